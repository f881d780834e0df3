//! Runs with somebody's sensor: what one run sends in ASTERIX is the sensor of another.

use super::foreign_plot::{Height, Place, reading};
use super::inlets::Inlets;
use super::visitor_tests::drive;
use crate::admin_station::summary::RunSummary;
use crate::exchange::stamp::{self, StampedPlots};
use crate::gateway::{Choice, Gateway};
use crate::runtime::codec::decode;
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{ScanReport, TruthMessage};
use models::plot::{Callsign, Identity, SensorKind};
use models::sensors::PlotSink;
use models::sensors::ScanInterval;
use models::time::SimTime;
use models::track::TrackStatus;
use pdu::Envelope;
use pdu::exercise::Arrival;
use scenarios::sensors::foreign::Octets;
use scenarios::{ForeignScene, ForeignSource, Scene, SensorScene};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

const SECONDS: u64 = 120;
const FRAMES_A_SCAN: u64 = 20;

/// A scene with the radar alone, so that nothing but its plots makes tracks.
fn radar_alone(name: &str) -> Arc<Scene> {
    let mut scene = scenarios::load(&scenarios::locate(name)).expect("the scene");
    let radar = |s: &SensorScene| s.kind == SensorKind::Asde;
    scene.sensors.retain(radar);
    scene.sensors.truncate(1);
    Arc::new(scene)
}

fn foreign(source: ForeignSource, categories: &[u8], sic: Option<u8>) -> ForeignScene {
    ForeignScene {
        source,
        sac: Some(0),
        sic,
        categories: categories.to_vec(),
        sigma_m: 5.0,
        interval_s: 1.0,
        first: false,
    }
}

/// The same scene where that radar is somebody else's.
fn theirs(scene: &Scene, foreign: ForeignScene) -> Arc<Scene> {
    let mut scene = scene.clone();
    let radar = &mut scene.sensors[0];
    (radar.asde, radar.foreign) = (None, Some(foreign));
    Arc::new(scene)
}

fn live() -> ForeignSource {
    let listen = "127.0.0.1:8600".parse().expect("an address");
    ForeignSource::Live { listen, interface: None, from: Vec::new() }
}

fn recording(datagrams: &BTreeMap<u64, Vec<Vec<u8>>>) -> ForeignSource {
    let octets: Vec<u8> = datagrams.values().flatten().flatten().copied().collect();
    ForeignSource::Recording { path: PathBuf::from("x.ast"), octets: Octets(octets.into()) }
}

/// Runs a scene: the summary, and what was published scan by scan.
fn flown(
    scene: &Arc<Scene>,
    visits: impl FnMut(u64) -> Vec<Vec<u8>>,
) -> (RunSummary, Vec<ScanReport>) {
    let mut reports = Vec::new();
    let summary = drive(scene, SECONDS, visits, |out| {
        let scan = out.publish.iter().find(|p| p.key == "tracks/1/scan").expect("published");
        reports.push(decode::<ScanReport>(&scan.body).expect("sound"));
    });
    (summary, reports)
}

/// What the gateway sends of a run, by scan.
fn sent(scene: &Scene, reports: &[ScanReport]) -> BTreeMap<u64, Vec<Vec<u8>>> {
    let choice = Choice { sensors: true, tracks: false, status: false, categories: None, sac: 0 };
    let mut gateway = Gateway::new(scene, choice);
    reports.iter().map(|report| (report.scan, gateway.on_scan(report))).collect()
}

/// The datagrams of each scan as the member `visitors` lets them in: in the last frame of their scan.
fn stamped(scene: &Scene, datagrams: &BTreeMap<u64, Vec<Vec<u8>>>, frame: u64) -> Vec<Vec<u8>> {
    let time = FrameTime::of(&scene.run);
    let envelope = Envelope::new(1, time.stamp(frame));
    let time_ns = time.start_utc_ns + time.time(frame).0;
    let of_scan = datagrams.get(&(frame / FRAMES_A_SCAN));
    let due = of_scan.filter(|_| frame.is_multiple_of(FRAMES_A_SCAN)).into_iter().flatten();
    let report = |(n, octets): (usize, &Vec<u8>)| {
        let utc_ns = 1_700_000_000_000_000_000 + time_ns + n as i64;
        let stamped = StampedPlots {
            sensor: scene.sensors[0].id.0,
            arrival: Arrival { time_ns, utc_ns, rate: 1.0 },
            from: "10.0.0.7:4000".parse().expect("an address"),
            octets: octets.clone(),
        };
        stamp::encode_plots(scene.run.site, &envelope, &stamped).expect("fits")
    };
    due.enumerate().map(report).collect()
}

