//! Checks of the wire vectors: places, orientations, dead reckoning, timestamps.

use crate::{CaseResult, Check, Judge};
use geodesy::{Ecef, Euler, Geodetic, LocalFrame, Matrix, Quaternion};
use pdu::DisTime;
use pdu::dead_reckoning;
use serde_json::Value;

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    match stem {
        "geodetic" => Some(|file| each(file, geodetic)),
        "ecef_enu" => Some(|file| each(file, ecef_enu)),
        "euler" => Some(|file| each(file, euler)),
        "dead_reckoning" => Some(|file| each(file, dead_reckoning)),
        "dis_timestamp" => Some(|file| each(file, dis_timestamp)),
        _ => None,
    }
}

/// Runs a check over the cases; one that cannot be read fails with what is missing.
fn each(file: &Value, check: fn(&Value, &mut Judge) -> Option<()>) -> Vec<CaseResult> {
    let cases = file.get("cases").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let run = |(number, case): (usize, &Value)| {
        let name = case.get("name").and_then(Value::as_str);
        let name = name.map_or_else(|| format!("case {number}"), str::to_owned);
        let mut judge = Judge::default();
        if check(case, &mut judge).is_none() {
            judge.holds("input, expected values and tolerances are there", false);
        }
        judge.case(name)
    };
    cases.iter().enumerate().map(run).collect()
}

fn number(value: &Value, key: &str) -> Option<f64> {
    value.get(key)?.as_f64()
}

fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let values: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    values?.try_into().ok()
}

fn matrix(value: &Value) -> Option<Matrix> {
    let rows: Option<Vec<[f64; 3]>> = value.as_array()?.iter().map(numbers).collect();
    Some(Matrix(rows?.try_into().ok()?))
}

/// Largest difference of two matrices.
fn difference(a: Matrix, b: Matrix) -> f64 {
    let pairs = a.0.into_iter().flatten().zip(b.0.into_iter().flatten());
    pairs.fold(0.0, |worst, (a, b)| if (a - b).abs() <= worst { worst } else { (a - b).abs() })
}

fn geodetic(case: &Value, judge: &mut Judge) -> Option<()> {
    let input = case.get("input")?;
    let (lat_deg, lon_deg) = (number(input, "lat_deg")?, number(input, "lon_deg")?);
    let place = Geodetic::from_degrees(lat_deg, lon_deg, number(input, "h")?);
    let expected = Ecef::from_xyz_m(numbers(case.get("expected")?.get("ecef")?)?);
    let found = place.to_ecef();
    judge.number("forward, m", found.distance_m(expected), 0.0, number(case, "tol_forward_m")?);

    let back = expected.to_geodetic();
    let radius_m = geodesy::SEMI_MAJOR_AXIS_M + place.height_m.abs();
    let lat_m = (back.lat_rad - place.lat_rad) * radius_m;
    let lat_tol_m = number(case, "tol_inverse_lat_m")?;
    judge.number("inverse, latitude, m", lat_m, 0.0, lat_tol_m);
    let h_tol_m = number(case, "tol_inverse_h_m")?;
    judge.number("inverse, height, m", back.height_m, place.height_m, h_tol_m);
    // A turn along the parallel, as a distance: nothing at the pole, and ±180° are one.
    let turn = libm_remainder(back.lon_rad - place.lon_rad);
    let parallel_m = geodesy::length([expected.x_m, expected.y_m, 0.0]);
    judge.number("inverse, longitude, m", turn * parallel_m, 0.0, lat_tol_m);
    for point in [[0.0, 0.0, 0.0], [0.0, 0.0, 6.4e6], [0.0, 0.0, -6.4e6], [1.0, 0.0, 0.0]] {
        let g = Ecef::from_xyz_m(point).to_geodetic();
        let finite = g.lat_rad.is_finite() && g.lon_rad.is_finite() && g.height_m.is_finite();
        judge.holds("the centre and the poles are finite", finite);
    }
    Some(())
}

