//! Where every flight is, from tracks, strips and flight plans.

use super::Moment;
use crate::control::clearance::{Board, ClearanceKind, Kinds, Strip};
use crate::control::layout::Layout;
use crate::control::situation::{Situation, Surveillance};
use crate::frames::{Azimuth, Point2, Vector2, center};
use crate::plot::Callsign;
use crate::time::SimTime;
use crate::traffic::core::{Day, Direction, Flight, OnGround, Seen};
use crate::traffic::network::Network;

/// What is known of an airport in a scan.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// Strips and what stands on them.
    pub board: &'a Board,
    /// What each track is to the airport.
    pub surveillance: &'a Surveillance,
    /// Where its runways are.
    pub layout: &'a Layout,
}

/// A stand of the network this near a place is that of the place, m.
const STAND_M: f64 = 60.0;
/// Who was cleared to push and is nearer to his stand is still there, m.
const PUSHED_M: f64 = 40.0;
/// From the push-back to taxiing, at most, s (assumed: tug and engines).
const STARTS_S: f64 = 60.0;

/// The airport as it is known at a frame, of `step_s` seconds.
#[must_use]
pub fn perceive(
    known: Known<'_>,
    net: &Network,
    flights: &[Flight],
    (frame, step_s): (i64, f64),
    seed: u64,
) -> Moment {
    let now = SimTime::from_s(frame as f64 * step_s);
    let (seen, unseen, day) = (Vec::new(), Vec::new(), Day::default());
    let mut moment = Moment { frame, step_s, seed, day, seen, unseen };
    for (m, flight) in flights.iter().enumerate() {
        let strip = known.board.find(Callsign::new(&flight.callsign));
        let track = strip.and_then(|i| known.surveillance.of_strip(i as u32));
        let strip = strip.map(|i| &known.board.strips()[i]);
        let one = One { known, net, flight, strip, track, now };
        let seen = match flight.direction {
            Direction::Departure => one.departure(),
            Direction::Arrival => one.arrival(),
            Direction::Vehicle => None,
        };
        if seen.is_none() {
            moment.unseen.push(m as u32);
        }
        moment.seen.push(seen.unwrap_or(Seen::Gone));
    }
    // The aircraft of a departure that has been cleared is no arrival's any more.
    for (m, flight) in flights.iter().enumerate() {
        if let (Some(arrival), true) = (flight.turnaround_of, moment.seen[m] != Seen::Planned)
            && let Some(seen @ Seen::OnStand(_)) = moment.seen.get_mut(arrival)
        {
            *seen = Seen::Gone;
        }
    }
    moment
}

/// One flight, its strip and its track.
struct One<'a> {
    known: Known<'a>,
    net: &'a Network,
    flight: &'a Flight,
    strip: Option<&'a Strip>,
    track: Option<&'a Situation>,
    now: SimTime,
}

