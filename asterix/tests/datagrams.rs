//! Literal datagrams, damaged ones, and any octets.

use asterix::table::Structure;
use asterix::{
    CATEGORIES, DATAGRAM_LIMIT, DecodeError, EncodeError, Fault, Packer, Reason, Record, Value,
    ValueError, blocks, cat010, cat011, cat021, cat048, cat062, json, presence,
};
use proptest::prelude::*;

fn octets(hex: &str) -> Vec<u8> {
    json::octets(&hex.replace(' ', "")).expect("hexadecimal digits")
}

fn records(datagram: &[u8]) -> Vec<Record<'_>> {
    let blocks = blocks(datagram).map(|b| b.expect("a sound block"));
    blocks.flat_map(|b| b.records()).map(|r| r.expect("a sound record")).collect()
}

#[test]
fn a_radar_plot_is_read_item_by_item() {
    let datagram = octets("0a001ff70109a0000701618046504005dc60000425fbdb4d41440a0cfffbb4");
    let [plot] = records(&datagram)[..] else { panic!("one record") };
    assert_eq!(plot.numbers(&cat010::I010), Some([0.0, 7.0]));
    assert_eq!(plot.numbers(&cat010::I042), Some([1061.0, -1061.0]), "m");
    assert_eq!(plot.numbers(&cat010::I040), Some([1500.0, 135.0]), "m, degrees");
    assert_eq!(plot.numbers(&cat010::I500), Some([2.5, 3.0, -1.25]), "m");
    assert_eq!(plot.number(&cat010::I140), Some(36_000.5), "s");
    let descriptor = plot.get(&cat010::I020).expect("there");
    assert_eq!(descriptor.value("SIM"), Some(Value::Integer(1)));
    assert_eq!(descriptor.value("SPI"), None, "in a part that is not there");
    assert_eq!(plot.get(&cat010::I161).map(|v| v.octets()), None);
    assert_eq!(plot.get(&cat062::I100).map(|v| v.octets()), None, "a row of another category");
    assert_eq!(plot.find("131").map(|v| v.octets().to_vec()), Some(vec![180]));
    assert_eq!((plot.offset, plot.octets().len()), (3, 28));
}

#[test]
fn a_system_track_is_written_octet_by_octet() {
    let mut packer = Packer::new(DATAGRAM_LIMIT);
    const SFC: usize = cat062::I080.field("SFC");
    let mut status = [0; 35];
    status[cat062::I080.field("SIM")] = 1;
    status[SFC] = 1;
    packer
        .record(&cat062::CATEGORY, |items| {
            items.put(&cat062::I010, &[0, 20])?;
            items.put(&cat062::I015, &[1])?;
            items.put(&cat062::I070, &[2.0])?;
            items.put(&cat062::I105, &[47.454_321, 8.556_789])?;
            items.put(&cat062::I100, &[657.25, -411.75])?;
            items.put(&cat062::I185, &[-7.75, 0.25])?;
            items.compound(&cat062::I380, |sub| sub.put(&cat062::I380_ID, &["FOLLOW1"]))?;
            items.put(&cat062::I040, &[9])?;
            items.put(&cat062::I080, &status)?;
            // Nothing in it: left out.
            items.compound(&cat062::I390, |_| Ok(()))
        })
        .expect("fits");
    let mut expected = octets(
        "3e 0000 bf1c 0014 01 000100 0086fb2f001856dd 000523fffcc9 ffe10001 40 18f30c3d7c60 0009 018101010110",
    );
    expected[2] = expected.len() as u8;
    assert_eq!(packer.take(), [expected]);
}

#[test]
fn the_surface_ground_vector_of_the_reserved_expansion_field() {
    let mut out = Vec::new();
    let write = |v: &[f64]| {
        let mut record = Vec::new();
        asterix::record(&mut record, &cat021::CATEGORY, |items| {
            items.compound(&cat021::RE, |sub| sub.put(&cat021::RE_SGV, v))
        })
        .expect("fits");
        record
    };
    out.extend(write(&[0.0, 1.0, 1.0, 0.0, 15.125, 272.8125]));
    let block = [&[21, 0, 3 + out.len() as u8][..], &out].concat();
    assert_eq!(
        block,
        octets("15000f 01010101010104 05 0860f3c2".replace("05 08", "0508").as_str())
    );
    let [report] = records(&block)[..] else { panic!("one record") };
    let field = report.get(&cat021::RE).expect("there");
    let vector: Vec<_> = field.subitems().flat_map(|s| s.values()).map(|(_, v)| v).collect();
    assert_eq!(vector[4..], [Value::Number(15.125), Value::Number(272.8125)]);
}

