//! Checks of the tracking vectors that concern one filter; those of sets are in [`crate::tracking_sets`].

use crate::{CaseResult, Check, Judge};
use models::filter::gaussian::Gaussian;
use models::filter::lanes::{Lane, Pair};
use models::filter::motion::Motion;
use models::filter::six_state::SixState;
use models::filter::steady;
use models::filter::three_state::ThreeState;
use models::filter::ud::Ud;
use models::filter::{Start, StateEstimator, weights};
use models::frames::{Azimuth, Matrix2, Point2, Vector2, wrap_pi};
use models::plot::{Plot, SensorId, SensorKind};
use models::plot::{polar_bias_m, polar_to_cartesian, principal_axes};
use models::time::SimTime;
use serde_json::Value;
use std::array::from_fn;
use std::f64::consts::PI;

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    Some(match stem {
        "kalman_cov" => |file| each_case(file, kalman_cov),
        "kalman_irregular" => |file| each_case(file, kalman_irregular),
        "steady_gains" => |file| each_case(file, steady_gains),
        "long_run" => |file| each_case(file, long_run),
        "filter_golden" => |file| each_case(file, filter_golden),
        "polar_unbiased" => |file| each_case(file, polar_unbiased),
        "angle_wrap" => |file| each_case(file, angle_wrap),
        "log_weights" => |file| each_case(file, log_weights),
        _ => return None,
    })
}

/// Input, expectation and tolerance of one case.
pub(crate) struct Case<'a> {
    pub(crate) input: &'a Value,
    pub(crate) expected: &'a Value,
    pub(crate) tol: f64,
}

/// Runs every case; what is missing or malformed fails its case.
pub(crate) fn each_case(
    file: &Value,
    check: fn(&Case<'_>, &mut Judge) -> Option<()>,
) -> Vec<CaseResult> {
    let cases = file["cases"].as_array().map_or(&[][..], Vec::as_slice);
    let judged = cases.iter().enumerate().map(|(number, case)| {
        let name = case["name"].as_str().map_or_else(|| number.to_string(), str::to_owned);
        let mut judge = Judge::default();
        let tol = case["tol"].as_f64().filter(|t| *t > 0.0);
        let read = tol.and_then(|tol| {
            let case = Case { input: &case["input"], expected: &case["expected"], tol };
            check(&case, &mut judge)
        });
        judge.holds("inputs and expected values are there", read.is_some());
        judge.case(name)
    });
    judged.collect()
}

impl Case<'_> {
    pub(crate) fn number(&self, key: &str) -> Option<f64> {
        self.input[key].as_f64()
    }
    pub(crate) fn list(&self, key: &str) -> Option<Vec<f64>> {
        numbers(&self.input[key])
    }
}

pub(crate) fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}

pub(crate) fn rows(value: &Value) -> Option<Vec<Vec<f64>>> {
    value.as_array()?.iter().map(numbers).collect()
}

/// Largest |ΔP_ij| / √(P_ii P_jj); absolute where a variance is zero.
fn covariance(
    judge: &mut Judge,
    expected: &[Vec<f64>],
    tol: f64,
    found: impl Fn(usize, usize) -> f64,
) -> Option<()> {
    let n = expected.len();
    for i in 0..n {
        for j in 0..n {
            let product = expected.get(i)?.get(i)? * expected.get(j)?.get(j)?;
            let scale = if product > 0.0 { product.sqrt() } else { 1.0 };
            judge.number(&format!("P[{i}][{j}]"), found(i, j), *expected[i].get(j)?, tol * scale);
        }
    }
    Some(())
}

fn kalman_cov(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    match case.list("P0_diag")?.len() {
        2 => kalman_cov_of::<2>(case, judge),
        3 => kalman_cov_of::<3>(case, judge),
        _ => None,
    }
}

