//! Checks of the vectors about sets of targets: association, the kinematic gate, set distances.

use crate::{CaseResult, Check, Judge};
use models::association::assignment::Solver;
use models::association::certificate::{Bracket, Certificate};
use models::association::existence::Existence;
use models::association::jpda::Jpda;
use models::association::kinematic_gate::{ClassLimits, Departure, ReachableSet, reach};
use models::association::lbp::{Belief, Edge};
use models::association::one_to_one::OneToOne;
use models::association::sparse::Sparse;
use models::frames::{Matrix2, Matrix4, Point2, Vector2};
use models::score;

use serde_json::Value;

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    Some(match stem {
        "jpda_marginals" => |file| each(file, jpda_marginals),
        "assignment" => |file| each(file, assignment),
        "bounded_marginals" => |file| each(file, bounded_marginals),
        "sparse_assignment" => |file| each(file, sparse_assignment),
        "identity" => |file| each(file, identity),
        "existence" => |file| each(file, existence),
        "gospa_ospa" => |file| each(file, gospa_ospa),
        "kinematic_gate" => |file| each(file, kinematic_gate),
        _ => return None,
    })
}

/// Runs `judge` on every case; what it cannot read (`None`) fails.
fn each(file: &Value, judge: fn(&Value, &Value, f64, &mut Judge) -> Option<()>) -> Vec<CaseResult> {
    let cases = file.get("cases").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    cases
        .iter()
        .enumerate()
        .map(|(index, case)| {
            let name = case.get("name").and_then(Value::as_str);
            let mut judgement = Judge::default();
            let read = || {
                let tolerance = number(case.get("tol")?)?;
                judge(case.get("input")?, case.get("expected")?, tolerance, &mut judgement)
            };
            let complete = { read }().is_some();
            judgement.holds("input and expectation are complete", complete);
            judgement.case(name.map_or_else(|| index.to_string(), str::to_owned))
        })
        .collect()
}

fn number(value: &Value) -> Option<f64> {
    value.as_f64()
}

fn row(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(number).collect()
}

/// Rows of equal length.
fn matrix(value: &Value) -> Option<Vec<Vec<f64>>> {
    let rows: Vec<Vec<f64>> = value.as_array()?.iter().map(row).collect::<Option<_>>()?;
    rows.windows(2).all(|w| w[0].len() == w[1].len()).then_some(rows)
}

fn pair(value: &Value) -> Option<Vector2<f64>> {
    match row(value)?[..] {
        [x, y] => Some(Vector2::new(x, y)),
        _ => None,
    }
}

fn points(value: &Value) -> Option<Vec<Point2<f64>>> {
    value.as_array()?.iter().map(|place| pair(place).map(Point2::from)).collect()
}

/// Largest cluster that a vector file may ask for, `tracks · 2^plots`.
const LARGEST_CLUSTER: usize = 1 << 24;

fn jpda_marginals(input: &Value, expected: &Value, tol: f64, judge: &mut Judge) -> Option<()> {
    let log_miss = row(input.get("log_miss")?)?;
    let log_like = matrix(input.get("log_like")?)?;
    let expected = matrix(expected.get("marginals")?)?;
    let width = expected.first().map_or(0, Vec::len);
    if log_like.len() != log_miss.len()
        || expected.len() != log_miss.len()
        || log_like.iter().any(|r| r.len() + 1 != width)
    {
        return None;
    }
    let mut beta = Vec::new();
    let done = Jpda::default().marginals(&log_miss, &log_like.concat(), LARGEST_CLUSTER, &mut beta);
    judge.holds("the cluster has exact marginals", done.is_ok());
    if done.is_ok() {
        for (k, (found, wanted)) in beta.iter().zip(expected.concat()).enumerate() {
            judge.number(&format!("marginal {}, {}", k / width, k % width), *found, wanted, tol);
        }
    }
    Some(())
}

/// Pairs of a matrix of gains; −∞ is no pair.
fn edges(gains: &[Vec<f64>]) -> Vec<Edge> {
    let row = |(row, gains): (usize, &Vec<f64>)| {
        let edge = |(column, &gain): (usize, &f64)| {
            let (row, column) = (row as u32, column as u32);
            (gain > f64::NEG_INFINITY).then_some(Edge { row, column, gain })
        };
        gains.iter().enumerate().filter_map(edge).collect::<Vec<_>>()
    };
    gains.iter().enumerate().flat_map(row).collect()
}

