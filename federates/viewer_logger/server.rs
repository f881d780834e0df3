//! The page's server: static files out of the executable and one WebSocket a browser, on a thread of its own.
//!
//! Who may do what stands in [`crate::runtime::access`], how many connections there are in `connections`.

mod asked_for;
mod at_seat;
mod authoring;
mod dial;
mod fork;
mod socket;

use super::Viewer;
use super::assets;
use super::author::Author;
use super::connections::{self, Peer};
use super::forks::Forks;
use super::session::MOST_RUNS;
use super::source::Source;
use crate::runtime::access::{Access, Ticket};
use crate::runtime::connections::same_origin;
use crate::runtime::messages::{Command, SeatAnswer, SeatOrder};
use axum::body::Body;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{DefaultBodyLimit, Extension, Query, Request, State};
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::{oneshot, watch};

/// What became of a command: whether it was carried out, and the state reached or the reason why not.
pub type Done = (bool, String);

/// Carries a command out and waits for the answer. Called on a thread that may block.
pub type Operate = Box<dyn Fn(&str, Command) -> Done + Send + Sync>;

/// Does something at a controller's seat and waits for the answer. Called on a thread that may block.
pub type Speak = Arc<dyn Fn(&SeatOrder) -> Result<SeatAnswer, String> + Send + Sync>;

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
    /// Other runs that are open beside it, finished or kept by somebody else.
    others: Mutex<Vec<Viewer>>,
    /// What makes forks, where they can be made.
    forks: Mutex<Option<Arc<Forks>>>,
    /// What carries the words of people at seats, where somebody does.
    speak: Mutex<Option<Speak>>,
    /// The scene that a person writes, where somebody does.
    author: Mutex<Option<Arc<Author>>>,
    /// Who sits where.
    people: Mutex<at_seat::People>,
    /// Held by each comparison on a finished run, for as long as it works.
    comparisons: Arc<()>,
    version: watch::Sender<u64>,
}

impl Page {
    /// Shares `viewer`.
    #[must_use]
    pub fn new(viewer: Viewer) -> Arc<Self> {
        let version = watch::Sender::new(viewer.version());
        Arc::new(Self {
            viewer: Mutex::new(viewer),
            others: Mutex::default(),
            forks: Mutex::default(),
            speak: Mutex::default(),
            author: Mutex::default(),
            people: Mutex::default(),
            comparisons: Arc::default(),
            version,
        })
    }

    /// Puts another run beside the first, and says what it is called here: two folders of one name are two runs.
    pub fn add(&self, mut viewer: Viewer) -> String {
        let first = self.viewer();
        let mut others = self.others();
        let taken = |id: &str| first.id() == id || others.iter().any(|v| v.id() == id);
        let own = viewer.id().to_owned();
        let more = (2_u32..).map(|n| format!("{own}-{n}"));
        let mut named = std::iter::once(own.clone()).chain(more);
        let id = named.find(|id| !taken(id)).unwrap_or_default();
        viewer.set_id(&id);
        others.push(viewer);
        drop((others, first));
        self.wake();
        id
    }

    /// From now on people may sit down at controllers' seats.
    pub fn let_speak(&self, speak: Speak) {
        *self.speak.lock().unwrap_or_else(PoisonError::into_inner) = Some(speak);
    }

    /// From now on pages may write this scene.
    pub fn let_write(&self, author: Arc<Author>) {
        *self.author.lock().unwrap_or_else(PoisonError::into_inner) = Some(author);
    }

    /// From now on pages may ask for forks.
    pub fn make_forks(&self, forks: Arc<Forks>) {
        *self.forks.lock().unwrap_or_else(PoisonError::into_inner) = Some(forks);
    }

    pub(super) fn forks(&self) -> Option<Arc<Forks>> {
        self.forks.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The database of the run of this name, where there is room for a fork of it.
    pub(super) fn database_of(&self, run: &str) -> Result<PathBuf, &'static str> {
        self.with_all(|all| {
            let viewer = all.iter().find(|v| v.id() == run).ok_or("there is no such run")?;
            let database = viewer.database();
            let database = database.ok_or("forks are made of finished runs; this one goes on")?;
            if all.len() >= MOST_RUNS {
                return Err("eight runs are open already: open fewer to make a fork");
            }
            Ok(database.to_owned())
        })
    }

    /// Looks at the scans of the run of this name.
    pub(super) fn with_source<T>(
        &self,
        run: &str,
        look: impl FnOnce(&dyn Source) -> T,
    ) -> Option<T> {
        self.with_all(|all| Some(look(all.iter().find(|v| v.id() == run)?.source())))
    }

    /// Looks at the run of this name, at the first where none is named.
    fn with_run<T>(&self, run: &str, look: impl FnOnce(&Viewer) -> T) -> Option<T> {
        self.with_all(|all| Some(look(all.iter().find(|v| run.is_empty() || v.id() == run)?)))
    }

    /// Tells a topic to everybody, whichever run they look at.
    pub(super) fn tell_all(&self, topic: &'static str, message: &serde_json::Value) {
        self.viewer().tell(topic, message.clone());
        for other in self.others().iter_mut() {
            other.tell(topic, message.clone());
        }
        self.wake();
    }

    /// Takes in what runs that others keep have grown by.
    pub fn follow(&self) {
        let mut grown = self.viewer().follow();
        for other in self.others().iter_mut() {
            grown |= other.follow();
        }
        if grown {
            self.wake();
        }
    }

