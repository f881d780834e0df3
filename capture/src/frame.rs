//! Frames around payloads, as a network card would have seen them.

use std::net::{IpAddr, Ipv6Addr, SocketAddr};

/// Largest payload that fits one UDP datagram over IPv4 and IPv6 alike (RFC 768, RFC 791).
pub const MOST_PAYLOAD: usize = 65_507;

/// Appends Ethernet, IPv4 or IPv6, and UDP headers and the payload to `out`, with right checksums.
/// An IPv4 address beside an IPv6 one is written in its mapped form.
///
/// `payload` must not be longer than [`MOST_PAYLOAD`].
pub(crate) fn build(out: &mut Vec<u8>, from: SocketAddr, to: SocketAddr, payload: &[u8]) {
    debug_assert!(payload.len() <= MOST_PAYLOAD);
    let (src, dst) = match (from.ip(), to.ip()) {
        (IpAddr::V4(a), IpAddr::V6(b)) => (IpAddr::V6(a.to_ipv6_mapped()), IpAddr::V6(b)),
        (IpAddr::V6(a), IpAddr::V4(b)) => (IpAddr::V6(a), IpAddr::V6(b.to_ipv6_mapped())),
        same => same,
    };
    out.extend_from_slice(&hardware(dst));
    out.extend_from_slice(&hardware(src));
    let udp_len = (payload.len() + 8) as u16;
    let pseudo_sum = match (src, dst) {
        (IpAddr::V4(src), IpAddr::V4(dst)) => {
            out.extend_from_slice(&[0x08, 0x00]);
            let start = out.len();
            // No options, no fragments, 64 hops, UDP.
            out.extend_from_slice(&[0x45, 0]);
            out.extend_from_slice(&(udp_len + 20).to_be_bytes());
            out.extend_from_slice(&[0, 0, 0x40, 0, 64, 17, 0, 0]);
            out.extend_from_slice(&src.octets());
            out.extend_from_slice(&dst.octets());
            let check = fold(sum(0, &out[start..]));
            out[start + 10..start + 12].copy_from_slice(&check.to_be_bytes());
            sum(sum(0, &src.octets()), &dst.octets())
        }
        (src, dst) => {
            let (src, dst) = (as_v6(src), as_v6(dst));
            out.extend_from_slice(&[0x86, 0xdd, 0x60, 0, 0, 0]);
            out.extend_from_slice(&udp_len.to_be_bytes());
            out.extend_from_slice(&[17, 64]);
            out.extend_from_slice(&src.octets());
            out.extend_from_slice(&dst.octets());
            sum(sum(0, &src.octets()), &dst.octets())
        }
    };
    let start = out.len();
    out.extend_from_slice(&from.port().to_be_bytes());
    out.extend_from_slice(&to.port().to_be_bytes());
    out.extend_from_slice(&udp_len.to_be_bytes());
    out.extend_from_slice(&[0, 0]);
    out.extend_from_slice(payload);
    let total = sum(pseudo_sum + u64::from(udp_len) + 17, &out[start..]);
    // A sum of zero is sent as all ones: zero means "no checksum" (RFC 768).
    let check = match fold(total) {
        0 => 0xffff,
        check => check,
    };
    out[start + 6..start + 8].copy_from_slice(&check.to_be_bytes());
}

fn as_v6(ip: IpAddr) -> Ipv6Addr {
    match ip {
        IpAddr::V4(v4) => v4.to_ipv6_mapped(),
        IpAddr::V6(v6) => v6,
    }
}

/// A hardware address for an IP address: the group's (RFC 1112, RFC 2464), the broadcast one, or a
/// locally administered one made from the host's.
fn hardware(ip: IpAddr) -> [u8; 6] {
    match ip {
        IpAddr::V4(v4) => {
            let [a, b, c, d] = v4.octets();
            if v4.is_multicast() {
                [0x01, 0x00, 0x5e, b & 0x7f, c, d]
            } else if d == 255 {
                [0xff; 6]
            } else {
                [0x02, 0x00, a, b, c, d]
            }
        }
        IpAddr::V6(v6) => {
            let o = v6.octets();
            if v6.is_multicast() {
                [0x33, 0x33, o[12], o[13], o[14], o[15]]
            } else {
                [0x02, 0x01, o[12], o[13], o[14], o[15]]
            }
        }
    }
}

/// Adds `octets` as 16-bit words (RFC 1071), an odd last one padded with zero.
fn sum(mut total: u64, octets: &[u8]) -> u64 {
    let mut words = octets.chunks_exact(4);
    for word in &mut words {
        total += u64::from(u32::from_be_bytes([word[0], word[1], word[2], word[3]]));
    }
    let mut last = [0; 4];
    last[..words.remainder().len()].copy_from_slice(words.remainder());
    total + u64::from(u32::from_be_bytes(last))
}

fn fold(mut total: u64) -> u16 {
    while total > 0xffff {
        total = (total & 0xffff) + (total >> 16);
    }
    !(total as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_from_the_literature_has_its_checksum() {
        // The example header of RFC 1071 practice: 4500 0073 0000 4000 4011 b861 c0a8 0001 c0a8 00c7.
        let header = [
            0x45, 0, 0, 0x73, 0, 0, 0x40, 0, 0x40, 0x11, 0, 0, 0xc0, 0xa8, 0, 1, 0xc0, 0xa8, 0,
            0xc7,
        ];
        assert_eq!(fold(sum(0, &header)), 0xb861);
    }

    #[test]
    fn a_sum_over_what_was_written_is_all_ones() {
        for (from, to) in [
            ("10.1.2.3:4000", "239.1.2.3:3000"),
            ("127.0.0.1:4000", "127.255.255.255:3000"),
            ("[fe80::1]:4000", "[ff02::1234]:3000"),
            ("10.1.2.3:4000", "[::1]:3000"),
        ] {
            for payload in [&b""[..], b"a", b"abcd", &[0xff; 777]] {
                let mut out = Vec::new();
                build(&mut out, from.parse().unwrap(), to.parse().unwrap(), payload);
                let v4 = out[12] == 0x08;
                let (ip, udp) = if v4 { (14, 34) } else { (14, 54) };
                if v4 {
                    assert_eq!(fold(sum(0, &out[ip..udp])), 0, "{from} IPv4 header");
                }
                let addresses = if v4 { &out[26..34] } else { &out[22..54] };
                let total = sum(sum(17, addresses), &out[udp + 4..udp + 6]);
                // The two octets of the length stand at an even place: padding does not move them.
                let length = u64::from(u16::from_be_bytes([out[udp + 4], out[udp + 5]]));
                let total = total - (length << 16) + length;
                assert_eq!(fold(sum(total, &out[udp..])), 0, "{from} {} octets", payload.len());
            }
        }
    }
}
