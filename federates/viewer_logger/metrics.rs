//! The run as Prometheus text, for `/metrics`. Format: Prometheus exposition format, version 0.0.4.

use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{FederateStatus, Health, RunState};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Type of the text, for the answer's head.
pub const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// A figure of each federate: name, kind, what it is, and how it is read.
type Figure = (&'static str, &'static str, &'static str, fn(&FederateStatus) -> f64);

const FIGURES: [Figure; 10] = [
    ("frame", "gauge", "Last frame executed.", |s| s.frame as f64),
    ("cpu_seconds_total", "counter", "Processor time since the start.", |s| s.cpu_s),
    ("resident_memory_bytes", "gauge", "Resident memory.", |s| s.rss_bytes as f64),
    ("pdus_received_total", "counter", "PDUs received.", |s| s.pdus_in as f64),
    ("pdus_sent_total", "counter", "PDUs sent.", |s| s.pdus_out as f64),
    ("pdus_lost_total", "counter", "PDUs that did not arrive by themselves.", |s| s.lost as f64),
    ("pdus_repaired_total", "counter", "PDUs fetched again by request.", |s| s.repaired as f64),
    ("dropped_total", "counter", "Datagrams or PDUs dropped as unsound.", |s| {
        s.dropped.iter().map(|(_, count)| *count).sum::<u64>() as f64
    }),
    ("step_seconds", "gauge", "Mean time to execute a frame or scan.", |s| s.exec_us * 1e-6),
    ("alarms", "gauge", "Sentences that a person should look after.", |s| s.alarms.len() as f64),
];

/// The text.
#[must_use]
pub fn text<'a>(
    state: Option<&RunState>,
    federates: impl Iterator<Item = &'a FederateStatus> + Clone,
    measures: &BTreeMap<String, f64>,
) -> String {
    let mut out = String::new();
    if let Some(state) = state {
        let step_s = state.step_ns as f64 * 1e-9;
        head(&mut out, "seeds_phase", "gauge", "1 for the phase of the run, 0 for the others.");
        for phase in [Phase::Init, Phase::Configured, Phase::Running, Phase::Frozen, Phase::Stopped]
        {
            let is = u8::from(state.phase == phase);
            let _ = writeln!(out, "seeds_phase{{phase=\"{phase}\"}} {is}");
        }
        for (name, kind, help, value) in [
            (
                "run_number",
                "gauge",
                "Number of the run; a restart counts it up.",
                f64::from(state.run),
            ),
            ("frame", "gauge", "Lowest frame that all have executed.", state.frame as f64),
            ("last_frame", "gauge", "Last frame of the run.", state.last_frame as f64),
            ("simulated_seconds", "gauge", "Simulated time.", state.frame as f64 * step_s),
            ("rate", "gauge", "Simulated seconds per second asked for.", state.rate),
            (
                "achieved_rate",
                "gauge",
                "Simulated seconds per second achieved.",
                state.achieved_rate,
            ),
            (
                "faults",
                "gauge",
                "Reasons for a degraded or frozen run.",
                state.reasons.len() as f64,
            ),
        ] {
            head(&mut out, &format!("seeds_{name}"), kind, help);
            let _ = writeln!(out, "seeds_{name} {}", number(value));
        }
        head(&mut out, "seeds_member_alive", "gauge", "1 while a member is joined and alive.");
        for member in &state.members {
            let (name, alive) = (label(&member.name), u8::from(member.alive));
            let _ = writeln!(out, "seeds_member_alive{{federate=\"{name}\"}} {alive}");
        }
        head(
            &mut out,
            "seeds_member_latency_seconds",
            "gauge",
            "From a grant to the frame ends that answer it, smoothed.",
        );
        for member in &state.members {
            let (name, latency) = (label(&member.name), number(member.latency_us * 1e-6));
            let _ = writeln!(out, "seeds_member_latency_seconds{{federate=\"{name}\"}} {latency}");
        }
    }
    if let Some(state) = state {
        head(&mut out, "seeds_member_health", "gauge", "1 for how a member does, 0 for the rest.");
        for member in &state.members {
            for health in Health::ALL {
                let (name, is) = (label(&member.name), u8::from(member.health == health));
                let word = health.word();
                let _ = writeln!(
                    out,
                    "seeds_member_health{{federate=\"{name}\",health=\"{word}\"}} {is}"
                );
            }
        }
        head(&mut out, "seeds_member_heard_seconds", "gauge", "Since a member was last heard of.");
        for member in &state.members {
            let Some(heard_ms) = member.heard_ms else { continue };
            let (name, heard_s) = (label(&member.name), number(heard_ms as f64 * 1e-3));
            let _ = writeln!(out, "seeds_member_heard_seconds{{federate=\"{name}\"}} {heard_s}");
        }
        let help = "Frames that a member may execute and has not.";
        head(&mut out, "seeds_member_behind_frames", "gauge", help);
        for member in &state.members {
            let (name, behind) = (label(&member.name), number(member.behind as f64));
            let _ = writeln!(out, "seeds_member_behind_frames{{federate=\"{name}\"}} {behind}");
        }
    }
    for (name, kind, help, figure) in FIGURES {
        head(&mut out, &format!("seeds_federate_{name}"), kind, help);
        for status in federates.clone() {
            let (federate, host) = (label(&status.name), label(&status.host));
            let value = number(figure(status));
            let _ = writeln!(
                out,
                "seeds_federate_{name}{{federate=\"{federate}\",host=\"{host}\"}} {value}"
            );
        }
    }
    head(
        &mut out,
        "seeds_measure",
        "gauge",
        "Measures of the run since its start, as the page names them.",
    );
    for (name, value) in measures {
        let _ = writeln!(out, "seeds_measure{{name=\"{}\"}} {}", label(name), number(*value));
    }
    out
}

