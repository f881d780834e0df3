//! Association of one batch (plots of one sensor and one of its intervals) with the tracks.

use super::config::{AssociationMethod, SensorModel};
use super::gate::{KEPT, REACH_MARGIN_M, lay_out, trace};
use super::life;
use super::registration::Reference;
use super::track_file::{Applied, Stage, Track, Update, position_at, predict};
use super::tracker::{Candidate, Outcome, Tracker, Work};
use crate::association::jpda::JpdaError;
use crate::association::kinematic_gate;
use crate::association::lbp::{self, Edge};
use crate::association::nearest::{self, Pair};
use crate::filter::{Measurement, Nis};
use crate::frames::Vector2;
use crate::plot::{Identity, Plot};
use crate::time::SimTime;
use std::collections::BTreeSet;

impl Tracker {
    /// Gives the plots `candidates[from..to]` (one sensor, one interval) to tracks; starts new ones.
    pub(super) fn associate_batch(&mut self, from: usize, to: usize, work: &mut Work) {
        let first = work.candidates[from].plot;
        let model = self.config.sensor(first.sensor, first.kind);
        let none = (SimTime(i64::MAX), SimTime(i64::MIN));
        work.span = work.candidates[from..to]
            .iter()
            .fold(none, |span, c| (span.0.min(c.plot.time), span.1.max(c.plot.time)));
        work.track_used.clear();
        work.track_used.resize(self.tracks.len(), false);
        self.take_identified(from, to, &model, work);
        lay_out(from, to, work);
        self.take_gated(from, to, Stage::Confirmed, &model, work);
        lay_out(from, to, work);
        if work.free.is_empty() {
            return;
        }
        self.reachable_pairs(&model, work);
        if self.config.gates.kinematic {
            self.take_manoeuvres(&model, work);
        }
        self.note_refused(&model, work);
        self.take_gated(from, to, Stage::Tentative, &model, work);
        self.mark_other_echoes(from, to, work);
        self.start_tracks(from, to, &model, work);
    }

