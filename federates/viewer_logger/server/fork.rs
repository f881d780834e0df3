//! A fork is made beside the page that asked for it, and put among its runs.

use super::super::forks::{Difference, Wanted};
use super::super::opened;
use super::Page;
use serde_json::json;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Begins to make a fork; what becomes of it is told to all pages as topic `fork`.
///
/// # Errors
/// Why it cannot begin, as one sentence.
pub(super) fn begin(page: &Arc<Page>, wanted: Wanted) -> Result<(), String> {
    let Some(forks) = page.forks() else {
        return Err("forks are made of finished runs: seeds open RUN, or seeds fork in a terminal"
            .to_owned());
    };
    let database = page.database_of(&wanted.run).map_err(str::to_owned)?;
    if forks.busy.swap(true, Ordering::AcqRel) {
        return Err("another fork is being made: wait for it, or cancel it".to_owned());
    }
    forks.cancelled.store(false, Ordering::Relaxed);
    let (page, own) = (Arc::clone(page), Arc::clone(&forks));
    let work = move || {
        let tell = |state: &str, text: &str, more: serde_json::Value| {
            let mut message =
                json!({"type": "fork", "id": wanted.id, "state": state, "text": text});
            if let Some(more) = more.as_object() {
                more.iter().for_each(|(k, v)| message[k] = v.clone());
            }
            page.tell_all("fork", &message);
        };
        tell("running", "the recording is played again", json!({}));
        let done = (own.make)(&database, &wanted, &own.cancelled)
            .and_then(|folder| added(&page, &wanted, &folder));
        own.busy.store(false, Ordering::Release);
        match done {
            Ok((run, difference)) => {
                tell("done", &difference.words(), json!({"run": run, "difference": difference}));
            }
            Err(_) if own.cancelled.load(Ordering::Relaxed) => {
                tell("cancelled", "cancelled; nothing was kept", json!({}));
            }
            Err(reason) => tell("failed", &reason, json!({})),
        }
    };
    let begun = std::thread::Builder::new().name("fork".to_owned()).spawn(work);
    begun.map(drop).map_err(|error| {
        forks.busy.store(false, Ordering::Release);
        format!("the fork cannot be begun: {error}")
    })
}

/// Puts the fork among the runs of the page and holds it against its parent.
fn added(page: &Page, wanted: &Wanted, folder: &Path) -> Result<(String, Difference), String> {
    let viewer = opened::viewer(&folder.join("run.sqlite")).map_err(|e| e.to_string())?;
    let own = viewer.source().sums().to_vec();
    let difference = page
        .with_source(&wanted.run, |parent| Difference::of(parent.sums(), &own, wanted.at_s))
        .ok_or("the run that it is a fork of is gone")?;
    Ok((page.add(viewer), difference))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::Viewer;
    use crate::viewer_logger::forks::Forks;

    #[test]
    fn forks_are_made_of_finished_runs_only_and_one_at_a_time() {
        let wanted =
            |run: &str| Wanted { id: 1, run: run.to_owned(), at_s: 0.0, changes: Vec::new() };
        let page = Page::new(Viewer::new(1 << 16));
        let error = begin(&page, wanted("live")).expect_err("nobody makes forks here");
        assert!(error.contains("seeds open"), "{error}");
        page.make_forks(Forks::new(Box::new(|_, _, _| Err("never".to_owned()))));
        let error = begin(&page, wanted("live")).expect_err("it goes on");
        assert!(error.contains("finished"), "{error}");
        let error = begin(&page, wanted("other")).expect_err("unknown");
        assert!(error.contains("no such run"), "{error}");
    }
}
