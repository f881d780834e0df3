//! `seeds accuracy --only load`: what a federation costs against the number of movers, with one traffic generator and with
//! four, in processes and in real time, as its own statistics say.

mod run;
mod scene;

use run::Measured;
use scene::Moves;
use std::path::Path;
use studies::plot::{Chart, Line};
use studies::{Draws, Ladder, Options, Outcome, Progress, Report, Row};

/// Name of the group.
pub const GROUP: &str = "load";

/// Traffic generators of a run: centralised, and distributed.
const LAYOUTS: [u32; 2] = [1, 4];

const ABOUT: &str = "Each row is a run of 30 s in real time with a process for each federate, on a grid of taxiways with a mover every \
60 m. cores: processor seconds per simulated second of all federates together, from 3 s after the start on. PDU/s: of all \
generators. latency: from a grant to the frame end of the slowest generator, smoothed. A row fails where the run did not keep real \
time, or where a PDU did not arrive by itself.";

/// Measures, with scenes written into `folder`.
///
/// # Errors
/// If a scene cannot be written or a run does not go.
pub fn study(
    options: &Options,
    folder: &Path,
    progress: &mut dyn FnMut(Progress),
) -> anyhow::Result<Report> {
    let sizes: &[usize] =
        if options.quick { &[100, 1_000] } else { &[100, 300, 1_000, 3_000, 10_000] };
    let (seconds, total) = (30.0, sizes.len() * 2 * LAYOUTS.len());
    let mut all: Vec<(Moves, Measured)> = Vec::new();
    for moves in [Moves::All, Moves::OneInTen] {
        for count in sizes {
            let file = scene::write(folder, *count, moves, seconds)?;
            for generators in LAYOUTS {
                let what = format!("{count} movers, {}, {generators} generators", moves.word());
                all.push((moves, run::measure(&file, *count, generators)?));
                progress(Progress { group: GROUP, what, done: all.len(), total });
            }
        }
    }
    let outcome = Outcome {
        ladder: Ladder {
            group: GROUP.into(),
            title: "What a federation costs, by the number of movers".into(),
            about: ABOUT.into(),
            error_label: "cores".into(),
            draws: Draws::Other,
            unit: "cores".into(),
            cost_label: Some("PDU/s".into()),
            ..Ladder::default()
        },
        rows: all.iter().map(|(moves, measured)| row(*moves, measured)).collect(),
        pictures: pictures(&all),
        ..Outcome::default()
    };
    let Options { machine, commit, seed, quick, .. } = options.clone();
    Ok(Report { machine, commit, seed, quick, budget: None, outcomes: vec![outcome] })
}

fn layout(generators: u32) -> String {
    if generators == 1 { "one generator".to_owned() } else { format!("{generators} generators") }
}

fn row(moves: Moves, measured: &Measured) -> Row {
    let mut failed = Vec::new();
    if measured.rate < 0.99 {
        failed.push(format!("{:.2} of real time", measured.rate));
    }
    if measured.lost > 0 {
        failed.push(format!("{} PDUs were repaired", measured.lost));
    }
    Row {
        group: GROUP.into(),
        scene: format!("{} movers, {}", measured.movers, moves.word()),
        rung: layout(measured.generators),
        error: Some(measured.cores()),
        error_unit: Some("cores".into()),
        cost: Some(measured.pdus_per_s),
        cost_unit: Some("PDU/s".into()),
        ns_per_update: Some(measured.latency_us * 1e3),
        failed,
        ..Row::default()
    }
}

/// A figure of a run that is drawn.
type Figure = fn(&Measured) -> f64;

fn pictures(all: &[(Moves, Measured)]) -> Vec<String> {
    let figures: [(&str, &str, Figure); 5] = [
        ("Processor time of all federates", "cores", Measured::cores),
        ("Processor time of the traffic generators", "cores", |m| m.of("traffic-generator")),
        ("Processor time of the SMDFM", "cores", |m| m.of("smdfm")),
        ("PDUs sent", "PDU/s", |m| m.pdus_per_s),
        ("From a grant to the frame end of the slowest generator", "ms", |m| m.latency_us * 1e-3),
    ];
    let chart = |(title, y_name, figure): (&str, &str, Figure)| {
        let mut lines = Vec::new();
        for moves in [Moves::All, Moves::OneInTen] {
            for generators in LAYOUTS {
                let of = |(m, r): &&(Moves, Measured)| *m == moves && r.generators == generators;
                let points = all.iter().filter(of).map(|(_, r)| (r.movers as f64, figure(r)));
                lines.push(Line {
                    name: format!("{}, {}", moves.word(), layout(generators)),
                    points: points.collect(),
                    dashed: generators > 1,
                });
            }
        }
        let (title, y_name) = (title.to_owned(), y_name.to_owned());
        Chart { title, x_name: "movers".to_owned(), y_name, lines }.svg()
    };
    figures.into_iter().map(chart).collect()
}
