//! Runway monitoring and conflict alerting: who is in the way of whom on a runway.

use super::alert::{AlertKind, Condition, Stage, Subject};
use super::layout::{Layout, RunwayAxis};
use super::parameters::Parameters;
use super::situation::{Situation, Surveillance};
use crate::time::SimTime;

/// One on final to, or fast on, a runway: it uses all of it.
struct User<'a> {
    situation: &'a Situation,
    /// +1 from the first end, −1 from the second.
    direction: f64,
    /// Place along the axis and speed along it, in its own direction.
    place_m: f64,
    speed_mps: f64,
    /// Time to the threshold on final; `None`: it rolls.
    final_s: Option<f64>,
}

/// One in the strip of a runway.
struct Inside<'a> {
    situation: &'a Situation,
    place_m: f64,
    along_mps: f64,
}

/// Gravity within a pair: only the gravest is raised.
fn gravity(kind: AlertKind) -> u8 {
    match kind {
        AlertKind::RunwayOpposite => 3,
        AlertKind::RunwayCrossing => 2,
        AlertKind::RunwayRoll => 1,
        _ => 0,
    }
}

/// Adds the conditions of all runways (`RMCA_*`, `RWY_CLOSED`), of each pair the gravest.
pub(super) fn conditions(
    layout: &Layout,
    parameters: &Parameters,
    (now, low_visibility): (SimTime, bool),
    surveillance: &Surveillance,
    out: &mut Vec<Condition>,
) {
    if surveillance.of_runways().is_empty() {
        return;
    }
    let mut pairs = Vec::new();
    let users: Vec<Vec<User<'_>>> =
        (0..layout.runways.len()).map(|r| users(layout, r, surveillance)).collect();
    for (r, runway) in layout.runways.iter().enumerate() {
        let inside = inside(runway, r, surveillance);
        let scene = Scene { now, runway, r, parameters, low_visibility };
        for (i, user) in users[r].iter().enumerate() {
            scene.against_users(user, &users[r][i + 1..], &mut pairs);
            scene.against_inside(user, &inside, &mut pairs);
            scene.closed(user, out);
        }
    }
    for crossing in &layout.crossings {
        let [a, b] = crossing.runways;
        for first in users.get(a).into_iter().flatten() {
            for second in users.get(b).into_iter().flatten() {
                let time = |user: &User<'_>, place_m: f64| {
                    (place_m - user.place_m) * user.direction / user.speed_mps
                };
                let times = [time(first, crossing.places_m[0]), time(second, crossing.places_m[1])];
                let ahead = times.iter().all(|t| (0.0..=parameters.crossing_ahead_s).contains(t));
                let other = first.situation.target.number != second.situation.target.number;
                if other && ahead && (times[0] - times[1]).abs() <= parameters.crossing_apart_s {
                    pairs.push(pair(
                        AlertKind::RunwayCrossing,
                        Stage::Alarm,
                        first.situation,
                        second.situation,
                        a,
                    ));
                }
            }
        }
    }
    // Of each pair the gravest kind in its gravest stage.
    pairs.sort_by(|a, b| {
        let grave = |c: &Condition| (gravity(c.kind), c.stage);
        a.subjects.cmp(&b.subjects).then(grave(b).cmp(&grave(a)))
    });
    pairs.dedup_by_key(|c| c.subjects);
    out.append(&mut pairs);
}

fn pair(kind: AlertKind, stage: Stage, k: &Situation, m: &Situation, runway: usize) -> Condition {
    let (a, b) = (Subject::Track(k.target.number), Subject::Track(m.target.number));
    Condition {
        kind,
        subjects: (a.min(b), Some(a.max(b))),
        stage,
        runway: Some(runway),
        place_m: m.target.position_m,
        crosses: false,
    }
}

fn users<'a>(layout: &Layout, r: usize, surveillance: &'a Surveillance) -> Vec<User<'a>> {
    let runway = &layout.runways[r];
    let of = |index: &u32| {
        let situation = &surveillance.situations()[*index as usize];
        let on_final = situation.on_final.filter(|f| f.runway == r);
        let rolls = situation.fast == Some(r);
        let along_mps = runway.along_mps(situation.target.velocity_mps);
        (on_final.is_some() || rolls).then(|| User {
            situation,
            direction: if along_mps < 0.0 { -1.0 } else { 1.0 },
            place_m: runway.place_m(situation.target.position_m).0,
            speed_mps: along_mps.abs(),
            // One that is over the runway and before a displaced threshold is both: it lands.
            final_s: on_final.filter(|_| !rolls).map(|f| f.time_s),
        })
    };
    surveillance.of_runways().iter().filter_map(of).collect()
}

