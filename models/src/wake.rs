//! Wake turbulence: categories and what has to lie between two aircraft on one runway.
//!
//! Sources: ICAO Doc 4444 and RECAT-EU 1.1, both from memory.

use crate::flight_list::WakeCategory;

/// Wake category of the European scheme (RECAT-EU), `A` (largest) to `F`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Recat {
    /// A380.
    A,
    /// Upper heavy.
    B,
    /// Lower heavy.
    C,
    /// Upper medium.
    D,
    /// Lower medium.
    E,
    /// Light.
    F,
}

impl Recat {
    /// The category of a letter.
    #[must_use]
    pub fn of(letter: &str) -> Option<Self> {
        Some(match letter {
            "A" => Self::A,
            "B" => Self::B,
            "C" => Self::C,
            "D" => Self::D,
            "E" => Self::E,
            "F" => Self::F,
            _ => return None,
        })
    }

    /// The category that stands for one of ICAO where the type is not known.
    #[must_use]
    pub fn like(wake: WakeCategory) -> Self {
        match wake {
            WakeCategory::Super => Self::A,
            WakeCategory::Heavy => Self::B,
            WakeCategory::Medium => Self::D,
            WakeCategory::Light => Self::F,
        }
    }

    /// The category of ICAO that an aircraft of this one is in.
    #[must_use]
    pub fn icao(self) -> WakeCategory {
        match self {
            Self::A => WakeCategory::Super,
            Self::B | Self::C => WakeCategory::Heavy,
            Self::D | Self::E => WakeCategory::Medium,
            Self::F => WakeCategory::Light,
        }
    }

    /// Time behind `self` at which `next` may take off, s: RECAT-EU 1.1, at least 60 s.
    #[must_use]
    pub fn departure_gap_s(self, next: Self) -> f64 {
        use Recat::{A, B, C, D, E, F};
        match (self, next) {
            (A, B) | (B, D) | (C, E) | (E, F) => 100.0,
            (A, C) | (B, E) | (C | D, F) => 120.0,
            (A, D) | (B, F) => 140.0,
            (A, E) => 160.0,
            (A, F) => 180.0,
            (C, D) | (F, F) => 80.0,
            _ => 60.0,
        }
    }

    /// Least distance at which `next` may land behind `self`, NM: RECAT-EU 1.1, at least 3 NM.
    #[must_use]
    pub fn landing_gap_nm(self, next: Self) -> f64 {
        use Recat::{A, B, C, D, E, F};
        match (self, next) {
            (A, B) | (B, C | D) | (C, E) | (E, F) => 4.0,
            (A, F) => 8.0,
            (A, E) | (C, F) => 6.0,
            (A, C | D) | (B, E) | (D, F) => 5.0,
            (B, F) => 7.0,
            _ => 3.0,
        }
    }
}

/// Wake category of an aircraft, and of which scheme it is separated by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wake {
    /// Category of ICAO.
    pub icao: WakeCategory,
    /// Category of RECAT-EU, where aircraft are separated by it.
    pub recat: Option<Recat>,
}

impl From<WakeCategory> for Wake {
    /// Separated as ICAO does.
    fn from(icao: WakeCategory) -> Self {
        Self { icao, recat: None }
    }
}

impl Wake {
    /// Time between departures on one runway, s: at least 60 s. Of RECAT-EU if both are separated by it.
    #[must_use]
    pub fn departure_gap_s(self, then: Self) -> f64 {
        match (self.recat, then.recat) {
            (Some(first), Some(then)) => first.departure_gap_s(then),
            _ => icao_departure_gap_s(self.icao, then.icao),
        }
    }

    /// Least distance between two landings on one runway, NM: at least 3 NM. Of RECAT-EU if both are separated by it.
    #[must_use]
    pub fn landing_gap_nm(self, then: Self) -> f64 {
        match (self.recat, then.recat) {
            (Some(first), Some(then)) => first.landing_gap_nm(then),
            _ => icao_landing_gap_nm(self.icao, then.icao),
        }
    }

    /// Time on its runway that is kept behind a take-off whoever comes next, s (assumed: between the least and the most of its scheme).
    #[must_use]
    pub fn usual_gap_s(self) -> f64 {
        match (self.recat, self.icao) {
            (Some(Recat::A), _) | (None, WakeCategory::Heavy | WakeCategory::Super) => 140.0,
            (Some(Recat::B), _) => 110.0,
            _ => 90.0,
        }
    }
}

