use super::between::Target;
use super::*;
use models::plot::Callsign;
use models::sensors::{TargetClass, TargetState};

/// The truth of a scene as a scan reports it.
fn truth_at(scene: &Scene, at: SimTime) -> Vec<TruthMessage> {
    let types = &scene.traffic.types;
    let designator = |entity: &scenarios::Entity| {
        let same = |d: &&str| types.get(d).is_some_and(|t| t.class == entity.class);
        types.designators().find(same).unwrap_or("").to_owned()
    };
    let one = |(number, entity): (usize, &scenarios::Entity)| {
        let state = entity.trajectory.as_ref()?.at(at)?;
        Some(TruthMessage {
            id: [1, 1, number as u16 + 1],
            callsign: entity.callsign.as_str().to_owned(),
            address: None,
            type_designator: designator(entity),
            aircraft: true,
            size_m: [30.0, 30.0],
            position_m: state.position_m,
            velocity_mps: state.velocity_mps.into(),
            heading_rad: state.heading_rad,
            ours: true,
            track: None,
        })
    };
    scene.traffic.entities.iter().enumerate().filter_map(one).collect()
}

fn works(scene: &Scene, from_scan: u64, count: u64) -> Vec<Work> {
    let step = scene.run.scan().0;
    let at = |scan: u64| SimTime(scan as i64 * step);
    (from_scan..from_scan + count)
        .map(|scan| Work {
            scan,
            to: at(scan),
            truth: truth_at(scene, at(scan)),
            before: Some((at(scan - 1), truth_at(scene, at(scan - 1)))),
            flights: FlightList::default(),
            ghost_m: None,
        })
        .collect()
}

fn shipped(name: &str) -> Arc<Scene> {
    Arc::new(scenarios::load(&scenarios::locate(name)).expect("a shipped scene"))
}

#[test]
fn every_tolerance_keeps_what_it_promises_and_the_exact_one_leaves_nothing_out() {
    // Dry, then in rain and with another seed; and another airport's sensors.
    for (name, from_scan, seed) in [("zurich", 100, 1), ("zurich", 470, 9), ("asmgcs", 120, 3)] {
        let scene = shipped(name);
        let mut chains = Chains::new(Arc::clone(&scene), seed).expect("sensors");
        works(&scene, from_scan, 60).iter().for_each(|work| chains.scan(work));
        let told = chains.told(Some(0.5));
        let rows = &told.rows;
        assert_eq!(rows.iter().filter(|r| r.run).count(), 1, "{name}");
        let own = scene.tolerance();
        for row in rows {
            let case = format!("{name} from {from_scan}, {} m: {row:?}", row.tolerance_m);
            let apart_m = row.apart_60s_m.expect("both have plots");
            // What changes a share of the plots is promised as a share, however far it moves these (late signals of
            // multilateration); all else keeps the distance.
            let share = row.skipped.iter().any(|s| s[2].contains("probability"));
            let loose = share && row.tolerance_m > own.position_m;
            assert!(loose || apart_m <= row.tolerance_m + 1e-9, "{case}");
            let detection = own.times(row.tolerance_m / own.position_m).detection;
            assert!(row.alone_60s.expect("plots") <= detection + 0.01, "{case}");
            assert!(row.plots > 30 && row.rmse_60s_m.is_some_and(f64::is_finite), "{case}");
            assert!(row.ns_per_target.is_some_and(|ns| ns > 0.0) && row.tracks > 0, "{case}");
        }
        let (exact, loosest) = (&rows[0], &rows[rows.len() - 1]);
        assert_eq!(
            (exact.tolerance_m, exact.apart_60s_m, exact.alone_60s),
            (0.0, Some(0.0), Some(0.0))
        );
        assert!(exact.skipped.is_empty() && exact.cheaper == 0, "{name}: {exact:?}");
        assert!(!loosest.skipped.is_empty(), "{name}: {loosest:?}");
        assert!(loosest.apart_60s_m > Some(0.0), "what is left out is missed: {loosest:?}");
        assert_eq!(
            told.ghosts_m.len(),
            rows.iter().find(|r| r.tolerance_m == 0.5).expect("it").tracks
        );
        assert!(
            chains.told(None).ghosts_m.is_empty() && chains.told(Some(0.3)).ghosts_m.is_empty()
        );
    }
}

