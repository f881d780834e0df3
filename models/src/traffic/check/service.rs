//! Who is served, who is stuck, and whether anything moves.

use super::{Breaches, Last, Row, Rules, STILL_MPS, Seen, Who};
use crate::frames::Point2;
use crate::traffic::core::Direction;

/// What one mover has done.
#[derive(Clone, Copy, Debug, Default)]
struct Done {
    /// Seen on the ground, in the air after it, on the ground after the air.
    on_ground: bool,
    airborne: bool,
    landed: bool,
    moved: bool,
    stuck: bool,
    last_s: f64,
    last_m: Option<(Point2<f64>, f64)>,
}

/// Service of all.
#[derive(Clone, Debug)]
pub(super) struct Service {
    done: Vec<Done>,
    /// Since when nothing moved while somebody waited, s.
    nothing_since_s: Option<f64>,
    told: bool,
    gridlocks: Breaches,
    stuck: Breaches,
}

fn plane(s: &Seen) -> Point2<f64> {
    Point2::new(s.position_m.x, s.position_m.y)
}

/// Whether a mover stands on one of the stands: its middle is within its length of one.
fn on_stand(who: &Who, stands_m: &[Point2<f64>], at_m: Point2<f64>) -> bool {
    stands_m.iter().any(|s| (s - at_m).norm() <= 0.7 * who.size.length_m.max(20.0))
}

impl Service {
    pub(super) fn new(count: usize) -> Self {
        Self {
            done: vec![Done::default(); count],
            nothing_since_s: None,
            told: false,
            gridlocks: Breaches::default(),
            stuck: Breaches::default(),
        }
    }

    pub(super) fn look(
        &mut self,
        rules: &Rules,
        who: &[Who],
        stands_m: &[Point2<f64>],
        time_s: f64,
        seen: &[Seen],
        last: &[Option<Last>],
    ) {
        let mut moves = false;
        let mut waits: Vec<usize> = Vec::new();
        for s in seen {
            let one = &mut self.done[s.who];
            let high = s.position_m.z > 15.0;
            let low = s.position_m.z < 1.0;
            one.landed |= one.airborne && low;
            one.airborne |= high;
            one.on_ground |= low && !one.airborne;
            let (v, at_m) = (s.velocity_mps.norm(), plane(s));
            one.moved |= v > 0.5;
            one.last_s = time_s;
            one.last_m = Some((at_m, v));
            if v > STILL_MPS {
                moves = true;
            } else if low && one.moved && !on_stand(&who[s.who], stands_m, at_m) {
                waits.push(s.who);
                let since = last[s.who].as_ref().filter(|l| l.seen.velocity_mps.norm() < STILL_MPS);
                let stood_s = since.map_or(0.0, |l| time_s - l.still_since_s);
                if stood_s > rules.stuck_s && !one.stuck {
                    one.stuck = true;
                    self.stuck.add(|| {
                        let name = &who[s.who].callsign;
                        format!(
                            "{name} stands since {:.0} s at {:.0} {:.0}",
                            time_s - stood_s,
                            at_m.x,
                            at_m.y
                        )
                    });
                }
            }
        }
        self.gridlocks.of += 1;
        if moves || waits.is_empty() {
            (self.nothing_since_s, self.told) = (None, false);
            return;
        }
        let since = *self.nothing_since_s.get_or_insert(time_s);
        if time_s - since >= rules.gridlock_s && !self.told {
            self.told = true;
            let names: Vec<&str> = waits.iter().map(|w| who[*w].callsign.as_str()).collect();
            self.gridlocks
                .add(|| format!("nothing moves since {since:.0} s: {}", names.join(", ")));
        }
    }

    pub(super) fn gridlocks(&mut self) -> [Row; 2] {
        let mut stuck = std::mem::take(&mut self.stuck);
        stuck.of = self.done.iter().filter(|d| d.moved).count() as u64;
        [std::mem::take(&mut self.gridlocks).row("gridlocks"), stuck.row("stuck")]
    }

    pub(super) fn served(
        self,
        rules: &Rules,
        who: &[Who],
        stands_m: &[Point2<f64>],
        end_s: f64,
    ) -> Row {
        let mut missed = Breaches::default();
        for (one, w) in self.done.iter().zip(who) {
            let Some(direction) = w.direction.filter(|d| *d != Direction::Vehicle) else {
                continue;
            };
            if w.due_s + rules.serve_s > end_s {
                continue;
            }
            missed.of += 1;
            let parked =
                one.last_m.is_some_and(|(at, v)| v < STILL_MPS && on_stand(w, stands_m, at));
            let (served, what) = match direction {
                Direction::Departure => (one.on_ground && one.airborne, "not airborne"),
                Direction::Arrival | Direction::Vehicle => (one.landed && parked, "not on a stand"),
            };
            if served {
                continue;
            }
            missed.add(|| {
                let place = match one.last_m {
                    Some((at, _)) => {
                        format!("last seen at {:.0} s at {:.0} {:.0}", one.last_s, at.x, at.y)
                    }
                    None => "never seen".into(),
                };
                format!("{} ({direction:?}, due {:.0} s): {what}, {place}", w.callsign, w.due_s)
            });
        }
        missed.row("served")
    }
}
