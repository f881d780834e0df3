//! Who may look at the page and at the run over HTTP, and who may command it from the page.
//!
//! A request must name this host by address or as `localhost` (no name that somebody else's DNS could point here),
//! and a WebSocket must come from a page of the same origin or show a token. On loopback the page itself needs none;
//! where the page can be reached from elsewhere, everybody does: two are drawn at each start, one to command and one to
//! look.

#[cfg(test)]
use super::connections::same_origin;
use axum::http::{HeaderMap, header};
use serde::Deserialize;
use std::net::SocketAddr;

/// What a browser may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rights {
    /// See the run.
    Look,
    /// See it and command it.
    Command,
}

/// What becomes of a WebSocket that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ticket {
    /// It has shown all that is needed.
    Let(Rights),
    /// Its first message must be a token.
    AskToken,
}

/// What is said to somebody who may not command.
pub(crate) const LOOK_ONLY: &str = "this address of the page is for looking; the other one that was printed at the start may command";

/// 128 random bits as 32 hexadecimal digits. Neither printed by `Debug` nor logged.
struct Token(String);

impl Token {
    /// # Errors
    /// If the system has no random numbers.
    fn draw() -> std::io::Result<Self> {
        let mut bits = [0; 16];
        getrandom::fill(&mut bits)?;
        Ok(Self(bits.iter().map(|octet| format!("{octet:02x}")).collect()))
    }

    /// Compares in a time that does not tell how many digits are right.
    fn is(&self, shown: &str) -> bool {
        use subtle::ConstantTimeEq;
        self.0.as_bytes().ct_eq(shown.as_bytes()).into()
    }
}

/// What a browser must show to be let in.
pub struct Access {
    address: SocketAddr,
    command: Token,
    look: Token,
}