fn kalman_cov_of<const N: usize>(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let p0: [f64; N] = case.list("P0_diag")?.try_into().ok()?;
    let (r, t, q) = (case.number("R")?, case.number("dt")?, case.number("q")?);
    let cycles = case.input["cycles"].as_u64()?;
    let h = &case.input["H"];
    let h = rows(h).or_else(|| Some(vec![numbers(h)?]))?;
    let h: Vec<[f64; N]> = h.into_iter().map(|row| row.try_into().ok()).collect::<Option<_>>()?;
    let moving = match (case.input["model"].as_str()?, N) {
        ("none", _) => false,
        ("CA", 3) | ("CV", 2) => true,
        _ => return None,
    };
    if cycles > 100_000_000 || h.is_empty() || !(t >= 0.0) {
        return None;
    }
    let expected = rows(&case.expected["P"])?;
    let mut ud = Ud::<N, f64>::diagonal(p0);
    let (phi, noise_u, noise_d) = transition::<N>(q, t);
    for _ in 0..cycles {
        if moving {
            ud = ud.predicted(&phi, &noise_u, &noise_d);
        }
        for row in &h {
            ud.update(row, r);
        }
    }
    covariance(judge, &expected, case.tol, |i, j| ud.covariance(i, j))?;
    // The per-axis filter of the tracker leaves out the ones and zeros: the same case through it.
    if moving && N == 3 && h.len() == 1 && h[0].iter().eq([1.0, 0.0, 0.0].iter()) {
        let mut pair = Ud::<3, Pair>::diagonal(from_fn(|i| Pair::splat(p0[i])));
        for _ in 0..cycles {
            pair = pair.jerked(q, t);
            pair.update_first(Pair::splat(r));
        }
        covariance(judge, &expected, case.tol, |i, j| pair.covariance(i, j).east())?;
        covariance(judge, &expected, case.tol, |i, j| pair.covariance(i, j).north())?;
    }
    Some(())
}

/// Φ, U_q and D_q of constant velocity (N = 2) or constant acceleration (N = 3).
fn transition<const N: usize>(q: f64, t: f64) -> ([[f64; N]; N], [[f64; N]; N], [f64; N]) {
    let row = [1.0, t, 0.5 * t * t];
    let phi = from_fn(|i| from_fn(|j| if j >= i { row[j - i] } else { 0.0 }));
    let (half, sixth, d) = models::filter::motion::Step::white_jerk_ud(q, t);
    let u = [1.0, half, sixth];
    let noise_u = from_fn(|i| from_fn(|j| if j >= i { u[j - i] } else { 0.0 }));
    // The factors for constant velocity are those of the last two components.
    (phi, noise_u, from_fn(|i| d[i + 3 - N]))
}

fn plot(time_s: f64, position: [f64; 2], r: [[f64; 2]; 2]) -> Plot {
    let matrix = Matrix2::new(r[0][0], r[0][1], r[1][0], r[1][1]);
    let (axis, along_m2, across_m2) = principal_axes(&matrix);
    Plot {
        sensor: SensorId(1),
        kind: SensorKind::Asde,
        time: SimTime::from_s(time_s),
        sequence: 0,
        position_m: Point2::new(position[0], position[1]),
        axis,
        along_m2,
        across_m2,
        altitude_m: None,
        polar: None,
        identity: None,
        scnr_db: None,
    }
}

/// A per-axis filter whose position is known to `z` with the given diagonal covariance.
fn three_state(time_s: f64, z: [f64; 2], p0: &[f64], q: f64) -> Option<ThreeState> {
    let zero = Pair::default();
    let p = [*p0.first()?, 0.0, 0.0, *p0.get(1)?, 0.0, *p0.get(2)?].map(Pair::splat);
    let x = [Pair::new(z[0], z[1]), zero, zero];
    Some(ThreeState::new(SimTime::from_s(time_s), x, p, q, Start::default()))
}

fn upper(p: &[Pair; 6], i: usize, j: usize) -> [f64; 2] {
    p[[[0, 1, 2], [1, 3, 4], [2, 4, 5]][i][j]].array()
}

