//! What operators are answered, and what else a command makes known.

use super::*;

/// It made its journal of them, too.
#[test]
fn a_station_without_members_does_not_spin() {
    let mut conductor = Conductor::new(config(Losses::default(), 8, false));
    let (mut now, mut turns) = (S, 0);
    while now < 2 * S {
        now = conductor.deadline(now);
        conductor.tick(now, &mut Vec::new());
        turns += 1;
    }
    assert!(turns <= 100, "{turns} in a second");
}
