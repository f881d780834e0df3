//! `seeds accuracy --only control`: what a sensor set, a profile and a confirmation make of the safety net's alerts.
//!
//! Traffic of an airport with failures is driven once; the alerts of the rules on its exact truth are the reference. Each
//! sensor looks at it once, each profile tracks what the sensors of a set saw, and the safety net judges these tracks.

use crate::control_found::{CONFIRMATIONS, Flown, Found, PROFILES, SETS, wrong};
use crate::control_picture::{grid, verdict};
use crate::watched::{Book, Frames, layout, movements, net_on_tracks, target};
use crate::{Draws, Ladder, Options, Outcome, Progress, Row, SceneAbout, Table, clock, zurich};
use models::control::parameters::Parameters;
use models::control::scoring::{in_all, score};
use models::control::situation::Target;
use models::environment::Weather;
use models::fusion::{Tracker, TrackingConfig};
use models::plot::{Plot, SensorId};
use models::sensors::{PlotSink, ScanInterval};
use models::time::SimTime;
use models::traffic::core::{Direction, Flight};
use models::traffic::exact::Watch;
use scenarios::{ScenarioError, Scene};
use std::fmt::Write;

/// Name of the group.
pub const GROUP: &str = "control";

/// Airports: name, files, movements an hour each way.
pub const AIRPORTS: [(&str, &str, u32); 6] = [
    ("LZIB", "layout = \"airports/LZIB.apt.dat\"", 12),
    ("XSYN", "layout = \"airports/XSYN.apt.dat\"", 10),
    (
        "LIMC",
        "layout = \"airports/LIMC.apt.dat\"\nground_network = \"airports/LIMC.groundnet.xml\"",
        16,
    ),
    (
        "LSZH",
        "layout = \"airports/LSZH.apt.dat\"\nground_network = \"airports/LSZH.groundnet.xml\"",
        16,
    ),
    (
        "EHAM",
        "layout = \"airports/EHAM.apt.dat\"\nground_network = \"airports/EHAM.groundnet.xml\"",
        20,
    ),
    ("EGCC", "layout = \"airports/EGCC.nodes.csv\"", 12),
];

/// What fails in turn with every third flight: kinds of `[[failure]]`.
#[derive(Clone, Copy, Debug)]
pub struct Failing {
    /// Of arrivals.
    pub arrivals: &'static [&'static str],
    /// Of departures.
    pub departures: &'static [&'static str],
}

/// What people do wrong: what the study measures.
pub const BY_PEOPLE: Failing = Failing {
    arrivals: &[
        "forget_landing_clearance",
        "vehicle_on_runway",
        "wrong_turn",
        "conflicting_clearance",
        "blown_tyre",
    ],
    departures: &[
        "pass_hold",
        "take_off_uncleared",
        "push_uncleared",
        "no_reply",
        "conflicting_clearance",
    ],
};

/// Nothing.
pub const NOTHING: Failing = Failing { arrivals: &[], departures: &[] };

/// Every kind of failure, that of equipment too.
pub const OF_ALL_KINDS: Failing = Failing {
    arrivals: &[
        "stop",
        "forget_landing_clearance",
        "transponder",
        "vehicle_on_runway",
        "wrong_turn",
        "engine",
        "conflicting_clearance",
        "blown_tyre",
    ],
    departures: &[
        "wrong_runway",
        "stop",
        "pass_hold",
        "take_off_uncleared",
        "stop_bar",
        "push_uncleared",
        "wrong_turn",
        "transponder",
        "no_reply",
        "engine",
        "conflicting_clearance",
    ],
};