/// Root mean square distance of published tracks from the nearest target, and their number.
fn error_m(reports: &[ScanReport]) -> (f64, usize) {
    let (mut sum, mut count) = (0.0, 0);
    for report in reports {
        for track in report.tracks.iter().filter(|t| t.status != TrackStatus::Last) {
            let far = |t: &TruthMessage| (t.position_m.xy() - track.position_m).norm();
            let nearest = report.truth.iter().map(far).fold(f64::MAX, f64::min);
            // What is farther is an echo of its own, not an error of a target.
            if nearest < 60.0 {
                sum += nearest * nearest;
                count += 1;
            }
        }
    }
    ((sum / count as f64).sqrt(), count)
}

/// Another airport beside the one that everything is tried on.
#[test]
fn the_radar_of_one_run_is_as_good_as_the_sensor_of_another() {
    for name in ["zurich", "xsyn"] {
        let own = radar_alone(name);
        let (of_own, reports) = flown(&own, |_| Vec::new());
        let (own_m, own_count) = error_m(&reports);
        assert!(own_count > 300, "{name}: {own_count}");
        let datagrams = sent(&own, &reports);
        let plots: usize = reports.iter().map(|r| r.plots.len()).sum();

        let scene = theirs(&own, foreign(live(), &[10], None));
        let feed = |frame| stamped(&scene, &datagrams, frame);
        let (first, live_reports) = flown(&scene, feed);
        assert_eq!(first.foreign_plots, Some(plots as u64), "{name}: every plot once");
        let (their_m, their_count) = error_m(&live_reports);
        println!("{name}: own {own_m:.3} m of {own_count}, theirs {their_m:.3} m of {their_count}");
        // Positions have steps of 9 mm, deviations of 0.25 m, times of 1/128 s (11 cm at 28 m/s).
        assert!((their_m / own_m - 1.0).abs() < 0.03, "{name}: {their_m} m, own {own_m} m");
        assert!(
            their_count.abs_diff(own_count) * 50 < own_count,
            "{name}: {their_count}, {own_count}"
        );

        // Nothing of it is ours: truth and weather alone are in the digest.
        assert!(first.external && first.foreign.is_some() && of_own.foreign.is_none());
        let empty = flown(&scene, |_| Vec::new()).0;
        assert_eq!((&first.digest, &first.track_digest), (&empty.digest, &empty.track_digest));
        assert!(!empty.external, "{name}: heard nothing");
        let again = flown(&scene, feed).0;
        assert_eq!((&again.digest, &again.foreign), (&first.digest, &first.foreign), "{name}");
        let numbers = live_reports.iter().flat_map(|r| &r.tracks).map(|t| t.number);
        assert!(numbers.into_iter().all(|n| n >= 4096), "{name}: numbers of outsiders");

        // As a recording the same plots are part of the scene and of its digest.
        let scene = theirs(&own, foreign(recording(&datagrams), &[10], None));
        let (recorded, its_reports) = flown(&scene, |_| Vec::new());
        assert!(!recorded.external && recorded.track_digest != empty.track_digest);
        let (its_m, its_count) = error_m(&its_reports);
        println!("{name}: recorded {its_m:.3} m of {its_count}");
        assert!((its_m / own_m - 1.0).abs() < 0.03, "{name}: {its_m} m, own {own_m} m");
        assert!(its_count.abs_diff(own_count) * 50 < own_count, "{name}: {its_count}, {own_count}");
        assert_eq!(recorded.digest, flown(&scene, |_| Vec::new()).0.digest);
    }
}

fn inlets_of(scene: &Scene) -> Inlets {
    Inlets::of(scene).expect("sound")
}

fn scan_of(inlets: &mut Inlets, scene: &Scene, scan: u64) -> PlotSink {
    let at = |scan: u64| SimTime(scan as i64 * scene.run.scan().0);
    let interval = ScanInterval { run_seed: 1, scan, from: at(scan - 1), to: at(scan) };
    let mut sink = PlotSink::default();
    inlets.scan(scene.sensors[0].id, &interval, &mut sink);
    sink
}

