//! A scene that is run again and again in the simulated network, with faults that a seed draws.

use super::guests::Guests;
use crate::control::Control;
use crate::external_world::ExternalWorld;
use crate::federation::{RunOptions, conductor_config, has_control, is_front_end};
use crate::runtime::conductor::ConductorConfig;
use crate::runtime::federate::Federate;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::messages::{Command, Kind};
use crate::runtime::simulation::{Event, Fault, MS, Make, Network, STANDBY, Simulation, What};
use crate::smdfm::Smdfm;
use crate::smdfm::front_end::FrontEnd;
use crate::traffic_generator::TrafficGenerator;
use scenarios::Scene;
use scenarios::losses::{ByMember, Losses, OnLoss};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Digests by member and name.
pub(super) type Digests = Vec<(String, String, u64)>;

/// A scene that is run again and again.
pub struct Trial {
    scene: Arc<Scene>,
    duration_s: f64,
    visitors: bool,
    smdfms: u32,
}

impl Trial {
    /// Of a scene, for so many simulated seconds.
    #[must_use]
    pub fn new(scene: Arc<Scene>, duration_s: f64) -> Self {
        Self { scene, duration_s, visitors: false, smdfms: 1 }
    }

    /// The same, or with an outsider.
    #[must_use]
    pub fn with_visitors(self, visitors: bool) -> Self {
        Self { visitors, ..self }
    }

    /// The same with so many SMDFMs.
    #[must_use]
    pub fn with_smdfms(self, smdfms: u32) -> Self {
        Self { smdfms, ..self }
    }

    /// The last frame of its runs.
    fn last_frame(&self) -> u64 {
        let options = RunOptions { duration_s: Some(self.duration_s), ..RunOptions::default() };
        conductor_config(&self.scene, &options).last_frame
    }

