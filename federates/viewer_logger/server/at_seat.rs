//! People at controllers' seats, from a page or a program: what they do goes to the member `visitors`.

use super::super::said::Topic;
use super::super::session::{Outgoing, reply};
use super::{ANSWER, Page, Shared};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::messages::{SeatAction, SeatOrder, SeatWords};
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, PoisonError};
use tokio::time::timeout;

/// Who sits where, by what was accepted on this host: all pages of one person see from his seats, also one that is opened or loaded anew.
#[derive(Debug, Default)]
pub(super) struct People {
    /// Of each seat: who has it, and when he was heard last (monotonic, ns).
    seats: BTreeMap<String, (String, u64)>,
}

impl People {
    /// Something was accepted at a seat.
    fn note(&mut self, order: &SeatOrder, now_ns: u64) {
        match order.action {
            SeatAction::Leave => {
                self.seats.remove(&order.seat);
            }
            _ => {
                self.seats.insert(order.seat.clone(), (order.person.clone(), now_ns));
            }
        }
    }

    /// The seats that a person has; whoever is not heard of has lost them.
    pub(super) fn seats_of(&self, person: &str, now_ns: u64) -> BTreeSet<String> {
        let has = |(_, (whose, heard_ns)): &(&String, &(String, u64))| {
            whose == person && now_ns.saturating_sub(*heard_ns) < SILENT_NS
        };
        self.seats.iter().filter(has).map(|(seat, _)| seat.clone()).collect()
    }
}

/// A little longer than a silent person keeps a seat, ns (docs/control.md, "Take a seat").
const SILENT_NS: u64 = 35_000_000_000;

/// Does it; its number, or why not.
async fn carried(page: Arc<Page>, order: SeatOrder) -> Result<u64, String> {
    let (noted, people) = (order.clone(), Arc::clone(&page));
    let done = spoken(page, order).await;
    if done.is_ok() {
        people.people().note(&noted, monotonic_ns());
        people.wake();
    }
    done
}

async fn spoken(page: Arc<Page>, order: SeatOrder) -> Result<u64, String> {
    let speak = page.speak.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let Some(speak) = speak else {
        return Err("this run is over: nobody can sit down".to_owned());
    };
    let work = tokio::task::spawn_blocking(move || speak(&order));
    match timeout(ANSWER, work).await {
        Ok(Ok(done)) => done.map(|answer| answer.number),
        Ok(Err(_)) => Err("it failed inside the viewer; see its log".to_owned()),
        Err(_) => {
            Err(format!("no answer from the member 'visitors' within {} s", ANSWER.as_secs()))
        }
    }
}

/// The answer to what a page did at a seat, and whether it was accepted: the number by which control tells what became of it.
pub(super) async fn answered(page: Arc<Page>, id: f64, order: SeatOrder) -> (Outgoing, bool) {
    match carried(page, order).await {
        Ok(number) => (reply(id, "seat", true, &number.to_string()), true),
        Err(why) => (reply(id, "seat", false, &why), false),
    }
}

/// How the seats stand, as JSON: who sits where, who waits for what, what is spoken, what became of inputs.
pub(super) async fn seats(headers: HeaderMap, State(shared): State<Arc<Shared>>) -> Response {
    if let Err(reason) = shared.access.may_read(&headers) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let said = shared.page.viewer().said_at(Topic::Seats, i64::MAX);
    match said {
        Some(text) => {
            ([(header::CONTENT_TYPE, "application/json")], text.to_string()).into_response()
        }
        None => (StatusCode::NOT_FOUND, "nothing was heard of controllers' seats in this run\n")
            .into_response(),
    }
}

/// Something at a seat, of a program: a JSON object of `seat`, `person`, `action` (take, leave, here, say), and with say
/// `callsign` and `clearance`.
pub(super) async fn act(
    headers: HeaderMap,
    State(shared): State<Arc<Shared>>,
    body: String,
) -> Response {
    if let Err(reason) = shared.access.may_command(&headers) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let order = serde_json::from_str::<SeatWords>(&body).map_err(|e| e.to_string());
    let done = match order.and_then(SeatWords::read) {
        Ok(order) => carried(Arc::clone(&shared.page), order).await,
        Err(why) => Err(why),
    };
    let (status, answer) = match done {
        Ok(number) => (StatusCode::OK, json!({"accepted": true, "number": number})),
        Err(why) => (StatusCode::BAD_REQUEST, json!({"accepted": false, "text": why})),
    };
    let kind = [(header::CONTENT_TYPE, "application/json")];
    (status, kind, format!("{answer}\n")).into_response()
}

