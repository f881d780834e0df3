//! `[[sensor]]`: kind, place, parameters, and who carries it.

pub mod asde;
pub mod foreign;
mod offline;
mod reported;

pub use asde::AsdeScene;
pub(crate) use foreign::KEYS as FOREIGN;
pub use foreign::{ForeignScene, ForeignSource};

use crate::Scene;
use crate::airport::AirportScene;
use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use crate::run::Run;
use crate::traffic::Traffic;
use models::effects::Tolerance;
use models::frames::{Point2, Point3};
use models::plot::{Callsign, SensorId, SensorKind};
use models::sensors::KINDS;
use models::sensors::Sensor;
use models::sensors::declared::{Declared, Settings};
use models::sensors::radar::levels::Processing;
use models::sensors::radar::shadow::Building;
use models::sensors::radar::video::{CellRadar, MOST_CELLS};
use std::path::PathBuf;
use std::sync::Arc;

/// One `[[sensor]]` of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorScene {
    /// Number: its place in the file, from 1.
    pub id: SensorId,
    /// What kind of sensor; of an off-line one the kind that its figures are of, of somebody else's the kind that it is.
    pub kind: SensorKind,
    /// Name for people, unique in the scene.
    pub name: String,
    /// Place of the antenna or loop: m east, north, and up from the reference plane. `None` for
    /// sensors that the targets carry.
    pub site_m: Option<Point3<f64>>,
    /// Name of the parameter set; `None` for the kind's own.
    pub parameters: Option<String>,
    /// Single parameters that differ from the set; the mapping to a model's configuration reads
    /// (and checks) them from here.
    pub overrides: Section,
    /// Which targets carry it, or are seen by it.
    pub equipped: Equipped,
    /// The checked radar, for `kind = "asde"`.
    pub asde: Option<AsdeScene>,
    /// The checked sensor, for every other kind that is simulated.
    pub reported: Option<Arc<dyn Settings>>,
    /// Of `kind = "asterix"`: whose plots they are.
    pub foreign: Option<ForeignScene>,
}

/// Which targets carry a sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum Equipped {
    /// All.
    All,
    /// Those named.
    Callsigns(Vec<Callsign>),
    /// A share of all, 0 to 1: each run draws who by its seed.
    Share(f64),
}

impl SensorScene {
    /// Whether both say the same keys of the same set, whatever their names.
    #[must_use]
    pub fn overrides_equal(&self, other: &Self) -> bool {
        self.parameters == other.parameters
            && self.equipped == other.equipped
            && self.reported == other.reported
            && self.asde == other.asde
            && self.foreign == other.foreign
    }

    /// The sensor itself, planned for a tolerance; none for one of somebody else, whose plots come from outside.
    ///
    /// # Errors
    /// One sentence if it cannot be made; the scene's check should have said so before.
    pub fn made(
        &self,
        scene: &Scene,
        tolerance: Tolerance,
    ) -> Result<Option<Box<dyn Sensor>>, String> {
        let failed = |e: &dyn std::fmt::Display| format!("sensor '{}': {e}", self.name);
        match (&self.asde, &self.reported) {
            (Some(radar), _) => {
                let asde = radar.radar_for(scene, self, tolerance).map_err(|e| failed(&e))?;
                Ok(Some(Box::new(asde)))
            }
            (None, Some(reported)) => {
                let made = reported.sensor(tolerance, scene.run.duration.s());
                Ok(Some(made.map_err(|e| failed(&e))?))
            }
            (None, None) if self.foreign.is_some() => Ok(None),
            (None, None) => Err(failed(&"the scene gives it no parameters")),
        }
    }

    /// Whether no target of these names can carry it, whatever a run draws: shares are drawn by the run's seed.
    #[must_use]
    pub fn is_carried_by_none(&self, mut callsigns: impl Iterator<Item = Callsign>) -> bool {
        match &self.equipped {
            Equipped::All => callsigns.next().is_none(),
            Equipped::Callsigns(named) => !callsigns.any(|callsign| named.contains(&callsign)),
            Equipped::Share(share) => *share <= 0.0,
        }
    }
}

