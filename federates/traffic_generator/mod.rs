//! The traffic generator: ground truth of its share of the movers, as Entity State PDUs.
//!
//! A PDU is due when the receivers' dead reckoning would be off by more than the scene's thresholds,
//! when a mover starts or stops, and at the heartbeat. A parked aircraft costs one PDU a minute.
//!
//! Flights that behave read each other, so every generator steps the whole core of them, which gives the
//! same bits everywhere, and publishes its share.

pub mod command;
pub mod driven_state;
pub mod traffic_state;

use crate::exchange::control_records::{Light, Lights, Teller};
use crate::exchange::entity_state::{deactivated, frozen, state_pdu, transponder, world_pose};
use crate::exchange::repeated::Repeated;
use crate::exchange::{driven, handover};
use crate::federation::{closes_loop, loop_frames, on_tracks};
use crate::runtime::bus::Class;
use crate::runtime::codec::encode;
use crate::runtime::federate::{Aside, Federate, FrameInputs, FrameOut, Octets, Publication};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{
    ClearanceNotice, FAULT, FinalReport, Frame, Kind, MEASURE, Notice, RunConfig, SeatEvent,
    SeatInput, SeatMessage, StandNotice, WantNotice,
};
use models::control::clearance::ClearanceKind;
use models::frames::Point2;
use models::time::SimTime;
use models::traffic::check::Rules;
use models::traffic::core::{self, Core, Direction, Flight, Order, Remark};
use models::traffic::measured::measured;
use pdu::exercise::Transponder;
use pdu::publishing::{Publisher, Thresholds};
use pdu::{EncodeBody, EntityState, Envelope};
use scenarios::{Entity, Scene};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The federate's logic.
pub struct TrafficGenerator {
    scene: Arc<Scene>,
    exercise: u8,
    time: FrameTime,
    share: u32,
    of: u32,
    movers: Vec<Mover>,
    /// Flights that behave, and the frame that their core has executed.
    core: Option<(Core, Frame)>,
    told: Told,
    /// What people who drive did, told by the generator of share 1; number of the run.
    drivers: Repeated<SeatMessage>,
    /// Asks that have no answer yet, by number, and how many of the core's answers were told.
    asked: BTreeMap<u64, (Frame, SeatInput)>,
    answered: usize,
    /// Who was given, in its place, by entity.
    given: BTreeMap<usize, Entity>,
    run: u32,
    /// Segments of the taxiways that were told to be lit.
    lit: BTreeSet<u32>,
    /// The frame executed last.
    executed: Frame,
}

/// Clearances of the core that control was told.
#[derive(Default)]
struct Told {
    given: usize,
    open: Vec<usize>,
    /// What flights of this share wait for.
    wants: Vec<WantNotice>,
    /// The stand of each flight, where it is another than planned.
    stands: BTreeMap<usize, usize>,
}

/// One mover of this share.
struct Mover {
    /// Index into the scene's entities.
    entity: usize,
    /// What receivers believe, from the last PDU; none before the first and after the last.
    sent: Option<Sent>,
    /// Nothing about it changes before that, and nothing is due.
    rests_until: SimTime,
}

struct Sent {
    still: bool,
    publisher: Publisher,
    state: EntityState<'static>,
    /// What its transponder said last, and when; none before that.
    answered: Option<(Transponder, i64)>,
}

/// Scans for which it is told again what a driver did: ten times a second.
const TOLD_FOR: u64 = 10;

/// Longest time between two IFF PDUs of a moving target, ns; parked ones: their heartbeat.
const IFF_EVERY_NS: i64 = 10_000_000_000;

impl TrafficGenerator {
    /// Share `share` (from 1) of `of` of the scene's traffic.
    #[must_use]
    pub fn new(scene: Arc<Scene>, exercise: u8, share: u32, of: u32) -> Self {
        let time = FrameTime::of(&scene.run);
        Self {
            scene,
            exercise,
            time,
            share,
            of,
            movers: Vec::new(),
            core: None,
            told: Told::default(),
            drivers: Repeated::told_for(TOLD_FOR),
            asked: BTreeMap::new(),
            answered: 0,
            given: BTreeMap::new(),
            run: 0,
            lit: BTreeSet::new(),
            executed: 0,
        }
    }