fn times_ms(sink: &PlotSink) -> Vec<i64> {
    sink.plots.iter().map(|p| p.time.0 / 1_000_000).collect()
}

fn plots(arrived_s: f64, scene: &Scene, octets: Vec<u8>) -> StampedPlots {
    let time_ns = scene.run.start_utc_ns + (arrived_s * 1e9) as i64;
    StampedPlots {
        sensor: scene.sensors[0].id.0,
        arrival: Arrival { time_ns, utc_ns: 5, rate: 1.0 },
        from: "10.0.0.7:4000".parse().expect("an address"),
        octets,
    }
}

/// A surface plot at a time of the scene.
fn plot_at(scene: &Scene, time_s: f64, place: [f64; 2]) -> Vec<u8> {
    use asterix::{Packer, cat010};
    let of_day_s = asterix::time::of_day_s(scene.run.start_utc_ns) + time_s;
    let mut packer = Packer::new(1400);
    packer
        .record(&cat010::CATEGORY, |items| {
            items.put(&cat010::I010, &[0, 1])?;
            items.put(&cat010::I000, &[1])?;
            items.put(&cat010::I140, &[of_day_s.rem_euclid(86_400.0)])?;
            items.put(&cat010::I042, &place)
        })
        .expect("fits");
    packer.take().concat()
}

#[test]
fn what_comes_late_early_twice_or_from_afar_is_refused_and_counted() {
    let own = radar_alone("zurich");
    let mut scene = theirs(&own, foreign(live(), &[10], None));
    // Over midnight.
    Arc::make_mut(&mut scene).run.start_utc_ns = 1_574_640_000_000_000_000 - 5_000_000_000;
    let start = scene.run.start_utc_ns;
    let mut inlets = inlets_of(&scene);
    let take = |inlets: &mut Inlets, arrived_s: f64, time_s: f64, place| {
        inlets.take(&plots(arrived_s, &scene, plot_at(&scene, time_s, place)), start)
    };
    assert!(take(&mut inlets, 8.0, 7.5, [100.0, 50.0]));
    assert!(!take(&mut inlets, 8.0, 7.5, [100.0, 50.0]), "twice");
    assert!(!take(&mut inlets, 8.0, 8.75, [101.0, 50.0]), "0.75 s ahead");
    assert!(take(&mut inlets, 8.0, 8.25, [102.0, 50.0]), "of the next scan");
    assert!(take(&mut inlets, 8.0, 4.5, [103.0, 50.0]), "arrived, but too old");
    let two = scan_of(&mut inlets, &scene, 8);
    assert_eq!(times_ms(&two), [7500]);
    assert!(!take(&mut inlets, 8.5, 7.5, [100.0, 50.0]), "a scan later");
    let next = scan_of(&mut inlets, &scene, 9);
    assert_eq!(times_ms(&next), [8250]);
    let mut words: Vec<(String, u64)> = inlets.refused();
    words.sort();
    let words: Vec<(&str, u64)> = words.iter().map(|(w, n)| (w.as_str(), *n)).collect();
    let expected = [
        ("plots: a plot more than 0.5 s ahead of its arrival", 1),
        ("plots: a plot older than three scans", 1),
        ("plots: a plot that came twice", 2),
    ];
    assert_eq!(words, expected);
    // A flood of ever new plots is bounded.
    for n in 0..40_000 {
        let place = [f64::from(n % 200), f64::from(n / 200)];
        inlets.take(&plots(20.0, &scene, plot_at(&scene, 19.5, place)), start);
    }
    assert!(scan_of(&mut inlets, &scene, 20).plots.len() <= 16_384);
}

/// Three scans old is not older than three scans; and whoever may still come may not come twice.
#[test]
fn a_plot_of_exactly_three_scans_is_taken_once() {
    let own = radar_alone("zurich");
    let mut scene = theirs(&own, foreign(live(), &[10], None));
    // Whole seconds are exact in every time of day.
    Arc::make_mut(&mut scene).run.start_utc_ns = 1_574_600_400_000_000_000;
    let start = scene.run.start_utc_ns;
    let mut inlets = inlets_of(&scene);
    let take = |inlets: &mut Inlets, time_s: f64| {
        inlets.take(&plots(8.0, &scene, plot_at(&scene, time_s, [100.0, 50.0])), start)
    };
    assert!(take(&mut inlets, 5.0) && take(&mut inlets, 4.75));
    assert_eq!(times_ms(&scan_of(&mut inlets, &scene, 8)), [5000]);
    assert!(!take(&mut inlets, 5.0), "twice");
    assert_eq!(times_ms(&scan_of(&mut inlets, &scene, 8)), [0_i64; 0]);
}

