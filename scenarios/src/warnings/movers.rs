//! What is silly about movers, the stands and runways that they are given, and sensors that see none of them.

use crate::document::{Section, within};
use crate::entity::Entity;
use crate::error::ScenarioError;
use crate::keys::{self, words};
use crate::{Scene, SensorScene};
use models::airport::{Airport, distance_to_segment_m};
use models::flight_list::MovementKind;
use models::frames::Point2;
use models::time::SimTime;
use models::traffic::core::{Direction, FailureKind};
use models::traffic::network::{NetRunway, Network, code_index, code_of_span};
use models::truth::Trajectory;
use models::truth::recorded::Held;
use std::cell::OnceCell;

/// Number, table, key, sentence.
pub(super) type Found = (u8, Section, &'static str, String);

/// Failures that never come: what goes wrong does not happen to a flight of this direction.
pub(super) fn failures(scene: &Scene, sections: &[Section]) -> Result<Vec<Found>, ScenarioError> {
    let Some(behaving) = &scene.traffic.behaving else { return Ok(Vec::new()) };
    let mut found = Vec::new();
    for section in sections {
        let (kind, name) =
            (section.choice("kind", &FailureKind::WORDS)?, section.text("callsign")?);
        let flight = behaving.flights.iter().find(|f| Some(&f.callsign[..]) == name);
        let (Some(kind), Some(flight)) = (kind, flight) else { continue };
        if !kind.happens_to(flight.direction) {
            let (of, word) = (flight.direction.word(), kind.word());
            let other = match flight.direction {
                Direction::Departure => Direction::Arrival.word(),
                _ => Direction::Departure.word(),
            };
            let text = format!(
                "'{}' is {of}, to which \"{word}\" does not happen: name {other}, or leave the table out",
                flight.callsign
            );
            found.push((25, section.clone(), "kind", text));
        }
    }
    Ok(found)
}

/// All that is found.
pub(super) fn of(
    scene: &Scene,
    traffic: &[Section],
    sensors: &[Section],
) -> Result<Vec<Found>, ScenarioError> {
    let mut found = Vec::new();
    let network = OnceCell::new();
    let network = || network.get_or_init(|| Network::of(&scene.airport.layout));
    for section in traffic {
        let callsign = section.text("callsign")?.unwrap_or("");
        let mover = scene.traffic.entities.iter().find(|e| e.callsign.as_str() == callsign);
        if let Some(mover) = mover {
            of_mover(scene, section, mover, &network, &mut found)?;
        }
        for key in ["arrival_runways", "departure_runways"] {
            for (name, _) in section.texts(key)? {
                if is_without_ways(network(), &name) {
                    found.push((23, section.clone(), key, no_ways(&name)));
                }
            }
        }
    }
    for (sensor, section) in scene.sensors.iter().zip(sensors) {
        if let Some((number, key, text)) = out_of_reach(scene, sensor) {
            found.push((number, section.clone(), key, text));
        }
    }
    Ok(found)
}

fn of_mover<'a>(
    scene: &Scene,
    section: &Section,
    mover: &Entity,
    network: &impl Fn() -> &'a Network,
    found: &mut Vec<Found>,
) -> Result<(), ScenarioError> {
    let mut say = |number, section: &Section, key, text: String| {
        found.push((number, section.clone(), key, text));
    };
    let layout = &scene.airport.layout;
    let duration_s = scene.run.duration.s();
    let kind = section.text("kind")?.unwrap_or("");
    if let Some(flight) = section.section("flight", &words(keys::FLIGHT))? {
        let entry = scene.flight_list.entries.iter().find(|e| e.callsign == mover.callsign);
        let arrives = entry.is_some_and(|e| e.movement == MovementKind::Arrival);
        let eta_s = flight.number("eta_ctd_s", within(f64::NEG_INFINITY, f64::INFINITY, "s"))?;
        if let Some(eta_s) = eta_s.filter(|eta_s| arrives && *eta_s > duration_s) {
            say(
                17,
                &flight,
                "eta_ctd_s",
                format!(
                    "the run ends at {duration_s} s, before it lands at {eta_s} s: let it land earlier or make run.duration_s longer"
                ),
            );
        }
        if let Some(name) = flight.text("runway")?.filter(|r| is_without_ways(network(), r)) {
            say(23, &flight, "runway", no_ways(name));
        }
        if let Some(text) = flight.text("stand")?.and_then(|s| too_small(layout, s, mover)) {
            say(21, &flight, "stand", text);
        }
    }
    if kind == "parked"
        && let Some(stand) = section.text("stand")?
    {
        if let Some(text) = too_small(layout, stand, mover) {
            say(21, section, "stand", text);
        }
        if let Some(way) = in_a_lane(layout, stand) {
            say(
                22,
                section,
                "stand",
                format!(
                    "\"{stand}\" lies on the way along {way}, and it stands there all the time: others drive through it"
                ),
            );
        }
    }
    let key = if kind == "route" { "via" } else { "file" };
    if let Some(trajectory) = mover.trajectory.as_ref().filter(|_| section.has(key)) {
        let last = SimTime(trajectory.end().0.min(scene.run.duration.0) - 1);
        let under_way = trajectory.at(last).is_some_and(|s| s.velocity_mps.norm() > 0.5);
        if kind == "route" && under_way {
            say(
                17,
                section,
                "via",
                format!(
                    "the run ends at {duration_s} s, before it is at the end of its way: start it earlier or make run.duration_s longer"
                ),
            );
        }
        if let (false, Some((name, at_s))) = (mover.class.aircraft, on_a_runway(layout, trajectory))
        {
            say(
                19,
                section,
                key,
                format!(
                    "a vehicle on runway {name} at {at_s} s, where nobody lets it: it raises alerts; take another way, or say that it is meant"
                ),
            );
        }
    }
    let speeds = [Held::TaxiSpeed, Held::TakeoffSpeed, Held::LandingSpeed];
    let held = mover.report.iter().flat_map(|r| &r.held);
    let fastest = held
        .filter(|h| speeds.contains(&h.limit) && h.recorded > MUCH_FASTER * h.value)
        .max_by(|a, b| (a.recorded / a.value).total_cmp(&(b.recorded / b.value)));
    if let Some(held) = fastest {
        let (designator, column) = (&mover.class.designator, held.limit.column().0);
        say(
            20,
            section,
            "type",
            format!(
                "the recording has {:.1} m/s where {designator} has {column} = {} m/s at the most: is it that type?",
                held.recorded, held.value
            ),
        );
    }
    Ok(())
}