/// Reads `[[sensor]]`.
pub(crate) fn read(
    root: &Section,
    run: &Run,
    airport: &AirportScene,
    traffic: &Traffic,
    buildings: &[Building],
) -> Result<(Vec<SensorScene>, Vec<PathBuf>), ScenarioError> {
    let mut files = Vec::new();
    let mut sensors: Vec<SensorScene> = Vec::new();
    let sections = root.sections("sensor", &words(keys::SENSOR))?;
    for (index, section) in sections.iter().enumerate() {
        let mut kinds: Vec<_> = KINDS.iter().map(|d| (d.kind.word, Form::Of(d))).collect();
        kinds.extend([("offline", Form::Offline), ("asterix", Form::Foreign)]);
        let form = section
            .choice("kind", &kinds)?
            .ok_or_else(|| section.missing("kind", "the kind of sensor, like \"asde\"".into()))?;
        let declared = match form {
            Form::Of(declared) => Some(declared),
            Form::Offline | Form::Foreign => None,
        };
        let name = section.need_text("name", "a name for people")?.to_owned();
        if let Some(first) = sensors.iter().position(|s| s.name == name) {
            let first_line = sections[first].line_of("name");
            return Err(section.refuse("name", Problem::Duplicate { found: name, first_line }));
        }
        let site = section.any_section("site")?;
        if declared.is_some_and(|d| d.kind.needs_site) && site.is_none() {
            let needed = "a place: { lat_deg = …, lon_deg = …, height_m = … }".into();
            return Err(section.missing("site", needed));
        }
        let site_m = site.as_ref().map(|place| airport.site(place)).transpose()?;
        let is_radar = declared.is_some_and(|d| d.kind.radar);
        if !is_radar && section.has("processing") {
            let found = "a key of radars".into();
            let needed = "kind = \"asde\", or no such key".into();
            return Err(section.refuse("processing", Problem::WrongKind { found, needed }));
        }
        let overrides =
            section.any_section("overrides")?.unwrap_or_else(|| section.empty("overrides"));
        let mut asde = None;
        if let (true, Some(site_m)) = (is_radar, site_m) {
            let (radar, file) = asde::read(section, &overrides, site_m)?;
            clear_of_buildings(section, &radar, site_m.xy(), buildings)?;
            can_paint(section, &radar, run)?;
            files.push(file);
            asde = Some(radar);
        }
        let id = SensorId(index as u16 + 1);
        if let Some(declared) = declared {
            reported::nobody_carries(section, declared)?;
        }
        let equipped = equipped(section, traffic)?;
        let place = reported::Place { run, airport, id, site_m, equipped: &equipped, buildings };
        form.only_its_keys(section)?;
        let mut foreign = None;
        let (kind, reported) = match form {
            Form::Of(declared) => {
                let reported = reported::read(declared, section, &overrides, &place)?;
                (SensorKind(&declared.kind), reported)
            }
            Form::Offline => {
                let (figures, file) = offline::read(section, &place)?;
                files.push(file);
                (figures.kind, Some(Arc::new(figures) as Arc<dyn Settings>))
            }
            Form::Foreign => {
                let (sensor, kind, file) = foreign::read(section, run)?;
                files.extend(file);
                foreign = Some(sensor);
                (kind, None)
            }
        };
        sensors.push(SensorScene {
            id,
            kind,
            name,
            site_m,
            parameters: section.text("parameters")?.map(Into::into),
            overrides,
            equipped,
            asde,
            reported,
            foreign,
        });
    }
    Ok((sensors, files))
}

