//! The radar effect by effect and level by level, each against everything exact.

use crate::clock::thread_ns;
use crate::effects::{RadarStudy, named_scenes};
use crate::measure::{Errors, median_and_p99};
use crate::{Draws, Ladder, Options, Outcome, Progress, Row, SceneAbout};
use models::effects::{Level, Tolerance};
use models::sensors::asde::Asde;
use models::sensors::radar::effects::RadarEffect;
use models::sensors::radar::levels::RadarLevels;
use models::sensors::{PlotSink, Sensor};

/// A whole radar: its levels, or none for planned ones.
type Rung = (&'static str, Option<RadarLevels>);

fn all_at(level: Level) -> RadarLevels {
    compared().fold(RadarLevels::EXACT, |levels, effect| levels.with(effect, level))
}

/// Every effect but the processing of the echoes: plots of closed forms, of cells and of the video draw
/// noise of their own, so a distance between them says nothing of a level.
fn compared() -> impl Iterator<Item = RadarEffect> {
    RadarEffect::ALL.iter().copied().filter(|effect| *effect != RadarEffect::Processing)
}

fn rungs() -> [Rung; 5] {
    [
        ("nothing", Some(all_at(Level::Skipped))),
        ("cheap", Some(all_at(Level::Cheap))),
        ("middle", Some(all_at(Level::Middle))),
        ("planned", None),
        ("exact", Some(RadarLevels::EXACT)),
    ]
}

/// The levels of one effect that differ from the next cheaper one.
fn levels_of(effect: RadarEffect) -> Vec<Level> {
    let mut found: Vec<Level> = Vec::new();
    for level in [Level::Skipped, Level::Cheap, Level::Middle, Level::Exact] {
        let now = RadarLevels::EXACT.with(effect, level);
        if found.last().is_none_or(|before| RadarLevels::EXACT.with(effect, *before) != now) {
            found.push(level);
        }
    }
    found
}

struct Played {
    /// (key, scan, position), sorted.
    plots: Vec<(u64, u64, models::frames::Point2<f64>)>,
    looks: u64,
    /// Time of a scan per look, ns.
    times: Vec<f64>,
}

fn play(study: &RadarStudy, levels: Option<RadarLevels>, scans: u64) -> Result<Played, String> {
    let mut radar: Asde = match levels {
        Some(levels) => study.radar()?.at_levels(levels),
        None => study.radar()?.tolerating(Tolerance::default()),
    };
    let mut played = Played { plots: Vec::new(), looks: 0, times: Vec::new() };
    for scan in 1..=scans {
        let mut sink = PlotSink::default();
        let begin = thread_ns();
        radar.scan(&crate::effects::interval(scan), &study.truth, &study.weather, &mut sink);
        let ns = (thread_ns() - begin) as f64;
        // The first scan makes tables and the plan.
        if scan > 1 && sink.looks > 0 {
            played.times.push(ns / sink.looks as f64);
        }
        played.looks += sink.looks;
        let seen = sink.plots.iter().zip(&sink.causes);
        played.plots.extend(seen.filter_map(|(p, c)| Some((c.key?, scan, p.position_m))));
    }
    played.plots.sort_by_key(|p| (p.0, p.1));
    Ok(played)
}

fn row(scene: &str, rung: &str, played: &mut Played, exact: &Played) -> Row {
    let (mut errors, mut only_one) = (Errors::default(), 0u64);
    let (mut a, mut b) = (played.plots.iter().peekable(), exact.plots.iter().peekable());
    while let (Some(one), Some(other)) = (a.peek(), b.peek()) {
        match (one.0, one.1).cmp(&(other.0, other.1)) {
            std::cmp::Ordering::Equal => {
                errors.add((one.2 - other.2).norm());
                a.next();
                b.next();
            }
            std::cmp::Ordering::Less => {
                only_one += 1;
                a.next();
            }
            std::cmp::Ordering::Greater => {
                only_one += 1;
                b.next();
            }
        }
    }
    only_one += (a.count() + b.count()) as u64;
    let (ns_per_update, ns_p99) = median_and_p99(&mut played.times);
    Row {
        group: "sensors".into(),
        scene: scene.into(),
        rung: rung.into(),
        rmse_m: errors.rms(),
        p95_m: errors.p95(),
        ns_per_update,
        ns_p99,
        error: Some(100.0 * only_one as f64 / played.looks.max(1) as f64),
        error_unit: Some("% of looks that only one of the two detects".into()),
        ..Row::default()
    }
}

/// Measures the ladder.
pub(crate) fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let scans = if options.quick { 12 } else { 60 };
    let (mut rows, mut scenes) = (Vec::new(), Vec::new());
    match named_scenes(options.seed) {
        Err(error) => rows.push(Row {
            group: "sensors".into(),
            failed: vec![error.to_string()],
            ..Row::default()
        }),
        Ok(studies) => {
            let effects = compared().count();
            let total = studies.len() + effects;
            let mut done = 0;
            for study in &studies {
                if let Err(error) = whole(study, scans, &mut rows) {
                    rows.push(failure(&study.name, error));
                }
                let about = "everything at one level, on the same draws".into();
                scenes.push(SceneAbout { name: study.name.clone(), about });
                done += 1;
                progress(Progress { group: "sensors", what: study.name.clone(), done, total });
            }
            // Effect by effect where most of them matter: a storm over aircraft among buildings.
            if let Some(study) = studies.last() {
                for effect in compared() {
                    if let Err(error) = single(study, effect, scans, &mut rows) {
                        rows.push(failure(effect.name(), error));
                    }
                    done += 1;
                    progress(Progress {
                        group: "sensors",
                        what: effect.name().into(),
                        done,
                        total,
                    });
                }
            }
        }
    }
    // The richest scene first: it is the one that the closing sentence is about.
    scenes.reverse();
    let ladder = Ladder {
        group: "sensors".into(),
        title: "The surveillance radar: every effect at every level".into(),
        about: "The same looks at the same targets with the same draws; the error is the distance of a plot \
                from that of the radar with every effect at its most exact level. \"Planned\" lets the scene \
                choose (0.1 m rms, 1 % of detection). After the scenes the table takes one effect at a time to \
                each of its levels, everything else exact, in the first scene shown. Detection differs too: that \
                share stands in the last column. Time is one look of the whole radar."
            .into(),
        error_label: "distance from the exact radar's plot, m (rms)".into(),
        draws: Draws::Position,
        scenes,
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

fn failure(scene: &str, error: String) -> Row {
    Row { group: "sensors".into(), scene: scene.into(), failed: vec![error], ..Row::default() }
}

fn whole(study: &RadarStudy, scans: u64, rows: &mut Vec<Row>) -> Result<(), String> {
    let exact = play(study, Some(RadarLevels::EXACT), scans)?;
    for (name, levels) in rungs() {
        rows.push(row(&study.name, name, &mut play(study, levels, scans)?, &exact));
    }
    Ok(())
}

fn single(
    study: &RadarStudy,
    effect: RadarEffect,
    scans: u64,
    rows: &mut Vec<Row>,
) -> Result<(), String> {
    let exact = play(study, Some(RadarLevels::EXACT), scans)?;
    for level in levels_of(effect) {
        let levels = RadarLevels::EXACT.with(effect, level);
        let mut played = play(study, Some(levels), scans)?;
        rows.push(row(&format!("only {}", effect.name()), level.name(), &mut played, &exact));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_level_differs_in_nothing_and_nothing_at_all_in_much() {
        let studies = named_scenes(3).expect("sets ship");
        let storm = studies.iter().find(|s| s.name.contains("storm")).expect("there");
        let mut rows = Vec::new();
        whole(storm, 6, &mut rows).expect("sound");
        let of = |rung: &str| rows.iter().find(|r| r.rung == rung).expect("measured");
        assert_eq!((of("exact").rmse_m, of("exact").error), (Some(0.0), Some(0.0)));
        assert!(of("nothing").error.expect("share") > 1.0);
        assert!(of("planned").rmse_m.expect("plots") <= 0.5);
        assert!(of("middle").rmse_m <= of("nothing").rmse_m);
    }

    #[test]
    fn every_effect_has_a_level_to_compare() {
        for effect in compared() {
            let levels = levels_of(effect);
            assert!(levels.len() >= 2, "{}: {levels:?}", effect.name());
        }
    }
}
