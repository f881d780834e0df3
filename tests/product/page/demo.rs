//! A run made up for the page: recorded movements as truth, simple noise in place of sensors and tracker.

use federates::runtime::life_cycle::Phase;
use federates::runtime::messages::{
    FederateStatus, FlightNotice, MemberState, PlotMessage, RunState, ScanReport, TrackMessage,
    TruthMessage, WeatherNotice,
};
use federates::viewer_logger::Viewer;
use federates::viewer_logger::picture::{AirportMap, RunInfo};
use models::flight_list::{MovementKind, WakeCategory};
use models::frames::Point3;
use models::plot::SensorKind;
use models::track::{TrackStatus, TrackType};
use scenarios::Scene;
use std::path::Path;

/// Movers with their recorded points: seconds since the start, m east and north.
pub(crate) struct Demo {
    /// The scene of the map.
    pub scene: Scene,
    movers: Vec<Mover>,
}

struct Mover {
    callsign: String,
    designator: &'static str,
    aircraft: bool,
    size_m: [f64; 2],
    movement: MovementKind,
    runway_stand: &'static str,
    points: Vec<(f64, [f64; 2])>,
}

impl Demo {
    /// Reads the scene and its recorded movements.
    pub(crate) fn load() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        Self::at(&folder)
    }

    /// The same from another folder.
    pub(crate) fn at(folder: &Path) -> Self {
        let scene = scenarios::load(&folder.join("zurich.toml")).expect("the scene is sound");
        let flights = [
            ("EDW229", "A320", MovementKind::Arrival, "28/E_19", 0.0),
            ("CAI3208", "B738", MovementKind::Arrival, "14/E_67", 130.0),
            ("ENT57BW", "B738", MovementKind::Departure, "28/I_98", 200.0),
            ("AEE5ZH", "A320", MovementKind::Departure, "28/D_16", 150.0),
            ("ACA879", "B77W", MovementKind::Departure, "16/E_56", 300.0),
            ("SWR137H", "A321", MovementKind::Departure, "28/A_48", 60.0),
        ];
        let mut movers: Vec<Mover> = flights
            .into_iter()
            .map(|(callsign, designator, movement, runway_stand, skip_s)| Mover {
                callsign: callsign.to_owned(),
                designator,
                aircraft: true,
                size_m: if designator == "B77W" { [73.9, 64.8] } else { [37.6, 34.1] },
                movement,
                runway_stand,
                points: recorded(&scene, &folder.join(format!("movements/{callsign}.csv")), skip_s),
            })
            .collect();
        let stand = |i: usize| {
            let p = scene.airport.layout.stands[i].position_m;
            [p.x, p.y]
        };
        for (callsign, designator, from, to) in
            [("FOLLOW1", "FOLLOWME", 2, 14), ("FIRE3", "FIRE", 16, 0)]
        {
            let round =
                (0..40).map(|i| (f64::from(i) * 60.0, stand(if i % 2 == 0 { from } else { to })));
            movers.push(Mover {
                callsign: callsign.to_owned(),
                designator,
                aircraft: false,
                size_m: [5.0, 2.0],
                movement: MovementKind::Vehicle,
                runway_stand: "",
                points: round.collect(),
            });
        }
        Self { scene, movers }
    }

    /// Scan `n`: the truth at `n` seconds with noise that depends on `n` and the mover only.
    pub(crate) fn scan(&self, n: u64) -> ScanReport {
        let time_ns = 1_000_000_000 * n as i64;
        let mut report = ScanReport {
            run: 1,
            scan: n,
            time_ns,
            measures: vec![
                ("pd_asde".to_owned(), 0.973),
                ("raw_rmse_m".to_owned(), 3.41),
                ("rmse_m".to_owned(), 2.07),
                ("tracks_confirmed".to_owned(), self.movers.len() as f64),
            ],
            plan: vec![
                ["ASDE tower", "rain attenuation", "rain 10 mm/h", "3.1 dB", "exact"]
                    .map(str::to_owned),
                ["ASDE tower", "fog", "visibility 400 m", "0.02 dB", "skipped"].map(str::to_owned),
            ],
            took_us: 812,
            ..ScanReport::default()
        };
        for (i, mover) in self.movers.iter().enumerate() {
            let number = i as u16 + 1;
            let Some((at, v)) = mover.at(n as f64) else { continue };
            let draw = |k: u64| noise(n * 64 + k, i as u64);
            let track_m = [at[0] + 1.6 * draw(1), at[1] + 1.6 * draw(2)];
            let plot_m = [at[0] + 3.2 * draw(3), at[1] + 4.4 * draw(4)];
            let missed = draw(5) > 1.9;
            let heading_rad = libm::atan2(v[0], v[1]).rem_euclid(std::f64::consts::TAU);
            let error_m = libm::hypot(track_m[0] - at[0], track_m[1] - at[1]);
            let tracked = i != 4 || n > 6;
            report.truth.push(TruthMessage {
                id: [1, 1, number],
                callsign: mover.callsign.clone(),
                address: None,
                type_designator: mover.designator.to_owned(),
                aircraft: mover.aircraft,
                size_m: mover.size_m,
                position_m: Point3::new(at[0], at[1], 0.0),
                velocity_mps: [v[0], v[1], 0.0],
                heading_rad,
                ours: true,
                track: tracked.then_some((number, error_m)),
            });
            let mut plot =
                |sensor: u16, kind: SensorKind, position_m: [f64; 2], cov_m2: [f64; 3]| {
                    report.plots.push(PlotMessage {
                        sensor,
                        kind,
                        time_ns: time_ns - 200_000_000,
                        position_m: position_m.into(),
                        cov_m2,
                        ellipse: [0.0, 1.0, cov_m2[2], cov_m2[0]],
                        altitude_m: None,
                        velocity_mps: None,
                        polar: None,
                        scnr_db: Some(14.0 + 3.0 * draw(6)),
                        identity: String::new(),
                        address: None,
                        cause: mover.callsign.clone(),
                        truth_m: Some(at.into()),
                        sequence: i as u32,
                        track: tracked.then_some(number),
                        effects: if kind == SensorKind::Asde { effects() } else { Vec::new() },
                    });
                };
            if !missed {
                plot(1, SensorKind::Asde, plot_m, [10.0, 2.0, 19.0]);
            }
            if !mover.aircraft {
                plot(3, SensorKind::Dgps, [at[0] + draw(7), at[1] + draw(8)], [1.0, 0.0, 1.0]);
            }
            if i == 0 {
                plot(
                    2,
                    SensorKind::Gps,
                    [at[0] + 5.0 * draw(7), at[1] + 5.0 * draw(8)],
                    [25.0, 0.0, 25.0],
                );
            }
            if tracked {
                report.tracks.push(TrackMessage {
                    number,
                    track_type: if mover.aircraft {
                        TrackType::Aircraft
                    } else {
                        TrackType::Vehicle
                    },
                    status: if missed { TrackStatus::Coasting } else { TrackStatus::Confirmed },
                    first: false,
                    time_ns,
                    position_m: track_m.into(),
                    velocity_mps: v,
                    cov_m2: [2.6, 0.5, 3.4],
                    acceleration_ms2: [0.0; 2],
                    velocity_cov_m2s2: [1.0, 0.0, 1.0],
                    altitude_m: None,
                    altitude_ns: None,
                    heading_rad,
                    manoeuvre: n % 40 < 3 && i == 1,
                    callsign: mover.callsign.clone(),
                    type_designator: mover.designator.to_owned(),
                    wake: mover.aircraft.then_some(WakeCategory::Medium),
                    movement: Some(mover.movement),
                    runway_stand: mover.runway_stand.to_owned(),
                    ctd_eta_ns: None,
                    routing: Vec::new(),
                    assumed: String::new(),
                    label_p: None,
                    address: None,
                    existence_p: None,
                    unresolved: false,
                    lag: None,
                });
            }
        }
        report
    }

    /// Gives the viewer the scene and everything but scans.
    pub(crate) fn begin(&self, viewer: &mut Viewer) {
        viewer.on_scene(&RunInfo::of(&self.scene, 1), &AirportMap::of(&self.scene));
        viewer.on_weather(&WeatherNotice {
            from_ns: 0,
            rain_mm_per_h: 10.0,
            visibility_m: 400.0,
            temperature_k: 283.15,
            pressure_hpa: 1002.0,
            vapour_g_per_m3: 9.0,
            wind_mps: [3.0, -4.0],
            film_mm: 0.5,
            cells: vec![[1100.0, 700.0, 600.0, 40.0]],
        });
        let flights: Vec<FlightNotice> = self
            .movers
            .iter()
            .map(|m| FlightNotice {
                callsign: m.callsign.clone(),
                address: None,
                type_designator: m.designator.to_owned(),
                wake: m.aircraft.then_some(WakeCategory::Medium),
                movement: m.movement,
                runway: m.runway_stand.split('/').next().unwrap_or("").to_owned(),
                stand: m.runway_stand.split('/').nth(1).unwrap_or("").to_owned(),
                stand_m: None,
                eta_ctd_ns: 300_000_000_000,
                off_block_ns: None,
                routing: ["E", "L", "B"].map(str::to_owned).to_vec(),
            })
            .collect();
        viewer.on_flights(&flights);
        viewer.on_state(&self.state(Phase::Running, 0));
        for (name, pdus) in NAMES.into_iter().zip(1..) {
            for s in 0..2 {
                let status = FederateStatus {
                    name: name.to_owned(),
                    pid: 4000 + pdus as u32,
                    host: "localhost".to_owned(),
                    frame: 20 * s,
                    cpu_pct: 3.0 * pdus as f64,
                    rss_bytes: 30_000_000,
                    pdus_in: s * 40 * pdus,
                    pdus_out: s * 20,
                    lost: if name == "smdfm" { 12 } else { 0 },
                    repaired: if name == "smdfm" { 12 } else { 0 },
                    ..FederateStatus::default()
                };
                viewer.on_federate(status, 1_000_000_000 * s as i64);
            }
        }
    }

    /// State of the run at a frame.
    pub(crate) fn state(&self, phase: Phase, frame: u64) -> RunState {
        RunState {
            scene: self.scene.name.clone(),
            run: 1,
            phase,
            frame,
            last_frame: 12_000,
            step_ns: 50_000_000,
            start_utc_ns: self.scene.run.start_utc_ns,
            seed: 1,
            rate: 1.0,
            achieved_rate: 1.0,
            reasons: Vec::new(),
            members: NAMES
                .iter()
                .map(|name| MemberState {
                    name: (*name).to_owned(),
                    alive: true,
                    essential: *name != "viewer-logger",
                    frame,
                    latency_us: 420.0,
                    ..MemberState::default()
                })
                .collect(),
        }
    }
}

