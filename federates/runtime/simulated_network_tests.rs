//! Toy federates in the simulated federation: messages and PDUs are delayed, reordered, doubled and lost by
//! seed, members die, stand still and come back; the laws of the protocol must hold all the same.

use super::conductor::ConductorConfig;
use super::federate::{Federate, FrameInputs, FrameOut, Octets};
use super::life_cycle::Phase;
use super::member::CONDUCTOR;
use super::messages::{Command, FinalReport, Frame, Health, Kind, Notice, RunConfig};
use super::simulation::{Fault, MS, Network, STANDBY, Simulation, What};
use proptest::prelude::*;
use scenarios::losses::{Losses, ReturnWithin, on_loss_flag, stall_flag, step_flag};
use std::sync::Arc;

const LAST: Frame = 60;
const MINUTE: u64 = 60_000 * MS;

/// A producer whose PDUs hold its name, the frame and what came before: a run made again from the middle differs.
struct Producer {
    name: String,
    sum: u64,
}

impl Federate for Producer {
    fn kind(&self) -> Kind {
        Kind::TrafficGenerator
    }
    fn configure(&mut self, config: &RunConfig, out: &mut FrameOut) -> Result<(), String> {
        self.sum = config.seed;
        out.notices.push(Notice::Flights(Vec::new()));
        out.pdus.push(format!("{} 0", self.name).into_bytes().into());
        Ok(())
    }
    fn step(&mut self, frame: Frame, _: &FrameInputs, out: &mut FrameOut) {
        self.sum = self.sum.wrapping_mul(31).wrapping_add(frame);
        for copy in 0..frame % 3 {
            let text = format!("{} {frame} {copy} {}", self.name, self.sum);
            out.pdus.push(text.into_bytes().into());
        }
    }
    fn finish(&mut self, _: &mut FinalReport) {}
}

/// A member that lets an outsider in, in every frame, and another one three frames later.
struct Visitors;

fn outsider(received_ns: i64) -> Notice {
    let from = std::net::SocketAddr::from(([127, 0, 0, 1], 9));
    Notice::Outsider { received_ns, from, octets: vec![1] }
}

impl Federate for Visitors {
    fn kind(&self) -> Kind {
        Kind::Visitors
    }
    fn configure(&mut self, _: &RunConfig, _: &mut FrameOut) -> Result<(), String> {
        Ok(())
    }
    fn step(&mut self, frame: Frame, _: &FrameInputs, out: &mut FrameOut) {
        out.notices.push(outsider(frame as i64));
        out.later.push((frame + 3, outsider(frame as i64 + 3)));
    }
    fn finish(&mut self, _: &mut FinalReport) {}
}

/// A consumer that remembers everything it was given.
#[derive(Default)]
struct Consumer {
    eaten: Vec<(Frame, Octets)>,
    visits: u64,
    steps: Vec<Frame>,
    outsiders: usize,
}

impl Consumer {
    fn digest(&self) -> u64 {
        let all: Vec<u8> = self
            .eaten
            .iter()
            .flat_map(|(f, o)| f.to_le_bytes().into_iter().chain(o.iter().copied()))
            .collect();
        super::digest::pdu_hash(&all)
    }
}

impl Federate for Consumer {
    fn kind(&self) -> Kind {
        Kind::Smdfm
    }
    fn period(&self) -> Frame {
        5
    }
    fn consumes(&self) -> bool {
        true
    }
    fn configure(&mut self, _: &RunConfig, _: &mut FrameOut) -> Result<(), String> {
        *self = Self::default();
        Ok(())
    }
    fn step(&mut self, frame: Frame, inputs: &FrameInputs, _: &mut FrameOut) {
        let first = if frame == 5 { 0 } else { frame - 4 };
        assert!(inputs.pdus.iter().all(|(f, _)| (first..=frame).contains(f)));
        let visits = inputs.notices.iter().filter(|(effect, notice)| match notice {
            Notice::Outsider { received_ns, .. } => {
                assert!(*received_ns == *effect as i64 && (first..=frame).contains(effect));
                true
            }
            _ => false,
        });
        self.visits += visits.count() as u64;
        self.steps.push(frame);
        self.eaten.extend(inputs.pdus.iter().cloned());
        self.outsiders += inputs.outsiders.len();
    }
    fn state(&self) -> u64 {
        self.digest()
    }
    fn finish(&mut self, report: &mut FinalReport) {
        report.digests.push(("eaten".into(), self.digest()));
        report.values.push(("steps".into(), self.steps.len() as f64));
        report.values.push(("eaten".into(), self.eaten.len() as f64));
        report.values.push(("foreign".into(), self.outsiders as f64));
        report.values.push(("visits".into(), self.visits as f64));
    }
}

