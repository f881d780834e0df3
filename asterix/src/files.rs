//! The forms in which recordings of ASTERIX travel, but for pcap: bare blocks, IOSS final, RFF.
//!
//! | form | layout |
//! | --- | --- |
//! | raw | blocks one after another; no times |
//! | final | a frame: length 2 (of all), error 1, board 1, day 1, time 3 (10 ms, since midnight), content, A5 four times |
//! | RFF | 128 octets of head (two dates of 20 characters), then a frame: ms since the start 4, length 2 *little-endian*, content |
//!
//! Numbers are big-endian where not said otherwise. Layouts as the decoder jASTERIX reads them.

use crate::error::{DecodeError, Fault};
use std::fmt;

/// A form of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Blocks one after another.
    Raw,
    /// IOSS final.
    Final,
    /// RFF.
    Rff,
}

impl Form {
    /// The form that a file's name asks for: `.ast`, `.raw` and `.bin` raw, `.ff` and `.final` final, `.rff` RFF.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        let (_, ending) = name.rsplit_once('.')?;
        match ending.to_ascii_lowercase().as_str() {
            "ast" | "raw" | "bin" => Some(Self::Raw),
            "ff" | "final" => Some(Self::Final),
            "rff" => Some(Self::Rff),
            _ => None,
        }
    }

    /// The form of these octets, judged by their first frame; raw if nothing else fits.
    #[must_use]
    pub fn of_octets(octets: &[u8]) -> Self {
        let date = |at: usize| {
            let text = octets.get(at..at + 19).unwrap_or_default();
            text.len() == 19 && text.iter().all(|c| c.is_ascii_digit() || b"-/. :T".contains(c))
        };
        if octets.len() >= RFF_HEAD && date(0) && date(20) {
            return Self::Rff;
        }
        let closed = |length: usize| {
            length >= FINAL_AROUND
                && octets.get(length - 4..length).is_some_and(|end| end == [0xa5; 4])
        };
        match octets {
            [high, low, ..] if closed(usize::from(u16::from_be_bytes([*high, *low]))) => {
                Self::Final
            }
            _ => Self::Raw,
        }
    }
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Raw => "raw",
            Self::Final => "IOSS final",
            Self::Rff => "RFF",
        })
    }
}

const RFF_HEAD: usize = 128;
/// Octets of a final frame around its content.
const FINAL_AROUND: usize = 12;
const DAY_NS: i64 = 86_400_000_000_000;

/// A frame of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Octet of the file at which the content begins.
    pub offset: usize,
    /// Arrival, ns since 1970; since the midnight before the recording where the form has no date (final); `None`
    /// where it has no times (raw, an RFF without a readable start).
    pub time_ns: Option<i64>,
    /// Data blocks.
    pub content: &'a [u8],
}

/// Why the rest of a file was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// The header of a block (raw).
    #[error("{0}")]
    Block(DecodeError),
    /// A frame that goes on after the file's end, or is too short to be one.
    #[error("octet {offset}: a frame of length {length}, {left} octets left")]
    Frame {
        /// Where the frame begins.
        offset: usize,
        /// Its length.
        length: usize,
        /// Octets there are.
        left: usize,
    },
    /// A final frame without its four closing octets.
    #[error("octet {offset}: a frame does not end with A5 A5 A5 A5")]
    Padding {
        /// Where the frame begins.
        offset: usize,
    },
}

/// The frames of a file in order. Damage ends them: without a sound length nothing tells where the next one begins.
#[must_use]
pub fn frames(form: Form, file: &[u8]) -> Frames<'_> {
    let start_ns =
        if form == Form::Rff { date_ns(file.get(..20).unwrap_or_default()) } else { None };
    let at = if form == Form::Rff { RFF_HEAD.min(file.len()) } else { 0 };
    Frames { form, file, at, start_ns }
}

/// See [`frames`].
#[derive(Clone, Debug)]
pub struct Frames<'a> {
    form: Form,
    file: &'a [u8],
    at: usize,
    start_ns: Option<i64>,
}

