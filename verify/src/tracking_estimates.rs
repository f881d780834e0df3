//! Checks of the tracking vectors that concern errors of echoes and sites, motion as events, and the choice of a rung.

use crate::tracking::{Case, each_case, numbers, rows};
use crate::{Check, Judge};
use models::filter::choice::Choice;
use models::filter::events::change_moments;
use models::filter::fixed_lag::FixedLag;
use models::filter::motion::Motion;
use models::filter::{Gaussian, Measurement, Sym2};
use models::frames::{Point2, Vector2};
use models::fusion::extent::Moments;
use models::fusion::near_side::{Body, EchoLaw, Kappa, derivatives, half_extents_m};
use models::fusion::registration::{Joint, Pair};

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    Some(match stem {
        "near_side" => |file| each_case(file, near_side),
        "registration" => |file| each_case(file, registration),
        "event_moments" => |file| each_case(file, event_moments),
        "model_choice" => |file| each_case(file, model_choice),
        "fixed_lag" => |file| each_case(file, fixed_lag),
        "extent" => |file| each_case(file, extent),
        _ => return None,
    })
}

/// Direction of an angle clockwise from north.
fn direction(rad: f64) -> Vector2<f64> {
    let (sin, cos) = libm::sincos(rad);
    Vector2::new(sin, cos)
}

fn near_side(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let input = |key: &str| case.input[key].as_f64();
    let body = Body {
        vehicle: case.input["kind"].as_str()? == "vehicle",
        length_m: input("length")?,
        span_m: input("span")?,
    };
    let kappa = Kappa { length: input("kappa_length")?, span: input("kappa_span")? };
    let law = EchoLaw { aircraft: kappa, vehicle: kappa, residual_m: 0.0, ..EchoLaw::default() };
    let expected = |key: &str| case.expected[key].as_f64();
    let axis = direction(case.input["azimuth"].as_f64().unwrap_or(0.0));
    let Some(heading) = case.input["heading"].as_f64() else {
        let (offset, sigma) = law.offset_m(Some(&body), None, axis);
        let scale = expected("offset")?.abs();
        judge.number("offset", offset, expected("offset")?, case.tol * scale);
        judge.number("sigma", sigma, expected("sigma")?, case.tol * scale);
        return Some(());
    };
    let course = direction(heading);
    let seen = half_extents_m(&body, axis, course);
    let (offset, _) = law.offset_m(Some(&body), Some(course), axis);
    let scale = 0.5 * body.length_m.max(body.span_m);
    judge.number("half_length_seen", seen.0, expected("half_length_seen")?, case.tol * scale);
    judge.number("half_span_seen", seen.1, expected("half_span_seen")?, case.tol * scale);
    judge.number("offset", offset, expected("offset")?, case.tol * scale);
    let shift = numbers(&case.expected["shift"])?;
    judge.number("shift east", -offset * axis.x, *shift.first()?, case.tol * scale);
    judge.number("shift north", -offset * axis.y, *shift.get(1)?, case.tol * scale);
    let velocity = numbers(&case.input["velocity"])?;
    let velocity = Vector2::new(*velocity.first()?, *velocity.get(1)?);
    let found = derivatives(axis, input("range")?, velocity, seen);
    let expected = rows(&case.expected["J"])?;
    let largest = expected.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
    for (k, column) in found.iter().enumerate() {
        let [east, north] = [column.x, column.y];
        judge.number("J east", east, *expected.first()?.get(k)?, case.tol * largest);
        judge.number("J north", north, *expected.get(1)?.get(k)?, case.tol * largest);
    }
    Some(())
}

