//! Which plots each track could have: the covariance gate and the first look of the kinematic one, within bounds.
//!
//! Where plots lie thinly, every plot in a track's search box is gated exactly. Where more than [`KEPT`] lie in one
//! box, they are compared by distances interpolated between the ends of the batch, at most [`LOOKED_AT`] of them, and
//! the best [`KEPT`] are gated exactly. So a scan of n tracks and m plots looks at no more than `O(n + m)` pairs,
//! wherever they lie; what was left out is counted, and what is left over is paired by rank (`pair_by_rank` of [`super::assigned`]).

use crate::association::grid::every;
use crate::association::nearest::Pair;
use crate::filter::{Measurement, Nis, Sym2, nis_at};
use crate::frames::{Point2, Vector2};
use crate::fusion::buffers::{Crowd, Look, Reachable};
use crate::fusion::config::SensorModel;
use crate::fusion::filter::{TrackFilter, place_at, position_at};
use crate::fusion::state::{Tracker, Work};
use crate::fusion::track_file::{Stage, Track};
use crate::plot::Plot;
use crate::time::SimTime;
use std::ops::Range;

/// Plots of one track that are gated exactly.
pub(in crate::fusion) const KEPT: usize = 8;

/// Plots of one search box that are compared at all.
const LOOKED_AT: usize = 64;

/// Places of the grid that are gone through for one track.
const PLACES: usize = 512;

/// Where a track may be at any time of a batch.
pub(in crate::fusion) struct Box2 {
    low: Point2<f64>,
    high: Point2<f64>,
    /// Predicted position at the begin and the end of the batch; of a track of one plot, that plot's.
    pub(in crate::fusion) ends: [Point2<f64>; 2],
    /// Covariance at the end.
    cov: Sym2,
    /// A track of one plot: how fast it may be, m/s.
    young: Option<f64>,
}

