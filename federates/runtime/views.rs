//! Which members are lost, and which of their frames count: seal, cut, hold, view.
//!
//! A loss is settled in two rounds over all survivors. *Seal*: from now on nothing of the lost
//! incarnations is accepted; every survivor answers how far it holds their frames. *Cut*: the highest
//! frame that a survivor holds counts for everybody; every survivor fetches what it lacks and says that
//! it holds it. *View*: closed; only now may anybody act on the cut. A further loss before that starts
//! again with the larger set, so any number of members may be lost together or one after the other.

use super::clock::WallNs;
use super::messages::{Cuts, Frame, Order};
use std::collections::BTreeMap;

/// A member that is not there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Removed {
    /// The incarnation that is lost.
    pub inc: u64,
    /// Its last frame that counts, once its view is closed; `Some(None)` if not even frame 0 does.
    pub cut: Option<Option<Frame>>,
    /// Frames after the cut count as absent; otherwise they are awaited from a successor.
    pub absent: bool,
}

#[derive(Debug)]
enum Stage {
    /// Who was asked, and what each holds of the lost members that it consumes.
    Sealing(BTreeMap<String, Option<Cuts>>),
    /// The cuts, and who was asked to hold all up to them.
    Holding(Cuts, BTreeMap<String, bool>),
}

#[derive(Debug)]
struct Open {
    set: Vec<(String, u64)>,
    stage: Stage,
    asked_at: WallNs,
}

/// The lost members of a run and the view that is being settled.
#[derive(Debug, Default)]
pub struct Views {
    run: u32,
    number: u32,
    open: Option<Open>,
    removed: BTreeMap<String, Removed>,
}

impl Views {
    /// A new run: whoever is not there is not awaited by its frames.
    pub fn reset(&mut self, run: u32) {
        *self = Self { run, number: self.number, ..Self::default() };
    }

    /// Number of the latest view.
    #[must_use]
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Whether a view is being settled.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Whether an answer of `name` is among those that a view is closed with.
    #[must_use]
    pub fn survives(&self, name: &str) -> bool {
        self.open.as_ref().is_some_and(|open| match &open.stage {
            Stage::Sealing(answers) => answers.contains_key(name),
            Stage::Holding(_, held) => held.contains_key(name),
        })
    }

    /// Members that are lost, by name.
    #[must_use]
    pub fn removed(&self) -> &BTreeMap<String, Removed> {
        &self.removed
    }

    /// `name` is lost: its view is opened, with all others that are not closed yet.
    pub fn lose(
        &mut self,
        now: WallNs,
        name: &str,
        inc: u64,
        absent: bool,
        survivors: &[String],
    ) -> Order {
        self.removed.insert(name.to_owned(), Removed { inc, cut: None, absent });
        self.number += 1;
        let unsettled = self.removed.iter().filter(|(_, r)| r.cut.is_none());
        let set: Vec<_> = unsettled.map(|(n, r)| (n.clone(), r.inc)).collect();
        self.open = Some(Open {
            set: set.clone(),
            stage: Stage::Sealing(survivors.iter().map(|n| (n.clone(), None)).collect()),
            asked_at: now,
        });
        Order::Seal { run: self.run, view: self.number, lost: set }
    }

    /// A survivor's answer to the seal of `view`: what it holds of each lost member that it consumes.
    pub fn sealed(&mut self, from: &str, view: u32, holds: Cuts) {
        if view == self.number
            && let Some(Open { stage: Stage::Sealing(answers), .. }) = &mut self.open
            && let Some(answer) = answers.get_mut(from)
        {
            *answer = Some(holds);
        }
    }

    /// A survivor holds every frame up to the cuts of `view`.
    pub fn held(&mut self, from: &str, view: u32) {
        if view == self.number
            && let Some(Open { stage: Stage::Holding(_, held), .. }) = &mut self.open
            && let Some(answer) = held.get_mut(from)
        {
            *answer = true;
        }
    }

    /// The next order, once all have answered. `known` is what the conductor itself knows of a member.
    pub fn next_order(
        &mut self,
        now: WallNs,
        known: impl Fn(&str) -> Option<Frame>,
    ) -> Option<Order> {
        let (run, view) = (self.run, self.number);
        let open = self.open.as_mut()?;
        match &mut open.stage {
            Stage::Sealing(answers) => {
                let answered: Option<Vec<_>> = answers.values().map(Option::as_ref).collect();
                let answered = answered?;
                let cut = |name: &String| {
                    let holds = answered.iter().flat_map(|a| a.iter());
                    let highest = holds.filter(|(n, _)| n == name).map(|(_, h)| *h).max();
                    highest.unwrap_or_else(|| known(name))
                };
                let cuts: Vec<_> = open.set.iter().map(|(n, _)| (n.clone(), cut(n))).collect();
                let asked = answers.keys().map(|n| (n.clone(), false)).collect();
                open.stage = Stage::Holding(cuts.clone(), asked);
                open.asked_at = now;
                Some(Order::Cut { run, view, cuts })
            }
            Stage::Holding(cuts, held) => {
                if held.values().any(|held| !held) {
                    return None;
                }
                let cuts = std::mem::take(cuts);
                self.open = None;
                let mut absent = Vec::new();
                for (name, cut) in &cuts {
                    if let Some(removed) = self.removed.get_mut(name) {
                        removed.cut = Some(*cut);
                        if removed.absent {
                            absent.push(name.clone());
                        }
                    }
                }
                Some(Order::View { run, view, cuts, absent })
            }
        }
    }

    /// Survivors that have not answered, and since when they are asked.
    #[must_use]
    pub fn awaited(&self) -> (WallNs, Vec<String>) {
        let Some(open) = &self.open else { return (0, Vec::new()) };
        let silent: Vec<String> = match &open.stage {
            Stage::Sealing(answers) => {
                answers.iter().filter(|(_, a)| a.is_none()).map(|(n, _)| n.clone()).collect()
            }
            Stage::Holding(_, held) => {
                held.iter().filter(|(_, held)| !**held).map(|(n, _)| n.clone()).collect()
            }
        };
        (open.asked_at, silent)
    }

    /// The last frame of a lost member that counts; none while that is not settled or it is not lost.
    #[must_use]
    pub fn cut(&self, name: &str) -> Option<Option<Frame>> {
        self.removed.get(name)?.cut
    }

    /// Whether `name` is lost and the run goes on without it.
    #[must_use]
    pub fn is_absent(&self, name: &str) -> bool {
        self.removed.get(name).is_some_and(|r| r.absent)
    }

    /// Whether frames of lost members are awaited from successors: time stands until then.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.removed.values().any(|r| !r.absent)
    }

    /// `name` is back.
    pub fn returned(&mut self, name: &str) {
        self.removed.remove(name);
    }
}
