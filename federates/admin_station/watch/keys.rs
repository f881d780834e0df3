//! What a key on the screen of `watch` does. No terminal: a key in, what is to be done out.

use super::shown::Shown;
use crate::runtime::messages::Command;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Deed {
    /// Nothing beyond what the screen shows now.
    Show,
    /// Leave the run as it is, and the screen.
    Leave,
    /// Give the run this command.
    Tell(Command),
}

/// Frames of one step.
pub(super) const STEP: u64 = 20;
/// The rates that the keys choose are powers of two within these; above is as fast as possible.
const SLOWEST: f64 = 1.0 / 64.0;
const FASTEST: f64 = 64.0;

/// A key was pressed.
pub(super) fn pressed(shown: &mut Shown, key: KeyEvent) -> Deed {
    let held = key.modifiers.intersects(KeyModifiers::CONTROL | KeyModifiers::ALT);
    if held {
        let leaves =
            key.modifiers.contains(KeyModifiers::CONTROL) && key.code == KeyCode::Char('c');
        return if leaves { Deed::Leave } else { Deed::Show };
    }
    if std::mem::take(&mut shown.confirming) {
        return match key.code {
            KeyCode::Char('y' | 'Y') => tell(shown, Command::Stop),
            _ => {
                shown.said = Some((true, "not stopped".to_owned()));
                Deed::Show
            }
        };
    }
    match key.code {
        KeyCode::Char('q' | 'Q') => Deed::Leave,
        KeyCode::Char('f' | 'F') => tell(shown, Command::Freeze),
        KeyCode::Char('r' | 'R') => tell(shown, Command::Start),
        KeyCode::Char('s' | 'S') => tell(shown, Command::Step { n: STEP }),
        KeyCode::Char('+' | '=') => {
            let rate = faster(shown.run.rate);
            tell(shown, Command::Rate { rate })
        }
        KeyCode::Char('-' | '_') => {
            let rate = slower(shown.run.rate);
            tell(shown, Command::Rate { rate })
        }
        KeyCode::Char('x' | 'X') => {
            shown.confirming = true;
            Deed::Show
        }
        KeyCode::Up => {
            shown.first = shown.first.saturating_sub(1);
            Deed::Show
        }
        KeyCode::Down => {
            shown.first = (shown.first + 1).min(shown.rows.len().saturating_sub(1));
            Deed::Show
        }
        _ => Deed::Show,
    }
}

/// One command at a time, and none to a station that does not answer.
fn tell(shown: &mut Shown, command: Command) -> Deed {
    let words = words(&command);
    let refused = match (&shown.under_way, shown.silent_s) {
        (Some(other), _) => Some(format!("{words}: not given, {other} is on its way")),
        (None, Some(_)) => Some(format!("{words}: not given, the station does not answer")),
        (None, None) => None,
    };
    if let Some(why) = refused {
        shown.said = Some((false, why));
        return Deed::Show;
    }
    shown.said = None;
    shown.under_way = Some(words);
    Deed::Tell(command)
}

/// As a person would type it.
fn words(command: &Command) -> String {
    match command {
        Command::Status => "status".to_owned(),
        Command::Start => "resume".to_owned(),
        Command::Freeze => "freeze".to_owned(),
        Command::Step { n } => format!("step {n}"),
        Command::Stop => "stop".to_owned(),
        Command::Restart => "restart".to_owned(),
        Command::Rate { rate } if rate.is_infinite() => "rate fast".to_owned(),
        Command::Rate { rate } => format!("rate {rate}"),
        Command::Move { name, to } => format!("move {name} {to}"),
        Command::Without { name } => format!("without {name}"),
    }
}

/// The next power of two above a rate.
fn faster(rate: Option<f64>) -> f64 {
    let mut next = SLOWEST;
    while rate.is_some_and(|rate| next <= rate) && next <= FASTEST {
        next *= 2.0;
    }
    if rate.is_none() || next > FASTEST { f64::INFINITY } else { next }
}

