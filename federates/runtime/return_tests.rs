//! Members killed in a federation whose inputs cannot all be made again: outsiders come in, and a loop is closed.
//! Whoever comes back reads them in the log of the run, and the run is the one that nothing happened to.

use super::conductor::ConductorConfig;
use super::digest::pdu_hash;
use super::federate::{Federate, FrameInputs, FrameOut};
use super::life_cycle::Phase;
use super::messages::{Command, FinalReport, Frame, Kind, Notice, RunConfig};
use super::simulation::{Fault, MS, Network, Simulation, What};
use proptest::prelude::*;
use scenarios::losses::{Losses, on_loss_flag};
use std::sync::{Arc, OnceLock};

const LAST: Frame = 120;
const MINUTE: u64 = 60_000 * MS;

/// How far generators may be ahead of control.
const AHEAD: Frame = 5;

const WORLD: &str = "external-world";
const SMDFM: &str = "smdfm";
const CONTROL: &str = "control";
const GENERATORS: [&str; 2] = ["traffic-generator-1", "traffic-generator-2"];
const ALL: [&str; 5] = [CONTROL, WORLD, SMDFM, GENERATORS[0], GENERATORS[1]];

/// A member of the loop: its state is a digest of all that it was given, and everything that it makes holds its state.
struct Toy {
    name: String,
    sum: u64,
}

fn notice(sum: u64) -> Notice {
    let from = std::net::SocketAddr::from(([127, 0, 0, 1], 9));
    Notice::Outsider { received_ns: 0, from, octets: sum.to_le_bytes().to_vec() }
}

impl Toy {
    fn mix(&mut self, octets: &[u8]) {
        self.sum = self.sum.wrapping_mul(0x100_0000_01b3).wrapping_add(pdu_hash(octets));
    }

    fn pdu(&self, frame: Frame) -> Vec<u8> {
        format!("{} {frame} {}", self.name, self.sum).into_bytes()
    }
}

impl Federate for Toy {
    fn kind(&self) -> Kind {
        match &*self.name {
            "visitors" => Kind::Visitors,
            WORLD => Kind::ExternalWorld,
            SMDFM => Kind::Smdfm,
            CONTROL => Kind::Control,
            _ => Kind::TrafficGenerator,
        }
    }
    fn period(&self) -> Frame {
        if matches!(self.kind(), Kind::Smdfm | Kind::Control) { 5 } else { 1 }
    }
    fn consumes(&self) -> bool {
        !matches!(self.kind(), Kind::Visitors | Kind::ExternalWorld)
    }
    fn reads_pdus(&self) -> bool {
        self.kind() == Kind::Smdfm
    }
    fn ahead_of(&self, producer: &str) -> Option<Frame> {
        match self.kind() {
            Kind::TrafficGenerator => (producer == CONTROL).then_some(AHEAD),
            Kind::Smdfm => (producer != CONTROL).then_some(0),
            _ => Some(0),
        }
    }
    fn in_loop(&self) -> bool {
        self.consumes()
    }
    fn live(&self) -> bool {
        self.kind() == Kind::Visitors
    }
    fn configure(&mut self, config: &RunConfig, out: &mut FrameOut) -> Result<(), String> {
        self.sum = config.seed;
        if self.kind() != Kind::Control {
            out.notices.push(notice(self.sum));
        }
        Ok(())
    }
    fn step(&mut self, frame: Frame, inputs: &FrameInputs, out: &mut FrameOut) {
        self.mix(&frame.to_le_bytes());
        for (at, octets) in &inputs.pdus {
            self.mix(&at.to_le_bytes());
            self.mix(octets);
        }
        for (effect, notice) in &inputs.notices {
            let Notice::Outsider { octets, .. } = notice else { continue };
            self.mix(&effect.to_le_bytes());
            self.mix(octets);
        }
        match self.kind() {
            Kind::Control => out.later.push((frame + AHEAD, notice(self.sum))),
            Kind::Smdfm => out.notices.push(notice(self.sum)),
            // Longer than a page of the log, in all.
            Kind::Visitors => {
                let mut octets = self.pdu(frame);
                octets.resize(9_000, 7);
                out.pdus.push(octets.into());
                out.pdus.push(self.pdu(frame).into());
                out.later.push((frame + 3, notice(self.sum)));
            }
            _ => {
                out.pdus.push(self.pdu(frame).into());
                if frame.is_multiple_of(7) {
                    out.notices.push(notice(self.sum));
                }
            }
        }
    }
    fn state(&self) -> u64 {
        if self.consumes() { self.sum } else { 0 }
    }
    fn finish(&mut self, report: &mut FinalReport) {
        report.digests.push(("state".into(), self.sum));
    }
}

