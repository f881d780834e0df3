//! Ways of moving that a target switches between, and how it switches.

use super::motion::{Motion, Step};

/// Most modes that a set may have.
pub const MAX_MODES: usize = 4;

/// A refused mode set.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ModesError {
    /// No mode, more than [`MAX_MODES`], or lists of different length.
    #[error("{0} modes: 1 to 4 needed, with as many rows, columns and priors")]
    Count(usize),
    /// Not a probability, or a row that does not sum to 1, or a mode that is always left.
    #[error(
        "row {0} of the mode transition matrix: not probabilities that sum to 1, with 0 < stay ≤ 1"
    )]
    Row(usize),
    /// The priors are not probabilities that sum to 1.
    #[error("mode priors are not probabilities that sum to 1")]
    Prior,
}

/// One to four motion models with the probabilities of switching per second.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    motions: [Motion; MAX_MODES],
    count: usize,
    transition: [[f64; MAX_MODES]; MAX_MODES],
    prior: [f64; MAX_MODES],
    /// ln Π_ii, and for j ≠ i ln(Π_ij / (1 − Π_ii)).
    logs: [[f64; MAX_MODES]; MAX_MODES],
    jump: usize,
}

impl Modes {
    /// `transition[i][j]`: probability that a target in mode i is in mode j one second later.
    ///
    /// # Errors
    /// If the lists do not fit each other or are not probabilities.
    pub fn new(
        motions: &[Motion],
        transition: &[&[f64]],
        prior: &[f64],
    ) -> Result<Self, ModesError> {
        let count = motions.len();
        if count == 0 || count > MAX_MODES || transition.len() != count || prior.len() != count {
            return Err(ModesError::Count(count));
        }
        let sound = |row: &[f64]| {
            row.len() == count
                && row.iter().all(|p| (0.0..=1.0).contains(p))
                && (row.iter().sum::<f64>() - 1.0).abs() < 1e-9
        };
        if !sound(prior) {
            return Err(ModesError::Prior);
        }
        let mut set = Self {
            motions: [motions[0]; MAX_MODES],
            count,
            transition: [[0.0; MAX_MODES]; MAX_MODES],
            prior: [0.0; MAX_MODES],
            logs: [[f64::NEG_INFINITY; MAX_MODES]; MAX_MODES],
            jump: count - 1,
        };
        set.motions[..count].copy_from_slice(motions);
        set.prior[..count].copy_from_slice(prior);
        for (i, row) in transition.iter().enumerate() {
            if !sound(row) || row[i] == 0.0 {
                return Err(ModesError::Row(i));
            }
            set.transition[i][..count].copy_from_slice(row);
            for (j, p) in row.iter().enumerate() {
                let share = if i == j { *p } else { p / (1.0 - row[i]) };
                set.logs[i][j] = if share > 0.0 { libm::log(share) } else { f64::NEG_INFINITY };
            }
        }
        Ok(set)
    }

    /// Steady, accelerating, jumping: constant velocity and acceleration with a quiet noise, and a
    /// constant velocity with so much noise that any manoeuvre of an aircraft fits.
    #[must_use]
    pub fn three() -> Self {
        Self::new(
            &[cv(0.01), ca(0.005), cv(15.0)],
            &[&[0.94, 0.02, 0.04], &[0.02, 0.97, 0.01], &[0.12, 0.02, 0.86]],
            &[0.45, 0.45, 0.1],
        )
        .expect("rows sum to 1")
    }

    /// The same three for a filter that mixes them: what is mixed at every plot is smeared, so they change
    /// more rarely, and the third has to cover more.
    #[must_use]
    pub fn mixed() -> Self {
        Self::new(
            &[cv(0.01), ca(0.02), cv(50.0)],
            &[&[0.98, 0.01, 0.01], &[0.01, 0.98, 0.01], &[0.05, 0.02, 0.93]],
            &[0.45, 0.45, 0.1],
        )
        .expect("rows sum to 1")
    }

    /// The same with a fourth mode for turns that an aircraft can fly.
    #[must_use]
    pub fn four() -> Self {
        Self::new(
            &[cv(0.01), ca(0.001), ca(0.5), cv(100.0)],
            &[
                &[0.93, 0.03, 0.02, 0.02],
                &[0.03, 0.93, 0.02, 0.02],
                &[0.04, 0.06, 0.88, 0.02],
                &[0.10, 0.10, 0.20, 0.60],
            ],
            &[0.4, 0.4, 0.1, 0.1],
        )
        .expect("rows sum to 1")
    }

    /// Number of modes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The last mode: the one for what no other foresees.
    #[must_use]
    pub fn jump(&self) -> usize {
        self.jump
    }

    /// Whether a mode has no acceleration: constant velocity.
    #[inline]
    #[must_use]
    pub fn is_steady(&self, mode: usize) -> bool {
        matches!(self.motions[mode], Motion::ConstantVelocity { .. })
    }

