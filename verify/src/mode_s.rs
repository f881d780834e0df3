//! Checks of extended squitters: values to octets, octets to what another decoder read, framing.
//!
//! A vector has `hex`, `beast`, `kind` and `asked` (what is to be sent); `cpr`, `movement` and `decoded` as far as its kind has them.

use crate::{CaseResult, Check, Judge};
use ::mode_s::cpr::{self, Span};
use ::mode_s::{
    AirbornePosition, AirborneVelocity, Emitter, Identification, Message, ModeSError,
    OperationalStatus, Reading, SurfacePosition, beast, length_width_code, read,
};
use serde_json::Value;

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    stem.starts_with("mode-s-vectors").then_some(check as Check)
}

fn check(file: &Value) -> Vec<CaseResult> {
    let list = file.get("vectors").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let judged = list.iter().enumerate().map(|(index, case)| {
        let kind = case.get("kind").and_then(Value::as_str).unwrap_or("without a kind");
        let mut judge = Judge::default();
        if one(case, kind, &mut judge).is_none() {
            judge.holds("kind, octets and values can be read", false);
        }
        judge.case(format!("{} {kind}", index + 1))
    });
    judged.collect()
}

/// Frames of the vectors say one second.
const TIME_NS: i64 = 1_000_000_000;

fn one(case: &Value, kind: &str, judge: &mut Judge) -> Option<()> {
    let text = |key: &str| case.get(key).and_then(Value::as_str);
    let hex = text("hex")?;
    let message = match Message::from_hex(hex) {
        Ok(message) => message,
        Err(e) => {
            judge.ratio(f64::INFINITY, || format!("refused: {e}"));
            return Some(());
        }
    };
    let (emitter, reading) = read(&message).ok()?;
    let asked = case.get("asked")?;
    let made = made(asked, kind, emitter, &reading)?;
    judge.ratio(if made == Ok(message) { 0.0 } else { f64::INFINITY }, || match &made {
        Ok(made) => format!("found {}, expected {hex}", made.hex()),
        Err(e) => format!("refused: {e}"),
    });
    let mut framed = Vec::new();
    beast::frame(&mut framed, &message, TIME_NS);
    let octets: String = framed.iter().map(|o| format!("{o:02x}")).collect();
    judge.holds("framing", text("beast")? == octets);
    let taken: Vec<_> = beast::take(&mut framed).into_iter().map(|(_, _, m)| m).collect();
    judge.holds("framing, the other way", taken == [message.0]);
    same_reading(case, &reading, judge)
}

/// What was asked for, as a message.
fn made(
    asked: &Value,
    kind: &str,
    emitter: Emitter,
    reading: &Reading,
) -> Option<Result<Message, ModeSError>> {
    let number = |key: &str| asked.get(key).and_then(Value::as_f64);
    let code =
        |key: &str| asked.get(key).and_then(Value::as_u64).and_then(|n| u8::try_from(n).ok());
    if let Some(format) = code("df") {
        let own = Emitter { format, ..emitter };
        if own != emitter {
            return None;
        }
    }
    let odd = number("odd").map(|n| n == 1.0);
    Some(match kind {
        "surface position" => SurfacePosition {
            lat_deg: number("lat")?,
            lon_deg: number("lon")?,
            speed_kt: number("speed_kt"),
            track_deg: number("track_deg"),
            odd: odd?,
            type_code: code("tc")?,
        }
        .message(emitter),
        "airborne position" => AirbornePosition {
            lat_deg: number("lat")?,
            lon_deg: number("lon")?,
            altitude_ft: number("altitude_ft")?,
            odd: odd?,
        }
        .message(emitter),
        "airborne velocity" => AirborneVelocity {
            east_kt: number("east_kt")?,
            north_kt: number("north_kt")?,
            climb_fpm: number("fpm")?,
        }
        .message(emitter),
        "identification" => {
            let category = u8::from_str_radix(asked.get("category")?.as_str()?, 16).ok()?;
            Identification { callsign: asked.get("callsign")?.as_str()?, category }.message(emitter)
        }
        kind if kind.starts_with("operational status") => {
            let sizes = number("length_m").zip(number("width_m"));
            let of_size = sizes.map(|(length_m, width_m)| length_width_code(length_m, width_m));
            if of_size != code("length_width_code") {
                return None;
            }
            let Reading::Status { version, .. } = reading else { return None };
            if Some(*version) != code("version") {
                return None;
            }
            OperationalStatus {
                length_width_code: of_size,
                nac_p: code("nacp")?,
                sil: code("sil")?,
            }
            .message(emitter)
        }
        _ => return None,
    })
}

