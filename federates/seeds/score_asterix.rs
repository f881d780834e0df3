//! Tracks of somebody's tracker out of a recording of ASTERIX.

use crate::exchange::asterix_file::{self, Pieces, sound};
use crate::gateway::foreign::{ForeignPlace, ForeignTrack, track};
use anyhow::{Context, bail};
use asterix::time::{Unwrap, of_day_s};
use models::frames::{Point2, Vector2};
use models::score::recording::Report;
use models::time::SimTime;
use std::collections::BTreeMap;
use std::path::Path;
use studies::score_files::Place;

/// Which tracks of a recording are meant, and how their times count.
#[derive(Clone, Copy, Debug)]
pub struct Which {
    /// Only this category.
    pub category: Option<u8>,
    /// Only this sender.
    pub source: Option<(u8, u8)>,
    /// UTC of the run's time 0, ns since 1970.
    pub start_utc_ns: Option<i64>,
    /// What the sender of the input added to the scene's times, s; tells when a report arrived.
    pub shift_s: Option<f64>,
}

/// A track that was silent for so long is another one when its number comes again, s.
const SILENT_S: f64 = 30.0;

/// Reports of the tracks, and remarks on what was left out.
///
/// # Errors
/// If the recording holds no track, or those of several senders.
pub fn reports(
    read: &Pieces,
    which: &Which,
    place: Place<'_>,
) -> anyhow::Result<(Vec<Report>, Vec<String>)> {
    let mut notes = Vec::new();
    let heard = heard(read, &mut notes);
    let chosen = chosen(heard, which)?;
    let Some(start_utc_ns) = which.start_utc_ns else {
        bail!(
            "the time of day tells nothing without the start of the run: take its database as --truth, or name the scene with --scene"
        );
    };
    let shift_s = which.shift_s.unwrap_or(0.0);
    let start_s = of_day_s(start_utc_ns) + shift_s;
    let mut days = Unwrap::near(start_s);
    let mut arrivals = Unwrap::near(start_s);
    let mut numbers: BTreeMap<u32, (u64, f64, bool)> = BTreeMap::new();
    let (mut next, mut coasting, mut unplaced) = (0, 0u64, 0u64);
    let mut reports = Vec::new();
    for (time_ns, report) in chosen {
        let time_s = days.seconds(report.of_day_s) - start_s;
        let known = numbers.get(&report.number).copied();
        let (id, ..) = match known {
            Some((id, last_s, ended)) if !ended && time_s - last_s <= SILENT_S => {
                (id, last_s, ended)
            }
            _ => {
                next += 1;
                (next, time_s, false)
            }
        };
        numbers.insert(report.number, (id, time_s, report.last));
        if report.tentative || report.last {
            continue;
        }
        coasting += u64::from(report.coasting);
        let position_m = match (report.place, place) {
            (ForeignPlace::Local([x_m, y_m]), _) => Point2::new(x_m, y_m),
            (ForeignPlace::Degrees([lat, lon]), Some(place)) => place(lat, lon),
            (ForeignPlace::Polar(_), _) => bail!(
                "positions are in range and azimuth about the site of a sensor, which no recording says: let a run hear them (--asterix-in) and score the tracks of its database (foreign_tracks)"
            ),
            (ForeignPlace::Degrees(_), None) => {
                bail!("positions are in degrees; name the scene of the airport with --scene")
            }
        };
        if position_m.coords.norm() > FARTHEST_M {
            unplaced += 1;
            continue;
        }
        // The clock of arrival is the sender's only where the times were shifted to it.
        let published = time_ns
            .filter(|_| which.shift_s.is_some())
            .map(|ns| SimTime::from_s(arrivals.seconds(of_day_s(ns)) - start_s));
        reports.push(Report {
            track: id,
            time: SimTime::from_s(time_s),
            published,
            position_m,
            velocity_mps: report.velocity_mps.map(|[x, y]| Vector2::new(x, y)),
            label: report.label,
        });
    }
    if unplaced > 0 {
        notes.push(format!("{unplaced} reports farther than 100 km were left out."));
    }
    if coasting > 0 {
        notes.push(format!("{coasting} of {} reports are of coasting tracks.", reports.len()));
    }
    Ok((reports, notes))
}

/// Farther than this from the reference point nothing belongs to an airport, m.
const FARTHEST_M: f64 = 100_000.0;

/// Every report of a track with its time of arrival; damage is remarked.
fn heard(read: &Pieces, notes: &mut Vec<String>) -> Vec<(Option<i64>, ForeignTrack)> {
    let mut heard = Vec::new();
    let mut damaged: BTreeMap<&str, u64> = BTreeMap::new();
    for piece in &read.pieces {
        for block in sound(&piece.octets) {
            match block {
                Ok(block) => {
                    let records = block.records().flatten();
                    heard.extend(records.filter_map(|r| Some((piece.time_ns, track(&r)?))));
                }
                Err(e) => *damaged.entry(e.fault.word()).or_default() += 1,
            }
        }
    }
    notes.extend(damaged.iter().map(|(word, n)| format!("{n} damaged datagrams: {word}.")));
    notes.extend(read.problems.iter().cloned());
    heard
}

fn chosen(
    heard: Vec<(Option<i64>, ForeignTrack)>,
    which: &Which,
) -> anyhow::Result<Vec<(Option<i64>, ForeignTrack)>> {
    let mut counts: BTreeMap<((u8, u8), u8), u64> = BTreeMap::new();
    let wanted = |t: &ForeignTrack| {
        which.category.is_none_or(|c| c == t.category) && which.source.is_none_or(|s| s == t.source)
    };
    for (_, t) in &heard {
        *counts.entry((t.source, t.category)).or_default() += 1;
    }
    let list = |counts: &BTreeMap<((u8, u8), u8), u64>| {
        let lines = counts.iter().map(|(((sac, sic), category), n)| {
            format!("--source {sac}/{sic} --category {category} ({n} reports)")
        });
        lines.collect::<Vec<_>>().join(", ")
    };
    let all = list(&counts);
    let chosen: Vec<_> = heard.into_iter().filter(|(_, t)| wanted(t)).collect();
    counts.retain(|(source, category), _| {
        which.category.is_none_or(|c| c == *category) && which.source.is_none_or(|s| s == *source)
    });
    match counts.len() {
        1 => Ok(chosen),
        0 if all.is_empty() => bail!("no track in category 010, 011, 020, 021 or 062"),
        0 => bail!("no such tracks; there are: {all}"),
        _ => bail!("tracks of several senders or categories; choose one of: {}", list(&counts)),
    }
}

/// Whether a file is a recording of ASTERIX by its first octets or its name.
///
/// # Errors
/// If it cannot be opened.
pub fn is_recording(path: &Path) -> anyhow::Result<bool> {
    use std::io::Read;
    let mut head = Vec::new();
    let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
    file.take(4).read_to_end(&mut head).with_context(|| path.display().to_string())?;
    let capture = <[u8; 4]>::try_from(head.as_slice()).is_ok_and(asterix_file::is_capture);
    Ok(capture || asterix::files::Form::of_name(&path.display().to_string()).is_some())
}

/// A sender as the command line has it: SAC/SIC.
///
/// # Errors
/// If it is not two numbers of 0 to 255.
pub fn source_of(text: &str) -> Result<(u8, u8), String> {
    let parts = text.split_once('/').and_then(|(a, i)| Some((a.parse().ok()?, i.parse().ok()?)));
    parts.ok_or_else(|| format!("'{text}' is not SAC/SIC, like 77/9"))
}
