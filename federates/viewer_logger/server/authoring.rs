//! The page of a scene's author: the scene, and what is done to it. Whoever may command may write.

use super::super::author::{Act, Author};
use super::super::detection::Maps;
use super::super::picture::{AirportMap, RunInfo};
use super::{Page, Shared};
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, post};
use scenarios::Scene;
use serde_json::Value;
use std::sync::{Arc, PoisonError};

/// Longest scene that a page writes, octets.
const MOST_TEXT: usize = 1 << 20;

/// What a page does to the scene, with a body as long as a scene may be.
pub(super) fn acting() -> MethodRouter<Arc<Shared>> {
    post(act).layer(DefaultBodyLimit::max(MOST_TEXT))
}

fn author_of(page: &Page) -> Option<Arc<Author>> {
    page.author.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// The scene as it is on disk, with the airport to draw.
pub(super) async fn scene(headers: HeaderMap, State(shared): State<Arc<Shared>>) -> Response {
    done(&headers, &shared, |author, page| author.begin(&shown_on(page))).await
}

async fn act(headers: HeaderMap, State(shared): State<Arc<Shared>>, body: String) -> Response {
    let act: Act = match serde_json::from_str(&body) {
        Ok(act) => act,
        Err(error) => {
            return (StatusCode::BAD_REQUEST, format!("not understood: {error}\n")).into_response();
        }
    };
    done(&headers, &shared, move |author, page| author.act(&shown_on(page), act)).await
}

/// Has the page's other parts follow a draft.
fn shown_on(page: &Page) -> impl Fn(&RunInfo, &AirportMap, Arc<Scene>) {
    |info, map, scene| {
        page.update(|viewer| {
            viewer.on_scene(info, map);
            viewer.show_detection(Maps::of(scene));
        });
    }
}

/// Does it on a thread that may take its time.
async fn done(
    headers: &HeaderMap,
    shared: &Arc<Shared>,
    work: impl FnOnce(&Author, &Page) -> Value + Send + 'static,
) -> Response {
    if let Err(reason) = shared.access.may_command(headers) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let Some(author) = author_of(&shared.page) else {
        let words = "this page shows a run; a scene is written with `seeds scene author FILE`\n";
        return (StatusCode::NOT_FOUND, words).into_response();
    };
    let page = Arc::clone(&shared.page);
    match tokio::task::spawn_blocking(move || work(&author, &page)).await {
        Ok(answer) => {
            ([(header::CONTENT_TYPE, "application/json")], answer.to_string()).into_response()
        }
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "it failed; see the program's log\n")
            .into_response(),
    }
}

#[cfg(test)]
mod tests;