#[test]
fn damage_is_refused_with_place_and_reason() {
    let start = "0a000ad00001023f4800"; // a sound block before each
    for (name, hex, offset, record, item, fault) in [
        ("header cut", "0a00", 10, 0, None, Fault::HeaderCut { left: 2 }),
        ("length 0", "3e0000", 10, 0, None, Fault::LengthTooSmall { length: 0 }),
        ("length 2", "3e000200", 10, 0, None, Fault::LengthTooSmall { length: 2 }),
        ("too long", "3e000901", 10, 0, None, Fault::LengthBeyond { length: 9, left: 4 }),
        ("FSPEC endless", "3e000cffffffffffffffffff", 13, 1, None, Fault::SpecificationEndless),
        ("FSPEC cut", "3e0004ff", 13, 1, None, Fault::SpecificationEndless),
        ("no item", "3e000400", 13, 1, None, Fault::Empty),
        ("spare position", "4100080180000000", 13, 1, None, Fault::SparePosition { position: 8 }),
        ("item cut", "0a000790000001", 16, 1, Some("140"), Fault::Cut { needed: 3, left: 1 }),
        ("parts beyond", "0a000720010101", 14, 1, Some("020"), Fault::PartsBeyond { parts: 3 }),
        (
            "repetitions",
            "0b0010d1010108000101000080ff0001",
            23,
            1,
            Some("605"),
            Fault::RepetitionsBeyond { count: 255, octets: 2, left: 2 },
        ),
        (
            "explicit 0",
            "15000b0101010101010400",
            20,
            1,
            Some("RE"),
            Fault::ExplicitTooShort { length: 0, needed: 2 },
        ),
    ] {
        let datagram = octets(&format!("{start}{hex}"));
        let mut sound = 0;
        let refused = blocks(&datagram).find_map(|block| match block.and_then(|b| b.check()) {
            Ok(count) => {
                sound += count;
                None
            }
            Err(e) => Some(e),
        });
        let error = refused.unwrap_or_else(|| panic!("{name}: not refused"));
        println!("{name}: {error}");
        assert_eq!(sound, 1, "{name}: the block before it counts");
        let DecodeError { item: found, .. } = error;
        assert_eq!(
            (error.offset, error.record, found, error.fault),
            (offset, record, item, fault),
            "{name}"
        );
    }
}

#[test]
fn a_record_that_cannot_be_written_leaves_nothing_behind() {
    let mut packer = Packer::new(40);
    let plain = |items: &mut asterix::ItemWriter<'_>| {
        items.put(&cat010::I010, &[0, 1])?;
        items.put(&cat010::I000, &[2])?;
        items.put(&cat010::I140, &[36_000.0])
    };
    let refuse =
        |packer: &mut Packer,
         write: &dyn Fn(&mut asterix::ItemWriter<'_>) -> Result<(), EncodeError>| {
            packer
                .record(&cat010::CATEGORY, |items| {
                    items.put(&cat010::I010, &[0, 1])?;
                    write(items)
                })
                .expect_err("refused")
        };
    packer.record(&cat010::CATEGORY, plain).expect("fits");
    let value = |e| Reason::Value(e);
    type Write = dyn Fn(&mut asterix::ItemWriter<'_>) -> Result<(), EncodeError>;
    let cases: [(&Write, Reason); 8] = [
        (&|i| i.put(&cat010::I010, &[0, 1]), Reason::Order),
        (&|i| i.put(&cat062::I010, &[0, 1]), Reason::Foreign),
        (&|i| i.put(&cat010::I140, &[f64::NAN]), value(ValueError::NotFinite)),
        (&|i| i.put(&cat010::I161, &[4096]), value(ValueError::TooLarge(12))),
        (&|i| i.put(&cat010::I042, &[1.0]), Reason::Values { given: 1, fields: 2 }),
        (&|i| i.put(&cat010::I020, &[0; 12]), Reason::Values { given: 12, fields: 11 }),
        (&|i| i.compound(&cat010::I042, |_| Ok(())), Reason::Structure),
        (&|i| i.put(&cat010::I280, &[0.0; 600]), Reason::TooLong),
    ];
    for (write, reason) in cases {
        assert_eq!(refuse(&mut packer, write).reason, reason);
    }
    let error = packer.record(&cat010::CATEGORY, |_| Ok(())).expect_err("empty");
    assert_eq!(error.reason, Reason::Empty);
    let large = packer.record(&cat010::CATEGORY, |i| i.put(&cat010::I280, &[0.0; 60]));
    assert_eq!(large.expect_err("large").reason, Reason::RecordTooLarge { octets: 68, limit: 40 });
    packer.record(&cat010::CATEGORY, plain).expect("fits");
    let one = octets("0a0011 d0000102465000 d0000102465000");
    assert_eq!(packer.take(), [one], "two records in one block, and no octet of the refused ones");
    let error = asterix::record(&mut Vec::new(), &cat062::CATEGORY, |items| {
        items.compound(&cat062::I390, |sub| sub.put(&cat062::I390_CS, &["TOO LONG"]))
    });
    assert_eq!(error.expect_err("refused").to_string(), "item 390/CS: longer than 7 characters");
}

