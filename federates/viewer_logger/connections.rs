//! The page's connections: how many there may be, and how long one may be without a whole request.

use axum::Router;
use axum::extract::Extension;
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
pub(super) struct Peer(pub(super) SocketAddr);

/// Connections at once; a WebSocket counts until it is one.
const MOST: usize = 256;
/// Of these, for one address beyond this host.
const MOST_OF_ONE_CLIENT: usize = 64;
/// How long the head of a request may take, and how long a connection may wait for its next request.
const HEAD_WITHIN: Duration = Duration::from_secs(5);
/// How long a connection may live that does not become a WebSocket; a browser opens another when it needs one.
const LIVES: Duration = Duration::from_secs(60);
/// How long to wait where the system takes no more connections.
const PAUSE: Duration = Duration::from_millis(100);

/// Serves `router` to everybody who connects, within the bounds above; beyond them a connection is closed at once.
pub(super) async fn serve(listener: &TcpListener, router: &Router) {
    let open = Arc::new(Mutex::new(BTreeMap::new()));
    loop {
        let (stream, from) = match listener.accept().await {
            Ok(accepted) => accepted,
            Err(error) => {
                // One that was given up meanwhile, or no file is free: the next may be had.
                tracing::debug!(%error, "the page took no connection");
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
        tracing::debug!(%error, "a connection to the page ended");
    }
}

type Open = Arc<Mutex<BTreeMap<IpAddr, usize>>>;

/// One of the places, free again when dropped.
struct Place(Open, IpAddr);

impl Place {
    fn take(open: &Open, client: IpAddr) -> Option<Self> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::Viewer;
    use crate::viewer_logger::server::{self, Page, Server};
    use std::io::{ErrorKind, Read, Write};
    use std::net::TcpStream;
    use std::time::Duration;

    fn page() -> Server {
        let here = "127.0.0.1:0".parse().expect("an address");
        server::serve(here, Page::new(Viewer::new(1 << 16)), Box::new(|_, _| (true, String::new())))
            .expect("served")
    }

    fn connect(server: &Server) -> TcpStream {
        let stream = TcpStream::connect(server.address()).expect("connected");
        stream.set_read_timeout(Some(Duration::from_secs(30))).expect("set");
        stream
    }

    /// Reads to the end; whether the other side closed within the time-out.
    fn closed(stream: &mut TcpStream) -> bool {
        let mut rest = Vec::new();
        match stream.read_to_end(&mut rest) {
            Ok(_) => true,
            Err(e) => !matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
        }
    }

    fn whole(server: &Server) -> bool {
        let mut stream = connect(server);
        let request = format!(
            "GET /icon.svg HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n",
            server.address()
        );
        if stream.write_all(request.as_bytes()).is_err() {
            return false;
        }
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).is_ok() && answer.starts_with(b"HTTP/1.1 200")
    }

    #[test]
    fn half_a_request_is_let_go_and_holds_nobody_up() {
        let server = page();
        let mut silent = connect(&server);
        let mut half = connect(&server);
        half.write_all(b"GET / HTTP/1.1\r\nHost: ").expect("sent");
        assert!(whole(&server), "others are served meanwhile");
        assert!(closed(&mut half), "half a request is not held for ever");
        assert!(closed(&mut silent), "nor is none");
        server.stop();
    }

    #[test]
    fn a_connection_beyond_the_bound_is_closed_and_a_place_comes_free() {
        let server = page();
        let held: Vec<TcpStream> = (0..MOST).map(|_| connect(&server)).collect();
        let mut one_too_many = connect(&server);
        assert!(closed(&mut one_too_many));
        drop(held);
        let free = (0..200).any(|_| {
            std::thread::sleep(Duration::from_millis(20));
            whole(&server)
        });
        assert!(free, "places come free");
        server.stop();
    }

    #[test]
    fn one_client_beyond_this_host_takes_a_share_only() {
        let open = Open::default();
        let client: IpAddr = [192, 0, 2, 7].into();
        let mut held: Vec<_> = (0..MOST).map_while(|_| Place::take(&open, client)).collect();
        assert_eq!(held.len(), MOST_OF_ONE_CLIENT);
        assert!(Place::take(&open, [192, 0, 2, 8].into()).is_some());
        held.pop();
        assert!(Place::take(&open, client).is_some());
        drop(held);
        assert!(open.lock().expect("sound").is_empty(), "nothing is kept of who has left");
    }
}