fn kalman_irregular(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let mut arrival: Vec<[f64; 2]> = rows(&case.input["arrival"])?
        .into_iter()
        .map(|row| row.try_into().ok())
        .collect::<Option<_>>()?;
    // In order of time, as the tracker's ring brings late plots.
    arrival.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (r, q) = (case.number("R")?, case.number("q")?);
    let [t0, z0] = *arrival.first()?;
    let mut filter = three_state(t0, [z0, z0], &case.list("P0_diag")?, q)?;
    for [t, z] in arrival.iter().skip(1) {
        filter.update(&plot(*t, [*z, *z], [[r, 0.0], [0.0, r]])).ok()?;
    }
    for (i, x) in numbers(&case.expected["x"])?.iter().enumerate() {
        let found = filter.state().get(i)?.east();
        judge.number(&format!("x[{i}]"), found, *x, case.tol * x.abs());
    }
    let expected = rows(&case.expected["P"])?;
    covariance(judge, &expected, case.tol, |i, j| upper(&filter.covariance(), i, j)[0])
}

fn steady_gains(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (q, t) = (case.number("q_over_R")?, case.number("T")?);
    let [alpha, beta, gamma] = steady::alpha_beta_gamma(q * t * t * t * t * t);
    let ca = [alpha, beta / t, gamma / (t * t)];
    let [alpha, beta] = steady::alpha_beta(q * t * t * t);
    for (name, found) in [("K_CA", &ca[..]), ("K_CV", &[alpha, beta / t][..])] {
        let expected = numbers(&case.expected[name])?;
        judge.holds("number of gains", expected.len() == found.len());
        for (k, (found, e)) in found.iter().zip(expected).enumerate() {
            judge.number(&format!("{name}[{k}]"), *found, e, case.tol * e.abs());
        }
    }
    Some(())
}

fn long_run(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let r: Vec<[f64; 2]> = rows(&case.input["R"])?
        .into_iter()
        .map(|row| row.try_into().ok())
        .collect::<Option<_>>()?;
    let r: [[f64; 2]; 2] = r.try_into().ok()?;
    let p0: [f64; 6] = case.list("P0_diag")?.try_into().ok()?;
    let (q, dt, cycles) = (case.number("q")?, case.number("dt")?, case.input["cycles"].as_u64()?);
    if cycles > 10_000_000 {
        return None;
    }
    let mut state = Gaussian::default();
    for (k, slot) in [(0, 0), (1, 3), (2, 5)] {
        state.p[slot] = Pair::new(p0[k], p0[k + 3]);
    }
    let motion = Motion::ConstantAcceleration { q };
    let mut filter = SixState::new(SimTime::ZERO, state, motion, Start::default());
    for k in 1..=cycles {
        filter.update(&plot(k as f64 * dt, [0.0, 0.0], r)).ok()?;
    }
    let p = filter.estimate().state.covariance();
    covariance(judge, &rows(&case.expected["P"])?, case.tol, |i, j| p[(i, j)])?;
    judge.ratio((p - p.transpose()).amax() / 1e-12, || "asymmetry".to_owned());
    judge.holds("all eigenvalues are positive", p.symmetric_eigenvalues().min() > 0.0);
    Some(())
}

fn filter_golden(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (r, q, dt) = (case.number("R")?, case.number("q")?, case.number("dt")?);
    let plots: Vec<[f64; 2]> = rows(&case.input["plots"])?
        .into_iter()
        .map(|row| row.try_into().ok())
        .collect::<Option<_>>()?;
    let (x, y) = (numbers(&case.expected["filtered_x"])?, numbers(&case.expected["filtered_y"])?);
    judge.holds("as many outputs as plots", plots.len() == x.len() && plots.len() == y.len());
    let mut filter = three_state(0.0, *plots.first()?, &case.list("P0_diag")?, q)?;
    for (k, z) in plots.iter().enumerate() {
        if k > 0 {
            filter.update(&plot(k as f64 * dt, *z, [[r, 0.0], [0.0, r]])).ok()?;
        }
        let at = filter.state()[0].array();
        for (axis, found, expected) in [("x", at[0], *x.get(k)?), ("y", at[1], *y.get(k)?)] {
            // Relative to the position, metres near the origin.
            let tolerance = case.tol * expected.abs().max(1.0);
            judge.number(&format!("filtered_{axis}[{k}]"), found, expected, tolerance);
        }
    }
    let expected = rows(&case.expected["final_P"])?;
    covariance(judge, &expected, case.tol, |i, j| upper(&filter.covariance(), i, j)[0])?;
    covariance(judge, &expected, case.tol, |i, j| upper(&filter.covariance(), i, j)[1])
}

