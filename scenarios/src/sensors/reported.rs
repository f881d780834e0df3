//! Sensors other than radars, read by the keys that each kind declares ([`models::sensors::declared`]).
//!
//! `parameters` names a parameter set of the kind, `overrides` what differs from it. What the model refuses is reported
//! with the line that said it.

use crate::airport::AirportScene;
use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::run::Run;
use models::frames::Point3;
use models::keys::{Holds, Key, PLACE};
use models::plot::SensorId;
use models::sensors::config::ConfigError;
use models::sensors::declared::{Declared, Given, Place as At, Settings, Value};
use models::sensors::radar::shadow::Building;
use models::sensors::reporting::cooperative::{Equipage, Equipped as Carriers};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use super::Equipped;

/// What a sensor is read from.
pub(super) struct Place<'a> {
    pub(super) run: &'a Run,
    pub(super) airport: &'a AirportScene,
    pub(super) id: SensorId,
    pub(super) site_m: Option<Point3<f64>>,
    pub(super) equipped: &'a Equipped,
    pub(super) buildings: &'a [Building],
}

/// Reads one sensor; `None` for a radar.
pub(super) fn read(
    declared: &Declared,
    section: &Section,
    overrides: &Section,
    place: &Place<'_>,
) -> Result<Option<Arc<dyn Settings>>, ScenarioError> {
    let Some(make) = declared.read else { return Ok(None) };
    let presets: Vec<(&str, &str)> =
        declared.kind.presets.iter().map(|(name, _)| (*name, *name)).collect();
    let first = presets.first().map_or("", |(name, _)| *name);
    let preset = section.choice("parameters", &presets)?.unwrap_or(first);
    let values = values(overrides, declared.kind.keys, place)?;
    let given = Given {
        id: place.id,
        preset,
        values: &values,
        site_m: place.site_m,
        equipped: equipage(place.equipped),
        reference: place.airport.reference,
        start_utc_ns: place.run.start_utc_ns,
        buildings: place.buildings,
        asked: RefCell::default(),
    };
    let made = make(&given);
    if made.is_ok() {
        let asked: Vec<&str> = given.asked.borrow().iter().map(|(word, _)| *word).collect();
        overrides.only(&asked)?;
    }
    match made.and_then(|settings| settings.validate().map(|()| settings)) {
        Ok(settings) => Ok(Some(settings)),
        Err(error) => Err(refuse(section, overrides, error)),
    }
}

/// The model's refusal at the line that gave the value, or at the sensor's.
fn refuse(section: &Section, overrides: &Section, error: ConfigError) -> ScenarioError {
    if let ConfigError::Missing { key, needed } = error {
        return overrides.missing(key, needed.into());
    }
    let key = error.key();
    if overrides.has(key) {
        overrides.refused_by_model(key, error)
    } else if section.has("parameters") {
        section.refused_by_model("parameters", error)
    } else {
        section.refused_by_model("kind", error)
    }
}

/// The values that a table gives for the keys of a kind. Limits are the model's to check: they may be narrower.
fn values(
    table: &Section,
    keys: &[&'static [Key]],
    place: &Place<'_>,
) -> Result<BTreeMap<String, Value>, ScenarioError> {
    let mut values = BTreeMap::new();
    for key in keys.iter().flat_map(|group| group.iter()).filter(|key| table.has(key.word)) {
        let value = match key.holds {
            Holds::Number { .. } => {
                let any = within(f64::NEG_INFINITY, f64::INFINITY, key.unit);
                table.number(key.word, any)?.map(Value::Number)
            }
            Holds::Whole { least, most } => {
                let found = table.integer(key.word, i64::MIN, i64::MAX)?;
                if let Some(value) = found.filter(|n| !(least..=most).contains(n)) {
                    let (value, min, max) = (value as f64, least as f64, most as f64);
                    let error = ConfigError::Number { key: key.word, value, min, max };
                    return Err(table.refused_by_model(key.word, error));
                }
                found.map(|n| Value::Number(n as f64))
            }
            Holds::Flag => table.flag(key.word)?.map(Value::Flag),
            Holds::Word(words) => {
                let words: Vec<(&str, &str)> = words().into_iter().map(|w| (w, w)).collect();
                table.choice(key.word, &words)?.map(|word| Value::Word(word.to_owned()))
            }
            Holds::Places(more) => Some(Value::Places(places(table, key.word, more, place)?)),
            _ => table.text(key.word)?.map(|text| Value::Word(text.to_owned())),
        };
        values.extend(value.map(|value| (key.word.to_owned(), value)));
    }
    Ok(values)
}

fn places(
    table: &Section,
    word: &str,
    more: &'static [Key],
    place: &Place<'_>,
) -> Result<Vec<At>, ScenarioError> {
    let own: Vec<&str> = more.iter().map(|key| key.word).collect();
    let allowed: Vec<&str> = PLACE.iter().map(|key| key.word).chain(own.iter().copied()).collect();
    table
        .sections(word, &allowed)?
        .iter()
        .map(|section| {
            let mut tables = BTreeMap::new();
            for key in more {
                if let Holds::Tables(inner) = key.holds {
                    let words: Vec<&str> = inner.iter().map(|key| key.word).collect();
                    let rows = section.sections(key.word, &words)?;
                    let rows: Result<Vec<_>, _> =
                        rows.iter().map(|row| numbers(row, inner)).collect();
                    tables.insert(key.word.to_owned(), rows?);
                }
            }
            Ok(At {
                position_m: place.airport.site(&section.without(&own))?,
                has_height: section.has("height_m"),
                numbers: numbers(section, more)?,
                tables,
            })
        })
        .collect()
}

/// The numbers among `keys`, within their limits.
fn numbers(table: &Section, keys: &'static [Key]) -> Result<BTreeMap<String, f64>, ScenarioError> {
    let mut numbers = BTreeMap::new();
    for key in keys {
        let Holds::Number { least, most } = key.holds else { continue };
        let limits = within(least, most, key.unit);
        let number = if key.needed {
            Some(table.need_number(key.word, limits)?)
        } else {
            table.number(key.word, limits)?
        };
        numbers.extend(number.map(|number| (key.word.to_owned(), number)));
    }
    Ok(numbers)
}

/// Aircraft and vehicles, those of them that the scene says.
pub(super) fn equipage(equipped: &Equipped) -> Equipage {
    let who = match equipped {
        Equipped::All => Carriers::All,
        Equipped::Share(share) => Carriers::Share(*share),
        Equipped::Callsigns(names) => Carriers::Callsigns(names.iter().copied().collect()),
    };
    Equipage { who, ..Equipage::all() }
}

/// Refuses `equipped` where nobody carries the sensor.
pub(super) fn nobody_carries(section: &Section, declared: &Declared) -> Result<(), ScenarioError> {
    if declared.kind.carried || !section.has("equipped") {
        return Ok(());
    }
    let allowed = format!("a {} sees whoever is there: leave `equipped` out", declared.kind.word);
    let found = "equipped".into();
    Err(section.refuse("equipped", Problem::NotAllowed { found, allowed }))
}
