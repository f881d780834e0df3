//! Tables of traffic that behaves: clearances, movements, measures and remarks.
//!
//! The core is a pure function of scene and seed, so the logger writes what it says by stepping one of its
//! own, at the end of the run, up to the last frame that was executed.

use super::log::{Log, LogError, write_events};
use super::marks::fault;
use super::said::alert_event;
use crate::exchange::seats::{People, figures};
use crate::exchange::{driven, handover};
use crate::runtime::messages::{AlertMessage, SeatEvent, SeatMessage};
use models::control::alert::{Alert, AlertKind, Change, Stage};
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::control::scoring;
use models::frames::Point2;
use models::time::SimTime;
use models::traffic::core::{Ask, Core, Direction, Notice, Order};
use models::traffic::exact::{Watch, targets};
use models::traffic::measured::{Measured, measured};
use rusqlite::{Connection, Transaction, params};
use scenarios::Scene;
use scenarios::control::Sees;
use std::collections::BTreeMap;

/// The core after `frames` frames with the alerts that the rules raise on its exact truth, or `None` where nothing behaves or the scene
/// cannot be read again. `people`: what controllers at seats cleared.
#[must_use]
pub fn core_after(
    scene: &Scene,
    seed: u64,
    frames: u64,
    people: &[SeatMessage],
) -> Option<(Core, Reference)> {
    scene.traffic.behaving.as_ref()?;
    let whole = scenarios::load(&scene.path).ok().filter(|s| s.hash == scene.hash)?;
    let mut core = whole.traffic.behaving.as_ref()?.told_core(&whole.run, seed)?;
    let layout =
        Layout::of(&whole.airport.layout).with_network(&whole.traffic.behaving.as_ref()?.network);
    let mut watch = Watch::new(layout, Parameters::default(), whole.control.stop_bars)
        .in_visibility(whole.visibility_m());
    let mut reference = Reference::default();
    let mut given: BTreeMap<u64, Vec<Notice>> = BTreeMap::new();
    let mut asked: BTreeMap<u64, Vec<(u64, u64, Ask)>> = BTreeMap::new();
    for message in people {
        // Also what was refused: it may have changed who is planned when.
        if let SeatEvent::Input { frame, input, .. } = &message.event
            && let Some(ask) = handover::ask(&whole, &input.order)
        {
            asked.entry(frame + 1).or_default().push((*frame, input.number, ask));
        }
        if let SeatEvent::Input { frame, input, refused } = &message.event
            && refused.is_empty()
            && let Some(notice) = driven::notice(&whole, &core, *frame, input)
        {
            given.entry(frame + 1).or_default().push(notice);
        }
        let SeatEvent::Given(effect, g) = &message.event else { continue };
        given.entry(*effect).or_default().push(Notice {
            effect_frame: *effect as i64,
            source: g.seat.clone(),
            sequence: g.number,
            flight: g.flight as usize,
            order: Order::told(g.kind, g.by_person),
        });
    }
    for frame in 1..=frames {
        for notice in given.remove(&frame).into_iter().flatten() {
            core.notice(notice);
        }
        for (said, number, ask) in asked.remove(&frame).into_iter().flatten() {
            let effect = said + driven::delay_frames(&whole);
            core.ask(effect as i64, handover::SEAT, number, ask);
        }
        core.step(frame as i64);
        if frame.is_multiple_of(u64::from(whole.run.frames_per_scan)) {
            let now = SimTime(frame as i64 * whole.run.frame.0);
            reference.scan(&mut watch, &core, now);
        }
    }
    Some((core, reference))
}

/// What the rules say of exact truth.
#[derive(Debug, Default)]
pub struct Reference {
    /// Each change of an alert, at its time.
    told: Vec<(SimTime, Change, Alert)>,
    /// By number of the alert, while it stands and after: how near its subjects came.
    near: BTreeMap<u32, scoring::Told>,
}

