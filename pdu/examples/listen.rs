//! Prints what arrives on a UDP port, until ten seconds pass without a datagram.
//!
//! `cargo run -p pdu --example listen [ADDRESS:PORT]`, by default 127.0.0.1:3000.
#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use geodesy::Ecef;
use pdu::{Body, pdus};
use std::error::Error;
use std::io::ErrorKind;
use std::net::UdpSocket;
use std::time::Duration;

fn main() -> Result<(), Box<dyn Error>> {
    let at = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1:3000".to_owned());
    let socket = UdpSocket::bind(&at)?;
    socket.set_read_timeout(Some(Duration::from_secs(10)))?;
    println!("listening on {at}");
    let mut buffer = vec![0; 65536];
    loop {
        let (length, from) = match socket.recv_from(&mut buffer) {
            Ok(received) => received,
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => break,
            Err(e) => return Err(e.into()),
        };
        for received in pdus(&buffer[..length]) {
            match received {
                Ok(received) => print(received.header(), received.body()),
                Err(damaged) => println!("from {from}: {damaged}"),
            }
        }
    }
    println!("nothing for ten seconds");
    Ok(())
}

fn print(header: &pdu::Header, body: &Body<'_>) {
    let Body::EntityState(state) = body else {
        println!("{} {}", header.timestamp, header.pdu_type);
        return;
    };
    let place = Ecef::from(state.location).to_geodetic();
    println!(
        "{} {} {:12} {:11.6}° {:11.6}° {:7.1} m {:6.1} m/s",
        header.timestamp,
        state.entity_id,
        state.marking.text(),
        place.lat_deg(),
        place.lon_deg(),
        place.height_m,
        geodesy::length(state.linear_velocity_mps.to_f64()),
    );
}
