//! The tracker on simulated traffic: accuracy against its plots, life, labels, hostile input.

use super::*;
use crate::draw::{DrawKey, Purpose, normal_pair, uniform};
use crate::flight_list::{FlightEntry, FlightList, MovementKind, WakeCategory};
use crate::frames::{Point2, Vector2};
use crate::plot::{Plot, Polar, SensorId, SensorKind};
use crate::time::SimTime;
use crate::track::{SystemTrack, TrackStatus};

mod crowds;
mod decisions;
mod doubles;
mod echo;
mod hard_cases;
mod identity;
mod labelled;
mod lag;
mod limits;
mod namesakes;
mod own;
mod rests;
mod seldom;
mod several;
mod shadows;
mod taken_in;
mod taken_off;
mod wide;

type Path = dyn Fn(f64) -> Option<Point2<f64>>;
/// A plot with the index and the true position of what caused it.
type Looked = (Plot, Option<(usize, Point2<f64>)>);

/// A radar in the plane: cells of 5.4 m and 0.25°, thermal noise, rotation once a second.
struct Radar {
    seed: u64,
    site: Point2<f64>,
    detection: f64,
    false_plots: u32,
}

const CELL_M: f64 = 5.4;
const CELL_RAD: f64 = 0.25 * std::f64::consts::PI / 180.0;

impl Radar {
    fn plot(&self, sequence: u32, time: SimTime, range: f64, azimuth: f64) -> Plot {
        let range = ((range / CELL_M).floor() + 0.5) * CELL_M;
        let azimuth = ((azimuth / CELL_RAD).floor() + 0.5) * CELL_RAD;
        let axis = Vector2::new(libm::sin(azimuth), libm::cos(azimuth));
        let sigma_range = CELL_M / 12f64.sqrt();
        let sigma_azimuth = CELL_RAD / 12f64.sqrt();
        Plot {
            sensor: SensorId(1),
            kind: SensorKind::Asde,
            time,
            sequence,
            position_m: self.site + axis * range,
            axis,
            along_m2: sigma_range * sigma_range,
            across_m2: (range * sigma_azimuth) * (range * sigma_azimuth),
            altitude_m: None,
            polar: Some(Polar {
                range_m: range,
                azimuth_rad: azimuth,
                sigma_range_m: sigma_range,
                sigma_azimuth_rad: sigma_azimuth,
                extent_m2: None,
            }),
            identity: None,
            scnr_db: Some(20.0),
        }
    }

    /// Plots of the scan (k − 1, k] with the index and true position of what caused each.
    fn scan(&self, k: u32, paths: &[Box<Path>]) -> Vec<Looked> {
        let mut plots = Vec::new();
        let start = f64::from(k) - 1.0;
        for (index, path) in paths.iter().enumerate() {
            let mut rng = self.rng(index as u64 + 1, k);
            let Some(guess) = path(start) else { continue };
            let offset = guess - self.site;
            let turn = |o: Vector2<f64>| {
                libm::atan2(o.x, o.y).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU
            };
            let time = SimTime::from_s(start + turn(offset)).0.max(SimTime::from_s(start).0 + 1);
            let time = SimTime(time);
            let Some(truth) = path(time.s()) else { continue };
            let o = truth - self.site;
            let (a, b) = normal_pair(&mut rng);
            if uniform(&mut rng) >= self.detection {
                continue;
            }
            let plot = self.plot(
                index as u32,
                time,
                libm::hypot(o.x, o.y) + 0.3 * a,
                libm::atan2(o.x, o.y) + 1e-4 * b,
            );
            plots.push((plot, Some((index, truth))));
        }
        let mut rng = self.rng(0, k);
        for n in 0..self.false_plots {
            let (u, v) = (uniform(&mut rng), uniform(&mut rng));
            let azimuth = std::f64::consts::TAU * u;
            let time = SimTime::from_s(start + u.max(1e-6));
            plots.push((self.plot(1000 + n, time, 200.0 + 3000.0 * v, azimuth), None));
        }
        plots
    }

    fn rng(&self, entity: u64, k: u32) -> rand::rngs::ChaCha8Rng {
        DrawKey { run_seed: self.seed, sensor: 1, entity, scan: u64::from(k) }.rng(Purpose::Study)
    }
}

/// Straight and round pieces one after the other: (duration s, acceleration m/s², turn rate rad/s).
fn drive(start: Point2<f64>, heading: f64, speed: f64, pieces: &[(f64, f64, f64)]) -> Box<Path> {
    let step = 0.01;
    let mut samples = vec![start];
    let (mut p, mut h, mut v) = (start, heading, speed);
    for &(duration, a, rate) in pieces {
        for _ in 0..(duration / step) as usize {
            v = (v + a * step).max(0.0);
            h += rate * step;
            p += Vector2::new(libm::sin(h), libm::cos(h)) * v * step;
            samples.push(p);
        }
    }
    Box::new(move |t| {
        let at = (t / step).max(0.0);
        let k = (at as usize).min(samples.len() - 1);
        let next = (k + 1).min(samples.len() - 1);
        Some(samples[k] + (samples[next] - samples[k]) * (at - k as f64).min(1.0))
    })
}

