//! Stands for flights that are drawn by rates: who stands where, from when to when, and who is left out.

use super::drawn::{Drawn, Mix, of_mix};
use super::reach::{Ground, Reach, end_named, needs_m};
use crate::types::TypeTable;
use models::airport::distance_to_segment_m;
use models::frames::{Azimuth, Point2, center};
use models::traffic::core::Direction;
use models::traffic::network::code_of_span;
use models::traffic::outline::{Rectangle, Size, distance_m, outline};
use std::collections::BTreeMap;

/// Index of the code letter from which on a type is an airliner: C.
const AIRLINER_CODE: u8 = 2;
/// An aircraft of the first population is on its stand so long before its off-block, s, and a stand is kept so long after one
/// (assumed).
const BEFORE_S: f64 = 2400.0;
const AFTER_S: f64 = 900.0;
/// A stand is kept so long before a landing, and an aircraft is in block so long after it, s (assumed).
const COMES_S: f64 = 300.0;
const TAXIES_S: f64 = 480.0;
/// Outlines on two stands keep so far apart, m (assumed).
const APART_M: f64 = 4.0;

/// What became of drawn flights.
pub(super) struct Allotted {
    /// The flights, some of another type than they were drawn with.
    pub(super) drawn: Vec<Drawn>,
    /// By flight: the arrival whose aircraft it is.
    pub(super) comes_as: Vec<Option<usize>>,
    /// By flight: its stand, where it is an arrival or of the first population and there is one.
    pub(super) stand_of: Vec<Option<usize>>,
}

/// Stands for drawn flights: a departure is the turn-round of the first arrival that is ready, else of the first population; nobody is
/// put where somebody else is or beside whom there is no room. Who finds none comes as a type of the smaller mixes, one after the
/// other, where these get more flights onto stands, and has none else.
pub(super) fn allotted(
    ground: &Ground<'_>,
    types: &TypeTable,
    usable: &[usize],
    mut drawn: Vec<Drawn>,
    smaller: &[Mix],
) -> Allotted {
    let mut stands = Stands::of(ground, types, usable, &drawn);
    let is_departure = |i: &usize| drawn[*i].direction == Direction::Departure;
    let by_time: Vec<usize> =
        stands.order.iter().copied().filter(|i| stands.comes_as[*i].is_none()).collect();
    let (mut first, landing): (Vec<usize>, Vec<usize>) =
        by_time.iter().partition(|i| is_departure(i));
    first.extend(landing);
    let mut stand_of = stands.allot(&drawn, &first);
    let all = drawn.len();
    // Where stands are few, the first population would take all of them, and nobody could land.
    if stands.served(&stand_of).0 < all {
        let other = stands.allot(&drawn, &by_time);
        if stands.served(&other) > stands.served(&stand_of) {
            stand_of = other;
        }
    }
    for mix in smaller {
        if stands.served(&stand_of).0 == all {
            break;
        }
        let mut others = drawn.clone();
        for (i, d) in others.iter_mut().enumerate() {
            if stand_of[stands.aircraft(i)].is_none()
                && let Some(designator) = of_mix(mix, d.other)
            {
                designator.clone_into(&mut d.designator);
            }
        }
        for order in [&first, &by_time] {
            let other = stands.allot(&others, order);
            if stands.served(&other) > stands.served(&stand_of) {
                stand_of = other;
                drawn.clone_from(&others);
            }
        }
    }
    Allotted { drawn, comes_as: stands.comes_as, stand_of }
}

/// The stands of an airport, and what is known of drawn flights whatever their types.
struct Stands<'a> {
    ground: &'a Ground<'a>,
    types: &'a TypeTable,
    usable: &'a [usize],
    /// By stand: its place, m, and the heading of who stands there, rad.
    poses: Vec<Option<(Point2<f64>, f64)>>,
    /// Taxiways, m, with their code letter, and the widest span that is drawn, m.
    lanes: Vec<([Point2<f64>; 2], u8)>,
    widest_m: f64,
    directions: Vec<Direction>,
    /// Flights by time; by flight the departure as which its aircraft leaves, and the arrival as which it comes.
    order: Vec<usize>,
    leaves_as: Vec<Option<usize>>,
    comes_as: Vec<Option<usize>>,
    /// Known already: stands by runway end, type, direction and number of the day's weather; whether somebody of a size on a stand leaves the lanes free.
    reached: BTreeMap<(String, String, bool, usize), [Vec<bool>; 2]>,
    clear_of: BTreeMap<(usize, u64, u64), bool>,
}