    /// Takes in what controllers at seats cleared, before the frame of its effect.
    fn take_given(&mut self, inputs: &FrameInputs) {
        let Some((core, _)) = &mut self.core else { return };
        for (effect, notice) in &inputs.notices {
            if let Notice::Seat(input) = notice {
                let said = effect.saturating_sub(driven::delay_frames(&self.scene));
                if handover::tell(&self.scene, core, said, input) {
                    self.asked.insert(input.number, (said, input.clone()));
                    continue;
                }
                let Some(notice) = driven::notice(&self.scene, core, said, input) else { continue };
                core.notice(notice);
                if self.share == 1 {
                    let event = SeatEvent::Input {
                        frame: said,
                        input: input.clone(),
                        refused: String::new(),
                    };
                    let number = self.drivers.next();
                    self.drivers.tell(SeatMessage { run: self.run, number, event });
                }
                continue;
            }
            let Notice::Given(given) = notice else { continue };
            core.notice(core::Notice {
                effect_frame: *effect as i64,
                source: given.seat.clone(),
                sequence: given.number,
                flight: given.flight as usize,
                order: Order::told(given.kind, given.by_person),
            });
        }
    }

    /// Takes what the core answered to asks for a handover: who is in his place from this frame on.
    fn take_answers(&mut self) {
        let Some((core, _)) = &self.core else { return };
        let first = self.scene.traffic.behaving.as_ref().map_or(0, |b| b.first_entity);
        for outcome in &core.handovers()[self.answered..] {
            if let Ok(flight) = outcome.what
                && let Some(given) = core.given(flight)
                && handover::is_place(&self.scene, first + flight)
            {
                let place = &self.scene.traffic.entities[first + flight];
                self.given.insert(first + flight, handover::entity(&self.scene, place, given));
            }
            let Some((frame, input)) = self.asked.remove(&outcome.sequence) else { continue };
            if self.share == 1 {
                let refused = outcome.what.as_ref().err().cloned().unwrap_or_default();
                let event = SeatEvent::Input { frame, input, refused };
                let number = self.drivers.next();
                self.drivers.tell(SeatMessage { run: self.run, number, event });
            }
        }
        self.answered = core.handovers().len();
    }

    /// Tells controllers at seats what the flights of this share wait for, once a scan, where it changed.
    fn tell_wants(&mut self, frame: Frame, out: &mut FrameOut) {
        let scan = frame.is_multiple_of(u64::from(self.scene.run.frames_per_scan));
        if !scan || !closes_loop(&self.scene) {
            return;
        }
        let (Some((core, _)), Some(behaving)) = (&self.core, &self.scene.traffic.behaving) else {
            return;
        };
        let own = |flight: u32| {
            scenarios::in_share(behaving.first_entity + flight as usize, self.share, self.of)
        };
        let want = |(w, runway): (models::control::actors::Wanted, usize), asks: bool| WantNotice {
            flight: w.flight,
            kind: w.kind,
            group: w.group,
            runway: behaving.network.runways[runway].names[0].clone(),
            asks,
        };
        let asked = core.wanted().into_iter().map(|w| want(w, true));
        let could = core.could_be_cleared().into_iter().map(|w| want(w, false));
        let wants = asked.chain(could).filter(|w| own(w.flight)).collect();
        if wants != self.told.wants {
            self.told.wants.clone_from(&wants);
            out.notices.push(Notice::Wants { share: self.share, wants });
        }
    }

