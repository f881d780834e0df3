//! Checks of the satellite positioning vectors and of the other reporting sensors.

use crate::{CaseResult, Check, Judge};
use geodesy::{Geodetic, LocalFrame};
use models::frames::Point2;
use models::sensors::adsb::{
    lag_m, latitude_step_m, position_uncertainty_m, rounding_sigma, sigma_of_radius_95,
};
use models::sensors::dgps::DifferentialBudget;
use models::sensors::induction_loop::{LoopPair, occupancy_s};
use models::sensors::mlat::ArrivalGeometry;
use models::sensors::radar::radial::radial_quantile;
use models::sensors::reporting::constellation::{Constellation, Dop, in_view, look};
use models::sensors::reporting::gauss_markov::{Gm1Step, Gm2Step, averaged_variance_ratio};
use models::sensors::reporting::service::{
    Alternating, FailureMode, down_independent, down_single_repair, position_probability,
    reference_continuity, reference_loss_probability, slot_down, slot_up,
};
use serde_json::Value;

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    Some(match stem {
        "constellation" => |d| each(d, constellation),
        "dop" => |d| each(d, dop),
        "radial_quantiles" => |d| each(d, radial_quantiles),
        "availability" => |d| each(d, availability),
        "service_chain" => |d| each(d, service_chain),
        "gauss_markov" => |d| each(d, gauss_markov),
        "dgps" => |d| each(d, dgps),
        "mlat" => |d| each(d, mlat),
        "adsb" => |d| each(d, adsb),
        "loops" => |d| each(d, loops),
        _ => return None,
    })
}

