//! A scan as rows of the database.

use super::rmse;
use super::said;
use crate::runtime::messages::ScanReport;
use crate::viewer_logger::frame::{Note, Noted, entity_key, plot_error_m};
use crate::viewer_logger::source::ScanSums;
use rusqlite::{Transaction, params};

/// `plan`: the rows of its effect plan that did not stand in the scan before.
pub(super) fn write_scan(
    t: &Transaction<'_>,
    scan: &ScanReport,
    plan: &[&[String; 5]],
) -> rusqlite::Result<()> {
    let number = scan.scan as i64;
    let sums = ScanSums::of(scan);
    t.prepare_cached("INSERT INTO scans VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)")?.execute(params![
        number,
        scan.time_ns,
        scan.truth.len() as i64,
        scan.plots.len() as i64,
        scan.tracks.len() as i64,
        scan.truth.iter().filter(|x| x.track.is_none()).count() as i64,
        rmse(scan.truth.iter().filter_map(|x| x.track.map(|p| p.1))),
        rmse(scan.plots.iter().filter_map(plot_error_m)),
        scan.took_us as i64,
        sums.worst_error_m,
        sums.mean_error_m,
        sums.false_tracks,
        sums.wrong_labels
    ])?;
    let mut insert =
        t.prepare_cached("INSERT INTO truth VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)")?;
    for (place, x) in scan.truth.iter().enumerate() {
        insert.execute(params![
            number,
            entity_key(x.id) as i64,
            format!("{}.{}.{}", x.id[0], x.id[1], x.id[2]),
            x.callsign,
            x.type_designator,
            x.position_m[0],
            x.position_m[1],
            x.position_m[2],
            x.velocity_mps[0],
            x.velocity_mps[1],
            x.heading_rad.to_degrees().rem_euclid(360.0),
            x.track.map(|p| p.0),
            x.track.map(|p| p.1),
            x.velocity_mps[2],
            x.heading_rad,
            x.size_m[0],
            x.size_m[1],
            x.aircraft,
            x.ours,
            place as i64
        ])?;
    }
    write_plots(t, scan)?;
    let pairs = crate::viewer_logger::frame::pairs(scan);
    let mut insert = t.prepare_cached(concat!(
        "INSERT INTO tracks VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,",
        "?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)"
    ))?;
    for (place, x) in scan.tracks.iter().enumerate() {
        let pair = pairs.get(&x.number);
        let lag = x.lag.as_ref();
        insert.execute(params![
            number,
            x.number,
            x.status.word(),
            x.track_type.word(),
            x.callsign,
            x.position_m[0],
            x.position_m[1],
            x.velocity_mps[0],
            x.velocity_mps[1],
            libm::hypot(x.velocity_mps[0], x.velocity_mps[1]),
            x.heading_rad.to_degrees().rem_euclid(360.0),
            x.altitude_m,
            x.cov_m2[0],
            x.cov_m2[1],
            x.cov_m2[2],
            x.manoeuvre,
            pair.map(|p| scan.truth[p.0].callsign.as_str()),
            pair.map(|p| p.1),
            lag.map(|l| l.time_ns),
            lag.map(|l| l.position_m[0]),
            lag.map(|l| l.position_m[1]),
            lag.map(|l| l.cov_m2[0]),
            lag.map(|l| l.cov_m2[1]),
            lag.map(|l| l.cov_m2[2]),
            lag.map(|l| l.coasted),
            lag.and_then(|l| l.error_m),
            (!x.assumed.is_empty()).then_some(&x.assumed),
            x.label_p,
            x.time_ns,
            x.first,
            x.type_designator,
            said(x.wake),
            said(x.movement),
            x.runway_stand,
            x.routing.join(" "),
            x.ctd_eta_ns,
            x.heading_rad,
            x.acceleration_ms2[0],
            x.acceleration_ms2[1],
            x.velocity_cov_m2s2[0],
            x.velocity_cov_m2s2[1],
            x.velocity_cov_m2s2[2],
            x.address,
            x.existence_p,
            x.unresolved,
            place as i64,
            x.altitude_ns
        ])?;
    }
    let mut insert = t.prepare_cached("INSERT INTO statistics VALUES (?,?,?)")?;
    for (name, value) in &scan.measures {
        insert.execute(params![number, name, value])?;
    }
    let mut insert = t.prepare_cached("INSERT INTO plan VALUES (?,?,?,?,?,?)")?;
    for row in plan {
        insert.execute(params![number, row[0], row[1], row[2], row[3], row[4]])?;
    }
    Ok(())
}

/// What is noted of the tracks of a scan.
pub(super) fn write_notes(t: &Transaction<'_>, scan: u64, noted: &Noted) -> rusqlite::Result<()> {
    let mut insert = t.prepare_cached("INSERT OR REPLACE INTO track_notes VALUES (?,?,?,?,?,?)")?;
    for (number, note) in noted {
        let Note { doing, derived, alert, cleared } = *note;
        insert.execute(params![scan as i64, number, doing, derived, alert, cleared])?;
    }
    Ok(())
}

fn write_plots(t: &Transaction<'_>, scan: &ScanReport) -> rusqlite::Result<()> {
    let mut insert = t.prepare_cached(concat!(
        "INSERT INTO plots VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,",
        "?,?,?,?,?,?,?,?,?)"
    ))?;
    let mut effect = t.prepare_cached("INSERT INTO plot_effects VALUES (?,?,?,?,?,?,?)")?;
    for (place, x) in scan.plots.iter().enumerate() {
        insert.execute(params![
            scan.scan as i64,
            x.sensor,
            x.sequence,
            x.kind.word,
            x.time_ns,
            x.position_m[0],
            x.position_m[1],
            x.cov_m2[0],
            x.cov_m2[1],
            x.cov_m2[2],
            x.polar.map(|p| p[0]),
            x.polar.map(|p| p[1].to_degrees().rem_euclid(360.0)),
            x.scnr_db,
            (!x.identity.is_empty()).then_some(&x.identity),
            x.track,
            (!x.cause.is_empty()).then_some(&x.cause),
            x.truth_m.map(|p| p[0]),
            x.truth_m.map(|p| p[1]),
            plot_error_m(x),
            x.ellipse[0],
            x.ellipse[1],
            x.ellipse[2],
            x.ellipse[3],
            x.altitude_m,
            x.polar.map(|p| p[1]),
            x.polar.map(|p| p[2]),
            x.polar.map(|p| p[3]),
            place as i64
        ])?;
        for (at, (name, value, unit)) in x.effects.iter().enumerate() {
            let scan = scan.scan as i64;
            effect.execute(params![scan, x.sensor, x.sequence, name, value, unit, at as i64])?;
        }
    }
    Ok(())
}
