//! Requirements of standards, and whether a score meets them.

use super::areas::Area;
use super::robust::quantile;
use super::run::{AreaScore, Score};

/// What a requirement measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Share of update intervals with a report.
    Report,
    /// Gaps of at least [`Requirement::gap_s`] per expected interval.
    Gaps,
    /// Share of reports within [`Requirement::threshold`] metres of their target.
    Position,
    /// Share of reports farther than [`Requirement::threshold`] metres from every target.
    FalseReports,
    /// Share of speeds within [`Requirement::threshold`] m/s, or 10 % where that is more.
    Speed,
    /// Share of courses within [`Requirement::threshold`] degrees, of targets faster than 3 m/s.
    Course,
    /// Share of reports with the right label.
    Identified,
    /// Share of reports with a wrong label.
    Misidentified,
}

/// One line of a standard.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirement {
    /// The standard ("ED-87E").
    pub standard: String,
    /// The area as the standard calls it.
    pub area: String,
    /// The measure as the standard calls it.
    pub name: String,
    /// What it measures.
    pub measure: Measure,
    /// Probability.
    pub probability: f64,
    /// Whether the probability is a least one; else a largest.
    pub at_least: bool,
    /// Limit of the error in the measure's unit.
    pub threshold: f64,
    /// Update interval, s.
    pub interval_s: f64,
    /// Length of a gap, s.
    pub gap_s: f64,
}

/// A requirement with what was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The requirement.
    pub requirement: Requirement,
    /// The probability found; none where nothing was measured.
    pub found: Option<f64>,
    /// How many reports, intervals or targets it rests on.
    pub samples: u64,
    /// Whether it is met.
    pub met: Option<bool>,
    /// Whether that many samples can show such a probability at all.
    pub enough: bool,
    /// Of one that is not met: what it fails on, and what would be needed.
    pub remark: Option<String>,
}

/// The areas that a standard's name stands for; none for parts of the air.
#[must_use]
pub fn areas_of(name: &str) -> &'static [Area] {
    let name = name.to_ascii_lowercase();
    let has = |word: &str| name.contains(word);
    if has("airborne") {
        &[]
    } else if has("common") {
        &[Area::Runway, Area::Taxiway, Area::Apron, Area::Stand]
    } else if has("maneuvering") || has("manoeuvring") {
        &[Area::Runway, Area::Taxiway]
    } else if has("stand") {
        &[Area::Stand]
    } else if has("apron") {
        &[Area::Apron]
    } else if has("runway") {
        &[Area::Runway]
    } else if has("taxiway") {
        &[Area::Taxiway]
    } else {
        &[]
    }
}

impl Requirement {
    /// Holds a score against the requirement.
    #[must_use]
    pub fn judge(&self, score: &Score) -> Verdict {
        let areas: Vec<&AreaScore> =
            score.areas.iter().filter(|a| areas_of(&self.area).contains(&a.area)).collect();
        let (hits, samples) = areas.iter().fold((0.0, 0), |(hits, samples), area| {
            let (h, n) = self.count(area);
            (hits + h as f64, samples + n)
        });
        let found = (samples > 0).then(|| hits / samples as f64);
        let met = found
            .map(|f| if self.at_least { f >= self.probability } else { f <= self.probability });
        let rare = self.probability.min(1.0 - self.probability);
        let enough = samples as f64 * rare >= 1.0;
        let remark = (met == Some(false)).then(|| self.remark(&areas));
        Verdict { requirement: self.clone(), found, samples, met, enough, remark }
    }

    /// Why it is not met, in numbers of the run, and what would be needed.
    fn remark(&self, areas: &[&AreaScore]) -> String {
        let sum = |of: fn(&AreaScore) -> u64| areas.iter().map(|a| of(a)).sum::<u64>();
        match self.measure {
            Measure::Report | Measure::Gaps => {
                let (missing, before) = (sum(|a| a.unreported), sum(|a| a.before_first));
                let where_ = format!(
                    "{before} of {missing} scans without a report lie before the first report of their target"
                );
                if 2 * before >= missing {
                    format!(
                        "{where_}: no sensor sees it there yet, or not often enough to confirm a track. Needed: a \
                         sensor that does (a further radar site, ADS-B or multilateration)"
                    )
                } else {
                    format!(
                        "{where_}; the rest are holes in a track. Needed: more plots per target (a second radar, \
                         ADS-B or multilateration beside one radar)"
                    )
                }
            }
            Measure::Position => {
                let mut errors: Vec<f64> =
                    areas.iter().flat_map(|a| a.position_m.iter().copied()).collect();
                errors.sort_by(f64::total_cmp);
                let reached = quantile(&errors, self.probability).unwrap_or(f64::NAN);
                format!(
                    "{:.0} % of the errors are below {reached:.1} m. Needed: plots with less error (one radar sees the \
                     near side of an aircraft, not its middle), or a second sensor",
                    100.0 * self.probability
                )
            }
            Measure::FalseReports => "reports of tracks without a target, or that have left theirs. Needed: fewer \
                                      false plots, or a second sensor that confirms"
                .to_owned(),
            Measure::Speed => "Needed: plots with less error or more often than now; the speed is a difference of \
                               positions where no sensor measures it"
                .to_owned(),
            Measure::Course => {
                let slowest = 3.0 * libm::tan(self.threshold.to_radians());
                format!(
                    "at 3 m/s {}° are {slowest:.1} m/s across the course, less than plots of some metres once a second \
                     tell. Needed: plots with less error or more often, or targets that report their course",
                    self.threshold
                )
            }
            Measure::Identified => {
                let (due, right) = (sum(|a| a.labels_due), sum(|a| a.right_labels));
                let wrong = sum(|a| a.wrong_labels);
                format!(
                    "{wrong} labels are wrong, {} reports have none: nothing tells the names of these targets, and by \
                     place and time several flights may be meant. Needed: a sensor that identifies every target \
                     (ADS-B, multilateration)",
                    due - right - wrong
                )
            }
            Measure::Misidentified => "labels given by place and time, or by a name that went over to another track. \
                                       Needed: a sensor that identifies every target (ADS-B, multilateration)"
                .to_owned(),
        }
    }

