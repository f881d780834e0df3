//! Programs that connect to a port of the gateway and are sent octets: Beast and SBS lines.
//!
//! Whoever does not read is dropped after 5 s or 1 MiB of backlog, counted and named. The gateway itself never waits.

use crossbeam_channel::{Receiver, Sender, unbounded};
use std::collections::BTreeMap;
use std::io::Write;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Octets that may wait for one client.
const BACKLOG: usize = 1 << 20;
/// How long a client may take no octet.
const STANDS: Duration = Duration::from_secs(5);
/// Clients of one port.
const MOST: usize = 64;
/// Names of dropped clients that are told.
const TOLD: usize = 8;

/// What a port has done.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// Clients now.
    pub clients: usize,
    /// Clients so far.
    pub in_all: u64,
    /// Octets given to the system, all clients together.
    pub octets: u64,
    /// Clients that did not read, the last ones by name.
    pub dropped: u64,
    /// Their addresses.
    pub dropped_names: Vec<String>,
    /// Clients that found all places taken.
    pub turned_away: u64,
}

struct Client {
    stream: TcpStream,
    queue: Sender<Arc<[u8]>>,
    waiting: Arc<AtomicUsize>,
}

#[derive(Default)]
struct Shared {
    clients: BTreeMap<SocketAddr, Client>,
    served: Served,
}

impl Shared {
    fn drop_slow(&mut self, who: SocketAddr) {
        if let Some(client) = self.clients.remove(&who) {
            client.stream.shutdown(Shutdown::Both).ok();
            self.served.dropped += 1;
            if self.served.dropped_names.len() < TOLD {
                self.served.dropped_names.push(who.to_string());
            }
            tracing::warn!("a client at {who} does not read: dropped");
        }
    }
}

/// A port that everybody may connect to.
pub struct Clients {
    shared: Arc<Mutex<Shared>>,
    address: SocketAddr,
    ends: Arc<AtomicBool>,
}

fn lock(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Clients {
    /// Listens.
    ///
    /// # Errors
    /// If the address cannot be listened on.
    pub fn listen(address: SocketAddr) -> std::io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let shared: Arc<Mutex<Shared>> = Arc::default();
        let ends = Arc::new(AtomicBool::new(false));
        let (of_all, until) = (Arc::clone(&shared), Arc::clone(&ends));
        std::thread::Builder::new().name("clients".into()).spawn(move || {
            for stream in listener.incoming() {
                if until.load(Ordering::SeqCst) {
                    break;
                }
                match stream {
                    Ok(stream) => welcome(stream, &of_all),
                    // No file is free, or it left again: the next may be had.
                    Err(_) => std::thread::sleep(Duration::from_millis(100)),
                }
            }
        })?;
        Ok(Self { shared, address, ends })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Sends the same octets to everybody.
    pub fn send(&self, octets: &[u8]) {
        if octets.is_empty() {
            return;
        }
        let octets: Arc<[u8]> = octets.into();
        let mut shared = lock(&self.shared);
        let slow: Vec<SocketAddr> = shared
            .clients
            .iter()
            .filter(|(_, client)| {
                let waiting = client.waiting.fetch_add(octets.len(), Ordering::SeqCst);
                waiting + octets.len() > BACKLOG || client.queue.send(Arc::clone(&octets)).is_err()
            })
            .map(|(who, _)| *who)
            .collect();
        slow.into_iter().for_each(|who| shared.drop_slow(who));
    }

    /// What was done so far.
    #[must_use]
    pub fn served(&self) -> Served {
        let shared = lock(&self.shared);
        Served { clients: shared.clients.len(), ..shared.served.clone() }
    }

    /// Waits up to `within` for what is still to be sent, and closes the port.
    pub fn close(&self, within: Duration) {
        let step = Duration::from_millis(10);
        for _ in 0..within.as_millis() / step.as_millis() {
            let waits =
                lock(&self.shared).clients.values().any(|c| c.waiting.load(Ordering::SeqCst) > 0);
            if !waits {
                break;
            }
            std::thread::sleep(step);
        }
        self.ends.store(true, Ordering::SeqCst);
        lock(&self.shared).clients.clear();
        // The thread waits for a client: this is one, so that it sees the end.
        TcpStream::connect_timeout(&self.address, Duration::from_millis(200)).ok();
    }
}

fn welcome(stream: TcpStream, shared: &Arc<Mutex<Shared>>) {
    let Ok(who) = stream.peer_addr() else { return };
    let mut all = lock(shared);
    if all.clients.len() >= MOST {
        all.served.turned_away += 1;
        return;
    }
    let (Ok(own), Ok(())) = (stream.try_clone(), stream.set_write_timeout(Some(STANDS))) else {
        return;
    };
    stream.set_nodelay(true).ok();
    let (queue, take) = unbounded();
    let waiting = Arc::new(AtomicUsize::new(0));
    all.clients.insert(who, Client { stream, queue, waiting: Arc::clone(&waiting) });
    all.served.in_all += 1;
    drop(all);
    let of_all = Arc::clone(shared);
    let named = std::thread::Builder::new().name("client".into());
    let started = named.spawn(move || write(own, who, &take, &waiting, &of_all));
    if started.is_err() {
        lock(shared).clients.remove(&who);
    }
}

fn write(
    mut stream: TcpStream,
    who: SocketAddr,
    take: &Receiver<Arc<[u8]>>,
    waiting: &AtomicUsize,
    shared: &Mutex<Shared>,
) {
    for octets in take {
        let written = stream.write_all(&octets);
        waiting.fetch_sub(octets.len(), Ordering::SeqCst);
        let mut all = lock(shared);
        match written {
            Ok(()) => all.served.octets += octets.len() as u64,
            Err(e)
                if matches!(
                    e.kind(),
                    std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
                ) =>
            {
                all.drop_slow(who);
                return;
            }
            Err(_) => {
                all.clients.remove(&who); // it left
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn until(mut holds: impl FnMut() -> bool) -> bool {
        (0..1000).any(|_| {
            std::thread::sleep(Duration::from_millis(10));
            holds()
        })
    }

    #[test]
    fn who_reads_gets_all_and_who_sleeps_is_dropped_and_named() {
        let port = Clients::listen("127.0.0.1:0".parse().expect("an address")).expect("a port");
        let mut reader = TcpStream::connect(port.address()).expect("connected");
        let sleeper = TcpStream::connect(port.address()).expect("connected");
        let name = sleeper.local_addr().expect("its address").to_string();
        assert!(until(|| port.served().clients == 2));
        let piece = vec![7_u8; 64 << 10];
        let (count, mut buffer) = (160, vec![0; 64 << 10]);
        for _ in 0..count {
            port.send(&piece);
            reader.read_exact(&mut buffer).expect("all of it");
            assert_eq!(buffer, piece);
        }
        assert!(until(|| port.served().clients == 1), "{:?}", port.served());
        let served = port.served();
        assert_eq!((served.dropped, served.dropped_names, served.in_all), (1, vec![name], 2));
        drop(reader);
        assert!(until(|| {
            port.send(b"anybody?");
            port.served().clients == 0
        }));
        assert_eq!(port.served().dropped, 1, "one that leaves is not slow");
        port.close(Duration::from_millis(100));
        assert!(until(|| TcpStream::connect(port.address()).is_err()));
    }
}
