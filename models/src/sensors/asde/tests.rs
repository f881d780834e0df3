use super::*;
use crate::effects::Level;
use crate::frames::Vector3;
use crate::plot::Callsign;
use crate::sensors::radar::equation::{BudgetLevels, Echo, Polarisation};

mod assigned;
mod reckoned;
mod shadows;
mod stated;

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
            shape: crate::sensors::radar::sample_shapes::of(false),
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
        let (start, velocity_mps) = self.targets[index];
        let position_m = start + velocity_mps * time.s();
        Some(TargetState { position_m, velocity_mps, heading_rad: 0.0 })
    }
}

pub(crate) fn interval(scan: u64, scan_s: f64) -> ScanInterval {
    let time = |n: u64| SimTime::from_s(n as f64 * scan_s);
    ScanInterval { run_seed: 7, scan, from: time(scan - 1), to: time(scan) }
}

fn asde(change: impl FnOnce(&mut AsdeParameters)) -> Asde {
    let mut parameters = AsdeParameters::ku_band();
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
                radar.looks(&interval, &radar.sweep(&interval), &truth, index, None, &mut looks);
                for look in looks.iter().filter(|look| look.number != looks::NEXT) {
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
        let mut parameters = AsdeParameters::ku_band();
        change(&mut parameters);
        let error = parameters.validate().expect_err(key);
        assert!(error.to_string().starts_with(key), "{key}: {error}");
    }
}

/// Many targets on a ring round the radar: all at the same ratio.
fn ring(count: u32, ground_m: f64, rcs_m2: f64) -> Straight {
    let place = |i: u32| {
        let (sin, cos) = libm::sincos(f64::from(i) / f64::from(count) * std::f64::consts::TAU);
        ((ground_m * sin, ground_m * cos), (0.0, 0.0))
    };
    let targets: Vec<(Pair, Pair)> = (0..count).map(place).collect();
    let mut truth = Straight::new(&targets);
    truth.class.rcs_m2 = rcs_m2;
    truth
}

fn plain() -> RadarLevels {
    RadarLevels::EXACT
        .with(RadarEffect::Extent, Level::Skipped)
        .with(RadarEffect::Merging, Level::Skipped)
        .with(RadarEffect::FalseAlarms, Level::Skipped)
}

#[test]
fn a_hundred_thousand_plots_deviate_as_the_formulas_say() {
    for energy in [Energy::SinglePulse, Energy::Dwell { factor: 1.5 }] {
        let truth = ring(200, 2000.0, 3.0);
        let mut radar = asde(|p| p.energy = energy).at_levels(plain());
        let mut out = PlotSink::default();
        for scan in 1..=500 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
        }
        assert!(out.plots.len() > 99_000, "{}", out.plots.len());
        let scnr = from_db(out.plots[0].scnr_db.expect("a radar's plot"));
        let (sigma_range_m, sigma_azimuth_rad) = radar.parameters().thermal_sigmas(scnr);
        let (mut range, mut azimuth, mut stated) = (0.0, 0.0, (0.0, 0.0));
        for (plot, cause) in out.plots.iter().zip(&out.causes) {
            let polar = plot.polar.expect("a radar's plot");
            let there = cause.truth_m.expect("known");
            let slant_m = libm::hypot(there.norm(), 60.0 - 1.5);
            stated.0 += polar.sigma_range_m.powi(2);
            stated.1 += polar.sigma_azimuth_rad.powi(2);
            range += (polar.range_m - slant_m).powi(2);
            azimuth += wrap_pi(polar.azimuth_rad - Azimuth::of(there).rad()).powi(2);
        }
        let n = out.plots.len() as f64;
        let (range, azimuth) = ((range / n).sqrt(), (azimuth / n).sqrt());
        assert!((range / sigma_range_m - 1.0).abs() < 0.01, "{range} of {sigma_range_m}");
        assert!((azimuth / sigma_azimuth_rad - 1.0).abs() < 0.01, "{azimuth}");
        // And each states what it deviates by.
        let stated = ((stated.0 / n).sqrt(), (stated.1 / n).sqrt());
        assert!((range / stated.0 - 1.0).abs() < 0.02, "{range} of {stated:?}");
        assert!((azimuth / stated.1 - 1.0).abs() < 0.02, "{azimuth} of {stated:?}");
    }
}

