//! Association: nearest, global and joint on the crossing scenes, error and swaps against time.
//!
//! Scene A: pairs on a 150 m grid, one east, one north, both at the crossing in mid-run. Scene B: pairs that
//! cross at 12°. Both start from the truth, so that association alone is measured.

use crate::clock;
use crate::measure::{median_and_p99, quantile, round_plot};
use crate::{Draws, Ladder, Options, Outcome, Progress, Row, SceneAbout};
use models::draw::{DrawKey, Purpose, normal_pair, uniform};
use models::filter::gaussian::Sym2;
use models::filter::{FilterConfig, Gaussian, Rung};
use models::flight_list::FlightList;
use models::frames::{Point2, Vector2};
use models::fusion::config::{AssociationMethod, SensorModel};
use models::fusion::{Tracker, TrackingConfig};
use models::plot::{Plot, SensorId, SensorKind};
use models::score::gospa;
use models::time::SimTime;
use rand::rngs::ChaCha8Rng;

/// Standard deviation of a plot per axis, m: 7.5 m at 95 %.
const SIGMA_M: f64 = 3.064;

/// Cut-off of GOSPA, m; also how far a track may end from its target.
const CUT_OFF_M: f64 = 20.0;

/// Targets on straight lines, seen once a second.
#[derive(Clone, Debug)]
pub struct Crossing {
    /// Name in the reports.
    pub name: &'static str,
    /// Position at time 0 and velocity of each target; targets 2k and 2k + 1 are partners.
    pub targets: Vec<(Point2<f64>, Vector2<f64>)>,
    /// Probability of a plot.
    pub detection: f64,
    /// Scans.
    pub scans: u32,
    /// Scans (first, last) without any plot.
    pub outage: Option<(u32, u32)>,
    /// Rectangles (low, high corner) with so many false plots each and scan.
    pub clutter: Vec<(Point2<f64>, Point2<f64>, u32)>,
}

