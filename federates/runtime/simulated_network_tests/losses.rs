//! Members are lost: who is named, what becomes of the run, and how long they are waited for.

use super::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn a_lost_member_freezes_all_at_one_frame_and_says_so(
        seed in 1u64.., at in 100u64..1200, consumer in any::<bool>(),
    ) {
        let name = if consumer { "smdfm" } else { "traffic-generator" };
        let mut net = super::net(seed, config(1.0, false), network(10));
        net.run(at * MS + 20_000 * MS, &[fault(at * MS, name, What::Kill)]);
        prop_assert_eq!(net.reached.last().map(|r| r.0), Some(Phase::Frozen), "{:?}", net.reached);
        let state = net.conductor().state();
        prop_assert!(state.reasons[0].contains(name), "{:?}", state.reasons);
        let mut batch = super::net(seed, config(f64::INFINITY, true), network(10));
        batch.run(MINUTE, &[fault(3 * MS + at * 10_000, name, What::Kill)]);
        prop_assert_eq!(batch.exit, Some(1));
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
    }

    #[test]
    fn any_pair_lost_together_is_named_and_nobody_else(
        seed in 1u64..,
        at_ms in 5u64..1500,
        gap_us in prop_oneof![0u64..3_000, 0u64..600_000],
        first in 0usize..4,
        second in 1usize..4,
        what in [what(), what()],
        bus in prop_oneof![Just(0u64), 0u64..150],
    ) {
        let pair = [ALL[first], ALL[(first + second) % 4]];
        let mut net = net(seed, with_control(1.0), Network { bus_loss: bus, ..network(10) });
        run_until_running(&mut net);
        let at = net.now + at_ms * MS;
        let [one, two] = what;
        let faults = [fault(at, pair[0], one), fault(at + gap_us * 1000, pair[1], two)];
        net.run(at + 10_000 * MS, &faults);
        prop_assert_eq!(net.conductor().phase(), Phase::Frozen, "{:?}", net.reached);
        let reasons = net.conductor().state().reasons;
        prop_assert_eq!(reasons.len(), 2, "{:?}", reasons);
        for name in pair {
            prop_assert!(reasons.iter().any(|r| r.starts_with(name)), "{:?}", reasons);
        }
        for name in ["control", "smdfm"] {
            if let Some(member) = net.member(name) {
                prop_assert_eq!(member.executed(), net.conductor().stand(), "{}", name);
            }
        }
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
        // New processes of both: the run goes on, and nothing is left out.
        let starts = pair.map(|name| fault(net.now, name, What::Start));
        let to = net.now + 20_000 * MS;
        net.run(to, &starts);
        prop_assert_eq!(net.closed.len(), 1, "{:?} {:?}", net.reached, net.conductor().state());
        prop_assert!(!net.closed[0].failed);
        prop_assert!(net.closed[0].reasons.iter().all(|r| r.contains("back after")), "{:?}", net.closed[0].reasons);
        let mut whole = super::net(1, with_control(f64::INFINITY), network(0));
        whole.run(MINUTE, &[]);
        prop_assert_eq!(eaten(&net, 0), eaten(&whole, 0));
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
    }

    #[test]
    fn a_run_goes_on_without_its_visitors_and_says_since_when(seed in 1u64.., at_ms in 5u64..1500) {
        let with_visitors = |seed| {
            let mut config = config(2.0, true);
            config.optional = vec!["visitors".into()];
            net(seed, config, network(10))
        };
        let mut whole = with_visitors(seed);
        whole.run(MINUTE, &[]);
        prop_assert_eq!((whole.exit, whole.value(0, "visits")), (Some(0), (2 * LAST - 3) as f64));
        let mut net = with_visitors(seed);
        run_until_running(&mut net);
        let at = net.now + at_ms * MS;
        net.run(MINUTE, &[fault(at, "visitors", What::Kill)]);
        prop_assert_eq!(net.exit, Some(0));
        prop_assert!(net.reached.iter().all(|r| r.0 != Phase::Frozen), "{:?}", net.reached);
        let said = &net.closed[0].reasons;
        prop_assert!(said.len() == 1 && said[0].starts_with("degraded since frame "), "{:?}", said);
        let visits = net.value(0, "visits");
        prop_assert!(visits < (2 * LAST - 3) as f64 && visits as u64 + 24 > at_ms / 25 * 2, "{}", visits);
        let ate = |net: &Simulation| eaten(net, 0).into_iter().find(|(_, k, _)| k == "eaten");
        prop_assert_eq!(ate(&net), ate(&calm()));
    }
}

/// What the toy producer makes up to and in frame `last`.
fn made_up_to(last: Frame) -> f64 {
    1.0 + (0..=last).map(|frame| frame % 3).sum::<u64>() as f64
}