impl Tracker {
    /// All pairs of tracks of `stage` and free plots inside the covariance gate, by track and plot.
    pub(in crate::fusion) fn gated_pairs(&self, from: usize, stage: Stage, work: &mut Work) {
        let Work { candidates, used, gated, held, pairs, track_used, span, .. } = work;
        let Work { crowd, budget, .. } = work;
        let first_stage = stage == Stage::Confirmed;
        let indices = if first_stage { &work.confirmed } else { &work.tentative };
        let (grid, looks, widest) = (&work.plots, &work.looks, work.widest_m2);
        // A merged state has a sixth of the histories.
        let cost = if work.light { budget.gate().div_ceil(6) } else { budget.gate() };
        pairs.clear();
        crowd.begin(looks.len());
        for &index in indices {
            if track_used[index as usize] {
                continue;
            }
            let track = &self.tracks[index as usize];
            let Some(search) = self.search_box(track, *span, widest) else { continue };
            let own = pairs.len();
            // What the covariance gate asks before it is asked.
            let fits = |look: &Look| {
                let (p, k) = (look.position_m, look.k as usize);
                let Box2 { low, high, .. } = search;
                let inside = p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
                if !inside || used[k] {
                    return None;
                }
                let plot = &candidates[k].plot;
                let m = look.measured?;
                let own = || plot.identity.is_some_and(|name| track.is(name));
                if look.named && (!track.may_be(plot.identity) || (held[k] && !own())) {
                    return None;
                }
                if let Some(reach) = search.young {
                    let dt_s = look.time.since_s(track.time()).abs();
                    if !((p - search.ends[0]).norm() <= reach * dt_s + 3.0 * trace(plot).sqrt()) {
                        return None;
                    }
                }
                Some((plot, m))
            };
            let gate = |look: &Look, plot: &Plot, m: &Measurement| {
                let nis = self.distance(track, look.time, plot, m)?;
                let plot = (look.k as usize - from) as u32;
                let inside = search.young.is_some() || nis.d2 <= self.gate_1;
                inside.then_some(Pair { track: index, plot, nis })
            };
            let mut keep = |gated: &mut [bool], pair: Option<Pair>| {
                let Some(pair) = pair else { return };
                gated[from + pair.plot as usize] |= first_stage;
                pairs.push(pair);
            };
            let mut asked = 0;
            if grid.at_most(search.low, search.high) <= LOOKED_AT {
                grid.runs(search.low, search.high, |run| {
                    for look in &looks[run] {
                        let Some((plot, m)) = fits(look) else { continue };
                        asked += 1;
                        keep(gated, gate(look, plot, &m));
                    }
                });
            } else {
                let Crowd { runs, near, ranked, .. } = crowd;
                let mut cut = grid.runs_near(search.low, search.high, PLACES, runs);
                let places: usize = runs.iter().map(Range::len).sum();
                let stride = places.div_ceil(PLACES).max(1);
                let mut unseen = stride > 1;
                cut |= unseen;
                near.clear();
                for place in every(runs, stride, index as usize % stride) {
                    if fits(&looks[place]).is_some() {
                        near.push(place as u32);
                    }
                }
                budget.spend((places / stride) as u64 / 8);
                if near.len() > KEPT {
                    cut = true;
                    let stride = near.len().div_ceil(LOOKED_AT);
                    unseen |= stride > 1;
                    let turned = index as usize % stride;
                    ranked.clear();
                    for (rank, &place) in near.iter().skip(turned).step_by(stride).enumerate() {
                        let look = &looks[place as usize];
                        let Some(nis) = search.about(look, *span) else { continue };
                        // Of those that are alike each track begins with another one.
                        let turn = (rank + index as usize) % LOOKED_AT;
                        ranked.push((nis.d2.max(0.0).to_bits(), turn as u32, place));
                    }
                    budget.spend(ranked.len() as u64);
                    ranked.sort_unstable();
                    // What the gate would hold is nobody's birth, kept or not.
                    let gate_bits = self.gate_1.to_bits();
                    for &(d2, _, place) in &*ranked {
                        gated[looks[place as usize].k as usize] |= first_stage && d2 <= gate_bits;
                    }
                    near.clear();
                    near.extend(ranked.iter().take(KEPT).map(|r| r.2));
                }
                for &place in &*near {
                    let look = &looks[place as usize];
                    let Some((plot, m)) = fits(look) else { continue };
                    // Where all is made cheaper, what was compared by is good enough.
                    if work.light && cut && search.young.is_none() {
                        let nis = search.about(look, *span).filter(|nis| nis.d2 <= self.gate_1);
                        let plot = (look.k as usize - from) as u32;
                        keep(gated, nis.map(|nis| Pair { track: index, plot, nis }));
                        continue;
                    }
                    asked += 1;
                    keep(gated, gate(look, plot, &m));
                }
                if cut {
                    crowd.note(index, unseen);
                }
            }
            budget.spend(cost * (asked + 2));
            if pairs.len() > own + 1 {
                pairs[own..].sort_unstable_by_key(|p| p.plot);
            }
        }
        crowd.end();
        if first_stage {
            for &place in &crowd.covered {
                gated[looks[place as usize].k as usize] = true;
            }
        }
    }

    /// Where `track` may be at any time of a batch; nothing if it cannot be said.
    pub(in crate::fusion) fn search_box(
        &self,
        track: &Track,
        span: (SimTime, SimTime),
        widest_m2: f64,
    ) -> Option<Box2> {
        let (begin, end) = span;
        if track.plots == 1 {
            // As far as its class can go since its only plot.
            let margin = 3.0 * (2.0 * widest_m2).sqrt();
            let first = track.filter().motion().0;
            let dt_s = end.since_s(track.time()).max(0.0);
            let reach = track.limits.speed_mps;
            let around = Vector2::repeat(reach * dt_s + margin);
            return Some(Box2 {
                low: first - around,
                high: first + around,
                ends: [first; 2],
                cov: Sym2::default(),
                young: Some(reach),
            });
        }
        let base = track
            .way
            .filter_before(begin, &self.ring)
            .or_else(|| track.way.filter_before(end, &self.ring))?;
        let gaps = track.way.gaps(&self.config);
        let (last, s) = position_at(base, end, gaps).ok()?;
        let first = place_at(base, begin.max(base.time()), gaps).unwrap_or(last);
        let half = Vector2::new(
            (self.gate_1 * (s.xx + widest_m2)).sqrt(),
            (self.gate_1 * (s.yy + widest_m2)).sqrt(),
        );
        Some(Box2 {
            low: first.inf(&last) - half,
            high: first.sup(&last) + half,
            ends: [first, last],
            cov: s,
            young: None,
        })
    }

