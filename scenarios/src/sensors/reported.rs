//! Sensors other than radars: satellite positioning, broadcasts, multilateration, loops, odometers.
//!
//! `parameters` names a preset of the model, `overrides` what differs from it. Keys and limits are the
//! model's own: what it refuses is reported with the line that said it.

use crate::airport::AirportScene;
use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::run::Run;
use models::effects::Tolerance;
use models::effects::positioning::Planned;
use models::frames::{Vector2, Vector3};
use models::plot::{SensorId, SensorKind};
use models::sensors::Sensor;
use models::sensors::adsb::{Adsb, AdsbConfig};
use models::sensors::config::ConfigError;
use models::sensors::constellation::{SatelliteFailures, SkyConfig};
use models::sensors::cooperative::{Equipage, Equipped as Carriers};
use models::sensors::dgps::{
    Budgeted, Dgps, DgpsConfig, DgpsModel, DifferentialBudget, ReferenceLoss,
};
use models::sensors::dynamic::{Dynamic, DynamicConfig};
use models::sensors::gps::{
    Diluted, Gps, GpsConfig, GpsModel, NorthEast, SoftFailure, Statistical,
};
use models::sensors::induction_loop::{InductionLoop, LoopConfig};
use models::sensors::mlat::{BlindSector, Mlat, MlatConfig, Station};
use models::sensors::offline::{Offline, OfflineConfig};
use models::sensors::ranging::{RangeBudget, RangeCorrections, RangingConfig};
use models::sensors::service::{Alternating, Service};
use models::sensors::shadow::Building;
use std::cell::RefCell;

use super::Equipped;

/// A checked sensor of one of these kinds.
#[derive(Clone, Debug, PartialEq)]
pub enum Reported {
    /// Satellite positioning.
    Gps(GpsConfig),
    /// Differential satellite positioning.
    Dgps(DgpsConfig),
    /// Position broadcasts.
    Adsb(AdsbConfig),
    /// Multilateration.
    Mlat(MlatConfig),
    /// Induction loops.
    Loop(LoopConfig),
    /// On-board dead reckoning.
    Dynamic(DynamicConfig),
    /// Fitted figures in place of any model.
    Offline(OfflineConfig),
}

impl Reported {
    /// Seconds between two reports of a mover, and the nominal delay of a report's position.
    #[must_use]
    pub fn timing_s(&self) -> (f64, f64) {
        match self {
            Self::Gps(config) => (config.report_s, 0.0),
            Self::Dgps(config) => (config.report_s, 0.0),
            Self::Adsb(config) => {
                (config.moving_s, 0.5 * (config.latency_min_s + config.latency_max_s))
            }
            Self::Mlat(config) => (config.report_s, 0.0),
            Self::Loop(_) => (1.0, 0.0),
            Self::Dynamic(config) => (config.report_s, 0.0),
            Self::Offline(config) => (config.figures.period_s, 0.0),
        }
    }

    /// The sensor, which knows no target yet, planned for a tolerance and a run of `run_s`.
    ///
    /// # Errors
    /// If the model refuses a parameter; a scene that was read holds none such.
    pub fn sensor(&self, plan: Tolerance, run_s: f64) -> Result<Box<dyn Sensor>, ConfigError> {
        let mut sensor = self.model()?;
        sensor.planning_mut().tolerate(plan, run_s);
        Ok(sensor)
    }

    /// The sensor, which knows no target yet, planned with nothing to lose.
    ///
    /// # Errors
    /// If the model refuses a parameter; a scene that was read holds none such.
    pub fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(match self.clone() {
            Self::Gps(config) => Box::new(Gps::new(config)?),
            Self::Dgps(config) => Box::new(Dgps::new(config)?),
            Self::Adsb(config) => Box::new(Adsb::new(config)?),
            Self::Mlat(config) => Box::new(Mlat::new(config)?),
            Self::Loop(config) => Box::new(InductionLoop::new(config)?),
            Self::Dynamic(config) => Box::new(Dynamic::new(config)?),
            Self::Offline(config) => Box::new(Offline::new(config)?),
        })
    }

    fn validate(&self) -> Result<(), ConfigError> {
        match self {
            Self::Gps(config) => config.validate(),
            Self::Dgps(config) => config.validate(),
            Self::Adsb(config) => config.validate(),
            Self::Mlat(config) => config.validate(),
            Self::Loop(config) => config.validate(),
            Self::Dynamic(config) => config.validate(),
            Self::Offline(config) => config.validate(),
        }
    }
}

