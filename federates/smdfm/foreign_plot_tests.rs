//! What is read of reports as somebody's sensors make them.

use super::foreign_plot::{Reading, reading};
use crate::gateway::foreign::track;
use crate::gateway::plots::Mixed;
use asterix::{Category, EncodeError, ItemWriter, Packer, Record};
use asterix::{cat010, cat020, cat021, cat048, cat062};
use models::plot::{Callsign, Identity};

/// Where a call sign of these letters stands in a record, others can be written.
const MARK: &str = "ABCDEFGH";

/// The octets of a record with these items, other six-bit characters in place of the mark.
fn octets(
    category: &'static Category,
    characters: [u8; 8],
    write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
) -> Vec<u8> {
    let mut packer = Packer::new(1400);
    packer.record(category, write).expect("fits");
    let mut octets = packer.take().concat();
    let bits = |text: [u8; 8]| text.iter().fold(0_u64, |sum, c| sum << 6 | u64::from(c & 0x3f));
    let (mark, wanted) = (bits(*b"ABCDEFGH").to_be_bytes(), bits(characters).to_be_bytes());
    if let Some(at) = octets.windows(6).position(|window| window == &mark[2..]) {
        octets[at..at + 6].copy_from_slice(&wanted[2..]);
    }
    octets
}

fn first<T>(octets: &[u8], get: impl FnOnce(&Record<'_>) -> T) -> T {
    let block = asterix::blocks(octets).next().expect("a block").expect("sound");
    let record = block.records().next().expect("a record").expect("sound");
    get(&record)
}

/// What is read of a record with these items.
fn read(
    category: &'static Category,
    write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
) -> Result<Option<Reading>, &'static str> {
    first(&octets(category, [0; 8], write), reading)
}

/// Who fills an unknown identification with zeros (six bits of them are "@", eight are NUL) or blanks says none: his address is what he
/// is known by. What fills up a call sign behind is no part of it.
#[test]
fn an_identification_of_zeros_is_none_and_hides_no_address() {
    let of_020 = |characters, address: u32| {
        let octets = octets(&cat020::CATEGORY, characters, |items| {
            items.put(&cat020::I010, &[7, 1])?;
            items.put(&cat020::I140, &[36_000.0])?;
            items.put(&cat020::I042, &[10.0, 20.0])?;
            items.put(&cat020::I161, &[5])?;
            items.put(&cat020::I220, &[address])?;
            items.put(&cat020::I245, &[Mixed::Code(2), Mixed::Text(MARK)])
        });
        let identity = first(&octets, reading).expect("complete").expect("a plot").identity;
        (identity, first(&octets, track).expect("a track too").label)
    };
    for nothing in [[0; 8], *b"        ", *b"\0\0\0\0    "] {
        for address in [0x4b_1234, 0x89_6001] {
            let expected = (Some(Identity::Address(address)), String::new());
            assert_eq!(of_020(nothing, address), expected, "{nothing:?}");
        }
    }
    for named in [*b"SWR99Z\0\0", *b"SWR99Z  "] {
        let expected = (Some(Identity::Callsign(Callsign::new("SWR99Z"))), "SWR99Z".to_owned());
        assert_eq!(of_020(named, 0x4b_1234), expected);
    }
    // The label of a system track is text of seven octets.
    let nul = |items: &mut ItemWriter<'_>| {
        items.put(&cat062::I010, &[7, 1])?;
        items.put(&cat062::I070, &[36_000.0])?;
        items.put(&cat062::I100, &[10.0, 20.0])?;
        items.compound(&cat062::I380, |sub| sub.put(&cat062::I380_ADR, &[0x4b_1234]))?;
        items.put(&cat062::I040, &[5])?;
        items.compound(&cat062::I390, |sub| sub.put(&cat062::I390_CS, &["\0\0\0\0\0\0\0"]))
    };
    let octets = octets(&cat062::CATEGORY, [0; 8], nul);
    let identity = first(&octets, reading).expect("complete").expect("a plot").identity;
    assert_eq!(identity, Some(Identity::Address(0x4b_1234)));
    assert_eq!(first(&octets, track).expect("a track").label, "");
}

