//! What is remembered of a track, and of a strip, from scan to scan; bounded.

use super::{Target, TargetClass};
use crate::control::clearance::Board;
use crate::frames::{Point2, Vector2};
use crate::plot::Callsign;
use crate::time::SimTime;

/// Positions kept per track: ten seconds and one more at a scan a second.
const KEPT: usize = 12;
/// Positions that are kept, but for the last one, are as far apart, s: all of them together reach ten seconds back at any scan.
const APART_S: f64 = 0.92;
/// Room for them: a power of two, so that a place is found by a mask.
const ROOM: usize = 16;
/// Noses kept: where it is and three before.
const NOSES: usize = 4;
/// A name that another track had so recently is taken over, s.
const TAKEN_OVER_S: f64 = 30.0;

/// Half a length that is not known, m (assumed): no more than of a light aircraft.
pub(super) const UNKNOWN_HALF_M: f64 = 4.0;

/// Noise puts one who stands no farther than this beyond the anchor's distance, m (assumed).
const STRAY_M: f64 = 10.0;

/// Where a track was in its last scans (of scans shorter than [`APART_S`], in the last one and in some before), a column each: a scan looks
/// at few of the times, at fewer of the places, and at the jumps only of who has jumped.
#[derive(Clone, Debug)]
pub(super) struct Places {
    at: [SimTime; ROOM],
    place_m: [Point2<f64>; ROOM],
    /// Of the last few scans only.
    nose_m: [Point2<f64>; NOSES],
    noses: u8,
    /// What its jumps have moved it until then, m, and how long they took, s; empty before the first of them.
    jumps: Vec<(Vector2<f64>, f64)>,
    next: u8,
    pub(super) kept: u8,
}

impl Places {
    fn none() -> Self {
        let (at, nowhere) = ([SimTime::ZERO; ROOM], Point2::origin());
        let (place_m, nose_m) = ([nowhere; ROOM], [nowhere; NOSES]);
        Self { at, place_m, nose_m, noses: 0, jumps: Vec::new(), next: 0, kept: 0 }
    }

    /// Index of the `n`-th latest, from 1 on; `n` is not above what is kept.
    #[inline]
    fn back(&self, n: usize) -> usize {
        usize::from(self.next).wrapping_sub(n) % ROOM
    }

    /// Time and place of the `n`-th latest, from 1 on.
    #[inline]
    pub(super) fn latest(&self, n: usize) -> (SimTime, Point2<f64>) {
        let at = self.back(n);
        (self.at[at], self.place_m[at])
    }

    /// Where the nose was in the three scans before the last one, the latest first.
    pub(super) fn noses_before_m(&self) -> [Option<Point2<f64>>; 3] {
        let kept = usize::from(self.noses);
        [2, 3, 4].map(|n| (n <= kept).then(|| self.nose_m[(kept - n) % NOSES]))
    }

    /// Index of the latest that is as old as a look back goes: mostly the one of so many scans ago.
    #[inline]
    fn before(&self, back: &Back) -> Option<usize> {
        let kept = usize::from(self.kept);
        let old = |n: usize| self.at[self.back(n)] <= back.limit;
        if back.scans > 1 && back.scans <= kept && old(back.scans) && !old(back.scans - 1) {
            return Some(self.back(back.scans));
        }
        (1..=kept).find(|n| old(*n)).map(|n| self.back(n))
    }