/// Marginals by belief propagation, column 0 a miss.
fn believed(gains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let columns = gains.first().map_or(0, Vec::len);
    let (edges, mut belief) = (edges(gains), Belief::default());
    belief.run(gains.len(), columns, &edges, 20_000, 1e-14);
    let row = |row: usize| {
        let mut beta = vec![0.0; columns + 1];
        beta[0] = belief.miss(row);
        belief
            .edges_of(row)
            .for_each(|e| beta[edges[e].column as usize + 1] = belief.share(row, e));
        beta
    };
    (0..gains.len()).map(row).collect()
}

/// Marginals as labels are weighed, column 0 a miss.
fn paired(gains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let columns = gains.first().map_or(0, Vec::len);
    let (edges, mut pairing) = (edges(gains), OneToOne::default());
    pairing.run(gains.len(), columns, &edges, 200, 1e-6);
    let row = |row: usize| {
        let mut beta = vec![0.0; columns + 1];
        beta[0] = pairing.miss(row);
        pairing.edges_of(row).for_each(|e| beta[edges[e].column as usize + 1] = pairing.share(e));
        beta
    };
    (0..gains.len()).map(row).collect()
}

/// Exact marginals of the same.
fn exact(gains: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let mut beta = Vec::new();
    let miss = vec![0.0; gains.len()];
    Jpda::default().marginals(&miss, &gains.concat(), LARGEST_CLUSTER, &mut beta).ok()?;
    let width = gains.first().map_or(0, Vec::len) + 1;
    Some(beta.chunks(width).map(<[f64]>::to_vec).collect())
}

fn compare(what: &str, found: &[Vec<f64>], wanted: &[Vec<f64>], tol: f64, judge: &mut Judge) {
    judge.holds("as many rows", found.len() == wanted.len());
    for (row, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        for (column, (found, wanted)) in found.iter().zip(wanted).enumerate() {
            judge.number(&format!("{what} {row}, {column}"), *found, *wanted, tol);
        }
    }
}

fn bounded_marginals(input: &Value, expected: &Value, tol: f64, judge: &mut Judge) -> Option<()> {
    let psi = matrix(input.get("psi")?)?;
    let gains: Vec<Vec<f64>> =
        psi.iter().map(|row| row.iter().map(|psi| libm::log(*psi)).collect()).collect();
    compare("exact", &exact(&gains)?, &matrix(expected.get("exact")?)?, tol, judge);
    let belief = believed(&gains);
    compare("belief", &belief, &matrix(expected.get("belief")?)?, 1e-9, judge);
    let off = |(found, wanted): (&Vec<f64>, &Vec<f64>)| {
        found.iter().zip(wanted).map(|(f, w)| (f - w).abs()).fold(0.0, f64::max)
    };
    let largest = belief.iter().zip(&exact(&gains)?).map(off).fold(0.0, f64::max);
    let wanted = number(expected.get("largest_belief_error")?)?;
    judge.number("largest error of belief", largest, wanted, 1e-9);
    let brackets = expected.get("bracket")?.as_object()?;
    judge.holds("brackets", !brackets.is_empty());
    for (depth, wanted) in brackets {
        let found = bounds(&gains, depth.parse().ok()?);
        let wanted: Vec<_> = wanted.as_array()?.iter().map(matrix).collect::<Option<_>>()?;
        judge.holds("a row of brackets each", wanted.len() == found.len());
        for (row, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
            judge.holds("a bracket each", found.len() == wanted.len());
            for (column, (found, wanted)) in found.iter().zip(wanted).enumerate() {
                let [low, high] = wanted[..] else { return None };
                let what = |end: &str| format!("{end} bound at depth {depth} of {row}, {column}");
                judge.number(&what("lower"), found.low, low, tol);
                judge.number(&what("upper"), found.high, high, tol);
            }
        }
    }
    Some(())
}

/// Bounds of all marginals, column 0 a miss, from trees cut at `depth`.
fn bounds(gains: &[Vec<f64>], depth: usize) -> Vec<Vec<Bracket>> {
    let columns = gains.first().map_or(0, Vec::len);
    let (edges, mut certificate) = (edges(gains), Certificate::default());
    certificate.lay_out(gains.len(), columns, &edges);
    let mut row = |row: usize| {
        let mut all = vec![Bracket { low: 0.0, high: 0.0 }; columns + 1];
        let mut own = edges.iter().filter(|e| e.row as usize == row);
        all[0] = certificate.bounds(row, depth, usize::MAX, |bracket| {
            if let Some(edge) = own.next() {
                all[edge.column as usize + 1] = bracket;
            }
        });
        all
    };
    (0..gains.len()).map(&mut row).collect()
}

