//! Network load against the error of what receivers believe, and the step of the movers.
//!
//! The movements of the Zurich scene go through the product's own decision ([`Publisher`]) and dead
//! reckoning, with velocities rounded as a PDU carries them; the error is the distance between truth
//! and what a receiver extrapolates, looked at 20 times a second whatever the step.

use crate::measure::{Errors, median_and_p99};
use crate::{Ladder, Options, Outcome, Progress, Row, SceneAbout, clock, zurich};
use geodesy::{Attitude, Ecef, Enu, Euler, LocalFrame};
use models::frames::Vector3;
use models::time::SimTime;
use models::truth::TruthState;
use pdu::EntityState;
use pdu::dead_reckoning::Motion;
use pdu::enumerations::DeadReckoningAlgorithm;
use pdu::publishing::{Publisher, Thresholds};
use pdu::records::{EntityId, Vector32};
use scenarios::Scene;

/// Between two looks of the receiver, ns.
const LOOK_NS: i64 = 50_000_000;

/// How truth is sent.
#[derive(Clone, Copy, Debug)]
struct Sending {
    algorithm: u8,
    threshold_m: f64,
    step_ns: i64,
}

/// What one way of sending cost and gave.
#[derive(Clone, Debug, Default)]
struct Found {
    errors: Errors,
    pdus: u64,
    mover_s: f64,
    step_ns: Vec<f64>,
}

fn pose(truth: &TruthState, frame: &LocalFrame) -> (Ecef, Euler) {
    let p = truth.position_m;
    let attitude = Attitude {
        heading_rad: truth.heading_rad,
        pitch_rad: truth.pitch_rad,
        roll_rad: truth.roll_rad,
    };
    (frame.to_ecef(Enu { east_m: p.x, north_m: p.y, up_m: p.z }), frame.euler(attitude))
}

fn state(
    truth: &TruthState,
    number: u16,
    algorithm: u8,
    frame: &LocalFrame,
) -> EntityState<'static> {
    let (at, orientation) = pose(truth, frame);
    let world = |v: Vector3<f64>| Vector32::from_f64(frame.vector_to_ecef([v.x, v.y, v.z]));
    let rate = truth.angular_rate_rads;
    EntityState {
        entity_id: EntityId::new(1, 1, number),
        linear_velocity_mps: world(truth.velocity_mps),
        linear_acceleration_mps2: world(truth.acceleration_ms2),
        location: at.into(),
        orientation: orientation.into(),
        dead_reckoning_algorithm: DeadReckoningAlgorithm(algorithm),
        angular_velocity_rad_s: Vector32::from_f64([rate.x, rate.y, rate.z]),
        ..EntityState::default()
    }
}

/// Sends every movement of the scene: once listened to, once timed.
fn run(scene: &Scene, sending: Sending, seconds: f64) -> Found {
    let mut found = send(scene, sending, seconds, true);
    found.step_ns = send(scene, sending, seconds, false).step_ns;
    found
}

fn send(scene: &Scene, sending: Sending, seconds: f64, listen: bool) -> Found {
    let frame = &scene.airport.frame;
    let mut found = Found::default();
    for (number, entity) in scene.traffic.entities.iter().enumerate() {
        let Some(trajectory) = &entity.trajectory else { continue };
        let mut publisher = Publisher::new(Thresholds {
            distance_m: sending.threshold_m,
            angle_rad: scene.run.dead_reckoning.orientation_rad,
            heartbeat_ns: scene.run.heartbeat_moving.0,
            jitter: 0.1,
        });
        let mut believed: Option<(Motion, i64)> = None;
        let first = trajectory.start().0.div_euclid(sending.step_ns) + 1;
        let last = trajectory.end().0.min(trajectory.start().0 + (seconds * 1e9) as i64);
        let mut looked = first * sending.step_ns;
        let (mut steps, begin) = (0u64, clock::thread_ns());
        for k in first..=last.div_euclid(sending.step_ns) {
            let now = k * sending.step_ns;
            // What the receiver believes before this step's PDU can arrive.
            while listen && looked < now {
                if let (Some((motion, sent)), Some(truth)) =
                    (&believed, trajectory.at(SimTime(looked)))
                {
                    let place = motion.after((looked - sent) as f64 * 1e-9).location;
                    found.errors.add(place.distance_m(pose(&truth, frame).0));
                }
                looked += LOOK_NS;
            }
            let Some(truth) = trajectory.at(SimTime(now)) else { continue };
            steps += 1;
            let (place, attitude) = pose(&truth, frame);
            if publisher.due(now, place, attitude).is_some() {
                let sent = state(&truth, number as u16, sending.algorithm, frame);
                publisher.sent(now, &sent);
                believed = Some((Motion::from(&sent), now));
                found.pdus += 1;
            }
        }
        let ns = (clock::thread_ns() - begin) as f64;
        let mover_s = steps as f64 * sending.step_ns as f64 * 1e-9;
        found.mover_s += mover_s;
        if mover_s > 0.0 {
            found.step_ns.push(ns / mover_s);
        }
    }
    found
}

