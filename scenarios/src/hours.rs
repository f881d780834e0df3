//! An hour of traffic without a run: the core alone, held against what traffic has to keep, as often as every frame.

use crate::run::Run;
use crate::schedule::Behaving;
use models::airport::Airport;
use models::control::clearance::ClearanceKind;
use models::draw::{DrawKey, Purpose, uniform};
use models::traffic::check::{Checker, Given, Row, Rules, Seen, TypeLimits, Who};
use models::traffic::core::{Core, Day, Flight, Notice, Order, Phase};

/// What is done and looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hour {
    /// Key of the draws.
    pub seed: u64,
    /// Frames from look to look.
    pub every: i64,
    /// After the end of the run, s.
    pub drain_s: f64,
    /// Share of the flights that stand still once for 20 to 180 s, some minutes after their time.
    pub stopping: f64,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Held {
    /// The core at the end.
    pub core: Core,
    /// The table of the checker.
    pub rows: Vec<Row>,
    /// When everybody was served, s; `None`: not everybody.
    pub served_s: Option<f64>,
    /// Frames that were executed.
    pub frames: i64,
}

impl Held {
    /// What was not kept, one line each with the first case.
    #[must_use]
    pub fn broken(&self) -> Vec<String> {
        let rows = self.rows.iter().filter(|r| !r.kept);
        rows.map(|r| format!("{} {}: {}", r.name, r.value, r.cases.join("; "))).collect()
    }
}

/// A flight as the checker knows it, in the weather of a run.
#[must_use]
pub fn who_of(f: &Flight, days: &[(f64, Day)]) -> Who {
    Who {
        callsign: f.callsign.clone(),
        size: f.size,
        limits: TypeLimits::new(f.taxi_mps.0, f.taxi_acc_mps2, f.take_off, f.landing.0)
            .in_weather(days),
        wake: Some(f.wake),
        direction: Some(f.direction),
        due_s: f.time_s,
    }
}

/// Steps the traffic of an airport for the run and [`Hour::drain_s`] more, or until everybody is served; `None` in a scene
/// loaded without truth. `step` executes a frame: [`Core::step`], and what the caller wants around it.
pub fn hour(
    behaving: &Behaving,
    run: &Run,
    airport: &Airport,
    hour: &Hour,
    mut step: impl FnMut(&mut Core, i64),
) -> Option<Held> {
    let mut core = behaving.core(run, hour.seed)?;
    let per_s = 1.0 / run.frame.s();
    for f in 0..core.flights().len() {
        let key = DrawKey { run_seed: hour.seed, sensor: 9, entity: f as u64, scan: 0 };
        let mut rng = key.rng(Purpose::Mover);
        let draws = [uniform(&mut rng), uniform(&mut rng), uniform(&mut rng)];
        if draws[0] < hour.stopping {
            let at_s = core.flights()[f].time_s + 120.0 + 400.0 * draws[1];
            core.notice(Notice {
                effect_frame: (at_s * per_s) as i64,
                source: "stops".into(),
                sequence: f as u64,
                flight: f,
                order: Order::Stop(20.0 + 160.0 * draws[2]),
            });
        }
    }
    let who: Vec<Who> = core.flights().iter().map(|f| who_of(f, &behaving.days)).collect();
    let mut checker = Checker::new(airport, who, Rules::exact());
    let last = run.frames() as i64 + (hour.drain_s * per_s) as i64;
    let (mut served_s, mut frames) = (None, 0);
    for frame in 1..=last {
        step(&mut core, frame);
        frames = frame;
        let now_s = frame as f64 * run.frame.s();
        if frame % hour.every == 0 {
            let seen = (0..core.flights().len()).filter_map(|f| {
                let state = core.state(f)?;
                Some(Seen {
                    who: f,
                    position_m: state.position_m,
                    velocity_mps: state.velocity_mps.xy(),
                    heading_rad: state.heading_rad,
                })
            });
            checker.frame(now_s, &seen.collect::<Vec<_>>());
        }
        if frame % 1200 == 0 && core.all_served() {
            served_s = Some(now_s);
            break;
        }
    }
    let given = core.clearances().iter().filter_map(|c| {
        Some(Given {
            who: c.flight,
            kind: ClearanceKind::of(c.kind)?,
            runway: c.runway.clone(),
            from_s: c.from_s,
            until_s: c.until_s.unwrap_or(f64::INFINITY),
        })
    });
    let mut rows = checker.finish(&given.collect::<Vec<_>>());
    rows.push(left_open(&core));
    Some(Held { core, rows, served_s, frames })
}

/// Clearances of who has arrived or left: he needs none, and one that stays open contradicts those of others.
fn left_open(core: &Core) -> Row {
    let served = |f: usize| matches!(core.phase(f), Phase::Docked | Phase::Gone);
    let of: Vec<_> = core.clearances().iter().filter(|c| served(c.flight)).collect();
    let open = of.iter().filter(|c| c.until_s.is_none());
    let cases: Vec<String> = open
        .map(|c| {
            let who = &core.flights()[c.flight].callsign;
            format!("{who}: {} {} of {:.0} s", c.kind, c.runway, c.from_s)
        })
        .collect();
    Row {
        name: "clearances left open",
        value: cases.len() as f64,
        goal: "0".into(),
        kept: cases.is_empty(),
        of: of.len() as u64,
        cases,
    }
}
