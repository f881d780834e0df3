use super::*;
use pdu::{DisTime, EntityState, Envelope};

const UTC_NS: i64 = 1_700_000_000_000_000_000;
const FRAME_NS: i64 = 50_000_000;

fn state(id: EntityId) -> Vec<u8> {
    let mut octets = Vec::new();
    let body = EntityState { entity_id: id, ..EntityState::default() };
    Envelope::new(1, DisTime(1)).append(&body, &mut octets).expect("fits");
    octets
}

fn source(n: u8) -> SocketAddr {
    SocketAddr::from(([10, 0, 0, n], 3000))
}

fn door() -> Door {
    Door::new(1, 417, BTreeSet::from([(1, 1), (2, 2)]))
}

#[test]
fn own_entities_are_not_visitors_and_others_of_the_site_are() {
    let mut door = door();
    for (application, number) in [(1, 1), (2, 2), (1, 2)] {
        door.knock(UTC_NS, source(1), &state(EntityId::new(417, application, number)));
    }
    let admitted = door.admit(UTC_NS);
    assert_eq!(admitted.iter().map(|w| w.about.entity).collect::<Vec<_>>(), [2]);
    assert_eq!((door.heard(), door.refused().len()), (1, 0));
}

#[test]
fn who_speaks_for_one_of_ours_beside_the_federation_is_named() {
    let (mut door, own) = (door(), EntityId::new(417, 1, 1));
    let word = "two senders use the identifier of an entity of the scene";
    // The generator, then the one that took over from it: no word.
    for n in [1, 1, 1, 2, 2, 2] {
        door.knock(UTC_NS, source(n), &state(own));
    }
    assert_eq!(door.refused().get(word), None);
    // A forger beside it.
    for n in [3, 2, 3, 2] {
        door.knock(UTC_NS, source(n), &state(own));
    }
    assert_eq!(door.refused().get(word), Some(&3));
    assert!(door.admit(UTC_NS).is_empty(), "nothing of it comes in");
    for n in 0..200 {
        door.knock(UTC_NS, source(n), &state(own));
    }
    assert!(door.voices[&(1, 1)].1.len() <= VOICES);
    door.clear();
    assert!(door.voices.is_empty());
}

#[test]
fn who_is_on_no_list_is_refused_by_its_reason_in_every_run() {
    let mut door = door();
    let from = vec!["10.0.0.0/28".parse().expect("a network")];
    door.take_only(Senders::new(from, Vec::new(), BTreeSet::from([9])));
    for _ in 0..2 {
        door.knock(UTC_NS, source(1), &state(EntityId::new(9, 1, 1)));
        door.knock(UTC_NS, source(1), &state(EntityId::new(417, 5, 1)));
        door.knock(UTC_NS, source(1), &state(EntityId::new(8, 1, 1)));
        door.knock(UTC_NS, source(99), &state(EntityId::new(9, 1, 2)));
        let sites: Vec<u16> = door.admit(UTC_NS).iter().map(|w| w.about.site).collect();
        assert_eq!(sites, [9, 417]);
        assert_eq!(*door.refused(), BTreeMap::from([(NO_SENDER, 1), (NO_SITE, 1)]));
        door.clear();
    }
}

#[test]
fn visitors_have_what_the_scenes_own_leave_of_its_targets() {
    // Two are the scene's own.
    for (most, inside) in [(1, 0), (2, 0), (5, 3), (usize::MAX, 9)] {
        let mut door = door().with_targets(most);
        for run in 0..2 {
            for n in 0..9 {
                door.knock(UTC_NS, source(1), &state(EntityId::new(9, 1, n)));
            }
            assert_eq!((door.admit(UTC_NS).len(), door.inside()), (inside, inside), "{most} {run}");
            let over = door.refused().get("more targets than targets_max").copied();
            assert_eq!(over.unwrap_or(0), 9 - inside as u64, "{most} {run}");
            door.clear();
        }
    }
    // Who is silent makes room.
    let mut door = door().with_targets(3);
    door.knock(UTC_NS, source(1), &state(EntityId::new(9, 1, 1)));
    door.admit(UTC_NS);
    let later = UTC_NS + ROOM_AFTER_NS;
    door.knock(later, source(1), &state(EntityId::new(9, 1, 2)));
    assert_eq!(door.admit(later).len(), 1);
}