/// Recordings exceed the usual speeds of types by some percent.
const MUCH_FASTER: f64 = 1.2;

/// A stand whose code letter, as the layout has it, is smaller than that of the aircraft's span.
fn too_small(layout: &Airport, stand: &str, mover: &Entity) -> Option<String> {
    let at = layout.stands.iter().position(|s| s.name == stand)?;
    let letter = layout.details.stands.get(at)?.code?;
    let needed = code_of_span(mover.class.span_m);
    let small = mover.class.aircraft && needed > code_index(letter);
    small.then(|| {
        let (of, needed) = (&mover.class.designator, char::from(b'A' + needed));
        format!(
            "\"{stand}\" is one of code {letter}, and {of} with its span of {} m needs code {needed}: choose a larger stand",
            mover.class.span_m
        )
    })
}

/// The way on which a stand lies that is not its own, by name.
fn in_a_lane(layout: &Airport, stand: &str) -> Option<String> {
    let stand = layout.stand(stand)?;
    let own = |node: usize| Some(node) == stand.node;
    let guessed = |index: &usize| layout.details.joined.contains(index);
    let edge = layout.edges.iter().enumerate().find(|(index, e)| {
        let ends = (layout.nodes.get(e.from), layout.nodes.get(e.to));
        let (Some(a), Some(b)) = ends else { return false };
        // One that ends there is its lead-in.
        let ends_there =
            [a, b].iter().any(|n| (n.position_m - stand.position_m).norm() < LEAD_IN_M);
        let off_m = distance_to_segment_m(stand.position_m, a.position_m, b.position_m);
        !guessed(index) && !own(e.from) && !own(e.to) && !ends_there && off_m < ON_A_LINE_M
    })?;
    let name = &edge.1.name;
    Some(if name.is_empty() { "a taxiway without a name".to_owned() } else { name.clone() })
}

