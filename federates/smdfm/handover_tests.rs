//! An aircraft changes hands while everybody looks: in each frame it is there once, where it was, and its track goes on.

use super::received_truth::ReceivedTruth;
use super::visitor_tests::drive_told;
use crate::exchange::handover::{SEAT, When, Words};
use crate::exchange::stamp::{self, Stamped};
use crate::runtime::codec::decode;
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{Notice, ScanReport, SeatAction, SeatInput, SeatOrder};
use geodesy::Enu;
use models::frames::{Point3, Vector2, Vector3};
use models::sensors::Truth as _;
use models::time::SimTime;
use models::traffic::core::{Direction, Phase};
use pdu::enumerations::DeadReckoningAlgorithm;
use pdu::exercise::{Arrival, Transponder};
use pdu::records::{EntityId, EntityType, Marking, Vector32};
use pdu::{Body, DisTime, EncodeBody, EntityState, Envelope};
use scenarios::Scene;
use std::collections::BTreeSet;
use std::sync::Arc;

const THEIRS: EntityId = EntityId { site: 300, application: 300, entity: 7 };

fn scene(airport: &str, departures_per_h: f64) -> Arc<Scene> {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = 5\nduration_s = 3600\n[airport]\nlayout = \"airports/{airport}.apt.dat\"\n[[traffic]]\nkind = \"generated\"\n\
         profile = \"even\"\narrivals_per_h = 4\ndepartures_per_h = {departures_per_h}\n[[traffic]]\nkind = \"handover\"\n[[sensor]]\nkind = \"adsb\"\nname = \"a\"\n"
    );
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/handover.toml");
    Arc::new(scenarios::load_text(std::path::Path::new(path), &text).expect("a scene"))
}

/// What another simulator says of its aircraft at a time, as `visitors` lets it in.
fn said(scene: &Scene, name: &str, at: (Point3<f64>, Vector3<f64>), at_s: f64) -> Vec<Vec<u8>> {
    let time = FrameTime::of(&scene.run);
    let frame = &scene.airport.frame;
    let (p, v) = at;
    let state = EntityState {
        entity_id: THEIRS,
        entity_type: EntityType::new(1, 2, 71, 87, 32, 1, 0),
        location: frame.to_ecef(Enu { east_m: p.x, north_m: p.y, up_m: p.z }).into(),
        linear_velocity_mps: Vector32::from_f64(frame.vector_to_ecef([v.x, v.y, v.z])),
        dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
        marking: Marking::new(name).expect("short"),
        ..EntityState::default()
    };
    let transponder = Transponder {
        on: true,
        address: Some(ADDRESS),
        identification: Some(Transponder::identification_of(name)),
        ..Transponder::default()
    };
    let utc_ns = 1_700_000_000_000_000_000 + (at_s * 1e9) as i64;
    let arrival = Arrival { time_ns: time.start_utc_ns + (at_s * 1e9) as i64, utc_ns, rate: 1.0 };
    let stamped = |body: &dyn Fn(&mut Vec<u8>)| {
        let mut octets = Vec::new();
        body(&mut octets);
        let from = "10.0.0.1:3000".parse().expect("an address");
        let frame = (at_s / scene.run.frame.s()).round() as u64;
        let envelope = Envelope::new(1, time.stamp(frame));
        stamp::encode(scene.run.site, &envelope, &Stamped { arrival, from, octets }).expect("fits")
    };
    let envelope = Envelope::new(1, DisTime::absolute(utc_ns as u64));
    fn put(envelope: &Envelope, body: &impl EncodeBody, octets: &mut Vec<u8>) {
        envelope.append(body, octets).expect("fits");
    }
    vec![
        stamped(&|octets| put(&envelope, &state, octets)),
        stamped(&|octets| put(&envelope, &transponder.iff(THEIRS), octets)),
    ]
}

const ADDRESS: u32 = 0x4b_1234;

/// Whether it is ours, where it is, how it moves.
type Held = (bool, Point3<f64>, Vector3<f64>);

/// What was seen of a call sign.
#[derive(Default)]
struct Seen {
    /// By frame: who had it (ours), where it was and how it moved.
    frames: Vec<(u64, Vec<Held>)>,
    tracks: BTreeSet<u16>,
    /// Frames of scans after the first with a track in which it had none.
    untracked: Vec<u64>,
    addresses: BTreeSet<u32>,
}