const ABOUT: &str = "Each scene is an hour of generated traffic in which something goes wrong with every third flight: passed holds, \
take-offs, landings and pushes without clearance, wrong turns, a car on the runway, clearances that exclude each other, stopped \
aircraft. Stop bars are in use. The alerts of the rules on exact truth are the reference: detected is raised on tracks within 3 s (so that no response is longer), \
of the same kind and subjects; false has no true one within 10 s; a nuisance is true by rule and came to nothing. The sites of \
the sensors are assumed: a Ku band radar on the tower, a second one mirrored about the airport's middle, eight stations of \
multilateration around it and one under each final, nine in ten aircraft with ADS-B. An alert about a track without a name is right of nobody. Time: \
processor time of a scan of sensors, tracker and safety net. Goals: 99 % detected, response 1 s (median) and 3 s (95 %), one false \
alert per 100 movements; a nuisance is one on exact truth, too, and says nothing of the sensors: those that are about no failure are counted apart.";

/// A scene in which things go wrong, watched by every sensor of the sets.
///
/// # Errors
/// If the scene is refused.
pub fn text(
    airport: &str,
    rate: u32,
    seed: u64,
    seconds: f64,
    failing: Failing,
) -> Result<String, ScenarioError> {
    let base = format!(
        "[run]\ntitle = \"control\"\nseed = {seed}\nduration_s = {seconds}\n[airport]\n{airport}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = {rate}\ndepartures_per_h = {rate}\n[control]\nstop_bars = true\n"
    );
    let scene = read(&base)?;
    let layout = &scene.airport.layout;
    let tower = layout.tower.map_or([0.0, 0.0], |(at, _)| [at.x, at.y]);
    let flights: &[Flight] = scene.traffic.behaving.as_ref().map_or(&[], |b| &b.flights);
    Ok(format!(
        "{base}{}{}{}[[sensor]]\nkind = \"adsb\"\nname = \"ADS-B\"\nequipped = 0.9\n",
        failures(flights, failing),
        scenarios::control::standard_sensors(layout, scene.airport.radius_m),
        scenarios::control::second_radar("ASDE far", layout, tower),
    ))
}

/// Something for every third flight.
fn failures(flights: &[Flight], failing: Failing) -> String {
    let (mut out, mut arrivals, mut departures) = (String::new(), 0, 0);
    for flight in flights.iter().skip(1).step_by(3) {
        let (kinds, count) = match flight.direction {
            Direction::Arrival => (failing.arrivals, &mut arrivals),
            Direction::Departure => (failing.departures, &mut departures),
            Direction::Vehicle => continue,
        };
        let Some(kind) = kinds.get(*count % kinds.len().max(1)) else { continue };
        *count += 1;
        let _ = write!(out, "[[failure]]\nkind = \"{kind}\"\ncallsign = \"{}\"\n", flight.callsign);
    }
    out
}

/// Reads a text of [`text`]; airports that ship are named from the folder of the scenes.
///
/// # Errors
/// If it is refused.
pub fn read(text: &str) -> Result<Scene, ScenarioError> {
    let path = scenarios::locate("zurich").with_file_name("control.toml");
    scenarios::load_text(&path, text)
}

/// A tracker on the plots of a set, with a safety net for each confirmation.
struct Chain {
    set: usize,
    profile: usize,
    sensors: Vec<SensorId>,
    tracker: Tracker,
    nets: Vec<(Watch, Book)>,
    /// Processor time of sensors and tracker, ns, and of each net.
    ns: f64,
    net_ns: Vec<f64>,
}

fn chains(scene: &Scene, text: &str) -> Result<Vec<Chain>, String> {
    let number = |name: &&str| scene.sensors.iter().find(|s| s.name == **name).map(|s| s.id);
    let mut chains = Vec::new();
    for (profile, word) in PROFILES.iter().enumerate() {
        let text = scenarios::vary::with_key(text, "tracking.profile", word)?;
        let config = read(&text).map_err(|e| e.to_string())?.tracking_config();
        for (set, (_, names)) in SETS.iter().enumerate() {
            let sensors: Vec<SensorId> = names.iter().filter_map(number).collect();
            let mut config: TrackingConfig = config.clone();
            config.sensors.retain(|model| sensors.contains(&model.id));
            let net = |scans: &u32| (net_on_tracks(scene, *scans), Book::default());
            chains.push(Chain {
                set,
                profile,
                sensors,
                tracker: Tracker::new(config),
                nets: CONFIRMATIONS.iter().map(net).collect(),
                ns: 0.0,
                net_ns: vec![0.0; CONFIRMATIONS.len()],
            });
        }
    }
    Ok(chains)
}

