//! The run over HTTP: last values as JSON and GeoJSON, a stream of scans, and what the map of a receiver reads.
//!
//! Nothing but GET. A request must name this host by address or as `localhost`, as the page asks it, and beyond loopback show a token
//! ([`access`](crate::runtime::access)). Connections are bounded and live for a minute; a stream is then opened again by the browser itself.

use super::board::{Board, KEYS};
use crate::runtime::access::Access;
use crate::runtime::connections::{self, same_origin};
use anyhow::Context;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use hyper::body::Frame;
use std::convert::Infallible;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::Poll;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::{Notify, mpsc, oneshot, watch};
use tokio::time::timeout;

/// A running server.
pub struct Http {
    address: SocketAddr,
    access: Arc<Access>,
    stop: oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

/// Paths under `/api/v1/` beside the keys.
const MORE: [&str; 5] = ["tracks.geojson", "truth.geojson", "states", "stream", "schema"];
/// Scans that may wait for a reader of the stream.
const WAITING: usize = 2;
/// How long a reader of the stream may read nothing.
const STANDS: Duration = Duration::from_secs(5);

impl Http {
    /// Serves the board.
    ///
    /// # Errors
    /// If the address cannot be listened on, no thread started, or no token drawn.
    pub fn serve(address: SocketAddr, board: Arc<Board>) -> anyhow::Result<Self> {
        let socket =
            std::net::TcpListener::bind(address).with_context(|| format!("--http {address}"))?;
        socket.set_nonblocking(true)?;
        let address = socket.local_addr()?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (stop, stopped) = oneshot::channel();
        let access = Arc::new(Access::at(address)?);
        let state =
            Arc::new(Shared { board, access: Arc::clone(&access), scans: Scans::default() });
        let body = move || {
            runtime.block_on(async {
                let encoder = Arc::clone(&state);
                tokio::spawn(async move { encoder.scans.encode(&encoder.board).await });
                let accept = async {
                    let listener = tokio::net::TcpListener::from_std(socket)?;
                    let router = axum::Router::new()
                        .fallback(answer)
                        .layer(DefaultBodyLimit::max(1024))
                        .with_state(state);
                    connections::serve(&listener, &router).await;
                    std::io::Result::Ok(())
                };
                tokio::select! {
                    ended = accept => tracing::error!(?ended, "the gateway's HTTP server ended"),
                    _ = stopped => {}
                }
            });
            runtime.shutdown_background();
        };
        let thread = std::thread::Builder::new().name("http".into()).spawn(body)?;
        Ok(Self { address, access, stop, thread })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What is added to an address to be let in: nothing on loopback.
    #[must_use]
    pub fn key(&self) -> String {
        self.access.key_to_look()
    }

    /// Closes all connections.
    pub fn stop(self) {
        self.stop.send(()).ok();
        self.thread.join().ok();
    }
}

struct Shared {
    board: Arc<Board>,
    access: Arc<Access>,
    scans: Scans,
}

/// Scans as the stream tells them: each is encoded once, however many read, and none while nobody does.
#[derive(Default)]
struct Scans {
    last: watch::Sender<Option<Bytes>>,
    came: Notify,
}

impl Scans {
    /// For one more reader, who begins with the last scan.
    fn reader(&self) -> watch::Receiver<Option<Bytes>> {
        let mut reader = self.last.subscribe();
        reader.mark_changed();
        self.came.notify_one();
        reader
    }

