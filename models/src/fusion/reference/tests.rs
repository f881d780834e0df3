//! The reference on plots that are made here, with errors that are known, and in hard cases.

use super::linear::{Forwards, MOTION, Moment, Row, Start};
use super::*;
use crate::filter::consistency::nees_of;
use crate::filter::testing::{by_radar, drawn, plot_at, slower, stops_and_goes};
use crate::flight_list::{FlightEntry, MovementKind};
use crate::frames::Point2;
use crate::fusion::config::{SensorModel, TypeSize};
use crate::fusion::near_side::{Body, EchoLaw, half_extents_m};
use crate::plot::{Identity, SensorKind};
use nalgebra::{DMatrix, DVector};

/// Range m, azimuth rad, stamps late by s.
type Errors = [f64; 3];

const CAR: Body = Body { vehicle: true, length_m: 4.6, span_m: 1.9 };
const FIRE: Body = Body { vehicle: true, length_m: 12.0, span_m: 3.0 };
const JET: Body = Body { vehicle: false, length_m: 37.6, span_m: 35.8 };

/// A mover: its body, whether it reports itself, and its way: place at each time, s.
struct Mover {
    name: &'static str,
    kind: &'static str,
    body: Body,
    reports: bool,
    way: fn(f64) -> Point2<f64>,
}

/// Goes to and fro between 0 and 1, with a stop of a fifth of the time at either end and without a jump of the velocity.
fn swing(t: f64, period_s: f64) -> f64 {
    let u = (t / period_s).rem_euclid(1.0);
    let (u, back) = if u < 0.5 { (2.0 * u, false) } else { (2.0 * u - 1.0, true) };
    let s = ((u - 0.2) / 0.8).clamp(0.0, 1.0);
    let s = s * s * (3.0 - 2.0 * s);
    if back { 1.0 - s } else { s }
}

const MOVERS: [Mover; 3] = [
    Mover {
        name: "CAR1",
        kind: "CAR",
        body: CAR,
        reports: true,
        way: |t| Point2::new(-700.0 + 1400.0 * swing(t, 260.0), 900.0 + 30.0 * swing(t, 260.0)),
    },
    Mover {
        name: "FIRE1",
        kind: "FIRE",
        body: FIRE,
        reports: true,
        way: |t| Point2::new(1500.0 + 200.0 * swing(t, 170.0), -900.0 + 1600.0 * swing(t, 300.0)),
    },
    Mover {
        name: "SWR1",
        kind: "A320",
        body: JET,
        reports: false,
        way: |t| {
            let turn = 0.35 * libm::sin(t / 60.0);
            Point2::new(-1500.0 + 9.0 * t.min(420.0), 400.0 + 300.0 * turn)
        },
    },
];

fn draw(seed: u64, sensor: u32, entity: usize, scan: u64) -> Vector2<f64> {
    drawn(seed, sensor, entity as u64, scan)
}

fn plot(sensor: u16, kind: SensorKind, t: f64, position_m: Point2<f64>, variance: f64) -> Plot {
    let own = plot_at(t, position_m.x, position_m.y, variance);
    Plot { sensor: SensorId(sensor), kind, axis: Vector2::new(0.0, 1.0), ..own }
}

/// A radar's plot with its errors, of a body whose echo wanders.
fn echo(mover: &Mover, n: usize, t: f64, seed: u64, errors: Errors) -> Plot {
    let shown = t - errors[2];
    let (at, before) = ((mover.way)(shown), (mover.way)(shown - 1.0));
    let moved = at - before;
    let course = if moved.norm() > 0.1 { moved.normalize() } else { Vector2::new(1.0, 0.0) };
    let (distance, sigma) = (at.coords.norm(), if mover.body.vehicle { 0.8 } else { 2.6 });
    let axis = at.coords / distance;
    let offset =
        EchoLaw::default().of(&mover.body).offset_m(half_extents_m(&mover.body, axis, course));
    let noise = draw(seed, 1, n, (t * 100.0) as u64);
    let range_m = distance - offset + errors[0] + sigma * noise.x;
    let azimuth_rad = libm::atan2(at.x, at.y) + errors[1] + sigma * noise.y / distance;
    let axis = Vector2::new(libm::sin(azimuth_rad), libm::cos(azimuth_rad));
    let own = plot(1, SensorKind::Asde, t, (axis * range_m).into(), 0.0);
    Plot { sequence: n as u32, ..by_radar(own, [2.6 * 2.6; 2]) }
}

