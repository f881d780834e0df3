//! Every kind of sensor, each declared in its own file: what the house knows of it ([`Kind`]), how its keys become a
//! configuration, and its planned models with their costs.
//!
//! Scene reader, messages, page, plan rows, cost bench, documents and the tests of completeness read `KINDS`.

use crate::effects::Tolerance;
use crate::effects::positioning::Model;
use crate::frames::{Point2, Point3};
use crate::kind::{Kind, SensorKind};
use crate::plot::SensorId;
use crate::sensors::Sensor;
use crate::sensors::config::ConfigError;
use crate::sensors::planned::Planned;
use crate::sensors::radar::shadow::Building;
use crate::sensors::reporting::cooperative::Equipage;
use crate::words::Word;
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// From the keys of a scene to a configuration.
pub type Read = fn(&Given<'_>) -> Result<Arc<dyn Settings>, ConfigError>;

/// A kind of sensor with what makes one.
pub struct Declared {
    /// What the house knows of it.
    pub kind: Kind,
    /// From the keys of a scene to a configuration. A radar has none here: its parameter sets are files, which the
    /// reader of scenes layers by itself.
    pub read: Option<Read>,
    /// Its planned models, by level.
    pub models: &'static [Modelled],
}

impl fmt::Debug for Declared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Declared").field("kind", &self.kind).finish_non_exhaustive()
    }
}

/// A planned model and an example of it.
pub struct Modelled {
    /// Its name, what its bounds read, its costs.
    pub model: &'static Model,
    /// A sensor of it in which every effect has something to do, planned with nothing to lose: for benches and tests.
    pub example: fn(SensorId) -> Result<Box<dyn Planned>, ConfigError>,
    /// The file that declares it, from the root of the workspace: there the bench of costs writes.
    pub file: &'static str,
}

impl fmt::Debug for Modelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Modelled").field("model", self.model).finish_non_exhaustive()
    }
}

/// A checked configuration of one sensor of a scene. As [`std::any::Any`], tools that know one kind find its numbers.
pub trait Settings: std::any::Any + fmt::Debug + Send + Sync {
    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    fn validate(&self) -> Result<(), ConfigError>;

    /// Seconds between two reports of a mover, and the nominal delay of a report's position.
    fn timing_s(&self) -> (f64, f64);

    /// Seconds between two reports of one that stands.
    fn standing_s(&self) -> f64 {
        self.timing_s().0
    }

    /// Standard deviation of one mover's own delay off the nominal one, s.
    fn late_sigma_s(&self) -> f64 {
        0.0
    }

    /// The sensor, which knows no target yet, planned with nothing to lose.
    ///
    /// # Errors
    /// If a parameter is refused; what was validated has none such.
    fn model(&self) -> Result<Box<dyn Planned>, ConfigError>;

    /// The sensor planned for a tolerance and a run of `run_s`.
    ///
    /// # Errors
    /// As [`Self::model`].
    fn sensor(&self, plan: Tolerance, run_s: f64) -> Result<Box<dyn Sensor>, ConfigError> {
        let mut sensor = self.model()?;
        sensor.planning_mut().tolerate(plan, run_s);
        Ok(sensor)
    }

    /// By how much leaving effects out may put a report earlier, s.
    fn shifts_s(&self) -> f64 {
        0.0
    }
}

/// Configurations are equal if they print alike: numbers are printed with all their digits.
impl PartialEq for dyn Settings {
    fn eq(&self, other: &Self) -> bool {
        format!("{self:?}") == format!("{other:?}")
    }
}

/// A value of a scene, of the kind that its key says.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// True or false.
    Flag(bool),
    /// A word.
    Word(String),
    /// A list of tables with a place each.
    Places(Vec<Place>),
}

/// A place with what else its table says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Place {
    /// East, north, up, m.
    pub position_m: Point3<f64>,
    /// Whether its height is given.
    pub has_height: bool,
    /// Its other numbers.
    pub numbers: BTreeMap<String, f64>,
    /// Its tables, each of numbers.
    pub tables: BTreeMap<String, Vec<BTreeMap<String, f64>>>,
}