fn config(visitors: bool, policy: &str) -> ConductorConfig {
    let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
    let mut producers = ALL.to_vec();
    producers.sort_unstable();
    let optional = if visitors { vec!["visitors".to_owned()] } else { Vec::new() };
    ConductorConfig {
        scene: "toy".into(),
        scene_hash: 1,
        version: "v".into(),
        expected: names(&producers),
        producers: names(&producers),
        await_spectators: optional.clone(),
        await_spectators_ns: MINUTE,
        optional,
        generators: 2,
        seed: 7,
        step_ns: 50 * MS as i64,
        start_utc_ns: 0,
        last_frame: LAST,
        rate: 2.0,
        autostart: true,
        batch: false,
        window: 10,
        closes: Some((CONTROL.into(), AHEAD)),
        front_ends: std::collections::BTreeMap::new(),
        through_router: false,
        fed: 42,
        losses: Losses { on_loss: on_loss_flag(policy).expect("a policy"), ..Losses::default() },
    }
}

fn net(seed: u64, config: ConductorConfig, bus_loss: u64) -> Simulation {
    let toy = |name: &str| Toy { name: name.to_owned(), sum: 0 };
    let all = config.expected.iter().chain(&config.optional);
    let kinds: Vec<_> = all.map(|name| (name.clone(), toy(name).kind())).collect();
    let make = move |name: &str| -> Box<dyn Federate> { Box::new(toy(name)) };
    let network = Network { delay_ns: 3 * MS, bus_loss, udp_loss: 100, twice: 100 };
    Simulation::new(seed, config, &kinds, Arc::new(make), network)
}

/// The run that nothing happens to, without and with outsiders.
fn whole(visitors: bool) -> &'static [(String, String, u64)] {
    static WHOLE: [OnceLock<Vec<(String, String, u64)>>; 2] = [OnceLock::new(), OnceLock::new()];
    WHOLE[usize::from(visitors)].get_or_init(|| {
        let mut net = net(1, config(visitors, "freeze"), 0);
        net.run_to_close(10 * MINUTE, &[]);
        assert_eq!(net.closed.len(), 1, "{:?}", net.conductor().state());
        net.digests(0)
    })
}

fn fault(at_ns: u64, who: &str, what: What) -> Fault {
    Fault { at_ns, who: who.to_owned(), what }
}

fn killed(at: u64, who: &str, again_ms: u64) -> [Fault; 2] {
    [fault(at, who, What::Kill), fault(at + again_ms * MS, who, What::Start)]
}

/// Runs from the first grant on under faults that begin `at_ms` later.
fn run(net: &mut Simulation, faults: impl Fn(u64) -> Vec<Fault>) {
    while net.conductor().phase() != Phase::Running {
        assert!(net.now < MINUTE, "{:?}", net.conductor().state());
        net.run(net.now + 1, &[]);
    }
    let faults = faults(net.now);
    net.run_to_close(net.now + 5 * MINUTE, &faults);
    let waits: Vec<_> = ALL
        .iter()
        .filter_map(|n| Some((n, net.member(n)?.executed(), net.member(n)?.waits_for())))
        .collect();
    assert_eq!(net.closed.len(), 1, "{:?} {waits:#?}", net.conductor().state());
}

/// What is the same, however often members were killed.
fn came_back(net: &Simulation, visitors: bool) {
    assert!(!net.closed[0].failed, "{:?}", net.closed[0].reasons);
    assert!(net.broken.is_empty(), "{:?}", net.broken);
    assert_eq!(net.digests(0), whole(visitors), "{:?}", net.closed[0].reasons);
}

