//! Prints every record that arrives: `cargo run -p asterix --example asterix_listen -- 239.9.1.1:8600 [seconds]`.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program for a terminal")]

use asterix::{blocks, json};
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::time::Duration;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let address: SocketAddrV4 = arguments.next().ok_or("which address and port?")?.parse()?;
    let seconds = arguments.next().map_or(Ok(60), |s| s.parse())?;
    let socket = if address.ip().is_multicast() {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, address.port()))?;
        socket.join_multicast_v4(address.ip(), &Ipv4Addr::LOCALHOST)?;
        socket
    } else {
        UdpSocket::bind(address)?
    };
    socket.set_read_timeout(Some(Duration::from_secs(seconds)))?;
    let mut buffer = [0; 65_535];
    while let Ok((length, from)) = socket.recv_from(&mut buffer) {
        for block in blocks(&buffer[..length]) {
            match block {
                Ok(block) => {
                    for record in block.records() {
                        match record {
                            Ok(record) => println!("{:03} {}", block.number, json::record(&record)),
                            Err(e) => eprintln!("{from}: {e}"),
                        }
                    }
                }
                Err(e) => eprintln!("{from}: {e}"),
            }
        }
    }
    Ok(())
}
