//! `[tracking]` and `[accuracy]`: which rung of each ladder, and what error a user tolerates.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use crate::sensors::SensorScene;
use crate::types::TypeTable;
use models::airport::Airport;
use models::effects::Tolerance;
use models::filter::map::MapKnowledge;
use models::filter::route::Network;
use models::filter::{FilterConfig, Rung};
use models::fusion::TrackingConfig;
use models::fusion::config::{AssociationMethod, ExistenceRules, SensorModel, TypeSize};
use models::sensors::radar::detection::Detector;
use models::sensors::radar::levels::Processing;
use std::sync::Arc;

/// `[tracking]` of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracking {
    /// The named choice that everything not said follows.
    pub profile: Profile,
    /// What the tracker is told; sensors and sizes of types are added by [`crate::Scene::tracking_config`].
    pub config: TrackingConfig,
    /// Whether errors of radar sites are estimated from what taxis on the airport's lanes too.
    pub register_map: bool,
}

/// A named choice of filter, gates, association and fusion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// As in the paper: three-state filter per axis, nearest neighbour.
    #[default]
    Paper,
    /// Smallest error.
    Accurate,
    /// Most targets.
    Bulk,
}

impl Profile {
    /// The tracker's configuration of this name.
    #[must_use]
    pub fn config(self) -> TrackingConfig {
        match self {
            Self::Paper => TrackingConfig::paper(),
            Self::Accurate => TrackingConfig::accurate(),
            Self::Bulk => TrackingConfig::bulk(),
        }
    }
}

/// `[accuracy]` of a scene: what may be lost against everything simulated exactly, on the same draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Rms distance of plots that both runs have, m.
    pub position_m: f64,
    /// Share of them that may be farther apart than five times that.
    pub tail: f64,
    /// Share of scans in which only one run has the plot.
    pub detection: f64,
    /// Expected number of false plots and ghosts of one run only, per scan and radar.
    pub false_plots: f64,
    /// Rms shift of the published position of a steady filter, m, where asked for.
    pub track_m: Option<f64>,
    /// Time of a scan and radar by the table of costs, µs, where it is limited: the other keys are then
    /// the unit of a factor.
    pub time_budget_us: Option<f64>,
}

impl Accuracy {
    /// The tolerance that the effects are planned for, with the jerk of the scene's filter.
    #[must_use]
    pub fn tolerance(&self, jerk_m2_s5: f64) -> Tolerance {
        Tolerance {
            position_m: self.position_m,
            tail: self.tail,
            detection: self.detection,
            false_plots: self.false_plots,
            track_m: self.track_m,
            jerk_m2_s5,
            time_budget_us: self.time_budget_us,
        }
    }
}