/// The next power of two below a rate.
fn slower(rate: Option<f64>) -> f64 {
    let mut next = FASTEST;
    while rate.is_some_and(|rate| next >= rate) && next > SLOWEST {
        next /= 2.0;
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(c: char) -> KeyEvent {
        KeyEvent::new(KeyCode::Char(c), KeyModifiers::NONE)
    }

    /// What keys come to one after the other, each answered before the next.
    fn deeds(shown: &mut Shown, keys: &str) -> Vec<Deed> {
        let each = |c| {
            let deed = pressed(shown, key(c));
            shown.under_way = None;
            deed
        };
        keys.chars().map(each).collect()
    }

    #[test]
    fn each_key_gives_its_command_and_stop_asks_first() {
        let mut shown = Shown::of("tcp/127.0.0.1:7447");
        shown.run.rate = Some(1.0);
        let rate = |rate| Deed::Tell(Command::Rate { rate });
        assert_eq!(
            deeds(&mut shown, "frs+-q"),
            [
                Deed::Tell(Command::Freeze),
                Deed::Tell(Command::Start),
                Deed::Tell(Command::Step { n: 20 }),
                rate(2.0),
                rate(0.5),
                Deed::Leave,
            ]
        );
        assert_eq!(
            deeds(&mut shown, "xn"),
            [Deed::Show, Deed::Show],
            "anything but y: not stopped"
        );
        assert_eq!(shown.said, Some((true, "not stopped".to_owned())));
        assert_eq!(deeds(&mut shown, "xq"), [Deed::Show, Deed::Show], "q answers the question");
        assert_eq!(deeds(&mut shown, "xy"), [Deed::Show, Deed::Tell(Command::Stop)]);
        assert_eq!(deeds(&mut shown, "yz"), [Deed::Show, Deed::Show], "y alone does nothing");
        let mut held =
            |c| pressed(&mut shown, KeyEvent::new(KeyCode::Char(c), KeyModifiers::CONTROL));
        assert_eq!((held('c'), held('x'), held('f')), (Deed::Leave, Deed::Show, Deed::Show));
        assert!(!shown.confirming);
    }

    #[test]
    fn control_c_leaves_while_the_question_stands() {
        let mut shown = Shown { confirming: true, ..Shown::default() };
        let held = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(pressed(&mut shown, held), Deed::Leave);
    }

    #[test]
    fn one_command_at_a_time_and_none_into_silence() {
        let mut shown = Shown::of("tcp/127.0.0.1:7447");
        assert_eq!(pressed(&mut shown, key('f')), Deed::Tell(Command::Freeze));
        assert_eq!(shown.under_way.as_deref(), Some("freeze"));
        assert_eq!(pressed(&mut shown, key('s')), Deed::Show);
        let (ok, words) = shown.said.clone().expect("why not");
        assert!(!ok && words == "step 20: not given, freeze is on its way", "{words}");
        shown.under_way = None;
        shown.silent_s = Some(4);
        assert_eq!(pressed(&mut shown, key('r')), Deed::Show);
        assert!(shown.said.expect("why not").1.contains("does not answer"));
    }

    #[test]
    fn rates_go_by_powers_of_two_up_to_as_fast_as_possible() {
        for (rate, up, down) in [
            (Some(1.0), 2.0, 0.5),
            (Some(3.0), 4.0, 2.0),
            (Some(64.0), f64::INFINITY, 32.0),
            (Some(700.0), f64::INFINITY, 64.0),
            (Some(0.001), SLOWEST, SLOWEST),
            (Some(SLOWEST), 2.0 * SLOWEST, SLOWEST),
            (None, f64::INFINITY, 64.0),
        ] {
            assert_eq!((faster(rate), slower(rate)), (up, down), "{rate:?}");
        }
    }

    #[test]
    fn arrows_move_within_the_rows() {
        let mut shown = Shown { rows: vec![Default::default(); 3], ..Shown::default() };
        let mut go = |code| {
            pressed(&mut shown, KeyEvent::new(code, KeyModifiers::NONE));
            shown.first
        };
        let (up, down) = (KeyCode::Up, KeyCode::Down);
        assert_eq!([up, down, down, down, up].map(&mut go), [0, 1, 2, 2, 1]);
    }
}
