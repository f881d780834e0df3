//! What the tracker is told: every number here is a choice of the scene, with a default.

use super::near_side::EchoLaw;
use crate::association::amplitude::AmplitudeLaw;
use crate::association::kinematic_gate::ClassLimits;
use crate::filter::route::Network;
use crate::filter::{FilterConfig, Rung};
use crate::flight_list::{FlightEntry, MovementKind, WakeCategory};
use crate::plot::{Plot, SensorId, SensorKind};
use std::sync::Arc;

/// How plots are given to tracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AssociationMethod {
    /// All gated pairs by distance, greedily: the paper's sub-optimal nearest neighbour.
    Nearest,
    /// The cheapest set of pairs and misses, cluster by cluster.
    Global,
    /// Exact joint probabilistic association in clusters of more than one pair. A cluster of more
    /// than `limit` states (`tracks · 2^plots`) is thinned by belief propagation, then, if still too
    /// large, done by [`Self::Global`] and counted.
    Joint {
        /// Largest `tracks · 2^plots` of a cluster.
        limit: usize,
    },
}

/// The two gates and what follows a refusal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gates {
    /// Probability that the covariance gate holds a true plot.
    pub probability: f64,
    /// The same for plots with an identity.
    pub identified_probability: f64,
    /// Whether plots that the first gate refused are offered to the kinematic gate.
    pub kinematic: bool,
    /// Probability that the reachable set, widened by what is uncertain, holds a true plot.
    pub kinematic_probability: f64,
    /// Whether two refused plots in successive scans start the track's state anew.
    pub restart: bool,
}

/// Birth, coasting and death of tracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Life {
    /// Hits of `confirm_of` expected updates that confirm a track, its first plot included.
    pub confirm_hits: u32,
    /// See `confirm_hits`; at most 32.
    pub confirm_of: u32,
    /// The same for tracks whose plots carry an identity.
    pub identified_hits: u32,
    /// See `identified_hits`.
    pub identified_of: u32,
    /// A coast continues at constant velocity after this time, s.
    pub constant_velocity_after_s: f64,
    /// Spectral density of the acceleration in that coast, m²/s³.
    pub coast_q: f64,
    /// A moving track is deleted after this time without a plot, s.
    pub delete_moving_s: f64,
    /// A standing one, or one at a stand, after this time, s.
    pub delete_standing_s: f64,
    /// At least this many expected updates of its slowest sensor are waited for.
    pub delete_least_updates: f64,
    /// A track that lacks two looks is deleted when the 95 % radius of its position exceeds this and has doubled since its last plot, m.
    pub delete_radius_m: f64,
    /// How many track numbers there are, from 0 on without 4096 to 8191 (those of tracks that plots of outsiders begin). 4096 is what
    /// twelve bits hold, 28 672 what fifteen do, and the most.
    pub numbers: u32,
    /// A number is not given again for this long, s.
    pub number_rest_s: f64,
    /// Most tracks at a time, tentative ones included; further starts are refused and counted.
    pub most_tracks: usize,
    /// Existence as a probability in place of counted hits and fixed times.
    pub existence: Option<ExistenceRules>,
}

/// Lives by the probability that there is a target at all (`life = "existence"`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExistenceRules {
    /// A track on trial is confirmed from here on.
    pub confirm: f64,
    /// Below, a track on trial is dropped.
    pub drop: f64,
    /// Below, a confirmed track ends.
    pub end: f64,
    /// New targets anywhere, 1/m² and look.
    pub births_m2: f64,
    /// So many times more at stands of the flight list and on final.
    pub at_entrances: f64,
    /// How near to a stand that is, m.
    pub entrance_radius_m: f64,
    /// A target stays on the field for this long on average, s.
    pub survival_s: f64,
    /// One that leaves it is seen for this long, s.
    pub leaving_s: f64,
}

impl Default for ExistenceRules {
    /// Assumed; what confirmation and end are worth is measured by `studies::life`.
    fn default() -> Self {
        Self {
            confirm: 0.999,
            drop: 1e-4,
            end: 1e-3,
            births_m2: 5e-10,
            at_entrances: 100.0,
            entrance_radius_m: 40.0,
            survival_s: 600.0,
            leaving_s: 20.0,
        }
    }
}

/// Where labels of the flight list come from without an identity in the plots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelRules {
    /// What is this near to a stand stands there, m.
    pub stand_radius_m: f64,
    /// Standard deviation of the times of the flight list, s; what named targets show of it is learnt.
    pub list_sigma_s: f64,
    /// What lands or takes off is no farther from the extended centreline than this, m.
    pub arrival_lateral_m: f64,
    /// How far out on final, m.
    pub final_length_m: f64,
}

