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

/// Whether the item `I010/042` of any record says that: a number, a list of numbers in the order of its table, or a text:
/// words and values in that order (`SAC 0 SIC 7`, `APC 2.0 2.25`), or `NAME=value`. Where nothing can be held against
/// octets it does not.
fn expect(found: &Value, item: &str, expected: &Value) -> bool {
    let Some((number, id)) = item.strip_prefix('I').and_then(|i| i.split_once('/')) else {
        return item == "blocks" && expected.as_u64() == found.as_array().map(|b| b.len() as u64);
    };
    let number: Option<u64> = number.parse().ok();
    // "202 raw" is in its steps, "202 at 0.25 m/s" as it is told.
    let (id, unit) = id.split_once(' ').unwrap_or((id, ""));
    let step = if unit == "raw" { RAW_STEP } else { 1.0 };
    let blocks = found.as_array().into_iter().flatten().filter(|b| b[0].as_u64() == number);
    let records = blocks.flat_map(|b| b[1].as_array().into_iter().flatten());
    let items: Vec<&Value> = records.filter_map(|r| r.get(id)).collect();
    match expected {
        Value::Number(_) => {
            let wanted = expected.as_f64().unwrap_or(f64::NAN) * step;
            items.iter().any(|i| leaves(i).iter().any(|n| near(&[*n], &[wanted])))
        }
        Value::Array(_) => {
            let wanted: Vec<f64> = leaves(expected).iter().map(|n| n * step).collect();
            // A list of one number a record is that item over the records.
            let all: Vec<f64> = items.iter().flat_map(|i| leaves(i)).collect();
            items.iter().any(|i| near(&leaves(i), &wanted)) || near(&all, &wanted)
        }
        Value::String(text) if text.contains([' ', '=']) => items.iter().any(|i| says(i, text)),
        Value::String(text) => items.iter().any(|item| {
            let address = u64::from_str_radix(text, 16).ok();
            let text = Value::from(text.as_str());
            **item == text
                || item.as_object().is_some_and(|fields| fields.values().any(|v| *v == text))
                || (item.is_u64() && item.as_u64() == address)
        }),
        _ => false,
    }
}

/// Steps of item 202 in category 010, m/s.
const RAW_STEP: f64 = 0.25;

fn near(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 5e-3)
}

/// Whether an item says what a text does: parts between `;` are of an entry of a list each.
fn says(item: &Value, text: &str) -> bool {
    let (parts, entries) = (text.split("; "), item.as_array().map_or(&[][..], Vec::as_slice));
    if !item.is_array() {
        return said(item, text);
    }
    parts.clone().count() == entries.len() && parts.zip(entries).all(|(part, e)| bits(e, part))
}

/// `BKN1 I10=1`, `BKN1 all 1`: a bank of twelve bars, the first of which is the highest bit.
fn bits(bank: &Value, text: &str) -> bool {
    let Some((name, rest)) = text.split_once(' ') else { return false };
    let number = name.strip_prefix("BKN").and_then(|n| n.parse::<u64>().ok());
    let lit = if rest == "all 1" {
        Some((1..=12).collect())
    } else {
        let bar = |word: &str| word.strip_prefix('I')?.strip_suffix("=1")?.parse::<u32>().ok();
        rest.split(' ').map(bar).collect::<Option<Vec<u32>>>()
    };
    let mask = lit.filter(|l| l.iter().all(|i| (1..=12).contains(i)));
    let mask = mask.map(|lit| lit.iter().fold(0, |mask, i| mask | 1 << (12 - i)));
    number.is_some() && bank["BKN"].as_u64() == number && bank["I"].as_u64() == mask
}

/// Words that name a field, each followed by all its values; a value without one is any field's.
fn said(item: &Value, text: &str) -> bool {
    let Some(fields) = item.as_object() else { return false };
    let mut words = text.split(' ').peekable();
    while let Some(word) = words.next() {
        if let Some((name, value)) = word.split_once('=') {
            let found = fields.get(name).and_then(Value::as_f64);
            if found.is_none() || found != value.parse().ok() {
                return false;
            }
            continue;
        }
        let Some(field) = fields.get(word) else {
            let number = word.parse::<f64>().ok();
            if !number.is_some_and(|n| leaves(item).iter().any(|found| near(&[*found], &[n]))) {
                return false;
            }
            continue;
        };
        let mut values = Vec::new();
        while let Some(value) = words.next_if(|w| !fields.contains_key(*w)) {
            values.push(value);
        }
        let same = match field {
            Value::String(text) => values == [text.as_str()],
            Value::Array(list) => list.len() == 1 && list.iter().all(|one| timed(one, &values)),
            _ => {
                let numbers: Option<Vec<f64>> = values.iter().map(|v| v.parse().ok()).collect();
                numbers.is_some_and(|numbers| near(&leaves(field), &numbers))
            }
        };
        if !same {
            return false;
        }
    }
    true
}

