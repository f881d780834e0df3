//! Sensors of somebody else: their plots as they come in, on their way into the tracker.
//!
//! Live ones arrive as stamped reports of the member `visitors`; those of a recording are part of the scene. A plot waits for the
//! scan that it was measured in. Older than three scans, more than half a second ahead of its arrival, farther than 100 km, or
//! more than are kept: refused and counted.

use super::foreign_plot::{Height, Place, Reading, reading};
use crate::exchange::asterix_file;
use crate::exchange::stamp::StampedPlots;
use asterix::time::of_some_day_ns;
use asterix::{Record, blocks};
use geodesy::{Geodetic, LocalFrame};
use models::environment::Weather;
use models::frames::{Matrix2, Point2, Point3, Vector2};
use models::plot::{Plot, Polar, SensorId, SensorKind, principal_axes};
use models::sensors::{Cause, PlotSink, ScanInterval, Sensor, Truth};
use models::time::SimTime;
use scenarios::{ForeignScene, ForeignSource, Scene};
use std::collections::{BTreeMap, BTreeSet};

/// Plots of one live sensor that wait, or are remembered, at most.
const MOST: usize = 16_384;
/// Farther than this from the reference point nothing belongs to an airport, m.
const FARTHEST_M: f64 = 100_000.0;
/// No run lasts so long, ns: what is stamped beyond is nonsense.
const MOST_NS: i64 = 100_000 * 86_400 * 1_000_000_000;
/// Scans after which a plot is too old.
const OLDEST_SCANS: i64 = 3;
/// How far ahead of its arrival a measurement may be, ns.
const AHEAD_NS: i64 = 500_000_000;
/// No report is more exact than this, m: deviations travel in steps of 0.25 m and may say 0.
const LEAST_SIGMA_M: f64 = 0.15;
/// A day, ns.
const DAY_NS: i64 = 86_400_000_000_000;
/// A sensor that looks at nothing: its plots come from outside.
#[derive(Clone, Copy, Debug)]
pub struct Elsewhere {
    /// Its number.
    pub id: SensorId,
    /// What it is.
    pub kind: SensorKind,
}

impl Sensor for Elsewhere {
    fn id(&self) -> SensorId {
        self.id
    }

    fn kind(&self) -> SensorKind {
        self.kind
    }

    fn scan(&mut self, _: &ScanInterval, _: &dyn Truth, _: &Weather, _: &mut PlotSink) {}
}

/// The sensors of somebody else that a scene has.
#[derive(Clone, Debug, Default)]
pub struct Inlets {
    inlets: BTreeMap<SensorId, Inlet>,
    refused: BTreeMap<&'static str, u64>,
    taken: u64,
}

#[derive(Clone, Debug)]
struct Inlet {
    kind: SensorKind,
    scene: ForeignScene,
    site_m: Option<Point3<f64>>,
    frame: LocalFrame,
    elevation_m: f64,
    start_ns: i64,
    /// By how much its clock differs, ns, where that is taken from its first plot.
    shift_ns: Option<i64>,
    /// Plots that no scan has had, by time.
    waiting: BTreeMap<Name, Plot>,
    /// Names of those that one has had, as long as they could come again.
    had: BTreeSet<Name>,
    /// Number of the next plot, counted through: two plots of one time are two, however late the second comes.
    sequence: u32,
}

/// What makes a plot the same one: time and place, to the bit, and who.
type Name = (SimTime, u64, u64, Option<models::plot::Identity>);

fn name(plot: &Plot) -> Name {
    let place = plot.position_m;
    (plot.time, place.x.to_bits(), place.y.to_bits(), plot.identity)
}

impl Inlets {
    /// Those of a scene at the start of a run; recordings are read.
    ///
    /// # Errors
    /// If a recording cannot be read or has no plot of its sensor.
    pub fn of(scene: &Scene) -> Result<Self, String> {
        let mut inlets = Self::default();
        for sensor in &scene.sensors {
            let Some(foreign) = &sensor.foreign else { continue };
            let inlet = Inlet {
                kind: sensor.kind,
                scene: foreign.clone(),
                site_m: sensor.site_m,
                frame: scene.airport.frame,
                elevation_m: scene.airport.reference.height_m,
                start_ns: scene.run.start_utc_ns.rem_euclid(DAY_NS),
                shift_ns: None,
                waiting: BTreeMap::new(),
                had: BTreeSet::new(),
                sequence: 0,
            };
            inlets.inlets.insert(sensor.id, inlet);
            if let ForeignSource::Recording { path, octets } = &foreign.source {
                let wrong =
                    |e: String| format!("sensor '{}': {}: {e}", sensor.name, path.display());
                let read = asterix_file::of_octets(&octets.0, &path.display().to_string())
                    .map_err(|e| wrong(format!("{e:#}")))?;
                inlets.recorded(sensor.id, &read);
                if inlets.waiting(sensor.id) == 0 {
                    return Err(wrong(
                        "no plot of this sensor in it: look with `seeds asterix stat`".into(),
                    ));
                }
            }
        }
        Ok(inlets)
    }