#[test]
fn the_run_s_own_row_has_the_plots_of_the_run() {
    /// The movements themselves, between the scans too.
    struct Exactly<'a>(&'a Scene, Vec<(u64, usize)>);
    impl Truth for Exactly<'_> {
        fn len(&self) -> usize {
            self.1.len()
        }
        fn key(&self, index: usize) -> u64 {
            self.1[index].0
        }
        fn class(&self, index: usize) -> &TargetClass {
            &self.0.traffic.entities[self.1[index].1].class
        }
        fn callsign(&self, index: usize) -> Callsign {
            self.0.traffic.entities[self.1[index].1].callsign
        }
        fn address(&self, _: usize) -> Option<u32> {
            None
        }
        fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
            let entity = &self.0.traffic.entities[self.1[index].1];
            let state = entity.trajectory.as_ref()?.at(time)?;
            Some(TargetState {
                position_m: state.position_m,
                velocity_mps: state.velocity_mps,
                heading_rad: state.heading_rad,
            })
        }
    }
    let scene = shipped("zurich");
    let mut chains = Chains::new(Arc::clone(&scene), 1).expect("sensors");
    let mut sensors: Vec<_> = scene
        .sensors
        .iter()
        .filter_map(|s| s.made(&scene, scene.tolerance()).expect("a sensor"))
        .collect();
    let own = chains.chains.iter().position(|c| c.run).expect("the run's own");
    let (mut apart2, mut pairs, mut alone) = (0.0, 0, 0);
    for work in works(&scene, 100, 60) {
        let between = Between::of(&scene, &work, scene.run.scan());
        let interval = ScanInterval {
            run_seed: 1,
            scan: work.scan,
            from: SimTime(work.to.0 - scene.run.scan().0),
            to: work.to,
        };
        let there = |t: &Target<'_>| (t.key, (t.key & 0xffff) as usize - 1);
        let exactly = Exactly(&scene, between.targets.iter().map(there).collect());
        let (mut a, mut b) = (PlotSink::default(), PlotSink::default());
        let weather = &scene.weather[0].weather;
        for (sensor, chain) in sensors.iter_mut().zip(&mut chains.chains[own].sensors) {
            sensor.scan(&interval, &exactly, weather, &mut a);
            chain.scan(&interval, &between, weather, &mut b);
        }
        let found = apart(&by_target(&a), &by_target(&b));
        (apart2, pairs, alone) = (apart2 + found.0, pairs + found.1, alone + found.2);
    }
    let apart_m = (apart2 / f64::from(pairs)).sqrt();
    assert!(apart_m < 0.1, "{apart_m} m over {pairs} plots");
    assert!(f64::from(alone) <= 0.005 * f64::from(pairs), "{alone} of {pairs}");
}

#[test]
fn the_ladder_holds_the_scene_s_own_tolerance_once() {
    let of = |position_m: f64| Tolerance { position_m, ..Tolerance::default() };
    for (own, rows) in [(of(0.1), 7), (of(0.3), 8), (Tolerance::EXACT, 7)] {
        let found = ladder(own);
        assert_eq!(found.len(), rows, "{own:?}");
        assert_eq!(found.iter().filter(|row| row.1).count(), 1, "{own:?}");
        assert!(found.iter().any(|row| row.1 && row.0 == own), "{own:?}");
        assert_eq!(found[0].0.position_m, 0.0);
        assert!(found.is_sorted_by(|a, b| a.0.position_m <= b.0.position_m), "{own:?}");
    }
    // Half the distance is half of everything.
    let half = ladder(of(0.1)).into_iter().find(|r| r.0.position_m == 0.05).expect("0.05 m").0;
    assert!((half.detection - 0.005).abs() < 1e-12 && (half.tail - 0.0005).abs() < 1e-12);
    // Nothing for the position, but something else: not the exact row.
    let rest = ladder(of(0.0));
    assert!(rest[0].0.detection == 0.0 && !rest[0].1 && rest.iter().filter(|r| r.1).count() == 1);
    let budget = Tolerance { time_budget_us: Some(50.0), ..Tolerance::default() };
    assert!(ladder(budget).iter().all(|row| row.1 == row.0.time_budget_us.is_some()));
}

#[test]
fn a_thread_makes_them_and_ends_with_its_owner() {
    let scene = shipped("zurich");
    let (send, receive) = crossbeam_channel::unbounded();
    let mut beside = Tolerances::begin(Arc::clone(&scene), 1, move |told| {
        send.send(told).ok();
    });
    let report = |work: &Work| ScanReport {
        scan: work.scan,
        time_ns: work.to.0,
        truth: work.truth.clone(),
        ..ScanReport::default()
    };
    // Far faster than real time: some are left out, and that is said.
    let all = works(&scene, 100, 40);
    all.iter().for_each(|w| beside.scan(&report(w), &FlightList::default(), Some(1.0)));
    let told = receive.recv_timeout(std::time::Duration::from_secs(90)).expect("told");
    assert!(told.taken <= 1.0 && told.rows.len() == 7 && told.why_not.is_empty(), "{told:?}");
    drop(beside);
    let wait = std::time::Duration::from_secs(90);
    let end = loop {
        if let Err(end) = receive.recv_timeout(wait) {
            break end;
        }
    };
    assert!(end.is_disconnected(), "the thread has ended");
}