impl<'a> Stands<'a> {
    fn of(
        ground: &'a Ground<'a>,
        types: &'a TypeTable,
        usable: &'a [usize],
        drawn: &[Drawn],
    ) -> Self {
        let network = ground.network;
        let pose = |s: usize| {
            let node = network.stands[s].node?;
            let edge = network.edges.iter().find(|e| e.nodes.contains(&node))?;
            let from = edge.nodes[usize::from(edge.nodes[0] == node)];
            let at_m = network.nodes[node].at_m;
            Some((at_m, Azimuth::of(at_m - network.nodes[from].at_m).rad()))
        };
        let taxiways = network.edges.iter().filter(|e| network.is_taxiway(e));
        let lanes = taxiways.map(|e| (e.nodes.map(|n| network.nodes[n].at_m), e.code)).collect();
        let mut order: Vec<usize> = (0..drawn.len()).collect();
        order.sort_by(|a, b| drawn[*a].time_s.total_cmp(&drawn[*b].time_s).then(a.cmp(b)));
        let (leaves_as, comes_as) = turn_rounds(drawn, &order);
        let mut stands = Self {
            ground,
            types,
            usable,
            poses: (0..network.stands.len()).map(pose).collect(),
            lanes,
            widest_m: 0.0,
            directions: drawn.iter().map(|d| d.direction).collect(),
            order,
            leaves_as,
            comes_as,
            reached: BTreeMap::new(),
            clear_of: BTreeMap::new(),
        };
        stands.widest_m = drawn.iter().map(|d| stands.size_of(d).span_m).fold(36.0, f64::max);
        stands
    }

    /// The flight whose aircraft a flight is: its arrival, else itself.
    fn aircraft(&self, flight: usize) -> usize {
        self.comes_as[flight].unwrap_or(flight)
    }

    fn size_of(&self, d: &Drawn) -> Size {
        let row = self.types.get(&d.designator);
        let (length_m, span_m) = row.map_or((37.6, 35.8), |t| (t.class.length_m, t.class.span_m));
        Size { length_m, span_m, aircraft: true }
    }

    /// How many flights have a stand, and the share of the direction that has less.
    fn served(&self, stand_of: &[Option<usize>]) -> (usize, f64) {
        let of = |direction: Direction| {
            let all = || (0..self.directions.len()).filter(|i| self.directions[*i] == direction);
            let some = all().filter(|i| stand_of[self.aircraft(*i)].is_some()).count();
            (some, some as f64 / all().count().max(1) as f64)
        };
        let [arrivals, departures] = [Direction::Arrival, Direction::Departure].map(of);
        (arrivals.0 + departures.0, arrivals.1.min(departures.1))
    }

    /// Stands that a type reaches from a runway end or leaves for it, by exits and entries with enough of the runway, where there are
    /// such; and those of them that are reached without taxiing along another runway.
    fn reach(
        &mut self,
        (name, time_s): (&str, f64),
        designator: &str,
        arrival: bool,
    ) -> [Vec<bool>; 2] {
        let (ground, types) = (self.ground, self.types);
        let day = ground.days.iter().rposition(|d| d.0 <= time_s).unwrap_or(0);
        let key = (name.to_owned(), designator.to_owned(), arrival, day);
        let found = self.reached.entry(key).or_insert_with(|| {
            let network = ground.network;
            let (Some(end), Some(row)) = (end_named(network, name), types.get(designator)) else {
                return [(); 2].map(|()| vec![true; network.stands.len()]);
            };
            // In the wind in which it is used.
            let ground = ground.in_wind_at(time_s);
            let (reach, code) = (Reach::of(&ground, end, arrival), code_of_span(row.class.span_m));
            let least_m = needs_m(row, &reach, end.1) - 1.0;
            let stands = reach.stands(code, least_m);
            let (stands, least_m) = match stands.contains(&true) {
                true => (stands, least_m),
                false => (reach.stands(code, 0.0), 0.0),
            };
            [stands, reach.stands_off_runways(code, least_m)]
        });
        found.clone()
    }

    /// Whether somebody of a size on a stand leaves the lanes free.
    fn is_clear(&mut self, stand: usize, size: Size) -> bool {
        let key = (stand, size.length_m.to_bits(), size.span_m.to_bits());
        let (poses, lanes, widest_m) = (&self.poses, &self.lanes, self.widest_m);
        *self.clear_of.entry(key).or_insert_with(|| {
            poses[stand].is_some_and(|(at_m, heading_rad)| {
                clear_of_lanes(lanes, &outline(size, at_m, heading_rad), widest_m)
            })
        })
    }