#[test]
fn a_flood_does_not_push_out_who_is_inside() {
    let mut door = door();
    let guest = EntityId::new(9, 9, 9);
    door.knock(UTC_NS, source(2), &state(guest));
    assert_eq!(door.admit(UTC_NS).len(), 1);
    let mut seen = 0;
    for frame in 1..200_i64 {
        let utc_ns = UTC_NS + frame * FRAME_NS;
        // 100 000 PDUs a second from one address, of ever new entities.
        for n in 0..5000 {
            let id = EntityId::new(frame as u16, (n >> 8) as u16, n as u16);
            door.knock(utc_ns, source(1), &state(id));
        }
        door.knock(utc_ns, source(2), &state(guest));
        let admitted = door.admit(utc_ns);
        assert!(admitted.len() <= PDUS_A_FRAME);
        assert!(admitted.iter().map(|w| w.octets.len()).sum::<usize>() <= OCTETS_A_FRAME);
        assert!(admitted.iter().filter(|w| w.from == source(1)).count() <= PDUS_A_FRAME / 2);
        seen += admitted.iter().filter(|w| w.about == guest).count();
        assert!(door.inside() <= ENTITIES && door.waiting_count <= WAITING);
    }
    assert_eq!(seen, 199, "the guest of before is heard in every frame");
    assert!(door.refused()["over the budget of its sender"] > 900_000);
}

#[test]
fn every_map_has_its_bound() {
    let mut door = door();
    for frame in 0..600_i64 {
        let utc_ns = UTC_NS + frame * FRAME_NS;
        for n in 0..300_i64 {
            let number = frame * 300 + n;
            let id = EntityId::new((number >> 16) as u16, 7, number as u16);
            let from = SocketAddr::from(([10, 1, (number % 7) as u8, (number % 251) as u8], 1));
            door.knock(utc_ns, from, &state(id));
        }
        door.admit(utc_ns);
    }
    assert!(door.waiting.len() <= SOURCES && door.inside.len() <= ENTITIES);
    assert!(door.ever.len() <= EVER);
    assert!(door.refused().contains_key("more than 4096 entities"));
}

/// Who comes and goes all the time does not fill the memory with names, either.
#[test]
fn identifiers_of_a_run_have_their_bound() {
    let mut door = door();
    for frame in 0..300_i64 {
        // All of the frame before are forgotten by now.
        let utc_ns = UTC_NS + frame * (ROOM_AFTER_NS + FRAME_NS);
        for n in 0..256_i64 {
            let number = frame * 256 + n;
            let id = EntityId::new((number >> 16) as u16, 7, number as u16);
            door.knock(utc_ns, source(1), &state(id));
        }
        door.admit(utc_ns);
    }
    assert_eq!(door.ever.len(), EVER);
    assert!(door.refused().contains_key("more than 65 536 identifiers in one run"));
}

/// What came first is chance: what is let in stands by sender and entity.
#[test]
fn what_is_let_in_is_in_one_order_however_it_came() {
    let said = [(2, 5), (1, 9), (2, 3), (1, 4), (3, 1)];
    let let_in = |turned: usize| -> Vec<(SocketAddr, EntityId)> {
        let mut door = door();
        for n in 0..said.len() {
            let (from, id) = said[(n + turned) % said.len()];
            door.knock(UTC_NS, source(from), &state(EntityId::new(9, 9, id)));
        }
        door.admit(UTC_NS).iter().map(|w| (w.from, w.about)).collect()
    };
    let mut sorted = said;
    sorted.sort_unstable();
    let sorted: Vec<_> =
        sorted.iter().map(|(from, id)| (source(*from), EntityId::new(9, 9, *id))).collect();
    for turned in 0..said.len() {
        assert_eq!(let_in(turned), sorted);
    }
}

#[test]
fn garbage_is_refused_and_counted() {
    let mut door = door();
    let sound = state(EntityId::new(9, 9, 9));
    for bad in [&b"garbage of some length"[..], &sound[..70], &[0; 1400]] {
        door.knock(UTC_NS, source(1), bad);
    }
    let mut other = sound.clone();
    other[1] = 2;
    door.knock(UTC_NS, source(1), &other);
    assert!(door.admit(UTC_NS).is_empty());
    assert!(door.refused()["not a sound PDU"] >= 2);
    assert_eq!(door.refused()["PDU of another exercise"], 1);
}

#[test]
fn a_removal_of_many_comes_in_where_it_means_somebody() {
    let mut door = door();
    let remove = |receiving_id| {
        let mut octets = Vec::new();
        let body = pdu::management::RemoveEntity { receiving_id, ..Default::default() };
        Envelope::new(1, DisTime(1)).append(&body, &mut octets).expect("fits");
        octets
    };
    let all_of_nine = remove(EntityId::new(9, 9, 0xffff));
    door.knock(UTC_NS, source(1), &all_of_nine);
    assert!(door.admit(UTC_NS).is_empty(), "nobody is inside");
    door.knock(UTC_NS, source(1), &state(EntityId::new(9, 9, 9)));
    assert_eq!(door.admit(UTC_NS).len(), 1);
    door.knock(UTC_NS, source(2), &all_of_nine);
    assert_eq!(door.admit(UTC_NS).len(), 1);
    assert_eq!(door.inside(), 1, "a wildcard is nobody");
}
