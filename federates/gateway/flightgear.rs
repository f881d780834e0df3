//! FlightGear multiplayer: one position message an entity, 232 octets big-endian, for an eye view in somebody's own FlightGear.
//!
//! Header (32): magic, protocol 1.1, message 7, length, range in NM, reply port, call sign. Body (200): model, time, lag, position
//! (earth-centred, m), orientation as angle times axis (earth-centred to body), velocities and accelerations in body axes
//! (x forward, y right, z down; accelerations and turns from one scan to the next), four octets of nothing. Source: FlightGear's `mpmessages.hxx` as of 2021.

use super::Gateway;
use super::board::Board;
use super::items::ascii;
use crate::runtime::messages::{ScanReport, TruthMessage};
use geodesy::Enu;
use std::collections::{BTreeMap, BTreeSet};

/// Octets of a message.
pub const LENGTH: usize = 232;
const MAGIC: u32 = 0x4647_4653;
const VERSION: u32 = 0x0001_0001;
const POSITION: u32 = 7;
const RANGE_NM: u32 = 100;
/// Messages of one scan.
const MOST: usize = 1000;

/// How the motion of an entity changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Acceleration, m/s² east, north, up.
    pub acceleration_mps2: [f64; 3],
    /// Turn of the nose, rad/s clockwise as seen from above.
    pub turn_radps: f64,
    /// Change of the turn, rad/s².
    pub turn_radps2: f64,
}

/// What is kept of an entity from one scan to the next.
#[derive(Clone, Copy, Debug)]
struct Before {
    time_ns: i64,
    velocity_mps: [f64; 3],
    heading_rad: f64,
    /// None in its first scan.
    turn_radps: Option<f64>,
}

/// Motions of all entities, by what they were a scan before, and the names that they have.
#[derive(Clone, Debug, Default)]
pub struct Motions {
    run: u32,
    before: BTreeMap<u64, Before>,
    names: Names,
}

/// Characters of a name.
const NAME: usize = 7;
/// Names that are kept for who may come again.
const MOST_NAMES: usize = 16_384;

/// Names of a run, each of one entity alone: FlightGear knows aircraft by nothing else.
#[derive(Clone, Debug, Default)]
struct Names {
    given: BTreeMap<u64, String>,
    taken: BTreeSet<String>,
}

impl Names {
    /// Where too many were given: those of who is not there any more.
    fn forget(&mut self, scan: &ScanReport) {
        if self.given.len() > MOST_NAMES {
            let there: BTreeSet<u64> = scan.truth.iter().map(TruthMessage::key).collect();
            self.given.retain(|key, _| there.contains(key));
            self.taken = self.given.values().cloned().collect();
        }
    }

    /// The name of an entity: the first seven characters of its call sign; if somebody has these, or it has none, the first three and
    /// the last four; if somebody has those too, a number behind them. It keeps it for the run.
    fn of(&mut self, truth: &TruthMessage) -> &str {
        let Self { given, taken } = self;
        given.entry(truth.key()).or_insert_with(|| {
            let whole = ascii(&truth.callsign, usize::MAX);
            let head = |most| whole.get(..most).unwrap_or(&whole);
            let ends = match whole.len().checked_sub(4) {
                Some(tail) if whole.len() > NAME => format!("{}{}", head(3), &whole[tail..]),
                _ => whole.clone(),
            };
            let numbered = (1_u64..).map(|n| {
                let number = n.to_string();
                let room = NAME.saturating_sub(number.len()).min(ends.len());
                format!("{}{number}", &ends[..room])
            });
            let mut wishes = [head(NAME).to_owned(), ends.clone()].into_iter().chain(numbered);
            let free = |name: &String| !name.is_empty() && !taken.contains(name);
            let name = wishes.find(free).unwrap_or_default();
            taken.insert(name.clone());
            name
        })
    }
}

