//! Uniform cubic B-splines: twice continuously differentiable, constant time to evaluate.
//!
//! Source: de Boor, A Practical Guide to Splines (2001), ch. IX and X. The derivative of a B-spline
//! is a B-spline of the differences of its controls, so limits on differences of neighbouring
//! controls are limits on the derivative everywhere (convex hull property).

/// A function of one variable with `N` components.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline<const N: usize> {
    start: f64,
    step: f64,
    controls: Vec<[f64; N]>,
}

/// Value and derivatives at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<const N: usize> {
    /// Value.
    pub value: [f64; N],
    /// First derivative.
    pub first: [f64; N],
    /// Second derivative.
    pub second: [f64; N],
    /// Third derivative: constant between knots.
    pub third: [f64; N],
}

impl<const N: usize> Spline<N> {
    /// The spline with these controls on `start ..= start + step · (controls − 3)`, or `None` with
    /// fewer than four controls, a step that is not positive, or a control that is not finite.
    #[must_use]
    pub fn new(start: f64, step: f64, controls: Vec<[f64; N]>) -> Option<Self> {
        let finite = controls.iter().flatten().all(|c| c.is_finite()) && start.is_finite();
        (controls.len() >= 4 && step > 0.0 && finite).then_some(Self { start, step, controls })
    }

    /// First place of the domain.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Last place of the domain.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.start + self.step * (self.controls.len() - 3) as f64
    }

    /// Distance of the knots.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The controls.
    #[must_use]
    pub fn controls(&self) -> &[[f64; N]] {
        &self.controls
    }

    /// Piece and place within it, 0 to 1, of `x` brought into the domain.
    fn locate(&self, x: f64) -> (usize, f64) {
        let pieces = self.controls.len() - 3;
        let place = ((x - self.start) / self.step).clamp(0.0, pieces as f64);
        let piece = (place as usize).min(pieces - 1);
        (piece, place - piece as f64)
    }

    /// Up to where the value stays exactly what it is at `x`: `x` itself where it changes, infinity where it stays for ever.
    #[must_use]
    pub fn rests_until(&self, x: f64) -> f64 {
        let (piece, _) = self.locate(x);
        let here = self.controls[piece];
        let changes = self.controls[piece..].iter().position(|c| *c != here);
        match changes {
            None => f64::INFINITY,
            // A piece depends on four controls; up to its begin nothing changes.
            Some(at) if at >= 4 => self.start + self.step * (piece + at - 3) as f64,
            Some(_) => x,
        }
    }

    /// Value and derivatives at `x`; outside the domain those of its nearer end.
    ///
    /// Written in differences of controls, so equal controls give exactly that value and exactly
    /// zero derivatives.
    #[must_use]
    pub fn at(&self, x: f64) -> Jet<N> {
        let (piece, t) = self.locate(x);
        let c: [[f64; N]; 4] = std::array::from_fn(|i| self.controls[piece + i]);
        let s = 1.0 - t;
        let (b0, b3) = (s * s * s / 6.0, t * t * t / 6.0);
        let b2 = (1.0 + 3.0 * t + 3.0 * t * t - 3.0 * t * t * t) / 6.0;
        let (d0, d2) = (0.5 * s * s, 0.5 * t * t);
        let d1 = 0.5 + t - t * t;
        let per = 1.0 / self.step;
        let component = |i: usize| {
            let (e0, e1, e2) = (c[1][i] - c[0][i], c[2][i] - c[1][i], c[3][i] - c[2][i]);
            let (f0, f1) = (e1 - e0, e2 - e1);
            [
                c[1][i] + (b2 * e1 - b0 * e0 + b3 * (e1 + e2)),
                (d0 * e0 + d1 * e1 + d2 * e2) * per,
                (s * f0 + t * f1) * per * per,
                (f1 - f0) * per * per * per,
            ]
        };
        let all: [[f64; 4]; N] = std::array::from_fn(component);
        Jet {
            value: all.map(|d| d[0]),
            first: all.map(|d| d[1]),
            second: all.map(|d| d[2]),
            third: all.map(|d| d[3]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_met_exactly() {
        // Controls of x³ on knots at the integers: blossom x(x² − 1) for step 1.
        let controls = (0..10).map(|j| f64::from(j) - 1.0).map(|x| [x * (x * x - 1.0)]).collect();
        let spline = Spline::new(0.0, 1.0, controls).unwrap();
        for x in [0.0, 0.3, 1.0, 2.5, 6.999, 7.0] {
            let jet = spline.at(x);
            assert!((jet.value[0] - x * x * x).abs() < 1e-12, "{x}");
            assert!((jet.first[0] - 3.0 * x * x).abs() < 1e-12, "{x}");
            assert!((jet.second[0] - 6.0 * x).abs() < 1e-12, "{x}");
            assert!((jet.third[0] - 6.0).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn equal_controls_stand_exactly_still() {
        let spline = Spline::new(3.0, 0.7, vec![[0.1, 1e6 / 3.0]; 8]).unwrap();
        for i in 0..100 {
            let jet = spline.at(3.0 + 0.035 * f64::from(i));
            assert_eq!(jet.value, [0.1, 1e6 / 3.0]);
            assert_eq!((jet.first, jet.second), ([0.0; 2], [0.0; 2]));
        }
    }

    #[test]
    fn what_rests_is_exactly_the_same_up_to_where_it_is_said_to_and_moves_behind_that() {
        let controls = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0];
        let spline = Spline::new(2.0, 0.5, controls.map(|c| [c]).to_vec()).unwrap();
        for (x, until) in [(2.0, 3.5), (3.4, 3.5), (1.0, 3.5), (3.6, 3.6), (4.0, 4.0)] {
            assert_eq!(spline.rests_until(x), until, "{x}");
        }
        assert_eq!(spline.rests_until(5.8), f64::INFINITY);
        let (end, begin) = (spline.at(3.5), spline.at(2.0));
        assert_eq!((end.value, end.first, end.second), (begin.value, begin.first, begin.second));
        assert!(spline.at(3.51).value[0] > 1.0);
    }

    #[test]
    fn outside_the_domain_the_ends_hold() {
        let spline = Spline::new(0.0, 1.0, vec![[0.0], [1.0], [4.0], [9.0], [16.0]]).unwrap();
        assert_eq!(spline.at(-5.0), spline.at(0.0));
        assert_eq!(spline.at(9.0), spline.at(2.0));
    }
}
