//! Speeds and accelerations of the type, and jumps.

use super::{Breaches, Last, Row, Rules, Seen, Who};
use crate::frames::Azimuth;

/// Breaches of the limits of types.
#[derive(Clone, Debug, Default)]
pub(super) struct Limits {
    speeds: Breaches,
    accelerations: Breaches,
    teleports: Breaches,
}

/// Fastest on a rapid exit, m/s (50 kt).
const EXIT_MPS: f64 = 25.7;
/// Across, m/s² (the fastest quarter turn, and room for the middle being elsewhere than the nose wheel).
const ACROSS_MPS2: f64 = 1.6;
/// Higher than this it flies, m: from then on it is faster than on the ground.
const LIFTED_M: f64 = 0.2;
/// Longer gaps say nothing of accelerations, s.
const MOST_GAP_S: f64 = 1.6;

impl Limits {
    /// `taxies`: away from all runways.
    pub(super) fn look(
        &mut self,
        rules: &Rules,
        who: &Who,
        last: &Last,
        time_s: f64,
        s: &Seen,
        taxies: bool,
    ) {
        let dt = time_s - last.time_s;
        if dt > MOST_GAP_S {
            return;
        }
        let (was, is) = (last.seen.velocity_mps, s.velocity_mps);
        let moved = (s.position_m - last.seen.position_m).xy();
        let far_m = (moved - (was + is) * (0.5 * dt)).norm();
        let name = &who.callsign;
        let at = format!("at {time_s:.1} s, at {:.0} {:.0}", s.position_m.x, s.position_m.y);
        self.teleports.of += 1;
        // Half a turn of a pushed tail, and the thresholds of dead reckoning.
        if far_m > 0.5 + 0.7 * dt {
            self.teleports.add(|| format!("{name} by {far_m:.1} m in {dt:.2} s {at}"));
        }
        if s.position_m.z >= LIFTED_M || last.seen.position_m.z >= LIFTED_M {
            return;
        }
        let speed = is.norm();
        let l = &who.limits;
        let most = if taxies { l.taxi_mps } else { l.runway_mps.max(EXIT_MPS) };
        self.speeds.of += 1;
        if speed > most + rules.speed_mps {
            self.speeds.add(|| format!("{name} {speed:.1} m/s, at most {most:.1}, {at}"));
        }
        // Of the middle over a while: turning swings it, so its own line is taken.
        let nose = Azimuth::from_rad(
            0.5 * turned(last.seen.heading_rad, s.heading_rad) + last.seen.heading_rad,
        );
        let change = (is - was) / dt;
        let along = change.dot(&nose.unit()) * if is.dot(&nose.unit()) < 0.0 { -1.0 } else { 1.0 };
        let across = (change - nose.unit() * change.dot(&nose.unit())).norm();
        // The last centimetres before a line are taken at once.
        if speed.max(was.norm()) < 0.3 {
            return;
        }
        let (up, down) = if taxies { l.taxi_mps2 } else { l.runway_mps2 };
        self.accelerations.of += 1;
        let room = rules.acceleration_mps2;
        let beside = if taxies { ACROSS_MPS2 } else { 2.0 * ACROSS_MPS2 };
        if along > up + room || along < -down - room || across > beside + room {
            self.accelerations.add(|| {
                format!("{name} {along:.2} along, {across:.2} across, at most {up:.2}, -{down:.2} and {beside:.2} m/s2, {at}, {speed:.1} m/s")
            });
        }
    }

    pub(super) fn rows(self) -> [Row; 3] {
        [
            self.speeds.row("speeds"),
            self.accelerations.row("accelerations"),
            self.teleports.row("teleports"),
        ]
    }
}

fn turned(from_rad: f64, to_rad: f64) -> f64 {
    crate::frames::wrap_pi(to_rad - from_rad)
}