impl Motions {
    /// The motion of each entity of a scan, in their order; of one that was not there a scan before nothing is known.
    pub fn on_scan(&mut self, scan: &ScanReport) -> Vec<Motion> {
        if self.run != scan.run {
            *self = Self { run: scan.run, ..Self::default() };
        }
        let before = std::mem::take(&mut self.before);
        let mut motions = Vec::with_capacity(scan.truth.len());
        for truth in &scan.truth {
            let mut now = Before {
                time_ns: scan.time_ns,
                velocity_mps: truth.velocity_mps,
                heading_rad: truth.heading_rad,
                turn_radps: None,
            };
            let mut motion = Motion::default();
            let then = before.get(&truth.key()).filter(|then| then.time_ns < scan.time_ns);
            if let Some(then) = then {
                let dt_s = (scan.time_ns - then.time_ns) as f64 / 1e9;
                for (a, (v, u)) in motion
                    .acceleration_mps2
                    .iter_mut()
                    .zip(now.velocity_mps.iter().zip(then.velocity_mps))
                {
                    *a = (v - u) / dt_s;
                }
                motion.turn_radps = turned_rad(then.heading_rad, now.heading_rad) / dt_s;
                motion.turn_radps2 =
                    then.turn_radps.map_or(0.0, |turn| (motion.turn_radps - turn) / dt_s);
                now.turn_radps = Some(motion.turn_radps);
            }
            self.before.insert(truth.key(), now);
            motions.push(motion);
        }
        motions
    }
}

/// The shorter turn from one heading to another, clockwise positive.
fn turned_rad(from_rad: f64, to_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (to_rad - from_rad + PI).rem_euclid(TAU) - PI
}

/// The messages of a scan's entities.
#[must_use]
pub fn packets(scan: &ScanReport, board: &Board, motions: &mut Motions) -> Vec<[u8; LENGTH]> {
    let of_scan = motions.on_scan(scan);
    motions.names.forget(scan);
    let all: Vec<_> = scan.truth.iter().zip(&of_scan).take(MOST).collect();
    let one = |gateway: &Gateway| {
        let one = |(truth, motion): &(&TruthMessage, &Motion)| {
            packet(gateway, truth, motions.names.of(truth), scan.time_ns, motion)
        };
        all.iter().map(one).collect()
    };
    board.with_gateway(one)
}

/// The message of one entity; of `name` the first seven characters.
#[must_use]
pub fn packet(
    gateway: &Gateway,
    truth: &TruthMessage,
    name: &str,
    time_ns: i64,
    motion: &Motion,
) -> [u8; LENGTH] {
    let mut out = Writer { octets: [0; LENGTH], at: 0 };
    out.put(&MAGIC.to_be_bytes());
    out.put(&VERSION.to_be_bytes());
    out.put(&POSITION.to_be_bytes());
    out.put(&(LENGTH as u32).to_be_bytes());
    out.put(&RANGE_NM.to_be_bytes());
    out.put(&0_u32.to_be_bytes());
    out.text(name, NAME + 1);
    out.text(model(truth), 96);
    out.put(&(time_ns as f64 / 1e9).to_be_bytes());
    out.put(&0.1_f64.to_be_bytes());
    let [east_m, north_m, up_m]: [f64; 3] = truth.position_m.into();
    let point = gateway.frame.to_ecef(Enu { east_m, north_m, up_m });
    for coordinate in [point.x_m, point.y_m, point.z_m] {
        out.put(&coordinate.to_be_bytes());
    }
    let place = point.to_geodetic();
    let axis =
        orientation(place.lat_deg().to_radians(), place.lon_deg().to_radians(), truth.heading_rad);
    out.floats(&axis);
    let (sine, cosine) = (libm::sin(truth.heading_rad), libm::cos(truth.heading_rad));
    // Nothing is plus zero.
    let body = |[e, n, u]: [f64; 3]| {
        [n * cosine + e * sine, e * cosine - n * sine, -u].map(|part| part + 0.0)
    };
    out.floats(&body(truth.velocity_mps));
    out.floats(&[0.0, 0.0, motion.turn_radps]);
    out.floats(&body(motion.acceleration_mps2));
    out.floats(&[0.0, 0.0, motion.turn_radps2]);
    out.octets
}

