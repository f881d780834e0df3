//! Several sensors: biases of sites, slow errors, outages, different times and rates.

use super::*;
use crate::plot::{Callsign, Identity};
use config::SensorModel;

struct Site {
    id: u16,
    place: Point2<f64>,
    range_bias: f64,
    azimuth_bias: f64,
}

const SIGMA_RANGE: f64 = 1.5;
const SIGMA_AZIMUTH: f64 = 1e-3;

fn look(site: &Site, seed: u64, target: usize, k: u32, t: f64, truth: Point2<f64>) -> Plot {
    let key =
        DrawKey { run_seed: seed, sensor: site.id.into(), entity: target as u64, scan: k.into() };
    let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
    let o = truth - site.place;
    let range = libm::hypot(o.x, o.y) + site.range_bias + SIGMA_RANGE * a;
    let azimuth = libm::atan2(o.x, o.y) + site.azimuth_bias + SIGMA_AZIMUTH * b;
    let axis = Vector2::new(libm::sin(azimuth), libm::cos(azimuth));
    Plot {
        sensor: SensorId(site.id),
        kind: SensorKind::Asde,
        time: SimTime::from_s(t),
        sequence: target as u32,
        position_m: site.place + axis * range,
        axis,
        along_m2: SIGMA_RANGE * SIGMA_RANGE,
        across_m2: (range * SIGMA_AZIMUTH) * (range * SIGMA_AZIMUTH),
        altitude_m: None,
        polar: Some(Polar {
            range_m: range,
            azimuth_rad: crate::frames::wrap_pi(azimuth),
            sigma_range_m: SIGMA_RANGE,
            sigma_azimuth_rad: SIGMA_AZIMUTH,
            extent_m2: None,
        }),
        identity: None,
        scnr_db: None,
    }
}

/// Runs two vehicles that report by DGPS and one silent target under `sites`; gives the mean squared error of
/// the published tracks of all three from scan 60 on, the most tracks at a time after scan 200, and the tracker.
fn watch(
    config: TrackingConfig,
    sites: &[Site],
    silent: impl Fn(u32, u16) -> bool,
) -> (f64, usize, Tracker) {
    let paths = [
        drive(Point2::new(0.0, 0.0), 0.7, 9.0, &[(600.0, 0.0, 0.01)]),
        drive(Point2::new(500.0, -300.0), 4.0, 7.0, &[(600.0, 0.0, -0.012)]),
        drive(Point2::new(-400.0, 500.0), 2.0, 12.0, &[(600.0, 0.0, 0.008)]),
    ];
    let mut tracker = Tracker::new(config);
    let rho = libm::exp(-1.0 / 100.0);
    let mut slow = [Vector2::zeros(); 2];
    let (mut sum, mut count, mut most) = (0.0, 0.0, 0);
    for k in 1..=300 {
        let mut plots = Vec::new();
        for (n, path) in paths.iter().enumerate() {
            for site in sites.iter().filter(|s| !silent(k, s.id)) {
                let t = f64::from(k) - 0.9 + 0.2 * f64::from(site.id) + 0.01 * n as f64;
                plots.push(look(site, 3, n, k, t, path(t).expect("moves")));
            }
            if n < 2 && !silent(k, 9) {
                let key = DrawKey { run_seed: 4, sensor: 9, entity: n as u64, scan: k.into() };
                let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
                slow[n] = slow[n] * rho + Vector2::new(a, b) * (1.0 - rho * rho).sqrt() * 0.55;
                let t = f64::from(k) - 0.35;
                let mut report = look(&sites[0], 3, n, k, t, path(t).expect("moves"));
                report.position_m = path(t).expect("moves") + slow[n];
                (report.sensor, report.kind, report.polar) = (SensorId(9), SensorKind::Dgps, None);
                (report.axis, report.along_m2, report.across_m2) =
                    (Vector2::new(0.0, 1.0), 0.3, 0.3);
                report.identity = Some(Identity::Callsign(Callsign::new(["CAR1", "CAR2"][n])));
                plots.push(report);
            }
        }
        let t_out = SimTime::from_s(f64::from(k));
        let tracks = tracker.scan(t_out, &plots, &FlightList::default());
        for path in &paths {
            let truth = path(t_out.s()).expect("moves");
            let nearest = tracks
                .iter()
                .map(|t| (t.position_m - truth).norm())
                .min_by(f64::total_cmp)
                .unwrap_or(f64::INFINITY);
            if k >= 60 {
                sum += nearest * nearest;
                count += 1.0;
            }
        }
        most = if k >= 200 { tracks.len().max(most) } else { 0 };
    }
    (sum / count, most, tracker)
}

