//! The binary form of one scan, as the browser reads it (`web/frame.js` is the other end).
//!
//! Little-endian. Header of 40 octets: `SEED`, version, flags (bit 0: this is the newest scan), number of the run in
//! the session u16, scan number u64, time i64 ns, counts of tracks, truth, plots and trails u32 each. Then the fixed-size
//! records in that order; a trail is a track number u16, a count u16 and that many east, north f32 pairs,
//! newest first. Missing figures are NaN, a missing index is −1.
//!
//! The last 40 octets of a track: address u32 (0: none), age of its plot in this scan f32 s, then an octet each: state,
//! stage of an alert, emitter category, sensors of its plots in this scan (bit by the place of their kind), clearance, bits (0: the
//! label is assumed, 1: unresolved, 2: coasted between, 3: the state is by map and speed only), probability of the label and of existence (⌊254 p⌋, 255: unknown); then where
//! it was one scan ago as it is known now, f32: east, north, variances ee, en, nn; four octets zero. State, stage and clearance are
//! those of [`Note`], as said of earlier scans; 0: unknown or none. The emitter category is that of I021/020 by the label: 1, 3, 5 by wake, 20 for
//! a fire engine, 21 for another vehicle, 0 without a label. What a page was told later (`alerts`, `traffic`) goes before.

use crate::runtime::messages::{PlotMessage, ScanReport, TrackMessage, TruthMessage};
use models::flight_list::{MovementKind, WakeCategory};
use models::time::SimTime;
use models::track::{TrackStatus, TrackType};
use models::words::Word;
use serde_json::json;
use std::collections::BTreeMap;

/// First octets of every message.
pub const MAGIC: [u8; 4] = *b"SEED";
/// Version of the layout; the page refuses another one.
pub const VERSION: u8 = 3;
/// Octets of the header.
pub const HEADER: usize = 40;
/// Octets of a track record.
pub const TRACK: usize = 152;
/// Octets of a truth record.
pub const TRUTH: usize = 80;
/// Octets of a plot record.
pub const PLOT: usize = 56;

/// What is noted of one track; zeros: nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Note {
    /// What it does: a place in [`DOING`].
    pub doing: u8,
    /// Whether that is by map and speed only.
    pub derived: bool,
    /// Stage of its gravest alert: 0 none, 1 information, 2 alarm.
    pub alert: u8,
    /// What it was cleared for last of what stands: a place in [`CLEARED`], from 1.
    pub cleared: u8,
}

/// The notes of a scan, by number of the track.
pub type Noted = BTreeMap<u16, Note>;

/// What a track may do, by its number.
pub const DOING: [&str; 17] = [
    "", "parked", "pushing", "ready", "taxiing", "holding", "crossing", "lined up", "rolling",
    "airborne", "final", "landing", "vacated", "docking", "standing", "driving", "failed",
];

/// Clearances by their number, from 1.
pub const CLEARED: [&str; 13] =
    ["PSH", "TAX", "HLD", "CRO", "LUP", "TOF", "CTO", "LND", "GOA", "BTR", "ENT", "SPD", "REV"];

/// Positions of a track in earlier scans, newest first, m east and north.
pub type Trail = (u16, Vec<[f32; 2]>);

/// [`encode_noted`] of a scan of which nothing is noted.
#[must_use]
pub fn encode(scan: &ScanReport) -> Vec<u8> {
    encode_noted(scan, &Noted::new())
}