/// Angle times axis of the rotation from earth-centred to body axes, level, nose at `heading_rad`.
#[must_use]
pub fn orientation(lat_rad: f64, lon_rad: f64, heading_rad: f64) -> [f64; 3] {
    // To north, east, down: about z by the longitude, then about y by −(90° + latitude). Then about z by the heading.
    let (sz, cz) = (libm::sin(lon_rad / 2.0), libm::cos(lon_rad / 2.0));
    let y = -std::f64::consts::FRAC_PI_4 - lat_rad / 2.0;
    let (sy, cy) = (libm::sin(y), libm::cos(y));
    let level = [cz * cy, -sz * sy, cz * sy, sz * cy];
    let (sh, ch) = (libm::sin(heading_rad / 2.0), libm::cos(heading_rad / 2.0));
    let [w, x, y, z] = level;
    let q = [w * ch - z * sh, x * ch + y * sh, y * ch - x * sh, w * sh + z * ch];
    let half = libm::acos(q[0].clamp(-1.0, 1.0));
    let sine = libm::sin(half);
    if sine.abs() < 1e-12 {
        return [0.0; 3];
    }
    [q[1], q[2], q[3]].map(|part| part * 2.0 * half / sine)
}

/// A model that FlightGear knows; it shows one of its own where it lacks it.
fn model(truth: &TruthMessage) -> &'static str {
    match truth.type_designator.get(..2).unwrap_or_default() {
        _ if !truth.aircraft => "Aircraft/followme/Models/follow_me.xml",
        "B7" if truth.type_designator.starts_with("B77") => "Aircraft/777/Models/777-200ER.xml",
        "A3" | "A2" => "Aircraft/A320neo/Models/A320neo.xml",
        _ => "Aircraft/737-800/Models/737-800.xml",
    }
}

struct Writer {
    octets: [u8; LENGTH],
    at: usize,
}

impl Writer {
    fn put(&mut self, octets: &[u8]) {
        self.octets[self.at..self.at + octets.len()].copy_from_slice(octets);
        self.at += octets.len();
    }

    /// A text in `size` octets with at least one zero behind it.
    fn text(&mut self, text: &str, size: usize) {
        let octets = text.as_bytes();
        let length = octets.len().min(size - 1);
        self.octets[self.at..self.at + length].copy_from_slice(&octets[..length]);
        self.at += size;
    }

