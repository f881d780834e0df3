//! `seeds picture`: the map of a finished run at a time, drawn without a browser.

use super::open::RUNS;
use crate::exchange::stands::Stands;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use crate::viewer_logger::archive::Archive;
use crate::viewer_logger::drawing::view::{Fit, View};
use crate::viewer_logger::drawing::{Drawing, Shown, png, svg};
use crate::viewer_logger::opened;
use crate::viewer_logger::picture::{AirportMap, RunInfo};
use crate::viewer_logger::said::{Said, Topic};
use crate::viewer_logger::source::Source as _;
use anyhow::{Context, bail, ensure};
use clap::Args;
use models::time::SimTime;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draw the map of a finished run at a time, as the page shows it, without a browser
#[derive(Args, Clone, Debug)]
pub struct PictureArgs {
    /// The run: a folder of runs/ or its name there, its database, or `last`
    #[arg(value_name = "RUN")]
    run: String,

    /// Simulated time, s [default: the end]
    #[arg(long, value_name = "T", value_parser = cli::time, conflicts_with_all = ["from", "to", "every"])]
    at: Option<f64>,

    /// First time of a series, s
    #[arg(long, value_name = "T", value_parser = cli::time, requires_all = ["to", "every"])]
    from: Option<f64>,

    /// Last time of a series, s
    #[arg(long, value_name = "T", value_parser = cli::time, requires = "from")]
    to: Option<f64>,

    /// Step of a series, s
    #[arg(long, value_name = "S", value_parser = cli::seconds, requires = "from")]
    every: Option<f64>,

    /// What is looked at: the page's address from # on (x, y, z, rot, fit, lay, sel, skin, vec, hist, col)
    #[arg(long, value_name = "#…", default_value = "")]
    view: String,

    /// Width and height of the map, pixels
    #[arg(long, value_name = "WxH", default_value = "1600x1000", value_parser = size_of)]
    size: [u16; 2],

    /// Colours: night or day [default: as the view says, else night]
    #[arg(long, value_name = "WORD", value_parser = ["night", "day"])]
    colours: Option<String>,

    /// File to write, .svg or .png; of a series a folder, with .svg or .png behind it for the form: frames.png
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
}

fn size_of(text: &str) -> Result<[u16; 2], String> {
    let bad = || format!("'{text}' is not a size like 1600x1000 (each 64 to 8000)");
    let (w, h) = text.split_once('x').ok_or_else(bad)?;
    let side = |t: &str| t.parse().ok().filter(|n| (64..=8000).contains(n)).ok_or_else(bad);
    Ok([side(w)?, side(h)?])
}

/// Draws and writes.
#[must_use]
pub fn run(args: &PictureArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    let task = match Task::of(args) {
        Ok(task) => task,
        Err(error) => return fail(BAD_INPUT, format!("{error:#}")),
    };
    match task.write(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(FAILED, format!("{error:#}")),
    }
}

/// Everything that a person may have said wrongly, checked.
struct Task {
    archive: Archive,
    info: RunInfo,
    map: AirportMap,
    view: View,
    /// Scans and the files that they go to.
    scans: Vec<(u64, PathBuf)>,
    as_png: bool,
}

impl Task {
    fn of(args: &PictureArgs) -> anyhow::Result<Self> {
        let as_png = match args.out.extension().and_then(|e| e.to_str()) {
            Some("svg") => false,
            Some("png") => true,
            _ => bail!("{}: which form? Name it .svg or .png", args.out.display()),
        };
        let [w, h] = args.size.map(f64::from);
        let mut view = View::new([w, h]);
        view.read(&args.view).map_err(anyhow::Error::msg)?;
        if let Some(colours) = &args.colours {
            view.day = colours == "day";
        }
        let databases = opened::databases(&args.run, Path::new(RUNS))?;
        let database = databases.first().context("no run was named")?;
        let archive = Archive::open(database)?;
        let (info, map) = opened::scene_of(&archive)?;
        let (first, last) = archive.times().with_context(|| {
            format!("{}: holds no scan, so there is nothing to draw", database.display())
        })?;
        let ends_s = [first.s(), last.s()];
        let scan_at = |at_s: f64| archive.at(SimTime::from_s(at_s));
        let scans = match (args.from, args.to, args.every) {
            (Some(from), Some(to), Some(every)) => {
                ensure!(from <= to, "--from {from} is after --to {to}");
                ensure!(every > 0.0, "--every {every} is not a step");
                let count = ((to - from) / every).floor() as usize + 1;
                ensure!(
                    count <= MOST_PICTURES,
                    "{count} pictures: at most {MOST_PICTURES}; choose a longer --every"
                );
                let folder = args.out.with_extension("");
                let form = if as_png { "png" } else { "svg" };
                let times = (0..count).map(|n| from + n as f64 * every);
                let name = |(n, at_s, scan): (usize, f64, u64)| {
                    (scan, folder.join(format!("{n:05}-{at_s:.0}s.{form}")))
                };
                series(times, ends_s, scan_at)?.into_iter().map(name).collect()
            }
            _ => {
                let at_s = args.at.unwrap_or(last.s());
                let scan = scan_at(at_s).with_context(|| none_at(at_s, ends_s))?;
                vec![(scan, args.out.clone())]
            }
        };
        Ok(Self { archive, info, map, view, scans, as_png })
    }