#[test]
fn datagrams_are_filled_and_records_never_split() {
    let mut packer = Packer::new(100);
    for category in [&cat010::CATEGORY, &cat011::CATEGORY, &cat010::CATEGORY] {
        let (source, message) = (category.uap[0].expect("010"), category.uap[1].expect("000"));
        for _ in 0..30 {
            packer
                .record(category, |items| {
                    items.put(source, &[0, 1])?;
                    items.put(message, &[2])
                })
                .expect("fits");
        }
    }
    let datagrams = packer.take();
    let counts: Vec<usize> = datagrams.iter().map(|d| records(d).len()).collect();
    assert!(datagrams.iter().all(|d| d.len() <= 100), "{datagrams:?}");
    // 24 records of 4 octets and a header; six of the first category share with the second.
    assert_eq!(counts, [24, 23, 23, 20]);
    assert!(packer.take().is_empty());
}

#[test]
fn presence_rules_are_named() {
    let datagram = octets("0a000ad00007024650000a000dd1010400070100000060");
    let found: Vec<Vec<String>> = records(&datagram)
        .iter()
        .map(|r| presence::breaches(r).iter().map(ToString::to_string).collect())
        .collect();
    assert!(found[0].is_empty(), "{found:?}");
    assert_eq!(found[1], ["I010/020 is missing", "I010/550 has no place in message type 1"]);
}

