//! Labels without names: who is right, how often, and how sure they say they are.

use super::labelled::entry;
use super::*;
use crate::frames::Point2;
use crate::plot::{Callsign, Identity};
use crate::track::SystemTrack;
use config::TypeSize;

/// One target: its way, its size, and the line of the list that it is, if any.
struct Mover {
    path: Box<Path>,
    size: [f64; 2],
    line: Option<&'static str>,
}

const LANDING: [f64; 2] = [-1500.0, 2500.0];
/// Threshold of runway 28 (westward would be its name; the frame does not care).
fn threshold() -> Point2<f64> {
    Point2::new(LANDING[0], 600.0)
}

fn stand(n: usize) -> Point2<f64> {
    Point2::new(-400.0 + 55.0 * n as f64, 0.0)
}

/// Stands for a while, then goes.
fn waits(at: Point2<f64>, until: f64, pieces: &[(f64, f64, f64)]) -> Box<Path> {
    let mut all = vec![(until, 0.0, 0.0)];
    all.extend_from_slice(pieces);
    drive(at, 0.0, 0.0, &all)
}

/// Lands over the threshold at this time and taxis on for `way_s` seconds, so that it stops behind those before it.
fn lands(at_threshold_s: f64, way_s: f64) -> Box<Path> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let way = drive(
        threshold() + Vector2::new(-1500.0, 0.0),
        quarter,
        70.0,
        &[
            (21.4, 0.0, 0.0),
            (28.0, -2.0, 0.0),
            (6.0, 0.0, 0.25),
            (way_s, 0.0, 0.0),
            (20.0, -0.8, 0.0),
        ],
    );
    Box::new(move |t| {
        let since = t - (at_threshold_s - 21.4);
        if since >= 0.0 { way(since) } else { None }
    })
}

/// Listed aircraft at stands, one that taxis and takes off, landings; unlisted ones parked between them; vehicles that
/// stand and drive beside the stands. `late_s(n)`: by how much the list is off.
fn scene(late_s: impl Fn(usize) -> f64) -> (Vec<Mover>, FlightList) {
    let medium = [37.6, 34.1];
    let mut movers = Vec::new();
    let mut entries = Vec::new();
    const LINES: [&str; 13] = [
        "DEP0", "DEP1", "DEP2", "DEP3", "DEP4", "DEP5", "DEP6", "ARR0", "ARR1", "ARR2", "ARR3",
        "ARR4", "ARR5",
    ];
    for (n, &line) in LINES.iter().enumerate() {
        let arrives = n >= 7;
        let time = if arrives { 60.0 + 90.0 * (n - 7) as f64 } else { 150.0 + 80.0 * n as f64 };
        let path = if arrives {
            lands(time, 1.0 + 3.0 * (12 - n) as f64)
        } else {
            // Off block 100 s before its departure.
            waits(
                stand(2 * n),
                time - 100.0,
                &[(10.0, 0.5, 0.0), (80.0, 0.0, 0.03), (60.0, 0.1, 0.0)],
            )
        };
        movers.push(Mover { path, size: medium, line: Some(line) });
        let movement = if arrives { MovementKind::Arrival } else { MovementKind::Departure };
        entries.push(FlightEntry {
            stand_m: (!arrives).then(|| stand(2 * n)),
            eta_ctd: SimTime::from_s(time + late_s(n)),
            off_block: (!arrives).then(|| SimTime::from_s(time - 100.0 + late_s(n))),
            ..entry(line, "A320", movement)
        });
    }
    // Unlisted aircraft on the stands between, and two on stands of the list itself, whose own aircraft have yet to come.
    for n in 0..11 {
        let path = waits(stand(2 * n + 1), 1e4, &[]);
        movers.push(Mover { path, size: medium, line: None });
    }
    for n in 0..11 {
        // Fuel trucks and cars: at a stand for a while, then along the row.
        let at = stand(2 * n) + Vector2::new(25.0, 18.0);
        let size = if n % 2 == 0 { [12.0, 3.0] } else { [4.6, 1.9] };
        let path = waits(
            at,
            40.0 + 30.0 * n as f64,
            &[(8.0, 0.8, 0.2), (60.0, 0.0, 0.02), (8.0, -0.8, 0.0), (200.0, 0.0, 0.0)],
        );
        movers.push(Mover { path, size, line: None });
    }
    entries.sort_by_key(|e| e.callsign);
    let far_end = Point2::new(LANDING[1], 600.0);
    (movers, FlightList { entries, runways: vec![("28".to_owned(), [threshold(), far_end])] })
}