const NAMES: [&str; 4] = ["traffic-generator", "external-world", "smdfm", "viewer-logger"];

impl Mover {
    fn at(&self, t: f64) -> Option<([f64; 2], [f64; 2])> {
        let next = self.points.partition_point(|p| p.0 <= t);
        let (a, b) = (self.points.get(next.checked_sub(1)?)?, self.points.get(next)?);
        let share = (t - a.0) / (b.0 - a.0);
        let at = [0, 1].map(|k| a.1[k] + share * (b.1[k] - a.1[k]));
        // Over several seconds, because the records repeat positions.
        let (c, d) = (
            &self.points[next.saturating_sub(6)],
            &self.points[(next + 4).min(self.points.len() - 1)],
        );
        Some((at, [0, 1].map(|k| (d.1[k] - c.1[k]) / (d.0 - c.0).max(1.0))))
    }
}

fn recorded(scene: &Scene, file: &Path, skip_s: f64) -> Vec<(f64, [f64; 2])> {
    let text = std::fs::read_to_string(file).expect("recorded movement");
    let rows: Vec<(f64, [f64; 2])> = text
        .lines()
        .filter_map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let figure = |i: usize| cells.get(i)?.parse::<f64>().ok();
            let p = scene.airport.local_m(figure(3)?, figure(4)?);
            Some((figure(0)? / 1000.0, [p.x, p.y]))
        })
        .collect();
    let start = rows.first().expect("rows").0 + skip_s;
    rows.into_iter().map(|(t, p)| (t - start, p)).filter(|(t, _)| *t >= -5.0).collect()
}

/// Roughly normal figures from a hash of two numbers.
fn noise(a: u64, b: u64) -> f64 {
    let mut x = a.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ b.wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    let mut sum = 0.0;
    for _ in 0..4 {
        x ^= x >> 29;
        x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x ^= x >> 32;
        sum += (x >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
    }
    sum * 1.7
}

/// What two effects did to a radar plot: effect, change, unit.
fn effects() -> Vec<(String, f64, String)> {
    [("ground clutter", -5.26, "dB"), ("glint", 3.76, "m")]
        .map(|(name, value, unit)| (name.to_owned(), value, unit.to_owned()))
        .to_vec()
}

/// Whether something becomes so within a minute and a half.
pub(crate) fn soon(mut so: impl FnMut() -> bool) -> bool {
    for _ in 0..900 {
        if so() {
            return true;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    false
}
