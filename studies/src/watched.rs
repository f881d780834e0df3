//! Traffic of a core as sensors see it, tracks as the safety net takes them, and what it told.

use models::control::alert::{Alert, Change};
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::control::scoring::Told;
use models::control::situation::{Target, TargetClass};
use models::flight_list::MovementKind;
use models::frames::Point2;
use models::plot::Callsign;
use models::sensors::{TargetState, Truth};
use models::time::SimTime;
use models::track::SystemTrack;
use models::traffic::core::Core;
use models::traffic::exact::{Watch, targets as exact_targets};
use models::truth::TruthState;
use scenarios::Scene;
use std::collections::BTreeMap;

/// States of a second, frame by frame, as sensors look at them: of the movers of a core.
#[derive(Debug)]
pub struct Frames<'a> {
    scene: &'a Scene,
    first: usize,
    /// By mover: its states with their times.
    states: Vec<Vec<(SimTime, TruthState)>>,
    /// Whose transponders are silent.
    silent: Vec<bool>,
}

impl<'a> Frames<'a> {
    /// Of a scene's traffic that behaves, whose movers are entities from `first` on.
    #[must_use]
    pub fn of(scene: &'a Scene, first: usize) -> Self {
        let count = scene.traffic.entities.len().saturating_sub(first);
        Self { scene, first, states: vec![Vec::new(); count], silent: vec![false; count] }
    }

    /// Takes the states of a frame.
    pub fn take(&mut self, core: &Core, now: SimTime) {
        for (mover, states) in self.states.iter_mut().enumerate() {
            states.extend(core.state(mover).map(|s| (now, s)));
            self.silent[mover] = !core.answers(mover);
        }
    }

    /// Forgets all but the last state of each, after a scan.
    pub fn clear(&mut self) {
        for states in &mut self.states {
            states.drain(..states.len().saturating_sub(1));
        }
    }
}

impl Truth for Frames<'_> {
    fn len(&self) -> usize {
        self.states.len()
    }
    fn key(&self, index: usize) -> u64 {
        (self.first + index) as u64
    }
    fn class(&self, index: usize) -> &models::sensors::TargetClass {
        &self.scene.traffic.entities[self.first + index].class
    }
    fn callsign(&self, index: usize) -> Callsign {
        self.scene.traffic.entities[self.first + index].callsign
    }
    fn address(&self, index: usize) -> Option<u32> {
        self.scene.traffic.entities[self.first + index].address
    }
    fn answers(&self, index: usize, _: SimTime) -> bool {
        !self.silent[index]
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (at, state) = self.states[index].iter().rev().find(|(at, _)| *at <= time)?;
        let ahead_s = time.since_s(*at);
        (ahead_s <= 0.1).then_some(TargetState {
            position_m: state.position_m + state.velocity_mps * ahead_s,
            velocity_mps: state.velocity_mps,
            heading_rad: state.heading_rad,
        })
    }
}

/// A track as the safety net takes it.
#[must_use]
pub fn target(scene: &Scene, track: &SystemTrack) -> Target {
    let callsign = track.callsign();
    let entry = callsign.and_then(|c| scene.flight_list.entries.iter().find(|e| e.callsign == c));
    let movement = track.label.as_ref().map(|l| l.movement).or(entry.map(|e| e.movement));
    let class = match movement {
        Some(MovementKind::Vehicle) => TargetClass::Vehicle,
        Some(_) => TargetClass::Aircraft,
        None => TargetClass::Unknown,
    };
    let row = entry.and_then(|e| scene.traffic.types.get(&e.type_designator));
    Target {
        number: track.number,
        callsign,
        class,
        arriving: movement == Some(MovementKind::Arrival),
        length_m: row.map_or(0.0, |r| r.class.length_m),
        position_m: track.position_m,
        velocity_mps: track.velocity_mps,
        altitude_m: track.altitude_m,
        last_plot: track.last_plot,
        first: track.first,
    }
}

/// Alerts by number, as they were told.
#[derive(Clone, Debug, Default)]
pub struct Book(pub BTreeMap<u32, Told>);

impl Book {
    /// Writes down what was told at a scan.
    pub fn enter(&mut self, now: SimTime, change: Change, alert: &Alert) {
        let subjects = alert.subjects().split(' ').map(str::to_owned).collect();
        let told = self.0.entry(alert.id).or_insert_with(|| Told {
            kind: alert.condition.kind.word(),
            subjects: Vec::new(),
            on_s: now.s(),
            end_s: f64::INFINITY,
            nearest_m: None,
        });
        told.subjects = subjects;
        if change == Change::Ended {
            told.end_s = now.s();
        }
    }

    /// Looks how near the subjects of what stands really are to each other.
    pub fn look(&mut self, core: &Core, now: SimTime) {
        let exact = exact_targets(core, now);
        let place = |t: &'_ Target| Some((t.callsign?, t.position_m));
        let places: Vec<(Callsign, Point2<f64>)> = exact.iter().filter_map(place).collect();
        let places: Vec<(&str, Point2<f64>)> =
            places.iter().map(|(c, p)| (c.as_str(), *p)).collect();
        self.0.values_mut().for_each(|told| told.look(now.s(), &places));
    }

    /// All of them.
    #[must_use]
    pub fn list(&self) -> Vec<Told> {
        self.0.values().cloned().collect()
    }
}

/// A safety net over tracks of a scene, as the federate has it, but for the scans that confirm.
#[must_use]
pub fn net_on_tracks(scene: &Scene, confirm_scans: u32) -> Watch {
    let control = &scene.control;
    let parameters = Parameters {
        confirm_scans,
        strip_margin_m: control.strip_margin_m,
        bar_margin_m: control.bar_margin_m,
        ..Parameters::on_tracks()
    };
    Watch::new(layout(scene), parameters, control.stop_bars).in_visibility(scene.visibility_m())
}

/// The airport as the safety net knows it.
#[must_use]
pub fn layout(scene: &Scene) -> Layout {
    let layout = Layout::of(&scene.airport.layout);
    match &scene.traffic.behaving {
        Some(behaving) => layout.with_network(&behaving.network),
        None => layout,
    }
}

/// Flights of a core that have moved: landed, or left their stand.
#[must_use]
pub fn movements(core: &Core) -> u32 {
    let moved = (0..core.flights().len()).filter(|f| {
        let m = core.measures(*f);
        m.aldt_s.is_some() || m.aobt_s.is_some()
    });
    moved.count() as u32
}
