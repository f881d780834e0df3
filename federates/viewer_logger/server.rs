//! The page's server: static files out of the executable and one WebSocket a browser, on a thread of its own.
//!
//! It answers only browsers that were sent here by this very page: a request must name this host by address or
//! as `localhost` (no name that somebody else's DNS could point here), and a WebSocket must come from a page
//! of the same origin. Any other web page that is open beside it cannot command the run or read it.

use super::{Asked, Outgoing, Session, Viewer, reply};
use crate::runtime::messages::Command;
use axum::body::Body;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::{oneshot, watch};
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

/// What became of a command: whether it was carried out, and the state reached or the reason why not.
pub type Done = (bool, String);

/// Carries a command out and waits for the answer. Called on a thread that may block.
pub type Operate = Box<dyn Fn(&str, Command) -> Done + Send + Sync>;

/// Why the page cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The address cannot be listened on.
    #[error(
        "page {address}: {}; choose another address with --page ADDR:PORT, or leave the page out with --no-viewer",
        listen_reason(source)
    )]
    Listen {
        /// The address asked for.
        address: SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
    /// The server's thread or event loop could not be started.
    #[error("page: cannot start its server: {0}")]
    Start(std::io::Error),
}

/// The viewer, shared between those who feed it and the browsers that watch it.
pub struct Page {
    viewer: Mutex<Viewer>,
    version: watch::Sender<u64>,
}

impl Page {
    /// Shares `viewer`.
    #[must_use]
    pub fn new(viewer: Viewer) -> Arc<Self> {
        let version = watch::Sender::new(viewer.version());
        Arc::new(Self { viewer: Mutex::new(viewer), version })
    }

    /// Changes the viewer and wakes the browsers.
    pub fn update(&self, change: impl FnOnce(&mut Viewer)) {
        let mut viewer = self.viewer();
        change(&mut viewer);
        let version = viewer.version();
        drop(viewer);
        self.version.send_replace(version);
    }

    /// The viewer as it stands.
    pub fn viewer(&self) -> MutexGuard<'_, Viewer> {
        // A panic while it was held leaves last values and whole scans; both are still fit to show.
        self.viewer.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A running server; dropping it without [`Server::stop`] leaves it running until the process ends.
pub struct Server {
    address: SocketAddr,
    stop: oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

impl Server {
    /// Where it listens; with the port that the system chose if 0 was asked for.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Closes all connections and waits for the thread.
    pub fn stop(self) {
        self.stop.send(()).ok();
        self.thread.join().ok();
    }
}

/// Serves `page` at `listen`; commands of the browsers go to `operate`.
///
/// # Errors
/// If the address cannot be listened on, or no thread can be started.
pub fn serve(listen: SocketAddr, page: Arc<Page>, operate: Operate) -> Result<Server, PageError> {
    let refused = |source| PageError::Listen { address: listen, source };
    let socket = std::net::TcpListener::bind(listen).map_err(refused)?;
    socket.set_nonblocking(true).map_err(refused)?;
    let address = socket.local_addr().map_err(refused)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .max_blocking_threads(MAX_BROWSERS)
        .build()
        .map_err(PageError::Start)?;
    let (stop, stopped) = oneshot::channel();
    let state = Arc::new(Shared { page, operate, browsers: AtomicUsize::new(0) });
    let body = move || {
        runtime.block_on(async {
            let accept = async {
                match tokio::net::TcpListener::from_std(socket) {
                    Ok(listener) => axum::serve(listener, router(state)).await.err(),
                    Err(error) => Some(error),
                }
            };
            tokio::select! {
                error = accept => tracing::error!(?error, "the page's server ended"),
                _ = stopped => {}
            }
        });
        runtime.shutdown_background(); // does not wait for an answer that may never come
    };
    let thread = std::thread::Builder::new()
        .name("page".to_owned())
        .spawn(body)
        .map_err(PageError::Start)?;
    Ok(Server { address, stop, thread })
}

struct Shared {
    page: Arc<Page>,
    operate: Operate,
    browsers: AtomicUsize,
}

fn router(state: Arc<Shared>) -> axum::Router {
    axum::Router::new()
        .route("/socket", get(upgrade))
        .fallback(file)
        .layer(middleware::from_fn(guard))
        .layer(DefaultBodyLimit::max(1024))
        .with_state(state)
}

/// Refuses requests that did not come from this page and adds the headers that keep the browser strict.
async fn guard(request: Request, next: Next) -> Response {
    if let Err(reason) = same_origin(request.headers()) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let mut response = next.run(request).await;
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        response.headers_mut().insert(name, header::HeaderValue::from_static(value));
    }
    response
}

/// The request names this host by address or as `localhost`, and comes from no other page.
fn same_origin(headers: &HeaderMap) -> Result<(), &'static str> {
    let text = |name| headers.get(name).map(|v: &header::HeaderValue| v.to_str().unwrap_or("?"));
    let host = text(header::HOST).ok_or("this page needs a Host header")?;
    let name = host.parse::<SocketAddr>().map(|a| a.ip().to_string()).unwrap_or_else(|_| {
        let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
        name.trim_matches(['[', ']']).to_owned()
    });
    if !name.eq_ignore_ascii_case("localhost") && name.parse::<IpAddr>().is_err() {
        return Err("this page answers to an address or to localhost, not to a name");
    }
    match text(header::ORIGIN) {
        Some(origin) if !origin.eq_ignore_ascii_case(&format!("http://{host}")) => {
            Err("another page may not use this one")
        }
        _ => Ok(()), // programs that are no browsers send none
    }
}