fn config(base: TrackingConfig) -> TrackingConfig {
    let mut config = base;
    // The targets here are points.
    config.register_echo = false;
    for id in [1, 2] {
        let mut sensor = SensorModel::default_of(SensorId(id), SensorKind::Asde);
        sensor.extra_sigma_m = 0.0;
        config.sensors.push(sensor);
    }
    config
}

#[test]
fn biases_of_sites_are_found_and_taken_off() {
    let sites = [
        Site { id: 1, place: Point2::new(-900.0, -600.0), range_bias: 6.0, azimuth_bias: -4e-3 },
        Site { id: 2, place: Point2::new(1100.0, 700.0), range_bias: -3.0, azimuth_bias: 2e-3 },
    ];
    let (raw, _, _) = watch(config(TrackingConfig::paper()), &sites, |_, _| false);
    let (registered, most, tracker) =
        watch(config(TrackingConfig::accurate()), &sites, |_, _| false);
    println!(
        "paper {:.2} m, registered {:.2} m, {:?}",
        raw.sqrt(),
        registered.sqrt(),
        tracker.site_biases()
    );
    let found = tracker.site_biases();
    assert_eq!(found.len(), 2);
    for bias in found {
        let site = &sites[usize::from(bias.sensor.0) - 1];
        let range = (bias.range_m - site.range_bias) / bias.sigma_range_m;
        let azimuth = (bias.azimuth_rad - site.azimuth_bias) / bias.sigma_azimuth_rad;
        assert!(range.abs() < 3.0 && azimuth.abs() < 3.0, "{bias:?}");
        // Honest: not surer than independent pairs allow.
        assert!(bias.sigma_range_m > 0.05 && bias.sigma_range_m < 2.0, "{bias:?}");
    }
    assert_eq!(most, 3, "no target has two tracks once the sites are known");
    assert!(registered < 0.5 * raw, "{registered} {raw}");
}

#[test]
fn an_outage_of_one_sensor_loses_no_track_and_both_are_better_than_one() {
    let sites = [
        Site { id: 1, place: Point2::new(-900.0, -600.0), range_bias: 0.0, azimuth_bias: 0.0 },
        Site { id: 2, place: Point2::new(1100.0, 700.0), range_bias: 0.0, azimuth_bias: 0.0 },
    ];
    let paper = || config(TrackingConfig::paper());
    let (both, most, _) = watch(paper(), &sites, |_, _| false);
    let (outage, most_outage, tracker) =
        watch(paper(), &sites, |k, id| id == 1 && (100..200).contains(&k));
    let (one, most_one, _) = watch(paper(), &sites, |_, id| id == 1);
    println!("both {both:.3} m², with an outage {outage:.3} m², one {one:.3} m²");
    assert_eq!([most, most_outage, most_one], [3; 3]);
    assert!(both < outage && outage < one);
    assert_eq!(tracker.statistics().deleted, 0);
}