fn inside<'a>(runway: &RunwayAxis, r: usize, surveillance: &'a Surveillance) -> Vec<Inside<'a>> {
    let of = |index: &u32| {
        let situation = &surveillance.situations()[*index as usize];
        situation.in_strip(r).then(|| Inside {
            situation,
            place_m: runway.place_m(situation.target.position_m).0,
            along_mps: runway.along_mps(situation.target.velocity_mps),
        })
    };
    surveillance.of_runways().iter().filter_map(of).collect()
}

struct Scene<'a> {
    now: SimTime,
    runway: &'a RunwayAxis,
    r: usize,
    parameters: &'a Parameters,
    low_visibility: bool,
}

impl Scene<'_> {
    fn times_s(&self) -> (f64, f64) {
        let p = self.parameters;
        if self.low_visibility {
            (p.low_visibility_information_s, p.low_visibility_alarm_s)
        } else {
            (p.information_s, p.alarm_s)
        }
    }

    fn against_users(&self, k: &User<'_>, others: &[User<'_>], pairs: &mut Vec<Condition>) {
        let near = |u: &User<'_>| u.final_s.is_none_or(|t| t <= self.parameters.opposite_s);
        for m in others.iter().filter(|m| m.direction != k.direction && near(m) && near(k)) {
            // Two rolls against each other count as one ahead of the other, below.
            if k.final_s.is_some() || m.final_s.is_some() {
                pairs.push(pair(
                    AlertKind::RunwayOpposite,
                    Stage::Alarm,
                    k.situation,
                    m.situation,
                    self.r,
                ));
            }
        }
    }

    fn against_inside(&self, k: &User<'_>, inside: &[Inside<'_>], pairs: &mut Vec<Condition>) {
        let p = self.parameters;
        let (information_s, alarm_s) = self.times_s();
        let far_end_m = if k.direction > 0.0 { self.runway.length_m } else { 0.0 };
        for m in inside {
            if m.situation.target.number == k.situation.target.number {
                continue;
            }
            let same_way_mps = m.along_mps * k.direction;
            let elsewhere = m.situation.fast.is_some_and(|runway| runway != self.r);
            let Some(t) = k.final_s else {
                let ahead_m = (m.place_m - k.place_m) * k.direction;
                if ahead_m <= 0.0 {
                    continue;
                }
                let leaves = same_way_mps >= p.fast_mps
                    && same_way_mps >= k.speed_mps - p.following_mps
                    && ahead_m > p.following_m;
                if same_way_mps <= -p.fast_mps {
                    pairs.push(pair(
                        AlertKind::RunwayOpposite,
                        Stage::Alarm,
                        k.situation,
                        m.situation,
                        self.r,
                    ));
                } else if !leaves && !elsewhere {
                    let (kind, stage) = (AlertKind::RunwayRoll, Stage::Alarm);
                    let across_mps = self.runway.across_mps(m.situation.target.velocity_mps).abs();
                    let crosses = across_mps > m.along_mps.abs().max(p.push_mps);
                    let towards = pair(kind, stage, k.situation, m.situation, self.r);
                    pairs.push(Condition { crosses, ..towards });
                }
                continue;
            };
            let end = usize::from(k.direction < 0.0);
            let from_end = |place_m: f64| {
                if end == 0 { place_m } else { self.runway.length_m - place_m }
            };
            let behind_threshold_m = from_end(m.place_m) - self.runway.displaced_m[end];
            let short = behind_threshold_m < -p.short_of_threshold_m;
            let then_m = m.place_m + m.along_mps * t;
            let gone = same_way_mps >= p.fast_mps && (then_m - far_end_m) * k.direction > 0.0;
            let lifts_off = same_way_mps >= p.final_mps
                && behind_threshold_m + same_way_mps * t >= p.departed_m;
            if t <= information_s && !elsewhere && !short && !gone && !lifts_off {
                let stage = if t <= alarm_s { Stage::Alarm } else { Stage::Information };
                pairs.push(pair(AlertKind::RunwayArrival, stage, k.situation, m.situation, self.r));
            }
        }
    }

    fn closed(&self, k: &User<'_>, out: &mut Vec<Condition>) {
        if self.runway.is_closed(self.now) && k.final_s.is_none_or(|t| t <= self.times_s().0) {
            out.push(Condition {
                kind: AlertKind::RunwayClosed,
                subjects: (Subject::Track(k.situation.target.number), None),
                stage: Stage::Alarm,
                runway: Some(self.r),
                place_m: k.situation.target.position_m,
                crosses: false,
            });
        }
    }
}
