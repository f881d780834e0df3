//! The off-line reference: where every target was, by all plots of a whole run, earlier and later ones.
//!
//! It is for recordings that have no truth, as what comes nearest to one; it knows nothing of ours.
//!
//! The tracker says which plots are of one target (`gathered`). Then every target has a smoother of its own over the whole run
//! (`linear`, `target`), with slow errors of its receivers and echoes as states, and all together say what their sensors have in
//! common (`shared`): errors of radar sites and clocks, and the law of echoes.

mod gathered;
mod linear;
mod shared;
mod target;
#[cfg(test)]
mod tests;

pub use shared::{Found, SiteFound};

use self::linear::{Forwards, MOTION, Smoothed};
use self::shared::{OF_ECHO, Shared};
use self::target::Target;
use super::config::{TrackingConfig, UnsoundNumber};
use super::state::Statistics;
use crate::flight_list::FlightList;
use crate::frames::{Matrix2, Point2, Vector2};
use crate::plot::{Callsign, Plot, SensorId};
use crate::time::SimTime;
use std::collections::BTreeMap;

/// Rounds in which what was learnt and where targets were is found in turn.
const ROUNDS: usize = 14;
/// From this round on what all targets share is learnt.
const SHARED_FROM: usize = 3;
/// From this round on targets may stand.
const STANDING_FROM: usize = 4;
/// A point that is less certain than this is left out, m.
const LEAST_CERTAIN_M: f64 = 60.0;

/// Where a target was at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// When.
    pub time: SimTime,
    /// Position, m east and north.
    pub position_m: Point2<f64>,
    /// Velocity, m/s east and north.
    pub velocity_mps: Vector2<f64>,
    /// Covariance of the position, m².
    pub position_cov_m2: Matrix2<f64>,
    /// Covariance of the velocity, m²/s².
    pub velocity_cov_m2s2: Matrix2<f64>,
    /// The target stands.
    pub stands: bool,
    /// Time to the nearest of its plots, s.
    pub plot_s: f64,
}

/// The way of one target.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// The tracks that it was made of: order of birth and number.
    pub tracks: Vec<(u64, u16)>,
    /// What the target was called last, by itself or by its label.
    pub callsign: Option<Callsign>,
    /// How many plots it rests on.
    pub plots: usize,
    /// At the end of each scan from the first plot to the last.
    pub points: Vec<Point>,
}

/// Everything that a run says of its targets and sensors.
#[derive(Clone, Debug)]
pub struct ReferenceRun {
    /// In the order in which the targets were first seen.
    pub trajectories: Vec<Trajectory>,
    /// Errors of the radars.
    pub sites: Vec<SiteFound>,
    /// κ_L of aircraft and of vehicles ([`super::near_side`]).
    pub kappa: [Found; 2],
    /// Ends of the scans.
    pub ends: Vec<SimTime>,
    /// Of each plot of each scan: the trajectory that it is part of.
    pub of_plots: Vec<Vec<Option<usize>>>,
    /// What the tracker counted that gave the plots to targets: `unsound` and `duplicates` were left out.
    pub statistics: Statistics,
}

/// Makes the reference of a run: each scan's end with its plots.
///
/// # Errors
/// A number of the configuration cannot be used.
pub fn reference(
    config: &TrackingConfig,
    flights: &FlightList,
    scans: &[(SimTime, Vec<Plot>)],
) -> Result<ReferenceRun, UnsoundNumber> {
    config.check()?;
    let (gathered, statistics) = gathered::gather(config, flights, scans);
    let ends: Vec<SimTime> = scans.iter().map(|s| s.0).collect();
    let law = config.echo_law();
    let mut sites: Vec<SensorId> = Vec::new();
    for plot in gathered.iter().flat_map(|g| &g.plots).filter(|p| p.polar.is_some()) {
        if !sites.contains(&plot.sensor) {
            sites.push(plot.sensor);
        }
    }
    sites.sort();
    let of = |site: SensorId| {
        let plots = gathered.iter().flat_map(|g| &g.plots);
        (site, shared::meeting_m(plots.filter(|p| p.sensor == site && p.polar.is_some())))
    };
    let sites = sites.into_iter().map(of).collect();
    let mut shared = Shared::new(sites, &law);
    let mut targets: Vec<Target<'_>> =
        gathered.iter().map(|g| Target::new(g, config, law, asked(&g.plots, &ends))).collect();
    for round in 0..ROUNDS {
        if round >= SHARED_FROM && config.register_sites {
            learn_shared(&mut shared, &targets);
        }
        for target in &mut targets {
            if let Some(back) = target.smoothed(&shared) {
                target.learn(&back, round >= STANDING_FROM);
            }
        }
    }
    if config.register_sites {
        learn_shared(&mut shared, &targets);
    }
    let mut of_plots: Vec<Vec<Option<usize>>> =
        scans.iter().map(|(_, plots)| vec![None; plots.len()]).collect();
    let mut trajectories = Vec::with_capacity(targets.len());
    for target in &targets {
        let Some(found) = trajectory(target, &shared) else { continue };
        for (scan, place) in &target.gathered.places {
            of_plots[*scan][*place] = Some(trajectories.len());
        }
        trajectories.push(found);
    }
    let kappa = [0, 1].map(|k| shared.found(shared.count() - OF_ECHO + k));
    Ok(ReferenceRun { trajectories, sites: shared.sites(), kappa, ends, of_plots, statistics })
}