fn config(rate: f64, batch: bool) -> ConductorConfig {
    let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
    ConductorConfig {
        scene: "toy".into(),
        scene_hash: 1,
        version: "v".into(),
        expected: names(&["external-world", "smdfm", "traffic-generator"]),
        producers: names(&["external-world", "traffic-generator"]),
        optional: Vec::new(),
        generators: 1,
        seed: 7,
        step_ns: 50 * MS as i64,
        start_utc_ns: 0,
        last_frame: LAST,
        rate,
        autostart: true,
        batch,
        await_spectators: Vec::new(),
        await_spectators_ns: 0,
        window: 8,
        closes: None,
        front_ends: std::collections::BTreeMap::new(),
        through_router: false,
        fed: 42,
        losses: Losses::default(),
    }
}

fn network(loss: u64) -> Network {
    Network { delay_ns: 3 * MS, bus_loss: 0, udp_loss: 10 * loss, twice: 300 }
}

fn net(seed: u64, config: ConductorConfig, network: Network) -> Simulation {
    let all = config.expected.iter().chain(&config.optional).cloned();
    let producers = config.producers.clone();
    let kinds: Vec<(String, Kind)> = all
        .map(|name| {
            let kind = match &*name {
                "visitors" => Kind::Visitors,
                _ if producers.contains(&name) => Kind::TrafficGenerator,
                _ => Kind::Smdfm,
            };
            (name, kind)
        })
        .collect();
    let make = move |name: &str| -> Box<dyn Federate> {
        match name {
            "visitors" => Box::new(Visitors),
            name if producers.iter().any(|p| p == name) => {
                Box::new(Producer { name: name.to_owned(), sum: 0 })
            }
            _ => Box::new(Consumer::default()),
        }
    };
    Simulation::new(seed, config, &kinds, Arc::new(make), network)
}

fn calm() -> Simulation {
    let mut calm = net(1, config(f64::INFINITY, true), network(0));
    calm.run(MINUTE, &[]);
    calm
}

fn fault(at_ns: u64, who: &str, what: What) -> Fault {
    Fault { at_ns, who: who.to_owned(), what }
}

fn run_for_until(net: &mut Simulation, within: u64, done: impl Fn(&Simulation) -> bool) {
    let until = net.now + within;
    while !done(net) {
        assert!(
            net.now < until,
            "never: {:?} {:?} {:?}",
            net.reached,
            net.answers,
            net.conductor().state()
        );
        net.run(net.now + 1, &[]);
    }
}

fn run_until(net: &mut Simulation, done: impl Fn(&Simulation) -> bool) {
    run_for_until(net, MINUTE, done);
}

/// Runs until time is being granted: before that there is nothing to freeze.
fn run_until_running(net: &mut Simulation) {
    run_until(net, |net| net.conductor().phase() == Phase::Running);
}

/// Gives a command as an operator does, who waits for its answer.
fn obey(net: &mut Simulation, command: Command) {
    let answered = net.answers.len();
    net.run(net.now + 1, &[fault(net.now, "", What::Command(command))]);
    run_until(net, |net| net.answers.len() > answered);
}