    fn waiting(&self, id: SensorId) -> usize {
        self.inlets.get(&id).map_or(0, |inlet| inlet.waiting.len())
    }

    /// Whether there are any.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.inlets.is_empty()
    }

    /// Whether plots of this sensor came from outside in this run.
    #[must_use]
    pub fn is_live(&self, id: SensorId) -> bool {
        self.inlets.get(&id).is_some_and(|inlet| inlet.scene.is_live())
    }

    /// All of them.
    #[must_use]
    pub fn ids(&self) -> BTreeSet<SensorId> {
        self.inlets.keys().copied().collect()
    }

    /// All plots of a recording, by time.
    fn recorded(&mut self, id: SensorId, read: &asterix_file::Pieces) {
        let Some(inlet) = self.inlets.get_mut(&id) else { return };
        let mut latest_ns = inlet.start_ns;
        for piece in &read.pieces {
            let refused = &mut self.refused;
            each_record(&piece.octets, refused, |record, refused| {
                let inlet = &mut *inlet;
                let time_ns = |of_day_ns: i64, inlet: &mut Inlet| {
                    let day_ns = of_some_day_ns(of_day_ns, latest_ns);
                    latest_ns = latest_ns.max(day_ns);
                    let time_ns = day_ns - inlet.start_ns;
                    time_ns + inlet.shift(-time_ns)
                };
                inlet.take_unless(record, refused, usize::MAX, time_ns, |_| false);
            });
        }
    }

    /// Takes plots as they were let in; says whether one had an effect.
    pub fn take(&mut self, stamped: &StampedPlots, start_utc_ns: i64) -> bool {
        let Some(inlet) = self.inlets.get_mut(&SensorId(stamped.sensor)) else {
            return false;
        };
        if !inlet.scene.is_live() {
            return false;
        }
        let arrived_ns = stamped.arrival.time_ns.saturating_sub(start_utc_ns);
        let arrived_ns = arrived_ns.clamp(-MOST_NS, MOST_NS);
        let mut taken = 0;
        each_record(&stamped.octets, &mut self.refused, |record, refused| {
            let time_ns = |of_day_ns: i64, inlet: &mut Inlet| {
                // The day that is nearest to the arrival.
                let near_ns = inlet.start_ns + arrived_ns;
                let time_ns = of_some_day_ns(of_day_ns, near_ns) - inlet.start_ns;
                time_ns + inlet.shift(arrived_ns - time_ns)
            };
            let ahead = |time: SimTime| time.0 > arrived_ns + AHEAD_NS;
            taken += u64::from(inlet.take_unless(record, refused, MOST, time_ns, ahead));
        });
        taken > 0
    }

    /// Appends the plots of one sensor that are due in a scan.
    pub fn scan(&mut self, id: SensorId, interval: &ScanInterval, sink: &mut PlotSink) {
        let Some(inlet) = self.inlets.get_mut(&id) else { return };
        let scan_ns = interval.to.0 - interval.from.0;
        let oldest = SimTime(interval.to.0.saturating_sub(OLDEST_SCANS * scan_ns));
        while let Some((name, plot)) = inlet.waiting.pop_first() {
            if plot.time > interval.to {
                inlet.waiting.insert(name, plot);
                break;
            }
            if plot.time < oldest {
                *self.refused.entry("a plot older than three scans").or_default() += 1;
                continue;
            }
            sink.plots.push(Plot { sensor: id, sequence: inlet.sequence, ..plot });
            sink.causes.push(Cause::default());
            inlet.had.insert(name);
            inlet.sequence = inlet.sequence.wrapping_add(1);
            self.taken += 1;
        }
        while inlet.had.first().is_some_and(|(time, ..)| *time < oldest) {
            inlet.had.pop_first();
        }
    }

    /// Plots that went into the tracker.
    #[must_use]
    pub fn taken(&self) -> u64 {
        self.taken
    }

    /// What was refused, by reason.
    #[must_use]
    pub fn refused(&self) -> Vec<(String, u64)> {
        self.refused.iter().map(|(reason, count)| (format!("plots: {reason}"), *count)).collect()
    }
}

/// Every sound record of a datagram; damage ends it and is counted.
fn each_record(
    octets: &[u8],
    refused: &mut BTreeMap<&'static str, u64>,
    mut take: impl FnMut(&Record<'_>, &mut BTreeMap<&'static str, u64>),
) {
    for block in blocks(octets) {
        let damage = match block {
            Ok(block) => block.records().find_map(|record| match record {
                Ok(record) => {
                    take(&record, refused);
                    None
                }
                Err(e) => Some(e),
            }),
            Err(e) => Some(e),
        };
        if let Some(e) = damage {
            *refused.entry(e.fault.word()).or_default() += 1;
            return;
        }
    }
}

impl Inlet {
    /// What is added to its times, ns; decided by its first plot.
    fn shift(&mut self, of_first_ns: i64) -> i64 {
        match self.scene.first {
            true => *self.shift_ns.get_or_insert(of_first_ns),
            false => 0,
        }
    }

