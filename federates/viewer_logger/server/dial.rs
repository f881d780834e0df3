//! The dial of one browser: beside the run that goes on, where all who watch share one, or on the finished run that it looks at.

use super::super::replayed::{Compared, Replayed};
use super::super::session::{Outgoing, Session, refused};
use super::Page;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// What a browser compares on finished runs.
#[derive(Default)]
pub(super) struct Dials {
    rungs: Option<Dial>,
    tolerances: Option<Dial>,
}

struct Dial {
    database: PathBuf,
    replayed: Replayed,
    /// What the page is to be told next.
    news: Arc<Mutex<Option<Value>>>,
}

impl Dials {
    /// A browser asks for a comparison, for another ghost in it, or has seen enough.
    pub(super) fn ask(
        &mut self,
        page: &Arc<Page>,
        session: &Session,
        on: bool,
        compared: Compared,
    ) -> Vec<Outgoing> {
        let Some((database, scan)) = page.with_all(|all| session.looks_back_at(all)) else {
            page.update(|viewer| match compared {
                Compared::Rungs(ghost) => viewer.compare(on, ghost),
                Compared::Tolerances(ghost_m) => viewer.compare_tolerances(on, ghost_m),
            });
            return Vec::new();
        };
        let kept = self.of(&compared);
        if !on {
            *kept = None;
            return vec![over(&compared)];
        }
        if let Some(dial) = kept.as_mut().filter(|d| d.database == database) {
            dial.replayed.ghost(compared);
            return Vec::new();
        }
        let Some(scan) = scan else { return vec![refused("this run has no scan to compare on")] };
        if Arc::strong_count(&page.comparisons) > MOST {
            return vec![refused(
                "four comparisons on finished runs are at work already: stop one",
            )];
        }
        match Dial::begin(page, database, scan, compared) {
            Ok(dial) => *kept = Some(dial),
            Err(error) => return vec![refused(&format!("nothing can be compared: {error}"))],
        }
        Vec::new()
    }

    fn of(&mut self, compared: &Compared) -> &mut Option<Dial> {
        match compared {
            Compared::Rungs(_) => &mut self.rungs,
            Compared::Tolerances(_) => &mut self.tolerances,
        }
    }

    /// Goes after the scan shown; what is to be told. Who looks at another run has seen enough of this one.
    pub(super) fn follow(&mut self, page: &Page, session: &Session) -> Vec<Outgoing> {
        let mut out = Vec::new();
        for (kept, none) in [
            (&mut self.rungs, Compared::Rungs(None)),
            (&mut self.tolerances, Compared::Tolerances(None)),
        ] {
            let Some(dial) = kept else { continue };
            let seen = page.with_all(|all| session.looks_back_at(all));
            let Some((_, scan)) = seen.filter(|(database, _)| *database == dial.database) else {
                *kept = None;
                out.push(over(&none));
                continue;
            };
            let Some(scan) = scan else { continue };
            dial.replayed.show(scan);
            let news = dial.news.lock().unwrap_or_else(PoisonError::into_inner).take();
            out.extend(news.map(|message| Outgoing::json(&message)));
        }
        out
    }
}

impl Dial {
    fn begin(
        page: &Arc<Page>,
        database: PathBuf,
        scan: u64,
        compared: Compared,
    ) -> std::io::Result<Self> {
        let news = Arc::<Mutex<Option<Value>>>::default();
        let (told, page, held) =
            (Arc::clone(&news), Arc::clone(page), Arc::clone(&page.comparisons));
        let tell = move |message| {
            let _at_work = &held;
            *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
            page.wake();
        };
        let replayed = Replayed::begin(database.clone(), scan, compared, tell)?;
        Ok(Self { database, replayed, news })
    }
}

/// Nothing is compared any more.
fn over(compared: &Compared) -> Outgoing {
    let kind = match compared {
        Compared::Rungs(_) => "rungs",
        Compared::Tolerances(_) => "tolerances",
    };
    Outgoing::json(&json!({"type": kind, "comparing": false, "rows": []}))
}

/// Comparisons on finished runs at one time, of all browsers.
const MOST: usize = 4;
