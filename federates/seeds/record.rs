//! `seeds record`: every datagram that arrives, into a file that Wireshark opens.

use super::link_args::LinkArgs;
use crate::runtime::clock::monotonic_ns;
use anyhow::Context;
use capture::Recorder;
use capture::tools::json;
use clap::Args;
use datalink::Receiver;
use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Record every DIS datagram that arrives into a pcapng file, sound or not, until Ctrl-C
#[derive(Args, Clone, Debug)]
pub struct RecordArgs {
    /// File to write (overwritten if it is there)
    file: PathBuf,

    #[command(flatten)]
    link: LinkArgs,

    /// Record what arrives here instead of DIS: ASTERIX to this host, group or broadcast address
    #[arg(long, value_name = "ADDR:PORT", conflicts_with = "dis")]
    asterix: Option<datalink::Destinations>,

    /// End after so many seconds [default: at Ctrl-C]
    #[arg(long, value_name = "S", value_parser = seconds)]
    duration: Option<f64>,

    /// No progress on stderr
    #[arg(long)]
    quiet: bool,
}

/// How often progress is shown.
const PROGRESS_NS: u64 = 1_000_000_000;

/// Records until Ctrl-C or the end of `--duration`; the last line on stdout is a JSON summary. Exit
/// code 3 if datagrams were lost: by a full disk, or by the system because they came too fast.
///
/// # Errors
/// If the file cannot be made or the link not be opened.
pub fn run(args: RecordArgs) -> anyhow::Result<ExitCode> {
    let mut link = args.link.config()?;
    if let Some(asterix) = &args.asterix {
        link.to = asterix.clone();
        // One host is listened for at its own address and port.
        let own = asterix.first();
        link.listen = link.listen.or((own.is_ipv4() && !leaves(own)).then_some(own));
    }
    let mut receiver = Receiver::open(&link)?;
    let name = args.file.display().to_string();
    let mut recorder =
        Recorder::create(&args.file).with_context(|| format!("making the recording {name}"))?;
    for warning in receiver.warnings() {
        remark(&warning.to_string());
    }
    let stop = Arc::new(AtomicBool::new(false));
    let (stopping, waker) = (Arc::clone(&stop), receiver.waker());
    ctrlc::set_handler(move || {
        if stopping.swap(true, Ordering::SeqCst) {
            // Asked twice: at once. What was flushed is safe.
            std::process::exit(1);
        }
        waker.wake();
    })
    .context("listening for Ctrl-C")?;
    let show = !args.quiet && io::stderr().is_terminal();
    if !args.quiet {
        remark(&format!("recording {} into {name}, Ctrl-C ends", receiver.address()));
    }

    let start = monotonic_ns();
    let end = args.duration.map(|s| start + (s * 1e9) as u64);
    let (mut octets, mut shown_at) = (0u64, start);
    while !stop.load(Ordering::SeqCst) {
        let now = monotonic_ns();
        if end.is_some_and(|end| now >= end) {
            break;
        }
        let until = end.map_or(u64::MAX, |end| end - now);
        let wait = Duration::from_nanos(until.min(PROGRESS_NS));
        let mut failed = None;
        receiver.receive(Some(wait), |a| {
            octets += a.payload.len() as u64;
            if let Err(e) = recorder.record(a.utc_ns, a.from, a.to, a.payload) {
                failed = Some(e);
            }
        })?;
        // What came is with the system before the next is waited for.
        if let Err(e) = recorder.flush() {
            failed = Some(e);
        }
        if let Some(e) = failed {
            remark(&e.to_string());
        }
        if show && now - shown_at >= PROGRESS_NS {
            shown_at = now;
            let s = (now - start) / 1_000_000_000;
            let (n, mb) = (recorder.recorded(), octets as f64 / 1e6);
            let lost = recorder.lost() + receiver.dropped_now();
            let _ = write!(io::stderr(), "\r{s} s  {n} datagrams  {mb:.1} MB  {lost} lost   ");
        }
    }
    if show {
        let _ = writeln!(io::stderr());
    }
    let dropped = receiver.dropped_now();
    let (recorded, lost) = (recorder.recorded(), recorder.lost());
    let closed = recorder.close(dropped);
    let line = json::Object::default()
        .text("file", &name)
        .raw("datagrams", recorded)
        .raw("octets", octets)
        .raw("lost", lost)
        .raw("dropped_by_system", dropped)
        .raw("wall_s", format_args!("{:.3}", (monotonic_ns() - start) as f64 * 1e-9))
        .end();
    writeln!(io::stdout(), "{line}")?;
    if let Err(e) = &closed {
        remark(&e.to_string());
    }
    let complete = closed.is_ok() && lost == 0 && dropped == 0;
    Ok(if complete { ExitCode::SUCCESS } else { ExitCode::from(3) })
}

/// Whether an address is a group or a broadcast address.
fn leaves(address: std::net::SocketAddr) -> bool {
    !matches!(datalink::Destination::of(address), datalink::Destination::Host(_))
}

/// A line for people.
fn remark(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v < 1e9 => Ok(v),
        _ => Err("a number of seconds above 0 is needed".to_owned()),
    }
}
