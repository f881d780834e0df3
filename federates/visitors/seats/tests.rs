//! Laws of the door for people at seats.

use super::*;
use models::control::clearance::ClearanceKind;

const SECOND_NS: i64 = 1_000_000_000;

fn door() -> SeatDoor {
    SeatDoor {
        seats: vec!["apron".into(), "ground".into(), "tower 1".into()],
        callsigns: BTreeSet::from(["SWR1A".to_owned()]),
        frame_ns: 50_000_000,
        ..SeatDoor::default()
    }
}

fn order(seat: &str, person: &str, action: SeatAction) -> SeatOrder {
    SeatOrder { seat: seat.into(), person: person.into(), action }
}

fn say(callsign: &str, clearance: &str) -> SeatAction {
    SeatAction::Say {
        callsign: callsign.into(),
        clearance: ClearanceKind::of(clearance).expect("a clearance"),
    }
}

/// A client of the public interface is at the seat for handovers under the name that was left of his.
#[test]
fn who_may_have_a_name_as_a_client_may_have_it_at_a_seat() {
    for letter in (0..=255_u8).map(char::from) {
        let name = format!("me{letter}lab");
        let answer = door().ask(order("ground", &name, SeatAction::Take), 0);
        assert_eq!(answer.accepted, may_name(letter), "{letter:?}: {}", answer.text);
    }
    assert!(may_name('@') && !may_name('<') && !may_name('\n') && !may_name('ä'));
}

#[test]
fn a_seat_has_one_person_and_what_is_wrong_is_said_in_one_sentence() {
    let mut door = door();
    let taken = door.ask(order("ground", "anna", SeatAction::Take), 0);
    assert_eq!((taken.accepted, taken.number), (true, 1));
    for (asked, why) in [
        (order("ground", "ben", SeatAction::Take), "ground is taken by anna"),
        (order("ground", "ben", say("SWR1A", "TAX")), "ground is taken by anna"),
        (
            order("tower 2", "anna", SeatAction::Take),
            "there is no seat \"tower 2\"; there are apron",
        ),
        (order("apron", "anna", SeatAction::Leave), "nobody sits at apron: take it first"),
        (order("apron", "", SeatAction::Take), "person: 1 to 32"),
        (order("apron", "<b>", SeatAction::Take), "person: 1 to 32"),
        (order("ground", "anna", say("XXX9", "TAX")), "there is no flight \"XXX9\" in this scene"),
    ] {
        let answer = door.ask(asked, 0);
        assert!(!answer.accepted && answer.text.starts_with(why), "{answer:?}");
    }
    let said = door.ask(order("ground", "anna", say("SWR1A", "TAX")), 0);
    let inputs = door.admit(7, 0);
    assert_eq!(inputs.iter().map(|i| i.number).collect::<Vec<_>>(), [1, said.number]);
    assert!(door.admit(8, 0).is_empty(), "once");
    // Time stands: what cannot go into a frame is refused, however often it is asked.
    let refused =
        (0..1000).filter(|_| !door.ask(order("ground", "anna", say("SWR1A", "TAX")), 0).accepted);
    assert_eq!(refused.count(), 1000 - MOST_WAITING);
    assert!(
        SeatDoor::default()
            .ask(order("ground", "anna", SeatAction::Take), 0)
            .text
            .contains("[control]")
    );
}

#[test]
fn who_is_silent_loses_his_seat_and_who_is_there_is_told_of_every_minute() {
    let mut door = door();
    door.ask(order("ground", "anna", SeatAction::Take), 0);
    door.admit(1, 0);
    let mut told = Vec::new();
    for frame in 2..4000_u64 {
        let utc_ns = frame as i64 * 50_000_000;
        // A word every five seconds, for two minutes.
        if frame % 100 == 0 && frame <= 2400 {
            assert!(door.ask(order("ground", "anna", SeatAction::Here), utc_ns).accepted);
        }
        told.extend(door.admit(frame, utc_ns).into_iter().map(|i| (frame, i.order.action)));
    }
    use SeatAction::{Here, Leave};
    // 2400 frames are 120 s; silent for 30 s more.
    assert_eq!(told, [(1201, Here), (2401, Here), (2400 + 601, Leave)]);
    assert!(door.ask(order("ground", "ben", SeatAction::Take), 300 * SECOND_NS).accepted);
}

