//! What a page asks for beside its files and its WebSocket: figures, where the radars see, a turn of a radar's video.

use super::super::Viewer;
use super::super::detection::{Maps, What};
use super::super::geometry;
use super::super::metrics;
use super::super::rings;
use super::super::video::{self, NoTurn};
use super::Shared;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use models::frames::Point2;
use models::time::SimTime;
use serde::Deserialize;
use std::sync::Arc;

/// The run as Prometheus text; beyond loopback for whoever shows a token (`Authorization: Bearer`).
pub(super) async fn figures(headers: HeaderMap, State(shared): State<Arc<Shared>>) -> Response {
    if let Err(reason) = shared.access.may_read(&headers) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let text = shared.page.viewer().metrics();
    ([(header::CONTENT_TYPE, metrics::CONTENT_TYPE)], text).into_response()
}

/// What a page asks of the radars: one of them (`sensor`), or all together, at a time, s; `of`: `pd` or `sigma`. Here as below `run` names
/// the run, else it is the first.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Asking {
    sensor: Option<u16>,
    #[serde(default)]
    t: f64,
    of: Option<String>,
    #[serde(default)]
    run: String,
}

/// Where the radars see, as a picture; its place (west and north edge, side of a cell, m) in `x-place`.
pub(super) async fn detection(
    headers: HeaderMap,
    asking: Result<Query<Asking>, QueryRejection>,
    State(shared): State<Arc<Shared>>,
) -> Response {
    if let Err(reason) = shared.access.may_read(&headers) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let asking = asking.ok().map(|Query(asking)| asking).filter(|asking| asking.t.is_finite());
    let what = |asking: &Asking| asking.of.as_deref().map_or(Some(What::Pd), What::of);
    let Some((asking, what)) = asking.and_then(|asking| what(&asking).map(|what| (asking, what)))
    else {
        let words = "sensor is a number of a sensor, t a time in seconds, of pd or sigma\n";
        return (StatusCode::BAD_REQUEST, words).into_response();
    };
    let maps = match looked_at(&shared, &asking.run, Viewer::detection) {
        Ok(maps) => maps,
        Err(refusal) => return refusal.into_response(),
    };
    // A tenth of a second of arithmetic: not on the thread that serves.
    let made =
        tokio::task::spawn_blocking(move || maps.picture(asking.sensor, asking.t, what)).await;
    match made {
        Ok(Ok(picture)) => {
            let [west, north] = picture.corner_m;
            let place = format!("{west} {north} {}", picture.step_m);
            let named = [
                (header::CONTENT_TYPE, "image/png".to_owned()),
                (header::HeaderName::from_static("x-place"), place),
            ];
            (named, picture.png.clone()).into_response()
        }
        Ok(Err(reason)) => (StatusCode::NOT_FOUND, format!("{reason}\n")).into_response(),
        Err(_) => {
            (StatusCode::INTERNAL_SERVER_ERROR, "the picture could not be made\n").into_response()
        }
    }
}

/// Of which sensor a page asks the geometry, at a time, s, and for a target where, m east and north.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct AskingGeometry {
    sensor: u16,
    #[serde(default)]
    t: f64,
    x: Option<f64>,
    y: Option<f64>,
    #[serde(default)]
    run: String,
}

impl AskingGeometry {
    /// Numbers that are some: a time within a year of the start, a place within a thousand kilometres.
    fn sound(self) -> Option<Self> {
        let place = [self.x, self.y].into_iter().flatten().all(|m| m.abs() <= 1e6);
        ((0.0..=3.2e7).contains(&self.t) && place).then_some(self)
    }
}

/// Satellites, stations or loops of a sensor, and what they make of a position (JSON).
pub(super) async fn geometry(
    headers: HeaderMap,
    asking: Result<Query<AskingGeometry>, QueryRejection>,
    State(shared): State<Arc<Shared>>,
) -> Response {
    if let Err(reason) = shared.access.may_read(&headers) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let Some(asking) = asking.ok().and_then(|Query(asking)| asking.sound()) else {
        let words =
            "sensor is a number of a sensor, t a time in seconds, x and y a place in metres\n";
        return (StatusCode::BAD_REQUEST, words).into_response();
    };
    let with_seed = |viewer: &Viewer| Some((viewer.detection()?, viewer.info().seed));
    let (maps, seed) = match looked_at(&shared, &asking.run, with_seed) {
        Ok(found) => found,
        Err(refusal) => return refusal.into_response(),
    };
    let target_m = asking.x.zip(asking.y).map(|(x, y)| Point2::new(x, y));
    let time = SimTime::from_s(asking.t);
    let asked = geometry::Asked { sensor: asking.sensor, seed, time, target_m };
    match tokio::task::spawn_blocking(move || maps.geometry(&asked)).await {
        Ok(Ok(told)) => {
            ([(header::CONTENT_TYPE, "application/json")], told.to_string()).into_response()
        }
        Ok(Err(reason)) => (StatusCode::NOT_FOUND, format!("{reason}\n")).into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "it could not be made\n").into_response(),
    }
}

