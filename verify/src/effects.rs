//! Checks of the effect plan's vectors: outcomes, choice, bounds and boxes.

use crate::{CaseResult, Check, Judge};
use models::effects::choice::{Candidate, Sum, cheapest, least_factor};
use models::effects::outcome::{
    AxisShift, MEAN_ABS, TrackGain, density_factor, detection_change, edge_factor, shift_by_ratio,
};
use models::environment::Weather;
use models::environment::surface::Complex;
use models::sensors::asde::AsdeParameters;
use models::sensors::asde::plan::bounds::{attenuation_raises_db, clutter_raises_db};
use models::sensors::asde::plan::boxes::{ring, sector};
use models::sensors::asde::plan::reflection::{Piece, Reach, Refinement};
use models::sensors::radar::antenna::Pattern;
use models::sensors::radar::detection::{Detector, PdTable, Swerling, from_db};
use models::sensors::radar::equation::Polarisation;
use models::sensors::radar::ghost::ghost_power;
use serde_json::Value;

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    Some(match stem {
        "shift_by_ratio" => |d| each(d, shift),
        "quantiser" => |d| each(d, quantiser),
        "detection_change" => |d| each(d, change),
        "track_gain" => |d| each(d, track),
        "choice" => |d| each(d, choice),
        "ratio_bounds" => |d| each(d, ratio),
        "reflection_bounds" => |d| each(d, reflection),
        "boxes" => |d| each(d, boxes),
        "ghost_power" => |d| each(d, ghosts),
        _ => return None,
    })
}

struct Case<'a> {
    input: &'a Value,
    expected: &'a Value,
    document: &'a Value,
}

impl Case<'_> {
    fn number(&self, key: &str) -> Option<f64> {
        self.input.get(key)?.as_f64()
    }

    fn expected(&self, key: &str) -> Option<f64> {
        self.expected.get(key)?.as_f64()
    }

    fn compare(&self, judge: &mut Judge, key: &str, found: f64) {
        let Some(expected) = self.expected(key) else {
            judge.holds(key, false);
            return;
        };
        let table = &self.document["tolerance"];
        let entry = table.get(key).or_else(|| table.get("*"));
        let part = |name| entry.and_then(|e| e.get(name)).and_then(Value::as_f64).unwrap_or(0.0);
        let tolerance = f64::max(part("abs"), part("rel") * expected.abs());
        judge.number(key, found, expected, tolerance);
    }
}

fn each(document: &Value, check: fn(&Case<'_>, &mut Judge) -> Option<()>) -> Vec<CaseResult> {
    let cases = document["cases"].as_array().map_or(&[][..], Vec::as_slice);
    let one = |(n, case): (usize, &Value)| {
        let mut judge = Judge::default();
        let case = Case { input: &case["input"], expected: &case["expected"], document };
        if check(&case, &mut judge).is_none() {
            judge.holds("all inputs are there", false);
        }
        judge.case(format!("{}", n + 1))
    };
    cases.iter().enumerate().map(one).collect()
}

fn shift(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let bound = shift_by_ratio(
        case.number("sigma1")?,
        case.number("least_ratio")?,
        from_db(case.number("lowest_db")?),
        case.number("raises_db")?,
        case.number("lowers_db")?,
    );
    case.compare(judge, "rms_bound", bound);
    judge.holds("no search finds more", case.expected("rms_largest")? <= bound * (1.0 + 1e-9));
    Some(())
}

fn quantiser(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (sigma, step) = (case.number("sigma")?, case.number("step")?);
    let (drawn_m, fixed_m) = (case.number("shift_rms")?, case.number("shift_fixed")?.abs());
    let u = step / sigma;
    let factor = edge_factor(u);
    case.compare(judge, "C", factor);
    let shift =
        |factors| AxisShift { drawn_m, fixed_m, step_m: step, factors, ..AxisShift::default() };
    // First order in the shift over the deviation.
    let worst = shift((factor, density_factor(u)));
    let most = if drawn_m + fixed_m < 0.5 * sigma { 1.02 } else { 1.3 };
    let mut within = |what: &str, found: f64, bound: f64, loose: f64| {
        judge.ratio(found / (most * bound), || format!("{what}: bound {bound} below {found}"));
        judge.ratio(bound / (loose * found), || format!("{what}: bound {bound} of {found}"));
    };
    // Steps far larger than the deviation are where the bounds are loose.
    within("worst place", case.expected("mean_square_worst")?, worst.square_m2(), 3.2);
    let spread = shift((MEAN_ABS, 1.0));
    within("spread", case.expected("mean_square_uniform")?, spread.square_m2(), 2.3);
    within("flips", case.expected("flip_uniform")?, spread.flip(), 2.3);
    Some(())
}

fn change(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let swerling = Swerling::case(case.input.get("swerling")?.as_u64()?)?;
    let pulses = case.input.get("pulses")?.as_u64()? as u32;
    let table = PdTable::new(&Detector::new(pulses, case.number("pfa")?), swerling);
    let (raises, lowers) = (case.number("raises_db")?, case.number("lowers_db")?);
    let (low, high) = (case.number("lowest_db")?, case.number("highest_db")?);
    let (from, to) = table.window_db();
    let clamp = |db: f64| db.clamp(from - raises, to + lowers).clamp(low, high);
    let range = (clamp(low), clamp(high));
    let found = detection_change(|db| table.at_db(db), range, raises, lowers, 14);
    case.compare(judge, "change", found);
    Some(())
}

fn track(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (period, jerk) = (case.number("period_s")?, case.number("jerk")?);
    let gain = TrackGain::steady(period, jerk, case.number("variance")?)?;
    case.compare(judge, "gain", gain.gain);
    case.compare(judge, "noise_gain", gain.noise_gain);
    let rms = gain.shift_m(case.number("shift_rms")?, case.number("shift_fixed")?);
    case.compare(judge, "track_rms", rms);
    Some(())
}

/// The four losses of the choice's cases.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plain {
    shift_m: f64,
    square_m2: f64,
    detection: f64,
    false_plots: f64,
}