/// Rows or columns of a sparse matrix, at most.
const MOST_ROWS: u64 = 1_000_000;

fn sparse_assignment(input: &Value, expected: &Value, tol: f64, judge: &mut Judge) -> Option<()> {
    let size = |key: &str| input.get(key)?.as_u64().filter(|n| *n <= MOST_ROWS);
    let (tracks, plots) = (size("tracks")?, size("plots")?);
    let miss = number(input.get("miss_cost")?)?;
    let listed = matrix(input.get("edges")?)?;
    let place =
        |x: f64, size: u64| Some(x as u32).filter(|n| f64::from(*n) == x && u64::from(*n) < size);
    let edge = |e: &Vec<f64>| {
        let [row, column, cost] = e[..] else { return None };
        Some(Edge { row: place(row, tracks)?, column: place(column, plots)?, gain: miss - cost })
    };
    let mut edges: Vec<Edge> = listed.iter().map(edge).collect::<Option<_>>()?;
    let (tracks, plots) = (tracks as usize, plots as usize);
    edges.sort_by_key(|e| (e.row, e.column));
    let (mut sparse, mut budget) = (Sparse::default(), u64::MAX);
    let found: Vec<_> = sparse.pairs(tracks, plots, &edges, &mut budget).collect();
    let cost = |(row, column): (usize, &Option<u32>)| {
        let of = |e: &&Edge| e.row as usize == row && Some(e.column) == *column;
        edges.iter().find(of).map_or(miss, |e| miss - e.gain)
    };
    let total: f64 = found.iter().enumerate().map(cost).sum();
    let wanted = number(expected.get("total")?)?;
    judge.number("total", total, wanted, tol * wanted.abs().max(1.0));
    let pairs = found.iter().flatten().count() as f64;
    judge.number("pairs", pairs, number(expected.get("pairs")?)?, 0.0);
    Some(())
}

fn identity(input: &Value, expected: &Value, tol: f64, judge: &mut Judge) -> Option<()> {
    const BELIEF: f64 = 0.03;
    let gains = matrix(input.get("log_odds")?)?;
    let threshold = number(input.get("threshold")?)?;
    let wanted = matrix(expected.get("probability")?)?;
    compare("exact", &exact(&gains)?, &wanted, tol, judge);
    let found = paired(&gains);
    compare("as labels have it", &found, &wanted, BELIEF, judge);
    let published = expected.get("published")?.as_array()?;
    for (row, (beta, wanted)) in found.iter().zip(published).enumerate() {
        let best = (1..beta.len()).find(|&c| beta[c] >= threshold).map(|c| c as u64 - 1);
        judge.holds(&format!("what row {row} is called"), best == wanted.as_u64());
    }
    Some(())
}

fn existence(input: &Value, expected: &Value, tol: f64, judge: &mut Judge) -> Option<()> {
    // One number for all, or one for each.
    let each_of = |key: &str, n: usize| -> Option<Vec<f64>> {
        let value = input.get(key)?;
        number(value).map(|v| vec![v; n]).or_else(|| row(value)).filter(|list| list.len() == n)
    };
    let tracks: Vec<Existence> =
        row(input.get("existence")?)?.into_iter().map(Existence::of).collect();
    let density = matrix(input.get("log_density")?)?;
    let plots = density.first().map_or(0, Vec::len);
    if density.len() != tracks.len() {
        return None;
    }
    let detection = each_of("detection", tracks.len())?;
    let clutter = each_of("clutter_density", plots)?;
    let both = || tracks.iter().zip(&detection);
    let log_miss: Vec<f64> = both().map(|(r, d)| r.log_miss(*d)).collect();
    let log_like: Vec<f64> = both()
        .zip(&density)
        .flat_map(|((r, d), row)| {
            row.iter().zip(&clutter).map(|(g, c)| r.log_pair(*d, *g, *c)).collect::<Vec<_>>()
        })
        .collect();
    let mut beta = Vec::new();
    let done = Jpda::default().marginals(&log_miss, &log_like, LARGEST_CLUSTER, &mut beta);
    judge.holds("the cluster has exact marginals", done.is_ok());
    done.ok()?;
    let found: Vec<Vec<f64>> = beta.chunks(plots + 1).map(<[f64]>::to_vec).collect();
    compare("beta", &found, &matrix(expected.get("beta")?)?, tol, judge);
    let after = row(expected.get("existence_after")?)?;
    judge.holds("as many tracks", after.len() == tracks.len());
    for ((track, detection), (row, wanted)) in both().zip(found.iter().zip(&after)) {
        judge.number("after", track.after(row[0], *detection).there(), *wanted, tol);
    }
    let unclaimed = row(expected.get("unclaimed")?)?;
    judge.holds("as many plots", unclaimed.len() == plots);
    for (plot, wanted) in unclaimed.iter().enumerate() {
        let claimed: f64 = found.iter().map(|row| row[plot + 1]).sum();
        judge.number("unclaimed", 1.0 - claimed, *wanted, tol);
    }
    Some(())
}