/// What a sensor is read from.
pub(super) struct Place<'a> {
    pub(super) run: &'a Run,
    pub(super) airport: &'a AirportScene,
    pub(super) id: SensorId,
    pub(super) site_m: Option<Vector3<f64>>,
    pub(super) equipped: &'a Equipped,
    pub(super) buildings: &'a [Building],
}

/// Reads one sensor; `None` for kinds that are not of this module.
pub(super) fn read(
    kind: SensorKind,
    section: &Section,
    overrides: &Section,
    place: &Place<'_>,
) -> Result<Option<Reported>, ScenarioError> {
    let keys = Keys { overrides, tried: RefCell::new(Vec::new()) };
    let reported = match kind {
        SensorKind::Asde => return Ok(None),
        SensorKind::Gps => Reported::Gps(gps(section, &keys, place)?),
        SensorKind::Dgps => Reported::Dgps(dgps(section, &keys, place)?),
        SensorKind::Adsb => Reported::Adsb(adsb(section, &keys, place)?),
        SensorKind::Mlat => Reported::Mlat(mlat(section, &keys, place)?),
        SensorKind::Loop => Reported::Loop(induction_loop(section, &keys, place)?),
        SensorKind::Dynamic => Reported::Dynamic(dynamic(section, &keys, place)?),
    };
    overrides.only(&keys.tried.borrow())?;
    match reported.validate() {
        Ok(()) => Ok(Some(reported)),
        Err(error) => Err(refuse(section, overrides, error)),
    }
}

/// The model's refusal at the line that gave the value, or at the sensor's.
fn refuse(section: &Section, overrides: &Section, error: ConfigError) -> ScenarioError {
    let (ConfigError::Number { key, .. }
    | ConfigError::Count { key, .. }
    | ConfigError::Shape { key, .. }
    | ConfigError::Conflict { key, .. }) = error;
    if overrides.has(key) {
        overrides.refused_by_model(key, error)
    } else if section.has("parameters") {
        section.refused_by_model("parameters", error)
    } else {
        section.refused_by_model("kind", error)
    }
}

/// Reads overrides into a preset, and remembers which keys there are.
struct Keys<'a> {
    overrides: &'a Section,
    tried: RefCell<Vec<&'static str>>,
}

impl Keys<'_> {
    fn note(&self, key: &'static str) {
        self.tried.borrow_mut().push(key);
    }

    /// A number of any size: the model checks it.
    fn optional(&self, key: &'static str) -> Result<Option<f64>, ScenarioError> {
        self.note(key);
        self.overrides.number(key, within(f64::NEG_INFINITY, f64::INFINITY, ""))
    }

    fn number(&self, key: &'static str, value: &mut f64) -> Result<(), ScenarioError> {
        if let Some(found) = self.optional(key)? {
            *value = found;
        }
        Ok(())
    }

    fn flag(&self, key: &'static str, value: &mut bool) -> Result<(), ScenarioError> {
        self.note(key);
        if let Some(found) = self.overrides.flag(key)? {
            *value = found;
        }
        Ok(())
    }

    fn choice<T: Clone>(
        &self,
        key: &'static str,
        default: T,
        allowed: &[(&str, T)],
    ) -> Result<T, ScenarioError> {
        self.note(key);
        Ok(self.overrides.choice(key, allowed)?.unwrap_or(default))
    }

    fn sections(&self, key: &'static str, allowed: &[&str]) -> Result<Vec<Section>, ScenarioError> {
        self.note(key);
        self.overrides.sections(key, allowed)
    }

    /// A service given by its share of time up and its mean outage.
    fn service(
        &self,
        share: &'static str,
        outage: &'static str,
        value: &mut Alternating,
    ) -> Result<(), ScenarioError> {
        let up = self.optional(share)?.unwrap_or_else(|| value.up_share());
        let down_s = self.optional(outage)?.unwrap_or(value.mean_down_s);
        if self.overrides.has(share) || self.overrides.has(outage) {
            *value = Alternating::from_share(up, down_s);
        }
        Ok(())
    }

    fn services(&self, service: &mut Service) -> Result<(), ScenarioError> {
        self.service("coverage", "coverage_mttr_s", &mut service.coverage)?;
        self.service("availability", "availability_mttr_s", &mut service.availability)?;
        self.service("reliability", "reliability_mttr_s", &mut service.reliability)
    }

    fn soft(&self, soft: &mut SoftFailure) -> Result<(), ScenarioError> {
        self.number("soft_step_m", &mut soft.step_m)?;
        self.number("soft_ramp_m_per_s", &mut soft.ramp_m_per_s)?;
        self.number("soft_limit_m", &mut soft.limit_m)
    }

    fn equipage(&self, equipped: &Equipped) -> Result<Equipage, ScenarioError> {
        let mut equipage = equipage(equipped);
        self.flag("aircraft", &mut equipage.aircraft)?;
        self.flag("vehicles", &mut equipage.vehicles)?;
        Ok(equipage)
    }

    fn sky(&self, place: &Place<'_>, step_s: f64) -> Result<SkyConfig, ScenarioError> {
        let epoch_s = (place.run.start_utc_ns - GPS_EPOCH_UTC_NS) as f64 * 1e-9;
        let mut sky = SkyConfig::reference(place.airport.reference, epoch_s);
        sky.step_s = step_s;
        self.number("mask_deg", &mut sky.mask_deg)?;
        self.number("pdop_limit", &mut sky.pdop_limit)?;
        self.number("step_s", &mut sky.step_s)?;
        let mut fail = true;
        self.flag("satellite_failures", &mut fail)?;
        if !fail {
            sky.failures = SatelliteFailures::never();
        }
        Ok(sky)
    }

    fn ranges(&self, place: &Place<'_>) -> Result<RangingConfig, ScenarioError> {
        let mut b = RangeBudget::modern();
        self.number("selective_availability_m", &mut b.selective_availability.sigma_m)?;
        self.number("selective_availability_tau_s", &mut b.selective_availability.tau_s)?;
        self.number("clock_ephemeris_m", &mut b.clock_ephemeris.sigma_m)?;
        self.number("clock_ephemeris_tau_s", &mut b.clock_ephemeris.tau_s)?;
        self.number("ionosphere_m", &mut b.ionosphere.sigma_m)?;
        self.number("ionosphere_tau_s", &mut b.ionosphere.tau_s)?;
        self.number("troposphere_m", &mut b.troposphere.sigma_m)?;
        self.number("troposphere_tau_s", &mut b.troposphere.tau_s)?;
        self.number("multipath_m", &mut b.multipath.sigma_m)?;
        self.number("multipath_tau_s", &mut b.multipath.tau_s)?;
        self.number("noise_m", &mut b.noise_m)?;
        let mut weighted = false;
        self.flag("weighted", &mut weighted)?;
        Ok(RangingConfig { sky: self.sky(place, 1.0)?, budget: b, weighted, corrections: None })
    }
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

