//! A flight that a person taxies: taken while it taxies, driven as [`hand`](super::hand) says, given back to its model.
//!
//! It keeps its way, its plan and its pieces: while it is on its way it takes and leaves pieces as ever, so others plan with it. Where it leaves
//! its way, or goes beyond what it may, it is an obstacle for the others as well. Given back on its way it goes on, at once where it can still
//! stop for what is not its own, else after it has come to a stand; elsewhere it stands, and is towed to a stand after a minute.

use super::hand::{AtWheel, Driven, Hand};
use super::{ASK_M, Core, Direction, Order, Phase, Timing};
use crate::frames::{Vector2, wrap_pi};
use crate::traffic::profile::stopping;

/// On its way: so far beside it, m, and so far from its direction, rad (spec of the views, section 6).
const ON_WAY_M: f64 = 5.0;
const ON_WAY_RAD: f64 = core::f64::consts::PI / 6.0;
/// The nearest place of its way is looked for so far back and ahead, m.
const LOOKS_M: [f64; 2] = [5.0, 40.0];
/// Wheels that point along the way, rad: the nose goes on in the same direction.
const ALIGNED_RAD: f64 = 0.03;
/// So near the end of its way the model goes on by itself, m: it lines up, or parks, to the decimetre.
const AT_END_M: f64 = 4.0;
/// Left beside its way it is towed after, s.
const TOWED_AFTER_S: f64 = 60.0;

impl Core {
    /// Whether a person can take a flight now: it taxies, and nothing has failed with it.
    #[must_use]
    pub fn may_be_taken(&self, flight: usize) -> bool {
        let Some(mover) = self.movers.get(flight) else { return false };
        self.flights_by_hand
            && mover.phase == Phase::Taxiing
            && mover.hand.is_none()
            && !(mover.stopped || mover.towed || self.is_vehicle(flight))
    }

    /// How a flight is that a person drives; `None` while nobody does.
    #[must_use]
    pub fn flight_at_wheel(&self, flight: usize) -> Option<AtWheel> {
        self.movers.get(flight)?.hand.as_ref().map(|hand| hand.at_wheel(self.time_s))
    }

    /// What a person at the wheel of a flight does.
    pub(super) fn fly_by_hand(&mut self, m: usize, order: Order) {
        let now = self.time_s;
        if order == Order::Take && self.may_be_taken(m) {
            self.take_flight(m);
        }
        if let Some(hand) = &mut self.movers[m].hand {
            hand.told(order, now);
        } else if order == Order::Take {
            let name = self.flights[m].callsign.clone();
            self.remark(format!("{name} cannot be taken: it does not taxi"));
        }
    }

    fn take_flight(&mut self, m: usize) {
        let Some(state) = self.state(m) else { return };
        let (flight, mover) = (&self.flights[m], &self.movers[m]);
        let mut hand = Hand::new(Driven {
            callsign: flight.callsign.clone(),
            size: flight.size,
            wheelbase_m: flight.wheelbase_m,
            most_mps: flight.taxi_mps.0,
            acc_dec_mps2: flight.taxi_acc_mps2,
            at_m: state.position_m.xy(),
            heading_rad: state.heading_rad,
        });
        (hand.v, hand.a, hand.steer_rad) = (mover.v, mover.a, mover.slip);
        self.movers[m].hand = Some(Box::new(hand));
        self.goes_by_sight(m);
        self.version += 1;
    }

