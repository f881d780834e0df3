//! What advice is worth: the same scene and seed flown with and without it, by models of controllers on truth, over many seeds.
//!
//! The differences are those of pairs, so that what the seeds have in common falls out; the interval is that of their mean
//! (Student, 95 %).

use models::control::actors::pilot::Habits as People;
use models::control::actors::{Actors, Wanted};
use models::control::advice::{Advisor, Change, Decision, Habits};
use models::control::clearance::ClearanceKind;
use models::traffic::core::{ClearedBy, Direction, Notice, Order};
use scenarios::Scene;
use serde_json::{Value, json};
use std::fmt::Write;

/// What is measured of a run: key, words, unit.
pub const MEASURES: [(&str, &str, &str); 8] = [
    ("taxi_out_s", "taxi-out, mean of the departures (off-block to line-up)", "s"),
    ("stand_to_air_s", "from the wish to push to take-off, mean of the departures", "s"),
    ("fuel_kg", "fuel on the ground, mean of all flights", "kg"),
    ("stops", "stops of 5 s or more off stands, mean of all flights", ""),
    ("last_take_off_s", "last take-off", "s"),
    ("taxi_in_s", "taxi-in, mean of the arrivals", "s"),
    ("radio_s", "seconds on the air, all frequencies", "s"),
    ("unserved", "flights that were not served", ""),
];

/// One run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flown {
    /// The measures, in the order of [`MEASURES`].
    pub measures: [f64; 8],
    /// Advice given, and accepted.
    pub advised: (u32, u32),
}

/// Longest that a run goes on after its scene until everybody is served, s.
const LONGER_S: f64 = 3600.0;

