//! When which datagram of a recording is due. No file, no socket, no clock: the caller tells the
//! time and sends what is due.
//!
//! The schedule is absolute: a position in the recording is computed from the wall time that passed
//! since the last change of pace, never added up from steps, so an hour of playing ends where an hour of
//! recording ends.

use std::ops::Range;

/// Datagrams with times that never decrease.
pub trait Timeline {
    /// How many.
    fn len(&self) -> usize;
    /// True if there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// When datagram `i` was captured, ns.
    fn time_ns(&self, i: usize) -> i64;
    /// Number of the first datagram at or after `time_ns`.
    fn first_at(&self, time_ns: i64) -> usize {
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = low + (high - low) / 2;
            if self.time_ns(middle) < time_ns {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }
}

impl Timeline for [i64] {
    fn len(&self) -> usize {
        <[i64]>::len(self)
    }
    fn time_ns(&self, i: usize) -> i64 {
        self[i]
    }
}

/// How fast a recording is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// So many millionths of real time: 1 000 000 is as recorded.
    Millionths(u32),
    /// Without waiting.
    AsFastAsPossible,
}

impl Pace {
    /// As recorded.
    pub const REAL_TIME: Self = Self::Millionths(1_000_000);

    /// `rate` times real time, 0.1 to 100.
    ///
    /// # Errors
    /// The rate, if it is outside (or NaN).
    pub fn times(rate: f64) -> Result<Self, BadRate> {
        if (0.1..=100.0).contains(&rate) {
            Ok(Self::Millionths((rate * 1e6).round() as u32))
        } else {
            Err(BadRate(rate))
        }
    }
}

/// A rate that cannot be played.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("rate = {0} is outside 0.1 ..= 100")]
pub struct BadRate(pub f64);

/// What a player does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Stands at its first datagram until [`Player::resume`] (a Start/Resume came).
    Waiting,
    /// Goes on with the wall time.
    Playing,
    /// Stands still.
    Paused,
    /// Has played everything.
    Ended,
}

/// Datagrams due in one call at most, so that commands are heard in between.
const MOST_DUE: usize = 1024;

/// The schedule of one playing.
#[derive(Clone, Debug)]
pub struct Player {
    /// What is played of the recording.
    window: Range<usize>,
    /// The next datagram.
    next: usize,
    /// Wall time and time of the recording that belong together.
    anchor: (i64, i64),
    pace: Pace,
    phase: Phase,
    looping: bool,
    rounds: u64,
}

impl Player {
    /// Plays the datagrams from `from_ns` to `to_ns` (both included; times of the recording). The
    /// window's start is due at `wall_ns`, or when [`Player::resume`] is called if `wait`.
    #[must_use]
    pub fn new(
        timeline: &(impl Timeline + ?Sized),
        from_ns: i64,
        to_ns: i64,
        pace: Pace,
        looping: bool,
        wait: bool,
        wall_ns: i64,
    ) -> Self {
        let start = timeline.first_at(from_ns);
        let end = to_ns.checked_add(1).map_or(timeline.len(), |after| timeline.first_at(after));
        let window = start..end.max(start);
        let phase = match (window.is_empty(), wait) {
            (true, _) => Phase::Ended,
            (_, true) => Phase::Waiting,
            _ => Phase::Playing,
        };
        let anchor_ns = match window.is_empty() {
            true => 0,
            // Before the first datagram there is nothing to wait for.
            false if start == 0 => timeline.time_ns(0),
            false => from_ns,
        };
        Self { next: start, anchor: (wall_ns, anchor_ns), window, pace, phase, looping, rounds: 0 }
    }

    /// What it does.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Number of the next datagram.
    #[must_use]
    pub fn next(&self) -> usize {
        self.next
    }

    /// Numbers of the datagrams that are played.
    #[must_use]
    pub fn window(&self) -> Range<usize> {
        self.window.clone()
    }

    /// How often the window was played to its end.
    #[must_use]
    pub fn rounds(&self) -> u64 {
        self.rounds
    }

    /// The time in the recording that wall time `wall_ns` belongs to.
    #[must_use]
    pub fn position_ns(&self, wall_ns: i64) -> i64 {
        let (wall, position) = self.anchor;
        match (self.phase, self.pace) {
            (Phase::Playing, Pace::Millionths(rate)) => {
                let passed = i128::from(wall_ns) - i128::from(wall);
                let moved = (passed * i128::from(rate)).div_euclid(1_000_000);
                clamped(i128::from(position) + moved)
            }
            _ => position,
        }
    }

    /// The wall time at which time `time_ns` of the recording is due; rounded up.
    fn wall_of(&self, time_ns: i64, rate: u32) -> i64 {
        let (wall, position) = self.anchor;
        let ahead = (i128::from(time_ns) - i128::from(position)) * 1_000_000;
        let rate = i128::from(rate.max(1));
        clamped(i128::from(wall) + ahead.div_euclid(rate) + i128::from(ahead.rem_euclid(rate) != 0))
    }

