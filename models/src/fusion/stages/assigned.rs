//! Which of its gated plots each track gets: nearest, by clusters, jointly, or by somebody's own rule.

use super::gated::trace;
use super::updated::How;
use crate::association::certificate;
use crate::association::jpda::JpdaError;
use crate::association::lbp;
use crate::association::nearest::{self, Pair};
use crate::fusion::buffers::Look;
use crate::fusion::config::{AssociationMethod, SensorModel};
use crate::fusion::filter::predict;
use crate::fusion::own::{Association, GatedPair};
use crate::fusion::state::{Tracker, Work};
use crate::fusion::track_file::Stage;
use crate::fusion::weights::{FEW_ROWS, Local, Weights, exact_cost};
use std::collections::BTreeSet;

impl Tracker {
    /// Covariance gate and association of all tracks of one stage.
    pub(in crate::fusion) fn take_gated(
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
        if stage == Stage::Confirmed {
            self.weigh_existence(model, work);
            self.weigh_strength(from, to, model, work);
        } else {
            work.shifts.clear();
        }
        work.plot_used.clear();
        work.plot_used.resize(to - from, false);
        for &index in &work.crowd.tracks {
            self.tracks[index as usize].unresolved = true;
        }
        self.statistics.crowded += work.crowd.tracks.len() as u64;
        if let (Some(own), Stage::Confirmed) = (self.association.clone(), stage) {
            return self.take_by(&*own, from, model, work);
        }
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

    /// What somebody's own rule makes of the gated pairs; one plot a track and one track a plot, whatever it says.
    fn take_by(
        &mut self,
        own: &dyn Association,
        from: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let pairs = std::mem::take(&mut work.pairs);
        let shown: Vec<GatedPair> = pairs
            .iter()
            .map(|p| GatedPair {
                track: p.track,
                plot: p.plot,
                d2: p.nis.d2,
                ln_det: p.nis.ln_det(),
                dof: p.nis.dof,
            })
            .collect();
        for pair in own.assign(&shown).into_iter().filter_map(|place| pairs.get(place)) {
            let (track, k) = (pair.track as usize, from + pair.plot as usize);
            if !work.track_used[track] && !work.used[k] {
                self.update(track, How::Plot, k, model, work);
            }
        }
        work.pairs = pairs;
    }

    pub(in crate::fusion) fn take_nearest(
        &mut self,
        from: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
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
    pub(in crate::fusion) fn take_by_cluster(
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
            let shift = work.shifts.of(pair);
            if weights.surely_above(&pair.nis, certain - shift) {
                self.update(pair.track as usize, How::Plot, k, model, work);
                continue;
            }
            let gain = weights.gain(&pair.nis) + shift;
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

    pub(in crate::fusion) fn take_globally(
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
                costs[row * columns + column] =
                    Some(-weights.gain(&pair.nis) - work.shifts.of(pair));
            }
            let pairs = work
                .solver
                .pairs_and_misses(rows, columns, |row, column| costs[row * columns + column]);
            found.extend(pairs.iter().map(|c| c.map(|c| c as u32)));
            work.budget.spend((rows * rows * (rows + columns)) as u64);
            local.costs = costs;
        } else {
            local.list(cluster, weights, &work.shifts);
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
    pub(in crate::fusion) fn take_jointly(
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
        if !local.is_exact(limit, &work.budget) {
            self.statistics.large_clusters += 1;
            self.take_by_belief(from, limit, cluster, weights, local, model, work);
            return;
        }
        local.log_like.clear();
        local.log_like.resize(rows * columns, f64::NEG_INFINITY);
        for pair in cluster {
            let (row, column) = local.place(pair);
            local.log_like[row * columns + column] =
                weights.log_like(&pair.nis) + work.shifts.of(pair);
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
        let rows = local.beta.chunks_exact(local.plots.len() + 1).enumerate();
        let rows = rows.map(|(row, beta)| (row, beta[0], (0..).zip(beta[1..].iter().copied())));
        self.take_rows(from, local, rows, model, work);
    }

    /// Updates tracks of a cluster: of each its row, the probability that it was missed, and its plots (their columns) with theirs.
    pub(in crate::fusion) fn take_rows<S: Iterator<Item = (u32, f64)> + Clone>(
        &mut self,
        from: usize,
        local: &Local,
        rows: impl Iterator<Item = (usize, f64, S)>,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let mut claimed = std::mem::take(&mut work.claimed);
        claimed.clear();
        claimed.resize(local.plots.len(), 0.0);
        for (row, missed, shares) in rows {
            shares.clone().for_each(|(column, share)| claimed[column as usize] += share);
            let shares = shares.map(|(column, share)| (local.plots[column as usize], share));
            self.take_weighted(from, local.tracks[row], missed, shares, model, work);
        }
        // A plot that the tracks claim with more than even odds is used up.
        for (plot, claimed) in local.plots.iter().zip(&claimed) {
            work.used[from + *plot as usize] |= *claimed > 0.5;
        }
        work.claimed = claimed;
    }

    /// A cluster that is too large to be done exactly: belief propagation over its pairs. Where dropping the pairs that
    /// it holds for hopeless leaves pieces that are small enough, those are done exactly.
    #[expect(clippy::too_many_arguments, reason = "one step of the batch, with its buffers")]
    pub(in crate::fusion) fn take_by_belief(
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
        local.list(cluster, weights, &work.shifts);
        let mut belief = std::mem::take(&mut work.belief);
        // An edge and sweep is an evaluation; four sweeps are always made.
        let fitting = work.budget.left_of(0.5) / (local.edges.len() as u64).max(1);
        let sweeps = fitting.clamp(4, lbp::MOST_SWEEPS.into()) as u32;
        let ended = belief.run(rows, columns, &local.edges, sweeps, lbp::STILL);
        work.budget.spend(u64::from(ended.sweeps) * local.edges.len() as u64);
        self.statistics.sweeps += u64::from(ended.sweeps);
        self.certify(rows, columns, &local.edges, work);
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
            if part.is_exact(limit, &work.budget) {
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
        work.hurried = rows > MANY_ROWS;
        let left = (0..rows).filter(|&row| !done[row] && !exact.contains(&local.tracks[row]));
        let (found, edges) = (&belief, &local.edges);
        let left = left.map(|row| {
            let shares = found.edges_of(row).map(move |e| (edges[e].column, found.share(row, e)));
            (row, found.miss(row), shares)
        });
        self.take_rows(from, local, left, model, work);
        work.hurried = false;
        work.belief = belief;
    }

    /// Counts of how many tracks of a cluster the best plot is certain, whatever belief propagation makes of it.
    fn certify(&mut self, rows: usize, columns: usize, edges: &[lbp::Edge], work: &mut Work) {
        self.statistics.believed += rows as u64;
        let laying = 4 * edges.len() as u64;
        let Some(left) = work.budget.left_aside().checked_sub(laying) else { return };
        work.certificate.lay_out(rows, columns, edges);
        let said = work.certificate.of_cluster(left.saturating_mul(certificate::TERMS));
        work.budget.spend_aside(laying + work.certificate.terms() / certificate::TERMS);
        self.statistics.certified += said.tracks;
        self.statistics.certain += said.certain;
    }

    /// Updates track `index` with the plots (their places in the batch) of its row of marginals.
    pub(in crate::fusion) fn take_weighted(
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
        let Some(filter) = self.tracks[index].way.filter_before(time, &self.ring) else { return };
        let gaps = self.tracks[index].way.gaps(&self.config);
        let Ok(at) = predict(filter, time, gaps) else { return };
        let velocity = at.velocity_mps();
        let mut plots = std::mem::take(&mut work.weighted);
        plots.clear();
        for (plot, share) in shares.filter(|&(plot, share)| plot == best || share > HOPELESS) {
            let mut moved = work.candidates[from + plot as usize].plot;
            moved.position_m += velocity * time.since_s(moved.time);
            moved.time = time;
            plots.push((moved, share));
        }
        // Where nothing can be told apart and time is short, the likeliest few say as much.
        if (work.light || work.hurried) && plots.len() > FEW_IN_LIGHT {
            plots.sort_by(|a, b| b.1.total_cmp(&a.1));
            plots.truncate(FEW_IN_LIGHT);
        }
        let how = How::Weighted { plots: &plots, hit: missed < 0.5 };
        self.update(index, how, k, model, work);
        work.weighted = plots;
    }

    /// Gives tracks that were cut off from some plots, and have none, one that nobody has: within a cell of the grid
    /// the first track the first plot, both in the order of their places. Nothing can be told apart there; no track
    /// shall die of it, and no plot begin one.
    pub(in crate::fusion) fn pair_by_rank(
        &mut self,
        from: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        if work.crowd.tracks.is_empty() {
            return;
        }
        let mut tracks: Vec<(usize, u64, u32)> = Vec::new();
        for &index in &work.crowd.tracks {
            let track = &self.tracks[index as usize];
            if work.track_used[index as usize] {
                continue;
            }
            if let Some(search) = self.search_box(track, work.span, work.widest_m2) {
                let (cell, within) = work.plots.cell_at(search.ends[1]);
                tracks.push((cell, within, index));
            }
        }
        let mut plots: Vec<(usize, u64, u32)> = Vec::new();
        for (place, look) in work.looks.iter().enumerate() {
            if !work.used[look.k as usize] {
                let (cell, within) = work.plots.cell_at(look.position_m);
                plots.push((cell, within, place as u32));
            }
        }
        tracks.sort_unstable();
        plots.sort_unstable();
        let mut next = 0;
        for (cell, _, index) in tracks {
            while next < plots.len() && plots[next].0 < cell {
                next += 1;
            }
            let Some(&(_, _, place)) = plots.get(next).filter(|plot| plot.0 == cell) else {
                continue;
            };
            let Look { time, measured, position_m, k, .. } = work.looks[place as usize];
            let (track, plot) = (&self.tracks[index as usize], &work.candidates[k as usize].plot);
            let Some(m) = measured.filter(|_| track.may_be(plot.identity)) else { continue };
            work.budget.spend(if work.light { 10 } else { work.budget.gate() });
            let found = self.distance(track, time, plot, &m);
            let near = if track.plots == 1 {
                let way = track.limits.speed_mps * time.since_s(track.time()).abs();
                let first = track.filter().motion().0;
                (position_m - first).norm() <= way + 3.0 * trace(plot).sqrt()
            } else {
                found.is_some_and(|nis| nis.d2 <= self.gate_1)
            };
            if near && found.is_some() && k as usize >= from {
                next += 1;
                self.statistics.paired_by_rank += 1;
                self.update(index as usize, How::Plot, k as usize, model, work);
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

/// No plot.
const NONE: u32 = u32::MAX;

/// ln of the odds from which on a single plot is taken for certain, or not at all.
const CERTAIN: f64 = 4.0;

/// Marginals below this are left out of an update.
const HOPELESS: f64 = 1e-3;

/// A plot that is a track's with this probability, in a cluster too large for more, is taken as its own.
const STANDS_OUT: f64 = 0.25;

/// A cluster of more tracks is hurried through.
const MANY_ROWS: usize = 2_000;

/// Plots of one update that are weighed in a scan that has to be made cheaper.
const FEW_IN_LIGHT: usize = 3;