async fn file(request: Request) -> Response {
    if ![Method::GET, Method::HEAD].contains(request.method()) {
        let allowed = [(header::ALLOW, "GET, HEAD")];
        return (StatusCode::METHOD_NOT_ALLOWED, allowed, "read only\n").into_response();
    }
    let path = match request.uri().path() {
        "/" => "/index.html",
        path => path,
    };
    match FILES.iter().find(|f| path.strip_prefix('/') == Some(f.0)) {
        Some((_, kind, octets)) => {
            ([(header::CONTENT_TYPE, *kind)], Body::from(*octets)).into_response()
        }
        None => (StatusCode::NOT_FOUND, "no such file\n").into_response(),
    }
}

async fn upgrade(socket: WebSocketUpgrade, State(shared): State<Arc<Shared>>) -> Response {
    if shared.browsers.fetch_add(1, Ordering::Relaxed) >= MAX_BROWSERS {
        shared.browsers.fetch_sub(1, Ordering::Relaxed);
        let text = format!("{MAX_BROWSERS} browsers watch already; close one\n");
        return (StatusCode::SERVICE_UNAVAILABLE, text).into_response();
    }
    socket.max_message_size(MAX_MESSAGE).on_upgrade(async move |socket| {
        browser(socket, &shared).await;
        shared.browsers.fetch_sub(1, Ordering::Relaxed);
    })
}

/// One browser until it leaves. A slow one gets fewer scans, never an ever longer queue.
async fn browser(mut socket: WebSocket, shared: &Arc<Shared>) {
    let mut session = Session::default();
    let mut version = shared.page.version.subscribe();
    version.mark_changed();
    let mut alive = interval(ALIVE);
    alive.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let out = tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Text(text))) => match session.on_message(&text) {
                    Asked::Nothing => session.poll(&shared.page.viewer()),
                    Asked::Refused(answer) => vec![answer],
                    Asked::Compare(on) => {
                        shared.page.update(|viewer| viewer.compare(on));
                        Vec::new()
                    }
                    Asked::Command(id, words, command) => {
                        vec![carry_out(shared.clone(), id, words, command).await]
                    }
                },
                Some(Ok(Message::Binary(_))) => vec![super::refused("binary messages mean nothing here")],
                Some(Ok(_)) => Vec::new(),
                Some(Err(_)) | None => return,
            },
            changed = version.changed() => {
                if changed.is_err() {
                    return;
                }
                sleep(PICTURE).await; // several changes make one picture
                version.mark_unchanged();
                session.poll(&shared.page.viewer())
            }
            _ = alive.tick() => vec![Outgoing::Text(r#"{"type":"alive"}"#.into())],
        };
        for message in out {
            let message = match message {
                Outgoing::Text(text) => Message::Text((&*text).into()),
                Outgoing::Binary(octets) => Message::Binary(octets.into()),
            };
            match timeout(STUCK, socket.send(message)).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) | Err(_) => return,
            }
        }
    }
}