/// Flies a scene with its controllers as models that know the truth.
///
/// # Errors
/// A scene without traffic that behaves, or loaded without truth.
pub fn fly(scene: &Scene, seed: u64, advice: Option<Habits>) -> Result<Flown, String> {
    let missing = || {
        format!("{}: no traffic that behaves (kind = \"schedule\" or \"generated\")", scene.name)
    };
    let behaving = scene.traffic.behaving.as_ref().ok_or_else(missing)?;
    let core = behaving.told_core(&scene.run, seed).ok_or_else(missing)?;
    let mut core = core.cleared_by(ClearedBy::Notices);
    let step_s = scene.run.frame.s();
    let per_scan = i64::from(scene.run.frames_per_scan);
    let mut actors = Actors::new(People::default(), seed, step_s);
    let mut advisor = advice.map(|habits| Advisor::new(habits, seed, behaving.departing()));
    let (mut flown, mut told) = (Flown::default(), 0);
    let most = scene.run.frames() as i64 + (LONGER_S / step_s) as i64;
    for frame in 1..=most {
        core.step(frame);
        if frame % per_scan != 0 {
            continue;
        }
        let now_s = frame as f64 * step_s;
        let wanted: Vec<Wanted> = core.wanted().into_iter().map(|(w, _)| w).collect();
        let mut may = vec![true; wanted.len()];
        if let Some(advisor) = &mut advisor {
            for change in advisor.scan(now_s, &wanted, false, None) {
                flown.advised.0 += u32::from(matches!(change, Change::Given(_)));
                let accepted = change.advice().decision.0 == Decision::Accepted;
                flown.advised.1 += u32::from(matches!(change, Change::Decided(_)) && accepted);
            }
            for (w, may) in wanted.iter().zip(&mut may) {
                *may = w.kind != ClearanceKind::Push || advisor.may_push(w.flight);
            }
        }
        for given in actors.scan_seen(now_s, &wanted, &may) {
            advisor.iter_mut().for_each(|advisor| advisor.given(&given));
            told += 1;
            core.notice(Notice {
                effect_frame: ((given.acts_s / step_s).ceil() as i64).max(frame + per_scan),
                source: given.seat.name(),
                sequence: told,
                flight: given.flight as usize,
                order: Order::told(given.kind, false),
            });
        }
        if frame % (60 * per_scan) == 0 && core.all_served() {
            break;
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let flights = || core.flights().iter().enumerate().map(|(at, f)| (f, core.measures(at)));
    let of = |direction: Direction| flights().filter(move |(f, _)| f.direction == direction);
    let taxi = |direction| of(direction).filter_map(|(_, m)| m.taxi_s).collect::<Vec<f64>>();
    let to_air = of(Direction::Departure).filter_map(|(f, m)| Some(m.atot_s? - f.time_s));
    let last_s = flights().filter_map(|(_, m)| m.atot_s).fold(0.0, f64::max);
    let mut on_air = std::collections::BTreeMap::new();
    for sample in actors.samples() {
        on_air.insert(sample.seat, sample.on_air_s);
    }
    flown.measures = [
        mean(&taxi(Direction::Departure)),
        mean(&to_air.collect::<Vec<f64>>()),
        mean(&flights().map(|(_, m)| m.fuel_kg).collect::<Vec<f64>>()),
        mean(&flights().map(|(_, m)| f64::from(m.stops)).collect::<Vec<f64>>()),
        last_s,
        mean(&taxi(Direction::Arrival)),
        on_air.values().sum(),
        (core.flights().len() - core.measures_of_served()) as f64,
    ];
    Ok(flown)
}

/// Pairs of runs of one scene.
#[derive(Clone, Debug, Default)]
pub struct Benefit {
    /// Name of the scene.
    pub scene: String,
    /// By seed: without and with advice.
    pub pairs: Vec<(u64, Flown, Flown)>,
}

/// A measure over all pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Mean without advice.
    pub without: f64,
    /// Mean with it.
    pub with: f64,
    /// Mean of with minus without.
    pub mean: f64,
    /// Half of its interval (95 %); `None` of fewer than two pairs.
    pub half: Option<f64>,
}

impl Benefit {
    /// A measure by its place in [`MEASURES`].
    #[must_use]
    pub fn difference(&self, measure: usize) -> Difference {
        let n = self.pairs.len().max(1) as f64;
        let mean =
            |of: &dyn Fn(&(u64, Flown, Flown)) -> f64| self.pairs.iter().map(of).sum::<f64>() / n;
        let by = |p: &(u64, Flown, Flown)| p.2.measures[measure] - p.1.measures[measure];
        let difference = mean(&by);
        let half = (self.pairs.len() > 1).then(|| {
            let square = self.pairs.iter().map(|p| (by(p) - difference).powi(2)).sum::<f64>();
            student_95(self.pairs.len() - 1) * (square / (n - 1.0) / n).sqrt()
        });
        Difference {
            without: mean(&|p| p.1.measures[measure]),
            with: mean(&|p| p.2.measures[measure]),
            mean: difference,
            half,
        }
    }

    /// Advice given and accepted, in all runs.
    #[must_use]
    pub fn advised(&self) -> (u32, u32) {
        let add =
            |(g, a): (u32, u32), p: &(u64, Flown, Flown)| (g + p.2.advised.0, a + p.2.advised.1);
        self.pairs.iter().fold((0, 0), add)
    }

    /// A table for a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        let (given, accepted) = self.advised();
        let mut out = format!(
            "{}: {} seeds, {given} advices, {accepted} accepted\n{:58} {:>10} {:>10} {:>10} {:>8}\n",
            self.scene,
            self.pairs.len(),
            "",
            "without",
            "with",
            "difference",
            "± 95 %"
        );
        for (at, (_, words, unit)) in MEASURES.iter().enumerate() {
            let d = self.difference(at);
            let half = d.half.map_or("-".into(), |h| format!("{h:.2}"));
            let _ = writeln!(
                out,
                "{words:58} {:>10.2} {:>10.2} {:>+10.2} {half:>8} {unit}",
                d.without, d.with, d.mean
            );
        }
        out
    }

    /// One row a measure.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut out = String::new();
        for (at, (key, _, unit)) in MEASURES.iter().enumerate() {
            let d = self.difference(at);
            let half = d.half.map_or(String::new(), |h| h.to_string());
            let _ = writeln!(
                out,
                "{},{},{key},{unit},{},{},{},{half}",
                self.scene,
                self.pairs.len(),
                d.without,
                d.with,
                d.mean
            );
        }
        out
    }

    /// Heads of [`Self::to_csv`].
    pub const CSV_HEADS: &str =
        "scene,seeds,measure,unit,without,with,difference,interval_95_percent\n";

    /// One JSON object.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let mut measures = serde_json::Map::new();
        for (at, (key, _, unit)) in MEASURES.iter().enumerate() {
            let d = self.difference(at);
            measures.insert(
                (*key).into(),
                json!({"unit": unit, "without": d.without, "with": d.with, "difference": d.mean, "interval_95_percent": d.half}),
            );
        }
        let (given, accepted) = self.advised();
        json!({"scene": self.scene, "seeds": self.pairs.len(), "advices": given, "accepted": accepted, "measures": measures})
    }
}

