//! `seeds sim`: a scene's federation in one thread under drawn faults, over a simulated clock, bus and ether.
//!
//! The oracle is the run of the same scene and seed that nothing happens to: members die and are started
//! again, stand still and are cut off, messages and PDUs are lost; in the end every digest must be the same.

use crate::control::Control;
use crate::external_world::ExternalWorld;
use crate::federation::{RunOptions, conductor_config};
use crate::runtime::cli::{self, BAD_INPUT, COMPLETE, FAILED, fail, load_scene, out};
use crate::runtime::conductor::ConductorConfig;
use crate::runtime::federate::Federate;
use crate::runtime::messages::{Command, Kind};
use crate::runtime::simulation::{Fault, MS, Make, Network, Simulation, What};
use crate::smdfm::Smdfm;
use crate::traffic_generator::TrafficGenerator;
use clap::Args;
use scenarios::Scene;
use scenarios::losses::{ByMember, Losses, OnLoss};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Run a scene's federation under drawn faults in simulated time, and compare every digest
#[derive(Args, Clone, Debug)]
pub struct SimArgs {
    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(value_name = "SCENE", default_value = "zurich")]
    scene: String,

    /// Seeds of the faults, first to last
    #[arg(long, value_name = "A..B", default_value = "1..20", value_parser = seeds_of)]
    seeds: (u64, u64),

    /// Simulated duration of each run, s
    #[arg(long, value_name = "S", default_value_t = 20.0, value_parser = cli::seconds)]
    duration: f64,

    /// Faults of this file (JSON, as a failing seed prints them) instead of drawn ones
    #[arg(long, value_name = "FILE")]
    faults: Option<PathBuf>,

    /// A table of what each kind of fault costs, instead of drawn ones
    #[arg(long)]
    table: bool,

    /// Only the rows of the table whose names hold this
    #[arg(long, value_name = "WORD", requires = "table")]
    only: Option<String>,
}

fn seeds_of(text: &str) -> Result<(u64, u64), String> {
    let parts = text.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match parts {
        Some((a, b)) if a <= b => Ok((a, b)),
        _ => Err(format!("'{text}' is not a range of seeds like 1..100")),
    }
}

/// Digests by member and name.
pub(super) type Digests = Vec<(String, String, u64)>;

