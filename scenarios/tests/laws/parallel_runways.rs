//! Two runways beside each other: who crosses the near one to the far one is cleared for each as long as he is in its strip, and
//! nobody is told of an incursion where nobody errs.

#[allow(dead_code, reason = "this test draws by hand")]
use crate::drawn::Drawn;
use models::control::alert::Change;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::time::SimTime;
use models::traffic::core::Phase;
use models::traffic::exact::Watch;
use std::path::PathBuf;

/// What the safety net raises on exact truth within 75 minutes, and the clearances that were left open.
fn raised(gap_m: f64, seed: u64, arrivals: u32) -> (Vec<String>, usize) {
    let folder =
        PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("parallel-{gap_m}-{seed}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    let airport = Drawn::parallel(gap_m, [10.0, 900.0, 1700.0, 2590.0], &[(1, 14)]);
    std::fs::write(folder.join("X.apt.dat"), airport.text()).expect("a file");
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"X.apt.dat\"\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = {arrivals}\ndepartures_per_h = 14\n\
         arrival_runways = [\"13R\"]\ndeparture_runways = [\"13R\"]\n[control]\nstop_bars = true\n"
    );
    let scene = scenarios::load_text(&folder.join("scene.toml"), &text);
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    std::fs::remove_dir_all(&folder).expect("removed");
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, seed).expect("with truth");
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), true);
    let mut raised = Vec::new();
    for frame in 1..=90_000 {
        core.step(frame);
        if frame % 20 == 0 {
            let now = SimTime(frame * scene.run.frame.0);
            let new = watch.scan(&core, now).iter().filter(|c| c.0 == Change::Raised);
            raised.extend(new.map(|(_, alert)| {
                format!("{:.0} s {} {}", now.s(), alert.condition.kind.word(), alert.subjects())
            }));
        }
    }
    let crosses = core.clearances().iter().filter(|c| c.kind == "CRO");
    assert!(crosses.clone().count() >= 5, "{gap_m} m: nobody crosses");
    let open = crosses.filter(|c| c.until_s.is_none()).count();
    (raised, open)
}

#[test]
fn who_crosses_two_runways_is_cleared_for_each_while_he_is_in_its_strip() {
    // Also who lands where there is no room between both lines: his landing takes him off both strips.
    for (gap_m, seed, arrivals) in [(150.0, 3, 8), (196.0, 4, 8), (243.0, 5, 8)] {
        assert_eq!(raised(gap_m, seed, arrivals), (Vec::new(), 0), "{gap_m} m apart");
    }
}

/// The longest that a departure to the far runway stands with something of it in the strip of the near one, which others use, s, how many
/// have taken off, and how many crossings of these are still cleared.
fn stands_in_strip_s(gap_m: f64, seed: u64) -> (u32, usize, usize) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("between-{gap_m}-{seed}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    let airport = Drawn::parallel(gap_m, [10.0, 900.0, 1700.0, 2590.0], &[(1, 14), (2, 14)]);
    std::fs::write(folder.join("X.apt.dat"), airport.text()).expect("a file");
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"X.apt.dat\"\n[[traffic]]\n\
         kind = \"generated\"\nprofile = \"even\"\narrivals_per_h = 4\ndepartures_per_h = 60\n\
         arrival_runways = [\"13L\"]\ndeparture_runways = [\"13R\"]\n"
    );
    let scene = scenarios::load_text(&folder.join("scene.toml"), &text);
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    std::fs::remove_dir_all(&folder).expect("removed");
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let (network, pieces) = (&behaving.network, behaving.pieces.as_ref().expect("truth"));
    let near = network.runways.iter().position(|r| r.names.iter().any(|n| n == "13L"));
    let mut core = behaving.core(&scene.run, seed).expect("with truth");
    let count = core.flights().len();
    let mut stands_s = vec![0_u32; count];
    let mut longest_s = 0;
    for frame in 1..=90_000 {
        core.step(frame);
        if frame % 20 != 0 {
            continue;
        }
        for (f, stands_s) in stands_s.iter_mut().enumerate() {
            let still = core.state(f).is_some_and(|s| s.velocity_mps.norm() == 0.0);
            let there = core.phase(f) == Phase::Taxiing && still;
            let in_near = |z: &u32| pieces.list[*z as usize].strip == near;
            let stands = there && core.held_pieces(f).iter().any(in_near);
            *stands_s = if stands { *stands_s + 1 } else { 0 };
            longest_s = longest_s.max(*stands_s);
        }
    }
    let away = |f: usize| core.phase(f) == Phase::Gone;
    let crosses = core.clearances().iter().filter(|c| c.kind == "CRO" && away(c.flight));
    assert!(crosses.clone().count() >= 5, "{gap_m} m: nobody crosses");
    let open = crosses.filter(|c| c.until_s.is_none()).count();
    (longest_s, (0..count).filter(|f| core.measures(*f).atot_s.is_some()).count(), open)
}

/// Who has crossed a runway and has no room to stand clear of it before his own crosses when he may line up. At Punta Gorda the next departure
/// stood in the strip of 15/33, over which the one who was lined up on 27 had to roll, and neither moved for the rest of the hour (14 of
/// 14 flights not served, two seeds).
#[test]
fn nobody_waits_for_his_runway_in_the_strip_of_another() {
    for (gap_m, seed) in [(150.0, 1), (200.0, 2), (230.0, 3), (300.0, 1)] {
        let (longest_s, departed, open) = stands_in_strip_s(gap_m, seed);
        // At Punta Arenas 31 conflicts of clearances an hour with crossings that were over for minutes.
        assert_eq!(open, 0, "{gap_m} m: crossings that never end");
        assert!(departed >= 8, "{gap_m} m: {departed} departed");
        assert!(longest_s <= 20, "{gap_m} m: {longest_s} s");
    }
}

/// A junction so near to a runway that there is no room before it: one holds beyond it, not on the pavement of the runway (at Providence
/// aircraft stood 20 m from a centreline).
#[test]
fn nobody_holds_on_the_pavement_of_a_runway() {
    let mut a = Drawn { turned_rad: 2.1, ..Drawn::default() };
    a.runway(0.0, 0.0, 2600.0, 0.0, ["13", "31"]);
    let mut before: Option<usize> = None;
    for (i, x) in [10.0, 1200.0, 2590.0].into_iter().enumerate() {
        let (foot, junction) = (a.node(x, 0.0), a.node(x, 38.0));
        a.edge(foot, junction, false, &format!("E{i}"));
        for side in [-60.0, 60.0] {
            let top = a.node(x + side, 180.0);
            a.edge(junction, top, false, &format!("E{i}"));
            if let Some(before) = before {
                a.edge(before, top, false, "A");
            }
            before = Some(top);
        }
    }
    let lane = a.node(1200.0, 300.0);
    a.edge(before.expect("a taxiway"), lane, false, "C");
    a.stand(1200.0, 395.0, "S1");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("near-junction");
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("X.apt.dat");
    std::fs::write(&file, a.text()).expect("a file");
    let (airport, _) = scenarios::airport::check(&file).unwrap_or_else(|e| panic!("{e}"));
    std::fs::remove_dir_all(&folder).expect("removed");
    let net = models::traffic::network::Network::of(&airport);
    let holds: Vec<f64> = net
        .nodes
        .iter()
        .filter(|n| n.hold_for == Some(0))
        .map(|n| net.runways[0].place_m(n.at_m).1.abs())
        .collect();
    assert_eq!(holds.len(), 6, "{holds:?}");
    assert!(holds.iter().all(|m| (80.0..91.0).contains(m)), "{holds:?}");
}