/// Radar plots of scan `k`: the wander of the echo grows with the body, and is off the tracker's law by a tenth.
fn plots(movers: &[Mover], seed: u64, k: u32) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (n, mover) in movers.iter().enumerate() {
        let key = DrawKey { run_seed: seed, sensor: 1, entity: n as u64 + 1, scan: k.into() };
        let mut rng = key.rng(Purpose::Study);
        let (a, b) = normal_pair(&mut rng);
        let t = f64::from(k) - 0.9 + 0.8 * (n as f64 / movers.len() as f64);
        let Some(truth) = (mover.path)(t) else { continue };
        if uniform(&mut rng) > 0.95 {
            continue;
        }
        let [length, span] = mover.size;
        let sigma = (0.5 * (0.8 + 0.0105 * 0.5 * (length * length + span * span))).sqrt();
        plots.push(Plot {
            sensor: SensorId(1),
            kind: SensorKind::Asde,
            time: SimTime::from_s(t),
            sequence: n as u32,
            position_m: truth + Vector2::new(a, b) * sigma,
            axis: Vector2::new(1.0, 0.0),
            along_m2: 6.5,
            across_m2: 6.5,
            altitude_m: None,
            polar: None,
            identity: None,
            scnr_db: None,
        });
    }
    plots
}

/// The line that the mover nearest to a track is, if one is near.
fn truth_of<'a>(movers: &'a [Mover], track: &SystemTrack) -> Option<&'a Mover> {
    let t = track.time.s();
    let distance =
        |m: &&Mover| (m.path)(t).map_or(f64::INFINITY, |p| (p - track.position_m).norm());
    let near = movers.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    near.filter(|m| distance(m) < 25.0)
}

#[derive(Default, Debug)]
struct Count {
    right: u32,
    wrong: u32,
    /// Sum of what the labels claim.
    claimed: f64,
    assumed_right: u32,
    assumed_wrong: u32,
}

fn watch(seed: u64, sigma_s: f64) -> Count {
    let late = |n: usize| {
        let key = DrawKey { run_seed: seed, sensor: 9, entity: n as u64, scan: 0 };
        sigma_s * normal_pair(&mut key.rng(Purpose::Study)).0
    };
    let (movers, flights) = scene(late);
    let mut config = TrackingConfig::paper();
    config.labels.list_sigma_s = sigma_s.max(30.0);
    config.sizes.push(TypeSize { designator: "A320".to_owned(), length_m: 37.6, span_m: 34.1 });
    let mut tracker = Tracker::new(config);
    let mut count = Count::default();
    for k in 1..=600 {
        let tracks =
            tracker.scan(SimTime::from_s(f64::from(k)), &plots(&movers, seed, k), &flights);
        for track in tracks.iter().filter(|t| t.status != TrackStatus::Last) {
            let mine = truth_of(&movers, track).and_then(|m| m.line);
            let is = |name: Callsign| mine == Some(name.as_str());
            if let Some(label) = &track.label {
                if is(label.callsign) {
                    count.right += 1
                } else {
                    count.wrong += 1
                }
                let sure = track.label_p.expect("a label says how sure it is");
                assert!(sure >= 0.8, "{} kept at {sure}", label.callsign.as_str());
                count.claimed += sure;
            } else if let Some(name) = track.assumed {
                if is(name) { count.assumed_right += 1 } else { count.assumed_wrong += 1 }
            }
        }
    }
    println!(
        "seed {seed}, list off by {sigma_s} s: {count:?} {:?}",
        tracker.statistics().label_revisions
    );
    count
}