impl Sum for Plain {
    const NONE: Self = Self { shift_m: 0.0, square_m2: 0.0, detection: 0.0, false_plots: 0.0 };

    fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            shift_m: self.shift_m + other.shift_m,
            square_m2: self.square_m2 + other.square_m2,
            detection: self.detection + other.detection,
            false_plots: self.false_plots + other.false_plots,
        }
    }
}

fn choice(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let number = |v: &Value, key: &str| v.get(key).and_then(Value::as_f64);
    let tolerance = case.input.get("tolerance")?;
    let position_m = number(tolerance, "position_m")?;
    let (detection, plots) = (number(tolerance, "detection")?, number(tolerance, "false_plots")?);
    let candidate = |v: &Value| {
        Some(Candidate {
            cost_ns: number(v, "cost_ns")?.round() as u32,
            loss: Plain {
                shift_m: number(v, "shift_m")?,
                square_m2: number(v, "square_m2")?,
                detection: number(v, "detection")?,
                false_plots: number(v, "false_plots")?,
            },
        })
    };
    let ladders: Vec<Vec<Candidate<Plain>>> = case
        .input
        .get("ladders")?
        .as_array()?
        .iter()
        .map(|ladder| ladder.as_array()?.iter().map(candidate).collect())
        .collect::<Option<_>>()?;
    let share = |l: &Plain| {
        let rms = (l.shift_m * l.shift_m + l.square_m2).sqrt();
        (rms / position_m).max(l.detection / detection).max(l.false_plots / plots)
    };
    let at = |factor: f64| cheapest(&ladders, |l| share(l) <= factor, share);
    let exact: u64 = ladders.iter().filter_map(|l| l.last()).map(|c| u64::from(c.cost_ns)).sum();
    let best = at(1.0 + 1e-12)?;
    judge.holds("searched to the end", best.is_best);
    case.compare(judge, "saved_ns", exact as f64 - best.cost_ns as f64);
    if let Some(budget) = case.number("budget_ns") {
        let cost = |factor: f64| match at(factor * (1.0 + 1e-12)) {
            Some(choice) => (choice.cost_ns as f64, share(&choice.loss)),
            None => (f64::INFINITY, f64::INFINITY),
        };
        let factor = least_factor(budget, 1e12, cost)?;
        case.compare(judge, "budget_share", factor);
        case.compare(judge, "budget_cost_ns", cost(factor).0);
    }
    if case.expected("front_points").is_some() {
        // From the cheapest choice to the one that loses nothing: each point is the least share for its cost.
        let cost = |factor: f64| match at(factor * (1.0 + 1e-12)) {
            Some(choice) => (choice.cost_ns as f64, share(&choice.loss)),
            None => (f64::INFINITY, f64::INFINITY),
        };
        let (mut points, mut most) = (0u32, 1e12);
        while points < 10_000 {
            let factor = least_factor(cost(most).0, most, cost)?;
            points += 1;
            if factor == 0.0 {
                break;
            }
            // Just below this point's share.
            most = factor * (1.0 - 1e-9);
        }
        case.compare(judge, "front_points", f64::from(points));
    }
    Some(())
}