/// Drives a scene and judges it on truth and by every chain.
fn fly(text: &str, seed: u64) -> Result<Flown, String> {
    let scene = read(text).map_err(|e| e.to_string())?;
    let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves")?;
    let mut core = behaving.core(&scene.run, seed).ok_or("no truth")?;
    let mut chains = chains(&scene, text)?;
    let mut sensors = zurich::sensors(&scene)?;
    let mut watch = Watch::new(layout(&scene), Parameters::default(), scene.control.stop_bars)
        .in_visibility(scene.visibility_m());
    let (mut exact, mut truth_ns) = (Book::default(), 0.0);
    let mut frames = Frames::of(&scene, behaving.first_entity);
    let (per_scan, weather) = (u64::from(scene.run.frames_per_scan), Weather::default());
    let scans = scene.run.frames() / per_scan;
    let spent = |since: i64| (clock::thread_ns() - since) as f64;
    for frame in 1..=scans * per_scan {
        core.step(frame as i64);
        let now = SimTime(frame as i64 * scene.run.frame.0);
        frames.take(&core, now);
        if !frame.is_multiple_of(per_scan) {
            continue;
        }
        let begin = clock::thread_ns();
        let told = watch.scan(&core, now).to_vec();
        truth_ns += spent(begin);
        told.iter().for_each(|(change, alert)| exact.enter(now, *change, alert));
        exact.look(&core, now);
        let from = SimTime(now.0 - per_scan as i64 * scene.run.frame.0);
        let interval = ScanInterval { run_seed: seed, scan: frame / per_scan, from, to: now };
        let looks: Vec<(SensorId, Vec<Plot>, f64)> = sensors
            .iter_mut()
            .map(|sensor| {
                let (mut sink, begin) = (PlotSink::default(), clock::thread_ns());
                sensor.scan(&interval, &frames, &weather, &mut sink);
                (sensor.id(), sink.plots, spent(begin))
            })
            .collect();
        for chain in &mut chains {
            let mut plots = Vec::new();
            for (_, seen, ns) in looks.iter().filter(|l| chain.sensors.contains(&l.0)) {
                plots.extend(seen.iter().cloned());
                chain.ns += ns;
            }
            let begin = clock::thread_ns();
            let tracks = chain.tracker.scan(now, &plots, &scene.flight_list);
            let mut targets: Vec<Target> = tracks.iter().map(|t| target(&scene, t)).collect();
            targets.sort_by_key(|t| t.number);
            chain.ns += spent(begin);
            for ((net, book), ns) in chain.nets.iter_mut().zip(&mut chain.net_ns) {
                let begin = clock::thread_ns();
                let told = net.scan_targets(&core, now, &targets);
                *ns += spent(begin);
                told.iter().for_each(|(change, alert)| book.enter(now, *change, alert));
            }
        }
        frames.clear();
    }
    let (movements, reference) = (movements(&core), exact.list());
    let us = |ns: f64| ns * 1e-3 / scans.max(1) as f64;
    let found = chains.iter().flat_map(|chain| {
        let each = chain.nets.iter().zip(&chain.net_ns).enumerate();
        each.map(|(confirm, ((_, book), net_ns))| Found {
            set: chain.set,
            profile: chain.profile,
            confirm,
            score: in_all(&score(&reference, &book.list())),
            us_per_scan: us(chain.ns + net_ns),
            wrong: wrong(&reference, &book.list(), core.shown()),
        })
    });
    let hours = scans as f64 * per_scan as f64 * scene.run.frame.s() / 3600.0;
    Ok(Flown { hours, movements, truth_us: us(truth_ns), found: found.collect() })
}

