use super::*;

const S: i64 = 1_000_000_000;

/// A datagram every 100 ms for `seconds`, from some day on.
fn every_100_ms(seconds: i64) -> Vec<i64> {
    (0..seconds * 10).map(|i| 1_700_000_000 * S + i * S / 10).collect()
}

fn whole(times: &[i64], pace: Pace) -> Player {
    Player::new(times, i64::MIN, i64::MAX, pace, false, false, 0)
}

#[test]
fn an_hour_ends_where_an_hour_was_recorded_at_any_rate() {
    let times = every_100_ms(3600);
    for rate in [0.1, 0.3, 1.0, 1.7, 33.3, 100.0] {
        let mut player = whole(&times, Pace::times(rate).unwrap());
        let (mut wall, mut sent, mut worst) = (0, 0, 0);
        while let Some(at) = player.wake_at(&times[..]) {
            // A caller that always comes late by up to 3 ms.
            wall = wall.max(at) + (at % 3_000_000);
            let due = player.due(&times[..], wall);
            assert_eq!(due.start, sent, "nothing is left out or twice");
            for i in due.clone() {
                let ideal = ((times[i] - times[0]) as f64 / rate) as i64;
                worst = worst.max((wall - ideal).abs());
            }
            sent = due.end;
        }
        assert_eq!((sent, player.phase()), (times.len(), Phase::Ended), "rate {rate}");
        // A fast pace has several datagrams between two calls; none is late by more than they are.
        assert!(worst <= 6_100_000, "rate {rate}: {worst} ns off the ideal schedule");
    }
}

#[test]
fn never_early() {
    let times = every_100_ms(10);
    let mut player = whole(&times, Pace::times(0.7).unwrap());
    for wall in (0..15 * S).step_by(777_777) {
        for i in player.due(&times[..], wall) {
            let ideal = (times[i] - times[0]) as f64 / 0.7;
            assert!(wall as f64 >= ideal - 1.0, "datagram {i} at {wall}, due at {ideal}");
        }
    }
    assert_eq!(player.phase(), Phase::Ended);
}

#[test]
fn rates_outside_are_refused() {
    for bad in [0.0, 0.09, 100.1, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Pace::times(bad).is_err(), "{bad}");
    }
    assert_eq!(Pace::times(1.0), Ok(Pace::REAL_TIME));
}

#[test]
fn as_fast_as_possible_gives_all_in_bounded_parts() {
    let times = every_100_ms(500);
    let mut player = whole(&times, Pace::AsFastAsPossible);
    let mut sent = 0;
    while player.phase() == Phase::Playing {
        let due = player.due(&times[..], 0);
        assert!(due.len() <= MOST_DUE && due.start == sent);
        sent = due.end;
    }
    assert_eq!(sent, 5000);
}

#[test]
fn pause_resume_and_change_of_pace_keep_the_position() {
    let times = every_100_ms(100);
    let mut player = whole(&times, Pace::REAL_TIME);
    assert_eq!(player.due(&times[..], 10 * S), 0..101);
    player.pause(10 * S + S / 20);
    assert!(player.due(&times[..], 50 * S).is_empty());
    assert_eq!(player.wake_at(&times[..]), None);
    player.resume(60 * S);
    assert_eq!(player.wake_at(&times[..]), Some(60 * S + S / 20));
    assert_eq!(player.due(&times[..], 61 * S), 101..111);
    player.set_pace(Pace::times(10.0).unwrap(), 61 * S);
    assert_eq!(player.due(&times[..], 62 * S), 111..211);
    player.set_pace(Pace::times(0.5).unwrap(), 62 * S);
    assert_eq!(player.due(&times[..], 64 * S), 211..221);
}

