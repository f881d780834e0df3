//! Antenna patterns and what of the beam the rain fills.

use std::f64::consts::{LN_2, PI};

/// The two-dimensional one-way power pattern of a rotating surface radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    /// Azimuth beamwidth at half power, rad.
    pub azimuth_rad: f64,
    /// Elevation beamwidth at half power, rad.
    pub elevation_rad: f64,
    /// Depression of the beam axis, rad.
    pub axis_rad: f64,
    /// Lower edge of the cosecant-squared coverage, rad of depression; `None` without a skirt.
    pub skirt_end_rad: Option<f64>,
    /// Side lobe floor, power ratio.
    pub floor: f64,
}

impl Pattern {
    /// Depression where the skirt takes over from the beam: half power below the axis.
    #[must_use]
    pub fn skirt_start_rad(&self) -> f64 {
        self.axis_rad + 0.5 * self.elevation_rad
    }

    /// The end of the skirt, if there is one. A beam tilted up so far that its lower edge is above
    /// 0.05° of depression has none.
    fn skirt(&self) -> Option<(f64, f64)> {
        let start = self.skirt_start_rad();
        let end = self.skirt_end_rad?;
        (start >= 0.05f64.to_radians() && end > start).then_some((start, end))
    }

    /// Whether there is a cosecant-squared coverage below the beam.
    #[must_use]
    pub fn has_skirt(&self) -> bool {
        self.skirt().is_some()
    }

    /// Gain of an antenna of this pattern without losses, `4π/∬ g dΩ`, side lobes left out: no real one
    /// has more.
    #[must_use]
    pub fn directivity(&self) -> f64 {
        let clear = Self { floor: 0.0, ..*self };
        let (down, up) = (0.5 * PI, -0.5 * PI);
        let mut cuts = vec![up, down, self.axis_rad - 3.0 * self.elevation_rad, self.axis_rad];
        cuts.push(self.axis_rad + 3.0 * self.elevation_rad);
        cuts.extend(self.skirt().map_or(vec![], |(start, end)| vec![start, end]));
        cuts.iter_mut().for_each(|cut| *cut = cut.clamp(up, down));
        cuts.sort_by(f64::total_cmp);
        let f = |e: f64| clear.elevation(e) * libm::cos(e);
        let elevation: f64 = cuts.windows(2).map(|w| simpson(w[0], w[1], 64, f)).sum();
        let azimuth = (self.azimuth_rad * (PI / (4.0 * LN_2)).sqrt()).min(2.0 * PI);
        4.0 * PI / (elevation * azimuth)
    }

    fn beam(&self, off_axis_rad: f64) -> f64 {
        let x = off_axis_rad / self.elevation_rad;
        libm::exp(-4.0 * LN_2 * x * x)
    }

    /// One-way power at a depression, positive downwards.
    ///
    /// A Gaussian beam down to half power below its axis, then a cosecant-squared skirt, then the
    /// beam's flank again; continuous everywhere, never below the side lobe floor.
    #[must_use]
    pub fn elevation(&self, depression_rad: f64) -> f64 {
        let g = match self.skirt() {
            Some((start, end)) if depression_rad > start => {
                let reached = depression_rad.min(end);
                let ratio = libm::sin(start) / libm::sin(reached);
                let skirt = 0.5 * ratio * ratio;
                if depression_rad > end { skirt * self.beam(depression_rad - end) } else { skirt }
            }
            _ => self.beam(depression_rad - self.axis_rad),
        };
        g.max(self.floor)
    }

    /// The elevation pattern prepared for sines of the depression.
    #[must_use]
    pub fn by_sine(&self) -> SinePattern {
        let edges = self.skirt().map(|(start, end)| (libm::sin(start), end, libm::sin(end)));
        SinePattern { pattern: *self, edges }
    }

    /// One-way power at an azimuth off the beam axis.
    #[must_use]
    pub fn azimuth(&self, off_axis_rad: f64) -> f64 {
        let x = crate::frames::wrap_pi(off_axis_rad) / self.azimuth_rad;
        libm::exp(-4.0 * LN_2 * x * x).max(self.floor)
    }

    /// Two-way equivalent width of the azimuth beam, rad: `θ_a·√(π/(8 ln 2))`.
    #[must_use]
    pub fn two_way_azimuth_rad(&self) -> f64 {
        self.azimuth_rad * (PI / (8.0 * LN_2)).sqrt()
    }

