//! A reference for people and programs: its trajectories as CSV, its sensors and its score as text and JSON.

use crate::chain::Sum;
use crate::reference::{Compared, Errors};
use models::fusion::reference::{Found, ReferenceRun, Trajectory};
use serde_json::{Value, json};
use std::fmt::Write;

/// Heads of [`csv()`].
pub const HEADS: &str = "time_s,track,callsign,x_m,y_m,vx_ms,vy_ms,var_ee_m2,var_en_m2,var_nn_m2,vvar_ee,vvar_en,vvar_nn,stands,plot_s";

/// All points, trajectory by trajectory; `track` counts trajectories from 1.
#[must_use]
pub fn csv(run: &ReferenceRun) -> String {
    let mut out = format!("{HEADS}\n");
    for (k, way) in run.trajectories.iter().enumerate() {
        let name = name(way);
        for p in &way.points {
            let (x, v) = (&p.position_cov_m2, &p.velocity_cov_m2s2);
            let _ = writeln!(
                out,
                "{},{},{name},{:.3},{:.3},{:.3},{:.3},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{},{:.3}",
                p.time.s(),
                k + 1,
                p.position_m.x,
                p.position_m.y,
                p.velocity_mps.x,
                p.velocity_mps.y,
                x[(0, 0)],
                x[(0, 1)],
                x[(1, 1)],
                v[(0, 0)],
                v[(0, 1)],
                v[(1, 1)],
                u8::from(p.stands),
                p.plot_s
            );
        }
    }
    out
}

fn name(way: &Trajectory) -> String {
    way.callsign.map_or_else(String::new, |c| c.as_str().replace([',', '"'], "_"))
}

/// The same, and of the score, as JSON.
#[must_use]
pub fn json(run: &ReferenceRun, compared: Option<&Compared>) -> Value {
    let found = |f: &Found| json!({ "value": f.value, "sigma": f.sigma, "known": f.known });
    let sites: Vec<Value> = run
        .sites
        .iter()
        .map(|s| {
            json!({
                "sensor": s.sensor.0, "range_m": found(&s.range_m), "azimuth_rad": found(&s.azimuth_rad),
                "time_s": found(&s.time_s),
            })
        })
        .collect();
    let ways: Vec<Value> = run
        .trajectories
        .iter()
        .enumerate()
        .map(|(k, way)| {
            let tracks: Vec<u16> = way.tracks.iter().map(|t| t.1).collect();
            json!({
                "track": k + 1, "callsign": name(way), "plots": way.plots, "points": way.points.len(),
                "tracks": tracks, "from_s": way.points.first().map(|p| p.time.s()),
                "to_s": way.points.last().map(|p| p.time.s()),
            })
        })
        .collect();
    let statistics = &run.statistics;
    json!({
        "sites": sites, "kappa_aircraft": found(&run.kappa[0]), "kappa_vehicle": found(&run.kappa[1]),
        "trajectories": ways, "plots": statistics.plots, "unsound": statistics.unsound,
        "duplicates": statistics.duplicates, "score": compared.map(score_json),
    })
}

fn score_json(c: &Compared) -> Value {
    let sum = |s: &Sum| match s.count {
        0 => json!({ "count": 0 }),
        count => json!({ "count": count, "rmse_m": s.rmse_m(), "nees": s.nees() }),
    };
    let errors = |e: &Errors| json!({ "all": sum(&e.all), "moving": sum(&e.moving), "standing": sum(&e.standing) });
    json!({
        "published": errors(&c.now[0]), "reference_then": errors(&c.now[1]),
        "second_ago": errors(&c.ago[0]), "reference_then_ago": errors(&c.ago[1]),
        "every_point": errors(&c.every), "far": c.far, "gone": c.gone, "missing": c.missing,
    })
}

/// For a person at a terminal.
#[must_use]
pub fn text(
    run: &ReferenceRun,
    compared: Option<&Compared>,
    sensor: &dyn Fn(u16) -> String,
) -> String {
    let points: usize = run.trajectories.iter().map(|w| w.points.len()).sum();
    let mut out = format!("{} trajectories, {points} points\n", run.trajectories.len());
    if run.statistics.unsound + run.statistics.duplicates > 0 {
        let _ = writeln!(
            out,
            "left out: {} plots that are none (not finite, impossible), {} copies",
            run.statistics.unsound, run.statistics.duplicates
        );
    }
    for site in &run.sites {
        let parts = [
            shown("range", &site.range_m, 1.0, "m"),
            shown("azimuth", &site.azimuth_rad, 1e3, "mrad"),
            shown("time", &site.time_s, 1.0, "s"),
        ];
        let _ = writeln!(out, "{}: {}", sensor(site.sensor.0), parts.join(", "));
    }
    if !run.sites.is_empty() {
        let parts =
            [shown("aircraft", &run.kappa[0], 1.0, ""), shown("vehicles", &run.kappa[1], 1.0, "")];
        let _ =
            writeln!(out, "near side of echoes, share of the half length: {}", parts.join(", "));
    }
    let Some(c) = compared else {
        out.push_str("no truth in this log: no score\n");
        return out;
    };
    let _ = writeln!(
        out,
        "{:<38} {:>7} {:>7} {:>6}   moving          standing",
        "against the truth", "points", "rms, m", "NEES"
    );
    let lines = [
        ("published", &c.now[0]),
        ("reference at these targets and times", &c.now[1]),
        ("one second ago", &c.ago[0]),
        ("reference at these targets and times", &c.ago[1]),
        ("reference, every point", &c.every),
    ];
    for (name, e) in lines.into_iter().filter(|(_, e)| e.all.count > 0) {
        let part = |s: &Sum| match s.count {
            0 => "–".to_owned(),
            _ => format!("{:.2} m, {:.2}", s.rmse_m(), s.nees()),
        };
        let _ = writeln!(
            out,
            "{name:<38} {:>7} {:>7.2} {:>6.2}   {:<15} {}",
            e.all.count,
            e.all.rmse_m(),
            e.all.nees(),
            part(&e.moving),
            part(&e.standing)
        );
    }
    let _ = writeln!(
        out,
        "{} points beyond 60 m of their target, {} of targets that were not there, {} reports without a point",
        c.far, c.gone, c.missing
    );
    out
}

fn shown(word: &str, f: &Found, scale: f64, unit: &str) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    // Nothing is written with a minus before it.
    let value = (scale * f.value * 1e3).round() / 1e3 + 0.0;
    match f.known {
        true => format!("{word} {value:.3} ± {:.3}{unit}", scale * f.sigma),
        false if value == 0.0 => format!("{word} not known"),
        false => format!("{word} not known ({value:.3} assumed)"),
    }
}