/// The scan ends from a target's first plot to the first one after its last.
fn asked<'a>(plots: &[Plot], ends: &'a [SimTime]) -> &'a [SimTime] {
    let (Some(first), Some(last)) = (plots.first(), plots.last()) else { return &[] };
    let from = ends.partition_point(|end| *end < first.time);
    let to = ends.partition_point(|end| *end < last.time);
    &ends[from..(to + 1).min(ends.len()).max(from)]
}

fn learn_shared(shared: &mut Shared, targets: &[Target<'_>]) {
    let n = shared.count();
    let (mut information, mut vector) = (vec![0.0; n * n], vec![0.0; n]);
    for target in targets.iter().filter(|t| !t.alone) {
        let moments = target.moments(shared, true);
        if let Some(forwards) = Forwards::of(&moments, target.start(), n) {
            forwards.tell(&mut information, &mut vector);
        }
    }
    shared.learn(&information, &vector);
}

fn trajectory(target: &Target<'_>, shared: &Shared) -> Option<Trajectory> {
    let moments = target.moments(shared, true);
    let back = Forwards::of(&moments, target.start(), shared.count())?.back();
    let plots = &target.gathered.plots;
    let mut points = Vec::new();
    for (k, ((time, asked), here)) in target.times().zip(&back).enumerate() {
        if !asked {
            continue;
        }
        let after = plots.partition_point(|p| p.time < time);
        let near = |index: usize| plots.get(index).map(|p| time.since_s(p.time).abs());
        let before = after.checked_sub(1).and_then(near);
        let plot_s = near(after).into_iter().chain(before).fold(f64::INFINITY, f64::min);
        let mut point = point(here, shared, time, target.stands(k), plot_s);
        point.position_cov_m2 += target.left_m2(k);
        let sigma = point.position_cov_m2.trace().sqrt();
        if sigma <= LEAST_CERTAIN_M {
            points.push(point);
        }
    }
    Some(Trajectory {
        tracks: target.gathered.tracks.clone(),
        callsign: target.gathered.callsign,
        plots: plots.len(),
        points,
    })
}

/// A state with what is applied of the shared parameters, and what that may be wrong by.
fn point(here: &Smoothed, shared: &Shared, time: SimTime, stands: bool, plot_s: f64) -> Point {
    let n = shared.count();
    let (mut x, mut p) = (here.state, here.covariance);
    for (k, by) in here.by_column.iter().enumerate() {
        (0..MOTION).for_each(|i| x[i] += by[i] * shared.applied(k));
    }
    for a in 0..n {
        for b in 0..n {
            let c = shared.applied_covariance(a, b);
            if c == 0.0 {
                continue;
            }
            for (i, line) in p.iter_mut().enumerate() {
                for (j, cell) in line.iter_mut().enumerate() {
                    *cell += here.by_column[a][i] * c * here.by_column[b][j];
                }
            }
        }
    }
    let part = |o: usize| {
        let cross = 0.5 * (p[o][2 + o] + p[2 + o][o]);
        Matrix2::new(p[o][o], cross, cross, p[2 + o][2 + o])
    };
    Point {
        time,
        position_m: Point2::new(x[0], x[2]),
        velocity_mps: Vector2::new(x[1], x[3]),
        position_cov_m2: part(0),
        velocity_cov_m2s2: part(1),
        stands,
        plot_s,
    }
}

impl ReferenceRun {
    /// Where each track (by order of birth) belongs: index of its trajectory.
    #[must_use]
    pub fn by_serial(&self) -> BTreeMap<u64, usize> {
        let of = |(k, t): (usize, &Trajectory)| -> Vec<(u64, usize)> {
            t.tracks.iter().map(|(serial, _)| (*serial, k)).collect()
        };
        self.trajectories.iter().enumerate().flat_map(of).collect()
    }
}

impl Trajectory {
    /// The point at a scan's end, if it has one there.
    #[must_use]
    pub fn at(&self, time: SimTime) -> Option<&Point> {
        self.points.binary_search_by_key(&time, |p| p.time).ok().map(|k| &self.points[k])
    }
}
