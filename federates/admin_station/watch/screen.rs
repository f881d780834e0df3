//! The full screen of `watch`: a terminal, its keys, and a thread each that asks the station and gives it commands.

use super::draw::draw;
use super::keys::{Deed, pressed};
use super::shown::Shown;
use crate::exchange::operator;
use crate::runtime::bus::Bus;
use crate::runtime::clock::monotonic_ns;
use crate::runtime::messages::{Answer, Command};
use crate::runtime::process::on_interrupt;
use crate::runtime::threads::spawn_watched;
use anyhow::Context;
use crossbeam_channel::{Receiver, Sender, bounded, unbounded};
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event};
use serde_json::Value;
use std::sync::Arc;
use std::time::Duration;

/// How long a key or an answer may wait until it is seen.
const LOOK: Duration = Duration::from_millis(50);

/// What comes from beside the keyboard.
enum News {
    /// How the run stands; none: the station does not answer.
    Statistics(Option<Box<Value>>),
    /// What became of a command.
    Answered(Box<Result<Answer, String>>),
    /// This process is asked to end.
    Leave,
    /// A thread ended by a fault.
    Died(String),
}

/// The terminal as it was, however this ends: a panic restores it before it is told (`ratatui::try_init`).
struct Screen(DefaultTerminal);

impl Screen {
    fn open() -> anyhow::Result<Self> {
        ratatui::try_init().map(Self).map_err(|e| {
            let _ = ratatui::try_restore();
            anyhow::anyhow!("the terminal cannot show a screen: {e}; --plain writes tables instead")
        })
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.0.show_cursor();
        let _ = ratatui::try_restore();
    }
}

/// Shows the run until the person leaves; `seen` is given every answer of the station. A station that goes away is waited for.
///
/// # Errors
/// If the terminal cannot be used, or `seen` fails.
pub(super) fn show(
    bus: &Arc<dyn Bus>,
    endpoint: &str,
    every: Duration,
    first: &Value,
    mut seen: impl FnMut(&Value) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut shown = Shown::of(endpoint);
    shown.take(monotonic_ns(), first);
    let (send, receive) = unbounded();
    let leave = send.clone();
    on_interrupt(move || drop(leave.send(News::Leave)))?;
    let commands = workers(bus, endpoint, every, &send)?;
    let mut screen = Screen::open()?;
    let mut heard_at = monotonic_ns();
    loop {
        screen.0.draw(|frame| draw(frame, &shown)).context("drawing on the terminal")?;
        if !next(&mut shown, &receive, &commands, &mut heard_at, &mut seen)? {
            return Ok(());
        }
    }
}

/// Waits for something that changes the screen; whether it goes on.
fn next(
    shown: &mut Shown,
    receive: &Receiver<News>,
    commands: &Sender<Command>,
    heard_at: &mut u64,
    seen: &mut impl FnMut(&Value) -> anyhow::Result<()>,
) -> anyhow::Result<bool> {
    let mut changed = false;
    while !changed {
        if event::poll(LOOK).context("reading the keyboard")? {
            changed = true;
            let event = event::read().context("reading the keyboard")?;
            let key = if let Event::Key(key) = event { Some(key) } else { None };
            match key.filter(|key| key.is_press()).map(|key| pressed(shown, key)) {
                Some(Deed::Leave) => return Ok(false),
                Some(Deed::Tell(command)) => drop(commands.send(command)),
                Some(Deed::Show) | None => {}
            }
        }
        for news in receive.try_iter() {
            changed = true;
            let now = monotonic_ns();
            match news {
                News::Statistics(Some(statistics)) => {
                    *heard_at = now;
                    seen(&statistics)?;
                    shown.take(now, &statistics);
                }
                News::Statistics(None) => {
                    shown.silent_s = Some(now.saturating_sub(*heard_at) / 1_000_000_000);
                }
                News::Answered(answer) => shown.answered(*answer),
                News::Leave => return Ok(false),
                News::Died(why) => anyhow::bail!(why),
            }
        }
    }
    Ok(true)
}

/// Starts a thread that asks how the run stands, and one that gives commands, which may take ten seconds each.
fn workers(
    bus: &Arc<dyn Bus>,
    endpoint: &str,
    every: Duration,
    send: &Sender<News>,
) -> std::io::Result<Sender<Command>> {
    let died = |send: &Sender<News>| {
        let send = send.clone();
        move |why| drop(send.send(News::Died(why)))
    };
    let (now, asked) = bounded::<()>(1);
    let (told, place, of) = (send.clone(), endpoint.to_owned(), Arc::clone(bus));
    spawn_watched("the one who asks the station", died(send), move || {
        loop {
            // A command was carried out: at once; else after the pause.
            let _ = asked.recv_timeout(every);
            let statistics = operator::statistics(&*of, &place).ok().map(Box::new);
            if told.send(News::Statistics(statistics)).is_err() {
                return;
            }
        }
    })?;
    let (commands, given) = unbounded();
    let (told, place, of) = (send.clone(), endpoint.to_owned(), Arc::clone(bus));
    spawn_watched("the one who gives commands", died(send), move || {
        for command in given {
            let answer = operator::command(&*of, &place, "terminal", command);
            let answer = Box::new(answer.map_err(|e| e.to_string()));
            if told.send(News::Answered(answer)).is_err() {
                return;
            }
            let _ = now.try_send(());
        }
    })?;
    Ok(commands)
}