#[test]
fn of_thirty_five_movers_hardly_one_label_in_a_hundred_is_wrong_and_they_know_how_sure_they_are() {
    let (mut right, mut wrong, mut claimed) = (0, 0, 0.0);
    for sigma_s in [20.0, 120.0] {
        for seed in 1..=4 {
            let count = watch(seed, sigma_s);
            (right, wrong, claimed) =
                (right + count.right, wrong + count.wrong, claimed + count.claimed);
        }
    }
    let given = f64::from(right + wrong);
    println!("{right} right, {wrong} wrong, {:.3} claimed", claimed / given);
    assert!(f64::from(wrong) <= 0.01 * given, "{wrong} of {given}");
    assert!(right > 5_000, "{right}");
    assert!(f64::from(right) / given >= claimed / given - 0.03, "surer than right");
}

/// Two that land on time tell that the list is good; then one after the other comes as late as they follow each other. The first
/// was called by the second's name until that landed (Manchester: 137 reports).
#[test]
fn who_lands_late_at_the_next_ones_time_is_not_called_by_its_name() {
    let times = [(60.0, 60.0), (150.0, 152.0), (250.0, 348.0), (350.0, 440.0)];
    let (mut movers, mut entries) = (Vec::new(), Vec::new());
    for (n, (listed_s, lands_s)) in times.into_iter().enumerate() {
        let line = ["ARR0", "ARR1", "ARR2", "ARR3"][n];
        let path = lands(lands_s, 1.0 + 6.0 * (3 - n) as f64);
        movers.push(Mover { path, size: [37.6, 34.1], line: Some(line) });
        let eta_ctd = SimTime::from_s(listed_s);
        entries.push(FlightEntry { eta_ctd, ..entry(line, "A320", MovementKind::Arrival) });
    }
    let far_end = Point2::new(LANDING[1], 600.0);
    let flights = FlightList { entries, runways: vec![("28".to_owned(), [threshold(), far_end])] };
    let mut config = TrackingConfig::paper();
    config.sizes.push(TypeSize { designator: "A320".to_owned(), length_m: 37.6, span_m: 34.1 });
    for seed in 1..=3 {
        let mut tracker = Tracker::new(config.clone());
        let mut right = [0; 4];
        for k in 1..=520 {
            let seen = plots(&movers, seed, k);
            for track in tracker.scan(SimTime::from_s(f64::from(k)), &seen, &flights) {
                let mine = truth_of(&movers, &track).and_then(|m| m.line);
                let Some(label) = &track.label else { continue };
                let place =
                    ["ARR0", "ARR1", "ARR2", "ARR3"].map(Some).iter().position(|l| *l == mine);
                assert_eq!(mine, Some(label.callsign.as_str()), "seed {seed}, {k}");
                right[place.expect("one of them")] += 1;
            }
        }
        println!("seed {seed}: {right:?}");
        assert!(right[0] > 100 && right[1] > 100, "seed {seed}: {right:?}");
    }
}

#[test]
fn what_turns_out_otherwise_loses_its_label() {
    // It stands at DEP0's stand; then it goes and lands: no such thing, but a swap can look like it.
    let (_, flights) = scene(|_| 0.0);
    let mut evidence = super::super::identity::Evidence::default();
    let entry = flights.by_callsign(Callsign::new("DEP0")).expect("listed");
    let config = TrackingConfig::paper();
    let (born, now) = (SimTime::from_s(0.0), SimTime::from_s(60.0));
    let odds = |evidence: &super::super::identity::Evidence| {
        let list = super::super::identity::List {
            flights: &flights,
            config: &config,
            now,
            times: super::super::identity::ListTimes::stated(120.0),
        };
        evidence.log_ratio(&super::super::size::Spread::default(), born, entry, &list)
    };
    let nothing = odds(&evidence);
    evidence.stood_m = entry.stand_m;
    let stands = odds(&evidence);
    evidence.stood_m = entry.stand_m.map(|s| s + Vector2::new(60.0, 0.0));
    let stands_beside = odds(&evidence);
    evidence.stood_m = entry.stand_m;
    evidence.landed =
        Some(super::super::identity::OnRunway { runway: 0, time: SimTime::from_s(50.0) });
    let landed = odds(&evidence);
    assert!(stands > nothing + 1.0 && stands_beside < nothing - 1.0 && landed < stands - 7.0);
}