fn ratio(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let two_way = case.number("two_way_db")?;
    let (least, skipped) =
        (case.number("least_clutter_to_noise")?, case.number("clutter_to_noise")?);
    let bound = attenuation_raises_db(two_way, two_way, least);
    case.compare(judge, "attenuation_bound_db", bound);
    let exact = case.expected("attenuation_raises_db")?;
    judge.holds("no more than the bound", exact <= bound * (1.0 + 1e-12));
    case.compare(judge, "clutter_raises_db", clutter_raises_db(skipped, least));
    Some(())
}

fn reflection(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let mut p = AsdeParameters::ku_band();
    let complex = |key: &str| {
        let list = case.input.get(key)?.as_array()?;
        Some(Complex::new(list.first()?.as_f64()?, list.get(1)?.as_f64()?))
    };
    p.polarisation = match case.input.get("polarisation")?.as_str()? {
        "h" => Polarisation::Horizontal,
        "v" => Polarisation::Vertical,
        _ => Polarisation::Circular,
    };
    p.carrier_ghz = case.number("carrier_ghz")?;
    p.antenna_height_m = case.number("antenna_m")?;
    p.roughness_m = case.number("roughness_m")?;
    let mut radar = p.radar();
    let skirt = case.input.get("skirt_deg").and_then(Value::as_f64);
    radar.pattern = Pattern {
        azimuth_rad: radar.pattern.azimuth_rad,
        elevation_rad: case.number("elevation_deg")?.to_radians(),
        axis_rad: case.number("axis_deg")?.to_radians(),
        skirt_end_rad: skirt.map(f64::to_radians),
        floor: case.number("floor")?,
    };
    radar.by_sine = radar.pattern.by_sine();
    let mut air = radar.air(&Weather::default());
    air.weather.film_mm = case.number("film_m")? * 1000.0;
    (air.surface, air.film) = (complex("permittivity")?, complex("film_permittivity")?);
    let (near, far) = (case.number("from_m")?, case.number("to_m")?);
    let (low, high) = (case.number("lowest_m")?, case.number("highest_m")?);
    // As fine as a search: the planner itself takes fewer pieces.
    let (distances, storeys) = (32, 8);
    let at = |i: i32| near * libm::pow(far / near, f64::from(i) / f64::from(distances));
    let up = |i: i32| low + (high - low) * f64::from(i) / f64::from(storeys);
    let extent_m = case.number("extent_m")?;
    let effect = case.input.get("effect")?.as_str()?;
    let refinement = match effect {
        "roughness" => Some(Refinement::Roughness),
        "film" => Some(Refinement::Film),
        "polarisation" => Some(Refinement::Polarisation),
        "curvature" => Some(Refinement::Curvature),
        _ => None,
    };
    // This one alone: the others are exact.
    let open = refinement.map_or(0, |r| 1 << r as usize);
    let piece = |i: i32, k: i32| {
        let reach = Reach { ground_m: (at(i), at(i + 1)), height_m: (up(k), up(k + 1)) };
        Piece::new(&radar, &air, reach).bounds(&radar, extent_m, open)
    };
    let pieces = (0..distances).flat_map(|i| (0..storeys).map(move |k| (i, k)));
    let bounds = pieces.map(|(i, k)| piece(i, k)).reduce(|a, b| a.and(&b))?;
    let (raises, lowers) = match (effect, refinement) {
        (_, Some(r)) => (bounds.refined_db[r as usize], bounds.refined_db[r as usize]),
        ("lobing", None) => bounds.lobing_db,
        ("reflection", None) => bounds.reflection_db,
        _ => return None,
    };
    // No looser than the file says, and than the search found: four times at most, where polarisation is taken for another.
    let largest = case.expected("raises_db")?.max(case.expected("lowers_db")?);
    let most = (1.5 * case.expected("bound_db")? + 0.01).min(4.0 * largest);
    for (name, bound) in [("raises_db", raises), ("lowers_db", lowers)] {
        let truth = case.expected(name)?;
        judge.ratio(if truth <= bound { 0.0 } else { f64::INFINITY }, || {
            format!("{name}: bound {bound} below {truth}")
        });
        judge.ratio(if bound == most { 1.0 } else { bound / most }, || {
            format!("{name}: bound {bound} of at most {most}")
        });
    }
    Some(())
}

