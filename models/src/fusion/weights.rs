//! How likely pairs of tracks and plots of one sensor are, and the rows and columns of one cluster of them.

use super::budget::Budget;
use super::config::SensorModel;
use crate::association::lbp::Edge;
use crate::association::nearest::Pair;
use crate::filter::Nis;

/// ln 2π.
const LN_TAU: f64 = 1.837_877_066_409_345_3;

/// Evaluations of the exact marginals of a cluster: forward and backward over the sets of used plots.
pub(super) fn exact_cost(tracks: usize, plots: usize) -> u64 {
    let sets = 1u64.checked_shl(plots as u32).unwrap_or(u64::MAX);
    sets.saturating_mul((tracks * plots) as u64) / 2
}

/// Weights of pairs and misses of one sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// `ln(1 − P_D P_G)`
    pub(super) log_miss: f64,
    /// `ln P_D − ln λ`
    pub(super) log_hit: f64,
}

impl Weights {
    pub(super) fn new(model: &SensorModel, gate_probability: f64) -> Self {
        let detection = model.detection.clamp(1e-6, 1.0 - 1e-6);
        let density = model.false_density_m2.clamp(1e-15, 1e3);
        Self {
            log_miss: libm::log1p(-detection * gate_probability.clamp(0.0, 1.0)),
            log_hit: libm::log(detection) - libm::log(density),
        }
    }

    /// `ln P_D − ½(d² + ln det 2πS) − ln λ`
    pub(super) fn log_like(&self, nis: &Nis) -> f64 {
        let ln_det = nis.ln_det() + f64::from(nis.dof) * LN_TAU;
        self.log_hit - 0.5 * (nis.d2 + ln_det)
    }

    /// How much better than a miss the pair is.
    pub(super) fn gain(&self, nis: &Nis) -> f64 {
        self.log_like(nis) - self.log_miss
    }

    /// True only if [`Self::gain`] is above `least`: a determinant is below the next power of two.
    pub(super) fn surely_above(&self, nis: &Nis, least: f64) -> bool {
        let exponent = (nis.det.to_bits() >> 52) as i32 - 1022;
        let most = f64::from(exponent) * std::f64::consts::LN_2 + f64::from(nis.dof) * LN_TAU;
        self.log_hit - 0.5 * (nis.d2 + most) - self.log_miss > least + 1e-9
    }
}

/// What is added to ln of the weight of a pair.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Shifts {
    /// Of each track: as it exists and is seen; empty where lives go by counts.
    pub(super) tracks: Vec<f64>,
    /// Of each plot of the batch: as strong as it is; empty where that says nothing.
    pub(super) plots: Vec<f64>,
}

impl Shifts {
    pub(super) fn clear(&mut self) {
        self.tracks.clear();
        self.plots.clear();
    }

    pub(super) fn of(&self, pair: &Pair) -> f64 {
        let found = |list: &[f64], place: u32| list.get(place as usize).copied().unwrap_or(0.0);
        found(&self.tracks, pair.track) + found(&self.plots, pair.plot)
    }
}

/// Rows and columns of one cluster.
#[derive(Clone, Debug, Default)]
pub(super) struct Local {
    pub(super) tracks: Vec<u32>,
    pub(super) plots: Vec<u32>,
    pub(super) log_miss: Vec<f64>,
    pub(super) log_like: Vec<f64>,
    pub(super) beta: Vec<f64>,
    pub(super) costs: Vec<Option<f64>>,
    pub(super) edges: Vec<Edge>,
    pub(super) found: Vec<Option<u32>>,
}

impl Local {
    /// Lists the pairs of the cluster, sorted by track, by row and column.
    pub(super) fn list(&mut self, cluster: &[Pair], weights: &Weights, shifts: &Shifts) {
        let mut edges = std::mem::take(&mut self.edges);
        edges.clear();
        edges.extend(cluster.iter().map(|pair| {
            let (row, column) = self.place(pair);
            let gain = weights.gain(&pair.nis) + shifts.of(pair);
            Edge { row: row as u32, column: column as u32, gain }
        }));
        self.edges = edges;
    }

    /// Whether exact association is within the limit of the method and a quarter of the scan's budget.
    pub(super) fn is_exact(&self, limit: usize, budget: &Budget) -> bool {
        let (tracks, plots) = (self.tracks.len(), self.plots.len());
        let states = 1usize.checked_shl(plots as u32).and_then(|sets| sets.checked_mul(tracks));
        plots < usize::BITS as usize
            && states.is_some_and(|states| states <= limit)
            && exact_cost(tracks, plots) <= budget.left_of(0.5) / 4
    }

    pub(super) fn fill(&mut self, cluster: &[Pair]) {
        self.tracks.clear();
        self.tracks.extend(cluster.iter().map(|p| p.track));
        self.tracks.sort_unstable();
        self.tracks.dedup();
        self.plots.clear();
        self.plots.extend(cluster.iter().map(|p| p.plot));
        self.plots.sort_unstable();
        self.plots.dedup();
    }

    pub(super) fn place(&self, pair: &Pair) -> (usize, usize) {
        let row = self.tracks.partition_point(|&t| t < pair.track);
        (row, self.plots.partition_point(|&p| p < pair.plot))
    }
}

