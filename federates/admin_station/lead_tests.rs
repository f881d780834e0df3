//! A station's conductor, its journal and its standby, on a real disk.

use super::clock_tests::config;
use crate::runtime::conductor::{Conductor, ConductorConfig, Effect, Input};
use crate::runtime::digest::pdu_hash;
use crate::runtime::follower::{Becomes, Follower};
use crate::runtime::journal::{Journal, run_of};
use crate::runtime::lead::Lead;
use crate::runtime::messages::{Fetch, FetchOf, Hello, Kind, Numbered, Report};
use crate::runtime::process::random_id;
use crate::runtime::run_log::RunLog;
use crate::runtime::succession::{Led, Steps, StepsAsk, Voted};
use std::path::Path;

/// A station, with what it finds at that path.
fn open(path: &Path, config: ConductorConfig, log: &mut RunLog) -> Lead {
    let opened = Journal::open(path, &config).expect("a journal");
    Lead::open(Some(opened), config, (1, random_id()), 0, log)
}

fn hello(name: &str) -> Hello {
    let (kind, pid, instance) = (Kind::TrafficGenerator, 1, 5);
    let (host, version) = ("h".into(), config().version);
    let scene_hash = config().scene_hash;
    Hello { name: name.into(), kind, pid, host, version, scene_hash, instance, was: None }
}

/// Whatever is to be done, the file knows already why: a copy of it, taken then, makes the same conductor.
#[test]
fn what_is_to_be_done_is_in_the_journal_before() {
    let folder = std::env::temp_dir().join(format!("seeds-lead-{:032x}", random_id()));
    std::fs::create_dir(&folder).expect("a folder");
    let (path, copy) = (folder.join("journal"), folder.join("copy"));
    let mut log = RunLog::default();
    let mut lead = open(&path, config(), &mut log);
    assert!(!lead.again());
    let mut welcomed = 0;
    for (n, name) in ["traffic-generator", "external-world", "smdfm"].iter().enumerate() {
        lead.tell(n as u64 * 1_000, Input::Hello(hello(name), n as u64));
        let effects = lead.tick(n as u64 * 1_000 + 500);
        welcomed += effects.iter().filter(|e| matches!(e, Effect::Welcome(..))).count();
        std::fs::copy(&path, &copy).expect("a copy");
        let (mut journal, past) = Journal::open(&copy, &config()).expect("a journal");
        let mut past = past.expect("a past");
        let config = ConductorConfig { fed: past.fed, ..config() };
        let again = Conductor::again(config, journal.steps(&mut past), |_, _| {});
        assert_eq!(format!("{:?}", again.conductor), format!("{:?}", lead.conductor()));
        assert_eq!(again.effects, effects, "carried out again, as nobody knows");
    }
    assert!(welcomed > 0);
    // A process that dies now is followed by one that leads the same federation, later by its own clock.
    let fed = lead.conductor().fed();
    drop(lead);
    let mut lead = open(&path, ConductorConfig { fed: 99, ..config() }, &mut log);
    assert!(lead.again() && lead.conductor().fed() == fed && lead.now(0) >= 2_500);
    lead.over();
    assert!(!path.exists(), "over");
    std::fs::remove_dir_all(&folder).expect("removed");
}