    /// Tells control which flights of this share have got another stand than planned, once a scan.
    fn tell_stands(&mut self, frame: Frame, out: &mut FrameOut) {
        let scan = frame.is_multiple_of(u64::from(self.scene.run.frames_per_scan));
        if !scan || !on_tracks(&self.scene) {
            return;
        }
        let (Some((core, _)), Some(behaving)) = (&self.core, &self.scene.traffic.behaving) else {
            return;
        };
        let mut changed = Vec::new();
        let drives = |f: &Flight| f.direction == Direction::Vehicle;
        for (flight, planned) in core.flights().iter().enumerate().filter(|f| !drives(f.1)) {
            let stand = core.stand(flight);
            let known = self.told.stands.get(&flight).copied().unwrap_or(planned.stand);
            if stand == known {
                continue;
            }
            self.told.stands.insert(flight, stand);
            if scenarios::in_share(behaving.first_entity + flight, self.share, self.of) {
                let at_m = core.stand_m(stand);
                let callsign = planned.callsign.clone();
                changed.push(StandNotice { callsign, stand_m: Point2::new(at_m.x, at_m.y) });
            }
        }
        if !changed.is_empty() {
            out.notices.push(Notice::Stands(changed));
        }
    }

    /// Tells pages what people drive: ten times a second while somebody does, once a second else.
    fn tell_driven(&self, frame: Frame, out: &mut FrameOut) {
        let share_1 = self.share == 1 && driven::any(&self.scene);
        let Some((core, _)) = self.core.as_ref().filter(|_| share_1) else { return };
        let Some(behaving) = &self.scene.traffic.behaving else { return };
        let frames = |s: f64| (s / self.scene.run.frame.s()).round().max(1.0) as u64;
        let whole = frame.is_multiple_of(frames(1.0));
        if whole || frame.is_multiple_of(frames(0.1)) && driven_state::moves(core, behaving) {
            out.publish.push(Publication {
                key: "obs/driven".into(),
                class: Class::Lossy,
                body: driven_state::json(core, behaving, self.time.time(frame).s(), whole)
                    .into_bytes(),
                retained: Some("obs/driven/last".into()),
            });
        }
    }

    fn frame(&mut self, frame: Frame, out: &mut FrameOut) {
        let now = self.time.time(frame);
        self.executed = frame;
        if let Some((core, executed)) = &mut self.core {
            // Whoever joins late simulates itself to the present.
            while *executed < frame {
                *executed += 1;
                core.step(*executed as i64);
            }
        }
        self.take_answers();
        self.tell_clearances(out);
        self.tell_wants(frame, out);
        self.tell_stands(frame, out);
        let first = self.scene.traffic.behaving.as_ref().map_or(usize::MAX, |b| b.first_entity);
        let run = &self.scene.run;
        let envelope = Envelope::new(self.exercise, self.time.stamp(frame));
        for mover in &mut self.movers {
            if now < mover.rests_until {
                continue;
            }
            let entity =
                self.given.get(&mover.entity).unwrap_or(&self.scene.traffic.entities[mover.entity]);
            let behaves = || self.core.as_ref()?.0.state(mover.entity.checked_sub(first)?);
            let truth = match &entity.trajectory {
                Some(trajectory) => trajectory.at(now),
                None => behaves(),
            };
            let Some(truth) = truth else {
                // Gone: one last PDU says so.
                if let Some(sent) = mover.sent.take() {
                    send(&envelope, &deactivated(sent.state), out);
                }
                continue;
            };
            let still = truth.is_still();
            // New, or it starts or stops: the heartbeat changes too.
            let (mut publisher, last, answered) = match mover.sent.take() {
                Some(sent) if sent.still == still => {
                    (sent.publisher, Some(sent.state), sent.answered)
                }
                sent => (publisher(run, still), None, sent.and_then(|s| s.answered)),
            };
            let (location, orientation) = world_pose(&truth, &self.scene.airport.frame);
            let state = match last {
                Some(last) if publisher.due(now.0, location, orientation).is_none() => last,
                _ => {
                    let state = state_pdu(entity, &truth, still, &self.scene);
                    publisher.sent(now.0, &state);
                    send(&envelope, &state, out);
                    state
                }
            };
            let on = self.core.as_ref().is_none_or(|(core, _)| {
                mover.entity.checked_sub(first).is_none_or(|flight| core.answers(flight))
            });
            // Who has no address says so when he fails, and when he answers again.
            let failed = answered.as_ref().is_some_and(|(said, _)| !said.on);
            let says =
                transponder(entity, &truth, on && !failed).map(|says| Transponder { on, ..says });
            let answered = says.map(|says| {
                let every_ns = if still { run.heartbeat_parked.0 } else { IFF_EVERY_NS };
                match answered {
                    Some((said, at)) if said == says && now.0 - at < every_ns => (said, at),
                    _ => {
                        send(&envelope, &says.iff(state.entity_id), out);
                        (says, now.0)
                    }
                }
            });
            // What stands costs nothing until it moves or its heartbeat is due.
            if let Some(trajectory) = entity.trajectory.as_ref().filter(|_| still)
                && let Some(heartbeat_ns) = publisher.heartbeat_at_ns()
            {
                let answer_ns = answered
                    .as_ref()
                    .map_or(i64::MAX, |(_, at)| at.saturating_add(run.heartbeat_parked.0));
                let due = SimTime(heartbeat_ns.min(answer_ns));
                mover.rests_until = trajectory.rests_until(now).min(due);
            }
            mover.sent = Some(Sent { still, publisher, state, answered });
        }
    }
}

