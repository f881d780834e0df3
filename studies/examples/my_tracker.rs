//! Somebody's own tracker on the plots of our sensors, scored as ours is.
//!
//! `cargo run --release -p studies --example my_tracker [SCENE] [SECONDS]`
//!
//! The sensors of the scene look at its movements; what they see is a list of plots a scan. Whatever makes reports of them is
//! a tracker: here thirty lines of alpha-beta filters with the nearest plot. `studies::score` holds its reports against the
//! truth, area by area and target by target; ours stands beside it. To replace only a part of ours, see
//! `models::fusion::own`.

use models::frames::{Point2, Vector2};
use models::plot::{Plot, SensorKind};
use models::score::areas::{AreaMap, AreaRules};
use models::score::recording::{Recording, Report};
use models::score::run::{Rules, Score, score};
use models::time::SimTime;
use std::process::ExitCode;

/// A target as this tracker knows it.
struct Mine {
    number: u64,
    position_m: Point2<f64>,
    velocity_mps: Vector2<f64>,
    time: SimTime,
    plots: u32,
}

/// All of them.
#[derive(Default)]
struct MyTracker {
    tracks: Vec<Mine>,
    next: u64,
}

/// Farther off than this a plot is of another target, m.
const GATE_M: f64 = 40.0;
/// Share of what a plot says that is taken, of the position and of the velocity.
const GAINS: (f64, f64) = (0.5, 0.2);
/// A track without plots for this long ends, s.
const PATIENCE_S: f64 = 5.0;

impl MyTracker {
    /// One scan: plots in the order of their times, reports at its end.
    fn scan(&mut self, to: SimTime, plots: &[Plot]) -> Vec<Report> {
        let mut plots: Vec<&Plot> = plots.iter().filter(|p| p.kind == SensorKind::Asde).collect();
        plots.sort_by_key(|p| (p.time, p.sequence));
        for plot in plots {
            let off = |t: &Mine| {
                let at = t.position_m + t.velocity_mps * plot.time.since_s(t.time);
                (plot.position_m - at).norm()
            };
            let near = self.tracks.iter_mut().min_by(|a, b| off(a).total_cmp(&off(b)));
            match near.filter(|t| off(t) < GATE_M && plot.time > t.time) {
                Some(track) => {
                    let dt_s = plot.time.since_s(track.time);
                    let at = track.position_m + track.velocity_mps * dt_s;
                    let nu = plot.position_m - at;
                    // The second plot is the first that tells a speed.
                    let beta = if track.plots == 1 { 1.0 } else { GAINS.1 };
                    track.position_m = at + nu * GAINS.0;
                    track.velocity_mps += nu * (beta / dt_s.max(0.5));
                    (track.time, track.plots) = (plot.time, track.plots + 1);
                }
                None => {
                    let (position_m, time) = (plot.position_m, plot.time);
                    let velocity_mps = Vector2::zeros();
                    let number = self.next;
                    self.tracks.push(Mine { number, position_m, velocity_mps, time, plots: 1 });
                    self.next += 1;
                }
            }
        }
        self.tracks.retain(|t| to.since_s(t.time) < PATIENCE_S);
        let known = self.tracks.iter().filter(|t| t.plots >= 3);
        let report = |t: &Mine| Report {
            track: t.number,
            time: to,
            published: Some(to),
            position_m: t.position_m + t.velocity_mps * to.since_s(t.time),
            velocity_mps: Some(t.velocity_mps),
            label: String::new(),
        };
        known.map(report).collect()
    }
}

fn scored(scene: &scenarios::Scene, seconds: f64) -> Result<[(&'static str, Score); 2], String> {
    let seen = studies::profiles::see(scene, scene.run.seed, seconds)?;
    let mut mine = MyTracker::default();
    let own: Vec<Report> =
        seen.scans.iter().flat_map(|(to, plots)| mine.scan(*to, plots)).collect();
    let (ours, _) = studies::profiles::track(&seen, &scene.tracking_config(), &scene.flight_list);
    let areas = AreaMap::of(&scene.airport.layout, AreaRules::default());
    let of = |reports: Vec<Report>| {
        let targets = studies::profiles::targets(scene, seconds);
        let mut recording = Recording { targets, reports, plots: seen.radar };
        recording.put_in_order();
        score(&recording, &areas, &Rules::default())
    };
    Ok([("mine", of(own)), ("seeds", of(ours))])
}

#[expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks")]
fn main() -> ExitCode {
    let mut args = std::env::args().skip(1);
    let name = args.next().unwrap_or_else(|| "zurich".to_owned());
    let seconds = args.next().and_then(|s| s.parse().ok()).unwrap_or(600.0);
    let scene = match scenarios::load(&scenarios::locate(&name)) {
        Ok(scene) => scene,
        Err(e) => {
            eprintln!("{e}");
            return ExitCode::FAILURE;
        }
    };
    match scored(&scene, seconds) {
        Ok(both) => {
            println!("tracker  rms m  tracks  false  swaps  breaks  missed targets");
            for (name, s) in both {
                let rms = s.rmse_m().unwrap_or(f64::NAN);
                let missed = s.missed_targets();
                println!(
                    "{name:7} {rms:6.2} {:7} {:6} {:6} {:7} {missed:7}",
                    s.tracks, s.false_tracks, s.swaps, s.breaks
                );
            }
            ExitCode::SUCCESS
        }
        Err(e) => {
            eprintln!("{e}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn somebodys_tracker_follows_every_target_and_ours_is_nearer() {
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("ships");
        let [(_, mine), (_, ours)] = scored(&scene, 120.0).expect("sound");
        assert_eq!((mine.missed_targets(), ours.missed_targets()), (0, 0));
        let (mine, ours) = (mine.rmse_m().expect("tracks"), ours.rmse_m().expect("tracks"));
        assert!(mine < 10.0 && ours < mine, "{mine} m, ours {ours} m");
    }
}
