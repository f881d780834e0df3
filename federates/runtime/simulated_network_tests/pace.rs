//! Federations in which nobody is lost: loss, order and pace leave no trace, commands are obeyed or refused, a heavy frame is waited for.

use super::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn what_the_consumer_eats_does_not_depend_on_loss_order_or_pace(
        seed in 1u64.., udp in 0u64..40, bus in 0u64..200, paced in any::<bool>(),
    ) {
        let rate = if paced { 4.0 } else { f64::INFINITY };
        let mut net = net(seed, config(rate, true), Network { bus_loss: bus, ..network(udp) });
        net.run(10 * MINUTE, &[]);
        prop_assert_eq!(net.exit, Some(0), "{:?}", net.conductor().state());
        prop_assert_eq!(net.closed.len(), 1);
        prop_assert_eq!(eaten(&net, 0), eaten(&calm(), 0));
        prop_assert_eq!(net.value(0, "steps"), (LAST / 5) as f64);
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
    }

    #[test]
    fn freeze_step_resume_and_restart_leave_no_trace(seed in 1u64.., at in 0u64..1300, bus in 0u64..100) {
        let calm = calm();
        let mut net = net(seed, config(2.0, false), Network { bus_loss: bus, ..network(10) });
        run_until_running(&mut net);
        let to = net.now + at * MS;
        net.run(to, &[]);
        obey(&mut net, Command::Freeze);
        let to = net.now + 700 * MS;
        net.run(to, &[]);
        obey(&mut net, Command::Step { n: 3 });
        let to = net.now + 700 * MS;
        net.run(to, &[]);
        obey(&mut net, Command::Start);
        let to = net.now + 100 * MS;
        net.run(to, &[]);
        obey(&mut net, Command::Rate { rate: f64::INFINITY });
        run_until(&mut net, |net| net.closed.len() == 1);
        obey(&mut net, Command::Restart);
        let to = net.now + 900 * MS;
        net.run(to, &[]);
        obey(&mut net, Command::Start);
        run_until(&mut net, |net| net.closed.len() == 2);
        prop_assert!(net.answers.iter().all(|(ok, _)| *ok), "{:?}", net.answers);
        for run in 0..2 {
            prop_assert_eq!(eaten(&net, run), eaten(&calm, 0));
        }
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
    }
}

#[test]
fn a_command_at_the_wrong_time_is_refused_with_what_is_possible() {
    let mut net = net(3, config(1.0, false), network(0));
    net.run(2, &[fault(1, "", What::Command(Command::Freeze))]);
    run_until_running(&mut net);
    let at = net.now;
    let command = |after_ms, command| fault(at + after_ms * MS, "", What::Command(command));
    let faults = [
        command(0, Command::Start),
        command(10, Command::Step { n: 1 }),
        command(20, Command::Rate { rate: -1.0 }),
    ];
    net.run(at + 500 * MS, &faults);
    assert_eq!(net.answers.len(), 4);
    assert!(net.answers.iter().all(|(ok, _)| !ok), "{:?}", net.answers);
    assert!(net.answers[0].1.contains("not possible while INIT"), "{:?}", net.answers);
    assert!(net.answers[1].1.contains("freeze, stop"), "{:?}", net.answers);
    assert_eq!(net.conductor().phase(), Phase::Running, "what was refused changed nothing");
}

/// Nobody dies, everybody works, and the run is frozen for longer than any patience.
#[test]
fn a_run_frozen_for_an_hour_steps_and_goes_on() {
    let mut net = net(5, config(1.0, false), network(0));
    run_until_running(&mut net);
    let to = net.now + 300 * MS;
    net.run(to, &[]);
    obey(&mut net, Command::Freeze);
    let frozen = net.conductor().frame();
    let to = net.now + 60 * MINUTE;
    net.run(to, &[]);
    obey(&mut net, Command::Step { n: 20 });
    let words = net.answers.last().map(|a| a.1.clone());
    assert_eq!(words, Some(format!("frozen at frame {}", frozen + 20)));
    let to = net.now + 60 * MINUTE;
    net.run(to, &[]);
    obey(&mut net, Command::Start);
    run_for_until(&mut net, 10 * MINUTE, |net| net.closed.len() == 1);
    assert!(net.closed[0].reasons.is_empty(), "{:?}", net.closed[0].reasons);
}

