//! Heights from the transponder to ASTERIX: who flies is in the air there, and on the ground after touchdown.

use super::visitor_tests::drive;
use crate::gateway::items::ident;
use crate::gateway::{Choice, Gateway};
use crate::runtime::codec::decode;
use crate::runtime::messages::ScanReport;
use asterix::table::Item;
use asterix::{Record, Value, blocks, cat011, cat020, cat021, cat062};
use scenarios::Scene;
use std::collections::BTreeMap;
use std::sync::Arc;

const SECONDS: u64 = 420;
/// What is said of a target that is this high and more, m, and of one that is this low and less: beside 15 m by a step of 25 ft, and by
/// what an arrival sinks in the second of a report.
const SURELY_UP_M: f64 = 25.0;
const SURELY_DOWN_M: f64 = 5.0;

/// Generated traffic on the synthetic airport, with ADS-B and multilateration beside its radar.
fn equipped() -> Arc<Scene> {
    let place = scenarios::locate("xsyn");
    let stations =
        [(0.02, 0.0), (0.006, 0.019), (-0.016, 0.012), (-0.016, -0.012), (0.006, -0.019)];
    let stations = stations.map(|(lat, lon)| {
        format!("{{ lat_deg = {}, lon_deg = {}, height_m = 12 }}", 44.995 + lat, 9.996 + lon)
    });
    let more = format!(
        "\n[[sensor]]\nkind = \"adsb\"\nname = \"ADS-B\"\n\n[[sensor]]\nkind = \"mlat\"\nname = \"MLAT\"\noverrides = {{ stations = [{}] }}\n",
        stations.join(", ")
    );
    let text = scenarios::text_of(&place).expect("read") + &more;
    Arc::new(scenarios::load_text(&place, &text).expect("a scene"))
}

fn flag(record: &Record<'_>, item: &'static Item, name: &str) -> Option<bool> {
    Some(record.get(item)?.value(name)? != Value::Integer(0))
}

/// Records that said of a target in the air, and of one on the ground, what it is, by category.
type Counts = BTreeMap<(u8, bool), usize>;

fn held_against_truth(scene: &Arc<Scene>) -> (Counts, usize) {
    let mut gateway = Gateway::new(scene, Choice::default());
    let (mut counts, mut landed) = (Counts::new(), 0);
    // Height at the end of the scan before, by call sign.
    let mut before: BTreeMap<String, f64> = BTreeMap::new();
    drive(
        scene,
        SECONDS,
        |_| Vec::new(),
        |out| {
            let scan = out.publish.iter().find(|p| p.key == "tracks/1/scan").expect("published");
            let scan: ScanReport = decode(&scan.body).expect("sound");
            let now: BTreeMap<String, f64> =
                scan.truth.iter().map(|t| (ident(&t.callsign), t.position_m.z)).collect();
            landed += now
                .iter()
                .filter(|(k, z)| **z < 1.0 && before.get(*k).is_some_and(|b| *b >= 1.0))
                .count();
            for datagram in gateway.on_scan(&scan) {
                let records =
                    blocks(&datagram).flat_map(|b| b.expect("sound").records().collect::<Vec<_>>());
                for record in records.map(|r| r.expect("sound")) {
                    let text = |item| Some(record.get(item)?.text()?.as_str().trim().to_owned());
                    let followed = |item| {
                        let number = record.number(item)? as u16;
                        let truth = scan
                            .truth
                            .iter()
                            .find(|t| t.track.is_some_and(|(n, _)| n == number))?;
                        Some(ident(&truth.callsign))
                    };
                    let said = match record.category.number {
                        20 => text(&cat020::I245).zip(flag(&record, &cat020::I020, "GBS")),
                        21 => text(&cat021::I170).zip(flag(&record, &cat021::I040, "GBS")),
                        62 => followed(&cat062::I040).zip(flag(&record, &cat062::I080, "SFC")),
                        11 => followed(&cat011::I161).zip(flag(&record, &cat011::I170, "GBS")),
                        _ => None,
                    };
                    let Some((name, ground)) = said else { continue };
                    let (Some(z), Some(b)) = (now.get(&name), before.get(&name)) else { continue };
                    let up = z.min(*b) >= SURELY_UP_M;
                    if !up && z.max(*b) > SURELY_DOWN_M {
                        continue;
                    }
                    let (category, at_s) = (record.category.number, scan.time_ns as f64 * 1e-9);
                    // A track that no plot with a height has reached yet has none.
                    let unknown = category == 62 && record.get(&cat062::I130).is_none()
                        || category == 11 && record.get(&cat011::I092).is_none();
                    assert!(ground != up || unknown, "{category}: {name} at {z} m, {at_s} s");
                    if unknown {
                        continue;
                    }
                    *counts.entry((category, up)).or_default() += 1;
                    if category == 21 {
                        assert_eq!(record.get(&cat021::I160).is_some(), up, "{name} at {z} m");
                        assert_eq!(record.get(&cat021::RE).is_some(), !up, "{name} at {z} m");
                        let sent = [&cat021::I071, &cat021::I073].map(|item| record.number(item));
                        assert_eq!(sent[0], sent[1], "received when it was sent");
                    }
                    if let [Some([_, nm_s, degrees]), Some(truth)] = [
                        record.numbers(&cat021::I160),
                        scan.truth.iter().find(|t| ident(&t.callsign) == name).map(|t| {
                            let [e, n, _] = t.velocity_mps;
                            [0.0, libm::hypot(e, n), libm::atan2(e, n).to_degrees()]
                        }),
                    ] {
                        assert!(
                            (nm_s * 1852.0 - truth[1]).abs() < 3.0,
                            "{name}: {nm_s} NM/s, {truth:?}"
                        );
                        let turn = (degrees - truth[2] + 180.0).rem_euclid(360.0) - 180.0;
                        assert!(turn.abs() < 4.0, "{name}: {degrees}, {truth:?}");
                    }
                    let height_ft = match category {
                        21 => record.number(&cat021::I140),
                        20 => record.number(&cat020::I105),
                        62 => record.number(&cat062::I130),
                        _ => record.number(&cat011::I092),
                    };
                    if let Some(ft) = height_ft {
                        let height_m = ft * 0.3048 - scene.airport.reference.height_m;
                        let off_m = (height_m - z).abs().min((height_m - b).abs());
                        assert!(off_m < 12.0, "{category}: {name} {height_m} m for {z} m");
                    }
                    if category == 11 && record.number(&cat011::I430) == Some(9.0) {
                        assert!(up, "{name}: on final at {z} m");
                        *counts.entry((9, true)).or_default() += 1;
                    }
                }
            }
            before = now;
        },
    );
    (counts, landed)
}

#[test]
fn an_arrival_on_final_is_airborne_until_touchdown_and_on_the_ground_after() {
    let shipped = Arc::new(scenarios::load(&scenarios::locate("asmgcs")).expect("the scene"));
    for scene in [shipped, equipped()] {
        let (counts, landed) = held_against_truth(&scene);
        println!("{}: {landed} landed; {counts:?}", scene.name);
        assert!(landed > 0, "{}: nobody landed", scene.name);
        for category in [20, 21, 62, 11] {
            for up in [true, false] {
                let count = counts.get(&(category, up)).copied().unwrap_or_default();
                assert!(count > 20, "{}: {category} {up}: {counts:?}", scene.name);
            }
        }
        assert!(counts.contains_key(&(9, true)), "{}: nobody on final", scene.name);
    }
}
