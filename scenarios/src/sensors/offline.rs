//! `kind = "offline"`: a sensor by figures that `seeds fit` wrote, in place of its model.

use super::reported::{Place, equipage};
use crate::document::Section;
use crate::error::{Problem, ScenarioError};
use models::plot::SensorKind;
use models::sensors::offline::{AxisFigures, OfflineAxes, OfflineConfig, OfflineFit};
use serde::Deserialize;
use serde_json::Value;
use std::path::PathBuf;

/// Figures of one sensor as `seeds fit --out FILE.json` writes them.
#[derive(Deserialize)]
struct FigureDoc {
    kind: String,
    mean_m: [f64; 2],
    sigma_m: [f64; 2],
    correlated_share: f64,
    tau_s: f64,
    pd: f64,
    outage_reports: f64,
    period_s: f64,
    far_share: f64,
    samples: usize,
    #[serde(default)]
    reach_m: Option<f64>,
}

/// Reads the figures that a sensor names, and the file that they are in.
pub(super) fn read(
    section: &Section,
    place: &Place<'_>,
) -> Result<(OfflineConfig, PathBuf), ScenarioError> {
    for key in ["parameters", "overrides"] {
        if section.has(key) {
            let allowed = "none: the figures are all that an off-line sensor has".into();
            return Err(section.refuse(key, Problem::NotAllowed { found: key.into(), allowed }));
        }
    }
    let path = section.file_path("figures")?.ok_or_else(|| {
        section.missing("figures", "a file that `seeds fit SCENE --out FILE.json` wrote".into())
    })?;
    let unsound =
        |reason: String| section.refuse("figures", Problem::File { path: path.clone(), reason });
    let text =
        crate::files::read_text(&path, crate::LARGEST_DATA).map_err(|e| unsound(e.to_string()))?;
    let file: Value =
        serde_json::from_str(&text).map_err(|e| unsound(format!("is not JSON: {e}")))?;
    let Some(sensors) = file.get("sensors").and_then(Value::as_array) else {
        return Err(unsound("has no list `sensors`, as `seeds fit` writes it".into()));
    };
    let name_of = |sensor: &Value| sensor.get("name").and_then(Value::as_str).map(str::to_owned);
    let names: Vec<String> = sensors.iter().filter_map(name_of).collect();
    let chosen = match section.text("of")? {
        Some(wanted) => match sensors.iter().find(|s| name_of(s).as_deref() == Some(wanted)) {
            Some(sensor) => sensor,
            None => {
                let allowed: Vec<_> = names.iter().map(|n| format!("\"{n}\"")).collect();
                let (found, allowed) = (wanted.to_owned(), allowed.join(", "));
                return Err(section.refuse("of", Problem::NotAllowed { found, allowed }));
            }
        },
        None => match &sensors[..] {
            [one] => one,
            _ => {
                let needed = format!("which sensor of the file: one of {}", names.join(", "));
                return Err(section.missing("of", needed));
            }
        },
    };
    if let Some(reason) = chosen.get("refused").and_then(Value::as_str) {
        return Err(unsound(format!("has no figures of this sensor: {reason}")));
    }
    let doc = FigureDoc::deserialize(chosen).map_err(|e| unsound(e.to_string()))?;
    let Some(kind) = SensorKind::of(&doc.kind) else {
        return Err(unsound(format!("kind \"{}\" is not a kind of sensor", doc.kind)));
    };
    let site_m = place.site_m.map(|site| site.xy());
    let axes = match (kind.radar, site_m) {
        (true, Some(site_m)) => OfflineAxes::Radial(site_m),
        (true, None) => {
            let needed = "a place, as these figures are along and across a radar's sight: \
                          { lat_deg = …, lon_deg = …, height_m = … }";
            return Err(section.missing("site", needed.into()));
        }
        _ => OfflineAxes::NorthEast,
    };
    let axis = |i: usize| AxisFigures { mean_m: doc.mean_m[i], sigma_m: doc.sigma_m[i] };
    let figures = OfflineFit {
        axes: [axis(0), axis(1)],
        correlated_share: doc.correlated_share,
        tau_s: doc.tau_s,
        pd: doc.pd,
        outage_reports: doc.outage_reports,
        period_s: doc.period_s,
        far_share: doc.far_share,
        samples: doc.samples,
    };
    let config = OfflineConfig {
        equipped: equipage(place.equipped),
        axes,
        reach: site_m.zip(doc.reach_m),
        ..OfflineConfig::of(place.id, kind, figures)
    };
    match config.validate() {
        Ok(()) => Ok((config, path)),
        Err(error) => Err(section.refused_by_model("figures", error)),
    }
}
