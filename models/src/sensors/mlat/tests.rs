use super::*;
use crate::sensors::testing::Parked;
use crate::time::SimTime;

fn square() -> Vec<Point2<f64>> {
    [(0.0, 0.0), (4000.0, 0.0), (4000.0, 2500.0), (0.0, 2500.0), (2000.0, -500.0)]
        .map(|(x, y)| Point2::new(x, y))
        .to_vec()
}

fn scan(config: &MlatConfig, truth: &Parked) -> PlotSink {
    let mut mlat = Mlat::new(config.clone()).expect("sound");
    let mut sink = PlotSink::default();
    let (from, to) = (SimTime::ZERO, SimTime::from_s(1.0));
    let interval = ScanInterval { run_seed: 8, scan: 1, from, to };
    mlat.scan(&interval, truth, &Weather::default(), &mut sink);
    sink
}

#[test]
fn hard_geometries_give_no_position() {
    let at = |x, y| Point2::new(x, y);
    for (name, stations, target, fix) in [
        ("no stations", vec![], at(0.0, 0.0), false),
        ("two stations", square()[..2].to_vec(), at(10.0, 20.0), false),
        ("one station thrice", vec![at(0.0, 0.0); 3], at(10.0, 20.0), false),
        (
            "three on one side, in line with the target",
            vec![at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0)],
            at(9.0, 0.0),
            false,
        ),
        ("target far outside", square(), at(1e12, 1e12), false),
        ("target on a station", square(), at(0.0, 0.0), true),
        ("inside", square(), at(1500.0, 900.0), true),
    ] {
        let geometry = ArrivalGeometry::of(&stations, target);
        assert_eq!(geometry.is_some(), fix, "{name}: {geometry:?}");
        assert!(geometry.is_none_or(|g| g.horizontal().is_finite()), "{name}");
    }
}

#[test]
fn errors_have_the_covariance_that_is_reported() {
    let keys: Vec<u64> = (0..20).collect();
    let config = MlatConfig {
        multipath: 0.0,
        report_s: 0.01,
        ..MlatConfig::with_stations(SensorId(1), &square())
    };
    let sink = scan(&config, &Parked::aircraft(&keys));
    let (mut sum, mut n) = (0.0, 0.0);
    for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
        let error = plot.position_m - cause.truth_m.expect("a target");
        let (along, across) = (error.dot(&plot.axis), error.dot(&plot.across_axis()));
        sum += along * along / plot.along_m2 + across * across / plot.across_m2;
        n += 1.0;
    }
    assert!(n > 1900.0, "{n}");
    assert!((sum / n - 2.0).abs() < 4.0 * 2.0 / f64::sqrt(n), "{}", sum / n);
}

#[test]
fn multipath_is_a_one_sided_tail() {
    let keys: Vec<u64> = (0..20).collect();
    let config = MlatConfig {
        multipath: 1.0,
        reception: 1.0,
        sigma_t_s: 1e-12,
        report_s: 0.01,
        stations: MlatConfig::with_stations(SensorId(1), &square()).stations,
        ..MlatConfig::with_stations(SensorId(1), &square())
    };
    let sink = scan(&config, &Parked::aircraft(&keys));
    assert_eq!(sink.plots.len(), 2000);
    let mean = sink
        .plots
        .iter()
        .zip(&sink.causes)
        .map(|(p, c)| (p.position_m - c.truth_m.expect("a target")).norm())
        .sum::<f64>()
        / 2000.0;
    assert!(mean > 5.0 && mean < 30.0, "{mean}");
}

