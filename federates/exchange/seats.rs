//! What controllers' seats did, as figures for the administration station, the summary of a run and its log.

use crate::runtime::messages::{SeatEvent, SeatMessage};
use models::control::actors::message::{MessageKind, Seat};
use models::control::actors::{Actors, Sample};
use models::control::clearance::ClearanceKind;
use models::time::SimTime;
use std::collections::BTreeMap;

/// The last minute of each seat for people: ("seat ground", "busy 34 %, 1 waiting").
#[must_use]
pub fn seat_facts(actors: &Actors) -> Vec<(String, String)> {
    let last: BTreeMap<Seat, &Sample> = actors.samples().iter().map(|s| (s.seat, s)).collect();
    let fact = |(seat, s): (Seat, &Sample)| {
        let text = format!("busy {:.0} %, {} waiting", 100.0 * s.busy, s.queue);
        (format!("seat {}", seat.name()), text)
    };
    last.into_iter().map(fact).collect()
}

/// Figures of each seat over the run, as values of a report: "seat ground busiest_minute" and others.
#[must_use]
pub fn seat_values(actors: &Actors) -> Vec<(String, f64)> {
    let minutes: Vec<Minute> = actors.samples().iter().map(Minute::of).collect();
    let figures = figures(&minutes).into_iter();
    figures
        .flat_map(|(seat, f)| f.map(|(name, _, value)| (format!("seat {seat} {name}"), value)))
        .collect()
}

/// One seat's minute.
#[derive(Clone, Debug, PartialEq)]
pub struct Minute {
    /// Its end, ns of simulated time.
    pub time_ns: i64,
    /// Whose.
    pub seat: String,
    /// Share in which it was busy.
    pub busy: f64,
    /// How many waited at its end.
    pub queue: u32,
    /// Seconds on the air since the begin.
    pub on_air_s: f64,
}

impl Minute {
    fn of(s: &Sample) -> Self {
        Self {
            time_ns: SimTime::from_s(s.time_s).0,
            seat: s.seat.name(),
            busy: s.busy,
            queue: s.queue,
            on_air_s: s.on_air_s,
        }
    }
}

/// Figures of a seat: key, words, value.
type Figures = [(&'static str, &'static str, f64); 3];

/// Three figures of each seat.
#[must_use]
pub fn figures(minutes: &[Minute]) -> Vec<(String, Figures)> {
    let mut by_seat: BTreeMap<&str, Vec<&Minute>> = BTreeMap::new();
    for m in minutes {
        by_seat.entry(&m.seat).or_default().push(m);
    }
    let of = |(seat, own): (&str, Vec<&Minute>)| {
        let last = own.last()?;
        let per_quarter_s = 900.0 * last.on_air_s / SimTime(last.time_ns).s().max(1.0);
        let busiest = own.iter().map(|m| m.busy).fold(0.0, f64::max);
        let longest = own.iter().map(|m| m.queue).max().unwrap_or(0);
        Some((
            seat.to_owned(),
            [
                ("on_air_s_in_15_min", "on air in 15 min", per_quarter_s),
                ("busiest_minute", "busiest minute", busiest),
                ("longest_queue", "longest queue", f64::from(longest)),
            ],
        ))
    };
    by_seat.into_iter().filter_map(of).collect()
}

/// A message as the table `radio` has it: time of its last word (ns), sender, receiver, kind, clearance.
pub type Spoken = (i64, [String; 2], MessageKind, ClearanceKind);

/// What controllers and pilots did in a run, wherever they sat.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct People {
    /// Minute by minute.
    pub minutes: Vec<Minute>,
    /// The messages.
    pub messages: Vec<Spoken>,
    /// Counts by their words.
    pub counts: Vec<(&'static str, u64)>,
}

impl People {
    /// As it was told by control; `None` if nothing was.
    #[must_use]
    pub fn of_told(told: &[SeatMessage]) -> Option<Self> {
        let mut people = Self::default();
        for message in told {
            match &message.event {
                SeatEvent::Given(..)
                | SeatEvent::Input { .. }
                | SeatEvent::Silent { .. }
                | SeatEvent::Advised(_) => {}
                SeatEvent::Spoke { time_ns, between, kind, clearance } => {
                    people.messages.push((*time_ns, between.clone(), *kind, *clearance))
                }
                SeatEvent::Minute { time_ns, seat, busy, queue, on_air_s } => {
                    people.minutes.push(Minute {
                        time_ns: *time_ns,
                        seat: seat.clone(),
                        busy: *busy,
                        queue: *queue,
                        on_air_s: *on_air_s,
                    });
                }
                SeatEvent::Counts { spoken, misheard, seen } => {
                    people.counts =
                        vec![("clearances spoken", *spoken), ("clearances misheard", *misheard)];
                    if let Some((called, kept_back)) = seen {
                        people.counts.extend([
                            ("clearances on a call, no track being there", *called),
                            (
                                "scans in which a runway looked occupied to one who waited",
                                *kept_back,
                            ),
                        ]);
                    }
                }
            }
        }
        (!told.is_empty()).then_some(people)
    }
}