/// Octets of header and records without trails; [`with_trails`] completes them.
#[must_use]
pub fn encode_noted(scan: &ScanReport, noted: &Noted) -> Vec<u8> {
    let size =
        HEADER + scan.tracks.len() * TRACK + scan.truth.len() * TRUTH + scan.plots.len() * PLOT;
    let mut out = Vec::with_capacity(size);
    out.extend(MAGIC);
    out.extend([VERSION, 0, 0, 0]);
    out.extend(scan.scan.to_le_bytes());
    out.extend(scan.time_ns.to_le_bytes());
    for count in [scan.tracks.len(), scan.truth.len(), scan.plots.len(), 0] {
        out.extend((count as u32).to_le_bytes());
    }
    let paired = pairs(scan);
    let index_of: BTreeMap<&str, i32> =
        scan.truth.iter().enumerate().map(|(i, t)| (t.callsign.as_str(), i as i32)).collect();
    let mut seen: BTreeMap<u16, (i64, u8)> = BTreeMap::new();
    for point in &scan.plots {
        if let Some(number) = point.track {
            let (newest_ns, kinds) = seen.entry(number).or_insert((i64::MIN, 0));
            *newest_ns = point.time_ns.max(*newest_ns);
            let place = point.kind.place();
            *kinds |= place.and_then(|p| 1_u8.checked_shl(p as u32)).unwrap_or(0);
        }
    }
    for point in &scan.tracks {
        let pair = paired.get(&point.number);
        let (index, error_m) = pair.map_or((-1, f64::NAN), |p| (p.0 as i32, p.1));
        track(&mut out, point, index, error_m);
        let (age_s, kinds) = seen
            .get(&point.number)
            .map_or((f64::NAN, 0), |(ns, kinds)| ((scan.time_ns - ns) as f64 * 1e-9, *kinds));
        let note = noted.get(&point.number).copied().unwrap_or_default();
        track_more(&mut out, point, (age_s, kinds), note);
    }
    for point in &scan.truth {
        truth(&mut out, point);
    }
    for point in &scan.plots {
        let index = index_of.get(point.cause.as_str()).copied().unwrap_or(-1);
        plot(&mut out, point, index, (scan.time_ns - point.time_ns) as f64 * 1e-9);
    }
    debug_assert_eq!(out.len(), size);
    out
}

/// Writes which run of the session a message is of.
pub fn set_run(message: &mut [u8], run: u16) {
    message[6..8].copy_from_slice(&run.to_le_bytes());
}

/// The message for a client: `frame` of [`encode`] with its trails and the flag for the newest scan.
#[must_use]
pub fn with_trails(frame: &[u8], newest: bool, trails: &[Trail]) -> Vec<u8> {
    let mut out = Vec::with_capacity(frame.len() + trails.len() * 256);
    out.extend(frame);
    out[5] = u8::from(newest);
    out[36..40].copy_from_slice(&(trails.len() as u32).to_le_bytes());
    for (number, points) in trails {
        out.extend(number.to_le_bytes());
        out.extend((points.len() as u16).to_le_bytes());
        for [east, north] in points {
            out.extend(east.to_le_bytes());
            out.extend(north.to_le_bytes());
        }
    }
    out
}

/// For each track that follows an entity: index of its truth in the scan, and the distance in m.
pub(super) fn pairs(scan: &ScanReport) -> BTreeMap<u16, (usize, f64)> {
    scan.followed()
}

/// Key of an entity in the page: its DIS identifier as one number.
#[must_use]
pub fn entity_key(id: [u16; 3]) -> u64 {
    u64::from(id[0]) << 32 | u64::from(id[1]) << 16 | u64::from(id[2])
}

/// An entity as a message has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Entity {
    /// Its identifier: [`entity_key`].
    pub key: u64,
    /// Call sign.
    pub callsign: String,
    /// Type designator.
    pub designator: String,
    /// Where it is, m east, north, up.
    pub position_m: [f64; 3],
    /// Velocity over ground, m/s east, north.
    pub velocity_mps: [f64; 2],
    /// Where the nose points, rad clockwise from north.
    pub heading_rad: f64,
    /// Whether it is an aircraft.
    pub aircraft: bool,
    /// Length, m.
    pub length_m: f64,
}

/// What [`reduced`] leaves in a message.
#[derive(Clone, Debug, Default)]
pub(super) struct Keeps {
    /// All tracks; else those that follow an entity that stays.
    pub tracks: bool,
    /// The plots.
    pub plots: bool,
    /// Which entities, by their place in the message.
    pub truth: Vec<bool>,
}