/// The scans of `seconds` s of these movers, plots with errors that stay for 100 s in the reports.
fn scans(seed: u64, seconds: u32, errors: Errors, reports: bool) -> Vec<(SimTime, Vec<Plot>)> {
    let mut slow = [Vector2::zeros(); MOVERS.len()];
    let keep = libm::exp(-1.0 / 100.0f64);
    (1..=seconds)
        .map(|k| {
            let (end, mut plots) = (f64::from(k), Vec::new());
            for (n, mover) in MOVERS.iter().enumerate() {
                plots.push(echo(mover, n, end - 0.7 + 0.05 * n as f64, seed, errors));
                let fresh = draw(seed, 3, n, k.into());
                slow[n] = if k == 1 { fresh } else { slower(slow[n], keep, fresh) };
                if reports && mover.reports {
                    let t = end - 0.35;
                    let error =
                        slow[n] * 0.65f64.sqrt() + draw(seed, 2, n, k.into()) * 0.35f64.sqrt();
                    let own = plot(2, SensorKind::Dgps, t, (mover.way)(t) + error * 0.6, 0.36);
                    let name = Identity::Callsign(Callsign::new(mover.name));
                    plots.push(Plot { identity: Some(name), sequence: n as u32, ..own });
                }
            }
            (SimTime::from_s(end), plots)
        })
        .collect()
}

fn flights() -> FlightList {
    let entries = MOVERS.iter().map(|m| FlightEntry {
        callsign: Callsign::new(m.name),
        address: None,
        type_designator: m.kind.into(),
        wake: None,
        movement: if m.body.vehicle { MovementKind::Vehicle } else { MovementKind::Arrival },
        runway: String::new(),
        stand: String::new(),
        stand_m: None,
        eta_ctd: SimTime(0),
        off_block: None,
        routing: Vec::new(),
    });
    FlightList { entries: entries.collect(), runways: Vec::new() }.sorted()
}

fn config() -> TrackingConfig {
    let mut config = TrackingConfig::accurate();
    config.sizes = MOVERS
        .iter()
        .map(|m| TypeSize {
            designator: m.kind.into(),
            length_m: m.body.length_m,
            span_m: m.body.span_m,
        })
        .collect();
    config.sensors = vec![SensorModel {
        extra_sigma_m: 0.0,
        ..SensorModel::default_of(SensorId(1), SensorKind::Asde)
    }];
    config
}

/// Root mean square error and mean normalised squared error of the trajectory nearest to a mover.
fn score(run: &ReferenceRun, mover: &Mover) -> (f64, f64) {
    let error = |p: &Point| p.position_m - (mover.way)(p.time.s());
    let mean = |w: &Trajectory| {
        w.points.iter().map(|p| error(p).norm_squared()).sum::<f64>() / w.points.len() as f64
    };
    let way = run.trajectories.iter().min_by(|a, b| mean(a).total_cmp(&mean(b))).expect("one");
    let nees = way.points.iter().map(|p| nees_of(&p.position_cov_m2, error(p))).sum::<f64>();
    (mean(way).sqrt(), nees / way.points.len() as f64)
}

#[test]
fn errors_of_a_radar_that_are_there_are_found_and_those_that_are_not_are_not() {
    for (seed, errors) in
        [(1, [2.0, 1e-3, 0.1]), (2, [-3.0, 0.0, 0.0]), (3, [0.0; 3]), (4, [0.0, -2e-3, 0.0])]
    {
        let run = reference(&config(), &flights(), &scans(seed, 600, errors, true)).expect("sound");
        assert_eq!(run.trajectories.len(), 3, "seed {seed}");
        let [site] = &run.sites[..] else { panic!("{:?}", run.sites) };
        let found = [site.range_m, site.azimuth_rad, site.time_s];
        for ((found, error), least) in found.iter().zip(errors).zip([0.3, 1e-4, 0.02]) {
            println!("seed {seed}: {:.5} ± {:.5}, {error}", found.value, found.sigma);
            assert!(found.known, "seed {seed}: {found:?}");
            assert!(
                (found.value - error).abs() <= 3.0 * found.sigma.max(least),
                "seed {seed}: {found:?} {error}"
            );
        }
        for (mover, most) in MOVERS.iter().zip([0.8, 0.8, 1.7]) {
            let (rms, nees) = score(&run, mover);
            println!("seed {seed}, {}: {rms:.2} m, NEES {nees:.2}", mover.name);
            assert!(rms <= most, "seed {seed}, {}: {rms}", mover.name);
            assert!(nees <= 3.5, "seed {seed}, {}: {nees}", mover.name);
        }
    }
}

