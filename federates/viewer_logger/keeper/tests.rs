use super::*;
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::SeatEvent;
use crate::viewer_logger::log::tests::Folder;
use crate::viewer_logger::tests::{scan, weather};
use models::control::alert::{AlertKind, Change, Stage};
use models::frames::Point2;

fn scene() -> Arc<Scene> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/zurich.toml");
    Arc::new(scenarios::load(&file).expect("the scene is sound"))
}

fn rows(file: &Path, question: &str) -> i64 {
    let reader = rusqlite::Connection::open(file).expect("a database");
    reader.query_row(question, [], |row| row.get(0)).expect(question)
}

fn state(run: u32, phase: Phase) -> Heard {
    // As a run with `--seed 7` says it from the beginning.
    Heard::State(RunState { run, phase, seed: 7, ..RunState::default() })
}

#[test]
fn a_run_is_kept_and_a_restart_gets_its_own_database() {
    let folder = Folder::new();
    let files = Files::in_folder(&folder.0, 1_763_684_465_000_000_000);
    let first = files.database.clone().expect("a database");
    assert!(first.ends_with("2025-11-21T00-21-05Z/run.sqlite"), "{}", first.display());
    let page = Page::new(Viewer::new(1 << 20));
    let mut keeper = Keeper::open(scene(), Some(page.clone()), &files).expect("opened");
    let here = SocketAddr::from(([127, 0, 0, 1], 3000));
    keeper.hear(state(0, Phase::Init), 1);
    keeper.hear(state(1, Phase::Running), 1);
    keeper.hear(state(1, Phase::Running), 2);
    keeper.hear(Heard::Weather(weather(10.0)), 2);
    for n in [1, 2, 2, 5] {
        keeper.hear(Heard::Scan(Box::new(scan(n))), 3);
        keeper.datagram(3, here, here, &[6, 1, 1, 1]);
    }
    assert_eq!(page.viewer().source().range(), Some((1, 5)));
    keeper.hear(state(2, Phase::Configured), 4);
    let mut again = scan(1);
    again.run = 2;
    keeper.hear(Heard::Scan(Box::new(again)), 5);
    keeper.hear(Heard::Scan(Box::new(scan(6))), 5); // a straggler of run 1
    assert_eq!(page.viewer().source().range(), Some((1, 1)));
    let kept = keeper.close(0);
    let second = first.with_file_name("run-2.sqlite");
    let databases = vec![first.clone(), second.clone()];
    let expected = Kept { scans: 4, scans_lost: 2, datagrams: 4, datagrams_lost: 0, databases };
    assert_eq!(kept, expected);
    assert!(!kept.complete());
    assert_eq!(rows(&first, "SELECT count(*) FROM scans"), 3);
    assert_eq!(rows(&first, "SELECT count(*) FROM states"), 2, "only changes");
    assert_eq!(rows(&first, "SELECT count(*) FROM run WHERE name = 'seed' AND value = '7'"), 1);
    assert_eq!(rows(&second, "SELECT count(*) FROM scans"), 1);
    let recorded = std::fs::metadata(files.recording.expect("a recording")).expect("a file");
    assert!(recorded.len() > 4 * 46);
}

/// The tables of traffic that behaves are written at the end of a run, also where another one follows it.
#[test]
fn a_run_of_behaving_traffic_that_is_followed_by_another_has_its_tables() {
    let folder = Folder::new();
    let files = Files::in_folder(&folder.0, 1_763_684_465_000_000_000);
    let first = files.database.clone().expect("a database");
    let scene = scenarios::load(&scenarios::locate("xsyn")).expect("the scene is sound");
    let mut keeper = Keeper::open(Arc::new(scene), None, &files).expect("opened");
    let at = |run: u32, frame: u64| {
        let phase = Phase::Running;
        Heard::State(RunState { run, phase, seed: 7, frame, ..RunState::default() })
    };
    keeper.hear(at(1, 0), 1);
    keeper.hear(Heard::Scan(Box::new(scan(1))), 2);
    let (seat, person) = ("ground".to_owned(), "me".to_owned());
    let event = SeatEvent::Silent { frame: 5, seat, person };
    keeper.hear(Heard::Inputs(vec![SeatMessage { run: 1, number: 1, event }]), 2);
    keeper.hear(at(1, 6000), 3);
    keeper.hear(at(2, 0), 4);
    keeper.hear(at(2, 6000), 5);
    keeper.close(0);
    let second = first.with_file_name("run-2.sqlite");
    let count = |file: &Path, table: &str| rows(file, &format!("SELECT count(*) FROM {table}"));
    for table in ["movements", "measures"] {
        assert!(count(&first, table) > 0, "{table}");
        assert_eq!(count(&first, table), count(&second, table), "{table}: one seed");
    }
    let inputs = [&first, &second].map(|file| count(file, "inputs"));
    assert_eq!(inputs, [1, 0], "what people did is of their run");
}

/// The second of two used to write over the first, or to be refused as a stranger.
#[test]
fn runs_that_begin_in_the_same_second_have_folders_of_their_own() {
    let folder = Folder::new();
    let take = || Files::in_folder(&folder.0, 1_763_684_465_000_000_000).database;
    let taken: std::collections::BTreeSet<_> = std::thread::scope(|s| {
        let all: Vec<_> = (0..12).map(|_| s.spawn(take)).collect();
        all.into_iter().map(|one| one.join().expect("taken")).collect()
    });
    assert_eq!(taken.len(), 12, "{taken:?}");
    let name = |n: u32| {
        format!("2025-11-21T00-21-05Z{}", if n == 1 { String::new() } else { format!("_{n}") })
    };
    for n in 1..=12 {
        let database = folder.0.join(name(n)).join("run.sqlite");
        assert!(taken.contains(&Some(database)), "{n}: {taken:?}");
    }
    // Where none can be made, opening says so.
    std::fs::write(folder.0.join("a-file"), []).expect("written");
    let files = Files::in_folder(&folder.0.join("a-file"), 0);
    let refused = Keeper::open(scene(), None, &files).err().expect("refused").to_string();
    assert!(refused.starts_with("making the folder") && refused.contains("a-file"), "{refused}");
}

