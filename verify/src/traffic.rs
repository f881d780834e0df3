//! Checks of the traffic vectors: closed forms of movers, outlines, ordered states, timed ways, and ways on
//! the networks of real airports.

use crate::{CaseResult, Check, Judge};
use geodesy::Geodetic;
use models::airport::Airport;
use models::frames::Point2;
use models::traffic::ordered::{Holding, is_ordered};
use models::traffic::outline::{Size, distance_m, outline};
use models::traffic::profile::{Leg, leg_profile, stopping};
use models::traffic::runway_roll::{Exit, Landing, TakeOff, approach_time_s, take_off_run};
use models::traffic::tractrix;
use models::traffic::ways::{Graph, TurnTime};
use models::traffic::windows::earliest_arrival_s;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    Some(match stem {
        "leg_profile" => |file| each_case(file, leg),
        "stopping" => |file| each_case(file, stop),
        "tractrix" => |file| each_case(file, slip),
        "takeoff_roll" => |file| each_case(file, take_off),
        "approach_time" => |file| each_case(file, approach),
        "landing_exit" => |file| each_case(file, landing),
        "outline" => outlines,
        "ordered_state" => |file| each_case(file, ordered),
        "timed_routes" => |file| each_case(file, timed),
        _ if stem.starts_with("routes_") => routes,
        _ => return None,
    })
}

/// Input, expectation and tolerances of one case.
struct Case<'a> {
    input: &'a Value,
    expected: &'a Value,
    tolerance: &'a Value,
}

