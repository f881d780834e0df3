//! The screen of `watch` at several sizes, cell by cell, from the JSON that a station answers with.

use super::draw::draw;
use super::keys::pressed;
use super::shown::Shown;
use crate::runtime::messages::{Answer, Health, RunState};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use serde_json::{Value, json};

const S: u64 = 1_000_000_000;

fn member(name: &str, health: &str, more: &Value) -> Value {
    let mut member = json!({
        "name": name, "host": "tower", "pid": 4711, "essential": true, "alive": true, "health": health,
        "heard_ms": 40, "behind": 1, "frame": 1203, "latency_us": 210.0,
    });
    for (key, value) in more.as_object().into_iter().flatten() {
        member[key] = value.clone();
    }
    member
}

/// A run that has lost its SMDFM, at frame `frame`, when `sent` PDUs had been sent.
fn answer(frame: u64, sent: u64) -> Value {
    json!({
        "state": {
            "scene": "Zurich: six recorded movements, two vehicles", "run": 1, "phase": "FROZEN", "frame": frame,
            "last_frame": 12_000, "step_ns": 50_000_000, "rate": 4.0, "achieved_rate": 3.9, "seed": 23,
            "reasons": ["smdfm (process 4713 on apron) is lost: its process or connection is gone"],
            "members": [
                member("traffic-generator-1", "alive", &json!({})),
                member("traffic-generator-2", "late", &json!({ "behind": 5 })),
                member("external-world", "silent", &json!({ "heard_ms": 420 })),
                member("smdfm", "lost", &json!({ "host": "apron", "heard_ms": 2_345, "behind": 20, "alive": false })),
                member("control", "returning", &json!({ "host": "apron" })),
                member("viewer-logger", "alive", &json!({ "essential": false, "heard_ms": null, "behind": 0 })),
            ],
        },
        "federates": {
            "admin-station": { "cpu_pct": 2.25, "rss_bytes": 21_400_000, "lost": 0, "pdus_out": 0, "alarms": [
                "the clock of host apron is 3.0 s ahead of the one here (tower): let both hosts follow one time server",
            ] },
            "traffic-generator-1": { "cpu_pct": 11.5, "rss_bytes": 31_000_000, "lost": 0, "pdus_out": sent, "alarms": [] },
            "smdfm": { "cpu_pct": 87.25, "rss_bytes": 152_000_000, "lost": 12, "pdus_out": 0, "alarms": [] },
        },
        "clocks": { "apron": 3.0 },
    })
}

/// Half a minute at different speeds.
fn watched() -> Shown {
    let mut shown = Shown::of("tcp/127.0.0.1:7447");
    let (mut frame, mut sent) = (100, 0);
    for second in 0..30 {
        frame += 10 * (1 + second % 8);
        sent += 40 * (1 + second % 5);
        shown.take(second * S, &answer(frame, sent));
    }
    shown
}

fn screen(shown: &Shown, width: u16, height: u16) -> Terminal<TestBackend> {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal");
    terminal.draw(|frame| draw(frame, shown)).expect("drawn");
    terminal
}

fn text(shown: &Shown, width: u16, height: u16) -> String {
    screen(shown, width, height).backend().to_string()
}

#[test]
fn the_screen_of_a_usual_terminal() {
    insta::assert_snapshot!(text(&watched(), 80, 24));
}

#[test]
fn the_screen_of_a_small_terminal() {
    insta::assert_snapshot!(text(&watched(), 40, 10));
}

#[test]
fn the_screen_of_a_large_terminal_while_the_station_is_silent_and_a_stop_is_asked_for() {
    let mut shown = watched();
    shown.silent_s = Some(7);
    pressed(&mut shown, KeyEvent::new(KeyCode::Char('x'), KeyModifiers::NONE));
    insta::assert_snapshot!(text(&shown, 120, 30));
}

