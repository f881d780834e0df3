//! Runs with visitors, frame by frame: what they change and what they must not.

use super::Smdfm;
use super::received_truth::{ReceivedTruth, key_of};
use crate::admin_station::summary::RunSummary;
use crate::exchange::stamp::{self, Stamped};
use crate::external_world::ExternalWorld;
use crate::runtime::conductor::ClosedRun;
use crate::runtime::digest::Digest;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut, Octets};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{FinalReport, Notice, RunConfig};
use crate::traffic_generator::TrafficGenerator;
use geodesy::Enu;
use models::sensors::Truth as _;
use models::time::SimTime;
use pdu::enumerations::{AirAppearance, DeadReckoningAlgorithm};
use pdu::exercise::{Arrival, Transponder};
use pdu::records::{EntityId, EntityType, Marking, Vector32};
use pdu::{DisTime, EncodeBody, EntityState, Envelope};
use scenarios::Scene;
use std::sync::Arc;

const GUEST: EntityId = EntityId { site: 900, application: 9, entity: 1 };

fn scene() -> Arc<Scene> {
    Arc::new(scenarios::load(&scenarios::locate("zurich")).expect("the scene"))
}

/// A visitor's PDU, sent `delay_s` before it arrives at simulated time `at_s`, in real time.
pub(super) fn stamped(scene: &Scene, at_s: f64, delay_s: f64, body: &impl EncodeBody) -> Stamped {
    let time = FrameTime::of(&scene.run);
    // The wall clock of another day than the scene's.
    let utc_ns = 1_700_000_000_000_000_000 + (at_s * 1e9) as i64;
    let sent = DisTime::absolute((utc_ns - (delay_s * 1e9) as i64) as u64);
    let mut octets = Vec::new();
    Envelope::new(1, sent).append(body, &mut octets).expect("fits");
    let time_ns = time.start_utc_ns + (at_s * 1e9) as i64;
    let arrival = Arrival { time_ns, utc_ns, rate: 1.0 };
    Stamped { arrival, from: "10.0.0.1:3000".parse().expect("an address"), octets }
}

/// A car (or, in the air domain, an aircraft) at a place of the airport.
pub(super) fn guest(
    scene: &Scene,
    position_m: [f64; 3],
    velocity_mps: [f64; 3],
    air: bool,
) -> EntityState<'static> {
    let frame = &scene.airport.frame;
    let [east_m, north_m, up_m] = position_m;
    EntityState {
        entity_id: GUEST,
        entity_type: match air {
            true => EntityType::new(1, 2, 71, 87, 32, 1, 0),
            false => EntityType::new(1, 1, 225, 81, 0, 0, 0),
        },
        location: frame.to_ecef(Enu { east_m, north_m, up_m }).into(),
        linear_velocity_mps: Vector32::from_f64(frame.vector_to_ecef(velocity_mps)),
        dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
        marking: Marking::new("GUEST1").expect("short"),
        ..EntityState::default()
    }
}

/// Drives generator, world and SMDFM for `seconds`; `visits` gives a frame's stamped PDUs.
fn run(
    scene: &Arc<Scene>,
    seconds: u64,
    mut visits: impl FnMut(u64) -> Vec<Stamped>,
) -> RunSummary {
    let time = FrameTime::of(&scene.run);
    let reports = |frame: u64| {
        let envelope = Envelope::new(1, time.stamp(frame));
        let stamped = visits(frame);
        let encode = |s: &Stamped| stamp::encode(scene.run.site, &envelope, s).expect("fits");
        stamped.iter().map(encode).collect()
    };
    drive(scene, seconds, reports, |_| {})
}

/// Drives generator, world and SMDFM for `seconds`; `visits` gives the reports of the member `visitors` in a frame, `each`
/// gets what the SMDFM published.
pub(super) fn drive(
    scene: &Arc<Scene>,
    seconds: u64,
    visits: impl FnMut(u64) -> Vec<Vec<u8>>,
    mut each: impl FnMut(FrameOut),
) -> RunSummary {
    drive_told(scene, seconds, |_| Vec::new(), visits, |_, out| out.into_iter().for_each(&mut each))
}

