//! Tests of fitted figures.

use super::*;

#[test]
fn a_scene_whose_traffic_only_moves_in_a_run_is_refused() {
    let scene = scenarios::load(&scenarios::locate("xsyn")).expect("ships");
    let make = || zurich::sensors(&scene);
    let refused = run(&scene, &make, (1, 1), 60.0, "test", &mut |_| ());
    let reason = refused.map(|report| report.closing()).expect_err("nobody moves");
    assert!(reason.contains("xsyn") && reason.contains("schedule"), "{reason}");
    assert!(has_movements(&zurich::scene().expect("ships"), 60.0).is_ok());
}

#[test]
fn where_nobody_is_followed_that_is_said_in_words() {
    let way = |name| Way { name, score: Score::default(), sensors_us: 3.0, tracking_us: 1.0 };
    let report = FitReport {
        scene: "own".into(),
        scene_hash: 0,
        fitted_on: vec![1],
        compared_on: vec![2],
        version: String::new(),
        sensors: Vec::new(),
        tracker: Err("too few".into()),
        ways: vec![way("on-line"), way("off-line")],
    };
    let text = report.closing();
    assert!(text.contains("no track follows anybody; off-line takes 4.0 µs"), "{text}");
    assert!(!format!("{text}{}", report.to_text()).contains("NaN"), "{}", report.to_text());
}

#[test]
fn off_line_figures_give_nearly_the_errors_of_the_chain_that_they_were_fitted_from() {
    let scene = zurich::scene().expect("ships");
    let make = || zurich::sensors(&scene);
    let report = run(&scene, &make, (1, 1), 240.0, "test", &mut |_| ()).expect("sound");
    println!("{}", report.to_text());
    assert_eq!(report.ways.len(), 3);
    let online = report.ways[0].score.rmse_m().expect("tracks");
    for way in &report.ways[1..] {
        let offline = way.score.rmse_m().expect("tracks");
        assert!((0.6..1.5).contains(&(offline / online)), "{}: {offline} {online}", way.name);
    }
    assert!(report.sensors[0].figures.is_ok());
    let json = report.to_json();
    assert_eq!(json["comparison"].as_array().expect("list").len(), 3);
}