/// 1993-07-01T00:00:00Z, the epoch of the reference constellation.
const GPS_EPOCH_UTC_NS: i64 = 741_484_800 * 1_000_000_000;

/// A preset by its name, the first one where none is given.
fn preset<T: Clone>(section: &Section, presets: &[(&str, T)]) -> Result<T, ScenarioError> {
    match section.choice("parameters", presets)? {
        Some(preset) => Ok(preset),
        None => Ok(presets[0].1.clone()),
    }
}

#[derive(Clone, Copy)]
enum Level {
    Statistical,
    Constellation,
    PerSatellite,
}

fn gps(section: &Section, keys: &Keys<'_>, place: &Place<'_>) -> Result<GpsConfig, ScenarioError> {
    let presets = [
        ("sps_2020", Statistical::sps_2020()),
        ("sps_2001", Statistical::sps_2001()),
        ("sps_1995", Statistical::sps_1995()),
    ];
    let mut statistics = preset(section, &presets)?;
    let level = keys.choice(
        "level",
        Level::Statistical,
        &[
            ("statistical", Level::Statistical),
            ("constellation", Level::Constellation),
            ("per_satellite", Level::PerSatellite),
        ],
    )?;
    let model = match level {
        Level::Statistical => {
            keys.services(&mut statistics.service)?;
            keys.soft(&mut statistics.soft)?;
            north_east(keys, &mut statistics.error)?;
            GpsModel::Statistical(statistics)
        }
        Level::Constellation => {
            let mut model = Diluted::reference(keys.sky(place, 10.0)?);
            keys.number("uere_m", &mut model.uere_m)?;
            keys.number("correlated_share", &mut model.correlated_share)?;
            keys.number("tau_s", &mut model.tau_s)?;
            GpsModel::Constellation(model)
        }
        Level::PerSatellite => GpsModel::PerSatellite(keys.ranges(place)?),
    };
    let mut config = GpsConfig::of(place.id, model);
    config.equipped = keys.equipage(place.equipped)?;
    keys.number("report_s", &mut config.report_s)?;
    Ok(config)
}