    /// By flight a stand, given in this order.
    fn allot(&mut self, drawn: &[Drawn], order: &[usize]) -> Vec<Option<usize>> {
        let network = self.ground.network;
        let mut taken: Vec<Taken> = Vec::new();
        let mut stand_of: Vec<Option<usize>> = vec![None; drawn.len()];
        for i in order.iter().copied() {
            let d = &drawn[i];
            let size = self.size_of(d);
            let next = self.leaves_as[i];
            let span_s = match (d.direction, next) {
                (Direction::Departure, _) => [d.time_s - BEFORE_S, d.time_s + AFTER_S],
                (_, Some(next)) => [d.time_s - COMES_S, drawn[next].time_s + AFTER_S],
                _ => [d.time_s - COMES_S, f64::INFINITY],
            };
            let need = code_of_span(size.span_m);
            let [mut reached, mut off_runways] =
                self.reach((&d.runway, d.time_s), &d.designator, d.direction == Direction::Arrival);
            if let Some(next) = next {
                let [left, off] =
                    self.reach((&drawn[next].runway, drawn[next].time_s), &d.designator, false);
                reached.iter_mut().zip(left).for_each(|(r, l)| *r &= l);
                off_runways.iter_mut().zip(off).for_each(|(r, l)| *r &= l);
            }
            let fits = |s: &usize| network.stands[*s].code >= need && reached[*s];
            let free = |s: &usize| self.is_free(*s, size, span_s, &taken);
            let mut fitting: Vec<usize> =
                self.usable.iter().copied().filter(|s| fits(s) && free(s)).collect();
            // Airliners stand among light aircraft and helicopters only where nothing else is left.
            let usual = |s: &usize| need < AIRLINER_CODE || !network.stands[*s].light;
            if fitting.iter().any(usual) {
                fitting.retain(usual);
            }
            // Nobody taxies along a runway on which others land or take off, where there is an elsewhere.
            if fitting.iter().any(|s| off_runways[*s]) {
                fitting.retain(|s| off_runways[*s]);
            }
            // Who would close a lane goes elsewhere, where there is an elsewhere.
            if fitting.iter().any(|s| self.is_clear(*s, size)) {
                fitting.retain(|s| self.is_clear(*s, size));
            }
            if fitting.is_empty() {
                continue;
            }
            let stand = fitting[(d.place * fitting.len() as f64) as usize % fitting.len()];
            taken.push(Taken { stand, span_s, size });
            stand_of[i] = Some(stand);
        }
        stand_of
    }

    /// Whether nobody is on a stand, or so near that there is no room, at a time.
    fn is_free(&self, stand: usize, size: Size, [from, to]: [f64; 2], taken: &[Taken]) -> bool {
        let Some((at_m, heading_rad)) = self.poses[stand] else { return false };
        taken.iter().all(|other| {
            if other.span_s[0] >= to || other.span_s[1] <= from {
                return true;
            }
            let Some((there, towards)) = self.poses[other.stand] else { return true };
            let own = || outline(size, at_m, heading_rad);
            other.stand != stand
                && ((there - at_m).norm() > 120.0
                    || distance_m(&own(), &outline(other.size, there, towards)) > APART_M)
        })
    }
}

/// A stand that is given, for a time, s.
struct Taken {
    stand: usize,
    span_s: [f64; 2],
    size: Size,
}

/// By flight: as which departure an arrival leaves, and as which arrival a departure comes: of those that are ready the first.
fn turn_rounds(drawn: &[Drawn], order: &[usize]) -> (Vec<Option<usize>>, Vec<Option<usize>>) {
    let mut leaves_as: Vec<Option<usize>> = vec![None; drawn.len()];
    let mut comes_as: Vec<Option<usize>> = vec![None; drawn.len()];
    for d in order.iter().filter(|d| drawn[**d].direction == Direction::Departure) {
        let ready = order.iter().copied().find(|a| {
            drawn[*a].direction == Direction::Arrival
                && leaves_as[*a].is_none()
                && drawn[*a].time_s + TAXIES_S + drawn[*a].turn_round_s <= drawn[*d].time_s
        });
        if let Some(a) = ready {
            (leaves_as[a], comes_as[*d]) = (Some(*d), Some(a));
        }
    }
    (leaves_as, comes_as)
}

/// Whether the widest of the demand can pass a parked outline on every lane that is wide enough for it.
fn clear_of_lanes(
    lanes: &[([Point2<f64>; 2], u8)],
    parked: &[Rectangle; 2],
    widest_m: f64,
) -> bool {
    let middle = center(&parked[0].corners_m[0], &parked[0].corners_m[2]);
    lanes.iter().all(|([a, b], code)| {
        let (a, b) = (*a, *b);
        if distance_to_segment_m(middle, a, b) > 80.0 {
            return true;
        }
        let line = Rectangle { corners_m: [a, b, b, a] };
        let span_m = if *code >= code_of_span(widest_m) { widest_m } else { 36.0 };
        distance_m(parked, &[line; 2]) > 0.5 * span_m + 3.0
    })
}
