//! The simulated hosts of the administration station and of its standby: what they decide is carried out, and what has to hold is checked.

use super::network::Parcel;
use super::{
    BEAT_NS, DONE_WITHOUT, Event, LEASE_NS, LEFT_OUT, MS, Node, PLACES, RECONNECT_NS, STRANGER,
    Simulation,
};
use crate::runtime::conductor::{Conductor, Effect as Decision, Input, Token, Why};
use crate::runtime::follower::{Becomes, Follower};
use crate::runtime::journal::{Disk, Journal, JournalError, Past};
use crate::runtime::lead::Lead;
use crate::runtime::life_cycle::Phase;
use crate::runtime::member::{CONDUCTOR, Member};
use crate::runtime::messages::{
    Command, Fetch, FetchOf, Frame, Hello, Numbered, Order, RepairOf, Welcome,
};
use crate::runtime::run_log::RunLog;
use crate::runtime::succession::{Question, Steps};
use std::collections::BTreeMap;
use std::io::{Cursor, Error, ErrorKind, Read};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A journal and what it holds already.
type Opened = (Journal, Option<Past>);

/// How often a standby looks at its clock, ns.
const LOOK_NS: u64 = 50 * MS;

/// How long the standby waits for an answer, ns.
const ANSWER_NS: u64 = 1_000 * MS;

/// A simulated disk: what is on it outlives a process. Behind it, whether it is full.
#[derive(Clone, Debug, Default)]
struct Kept(Arc<Mutex<Vec<u8>>>, Arc<AtomicBool>);