/// What a scene gives for one sensor.
#[derive(Debug)]
pub struct Given<'a> {
    /// Number of the sensor.
    pub id: SensorId,
    /// The parameter set; the first one where none is named.
    pub preset: &'a str,
    /// Its values by key.
    pub values: &'a BTreeMap<String, Value>,
    /// Where it stands, if anywhere.
    pub site_m: Option<Point3<f64>>,
    /// Who carries it.
    pub equipped: Equipage,
    /// Reference point of the airport.
    pub reference: geodesy::Geodetic,
    /// Start of the run, ns since 1970-01-01 UTC.
    pub start_utc_ns: i64,
    /// Buildings of the scene.
    pub buildings: &'a [Building],
    /// Keys that were asked for so far, with what held before: the ones that this sensor has, whether given or not.
    pub asked: RefCell<Vec<(&'static str, String)>>,
}

impl Given<'_> {
    fn note(&self, key: &'static str, default: String) {
        let mut asked = self.asked.borrow_mut();
        if !asked.iter().any(|(word, _)| *word == key) {
            asked.push((key, default));
        }
    }

    /// Whether the scene gives a key.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.values.contains_key(key)
    }

    /// East and north of the site; the reference point where there is none.
    #[must_use]
    pub fn place_m(&self) -> Point2<f64> {
        self.site_m.map_or_else(Point2::origin, |site| site.xy())
    }

    /// Puts a number in place of `slot` if it is given.
    pub fn number(&self, key: &'static str, slot: &mut f64) {
        self.note(key, slot.to_string());
        if let Some(Value::Number(number)) = self.values.get(key) {
            *slot = *number;
        }
    }

    /// A number that has to be given.
    ///
    /// # Errors
    /// [`ConfigError::Missing`].
    pub fn need_number(&self, key: &'static str, needed: &'static str) -> Result<f64, ConfigError> {
        self.note(key, String::new());
        match self.values.get(key) {
            Some(Value::Number(number)) => Ok(*number),
            _ => Err(ConfigError::Missing { key, needed }),
        }
    }

    /// Puts true or false in place of `slot` if it is given.
    pub fn flag(&self, key: &'static str, slot: &mut bool) {
        self.note(key, slot.to_string());
        if let Some(Value::Flag(flag)) = self.values.get(key) {
            *slot = *flag;
        }
    }

    /// The word of a key, or `default`; the reader has refused words that the key does not list.
    #[must_use]
    pub fn word(&self, key: &'static str, default: &'static str) -> &str {
        self.note(key, default.to_owned());
        match self.values.get(key) {
            Some(Value::Word(word)) => word,
            _ => default,
        }
    }

    /// A list of places; empty where it is not given.
    #[must_use]
    pub fn places(&self, key: &'static str) -> &[Place] {
        self.note(key, String::new());
        match self.values.get(key) {
            Some(Value::Places(places)) => places,
            _ => &[],
        }
    }

    /// Who carries it: what the scene says, of the kinds of targets that `aircraft` and `vehicles` let pass.
    #[must_use]
    pub fn equipage(&self) -> Equipage {
        let mut equipage = self.equipped.clone();
        self.flag("aircraft", &mut equipage.aircraft);
        self.flag("vehicles", &mut equipage.vehicles);
        equipage
    }
}

impl Word for SensorKind {
    const WHAT: &'static str = "kind of sensor";

    fn words() -> Vec<Cow<'static, str>> {
        Self::all().map(|kind| kind.word.into()).collect()
    }

    fn said(&self) -> Cow<'static, str> {
        self.word.into()
    }

    fn named(word: &str) -> Option<Self> {
        Self::of(word)
    }
}

impl SensorKind {
    /// The declared kind of that word.
    #[must_use]
    pub fn of(word: &str) -> Option<Self> {
        super::KINDS.iter().find(|d| d.kind.word == word).map(|d| Self(&d.kind))
    }

