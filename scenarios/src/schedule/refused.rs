//! Departures whose runway is too short for them (traffic.md 13).

use super::flights::flight_of;
use super::reach::{Ground, direction_rad};
use super::{RunwayEnd, Wanted};
use crate::types::TypeRow;
use models::frames::Azimuth;
use models::traffic::core::{Day, Direction};

/// What a departure lacks of its runway, in words.
pub(super) enum Lack {
    /// Whenever it leaves from its time on.
    Always(String),
    /// At its time, and not in all weather after it.
    Now(String),
}

/// What a departure lacks of its runway: more than all that is ahead of its entries, from its time on.
pub(super) fn lack(ground: &Ground<'_>, w: &Wanted, row: &TypeRow, end: RunwayEnd) -> Option<Lack> {
    let there_m = ground.longest_run_m(end);
    if w.direction != Direction::Departure || there_m == 0.0 {
        return None;
    }
    let flight = flight_of(row);
    let along = Azimuth::from_rad(direction_rad(ground.network, end));
    let needs_m = |day: &Day| flight.needs_runway_m(day.density_ratio, day.head_mps(along));
    let goes = |day: &Day| needs_m(day).is_some_and(|needs_m| needs_m <= there_m);
    let calm = [(0.0, Day::default())];
    let days = if ground.days.is_empty() { &calm } else { ground.days };
    let now = days.iter().rposition(|d| d.0 <= w.time_s).unwrap_or(0);
    let day = &days[now].1;
    if goes(day) {
        return None;
    }
    let (r, e) = end;
    let (name, kind, runway) = (&w.callsign, &w.designator, &ground.network.runways[r].names[e]);
    let text = match needs_m(day) {
        Some(needs_m) => format!(
            "{name}: a {kind} needs {needs_m:.0} m of runway {runway} for its take-off, {there_m:.0} m are there"
        ),
        None => format!(
            "{name}: a {kind} cannot take off from runway {runway} in this air and {:.0} m/s of head wind",
            day.head_mps(along)
        ),
    };
    let later = days[now..].iter().any(|d| goes(&d.1));
    Some(if later {
        Lack::Now(format!("{text} at its time, it waits on its stand"))
    } else {
        Lack::Always(text)
    })
}
