//! Links between sockets of this host.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use datalink::{Bundle, Link, LinkConfig, LinkError, Packing, Receiver, Sender};
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

fn free_port() -> u16 {
    datalink::free_port().unwrap()
}

fn config(to: &str) -> LinkConfig {
    LinkConfig { to: to.parse().unwrap(), ..LinkConfig::default() }
}

/// An IPv6 address of an interface other than the loopback.
fn ipv6_interface() -> Option<String> {
    let table = std::fs::read_to_string("/proc/self/net/if_inet6").ok()?;
    let line = table.lines().find(|l| !l.ends_with(" lo") && !l.starts_with("fe80"))?;
    let hex = line.get(..32)?;
    let words: Vec<&str> = (0..8).map(|i| &hex[4 * i..4 * i + 4]).collect();
    Some(words.join(":"))
}

/// What arrives until `n` datagrams came or half a second brings none.
fn take(receiver: &mut Receiver, n: usize) -> Vec<(SocketAddr, SocketAddr, Vec<u8>)> {
    let mut all = Vec::new();
    while all.len() < n {
        let got = receiver
            .receive(Some(Duration::from_millis(500)), |a| {
                assert!(a.utc_ns > 1_500_000_000_000_000_000, "stamp {}", a.utc_ns);
                all.push((a.from, a.to, a.payload.to_vec()));
            })
            .unwrap();
        if got.datagrams == 0 {
            break;
        }
    }
    all
}

#[test]
fn every_receiver_of_the_host_gets_broadcast_and_multicast() {
    for (name, host, interface) in [
        ("broadcast", "127.255.255.255", None),
        ("multicast", "239.77.1.2", Some("127.0.0.1".to_owned())),
        // The loopback of Linux has no IPv6 multicast; groups of this scope never leave the host.
        ("IPv6 multicast", "[ff01::77:1]", ipv6_interface()),
    ] {
        if name == "IPv6 multicast" && interface.is_none() {
            println!("no interface with IPv6 multicast here: not tested");
            continue;
        }
        let to = format!("{host}:{}", free_port());
        let config = LinkConfig { interface: interface.map(|i| i.parse().unwrap()), ..config(&to) };
        let (mut sender, mut one) = Link::open(&config).unwrap_or_else(|e| panic!("{name}: {e}"));
        let (_, mut two) = Link::open(&config).unwrap_or_else(|e| panic!("{name}: {e}"));
        let pdus: Vec<Vec<u8>> = (0..200u8).map(|i| vec![i; 12 + usize::from(i)]).collect();
        sender.send(&pdus[0]).unwrap();
        sender.send_all(pdus[1..].iter().map(Vec::as_slice)).unwrap();
        for receiver in [&mut one, &mut two] {
            let got = take(receiver, 200);
            assert_eq!(got.len(), 200, "{name}");
            for (i, (from, to, payload)) in got.iter().enumerate() {
                assert_eq!(payload, &pdus[i], "{name}");
                assert_eq!(from.port(), sender.address().unwrap().port(), "{name}");
                assert_eq!(to.ip(), config.to.first().ip(), "{name}");
            }
            assert_eq!(receiver.dropped(), 0);
        }
        assert_eq!(sender.sent().datagrams, 200);
    }
}

#[test]
fn only_joined_groups_are_delivered() {
    let port = free_port();
    let on_loopback =
        |to: String| LinkConfig { interface: Some("127.0.0.1".parse().unwrap()), ..config(&to) };
    // Two groups in one socket: bound to no address, yet deaf to the third.
    let two = LinkConfig {
        groups: vec!["239.77.2.2".parse().unwrap()],
        ..on_loopback(format!("239.77.2.1:{port}"))
    };
    let mut receiver = Receiver::open(&two).unwrap();
    let mut other = Receiver::open(&on_loopback(format!("239.77.2.3:{port}"))).unwrap();
    for (group, content) in [("239.77.2.3", b"3"), ("239.77.2.1", b"1"), ("239.77.2.2", b"2")] {
        let mut sender = Sender::open(&on_loopback(format!("{group}:{port}"))).unwrap();
        sender.send(content).unwrap();
    }
    let got: Vec<_> = take(&mut receiver, 3)
        .into_iter()
        .map(|(_, to, payload)| (to.ip().to_string(), payload))
        .collect();
    assert_eq!(
        got,
        [("239.77.2.1".to_owned(), b"1".to_vec()), ("239.77.2.2".to_owned(), b"2".to_vec())]
    );
    let got = take(&mut other, 2);
    assert_eq!(got.len(), 1);
    assert_eq!(got[0].2, b"3");
}