#[test]
fn a_degraded_run_goes_on_and_says_since_which_frame() {
    for (at_ms, name) in [(400, "traffic-generator"), (900, "external-world")] {
        let mut config = config(2.0, true);
        let other = if at_ms == 400 { "external-world" } else { "traffic-generator" };
        let policies = format!("{name}=degrade,{other}=abort");
        config.losses.on_loss = on_loss_flag(&policies).expect("policies");
        let mut net = net(3, config, network(10));
        run_until_running(&mut net);
        let at = net.now + at_ms * MS;
        net.run(MINUTE, &[fault(at, name, What::Kill)]);
        assert_eq!(net.exit, Some(0));
        assert!(net.reached.iter().all(|r| r.0 != Phase::Frozen), "{:?}", net.reached);
        let said = &net.closed[0].reasons;
        let since = said[0].strip_prefix("degraded since frame ").expect("it says so");
        let (since, why) = since.split_once(": ").expect("a reason");
        let since: Frame = since.parse().expect("a frame");
        assert!(said.len() == 1 && why.starts_with(name), "{said:?}");
        let eaten = made_up_to(LAST) + made_up_to(since - 1);
        assert_eq!(net.value(0, "eaten"), eaten, "{name}: what was made before frame {since}");
    }
}

/// Time stands for one that is lost, until somebody says that the run goes on without it: from then on it is as under `degrade`.
#[test]
fn a_run_that_stands_for_one_that_is_lost_goes_on_without_it_by_command() {
    let without =
        |at, name: &str| fault(at, "", What::Command(Command::Without { name: name.into() }));
    for (name, batch) in
        [("traffic-generator", false), ("external-world", false), ("external-world", true)]
    {
        let mut config = config(2.0, batch);
        config.losses.return_ms = Some(ReturnWithin::Ms(60_000));
        let mut net = net(3, config, network(10));
        run_until_running(&mut net);
        let at = net.now + 400 * MS;
        let faults = [
            without(at - MS, name),
            fault(at, name, What::Kill),
            without(at + 4_000 * MS, "smdfm"),
            without(at + 5_000 * MS, name),
            without(at + 5_500 * MS, name),
            // Too late to be taken back.
            fault(at + 5_600 * MS, name, What::Start),
        ];
        net.run_to_close(at + 4_900 * MS, &faults[..3]);
        assert_eq!(net.conductor().phase(), Phase::Frozen, "{name}");
        net.run_to_close(at + MINUTE, &faults[3..]);
        let said: Vec<_> = net.answers.iter().map(|(ok, text)| (*ok, &text[..])).collect();
        let closed = net.closed.first().unwrap_or_else(|| panic!("{:?}", net.conductor().state()));
        let reason = closed.reasons.iter().find(|r| r.starts_with("degraded")).expect("it says so");
        let since = reason.strip_prefix("degraded since frame ").expect("since when");
        let (since, why) = since.split_once(": ").expect("a reason");
        assert!(why.starts_with(name) && why.ends_with("goes on without it by command"), "{why}");
        let begins = format!("goes on without {name} from frame {since}");
        assert_eq!((said.len(), said[2].0), (4, true), "{said:?}");
        assert!(said[0].1.contains("nobody is lost") && said[2].1.starts_with(&begins), "{said:?}");
        assert!(said[1].1.contains(&format!("'smdfm' is not lost; lost: {name}")), "{said:?}");
        assert!(!said[0].0 && !said[1].0 && !said[3].0, "{said:?}");
        let since: Frame = since.parse().expect("a frame");
        assert!(!closed.failed && closed.frame == LAST, "{:?}", closed.reasons);
        assert_eq!(net.value(0, "eaten"), made_up_to(LAST) + made_up_to(since - 1), "{name}");
        assert!(net.broken.is_empty(), "{:?}", net.broken);
        assert_eq!(net.seen.get("left out by the run"), Some(&1), "who came too late");
    }
}

#[test]
fn an_aborted_run_is_closed_where_it_stands() {
    for (batch, policies) in [(true, "abort"), (false, "degrade,smdfm=abort")] {
        let mut config = config(2.0, batch);
        config.losses.on_loss = on_loss_flag(policies).expect("policies");
        let mut net = net(3, config, network(10));
        run_until_running(&mut net);
        let at = net.now + 500 * MS;
        net.run(at + 2_000 * MS, &[fault(at, "smdfm", What::Kill)]);
        assert_eq!((net.closed.len(), net.conductor().phase()), (1, Phase::Stopped));
        assert!(net.closed[0].failed && net.closed[0].frame < LAST);
        assert_eq!((net.exit, net.conductor().exit_code()), (batch.then_some(1), 1));
    }
}

#[test]
fn how_long_the_lost_are_waited_for_is_what_was_said() {
    for (batch, within, closed_after_ms) in [
        (true, None, 0),
        (true, Some(ReturnWithin::Ms(4_000)), 4_000),
        (true, Some(ReturnWithin::NoEnd), 20_000),
        (false, None, 20_000),
        (false, Some(ReturnWithin::Ms(4_000)), 4_000),
    ] {
        let mut config = config(2.0, batch);
        config.losses.return_ms = within;
        let mut net = net(3, config, network(10));
        run_until_running(&mut net);
        let at = net.now + 500 * MS;
        let until = at + 20_000 * MS;
        net.run_to_close(until, &[fault(at, "traffic-generator", What::Kill)]);
        let after_ms = (net.now - at) / MS;
        let late = after_ms.saturating_sub(closed_after_ms);
        assert!(after_ms >= closed_after_ms && late < 700, "{batch} {within:?}: {after_ms} ms");
    }
}