impl<'a> Iterator for Frames<'a> {
    type Item = Result<Frame<'a>, FileError>;

    fn next(&mut self) -> Option<Self::Item> {
        let offset = self.at;
        let rest = &self.file[offset..];
        if rest.is_empty() {
            return None;
        }
        let read = match self.form {
            Form::Raw => raw(rest, offset),
            Form::Final => closing(rest, offset),
            Form::Rff => rff(rest, offset, self.start_ns),
        };
        match read {
            Ok((frame, length)) => {
                self.at += length;
                Some(Ok(frame))
            }
            Err(e) => {
                self.at = self.file.len();
                Some(Err(e))
            }
        }
    }
}

fn raw(rest: &[u8], offset: usize) -> Result<(Frame<'_>, usize), FileError> {
    let refuse = |category, fault| {
        FileError::Block(DecodeError {
            offset,
            category,
            record: 0,
            item: None,
            subitem: None,
            fault,
        })
    };
    let left = rest.len();
    let &[category, high, low, ..] = rest else {
        return Err(refuse(None, Fault::HeaderCut { left }));
    };
    let length = usize::from(u16::from_be_bytes([high, low]));
    if length < 3 {
        return Err(refuse(Some(category), Fault::LengthTooSmall { length }));
    }
    match rest.get(..length) {
        Some(content) => Ok((Frame { offset, time_ns: None, content }, length)),
        None => Err(refuse(Some(category), Fault::LengthBeyond { length, left })),
    }
}

fn closing(rest: &[u8], offset: usize) -> Result<(Frame<'_>, usize), FileError> {
    let left = rest.len();
    let length = match rest {
        &[high, low, ..] => usize::from(u16::from_be_bytes([high, low])),
        _ => 0,
    };
    if length < FINAL_AROUND || length > left {
        return Err(FileError::Frame { offset, length, left });
    }
    if rest[length - 4..length] != [0xa5; 4] {
        return Err(FileError::Padding { offset });
    }
    let ticks = u32::from_be_bytes([0, rest[5], rest[6], rest[7]]);
    let time_ns = i64::from(rest[4]) * DAY_NS + i64::from(ticks) * 10_000_000;
    let content = &rest[8..length - 4];
    Ok((Frame { offset: offset + 8, time_ns: Some(time_ns), content }, length))
}

fn rff(rest: &[u8], offset: usize, start_ns: Option<i64>) -> Result<(Frame<'_>, usize), FileError> {
    let left = rest.len();
    let &[a, b, c, d, low, high, ref after @ ..] = rest else {
        return Err(FileError::Frame { offset, length: 6, left });
    };
    let length = usize::from(u16::from_le_bytes([low, high]));
    let Some(content) = after.get(..length) else {
        return Err(FileError::Frame { offset, length: length + 6, left });
    };
    let since_ns = i64::from(u32::from_be_bytes([a, b, c, d])) * 1_000_000;
    let time_ns = start_ns.map(|start| start + since_ns);
    Ok((Frame { offset: offset + 6, time_ns, content }, 6 + length))
}

/// Makes a file frame by frame.
#[derive(Debug)]
pub struct FileWriter {
    form: Form,
    octets: Vec<u8>,
    /// Arrival of the first and of the last frame.
    span_ns: Option<(i64, i64)>,
}

/// A frame that does not fit into its form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a frame of {octets} octets: {form} holds {most}")]
pub struct TooLong {
    /// Octets of the frame's content.
    pub octets: usize,
    /// Most that the form holds.
    pub most: usize,
    /// The form.
    pub form: Form,
}

impl FileWriter {
    /// An empty file.
    #[must_use]
    pub fn new(form: Form) -> Self {
        let head = if form == Form::Rff { RFF_HEAD } else { 0 };
        Self { form, octets: vec![0; head], span_ns: None }
    }

