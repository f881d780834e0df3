//! `seeds plan SCENE --advice`: what another sensor would gain, by running the scene with it.
//!
//! All sensors of the menu look at one run (their draws are keyed by sensor, so a set sees what it would see alone); each set is
//! tracked by itself and held against the requirements of A-SMGCS surveillance.

use crate::chain::{publish_of, scored_of};
use crate::movers::Movers;
use crate::profiles::{Seen, see_of};
use crate::{Table, clock, requirements, zurich};
use models::plot::{Plot, SensorId};
use scenarios::{AirportScene, Scene, control};
use std::fmt::Write;
use std::path::Path;

/// One choice: what is added to the scene's own sensors, and what came of it, the mean over the seeds.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// What is added; empty: the scene as it is.
    pub added: Vec<&'static str>,
    /// Requirement rows that are met, and those that could be judged.
    pub met: [f64; 2],
    /// Rows that are not met with any seed: their names.
    pub unmet: Vec<String>,
    /// Root mean square error of the published positions, m.
    pub rmse_m: f64,
    /// Processor time of a scan, tracker alone, µs.
    pub us_per_scan: f64,
}

impl Choice {
    /// In words.
    #[must_use]
    pub fn name(&self) -> String {
        if self.added.is_empty() { "as it is".into() } else { self.added.join(" + ") }
    }
}

/// What could be added, and what came of it.
#[derive(Clone, Debug, Default)]
pub struct Advice {
    /// The scene as it is first, then the others, best first.
    pub choices: Vec<Choice>,
    /// What could not be added to this scene, and why.
    pub refused: Vec<String>,
    /// Simulated seconds of each run, and seeds.
    pub seconds: f64,
    /// Seeds of the runs.
    pub seeds: Vec<u64>,
}

/// A sensor of the menu.
struct Item {
    /// In words.
    words: &'static str,
    /// Its name in the scene.
    name: &'static str,
    /// Its `[[sensor]]` table.
    table: String,
}

fn menu(scene: &Scene) -> [Item; 3] {
    let AirportScene { layout, radius_m, .. } = &scene.airport;
    let radar = scene.sensors.iter().find(|s| s.asde.is_some()).and_then(|s| s.site_m);
    let first_m = radar.map_or([0.0, 0.0], |at| [at.x, at.y]);
    let item =
        |words, name, table: &dyn Fn(&str) -> String| Item { words, name, table: table(name) };
    [
        item("a second radar", "advice radar", &|name| {
            control::second_radar(name, layout, first_m)
        }),
        item("ADS-B on all", "advice ADS-B", &|name| {
            format!("[[sensor]]\nkind = \"adsb\"\nname = \"{name}\"\nequipped = 1.0\n")
        }),
        item("multilateration", "advice MLAT", &|name| {
            control::multilateration(name, layout, *radius_m)
        }),
    ]
}

/// Whether a text of TOML has a table of this head ("[[sensor]]"), not only in a remark.
fn has_table(text: &str, head: &str) -> bool {
    text.lines().any(|line| line.trim_start().starts_with(head))
}

