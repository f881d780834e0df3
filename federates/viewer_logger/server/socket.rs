//! One browser on its WebSocket: what it asks for is answered, what it lacks is sent, until it leaves.

use super::super::replayed::Compared;
use super::super::session::{Asked, Outgoing, Session, refused, reply};
use super::dial::Dials;
use super::{ANSWER, Shared, Whose, at_seat, fork};
use crate::runtime::access::{Access, LOOK_ONLY, Rights};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::messages::Command;
use axum::extract::ws::{Message, WebSocket};
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

/// The rights of a browser whose first message is a token; anybody else hears why not.
pub(super) async fn first_word(socket: &mut WebSocket, access: &Access) -> Option<Rights> {
    let first = timeout(FIRST_WORD, socket.recv()).await;
    if let Ok(Some(Ok(Message::Text(text)))) = first
        && let Some(rights) = access.rights_of_message(&text)
    {
        return Some(rights);
    }
    let Outgoing::Text(why) = refused(access.needed()) else { return None };
    let _ = timeout(FIRST_WORD, socket.send(Message::Text((&*why).into()))).await;
    None
}

/// One browser until it leaves. A slow one gets fewer scans, never an ever longer queue.
pub(super) async fn browser(
    mut socket: WebSocket,
    shared: &Arc<Shared>,
    rights: Rights,
    Whose { mut person, eye }: Whose,
) {
    let (mut session, mut dials) = (Session::default(), Dials::default());
    if eye {
        session.looks_out();
    }
    let mut version = shared.page.version.subscribe();
    version.mark_changed();
    let mut alive = interval(ALIVE);
    alive.set_missed_tick_behavior(MissedTickBehavior::Delay);
    // First of all whose page it is: nothing is sent that is not seen from his seats.
    let mut first = sees(shared, &mut session, &person);
    loop {
        let out = tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Text(text))) => match session.on_message(&text) {
                    Asked::Nothing => picture(shared, &mut session, &person),
                    Asked::Refused(answer) => vec![answer],
                    Asked::Open(ids) => shared.page.with_all(|all| match session.open(all, &ids) {
                        Ok(()) => session.poll_runs(all),
                        Err(reason) => vec![refused(&reason)],
                    }),
                    Asked::Strip(from_s, to_s, columns) => {
                        shared.page.with_all(|all| session.strip(all, from_s, to_s, columns))
                    }
                    Asked::Compare(..) | Asked::Tolerances(..) if rights == Rights::Look => {
                        vec![refused(LOOK_ONLY)]
                    }
                    Asked::Compare(on, ghost) => {
                        dials.ask(&shared.page, &session, on, Compared::Rungs(ghost))
                    }
                    Asked::Tolerances(on, ghost_m) => {
                        dials.ask(&shared.page, &session, on, Compared::Tolerances(ghost_m))
                    }
                    Asked::Fork(..) if rights == Rights::Look => vec![refused(LOOK_ONLY)],
                    Asked::Fork(Some(wanted)) => {
                        let begun = fork::begin(&shared.page, wanted);
                        begun.err().map(|why| refused(&why)).into_iter().collect()
                    }
                    Asked::Fork(None) => {
                        shared.page.forks().inspect(|forks| forks.cancel());
                        Vec::new()
                    }
                    Asked::Person(name) => {
                        person = name;
                        picture(shared, &mut session, &person)
                    }
                    Asked::Acknowledge(_) if rights == Rights::Look => vec![refused(LOOK_ONLY)],
                    Asked::Acknowledge(id) => {
                        let mut done = Ok(String::new());
                        shared.page.update(|viewer| done = viewer.acknowledge(id));
                        done.err().map(|why| refused(&why)).into_iter().collect()
                    }
                    Asked::Seat(id, _) if rights == Rights::Look => {
                        vec![reply(id, "seat", false, LOOK_ONLY)]
                    }
                    Asked::Seat(id, order) => {
                        let page = Arc::clone(&shared.page);
                        let (answer, accepted) = at_seat::answered(page, id, order.clone()).await;
                        let mut out = vec![answer];
                        if accepted {
                            person.clone_from(&order.person);
                            out.extend(session.sits(&order));
                            out.extend(picture(shared, &mut session, &person));
                        }
                        out
                    }
                    Asked::Command(id, words, _) if rights == Rights::Look => {
                        vec![reply(id, &words, false, LOOK_ONLY)]
                    }
                    Asked::Command(id, words, command) => {
                        vec![carry_out(shared.clone(), id, words, command).await]
                    }
                },
                Some(Ok(Message::Binary(_))) => vec![refused("binary messages mean nothing here")],
                Some(Ok(_)) => Vec::new(),
                Some(Err(_)) | None => return,
            },
            changed = version.changed() => {
                if changed.is_err() {
                    return;
                }
                sleep(PICTURE).await; // several changes make one picture
                version.mark_unchanged();
                picture(shared, &mut session, &person)
            }
            _ = alive.tick() => vec![Outgoing::Text(r#"{"type":"alive"}"#.into())],
        };
        for message in std::mem::take(&mut first)
            .into_iter()
            .chain(out)
            .chain(dials.follow(&shared.page, &session))
        {
            let message = match message {
                Outgoing::Text(text) => Message::Text((&*text).into()),
                Outgoing::Binary(octets) => Message::Binary(octets.into()),
            };
            match timeout(STUCK, socket.send(message)).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) | Err(_) => return,
            }
        }
    }
}

/// From where its person sees the run now, where that is news.
fn sees(shared: &Shared, session: &mut Session, person: &str) -> Vec<Outgoing> {
    session.is_of(shared.page.people().seats_of(person, monotonic_ns()))
}

/// What a browser lacks, as seen from where its person sits.
fn picture(shared: &Shared, session: &mut Session, person: &str) -> Vec<Outgoing> {
    let mut out = sees(shared, session, person);
    out.extend(shared.page.with_all(|all| session.poll_runs(all)));
    out
}

async fn carry_out(shared: Arc<Shared>, id: f64, words: String, command: Command) -> Outgoing {
    let word = words.clone();
    let work = tokio::task::spawn_blocking(move || (shared.operate)(&word, command));
    let (accepted, text) = match timeout(ANSWER, work).await {
        Ok(Ok(done)) => done,
        Ok(Err(_)) => (false, "the command failed inside the viewer; see its log".to_owned()),
        Err(_) => {
            (false, format!("no answer from the admin station within {} s", ANSWER.as_secs()))
        }
    };
    reply(id, &words, accepted, &text)
}

/// How long a browser that needs a token may take to say it.
const FIRST_WORD: Duration = Duration::from_secs(5);
/// At most this often a new picture.
const PICTURE: Duration = Duration::from_millis(40);
/// A sign of life when nothing else is to be said; the page shows its absence.
const ALIVE: Duration = Duration::from_secs(1);
/// A browser that takes nothing for so long is let go.
const STUCK: Duration = Duration::from_secs(20);