fn registration(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let sigma = case.list("prior_sigma")?;
    let mut joint = Joint::new(&case.list("prior_mean")?, &sigma);
    for pair in case.input["pairs"].as_array()? {
        let number = |key: &str| pair[key].as_f64();
        let vector = |key: &str| {
            let list = numbers(&pair[key])?;
            Some(Vector2::new(*list.first()?, *list.get(1)?))
        };
        joint.learn(
            0,
            &Pair {
                axis: direction(number("azimuth")?),
                ground_m: number("range")?,
                velocity_mps: vector("velocity")?,
                vehicle: !pair["aircraft"].as_bool()?,
                half_extent_m: number("half_extent")?,
                variance_m2: [number("variance_along")?, number("variance_across")?],
                delta_m: vector("delta")?,
            },
        );
    }
    joint.solve();
    let (estimates, sigmas) =
        (numbers(&case.expected["estimate"])?, numbers(&case.expected["sigma"])?);
    let gains = numbers(&case.expected["information_gain"])?;
    for k in 0..5 {
        let (found, own) = joint.parameter(k);
        judge.number("estimate", found, *estimates.get(k)?, case.tol * *sigmas.get(k)?);
        judge.number("sigma", own, *sigmas.get(k)?, case.tol * *sigmas.get(k)?);
        let gain = 1.0 - own * own / (sigma[k] * sigma[k]);
        judge.number("information gain", gain, *gains.get(k)?, case.tol);
    }
    let correlation = case.expected["corr_range_vehicle"].as_f64()?;
    judge.number("correlation", joint.correlation(0, 4), correlation, case.tol);
    Some(())
}

