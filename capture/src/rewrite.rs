//! Identifiers in PDUs changed in place: exercise, site, application, time stamp.

use crate::bytes::be16;
use pdu::DisTime;

/// What is changed in every PDU. Lengths stay as they are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rewrite {
    /// The exercise of every PDU.
    pub exercise: Option<u8>,
    /// Sites: old number (`None`: any) to new one; the first that fits counts.
    pub site: Vec<(Option<u16>, u16)>,
    /// Applications: old number (`None`: any) to new one; the first that fits counts.
    pub application: Vec<(Option<u16>, u16)>,
}

/// Addresses nobody, and everybody: never changed.
const SPECIAL: [u16; 2] = [0, 0xffff];

impl Rewrite {
    /// True if nothing is changed.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }

    /// Changes every PDU of a datagram, as far as it can be walked. Sites and applications are changed
    /// in all entity, event and object identifiers of the types that have them at known places,
    /// targets of emissions and sets of attributes included; 0 (nobody) and 65535 (everybody) stay.
    pub fn apply(&self, datagram: &mut [u8]) {
        self.apply_at(datagram, None);
    }

    /// As [`Rewrite::apply`], and gives every PDU the time stamp `stamp`. Whether it counts as
    /// absolute stays as it was.
    pub fn apply_at(&self, datagram: &mut [u8], stamp: Option<DisTime>) {
        let mut start = 0;
        while let Some(length) = be16(&datagram[start..], 8).map(usize::from) {
            let Some(pdu) = datagram.get_mut(start..start + length) else { return };
            if length < 12 {
                return;
            }
            if let Some(exercise) = self.exercise {
                pdu[1] = exercise;
            }
            if let Some(stamp) = stamp {
                let word = stamp.0 & !1 | u32::from(pdu[7] & 1);
                pdu[4..8].copy_from_slice(&word.to_be_bytes());
            }
            if !self.site.is_empty() || !self.application.is_empty() {
                for at in identifiers(pdu) {
                    change(pdu, at, &self.site);
                    change(pdu, at + 2, &self.application);
                }
            }
            start += length;
        }
    }
}

fn change(pdu: &mut [u8], at: usize, rules: &[(Option<u16>, u16)]) {
    let Some(old) = be16(pdu, at) else { return };
    if SPECIAL.contains(&old) {
        return;
    }
    if let Some((_, new)) = rules.iter().find(|(from, _)| from.is_none_or(|from| from == old)) {
        pdu[at..at + 2].copy_from_slice(&new.to_be_bytes());
    }
}

/// Where in a PDU identifiers that begin with site and application stand. Source: IEEE 1278.1-2012,
/// clause 7, by type.
pub(crate) fn identifiers(pdu: &[u8]) -> Vec<usize> {
    let fixed: &[usize] = match pdu[2] {
        1 | 26 | 30 | 31 | 33 | 34 | 37 | 38 | 40 | 41 | 42 | 67 | 68 | 70 | 71 | 72 | 25 => &[12],
        // Fire, Detonation, the collisions: shooter, target, munition or event.
        2 | 3 => &[12, 18, 24, 30],
        4 | 66 | 69 => &[12, 18, 24],
        // Logistics, simulation management, -R, IFF, sound, parts, emissions: two in a row.
        5..=22 | 23 | 28 | 29 | 36 | 39 | 51..=65 => &[12, 18],
        24 => &[12, 20],
        27 => &[12, 28],
        32 => &[14],
        35 => &[12, 18, 30],
        43..=45 => &[12, 18],
        _ => &[],
    };
    let mut all = fixed.to_vec();
    match pdu[2] {
        23 => emission_targets(pdu, &mut all),
        72 => attribute_sets(pdu, &mut all),
        _ => {}
    }
    all
}

/// Entities that beams track or jam. Source: IEEE 1278.1-2012, 7.6.2.
fn emission_targets(pdu: &[u8], all: &mut Vec<usize>) {
    let mut system = 28;
    for _ in 0..pdu.get(25).copied().unwrap_or(0) {
        let Some(beams) = pdu.get(system + 1).copied() else { return };
        let mut beam = system + 20;
        for _ in 0..beams {
            let Some(targets) = pdu.get(beam + 45).map(|n| usize::from(*n)) else { return };
            all.extend((0..targets).map(|n| beam + 52 + 8 * n).filter(|at| at + 4 <= pdu.len()));
            beam += 52 + 8 * targets;
        }
        system = beam;
    }
}

