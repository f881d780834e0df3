//! The plan of a scene at one time, as an engineer reads it and as programs do.

use models::effects::{Level, PlanRow, Tolerance};
use models::environment::Weather;
use models::sensors::Sensor;
use models::sensors::asde::Placed;
use models::sensors::asde::plan::boxes::band_m;
use models::sensors::asde::plan::{BoxEffect, BoxPlan, Fitted, Kind, PlannedBox};
use models::sensors::radar::costs;
use models::sensors::radar::effects::RadarEffect;
use models::sensors::radar::equation::Reflection;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// One sensor of a scene at one time.
#[derive(Clone, Debug)]
pub(super) struct SensorPlan {
    /// Its name in the scene.
    pub(super) name: String,
    /// The rows of its plan.
    pub(super) rows: Vec<PlanRow>,
    /// Of a radar: its boxes.
    boxes: Vec<PlannedBox>,
    /// Of a radar: the targets that it displays, with their names.
    placed: Vec<(Placed, String)>,
    /// Of a radar: those that it does not display.
    hidden: Vec<String>,
    is_radar: bool,
    tolerance: Tolerance,
    /// With a budget of time: what it came to.
    fitted: Option<Fitted>,
}

/// What the effects of a radar cost a target on average, ns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Costs {
    exact: f64,
    tables: f64,
    not_there: f64,
    left_out: f64,
    simulated: f64,
}

impl Costs {
    /// Share of what is there beyond tables that is left out, %.
    fn left_out_percent(&self) -> f64 {
        100.0 * self.left_out / (self.left_out + self.simulated).max(1e-9)
    }
}

/// Effects that are decided for each target by what is around it, not by its box.
const AROUND: [RadarEffect; 3] =
    [RadarEffect::BuildingShadow, RadarEffect::AircraftShadow, RadarEffect::Merging];

/// What refines the surface reflection.
const REFINING: [RadarEffect; 5] = [
    RadarEffect::Lobing,
    RadarEffect::Roughness,
    RadarEffect::WaterFilm,
    RadarEffect::ReflectedPolarisation,
    RadarEffect::RoundEarth,
];

/// What is simulated where an effect is left out, if not nothing.
fn instead(effect: RadarEffect, found: &[&BoxEffect]) -> &'static str {
    match effect {
        RadarEffect::SurfaceReflection => "with all that refines it",
        RadarEffect::RainAttenuation if found.iter().any(|e| e.level == Level::Cheap) => {
            "straight-line law for some"
        }
        RadarEffect::ReflectedPolarisation => "horizontal coefficient",
        _ => "",
    }
}

impl SensorPlan {
    /// Of a sensor that has scanned; `names` are those of the truth, by place.
    pub(super) fn of(
        name: &str,
        sensor: &dyn Sensor,
        names: &dyn Fn(usize) -> String,
        tolerance: Tolerance,
    ) -> Self {
        let named = sensor.placed().iter().map(|p| (*p, names(p.index)));
        let (placed, hidden): (Vec<_>, Vec<_>) = named.partition(|(p, _)| p.shown);
        Self {
            name: name.to_owned(),
            rows: sensor.plan().to_vec(),
            boxes: sensor.boxes().to_vec(),
            placed,
            hidden: hidden.into_iter().map(|(_, name)| name).collect(),
            is_radar: sensor.kind().radar,
            tolerance,
            fitted: sensor.fitted(),
        }
    }

    fn plan_of(&self, placed: &Placed) -> Option<&BoxPlan> {
        if placed.paired {
            return None;
        }
        placed.place.map(|place| &self.boxes[place as usize].plan)
    }

    /// Whether an effect is not there for any target that is in a box: then for none.
    fn is_nowhere(&self, effect: RadarEffect) -> bool {
        let planned = || self.placed.iter().filter_map(|(p, _)| self.plan_of(p));
        planned().count() > 0
            && planned().all(|plan| {
                plan.effects.iter().any(|e| e.effect == effect && e.kind == Kind::NotThere)
            })
    }

    /// Cost of the exact level of an effect in this weather, ns a target.
    fn exact_ns(&self, effect: RadarEffect) -> f64 {
        let mut own = self.boxes.iter().flat_map(|b| &b.plan.effects);
        let own = own.find(|e| e.effect == effect).map(|e| f64::from(e.exact_ns));
        own.unwrap_or_else(|| costs::of(effect, Level::Exact))
    }

