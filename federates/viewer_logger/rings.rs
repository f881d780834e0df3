//! Where each effect of a radar's plan is on: rings and sectors round the radar, for the targets of one scan, made when a page asks for them.
//!
//! A radar of the scene, at the scene's tolerance, plans the truth of the scan as it was sent to the page. A box's plan depends on the
//! box, the weather and the neighbours alone (`effects.md` 3.1), so that it is the one of the run, but for weather that an operator changed.
//! Nothing is asked of the SMDFM, and no digest depends on it.

use super::frame;
use super::video::Seen;
use models::effects::Level;
use models::environment::Weather;
use models::frames::Point2;
use models::sensors::asde::plan::boxes::{SECTORS, band, band_m, ring, ring_m};
use models::sensors::asde::plan::{BoxEffect, Kind, PlannedBox};
use models::sensors::asde::{Asde, Placed};
use models::sensors::radar::effects::RadarEffect;
use models::sensors::radar::levels::Processing;
use models::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use models::time::SimTime;
use scenarios::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// What is needed of the run.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Number of the radar.
    pub sensor: u16,
    /// Seed of the run.
    pub seed: u64,
    /// The scan, as the page was sent it ([`frame::encode`]).
    pub scan: Vec<u8>,
}

/// How an effect is simulated somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    /// Nothing there calls for it.
    NotCalledFor,
    /// It is left out: the tolerance allows what that changes.
    Skipped,
    /// A cheaper form.
    Reduced,
    /// As exact as it can be, or by a table that equals that.
    Exact,
}

impl State {
    /// Its letter in [`of`].
    #[must_use]
    pub fn letter(self) -> char {
        match self {
            Self::NotCalledFor => 'n',
            Self::Skipped => 's',
            Self::Reduced => 'r',
            Self::Exact => 'e',
        }
    }

    fn of_box(effect: &BoxEffect) -> Self {
        match (effect.kind, effect.level) {
            (Kind::NotThere, _) => Self::NotCalledFor,
            (Kind::Exact | Kind::Table, _) | (_, Level::Exact) => Self::Exact,
            (Kind::LeftOut, Level::Skipped) => Self::Skipped,
            (Kind::LeftOut, _) => Self::Reduced,
        }
    }

    fn of_level(level: Level) -> Self {
        match level {
            Level::Skipped => Self::NotCalledFor,
            Level::Exact => Self::Exact,
            _ => Self::Reduced,
        }
    }
}

/// Effects that are on for the whole radar or for nobody.
const WHOLE: [RadarEffect; 3] =
    [RadarEffect::FalseAlarms, RadarEffect::SecondTrace, RadarEffect::Processing];

/// Scans of the same second until no box waits for its plan.
const SCANS: usize = 200;

/// One place of the picture: nearest and farthest ground distance and lowest and highest place, as bits, which sort alike; sector; class.
type Cell = ([u64; 4], u8, String);