#[test]
fn targets_are_detected_as_often_as_the_formula_says_at_any_scan_length() {
    for (swerling, rcs_m2) in
        [(Swerling::Steady, 0.0028), (Swerling::One, 0.01), (Swerling::Three, 0.006)]
    {
        for scan_s in [1.0, 0.1] {
            let truth = ring(200, 2000.0, rcs_m2);
            let mut radar = asde(|p| {
                p.swerling = swerling;
                // A spread over the scene's surface: no lobes, or the ring would not be one ratio.
                p.roughness_m = 1.0;
            })
            .at_levels(plain());
            let mut out = PlotSink::default();
            for scan in 1..=((100.0 / scan_s) as u64) {
                radar.scan(&interval(scan, scan_s), &truth, &Weather::default(), &mut out);
            }
            let air = radar.air(&Weather::default());
            let echo = Echo { ground_m: 2000.0, height_m: 1.5, extent_m: 3.0, rcs_m2 };
            let to = Vector2::new(0.0, 2000.0);
            let levels = BudgetLevels::EXACT;
            let budget = radar.radar.budget(&air, &levels, &echo, Vector2::zeros(), to);
            let pd = radar.detector.probability(budget.scnr(), swerling);
            assert!(pd > 0.1 && pd < 0.95, "{swerling:?}: {pd}");
            let n = out.looks as f64;
            assert!((n - 20_000.0).abs() < 201.0, "{n} looks");
            let found = out.plots.len() as f64 / n;
            let sigma = (pd * (1.0 - pd) / n).sqrt();
            assert!((found - pd).abs() < 4.0 * sigma, "{swerling:?} {scan_s} s: {found} of {pd}");
        }
    }
}

#[test]
fn a_target_behind_a_hangar_is_lost_and_its_ghost_is_found() {
    let c = Vector2::new;
    let hangar = Building {
        name: "hangar".into(),
        footprint_m: vec![c(-60.0, 800.0), c(60.0, 800.0), c(60.0, 840.0), c(-60.0, 840.0)],
        height_m: 40.0,
        facade: crate::environment::surface::Material::named("metal").expect("known"),
    };
    // One behind the hangar, one before it, one beside.
    let truth = Straight::new(&[
        ((0.0, 900.0), (0.0, 0.0)),
        ((100.0, 300.0), (0.0, 0.0)),
        ((900.0, 0.0), (0.0, 0.0)),
    ]);
    let mut radar = asde(|p| {
        p.pfa = 1e-9;
        p.antenna_height_m = 30.0;
    })
    .among(Arc::new([hangar]))
    .tolerating(Tolerance::EXACT);
    let mut out = PlotSink { explain: true, ..PlotSink::default() };
    for scan in 1..=20 {
        radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
    }
    let of = |key| out.causes.iter().filter(|cause| cause.key == Some(key)).count();
    assert_eq!((of(1), of(2), of(3)), (0, 20, 20));
    let ghosts: Vec<_> = out
        .plots
        .iter()
        .zip(&out.causes)
        .filter(|(_, cause)| cause.effects.iter().any(|e| e.effect == "facade ghosts"))
        .collect();
    assert!(!ghosts.is_empty(), "the target before the hangar is mirrored in it");
    for (plot, _) in ghosts {
        // The double bounce appears 1.3 km away, the mixed path half way between.
        let range_m = plot.position_m.norm();
        assert!((range_m - 800.0).abs() < 20.0 || (range_m - 1304.0).abs() < 20.0, "{range_m}");
    }
    let explained = &out.causes[0].effects;
    assert!(explained.iter().any(|e| e.effect == "surface reflection" && e.unit == "dB"));
    assert!(explained.iter().all(|e| e.value.is_finite()), "{explained:?}");
}

#[test]
fn two_targets_in_one_cell_give_one_plot_between_them() {
    let near = Straight::new(&[((1500.0, 0.0), (0.0, 0.0)), ((1502.0, 1.0), (0.0, 0.0))]);
    let far = Straight::new(&[((1500.0, 0.0), (0.0, 0.0)), ((1510.0, 20.0), (0.0, 0.0))]);
    for (truth, plots) in [(near, 1), (far, 2)] {
        let mut radar = asde(|p| p.pfa = 1e-12);
        let mut out = PlotSink::default();
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
        assert_eq!((out.plots.len(), out.looks), (plots, 2));
        // Nothing planned, everything at its exact level; and without merging, two.
        for (levels, plots) in [(RadarLevels::EXACT, plots), (plain(), 2)] {
            let mut radar = asde(|p| p.pfa = 1e-12).at_levels(levels);
            let mut out = PlotSink::default();
            radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
            assert_eq!((out.plots.len(), out.looks), (plots, 2));
        }
    }
}

#[test]
fn an_echo_from_beyond_the_unambiguous_range_appears_nearer() {
    // 20 kHz: 7.49 km. A landing aircraft at 8.5 km appears at about 1 km.
    let mut truth = Straight::new(&[((0.0, 8500.0), (0.0, 0.0))]);
    truth.class.rcs_m2 = 1e4;
    let mut radar = asde(|p| p.pfa = 1e-12);
    let mut out = PlotSink::default();
    for scan in 1..=5 {
        radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
    }
    assert!(!out.plots.is_empty());
    let range_m = out.plots[0].polar.expect("a radar's plot").range_m;
    assert!((range_m - (8500.0 - 7494.8)).abs() < 5.0, "{range_m}");
}