    /// All declared kinds, in their order.
    pub fn all() -> impl Iterator<Item = Self> {
        super::KINDS.iter().map(|d| Self(&d.kind))
    }

    /// Place among all kinds.
    #[must_use]
    pub fn place(self) -> Option<usize> {
        super::KINDS.iter().position(|d| d.kind.word == self.word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Purpose;
    use crate::sensors::KINDS;

    #[test]
    fn words_colours_and_draws_are_unlike() {
        let mut draws: Vec<u32> = Purpose::SHARED.iter().map(|p| p.number()).collect();
        for (i, a) in KINDS.iter().enumerate() {
            assert!(
                a.kind.word.chars().all(|c| c.is_ascii_lowercase() || c == '_'),
                "{:?}",
                a.kind
            );
            for colour in a.kind.colours {
                let digits = colour.strip_prefix('#').unwrap_or("");
                assert!(digits.len() == 6 && u32::from_str_radix(digits, 16).is_ok(), "{colour}");
            }
            for b in &KINDS[i + 1..] {
                assert_ne!(a.kind.word, b.kind.word);
                for side in 0..2 {
                    assert_ne!(a.kind.colours[side], b.kind.colours[side], "{}", b.kind.word);
                }
            }
            draws.extend(a.kind.draws.iter().map(|p| p.number()));
            assert_eq!(SensorKind::of(a.kind.word).and_then(SensorKind::place), Some(i));
        }
        let count = draws.len();
        draws.sort_unstable();
        draws.dedup();
        assert_eq!(draws.len(), count, "two draws with one number would be the same draws");
    }

    #[test]
    fn settings_are_equal_if_all_their_numbers_are() {
        use crate::sensors::induction_loop::LoopConfig;
        let one = LoopConfig::pair_at(SensorId(1), Point2::new(3.0, 4.0), 90.0);
        let other = LoopConfig { delay_s: one.delay_s + 1e-15, ..one.clone() };
        let as_settings = |config: &LoopConfig| -> Box<dyn Settings> { Box::new(config.clone()) };
        assert!(*as_settings(&one) == *as_settings(&one));
        assert!(*as_settings(&one) != *as_settings(&other));
    }

    #[test]
    fn a_scene_gives_the_keys_that_it_gives() {
        let values = BTreeMap::from([("pd".to_owned(), Value::Number(0.9))]);
        let given = Given {
            id: SensorId(1),
            preset: "pair",
            values: &values,
            site_m: None,
            equipped: Equipage::all(),
            reference: geodesy::Geodetic::from_degrees(47.0, 8.0, 0.0),
            start_utc_ns: 0,
            buildings: &[],
            asked: RefCell::default(),
        };
        assert!(given.has("pd") && !given.has("delay_s"));
        let (mut pd, mut delay_s) = (0.5, 0.05);
        given.number("pd", &mut pd);
        given.number("delay_s", &mut delay_s);
        assert_eq!((pd, delay_s), (0.9, 0.05), "what is not given stays");
        let asked: Vec<_> = given.asked.borrow().iter().map(|(word, _)| *word).collect();
        assert_eq!(asked, ["pd", "delay_s"]);
    }

    #[test]
    fn keys_have_words_lines_and_limits() {
        for declared in KINDS {
            let mut words = Vec::new();
            for key in declared.kind.keys.iter().flat_map(|group| group.iter()) {
                assert!(key.doc.len() > 8 && !key.doc.ends_with('.'), "{}", key.word);
                assert!(!words.contains(&key.word), "{} twice", key.word);
                words.push(key.word);
                if let crate::keys::Holds::Number { least, most } = key.holds {
                    assert!(least < most, "{}", key.word);
                }
            }
        }
    }

    #[test]
    fn examples_are_sound_and_every_preset_can_be_read() {
        for modelled in crate::sensors::models() {
            let sensor = (modelled.example)(SensorId(1)).expect(modelled.model.name);
            assert_eq!(sensor.id(), SensorId(1));
            assert!(modelled.file.starts_with("models/src/sensors/"), "{}", modelled.file);
        }
    }
}