    /// The datagrams that are due at `wall_ns`, at most 1024 in one call: ask again until it is empty.
    /// They count as sent.
    pub fn due(&mut self, timeline: &(impl Timeline + ?Sized), wall_ns: i64) -> Range<usize> {
        let start = self.next;
        if self.phase != Phase::Playing {
            return start..start;
        }
        let limit = self.window.end.min(start + MOST_DUE);
        let end = match self.pace {
            Pace::AsFastAsPossible => limit,
            Pace::Millionths(_) => {
                let position = self.position_ns(wall_ns);
                let mut end = start;
                while end < limit && timeline.time_ns(end) <= position {
                    end += 1;
                }
                end
            }
        };
        self.next = end;
        if self.pace == Pace::AsFastAsPossible && end > start {
            self.anchor = (wall_ns, timeline.time_ns(end - 1));
        }
        if end == self.window.end {
            self.turn(timeline, wall_ns);
        }
        start..end
    }

    /// At the end of the window: the next round starts when the last datagram was due, whenever it was
    /// asked for, so rounds do not drift either.
    fn turn(&mut self, timeline: &(impl Timeline + ?Sized), wall_ns: i64) {
        self.rounds += 1;
        if !self.looping {
            self.anchor = (wall_ns, timeline.time_ns(self.window.end - 1));
            self.phase = Phase::Ended;
            return;
        }
        let last_ns = timeline.time_ns(self.window.end - 1);
        let wall = match self.pace {
            Pace::Millionths(rate) => self.wall_of(last_ns, rate),
            Pace::AsFastAsPossible => wall_ns,
        };
        self.next = self.window.start;
        self.anchor = (wall, timeline.time_ns(self.window.start));
    }

    /// When to call [`Player::due`] again; `None` if nothing will be due before a command.
    #[must_use]
    pub fn wake_at(&self, timeline: &(impl Timeline + ?Sized)) -> Option<i64> {
        if self.phase != Phase::Playing {
            return None;
        }
        match self.pace {
            Pace::AsFastAsPossible => Some(self.anchor.0),
            Pace::Millionths(rate) => Some(self.wall_of(timeline.time_ns(self.next), rate)),
        }
    }

    /// Stands still.
    pub fn pause(&mut self, wall_ns: i64) {
        if self.phase == Phase::Playing {
            self.anchor = (wall_ns, self.position_ns(wall_ns));
            self.phase = Phase::Paused;
        }
    }

    /// Goes on from where it stands.
    pub fn resume(&mut self, wall_ns: i64) {
        if matches!(self.phase, Phase::Waiting | Phase::Paused) {
            self.anchor.0 = wall_ns;
            self.phase = Phase::Playing;
        }
    }

    /// Changes the pace from now on.
    pub fn set_pace(&mut self, pace: Pace, wall_ns: i64) {
        self.anchor = (wall_ns, self.position_ns(wall_ns));
        self.pace = pace;
    }

    /// Goes to `time_ns` of the recording (the nearest time of the window). The caller then sends the
    /// states that hold there, see [`crate::Recording::alive_at`]. Keeps playing or standing; what has
    /// ended stands.
    pub fn seek(&mut self, timeline: &(impl Timeline + ?Sized), time_ns: i64, wall_ns: i64) {
        if self.window.is_empty() {
            return;
        }
        let last_ns = timeline.time_ns(self.window.end - 1);
        let time_ns = time_ns.clamp(timeline.time_ns(self.window.start), last_ns);
        self.next = timeline.first_at(time_ns).clamp(self.window.start, self.window.end - 1);
        self.anchor = (wall_ns, time_ns);
        if self.phase == Phase::Ended {
            self.phase = Phase::Paused;
        }
    }

    /// One datagram forward while standing: its number, to be sent now; `None` at the end.
    pub fn step(&mut self, timeline: &(impl Timeline + ?Sized), wall_ns: i64) -> Option<usize> {
        self.pause(wall_ns);
        let number = self.next;
        if number >= self.window.end {
            return None;
        }
        self.next += 1;
        self.anchor = (wall_ns, timeline.time_ns(number));
        if self.next == self.window.end {
            self.phase = Phase::Ended;
        }
        Some(number)
    }

    /// One datagram back while standing: gives the time to which the states have to be set (as for
    /// [`Player::seek`]); the datagram is the next one again. `None` at the start.
    pub fn step_back(&mut self, timeline: &(impl Timeline + ?Sized), wall_ns: i64) -> Option<i64> {
        self.pause(wall_ns);
        if self.next <= self.window.start {
            return None;
        }
        self.next -= 1;
        let time_ns = timeline.time_ns(self.next);
        self.anchor = (wall_ns, time_ns);
        if self.phase == Phase::Ended {
            self.phase = Phase::Paused;
        }
        Some(time_ns)
    }
}

fn clamped(ns: i128) -> i64 {
    ns.clamp(i64::MIN.into(), i64::MAX.into()) as i64
}

#[cfg(test)]
mod tests;