#[test]
fn cells_and_closed_centroid_see_the_same_aircraft() {
    let mut truth = Straight::new(&[
        ((-1500.0, 900.0), (0.0, 0.0)),
        ((900.0, 1800.0), (0.0, 0.0)),
        ((1200.0, -1100.0), (0.0, 0.0)),
    ]);
    truth.class.aircraft = true;
    truth.class.shape = crate::sensors::radar::sample_shapes::of(true);
    (truth.class.length_m, truth.class.span_m, truth.class.height_m) = (37.6, 35.8, 5.0);
    let run = |processing| {
        let mut radar = asde(|p| p.pfa = 1e-7).at_levels(RadarLevels::EXACT).processing(processing);
        let mut sink = PlotSink::default();
        for scan in 1..=150 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut sink);
        }
        // Mean place and plots of each target, errors along the line of sight.
        let mut found = vec![(0.0, 0.0); 3];
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            if let (Some(key), Some(truth_m)) = (cause.key, cause.truth_m) {
                let along = (plot.position_m - truth_m).dot(&truth_m.normalize());
                let slot = &mut found[key as usize - 1];
                *slot = (slot.0 + along, slot.1 + 1.0);
            }
        }
        found.into_iter().map(|(sum, n)| (sum / n, n)).collect::<Vec<_>>()
    };
    let (closed, cells) = (run(Processing::Plot), run(Processing::Cells));
    for (closed, cells) in closed.into_iter().zip(cells) {
        assert!(cells.1 > 120.0, "{closed:?} {cells:?}");
        assert!(
            (closed.0 - cells.0).abs() < 1.5,
            "mean along the line of sight {closed:?} {cells:?}"
        );
    }
}

/// What the cells show of a target's length and width, averaged over the looks. An airliner's length is right within a third
/// from wherever it is seen (its wings scatter little: the width is a lower bound), and a car is short.
#[test]
fn the_cells_of_an_echo_show_how_large_the_target_is() {
    use crate::fusion::extent::{Extent, Moments};
    // The nose points north.
    for (what, place, aircraft, (length, width), limits) in [
        ("airliner ahead", (0.0, 1500.0), true, (37.6, 35.8), (25.0, 45.0)),
        ("airliner aside", (1500.0, 0.0), true, (37.6, 35.8), (25.0, 45.0)),
        ("airliner askew", (-1000.0, 1000.0), true, (37.6, 35.8), (25.0, 45.0)),
        ("car", (700.0, 700.0), false, (4.6, 1.9), (0.0, 9.0)),
    ] {
        let mut truth = Straight::new(&[(place, (0.0, 0.0))]);
        truth.class.aircraft = aircraft;
        truth.class.shape = crate::sensors::radar::sample_shapes::of(aircraft);
        (truth.class.length_m, truth.class.span_m) = (length, width);
        let mut radar =
            asde(|p| p.pfa = 1e-7).at_levels(RadarLevels::EXACT).processing(Processing::Cells);
        let mut sink = PlotSink::default();
        for scan in 1..=60 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut sink);
        }
        let mut extent = Extent::default();
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let polar = plot.polar.expect("a radar's plot");
            let (Some(seen), Some(_)) = (polar.extent_m2, cause.key) else { continue };
            let (sin, cos) = libm::sincos(polar.azimuth_rad);
            let seen = Moments::turned(Vector2::new(sin, cos), seen);
            extent.learn(&seen, Some(Vector2::new(0.0, 1.0)));
        }
        let (l, w) = extent.size_m().expect("60 looks");
        println!("{what}: {l:.1} by {w:.1} m, is {length} by {width}");
        assert!((limits.0..=limits.1).contains(&l), "{what}: {l:.1} by {w:.1} m");
        assert!(w <= 1.3 * width.max(5.0), "{what}: {l:.1} by {w:.1} m");
    }
}

#[test]
fn echoes_in_one_cell_are_found_across_every_sector_border() {
    // Pairs half a beam apart, all round: each must merge wherever the border between sectors falls.
    let half = 0.125f64.to_radians() * 0.5;
    let mut targets = Vec::new();
    for i in 0..180 {
        let azimuth = (f64::from(i) * 2.0 + 1.0).to_radians() + 0.001 * f64::from(i % 7);
        for side in [-half, half] {
            let (sin, cos) = libm::sincos(azimuth + side);
            targets.push(((2000.0 * sin, 2000.0 * cos), (0.0, 0.0)));
        }
    }
    let truth = Straight::new(&targets);
    let mut radar = asde(|p| p.pfa = 1e-12);
    let mut out = PlotSink::default();
    radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
    assert_eq!((out.looks, out.plots.len()), (360, 180));
}