    fn costs(&self) -> Costs {
        let mut sum = Costs::default();
        let there = |effect: RadarEffect| {
            self.rows.iter().any(|r| r.effect == effect.name() && !r.is_skipped())
        };
        for (placed, _) in &self.placed {
            for effect in RadarEffect::ALL.iter().copied() {
                let exact = self.exact_ns(effect);
                let own = self
                    .plan_of(placed)
                    .and_then(|plan| plan.effects.iter().find(|e| e.effect == effect));
                let (kind, cost) = match (effect, own) {
                    (RadarEffect::Processing | RadarEffect::SecondTrace, _) => continue,
                    (_, Some(own)) => (own.kind, f64::from(own.cost_ns)),
                    (RadarEffect::BuildingShadow, _) if !there(effect) => (Kind::NotThere, 0.0),
                    (RadarEffect::AircraftShadow, _) if !placed.shadowed => (Kind::NotThere, 0.0),
                    (RadarEffect::Merging, _) if !placed.paired => (Kind::NotThere, 0.0),
                    (RadarEffect::Detection, _) => (Kind::Table, costs::of(effect, Level::Middle)),
                    _ if self.is_nowhere(effect) => (Kind::NotThere, 0.0),
                    _ => (Kind::Exact, exact),
                };
                sum.exact += exact;
                sum.simulated += cost;
                let saved = exact - cost;
                match kind {
                    Kind::NotThere => sum.not_there += saved,
                    Kind::Table => sum.tables += saved,
                    Kind::LeftOut | Kind::Exact => sum.left_out += saved,
                }
            }
        }
        let n = self.placed.len().max(1) as f64;
        Costs {
            exact: sum.exact / n,
            tables: sum.tables / n,
            not_there: sum.not_there / n,
            left_out: sum.left_out / n,
            simulated: sum.simulated / n,
        }
    }

    /// Targets for which an effect is of a kind, and the effect in the boxes of these.
    fn with(&self, effect: RadarEffect, kind: Kind) -> (Vec<&str>, Vec<&BoxEffect>) {
        let mut names = Vec::new();
        let mut found: Vec<&BoxEffect> = Vec::new();
        for (placed, name) in &self.placed {
            let Some(plan) = self.plan_of(placed) else { continue };
            // Without the reflection there is nothing to refine.
            let reflected = plan.levels.budget.reflection != Reflection::None;
            if kind == Kind::LeftOut && REFINING.contains(&effect) && !reflected {
                continue;
            }
            if let Some(own) = plan.effects.iter().find(|e| e.effect == effect && e.kind == kind) {
                names.push(name.as_str());
                found.push(own);
            }
        }
        (names, found)
    }

    /// "all 5", "4 of 5", or the names of few.
    fn for_whom(&self, names: &[&str]) -> String {
        let all = self.placed.len();
        match names.len() {
            n if n == all => format!("all {n}"),
            1 | 2 => names.join(", "),
            n => format!("{n} of {all}"),
        }
    }