/// More frames than anybody remembers, while PDUs and messages are lost: a step is no way around the window.
#[test]
fn a_step_of_thousands_of_frames_loses_nothing() {
    let last = 3_000;
    let of = |rate, batch| ConductorConfig { last_frame: last, ..config(rate, batch) };
    let mut calm = net(1, of(f64::INFINITY, true), network(0));
    run_for_until(&mut calm, 10 * MINUTE, |net| net.closed.len() == 1);
    let mut net = net(7, of(1.0, false), Network { bus_loss: 20, ..network(50) });
    run_until_running(&mut net);
    let to = net.now + 300 * MS;
    net.run(to, &[]);
    obey(&mut net, Command::Freeze);
    let n = last - 10 - net.conductor().frame();
    let answered = net.answers.len();
    net.run(net.now + 1, &[fault(net.now, "", What::Command(Command::Step { n }))]);
    run_for_until(&mut net, 10 * MINUTE, |net| net.answers.len() > answered);
    assert_eq!(net.answers.last().map(|a| a.1.clone()), Some("frozen at frame 2990".to_owned()));
    obey(&mut net, Command::Start);
    run_for_until(&mut net, 10 * MINUTE, |net| net.closed.len() == 1);
    assert!(net.closed[0].reasons.is_empty(), "{:?}", net.closed[0].reasons);
    assert_eq!(eaten(&net, 0), eaten(&calm, 0));
    assert!(net.broken.is_empty(), "{:?}", net.broken);
}

/// A heavy frame is a word, not a fault: beats say that it is worked on.
#[test]
fn a_heavy_frame_is_waited_for_and_a_hanging_one_is_not() {
    for (slow_s, name) in [(10, "smdfm"), (30, "traffic-generator")] {
        let mut net = net(5, config(1.0, false), network(0));
        run_until_running(&mut net);
        let at = net.now + 500 * MS;
        net.run(at + 5_000 * MS, &[fault(at, name, What::Slow(slow_s * 1000 * MS))]);
        assert_eq!(net.conductor().phase(), Phase::Running, "{name}: {:?}", net.reached);
        run_until(&mut net, |net| net.closed.len() == 1);
        assert!(net.closed[0].reasons.is_empty(), "{:?}", net.closed[0].reasons);
        assert_eq!(eaten(&net, 0), eaten(&calm(), 0));
    }
    let mut net = net(5, config(1.0, false), network(0));
    run_until_running(&mut net);
    let at = net.now + 500 * MS;
    net.run(at + 70_000 * MS, &[fault(at, "smdfm", What::Slow(600_000 * MS))]);
    let reasons = net.conductor().state().reasons;
    assert!(reasons.len() == 1 && reasons[0].contains("hangs for 60 s"), "{reasons:?}");
}