#[test]
fn two_targets_across_the_end_of_a_scan_are_one_plot_as_anywhere_else() {
    // The beam starts at azimuth 0: pairs on both sides of it, of either order, 1.5 m or 30 m apart.
    // Ten scans a turn have their ends elsewhere; the last pair stands across one of those.
    let tenth = TAU / 10.0;
    for (name, azimuth, swap, apart_m, together) in [
        ("north", 0.0, false, 1.5, true),
        ("north, the later one first", 0.0, true, 1.5, true),
        ("a tenth of a turn", tenth, false, 1.5, true),
        ("apart", 0.0, false, 30.0, false),
    ] {
        let place = |side: f64| {
            let (sin, cos) = libm::sincos(azimuth + side * 0.5 * apart_m / 1500.0);
            ((1500.0 * sin, 1500.0 * cos), (0.0, 0.0))
        };
        let sides = if swap { [1.0, -1.0] } else { [-1.0, 1.0] };
        let truth = Straight::new(&sides.map(place));
        for scan_s in [1.0, 0.1] {
            let mut radar = asde(|p| p.pfa = 1e-12);
            let mut out = PlotSink::default();
            let scans = (20.0 / scan_s) as u64;
            for scan in 1..=scans {
                radar.scan(&interval(scan, scan_s), &truth, &Weather::default(), &mut out);
            }
            // Before the first turn is complete the beam has passed only one of a pair across its start.
            let wanted = if together { 20.0 } else { 40.0 };
            let found = out.plots.len() as f64;
            assert!((found - wanted).abs() <= 1.0, "{name}, {scan_s} s: {found} plots");
            if together {
                let amid = |plot: &Plot| {
                    let off = wrap_pi(plot.polar.expect("a radar's plot").azimuth_rad - azimuth);
                    off.abs() * 1500.0 < 3.0
                };
                assert!(out.plots.iter().all(amid), "{name}");
            }
        }
    }
}

/// Root mean square error per axis of the plots of targets alone, and plots per look.
fn errors_of(pulse_s: f64, truth: &Straight, processing: Processing, scans: u64) -> (f64, f64) {
    let levels = RadarLevels::EXACT
        .with(RadarEffect::Merging, Level::Skipped)
        .with(RadarEffect::AircraftShadow, Level::Skipped);
    let pulse = |p: &mut AsdeParameters| {
        (p.pulse_s, p.bandwidth_hz) = (pulse_s, 1.0 / pulse_s);
        p.range_min_m = 200.0;
    };
    let mut radar = asde(pulse).at_levels(levels).processing(processing);
    let (mut sum, mut count, mut looks) = (0.0, 0.0, 0);
    for scan in 1..=scans {
        let mut sink = PlotSink::default();
        radar.scan(&interval(scan, 1.0), truth, &Weather::default(), &mut sink);
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            if let Some(truth_m) = cause.truth_m {
                sum += (plot.position_m - truth_m).norm_squared();
                count += 1.0;
            }
        }
        looks += sink.looks;
    }
    ((0.5 * sum / count).sqrt(), count / looks as f64)
}

#[test]
fn plot_level_errs_like_the_cells_within_what_the_plan_says() {
    for (name, pulse_s, aircraft, length_m, span_m, rcs_m2) in [
        ("car", 36e-9, false, 4.8, 2.0, 5.0),
        ("car, long pulse", 100e-9, false, 4.8, 2.0, 5.0),
        ("light aircraft", 36e-9, true, 8.3, 11.0, 3.0),
        ("narrow body", 36e-9, true, 37.6, 35.8, 20.0),
        ("narrow body, long pulse", 100e-9, true, 37.6, 35.8, 20.0),
        ("wide body", 36e-9, true, 70.7, 64.4, 60.0),
    ] {
        for ground_m in [600.0, 1500.0, 3000.0] {
            // Eight cells of range, so that every place within a cell and every aspect comes.
            let mut truth = ring(144, ground_m, rcs_m2);
            for (i, (place_m, _)) in truth.targets.iter_mut().enumerate() {
                *place_m *= 1.0 + 0.3 * i as f64 / ground_m;
            }
            truth.class.aircraft = aircraft;
            truth.class.shape = crate::sensors::radar::sample_shapes::of(aircraft);
            (truth.class.length_m, truth.class.span_m) = (length_m, span_m);
            let (plot, plots) = errors_of(pulse_s, &truth, Processing::Plot, 16);
            let (cells, in_cells) = errors_of(pulse_s, &truth, Processing::Cells, 16);
            let mut radar = asde(|p| (p.pulse_s, p.range_min_m) = (pulse_s, 200.0));
            radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
            let row = radar.plan().last().expect("a plan").clone();
            let differ = (plot - cells).abs();
            println!(
                "{name} at {ground_m} m: {plot:.3} and {cells:.3} m, {:.3} allowed",
                row.bound
            );
            assert_eq!((row.effect, row.unit), ("signal processing", "m"));
            assert!(differ <= row.bound, "{name} at {ground_m} m: {differ} of {}", row.bound);
            assert!((plots - in_cells).abs() < 0.01, "{name}: {plots} and {in_cells} plots a look");
        }
    }
}

