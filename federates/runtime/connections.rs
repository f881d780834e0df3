//! Connections to a port for browsers: how many there may be, how long one may be without a whole request, and whom it answers.

use axum::Router;
use axum::extract::Extension;
use axum::http::{HeaderMap, header};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{sleep, timeout};

/// Who is at the other end of a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer(pub(crate) SocketAddr);

/// Connections at once; a WebSocket counts until it is one.
pub(crate) const MOST: usize = 256;
/// Of these, for one address beyond this host.
pub(crate) const MOST_OF_ONE_CLIENT: usize = 64;
/// How long the head of a request may take, and how long a connection may wait for its next request.
const HEAD_WITHIN: Duration = Duration::from_secs(5);
/// How long a connection may live that does not become a WebSocket; a browser opens another when it needs one.
const LIVES: Duration = Duration::from_secs(60);
/// How long to wait where the system takes no more connections.
const PAUSE: Duration = Duration::from_millis(100);

/// Serves `router` to everybody who connects, within the bounds above; beyond them a connection is closed at once.
pub(crate) async fn serve(listener: &TcpListener, router: &Router) {
    let open = Arc::new(Mutex::new(BTreeMap::new()));
    loop {
        let (stream, from) = match listener.accept().await {
            Ok(accepted) => accepted,
            Err(error) => {
                // One that was given up meanwhile, or no file is free: the next may be had.
                tracing::debug!(%error, "a port for browsers took no connection");
                sleep(PAUSE).await;
                continue;
            }
        };
        let Some(place) = Place::take(&open, from.ip()) else { continue };
        let router = router.clone().layer(Extension(Peer(from)));
        tokio::spawn(async move {
            one(stream, router).await;
            drop(place);
        });
    }
}

async fn one(stream: TcpStream, router: Router) {
    stream.set_nodelay(true).ok();
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD_WITHIN);
    let connection = http
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router))
        .with_upgrades();
    if let Ok(Err(error)) = timeout(LIVES, connection).await {
        tracing::debug!(%error, "a connection of a browser ended");
    }
}

pub(crate) type Open = Arc<Mutex<BTreeMap<IpAddr, usize>>>;

/// One of the places, free again when dropped.
pub(crate) struct Place(Open, IpAddr);

impl Place {
    pub(crate) fn take(open: &Open, client: IpAddr) -> Option<Self> {
        let mut by_client = open.lock().unwrap_or_else(PoisonError::into_inner);
        let own = by_client.get(&client).copied().unwrap_or(0);
        let full = by_client.values().sum::<usize>() >= MOST;
        if full || (!client.is_loopback() && own >= MOST_OF_ONE_CLIENT) {
            return None;
        }
        by_client.insert(client, own + 1);
        Some(Self(Arc::clone(open), client))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut by_client = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = by_client.get_mut(&self.1) {
            *own -= 1;
            if *own == 0 {
                by_client.remove(&self.1);
            }
        }
    }
}

/// The request names this host by address or as `localhost`, and comes from no other page.
pub(crate) fn same_origin(headers: &HeaderMap) -> Result<(), &'static str> {
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
        // A TLS proxy in front, which passes the name of the host on, makes it https.
        Some(origin)
            if !["http", "https"]
                .iter()
                .any(|scheme| origin.eq_ignore_ascii_case(&format!("{scheme}://{host}"))) =>
        {
            Err("another page may not use this one")
        }
        _ => Ok(()), // programs that are no browsers send none
    }
}
