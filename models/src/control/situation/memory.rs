//! What is remembered of a track, and of a strip, from scan to scan; bounded.

use super::Target;
use crate::control::clearance::Board;
use crate::frames::Vector2;
use crate::plot::Callsign;
use crate::time::SimTime;

/// Positions kept per track: ten seconds and one more at a scan a second.
pub(super) const KEPT: usize = 12;
/// A name that another track had so recently is taken over, s.
const TAKEN_OVER_S: f64 = 30.0;

/// Noise puts one who stands no farther than this beyond the anchor's distance, m (assumed).
const STRAY_M: f64 = 10.0;

/// Where a track was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) at: SimTime,
    pub(super) place_m: Vector2<f64>,
    /// What its jumps have moved it until then, m, and how long they took, s.
    jumps: (Vector2<f64>, f64),
}

/// What is remembered of a track.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    pub(super) seen: SimTime,
    pub(super) places: [Place; KEPT],
    pub(super) next: usize,
    pub(super) kept: usize,
    pub(super) heading: Option<Vector2<f64>>,
    pub(super) noses_m: [Option<Vector2<f64>>; 3],
    pub(super) anchor_m: Vector2<f64>,
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
    /// Where it was, and when, before the first of the jumps that follow each other.
    pub(super) before_jumps: (SimTime, Vector2<f64>),
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
    /// The strip that it had, as it was then, and when last.
    pub(super) had: Option<(u32, Target, SimTime)>,
    /// On final to a runway since, and until.
    pub(super) final_span: Option<(SimTime, SimTime, usize)>,
    /// Time to the threshold when that began, s.
    pub(super) final_from_s: f64,
    /// Under its present strip since.
    pub(super) named: SimTime,
    /// Its strip was another track's shortly before.
    pub(super) taken_over: bool,
    /// Jumped again soon after it had jumped.
    pub(super) restless: Option<SimTime>,
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
            seen: now,
            places: [Place { at: now, place_m: target.position_m, jumps: Default::default() };
                KEPT],
            next: 0,
            kept: 0,
            heading: None,
            noses_m: [None; 3],
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
            before_jumps: (now, target.position_m),
            leaps: false,
            leapt: None,
            strips: 0,
            found_again: None,
            last_plot: target.last_plot,
            was_slow: false,
            had: None,
            final_span: None,
            final_from_s: 0.0,
            named: now,
            taken_over: false,
            restless: None,
        }
    }

    /// The latest place that is at least so many seconds old.
    fn place_before(&self, now: SimTime, seconds: f64) -> Option<&Place> {
        let limit = SimTime(now.0.saturating_sub(SimTime::from_s(seconds).0) + 1_000_000);
        self.latest_first().find(|place| place.at <= limit)
    }

    /// The kept places, the latest first.
    fn latest_first(&self) -> impl Iterator<Item = &Place> {
        let (newer, older) = self.places[..self.kept].split_at(self.next.min(self.kept));
        newer.iter().rev().chain(older.iter().rev())
    }

    /// Mean speed since the latest place that is at least `mean_s` old. A jump moves nobody: the least of that, of that without the
    /// steps in which it jumped, and of that since before it began to jump (it may have been drawn away and be on its way back).
    pub(super) fn mean_mps(&self, now: SimTime, position_m: Vector2<f64>, mean_s: f64) -> f64 {
        let Some(&Place { at, place_m, jumps }) = self.place_before(now, mean_s) else {
            return 0.0;
        };
        let (moved_m, over_s) = (position_m - place_m, now.since_s(at));
        let mean_mps = moved_m.norm() / over_s;
        let (jumped_m, jumped_s) = (self.jumps.0 - jumps.0, self.jumps.1 - jumps.1);
        if jumped_s <= 0.0 {
            return mean_mps;
        }
        let driven_s = over_s - jumped_s;
        let driven_mps = if driven_s > 0.1 { (moved_m - jumped_m).norm() / driven_s } else { 0.0 };
        let (before, before_m) = self.before_jumps;
        let since_mps = (position_m - before_m).norm() / now.since_s(before).clamp(0.1, mean_s);
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
        let Some(known) = self.strip.filter(|s| before != Some(*s)) else { return };
        let Some(known) = of_strips.get(known as usize) else { return };
        self.named = now;
        let other = known.had.filter(|(number, _)| *number != target.number);
        self.taken_over = other.is_some_and(|(_, at)| now.since_s(at) <= TAKEN_OVER_S);
        self.last_final = self.last_final.max(known.last_final);
        self.last_fast = self.last_fast.max(known.last_fast);
    }

    /// Since when it stands, on tracks. Anchors 15 m apart leave the last one anywhere in the last 15 m of its way, and noise moves
    /// them; so it is when it was last a third of that from where it came to stand, and who stands moves no anchor.
    pub(super) fn stand(
        &mut self,
        now: SimTime,
        position_m: Vector2<f64>,
        anchor_m: f64,
        moves: bool,
    ) {
        let gone_m = (position_m - self.anchor_m).norm();
        self.away |= gone_m > if moves { anchor_m } else { anchor_m + STRAY_M };
        if self.away && moves {
            self.still_since = now;
        } else if self.away {
            let far = |place: &&Place| (position_m - place.place_m).norm() > anchor_m / 3.0;
            let since = self.latest_first().find(far).map(|place| place.at);
            (self.anchor_m, self.still_since) = (position_m, since.unwrap_or(now));
            self.away = false;
        }
    }

    pub(super) fn keep(&mut self, now: SimTime, position_m: Vector2<f64>) {
        self.places[self.next] = Place { at: now, place_m: position_m, jumps: self.jumps };
        self.next = (self.next + 1) % KEPT;
        self.kept = (self.kept + 1).min(KEPT);
    }
}