fn eaten(net: &Simulation, run: usize) -> Vec<(String, String, u64)> {
    net.digests(run)
}

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

    #[test]
    fn a_lost_member_freezes_all_at_one_frame_and_says_so(
        seed in 1u64.., at in 100u64..1200, consumer in any::<bool>(),
    ) {
        let name = if consumer { "smdfm" } else { "traffic-generator" };
        let mut net = super::simulated_network_tests::net(seed, config(1.0, false), network(10));
        net.run(at * MS + 20_000 * MS, &[fault(at * MS, name, What::Kill)]);
        prop_assert_eq!(net.reached.last().map(|r| r.0), Some(Phase::Frozen), "{:?}", net.reached);
        let state = net.conductor().state();
        prop_assert!(state.reasons[0].contains(name), "{:?}", state.reasons);
        let mut batch = super::simulated_network_tests::net(seed, config(f64::INFINITY, true), network(10));
        batch.run(MINUTE, &[fault(3 * MS + at * 10_000, name, What::Kill)]);
        prop_assert_eq!(batch.exit, Some(1));
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
    }
}

const ALL: [&str; 4] = ["control", "external-world", "smdfm", "traffic-generator"];

fn what() -> impl Strategy<Value = What> {
    prop_oneof![Just(What::Kill), Just(What::Vanish)]
}

/// A pause, or a link that is cut in both directions or in one.
fn interruption() -> impl Strategy<Value = What> {
    prop_oneof![
        (100u64..6_000).prop_map(|ms| What::Pause(ms * MS)),
        (100u64..6_000).prop_map(|ms| What::Cut(ms * MS)),
        (100u64..6_000).prop_map(|ms| What::Deaf(ms * MS)),
        (100u64..6_000).prop_map(|ms| What::Mute(ms * MS)),
    ]
}

fn with_control(rate: f64) -> ConductorConfig {
    let mut config = config(rate, false);
    config.expected.insert(0, "control".into());
    config
}

/// What the undisturbed federation of [`with_control`] eats.
fn whole() -> Vec<(String, String, u64)> {
    let mut whole = net(1, with_control(f64::INFINITY), network(0));
    whole.run(MINUTE, &[]);
    eaten(&whole, 0)
}

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

/// Found by a random case: a producer and, 45 ms later, a consumer die in the first frames. The consumer had told
/// of frame 0, which has no inputs; what the producer made in it was taken for nothing, since nobody knew of it.
#[test]
fn a_consumer_that_dies_behind_a_producer_in_the_first_frames_returns_as_it_was() {
    for gap_us in [45_366, 40_000, 50_000, 95_000, 100_000] {
        let mut net = net(1, with_control(1.0), network(10));
        run_until_running(&mut net);
        let at = net.now + 5 * MS;
        let dead = ["external-world", "control"];
        let faults =
            [fault(at, dead[0], What::Kill), fault(at + gap_us * 1000, dead[1], What::Kill)];
        net.run(at + 10_000 * MS, &faults);
        let starts = dead.map(|name| fault(net.now, name, What::Start));
        let to = net.now + 20_000 * MS;
        net.run(to, &starts);
        assert_eq!(eaten(&net, 0), whole(), "{gap_us} us");
    }
}

