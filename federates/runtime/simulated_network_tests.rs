//! The conductor and its members under a simulated network: messages and PDUs are delayed, reordered
//! between senders, duplicated and lost by seed; the laws of the protocol must hold all the same.

use super::codec::encode;
use super::conductor::{ClosedRun, Conductor, ConductorConfig, Effect as Decision};
use super::federate::{Federate, FrameInputs, FrameOut, Octets};
use super::life_cycle::Phase;
use super::member::{Effect, Member};
use super::messages::{
    Command, FinalReport, Frame, Hello, Kind, Notice, Order, Repair, Repaired, Report, RunConfig,
    Welcome,
};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

const MS: u64 = 1_000_000;
const LAST: Frame = 60;

/// A producer whose PDUs are its name and the frame.
struct Producer {
    name: &'static str,
}

impl Federate for Producer {
    fn kind(&self) -> Kind {
        Kind::TrafficGenerator
    }
    fn configure(&mut self, _: &RunConfig, out: &mut FrameOut) -> Result<(), String> {
        out.notices.push(Notice::Flights(Vec::new()));
        Ok(())
    }
    fn step(&mut self, frame: Frame, _: &FrameInputs, out: &mut FrameOut) {
        for copy in 0..frame % 3 {
            out.pdus.push(format!("{} {frame} {copy}", self.name).into_bytes().into());
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
        assert!(inputs.pdus.iter().all(|(f, _)| *f <= frame && *f + 5 > frame));
        // Nothing is left out, whatever happens: every producer makes f % 3 PDUs in frame f.
        let made: u64 = (frame - 4..=frame).map(|f| 2 * (f % 3)).sum();
        assert_eq!(inputs.pdus.len() as u64, made, "inputs of frame {frame}");
        let visits = inputs.notices.iter().filter(|(effect, notice)| match notice {
            Notice::Outsider { received_ns, .. } => {
                assert!(*received_ns == *effect as i64 && *effect <= frame && *effect + 5 > frame);
                true
            }
            Notice::Flights(_) => false,
        });
        self.visits += visits.count() as u64;
        self.steps.push(frame);
        self.eaten.extend(inputs.pdus.iter().cloned());
        self.outsiders += inputs.outsiders.len();
    }
    fn finish(&mut self, report: &mut FinalReport) {
        let all: Vec<u8> = self
            .eaten
            .iter()
            .flat_map(|(f, o)| f.to_le_bytes().into_iter().chain(o.iter().copied()))
            .collect();
        report.digests.push(("eaten".into(), super::digest::pdu_hash(&all)));
        report.values.push(("steps".into(), self.steps.len() as f64));
        report.values.push(("eaten".into(), self.eaten.len() as f64));
        report.values.push(("foreign".into(), self.outsiders as f64));
        report.values.push(("visits".into(), self.visits as f64));
    }
}

enum Parcel {
    Order(Order),
    Report(String, Report),
    Pdus(Vec<Octets>),
    Repair(String, Repair),
    Repaired(Repaired),
}

/// What a scenario does to the federation at a time: command, or death of a member.
#[derive(Clone, Debug)]
enum Act {
    Command(Command),
    /// Its process dies, and its connection with it.
    Kill(&'static str),
    /// It is not heard of any more, and nobody is told.
    Vanish(&'static str),
}

struct Net {
    now: u64,
    random: u64,
    loss_pct: u64,
    parcels: BTreeMap<(u64, u64), (String, Parcel)>,
    /// In-order delivery of must-arrive messages: (from, to) → earliest next delivery.
    ordered: BTreeMap<(String, String), u64>,
    sent: u64,
    members: BTreeMap<String, Member>,
    conductor: Conductor,
    closed: Vec<ClosedRun>,
    reached: Vec<(Phase, Frame)>,
    answers: Vec<(bool, String)>,
    exit: Option<u8>,
}

impl Net {
    fn new(seed: u64, loss_pct: u64, rate: f64, batch: bool) -> Self {
        Self::with(seed, loss_pct, rate, batch, |_| {})
    }

    fn with(
        seed: u64,
        loss_pct: u64,
        rate: f64,
        batch: bool,
        change: impl FnOnce(&mut ConductorConfig),
    ) -> Self {
        let names = ["external-world", "traffic-generator"];
        let mut config = ConductorConfig {
            scene: "toy".into(),
            scene_hash: 1,
            version: "v".into(),
            expected: vec!["external-world".into(), "smdfm".into(), "traffic-generator".into()],
            producers: names.iter().map(|n| (*n).to_owned()).collect(),
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
            // A request for repair is sent again every 0.2 s: of a hundred one gets through.
            stall_ns: 20_000 * MS,
        };
        change(&mut config);
        let mut expected = config.expected.clone();
        expected.extend(config.optional.clone());
        let mut net = Self {
            now: 1,
            random: seed | 1,
            loss_pct,
            parcels: BTreeMap::new(),
            ordered: BTreeMap::new(),
            sent: 0,
            members: BTreeMap::new(),
            conductor: Conductor::new(config),
            closed: Vec::new(),
            reached: Vec::new(),
            answers: Vec::new(),
            exit: None,
        };
        for name in expected {
            let producer = names.into_iter().find(|n| *n == name);
            let kind = match (producer, &*name) {
                (Some(_), _) => Kind::TrafficGenerator,
                (None, "visitors") => Kind::Visitors,
                (None, _) => Kind::Smdfm,
            };
            let hello = Hello {
                name: name.clone(),
                kind,
                pid: 1,
                host: "h".into(),
                version: "v".into(),
                scene_hash: 1,
            };
            let mut decisions = Vec::new();
            net.conductor.hello(net.now, hello, 0, &mut decisions);
            let inc = decisions
                .iter()
                .find_map(|d| match d {
                    Decision::Welcome(_, Welcome::Accepted { inc }) => Some(*inc),
                    _ => None,
                })
                .expect("accepted");
            let federate: Box<dyn Federate> = match producer {
                Some(name) => Box::new(Producer { name }),
                None if kind == Kind::Visitors => Box::new(Visitors),
                None => Box::new(Consumer::default()),
            };
            net.members.insert(name.clone(), Member::new(federate, &name, inc, || 0));
            net.decide(decisions);
        }
        net
    }

    fn draw(&mut self, below: u64) -> u64 {
        // xorshift: only the test's own dice.
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random % below
    }

    fn post(&mut self, from: &str, to: &str, parcel: Parcel, in_order: bool) {
        let mut at = self.now + 10_000 + self.draw(3 * MS);
        if in_order {
            let earliest = self.ordered.entry((from.into(), to.into())).or_default();
            at = at.max(*earliest + 1);
            *earliest = at;
        }
        self.sent += 1;
        self.parcels.insert((at, self.sent), (to.to_owned(), parcel));
    }

    fn decide(&mut self, decisions: Vec<Decision>) {
        let names: Vec<String> = self.members.keys().cloned().collect();
        for decision in decisions {
            match decision {
                Decision::Order(order) => {
                    assert!(encode(&order).len() < 10_000);
                    for name in &names {
                        self.post("conductor", name, Parcel::Order(order.clone()), true);
                    }
                }
                Decision::Closed(run) => self.closed.push(*run),
                Decision::Reached { phase, frame, reason } => {
                    self.reached.push((phase, frame));
                    if phase == Phase::Frozen {
                        // I4: by command all stand at exactly this frame, by a fault all consumers.
                        let stand = if reason.is_none() { frame } else { self.conductor.stand() };
                        for (name, member) in &self.members {
                            if reason.is_none() || member.federate().consumes() {
                                assert_eq!(member.executed(), stand, "{name} at freeze");
                            }
                        }
                    }
                }
                Decision::Answer(_, answer) => self.answers.push((answer.ok, answer.text)),
                Decision::Exit(code) => self.exit = Some(code),
                Decision::Welcome(..) | Decision::State(_) => {}
            }
        }
    }

    fn consumers(&self) -> Vec<String> {
        let consumers = self.members.iter().filter(|(_, m)| m.federate().consumes());
        consumers.map(|(name, _)| name.clone()).collect()
    }

    fn act(&mut self, name: &str, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Send(pdus) => {
                    for octets in pdus {
                        for to in self.consumers() {
                            for _ in 0..1 + self.draw(2) {
                                if self.draw(100) >= self.loss_pct {
                                    let pdus = Parcel::Pdus(vec![Arc::clone(&octets)]);
                                    self.post(name, &to, pdus, false);
                                }
                            }
                        }
                    }
                }
                Effect::Report(report) => {
                    let parcel = |r: &Report| Parcel::Report(name.to_owned(), r.clone());
                    self.post(name, "conductor", parcel(&report), true);
                    for to in self.consumers().into_iter().filter(|to| to != name) {
                        self.post(name, &to, parcel(&report), true);
                    }
                }
                Effect::Repair { name: producer, repair } => {
                    if self.draw(100) >= self.loss_pct {
                        self.post(name, &producer, Parcel::Repair(name.into(), repair), false);
                    }
                }
                Effect::Publish(_) | Effect::Exit(_) => {}
            }
        }
    }