/// Reads `[tracking]`.
pub(crate) fn read(root: &Section) -> Result<Tracking, ScenarioError> {
    let section =
        root.section("tracking", &words(keys::TRACKING))?.unwrap_or_else(|| root.empty("tracking"));
    let profiles =
        [("paper", Profile::Paper), ("accurate", Profile::Accurate), ("bulk", Profile::Bulk)];
    let profile = section.choice("profile", &profiles)?.unwrap_or_default();
    let mut config = profile.config();
    let rungs: Vec<(&str, Rung)> = Rung::ALL.iter().map(|&(rung, name)| (name, rung)).collect();
    if let Some(rung) = section.choice("filter", &rungs)? {
        config.filter = FilterConfig::new(rung);
    }
    let set = |slot: &mut f64, key: &str, low: f64, high: f64, unit: &'static str| {
        *slot = section.number_or(key, *slot, within(low, high, unit))?;
        Ok(())
    };
    set(&mut config.filter.q, "q", 1e-9, 1e6, "m²/s⁵")?;
    let limit = section.integer("joint_limit", 2, 10_000_000)?.unwrap_or(100_000) as usize;
    let methods = [
        ("nearest", AssociationMethod::Nearest),
        ("global", AssociationMethod::Global),
        ("joint", AssociationMethod::Joint { limit }),
    ];
    if let Some(method) = section.choice("association", &methods)? {
        config.association = method;
    } else if let AssociationMethod::Joint { limit: slot } = &mut config.association {
        *slot = limit;
    }
    let lives = [("m_of_n", None), ("existence", Some(ExistenceRules::default()))];
    if let Some(life) = section.choice("life", &lives)? {
        config.life.existence = life;
    }
    let gates = &mut config.gates;
    set(&mut gates.probability, "gate_probability", 0.5, 1.0 - 1e-12, "")?;
    set(&mut gates.identified_probability, "identified_gate_probability", 0.5, 1.0 - 1e-12, "")?;
    gates.kinematic = section.flag("kinematic_gate")?.unwrap_or(gates.kinematic);
    gates.restart = section.flag("restart")?.unwrap_or(gates.restart);
    let life = &mut config.life;
    let count = |slot: &mut u32, key: &str, low: i64, high: i64| {
        *slot = section.integer(key, low, high)?.map_or(*slot, |n| n as u32);
        Ok(())
    };
    count(&mut life.confirm_of, "confirm_of", 1, 32)?;
    count(&mut life.confirm_hits, "confirm_hits", 1, i64::from(life.confirm_of))?;
    count(&mut life.identified_of, "identified_of", 1, 32)?;
    count(&mut life.identified_hits, "identified_hits", 1, i64::from(life.identified_of))?;
    life.confirm_hits = life.confirm_hits.min(life.confirm_of);
    life.identified_hits = life.identified_hits.min(life.identified_of);
    count(&mut life.numbers, "track_numbers", 1, 65_536)?;
    set(&mut life.constant_velocity_after_s, "constant_velocity_after_s", 0.0, 60.0, "s")?;
    set(&mut life.coast_q, "coast_q", 0.0, 1e3, "m²/s³")?;
    set(&mut life.delete_moving_s, "delete_moving_s", 0.5, 600.0, "s")?;
    set(&mut life.delete_standing_s, "delete_standing_s", 0.5, 3600.0, "s")?;
    set(&mut life.delete_radius_m, "delete_radius_m", 1.0, 10_000.0, "m")?;
    set(&mut life.number_rest_s, "number_rest_s", 0.0, 3600.0, "s")?;
    set(&mut config.ring_s, "late_s", 0.0, 60.0, "s")?;
    set(&mut config.duplicate_radius_m, "duplicate_radius_m", 0.0, 100.0, "m")?;
    set(&mut config.scan_budget_ms, "scan_budget_ms", 1.0, 1e6, "ms")?;
    let flag = |slot: &mut bool, key: &str| {
        *slot = section.flag(key)?.unwrap_or(*slot);
        Ok(())
    };
    flag(&mut config.consider_slow_errors, "consider_slow_errors")?;
    flag(&mut config.register_sites, "register_sites")?;
    flag(&mut config.register_echo, "register_echo")?;
    flag(&mut config.amplitude, "amplitude")?;
    flag(&mut config.second_ago, "second_ago")?;
    let labels = &mut config.labels;
    set(&mut labels.stand_radius_m, "stand_radius_m", 1.0, 500.0, "m")?;
    set(&mut labels.list_sigma_s, "list_sigma_s", 1.0, 86_400.0, "s")?;
    Ok(Tracking { profile, config, register_map: section.flag("register_map")?.unwrap_or(false) })
}

/// The configuration with the scene's sensors and the sizes of all types.
/// What asks for a map gets the airport's.
pub(crate) fn complete(
    tracking: &Tracking,
    sensors: &[SensorScene],
    types: &TypeTable,
    airport: &Airport,
) -> TrackingConfig {
    let mut config = tracking.config.clone();
    if config.filter.rung == Rung::Mh9Map {
        config.filter.map = Some(Arc::new(MapKnowledge::of(Network::of_airport(airport))));
    }
    if tracking.register_map {
        config.lanes = Some(Arc::new(Network::of_airport(airport)));
    }
    config.sensors = sensors.iter().map(model_of).collect();
    config.sizes = types
        .designators()
        .filter_map(|designator| types.get(designator))
        .map(|row| TypeSize {
            designator: row.class.designator.clone(),
            length_m: row.class.length_m,
            span_m: row.class.span_m,
        })
        .collect();
    config
}