#[test]
fn a_name_reported_far_off_neither_moves_its_track_nor_keeps_it() {
    let path = drive(Point2::new(0.0, 500.0), 1.0, 10.0, &[(300.0, 0.0, 0.02)]);
    let paths = [path];
    for config in [TrackingConfig::paper(), TrackingConfig::accurate()] {
        for (name, spoofed) in [("once", 60..61), ("twice", 60..62), ("a minute", 60..120)] {
            // What its reports say meanwhile: the truth, a place 7.5 km off, nothing.
            let run = |off_m: Option<f64>| {
                let mut tracker = Tracker::new(config.clone());
                let radar = tower(8, 1.0, 0);
                let (mut places, mut named) = (Vec::new(), Vec::new());
                for k in 1..=150 {
                    let t = f64::from(k);
                    let mut plots: Vec<Plot> =
                        radar.scan(k, &paths).into_iter().map(|looked| looked.0).collect();
                    let at = paths[0](t - 0.3).expect("moves");
                    let off = if spoofed.contains(&k) { off_m } else { Some(0.0) };
                    plots.extend(off.map(|off| Plot {
                        sensor: SensorId(5),
                        kind: SensorKind::Adsb,
                        time: SimTime::from_s(t - 0.3),
                        sequence: 1,
                        position_m: at + Vector2::new(off, 0.0),
                        axis: Vector2::new(0.0, 1.0),
                        along_m2: 4.0,
                        across_m2: 4.0,
                        altitude_m: None,
                        polar: None,
                        identity: Some(Identity::Callsign(Callsign::new("SWR1"))),
                        scnr_db: None,
                    }));
                    let tracks = tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
                    let truth = paths[0](t).expect("moves");
                    let near = |t: &&SystemTrack| (t.position_m - truth).norm() < 50.0;
                    let mine = tracks.iter().find(near);
                    if k > 10 {
                        let mine = mine.expect("its track stays");
                        places.push(mine.position_m);
                        named.push(mine.callsign().is_some());
                    }
                }
                (places, named)
            };
            let (silent, _) = run(None);
            let (places, named) = run(Some(7_500.0));
            let moved = places.iter().zip(&silent).map(|(a, b)| (a - b).norm());
            let most_m = moved.fold(0.0, f64::max);
            println!("{name}: {most_m:.3} m from where it would be without those reports");
            assert!(most_m <= 1.0, "{name}: {most_m}");
            let last = spoofed.end as usize - 12;
            assert_eq!(named[last.min(named.len() - 1)], name != "a minute", "{name}");
            assert!(named[140 - 11 + 5], "{name}: its name again");
        }
    }
}

/// As above, near and far, of what drives and of what stands, in any direction; the place is that of another target's plot.
#[test]
fn a_name_reported_anywhere_else_moves_no_track() {
    for (name, speed) in [("drives", 12.0), ("stands", 0.0)] {
        for (n, off_m) in [80.0, 300.0, 2_000.0].into_iter().enumerate() {
            let turn = 2.1 * n as f64 + speed;
            let off = Vector2::new(libm::sin(turn), libm::cos(turn)) * off_m;
            let path = drive(Point2::new(-400.0, 900.0), 2.5, speed, &[(300.0, 0.0, -0.01)]);
            let other = drive(Point2::new(-400.0, 900.0) + off, 2.5, speed, &[(300.0, 0.0, -0.01)]);
            let paths = [path, other];
            for config in [TrackingConfig::paper(), TrackingConfig::accurate()] {
                let run = |lies: bool| {
                    let (mut tracker, mut places) = (Tracker::new(config.clone()), Vec::new());
                    let radar = tower(18, 1.0, 0);
                    for k in 1..=90 {
                        let t = f64::from(k);
                        let mut plots: Vec<Plot> =
                            radar.scan(k, &paths).into_iter().map(|looked| looked.0).collect();
                        let at = |n: usize| paths[n](t - 0.3).expect("there");
                        let liar = lies && (40..60).contains(&k);
                        let said = Plot {
                            sensor: SensorId(5),
                            kind: SensorKind::Adsb,
                            time: SimTime::from_s(t - 0.3),
                            sequence: 1,
                            position_m: at(usize::from(liar)),
                            axis: Vector2::new(0.0, 1.0),
                            along_m2: 4.0,
                            across_m2: 4.0,
                            altitude_m: None,
                            polar: None,
                            identity: Some(Identity::Callsign(Callsign::new("SWR1"))),
                            scnr_db: None,
                        };
                        // Silence is the measure: what an honest report would add is not.
                        plots.extend((lies || !(40..60).contains(&k)).then_some(said));
                        let tracks =
                            tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
                        let truth = paths[0](t).expect("there");
                        let off = |t: &&SystemTrack| (t.position_m - truth).norm();
                        let mine = tracks.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
                        if k > 10 {
                            places.push(mine.expect("its track stays").position_m);
                        }
                    }
                    places
                };
                let moved = run(true)
                    .iter()
                    .zip(&run(false))
                    .map(|(a, b)| (a - b).norm())
                    .fold(0.0, f64::max);
                println!("{name}, {off_m} m off: {moved:.3} m");
                assert!(moved <= 1.0, "{name}, {off_m} m off: {moved}");
            }
        }
    }
}

