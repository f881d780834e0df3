//! The rotating video of a radar: all cells of one turn, from the radar's own model, made when a pane of a page asks for one.
//!
//! Everything exact, the truth of the scan dead-reckoned within it, the draws of the run (seed, sensor, entity, scan). One turn is
//! made at a time, never a queue, and at most for `SHARE` of the time: whoever asks meanwhile is told to ask again. So no
//! pane can hold the run up.

use super::frame;
use crate::runtime::clock::monotonic_ns;
use models::environment::Weather;
use models::frames::{Point2, Point3, Vector3};
use models::plot::Callsign;
use models::sensors::asde::picture::VideoScene;
use models::sensors::asde::{Asde, AsdeParameters};
use models::sensors::radar::levels::RadarLevels;
use models::sensors::radar::video::{CellRadar, MOST_CELLS, Video};
use models::sensors::{ScanInterval, TargetClass, TargetState, Truth};
use models::time::SimTime;
use scenarios::Scene;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use studies::picture::Pavement;

/// First octets of a turn.
pub const MAGIC: [u8; 4] = *b"VIDE";
/// Version of the layout; the page refuses another one.
pub const VERSION: u8 = 1;
/// Octets before the cells.
pub const HEADER: usize = 64;
/// Power of level 0 and below, over the mean of noise, dB.
pub const FLOOR_DB: f64 = -1.5;
/// From one of the 16 levels to the next, dB.
pub const STEP_DB: f64 = 3.0;
/// Cells of a message: along the range, and beams.
const MOST: (usize, usize) = (1024, 2048);
/// Of the time, at most, that turns are made.
const SHARE: f64 = 0.4;
/// Nobody waits longer for the next one, ns.
const MOST_PAUSE_NS: u64 = 10_000_000_000;
/// Turns kept: a few of a few radars.
const MOST_KEPT: usize = 16;
/// What an entity is that the scene has no type for.
const TYPE: &str = "A320";

/// Why there is no turn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoTurn {
    /// Another one is being made, or was a moment ago: ask again.
    Busy,
    /// There will be none; as one sentence.
    Never(String),
}

/// What is needed of the run for a turn.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Number of the radar.
    pub sensor: u16,
    /// Seed of the run.
    pub seed: u64,
    /// The scan, as the page was sent it ([`frame::encode`]).
    pub scan: Vec<u8>,
}

/// One radar with all that its video needs.
#[derive(Debug)]
struct Ready {
    sensor: u16,
    radar: Asde,
    site_m: Point2<f64>,
    ground: Arc<Pavement>,
}

/// A turn by its radar and its scan.
type Kept = ((u16, u64), Arc<Vec<u8>>);

#[derive(Debug, Default)]
struct Made {
    radars: Vec<Ready>,
    kept: VecDeque<Kept>,
    /// Not before then the next one, ns of the wall clock.
    rest_ns: u64,
}

/// The turns of one run.
#[derive(Debug, Default)]
pub struct Turns(Mutex<Made>);

impl Turns {
    /// The turn of a radar that ended with a scan, as it goes to the browser: see `encode`.
    ///
    /// # Errors
    /// Another turn is being made; or the scene has no such radar, or one with more cells than can be kept.
    pub fn turn(&self, scene: &Scene, asked: &Asked) -> Result<Arc<Vec<u8>>, NoTurn> {
        let mut made = match self.0.try_lock() {
            Ok(made) => made,
            Err(TryLockError::WouldBlock) => return Err(NoTurn::Busy),
            Err(TryLockError::Poisoned(made)) => PoisonError::into_inner(made),
        };
        let (scan, time) = frame::number_and_time(&asked.scan)
            .ok_or_else(|| NoTurn::Never("there is no such scan".to_owned()))?;
        let key = (asked.sensor, scan);
        if let Some((_, turn)) = made.kept.iter().find(|k| k.0 == key) {
            return Ok(Arc::clone(turn));
        }
        let began_ns = monotonic_ns();
        if began_ns < made.rest_ns {
            return Err(NoTurn::Busy);
        }
        let turn = Arc::new(made.make(scene, asked, (scan, time)).map_err(NoTurn::Never)?);
        let now_ns = monotonic_ns();
        made.rest_ns = now_ns + pause_after_ns(now_ns.saturating_sub(began_ns));
        if made.kept.len() >= MOST_KEPT {
            made.kept.pop_front();
        }
        made.kept.push_back((key, Arc::clone(&turn)));
        Ok(turn)
    }
}

/// How long nothing is made after a turn that took so long, ns.
fn pause_after_ns(took_ns: u64) -> u64 {
    ((took_ns as f64 * (1.0 / SHARE - 1.0)) as u64).min(MOST_PAUSE_NS)
}