    fn people(&self) -> MutexGuard<'_, at_seat::People> {
        self.people.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn others(&self) -> MutexGuard<'_, Vec<Viewer>> {
        self.others.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does something with all runs at once, the first one first.
    fn with_all<T>(&self, look: impl FnOnce(&[&Viewer]) -> T) -> T {
        let (viewer, others) = (self.viewer(), self.others());
        let all: Vec<&Viewer> = std::iter::once(&*viewer).chain(others.iter()).collect();
        look(&all)
    }

    /// Changes the viewer and wakes the browsers.
    pub fn update(&self, change: impl FnOnce(&mut Viewer)) {
        let mut viewer = self.viewer();
        change(&mut viewer);
        drop(viewer);
        self.wake();
    }

    /// Something is to be sent to a browser.
    fn wake(&self) {
        self.version.send_modify(|v| *v = v.wrapping_add(1));
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
    access: Arc<Access>,
    stop: oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

impl Server {
    /// Where it listens; with the port that the system chose if 0 was asked for.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What a browser must show to be let in.
    #[must_use]
    pub fn access(&self) -> &Access {
        &self.access
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
    let access = Arc::new(Access::at(address).map_err(PageError::Start)?);
    let state =
        Arc::new(Shared { page, operate, access: Arc::clone(&access), browsers: Mutex::default() });
    let body = move || {
        runtime.block_on(async {
            let accept = async {
                match tokio::net::TcpListener::from_std(socket) {
                    Ok(listener) => {
                        connections::serve(&listener, &router(state)).await;
                        None
                    }
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
    Ok(Server { address, access, stop, thread })
}

struct Shared {
    page: Arc<Page>,
    operate: Operate,
    access: Arc<Access>,
    /// WebSockets by client.
    browsers: Mutex<BTreeMap<IpAddr, usize>>,
}

impl Shared {
    fn browsers(&self) -> MutexGuard<'_, BTreeMap<IpAddr, usize>> {
        self.browsers.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One of the places for browsers, free again when dropped.
struct Seat(Arc<Shared>, IpAddr);

impl Seat {
    /// # Errors
    /// All places, or all of this client, are taken: what to say.
    fn take(shared: &Arc<Shared>, client: IpAddr) -> Result<Self, String> {
        let mut browsers = shared.browsers();
        let own = browsers.get(&client).copied().unwrap_or(0);
        if browsers.values().sum::<usize>() >= MAX_BROWSERS {
            return Err(format!("{MAX_BROWSERS} browsers watch already; close one\n"));
        }
        if !client.is_loopback() && own >= MAX_OF_ONE_CLIENT {
            return Err(format!("{own} browsers of {client} watch already; close one\n"));
        }
        browsers.insert(client, own + 1);
        drop(browsers);
        Ok(Self(Arc::clone(shared), client))
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut browsers = self.0.browsers();
        if let Some(own) = browsers.get_mut(&self.1) {
            *own -= 1;
            if *own == 0 {
                browsers.remove(&self.1);
            }
        }
    }
}

fn router(state: Arc<Shared>) -> axum::Router {
    axum::Router::new()
        .route("/socket", get(upgrade))
        .route("/metrics", get(asked_for::figures))
        .route("/detection", get(asked_for::detection))
        .route("/geometry", get(asked_for::geometry))
        .route("/rings", get(asked_for::rings))
        .route("/video", get(asked_for::turn))
        .route("/seats", get(at_seat::seats))
        .route("/seat", post(at_seat::act))
        .route("/author/scene", get(authoring::scene))
        .route("/author/act", authoring::acting())
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

async fn file(request: Request) -> Response {
    if ![Method::GET, Method::HEAD].contains(request.method()) {
        let allowed = [(header::ALLOW, "GET, HEAD")];
        return (StatusCode::METHOD_NOT_ALLOWED, allowed, "read only\n").into_response();
    }
    match assets::find(request.uri().path()) {
        Some((kind, octets)) => {
            ([(header::CONTENT_TYPE, kind)], Body::from(octets)).into_response()
        }
        None => (StatusCode::NOT_FOUND, "no such file\n").into_response(),
    }
}

/// Whose page it is that opens a socket, and whether it is the eye's, where it says so.
#[derive(serde::Deserialize)]
struct Whose {
    #[serde(default)]
    person: String,
    #[serde(default)]
    eye: bool,
}

async fn upgrade(
    socket: WebSocketUpgrade,
    headers: HeaderMap,
    Query(whose): Query<Whose>,
    Extension(Peer(peer)): Extension<Peer>,
    State(shared): State<Arc<Shared>>,
) -> Response {
    let ticket = match shared.access.ticket(&headers) {
        Ok(ticket) => ticket,
        Err(reason) => return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response(),
    };
    let seat = match Seat::take(&shared, peer.ip()) {
        Ok(seat) => seat,
        Err(reason) => return (StatusCode::SERVICE_UNAVAILABLE, reason).into_response(),
    };
    socket.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE).on_upgrade(
        async move |mut socket| {
            let rights = match ticket {
                Ticket::Let(rights) => rights,
                Ticket::AskToken => match socket::first_word(&mut socket, &shared.access).await {
                    Some(rights) => rights,
                    None => return,
                },
            };
            socket::browser(socket, &shared, rights, whose).await;
            drop(seat);
        },
    )
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
    "default-src 'self'; frame-ancestors 'self'; base-uri 'none'; form-action 'none'";
const MAX_BROWSERS: usize = 32;
/// Of these, for one address beyond this host.
const MAX_OF_ONE_CLIENT: usize = 8;
/// Longest message of a browser, octets.
const MAX_MESSAGE: usize = 4096;
/// How long an answer is waited for: longer than what carries a command out, which says after ten seconds how far that is.
const ANSWER: Duration = Duration::from_secs(13);

#[cfg(test)]
mod tests;