    /// Runs until the federation exits or `until`, doing `acts` at their times.
    fn run(&mut self, until: u64, mut acts: Vec<(u64, Act)>) {
        acts.sort_by_key(|(at, _)| std::cmp::Reverse(*at));
        while self.now < until && self.exit.is_none() {
            let next_parcel = self.parcels.keys().next().map_or(u64::MAX, |(at, _)| *at);
            let next_tick = self
                .members
                .values()
                .filter_map(Member::deadline)
                .min()
                .unwrap_or(u64::MAX)
                .min(self.conductor.deadline(self.now));
            let next_act = acts.last().map_or(u64::MAX, |(at, _)| *at);
            self.now = next_parcel.min(next_tick).min(next_act).max(self.now + 1);
            while acts.last().is_some_and(|(at, _)| *at <= self.now) {
                let (_, act) = acts.pop().expect("just seen");
                let mut decisions = Vec::new();
                match act {
                    Act::Command(command) => {
                        self.conductor.command(self.now, command, 9, &mut decisions);
                    }
                    Act::Kill(name) => {
                        self.members.remove(name);
                        let inc =
                            self.conductor.state().members.iter().position(|m| m.name == name);
                        assert!(inc.is_some());
                        for inc in 1..=4 {
                            self.conductor.alive(self.now, name, inc, false, &mut decisions);
                        }
                    }
                    Act::Vanish(name) => drop(self.members.remove(name)),
                }
                self.decide(decisions);
            }
            while let Some((&key, _)) = self.parcels.first_key_value() {
                if key.0 > self.now {
                    break;
                }
                let (to, parcel) = self.parcels.remove(&key).expect("just seen");
                self.deliver(&to, parcel);
            }
            let names: Vec<String> = self.members.keys().cloned().collect();
            for name in names {
                let mut effects = Vec::new();
                let now = self.now;
                self.members.get_mut(&name).expect("present").tick(now, &mut effects);
                self.act(&name, effects);
            }
            let mut decisions = Vec::new();
            self.conductor.tick(self.now, &mut decisions);
            self.decide(decisions);
            // I1 and I5: nobody executes more than was granted.
            let granted = self.conductor.state();
            for (name, member) in &self.members {
                assert!(member.executed() <= LAST, "{name} beyond the run: {granted:?}");
            }
        }
    }

