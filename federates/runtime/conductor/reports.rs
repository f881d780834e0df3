//! What members say: reports and beats in, lost messages told again.

use super::{Conductor, Effect, Fault, MemberEntry};
use crate::runtime::clock::WallNs;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::messages::{Beat, FetchOf, Fetched, Numbered, Order, RepairOf, Report};
use crate::runtime::stream::Inbox;

/// Share of a new latency in the smoothed one: about a second of frames.
const LATENCY_SMOOTHING: f64 = 0.05;

impl Conductor {
    /// A report of a member.
    pub fn report(
        &mut self,
        now: WallNs,
        from: &str,
        report: Numbered<Report>,
        effects: &mut Vec<Effect>,
    ) {
        if self.hear(now, from, report.fed, report.inc) {
            self.told(now, from, report, effects);
        }
    }

    /// A report of a member, by itself or by somebody who remembers it: that says nothing of whether it lives.
    fn told(
        &mut self,
        now: WallNs,
        from: &str,
        report: Numbered<Report>,
        effects: &mut Vec<Effect>,
    ) {
        let Some(member) = self.members.get_mut(from) else { return };
        if report.seq == 0 {
            if matches!(report.body, Report::Present { .. }) {
                self.take_report(now, from, 0, report.body, effects);
            }
            return;
        }
        let next = member.stream.seen() + 1;
        for (seq, report) in (next..).zip(member.stream.take(now, report)) {
            self.take_report(now, from, seq, report, effects);
        }
    }

    /// Notes that a member lives; whether it is one.
    pub(super) fn hear(&mut self, now: WallNs, from: &str, fed: u128, inc: u64) -> bool {
        let known = self.members.get_mut(from).filter(|m| m.inc == inc && fed == self.config.fed);
        let Some(member) = known else { return false };
        member.heard_at = now;
        member.heard = true;
        // Silent while nothing was being made: nobody went on without it.
        if !member.alive && !member.returning && !self.views.removed().contains_key(from) {
            member.alive = true;
        }
        true
    }

    /// A beat of a member.
    pub fn beat(&mut self, now: WallNs, from: &str, beat: &Beat) {
        if !self.hear(now, from, beat.fed, beat.inc) {
            return;
        }
        let Some(member) = self.members.get_mut(from) else { return };
        member.stream.told(now, beat.last_seq);
        let working = beat.working.map(|(frame, _)| frame);
        if beat.run == self.run && working.is_some() && working != member.working {
            member.due_since = None;
        }
        member.working = working;
        for (_, _, seq) in beat.seen.iter().filter(|(of, inc, _)| of == CONDUCTOR && *inc == 0) {
            self.outbox.confirm(from, *seq);
        }
    }

    /// The conductor's own beat.
    #[must_use]
    pub fn own_beat(&self) -> Beat {
        // Of the lost nothing more is asked for once their loss is settled.
        let speaks = |m: &MemberEntry| m.alive || m.returning || self.views.is_open();
        let members = self.members.iter().filter(|(_, m)| speaks(m));
        let seen = members.map(|(n, m)| (n.clone(), m.inc, m.stream.seen()));
        Beat {
            fed: self.config.fed,
            run: self.run,
            inc: 0,
            last_seq: self.outbox.last(),
            executed: self.granted,
            working: None,
            seen: seen.collect(),
            utc_ns: 0,
        }
    }

    /// The host of the member called `name`, as it said when it joined.
    #[must_use]
    pub fn host_of(&self, name: &str) -> Option<&str> {
        self.members.get(name).map(|member| &member.hello.host[..])
    }

    /// Answers a member that lacks orders.
    #[must_use]
    pub fn fetch_orders(&self, ask: &FetchOf) -> Fetched<Order> {
        if ask.fetch.fed != self.config.fed || ask.fetch.inc != 0 {
            return Fetched { of: ask.of.clone(), items: Vec::new(), gone_before: 0 };
        }
        self.outbox.fetch(&ask.of, &ask.fetch)
    }

    /// Answers a member that lacks reports of another one.
    #[must_use]
    pub fn fetch_reports(&self, ask: &FetchOf) -> Fetched<Report> {
        let nothing = Fetched { of: ask.of.clone(), items: Vec::new(), gone_before: 0 };
        let stream = self.members.get(&ask.of).map(|m| &m.stream);
        let asked =
            |s: &&Inbox<Report>| s.inc() == ask.fetch.inc && ask.fetch.fed == self.config.fed;
        stream.filter(asked).map_or(nothing, |stream| stream.relay(&ask.of, &ask.fetch))
    }