/// A message with some of its tracks, entities and plots only. No track and no plot tells any more how far it is from the truth; a track tells
/// which entity it follows where that one stays. None if it is no message.
pub(super) fn reduced(message: &[u8], keeps: &Keeps) -> Option<Vec<u8>> {
    let count = |at| octets(message, at).map(|n| u32::from_le_bytes(n) as usize);
    let [tracks, truths, plots, trails] = [count(24)?, count(28)?, count(32)?, count(36)?];
    let truth_from = HEADER + tracks * TRACK;
    let plots_from = truth_from + truths * TRUTH;
    let mut out = message.get(..HEADER)?.to_vec();
    let stays = |at: usize| keeps.truth.get(at).copied().unwrap_or(false);
    let place = |at: usize| (0..at).filter(|at| stays(*at)).count() as i32;
    let unknown = f32::NAN.to_le_bytes();
    let mut numbers = Vec::new();
    for at in 0..tracks {
        let record = message.get(HEADER + at * TRACK..HEADER + (at + 1) * TRACK)?;
        let truth = usize::try_from(i32::from_le_bytes(octets(record, 8)?)).ok();
        let truth = truth.filter(|at| stays(*at));
        if keeps.tracks || truth.is_some() {
            let from = out.len();
            out.extend(record);
            out[from + 8..from + 12].copy_from_slice(&truth.map_or(-1, place).to_le_bytes());
            out[from + 92..from + 96].copy_from_slice(&unknown);
            if !keeps.tracks {
                // Alerts and clearances are a controller's.
                [120, 121, 124].into_iter().for_each(|at| out[from + at] = 0);
                out[from + 125] &= 7;
            }
            numbers.push(u16::from_le_bytes(octets(record, 0)?));
        }
    }
    for at in (0..truths).filter(|at| stays(*at)) {
        out.extend(message.get(truth_from + at * TRUTH..truth_from + (at + 1) * TRUTH)?);
    }
    for at in (0..plots).filter(|_| keeps.plots) {
        let from = out.len();
        out.extend(message.get(plots_from + at * PLOT..plots_from + (at + 1) * PLOT)?);
        out[from + 4..from + 8].copy_from_slice(&(-1_i32).to_le_bytes());
        out[from + 44..from + 48].copy_from_slice(&unknown);
    }
    let mut from = plots_from + plots * PLOT;
    let mut left = 0_u32;
    for _ in 0..trails {
        let number = u16::from_le_bytes(octets(message, from)?);
        let to = from + 4 + 8 * usize::from(u16::from_le_bytes(octets(message, from + 2)?));
        let trail = message.get(from..to)?;
        if numbers.contains(&number) {
            out.extend(trail);
            left += 1;
        }
        from = to;
    }
    let counts = [
        numbers.len(),
        (0..truths).filter(|at| stays(*at)).count(),
        if keeps.plots { plots } else { 0 },
    ];
    for (at, count) in [24, 28, 32].into_iter().zip(counts) {
        out[at..at + 4].copy_from_slice(&(count as u32).to_le_bytes());
    }
    out[36..40].copy_from_slice(&left.to_le_bytes());
    Some(out)
}

/// Number and time of the scan of a message; none if it is none.
pub(super) fn number_and_time(message: &[u8]) -> Option<(u64, SimTime)> {
    let scan = octets(message, 8).map(u64::from_le_bytes)?;
    Some((scan, SimTime(octets(message, 16).map(i64::from_le_bytes)?)))
}

/// The entities of a message of [`encode`].
pub(super) fn entities(message: &[u8]) -> Vec<Entity> {
    let count = |at| octets(message, at).map_or(0, u32::from_le_bytes) as usize;
    let from = HEADER + count(24) * TRACK;
    (0..count(28))
        .map_while(|i| entity(message.get(from + i * TRUTH..from + (i + 1) * TRUTH)?))
        .collect()
}

fn entity(record: &[u8]) -> Option<Entity> {
    let words = |from: usize, to: usize| {
        let text = String::from_utf8_lossy(record.get(from..to)?).into_owned();
        Some(text.trim_end_matches('\0').to_owned())
    };
    let double = |at| octets(record, at).map(f64::from_le_bytes);
    let single = |at| octets(record, at).map(|o| f64::from(f32::from_le_bytes(o)));
    Some(Entity {
        key: octets(record, 0).map(u64::from_le_bytes)?,
        callsign: words(8, 20)?,
        designator: words(20, 28)?,
        position_m: [double(32)?, double(40)?, single(68)?],
        velocity_mps: [single(48)?, single(52)?],
        heading_rad: single(56)?,
        aircraft: octets(record, 28).map(u32::from_le_bytes)? & 1 == 1,
        length_m: single(60)?,
    })
}

fn octets<const N: usize>(from: &[u8], at: usize) -> Option<[u8; N]> {
    from.get(at..at + N)?.try_into().ok()
}