/// The accuracy that an ADS-B target says of itself is the error of its plots, down to the coarsest; what it does not know is no
/// accuracy, for which the scene has one.
#[test]
fn every_accuracy_category_is_taken_at_its_word() {
    let variance = |nac_p: u32| {
        let read = read(&cat021::CATEGORY, |items| {
            items.put(&cat021::I010, &[7, 1])?;
            items.put(&cat021::I040, &[0, 0, 0, 0])?;
            items.put(&cat021::I131, &[47.45, 8.56])?;
            items.put(&cat021::I080, &[0x4b_1234])?;
            items.put(&cat021::I073, &[36_000.0])?;
            items.put(&cat021::I090, &[0, 0, 0, 0, nac_p])
        });
        read.expect("complete").expect("a plot").cov_m2
    };
    // 95 % within 10, 4, 2, 1, 0.5 and 0.3 nautical miles, 0.1, 0.05 (DO-260B), 30, 10 and 3 m.
    let radii_m =
        [18_520.0, 7408.0, 3704.0, 1852.0, 926.0, 555.6, 185.2, 92.6, 30.0, 10.0, 3.0_f64];
    for (nac_p, radius_m) in (1..).zip(radii_m) {
        let sigma_m = radius_m / (-2.0 * libm::log(0.05)).sqrt();
        let [ee_m2, en_m2, nn_m2] = variance(nac_p).expect("an accuracy");
        assert!((ee_m2.sqrt() / sigma_m - 1.0).abs() < 1e-6, "{nac_p}: {ee_m2}");
        assert_eq!((en_m2, nn_m2), (0.0, ee_m2));
        let said = crate::gateway::items::nac_p([ee_m2 * 0.99, 0.0, nn_m2 * 0.99]);
        assert_eq!(u32::from(said), nac_p, "what goes out is what comes in");
    }
    for unknown in [0, 12, 13, 14, 15] {
        assert_eq!(variance(unknown), None, "{unknown}");
    }
}

