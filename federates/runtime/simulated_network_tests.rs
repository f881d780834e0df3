//! Toy federates in the simulated federation: messages and PDUs are delayed, reordered, doubled and lost by
//! seed, members die, stand still and come back; the laws of the protocol must hold all the same.

mod connections;
mod losses;
mod pace;
mod returns;
mod station;

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

/// A batch under `takeover`, with control.
fn taking_over(rate: f64) -> ConductorConfig {
    let mut config = with_control(rate);
    config.batch = true;
    config.losses.on_loss = on_loss_flag("takeover").expect("a policy");
    config
}