    async fn encode(&self, board: &Board) {
        let mut scans = board.scans();
        loop {
            tokio::select! {
                changed = scans.changed() => if changed.is_err() { return },
                () = self.came.notified() => if self.last.borrow().is_some() { continue },
            }
            let read = self.last.receiver_count() > 0;
            let scan = if read { board.value("scan") } else { None };
            let event = scan.map(|scan| Bytes::from(format!("event: scan\ndata: {scan}\n\n")));
            self.last.send_replace(event);
        }
    }
}

/// The next scan of a reader.
async fn next(reader: &mut watch::Receiver<Option<Bytes>>) -> Option<Bytes> {
    loop {
        reader.changed().await.ok()?;
        let event = reader.borrow_and_update().clone();
        if event.is_some() {
            return event;
        }
    }
}

async fn answer(State(shared): State<Arc<Shared>>, request: Request) -> Response {
    if let Err(reason) = same_origin(request.headers()) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let query = request.uri().query().unwrap_or_default();
    if let Err(reason) = shared.access.may_read_with(request.headers(), query) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let board = &shared.board;
    if ![Method::GET, Method::HEAD].contains(request.method()) {
        let allowed = [(header::ALLOW, "GET, HEAD")];
        return (StatusCode::METHOD_NOT_ALLOWED, allowed, "read only\n").into_response();
    }
    let path = request.uri().path();
    let key = match path {
        "/data/aircraft.json" => Some("aircraft.json"),
        // As clients of the OpenSky Network ask.
        "/api/states/all" => Some("states"),
        "/data/receiver.json" => Some("receiver.json"),
        _ => path.strip_prefix("/api/v1/").filter(|key| !key.ends_with("r.json")),
    };
    let Some(key) = key else { return not_found(path) };
    if key == "stream" {
        return stream(shared.scans.reader());
    }
    let known = KEYS.contains(&key)
        || MORE.contains(&key)
        || key.starts_with("federate/")
        || path.starts_with("/data/");
    match board.value(key) {
        Some(value) => {
            let kind =
                if key.ends_with(".geojson") { "application/geo+json" } else { "application/json" };
            let headers = [
                (header::CONTENT_TYPE, kind),
                (header::CACHE_CONTROL, "no-store"),
                (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
            ];
            (headers, value.to_string()).into_response()
        }
        None if known => (StatusCode::NOT_FOUND, format!("{path}: nothing yet\n")).into_response(),
        None => not_found(path),
    }
}

fn not_found(path: &str) -> Response {
    let mut text =
        format!("{}: no such path. There are:\n", path.chars().take(80).collect::<String>());
    for key in KEYS.iter().chain(&MORE) {
        text += &format!("/api/v1/{key}\n");
    }
    text += "/api/v1/federate/NAME\n/api/states/all\n/data/aircraft.json\n/data/receiver.json\n";
    (StatusCode::NOT_FOUND, text).into_response()
}

/// Server-sent events: each scan as it comes.
fn stream(mut scans: watch::Receiver<Option<Bytes>>) -> Response {
    let (send, receive) = mpsc::channel(WAITING);
    tokio::spawn(async move {
        while let Some(event) = next(&mut scans).await {
            match timeout(STANDS, send.send(event)).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) | Err(_) => return, // it left, or does not read
            }
        }
    });
    let headers =
        [(header::CONTENT_TYPE, "text/event-stream"), (header::CACHE_CONTROL, "no-store")];
    (headers, Body::new(Events(receive))).into_response()
}

/// A body of pieces as they come.
struct Events(mpsc::Receiver<Bytes>);

impl hyper::body::Body for Events {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut std::task::Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        self.0.poll_recv(context).map(|piece| piece.map(|bytes| Ok(Frame::data(bytes))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::ScanReport;
    use std::io::{Read, Write};
    use std::net::TcpStream;

    fn asked(http: &Http, path: &str, more: &str) -> String {
        let mut stream = TcpStream::connect(("127.0.0.1", http.address().port())).expect("open");
        stream.set_read_timeout(Some(Duration::from_secs(30))).expect("set");
        write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n{more}\r\n")
            .expect("sent");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        answer
    }

    #[test]
    fn a_scan_is_encoded_once_for_all_who_read_the_stream() {
        let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("zurich");
        let board = Arc::new(Board::new(&scene, 1, false));
        let scans = Arc::new(Scans::default());
        let scan = |number: u64| {
            let time_ns = number as i64 * 1_000_000_000;
            board.on_scan(&Arc::new(ScanReport {
                run: 1,
                scan: number,
                time_ns,
                ..Default::default()
            }));
        };
        let number = |event: &Bytes| {
            let text = std::str::from_utf8(event).expect("text");
            let json = text.strip_prefix("event: scan\ndata: ").expect("an event").trim_end();
            serde_json::from_str::<serde_json::Value>(json).expect("JSON")["scan"].as_u64()
        };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        runtime.expect("a runtime").block_on(async {
            let (encoder, of) = (Arc::clone(&scans), Arc::clone(&board));
            tokio::spawn(async move { encoder.encode(&of).await });
            let turn = || async {
                for _ in 0..10 {
                    tokio::task::yield_now().await;
                }
            };
            turn().await;
            scan(1);
            turn().await;
            assert!(scans.last.borrow().is_none(), "nobody reads");
            let (mut one, mut two) = (scans.reader(), scans.reader());
            for expected in 1..4 {
                let events = [next(&mut one).await, next(&mut two).await];
                let [Some(first), Some(second)] = events else { panic!("two readers") };
                assert_eq!(number(&first), Some(expected));
                assert_eq!(first.as_ptr(), second.as_ptr(), "the same octets");
                let mut late = scans.reader();
                assert_eq!(next(&mut late).await.map(|e| e.as_ptr()), Some(first.as_ptr()));
                scan(expected + 1);
            }
            drop((one, two));
            turn().await;
            scan(5);
            turn().await;
            let event = next(&mut scans.reader()).await.expect("the last one");
            assert_eq!(number(&event), Some(5), "not one of when somebody read");
        });
    }

    #[test]
    fn beyond_loopback_nothing_is_told_without_the_token_that_was_printed() {
        let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("zurich");
        let serve = |place: &str| {
            let board = Arc::new(Board::new(&scene, 1, false));
            Http::serve(place.parse().expect("an address"), board).expect("served")
        };
        let here = serve("127.0.0.1:0");
        assert_eq!(here.key(), "");
        assert!(!asked(&here, "/api/v1/state", "").starts_with("HTTP/1.1 403"));
        here.stop();
        let beyond = serve("0.0.0.0:0");
        let key = beyond.key();
        let token = key.strip_prefix("?key=").expect("a token").to_owned();
        for path in ["/api/v1/state", "/api/v1/stream", "/data/aircraft.json", "/nothing"] {
            let refused = asked(&beyond, path, "");
            assert!(
                refused.starts_with("HTTP/1.1 403") && refused.contains("?key=TOKEN"),
                "{refused}"
            );
            assert!(
                asked(&beyond, &format!("{path}?key={}", "0".repeat(32)), "")
                    .starts_with("HTTP/1.1 403")
            );
        }
        assert!(asked(&beyond, "/api/v1/schema?x=1", "").starts_with("HTTP/1.1 403"));
        let schema = "HTTP/1.1 200";
        assert!(asked(&beyond, &format!("/api/v1/schema{key}"), "").starts_with(schema));
        let bearer = format!("Authorization: Bearer {token}\r\n");
        assert!(asked(&beyond, "/api/v1/schema", &bearer).starts_with(schema));
        beyond.stop();
    }
}
