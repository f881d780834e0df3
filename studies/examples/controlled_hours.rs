//! Hours of traffic without failures that models of controllers clear on tracks, on airports and with seeds of one's choice: who is served, what
//! traffic has to keep, and every alert that was raised, each of which is one too many.
//!
//! `cargo run --release -p studies --example controlled_hours -- [--movements N] [--seeds A..B] [--control KEYS] [--watch CALLSIGN] [--clearances] [--quiet] AIRPORT|LAYOUT …`
#![allow(clippy::print_stdout, reason = "a tool for the terminal")]

use models::control::alert::{Alert, AlertKind, Change};
use models::control::parameters::Parameters;
use models::control::scoring::{self, Told};
use models::control::situation::{Situation, Target};
use models::traffic::core::{Core, Direction};
use models::traffic::exact::Watch;
use scenarios::hours::{self, Hour};
use scenarios::{Scene, template, vary};
use std::collections::BTreeMap;
use studies::clearing::{Scanned, Tower};
use studies::watched::{Book, layout};

struct Options {
    movements: f64,
    seeds: (u64, u64),
    /// More keys of `[control]`.
    control: String,
    watch: String,
    clearances: bool,
    quiet: bool,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut options = Options {
        movements: 24.0,
        seeds: (31, 31),
        control: String::new(),
        watch: String::new(),
        clearances: false,
        quiet: false,
    };
    let mut airports = Vec::new();
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut next = || args.next().unwrap_or_default();
        match arg.as_str() {
            "--movements" => options.movements = next().parse()?,
            "--control" => options.control = next(),
            "--watch" => options.watch = next(),
            "--clearances" => options.clearances = true,
            "--quiet" => options.quiet = true,
            "--seeds" => {
                let text = next();
                let (a, b) = text.split_once("..").unwrap_or((&text, &text));
                options.seeds = (a.parse()?, b.parse()?);
            }
            _ => airports.push(arg),
        }
    }
    for airport in &airports {
        for seed in options.seeds.0..=options.seeds.1 {
            match scene(airport, seed, &options) {
                Ok(scene) => controlled(airport, &scene, seed, &options)?,
                Err(why) => println!("{airport} seed {seed}: {why}"),
            }
        }
    }
    Ok(())
}

/// The scene that `seeds scene new` makes, with its controllers.
fn scene(airport: &str, seed: u64, options: &Options) -> Result<Scene, Box<dyn std::error::Error>> {
    let path = scenarios::locate("zurich").with_file_name("controlled.toml");
    let wanted = template::Wanted {
        layout: template::layout_of(airport).unwrap_or_else(|| airport.to_owned()),
        path: path.clone(),
        minutes: 60.0,
        per_h: options.movements,
    };
    let (text, _) = template::scene(&wanted)?;
    let control = format!(
        "\n[control]\nsees = \"tracks\"\ncontrollers = \"model\"\n{}\n",
        options.control.replace(';', "\n")
    );
    let text = vary::with_key(&(text + &control), "run.seed", &seed.to_string())?;
    Ok(scenarios::load_text(&path, &text)?)
}

/// What is told beside a tower, and what of it is looked at.
struct Seen<'a> {
    tower: Tower<'a>,
    on_truth: Watch,
    exact: Book,
    tracked: Book,
    /// By alert on tracks: where it was raised, and of whom.
    about: BTreeMap<u32, String>,
    watch: String,
}