#[test]
fn two_equal_radars_at_one_time_are_one_radar_with_half_the_variance() {
    let filter = |sensors: &[u16], variance: f64| {
        let mut config = TrackingConfig::paper();
        config.consider_slow_errors = false;
        for &id in sensors {
            let model = SensorModel::default_of(SensorId(id), SensorKind::Mlat);
            config.sensors.push(SensorModel { extra_sigma_m: 0.0, ..model });
        }
        let mut tracker = Tracker::new(config);
        let mut last = Vec::new();
        for k in 1..=20 {
            let t = f64::from(k);
            let plots: Vec<Plot> = sensors
                .iter()
                .map(|&id| Plot {
                    sensor: SensorId(id),
                    kind: SensorKind::Mlat,
                    time: SimTime::from_s(t),
                    sequence: 0,
                    position_m: Point2::new(7.0 * t, 2.0),
                    axis: Vector2::new(1.0, 0.0),
                    along_m2: variance,
                    across_m2: variance,
                    altitude_m: None,
                    polar: None,
                    identity: None,
                    scnr_db: None,
                })
                .collect();
            last = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
        }
        assert_eq!(last.len(), 1);
        last[0].position_cov_m2[(0, 0)]
    };
    let (two, one) = (filter(&[1, 2], 4.0), filter(&[1], 2.0));
    assert!((two - one).abs() < 2e-3 * one, "{two} {one}");
}

#[test]
fn a_vehicle_that_names_itself_is_not_lost_where_it_brakes_harder_than_its_filter_foresees() {
    // 15 m/s, from 20 s on 7 m/s² until it stands.
    let way = |t: f64| {
        let braking = (t - 20.0).clamp(0.0, 15.0 / 7.0);
        Point2::new(15.0 * t.min(20.0) + (15.0 - 3.5 * braking) * braking, 40.0)
    };
    let mut tracker = Tracker::new(TrackingConfig::paper());
    let site = Site { id: 1, place: Point2::origin(), range_bias: 0.0, azimuth_bias: 0.0 };
    for k in 1..=40 {
        let t = f64::from(k);
        let mut plot = look(&site, 1, 0, k, t - 0.4, way(t - 0.4));
        (plot.sensor, plot.kind, plot.polar) = (SensorId(9), SensorKind::Dgps, None);
        plot.position_m = way(t - 0.4);
        (plot.along_m2, plot.across_m2) = (0.01, 0.01);
        plot.identity = Some(Identity::Callsign(Callsign::new("CAR1")));
        let tracks = tracker.scan(SimTime::from_s(t), &[plot], &FlightList::default());
        if k > 3 {
            assert_eq!(tracks.len(), 1, "{k} s");
            let error = (tracks[0].position_m - way(t)).norm();
            assert!(error < 12.0, "{error:.1} m at {k} s");
        }
    }
    let found = tracker.statistics();
    assert!(found.gate_2 + found.restarts >= 1, "the covariance gate alone refuses it: {found:?}");
    assert_eq!((found.confirmed, found.deleted, found.identity_conflicts), (1, 0, 0));
}