#[test]
fn each_member_that_is_killed_after_outsiders_came_in_makes_the_same_run() {
    for policy in ["freeze", "takeover"] {
        for name in ALL {
            for at_ms in [40, 700, 2_400] {
                let mut net = net(3, config(true, policy), 0);
                run(&mut net, |from| killed(from + at_ms * MS, name, 2_500).to_vec());
                came_back(&net, true);
            }
        }
    }
}

#[test]
fn one_that_is_killed_again_and_again_comes_back_each_time() {
    for name in [SMDFM, CONTROL, GENERATORS[1]] {
        let mut net = net(5, config(true, "freeze"), 20);
        run(&mut net, |from| {
            (0..4).flat_map(|n| killed(from + (300 + 1_700 * n) * MS, name, 600)).collect()
        });
        came_back(&net, true);
    }
}

fn moved(at_ns: u64, name: &str, to: &str) -> Fault {
    fault(at_ns, "", What::Command(Command::Move { name: name.into(), to: to.into() }))
}

fn count(net: &Simulation, what: &str) -> u64 {
    net.seen.get(what).copied().unwrap_or(0)
}

/// Generators and the external world, each to the process of each other one, early and late, with and without lost messages.
#[test]
fn a_place_that_is_given_to_another_process_is_the_same_run_and_no_fault() {
    let places = [WORLD, GENERATORS[0], GENERATORS[1]];
    for (n, (name, to)) in
        places.iter().flat_map(|a| places.iter().map(move |b| (*a, *b))).enumerate()
    {
        for at_ms in if name == to { [].as_slice() } else { &[1, 40, 700, 2_400] } {
            let mut net = net(n as u64, config(true, "takeover"), if n % 2 == 0 { 0 } else { 20 });
            run(&mut net, |from| vec![moved(from + at_ms * MS, name, to)]);
            came_back(&net, true);
            assert_eq!(net.closed[0].reasons, Vec::<String>::new(), "{name} to {to}");
            assert_eq!(count(&net, "place given by command"), 1);
            assert_eq!(count(&net, "taken over"), 1, "{name} to {to} at {at_ms}");
            let told = net.conductor().state().reasons;
            assert_eq!(told, Vec::<String>::new(), "all is well: {name} to {to}");
            let stood = net.reached.iter().filter(|(_, _, unasked)| *unasked).count() as u64;
            assert_eq!(count(&net, "stood for a move"), stood, "and none of that was a fault");
        }
    }
}

/// From process to process and to one that was moved itself: all three places are in one process in the end, and each is made good.
#[test]
fn places_are_moved_again_and_again() {
    let mut net = net(9, config(true, "takeover"), 20);
    let [first, second] = GENERATORS;
    run(&mut net, |from| {
        let moves =
            [(first, WORLD), (second, first), (first, second), (WORLD, first), (first, WORLD)];
        moves
            .iter()
            .zip(0..)
            .map(|((name, to), n)| moved(from + (200 + 450 * n) * MS, name, to))
            .collect()
    });
    came_back(&net, true);
    assert_eq!(net.closed[0].reasons, Vec::<String>::new());
    let refused: Vec<_> = net.answers.iter().filter(|(ok, _)| !ok).collect();
    // The first three lie in the process of the external world then: who is there already is not moved there.
    assert!(refused.iter().all(|(_, text)| text.contains("already")), "{refused:?}");
    assert_eq!(count(&net, "place given by command") as usize + refused.len(), 5);
    assert!(count(&net, "place given by command") >= 3, "{refused:?}");
}

/// Whoever is to take the place dies before it has, or the SMDFM does, or the place is lost again: the run is made good as for any loss.
#[test]
fn what_befalls_a_move_is_made_good() {
    let [first, second] = GENERATORS;
    for (n, who) in [WORLD, second, SMDFM, CONTROL].into_iter().enumerate() {
        for after_ms in [0, 5, 60, 200, 400, 900] {
            let mut net = net(20 + n as u64, config(true, "takeover"), 20);
            run(&mut net, |from| {
                let at = from + 500 * MS;
                let [killed, started] = killed(at + after_ms * MS, who, 1_500);
                vec![moved(at, first, WORLD), killed, started]
            });
            came_back(&net, true);
        }
    }
}