/// Brought into [−π, π].
fn libm_remainder(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle_rad - turn * (angle_rad / turn).round_ties_even()
}

fn ecef_enu(case: &Value, judge: &mut Judge) -> Option<()> {
    let input = case.get("input")?;
    let origin = Geodetic::from_degrees(
        number(input, "origin_lat_deg")?,
        number(input, "origin_lon_deg")?,
        number(input, "origin_h")?,
    );
    let point = Ecef::from_xyz_m(numbers(input.get("ecef")?)?);
    let frame = LocalFrame::at(origin);
    let tolerance = number(case, "tol")?;
    let expected: [f64; 3] = numbers(case.get("expected")?.get("enu")?)?;
    let found = frame.to_enu(point);
    for (i, axis) in ["east, m", "north, m", "up, m"].into_iter().enumerate() {
        judge.number(axis, found.to_array()[i], expected[i], tolerance);
    }
    let back_m = frame.to_ecef(found).distance_m(point);
    judge.number("there and back, m", back_m, 0.0, tolerance);
    Some(())
}

fn euler(case: &Value, judge: &mut Judge) -> Option<()> {
    let input = case.get("input")?;
    let euler = Euler {
        psi_rad: number(input, "psi")?,
        theta_rad: number(input, "theta")?,
        phi_rad: number(input, "phi")?,
    };
    let tolerance = number(case, "tol")?;
    let expected = case.get("expected")?;
    let world_to_body = matrix(expected.get("R_world_to_body")?)?;
    judge.number("matrix", difference(euler.matrix(), world_to_body), 0.0, tolerance);
    let [w, x, y, z] = numbers(expected.get("quat_wxyz")?)?;
    let Quaternion { w: fw, x: fx, y: fy, z: fz } = euler.quaternion();
    for (name, found, expected) in [("w", fw, w), ("x", fx, x), ("y", fy, y), ("z", fz, z)] {
        judge.number(name, found, expected, tolerance);
    }
    let rebuilt = world_to_body.euler().matrix();
    let (psi, angles) = (number(expected, "psi_minus_phi")?, world_to_body.euler());
    let off = angles.psi_rad - angles.phi_rad - psi;
    let turns = (off / std::f64::consts::TAU).round();
    judge.number("psi - phi of the matrix", off - turns * std::f64::consts::TAU, 0.0, tolerance);
    judge.number("matrix from angles from matrix", difference(rebuilt, world_to_body), 0.0, 4e-16);
    Some(())
}

fn dead_reckoning(case: &Value, judge: &mut Judge) -> Option<()> {
    let input = case.get("input")?;
    let omega: [f64; 3] = numbers(input.get("omega")?)?;
    let dt_s = number(input, "dt")?;
    let velocity_mps: [f64; 3] = numbers(input.get("v_body")?)?;
    let acceleration_mps2: [f64; 3] = numbers(input.get("a_body")?)?;
    let tolerance = number(case, "tol")?;
    let expected = case.get("expected")?;
    let rot = matrix(expected.get("rot")?)?;
    let way: [f64; 3] = numbers(expected.get("displacement")?)?;

    let found = dead_reckoning::rotation(omega, dt_s);
    judge.number("rotation", difference(found, rot), 0.0, tolerance);
    let found = dead_reckoning::body_displacement(omega, dt_s, velocity_mps, acceleration_mps2);
    let off = geodesy::length([0, 1, 2].map(|i| found[i] - way[i]));
    let scale = geodesy::length(way).max(f64::MIN_POSITIVE);
    judge.number("displacement, relative", off / scale, 0.0, tolerance);
    // And through the model that uses both (RVB, 8), from the origin of the world axes.
    let moved = dead_reckoning::Motion {
        algorithm: pdu::enumerations::DeadReckoningAlgorithm::RVB,
        velocity_mps,
        acceleration_mps2,
        angular_velocity_rad_s: omega,
        ..Default::default()
    }
    .after(dt_s);
    let off = geodesy::length([0, 1, 2].map(|i| moved.location.xyz_m()[i] - way[i]));
    judge.number("model 8, location, relative", off / scale, 0.0, tolerance);
    let turned = difference(moved.attitude.transposed(), rot);
    judge.number("model 8, orientation", turned, 0.0, tolerance);
    Some(())
}