/// With a standby, a decision is heard once that holds what led to it; orders and beats say no more than was heard. Where the
/// standby is silent, the members and the station decide to go on.
#[test]
fn nothing_is_heard_that_the_standby_does_not_hold() {
    let folder = std::env::temp_dir().join(format!("seeds-held-{:032x}", random_id()));
    std::fs::create_dir(&folder).expect("a folder");
    let mut lead = open(&folder.join("journal"), config(), &mut RunLog::default());
    let ask = |from, sum| StepsAsk { run: run_of(&config()), who: 7, from, sum };
    let mut copy = Vec::new();
    let mut read = |lead: &mut Lead, now| loop {
        let tail = &copy[copy.len().saturating_sub(4096)..];
        match lead.steps(now, &ask(copy.len() as u64, pdu_hash(tail))) {
            Some(Steps::Octets(octets)) => copy.extend(octets),
            None => return copy.len(),
            other => panic!("{other:?}"),
        }
    };
    read(&mut lead, 0);
    assert!(!lead.led().standby, "members decide who leads: not without them");
    for (n, name) in ["external-world", "smdfm"].iter().enumerate() {
        lead.tell(n as u64, Input::Hello(hello(name), n as u64));
        assert_eq!(
            lead.tick(n as u64).iter().filter(|e| matches!(e, Effect::Welcome(..))).count(),
            1
        );
    }
    let held = read(&mut lead, 10);
    assert!(lead.led().standby && held > 0);
    let said = lead.beat();
    let command = |token| Input::Command(crate::runtime::messages::Command::Status, token);
    let answers = |effects: Vec<Effect>| -> Vec<u64> {
        let answered = |e: &Effect| match e {
            Effect::Answer(token, _) => Some(*token),
            _ => None,
        };
        effects.iter().filter_map(answered).collect()
    };
    lead.tell(1_000, command(40));
    assert!(answers(lead.tick(1_000)).is_empty());
    lead.tell(2_000, command(41));
    assert!(answers(lead.tick(2_000)).is_empty());
    assert_eq!(lead.beat(), said);
    assert!(
        matches!(lead.steps(2_500, &ask(held as u64, 1)), Some(Steps::Anew)),
        "of another journal"
    );
    assert!(read(&mut lead, 3_000) > held);
    assert_eq!(answers(lead.tick(4_000)), [40, 41], "in their order");

    // Nor is an order told to a member that asks for what it lacks.
    let lacking = |lead: &Lead| {
        let fetch = Fetch { fed: lead.conductor().fed(), inc: 0, from: 1, to: u64::MAX };
        lead.fetch_orders(&FetchOf { of: "conductor".into(), fetch }).items.len()
    };
    for name in ["external-world", "smdfm"] {
        let fed = lead.conductor().fed();
        let inc = lead.conductor().inc_of(name).expect("a member");
        let hears = vec!["external-world".to_owned()];
        let body = Report::Present { hears, consumes: name == "smdfm" };
        lead.tell(5_000, Input::Report(name.into(), Numbered { fed, inc, seq: 0, body }));
    }
    let decided = lead.tick(5_000);
    assert_eq!((decided.len(), lacking(&lead)), (0, 0));
    assert!(lead.conductor().own_beat().last_seq > 0, "to configure");
    read(&mut lead, 6_000);
    let ordered = |e: &Effect| matches!(e, Effect::Order(o) if o.seq > 0);
    let heard = lead.tick(6_500).iter().filter(|e| ordered(e)).count();
    assert_eq!((heard, lacking(&lead)), (1, 1));

    let silent = 5_000_000_000;
    lead.tell(silent, command(42));
    assert!(answers(lead.tick(silent)).is_empty());
    let questions = lead.questions(silent);
    assert_eq!(questions.len(), 2);
    for (n, (name, question)) in questions.iter().enumerate() {
        assert!(answers(lead.tick(silent + n as u64)).is_empty(), "{n} voices are too few");
        let inc = lead.conductor().inc_of(name).expect("a member");
        let voice = crate::runtime::succession::Voice::Promised;
        let (by, attempt) = (question.by, question.attempt);
        lead.voted(silent, name, &Voted { by, attempt, inc, voice });
    }
    assert_eq!(answers(lead.tick(silent + 9)), [42]);
    assert_eq!(lead.led(), Led { epoch: 1, standby: false });
    assert_eq!(lead.beat(), lead.conductor().own_beat());
    std::fs::remove_dir_all(&folder).expect("removed");
}

/// A standby reads all there is of a station's journal.
fn follow(lead: &mut Lead, standby: &mut Follower, now: u64) {
    // A question that finds nothing waits at the station.
    for at in (now..now + 3_000_000_000).step_by(100_000_000) {
        if let Some((number, ask)) = standby.ask(at).expect("a question") {
            let steps = lead.steps(at, &ask).unwrap_or(Steps::Octets(Vec::new()));
            let becomes = standby.told(at, number, Some(steps)).expect("written");
            assert_eq!(becomes, Becomes::Standby);
        }
    }
}

/// What a voter was told that a process has given up is late. So one that begins anew with another journal, and counts its questions anew,
/// is another process.
#[test]
fn a_standby_that_begins_anew_is_not_taken_for_the_one_before() {
    let folder = std::env::temp_dir().join(format!("seeds-anew-{:032x}", random_id()));
    std::fs::create_dir(&folder).expect("a folder");
    let mut leads = ["one", "two"].map(|name| {
        let mut lead = open(&folder.join(name), config(), &mut RunLog::default());
        for (n, name) in ["external-world", "smdfm"].iter().enumerate() {
            lead.tell(n as u64, Input::Hello(hello(name), n as u64));
            lead.tick(n as u64);
        }
        lead
    });
    // The second one knows something more, from its begin on.
    leads[1].tell(9, Input::Hello(hello("traffic-generator"), 9));
    leads[1].tick(9);
    let opened = Journal::open_copy(&folder.join("copy"), &config()).expect("a file");
    let mut standby = Follower::open(opened, &config(), (7, 70), 0);
    let mut asked = Vec::new();
    for (n, lead) in leads.iter_mut().enumerate() {
        let now = n as u64 * 20_000_000_000;
        follow(lead, &mut standby, now);
        assert!(standby.is_in(), "{n}");
        let silent = now + 10_000_000_000;
        let questions = standby.questions(silent);
        assert_eq!(questions.len(), 2, "{n}");
        asked.push((questions[0].1.by, questions[0].1.attempt));
        standby.heard(silent + 1);
        assert_eq!(standby.questions(silent + 2).len(), 2, "given back");
    }
    assert_ne!(asked[0], asked[1]);
    std::fs::remove_dir_all(&folder).expect("removed");
}