/// Two plots of one stamp are told apart by their numbers in the tracker too, when the second comes a scan late.
#[test]
fn late_plots_of_a_time_that_another_had_are_none_of_its_copies() {
    let own = radar_alone("zurich");
    let scene = theirs(&own, foreign(live(), &[10], None));
    let start = scene.run.start_utc_ns;
    let mut inlets = inlets_of(&scene);
    let mut tracker = models::fusion::Tracker::new(scene.tracking_config());
    for scan in 1..=6_u64 {
        let to = scan as f64;
        let mut take = |arrived_s: f64, time_s: f64, north_m: f64| {
            let octets = plot_at(&scene, time_s, [100.0, north_m]);
            assert!(inlets.take(&plots(arrived_s, &scene, octets), start));
        };
        take(to - 0.25, to - 0.5, 50.0);
        if scan > 1 {
            take(to - 0.25, to - 1.5, 900.0);
        }
        let sink = scan_of(&mut inlets, &scene, scan);
        tracker.scan(SimTime::from_s(to), &sink.plots, &models::flight_list::FlightList::default());
    }
    let counted = tracker.statistics();
    assert_eq!((counted.plots, counted.duplicates, counted.too_late), (11, 0, 0));
}

#[test]
fn a_position_without_a_deviation_has_that_of_the_scene() {
    let own = radar_alone("zurich");
    for sigma_m in [5.0, 20.0] {
        let mut foreign = foreign(live(), &[10], None);
        foreign.sigma_m = sigma_m;
        let scene = theirs(&own, foreign);
        let mut inlets = inlets_of(&scene);
        let octets = plot_at(&scene, 2.5, [300.0, 100.0]);
        assert!(inlets.take(&plots(2.6, &scene, octets), scene.run.start_utc_ns));
        let plot = scan_of(&mut inlets, &scene, 3).plots[0];
        for variance_m2 in [plot.along_m2, plot.across_m2] {
            assert!((variance_m2.sqrt() - sigma_m).abs() < 0.01 * sigma_m, "{plot:?}");
        }
    }
}

#[test]
fn a_clock_of_its_own_is_taken_from_its_first_plot() {
    let own = radar_alone("zurich");
    let mut foreign = foreign(live(), &[10], None);
    foreign.first = true;
    let scene = theirs(&own, foreign);
    let mut inlets = inlets_of(&scene);
    // A clock that is eleven hours off, and two plots a second apart.
    for (arrived_s, time_s) in [(3.0, 39_600.0), (4.1, 39_601.0)] {
        let octets = plot_at(&scene, time_s, [0.0, 100.0]);
        assert!(inlets.take(&plots(arrived_s, &scene, octets), scene.run.start_utc_ns));
    }
    let times: Vec<i64> =
        [3, 4].into_iter().flat_map(|scan| times_ms(&scan_of(&mut inlets, &scene, scan))).collect();
    assert_eq!(times, [3000, 4000]);
}