    /// Members that may be lost, by name.
    pub(super) fn names(&self) -> Vec<&'static str> {
        let mut names =
            vec!["external-world", "smdfm", "traffic-generator-1", "traffic-generator-2"];
        if has_control(&self.scene) {
            names.push("control");
        }
        names.extend(["smdfm-2", "smdfm-3"].iter().take(self.smdfms as usize - 1));
        names
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
            smdfms: self.smdfms,
            batch,
            visitors: self.visitors,
            losses: losses.clone(),
            ..RunOptions::default()
        };
        let config = ConductorConfig { fed: 1, ..conductor_config(&self.scene, &options) };
        let kind = |name: &String| match &**name {
            "external-world" => Kind::ExternalWorld,
            name if name == "smdfm" || is_front_end(name) => Kind::Smdfm,
            "control" => Kind::Control,
            "visitors" => Kind::Visitors,
            _ => Kind::TrafficGenerator,
        };
        let guests = config.optional.iter().filter(|_| self.visitors);
        let all = config.expected.iter().chain(guests);
        let kinds: Vec<_> = all.map(|n| (n.clone(), kind(n))).collect();
        let (scene, exercise) = (Arc::clone(&self.scene), self.scene.run.exercise);
        let smdfms = self.smdfms;
        let make: Make = Arc::new(move |name: &str| -> Box<dyn Federate> {
            let scene = Arc::clone(&scene);
            match name {
                "external-world" => Box::new(ExternalWorld::new(scene, exercise)),
                "smdfm" => Box::new(Smdfm::new(scene, exercise)),
                "control" => Box::new(Control::new(scene, exercise)),
                "visitors" => Box::new(Guests::new(scene)),
                name if is_front_end(name) => {
                    let share = name.bytes().last().map_or(2, |b| u32::from(b - b'0'));
                    Box::new(FrontEnd::new(scene, exercise, share, smdfms))
                }
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
            _ => Err(format!(
                "the undisturbed run does not end: {:?}",
                simulation.conductor().state()
            )),
        }
    }

    /// Faults of a seed: one to three members die or are interrupted, close together or not, and are started
    /// again; in some seeds while they join, while an operator freezes the run, under `takeover` with places that move, with the station, or
    /// with the station and its standby.
    ///
    /// On top of that, by `More`: faults that are aimed at what the protocol does, bursts of loss, a disk that is full,
    /// strangers and intruders, and an operator.
    #[must_use]
    pub fn draw(&self, seed: u64) -> Vec<Fault> {
        let mut faults = self.draw_losses(seed);
        self.draw_more(seed, &mut faults);
        faults
    }

    fn draw_losses(&self, seed: u64) -> Vec<Fault> {
        let mut draw = dice(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let names = self.names();
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
            let who = names[draw(names.len() as u64) as usize].to_owned();
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
                let taken = !who.starts_with("smdfm") && who != "control";
                let late_ns = if takes_over(seed) && taken { 8_000 * MS } else { 0 };
                let again_ns = at_ns + late_ns + (300 + draw(6_000)) * MS;
                faults.push(Fault { at_ns: again_ns, who: who.clone(), what: What::Start });
            }
            faults.push(Fault { at_ns, who, what });
            at_ns += if draw(2) == 0 { draw(50) } else { draw(4_000) } * MS;
        }
        if seed % 3 == 1 {
            // The station dies as well, and is started again with its journal.
            let aimed = faults.iter().map(|fault| fault.at_ns).collect::<Vec<_>>();
            for _ in 0..=draw(2) {
                let near = aimed[draw(aimed.len() as u64) as usize] + draw(700) * MS;
                let anywhere = draw((self.duration_s * 500.0) as u64) * MS;
                let at_ns = if draw(2) == 0 { near } else { anywhere };
                let who = CONDUCTOR.to_owned();
                faults.push(Fault { at_ns, who: who.clone(), what: What::Kill });
                let at_ns = at_ns + (20 + draw(3_000)) * MS;
                faults.push(Fault { at_ns, who, what: What::Start });
            }
        }
        if has_standby(seed) {
            return self.with_stations(faults, &mut draw);
        }
        if takes_over(seed) {
            // Places go from process to process by command, near a fault or anywhere.
            let places = ["external-world", "traffic-generator-1", "traffic-generator-2"];
            for _ in 0..draw(4) {
                let near = faults[draw(faults.len() as u64) as usize].at_ns + draw(700) * MS;
                let anywhere = draw((self.duration_s * 500.0) as u64) * MS;
                let at_ns = if draw(2) == 0 { near } else { anywhere };
                let from = draw(3);
                let to = (from + 1 + draw(2)) % 3;
                let [name, to] = [from, to].map(|place| places[place as usize].to_owned());
                let what = What::Command(Command::Move { name, to });
                faults.push(Fault { at_ns, who: String::new(), what });
            }
        }
        faults
    }

    /// A standby is there, and the station is lost, with or without a member, or the two lose each other. Members that die otherwise too take
    /// their voices with them, so then both stations are started again.
    fn with_stations(&self, others: Vec<Fault>, draw: &mut impl FnMut(u64) -> u64) -> Vec<Fault> {
        let fault =
            |at_ms: u64, who: &str, what| Fault { at_ns: at_ms * MS, who: who.to_owned(), what };
        let names = self.names();
        // It is found within four seconds, by each for itself.
        let mut faults = vec![fault(draw(500), STANDBY, What::Start)];
        let at_ms = 5_000 + draw((self.duration_s * 250.0) as u64);
        let long_ms = 100 + draw(7_000);
        let for_ns = long_ms * MS;
        let kind = draw(10);
        let member = names[draw(names.len() as u64) as usize];
        let near_ms = at_ms + draw(600);
        match kind {
            0 => faults.push(fault(at_ms, CONDUCTOR, What::Kill)),
            1 => {
                faults.push(fault(at_ms, CONDUCTOR, What::Kill));
                faults.push(fault(at_ms + long_ms, CONDUCTOR, What::Start));
            }
            2 => faults.push(fault(at_ms, CONDUCTOR, What::Pause(for_ns))),
            3 => faults.push(fault(at_ms, CONDUCTOR, What::Cut(for_ns))),
            4 => faults.push(fault(at_ms, CONDUCTOR, What::Deaf(for_ns))),
            5 => faults.push(fault(at_ms, CONDUCTOR, What::Mute(for_ns))),
            6 => {
                faults.push(fault(at_ms, CONDUCTOR, What::Vanish));
                faults.push(fault(near_ms, member, What::Kill));
                faults.push(fault(near_ms + 300 + draw(5_000), member, What::Start));
            }
            // As many voters on each side, or one more here or there.
            7 | 8 => {
                let few = names.len() / 2 - 1 + draw(3) as usize;
                let from = draw(names.len() as u64) as usize;
                let with = names.iter().cycle().skip(from).take(few);
                let with = with.map(|name| (*name).to_owned()).collect();
                faults.push(fault(at_ms, CONDUCTOR, What::Part(with, for_ns)));
            }
            _ => {
                let what = [What::Kill, What::Pause(for_ns), What::Cut(for_ns)];
                faults.push(fault(at_ms, STANDBY, what[draw(3) as usize].clone()));
                faults.push(fault(at_ms + long_ms, STANDBY, What::Start));
                let again_ms = at_ms + long_ms + draw(4_000);
                faults.push(fault(again_ms, CONDUCTOR, What::Kill));
                faults.push(fault(again_ms + draw(3_000), CONDUCTOR, What::Start));
            }
        }
        if draw(3) == 0 {
            faults.extend(others);
        } else if draw(2) == 0 {
            // Who stood down, or was lost, is the standby of the other from then on.
            for after_ms in [long_ms + 500, long_ms + 4_000] {
                faults.push(fault(at_ms + after_ms, CONDUCTOR, What::Start));
            }
        }
        for after_ms in [25_000, 26_000, 40_000, 41_000, 50_000] {
            faults.push(fault(after_ms, CONDUCTOR, What::Start));
            faults.push(fault(after_ms, STANDBY, What::Start));
        }
        faults
    }

    /// What [`More`] adds for a seed.
    fn draw_more(&self, seed: u64, faults: &mut Vec<Fault>) {
        let mut draw = dice(seed.wrapping_mul(0xd134_2543_de82_ef95) | 1);
        let draw = &mut draw;
        (0..4).for_each(|_| _ = draw(2));
        let names = self.names();
        let member =
            |draw: &mut dyn FnMut(u64) -> u64| names[draw(names.len() as u64) as usize].to_owned();
        let within_ms = (self.duration_s * 400.0) as u64;
        let fault =
            |at_ms: u64, who: &str, what| Fault { at_ns: at_ms * MS, who: who.to_owned(), what };
        let command = |at_ms: u64, command| fault(at_ms, "", What::Command(command));
        let standby = has_standby(seed);
        // It is started again with its journal.
        let station_dies = standby || seed % 3 == 1;
        match more(seed) {
            More::Nothing => {}
            More::Aimed => {
                let mut aimed = Vec::new();
                for _ in 0..3 + draw(3) {
                    // Where there is a standby, half of them at what stations do.
                    let event = AIMS[match standby && draw(2) == 0 {
                        true => 8 + draw(2),
                        false => draw(8),
                    } as usize];
                    let who = match draw(4) {
                        0 if station_dies => CONDUCTOR.to_owned(),
                        _ => member(draw),
                    };
                    // One that dies at a frame too often is not taken back.
                    let deaths = faults.iter().filter(|f| f.who == who && f.what == What::Kill);
                    if aimed.contains(&who) || deaths.count() > 1 {
                        continue;
                    }
                    let for_ns = (50 + draw(5_000)) * MS;
                    let what = match draw(6) {
                        0..=2 => What::Kill,
                        3 => What::Pause(for_ns),
                        4 => What::Cut(for_ns),
                        _ => What::Mute(for_ns),
                    };
                    let late_ns = draw(4) * draw(2_000_000);
                    faults.push(fault(1, &who, What::Aimed(event, late_ns, Box::new(what))));
                    let at_end = matches!(event, Event::Finish | Event::Final);
                    let from_ms = if at_end { 40_000 } else { 11_000 };
                    for again in 0..3 {
                        let at_ms = from_ms + 7_000 * again + draw(3_000);
                        faults.push(fault(at_ms, &who, What::Start));
                    }
                    aimed.push(who);
                }
            }
            More::Bursts => {
                for _ in 0..5 + draw(20) {
                    let mut ends = [member(draw), member(draw)];
                    if draw(2) == 0 {
                        ends[0] =
                            if standby && draw(2) == 0 { STANDBY } else { CONDUCTOR }.to_owned();
                    }
                    let [a, b] = if draw(2) == 0 { [1, 0] } else { [0, 1] };
                    let what = What::Burst(ends[b].clone(), (100 + draw(1_900)) * MS);
                    faults.push(fault(100 + draw(within_ms), &ends[a], what));
                }
            }
            More::Disk => {
                // A station without a journal is not made again: only the copy of a standby may be lost where it dies.
                let who = if standby { STANDBY } else { CONDUCTOR };
                let at_ms = 1 + draw(within_ms);
                let what = match draw(2) {
                    0 => What::Full,
                    _ => What::Aimed(AIMS[draw(5) as usize], 0, Box::new(What::Full)),
                };
                faults.push(fault(at_ms, who, what));
                // Wherever nothing was lost until then.
                faults.push(fault(within_ms, who, What::Full));
                if !standby {
                    faults.retain(|f| {
                        f.who != who || f.what == What::Full || matches!(f.what, What::Aimed(..))
                    });
                }
            }
            More::Strangers => {
                for _ in 0..4 {
                    let what = What::Stranger { build: draw(2) == 0 };
                    faults.push(fault(50 + draw(within_ms), &member(draw), what));
                }
            }
            More::Another => {
                let at_ms = 2_000 + draw(within_ms);
                let smdfm = "smdfm";
                faults.retain(|f| f.who != smdfm);
                faults.push(fault(at_ms, smdfm, What::Kill));
                faults.push(fault(at_ms + 300 + draw(1_500), smdfm, What::Another));
                for after_ms in [5_000, 9_000, 20_000, 45_000] {
                    faults.push(fault(at_ms + after_ms, smdfm, What::Start));
                }
            }
            More::Intruder => {
                for _ in 0..=draw(3) {
                    let what = What::Intruder((500 + draw(4_000)) * MS);
                    faults.push(fault(1 + draw(within_ms), "", what));
                }
            }
            More::Operator => {
                for _ in 0..3 + draw(6) {
                    let rate = [0.5, 1.0, 3.0, 8.0, 30.0][draw(5) as usize];
                    faults.push(command(200 + draw(within_ms), Command::Rate { rate }));
                }
                let at_ms = 500 + draw(within_ms);
                if draw(2) == 0 {
                    faults.push(command(at_ms, Command::Freeze));
                    faults.push(command(at_ms + 100 + draw(1_500), Command::Restart));
                } else {
                    let again = Box::new(What::Command(Command::Restart));
                    let late_ns = draw(3) * draw(20) * MS;
                    faults.push(fault(1, "", What::Aimed(Event::Finish, late_ns, again)));
                }
                for after_s in [3, 20, 40, 55] {
                    faults.push(command(at_ms + after_s * 1_000, Command::Start));
                }
            }
        }
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
        self.holds_with(seed, faults, whole, seen, &losses)?;
        // Odd: with messages lost; some of them with places taken over.
        if seed % 10 == 7 {
            let [once, twice] = [(); 2].map(|()| self.run(seed, faults, &losses).trace);
            if once != twice {
                return Err(format!("the same run twice: {once:016x} and {twice:016x}"));
            }
            *seen.entry("the same run twice").or_default() += 1;
        }
        Ok(())
    }

    /// The run of a seed under `faults`, to its end.
    fn run(&self, seed: u64, faults: &[Fault], losses: &Losses) -> Simulation {
        let network = Network {
            delay_ns: [MS / 10, 3 * MS, 20 * MS][(seed % 3) as usize],
            bus_loss: match seed {
                _ if seed.is_multiple_of(2) => 0,
                // Every word waits for the standby, which asks again for what is lost after a second.
                _ if faults.iter().any(|fault| fault.who == STANDBY) => seed % 20,
                _ => seed % 100,
            },
            udp_loss: seed % 300,
            twice: 100,
        };
        let mut simulation = self.simulation(seed, 2.0, false, network, losses);
        let until = (self.duration_s * 500.0) as u64 * MS + 90_000 * MS;
        simulation.run_to_end(until, faults);
        simulation
    }

    pub(super) fn holds_with(
        &self,
        seed: u64,
        faults: &[Fault],
        whole: &Digests,
        seen: &mut BTreeMap<&'static str, u64>,
        losses: &Losses,
    ) -> Result<(), String> {
        let simulation = self.run(seed, faults, losses);
        for (what, count) in &simulation.seen {
            *seen.entry(what).or_default() += count;
        }
        if let Some(broken) = simulation.broken.first() {
            return Err(broken.clone());
        }
        let last = simulation.closed.len().wrapping_sub(1);
        if !simulation
            .closed
            .get(last)
            .is_some_and(|run| !run.failed && run.frame >= self.last_frame())
        {
            let state = simulation.conductor().state();
            let waits = state.members.iter().filter_map(|m| {
                let member = simulation.member(&m.name)?;
                Some(format!("{}: {}", m.name, member.waits_for().join("; ")))
            });
            let waits = waits.collect::<Vec<_>>().join("\n");
            let stations = simulation.stations().join("\n");
            return Err(format!("it does not end: {state:?}\n{waits}\n{stations}"));
        }
        let mut digests = simulation.digests(last);
        let mut whole = whole.clone();
        let reasons = simulation.closed[last].reasons.iter();
        if self.visitors && reasons.clone().any(|r| r.contains(": visitors ")) {
            // The outsider is gone since then: all else is as it was.
            *seen.entry("without outsiders since a frame").or_default() += 1;
            for digests in [&mut digests, &mut whole] {
                digests.retain(|(of, name, _)| of != "visitors" && name != "foreign");
            }
        }
        if digests != whole {
            return Err(format!("digests {digests:x?}, undisturbed {whole:x?}"));
        }
        Ok(())
    }
}

