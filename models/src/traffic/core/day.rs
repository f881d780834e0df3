//! What the weather does to movers: braking and corners on wet surfaces, speed in fog, wind and the density of air.
//!
//! Source: `docs/traffic.md`; the factors are assumed there.

use super::{Core, Phase, Policy};
use crate::environment::Weather;
use crate::frames::{Azimuth, Vector2};
use crate::traffic::way::{Driving, Roll};

/// The weather as far as movers feel it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Day {
    /// Surfaces are wet.
    pub wet: bool,
    /// Meteorological visibility, m.
    pub visibility_m: f64,
    /// Wind, m/s east and north (where it blows to).
    pub wind_mps: Vector2<f64>,
    /// Density of the air over that of 15 °C and 1013.25 hPa.
    pub density_ratio: f64,
}

/// Surfaces are wet from this film on, mm.
const WET_FILM_MM: f64 = 0.25;
/// Braking and what may be pulled in corners when it is wet, over the dry figure.
const WET_BRAKING: f64 = 0.8;
const WET_CORNERS: f64 = 0.7;
/// Nobody taxies faster below this visibility, m, than this, m/s.
const LOW_VISIBILITY_M: f64 = 400.0;
const LOW_VISIBILITY_MPS: f64 = 8.0;
/// Exits are taken at this share of their speed when it is wet.
const WET_EXITS: f64 = 0.5;
/// Greatest braking for an exit, dry and wet, m/s².
const EXIT_BRAKING_MPS2: [f64; 2] = [2.5, 1.8];
/// Braking on an exit within its strip, dry, m/s²: hard braking of who taxies.
const OFF_BRAKING_MPS2: f64 = 1.5;
/// Density is that of dry air: the reference, hPa and K.
const STANDARD_HPA: f64 = 1013.25;
const STANDARD_K: f64 = 288.15;

impl Default for Day {
    /// Dry, clear, calm, as by the standard atmosphere at sea level.
    fn default() -> Self {
        Self {
            wet: false,
            visibility_m: f64::INFINITY,
            wind_mps: Vector2::zeros(),
            density_ratio: 1.0,
        }
    }
}

impl From<&Weather> for Day {
    /// `σ = (p/p₀)(T₀/T)`: vapour is left out (below 1.5 % of the density at 30 °C).
    fn from(weather: &Weather) -> Self {
        Self {
            wet: weather.film_mm > WET_FILM_MM,
            visibility_m: weather.visibility_m,
            wind_mps: weather.wind_mps,
            density_ratio: (weather.pressure_hpa / STANDARD_HPA)
                * (STANDARD_K / weather.temperature_k),
        }
    }
}

impl Day {
    /// Head wind for somebody who moves in a direction, m/s; negative: tail wind.
    #[must_use]
    pub fn head_mps(&self, along: Azimuth) -> f64 {
        -self.wind_mps.dot(&along.unit())
    }

    /// How somebody drives on this day who drives so when it is dry and clear.
    #[must_use]
    pub fn driving(&self, dry: Driving) -> Driving {
        let wet = |factor: f64| if self.wet { factor } else { 1.0 };
        let foggy = self.visibility_m < LOW_VISIBILITY_M;
        let most_mps = if foggy { LOW_VISIBILITY_MPS } else { f64::INFINITY };
        Driving {
            straight_mps: dry.straight_mps.min(most_mps),
            dec_mps2: dry.dec_mps2 * wet(WET_BRAKING),
            lateral_mps2: dry.lateral_mps2 * wet(WET_CORNERS),
            ..dry
        }
    }

    /// Share of its usual speed at which an exit is taken.
    pub(super) fn exit_share(&self) -> f64 {
        if self.wet { WET_EXITS } else { 1.0 }
    }

    /// Greatest braking for an exit, m/s².
    pub(super) fn exit_braking_mps2(&self) -> f64 {
        EXIT_BRAKING_MPS2[usize::from(self.wet)]
    }

    /// Greatest braking on an exit within its strip, m/s².
    pub(super) fn off_braking_mps2(&self) -> f64 {
        OFF_BRAKING_MPS2 * if self.wet { WET_BRAKING } else { 1.0 }
    }
}

impl Core {
    /// Head wind along the runway of a flight, from the end that it uses, m/s.
    pub(super) fn head_mps(&self, m: usize) -> f64 {
        self.head_on_mps(self.flights[m].runway)
    }