/// Costs from here on stand for forbidden cells.
const FORBIDDEN_COST: f64 = 1e300;

fn assignment(input: &Value, expected: &Value, tol: f64, judge: &mut Judge) -> Option<()> {
    let cost = matrix(input.get("cost")?)?;
    let columns = cost.first().map_or(0, Vec::len);
    let found = Solver::default().solve(cost.len(), columns, |r, c| {
        Some(cost[r][c]).filter(|&value| value < FORBIDDEN_COST)
    });
    let mut taken: Vec<usize> = found.column_of_row.iter().flatten().copied().collect();
    let pairs = taken.len();
    taken.sort_unstable();
    taken.dedup();
    judge.holds("each column once", taken.len() == pairs && taken.iter().all(|&c| c < columns));
    let total: f64 = found
        .column_of_row
        .iter()
        .enumerate()
        .filter_map(|(r, c)| c.map(|c| cost[r][c]))
        .filter(|&value| value < FORBIDDEN_COST)
        .sum();
    let wanted = expected.get("total").or_else(|| expected.get("finite_total"))?;
    let wanted = number(wanted)?;
    judge.number("total", found.total, wanted, tol * wanted.abs().max(f64::MIN_POSITIVE));
    judge.number("sum of the pairs", total, wanted, tol * wanted.abs().max(f64::MIN_POSITIVE));
    if let Some(wanted) = expected.get("pairs") {
        judge.number("pairs", pairs as f64, number(wanted)?, 0.0);
    } else {
        judge.number("pairs", pairs as f64, cost.len().min(columns) as f64, 0.0);
    }
    if let Some(wanted) = expected.get("forbidden_used_at_least") {
        judge.number("forbidden cells", found.forbidden_used as f64, number(wanted)?, 0.0);
    }
    Some(())
}

fn gospa_ospa(input: &Value, expected: &Value, tol: f64, judge: &mut Judge) -> Option<()> {
    let truth = points(input.get("truth")?)?;
    let tracks = points(input.get("tracks")?)?;
    let cut_off = number(input.get("c")?)?;
    let p = number(input.get("p")?)?;
    if let Some(alpha) = input.get("alpha") {
        judge.holds("alpha is 2", number(alpha)? == 2.0);
    }
    let mut relative = |name: &str, found: f64| {
        let wanted = number(expected.get(name)?)?;
        judge.number(name, found, wanted, tol * wanted.abs());
        Some(())
    };
    relative("ospa", score::ospa(&truth, &tracks, cut_off, p))?;
    relative("gospa", score::gospa(&truth, &tracks, cut_off, p).total)
}

/// Tolerance of a hull's vertices, m.
const HULL_TOLERANCE_M: f64 = 1e-9;

