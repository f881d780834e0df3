//! Datagrams that were sound once: octets changed, cut, doubled, joined. Shared by the test and the example of that name.

use asterix::{blocks, presence};

/// SplitMix64: equal seeds give equal datagrams.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Octets of the longest datagram.
const LONGEST: usize = 2048;

/// Makes the next datagram in `out` from one of `sound`.
pub(crate) fn mutate(random: &mut Random, sound: &[Vec<u8>], out: &mut Vec<u8>) {
    out.clear();
    out.extend_from_slice(&sound[random.below(sound.len())]);
    for _ in 0..1 + random.below(6) {
        let at = random.below(out.len());
        match random.below(8) {
            0 => out.truncate(at),
            1 => {
                let other = &sound[random.below(sound.len())];
                let from = random.below(other.len());
                out.extend_from_slice(&other[from..]);
            }
            2 if !out.is_empty() => out.insert(at, random.next() as u8),
            3 if !out.is_empty() => drop(out.remove(at)),
            // Lengths, counts and field specifications of their extreme values.
            4 if !out.is_empty() => out[at] = [0, 1, 0x7f, 0x80, 0xfe, 0xff][random.below(6)],
            5 if out.len() > 3 => {
                let length = (out.len() as u16).to_be_bytes();
                out[1..3].copy_from_slice(&length);
            }
            _ if !out.is_empty() => out[at] ^= 1 << random.below(8),
            _ => {}
        }
    }
    out.truncate(LONGEST);
}

/// What became of a datagram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    /// Records that were given out.
    pub(crate) records: u64,
    /// Values in them.
    pub(crate) values: u64,
    /// Refusals.
    pub(crate) refused: u64,
}

/// Every field of an item and of what is below it.
fn gather(item: asterix::View<'_>, take: &mut dyn FnMut(asterix::Datum)) {
    item.data().for_each(&mut *take);
    item.subitems().for_each(|below| gather(below, take));
}

/// Reads everything of a datagram. Work is bounded by its octets: each value and each record takes some of them.
pub(crate) fn read(datagram: &[u8], seen: &mut Seen) {
    let before = *seen;
    for block in blocks(datagram) {
        let Ok(block) = block else {
            seen.refused += 1;
            break;
        };
        for record in block.records() {
            let Ok(record) = record else {
                seen.refused += 1;
                break;
            };
            seen.records += 1;
            let mut one_by_one = (0, 0_u64);
            let add = |values: &mut (u64, u64), datum: asterix::Datum| {
                values.0 += 1;
                values.1 = values.1.rotate_left(5) ^ datum.raw;
            };
            record.items().for_each(|item| gather(item, &mut |d| add(&mut one_by_one, d)));
            let mut at_once = (0, 0);
            record.each(|datum| add(&mut at_once, datum));
            assert_eq!(at_once, one_by_one, "{:02x?}", record.octets());
            seen.values += at_once.0;
            if seen.records.is_multiple_of(16) {
                seen.values += presence::breaches(&record).len() as u64;
            }
        }
    }
    let most = 16 * datagram.len() as u64 + 16;
    assert!(seen.records - before.records <= datagram.len() as u64, "{datagram:02x?}");
    assert!(
        seen.values - before.values <= most,
        "{} values of {datagram:02x?}",
        seen.values - before.values
    );
}

/// Sound datagrams of every category: the vectors' files, which stand below `root`.
pub(crate) fn sound(root: &std::path::Path) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    for name in ["asterix-vectors.json", "asterix-vectors-2.json"] {
        let path = root.join("tests/data/vectors/asterix").join(name);
        let text = std::fs::read_to_string(path).expect("the vectors");
        for piece in text.split("\"hex\"").skip(1) {
            let hex = piece.split('"').nth(1).expect("a text");
            found.push(asterix::json::octets(hex).expect("octets"));
        }
    }
    found
}
