//! Runs the traffic of scenes and prints every control alert, on its exact truth and, with `--tracks`, on the tracks of
//! the scene's sensors and tracker, with the score of the second against the first. Several seeds: `--seeds A..B`.
//!
//! `cargo run --release -p studies --example alerts -- [--tracks] [--quiet] [--clearances] [--watch CALLSIGN] [--sensors NAMES] [--seeds A..B] [--seconds S] SCENE…`
//!
//! A scene that has an `.expect.json` beside it is held against it.
//!
//! With `--failing people` (`all`, `nobody`, or one kind of failure) airports stand in place of scenes (a name of the study `control`, or a layout file): an
//! hour of the study's traffic there, in which that goes wrong, by radar and multilateration; `--rate N` movements an hour each way, and with
//! `--controllers` models clear it on its tracks. `--sensors "ASDE tower,MLAT"`: watched by these of its sensors alone.
#![allow(clippy::print_stdout, reason = "a tool for the terminal")]

use models::control::alert::{Alert, Change};
use models::control::parameters::Parameters;
use models::control::scoring::{self, Told};
use models::control::situation::Target;
use models::environment::Weather;
use models::fusion::Tracker;
use models::plot::Callsign;
use models::sensors::{PlotSink, ScanInterval};
use models::time::SimTime;
use models::traffic::core::{Core, Shown};
use models::traffic::exact::Watch;
use scenarios::control::Sees;
use scenarios::{ScenarioError, Scene};
use std::collections::BTreeMap;
use studies::clearing::Controllers;
use studies::control::{self, BY_PEOPLE, Failing, NOTHING, OF_ALL_KINDS};
use studies::expected::{Expected, cause};
use studies::watched::{Book, Frames, layout, movements, net_on_tracks, target};

/// What sees the study's traffic.
const SENSORS: [&str; 2] = ["ASDE tower", "MLAT"];

struct Options {
    tracks: bool,
    quiet: bool,
    clearances: bool,
    watch: String,
    seconds: f64,
    failing: Option<Failing>,
    rate: Option<u32>,
    /// Names of sensors; all where nothing is named.
    sensors: Vec<String>,
    controllers: bool,
    /// Tracks without a name are taken for who is really there.
    by_place: bool,
}

