//! Speeds and accelerations of the type, and jumps.

use super::{Breaches, Last, Row, Rules, Seen, Who, nose_mps};
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
/// Gain of climb rate behind a lift-off, m/s² (assumed): how long the error of the heights hides it.
const LIFTS_MPS2: f64 = 1.0;
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
        let flies = |z_m: f64| z_m > rules.height_m;
        if flies(last.seen.position_m.z) {
            return;
        }
        let speed = is.norm();
        let l = &who.limits;
        let lifts = flies(s.position_m.z);
        self.speed(rules, who, last, taxies, lifts);
        if lifts {
            return;
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
        // One of two speeds may be off by as much as speeds are.
        let room = rules.acceleration_mps2.max(rules.speed_mps / dt);
        let beside = if taxies { ACROSS_MPS2 } else { 2.0 * ACROSS_MPS2 };
        let beyond = |along: f64, across: f64| {
            along > up + room || along < -down - room || across > beside + room
        };
        // The limits are those of the point that is guided: of a body that swings, the middle has others.
        if beyond(along, across) && guided(who, last, dt, s).is_none_or(|n| beyond(n.0, n.1)) {
            self.accelerations.add(|| {
                format!("{name} {along:.2} along, {across:.2} across, at most {up:.2}, -{down:.2} and {beside:.2} m/s2, {at}, {speed:.1} m/s")
            });
        }
    }

    /// The speed of the sample before: whether it was rolling still, the one after it says. One that lifted off unseen,
    /// lower than the heights are right, has gained speed since.
    fn speed(&mut self, rules: &Rules, who: &Who, last: &Last, taxies: bool, lifts: bool) {
        let l = &who.limits;
        let most = if taxies { l.taxi_mps } else { l.runway_mps.max(EXIT_MPS) };
        let hidden_s = if lifts { (2.0 * rules.height_m / LIFTS_MPS2).sqrt() } else { 0.0 };
        let speed = last.seen.velocity_mps.norm();
        self.speeds.of += 1;
        if speed > most + rules.speed_mps + l.runway_mps2.0 * hidden_s {
            let (name, at_s, at) = (&who.callsign, last.time_s, last.seen.position_m);
            self.speeds.add(|| {
                format!(
                    "{name} {speed:.2} m/s, at most {most:.2}, at {at_s:.1} s, at {:.0} {:.0}",
                    at.x, at.y
                )
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

/// Acceleration of the nose wheel along and across its way, m/s²; `None` with the first samples, and where they are too
/// far apart to tell it from positions.
fn guided(who: &Who, last: &Last, dt: f64, s: &Seen) -> Option<(f64, f64)> {
    let was = last.nose_mps.filter(|_| dt < 0.25)?;
    let is = nose_mps(who, last, dt, s);
    Some(((is.norm() - was.norm()) / dt, is.perp(&was).abs() / is.norm().max(0.1) / dt))
}

fn turned(from_rad: f64, to_rad: f64) -> f64 {
    crate::frames::wrap_pi(to_rad - from_rad)
}