/// What is told again is taken once; a hole is noted.
#[test]
fn alerts_that_were_lost_and_told_again_are_all_there_and_once() {
    let folder = Folder::new();
    let files = Files::in_folder(&folder.0, 1_763_684_465_000_000_000);
    let file = files.database.clone().expect("a database");
    let mut keeper = Keeper::open(scene(), None, &files).expect("opened");
    keeper.hear(state(1, Phase::Running), 1);
    let alert = |number: u64| AlertMessage {
        run: 1,
        number,
        id: number as u32,
        time_ns: number as i64,
        change: Change::Raised,
        kind: AlertKind::RunwayArrival,
        stage: Stage::Alarm,
        subjects: format!("A{number}"),
        since_ns: 0,
        asterix: 9,
        place_m: Point2::origin(),
    };
    let of = |range: std::ops::RangeInclusive<u64>| Heard::Alerts(range.map(alert).collect());
    keeper.hear(of(1..=1), 1);
    keeper.hear(of(1..=1), 2);
    // The messages of 2 and 3 were lost.
    keeper.hear(of(1..=4), 3);
    keeper.hear(of(2..=4), 4);
    assert_eq!(keeper.last_told, [4, 0, 0]);
    // 5 was lost for good.
    keeper.hear(of(6..=7), 5);
    let noted = "SELECT count(*) FROM run WHERE name = 'alerts_lost' AND value = '1'";
    assert_eq!(rows(&file, noted), 1);
    // Nothing came for minutes: 6 and 9 stand, what was told last is told again.
    keeper.hear(Heard::Alerts([6, 9, 12].map(alert).into()), 6);
    keeper.close(0);
    assert_eq!(rows(&file, "SELECT count(*) FROM alerts"), 8);
    assert_eq!(rows(&file, "SELECT count(DISTINCT subjects) FROM alerts"), 8);
    let lost = "SELECT value FROM run WHERE name = 'alerts_lost'";
    let reader = rusqlite::Connection::open(&file).expect("a database");
    let lost: String = reader.query_row(lost, [], |row| row.get(0)).expect("noted");
    assert_eq!(lost, "4", "5, 8, 10 and 11");
}

/// `seeds run --record x-2.pcapng`, then `--record x.pcapng` and a restart: the log of the first was replaced.
#[test]
fn a_restart_replaces_no_log_but_its_own_of_before() {
    let folder = Folder::new();
    let run = |name: &str, runs: u32| {
        let files = Files::beside(&folder.0.join(name));
        let mut keeper = Keeper::open(scene(), None, &files).expect("opened");
        for run in 1..=runs {
            keeper.hear(state(run, Phase::Running), 1);
            for n in 1..=u64::from(run) {
                let mut scan = scan(n);
                scan.run = run;
                keeper.hear(Heard::Scan(Box::new(scan)), 1);
            }
        }
        assert!(keeper.close(0).complete());
    };
    run("x-2.pcapng", 1);
    for _ in 0..2 {
        run("x.pcapng", 2);
        let scans = |name: &str| rows(&folder.0.join(name), "SELECT count(*) FROM scans");
        assert_eq!(["x-2.sqlite", "x.sqlite", "x-2_2.sqlite"].map(scans), [1, 1, 2]);
    }
    assert!(!folder.0.join("x-2_3.sqlite").exists(), "its own of before is replaced");
}

/// The last line said that all was kept.
#[test]
fn scans_of_a_run_whose_log_cannot_be_made_are_lost() {
    let folder = Folder::new();
    let files = Files::beside(&folder.0.join("x.pcapng"));
    let mut keeper = Keeper::open(scene(), None, &files).expect("opened");
    keeper.hear(state(1, Phase::Running), 1);
    keeper.hear(Heard::Scan(Box::new(scan(1))), 1);
    // No file can be made there any more, and the name is taken.
    keeper.database = Some(folder.0.join("gone").join("x.sqlite"));
    keeper.hear(state(2, Phase::Running), 2);
    for n in 1..=3 {
        let mut scan = scan(n);
        scan.run = 2;
        keeper.hear(Heard::Scan(Box::new(scan)), 2);
    }
    let kept = keeper.close(0);
    assert_eq!((kept.scans, kept.scans_lost, kept.complete()), (1, 3, false));
}

#[test]
fn a_recording_asked_for_by_name_replaces_the_last_one_but_no_stranger() {
    let folder = Folder::new();
    let files = Files::beside(&folder.0.join("x.pcapng"));
    for _ in 0..2 {
        let mut keeper = Keeper::open(scene(), None, &files).expect("opened");
        keeper.hear(Heard::Scan(Box::new(scan(1))), 1);
        assert!(keeper.close(0).complete());
    }
    let database = folder.0.join("x.sqlite");
    assert_eq!(rows(&database, "SELECT count(*) FROM scans"), 1);
    std::fs::write(&database, "my letters").expect("written");
    let refused = Keeper::open(scene(), None, &files).err().expect("refused").to_string();
    assert!(refused.contains("x.sqlite") && refused.contains("not a log"), "{refused}");
    assert_eq!(std::fs::read(&database).expect("still there"), b"my letters");
}