/// The same; `told` gives notices of `visitors` in the frame of their effect, and `each` gets a frame's PDUs of the traffic and what
/// the SMDFM published with it.
pub(super) fn drive_told(
    scene: &Arc<Scene>,
    seconds: u64,
    told: impl Fn(u64) -> Vec<(u64, Notice)>,
    mut visits: impl FnMut(u64) -> Vec<Vec<u8>>,
    mut each: impl FnMut((u64, &[Octets]), Option<FrameOut>),
) -> RunSummary {
    let mut smdfm = Smdfm::new(Arc::clone(scene), 1);
    let mut producers: [(&str, Box<dyn Federate>, Digest); 2] = [
        (
            "traffic-generator",
            Box::new(TrafficGenerator::new(Arc::clone(scene), 1, 1, 1)),
            Digest::default(),
        ),
        ("external-world", Box::new(ExternalWorld::new(Arc::clone(scene), 1)), Digest::default()),
    ];
    let period = smdfm.period();
    let config = RunConfig {
        run: 1,
        seed: scene.run.seed,
        producers: Vec::new(),
        generators: 1,
        last_frame: seconds * period,
        ..RunConfig::default()
    };
    let mut inputs = FrameInputs::default();
    smdfm.configure(&config, &mut FrameOut::default()).expect("configured");
    for frame in 0..=config.last_frame {
        let mut traffic = Vec::new();
        for (name, producer, digest) in &mut producers {
            let mut out = FrameOut::default();
            let heard = FrameInputs { notices: told(frame), ..FrameInputs::default() };
            match frame {
                0 => producer.configure(&config, &mut out).expect("configured"),
                _ => producer.step(frame, &heard, &mut out),
            }
            if *name == "traffic-generator" {
                traffic.clone_from(&out.pdus);
            }
            out.pdus.iter().for_each(|octets| digest.add(frame, octets));
            inputs.pdus.extend(out.pdus.into_iter().map(|octets| (frame, octets)));
            inputs.notices.extend(out.notices.into_iter().map(|notice| (frame, notice)));
        }
        inputs.pdus.extend(visits(frame).into_iter().map(|octets| (frame, octets.into())));
        if frame > 0 && frame.is_multiple_of(period) {
            let mut out = FrameOut::default();
            smdfm.step(frame, &std::mem::take(&mut inputs), &mut out);
            each((frame, &traffic), Some(out));
        } else {
            each((frame, &traffic), None);
        }
    }
    let mut reports = vec![FinalReport { name: "smdfm".into(), ..FinalReport::default() }];
    smdfm.finish(&mut reports[0]);
    for (name, _, digest) in producers {
        let digests = vec![("pdus".into(), digest.0)];
        reports.push(FinalReport { name: name.into(), digests, ..FinalReport::default() });
    }
    let closed = ClosedRun { run: 1, frame: config.last_frame, reports, ..ClosedRun::default() };
    RunSummary::of(&closed, "zurich", scene.run.frame.0)
}

/// Once a second from second 5 on: a car at a place, with a transponder.
fn car_at(scene: &Scene, frame: u64, place_m: [f64; 2], north_mps: f64) -> Vec<Stamped> {
    let at_s = frame as f64 * 0.05;
    if frame < 100 || !frame.is_multiple_of(20) {
        return Vec::new();
    }
    let north_m = place_m[1] + north_mps * at_s;
    let state = guest(scene, [place_m[0], north_m, 0.0], [0.0, north_mps, 0.0], true);
    let transponder = Transponder { on: true, address: Some(0xabc_def), ..Transponder::default() };
    vec![stamped(scene, at_s, 0.0, &state), stamped(scene, at_s, 0.0, &transponder.iff(GUEST))]
}

#[test]
fn a_visitor_that_touches_nothing_leaves_the_digest_and_equal_stamps_give_equal_foreign() {
    let scene = scene();
    let alone = run(&scene, 60, |_| Vec::new());
    assert!(!alone.external && alone.foreign.is_none() && alone.visitors.is_none());
    assert!(!alone.line().contains("foreign"), "{}", alone.line());
    // Far from all traffic, to several sides of the airport; one of them in view of every sensor.
    for place_m in [[-900.0, -2600.0], [1500.0, 1500.0], [-2500.0, 900.0]] {
        let visited = run(&scene, 60, |frame| car_at(&scene, frame, place_m, 5.0));
        assert_eq!(visited.digest, alone.digest, "{place_m:?}");
        assert_eq!(visited.track_digest, alone.track_digest, "{place_m:?}");
        assert!(visited.external && visited.foreign.is_some());
        assert_eq!((visited.visitors, visited.touched), (Some(1), Some(0)), "{place_m:?}");
        let again = run(&scene, 60, |frame| car_at(&scene, frame, place_m, 5.0));
        assert_eq!((again.digest, again.foreign), (visited.digest, visited.foreign));
    }
}