fn boxes(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (east, north) = (case.number("east_m")?, case.number("north_m")?);
    case.compare(judge, "ring", f64::from(ring(east * east + north * north)));
    case.compare(judge, "sector", f64::from(sector(libm::atan2(east, north))));
    Some(())
}

fn ghosts(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let pattern = Pattern {
        azimuth_rad: case.number("beamwidth_deg")?.to_radians(),
        floor: case.number("floor")?,
        ..AsdeParameters::ku_band().radar().pattern
    };
    let beside = pattern.azimuth(case.number("apart_deg")?.to_radians());
    let (direct, image) = (case.number("direct_m")?, case.number("image_m")?);
    let (mixed, double) = ghost_power(case.number("reflection")?, direct, image, beside);
    case.compare(judge, "mixed_db", 10.0 * libm::log10(mixed));
    case.compare(judge, "double_db", 10.0 * libm::log10(double));
    Some(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_case_of_the_effect_plan_passes() {
        crate::assert_all_pass(&[
            ("effects/shift_by_ratio", 40),
            ("effects/quantiser", 24),
            ("effects/detection_change", 24),
            ("effects/track_gain", 12),
            ("effects/choice", 14),
            ("effects/ratio_bounds", 24),
            ("effects/boxes", 40),
            ("effects/ghost_power", 24),
        ]);
    }

    fn cases_of(file: &str) -> (serde_json::Value, Vec<serde_json::Value>) {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/vectors");
        let text = std::fs::read_to_string(root.join(format!("effects/{file}.json"))).expect(file);
        let whole: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let cases = whole["cases"].as_array().expect("cases").clone();
        (whole, cases)
    }

    /// The worst of one case in which quantities are multiplied by a factor, or missing.
    fn worst_of(
        file: &str,
        whole: &serde_json::Value,
        case: &serde_json::Value,
        changed: &[(&str, Option<f64>)],
    ) -> f64 {
        let (mut whole, mut case) = (whole.clone(), case.clone());
        let expected = case["expected"].as_object_mut().expect("quantities");
        for (name, factor) in changed {
            let value = expected.remove(*name).and_then(|v| v.as_f64()).expect("a number");
            if let Some(factor) = factor {
                expected.insert((*name).to_owned(), serde_json::json!(value * factor));
            }
        }
        whole["cases"] = serde_json::json!([case]);
        super::check_for(file).expect("covered")(&whole)[0].worst
    }

    /// A bound holds from both sides: neither larger nor smaller quantities pass, nor missing ones.
    #[test]
    fn changed_quantities_of_bounds_fail() {
        let (whole, cases) = cases_of("quantiser");
        for case in &cases {
            for name in ["mean_square_uniform", "mean_square_worst", "flip_uniform", "C"] {
                for factor in [Some(0.25), Some(4.0), None] {
                    let worst = worst_of("quantiser", &whole, case, &[(name, factor)]);
                    assert!(worst > 1.0, "{name} times {factor:?}: {worst} {case}");
                }
            }
        }
        let (whole, cases) = cases_of("reflection_bounds");
        for case in cases.iter().step_by(9) {
            let both = |factor| [("raises_db", Some(factor)), ("lowers_db", Some(factor))];
            let less = [("bound_db", Some(0.1))];
            let without = ["raises_db", "lowers_db", "bound_db"].map(|name| [(name, None)]);
            let (much, little) = (both(5.0), both(0.2));
            let all = [&much[..], &little, &less].into_iter().chain(without.iter().map(|w| &w[..]));
            for changed in all {
                // Half a hundredth of a decibel is allowed whatever the file says.
                let worst = worst_of("reflection_bounds", &whole, case, changed);
                let small = case["expected"]["bound_db"].as_f64().expect("a number") < 0.01;
                assert!(worst > 1.0 || (small && changed == less), "{changed:?} {case}");
            }
        }
    }

    #[test]
    fn no_reflection_bound_is_below_the_truth_or_loose() {
        crate::assert_all_pass(&[("effects/reflection_bounds", 40)]);
    }
}