#[test]
fn seek_goes_there_and_keeps_playing_or_standing() {
    let times = every_100_ms(100);
    let mut player = whole(&times, Pace::REAL_TIME);
    player.seek(&times[..], times[0] + 50 * S, 1000 * S);
    assert_eq!(player.due(&times[..], 1000 * S), 500..501, "the datagram of that very time");
    player.pause(1000 * S);
    player.seek(&times[..], times[0] + 7 * S + 1, 1001 * S);
    assert_eq!((player.phase(), player.next()), (Phase::Paused, 71));
    player.seek(&times[..], i64::MAX, 1001 * S);
    assert_eq!(player.next(), 999);
    player.seek(&times[..], i64::MIN, 1001 * S);
    assert_eq!(player.next(), 0);
    player.resume(1001 * S);
    assert_eq!(player.due(&times[..], 2000 * S).len(), 1000);
    assert_eq!(player.phase(), Phase::Ended);
    player.seek(&times[..], times[500], 2000 * S);
    assert_eq!((player.phase(), player.next()), (Phase::Paused, 500), "after the end");
}

#[test]
fn steps_go_forward_and_back() {
    let times = every_100_ms(1);
    let mut player = whole(&times, Pace::REAL_TIME);
    assert_eq!(player.step_back(&times[..], 0), None, "nothing before the first");
    assert_eq!(player.phase(), Phase::Paused, "stepping stands");
    let forward: Vec<_> = std::iter::from_fn(|| player.step(&times[..], 0)).collect();
    assert_eq!(forward, (0..10).collect::<Vec<_>>());
    assert_eq!(player.phase(), Phase::Ended);
    let back: Vec<_> = std::iter::from_fn(|| player.step_back(&times[..], 0)).collect();
    assert_eq!(back, times.iter().rev().copied().collect::<Vec<_>>());
    assert_eq!(player.step(&times[..], 0), Some(0));
    player.resume(5 * S);
    assert_eq!(player.due(&times[..], 5 * S + S / 10), 1..2, "goes on from where it stands");
}

#[test]
fn rounds_follow_without_drift() {
    let times = every_100_ms(10);
    let mut player =
        Player::new(&times[..], i64::MIN, i64::MAX, Pace::times(2.0).unwrap(), true, false, 0);
    let mut sent = 0;
    // A late caller: 7 ms steps that never meet a due time exactly.
    for wall in (0..100 * S).step_by(7_000_000) {
        loop {
            let due = player.due(&times[..], wall);
            if due.is_empty() {
                break;
            }
            sent += due.len();
        }
    }
    // A round lasts 9.9 s of recording, 4.95 s of wall time.
    assert_eq!(player.rounds(), 20);
    let expected = 20 * 100 + (100.0 - 20.0 * 4.95) as usize * 20;
    assert!(sent.abs_diff(expected) <= 1, "{sent} of {expected}");
}

#[test]
fn the_window_keeps_its_ends_and_waits_where_told() {
    let times = every_100_ms(10);
    let (from, to) = (times[20] - S / 20, times[30]);
    let mut player = Player::new(&times[..], from, to, Pace::REAL_TIME, false, true, 0);
    assert_eq!((player.window(), player.phase()), (20..31, Phase::Waiting));
    assert!(player.due(&times[..], 100 * S).is_empty(), "waits for Start/Resume");
    player.resume(200 * S);
    assert_eq!(player.wake_at(&times[..]), Some(200 * S + S / 20), "from the time named");
    assert_eq!(player.due(&times[..], 300 * S), 20..31);
    let empty =
        Player::new(&times[..], times[9] + 1, times[9] + 2, Pace::REAL_TIME, true, false, 0);
    assert_eq!((empty.phase(), empty.wake_at(&times[..])), (Phase::Ended, None));
    let none: [i64; 0] = [];
    assert_eq!(whole(&none, Pace::REAL_TIME).phase(), Phase::Ended);
}

#[test]
fn all_at_one_time_in_a_loop_does_not_hang() {
    let times = [5 * S; 3];
    let mut player = Player::new(&times[..], i64::MIN, i64::MAX, Pace::REAL_TIME, true, false, 0);
    for _ in 0..5 {
        assert_eq!(player.due(&times[..], 0), 0..3);
    }
}