    /// One step of a flight that a person drives.
    pub(super) fn taxi_by_hand(&mut self, m: usize) {
        let Some(mut hand) = self.movers[m].hand.take() else { return };
        let (now, dt) = (self.time_s, self.step_s);
        hand.step(now, dt);
        if hand.v > 0.0 {
            hand.off_pavement = !self.is_paved(&hand);
        }
        let mover = &self.movers[m];
        let nose_m = hand.nose_m;
        let (from, to) = (mover.s - LOOKS_M[0], (mover.s + LOOKS_M[1]).min(mover.way.stop_m));
        let beside_m = |place: f64| (mover.way.path.at(place).at_m - nose_m).norm();
        let nearest = |from: f64, to: f64, step: f64| -> f64 {
            let count = ((to - from) / step).max(0.0) as usize;
            let places = (0..=count).map(|k| from + step * k as f64);
            places.min_by(|a, b| beside_m(*a).total_cmp(&beside_m(*b))).unwrap_or(from)
        };
        let near = nearest(from.max(0.0), to.max(0.0), 1.0);
        let place = nearest((near - 1.0).max(0.0), near + 1.0, 0.05).min(mover.way.stop_m);
        let on = mover.way.path.at(place);
        let off_m = nose_m - on.at_m;
        let turned = wrap_pi(on.heading_rad - hand.heading_rad);
        let on_way = off_m.norm() <= ON_WAY_M && turned.abs() <= ON_WAY_RAD && !hand.backwards;
        let mover = &mut self.movers[m];
        (mover.v, mover.a) = (hand.v, hand.a);
        if on_way {
            mover.s = mover.s.max(place);
            mover.slip = turned;
            self.take_ahead(m);
            self.release_behind(m);
        }
        let mover = &self.movers[m];
        let ahead_m = self.authority(m) - mover.s;
        hand.beside = !on_way || ahead_m < -1.0;
        // Given back it steers onto its way; the model has it when the wheels point along that, or from a stand.
        hand.guided_rad = (on_way && !hand.taken).then_some(turned);
        let aligned = (turned - hand.steer_rad).abs() < ALIGNED_RAD;
        let needed =
            stopping(hand.v, hand.a, 0.7 * mover.driving.dec_mps2, mover.driving.jerk_mps3, dt).0;
        let stops = aligned && needed + ASK_M <= ahead_m || hand.v == 0.0 && ahead_m >= -1.0;
        let ends = hand.v == 0.0 && mover.way.stop_m - mover.s < AT_END_M;
        if on_way && stops && (!hand.taken || ends) {
            self.goes_on_by_itself(m, &hand, place, off_m, turned);
            return;
        }
        match (hand.taken || hand.v > 0.0, hand.left_s) {
            (true, _) => hand.left_s = None,
            (false, None) => hand.left_s = Some(now),
            (false, Some(since)) if now - since > TOWED_AFTER_S => {
                self.movers[m].hand = Some(hand);
                self.tow_from_beside(m);
                return;
            }
            (false, Some(_)) => {}
        }
        self.movers[m].hand = Some(hand);
    }

    /// The model has it again, from the same place, speed and heading; it comes to its line as after a pushback.
    fn goes_on_by_itself(
        &mut self,
        m: usize,
        hand: &Hand,
        place: f64,
        off_m: Vector2<f64>,
        turned: f64,
    ) {
        let mover = &mut self.movers[m];
        (mover.s, mover.v, mover.a, mover.slip) = (place, hand.v, hand.a, turned);
        (mover.beside_m, mover.beside_from) = (off_m, place);
        mover.wander = mover.wander.anew();
        mover.refused_at = None;
        self.version += 1;
        let name = self.flights[m].callsign.clone();
        self.remark(format!("{name} goes on by itself"));
    }

    /// Left beside its way: an arrival is towed to its stand, a departure to a free one, from which it goes again.
    fn tow_from_beside(&mut self, m: usize) {
        let arrival = self.flights[m].direction == Direction::Arrival;
        let (own, size, now) = (self.movers[m].stand, self.flights[m].size, self.time_s);
        let parked = self.pieces_of_stand(own, size);
        let stand = match arrival {
            true => self.stand_is_free(m, own, &parked).then_some(own),
            false => self.free_stands(m, 6).into_iter().next().map(|(stand, _)| stand),
        };
        // Nowhere to go yet: it stays, and is looked at again.
        let Some(stand) = stand else { return };
        let name = self.flights[m].callsign.clone();
        let to = self.net.stands[stand].name.clone();
        self.remark(format!("{name}: left beside its way, towed to stand {to}"));
        self.release_held(m);
        self.keep_for_roll(m, Vec::new());
        self.vacate(m);
        let mover = &mut self.movers[m];
        (mover.hand, mover.timing) = (None, Timing::default());
        (mover.push, mover.way) = Default::default();
        (mover.granted, mover.insisted) = Default::default();
        (mover.first_held, mover.next, mover.s, mover.v, mover.a, mover.slip) =
            (0, 0, 0.0, 0.0, 0.0, 0.0);
        if arrival {
            parked.iter().for_each(|z| self.hold(m, *z, false));
            let mover = &mut self.movers[m];
            (mover.parked_pieces, mover.phase) = (parked, Phase::Docked);
            mover.measures.aibt_s = Some(now);
            mover.measures.taxi_s = Some(now - mover.taxi_from_s);
        } else {
            (mover.phase, mover.tow_to) = (Phase::Absent, Some(stand));
            mover.next_try_s = now + 120.0;
        }
        // Nothing that it was cleared for holds any more, for a runway in whose strip it was left neither.
        self.end_clearances(m);
        self.version += 1;
        self.book();
    }

    /// Flights that are beside their ways, by hand: index, and the poses on which they could stop.
    pub(super) fn beside_their_ways(&self) -> Vec<(usize, &Hand)> {
        if !self.flights_by_hand {
            return Vec::new();
        }
        let mut found = Vec::new();
        for (m, mover) in self.movers.iter().enumerate() {
            found.extend(mover.hand.as_deref().filter(|h| h.beside).map(|hand| (m, hand)));
        }
        found
    }
}