type CaseCheck<'c> = &'c dyn Fn(&Case<'_>, &mut Judge) -> Option<()>;

fn each_case(file: &Value, check: impl Fn(&Case<'_>, &mut Judge) -> Option<()>) -> Vec<CaseResult> {
    cases(file, &check)
}

fn cases(file: &Value, check: CaseCheck<'_>) -> Vec<CaseResult> {
    let cases = file["cases"].as_array().map_or(&[][..], Vec::as_slice);
    let judged = cases.iter().enumerate().map(|(number, value)| {
        let input = &value["input"];
        let name = value["name"].as_str().or(input["type"].as_str()).unwrap_or("case");
        let mut judge = Judge::default();
        let (expected, tolerance) = (&value["expected"], &file["tolerance"]);
        let read = check(&Case { input, expected, tolerance }, &mut judge);
        judge.holds("inputs and expected values are there", read.is_some());
        judge.case(format!("{number} {name}"))
    });
    judged.collect()
}

impl Case<'_> {
    fn number(&self, key: &str) -> Option<f64> {
        self.input[key].as_f64()
    }

    /// Compares a value with the expected one of this name; null means absent. Quantities that a case does
    /// not state are passed over.
    fn is(&self, judge: &mut Judge, key: &str, found: Option<f64>) {
        let expected = &self.expected[key];
        if self.expected.get(key).is_some() {
            self.compare(judge, key, key, found, expected);
        }
    }

    fn compare(
        &self,
        judge: &mut Judge,
        key: &str,
        what: &str,
        found: Option<f64>,
        expected: &Value,
    ) {
        let of = |name: &str| {
            let rule = self.tolerance.get(key).unwrap_or(&self.tolerance["*"]);
            rule[name].as_f64().unwrap_or(0.0)
        };
        match (found, expected.as_f64()) {
            (Some(found), Some(expected)) => {
                // Where a file demands equality, the last bits of a sum may differ.
                let tolerance = (of("abs") + of("rel") * expected.abs()).max(1e-12);
                judge.number(what, found, expected, tolerance);
            }
            (found, expected) => judge.holds(what, found.is_none() && expected.is_none()),
        }
    }
}

fn leg(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let leg = Leg {
        length_m: case.number("length_m")?,
        v0_mps: case.number("v0_ms")?,
        v1_mps: case.number("v1_ms")?,
        vmax_mps: case.number("vmax_ms")?,
        acc_mps2: case.number("acc_ms2")?,
        dec_mps2: case.number("dec_ms2")?,
        jerk_mps3: case.number("jerk_ms3"),
    };
    let found = leg_profile(&leg);
    case.is(judge, "peak_ms", found.map(|p| p.peak_mps));
    case.is(judge, "time_s", found.map(|p| p.time_s));
    case.is(judge, "acc_distance_m", found.map(|p| p.acc_distance_m));
    case.is(judge, "cruise_distance_m", found.map(|p| p.cruise_distance_m));
    Some(())
}

fn stop(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (distance_m, time_s) = stopping(
        case.number("v_ms")?,
        case.number("a_ms2")?,
        case.number("dec_ms2")?,
        case.number("jerk_ms3")?,
        case.number("reaction_s")?,
    );
    case.is(judge, "distance_m", Some(distance_m));
    case.is(judge, "time_s", Some(time_s));
    Some(())
}

fn slip(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (wheelbase, radius) = (case.number("wheelbase_m")?, case.number("radius_m")?);
    let arc_m = case.number("turn_deg")?.to_radians() * radius;
    let at_end = tractrix::slip_on_arc_rad(arc_m, radius, wheelbase);
    let after = tractrix::slip_on_straight_rad(at_end, case.number("straight_after_m")?, wheelbase);
    case.is(judge, "slip_end_rad", Some(at_end));
    case.is(judge, "slip_after_rad", Some(after));
    case.is(judge, "cut_in_end_m", Some(tractrix::cut_in_m(at_end, radius, wheelbase)));
    case.is(judge, "lag_after_m", Some(tractrix::lag_m(after, wheelbase)));
    Some(())
}

fn take_off(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let run = take_off_run(&TakeOff {
        liftoff_mps: case.number("liftoff_ms")?,
        distance_m: case.number("takeoff_dist_m")?,
        density_ratio: case.number("density_ratio")?,
        headwind_mps: case.number("headwind_ms")?,
        end_ratio: case.number("end_ratio")?,
        thrust_exponent: case.number("thrust_exponent")?,
        rolling_friction: case.number("rolling_friction")?,
    });
    case.is(judge, "a_static_ms2", run.map(|r| r.a_mps2));
    case.is(judge, "b_per_m", run.map(|r| r.b_per_m));
    case.is(judge, "liftoff_ground_ms", run.map(|r| r.liftoff_ground_mps));
    case.is(judge, "distance_m", run.map(|r| r.distance_m));
    case.is(judge, "time_s", run.map(|r| r.time_s));
    Some(())
}

fn approach(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let touchdown = case.number("touchdown_ms")?;
    let time = approach_time_s(touchdown, case.number("headwind_ms")?, case.number("from_nm")?);
    let last = models::traffic::runway_roll::approach_airspeed_mps(0.0, touchdown);
    case.is(judge, "approach_ms", Some(last));
    case.is(judge, "time_s", time);
    Some(())
}

fn landing(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let landing = Landing {
        touchdown_mps: case.number("touchdown_ms")?,
        touchdown_m: case.number("touchdown_m")?,
        delay_s: case.number("delay_s")?,
        nominal_mps2: case.number("dec_nominal_ms2")?,
        greatest_mps2: case.number("dec_max_ms2")?,
    };
    let exits: Option<Vec<Exit>> = case.input["exits"]
        .as_array()?
        .iter()
        .map(|e| Some(Exit { place_m: e["place_m"].as_f64()?, speed_mps: e["speed_ms"].as_f64()? }))
        .collect();
    let exits = exits?;
    let taken = landing.exit(&exits);
    case.is(judge, "exit", Some(taken.map_or(-1.0, |e| e as f64)));
    if let Some(needed) = case.expected["needed_ms2"].as_array() {
        judge.holds("one value an exit", needed.len() == exits.len());
        for (index, (exit, expected)) in exits.iter().zip(needed).enumerate() {
            let what = format!("needed_ms2[{index}]");
            case.compare(judge, "needed_ms2", &what, landing.needed_mps2(*exit), expected);
        }
    }
    case.is(judge, "time_to_exit_s", taken.and_then(|e| landing.time_to_s(exits[e])));
    Some(())
}

fn outlines(file: &Value) -> Vec<CaseResult> {
    let types = scenarios::types::shipped();
    let size = |designator: &Value| -> Option<Size> {
        let row = types.as_ref().ok()?.get(designator.as_str()?)?;
        let class = &row.class;
        Some(Size { length_m: class.length_m, span_m: class.span_m, aircraft: class.aircraft })
    };
    cases(file, &|case, judge| {
        let (a, b) = (size(&case.input["type_a"])?, size(&case.input["type_b"])?);
        let at = Point2::new(case.number("east_m")?, case.number("north_m")?);
        let first = outline(a, Point2::origin(), case.number("heading_a_deg")?.to_radians());
        let second = outline(b, at, case.number("heading_b_deg")?.to_radians());
        let distance = distance_m(&first, &second);
        case.is(judge, "distance_m", Some(distance));
        judge.holds("overlap", case.expected["overlap"].as_bool()? == (distance == 0.0));
        Some(())
    })
}

fn indices(value: &Value) -> Option<Vec<usize>> {
    value.as_array()?.iter().map(|v| v.as_u64().map(|n| n as usize)).collect()
}

fn ordered(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let pieces = case.input["pieces"].as_u64().filter(|n| *n < 100_000)? as usize;
    let mut conflicts = vec![Vec::new(); pieces];
    for pair in case.input["conflicts"].as_array()? {
        let pair = indices(pair)?;
        let (a, b) = (*pair.first()?, *pair.get(1)?);
        conflicts.get_mut(a)?.push(b);
        conflicts.get_mut(b)?.push(a);
    }
    let movers: Option<Vec<Holding>> = case.input["movers"]
        .as_array()?
        .iter()
        .map(|m| {
            let sound = |list: Vec<usize>| list.iter().all(|z| *z < pieces).then_some(list);
            Some(Holding {
                held: sound(indices(&m["held"])?)?,
                remaining: sound(indices(&m["remaining"])?)?,
                keeps_last: m["keeps_last"].as_bool()?,
            })
        })
        .collect();
    let found = is_ordered(&conflicts, &movers?, 1_000_000);
    judge.holds("ordered", found == case.expected["ordered"].as_bool()?);
    Some(())
}

fn timed(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let zones = case.input["zones"].as_u64().filter(|n| *n < 100_000)? as usize;
    let mut next = vec![Vec::new(); zones];
    for edge in case.input["edges"].as_array()? {
        let edge = indices(edge)?;
        let to = *edge.get(1).filter(|z| **z < zones)?;
        next.get_mut(*edge.first()?)?.push(to);
    }
    let list =
        |v: &Value| -> Option<Vec<f64>> { v.as_array()?.iter().map(Value::as_f64).collect() };
    let passage = list(&case.input["passage_s"]).filter(|p| p.len() == zones)?;
    let busy: Option<Vec<Vec<(f64, f64)>>> = case.input["busy"]
        .as_array()?
        .iter()
        .map(|zone| {
            let pairs = zone.as_array()?.iter().map(list);
            pairs.map(|p| p.and_then(|p| Some((*p.first()?, *p.get(1)?)))).collect()
        })
        .collect();
    let busy = busy.filter(|b| b.len() == zones)?;
    let ends = [case.input["from"].as_u64()? as usize, case.input["to"].as_u64()? as usize];
    if ends.iter().any(|z| *z >= zones) {
        return None;
    }
    let arrival = |busy: &[Vec<(f64, f64)>]| {
        earliest_arrival_s(&passage, &next, busy, ends[0], ends[1], 600.0)
    };
    case.is(judge, "arrival_s", arrival(&busy));
    case.is(judge, "unhindered_s", arrival(&vec![Vec::new(); zones]));
    Some(())
}

/// Ways on the network that the file names: `routes_ICAO.json`, layouts beside it (see [`layout_folders`]).
fn routes(file: &Value) -> Vec<CaseResult> {
    let network = network_of(file);
    cases(file, &|case, judge| {
        let airport = match &network {
            Ok(airport) => airport,
            Err(reason) => {
                judge.ratio(f64::INFINITY, || reason.clone());
                return Some(());
            }
        };
        let graph = Graph::of(airport);
        let node = |key: &str| airport.node(&format!("#{}", case.input[key].as_str()?));
        // A node without any edge is not part of the network: no way leads there.
        let ends = node("from").zip(node("to"));
        let length = ends.and_then(|(from, to)| graph.cheapest(from, to, Graph::length));
        case.is(judge, "length_m", length.map(|w| w.cost));
        let cost = ends.and_then(|(from, to)| graph.cheapest(from, to, Graph::runway_cost));
        case.is(judge, "cost_m", cost.map(|w| w.cost));
        let rule = TurnTime::default();
        let quickest = ends.and_then(|(from, to)| graph.quickest(from, to, &rule));
        case.is(judge, "turn_time_s", quickest.map(|w| w.cost));
        let Some((from, to)) = ends else { return Some(()) };
        if let Some(expected) = case.expected["three_shortest_m"].as_array() {
            let ways = graph.shortest_ways(from, to, expected.len().max(3));
            judge.holds("as many ways", ways.len() == expected.len());
            for (index, (way, expected)) in ways.iter().zip(expected).enumerate() {
                let what = format!("three_shortest_m[{index}]");
                case.compare(judge, "three_shortest_m", &what, Some(way.cost), expected);
            }
        }
        Some(())
    })
}

/// The layout of a file of ways: the airport and the folder come from the path that [`crate::run`] adds.
fn network_of(file: &Value) -> Result<Airport, String> {
    let path = file["path"].as_str().map(PathBuf::from).ok_or("no path of the vector file")?;
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let icao = stem.strip_prefix("routes_").unwrap_or(&stem);
    let ending = match file["layout"].as_str() {
        Some("groundnet") => "groundnet.xml",
        Some("nodes.csv") => "nodes.csv",
        Some("apt.dat") => "apt.dat",
        other => return Err(format!("layout {other:?}: known are groundnet, nodes.csv, apt.dat")),
    };
    let degrees = |key: &str| file["reference"][key].as_f64().ok_or(format!("no reference.{key}"));
    let reference = Geodetic::from_degrees(degrees("lat_deg")?, degrees("lon_deg")?, 0.0);
    let name = format!("{icao}.{ending}");
    let folders = layout_folders(&path);
    let layout = folders.iter().map(|f| f.join(&name)).find(|p| p.is_file());
    let layout = layout.ok_or_else(|| {
        format!("{name} is not beside the vectors, nor in a folder airports above them")
    })?;
    let read = scenarios::airport::check_files(&[layout], Some(reference));
    read.map(|(airport, _)| airport).map_err(|e| e.to_string())
}

/// Beside the vector file, in folders `airports` and `synthetic` of it and of those above it, and in the
/// airports that come with SEEDS.
fn layout_folders(path: &Path) -> Vec<PathBuf> {
    let mut folders = Vec::new();
    for folder in path.ancestors().skip(1).take(6) {
        folders.push(folder.to_path_buf());
        folders.push(folder.join("airports"));
        folders.push(folder.join("synthetic"));
    }
    folders.push(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/airports"));
    folders
}

#[cfg(test)]
mod tests {
    use crate::assert_all_pass;

    #[test]
    fn closed_forms_are_those_of_the_vectors() {
        assert_all_pass(&[
            ("traffic/leg_profile", 40),
            ("traffic/stopping", 20),
            ("traffic/tractrix", 20),
            ("traffic/takeoff_roll", 20),
            ("traffic/approach_time", 12),
            ("traffic/landing_exit", 20),
            ("traffic/outline", 40),
        ]);
    }

    #[test]
    fn states_and_timed_ways_are_those_of_the_vectors() {
        assert_all_pass(&[("traffic/ordered_state", 30), ("traffic/timed_routes", 20)]);
    }

    #[test]
    fn ways_on_real_networks_are_those_of_the_vectors() {
        assert_all_pass(&[
            ("traffic/routes_EGCC", 30),
            ("traffic/routes_EHAM", 30),
            ("traffic/routes_LIMC", 30),
            ("traffic/routes_LSZH", 31),
            ("traffic/routes_LZIB", 30),
        ]);
    }
}
