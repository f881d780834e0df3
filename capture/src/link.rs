//! From a frame as captured down to the UDP datagram in it.
//!
//! Sources: IEEE 802.3 and 802.1Q for Ethernet, the tcpdump group's link-layer header types for
//! the others, RFC 791 (IPv4), RFC 8200 (IPv6), RFC 768 (UDP). Checksums are not verified: captures
//! taken on the sending host have none yet where the network card computes them.

use crate::bytes::{Order, array, be16};
use crate::error::FrameFault;
use crate::fragments::{FragmentKey, Fragments};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

/// Link-layer header types that are read, by the number in the capture file.
pub(crate) mod link_type {
    pub(crate) const NULL: u16 = 0;
    pub(crate) const ETHERNET: u16 = 1;
    /// Raw IP has three numbers: two from operating systems of old, one assigned.
    pub(crate) const RAW: [u16; 3] = [12, 14, 101];
    pub(crate) const LOOP: u16 = 108;
    pub(crate) const LINUX_SLL: u16 = 113;
    pub(crate) const IPV4: u16 = 228;
    pub(crate) const IPV6: u16 = 229;
    pub(crate) const LINUX_SLL2: u16 = 276;
}

const ETHER_IPV4: u16 = 0x0800;
const ETHER_IPV6: u16 = 0x86dd;
const ETHER_VLAN: [u16; 3] = [0x8100, 0x88a8, 0x9100];
const UDP: u8 = 17;

/// What a frame turned out to hold.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Content {
    /// A datagram whose payload is `start..start + len` of the frame.
    Udp { from: SocketAddr, to: SocketAddr, start: usize, len: usize, missing: usize },
    /// A datagram put together from fragments.
    Whole { from: SocketAddr, to: SocketAddr, payload: Vec<u8>, first_frame: u64 },
    /// Something else than UDP, or a part of a datagram not yet whole.
    Other,
}

/// The part of a frame that the enclosing header announced: `have` octets there, `missing` cut off.
#[derive(Clone, Copy)]
struct Span {
    start: usize,
    end: usize,
    missing: usize,
}

/// Takes one frame apart. `cut` is the number of octets of it that the capture left out.
pub(crate) fn open_frame(
    link: u16,
    frame: &[u8],
    cut: usize,
    number: u64,
    fragments: &mut Fragments,
) -> Result<Content, FrameFault> {
    let Some(start) = network_layer(link, frame)? else { return Ok(Content::Other) };
    let span = Span { start, end: frame.len(), missing: cut };
    match frame.get(start).map(|b| b >> 4) {
        Some(4) => ipv4(frame, span, number, fragments),
        Some(6) => ipv6(frame, span, number, fragments),
        Some(version) => Err(FrameFault::Field { field: "IP version", value: version.into() }),
        None => Err(short("IP", 1, 0)),
    }
}

/// Offset of the IP header, or `None` for another protocol.
fn network_layer(link: u16, frame: &[u8]) -> Result<Option<usize>, FrameFault> {
    let need = |layer, needed| {
        if frame.len() < needed { Err(short(layer, needed, frame.len())) } else { Ok(()) }
    };
    match link {
        link_type::ETHERNET => {
            need("Ethernet", 14)?;
            ether_type(frame, 12)
        }
        link_type::LINUX_SLL => {
            need("Linux cooked", 16)?;
            ether_type(frame, 14)
        }
        link_type::LINUX_SLL2 => {
            need("Linux cooked v2", 20)?;
            Ok(match be16(frame, 0) {
                Some(ETHER_IPV4 | ETHER_IPV6) => Some(20),
                // The tag of a virtual network stands behind the header, then the inner type.
                Some(t) if ETHER_VLAN.contains(&t) => match be16(frame, 22) {
                    Some(ETHER_IPV4 | ETHER_IPV6) => Some(24),
                    _ => None,
                },
                _ => None,
            })
        }
        link_type::NULL | link_type::LOOP => {
            need("loopback", 4)?;
            // Family in the order of the capturing host: the small reading is the right one.
            let family =
                Order::Little.u32(frame, 0).into_iter().chain(Order::Big.u32(frame, 0)).min();
            Ok(matches!(family, Some(2 | 10 | 24 | 28 | 30)).then_some(4))
        }
        link_type::IPV4 | link_type::IPV6 => Ok(Some(0)),
        _ if link_type::RAW.contains(&link) => Ok(Some(0)),
        _ => Err(FrameFault::LinkType(link)),
    }
}

/// Walks tags of virtual networks from the type field at `at`.
fn ether_type(frame: &[u8], mut at: usize) -> Result<Option<usize>, FrameFault> {
    loop {
        match be16(frame, at) {
            Some(ETHER_IPV4 | ETHER_IPV6) => return Ok(Some(at + 2)),
            Some(t) if ETHER_VLAN.contains(&t) => at += 4,
            Some(_) => return Ok(None),
            None => return Err(short("VLAN", at + 2, frame.len())),
        }
    }
}