impl Made {
    fn make(
        &mut self,
        scene: &Scene,
        asked: &Asked,
        (scan, time): (u64, SimTime),
    ) -> Result<Vec<u8>, String> {
        let at = match self.radars.iter().position(|r| r.sensor == asked.sensor) {
            Some(at) => at,
            None => {
                self.radars.push(Ready::of(scene, asked.sensor)?);
                self.radars.len() - 1
            }
        };
        let Ready { radar, ground, site_m, .. } = &mut self.radars[at];
        let notice = scene.weather.iter().rev().find(|n| n.time <= time);
        let weather =
            notice.map_or_else(Weather::default, |n| n.weather.after(time.since_s(n.time)));
        // A whole turn, and a whole scan.
        let turn_s = (1.0 / radar.parameters().turns_per_s()).max(scene.run.scan().s());
        let interval =
            ScanInterval { run_seed: asked.seed, scan, from: time.plus_s(-turn_s), to: time };
        let truth = Seen::of(scene, &asked.scan, time);
        let video = radar.video(&interval, &truth, &weather, &**ground, &VideoScene::PICTURE);
        let parameters = radar.parameters();
        Ok(encode((asked.sensor, parameters, *site_m), &video, (scan, time)))
    }
}

impl Ready {
    fn of(scene: &Scene, sensor: u16) -> Result<Self, String> {
        let found = scene.sensors.iter().find(|s| s.id.0 == sensor);
        let found = found.and_then(|s| Some((s, s.asde.as_ref()?)));
        let (row, parts) = found.ok_or("this sensor is not a radar")?;
        let radar = parts.radar(scene, row).map_err(|e| e.to_string())?;
        let cells = CellRadar::of(radar.parameters()).turn_cells();
        if cells > MOST_CELLS {
            return Err(format!("{cells} cells a turn: at most {MOST_CELLS} are shown"));
        }
        let site_m = row.site_m.map_or_else(Point2::origin, |site| site.xy());
        let reach_m = (radar.parameters().range_max_m + site_m.coords.norm()).min(12_000.0);
        let ground = Arc::new(Pavement::of(&scene.airport.layout, reach_m));
        Ok(Self { sensor, radar: radar.at_levels(RadarLevels::EXACT), site_m, ground })
    }
}

/// The entities of a scan as they were within it: back along their velocity.
pub(super) struct Seen<'a> {
    at: SimTime,
    targets: Vec<(frame::Entity, &'a TargetClass)>,
}

impl<'a> Seen<'a> {
    pub(super) fn of(scene: &'a Scene, scan: &[u8], at: SimTime) -> Self {
        let types = &scene.traffic.types;
        let usual = types.get(TYPE).or_else(|| types.get(types.designators().next()?));
        let class = |e: &frame::Entity| Some(&types.get(&e.designator).or(usual)?.class);
        let known = frame::entities(scan).into_iter();
        let mut targets: Vec<_> = known.filter_map(|e| class(&e).map(|class| (e, class))).collect();
        targets.sort_by_key(|t| t.0.key);
        Self { at, targets }
    }
}

impl Truth for Seen<'_> {
    fn len(&self) -> usize {
        self.targets.len()
    }
    fn key(&self, index: usize) -> u64 {
        self.targets[index].0.key
    }
    fn class(&self, index: usize) -> &TargetClass {
        self.targets[index].1
    }
    fn callsign(&self, index: usize) -> Callsign {
        Callsign::new(&self.targets[index].0.callsign)
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let e = &self.targets[index].0;
        let since_s = time.since_s(self.at);
        let velocity_mps = Vector3::new(e.velocity_mps[0], e.velocity_mps[1], 0.0);
        Some(TargetState {
            position_m: Point3::from(e.position_m) + velocity_mps * since_s,
            velocity_mps,
            heading_rad: e.heading_rad,
        })
    }
}