fn rung(found: &Found) -> String {
    let confirmed = if CONFIRMATIONS[found.confirm] > 1 { ", 2 of 2" } else { "" };
    format!("{}, {}{confirmed}", SETS[found.set].0, PROFILES[found.profile])
}

fn rows(scene: &str, flown: &Flown) -> Vec<Row> {
    let row = |rung: String, wrong: u32, us: f64| Row {
        group: GROUP.into(),
        scene: scene.into(),
        rung,
        error: (flown.hours > 0.0).then(|| f64::from(wrong) / flown.hours),
        error_unit: Some("missed, false or nuisance an hour".into()),
        ns_per_update: Some(us * 1e3),
        ..Row::default()
    };
    let truth = Row {
        needs: Some("exact truth in place of tracks".into()),
        ..row("exact truth".into(), 0, flown.truth_us)
    };
    let of = |f: &Found| {
        let wrong = f.score.missed() + f.score.false_alerts + f.score.nuisance_alerts;
        row(rung(f), wrong, f.us_per_scan)
    };
    std::iter::once(truth).chain(flown.found.iter().map(of)).collect()
}

const HEADS: [&str; 20] = [
    "scene",
    "sensors",
    "profile",
    "confirm_scans",
    "hours",
    "movements",
    "true",
    "detected",
    "detected_percent",
    "response_median_s",
    "response_95_percent_s",
    "missed",
    "false",
    "false_per_hour",
    "false_per_100_movements",
    "nuisance",
    "nuisance_per_100_movements",
    "nuisance_of_no_failure",
    "nuisance_of_no_failure_per_100_movements",
    "us_per_scan",
];

fn lines(scene: &str, flown: &Flown) -> Vec<Vec<String>> {
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.3}"));
    let line = |f: &Found| {
        let s = &f.score;
        let hundred = |n: u32| {
            (flown.movements > 0).then(|| 100.0 * f64::from(n) / f64::from(flown.movements))
        };
        let share =
            (s.reference > 0).then(|| 100.0 * f64::from(s.detected) / f64::from(s.reference));
        vec![
            scene.to_owned(),
            SETS[f.set].0.to_owned(),
            PROFILES[f.profile].to_owned(),
            CONFIRMATIONS[f.confirm].to_string(),
            format!("{:.3}", flown.hours),
            flown.movements.to_string(),
            s.reference.to_string(),
            s.detected.to_string(),
            number(share),
            number(s.response_s(0.5)),
            number(s.response_s(0.95)),
            s.missed().to_string(),
            s.false_alerts.to_string(),
            number(Some(f64::from(s.false_alerts) / flown.hours)),
            number(hundred(s.false_alerts)),
            s.nuisance_alerts.to_string(),
            number(hundred(s.nuisance_alerts)),
            f.unprovoked().to_string(),
            number(hundred(f.unprovoked())),
            number(Some(f.us_per_scan)),
        ]
    };
    flown.found.iter().map(line).collect()
}

/// Heads of the table of what was missed or is none.
const WRONG_HEADS: [&str; 9] = [
    "scene",
    "sensors",
    "profile",
    "confirm_scans",
    "time_s",
    "verdict",
    "kind",
    "subjects",
    "failure",
];

fn wrong_lines(scene: &str, flown: &Flown) -> Vec<Vec<String>> {
    let of = |f: &Found, one: &[String; 5]| {
        let confirm = CONFIRMATIONS[f.confirm].to_string();
        let head =
            [scene.to_owned(), SETS[f.set].0.to_owned(), PROFILES[f.profile].to_owned(), confirm];
        head.iter().chain(one).cloned().collect()
    };
    flown.found.iter().flat_map(|f| f.wrong.iter().map(move |one| of(f, one))).collect()
}