    /// How often what is measured happened, of how many.
    pub(super) fn count(&self, area: &AreaScore) -> (u64, u64) {
        let within = |errors: &[f64], limit: f64| {
            (errors.partition_point(|e| *e <= limit) as u64, errors.len() as u64)
        };
        match self.measure {
            Measure::Report => area.reports_due(self.interval_s),
            Measure::Gaps => area.gaps(self.gap_s, self.interval_s),
            Measure::Position => within(&area.position_m, self.threshold),
            Measure::FalseReports => {
                // A track whose target has just ended is as false as any other.
                (area.false_reports(self.threshold).0, area.nearest_target_m.len() as u64)
            }
            Measure::Speed => {
                let good = area
                    .speed
                    .iter()
                    .filter(|(error, speed)| *error <= self.threshold.max(0.1 * speed));
                (good.count() as u64, area.speed.len() as u64)
            }
            Measure::Course => within(&area.course_rad, self.threshold.to_radians()),
            Measure::Identified => (area.right_labels, area.labels_due),
            Measure::Misidentified => (area.wrong_labels, area.labels_due),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn requirement(measure: Measure, probability: f64, at_least: bool) -> Requirement {
        Requirement {
            standard: "S".into(),
            area: "Manoeuvring Area".into(),
            name: "n".into(),
            measure,
            probability,
            at_least,
            threshold: 12.0,
            interval_s: 1.0,
            gap_s: 3.0,
        }
    }

    #[test]
    fn areas_are_found_by_their_names() {
        assert_eq!(areas_of("Active Stands"), [Area::Stand]);
        assert_eq!(areas_of("Apron Taxiways"), [Area::Apron]);
        assert_eq!(areas_of("Maneuvering Area"), [Area::Runway, Area::Taxiway]);
        assert_eq!(areas_of("Common").len(), 4);
        assert!(areas_of("Airborne 2.5-5nm").is_empty() && areas_of("").is_empty());
    }

    #[test]
    fn what_fails_says_what_it_fails_on() {
        let mut found = AreaScore::of(Area::Taxiway);
        (found.labels_due, found.right_labels, found.wrong_labels) = (100, 60, 1);
        let score = Score { areas: vec![found], ..Score::default() };
        let verdict = requirement(Measure::Identified, 0.97, true).judge(&score);
        let words = verdict.remark.expect("not met");
        assert!(words.contains("1 labels are wrong, 39 reports have none"), "{words}");
        assert_eq!(requirement(Measure::Identified, 0.6, true).judge(&score).remark, None);
    }

    #[test]
    fn verdicts_count_over_the_areas_and_say_when_they_rest_on_too_little() {
        let mut score = Score::default();
        for (area, errors) in [(Area::Runway, vec![1.0, 2.0, 13.0]), (Area::Taxiway, vec![5.0; 17])]
        {
            let mut found = AreaScore::of(area);
            found.position_m = errors;
            score.areas.push(found);
        }
        let verdict = requirement(Measure::Position, 0.95, true).judge(&score);
        assert_eq!((verdict.found, verdict.samples), (Some(0.95), 20));
        assert_eq!((verdict.met, verdict.enough), (Some(true), true));
        let verdict = requirement(Measure::Position, 0.99, true).judge(&score);
        assert_eq!((verdict.met, verdict.enough), (Some(false), false));
        // What it fails on is counted in the run: 99 % of these errors are below 13 m.
        assert!(verdict.remark.is_some_and(|words| words.contains("below 13.0 m")));
        let verdict = requirement(Measure::Identified, 0.99, true).judge(&score);
        assert_eq!((verdict.met, verdict.found), (None, None));
    }
}