#[test]
fn cells_detect_a_point_as_often_as_the_formula_within_a_few_percent() {
    // The cells lose by straddling and the beam's shape what the budget's losses had counted for it.
    for (swerling, most) in
        [(Swerling::Steady, 0.06), (Swerling::One, 0.03), (Swerling::Three, 0.03)]
    {
        for rcs_m2 in [0.002, 0.003, 0.005, 0.02] {
            let truth = ring(200, 2000.0, rcs_m2);
            let share = |processing| {
                let mut radar = asde(|p| {
                    p.swerling = swerling;
                    p.roughness_m = 1.0;
                })
                .at_levels(plain())
                .processing(processing);
                let mut out = PlotSink::default();
                for scan in 1..=30 {
                    radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
                }
                out.plots.len() as f64 / out.looks as f64
            };
            let (plot, cells) = (share(Processing::Plot), share(Processing::Cells));
            assert!((plot - cells).abs() < most, "{swerling:?} {rcs_m2} m²: {plot} and {cells}");
        }
    }
}

#[test]
fn windows_and_video_find_the_same_plots_with_the_same_draws() {
    // Aircraft alone, two that touch, one across the beam's start; no false alarms in so few cells.
    let mut truth = Straight::new(&[
        ((400.0, 700.0), (8.0, 0.0)),
        ((-900.0, 300.0), (0.0, 9.0)),
        ((-910.0, 330.0), (0.0, 9.0)),
        ((2.0, 1100.0), (0.0, 0.0)),
        ((300.0, -1200.0), (10.0, 3.0)),
    ]);
    truth.class.aircraft = true;
    truth.class.shape = crate::sensors::radar::sample_shapes::of(true);
    (truth.class.length_m, truth.class.span_m, truth.class.height_m) = (37.6, 35.8, 5.0);
    // On the ground behind an aircraft the video has its shadow, the window has not.
    for (scan_s, swerling, ground) in [
        (1.0, Swerling::One, Level::Skipped),
        (0.25, Swerling::Steady, Level::Skipped),
        (1.0, Swerling::One, Level::Exact),
    ] {
        let run = |processing| {
            let mut radar = asde(|p| {
                p.range_max_m = 1500.0;
                p.pfa = 1e-9;
                p.swerling = swerling;
            })
            .at_levels(RadarLevels::EXACT.with(RadarEffect::GroundClutter, ground))
            .processing(processing);
            let mut sink = PlotSink::default();
            for scan in 1..=(12.0 / scan_s) as u64 {
                radar.scan(&interval(scan, scan_s), &truth, &Weather::default(), &mut sink);
            }
            let keyed = sink.plots.iter().zip(&sink.causes);
            let mut found: Vec<_> =
                keyed.filter_map(|(p, c)| Some((c.key?, p.time, p.position_m))).collect();
            found.sort_by_key(|f| (f.0, f.1));
            found
        };
        let (windows, video) = (run(Processing::Cells), run(Processing::Video));
        assert!(windows.len() > 40, "{}", windows.len());
        let (near_m, most) = if ground == Level::Skipped { (1e-9, 0) } else { (0.3, 2) };
        let apart: Vec<f64> = windows
            .iter()
            .filter_map(|a| Some((a, video.iter().find(|b| (a.0, a.1) == (b.0, b.1))?)))
            .map(|(a, b)| (a.2 - b.2).norm())
            .collect();
        let (all, worst_m) = (apart.len(), apart.iter().copied().fold(0.0, f64::max));
        let rms_m = (apart.iter().map(|d| d * d).sum::<f64>() / all as f64).sqrt();
        println!("{scan_s} s, ground {ground:?}: {rms_m} m rms, {worst_m} m worst, {all} plots");
        assert!(worst_m <= near_m && rms_m <= 0.3 * near_m, "{rms_m} m, {worst_m} m");
        assert!(windows.len() - all <= most && video.len() - all <= most);
    }
}

#[test]
fn the_video_makes_its_false_alarms_of_noise() {
    let mut radar = asde(|p| {
        p.pfa = 1e-4;
        p.range_max_m = 2000.0;
    })
    .at_levels(RadarLevels::EXACT)
    .processing(Processing::Video);
    let truth = Straight::new(&[]);
    let mut out = PlotSink::default();
    for scan in 1..=20 {
        radar.scan(&interval(scan, 0.5), &truth, &Weather::default(), &mut out);
    }
    // Cells near each other make one plot: a little less than cells times probability.
    let expected = radar.false_alarms_per(10.0);
    let found = out.plots.len() as f64;
    assert!(found < expected + 4.0 * expected.sqrt(), "{found} of {expected}");
    assert!(found > 0.98 * expected - 4.0 * expected.sqrt(), "{found} of {expected}");
    for plot in &out.plots {
        let turns = plot.time.s();
        let azimuth = (turns - turns.floor()) * TAU;
        let off = wrap_pi(plot.polar.expect("a radar's plot").azimuth_rad - azimuth);
        assert!(off.abs() < 1e-6, "{off}");
    }
}