async fn carry_out(shared: Arc<Shared>, id: f64, words: String, command: Command) -> Outgoing {
    let word = words.clone();
    let work = tokio::task::spawn_blocking(move || (shared.operate)(&word, command));
    let (accepted, text) = match timeout(ANSWER, work).await {
        Ok(Ok(done)) => done,
        Ok(Err(_)) => (false, "the command failed inside the viewer; see its log".to_owned()),
        Err(_) => {
            (false, format!("no answer from the admin station within {} s", ANSWER.as_secs()))
        }
    };
    reply(id, &words, accepted, &text)
}

fn listen_reason(error: &std::io::Error) -> String {
    use std::io::ErrorKind as Kind;
    match error.kind() {
        Kind::AddrInUse => "the port is taken by another program".to_owned(),
        Kind::PermissionDenied => "this port needs more rights".to_owned(),
        Kind::AddrNotAvailable => "this host has no such address".to_owned(),
        _ => error.to_string(),
    }
}

const POLICY: &str =
    "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
const MAX_BROWSERS: usize = 32;
/// Longest message of a browser, octets.
const MAX_MESSAGE: usize = 4096;
/// At most this often a new picture.
const PICTURE: Duration = Duration::from_millis(40);
/// A sign of life when nothing else is to be said; the page shows its absence.
const ALIVE: Duration = Duration::from_secs(1);
/// A browser that takes nothing for so long is let go.
const STUCK: Duration = Duration::from_secs(20);
const ANSWER: Duration = Duration::from_secs(10);

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const FONT: &str = "font/woff2";

macro_rules! files {
    ($($path:literal $kind:expr;)*) => { &[$(($path, $kind, include_bytes!(concat!("web/", $path)))),*] };
}

/// Path, type and octets of everything the browser may ask for.
const FILES: &[(&str, &str, &[u8])] = files! {
    "index.html" HTML;
    "style.css" STYLE;
    "main.js" SCRIPT;
    "link.js" SCRIPT;
    "frame.js" SCRIPT;
    "labels.js" SCRIPT;
    "map.js" SCRIPT;
    "panels.js" SCRIPT;
    "curve.js" SCRIPT;
    "text.js" SCRIPT;
    "icon.svg" "image/svg+xml";
    "vendor/uPlot.iife.min.js" SCRIPT;
    "vendor/uPlot.min.css" STYLE;
    "vendor/b612-latin-400-normal.woff2" FONT;
    "vendor/b612-latin-700-normal.woff2" FONT;
    "vendor/b612-mono-latin-400-normal.woff2" FONT;
    "vendor/b612-mono-latin-700-normal.woff2" FONT;
};

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().expect("host"));
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().expect("origin"));
        }
        headers
    }

    #[test]
    fn only_this_page_may_use_the_server() {
        for (host, origin, allowed) in [
            ("127.0.0.1:8600", None, true),
            ("127.0.0.1:8600", Some("http://127.0.0.1:8600"), true),
            ("localhost:8600", Some("http://localhost:8600"), true),
            ("[::1]:8600", Some("http://[::1]:8600"), true),
            ("192.0.2.7", None, true),
            ("127.0.0.1:8600", Some("http://evil.example"), false),
            ("127.0.0.1:8600", Some("http://127.0.0.1:8601"), false),
            ("127.0.0.1:8600", Some("https://127.0.0.1:8600"), false),
            ("127.0.0.1:8600", Some("null"), false),
            ("evil.example:8600", None, false),
            ("evil.example:8600", Some("http://evil.example:8600"), false),
        ] {
            let answer = same_origin(&headers(host, origin));
            assert_eq!(answer.is_ok(), allowed, "{host} from {origin:?}: {answer:?}");
        }
    }

    #[test]
    fn a_taken_port_is_named_with_the_flag_that_helps() {
        let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = taken.local_addr().expect("address");
        let page = Page::new(Viewer::new(1 << 16));
        let error =
            serve(address, page, Box::new(|_, _| (true, String::new()))).err().expect("taken");
        let text = error.to_string();
        for part in [&address.to_string()[..], "taken", "--page"] {
            assert!(text.contains(part), "{text}");
        }
        assert!(!text.contains('\n'));
    }
}
