//! Alerts as features, placemarks, packets and rows.

use super::super::sweep::cell;
use super::{Run, digits, escaped};
use anyhow::Context;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// An alert from when it was raised until it ended.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Alert {
    id: i64,
    kind: String,
    /// The highest that it came to.
    stage: String,
    subjects: String,
    from_ns: i64,
    /// None: it stands at the end of the run.
    to_ns: Option<i64>,
    position_m: Option<[f64; 2]>,
}

/// Those of a run, in the order of time.
///
/// # Errors
/// If the database has no table of alerts.
pub(super) fn of(run: &Run) -> anyhow::Result<Vec<Alert>> {
    // A row a stage: 'alarm' is before 'information' in the alphabet, and above it.
    let mut query = run
        .database
        .prepare(
            "SELECT id, kind, min(stage), max(subjects), min(time_ns), max(end_ns), \
             CASE WHEN count(end_ns) = count(*) THEN 1 END, place_x_m, place_y_m \
             FROM alerts GROUP BY id ORDER BY min(time_ns), id",
        )
        .context("the database of another version: it has no alerts")?;
    let rows = query.query_map([], |row| {
        let ended = row.get::<_, Option<i64>>(6)?.is_some();
        let place = row.get::<_, Option<f64>>(7)?.zip(row.get::<_, Option<f64>>(8)?);
        Ok(Alert {
            id: row.get(0)?,
            kind: row.get(1)?,
            stage: row.get(2)?,
            subjects: row.get(3)?,
            from_ns: row.get(4)?,
            to_ns: row.get::<_, Option<i64>>(5)?.filter(|_| ended),
            position_m: place.map(|(x, y)| [x, y]),
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}

impl Alert {
    fn title(&self) -> String {
        format!("{} {}", self.kind, self.subjects)
    }

    fn place(&self, run: &Run) -> Option<[f64; 2]> {
        self.position_m.map(|place| run.place(place).map(|degrees| digits(degrees, 7)))
    }

    /// GeoJSON; without geometry where nobody says where it was.
    pub(super) fn feature(&self, run: &Run) -> Value {
        let geometry = self.place(run).map(|at| json!({"type": "Point", "coordinates": at}));
        json!({
            "type": "Feature", "geometry": geometry,
            "properties": {
                "kind": "alert", "id": self.id.to_string(), "name": self.title(), "type": self.kind, "stage": self.stage,
                "subjects": self.subjects.split(' ').collect::<Vec<_>>(),
                "begin": run.time(self.from_ns), "end": self.to_ns.map(|ns| run.time(ns)),
            },
        })
    }

    /// KML, a point that is there while it stands.
    pub(super) fn kml(&self, run: &Run, out: &mut String) {
        let Some([lon, lat]) = self.place(run) else { return };
        let end = self.to_ns.map_or(String::new(), |ns| format!("<end>{}</end>", run.time(ns)));
        writeln!(
            out,
            "<Placemark><name>{}</name><description>{}</description><TimeSpan><begin>{}</begin>{end}</TimeSpan>\
             <Point><coordinates>{lon:.7},{lat:.7}</coordinates></Point></Placemark>",
            escaped(&self.title()),
            escaped(&self.stage),
            run.time(self.from_ns)
        )
        .ok();
    }

    /// CZML; `last_ns`: the end of the document, where it still stands.
    pub(super) fn packet(&self, run: &Run, last_ns: i64) -> Value {
        let end = run.time(self.to_ns.unwrap_or(last_ns.max(self.from_ns)));
        let rgba = if self.stage == "alarm" { [213, 0, 0, 255] } else { [255, 176, 0, 255] };
        let mut packet = json!({
            "id": format!("alert-{}", self.id), "name": self.title(),
            "availability": format!("{}/{end}", run.time(self.from_ns)),
            "point": {"pixelSize": 14, "color": {"rgba": rgba}, "heightReference": "CLAMP_TO_GROUND"},
            "label": {
                "text": self.title(), "font": "12px sans-serif", "pixelOffset": {"cartesian2": [10, 10]},
                "horizontalOrigin": "LEFT",
            },
        });
        if let Some([lon, lat]) = self.place(run) {
            packet["position"] = json!({"cartographicDegrees": [lon, lat, 0.0]});
        }
        packet
    }
}

/// One row an alert, with the columns that `seeds score --alerts` reads.
pub(super) fn csv(run: &Run, alerts: &[Alert]) -> String {
    let mut out = String::from("time_s,end_s,kind,stage,subjects,utc,lat_deg,lon_deg,x_m,y_m,id\n");
    for alert in alerts {
        let seconds = |ns: i64| format!("{:.3}", ns as f64 * 1e-9);
        let pair = |place: Option<[f64; 2]>, decimals: usize| match place {
            Some([a, b]) => format!("{a:.decimals$},{b:.decimals$}"),
            None => ",".to_owned(),
        };
        let degrees = alert.place(run).map(|[lon, lat]| [lat, lon]);
        writeln!(
            out,
            "{},{},{},{},{},{},{},{},{}",
            seconds(alert.from_ns),
            alert.to_ns.map_or(String::new(), seconds),
            cell(&alert.kind),
            cell(&alert.stage),
            cell(&alert.subjects),
            run.time(alert.from_ns),
            pair(degrees, 7),
            pair(alert.position_m, 3),
            alert.id
        )
        .ok();
    }
    out
}