#[test]
fn only_the_scene_asks_for_cells() {
    let truth = Straight::new(&[((1500.0, 0.0), (0.0, 0.0))]);
    let row = |tolerance: Tolerance, asked: Option<Processing>| {
        let mut radar = asde(|_| ()).tolerating(tolerance);
        if let Some(asked) = asked {
            radar = radar.processing(asked);
        }
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
        let counted = radar.tally().of(RadarEffect::Processing) > 0;
        let row = radar.plan().last().expect("a plan").clone();
        assert_eq!(counted, row.level > Level::Cheap);
        (row.level, row.called_for)
    };
    // Two processings draw differently: no tolerance on plots of the same draws can choose between them.
    assert_eq!(row(Tolerance::default(), None).0, Level::Cheap);
    assert_eq!(row(Tolerance::EXACT, None).0, Level::Cheap);
    let cells = row(Tolerance::default(), Some(Processing::Cells));
    assert_eq!(cells, (Level::Middle, "the scene asks for \"cells\"".into()));
    let video = row(Tolerance::default(), Some(Processing::Video));
    assert_eq!(video, (Level::Exact, "the scene asks for \"video\"".into()));
}

/// The levels at which the target of a key was simulated.
fn levels_of(radar: &Asde, truth: &Straight, key: u64) -> Option<RadarLevels> {
    let index = (0..truth.len()).find(|i| truth.key(*i) == key)?;
    let placed = radar.placed().iter().find(|p| p.index == index)?;
    placed.place.map(|p| radar.boxes()[p as usize].plan.levels)
}

#[test]
fn where_nothing_may_move_nothing_does_though_detection_may_change() {
    // Far off in a wide beam the arc of a plot is bent by what it states of its errors, and that by how strong a look was:
    // a table of the detection would move it by micrometres.
    let truth = Straight::new(&[((2500.0, 2500.0), (0.0, 0.0)), ((-3500.0, 900.0), (0.0, 0.0))]);
    let plots = |levels: Option<RadarLevels>, position_m: f64| {
        let mut radar = asde(|p| {
            (p.azimuth_beamwidth_deg, p.prf_hz, p.swerling) = (2.0, 5000.0, Swerling::One);
            (p.peak_power_w, p.range_step_m, p.azimuth_step_deg) =
                (0.02 * p.peak_power_w, 0.0, 0.0);
        })
        .tolerating(Tolerance { position_m, tail: 0.1, ..Tolerance::default() });
        radar.fixed = levels;
        let mut out = PlotSink::default();
        for scan in 1..=200 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
        }
        out.plots.iter().map(|plot| (plot.time, plot.position_m)).collect::<Vec<_>>()
    };
    let exact = plots(Some(RadarLevels::EXACT), 0.0);
    assert!(exact.len() > 200, "{}", exact.len());
    assert_eq!(plots(None, 0.0), exact);
    assert_ne!(plots(None, 0.1), exact, "what may move does");
}

#[test]
fn a_target_at_the_towers_foot_changes_nothing_for_one_far_away() {
    let far = ((900.0, 900.0), (0.0, 0.0));
    let alone = Straight::new(&[far]);
    let mut radar = asde(|_| ());
    let scan = |radar: &mut Asde, truth: &Straight| {
        radar.scan(&interval(1, 1.0), truth, &Weather::default(), &mut PlotSink::default());
    };
    scan(&mut radar, &alone);
    let before = levels_of(&radar, &alone, 1).expect("planned");
    assert!(before != radar.base_levels(), "something is left out");
    for near in [30.0, 70.0, 130.0, 250.0] {
        let both = Straight::new(&[far, ((near, 0.0), (0.0, 0.0))]);
        let mut radar = asde(|_| ());
        scan(&mut radar, &both);
        assert_eq!(levels_of(&radar, &both, 1), Some(before), "the other at {near} m");
    }
}

#[test]
fn a_plan_is_the_same_for_targets_in_any_order_and_planned_in_parts() {
    let spiral = |i: usize| {
        let (sin, cos) = libm::sincos(i as f64 * 2.4);
        let r = 150.0 * libm::exp(i as f64 * 0.08);
        ((r * sin, r * cos), (0.0, 0.0))
    };
    let all: Vec<(Pair, Pair)> = (0..40).map(spiral).collect();
    let plans = |order: &[usize]| -> Vec<Option<RadarLevels>> {
        let truth = Straight::new(&order.iter().map(|i| all[*i]).collect::<Vec<_>>());
        let mut radar = asde(|p| p.polarisation = Polarisation::Vertical);
        let mut planned = 0;
        for _ in 0..5 {
            radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
            let now = radar.boxes().len();
            assert!(now - planned <= plan::planner::MOST_NEW, "{now} after {planned}");
            planned = now;
        }
        let place = |i: usize| order.iter().position(|o| *o == i).expect("in the order") as u64;
        (0..all.len()).map(|i| levels_of(&radar, &truth, place(i) + 1)).collect()
    };
    let forward: Vec<usize> = (0..all.len()).collect();
    let backward: Vec<usize> = forward.iter().rev().copied().collect();
    let found = plans(&forward);
    assert!(found.iter().filter(|f| f.is_some()).count() > 30, "{found:?}");
    assert_eq!(found, plans(&backward));
}