    fn take_unless(
        &mut self,
        record: &Record<'_>,
        refused: &mut BTreeMap<&'static str, u64>,
        most: usize,
        mut time_ns: impl FnMut(i64, &mut Self) -> i64,
        ahead: impl Fn(SimTime) -> bool,
    ) -> bool {
        let own = record.source().is_some_and(|s| self.scene.is_of(s, record.category.number));
        if !own {
            return false;
        }
        let taken = match reading(record) {
            Ok(None) => return false,
            Ok(Some(reading)) => self.placed(&reading).and_then(|plot| {
                let time = SimTime(time_ns(reading.of_day_ns, self));
                let plot = Plot { time, ..plot };
                let name = name(&plot);
                if ahead(time) {
                    return Err("a plot more than 0.5 s ahead of its arrival");
                }
                if self.waiting.contains_key(&name) || self.had.contains(&name) {
                    return Err("a plot that came twice");
                }
                if self.waiting.len() + self.had.len() >= most {
                    return Err("more plots than are kept");
                }
                self.waiting.insert(name, plot);
                Ok(())
            }),
            Err(reason) => Err(reason),
        };
        if let Err(reason) = taken {
            *refused.entry(reason).or_default() += 1;
        }
        taken.is_ok()
    }

    /// The plot of a reading, its time still open.
    fn placed(&self, reading: &Reading) -> Result<Plot, &'static str> {
        let altitude_m = match reading.height {
            Some(Height::Local(height_m)) => Some(height_m),
            Some(Height::Sea(height_m)) => Some(height_m - self.elevation_m),
            Some(Height::Pressure(_)) | None => None,
        };
        let site = || self.site_m.ok_or("a plot about the site of a sensor that has none");
        let position_m = match reading.place {
            Place::Degrees([lat, lon]) => {
                let height_m = self.frame.origin_geodetic().height_m;
                let there = self.frame.to_enu(Geodetic::from_degrees(lat, lon, height_m).to_ecef());
                Point2::new(there.east_m, there.north_m)
            }
            Place::Local([east_m, north_m]) => Point2::new(east_m, north_m),
            Place::FromSite([east_m, north_m]) => site()?.xy() + Vector2::new(east_m, north_m),
            Place::Polar => {
                let (site_m, [range_m, azimuth_rad]) = (site()?, reading.polar.unwrap_or_default());
                // Without a height the target is taken to be on the ground.
                let height_m = match reading.height {
                    Some(Height::Pressure(height_m)) => height_m - self.elevation_m,
                    _ => altitude_m.unwrap_or(0.0),
                };
                let up_m = height_m - site_m.z;
                let ground_m = (range_m * range_m - up_m * up_m).max(0.0).sqrt();
                let (sin, cos) = libm::sincos(azimuth_rad);
                site_m.xy() + Vector2::new(sin, cos) * ground_m
            }
        };
        if !(position_m.coords.norm() <= FARTHEST_M) {
            return Err("a position out of 100 km");
        }
        let white_m2 = self.scene.sigma_m * self.scene.sigma_m;
        let [ee_m2, en_m2, nn_m2] = reading.cov_m2.unwrap_or([white_m2, 0.0, white_m2]);
        // Deviations and covariance are rounded one by one: together they may say what no covariance can.
        let most_m2 = 0.999 * (ee_m2 * nn_m2).sqrt();
        let en_m2 = en_m2.clamp(-most_m2, most_m2);
        let covariance_m2 = Matrix2::new(ee_m2, en_m2, en_m2, nn_m2);
        let least_m2 = LEAST_SIGMA_M * LEAST_SIGMA_M;
        let sight = self.site_m.filter(|_| self.kind.radar).map(|site| position_m - site.xy());
        let (axis, along_m2, across_m2) = match sight.filter(|sight| sight.norm() > 1.0) {
            Some(sight) => {
                let axis = sight / sight.norm();
                let across = Vector2::new(axis.y, -axis.x);
                let of = |u: Vector2<f64>| u.dot(&(covariance_m2 * u));
                (axis, of(axis), of(across))
            }
            None => principal_axes(&covariance_m2),
        };
        let (along_m2, across_m2) = (along_m2.max(least_m2), across_m2.max(least_m2));
        let polar = reading.polar.filter(|[range_m, _]| sight.is_some() && *range_m > 1.0);
        Ok(Plot {
            sensor: SensorId(0),
            kind: self.kind,
            time: SimTime(0),
            sequence: 0,
            position_m,
            axis,
            along_m2,
            across_m2,
            altitude_m,
            polar: polar.map(|[range_m, azimuth_rad]| Polar {
                range_m,
                azimuth_rad: models::frames::wrap_pi(azimuth_rad),
                sigma_range_m: along_m2.sqrt(),
                sigma_azimuth_rad: across_m2.sqrt() / range_m,
                extent_m2: None,
            }),
            identity: reading.identity,
            scnr_db: reading.scnr_db,
        })
    }
}