#[test]
fn each_member_has_its_own_clocks() {
    let mut config = config(1.0, false);
    config.losses.stall_ms = stall_flag("600,smdfm=5000").expect("clocks");
    config.losses.step_ms = step_flag("smdfm=3000").expect("clocks");
    for (name, what, named_ms, words) in [
        ("smdfm", What::Vanish, 5_000, "nothing was heard of it for 5 s"),
        ("external-world", What::Vanish, 600, "nothing was heard of it for 0.6 s"),
        ("smdfm", What::Slow(MINUTE), 3_000, "hangs for 3 s"),
        ("traffic-generator", What::Slow(5_000 * MS), 5_000, ""),
    ] {
        let mut net = net(3, config.clone(), network(0));
        run_until_running(&mut net);
        let at = net.now + 500 * MS;
        net.run(at + 1, &[fault(at, name, what)]);
        let lost = |net: &Simulation| net.conductor().state().reasons.join("; ");
        while !lost(&net).contains("is lost") && net.now < at + (named_ms + 1_000) * MS {
            let to = net.now + 10 * MS;
            net.run(to, &[]);
        }
        let after_ms = (net.now - at) / MS;
        assert!(lost(&net).contains(words), "{name}: {}", lost(&net));
        let (least, most) = (named_ms.saturating_sub(200), named_ms + 400);
        let named = (least..most).contains(&after_ms);
        assert_eq!(named, !words.is_empty(), "{name} after {after_ms} ms: {}", lost(&net));
    }
}

#[test]
fn a_producer_lost_before_its_first_frame_holds_nobody_up() {
    let lost = "traffic-generator";
    let mut net = net(13_406_712_465_736_579_652, config(f64::INFINITY, true), network(10));
    net.run(MINUTE, &[fault(7_300_000, lost, What::Kill)]);
    assert_eq!(net.exit, Some(1));
    let reasons = &net.conductor().state().reasons;
    assert!(reasons.len() == 1 && reasons[0].contains(lost), "{reasons:?}");
}

#[test]
fn a_stopped_run_does_not_wait_for_the_reports_of_the_dead() {
    let mut net = net(3, config(1.0, false), network(0));
    run_until_running(&mut net);
    let dead = ["external-world", "smdfm", "traffic-generator"];
    let at = net.now;
    let mut faults = dead.map(|name| fault(at, name, What::Cut(MINUTE))).to_vec();
    faults.push(fault(at, "", What::Command(Command::Stop)));
    net.run(at + 2 * MS, &faults);
    let closed_at = |net: &mut Simulation| {
        run_until(net, |net| net.closed.len() == 1);
        net.now - at
    };
    assert!(closed_at(&mut net) < 3_000 * MS, "closed when they are known to be lost");
}

/// As an operator meets it: a federate dies in a closed run, and the run is to begin again.
#[test]
fn a_restart_that_waits_for_somebody_says_for_whom() {
    for lost in ALL {
        let mut net = net(3, with_control(f64::INFINITY), network(0));
        run_until(&mut net, |net| net.closed.len() == 1);
        let to = net.now + 1_000 * MS;
        net.run(to, &[fault(net.now, lost, What::Kill)]);
        let asked = net.now;
        obey(&mut net, Command::Restart);
        assert!(net.now - asked < 10 * MS, "answered at once");
        let words = &net.answers.last().expect("an answer").1;
        assert!(words.contains(&format!("waiting for {lost}")), "{words}");
        assert_eq!(net.conductor().phase(), Phase::Init);
        net.run(net.now + 1_000 * MS, &[fault(net.now, lost, What::Start)]);
        assert_eq!(net.conductor().phase(), Phase::Configured, "{:?}", net.conductor().state());
        obey(&mut net, Command::Start);
        run_until(&mut net, |net| net.closed.len() == 2);
        assert_eq!(eaten(&net, 1), eaten(&net, 0));
    }
}

/// Found by `seeds sim`: the answer to its question was lost, then the process; another one of its name was
/// refused for good, since the first was thought to be there.
#[test]
fn a_process_that_vanished_while_joining_is_not_waited_for() {
    for (name, bus) in ALL.into_iter().zip([0, 100, 300, 600]) {
        for at_ms in [0, 1, 10, 40] {
            let mut net = net(8 + bus, with_control(2.0), Network { bus_loss: bus, ..network(0) });
            let at = net.now + at_ms * MS;
            let again = at + 400 * MS;
            let faults = [
                fault(0, name, What::Deaf(60 * MS)),
                fault(at, name, What::Vanish),
                fault(again, name, What::Start),
            ];
            net.run(2 * MINUTE, &faults);
            assert_eq!(net.closed.len(), 1, "{name}, {at_ms} ms: {:?}", net.conductor().state());
            assert_eq!(eaten(&net, 0), whole(), "{name}, {at_ms} ms");
        }
    }
}