#[test]
fn without_a_report_nothing_is_known_of_the_site_and_nothing_is_taken_off() {
    let run = reference(&config(), &flights(), &scans(5, 300, [0.0; 3], false)).expect("sound");
    let [site] = &run.sites[..] else { panic!("{:?}", run.sites) };
    for found in [site.range_m, site.azimuth_rad, site.time_s] {
        assert!(!found.known && found.value == 0.0, "{found:?}");
    }
    assert!(run.kappa.iter().all(|k| !k.known), "{:?}", run.kappa);
}

#[test]
fn what_stands_is_where_the_mean_of_its_plots_is() {
    // The car stands for its first 26 s.
    let run = reference(&config(), &flights(), &scans(6, 300, [0.0; 3], true)).expect("sound");
    let car =
        run.trajectories.iter().find(|w| w.callsign == Some(Callsign::new("CAR1"))).expect("named");
    let still: Vec<&Point> =
        car.points.iter().filter(|p| (5.0..=20.0).contains(&p.time.s())).collect();
    assert!(still.len() >= 15 && still.iter().all(|p| p.stands && p.velocity_mps.norm() < 0.05));
    let moving = car.points.iter().filter(|p| (60.0..=100.0).contains(&p.time.s()));
    for p in moving {
        let speed = ((MOVERS[0].way)(p.time.s() + 0.5) - (MOVERS[0].way)(p.time.s() - 0.5)).norm();
        assert!(!p.stands && (p.velocity_mps.norm() - speed).abs() < 1.0, "{p:?} {speed}");
    }
}

#[test]
fn gaps_copies_wild_plots_and_nonsense_do_no_harm() {
    let clean = scans(7, 300, [0.0; 3], true);
    let (whole, _) = score(&reference(&config(), &flights(), &clean).expect("sound"), &MOVERS[2]);
    let mut dirty = clean.clone();
    for (k, (end, plots)) in dirty.iter_mut().enumerate() {
        if (100..106).contains(&k) {
            plots.clear(); // nobody sees anything
        }
        let Some(first) = plots.first().copied() else { continue };
        plots.push(first); // the same plot again
        match k % 50 {
            10 => {
                plots.push(Plot { position_m: Point2::new(f64::NAN, 0.0), sequence: 90, ..first })
            }
            20 => plots.push(Plot { along_m2: -1.0, sequence: 91, ..first }),
            30 => plots.push(Plot { time: end.plus_s(100.0), sequence: 92, ..first }),
            40 => plots[2].position_m += Vector2::new(15.0, -12.0), // a wild one of the jet
            _ => {}
        }
    }
    let run = reference(&config(), &flights(), &dirty).expect("sound");
    assert_eq!(run.statistics.unsound, 3 * 6);
    assert_eq!(run.statistics.duplicates, 300 - 6);
    let (rms, nees) = score(&run, &MOVERS[2]);
    println!("clean {whole:.2} m, dirty {rms:.2} m, NEES {nees:.2}");
    assert!(rms <= 1.4 * whole + 0.2 && nees <= 4.0, "{rms} {nees}");
    for point in run.trajectories.iter().flat_map(|w| &w.points) {
        assert!(point.position_m.iter().chain(point.position_cov_m2.iter()).all(|v| v.is_finite()));
        assert!(point.position_cov_m2.determinant() > 0.0, "{point:?}");
    }
    // In the gap less is known than beside it.
    let jet = run.trajectories.iter().find(|w| !w.tracks.is_empty() && w.callsign.is_none());
    let jet = jet
        .or_else(|| run.trajectories.iter().find(|w| w.callsign == Some(Callsign::new("SWR1"))))
        .expect("there");
    let at = |s: f64| jet.at(SimTime::from_s(s)).map(|p| (p.position_cov_m2.trace(), p.plot_s));
    let (Some(inside), Some(beside)) = (at(103.0), at(150.0)) else { panic!("not reported") };
    assert!(inside.0 > beside.0 && inside.1 > 2.0 && beside.1 < 1.0, "{inside:?} {beside:?}");
}

#[test]
fn little_is_enough_and_nothing_is_refused() {
    assert!(reference(&config(), &flights(), &[]).expect("sound").trajectories.is_empty());
    let mut few = scans(8, 3, [0.0; 3], true);
    let one = vec![(few[0].0, vec![few[0].1[0]])];
    // One plot is no target yet.
    assert!(reference(&config(), &flights(), &one).expect("sound").trajectories.is_empty());
    let run = reference(&config(), &flights(), &few).expect("sound");
    assert!(run.trajectories.len() >= 2 && run.trajectories.iter().all(|w| !w.points.is_empty()));
    // All plots at one instant.
    for (end, plots) in &mut few {
        plots.iter_mut().for_each(|p| p.time = end.plus_s(-0.5));
    }
    let run = reference(&config(), &flights(), &few).expect("sound");
    assert!(run.trajectories.iter().flat_map(|w| &w.points).all(|p| p.position_m.x.is_finite()));
    let mut wrong = config();
    wrong.sensors[0].interval_s = f64::NAN;
    let refused = reference(&wrong, &flights(), &few).expect_err("no interval");
    assert!(refused.to_string().contains("interval_s"), "{refused}");
}

