//! `seeds score --truth RUN --alerts FILE`: the alerts of a safety net held against those of the rules on exact truth.
//!
//! The log of a run with traffic that behaves holds the true alerts (`reference_alerts`). Of recorded traffic, in which nobody
//! follows clearances, they are made here from the true states, by the same rules but those about clearances.

use super::score_source::{Source, scene};
use crate::runtime::cli::{self, out};
use crate::viewer_logger::log_traffic::told_of;
use anyhow::{Context, bail};
use models::control::alert::{AlertKind, Change};
use models::control::clearance::Board;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::control::safety_net::{SafetyNet, Scan};
use models::control::scoring::Told;
use models::control::situation::{Target, TargetClass};
use models::frames::{Point2, Vector2};
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::network::Network;
use rusqlite::Connection;
use scenarios::Scene;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use studies::score_alerts::AlertReport;
use studies::score_files;

/// Says the report, and saves it where a file is asked for.
///
/// # Errors
/// If the file cannot be written.
pub fn write(report: &AlertReport, file: Option<&Path>, json: bool) -> anyhow::Result<()> {
    if let Some(path) = file {
        let form = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let text = match form {
            "csv" => report.to_csv(),
            "json" => format!("{:#}\n", report.to_json()),
            _ => report.to_html(),
        };
        cli::save(path, text)?;
    }
    match json {
        true => out!("{}", report.to_json()),
        false => out!("{}", report.to_text().trim_end()),
    }
    Ok(())
}

/// Scores alerts against the truth of a run.
///
/// # Errors
/// What cannot be read, and where.
pub fn scored(
    truth: &Path,
    alerts: &Path,
    asked_scene: Option<&str>,
) -> anyhow::Result<AlertReport> {
    let run = Source::open(truth)?;
    let Source::Database(database) = &run else {
        bail!(
            "{}: the truth of alerts is the database of a run (.sqlite): clearances and stop bars belong to it",
            truth.display()
        );
    };
    let mut notes = Vec::new();
    let at_truth = || truth.display().to_string();
    let count = |query: &str| database.query_row(query, [], |row| row.get::<_, i64>(0));
    let behaves = count("SELECT count(*) FROM movements").with_context(at_truth)? > 0;
    let mut found = match Source::open(alerts)? {
        Source::Database(other) => told_of(&other, "alerts").map_err(anyhow::Error::from),
        Source::Text(text) => score_files::alerts(&text).map_err(anyhow::Error::from),
        Source::Recording(_) => {
            bail!("{}: neither CSV nor the database of a run", alerts.display())
        }
    }
    .with_context(|| alerts.display().to_string())?;
    let (reference, movements) = if behaves {
        let served = "SELECT value FROM measures WHERE source = 'truth' AND name = 'served'";
        let served: f64 =
            database.query_row(served, [], |row| row.get(0)).with_context(at_truth)?;
        (told_of(database, "reference_alerts").with_context(at_truth)?, served as u32)
    } else {
        let Some(scene) = scene(asked_scene, &[&run], &mut notes)? else {
            bail!("{}: the airport is needed; name its scene with --scene", truth.display());
        };
        notes.push(
            "The run is one of recorded traffic: nobody follows clearances, and alerts about them are left out."
                .into(),
        );
        found.retain(|t| !AlertKind::of(&t.kind).is_some_and(AlertKind::is_about_clearances));
        of_truth(database, &scene).with_context(at_truth)?
    };
    let hours = count("SELECT coalesce(max(time_ns), 0) FROM scans").with_context(at_truth)? as f64
        / 3.6e12;
    let beyond = found.iter().filter(|t| t.on_s < 0.0 || t.on_s > 3600.0 * hours + 1.0).count();
    if beyond > 0 {
        notes.push(format!(
            "{beyond} alerts are from before or after the run: times count in seconds from its begin."
        ));
    }
    let title = format!("{} against {}", alerts.display(), truth.display());
    Ok(AlertReport::of(title, notes, reference, found, (hours, movements)))
}

/// So many are watched at once: numbers of tracks are 0 to 4095.
const MOST_TARGETS: u16 = 4096;

/// Numbers of those who are there: of who has gone they are free again.
struct Numbers {
    of: BTreeMap<i64, u16>,
    free: BTreeSet<u16>,
    /// Had by somebody at some time.
    had: BTreeSet<u16>,
}

impl Default for Numbers {
    fn default() -> Self {
        Self { of: BTreeMap::new(), free: (0..MOST_TARGETS).collect(), had: BTreeSet::new() }
    }
}

impl Numbers {
    /// The number of an entity, and whether another one had it before; of more at once than there are numbers some have none.
    fn of(&mut self, entity: i64) -> Option<(u16, bool)> {
        if let Some(number) = self.of.get(&entity) {
            return Some((*number, false));
        }
        let number = self.free.pop_first()?;
        self.of.insert(entity, number);
        Some((number, !self.had.insert(number)))
    }

    /// Forgets all but those of a scan.
    fn keep(&mut self, targets: &[Target]) {
        let there: BTreeSet<u16> = targets.iter().map(|t| t.number).collect();
        let free = &mut self.free;
        self.of.retain(|_, number| there.contains(number) || !free.insert(*number));
    }
}

/// What moves counts as a movement from this speed on, m/s.
const MOVES_MPS: f64 = 1.0;