impl Access {
    /// Access to a page at `address`, with tokens of its own.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn at(address: SocketAddr) -> std::io::Result<Self> {
        Ok(Self { address, command: Token::draw()?, look: Token::draw()? })
    }

    /// The page's address, with the token that may command where one is needed.
    #[must_use]
    pub fn url(&self) -> String {
        self.with(&self.command)
    }

    /// The page's address for those who may only look; none where no token is needed.
    #[must_use]
    pub fn url_to_look(&self) -> Option<String> {
        self.needs_token().then(|| self.with(&self.look))
    }

    fn with(&self, token: &Token) -> String {
        let address = self.address;
        if !self.needs_token() {
            return format!("http://{address}/");
        }
        format!("http://{address}/#key={}", token.0)
    }

    fn needs_token(&self) -> bool {
        !self.address.ip().is_loopback()
    }

    /// What a program adds to an address of this port to look: nothing where no token is needed.
    #[must_use]
    pub fn key_to_look(&self) -> String {
        if self.needs_token() { format!("?key={}", self.look.0) } else { String::new() }
    }

    /// What is said to somebody without a sound token.
    pub(crate) fn needed(&self) -> &'static str {
        "this page needs a token: open the address that was printed where the run was started (http://…/#key=…)"
    }

    /// Who asks for a WebSocket, by the request's head.
    ///
    /// # Errors
    /// Why it is refused.
    pub(crate) fn ticket(&self, headers: &HeaderMap) -> Result<Ticket, &'static str> {
        let text = |name| headers.get(name).and_then(|v: &header::HeaderValue| v.to_str().ok());
        if let Some(shown) = text(header::AUTHORIZATION) {
            let token = shown.strip_prefix("Bearer ").unwrap_or_default();
            return self.rights(token).map(Ticket::Let).ok_or(self.needed());
        }
        match text(header::ORIGIN) {
            _ if self.needs_token() => Ok(Ticket::AskToken),
            Some(_) => Ok(Ticket::Let(Rights::Command)), // same origin: checked for every request
            None => Err("a WebSocket needs the Origin of this page: http://ADDRESS:PORT"),
        }
    }

    /// Whether a request without a WebSocket may read the run.
    ///
    /// # Errors
    /// Why it is refused.
    pub(crate) fn may_read(&self, headers: &HeaderMap) -> Result<(), &'static str> {
        let shown = headers.get(header::AUTHORIZATION).and_then(|v| v.to_str().ok());
        match shown.and_then(|text| text.strip_prefix("Bearer ")) {
            Some(token) => self.rights(token).map(drop).ok_or(self.needed()),
            None if self.needs_token() => Err(self.needed()),
            None => Ok(()),
        }
    }

    /// The same for programs that set no header: a token may also stand in the address, as `key=` of its query.
    ///
    /// # Errors
    /// Why it is refused.
    pub(crate) fn may_read_with(&self, headers: &HeaderMap, query: &str) -> Result<(), String> {
        let words = "this port needs a token beyond loopback: ?key=TOKEN, or Authorization: Bearer TOKEN, as printed where the run was started";
        let key = query.split('&').find_map(|pair| pair.strip_prefix("key="));
        match key.filter(|_| !headers.contains_key(header::AUTHORIZATION)) {
            Some(key) => self.rights(key).map(drop).ok_or(words.to_owned()),
            None => self.may_read(headers).map_err(|_| words.to_owned()),
        }
    }

    /// Whether a request without a WebSocket may command the run: who shows the token, and on loopback a program of this host
    /// (a page of somebody else is refused before, by its origin).
    ///
    /// # Errors
    /// Why it is refused.
    pub(crate) fn may_command(&self, headers: &HeaderMap) -> Result<(), &'static str> {
        let shown = headers.get(header::AUTHORIZATION).and_then(|v| v.to_str().ok());
        match shown.and_then(|text| text.strip_prefix("Bearer ")).map(|token| self.rights(token)) {
            Some(Some(Rights::Command)) => Ok(()),
            Some(Some(Rights::Look)) => Err(LOOK_ONLY),
            None if !self.needs_token() => Ok(()),
            _ => Err(self.needed()),
        }
    }

    /// What a browser's first message gives it.
    pub(crate) fn rights_of_message(&self, text: &str) -> Option<Rights> {
        #[derive(Deserialize)]
        #[serde(tag = "type", rename_all = "lowercase")]
        enum First {
            Token { token: String },
        }
        let First::Token { token } = serde_json::from_str(text).ok()?;
        self.rights(&token)
    }

    fn rights(&self, token: &str) -> Option<Rights> {
        match () {
            () if self.command.is(token) => Some(Rights::Command),
            () if self.look.is(token) => Some(Rights::Look),
            () => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().expect("host"));
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().expect("origin"));
        }
        headers
    }

    fn at(address: &str) -> Access {
        Access::at(address.parse().expect("an address")).expect("random numbers")
    }

    #[test]
    fn only_this_page_may_use_the_server() {
        for (host, origin, allowed) in [
            ("127.0.0.1:8600", None, true),
            ("127.0.0.1:8600", Some("http://127.0.0.1:8600"), true),
            ("localhost:8600", Some("http://localhost:8600"), true),
            ("[::1]:8600", Some("http://[::1]:8600"), true),
            ("192.0.2.7", None, true),
            ("127.0.0.1:8600", Some("http://evil.example"), false),
            ("127.0.0.1:8600", Some("http://127.0.0.1:8601"), false),
            ("192.0.2.7", Some("https://192.0.2.7"), true),
            ("192.0.2.7", Some("https://192.0.2.8"), false),
            ("192.0.2.7", Some("wss://192.0.2.7"), false),
            ("127.0.0.1:8600", Some("null"), false),
            ("evil.example:8600", None, false),
            ("evil.example:8600", Some("http://evil.example:8600"), false),
        ] {
            let answer = same_origin(&headers(host, origin));
            assert_eq!(answer.is_ok(), allowed, "{host} from {origin:?}: {answer:?}");
        }
    }

    #[test]
    fn on_loopback_the_page_commands_and_a_socket_without_origin_does_not() {
        let access = at("127.0.0.1:8600");
        let page = headers("127.0.0.1:8600", Some("http://127.0.0.1:8600"));
        assert_eq!(access.ticket(&page), Ok(Ticket::Let(Rights::Command)));
        assert!(access.ticket(&headers("127.0.0.1:8600", None)).is_err());
        assert!(
            access.may_command(&headers("127.0.0.1:8600", None)).is_ok(),
            "a program of this host"
        );
        assert!(at("0.0.0.0:8600").may_command(&headers("192.0.2.7:8600", None)).is_err());
        assert_eq!((access.url(), access.url_to_look()), ("http://127.0.0.1:8600/".into(), None));
    }

    #[test]
    fn a_program_may_carry_its_token_in_the_address_where_one_is_needed() {
        let (here, beyond) = (at("127.0.0.1:80"), at("192.0.2.7:80"));
        let none = headers("192.0.2.7:80", None);
        assert_eq!(here.key_to_look(), "");
        assert!(here.may_read_with(&none, "").is_ok());
        let key = beyond.key_to_look();
        let query = key.strip_prefix('?').expect("a query");
        assert!(beyond.may_read_with(&none, query).is_ok());
        assert!(beyond.may_read_with(&none, &format!("since=3&{query}")).is_ok());
        let short = &query[..query.len() - 1];
        for wrong in ["", "key=", "key", short, &query.replacen("key", "token", 1)] {
            assert!(beyond.may_read_with(&none, wrong).is_err(), "{wrong}");
        }
        // A wrong one in the head is not made good by another place.
        let mut program = none;
        program.insert(header::AUTHORIZATION, "Bearer 0".parse().expect("a header"));
        assert!(beyond.may_read_with(&program, query).is_err());
    }

    #[test]
    fn beyond_loopback_only_a_token_lets_in_and_says_what_one_may() {
        for address in ["0.0.0.0:8600", "192.0.2.7:8600", "[::]:8600"] {
            let access = at(address);
            let page = headers("192.0.2.7:8600", Some("http://192.0.2.7:8600"));
            assert_eq!(access.ticket(&page), Ok(Ticket::AskToken), "{address}");
            assert_eq!(access.ticket(&headers("192.0.2.7:8600", None)), Ok(Ticket::AskToken));
            let token_of = |url: &str| url.split_once("#key=").expect("a token").1.to_owned();
            let command = token_of(&access.url());
            let look = token_of(&access.url_to_look().expect("another token"));
            assert_ne!(command, look);
            assert_eq!(command.len(), 32);
            let almost =
                format!("{}{}", &command[..31], if command.ends_with('0') { 1 } else { 0 });
            for (token, rights) in [
                (&command[..], Some(Rights::Command)),
                (&look, Some(Rights::Look)),
                (&almost, None),
                (&command[..31], None),
                ("", None),
                (&token_of(&at(address).url()), None),
            ] {
                let message = format!(r#"{{"type":"token","token":"{token}"}}"#);
                assert_eq!(access.rights_of_message(&message), rights, "{address} {token}");
                let mut program = headers("192.0.2.7:8600", None);
                let bearer = format!("Bearer {token}").parse().expect("a header");
                program.insert(header::AUTHORIZATION, bearer);
                assert_eq!(access.ticket(&program).ok(), rights.map(Ticket::Let));
                assert_eq!(access.may_command(&program).is_ok(), rights == Some(Rights::Command));
            }
            for other in ["", "{}", r#"{"type":"show","scan":null}"#, r#"{"type":"token"}"#] {
                assert_eq!(access.rights_of_message(other), None, "{other}");
            }
        }
    }
}