    /// Plots with an identity go first, to the track that has it.
    fn take_identified(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        if work.candidates[from..to].iter().all(|c| c.plot.identity.is_none()) {
            return;
        }
        work.identities.clear();
        work.renamed.clear();
        for (index, track) in self.tracks.iter().enumerate() {
            if track.stage != Stage::Ended {
                let callsign = track.callsign.map(Identity::Callsign);
                let address = track.address.map(Identity::Address);
                let names = callsign.into_iter().chain(address);
                work.identities.extend(names.map(|name| (name, index as u32)));
            }
        }
        work.identities.sort_unstable();
        for k in from..to {
            let plot = &work.candidates[k].plot;
            let Some(identity) = plot.identity else { continue };
            let first = work.identities.partition_point(|(name, _)| *name < identity);
            let holder = work.identities.get(first).filter(|(name, _)| *name == identity);
            let Some(&(_, track)) = holder else { continue };
            let track = track as usize;
            // Whoever holds the name: the plot starts no other track, nor is it taken for one on trial
            // while the holder is still called so.
            work.gated[k] = true;
            let holder = &self.tracks[track];
            work.held[k] = holder.stage == Stage::Confirmed
                && plot.time.since_s(holder.named_at) <= NAME_HOLDS_S;
            if work.track_used[track] {
                continue;
            }
            let found = Measurement::of(plot)
                .ok()
                .and_then(|m| self.distance(&self.tracks[track], plot.time, plot, &m));
            if found.is_some_and(|pair| pair.d2 <= self.identified_gate) {
                self.update(track, How::Plot, k, model, work);
            } else {
                self.tracks[track].name_refused += 1;
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
        // Tracks on trial take what is nearest: they have no reliable density to weigh with.
        let method = match stage {
            Stage::Tentative => AssociationMethod::Nearest,
            _ => self.config.association,
        };
        self.gated_pairs(from, stage, work);
        work.plot_used.clear();
        work.plot_used.resize(to - from, false);
        for &index in &work.crowd.tracks {
            self.tracks[index as usize].unresolved = true;
        }
        self.statistics.crowded += work.crowd.tracks.len() as u64;
        match method {
            AssociationMethod::Nearest => self.take_nearest(from, model, work),
            AssociationMethod::Global => self.take_by_cluster(from, None, model, work),
            AssociationMethod::Joint { limit } => {
                // What joint association has weighed has had its chance.
                return self.take_by_cluster(from, Some(limit), model, work);
            }
        }
        self.pair_by_rank(from, model, work);
    }

    fn take_nearest(&mut self, from: usize, model: &SensorModel, work: &mut Work) {
        let mut pairs = std::mem::take(&mut work.pairs);
        let mut taken = std::mem::take(&mut work.scratch);
        taken.clear();
        part_undisputed(&mut pairs, work.plot_used.len(), &mut work.claims, &mut taken);
        // The updates come in the order in which the tracks lie in memory.
        work.chosen.clear();
        work.chosen.resize(self.tracks.len(), NONE);
        for pair in &taken {
            work.chosen[pair.track as usize] = pair.plot;
            work.track_used[pair.track as usize] = true;
        }
        let Work { order, chosen, track_used, plot_used, .. } = work;
        nearest::greedy(&pairs, order, track_used, plot_used, |pair| {
            chosen[pair.track as usize] = pair.plot;
        });
        for track in 0..work.chosen.len() {
            let plot = work.chosen[track];
            if plot != NONE {
                self.update(track, How::Plot, from + plot as usize, model, work);
            }
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
        let plots = work.plot_used.len();
        let mut single = std::mem::take(&mut work.single);
        single.clear();
        part_undisputed(&mut pairs, plots, &mut work.claims, &mut single);
        for pair in &single {
            let k = from + pair.plot as usize;
            let certain = if limit.is_some() { CERTAIN } else { 0.0 };
            if weights.surely_above(&pair.nis, certain) {
                self.update(pair.track as usize, How::Plot, k, model, work);
                continue;
            }
            let gain = weights.gain(&pair.nis);
            if limit.is_some() && gain.abs() < CERTAIN {
                let mut plots = std::mem::take(&mut work.weighted);
                plots.clear();
                plots.push((work.candidates[k].plot, 1.0 / (1.0 + libm::exp(-gain))));
                let how = How::Weighted { plots: &plots, hit: gain > 0.0 };
                self.update(pair.track as usize, how, k, model, work);
                work.weighted = plots;
            } else if gain > 0.0 {
                self.update(pair.track as usize, How::Plot, k, model, work);
            }
        }
        work.single = single;
        let borders: &[u32] = if pairs.is_empty() {
            &[]
        } else {
            clusters.cut(self.tracks.len(), plots, &mut pairs, &mut scratch)
        };
        let mut local = std::mem::take(&mut work.local);
        for border in borders.windows(2) {
            let cluster = &pairs[border[0] as usize..border[1] as usize];
            local.fill(cluster);
            match limit {
                Some(limit) => {
                    self.take_jointly(from, limit, cluster, &weights, &mut local, model, work);
                }
                _ => self.take_globally(from, cluster, &weights, &mut local, model, work),
            }
        }
        work.local = local;
        work.pairs = pairs;
        work.scratch = scratch;
        work.clusters = clusters;
    }

    fn take_globally(
        &mut self,
        from: usize,
        cluster: &[Pair],
        weights: &Weights,
        local: &mut Local,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let (rows, columns) = (local.tracks.len(), local.plots.len());
        let mut found = std::mem::take(&mut local.found);
        found.clear();
        if rows <= FEW_ROWS {
            let mut costs = std::mem::take(&mut local.costs);
            costs.clear();
            costs.resize(rows * columns, None);
            for pair in cluster {
                let (row, column) = local.place(pair);
                costs[row * columns + column] = Some(-weights.gain(&pair.nis));
            }
            let pairs = work
                .solver
                .pairs_and_misses(rows, columns, |row, column| costs[row * columns + column]);
            found.extend(pairs.iter().map(|c| c.map(|c| c as u32)));
            work.budget.spend((rows * rows * (rows + columns)) as u64);
            local.costs = costs;
        } else {
            local.list(cluster, weights);
            let left = work.budget.left_of(0.5).max(4 * cluster.len() as u64);
            let mut budget = left;
            found.extend(work.sparse.pairs(rows, columns, &local.edges, &mut budget));
            work.budget.spend(left - budget);
        }
        for (row, column) in found.iter().enumerate() {
            let Some(column) = *column else { continue };
            let k = from + local.plots[column as usize] as usize;
            self.update(local.tracks[row] as usize, How::Plot, k, model, work);
        }
        local.found = found;
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
        self.statistics.largest_cluster = self.statistics.largest_cluster.max(rows as u64);
        if !local.is_exact(limit, work) {
            self.statistics.large_clusters += 1;
            self.take_by_belief(from, limit, cluster, weights, local, model, work);
            return;
        }
        local.log_like.clear();
        local.log_like.resize(rows * columns, f64::NEG_INFINITY);
        for pair in cluster {
            let (row, column) = local.place(pair);
            local.log_like[row * columns + column] = weights.log_like(&pair.nis);
        }
        local.log_miss.clear();
        local.log_miss.resize(rows, weights.log_miss);
        work.budget.spend(exact_cost(rows, columns));
        let Local { log_miss, log_like, beta, .. } = local;
        match work.jpda.marginals(log_miss, log_like, limit, beta) {
            Ok(()) => self.take_marginals(from, local, model, work),
            Err(JpdaError::TooLarge { .. } | JpdaError::NoEvent) => {
                self.take_globally(from, cluster, weights, local, model, work);
            }
        }
    }

    /// Updates the tracks of a cluster with their rows of marginals.
    fn take_marginals(&mut self, from: usize, local: &Local, model: &SensorModel, work: &mut Work) {
        let (rows, columns) = (local.tracks.len(), local.plots.len());
        for row in 0..rows {
            let beta = &local.beta[row * (columns + 1)..(row + 1) * (columns + 1)];
            let shares = local.plots.iter().copied().zip(beta[1..].iter().copied());
            self.take_weighted(from, local.tracks[row], beta[0], shares, model, work);
        }
        // A plot that the tracks of the cluster claim with more than even odds is used up.
        for column in 0..columns {
            let claimed: f64 =
                (0..rows).map(|row| local.beta[row * (columns + 1) + column + 1]).sum();
            work.used[from + local.plots[column] as usize] |= claimed > 0.5;
        }
    }

    /// A cluster that is too large to be done exactly: belief propagation over its pairs. Where dropping the pairs that
    /// it holds for hopeless leaves pieces that are small enough, those are done exactly.
    #[expect(clippy::too_many_arguments, reason = "one step of the batch, with its buffers")]
    fn take_by_belief(
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
        local.list(cluster, weights);
        let mut belief = std::mem::take(&mut work.belief);
        // An edge and sweep is an evaluation; four sweeps are always made.
        let fitting = work.budget.left_of(0.5) / (local.edges.len() as u64).max(1);
        let sweeps = fitting.clamp(4, lbp::MOST_SWEEPS.into()) as u32;
        let ended = belief.run(rows, columns, &local.edges, sweeps, lbp::STILL);
        work.budget.spend(u64::from(ended.sweeps) * local.edges.len() as u64);
        self.statistics.sweeps += u64::from(ended.sweeps);
        let hopeful = |row: usize, edge: usize| belief.share(row, edge) > HOPELESS;
        let kept = |row: usize| belief.edges_of(row).filter(move |&e| hopeful(row, e));
        let mut pieces: Vec<Pair> = (0..rows).flat_map(kept).map(|edge| cluster[edge]).collect();
        let mut clusters = crate::association::cluster::Clusters::default();
        let borders = if pieces.len() < cluster.len() {
            let plots = work.plot_used.len();
            clusters.cut(self.tracks.len(), plots, &mut pieces, &mut Vec::new())
        } else {
            &[]
        };
        let mut exact = BTreeSet::new();
        let mut part = Local::default();
        for border in borders.windows(2) {
            let piece = &pieces[border[0] as usize..border[1] as usize];
            part.fill(piece);
            if part.is_exact(limit, work) {
                exact.extend(part.tracks.iter().copied());
                self.take_jointly(from, limit, piece, weights, &mut part, model, work);
            }
        }
        // By falling probability, where one plot stands out: a mixture would hold the tracks together for good.
        let mut clear: Vec<(f64, usize, usize)> = Vec::new();
        for row in (0..rows).filter(|&row| !exact.contains(&local.tracks[row])) {
            let standing = belief.edges_of(row).map(|e| (belief.share(row, e), row, e));
            clear.extend(standing.filter(|(share, ..)| *share >= STANDS_OUT));
        }
        clear.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut done = vec![false; rows];
        for (_, row, edge) in clear {
            let k = from + local.plots[local.edges[edge].column as usize] as usize;
            if !done[row] && !work.used[k] {
                done[row] = true;
                self.update(local.tracks[row] as usize, How::Plot, k, model, work);
            }
        }
        let mut claimed = vec![0.0; columns];
        for row in (0..rows).filter(|&row| !done[row]) {
            if exact.contains(&local.tracks[row]) {
                continue;
            }
            let shares =
                belief.edges_of(row).map(|e| (local.edges[e].column, belief.share(row, e)));
            shares.clone().for_each(|(column, share)| claimed[column as usize] += share);
            let shares = shares.map(|(column, share)| (local.plots[column as usize], share));
            let miss = belief.miss(row);
            self.take_weighted(from, local.tracks[row], miss, shares, model, work);
        }
        for (plot, claimed) in local.plots.iter().zip(claimed) {
            work.used[from + *plot as usize] |= claimed > 0.5;
        }
        work.belief = belief;
    }

    /// Updates track `index` with the plots (their places in the batch) of its row of marginals.
    fn take_weighted(
        &mut self,
        from: usize,
        index: u32,
        missed: f64,
        shares: impl Iterator<Item = (u32, f64)> + Clone,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let index = index as usize;
        let best = shares.clone().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let Some((best, share)) = best else { return };
        if 1.0 - missed < HOPELESS {
            return;
        }
        let k = from + best as usize;
        if share > 1.0 - HOPELESS {
            self.update(index, How::Plot, k, model, work);
            return;
        }
        // All at the time of the likeliest, moved by the predicted velocity.
        let time = work.candidates[k].plot.time;
        let Some(filter) = self.tracks[index].filter_before(time, &self.ring) else { return };
        let Ok(at) = predict(filter, time, &self.config.life) else { return };
        let velocity = at.velocity_mps();
        let mut plots = std::mem::take(&mut work.weighted);
        plots.clear();
        for (plot, share) in shares.filter(|&(plot, share)| plot == best || share > HOPELESS) {
            let mut moved = work.candidates[from + plot as usize].plot;
            moved.position_m += velocity * time.since_s(moved.time);
            moved.time = time;
            plots.push((moved, share));
        }
        let how = How::Weighted { plots: &plots, hit: missed < 0.5 };
        self.update(index, how, k, model, work);
        work.weighted = plots;
    }

    /// Offers what the covariance gate left to the reachable sets of confirmed tracks without a plot.
    fn take_manoeuvres(&mut self, model: &SensorModel, work: &mut Work) {
        let mut offers: Vec<(f64, f64, u32, usize)> = Vec::new();
        let limit = self.config.gates.kinematic_limit;
        for pair in work.reaches.iter().filter(|pair| !pair.hopeless) {
            let track = &self.tracks[pair.track as usize];
            let k = pair.k as usize;
            let plot = &work.candidates[k].plot;
            let Some(filter) = track.filter_before(plot.time, &self.ring) else { continue };
            let dt_s = plot.time.since_s(filter.time());
            let (target, r) = (Track::departure(filter), plot.covariance_m2());
            let reach = kinematic_gate::reach(&track.limits, &target, dt_s, plot.position_m, r);
            let Some(reach) = reach.filter(|reach| reach.m <= limit) else { continue };
            let measured = Measurement::of(plot).ok();
            let found = measured.and_then(|m| self.distance(track, plot.time, plot, &m));
            offers.push((reach.m, found.map_or(f64::MAX, |d| d.d2), pair.track, k));
        }
        offers.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)).then(a.3.cmp(&b.3))
        });
        for (_, _, track, k) in offers {
            if !work.track_used[track as usize] && !work.used[k] {
                self.update(track as usize, How::Manoeuvre, k, model, work);
            }
        }
    }

    /// Remembers the nearest plot that both gates refused; two in a row that fit together start the
    /// track's state anew. Once: before the next new beginning a plot must have fitted the last one, or clutter
    /// would keep a track alive for ever.
    fn note_refused(&mut self, model: &SensorModel, work: &mut Work) {
        let mut refusals: Vec<(f64, u32, usize)> = Vec::new();
        for pairs in work.reaches.chunk_by(|a, b| a.track == b.track) {
            let index = pairs[0].track;
            let track = &self.tracks[index as usize];
            if work.track_used[index as usize] || track.updated {
                continue;
            }
            let mut nearest: Option<(f64, usize)> = None;
            for k in pairs.iter().map(|pair| pair.k as usize).filter(|&k| !work.used[k]) {
                let plot = &work.candidates[k].plot;
                let Some(filter) = track.filter_before(plot.time, &self.ring) else { continue };
                let Ok((at, _)) = position_at(filter, plot.time, &self.config.life) else {
                    continue;
                };
                let distance = (plot.position_m - at).norm();
                if nearest.is_none_or(|best| (distance, k) < best) {
                    nearest = Some((distance, k));
                }
            }
            refusals.extend(nearest.map(|(distance, k)| (distance, index, k)));
        }
        refusals.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, index, k) in refusals {
            if work.used[k] {
                continue;
            }
            self.statistics.refused += 1;
            let plot = &work.candidates[k].plot;
            let track = &mut self.tracks[index as usize];
            // What says its name says no more than others see: while they follow the track, it is not moved by it.
            let lone = plot.identity.is_none()
                || !track.has_other_than(
                    plot.sensor,
                    plot.time,
                    3.0 * track.interval_s.max(model.interval_s),
                );
            let before = track.refused.take().filter(|before| {
                let dt_s = plot.time.since_s(before.time);
                lone && before.sensor == plot.sensor
                    && dt_s > 0.0
                    && dt_s <= 2.5 * model.interval_s
                    && (plot.position_m - before.position_m).norm()
                        <= track.limits.speed_mps * dt_s + 3.0 * trace(plot).sqrt()
            });
            match before {
                Some(before) if self.config.gates.restart && !track.restarted => {
                    self.statistics.restarts += 1;
                    self.update(index as usize, How::Restart(&before), k, model, work);
                }
                _ => track.refused = Some(Box::new(*plot)),
            }
        }
    }

    /// Marks the free plots that lie on the body of a labelled target: other echoes of it.
    fn mark_other_echoes(&self, from: usize, to: usize, work: &mut Work) {
        let Work { candidates, used, gated, bodies, bodied, positions, near, .. } = work;
        if bodied.is_empty() || (from..to).all(|k| used[k] || gated[k]) {
            return;
        }
        positions.clear();
        let mut longest = 0.0f64;
        for &index in &*bodied {
            let track = &self.tracks[index as usize];
            positions.push(track.filter().motion().0);
            longest = track.size_m.map_or(longest, |(l, s)| longest.max(l.max(s)));
        }
        bodies.fill(positions, longest + REACH_MARGIN_M);
        let around = Vector2::repeat(longest + REACH_MARGIN_M);
        for k in (from..to).filter(|&k| !used[k]) {
            let plot = &candidates[k].plot;
            if gated[k] || plot.identity.is_some() {
                continue;
            }
            let place = plot.position_m;
            let mut look_at = |body: usize| {
                let track = &self.tracks[bodied[body] as usize];
                let time = plot.time.max(track.time());
                gated[k] |= track.size_m.is_some()
                    && position_at(track.filter(), time, &self.config.life)
                        .is_ok_and(|(at, _)| life::on_body(track, at, place, 0.0));
            };
            let (low, high) = (place - around, place + around);
            bodies.visit_near(low, high, KEPT, near, &mut look_at);
        }
    }

    /// A plot that no track used and that lies in no gate of a confirmed track begins a track.
    fn start_tracks(&mut self, from: usize, to: usize, model: &SensorModel, work: &mut Work) {
        let mut started = BTreeSet::new();
        for k in from..to {
            if work.used[k] {
                continue;
            }
            let Candidate { plot, index } = &work.candidates[k];
            // One name, one track: another plot of it waits for the next look.
            work.gated[k] |= plot.identity.is_some_and(|name| started.contains(&name));
            let one_line_only = !plot.across_m2.is_finite() || !plot.along_m2.is_finite();
            if work.gated[k] || one_line_only {
                self.statistics.unused += 1;
                continue;
            }
            if self.tracks.len() >= self.config.life.most_tracks {
                self.statistics.no_room += 1;
                continue;
            }
            let track = Track::start(self.next_serial, plot, &self.config, model.interval_s);
            let Ok(mut track) = track else {
                self.statistics.unsound += 1;
                self.outcomes[*index] = Outcome::Unsound;
                continue;
            };
            track.outside = self.is_outside(*index);
            self.outcomes[*index] = Outcome::Used {
                number: None,
                serial: track.serial,
                position_m: plot.position_m,
                velocity_mps: Vector2::zeros(),
            };
            started.extend(plot.identity);
            work.used[k] = true;
            self.next_serial += 1;
            self.statistics.started += 1;
            work.tentative.push(self.tracks.len() as u32);
            self.tracks.push(track);
        }
    }

    /// Gives candidate `k` to a track.
    pub(super) fn update(
        &mut self,
        index: usize,
        how: How<'_>,
        k: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let Candidate { plot, index: place } = &work.candidates[k];
        let outside = self.is_outside(*place) || self.tracks[index].outside;
        // The plot as the track knows its target: offset of its echo, and how that wanders.
        let stated = *plot;
        let known = self.tracks[index].as_known(plot, &self.registration);
        let plot = &known;
        let several: Vec<(Plot, f64)>;
        let how = match how {
            How::Weighted { plots, hit } if self.config.register_echo => {
                several = {
                    let (track, sites) = (&self.tracks[index], &self.registration);
                    plots.iter().map(|(p, beta)| (track.as_known(p, sites), *beta)).collect()
                };
                How::Weighted { plots: &several, hit }
            }
            other => other,
        };
        let track = &mut self.tracks[index];
        let late = plot.time < track.time();
        if late {
            // What comes behind it is done again.
            let again = track.later_than(plot.time) as u64 * work.budget.update();
            if work.budget.left_of(0.9) < again {
                self.statistics.too_late += 1;
                self.outcomes[*place] = Outcome::TooLate;
                return;
            }
            work.budget.spend(again);
        }
        let (update, hit) = match how {
            How::Plot => (Update::Plot(plot), true),
            How::Manoeuvre => (Update::Manoeuvre(plot), true),
            How::Restart(before) => (Update::Restart(before, plot), true),
            How::Weighted { plots, hit } => (Update::Weighted(plots), hit),
        };
        let manoeuvre = matches!(how, How::Manoeuvre | How::Restart(_));
        // Where full weighing would cost too much, the track goes on as one Gaussian for this update.
        let plots = if let How::Weighted { plots, .. } = how { plots.len() as u64 + 1 } else { 1 };
        let dear = plots > 2 && work.budget.left_of(0.7) < plots * work.budget.update();
        let merge = (work.light || dear) && work.budget.update() > MERGED_ABOVE;
        self.statistics.merged_updates += u64::from(merge);
        work.budget.spend(if merge { 30 * plots } else { plots * work.budget.update() });
        let config = &self.config;
        let applied = track.apply(update, merge, config, self.oldest, &mut self.ring);
        let (position_m, velocity_mps) = match applied {
            Applied::Taken { position_m, velocity_mps } => (position_m, velocity_mps),
            Applied::Reborn { position_m, velocity_mps } => {
                self.statistics.not_positive_definite += 1;
                (position_m, velocity_mps)
            }
            Applied::Refused => {
                self.statistics.unsound += 1;
                return;
            }
        };
        let new_name = plot.identity.filter(|name| hit && !track.is(*name));
        if hit {
            track.note_hit(plot, model.interval_s);
            work.used[k] = true;
            work.track_used[index] = true;
        }
        if hit {
            track.note_course(velocity_mps);
        }
        if hit && !manoeuvre && self.config.register_echo && stated.polar.is_some() {
            track.spread.learn(&stated, model.interval_s);
            track.note_echo(&stated, self.registration.law());
        }
        if hit && self.config.register_sites && !outside {
            if plot.polar.is_some() && !manoeuvre {
                if let Some(reference) = &track.reference {
                    let (body, course) = (track.body(), track.course);
                    let taken_off = self.registration.correction_m(&stated)
                        - stated.axis * self.registration.law().unknown_m.0;
                    self.registration.learn(
                        &stated,
                        taken_off,
                        reference,
                        velocity_mps,
                        body.as_ref(),
                        course,
                        model.interval_s,
                    );
                }
            } else if plot.identity.is_some() && plot.along_m2.is_finite() {
                track.reference = Some(Box::new(Reference {
                    time: plot.time,
                    position_m: plot.position_m,
                    variance_m2: 0.5 * (plot.along_m2 + plot.across_m2),
                    repeats: if model.slow_share > 0.0 {
                        (2.0 * model.slow_tau_s / model.interval_s.max(1e-3)).max(1.0)
                    } else {
                        1.0
                    },
                }));
            }
        }
        if hit {
            track.restarted = matches!(how, How::Restart(_));
        }
        track.manoeuvre |= manoeuvre;
        self.statistics.late += u64::from(late);
        match how {
            How::Manoeuvre => self.statistics.gate_2 += 1,
            How::Restart(_) => {}
            How::Plot | How::Weighted { .. } => self.statistics.gate_1 += 1,
        }
        // At the time that the plot itself says.
        let position_m = position_m + velocity_mps * model.latency_s;
        self.outcomes[*place] =
            Outcome::Used { number: track.number, serial: track.serial, position_m, velocity_mps };
        // The name goes with the track that is nearer to the plot that carries it.
        if let Some(name) = new_name {
            let first = work.identities.partition_point(|(known, _)| *known < name);
            let listed = work.identities.get(first).filter(|(known, _)| *known == name);
            let holder = work.renamed.insert(name, index as u32).or(listed.map(|l| l.1));
            if let Some(other) = holder.map(|other| other as usize).filter(|&o| o != index) {
                let track = &mut self.tracks[other];
                if track.is(name) {
                    track.forget_identity();
                    track.limits = self.config.limits_of(None);
                    self.statistics.identity_conflicts += 1;
                }
            }
        }
    }
}