impl TrafficGenerator {
    /// Tells control what was cleared, and what ended, of the flights of this share.
    fn tell_clearances(&mut self, out: &mut FrameOut) {
        if !on_tracks(&self.scene) {
            return;
        }
        let (Some((core, _)), Some(behaving)) = (&self.core, &self.scene.traffic.behaving) else {
            return;
        };
        let ns = |s: f64| SimTime::from_s(s).0;
        let all = core.clearances();
        let notice = |index: usize| {
            let c = &all[index];
            let kind = ClearanceKind::of(c.kind)?;
            let way = core.cleared_way_m(c.flight);
            Some(ClearanceNotice {
                callsign: core.flights()[c.flight].callsign.clone(),
                kind,
                runway: c.runway.clone(),
                from_ns: ns(c.from_s),
                until_ns: None,
                place_m: c.place_m,
                way_m: if kind == ClearanceKind::Taxi { way.to_vec() } else { Vec::new() },
            })
        };
        let mut notices = Vec::new();
        for index in self.told.given..all.len() {
            if scenarios::in_share(behaving.first_entity + all[index].flight, self.share, self.of) {
                notices.extend(notice(index));
                self.told.open.push(index);
            }
        }
        self.told.given = all.len();
        self.told.open.retain(|index| {
            let Some(until_s) = all[*index].until_s else { return true };
            let until_ns = Some(ns(until_s));
            let ended = |notice| ClearanceNotice { until_ns, way_m: Vec::new(), ..notice };
            notices.extend(notice(*index).map(ended));
            false
        });
        if !notices.is_empty() {
            out.notices.push(Notice::Clearances(notices));
        }
    }
}

fn publisher(run: &scenarios::Run, still: bool) -> Publisher {
    Publisher::new(Thresholds {
        distance_m: run.dead_reckoning.position_m,
        angle_rad: run.dead_reckoning.orientation_rad,
        heartbeat_ns: match still {
            true => run.heartbeat_parked.0,
            false => run.heartbeat_moving.0,
        },
        jitter: 0.1,
    })
}

fn send(envelope: &Envelope, body: &impl EncodeBody, out: &mut FrameOut) {
    let mut octets = Vec::with_capacity(144);
    envelope
        .append(body, &mut octets)
        .expect("a state without parameters and an IFF of two layers fit");
    out.pdus.push(octets.into());
}

impl Federate for TrafficGenerator {
    fn kind(&self) -> Kind {
        Kind::TrafficGenerator
    }

    fn consumes(&self) -> bool {
        closes_loop(&self.scene) || driven::hears(&self.scene)
    }

    fn reads_pdus(&self) -> bool {
        false
    }