fn kinematic_gate(input: &Value, expected: &Value, tol: f64, judge: &mut Judge) -> Option<()> {
    let params = input.get("params")?;
    let param = |name: &str| number(params.get(name)?);
    let limits = ClassLimits {
        acceleration_ms2: param("a_acc")?,
        braking_ms2: param("a_brk")?,
        lateral_ms2: param("a_lat")?,
        turn_rate_rads: param("w_max")?,
        turn_radius_m: param("R_min")?,
        speed_mps: param("v_max")?,
    };
    let p4 = matrix(input.get("P4")?)?;
    let r = matrix(input.get("R")?)?;
    if p4.len() != 4 || p4[0].len() != 4 || r.len() != 2 || r[0].len() != 2 {
        return None;
    }
    let target = Departure {
        position_m: pair(input.get("p")?)?.into(),
        velocity_mps: pair(input.get("v")?)?,
        covariance: Matrix4::from_fn(|i, j| p4[i][j]),
    };
    let dt_s = number(input.get("dt")?)?;
    let limit = number(input.get("g2")?)?;
    let r = Matrix2::from_fn(|i, j| r[i][j]);
    let Some(found) = reach(&limits, &target, dt_s, pair(input.get("z")?)?.into(), r) else {
        judge.holds("the gate answers", false);
        return Some(());
    };
    let wanted = number(expected.get("m")?)?;
    judge.number("m", found.m, wanted, tol * wanted.abs());
    let accept = expected.get("accept")?.as_bool()?;
    judge.holds("decision", (found.m <= limit) == accept);
    if let Some(hull) = expected.get("hull_along_left").filter(|h| !h.is_null()) {
        let hull: Vec<_> = hull.as_array()?.iter().map(pair).collect::<Option<_>>()?;
        let set = ReachableSet::new(&limits, target.velocity_mps.norm(), dt_s);
        // As sets of points: the three accelerations of one turn rate end on one line, so whether
        // the middle one is a vertex is a matter of rounding.
        let (vertices, wanted) = (set.vertices(), as_set(&hull)?);
        judge.holds("a hull where one is expected", !vertices.is_empty());
        let outside = |set: &ReachableSet, points: &[Vector2<f64>]| {
            points.iter().map(|&p| set.from_nearest(p).norm()).fold(0.0, f64::max)
        };
        let worst = outside(&set, &hull).max(outside(&wanted, vertices));
        judge.ratio(worst / HULL_TOLERANCE_M, || format!("hull: sets {worst:e} m apart"));
    }
    Some(())
}

/// A convex polygon given by its vertices, counter-clockwise.
fn as_set(hull: &[Vector2<f64>]) -> Option<ReachableSet> {
    let mut vertices = [Vector2::zeros(); 9];
    vertices.get_mut(..hull.len())?.copy_from_slice(hull);
    (!hull.is_empty()).then_some(ReachableSet::Hull { vertices, count: hull.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_of_the_set_vectors_passes() {
        crate::assert_all_pass(&[
            ("tracking/jpda_marginals", 6),
            ("tracking/assignment", 8),
            ("tracking/gospa_ospa", 6),
            ("tracking/kinematic_gate", 24),
            ("tracking2/existence", 10),
            ("tracking2/bounded_marginals", 9),
        ]);
    }

    #[test]
    fn malformed_cases_fail_and_do_not_panic() {
        let broken = [
            "{}",
            r#"{"name": 1, "input": {}, "expected": {}, "tol": 1e-9}"#,
            r#"{"input": {"log_miss": [-1], "log_like": [[1, 2], [3]], "cost": [[1], [2, 3]],
                "truth": [[1]], "tracks": [], "c": 1, "p": 2, "params": 3},
                "expected": {"marginals": [[1]], "total": "x", "pairs": null}, "tol": 1e-9}"#,
        ];
        for stem in ["jpda_marginals", "assignment", "gospa_ospa", "kinematic_gate"] {
            let check = check_for(stem).expect(stem);
            assert!(check(&Value::Null).is_empty());
            for text in broken {
                let file = serde_json::json!({
                    "cases": [serde_json::from_str::<Value>(text).expect("JSON")]
                });
                assert!(check(&file)[0].worst.is_infinite(), "{stem}: {text}");
            }
        }
    }

    #[test]
    fn an_edge_outside_the_matrix_fails_and_does_not_panic() {
        let check = check_for("sparse_assignment").expect("covered");
        let of = |input: &str| {
            let case = format!(
                r#"{{"input": {input}, "expected": {{"total": 2, "pairs": 1}}, "tol": 1e-9}}"#
            );
            let case: Value = serde_json::from_str(&case).expect("JSON");
            check(&serde_json::json!({"cases": [case]}))[0].worst
        };
        let edges = |edges: &str| {
            of(&format!(r#"{{"tracks": 1, "plots": 1, "miss_cost": 9, "edges": {edges}}}"#))
        };
        assert!(edges("[[0, 0, 2]]") <= 1.0);
        for beyond in ["[[1, 0, 2]]", "[[0, 1, 2]]", "[[-1, 0, 2]]", "[[0.5, 0, 2]]", "[[0, 0]]"] {
            assert!(edges(beyond).is_infinite(), "{beyond}");
        }
        let endless =
            r#"{"tracks": 1e18, "plots": 1000000000000000000, "miss_cost": 9, "edges": []}"#;
        assert!(of(endless).is_infinite());
        assert!(of(&endless.replace("1e18", "1000000000000000000")).is_infinite());
    }
}