/// A stand nearer to a centreline than this is on it, m.
const ON_A_LINE_M: f64 = 1.0;
/// A way whose end is nearer to a stand than this leads into it, m.
const LEAD_IN_M: f64 = 20.0;

/// Whether a runway of that name is left and entered by no way, where there is a network at all.
fn is_without_ways(network: &Network, name: &str) -> bool {
    let named = |r: &&NetRunway| r.names.iter().any(|n| n == name);
    let Some(runway) = network.runways.iter().find(named) else { return false };
    let on = |node: usize| runway.spine.iter().any(|(_, n)| *n == node);
    let leads = network.edges.iter().any(|e| e.runway.is_none() && e.nodes.iter().any(|n| on(*n)));
    !network.edges.is_empty() && !leads
}

fn no_ways(name: &str) -> String {
    format!(
        "no way leads to runway {name} or from it: nobody gets there or away (`seeds airport check` says what the layout lacks)"
    )
}

/// The first runway that somebody is on, and when, s.
fn on_a_runway(layout: &Airport, trajectory: &Trajectory) -> Option<(String, i64)> {
    const SECOND: i64 = 1_000_000_000;
    let seconds = trajectory.start().0.div_euclid(SECOND) + 1..=trajectory.end().0 / SECOND;
    let on = |at: Point2<f64>| {
        layout.runways.iter().find(|r| {
            let along = r.ends_m[1] - r.ends_m[0];
            let from = at - r.ends_m[0];
            let length_m = along.norm().max(1e-9);
            let (place_m, off_m) = (from.dot(&along) / length_m, from.perp(&along) / length_m);
            (0.0..=length_m).contains(&place_m) && off_m.abs() < 0.5 * r.width_m
        })
    };
    seconds.into_iter().find_map(|s| {
        let state = trajectory.at(SimTime(s * SECOND))?;
        Some((on(state.position_m.xy())?.names.join("/"), s))
    })
}

/// Why no target is ever seen by a sensor.
fn out_of_reach(scene: &Scene, sensor: &SensorScene) -> Option<(u8, &'static str, String)> {
    let layout = &scene.airport.layout;
    if let (Some(radar), Some(site_m)) = (&sensor.asde, sensor.site_m) {
        let most_m = radar.parameters.range_max_m;
        let places = layout.runways.iter().flat_map(|r| r.ends_m);
        let places = places.chain(layout.stands.iter().map(|s| s.position_m));
        let places = places.chain(layout.nodes.iter().map(|n| n.position_m));
        let nearest_m = places.map(|p| (p - site_m.xy()).norm()).fold(f64::INFINITY, f64::min);
        return (nearest_m.is_finite() && nearest_m > most_m).then(|| {
            let text = format!(
                "the radar shows {most_m} m, and the nearest place of the airport is {nearest_m:.0} m away: no target can be seen"
            );
            (18, "site", text)
        });
    }
    if sensor.kind.word == "loop"
        && let Some(site_m) = sensor.site_m
    {
        let ends = layout.edges.iter().filter_map(|e| {
            Some((layout.nodes.get(e.from)?.position_m, layout.nodes.get(e.to)?.position_m))
        });
        let ends = ends.chain(layout.runways.iter().map(|r| (r.ends_m[0], r.ends_m[1])));
        let far_m = ends.map(|(a, b)| distance_to_segment_m(site_m.xy(), a, b));
        let nearest_m = far_m.fold(f64::INFINITY, f64::min);
        return (nearest_m.is_finite() && nearest_m > LOOP_M).then(|| {
            (
                18,
                "site",
                format!("the next way is {nearest_m:.0} m from this loop: nobody drives over it"),
            )
        });
    }
    let movers = &scene.traffic.entities;
    let carried = sensor.kind.carried && scene.traffic.behaving.is_none();
    let nobody = sensor.is_carried_by_none(movers.iter().map(|e| e.callsign));
    (carried && !movers.is_empty() && nobody)
        .then(|| (18, "equipped", "nobody carries it: it gives no plots".to_owned()))
}

/// A loop farther from every way than this is beside it, m.
const LOOP_M: f64 = 60.0;