#[test]
fn a_pause_while_joining_changes_nothing() {
    let mut joining = 0;
    for name in ALL {
        for (at_us, batch) in
            [(0, true), (2_000, true), (4_000, true), (6_000, true), (3_000, false)]
        {
            let mut config = with_control(f64::INFINITY);
            config.batch = batch;
            let (mut net, at_ms) = (net(at_us + 1, config, network(10)), at_us / 1_000);
            net.run(1 + at_us * 1_000, &[]);
            if net.conductor().phase() != Phase::Init {
                continue;
            }
            joining += 1;
            net.run(MINUTE, &[fault(0, name, What::Pause(3_000 * MS))]);
            let state = net.conductor().state();
            let began = net.reached.iter().filter(|r| r.0 == Phase::Running).count();
            if began > 0 && net.closed.first().is_some_and(|run| run.failed) {
                // All had said that they were ready: it was missed in the run.
                joining -= 1;
                continue;
            }
            assert_eq!(net.closed.len(), 1, "{name}, {at_ms} ms: {state:?}");
            assert!(!net.closed[0].failed && net.exit.unwrap_or(0) == 0, "{name}, {at_ms} ms");
            let incs: Vec<u64> =
                ALL.iter().filter_map(|n| net.member(n)).map(|m| m.inc()).collect();
            assert!(incs.iter().all(|inc| *inc <= 4), "{name}, {at_ms} ms: {incs:?}");
            assert_eq!(eaten(&net, 0), whole(), "{name}, {at_ms} ms");
        }
    }
    assert!(joining >= 12, "{joining} cases were in INIT");
}

#[test]
fn how_each_member_does_is_said() {
    for (what, after_ms, expected) in [
        (What::Slow(10_000 * MS), 500, Health::Alive),
        (What::Vanish, 1_000, Health::Silent),
        (What::Vanish, 3_000, Health::Lost),
        (What::Slow(10_000 * MS), 4_000, Health::Late),
    ] {
        let mut net = net(3, config(1.0, false), network(0));
        run_until_running(&mut net);
        let at = net.now + 500 * MS;
        net.run(at + after_ms * MS, &[fault(at, "smdfm", what.clone())]);
        let members = net.conductor().state().members;
        let of = |name: &str| members.iter().find(|m| m.name == name).expect("a member");
        let smdfm = of("smdfm");
        assert_eq!(smdfm.health, expected, "{what:?} {after_ms} ms: {smdfm:?}");
        assert_eq!(of("external-world").health, Health::Alive);
        let heard_ms = smdfm.heard_ms.expect("it beats");
        let silent_ms = if matches!(what, What::Vanish) { after_ms } else { 0 };
        assert!((silent_ms.saturating_sub(50)..silent_ms + 250).contains(&heard_ms), "{smdfm:?}");
        assert_eq!(smdfm.behind, net.conductor().granted() - smdfm.frame);
    }
}

/// Of a hundred and fifty such runs 32 were closed without some results after five seconds for them, and half took longer than 77 s, one 130 s
/// (60 frames at 25 ms): what was missing was asked for twice a second. The draws are none that anything was chosen by.
#[test]
fn a_run_whose_bus_loses_six_words_of_ten_ends_in_time_with_all_its_results() {
    let whole = whole();
    for (seed, name) in (1_901..1_913).zip(ALL.into_iter().cycle()) {
        let mut net = net(seed, with_control(2.0), Network { bus_loss: 600, ..network(0) });
        let vanish = fault(net.now + 10 * MS, name, What::Vanish);
        let start = fault(net.now + 400 * MS, name, What::Start);
        net.run_to_close(net.now + 11 * MS, &[vanish]);
        let mut stopped = None;
        while net.closed.is_empty() && net.now < MINUTE {
            let until = net.now + 100 * MS;
            let due = (start.at_ns < until && start.at_ns >= net.now).then(|| start.clone());
            net.run_to_close(until, due.as_slice());
            if net.conductor().phase() == Phase::Stopped {
                stopped.get_or_insert(net.now);
            }
        }
        let took_ms = net.now / MS;
        assert!(
            net.closed.len() == 1 && took_ms < 45_000,
            "{seed}: {took_ms} ms, {:?}",
            net.reached
        );
        let end_ms = (net.now - stopped.unwrap_or(net.now)) / MS;
        assert!(end_ms < 10_000, "{seed}: results came after {end_ms} ms");
        assert_eq!(eaten(&net, 0), whole, "{seed}");
        assert!(!net.closed[0].failed && net.broken.is_empty(), "{seed}: {:?}", net.broken);
    }
}