/// A small system, all of it: means, covariances and likelihood by conditioning one large Gaussian.
struct Dense {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    ln_likelihood: f64,
}

fn dense(moments: &[Moment], start: Start, columns: &[f64]) -> Dense {
    let n = MOTION + moments[0].fade.len();
    let k = moments.len();
    let (mut mean, mut p) = (DVector::zeros(n * k), DMatrix::zeros(n * k, n * k));
    let mut x = DVector::zeros(n);
    (x[0], x[2]) = (start.place[0], start.place[1]);
    let mut own = DMatrix::zeros(n, n);
    for i in 0..n {
        own[(i, i)] = [start.sigma_m, start.sigma_mps, start.sigma_m, start.sigma_mps]
            .get(i)
            .map_or(1.0, |s| s * s);
    }
    for (m, moment) in moments.iter().enumerate() {
        let mut phi = DMatrix::identity(n, n);
        let mut noise = DMatrix::zeros(n, n);
        let (t, q) = (moment.after_s, moment.q);
        for at in [0, 2] {
            phi[(at, at + 1)] = t;
            noise[(at, at)] = q * t * t * t / 3.0;
            (noise[(at, at + 1)], noise[(at + 1, at)]) = (q * t * t / 2.0, q * t * t / 2.0);
            noise[(at + 1, at + 1)] = q * t;
        }
        for (i, f) in moment.fade.iter().enumerate() {
            phi[(MOTION + i, MOTION + i)] = *f;
            noise[(MOTION + i, MOTION + i)] = 1.0 - f * f;
        }
        x = &phi * x;
        own = &phi * own * phi.transpose() + noise;
        mean.rows_mut(n * m, n).copy_from(&x);
        if m > 0 {
            let before = p.view((n * (m - 1), 0), (n, n * m)).into_owned();
            let cross = &phi * before;
            p.view_mut((n * m, 0), (n, n * m)).copy_from(&cross);
            p.view_mut((0, n * m), (n * m, n)).copy_from(&cross.transpose());
        }
        p.view_mut((n * m, n * m), (n, n)).copy_from(&own);
    }
    let rows: Vec<(usize, &Row)> = moments
        .iter()
        .enumerate()
        .flat_map(|(m, moment)| moment.rows.iter().map(move |r| (m, r)))
        .collect();
    let mut h = DMatrix::zeros(rows.len(), n * k);
    let (mut z, mut r) = (DVector::zeros(rows.len()), DMatrix::zeros(rows.len(), rows.len()));
    for (i, (m, row)) in rows.iter().enumerate() {
        row.h.iter().for_each(|(at, factor)| h[(i, n * m + at)] += factor);
        z[i] = row.z - row.columns.iter().zip(columns).map(|(j, c)| j * c).sum::<f64>();
        r[(i, i)] = row.variance;
    }
    let s = &h * &p * h.transpose() + r;
    let nu = z - &h * &mean;
    let inverse = s.clone().try_inverse().expect("positive");
    let gain = &p * h.transpose() * &inverse;
    Dense {
        mean: mean + &gain * &nu,
        covariance: &p - &gain * h * &p,
        ln_likelihood: -0.5
            * ((nu.transpose() * inverse * &nu)[(0, 0)] + libm::log(s.determinant())),
    }
}

fn small() -> (Vec<Moment>, Start) {
    let mut moments: Vec<Moment> = (0..7)
        .map(|k| {
            let noise = draw(3, 9, 0, k);
            let row = |h: [(usize, f64); 4], z: f64| Row {
                h,
                z,
                variance: 2.0,
                columns: vec![0.5 + 0.1 * k as f64, noise.y],
            };
            let (t, q) = ([0.0, 1.0, 0.0, 2.5, 1.0, 0.3, 1.0][k as usize], 0.2 + 0.1 * k as f64);
            let at = 3.0 * k as f64;
            Moment {
                after_s: t,
                q,
                fade: vec![libm::exp(-t / 5.0), 1.0],
                rows: vec![
                    row([(0, 0.6), (2, 0.8), (4, 1.2), (5, -0.4)], at + noise.x),
                    row([(0, 0.8), (2, -0.6), (5, 0.7), (0, 0.0)], 1.0 + noise.y),
                ],
            }
        })
        .collect();
    moments[3].rows.pop();
    moments[5].rows.clear();
    (moments, Start { place: [1.0, -1.0], sigma_m: 30.0, sigma_mps: 8.0 })
}

