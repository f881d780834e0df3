//! Models of controllers who see tracks, around a core: what the member `control` clears in a run, without the run.

use crate::watched::{Frames, net_on_tracks, target};
use crate::zurich;
use models::control::actors::pilot::Habits;
use models::control::actors::sight::{Sight, Waiting};
use models::control::actors::{Actors, Wanted};
use models::control::alert::{Alert, Change};
use models::control::situation::Target;
use models::environment::Weather;
use models::fusion::Tracker;
use models::plot::Callsign;
use models::sensors::{PlotSink, ScanInterval, Sensor};
use models::time::SimTime;
use models::traffic::core::{Core, Notice, Order};
use models::traffic::exact::Watch;
use scenarios::Scene;
use std::fmt;

/// An airport whose controllers see tracks: the sensors of its scene, its tracker, its safety net and its seats.
pub struct Tower<'a> {
    scene: &'a Scene,
    seed: u64,
    sensors: Vec<Box<dyn Sensor>>,
    tracker: Tracker,
    frames: Frames<'a>,
    net: Watch,
    controllers: Controllers,
}

/// What was seen and told in a scan.
#[derive(Clone, Debug)]
pub struct Scanned {
    /// Its time.
    pub now: SimTime,
    /// The tracks as the safety net takes them, by number.
    pub targets: Vec<Target>,
    /// What the safety net told.
    pub told: Vec<(Change, Alert)>,
}

impl<'a> Tower<'a> {
    /// The tower of a scene with traffic that behaves, in a run with this seed.
    ///
    /// # Errors
    /// One sentence if nothing behaves in the scene, or a sensor cannot be made.
    pub fn new(scene: &'a Scene, seed: u64) -> Result<Self, String> {
        let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves in this scene")?;
        Ok(Self {
            scene,
            seed,
            sensors: zurich::sensors(scene)?,
            tracker: Tracker::new(scene.tracking_config()),
            frames: Frames::of(scene, behaving.first_entity),
            net: net_on_tracks(scene, scene.control.confirm_scans),
            controllers: Controllers::new(scene, seed),
        })
    }

    /// The safety net on its tracks.
    #[must_use]
    pub fn net(&self) -> &Watch {
        &self.net
    }

    /// The seats.
    #[must_use]
    pub fn controllers(&self) -> &Controllers {
        &self.controllers
    }

    /// After each step of the core: looks at it, and once a scan judges it and clears.
    pub fn frame(&mut self, core: &mut Core, frame: i64) -> Option<Scanned> {
        let run = &self.scene.run;
        let now = SimTime(frame * run.frame.0);
        self.frames.take(core, now);
        let per_scan = i64::from(run.frames_per_scan);
        if frame % per_scan != 0 {
            return None;
        }
        let from = SimTime(now.0 - per_scan * run.frame.0);
        let scan = (frame / per_scan) as u64;
        let interval = ScanInterval { run_seed: self.seed, scan, from, to: now };
        let notice = self.scene.weather.iter().rev().find(|notice| notice.time <= now);
        let weather = notice.map_or_else(Weather::default, |notice| notice.weather.clone());
        let mut sink = PlotSink::default();
        for sensor in &mut self.sensors {
            sensor.scan(&interval, &self.frames, &weather, &mut sink);
        }
        let tracks = self.tracker.scan(now, &sink.plots, &self.scene.flight_list);
        let mut targets: Vec<Target> = tracks.iter().map(|t| target(self.scene, t)).collect();
        targets.sort_by_key(|t| t.number);
        let told = self.net.scan_targets(core, now, &targets).to_vec();
        self.frames.clear();
        self.controllers.scan(core, frame, &self.net);
        Some(Scanned { now, targets, told })
    }
}

impl fmt::Debug for Tower<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tower").field("scene", &self.scene.name).finish_non_exhaustive()
    }
}

/// Every seat of an airport, and what its people see.
#[derive(Debug)]
pub struct Controllers {
    actors: Actors,
    sight: Sight,
    step_s: f64,
    /// What is said counts so many frames later at the earliest.
    ahead: i64,
    given: u64,
}

impl Controllers {
    /// Nobody has said anything in a run of a scene with this seed.
    #[must_use]
    pub fn new(scene: &Scene, seed: u64) -> Self {
        let step_s = scene.run.frame.s();
        Self {
            actors: Actors::new(Habits::default(), seed, step_s),
            sight: Sight::default(),
            step_s,
            ahead: i64::from(scene.run.frames_per_scan),
            given: 0,
        }
    }

    /// How many were cleared on their word, and for how long runways looked occupied to those who were kept back, s.
    #[must_use]
    pub fn cost(&self) -> (u64, u64) {
        self.sight.cost()
    }

    /// One scan, after the safety net has looked at its tracks: who waits and may go is told so.
    pub fn scan(&mut self, core: &mut Core, frame: i64, seen: &Watch) {
        let (layout, surveillance) = (seen.net().layout(), seen.net().surveillance());
        let waiting = |(wanted, runway): (Wanted, usize)| {
            let callsign = Callsign::new(&core.flights()[wanted.flight as usize].callsign);
            let runway = core.network().runways.get(runway)?;
            Some(Waiting {
                wanted,
                strip: seen.board().find(callsign).map(|i| i as u32),
                runway: layout.runway(&runway.names[0]).map(|r| r.0),
            })
        };
        let mut all: Vec<Waiting> = core.wanted().into_iter().filter_map(waiting).collect();
        all.sort_by_key(|w| w.wanted.flight);
        all.dedup_by_key(|w| w.wanted.flight);
        let now_s = frame as f64 * self.step_s;
        let may = self.sight.look(now_s, &all, layout, surveillance);
        let wanted: Vec<Wanted> = all.iter().map(|w| w.wanted).collect();
        for given in self.actors.scan_seen(now_s, &wanted, &may) {
            self.given += 1;
            core.notice(Notice {
                effect_frame: ((given.acts_s / self.step_s).ceil() as i64).max(frame + self.ahead),
                source: given.seat.name(),
                sequence: self.given,
                flight: given.flight as usize,
                order: Order::told(given.kind, false),
            });
        }
    }
}
