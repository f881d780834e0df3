//! The geometry of a position from times of arrival, and what timing makes of it.

use crate::frames::{Point2, Vector2};

/// Speed of light, m/s.
pub(super) const SPEED_OF_LIGHT_MPS: f64 = 299_792_458.0;

/// Geometry of a position from times of arrival: (HᵀH)⁻¹ in the order east, north, time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrivalGeometry {
    /// Q = (HᵀH)⁻¹.
    pub q: [[f64; 3]; 3],
}

impl ArrivalGeometry {
    /// Geometry of a target at `target_m` heard by `stations_m`; `None` with fewer than three stations
    /// or where they do not span position and time (a pivot below 1e-9).
    #[must_use]
    pub fn of(stations_m: &[Point2<f64>], target_m: Point2<f64>) -> Option<Self> {
        if stations_m.len() < 3 {
            return None;
        }
        let mut a = [[0.0; 3]; 3];
        for station_m in stations_m {
            let row = row(*station_m, target_m);
            for (r, line) in a.iter_mut().enumerate() {
                for (c, value) in line.iter_mut().enumerate() {
                    *value += row[r] * row[c];
                }
            }
        }
        // Cholesky, pivot by pivot.
        let l00 = pivot(a[0][0])?;
        let (l10, l20) = (a[1][0] / l00, a[2][0] / l00);
        let l11 = pivot(a[1][1] - l10 * l10)?;
        let l21 = (a[2][1] - l20 * l10) / l11;
        let l22 = pivot(a[2][2] - l20 * l20 - l21 * l21)?;
        let (m00, m11, m22) = (1.0 / l00, 1.0 / l11, 1.0 / l22);
        let m10 = -l10 * m00 * m11;
        let m21 = -l21 * m11 * m22;
        let m20 = -(l20 * m00 + l21 * m10) * m22;
        let (q01, q02, q12) = (m10 * m11 + m20 * m21, m20 * m22, m21 * m22);
        Some(Self {
            q: [
                [m00 * m00 + m10 * m10 + m20 * m20, q01, q02],
                [q01, m11 * m11 + m21 * m21, q12],
                [q02, q12, m22 * m22],
            ],
        })
    }

    /// Horizontal dilution: deviation of the position per deviation of one range.
    #[must_use]
    pub fn horizontal(&self) -> f64 {
        (self.q[0][0] + self.q[1][1]).sqrt()
    }

    /// Variance east, covariance, variance north in m² for timing errors of `sigma_t_s`.
    #[must_use]
    pub fn covariance_m2(&self, sigma_t_s: f64) -> [f64; 3] {
        let variance = (SPEED_OF_LIGHT_MPS * sigma_t_s) * (SPEED_OF_LIGHT_MPS * sigma_t_s);
        [self.q[0][0] * variance, self.q[0][1] * variance, self.q[1][1] * variance]
    }

    /// What the fit leaves of range errors, m²: the sum of the squared residuals of the ranges by least squares.
    pub(super) fn residual_m2(
        &self,
        stations_m: &[Point2<f64>],
        target_m: Point2<f64>,
        errors_m: &[f64],
    ) -> f64 {
        let rows: Vec<[f64; 3]> = stations_m.iter().map(|s| row(*s, target_m)).collect();
        let mut sums = [0.0; 3];
        for (h, error) in rows.iter().zip(errors_m) {
            (0..3).for_each(|k| sums[k] += h[k] * error);
        }
        let fit = self.q.map(|q| q[0] * sums[0] + q[1] * sums[1] + q[2] * sums[2]);
        let left = |h: &[f64; 3], e: &f64| e - h[0] * fit[0] - h[1] * fit[1] - h[2] * fit[2];
        rows.iter().zip(errors_m).map(|(h, e)| left(h, e)).map(|r| r * r).sum()
    }

    /// Shift of the position (m east, north) per metre of range error at one station.
    pub(super) fn shift(&self, station_m: Point2<f64>, target_m: Point2<f64>) -> Vector2<f64> {
        let h = row(station_m, target_m);
        let of = |r: usize| self.q[r][0] * h[0] + self.q[r][1] * h[1] + self.q[r][2] * h[2];
        Vector2::new(of(0), of(1))
    }
}

/// (u_x, u_y, 1); a target on top of a station has no direction from it.
fn row(station_m: Point2<f64>, target_m: Point2<f64>) -> [f64; 3] {
    let d = target_m - station_m;
    let far = libm::hypot(d.x, d.y);
    if far > 0.0 { [d.x / far, d.y / far, 1.0] } else { [0.0, 0.0, 1.0] }
}

fn pivot(rest: f64) -> Option<f64> {
    (rest >= 1e-9).then(|| rest.sqrt())
}