/// The plots of a second radar between those of the first hid each from the other: nothing was learnt of any body, and of
/// fifteen parked aircraft whose type says who they are two had a name in place of fourteen.
#[test]
fn what_two_radars_see_of_a_body_is_learnt_from_both() {
    // Each radar from its scan on, until it sees the target no more.
    let seen = |radars: &[(u16, std::ops::Range<u32>)]| {
        let mut spread = size::Spread::default();
        for k in 0..200_u32 {
            for (id, _) in radars.iter().filter(|(_, scans)| scans.contains(&k)) {
                let key = DrawKey { run_seed: 3, sensor: (*id).into(), entity: 0, scan: k.into() };
                let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
                let near_side = Vector2::new(f64::from(*id) * 4.0, 0.0);
                let plot = Plot {
                    sensor: SensorId(*id),
                    position_m: Point2::new(900.0, 700.0) + near_side + Vector2::new(a, b) * 3.0,
                    ..hard_cases::plot(f64::from(k) + 0.3 * f64::from(*id), k, 0.0, 0.0)
                };
                spread.learn(&plot, 1.0);
            }
        }
        spread.variance_m2().expect("triples")
    };
    let all = |id| (id, 0..200);
    let (one, both) = (seen(&[all(1)]), seen(&[all(1), all(2)]));
    let six = seen(&[1, 2, 3, 4, 5, 6].map(all));
    let after = |id: u16| (id, 30 * u32::from(id)..30 * u32::from(id) + 25);
    let handed_over = seen(&[0, 1, 2, 3, 4, 5].map(after));
    let four = seen(&[0, 1, 2, 3].map(after));
    println!("{one:?} {both:?} {six:?} {handed_over:?} {four:?}");
    assert!((six.0 / 9.0 - 1.0).abs() < 0.3, "of more radars than are kept, the first");
    assert!(handed_over.1 > four.1 + 3.0, "from one to the next, more than are kept");
    assert!(both.1 > 0.95 * one.1, "as many triples");
    assert!((both.0 / 9.0 - 1.0).abs() < 0.3 && (one.0 / 9.0 - 1.0).abs() < 0.3, "9 m²");
}

/// Where two radars look in turn, each refused plot took the place of the other's, and "two in a row of one sensor" never came:
/// a track that had been left behind was so for a scan longer, until its uncertainty had grown.
#[test]
fn two_radars_in_turn_begin_a_lost_state_anew() {
    let mut config = TrackingConfig::paper();
    config.sensors =
        [1, 2].map(|id| SensorModel::default_of(SensorId(id), SensorKind::Asde)).to_vec();
    let mut tracker = Tracker::new(config);
    let mut near = 0;
    // Drives at 12 m/s; from the sixtieth second on its plots lie 30 m aside.
    let at = |t: f64| Point2::new(800.0 + 12.0 * t, if t < 60.0 { 300.0 } else { 330.0 });
    for k in 1..=70_u32 {
        let mut plots = Vec::new();
        for id in [1_u16, 2] {
            let t = f64::from(k) - 1.0 + 0.4 * f64::from(id);
            let plot = hard_cases::plot(t, id.into(), at(t).x, at(t).y);
            plots.push(Plot { sensor: SensorId(id), ..plot });
        }
        let tracks = tracker.scan(SimTime::from_s(k.into()), &plots, &FlightList::default());
        let truth = at(k.into());
        let first = |t: &SystemTrack| t.number == 0 && (t.position_m - truth).norm() < 8.0;
        near += u32::from(k > 60 && tracks.iter().any(first));
    }
    println!("{near} {:?}", tracker.statistics());
    assert_eq!(near, 10, "the first track has it again, in every scan from the next on");
}

/// A report stands for all that come within two of its error's times, or for itself where that is less.
#[test]
fn a_report_counts_as_often_as_its_error_lasts() {
    for (slow_share, slow_tau_s, interval_s, repeats) in [
        (0.9, 300.0, 0.5, 1200.0),
        (0.5, 300.0, 4.0, 150.0),
        (0.9, 20.0, 1.0, 40.0),
        (0.0, 300.0, 0.5, 1.0),
    ] {
        let mut config = TrackingConfig::accurate();
        config.register_sites = true;
        let model = SensorModel::default_of(SensorId(5), SensorKind::Adsb);
        config.sensors.push(SensorModel { slow_share, slow_tau_s, interval_s, ..model });
        let mut tracker = Tracker::new(config);
        for k in 1..=20 {
            let t = f64::from(k);
            let at = Point2::new(10.0 * t, 0.0);
            let plots = [labelled::report(5, SensorKind::Adsb, t - 0.2, 0, at)];
            tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
        }
        let found = tracker.tracks[0].reference.as_ref().expect("it reports").repeats;
        assert_eq!(found, repeats, "{slow_share} {slow_tau_s} {interval_s}");
    }
}