fn polar_unbiased(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (r, theta) = (case.number("r")?, case.number("theta")?);
    let (sr, st) = (case.number("sr")?, case.number("st")?);
    let direction = Azimuth::from_rad(PI / 2.0 - theta).unit();
    let (offset, along, across) = polar_to_cartesian(direction, r, sr, st);
    let xy = numbers(&case.expected["xy"])?;
    let e = |key: &str| case.expected[key].as_f64();
    let (rxx, rxy, ryy) = (e("Rxx")?, e("Rxy")?, e("Ryy")?);
    let length = Vector2::new(*xy.first()?, *xy.get(1)?).norm();
    judge.number("x", offset.x, xy[0], case.tol * length);
    judge.number("y", offset.y, xy[1], case.tol * length);
    let (c, s) = (direction.x, direction.y);
    let scale = case.tol * (rxx * ryy).sqrt();
    judge.number("Rxx", along * c * c + across * s * s, rxx, scale);
    judge.number("Rxy", (along - across) * c * s, rxy, scale);
    judge.number("Ryy", along * s * s + across * c * c, ryy, scale);
    let bias = e("bias_classical_m")?;
    judge.number("bias_classical_m", polar_bias_m(r, st), bias, case.tol * bias.abs());
    Some(())
}

fn angle_wrap(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let found = wrap_pi(case.number("a")? - case.number("b")?);
    let expected = case.expected["wrapped"].as_f64()?;
    // Half a turn to the left is half a turn to the right.
    let either = (expected.abs() - PI).abs() <= 4e-16;
    let (found, expected) = if either { (found.abs(), expected.abs()) } else { (found, expected) };
    judge.number("wrapped", found, expected, case.tol);
    judge.holds("within half a turn", (-PI..=PI).contains(&found));
    Some(())
}

fn log_weights(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let mut w = case.list("logw")?;
    let log_sum = weights::normalise(&mut w)?;
    let expected = numbers(&case.expected["weights"])?;
    judge.holds("as many weights", expected.len() == w.len());
    for (k, (found, e)) in w.iter().zip(expected).enumerate() {
        if e < 1e-300 {
            judge.holds(&format!("weights[{k}] below 1e-300"), (0.0..1e-300).contains(found));
        } else {
            judge.number(&format!("weights[{k}]"), *found, e, case.tol * e);
        }
    }
    let e = case.expected["log_sum"].as_f64()?;
    judge.number("log_sum", log_sum, e, case.tol * e.abs());
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(stem: &str) -> Value {
        let path =
            format!("{}/../tests/data/vectors/tracking/{stem}.json", env!("CARGO_MANIFEST_DIR"));
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    }

    #[test]
    fn every_vector_passes() {
        crate::assert_all_pass(&[
            ("tracking/kalman_cov", 10),
            ("tracking/kalman_irregular", 4),
            ("tracking/steady_gains", 12),
            ("tracking/long_run", 3),
            ("tracking/filter_golden", 2),
            ("tracking/polar_unbiased", 9),
            ("tracking/angle_wrap", 8),
            ("tracking/log_weights", 6),
        ]);
    }

    #[test]
    fn what_is_missing_or_wrong_fails() {
        for stem in ["kalman_cov", "steady_gains", "filter_golden", "polar_unbiased", "log_weights"]
        {
            let mut document = file(stem);
            document["cases"][0]["input"] = serde_json::json!({ "cycles": "many" });
            document["cases"][1]["expected"] = Value::Null;
            let found = check_for(stem).unwrap()(&document);
            assert!(found[..2].iter().all(|c| c.worst > 1.0), "{stem}: {found:?}");
        }
        let mut document = file("filter_golden");
        let value = &mut document["cases"][0]["expected"]["filtered_x"][20];
        *value = (value.as_f64().unwrap() + 1e-7).into();
        assert!(check_for("filter_golden").unwrap()(&document)[0].worst > 1.0);
    }
}
