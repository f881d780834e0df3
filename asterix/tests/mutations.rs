//! A million mutated datagrams: none panics, none costs more than its octets. The long proof is the example `mutate`.

#[path = "support/mutations.rs"]
mod mutations;

use mutations::{Random, Seen, mutate, read, sound};
use std::path::Path;

#[test]
fn a_million_mutated_datagrams_are_read_or_refused() {
    let sound = sound(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    assert!(sound.len() >= 55, "{} vectors", sound.len());
    let (mut random, mut datagram, mut seen) = (Random(1), Vec::new(), Seen::default());
    for _ in 0..1_000_000 {
        mutate(&mut random, &sound, &mut datagram);
        read(&datagram, &mut seen);
    }
    println!("{seen:?}");
    // Neither all refused nor all sound: the mutations reach both.
    assert!(seen.records > 500_000 && seen.refused > 200_000, "{seen:?}");
}