#[test]
fn the_smoother_is_the_conditional_of_one_large_gaussian() {
    let (moments, start) = small();
    let back = Forwards::of(&moments, start, 2).expect("sound").back();
    let n = MOTION + 2;
    let (none, first) = (dense(&moments, start, &[0.0, 0.0]), dense(&moments, start, &[0.0, 1.0]));
    for (k, here) in back.iter().enumerate() {
        for i in 0..MOTION {
            assert!((here.state[i] - none.mean[n * k + i]).abs() < 1e-8, "{k} {i}");
            let by = first.mean[n * k + i] - none.mean[n * k + i];
            assert!(
                (here.by_column[1][i] - by).abs() < 1e-8,
                "{k} {i}: {} {by}",
                here.by_column[1][i]
            );
            for j in 0..MOTION {
                let of = none.covariance[(n * k + i, n * k + j)];
                assert!((here.covariance[i][j] - of).abs() < 1e-7, "{k} {i} {j}");
            }
        }
    }
}

#[test]
fn scores_and_what_columns_tell_are_derivatives_of_the_likelihood() {
    let (moments, start) = small();
    let forwards = Forwards::of(&moments, start, 2).expect("sound");
    let back = forwards.back();
    let at = |change: &dyn Fn(&mut Vec<Moment>), columns: [f64; 2]| {
        let mut own = moments.clone();
        change(&mut own);
        dense(&own, start, &columns).ln_likelihood
    };
    let nothing = |_: &mut Vec<Moment>| {};
    let e: f64 = 1e-4;
    for k in [1, 3, 4] {
        let by = |f: f64| at(&|m: &mut Vec<Moment>| m[k].q *= libm::exp(f), [0.0; 2]);
        let slope = (by(e) - by(-e)) / (2.0 * e);
        let score = 0.5 * (back[k].moved.found - back[k].moved.told);
        assert!((slope - score).abs() < 1e-6, "density {k}: {slope} {score}");
        let by =
            |f: f64| at(&|m: &mut Vec<Moment>| m[k].rows[0].variance *= libm::exp(f), [0.0; 2]);
        let slope = (by(e) - by(-e)) / (2.0 * e);
        let score = 0.5 * (back[k].rows[0].found - back[k].rows[0].told);
        assert!((slope - score).abs() < 1e-6, "variance {k}: {slope} {score}");
    }
    let (mut information, mut vector) = (vec![0.0; 4], vec![0.0; 2]);
    forwards.tell(&mut information, &mut vector);
    let [a, o, b] = [-1e-2, 0.0, 1e-2].map(|c| at(&nothing, [c, 0.0]));
    assert!(((b - a) / 2e-2 - vector[0]).abs() < 1e-6 * vector[0].abs().max(1.0));
    assert!(((b - 2.0 * o + a) / 1e-4 + information[0]).abs() < 1e-4 * information[0]);
}

/// What a mover says of itself.
fn said(
    sensor: u16,
    kind: SensorKind,
    name: &str,
    t: f64,
    at_m: Point2<f64>,
    variance: f64,
) -> Plot {
    let name = Some(Identity::Callsign(Callsign::new(name)));
    Plot { identity: name, ..plot(sensor, kind, t, at_m, variance) }
}

/// With the lines of sight to its plots in place of that to the target, a place nearer to the radar explains away what echoes
/// wander across: an aircraft that stood for an hour 136 m from a radar was 43 m off, and all that stand by 6 km² over their distance.
#[test]
fn what_stands_near_a_radar_for_long_is_where_it_stands() {
    let stand = |body, way| Mover { name: "JET1", kind: "A320", body, reports: true, way };
    let near = stand(JET, |_| Point2::new(80.0, -110.0));
    let keep = libm::exp(-5.0 / 300.0f64);
    let mut slow = draw(31, 3, 0, 0);
    let all: Vec<(SimTime, Vec<Plot>)> = (1..=1_500u32)
        .map(|k| {
            let end = f64::from(k);
            let mut plots = vec![echo(&near, 0, end - 0.6, 31, [0.0; 3])];
            // Others turn the radar's line of sight.
            plots.push(echo(&MOVERS[0], 1, end - 0.4, 31, [0.0; 3]));
            if k % 5 == 0 {
                slow = slower(slow, keep, draw(31, 3, 0, k.into()));
                let error = slow * 1.9 + draw(31, 2, 0, k.into()) * 0.5;
                let at_m = (near.way)(end) + error;
                plots.push(said(2, SensorKind::Gps, near.name, end - 0.2, at_m, 3.9));
            }
            (SimTime::from_s(end), plots)
        })
        .collect();
    let run = reference(&config(), &flights(), &all).expect("sound");
    let (rms, nees) = score(&run, &near);
    println!("{rms:.2} m, NEES {nees:.2}");
    assert!(rms <= 2.5 && nees <= 5.0, "{rms} m, NEES {nees}");
}