    #[inline]
    pub(super) fn keep(
        &mut self,
        now: SimTime,
        place_m: Point2<f64>,
        nose_m: Point2<f64>,
        jumps: (Vector2<f64>, f64),
    ) {
        // Of scans that are short the last place gives way, as long as it is not far enough from the one before it; as the last one may be
        // near, two more are kept.
        let short = self.kept >= 1 && now.since_s(self.latest(1).0) < APART_S;
        let most = if short { KEPT + 2 } else { KEPT };
        if self.kept >= 2 && self.latest(1).0.since_s(self.latest(2).0) < APART_S {
            self.next = self.next.wrapping_sub(1);
            self.kept -= 1;
        }
        let next = usize::from(self.next) % ROOM;
        (self.at[next], self.place_m[next]) = (now, place_m);
        // Counts on in rounds of four.
        self.nose_m[usize::from(self.noses) % NOSES] = nose_m;
        self.noses =
            if usize::from(self.noses) >= 2 * NOSES - 1 { NOSES as u8 } else { self.noses + 1 };
        // Until the first jump nothing has been moved by one.
        if jumps.1 > 0.0 {
            self.jumps.resize(ROOM, Default::default());
            self.jumps[next] = jumps;
        }
        self.next = self.next.wrapping_add(1);
        self.kept = (self.kept + 1).min(most as u8);
    }
}

/// How far back one looks in a scan, the same for all tracks.
pub(super) struct Back {
    seconds: f64,
    /// Places until then are old enough.
    limit: SimTime,
    /// So many scans ago, at a scan a second.
    scans: usize,
}

impl Back {
    pub(super) fn new(now: SimTime, seconds: f64) -> Self {
        let limit = SimTime(now.0.saturating_sub(SimTime::from_s(seconds).0) + 1_000_000);
        Self { seconds, limit, scans: (seconds.clamp(0.0, KEPT as f64)) as usize }
    }
}

/// What a track has with its name.
#[derive(Clone, Copy, Debug)]
pub(super) struct Named {
    pub(super) strip: u32,
    pub(super) callsign: Option<Callsign>,
    pub(super) class: TargetClass,
    pub(super) arriving: bool,
    pub(super) length_m: f64,
}

/// A jump of which is not known yet whether it was a movement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jump {
    /// Time and place before it, and the mean velocity there, m/s.
    pub(super) from: SimTime,
    pub(super) from_m: Point2<f64>,
    pub(super) mean_mps: Vector2<f64>,
    /// When, in which direction and how far, m.
    pub(super) at: SimTime,
    pub(super) along: Vector2<f64>,
    pub(super) off_m: f64,
}

impl Jump {
    /// From where it would be without the jump to a place, m.
    pub(super) fn off(&self, position_m: Point2<f64>, since_s: f64) -> Vector2<f64> {
        position_m - self.from_m - self.mean_mps * since_s
    }
}

/// What is remembered of a track.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    /// Place of its situation in the scan in which it was last seen.
    pub(super) index: u32,
    pub(super) seen: SimTime,
    pub(super) places: Places,
    pub(super) heading: Option<Vector2<f64>>,
    pub(super) anchor_m: Point2<f64>,
    pub(super) still_since: SimTime,
    /// On tracks: it has gone from its anchor, and goes on.
    pub(super) away: bool,
    pub(super) last_final: Option<(SimTime, usize)>,
    pub(super) last_fast: Option<SimTime>,
    pub(super) callsign: Option<Callsign>,
    pub(super) strip: Option<u32>,
    pub(super) board_version: u64,
    pub(super) born: SimTime,
    /// Velocities of the last scans, the latest first.
    pub(super) velocities: [Vector2<f64>; 3],
    pub(super) jumped: Option<SimTime>,
    /// All that its jumps have moved it, m, and how long they took, s.
    pub(super) jumps: (Vector2<f64>, f64),
    /// It jumped so, and it is not seen yet whether it goes on.
    pub(super) goes_on: Option<Jump>,
    /// It went on from a jump, last.
    pub(super) went_on: Option<SimTime>,
    /// Of one without a name: half its length by where it held before a line, m.
    pub(super) held_half_m: f64,
    /// Where it was, and when, before the first of the jumps that follow each other.
    pub(super) before_jumps: (SimTime, Point2<f64>),
    /// Is far from where it had to be.
    pub(super) leaps: bool,
    /// Was so last where that mattered.
    pub(super) leapt: Option<SimTime>,
    /// Strips in which it was last.
    pub(super) strips: u32,
    /// Its plots came again after it had coasted.
    pub(super) found_again: Option<SimTime>,
    pub(super) last_plot: SimTime,
    /// Was slower than a roll.
    pub(super) was_slow: bool,
    /// Who it was when it last had a strip, and when.
    pub(super) had: Option<Named>,
    pub(super) had_at: SimTime,
    /// On final to a runway since, and until.
    pub(super) final_span: Option<(SimTime, SimTime, usize)>,
    /// Time to the threshold when that began, s.
    pub(super) final_from_s: f64,
    /// Under its present strip since.
    pub(super) named: SimTime,
    /// Its strip was another track's shortly before.
    pub(super) taken_over: bool,
    /// Without a name, it was beside one who rolls or flies, last.
    pub(super) beside: Option<SimTime>,
    /// Jumped again soon after it had jumped.
    pub(super) restless: Option<SimTime>,
    /// When it was last new, under a new name, found again, jumped or leapt.
    pub(super) troubled: SimTime,
}

