//! Scans of any density: work that is counted and bounded, and no tracks lost or born in mass.

use super::*;
use crate::plot::{Callsign, Identity};

/// A radar plot of both coordinates with `sigma_m` per axis.
fn plot_at(position_m: Point2<f64>, t_s: f64, sequence: usize, sigma_m: f64) -> Plot {
    Plot {
        sensor: SensorId(1),
        kind: SensorKind::Asde,
        time: SimTime::from_s(t_s),
        sequence: sequence as u32,
        position_m,
        axis: Vector2::new(1.0, 0.0),
        along_m2: sigma_m * sigma_m,
        across_m2: sigma_m * sigma_m,
        altitude_m: None,
        polar: None,
        identity: None,
        scnr_db: None,
    }
}

/// Plots of scan `k` of targets at `truth`, each with an error of `sigma_m` per axis.
fn plots(k: u32, n: usize, sigma_m: f64, truth: impl Fn(usize, f64) -> Point2<f64>) -> Vec<Plot> {
    let mut rng = DrawKey { run_seed: 7, sensor: 1, entity: 0, scan: k.into() }.rng(Purpose::Study);
    (0..n)
        .map(|i| {
            let t = f64::from(k) - 1.0 + (i + 1) as f64 / (n + 1) as f64;
            let (a, b) = normal_pair(&mut rng);
            plot_at(truth(i, t) + Vector2::new(a, b) * sigma_m, t, i, sigma_m)
        })
        .collect()
}

fn cloud(_: usize, _: f64) -> Point2<f64> {
    Point2::new(10.0, 20.0)
}

fn on_grid(i: usize, _: f64) -> Point2<f64> {
    Point2::new((i % 32) as f64, (i / 32) as f64) * 12.0
}

/// 25 targets on a square kilometre, moving apart at 10 m/s.
fn airport(n: usize) -> impl Fn(usize, f64) -> Point2<f64> {
    let columns = (n as f64).sqrt().ceil() as usize;
    move |i, t| {
        let angle = i as f64 * 2.4;
        Point2::new((i % columns) as f64, (i / columns) as f64) * 200.0
            + Vector2::new(libm::cos(angle), libm::sin(angle)) * 10.0 * t
    }
}

struct Ran {
    tracker: Tracker,
    /// Confirmed tracks after each scan.
    counts: Vec<usize>,
    /// Evaluations of each scan.
    evaluations: Vec<u64>,
}

fn scans(config: TrackingConfig, scans: u32, plots: impl Fn(u32) -> Vec<Plot>) -> Ran {
    let mut tracker = Tracker::new(config);
    let (mut counts, mut evaluations) = (Vec::new(), Vec::new());
    for k in 1..=scans {
        let before = tracker.statistics().evaluations;
        let tracks = tracker.scan(SimTime::from_s(f64::from(k)), &plots(k), &FlightList::default());
        counts.push(tracks.iter().filter(|t| t.status != TrackStatus::Last).count());
        evaluations.push(tracker.statistics().evaluations - before);
    }
    Ran { tracker, counts, evaluations }
}

