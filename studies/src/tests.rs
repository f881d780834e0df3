//! The error columns of the ladders that have no snapshot of their own, and the list of ladders.

use crate::{GROUPS, Options, Outcome};

fn quick(seed: u64) -> Options {
    Options { quick: true, seed, ..Options::default() }
}

/// Everything but the times, with as many digits as mean something.
fn columns(outcome: &Outcome) -> String {
    let number = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.2}"));
    let mut out = String::new();
    for r in &outcome.rows {
        // What a rung's name says of time is no error.
        let rung = r.rung.split(" (the plan saves").next().unwrap_or("");
        out += &format!("{} | {} | {rung} |", r.group, r.scene);
        for value in [r.rmse_m, r.p95_m, r.nees, r.lost_pct, r.swaps_pct, r.gospa, r.error, r.cost]
        {
            out += " ";
            out += &number(value);
        }
        out += if r.failed.is_empty() { "\n" } else { " FAILED\n" };
    }
    out
}

#[test]
fn the_error_columns_are_those_of_the_snapshot() {
    let own = ["filters", "gates", "association"];
    let mut out = String::from(
        "group | scene | rung | rmse_m p95_m nees lost_pct swaps_pct gospa error cost\n",
    );
    for (name, study) in GROUPS.iter().filter(|(name, _)| !own.contains(name)) {
        let outcome = study(&quick(3), &mut |_| ());
        assert!(!outcome.rows.is_empty(), "{name}");
        out += &columns(&outcome);
    }
    insta::assert_snapshot!(out);
}

#[test]
fn an_unknown_group_is_refused_with_the_names_of_all() {
    let asked = Options { only: Some("nonsense".into()), ..quick(1) };
    let refused = crate::run(&asked, &mut |_| ()).expect_err("no such group").to_string();
    for (name, _) in GROUPS {
        assert!(refused.contains(name), "{refused}");
    }
}