    /// Runs, event by event, until `done`.
    fn run_until(&mut self, done: impl Fn(&Self) -> bool) {
        self.run_for_until(MINUTE, done);
    }

    /// Runs, event by event and for at most `within`, until `done`.
    fn run_for_until(&mut self, within: u64, done: impl Fn(&Self) -> bool) {
        let until = self.now + within;
        while !done(self) {
            assert!(self.now < until, "never: {:?} {:?}", self.reached, self.answers);
            self.run(self.now + 1, vec![]);
        }
    }

    /// Runs until time is being granted: before that there is nothing to freeze.
    fn run_until_running(&mut self) {
        self.run_until(|net| net.conductor.phase() == Phase::Running);
    }

    /// Gives a command as an operator does, who waits for its answer.
    fn obey(&mut self, command: Command) {
        let answered = self.answers.len();
        self.run(self.now + 1, vec![(self.now, Act::Command(command))]);
        self.run_until(|net| net.answers.len() > answered);
    }

    fn deliver(&mut self, to: &str, parcel: Parcel) {
        if to == "conductor" {
            if let Parcel::Report(from, report) = parcel {
                let mut decisions = Vec::new();
                self.conductor.report(self.now, &from, report, &mut decisions);
                self.decide(decisions);
            }
            return;
        }
        let now = self.now;
        let Some(member) = self.members.get_mut(to) else { return };
        let mut effects = Vec::new();
        match parcel {
            Parcel::Order(order) => member.order(order, &mut effects),
            Parcel::Report(from, report) => member.report(now, &from, report, &mut effects),
            Parcel::Pdus(pdus) => member.pdus(pdus, &mut effects),
            Parcel::Repaired(repaired) => member.repaired(repaired, &mut effects),
            Parcel::Repair(from, repair) => {
                let repaired = member.repair(&repair);
                self.post(to, &from, Parcel::Repaired(repaired), false);
            }
        }
        self.act(to, effects);
    }

