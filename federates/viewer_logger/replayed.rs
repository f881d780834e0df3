//! The dial on a finished run: what the other rungs, or other tolerances of the effect plan, would give for the scans before the time shown.
//!
//! Plots and truth are in the database, so what runs beside a live run ([`Beside`], [`tolerances`](super::tolerances)) is fed with stored
//! scans: of two minutes before the time shown, one in which tracks form and one that is judged. Who goes on in time goes on with the
//! same trackers; who jumps begins anew. A thread with its own view of the file does it, scan by scan; each scan it may be told
//! something else, and it ends with its owner, which is how it is cancelled.

use super::archive::Archive;
use super::beside::Beside;
use super::kept_scene;
use super::source::{ScanSums, Source as _};
use super::tolerances::{Chains, Work};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::messages::{ScanReport, TruthMessage};
use anyhow::{Context as _, bail, ensure};
use crossbeam_channel::{Receiver, Sender, TryRecvError, unbounded};
use models::flight_list::FlightList;
use models::time::SimTime;
use scenarios::Scene;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is compared, and whose tracks are wanted beside the run's own.
#[derive(Clone, Debug, PartialEq)]
pub enum Compared {
    /// The rungs of the filter ladder; the ghost by name.
    Rungs(Option<String>),
    /// Tolerances of the effect plan; the ghost by its distance, m.
    Tolerances(Option<f64>),
}

/// What is to be shown.
#[derive(Clone, Debug, PartialEq)]
struct Wish {
    scan: u64,
    compared: Compared,
}

/// A comparison on a finished run. Dropping it ends its thread.
#[derive(Debug)]
pub struct Replayed {
    wishes: Sender<Wish>,
    last: Wish,
}

impl Replayed {
    /// Begins with the scan shown. `tell` is called on a thread of its own with messages for the page: `rungs` or `tolerances` as
    /// of a live run, with `done`, the share of the way there, and rows only at its end.
    ///
    /// # Errors
    /// If no thread can be started.
    pub fn begin(
        database: PathBuf,
        scan: u64,
        compared: Compared,
        tell: impl Fn(Value) + Send + 'static,
    ) -> std::io::Result<Self> {
        let (wishes, heard) = unbounded();
        let last = Wish { scan, compared };
        let first = last.clone();
        let work = move || {
            let of = first.compared.clone();
            if let Err(why) = follow(&database, first, &heard, &tell) {
                tell(of.message(json!({"rows": [], "why_not": format!("{why:#}"), "done": 1.0})));
            }
        };
        std::thread::Builder::new().name("dial".to_owned()).spawn(work)?;
        Ok(Self { wishes, last })
    }

    /// Another scan is shown.
    pub fn show(&mut self, scan: u64) {
        self.wish(Wish { scan, ..self.last.clone() });
    }

    /// Somebody else's tracks are wanted beside the run's own.
    pub fn ghost(&mut self, compared: Compared) {
        self.wish(Wish { compared, ..self.last.clone() });
    }

    fn wish(&mut self, wish: Wish) {
        if wish != self.last {
            self.wishes.send(wish.clone()).ok(); // who has ended has said why
            self.last = wish;
        }
    }
}

impl Compared {
    /// A message for the page.
    fn message(&self, mut about: Value) -> Value {
        let kind = match self {
            Self::Rungs(_) => "rungs",
            Self::Tolerances(_) => "tolerances",
        };
        about["type"] = kind.into();
        about["comparing"] = true.into();
        about
    }
}

/// What is compared, as far as it has come.
enum Side {
    Rungs(Box<Beside>),
    Tolerances(Box<Chains>, Option<(SimTime, Vec<TruthMessage>)>),
}

impl Side {
    fn new(compared: &Compared, scene: &Arc<Scene>, seed: u64) -> anyhow::Result<Self> {
        Ok(match compared {
            Compared::Rungs(_) => {
                Self::Rungs(Box::new(Beside::unhurried(&scene.tracking_config())))
            }
            Compared::Tolerances(_) => {
                let chains = Chains::new(Arc::clone(scene), seed).map_err(anyhow::Error::msg)?;
                Self::Tolerances(Box::new(chains), None)
            }
        })
    }

    fn scan(&mut self, report: &ScanReport, flights: &FlightList) {
        match self {
            Self::Rungs(beside) => beside.scan(report, flights),
            Self::Tolerances(chains, before) => {
                let now = (SimTime(report.time_ns), report.truth.clone());
                chains.scan(&Work::of(report, before.replace(now), flights, None));
            }
        }
    }