    /// All pairs of confirmed tracks without a plot and free plots that the fastest target of the track's class
    /// could have reached.
    pub(in crate::fusion) fn reachable_pairs(&self, model: &SensorModel, work: &mut Work) {
        let Work { candidates, used, gated, confirmed, track_used, span, reaches, .. } = work;
        let Work { crowd, budget, .. } = work;
        let (plots, looks) = (&work.plots, &work.looks);
        let limit = self.kinematic_gate;
        reaches.clear();
        for &index in &*confirmed {
            let track = &self.tracks[index as usize];
            if track_used[index as usize] || (track.updated && !self.config.gates.kinematic) {
                continue;
            }
            let now = Departed::of(track.filter());
            let way = span.1.since_s(now.time).max(0.0) + model.interval_s.min(1.0);
            let radius = track.limits.speed_mps * way + REACH_MARGIN_M;
            let around = Vector2::repeat(radius);
            let own = reaches.len();
            let mut look_at = |run: Range<usize>| {
                for look in &looks[run] {
                    let offset = look.position_m - now.position_m;
                    if offset.x.abs() > radius || offset.y.abs() > radius {
                        continue;
                    }
                    let k = look.k as usize;
                    let plot = &candidates[k].plot;
                    // A plot with the track's own name that the covariance gate refused is a manoeuvre, or says that
                    // the track is wrong: it is kept from all other tracks only.
                    let own = || look.named && plot.identity.is_some_and(|name| track.is(name));
                    if used[k] || (gated[k] && !own()) {
                        continue;
                    }
                    // Nobody else's name may be put on a track that has none by a manoeuvre.
                    if look.named
                        && (!track.may_be(plot.identity)
                            || (track.callsign.is_none() && track.address.is_none()))
                    {
                        continue;
                    }
                    let from = if now.time <= look.time {
                        now
                    } else {
                        match track.way.filter_before(look.time, &self.ring) {
                            Some(filter) => Departed::of(filter),
                            None => continue,
                        }
                    };
                    let dt_s = look.time.since_s(from.time);
                    let distance = (look.position_m - from.position_m).norm();
                    let uncertainty = 3.0 * (trace(plot) + from.pp).sqrt();
                    if distance <= track.limits.speed_mps * dt_s + uncertainty {
                        let hopeless = from.surely_out_of_reach(
                            distance,
                            track.limits.acceleration_ms2,
                            dt_s,
                            plot.along_m2 + plot.across_m2,
                            limit,
                        );
                        let distance_m = distance;
                        reaches.push(Reachable { track: index, k: look.k, hopeless, distance_m });
                    }
                }
            };
            let (low, high) = (now.position_m - around, now.position_m + around);
            if plots.at_most(low, high) <= LOOKED_AT {
                plots.runs(low, high, look_at);
                continue;
            }
            plots.runs_near(low, high, PLACES, &mut crowd.runs);
            let mut left = PLACES;
            for run in &crowd.runs {
                let end = run.end.min(run.start + left);
                look_at(run.start..end);
                left -= end - run.start;
            }
            budget.spend((PLACES - left) as u64 / 4);
            if reaches.len() > own + KEPT {
                reaches[own..].sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
                reaches.truncate(own + KEPT);
            }
        }
    }
}

