//! Reading does not allocate, and damaged input does not make it.

use asterix::{Packer, blocks, cat010, json};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static COUNTER: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Without the test harness: its threads allocate, and the counter counts the whole process.
fn main() {
    let path = "../tests/data/vectors/asterix/asterix-vectors-2.json";
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let text = std::fs::read_to_string(path).expect("the vectors");
    let file: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let list = |key: &str| file[key].as_array().expect("a list").clone();
    let hex = |case: &serde_json::Value| json::octets(case["hex"].as_str().expect("hex"));
    let cases = [list("vectors"), list("bad")].concat();
    let datagrams: Vec<Vec<u8>> = cases.iter().map(|c| hex(c).expect("digits")).collect();

    let region = Region::new(COUNTER);
    let (mut records, mut values, mut refused) = (0, 0.0, 0);
    for datagram in &datagrams {
        for block in blocks(datagram) {
            let Ok(block) = block else {
                refused += 1;
                break;
            };
            for record in block.records() {
                let Ok(record) = record else {
                    refused += 1;
                    break;
                };
                records += 1;
                record.each(|datum| values += datum.number().unwrap_or(1.0));
                for item in record.items() {
                    let subitems = item.subitems().flat_map(|s| s.values());
                    for (_, value) in item.values().chain(subitems) {
                        values += value.number().unwrap_or(1.0);
                    }
                }
            }
        }
    }
    let change = region.change();
    assert!(records > 60 && refused == 9 && values != 0.0, "{records} {refused} {values}");
    assert_eq!(change.allocations + change.reallocations, 0, "while reading");

    let mut packer = Packer::new(1400);
    let region = Region::new(COUNTER);
    for _ in 0..80 {
        let written = packer.record(&cat010::CATEGORY, |items| {
            items.put(&cat010::I010, &[0, 1])?;
            items.put(&cat010::I000, &[2])?;
            items.put(&cat010::I140, &[36_000.0])
        });
        assert!(written.is_ok());
    }
    assert_eq!(region.change().allocations, 0, "while writing into a datagram");
}
