//! Who reaches both planes of a simulated federation and is none of it: what he says is of another federation, of an incarnation that
//! is no more, was said before, or is nothing at all.

use super::Simulation;
use super::network::Parcel;
use crate::runtime::messages::{FinalReport, Numbered, Order, Report};

/// Messages that may be said again.
const OVERHEARD: usize = 64;

/// Of a thousand messages, those that are followed by a forged one.
const FORGED: u64 = 200;

impl Simulation {
    /// What passes is overheard, and something else follows it.
    pub(super) fn intrude(&mut self, to: &str, passes: Parcel) {
        if self.intruder_until <= self.now || !self.chance(FORGED) {
            return;
        }
        let again = self.draw(4) == 0 && !self.overheard.is_empty();
        let forged = if again {
            let at = self.draw(self.overheard.len() as u64) as usize;
            self.overheard.get(at).and_then(said_again)
        } else {
            self.forged(&passes)
        };
        if let Some(heard) = said_again(&passes) {
            self.overheard.push_back(heard);
            if self.overheard.len() > OVERHEARD {
                self.overheard.pop_front();
            }
        }
        if let Some(forged) = forged {
            self.note("forged messages");
            let at = self.now + 10_000 + self.draw(self.network.delay_ns.max(1));
            self.put(at, to, forged);
        }
    }

    /// What he makes of what passes.
    fn forged(&mut self, passes: &Parcel) -> Option<Parcel> {
        let foreign = self.draw(2) == 0;
        let ahead = self.draw(3);
        let kind = self.draw(5);
        Some(match passes {
            Parcel::Order(order) => {
                let (run, last) = (self.conductor().state().run, self.config.last_frame);
                let body = match kind {
                    0 => Order::Exit { code: 1 },
                    1 => Order::Finish { run, frame: last },
                    2 => Order::Grant { run, upto: last },
                    3 => Order::Cut { run, view: u32::MAX, cuts: Vec::new() },
                    _ => order.body.clone(),
                };
                // The conductor has no incarnation.
                let (fed, inc) = if foreign { (order.fed ^ 1, 0) } else { (order.fed, 1 + ahead) };
                let seq = if kind == 0 { 0 } else { order.seq + ahead };
                Parcel::Order(Numbered { fed, inc, seq, body })
            }
            Parcel::Report(from, report) => {
                let run = self.conductor().state().run;
                let reason = "a word of nobody".to_owned();
                let name = from.clone();
                let body = match kind {
                    0 | 1 => Report::Failed { reason },
                    2 => Report::Final(Box::new(FinalReport { run, name, ..Default::default() })),
                    _ => report.body.clone(),
                };
                let (fed, inc) = older(foreign, report.fed, report.inc, ahead);
                Parcel::Report(from.clone(), Numbered { fed, inc, seq: report.seq + ahead, body })
            }
            Parcel::Beat(from, beat) => {
                let mut beat = beat.clone();
                (beat.fed, beat.inc) = match beat.inc {
                    0 => (beat.fed ^ 1, 0),
                    inc => older(foreign, beat.fed, inc, ahead),
                };
                (beat.last_seq, beat.executed) = (u64::MAX, u64::MAX);
                beat.seen.iter_mut().for_each(|(.., seq)| *seq = u64::MAX);
                Parcel::Beat(from.clone(), beat)
            }
            Parcel::Pdus(_) => {
                let length = self.draw(1_500);
                let octets: Vec<u8> = (0..length).map(|_| self.draw(256) as u8).collect();
                Parcel::Pdus(vec![octets.into()])
            }
            Parcel::Repair(from, repair) => {
                let mut repair = repair.clone();
                repair.wanted = vec![(self.draw(u64::MAX), vec![self.draw(u64::MAX)])];
                Parcel::Repair(from.clone(), repair)
            }
            Parcel::Fetch(from, ask) => {
                let mut ask = ask.clone();
                match kind {
                    0 => ask.fetch.fed ^= 1,
                    1 => ask.of = "nobody".to_owned(),
                    _ => (ask.fetch.from, ask.fetch.to) = (ask.fetch.to, ask.fetch.from),
                }
                Parcel::Fetch(from.clone(), ask)
            }
            _ => return None,
        })
    }
}

/// Of another federation, or of an incarnation before.
fn older(foreign: bool, fed: u128, inc: u64, by: u64) -> (u128, u64) {
    if foreign { (fed ^ 1, inc) } else { (fed, inc.saturating_sub(1 + by)) }
}

/// The same once more, of what has an effect only once.
fn said_again(parcel: &Parcel) -> Option<Parcel> {
    Some(match parcel {
        Parcel::Order(order) => Parcel::Order(order.clone()),
        Parcel::Report(from, report) => Parcel::Report(from.clone(), report.clone()),
        Parcel::Pdus(pdus) => Parcel::Pdus(pdus.clone()),
        _ => return None,
    })
}
