//! What the station hears, serves and watches: each becomes an [`Event`], what is measured goes into the [`Statistics`].

use super::Event;
use super::statistics::Statistics;
use crate::runtime::bus::{Bus, BusError, Request, hear_parts};
use crate::runtime::codec::decode;
use crate::runtime::messages::{FederateStatus, ScanReport};
use crossbeam_channel::Sender;
use std::sync::{Arc, Mutex, PoisonError};

/// Opens all of them.
///
/// # Errors
/// If the bus refuses one.
pub(super) fn open(
    bus: &dyn Bus,
    send: &Sender<Event>,
    statistics: &Arc<Mutex<Statistics>>,
) -> Result<(), BusError> {
    let serve = |key: &str, event: fn(Request) -> Event| {
        let to = send.clone();
        let handler = move |request| {
            let _ = to.send(event(request));
        };
        bus.serve(key, Box::new(handler))
    };
    // What is said under "{of}/{name}", with the name.
    let hear = |of: &'static str, event: fn(String, Vec<u8>) -> Event| {
        let to = send.clone();
        let handler = move |key: &str, body: &[u8]| {
            let name = key.strip_prefix(of).and_then(|rest| rest.strip_prefix('/'));
            let _ = to.send(event(name.unwrap_or(key).to_owned(), body.to_vec()));
        };
        bus.subscribe(&format!("{of}/*"), Box::new(handler))
    };
    serve("ctl/join", Event::Join)?;
    serve("ctl/command", Event::Command)?;
    serve("ctl/steps", Event::Steps)?;
    serve("log/conductor", Event::Fetch)?;
    serve("log/run", Event::Log)?;
    serve("frames/conductor", Event::Repair)?;
    hear("fed", Event::Report)?;
    hear("beat", Event::Beat)?;
    let to = send.clone();
    let leads = move |_: &str, body: &[u8]| {
        let _ = to.send(Event::Leads(body.to_vec()));
    };
    bus.subscribe("ctl/lead", Box::new(leads))?;
    let to = send.clone();
    let alive = move |key: &str, alive| {
        let mut parts = key.split('/').skip(1);
        if let (Some(name), Some(Ok(inc))) = (parts.next(), parts.next().map(str::parse)) {
            let _ = to.send(Event::Alive(name.to_owned(), inc, alive));
        }
    };
    bus.watch("alive/*/*", Box::new(alive))?;

    let kept = Arc::clone(statistics);
    let hears = move |_: &str, body: &[u8]| {
        if let Ok(status) = decode::<FederateStatus>(body) {
            kept.lock().unwrap_or_else(PoisonError::into_inner).hear(status);
        }
    };
    bus.subscribe("obs/fed/*", Box::new(hears))?;
    let kept = Arc::clone(statistics);
    hear_parts(bus, "tracks/1/scan", move |scan: ScanReport| {
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.measures = scan.measures.into_iter().collect();
    })?;
    let kept = Arc::clone(statistics);
    let measured = move |_: &str, body: &[u8]| {
        if let Ok(measures) = serde_json::from_slice(body)
            && body.len() <= MOST_MEASURES
        {
            kept.lock().unwrap_or_else(PoisonError::into_inner).traffic = measures;
        }
    };
    bus.subscribe("obs/measures", Box::new(measured))?;
    let kept = Arc::clone(statistics);
    let answers = move |request: Request| {
        let kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        request.answer(serde_json::to_vec(&*kept).unwrap_or_default());
    };
    bus.serve("ctl/statistics", Box::new(answers))
}

/// Longest message of measures that is taken, octets.
const MOST_MEASURES: usize = 1 << 16;
