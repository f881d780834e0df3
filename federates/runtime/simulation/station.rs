//! The simulated administration station: what the conductor decides is carried out, and what has to hold is checked.

use super::network::Parcel;
use super::{RECONNECT_NS, Simulation};
use crate::runtime::conductor::{Again, Conductor, Effect as Decision, Input, Step, Why};
use crate::runtime::life_cycle::Phase;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::messages::{Frame, Order};
use crate::runtime::run_log::RunLog;

impl Simulation {
    /// Tells the conductor, and its journal first.
    pub(super) fn tell(&mut self, input: Input) -> Vec<Decision> {
        let mut decisions = Vec::new();
        self.steps.push(Step::Told(self.now, input.clone()));
        self.conductor.take(self.now, input, &mut decisions);
        decisions
    }

    /// A station is started in place of one that died: of all that the one before knew it has the journal only.
    pub(super) fn start_station(&mut self) {
        if !std::mem::take(&mut self.station_dead) {
            return;
        }
        self.note("station made again");
        let mut names: Vec<String> = self.nodes.keys().cloned().collect();
        while let Some(name) = names.pop() {
            let within = self.draw(RECONNECT_NS);
            if let Some(node) = self.nodes.get_mut(&name) {
                node.finds_station = self.now + within;
            }
        }
        let mut log = RunLog::default();
        let steps = std::mem::take(&mut self.steps);
        let Again { conductor, now, effects } =
            Conductor::again(self.config.clone(), steps.clone(), |run, record| {
                log.append(run, record);
            });
        let was = std::mem::replace(&mut self.conductor, conductor);
        if format!("{was:?}") != format!("{:?}", self.conductor) || now > self.now {
            self.broken.push("the journal made another conductor".to_owned());
        }
        (self.log, self.steps) = (log, steps);
        self.closed_again(effects);
        // For the conductor no time passed; the simulation has one clock, so it is told of a pause.
        let decisions = self.tell(Input::Resumed);
        self.decide(decisions);
    }

    /// What the station before decided at last is carried out again, as nobody knows whether it was.
    fn closed_again(&mut self, effects: Vec<Decision>) {
        let twice = |d: &Decision| matches!(d, Decision::Closed(_) | Decision::Reached { .. });
        self.decide(effects.into_iter().filter(|d| !twice(d)).collect());
    }

    pub(super) fn decide(&mut self, decisions: Vec<Decision>) {
        let loss = self.network.bus_loss;
        for decision in decisions {
            match decision {
                Decision::Order(order) => {
                    if let Order::Grant { upto, .. } = order.body
                        && self.conductor.state().rate.is_infinite()
                        && upto > self.conductor.frame() + self.window
                        && upto > std::mem::replace(&mut self.granted, upto)
                    {
                        let frame = self.conductor.frame();
                        self.broken.push(format!("granted {upto} while all stand at {frame}"));
                    }
                    self.note(match &order.body {
                        Order::Seal { .. } => "seal",
                        Order::Cut { .. } => "cut",
                        Order::View { absent, .. } if absent.is_empty() => "view that waits",
                        Order::View { .. } => "view that goes on",
                        Order::Admit { .. } => "admit",
                        Order::Dismiss { .. } => "dismiss",
                        Order::Yield { .. } => "place given by command",
                        _ => "other orders",
                    });
                    if let Order::Yield { name, inc, .. } = &order.body {
                        self.yielding.insert((name.clone(), *inc));
                    }
                    let names: Vec<String> = self.nodes.keys().cloned().collect();
                    for name in names {
                        self.post("", &name, || Parcel::Order(order.clone()), loss);
                    }
                }
                Decision::Fetch { holder, ask } => {
                    self.note("reports asked for");
                    let parcel = || Parcel::Fetch(CONDUCTOR.to_owned(), ask.clone());
                    self.post("", &holder, parcel, loss);
                }
                Decision::Record(run, record) => self.log.append(run, &record),
                Decision::Closed(run) => self.closed.push(*run),
                Decision::Reached { phase, frame, why } => {
                    if matches!(why, Some(Why::Given(_))) {
                        self.note("stood for a move");
                    }
                    self.reached.push((phase, frame, why.is_some()));
                    if phase == Phase::Frozen {
                        self.check_frozen(frame, why.is_some());
                    }
                }
                Decision::Answer(_, answer) => self.answers.push((answer.ok, answer.text)),
                Decision::Exit(code) => self.exit = Some(code),
                Decision::Welcome(..) | Decision::State(_) => {}
            }
        }
    }

    /// By command all stand at exactly this frame, by a fault all consumers where nothing is left out.
    fn check_frozen(&mut self, frame: Frame, by_fault: bool) {
        let stand = if by_fault { self.conductor.stand() } else { frame };
        let state = self.conductor.state();
        for (name, node) in &self.nodes {
            let Some(member) = node.member.as_ref().filter(|_| !node.dead) else { continue };
            let alive = state.members.iter().any(|m| m.name == *name && m.alive);
            let counts = alive && (!by_fault || member.federate().consumes());
            let at = member.executed();
            // In a closed loop some may be ahead of him who closes it, and some do not read him.
            let most = match by_fault {
                true => self.conductor.stand_of(|p| member.federate().ahead_of(p)),
                false => stand,
            };
            // One that tells its frames to one other alone is a producer: it may have gone on to what was granted.
            let front_end = by_fault && self.front_ends.contains(name);
            if counts && !(stand..=most).contains(&at) && !(front_end && at > stand) {
                let text =
                    format!("FROZEN at {frame}: {name} stands at {at}, not {stand} to {most}");
                self.broken.push(text);
            }
        }
        self.note(if by_fault { "frozen by a fault" } else { "frozen by command" });
    }
}