/// What is remembered of a strip, whichever track has it: a track that is lost and found again has landed, too.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OfStrip {
    pub(super) last_final: Option<(SimTime, usize)>,
    pub(super) last_fast: Option<SimTime>,
    /// The track that had it last, and when.
    pub(super) had: Option<(u16, SimTime)>,
}

impl Memory {
    pub(super) fn new(now: SimTime, target: &Target) -> Self {
        Self {
            index: 0,
            seen: now,
            places: Places::none(),
            heading: None,
            anchor_m: target.position_m,
            still_since: now,
            away: false,
            last_final: None,
            last_fast: None,
            callsign: None,
            strip: None,
            board_version: u64::MAX,
            born: now,
            velocities: [target.velocity_mps; 3],
            jumped: None,
            jumps: Default::default(),
            goes_on: None,
            went_on: None,
            held_half_m: UNKNOWN_HALF_M,
            before_jumps: (now, target.position_m),
            leaps: false,
            leapt: None,
            strips: 0,
            found_again: None,
            last_plot: target.last_plot,
            was_slow: false,
            had: None,
            had_at: now,
            final_span: None,
            final_from_s: 0.0,
            named: now,
            taken_over: false,
            beside: None,
            restless: None,
            troubled: now,
        }
    }

    /// Mean speed since the latest place that is old enough. A jump moves nobody: the least of that, of that without the
    /// steps in which it jumped, and of that since before it began to jump (it may have been drawn away and be on its way back).
    #[inline(always)]
    pub(super) fn mean_mps(&self, now: SimTime, position_m: Point2<f64>, back: &Back) -> f64 {
        let Some(before) = self.places.before(back) else {
            return 0.0;
        };
        let moved_m = position_m - self.places.place_m[before];
        let over_s = now.since_s(self.places.at[before]);
        let mean_mps = moved_m.norm() / over_s;
        if self.jumps.1 <= 0.0 {
            return mean_mps;
        }
        self.without_jumps(mean_mps, now, position_m, before, back)
    }

    #[cold]
    fn without_jumps(
        &self,
        mean_mps: f64,
        now: SimTime,
        position_m: Point2<f64>,
        before: usize,
        back: &Back,
    ) -> f64 {
        let moved_m = position_m - self.places.place_m[before];
        let over_s = now.since_s(self.places.at[before]);
        let jumps = self.places.jumps.get(before).copied().unwrap_or_default();
        let (jumped_m, jumped_s) = (self.jumps.0 - jumps.0, self.jumps.1 - jumps.1);
        if jumped_s <= 0.0 {
            return mean_mps;
        }
        let driven_s = over_s - jumped_s;
        let driven_mps = if driven_s > 0.1 { (moved_m - jumped_m).norm() / driven_s } else { 0.0 };
        let (before, before_m) = self.before_jumps;
        let since_mps =
            (position_m - before_m).norm() / now.since_s(before).clamp(0.1, back.seconds);
        mean_mps.min(driven_mps).min(since_mps)
    }