/// What befalls a seed's run beside losses of members and messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum More {
    /// Nothing.
    Nothing,
    /// Processes die, stand still or are cut off when the protocol does something.
    Aimed,
    /// On links, one way each, nothing passes for up to two seconds.
    Bursts,
    /// The disk of the station, or of its standby, is full.
    Disk,
    /// Processes of another build or scene ask to be let in.
    Strangers,
    /// An SMDFM returns that makes another run.
    Another,
    /// Forged messages on both planes.
    Intruder,
    /// The pace changes, and the run is begun again.
    Operator,
}

/// What a fault may be aimed at; the last two where there is a standby.
const AIMS: [Event; 10] = [
    Event::Seal,
    Event::Sealed,
    Event::Cut,
    Event::Held,
    Event::View,
    Event::Admit,
    Event::Finish,
    Event::Final,
    Event::Candidacy,
    Event::Leads,
];

/// What befalls the run of a seed beside losses.
pub(super) fn more(seed: u64) -> More {
    match seed.wrapping_mul(0x9e37_79b9) >> 7 & 15 {
        0..=3 => More::Aimed,
        4 | 5 => More::Bursts,
        // Where the station dies it needs its journal.
        6 if has_standby(seed) || seed % 3 != 1 => More::Disk,
        6 | 7 => More::Strangers,
        8 => More::Another,
        9 | 10 => More::Intruder,
        11 | 12 => More::Operator,
        _ => More::Nothing,
    }
}

/// A die of its own: each throw below a number.
fn dice(mut dice: u64) -> impl FnMut(u64) -> u64 {
    move |below: u64| {
        dice ^= dice << 13;
        dice ^= dice >> 7;
        dice ^= dice << 17;
        (dice >> 11) % below
    }
}

/// Whoever is lost is replaced.
pub(super) fn taking_over() -> Losses {
    let on_loss = ByMember { all: Some(OnLoss::TakeOver), ..ByMember::default() };
    Losses { on_loss, ..Losses::default() }
}

/// Whether a seed's run replaces who is lost.
pub(super) fn takes_over(seed: u64) -> bool {
    seed % 4 == 3
}

/// Whether a seed's run has a standby.
pub(super) fn has_standby(seed: u64) -> bool {
    seed % 7 == 2 || seed % 7 == 5
}