/// Moves the pairs that nobody disputes (the only plot of a track, in no other gate) from `pairs`, sorted by
/// track, to `single`.
fn part_undisputed(
    pairs: &mut Vec<Pair>,
    plots: usize,
    claims: &mut Vec<u32>,
    single: &mut Vec<Pair>,
) {
    claims.clear();
    claims.resize(plots, 0);
    pairs.iter().for_each(|pair| claims[pair.plot as usize] += 1);
    let (mut kept, mut before) = (0, u32::MAX);
    for k in 0..pairs.len() {
        let pair = pairs[k];
        let alone =
            pair.track != before && pairs.get(k + 1).is_none_or(|next| next.track != pair.track);
        before = pair.track;
        if alone && claims[pair.plot as usize] == 1 {
            single.push(pair);
        } else {
            pairs[kept] = pair;
            kept += 1;
        }
    }
    pairs.truncate(kept);
}

/// How a plot is given to a track.
#[derive(Clone, Copy, Debug)]
pub(super) enum How<'a> {
    /// As an ordinary plot.
    Plot,
    /// As one that only the kinematic gate accepted.
    Manoeuvre,
    /// With an earlier one, as a new beginning.
    Restart(&'a Plot),
    /// With others and the probability of each; `hit`: one of them is likelier than none.
    Weighted { plots: &'a [(Plot, f64)], hit: bool },
}

/// For so long after the last plot with its name that a track took, the name is its own, s.
const NAME_HOLDS_S: f64 = 3.0;

/// No plot.
const NONE: u32 = u32::MAX;

/// ln 2π.
const LN_TAU: f64 = 1.837_877_066_409_345_3;

/// ln of the odds from which on a single plot is taken for certain, or not at all.
const CERTAIN: f64 = 4.0;

/// Marginals below this are left out of an update.
const HOPELESS: f64 = 1e-3;

/// A plot that is a track's with this probability, in a cluster too large for more, is taken as its own.
const STANDS_OUT: f64 = 0.25;

/// Clusters of up to this many tracks are assigned by the dense solver.
const FEW_ROWS: usize = 8;

/// Rungs whose update takes no more evaluations than this are never merged.
pub(super) const MERGED_ABOVE: u64 = 30;

/// Evaluations of the exact marginals of a cluster: forward and backward over the sets of used plots.
fn exact_cost(tracks: usize, plots: usize) -> u64 {
    let sets = 1u64.checked_shl(plots as u32).unwrap_or(u64::MAX);
    sets.saturating_mul((tracks * plots) as u64) / 2
}

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
    fn log_like(&self, nis: &Nis) -> f64 {
        let ln_det = nis.ln_det() + f64::from(nis.dof) * LN_TAU;
        self.log_hit - 0.5 * (nis.d2 + ln_det)
    }

    /// How much better than a miss the pair is.
    fn gain(&self, nis: &Nis) -> f64 {
        self.log_like(nis) - self.log_miss
    }

    /// True only if [`Self::gain`] is above `least`: a determinant is below the next power of two.
    fn surely_above(&self, nis: &Nis, least: f64) -> bool {
        let exponent = (nis.det.to_bits() >> 52) as i32 - 1022;
        let most = f64::from(exponent) * std::f64::consts::LN_2 + f64::from(nis.dof) * LN_TAU;
        self.log_hit - 0.5 * (nis.d2 + most) - self.log_miss > least + 1e-9
    }
}

