//! What a target looks like to a radar: the places that return its echo, from where each is seen, the
//! flash of a fuselage at broadside. Shapes are data (`target-shapes.toml`); nothing of them is stated here.

use crate::frames::wrap_pi;
use smallvec::SmallVec;
use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, OnceLock};

/// From where a scatterer is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// From everywhere.
    All,
    /// From the direction `from_deg` (0 ahead, clockwise), falling as cos² to 0 at `half_width_deg`.
    Sector {
        /// Direction of the full return, degrees clockwise from ahead.
        from_deg: f64,
        /// Where it has fallen to nothing, degrees.
        half_width_deg: f64,
    },
}

impl View {
    /// Share of the full return seen from `view_rad`, 0 to 1.
    #[must_use]
    pub fn share(self, view_rad: f64) -> f64 {
        match self {
            Self::All => 1.0,
            Self::Sector { from_deg, half_width_deg } => {
                let off = wrap_pi(view_rad - from_deg.to_radians()).abs();
                let half = half_width_deg.to_radians();
                if off >= half {
                    return 0.0;
                }
                let cos = libm::cos(FRAC_PI_2 * off / half);
                cos * cos
            }
        }
    }
}

/// One place on a target that returns part of the echo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Forward of the centre, in lengths.
    pub x: f64,
    /// Right of the centre, in spans or widths.
    pub y: f64,
    /// Share of the median cross section.
    pub weight: f64,
    /// From where it is seen.
    pub view: View,
}

/// A fuselage: it hides what is behind it, and flashes at broadside. Points on its near side share
/// `(base + peak·exp(−½(Δβ/width)²))·|sin β|` of the median cross section.
#[derive(Clone, Debug, PartialEq)]
pub struct Fuselage {
    /// Radius, in lengths.
    pub radius: f64,
    /// Share left of a scatterer behind it.
    pub behind: f64,
    /// Share of the flash at every aspect.
    pub base: f64,
    /// Share at broadside.
    pub peak: f64,
    /// Its width, degrees.
    pub width_deg: f64,
    /// Places of the flash along the fuselage, in lengths.
    pub points: Vec<f64>,
}

/// How a class of targets returns an echo.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Its name.
    pub name: String,
    /// Length and span of a body of its usual proportions, m.
    pub size_m: (f64, f64),
    /// Median cross section of such a body, m².
    pub rcs_m2: f64,
    /// Places that return part of the echo.
    pub scatterers: Vec<Scatterer>,
    /// Of an aircraft.
    pub fuselage: Option<Fuselage>,
    /// How far, dB, the echo of any aspect is below and above the median, at most; both positive.
    pub limits_db: (f64, f64),
    /// Where it comes from.
    pub source: String,
}

/// Most scatterers of a shape.
pub const MOST_SCATTERERS: usize = 32;
/// Most places of a flash.
pub const MOST_POINTS: usize = 16;

/// Aspects over which a shape is tested: every half degree.
const ASPECTS: u32 = 720;
/// Largest difference between left and right that is passed over, dB.
const SIDES_DB: f64 = 1.0;

impl Shape {
    /// One place in the middle that is seen from everywhere.
    #[must_use]
    pub fn point() -> Arc<Self> {
        static POINT: OnceLock<Arc<Shape>> = OnceLock::new();
        let middle = Scatterer { x: 0.0, y: 0.0, weight: 1.0, view: View::All };
        let point = || {
            Arc::new(Self {
                name: "point".into(),
                size_m: (1.0, 1.0),
                rcs_m2: 1.0,
                scatterers: vec![middle],
                fuselage: None,
                limits_db: (0.1, 0.1),
                source: "one place".into(),
            })
        };
        POINT.get_or_init(point).clone()
    }

