//! Association of one batch (plots of one sensor and one of its intervals) with the tracks.

use super::config::{AssociationMethod, SensorModel, TrackingConfig};
use super::filter::TrackFilter;
use super::life;
use super::registration::Reference;
use super::track_file::{Applied, Stage, Track, Update, predict};
use super::tracker::{Candidate, Outcome, Tracker, Work};
use crate::association::kinematic_gate;
use crate::association::nearest::{self, Pair};
use crate::association::{jpda::JpdaError, lbp};
use crate::frames::Vector2;
use crate::plot::{Identity, Plot};
use crate::time::SimTime;

impl Tracker {
    /// Gives the plots `candidates[from..to]` (one sensor, one interval) to tracks; starts new ones.
    pub(super) fn associate_batch(&mut self, from: usize, to: usize, work: &mut Work) {
        let first = work.candidates[from].plot;
        let model = self.config.sensor(first.sensor, first.kind);
        work.positions.clear();
        work.positions.extend(work.candidates[from..to].iter().map(|c| c.plot.position_m));
        work.grid.fill(&work.positions, GRID_CELL_M);
        let none = (SimTime(i64::MAX), SimTime(i64::MIN));
        work.span = work.candidates[from..to]
            .iter()
            .fold(none, |span, c| (span.0.min(c.plot.time), span.1.max(c.plot.time)));
        work.track_used.clear();
        work.track_used.resize(self.tracks.len(), false);
        self.take_identified(from, to, &model, work);
        self.take_gated(from, to, Stage::Confirmed, &model, work);
        if self.config.gates.kinematic {
            self.take_manoeuvres(from, to, &model, work);
        }
        self.note_refused(from, to, &model, work);
        self.take_gated(from, to, Stage::Tentative, &model, work);
        self.mark_other_echoes(from, to, work);
        self.start_tracks(from, to, &model, work);
    }