/// Which choice is good enough, and what the cheapest of these is, in a sentence.
fn finding(flown: &Flown) -> String {
    let mut good: Vec<&Found> =
        flown.found.iter().filter(|f| verdict(f, flown).iter().all(|met| *met)).collect();
    good.sort_by(|a, b| a.us_per_scan.total_cmp(&b.us_per_scan));
    match good.first() {
        Some(one) => format!(
            "Of {} choices {} meet all goals over {} movements; the cheapest of them is {} ({:.0} µs a scan).",
            flown.found.len(),
            good.len(),
            flown.movements,
            rung(one),
            one.us_per_scan
        ),
        None => {
            let met = |f: &&Found| verdict(f, flown).iter().filter(|met| **met).count();
            let nearest = flown.found.iter().max_by(|a, b| {
                let share = |f: &Found| f64::from(f.score.detected);
                met(a).cmp(&met(b)).then(share(a).total_cmp(&share(b)))
            });
            let near = nearest.map_or_else(String::new, |f| {
                format!(
                    "; nearest is {} ({} of {} detected, {} false, {} nuisance)",
                    rung(f),
                    f.score.detected,
                    f.score.reference,
                    f.score.false_alerts,
                    f.score.nuisance_alerts
                )
            });
            format!("No choice meets all goals over {} movements{near}.", flown.movements)
        }
    }
}

/// Measures the group.
pub fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let (airports, seconds) =
        if options.quick { (&AIRPORTS[..1], 1200.0) } else { (&AIRPORTS[..], 3600.0) };
    let seeds = options.scenes.filter(|_| options.only.is_some()).unwrap_or(1).max(1);
    let total = airports.len() * seeds as usize;
    let mut outcome = Outcome {
        ladder: Ladder {
            group: GROUP.into(),
            title: "Alerts of the safety net, by sensor set, profile and confirmation".into(),
            error_label: "missed, false or nuisance alerts an hour".into(),
            draws: Draws::Other,
            unit: "an hour".into(),
            ..Ladder::default()
        },
        ..Outcome::default()
    };
    let mut table = Table {
        name: GROUP.into(),
        title: "Alerts by scene, sensor set, profile and confirmation".into(),
        heads: HEADS.map(str::to_owned).to_vec(),
        rows: Vec::new(),
    };
    let mut named = Table {
        name: "control-alerts".into(),
        title: "Alerts that were missed, false or a nuisance".into(),
        heads: WRONG_HEADS.map(str::to_owned).to_vec(),
        rows: Vec::new(),
    };
    let (mut sum, mut done): (Option<Flown>, usize) = (None, 0);
    for (name, files, rate) in airports {
        let mut scene: Option<Flown> = None;
        for seed in (0..seeds).map(|k| options.seed.saturating_add(k)) {
            let flown = text(files, *rate, seed, seconds, BY_PEOPLE).map_err(|e| e.to_string());
            match flown.and_then(|text| fly(&text, seed)) {
                Ok(flown) => scene = Some(scene.map_or_else(|| flown.clone(), |s| s.and(&flown))),
                Err(e) => outcome.rows.push(Row {
                    group: GROUP.into(),
                    scene: (*name).into(),
                    rung: format!("seed {seed}"),
                    failed: vec![e],
                    ..Row::default()
                }),
            }
            done += 1;
            progress(Progress { group: GROUP, what: format!("{name}, seed {seed}"), done, total });
        }
        let Some(flown) = scene else { continue };
        outcome.rows.extend(rows(name, &flown));
        table.rows.extend(lines(name, &flown));
        named.rows.extend(wrong_lines(name, &flown));
        sum = Some(sum.map_or_else(|| flown.clone(), |s| s.and(&flown)));
    }
    if let Some(all) = sum {
        outcome.ladder.about = ABOUT.into();
        outcome.said = Some(finding(&all));
        let about = format!("{} movements, {:.1} h", all.movements, all.hours);
        outcome.ladder.scenes.push(SceneAbout { name: "all".into(), about });
        let once = Flown {
            found: all.found.iter().filter(|f| CONFIRMATIONS[f.confirm] == 1).cloned().collect(),
            ..all.clone()
        };
        outcome.rows.extend(rows("all", &once));
        outcome.pictures.push(grid(&all));
        table.rows.extend(lines("all", &all));
    }
    outcome.tables.extend([table, named]);
    outcome
}