/// Traffic of an ordinary minute or five: a landing, a take-off, taxiing with turns and stops, a car,
/// three parked aircraft 45 m apart.
fn traffic() -> Vec<Box<Path>> {
    let v = Point2::new;
    let quarter = std::f64::consts::FRAC_PI_2;
    vec![
        drive(
            v(-900.0, 300.0),
            quarter,
            75.0,
            &[
                (3.0, 0.0, 0.0),
                (35.0, -1.8, 0.0),
                (6.0, 0.0, 0.12),
                (20.0, 0.0, 0.0),
                (8.0, -0.6, 0.0),
                (5.0, 0.0, 0.25),
                (200.0, 0.2, 0.0),
            ],
        ),
        drive(
            v(-1200.0, -200.0),
            quarter,
            0.0,
            &[(40.0, 0.0, 0.0), (38.0, 1.9, 0.0), (30.0, 0.0, 0.0)],
        ),
        drive(
            v(300.0, 900.0),
            3.0,
            0.0,
            &[
                (10.0, 0.0, 0.0),
                (14.0, 0.7, 0.0),
                (20.0, 0.0, 0.0),
                (7.0, 0.0, 0.22),
                (25.0, 0.0, 0.0),
                (10.0, -1.0, 0.0),
                (25.0, 0.0, 0.0),
                (8.0, 0.9, 0.0),
                (6.0, 0.0, -0.26),
                (120.0, 0.0, 0.0),
            ],
        ),
        drive(
            v(600.0, -400.0),
            5.0,
            14.0,
            &[
                (20.0, 0.0, 0.0),
                (4.0, -2.0, 0.0),
                (3.0, 0.0, 0.5),
                (5.0, 2.0, 0.0),
                (120.0, 0.0, 0.005),
            ],
        ),
        drive(v(420.0, 310.0), 0.0, 0.0, &[(1.0, 0.0, 0.0)]),
        drive(v(465.0, 310.0), 0.0, 0.0, &[(1.0, 0.0, 0.0)]),
        drive(v(510.0, 310.0), 0.0, 0.0, &[(1.0, 0.0, 0.0)]),
    ]
}

#[derive(Default)]
struct Score {
    plots: u64,
    raw2: f64,
    track2: f64,
}

impl Score {
    fn reduction_pct(&self) -> f64 {
        100.0 * (1.0 - self.track2 / self.raw2)
    }
}

struct Run {
    /// Plots of moving targets against the truth.
    moving: Score,
    last: Vec<SystemTrack>,
    /// Per path: numbers of the nearest track within 25 m, one after the other.
    numbers_near: Vec<Vec<u16>>,
    /// Per path: scans after the fifth without such a track.
    missing: Vec<u32>,
    tracker: Tracker,
    most_tracks: usize,
}

fn run(
    config: TrackingConfig,
    radar: &Radar,
    paths: &[Box<Path>],
    flights: &FlightList,
    scans: u32,
) -> Run {
    let mut tracker = Tracker::new(config);
    let mut moving = Score::default();
    let mut numbers_near = vec![Vec::new(); paths.len()];
    let mut missing = vec![0; paths.len()];
    let (mut last, mut most_tracks) = (Vec::new(), 0);
    for k in 1..=scans {
        let looked = radar.scan(k, paths);
        let plots: Vec<Plot> = looked.iter().map(|l| l.0).collect();
        let t_out = SimTime::from_s(f64::from(k));
        let tracks = tracker.scan(t_out, &plots, flights);
        for (index, (plot, cause)) in looked.iter().enumerate() {
            let Some((path, truth)) = *cause else { continue };
            let Outcome::Used { position_m, .. } = tracker.outcomes()[index] else { continue };
            let soon = paths[path](plot.time.s() + 0.5).expect("moves for ever");
            if k >= 4 && (soon - truth).norm() > 0.5 {
                moving.plots += 1;
                moving.raw2 += (plot.position_m - truth).norm_squared();
                moving.track2 += (position_m - truth).norm_squared();
            }
        }
        for (path, near) in numbers_near.iter_mut().enumerate() {
            let truth = paths[path](t_out.s()).expect("moves for ever");
            let distance = |t: &SystemTrack| (t.position_m - truth).norm();
            let mine = tracks
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .filter(|t| distance(t) < 25.0);
            match mine {
                Some(track) => near.push(track.number),
                None => missing[path] += u32::from(k > 5),
            }
            near.dedup();
        }
        most_tracks = most_tracks.max(tracks.len());
        last = tracks;
    }
    Run { moving, last, numbers_near, missing, tracker, most_tracks }
}

fn tower(seed: u64, detection: f64, false_plots: u32) -> Radar {
    Radar { seed, site: Point2::new(150.0, -250.0), detection, false_plots }
}

#[test]
fn tracks_are_better_than_their_plots_and_no_target_is_lost() {
    for seed in [1, 2, 3] {
        let radar = tower(seed, 0.95, 2);
        let run = run(TrackingConfig::paper(), &radar, &traffic(), &FlightList::default(), 240);
        let Score { plots, raw2, track2 } = run.moving;
        println!(
            "seed {seed}: {plots} plots, raw {:.2} m, track {:.2} m, {:.0} %, {:?}",
            (raw2 / plots as f64).sqrt(),
            (track2 / plots as f64).sqrt(),
            run.moving.reduction_pct(),
            run.tracker.statistics()
        );
        println!(
            "numbers {:?} missing {:?} most {}",
            run.numbers_near, run.missing, run.most_tracks
        );
        assert!(plots > 500);
        assert!(track2 < raw2, "seed {seed}");
        assert!(run.missing.iter().all(|&m| m <= 2), "{:?}", run.missing);
        assert!(run.numbers_near.iter().all(|n| n.len() == 1), "{:?}", run.numbers_near);
        assert_eq!(run.last.len(), 7);
    }
}