    fn ahead_of(&self, producer: &str) -> Option<Frame> {
        // What control says in a frame takes effect a scan later at the earliest, what a driver does a little later; nobody
        // else is read.
        let scene = &self.scene;
        match producer {
            _ if !self.consumes() => Some(0),
            name if name == Kind::Control.name() => closes_loop(scene).then(|| loop_frames(scene)),
            name if name == Kind::Visitors.name() => {
                driven::hears(scene).then(|| driven::delay_frames(scene))
            }
            _ => None,
        }
    }

    fn in_loop(&self) -> bool {
        self.consumes()
    }

    fn configure(&mut self, config: &RunConfig, out: &mut FrameOut) -> Result<(), String> {
        if config.generators != self.of {
            return Err(format!(
                "this traffic generator has share {}/{}, but the federation has {} generators: give --share I/{}",
                self.share, self.of, config.generators, config.generators
            ));
        }
        let entities = &self.scene.traffic.entities;
        let behaving = self.scene.traffic.behaving.as_ref();
        self.core =
            behaving.and_then(|b| b.told_core(&self.scene.run, config.seed)).map(|core| (core, 0));
        let first = behaving.filter(|_| self.core.is_some()).map_or(usize::MAX, |b| b.first_entity);
        let own = |entity: &usize| scenarios::in_share(*entity, self.share, self.of);
        let own: Vec<usize> = (0..entities.len()).filter(own).collect();
        if own.iter().any(|e| *e < first && entities[*e].trajectory.is_none()) {
            return Err("the scene was loaded without this share of its truth".into());
        }
        self.told = Told::default();
        self.asked.clear();
        self.lit.clear();
        self.given.clear();
        self.answered = 0;
        (self.drivers, self.run) = (Repeated::told_for(TOLD_FOR), config.run);
        self.movers = own
            .into_iter()
            .map(|entity| Mover { entity, sent: None, rests_until: SimTime(i64::MIN) })
            .collect();
        self.frame(0, out);
        Ok(())
    }

    fn step(&mut self, frame: Frame, inputs: &FrameInputs, out: &mut FrameOut) {
        self.take_given(inputs);
        self.frame(frame, out);
        self.tell_driven(frame, out);
        let per_scan = (self.scene.run.scan().0 / self.scene.run.frame.0).max(1) as u64;
        // One of all says what all of them know.
        if let Some((core, _)) =
            self.core.as_ref().filter(|_| self.share == 1 && frame.is_multiple_of(per_scan))
        {
            if let Some(told) = self.drivers.scan() {
                out.publish.push(Publication {
                    key: "obs/inputs".into(),
                    class: Class::Lossy,
                    body: encode(&told),
                    retained: None,
                });
            }
            if let Some(lamps) = core.lamps() {
                let lit: BTreeSet<u32> =
                    core.greens().into_iter().flat_map(|g| g.segments).collect();
                let dark = |s: &u32| lamps.segments()[*s as usize].dark;
                let changed = self.lit.symmetric_difference(&lit).filter(|s| **s <= 0xffff);
                let changed: Vec<(u16, Light)> = changed
                    .map(|s| {
                        (*s as u16, Light { lit: lit.contains(s) && !dark(s), failed: dark(s) })
                    })
                    .collect();
                let teller = Teller { exercise: self.exercise, site: self.scene.run.site };
                let at = self.time.stamp(frame);
                out.aside.extend(teller.lights(Lights::Taxiways, at, &changed));
                self.lit = lit;
            }
            out.publish.push(Publication {
                key: "obs/traffic".into(),
                class: Class::Lossy,
                body: traffic_state::json(core, self.time.time(frame).s()).into_bytes(),
                retained: Some("obs/traffic/last".into()),
            });
            if frame.is_multiple_of(MEASURED_SCANS * u64::from(self.scene.run.frames_per_scan)) {
                let measures = figures(core).map(|(name, x)| (name, x.into())).collect();
                out.publish.push(Publication {
                    key: "obs/measures".into(),
                    class: Class::Lossy,
                    body: serde_json::Value::Object(measures).to_string().into_bytes(),
                    retained: None,
                });
            }
        }
    }