    /// The text of a radar.
    fn radar_text(&self, all_rows: bool, out: &mut String) {
        let costs = self.costs();
        let occupied = self.boxes.iter().filter(|b| b.targets > 0).count();
        let percent = |ns: f64| 100.0 * ns / costs.exact.max(1e-9);
        let _ = writeln!(
            out,
            "{}: {} targets in {occupied} boxes. {:.0} of {:.0} ns a target ({:.0} % saved: tables \
             {:.0}, not there {:.0}, left out {:.0} = {:.0} % of what is there)",
            self.name,
            self.placed.len(),
            costs.simulated,
            costs.exact,
            percent(costs.exact - costs.simulated),
            percent(costs.tables),
            percent(costs.not_there),
            percent(costs.left_out),
            costs.left_out_percent(),
        );
        if let (Some(fitted), Some(budget_us)) = (self.fitted, self.tolerance.time_budget_us) {
            let _ = writeln!(out, "  {}", promise(&fitted, budget_us, &self.tolerance));
        }
        let (mut left, mut simulated, mut absent) = (Vec::new(), Vec::new(), Vec::new());
        for effect in RadarEffect::ALL.iter().copied() {
            let (names, found) = self.with(effect, Kind::LeftOut);
            if !names.is_empty() {
                let change = Change::of(&found);
                left.push((effect.name(), self.for_whom(&names), change, instead(effect, &found)));
            }
            let (mut exactly, _) = self.with(effect, Kind::Exact);
            exactly.extend(self.with(effect, Kind::Table).0);
            let outside = self.placed.iter().filter(|(p, _)| self.plan_of(p).is_none());
            exactly.extend(outside.map(|(_, name)| name.as_str()));
            let row = self.rows.iter().find(|r| r.effect == effect.name());
            let there = row.is_some_and(|r| !r.is_skipped());
            if AROUND.contains(&effect) || effect == RadarEffect::FalseAlarms {
                let touched = |p: &Placed| match effect {
                    RadarEffect::AircraftShadow => p.shadowed,
                    RadarEffect::Merging => p.paired,
                    _ => true,
                };
                let whom = self.placed.iter().filter(|(p, _)| touched(p));
                let whom: Vec<&str> = whom.map(|(_, name)| name.as_str()).collect();
                match there {
                    true if whom.len() == self.placed.len() => {
                        simulated.push(effect.name().to_owned());
                    }
                    true => simulated.push(format!("{} ({})", effect.name(), self.for_whom(&whom))),
                    false => absent.push(effect.name()),
                }
            } else if matches!(effect, RadarEffect::Processing | RadarEffect::SecondTrace) {
            } else if self.is_nowhere(effect) {
                absent.push(effect.name());
            } else if !exactly.is_empty() {
                let whom = self.for_whom(&exactly);
                let everyone = exactly.len() == self.placed.len();
                let name = effect.name();
                simulated.push(if everyone { name.to_owned() } else { format!("{name} ({whom})") });
            }
        }
        if !left.is_empty() {
            let head =
                format!("  {:<32}{:<26}{:<24}instead", "left out", "for", "would change at most");
            let _ = writeln!(out, "{head}");
        }
        for (effect, whom, change, instead) in left {
            let line = format!("  {effect:<32}{whom:<26}{:<24}{instead}", change.to_string());
            let _ = writeln!(out, "{}", line.trim_end());
        }
        let shares = self.placed.iter().filter_map(|(p, name)| Some((self.plan_of(p)?, name)));
        if let Some((plan, name)) = shares.max_by(|a, b| a.0.share.total_cmp(&b.0.share)) {
            let o = &plan.outcome;
            let _ = writeln!(
                out,
                "  {:<32}{name:<26}{:.3} m rms, detection {:.4}, {} beyond{}",
                "together, worst target",
                o.rms_m,
                o.detection,
                small(o.tail),
                if plan.is_best { "" } else { " (search cut short)" },
            );
        }
        let list = |words: &[String]| words.join(", ");
        if !simulated.is_empty() {
            let _ = writeln!(out, "  simulated: {}", list(&simulated));
        }
        for (paired, why) in [
            (true, "beside another target, in one cell with it or nearly so"),
            (false, "near the foot of the tower"),
        ] {
            let exact = self.placed.iter().filter(|(p, _)| self.plan_of(p).is_none());
            let names: Vec<&str> =
                exact.filter(|(p, _)| p.paired == paired).map(|(_, n)| n.as_str()).collect();
            if !names.is_empty() {
                let _ = writeln!(out, "  everything exact for {} ({why})", self.for_whom(&names));
            }
        }
        if !self.hidden.is_empty() {
            let _ = writeln!(out, "  not displayed: {}", self.hidden.join(", "));
        }
        if !absent.is_empty() {
            let _ = writeln!(out, "  not there: {}", absent.join(", "));
        }
        if all_rows {
            self.table(out);
        }
    }

    /// All rows of a sensor.
    fn table(&self, out: &mut String) {
        for row in &self.rows {
            let [_, effect, called_for, bound, decision] = crate::smdfm::report::plan_line(row);
            let _ = writeln!(out, "    {effect:<32}{bound:>20}  {decision:<18} {called_for}");
        }
    }

    /// The text of a sensor that is no radar.
    fn other_text(&self, all_rows: bool, out: &mut String) {
        if self.rows.is_empty() {
            let _ = writeln!(out, "{}: no plan", self.name);
            return;
        }
        if self.rows.iter().all(|r| r.called_for == "no equipped target") {
            let _ = writeln!(out, "{}: no target carries it", self.name);
        } else {
            let (on, off): (Vec<_>, Vec<_>) = self.rows.iter().partition(|r| !r.is_skipped());
            let names =
                |rows: &[&PlanRow]| rows.iter().map(|r| r.effect).collect::<Vec<_>>().join(", ");
            let simulated = if on.is_empty() { "nothing".into() } else { names(&on) };
            let _ =
                writeln!(out, "{}: {simulated}; {} left out or not there", self.name, off.len());
        }
        if all_rows {
            self.table(out);
        }
    }

