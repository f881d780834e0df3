//! No panic, no guess, no loss on any octets; what decodes encodes back.

mod common;

use common::any_bytes::check_any_bytes;
use common::samples;
use pdu::{Body, Reason, TYPED, frames, pdus};
use proptest::prelude::*;

fn octets() -> Vec<Vec<u8>> {
    samples::pdus().iter().map(|pdu| pdu.encode_to_vec().expect("a sample fits")).collect()
}

#[test]
fn every_typed_type_has_a_sample_and_comes_back() {
    let mut types = Vec::new();
    for pdu in samples::pdus() {
        let octets = pdu.encode_to_vec().expect("a sample fits");
        let received = pdus(&octets).next().expect("one").expect("sound");
        assert!(!matches!(received.body(), Body::Raw(_)), "{}", pdu.header().pdu_type);
        // Content with padding differs from content without; the octets do not.
        assert_eq!(received.encode_to_vec().as_ref(), Ok(&octets), "{}", pdu.header().pdu_type);
        let padded = [25, 28, 72].contains(&pdu.header().pdu_type.0)
            || matches!(pdu.body(), Body::Signal(_));
        if !padded {
            assert_eq!(received.pdu, pdu);
        }
        assert_eq!(check_any_bytes(&octets), 1);
        types.push(pdu.header().pdu_type);
    }
    for pdu_type in TYPED {
        assert!(types.contains(pdu_type), "no sample of {pdu_type}");
    }
}

#[test]
fn the_fuzz_targets_that_the_guide_names_exist() {
    let here = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let guide = std::fs::read_to_string(here.join("../CONTRIBUTING.md")).expect("the guide");
    let line =
        guide.lines().find(|line| line.contains("cargo fuzz run")).expect("a line on fuzzing");
    let named = line.split("--sanitizer none ").nth(1).expect("a target").split(['`', ' ']);
    let others = line.split("(or `").nth(1).into_iter().flat_map(|rest| rest.split('`').take(1));
    for target in named.take(1).chain(others) {
        let file = here.join(format!("fuzz/fuzz_targets/{target}.rs"));
        assert!(file.exists(), "{target}");
        let body = std::fs::read_to_string(file).expect("readable");
        assert!(body.contains("check_any_bytes"), "{target} runs the shared body");
    }
}

#[test]
fn every_pdu_cut_at_every_length() {
    for whole in octets() {
        for cut in 0..whole.len() {
            // Cut by the network: the header says more than there is.
            assert_eq!(check_any_bytes(&whole[..cut]), 0);
            if cut < 12 {
                continue;
            }
            // Cut by the sender: the header says what there is.
            let mut short = whole[..cut].to_vec();
            short[8..10].copy_from_slice(&(cut as u16).to_be_bytes());
            let sound = check_any_bytes(&short);
            if let Some(Err(error)) = pdus(&short).next() {
                assert_eq!((sound, error.index, error.pdu_offset), (0, 0, 0));
                assert!(error.offset <= cut, "{error}");
            }
        }
        // Longer than the body.
        let mut long = whole.clone();
        long.extend([0; 8]);
        let length = long.len() as u16;
        long[8..10].copy_from_slice(&length.to_be_bytes());
        check_any_bytes(&long);
    }
}

#[test]
fn a_cut_entity_state_names_the_field() {
    let whole = samples::entity_state(0);
    let mut octets = vec![];
    pdu::Envelope::new(1, pdu::DisTime(1)).append(&whole, &mut octets).expect("fits");
    octets.truncate(17);
    octets[9] = 17;
    let error = pdus(&octets).next().expect("one").expect_err("cut");
    assert_eq!(
        error.to_string(),
        "Entity State PDU 0 at octet 0, octet 16, field `entity_id.entity`: needs 2 octets, 1 left"
    );
}

#[test]
fn a_bundle_delivers_its_sound_pdus() {
    let samples = octets();
    let (first, second) = (&samples[0], &samples[3]);
    let mut damaged = second.clone();
    damaged[9] -= 1; // one octet less than the body needs …
    damaged.pop(); // … and the datagram has it so
    let datagram = [first.as_slice(), &damaged, second, &[1, 2, 3]].concat();
    let found: Vec<_> = pdus(&datagram).collect();
    assert_eq!(found.len(), 4);
    assert_eq!(found[0].as_ref().map(|p| p.octets), Ok(first.as_slice()));
    let error = found[1].as_ref().expect_err("cut short");
    assert_eq!((error.index, error.pdu_offset), (1, first.len()));
    assert_eq!(error.field, "request_id");
    assert_eq!(found[2].as_ref().map(|p| (p.index, p.octets)), Ok((2, second.as_slice())));
    let rest = found[3].as_ref().expect_err("trailing octets");
    assert!(rest.is_trailing());
    assert_eq!(rest.reason, Reason::Trailing { octets: 3 });
    let mut walk = frames(&datagram);
    assert_eq!(walk.by_ref().flatten().count(), 3);
    assert_eq!(walk.rest(), [1, 2, 3]);
}

