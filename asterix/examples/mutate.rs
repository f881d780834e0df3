//! Mutated datagrams in any number: `cargo run --release -p asterix --example mutate -- 100000000 [SEED]`.
//!
//! Ends with a panic at the first that is not read or refused; otherwise says how many there were and how much memory was used.

#[path = "../tests/support/mutations.rs"]
mod mutations;

use mutations::{Random, Seen, mutate, read, sound};
use std::path::Path;

#[expect(clippy::print_stdout, reason = "a program for people")]
fn main() {
    let mut numbers = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = numbers.next().and_then(Result::ok).unwrap_or(1_000_000);
    let seed = numbers.next().and_then(Result::ok).unwrap_or(2);
    let sound = sound(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    let (mut random, mut datagram, mut seen) = (Random(seed), Vec::new(), Seen::default());
    for _ in 0..count {
        mutate(&mut random, &sound, &mut datagram);
        read(&datagram, &mut seen);
    }
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or("VmHWM: unknown");
    println!("{count} datagrams, {seen:?}, {peak}");
}