/// A scene, or the study's traffic at an airport.
fn scene_of(path: &str, seed: Option<u64>, options: &Options) -> Result<Scene, ScenarioError> {
    let Some(failing) = options.failing else { return scenarios::load(&scenarios::locate(path)) };
    let known = control::AIRPORTS.iter().find(|a| a.0 == path);
    let files = known.map_or_else(|| format!("layout = \"{path}\""), |a| a.1.to_owned());
    let rate = options.rate.or(known.map(|a| a.2)).unwrap_or(12);
    let seconds = options.seconds.min(3600.0);
    let text = control::text(&files, rate, seed.unwrap_or(1), seconds, failing)?;
    if options.controllers {
        let sees = "[control]\nsees = \"tracks\"\ncontrollers = \"model\"\n";
        return control::read(&text.replacen("[control]\n", sees, 1));
    }
    control::read(&text)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut options = Options {
        tracks: false,
        quiet: false,
        clearances: false,
        watch: String::new(),
        seconds: f64::INFINITY,
        failing: None,
        rate: None,
        sensors: Vec::new(),
        controllers: false,
        by_place: false,
    };
    let (mut seeds, mut paths) = (None, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--tracks" => options.tracks = true,
            "--quiet" => options.quiet = true,
            "--clearances" => options.clearances = true,
            "--watch" => options.watch = args.next().unwrap_or_default(),
            "--failing" => {
                options.failing = Some(match args.next().as_deref() {
                    Some("all") => OF_ALL_KINDS,
                    Some("people") => BY_PEOPLE,
                    Some("nobody") => NOTHING,
                    Some(kind) if one_kind(kind).is_some() => one_kind(kind).unwrap_or(NOTHING),
                    _ => return Err("--failing: people, all, nobody or a kind of failure".into()),
                });
            }
            "--by-place" => options.by_place = true,
            "--controllers" => options.controllers = true,
            "--sensors" => {
                let names = args.next().unwrap_or_default();
                options.sensors = names.split(',').map(str::to_owned).collect();
            }
            "--rate" => options.rate = Some(args.next().unwrap_or_default().parse()?),
            "--seconds" => options.seconds = args.next().unwrap_or_default().parse()?,
            "--seeds" => {
                let text = args.next().unwrap_or_default();
                let (a, b) = text.split_once("..").unwrap_or((&text, &text));
                seeds = Some(a.parse()?..=b.parse()?);
            }
            _ => paths.push(arg),
        }
    }
    if options.failing.is_some() && options.sensors.is_empty() {
        options.sensors = SENSORS.map(str::to_owned).to_vec();
    }
    let mut sum: BTreeMap<String, scoring::KindScore> = BTreeMap::new();
    let mut served = 0;
    for path in paths {
        let own = match seeds {
            Some(_) => 0,
            None => scene_of(&path, None, &options)?.run.seed,
        };
        for seed in seeds.clone().unwrap_or(own..=own) {
            println!("== {path} seed {seed}");
            let scene = scene_of(&path, Some(seed), &options)?;
            let Ran { moved, shown, raised } = run(&scene, seed, &options, &mut sum)?;
            served += moved;
            let beside = std::path::Path::new(&path).with_extension("expect.json");
            if options.tracks && options.failing.is_none() && beside.is_file() {
                let expected: Expected = serde_json::from_str(&std::fs::read_to_string(beside)?)?;
                let complaints = expected.complaints(&shown, &raised);
                println!("expected: {}", if complaints.is_empty() { "met" } else { "not met" });
                complaints.iter().for_each(|complaint| println!("    {complaint}"));
            }
        }
    }
    if options.tracks {
        println!("== all: {served} movements");
        let mut all = [0_u32; 4];
        for s in sum.values() {
            all[3] += s.nuisance_alerts;
            all = [all[0] + s.reference, all[1] + s.detected, all[2] + s.false_alerts, all[3]];
            let response = |p| s.response_s(p).unwrap_or(f64::NAN);
            println!(
                "{:14} of truth {:4}, detected {:4}, false {:4}, nuisance {:4}, response {:.0} and {:.0} s",
                s.kind,
                s.reference,
                s.detected,
                s.false_alerts,
                s.nuisance_alerts,
                response(0.5),
                response(0.95)
            );
        }
        let rate = 100.0 * f64::from(all[2]) / f64::from(served.max(1));
        println!(
            "all: of truth {}, detected {}, false {} ({rate:.1} per 100 movements), nuisance {}",
            all[0], all[1], all[2], all[3]
        );
    }
    Ok(())
}

/// One kind of failure alone, of every third flight that can fail so.
fn one_kind(kind: &str) -> Option<Failing> {
    let only = |kinds: &'static [&'static str]| {
        let at = kinds.iter().position(|k| *k == kind);
        at.map_or(&[][..], |at| &kinds[at..=at])
    };
    let (arrivals, departures) = (only(OF_ALL_KINDS.arrivals), only(OF_ALL_KINDS.departures));
    (!arrivals.is_empty() || !departures.is_empty()).then_some(Failing { arrivals, departures })
}

fn print(side: &str, now: SimTime, change: Change, alert: &Alert, about: &str) {
    let (kind, stage) = (alert.condition.kind.word(), alert.condition.stage.word());
    let word = match change {
        Change::Raised => "raised",
        Change::Changed => "changed",
        Change::Ended => "ended",
    };
    println!("{:8.1} {side} {word:8} {kind:14} {stage:12} {}{about}", now.s(), alert.subjects());
}