fn north_east(keys: &Keys<'_>, error: &mut NorthEast) -> Result<(), ScenarioError> {
    keys.number("mean_north_m", &mut error.mean_north_m)?;
    keys.number("mean_east_m", &mut error.mean_east_m)?;
    keys.number("sigma_north_m", &mut error.sigma_north_m)?;
    keys.number("sigma_east_m", &mut error.sigma_east_m)?;
    keys.number("correlated_share", &mut error.correlated_share)?;
    keys.number("tau_s", &mut error.tau_s)
}

fn dgps(
    section: &Section,
    keys: &Keys<'_>,
    place: &Place<'_>,
) -> Result<DgpsConfig, ScenarioError> {
    let mut model = preset(section, &[("on_airport", Budgeted::on_airport())])?;
    let reference_m = place.site_m.map_or_else(Vector2::zeros, |site| site.xy());
    let mut config = DgpsConfig::on_airport(place.id, reference_m);
    config.equipped = keys.equipage(place.equipped)?;
    keys.number("report_s", &mut config.report_s)?;
    keys.service("reference_up", "reference_mttr_s", &mut config.reference)?;
    let alone =
        keys.choice("on_reference_loss", false, &[("no_report", false), ("stand_alone", true)])?;
    if alone {
        config.on_reference_loss = ReferenceLoss::StandAlone(Statistical::sps_2020().error);
    }
    let ranges = keys.choice("level", false, &[("budget", false), ("per_satellite", true)])?;
    config.model = if ranges {
        let mut ranging = keys.ranges(place)?;
        let mut c = RangeCorrections::on_airport();
        keys.number("reference_range_m", &mut c.reference.sigma_m)?;
        keys.number("reference_tau_s", &mut c.reference.tau_s)?;
        keys.number("iono_gradient", &mut c.iono_gradient)?;
        keys.number("smoothing_s", &mut c.smoothing_s)?;
        keys.number("space_decorrelation", &mut c.space_decorrelation)?;
        keys.number("correction_latency_s", &mut c.latency_s)?;
        keys.number("correction_s", &mut c.period_s)?;
        ranging.corrections = Some(c);
        DgpsModel::PerSatellite(ranging)
    } else {
        keys.services(&mut model.service)?;
        keys.soft(&mut model.soft)?;
        differential(keys, &mut model.budget)?;
        keys.number("north_factor", &mut model.north_factor)?;
        keys.number("east_factor", &mut model.east_factor)?;
        keys.number("correlated_share", &mut model.correlated_share)?;
        keys.number("tau_s", &mut model.tau_s)?;
        keys.number("correction_latency_s", &mut model.correction_latency_s)?;
        keys.number("correction_s", &mut model.correction_s)?;
        DgpsModel::Budget(model)
    };
    Ok(config)
}

fn differential(keys: &Keys<'_>, budget: &mut DifferentialBudget) -> Result<(), ScenarioError> {
    keys.number("sigma_user_m", &mut budget.sigma_user_m)?;
    keys.number("sigma_ref_m", &mut budget.sigma_ref_m)?;
    keys.number("iono_gradient", &mut budget.iono_gradient)?;
    keys.number("obliquity", &mut budget.obliquity)?;
    keys.number("smoothing_s", &mut budget.smoothing_s)?;
    keys.number("space_decorrelation", &mut budget.space_decorrelation)?;
    keys.number("correction_acceleration_ms2", &mut budget.correction_acceleration_ms2)
}

fn adsb(
    section: &Section,
    keys: &Keys<'_>,
    place: &Place<'_>,
) -> Result<AdsbConfig, ScenarioError> {
    let latitude_deg = place.airport.reference.lat_deg();
    let mut config = preset(section, &[("surface", AdsbConfig::surface(place.id, latitude_deg))])?;
    config.equipped = keys.equipage(place.equipped)?;
    keys.note("nacp");
    if let Some(nacp) = keys.overrides.integer("nacp", 0, 255)? {
        config.nacp = nacp as u8;
    }
    keys.number("report_s", &mut config.moving_s)?;
    keys.number("parked_s", &mut config.parked_s)?;
    keys.number("parked_below_mps", &mut config.parked_below_mps)?;
    keys.number("latency_min_s", &mut config.latency_min_s)?;
    keys.number("latency_max_s", &mut config.latency_max_s)?;
    keys.number("reception", &mut config.reception)?;
    keys.number("correlated_share", &mut config.correlated_share)?;
    keys.number("tau_s", &mut config.tau_s)?;
    Ok(config)
}

