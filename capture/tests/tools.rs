//! The tools, on other people's captures and on files made to be wrong.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod common;

use capture::tools::check::{Check, Finding, check};
use capture::tools::diff::{Difference, diff};
use capture::tools::dump::dump;
use capture::tools::edit::{Change, EditError, Selection, edit};
use capture::tools::lint::{Limits, Rule, lint};
use capture::tools::stat::stat;
use capture::{OpenError, Reader, Recorder, Rewrite};
use common::Folder;
use pdu::enumerations::{DeadReckoningAlgorithm, ForceId, PduType};
use pdu::records::{EntityId, EntityType, Location, Marking};
use pdu::{DisTime, EncodeBody, EntityState, Envelope, management};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/dis").join(name)
}

const S: i64 = 1_000_000_000;
const START: i64 = 1_700_000_000 * S;

/// Writes datagrams: second, port, payload.
fn write(path: &Path, datagrams: &[(f64, u16, Vec<u8>)]) {
    let mut recorder = Recorder::create(path).unwrap();
    for (s, port, payload) in datagrams {
        let from = "10.0.0.7:4001".parse().unwrap();
        let to = format!("239.1.2.3:{port}").parse().unwrap();
        recorder.record(START + (s * 1e9) as i64, from, to, payload).unwrap();
    }
    recorder.close(0).unwrap();
}

/// An entity that stands in Zurich.
fn state(entity: u16) -> EntityState<'static> {
    EntityState {
        entity_id: EntityId::new(1, 2, entity),
        entity_type: EntityType::new(1, 2, 225, 57, 1, 2, 0),
        force_id: ForceId(3),
        location: Location { x_m: 4_283_000.0, y_m: 643_600.0, z_m: 4_668_500.0 },
        dead_reckoning_algorithm: DeadReckoningAlgorithm(2),
        marking: Marking::new("SWR8").unwrap(),
        ..EntityState::default()
    }
}

fn octets(at_s: f64, bodies: &[&dyn Encode]) -> Vec<u8> {
    let mut out = Vec::new();
    for body in bodies {
        body.append(Envelope::new(1, DisTime::absolute((at_s * 1e9) as u64)), &mut out);
    }
    out
}

/// Any body.
trait Encode {
    fn append(&self, envelope: Envelope, out: &mut Vec<u8>);
}
impl<T: EncodeBody> Encode for T {
    fn append(&self, envelope: Envelope, out: &mut Vec<u8>) {
        envelope.append(self, out).unwrap();
    }
}

fn checked(path: &Path) -> (Check, Vec<String>) {
    let mut told = Vec::new();
    let counts = check(path, &[], |f| told.push(f.to_string())).unwrap();
    (counts, told)
}

#[test]
fn every_pdu_of_real_captures_comes_back() {
    for (name, datagrams, by_type) in [
        ("kdis-log1.pcap", 88, vec![(1u8, 60u64), (2, 1), (3, 1), (20, 20), (41, 6)]),
        ("opendis7-gaz69-straight.pcap", 174, vec![(1, 126), (72, 126)]),
        ("open-dis-python/EntityStatePdu-26.raw", 1, vec![(1, 1)]),
        ("open-dis-python/ElectromagneticEmissionPdu-single-system.raw", 1, vec![(23, 1)]),
        ("open-dis-python/SetDataPdu-multi-variable-datums.raw", 1, vec![(19, 1)]),
        ("open-dis-python/SetDataPdu-vbs-script-cmd.raw", 1, vec![(19, 1)]),
        ("open-dis-python/SignalPdu.raw", 1, vec![(26, 1)]),
        ("open-dis-python/TransmitterPdu.raw", 1, vec![(25, 1)]),
    ] {
        let (counts, told) = checked(&data(name));
        assert_eq!(told, [""; 0], "{name}");
        assert_eq!((counts.datagrams, counts.damaged), (datagrams, 0), "{name}");
        assert_eq!(counts.reencoded_identical, counts.pdus, "{name}");
        if !name.starts_with("opendis7") {
            assert_eq!(counts.by_type, by_type.into_iter().collect(), "{name}");
        } else {
            assert_eq!(counts.by_type.get(&72), Some(&126), "{name}: {counts}");
        }
    }
}