/// Runs the seeds; ends with 1 at the first that does not come to the same result.
#[must_use]
pub fn run(args: &SimArgs) -> ExitCode {
    let scene = match load_scene(&args.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    let given = match &args.faults {
        None => None,
        Some(file) => match read_faults(file) {
            Ok(faults) => Some(faults),
            Err(e) => return fail(BAD_INPUT, format!("{}: {e}", file.display())),
        },
    };
    let trial = Trial::new(scene, args.duration);
    let whole = match trial.undisturbed() {
        Ok(whole) => whole,
        Err(why) => return fail(FAILED, why),
    };
    if args.table {
        return match super::fault_table::print(&trial, &whole, args.only.as_deref()) {
            Ok(()) => ExitCode::from(COMPLETE),
            Err(why) => fail(BAD_INPUT, why),
        };
    }
    let mut seen = BTreeMap::new();
    for seed in args.seeds.0..=args.seeds.1 {
        let faults = given.clone().unwrap_or_else(|| trial.draw(seed));
        let Err(why) = trial.holds(seed, &faults, &whole, &mut seen) else { continue };
        let least = shrink(&faults, |fewer| {
            is_mended(fewer) && trial.holds(seed, fewer, &whole, &mut BTreeMap::new()).is_err()
        });
        let text = serde_json::to_string(&least).unwrap_or_default();
        out!("{text}");
        return fail(
            FAILED,
            format!(
                "seed {seed}: {why}; again with: seeds sim {} --duration {} --seeds {seed}..{seed} --faults FILE (the line on standard output)",
                args.scene, args.duration
            ),
        );
    }
    for (what, count) in seen {
        out!("{count:>9} {what}");
    }
    ExitCode::from(COMPLETE)
}

fn read_faults(file: &std::path::Path) -> anyhow::Result<Vec<Fault>> {
    Ok(serde_json::from_str(&std::fs::read_to_string(file)?)?)
}

/// Whether everybody who dies is started again, and the last word of an operator is to go on.
fn is_mended(faults: &[Fault]) -> bool {
    let again = |fault: &Fault| {
        let starts = |f: &&Fault| f.who == fault.who && f.what == What::Start;
        let dies = matches!(fault.what, What::Kill | What::Vanish);
        !dies || faults.iter().filter(starts).any(|f| f.at_ns > fault.at_ns)
    };
    let orders = faults.iter().filter(|f| matches!(f.what, What::Command(_)));
    let last = orders.max_by_key(|f| f.at_ns);
    faults.iter().all(again) && last.is_none_or(|f| f.what == What::Command(Command::Start))
}

/// The fewest of `faults` that `fails` is still true of: halves, then single ones are left out.
fn shrink(faults: &[Fault], fails: impl Fn(&[Fault]) -> bool) -> Vec<Fault> {
    let mut least = faults.to_vec();
    let mut size = least.len();
    while size > 0 {
        let mut at = 0;
        while at < least.len() {
            let mut fewer = least.clone();
            fewer.drain(at..(at + size).min(least.len()));
            if fails(&fewer) {
                least = fewer;
            } else {
                at += size;
            }
        }
        size /= 2;
    }
    least
}

/// A scene that is run again and again.
pub struct Trial {
    scene: Arc<Scene>,
    duration_s: f64,
}

impl Trial {
    /// Of a scene, for so many simulated seconds.
    #[must_use]
    pub fn new(scene: Arc<Scene>, duration_s: f64) -> Self {
        Self { scene, duration_s }
    }

    pub(super) fn simulation(
        &self,
        seed: u64,
        rate: f64,
        batch: bool,
        network: Network,
        losses: &Losses,
    ) -> Simulation {
        let options = RunOptions {
            duration_s: Some(self.duration_s),
            rate,
            generators: 2,
            batch,
            losses: losses.clone(),
            ..RunOptions::default()
        };
        let config = ConductorConfig { fed: 1, ..conductor_config(&self.scene, &options) };
        let kind = |name: &String| match &**name {
            "external-world" => Kind::ExternalWorld,
            "smdfm" => Kind::Smdfm,
            "control" => Kind::Control,
            _ => Kind::TrafficGenerator,
        };
        let kinds: Vec<_> = config.expected.iter().map(|n| (n.clone(), kind(n))).collect();
        let (scene, exercise) = (Arc::clone(&self.scene), self.scene.run.exercise);
        let make: Make = Arc::new(move |name: &str| -> Box<dyn Federate> {
            let scene = Arc::clone(&scene);
            match name {
                "external-world" => Box::new(ExternalWorld::new(scene, exercise)),
                "smdfm" => Box::new(Smdfm::new(scene, exercise)),
                "control" => Box::new(Control::new(scene)),
                name => {
                    let share = if name.ends_with("-2") { 2 } else { 1 };
                    Box::new(TrafficGenerator::new(scene, exercise, share, 2))
                }
            }
        });
        Simulation::new(seed, config, &kinds, make, network)
    }

    /// The digests of the run that nothing happens to.
    ///
    /// # Errors
    /// If even that does not end.
    pub fn undisturbed(&self) -> Result<Digests, String> {
        let network = Network { delay_ns: MS, bus_loss: 0, udp_loss: 0, twice: 0 };
        let mut simulation = self.simulation(1, f64::INFINITY, true, network, &Losses::default());
        simulation.run(600_000 * MS, &[]);
        match simulation.closed.len() {
            1 => Ok(simulation.digests(0)),
            _ => {
                Err(format!("the undisturbed run does not end: {:?}", simulation.conductor.state()))
            }
        }
    }

    /// Faults of a seed: one to three members die or are interrupted, close together or not, and are started
    /// again; in some seeds while they join, while an operator freezes the run, or under `takeover`.
    #[must_use]
    pub fn draw(&self, seed: u64) -> Vec<Fault> {
        let mut dice = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut draw = move |below: u64| {
            dice ^= dice << 13;
            dice ^= dice >> 7;
            dice ^= dice << 17;
            (dice >> 11) % below
        };
        let names = ["external-world", "smdfm", "traffic-generator-1", "traffic-generator-2"];
        let joining = seed % 6 == 5;
        let mut at_ns = match joining {
            true => draw(60 * MS),
            false => (100 + draw((self.duration_s * 400.0) as u64)) * MS,
        };
        let mut faults = Vec::new();
        if seed % 5 == 4 {
            let order =
                |at_ns, command| Fault { at_ns, who: String::new(), what: What::Command(command) };
            let freeze_ns = (100 + draw((self.duration_s * 400.0) as u64)) * MS;
            faults.push(order(freeze_ns, Command::Freeze));
            faults.push(order(freeze_ns + draw(3_000) * MS, Command::Step { n: 1 + draw(30) }));
            // One of them is after the last return.
            for after_s in [3, 20, 40, 55] {
                faults.push(order(freeze_ns + after_s * 1_000 * MS, Command::Start));
            }
        }
        for _ in 0..=draw(3) {
            let who = names[draw(4) as usize].to_owned();
            let for_ns = (50 + draw(6_000)) * MS;
            let what = match draw(8) {
                0 | 1 => What::Kill,
                2 => What::Vanish,
                3 => What::Pause(for_ns),
                4 => What::Cut(for_ns),
                5 => What::Deaf(for_ns),
                6 => What::Slow(for_ns),
                _ => What::Mute(for_ns),
            };
            if matches!(what, What::Kill | What::Vanish) {
                // Where others take its place, somebody comes only where there is nobody left.
                let late_ns = if takes_over(seed) && who != "smdfm" { 8_000 * MS } else { 0 };
                let again_ns = at_ns + late_ns + (300 + draw(6_000)) * MS;
                faults.push(Fault { at_ns: again_ns, who: who.clone(), what: What::Start });
            }
            faults.push(Fault { at_ns, who, what });
            at_ns += if draw(2) == 0 { draw(50) } else { draw(4_000) } * MS;
        }
        faults
    }

    /// Whether the run under `faults` ends as the undisturbed one did; counts what happened into `seen`.
    ///
    /// # Errors
    /// What did not hold.
    pub fn holds(
        &self,
        seed: u64,
        faults: &[Fault],
        whole: &Digests,
        seen: &mut BTreeMap<&'static str, u64>,
    ) -> Result<(), String> {
        let losses = if takes_over(seed) { taking_over() } else { Losses::default() };
        self.holds_with(seed, faults, whole, seen, &losses)
    }

    fn holds_with(
        &self,
        seed: u64,
        faults: &[Fault],
        whole: &Digests,
        seen: &mut BTreeMap<&'static str, u64>,
        losses: &Losses,
    ) -> Result<(), String> {
        let network = Network {
            delay_ns: [MS / 10, 3 * MS, 20 * MS][(seed % 3) as usize],
            bus_loss: if seed.is_multiple_of(2) { 0 } else { seed % 100 },
            udp_loss: seed % 300,
            twice: 100,
        };
        let mut simulation = self.simulation(seed, 2.0, false, network, losses);
        let until = (self.duration_s * 500.0) as u64 * MS + 90_000 * MS;
        simulation.run_to_close(until, faults);
        for (what, count) in &simulation.seen {
            *seen.entry(what).or_default() += count;
        }
        if let Some(broken) = simulation.broken.first() {
            return Err(broken.clone());
        }
        if simulation.closed.len() != 1 || simulation.closed[0].failed {
            let state = simulation.conductor.state();
            let waits = state.members.iter().filter_map(|m| {
                let member = simulation.member(&m.name)?;
                Some(format!("{}: {}", m.name, member.waits_for().join("; ")))
            });
            let waits = waits.collect::<Vec<_>>().join("\n");
            return Err(format!("it does not end: {state:?}\n{waits}"));
        }
        let digests = simulation.digests(0);
        if digests != *whole {
            return Err(format!("digests {digests:x?}, undisturbed {whole:x?}"));
        }
        Ok(())
    }
}

/// Whoever is lost is replaced.
fn taking_over() -> Losses {
    let on_loss = ByMember { all: Some(OnLoss::TakeOver), ..ByMember::default() };
    Losses { on_loss, ..Losses::default() }
}

/// Whether a seed's run replaces who is lost.
fn takes_over(seed: u64) -> bool {
    seed % 4 == 3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forty seeds of the shipped scene's first seconds; a thousand and more by the command.
    #[test]
    fn whatever_befalls_a_federation_its_digests_are_those_of_the_undisturbed_run() {
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let trial = Trial::new(Arc::new(scene), 20.0);
        let whole = trial.undisturbed().expect("it ends");
        let mut seen = BTreeMap::new();
        for seed in 1..=40 {
            let faults = trial.draw(seed);
            if let Err(why) = trial.holds(seed, &faults, &whole, &mut seen) {
                panic!("seed {seed}: {why} under {faults:?}");
            }
        }
        for what in ["seal", "cut", "view that waits", "admit", "outcast", "frozen by a fault"] {
            assert!(seen.get(what).is_some_and(|n| *n >= 5), "{what} was hardly reached: {seen:?}");
        }
    }

    /// Seeds that failed once: number, and the fewest faults that did it.
    #[test]
    fn what_failed_once_holds() {
        let fault = |at_ms: u64, who: &str, what: What| Fault {
            at_ns: at_ms * MS,
            who: who.to_owned(),
            what,
        };
        let (smdfm, second) = ("smdfm", "traffic-generator-2");
        let cases = [
            (
                639,
                vec![
                    fault(7174, "external-world", What::Mute(442 * MS)),
                    fault(8150, smdfm, What::Kill),
                    fault(8184, second, What::Pause(4136 * MS)),
                    fault(12004, smdfm, What::Start),
                ],
            ),
            (175, vec![fault(322, smdfm, What::Vanish), fault(3_000, smdfm, What::Start)]),
        ];
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let trial = Trial::new(Arc::new(scene), 20.0);
        let whole = trial.undisturbed().expect("it ends");
        for (seed, faults) in cases {
            let seen = &mut BTreeMap::new();
            let policies = [Losses::default(), taking_over()];
            for losses in policies {
                let held = trial.holds_with(seed, &faults, &whole, seen, &losses);
                held.unwrap_or_else(|why| panic!("seed {seed}, {losses:?}: {why}"));
            }
        }
    }

    #[test]
    fn what_is_shrunk_still_fails_and_has_nothing_that_could_go() {
        let fault = |at_ns| Fault { at_ns, who: "smdfm".into(), what: What::Kill };
        let faults: Vec<Fault> = (1..=9).map(fault).collect();
        let fails = |f: &[Fault]| [3, 7].iter().all(|at| f.iter().any(|f| f.at_ns == *at));
        assert_eq!(shrink(&faults, fails), [fault(3), fault(7)]);
    }
}