/// Runs a scene (its file and text) with every set of the menu, at most so many seconds each; `tell` is given what is done.
///
/// # Errors
/// One sentence if the scene is refused, or a sensor of its own cannot be made.
pub fn advise(
    file: &Path,
    text: &str,
    most_s: f64,
    seeds: &[u64],
    tell: &mut dyn FnMut(String),
) -> Result<Advice, String> {
    let load = |text: &str| scenarios::load_text(file, text).map_err(|e| e.to_string());
    let own = load(text)?;
    let mut whole = text.to_owned();
    // What a scene that names no sensors is watched by would go with the first that is added.
    if !has_table(text, "[[sensor]]") && !own.sensors.is_empty() {
        let _ = write!(
            whole,
            "\n{}",
            control::standard_sensors(&own.airport.layout, own.airport.radius_m)
        );
        if !has_table(text, "[tracking]") {
            whole.push_str("[tracking]\nprofile = \"accurate\"\n");
        }
    }
    let seconds = own.run.duration.s().min(most_s);
    let mut advice = Advice { seconds, seeds: seeds.to_vec(), ..Advice::default() };
    let mut items: Vec<Item> = Vec::new();
    for item in menu(&own) {
        let with = format!("{whole}\n{}", item.table);
        match load(&with) {
            Ok(_) => {
                whole = with;
                items.push(item);
            }
            Err(e) => advice.refused.push(format!("{}: {e}", item.words)),
        }
    }
    let mut choices: Vec<Choice> = (0..1_usize << items.len())
        .map(|set| {
            let of = |k: &usize| set >> k & 1 == 1;
            Choice {
                added: (0..items.len()).filter(of).map(|k| items[k].words).collect(),
                ..Choice::default()
            }
        })
        .collect();
    let mut failed: Vec<Vec<Vec<String>>> = vec![Vec::new(); choices.len()];
    for seed in seeds {
        let with_seed = scenarios::vary::with_key(&whole, "run.seed", &seed.to_string())?;
        let scene = load(&with_seed)?;
        let movers = Movers::drive(&scene, seconds);
        tell(format!("seed {seed}: sensors"));
        let seen = see_of(&movers, &scene, zurich::sensors(&scene)?, *seed, seconds);
        let config = scene.tracking_config();
        for (set, choice) in choices.iter_mut().enumerate() {
            tell(format!("seed {seed}: {}", choice.name()));
            let out = |name: &str| {
                items.iter().enumerate().any(|(k, item)| item.name == name && set >> k & 1 == 0)
            };
            let used: Vec<SensorId> =
                scene.sensors.iter().filter(|s| !out(&s.name)).map(|s| s.id).collect();
            let part = subset(&seen, &used);
            let mut config = config.clone();
            config.sensors.retain(|model| used.contains(&model.id));
            let begin = clock::thread_ns();
            let published = publish_of(&movers, &part, &config, &scene.flight_list);
            let ns = (clock::thread_ns() - begin) as f64;
            let score = scored_of(&movers, &scene, &part, &published, seconds);
            let verdicts: Vec<_> = requirements::all().iter().map(|r| r.judge(&score)).collect();
            let judged = verdicts.iter().filter(|v| v.met.is_some()).count() as f64;
            let met = verdicts.iter().filter(|v| v.met == Some(true)).count() as f64;
            let share = 1.0 / seeds.len() as f64;
            choice.met[0] += share * met;
            choice.met[1] += share * judged;
            choice.rmse_m += share * published.all.rmse_m();
            choice.us_per_scan += share * ns * 1e-3 / part.scans.len().max(1) as f64;
            let not = verdicts.iter().filter(|v| v.met == Some(false));
            let name = |v: &models::score::requirements::Verdict| {
                let r = &v.requirement;
                format!("{} {}: {}", r.standard, r.area, r.name)
            };
            failed[set].push(not.map(name).collect());
        }
    }
    for (choice, failed) in choices.iter_mut().zip(failed) {
        let always = |row: &&String| failed.iter().all(|of| of.contains(row));
        choice.unmet = failed.first().into_iter().flatten().filter(always).cloned().collect();
    }
    choices[1..].sort_by(|a, b| b.met[0].total_cmp(&a.met[0]).then(a.rmse_m.total_cmp(&b.rmse_m)));
    advice.choices = choices;
    Ok(advice)
}

/// What some of the sensors saw.
fn subset(seen: &Seen, used: &[SensorId]) -> Seen {
    let mut part = Seen { radar: seen.radar, ..Seen::default() };
    for ((at, plots), causes) in seen.scans.iter().zip(&seen.causes) {
        let both = plots.iter().zip(causes).filter(|(p, _)| used.contains(&p.sensor));
        let (plots, causes): (Vec<Plot>, Vec<Option<u64>>) = both.map(|(p, c)| (*p, *c)).unzip();
        part.scans.push((*at, plots));
        part.causes.push(causes);
    }
    part
}