#[test]
fn what_cannot_be_moved_is_refused_and_nothing_happens() {
    let [first, second] = GENERATORS;
    for (policy, name, to, why) in [
        ("freeze", first, WORLD, "only under --on-loss takeover"),
        ("takeover", first, first, "already"),
        ("takeover", SMDFM, WORLD, "'smdfm' is not a place that can be moved: external-world, "),
        ("takeover", first, CONTROL, "'control' is not a place that can be moved"),
        ("takeover", "traffic-generator-3", second, "'traffic-generator-3' is not a place"),
    ] {
        let mut net = net(7, config(true, policy), 0);
        run(&mut net, |from| vec![moved(from + 300 * MS, name, to)]);
        came_back(&net, true);
        let [(false, said)] = &net.answers[..] else { panic!("{:?}", net.answers) };
        assert!(said.contains(why), "{policy} {name} {to}: {said}");
        assert_eq!(count(&net, "place given by command"), 0);
    }
}

/// The outsiders' door and who reads it are lost together: the run goes on without outsiders, and its SMDFM returns.
#[test]
fn a_consumer_returns_although_the_member_that_let_outsiders_in_is_gone() {
    for (gap_ms, visitors_first) in [(0, true), (20, false), (20, true), (400, false), (900, true)]
    {
        for seed in 1..6 {
            let mut net = net(seed, config(true, "freeze"), 10 * seed);
            run(&mut net, |from| {
                let (at, later) = (from + 800 * MS, from + (800 + gap_ms) * MS);
                let (door, reader) = if visitors_first { (at, later) } else { (later, at) };
                let mut faults = killed(reader, SMDFM, 2_000).to_vec();
                faults.push(fault(door, "visitors", What::Kill));
                faults
            });
            let closed = &net.closed[0];
            assert!(!closed.failed, "{gap_ms} {visitors_first} {seed}: {:?}", closed.reasons);
            assert!(closed.reasons.iter().any(|r| r.starts_with("degraded since frame ")));
            assert_eq!(closed.frame, LAST);
        }
    }
}

/// A generator is gone for good and the run goes on without it; then the SMDFM is killed.
#[test]
fn a_consumer_makes_nothing_of_one_that_the_run_goes_on_without() {
    let mut policy = config(false, "freeze,traffic-generator-2=degrade");
    policy.closes = None;
    for name in [SMDFM, CONTROL] {
        let mut net = net(3, policy.clone(), 0);
        run(&mut net, |from| {
            let mut faults = killed(from + 1_500 * MS, name, 1_000).to_vec();
            faults.push(fault(from + 500 * MS, GENERATORS[1], What::Kill));
            faults
        });
        let closed = &net.closed[0];
        assert!(!closed.failed && closed.frame == LAST, "{name}: {:?}", closed.reasons);
        assert!(closed.reasons.iter().any(|r| r.contains("back after")), "{:?}", closed.reasons);
    }
}

/// With an outsider, under takeover, the external world is lost, then the SMDFM, then the generator whose process had made the world
/// again. The SMDFM makes that generator up to a frame past its own, and has to hear what control had said meanwhile.
#[test]
fn a_world_its_host_and_the_smdfm_lost_within_half_a_second_make_the_same_run() {
    let mut net = net(9_506_185_349_902_963_395, config(true, "takeover"), 14);
    run(&mut net, |from| {
        let all = [(WORLD, 0), (GENERATORS[1], 407), (SMDFM, 388)];
        all.into_iter()
            .flat_map(|(who, gap)| killed(from + (1_327 + gap) * MS, who, 9_300))
            .collect()
    });
    came_back(&net, true);
}

/// A generator may have made what control said in a frame that nobody holds but the SMDFM's inputs: control's cut is before it, those of the
/// generators are not, and the SMDFM, who reads no control, stands at theirs.
#[test]
fn who_reads_no_control_stands_where_its_own_producers_are_cut() {
    let mut net = net(18_165_595_664_656_830_003, config(false, "freeze"), 107);
    run(&mut net, |from| {
        let [a, b, c] = [(CONTROL, 0), (GENERATORS[1], 91), (GENERATORS[0], 94)]
            .map(|(who, gap)| killed(from + (1_611 + gap) * MS, who, 300));
        [a, b, c].concat()
    });
    came_back(&net, false);
}

