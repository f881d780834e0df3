//! The station dies, stands beside its standby, or has no room on its disk.

use super::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// The station dies, also twice, also together with a member, and is started again from its journal: in any phase, under loss.
    #[test]
    fn a_station_that_is_made_again_from_its_journal_leads_the_same_run(
        seed in 1u64..,
        at_ms in prop_oneof![0u64..60, 5u64..1500],
        gap_ms in prop_oneof![1u64..50, 1u64..4_000],
        again_ms in prop_oneof![1u64..40, 1u64..3_000],
        who in 0usize..4,
        what in prop_oneof![Just(None), what().prop_map(Some), interruption().prop_map(Some)],
        twice in any::<bool>(),
        bus in prop_oneof![Just(0u64), 0u64..150],
        rate in prop_oneof![Just(1.0), Just(f64::INFINITY)],
    ) {
        let mut net = net(seed, with_control(rate), Network { bus_loss: bus, ..network(10) });
        let at = net.now + at_ms * MS;
        let mut faults = vec![fault(at, CONDUCTOR, What::Kill), fault(at + again_ms * MS, CONDUCTOR, What::Start)];
        if twice {
            let at = at + again_ms * MS + gap_ms * MS;
            faults.extend([fault(at, CONDUCTOR, What::Kill), fault(at + again_ms * MS, CONDUCTOR, What::Start)]);
        }
        if let Some(what) = what {
            faults.extend([fault(at + gap_ms * MS, ALL[who], what), fault(at + (gap_ms + 9_000) * MS, ALL[who], What::Start)]);
        }
        net.run(at + 60_000 * MS, &faults);
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
        prop_assert_eq!(net.closed.len(), 1, "{:?} {:?}", net.reached, net.conductor().state());
        prop_assert!(!net.closed[0].failed, "{:?}", net.closed[0].reasons);
        if faults.iter().all(|fault| fault.who == CONDUCTOR) {
            prop_assert!(net.closed[0].reasons.is_empty(), "no member is blamed: {:?}", net.closed[0].reasons);
        }
        prop_assert!(net.seen.get("station made again").is_some_and(|n| *n == 1 + u64::from(twice)), "{:?}", net.seen);
        let mut whole = super::net(1, with_control(f64::INFINITY), network(0));
        whole.run(MINUTE, &[]);
        prop_assert_eq!(eaten(&net, 0), eaten(&whole, 0));
    }
}

/// All processes are lost, the station among them, and started again much later (`seeds run --continue`): also a run that ends by itself, and
/// would be closed at once where a member is lost, waits until they have found the station.
#[test]
fn a_run_whose_processes_are_all_gone_goes_on_from_its_journal() {
    for (batch, at_ms, apart_ms) in [(false, 900, 0), (true, 900, 0), (true, 40, 300)] {
        let mut config = with_control(2.0);
        config.batch = batch;
        let mut net = net(3, config, network(10));
        run_until_running(&mut net);
        let at = net.now + at_ms * MS;
        let all = [CONDUCTOR].iter().chain(&ALL);
        let mut faults: Vec<Fault> = all.clone().map(|who| fault(at, who, What::Kill)).collect();
        faults.extend(
            (0..)
                .zip(all)
                .map(|(n, who)| fault(at + (20_000 + n * apart_ms) * MS, who, What::Start)),
        );
        net.run_to_close(at + 2 * MINUTE, &faults);
        let closed = net.closed.first();
        let closed = closed.unwrap_or_else(|| panic!("{at_ms}: {:?}", net.conductor().state()));
        assert!(!closed.failed, "{at_ms}: {:?}", closed.reasons);
        assert_eq!(eaten(&net, 0), whole(), "{at_ms}");
        assert!(net.broken.is_empty(), "{at_ms}: {:?}", net.broken);
        assert_eq!(net.seen.get("station made again"), Some(&1));
        let back = closed.reasons.iter().filter(|r| r.contains("back after")).count();
        assert_eq!(back, ALL.len(), "{:?}", closed.reasons);
    }
}

/// Its journal is behind the run from then on: whoever is started next must not go on from it.
#[test]
fn a_station_whose_disk_is_full_goes_on_and_leaves_no_journal() {
    let full = |who: &str| fault(1_000 * MS, who, What::Full);
    let mut alone = net(3, with_control(1.0), network(10));
    alone.run_to_close(MINUTE, &[full(CONDUCTOR)]);
    assert_eq!(alone.seen.get("journal not writable"), Some(&1), "{:?}", alone.seen);
    assert_eq!(eaten(&alone, 0), whole());
    let mut killed = net(3, with_control(1.0), network(10));
    let [kill, start] = [(1_500, What::Kill), (1_600, What::Start)];
    let faults = [
        full(CONDUCTOR),
        fault(kill.0 * MS, CONDUCTOR, kill.1),
        fault(start.0 * MS, CONDUCTOR, start.1),
    ];
    killed.run_to_close(20_000 * MS, &faults);
    assert_eq!(killed.seen.get("station made again"), None, "{:?}", killed.seen);
}

/// Neither the station nor its standby needs the other's disk: who cannot write says so, and the run is the same.
#[test]
fn where_the_disk_of_the_station_or_of_its_standby_is_full_the_run_goes_on() {
    for (who, row) in [
        (CONDUCTOR, "standby of a station without a journal"),
        (STANDBY, "copy of the journal not writable"),
    ] {
        let mut net = net(4, with_control(0.25), network(10));
        let faults = [fault(1, STANDBY, What::Start), fault(7_000 * MS, who, What::Full)];
        net.run_to_close(MINUTE, &faults);
        assert_eq!(net.seen.get("standby is in"), Some(&1), "{:?}", net.seen);
        assert!(net.seen.contains_key(row), "{row}: {:?}", net.seen);
        assert_eq!(eaten(&net, 0), whole(), "{who}");
        assert!(net.broken.is_empty(), "{who}: {:?}", net.broken);
    }
}
