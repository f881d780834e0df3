//! Plots and tracks as octets for digests and as messages for spectators.

use super::evaluation::Evaluation;
use super::received_truth::View;
use crate::exchange::{ASSOCIATION, TRACKER};
use crate::runtime::messages::{LagMessage, PlotMessage, ScanReport, TrackMessage, TruthMessage};
use models::effects::PlanRow;
use models::frames::Point2;
use models::fusion::{Outcome, Statistics};
use models::plot::{Identity, ON_GROUND_M, Plot};
use models::score::run::Rules;
use models::sensors::{PlotSink, ScanInterval, Truth};
use models::track::{SystemTrack, TrackStatus};

fn append(octets: &mut Vec<u8>, numbers: &[f64]) {
    numbers.iter().for_each(|n| octets.extend_from_slice(&n.to_bits().to_le_bytes()));
}

/// The canonical octets of a plot: every bit of its numbers.
#[must_use]
pub fn plot_octets(plot: &Plot) -> Vec<u8> {
    let mut octets = Vec::with_capacity(128);
    octets.extend_from_slice(&plot.sensor.0.to_le_bytes());
    octets.extend_from_slice(&plot.time.0.to_le_bytes());
    octets.extend_from_slice(&plot.sequence.to_le_bytes());
    append(
        &mut octets,
        &[
            plot.position_m.x,
            plot.position_m.y,
            plot.axis.x,
            plot.axis.y,
            plot.along_m2,
            plot.across_m2,
            plot.altitude_m.unwrap_or(f64::NAN),
            plot.scnr_db.unwrap_or(f64::NAN),
        ],
    );
    octets.extend_from_slice(identity(plot).as_bytes());
    octets
}

/// The canonical octets of a track.
#[must_use]
pub fn track_octets(track: &SystemTrack) -> Vec<u8> {
    let mut octets = Vec::with_capacity(192);
    octets.extend_from_slice(&track.number.to_le_bytes());
    octets.extend_from_slice(&[track.status as u8, u8::from(track.first), track.track_type as u8]);
    octets.extend_from_slice(&track.time.0.to_le_bytes());
    octets.extend_from_slice(&track.last_plot.0.to_le_bytes());
    append(&mut octets, track.position_m.coords.as_slice());
    append(&mut octets, track.velocity_mps.as_slice());
    append(&mut octets, track.acceleration_ms2.as_slice());
    append(&mut octets, track.position_cov_m2.as_slice());
    append(&mut octets, track.velocity_cov_m2s2.as_slice());
    append(&mut octets, &[track.altitude_m.unwrap_or(f64::NAN), track.heading_rad]);
    if let Some(lag) = &track.second_ago {
        octets.extend_from_slice(&lag.time.0.to_le_bytes());
        append(&mut octets, lag.position_m.coords.as_slice());
        append(&mut octets, lag.cov_m2.as_slice());
    }
    if let Some(callsign) = track.callsign() {
        octets.extend_from_slice(callsign.as_str().as_bytes());
    }
    octets
}

fn identity(plot: &Plot) -> String {
    match plot.identity {
        None => String::new(),
        Some(Identity::Callsign(callsign)) => callsign.as_str().to_owned(),
        Some(Identity::Address(address)) => format!("{address:06X}"),
    }
}

/// The address that was reported: a transponder that says a call sign says its address with it.
fn address(view: &View<'_>, entity: Option<usize>, plot: &Plot) -> Option<u32> {
    match plot.identity? {
        Identity::Address(address) => Some(address),
        Identity::Callsign(callsign) => {
            view.address(entity.filter(|index| view.callsign(*index) == callsign)?)
        }
    }
}

/// What a scan report is made of.
pub struct ScanParts<'a> {
    /// Number of the run.
    pub run: u32,
    /// The scan.
    pub interval: &'a ScanInterval,
    /// Truth as received.
    pub view: &'a View<'a>,
    /// Plots with their causes.
    pub sink: &'a PlotSink,
    /// What became of the plots.
    pub outcomes: &'a [Outcome],
    /// Published tracks.
    pub tracks: &'a [SystemTrack],
    /// Measures.
    pub evaluation: &'a Evaluation,
    /// The effect plans of the sensors.
    pub plan: Vec<[String; 5]>,
    /// Wall time of sensors and tracker, µs; measured, and part of no digest.
    pub took_us: u64,
}

