//! The page's connections, within the bounds of every port for browsers.

pub(super) use crate::runtime::connections::{Peer, serve};

#[cfg(test)]
mod tests {
    use crate::runtime::connections::{MOST, MOST_OF_ONE_CLIENT, Open, Place};
    use crate::viewer_logger::Viewer;
    use crate::viewer_logger::server::{self, Page, Server};
    use std::io::{ErrorKind, Read, Write};
    use std::net::{IpAddr, TcpStream};
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
