//! BaseStation lines (TCP port 30003 by custom): 22 fields with commas between, CR LF.

use std::fmt::Write as _;

/// What is common to all lines of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<'a> {
    /// 24-bit address.
    pub address: u32,
    /// UTC, ns since 1970.
    pub utc_ns: i64,
    /// What it says.
    pub says: Says<'a>,
}

/// The four transmissions that are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Says<'a> {
    /// 1: call sign.
    Identification(&'a str),
    /// 2: position on the ground.
    Surface {
        /// Speed over ground, kt.
        speed_kt: f64,
        /// Track, degrees.
        track_deg: f64,
        /// Latitude, degrees.
        lat_deg: f64,
        /// Longitude, degrees.
        lon_deg: f64,
    },
    /// 3: position in the air.
    Airborne {
        /// Pressure altitude, ft.
        altitude_ft: f64,
        /// Latitude, degrees.
        lat_deg: f64,
        /// Longitude, degrees.
        lon_deg: f64,
    },
    /// 4: velocity in the air.
    Velocity {
        /// Speed over ground, kt.
        speed_kt: f64,
        /// Track, degrees.
        track_deg: f64,
        /// Up, ft/min.
        climb_fpm: f64,
    },
}

/// Date and time of a UTC instant: `2019/11/24`, `09:03:51.000`.
#[must_use]
pub fn date_and_time(utc_ns: i64) -> (String, String) {
    let ms = utc_ns.div_euclid(1_000_000);
    let (days, ms_of_day) = (ms.div_euclid(86_400_000), ms.rem_euclid(86_400_000));
    // Days from civil, the other way round: years begin in March, eras have 400 of them.
    let z = days + 719_468;
    let (era, of_era) = (z.div_euclid(146_097), z.rem_euclid(146_097));
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let day_of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    let (s, ms) = (ms_of_day / 1000, ms_of_day % 1000);
    let time = format!("{:02}:{:02}:{:02}.{ms:03}", s / 3600, s / 60 % 60, s % 60);
    (format!("{year:04}/{month:02}/{day:02}"), time)
}

/// A course in tenths of a degree, below 360.
fn course(track_deg: f64) -> f64 {
    libm::round(track_deg * 10.0).rem_euclid(3600.0) / 10.0
}

/// Appends one line.
pub fn line(out: &mut String, line: &Line<'_>) {
    let (date, time) = date_and_time(line.utc_ns);
    let number = match line.says {
        Says::Identification(_) => 1,
        Says::Surface { .. } => 2,
        Says::Airborne { .. } => 3,
        Says::Velocity { .. } => 4,
    };
    // Fields 1 to 10: kind, session, aircraft, address, flight, generated and logged date and time.
    write!(out, "MSG,{number},1,1,{:06X},1,{date},{time},{date},{time},", line.address).ok();
    // 11 call sign, 12 altitude, 13 speed, 14 track, 15 and 16 position, 17 climb, 18 squawk, 19 to 21 alerts, 22 ground.
    let written = match line.says {
        Says::Identification(callsign) => {
            let clean: String = callsign.chars().filter(|c| !c.is_control() && *c != ',').collect();
            write!(out, "{clean},,,,,,,,,,,0")
        }
        Says::Surface { speed_kt, track_deg, lat_deg, lon_deg } => {
            let track_deg = course(track_deg);
            write!(out, ",,{speed_kt:.1},{track_deg:.1},{lat_deg:.6},{lon_deg:.6},,,0,0,0,-1")
        }
        Says::Airborne { altitude_ft, lat_deg, lon_deg } => {
            write!(out, ",{altitude_ft:.0},,,{lat_deg:.6},{lon_deg:.6},,,0,0,0,0")
        }
        Says::Velocity { speed_kt, track_deg, climb_fpm } => {
            let track_deg = course(track_deg);
            write!(out, ",,{speed_kt:.1},{track_deg:.1},,,{climb_fpm:.0},,0,0,0,0")
        }
    };
    written.ok(); // a String takes everything
    out.push_str("\r\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_has_22_fields() {
        let says = [
            Says::Identification("SWR1,2"),
            Says::Surface { speed_kt: 15.04, track_deg: 272.8, lat_deg: 47.4, lon_deg: -8.5 },
            Says::Airborne { altitude_ft: -25.0, lat_deg: 47.4, lon_deg: 8.5 },
            Says::Velocity { speed_kt: 140.2, track_deg: 0.0, climb_fpm: -704.0 },
        ];
        let mut out = String::new();
        for says in says {
            line(&mut out, &Line { address: 0xab, utc_ns: 1_574_586_231_250_000_000, says });
        }
        let lines: Vec<&str> = out.split_terminator("\r\n").collect();
        assert!(lines.iter().all(|l| l.split(',').count() == 22), "{out}");
        let ground = "MSG,2,1,1,0000AB,1,2019/11/24,09:03:51.250,2019/11/24,09:03:51.250,,,15.0,272.8,47.400000,-8.500000,,,0,0,0,-1";
        assert_eq!(lines[1], ground);
        assert_eq!(lines[0].split(',').nth(10), Some("SWR12"));
    }

    #[test]
    fn no_track_is_rounded_up_to_360() {
        for (track_deg, text) in
            [(359.949, "359.9"), (359.95, "0.0"), (359.999, "0.0"), (0.04, "0.0")]
        {
            for says in [
                Says::Surface { speed_kt: 15.0, track_deg, lat_deg: 47.4, lon_deg: 8.5 },
                Says::Velocity { speed_kt: 15.0, track_deg, climb_fpm: 0.0 },
            ] {
                let mut out = String::new();
                line(&mut out, &Line { address: 0xab, utc_ns: 0, says });
                assert_eq!(out.split(',').nth(13), Some(text), "{track_deg}");
            }
        }
    }

    #[test]
    fn dates_follow_the_calendar() {
        for (utc_s, date) in [
            (0, "1970/01/01"),
            (951_782_400, "2000/02/29"),
            (951_868_800, "2000/03/01"),
            (-86_400, "1969/12/31"),
            (4_107_542_400, "2100/03/01"),
        ] {
            assert_eq!(date_and_time(utc_s * 1_000_000_000).0, date);
        }
    }
}