    /// Plots with an identity go first, to the track that has it.
    fn take_identified(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        if work.candidates[from..to].iter().all(|c| c.plot.identity.is_none()) {
            return;
        }
        work.names.clear();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != Stage::Ended {
                let callsign = track.callsign.map(Identity::Callsign);
                let address = track.address.map(Identity::Address);
                let names = callsign.into_iter().chain(address);
                work.names.extend(names.map(|name| (name, index as u32)));
            }
        }
        work.names.sort_unstable();
        for k in from..to {
            let plot = work.candidates[k].plot;
            let Some(identity) = plot.identity else { continue };
            let first = work.names.partition_point(|(name, _)| *name < identity);
            let Some(&(_, track)) = work.names.get(first).filter(|(name, _)| *name == identity)
            else {
                continue;
            };
            let track = track as usize;
            // Whoever holds the name: the plot starts no other track.
            work.candidates[k].gated = true;
            if work.track_used[track] {
                continue;
            }
            let gate = self.identified_gate;
            if self.distance(track, &plot).is_some_and(|pair| pair.d2 <= gate) {
                self.update(track, Update::Plot(plot), k, model, work);
            }
        }
    }

    /// Covariance gate and association of all tracks of one stage.
    fn take_gated(
        &mut self,
        from: usize,
        to: usize,
        stage: Stage,
        model: &SensorModel,
        work: &mut Work,
    ) {
        self.gated_pairs(from, to, stage, work);
        work.plot_used.clear();
        work.plot_used.resize(to - from, false);
        // Tracks on trial take what is nearest: they have no reliable density to weigh with.
        match self.config.association {
            _ if stage == Stage::Tentative => self.take_nearest(from, model, work),
            AssociationMethod::Nearest => self.take_nearest(from, model, work),
            AssociationMethod::Global => self.take_by_cluster(from, None, model, work),
            AssociationMethod::Joint { limit } => {
                self.take_by_cluster(from, Some(limit), model, work);
            }
        }
    }

    fn take_nearest(&mut self, from: usize, model: &SensorModel, work: &mut Work) {
        let mut pairs = std::mem::take(&mut work.pairs);
        let mut taken = std::mem::take(&mut work.scratch);
        taken.clear();
        nearest::greedy(&mut pairs, &mut work.track_used, &mut work.plot_used, |p| taken.push(p));
        for pair in &taken {
            let k = from + pair.plot as usize;
            let plot = work.candidates[k].plot;
            self.update(pair.track as usize, Update::Plot(plot), k, model, work);
        }
        work.pairs = pairs;
        work.scratch = taken;
    }

    /// Global nearest neighbour in clusters; with a `limit`, joint probabilistic association in
    /// every cluster of more than one pair.
    fn take_by_cluster(
        &mut self,
        from: usize,
        limit: Option<usize>,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let mut pairs = std::mem::take(&mut work.pairs);
        let mut scratch = std::mem::take(&mut work.scratch);
        let mut clusters = std::mem::take(&mut work.clusters);
        let weights = Weights::new(model, self.config.gates.probability);
        pairs.sort_unstable_by_key(|p| (p.track, p.plot));
        let plots = work.plot_used.len();
        let borders = clusters.cut(self.tracks.len(), plots, &mut pairs, &mut scratch);
        let mut local = Local::default();
        for border in borders.windows(2) {
            let cluster = &pairs[border[0] as usize..border[1] as usize];
            if let [pair] = cluster {
                if weights.gain(pair) > 0.0 {
                    let k = from + pair.plot as usize;
                    let plot = work.candidates[k].plot;
                    self.update(pair.track as usize, Update::Plot(plot), k, model, work);
                }
                continue;
            }
            local.fill(cluster);
            match limit {
                Some(limit) => {
                    self.take_jointly(from, limit, cluster, &weights, &mut local, model, work);
                }
                _ => self.take_globally(from, cluster, &weights, &local, model, work),
            }
        }
        work.pairs = pairs;
        work.scratch = scratch;
        work.clusters = clusters;
    }

    fn take_globally(
        &mut self,
        from: usize,
        cluster: &[Pair],
        weights: &Weights,
        local: &Local,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let columns = local.plots.len();
        let mut costs = vec![None; local.tracks.len() * columns];
        for pair in cluster {
            let (row, column) = local.place(pair);
            costs[row * columns + column] = Some(-weights.gain(pair));
        }
        let found = work.solver.pairs_and_misses(local.tracks.len(), columns, |row, column| {
            costs[row * columns + column]
        });
        for (row, column) in found.into_iter().enumerate() {
            let Some(column) = column else { continue };
            let k = from + local.plots[column] as usize;
            let plot = work.candidates[k].plot;
            self.update(local.tracks[row] as usize, Update::Plot(plot), k, model, work);
        }
    }

    #[expect(clippy::too_many_arguments, reason = "one step of the batch, with its buffers")]
    fn take_jointly(
        &mut self,
        from: usize,
        limit: usize,
        cluster: &[Pair],
        weights: &Weights,
        local: &mut Local,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let (rows, columns) = (local.tracks.len(), local.plots.len());
        local.log_like.clear();
        local.log_like.resize(rows * columns, f64::NEG_INFINITY);
        for pair in cluster {
            let (row, column) = local.place(pair);
            local.log_like[row * columns + column] = weights.log_like(pair);
        }
        local.log_miss.clear();
        local.log_miss.resize(rows, weights.log_miss);
        let Local { log_miss, log_like, beta, .. } = local;
        match work.jpda.marginals(log_miss, log_like, limit, beta) {
            Ok(()) => {}
            Err(JpdaError::TooLarge { .. }) => {
                self.statistics.large_clusters += 1;
                if !self.take_thinned(from, limit, cluster, weights, local, model, work) {
                    self.take_globally(from, cluster, weights, local, model, work);
                }
                return;
            }
            Err(JpdaError::NoEvent) => {
                self.take_globally(from, cluster, weights, local, model, work);
                return;
            }
        }
        for row in 0..rows {
            self.take_weighted(from, row, local, model, work);
        }
        // A plot that the tracks of the cluster claim with more than even odds is used up.
        for column in 0..columns {
            let claimed: f64 =
                (0..rows).map(|row| local.beta[row * (columns + 1) + column + 1]).sum();
            work.candidates[from + local.plots[column] as usize].used |= claimed > 0.5;
        }
    }

    /// Drops the pairs that belief propagation holds for hopeless and tries again, if that splits or shrinks the
    /// cluster enough for exact association.
    #[expect(clippy::too_many_arguments, reason = "one step of the batch, with its buffers")]
    fn take_thinned(
        &mut self,
        from: usize,
        limit: usize,
        cluster: &[Pair],
        weights: &Weights,
        local: &mut Local,
        model: &SensorModel,
        work: &mut Work,
    ) -> bool {
        let columns = local.plots.len();
        lbp::marginals(&local.log_miss, &local.log_like, &mut local.beta);
        let mut kept: Vec<Pair> = cluster
            .iter()
            .filter(|pair| {
                let (row, column) = local.place(pair);
                local.beta[row * (columns + 1) + column + 1] > HOPELESS
            })
            .copied()
            .collect();
        if kept.len() == cluster.len() {
            return false;
        }
        kept.sort_unstable_by_key(|p| (p.track, p.plot));
        let mut clusters = crate::association::cluster::Clusters::default();
        let borders = clusters
            .cut(self.tracks.len(), work.plot_used.len(), &mut kept, &mut Vec::new())
            .to_vec();
        let mut part = Local::default();
        for border in borders.windows(2) {
            let piece = &kept[border[0] as usize..border[1] as usize];
            part.fill(piece);
            if part.tracks.len() << part.plots.len().min(40) > limit {
                self.take_globally(from, piece, weights, &part, model, work);
            } else {
                self.take_jointly(from, limit, piece, weights, &mut part, model, work);
            }
        }
        true
    }

    /// Updates one track with the plots of its row of marginals.
    fn take_weighted(
        &mut self,
        from: usize,
        row: usize,
        local: &Local,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let columns = local.plots.len();
        let beta = &local.beta[row * (columns + 1)..(row + 1) * (columns + 1)];
        let index = local.tracks[row] as usize;
        let missed = beta[0];
        let best = (1..=columns).max_by(|&a, &b| beta[a].total_cmp(&beta[b]).then(b.cmp(&a)));
        let Some(best) = best else { return };
        if 1.0 - missed < HOPELESS {
            return;
        }
        let k = from + local.plots[best - 1] as usize;
        let plot = work.candidates[k].plot;
        if beta[best] > 1.0 - HOPELESS {
            self.update(index, Update::Plot(plot), k, model, work);
            return;
        }
        // All at the time of the likeliest, moved by the predicted velocity.
        let Some(filter) = self.tracks[index].filter_before(plot.time) else { return };
        let Ok(at) = predict(filter, plot.time, &self.config.life) else { return };
        let velocity = at.velocity_ms();
        let plots = (1..=columns)
            .filter(|&c| c == best || beta[c] > HOPELESS)
            .map(|c| {
                let mut moved = work.candidates[from + local.plots[c - 1] as usize].plot;
                moved.position_m += velocity * plot.time.since_s(moved.time);
                moved.time = plot.time;
                (moved, beta[c])
            })
            .collect();
        self.update(index, Update::Weighted { plots, hit: missed < 0.5 }, k, model, work);
    }

    /// All pairs of tracks of `stage` and free plots inside the covariance gate.
    fn gated_pairs(&mut self, from: usize, to: usize, stage: Stage, work: &mut Work) {
        let Work { candidates, grid, pairs, track_used, span, .. } = work;
        let batch = &mut candidates[from..to];
        let (begin, end) = *span;
        let widest = batch.iter().fold(0.0f64, |w, c| w.max(search_variance(&c.plot)));
        pairs.clear();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != stage || track_used[index] {
                continue;
            }
            let young = track.plots == 1;
            let (low, high) = if young {
                // As far as its class can go since its only plot.
                let first = track.filter().estimate();
                let dt_s = end.since_s(first.time).max(0.0);
                let radius = track.limits.speed_ms * dt_s + 3.0 * (2.0 * widest).sqrt();
                let around = Vector2::repeat(radius);
                (first.position_m() - around, first.position_m() + around)
            } else {
                // Where it may be at any time of the batch.
                let Some(base) = track.filter_before(begin).or_else(|| track.filter_before(end))
                else {
                    continue;
                };
                let Ok(last) = predict(base, end, &self.config.life) else { continue };
                let first = predict(base, begin.max(base.time()), &self.config.life)
                    .map_or(last.position_m(), |e| e.position_m());
                let s = last.position_cov_m2();
                let half = Vector2::new(
                    (self.gate_1 * (s[(0, 0)] + widest)).sqrt(),
                    (self.gate_1 * (s[(1, 1)] + widest)).sqrt(),
                );
                (first.inf(&last.position_m()) - half, first.sup(&last.position_m()) + half)
            };
            grid.visit(low, high, |k| {
                let c = &mut batch[k];
                let p = c.plot.position_m;
                let inside = p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
                if c.used || !inside || !track.may_be(c.plot.identity) {
                    return;
                }
                if young && !within_first_gate(track, &c.plot) {
                    return;
                }
                let Some(found) = distance(track, &c.plot, &self.config) else { return };
                let within =
                    if young { within_first_gate(track, &c.plot) } else { found.d2 <= self.gate_1 };
                if within {
                    if stage == Stage::Confirmed {
                        c.gated = true;
                    }
                    pairs.push(Pair {
                        track: index as u32,
                        plot: k as u32,
                        d2: found.d2,
                        ln_det: found.ln_det,
                    });
                }
            });
        }
    }

    /// Offers what the covariance gate left to the reachable sets of confirmed tracks without a plot.
    fn take_manoeuvres(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        let mut offers: Vec<(f64, f64, usize, usize)> = Vec::new();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != Stage::Confirmed || work.track_used[index] {
                continue;
            }
            self.for_plots_in_reach(track, from, to, model, work, |k, plot, filter| {
                let dt_s = plot.time.since_s(filter.time());
                let target = Track::departure(filter);
                let r = plot.covariance_m2();
                let Some(reach) =
                    kinematic_gate::reach(&track.limits, &target, dt_s, plot.position_m, r)
                else {
                    return;
                };
                if reach.m <= self.config.gates.kinematic_limit {
                    let d2 = distance(track, plot, &self.config).map_or(f64::MAX, |d| d.d2);
                    offers.push((reach.m, d2, index, k));
                }
            });
        }
        offers.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)).then(a.3.cmp(&b.3))
        });
        for (_, _, track, k) in offers {
            if !work.track_used[track] && !work.candidates[k].used {
                let plot = work.candidates[k].plot;
                self.update(track, Update::Manoeuvre(plot), k, model, work);
            }
        }
    }

    /// Remembers the nearest plot that both gates refused; two in a row that fit together start the
    /// track's state anew.
    fn note_refused(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        let mut refusals: Vec<(f64, usize, usize)> = Vec::new();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != Stage::Confirmed || work.track_used[index] || track.updated {
                continue;
            }
            let mut nearest: Option<(f64, usize)> = None;
            self.for_plots_in_reach(track, from, to, model, work, |k, plot, filter| {
                let Ok(at) = predict(filter, plot.time, &self.config.life) else { return };
                let distance = (plot.position_m - at.position_m()).norm();
                if nearest.is_none_or(|(best, _)| distance < best) {
                    nearest = Some((distance, k));
                }
            });
            if let Some((distance, k)) = nearest {
                refusals.push((distance, index, k));
            }
        }
        refusals.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, index, k) in refusals {
            if work.candidates[k].used {
                continue;
            }
            self.statistics.refused += 1;
            let plot = work.candidates[k].plot;
            let track = &self.tracks[index];
            let before = track.refused.filter(|before| {
                let dt_s = plot.time.since_s(before.time);
                before.sensor == plot.sensor
                    && dt_s > 0.0
                    && dt_s <= 2.5 * model.interval_s
                    && (plot.position_m - before.position_m).norm()
                        <= track.limits.speed_ms * dt_s + 3.0 * trace(&plot).sqrt()
            });
            match before {
                Some(before) if self.config.gates.restart => {
                    self.statistics.restarts += 1;
                    self.update(index, Update::Restart(before, plot), k, model, work);
                }
                _ => self.tracks[index].refused = Some(plot),
            }
        }
    }

    /// Calls `visit` for every free plot of the batch that the fastest target of the track's class could
    /// have reached, with the filter as it was before that plot.
    fn for_plots_in_reach<'a>(
        &self,
        track: &'a Track,
        from: usize,
        to: usize,
        model: &SensorModel,
        work: &Work,
        mut visit: impl FnMut(usize, &Plot, &'a TrackFilter),
    ) {
        let batch = &work.candidates[from..to];
        let (_, latest) = work.span;
        let centre = track.filter().estimate().position_m();
        let way = latest.since_s(track.time()).max(0.0) + model.interval_s.min(1.0);
        let radius = track.limits.speed_ms * way + REACH_MARGIN_M;
        let around = Vector2::repeat(radius);
        work.grid.visit(centre - around, centre + around, |k| {
            let c = &batch[k];
            if c.used || c.gated || !track.may_be(c.plot.identity) {
                return;
            }
            // Nobody else's name may be put on a track that has none by a manoeuvre.
            if c.plot.identity.is_some() && track.callsign.is_none() && track.address.is_none() {
                return;
            }
            if let Some(filter) = track.filter_before(c.plot.time) {
                let dt_s = c.plot.time.since_s(filter.time());
                let offset = c.plot.position_m - filter.estimate().position_m();
                let uncertainty =
                    3.0 * (trace(&c.plot) + filter.estimate().position_cov_m2().trace()).sqrt();
                if offset.norm() <= track.limits.speed_ms * dt_s + uncertainty {
                    visit(from + k, &c.plot, filter);
                }
            }
        });
    }

    /// Marks the free plots that lie on the body of a labelled target: other echoes of it.
    fn mark_other_echoes(&self, from: usize, to: usize, work: &mut Work) {
        let Work { candidates, bodies, body_tracks, positions, .. } = work;
        let batch = &mut candidates[from..to];
        if batch.iter().all(|c| c.used || c.gated) {
            return;
        }
        body_tracks.clear();
        positions.clear();
        let mut longest = 0.0f64;
        for (index, track) in self.tracks.iter().enumerate() {
            if let (Stage::Confirmed, Some((length, span))) = (track.stage, track.size_m) {
                body_tracks.push(index as u32);
                positions.push(track.filter().estimate().position_m());
                longest = longest.max(length.max(span));
            }
        }
        if body_tracks.is_empty() {
            return;
        }
        bodies.fill(positions, longest + REACH_MARGIN_M);
        let around = Vector2::repeat(longest + REACH_MARGIN_M);
        for c in batch.iter_mut().filter(|c| !c.used && !c.gated) {
            let place = c.plot.position_m;
            let mut on_body = false;
            bodies.visit(place - around, place + around, |k| {
                let track = &self.tracks[body_tracks[k] as usize];
                let at = predict(track.filter(), c.plot.time.max(track.time()), &self.config.life);
                on_body |= c.plot.identity.is_none()
                    && at.is_ok_and(|at| life::on_body(track, at.position_m(), place, 0.0));
            });
            c.gated |= on_body;
        }
    }

    /// A plot that no track used and that lies in no gate of a confirmed track begins a track.
    fn start_tracks(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        for k in from..to {
            let Candidate { plot, used, gated, index } = work.candidates[k];
            if used {
                continue;
            }
            let one_line_only = !plot.across_m2.is_finite() || !plot.along_m2.is_finite();
            if gated || one_line_only {
                self.statistics.unused += 1;
                continue;
            }
            if self.tracks.len() >= self.config.life.most_tracks {
                self.statistics.no_room += 1;
                continue;
            }
            let Ok(track) = Track::start(self.next_serial, &plot, &self.config, model.interval_s)
            else {
                self.statistics.unsound += 1;
                self.outcomes[index] = Outcome::Unsound;
                continue;
            };
            self.outcomes[index] = Outcome::Used {
                number: None,
                serial: track.serial,
                position_m: plot.position_m,
                velocity_ms: Vector2::zeros(),
            };
            work.candidates[k].used = true;
            self.next_serial += 1;
            self.statistics.started += 1;
            self.tracks.push(track);
            work.track_used.push(true);
        }
    }

    fn distance(&self, track: usize, plot: &Plot) -> Option<Distance> {
        distance(&self.tracks[track], plot, &self.config)
    }

    /// Gives candidate `k` to a track.
    fn update(
        &mut self,
        index: usize,
        update: Update,
        k: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let candidate = &mut work.candidates[k];
        let track = &mut self.tracks[index];
        let manoeuvre = matches!(update, Update::Manoeuvre(_) | Update::Restart(..));
        let by_gate_2 = matches!(update, Update::Manoeuvre(_));
        let late = candidate.plot.time < track.time();
        let (callsign, address) = (track.callsign, track.address);
        let was_called = |name: Identity| match name {
            Identity::Callsign(c) => callsign == Some(c),
            Identity::Address(a) => address == Some(a),
        };
        let hit = !matches!(update, Update::Weighted { hit: false, .. });
        let applied = track.apply(update, candidate.plot.time, model.interval_s, &self.config);
        let (position_m, velocity_ms) = match applied {
            Applied::Taken { position_m, velocity_ms } => (position_m, velocity_ms),
            Applied::Reborn { position_m, velocity_ms } => {
                self.statistics.not_positive_definite += 1;
                (position_m, velocity_ms)
            }
            Applied::Refused => {
                self.statistics.unsound += 1;
                return;
            }
        };
        let new_name = candidate.plot.identity.filter(|name| !was_called(*name));
        candidate.used |= hit;
        if hit && self.config.register_sites {
            let plot = candidate.plot;
            if plot.polar.is_some() && !manoeuvre {
                if let Some(reference) = &track.reference {
                    self.registration.learn(&plot, reference, velocity_ms);
                }
            } else if plot.identity.is_some() && plot.along_m2.is_finite() {
                track.reference = Some(Reference {
                    time: plot.time,
                    position_m: plot.position_m,
                    variance_m2: 0.5 * (plot.along_m2 + plot.across_m2),
                    repeats: if model.slow_share > 0.0 {
                        (2.0 * model.slow_tau_s / model.interval_s.max(1e-3)).max(1.0)
                    } else {
                        1.0
                    },
                });
            }
        }
        work.track_used[index] |= hit;
        track.manoeuvre |= manoeuvre;
        self.statistics.late += u64::from(late);
        if by_gate_2 {
            self.statistics.gate_2 += 1;
        } else if !manoeuvre {
            self.statistics.gate_1 += 1;
        }
        self.outcomes[candidate.index] =
            Outcome::Used { number: track.number, serial: track.serial, position_m, velocity_ms };
        // The name goes with the track that is nearer to the plot that carries it.
        if let (true, Some(name)) = (hit, new_name) {
            for (other, track) in self.tracks.iter_mut().enumerate() {
                if other != index && track.is(name) {
                    track.forget_identity();
                    track.limits = self.config.limits_of(None);
                    self.statistics.identity_conflicts += 1;
                }
            }
        }
    }
}