fn head(out: &mut String, name: &str, kind: &str, help: &str) {
    let _ = writeln!(out, "# HELP {name} {help}\n# TYPE {name} {kind}");
}

/// A label's value: backslash, quote and line feed are escaped.
fn label(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

fn number(value: f64) -> String {
    match value {
        v if v.is_nan() => "NaN".to_owned(),
        v if v == f64::INFINITY => "+Inf".to_owned(),
        v if v == f64::NEG_INFINITY => "-Inf".to_owned(),
        v => v.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::MemberState;

    /// Metric, labels and value of a line, by the grammar of the format.
    fn parse(line: &str) -> (String, String, f64) {
        let (name, value) = line.rsplit_once(' ').expect("a value");
        let value = match value {
            "+Inf" => f64::INFINITY,
            value => value.parse().unwrap_or_else(|_| panic!("{line}")),
        };
        let (metric, labels) = name.split_once('{').unwrap_or((name, "}"));
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        assert!(metric.starts_with("seeds_") && metric.chars().all(word), "{line}");
        (metric.to_owned(), labels.strip_suffix('}').expect("closed").to_owned(), value)
    }

    #[test]
    fn every_line_is_a_sample_of_a_metric_that_was_declared() {
        let member = MemberState {
            name: "smdfm".into(),
            alive: true,
            health: Health::Late,
            heard_ms: Some(120),
            behind: 5,
            ..MemberState::default()
        };
        let state = RunState {
            phase: Phase::Running,
            frame: 40,
            step_ns: 50_000_000,
            rate: f64::INFINITY,
            members: vec![member],
            ..RunState::default()
        };
        let federates = [FederateStatus {
            name: "sm\"d\\fm\n".into(),
            host: "here".into(),
            pdus_in: 7,
            dropped: vec![("a".into(), 2), ("b".into(), 3)],
            ..FederateStatus::default()
        }];
        let measures = BTreeMap::from([("rmse_m".to_owned(), 3.25)]);
        let text = text(Some(&state), federates.iter(), &measures);
        let mut declared = Vec::new();
        let mut samples = BTreeMap::new();
        for line in text.lines() {
            if let Some(declaration) = line.strip_prefix("# TYPE ") {
                let name = declaration.split(' ').next().expect("a name").to_owned();
                assert!(!declared.contains(&name), "{name} twice");
                declared.push(name);
            } else if !line.starts_with("# HELP ") {
                let (metric, labels, value) = parse(line);
                assert_eq!(declared.last(), Some(&metric), "samples stand below their metric");
                samples.insert((metric, labels), value);
            }
        }
        for (metric, labels, value) in [
            ("seeds_phase", "phase=\"RUNNING\"", 1.0),
            ("seeds_phase", "phase=\"FROZEN\"", 0.0),
            ("seeds_simulated_seconds", "", 2.0),
            ("seeds_rate", "", f64::INFINITY),
            ("seeds_member_alive", "federate=\"smdfm\"", 1.0),
            ("seeds_member_health", "federate=\"smdfm\",health=\"late\"", 1.0),
            ("seeds_member_health", "federate=\"smdfm\",health=\"alive\"", 0.0),
            ("seeds_member_heard_seconds", "federate=\"smdfm\"", 0.12),
            ("seeds_member_behind_frames", "federate=\"smdfm\"", 5.0),
            ("seeds_measure", "name=\"rmse_m\"", 3.25),
            ("seeds_federate_dropped_total", r#"federate="sm\"d\\fm\n",host="here""#, 5.0),
            ("seeds_federate_pdus_received_total", r#"federate="sm\"d\\fm\n",host="here""#, 7.0),
        ] {
            let found = samples.get(&(metric.to_owned(), labels.to_owned()));
            assert_eq!(found, Some(&value), "{metric}{{{labels}}} in\n{text}");
        }
    }
}