fn track(out: &mut Vec<u8>, t: &TrackMessage, truth_index: i32, error_m: f64) {
    out.extend(t.number.to_le_bytes());
    out.push(t.track_type as u8);
    out.push(t.status as u8);
    out.extend((u16::from(t.first) | u16::from(t.manoeuvre) << 1).to_le_bytes());
    out.push(t.movement.map_or(0, |m| m as u8 + 1));
    out.push(t.wake.map_or(0, |w| w.word().as_bytes()[0]));
    out.extend(truth_index.to_le_bytes());
    text(out, if t.callsign.is_empty() { &t.assumed } else { &t.callsign }, 12);
    text(out, &t.type_designator, 8);
    text(out, &t.runway_stand, 24);
    f64s(out, t.position_m.coords.as_slice());
    f32s(out, &t.velocity_mps);
    f32s(out, &t.cov_m2);
    f32s(out, &[error_m, 0.0, t.heading_rad, t.altitude_m.unwrap_or(f64::NAN), 0.0]);
}

/// Emitter category of I021/020 by a label; 0 without one.
fn emitter(t: &TrackMessage) -> u8 {
    let vehicle = t.track_type == TrackType::Vehicle || t.movement == Some(MovementKind::Vehicle);
    match t.wake {
        _ if t.callsign.is_empty() => 0,
        _ if vehicle && t.type_designator == "FIRE" => 20,
        _ if vehicle => 21,
        Some(WakeCategory::Light) => 1,
        Some(WakeCategory::Medium) => 3,
        Some(WakeCategory::Heavy | WakeCategory::Super) => 5,
        None => 0,
    }
}

fn track_more(out: &mut Vec<u8>, t: &TrackMessage, (age_s, kinds): (f64, u8), note: Note) {
    let share = |p: Option<f64>| p.map_or(255, |p| (254.0 * p.clamp(0.0, 1.0)) as u8);
    out.extend(t.address.unwrap_or(0).to_le_bytes());
    f32s(out, &[age_s]);
    let assumed = t.callsign.is_empty() && !t.assumed.is_empty();
    let coasted = t.lag.is_some_and(|l| l.coasted);
    let bits = u8::from(assumed) | u8::from(t.unresolved) << 1 | u8::from(coasted) << 2;
    let bits = bits | u8::from(note.derived) << 3;
    out.extend([note.doing, note.alert, emitter(t), kinds, note.cleared, bits]);
    out.extend([share(t.label_p), share(t.existence_p)]);
    match &t.lag {
        Some(lag) => {
            f32s(out, lag.position_m.coords.as_slice());
            f32s(out, &lag.cov_m2);
        }
        None => f32s(out, &[f64::NAN; 5]),
    }
    out.extend([0; 4]);
}

fn truth(out: &mut Vec<u8>, t: &TruthMessage) {
    out.extend(entity_key(t.id).to_le_bytes());
    text(out, &t.callsign, 12);
    text(out, &t.type_designator, 8);
    out.extend((u32::from(t.aircraft) | u32::from(t.ours) << 1).to_le_bytes());
    f64s(out, &t.position_m.coords.as_slice()[..2]);
    f32s(out, &t.velocity_mps[..2]);
    f32s(out, &[t.heading_rad, t.size_m[0], t.size_m[1], t.position_m[2]]);
    out.extend(t.track.map_or(-1, |(number, _)| i32::from(number)).to_le_bytes());
    out.extend([0; 4]);
}

fn plot(out: &mut Vec<u8>, p: &PlotMessage, truth_index: i32, age_s: f64) {
    out.extend(p.sensor.to_le_bytes());
    let kind = p.kind.place();
    out.push(kind.and_then(|place| u8::try_from(place).ok()).unwrap_or(255));
    out.push(u8::from(!p.identity.is_empty()));
    out.extend(truth_index.to_le_bytes());
    f64s(out, p.position_m.coords.as_slice());
    f32s(out, &p.cov_m2);
    f32s(out, &[p.scnr_db.unwrap_or(f64::NAN), age_s, plot_error_m(p).unwrap_or(f64::NAN)]);
    out.extend(p.track.map_or(-1, i32::from).to_le_bytes());
    out.extend([0; 4]);
}

/// Distance of a plot from the truth at the plot's own time, m.
#[must_use]
pub fn plot_error_m(p: &PlotMessage) -> Option<f64> {
    p.truth_m.map(|t| libm::hypot(t[0] - p.position_m[0], t[1] - p.position_m[1]))
}