impl Seen<'_> {
    fn frame(&mut self, core: &mut Core, frame: i64) {
        let Some(Scanned { now, targets, told }) = self.tower.frame(core, frame) else { return };
        for (change, alert) in self.on_truth.scan(core, now) {
            self.exact.enter(now, *change, alert);
        }
        self.exact.look(core, now);
        for (change, alert) in &told {
            self.tracked.enter(now, *change, alert);
            if *change == Change::Raised {
                self.about.insert(alert.id, about(core, alert, &targets));
            }
        }
        self.tracked.look(core, now);
        let watched = |s: &&Situation| s.target.callsign.is_some_and(|c| c.as_str() == self.watch);
        let surveillance = self.tower.net().net().surveillance();
        for s in surveillance.situations().iter().filter(watched) {
            println!(
                "{:8.1} track {} at {:.0} {:.0}, {:.1} m/s, mean {:.1}, strips {:b}, fast {:?}, {:?}, still since {:.0}, {:?}",
                now.s(),
                s.target.number,
                s.target.position_m.x,
                s.target.position_m.y,
                s.speed_mps,
                s.mean_mps,
                s.strips,
                s.fast,
                s.on_final,
                s.still_since.s(),
                s.doubt
            );
        }
        let watched = (0..core.flights().len()).find(|f| core.flights()[*f].callsign == self.watch);
        if let Some(f) = watched.filter(|f| core.wants(*f).is_some()) {
            println!("{:8.1} wants {:?}, waits for {:?}", now.s(), core.wants(f), core.waiting(f));
        }
    }
}

/// Where an alert is, what its tracks are, and where who they are really is.
fn about(core: &Core, alert: &Alert, targets: &[Target]) -> String {
    use models::control::alert::Subject;
    let place = alert.condition.place_m;
    let mut text = format!("at {:.0} {:.0}", place.x, place.y);
    let (a, b) = alert.condition.subjects;
    for subject in [Some(a), b].into_iter().flatten() {
        let Subject::Track(number) = subject else { continue };
        let Some(t) = targets.iter().find(|t| t.number == number) else { continue };
        let states = (0..core.flights().len()).filter_map(|f| Some((f, core.state(f)?)));
        let nearest = states
            .map(|(f, s)| (f, (s.position_m.xy() - t.position_m).norm(), s.velocity_mps.norm()))
            .min_by(|x, y| x.1.total_cmp(&y.1));
        let Some((f, off_m, mps)) = nearest else { continue };
        text += &format!(
            " | track {number} {:.1} m/s, alt {:?}: {} {:?} {off_m:.1} m off, {mps:.1} m/s",
            t.velocity_mps.norm(),
            t.altitude_m.map(f64::round),
            core.flights()[f].callsign,
            core.phase(f),
        );
        if alert.condition.kind == AlertKind::StandOccupied {
            text += &format!(" | {}", at_stand(core, f, targets));
        }
    }
    text
}

/// Who is within 60 m of a flight's stand, in truth and as tracks.
fn at_stand(core: &Core, flight: usize, targets: &[Target]) -> String {
    let stand = core.stand(flight);
    let at_m = core.stand_m(stand);
    let mut text = format!("stand {}", core.network().stands[stand].name);
    for f in (0..core.flights().len()).filter(|f| *f != flight) {
        let Some(s) = core.state(f) else { continue };
        let off_m = (s.position_m.xy() - at_m).norm();
        if off_m < 60.0 {
            let name = &core.flights()[f].callsign;
            text += &format!(", {name} {:?} {off_m:.1} m", core.phase(f));
        }
    }
    for t in targets.iter().filter(|t| (t.position_m - at_m).norm() < 60.0) {
        let off_m = (t.position_m - at_m).norm();
        let name = t.callsign.map_or(String::new(), |c| c.as_str().to_owned());
        text += &format!(", track {} {name} {off_m:.1} m", t.number);
    }
    text
}