/// A turn for the browser (`web/video.js` is the other end), little-endian: `VIDE`, version u8, an octet 0, sensor u16, scan u64, time
/// i64 ns, cells along the range u16 and beams u16, then f32: near edge of the first cell (slant) m, length of a cell m, dB of level
/// 0, dB a level, antenna east, north m and above the ground m, seconds a turn; four octets 0. Then a cell in four bits, low ones
/// first, range fastest, each beam from a whole octet: the level of its strongest part, so that nothing is lost where
/// several cells of the radar share one. Beams count clockwise from north.
fn encode(
    (sensor, p, site_m): (u16, &AsdeParameters, Point2<f64>),
    video: &Video,
    (scan, time): (u64, SimTime),
) -> Vec<u8> {
    let fold = |n: usize, most: usize| n.div_ceil(n.div_ceil(most.max(1)).max(1)).max(1);
    let (ranges, beams) = (fold(video.cells, MOST.0), fold(video.beams, MOST.1));
    let per_range = video.cells.div_ceil(ranges);
    let mut strongest = vec![0.0_f32; ranges * beams];
    for (at, power) in video.power.iter().enumerate() {
        let (beam, cell) = (at / video.cells, at % video.cells);
        let slot = &mut strongest[beam * beams / video.beams * ranges + cell / per_range];
        *slot = slot.max(*power);
    }
    let cell_m = p.radar().cell_m * per_range as f64;
    let mut out = Vec::with_capacity(HEADER + beams * ranges.div_ceil(2));
    out.extend(MAGIC);
    out.extend([VERSION, 0]);
    out.extend(sensor.to_le_bytes());
    out.extend(scan.to_le_bytes());
    out.extend(time.0.to_le_bytes());
    out.extend((ranges as u16).to_le_bytes());
    out.extend((beams as u16).to_le_bytes());
    for figure in [
        p.range_min_m,
        cell_m,
        FLOOR_DB,
        STEP_DB,
        site_m.x,
        site_m.y,
        p.antenna_height_m,
        1.0 / p.turns_per_s(),
    ] {
        out.extend((figure as f32).to_le_bytes());
    }
    out.resize(HEADER, 0);
    let level = |power: f32| {
        let db = 10.0 * libm::log10(f64::from(power).max(1e-9));
        ((db - FLOOR_DB) / STEP_DB).floor().clamp(0.0, 15.0) as u8
    };
    for row in strongest.chunks_exact(ranges) {
        out.extend(
            row.chunks(2).map(|two| level(two[0]) | two.get(1).map_or(0, |p| level(*p)) << 4),
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::{ScanReport, TruthMessage};

    /// A scan with one A320 that stands east of the radar, on open ground.
    fn scan(number: u64, at_s: f64, place_m: [f64; 2]) -> Vec<u8> {
        let truth = TruthMessage {
            id: [1, 2, 3],
            callsign: "TEST1".to_owned(),
            address: None,
            type_designator: "A320".to_owned(),
            aircraft: true,
            size_m: [37.6, 34.1],
            position_m: Point3::new(place_m[0], place_m[1], 0.0),
            velocity_mps: [0.0; 3],
            heading_rad: 0.3,
            ours: true,
            track: None,
        };
        let time_ns = (at_s * 1e9) as i64;
        frame::encode(&ScanReport {
            scan: number,
            time_ns,
            truth: vec![truth],
            ..Default::default()
        })
    }

    struct Read {
        beams: usize,
        ranges: usize,
        first_m: f64,
        step_m: f64,
        site_m: [f64; 2],
        antenna_m: f64,
        octets: Vec<u8>,
    }

    impl Read {
        fn of(turn: &[u8]) -> Self {
            assert_eq!((&turn[..4], turn[4]), (&MAGIC[..], VERSION));
            let short = |at: usize| u16::from_le_bytes([turn[at], turn[at + 1]]) as usize;
            let single = |i: usize| {
                f64::from(f32::from_le_bytes(
                    turn[28 + 4 * i..32 + 4 * i].try_into().expect("four"),
                ))
            };
            assert_eq!((single(2), single(3)), (FLOOR_DB, STEP_DB));
            let (ranges, beams) = (short(24), short(26));
            assert_eq!(turn.len(), HEADER + beams * ranges.div_ceil(2));
            Self {
                beams,
                ranges,
                first_m: single(0),
                step_m: single(1),
                site_m: [single(4), single(5)],
                antenna_m: single(6),
                octets: turn[HEADER..].to_vec(),
            }
        }

        fn level(&self, beam: usize, cell: usize) -> f64 {
            let octet = self.octets[beam * self.ranges.div_ceil(2) + cell / 2];
            f64::from(octet >> (4 * (cell % 2)) & 15)
        }

        /// Levels of the cells whose middle lies within `within_m` of a place.
        fn near(&self, place_m: [f64; 2], within_m: f64) -> Vec<f64> {
            let mut found = Vec::new();
            for beam in 0..self.beams {
                let azimuth = std::f64::consts::TAU * (beam as f64 + 0.5) / self.beams as f64;
                for cell in 0..self.ranges {
                    let slant_m = self.first_m + (cell as f64 + 0.5) * self.step_m;
                    let ground_m =
                        (slant_m * slant_m - self.antenna_m * self.antenna_m).max(0.0).sqrt();
                    let x = self.site_m[0] + ground_m * libm::sin(azimuth) - place_m[0];
                    let y = self.site_m[1] + ground_m * libm::cos(azimuth) - place_m[1];
                    if libm::hypot(x, y) < within_m {
                        found.push(self.level(beam, cell));
                    }
                }
            }
            found
        }
    }

    fn mean(levels: &[f64]) -> f64 {
        assert!(levels.len() > 20, "{} cells", levels.len());
        levels.iter().sum::<f64>() / levels.len() as f64
    }

    #[test]
    fn a_target_is_bright_where_it_stands_rain_fills_in_and_a_building_darkens() {
        let file = scenarios::locate("asmgcs");
        let scene = scenarios::load_without_truth(&file).expect("the shipped scene");
        let radar = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar");
        let site_m = radar.site_m.expect("a site").xy();
        let target_m = [site_m.x + 620.0, site_m.y + 300.0];
        let turns = Turns::default();
        let turn = |scan: Vec<u8>| {
            turns.0.lock().expect("sound").rest_ns = 0;
            turns.turn(&scene, &Asked { sensor: radar.id.0, seed: 7, scan })
        };
        let dry = turn(scan(40, 40.0, target_m)).expect("a turn");
        let read = Read::of(&dry);
        // The target: 18 dB over noise and more, and nowhere else as bright as it.
        let brightest = |r: &Read, at, within| r.near(at, within).into_iter().fold(0.0, f64::max);
        let db = |level: f64| FLOOR_DB + STEP_DB * level;
        assert!(
            db(brightest(&read, target_m, 20.0)) >= 18.0,
            "{}",
            brightest(&read, target_m, 20.0)
        );
        // It went: its place is as what lies around.
        let gone = turn(scan(41, 41.0, [target_m[0] + 300.0, target_m[1] + 900.0])).expect("one");
        let left = mean(&Read::of(&gone).near(target_m, 20.0));
        assert!(left + 3.0 < brightest(&read, target_m, 20.0), "{left}");
        // The same scan again is the same turn, and kept; another sensor has none.
        assert!(Arc::ptr_eq(&gone, &turn(scan(41, 41.0, target_m)).expect("kept")));
        let stranger = Asked { sensor: 999, seed: 7, scan: scan(42, 42.0, target_m) };
        turns.0.lock().expect("sound").rest_ns = 0;
        assert!(matches!(turns.turn(&scene, &stranger), Err(NoTurn::Never(_))));
        // Rain of the scene's later weather: what lies open is brighter than when it was dry.
        let rain_s = scene.weather.iter().find(|n| n.weather.cells.is_empty() && n.time.s() > 0.0);
        if let Some(notice) = rain_s {
            let wet = turn(scan(500, notice.time.s() + 1.0, target_m)).expect("a turn");
            let far_m = [site_m.x + 1500.0, site_m.y + 900.0];
            let (before, now) =
                (mean(&read.near(far_m, 60.0)), mean(&Read::of(&wet).near(far_m, 60.0)));
            assert!(now > before, "{before} dry, {now} in rain");
        }
    }

    #[test]
    fn a_turn_is_followed_by_rest_and_nobody_waits_in_a_queue() {
        let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("shipped");
        let sensor = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar").id.0;
        let turns = Turns::default();
        let asked = |n| Asked { sensor, seed: 1, scan: scan(n, n as f64, [100.0, 900.0]) };
        turns.turn(&scene, &asked(1)).expect("a turn");
        turns.0.lock().expect("sound").rest_ns = u64::MAX;
        assert_eq!(turns.turn(&scene, &asked(2)), Err(NoTurn::Busy));
        turns.turn(&scene, &asked(1)).expect("what is there is given");
        let held = turns.0.lock().expect("sound");
        assert_eq!(turns.turn(&scene, &asked(1)), Err(NoTurn::Busy), "nobody waits");
        drop(held);
        let took_ns = 800_000_000;
        let share = took_ns as f64 / (took_ns + pause_after_ns(took_ns)) as f64;
        assert!((share - SHARE).abs() < 1e-9, "{share}");
        let bad = Asked { sensor, seed: 1, scan: b"SEED".to_vec() };
        assert!(matches!(turns.turn(&scene, &bad), Err(NoTurn::Never(_))));
    }

    #[test]
    fn what_a_page_was_sent_is_read_back() {
        let message = scan(12, 3.5, [1.5, -2.5]);
        assert_eq!(frame::number_and_time(&message), Some((12, SimTime(3_500_000_000))));
        let found = frame::entities(&message);
        assert_eq!(found.len(), 1);
        assert_eq!((&*found[0].callsign, &*found[0].designator), ("TEST1", "A320"));
        assert_eq!(found[0].position_m, [1.5, -2.5, 0.0]);
        assert_eq!(found[0].key, frame::entity_key([1, 2, 3]));
        assert!((found[0].heading_rad - 0.3).abs() < 1e-6);
        // Cut anywhere: fewer entities, no panic.
        for end in 0..message.len() {
            assert!(frame::entities(&message[..end]).len() <= 1);
        }
    }
}
