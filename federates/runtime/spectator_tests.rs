//! Spectators hold nobody up: how long a run waits for one, what they are called, how many there may be.

use super::conductor::{Conductor, ConductorConfig, Effect};
use super::messages::{Hello, Kind, Numbered, Order, Report, Welcome};

const S: u64 = 1_000_000_000;

fn conductor() -> Conductor {
    Conductor::new(ConductorConfig {
        scene: "toy".into(),
        scene_hash: 1,
        version: "v".into(),
        expected: vec!["external-world".into()],
        producers: vec!["external-world".into()],
        optional: Vec::new(),
        generators: 1,
        seed: 7,
        step_ns: 50_000_000,
        start_utc_ns: 0,
        last_frame: 100,
        rate: 1.0,
        autostart: true,
        batch: false,
        await_spectators: vec!["viewer-logger".into()],
        await_spectators_ns: 2 * S,
        window: 8,
        closes: None,
        front_ends: std::collections::BTreeMap::new(),
        through_router: false,
        fed: 7,
        losses: scenarios::losses::Losses::default(),
    })
}

fn hello(name: &str, kind: Kind, pid: u32) -> Hello {
    Hello {
        name: name.into(),
        kind,
        pid,
        host: "here".into(),
        version: "v".into(),
        scene_hash: 1,
        instance: u128::from(pid),
        was: None,
    }
}

/// What a federate that asks to join is told.
fn join(conductor: &mut Conductor, now: u64, hello: Hello) -> Welcome {
    let mut effects = Vec::new();
    conductor.hello(now, hello, 1, &mut effects);
    let told = effects.into_iter().find_map(|effect| match effect {
        Effect::Welcome(1, welcome) => Some(welcome),
        _ => None,
    });
    told.expect("an answer")
}

fn inc(welcome: Welcome) -> u64 {
    match welcome {
        Welcome::Accepted(accepted) => accepted.inc,
        other => panic!("{other:?}"),
    }
}

/// A conductor whose only member joined at `now` and is present.
fn with_member(now: u64) -> Conductor {
    let mut conductor = conductor();
    let inc = inc(join(&mut conductor, now, hello("external-world", Kind::ExternalWorld, 1)));
    let present =
        Numbered { fed: 7, inc, seq: 0, body: Report::Present { hears: vec![], consumes: false } };
    conductor.report(now, "external-world", present, &mut Vec::new());
    conductor
}

/// When, in ticks of 10 ms from `from` on, the members are configured.
fn configured_at(conductor: &mut Conductor, from: u64) -> Option<u64> {
    let mut effects = Vec::new();
    (0..2_000).map(|n| from + n * S / 100).find(|now| {
        conductor.tick(*now, &mut effects);
        effects
            .iter()
            .any(|e| matches!(e, Effect::Order(Numbered { body: Order::Configure(_), .. })))
    })
}

#[test]
fn a_spectator_that_does_not_come_is_waited_for_from_the_last_member_on() {
    // However long the members themselves took.
    let mut conductor = with_member(60 * S);
    let at = configured_at(&mut conductor, 60 * S).expect("configured");
    assert!((62 * S..=62 * S + S / 20).contains(&at), "{at}");
}

#[test]
fn a_spectator_that_is_gone_or_will_not_come_is_not_waited_for() {
    let mut conductor = with_member(S);
    let seen = join(&mut conductor, S, hello("viewer-logger", Kind::ViewerLogger, 2));
    conductor.alive(S + 1, "viewer-logger", inc(seen), false, &mut Vec::new());
    assert!(configured_at(&mut conductor, S).expect("configured") < S + S / 10);

    let mut conductor = with_member(S);
    let mut effects = Vec::new();
    conductor.await_no_spectators(S, &mut effects);
    assert!(
        effects
            .iter()
            .any(|e| matches!(e, Effect::Order(Numbered { body: Order::Configure(_), .. })))
    );
}

#[test]
fn spectators_of_one_name_are_told_to_take_another_and_members_are_refused() {
    let mut conductor = with_member(S);
    let first = join(&mut conductor, S, hello("viewer-logger", Kind::ViewerLogger, 2));
    assert!(matches!(first, Welcome::Accepted { .. }));
    let second = join(&mut conductor, S, hello("viewer-logger", Kind::ViewerLogger, 3));
    assert_eq!(second, Welcome::NameTaken);
    let second = join(&mut conductor, S, hello("viewer-logger-2", Kind::ViewerLogger, 3));
    assert!(matches!(second, Welcome::Accepted { .. }));
    let twice = join(&mut conductor, S, hello("external-world", Kind::ExternalWorld, 9));
    assert!(matches!(twice, Welcome::Refused(_)), "{twice:?}");
    conductor.alive(S, "viewer-logger", inc(first), false, &mut Vec::new());
    let again = join(&mut conductor, S, hello("viewer-logger", Kind::ViewerLogger, 4));
    assert!(matches!(again, Welcome::Accepted { .. }), "a name comes free: {again:?}");
}

#[test]
fn spectators_without_end_are_refused_and_those_gone_make_room() {
    let mut conductor = with_member(S);
    let mut incs = Vec::new();
    for n in 0..5_000 {
        let spectator = hello(&format!("forged-{n}"), Kind::ViewerLogger, n);
        if let Welcome::Accepted(accepted) = join(&mut conductor, S, spectator) {
            incs.push((n, accepted.inc));
        }
    }
    assert_eq!(incs.len(), 1023, "1024 with the member");
    let (n, inc) = incs[0];
    conductor.alive(S, &format!("forged-{n}"), inc, false, &mut Vec::new());
    let late = join(&mut conductor, S, hello("viewer-logger", Kind::ViewerLogger, 1));
    assert!(matches!(late, Welcome::Accepted { .. }), "{late:?}");
}