/// Drives a scene with what another simulator tells of an aircraft in some frames, and asks in one of them.
fn watch(
    scene: &Arc<Scene>,
    name: &str,
    seconds: u64,
    theirs: impl Fn(u64) -> Option<(Point3<f64>, Vector3<f64>)>,
    ask: &(u64, SeatAction),
) -> Seen {
    let mut seen = Seen::default();
    let mut truth = ReceivedTruth::new(Arc::clone(scene), 1);
    let dt = scene.run.frame.s();
    let told = |frame: u64| -> Vec<(u64, Notice)> {
        let (effect, action) = ask;
        let order = SeatOrder { seat: SEAT.into(), person: "test".into(), action: action.clone() };
        let input = SeatInput { number: 1, order };
        if frame == *effect { vec![(frame, Notice::Seat(input))] } else { Vec::new() }
    };
    let visits = |frame: u64| {
        theirs(frame).map_or_else(Vec::new, |at| said(scene, name, at, frame as f64 * dt))
    };
    drive_told(scene, seconds, told, visits, |(frame, pdus), out| {
        let own = pdus.iter().map(|o| o.to_vec());
        for octets in own.chain(visits(frame)) {
            for received in pdu::pdus(&octets) {
                match received.expect("sound").body() {
                    Body::EntityState(state) => truth.take(frame, frame, state),
                    Body::Iff(iff) => truth.take_answer(frame, frame, iff),
                    Body::EventReport(report) => {
                        let stamped = stamp::decode(report, scene.run.site).expect("stamped");
                        assert!(truth.take_visitor(&stamped));
                    }
                    _ => {}
                }
            }
        }
        let now = SimTime(frame as i64 * scene.run.frame.0);
        let view = truth.view(SimTime(now.0 - scene.run.frame.0), now);
        let mut there = Vec::new();
        for i in (0..view.len()).filter(|i| view.callsign(*i).as_str() == name) {
            if let Some(state) = view.at(i, now) {
                there.push((view.is_ours(i), state.position_m, state.velocity_mps));
                seen.addresses.extend(view.address(i));
            }
        }
        seen.frames.push((frame, there));
        truth.forget_before(now);
        let Some(out) = out else { return };
        let scan = out.publish.iter().find(|p| p.key == "tracks/1/scan").expect("published");
        let scan: ScanReport = decode(&scan.body).expect("sound");
        let rows: Vec<_> = scan.truth.iter().filter(|t| t.callsign == name).collect();
        match rows.first().and_then(|t| t.track) {
            Some((number, _)) => drop(seen.tracks.insert(number)),
            None if !seen.tracks.is_empty() && !rows.is_empty() => seen.untracked.push(frame),
            None => {}
        }
    });
    seen
}

/// It is there once in each of these frames, and goes from hand to hand as it flies: the jumps of place and velocity at the one change
/// of hands. Elsewhere they are those of dead reckoning.
fn goes_on(seen: &Seen, from: u64, to: u64, dt: f64) -> (f64, f64) {
    let (mut jump_m, mut jump_mps, mut changes): (f64, f64, usize) = (0.0, 0.0, 0);
    let mut last: Option<Held> = None;
    for (frame, there) in seen.frames.iter().filter(|(frame, _)| (from..to).contains(frame)) {
        assert_eq!(there.len(), 1, "one owner at {frame}: {there:?}");
        if let Some((ours, p, v)) = last {
            let (by_m, by_mps) = ((there[0].1 - p - v * dt).norm(), (there[0].2 - v).norm());
            assert!(by_m < 5.0 && by_mps < 3.0, "{by_m} m {by_mps} m/s at {frame}");
            if ours != there[0].0 {
                (jump_m, jump_mps, changes) = (by_m, by_mps, changes + 1);
            }
        }
        last = Some(there[0]);
    }
    assert_eq!(changes, 1);
    (jump_m, jump_mps)
}