    fn state(&self) -> u64 {
        self.core.as_ref().map_or(0, |(core, _)| core.digest())
    }

    fn aside(&mut self, what: Aside) -> Vec<Octets> {
        let now = self.time.time(self.executed);
        let first = self.scene.traffic.behaving.as_ref().map_or(usize::MAX, |b| b.first_entity);
        let envelope = Envelope::new(self.exercise, self.time.stamp(self.executed));
        let mut out = FrameOut::default();
        for mover in self.movers.iter().filter(|mover| mover.sent.is_some()) {
            let entity =
                self.given.get(&mover.entity).unwrap_or(&self.scene.traffic.entities[mover.entity]);
            let truth = match &entity.trajectory {
                Some(trajectory) => trajectory.at(now),
                None => self
                    .core
                    .as_ref()
                    .and_then(|(core, _)| core.state(mover.entity.checked_sub(first)?)),
            };
            let Some(truth) = truth else { continue };
            let state = state_pdu(entity, &truth, truth.is_still(), &self.scene);
            let state = match what {
                Aside::Stands => frozen(state, false),
                Aside::GoesOn => state,
                Aside::Over => frozen(state, true),
            };
            send(&envelope, &state, &mut out);
        }
        out.pdus
    }

    fn finish(&mut self, report: &mut FinalReport) {
        report.values.push(("entities".into(), self.movers.len() as f64));
        if let Some((core, _)) = &self.core {
            // Equal in every generator: the halves of the digest, because values are numbers.
            let digest = core.digest();
            report.values.push(("core_digest_high".into(), (digest >> 32) as f64));
            report.values.push(("core_digest_low".into(), (digest & 0xffff_ffff) as f64));
            if self.share == 1 {
                let (served, failed) = served_and_failed(core, self.time.time(self.executed).s());
                report.values.push(("movements_served".into(), served as f64));
                report.values.push(("movements_failed".into(), failed as f64));
                report
                    .values
                    .extend(figures(core).map(|(name, x)| (format!("{MEASURE}{name}"), x)));
                report.values.extend(deadlocks(core.unexpected_deadlocks(), core.remarks()));
            }
        }
    }
}

/// Scans between two tellings of the measures of the traffic.
const MEASURED_SCANS: u64 = 10;

/// Measures of the traffic so far (`models::traffic::measured`), named with their units.
fn figures(core: &Core) -> impl Iterator<Item = (String, f64)> {
    measured(core).into_iter().map(|m| {
        let unit = if m.unit.is_empty() { String::new() } else { format!(", {}", m.unit) };
        (format!("{}{unit}", m.name), m.value)
    })
}

/// Rings of movers that wait for each other, under a policy that rules them out, as faults of the run: what is said of each, and
/// since when it is known, s.
fn deadlocks(unexpected: u64, remarks: &[Remark]) -> Vec<(String, f64)> {
    let rings = remarks.iter().filter(|r| unexpected > 0 && r.text.starts_with("deadlock"));
    rings.map(|r| (format!("{FAULT}{}", r.text), r.time_s)).collect()
}

/// Flights that took off or are in block, and those that did neither within the time that the check of traffic gives them.
fn served_and_failed(core: &Core, now_s: f64) -> (usize, usize) {
    let latest_s = now_s - Rules::default().serve_s;
    let served = core.measures_of_served();
    let due = core.flights().iter().enumerate().filter(|(m, f)| {
        let flies = f.direction != Direction::Vehicle && !core.is_free_place(*m);
        flies && f.time_s <= latest_s
    });
    let done = |m: usize| {
        let measures = core.measures(m);
        measures.aibt_s.is_some() || measures.atot_s.is_some()
    };
    (served, due.filter(|(m, _)| !done(*m)).count())
}