/// Which turn of which radar a page asks for.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct AskingTurn {
    sensor: u16,
    scan: u64,
    #[serde(default)]
    run: String,
}

/// What is made of the sensor and the scan that a page asks for: the maker, the sensor, the seed of the run, and the scan as the page was
/// sent it; else the refusal.
fn sensor_and_scan(
    headers: &HeaderMap,
    asking: Result<Query<AskingTurn>, QueryRejection>,
    shared: &Shared,
) -> Result<(Arc<Maps>, u16, u64, Vec<u8>), Refusal> {
    if let Err(reason) = shared.access.may_read(headers) {
        return Err((StatusCode::FORBIDDEN, format!("{reason}\n")));
    }
    let Ok(Query(AskingTurn { sensor, scan, run })) = asking else {
        let words = "sensor is a number of a radar, scan the number of a scan\n";
        return Err((StatusCode::BAD_REQUEST, words.to_owned()));
    };
    let (maps, seed, message) = looked_at(shared, &run, |viewer| {
        let source = viewer.source();
        let there = source.nearest(scan).filter(|near| *near == scan);
        let message = there.and_then(|scan| source.message(scan));
        Some((viewer.detection()?, viewer.info().seed, message))
    })?;
    let message =
        message.ok_or_else(|| (StatusCode::NOT_FOUND, "there is no such scan\n".to_owned()))?;
    Ok((maps, sensor, seed, message))
}

/// What a page wants to know of the run of this name; the first one's where it names none.
fn looked_at<T>(
    shared: &Shared,
    run: &str,
    look: impl FnOnce(&Viewer) -> Option<T>,
) -> Result<T, Refusal> {
    let none = |what: &str| (StatusCode::NOT_FOUND, format!("there is no {what}\n"));
    let found = shared.page.with_run(run, look).ok_or_else(|| none("such run"))?;
    found.ok_or_else(|| none("scene yet"))
}

/// Status and sentence of what is not answered.
type Refusal = (StatusCode, String);

/// Where each effect of a radar's plan is on in a scan (JSON).
pub(super) async fn rings(
    headers: HeaderMap,
    asking: Result<Query<AskingTurn>, QueryRejection>,
    State(shared): State<Arc<Shared>>,
) -> Response {
    let (maps, sensor, seed, scan) = match sensor_and_scan(&headers, asking, &shared) {
        Ok(found) => found,
        Err(refusal) => return refusal.into_response(),
    };
    let asked = rings::Asked { sensor, seed, scan };
    match tokio::task::spawn_blocking(move || maps.rings(&asked)).await {
        Ok(Ok(told)) => {
            ([(header::CONTENT_TYPE, "application/json")], told.to_string()).into_response()
        }
        Ok(Err(reason)) => (StatusCode::NOT_FOUND, format!("{reason}\n")).into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "it could not be made\n").into_response(),
    }
}