/// The message of one scan.
#[must_use]
pub fn scan_report(parts: &ScanParts<'_>) -> ScanReport {
    let view = parts.view;
    let mut followed = vec![None; view.len()];
    for track in parts.tracks.iter().filter(|t| t.status != TrackStatus::Last) {
        // Of an echo of a pulse before the last, kilometres from its target: a false track, as for `seeds score`.
        let near = |(_, distance_m): &(usize, f64)| *distance_m <= Rules::default().pair_m;
        let of = parts.evaluation.truth_of(view, track, parts.interval.to);
        if let Some((index, distance_m)) = of.filter(near) {
            let nearer = |(_, d): &(u16, f64)| distance_m < *d;
            if followed[index].as_ref().is_none_or(nearer) {
                followed[index] = Some((track.number, distance_m));
            }
        }
    }
    let truth = (0..view.len()).filter_map(|i| truth_message(view, i, followed[i])).collect();
    let plots = parts
        .sink
        .plots
        .iter()
        .zip(&parts.sink.causes)
        .zip(parts.outcomes)
        .map(|((plot, cause), outcome)| {
            let entity = cause.key.and_then(|key| view.index_of(key));
            let track = match outcome {
                Outcome::Used { number, .. } => *number,
                _ => None,
            };
            let cov = plot.covariance_m2();
            PlotMessage {
                sensor: plot.sensor.0,
                sequence: plot.sequence,
                kind: plot.kind,
                time_ns: plot.time.0,
                position_m: Point2::new(plot.position_m.x, plot.position_m.y),
                cov_m2: [cov.m11, cov.m12, cov.m22],
                ellipse: [plot.axis.x, plot.axis.y, plot.along_m2, plot.across_m2],
                altitude_m: plot.altitude_m,
                velocity_mps: entity.and_then(|i| reported_velocity_mps(view, i, plot)),
                polar: plot
                    .polar
                    .map(|p| [p.range_m, p.azimuth_rad, p.sigma_range_m, p.sigma_azimuth_rad]),
                scnr_db: plot.scnr_db,
                identity: identity(plot),
                address: address(view, entity, plot),
                cause: entity.map_or_else(String::new, |i| view.callsign(i).as_str().to_owned()),
                truth_m: cause.truth_m,
                track,
                effects: cause
                    .effects
                    .iter()
                    .map(|c| (c.effect.to_owned(), c.value, c.unit.to_owned()))
                    .collect(),
            }
        })
        .collect();
    ScanReport {
        run: parts.run,
        scan: parts.interval.scan,
        time_ns: parts.interval.to.0,
        tracks: parts
            .tracks
            .iter()
            .map(|track| track_message(track, parts.evaluation.lag_error_m(view, track)))
            .collect(),
        plots,
        truth,
        measures: parts.evaluation.values().into_iter().filter(|(_, v)| v.is_finite()).collect(),
        plan: parts.plan.clone(),
        took_us: parts.took_us,
    }
}

/// Velocity as a squitter says it, m/s east and north. On the ground (of a surface position): the speed rounded down to its step (1/8 kt
/// below 1 kt, 1/2 kt to 15 kt, 1 kt to 70 kt), the track to the nearest of 128 directions; standing below 1/8 kt. In the air (velocity
/// over ground, subtype 1): each component to the nearest knot. Source: DO-260B.
fn reported_velocity_mps(view: &View<'_>, index: usize, plot: &Plot) -> Option<[f64; 2]> {
    if plot.kind != models::plot::SensorKind::Adsb {
        return None;
    }
    let velocity = view.at(index, plot.time)?.velocity_mps;
    if plot.altitude_m.is_some_and(|height_m| height_m >= ON_GROUND_M) {
        let told = |mps: f64| libm::round(mps / mode_s::KNOT_MPS) * mode_s::KNOT_MPS;
        return Some([told(velocity.x), told(velocity.y)]);
    }
    let speed_kt = libm::hypot(velocity.x, velocity.y) / mode_s::KNOT_MPS;
    let code = mode_s::movement_code(speed_kt).ok()?;
    let said_mps = mode_s::movement_speed_kt(code)? * mode_s::KNOT_MPS;
    let step = std::f64::consts::TAU / 128.0;
    let track = libm::floor(libm::atan2(velocity.x, velocity.y) / step + 0.5) * step;
    Some([said_mps * libm::sin(track), said_mps * libm::cos(track)])
}

fn truth_message(view: &View<'_>, index: usize, track: Option<(u16, f64)>) -> Option<TruthMessage> {
    let state = view.at(index, view.to())?;
    let (id, class) = (view.id(index), view.class(index));
    Some(TruthMessage {
        id: [id.site, id.application, id.entity],
        callsign: view.callsign(index).as_str().to_owned(),
        address: view.address(index),
        type_designator: class.designator.clone(),
        aircraft: class.aircraft,
        size_m: [class.length_m, class.span_m],
        position_m: state.position_m,
        velocity_mps: state.velocity_mps.into(),
        heading_rad: state.heading_rad,
        ours: view.is_ours(index),
        track,
    })
}

