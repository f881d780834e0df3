//! Who is towed: off others' ways, off stands that others need, elsewhere where nothing leads away.

use super::closed::Closed;
use super::{Core, Phase};

/// Who has found no way for so long has those towed off who stand on it and have no next flight, s (assumed).
pub(super) const TOWED_OFF_S: f64 = 120.0;
/// Of so many free stands the first is taken from which a way leads on.
const MOST_LOOKED_AT: usize = 12;

impl Core {
    /// Its pushback is kept up by somebody who stands on his stand: he is towed off as where there is no way, or it is itself.
    /// `true`: something was done.
    pub(super) fn shut_in(&mut self, m: usize, blocker: Option<usize>) -> bool {
        let stands = |o: usize| self.movers.get(o).is_some_and(|b| b.phase == Phase::Docked);
        if !blocker.is_some_and(stands) {
            self.movers[m].shut_in_since_s = None;
            return false;
        }
        let now = self.time_s;
        let since = *self.movers[m].shut_in_since_s.get_or_insert(now);
        if now - since <= TOWED_OFF_S {
            return false;
        }
        self.tow_blockers(m);
        // Whoever has a next flight stays, and it leaves from elsewhere.
        let stays = blocker.is_some_and(|o| self.movers[o].phase == Phase::Docked);
        let done = !stays || self.tow_elsewhere(m);
        self.movers[m].shut_in_since_s = Some(now);
        done
    }

    /// Nothing leads away from a stand: of those who stand on the way that it has on an empty airport, the ones without a
    /// next flight are towed away.
    pub(super) fn tow_blockers(&mut self, m: usize) {
        let old = self.movers[m].clone();
        let told = self.remarks.len();
        let narrow = self.narrow(m);
        let easy = vec![false; 2 * self.net.edges.len()];
        let found = self.plan_departure(m, &narrow, &easy, &[]);
        let way = std::mem::replace(&mut self.movers[m], old);
        self.remarks.truncate(told);
        if !found {
            return;
        }
        let pieces: Vec<u32> = way.push.pieces.iter().chain(&way.way.pieces).copied().collect();
        self.tow_off(m, &pieces);
    }

    /// Of those who stand on some pieces, the ones without a next flight are towed away.
    pub(super) fn tow_off(&mut self, m: usize, pieces: &[u32]) {
        let class = self.movers[m].class;
        let mut blockers: Vec<usize> = Vec::new();
        for z in pieces {
            for (other, least) in self.pieces.conflicts(*z as usize, class) {
                let holders = self.holders[*other as usize].iter().map(|h| *h as usize);
                blockers.extend(holders.filter(|h| *h != m && self.movers[*h].class >= *least));
            }
        }
        blockers.sort_unstable();
        blockers.dedup();
        for o in blockers {
            let next = self.flights.iter().any(|g| g.turnaround_of == Some(o));
            if self.movers[o].phase != Phase::Docked || next {
                continue;
            }
            let (name, stand) = (&self.flights[o].callsign, self.movers[o].stand);
            let (stand, who) = (&self.net.stands[stand].name, &self.flights[m].callsign);
            let text = format!("{name}: towed away from stand {stand}, out of the way of {who}");
            self.remark(text);
            self.leave_stand(o);
        }
    }

    /// Nothing has led away for long: it is towed to another stand, where it is again two minutes later; to one from which a way leads
    /// to its runway now, where there is one, and back to where it was towed from only where nothing else is left.
    pub(super) fn tow_elsewhere(&mut self, m: usize) -> bool {
        let here = self.movers[m].stand;
        let Some(stand) = self.stand_to_tow_to(m) else { return false };
        let [from, to] = [here, stand].map(|s| self.net.stands[s].name.clone());
        let name = &self.flights[m].callsign;
        self.remark(format!("{name}: nothing leads away from stand {from}, towed to {to}"));
        self.leave_stand(m);
        let mover = &mut self.movers[m];
        mover.phase = Phase::Absent;
        mover.tow_to = Some(stand);
        mover.towed_from.push(here);
        mover.waits_since_s = None;
        mover.next_try_s = self.time_s + 120.0;
        true
    }

