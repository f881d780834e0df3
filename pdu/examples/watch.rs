//! Prints where every entity of an exercise is, once a second, until ten seconds pass without a datagram.
//!
//! `cargo run -p pdu --example watch [ADDRESS:PORT] [EXERCISE]`, by default 127.0.0.1:3000 and 1.
#![expect(clippy::print_stdout, reason = "an example talks to its user")]
#![expect(clippy::disallowed_methods, reason = "the example's own clock")]

use pdu::exercise::{Arrival, Exercise};
use std::error::Error;
use std::io::ErrorKind;
use std::net::UdpSocket;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let at = arguments.next().unwrap_or_else(|| "127.0.0.1:3000".to_owned());
    let id = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let socket = UdpSocket::bind(&at)?;
    socket.set_read_timeout(Some(Duration::from_secs(10)))?;
    let mut exercise = Exercise::new(id);
    let mut buffer = vec![0; 65536];
    let mut shown_ns = 0;
    loop {
        let length = match socket.recv_from(&mut buffer) {
            Ok((length, _)) => length,
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => break,
            Err(e) => return Err(e.into()),
        };
        let now_ns = i64::try_from(SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos())?;
        exercise.feed(&Arrival::in_real_time(now_ns), &buffer[..length]);
        if now_ns - shown_ns < 1_000_000_000 {
            continue;
        }
        shown_ns = now_ns;
        for (entity, placed) in exercise.at(now_ns) {
            let place = placed.estimate.location.to_geodetic();
            println!(
                "{} {:11} {:11.6}° {:11.6}° {:7.1} m {:6.1} m/s, {:.2} s old",
                entity.id(),
                entity.marking(),
                place.lat_deg(),
                place.lon_deg(),
                place.height_m,
                geodesy::length(placed.estimate.velocity_mps),
                placed.age_s,
            );
        }
        for ((site, application), clock) in exercise.senders() {
            println!(
                "  {site}:{application}: clock {:+.3} s, delay {:.3} s",
                -clock.offset_s, clock.delay_s
            );
        }
        exercise.forget_before(now_ns - 1_000_000_000);
    }
    println!("nothing for ten seconds");
    Ok(())
}