/// Time between departures on one runway, s (ICAO wake categories, at least 60 s).
#[must_use]
pub fn icao_departure_gap_s(first: WakeCategory, then: WakeCategory) -> f64 {
    use WakeCategory::{Heavy as H, Light as L, Medium as M, Super as J};
    match (first, then) {
        (J, H) => 120.0,
        (J, M | L) => 180.0,
        (H, M | L) | (M, L) => 120.0,
        _ => 60.0,
    }
}

/// Least distance between two landings on one runway, NM (ICAO wake categories, at least 3 NM).
fn icao_landing_gap_nm(first: WakeCategory, then: WakeCategory) -> f64 {
    use WakeCategory::{Heavy as H, Light as L, Medium as M, Super as J};
    match (first, then) {
        (J, J) | (H, J) | (M | L, J | H | M) | (L, L) => 3.0,
        (H, H) => 4.0,
        (J, H) | (H, M) | (M, L) => 5.0,
        (H, L) => 6.0,
        (J, M) => 7.0,
        (J, L) => 8.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Recat::{A, B, C, D, E, F};

    /// The rows of traffic.md 3.6, by leader.
    #[test]
    fn separations_are_those_of_the_tables() {
        let all = [A, B, C, D, E, F];
        let times: [[f64; 6]; 6] = [
            [60.0, 100.0, 120.0, 140.0, 160.0, 180.0],
            [60.0, 60.0, 60.0, 100.0, 120.0, 140.0],
            [60.0, 60.0, 60.0, 80.0, 100.0, 120.0],
            [60.0, 60.0, 60.0, 60.0, 60.0, 120.0],
            [60.0, 60.0, 60.0, 60.0, 60.0, 100.0],
            [60.0, 60.0, 60.0, 60.0, 60.0, 80.0],
        ];
        let distances: [[f64; 6]; 6] = [
            [3.0, 4.0, 5.0, 5.0, 6.0, 8.0],
            [3.0, 3.0, 4.0, 4.0, 5.0, 7.0],
            [3.0, 3.0, 3.0, 3.0, 4.0, 6.0],
            [3.0, 3.0, 3.0, 3.0, 3.0, 5.0],
            [3.0, 3.0, 3.0, 3.0, 3.0, 4.0],
            [3.0, 3.0, 3.0, 3.0, 3.0, 3.0],
        ];
        for (i, first) in all.into_iter().enumerate() {
            for (j, then) in all.into_iter().enumerate() {
                assert_eq!(first.departure_gap_s(then), times[i][j], "{first:?} {then:?}");
                assert_eq!(first.landing_gap_nm(then), distances[i][j], "{first:?} {then:?}");
            }
            assert_eq!(Recat::of(&format!("{first:?}")), Some(first));
        }
    }

    /// A lower heavy lets a medium go 40 s earlier than a heavy of ICAO does; one of whom the scheme does not know the category is
    /// separated as ICAO does.
    #[test]
    fn who_is_separated_by_the_european_scheme_is_it_only_among_his_like() {
        let of = |recat: Recat| Wake { icao: recat.icao(), recat: Some(recat) };
        let old = |recat: Recat| Wake::from(recat.icao());
        assert_eq!(of(C).departure_gap_s(of(D)), 80.0);
        assert_eq!(old(C).departure_gap_s(old(D)), 120.0);
        assert_eq!(of(C).departure_gap_s(old(D)), 120.0);
        assert_eq!(old(C).departure_gap_s(of(D)), 120.0);
        assert_eq!((of(C).landing_gap_nm(of(D)), of(C).landing_gap_nm(old(D))), (3.0, 5.0));
        assert_eq!(
            (of(B).usual_gap_s(), old(B).usual_gap_s(), of(C).usual_gap_s()),
            (110.0, 140.0, 90.0)
        );
        for wake in
            [WakeCategory::Light, WakeCategory::Medium, WakeCategory::Heavy, WakeCategory::Super]
        {
            assert_eq!(Recat::like(wake).icao(), wake);
        }
    }
}
