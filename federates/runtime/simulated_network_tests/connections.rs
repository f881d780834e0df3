//! Two members that have no connection to each other, while both have theirs to the station.

use super::*;

/// Two members that have heard each other lose their connection for good and keep that to the station, as a process does that
/// stood still while another joined: before the run is configured, or in it.
#[test]
fn two_that_lose_their_connection_for_good_take_part_all_the_same() {
    for seed in 1..=12 {
        for in_run_ms in [None, Some(30), Some(300)] {
            let mut net = net(seed, with_control(8.0), network(0));
            run_until(&mut net, |net| net.conductor().phase() != Phase::Init);
            if let Some(ms) = in_run_ms {
                run_until_running(&mut net);
                let to = net.now + ms * MS;
                net.run(to, &[]);
            }
            let apart = [("traffic-generator", "smdfm"), ("smdfm", "traffic-generator")]
                .map(|(from, to)| fault(net.now, from, What::Burst(to.to_owned(), 60 * MINUTE)));
            let to = net.now + 20_000 * MS;
            net.run(to, &apart);
            let state = net.conductor().state();
            assert_eq!(net.closed.len(), 1, "seed {seed}, {in_run_ms:?}: {state:?}");
            let froze = net.reached.iter().any(|r| r.0 == Phase::Frozen);
            assert!(!froze, "seed {seed}, {in_run_ms:?}: {:?}", net.reached);
            assert_eq!(eaten(&net, 0), whole(), "seed {seed}, {in_run_ms:?}");
            assert!(net.broken.is_empty(), "{:?}", net.broken);
        }
    }
}

/// Cuts one pair for good.
fn apart(net: &mut Simulation, one: &str, two: &str) {
    let faults = [(one, two), (two, one)]
        .map(|(from, to)| fault(net.now, from, What::Burst(to.to_owned(), 60 * MINUTE)));
    net.run(net.now + 1, &faults);
}

/// How long a run takes in which a pair is cut off, ns of wall time, and what it eats.
fn takes(mut net: Simulation, cut: Option<(&str, &str)>) -> (u64, Vec<(String, String, u64)>) {
    run_until_running(&mut net);
    let begun = net.now;
    if let Some((one, two)) = cut {
        apart(&mut net, one, two);
    }
    net.run_to_close(begun + 60 * MINUTE, &[]);
    assert_eq!(net.closed.len(), 1, "{cut:?}: {:?}", net.conductor().state());
    assert!(net.broken.is_empty(), "{cut:?}: {:?}", net.broken);
    (net.now - begun, eaten(&net, 0))
}

/// As fast as possible, five times as long as others: the producer was asked twice for every batch of granted frames before the station was.
#[test]
fn a_pair_without_a_connection_does_not_hold_up_a_fast_run() {
    for seed in 20..28 {
        let fast = || {
            let mut config = with_control(f64::INFINITY);
            config.last_frame = 5 * LAST;
            net(seed, config, network(0))
        };
        let (whole, ate) = takes(fast(), None);
        for pair in [("traffic-generator", "smdfm"), ("control", "external-world")] {
            let (took, eaten) = takes(fast(), Some(pair));
            assert!(took < 5 * whole, "seed {seed}, {pair:?}: {took} for {whole} ns");
            assert_eq!(eaten, ate, "seed {seed}, {pair:?}");
        }
    }
}

/// The only consumer has no connection to a producer: nobody else holds what that made.
#[test]
fn what_no_other_consumer_holds_comes_by_the_station() {
    for (seed, udp, bus) in [(1, 0, 0), (2, 300, 0), (3, 300, 150), (4, 1_000, 50)] {
        for rate in [8.0, f64::INFINITY] {
            let network = Network { bus_loss: bus, ..network(udp / 10) };
            let net = net(seed, config(rate, false), network);
            let (_, eaten) = takes(net, Some(("traffic-generator", "smdfm")));
            assert_eq!(eaten, super::eaten(&calm(), 0), "seed {seed}, rate {rate}");
        }
    }
}

/// What the members say of their connections.
fn unheard(net: &Simulation) -> Vec<(String, String)> {
    let says = |name: &&str| {
        let member = net.member(name)?;
        Some(member.unheard().map(|text| ((*name).to_owned(), text.to_owned())).collect::<Vec<_>>())
    };
    ALL.iter().filter_map(says).flatten().collect()
}

#[test]
fn who_is_not_heard_directly_is_said_until_he_is_heard_again() {
    let mut net = net(5, with_control(0.25), network(10));
    run_until_running(&mut net);
    let cut = ["traffic-generator", "smdfm"];
    let faults = [(cut[0], cut[1]), (cut[1], cut[0])]
        .map(|(from, to)| fault(net.now, from, What::Burst(to.to_owned(), 5_000 * MS)));
    let to = net.now + 4_000 * MS;
    net.run(to, &faults);
    let said = unheard(&net);
    assert!(
        said.len() == 1 && said[0].0 == "smdfm" && said[0].1.contains("traffic-generator"),
        "{said:?}"
    );
    let to = net.now + 2_000 * MS;
    net.run(to, &[]);
    assert_eq!(unheard(&net), [], "the connection is back");
}

/// Loss, a pause and a death are other faults, with words of their own.
#[test]
fn who_is_lost_or_lost_for_a_while_is_no_matter_of_connections() {
    for (seed, bus, what) in [
        (1, 300, None),
        (2, 0, Some(What::Kill)),
        (3, 100, Some(What::Pause(1_500 * MS))),
        (4, 0, Some(What::Cut(1_500 * MS))),
    ] {
        let mut net = net(seed, with_control(0.25), Network { bus_loss: bus, ..network(10) });
        run_until_running(&mut net);
        let at = net.now + 1_000 * MS;
        let what: Vec<Fault> =
            what.map(|what| fault(at, "traffic-generator", what)).into_iter().collect();
        for n in 0..60 {
            let to = net.now + 100 * MS;
            net.run(to, if n == 0 { &what } else { &[] });
            assert_eq!(unheard(&net), [], "seed {seed}, {n}");
        }
    }
}