#[cfg(test)]
mod stand_tests;
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_of_waiting_are_told_as_faults_unless_the_policy_allows_them() {
        let remark = |time_s: f64, text: &str| Remark { time_s, text: text.to_owned() };
        let all = [remark(3.0, "stand A 1 is not free"), remark(61.5, "deadlock: A, B wait")];
        assert_eq!(deadlocks(1, &all), [("fault deadlock: A, B wait".to_owned(), 61.5)]);
        assert!(deadlocks(0, &all).is_empty(), "the free policy has them");
    }

    #[test]
    fn what_is_told_aside_leaves_every_frame_as_it_is() {
        use crate::exchange::entity_state::{Reckoned, is_deactivated, is_frozen};
        use pdu::Body;
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let scene = Arc::new(scene);
        let run = |told: bool| {
            let mut generator = TrafficGenerator::new(Arc::clone(&scene), 1, 1, 1);
            let config = RunConfig { generators: 1, seed: 1, ..RunConfig::default() };
            let (mut sent, mut aside, mut out) = (Vec::new(), Vec::new(), FrameOut::default());
            generator.configure(&config, &mut out).expect("it goes");
            for frame in 1..2_000 {
                generator.step(frame, &FrameInputs::default(), &mut out);
                sent.push(std::mem::take(&mut out.pdus));
                if told && frame % 300 == 0 {
                    let stands = generator.aside(Aside::Stands);
                    assert_eq!(generator.aside(Aside::Stands), stands, "the same again");
                    aside.push((frame, stands, generator.aside(Aside::GoesOn)));
                }
            }
            let over = generator.aside(Aside::Over);
            (sent, aside, over)
        };
        let ((sent, aside, over), (alone, ..)) = (run(true), run(false));
        assert!(sent == alone, "the same PDUs in the same frames");
        let states = |pdus: &[Octets]| -> Vec<EntityState<'static>> {
            let state = |octets: &Octets| {
                let received = pdu::pdus(octets).next().expect("one").expect("sound");
                let Body::EntityState(state) = received.body() else { panic!("a state") };
                state.clone().into_owned()
            };
            pdus.iter().map(state).collect()
        };
        let mut moving = 0;
        for (_, stands, goes_on) in &aside {
            assert_eq!(stands.len(), goes_on.len());
            for (stands, goes_on) in states(stands).iter().zip(states(goes_on)) {
                assert!(is_frozen(stands) && !is_deactivated(stands) && !is_frozen(&goes_on));
                let frame = &scene.airport.frame;
                let (a, b) = (Reckoned::new(stands), Reckoned::new(&goes_on));
                assert_eq!(a.at(9.0, frame).position_m, b.at(0.0, frame).position_m, "it stands");
                moving += usize::from(b.at(0.0, frame).velocity_mps.norm() > 1.0);
            }
        }
        assert!(moving > 5, "{moving}");
        assert!(
            !over.is_empty() && states(&over).iter().all(|s| is_deactivated(s) && is_frozen(s))
        );
    }

    #[test]
    fn what_stands_costs_nothing_and_is_sent_as_if_it_were_looked_at_every_frame() {
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let scene = Arc::new(scene);
        let run = |rests: bool| {
            let mut generator = TrafficGenerator::new(Arc::clone(&scene), 1, 1, 1);
            let config = RunConfig { generators: 1, seed: 1, ..RunConfig::default() };
            let (mut sent, mut skipped) = (Vec::new(), 0);
            let mut out = FrameOut::default();
            generator.configure(&config, &mut out).expect("it goes");
            for frame in 1..4_000 {
                let now = generator.time.time(frame);
                if !rests {
                    generator.movers.iter_mut().for_each(|m| m.rests_until = SimTime(i64::MIN));
                }
                skipped += generator.movers.iter().filter(|m| now < m.rests_until).count();
                generator.step(frame, &FrameInputs::default(), &mut out);
                sent.push(std::mem::take(&mut out.pdus));
            }
            (sent, skipped)
        };
        let ((sent, skipped), (all, none)) = (run(true), run(false));
        assert!(sent == all, "the same PDUs in the same frames");
        assert!(skipped > 2_000 && none == 0, "{skipped} {none}");
    }
}