/// What the tracker knows of a sensor: how often it looks, its nominal delay, and the strengths of its noise.
fn model_of(sensor: &SensorScene) -> SensorModel {
    let model = SensorModel::default_of(sensor.id, sensor.kind);
    let (interval_s, latency_s) = match (&sensor.asde, &sensor.reported) {
        (Some(radar), _) => (60.0 / radar.parameters.rotation_rpm, 0.0),
        (None, Some(reported)) => reported.timing_s(),
        (None, None) => match &sensor.foreign {
            Some(foreign) => (foreign.interval_s, 0.0),
            None => return model,
        },
    };
    let standing_interval_s = sensor.reported.as_ref().map_or(0.0, |r| r.standing_s());
    let late_sigma_s = sensor.reported.as_ref().map_or(0.0, |r| r.late_sigma_s());
    // Of a blob of cells the strongest is told, and noise of one cell says nothing of that.
    let of_plots = |p: Option<Processing>| p.is_none_or(|p| p == Processing::Plot);
    let radar = sensor.asde.as_ref().filter(|radar| of_plots(radar.processing));
    let strength = radar.map(|radar| {
        Detector::new(radar.parameters.pulses_summed(), radar.parameters.pfa).strengths()
    });
    SensorModel { interval_s, standing_interval_s, latency_s, late_sigma_s, strength, ..model }
}

