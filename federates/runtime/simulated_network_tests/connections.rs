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
