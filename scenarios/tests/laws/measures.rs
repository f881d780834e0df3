//! Measures of traffic against plain arithmetic on what each flight did.

use models::traffic::core::{Core, Direction};
use models::traffic::measured::measured;
use std::path::Path;

fn flown(traffic: &str, seed: u64, seconds: i64) -> Core {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nstart = 2026-05-12T06:00:00Z\nduration_s = 3600\n[airport]\n\
         layout = \"airports/XSYN.apt.dat\"\n{traffic}"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("measures.toml");
    let scene = scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"));
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, seed).expect("with truth");
    (1..=seconds * 20).for_each(|frame| core.step(frame));
    core
}

fn value(core: &Core, name: &str) -> Option<f64> {
    measured(core).into_iter().find(|m| m.name == name).map(|m| m.value)
}

#[test]
fn separations_and_delays_are_those_of_the_movements() {
    for (seed, rate) in [(3, 20), (8, 30)] {
        let traffic = format!(
            "[[traffic]]\nkind = \"generated\"\narrivals_per_h = {rate}\ndepartures_per_h = {rate}\n"
        );
        let core = flown(&traffic, seed, 4200);
        let runways: Vec<String> =
            core.network().runways.iter().flat_map(|r| r.names.clone()).collect();
        let mut looked_at = 0;
        for name in &runways {
            let mut at: Vec<(f64, usize)> = (0..core.flights().len())
                .filter(|f| {
                    let (r, end) = core.flights()[*f].runway;
                    core.network().runways[r].names[end] == *name
                })
                .filter_map(|f| Some((core.measures(f).atot_s?, f)))
                .collect();
            at.sort_by(|a, b| a.0.total_cmp(&b.0));
            let surplus: Vec<f64> = at
                .windows(2)
                .map(|w| {
                    let [a, b] = [w[0].1, w[1].1].map(|f| core.flights()[f].wake);
                    w[1].0 - w[0].0 - a.departure_gap_s(b)
                })
                .filter(|s| *s < 300.0)
                .collect();
            let told = value(&core, &format!("take_off_surplus_mean {name}"));
            if surplus.is_empty() {
                assert_eq!(told, None, "{name}");
                continue;
            }
            let mean = surplus.iter().sum::<f64>() / surplus.len() as f64;
            assert!((told.expect("told") - mean).abs() < 1e-9, "{name}: {told:?} {mean}");
            // Nobody rolls before the wake of the one before has gone, nor lands nearer than its distance.
            for kind in ["take_offs", "landings"] {
                let close = value(&core, &format!("{kind}_too_close {name}")).unwrap_or(0.0);
                assert_eq!(close, 0.0, "seed {seed}: {kind} {name}");
            }
            looked_at += surplus.len();
        }
        assert!(looked_at > 5, "seed {seed}: {looked_at} pairs");
        let mut added: Vec<f64> = (0..core.flights().len())
            .filter(|f| core.flights()[*f].direction == Direction::Departure)
            .filter_map(|f| core.measures(f).additional_s())
            .collect();
        added.sort_by(f64::total_cmp);
        let most = value(&core, "taxi_out_additional_95_percent").expect("told");
        let beyond = added.iter().filter(|a| **a > most).count();
        assert!(added.contains(&most) && beyond as f64 <= 0.05 * added.len() as f64, "{beyond}");
        let mean = value(&core, "taxi_out_additional_mean").expect("told");
        assert!((mean - added.iter().sum::<f64>() / added.len() as f64).abs() < 1e-9);
        assert_eq!(value(&core, "slots_kept"), None, "nobody has a slot");
        assert_eq!(value(&core, "start_ups_kept"), None, "nobody waits for a start-up approval");
    }
}

/// Two departures with slots that they keep, one whose slot was over before it could leave, one without.
#[test]
fn slots_count_from_five_minutes_before_to_ten_after() {
    let file = std::env::temp_dir().join(format!("seeds-slots-{}.csv", std::process::id()));
    let rows = "callsign,type,movement,runway,stand,tobt,ctot\n\
                A1,A320,departure,09,C1,2026-05-12T06:05:00Z,2026-05-12T06:25:00Z\n\
                A2,A320,departure,09,C2,2026-05-12T06:06:00Z,2026-05-12T06:30:00Z\n\
                A3,A320,departure,09,C3,2026-05-12T06:40:00Z,2026-05-12T06:10:00Z\n\
                A4,A320,departure,09,C4,2026-05-12T06:15:00Z,\n";
    std::fs::write(&file, rows).expect("written");
    let traffic = format!(
        "[[traffic]]\nkind = \"schedule\"\nfile = {:?}\n[control]\nsequence = \"cps\"\n",
        file.display().to_string()
    );
    let core = flown(&traffic, 3, 4200);
    std::fs::remove_file(&file).expect("removed");
    let late: Vec<Option<f64>> =
        (0..4).map(|f| Some(core.measures(f).atot_s? - core.flights()[f].ctot_s?)).collect();
    let kept = late.iter().flatten().filter(|l| (-300.0..=600.0).contains(*l)).count();
    assert!(kept >= 1, "{late:?}");
    let share = value(&core, "slots_kept").expect("told");
    assert!((share - 100.0 * kept as f64 / 3.0).abs() < 1e-9, "{share} {late:?}");
    let kept = |f: &usize| {
        let tsat_s = core.milestones(*f).expect("in the sequence").tsat_s;
        (core.measures(*f).aobt_s.expect("left") - tsat_s).abs() <= 300.0
    };
    let start_ups = 100.0 * (0..4).filter(kept).count() as f64 / 4.0;
    let told = value(&core, "start_ups_kept").expect("told");
    assert!(start_ups > 0.0 && (told - start_ups).abs() < 1e-9, "{told} {start_ups}");
    // Delay counts from the begin of the slot where that is later than the way alone.
    let alone = |f: usize| core.flights()[f].time_s + core.measures(f).unhindered_s;
    let from = |f: usize| {
        let opens = core.flights()[f].ctot_s.map_or(f64::MIN, |c| c - 300.0);
        alone(f).max(opens)
    };
    assert!(from(1) > alone(1), "its slot opens after it could be there");
    let mean: f64 =
        (0..4).map(|f| core.measures(f).atot_s.expect("left") - from(f)).sum::<f64>() / 4.0;
    let told = value(&core, "take_off_delay_mean").expect("told");
    assert!((told - mean).abs() < 1e-9, "{told} {mean}");
}