/// Slant ranges of aircraft on final, on the ground 6 m too far, were taken for an error of the radar's range (5.3 m at an airport whose
/// aircraft report by ADS-B), on line and off.
#[test]
fn who_flies_teaches_nothing_of_a_radar() {
    let final_m = |n: u32, t: f64| Point2::new(7_000.0 - 75.0 * (t - 100.0 * f64::from(n)), 300.0);
    let name = |n: u32| format!("FLY{n}");
    let all: Vec<(SimTime, Vec<Plot>)> = (1..=560u32)
        .map(|k| {
            let (end, n) = (f64::from(k), k / 100);
            let mut plots = Vec::new();
            if k % 100 >= 1 && k % 100 <= 55 {
                let t = end - 0.6;
                let noise = draw(32, 1, 0, k.into());
                let at = final_m(n, t);
                let axis = at.coords.normalize();
                let across = Vector2::new(axis.y, -axis.x);
                let place = at + axis * (6.0 + 2.0 * noise.x) + across * (2.0 * noise.y);
                let seen = plot(1, SensorKind::Asde, t, place, 0.0);
                plots.push(by_radar(seen, [2.6 * 2.6; 2]));
                let at_m = final_m(n, end - 0.2) + draw(32, 2, 0, k.into()) * 0.5;
                plots.push(said(2, SensorKind::Dgps, &name(n), end - 0.2, at_m, 0.3));
            }
            (SimTime::from_s(end), plots)
        })
        .collect();
    let run = reference(&config(), &flights(), &all).expect("sound");
    let [site] = &run.sites[..] else { panic!("{:?}", run.sites) };
    assert!(!site.range_m.known && site.range_m.value == 0.0, "{:?}", site.range_m);
    let mut tracker = crate::fusion::Tracker::new(config());
    for (end, plots) in &all {
        tracker.scan(*end, plots, &flights());
    }
    assert!(
        tracker.site_biases().iter().all(|b| b.range_m.abs() < 0.5),
        "{:?}",
        tracker.site_biases()
    );
}

/// Reports of a target that drives and stops are late by the same 0.22 s; beside them a radar without errors.
#[test]
fn what_reports_are_late_by_is_found_off_line() {
    let place = |t: f64| Point2::new(-1_200.0 + stops_and_goes(t), 500.0);
    let all: Vec<(SimTime, Vec<Plot>)> = (1..=200u32)
        .map(|k| {
            let end = f64::from(k);
            let at = place(end - 0.6) + draw(41, 1, 0, k.into()) * 2.5;
            let seen = by_radar(plot(1, SensorKind::Asde, end - 0.6, at, 0.0), [2.6 * 2.6; 2]);
            let at_m = place(end - 0.1 - 0.22) + draw(41, 2, 0, k.into()) * 0.5;
            let said = said(2, SensorKind::Dgps, "LATE1", end - 0.1, at_m, 0.25);
            (SimTime::from_s(end), vec![seen, said])
        })
        .collect();
    let rms = |late_sigma_s: f64| {
        let mut config = TrackingConfig { register_echo: false, ..config() };
        config.sensors.push(SensorModel {
            late_sigma_s,
            slow_share: 0.0,
            ..SensorModel::default_of(SensorId(2), SensorKind::Dgps)
        });
        let run = reference(&config, &FlightList::default(), &all).expect("sound");
        let points = || run.trajectories.iter().flat_map(|w| &w.points);
        let fast = |p: &&Point| p.time.s() > 20.0 && p.velocity_mps.norm() > 15.0;
        let error = |p: &Point| (p.position_m - place(p.time.s())).norm_squared();
        let count = points().filter(fast).count() as f64;
        assert!(count > 50.0, "{count}");
        (points().filter(fast).map(error).sum::<f64>() / count).sqrt()
    };
    let (known, ignored) = (rms(0.15), rms(0.0));
    println!("at speed {known:.2} m, taken for punctual {ignored:.2} m");
    assert!(known < 1.2 && known < 0.5 * ignored, "{known} m, {ignored} m");
}