#[test]
fn rings_are_cut_where_parts_leave_out_more_and_their_own_plan_holds_until_then() {
    let spiral = |i: usize| {
        let (sin, cos) = libm::sincos(i as f64 * 2.4);
        let r = 150.0 * libm::exp(i as f64 * 0.045);
        ((r * sin, r * cos), (0.0, 0.0))
    };
    let truth = Straight::new(&(0..60).map(spiral).collect::<Vec<_>>());
    let storm = Weather { rain_mm_per_h: 20.0, film_mm: 0.5, ..Weather::default() };
    let mut sink = PlotSink::default();
    let (mut by_ring, mut in_parts, mut saved_ns) = (0, 0, 0);
    for power in [1.0, 0.1, 0.01, 1e-3] {
        let mut radar = asde(|p| p.peak_power_w *= power);
        let mut planned = 0;
        for scan in 1..=12 {
            radar.scan(&interval(scan, 1.0), &truth, &storm, &mut sink);
            let boxes = radar.boxes();
            assert!(boxes.len() - planned <= plan::planner::MOST_NEW);
            planned = boxes.len();
            for placed in radar.placed() {
                let Some(place) = placed.place else { continue };
                let found = &boxes[place as usize];
                let state = truth.at(placed.index, SimTime(0)).expect("it stands");
                let (near, far) = found.key.ground_m();
                let d = state.position_m.xy().norm();
                assert!(d >= near * (1.0 - 1e-9) && d <= far * (1.0 + 1e-9), "{d} m in {found:?}");
                by_ring += usize::from(found.parted);
            }
        }
        // All parts that are asked for are there, and take the ring's place.
        let boxes = radar.boxes();
        assert_eq!(radar.planner().waiting(), 0);
        let of = |part: bool| boxes.iter().filter(move |b| (b.key.part > 0) == part);
        assert!(of(true).all(|b| boxes.iter().any(|w| w.parted && w.key == b.key.whole())));
        assert!(!boxes.iter().any(|b| b.parted && b.targets > 0), "a part takes the ring's place");
        assert!(of(true).all(|b| b.plan.share <= 1.0 + 1e-9));
        in_parts += of(true).filter(|b| b.targets > 0).count();
        for whole in of(false) {
            let parts = of(true).filter(|b| b.key.whole() == whole.key);
            let saved =
                |b: &plan::PlannedBox| whole.plan.cost_ns().0.saturating_sub(b.plan.cost_ns().0);
            saved_ns += parts.map(saved).max().unwrap_or(0);
        }
    }
    assert!(in_parts > 10 && saved_ns > 30, "{in_parts} boxes of parts, {saved_ns} ns");
    assert!(by_ring > 0, "while parts waited, the ring's plan held");

    // With a budget of time a ring's plan is the front of one factor.
    let budget = Tolerance { time_budget_us: Some(20.0), ..Tolerance::default() };
    let mut radar = asde(|_| ()).tolerating(budget);
    for scan in 1..=3 {
        radar.scan(&interval(scan, 1.0), &truth, &storm, &mut sink);
    }
    assert!(radar.boxes().len() > 5 && radar.boxes().iter().all(|b| b.key.part == 0));
}

#[test]
fn a_target_that_is_not_displayed_is_simulated_for_nobody() {
    let far = asde(|_| ()).parameters().range_max_m + 500.0;
    let (dark, near) = (((far, 0.0), (0.0, 0.0)), ((900.0, 900.0), (0.0, 0.0)));
    let foot = ((60.0, 0.0), (0.0, 0.0));
    let scan = |targets: &[(Pair, Pair)], nearest_m: f64| {
        let mut radar = asde(|p| p.range_min_m = nearest_m);
        let truth = Straight::new(targets);
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
        let shown: Vec<bool> = radar.placed().iter().map(|p| p.shown).collect();
        let levels = radar.plan().iter().map(|row| (row.effect, row.level)).collect::<Vec<_>>();
        (shown, levels)
    };
    let (shown, alone) = scan(&[near], 300.0);
    assert_eq!(shown, [true]);
    let (shown, levels) = scan(&[near, dark, foot], 300.0);
    assert_eq!(shown, [true, false, false]);
    assert_eq!(levels, alone, "nobody's plan changes");
    // Displayed at the foot of the tower: everything is exact for it.
    let (shown, levels) = scan(&[near, foot], 25.0);
    assert_eq!(shown, [true, true]);
    assert_ne!(levels, alone);
}