/// A kind of mover and what it can do (kinematic gate).
#[derive(Clone, Debug, PartialEq)]
pub struct MoverClass {
    /// Name ("medium_jet").
    pub name: String,
    /// Type designators of the flight list that belong here.
    pub designators: Vec<String>,
    /// Wake categories that belong here where the designator is nowhere listed.
    pub wakes: Vec<WakeCategory>,
    /// Limits of its motion.
    pub limits: ClassLimits,
}

/// Size of a type of the flight list.
#[derive(Clone, Debug, PartialEq)]
pub struct TypeSize {
    /// Type designator.
    pub designator: String,
    /// Length over all, m.
    pub length_m: f64,
    /// Span, or width of a vehicle, m.
    pub span_m: f64,
}

/// What the tracker assumes of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// Which sensor.
    pub id: SensorId,
    /// Its kind.
    pub kind: SensorKind,
    /// Interval between two looks at one target, s.
    pub interval_s: f64,
    /// The same at one that stands, s, where that is longer: transponders report more seldom then.
    pub standing_interval_s: f64,
    /// Probability of a plot at a look.
    pub detection: f64,
    /// Density of false plots and new targets, 1/m² and look.
    pub false_density_m2: f64,
    /// White error beyond what the plot states (glint of an extended target), standard deviation, m.
    pub extra_sigma_m: f64,
    /// Share of the plot's variance that varies slowly instead of from plot to plot, 0 to 1 (not of a radar: see
    /// [`super::near_side`]).
    pub slow_share: f64,
    /// Correlation time of that share, s.
    pub slow_tau_s: f64,
    /// Nominal delay between measuring and the plot's stamp, taken off, s.
    pub latency_s: f64,
    /// Standard deviation of a target's own delay off the nominal one, s.
    pub late_sigma_s: f64,
    /// Of a sensor that states how strong its echoes are: where these begin, and how strong noise is.
    pub strength: Option<AmplitudeLaw>,
}

impl SensorModel {
    /// What is assumed of a sensor of this kind if nobody says more.
    #[must_use]
    pub fn default_of(id: SensorId, kind: SensorKind) -> Self {
        let assumed = kind.assumed;
        Self {
            id,
            kind,
            interval_s: 1.0,
            standing_interval_s: 0.0,
            detection: assumed.detection,
            false_density_m2: assumed.false_density_m2,
            extra_sigma_m: assumed.extra_sigma_m,
            slow_share: assumed.slow_share,
            slow_tau_s: assumed.slow_tau_s,
            latency_s: 0.0,
            late_sigma_s: 0.0,
            strength: None,
        }
    }
}

/// Everything that the tracker is told before the run.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackingConfig {
    /// The filter of every track.
    pub filter: FilterConfig,
    /// Gates.
    pub gates: Gates,
    /// Association.
    pub association: AssociationMethod,
    /// Life of tracks.
    pub life: Life,
    /// Labels.
    pub labels: LabelRules,
    /// Kinds of movers. The last one stands for everything that no other one claims.
    pub classes: Vec<MoverClass>,
    /// Sizes of the types in the flight list; an aircraft that is not listed is taken as 35 by 35 m.
    pub sizes: Vec<TypeSize>,
    /// Sensors; one that is not listed is taken as [`SensorModel::default_of`] its kind.
    pub sensors: Vec<SensorModel>,
    /// Late plots are taken in their order back to this many seconds before the scan's end.
    pub ring_s: f64,
    /// Whether slow errors of sensors are respected ([`super::consider`]) or taken for white. A track that
    /// such a sensor updates leaves the configured filter for a six-state one.
    pub consider_slow_errors: bool,
    /// Whether constant errors of radar sites (and what is known of echoes) are estimated from targets that report their
    /// position, and taken off.
    pub register_sites: bool,
    /// The same from targets that taxi along these lanes, where they were surveyed (to half a metre): a lane that is not where the map
    /// has it is taken for an error of the site. Not beside `register_sites = false`.
    pub lanes: Option<Arc<Network>>,
    /// Whether the near side of echoes is taken off, and what is left of it respected ([`super::near_side`]).
    pub register_echo: bool,
    /// Whether the strength of an echo says whether it has a target ([`crate::association::amplitude`]): in joint association, and
    /// where lives go by existence.
    pub amplitude: bool,
    /// What is assumed of echoes.
    pub echo: EchoLaw,
    /// Whether each track is published as it was one scan ago too, by the plots that came since.
    pub second_ago: bool,
    /// What a scan may cost, ms, by a table of evaluations (never by a clock): association and filters fall to cheaper
    /// forms, which are counted, before it is used up.
    pub scan_budget_ms: f64,
    /// Two tracks that stay this near and move alike are one target, m (beside the body of a labelled one).
    pub duplicate_radius_m: f64,
}