    /// `∫ g_e² dε` over the part of the beam above ground and below the rain top, rad.
    ///
    /// Closed form: two error functions for the beam, the skirt exactly; side lobe floor left out.
    #[must_use]
    pub fn rain_integral(&self, range_m: f64, antenna_m: f64, rain_top_m: f64) -> f64 {
        let ground = libm::asin((antenna_m / range_m).min(1.0));
        let top = -libm::asin(((rain_top_m - antenna_m) / range_m).min(1.0));
        let a = (8.0 * LN_2).sqrt() / self.elevation_rad;
        let skirt = self.skirt();
        let lower = skirt.map_or(ground, |(start, _)| ground.min(start));
        let width = 0.5 * self.elevation_rad * (PI / (8.0 * LN_2)).sqrt();
        let beam =
            width * (libm::erf(a * (lower - self.axis_rad)) - libm::erf(a * (top - self.axis_rad)));
        match skirt {
            Some((start, end)) if ground > start => {
                let ratio = libm::sin(start) / libm::sin(ground.min(end));
                beam + libm::sin(start) / 12.0 * (1.0 - ratio * ratio * ratio)
            }
            _ => beam,
        }
    }

    /// The same by quadrature of the pattern itself, `cos ε` and side lobe floor included: the exact level.
    #[must_use]
    pub fn rain_integral_exact(&self, range_m: f64, antenna_m: f64, rain_top_m: f64) -> f64 {
        let ground = libm::asin((antenna_m / range_m).min(1.0));
        let top = -libm::asin(((rain_top_m - antenna_m) / range_m).min(1.0));
        let mut cuts = vec![top, self.axis_rad - 3.0 * self.elevation_rad, self.axis_rad];
        cuts.push(self.skirt_start_rad());
        cuts.extend(self.skirt_end_rad);
        cuts.push(ground);
        cuts.iter_mut().for_each(|cut| *cut = cut.clamp(top, ground));
        cuts.sort_by(f64::total_cmp);
        let f = |e: f64| {
            let g = self.elevation(e);
            g * g * libm::cos(e)
        };
        cuts.windows(2).map(|w| simpson(w[0], w[1], 32, f)).sum()
    }

    /// The integral without ground and without rain top: an upper bound for every range.
    #[must_use]
    pub fn rain_integral_bound(&self) -> f64 {
        let beam = self.elevation_rad * (PI / (8.0 * LN_2)).sqrt();
        beam + self.skirt().map_or(0.0, |(start, _)| libm::sin(start) / 12.0)
    }
}

/// An elevation pattern by the sine of the depression: no angle is needed on the skirt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinePattern {
    pattern: Pattern,
    /// Of the skirt: sine of its start, its end in radians, sine of its end.
    edges: Option<(f64, f64, f64)>,
}

impl SinePattern {
    /// [`Pattern::elevation`] at the depression of this sine.
    #[must_use]
    pub fn elevation(&self, sin_depression: f64) -> f64 {
        let pattern = &self.pattern;
        let g = match self.edges {
            Some((start, _, end)) if sin_depression > start && sin_depression <= end => {
                let ratio = start / sin_depression;
                0.5 * ratio * ratio
            }
            Some((start, end_rad, end)) if sin_depression > end => {
                let ratio = start / end;
                0.5 * ratio * ratio * pattern.beam(libm::asin(sin_depression) - end_rad)
            }
            _ => pattern.beam(libm::asin(sin_depression) - pattern.axis_rad),
        };
        g.max(pattern.floor)
    }

    /// Least and largest slope of the logarithm of [`Self::elevation`] by the sine, anywhere between two
    /// sines: each part of the pattern at its ends, for there it grows or falls throughout.
    #[must_use]
    pub fn log_slope(&self, low: f64, high: f64) -> (f64, f64) {
        let pattern = &self.pattern;
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut add = |slope: f64| (least, most) = (least.min(slope), most.max(slope));
        let sharp = 8.0 * LN_2 / (pattern.elevation_rad * pattern.elevation_rad);
        // A flank of the beam about `about`, as far as it is above the floor.
        let mut flank = |from: f64, to: f64, about: f64, top: f64| {
            let reach = (2.0 * libm::log((top / pattern.floor).max(1.0)) / sharp).sqrt();
            let (from, to) = (from.max(about - reach), to.min(about + reach));
            if from < to {
                for angle in [from, to] {
                    add(-sharp * (angle - about) / libm::cos(angle).max(1e-6));
                }
            }
        };
        let (from, to) = (libm::asin(low.clamp(-1.0, 1.0)), libm::asin(high.clamp(-1.0, 1.0)));
        match self.edges {
            None => flank(from, to, pattern.axis_rad, 1.0),
            Some((start, end_rad, end)) => {
                flank(from, to.min(libm::asin(start)), pattern.axis_rad, 1.0);
                let ratio = start / end;
                flank(from.max(end_rad), to, end_rad, 0.5 * ratio * ratio);
                let (a, b) = (low.max(start), high.min(end));
                if a < b {
                    add(-2.0 / a);
                    add(-2.0 / b);
                }
            }
        }
        if least > most || self.elevation(low).min(self.elevation(high)) <= pattern.floor {
            (least, most) = (least.min(0.0), most.max(0.0));
        }
        (least, most)
    }
}

