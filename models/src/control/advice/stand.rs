//! Stand conflicts: who is to come to a stand before the one on it has left.

use super::{Found, Picture, What, expected_taxi_out_s};
use crate::control::actors::message::Seat;
use crate::traffic::ahead::{Direction, Seen, class_of, perceive};

/// Arrivals that are to land later do not count, s.
pub const AHEAD_S: f64 = 900.0;
/// From the push-back until the stand is free, s (assumed).
const LEAVES_S: f64 = 120.0;
/// From the threshold to being off the runway, s (assumed).
const ROLLS_OUT_S: f64 = 60.0;
/// On final, m/s (assumed).
const FINAL_MPS: f64 = 70.0;
/// Of a stand that nobody knows to be left: it is not free before so long, s.
const LONG_S: f64 = 900.0;

/// Arrivals whose stand is not free when they come.
pub(super) fn look(now_s: f64, picture: &Picture<'_>) -> Vec<Found> {
    let moment = perceive(picture.known, picture.network, picture.flights, picture.frame, 0);
    let (net, flights) = (picture.network, picture.flights);
    // Who comes to which stand, and when.
    let mut comes: Vec<(usize, usize, f64)> = Vec::new();
    for (m, f) in flights.iter().enumerate().filter(|(_, f)| f.direction == Direction::Arrival) {
        let taxi_s = |from_m: crate::frames::Point2<f64>, stand: usize| {
            expected_taxi_s((net.stands[stand].at_m - from_m).norm())
        };
        let threshold_m = net.runways[f.runway.0].ends_m[f.runway.1];
        let (stand, comes_s) = match &moment.seen[m] {
            Seen::Planned if f.time_s <= now_s + AHEAD_S => {
                let stand = picture.stand_of(m);
                (stand, f.time_s.max(now_s) + ROLLS_OUT_S + taxi_s(threshold_m, stand))
            }
            Seen::OnFinal { distance_m, stand } => {
                let lands_s = now_s + distance_m / FINAL_MPS;
                (*stand, lands_s + ROLLS_OUT_S + taxi_s(threshold_m, *stand))
            }
            Seen::Taxiing(at) | Seen::OnRunway(at) => {
                let stand = at.stand.unwrap_or(f.stand);
                (stand, now_s + taxi_s(at.middle_m, stand))
            }
            _ => continue,
        };
        comes.push((m, stand, comes_s));
    }
    let on = |stand: usize| moment.seen.iter().position(|s| *s == Seen::OnStand(stand));
    let mut found = Vec::new();
    for (m, stand, comes_s) in &comes {
        let Some(there) = on(*stand).filter(|o| o != m) else { continue };
        let leaves = match flights[there].direction {
            Direction::Departure => Some(there),
            Direction::Arrival => flights.iter().position(|g| g.turnaround_of == Some(there)),
            Direction::Vehicle => continue,
        };
        // Its own next flight is no other.
        if leaves.is_some_and(|d| flights[d].turnaround_of == Some(*m)) {
            continue;
        }
        let free_s = leaves.map(|d| flights[d].time_s.max(now_s) + LEAVES_S);
        if free_s.is_some_and(|free_s| free_s <= *comes_s) {
            continue;
        }
        let need = class_of(flights[*m].size).saturating_sub(1);
        let away_m = |s: &usize| (net.stands[*s].at_m - net.stands[*stand].at_m).norm();
        let instead = (0..net.stands.len())
            .filter(|s| net.stands[*s].node.is_some_and(|n| net.nodes[n].used))
            .filter(|s| net.stands[*s].code >= need && on(*s).is_none())
            .filter(|s| !comes.iter().any(|c| c.1 == *s))
            .min_by(|a, b| away_m(a).total_cmp(&away_m(b)));
        found.push(Found {
            seat: Seat::Apron,
            flight: *m as u32,
            other: Some(there as u32),
            until_s: *comes_s,
            value: free_s.map_or(LONG_S, |free_s| free_s - comes_s),
            what: What::StandConflict { stand: *stand, free_s, comes_s: *comes_s, instead },
        });
    }
    found
}

/// Expected time on the ground over a distance as the crow flies, s: as [`expected_taxi_out_s`] without a push-back.
fn expected_taxi_s(distance_m: f64) -> f64 {
    expected_taxi_out_s(distance_m) - expected_taxi_out_s(0.0)
}