#[test]
fn a_visitor_on_top_of_ours_touches_it() {
    let scene = scene();
    let alone = run(&scene, 40, |_| Vec::new());
    // One visitor on each of ours that is on the ground, moving with it.
    let doubles = |frame: u64| -> Vec<Stamped> {
        let at = SimTime::from_s(frame as f64 * 0.05);
        if frame < 100 || !frame.is_multiple_of(10) {
            return Vec::new();
        }
        let truth = |e: &scenarios::Entity| e.trajectory.as_ref()?.at(at);
        let states = scene.traffic.entities.iter().filter_map(|e| Some((e.number, truth(e)?)));
        states
            .filter(|(_, state)| state.position_m.z.abs() < 15.0)
            .map(|(number, state)| {
                let [x, y, z] = state.position_m.into();
                let double = EntityState {
                    entity_id: EntityId::new(900, 9, number),
                    ..guest(&scene, [x + 1.0, y, z], state.velocity_mps.into(), true)
                };
                stamped(&scene, at.s(), 0.0, &double)
            })
            .collect()
    };
    let visited = run(&scene, 40, doubles);
    assert_ne!(visited.digest, alone.digest);
    assert!(visited.touched >= Some(1), "{}", visited.line());
}

/// Where the guest is at the end of a scan, as the sensors see it: east, m.
fn seen(truth: &ReceivedTruth, at_s: f64) -> Option<f64> {
    let to = SimTime::from_s(at_s);
    let view = truth.view(to.plus_s(-1.0), to);
    Some(view.at(view.index_of(key_of(GUEST))?, to)?.position_m.x)
}

#[test]
fn delay_is_made_up_for_and_who_is_frozen_stands() {
    let scene = scene();
    let mut truth = ReceivedTruth::new(Arc::clone(&scene), 1);
    for n in 0..40 {
        // 70 m/s, a state every half second, 150 to 250 ms on the way.
        let (sent_s, delay_s) = (f64::from(n) * 0.5, 0.15 + 0.1 * f64::from(n * 7 % 10) / 9.0);
        let state = guest(&scene, [-1000.0 + 70.0 * sent_s, 0.0, 0.0], [70.0, 0.0, 0.0], true);
        assert!(truth.take_visitor(&stamped(&scene, sent_s + delay_s, delay_s, &state)));
        if n > 0 {
            let now_s = sent_s + delay_s;
            let off_m = seen(&truth, now_s).expect("there") - (-1000.0 + 70.0 * now_s);
            assert!(off_m.abs() < 0.5, "{now_s} s: {off_m} m");
        }
    }
    let frozen = EntityState {
        appearance: AirAppearance(0).with_frozen(true).0,
        ..guest(&scene, [400.0, 0.0, 0.0], [20.0, 0.0, 0.0], true)
    };
    assert!(truth.take_visitor(&stamped(&scene, 20.0, 0.0, &frozen)));
    for at_s in [20.0, 25.0, 30.0] {
        assert!((seen(&truth, at_s).expect("there") - 400.0).abs() < 0.1, "{at_s} s");
    }
    assert_eq!(seen(&truth, 34.0), None, "silent for more than 12 s");
}

#[test]
fn what_an_airport_cannot_believe_is_refused() {
    let scene = scene();
    let mut truth = ReceivedTruth::new(Arc::clone(&scene), 1);
    let take = |truth: &mut ReceivedTruth, state: EntityState<'_>, at_s: f64| {
        truth.take_visitor(&stamped(&scene, at_s, 0.0, &state))
    };
    let sound = || guest(&scene, [0.0, 0.0, 0.0], [0.0; 3], false);
    assert!(!take(&mut truth, guest(&scene, [2e5, 0.0, 0.0], [0.0; 3], false), 1.0), "far");
    assert!(!take(&mut truth, guest(&scene, [0.0; 3], [2000.0, 0.0, 0.0], false), 1.0), "fast");
    let ours = &scene.traffic.entities[0];
    let id = EntityId::new(scene.run.site, ours.application, ours.number);
    assert!(!take(&mut truth, EntityState { entity_id: id, ..sound() }, 1.0), "of the scene");
    assert!(take(&mut truth, sound(), 1.0));
    assert!(!take(&mut truth, guest(&scene, [9e3, 0.0, 0.0], [0.0; 3], false), 1.5), "a jump");
    assert_eq!(truth.refused().len(), 4, "{:?}", truth.refused());
    for n in 0..5000_u16 {
        let id = EntityId::new(901, 1, n);
        take(&mut truth, EntityState { entity_id: id, ..sound() }, 2.0);
    }
    assert_eq!(truth.visitors_ever(), 4096);
}