/// The video of a turn; 202 and nothing while another one is made, with the seconds after which to ask again.
pub(super) async fn turn(
    headers: HeaderMap,
    asking: Result<Query<AskingTurn>, QueryRejection>,
    State(shared): State<Arc<Shared>>,
) -> Response {
    let (maps, sensor, seed, scan) = match sensor_and_scan(&headers, asking, &shared) {
        Ok(found) => found,
        Err(refusal) => return refusal.into_response(),
    };
    let asked = video::Asked { sensor, seed, scan };
    match tokio::task::spawn_blocking(move || maps.turn(&asked)).await {
        Ok(Ok(turn)) => {
            let kind = [(header::CONTENT_TYPE, "application/octet-stream")];
            (kind, turn.as_ref().clone()).into_response()
        }
        Ok(Err(NoTurn::Busy)) => {
            let again = [(header::RETRY_AFTER, "1")];
            (StatusCode::ACCEPTED, again).into_response()
        }
        Ok(Err(NoTurn::Never(reason))) => {
            (StatusCode::NOT_FOUND, format!("{reason}\n")).into_response()
        }
        Err(_) => {
            (StatusCode::INTERNAL_SERVER_ERROR, "the turn could not be made\n").into_response()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Operate, Page, serve};
    use super::*;
    use std::io::{Read, Write};

    /// What is answered to a question on this host; of octets that are no text the replacement.
    fn get(port: u16, path: &str) -> String {
        let mut stream = std::net::TcpStream::connect(("127.0.0.1", port)).expect("connected");
        write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n")
            .expect("sent");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        String::from_utf8_lossy(&answer).into_owned()
    }

    #[test]
    fn what_is_no_time_or_no_number_is_refused_with_one_sentence() {
        let page = Page::new(Viewer::new(1 << 16));
        let operate: Operate = Box::new(|_, _| (true, String::new()));
        let here = "127.0.0.1:0".parse().expect("an address");
        let server = serve(here, page, operate).expect("served");
        let port = server.address().port();
        let get = |path: &str| get(port, path);
        for query in
            ["t=NaN", "t=inf", "t=-inf", "t=x", "sensor=-1", "sensor=70000", "sensor=a", "of=x"]
        {
            let answer = get(&format!("/detection?{query}"));
            assert!(answer.starts_with("HTTP/1.1 400"), "{query}: {answer}");
            assert!(answer.contains("t a time in seconds"), "{query}: {answer}");
        }
        for query in ["", "sensor=1", "sensor=1&scan=-1", "sensor=1&scan=x", "scan=1"] {
            for path in ["video", "rings"] {
                let answer = get(&format!("/{path}?{query}"));
                assert!(answer.starts_with("HTTP/1.1 400"), "{path}?{query}: {answer}");
            }
        }
        for query in ["", "sensor=a", "sensor=1&t=NaN", "sensor=1&t=-1", "sensor=1&x=inf&y=1"] {
            let answer = get(&format!("/geometry?{query}"));
            assert!(answer.starts_with("HTTP/1.1 400"), "{query}: {answer}");
        }
        // Sound, but there is no run yet.
        assert!(get("/geometry?sensor=1&t=3").starts_with("HTTP/1.1 404"));
        assert!(get("/detection?t=3").starts_with("HTTP/1.1 404"));
        assert!(get("/video?sensor=1&scan=1").starts_with("HTTP/1.1 404"));
        assert!(get("/rings?sensor=1&scan=1").starts_with("HTTP/1.1 404"));
        server.stop();
    }

    #[test]
    fn what_is_asked_of_a_run_is_answered_by_that_run() {
        use super::super::super::tests::scan;
        let scene = scenarios::load_without_truth(&scenarios::locate("asmgcs")).expect("a scene");
        let radar = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar").id.0;
        let page = Page::new(Viewer::new(1 << 16));
        let mut second = Viewer::new(1 << 20);
        second.set_id("the second");
        second.show_detection(Maps::of(Arc::new(scene)));
        second.on_scan(&scan(3));
        page.add(second);
        let operate: Operate = Box::new(|_, _| (true, String::new()));
        let here = "127.0.0.1:0".parse().expect("an address");
        let server = serve(here, page, operate).expect("served");
        let port = server.address().port();
        let get = |path: &str| get(port, path);
        for path in ["geometry", "detection", "rings", "video"] {
            let query = format!("/{path}?sensor={radar}&t=3&scan=3");
            assert!(get(&query).contains("there is no scene yet"), "{path}: of the first");
            let answer = get(&format!("{query}&run=nobody"));
            assert!(answer.contains("there is no such run"), "{path}: {answer}");
            let answer = get(&format!("{query}&run=the+second"));
            let geometry = path == "geometry" && answer.starts_with("HTTP/1.1 404");
            let own = answer.starts_with("HTTP/1.1 200") || geometry;
            assert!(own && !answer.contains("there is no"), "{path}: {answer}");
        }
        assert!(
            get(&format!("/rings?sensor={radar}&scan=4&run=the+second")).contains("no such scan")
        );
        server.stop();
    }
}