    /// The text of the sensor.
    pub(super) fn text(&self, all_rows: bool, out: &mut String) {
        if self.is_radar {
            self.radar_text(all_rows, out);
        } else {
            self.other_text(all_rows, out);
        }
    }

    /// One object a row, then the total.
    pub(super) fn json(&self, at_s: f64, out: &mut Vec<Value>) {
        for row in &self.rows {
            out.push(self.row_json(at_s, row));
        }
        if self.is_radar {
            out.push(self.total_json(at_s));
        }
    }

    fn row_json(&self, at_s: f64, row: &PlanRow) -> Value {
        let level = row.level.name();
        let kind = |kinds: &[Kind]| kinds.iter().max().map_or("exact", |k| k.name());
        let mut value = json!({
            "at_s": at_s, "sensor": row.sensor.0, "effect": row.effect,
            "called_for": row.called_for,
            "bound": Some(row.bound).filter(|b| b.is_finite()), "unit": row.unit,
            "skipped": row.is_skipped(), "level": level,
            "cost_ns": row.cost_ns, "name": self.name,
        });
        let mut boxes = Vec::new();
        let (mut kinds, mut saved, mut left_out, mut targets) = (Vec::new(), 0.0, 0, 0);
        for (place, planned) in (0u32..).zip(&self.boxes) {
            let effect = planned.plan.effects.iter().find(|e| e.effect.name() == row.effect);
            let Some(effect) = effect.filter(|_| planned.targets > 0) else { continue };
            let n = planned.targets;
            let of_effect = f64::from(effect.exact_ns.saturating_sub(effect.cost_ns));
            kinds.push(effect.kind);
            targets += n;
            if effect.kind == Kind::LeftOut {
                left_out += n;
                saved += f64::from(n) * of_effect;
            }
            boxes.push(self.box_json(place, planned, effect));
        }
        let kind = match (kinds.is_empty(), row.is_skipped()) {
            (true, true) => "not_there",
            (true, false) => "exact",
            _ => kind(&kinds),
        };
        if let Some(object) = value.as_object_mut() {
            object.insert("kind".into(), json!(kind));
            object.insert("targets".into(), json!(targets));
            object.insert("left_out_for".into(), json!(left_out));
            object.insert("saved_ns".into(), json!(saved));
            object.insert("boxes".into(), json!(boxes));
        }
        value
    }

    fn box_json(&self, place: u32, planned: &PlannedBox, effect: &BoxEffect) -> Value {
        let here = self.placed.iter().filter(|(p, _)| p.place == Some(place));
        let mut sectors: Vec<u8> = here.map(|(p, _)| p.sector).collect();
        sectors.sort_unstable();
        sectors.dedup();
        let (near, far) = planned.key.ground_m();
        let (low, high) = band_m(planned.key.band);
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let loss = &effect.loss;
        json!({
            "class": planned.class, "ring_m": [near, far], "band_m": [low, high],
            "sectors": sectors, "targets": planned.targets,
            "level": effect.level.name(), "kind": effect.kind.name(),
            "loss": {
                "raises_db": finite(loss.raises_db), "lowers_db": finite(loss.lowers_db),
                "fixed_m": finite(loss.fixed_m), "own_m2": finite(loss.own_m2),
                "coupled_rad": finite(loss.coupled_rad), "odds": finite(loss.odds),
                "false_plots": finite(loss.false_plots),
            },
            "cost_ns": effect.cost_ns,
            "saved_ns": effect.exact_ns.saturating_sub(effect.cost_ns),
        })
    }

    fn total_json(&self, at_s: f64) -> Value {
        let costs = self.costs();
        let worst = self
            .placed
            .iter()
            .filter_map(|(p, name)| Some((self.plan_of(p)?, name)))
            .max_by(|a, b| a.0.share.total_cmp(&b.0.share));
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        json!({ "total": {
            "at_s": at_s, "sensor": self.rows.first().map(|r| r.sensor.0), "name": self.name,
            "targets": self.placed.len(),
            "boxes": self.boxes.iter().filter(|b| b.targets > 0).count(),
            "exact_ns": costs.exact, "tables_ns": costs.tables, "not_there_ns": costs.not_there,
            "left_out_ns": costs.left_out, "simulated_ns": costs.simulated,
            "left_out_percent": costs.left_out_percent(),
            "worst_target": worst.map(|(_, name)| name),
            "rms_m": worst.and_then(|(plan, _)| finite(plan.outcome.rms_m)),
            "detection": worst.map(|(plan, _)| plan.outcome.detection),
            "tail": worst.map(|(plan, _)| plan.outcome.tail),
            "share": worst.and_then(|(plan, _)| finite(plan.share)),
            "time_budget_us": self.tolerance.time_budget_us,
            "cost_us": self.fitted.map(|f| f.cost_us),
            "factor": self.fitted.map(|f| f.factor),
            "reached": self.fitted.map(|f| f.reached),
        }})
    }
}