/// The words of a command, of what came of it, and of a run that goes on; no alarms.
#[test]
fn what_a_command_came_to_is_shown_with_the_state_that_it_reached() {
    let mut shown = watched();
    pressed(&mut shown, KeyEvent::new(KeyCode::Char('s'), KeyModifiers::NONE));
    assert!(text(&shown, 80, 24).contains(" … step 20"));
    let state = RunState { frame: 1_337, rate: f64::INFINITY, ..RunState::default() };
    shown.answered(Ok(Answer { ok: true, text: "frozen at frame 1337".to_owned(), state }));
    shown.alarms.clear();
    let after = text(&shown, 80, 24);
    for words in ["ok: frozen at frame 1337", "frame 1337 of", "rate fast", "no alarms", "○ INIT"]
    {
        assert!(after.contains(words), "{words}: {after}");
    }
    shown.answered(Err("nobody is there".to_owned()));
    assert!(text(&shown, 80, 24).contains("! nobody is there"));
}

#[test]
fn every_health_has_a_word_where_there_are_no_colours() {
    let shown = watched();
    let seen = text(&shown, 40, 24);
    for health in Health::ALL {
        assert!(seen.contains(health.word()), "{}: {seen}", health.word());
    }
}

#[test]
fn any_size_and_any_words_can_be_drawn_and_nothing_controls_the_terminal() {
    let mut shown = watched();
    shown.alarms.push("\x1b[2J\x07smdfm \u{202e}\u{1f6e9}\u{fe0f} 漢字 says".repeat(9));
    shown.rows[0].name = "\x1b]0;owned\x07名前が長い交通生成器と言います".to_owned();
    shown.said = Some((false, "\x1b[31m".to_owned()));
    for asks in [false, true] {
        shown.confirming = asks;
        shown.silent_s = asks.then_some(0);
        for (width, height) in (1..=100).step_by(3).flat_map(|w| (1..=30).map(move |h| (w, h))) {
            let terminal = screen(&shown, width, height);
            let cells = terminal.backend().buffer().content();
            let sound = cells.iter().all(|cell| !cell.symbol().contains(char::is_control));
            assert!(sound, "{width} x {height}");
        }
    }
}

/// Few lines: the phase first, then whether the station answers, then the keys; of the federates who is lost, and arrows bring the rest.
#[test]
fn what_matters_most_is_what_stays() {
    let mut shown = watched();
    shown.silent_s = Some(3);
    assert!(text(&shown, 60, 1).contains("FROZEN"));
    assert!(text(&shown, 60, 2).contains("no answer from the station for 3 s"));
    assert!(text(&shown, 60, 3).contains("q leave"));
    let small = text(&shown, 60, 10);
    assert!(small.contains("x lost") && small.contains("1-2 of 7 ↑↓"), "{small}");
    assert!(!small.contains("viewer-logger"), "{small}");
    for _ in 0..9 {
        pressed(&mut shown, KeyEvent::new(KeyCode::Down, KeyModifiers::NONE));
    }
    let small = text(&shown, 60, 10);
    assert!(small.contains("viewer-logger") && small.contains("6-7 of 7 ↑↓"), "{small}");
    assert!(!small.contains("x lost"), "{small}");
}

/// Two hundred frames in two seconds, then a run that begins again; PDUs of a federate that was started again.
#[test]
fn curves_follow_runs_and_processes_that_begin_again() {
    let mut shown = Shown::of("x");
    let newest = |shown: &Shown| {
        let of = &shown.curves;
        let value = |curve: &std::collections::VecDeque<f64>| curve.back().copied();
        (value(&of.frames_per_s), value(&of.pdus_per_s), value(&of.behind))
    };
    shown.take(0, &answer(1_000, 500));
    assert_eq!(newest(&shown), (None, None, Some(20.0)), "one answer is no speed");
    shown.take(S, &answer(1_100, 560));
    assert_eq!(newest(&shown), (Some(100.0), Some(60.0), Some(20.0)));
    let mut again = answer(40, 20);
    again["state"]["run"] = json!(2);
    shown.take(2 * S, &again);
    assert_eq!(newest(&shown), (Some(70.0), Some(30.0), Some(20.0)));
    shown.take(2 * S, &again);
    assert_eq!(shown.curves.frames_per_s.len(), 2, "two answers at one time");
    for second in 3..1_000 {
        shown.take(second * S, &again);
    }
    assert_eq!(newest(&shown), (Some(0.0), Some(0.0), Some(20.0)));
    assert_eq!(shown.curves.frames_per_s.len(), shown.curves.behind.len());
}
