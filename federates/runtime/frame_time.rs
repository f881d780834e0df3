//! Frames, simulated time, UTC and DIS timestamps: whole numbers only.

use super::messages::Frame;
use models::time::SimTime;
use pdu::{DisTime, NANOS_PER_HOUR};

/// How the frames of a scene lie in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameTime {
    /// UTC of frame 0, ns since 1970.
    pub start_utc_ns: i64,
    /// Length of a frame, ns.
    pub step_ns: i64,
}

impl FrameTime {
    /// Of a scene.
    #[must_use]
    pub fn of(run: &scenarios::Run) -> Self {
        Self { start_utc_ns: run.start_utc_ns, step_ns: run.frame.0 }
    }

    /// Simulated time of a frame.
    #[must_use]
    pub fn time(&self, frame: Frame) -> SimTime {
        SimTime(frame as i64 * self.step_ns)
    }

    /// DIS timestamp of a frame.
    #[must_use]
    pub fn stamp(&self, frame: Frame) -> DisTime {
        DisTime::absolute((self.start_utc_ns + self.time(frame).0).rem_euclid(i64::MAX) as u64)
    }

    /// The frame nearest to `near` whose timestamp is `stamp`, if there is one: a timestamp names a
    /// frame within the hour.
    #[must_use]
    pub fn frame_of(&self, stamp: DisTime, near: Frame) -> Option<Frame> {
        if !stamp.is_absolute() {
            return None;
        }
        let hour = NANOS_PER_HOUR as i64;
        let base = self.start_utc_ns + self.time(near).0;
        let ahead = (stamp.nanos_past_hour() as i64 - base).rem_euclid(hour);
        let offset = if ahead > hour / 2 { ahead - hour } else { ahead };
        let frames = (offset as f64 / self.step_ns as f64).round() as i64;
        // Half a unit of the timestamp is 0.84 µs; a frame's stamp is nearer than that.
        if (frames * self.step_ns - offset).abs() > 1_000 {
            return None;
        }
        u64::try_from(near as i64 + frames).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_of_two_hours_is_named_by_its_stamp() {
        let time = FrameTime { start_utc_ns: 1_574_589_361_000_000_000, step_ns: 50_000_000 };
        for frame in (0..144_000).step_by(7) {
            assert_eq!(time.frame_of(time.stamp(frame), frame.saturating_sub(300)), Some(frame));
        }
        assert_eq!(time.frame_of(DisTime::relative(0), 0), None);
        assert_eq!(time.frame_of(DisTime::absolute(1_574_589_361_000_025_000), 0), None);
    }
}