impl Crossing {
    /// `targets` targets in pairs on a grid, crossing at right angles.
    #[must_use]
    pub fn a(targets: usize, rng: &mut ChaCha8Rng) -> Self {
        let pairs = targets.div_ceil(2);
        let columns = (pairs as f64).sqrt().ceil() as usize;
        let scans = 12;
        let middle = 0.5 * f64::from(scans);
        let mut list = Vec::new();
        for pair in 0..pairs {
            let centre =
                Point2::new(150.0 * (pair % columns) as f64, 150.0 * (pair / columns) as f64);
            for direction in [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)] {
                let velocity = direction * (8.0 + 7.0 * uniform(rng));
                let at_crossing = middle + 3.0 * (uniform(rng) - 0.5);
                list.push((centre - velocity * at_crossing, velocity));
            }
        }
        let side_m = 150.0 * columns as f64;
        let (low, high) = (Point2::new(-75.0, -75.0), Point2::new(side_m, side_m));
        let clutter = vec![(low, high, (targets / 2) as u32)];
        Self { name: "crossing_90", targets: list, detection: 0.95, scans, outage: None, clutter }
    }

    /// `targets` targets in pairs 400 m apart that cross at 12° with nearly equal speeds.
    #[must_use]
    pub fn b(targets: usize, rng: &mut ChaCha8Rng) -> Self {
        let scans = 16;
        let middle = 0.5 * f64::from(scans);
        let mut list = Vec::new();
        let mut clutter = Vec::new();
        for pair in 0..targets.div_ceil(2) {
            let centre = Point2::new(400.0 * pair as f64, 0.0);
            let heading = std::f64::consts::TAU * uniform(rng);
            let speed = 8.0 + 4.0 * uniform(rng);
            for side in [0.0, 12f64.to_radians()] {
                let v = speed + 0.5 * (2.0 * uniform(rng) - 1.0) * 0.5;
                let (sin, cos) = libm::sincos(heading + side);
                let velocity = Vector2::new(sin, cos) * v;
                let at_crossing = middle + 0.4 * (uniform(rng) - 0.5);
                list.push((centre - velocity * at_crossing, velocity));
            }
            let half = Vector2::repeat(80.0);
            clutter.push((centre - half, centre + half, 2));
        }
        Self { name: "crossing_12", targets: list, detection: 0.9, scans, outage: None, clutter }
    }

    /// Two taxiways 15 m apart, traffic side by side at equal speed.
    #[must_use]
    pub fn parallel(targets: usize, rng: &mut ChaCha8Rng) -> Self {
        let mut list = Vec::new();
        let mut clutter = Vec::new();
        for pair in 0..targets.div_ceil(2) {
            let start = Point2::new(0.0, 300.0 * pair as f64);
            let velocity = Vector2::new(8.0 + 3.0 * uniform(rng), 0.0);
            list.push((start, velocity));
            list.push((start + Vector2::new(3.0 * uniform(rng), 15.0), velocity));
            clutter.push((start - Vector2::new(50.0, 80.0), start + Vector2::new(350.0, 95.0), 4));
        }
        let name = "parallel_taxiways";
        Self { name, targets: list, detection: 0.9, scans: 30, outage: None, clutter }
    }

    /// Lone targets in dense clutter: 40 false plots in 200 × 200 m about each.
    #[must_use]
    pub fn clutter(targets: usize, rng: &mut ChaCha8Rng) -> Self {
        let (mut list, mut clutter) = (Vec::new(), Vec::new());
        for target in 0..targets {
            let centre = Point2::new(400.0 * target as f64, 0.0);
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * uniform(rng));
            let velocity = Vector2::new(sin, cos) * (6.0 + 6.0 * uniform(rng));
            list.push((centre - velocity * 10.0, velocity));
            let half = Vector2::repeat(100.0);
            clutter.push((centre - half, centre + half, 40));
        }
        let name = "dense_clutter";
        Self { name, targets: list, detection: 0.9, scans: 20, outage: None, clutter }
    }

    /// The 12° crossing with six seconds without plots after it.
    #[must_use]
    pub fn outage(targets: usize, rng: &mut ChaCha8Rng) -> Self {
        Self { name: "sensor_outage", scans: 24, outage: Some((11, 16)), ..Self::b(targets, rng) }
    }

    fn truth(&self, t: f64) -> Vec<Point2<f64>> {
        self.targets.iter().map(|(p, v)| p + v * t).collect()
    }

    fn plots(&self, k: u32, rng: &mut ChaCha8Rng) -> Vec<Plot> {
        let t = f64::from(k);
        let mut positions = Vec::new();
        for truth in self.truth(t) {
            let (a, b) = normal_pair(rng);
            if uniform(rng) < self.detection {
                positions.push(truth + Vector2::new(a, b) * SIGMA_M);
            }
        }
        for &(low, high, count) in &self.clutter {
            for _ in 0..count {
                let (u, v) = (uniform(rng), uniform(rng));
                let extent = high - low;
                positions.push(low + Vector2::new(extent.x * u, extent.y * v));
            }
        }
        if self.outage.is_some_and(|(first, last)| (first..=last).contains(&k)) {
            positions.clear();
        }
        let plot = |(n, p)| round_plot(SimTime::from_s(t), n as u32, p, SIGMA_M);
        positions.into_iter().enumerate().map(plot).collect()
    }

    /// False plots per square metre and scan.
    fn density(&self) -> f64 {
        let (mut count, mut area) = (0.0, 0.0);
        for (low, high, n) in &self.clutter {
            count += f64::from(*n);
            area += (high.x - low.x) * (high.y - low.y);
        }
        if area > 0.0 { count / area } else { 1e-9 }
    }
}