impl Kept {
    fn with<T>(&self, what: impl FnOnce(&mut Vec<u8>) -> T) -> T {
        what(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Disk for Kept {
    fn length(&self) -> std::io::Result<u64> {
        Ok(self.with(|kept| kept.len() as u64))
    }

    fn read(&mut self, from: u64, octets: &mut [u8]) -> std::io::Result<()> {
        let from = from as usize;
        self.with(|kept| {
            let there = kept.get(from..from + octets.len());
            octets.copy_from_slice(there.ok_or(Error::from(ErrorKind::UnexpectedEof))?);
            Ok(())
        })
    }

    fn write(&mut self, at: u64, octets: &[u8]) -> std::io::Result<()> {
        let at = at as usize;
        let full = self.1.load(Ordering::Relaxed);
        let octets = if full { &octets[..octets.len() / 2] } else { octets };
        self.with(|kept| {
            kept.resize(kept.len().max(at + octets.len()), 0);
            kept[at..at + octets.len()].copy_from_slice(octets);
        });
        if full { Err(ErrorKind::StorageFull.into()) } else { Ok(()) }
    }

    fn cut(&mut self, length: u64) -> std::io::Result<()> {
        self.with(|kept| kept.resize(length as usize, 0));
        Ok(())
    }

    fn all(&self) -> std::io::Result<Box<dyn Read + Send>> {
        Ok(Box::new(Cursor::new(self.with(|kept| kept.clone()))))
    }

    fn remove(&self) -> std::io::Result<()> {
        self.with(Vec::clear);
        Ok(())
    }
}

/// What the process of a host is, or was when it died.
pub(super) enum Role {
    /// None was started, or it ended because another one leads.
    None,
    /// It leads, as far as it knows.
    Leads(Box<Lead>, RunLog),
    /// It follows.
    Follows(Box<Follower>),
}

/// A host of a station.
pub(super) struct Host {
    disk: Kept,
    pub(super) role: Role,
    /// Its process, by when it was started: its clock begins then.
    pub(super) started: u64,
    pub(super) dead: bool,
    pub(super) paused_until: u64,
    pub(super) deaf_until: u64,
    pub(super) mute_until: u64,
    next_beat: u64,
    /// When a standby looks at its clock again.
    look_at: u64,
    /// Who waits to be let in, by process.
    hellos: BTreeMap<Token, (String, u128)>,
    /// Questions so far that are to be answered.
    tokens: Token,
    /// The question that waits for more of the journal: by which token, of which process, which one of it.
    steps: Option<(Token, u64, u64)>,
    /// It has said that it asks for voices.
    contends: bool,
    /// It has no journal any more, since its disk is full.
    unwritten: bool,
}

impl Host {
    pub(super) fn new() -> Self {
        Self {
            disk: Kept::default(),
            role: Role::None,
            started: 0,
            dead: true,
            paused_until: 0,
            deaf_until: 0,
            mute_until: 0,
            next_beat: 0,
            look_at: 0,
            hellos: BTreeMap::new(),
            tokens: 0,
            steps: None,
            contends: false,
            unwritten: false,
        }
    }

    /// Nothing more can be written there, until a process is started.
    pub(super) fn fill_disk(&mut self) {
        self.disk.1.store(true, Ordering::Relaxed);
    }

    fn disk_is_full(&self) -> bool {
        self.disk.1.load(Ordering::Relaxed)
    }

    pub(super) fn lead(&self) -> Option<&Lead> {
        match &self.role {
            Role::Leads(lead, _) => Some(lead),
            _ => None,
        }
    }

    /// When it has something to do, by the simulated clock.
    pub(super) fn next(&self, now: u64) -> u64 {
        if self.dead {
            return u64::MAX;
        }
        let at = match &self.role {
            Role::None => return u64::MAX,
            Role::Leads(lead, _) => {
                let deadline = lead.conductor().deadline(lead.now(now - self.started));
                let due = deadline.min(lead.questions_due());
                let due = due.saturating_sub(lead.now(0)).saturating_add(self.started);
                due.min(self.next_beat)
            }
            Role::Follows(_) => self.look_at,
        };
        at.max(self.paused_until)
    }
}

impl Simulation {
    /// The conductor that leads: that of the last epoch, also of a station that is gone.
    #[must_use]
    pub fn conductor(&self) -> &Conductor {
        let lead = self.leader().and_then(|at| self.hosts[at].lead());
        lead.map_or(&self.none, Lead::conductor)
    }

    /// How the two stations stand, for people.
    #[must_use]
    pub fn stations(&self) -> Vec<String> {
        let says = |(host, place): (&Host, &&str)| {
            let says = match &host.role {
                Role::None => "nobody".to_owned(),
                Role::Leads(lead, _) => lead.says(),
                Role::Follows(follower) => follower.says(),
            };
            format!("{place}{}: {says}", if host.dead { ", gone" } else { "" })
        };
        self.hosts.iter().zip(&PLACES).map(says).collect()
    }

    /// Where the station of the last epoch is.
    pub(super) fn leader(&self) -> Option<usize> {
        let leads = |at: &usize| self.hosts[*at].lead().map(|lead| (lead.led().epoch, 1 - at));
        (0..PLACES.len()).filter(|at| leads(at).is_some()).max_by_key(leads)
    }

    /// Whether a process works there.
    pub(super) fn works(&self, at: usize) -> bool {
        !self.hosts[at].dead && self.hosts[at].paused_until <= self.now
    }

    fn journal(&self, at: usize, begin: bool) -> Result<Opened, JournalError> {
        let disk = Box::new(self.hosts[at].disk.clone());
        Journal::on(disk, Path::new(PLACES[at]), &self.config, begin)
    }

    /// A process is started there: the station, or who led when it died, with its journal; else a standby.
    pub(super) fn start_station(&mut self, at: usize) {
        if !self.hosts[at].dead {
            return;
        }
        self.hosts[at].disk.1.store(false, Ordering::Relaxed);
        let leads = self.hosts[at].lead().is_some() || (at == 0 && self.leader().is_none());
        let opened = match self.journal(at, leads) {
            Ok(opened) => opened,
            Err(e) => return self.broken.push(format!("{}: {e}", PLACES[at])),
        };
        self.processes += 1;
        let who = (at as u64 + 1, u128::from(self.processes) << 32);
        let (mut log, again) = (RunLog::default(), opened.1.is_some());
        if leads {
            if again {
                self.check_made_again(at);
            }
            let lead = Lead::open(Some(opened), self.config.clone(), who, 0, &mut log);
            self.hosts[at].role = Role::Leads(Box::new(lead), log);
            self.check_knows(at);
            if again {
                self.note("station made again");
            }
        } else {
            let follower = Follower::open(opened, &self.config, who, 0);
            self.hosts[at].role = Role::Follows(Box::new(follower));
            self.note("standby started");
        }
        let now = self.now;
        let host = &mut self.hosts[at];
        (host.dead, host.started, host.next_beat, host.look_at) = (false, now, now, now);
        (host.steps, host.contends, host.paused_until) = (None, false, now);
        host.unwritten = false;
        host.hellos.clear();
        if again || at > 0 {
            self.finds(at);
        }
    }

    /// Each federate finds a process that was started there within a while, and so does the other host.
    fn finds(&mut self, at: usize) {
        let mut names: Vec<String> = self.nodes.keys().cloned().collect();
        while let Some(name) = names.pop() {
            let within = self.draw(RECONNECT_NS);
            if let Some(node) = self.nodes.get_mut(&name) {
                node.finds_station[at] = self.now + within;
            }
        }
        if self.hosts[1 - at].dead {
            return;
        }
        self.stations_meet = self.now + self.draw(RECONNECT_NS);
        self.put(self.stations_meet, PLACES[1 - at], Parcel::Station(true));
    }

    /// The journal makes the conductor that died.
    fn check_made_again(&mut self, at: usize) {
        let Ok((mut journal, Some(mut past))) = self.journal(at, true) else { return };
        let again =
            Conductor::again(self.config.clone(), journal.steps(&mut past), |_, _| {}).conductor;
        let same = |lead: &Lead| format!("{:?}", lead.conductor()) == format!("{again:?}");
        if !self.hosts[at].lead().is_some_and(same) {
            self.broken.push("the journal made another conductor".to_owned());
        }
    }

    /// Whoever leads on knows every word that was said.
    fn check_knows(&mut self, at: usize) {
        // Where a standby was in it may lead: then this one says nothing.
        let lead = self.hosts[at].lead().filter(|lead| !lead.led().standby);
        let Some(lead) = lead else { return };
        if lead.conductor().own_beat().last_seq < self.said.keys().last().copied().unwrap_or(0) {
            let last = lead.conductor().own_beat().last_seq;
            let said = self.said.last_key_value();
            self.broken.push(format!("{} leads on and knows of {last}: {said:?}", PLACES[at]));
        }
    }

    /// Everything that is due there now.
    pub(super) fn pass_station(&mut self, at: usize) {
        if !self.works(at) {
            return;
        }
        let clock = self.now - self.hosts[at].started;
        let mut questions = Vec::new();
        match &mut self.hosts[at].role {
            Role::None => {}
            Role::Leads(..) => {
                self.beat_of(at);
                let Role::Leads(lead, _) = &mut self.hosts[at].role else { return };
                let now = lead.now(clock);
                let turn = lead.turn(now);
                questions = lead.questions(now);
                let standing = lead.standing();
                self.disk_fails(at);
                for (token, steps) in turn.told {
                    self.tell_steps(at, token, steps);
                }
                self.decide(at, turn.effects);
                self.contends(at, standing);
            }
            Role::Follows(follower) => {
                let asked = follower.ask(clock);
                questions = follower.questions(clock);
                let standing = follower.standing();
                self.hosts[at].look_at = self.now + LOOK_NS;
                match asked {
                    Ok(Some((number, ask))) => {
                        let process = self.hosts[at].started;
                        let parcel = || Parcel::StepsAsk(process, number, ask.clone());
                        self.post(PLACES[at], PLACES[1 - at], parcel, self.network.bus_loss);
                        let late = Parcel::Steps(process, number, None);
                        self.put(self.now + ANSWER_NS, PLACES[at], late);
                    }
                    Ok(None) => {}
                    Err(e) => self.standby_fails(at, &e),
                }
                self.contends(at, standing);
            }
        }
        self.ask_voters(at, questions);
    }

    /// A station that cannot write its journal goes on without one, and leaves nothing from which another could go on.
    fn disk_fails(&mut self, at: usize) {
        let host = &mut self.hosts[at];
        if host.disk_is_full() && !host.unwritten && host.disk.length().is_ok_and(|l| l == 0) {
            host.unwritten = true;
            self.note("journal not writable");
        }
    }

    fn ask_voters(&mut self, at: usize, questions: Vec<Question>) {
        if !questions.is_empty() {
            self.event(Event::Candidacy);
        }
        for (voter, question) in questions {
            let parcel = || Parcel::Candidacy(PLACES[at], question.clone());
            self.post(PLACES[at], &voter, parcel, self.network.bus_loss);
        }
    }

    fn beat_of(&mut self, at: usize) {
        let now = self.now;
        let host = &mut self.hosts[at];
        let Role::Leads(lead, _) = &host.role else { return };
        if now < host.next_beat {
            return;
        }
        host.next_beat = now + BEAT_NS;
        let (beat, epoch) = (lead.beat(), lead.led().epoch);
        let names: Vec<String> = self.nodes.keys().cloned().collect();
        let loss = self.network.bus_loss;
        for to in &names {
            self.post(PLACES[at], to, || Parcel::Beat(CONDUCTOR.to_owned(), beat.clone()), loss);
        }
        if self.hosts[1 - at].dead {
            return;
        }
        let parcel = || Parcel::Beat(CONDUCTOR.to_owned(), beat.clone());
        self.post(PLACES[at], PLACES[1 - at], parcel, loss);
        if epoch > 0 {
            self.post(PLACES[at], PLACES[1 - at], || Parcel::Leads(epoch), loss);
        }
    }

    fn tell_steps(&mut self, at: usize, token: Token, steps: Steps) {
        if let Some((_, process, number)) = self.hosts[at].steps.take_if(|(of, ..)| *of == token) {
            let parcel = || Parcel::Steps(process, number, Some(steps.clone()));
            self.post(PLACES[at], PLACES[1 - at], parcel, self.network.bus_loss);
        }
    }

    /// It asks for voices, or does so no more.
    fn contends(&mut self, at: usize, standing: Option<(usize, usize)>) {
        let parted = self.parted(PLACES[at], PLACES[1 - at]);
        let stands = standing.is_some_and(|(here, all)| parted && here * 2 <= all);
        self.stands_parted[at] = stands;
        if !parted {
            self.stand_parted = false;
        }
        if self.stands_parted == [true; 2] && !std::mem::replace(&mut self.stand_parted, true) {
            self.note("both stand without a majority");
        }
        if !std::mem::replace(&mut self.hosts[at].contends, standing.is_some())
            && standing.is_some()
        {
            self.note(match self.hosts[at].role {
                Role::Leads(..) => "station asks for voices",
                _ => "standby asks for voices",
            });
        }
    }

    /// The voters gave an epoch to this one.
    fn won(&mut self, at: usize, epoch: u32) {
        if *self.epochs.entry(epoch).or_insert(at) != at {
            self.broken.push(format!("two lead in epoch {epoch}"));
        }
        self.event(Event::Leads);
        let lost = self.nodes.values().any(|node| node.dead);
        let other = &self.hosts[1 - at];
        let (dead, stood) = (other.dead, other.paused_until > self.now);
        let led_on = self.leads_on.take_if(|on| *on == at).is_some();
        self.note(match (led_on, dead, stood) {
            (false, ..) => "station goes on without its standby",
            (true, true, _) if lost => "standby leads: station and a member lost",
            (true, true, _) => "standby leads: station lost",
            (true, _, true) => "standby leads: station stands still",
            (true, ..) => "standby leads: station cut off",
        });
        self.check_knows(at);
    }

    /// The station's process hears, or its standby's.
    pub(super) fn deliver_to_station(&mut self, at: usize, parcel: Parcel) {
        let (now, host) = (self.now, &mut self.hosts[at]);
        // What it sees by itself.
        let own =
            matches!(parcel, Parcel::Steps(_, _, None) | Parcel::Alive(..) | Parcel::Station(_));
        if host.dead || (host.deaf_until > now && !own) {
            return;
        }
        let rests_until = host.paused_until;
        if rests_until > now {
            // What waits for a process that stands still for long is lost with its connection.
            if rests_until <= now + LEASE_NS || own {
                self.put(rests_until, PLACES[at], parcel);
            }
            return;
        }
        let clock = now - host.started;
        match &mut host.role {
            Role::None => {}
            Role::Leads(lead, _) => {
                let time = lead.now(clock);
                match parcel {
                    Parcel::Report(from, report) => lead.tell(time, Input::Report(from, report)),
                    Parcel::Beat(from, beat) if from != CONDUCTOR => {
                        lead.tell(time, Input::Beat(from, beat));
                    }
                    Parcel::Reports(_, fetched) => lead.tell(time, Input::Fetched(fetched)),
                    Parcel::Alive(name, inc, alive) => {
                        lead.tell(time, Input::Alive(name, inc, alive));
                    }
                    Parcel::StepsAsk(process, number, ask) => {
                        host.tokens += 1;
                        host.steps = Some((host.tokens, process, number));
                        lead.asked(time, host.tokens, ask);
                    }
                    Parcel::Voted(name, voted) => {
                        let epoch = lead.led().epoch;
                        lead.voted(time, &name, &voted);
                        let led = lead.led();
                        if led.epoch > epoch {
                            self.won(at, led.epoch);
                        }
                    }
                    Parcel::Leads(epoch) if lead.deposed_by(epoch) => {
                        lead.over();
                        (host.dead, host.role) = (true, Role::None);
                        self.note("station stands down");
                        self.put(now + 8 * MS, PLACES[1 - at], Parcel::Station(false));
                    }
                    Parcel::RepairOf(from, ask) if lead.conductor().passes_on(&ask) => {
                        self.note("PDUs asked for by the station");
                        let RepairOf { of, repair } = ask;
                        let parcel = || Parcel::RepairBy(at, from.clone(), repair.clone());
                        self.post(PLACES[at], &of, parcel, self.network.bus_loss);
                    }
                    Parcel::RepairedFor(to, repaired) => {
                        let by = CONDUCTOR.to_owned();
                        self.reply(PLACES[at], &to, Parcel::Repaired(by, repaired));
                    }
                    Parcel::Fetch(from, ask) => {
                        let fetched = match ask.of == CONDUCTOR {
                            true => Parcel::Orders(lead.fetch_orders(&ask)),
                            false => Parcel::Reports(
                                CONDUCTOR.to_owned(),
                                lead.conductor().fetch_reports(&ask),
                            ),
                        };
                        self.reply(PLACES[at], &from, fetched);
                    }
                    _ => {}
                }
            }
            Role::Follows(follower) => {
                let becomes = match parcel {
                    Parcel::Beat(from, _) if from == CONDUCTOR => {
                        follower.heard(clock);
                        Ok(Becomes::Standby)
                    }
                    Parcel::Station(there) => {
                        follower.connected(there);
                        Ok(Becomes::Standby)
                    }
                    Parcel::Voted(name, voted) => Ok(follower.voted(clock, &name, &voted)),
                    Parcel::Order(order) => Ok(follower.ordered(&order)),
                    Parcel::Steps(process, number, steps) if process == host.started => {
                        let was = follower.is_in();
                        let told = follower.told(clock, number, steps);
                        if follower.is_in() && !was {
                            self.note("standby is in");
                        }
                        told
                    }
                    _ => Ok(Becomes::Standby),
                };
                match becomes {
                    Ok(becomes) => self.become_of(at, becomes),
                    Err(e) => self.standby_fails(at, &e),
                }
            }
        }
    }

    /// A standby that cannot write its copy ends.
    fn standby_fails(&mut self, at: usize, e: &JournalError) {
        if !self.hosts[at].disk_is_full() {
            return self.broken.push(e.to_string());
        }
        self.note("copy of the journal not writable");
        self.hosts[at].dead = true;
        self.put(self.now + 8 * MS, PLACES[1 - at], Parcel::Station(false));
    }

    fn become_of(&mut self, at: usize, becomes: Becomes) {
        if becomes == Becomes::Standby {
            return;
        }
        let host = &mut self.hosts[at];
        let clock = self.now - host.started;
        let Role::Follows(follower) = std::mem::replace(&mut host.role, Role::None) else { return };
        match becomes {
            Becomes::Leader(led) => match follower.lead(led, clock) {
                Ok((lead, log)) => {
                    host.role = Role::Leads(Box::new(lead), log);
                    host.next_beat = self.now;
                    self.leads_on = Some(at);
                    self.won(at, led.epoch);
                    self.hear_who_lives(at);
                }
                Err(e) => self.standby_fails(at, &e),
            },
            Becomes::Refused(why) => {
                host.dead = true;
                if self.hosts[1 - at].disk_is_full() {
                    return self.note("standby of a station without a journal");
                }
                self.broken.push(format!("{} is refused: {why}", PLACES[at]));
            }
            Becomes::Over | Becomes::Standby => host.dead = true,
        }
    }

    /// Who begins to watch hears who lives.
    fn hear_who_lives(&mut self, at: usize) {
        let lives = |(name, node): (&String, &Node)| {
            let here = node.member.as_ref().filter(|_| !node.dead && node.mute_until <= self.now);
            let inc = here.map(Member::inc);
            inc.map(|inc| (name.clone(), inc))
        };
        let lives: Vec<_> = self.nodes.iter().filter_map(lives).collect();
        for (name, inc) in lives {
            if !self.apart(&name, PLACES[at]) {
                self.put(self.now + MS, PLACES[at], Parcel::Alive(name, inc, true));
            }
        }
    }

    pub(super) fn decide(&mut self, at: usize, decisions: Vec<Decision>) {
        let loss = self.network.bus_loss;
        for decision in decisions {
            match decision {
                Decision::Order(order) => self.say(at, &order),
                Decision::Fetch { holder, ask } => {
                    self.note("reports asked for");
                    let parcel = || Parcel::Fetch(PLACES[at].to_owned(), ask.clone());
                    self.post(PLACES[at], &holder, parcel, loss);
                }
                Decision::Record(run, record) => {
                    if let Role::Leads(_, log) = &mut self.hosts[at].role {
                        log.append(run, &record);
                    }
                }
                // What a station decided at last is carried out again by the next one, as nobody knows whether it was.
                Decision::Closed(run) => {
                    if self.closed.last() != Some(&*run) {
                        self.closed.push(*run);
                    }
                }
                Decision::Reached { phase, frame, why } => {
                    let reached = (phase, frame, why.is_some());
                    if self.reached.last() == Some(&reached) {
                        continue;
                    }
                    if matches!(why, Some(Why::Given(_))) {
                        self.note("stood for a move");
                    }
                    self.reached.push(reached);
                    if phase == Phase::Frozen {
                        self.check_frozen(at, frame, why.is_some());
                    }
                }
                Decision::Answer(_, answer) => {
                    if answer.ok && answer.text.starts_with("rate:") {
                        self.note("rate by command");
                    }
                    self.answers.push((answer.ok, answer.text));
                }
                Decision::Exit(code) => self.exit = Some(code),
                Decision::Welcome(token, welcome) => self.welcome(at, token, welcome),
                Decision::State(_) => {}
            }
        }
    }

    /// An order goes to all.
    fn say(&mut self, at: usize, order: &Numbered<Order>) {
        let Some(lead) = self.hosts[at].lead() else { return };
        if let Order::Grant { upto, .. } = order.body
            && lead.conductor().state().rate.is_infinite()
            && upto > lead.conductor().frame() + self.window
            && upto > std::mem::replace(&mut self.granted, upto)
        {
            let frame = lead.conductor().frame();
            self.broken.push(format!("granted {upto} while all stand at {frame}"));
        }
        self.check_said(at, order);
        let event = match &order.body {
            Order::Seal { .. } => Some(Event::Seal),
            Order::Cut { .. } => Some(Event::Cut),
            Order::View { .. } => Some(Event::View),
            Order::Admit { .. } => Some(Event::Admit),
            Order::Finish { .. } => Some(Event::Finish),
            _ => None,
        };
        if let Some(event) = event {
            self.event(event);
        }
        self.note(match &order.body {
            Order::Seal { .. } => "seal",
            Order::Cut { .. } => "cut",
            Order::View { absent, .. } if absent.is_empty() => "view that waits",
            Order::View { .. } => "view that goes on",
            Order::Admit { .. } => "admit",
            Order::Dismiss { .. } => "dismiss",
            Order::Yield { .. } => "place given by command",
            Order::Configure(config) if config.run > 1 => "begun again by command",
            _ => "other orders",
        });
        if let Order::Yield { name, inc, .. } = &order.body {
            self.yielding.insert((name.clone(), *inc));
        }
        let names: Vec<String> = self.nodes.keys().cloned().collect();
        let others = PLACES[1 - at].to_owned();
        let others = Some(others).filter(|_| !self.hosts[1 - at].dead);
        for name in names.into_iter().chain(others) {
            self.post(PLACES[at], &name, || Parcel::Order(order.clone()), self.network.bus_loss);
        }
    }

    /// Nobody says two things; who was followed by another says nothing that this one does not know.
    fn check_said(&mut self, at: usize, order: &Numbered<Order>) {
        if order.seq == 0 {
            return;
        }
        match self.said.get(&order.seq) {
            Some(said) if said == order => return,
            Some(said) => {
                let text = format!("two things are said: {said:?} and {order:?}");
                return self.broken.push(text);
            }
            None => {}
        }
        self.said.insert(order.seq, order.clone());
        let leader = self.leader().filter(|leader| *leader != at);
        let Some(lead) = leader.and_then(|leader| self.hosts[leader].lead()) else { return };
        let (fed, seq) = (order.fed, order.seq);
        let fetch = Fetch { fed, inc: 0, from: seq, to: seq };
        let known = lead.conductor().fetch_orders(&FetchOf { of: CONDUCTOR.to_owned(), fetch });
        if !known.items.contains(order) && known.gone_before <= seq {
            let epoch = lead.led().epoch;
            self.broken.push(format!(
                "{} says something while epoch {epoch} is led: {order:?}",
                PLACES[at]
            ));
        }
    }

    /// One who asked to join is answered.
    fn welcome(&mut self, at: usize, token: Token, welcome: Welcome) {
        let Some((name, instance)) = self.hosts[at].hellos.remove(&token) else { return };
        if instance == STRANGER {
            return match welcome {
                Welcome::Refused(why) if why.contains("version") => {
                    self.note("another build was refused");
                }
                Welcome::Refused(why) if why.contains("another scene") => {
                    self.note("another scene was refused");
                }
                other => self.broken.push(format!("a stranger as {name} is told {other:?}")),
            };
        }
        let now = self.now;
        let waits =
            |node: &&Node| !node.dead && node.instance == instance && node.hello_at.is_some();
        let Some(node) = self.nodes.get(&name).filter(waits) else { return };
        let deaf = node.deaf_until > now || self.silenced(PLACES[at], &name);
        if deaf || self.chance(self.network.bus_loss) {
            return self.note("answers to a hello lost");
        }
        match welcome {
            Welcome::Accepted(mut accepted) => {
                accepted.epoch = self.hosts[at].lead().map_or(0, |lead| lead.led().epoch);
                self.accepted(at, &name, &accepted);
            }
            Welcome::Later(_) => self.hello_later(&name),
            Welcome::NameTaken => self.note("refused"),
            Welcome::Refused(why) if why.contains(DONE_WITHOUT) => self.leaves(&name, LEFT_OUT),
            Welcome::Refused(why) => {
                // Another process of that name lives, as far as the conductor knows: later perhaps not.
                self.note("refused");
                if !why.contains("already running") {
                    self.broken.push(format!("{name} was refused: {why}"));
                }
            }
        }
    }

    /// A process asks to join there.
    pub(super) fn hello(&mut self, at: usize, hello: Hello) {
        let host = &mut self.hosts[at];
        let clock = self.now - host.started;
        let Role::Leads(lead, _) = &mut host.role else { return };
        host.tokens += 1;
        host.hellos.insert(host.tokens, (hello.name.clone(), hello.instance));
        lead.tell(lead.now(clock), Input::Hello(hello, host.tokens));
    }

    /// An operator's command to whoever leads.
    pub(super) fn command(&mut self, command: &Command) {
        let Some(at) = self.leader().filter(|at| self.works(*at)) else {
            return self.note("commands to no station");
        };
        let host = &mut self.hosts[at];
        let clock = self.now - host.started;
        if let Role::Leads(lead, _) = &mut host.role {
            lead.tell(lead.now(clock), Input::Command(command.clone(), 9));
        }
    }

    /// By command all stand at exactly this frame, by a fault all consumers where nothing is left out.
    fn check_frozen(&mut self, at: usize, frame: Frame, by_fault: bool) {
        let Some(lead) = self.hosts[at].lead() else { return };
        let conductor = lead.conductor();
        if lead.beat().last_seq != conductor.own_beat().last_seq {
            // It knows more by now than it may say: how it stood then is not known here.
            return;
        }
        let stand = if by_fault { conductor.stand() } else { frame };
        let state = conductor.state();
        for (name, node) in &self.nodes {
            let Some(member) = node.member.as_ref().filter(|_| !node.dead) else { continue };
            let alive = state.members.iter().any(|m| m.name == *name && m.alive);
            let counts = alive && (!by_fault || member.federate().consumes());
            let at = member.executed();
            // In a closed loop some may be ahead of him who closes it, and some do not read him.
            let most = match by_fault {
                true => conductor.stand_of(|p| member.federate().ahead_of(p)),
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