fn row(group: &str, rung: String, mut found: Found) -> Row {
    let load = found.pdus as f64 / found.mover_s.max(1e-9);
    let (median, p99) = median_and_p99(&mut found.step_ns);
    Row {
        group: group.into(),
        scene: "zurich".into(),
        rung,
        rmse_m: found.errors.rms(),
        p95_m: found.errors.p95(),
        error: found.errors.most(),
        error_unit: Some("m at most".into()),
        ns_per_update: median,
        ns_p99: p99,
        cost: Some(load),
        cost_unit: Some("PDUs per mover and second".into()),
        ..Row::default()
    }
}

fn failure(group: &str, error: &dyn std::fmt::Display) -> Row {
    Row {
        group: group.into(),
        scene: "zurich".into(),
        failed: vec![error.to_string()],
        ..Row::default()
    }
}

fn about() -> Vec<SceneAbout> {
    let about = "six recorded movements and two vehicles of the Zurich scene".into();
    vec![SceneAbout { name: "zurich".into(), about }]
}

/// The ladder of thresholds and algorithms.
pub(crate) fn thresholds(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let seconds = if options.quick { 200.0 } else { 1e4 };
    let mut rows = Vec::new();
    let algorithms: [(&str, u8); 3] = [("FPW", 2), ("FVW", 5), ("RVW", 4)];
    let limits = [10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01];
    let total = algorithms.len() * limits.len();
    match zurich::scene() {
        Err(error) => rows.push(failure("dead_reckoning", &error)),
        Ok(scene) => {
            for (name, algorithm) in algorithms {
                for threshold_m in limits {
                    let sending = Sending { algorithm, threshold_m, step_ns: scene.run.frame.0 };
                    let rung = format!("{name} {threshold_m} m");
                    rows.push(row("dead_reckoning", rung.clone(), run(&scene, sending, seconds)));
                    progress(Progress {
                        group: "dead_reckoning",
                        what: rung,
                        done: rows.len(),
                        total,
                    });
                }
            }
        }
    }
    let ladder = Ladder {
        group: "dead_reckoning".into(),
        title: "Dead reckoning: error of what receivers believe against network load".into(),
        about: "Entity State PDUs are sent when the receivers' extrapolation is off by more than the \
                threshold (or 0.5°), and every 5 s. FPW extrapolates at constant velocity, FVW at constant \
                acceleration, RVW turns too (IEEE 1278.1-2012, annex E): in a turn the first two send for the \
                angle, not the position. Steps of 50 ms: the threshold is looked at that often, so the largest error is a little above it. Time is one mover for one \
                simulated second."
            .into(),
        error_label: "error of the extrapolated position, m (rms)".into(),
        cost_label: Some("PDUs per mover and second".into()),
        scenes: about(),
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

/// The ladder of time steps of the movers.
pub(crate) fn steps(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let seconds = if options.quick { 200.0 } else { 1e4 };
    let mut rows = Vec::new();
    let steps_ms = [1000, 500, 200, 100, 50, 20, 10];
    match zurich::scene() {
        Err(error) => rows.push(failure("time_step", &error)),
        Ok(scene) => {
            let run_ = &scene.run.dead_reckoning;
            for step_ms in steps_ms {
                let (algorithm, threshold_m) = (run_.algorithm, run_.position_m);
                let sending = Sending { algorithm, threshold_m, step_ns: step_ms * 1_000_000 };
                let rung = format!("{step_ms} ms");
                rows.push(row("time_step", rung.clone(), run(&scene, sending, seconds)));
                let total = steps_ms.len();
                progress(Progress { group: "time_step", what: rung, done: rows.len(), total });
            }
        }
    }
    let ladder = Ladder {
        group: "time_step".into(),
        title: "Time step of the movers".into(),
        about: "Positions are exact at every step, whatever its length (the path is a curve, not a sum of \
                steps); what a step costs in accuracy is that a departure from the dead reckoning is noticed \
                only at its end. Threshold and algorithm as in the Zurich scene. Time is one mover for one \
                simulated second."
            .into(),
        error_label: "error of the extrapolated position, m (rms)".into(),
        scenes: about(),
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tighter_thresholds_cost_more_pdus_and_keep_what_they_promise() {
        let scene = zurich::scene().expect("ships");
        let found = |algorithm, threshold_m| {
            run(&scene, Sending { algorithm, threshold_m, step_ns: scene.run.frame.0 }, 150.0)
        };
        let (coarse, fine) = (found(5, 1.0), found(5, 0.1));
        assert!(fine.pdus > coarse.pdus, "{} {}", fine.pdus, coarse.pdus);
        assert!(fine.errors.rms() < coarse.errors.rms());
        // What was below the threshold at one step is at most one step's drift above it at the next.
        assert!(fine.errors.most().expect("looked") < 0.2, "{:?}", fine.errors.most());
        assert!(found(2, 0.1).pdus > fine.pdus, "constant velocity needs more PDUs");
    }
}
