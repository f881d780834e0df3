//! What the targets of a scene cost by the table.

use super::result::SceneResult;
use models::sensors::asde::Asde;
use models::sensors::asde::plan::Kind;
use models::sensors::radar::effects::RadarEffect;
use std::collections::BTreeMap;

/// Costs of targets by the table, summed over scans.
#[derive(Clone, Debug, Default)]
pub(super) struct Costs {
    targets: f64,
    exact_ns: f64,
    there_ns: f64,
    planned_ns: f64,
    by_effect: BTreeMap<RadarEffect, (f64, f64)>,
}

impl Costs {
    /// Adds the targets that a planned radar had in its boxes in its last scan.
    pub(super) fn add(&mut self, radar: &Asde) {
        for planned in radar.planner().boxes().iter().filter(|b| b.targets > 0) {
            let n = f64::from(planned.targets);
            let (cost, all) = planned.plan.cost_ns();
            let not_done =
                planned.plan.saved_ns(Kind::NotThere) + planned.plan.saved_ns(Kind::Table);
            self.targets += n;
            self.exact_ns += n * all as f64;
            self.there_ns += n * (all - not_done) as f64;
            self.planned_ns += n * cost as f64;
            for effect in &planned.plan.effects {
                let saved = effect.exact_ns.saturating_sub(effect.cost_ns);
                let left = if effect.kind == Kind::LeftOut { saved } else { 0 };
                let of = self.by_effect.entry(effect.effect).or_default();
                of.0 += n * f64::from(effect.cost_ns);
                of.1 += n * f64::from(left);
            }
        }
    }

    /// Exact, without what is not there and tables, and planned; and effect by effect.
    pub(super) fn tell(&self, result: &mut SceneResult) {
        let per = |x: f64| x / self.targets.max(1.0);
        result.cost_ns = (per(self.exact_ns), per(self.there_ns), per(self.planned_ns));
        let rows = self.by_effect.iter().map(|(effect, of)| (*effect, per(of.0), per(of.1)));
        result.by_effect = rows.collect();
    }
}
