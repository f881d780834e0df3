use super::super::conductor::{Input, OnLoss, Step};
use super::super::messages::Command;
use super::*;
use scenarios::losses::{ByMember, Losses};

struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        let name = format!("seeds-journal-{:032x}", super::super::process::random_id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir(&path).expect("a folder");
        Self(path)
    }

    fn file(&self) -> PathBuf {
        self.0.join("journal")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn config(fed: u128) -> ConductorConfig {
    let on_loss = ByMember { all: Some(OnLoss::TakeOver), ..ByMember::default() };
    ConductorConfig {
        scene: "two members".into(),
        scene_hash: 42,
        version: "1".into(),
        expected: vec!["smdfm".into(), "traffic-generator".into()],
        producers: vec!["traffic-generator".into()],
        optional: Vec::new(),
        generators: 1,
        seed: 1,
        step_ns: 50_000_000,
        start_utc_ns: 0,
        last_frame: 200,
        rate: f64::INFINITY,
        autostart: true,
        batch: true,
        await_spectators: Vec::new(),
        await_spectators_ns: 0,
        window: 40,
        closes: None,
        front_ends: std::collections::BTreeMap::new(),
        through_router: false,
        fed,
        losses: Losses { on_loss, ..Losses::default() },
    }
}

/// Three ticks with zero, one and two inputs.
fn ticks() -> Vec<Vec<Step>> {
    let told = |at, n| Step::Told(at, Input::Command(Command::Step { n }, n));
    vec![
        vec![Step::Tick(10)],
        vec![told(11, 1), Step::Tick(20)],
        vec![told(21, 2), Step::Told(22, Input::Alive("smdfm".into(), 3, false)), Step::Tick(30)],
    ]
}

/// Writes a journal; octets of its head.
fn written(path: &Path) -> usize {
    let (mut journal, past) = Journal::open(path, &config(7)).expect("a new journal");
    assert!(past.is_none());
    let head = std::fs::metadata(path).expect("it is there").len() as usize;
    for steps in ticks() {
        journal.append(&steps).expect("written");
    }
    head
}

/// Wherever the writer died, whole ticks are read, all that are whole, and what is written next stands behind them.
#[test]
fn a_journal_cut_at_any_octet_goes_on_behind_its_last_tick() {
    let folder = Folder::new();
    let path = folder.file();
    let head = written(&path);
    let whole = std::fs::read(&path).expect("it is there");
    let mut most = 0;
    for length in 0..=whole.len() {
        std::fs::write(&path, &whole[..length]).expect("cut");
        // The head is written at once, before anybody joins: what has not even that is no journal, and the file is kept.
        let Ok((mut journal, past)) = Journal::open(&path, &config(9)) else {
            assert!(length < head, "{length}");
            assert_eq!(std::fs::read(&path).expect("kept").len(), length);
            continue;
        };
        let Some(mut past) = past else {
            assert_eq!(length, 0);
            continue;
        };
        assert_eq!(past.fed, 7, "the federation of the station that died");
        let read: Vec<Step> = journal.steps(&mut past).collect();
        let n = (0..=3).rev().find(|n| read == ticks()[..*n].concat());
        let n = n.unwrap_or_else(|| panic!("{length}: {read:?}"));
        assert!(n >= most, "{length}");
        most = n;
        journal.append(&[Step::Tick(99)]).expect("written");
        drop((journal, past));
        let (mut journal, past) = Journal::open(&path, &config(9)).expect("again");
        let read: Vec<Step> = journal.steps(&mut past.expect("a past")).collect();
        assert_eq!(read, [ticks()[..n].concat(), vec![Step::Tick(99)]].concat(), "{length}");
    }
    assert_eq!(most, 3);
}

/// A damaged octet ends what is read before it, and is never taken for a step.
#[test]
fn a_damaged_journal_is_read_up_to_the_damage() {
    let folder = Folder::new();
    let path = folder.file();
    written(&path);
    let whole = std::fs::read(&path).expect("it is there");
    for at in 0..whole.len() {
        let mut octets = whole.clone();
        octets[at] ^= 0x10;
        std::fs::write(&path, &octets).expect("damaged");
        let Ok((mut journal, Some(mut past))) = Journal::open(&path, &config(9)) else { continue };
        let read: Vec<Step> = journal.steps(&mut past).collect();
        assert!((0..3).any(|n| read == ticks()[..n].concat()), "{at}: {read:?}");
    }
}

#[test]
fn a_journal_of_another_run_one_in_use_and_no_journal_are_refused_and_kept() {
    let folder = Folder::new();
    let path = folder.file();
    let (journal, _) = Journal::open(&path, &config(7)).expect("a new journal");
    let refused = |config: &ConductorConfig| match Journal::open(&path, config) {
        Ok(_) => panic!("it was taken"),
        Err(e) => e.to_string(),
    };
    assert!(refused(&config(7)).contains("belongs to an administration station that runs"));
    drop(journal);
    let other = ConductorConfig { seed: 2, ..config(7) };
    assert!(
        refused(&other).contains("one of another run (scene, seed, flags or build): remove it")
    );
    assert!(Journal::open(&path, &config(8)).expect("the same run").1.is_some());
    // In a folder each run has its own.
    let (first, second) = (Journal::open(&folder.0, &config(7)), Journal::open(&folder.0, &other));
    assert!(first.expect("a file").1.is_none() && second.expect("another").1.is_none());
    assert!(Journal::open(&folder.0, &other).expect("the same").1.is_some());
    assert_eq!(std::fs::read_dir(&folder.0).expect("a folder").count(), 3);
    std::fs::write(&path, "my diary").expect("written");
    assert!(refused(&config(7)).contains("no journal of an administration station"));
    assert_eq!(std::fs::read(&path).expect("kept"), b"my diary");
    let nowhere = Journal::open(&folder.0.join("no/where"), &config(7));
    assert!(nowhere.err().expect("refused").to_string().contains("--journal"));
}

#[test]
fn a_full_disk_is_told_from_a_folder_that_may_not_be_written() {
    let told = |kind: std::io::ErrorKind| {
        JournalError::File { path: "j".into(), error: kind.into() }.to_string()
    };
    assert!(told(std::io::ErrorKind::StorageFull).contains("make room there"));
    assert!(told(std::io::ErrorKind::PermissionDenied).contains("where this user may write"));
}