impl Reference {
    fn scan(&mut self, watch: &mut Watch, core: &Core, now: SimTime) {
        self.told.extend(watch.scan(core, now).iter().map(|(c, a)| (now, *c, a.clone())));
        let exact = targets(core, now);
        let names =
            exact.iter().filter_map(|t| Some((t.callsign.as_ref()?.as_str(), t.position_m)));
        let mut places: Vec<(&str, Point2<f64>)> = Vec::new();
        for alert in watch.net().standing() {
            if places.is_empty() {
                places.extend(names.clone());
            }
            let near = self.near.entry(alert.id).or_insert_with(|| scoring::Told {
                kind: alert.condition.kind.word(),
                subjects: Vec::new(),
                on_s: alert.since.s(),
                end_s: f64::INFINITY,
                nearest_m: None,
            });
            near.subjects = alert.subjects().split(' ').map(str::to_owned).collect();
            near.look(now.s(), &places);
        }
    }
}

/// What the controllers' seats did, minute by minute and in all.
fn write_seats(t: &Transaction<'_>, people: &People, source: &str) -> rusqlite::Result<()> {
    let mut insert = t.prepare("INSERT INTO seats VALUES (?,?,?,?)")?;
    for m in &people.minutes {
        insert.execute(params![m.time_ns, m.seat, m.busy, m.queue])?;
    }
    let mut insert = t.prepare("INSERT INTO radio VALUES (?,?,?,?,?)")?;
    for (time_ns, [sender, receiver], kind, clearance) in &people.messages {
        insert.execute(params![time_ns, sender, receiver, kind.word(), clearance.word()])?;
    }
    let mut insert = t.prepare("INSERT INTO measures VALUES (?,?,?,?)")?;
    for (seat, figures) in figures(&people.minutes) {
        for (key, name, value) in figures {
            let unit = if key.contains("_s_") { "s" } else { "" };
            insert.execute(params![source, format!("{seat}: {name}"), value, unit])?;
        }
    }
    for (name, count) in &people.counts {
        insert.execute(params![source, name, *count as f64, ""])?;
    }
    Ok(())
}