/// The alerts of the rules on the true states of a run of recorded traffic, and how many aircraft moved in it.
fn of_truth(database: &Connection, scene: &Scene) -> anyhow::Result<(Vec<Told>, u32)> {
    let layout = &scene.airport.layout;
    let layout = Layout::of(layout).with_network(&Network::of(layout));
    // Without error, by the thresholds of the run.
    let (strip_margin_m, bar_margin_m) = (scene.control.strip_margin_m, scene.control.bar_margin_m);
    let parameters = Parameters { strip_margin_m, bar_margin_m, ..Parameters::default() };
    let mut net = SafetyNet::new(layout, parameters);
    let visibilities = scene.visibility_m();
    let visibility_m = |now: SimTime| {
        let until = visibilities.partition_point(|(from, _)| *from <= now);
        until.checked_sub(1).map_or(f64::INFINITY, |last| visibilities[last].1)
    };
    let mut arrivals =
        database.prepare("SELECT callsign FROM flights WHERE movement = 'arrival'")?;
    let arrivals: BTreeSet<String> =
        arrivals.query_map([], |row| row.get(0))?.collect::<Result<_, _>>()?;
    let mut query = database.prepare(
        "SELECT time_ns, entity, callsign, x_m, y_m, altitude_m, vx_ms, vy_ms, length_m, aircraft \
         FROM scans LEFT JOIN truth USING (scan) ORDER BY scan, entity",
    )?;
    let mut rows = query.query([])?;
    let (mut numbers, mut moved) = (Numbers::default(), BTreeSet::new());
    let mut told: BTreeMap<u32, Told> = BTreeMap::new();
    let (mut at, mut targets): (Option<SimTime>, Vec<Target>) = (None, Vec::new());
    loop {
        let row = rows.next()?;
        let time = row.map(|row| row.get(0)).transpose()?.map(SimTime);
        if let Some(now) = at.filter(|now| time != Some(*now)) {
            targets.sort_by_key(|t| t.number);
            judge(&mut net, now, &targets, visibility_m(now), &mut told);
            numbers.keep(&targets);
            targets.clear();
        }
        let (Some(row), Some(now)) = (row, time) else { break };
        at = Some(now);
        let Some(entity) = row.get::<_, Option<i64>>(1)? else { continue };
        let callsign: String = row.get::<_, Option<String>>(2)?.unwrap_or_default();
        let velocity_mps = Vector2::new(row.get(6)?, row.get(7)?);
        let is_aircraft = row.get::<_, Option<i64>>(9)? == Some(1);
        if is_aircraft && velocity_mps.norm() > MOVES_MPS {
            moved.insert(entity);
        }
        let Some((number, first)) = numbers.of(entity) else { continue };
        targets.push(Target {
            number,
            callsign: (!callsign.is_empty()).then(|| Callsign::new(&callsign)),
            class: if is_aircraft { TargetClass::Aircraft } else { TargetClass::Vehicle },
            arriving: arrivals.contains(&callsign),
            length_m: row.get::<_, Option<f64>>(8)?.unwrap_or(0.0),
            position_m: Point2::new(row.get(3)?, row.get(4)?),
            velocity_mps,
            altitude_m: row.get(5)?,
            last_plot: now,
            first,
        });
    }
    Ok((told.into_values().collect(), moved.len() as u32))
}

/// One scan of exact states: what is raised, how near its subjects are, what ends.
fn judge(
    net: &mut SafetyNet,
    now: SimTime,
    targets: &[Target],
    visibility_m: f64,
    told: &mut BTreeMap<u32, Told>,
) {
    let (board, areas) = (Board::default(), net.layout().areas.clone());
    let low_visibility = net.parameters().is_low(visibility_m);
    let scan = Scan { now, targets, board: &board, bars: &[], areas: &areas, low_visibility };
    let changes = net.scan(&scan);
    for (change, alert) in changes.iter().filter(|(_, a)| !a.condition.kind.is_about_clearances()) {
        let one = told.entry(alert.id).or_insert_with(|| Told {
            kind: alert.condition.kind.word(),
            subjects: Vec::new(),
            on_s: now.s(),
            end_s: f64::INFINITY,
            nearest_m: None,
        });
        one.subjects = alert.subjects().split(' ').map(str::to_owned).collect();
        if *change == Change::Ended {
            one.end_s = now.s();
        }
    }
    let named = |t: &'_ Target| Some((t.callsign?, t.position_m));
    let places: Vec<(Callsign, Point2<f64>)> = targets.iter().filter_map(named).collect();
    let places: Vec<(&str, Point2<f64>)> = places.iter().map(|(c, at)| (c.as_str(), *at)).collect();
    for one in told.values_mut().filter(|one| one.end_s.is_infinite()) {
        one.look(now.s(), &places);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten thousand entities, a thousand at a time: each has a number of its own while it is there, and is said to be another one.
    #[test]
    fn numbers_of_who_has_gone_are_given_again() {
        let mut numbers = Numbers::default();
        for group in 0..10_i64 {
            let mut targets = Vec::new();
            for entity in 1000 * group..1000 * (group + 1) {
                let (number, first) = numbers.of(entity).expect("a number");
                // The third thousand have the numbers of the first, who have gone.
                assert_eq!((first, numbers.of(entity)), (group > 1, Some((number, false))));
                targets.push(Target {
                    number,
                    callsign: None,
                    class: TargetClass::Vehicle,
                    arriving: false,
                    length_m: 5.0,
                    position_m: Point2::origin(),
                    velocity_mps: Vector2::zeros(),
                    altitude_m: None,
                    last_plot: SimTime::ZERO,
                    first,
                });
            }
            let own: BTreeSet<u16> = targets.iter().map(|t| t.number).collect();
            assert!(own.len() == 1000 && own.iter().all(|n| *n < MOST_TARGETS));
            // The next ones come while these are still there.
            numbers.keep(&targets);
        }
    }
}