#[test]
fn inputs_of_another_run_come_in_their_frames_with_their_numbers() {
    let folder = std::env::temp_dir().join(format!("seeds-inputs-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("inputs.jsonl");
    let line = r#"{"frame":40,"seat":"ground","person":"anna","action":"take"}"#;
    let more = r#"{"frame":90,"seat":"ground","person":"anna","action":"say","callsign":"SWR1A","clearance":"TAX"}"#;
    std::fs::write(&file, format!("{line}\n\n{more}\n")).expect("written");
    let mut door = door();
    let script = read_for(&file, &door);
    door.follow(script.expect("read"));
    for _ in 0..2 {
        door.clear();
        let frames: Vec<(u64, u64)> = (1..200)
            .flat_map(|f| door.admit(f, 0).into_iter().map(move |i| (f, i.number)))
            .collect();
        assert_eq!(frames, [(40, 1), (90, 2)]);
    }
    // Where they have a seat, who asks for it again later is heard again, when it may be free.
    let later = door.ask(order("ground", "ben", SeatAction::Take), 0);
    let again = door.ask(order("ground", "ben", SeatAction::Take), 0);
    assert!(later.number > 0 && again.number > later.number, "{later:?} {again:?}");
    for (text, why) in [
        ("{\"frame\":1}", "inputs.jsonl:1: missing field `seat`"),
        (&line.replace("take", "fly"), "inputs.jsonl:1: there is no action \"fly\""),
        (&line.replace("take", "say"), "inputs.jsonl:1: say: name a callsign"),
        (&line.replace("ground", "attic"), "inputs.jsonl:1: there is no seat \"attic\"; there are"),
        (&line.replace("person", "who"), "inputs.jsonl:1: unknown field `who`"),
        (&line.replace("40", "-4"), "inputs.jsonl:1: frame: a whole number"),
        (&line.replace("frame", "fame"), "inputs.jsonl:1: missing field `frame`"),
    ] {
        std::fs::write(&file, text).expect("written");
        let error = format!("{:#}", read_for(&file, &door).expect_err("refused"));
        assert!(error.contains(why), "{error}");
    }
    // What has no end is refused, not read.
    std::fs::File::create(&file).and_then(|f| f.set_len(LARGEST_INPUTS + 1)).expect("made");
    let error = format!("{:#}", read_for(&file, &door).expect_err("refused"));
    assert!(error.contains("inputs.jsonl: longer than 16 MiB"), "{error}");
    let _ = std::fs::remove_dir_all(&folder);
}

fn wheel() -> SeatDoor {
    let mut door = door();
    door.seats.push("driver FOLLOW1".into());
    door.wheels.insert("driver FOLLOW1".into());
    door.paced(1.0);
    door
}

fn drive(throttle: i16) -> SeatAction {
    SeatAction::Drive { throttle, brake: 0, steer: 0 }
}

/// Of what one driver wishes before a frame the last counts, and of nobody else's anything is lost; after 5 s of silence he is gone.
#[test]
fn of_many_wishes_before_a_frame_the_last_counts_and_a_silent_driver_is_gone_soon() {
    let mut door = wheel();
    assert!(door.ask(order("driver FOLLOW1", "anna", SeatAction::Take), 0).accepted);
    assert!(door.ask(order("ground", "ben", SeatAction::Take), 0).accepted);
    for throttle in 0..500 {
        assert!(door.ask(order("driver FOLLOW1", "anna", drive(throttle)), 0).accepted);
    }
    let inputs = door.admit(1, 0);
    let actions: Vec<_> = inputs.iter().map(|i| i.order.action.clone()).collect();
    assert_eq!(actions, [SeatAction::Take, SeatAction::Take, drive(499)]);
    assert!(inputs.windows(2).all(|w| w[0].number < w[1].number));
    assert!(door.admit(2, 4 * SECOND_NS).is_empty());
    let gone = door.admit(3, 6 * SECOND_NS);
    assert_eq!(gone.len(), 1, "{gone:?}");
    assert_eq!(gone[0].order, order("driver FOLLOW1", "anna", SeatAction::Leave));
    assert!(door.ask(order("driver FOLLOW1", "ben", SeatAction::Take), 6 * SECOND_NS).accepted);
}

#[test]
fn who_cannot_drive_hears_why() {
    let mut door = wheel();
    door.ask(order("driver FOLLOW1", "anna", SeatAction::Take), 0);
    door.ask(order("ground", "anna", SeatAction::Take), 0);
    for (asked, why) in [
        (order("driver FOLLOW1", "ben", drive(1)), "driver FOLLOW1 is taken by anna"),
        (order("driver FOLLOW1", "anna", say("SWR1A", "TAX")), "driver FOLLOW1 drives"),
        (
            order("ground", "anna", drive(1)),
            "nothing is driven from ground; there are driver FOLLOW1",
        ),
        (order("driver CAR9", "anna", SeatAction::Take), "there is no seat \"driver CAR9\""),
    ] {
        let answer = door.ask(asked, 0);
        assert!(!answer.accepted && answer.text.starts_with(why), "{answer:?}");
    }
    // Faster than real time nobody drives; as fast as it he does, and giving up is always possible.
    door.paced(4.0);
    let answer = door.ask(order("driver FOLLOW1", "anna", drive(1)), 0);
    assert!(!answer.accepted && answer.text.contains("4.0 times real time"), "{answer:?}");
    assert!(door.ask(order("driver FOLLOW1", "anna", SeatAction::Leave), 0).accepted);
    let answer = door.ask(order("driver FOLLOW1", "anna", SeatAction::Take), 0);
    assert!(!answer.accepted && answer.text.contains("rate 1"), "{answer:?}");
    door.paced(1.0);
    assert!(door.ask(order("driver FOLLOW1", "anna", SeatAction::Take), 0).accepted);
}

/// Words and actions are each other's: what the log keeps is read back the same.
#[test]
fn what_is_driven_is_written_and_read_back_the_same() {
    for (throttle, brake, steer) in [(0, 0, 0), (-1000, 1000, 1000), (333, 0, -1000)] {
        let action = SeatAction::Drive { throttle, brake, steer };
        let (callsign, clearance) = action.said();
        assert_eq!(SeatAction::of(action.word(), callsign, &clearance), Ok(action.clone()));
    }
    for wrong in ["", "1 2", "1 2 3 4", "1001 0 0", "0 -1 0", "0 0 -1001", "a b c", "1e9 0 0"] {
        let why = SeatAction::of("drive", "", wrong).expect_err(wrong);
        assert!(why.starts_with("drive: give"), "{why}");
    }
}
