//! The run over HTTP: last values as JSON and GeoJSON, a stream of scans, and what the map of a receiver reads.
//!
//! Nothing but GET. A request must name this host by address or as `localhost`, as the page asks it. Connections are bounded and live for a
//! minute; a stream is then opened again by the browser itself.

use super::board::{Board, KEYS};
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
use tokio::sync::{mpsc, oneshot};
use tokio::time::timeout;

/// A running server.
pub struct Http {
    address: SocketAddr,
    stop: oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

/// Paths under `/api/v1/` beside the keys.
const MORE: [&str; 4] = ["tracks.geojson", "truth.geojson", "stream", "schema"];
/// Scans that may wait for a reader of the stream.
const WAITING: usize = 2;
/// How long a reader of the stream may read nothing.
const STANDS: Duration = Duration::from_secs(5);

impl Http {
    /// Serves the board.
    ///
    /// # Errors
    /// If the address cannot be listened on, or no thread started.
    pub fn serve(address: SocketAddr, board: Arc<Board>) -> anyhow::Result<Self> {
        let socket =
            std::net::TcpListener::bind(address).with_context(|| format!("--http {address}"))?;
        socket.set_nonblocking(true)?;
        let address = socket.local_addr()?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (stop, stopped) = oneshot::channel();
        let body = move || {
            runtime.block_on(async {
                let accept = async {
                    let listener = tokio::net::TcpListener::from_std(socket)?;
                    let router = axum::Router::new()
                        .fallback(answer)
                        .layer(DefaultBodyLimit::max(1024))
                        .with_state(board);
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
        Ok(Self { address, stop, thread })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Closes all connections.
    pub fn stop(self) {
        self.stop.send(()).ok();
        self.thread.join().ok();
    }
}

async fn answer(State(board): State<Arc<Board>>, request: Request) -> Response {
    if let Err(reason) = same_origin(request.headers()) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    if ![Method::GET, Method::HEAD].contains(request.method()) {
        let allowed = [(header::ALLOW, "GET, HEAD")];
        return (StatusCode::METHOD_NOT_ALLOWED, allowed, "read only\n").into_response();
    }
    let path = request.uri().path();
    let key = match path {
        "/data/aircraft.json" => Some("aircraft.json"),
        "/data/receiver.json" => Some("receiver.json"),
        _ => path.strip_prefix("/api/v1/").filter(|key| !key.ends_with("r.json")),
    };
    let Some(key) = key else { return not_found(path) };
    if key == "stream" {
        return stream(board);
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
    text += "/api/v1/federate/NAME\n/data/aircraft.json\n/data/receiver.json\n";
    (StatusCode::NOT_FOUND, text).into_response()
}

/// Server-sent events: each scan as it comes.
fn stream(board: Arc<Board>) -> Response {
    let (send, receive) = mpsc::channel(WAITING);
    tokio::spawn(async move {
        let mut scans = board.scans();
        scans.mark_changed();
        while scans.changed().await.is_ok() {
            scans.mark_unchanged();
            let Some(scan) = board.value("scan") else { continue };
            let event = Bytes::from(format!("event: scan\ndata: {scan}\n\n"));
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