fn profiles() -> [(&'static str, TrackingConfig); 3] {
    let mut global = TrackingConfig::paper();
    global.association = config::AssociationMethod::Global;
    let mut all = [
        ("paper", TrackingConfig::paper()),
        ("global", global),
        ("accurate", TrackingConfig::accurate()),
    ];
    all.iter_mut().for_each(|(_, config)| config.life.numbers = 65_536);
    all
}

/// A hundred milliseconds, by the table.
const WHOLE: u64 = 10_000_000;

#[test]
fn a_thousand_echoes_on_a_metre_or_a_tight_grid_cost_what_a_scan_may_cost() {
    type Scene = (&'static str, usize, f64, fn(usize, f64) -> Point2<f64>, usize);
    let scenes: [Scene; 4] = [
        ("a metre", 1000, 1.0, cloud, 900),
        ("12 m grid, 3 m errors", 1024, 3.0, on_grid, 920),
        // Twice as far off as they lie apart: a plot that two tracks share leaves one target without.
        ("12 m grid, 25 m errors", 1024, 25.0, on_grid, 820),
        ("one point", 1000, 0.0, cloud, 900),
    ];
    let mut faults = Vec::new();
    for (scene, n, sigma, truth, least) in scenes {
        for (name, config) in profiles() {
            let ran = scans(config, 8, |k| plots(k, n, sigma.max(0.1), truth));
            println!("{scene}, {name}: {:?} {:?}", ran.counts, ran.evaluations);
            println!("   {:?}", ran.tracker.statistics());
            let dear = ran.evaluations.iter().any(|&e| e > WHOLE);
            // All plots find a track: none is lost in mass, nor born in mass of what is left over.
            let settled = &ran.counts[4..];
            let strays = settled.iter().any(|&c| c > n + n / 10 || c < least);
            if dear || strays {
                faults.push(format!("{scene}, {name}: {:?} {:?}", ran.counts, ran.evaluations));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:?}");
}

#[test]
fn ten_thousand_plots_cost_what_a_scan_may_cost_wherever_they_lie() {
    let n = 10_000;
    let spread = airport(n);
    for (name, config) in profiles() {
        for (scene, sigma, ran) in [
            ("airport", 3.0, scans(config.clone(), 5, |k| plots(k, n, 3.0, &spread))),
            ("one point", 1.0, scans(config, 5, |k| plots(k, n, 1.0, cloud))),
        ] {
            println!("{scene} {sigma}, {name}: {:?} {:?}", ran.counts, ran.evaluations);
            println!("   {:?}", ran.tracker.statistics());
            assert!(ran.evaluations.iter().all(|&e| e <= WHOLE), "{scene}, {name}");
        }
    }
}

#[test]
fn work_grows_with_the_targets_not_with_their_pairs() {
    for (name, config) in profiles() {
        let work = |n: usize| {
            let mut config = config.clone();
            // The whole ladder of each track: it is the association whose growth is looked at.
            config.scan_budget_ms = 1e5;
            let ran = scans(config, 6, |k| plots(k, n, 3.0, airport(n)));
            assert!(ran.counts[5] >= n - n / 100, "{name}: {:?}", ran.counts);
            ran.evaluations[5] as f64
        };
        let (few, some, many) = (work(100), work(1_000), work(10_000));
        println!("{name}: {few} {some} {many}");
        assert!(some / few < 12.0 && many / some < 12.0, "{name}: {few} {some} {many}");
    }
}

#[test]
fn a_thousand_births_with_names_and_a_flight_list_are_born_at_once() {
    let n = 1_000;
    let spread = airport(n);
    let entries = (0..n)
        .map(|i| FlightEntry {
            stand_m: Some(spread(i, 0.0)),
            ..labelled::entry(&format!("SWR{i}"), "A320", MovementKind::Departure)
        })
        .collect();
    let flights = FlightList { entries, runways: Vec::new() }.sorted();
    for named in [false, true] {
        let mut tracker = Tracker::new(TrackingConfig::paper());
        for k in 1..=6 {
            let mut plots = plots(k, n, 3.0, &spread);
            for (i, plot) in plots.iter_mut().enumerate().filter(|_| named) {
                plot.identity = Some(Identity::Callsign(Callsign::new(&format!("SWR{i}"))));
            }
            tracker.scan(SimTime::from_s(f64::from(k)), &plots, &flights);
        }
        let found = tracker.statistics();
        println!("{found:?}");
        assert_eq!((found.confirmed, found.deleted), (n as u64, 0));
        assert!(found.most_evaluations <= WHOLE / 5, "twenty milliseconds: {found:?}");
    }
}

/// What belief propagation weighs gets bounds: on a line of targets ten metres apart a tenth of the tracks has a certain plot where errors are
/// a quarter of that, and hardly any where they are half. All of it is counted only.
#[test]
fn clusters_beyond_exact_association_say_of_how_many_tracks_the_pair_is_certain() {
    let line = |i: usize, t: f64| Point2::new(10.0 * i as f64, 8.0 * t);
    let share = |sigma_m: f64| {
        let ran = scans(TrackingConfig::accurate(), 12, |k| plots(k, 60, sigma_m, line));
        let found = *ran.tracker.statistics();
        println!("{sigma_m}: {found:?}");
        assert!(found.large_clusters > 0 && found.believed >= 13 * found.large_clusters);
        assert!(found.certain <= found.certified && found.certified <= found.believed);
        assert!(found.certified > found.believed / 10, "{found:?}");
        found.certain as f64 / found.certified as f64
    };
    let (clear, hard) = (share(2.5), share(5.0));
    assert!(clear > 0.05 && hard < 0.2 * clear, "{clear} {hard}");
}