impl Box2 {
    /// Normalised distance of a plot, with the track between the two ends of the batch.
    pub(in crate::fusion) fn about(&self, look: &Look, span: (SimTime, SimTime)) -> Option<Nis> {
        let whole = span.1.since_s(span.0);
        let share = if whole > 0.0 { look.time.since_s(span.0) / whole } else { 1.0 };
        let at = self.ends[0] + (self.ends[1] - self.ends[0]) * share;
        let nis = nis_at(at, self.cov, &look.measured?).ok()?;
        (nis.d2.is_finite() && nis.det > 0.0 && nis.det < f64::INFINITY).then_some(nis)
    }
}

/// Lays those of the plots `candidates[from..to]` that no track has out by place, with what gates ask of them in the
/// order of the grid's cells.
pub(in crate::fusion) fn lay_out(from: usize, to: usize, work: &mut Work) {
    let Work { candidates, used, free, positions, plots, looks, widest_m2, .. } = work;
    free.clear();
    free.extend((from..to).filter(|&k| !used[k]).map(|k| k as u32));
    positions.clear();
    positions.extend(free.iter().map(|&k| candidates[k as usize].plot.position_m));
    plots.fill(positions, GRID_CELL_M);
    looks.clear();
    looks.extend(plots.order().iter().map(|&place| {
        let k = free[place as usize];
        let plot = &candidates[k as usize].plot;
        Look {
            time: plot.time,
            measured: Measurement::of(plot).ok(),
            position_m: plot.position_m,
            k,
            named: plot.identity.is_some(),
        }
    }));
    let variances = free.iter().map(|&k| search_variance(&candidates[k as usize].plot));
    *widest_m2 = variances.fold(0.0, f64::max);
}

/// A target at its last update, as much as a first look needs.
#[derive(Clone, Copy, Debug)]
struct Departed {
    time: SimTime,
    position_m: Point2<f64>,
    speed_mps: f64,
    /// Traces of the covariances of position, position with velocity, and velocity.
    pp: f64,
    pv: f64,
    vv: f64,
}

impl Departed {
    #[inline]
    pub(in crate::fusion) fn of(filter: &TrackFilter) -> Self {
        let state = filter.estimate().state;
        let [vx, vy] = state.x[1].array();
        let [pp, pv, vv] = [0, 1, 3].map(|k| state.p[k].east() + state.p[k].north());
        Self {
            time: filter.time(),
            position_m: state.position(),
            speed_mps: (vx * vx + vy * vy).sqrt(),
            pp,
            pv,
            vv,
        }
    }

    /// Whether no reachable set can touch a plot that is `distance` away, trace of its covariance `r`: even
    /// straight on at full acceleration the way is too short by more than the gate times the trace of all that is
    /// uncertain.
    #[inline]
    pub(in crate::fusion) fn surely_out_of_reach(
        &self,
        distance: f64,
        acceleration: f64,
        dt_s: f64,
        r: f64,
        limit: f64,
    ) -> bool {
        let way = (self.speed_mps + 0.5 * acceleration.max(0.0) * dt_s) * dt_s;
        let gap = distance - way * (1.0 + 1e-9);
        let spread = self.pp + dt_s * (2.0 * self.pv + dt_s * self.vv) + r;
        gap > 0.0 && gap * gap > limit * spread * (1.0 + 1e-9)
    }
}

/// Cell of the search grid, m: about a search box of a taxiing target.
const GRID_CELL_M: f64 = 25.0;

/// Added to the search circle of the kinematic gate, m; the exact test follows.
pub(in crate::fusion) const REACH_MARGIN_M: f64 = 50.0;

impl Tracker {
    /// Distance of a plot (measuring `m`) from a track predicted to the plot's own time.
    #[inline]
    pub(in crate::fusion) fn distance(
        &self,
        track: &Track,
        time: SimTime,
        plot: &Plot,
        m: &Measurement,
    ) -> Option<Nis> {
        let config = &self.config;
        let filter = track.way.filter_before(time, &self.ring)?;
        let gaps = track.way.gaps(config);
        let soon = time.since_s(filter.time()) <= gaps.after_s;
        let time = filter.time().plus_s(self.reckoned_s(track, time.since_s(filter.time())));
        let known = plot.polar.is_some().then(|| track.as_known(plot, &self.registration));
        let nis = match filter.considered(known.as_ref().unwrap_or(plot), config) {
            Some(found) if soon => found.ok()?,
            _ => {
                let (at, cov) = position_at(filter, time, gaps).ok()?;
                let m = known.map_or(Ok(*m), |plot| Measurement::of(&plot)).ok()?;
                nis_at(at, cov, &m).ok()?
            }
        };
        (nis.d2.is_finite() && nis.det > 0.0 && nis.det < f64::INFINITY).then_some(nis)
    }
}