/// `typ 2 10:12:30`: a time of departure or arrival.
fn timed(time: &Value, words: &[&str]) -> bool {
    let ["typ", kind, clock] = words else { return false };
    let field = |name: &str| time[name].as_u64().map(|n| format!("{n:02}"));
    let clock_of = ["HOR", "MIN", "SEC"].map(|name| field(name).unwrap_or_default());
    time["TYP"].as_u64().map(|n| n.to_string()).as_deref() == Some(kind)
        && clock_of.join(":") == *clock
}

/// Fields of two and more numbers in the order of their tables.
const ORDER: [&str; 22] = [
    "CAT",
    "MAIN",
    "SUB",
    "LAT",
    "LON",
    "RHO",
    "TH",
    "X",
    "Y",
    "XY",
    "VX",
    "VY",
    "AX",
    "AY",
    "GSP",
    "TRA",
    "LENGTH",
    "ORIENTATION",
    "WIDTH",
    "DEVX",
    "DEVY",
    "COV",
];

/// The numbers of a value in the order of its table; knots of speeds, as the files say them.
fn leaves(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(leaves).collect(),
        Value::Object(fields) => {
            let rank = |name: &str| ORDER.iter().position(|n| *n == name).unwrap_or(ORDER.len());
            let mut fields: Vec<_> = fields.iter().filter(|(name, _)| *name != "_parts").collect();
            fields.sort_by_key(|(name, _)| rank(name));
            let numbers = fields.into_iter().flat_map(|(name, value)| {
                let knots = value.as_f64().filter(|_| name == "GSP").map(|nm| vec![nm * 3600.0]);
                knots.unwrap_or_else(|| leaves(value))
            });
            numbers.collect()
        }
        _ => value.as_f64().into_iter().collect(),
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

    /// Nor does a remark that says something else pass: a pair the other way round, another word of a text.
    #[test]
    fn a_changed_expectation_fails() {
        let other = |word: &str| {
            let (head, last) = word.split_at(word.len() - 1);
            let last = last.bytes().next().unwrap_or(b'0');
            format!("{head}{}", char::from(if last == b'9' { b'8' } else { last + 1 }))
        };
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/vectors");
        let path = root.join("asterix/asterix-vectors.json");
        let text = std::fs::read_to_string(path).expect("the file");
        let file: Value = serde_json::from_str(&text).expect("JSON");
        let mut count = 0;
        for case in file["vectors"].as_array().expect("vectors") {
            for (item, expected) in case["expect"].as_object().into_iter().flatten() {
                let mut changed = Vec::new();
                match expected {
                    Value::Number(n) => changed.push(object!(n.as_f64().expect("a number") + 1.0)),
                    Value::Array(list) => {
                        changed.push(Value::Array(list.iter().rev().cloned().collect()));
                        let mut more = list.clone();
                        more[0] = list[0].as_f64().map_or(Value::Null, |n| object!(n + 1.0));
                        changed.push(Value::Array(more));
                    }
                    Value::String(text) => {
                        let words: Vec<&str> = text.split(' ').collect();
                        for k in 0..words.len() {
                            let mut words: Vec<String> =
                                words.iter().map(|w| (*w).to_owned()).collect();
                            let end = if words[k].ends_with(';') { ";" } else { "" };
                            words[k] = other(words[k].trim_end_matches(';')) + end;
                            changed.push(Value::from(words.join(" ")));
                        }
                    }
                    _ => panic!("{item}"),
                }
                for changed in changed {
                    let mut case = case.clone();
                    case["expect"] = object!({});
                    case["expect"][item] = changed.clone();
                    let mut judge = Judge::default();
                    assert_eq!(good(&case, &mut judge), Some(()), "{}", case["name"]);
                    assert!(judge.case("").worst > 1.0, "{item}: {expected} as {changed}");
                    count += 1;
                }
            }
        }
        assert!(count > 100, "{count} changes");
        // Nor what cannot be held against octets.
        let found = object!([[10, [{"020": {"TYP": 3}, "220": 3_958_150}]]]);
        assert!(expect(&found, "I010/020", &object!("TYP=3")));
        for (item, expected) in [
            ("I010/020", object!("FOO=x")),
            ("I010/020", Value::Null),
            ("I010/020", object!({"TYP": 3})),
            ("I010/021 raw", object!([3])),
            ("remark", object!(1)),
        ] {
            assert!(!expect(&found, item, &expected), "{item} {expected}");
        }
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