/// The two-sided 95 % point of Student's distribution: from its table up to nine degrees of freedom, then by the expansion in
/// 1/ν after Cornish and Fisher, right to 0.001 there.
#[must_use]
pub fn student_95(freedom: usize) -> f64 {
    const TABLE: [f64; 9] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262];
    match freedom {
        0 => f64::INFINITY,
        n @ 1..=9 => TABLE[n - 1],
        n => {
            let (z, v) = (1.959_964_f64, n as f64);
            let g1 = (z.powi(3) + z) / 4.0;
            let g2 = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
            let g3 = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
            z + g1 / v + g2 / (v * v) + g3 / v.powi(3)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Departures of Manchester, where they queue, with somebody who lands in between.
    fn scene(seed: u64, departures: u32, arrivals: u32) -> Scene {
        let airport = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/airports/EGCC.nodes.csv");
        let text = format!(
            "[run]\ntitle = \"advice\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"{airport}\"\n[[traffic]]\n\
             kind = \"generated\"\narrivals_per_h = {arrivals}\ndepartures_per_h = {departures}\n[control]\nsees = \"truth\"\n"
        );
        scenarios::load_text(std::path::Path::new("advice.toml"), &text).expect("a scene")
    }

    #[test]
    fn the_interval_of_a_mean_of_pairs_is_students() {
        for (freedom, table) in [(4, 2.776), (9, 2.262), (10, 2.228), (19, 2.093), (60, 2.000)] {
            assert!((student_95(freedom) - table).abs() < 1e-3, "{freedom}");
        }
        let flown = |x: f64| Flown { measures: [x; 8], advised: (2, 1) };
        let pairs = [(1.0, 2.0), (5.0, 5.0), (9.0, 10.0), (0.0, 4.0), (3.0, 3.0)];
        let pairs = pairs.iter().enumerate().map(|(n, (a, b))| (n as u64, flown(*a), flown(*b)));
        let benefit = Benefit { scene: "x".into(), pairs: pairs.collect() };
        let d = benefit.difference(0);
        // Differences 1, 0, 1, 4, 0: mean 1.2, deviation 1.643.
        assert!((d.mean - 1.2).abs() < 1e-12 && (d.without - 3.6).abs() < 1e-12);
        assert!((d.half.expect("five") - 2.776 * 1.643_168 / 5_f64.sqrt()).abs() < 2e-3);
        assert_eq!(benefit.advised(), (10, 5));
        assert!(benefit.to_text().contains("+1.20"));
        assert_eq!(benefit.to_csv().lines().count(), MEASURES.len());
        assert_eq!(benefit.to_csv().lines().next().map(|l| l.split(',').count()), Some(8));
        assert_eq!(benefit.to_json()["measures"]["stops"]["with"], 4.8);
    }

    #[test]
    fn held_departures_wait_at_the_stand_in_place_of_the_line_and_nobody_is_lost() {
        let always = Habits { accepts: 1.0, ..Habits::default() };
        let never = Habits { accepts: 0.0, ..Habits::default() };
        let mut benefit = Benefit::default();
        for seed in 1..=8 {
            let scene = scene(seed, 40, 15);
            let without = fly(&scene, seed, None).expect("behaves");
            let with = fly(&scene, seed, Some(always)).expect("behaves");
            if seed == 1 {
                let refused = fly(&scene, seed, Some(never)).expect("behaves");
                assert_eq!(refused.measures, without.measures, "advice is no action");
                assert!(refused.advised.0 > 0 && refused.advised.1 == 0, "{:?}", refused.advised);
                assert_eq!(fly(&scene, seed, Some(always)).as_ref(), Ok(&with), "the same again");
            }
            benefit.pairs.push((seed, without, with));
        }
        let [taxi_out, to_air, fuel, unserved] = [0, 1, 2, 7].map(|m| benefit.difference(m));
        assert!(benefit.advised().1 > 20, "{benefit:?}");
        // Of one seed it may cost: the mean of 24 is -18 +- 18 s.
        assert!(taxi_out.mean < -10.0 && fuel.mean < 0.0, "{}", benefit.to_text());
        // Who waits at the stand takes off little later, and nobody is left behind.
        assert!(to_air.mean < 120.0, "{}", benefit.to_text());
        assert_eq!((unserved.with, unserved.without), (0.0, 0.0), "{}", benefit.to_text());
        // Where nobody waits, nobody is advised.
        let quiet = scene(3, 2, 2);
        assert_eq!(fly(&quiet, 3, Some(always)).expect("behaves").advised, (0, 0));
    }
}