    /// Adds a datagram that arrived `time_ns` after 1970.
    ///
    /// # Errors
    /// If it is longer than a frame of this form can be.
    pub fn add(&mut self, time_ns: i64, datagram: &[u8]) -> Result<(), TooLong> {
        let octets = datagram.len();
        let most = if self.form == Form::Final { 65_535 - FINAL_AROUND } else { 65_535 };
        if octets > most && self.form != Form::Raw {
            return Err(TooLong { octets, most, form: self.form });
        }
        let (first_ns, _) = *self.span_ns.get_or_insert((time_ns, time_ns));
        self.span_ns = Some((first_ns, time_ns));
        match self.form {
            Form::Raw => self.octets.extend_from_slice(datagram),
            Form::Final => {
                let midnight_ns = first_ns.div_euclid(DAY_NS) * DAY_NS;
                let since_ns = (time_ns - midnight_ns).max(0);
                let day = (since_ns / DAY_NS).min(255) as u8;
                let ticks = (since_ns % DAY_NS / 10_000_000) as u32;
                let length = (octets + FINAL_AROUND) as u16;
                self.octets.extend_from_slice(&length.to_be_bytes());
                self.octets.extend_from_slice(&[0, 0, day]);
                self.octets.extend_from_slice(&ticks.to_be_bytes()[1..]);
                self.octets.extend_from_slice(datagram);
                self.octets.extend_from_slice(&[0xa5; 4]);
            }
            Form::Rff => {
                // Counted from the whole second that the head names.
                let since_ns = time_ns - first_ns.div_euclid(1_000_000_000) * 1_000_000_000;
                let since_ms = u32::try_from(since_ns / 1_000_000).unwrap_or(0);
                self.octets.extend_from_slice(&since_ms.to_be_bytes());
                self.octets.extend_from_slice(&(octets as u16).to_le_bytes());
                self.octets.extend_from_slice(datagram);
            }
        }
        Ok(())
    }

    /// The file.
    #[must_use]
    pub fn finish(mut self) -> Vec<u8> {
        if let (Form::Rff, Some((first_ns, last_ns))) = (self.form, self.span_ns) {
            for (at, time_ns) in [(0, first_ns), (20, last_ns)] {
                self.octets[at..at + 19].copy_from_slice(date(time_ns).as_bytes());
            }
        }
        self.octets
    }
}