/// What people at the seats did, whether it was possible or not, and what became of advice for them.
fn write_inputs(t: &Transaction<'_>, told: &[SeatMessage], frame_ns: i64) -> rusqlite::Result<()> {
    let mut insert = t.prepare("INSERT INTO inputs VALUES (?,?,?,?,?,?,?,?,?)")?;
    let mut advise = t.prepare("INSERT INTO advice VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?)")?;
    for message in told {
        let time_ns = |frame: &u64| *frame as i64 * frame_ns;
        match &message.event {
            SeatEvent::Input { frame, input, refused } => {
                let (order, (callsign, clearance)) = (&input.order, input.order.action.said());
                insert.execute(params![
                    input.number as i64,
                    *frame as i64,
                    time_ns(frame),
                    order.seat,
                    order.person,
                    order.action.word(),
                    callsign,
                    clearance,
                    refused
                ])?;
            }
            SeatEvent::Advised(a) => {
                advise.execute(params![
                    a.id,
                    a.frame as i64,
                    time_ns(&a.frame),
                    a.change.word(),
                    a.kind.word(),
                    a.seat,
                    a.subjects,
                    a.text,
                    a.value,
                    a.unit,
                    a.otherwise,
                    a.until_ns,
                    a.decision.word(),
                    if a.by_person { "person" } else { "model" }
                ])?;
            }
            SeatEvent::Silent { frame, seat, person } => {
                let (time_ns, frame) = (time_ns(frame), *frame as i64);
                insert.execute(params![0, frame, time_ns, seat, person, "silent", "", "", ""])?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// A row of a table of alerts.
struct Row<'a> {
    id: u32,
    time_ns: i64,
    kind: AlertKind,
    stage: Stage,
    subjects: &'a str,
    place_m: [f64; 2],
}

/// Alerts of a table (`alerts` or `reference_alerts`) of a run's database, one for each number.
///
/// # Errors
/// If there is no such table, or it cannot be read.
pub fn told_of(t: &Connection, table: &str) -> rusqlite::Result<Vec<scoring::Told>> {
    let nearest = if table == "reference_alerts" { "max(nearest_m)" } else { "NULL" };
    let text = format!(
        "SELECT kind, max(subjects), min(time_ns), max(end_ns), {nearest} FROM {table} GROUP BY id ORDER BY id"
    );
    let mut select = t.prepare(&text)?;
    let rows = select.query_map([], |row| {
        let subjects: String = row.get(1)?;
        let end_ns: Option<i64> = row.get(3)?;
        Ok(scoring::Told {
            kind: row.get(0)?,
            subjects: subjects.split(' ').map(str::to_owned).collect(),
            on_s: SimTime(row.get(2)?).s(),
            end_s: end_ns.map_or(f64::INFINITY, |ns| SimTime(ns).s()),
            nearest_m: row.get(4)?,
        })
    })?;
    rows.collect()
}

/// Measures of the alerts on tracks against those on exact truth, by kind and in all.
fn score_alerts(t: &Transaction<'_>, core: &Core) -> rusqlite::Result<()> {
    let scores = scoring::score(&told_of(t, "reference_alerts")?, &told_of(t, "alerts")?);
    let mut insert = t.prepare("INSERT INTO measures VALUES ('tracks',?,?,?)")?;
    let all = scoring::in_all(&scores);
    for score in scores.iter().chain([&all]) {
        let counts = [
            ("reference", score.reference),
            ("detected", score.detected),
            ("missed", score.missed()),
            ("false", score.false_alerts),
            ("nuisance", score.nuisance_alerts),
        ];
        for (name, count) in counts {
            insert.execute(params![format!("alerts {}: {name}", score.kind), count, ""])?;
        }
        for (name, p) in [("response median", 0.5), ("response 95 %", 0.95)] {
            if let Some(seconds) = score.response_s(p) {
                insert.execute(params![format!("alerts {}: {name}", score.kind), seconds, "s"])?;
            }
        }
    }
    let movements = core.measures_of_served();
    for (name, count) in [("false", all.false_alerts), ("nuisance", all.nuisance_alerts)] {
        // Of a run in which nobody was served there is no rate.
        if movements == 0 {
            break;
        }
        let rate = 100.0 * f64::from(count) / movements as f64;
        insert.execute(params![format!("alerts all: {name} per 100 movements"), rate, ""])?;
    }
    Ok(())
}

/// One row a stage; the end goes into all of them.
fn write_alert(
    t: &Transaction<'_>,
    table: &str,
    ended: bool,
    row: &Row<'_>,
) -> rusqlite::Result<()> {
    if ended {
        let end = format!("UPDATE {table} SET end_ns = ? WHERE id = ?");
        t.prepare_cached(&end)?.execute(params![row.time_ns, row.id])?;
        return Ok(());
    }
    let known = format!("SELECT count(*) FROM {table} WHERE id = ? AND stage = ?");
    let known: i64 =
        t.prepare_cached(&known)?.query_row(params![row.id, row.stage.word()], |r| r.get(0))?;
    if known > 0 {
        // A name that came later.
        let name = format!("UPDATE {table} SET subjects = ? WHERE id = ?");
        t.prepare_cached(&name)?.execute(params![row.subjects, row.id])?;
        return Ok(());
    }
    let insert = format!(
        "INSERT INTO {table} (time_ns, kind, stage, subjects, place_x_m, place_y_m, id) \
         VALUES (?,?,?,?,?,?,?)"
    );
    let [x, y] = row.place_m;
    t.prepare_cached(&insert)?.execute(params![
        row.time_ns,
        row.kind.word(),
        row.stage.word(),
        row.subjects,
        x,
        y,
        row.id
    ])?;
    Ok(())
}

impl Log {
    /// Writes what changed of the alerts on tracks.
    ///
    /// # Errors
    /// If the database cannot be written.
    pub fn alerts(&mut self, alerts: &[AlertMessage]) -> Result<(), LogError> {
        self.write(|t| {
            for a in alerts {
                let row = Row {
                    id: a.id,
                    time_ns: a.time_ns,
                    kind: a.kind,
                    stage: a.stage,
                    subjects: &a.subjects,
                    place_m: a.place_m.into(),
                };
                write_alert(t, "alerts", a.change == Change::Ended, &row)?;
            }
            let raised = alerts.iter().filter(|a| a.change == Change::Raised);
            let event = |a: &AlertMessage| alert_event(a.time_ns, a.stage, a.kind, &a.subjects);
            write_events(t, &raised.map(event).collect::<Vec<_>>())
        })
    }

    /// Writes what a core did.
    ///
    /// # Errors
    /// If the database cannot be written.
    pub fn traffic(
        &mut self,
        scene: &Scene,
        core: &Core,
        reference: &Reference,
        people: &[SeatMessage],
    ) -> Result<(), LogError> {
        let Some(behaving) = &scene.traffic.behaving else { return Ok(()) };
        let ns = |s: f64| (s * 1e9).round() as i64;
        self.write(|t| {
            for table in [
                "clearances",
                "movements",
                "measures",
                "remarks",
                "failures",
                "reference_alerts",
                "seats",
                "radio",
                "inputs",
                "advice",
            ] {
                t.execute(&format!("DELETE FROM {table}"), [])?;
            }
            let mut insert = t.prepare("INSERT INTO clearances VALUES (?,?,?,?,?,?,?)")?;
            for c in core.clearances() {
                let callsign = &core.flights()[c.flight].callsign;
                let (from, until) = (ns(c.from_s), c.until_s.map(ns));
                let runway = (!c.runway.is_empty()).then_some(&c.runway);
                insert.execute(params![
                    from,
                    callsign,
                    c.kind,
                    runway,
                    until,
                    c.route,
                    core.seat_of(c)
                ])?;
            }
            let mut insert = t.prepare("INSERT INTO movements VALUES (?,?,?,?,?,?,?,?,?,?,?,?)")?;
            let all = core.flights().iter().enumerate();
            for (index, f) in all.filter(|(index, _)| !core.is_free_place(*index)) {
                let m = core.measures(index);
                let kind = match f.direction {
                    Direction::Arrival => "arrival",
                    Direction::Departure => "departure",
                    Direction::Vehicle => continue,
                };
                let runway = &behaving.network.runways[f.runway.0].names[f.runway.1];
                let stand = &behaving.network.stands[core.stand(index)].name;
                insert.execute(params![
                    f.callsign,
                    kind,
                    m.aobt_s.map(ns),
                    m.atot_s.map(ns),
                    m.aldt_s.map(ns),
                    m.aibt_s.map(ns),
                    runway,
                    stand,
                    m.stops,
                    m.taxi_s,
                    m.additional_s(),
                    m.fuel_kg
                ])?;
            }
            let mut insert = t.prepare("INSERT INTO measures VALUES (?,?,?,?)")?;
            for Measured { name, value, unit } in measured(core) {
                insert.execute(params!["truth", name, value, unit])?;
            }
            if let Some(people) = People::of_told(people) {
                let sees = if scene.control.sees == Sees::Tracks { "tracks" } else { "truth" };
                write_seats(t, &people, sees)?;
            }
            write_inputs(t, people, scene.run.frame.0)?;
            let mut insert = t.prepare("INSERT INTO failures VALUES (?,?,?,?)")?;
            for f in core.shown() {
                insert.execute(params![f.id, f.callsign, f.kind.word(), ns(f.time_s)])?;
            }
            let failed = core.shown().iter().map(|f| {
                let text = format!("{} {}", f.callsign, f.kind.word().replace('_', " "));
                fault(ns(f.time_s), &f.callsign, text)
            });
            write_events(t, &failed.collect::<Vec<_>>())?;
            for (now, change, alert) in &reference.told {
                let (kind, stage) = (alert.condition.kind, alert.condition.stage);
                let place = alert.condition.place_m;
                let row = Row {
                    id: alert.id,
                    time_ns: now.0,
                    kind,
                    stage,
                    subjects: &alert.subjects(),
                    place_m: [place.x, place.y],
                };
                write_alert(t, "reference_alerts", *change == Change::Ended, &row)?;
            }
            let mut near = t.prepare("UPDATE reference_alerts SET nearest_m = ? WHERE id = ?")?;
            for (id, told) in &reference.near {
                near.execute(params![told.nearest_m, id])?;
            }
            if scene.control.sees == Sees::Tracks {
                score_alerts(t, core)?;
            }
            let mut insert = t.prepare("INSERT INTO remarks VALUES (?,?)")?;
            for r in core.remarks() {
                insert.execute(params![ns(r.time_s), r.text])?;
            }
            let stuck = core.remarks().iter().filter(|r| r.text.starts_with("deadlock"));
            let stuck = stuck.map(|r| fault(ns(r.time_s), "", r.text.clone()));
            write_events(t, &stuck.collect::<Vec<_>>())
        })
    }
}