#[test]
fn the_closing_line_of_check_has_its_members_in_order() {
    let (counts, _) = checked(&data("kdis-log1.pcap"));
    assert_eq!(
        counts.json(),
        r#"{"datagrams":88,"pdus":88,"by_type":{"1":60,"2":1,"3":1,"20":20,"41":6},"damaged":0,"reencoded_identical":88}"#
    );
}

#[test]
fn damage_is_counted_and_what_is_sound_beside_it_too() {
    let folder = Folder::new("check");
    let path = folder.file("a.pcapng");
    let good = octets(1.0, &[&state(1), &state(2)]);
    let mut cut = good[..good.len() - 7].to_vec();
    let mut wrong_length = good.clone();
    wrong_length[9] = 136;
    let mut nan = octets(
        1.0,
        &[&EntityState { location: Location { x_m: f64::NAN, ..Default::default() }, ..state(3) }],
    );
    nan[48..56].copy_from_slice(&0x7ff8_dead_beef_0001_u64.to_be_bytes());
    cut.truncate(cut.len());
    write(
        &path,
        &[
            (0.0, 3000, good.clone()),
            (1.0, 3000, cut),
            (2.0, 3000, wrong_length),
            (3.0, 3000, b"garbage that is no PDU at all".to_vec()),
            (4.0, 3000, vec![7; 5]),
            (5.0, 3000, [&good[..], &[0; 4]].concat()),
            (6.0, 3000, nan),
            (7.0, 3000, vec![]),
            (8.0, 5353, b"\0\0\x84\0 a name service, not DIS".to_vec()),
        ],
    );
    let (counts, told) = checked(&path);
    // 2 sound; 1 and 1 cut; the wrong length and what it makes of the rest; 1; 1; 2 and a rest; 1 with NaN.
    assert_eq!(counts.datagrams, 8, "{told:#?}");
    assert_eq!((counts.trailing, counts.others, counts.problems), (1, 1, 0));
    assert_eq!((counts.pdus, counts.reencoded_identical), (6, 6), "{told:#?}");
    assert!((4..=5).contains(&counts.damaged), "{told:#?}");
    assert!(
        told.iter().any(|t| t.contains("frame 2: Entity State PDU 1 at octet 144")),
        "{told:#?}"
    );
    // With the ports given, the other traffic is DIS too, and damaged.
    let all = check(&path, &[3000, 5353], |_| ()).unwrap();
    assert_eq!((all.datagrams, all.damaged), (9, counts.damaged + 1));
    // A file cut at its end: everything before the cut is counted, and the cut is told.
    let whole = std::fs::read(&path).unwrap();
    let short = folder.file("short.pcapng");
    let end = Reader::open(&path).unwrap().nth(1).unwrap().unwrap().place.unwrap() as usize;
    std::fs::write(&short, &whole[..end + 10]).unwrap();
    let (counts, told) = checked(&short);
    assert_eq!((counts.datagrams, counts.problems), (1, 1));
    assert!(told[0].contains("last block cut"), "{told:?}");
}