fn mlat(
    section: &Section,
    keys: &Keys<'_>,
    place: &Place<'_>,
) -> Result<MlatConfig, ScenarioError> {
    let mut config = preset(section, &[("airport", MlatConfig::with_stations(place.id, &[]))])?;
    config.equipped = keys.equipage(place.equipped)?;
    let station_keys = ["lat_deg", "lon_deg", "east_m", "north_m", "height_m", "range_m", "blind"];
    for station in keys.sections("stations", &station_keys)? {
        let mut blind = Vec::new();
        for sector in station.sections("blind", &["from_deg", "to_deg", "beyond_m"])? {
            let any = |key| sector.need_number(key, within(f64::NEG_INFINITY, f64::INFINITY, ""));
            let beyond_m = any("beyond_m")?;
            blind.push(BlindSector {
                from_deg: any("from_deg")?,
                to_deg: any("to_deg")?,
                beyond_m,
            });
        }
        let site_m = place.airport.site(&station.without(&["range_m", "blind"]))?;
        let height_m = if station.has("height_m") { site_m.z } else { 15.0 };
        config.stations.push(Station {
            position_m: site_m.xy(),
            height_m,
            range_m: station.number_or("range_m", 10_000.0, within(1.0, 1e6, "m"))?,
            blind,
        });
    }
    config.buildings = place.buildings.into();
    if config.stations.is_empty() {
        let needed = "a list of at least three places [{ lat_deg = …, lon_deg = … }, …]".into();
        return Err(keys.overrides.missing("stations", needed));
    }
    keys.number("report_s", &mut config.report_s)?;
    keys.number("sigma_t_s", &mut config.sigma_t_s)?;
    keys.number("multipath", &mut config.multipath)?;
    keys.number("multipath_m", &mut config.multipath_m)?;
    keys.number("reception", &mut config.reception)?;
    keys.number("max_dilution", &mut config.max_dilution)?;
    Ok(config)
}

fn induction_loop(
    section: &Section,
    keys: &Keys<'_>,
    place: &Place<'_>,
) -> Result<LoopConfig, ScenarioError> {
    let site_m = place.site_m.map_or_else(Vector2::zeros, |site| site.xy());
    let mut pair = LoopConfig::pair_at(place.id, site_m, 0.0);
    let single = LoopConfig { pair: None, ..pair.clone() };
    pair = preset(section, &[("pair", pair), ("single", single)])?;
    if section.has("equipped") {
        let found = "equipped".into();
        let allowed = "a loop sees whoever passes: leave `equipped` out".into();
        return Err(section.refuse("equipped", Problem::NotAllowed { found, allowed }));
    }
    let Some(direction_deg) = keys.optional("direction_deg")? else {
        let needed = "the direction of the taxiway, degrees clockwise from north".into();
        return Err(keys.overrides.missing("direction_deg", needed));
    };
    pair.direction_deg = direction_deg;
    keys.number("length_m", &mut pair.length_m)?;
    keys.number("half_width_m", &mut pair.half_width_m)?;
    if let Some(loops) = &mut pair.pair {
        keys.number("spacing_m", &mut loops.spacing_m)?;
        keys.number("sigma_spacing_m", &mut loops.sigma_spacing_m)?;
    }
    keys.number("sigma_edge_m", &mut pair.sigma_edge_m)?;
    keys.number("delay_s", &mut pair.delay_s)?;
    keys.number("pd", &mut pair.pd)?;
    keys.number("false_per_h", &mut pair.false_per_h)?;
    keys.number("assumed_half_length_m", &mut pair.assumed_half_length_m)?;
    keys.number("sigma_half_length_m", &mut pair.sigma_half_length_m)?;
    keys.number("assumed_speed_mps", &mut pair.assumed_speed_mps)?;
    Ok(pair)
}

fn dynamic(
    section: &Section,
    keys: &Keys<'_>,
    place: &Place<'_>,
) -> Result<DynamicConfig, ScenarioError> {
    let mut config = preset(section, &[("odometer", DynamicConfig::odometer(place.id))])?;
    config.equipped = keys.equipage(place.equipped)?;
    keys.number("report_s", &mut config.report_s)?;
    keys.number("sigma_scale", &mut config.sigma_scale)?;
    keys.number("sigma_heading_deg", &mut config.sigma_heading_deg)?;
    keys.number("heading_walk_deg_per_sqrt_h", &mut config.heading_walk_deg_per_sqrt_h)?;
    keys.number("sigma_start_m", &mut config.sigma_start_m)?;
    keys.number("sigma_white_m", &mut config.sigma_white_m)?;
    keys.number("reset_radius_m", &mut config.reset_radius_m)?;
    for spot in keys.sections("resets", &["lat_deg", "lon_deg", "east_m", "north_m"])? {
        config.resets_m.push(place.airport.site(&spot)?.xy());
    }
    Ok(config)
}