/// Where an alert is and who is really there.
fn about(core: &Core, alert: &Alert, ages: &BTreeMap<u16, u32>, targets: &[Target]) -> String {
    use models::control::alert::Subject;
    let (a, b) = alert.condition.subjects;
    let mut text = String::new();
    for subject in [Some(a), b].into_iter().flatten() {
        let Subject::Track(number) = subject else { continue };
        let Some(t) = targets.iter().find(|t| t.number == number) else { continue };
        let nearest = (0..core.flights().len() + 4)
            .filter_map(|f| {
                let state = core.state(f)?;
                Some((f, (state.position_m.xy() - t.position_m).norm(), state.velocity_mps.norm()))
            })
            .min_by(|x, y| x.1.total_cmp(&y.1));
        let name = |f: usize| {
            let flight = core.flights().get(f).map(|f| f.callsign.clone());
            flight.or_else(|| core.vehicle_name(f).map(str::to_owned)).unwrap_or_default()
        };
        let (who, far_m, v) = nearest.map_or(("".into(), 0.0, 0.0), |(f, d, v)| (name(f), d, v));
        let phase = nearest.and_then(|(f, ..)| (f < core.flights().len()).then(|| core.phase(f)));
        text += &format!(
            " | track {number} of {} scans, {:.1} m/s, alt {:?}, at {:.0} {:.0}; {who} {phase:?} {far_m:.1} m off, {v:.1} m/s",
            ages.get(&number).copied().unwrap_or(0),
            t.velocity_mps.norm(),
            t.altitude_m.map(f64::round),
            t.position_m.x,
            t.position_m.y
        );
    }
    text
}

/// Subjects without a name are those who are really where their tracks are.
fn by_place(core: &Core, alert: &Alert, targets: &[Target], told: &mut Told) {
    use models::control::alert::Subject;
    let (a, b) = alert.condition.subjects;
    for (subject, name) in [Some(a), b].into_iter().flatten().zip([alert.names.0, alert.names.1]) {
        let Subject::Track(number) = subject else { continue };
        let at_m = targets.iter().find(|t| t.number == number).map(|t| t.position_m);
        let (Some(at_m), None) = (at_m, name) else { continue };
        let off_m =
            |m: &usize| core.state(*m).map_or(f64::INFINITY, |s| (s.position_m.xy() - at_m).norm());
        let all = 0..core.flights().len() + CARS;
        let nearest = all.min_by(|a, b| off_m(a).total_cmp(&off_m(b)));
        let Some(m) = nearest.filter(|m| off_m(m) <= THERE_M) else { continue };
        let of_car = || core.vehicle_name(m).map(str::to_owned);
        let named = core.flights().get(m).map(|f| f.callsign.clone()).or_else(of_car);
        let told = told.subjects.iter_mut().find(|s| **s == number.to_string());
        if let (Some(told), Some(named)) = (told, named) {
            *told = named;
        }
    }
    told.subjects.sort();
}

/// A track is that of somebody who is so near to it, m; vehicles of failures that are looked at.
const THERE_M: f64 = 40.0;
const CARS: usize = 4;

/// What came of a scene: movements, failures that showed, alerts on tracks.
struct Ran {
    moved: u32,
    shown: Vec<Shown>,
    raised: Vec<Told>,
}