/// Rows and columns of one cluster.
#[derive(Clone, Debug, Default)]
pub(super) struct Local {
    tracks: Vec<u32>,
    plots: Vec<u32>,
    log_miss: Vec<f64>,
    log_like: Vec<f64>,
    beta: Vec<f64>,
    costs: Vec<Option<f64>>,
    edges: Vec<Edge>,
    found: Vec<Option<u32>>,
}

impl Local {
    /// Lists the pairs of the cluster, sorted by track, by row and column.
    fn list(&mut self, cluster: &[Pair], weights: &Weights) {
        let mut edges = std::mem::take(&mut self.edges);
        edges.clear();
        edges.extend(cluster.iter().map(|pair| {
            let (row, column) = self.place(pair);
            Edge { row: row as u32, column: column as u32, gain: weights.gain(&pair.nis) }
        }));
        self.edges = edges;
    }

    /// Whether exact association is within the limit of the method and a quarter of the scan's budget.
    fn is_exact(&self, limit: usize, work: &Work) -> bool {
        let (tracks, plots) = (self.tracks.len(), self.plots.len());
        let states = 1usize.checked_shl(plots as u32).and_then(|sets| sets.checked_mul(tracks));
        plots < usize::BITS as usize
            && states.is_some_and(|states| states <= limit)
            && exact_cost(tracks, plots) <= work.budget.left_of(0.5) / 4
    }

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
