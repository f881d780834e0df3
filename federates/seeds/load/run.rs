//! One run of a load scene, and what its federates say of themselves meanwhile.

use crate::exchange::operator;
use crate::runtime::bus::Bus as _;
use crate::runtime::clock::monotonic_ns;
use crate::runtime::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use anyhow::Context;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Frames before that are the start of a run.
const SETTLED: u64 = 60;
/// A run that has not ended by then is given up.
const WITHIN_NS: u64 = 600_000_000_000;
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// What one run cost.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measured {
    pub(super) movers: usize,
    pub(super) generators: u32,
    /// Processor seconds per simulated second, by federate.
    pub(super) cores: BTreeMap<String, f64>,
    pub(super) pdus_per_s: f64,
    pub(super) latency_us: f64,
    /// PDUs that did not arrive by themselves.
    pub(super) lost: u64,
    /// Simulated seconds per wall second.
    pub(super) rate: f64,
}

impl Measured {
    /// Of all federates.
    pub(super) fn cores(&self) -> f64 {
        self.cores.values().sum()
    }

    /// Of the federates whose names begin so.
    pub(super) fn of(&self, begin: &str) -> f64 {
        self.cores.iter().filter(|(name, _)| name.starts_with(begin)).map(|(_, cores)| cores).sum()
    }
}

/// What a federate has said of itself: at its first settled frame, and last.
#[derive(Clone, Copy, Debug, Default)]
struct Said {
    frame: u64,
    cpu_s: f64,
    pdus_out: u64,
}

#[derive(Debug, Default)]
struct Samples {
    first: BTreeMap<String, Said>,
    last: BTreeMap<String, Said>,
    latency_us: f64,
    step_s: f64,
}

impl Samples {
    fn take(&mut self, statistics: &Value) {
        let state = &statistics["state"];
        self.step_s = state["step_ns"].as_f64().unwrap_or(0.0) * 1e-9;
        for (name, f) in statistics["federates"].as_object().into_iter().flatten() {
            let said = Said {
                frame: f["frame"].as_u64().unwrap_or(0),
                cpu_s: f["cpu_s"].as_f64().unwrap_or(0.0),
                pdus_out: f["pdus_out"].as_u64().unwrap_or(0),
            };
            if said.frame >= SETTLED && state["phase"] == "RUNNING" {
                self.first.entry(name.clone()).or_insert(said);
                self.last.insert(name.clone(), said);
            }
        }
        let of_generators = |m: &&Value| {
            m["name"].as_str().is_some_and(|name| name.starts_with("traffic-generator"))
        };
        let members = state["members"].as_array().into_iter().flatten().filter(of_generators);
        let slowest = members.filter_map(|m| m["latency_us"].as_f64()).fold(0.0, f64::max);
        if slowest > 0.0 {
            self.latency_us = slowest;
        }
    }

    /// What each federate spent in a simulated second, and PDUs a second of all.
    fn per_second(&self) -> (BTreeMap<String, f64>, f64) {
        let (mut cores, mut pdus_per_s) = (BTreeMap::new(), 0.0);
        for (name, last) in &self.last {
            let Some(first) = self.first.get(name) else { continue };
            let took_s = last.frame.saturating_sub(first.frame) as f64 * self.step_s;
            if took_s > 0.0 {
                cores.insert(name.clone(), (last.cpu_s - first.cpu_s) / took_s);
                pdus_per_s += last.pdus_out.saturating_sub(first.pdus_out) as f64 / took_s;
            }
        }
        (cores, pdus_per_s)
    }
}

/// Ends a run that was left.
struct Started(Child);

impl Drop for Started {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs a scene in real time, in processes.
pub(super) fn measure(scene: &Path, movers: usize, generators: u32) -> anyhow::Result<Measured> {
    let (port, dis) = (datalink::free_port()?, datalink::free_port()?);
    let endpoint = format!("tcp/127.0.0.1:{port}");
    let seeds = std::env::current_exe().context("finding this executable")?;
    let mut command = Command::new(seeds);
    command.arg("run").arg(scene);
    command.args(["--rate", "1", "--no-viewer", "--no-visitors", "--sync-listen", &endpoint]);
    command.args(["--dis", &format!("127.255.255.255:{dis}")]);
    command.args(["--generators", &generators.to_string()]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::inherit());
    let mut run = Started(command.spawn().context("starting a run")?);
    let mut samples = Samples::default();
    let mut bus: Option<ZenohBus> = None;
    let began = monotonic_ns();
    let status = loop {
        if let Some(status) = run.0.try_wait()? {
            break status;
        }
        anyhow::ensure!(
            monotonic_ns() - began < WITHIN_NS,
            "the run of {movers} movers does not end"
        );
        std::thread::sleep(LOOK_EVERY);
        if bus.is_none() {
            bus = ZenohBus::open(&ZenohConfig {
                part: Part::Peer,
                listen: vec![],
                connect: vec![endpoint.clone()],
                exercise: 1,
                connect_timeout: Duration::from_secs(1),
                certs: None,
            })
            .ok();
        }
        if let Some(Ok(statistics)) = bus.as_ref().map(|b| operator::statistics(b, &endpoint)) {
            samples.take(&statistics);
        }
    };
    if let Some(bus) = bus {
        bus.close();
    }
    anyhow::ensure!(status.success(), "the run of {movers} movers ended with {status}");
    let mut text = String::new();
    if let Some(mut out) = run.0.stdout.take() {
        std::io::Read::read_to_string(&mut out, &mut text)?;
    }
    let summary: Value = serde_json::from_str(text.lines().last().unwrap_or_default())
        .context("reading the summary of the run")?;
    let (cores, pdus_per_s) = samples.per_second();
    Ok(Measured {
        movers,
        generators,
        cores,
        pdus_per_s,
        latency_us: samples.latency_us,
        lost: summary["truth"]["lost"].as_u64().unwrap_or(0),
        rate: summary["rate"].as_f64().unwrap_or(0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_a_second_costs_is_counted_from_the_first_settled_frame_on() {
        let mut samples = Samples::default();
        let mut say = |frame: u64, cpu_s: f64, pdus: u64| {
            samples.take(&json!({
                "state": {"phase": "RUNNING", "step_ns": 50_000_000, "members": [
                    {"name": "smdfm", "latency_us": 900.0}, {"name": "traffic-generator-1", "latency_us": 250.0}]},
                "federates": {"traffic-generator-1": {"frame": frame, "cpu_s": cpu_s, "pdus_out": pdus}},
            }));
        };
        say(20, 7.0, 1_000);
        say(80, 8.0, 1_500);
        say(100, 8.25, 1_600);
        say(120, 8.5, 1_700);
        let (cores, pdus_per_s) = samples.per_second();
        assert_eq!(cores["traffic-generator-1"], 0.25);
        assert_eq!(pdus_per_s, 100.0);
        assert_eq!(samples.latency_us, 250.0);
    }
}