    /// What is wrong with it: the key, and what is needed there.
    ///
    /// # Errors
    /// A number outside its limits, or an aspect at which the echo leaves `limits_db`.
    pub fn validate(&self) -> Result<(), (&'static str, String)> {
        let within = |key: &'static str, value: f64, low: f64, high: f64| {
            if value >= low && value <= high {
                return Ok(());
            }
            Err((key, format!("{value} is not within {low} to {high}")))
        };
        if self.scatterers.is_empty() || self.scatterers.len() > MOST_SCATTERERS {
            let found = self.scatterers.len();
            return Err(("scatterers", format!("{found} rows; 1 to {MOST_SCATTERERS} are needed")));
        }
        let mut sum = 0.0;
        for (i, s) in self.scatterers.iter().enumerate() {
            let row = |(key, text): (&'static str, String)| (key, format!("row {}: {text}", i + 1));
            within("scatterers", s.x, -0.5, 0.5).map_err(row)?;
            within("scatterers", s.y, -0.5, 0.5).map_err(row)?;
            within("scatterers", s.weight, 1e-6, 1.0).map_err(row)?;
            if let View::Sector { from_deg, half_width_deg } = s.view {
                within("scatterers", from_deg, -360.0, 360.0).map_err(row)?;
                within("scatterers", half_width_deg, 10.0, 180.0).map_err(row)?;
            }
            sum += s.weight;
        }
        within("scatterers", sum, 0.3, 4.0)
            .map_err(|(key, text)| (key, format!("the sum of shares {text}")))?;
        if let Some(f) = &self.fuselage {
            within("fuselage_radius", f.radius, 0.0, 0.5)?;
            within("behind_fuselage", f.behind, 0.0, 1.0)?;
            within("flash", f.base, 0.0, 100.0)?;
            within("flash", f.peak, 0.0, 100.0)?;
            within("flash", f.width_deg, 0.5, 90.0)?;
            if f.points.is_empty() || f.points.len() > MOST_POINTS {
                let found = f.points.len();
                return Err(("flash", format!("{found} points; 1 to {MOST_POINTS} are needed")));
            }
            f.points.iter().try_for_each(|x| within("flash", *x, -0.5, 0.5))?;
        }
        within("length_m", self.size_m.0, 0.1, 200.0)?;
        within("span_m", self.size_m.1, 0.1, 200.0)?;
        within("rcs_m2", self.rcs_m2, 1e-3, 1e5)?;
        within("limits_db", self.limits_db.0, 0.0, 60.0)?;
        within("limits_db", self.limits_db.1, 0.0, 60.0)?;
        for view_deg in self.aspects() {
            let db = self.aspect_db(view_deg);
            let (below, above) = self.limits_db;
            // Limits are written to a tenth of a decibel.
            if !(db >= -below - 0.05 && db <= above + 0.05) {
                let found = if db.is_finite() {
                    format!("{db:.2} dB")
                } else {
                    "nothing is returned".to_owned()
                };
                let text = format!(
                    "at {view_deg:.1} degrees from ahead: {found}, beyond {below} below and {above} above"
                );
                return Err(("limits_db", text));
            }
        }
        Ok(())
    }

    /// Largest difference of the echo between left and right, where it is more than a decibel: dB and the
    /// aspect, degrees.
    #[must_use]
    pub fn lopsided(&self) -> Option<(f64, f64)> {
        let apart = |deg: f64| ((self.aspect_db(deg) - self.aspect_db(-deg)).abs(), deg);
        let all = (0..ASPECTS / 2).map(|i| apart(f64::from(i) * 360.0 / f64::from(ASPECTS)));
        all.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(db, _)| *db > SIDES_DB)
    }

    /// The aspects that are tested: every half degree, and a tenth of one in the flash.
    fn aspects(&self) -> impl Iterator<Item = f64> {
        let whole = (0..ASPECTS).map(|i| f64::from(i) * 360.0 / f64::from(ASPECTS));
        let wide = self.fuselage.as_ref().map_or(0.0, |f| 3.0 * f.width_deg);
        let steps = (20.0 * wide) as u32;
        let flash = (0..=steps).map(move |i| 90.0 - wide + f64::from(i) * 0.1);
        whole.chain(flash)
    }

    /// The echo at an aspect against the median, dB: of a body of its usual proportions.
    fn aspect_db(&self, view_deg: f64) -> f64 {
        let seen = echoes_of(self, self.size_m, 1.0, view_deg.to_radians());
        let sum: f64 = seen.iter().map(|e| e.rcs_m2).sum();
        if sum > 0.0 { 10.0 * libm::log10(sum) } else { f64::NEG_INFINITY }
    }

    /// Whether its left side is the mirror image of its right one.
    #[must_use]
    pub fn is_symmetric(&self) -> bool {
        self.scatterers.iter().all(|a| {
            self.scatterers.iter().any(|b| {
                let view = match (a.view, b.view) {
                    (View::All, View::All) => true,
                    (
                        View::Sector { from_deg: x, half_width_deg: u },
                        View::Sector { from_deg: y, half_width_deg: v },
                    ) => u == v && (x + y).rem_euclid(360.0) == 0.0,
                    _ => false,
                };
                a.x == b.x && a.y == -b.y && a.weight == b.weight && view
            })
        })
    }

    /// The share of the median that the flash adds at an aspect, all points together.
    #[must_use]
    pub fn flash(&self, view_rad: f64, sin: f64) -> f64 {
        self.fuselage.as_ref().map_or(0.0, |f| {
            let off = (wrap_pi(view_rad).abs() - FRAC_PI_2) / f.width_deg.to_radians();
            (f.base + f.peak * libm::exp(-0.5 * off * off)) * sin.abs()
        })
    }
}