#[test]
fn a_blind_sector_hides_what_is_behind_it() {
    let sector = BlindSector { from_deg: 350.0, to_deg: 10.0, beyond_m: 100.0 };
    let station = Station {
        position_m: Point2::origin(),
        height_m: 15.0,
        range_m: 1000.0,
        blind: vec![sector],
    };
    for (name, x, y, heard) in [
        ("behind", 0.0, 200.0, false),
        ("before", 0.0, 90.0, true),
        ("beside", 100.0, 200.0, true),
        ("opposite", 0.0, -200.0, true),
        ("too far", -2000.0, 0.0, false),
    ] {
        assert_eq!(station.hears(Point2::new(x, y)), heard, "{name}");
    }
    // All round.
    for (from_deg, to_deg, beyond_m) in [(0.0, 360.0, 0.0), (-180.0, 180.0, 100.0)] {
        let blind = vec![BlindSector { from_deg, to_deg, beyond_m }];
        let station = Station { blind, ..station.clone() };
        for step in 0..36 {
            let (sin, cos) = libm::sincos(f64::from(step) * 10.0_f64.to_radians());
            let heard = |away_m: f64| station.hears(Point2::new(away_m * sin, away_m * cos));
            assert!(!heard(200.0), "{from_deg} to {to_deg}, {step}");
            assert_eq!(heard(90.0), beyond_m > 90.0, "{from_deg} to {to_deg}, {step}");
        }
    }
    let c = Point2::new;
    let hangar = Building {
        name: "hangar".into(),
        footprint_m: vec![c(-40.0, 100.0), c(40.0, 100.0), c(40.0, 140.0), c(-40.0, 140.0)],
        height_m: 20.0,
        facade: crate::environment::surface::Material::named("metal").expect("known"),
    };
    for (name, x, y, height_m, seen) in [
        ("behind the hangar", 0.0, 300.0, 3.0, false),
        ("high above it", 0.0, 300.0, 60.0, true),
        ("before it", 0.0, 90.0, 3.0, true),
        ("beside it", 200.0, 300.0, 3.0, true),
    ] {
        let hangars = std::slice::from_ref(&hangar);
        assert_eq!(station.sees(hangars, Point2::new(x, y), height_m), seen, "{name}");
    }
    let mut config = MlatConfig::with_stations(SensorId(1), &square());
    // Walls all round the parked target: nobody sees it.
    let truth = Parked::aircraft(&[3]);
    let place = truth.at(0, SimTime::ZERO).expect("parked").position_m.xy();
    let wall = |low: Point2<f64>, high: Point2<f64>| Building {
        footprint_m: vec![low, c(high.x, low.y), high, c(low.x, high.y)],
        height_m: 100.0,
        ..hangar.clone()
    };
    let ring = [
        (-60.0, -60.0, 60.0, -50.0),
        (-60.0, 50.0, 60.0, 60.0),
        (-60.0, -60.0, -50.0, 60.0),
        (50.0, -60.0, 60.0, 60.0),
    ];
    assert_eq!(scan(&config, &truth).plots.len(), 1, "in the open");
    config.buildings = ring
        .map(|(a, b, x, y)| wall(place + c(a, b).coords, place + c(x, y).coords))
        .to_vec()
        .into();
    assert_eq!(scan(&config, &truth).plots.len(), 0, "behind walls");
    config.buildings = Arc::new([]);
    for station in &mut config.stations {
        station.range_m = 10.0;
    }
    let sink = scan(&config, &Parked::aircraft(&[3]));
    assert_eq!((sink.looks, sink.plots.len()), (1, 0), "nobody hears");
    config.stations.truncate(2);
    assert!(matches!(Mlat::new(config), Err(ConfigError::Count { found: 2, .. })));
}

/// By the timing alone the mean was 5.4.
#[test]
fn with_late_arrivals_errors_have_the_covariance_that_is_reported() {
    let at = |x, y| Point2::new(x, y);
    let other = vec![at(-900.0, 400.0), at(2600.0, -700.0), at(1800.0, 2100.0), at(-300.0, 1900.0)];
    for (stations, multipath, multipath_m) in [
        (square(), 0.02, 10.0),
        (other.clone(), 0.02, 10.0),
        (other, 0.1, 6.0),
        (square(), 0.001, 10.0),
    ] {
        let config = MlatConfig {
            multipath,
            multipath_m,
            report_s: 0.01,
            ..MlatConfig::with_stations(SensorId(1), &stations)
        };
        let sink = scan(&config, &Parked::aircraft(&(0..200).collect::<Vec<_>>()));
        let (mut sum, mut timing, mut n) = (0.0, 0.0, 0.0);
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let error = plot.position_m - cause.truth_m.expect("a target");
            let (along, across) = (error.dot(&plot.axis), error.dot(&plot.across_axis()));
            sum += along * along / plot.along_m2 + across * across / plot.across_m2;
            timing += plot.along_m2.min(1e3);
            n += 1.0;
        }
        println!("{multipath} {multipath_m}: {n} plots, {:.2}, {:.2} m²", sum / n, timing / n);
        assert!(n > 1_000.0 && (1.4..2.4).contains(&(sum / n)), "{multipath}: {}", sum / n);
    }
}