#[test]
fn stat_tells_entities_senders_and_bundles() {
    let told = stat(data("kdis-log1.pcap"), &[]).unwrap();
    assert_eq!((told.datagrams.count, told.pdus, told.bundles), (88, 88, 0));
    assert_eq!(told.by_version, BTreeMap::from([(5, 88)]));
    assert_eq!(told.entities.values().map(|e| e.states).sum::<u64>(), 60);
    let json = told.json();
    assert!(
        json.starts_with(r#"{"datagrams":88,"#) && json.ends_with("\"problems\":[]}"),
        "{json}"
    );
    let bundled = stat(data("opendis7-gaz69-straight.pcap"), &[]).unwrap();
    assert!(bundled.bundles > 100, "{bundled}");
}

#[test]
fn dump_gives_every_field_and_only_what_is_selected() {
    let lines = |selection: &Selection| {
        let (mut text, mut json) = (Vec::new(), Vec::new());
        dump(data("kdis-log1.pcap"), &[], selection, |item| {
            text.push(item.to_string());
            json.push(item.json());
            Ok::<(), OpenError>(())
        })
        .unwrap();
        (text, json)
    };
    let (text, json) = lines(&Selection::default());
    assert_eq!((text.len(), json.len()), (88, 88));
    let all_json = json.join("\n");
    assert!(all_json.contains(r#""entity_id":{"site":"#), "{all_json}");
    assert!(!text.join("\n").contains("DAMAGED"));
    let (fires, _) = lines(&Selection { types: vec![PduType(2)], ..Selection::default() });
    assert_eq!(fires.len(), 1, "{fires:?}");
    assert!(fires[0].contains("Fire"), "{fires:?}");
}

#[test]
fn lint_finds_what_hurts() {
    let folder = Folder::new("lint");
    let path = folder.file("a.pcapng");
    let nan = EntityState { location: Location { x_m: f64::NAN, y_m: 0.0, z_m: 0.0 }, ..state(1) };
    let deep =
        EntityState { location: Location { x_m: 4_000_000.0, y_m: 0.0, z_m: 0.0 }, ..state(2) };
    let centre = EntityState { location: Location::default(), ..state(3) };
    let mut still = EntityState { dead_reckoning_algorithm: DeadReckoningAlgorithm(1), ..state(4) };
    still.linear_velocity_mps.x = 3.0;
    let bad_numbers = EntityState {
        dead_reckoning_algorithm: DeadReckoningAlgorithm(77),
        entity_type: EntityType::new(99, 2, 225, 57, 1, 2, 0),
        ..state(5)
    };
    let other_marking = EntityState { marking: Marking::new("DLH9").unwrap(), ..state(6) };
    let mut wrong_family = octets(0.0, &[&state(7)]);
    wrong_family[3] = 5;
    let unaligned = management::Acknowledge::default();
    let mut short = octets(0.0, &[&state(11)]);
    short[19] = 1;
    let remove =
        management::RemoveEntity { receiving_id: EntityId::new(1, 2, 9), ..Default::default() };
    let gone = EntityState { appearance: 1 << 23, ..state(10) };
    let mut odd = octets(0.0, &[&unaligned]);
    odd.extend([0; 4]);
    odd[9] += 4;
    let datagrams = [
        (0.0, 3000, octets(0.0, &[&nan])),
        (0.0, 3000, octets(0.0, &[&deep])),
        (0.0, 3000, octets(0.0, &[&centre])),
        (0.0, 3000, octets(0.0, &[&still])),
        (0.0, 3000, octets(0.0, &[&bad_numbers])),
        (0.0, 3000, octets(0.0, &[&state(6)])),
        (0.1, 3000, octets(0.1, &[&other_marking])),
        (0.2, 3000, wrong_family),
        (0.3, 3000, short),
        (0.4, 3000, octets(0.4, &[&state(8)])),
        (0.5, 3000, octets(0.3, &[&state(8)])),
        (0.45, 3000, octets(0.5, &[&state(9), &state(10)])),
        (1.0, 3000, octets(1.0, &[&remove])),
        (1.0, 3000, octets(1.0, &[&gone])),
        (20.0, 3000, octets(20.0, &[&state(8)])),
        (20.0, 3000, octets(20.0, &[&state(1), &state(2), &state(3), &state(4)])),
        (21.0, 3000, octets(21.0, &[&state(9), &state(10)])),
    ];
    write(&path, &datagrams);
    let mut found = Vec::new();
    lint(&path, &[], Limits::default(), |f| {
        found.push((f.rule, f.entity.map(|e| e.entity), f.to_string()))
    })
    .unwrap();
    let of = |rule: Rule| -> Vec<u16> {
        let mut all: Vec<u16> =
            found.iter().filter(|(r, ..)| *r == rule).map(|(_, e, _)| e.unwrap_or(0)).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    assert_eq!(of(Rule::NotFinite), [1]);
    assert_eq!(of(Rule::InsideEarth), [2, 3]);
    assert_eq!(of(Rule::StillModel), [4]);
    assert_eq!(of(Rule::Enumeration), [5]);
    assert_eq!(of(Rule::Duplicate), [6]);
    assert_eq!(of(Rule::Header), [0]);
    assert_eq!(of(Rule::Length), [0]);
    // Capture stamps (no entity) and time stamps of entity 8.
    assert_eq!(of(Rule::Backwards), [0, 8]);
    // 1 to 4 and 8 come back late; 5, 6 and 7 never do; 9 was removed, 10 deactivated.
    assert_eq!(of(Rule::Heartbeat), [1, 2, 3, 4, 5, 6, 7, 8], "{found:#?}");
    assert_eq!(of(Rule::Boundary), [] as [u16; 0]);
    let boundary = folder.file("b.pcapng");
    let mut bundle = octets(0.0, &[&state(1)]);
    bundle.truncate(0);
    let mut comment = octets(0.0, &[&management::StopFreeze::default()]);
    comment.extend_from_slice(&[0; 4]);
    comment[9] += 4;
    bundle.extend_from_slice(&comment);
    bundle.extend_from_slice(&octets(0.0, &[&state(1)]));
    write(&boundary, &[(0.0, 3000, bundle)]);
    let counts = lint(&boundary, &[], Limits::default(), |_| ()).unwrap();
    assert_eq!(counts.get(&Rule::Boundary), Some(&1));
    // A capture in order is silent about all that.
    let clean = folder.file("c.pcapng");
    let calm: Vec<_> = (0..10)
        .map(|i| (f64::from(i), 3000, octets(f64::from(i), &[&state(1), &state(2)])))
        .collect();
    write(&clean, &calm);
    let counts = lint(&clean, &[], Limits::default(), |f| panic!("{f}")).unwrap();
    assert!(counts.is_empty());
}

#[test]
fn diff_tells_what_is_missing_and_which_field_changed() {
    let folder = Folder::new("diff");
    let (a, b) = (folder.file("a.pcapng"), folder.file("b.pcapng"));
    let common: Vec<_> =
        (0..20).map(|i| (f64::from(i), 3000, octets(f64::from(i), &[&state(1)]))).collect();
    let mut first = common.clone();
    first.push((30.0, 3000, octets(30.0, &[&state(2)])));
    let mut second = common.clone();
    let changed = EntityState { capabilities: 7, ..state(1) };
    second[5] = (5.0, 3000, octets(5.0, &[&changed]));
    second.push((31.0, 3000, octets(31.0, &[&state(3), &state(4)])));
    write(&a, &first);
    write(&b, &second);
    let mut told = Vec::new();
    let counts = diff(&a, &b, &[], false, |d| told.push(d.clone())).unwrap();
    assert_eq!((counts.same, counts.changed, counts.only_first, counts.only_second), (19, 1, 1, 2));
    let fields = told.iter().find_map(|d| match d {
        Difference::Changed { fields, datagrams, .. } => Some((fields.clone(), *datagrams)),
        _ => None,
    });
    let expected = ("body.EntityState.capabilities", "0", "7");
    let (fields, datagrams) = fields.unwrap();
    assert_eq!(datagrams, (6, 6));
    assert_eq!(fields.len(), 1, "{fields:?}");
    assert!(fields[0].0.ends_with("capabilities"), "{fields:?}");
    assert_eq!((fields[0].1.as_str(), fields[0].2.as_str()), (expected.1, expected.2));
    assert!(diff(&a, &a, &[], false, |d| panic!("{d}")).unwrap().is_none());
    // The same traffic an hour later, sent by another clock.
    let shifted = folder.file("shifted.pcapng");
    let later: Vec<_> = (0..20)
        .map(|i| (f64::from(i) + 7.0, 3000, octets(f64::from(i) + 0.123, &[&state(1)])))
        .collect();
    write(&shifted, &later);
    let plain = folder.file("plain.pcapng");
    write(&plain, &common);
    assert_eq!(diff(&plain, &shifted, &[], true, |d| panic!("{d}")).unwrap().same, 20);
    assert_eq!(diff(&plain, &shifted, &[], false, |_| ()).unwrap().same, 0);
}

#[test]
fn cut_and_merge_by_time_entity_type_and_exercise() {
    let folder = Folder::new("edit");
    let (a, out) = (folder.file("a.pcapng"), folder.file("out.pcapng"));
    let remove =
        management::RemoveEntity { receiving_id: EntityId::new(1, 2, 2), ..Default::default() };
    let mut datagrams: Vec<_> = (0..10)
        .map(|i| (f64::from(i), 3000, octets(f64::from(i), &[&state(1), &state(2), &state(3)])))
        .collect();
    datagrams.push((9.5, 3000, octets(9.5, &[&remove])));
    datagrams.push((9.7, 3000, b"garbage".to_vec()));
    write(&a, &datagrams);
    let run = |selection: Selection, change: Change| {
        let done =
            edit(std::slice::from_ref(&a), &out, &[], &selection, &change, |_, p| panic!("{p}"))
                .unwrap();
        let read: Vec<_> = Reader::open(&out).unwrap().map(Result::unwrap).collect();
        assert_eq!(read.len() as u64, done.written);
        (done, read)
    };
    let (done, read) = run(Selection::default(), Change::default());
    assert_eq!((done.written, done.pdus), (12, 31), "everything, garbage too");
    let original: Vec<_> = Reader::open(&a).unwrap().map(Result::unwrap).collect();
    assert_eq!(read, original, "a copy");
    let some = Selection {
        from: Some("2.5".parse().unwrap()),
        to: Some("2023-11-14T22:13:25Z".parse().unwrap()),
        ..Selection::default()
    };
    let (done, read) = run(some, Change::default());
    assert_eq!(done.written, 3);
    assert_eq!(read[0].utc_ns, START + 3 * S);
    let one = Selection { entities: vec!["1:2:2".parse().unwrap()], ..Selection::default() };
    let (done, read) = run(one, Change::default());
    assert_eq!((done.written, done.pdus, done.damaged_left_out), (11, 11, 1));
    assert_eq!(read[0].payload.len(), 144, "the bundle has one PDU left");
    let change = Change {
        rewrite: Rewrite { exercise: Some(9), ..Rewrite::default() },
        from: Some("192.0.2.1:3000".parse().unwrap()),
        to: Some("127.0.0.1:3001".parse().unwrap()),
    };
    let (_, read) = run(Selection { types: vec![PduType(12)], ..Selection::default() }, change);
    assert_eq!((read.len(), read[0].payload[1]), (1, 9));
    assert_eq!((read[0].from.port(), read[0].to.port()), (3000, 3001));
    let (done, _) =
        run(Selection { exercises: vec![2], ..Selection::default() }, Change::default());
    assert_eq!(done.written, 0);

    // Merged: in the order of time, each file in its own.
    let b = folder.file("b.pcapng");
    let between: Vec<_> =
        (0..5).map(|i| (f64::from(i) + 0.5, 3000, octets(f64::from(i), &[&state(7)]))).collect();
    write(&b, &between);
    let both = [a.clone(), b.clone()];
    edit(&both, &out, &[], &Selection::default(), &Change::default(), |_, p| panic!("{p}"))
        .unwrap();
    let read: Vec<_> = Reader::open(&out).unwrap().map(Result::unwrap).collect();
    assert_eq!(read.len(), 17);
    assert!(read.is_sorted_by_key(|d| d.utc_ns));

    // Bare PDUs out, and in again.
    let bare = folder.file("out.raw");
    edit(&[b], &bare, &[], &Selection::default(), &Change::default(), |_, p| panic!("{p}"))
        .unwrap();
    assert_eq!(checked(&bare).0.pdus, 5);

    // Datagrams that end in garbage, or are nothing else: in bare PDUs nothing behind would be found.
    let noisy = folder.file("noisy.pcapng");
    let datagrams: Vec<_> = (0..2092)
        .map(|i| {
            let t = f64::from(i) * 0.01;
            let mut payload = octets(t, &[&state(1 + (i % 9) as u16)]);
            match i % 67 {
                66 => payload.extend([1, 2, 3]),
                33 => payload = vec![0xff; 40],
                44 => payload.truncate(70),
                55 => payload[9] = 0,
                _ => {}
            }
            (t, 3000, payload)
        })
        .collect();
    write(&noisy, &datagrams);
    let done =
        edit(&[noisy], &bare, &[], &Selection::default(), &Change::default(), |_, p| panic!("{p}"))
            .unwrap();
    // 31 of each kind; those with garbage behind their PDU keep the PDU.
    assert_eq!((done.read, done.written), (2092, 2092 - 93), "{done:?}");
    assert_eq!(done.damaged_left_out, 124, "{done:?}");
    let (found, _) = checked(&bare);
    assert_eq!(found.pdus, done.written, "everything written is read back");

    // What cannot be read leaves no output, what cannot be written no half of one.
    let none = folder.file("none.pcapng");
    let missing = [a.clone(), folder.file("missing.pcapng")];
    let error = edit(&missing, &none, &[], &Selection::default(), &Change::default(), |_, _| ());
    assert!(matches!(error, Err(EditError::Open(_))));
    assert!(!none.exists());
    let nowhere = folder.file("no-folder/out.pcapng");
    let error = edit(&[a], &nowhere, &[], &Selection::default(), &Change::default(), |_, _| ());
    assert!(error.unwrap_err().to_string().contains("no-folder"));
}

#[test]
fn findings_are_one_json_object_a_line() {
    let folder = Folder::new("json");
    let path = folder.file("a.pcapng");
    write(&path, &[(0.0, 3000, octets(0.0, &[&state(1)])), (1.0, 3000, vec![9; 40])]);
    let mut lines = Vec::new();
    check(&path, &[], |f: &Finding<'_>| lines.push(f.json())).unwrap();
    assert_eq!(lines.len(), 1);
    assert!(lines[0].starts_with(r#"{"finding":"damaged","frame":2,"pdu":0,"#), "{lines:?}");
}

#[test]
fn what_is_no_plain_file_is_written_to_and_never_replaced() {
    use capture::tools::edit::{Change, edit};
    use std::os::unix::fs::FileTypeExt;
    let folder = Folder::new("devices");
    let source = folder.file("source.pcapng");
    write(&source, &[(0.0, 3000, octets(0.0, &[&state(1)]))]);
    let to = |output: &Path| {
        let (all, same) = (Selection::default(), Change::default());
        edit(std::slice::from_ref(&source), output, &[], &all, &same, |_, p| panic!("{p}"))
    };
    let full = to(Path::new("/dev/full")).expect_err("no room").to_string();
    assert_eq!(full, "/dev/full: No space left on device (os error 28)");
    let device = std::fs::metadata("/dev/full").expect("there").file_type();
    assert!(device.is_char_device(), "still a device");
    let (kept, link) = (folder.file("kept.pcapng"), folder.file("link.pcapng"));
    std::fs::write(&kept, "before").expect("written");
    std::os::unix::fs::symlink(&kept, &link).expect("a link");
    to(&link).expect("whole");
    assert!(link.is_symlink(), "a link stays a link");
    assert_eq!(checked(&kept).0.pdus, 1);
}
