//! The run is checked as it goes: who steps the same traffic has the same state, and a consumer used what its producers named.

use super::{Conductor, Effect, Fault, MemberEntry, MemberLog};
use crate::runtime::clock::WallNs;
use crate::runtime::messages::{Frame, Kind, Used};

impl Conductor {
    /// All generators step the same traffic: where two of them do not have the same state at a frame, the run is
    /// worth nothing any more.
    pub(super) fn compare_traffic(
        &mut self,
        now: WallNs,
        from: &str,
        frame: Frame,
        state: u64,
        effects: &mut Vec<Effect>,
    ) {
        let generates = |m: &MemberEntry| m.alive && m.hello.kind == Kind::TrafficGenerator;
        if !self.members.get(from).is_some_and(generates) {
            return;
        }
        let differs = |m: &MemberEntry| {
            m.log.states.iter().rev().any(|(f, other)| *f == frame && *other != state)
        };
        let other = self.members.iter().find(|(n, m)| *n != from && generates(m) && differs(m));
        let Some(other) = other.map(|(name, _)| name.clone()) else { return };
        let text = format!(
            "{from} and {other} do not have the same traffic at frame {frame}: other builds, other hosts, or a fault of SEEDS"
        );
        self.differ(now, from.to_owned(), text, effects);
    }

    /// Every frame was made of what its producers named (invariant I3 of `protocol.md`), as far as both sides are told by
    /// now: what a consumer used may be known before what it was to use.
    pub(super) fn compare_inputs(&mut self, now: WallNs, effects: &mut Vec<Effect>) {
        let mut other: Option<(String, Used)> = None;
        let names: Vec<String> = self.members.keys().cloned().collect();
        for name in names {
            let Some(member) = self.members.get_mut(&name) else { continue };
            let mut told = std::mem::take(&mut member.log.used);
            told.retain(|used| {
                // Of one that the run goes on without, frames count up to its cut only, wherever that is.
                let Some(of) = self.members.get(&used.of) else { return false };
                if self.views.is_absent(&used.of) {
                    return false;
                }
                if of.executed < Some(used.last) {
                    return true;
                }
                let differs = of.log.named(used.first, used.last).is_some_and(|n| n != used.sum);
                if differs && other.is_none() {
                    other = Some((name.clone(), used.clone()));
                }
                false
            });
            if let Some(member) = self.members.get_mut(&name) {
                member.log.used = told;
            }
        }
        if let Some((name, Used { of, first, last, .. })) = other {
            let text = format!(
                "{name} did not use the PDUs that {of} named in frames {first} to {last}: other builds, or a fault of SEEDS"
            );
            self.differ(now, name, text, effects);
        }
    }

    fn differ(&mut self, now: WallNs, name: String, text: String, effects: &mut Vec<Effect>) {
        if self.differed {
            return;
        }
        self.differed = true;
        self.faults.push(Fault { name, text, since: now, back: None });
        self.failed = true;
        self.fail_pending(effects);
        effects.push(Effect::Exit(1));
    }
}

impl MemberLog {
    /// Sum of the hashes that it named in these frames, where all of them are remembered.
    fn named(&self, first: Frame, last: Frame) -> Option<u64> {
        let begin = self.named.front().and_then(|(begin, _)| first.checked_sub(*begin))? as usize;
        let end = begin + last.checked_sub(first)? as usize;
        self.named.get(end).filter(|(frame, _)| *frame == last)?;
        let all = self.named.range(begin..=end);
        Some(all.fold(0, |sum: u64, (_, named)| sum.wrapping_add(*named)))
    }
}