fn dis_timestamp(case: &Value, judge: &mut Judge) -> Option<()> {
    let input = case.get("input")?;
    let expected = case.get("expected")?;
    let exact = |judge: &mut Judge, name: &str, found: i64| -> Option<()> {
        judge.number(name, found as f64, expected.get(name)?.as_i64()? as f64, 0.0);
        Some(())
    };
    if let Some(seconds) = input.get("seconds_past_hour") {
        let nanos = (seconds.as_f64()? * 1e9).round();
        let nearest = DisTime::absolute(nanos as u64);
        let floor = DisTime::absolute_not_after(nanos as u64);
        exact(judge, "ticks_nearest", i64::from(nearest.units()))?;
        exact(judge, "ticks_floor", i64::from(floor.units()))?;
        exact(judge, "word_absolute_floor", i64::from(floor.0))?;
        let relative = DisTime::relative(nanos as u64);
        judge.holds("relative differs in the lowest bit", relative.0 == nearest.0 & !1);
    } else {
        let ticks = |key| u32::try_from(input.get(key)?.as_u64()?).ok().filter(|t| t >> 31 == 0);
        let a = DisTime(ticks("ticks_a")? << 1 | 1);
        let b = DisTime(ticks("ticks_b")? << 1 | 1);
        exact(judge, "signed_ticks", i64::from(a.units_since(b)))?;
        let seconds = number(expected, "seconds")?;
        let ulp = seconds.abs() * f64::EPSILON;
        judge.number("seconds", a.seconds_since(b), seconds, ulp);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wire_vector_passes() {
        crate::assert_all_pass(&[
            ("tracking/geodetic", 12),
            ("tracking/ecef_enu", 4),
            ("tracking/euler", 7),
            ("tracking/dead_reckoning", 10),
            ("tracking/dis_timestamp", 14),
        ]);
    }

    #[test]
    fn a_changed_expectation_of_angles_fails() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/vectors");
        let text = std::fs::read_to_string(root.join("tracking/euler.json")).expect("the file");
        let whole: Value = serde_json::from_str(&text).expect("JSON");
        for case in whole["cases"].as_array().expect("cases") {
            let mut case = case.clone();
            let Some(turn) = case["expected"]["psi_minus_phi"].as_f64() else { continue };
            case["expected"]["psi_minus_phi"] = Value::from(turn + 1e-12);
            let mut judge = Judge::default();
            euler(&case, &mut judge).expect("read");
            assert!(judge.case("").worst > 1.0, "{}", case["name"]);
        }
    }

    #[test]
    fn what_cannot_be_read_fails() {
        for stem in ["geodetic", "ecef_enu", "euler", "dead_reckoning", "dis_timestamp"] {
            let check = check_for(stem).expect(stem);
            for text in [
                r#"{"cases": [{}]}"#,
                r#"{"cases": [{"input": 3, "expected": [], "tol": "x"}]}"#,
                r#"{"cases": [{"input": {"ticks_a": 4294967295, "ticks_b": 1}, "expected": {}}]}"#,
                r#"{"cases": [null]}"#,
            ] {
                let file = serde_json::from_str(text).expect(text);
                let cases = check(&file);
                assert_eq!(cases.len(), 1, "{stem}: {text}");
                assert!(cases[0].worst.is_infinite(), "{stem}: {text}: {:?}", cases[0]);
            }
            assert!(check(&Value::Null).is_empty());
        }
    }
}