#[cfg(test)]
mod tests {
    use super::super::super::Viewer;
    use super::super::{Operate, Page, serve};
    use super::*;
    use crate::runtime::messages::SeatAnswer;
    use std::io::{Read, Write};

    #[test]
    fn a_person_has_the_seats_he_took_until_he_leaves_is_silent_or_another_has_them() {
        let order = |seat: &str, person: &str, action| SeatOrder {
            seat: seat.to_owned(),
            person: person.to_owned(),
            action,
        };
        let mut people = People::default();
        let seats = |people: &People, person: &str, s: u64| -> Vec<String> {
            people.seats_of(person, s * 1_000_000_000).into_iter().collect()
        };
        people.note(&order("ground", "ann", SeatAction::Take), 0);
        people.note(&order("pilot SWR1", "ann", SeatAction::Take), 1_000_000_000);
        people.note(&order("tower 1", "bob", SeatAction::Take), 0);
        assert_eq!(seats(&people, "ann", 2), ["ground", "pilot SWR1"]);
        assert_eq!(seats(&people, "bob", 2), ["tower 1"]);
        assert!(seats(&people, "eve", 2).is_empty() && seats(&people, "", 2).is_empty());
        people.note(&order("ground", "ann", SeatAction::Here), 30_000_000_000);
        assert_eq!(seats(&people, "ann", 50), ["ground"], "nothing was heard from the cockpit");
        people.note(&order("ground", "bob", SeatAction::Take), 70_000_000_000);
        assert_eq!(
            (seats(&people, "ann", 71), seats(&people, "bob", 71)),
            (vec![], vec!["ground".to_owned()])
        );
        people.note(&order("ground", "bob", SeatAction::Leave), 72_000_000_000);
        assert!(seats(&people, "bob", 73).is_empty());
    }

    #[test]
    fn a_program_sits_down_by_http_and_hears_in_one_sentence_why_not() {
        let page = Page::new(Viewer::new(1 << 16));
        let operate: Operate = Box::new(|_, _| (true, String::new()));
        let here = "127.0.0.1:0".parse().expect("an address");
        let server = serve(here, Arc::clone(&page), operate).expect("served");
        let port = server.address().port();
        let ask = |head: &str, body: &str| {
            let mut stream = std::net::TcpStream::connect(("127.0.0.1", port)).expect("connected");
            write!(
                stream,
                "{head} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}",
                body.len()
            )
            .expect("sent");
            let patience = Some(std::time::Duration::from_secs(90));
            stream.set_read_timeout(patience).expect("a time");
            let mut answer = String::new();
            stream.read_to_string(&mut answer).expect("an answer");
            answer
        };
        let take = r#"{"seat":"ground","person":"me","action":"take"}"#;
        let over = ask("POST /seat", take);
        assert!(over.starts_with("HTTP/1.1 400") && over.contains("this run is over"), "{over}");
        page.let_speak(Arc::new(|order| match &order.seat[..] {
            "ground" => Ok(SeatAnswer { accepted: true, number: 7, text: String::new() }),
            other => Err(format!("there is no seat {other:?}")),
        }));
        let taken = ask("POST /seat", take);
        assert!(taken.starts_with("HTTP/1.1 200") && taken.contains("\"number\":7"), "{taken}");
        for (body, why) in [
            (take.replace("ground", "cab"), "there is no seat"),
            (take.replace("take", "fly"), "there is no action"),
            (take.replace("take", "say"), "name a callsign and a clearance"),
            (take.replace("person", "who"), "unknown field `who`"),
            ("{".to_owned(), "EOF while parsing"),
        ] {
            let answer = ask("POST /seat", &body);
            assert!(answer.starts_with("HTTP/1.1 400") && answer.contains(why), "{body}: {answer}");
        }
        assert!(ask("GET /seats", "").starts_with("HTTP/1.1 404"), "nothing was said yet");
        let said = r#"{"time_s":3.0,"seats":[]}"#;
        page.update(|viewer| viewer.on_said(Topic::Seats, said));
        assert!(ask("GET /seats", "").ends_with(said));
        server.stop();
    }
}