/// One name, ten minutes apart, is two stays; two minutes apart it is one.
#[test]
fn two_stays_of_one_name_are_two_trajectories() {
    let ways = |gap_s: u32| {
        let car = &MOVERS[0];
        let all: Vec<(SimTime, Vec<Plot>)> = (1..=80 + gap_s)
            .map(|k| {
                let t = f64::from(k) - 0.3;
                let there = k <= 40 || k > 40 + gap_s;
                let at_m = (car.way)(t) + draw(42, 2, 0, k.into()) * 0.5;
                let own = said(2, SensorKind::Dgps, car.name, t, at_m, 0.3);
                (SimTime::from_s(f64::from(k)), there.then_some(own).into_iter().collect())
            })
            .collect();
        reference(&config(), &flights(), &all).expect("sound").trajectories.len()
    };
    assert_eq!((ways(100), ways(600)), (1, 2));
}

#[test]
fn a_radar_stands_where_its_lines_of_sight_meet_if_they_do() {
    let site_m = Point2::new(120.0, -40.0);
    let seen = |turn: f64, range_m: f64| {
        let axis = Vector2::new(libm::sin(turn), libm::cos(turn));
        Plot { axis, ..plot(1, SensorKind::Asde, 1.0, site_m + axis * range_m, 1.0) }
    };
    let around = [seen(0.3, 500.0), seen(1.9, 2_000.0), seen(4.0, 90.0)];
    let found = super::shared::meeting_m(around.iter()).expect("they cross");
    assert!((found - site_m).norm() < 1e-6, "{found}");
    let one_way = [seen(0.3, 500.0), seen(0.3005, 2_000.0), seen(0.2995, 90.0)];
    assert_eq!(super::shared::meeting_m(one_way.iter()), None);
    assert_eq!(super::shared::meeting_m([].iter()), None);
}

/// At 0.2 m/s a car is slower than what stands may be, but its reports pull at a place that stays.
#[test]
fn what_creeps_does_not_stand() {
    let way = |t: f64| Point2::new(300.0 + 0.2 * (t - 60.0).clamp(0.0, 120.0), 400.0);
    let all: Vec<(SimTime, Vec<Plot>)> = (1..=240u32)
        .map(|k| {
            let t = f64::from(k) - 0.3;
            let at_m = way(t) + draw(43, 2, 0, k.into()) * 0.3;
            (
                SimTime::from_s(f64::from(k)),
                vec![said(2, SensorKind::Mlat, "CREEP1", t, at_m, 0.09)],
            )
        })
        .collect();
    let run = reference(&config(), &FlightList::default(), &all).expect("sound");
    let [only] = &run.trajectories[..] else { panic!("{}", run.trajectories.len()) };
    let off = |p: &Point| (p.position_m - way(p.time.s())).norm();
    let worst_m = only.points.iter().map(off).fold(0.0, f64::max);
    println!("at most {worst_m:.2} m");
    assert!(worst_m < 1.2, "{worst_m} m");
}

/// The side that it shows stays as long as it stands: what its echoes lie off does not average out, however long that is.
#[test]
fn what_the_echoes_of_a_standing_target_lie_off_is_not_averaged_away() {
    let near = Mover {
        name: "JET1",
        kind: "A320",
        body: JET,
        reports: true,
        way: |_| Point2::new(900.0, 500.0),
    };
    let keep = libm::exp(-5.0 / 300.0f64);
    let mut slow = draw(51, 3, 9, 0);
    // Others show what the radar errs by.
    let mut all = scans(51, 1_200, [0.0; 3], true);
    for (end, plots) in &mut all {
        let (k, end) = (end.s() as u64, end.s());
        plots.push(echo(&near, 9, end - 0.6, 51, [0.0; 3]));
        if k % 5 == 0 {
            slow = slower(slow, keep, draw(51, 3, 9, k));
            let at_m = (near.way)(end) + slow * 1.9 + draw(51, 2, 9, k) * 0.5;
            plots.push(said(3, SensorKind::Gps, near.name, end - 0.2, at_m, 3.9));
        }
    }
    let run = reference(&config(), &flights(), &all).expect("sound");
    let own = |w: &&Trajectory| {
        w.at(SimTime::from_s(600.0)).is_some_and(|p| (p.position_m - (near.way)(0.0)).norm() < 20.0)
    };
    let only = run.trajectories.iter().find(own).expect("followed");
    let at = only.at(SimTime::from_s(600.0)).expect("there");
    let sight = (near.way)(0.0).coords.normalize();
    let along_m2 = (sight.transpose() * at.position_cov_m2 * sight)[(0, 0)];
    println!("{along_m2:.2} m² along the line of sight");
    // What echoes lie off is worth 2 m², the receiver over all the time 1.4 m²; echoes that wander every 100 s would be worth 0.3 m² by then.
    assert!(at.stands && along_m2 > 0.5, "{along_m2} m²");
}

