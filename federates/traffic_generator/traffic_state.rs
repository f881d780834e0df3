//! What flights that behave are about, for pages: `obs/traffic`, JSON, once a scan, by the generator of share 1.
//!
//! ```json
//! {"time_s": 61.0,
//!  "movers": [{"callsign": "KLM123", "phase": "taxiing", "stand": "B 16", "runway": "18L",
//!              "authority_m": [[e, n], …], "planned_m": [[e, n], …], "held": [17, 18],
//!              "cleared": [{"kind": "TAX", "runway": "", "since_s": 30.0}],
//!              "waits": {"for": "BAW7", "at": "A (31-32)", "since_s": 42.0, "planned_s": 12.0}, "wants": "CRO"}],
//!  "runways": [{"name": "18L/36R", "owner": "DLH4", "queue": 2}],
//!  "greens": [{"callsign": "KLM123", "segments": [7, 8], "lines_m": [[[e, n], [e, n]], …], "bar_m": [[e, n], [e, n]]}]}
//! ```
//!
//! `authority_m`: from the mover to where it may drive now; `planned_m`: from there to the end of its way; m east and
//! north. `cleared`: what stands. `waits` and `wants` (a clearance) only while it waits; `for` is null where it waits for a clearance or the policy.
//! `targets` of a departure: `tobt_s`, `tsat_s`, `ttot_s`, where departures leave by a sequence, and `ctot_s`, its slot.
//! `greens`, where lamps lead: the segments that are lit for each flight, those of them whose lamps work as lines, and the bar at their end.

use models::frames::{Point2, Vector2};
use models::traffic::core::{Core, Direction, Greens, Phase};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The state of a core.
#[must_use]
pub fn json(core: &Core, time_s: f64) -> String {
    let net = core.network();
    let rounded = |line: Vec<[f64; 2]>| -> Value {
        thinned(&line)
            .into_iter()
            .map(|p| p.map(|x| (x * 10.0).round() / 10.0))
            .map(|p| json!(p))
            .collect()
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
        let runway = match flight.direction {
            Direction::Vehicle => "",
            _ => &net.runways[flight.runway.0].names[flight.runway.1],
        };
        let mut mover = json!({
            "callsign": flight.callsign,
            "phase": phase,
            "stand": net.stands[core.stand(f)].name,
            "runway": runway,
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
        let targets = targets(core, f);
        if targets != Value::Null {
            mover["targets"] = targets;
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
    let mut state = json!({"time_s": time_s, "movers": movers, "runways": runways});
    if core.lamps().is_some() {
        state["greens"] = greens(core);
    }
    state.to_string()
}

/// Target times of a departure that has not taken off; null where it has none.
fn targets(core: &Core, f: usize) -> Value {
    let ctot_s = core.flights()[f].ctot_s;
    let targets = core.milestones(f).filter(|_| core.measures(f).atot_s.is_none());
    match targets {
        Some(t) => json!({
            "tobt_s": t.tobt_s.round(), "tsat_s": t.tsat_s.round(), "ttot_s": t.ttot_s.round(), "ctot_s": ctot_s,
        }),
        None => ctot_s.map_or(Value::Null, |s| json!({"ctot_s": s})),
    }
}

/// Half the bar at the end of the greens of a flight, m (assumed: a taxiway of 23 m).
const HALF_BAR_M: f64 = 11.5;

/// What is lit for each flight.
fn greens(core: &Core) -> Value {
    let Some(lamps) = core.lamps() else { return Value::Null };
    let all = lamps.segments();
    let round = |p: Point2<f64>| [p.x, p.y].map(|x| (x * 10.0).round() / 10.0);
    let of = |g: &Greens| {
        let lit = g.segments.iter().map(|s| &all[*s as usize]).filter(|s| !s.dark);
        let lines: Vec<_> = lit.map(|s| s.ends_m.map(round)).collect();
        let last = g.segments.last().map(|s| all[*s as usize].ends_m);
        // Across the last of them.
        let right = last.map(|[a, b]| b - a).filter(|along| along.norm() > 0.1);
        let right = right.map_or(Vector2::zeros(), |a| Vector2::new(a.y, -a.x) / a.norm());
        let bar = [-HALF_BAR_M, HALF_BAR_M].map(|m| round(g.bar_m + right * m));
        json!({
            "callsign": core.flights()[g.flight].callsign, "segments": g.segments, "lines_m": lines, "bar_m": bar,
        })
    };
    core.greens().iter().map(of).collect()
}

/// How far a line may lie beside the one that is said for it, m: less than a pixel.
const BESIDE_M: f64 = 0.25;

/// A line with the points that its shape needs: of thousands of movers it goes out once a scan (Douglas and Peucker 1973).
fn thinned(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let Some(last) = line.len().checked_sub(1).filter(|last| *last > 1) else {
        return line.to_vec();
    };
    let mut kept = vec![false; line.len()];
    (kept[0], kept[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let ([x, y], [u, v]) = (line[from], line[to]);
        let (du, dv) = (u - x, v - y);
        let length_m2 = (du * du + dv * dv).max(1e-12);
        let beside = |p: &[f64; 2]| {
            let along = (((p[0] - x) * du + (p[1] - y) * dv) / length_m2).clamp(0.0, 1.0);
            libm::hypot(p[0] - x - along * du, p[1] - y - along * dv)
        };
        let far = (from + 1..to).map(|i| (i, beside(&line[i])));
        if let Some((farthest, m)) = far.max_by(|a, b| a.1.total_cmp(&b.1))
            && m > BESIDE_M
        {
            kept[farthest] = true;
            open.extend([(from, farthest), (farthest, to)]);
        }
    }
    line.iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_line_has_few_points_and_lies_where_the_line_was() {
        // A straight way, a quarter of a circle of 40 m, and a straight way again, a point each metre.
        let mut line: Vec<[f64; 2]> = (0..500).map(|i| [f64::from(i), 0.0]).collect();
        let arc = (0..63).map(|i| f64::from(i) / 40.0);
        line.extend(arc.map(|t| [500.0 + 40.0 * libm::sin(t), 40.0 * (1.0 - libm::cos(t))]));
        line.extend((0..500).map(|i| [540.0, 40.0 + f64::from(i)]));
        let few = thinned(&line);
        assert!(few.len() <= 12, "{} of {}", few.len(), line.len());
        assert_eq!((few.first(), few.last()), (line.first(), line.last()));
        for p in &line {
            let near = few.windows(2).map(|ends| {
                let ([x, y], [u, v]) = (ends[0], ends[1]);
                let (du, dv) = (u - x, v - y);
                let along = ((p[0] - x) * du + (p[1] - y) * dv) / (du * du + dv * dv).max(1e-12);
                let along = along.clamp(0.0, 1.0);
                libm::hypot(p[0] - x - along * du, p[1] - y - along * dv)
            });
            assert!(near.fold(f64::INFINITY, f64::min) <= BESIDE_M + 1e-9, "{p:?}");
        }
        for short in [&line[..0], &line[..1], &line[..2]] {
            assert_eq!(thinned(short), short);
        }
        assert_eq!(thinned(&[[1.0, 1.0]; 5]).len(), 2, "who stands has no way");
    }
}