fn simpson(from: f64, to: f64, steps: u32, f: impl Fn(f64) -> f64) -> f64 {
    if to <= from {
        return 0.0;
    }
    let h = (to - from) / f64::from(2 * steps);
    let mut sum = f(from) + f(to);
    for i in 1..2 * steps {
        sum += f(from + h * f64::from(i)) * if i % 2 == 1 { 4.0 } else { 2.0 };
    }
    sum * h / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ku() -> Pattern {
        Pattern {
            azimuth_rad: 0.25f64.to_radians(),
            elevation_rad: 1.6f64.to_radians(),
            axis_rad: 1f64.to_radians(),
            skirt_end_rad: Some(31f64.to_radians()),
            floor: 1e-3,
        }
    }

    #[test]
    fn no_step_at_any_edge_of_the_beam() {
        for pattern in [ku(), Pattern { skirt_end_rad: None, ..ku() }] {
            for edge_deg in [1.0, 1.8, 31.0, 31.0 + 1.6, -2.0] {
                let edge = f64::to_radians(edge_deg);
                let (a, b) = (pattern.elevation(edge - 1e-9), pattern.elevation(edge + 1e-9));
                assert!((a - b).abs() < 1e-6 * a, "{edge_deg}: {a:e} {b:e}");
            }
        }
    }

    #[test]
    fn by_the_sine_it_is_the_same_pattern() {
        for pattern in [ku(), Pattern { skirt_end_rad: None, ..ku() }] {
            let by_sine = pattern.by_sine();
            for i in -900..=900 {
                let depression = (f64::from(i) * 0.1 + 0.013).min(90.0).to_radians();
                let (a, b) =
                    (pattern.elevation(depression), by_sine.elevation(libm::sin(depression)));
                assert!((a - b).abs() < 1e-11 * a, "{i}: {a} {b}");
            }
        }
    }

    #[test]
    fn no_slope_is_beyond_what_the_ends_say() {
        for pattern in [ku(), Pattern { skirt_end_rad: None, floor: 1e-2, ..ku() }] {
            let by_sine = pattern.by_sine();
            for i in -400..400 {
                let (low, high) = (f64::from(i) * 0.0025, f64::from(i + 7) * 0.0025);
                let (low, high) = (low.clamp(-0.99, 0.99), high.clamp(-0.98, 0.999));
                let (least, most) = by_sine.log_slope(low, high);
                let (mut found, mut above) = ((f64::INFINITY, f64::NEG_INFINITY), true);
                for k in 0..=200 {
                    let at = low + (high - low) * f64::from(k) / 200.0;
                    let h = 1e-7 * (1.0 - at.abs());
                    let ln = |s: f64| libm::log(by_sine.elevation(s));
                    let slope = (ln(at + h) - ln(at - h)) / (2.0 * h);
                    let margin = 1e-5 * (1.0 + slope.abs());
                    assert!(slope >= least - margin && slope <= most + margin, "{at}: {slope}");
                    found = (found.0.min(slope), found.1.max(slope));
                    above &= by_sine.elevation(at) > pattern.floor;
                }
                // And off the floor no bound is farther off than the slopes are.
                let near = 0.03 * (1.0 + least.abs() + most.abs());
                let tight = least >= found.0 - near && most <= found.1 + near;
                assert!(tight || !above, "{low} to {high}: {least} {most}, found {found:?}");
            }
        }
    }

    #[test]
    fn a_beam_tilted_up_has_no_skirt() {
        let up = Pattern { axis_rad: -2f64.to_radians(), ..ku() };
        assert!(up.elevation(0.1).is_finite() && up.elevation(0.1) <= 1.0);
        assert_eq!(up.elevation(0.3), up.floor);
    }

    #[test]
    fn the_closed_rain_integral_is_near_the_quadrature() {
        for range in [30.0, 60.0, 400.0, 1500.0, 5500.0] {
            let closed = ku().rain_integral(range, 60.0, 3000.0);
            let exact = ku().rain_integral_exact(range, 60.0, 3000.0);
            let db = 10.0 * libm::log10(closed / exact);
            assert!(db.abs() < 0.02, "{range}: {db} dB");
            assert!(closed <= ku().rain_integral_bound() * (1.0 + 1e-12));
        }
    }
}