#[test]
fn each_kind_of_evidence_tells_lines_apart() {
    use super::super::identity::{Evidence, List, ListTimes, OnRunway};
    let (_, flights) = scene(|_| 0.0);
    let config = TrackingConfig::paper();
    let odds = |evidence: &Evidence, line: &FlightEntry, born_s: f64, now_s: f64| {
        let now = SimTime::from_s(now_s);
        let list =
            List { flights: &flights, config: &config, now, times: ListTimes::stated(120.0) };
        let spread = super::super::size::Spread::default();
        evidence.log_ratio(&spread, SimTime::from_s(born_s), line, &list)
    };
    let line = |movement, runway: &str| FlightEntry {
        runway: runway.to_owned(),
        eta_ctd: SimTime::from_s(300.0),
        off_block: Some(SimTime::from_s(280.0)),
        ..entry("SWR1", "A320", movement)
    };
    let (arrives, departs) = (MovementKind::Arrival, MovementKind::Departure);
    let nothing = Evidence::default();
    let mut landed = nothing.clone();
    landed.landed = Some(OnRunway { runway: 0, time: SimTime::from_s(300.0) });
    let lands_as = |line: &FlightEntry| odds(&landed, line, 250.0, 310.0);
    let own = lands_as(&line(arrives, "28"));
    assert!(own > lands_as(&line(arrives, "14")) + 6.0, "on another runway");
    assert!(own > lands_as(&line(departs, "28")) + 6.0, "who departs does not land");
    // What stands has come from the runway: it was listed longer ago.
    let mut stood = nothing.clone();
    stood.stood_m = Some(Point2::new(900.0, -900.0));
    let arrived = |evidence| odds(evidence, &line(arrives, "28"), 400.0, 420.0);
    assert!(arrived(&nothing) > arrived(&stood) + 0.5);
    // Nobody is off his block minutes before his time.
    let moved_at = |s: f64| {
        let mut evidence = nothing.clone();
        evidence.moved = Some(SimTime::from_s(s));
        odds(&evidence, &line(departs, "28"), 10.0, 300.0)
    };
    assert!(moved_at(270.0) > moved_at(100.0) + 2.5);
}