#[test]
fn a_list_of_hosts_reaches_each_of_them() {
    let (a, b) = (free_port(), free_port());
    let list = format!("127.0.0.1:{a},127.0.0.1:{b}");
    let (mut sender, mut one) = Link::open(&config(&list)).unwrap();
    let listen = Some(format!("127.0.0.1:{b}").parse().unwrap());
    let mut two = Receiver::open(&LinkConfig { listen, ..config(&list) }).unwrap();
    sender.send_all([&b"hello"[..], b"world"]).unwrap();
    assert_eq!(take(&mut one, 2).len(), 2);
    assert_eq!(take(&mut two, 2).len(), 2);
    // A host where nobody listens does not stop the others.
    drop(two);
    for _ in 0..3 {
        sender.send(b"again").unwrap();
    }
    assert_eq!(take(&mut one, 3).len(), 3);
}

#[test]
fn processes_of_one_host_share_a_list_that_has_a_port_for_each() {
    let (one, two) = (free_port(), free_port());
    let config = config(&format!("127.0.0.1:{one},127.0.0.1:{two}"));
    let (mut sender, mut first) = Link::open(&config).unwrap();
    let mut second = Receiver::open(&config).unwrap();
    sender.send(&[7; 40]).unwrap();
    for receiver in [&mut first, &mut second] {
        assert_eq!(take(receiver, 1).len(), 1);
    }
    let error = Receiver::open(&config).unwrap_err().to_string();
    assert!(error.contains("a port for each"), "{error}");
}

#[test]
fn bundles_and_segments_carry_the_same_pdus() {
    let pdus: Vec<Vec<u8>> =
        (0..1000usize).map(|i| vec![i as u8; if i % 50 == 7 { 200 } else { 144 }]).collect();
    let bundle = Some(Bundle { most_wait: Duration::from_secs(100), ..Bundle::default() });
    for (name, packing, datagrams) in [
        ("one each", Packing::default(), 1000),
        ("bundles", Packing { bundle, offload: false }, 115),
        ("segments", Packing { bundle: None, offload: true }, 1000),
        ("segments of bundles", Packing { bundle, offload: true }, 115),
    ] {
        let to = format!("127.255.255.255:{}", free_port());
        let (mut sender, mut receiver) =
            Link::open(&LinkConfig { packing, ..config(&to) }).unwrap();
        sender.send_all(pdus.iter().map(Vec::as_slice)).unwrap();
        let got = take(&mut receiver, sender.sent().datagrams as usize);
        let octets: Vec<u8> = got.iter().flat_map(|(_, _, p)| p.clone()).collect();
        assert_eq!(octets, pdus.concat(), "{name}");
        let sent = sender.sent();
        assert_eq!((sent.pdus, sent.datagrams), (1000, got.len() as u64), "{name}");
        assert!(got.len().abs_diff(datagrams) <= 5, "{name}: {} datagrams", got.len());
        assert!(got.iter().all(|(_, _, p)| p.len() <= 1400), "{name}");
        assert_eq!(sender.warnings(), [], "{name}");
    }
}

#[test]
fn a_bundle_waits_until_it_is_due_and_no_longer() {
    let to = format!("127.255.255.255:{}", free_port());
    let bundle = Bundle { most_wait: Duration::from_secs(100), ..Bundle::default() };
    let packing = Packing { bundle: Some(bundle), offload: false };
    let (mut sender, mut receiver) = Link::open(&LinkConfig { packing, ..config(&to) }).unwrap();
    sender.send(&[1; 144]).unwrap();
    assert!(sender.deadline().is_some());
    sender.flush_due().unwrap();
    assert_eq!(receiver.receive(Some(Duration::ZERO), |_| ()).unwrap().datagrams, 0);
    sender.flush().unwrap();
    assert_eq!(sender.deadline(), None);
    assert_eq!(take(&mut receiver, 1).len(), 1);
    let bundle = Bundle { most_wait: Duration::ZERO, ..Bundle::default() };
    let packing = Packing { bundle: Some(bundle), offload: false };
    let mut sender = Sender::open(&LinkConfig { packing, ..config(&to) }).unwrap();
    sender.send(&[1; 144]).unwrap();
    sender.flush_due().unwrap();
    assert_eq!(take(&mut receiver, 1).len(), 1, "due at once");
}