fn event_moments(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (t, sigma, before) = (case.number("T")?, case.number("sigma_a")?, case.number("a0")?);
    let moments = change_moments(t, before);
    let mean = numbers(&case.expected["mean_added"])?;
    let scale = [t * t, t, 1.0].map(|s| s * before.abs().max(sigma));
    for k in 0..3 {
        judge.number("mean", moments.mean[k], *mean.get(k)?, (case.tol * scale[k]).max(1e-300));
    }
    for (what, sigma) in [("Q_start", sigma), ("Q_stop", 0.0)] {
        let expected = rows(&case.expected[what])?;
        let q = moments.noise(sigma);
        for (place, (i, j)) in
            [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate()
        {
            let tolerance = (case.tol * scale[i] * scale[j]).max(1e-300);
            judge.number(what, q[place], *expected.get(i)?.get(j)?, tolerance);
        }
    }
    Some(())
}

fn model_choice(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let plots = rows(&case.input["log_likelihood"])?;
    let expected = rows(&case.expected["weights"])?;
    let chosen = case.expected["chosen"].as_array()?;
    let rungs = plots.first()?.len();
    let mut choice = Choice::new(rungs);
    let floor = case.number("floor")?;
    let (mut switches, mut last) = (0, 0);
    for ((logs, weights), rung) in plots.iter().zip(&expected).zip(chosen) {
        let floored: Vec<f64> = logs.iter().map(|l| l.max(floor)).collect();
        choice.add(case.number("forgetting")?, &floored);
        for (found, expected) in choice.weights().iter().zip(weights) {
            judge.number("weight", *found, *expected, case.tol);
        }
        let now = choice.choose(last, case.number("switch_up")?);
        judge.holds("chosen", Some(now as u64) == rung.as_u64());
        switches += u64::from(now != last);
        last = now;
    }
    judge.holds("switches", case.expected["switches"].as_u64() == Some(switches));
    Some(())
}

/// A plot of the position of an axis, the same on both.
fn on_both_axes(z: f64, r: f64) -> Measurement {
    Measurement::Position { z: Point2::new(z, z), r: Sym2 { xx: r, xy: 0.0, yy: r } }
}

/// Places of the numbers of the east axis and of north's position in the state.
const COPIED: [usize; 4] = [0, 1, 2, 3];

fn fixed_lag(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (t, z, r) = (case.list("t")?, case.list("z")?, case.list("R")?);
    let (start, vars) = (case.list("start")?, case.list("start_var")?);
    if z.len() != t.len() || r.len() != t.len() || start.len() != 3 || vars.len() != 3 {
        return None;
    }
    let motion = Motion::ConstantAcceleration { q: case.number("q")? };
    // The first plot is the start.
    let mut state = Gaussian::at_position(
        Point2::new(start[0], start[0]),
        Sym2 { xx: vars[0], xy: 0.0, yy: vars[0] },
        vars[1].sqrt(),
        vars[2].sqrt(),
    );
    (1..3).for_each(|k| state.x[k] = models::filter::lanes::Lane::splat(start[k]));
    let (mut now_s, mut next) = (*t.first()?, 1);
    let mut lag: Option<FixedLag<4>> = None;
    let mut expected = case.expected["published"].as_array()?.iter();
    for until_s in case.list("publish")? {
        if until_s < t[0] {
            continue;
        }
        while next < t.len() && t[next] <= until_s {
            state = state.predicted(&motion.step(t[next] - now_s));
            let m = on_both_axes(z[next], r[next]);
            let Measurement::Position { z: point, r: noise } = m else { return None };
            if let Some(lag) = &mut lag {
                lag.predict(t[next] - now_s, true);
                let inverse = (state.position_cov() + noise).matrix().try_inverse()?;
                let nu = point - state.position();
                lag.take(&state, inverse, 1.0, nu, models::frames::Matrix2::zeros());
            }
            state.update(&m).ok()?;
            (now_s, next) = (t[next], next + 1);
        }
        let at = state.predicted(&motion.step(until_s - now_s));
        let wanted = expected.next()?;
        judge.number("time", until_s, wanted["t"].as_f64()?, 1e-12);
        let sigmas = [at.p[0], at.p[3], at.p[5]].map(|p| p.east().max(0.0).sqrt());
        for (k, wanted) in numbers(&wanted["now"])?.into_iter().enumerate().take(3) {
            judge.number("now", at.x[k].east(), wanted, case.tol * sigmas[k]);
        }
        let variance = wanted["now_var"].as_f64()?;
        judge.number("variance now", at.p[0].east(), variance, case.tol * variance);
        match (&lag, wanted.get("second_ago")) {
            (None, None) => {}
            (Some(lag), Some(ago)) => {
                for (k, wanted) in numbers(ago)?.into_iter().enumerate().take(3) {
                    let sigma = lag.covariance[(k, k)].max(0.0).sqrt();
                    judge.number("second ago", lag.value[k], wanted, case.tol * sigma);
                }
                let variance = wanted["second_ago_var"].as_f64()?;
                let found = lag.covariance[(0, 0)];
                judge.number("its variance", found, variance, case.tol * variance);
                judge.number("north", lag.value[3], numbers(ago)?[0], case.tol * variance.sqrt());
            }
            _ => judge.holds("a second ago from the second publication on", false),
        }
        state = at;
        now_s = until_s;
        lag = Some(FixedLag::of(&state, COPIED));
    }
    judge.holds("as many publications", expected.next().is_none());
    Some(())
}

fn extent(case: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let point = |p: Vec<f64>| Some(Vector2::new(*p.first()?, *p.get(1)?));
    let cells: Vec<Point2<f64>> = rows(&case.input["cells"])?
        .into_iter()
        .map(|p| point(p).map(Point2::from))
        .collect::<Option<_>>()?;
    let (centroid, moments) = Moments::of(&cells, case.number("cell_variance")?)?;
    let velocity = match case.list("velocity") {
        Some(velocity) => point(velocity)?,
        None => Vector2::zeros(),
    };
    let wanted = |key: &str| case.expected[key].as_f64();
    let relative = |v: f64| case.tol * v.abs().max(1.0);
    let place = numbers(&case.expected["centroid"])?;
    judge.number("east", centroid.x, *place.first()?, relative(centroid.x));
    judge.number("north", centroid.y, *place.get(1)?, relative(centroid.y));
    let (length, width) = moments.length_and_width_m(velocity);
    for (what, found) in
        [("length_along", length), ("width_across", width), ("longest", moments.longest_m())]
    {
        judge.number(what, found, wanted(what)?, relative(found));
    }
    // Equal moments have no axis; an axis and the one half a turn on are one.
    let gap = libm::hypot(moments.ee - moments.nn, 2.0 * moments.en);
    if gap > 1e-9 * (moments.ee.abs() + moments.nn.abs()) {
        let turn = models::frames::wrap_pi(2.0 * (moments.axis_rad() - wanted("axis")?)) / 2.0;
        judge.number("axis", turn, 0.0, case.tol);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_vectors_of_estimates_pass() {
        crate::assert_all_pass(&[
            ("tracking2/near_side", 15),
            ("tracking2/registration", 6),
            ("tracking2/event_moments", 6),
            ("tracking2/model_choice", 6),
            ("tracking2/fixed_lag", 6),
            ("tracking2/extent", 6),
        ]);
    }
}