/// One echo of a target, in the frame of the line of sight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Echo {
    /// Away from the radar, from the reference point, m.
    pub along_m: f64,
    /// Clockwise in azimuth, from the reference point, m.
    pub across_m: f64,
    /// Mean cross section, m².
    pub rcs_m2: f64,
}

/// The echoes of one target; up to 32 without allocation.
pub type Echoes = SmallVec<[Echo; 32]>;

/// The echoes of a body of a shape, with its length and span and its median cross section.
///
/// Of a scatterer whose line of sight crosses the fuselage a share is left; the points of the flash stand
/// on the near side of the fuselage.
#[must_use]
pub fn echoes_of(
    shape: &Shape,
    (length_m, span_m): (f64, f64),
    median_m2: f64,
    view_rad: f64,
) -> Echoes {
    let (sin, cos) = libm::sincos(view_rad);
    let mut out = Echoes::new();
    let mut add = |x_m: f64, y_m: f64, rcs_m2: f64| {
        if rcs_m2 > 0.0 {
            out.push(Echo {
                along_m: -cos * x_m - sin * y_m,
                across_m: sin * x_m - cos * y_m,
                rcs_m2,
            });
        }
    };
    let (mut last_view, mut last_share) = (View::All, 1.0);
    for scatterer in &shape.scatterers {
        if scatterer.view != last_view {
            (last_view, last_share) = (scatterer.view, scatterer.view.share(view_rad));
        }
        let (x_m, y_m) = (scatterer.x * length_m, scatterer.y * span_m);
        let mut rcs_m2 = scatterer.weight * last_share * median_m2;
        if let Some(fuselage) = &shape.fuselage
            && behind_fuselage(length_m, x_m, y_m, sin, cos)
        {
            rcs_m2 *= fuselage.behind;
        }
        add(x_m, y_m, rcs_m2);
    }
    if let Some(fuselage) = &shape.fuselage {
        let share = shape.flash(view_rad, sin) / fuselage.points.len() as f64;
        let side_m = (fuselage.radius * length_m).min(0.5 * span_m).copysign(sin);
        for x in &fuselage.points {
            add(x * length_m, side_m, share * median_m2);
        }
    }
    out
}

