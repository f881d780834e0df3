use super::*;
use crate::effects::Level;
use crate::frames::Vector3;
use crate::plot::Callsign;

type Pair = (f64, f64);

/// Targets that move straight from where they are at time zero.
pub(crate) struct Straight {
    pub(crate) class: TargetClass,
    pub(crate) targets: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl Straight {
    /// From (position, velocity), each (east, north).
    pub(crate) fn new(targets: &[(Pair, Pair)]) -> Self {
        let class = TargetClass {
            designator: "CAR".into(),
            aircraft: false,
            length_m: 4.0,
            span_m: 2.0,
            height_m: 3.0,
            rcs_m2: 10.0,
        };
        let vector = |(x, y): Pair| Vector3::new(x, y, 0.0);
        Self { class, targets: targets.iter().map(|&(p, v)| (vector(p), vector(v))).collect() }
    }
}

impl Truth for Straight {
    fn len(&self) -> usize {
        self.targets.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, _: usize) -> &TargetClass {
        &self.class
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (start, velocity_ms) = self.targets[index];
        let position_m = start + velocity_ms * time.s();
        Some(TargetState { position_m, velocity_ms, heading_rad: 0.0 })
    }
}

pub(crate) fn interval(scan: u64, scan_s: f64) -> ScanInterval {
    let time = |n: u64| SimTime::from_s(n as f64 * scan_s);
    ScanInterval { run_seed: 7, scan, from: time(scan - 1), to: time(scan) }
}

fn asde(change: impl FnOnce(&mut AsdeParameters)) -> Asde {
    let mut parameters = AsdeParameters::for_tests();
    change(&mut parameters);
    Asde::new(SensorId(1), Vector2::zeros(), parameters).expect("sound parameters")
}

#[test]
fn every_target_is_seen_once_per_turn_when_the_beam_points_at_it() {
    // Across the starting direction both ways, round the radar, away from it, and standing still.
    let truth = Straight::new(&[
        ((-50.0, 2000.0), (3.0, 0.0)),
        ((50.0, 2000.0), (-3.0, 0.0)),
        ((0.0, 2000.0), (0.0, 0.0)),
        ((0.0, -2000.0), (0.0, 0.0)),
        ((1000.0, 0.0), (0.0, 80.0)),
        ((-900.0, 300.0), (25.0, -3.0)),
    ]);
    for (scan_s, rpm) in [(1.0, 60.0), (0.3, 60.0), (1.0, 41.0), (2.5, 60.0)] {
        let radar = asde(|p| p.rotation_rpm = rpm);
        let scans = (60.0 / scan_s) as u64;
        let mut last = vec![None::<f64>; truth.len()];
        let mut count = vec![0u32; truth.len()];
        let mut looks = Vec::new();
        for scan in 1..=scans {
            let interval = interval(scan, scan_s);
            for index in 0..truth.len() {
                looks.clear();
                radar.looks(&interval, &truth, index, &mut looks);
                for look in &looks {
                    assert!(interval.from < look.time && look.time <= interval.to);
                    let miss = wrap_pi(radar.beam_rad(look.time) - radar.azimuth_rad(&look.state));
                    assert!(miss.abs() < 1e-5, "target {index}: beam off by {miss:e} rad");
                    if let Some(previous) = last[index] {
                        let turn = (look.time.s() - previous) * rpm / 60.0;
                        assert!((turn - 1.0).abs() < 0.05, "target {index}: {turn} turns");
                    }
                    last[index] = Some(look.time.s());
                    count[index] += 1;
                }
            }
        }
        let turns = rpm / 60.0 * scans as f64 * scan_s;
        assert!(count.iter().all(|&n| (f64::from(n) - turns).abs() <= 1.0), "{count:?} of {turns}");
    }
}

#[test]
fn a_plot_tells_where_the_target_was_at_its_own_time() {
    let truth = Straight::new(&[((1500.0, 700.0), (-40.0, 20.0))]);
    let mut radar = asde(|p| {
        p.pfa = 1e-12;
        p.assumed_height_m = 1.5;
    })
    .at_levels(RadarLevels::EXACT.with(RadarEffect::Extent, Level::Skipped));
    let mut out = PlotSink::default();
    for scan in 1..=200 {
        radar.scan(&interval(scan, 0.1), &truth, &Weather::default(), &mut out);
    }
    assert!(out.plots.len() >= 18, "{}", out.plots.len());
    for (plot, cause) in out.plots.iter().zip(&out.causes) {
        let there = truth.at(0, plot.time).expect("exists").position_m.xy();
        assert!((cause.truth_m.expect("known") - there).norm() < 1e-9);
        let miss = plot.position_m - there;
        let (along, across) = (miss.dot(&plot.axis), miss.dot(&plot.across_axis()));
        let squared = along * along / plot.along_m2 + across * across / plot.across_m2;
        assert!(squared < 25.0, "{squared}: {miss:?}");
    }
}

#[test]
fn false_alarms_come_as_often_as_cells_and_probability_say() {
    let mut radar = asde(|p| p.pfa = 1e-5);
    let truth = Straight::new(&[]);
    let mut out = PlotSink::default();
    for scan in 1..=300 {
        radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
    }
    let expected = radar.false_alarms_per(300.0);
    let found = out.plots.len() as f64;
    assert!((found - expected).abs() < 4.0 * expected.sqrt(), "{found} of {expected}");
    assert!(out.causes.iter().all(|cause| cause.key.is_none()));
}

#[test]
fn outside_its_limits_a_parameter_is_refused_with_key_value_and_limits() {
    type Change = fn(&mut AsdeParameters);
    let cases: [(&str, Change); 10] = [
        ("carrier_ghz", |p| p.carrier_ghz = 0.5),
        ("azimuth_beamwidth_deg", |p| p.azimuth_beamwidth_deg = 0.0),
        ("antenna_height_m", |p| p.antenna_height_m = -1.0),
        ("pfa", |p| p.pfa = 0.0),
        ("peak_power_w", |p| p.peak_power_w = f64::NAN),
        ("rotation_rpm", |p| p.rotation_rpm = 0.0),
        ("range_max_m", |p| p.range_max_m = 8000.0),
        ("range_min_m", |p| p.range_min_m = 5.0),
        ("noise_figure_db", |p| p.noise_figure_db = -1.0),
        ("pulses on target (prf, beamwidth, rotation)", |p| p.azimuth_beamwidth_deg = 20.0),
    ];
    for (key, change) in cases {
        let mut parameters = AsdeParameters::for_tests();
        change(&mut parameters);
        let error = parameters.validate().expect_err(key);
        assert!(error.to_string().starts_with(key), "{key}: {error}");
    }
}