    /// Head wind along a runway from an end of it, m/s.
    pub(super) fn head_on_mps(&self, (r, end): (usize, usize)) -> f64 {
        match self.net.runways.get(r) {
            Some(runway) => {
                self.day.head_mps(Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]))
            }
            None => 0.0,
        }
    }

    /// The weather of this frame: whoever drives does so by it from now on, and the plans know.
    pub(super) fn look_at_weather(&mut self) {
        let before = self.day;
        while let Some((_, day)) = self.days.get(self.next_day).filter(|next| next.0 <= self.time_s)
        {
            self.day = *day;
            self.next_day += 1;
        }
        if self.day == before {
            return;
        }
        for m in 0..self.movers.len() {
            self.drives_by_day(m);
            self.rejects_for_weather(m);
        }
        if self.policy == Policy::Planned {
            self.retime();
        }
    }

    /// Drives as the day wants it. Who is about to land or does keeps what his exit was chosen by, until he is off the runway.
    pub(super) fn drives_by_day(&mut self, m: usize) {
        let mover = &self.movers[m];
        let driving = self.day.driving(mover.dry);
        let lands = matches!(mover.phase, Phase::Final | Phase::Landing);
        if driving == mover.driving || lands {
            return;
        }
        let (net, pieces) = (self.net.clone(), self.pieces.clone());
        let mover = &mut self.movers[m];
        mover.driving = driving;
        let laid = mover.way.pieces.len() > 1;
        if !laid || matches!(mover.phase, Phase::GoAround | Phase::Rolling) {
            return;
        }
        mover.way.limit(&net, &pieces, &driving, &Roll::NONE);
        if mover.timing.planned {
            self.passes_anew(m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dry() -> Driving {
        Driving {
            straight_mps: 14.0,
            turn_mps: 5.1,
            acc_mps2: 0.7,
            dec_mps2: 0.7,
            jerk_mps3: 0.6,
            lateral_mps2: 1.2,
        }
    }

    #[test]
    fn a_standard_day_changes_nothing() {
        let day = Day::from(&Weather::default());
        assert_eq!(day, Day::default());
        assert_eq!(day.driving(dry()), dry());
        assert_eq!((day.exit_share(), day.exit_braking_mps2()), (1.0, 2.5));
    }

    #[test]
    fn water_takes_braking_and_corners_fog_takes_speed() {
        let wet = Day::from(&Weather { film_mm: 0.26, ..Weather::default() }).driving(dry());
        assert_eq!((wet.dec_mps2, wet.straight_mps), (0.7 * 0.8, 14.0));
        assert!((wet.lateral_mps2 - 0.84).abs() < 1e-12);
        let damp = Day::from(&Weather { film_mm: 0.25, ..Weather::default() });
        assert_eq!(damp.driving(dry()), dry());
        let fog = |visibility_m| Day::from(&Weather { visibility_m, ..Weather::default() });
        assert_eq!(fog(399.0).driving(dry()), Driving { straight_mps: 8.0, ..dry() });
        assert_eq!(fog(400.0).driving(dry()), dry());
        let slow = Driving { straight_mps: 5.0, ..dry() };
        assert_eq!(fog(50.0).driving(slow), slow, "whoever is slower stays so");
    }

    /// Hot and high: 35 °C and 850 hPa leave 78 % of the air.
    #[test]
    fn air_is_thin_where_it_is_hot_and_high() {
        let hot = Weather { temperature_k: 308.15, pressure_hpa: 850.0, ..Weather::default() };
        let ratio = Day::from(&hot).density_ratio;
        assert!((ratio - 850.0 / 1013.25 * 288.15 / 308.15).abs() < 1e-12 && ratio < 0.79);
        let windy = Weather { wind_mps: Vector2::new(0.0, -7.0), ..Weather::default() };
        let day = Day::from(&windy);
        assert!((day.head_mps(Azimuth::from_rad(0.0)) - 7.0).abs() < 1e-12, "from the north");
        assert!((day.head_mps(Azimuth::from_rad(std::f64::consts::PI)) + 7.0).abs() < 1e-12);
        assert!(day.head_mps(Azimuth::from_rad(std::f64::consts::FRAC_PI_2)).abs() < 1e-12);
    }
}