/// Cell of the search grid, m: about a search box of a taxiing target.
const GRID_CELL_M: f64 = 25.0;

/// Added to the search circle of the kinematic gate, m; the exact test follows.
const REACH_MARGIN_M: f64 = 50.0;

/// ln 2π.
const LN_TAU: f64 = 1.837_877_066_409_345_3;

/// Innovation squared and its ln det 2πS.
#[derive(Clone, Copy, Debug)]
struct Distance {
    d2: f64,
    ln_det: f64,
}

/// Distance of a plot from a track predicted to the plot's own time.
fn distance(track: &Track, plot: &Plot, config: &TrackingConfig) -> Option<Distance> {
    let filter = track.filter_before(plot.time)?;
    let (d2, ln_det, dof) =
        if plot.time.since_s(filter.time()) <= config.life.constant_velocity_after_s {
            filter.innovation(plot, &config.sensor(plot.sensor, plot.kind)).ok()?
        } else {
            let found = predict(filter, plot.time, &config.life).ok()?.innovation(plot).ok()?;
            (found.d2, found.ln_det, found.dof)
        };
    let ln_det = ln_det + f64::from(dof) * LN_TAU;
    (d2.is_finite() && ln_det.is_finite()).then_some(Distance { d2, ln_det })
}

/// First gate of a track with one plot: as far as its class can go.
fn within_first_gate(track: &Track, plot: &Plot) -> bool {
    let first = track.filter().estimate();
    let dt_s = plot.time.since_s(first.time).abs();
    let margin = 3.0 * trace(plot).sqrt();
    (plot.position_m - first.position_m()).norm() <= track.limits.speed_ms * dt_s + margin
}