/// A track as the paper's `TrackInfo`.
#[must_use]
pub fn track_message(track: &SystemTrack, lag_error_m: Option<f64>) -> TrackMessage {
    let label = track.label.as_ref();
    let text = |get: fn(&models::track::Label) -> String| label.map(get).unwrap_or_default();
    let (cov, velocity_cov) = (&track.position_cov_m2, &track.velocity_cov_m2s2);
    TrackMessage {
        number: track.number,
        track_type: track.track_type,
        status: track.status,
        first: track.first,
        time_ns: track.time.0,
        position_m: track.position_m,
        velocity_mps: track.velocity_mps.into(),
        cov_m2: [cov.m11, cov.m12, cov.m22],
        acceleration_ms2: track.acceleration_ms2.into(),
        velocity_cov_m2s2: [velocity_cov.m11, velocity_cov.m12, velocity_cov.m22],
        altitude_m: track.altitude_m,
        altitude_ns: track.altitude_at.map(|at| at.0),
        heading_rad: track.heading_rad,
        manoeuvre: track.manoeuvre,
        callsign: track.callsign().map_or_else(String::new, |c| c.as_str().to_owned()),
        type_designator: text(|l| l.type_designator.clone()),
        wake: label.and_then(|l| l.wake),
        movement: label.map(|l| l.movement),
        runway_stand: text(|l| l.runway_stand.clone()),
        ctd_eta_ns: label.map(|l| l.ctd_eta.0),
        routing: label.map(|l| l.routing.clone()).unwrap_or_default(),
        assumed: track.assumed.map_or_else(String::new, |c| c.as_str().to_owned()),
        label_p: track.label_p,
        address: track.address,
        existence_p: track.existence_p,
        unresolved: track.unresolved,
        lag: track.second_ago.map(|lag| LagMessage {
            time_ns: lag.time.0,
            position_m: lag.position_m,
            cov_m2: [lag.cov_m2.m11, lag.cov_m2.m12, lag.cov_m2.m22],
            coasted: lag.coasted,
            error_m: lag_error_m,
        }),
    }
}

/// What joint association did where a cluster was too large for its exact form, and what else the tracker did instead of its plain
/// work or refused, since the run began, for the measures of a scan and of the run; nothing where none was.
pub fn tracker_values(counted: &Statistics) -> Vec<(String, f64)> {
    let association = [
        ("large_clusters", counted.large_clusters),
        ("largest_cluster", counted.largest_cluster),
        ("sweeps", counted.sweeps),
        ("tracks", counted.believed),
        ("certified", counted.certified),
        ("certain", counted.certain),
    ];
    let cut = counted.light_scans + counted.merged_updates > 0;
    let others = [
        ("duplicates", counted.duplicates),
        ("too_late", counted.too_late),
        ("unsound", counted.unsound),
        ("no_room", counted.no_room),
        ("no_number", counted.no_number),
        ("identity_conflicts", counted.identity_conflicts),
        ("label_revisions", counted.label_revisions),
        ("not_positive_definite", counted.not_positive_definite),
        ("crowded", counted.crowded),
        ("paired_by_rank", counted.paired_by_rank),
        ("light_scans", counted.light_scans),
        ("merged_updates", counted.merged_updates),
        // Of the dearest scan, where the budget did not bear it.
        ("most_evaluations", if cut { counted.most_evaluations } else { 0 }),
        ("clock_resets", counted.clock_resets),
    ];
    let association = association.into_iter().filter(|_| counted.large_clusters > 0);
    let others = others.into_iter().filter(|(_, count)| *count > 0);
    let named = |begin: &'static str| {
        move |(name, count): (&str, u64)| (format!("{begin}{name}"), count as f64)
    };
    association.map(named(ASSOCIATION)).chain(others.map(named(TRACKER))).collect()
}

/// A line of the plan: sensor, effect, called for by, bound, decision.
#[must_use]
pub fn plan_line(row: &PlanRow) -> [String; 5] {
    let bound = match row.unit {
        "" => "cannot be told".to_owned(),
        unit if row.bound != 0.0 && row.bound < 1e-3 => format!("{:.1e} {unit}", row.bound),
        unit => format!("{:.3} {unit}", row.bound),
    };
    let decision = if row.is_skipped() {
        "skipped".to_owned()
    } else {
        format!("{:?}, {:.0} ns", row.level, row.cost_ns).to_lowercase()
    };
    [row.sensor.0.to_string(), row.effect.to_owned(), row.called_for.clone(), bound, decision]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// What a run did plainly is not told, all else is, and by a name of its own.
    #[test]
    fn whatever_the_tracker_refused_or_cut_is_told() {
        let plain =
            Statistics { scans: 9, plots: 80, gate_1: 70, late: 2, ..Statistics::default() };
        assert!(tracker_values(&plain).is_empty());
        let counted = Statistics { duplicates: 4, most_evaluations: 900, ..plain };
        assert_eq!(tracker_values(&counted), [("tracker_duplicates".to_owned(), 4.0)]);
        let counted = Statistics {
            too_late: 1,
            unsound: 2,
            no_room: 3,
            no_number: 4,
            identity_conflicts: 5,
            label_revisions: 6,
            not_positive_definite: 7,
            crowded: 8,
            paired_by_rank: 9,
            light_scans: 10,
            merged_updates: 11,
            clock_resets: 12,
            large_clusters: 13,
            ..counted
        };
        let told: BTreeMap<String, f64> = tracker_values(&counted).into_iter().collect();
        let of = |begin: &str| told.keys().filter(|name| name.starts_with(begin)).count();
        assert_eq!((of(TRACKER), of(ASSOCIATION)), (14, 6));
        let sum: f64 = told.values().sum();
        assert_eq!(sum, f64::from((1..=13).sum::<u32>() + 4 + 900));
    }
}
