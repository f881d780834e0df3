//! Times as people write them, and back.

use std::fmt;

/// Nanoseconds since 1970 UTC, shown as `2026-11-20T23:30:00.123456789Z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Utc(pub i64);

const NS_PER_S: i64 = 1_000_000_000;
const S_PER_DAY: i64 = 86_400;

impl fmt::Display for Utc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (s, ns) = (self.0.div_euclid(NS_PER_S), self.0.rem_euclid(NS_PER_S));
        let (day, s) = (s.div_euclid(S_PER_DAY), s.rem_euclid(S_PER_DAY));
        let (year, month, dom) = date(day);
        let (h, m, s) = (s / 3600, s / 60 % 60, s % 60);
        write!(f, "{year:04}-{month:02}-{dom:02}T{h:02}:{m:02}:{s:02}.{ns:09}Z")
    }
}

/// A text that is no time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is not a valid time: seconds from the start (12.5) or UTC (2026-11-20T23:30:00Z) are"
)]
pub struct BadTime(pub String);

/// A time in a recording: from its start, or UTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Nanoseconds from the first datagram on.
    FromStart(i64),
    /// Nanoseconds since 1970.
    At(Utc),
}

impl When {
    /// The time in a recording that starts at `start_ns` since 1970 UTC.
    #[must_use]
    pub fn utc_ns(self, start_ns: i64) -> i64 {
        match self {
            Self::FromStart(ns) => start_ns.saturating_add(ns),
            Self::At(utc) => utc.0,
        }
    }
}

impl std::str::FromStr for When {
    type Err = BadTime;

    fn from_str(text: &str) -> Result<Self, BadTime> {
        let bad = || BadTime(text.to_owned());
        if let Some(utc) = text.strip_suffix('Z') {
            return parse_utc(utc).map(Self::At).ok_or_else(bad);
        }
        // Whole and decimal digits apart: exact to the nanosecond.
        let (negative, digits) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
        let ns = parse_seconds(digits).ok_or_else(bad)?;
        Ok(Self::FromStart(if negative { -ns } else { ns }))
    }
}

/// `12`, `12.5`: nanoseconds.
fn parse_seconds(text: &str) -> Option<i64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |t: &str| t.bytes().all(|b| b.is_ascii_digit());
    if whole.is_empty() || !digits(whole) || !digits(fraction) || fraction.len() > 9 {
        return None;
    }
    let mut ns: i64 = 0;
    for b in fraction.bytes().chain(std::iter::repeat(b'0')).take(9) {
        ns = ns * 10 + i64::from(b - b'0');
    }
    whole.parse::<i64>().ok()?.checked_mul(NS_PER_S)?.checked_add(ns)
}

/// `2026-11-20T23:30:00` with or without decimals.
fn parse_utc(text: &str) -> Option<Utc> {
    let (day, time) = text.split_once(['T', ' '])?;
    let mut day = day.splitn(3, '-').map(|t| t.parse::<i64>().ok());
    let (year, month, dom) = (day.next()??, day.next()??, day.next()??);
    let (hm, s) = time.rsplit_once(':')?;
    let (h, m) = hm.split_once(':')?;
    let (h, m) = (h.parse::<i64>().ok()?, m.parse::<i64>().ok()?);
    let ns = parse_seconds(s)?;
    let valid = (1970..2262).contains(&year)
        && (1..=12).contains(&month)
        && (1..=31).contains(&dom)
        && (0..24).contains(&h)
        && (0..60).contains(&m)
        && ns < 60 * NS_PER_S;
    let days = day_number(year, month, dom);
    // The 31st of a short month would come back as another day.
    (valid && date(days) == (year, month, dom))
        .then(|| Utc((days * S_PER_DAY + h * 3600 + m * 60) * NS_PER_S + ns))
}

/// Days since 1970-01-01 of a date of the Gregorian calendar. A year is taken to begin in March, so
/// that the leap day is its last; 400 years have 146 097 days.
fn day_number(year: i64, month: i64, dom: i64) -> i64 {
    let from_march = (month + 9) % 12;
    let year = year - i64::from(month < 3);
    let day_of_year = (153 * from_march + 2) / 5 + dom - 1;
    let (era, yoe) = (year.div_euclid(400), year.rem_euclid(400));
    era * 146_097 + yoe * 365 + yoe / 4 - yoe / 100 + day_of_year - 719_468
}

/// The inverse of [`day_number`].
fn date(days: i64) -> (i64, i64, i64) {
    let days = days + 719_468;
    let (era, doe) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let yoe = (doe - doe / 1460 + doe / 36_524 - doe / 146_096) / 365;
    let doy = doe - (365 * yoe + yoe / 4 - yoe / 100);
    let from_march = (5 * doy + 2) / 153;
    let month = (from_march + 2) % 12 + 1;
    (era * 400 + yoe + i64::from(month < 3), month, doy - (153 * from_march + 2) / 5 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_times() {
        for (ns, text) in [
            (0, "1970-01-01T00:00:00.000000000Z"),
            (951_782_400 * NS_PER_S + 1, "2000-02-29T00:00:00.000000001Z"),
            (1_709_251_199 * NS_PER_S, "2024-02-29T23:59:59.000000000Z"),
            (4_102_444_800 * NS_PER_S, "2100-01-01T00:00:00.000000000Z"),
        ] {
            assert_eq!(Utc(ns).to_string(), text);
            assert_eq!(text.parse(), Ok(When::At(Utc(ns))));
        }
        assert_eq!(Utc(-1).to_string(), "1969-12-31T23:59:59.999999999Z");
    }

    #[test]
    fn every_day_comes_back() {
        for day in -200_000..200_000 {
            let (year, month, dom) = date(day);
            assert_eq!(day_number(year, month, dom), day);
        }
    }

    #[test]
    fn seconds_from_the_start_and_what_is_no_time() {
        assert_eq!("12.5".parse(), Ok(When::FromStart(12_500_000_000)));
        assert_eq!("0.000000001".parse(), Ok(When::FromStart(1)));
        assert_eq!("-3".parse(), Ok(When::FromStart(-3 * NS_PER_S)));
        for bad in ["", "x", "1e3", ".5", "1.2.3", "NaN", "2026-02-30T00:00:00Z", "2026-01-01Z"] {
            assert!(bad.parse::<When>().is_err(), "{bad}");
        }
    }
}