/// Entities whose attributes an Attribute PDU tells. Source: IEEE 1278.1-2012, 7.2.6.
fn attribute_sets(pdu: &[u8], all: &mut Vec<usize>) {
    let mut at = 32;
    for _ in 0..be16(pdu, 30).unwrap_or(0) {
        let Some(records) = be16(pdu, at + 6) else { return };
        all.push(at);
        at += 8;
        for _ in 0..records {
            let Some(length) = be16(pdu, at + 4).filter(|n| *n >= 6) else { return };
            at += usize::from(length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pdu::records::{EntityId, SimulationAddress};
    use pdu::{Body, EntityState, Envelope, management};

    #[test]
    fn identifiers_change_and_nothing_else() {
        let rewrite = Rewrite {
            exercise: Some(9),
            site: vec![(Some(1), 70)],
            application: vec![(Some(5), 50), (None, 80)],
        };
        let envelope = Envelope::new(1, DisTime::relative(77_000_000));
        let state = EntityState {
            entity_id: EntityId::new(1, 2, 3),
            capabilities: 7,
            ..Default::default()
        };
        let start = management::RemoveEntity {
            originating_id: EntityId::new(4, 5, 6),
            receiving_id: EntityId::ALL,
            request_id: 8,
        };
        let mut datagram = Vec::new();
        envelope.append(&state, &mut datagram).unwrap();
        envelope.append(&start, &mut datagram).unwrap();
        let before = datagram.clone();
        rewrite.apply_at(&mut datagram, Some(DisTime::absolute(5_000_000_000)));
        let bodies: Vec<_> = pdu::pdus(&datagram).map(Result::unwrap).collect();
        let expected =
            EntityState { entity_id: EntityId::new(70, 80, 3), capabilities: 7, ..state };
        assert_eq!(bodies[0].body(), &Body::EntityState(expected));
        let expected =
            management::RemoveEntity { originating_id: EntityId::new(4, 50, 6), ..start };
        assert_eq!(bodies[1].body(), &Body::RemoveEntity(expected));
        for pdu in &bodies {
            assert_eq!(pdu.header().exercise_id, 9);
            assert_eq!(pdu.header().timestamp, DisTime::relative(5_000_000_000));
        }
        let mut same = before.clone();
        Rewrite::default().apply(&mut same);
        assert_eq!(same, before);
    }

    #[test]
    fn entities_inside_attributes_change() {
        let path =
            concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/dis/opendis7-gaz69-straight.pcap");
        let rewrite = Rewrite {
            site: vec![(None, 1234)],
            application: vec![(None, 4321)],
            ..Rewrite::default()
        };
        let mut attributes = 0;
        for datagram in crate::Reader::open(path).unwrap() {
            let mut payload = datagram.unwrap().payload;
            rewrite.apply(&mut payload);
            for frame in pdu::frames(&payload).map(Result::unwrap) {
                if frame.header.pdu_type.0 == 72 {
                    attributes += 1;
                    let inner = &frame.octets[32..36];
                    assert_eq!(inner, [4, 210, 16, 225], "set of attributes");
                    // Zero says nobody, and stays.
                    assert_eq!(frame.address(), Some(SimulationAddress::default()));
                }
            }
        }
        assert_eq!(attributes, 126);
    }

    proptest::proptest! {
        #[test]
        fn any_octets_are_rewritten_without_a_panic(mut octets in proptest::collection::vec(0u8.., 0..400), kind in 0u8..80) {
            let rewrite = Rewrite { site: vec![(None, 1)], application: vec![(None, 1)], exercise: Some(1) };
            if octets.len() > 12 {
                let len = octets.len() as u16;
                octets[8..10].copy_from_slice(&len.to_be_bytes());
                octets[2] = kind;
            }
            let before = octets.len();
            rewrite.apply(&mut octets);
            assert_eq!(octets.len(), before);
        }
    }
}
