//! PDUs per second over loopback with nothing lost, sender and receiver in threads of one process.
//!
//! The sender stays at most a window of PDUs ahead of the receiver, so what is measured is the pace
//! that both keep up together; a single PDU lost fails the run. The processor time of each thread
//! tells what a host does that has nothing else to do. `cargo bench -p datalink`.

#![expect(clippy::print_stdout, reason = "a bench tells its result")]
#![expect(clippy::unwrap_used, reason = "a bench stops where it fails")]
#![expect(clippy::disallowed_methods, reason = "a bench reads the clock")]

use datalink::{Bundle, Link, LinkConfig, Packing};
use nix::sys::resource::{UsageWho, getrusage};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Octets of an Entity State PDU without variable parameters.
const PDU: usize = 144;
/// PDUs on the way at most.
const WINDOW: u64 = 4000;
/// PDUs handed over in one call.
const BURST: u64 = 576;

struct Result {
    pdus: u64,
    took: Duration,
    /// Processor time of the sending thread, the system's part included.
    sending: Duration,
    /// Processor time of the receiving thread.
    receiving: Duration,
    lost: u64,
    datagrams: u64,
}

/// Processor time that this thread has used.
fn cpu_time() -> Duration {
    let usage = getrusage(UsageWho::RUSAGE_THREAD).unwrap();
    let of = |t: nix::sys::time::TimeVal| {
        Duration::new(t.tv_sec() as u64, 0) + Duration::from_micros(t.tv_usec() as u64)
    };
    of(usage.user_time()) + of(usage.system_time())
}

fn run(host: &str, packing: Packing, wanted: u64, most: Duration) -> Result {
    let port = datalink::free_port().unwrap();
    let to = format!("{host}:{port}").parse().unwrap();
    let config = LinkConfig { to, packing, ..LinkConfig::default() };
    let (mut sender, mut receiver) = Link::open(&config).unwrap();
    let received = Arc::new(AtomicU64::new(0));
    let done = Arc::new(AtomicBool::new(false));
    let (count, end) = (received.clone(), done.clone());
    let thread = std::thread::spawn(move || {
        let mut datagrams = 0;
        loop {
            let mut octets = 0;
            let got = receiver
                .receive(Some(Duration::from_millis(20)), |a| octets += a.payload.len())
                .unwrap();
            count.fetch_add((octets / PDU) as u64, Ordering::Release);
            datagrams += got.datagrams as u64;
            if got.datagrams == 0 && end.load(Ordering::Acquire) {
                return (datagrams, receiver.dropped_now(), cpu_time());
            }
        }
    });
    let pdu = [7u8; PDU];
    let (start, cpu) = (Instant::now(), cpu_time());
    let mut sent = 0;
    while sent < wanted && start.elapsed() < most {
        while sent + BURST > received.load(Ordering::Acquire) + WINDOW {
            // Asleep, not spinning: the receiver may need the processor.
            std::thread::sleep(Duration::from_micros(20));
            if start.elapsed() > most {
                break;
            }
        }
        sender.send_all((0..BURST).map(|_| &pdu[..])).unwrap();
        sent += BURST;
    }
    while received.load(Ordering::Acquire) < sent && start.elapsed() < 2 * most {
        std::thread::sleep(Duration::from_micros(20));
    }
    let (took, sending) = (start.elapsed(), cpu_time() - cpu);
    done.store(true, Ordering::Release);
    let (datagrams, dropped, receiving) = thread.join().unwrap();
    let arrived = received.load(Ordering::Acquire);
    assert!(dropped == 0 || arrived < sent, "the system counts {dropped} but nothing is missing");
    Result { pdus: arrived, took, sending, receiving, lost: sent - arrived, datagrams }
}

fn main() {
    let bundle = Some(Bundle::default());
    println!("{PDU} octets a PDU, window {WINDOW} PDUs, best of 3");
    let mut failed = false;
    for (name, packing, wanted) in [
        ("one PDU a datagram", Packing { bundle: None, offload: false }, 600_000),
        ("one PDU a datagram, offload", Packing { bundle: None, offload: true }, 1_000_000),
        ("bundles", Packing { bundle, offload: false }, 4_000_000),
        ("bundles, offload", Packing { bundle, offload: true }, 4_000_000),
    ] {
        for (kind, host) in [("unicast", "127.0.0.1"), ("broadcast", "127.255.255.255")] {
            let runs: Vec<Result> =
                (0..3).map(|_| run(host, packing, wanted, Duration::from_secs(4))).collect();
            let lost: u64 = runs.iter().map(|r| r.lost).sum();
            let best = runs.iter().max_by(|a, b| rate(a).total_cmp(&rate(b))).unwrap();
            let each = |of: fn(&Result) -> Duration| {
                runs.iter().map(|r| of(r).as_nanos() as u64 / r.pdus.max(1)).min().unwrap()
            };
            let (sending, receiving) = (each(|r| r.sending), each(|r| r.receiving));
            let datagrams = best.datagrams as f64 / best.took.as_secs_f64();
            println!(
                "{name:<28} {kind:<9} {:>8.0} PDU/s {datagrams:>7.0} datagrams/s, lost {lost}; \
                 processor ns/PDU: sender {sending}, receiver {receiving}",
                rate(best),
            );
            failed |= lost > 0;
        }
    }
    assert!(!failed, "PDUs were lost");
}

fn rate(r: &Result) -> f64 {
    r.pdus as f64 / r.took.as_secs_f64()
}
