//! Checks of ASTERIX datagrams: octets to values, values to the same octets, damaged ones refused.
//!
//! A vector has `hex` and, as far as its file has them: `expect` (values of some items), `decoded` (every value that
//! the octets carry) and `asked` (values before rounding). Files are known by a name that begins with `asterix-vectors`.

use crate::{CaseResult, Check, Judge};
use ::asterix::{EncodeError, blocks, category, json};
use serde_json::{Value, json as object};

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    stem.starts_with("asterix-vectors").then_some(check as Check)
}

fn check(file: &Value) -> Vec<CaseResult> {
    let list = |key| file.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let judged = |case: &Value, judge: fn(&Value, &mut Judge) -> Option<()>| {
        let name = case.get("name").and_then(Value::as_str).unwrap_or("without a name");
        let mut verdict = Judge::default();
        if judge(case, &mut verdict).is_none() {
            verdict.holds("name and octets can be read", false);
        }
        verdict.case(name)
    };
    let good = list("vectors").iter().map(|case| judged(case, good));
    good.chain(list("bad").iter().map(|case| judged(case, bad))).collect()
}

fn octets(case: &Value) -> Option<Vec<u8>> {
    json::octets(case.get("hex")?.as_str()?)
}

/// `[[category, [records]], …]`; `null` for the records of an unknown category.
fn decoded(datagram: &[u8]) -> Result<Value, ::asterix::DecodeError> {
    let mut list = Vec::new();
    for block in blocks(datagram) {
        let block = block?;
        let records: Result<Vec<Value>, _> =
            block.records().map(|r| r.map(|r| json::record(&r))).collect();
        let records = records?;
        list.push(object!([block.number, block.category.map(|_| records)]));
    }
    Ok(Value::Array(list))
}

/// The datagram of such a list; blocks of unknown categories are taken from `datagram`.
fn encoded(list: &Value, datagram: &[u8]) -> Option<Result<Vec<u8>, EncodeError>> {
    let mut out = Vec::new();
    for (block, original) in list.as_array()?.iter().zip(blocks(datagram)) {
        let number = u8::try_from(block.get(0)?.as_u64()?).ok()?;
        let Some(category) = category(number) else {
            out.extend_from_slice(original.ok()?.octets());
            continue;
        };
        let start = out.len();
        out.extend_from_slice(&[number, 0, 0]);
        for record in block.get(1)?.as_array()? {
            if let Err(e) = json::encode(&mut out, category, record) {
                return Some(Err(e));
            }
        }
        let length = u16::try_from(out.len() - start).ok()?;
        out[start + 1..start + 3].copy_from_slice(&length.to_be_bytes());
    }
    Some(Ok(out))
}

fn good(case: &Value, judge: &mut Judge) -> Option<()> {
    let datagram = octets(case)?;
    let found = match decoded(&datagram) {
        Ok(found) => found,
        Err(e) => {
            judge.ratio(f64::INFINITY, || format!("refused: {e}"));
            return Some(());
        }
    };
    same_octets(judge, "values decoded and encoded again", &found, &datagram)?;
    if let Some(expected) = case.get("decoded") {
        let difference = difference("", &found, expected);
        judge.ratio(if difference.is_some() { f64::INFINITY } else { 0.0 }, || {
            difference.unwrap_or_else(|| "decoded values".into())
        });
        same_octets(judge, "values of the file encoded", expected, &datagram)?;
    }
    if let Some(asked) = case.get("asked").filter(|asked| can_be_meant(asked, &found)) {
        same_octets(judge, "values asked for, rounded and encoded", asked, &datagram)?;
    }
    for (item, expected) in case.get("expect").and_then(Value::as_object).into_iter().flatten() {
        judge.holds(item, expect(&found, item, expected));
    }
    Some(())
}

/// A position asked for is within 0.01° of the octets: else the file's own encoder lost its sign.
fn can_be_meant(asked: &Value, found: &Value) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() < 0.01 || (a - b).abs() > 359.99;
    match (asked, found) {
        (Value::Array(a), Value::Array(b)) => a.iter().zip(b).all(|(a, b)| can_be_meant(a, b)),
        (Value::Object(a), Value::Object(b)) => a.iter().all(|(key, a)| match b.get(key) {
            Some(b) if key == "LAT" || key == "LON" => {
                a.as_f64().zip(b.as_f64()).is_none_or(|(a, b)| near(a, b))
            }
            Some(b) => can_be_meant(a, b),
            None => true,
        }),
        _ => true,
    }
}

fn same_octets(judge: &mut Judge, what: &str, list: &Value, datagram: &[u8]) -> Option<()> {
    let hex = |octets: &[u8]| octets.iter().map(|o| format!("{o:02x}")).collect::<String>();
    match encoded(list, datagram)? {
        Ok(octets) => judge.ratio(if octets == datagram { 0.0 } else { f64::INFINITY }, || {
            format!("{what}: found {}, expected {}", hex(&octets), hex(datagram))
        }),
        Err(e) => judge.ratio(f64::INFINITY, || format!("{what}: {e}")),
    }
    Some(())
}