    /// Probability of each mode for a new track.
    #[must_use]
    pub fn prior(&self) -> [f64; MAX_MODES] {
        self.prior
    }

    /// Transition and noise of each mode over `t` seconds.
    #[inline]
    #[must_use]
    pub fn steps(&self, t: f64) -> [Step; MAX_MODES] {
        let mut steps = [Step::constant_velocity(0.0, t); MAX_MODES];
        for (step, motion) in steps.iter_mut().zip(&self.motions[..self.count]) {
            *step = motion.step(t);
        }
        steps
    }

    /// Transition and noise of one mode over `t` seconds.
    #[inline]
    #[must_use]
    pub fn step(&self, mode: usize, t: f64) -> Step {
        self.motions[mode].step(t)
    }

    /// ln Π over `t` seconds: a mode is kept with Π_ii^t, and left to each other one in proportion to Π.
    /// Exact at one second; over no time no mode changes.
    #[must_use]
    pub fn log_transition(&self, t: f64) -> [[f64; MAX_MODES]; MAX_MODES] {
        let mut logs = self.logs;
        for (i, row) in logs.iter_mut().enumerate().take(self.count) {
            let stay = row[i] * t;
            let leave = -libm::expm1(stay);
            let leave = if leave > 0.0 { libm::log(leave) } else { f64::NEG_INFINITY };
            for (j, log) in row.iter_mut().enumerate() {
                *log = if i == j { stay } else { *log + leave };
            }
        }
        logs
    }

    /// Π over `t` seconds, as [`Self::log_transition`].
    #[inline]
    #[must_use]
    pub fn transition(&self, t: f64) -> [[f64; MAX_MODES]; MAX_MODES] {
        if t == 1.0 {
            return self.transition;
        }
        let mut p = self.transition;
        for (i, row) in p.iter_mut().enumerate().take(self.count) {
            let left = 1.0 - row[i];
            let leave = -libm::expm1(self.logs[i][i] * t);
            for (j, p) in row.iter_mut().enumerate() {
                *p = if i == j {
                    1.0 - leave
                } else if left > 0.0 {
                    *p * (leave / left)
                } else {
                    0.0
                };
            }
        }
        p
    }

    /// Raises the probability of jumping to at least one half, the other ways out of a mode in proportion.
    pub fn expect_jump(&self, p: &mut [[f64; MAX_MODES]; MAX_MODES]) {
        let jump = self.jump;
        for row in p.iter_mut().take(self.count) {
            let other = 1.0 - row[jump];
            if row[jump] < JUMP_PRIOR {
                let scale = (1.0 - JUMP_PRIOR) / other;
                row.iter_mut().for_each(|p| *p *= scale);
                row[jump] = JUMP_PRIOR;
            }
        }
    }
}

/// Prior of the jump mode once a plot was accepted by the kinematic gate alone.
const JUMP_PRIOR: f64 = 0.5;

/// Constant velocity, q in m²/s³.
#[must_use]
pub fn cv(q: f64) -> Motion {
    Motion::ConstantVelocity { q }
}

/// Constant acceleration, q in m²/s⁵.
#[must_use]
pub fn ca(q: f64) -> Motion {
    Motion::ConstantAcceleration { q }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transition_matrices_are_probabilities_for_every_interval() {
        for modes in [Modes::three(), Modes::mixed(), Modes::four()] {
            for t in [0.0, 1e-9, 0.1, 1.0, 7.0, 3600.0] {
                let (p, logs) = (modes.transition(t), modes.log_transition(t));
                for i in 0..modes.count() {
                    let sum: f64 = p[i].iter().sum();
                    assert!((sum - 1.0).abs() < 1e-12, "{t} {i}");
                    for j in 0..modes.count() {
                        assert!((libm::exp(logs[i][j]) - p[i][j]).abs() < 1e-12, "{t} {i} {j}");
                    }
                }
            }
            assert_eq!(modes.transition(0.0)[0][0], 1.0);
        }
    }

    #[test]
    fn a_matrix_that_is_none_is_refused() {
        let two = [cv(1.0), ca(1.0)];
        let refused = |t: &[&[f64]], prior: &[f64]| Modes::new(&two, t, prior).unwrap_err();
        assert_eq!(refused(&[&[0.9, 0.2], &[0.1, 0.9]], &[0.5, 0.5]), ModesError::Row(0));
        assert_eq!(refused(&[&[0.9, 0.1], &[1.0, 0.0]], &[0.5, 0.5]), ModesError::Row(1));
        assert_eq!(refused(&[&[0.9, 0.1], &[0.1, 0.9]], &[0.5, 0.6]), ModesError::Prior);
        assert_eq!(refused(&[&[1.0, 0.0]], &[0.5, 0.5]), ModesError::Count(2));
    }
}