/// Who has not been seen for some looks may have gone: nobody is called so for certain.
#[test]
fn what_is_not_seen_for_three_looks_is_only_assumed() {
    let (movers, flights) = scene(|_| 0.0);
    let mut config = TrackingConfig::paper();
    config.labels.list_sigma_s = 30.0;
    config.sizes.push(TypeSize { designator: "A320".to_owned(), length_m: 37.6, span_m: 34.1 });
    let mut tracker = Tracker::new(config);
    let mut called = Vec::new();
    for k in 1..=405 {
        let seen = if k <= 400 { plots(&movers, 1, k) } else { Vec::new() };
        let tracks = tracker.scan(SimTime::from_s(f64::from(k)), &seen, &flights);
        if k == 400 {
            let label = |t: &SystemTrack| Some((t.number, t.label.as_ref()?.callsign));
            called = tracks.iter().filter_map(label).collect();
        }
        // One or two looks are missed by what is there.
        if k == 402 {
            let still = |(number, name): &&(u16, Callsign)| {
                let own = tracks.iter().find(|t| t.number == *number);
                own.and_then(|t| t.label.as_ref()).is_some_and(|l| l.callsign == *name)
            };
            let kept = called.iter().filter(still).count();
            assert!(kept >= 2 && kept == called.len(), "{kept} of {called:?}");
        }
        if k == 405 {
            let left: Vec<_> = tracks.iter().filter(|t| t.status != TrackStatus::Last).collect();
            assert!(left.iter().all(|t| t.label.is_none()), "labels stay");
            let assumed = |(number, name): &&(u16, Callsign)| {
                left.iter().any(|t| t.number == *number && t.assumed == Some(*name))
            };
            assert!(called.iter().filter(assumed).count() >= 2, "{called:?}");
            assert!(left.iter().all(|t| t.label_p.is_none_or(|p| p <= 0.7)));
        }
    }
}

/// Plots of a radar of what stands, in each of these stretches (their number, deviation of the plots, m).
fn shown(stretches: &[(u32, f64)]) -> super::super::size::Spread {
    let mut spread = super::super::size::Spread::default();
    let mut k = 0;
    for (count, sigma_m) in stretches {
        for _ in 0..*count {
            let key = DrawKey { run_seed: 77, sensor: 1, entity: 0, scan: k.into() };
            let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
            let plot = hard_cases::plot(f64::from(k), k, 900.0 + sigma_m * a, 300.0 + sigma_m * b);
            spread.learn(&plot, 1.0);
            k += 1;
        }
    }
    spread
}

/// What the plots of a track wander tells a jet from a car, and from what it was before another target took it over.
#[test]
fn the_size_that_is_shown_tells_lines_apart_and_lately_most_of_all() {
    let mut config = TrackingConfig::paper();
    for (designator, length_m, span_m) in [("A320", 37.6, 34.1), ("C172", 8.3, 11.0)] {
        config.sizes.push(TypeSize { designator: designator.to_owned(), length_m, span_m });
    }
    let entries = ["A320", "C172"].map(|kind| entry(kind, kind, MovementKind::Arrival));
    let flights = FlightList { entries: entries.to_vec(), runways: Vec::new() };
    let (born, now) = (SimTime::from_s(0.0), SimTime::from_s(60.0));
    let times = super::super::identity::ListTimes::stated(120.0);
    let evidence = super::super::identity::Evidence::default();
    let odds = |kind: &str, spread: &super::super::size::Spread| {
        let line = flights.by_callsign(Callsign::new(kind)).expect("listed");
        let list = super::super::identity::List { flights: &flights, config: &config, now, times };
        evidence.log_ratio(spread, born, line, &list)
    };
    let of = |length_m, span_m| super::super::size::plot_variance_m2(length_m, span_m).sqrt();
    let (jet_m, light_m) = (of(37.6, 34.1), of(8.3, 11.0));
    let nothing = odds("A320", &shown(&[]));
    let (jet, light) = (shown(&[(120, jet_m)]), shown(&[(120, light_m)]));
    for (own, other, spread) in [("A320", "C172", &jet), ("C172", "A320", &light)] {
        let (own, other) = (odds(own, spread), odds(other, spread));
        println!("{nothing:.2}: {own:.2}, other {other:.2}");
        assert!(own > nothing + 0.5 && other < nothing - 1.5, "{nothing} {own} {other}");
    }
    // For ten seconds of six minutes the track has followed a car: over all of it it is a jet as before.
    let over = shown(&[(350, jet_m), (24, 0.4)]);
    let all = shown(&[(350, jet_m), (24, jet_m)]);
    let (over, all) = (odds("A320", &over), odds("A320", &all));
    println!("taken over {over:.2}, never {all:.2}");
    assert!(over < nothing - 1.5 && all > nothing + 0.5, "{over} {all}");
}