impl One<'_> {
    /// Where a departure is; `None`: under way, and not seen.
    fn departure(&self) -> Option<Seen> {
        use ClearanceKind::{Cross, Hold, LineUp, Push, TakeOff, Taxi};
        let Some(strip) = self.strip else { return Some(Seen::Planned) };
        let kinds = strip.kinds;
        if strip.flew_until.is_some() && !kinds.has(TakeOff) {
            return Some(Seen::Gone);
        }
        let moves = Kinds::of(&[Taxi, Cross, LineUp, TakeOff, Hold]);
        if !kinds.any(moves) && strip.moved_until.is_none() && !kinds.has(Push) {
            // Whose aircraft has not come in yet has no stand.
            let turns = self.flight.turnaround_of.is_some();
            return Some(if turns { Seen::Planned } else { Seen::OnStand(self.stand()) });
        }
        let stand_m = self.net.stands[self.stand()].at_m;
        let track = match self.track {
            Some(track) => track,
            None if kinds.has(Push) => return Some(Seen::OnStand(self.stand())),
            None => return None,
        };
        let pushed = kinds.any(moves);
        if !pushed && (track.target.position_m - stand_m).norm() < PUSHED_M {
            return Some(Seen::OnStand(self.stand()));
        }
        if track.airborne {
            return Some(Seen::Gone);
        }
        let at = OnGround {
            starts_in_s: if pushed { 0.0 } else { STARTS_S },
            ..self.on_ground(strip, track)
        };
        let on_runway = self.own_runway().is_some_and(|r| track.in_strip(r));
        let entered = on_runway && kinds.any(Kinds::of(&[LineUp, TakeOff]));
        Some(if entered { Seen::OnRunway(at) } else { Seen::Taxiing(at) })
    }

    /// Where an arrival is; `None`: under way, and not seen.
    fn arrival(&self) -> Option<Seen> {
        use ClearanceKind::{Cross, Hold, Land, Taxi};
        let Some(strip) = self.strip else { return Some(Seen::Planned) };
        let kinds = strip.kinds;
        let landed = strip.flew_until.is_some() || strip.moved_until.is_some();
        let moves = kinds.any(Kinds::of(&[Taxi, Cross, Hold]));
        if !kinds.has(Land) && !moves && strip.moved_until.is_some() {
            return Some(Seen::OnStand(self.stand()));
        }
        let Some(track) = self.track else {
            return (!landed && !moves).then_some(Seen::Planned);
        };
        if let Some(on_final) = track.on_final.filter(|_| !moves) {
            let distance_m = on_final.distance_m.max(0.0);
            return Some(Seen::OnFinal { distance_m, stand: self.stand() });
        }
        let on_runway = self.own_runway().is_some_and(|r| track.in_strip(r));
        if !on_runway && !moves {
            // Comes from far away, or has just left its runway.
            let on_ground = landed || kinds.has(Land) && !track.airborne;
            return Some(match on_ground {
                true => Seen::Taxiing(self.on_ground(strip, track)),
                false => Seen::Planned,
            });
        }
        let at = self.on_ground(strip, track);
        Some(if on_runway && !moves { Seen::OnRunway(at) } else { Seen::Taxiing(at) })
    }

    fn own_runway(&self) -> Option<usize> {
        let (r, end) = self.flight.runway;
        self.known.layout.runway(&self.net.runways[r].names[end]).map(|r| r.0)
    }

    fn stand(&self) -> usize {
        stand_of(self.strip, self.net, self.flight)
    }

    fn on_ground(&self, strip: &Strip, track: &Situation) -> OnGround {
        let middle_m = track.target.position_m;
        let ahead_m = track.nose_m - middle_m;
        let velocity = track.target.velocity_mps;
        let along = match (velocity.norm() > 2.0, ahead_m.norm() > 1.0) {
            (true, _) => velocity,
            (_, true) => ahead_m,
            _ => direction_of(&strip.way_m, middle_m).unwrap_or(ahead_m),
        };
        let still = self.now.since_s(track.still_since) > 5.0;
        OnGround {
            middle_m,
            heading_rad: Azimuth::of(along).rad(),
            speed_mps: if still { 0.0 } else { track.judged_mps },
            cleared_way_m: strip.way_m.clone(),
            starts_in_s: 0.0,
            stand: Some(self.stand()),
        }
    }
}

/// The stand of a flight by index: that of its strip, else of its plan.
#[must_use]
pub fn stand_of(strip: Option<&Strip>, net: &Network, flight: &Flight) -> usize {
    let Some(at_m) = strip.and_then(|s| s.stand_m) else { return flight.stand };
    let away_m = |s: usize| (net.stands[s].at_m - at_m).norm();
    let nearest = (0..net.stands.len()).min_by(|a, b| away_m(*a).total_cmp(&away_m(*b)));
    nearest.filter(|s| away_m(*s) < STAND_M).unwrap_or(flight.stand)
}

/// Where a line leads beside a point.
fn direction_of(line_m: &[Point2<f64>], point_m: Point2<f64>) -> Option<Vector2<f64>> {
    let middle = |w: &[Point2<f64>]| (center(&w[0], &w[1]) - point_m).norm();
    let nearest = line_m.windows(2).min_by(|a, b| middle(a).total_cmp(&middle(b)))?;
    Some(nearest[1] - nearest[0]).filter(|d| d.norm() > 0.1)
}