/// Found by random cases: two that stood still or were cut off wake up at about the same time. An answer to a question
/// that was asked twice was older than what had been heard since; a consumer that had used more than the others held
/// used it again; results were not told before the run was over.
#[test]
fn two_that_wake_up_together_go_on_as_one_run() {
    /// Seed, messages lost of a thousand, and who is disturbed when.
    type Case = (u64, u64, [(&'static str, u64, What); 2]);
    let cases: [Case; 5] = [
        (
            4_415_643_496_163_808_907,
            69,
            [
                ("external-world", 1_052, What::Pause(3_745 * MS)),
                ("smdfm", 2_602, What::Pause(2_194 * MS)),
            ],
        ),
        (
            125_297_936_774_898_397,
            0,
            [
                ("external-world", 929, What::Cut(3_147 * MS)),
                ("control", 1_002, What::Pause(3_180 * MS)),
            ],
        ),
        (
            8_171_326_735_776_529_985,
            0,
            [
                ("traffic-generator", 1_303, What::Pause(4_688 * MS)),
                ("control", 3_194, What::Pause(2_802 * MS)),
            ],
        ),
        (
            14_165_529_495_489_109_648,
            126,
            [
                ("control", 1_403, What::Cut(101 * MS)),
                ("external-world", 3_352, What::Cut(1_921 * MS)),
            ],
        ),
        (
            1_554_159_699_540_844_987,
            117,
            [
                ("external-world", 744, What::Mute(100 * MS)),
                ("smdfm", 3_103, What::Pause(1_971 * MS)),
            ],
        ),
    ];
    for (seed, bus, whats) in cases {
        let mut net = net(seed, with_control(1.0), Network { bus_loss: bus, ..network(10) });
        run_until_running(&mut net);
        let begun = net.now;
        let faults = whats.map(|(name, at_ms, what)| fault(begun + at_ms * MS, name, what));
        net.run(begun + 31_052 * MS, &faults);
        let waits: Vec<_> =
            ALL.iter().filter_map(|n| Some((n, net.member(n)?.waits_for()))).collect();
        assert_eq!(net.closed.len(), 1, "{seed}: {:?} {waits:?}", net.reached);
        assert!(!net.closed[0].failed, "{seed}: {:?}", net.closed[0].reasons);
        assert_eq!(eaten(&net, 0), whole(), "{seed}");
    }
}

/// Found by random cases: all frames were made, and a link was cut before the results were told.
#[test]
fn results_of_one_that_is_lost_at_the_end_are_awaited() {
    for (n, name) in (0..).zip(ALL) {
        for what in
            [What::Cut(3_000 * MS), What::Pause(4_000 * MS), What::Mute(5_000 * MS), What::Kill]
        {
            let mut net = net(7 + n, with_control(2.0), Network { bus_loss: 50, ..network(10) });
            run_until(&mut net, |net| net.conductor().phase() == Phase::Stopped);
            let at = net.now;
            let faults = [fault(at, name, what.clone()), fault(at + 6_000 * MS, name, What::Start)];
            net.run(at + 15_000 * MS, &faults);
            assert_eq!(net.closed.len(), 1, "{name} {what:?}: {:?}", net.conductor().state());
            assert!(!net.closed[0].failed && net.conductor().exit_code() == 0, "{name} {what:?}");
            assert_eq!(eaten(&net, 0), whole(), "{name} {what:?}");
            assert!(net.broken.is_empty(), "{name} {what:?}: {:?}", net.broken);
        }
    }
    // Somebody else takes a producer's place; a batch that waits for nobody ends with what it has.
    for (config, code) in [(taking_over(2.0), 0), (config(2.0, true), 1)] {
        let mut net = net(5, config, network(10));
        run_until(&mut net, |net| net.conductor().phase() == Phase::Stopped);
        let at = net.now;
        net.run(at + MINUTE, &[fault(at, "traffic-generator", What::Kill)]);
        assert_eq!((net.exit, net.closed.len()), (Some(code), 1), "{:?}", net.conductor().state());
        if code == 0 {
            assert_eq!(eaten(&net, 0), whole());
        }
    }
    // An operator does not wait for ever.
    let mut net = net(5, with_control(2.0), network(10));
    run_until(&mut net, |net| net.conductor().phase() == Phase::Stopped);
    let at = net.now;
    net.run(at + MINUTE, &[fault(at, "smdfm", What::Kill)]);
    assert!(net.closed.is_empty() && net.conductor().awaits_results());
    obey(&mut net, Command::Stop);
    assert!(net.closed.len() == 1 && net.closed[0].failed);
    assert_eq!(net.conductor().exit_code(), 1);
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

/// A batch under `takeover`, with control.
fn taking_over(rate: f64) -> ConductorConfig {
    let mut config = with_control(rate);
    config.batch = true;
    config.losses.on_loss = on_loss_flag("takeover").expect("a policy");
    config
}

#[test]
fn a_producer_is_taken_over_by_the_process_of_another_and_so_is_that_one() {
    let mut net = net(3, taking_over(1.0), network(10));
    run_until_running(&mut net);
    let at = net.now + 500 * MS;
    // The host dies with what it hosts; then a new process of the first is there to take both.
    let faults = [
        fault(at, "traffic-generator", What::Kill),
        fault(at + 1_000 * MS, "external-world", What::Kill),
        fault(at + 2_000 * MS, "traffic-generator", What::Start),
    ];
    net.run(MINUTE, &faults);
    assert_eq!(net.exit, Some(0), "{:?}", net.conductor().state());
    assert!((2..=4).contains(&net.seen["taken over"]), "{:?}", net.seen);
    assert_eq!(net.closed[0].reasons.len(), 3, "{:?}", net.closed[0].reasons);
    assert!(net.closed[0].reasons.iter().all(|r| r.contains("back after")));
    assert_eq!(eaten(&net, 0), whole());
}

#[test]
fn whom_nobody_takes_over_is_waited_for_ten_seconds() {
    for (again_ms, code) in [(Some(4_000), 0), (None, 1)] {
        let mut net = net(3, taking_over(1.0), network(10));
        run_until_running(&mut net);
        let at = net.now + 500 * MS;
        let start = again_ms.map(|ms| fault(at + ms * MS, "smdfm", What::Start));
        let faults: Vec<_> = [fault(at, "smdfm", What::Kill)].into_iter().chain(start).collect();
        net.run(at + 11_000 * MS, &faults);
        assert_eq!(net.exit, Some(code), "{:?}", net.conductor().state());
        if code == 0 {
            assert_eq!(eaten(&net, 0), whole());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

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
        let mut whole = super::simulated_network_tests::net(1, with_control(f64::INFINITY), network(0));
        whole.run(MINUTE, &[]);
        prop_assert_eq!(eaten(&net, 0), eaten(&whole, 0));
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
    }

    #[test]
    fn whoever_stood_still_or_was_cut_off_comes_back_and_nothing_is_missing(
        seed in 1u64..,
        at_ms in 5u64..1500,
        gap_ms in 0u64..3_000,
        first in 0usize..4,
        second in 1usize..4,
        what in [interruption(), interruption()],
        bus in prop_oneof![Just(0u64), 0u64..150],
    ) {
        let pair = [ALL[first], ALL[(first + second) % 4]];
        let mut net = net(seed, with_control(1.0), Network { bus_loss: bus, ..network(10) });
        run_until_running(&mut net);
        let at = net.now + at_ms * MS;
        let [one, two] = what;
        let faults = [fault(at, pair[0], one), fault(at + gap_ms * MS, pair[1], two)];
        net.run(at + 30_000 * MS, &faults);
        let waits: Vec<_> = ALL.iter().filter_map(|n| Some((n, net.member(n)?.waits_for()))).collect();
        prop_assert_eq!(net.closed.len(), 1, "{:?} {:?} {:?}", net.reached, net.conductor().state(), waits);
        prop_assert!(!net.closed[0].failed);
        let mut whole = super::simulated_network_tests::net(1, with_control(f64::INFINITY), network(0));
        whole.run(MINUTE, &[]);
        prop_assert_eq!(eaten(&net, 0), eaten(&whole, 0));
        prop_assert!(net.broken.is_empty(), "{:?}", net.broken);
    }

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
        let mut whole = super::simulated_network_tests::net(1, with_control(f64::INFINITY), network(0));
        whole.run(MINUTE, &[]);
        prop_assert_eq!(eaten(&net, 0), eaten(&whole, 0));
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

/// Found by `seeds sim`: the SMDFM dies at the end of the run, and then, before it has answered the seal, a generator whose results are here. Nobody
/// awaited anything of that one, but for the answer: the loss was never settled, the SMDFM never let in again, the run never closed.
#[test]
fn one_that_dies_with_its_results_told_holds_nobody_up() {
    for (seed, gap_ms) in (1..).zip([20, 50, 100, 200, 300]) {
        let mut net = net(seed, with_control(2.0), network(10));
        run_until(&mut net, |net| net.conductor().phase() == Phase::Stopped);
        let at = net.now;
        let faults = [
            fault(at, "smdfm", What::Kill),
            fault(at + gap_ms * MS, "traffic-generator", What::Kill),
            fault(at + 1_500 * MS, "smdfm", What::Start),
        ];
        net.run_to_close(at + 20_000 * MS, &faults);
        assert_eq!(net.closed.len(), 1, "{gap_ms} ms: {:?}", net.conductor().state());
        assert!(!net.closed[0].failed, "{gap_ms} ms: {:?}", net.closed[0].reasons);
        assert_eq!(eaten(&net, 0), whole(), "{gap_ms} ms");
        assert!(net.broken.is_empty(), "{gap_ms} ms: {:?}", net.broken);
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