    /// Where a departure is towed to that nothing leads away from where it was.
    pub(super) fn stand_to_tow_to(&mut self, m: usize) -> Option<usize> {
        let here = self.movers[m].stand;
        let free = self.free_stands(m, MOST_LOOKED_AT).into_iter().map(|s| s.0);
        let free: Vec<usize> = free.filter(|s| *s != here).collect();
        let left = self.movers[m].towed_from.clone();
        tows_to(&free, &left, |s| self.leads_away(m, s))
    }

    /// Whether a pushback and a way lead from a stand to a departure's runway, among all who stand now.
    fn leads_away(&mut self, m: usize, stand: usize) -> bool {
        let old = self.movers[m].clone();
        let told = self.remarks.len();
        self.movers[m].stand = stand;
        self.movers[m].turned = self.is_turned_on(m, stand);
        let (closed, easy) = (self.closed(m), vec![false; 2 * self.net.edges.len()]);
        let found = self.plan_departure(m, &closed, &easy, &[]);
        self.movers[m] = old;
        self.remarks.truncate(told);
        found
    }

    /// No way leads to a stand that is free: those without a next flight who stand on the one that there is on an empty airport are
    /// towed away.
    pub(super) fn tow_off_way_to(&mut self, m: usize, stand: usize) {
        let old = self.movers[m].clone();
        self.movers[m].stand = stand;
        let mut searches = self.searches(m, Closed::Narrow);
        let found = self.plan_arrival(m, &mut searches, &[]);
        let way = std::mem::replace(&mut self.movers[m], old).way;
        if found {
            self.tow_off(m, &way.pieces);
        }
    }

    /// The aircraft that has stood longest without a next flight is towed away.
    pub(super) fn make_room(&mut self, m: usize) -> Option<(usize, Vec<u32>)> {
        let idle = |o: &usize| {
            let other = &self.movers[*o];
            other.phase == Phase::Docked
                && other.class >= self.movers[m].class
                && other.measures.aibt_s.is_some_and(|t| self.time_s > t + 1200.0)
                && !self.flights.iter().any(|g| g.turnaround_of == Some(*o))
        };
        let oldest = (0..self.movers.len()).filter(idle).min_by(|a, b| {
            let since = |o: usize| self.movers[o].measures.aibt_s.unwrap_or(0.0);
            since(*a).total_cmp(&since(*b))
        })?;
        self.remark(format!(
            "{}: towed away from stand {}",
            self.flights[oldest].callsign, self.net.stands[self.movers[oldest].stand].name
        ));
        self.leave_stand(oldest);
        self.free_stand(m)
    }
}

/// Of free stands, best first, the one to tow to: one from which a way leads on, else one that it has not left, else the best.
fn tows_to(
    free: &[usize],
    left: &[usize],
    mut leads_away: impl FnMut(usize) -> bool,
) -> Option<usize> {
    let free = || free.iter().copied();
    let leads = free().find(|s| leads_away(*s));
    leads.or_else(|| free().find(|s| !left.contains(s))).or_else(|| free().next())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At Osnova a departure went to and fro between two stands from which nothing led away (six times in half an hour), and two stands
    /// farther a way was open.
    #[test]
    fn a_tow_ends_where_a_way_leads_on_and_not_where_it_began() {
        assert_eq!(tows_to(&[3, 4, 5], &[], |s| s == 5), Some(5));
        assert_eq!(tows_to(&[3, 4, 5], &[3], |_| false), Some(4));
        assert_eq!(tows_to(&[3, 4], &[3], |s| s == 3), Some(3), "there is a way by now");
        assert_eq!(tows_to(&[3, 4], &[4, 3], |_| false), Some(3));
        assert_eq!(tows_to(&[], &[3], |_| true), None);
    }
}