/// What the other decoder found, as far as the file says it.
fn same_reading(case: &Value, reading: &Reading, judge: &mut Judge) -> Option<()> {
    let Some(decoded) = case.get("decoded") else { return Some(()) };
    let asked = case.get("asked")?;
    let number = |of: &Value, key: &str| of.get(key).and_then(Value::as_f64);
    let near = || {
        let reference = asked.get("reference").and_then(Value::as_array);
        let of = |i: usize, key: &str| {
            reference.and_then(|r| r.get(i)).and_then(Value::as_f64).or_else(|| number(asked, key))
        };
        Some([of(0, "lat")?, of(1, "lon")?])
    };
    let mut compare = |what: &str, found: Option<f64>, key: &str, tolerance: f64| {
        if let Some(expected) = number(decoded, key) {
            judge.number(what, found.unwrap_or(f64::NAN), expected, tolerance);
        }
    };
    match reading {
        Reading::Surface { type_code, movement, speed_kt, track_deg, report } => {
            let [lat, lon] = cpr::decode(*report, near()?, Span::Surface);
            compare("latitude", Some(lat), "lat", 1e-9);
            compare("longitude", Some(lon), "lon", 1e-9);
            compare("track", *track_deg, "track", 1e-9);
            // The other decoder gives the middle of some steps.
            compare("speed", *speed_kt, "groundspeed", 5.0);
            compare("type code", Some(f64::from(*type_code)), "typecode", 0.0);
            let cpr = case.get("cpr")?.as_array()?;
            let both = [cpr.first()?.as_u64()?, cpr.get(1)?.as_u64()?];
            judge.holds("17-bit values", both == [report.lat, report.lon].map(u64::from));
            judge.holds("movement", case.get("movement")?.as_u64()? == u64::from(*movement));
        }
        Reading::Airborne { altitude_ft, report } => {
            let [lat, lon] = cpr::decode(*report, near()?, Span::Airborne);
            compare("latitude", Some(lat), "latitude", 1e-9);
            compare("longitude", Some(lon), "longitude", 1e-9);
            compare("altitude", *altitude_ft, "altitude", 0.0);
        }
        Reading::Velocity { east_kt, north_kt, climb_fpm } => {
            let speed = east_kt.zip(*north_kt).map(|(e, n)| libm::hypot(e, n));
            // The other decoder rounds down to whole knots.
            compare("speed", speed.map(libm::floor), "groundspeed", 0.0);
            compare("rate of climb", *climb_fpm, "vertical_rate", 0.0);
        }
        Reading::Identification { callsign, category } => {
            compare("category", Some(f64::from(category & 15)), "category", 0.0);
            judge.holds("call sign", decoded.get("callsign")?.as_str()? == callsign);
        }
        Reading::Status { version, nac_p, sil, .. } => {
            compare("version", Some(f64::from(*version)), "version", 0.0);
            compare("NACp", Some(f64::from(*nac_p)), "nac_p", 0.0);
            compare("SIL", Some(f64::from(*sil)), "sil", 0.0);
        }
        Reading::Other(_) => return None,
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_squitter_passes_both_ways() {
        crate::assert_all_pass(&[("mode_s/mode-s-vectors", 77)]);
    }

    /// Another value that is asked for gives other octets, and fails.
    #[test]
    fn a_changed_value_fails() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/vectors");
        let text = std::fs::read_to_string(root.join("mode_s/mode-s-vectors.json")).expect("there");
        let file: Value = serde_json::from_str(&text).expect("JSON");
        let worst = |case: Value| check(&serde_json::json!({"vectors": [case]}))[0].worst;
        for case in file["vectors"].as_array().expect("vectors") {
            for key in ["lat", "lon", "altitude_ft", "east_kt", "north_kt", "nacp", "sil", "odd"] {
                let Some(value) = case["asked"][key].as_f64() else { continue };
                let mut changed = case.clone();
                let step = if key.starts_with('l') { 1e-4 } else { 25.0 };
                changed["asked"][key] = match key {
                    "nacp" | "sil" => Value::from(case["asked"][key].as_u64().expect("whole") - 1),
                    "odd" => Value::from(1 - case["asked"][key].as_u64().expect("whole")),
                    _ => Value::from(value + step),
                };
                assert!(worst(changed) > 1.0, "{key} of {case}");
            }
            let mut changed = case.clone();
            changed["beast"] = Value::from("1a33");
            assert!(worst(changed) > 1.0, "framing of {case}");
        }
        assert!(worst(Value::Null) > 1.0);
    }
}