    fn write(&self, args: &PictureArgs) -> anyhow::Result<()> {
        if args.from.is_some()
            && let Some(folder) = self.scans.first().and_then(|s| s.1.parent())
        {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("making the folder {}", folder.display()))?;
        }
        let (weather, said) = (self.archive.weather()?, self.archive.alerts());
        for (scan, file) in &self.scans {
            let drawing = self.drawing(*scan, &weather, &said)?;
            if self.as_png {
                let octets = png::write(&drawing).context("the picture could not be made")?;
                cli::save(file, octets)?;
            } else {
                cli::save(file, svg::write(&drawing))?;
            }
        }
        Ok(())
    }

    fn drawing(
        &self,
        scan: u64,
        weather: &[crate::runtime::messages::WeatherNotice],
        said: &Said,
    ) -> anyhow::Result<Drawing> {
        let report = self.archive.report(scan)?.context("the scan is gone")?;
        // As the page: what control or a stand that was not free gave instead of the planned one.
        let traffic = self.archive.said(Topic::Traffic, report.time_ns);
        let stands = traffic.as_deref().map(Stands::of).unwrap_or_default();
        let report = stands.labelled(&report);
        let trails = self.archive.trails_of(scan)?;
        let mut view = self.view.clone();
        let targets: Vec<[f64; 2]> = report
            .tracks
            .iter()
            .map(|t| t.position_m)
            .chain(report.truth.iter().map(|t| t.position_m.xy()))
            .filter(|p| p.iter().all(|x| x.is_finite() && x.abs() < 1e6))
            .flat_map(|p| [[p.x - 80.0, p.y - 80.0], [p.x + 80.0, p.y + 80.0]])
            .collect();
        match view.fit {
            Fit::Airport => view.camera.fit(&self.map.points(), 44.0),
            Fit::Targets => view.camera.fit(&targets, 80.0),
            Fit::Given => {}
        }
        let time_s = report.time_ns as f64 * 1e-9;
        let caption = format!(
            "{}   T+ {:02}:{:02}   tracks: filled, truth: outline, error: magenta line",
            if self.info.title.is_empty() { &self.info.scene } else { &self.info.title },
            (time_s / 60.0) as u64,
            time_s as u64 % 60
        );
        let (alerts, _) = said.alerts_at(report.time_ns);
        let shown = Shown {
            map: &self.map,
            scan: &report,
            trails: &trails,
            weather: weather.iter().rev().find(|w| w.from_ns <= report.time_ns),
            alerts: &alerts,
            caption: &caption,
        };
        Ok(Drawing::of(&shown, &view))
    }
}

/// The scans of a series with their places and times, s. Where scans were lost there is no picture, which is said, and the series goes on.
fn series(
    times: impl Iterator<Item = f64>,
    ends_s: [f64; 2],
    scan_at: impl Fn(f64) -> Option<u64>,
) -> anyhow::Result<Vec<(usize, f64, u64)>> {
    let mut scans = Vec::new();
    let (mut lost, mut sample) = (0, None);
    for (n, at_s) in times.enumerate() {
        match scan_at(at_s) {
            Some(scan) => scans.push((n, at_s, scan)),
            None if (ends_s[0]..=ends_s[1]).contains(&at_s) => {
                lost += 1;
                sample.get_or_insert(at_s);
            }
            None => bail!(none_at(at_s, ends_s)),
        }
    }
    if let Some(first_s) = sample {
        ensure!(!scans.is_empty(), none_at(first_s, ends_s));
        tracing::warn!("{lost} pictures are left out: {}", none_at(first_s, ends_s));
    }
    Ok(scans)
}

/// Why there is no picture at a time.
fn none_at(at_s: f64, ends_s: [f64; 2]) -> String {
    let [first, last] = ends_s.map(|s| (1e3 * s).round() / 1e3);
    if (ends_s[0]..=ends_s[1]).contains(&at_s) {
        return format!("there is no picture at {at_s} s: scans were lost there");
    }
    format!("there is no picture at {at_s} s: the run lasts from {first} to {last} s")
}

/// Pictures of one series, at most.
const MOST_PICTURES: usize = 100_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_goes_on_where_scans_were_lost() {
        // Scans at whole seconds, 4 to 6 lost.
        let at =
            |s: f64| (!(4.0..7.0).contains(&s)).then_some(s as u64).filter(|n| (1..=9).contains(n));
        let of = |from: u32, to: u32| series((from..=to).map(f64::from), [1.0, 9.0], at);
        let scans = of(2, 8).expect("some");
        assert_eq!(scans.iter().map(|s| s.2).collect::<Vec<_>>(), [2, 3, 7, 8]);
        assert_eq!(scans[2], (5, 7.0, 7), "named by its place in the series");
        let none = of(4, 5).expect_err("none").to_string();
        assert_eq!(none, "there is no picture at 4 s: scans were lost there");
        let beyond = of(8, 12).expect_err("beyond").to_string();
        assert_eq!(beyond, "there is no picture at 10 s: the run lasts from 1 to 9 s");
    }
}