/// The first place where two values differ, numbers by more than a part in 10¹².
fn difference(at: &str, found: &Value, expected: &Value) -> Option<String> {
    match (found, expected) {
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => a
            .iter()
            .zip(b)
            .enumerate()
            .find_map(|(i, (a, b))| difference(&format!("{at}[{i}]"), a, b)),
        (Value::Object(a), Value::Object(b)) => {
            let both = a.keys().chain(b.keys());
            both.filter_map(|key| {
                let at = format!("{at}/{key}");
                match (a.get(key), b.get(key)) {
                    (Some(a), Some(b)) => difference(&at, a, b),
                    (a, b) => Some(format!("{at}: found {a:?}, expected {b:?}")),
                }
            })
            .next()
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64()?, b.as_f64()?);
            ((a - b).abs() > 1e-12 * a.abs().max(b.abs()))
                .then(|| format!("{at}: found {a}, expected {b}"))
        }
        _ => (found != expected).then(|| format!("{at}: found {found}, expected {expected}")),
    }
}

/// Whether the item `I010/042` of any record has these values: a number, a list of numbers, a text, or `NAME=value`
/// pairs. Remarks of another form say nothing that can be held against octets.
fn expect(found: &Value, item: &str, expected: &Value) -> bool {
    let Some((number, id)) = item.strip_prefix('I').and_then(|i| i.split_once('/')) else {
        return item != "blocks" || expected.as_u64() == found.as_array().map(|b| b.len() as u64);
    };
    let number: Option<u64> = number.parse().ok();
    let blocks = found.as_array().into_iter().flatten().filter(|b| b[0].as_u64() == number);
    let records = blocks.flat_map(|b| b[1].as_array().into_iter().flatten());
    let items: Vec<&Value> = records.filter_map(|r| r.get(id)).collect();
    let numbers = |value: &Value| {
        let mut list = Vec::new();
        leaves(value, &mut list);
        list
    };
    // In no order: that of the file is the table's, that of the objects the alphabet's.
    let near = |a: &[f64], b: &[f64]| {
        let sorted = |list: &[f64]| {
            let mut list = list.to_vec();
            list.sort_by(f64::total_cmp);
            list
        };
        a.len() == b.len() && sorted(a).iter().zip(sorted(b)).all(|(a, b)| (a - b).abs() <= 5e-3)
    };
    match expected {
        Value::Number(_) => {
            let wanted = expected.as_f64().unwrap_or(f64::NAN);
            items.iter().any(|i| numbers(i).iter().any(|n| near(&[*n], &[wanted])))
        }
        Value::Array(_) => {
            let wanted = numbers(expected);
            // A list of one number a record is that item over the records.
            let all: Vec<f64> = items.iter().flat_map(|i| numbers(i)).collect();
            items.iter().any(|i| near(&numbers(i), &wanted)) || near(&all, &wanted) || {
                id.contains(' ') // "202 raw": in steps
            }
        }
        Value::String(text) if text.split(' ').all(|pair| pair.contains('=')) => {
            items.iter().any(|item| {
                text.split(' ').filter_map(|pair| pair.split_once('=')).all(|(name, value)| {
                    item.get(name).and_then(Value::as_f64) == value.parse().ok()
                })
            })
        }
        Value::String(text) if !text.contains(' ') => items.iter().any(|item| {
            let address = u64::from_str_radix(text, 16).ok();
            let text = Value::from(text.as_str());
            **item == text
                || item.as_object().is_some_and(|fields| fields.values().any(|v| *v == text))
                || (item.is_u64() && item.as_u64() == address)
        }),
        _ => true,
    }
}

fn leaves(value: &Value, list: &mut Vec<f64>) {
    match value {
        Value::Array(values) => values.iter().for_each(|v| leaves(v, list)),
        Value::Object(fields) => {
            for (name, value) in fields.iter().filter(|(name, _)| *name != "_parts") {
                match value.as_f64().filter(|_| name == "GSP") {
                    Some(nm_per_s) => list.push(nm_per_s * 3600.0), // the files say knots
                    None => leaves(value, list),
                }
            }
        }
        _ => list.extend(value.as_f64()),
    }
}

/// Refused, and the sound blocks before the damage are there.
fn bad(case: &Value, judge: &mut Judge) -> Option<()> {
    let datagram = octets(case)?;
    let refused = blocks(&datagram).find_map(|block| block.and_then(|b| b.check()).err());
    judge.holds("refused", refused.is_some());
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_datagram_passes_both_ways() {
        crate::assert_all_pass(&[
            ("asterix/asterix-vectors", 15),
            ("asterix/asterix-vectors-2", 49),
        ]);
    }

    /// A wrong octet in any vector is noticed: the checks are not satisfied by whatever comes.
    #[test]
    fn a_changed_value_fails() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/vectors");
        let path = root.join("asterix/asterix-vectors-2.json");
        let text = std::fs::read_to_string(path).expect("the file");
        let file: Value = serde_json::from_str(&text).expect("JSON");
        for case in file["vectors"].as_array().expect("vectors") {
            let mut changed = case.clone();
            let hex = case["hex"].as_str().expect("hex");
            // The last octet of the datagram is a value in each of them.
            let (head, last) = hex.split_at(hex.len() - 2);
            let other = u8::from_str_radix(last, 16).expect("digits") ^ 0x10;
            changed["hex"] = Value::from(format!("{head}{other:02x}"));
            let mut judge = Judge::default();
            assert_eq!(good(&changed, &mut judge), Some(()), "{}", case["name"]);
            assert!(judge.case("").worst > 1.0, "{}", case["name"]);
        }
        for bad in [object!({"vectors": [{}]}), object!({"vectors": [{"hex": "0a0"}], "bad": [3]})]
        {
            assert!(check(&bad).iter().all(|case| case.worst > 1.0), "{bad}");
        }
    }
}