    /// Whether PDUs that a member lacks are to be asked for in its place: who made them takes part in this run.
    #[must_use]
    pub fn passes_on(&self, ask: &RepairOf) -> bool {
        ask.repair.run == self.run && self.members.get(&ask.of).is_some_and(|m| m.alive)
    }

    /// Reports that were lost on their way.
    pub fn fetched(&mut self, now: WallNs, fetched: Fetched<Report>, effects: &mut Vec<Effect>) {
        let Some(member) = self.members.get(&fetched.of) else { return };
        if fetched.gone_before > member.stream.seen() + 1 {
            self.lose(now, fetched.of, "its reports were lost and are not remembered", effects);
            return;
        }
        for report in fetched.items {
            let inc = self.members.get(&fetched.of).map(|m| m.inc);
            if report.fed == self.config.fed && Some(report.inc) == inc {
                self.told(now, &fetched.of, report, effects);
            }
        }
    }

    pub(super) fn take_report(
        &mut self,
        now: WallNs,
        from: &str,
        seq: u64,
        report: Report,
        effects: &mut Vec<Effect>,
    ) {
        let Some(member) = self.members.get_mut(from) else { return };
        match report {
            Report::Present { hears, consumes } => {
                // A consumer must hear the producers, an awaited spectator everybody.
                let producers = self.heard_producers();
                let Some(member) = self.members.get_mut(from) else { return };
                let needed = match consumes {
                    _ if self.config.optional.iter().any(|o| o == from) => &[],
                    _ if self.config.await_spectators.iter().any(|s| s == from) => {
                        &self.config.expected[..]
                    }
                    true => &producers[..],
                    false => &[],
                };
                member.present = needed.iter().all(|p| p == from || hears.contains(p));
                member.consumes = consumes;
                self.try_configure(now, effects);
            }
            Report::Ready { run, at } if run == self.run => match at {
                None => {
                    member.ready = Some(run);
                    self.all_ready(now, effects);
                }
                Some(at) => self.returned(now, from, at, effects),
            },
            Report::Ends(ends) if ends.run == self.run && member.alive => {
                let Some((seq, ends)) = member.joined.take(seq, ends) else { return };
                let next = member.executed.map_or(0, |e| e + 1);
                if ends.first != next || ends.last < next || ends.last > self.granted {
                    return;
                }
                member.log.take(seq, &ends);
                let told = ends.state.map(|state| (ends.last, state));
                member.executed = Some(ends.last);
                member.due_since = None;
                // The grant that allowed the first of these frames.
                if let Some((at, _)) = self.grants.iter().find(|(_, upto)| *upto >= next) {
                    let took = now.saturating_sub(*at) as f64;
                    member.latency_ns += (took - member.latency_ns) * LATENCY_SMOOTHING;
                }
                self.record(from, ends, effects);
                if let Some((frame, state)) = told {
                    self.compare_traffic(now, from, frame, state, effects);
                }
                self.compare_inputs(now, effects);
                self.settle(now, effects);
                self.extend(now, effects);
            }
            Report::Whole { run, pdus } if run == self.run => self.take_whole(from, pdus),
            Report::Sealed { run, view, holds } if run == self.run => {
                self.views.sealed(from, view, holds);
                self.settle_views(now, effects);
            }
            Report::Held { run, view } if run == self.run => {
                self.views.held(from, view);
                self.settle_views(now, effects);
            }
            Report::Final(report) if report.run == self.run => {
                self.finals.insert(from.to_owned(), *report);
                self.results_came(now, from);
                self.try_close(now, effects);
            }
            Report::Failed { reason } if self.config.optional.iter().any(|o| o == from) => {
                self.lose(now, from.to_owned(), &format!("it cannot go on: {reason}"), effects);
            }
            Report::Failed { reason } if member.returning => {
                member.returning = false;
                let (name, inc) = (from.to_owned(), member.inc);
                self.notes.push(format!("{from} did not come back: {reason}"));
                self.say(Order::Dismiss { name, inc, reason }, effects);
            }
            Report::Failed { reason } => {
                let text = format!("{from} cannot go on: {reason}");
                self.faults.push(Fault { name: from.to_owned(), text, since: now, back: None });
                self.failed = true;
                self.fail_pending(effects);
                effects.push(Effect::Exit(1));
            }
            _ => {}
        }
    }
}