#[test]
fn lengths_that_lie_end_the_walk() {
    let sample = octets().remove(3);
    for (name, length, expected) in [
        ("zero", 0, Reason::LengthBelowHeader { length: 0 }),
        ("eleven", 11, Reason::LengthBelowHeader { length: 11 }),
        ("beyond", 45, Reason::LengthBeyondDatagram { length: 45, left: 44 }),
        ("largest", 65535, Reason::LengthBeyondDatagram { length: 65535, left: 44 }),
    ] {
        let mut datagram = sample.clone();
        datagram[8..10].copy_from_slice(&u16::to_be_bytes(length));
        let found: Vec<_> = pdus(&datagram).collect();
        assert_eq!(found.len(), 1, "{name}");
        assert_eq!(found[0].as_ref().expect_err(name).reason, expected, "{name}");
        assert_eq!(frames(&datagram).rest().len(), 44);
    }
    // Octets beyond the body are an error of that PDU only.
    let mut long = sample.clone();
    long.push(0);
    long[9] += 1;
    long.extend(&sample);
    let found: Vec<_> = pdus(&long).collect();
    assert_eq!(found[0].as_ref().expect_err("long").reason, Reason::LeftOver { octets: 1 });
    assert!(found[1].is_ok());
}

#[test]
fn action_request_r_is_read_in_both_lengths() {
    for (unused, length) in [(None, 44 + 16 + 24 + 16), (Some(0), 48 + 16 + 24 + 16)] {
        let body = samples::action_request_r(unused);
        let octets = pdu::Pdu::new(pdu::Envelope::new(1, pdu::DisTime(1)), body.clone())
            .encode_to_vec()
            .expect("fits");
        assert_eq!(octets.len(), length);
        assert_eq!(pdus(&octets).next().expect("one").expect("sound").body(), &body);
    }
}

#[test]
fn nan_payloads_and_unused_octets_are_kept() {
    let mut octets = octets().remove(0);
    octets[48..56].copy_from_slice(&0x7ff0_0000_dead_beef_u64.to_be_bytes()); // signalling NaN
    octets[36..40].copy_from_slice(&0x7fa0_1234_u32.to_be_bytes());
    octets[10] = 0xff; // status
    octets[11] = 0x5a; // padding
    octets[3] = 0x77; // a family that does not belong to the type
    octets[88] = 200; // a dead-reckoning model that does not exist
    octets[129..140].copy_from_slice(b"\0\xff behind\0\0");
    assert_eq!(check_any_bytes(&octets), 1);
}

#[test]
fn unknown_types_and_versions_are_kept_raw() {
    let sample = octets().remove(0);
    for (version, pdu_type) in [(7, 0), (7, 73), (7, 255), (7, 29), (4, 1), (8, 1), (0, 1)] {
        let mut octets = sample.clone();
        (octets[0], octets[2]) = (version, pdu_type);
        let received = pdus(&octets).next().expect("one").expect("sound");
        let Body::Raw(raw) = received.body() else {
            panic!("version {version}, type {pdu_type} is raw")
        };
        assert_eq!(raw.octets, &sample[12..]);
        assert_eq!(received.encode_to_vec(), Ok(octets.clone()));
    }
    for version in [5, 6, 7] {
        let mut octets = sample.clone();
        octets[0] = version;
        let received = pdus(&octets).next().expect("one").expect("sound");
        assert!(matches!(received.body(), Body::EntityState(_)));
    }
}

/// How many cases of each law: 1000, or what the environment variable `PDU_CASES` says, for a long run.
fn cases() -> u32 {
    std::env::var("PDU_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(1000)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn random_octets(octets in prop::collection::vec(any::<u8>(), 0..400)) {
        check_any_bytes(&octets);
    }

    #[test]
    fn random_octets_behind_a_plausible_header(
        version in 4_u8..9, pdu_type in 0_u8..75, body in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let length = (12 + body.len() as u16).to_be_bytes();
        let mut octets =
            vec![version, 1, pdu_type, 1, 0, 0, 0, 1, length[0], length[1], 0, 0];
        octets.extend(body);
        check_any_bytes(&octets);
    }

    #[test]
    fn damaged_samples(
        which in any::<prop::sample::Index>(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
    ) {
        let samples = octets();
        let mut octets = samples[which.index(samples.len())].clone();
        for (at, value) in damage {
            let at = at.index(octets.len());
            octets[at] = value;
        }
        check_any_bytes(&octets);
    }

    #[test]
    fn damaged_bundles(
        which in prop::collection::vec(any::<prop::sample::Index>(), 1..6),
        damage in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..8), 0..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let samples = octets();
        let mut octets: Vec<u8> =
            which.iter().flat_map(|w| samples[w.index(samples.len())].clone()).collect();
        for (at, bit) in damage {
            let at = at.index(octets.len());
            octets[at] ^= 1 << bit;
        }
        octets.truncate(cut.index(octets.len()) + 1);
        check_any_bytes(&octets);
    }
}