    /// Rows and ghost of the scan that came last.
    fn told(&mut self, compared: &Compared) -> Value {
        match (self, compared) {
            (Self::Rungs(beside), Compared::Rungs(ghost)) => {
                beside.ghost(ghost.as_deref());
                json!({"rows": beside.rows(), "ghost": beside.ghosts_m()})
            }
            (Self::Tolerances(chains, _), Compared::Tolerances(ghost_m)) => {
                json!(chains.told(*ghost_m))
            }
            _ => json!({"rows": []}), // a thread compares one thing
        }
    }
}

/// Goes after the wishes until their owner is gone.
fn follow(
    database: &Path,
    first: Wish,
    heard: &Receiver<Wish>,
    tell: &dyn Fn(Value),
) -> anyhow::Result<()> {
    let mut archive = Archive::open(database)?;
    let scene = Arc::new(kept_scene::load_as_tracked(&archive)?);
    if let Compared::Tolerances(_) = first.compared {
        let changes = kept_scene::changes(&archive)?;
        if let Some((key, value)) = changes.iter().find(|c| !c.0.starts_with("tracking.")) {
            bail!(
                "this fork changed {key} to {value} on the way: tolerances are compared on its parent"
            );
        }
    }
    let flights = kept_scene::flights(&archive, &scene)?;
    let seed = archive.fact("seed").and_then(|s| s.parse().ok()).unwrap_or(scene.run.seed);
    let (mut wish, mut run) = (first, None::<(usize, Side, usize)>);
    'wishes: loop {
        if archive.range().is_none_or(|(_, last)| last < wish.scan) {
            archive.follow()?; // of a run that goes on
        }
        let (from, last) = window(archive.sums(), wish.scan).context("the log holds no scan")?;
        let (mut next, mut side, mut plots) = match run.take() {
            Some((at, side, plots)) if (from..=last + 1).contains(&(at + 1)) => {
                (at + 1, side, plots)
            }
            _ => (from, Side::new(&wish.compared, &scene, seed)?, 0),
        };
        let (begin, began_ns, mut told_ns) = (next, monotonic_ns(), 0);
        while next <= last {
            let now_ns = monotonic_ns();
            if now_ns.saturating_sub(told_ns) > TELL_NS {
                told_ns = now_ns;
                let done = (next - begin) as f64 / (last + 1 - begin) as f64;
                let took_s = now_ns.saturating_sub(began_ns) as f64 * 1e-9;
                let left_s = (next > begin).then(|| took_s * (1.0 / done - 1.0));
                let on_the_way = json!({"rows": [], "done": done, "left_s": left_s});
                tell(wish.compared.message(on_the_way));
            }
            let scan = archive.sums()[next].scan;
            let report = archive.report(scan)?.context("a scan is missing")?;
            let whole = report.plots.iter().all(|p| p.ellipse.iter().all(|e| !e.is_nan()));
            ensure!(
                whole,
                "this log is of an earlier version: its plots do not say how sure they are"
            );
            plots += report.plots.len();
            side.scan(&report, &flights);
            next += 1;
            match heard.try_recv() {
                Ok(newer) => {
                    (wish, run) = (newer, Some((next - 1, side, plots)));
                    continue 'wishes;
                }
                Err(TryRecvError::Disconnected) => return Ok(()),
                Err(TryRecvError::Empty) => {}
            }
        }
        let mut about = side.told(&wish.compared);
        about["done"] = 1.0.into();
        about["scan"] = wish.scan.into();
        if plots == 0 && matches!(side, Side::Rungs(_)) {
            about["rows"] = json!([]);
            about["why_not"] = NO_PLOTS.into();
        }
        tell(wish.compared.message(about));
        run = Some((last, side, plots));
        match heard.recv() {
            Ok(newer) => wish = newer,
            Err(_) => return Ok(()),
        }
        // Of several that wait only the newest counts.
        wish = heard.try_iter().last().unwrap_or(wish);
    }
}

/// Places of the first scan to take and of the one shown; none in an empty log.
fn window(sums: &[ScanSums], scan: u64) -> Option<(usize, usize)> {
    let last = sums.partition_point(|s| s.scan <= scan).max(1) - 1;
    let from = SimTime(sums.get(last)?.time.0 - BEFORE_NS);
    Some((sums.partition_point(|s| s.time <= from), last))
}

/// Of how long before the time shown scans are taken, ns: a minute in which tracks form, and the one that is judged.
const BEFORE_NS: i64 = 120_000_000_000;
/// How often the page is told how far it is, ns.
const TELL_NS: u64 = 200_000_000;
const NO_PLOTS: &str =
    "these scans hold no plots: nothing was seen, or the log was kept without them";

#[cfg(test)]
mod tests;
