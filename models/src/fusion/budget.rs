//! What a scan may cost, counted in evaluations of ten nanoseconds by a table, never by a clock: the same input gives
//! the same result on every machine.

use super::config::TrackingConfig;

/// One evaluation: this many make a millisecond on the machine that the table was made on.
const PER_MS: f64 = 1e5;

/// See the module's text.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Budget {
    whole: u64,
    spent: u64,
    update: u64,
    gate: u64,
}

impl Budget {
    /// The budget of one scan; it is kept to by cheaper forms of each stage, not by stopping.
    pub(super) fn new(config: &TrackingConfig) -> Self {
        let whole = (config.scan_budget_ms.clamp(0.0, 1e6) * PER_MS) as u64;
        let update = config.filter.rung.declared().cost;
        Self { whole, spent: 0, update, gate: update.div_ceil(6) }
    }

    pub(super) fn begin(&mut self) {
        self.spent = 0;
    }

    /// Evaluations so far in this scan.
    pub(super) fn spent(&self) -> u64 {
        self.spent
    }

    #[inline]
    pub(super) fn spend(&mut self, evaluations: u64) {
        self.spent = self.spent.saturating_add(evaluations);
    }

    /// What is left of this share of the budget.
    pub(super) fn left_of(&self, share: f64) -> u64 {
        ((self.whole as f64 * share) as u64).saturating_sub(self.spent)
    }

    /// A gate at one plot.
    #[inline]
    pub(super) fn gate(&self) -> u64 {
        self.gate
    }

    /// An update with one plot.
    #[inline]
    pub(super) fn update(&self) -> u64 {
        self.update
    }

    /// Whether updates can be made cheaper at all.
    pub(super) fn dear(&self) -> bool {
        self.update > MERGED_ABOVE
    }

    /// Whether so many tracks (gated, updated and published once each) leave half of the budget to the rest.
    pub(super) fn bears(&self, tracks: usize) -> bool {
        let each = 30 + self.update * 5 / 2;
        (tracks as u64).saturating_mul(each) <= self.whole / 2
    }
}

/// Rungs whose update takes no more evaluations than this are never merged.
pub(super) const MERGED_ABOVE: u64 = 30;
