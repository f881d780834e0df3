//! What stands in the way costs an echo its loss twice: on the way out and on the way back.

use super::*;
use crate::frames::Point2;
use crate::sensors::radar::detection::Swerling;

/// Strength of the echo of a steady target at 1200 m, dB, behind other targets or buildings; everything exact.
fn strength_db(truth: &Straight, key: u64, antenna_m: f64, buildings: Vec<Building>) -> f64 {
    let mut radar = asde(|p| {
        (p.antenna_height_m, p.assumed_height_m) = (antenna_m, 1.5);
        (p.peak_power_w, p.swerling, p.pfa) = (1e8, Swerling::Steady, 1e-12);
    })
    .among(buildings.into())
    .at_levels(plain());
    let mut out = PlotSink::default();
    radar.scan(&interval(1, 1.0), truth, &Weather::default(), &mut out);
    let own = out.causes.iter().position(|c| c.key == Some(key)).expect("strong enough");
    out.plots[own].scnr_db.expect("a radar's plot")
}

/// A wall half a metre thick across the way, `top_m` high.
fn wall(north_m: f64, top_m: f64) -> Building {
    let corner = |x: f64, y: f64| Point2::new(x, north_m + y);
    Building {
        name: "wall".into(),
        footprint_m: vec![
            corner(-200.0, 0.0),
            corner(200.0, 0.0),
            corner(200.0, 0.5),
            corner(-200.0, 0.5),
        ],
        height_m: top_m,
        facade: &crate::environment::surface::MATERIALS[0],
    }
}

#[test]
fn an_edge_on_the_line_of_sight_costs_six_decibels_each_way() {
    // Half of the field passes an edge that the straight line touches: 6.0 dB (ITU-R P.526), 12.1 dB there and back.
    let truth = Straight::new(&[((0.0, 1200.0), (0.0, 0.0))]);
    for (antenna_m, north_m) in [(15.0, 600.0), (40.0, 300.0), (25.0, 1000.0)] {
        let on_the_line = antenna_m + (1.5 - antenna_m) * north_m / 1200.0;
        let free = strength_db(&truth, 1, antenna_m, vec![]);
        let behind = strength_db(&truth, 1, antenna_m, vec![wall(north_m, on_the_line)]);
        assert!((free - behind - 12.06).abs() < 0.3, "{antenna_m} m: {free} {behind} dB");
        // Far above it the line is free.
        let low = strength_db(&truth, 1, antenna_m, vec![wall(north_m, 0.1)]);
        assert!((free - low).abs() < 0.1, "{antenna_m} m: {free} {low} dB");
    }
}

#[test]
fn an_aircraft_before_an_echo_costs_its_loss_twice() {
    let mut truth = Straight::new(&[((0.3, 600.0), (0.0, 0.0)), ((0.0, 1200.0), (0.0, 0.0))]);
    truth.class.aircraft = true;
    (truth.class.length_m, truth.class.span_m, truth.class.height_m) = (37.6, 35.8, 11.8);
    let mut alone = Straight::new(&[((900.0, -600.0), (0.0, 0.0)), ((0.0, 1200.0), (0.0, 0.0))]);
    alone.class = truth.class.clone();
    for antenna_m in [5.0, 6.0] {
        let line = crate::sensors::radar::shadow::SightLine {
            site_m: Point2::origin(),
            antenna_m,
            target_m: Point2::new(0.0, 1200.0),
            height_m: 0.5 * 11.8,
            wavelength_m: asde(|_| ()).radar.wavelength_m,
        };
        let place_m = Point2::new(0.3, 600.0);
        let parts = crate::sensors::radar::shadow::aircraft_obstacles(place_m, 0.0, 37.6, 11.8);
        let once_db = parts
            .iter()
            .map(|(corners, top_m)| line.behind(corners, *top_m).loss_db)
            .fold(0.0, f64::max);
        assert!(once_db > 1.0, "{once_db} dB: nothing in the way");
        let lost =
            strength_db(&alone, 2, antenna_m, vec![]) - strength_db(&truth, 2, antenna_m, vec![]);
        assert!((lost - 2.0 * once_db).abs() < 0.02, "{antenna_m} m: {lost} of twice {once_db} dB");
    }
}

/// A hangar of metal 800 m north of the radar.
fn hangar() -> Building {
    let c = Point2::new;
    Building {
        name: "hangar".into(),
        footprint_m: vec![c(-60.0, 800.0), c(60.0, 800.0), c(60.0, 840.0), c(-60.0, 840.0)],
        height_m: 40.0,
        facade: crate::environment::surface::Material::named("metal").expect("known"),
    }
}

#[test]
fn a_target_behind_a_hangar_is_lost_and_its_ghost_is_found() {
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
    .among(Arc::new([hangar()]))
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
        let range_m = plot.position_m.coords.norm();
        assert!((range_m - 800.0).abs() < 20.0 || (range_m - 1304.0).abs() < 20.0, "{range_m}");
    }
    let explained = &out.causes[0].effects;
    assert!(explained.iter().any(|e| e.effect == "surface reflection" && e.unit == "dB"));
    assert!(explained.iter().all(|e| e.value.is_finite()), "{explained:?}");
}

/// A scan of four turns has the ghosts of four turns, as it has their plots; it had those of the first.
#[test]
fn ghosts_come_with_every_turn_of_a_scan() {
    let truth = Straight::new(&[((100.0, 300.0), (0.0, 0.0))]);
    let seen = |scan_s: f64| {
        let mut radar = asde(|p| {
            p.pfa = 1e-9;
            p.antenna_height_m = 30.0;
        })
        .among(Arc::new([hangar()]))
        .tolerating(Tolerance::EXACT);
        let mut out = PlotSink { explain: true, ..PlotSink::default() };
        for scan in 1..=(40.0 / scan_s) as u64 {
            radar.scan(&interval(scan, scan_s), &truth, &Weather::default(), &mut out);
        }
        let is_ghost = |effects: &[crate::sensors::Contribution]| {
            effects.iter().any(|e| e.effect == "facade ghosts")
        };
        let ghosts = out.causes.iter().filter(|cause| is_ghost(&cause.effects)).count();
        (ghosts, out.plots.len() - ghosts)
    };
    let [once, often] = [1.0, 4.0].map(seen);
    assert_eq!(once.1, often.1, "plots of the target");
    assert!(once.0 >= 20 && often.0.abs_diff(once.0) <= once.0 / 4, "{once:?} {often:?}");
}

/// An aircraft stands before what is farther than half its length behind it, in its direction and on the ground.
#[test]
fn who_is_half_a_length_nearer_stands_before_another() {
    for (behind_m, aside_m, up_m, before) in [
        (17.0, 0.0, 0.0, 0),
        (20.0, 0.0, 0.0, 1),
        (300.0, 0.0, 0.0, 1),
        (300.0, 28.0, 0.0, 0),
        (300.0, 24.0, 0.0, 1),
        (300.0, 0.0, 12.0, 0),
    ] {
        let mut truth = Straight::new(&[
            ((0.0, 1000.0), (0.0, 0.0)),
            ((aside_m, 1000.0 + behind_m), (0.0, 0.0)),
        ]);
        truth.class.aircraft = true;
        (truth.class.length_m, truth.class.height_m) = (37.6, 11.8);
        truth.targets[0].0.z = up_m;
        let mut radar = asde(|p| p.antenna_height_m = 15.0).at_levels(RadarLevels::EXACT);
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
        let found = radar.tally().of(RadarEffect::AircraftShadow);
        assert_eq!(found, before, "{behind_m} m behind, {aside_m} m aside, {up_m} m up");
    }
}