#[test]
fn a_target_that_is_displayed_has_its_plots_at_the_edge_too() {
    // The centre of an echo lies before the middle of a body, and wanders.
    let mut car = Straight::new(&[((0.0, 901.4), (0.0, 0.0))]);
    let mut aircraft = Straight::new(&[((0.0, 903.0), (0.0, 0.0))]);
    aircraft.class = crate::sensors::testing::class(true, 37.6, 35.8, 20.0);
    for truth in [&mut car, &mut aircraft] {
        let slant_m = libm::hypot(truth.targets[0].0.y, 42.7 - 0.5 * truth.class.height_m);
        for (near_m, far_m) in
            [(slant_m - 0.01, 5e3), (slant_m - 0.9, 5e3), (200.0, slant_m + 0.01)]
        {
            for levels in [None, Some(RadarLevels::EXACT)] {
                let mut radar = asde(|p| {
                    (p.range_min_m, p.range_max_m, p.pfa) = (near_m, far_m, 1e-12);
                    (p.range_step_m, p.antenna_height_m) = (0.0, 42.7);
                });
                radar.fixed = levels;
                let mut out = PlotSink::default();
                for scan in 1..=50 {
                    radar.scan(&interval(scan, 1.0), truth, &Weather::default(), &mut out);
                }
                assert_eq!(out.plots.len(), 50, "{near_m} to {far_m} m, {levels:?}");
                for plot in &out.plots {
                    let range_m = plot.polar.expect("of a radar").range_m;
                    assert!(near_m <= range_m && range_m <= far_m, "{range_m} is displayed");
                }
            }
        }
        // And one that is just not has none.
        let mut radar = asde(|p| {
            (p.range_min_m, p.pfa, p.antenna_height_m) = (slant_m + 0.01, 1e-12, 42.7);
        });
        let mut out = PlotSink::default();
        for scan in 1..=50 {
            radar.scan(&interval(scan, 1.0), truth, &Weather::default(), &mut out);
        }
        assert_eq!(out.plots.len(), 0);
    }
}

#[test]
fn rain_without_cells_costs_no_walk_through_cells() {
    let truth = Straight::new(&[((900.0, 900.0), (0.0, 0.0))]);
    let cost = |weather: &Weather| {
        let mut radar = asde(|_| ());
        radar.scan(&interval(1, 1.0), &truth, weather, &mut PlotSink::default());
        let effects = radar.boxes()[0].plan.effects.clone();
        let own = effects.iter().find(|e| e.effect == RadarEffect::RainAttenuation);
        let row = radar.plan().iter().find(|r| r.effect == RadarEffect::RainAttenuation.name());
        (own.expect("an effect").exact_ns, row.expect("a row").cost_ns)
    };
    let rain = Weather { rain_mm_per_h: 40.0, ..Weather::default() };
    let cell = crate::environment::RainCell {
        centre_m: Vector2::new(500.0, 500.0),
        radius_m: 300.0,
        rain_mm_per_h: 80.0,
    };
    let (plain, row_ns) = cost(&rain);
    let (cells, _) = cost(&Weather { cells: vec![cell], ..rain });
    assert!(plain < 10 && row_ns < 10.0 && cells > 50, "{plain} ns, {row_ns} ns, {cells} ns");
}

#[test]
fn what_the_plan_of_a_box_leaves_out_is_not_evaluated() {
    let mut left_out = 0;
    for (n, tolerance) in [0.1, 0.5, 3.0].into_iter().enumerate() {
        let truth = Straight::new(&[((300.0 * (n + 1) as f64, 500.0), (0.0, 0.0))]);
        let tolerance = Tolerance { position_m: tolerance, ..Tolerance::default() };
        // Without false alarms, which are always quantised.
        let mut radar = asde(|p| p.pfa = 1e-12).tolerating(tolerance);
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
        let tally = radar.tally().clone();
        let place = radar.placed()[0].place.expect("planned") as usize;
        for effect in &radar.boxes()[place].plan.effects {
            if effect.level == Level::Skipped {
                left_out += 1;
                assert_eq!(tally.of(effect.effect), 0, "{}", effect.effect.name());
            }
        }
    }
    assert!(left_out > 15, "{left_out}");
}

#[test]
fn a_shadow_is_named_for_what_casts_it() {
    let mut truth = Straight::new(&[((0.9, 1000.0), (0.0, 0.0)), ((0.0, 1200.0), (0.0, 0.0))]);
    truth.class.aircraft = true;
    truth.class.shape = crate::sensors::radar::sample_shapes::of(true);
    (truth.class.length_m, truth.class.span_m, truth.class.height_m) = (37.6, 35.8, 11.8);
    let corner = |x: f64, y: f64| Vector2::new(x, y);
    let hangar = Building {
        name: "hangar".into(),
        footprint_m: vec![corner(-9.0, 600.0), corner(9.0, 600.0), corner(9.0, 620.0)],
        height_m: 11.0,
        facade: &crate::environment::surface::MATERIALS[5],
    };
    let shadows_of_last = |buildings: Vec<Building>| -> Vec<&'static str> {
        let low = |p: &mut AsdeParameters| {
            (p.antenna_height_m, p.peak_power_w) = (15.0, 1e8);
        };
        let mut radar = asde(low).among(buildings.into());
        let mut out = PlotSink { explain: true, ..PlotSink::default() };
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
        let last = out.causes.iter().find(|c| c.key == Some(2)).expect("the one behind is seen");
        let shadows = last.effects.iter().filter(|e| e.effect.ends_with("shadow"));
        shadows.inspect(|e| assert!(e.value < 0.0, "{e:?}")).map(|e| e.effect).collect()
    };
    assert_eq!(shadows_of_last(vec![]), ["aircraft shadow"]);
    assert_eq!(shadows_of_last(vec![hangar]), ["building shadow", "aircraft shadow"]);
}