/// Vectors of every category that has plots: what each says is read as it was said.
#[test]
fn reports_of_every_category_are_plots() {
    let name = |text: &str| Some(Identity::Callsign(Callsign::new(text)));
    let square = |sigma_m: f64| sigma_m * sigma_m;
    for (category, hex, time_s, place, cov_m2, identity) in [
        (
            10,
            "0a001ff70109a0000701618046504005dc60000425fbdb4d41440a0cfffbb4",
            36_000.5,
            Place::Local([1061.0, -1061.0]),
            Some([6.25, -1.25, 9.0]),
            None,
        ),
        (
            20,
            "140037ffcd0c0008bf144650800081cac10018cff8fffe0b000708014102029c001bfffc3c65868005a071cb3d2040000a000d000001b1",
            36_001.0,
            Place::Degrees([45.630_002_6, 8.723_101_6]),
            Some([6.25, 0.0, 10.5625]),
            name("AZA1234"),
        ),
        (
            21,
            "150036eb193103c1410400030960001f3f480010df69ff030ade394b18053f482051f314123f48284d74b1cf7220030140050860f3c2",
            32_400.0,
            Place::Degrees([47.454_5, 8.556_9]),
            Some([square(30.0 / 2.447_75), 0.0, square(30.0 / 2.447_75)]),
            name("SWR137H"),
        ),
        (48, "300013f10148190a3f49003000ff00001a3ffd", 32_402.0, Place::Polar, None, None),
        (
            62,
            "3e006bbfdfa3840014014651000081cac10018cff8fffe0b0007080021fff202ff029cc03c658605a071cb3d200141019101010110c120c8040210001e4fcc415a4131323334413332304d4c494d434548414d33355201100a0c1e4231322020204d514484000400050203",
            36_002.0,
            Place::Degrees([45.630_002_6, 8.723_101_6]),
            Some([4.0, 0.0, 6.25]),
            name("AZA1234"),
        ),
    ] {
        let octets = asterix::json::octets(hex).expect("digits");
        let block = asterix::blocks(&octets).next().expect("a block").expect("sound");
        let record = block.records().next().expect("a record").expect("sound");
        let read = reading(&record).expect("complete").expect("a plot");
        assert_eq!(read.of_day_ns, (time_s * 1e9) as i64, "{category}");
        assert_eq!(read.identity, identity, "{category}");
        let near = |a: [f64; 2], b: [f64; 2], off: f64| {
            assert!((a[0] - b[0]).abs() < off && (a[1] - b[1]).abs() < off, "{category}: {a:?}");
        };
        match (read.place, place) {
            (Place::Degrees(a), Place::Degrees(b)) => near(a, b, 1e-4),
            (a, b) => assert_eq!(a, b, "{category}"),
        }
        match (read.cov_m2, cov_m2) {
            (Some(a), Some(b)) => {
                near([a[0], a[2]], [b[0], b[2]], 1e-3);
                near([a[1], 0.0], [b[1], 0.0], 1e-3);
            }
            (a, b) => assert_eq!(a, b, "{category}"),
        }
        if category == 48 {
            let [range_m, azimuth_rad] = read.polar.expect("range and azimuth");
            near([range_m, azimuth_rad], [0.996_093_75 * 1852.0, 0.0], 1e-6);
            assert_eq!(read.height, Some(Height::Sea(-75.0 * 0.3048)));
        }
    }
}

/// A radar that tells range and azimuth alone: its plots are about its site, over the ground.
#[test]
fn range_and_azimuth_are_laid_out_from_the_site() {
    use asterix::{Packer, cat048};
    let own = radar_alone("zurich");
    let scene = theirs(&own, foreign(live(), &[48], None));
    let mut packer = Packer::new(1400);
    let of_day_s = asterix::time::of_day_s(scene.run.start_utc_ns) + 4.5;
    let elevation_ft = scene.airport.reference.height_m / 0.3048;
    packer
        .record(&cat048::CATEGORY, |items| {
            items.put(&cat048::I010, &[0, 1])?;
            items.put(&cat048::I140, &[of_day_s])?;
            items.put(&cat048::I040, &[2.0, 90.0])?;
            items.put(&cat048::I110, &[elevation_ft + 3000.0])
        })
        .expect("fits");
    let mut inlets = inlets_of(&scene);
    let stamped = plots(5.0, &scene, packer.take().concat());
    assert!(inlets.take(&stamped, scene.run.start_utc_ns));
    let plot = scan_of(&mut inlets, &scene, 5).plots[0];
    let site_m = scene.sensors[0].site_m.expect("a site");
    let altitude_m = plot.altitude_m.expect("measured");
    assert!((altitude_m - 3000.0 * 0.3048).abs() < 12.5 * 0.3048 + 0.01, "{altitude_m}");
    let ground_m = ((2.0 * 1852.0_f64).powi(2) - (altitude_m - site_m.z).powi(2)).sqrt();
    let off_m = plot.position_m - site_m.xy();
    assert!((off_m.x - ground_m).abs() < 0.01 && off_m.y.abs() < 0.01, "{off_m}, {ground_m}");
    assert_eq!((plot.along_m2, plot.across_m2), (25.0, 25.0), "as the scene says");
    let polar = plot.polar.expect("kept");
    assert!((polar.sigma_azimuth_rad * polar.range_m - 5.0).abs() < 1e-9);
}
