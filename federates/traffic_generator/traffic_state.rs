//! What flights that behave are about, for pages: `obs/traffic`, JSON, once a scan, by the generator of share 1.
//!
//! ```json
//! {"time_s": 61.0,
//!  "movers": [{"callsign": "KLM123", "phase": "taxiing", "stand": "B 16", "runway": "18L",
//!              "authority_m": [[e, n], …], "planned_m": [[e, n], …], "held": [17, 18],
//!              "cleared": [{"kind": "TAX", "runway": "", "since_s": 30.0}],
//!              "waits": {"for": "BAW7", "at": "A (31-32)", "since_s": 42.0, "planned_s": 12.0}, "wants": "CRO"}],
//!  "runways": [{"name": "18L/36R", "owner": "DLH4", "queue": 2}]}
//! ```
//!
//! `authority_m`: from the mover to where it may drive now; `planned_m`: from there to the end of its way; m east and
//! north. `cleared`: what stands. `waits` and `wants` (a clearance) only while it waits; `for` is null where it waits for a clearance or the policy.

use models::traffic::core::{Core, Phase};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The state of a core.
#[must_use]
pub fn json(core: &Core, time_s: f64) -> String {
    let net = core.network();
    let rounded = |line: Vec<[f64; 2]>| -> Value {
        line.into_iter().map(|p| p.map(|x| (x * 10.0).round() / 10.0)).map(|p| json!(p)).collect()
    };
    let mut standing: BTreeMap<usize, Vec<Value>> = BTreeMap::new();
    for c in core.clearances().iter().filter(|c| c.until_s.is_none()) {
        let cleared = json!({"kind": c.kind, "runway": c.runway, "since_s": c.from_s});
        standing.entry(c.flight).or_default().push(cleared);
    }
    let mut movers = Vec::new();
    for (f, flight) in core.flights().iter().enumerate() {
        let Some(phase) = word(core.phase(f)) else { continue };
        let (authority, planned) = core.ways_ahead(f);
        let mut mover = json!({
            "callsign": flight.callsign,
            "phase": phase,
            "stand": net.stands[core.stand(f)].name,
            "runway": net.runways[flight.runway.0].names[flight.runway.1],
            "authority_m": rounded(authority),
            "planned_m": rounded(planned),
            "held": core.held_pieces(f),
            "cleared": standing.remove(&f).unwrap_or_default(),
        });
        if let Some(waits) = core.waiting(f) {
            mover["waits"] = json!({
                "for": waits.behind, "at": waits.place, "since_s": waits.since_s,
                "planned_s": waits.planned_s.map(f64::round),
            });
        }
        if let Some(kind) = core.wants(f) {
            mover["wants"] = json!(kind.word());
        }
        movers.push(mover);
    }
    let runway = |r: usize| {
        let (owner, queue) = core.runway_state(r);
        json!({"name": net.runways[r].names.join("/"), "owner": owner, "queue": queue})
    };
    let runways: Vec<Value> = (0..net.runways.len()).map(runway).collect();
    json!({"time_s": time_s, "movers": movers, "runways": runways}).to_string()
}

/// Word of a phase; `None`: not in the run.
fn word(phase: Phase) -> Option<&'static str> {
    Some(match phase {
        Phase::Absent | Phase::Gone => return None,
        Phase::Parked => "parked",
        Phase::Pushing => "pushing",
        Phase::Starting(_) => "starting",
        Phase::Taxiing => "taxiing",
        Phase::LinedUp(_) => "lined up",
        Phase::Rolling => "rolling",
        Phase::Final => "final",
        Phase::GoAround => "going around",
        Phase::Landing => "landing",
        Phase::Docked => "docked",
    })
}