fn controlled(
    airport: &str,
    scene: &Scene,
    seed: u64,
    options: &Options,
) -> Result<(), Box<dyn std::error::Error>> {
    let behaving = scene.traffic.behaving.as_ref().ok_or("nobody flies there")?;
    let mut seen = Seen {
        tower: Tower::new(scene, seed)?,
        on_truth: Watch::new(layout(scene), Parameters::default(), scene.control.stop_bars)
            .in_visibility(scene.visibility_m()),
        exact: Book::default(),
        tracked: Book::default(),
        about: BTreeMap::new(),
        watch: options.watch.clone(),
    };
    let looks = Hour { seed, every: 10, drain_s: 2700.0, stopping: 0.0 };
    let held = hours::hour(behaving, &scene.run, &scene.airport.layout, &looks, |core, frame| {
        core.step(frame);
        seen.frame(core, frame);
    })
    .ok_or("no truth")?;
    let core = &held.core;
    let count = core.flights().len();
    let (reference, found) = (seen.exact.list(), seen.tracked.list());
    let mut counts = [0; 3];
    let mut lines = Vec::new();
    for (id, told) in &seen.tracked.0 {
        let alone = scoring::score(&reference, std::slice::from_ref(told));
        let any = |of: fn(&scoring::KindScore) -> u32| alone.iter().any(|s| of(s) > 0);
        let verdict = match () {
            () if any(|s| s.false_alerts) => 0,
            () if any(|s| s.nuisance_alerts) => 1,
            () => 2,
        };
        counts[verdict] += 1;
        let about = seen.about.get(id).map_or("", |a| a);
        lines.push(line(told, ["false", "nuisance", "true"][verdict], about));
    }
    let missed: Vec<&Told> = reference
        .iter()
        .filter(|t| scoring::score(std::slice::from_ref(*t), &found).iter().any(|s| s.missed() > 0))
        .collect();
    lines.extend(missed.iter().map(|t| line(t, "missed", "")));
    let around: u32 = (0..count).map(|f| core.measures(f).go_arounds).sum();
    let extra = |direction: Direction| {
        let of = (0..count).filter(|f| core.flights()[*f].direction == direction);
        let all: Vec<f64> = of.filter_map(|f| core.measures(f).additional_s()).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    let (words, kept_s) = seen.tower.controllers().cost();
    let broken: Vec<String> = held
        .rows
        .iter()
        .filter(|r| !r.kept)
        .map(|r| format!("{} {:.4}", r.name, r.value))
        .collect();
    println!(
        "{airport} seed {seed}: served {}/{count}{}, rings {}, broken [{}], alerts false {} nuisance {} true {} missed {}, go-arounds {around}, \
         out +{:.0} s, in +{:.0} s, on their word {words}, kept back {kept_s} s",
        core.measures_of_served(),
        held.served_s.map_or(String::new(), |t| format!(" by {t:.0} s")),
        core.unexpected_deadlocks(),
        broken.join(", "),
        counts[0],
        counts[1],
        counts[2],
        missed.len(),
        extra(Direction::Departure),
        extra(Direction::Arrival),
    );
    if options.clearances {
        for c in core.clearances() {
            let until = c.until_s.unwrap_or(f64::INFINITY);
            let name = &core.flights()[c.flight].callsign;
            println!(
                "{:8.1}-{until:.1} {} {name} {} at {:?}",
                c.from_s, c.kind, c.runway, c.place_m
            );
        }
    }
    if options.quiet {
        return Ok(());
    }
    lines.iter().for_each(|line| println!("    {line}"));
    for row in held.rows.iter().filter(|r| !r.kept) {
        row.cases.iter().take(4).for_each(|case| println!("    BROKEN {}: {case}", row.name));
    }
    let served = |f: usize| core.measures(f).aibt_s.is_some() || core.measures(f).atot_s.is_some();
    for f in (0..count).filter(|f| !served(*f)) {
        let flight = &core.flights()[f];
        println!(
            "    not served: {} {:?} due {:.0} s, stand {}, {:?}, wants {:?}, waits for {:?}",
            flight.callsign,
            flight.direction,
            flight.time_s,
            behaving.network.stands[core.stand(f)].name,
            core.phase(f),
            core.wants(f),
            core.waiting(f)
        );
    }
    Ok(())
}

fn line(told: &Told, verdict: &str, about: &str) -> String {
    format!(
        "{:8.1}-{:.0} {verdict} {} {}, nearest {:?} m, {about}",
        told.on_s,
        told.end_s,
        told.kind,
        told.subjects.join(" "),
        told.nearest_m.map(f64::round)
    )
}
