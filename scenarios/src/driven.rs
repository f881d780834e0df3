//! `[[traffic]] kind = "driven"`: a vehicle or an aircraft that a person drives, and the seat from which he does.

use crate::document::Section;
use crate::error::{Problem, ScenarioError};
use crate::places::Places;
use crate::schedule::{Behaving, wheelbase_m};
use crate::types::TypeRow;
use models::airport::Airport;
use models::frames::{Azimuth, Point2, Vector2};
use models::plot::Callsign;
use models::traffic::core::Driven;
use models::traffic::outline::Size;

/// Distance of a vehicle's axles, in parts of its length (assumed).
const VEHICLE_WHEELBASE: f64 = 0.58;
/// Half the width of a service road, m (assumed).
const HALF_ROAD_M: f64 = 5.0;

/// Outlines of everything paved that the network does not tell, m, not closed: aprons and service roads.
pub(crate) fn pavement_m(layout: &Airport) -> Vec<Vec<Point2<f64>>> {
    let road = |[a, b]: [Point2<f64>; 2]| {
        let along = (b - a) / (b - a).norm().max(1e-9);
        let aside = Vector2::new(along.y, -along.x) * HALF_ROAD_M;
        vec![a + aside, b + aside, b - aside, a - aside]
    };
    let roads = layout.details.roads.iter().map(|(ends, _)| road(*ends));
    layout.pavement.iter().cloned().chain(roads).collect()
}

/// Where it stands at first, and what its type can do.
pub(crate) fn read(
    section: &Section,
    places: &Places<'_>,
    callsign: Callsign,
    row: &TypeRow,
) -> Result<Driven, ScenarioError> {
    let text = callsign.to_string();
    if !text.chars().all(|c| c.is_ascii_alphanumeric()) {
        // The name is part of the seat's, by which it is asked for.
        let needed = "letters and digits only, for what a person drives".into();
        let found = format!("the text {text:?}");
        return Err(section.refuse("callsign", Problem::WrongKind { found, needed }));
    }
    let name = section.need_text("stand", "the name of a stand or of a node")?;
    let layout = places.layout();
    let (at_m, heading_rad) = match (places.stand(name), places.node(name)) {
        (Some(stand), _) => (stand.position_m, stand.heading_rad),
        (None, Some(node)) => {
            let at_m = layout.nodes[node].position_m;
            // Along the first way that leads from there.
            let on = |e: &&models::airport::Edge| e.from == node || e.to == node;
            let way = layout.edges.iter().find(on).map(|e| {
                let other = if e.from == node { e.to } else { e.from };
                layout.nodes[other].position_m - at_m
            });
            (at_m, way.map_or(0.0, |way| Azimuth::of(way).rad()))
        }
        (None, None) => {
            let allowed = "a stand, or the number of a node, of the ground network".into();
            return Err(
                section.refuse("stand", Problem::NotAllowed { found: name.to_owned(), allowed })
            );
        }
    };
    let (class, k) = (&row.class, &row.kinematics);
    Ok(Driven {
        callsign: callsign.to_string(),
        size: Size { length_m: class.length_m, span_m: class.span_m, aircraft: class.aircraft },
        wheelbase_m: match class.aircraft {
            true => wheelbase_m(&class.designator, class.length_m),
            false => VEHICLE_WHEELBASE * class.length_m,
        },
        most_mps: k.taxi_straight_mps,
        acc_dec_mps2: (k.taxi_acc_ms2, k.taxi_dec_ms2),
        at_m,
        heading_rad,
    })
}

/// Name of the seat from which a mover is driven: "driver FOLLOW1", "pilot HBIJA".
#[must_use]
pub fn seat_of(mover: &Driven) -> String {
    let role = if mover.size.aircraft { "pilot" } else { "driver" };
    format!("{role} {}", mover.callsign)
}

/// Name of the seat from which a flight is taken while it taxies.
#[must_use]
pub fn seat_of_flight(callsign: &str) -> String {
    format!("pilot {callsign}")
}

/// What is driven from a seat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wheel {
    /// A mover of the scene that is there to be driven, from 0.
    Driven(usize),
    /// A flight, from 0.
    Flight(usize),
}

/// What is driven from a seat; none where it is no such seat.
#[must_use]
pub fn at_seat(behaving: &Behaving, seat: &str) -> Option<Wheel> {
    let driven = behaving.driven.iter().position(|mover| seat_of(mover) == seat);
    let callsign = seat.strip_prefix("pilot ").filter(|_| behaving.by_hand);
    let flight = || behaving.flights.iter().position(|f| Some(&*f.callsign) == callsign);
    driven.map(Wheel::Driven).or_else(|| flight().map(Wheel::Flight))
}