impl Tracker {
    /// For how long a track that was last seen so long before `plot` is reckoned to have moved, s. One that stood then is
    /// looked for there: as if a look or two had passed.
    pub(in crate::fusion) fn reckoned_s(&self, track: &Track, dt_s: f64) -> f64 {
        let longest_s = track.way.gaps(&self.config).after_s;
        if track.rest.place_m().is_some() { dt_s.min(longest_s) } else { dt_s }
    }
}

/// `tr R`, m²; a direction that is not measured counts 10 m.
pub(in crate::fusion) fn trace(plot: &Plot) -> f64 {
    plot.along_m2.min(100.0) + plot.across_m2.min(100.0)
}

/// Largest variance of the plot for the search box; a direction that is not measured counts 20 m.
fn search_variance(plot: &Plot) -> f64 {
    let bounded = |v: f64| if v.is_finite() { v } else { 400.0 };
    bounded(plot.along_m2).max(bounded(plot.across_m2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::association::kinematic_gate::{ClassLimits, Departure, reach};
    use crate::frames::Matrix2;
    use nalgebra::Matrix4;

    /// What the first look leaves out the kinematic gate refuses too, up to the very limit straight ahead; and it does leave
    /// out what is well beyond.
    #[test]
    fn what_is_surely_out_of_reach_is_refused_by_the_reachable_set() {
        let limits = ClassLimits {
            acceleration_ms2: 4.0,
            braking_ms2: 8.0,
            lateral_ms2: 5.0,
            turn_rate_rads: 1.0,
            turn_radius_m: 5.0,
            speed_mps: 100.0,
        };
        let (limit, mut hopeless, mut hoped) = (9.21, 0, 0);
        for case in 0..3_000_u32 {
            let of = |n: u32, m: u32| f64::from((case / n) % m);
            let (speed_mps, dt_s) = (2.0 + 4.0 * of(1, 11), 0.25 + 0.5 * of(11, 5));
            // All that is uncertain lies straight ahead.
            let (pp, pv, vv, r) = (1.0 + of(5, 4), 0.2, 0.1 + 0.3 * of(7, 3), 2.0 + of(3, 9));
            let from =
                Departed { time: SimTime(0), position_m: Point2::origin(), speed_mps, pp, pv, vv };
            let way = (speed_mps + 2.0 * dt_s) * dt_s;
            let spread = (limit * (pp + dt_s * (2.0 * pv + dt_s * vv) + r)).sqrt();
            for share in [0.5, 0.97, 0.999, 1.001, 1.03, 1.5] {
                let distance = way + share * spread;
                let out = from.surely_out_of_reach(distance, 4.0, dt_s, r, limit);
                let mut covariance = Matrix4::zeros();
                covariance[(0, 0)] = pp;
                (covariance[(0, 2)], covariance[(2, 0)]) = (pv, pv);
                covariance[(2, 2)] = vv;
                let target = Departure {
                    position_m: Point2::origin(),
                    velocity_mps: Vector2::new(speed_mps, 0.0),
                    covariance,
                };
                let ahead = Point2::new(distance, 0.0);
                let cov = Matrix2::new(r, 0.0, 0.0, 1e-3);
                let exact = reach(&limits, &target, dt_s, ahead, cov).expect("sound").m;
                assert!(!out || exact > limit, "{case} {share}: {exact}");
                assert!(out || share < 1.0, "{case} {share}: {exact}");
                if out { hopeless += 1 } else { hoped += 1 }
            }
        }
        assert!(hopeless > 5_000 && hoped > 5_000, "{hopeless} {hoped}");
    }
}