/// Clusters of up to this many tracks are assigned by the dense solver.
pub(super) const FEW_ROWS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fusion::config::TrackingConfig;
    use crate::plot::{SensorId, SensorKind};

    #[test]
    fn a_cluster_is_exact_within_the_limit_of_states_and_an_eighth_of_the_budget() {
        let of = |tracks: u32, plots: u32| {
            let pairs = (0..tracks).flat_map(|track| (0..plots).map(move |plot| (track, plot)));
            let nis = Nis { d2: 0.0, det: 1.0, dof: 2 };
            let pairs: Vec<_> =
                pairs.map(|(track, plot)| Pair { track: 3 * track, plot: 2 * plot, nis }).collect();
            let mut local = Local::default();
            local.fill(&pairs);
            assert_eq!(
                local.place(&pairs[pairs.len() - 1]),
                (tracks as usize - 1, plots as usize - 1)
            );
            assert_eq!((local.tracks.len(), local.plots.len()), (tracks as usize, plots as usize));
            local
        };
        // Five tracks and four plots: 80 states, 160 evaluations.
        assert_eq!((exact_cost(5, 4), exact_cost(1, 64)), (160, u64::MAX / 2));
        let mut config = TrackingConfig { scan_budget_ms: 0.0128, ..TrackingConfig::paper() };
        let budget = Budget::new(&config);
        assert_eq!(budget.left_of(0.5), 640);
        assert!(of(5, 4).is_exact(80, &budget) && !of(5, 4).is_exact(79, &budget));
        config.scan_budget_ms = 0.01278;
        assert!(!of(5, 4).is_exact(80, &Budget::new(&config)));
        config.scan_budget_ms = 1e6;
        assert!(!of(1, 64).is_exact(usize::MAX, &Budget::new(&config)));
    }

    #[test]
    fn weights_are_those_of_the_textbook() {
        let model = SensorModel {
            detection: 0.9,
            false_density_m2: 1e-5,
            ..SensorModel::default_of(SensorId(1), SensorKind::Asde)
        };
        let weights = Weights::new(&model, 0.99);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} for {b}");
        close(weights.log_miss, libm::log(1.0 - 0.9 * 0.99));
        close(weights.log_hit, libm::log(0.9e5));
        // One axis of variance 4 at one deviation: the density of a normal distribution there.
        let density = libm::exp(-0.5) / (2.0 * std::f64::consts::PI * 4.0).sqrt();
        close(weights.log_like(&Nis { d2: 1.0, det: 4.0, dof: 1 }), libm::log(0.9e5 * density));
        let both = Nis { d2: 1.0, det: 4.0, dof: 2 };
        close(
            weights.gain(&both),
            libm::log(0.9e5 * libm::exp(-0.5) / (4.0 * std::f64::consts::PI) / 0.109),
        );
        let pair = |track| Pair { track, plot: 0, nis: both };
        let mut shifts = Shifts { tracks: vec![0.5, -2.0], plots: vec![] };
        assert_eq!([0, 1, 2].map(|t| shifts.of(&pair(t))), [0.5, -2.0, 0.0]);
        shifts.plots = vec![0.25];
        assert_eq!([0, 1, 2].map(|t| shifts.of(&pair(t))), [0.75, -1.75, 0.25]);
        // Nothing is certain.
        let sure = SensorModel { detection: 1.0, false_density_m2: 0.0, ..model };
        let weights = Weights::new(&sure, 1.0);
        close(weights.log_miss, libm::log(1e-6));
        close(weights.log_hit, libm::log(1e15 * (1.0 - 1e-6)));
        let blind =
            Weights::new(&SensorModel { detection: 0.0, false_density_m2: 1e9, ..model }, 7.0);
        close(blind.log_hit, libm::log(1e-9));
        close(blind.log_miss, -1e-6);
    }

    #[test]
    fn a_cluster_is_listed_by_row_and_column_with_its_gains() {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        let weights = Weights::new(&model, 0.999);
        let nis = Nis { d2: 1.0, det: 4.0, dof: 2 };
        let pairs = [(4, 9), (4, 7), (6, 9)].map(|(track, plot)| Pair { track, plot, nis });
        let mut local = Local::default();
        local.fill(&pairs);
        let tracks = vec![0.0, 0.0, 0.0, 0.0, 0.25];
        local.list(&pairs, &weights, &Shifts { tracks, plots: vec![] });
        let edge = |row, column, more| Edge { row, column, gain: weights.gain(&nis) + more };
        assert_eq!(local.edges, [edge(0, 1, 0.25), edge(0, 0, 0.25), edge(1, 1, 0.0)]);
    }

    /// What is said without a logarithm is never said in vain, and hardly ever left unsaid: a determinant is within a factor
    /// of two of the power that stands for it.
    #[test]
    fn what_is_surely_above_is_above_and_what_is_well_above_is_surely_so() {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        let weights = Weights::new(&model, 0.999);
        let (mut sure, mut unsure) = (0, 0);
        for step in 0..4_000 {
            let det = libm::exp2(f64::from(step % 97) * 0.37 - 12.0);
            let d2 = f64::from(step % 41) * 0.5;
            for dof in [1, 2] {
                let nis = Nis { d2, det, dof };
                for above in [-0.4, -0.3, -1e-3, 0.0, 1e-3, 0.3, 0.4] {
                    let least = weights.gain(&nis) - above;
                    if weights.surely_above(&nis, least) {
                        assert!(above > 0.0, "{nis:?}: {above}");
                        sure += 1;
                    } else {
                        assert!(above < 0.5 * std::f64::consts::LN_2 + 1e-6, "{nis:?}: {above}");
                        unsure += 1;
                    }
                }
            }
        }
        assert!(sure > 8_000 && unsure > 8_000, "{sure} {unsure}");
    }
}