#[test]
fn who_is_given_is_there_once_in_each_frame_and_keeps_his_track() {
    for airport in ["LZIB", "XSYN"] {
        let scene = scene(airport, 0.0);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let lands = behaving.flights.iter().find(|f| f.direction == Direction::Arrival);
        let (r, end) = lands.expect("an arrival").runway;
        let runway = &behaving.network.runways[r];
        let along = (runway.ends_m[1 - end] - runway.ends_m[end]).normalize();
        let aside = Vector2::new(along.y, -along.x);
        let dt = scene.run.frame.s();
        // Five miles out in second 20, 80 m beside the final and a little high, on a line of its own.
        let theirs = |frame: u64| {
            let t = frame as f64 * dt - 20.0;
            let velocity = along * 75.0 - aside * 1.5;
            let at = runway.ends_m[end] - along * (5.0 * 1852.0) + aside * 80.0 + velocity * t;
            (Point3::new(at.x, at.y, 520.0 - 4.0 * t), Vector3::new(velocity.x, velocity.y, -4.0))
        };
        let (p, v) = theirs(400);
        let milli = |v: Vector3<f64>| [v.x, v.y, v.z].map(|x| (1e3 * x).round() as i64);
        let words = Words {
            designator: "A320".into(),
            address: Some(ADDRESS),
            runway: None,
            stand: None,
            at_mm: milli(p.coords),
            velocity_mmps: milli(v),
            when: When::Run(20_000_000_000),
        };
        let give = SeatAction::Give { callsign: "BSK1".into(), state: words.to_string() };
        // The giver goes on for two seconds, as he does not know yet.
        let tells = |frame: u64| {
            (frame.is_multiple_of(10) && (100..444).contains(&frame)).then(|| theirs(frame))
        };
        let seen = watch(&scene, "BSK1", 60, tells, &(404, give));
        let ours_from = seen.frames.iter().find(|(_, there)| there.iter().any(|t| t.0));
        assert_eq!(ours_from.map(|f| f.0), Some(404), "{airport}");
        let (jump_m, jump_mps) = goes_on(&seen, 101, 1200, dt);
        println!("{airport}: jump {jump_m:.3} m {jump_mps:.3} m/s");
        assert!(jump_m < 0.5 && jump_mps < 0.5, "{airport}: {jump_m} m {jump_mps} m/s");
        assert_eq!(seen.addresses, BTreeSet::from([ADDRESS]));
        // One track throughout. In the scan of the change its last plots may be those of the giver, to whom it then belongs.
        assert_eq!(seen.tracks.len(), 1, "{airport}: {:?}", seen.tracks);
        let of_giver = seen.untracked.iter().filter(|frame| (404..=424).contains(*frame)).count();
        assert!(of_giver < 2 && seen.untracked.len() < 3, "{airport}: {:?}", seen.untracked);
    }
}

#[test]
fn who_is_let_go_is_there_once_in_each_frame() {
    let scene = scene("LZIB", 20.0);
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let dt = scene.run.frame.s();
    // The first to climb through 1200 ft.
    let mut core = behaving.told_core(&scene.run, scene.run.seed).expect("with truth");
    let (effect, flight, state) = (1..18_000_u64)
        .find_map(|frame| {
            core.step(frame as i64);
            let climbs = |f: &usize| core.phase(*f) == Phase::Rolling;
            let mut high = (0..core.flights().len()).filter(climbs).filter_map(|f| {
                let state = core.state(f)?;
                (state.position_m.z > 366.0).then_some((frame, f, state))
            });
            high.next()
        })
        .expect("somebody departs");
    let name = core.flights()[flight].callsign.clone();
    // The taker has followed it for two seconds before, and flies on straight.
    let theirs = |frame: u64| {
        let t = frame as f64 * dt - effect as f64 * dt;
        let (p, v) = (state.position_m, state.velocity_mps);
        (frame.is_multiple_of(10) && frame + 40 >= effect && frame < effect + 400)
            .then(|| (p + v * t, v))
    };
    let release = SeatAction::Release { callsign: name.clone() };
    let seen = watch(&scene, &name, effect / 20 + 15, theirs, &(effect, release));
    let (jump_m, jump_mps) = goes_on(&seen, effect - 60, effect + 200, dt);
    println!("{name}: jump {jump_m:.3} m {jump_mps:.3} m/s");
    assert!(jump_m < 0.5 && jump_mps < 0.5, "{jump_m} m {jump_mps} m/s");
    let last_ours = seen.frames.iter().rfind(|(_, there)| there.iter().any(|t| t.0));
    assert_eq!(last_ours.map(|f| f.0), Some(effect - 1));
}