/// Reads `[accuracy]`.
pub(crate) fn read_accuracy(root: &Section) -> Result<Accuracy, ScenarioError> {
    let mut allowed = words(keys::ACCURACY);
    allowed.push(keys::ACCURACY_BEFORE);
    let section = root.section("accuracy", &allowed)?.unwrap_or_else(|| root.empty("accuracy"));
    if section.has(keys::ACCURACY_BEFORE) {
        let instead = "position_m, tail, detection, false_plots and track_m say what may change";
        return Err(section.refuse(keys::ACCURACY_BEFORE, Problem::Replaced { instead }));
    }
    let default = Tolerance::default();
    Ok(Accuracy {
        position_m: section.number_or(
            "position_m",
            default.position_m,
            within(0.0, 1000.0, "m"),
        )?,
        tail: section.number_or("tail", default.tail, within(0.0, 1.0, ""))?,
        detection: section.number_or("detection", default.detection, within(0.0, 1.0, ""))?,
        false_plots: section.number_or("false_plots", default.false_plots, within(0.0, 1e6, ""))?,
        track_m: section.number("track_m", within(0.0, 1000.0, "m"))?,
        time_budget_us: section.number("time_budget_us", within(1.0, 1e9, "µs"))?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::frames::{Point2, Vector2};
    use models::plot::{Plot, SensorId, SensorKind};
    use models::time::SimTime;
    use std::path::Path;

    fn tracking(text: &str) -> Result<Tracking, ScenarioError> {
        read(&Section::parse(Path::new("scene.toml"), text).expect("TOML"))
    }

    #[test]
    fn a_profile_is_the_base_and_single_keys_differ_from_it() {
        let paper = tracking("").expect("nothing said");
        assert_eq!((paper.profile, paper.config), (Profile::Paper, TrackingConfig::paper()));
        let mixed = tracking(
            "[tracking]\nprofile = \"accurate\"\nfilter = \"ca6\"\nq = 0.1\nassociation = \"joint\"\n\
             joint_limit = 500\nconfirm_hits = 2\nconfirm_of = 3\nlate_s = 2.0\nkinematic_gate = false",
        )
        .expect("sound");
        let expected = {
            let mut c = TrackingConfig::accurate();
            c.filter = FilterConfig::new(Rung::Ca6);
            c.filter.q = 0.1;
            c.association = AssociationMethod::Joint { limit: 500 };
            (c.life.confirm_hits, c.life.confirm_of, c.ring_s) = (2, 3, 2.0);
            c.gates.kinematic = false;
            c
        };
        assert_eq!(mixed.config, expected);
    }

    #[test]
    fn what_no_profile_has_is_on_by_its_key_alone() {
        for profile in ["paper", "accurate", "bulk"] {
            let with = |keys: &str| {
                tracking(&format!("[tracking]\nprofile = \"{profile}\"\n{keys}")).expect("sound")
            };
            let (off, on) = (with(""), with("amplitude = true\nregister_map = true"));
            assert!(!off.config.amplitude && !off.register_map, "{profile}");
            assert!(on.config.amplitude && on.register_map, "{profile}");
            let same = TrackingConfig { amplitude: false, ..on.config };
            assert_eq!(same, off.config, "{profile}: nothing else");
        }
    }

    #[test]
    fn what_is_not_allowed_is_refused_with_its_line() {
        for (text, needle) in [
            ("[tracking]\nfiler = \"ca3\"", "filer"),
            ("[tracking]\nfilter = \"magic\"", "tracking.filter"),
            ("[tracking]\nassociation = \"best\"", "tracking.association"),
            ("[tracking]\nq = -1.0", "tracking.q"),
            ("[tracking]\ngate_probability = 1.0", "tracking.gate_probability"),
            ("[tracking]\nconfirm_hits = 5\nconfirm_of = 4", "tracking.confirm_hits"),
            ("[tracking]\ndelete_moving_s = \"soon\"", "tracking.delete_moving_s"),
        ] {
            let error = tracking(text).expect_err(text).to_string();
            assert!(error.starts_with("scene.toml:2:") && error.contains(needle), "{error}");
        }
    }

    /// Mean squared error of the positions of all movers of a scene on the ground, of plots of 3 m per axis
    /// once a second and of the filter on them, m².
    fn errors(scene: &crate::Scene, filter: &FilterConfig) -> (f64, f64) {
        use models::draw::{DrawKey, Purpose, normal_pair};
        use models::filter::{Estimator, StateEstimator};
        let (mut raw, mut filtered, mut count) = (0.0, 0.0, 0.0);
        for (n, entity) in scene.traffic.entities.iter().enumerate() {
            let Some(trajectory) = &entity.trajectory else { continue };
            let mut track: Option<(Estimator, u32)> = None;
            for k in 0..600u32 {
                let time = SimTime::from_s(f64::from(k));
                let Some(truth) = trajectory.at(time).filter(|t| t.position_m.z < 5.0) else {
                    track = None;
                    continue;
                };
                let truth = truth.position_m.xy();
                let key = DrawKey { run_seed: 3, sensor: 1, entity: n as u64, scan: k.into() };
                let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
                let plot = plot(time, truth + Vector2::new(3.0 * a, 3.0 * b));
                match &mut track {
                    None => track = Some((Estimator::from_plot(filter, &plot).expect("sound"), k)),
                    Some((filter, since)) => {
                        filter.update(&plot).expect("sound");
                        assert!(filter.estimate().state.is_sound());
                        if k > *since + 5 {
                            raw += (plot.position_m - truth).norm_squared();
                            filtered += (filter.estimate().position_m() - truth).norm_squared();
                            count += 1.0;
                        }
                    }
                }
            }
        }
        (raw / count, filtered / count)
    }

    fn plot(time: SimTime, position_m: Point2<f64>) -> Plot {
        Plot {
            sensor: SensorId(1),
            kind: SensorKind::Asde,
            time,
            sequence: 0,
            position_m,
            axis: Vector2::new(1.0, 0.0),
            along_m2: 9.0,
            across_m2: 9.0,
            altitude_m: None,
            polar: None,
            identity: None,
            scnr_db: None,
        }
    }

    #[test]
    fn a_scene_that_asks_for_the_map_gets_its_airports_and_a_smaller_error() {
        let scene = crate::load(&crate::locate("zurich")).expect("sound");
        let free =
            complete(&scene.tracking, &scene.sensors, &scene.traffic.types, &scene.airport.layout);
        assert_eq!(free.filter.map, None, "not asked for");
        let mut asked = scene.tracking.clone();
        asked.config.filter = FilterConfig::new(Rung::Mh9Map);
        let config = complete(&asked, &scene.sensors, &scene.traffic.types, &scene.airport.layout);
        let map = config.filter.map.as_ref().expect("the airport's");
        let edges = &map.network.edges;
        assert!(edges.len() > 100 && edges.len() <= 2 * scene.airport.layout.edges.len() + 6);
        for edge in edges {
            let sum: f64 = edge.next.iter().map(|way| way.1).sum();
            assert!(edge.next.is_empty() || (sum - 1.0).abs() < 1e-12);
            assert!(edge.width_m > 0.0 && edge.route.length_m() > 0.0);
        }
        let (raw, with_map) = errors(&scene, &config.filter);
        let (_, without) = errors(&scene, &FilterConfig::new(Rung::Imm3));
        println!("plots {raw:.2} m², imm3 {without:.2}, mh9-map {with_map:.2}");
        // A better mixing filter leaves the map less to gain, so the map's error is held by itself too:
        // nine tenths of the 8.86 m² that mixing once had on these plots of 18.28 m².
        assert!(with_map < 0.436 * raw, "{with_map:.2} m² of {raw:.2}");
        assert!(with_map < 0.95 * without && without < raw);
    }
}