    fn value(&self, run: usize, key: &str) -> f64 {
        let values = self.closed[run].reports.iter().flat_map(|r| &r.values);
        values.filter(|(k, _)| k == key).map(|(_, v)| v).sum()
    }

    fn eaten_digest(&self, run: usize) -> u64 {
        self.closed[run]
            .reports
            .iter()
            .flat_map(|r| &r.digests)
            .find(|(k, _)| k == "eaten")
            .expect("the consumer reports it")
            .1
    }
}

const MINUTE: u64 = 60_000 * MS;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn what_the_consumer_eats_does_not_depend_on_loss_order_or_pace(
        seed in 1u64.., loss in 0u64..40, paced in any::<bool>(),
    ) {
        let mut calm = Net::new(1, 0, f64::INFINITY, true);
        calm.run(MINUTE, vec![]);
        prop_assert_eq!(calm.exit, Some(0));
        let rate = if paced { 4.0 } else { f64::INFINITY };
        let mut net = Net::new(seed, loss, rate, true);
        net.run(10 * MINUTE, vec![]);
        prop_assert_eq!(net.exit, Some(0));
        prop_assert_eq!(net.closed.len(), 1);
        prop_assert_eq!(net.eaten_digest(0), calm.eaten_digest(0));
        prop_assert_eq!(net.value(0, "steps"), (LAST / 5) as f64);
    }

    #[test]
    fn freeze_step_resume_and_restart_leave_no_trace(seed in 1u64.., at in 0u64..1300) {
        let mut calm = Net::new(1, 0, f64::INFINITY, true);
        calm.run(MINUTE, vec![]);
        let mut net = Net::new(seed, 10, 2.0, false);
        net.run_until_running();
        net.run(net.now + at * MS, vec![]);
        net.obey(Command::Freeze);
        net.run(net.now + 700 * MS, vec![]);
        net.obey(Command::Step { n: 3 });
        net.run(net.now + 700 * MS, vec![]);
        net.obey(Command::Start);
        net.run(net.now + 100 * MS, vec![]);
        net.obey(Command::Rate { rate: f64::INFINITY });
        net.run_until(|net| net.closed.len() == 1);
        net.obey(Command::Restart);
        net.run(net.now + 900 * MS, vec![]);
        net.obey(Command::Start);
        net.run_until(|net| net.closed.len() == 2);
        prop_assert!(net.answers.iter().all(|(ok, _)| *ok), "{:?}", net.answers);
        for run in 0..2 {
            prop_assert_eq!(net.eaten_digest(run), calm.eaten_digest(0));
        }
    }