/// What a budget of time buys, or that it cannot be held.
fn promise(fitted: &Fitted, budget_us: f64, tolerance: &Tolerance) -> String {
    let Fitted { cost_us, factor, reached } = fitted;
    let held = if *reached {
        format!("within {budget_us} µs ({cost_us:.2})")
    } else {
        format!("impossible within {budget_us} µs: at least {cost_us:.2} µs")
    };
    let by = if *factor <= 1.0 {
        "within tolerance".to_owned()
    } else {
        format!("{factor:.1} times the tolerance")
    };
    format!(
        "{held}: {by}: up to {:.3} m rms, detection within {:.4}",
        factor * tolerance.position_m,
        (factor * tolerance.detection).min(1.0)
    )
}

/// What an effect would change, over the boxes that leave it out.
struct Change {
    least: f64,
    most: f64,
    unit: &'static str,
}

impl Change {
    fn of(found: &[&BoxEffect]) -> Self {
        let values = || found.iter().map(|e| e.shown.0);
        Self {
            least: values().fold(f64::INFINITY, f64::min),
            most: values().fold(0.0, f64::max),
            unit: found.first().map_or("", |e| e.shown.1),
        }
    }
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = |x: f64| if x < 0.995 { 3 } else { 1 };
        let (least, most) = (self.least, self.most);
        if most - least > 0.05 * most {
            write!(f, "{least:.*} to ", digits(least))?;
        }
        write!(f, "{most:.*} {}", digits(most), self.unit)
    }
}

fn small(x: f64) -> String {
    if x == 0.0 || x >= 1e-4 { format!("{x:.4}") } else { format!("{x:.0e}") }
}

/// The first line of a time: scene, weather, and the promise.
pub(super) fn heading(scene: &str, at_s: f64, weather: &Weather, tolerance: &Tolerance) -> String {
    let mut words = Vec::new();
    if weather.rain_mm_per_h > 0.0 {
        words.push(format!("rain {} mm/h", weather.rain_mm_per_h));
    }
    if !weather.cells.is_empty() {
        words.push(format!("{} rain cells", weather.cells.len()));
    }
    if weather.visibility_m < 10_000.0 {
        words.push(format!("visibility {} m", weather.visibility_m));
    }
    if weather.film_mm > 0.0 {
        words.push(format!("film {} mm", weather.film_mm));
    }
    if words.is_empty() {
        words.push("clear, dry".to_owned());
    }
    let promise = match tolerance.time_budget_us {
        Some(budget) => format!("{budget} µs a scan and radar are asked for"),
        None => format!(
            "{} m rms, {} in 1000 beyond {} m, detection {}, {} false plots a scan",
            tolerance.position_m,
            1000.0 * tolerance.tail,
            5.0 * tolerance.position_m,
            tolerance.detection,
            tolerance.false_plots
        ),
    };
    format!("{scene} at {at_s:.0} s: {}. Against everything exact: {promise}", words.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_that_cannot_be_held_is_said_to_be_impossible() {
        let tolerance = Tolerance { position_m: 0.1, detection: 0.01, ..Tolerance::default() };
        let said = |cost_us: f64, factor: f64, reached: bool| {
            promise(&Fitted { cost_us, factor, reached }, 40.0, &tolerance)
        };
        let held = said(38.0, 3.2, true);
        assert!(
            held.starts_with("within 40 µs") && held.contains("3.2 times the tolerance"),
            "{held}"
        );
        assert!(held.contains("0.320 m rms") && held.contains("0.0320"), "{held}");
        assert!(said(20.0, 0.5, true).contains("within tolerance"));
        let missed = said(41.5, 107.6, false);
        assert!(
            missed.starts_with("impossible") && missed.contains("at least 41.50 µs"),
            "{missed}"
        );
    }
}