/// One plot 2 m off among plots of 0.3 m: the way bends by a fraction of what a plot of full weight would do.
#[test]
fn one_wild_plot_hardly_bends_a_way() {
    let way = |t: f64| Point2::new(4.0 * t, 300.0 + 2.0 * t);
    let all = |off_m: f64| -> Vec<(SimTime, Vec<Plot>)> {
        (1..=120u32)
            .map(|k| {
                let t = f64::from(k) - 0.3;
                let off = if k == 60 { off_m } else { 0.0 };
                let at_m = way(t) + draw(52, 2, 0, k.into()) * 0.3 + Vector2::new(0.0, off);
                let own = said(2, SensorKind::Mlat, "WILD1", t, at_m, 0.09);
                (SimTime::from_s(f64::from(k)), vec![own])
            })
            .collect()
    };
    let mut config = config();
    config.sensors.push(SensorModel {
        slow_share: 0.0,
        extra_sigma_m: 0.0,
        ..SensorModel::default_of(SensorId(2), SensorKind::Mlat)
    });
    let at = |off_m: f64| {
        let run = reference(&config, &FlightList::default(), &all(off_m)).expect("sound");
        let [only] = &run.trajectories[..] else { panic!("{}", run.trajectories.len()) };
        only.at(SimTime::from_s(60.0)).expect("there").position_m
    };
    let bent_m = (at(2.0) - at(0.0)).norm();
    println!("{bent_m:.2} m");
    assert!(bent_m < 0.25, "{bent_m} m");
}

/// It rolls to a stop and moves off so gently that for two seconds it is slower than what stands may be.
#[test]
fn what_stands_may_move_already_at_either_end() {
    let way = |t: f64| {
        let (before, after) = ((20.0 - t).max(0.0), (t - 60.0).max(0.0));
        Point2::new(300.0 - 0.075 * before * before + 0.075 * after * after, 400.0)
    };
    let all: Vec<(SimTime, Vec<Plot>)> = (1..=80u32)
        .map(|k| {
            let t = f64::from(k) - 0.3;
            let at_m = way(t) + draw(53, 2, 0, k.into()) * 0.15;
            let own = said(2, SensorKind::Mlat, "GENTLE1", t, at_m, 0.0225);
            (SimTime::from_s(f64::from(k)), vec![own])
        })
        .collect();
    let run = reference(&config(), &FlightList::default(), &all).expect("sound");
    let [only] = &run.trajectories[..] else { panic!("{}", run.trajectories.len()) };
    let stands: Vec<f64> = only.points.iter().filter(|p| p.stands).map(|p| p.time.s()).collect();
    println!("{:?} to {:?}", stands.first(), stands.last());
    assert!(stands.len() >= 25, "{}", stands.len());
    assert!(stands.iter().all(|t| (20.0..=60.0).contains(t)), "{stands:?}");
}

#[test]
fn a_target_is_asked_for_from_its_first_plot_to_the_scan_after_its_last() {
    let ends: Vec<SimTime> = (1..=9).map(|k| SimTime::from_s(f64::from(k))).collect();
    let of = |first_s: f64, last_s: f64| {
        let plots = [first_s, last_s].map(|t| crate::filter::testing::plot_at(t, 0.0, 0.0, 1.0));
        let asked = asked(&plots, &ends);
        (asked.first().map(|t| t.s()), asked.last().map(|t| t.s()))
    };
    assert_eq!(of(2.5, 4.5), (Some(3.0), Some(5.0)));
    assert_eq!(of(3.0, 5.0), (Some(3.0), Some(5.0)));
    assert_eq!(of(0.1, 0.2), (Some(1.0), Some(1.0)));
    assert_eq!(of(8.5, 9.5), (Some(9.0), Some(9.0)));
    assert_eq!(of(9.5, 9.9), (None, None));
    assert!(asked(&[], &ends).is_empty());
}

/// Nothing is divided by a variance that is none: the whole way is refused.
#[test]
fn a_row_without_a_variance_is_refused() {
    let (moments, start) = small();
    for (k, row) in [(0, 0), (1, 1), (6, 0)] {
        for (variance, is_sound) in
            [(1e-9, true), (0.0, false), (-1.0, false), (f64::NAN, false), (f64::INFINITY, false)]
        {
            let mut moments = moments.clone();
            moments[k].rows[row].variance = variance;
            let found = Forwards::of(&moments, start, 2).is_some();
            assert_eq!(found, is_sound, "{variance} at {k}");
        }
    }
}
