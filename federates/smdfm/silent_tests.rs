//! A transponder that fails, from the generator's PDUs to what the sensors may hear.

use super::received_truth::ReceivedTruth;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::messages::RunConfig;
use crate::traffic_generator::TrafficGenerator;
use models::sensors::Truth as _;
use models::time::SimTime;
use pdu::Body;
use pdu::exercise::Transponder;
use std::path::Path;
use std::sync::Arc;

fn load(rest: &str) -> Arc<scenarios::Scene> {
    let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = 7\nduration_s = 600\n[airport]\nlayout = \"{airports}/LZIB.apt.dat\"\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 6\ndepartures_per_h = 8\n{rest}"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("silent.toml");
    Arc::new(scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn sensors_hear_no_answer_while_a_transponder_is_silent_whether_it_has_an_address_or_not() {
    let plain = load("");
    let behaving = plain.traffic.behaving.as_ref().expect("behaves");
    let parked = |f: &usize| behaving.flights[*f].time_s > 60.0;
    let mut departs = (0..behaving.flights.len())
        .filter(|f| behaving.flights[*f].direction == models::traffic::core::Direction::Departure);
    let flight = departs.find(parked).expect("a parked departure");
    let name = &behaving.flights[flight].callsign;
    let failure = format!(
        "[[failure]]\nkind = \"transponder\"\ncallsign = \"{name}\"\nat_s = 3\nstay_s = 4\n"
    );
    for with_address in [true, false] {
        let mut scene = load(&failure);
        let entity = behaving.first_entity + flight;
        if !with_address {
            Arc::make_mut(&mut scene).traffic.entities[entity].address = None;
        }
        let mut generator = TrafficGenerator::new(Arc::clone(&scene), 1, 1, 1);
        let config =
            RunConfig { run: 1, seed: 7, generators: 1, last_frame: 200, ..RunConfig::default() };
        // The first states are sent before the first frame.
        let mut first = FrameOut::default();
        generator.configure(&config, &mut first).expect("configured");
        let mut truth = ReceivedTruth::new(Arc::clone(&scene), 1);
        let mut said = Vec::new();
        for frame in 0..=200 {
            let mut out = std::mem::take(&mut first);
            if frame > 0 {
                generator.step(frame, &FrameInputs::default(), &mut out);
            }
            for octets in &out.pdus {
                let Some(Ok(received)) = pdu::pdus(octets).next() else { panic!("a PDU") };
                match received.body() {
                    Body::EntityState(state) => truth.take(frame, frame, state),
                    Body::Iff(iff) => {
                        truth.take_answer(frame, frame, iff);
                        let own = iff.basic.emitting_entity.entity
                            == scene.traffic.entities[entity].number;
                        let on = Transponder::of(iff).expect("a transponder").on;
                        said.extend(own.then_some((frame, on)));
                    }
                    _ => {}
                }
            }
        }
        let changes: Vec<(u64, bool)> =
            said.iter().copied().filter(|(frame, on)| !on || *frame > 1).collect();
        assert_eq!(changes, [(60, false), (140, true)], "with an address: {with_address}");
        let view = truth.view(SimTime::ZERO, SimTime::from_s(10.0));
        let own = scene.traffic.entities[entity].number;
        let index = (0..view.len())
            .find(|i| view.callsign(*i).as_str() == name.as_str())
            .unwrap_or_else(|| {
                let names: Vec<_> = (0..view.len()).map(|i| view.callsign(i)).collect();
                panic!("{name} is not in {names:?}; refused {:?}", truth.refused())
            });
        assert_eq!(view.key(index) & 0xffff, u64::from(own));
        for tenth in 1..=99_u32 {
            let at = SimTime::from_s(0.1 * f64::from(tenth));
            let silent = (30..70).contains(&tenth);
            assert_eq!(view.answers(index, at), !silent, "at {tenth}/10 s");
            for other in (0..view.len()).filter(|o| *o != index) {
                assert!(view.answers(other, at), "another one");
            }
        }
    }
}