    #[test]
    fn a_lost_producer_freezes_all_at_one_frame_and_says_so(
        seed in 1u64.., at in 100u64..1200, consumer in any::<bool>(),
    ) {
        let name = if consumer { "smdfm" } else { "traffic-generator" };
        let mut net = Net::new(seed, 10, 1.0, false);
        net.run(at * MS + 20_000 * MS, vec![(at * MS, Act::Kill(name))]);
        prop_assert_eq!(net.reached.last().map(|r| r.0), Some(Phase::Frozen), "{:?}", net.reached);
        let state = net.conductor.state();
        prop_assert!(state.reasons[0].contains(name), "{:?}", state.reasons);
        let mut batch = Net::new(seed, 10, f64::INFINITY, true);
        batch.run(MINUTE, vec![(3 * MS + at * 10_000, Act::Kill(name))]);
        prop_assert_eq!(batch.exit, Some(1));
    }
}

const ALL: [&str; 3] = ["external-world", "smdfm", "traffic-generator"];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_pair_lost_together_is_named_and_nobody_else(
        seed in 1u64..,
        at_ms in 5u64..1500,
        gap_us in prop_oneof![0u64..3_000, 0u64..600_000],
        first in 0usize..3,
        second in 1usize..3,
        told in any::<bool>(),
    ) {
        let pair = [ALL[first], ALL[(first + second) % 3]];
        let mut net = Net::with(seed, 10, 1.0, false, |config| {
            config.stall_ns = 2_000 * MS;
        });
        net.run_until_running();
        let act = |told, name| if told { Act::Kill(name) } else { Act::Vanish(name) };
        let at = net.now + at_ms * MS;
        net.run(
            at + 10_000 * MS,
            vec![(at, act(told, pair[0])), (at + gap_us * 1000, Act::Kill(pair[1]))],
        );
        prop_assert_eq!(net.conductor.phase(), Phase::Frozen, "{:?}", net.reached);
        let reasons = net.conductor.state().reasons;
        prop_assert_eq!(reasons.len(), 2, "{:?}", reasons);
        for name in pair {
            prop_assert!(reasons.iter().any(|r| r.starts_with(name)), "{:?}", reasons);
        }
        for (name, member) in net.members.iter().filter(|(_, m)| m.federate().consumes()) {
            prop_assert_eq!(member.executed(), net.conductor.stand(), "{}", name);
        }
        net.obey(Command::Stop);
        prop_assert_eq!(net.closed.len(), 1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn a_run_goes_on_without_its_visitors_and_says_since_when(seed in 1u64.., at_ms in 5u64..1500) {
        let mut calm = Net::new(1, 0, f64::INFINITY, true);
        calm.run(MINUTE, vec![]);
        let with_visitors = |seed| {
            Net::with(seed, 10, 2.0, true, |config| config.optional = vec!["visitors".into()])
        };
        let mut whole = with_visitors(seed);
        whole.run(MINUTE, vec![]);
        prop_assert_eq!((whole.exit, whole.value(0, "visits")), (Some(0), (2 * LAST - 3) as f64));
        let mut net = with_visitors(seed);
        net.run_until_running();
        let at = net.now + at_ms * MS;
        net.run(MINUTE, vec![(at, Act::Kill("visitors"))]);
        prop_assert_eq!(net.exit, Some(0));
        prop_assert!(net.reached.iter().all(|r| r.0 != Phase::Frozen), "{:?}", net.reached);
        let said = &net.closed[0].reasons;
        prop_assert!(said.len() == 1 && said[0].starts_with("degraded since frame "), "{:?}", said);
        let visits = net.value(0, "visits");
        prop_assert!(visits < (2 * LAST - 3) as f64 && visits as u64 + 24 > at_ms / 25 * 2, "{}", visits);
        for net in [&whole, &net] {
            prop_assert_eq!(net.eaten_digest(0), calm.eaten_digest(0));
        }
    }
}

#[test]
fn a_command_at_the_wrong_time_is_refused_with_what_is_possible() {
    let mut net = Net::new(3, 0, 1.0, false);
    net.run(2, vec![(2, Act::Command(Command::Freeze))]);
    net.run_until_running();
    let at = net.now;
    net.run(
        at + 500 * MS,
        vec![
            (at, Act::Command(Command::Start)),
            (at + 10 * MS, Act::Command(Command::Step { n: 1 })),
            (at + 20 * MS, Act::Command(Command::Rate { rate: -1.0 })),
        ],
    );
    assert_eq!(net.answers.len(), 4);
    assert!(net.answers.iter().all(|(ok, _)| !ok), "{:?}", net.answers);
    assert!(net.answers[0].1.contains("not possible while INIT"), "{:?}", net.answers);
    assert!(net.answers[1].1.contains("freeze, stop"), "{:?}", net.answers);
    assert_eq!(net.conductor.phase(), Phase::Running, "what was refused changed nothing");
}

/// As a script: nobody dies, everybody works, and the run is frozen for longer than any patience.
#[test]
fn a_run_frozen_for_an_hour_steps_and_goes_on() {
    for stall_ms in [50, 2_000] {
        let mut net = Net::with(5, 0, 1.0, false, |config| config.stall_ns = stall_ms * MS);
        net.run_until_running();
        net.run(net.now + 300 * MS, vec![]);
        net.obey(Command::Freeze);
        let frozen = net.conductor.frame();
        net.run(net.now + 60 * MINUTE, vec![]);
        net.obey(Command::Step { n: 20 });
        assert_eq!(
            net.answers.last().map(|a| a.1.clone()),
            Some(format!("frozen at frame {}", frozen + 20))
        );
        net.run(net.now + 60 * MINUTE, vec![]);
        net.obey(Command::Start);
        net.run_for_until(10 * MINUTE, |net| net.closed.len() == 1);
        assert!(net.closed[0].reasons.is_empty(), "{:?}", net.closed[0].reasons);
    }
}

#[test]
fn a_producer_lost_before_its_first_frame_holds_nobody_up() {
    let lost = "traffic-generator";
    let mut net = Net::new(13_406_712_465_736_579_652, 10, f64::INFINITY, true);
    net.run(MINUTE, vec![(7_300_000, Act::Kill(lost))]);
    assert_eq!(net.exit, Some(1));
    let reasons = &net.conductor.state().reasons;
    assert!(reasons.len() == 1 && reasons[0].contains(lost), "{reasons:?}");
}

#[test]
fn a_stopped_run_does_not_wait_for_the_reports_of_the_dead() {
    let mut net = Net::new(3, 0, 1.0, false);
    net.run_until_running();
    let at = net.now;
    net.run(at + 1, vec![(at, Act::Command(Command::Stop))]);
    net.run_until(|net| net.conductor.phase() == Phase::Stopped);
    assert!(net.closed.is_empty(), "the reports are still on their way");
    let at = net.now;
    let dead = ["external-world", "smdfm", "traffic-generator"];
    net.run(at + MS, dead.map(|name| (at, Act::Kill(name))).to_vec());
    assert_eq!(net.closed.len(), 1, "closed at once, not after the patience for reports");
    assert_eq!(net.closed[0].reasons.len(), 3, "{:?}", net.closed[0].reasons);
}