/// Rings and sectors of a radar as JSON: `scan`, `site_m` (east, north), `from_m` and `to_m` (what is displayed, slant), `sectors` (so many
/// in a turn, clockwise from north), `effects` (their names), `whole` (effects that are on for the whole radar or for nobody: name and
/// letter) and `cells`: `ring_m`, `band_m`, `sector`, `class`, `targets`, and `states`, a letter for each effect: `n` not called for, `s`
/// skipped, `r` reduced, `e` exact. Targets that are not displayed have no cell.
///
/// # Errors
/// The scene has no such radar, or there is no such scan; as one sentence.
pub fn of(scene: &Scene, asked: &Asked) -> Result<Value, String> {
    let (number, to) = frame::number_and_time(&asked.scan).ok_or("there is no such scan")?;
    let row = scene.sensors.iter().find(|s| s.id.0 == asked.sensor);
    let found = row.and_then(|row| Some((row, row.asde.as_ref()?)));
    let (row, parts) = found.ok_or("this sensor is not a radar: its plan has no rings")?;
    if parts.processing.is_some_and(|p| p != Processing::Plot) {
        return Err("this radar is simulated in cells: all effects are exact there".into());
    }
    let mut radar = parts.radar_for(scene, row, scene.tolerance()).map_err(|e| e.to_string())?;
    let from = SimTime(to.0 - scene.run.scan().0);
    let notice = scene.weather.iter().rev().find(|n| n.time <= from);
    let weather = notice.map_or_else(Weather::default, |n| n.weather.after(from.since_s(n.time)));
    let truth = Seen::of(scene, &asked.scan, to);
    let interval = ScanInterval { run_seed: asked.seed, scan: number, from, to };
    let mut planned = usize::MAX;
    for _ in 0..SCANS {
        radar.scan(&interval, &truth, &weather, &mut PlotSink::default());
        let now = radar.boxes().len();
        if std::mem::replace(&mut planned, now) == now {
            break;
        }
    }
    let site_m = row.site_m.map_or_else(Point2::origin, |site| site.xy());
    let mut cells: BTreeMap<Cell, (u32, Vec<State>)> = BTreeMap::new();
    for placed in radar.placed().iter().filter(|p| p.shown) {
        let Some(cell) = cell_of(&radar, &truth, placed, (site_m, from)) else { continue };
        let states = RadarEffect::ALL.iter().map(|&effect| state_of(&radar, placed, effect));
        let (targets, most) = cells.entry(cell).or_default();
        *targets += 1;
        if most.is_empty() {
            most.extend(states);
        } else {
            // Of several targets of a cell neighbours may call for more for one.
            most.iter_mut().zip(states).for_each(|(most, own)| *most = own.max(*most));
        }
    }
    let cell = |((bits, sector, class), (targets, states)): (&Cell, &(u32, Vec<State>))| {
        let states: String = states.iter().map(|state| state.letter()).collect();
        let [near, far, low, high] = bits.map(f64::from_bits);
        json!({
            "ring_m": [near, far], "band_m": [low, high], "sector": sector, "class": class,
            "targets": targets, "states": states,
        })
    };
    let whole: BTreeMap<&str, char> = radar
        .plan()
        .iter()
        .filter(|row| WHOLE.iter().any(|e| e.name() == row.effect))
        .map(|row| (row.effect, State::of_level(row.level).letter()))
        .collect();
    let names: Vec<&str> = RadarEffect::ALL.iter().map(|e| e.name()).collect();
    let parameters = radar.parameters();
    Ok(json!({
        "sensor": asked.sensor, "scan": number, "site_m": [site_m.x, site_m.y],
        "from_m": parameters.range_min_m, "to_m": parameters.range_max_m, "sectors": SECTORS,
        "effects": names, "whole": whole, "cells": cells.iter().map(cell).collect::<Vec<_>>(),
    }))
}

/// Where a target is on the lattice; one in no box by its place at the begin of the scan.
fn cell_of(
    radar: &Asde,
    truth: &Seen<'_>,
    placed: &Placed,
    (site_m, from): (Point2<f64>, SimTime),
) -> Option<Cell> {
    let (ground, height, class) = match placed.place {
        Some(place) => {
            let planned = radar.boxes().get(place as usize)?;
            (planned.key.ground_m(), band_m(planned.key.band), planned.class.clone())
        }
        None => {
            let at_m = truth.at(placed.index, from)?.position_m;
            let ground_m2 = (at_m.xy() - site_m).norm_squared();
            let class = truth.class(placed.index).designator.clone();
            (ring_m(ring(ground_m2)), band_m(band(at_m.z)), class)
        }
    };
    let edges = [ground.0, ground.1, height.0, height.1].map(f64::to_bits);
    Some((edges, placed.sector, class))
}

/// How an effect is simulated for a target.
fn state_of(radar: &Asde, placed: &Placed, effect: RadarEffect) -> State {
    let of_row = || {
        let row = radar.plan().iter().find(|row| row.effect == effect.name());
        row.map_or(State::NotCalledFor, |row| State::of_level(row.level))
    };
    let there = |there: bool| if there { State::Exact } else { State::NotCalledFor };
    match effect {
        RadarEffect::AircraftShadow => return there(placed.shadowed),
        RadarEffect::Merging => return there(placed.paired),
        RadarEffect::BuildingShadow => return of_row(),
        _ if WHOLE.contains(&effect) => return of_row(),
        _ => (),
    }
    let boxes = radar.boxes();
    let planned = placed.place.and_then(|place| boxes.get(place as usize));
    let own =
        |b: &PlannedBox| b.plan.effects.iter().find(|e| e.effect == effect).map(State::of_box);
    if let Some(planned) = planned.filter(|_| !placed.paired) {
        return own(planned).unwrap_or_else(of_row);
    }
    // Everything that is there is exact for it.
    let mut elsewhere = boxes.iter().filter_map(own).peekable();
    there(elsewhere.peek().is_none() || elsewhere.any(|state| state != State::NotCalledFor))
}

#[cfg(test)]
mod tests;
