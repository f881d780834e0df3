//! The off-line reference: every state from all plots, earlier and later ones.
//!
//! Modified Bryson–Frazier form of the fixed-interval smoother: backwards over the filter's own
//! innovations, without the inverse of a predicted covariance that the form of Rauch, Tung and Striebel
//! needs. Source: Bierman, Automatica 9 (1973); both agree to rounding.

use super::gaussian::Gaussian;
use super::lanes::Pair;
use super::motion::Motion;
use super::three_state::start_position;
use super::{Estimate, Start, UpdateError, interval};
use crate::plot::Plot;
use nalgebra::{SMatrix, SVector};

type Vec6 = SVector<f64, 6>;
type Mat6 = SMatrix<f64, 6, 6>;

/// One scalar measurement as the filter took it.
struct Taken {
    h: Vec6,
    gain: Vec6,
    nu: f64,
    s: f64,
}

/// The states at the times of `plots` (in order of time), each as known after the last of them.
///
/// # Errors
/// If there is no plot, one is unsound or out of order, or an innovation covariance not positive.
pub fn smooth(plots: &[Plot], motion: Motion, start: Start) -> Result<Vec<Estimate>, UpdateError> {
    let first = plots.first().ok_or(UpdateError::UnsoundPlot)?;
    let (z, r) = start_position(first)?;
    let mut state = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
    let mut filtered = vec![Estimate::new(first.time, state)];
    let mut taken: Vec<Vec<Taken>> = vec![Vec::new()];
    for pair in plots.windows(2) {
        let t = interval(pair[0].time, pair[1].time)?;
        state = state.predicted(&motion.step(t));
        taken.push(take(&mut state, &pair[1])?);
        filtered.push(Estimate::new(pair[1].time, state));
    }
    let (mut lambda, mut big) = (Vec6::zeros(), Mat6::zeros());
    let mut out = vec![filtered[filtered.len() - 1]];
    for k in (1..filtered.len()).rev() {
        for m in taken[k].iter().rev() {
            let c = Mat6::identity() - m.gain * m.h.transpose();
            lambda = c.transpose() * lambda - m.h * (m.nu / m.s);
            big = c.transpose() * big * c + m.h * m.h.transpose() / m.s;
        }
        let t = interval(filtered[k - 1].time, filtered[k].time)?;
        let phi = transition(&motion.step(t));
        lambda = phi.transpose() * lambda;
        big = phi.transpose() * big * phi;
        let at = &filtered[k - 1];
        let p = at.state.covariance();
        out.push(Estimate::new(
            at.time,
            gaussian(&(vector(&at.state) - p * lambda), &(p - p * big * p)),
        ));
    }
    out.reverse();
    Ok(out)
}

/// Takes a plot along its two axes and keeps what the way back needs.
fn take(state: &mut Gaussian, plot: &Plot) -> Result<Vec<Taken>, UpdateError> {
    super::Measurement::of(plot)?;
    let (mut x, mut p) = (vector(state), state.covariance());
    let mut taken = Vec::with_capacity(2);
    for (axis, variance) in [(plot.axis, plot.along_m2), (plot.across_axis(), plot.across_m2)] {
        if variance == f64::INFINITY {
            continue;
        }
        let mut h = Vec6::zeros();
        (h[0], h[3]) = (axis.x, axis.y);
        let column = p * h;
        let s = h.dot(&column) + variance;
        if !(s > 0.0 && s < f64::INFINITY) {
            return Err(UpdateError::BadInnovation(s));
        }
        let gain = column / s;
        let nu = axis.dot(&plot.position_m.coords) - h.dot(&x);
        x += gain * nu;
        p -= gain * column.transpose();
        p = 0.5 * (p + p.transpose());
        taken.push(Taken { h, gain, nu, s });
    }
    *state = gaussian(&x, &p);
    Ok(taken)
}

fn transition(step: &super::motion::Step) -> Mat6 {
    let mut phi = Mat6::identity();
    for b in [0, 3] {
        (phi[(b, b + 1)], phi[(b, b + 2)]) = (step.t, step.f02);
        (phi[(b + 1, b + 2)], phi[(b + 2, b + 2)]) = (step.f12, step.f22);
    }
    phi
}

fn vector(g: &Gaussian) -> Vec6 {
    Vec6::from_fn(|i, _| g.x[i % 3].array()[i / 3])
}

fn gaussian(x: &Vec6, p: &Mat6) -> Gaussian {
    Gaussian {
        x: std::array::from_fn(|i| Pair::new(x[i], x[i + 3])),
        p: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
            .map(|(i, j)| Pair::new(p[(i, j)], p[(i + 3, j + 3)])),
        cross: std::array::from_fn(|k| p[(k / 3, 3 + k % 3)]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::testing::{random_plots, track_of};

    /// Rauch, Tung and Striebel, with the inverse.
    fn rauch(plots: &[Plot], motion: Motion, start: Start) -> Vec<Estimate> {
        let forward = track_of(plots, motion, start);
        let mut out = vec![forward[forward.len() - 1]];
        for k in (0..forward.len() - 1).rev() {
            let phi = transition(&motion.step(plots[k + 1].time.since_s(plots[k].time)));
            let (x, p) = (vector(&forward[k].state), forward[k].state.covariance());
            let predicted =
                forward[k].state.predicted(&motion.step(plots[k + 1].time.since_s(plots[k].time)));
            let g = p * phi.transpose() * predicted.covariance().try_inverse().unwrap();
            let later = out[out.len() - 1];
            let xs = x + g * (vector(&later.state) - vector(&predicted));
            let ps = p + g * (later.state.covariance() - predicted.covariance()) * g.transpose();
            out.push(Estimate::new(forward[k].time, gaussian(&xs, &ps)));
        }
        out.reverse();
        out
    }

    #[test]
    fn both_forms_agree() {
        let motion = Motion::ConstantAcceleration { q: 0.5 };
        let plots = random_plots(60, 11);
        let (a, b) = (
            smooth(&plots, motion, Start::default()).unwrap(),
            rauch(&plots, motion, Start::default()),
        );
        for (a, b) in a.iter().zip(&b) {
            assert!((a.position_m() - b.position_m()).norm() < 1e-8);
            let difference = a.state.covariance() - b.state.covariance();
            assert!(difference.amax() < 1e-6 * b.state.covariance().amax());
        }
    }

    /// A loop says nothing across: as good as a plot with next to no weight there.
    #[test]
    fn a_plot_along_one_line_is_smoothed_as_one_that_is_vague_across() {
        let motion = Motion::ConstantAcceleration { q: 0.5 };
        let smoothed = |across_m2: f64| {
            let mut plots = random_plots(30, 7);
            plots.iter_mut().skip(2).step_by(4).for_each(|plot| plot.across_m2 = across_m2);
            smooth(&plots, motion, Start::default()).expect("sound plots")
        };
        for (line, vague) in smoothed(f64::INFINITY).iter().zip(&smoothed(1e11)) {
            assert!((line.position_m() - vague.position_m()).norm() < 1e-4);
            let covariance = vague.state.covariance();
            assert!((line.state.covariance() - covariance).amax() < 1e-4 * covariance.amax());
        }
        assert!(smooth(&[], motion, Start::default()).is_err());
    }

    #[test]
    fn a_model_without_acceleration_is_smoothed_too() {
        // P⁻ is singular here: an inverse would fail.
        let smoothed =
            smooth(&random_plots(40, 3), Motion::ConstantVelocity { q: 1.0 }, Start::default());
        assert!(smoothed.unwrap().iter().all(|e| e.state.is_sound()));
    }
}