fn ipv4(
    frame: &[u8],
    span: Span,
    number: u64,
    fragments: &mut Fragments,
) -> Result<Content, FrameFault> {
    let packet = &frame[span.start..span.end];
    let header: [u8; 20] = array(packet, 0).ok_or(short("IPv4", 20, packet.len()))?;
    let header_len = usize::from(header[0] & 0x0f) * 4;
    if header_len < 20 {
        return Err(FrameFault::Field { field: "IPv4 header length", value: header_len as u32 });
    }
    if packet.len() < header_len {
        return Err(short("IPv4", header_len, packet.len()));
    }
    // Zero: the host left the length to the network card (segmentation offload).
    let total = match usize::from(u16::from_be_bytes([header[2], header[3]])) {
        0 => packet.len() + span.missing,
        n if n < header_len => {
            return Err(FrameFault::Field { field: "IPv4 total length", value: n as u32 });
        }
        n => n,
    };
    if header[9] != UDP {
        return Ok(Content::Other);
    }
    let src = IpAddr::V4(Ipv4Addr::new(header[12], header[13], header[14], header[15]));
    let dst = IpAddr::V4(Ipv4Addr::new(header[16], header[17], header[18], header[19]));
    let body = within(span, header_len, total);
    let flags = u16::from_be_bytes([header[6], header[7]]);
    let (more, offset) = (flags & 0x2000 != 0, usize::from(flags & 0x1fff) * 8);
    if more || offset != 0 {
        let id = u32::from(u16::from_be_bytes([header[4], header[5]]));
        let key = FragmentKey { src, dst, id };
        return fragment(frame, body, key, offset, more, number, fragments);
    }
    udp(frame, body, src, dst)
}

fn ipv6(
    frame: &[u8],
    span: Span,
    number: u64,
    fragments: &mut Fragments,
) -> Result<Content, FrameFault> {
    let packet = &frame[span.start..span.end];
    let header: [u8; 40] = array(packet, 0).ok_or(short("IPv6", 40, packet.len()))?;
    let payload_len = match usize::from(u16::from_be_bytes([header[4], header[5]])) {
        0 => packet.len() + span.missing - 40,
        n => n,
    };
    let (src, dst): ([u8; 16], [u8; 16]) = match (array(&header, 8), array(&header, 24)) {
        (Some(s), Some(d)) => (s, d),
        _ => return Err(short("IPv6", 40, packet.len())),
    };
    let (src, dst) = (IpAddr::V6(Ipv6Addr::from(src)), IpAddr::V6(Ipv6Addr::from(dst)));
    let mut body = within(span, 40, 40 + payload_len);
    let mut next = header[6];
    loop {
        let rest = &frame[body.start..body.end];
        match next {
            UDP => return udp(frame, body, src, dst),
            // Hop-by-hop, routing and destination options: next header, length in eight octets.
            0 | 43 | 60 => {
                let option: [u8; 2] = array(rest, 0).ok_or(short("IPv6 option", 8, rest.len()))?;
                let len = (usize::from(option[1]) + 1) * 8;
                if rest.len() < len {
                    return Err(short("IPv6 option", len, rest.len()));
                }
                next = option[0];
                body.start += len;
            }
            44 => {
                let head: [u8; 8] = array(rest, 0).ok_or(short("IPv6 fragment", 8, rest.len()))?;
                if head[0] != UDP {
                    return Ok(Content::Other);
                }
                let place = u16::from_be_bytes([head[2], head[3]]);
                let id = u32::from_be_bytes([head[4], head[5], head[6], head[7]]);
                body.start += 8;
                let (offset, more) = (usize::from(place & 0xfff8), place & 1 != 0);
                if offset == 0 && !more {
                    return udp(frame, body, src, dst);
                }
                let key = FragmentKey { src, dst, id };
                return fragment(frame, body, key, offset, more, number, fragments);
            }
            _ => return Ok(Content::Other),
        }
    }
}

/// The octets from `header_len` to `total` of the packet at `span`, as far as they were captured.
fn within(span: Span, header_len: usize, total: usize) -> Span {
    let have = span.end - span.start;
    let end = span.start + total.min(have);
    Span {
        start: span.start + header_len,
        end: end.max(span.start + header_len),
        missing: total.saturating_sub(have),
    }
}

fn fragment(
    frame: &[u8],
    body: Span,
    key: FragmentKey,
    offset: usize,
    more: bool,
    number: u64,
    fragments: &mut Fragments,
) -> Result<Content, FrameFault> {
    if body.missing > 0 {
        return Err(short(
            "IP fragment",
            body.end - body.start + body.missing,
            body.end - body.start,
        ));
    }
    let Some(whole) = fragments.add(key, offset, more, &frame[body.start..body.end], number)?
    else {
        return Ok(Content::Other);
    };
    let span = Span { start: 0, end: whole.octets.len(), missing: 0 };
    match udp(&whole.octets, span, key.src, key.dst)? {
        Content::Udp { from, to, start, len, .. } => Ok(Content::Whole {
            from,
            to,
            payload: whole.octets[start..start + len].to_vec(),
            first_frame: whole.first_frame,
        }),
        other => Ok(other),
    }
}

fn udp(frame: &[u8], body: Span, src: IpAddr, dst: IpAddr) -> Result<Content, FrameFault> {
    let datagram = &frame[body.start..body.end];
    let header: [u8; 8] = array(datagram, 0).ok_or(short("UDP", 8, datagram.len()))?;
    let announced = match usize::from(u16::from_be_bytes([header[4], header[5]])) {
        0 => datagram.len() + body.missing,
        n if n < 8 => return Err(FrameFault::Field { field: "UDP length", value: n as u32 }),
        n => n,
    };
    let have = datagram.len();
    let from = SocketAddr::new(src, u16::from_be_bytes([header[0], header[1]]));
    let to = SocketAddr::new(dst, u16::from_be_bytes([header[2], header[3]]));
    let (start, len) = (body.start + 8, announced.min(have) - 8);
    Ok(Content::Udp { from, to, start, len, missing: announced.saturating_sub(have) })
}

fn short(layer: &'static str, needed: usize, have: usize) -> FrameFault {
    FrameFault::Short { layer, needed, have }
}