/// `tr R`, m²; a direction that is not measured counts 10 m.
fn trace(plot: &Plot) -> f64 {
    plot.along_m2.min(100.0) + plot.across_m2.min(100.0)
}

/// Largest variance of the plot for the search box; a direction that is not measured counts 20 m.
fn search_variance(plot: &Plot) -> f64 {
    let bounded = |v: f64| if v.is_finite() { v } else { 400.0 };
    bounded(plot.along_m2).max(bounded(plot.across_m2))
}

/// Marginals below this are left out of an update.
const HOPELESS: f64 = 1e-3;

/// Weights of pairs and misses of one sensor.
#[derive(Clone, Copy, Debug)]
struct Weights {
    /// `ln(1 − P_D P_G)`
    log_miss: f64,
    /// `ln P_D − ln λ`
    log_hit: f64,
}

impl Weights {
    fn new(model: &SensorModel, gate_probability: f64) -> Self {
        let detection = model.detection.clamp(1e-6, 1.0 - 1e-6);
        let density = model.false_density_m2.clamp(1e-15, 1e3);
        Self {
            log_miss: libm::log1p(-detection * gate_probability.clamp(0.0, 1.0)),
            log_hit: libm::log(detection) - libm::log(density),
        }
    }

    /// `ln P_D − ½(d² + ln det 2πS) − ln λ`
    fn log_like(&self, pair: &Pair) -> f64 {
        self.log_hit - 0.5 * (pair.d2 + pair.ln_det)
    }

    /// How much better than a miss the pair is.
    fn gain(&self, pair: &Pair) -> f64 {
        self.log_like(pair) - self.log_miss
    }
}

/// Rows and columns of one cluster.
#[derive(Clone, Debug, Default)]
struct Local {
    tracks: Vec<u32>,
    plots: Vec<u32>,
    log_miss: Vec<f64>,
    log_like: Vec<f64>,
    beta: Vec<f64>,
}

impl Local {
    fn fill(&mut self, cluster: &[Pair]) {
        self.tracks.clear();
        self.tracks.extend(cluster.iter().map(|p| p.track));
        self.tracks.sort_unstable();
        self.tracks.dedup();
        self.plots.clear();
        self.plots.extend(cluster.iter().map(|p| p.plot));
        self.plots.sort_unstable();
        self.plots.dedup();
    }

    fn place(&self, pair: &Pair) -> (usize, usize) {
        let row = self.tracks.partition_point(|&t| t < pair.track);
        (row, self.plots.partition_point(|&p| p < pair.plot))
    }
}