fn run(
    scene: &Scene,
    seed: u64,
    options: &Options,
    sum: &mut BTreeMap<String, scoring::KindScore>,
) -> Result<Ran, Box<dyn std::error::Error>> {
    let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves in this scene")?;
    let mut core = behaving.core(&scene.run, seed).ok_or("no truth")?;
    let bars = scene.control.stop_bars;
    if options.clearances {
        layout(scene).bars.iter().for_each(|bar| println!("bar {bar:?}"));
    }
    let mut watch =
        Watch::new(layout(scene), Parameters::default(), bars).in_visibility(scene.visibility_m());
    let mut seen = net_on_tracks(scene, scene.control.confirm_scans);
    let mut sensors = if options.tracks { studies::zurich::sensors(scene)? } else { Vec::new() };
    let mut config = scene.tracking_config();
    if !options.sensors.is_empty() {
        let set =
            |id| scene.sensors.iter().any(|s| s.id == id && options.sensors.contains(&s.name));
        sensors.retain(|sensor| set(sensor.id()));
        config.sensors.retain(|model| set(model.id));
    }
    let mut tracker = Tracker::new(config);
    let controlled = scene.control.controllers && scene.control.sees == Sees::Tracks;
    let mut controllers = controlled.then(|| Controllers::new(scene, seed));
    let weather = Weather::default();
    let (mut exact, mut tracked) = (Book::default(), Book::default());
    let mut ages: BTreeMap<u16, u32> = BTreeMap::new();
    let mut lines: BTreeMap<u32, String> = BTreeMap::new();
    let mut who: BTreeMap<u32, Vec<String>> = BTreeMap::new();
    let mut past: BTreeMap<u16, Vec<String>> = BTreeMap::new();
    let mut frames = Frames::of(scene, behaving.first_entity);
    let per_scan = u64::from(scene.run.frames_per_scan);
    let mut errors: BTreeMap<String, [f64; 5]> = BTreeMap::new();
    let last = scene.run.frames().min((options.seconds / scene.run.frame.s()) as u64);
    for frame in 1..=last {
        core.step(frame as i64);
        let now = SimTime(frame as i64 * scene.run.frame.0);
        if options.tracks {
            frames.take(&core, now);
        }
        if !frame.is_multiple_of(per_scan) {
            continue;
        }
        let told = watch.scan(&core, now).to_vec();
        for s in watch.net().surveillance().situations() {
            let own = s.target.callsign.is_some_and(|c| c.as_str() == options.watch);
            if !own {
                continue;
            }
            for (r, axis) in layout(scene).runways.iter().enumerate() {
                let ((p, d), (nose_p, nose_d)) =
                    (axis.place_m(s.target.position_m), axis.place_m(s.nose_m));
                let hold_m = axis.hold_at_m(p, d);
                if d.abs() < 150.0 && (-200.0..axis.length_m + 200.0).contains(&p) {
                    println!(
                        "{:8.1} {} {}: {p:.0} {d:.1}, nose {nose_p:.0} {nose_d:.1}, hold {hold_m:.1}, in {} {:.1} m/s",
                        now.s(),
                        options.watch,
                        axis.names[0],
                        s.in_strip(r),
                        s.speed_mps
                    );
                }
            }
        }
        for (change, alert) in &told {
            exact.enter(now, *change, alert);
            if !options.quiet {
                print("truth ", now, *change, alert, "");
            }
        }
        exact.look(&core, now);
        if !options.tracks {
            continue;
        }
        let scan = frame / per_scan;
        let from = SimTime(now.0 - per_scan as i64 * scene.run.frame.0);
        let interval = ScanInterval { run_seed: seed, scan, from, to: now };
        let mut sink = PlotSink::default();
        sensors.iter_mut().for_each(|s| s.scan(&interval, &frames, &weather, &mut sink));
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let one = errors.entry(format!("{:?}", plot.kind)).or_default();
            one[0] += 1.0;
            let Some(truth) = cause.truth_m else { continue };
            let error = plot.position_m - truth;
            let squared = error.norm_squared();
            one[1] += 1.0;
            one[4] += f64::from(u8::from(squared > 2500.0));
            if squared <= 2500.0 {
                let cov = plot.covariance_m2();
                one[2] += squared;
                one[3] += cov.try_inverse().map_or(0.0, |i| (error.transpose() * i * error).x);
            }
        }
        let tracks = tracker.scan(now, &sink.plots, &scene.flight_list);
        let mut targets: Vec<Target> = tracks.iter().map(|t| target(scene, t)).collect();
        targets.sort_by_key(|t| t.number);
        for t in &targets {
            let age = ages.entry(t.number).or_default();
            *age = if t.first { 1 } else { *age + 1 };
            let own = core
                .flights()
                .iter()
                .position(|f| t.callsign.is_some_and(|c| c == Callsign::new(&f.callsign)));
            let line = past.entry(t.number).or_default();
            if t.first || line.len() > 16 {
                line.drain(..if t.first { line.len() } else { 1 });
            }
            let truth = own.and_then(|f| core.state(f));
            line.push(match truth {
                Some(s) => format!(
                    "{:.0}m {:.0}/{:.0}",
                    (s.position_m.xy() - t.position_m).norm(),
                    t.velocity_mps.norm(),
                    s.velocity_mps.norm()
                ),
                None => format!("? {:.0}", t.velocity_mps.norm()),
            });
        }
        let told = seen.scan_targets(&core, now, &targets).to_vec();
        if let Some(controllers) = &mut controllers {
            controllers.scan(&mut core, frame as i64, &seen);
        }
        // Under his name, or where he is.
        let watched = core.flights().iter().position(|f| f.callsign == options.watch);
        let watched_m = watched.and_then(|f| core.state(f)).map(|s| s.position_m.xy());
        for s in seen.net().surveillance().situations() {
            let there = watched_m.is_some_and(|m| (s.target.position_m - m).norm() < 25.0);
            if there || s.target.callsign.is_some_and(|c| c.as_str() == options.watch) {
                println!(
                    "{:8.1} track {} at {:.0} {:.0}, {:.1} m/s, mean {:.1}, of 3 s {:.1}, strips {:b}, fast {:?}, {:?}, last plot {:.1}, doubt {:?}",
                    now.s(),
                    s.target.number,
                    s.target.position_m.x,
                    s.target.position_m.y,
                    s.speed_mps,
                    s.mean_mps,
                    s.recent_mps,
                    s.strips,
                    s.fast,
                    s.on_final,
                    s.target.last_plot.s(),
                    s.doubt
                );
            }
        }
        for (change, alert) in &told {
            tracked.enter(now, *change, alert);
            if options.by_place
                && let Some(told) = tracked.0.get_mut(&alert.id)
            {
                if *change == Change::Raised {
                    by_place(&core, alert, &targets, told);
                    who.insert(alert.id, told.subjects.clone());
                }
                told.subjects.clone_from(&who[&alert.id]);
            }
            let about = about(&core, alert, &ages, &targets);
            if *change == Change::Raised {
                let mut about = about.clone();
                if let models::control::alert::Subject::Track(n) = alert.condition.subjects.0 {
                    about += &format!(" | {}", past.get(&n).map_or(String::new(), |l| l.join(" ")));
                }
                lines.insert(alert.id, about);
            }
            if !options.quiet {
                print("tracks", now, *change, alert, &about);
            }
        }
        frames.clear();
    }
    for shown in core.shown() {
        println!("{:8.1} failure {} {}", shown.time_s, shown.kind.word(), shown.callsign);
    }
    if options.clearances {
        for c in core.clearances() {
            let (name, until) = (&core.flights()[c.flight].callsign, c.until_s);
            println!(
                "{:8.1} {} {name} {} until {until:?} at {:?}",
                c.from_s, c.kind, c.runway, c.place_m
            );
        }
    }
    if !options.quiet {
        for remark in core.remarks() {
            println!("{:8.1} {}", remark.time_s, remark.text);
        }
    }
    for (kind, [all, of_targets, squares, nees, far]) in &errors {
        let near = (of_targets - far).max(1.0);
        println!(
            "plots {kind}: {all}, of targets {of_targets}, beyond 50 m {far}, else rms {:.2} m, NEES {:.2}",
            (squares / near).sqrt(),
            nees / near
        );
    }
    println!("served {} of {}", core.measures_of_served(), core.flights().len());
    let (reference, found) = (exact.list(), tracked.list());
    if options.tracks {
        for (id, told) in &tracked.0 {
            let alone = scoring::score(&reference, std::slice::from_ref(told));
            let (kind, subjects) = (&told.kind, told.subjects.join(" "));
            if alone.iter().any(|s| s.false_alerts > 0) {
                let about = lines.get(id).map_or("", |l| l);
                println!("{:8.1}-{:.0} false {kind} {subjects}{about}", told.on_s, told.end_s);
            }
            if alone.iter().any(|s| s.nuisance_alerts > 0) {
                let failure = cause(core.shown(), told).map_or("no failure", |s| s.kind.word());
                println!(
                    "{:8.1}-{:.0} nuisance {kind} {subjects}, of {failure}",
                    told.on_s, told.end_s
                );
            }
        }
        for told in &reference {
            let alone = scoring::score(std::slice::from_ref(told), &found);
            if alone.iter().any(|s| s.missed() > 0) {
                println!("{:8.1} missed {} {}", told.on_s, told.kind, told.subjects.join(" "));
            }
        }
        for score in scoring::score(&reference, &found) {
            let all = sum.entry(score.kind.clone()).or_insert_with(|| scoring::KindScore {
                kind: score.kind.clone(),
                ..Default::default()
            });
            all.add(&score);
        }
    }
    Ok(Ran { moved: movements(&core), shown: core.shown().to_vec(), raised: found })
}