/// Words of what stands in a track as a number, in the order of the numbers; no movement is 0, the first 1.
#[must_use]
pub fn words() -> serde_json::Value {
    json!({
        "types": TrackType::words(), "statuses": TrackStatus::words(), "movements": MovementKind::words(),
        "doing": DOING, "cleared": CLEARED,
    })
}

fn f64s(out: &mut Vec<u8>, values: &[f64]) {
    values.iter().for_each(|value| out.extend((value + 0.0).to_le_bytes())); // a database has no −0
}

/// Figures for drawing: seven digits are enough.
fn f32s(out: &mut Vec<u8>, values: &[f64]) {
    values.iter().for_each(|value| out.extend(((value + 0.0) as f32).to_le_bytes()));
}

/// `text` cut to `width` octets at a character boundary, filled with zeros.
fn text(out: &mut Vec<u8>, text: &str, width: usize) {
    let mut end = text.len().min(width);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    out.extend(&text.as_bytes()[..end]);
    out.extend(std::iter::repeat_n(0, width - end));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_stands_at_the_place_of_its_number() {
        assert!(TrackType::ALL.iter().enumerate().all(|(n, value)| *value as usize == n));
        assert!(TrackStatus::ALL.iter().enumerate().all(|(n, value)| *value as usize == n));
        assert!(MovementKind::ALL.iter().enumerate().all(|(n, value)| *value as usize == n));
        assert_eq!(words()["statuses"][2], "coasting");
    }

    #[test]
    fn the_octets_of_a_track_are_where_the_layout_has_them() {
        let mut report = crate::viewer_logger::tests::scan(1);
        let unsaid = encode(&report);
        let track = &mut report.tracks[0];
        (track.address, track.existence_p, track.unresolved) = (Some(0x4b_1234), Some(0.5), true);
        let said = encode(&report);
        let of = |frame: &[u8], at: usize| frame[HEADER + at];
        assert_eq!(said[HEADER + 112..HEADER + 116], 0x4b_1234_u32.to_le_bytes());
        assert_eq!((of(&unsaid, 127), of(&said, 127)), (255, 127));
        assert_eq!((of(&unsaid, 125) & 2, of(&said, 125) & 2), (0, 2));
        let differ = |at: &usize| unsaid[*at] != said[*at];
        let differ: Vec<usize> = (0..said.len()).filter(differ).map(|at| at - HEADER).collect();
        assert_eq!(differ, [112, 113, 114, 125, 127], "nothing else");
    }

    #[test]
    fn what_is_noted_of_a_track_is_in_its_octets_and_an_emitter_by_its_label() {
        let mut report = crate::viewer_logger::tests::scan(1);
        let note = Note { doing: 6, derived: true, alert: 2, cleared: 4 };
        let more = |report: &ScanReport| {
            let octets = encode_noted(report, &[(4, note), (9, Note::default())].into());
            <[u8; 6]>::try_from(&octets[HEADER + 120..HEADER + 126]).expect("six")
        };
        assert_eq!(more(&report), [6, 2, 3, 1, 4, 8], "an A320 of wake M, crossing, by CRO");
        assert_eq!(encode(&report)[HEADER + 120..HEADER + 126], [0, 0, 3, 1, 0, 0]);
        let track = &mut report.tracks[0];
        (track.track_type, track.type_designator) = (TrackType::Vehicle, "FIRE".into());
        assert_eq!(more(&report)[2], 20);
        report.tracks[0].type_designator = "TUG".into();
        assert_eq!(more(&report)[2], 21);
        report.tracks[0].callsign.clear();
        assert_eq!(more(&report)[2], 0);
        // Who sits aboard somebody sees who he is, but neither alerts nor clearances.
        let octets = encode_noted(&report, &[(4, note)].into());
        for (tracks, wanted) in [(true, [6, 2, 4, 8]), (false, [0, 0, 0, 0])] {
            let keeps = Keeps { tracks, plots: false, truth: vec![true] };
            let seen = reduced(&octets, &keeps).expect("a message");
            assert_eq!([120, 121, 124, 125].map(|at| seen[HEADER + at]), wanted);
        }
    }

    #[test]
    fn a_text_longer_than_its_field_is_cut_between_characters() {
        let mut out = Vec::new();
        text(&mut out, "abcdefgé", 8);
        assert_eq!(out, b"abcdefg\0");
        let mut out = Vec::new();
        text(&mut out, "", 3);
        assert_eq!(out, [0; 3]);
    }
}