impl TrackingConfig {
    /// The paper's chain: three-state Kalman filter per axis, two gates, nearest neighbour.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            filter: FilterConfig::new(Rung::Ca3),
            gates: Gates {
                probability: 0.999,
                identified_probability: 0.9999,
                kinematic: true,
                kinematic_probability: 0.99,
                restart: true,
            },
            association: AssociationMethod::Nearest,
            life: Life {
                confirm_hits: 3,
                confirm_of: 4,
                identified_hits: 2,
                identified_of: 2,
                constant_velocity_after_s: 2.0,
                coast_q: 1.0,
                delete_moving_s: 8.0,
                delete_standing_s: 15.0,
                delete_least_updates: 3.0,
                delete_radius_m: 60.0,
                numbers: 4096,
                number_rest_s: 60.0,
                most_tracks: 100_000,
                existence: None,
            },
            labels: LabelRules {
                stand_radius_m: 40.0,
                list_sigma_s: 120.0,
                arrival_lateral_m: 60.0,
                final_length_m: 20_000.0,
            },
            classes: default_classes(),
            sizes: Vec::new(),
            sensors: Vec::new(),
            ring_s: 5.0,
            consider_slow_errors: false,
            register_sites: false,
            lanes: None,
            register_echo: false,
            amplitude: false,
            echo: EchoLaw::default(),
            second_ago: true,
            scan_budget_ms: 100.0,
            duplicate_radius_m: 12.0,
        }
    }

    /// Smallest published error on recorded traffic: three modes mixed, slow errors of receivers and echoes as states, joint
    /// probabilistic association in clusters. (More histories win on point targets that move as drawn, not here.)
    #[must_use]
    pub fn accurate() -> Self {
        let mut config = Self::paper();
        config.filter = FilterConfig::new(Rung::Imm3);
        config.association = AssociationMethod::Joint { limit: 100_000 };
        config.consider_slow_errors = true;
        config.register_sites = true;
        config.register_echo = true;
        config
    }

    /// Most targets: constant velocity per axis (two states in place of three), nearest neighbour, a short ring, and more
    /// track numbers than twelve bits hold.
    #[must_use]
    pub fn bulk() -> Self {
        let mut config = Self::paper();
        config.filter = FilterConfig { rolling: true, q: 1.0, ..FilterConfig::new(Rung::Ca3) };
        config.ring_s = 1.5;
        config.second_ago = false;
        config.life.numbers = 28_672;
        config
    }

    /// Limits of the class of a line of the flight list, or of anything.
    #[must_use]
    pub(super) fn limits_of(&self, entry: Option<&FlightEntry>) -> ClassLimits {
        let claimed = entry.and_then(|entry| {
            let named = |c: &&MoverClass| c.designators.contains(&entry.type_designator);
            let wake = |c: &&MoverClass| entry.wake.is_some_and(|w| c.wakes.contains(&w));
            self.classes.iter().find(named).or_else(|| self.classes.iter().find(wake))
        });
        claimed.or(self.classes.last()).map_or(ANYTHING, |c| c.limits)
    }

    /// Length and span of a line of the flight list, m.
    #[must_use]
    pub(super) fn size_of(&self, entry: &FlightEntry) -> (f64, f64) {
        let listed = self.sizes.iter().find(|s| s.designator == entry.type_designator);
        match (listed, entry.movement) {
            (Some(size), _) => (size.length_m, size.span_m),
            (None, MovementKind::Vehicle) => (6.0, 2.5),
            (None, _) => (35.0, 35.0),
        }
    }

    /// The law of echoes in force.
    #[must_use]
    pub(super) fn echo_law(&self) -> EchoLaw {
        if self.register_echo { self.echo } else { EchoLaw::POINT }
    }

    /// ln of how much likelier the plot is of a target than of noise, by its strength; 0 where that is not asked for or not known.
    #[must_use]
    pub(super) fn log_strength(&self, plot: &Plot, model: &SensorModel) -> f64 {
        match (model.strength, plot.scnr_db) {
            (Some(law), Some(db)) if self.amplitude => law.log_ratio(libm::pow(10.0, 0.1 * db)),
            _ => 0.0,
        }
    }

    /// The model of a sensor.
    #[must_use]
    pub(super) fn sensor(&self, id: SensorId, kind: SensorKind) -> SensorModel {
        let listed = self.sensors.iter().find(|s| s.id == id);
        listed.copied().unwrap_or_else(|| SensorModel::default_of(id, kind))
    }
}

/// A number of the configuration that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value} is outside {low} to {high}: give a finite number within these limits")]
pub struct UnsoundNumber {
    /// Which number, with its sensor.
    pub name: String,
    /// What was given.
    pub value: f64,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
}