    /// Finds the strip of a track; what is remembered of the strip is the track's, too.
    pub(super) fn name(
        &mut self,
        now: SimTime,
        board: &Board,
        target: &Target,
        of_strips: &mut [OfStrip],
    ) {
        if self.callsign == target.callsign && self.board_version == board.version() {
            return;
        }
        self.callsign = target.callsign;
        self.board_version = board.version();
        let before = self.strip;
        self.strip = target.callsign.and_then(|c| board.find(c)).map(|i| i as u32);
        if let Some(strip) = self.strip {
            let Target { callsign, class, arriving, length_m, .. } = *target;
            self.had = Some(Named { strip, callsign, class, arriving, length_m });
        }
        let Some(known) = self.strip.filter(|s| before != Some(*s)) else { return };
        let Some(known) = of_strips.get(known as usize) else { return };
        self.named = now;
        let other = known.had.filter(|(number, _)| *number != target.number);
        self.taken_over = other.is_some_and(|(_, at)| now.since_s(at) <= TAKEN_OVER_S);
        self.troubled = now;
        self.last_final = self.last_final.max(known.last_final);
        self.last_fast = self.last_fast.max(known.last_fast);
    }

    /// Since when it stands, on tracks. Anchors 15 m apart leave the last one anywhere in the last 15 m of its way, and noise moves
    /// them; so it is when it was last a third of that from where it came to stand, and who stands moves no anchor.
    pub(super) fn stand(
        &mut self,
        now: SimTime,
        position_m: Point2<f64>,
        anchor_m: f64,
        moves: bool,
    ) {
        let gone_m = (position_m - self.anchor_m).norm();
        self.away |= gone_m > if moves { anchor_m } else { anchor_m + STRAY_M };
        if self.away && moves {
            self.still_since = now;
        } else if self.away {
            let latest_first = (1..=usize::from(self.places.kept)).map(|n| self.places.latest(n));
            let far = |(_, place_m): &(SimTime, Point2<f64>)| {
                (position_m - place_m).norm() > anchor_m / 3.0
            };
            let since = latest_first.into_iter().find(far).map(|(at, _)| at);
            (self.anchor_m, self.still_since) = (position_m, since.unwrap_or(now));
            self.away = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place of which a mean speed is taken is the latest that is old enough, however often there are scans; of scans that follow
    /// each other within less than a second, one that is at most two seconds older.
    #[test]
    fn a_look_back_finds_the_latest_that_is_old_enough() {
        for step_s in [1.0, 2.0, 1.5, 4.0, 0.95, 0.9, 0.5, 0.25, 0.1, 0.03] {
            for seconds in [3.0, 10.0] {
                let mut places = Places::none();
                for scan in 0..(30.0_f64 / step_s).max(30.0) as u32 {
                    let now = SimTime::from_s(f64::from(scan) * step_s);
                    let found = places.before(&Back::new(now, seconds)).map(|at| places.at[at]);
                    let mut old = (0..scan).rev().map(|s| f64::from(s) * step_s);
                    let latest = old.find(|s| now.s() - s >= seconds - 1e-9);
                    let name = format!("scan {scan}, {step_s} s apart, {seconds} s back");
                    assert_eq!(found.is_some(), latest.is_some(), "{name}");
                    if let (Some(found), Some(latest)) = (found, latest) {
                        let slack_s = if step_s < APART_S { 2.0 * APART_S } else { 1e-9 };
                        let older_s = latest - found.s();
                        assert!((-1e-9..=slack_s).contains(&older_s), "{name}: {older_s} s");
                    }
                    let here = Point2::new(now.s(), 0.0);
                    places.keep(now, here, here, Default::default());
                    // The last scan itself is there, and the noses are those of the scans before it.
                    assert_eq!(places.latest(1), (now, here), "{name}");
                    for (nose_m, back) in places.noses_before_m().into_iter().zip(1..) {
                        let expected = (back <= scan).then(|| f64::from(scan - back) * step_s);
                        let expected_m = expected.map(|s| Point2::new(SimTime::from_s(s).s(), 0.0));
                        assert_eq!(nose_m, expected_m, "{name}: nose {back}");
                    }
                }
            }
        }
    }
}
