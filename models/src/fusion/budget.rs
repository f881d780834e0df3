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
    aside: u64,
}

impl Budget {
    /// The budget of one scan; it is kept to by cheaper forms of each stage, not by stopping.
    pub(super) fn new(config: &TrackingConfig) -> Self {
        let whole = (config.scan_budget_ms.clamp(0.0, 1e6) * PER_MS) as u64;
        let update = config.filter.rung.declared().cost;
        Self { whole, spent: 0, update, gate: update.div_ceil(6), aside: 0 }
    }

    pub(super) fn begin(&mut self) {
        (self.spent, self.aside) = (0, 0);
    }

    /// Evaluations so far in this scan.
    pub(super) fn spent(&self) -> u64 {
        self.spent.saturating_add(self.aside)
    }

    /// What is left in this scan for what only reports and decides nothing: a twentieth of the budget, of which what decides is told
    /// nothing.
    pub(super) fn left_aside(&self) -> u64 {
        (self.whole / 20).saturating_sub(self.aside)
    }

    /// Evaluations of what only reports.
    pub(super) fn spend_aside(&mut self, evaluations: u64) {
        self.aside = self.aside.saturating_add(evaluations);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn of(whole: u64, spent: u64, update: u64) -> Budget {
        Budget { whole, spent, update, gate: 0, aside: 0 }
    }

    #[test]
    fn a_scan_of_so_many_milliseconds_is_a_hundred_thousand_evaluations_each() {
        let mut config = TrackingConfig::paper();
        for (scan_budget_ms, whole) in
            [(1.0, 100_000), (50.0, 5_000_000), (-3.0, 0), (1e9, 100_000_000_000)]
        {
            config.scan_budget_ms = scan_budget_ms;
            let budget = Budget::new(&config);
            assert_eq!((budget.left_of(1.0), budget.spent()), (whole, 0));
            // A gate is a sixth of an update, or a little more.
            let (gate, update) = (budget.gate(), budget.update());
            assert_eq!(update, config.filter.rung.declared().cost);
            assert!(6 * gate >= update && 6 * gate < update + 6, "{gate} {update}");
        }
    }

    #[test]
    fn what_is_left_is_of_a_share_and_never_less_than_nothing() {
        let mut budget = of(1_000, 0, 10);
        budget.spend(300);
        budget.spend(50);
        assert_eq!((budget.spent(), budget.left_of(1.0), budget.left_of(0.5)), (350, 650, 150));
        assert_eq!(budget.left_of(0.25), 0);
        budget.spend(u64::MAX);
        assert_eq!((budget.spent(), budget.left_of(1.0)), (u64::MAX, 0));
        budget.begin();
        assert_eq!(budget.left_of(1.0), 1_000);
    }

    #[test]
    fn what_only_reports_has_a_twentieth_and_takes_nothing_from_what_decides() {
        let mut budget = of(1_000, 0, 10);
        budget.spend(900);
        budget.spend_aside(30);
        assert_eq!((budget.left_aside(), budget.spent(), budget.left_of(1.0)), (20, 930, 100));
        budget.spend_aside(21);
        assert_eq!((budget.left_aside(), budget.spent(), budget.left_of(1.0)), (0, 951, 100));
        budget.begin();
        assert_eq!((budget.left_aside(), budget.spent()), (50, 0));
    }

    #[test]
    fn so_many_tracks_are_borne_as_leave_half_of_it() {
        // An update of 40 is 130 in all: a gate, two updates and a half.
        assert!(
            of(2_600, 0, 40).bears(10)
                && !of(2_599, 0, 40).bears(10)
                && !of(2_600, 0, 40).bears(11)
        );
        assert!(of(0, 0, 40).bears(0) && !of(u64::MAX, 0, u64::MAX / 8).bears(usize::MAX));
        assert!(!of(1, 0, MERGED_ABOVE).dear() && of(1, 0, MERGED_ABOVE + 1).dear());
    }
}
