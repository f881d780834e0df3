//! Departures that name the arrival whose aircraft they are, in whatever order they stand.

use super::Wanted;
use crate::document::one_of;
use crate::error::{Problem, ScenarioError};
use models::traffic::core::{Direction, Flight};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Who names whom, and whom nobody sees.
#[derive(Default)]
pub(super) struct TurnRounds {
    /// By flight: what it names, with type, file and line.
    named: Vec<Named>,
    /// Arrivals that landed before the run, or land after it.
    over: Vec<String>,
}

struct Named {
    arrival: Option<String>,
    designator: String,
    file: PathBuf,
    line: usize,
}

impl TurnRounds {
    /// The next flight.
    pub(super) fn add(&mut self, w: &Wanted, file: &Path) {
        self.named.push(Named {
            arrival: w.turnaround_of.clone(),
            designator: w.designator.clone(),
            file: file.to_path_buf(),
            line: w.line,
        });
    }

    /// Arrivals that are none of the run.
    pub(super) fn over(&mut self, callsigns: Vec<String>) {
        self.over.extend(callsigns);
    }

    /// Finds the arrivals of all that were added. An arrival that nobody knows is refused, and one that two name; one of another type
    /// is not the same aircraft, which `remarks` say.
    pub(super) fn resolve(
        self,
        flights: &mut [Flight],
        remarks: &mut Vec<String>,
    ) -> Result<(), ScenarioError> {
        let mut arrivals: BTreeMap<&str, usize> = BTreeMap::new();
        for (at, f) in flights.iter().enumerate() {
            if f.direction == Direction::Arrival {
                arrivals.entry(&f.callsign).or_insert(at);
            }
        }
        let mut found: Vec<Option<usize>> = vec![None; flights.len()];
        let mut first: BTreeMap<usize, usize> = BTreeMap::new();
        for (at, named) in self.named.iter().enumerate() {
            let Some(name) = named.arrival.as_deref() else { continue };
            let refuse = |problem| {
                Err(ScenarioError::new(&named.file, named.line, "turnaround_of", problem))
            };
            let Some(arrival) = arrivals.get(name).copied() else {
                if self.over.iter().any(|o| o == name) {
                    continue;
                }
                let known = arrivals.keys().copied().chain(self.over.iter().map(String::as_str));
                let allowed = one_of(name, &known.collect::<Vec<_>>());
                return refuse(Problem::NotAllowed { found: name.to_owned(), allowed });
            };
            if let Some(other) = first.insert(arrival, at) {
                let first_line = self.named[other].line;
                return refuse(Problem::Duplicate { found: name.to_owned(), first_line });
            }
            let comes_as = &self.named[arrival].designator;
            if *comes_as == named.designator {
                found[at] = Some(arrival);
            } else {
                remarks.push(format!(
                    "{}: a {} is not the {comes_as} of {name}, it has an aircraft of its own",
                    flights[at].callsign, named.designator
                ));
            }
        }
        flights.iter_mut().zip(found).for_each(|(f, arrival)| f.turnaround_of = arrival);
        Ok(())
    }
}