#[test]
fn a_wait_ends_when_woken() {
    let to = format!("127.255.255.255:{}", free_port());
    let mut receiver = Receiver::open(&config(&to)).unwrap();
    let waker = receiver.waker();
    let thread = std::thread::spawn(move || waker.wake());
    let got = receiver.receive(None, |_| ()).unwrap();
    assert!(got.woken && got.datagrams == 0);
    thread.join().unwrap();
    let got = receiver.receive(Some(Duration::from_millis(1)), |_| ()).unwrap();
    assert!(!got.woken && got.datagrams == 0);
}

#[test]
fn what_the_system_drops_is_counted() {
    let to = format!("127.255.255.255:{}", free_port());
    let small = LinkConfig { receive_buffer: 8192, ..config(&to) };
    let (mut sender, mut receiver) = Link::open(&small).unwrap();
    sender.send_all((0..500).map(|_| &[0u8; 1000][..])).unwrap();
    assert!(receiver.dropped_now() > 0, "known before anything is received");
    let got = take(&mut receiver, 500).len();
    sender.send(&[1]).unwrap();
    assert_eq!(take(&mut receiver, 1).len(), 1);
    assert_eq!(got as u64 + receiver.dropped(), 500);
    assert_eq!(receiver.dropped(), receiver.dropped_now());
}

#[test]
fn the_largest_datagram_passes_and_a_larger_pdu_is_refused() {
    let to = format!("127.0.0.1:{}", free_port());
    let (mut sender, mut receiver) = Link::open(&config(&to)).unwrap();
    sender.send(&vec![9; 65_507]).unwrap();
    let got = take(&mut receiver, 1);
    assert_eq!(got[0].2.len(), 65_507);
    assert!(matches!(sender.send(&vec![9; 65_508]), Err(LinkError::TooLong(65_508))));
    sender.send(&[]).unwrap();
    assert_eq!(take(&mut receiver, 1)[0].2.len(), 0, "an empty datagram is one too");
}

#[test]
fn errors_say_what_where_and_what_to_do() {
    let port = free_port();
    let host = config(&format!("127.0.0.1:{port}"));
    let _first = Receiver::open(&host).unwrap();
    let in_use = Receiver::open(&host).unwrap_err().to_string();
    let foreign = UdpSocket::bind("0.0.0.0:0").unwrap();
    let port2 = foreign.local_addr().unwrap().port();
    let shared = Receiver::open(&LinkConfig {
        listen: Some(format!("0.0.0.0:{port2}").parse().unwrap()),
        ..config(&format!("127.255.255.255:{port2}"))
    })
    .unwrap_err()
    .to_string();
    let with = |to: &str, interface: &str| {
        Link::open(&LinkConfig { interface: Some(interface.parse().unwrap()), ..config(to) })
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    let groups = (0..200u8).map(|i| [239, 77, 3, i].into()).collect();
    let many = Receiver::open(&LinkConfig {
        groups,
        interface: Some("127.0.0.1".parse().unwrap()),
        ..config(&format!("239.77.1.1:{}", free_port()))
    })
    .unwrap_err()
    .to_string();
    for (error, parts) in [
        (in_use, ["in use", "choose another port"]),
        (shared, ["in use", "does not share"]),
        (with("239.1.2.3:3000", "192.0.2.77"), ["no interface", "127.0.0.1"]),
        (with("239.1.2.3:3000", "::1"), ["different IP versions", "::1"]),
        (many, ["cannot join", "igmp_max_memberships"]),
    ] {
        for part in parts {
            assert!(error.contains(part), "`{part}` missing in: {error}");
        }
        assert!(!error.contains('\n'), "one line: {error}");
    }
}

#[test]
fn a_buffer_that_is_too_small_is_told() {
    let asked = 2 << 30;
    let to = format!("127.255.255.255:{}", free_port());
    let receiver = Receiver::open(&LinkConfig { receive_buffer: asked, ..config(&to) }).unwrap();
    let (_, obtained) = receiver.buffer_octets();
    assert!(obtained < asked);
    let text = receiver.warnings()[0].to_string();
    assert!(text.contains("rmem_max") && text.contains(&obtained.to_string()), "{text}");
}