type Items = fn(&mut ItemWriter<'_>) -> Result<(), EncodeError>;

fn head_010(items: &mut ItemWriter<'_>) -> Result<(), EncodeError> {
    items.put(&cat010::I010, &[7, 1])?;
    items.put(&cat010::I000, &[1])
}

fn body_010(items: &mut ItemWriter<'_>) -> Result<(), EncodeError> {
    items.put(&cat010::I140, &[36_000.0])?;
    items.put(&cat010::I042, &[10.0, 20.0])
}

/// What was not measured is no plot: an extrapolation, the farewell of a track, a test target, a field monitor.
#[test]
fn what_is_no_measurement_is_refused_by_its_reason() {
    let of_010: [(Items, _); 5] = [
        (
            |i| {
                head_010(i)?;
                i.put(&cat010::I020, &[3, 0, 0, 1, 0, 1, 0, 0, 0, 1])?;
                body_010(i)?;
                i.put(&cat010::I170, &[1, 0, 0, 0, 0, 0])
            },
            Ok(true), // simulated, not confirmed: a plot all the same
        ),
        (
            |i| {
                head_010(i)?;
                body_010(i)?;
                i.put(&cat010::I170, &[0, 0, 2, 0, 0, 0])
            },
            Err("an extrapolated position"),
        ),
        (
            |i| {
                head_010(i)?;
                body_010(i)?;
                i.put(&cat010::I170, &[0, 1, 0, 0, 0, 0])
            },
            Err("the last report of a track"),
        ),
        (
            |i| {
                head_010(i)?;
                i.put(&cat010::I020, &[3, 0, 0, 1, 0, 0, 1, 0, 0, 1])?;
                body_010(i)
            },
            Err("a test target"),
        ),
        (
            |i| {
                head_010(i)?;
                i.put(&cat010::I020, &[3, 0, 0, 1, 0, 0, 0, 1, 0, 1])?;
                body_010(i)
            },
            Err("a field monitor"),
        ),
    ];
    let of = |read: Result<Option<Reading>, &'static str>| read.map(|reading| reading.is_some());
    for (write, expected) in of_010 {
        assert_eq!(of(read(&cat010::CATEGORY, write)), expected);
    }
    let of_020 = |descriptor: [u8; 7], status: [u8; 7]| {
        of(read(&cat020::CATEGORY, |items| {
            items.put(&cat020::I010, &[7, 1])?;
            // The first seven bits are inverted.
            let descriptor = [[1, 0, 1, 1, 1, 1, 1], descriptor].concat();
            items.put(&cat020::I020, &descriptor)?;
            items.put(&cat020::I140, &[36_000.0])?;
            items.put(&cat020::I042, &[10.0, 20.0])?;
            items.put(&cat020::I170, &status)
        }))
    };
    let [none, first] = [[0; 7], [1, 0, 0, 0, 0, 0, 0]];
    assert_eq!(of_020([0, 0, 0, 1, 0, 1, 0], first), Ok(true));
    assert_eq!(of_020(first, none), Err("a field monitor"));
    assert_eq!(of_020([0, 0, 0, 0, 0, 0, 1], none), Err("a test target"));
    assert_eq!(of_020(none, [0, 0, 1, 0, 0, 0, 0]), Err("an extrapolated position"));
    assert_eq!(of_020(none, [0, 1, 0, 0, 0, 0, 0]), Err("the last report of a track"));
    let of_021 = |rab: u8, test: u8| {
        of(read(&cat021::CATEGORY, |items| {
            items.put(&cat021::I010, &[7, 1])?;
            items.put(&cat021::I040, &[0, 0, 0, rab, 0, 0, 1, test, 0, 0])?;
            items.put(&cat021::I131, &[47.45, 8.56])?;
            items.put(&cat021::I080, &[0x4b_1234])?;
            items.put(&cat021::I073, &[36_000.0])
        }))
    };
    assert_eq!(of_021(0, 0), Ok(true));
    assert_eq!(of_021(1, 0), Err("a field monitor"));
    assert_eq!(of_021(0, 1), Err("a test target"));
    let of_048 = |descriptor: &[u8]| {
        of(read(&cat048::CATEGORY, |items| {
            items.put(&cat048::I010, &[7, 1])?;
            items.put(&cat048::I140, &[36_000.0])?;
            items.put(&cat048::I020, descriptor)?;
            items.put(&cat048::I040, &[2.0, 90.0])
        }))
    };
    assert_eq!(of_048(&[1, 1, 0, 0, 0]), Ok(true));
    assert_eq!(of_048(&[0, 0, 0, 0, 0]), Err("a report without a detection"));
    assert_eq!(of_048(&[5, 0, 0, 0, 1]), Err("a field monitor"));
    assert_eq!(of_048(&[5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0]), Err("a test target"));
    let of_062 = |name: &str| {
        let mut status = [0; cat062::I080.fields()];
        if !name.is_empty() {
            status[cat062::I080.field(name)] = 1;
        }
        of(read(&cat062::CATEGORY, |items| {
            items.put(&cat062::I010, &[7, 1])?;
            items.put(&cat062::I070, &[36_000.0])?;
            items.put(&cat062::I100, &[10.0, 20.0])?;
            items.put(&cat062::I040, &[5])?;
            items.put(&cat062::I080, &status)
        }))
    };
    assert_eq!(["", "SIM", "CNF", "TSB"].map(of_062), [Ok(true); 4]);
    assert_eq!(of_062("CST"), Err("an extrapolated position"));
    assert_eq!(of_062("TSE"), Err("the last report of a track"));
}