/// Address, call sign or identifier of one of ours on somebody else's vehicle: refused with a word, and ours are as they were.
#[test]
fn who_calls_himself_as_one_of_ours_hides_nobody() {
    let scene = scene();
    let ours = scene.traffic.entities.iter().find(|e| e.address.is_some()).expect("addressed");
    let (name, address) = (ours.callsign.as_str().to_owned(), ours.address);
    let alias = EntityState {
        marking: Marking::new(&name).expect("short"),
        ..guest(&scene, [-900.0, -2600.0, 0.0], [0.0, 5.0, 0.0], true)
    };
    let transponder = |address, name: &str| Transponder {
        on: true,
        address,
        identification: Some(Transponder::identification_of(name)),
        ..Transponder::default()
    };
    let mut truth = ReceivedTruth::new(Arc::clone(&scene), 1);
    assert!(truth.take_visitor(&stamped(&scene, 20.0, 0.0, &alias)), "the entity itself is let in");
    for (address, name) in [(address, "OTHER"), (Some(0xabc_def), &name[..])] {
        let said = transponder(address, name).iff(GUEST);
        assert!(!truth.take_visitor(&stamped(&scene, 20.1, 0.0, &said)), "{address:?} {name}");
    }
    let stolen = EntityState {
        entity_id: EntityId::new(scene.run.site, ours.application, ours.number),
        ..alias.clone()
    };
    assert!(!truth.take_visitor(&stamped(&scene, 20.2, 0.0, &stolen)));
    let to = SimTime::from_s(20.5);
    let view = truth.view(to.plus_s(-1.0), to);
    let index = view.index_of(key_of(GUEST)).expect("seen");
    assert_eq!((view.callsign(index).as_str(), view.address(index)), ("", None));
    let words: Vec<String> = truth.refused().into_iter().map(|(word, _)| word).collect();
    for word in ["Mode S address", "call sign of an entity", "marking", "identifier"] {
        assert!(words.iter().any(|w| w.contains(word)), "{word}: {words:?}");
    }
    // Through a run: as if he were not there.
    let alone = run(&scene, 40, |_| Vec::new());
    let visited = run(&scene, 40, |frame| {
        let at_s = frame as f64 * 0.05;
        if frame < 100 || !frame.is_multiple_of(20) {
            return Vec::new();
        }
        let said = transponder(address, &name).iff(GUEST);
        vec![stamped(&scene, at_s, 0.0, &alias), stamped(&scene, at_s, 0.0, &said)]
    });
    assert_eq!((visited.digest, visited.track_digest), (alone.digest, alone.track_digest));
    assert_eq!((visited.visitors, visited.touched), (Some(1), Some(0)));
}

/// A visitor that switches its transponder off is asked in vain, as one of ours is: multilateration and ADS-B heard it on.
#[test]
fn a_visitor_whose_transponder_is_off_does_not_answer() {
    let scene = scene();
    let state = guest(&scene, [-900.0, -2600.0, 0.0], [0.0, 5.0, 0.0], true);
    let mut truth = ReceivedTruth::new(Arc::clone(&scene), 1);
    assert!(truth.take_visitor(&stamped(&scene, 20.0, 0.0, &state)));
    let mut answers = Vec::new();
    for (at_s, said) in [(20.1, None), (20.2, Some(true)), (20.3, Some(false)), (20.4, Some(true))]
    {
        if let Some(on) = said {
            let iff = Transponder { on, address: Some(0xabc_def), ..Transponder::default() };
            assert!(truth.take_visitor(&stamped(&scene, at_s, 0.0, &iff.iff(GUEST))));
        }
        let to = SimTime::from_s(20.5);
        let view = truth.view(to.plus_s(-1.0), to);
        let index = view.index_of(key_of(GUEST)).expect("seen");
        answers.push(view.answers(index, to));
    }
    assert_eq!(answers, [true, true, false, true]);
}