/// The rungs by name.
#[must_use]
pub fn methods() -> [(&'static str, AssociationMethod); 3] {
    [
        ("nearest", AssociationMethod::Nearest),
        ("global", AssociationMethod::Global),
        ("joint", AssociationMethod::Joint { limit: 100_000 }),
    ]
}

/// Tracks the targets of a crossing: association alone, no starts counted as tracks of targets.
fn config(scene: &Crossing, method: AssociationMethod) -> TrackingConfig {
    let mut config = TrackingConfig::paper();
    config.association = method;
    // Constant velocity, q = 0.5 m²/s³.
    config.filter = FilterConfig { q: 0.5, rolling: true, ..FilterConfig::new(Rung::Ca3) };
    // The tracks given at the start are to live through the run, whatever happens to them.
    (config.life.delete_moving_s, config.life.delete_standing_s) = (60.0, 60.0);
    config.gates.probability = 0.9999;
    config.gates.kinematic = false;
    config.gates.restart = false;
    config.duplicate_radius_m = 0.0;
    // No new tracks: association alone is measured.
    config.life.most_tracks = scene.targets.len();
    let mut sensor = SensorModel::default_of(SensorId(1), SensorKind::Asde);
    sensor.detection = scene.detection;
    sensor.false_density_m2 = scene.density();
    sensor.extra_sigma_m = 0.0;
    config.sensors.push(sensor);
    config
}

fn start(position: Point2<f64>, velocity: Vector2<f64>) -> Gaussian {
    let r = Sym2 { xx: SIGMA_M * SIGMA_M, xy: 0.0, yy: SIGMA_M * SIGMA_M };
    let mut state = Gaussian::at_position(position, r, 1.0, 0.1);
    state.x[1] = models::filter::lanes::Pair::new(velocity.x, velocity.y);
    state
}

/// What one rung gave on one scene, summed over runs.
#[derive(Clone, Debug, Default)]
struct Sums {
    targets: usize,
    lost_or_swapped: usize,
    gospa: f64,
    squares: f64,
    pairs: usize,
    scans: usize,
    /// Time of a scan per target, ns.
    scan_ns: Vec<f64>,
    /// Position errors, m.
    radii: Vec<f64>,
}

fn one_run(scene: &Crossing, method: AssociationMethod, key: DrawKey, sums: &mut Sums) {
    let mut rng = key.rng(Purpose::Study);
    let mut tracker = Tracker::new(config(scene, method));
    let states: Vec<Gaussian> = scene.targets.iter().map(|&(p, v)| start(p, v)).collect();
    tracker.adopt(SimTime::ZERO, &states);
    let flights = FlightList::default();
    let n = scene.targets.len();
    let mut last = vec![Point2::new(f64::NAN, f64::NAN); n];
    for k in 1..=scene.scans {
        let plots = scene.plots(k, &mut rng);
        let begin = clock::thread_ns();
        let tracks = tracker.scan(SimTime::from_s(f64::from(k)), &plots, &flights);
        sums.scan_ns.push((clock::thread_ns() - begin) as f64 / n as f64);
        // The adopted tracks have the first numbers, in order.
        for track in tracks.iter().filter(|t| usize::from(t.number) < n) {
            last[usize::from(track.number)] = track.position_m;
        }
        let estimates: Vec<_> =
            tracks.iter().filter(|t| usize::from(t.number) < n).map(|t| t.position_m).collect();
        let truth = scene.truth(f64::from(k));
        let found = gospa(&truth, &estimates, CUT_OFF_M, 2.0);
        sums.radii.extend(found.pairs.iter().map(|&(t, e)| (truth[t] - estimates[e]).norm()));
        sums.gospa += found.total / (n as f64).sqrt();
        sums.squares += found.localisation;
        sums.pairs += found.pairs.len();
        sums.scans += 1;
    }
    let truth = scene.truth(f64::from(scene.scans));
    for (target, position) in last.iter().enumerate() {
        let own = (position - truth[target]).norm();
        let partner = truth.get(target ^ 1).map_or(f64::INFINITY, |p| (position - p).norm());
        sums.targets += 1;
        if !(own <= CUT_OFF_M && own <= partner) {
            sums.lost_or_swapped += 1;
        }
    }
}

type Make = fn(usize, &mut ChaCha8Rng) -> Crossing;

/// Scene, targets, runs of the full and of the quick study.
const CASES: [(Make, usize, u64, u64); 8] = [
    (Crossing::b, 10, 300, 40),
    (Crossing::b, 100, 20, 3),
    (Crossing::a, 100, 40, 6),
    (Crossing::a, 1000, 4, 1),
    (Crossing::parallel, 10, 100, 15),
    (Crossing::clutter, 10, 100, 15),
    (Crossing::clutter, 100, 8, 1),
    (Crossing::outage, 10, 200, 30),
];

/// One row a scene, size and method.
fn rows(quick: bool, seed: u64, progress: &mut dyn FnMut(Progress)) -> Vec<Row> {
    let mut rows = Vec::new();
    let total = CASES.len() * methods().len();
    for (make, targets, full, few) in CASES {
        for (name, method) in methods() {
            let mut sums = Sums::default();
            let mut scene_name = "";
            for run in 0..if quick { few } else { full } {
                // The same draws for every method.
                let key = DrawKey { run_seed: seed, sensor: targets as u32, entity: 0, scan: run };
                let scene = make(targets, &mut key.rng(Purpose::Mover));
                scene_name = scene.name;
                one_run(&scene, method, key, &mut sums);
            }
            rows.push(row(scene_name, targets, name, &mut sums));
            let what = format!("{scene_name}_{targets} {name}");
            progress(Progress { group: "association", what, done: rows.len(), total });
        }
    }
    rows
}

/// Measures the ladder.
pub(crate) fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let rows = rows(options.quick, options.seed, progress);
    let about = |name: &str, text: &str| SceneAbout { name: name.into(), about: text.into() };
    let ladder = Ladder {
        group: "association".into(),
        title: "Association: which plot belongs to which track".into(),
        about: "Tracks start from the truth and no new ones are made, so that association alone is measured; \
                plots have 3.06 m per axis (7.5 m at 95 %), all methods get the same ones. GOSPA (cut-off 20 m, \
                per root of the number of targets) counts position errors, missed targets and false tracks in \
                one figure; a track that ends more than 20 m from its target or nearer to its partner's is lost \
                or swapped. Time is one scan with gates, association and filter, per target."
            .into(),
        error_label: "GOSPA per root of targets, m".into(),
        scenes: vec![
            about("crossing_12_10", "ten targets in pairs that cross at 12° side by side, clutter"),
            about("crossing_12_100", "a hundred of them"),
            about("crossing_90_100", "a hundred targets that cross at right angles, clutter"),
            about("crossing_90_1000", "a thousand of them"),
            about("parallel_taxiways_10", "pairs on taxiways 15 m apart at equal speed, clutter"),
            about("dense_clutter_10", "ten lone targets, each among 40 false plots in 200 × 200 m"),
            about("dense_clutter_100", "a hundred of them"),
            about("sensor_outage_10", "the 12° crossing, then six seconds without any plot"),
        ],
        draws: Draws::Gospa,
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

/// Error columns for a snapshot.
#[must_use]
pub fn error_table(seed: u64) -> String {
    let mut out = String::from("scene rung rmse_m p95_m gospa swaps_pct\n");
    for (make, targets, runs) in [
        (Crossing::b as Make, 10, 20),
        (Crossing::a, 100, 2),
        (Crossing::parallel, 10, 6),
        (Crossing::clutter, 10, 6),
        (Crossing::outage, 10, 10),
    ] {
        for (name, method) in methods() {
            let mut sums = Sums::default();
            let mut scene_name = "";
            for run in 0..runs {
                let key = DrawKey { run_seed: seed, sensor: targets as u32, entity: 0, scan: run };
                let scene = make(targets, &mut key.rng(Purpose::Mover));
                scene_name = scene.name;
                one_run(&scene, method, key, &mut sums);
            }
            let row = row(scene_name, targets, name, &mut sums);
            let number = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.2}"));
            out += &format!(
                "{} {} {} {} {} {}\n",
                row.scene,
                row.rung,
                number(row.rmse_m),
                number(row.p95_m),
                number(row.gospa),
                number(row.swaps_pct)
            );
        }
    }
    out
}

fn row(scene: &str, targets: usize, rung: &str, sums: &mut Sums) -> Row {
    let (ns_per_update, ns_p99) = median_and_p99(&mut sums.scan_ns);
    Row {
        group: "association".to_owned(),
        scene: format!("{scene}_{targets}"),
        rung: rung.to_owned(),
        rmse_m: Some((sums.squares / sums.pairs.max(1) as f64).sqrt()),
        p95_m: quantile(&mut sums.radii, 0.95),
        swaps_pct: Some(100.0 * sums.lost_or_swapped as f64 / sums.targets.max(1) as f64),
        gospa: Some(sums.gospa / sums.scans.max(1) as f64),
        ns_per_update,
        ns_p99,
        ..Row::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_columns_are_those_of_the_snapshot() {
        insta::assert_snapshot!(error_table(3));
    }

    #[test]
    fn joint_association_swaps_least_where_traffic_crosses_at_12_degrees() {
        let mut swaps = Vec::new();
        for (name, method) in methods() {
            let mut sums = Sums::default();
            for run in 0..100 {
                let key = DrawKey { run_seed: 77, sensor: 10, entity: 0, scan: run };
                let scene = Crossing::b(10, &mut key.rng(Purpose::Mover));
                one_run(&scene, method, key, &mut sums);
            }
            let row = row("crossing_12", 10, name, &mut sums);
            println!("{name}: {:?} % swapped, gospa {:?}", row.swaps_pct, row.gospa);
            swaps.push(row.swaps_pct.expect("measured"));
        }
        assert!(swaps[2] <= 6.0, "{swaps:?}");
        assert!(swaps[2] < 0.3 * swaps[0] && swaps[2] < 0.3 * swaps[1], "{swaps:?}");
    }
}