/// Positions, names and sizes of every table fit together.
#[test]
fn tables_are_sound() {
    fn check(what: &str, table: &[Option<&'static asterix::table::Item>]) -> usize {
        let mut count = 0;
        for (position, item) in table.iter().enumerate() {
            let Some(item) = item else { continue };
            let name = format!("{what}/{}", item.id);
            count += 1;
            assert_eq!(usize::from(item.position), position, "{name}");
            let extended = matches!(item.structure, Structure::Extended(_) | Structure::Chained(_));
            for part in item.structure.parts() {
                let bits: usize = part.fields.iter().map(|f| usize::from(f.bits)).sum();
                assert_eq!(bits + usize::from(extended), 8 * usize::from(part.octets), "{name}");
                assert!(part.fields.iter().all(|f| (1..=56).contains(&f.bits)), "{name}");
                let mut bit = 0;
                for field in part.fields {
                    assert!(bit % 8 + usize::from(field.bits) <= 64, "{name}");
                    bit += usize::from(field.bits);
                }
            }
            if item.fields() > 1 {
                let parts = item.structure.parts();
                let names = parts.iter().flat_map(|p| p.fields).filter(|f| !f.name.is_empty());
                let mut names: Vec<_> = names.map(|f| f.name).collect();
                assert_eq!(names.len(), item.fields(), "{name}: every field has a name");
                names.sort_unstable();
                names.dedup();
                assert_eq!(names.len(), item.fields(), "{name}: every name once");
            }
            if let Structure::Compound(table) | Structure::Explicit(table) = item.structure {
                count += check(&name, table);
            }
        }
        count
    }
    for category in CATEGORIES {
        assert!(category.uap.len() <= asterix::table::MOST_POSITIONS);
        let items = check(&format!("{:03}", category.number), category.uap);
        println!("{:03}: {items} items and subitems", category.number);
    }
}

/// Reads everything, and writes it again.
fn read_any(datagram: &[u8]) {
    for block in blocks(datagram) {
        let Ok(block) = block else { break };
        for record in block.records() {
            let Ok(record) = record else { break };
            let values = json::record(&record);
            let _ = presence::breaches(&record);
            let mut again = Vec::new();
            json::encode(&mut again, record.category, &values).expect("what was read fits");
            // Spare bits and empty octets of the field specification are not kept; all values are.
            let block =
                [&[block.number][..], &(again.len() as u16 + 3).to_be_bytes(), &again].concat();
            let read = records(&block);
            assert_eq!(read.len(), 1);
            // A time of day beyond the day is not one; it is written as the time of the next day.
            let late = |v: &asterix::View<'_>| {
                let of_day = |f: &asterix::table::Field| f.kind == asterix::table::Kind::TimeOfDay;
                v.values().any(|(f, v)| of_day(f) && v.number() >= Some(asterix::DAY_S))
            };
            if record.items().any(|v| late(&v)) {
                continue;
            }
            assert_eq!(json::record(&read[0]), values);
            let spares = record.items().any(|v| !v.parts().all(|p| p.spares_are_zero()));
            if again.len() == record.octets().len() && !spares && !values.to_string().contains('{')
            {
                assert_eq!(again, record.octets());
            }
        }
    }
}

/// A record with random contents of every item, after the tables.
fn any_record(category: &'static asterix::Category, seed: &[u8]) -> Vec<u8> {
    let mut next = seed.iter().copied().cycle().zip(0u32..).map(|(s, i)| {
        let mixed = (u32::from(s) ^ i).wrapping_mul(0x9e37_79b1);
        (mixed >> 24) as u8
    });
    let wanted: Vec<u8> = (0..category.uap.len().div_ceil(7)).filter_map(|_| next.next()).collect();
    let mut out = Vec::new();
    for (index, octet) in wanted.iter().enumerate() {
        let mut octet = octet & 0xfe;
        for bit in 0..7 {
            if category.uap.get(7 * index + bit).copied().flatten().is_none() {
                octet &= !(0x80 >> bit);
            }
        }
        out.push(octet | u8::from(index + 1 < wanted.len()));
    }
    out.extend(next.take(300));
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn any_octets_give_values_or_an_error(datagram in proptest::collection::vec(any::<u8>(), 0..200)) {
        read_any(&datagram);
    }

    #[test]
    fn any_octets_of_a_known_category(category in 0..11usize, seed in proptest::collection::vec(any::<u8>(), 1..64)) {
        let category = CATEGORIES[category];
        let record = any_record(category, &seed);
        // Cut where the record ends, if it is sound, so that a block holds it.
        let block = |r: &[u8]| [&[category.number][..], &(r.len() as u16 + 3).to_be_bytes(), r].concat();
        let whole = block(&record);
        read_any(&whole);
        let block_of = blocks(&whole).next().expect("a block").expect("sound");
        if let Some(Ok(first)) = block_of.records().next() {
            read_any(&block(first.octets()));
        }
    }
}

#[test]
fn names_that_a_table_has_not_are_refused() {
    for (json, message) in [
        (r#"{"999": 1}"#, "item 999: unknown name"),
        (r#"{"010": {"SAC": 0, "SIK": 1}}"#, "item 010, field SIK: unknown name"),
        (r#"{"010": 3}"#, "item 010: an object of fields is asked for"),
        (r#"{"140": "x"}"#, "item 140: a number is asked for"),
        (r#"{"020": {"TYP": 1, "_parts": 4}}"#, "item 020, field _parts: unknown name"),
        (r#"{"130": {"ZZ": 1}}"#, "item 130, field ZZ: unknown name"),
    ] {
        let value = serde_json::from_str(json).expect("JSON");
        let error = json::encode(&mut Vec::new(), &cat048::CATEGORY, &value).expect_err(json);
        assert_eq!(error.to_string(), message, "{json}");
    }
}