    fn floats(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.put(&(*value as f32).to_be_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geodesy::Geodetic;
    use models::frames::Point3;

    /// A second reading of the message, by the offsets of its fields.
    fn f64_at(octets: &[u8], at: usize) -> f64 {
        f64::from_be_bytes(octets[at..at + 8].try_into().expect("eight"))
    }

    fn f32_at(octets: &[u8], at: usize) -> f64 {
        f64::from(f32::from_be_bytes(octets[at..at + 4].try_into().expect("four")))
    }

    /// Where an axis of the body points in earth-centred coordinates (Rodrigues' formula).
    fn turned(axis: [f64; 3], v: [f64; 3]) -> [f64; 3] {
        let angle = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        let k = axis.map(|a| a / angle);
        let cross =
            [k[1] * v[2] - k[2] * v[1], k[2] * v[0] - k[0] * v[2], k[0] * v[1] - k[1] * v[0]];
        let dot: f64 = k.iter().zip(v).map(|(a, b)| a * b).sum();
        let (s, c) = libm::sincos(angle);
        [0, 1, 2].map(|i| v[i] * c + cross[i] * s + k[i] * dot * (1.0 - c))
    }

    #[test]
    fn a_message_read_by_its_offsets_says_place_and_attitude() {
        let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene");
        let gateway = Gateway::new(&scene, crate::gateway::Choice::default());
        for heading_deg in [0.0, 45.0, 137.0, 359.0_f64] {
            let heading_rad = heading_deg.to_radians();
            let truth = TruthMessage {
                id: [1, 2, 3],
                callsign: "SWR137HXY".into(),
                address: None,
                type_designator: "B77W".into(),
                aircraft: true,
                size_m: [70.0, 60.0],
                position_m: Point3::new(1000.0, -2000.0, 30.0),
                velocity_mps: [10.0 * libm::sin(heading_rad), 10.0 * libm::cos(heading_rad), 2.0],
                heading_rad,
                ours: true,
                track: None,
            };
            let octets = packet(&gateway, &truth, "SWR137HXY", 12_500_000_000, &Motion::default());
            assert_eq!(&octets[..16], b"FGFS\0\x01\0\x01\0\0\0\x07\0\0\0\xe8");
            assert_eq!(&octets[24..32], b"SWR137H\0");
            assert_eq!(&octets[32..64], b"Aircraft/777/Models/777-200ER.xm");
            assert_eq!((f64_at(&octets, 128), f64_at(&octets, 136)), (12.5, 0.1));
            let point = [144, 152, 160].map(|at| f64_at(&octets, at));
            let expected =
                gateway.frame.to_ecef(Enu { east_m: 1000.0, north_m: -2000.0, up_m: 30.0 });
            assert_eq!(point, [expected.x_m, expected.y_m, expected.z_m]);
            // The nose points where one metre along the heading leads.
            let axis = [168, 172, 176].map(|at| f32_at(&octets, at));
            let nose = turned(axis, [1.0, 0.0, 0.0]);
            let place: Geodetic = expected.to_geodetic();
            let (lat, lon) = (place.lat_deg().to_radians(), place.lon_deg().to_radians());
            let north = [
                -libm::sin(lat) * libm::cos(lon),
                -libm::sin(lat) * libm::sin(lon),
                libm::cos(lat),
            ];
            let east = [-libm::sin(lon), libm::cos(lon), 0.0];
            for i in 0..3 {
                let wanted = north[i] * libm::cos(heading_rad) + east[i] * libm::sin(heading_rad);
                assert!((nose[i] - wanted).abs() < 1e-6, "{heading_deg}: {nose:?}");
            }
            let down = turned(axis, [0.0, 0.0, 1.0]);
            let up =
                [libm::cos(lat) * libm::cos(lon), libm::cos(lat) * libm::sin(lon), libm::sin(lat)];
            assert!((0..3).all(|i| (down[i] + up[i]).abs() < 1e-6), "{down:?}");
            let velocity = [180, 184, 188].map(|at| f32_at(&octets, at));
            assert!((velocity[0] - 10.0).abs() < 1e-5 && velocity[1].abs() < 1e-5, "{velocity:?}");
            assert_eq!(velocity[2], -2.0);
            assert!(octets[192..].iter().all(|o| *o == 0));
        }
    }

    /// Whoever listens knows aircraft by the seven characters of their names alone: two of one name would be one that leaps.
    #[test]
    fn everybody_has_a_name_of_his_own_and_keeps_it() {
        let board = Board::new(
            &scenarios::load_without_truth(&scenarios::locate("xsyn")).expect("the scene"),
            1,
            false,
        );
        let mut motions = Motions::default();
        let mut names = |run, list: &[(u16, &str)]| -> Vec<String> {
            let truth = list.iter().map(|(entity, callsign)| TruthMessage {
                id: [1, 1, *entity],
                callsign: (*callsign).into(),
                address: None,
                type_designator: "A320".into(),
                aircraft: true,
                size_m: [40.0, 36.0],
                position_m: Point3::new(0.0, 0.0, 0.0),
                velocity_mps: [0.0; 3],
                heading_rad: 0.0,
                ours: true,
                track: None,
            });
            let scan = ScanReport { run, truth: truth.collect(), ..ScanReport::default() };
            let name = |octets: &[u8; LENGTH]| {
                let end = octets[24..32].iter().position(|o| *o == 0).expect("an end");
                String::from_utf8(octets[24..24 + end].to_vec()).expect("text")
            };
            packets(&scan, &board, &mut motions).iter().map(name).collect()
        };
        let all =
            [(1, "FOLLOWME1"), (2, "FOLLOWME2"), (3, "SWR1"), (4, ""), (5, "日本"), (6, "SWR1")];
        let first = names(1, &all);
        assert_eq!(first[..3], ["FOLLOWM", "FOLWME2", "SWR1"]);
        let own: std::collections::BTreeSet<&String> = first.iter().collect();
        assert_eq!(own.len(), all.len(), "{first:?}");
        assert!(first.iter().all(|name| !name.is_empty()), "{first:?}");
        // Who leaves changes nobody's name; nor does the order.
        let fewer = [all[5], all[4], all[1]];
        assert_eq!(names(1, &fewer), [&first[5], &first[4], &first[1]].map(Clone::clone));
        assert_eq!(names(2, &fewer), ["SWR1", &first[3], "FOLLOWM"], "another run begins anew");
        let many: Vec<(u16, &str)> = (0..900).map(|entity| (entity, "VEHICLE_OF_NOBODY")).collect();
        let many = names(3, &many);
        assert_eq!(many.iter().collect::<std::collections::BTreeSet<_>>().len(), 900);
    }

    /// One that speeds up by 2 m/s² while it turns right through north, and climbs ever faster: what a receiver goes on with between
    /// two packets.
    #[test]
    fn accelerations_and_turns_are_those_from_scan_to_scan_in_body_axes() {
        let scene = scenarios::load_without_truth(&scenarios::locate("eham")).expect("the scene");
        let gateway = Gateway::new(&scene, crate::gateway::Choice::default());
        let mut motions = Motions::default();
        // Headings 350°, 356°, 5°: 6°/s, then 9°/s, so 3°/s².
        let scan = |n: i64, run: u32| {
            let heading_rad = [350.0, 356.0, 5.0_f64][n as usize].to_radians();
            let truth = TruthMessage {
                id: [1, 2, 3],
                callsign: "KLM1".into(),
                address: None,
                type_designator: String::new(),
                aircraft: true,
                size_m: [40.0, 36.0],
                position_m: Point3::new(0.0, 0.0, 50.0),
                velocity_mps: [1.0 * n as f64, 20.0 + 2.0 * n as f64, 0.5 * n as f64],
                heading_rad,
                ours: true,
                track: None,
            };
            ScanReport {
                run,
                time_ns: n * 1_000_000_000,
                truth: vec![truth],
                ..ScanReport::default()
            }
        };
        let read = |scan: &ScanReport, motion: &Motion| {
            let octets = packet(&gateway, &scan.truth[0], "KLM1", scan.time_ns, motion);
            std::array::from_fn::<f64, 9, _>(|i| f32_at(&octets, 192 + 4 * i))
        };
        let first = scan(0, 1);
        assert_eq!(read(&first, &motions.on_scan(&first)[0]), [0.0; 9], "nothing is known yet");
        let second = scan(1, 1);
        let motion = motions.on_scan(&second)[0];
        assert!(
            (motion.turn_radps - 6.0_f64.to_radians()).abs() < 1e-9 && motion.turn_radps2 == 0.0
        );
        let third = scan(2, 1);
        let said = read(&third, &motions.on_scan(&third)[0]);
        let (s, c) = libm::sincos(5.0_f64.to_radians());
        let expected = [
            0.0,
            0.0,
            9.0_f64.to_radians(),
            2.0 * c + 1.0 * s,
            1.0 * c - 2.0 * s,
            -0.5,
            0.0,
            0.0,
            3.0_f64.to_radians(),
        ];
        for (found, wanted) in said.iter().zip(expected) {
            assert!((found - wanted).abs() < 1e-6, "{said:?}");
        }
        // The same scan again has no time between; another run knows nothing of this one.
        assert_eq!(motions.on_scan(&third)[0], Motion::default());
        assert_eq!(motions.on_scan(&scan(2, 2))[0], Motion::default());
    }
}