impl Advice {
    /// One row a choice.
    #[must_use]
    pub fn table(&self) -> Table {
        let heads = ["added", "met", "judged", "gained", "rmse_m", "tracker_us_per_scan", "unmet"];
        let first = self.choices.first().map_or(0.0, |c| c.met[0]);
        let row = |c: &Choice| {
            vec![
                c.name(),
                format!("{:.1}", c.met[0]),
                format!("{:.1}", c.met[1]),
                format!("{:+.1}", c.met[0] - first),
                format!("{:.2}", c.rmse_m),
                format!("{:.0}", c.us_per_scan),
                c.unmet.join("; "),
            ]
        };
        Table {
            name: "advice".into(),
            title: "What another sensor would gain".into(),
            heads: heads.map(str::to_owned).to_vec(),
            rows: self.choices.iter().map(row).collect(),
        }
    }

    /// For a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut out = format!(
            "What another sensor would gain: {:.0} s, seeds {:?}, rows of A-SMGCS requirements that are met (mean)\n\n{:48} {:>6} {:>7} {:>7} {:>9} {:>14}\n",
            self.seconds, self.seeds, "added", "met", "of", "gained", "error", "tracker"
        );
        let first = self.choices.first().map_or(0.0, |c| c.met[0]);
        for c in &self.choices {
            let _ = writeln!(
                out,
                "{:48} {:>6.1} {:>7.1} {:>+7.1} {:>7.2} m {:>8.0} µs/scan",
                c.name(),
                c.met[0],
                c.met[1],
                c.met[0] - first,
                c.rmse_m,
                c.us_per_scan
            );
        }
        let never = |row: &&String| self.choices.iter().all(|c| c.unmet.contains(row));
        let base = self.choices.first().map(|c| c.unmet.as_slice()).unwrap_or_default();
        let never: Vec<&String> = base.iter().filter(never).collect();
        if !never.is_empty() {
            out.push_str("\nmet by none of these sets:\n");
            never.iter().for_each(|row| out.push_str(&format!("  {row}\n")));
        }
        for refused in &self.refused {
            let _ = writeln!(out, "\nnot tried: {refused}");
        }
        out.push_str(
            "\nSites are assumed: the radar mirrored about the middle of the ground network, eight receivers around it. The error is that of all that is published: a set that sees farther out publishes more. Prices are yours to add.\n",
        );
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A set of sensors sees and publishes what a run with these alone does, and more sensors meet more.
    #[test]
    fn a_set_of_the_menu_is_the_run_with_it_and_more_sensors_meet_more() {
        let file = scenarios::locate("zurich");
        let text = scenarios::text_of(&file).expect("ships");
        let advice = advise(&file, &text, 120.0, &[5], &mut |_| ()).expect("runs");
        assert!(advice.refused.is_empty(), "{:?}", advice.refused);
        assert_eq!(advice.choices.len(), 8);
        let of = |name: &str| advice.choices.iter().find(|c| c.name() == name).expect(name);
        let (bare, all) = (of("as it is"), of("a second radar + ADS-B on all + multilateration"));
        assert!(all.met[0] >= bare.met[0] + 3.0, "{} {}", bare.met[0], all.met[0]);
        assert!(all.rmse_m < 0.8 * bare.rmse_m, "{} {}", bare.rmse_m, all.rmse_m);
        // The scene alone, run by itself.
        let with_seed = scenarios::vary::with_key(&text, "run.seed", "5").expect("a key");
        let scene = scenarios::load_text(&file, &with_seed).expect("loads");
        let movers = Movers::drive(&scene, 120.0);
        let seen = see_of(&movers, &scene, zurich::sensors(&scene).expect("made"), 5, 120.0);
        let alone = publish_of(&movers, &seen, &scene.tracking_config(), &scene.flight_list);
        assert_eq!(alone.all.rmse_m().to_bits(), bare.rmse_m.to_bits());
    }
}