fn without(at_ns: u64, name: &str) -> Fault {
    fault(at_ns, "", What::Command(Command::Without { name: name.into() }))
}

/// Two are lost; the run goes on without one of them and stands for the other until that is back, whichever comes first.
#[test]
fn time_stands_for_the_rest_of_those_that_are_lost() {
    let mut config = config(false, "freeze");
    config.closes = None;
    for (name, other) in [(GENERATORS[0], SMDFM), (WORLD, GENERATORS[1]), (SMDFM, GENERATORS[0])] {
        for (without_ms, again_ms) in [(2_000, 4_000), (4_000, 2_000)] {
            let mut net = net(3, config.clone(), 0);
            run(&mut net, |from| {
                let at = from + 500 * MS;
                let [killed, started] = killed(at, other, again_ms);
                vec![
                    killed,
                    started,
                    fault(at + 20 * MS, name, What::Kill),
                    without(at + without_ms * MS, name),
                ]
            });
            let closed = &net.closed[0];
            assert!(!closed.failed && closed.frame == LAST, "{name}: {:?}", closed.reasons);
            assert!(net.broken.is_empty(), "{:?}", net.broken);
            assert!(net.answers[0].0, "{:?}", net.answers);
            let said = |what: &str| closed.reasons.iter().filter(|r| r.contains(what)).count();
            assert_eq!(
                (said("degraded since"), said("back after")),
                (1, 1),
                "{:?}",
                closed.reasons
            );
            // It stood all the time that somebody was awaited.
            let stood = net.reached.iter().filter(|(phase, ..)| *phase == Phase::Frozen).count();
            assert_eq!(stood, 1, "{:?}", net.reached);
        }
    }
}

/// One that is on its way back while it is said that the run goes on without it is not taken any more.
#[test]
fn who_is_done_without_is_not_let_in_again() {
    for late_ms in [0, 1, 2, 4, 8, 15, 30] {
        let mut net = net(5, config(false, "freeze"), 0);
        run(&mut net, |from| {
            let at = from + 700 * MS;
            let [killed, started] = killed(at, GENERATORS[1], 3_000);
            vec![killed, started, without(at + (3_000 + late_ms) * MS, GENERATORS[1])]
        });
        let closed = &net.closed[0];
        assert!(!closed.failed && closed.frame == LAST, "{late_ms}: {:?}", closed.reasons);
        let (ok, said) = &net.answers[0];
        let gone = closed.reasons.iter().any(|r| r.starts_with("degraded since frame "));
        assert_eq!(*ok, gone, "{late_ms}: {said}");
        if !ok {
            came_back(&net, false);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Two or three of them within half a second, any of them, under losses of messages, with and without outsiders.
    #[test]
    fn any_that_are_killed_within_half_a_second_make_the_same_run(
        seed in 1u64..,
        at_ms in 5u64..2_600,
        gaps_ms in [0u64..500, 0u64..500],
        who in [0usize..5, 0usize..5, 0usize..5],
        again_ms in [300u64..4_000, 300u64..4_000, 300u64..4_000],
        bus in prop_oneof![Just(0u64), 0u64..120],
        visitors in any::<bool>(),
        takeover in any::<bool>(),
    ) {
        let policy = if takeover { "takeover" } else { "freeze" };
        let mut net = net(seed, config(visitors, policy), bus);
        run(&mut net, |from| {
            let first = from + at_ms * MS;
            let at = [first, first + gaps_ms[0] * MS, first + gaps_ms[1] * MS];
            let mut faults = Vec::new();
            for n in 0..3 {
                if !who[..n].contains(&who[n]) {
                    // Where others take its place, somebody comes only where there is nobody left.
                    let again_ms = again_ms[n] + if takeover { 9_000 } else { 0 };
                    faults.extend(killed(at[n], ALL[who[n]], again_ms));
                }
            }
            faults
        });
        came_back(&net, visitors);
    }
}