/// What the product found for one case, by name.
type Found = Vec<(&'static str, Value)>;

/// Runs `body` over all cases. A case fails if its input is missing, malformed or outside the domain,
/// if it expects nothing, or something that `body` does not find.
fn each(document: &Value, body: fn(&Value) -> Option<Found>) -> Vec<CaseResult> {
    let cases = document["cases"].as_array().map_or(&[][..], Vec::as_slice);
    let run = |(index, case): (usize, &Value)| {
        let mut judge = Judge::default();
        let expected = case["expected"].as_object().filter(|e| !e.is_empty());
        match (expected, body(&case["input"])) {
            (Some(expected), Some(found)) => {
                for (quantity, expected) in expected {
                    match found.iter().find(|(name, _)| name == quantity) {
                        Some((_, found)) => {
                            compare(document, &mut judge, quantity, found, expected);
                        }
                        None => judge.holds(&format!("{quantity}: not answered"), false),
                    }
                }
            }
            (None, _) => judge.holds("expected values", false),
            (_, None) => judge.holds("input within the domain", false),
        }
        let name = case.get("name").and_then(Value::as_str);
        judge.case(name.map_or_else(|| format!("case {index}"), str::to_owned))
    };
    cases.iter().enumerate().map(run).collect()
}

/// Numbers by tolerance, lists element by element, everything else by equality.
fn compare(document: &Value, judge: &mut Judge, quantity: &str, found: &Value, expected: &Value) {
    match (found, expected) {
        (Value::Number(_), Value::Number(_)) => {
            let (found, expected) = (float(found), float(expected));
            judge.number(quantity, found, expected, tolerance(document, quantity, expected));
        }
        (Value::Array(found), Value::Array(expected)) => {
            judge.holds(&format!("{quantity}: length"), found.len() == expected.len());
            for (found, expected) in found.iter().zip(expected) {
                compare(document, judge, quantity, found, expected);
            }
        }
        _ => judge.holds(quantity, found == expected),
    }
}

fn float(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn tolerance(document: &Value, quantity: &str, expected: f64) -> f64 {
    let table = &document["tolerance"];
    let entry = table.get(quantity).or_else(|| table.get("*"));
    let part = |name| entry.and_then(|e| e.get(name)).and_then(Value::as_f64).unwrap_or(0.0);
    f64::max(part("abs"), part("rel") * expected.abs())
}

/// A finite number of the input.
fn number(input: &Value, key: &str) -> Option<f64> {
    input.get(key)?.as_f64().filter(|x| x.is_finite())
}

/// A number above zero.
fn positive(input: &Value, key: &str) -> Option<f64> {
    number(input, key).filter(|x| *x > 0.0)
}

/// A number of at least zero.
fn at_least_zero(input: &Value, key: &str) -> Option<f64> {
    number(input, key).filter(|x| *x >= 0.0)
}

fn list(values: impl IntoIterator<Item = f64>) -> Value {
    values.into_iter().map(Value::from).collect()
}

fn frame(input: &Value) -> Option<LocalFrame> {
    let place = [number(input, "lat")?, number(input, "lon")?, number(input, "h")?];
    (place[0].abs() <= 90.0)
        .then(|| LocalFrame::at(Geodetic::from_degrees(place[0], place[1], place[2])))
}

fn constellation(input: &Value) -> Option<Found> {
    let constellation = Constellation::reference_24();
    let slot = &constellation.slots[constellation.slot(input.get("slot")?.as_str()?)?];
    let satellite = constellation.position(slot, number(input, "t")?);
    let [x, y, z] = satellite.xyz_m();
    let seen = look(&frame(input)?, satellite);
    Some(vec![
        ("x", x.into()),
        ("y", y.into()),
        ("z", z.into()),
        ("el", seen.elevation_rad.into()),
        ("az", seen.azimuth_rad.into()),
        ("range", seen.range_m.into()),
    ])
}

fn dop(input: &Value) -> Option<Found> {
    let constellation = Constellation::reference_24();
    let mut removed = Vec::new();
    for name in input.get("removed")?.as_array()? {
        removed.push(constellation.slot(name.as_str()?)?);
    }
    let mask_rad = number(input, "mask")?.to_radians();
    let t_s = number(input, "t")?;
    let views = in_view(&constellation, &frame(input)?, t_s, mask_rad, |s| removed.contains(&s));
    let units: Vec<_> = views.iter().map(|v| v.look.unit).collect();
    let used: Vec<_> = views.iter().map(|v| constellation.slots[v.slot].name.clone()).collect();
    let mut found: Found = vec![("n", units.len().into()), ("used", used.into())];
    // Without a fix nothing else is answered; a file that expects more then fails.
    if let Some(dop) = Dop::of(&units, &[]) {
        let shift = |unit: &[f64; 3]| {
            let [east, north, _] = dop.shift_per_metre(*unit, 1.0);
            libm::hypot(east, north)
        };
        found.extend([
            ("N", dop.north().into()),
            ("E", dop.east().into()),
            ("V", dop.vertical().into()),
            ("T", dop.time().into()),
            ("H", dop.horizontal().into()),
            ("P", dop.position().into()),
            ("G", dop.geometric().into()),
            ("Q_EN", dop.q[0][1].into()),
            ("S_row_H_max", units.iter().map(shift).fold(0.0, f64::max).into()),
        ]);
    }
    Some(found)
}

fn radial_quantiles(input: &Value) -> Option<Found> {
    let r = radial_quantile(
        number(input, "sigma_N")?,
        number(input, "sigma_E")?,
        number(input, "mean_N")?,
        number(input, "mean_E")?,
        number(input, "q")?,
    )?;
    Some(vec![("r", r.into())])
}

fn availability(input: &Value) -> Option<Found> {
    let mut modes = Vec::new();
    for mode in input.get("modes")?.as_array()? {
        modes.push(FailureMode {
            mtbf: positive(mode, "mtbf")?,
            mttr: at_least_zero(mode, "mttr")?,
        });
    }
    let first = modes.first()?;
    let slots = u32::try_from(input.get("n")?.as_u64()?).ok().filter(|n| *n <= 1000)?;
    let mut times = Vec::new();
    for t in input.get("t")?.as_array()? {
        times.push(t.as_f64().filter(|t| *t >= 0.0)?);
    }
    let alternating = Alternating::from_mtbf(first.mtbf, first.mttr);
    Some(vec![
        ("slot_up", slot_up(&modes).into()),
        ("unavailability", slot_down(&modes).into()),
        ("binomial_down_0_5", list((0..=5).map(|k| down_independent(&modes, slots, k)))),
        (
            "single_server_down_0_5_first_mode",
            list((0..=5).map(|k| down_single_repair(first, slots, k))),
        ),
        ("p_up_t_first_mode", list(times.iter().map(|t| alternating.up_after(true, *t)))),
        ("p_down_t_first_mode", list(times.iter().map(|t| alternating.down_after(*t)))),
    ])
}

fn service_chain(input: &Value) -> Option<Found> {
    let gps =
        position_probability(number(input, "Pc")?, number(input, "Psa")?, number(input, "Psr")?);
    let (phase, mtbf) = (at_least_zero(input, "T")?, positive(input, "mtbf_ref")?);
    let continuity = reference_continuity(phase, mtbf);
    Some(vec![
        ("P_gps", gps.into()),
        ("Prsc", continuity.into()),
        ("one_minus_Prsc", reference_loss_probability(phase, mtbf).into()),
        ("P_dgps", (gps * continuity).into()),
    ])
}

fn gauss_markov(input: &Value) -> Option<Found> {
    let (sigma, tau_s) = (at_least_zero(input, "sigma")?, positive(input, "tau")?);
    let dt_s = at_least_zero(input, "dt")?;
    let (first, second) = (Gm1Step::new(sigma, tau_s, dt_s), Gm2Step::new(sigma, tau_s, dt_s));
    let matrix = |rows: [[f64; 2]; 2]| rows.into_iter().map(list).collect::<Value>();
    Some(vec![
        ("phi", first.phi.into()),
        ("q", first.q.into()),
        ("Phi", matrix(second.phi)),
        ("Q", matrix([[second.q11, second.q12], [second.q12, second.q22]])),
        ("avg_var_ratio", averaged_variance_ratio(tau_s, dt_s).into()),
    ])
}

fn dgps(input: &Value) -> Option<Found> {
    let budget = DifferentialBudget {
        sigma_user_m: number(input, "sigma_user")?,
        sigma_ref_m: number(input, "sigma_ref")?,
        iono_gradient: number(input, "g_iono")?,
        obliquity: number(input, "OF")?,
        smoothing_s: number(input, "tau_smooth")?,
        space_decorrelation: number(input, "k_space")?,
        correction_acceleration_ms2: number(input, "a")?,
    };
    let sigma_m = budget.sigma_m(number(input, "d")?, number(input, "v")?, number(input, "age")?);
    Some(vec![("sigma", sigma_m.into())])
}

fn mlat(input: &Value) -> Option<Found> {
    let point = |value: &Value| Some(Point2::new(number(value, "x")?, number(value, "y")?));
    let mut stations = Vec::new();
    for station in input.get("stations")?.as_array()? {
        stations.push(point(station)?);
    }
    let sigma_t_s = positive(input, "sigma_t")?;
    let geometry = ArrivalGeometry::of(&stations, point(input.get("target")?)?)?;
    let [east, cross, north] = geometry.covariance_m2(sigma_t_s);
    Some(vec![
        ("hdop", geometry.horizontal().into()),
        ("sigma_x", east.sqrt().into()),
        ("sigma_y", north.sqrt().into()),
        ("cov_xy", cross.into()),
    ])
}

fn adsb(input: &Value) -> Option<Found> {
    let radius_m = position_uncertainty_m(u8::try_from(input.get("nacp")?.as_u64()?).ok()?)?;
    let lag = lag_m(number(input, "speed")?, number(input, "latency")?);
    Some(vec![
        ("epu", radius_m.into()),
        ("sigma", sigma_of_radius_95(radius_m).into()),
        ("lat_step_even", latitude_step_m(false).into()),
        ("lat_quant_sigma", rounding_sigma(latitude_step_m(false)).into()),
        ("lag", lag.into()),
    ])
}

fn loops(input: &Value) -> Option<Found> {
    let pair =
        LoopPair { spacing_m: positive(input, "s")?, sigma_spacing_m: number(input, "sigma_s")? };
    let speed_mps = positive(input, "v")?;
    let occupancy = occupancy_s(number(input, "L")?, number(input, "L_loop")?, speed_mps);
    Some(vec![
        ("dt", pair.passage_s(speed_mps).into()),
        ("sigma_v", pair.sigma_speed_mps(speed_mps, number(input, "sigma_t")?).into()),
        ("occupancy", occupancy.into()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Files of this module with the cases that the repository's copies have.
    const FILES: [(&str, usize); 10] = [
        ("gnss/adsb", 4),
        ("gnss/availability", 3),
        ("gnss/constellation", 15),
        ("gnss/dgps", 3),
        ("gnss/dop", 48),
        ("gnss/gauss_markov", 6),
        ("gnss/loops", 2),
        ("gnss/mlat", 2),
        ("gnss/radial_quantiles", 15),
        ("gnss/service_chain", 3),
    ];

    #[test]
    fn every_gnss_vector_passes() {
        crate::assert_all_pass(&FILES);
    }

    #[test]
    fn what_is_wrong_fails_and_nothing_panics() {
        for (name, stem, case) in [
            ("nothing", "adsb", json!({})),
            ("no expectation", "adsb", json!({"input": {"nacp": 9, "speed": 0, "latency": 0}})),
            (
                "unknown quantity",
                "adsb",
                json!({"input": {"nacp": 9, "speed": 0, "latency": 0}, "expected": {"x": 1.0}}),
            ),
            (
                "wrong value",
                "adsb",
                json!({"input": {"nacp": 9, "speed": 0, "latency": 0}, "expected": {"epu": 31.0}}),
            ),
            (
                "a number for a list",
                "availability",
                json!({"input": {"modes": [{"mtbf": 1.0, "mttr": 1.0}], "n": 24, "t": [1.0]},
                       "expected": {"binomial_down_0_5": 0.5}}),
            ),
            (
                "short list",
                "availability",
                json!({"input": {"modes": [{"mtbf": 1.0, "mttr": 1.0}], "n": 24, "t": []},
                       "expected": {"p_up_t_first_mode": [1.0]}}),
            ),
            (
                "no modes",
                "availability",
                json!({"input": {"modes": [], "n": 24, "t": []}, "expected": {"slot_up": 1.0}}),
            ),
            (
                "no such slot",
                "constellation",
                json!({"input": {"t": 0, "slot": "Z9", "lat": 0, "lon": 0, "h": 0}, "expected": {"x": 0}}),
            ),
            (
                "an answer where there is no fix",
                "dop",
                json!({"input": {"t": 0, "lat": 0, "lon": 0, "h": 0, "mask": 80, "removed": []},
                       "expected": {"P": 2.0}}),
            ),
            (
                "two stations",
                "mlat",
                json!({"input": {"stations": [{"x": 0, "y": 0}, {"x": 1, "y": 0}],
                       "target": {"x": 0, "y": 1}, "sigma_t": 1e-9}, "expected": {"hdop": 1.0}}),
            ),
            (
                "no width",
                "radial_quantiles",
                json!({"input": {"sigma_N": 0, "sigma_E": 1, "mean_N": 0, "mean_E": 0, "q": 0.5},
                       "expected": {"r": 0}}),
            ),
        ] {
            let check = check_for(stem).expect(stem);
            let document = json!({"tolerance": {"*": {"rel": 1e-9}}, "cases": [case]});
            let results = check(&document);
            assert_eq!(results.len(), 1, "{name}");
            assert!(results[0].worst > 1.0, "{name}: {:?}", results[0]);
        }
        assert!(check_for("adsb").expect("known")(&json!({"cases": 7})).is_empty());
    }
}