/// What `kind` can say.
#[derive(Clone, Copy)]
enum Form {
    /// A kind that is simulated.
    Of(&'static Declared),
    /// By fitted figures, of the kind that they are of.
    Offline,
    /// Somebody else's, which is there.
    Foreign,
}

impl Form {
    /// Refuses keys that only other forms have.
    fn only_its_keys(self, section: &Section) -> Result<(), ScenarioError> {
        let refused = |key: &str, kinds: &str| {
            let allowed = format!("for kind = {kinds} only");
            section.refuse(key, Problem::NotAllowed { found: key.to_owned(), allowed })
        };
        if section.has("figures") && !matches!(self, Self::Offline) {
            return Err(refused("figures", "\"offline\""));
        }
        if section.has("of") && matches!(self, Self::Of(_)) {
            return Err(refused("of", "\"offline\" and \"asterix\""));
        }
        if matches!(self, Self::Foreign) {
            return Ok(());
        }
        match foreign::KEYS.iter().find(|key| section.has(key)) {
            Some(key) => Err(refused(key, "\"asterix\"")),
            None => Ok(()),
        }
    }
}

/// Refuses the whole video where a scan lasts longer than a turn (a cell would be painted twice), and
/// where there are too many cells to keep.
fn can_paint(section: &Section, radar: &AsdeScene, run: &Run) -> Result<(), ScenarioError> {
    if radar.processing != Some(Processing::Video) {
        return Ok(());
    }
    let cells = CellRadar::of(&radar.parameters).turn_cells();
    if cells > MOST_CELLS {
        let found = format!("\"video\" with {cells} cells a turn");
        let needed =
            format!("at most {MOST_CELLS} (beamwidth, pulse, display range), or \"cells\"");
        return Err(section.refuse("processing", Problem::WrongKind { found, needed }));
    }
    let (scan_s, turns_per_s) = (run.scan().s(), radar.parameters.turns_per_s());
    if scan_s * turns_per_s <= 1.0 + 1e-9 {
        return Ok(());
    }
    let found = format!("\"video\" with scans of {scan_s} s and turns of {} s", 1.0 / turns_per_s);
    let needed = "a run.scan_s of at most one turn, or another processing".into();
    Err(section.refuse("processing", Problem::WrongKind { found, needed }))
}

/// Refuses an antenna inside a building.
fn clear_of_buildings(
    section: &Section,
    radar: &AsdeScene,
    site_m: Point2<f64>,
    buildings: &[Building],
) -> Result<(), ScenarioError> {
    let height_m = radar.parameters.antenna_height_m;
    let inside = buildings.iter().find(|b| b.contains(site_m) && b.height_m >= height_m);
    let Some(building) = inside else { return Ok(()) };
    let found = format!("an antenna at {height_m} m inside \"{}\"", building.name);
    let needed = format!("a height above its roof at {} m, or another place", building.height_m);
    Err(section.refuse("site", Problem::WrongKind { found, needed }))
}

/// `equipped = 0.5`, or `equipped = ["EDW229"]`; everybody where it is not given.
fn equipped(section: &Section, traffic: &Traffic) -> Result<Equipped, ScenarioError> {
    if !section.has("equipped") {
        return Ok(Equipped::All);
    }
    if section.is_list("equipped") {
        let callsigns = section.texts("equipped")?.into_iter().map(|(text, line)| {
            let callsign = Callsign::new(&text);
            if traffic.entities.iter().any(|e| e.callsign == callsign) {
                return Ok(callsign);
            }
            let known: Vec<_> =
                traffic.entities.iter().map(|e| format!("\"{}\"", e.callsign)).collect();
            let problem = Problem::NotAllowed { found: text, allowed: known.join(", ") };
            let key = format!("{}.equipped", section.path());
            Err(ScenarioError::new(section.file(), line, key, problem))
        });
        return Ok(Equipped::Callsigns(callsigns.collect::<Result<_, _>>()?));
    }
    Ok(Equipped::Share(section.need_number("equipped", within(0.0, 1.0, "share"))?))
}