/// Whether the way from (x, y) to the radar crosses the fuselage |x| < L/2, y = 0.
fn behind_fuselage(length_m: f64, x_m: f64, y_m: f64, sin: f64, cos: f64) -> bool {
    if y_m == 0.0 || y_m * sin >= 0.0 {
        return false;
    }
    (x_m - y_m / sin * cos).abs() < 0.5 * length_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::radar::sample_shapes;

    #[test]
    fn a_shape_is_symmetric_if_its_left_side_is_the_mirror_image_of_its_right_one() {
        for aircraft in [true, false] {
            let shape = sample_shapes::of(aircraft);
            assert!(shape.is_symmetric());
            for k in 0..shape.scatterers.len() {
                let with = |change: fn(&mut Scatterer)| {
                    let mut shape = (*shape).clone();
                    change(&mut shape.scatterers[k]);
                    shape.is_symmetric()
                };
                assert!(!with(|s| s.y += 0.01), "{k}: beside");
                let View::Sector { from_deg, .. } = shape.scatterers[k].view else { continue };
                let twisted = with(|s| {
                    let View::Sector { from_deg, .. } = &mut s.view else { return };
                    *from_deg += 5.0;
                });
                assert!(!twisted, "{k}: from {from_deg}");
            }
        }
        // What one of a pair has more of, and what is seen from one side only.
        let shape = sample_shapes::of(true);
        let pair = shape.scatterers.iter().position(|s| s.y != 0.0).expect("a pair");
        for change in [
            |s: &mut Scatterer| s.weight *= 1.1,
            |s: &mut Scatterer| s.x += 0.1,
            |s: &mut Scatterer| s.view = View::Sector { from_deg: 0.0, half_width_deg: 10.0 },
        ] {
            let mut shape = (*shape).clone();
            change(&mut shape.scatterers[pair]);
            assert!(!shape.is_symmetric());
        }
    }

    /// What is a little beyond a limit is refused by its key, what is at it is not.
    #[test]
    fn numbers_of_a_shape_are_refused_beyond_their_limits() {
        type Set = fn(&mut Shape, f64);
        fn fuselage(shape: &mut Shape) -> &mut Fuselage {
            shape.fuselage.as_mut().expect("an aircraft")
        }
        fn seen_from(shape: &mut Shape, from_deg: f64, half_width_deg: f64) {
            shape.scatterers[0].view = View::Sector { from_deg, half_width_deg };
        }
        let all: [(&str, f64, f64, Set); 16] = [
            ("scatterers", -0.5, 0.5, |s, v| s.scatterers[0].x = v),
            ("scatterers", -0.5, 0.5, |s, v| s.scatterers[0].y = v),
            ("scatterers", 1e-6, 1.0, |s, v| s.scatterers[0].weight = v),
            ("scatterers", -360.0, 360.0, |s, v| seen_from(s, v, 20.0)),
            ("scatterers", 10.0, 180.0, |s, v| seen_from(s, 0.0, v)),
            ("fuselage_radius", 0.0, 0.5, |s, v| fuselage(s).radius = v),
            ("behind_fuselage", 0.0, 1.0, |s, v| fuselage(s).behind = v),
            ("flash", 0.0, 100.0, |s, v| fuselage(s).base = v),
            ("flash", 0.0, 100.0, |s, v| fuselage(s).peak = v),
            ("flash", 0.5, 90.0, |s, v| fuselage(s).width_deg = v),
            ("flash", -0.5, 0.5, |s, v| fuselage(s).points[0] = v),
            ("length_m", 0.1, 200.0, |s, v| s.size_m.0 = v),
            ("span_m", 0.1, 200.0, |s, v| s.size_m.1 = v),
            ("rcs_m2", 1e-3, 1e5, |s, v| s.rcs_m2 = v),
            ("limits_db", 0.0, 60.0, |s, v| s.limits_db.0 = v),
            ("limits_db", 0.0, 60.0, |s, v| s.limits_db.1 = v),
        ];
        assert_eq!(sample_shapes::of(true).validate(), Ok(()));
        for (key, low, high, set) in all {
            let refused = |value: f64| {
                let mut shape = (*sample_shapes::of(true)).clone();
                set(&mut shape, value);
                let said = format!("{value} is not within {low} to {high}");
                let found = shape.validate().err();
                found.is_some_and(|(word, text)| word == key && text.ends_with(&said))
            };
            let by = 1e-3 * (high - low).min(low.abs().max(1e-3));
            for (value, wanted) in [
                (low, false),
                (high, false),
                (low - by, true),
                (high + 1e-3 * high, true),
                (f64::NAN, true),
            ] {
                assert_eq!(refused(value), wanted, "{key} = {value}");
            }
        }
        let with = |count: usize, points: usize| {
            let mut shape = (*sample_shapes::of(true)).clone();
            let one =
                Scatterer { x: 0.0, y: 0.0, weight: 1.0 / count.max(1) as f64, view: View::All };
            shape.scatterers = vec![one; count];
            fuselage(&mut shape).points = vec![0.0; points];
            shape.limits_db = (60.0, 60.0);
            shape.validate().map_err(|(key, _)| key)
        };
        assert_eq!([with(1, 1), with(32, 16)], [Ok(()); 2]);
        assert_eq!([with(0, 1), with(33, 1)], [Err("scatterers"); 2]);
        assert_eq!([with(1, 0), with(1, 17)], [Err("flash"); 2]);
        // The echo of an aspect beyond its limits, and sides that are unlike.
        let mut tight = (*sample_shapes::of(true)).clone();
        tight.limits_db = (0.1, 0.1);
        assert_eq!(tight.validate().map_err(|(key, _)| key), Err("limits_db"));
        assert_eq!(sample_shapes::of(true).lopsided(), None);
        let mut one_sided = (*Shape::point()).clone();
        seen_from(&mut one_sided, 60.0, 90.0);
        one_sided.scatterers.push(Scatterer { x: 0.0, y: 0.0, weight: 0.1, view: View::All });
        let (db, deg) = one_sided.lopsided().expect("its sides are unlike");
        let wanted = [0.0, 10.0, 30.0, 60.0, 90.0, 120.0].map(|deg: f64| {
            let share = |deg: f64| {
                let off = (deg - 60.0).rem_euclid(360.0);
                let off = off.min(360.0 - off).min(90.0);
                libm::cos(off.to_radians()).powi(2) + 0.1
            };
            (10.0 * libm::log10(share(deg) / share(-deg))).abs()
        });
        let most = wanted.into_iter().fold(0.0, f64::max);
        assert!(db >= most - 1e-9 && db < 10.5 && (0.0..180.0).contains(&deg), "{db} at {deg}");
    }
}