impl SensorModel {
    /// Part of its error stays from plot to plot.
    pub(super) fn errs_slowly(&self) -> bool {
        self.slow_share > 0.0 || self.late_sigma_s > 0.0
    }

    /// Its numbers with their names and limits.
    fn numbers(&mut self) -> [(&'static str, &mut f64, [f64; 2]); 9] {
        [
            ("interval_s", &mut self.interval_s, [1e-3, 1e6]),
            ("standing_interval_s", &mut self.standing_interval_s, [0.0, 1e6]),
            ("detection", &mut self.detection, [0.0, 1.0]),
            ("false_density_m2", &mut self.false_density_m2, [0.0, 1e3]),
            ("extra_sigma_m", &mut self.extra_sigma_m, [0.0, 1e4]),
            ("slow_share", &mut self.slow_share, [0.0, 1.0]),
            ("slow_tau_s", &mut self.slow_tau_s, [1e-6, 1e9]),
            ("latency_s", &mut self.latency_s, [0.0, 60.0]),
            ("late_sigma_s", &mut self.late_sigma_s, [0.0, 60.0]),
        ]
    }

    /// The same with the default of its kind in place of every number that cannot be used.
    #[must_use]
    pub(super) fn sound(mut self) -> Self {
        let mut defaults = Self::default_of(self.id, self.kind);
        let spare = defaults.numbers().map(|(_, value, _)| *value);
        for ((_, value, [low, high]), spare) in self.numbers().into_iter().zip(spare) {
            if !(*value >= low && *value <= high) {
                *value = spare;
            }
        }
        self
    }
}

impl TrackingConfig {
    /// Whether every number of the sensors can be used.
    ///
    /// # Errors
    /// The first one that cannot. A tracker that is made all the same uses the default of the sensor's kind for it.
    pub fn check(&self) -> Result<(), UnsoundNumber> {
        for sensor in &self.sensors {
            let mut sensor = *sensor;
            let id = sensor.id.0;
            for (name, value, [low, high]) in sensor.numbers() {
                let value = *value;
                if !(value >= low && value <= high) {
                    let name = format!("sensor {id}: {name}");
                    return Err(UnsoundNumber { name, value, low, high });
                }
            }
        }
        Ok(())
    }
}

/// Limits of a target of which nothing is known (assumed).
const ANYTHING: ClassLimits = ClassLimits {
    acceleration_ms2: 4.0,
    braking_ms2: 8.0,
    lateral_ms2: 5.0,
    turn_rate_rads: 1.0,
    turn_radius_m: 5.0,
    speed_mps: 100.0,
};

/// Assumed classes of movers; a scene may replace them. The last one is for targets without a label.
#[must_use]
pub fn default_classes() -> Vec<MoverClass> {
    use WakeCategory::{Heavy, Light, Medium, Super};
    // Acceleration, braking, lateral m/s², turn rate rad/s, turn radius m, speed m/s.
    type ClassRow = (&'static str, &'static [&'static str], &'static [WakeCategory], [f64; 6]);
    let rows: [ClassRow; 8] = [
        ("heavy_jet", &[], &[Heavy, Super], [2.5, 4.0, 2.0, 0.25, 25.0, 100.0]),
        ("medium_jet", &[], &[Medium], [3.0, 4.5, 2.5, 0.35, 15.0, 95.0]),
        ("light", &[], &[Light], [3.5, 4.5, 3.0, 0.60, 8.0, 70.0]),
        ("helicopter", &["EC35", "H145", "A109"], &[], [4.0, 4.0, 4.0, 1.00, 0.5, 80.0]),
        ("tug_towing", &["TUG"], &[], [0.7, 1.5, 1.0, 0.25, 10.0, 9.0]),
        ("car_follow_me", &["FOLLOWME", "CAR"], &[], [4.0, 8.0, 5.0, 0.80, 5.5, 40.0]),
        ("fire_truck", &["FIRE"], &[], [3.0, 6.0, 4.0, 0.60, 9.0, 36.0]),
        ("unknown", &[], &[], [4.0, 8.0, 5.0, 1.00, 5.0, 100.0]),
    ];
    rows.into_iter()
        .map(|(name, designators, wakes, l)| MoverClass {
            name: name.to_owned(),
            designators: designators.iter().map(ToString::to_string).collect(),
            wakes: wakes.to_vec(),
            limits: ClassLimits {
                acceleration_ms2: l[0],
                braking_ms2: l[1],
                lateral_ms2: l[2],
                turn_rate_rads: l[3],
                turn_radius_m: l[4],
                speed_mps: l[5],
            },
        })
        .collect()
}
