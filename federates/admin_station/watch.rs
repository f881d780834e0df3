//! How a run stands, again and again: a screen or tables in the terminal, or rows of figures for other programs.

mod draw;
mod keys;
mod screen;
#[cfg(test)]
mod screen_tests;
mod shown;

use crate::exchange::operator;
use crate::runtime::bus::Bus;
use crate::runtime::cli::print_line;
use crate::runtime::clock::utc_ns;
use serde_json::Value;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Cursor to the upper left corner, and all below it cleared.
const HOME: &str = "\x1b[H\x1b[J";

/// The first row of the figures.
pub(super) const COLUMNS: &str = "utc_s,run,phase,frame,sim_s,rate,achieved_rate,federate,host,health,heard_ms,behind_frames,executed,latency_us,cpu_pct,cpu_s,rss_bytes,pdus_in,pdus_out,lost,repaired,exec_us,exec_max_us,alarms,reasons";

/// Asks every `every` and shows or writes the answer; `figures` is a file, `-` for the output of this process. In a terminal a
/// screen shows it until the person leaves, unless tables are wanted (`plain`); tables and rows go on until the station is gone.
///
/// # Errors
/// If no station answers at first, the figures cannot be written, or the terminal cannot be used.
pub(super) fn watch(
    bus: &Arc<dyn Bus>,
    endpoint: &str,
    every: Duration,
    figures: Option<&Path>,
    plain: bool,
) -> anyhow::Result<()> {
    let to_output = figures == Some(Path::new("-"));
    let mut file = match figures {
        Some(path) if !to_output => Some(
            std::fs::File::create(path).map_err(|e| anyhow::anyhow!("{}: {e}", path.display()))?,
        ),
        _ => None,
    };
    let mut begun = false;
    let mut write = |statistics: &Value| -> anyhow::Result<()> {
        if figures.is_none() {
            return Ok(());
        }
        let head = (!std::mem::replace(&mut begun, true)).then(|| COLUMNS.to_owned());
        let rows = rows(utc_ns() as f64 * 1e-9, statistics);
        for line in head.into_iter().chain(rows) {
            match &mut file {
                Some(file) => file.write_all(format!("{line}\n").as_bytes())?,
                None => print_line(&line),
            }
        }
        Ok(())
    };
    let terminal = std::io::stdout().is_terminal();
    let mut statistics = operator::statistics(&**bus, endpoint)?;
    write(&statistics)?;
    if terminal && !to_output && !plain && draws() {
        return screen::show(bus, endpoint, every, &statistics, write);
    }
    loop {
        if !to_output {
            let home = if terminal { HOME } else { "" };
            print_line(&format!("{home}{}", operator::table(&statistics)));
        }
        std::thread::sleep(every);
        let Ok(next) = operator::statistics(&**bus, endpoint) else { return Ok(()) };
        statistics = next;
        write(&statistics)?;
    }
}

/// Whether keys can come from a person, and the terminal moves its cursor.
fn draws() -> bool {
    std::io::stdin().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// One row for each member and spectator.
pub(super) fn rows(utc_s: f64, statistics: &Value) -> Vec<String> {
    let state = &statistics["state"];
    let number = |value: &Value| value.as_f64().unwrap_or(0.0);
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let sentences = |value: &Value| -> String {
        value.as_array().into_iter().flatten().map(text).collect::<Vec<_>>().join("; ")
    };
    let rate = state["rate"].as_f64().map_or_else(|| "fast".to_owned(), |rate| rate.to_string());
    let sim_s = number(&state["frame"]) * number(&state["step_ns"]) * 1e-9;
    let members = state["members"].as_array().into_iter().flatten();
    members
        .map(|member| {
            let name = text(&member["name"]);
            let own = &statistics["federates"][&name];
            let figure = |key: &str| own[key].as_f64().map(|n| n.to_string()).unwrap_or_default();
            let fields = [
                format!("{utc_s:.3}"),
                text(&state["run"]),
                text(&state["phase"]),
                text(&state["frame"]),
                format!("{sim_s:.3}"),
                rate.clone(),
                format!("{:.3}", number(&state["achieved_rate"])),
                name,
                text(&member["host"]),
                text(&member["health"]),
                member["heard_ms"].as_u64().map(|ms| ms.to_string()).unwrap_or_default(),
                text(&member["behind"]),
                text(&member["frame"]),
                format!("{:.0}", number(&member["latency_us"])),
                figure("cpu_pct"),
                figure("cpu_s"),
                figure("rss_bytes"),
                figure("pdus_in"),
                figure("pdus_out"),
                figure("lost"),
                figure("repaired"),
                figure("exec_us"),
                figure("exec_max_us"),
                sentences(&own["alarms"]),
                sentences(&state["reasons"]),
            ];
            fields.map(|field| quoted(&field)).join(",")
        })
        .collect()
}

/// A field as RFC 4180 wants it.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_member_has_a_row_with_as_many_fields_as_there_are_columns() {
        let statistics = json!({
            "state": {
                "run": 1, "phase": "FROZEN", "frame": 40, "step_ns": 50_000_000, "rate": null,
                "achieved_rate": 0.0,
                "reasons": ["smdfm is lost: \"gone\", it seems", "late"],
                "members": [
                    { "name": "smdfm", "host": "a,b", "health": "lost", "heard_ms": 2100, "behind": 5,
                      "frame": 35, "latency_us": 12.4 },
                    { "name": "viewer-logger", "host": "c", "health": "alive", "heard_ms": null,
                      "behind": 0, "frame": 40, "latency_us": 0.0 },
                ],
            },
            "federates": { "smdfm": { "cpu_pct": 12.5, "lost": 3, "alarms": ["hears none"] } },
        });
        let rows = rows(1.25, &statistics);
        let smdfm = "1.250,1,FROZEN,40,2.000,fast,0.000,smdfm,\"a,b\",lost,2100,5,35,12,12.5,null,null,null,null,3,null,null,null,hears none,\"smdfm is lost: \"\"gone\"\", it seems; late\"";
        assert_eq!(rows[0], smdfm.replace("null", ""));
        assert!(rows[1].contains("viewer-logger,c,alive,,0,40,0,,,"), "{}", rows[1]);
        let outside = rows[1].split('"').step_by(2).map(|part| part.matches(',').count());
        assert_eq!(outside.sum::<usize>() + 1, COLUMNS.split(',').count());
    }
}
