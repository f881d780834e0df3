//! People at controllers' seats, from a page or a program: what they do goes to the member `visitors`.

use super::super::said::Topic;
use super::super::session::{FromSeat, Outgoing, reply};
use super::{ANSWER, Page, Shared};
use crate::runtime::messages::SeatOrder;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::json;
use std::sync::{Arc, PoisonError};
use tokio::time::timeout;

/// Does it; its number, or why not.
async fn carried(page: Arc<Page>, order: SeatOrder) -> Result<u64, String> {
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

/// The answer to what a page did at a seat: the number by which control tells what became of it.
pub(super) async fn answered(page: Arc<Page>, id: f64, order: SeatOrder) -> Outgoing {
    match carried(page, order).await {
        Ok(number) => reply(id, "seat", true, &number.to_string()),
        Err(why) => reply(id, "seat", false, &why),
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
    let order = serde_json::from_str::<FromSeat>(&body).map_err(|e| e.to_string());
    let done = match order.and_then(FromSeat::read) {
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