/// `YYYY-MM-DD hh:mm:ss`.
fn date(time_ns: i64) -> String {
    let seconds = time_ns.div_euclid(1_000_000_000);
    let (days, of_day) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    // Days since 0000-03-01, by years of March to February.
    let shifted = days + 719_468;
    let era = shifted.div_euclid(146_097);
    let day_of_era = shifted.rem_euclid(146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = (era * 400 + year_of_era + i64::from(month <= 2)).clamp(0, 9999);
    let (h, m, s) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("{year:04}-{month:02}-{day:02} {h:02}:{m:02}:{s:02}")
}

/// Nanoseconds since 1970 of a date as [`date`] writes it (any signs between the numbers).
fn date_ns(text: &[u8]) -> Option<i64> {
    let number = |from: usize, to: usize| {
        let digits = text.get(from..to)?;
        let text =
            std::str::from_utf8(digits).ok().filter(|_| digits.iter().all(u8::is_ascii_digit))?;
        text.parse::<i64>().ok()
    };
    let (year, month, day) = (number(0, 4)?, number(5, 7)?, number(8, 10)?);
    let (h, m, s) = (number(11, 13)?, number(14, 16)?, number(17, 19)?);
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) || h > 23 || m > 59 || s > 60 {
        return None;
    }
    let shifted = if month <= 2 { year - 1 } else { year };
    let era = shifted.div_euclid(400);
    let year_of_era = shifted.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let day_of_era = 365 * year_of_era + year_of_era / 4 - year_of_era / 100 + day_of_year;
    let days = era * 146_097 + day_of_era - 719_468;
    Some((days * 86_400 + h * 3600 + m * 60 + s) * 1_000_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;

    const START_NS: i64 = 1_574_586_012_340_000_000; // 2019-11-24 09:00:12.34
    const PLOT: [u8; 10] = [0x0a, 0, 10, 0xd0, 0, 7, 2, 0x46, 0x50, 0];

    fn written(form: Form, times_ns: &[i64]) -> Vec<u8> {
        let mut file = FileWriter::new(form);
        for &time_ns in times_ns {
            file.add(time_ns, &PLOT).expect("fits");
        }
        file.finish()
    }

    #[test]
    fn literal_frames() {
        let around_midnight = [START_NS, START_NS + DAY_NS];
        let closing = written(Form::Final, &around_midnight);
        // 09:00:12.34 is 3 241 234 steps of 10 ms.
        let head = [0, 22, 0, 0, 0, 0x31, 0x75, 0x12];
        assert_eq!(closing[..22], [&head[..], &PLOT, &[0xa5; 4]].concat());
        assert_eq!(closing[22..30], [0, 22, 0, 0, 1, 0x31, 0x75, 0x12]);
        let rff = written(Form::Rff, &[START_NS, START_NS + 2_000_000_000]);
        assert_eq!(&rff[..40], b"2019-11-24 09:00:12\x002019-11-24 09:00:14\x00");
        assert_eq!(rff[128..134], [0, 0, 1, 0x54, 10, 0], "340 ms big-endian, 10 little-endian");
        assert_eq!(written(Form::Raw, &[START_NS; 2]), [PLOT, PLOT].concat());
    }

    #[test]
    fn what_is_written_is_read_and_known_again() {
        for (form, times) in [
            (Form::Raw, [None, None]),
            (Form::Final, [Some(32_412_340_000_000), Some(DAY_NS + 32_412_340_000_000)]),
            (Form::Rff, [Some(START_NS), Some(START_NS + DAY_NS)]),
        ] {
            let file = written(form, &[START_NS, START_NS + DAY_NS]);
            assert_eq!(Form::of_octets(&file), form);
            let read: Vec<_> = frames(form, &file).map(|f| f.expect("sound")).collect();
            assert_eq!(read.iter().map(|f| f.time_ns).collect::<Vec<_>>(), times, "{form}");
            assert!(read.iter().all(|f| f.content == PLOT && file[f.offset..].starts_with(&PLOT)));
        }
        for (name, form) in [("a.ast", Some(Form::Raw)), ("b.FF", Some(Form::Final)), ("c", None)] {
            assert_eq!(Form::of_name(name), form);
        }
    }

    #[test]
    fn damage_ends_a_file_and_says_where() {
        for form in [Form::Raw, Form::Final, Form::Rff] {
            let file = written(form, &[START_NS; 3]);
            for cut in 0..file.len() {
                let read: Vec<_> = frames(form, &file[..cut]).collect();
                let sound = read.iter().filter(|f| f.is_ok()).count();
                assert!(sound < 3 && read.len() - sound <= 1, "{form} cut at {cut}");
            }
        }
        let mut file = written(Form::Final, &[START_NS; 2]);
        file[22 + 21] = 0;
        let read: Vec<_> = frames(Form::Final, &file).collect();
        assert_eq!(read[1], Err(FileError::Padding { offset: 22 }));
        assert!(matches!(frames(Form::Raw, &[10, 0, 2]).next(), Some(Err(FileError::Block(_)))));
    }

    #[test]
    fn dates_go_both_ways() {
        for time_ns in
            [0, 951_782_399_000_000_000, 951_868_800_000_000_000, START_NS, -86_401_000_000_000]
        {
            let whole_ns = time_ns - time_ns.rem_euclid(1_000_000_000);
            assert_eq!(date_ns(date(time_ns).as_bytes()), Some(whole_ns), "{}", date(time_ns));
        }
        assert_eq!(date(951_782_400_000_000_000), "2000-02-29 00:00:00");
        assert_eq!(date_ns(b"not a date at all.."), None);
    }
}
