//! *What if* for people at seats: the airport as it is seen, flown ahead beside the run.
//!
//! A question is an input like any other, so the moment that it is asked of is the same in every run of the same inputs. The
//! answer is worked out in a thread of its own, and only shown: no frame waits for it, and nothing of the run depends on it.

use models::control::advice::Picture;
use models::traffic::ahead::{
    AHEAD_S, Airport, Answer, Change, Day, Direction, Flight, MEASURES, Moment, perceive,
};
use models::traffic::network::Network;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, OnceLock};

/// Questions that may be asked within a minute of simulated time; more are refused.
const A_MINUTE: usize = 12;
/// Questions that wait to be worked out; the oldest of more are not.
const WAITING: usize = 8;
/// Answers that are shown.
const SHOWN: usize = 4;

/// A question.
#[derive(Debug)]
struct Question {
    person: String,
    callsign: String,
    words: String,
    change: Change,
    moment: Moment,
}

/// Where an answer comes from.
type Answering = Receiver<Result<Answer, String>>;

/// The airport that is looked ahead on, and what was asked.
#[derive(Debug)]
pub(super) struct LookAhead {
    network: Arc<Network>,
    flights: Arc<Vec<Flight>>,
    /// Whether control is told tracks, without which nobody is seen.
    on_tracks: bool,
    /// Made when it is needed first.
    airport: Arc<OnceLock<Airport>>,
    seed: u64,
    /// The weather that was told last.
    pub(super) day: Day,
    /// When the last ones were asked, s of the run.
    times_s: VecDeque<f64>,
    waiting: VecDeque<Arc<Question>>,
    /// What is worked out.
    at_work: Option<(Arc<Question>, Answering)>,
    shown: VecDeque<Value>,
}

impl LookAhead {
    /// Nobody has asked anything.
    pub(super) fn new(
        network: Arc<Network>,
        flights: Arc<Vec<Flight>>,
        seed: u64,
        on_tracks: bool,
    ) -> Self {
        Self {
            network,
            flights,
            on_tracks,
            airport: Arc::default(),
            seed,
            day: Day::default(),
            times_s: VecDeque::new(),
            waiting: VecDeque::new(),
            at_work: None,
            shown: VecDeque::new(),
        }
    }

    /// Takes a question; words for its person. What is refused depends on the run only, never on how long answers take:
    /// refusals are part of the run.
    ///
    /// # Errors
    /// Why not, in words.
    pub(super) fn ask(
        &mut self,
        person: &str,
        (callsign, words): (&str, &str),
        picture: &Picture<'_>,
    ) -> Result<String, String> {
        if !self.on_tracks {
            return Err("nobody is seen in this scene: it needs [control] sees = \"tracks\", controllers = \"model\"".to_owned());
        }
        let of = |f: &Flight| f.callsign == callsign;
        let flight = self.flights.iter().position(of);
        let flight = flight.ok_or_else(|| format!("there is no flight {callsign:?}"))?;
        let change = self.change(flight as u32, words)?;
        let mut moment =
            perceive(picture.known, &self.network, &self.flights, picture.frame, self.seed);
        moment.day = self.day;
        moment
            .can(&self.network, &self.flights, change)
            .map_err(|why| format!("{callsign} {why}"))?;
        let now_s = moment.now_s();
        self.times_s.retain(|s| now_s - *s < 60.0);
        if self.times_s.len() >= A_MINUTE {
            return Err(format!("{A_MINUTE} questions a minute are answered: ask again later"));
        }
        self.times_s.push_back(now_s);
        let question = Question {
            person: person.to_owned(),
            callsign: callsign.to_owned(),
            words: words.to_owned(),
            change,
            moment,
        };
        self.waiting.push_back(Arc::new(question));
        while self.waiting.len() > WAITING {
            if let Some(oldest) = self.waiting.pop_front() {
                self.answered(
                    &oldest,
                    json!({ "refused": "was not worked out: others came faster" }),
                );
            }
        }
        self.go_on();
        Ok(format!("{callsign}: what if {words}? is worked out"))
    }

    /// What words say is done otherwise.
    fn change(&self, flight: u32, words: &str) -> Result<Change, String> {
        let (kind, value) = words.trim().split_once(' ').unwrap_or((words, ""));
        let value = value.trim();
        let named = |all: &[String; 2]| all.iter().position(|n| n == value);
        match kind {
            "HOLD" => match value.parse() {
                Ok(for_s) => Ok(Change::Hold { flight, for_s }),
                Err(_) => Err(format!("HOLD {value:?}: give seconds, like \"HOLD 120\"")),
            },
            "STAND" => {
                let stand = self.network.stands.iter().position(|s| s.name == value);
                let stand = stand.ok_or_else(|| format!("there is no stand {value:?}"))?;
                Ok(Change::Stand { flight, stand })
            }
            "RUNWAY" => {
                let runways = self.network.runways.iter().enumerate();
                let found =
                    runways.filter_map(|(r, runway)| Some((r, named(&runway.names)?))).next();
                let runway = found.ok_or_else(|| format!("there is no runway {value:?}"))?;
                Ok(Change::Runway { flight, runway })
            }
            other => Err(format!(
                "there is no change {other:?}: \"HOLD 120\", \"STAND A12\" or \"RUNWAY 28\""
            )),
        }
    }

    /// What was answered last, and what is worked out (JSON).
    pub(super) fn told(&mut self) -> Vec<Value> {
        self.go_on();
        let open = self.at_work.iter().map(|w| &w.0).chain(&self.waiting);
        let open = open.map(|question| head(question, Value::Null));
        self.shown.iter().cloned().chain(open).collect()
    }

    /// Takes what has been answered, and begins to work out the next.
    fn go_on(&mut self) {
        if let Some((question, answer)) = self.at_work.take() {
            let told = match answer.try_recv() {
                Ok(Ok(answer)) => self.words(&answer),
                Ok(Err(why)) => json!({ "refused": why }),
                Err(TryRecvError::Empty) => {
                    self.at_work = Some((question, answer));
                    return;
                }
                Err(TryRecvError::Disconnected) => {
                    json!({ "refused": "could not be worked out: its thread ended" })
                }
            };
            self.answered(&question, told);
        }
        let Some(question) = self.waiting.pop_front() else { return };
        let (send, answer) = channel();
        let (network, flights) = (Arc::clone(&self.network), Arc::clone(&self.flights));
        let (airport, asked) = (Arc::clone(&self.airport), Arc::clone(&question));
        let work = move || {
            let airport = airport.get_or_init(|| Airport::new(network, flights));
            // Whoever asked may be gone: then nobody hears it.
            let _ = send.send(asked.moment.what_if(airport, asked.change));
        };
        match std::thread::Builder::new().name("what-if".into()).spawn(work) {
            Ok(_) => self.at_work = Some((question, answer)),
            Err(e) => {
                let why = format!("could not be worked out: no thread ({e})");
                self.answered(&question, json!({ "refused": why }));
            }
        }
    }

    fn answered(&mut self, question: &Question, answer: Value) {
        if self.shown.len() >= SHOWN {
            self.shown.pop_front();
        }
        self.shown.push_back(head(question, answer));
    }

    fn words(&self, answer: &Answer) -> Value {
        let name = |m: usize| self.flights.get(m).map_or("", |f| f.callsign.as_str());
        let names =
            |all: &[u32]| all.iter().map(|m| name(*m as usize).to_owned()).collect::<Vec<_>>();
        let round = |x: f64| (10.0 * x).round() / 10.0;
        let both = answer.without.measures.iter().zip(&answer.with.measures);
        let measures: Vec<Value> = MEASURES
            .iter()
            .zip(both)
            .map(|((key, words, unit), (without, with))| {
                json!({
                    "key": key, "words": words, "unit": unit, "without": round(*without), "with": round(*with),
                })
            })
            .collect();
        let end = |m: usize| match self.flights.get(m).map(|f| f.direction) {
            Some(Direction::Departure) => "take-off",
            _ => "in-block",
        };
        let moved: Vec<Value> = answer
            .moved()
            .map(|(m, without, with)| {
                json!({
                    "callsign": name(m), "end": end(m), "without_s": without.map(round), "with_s": with.map(round),
                })
            })
            .collect();
        json!({
            "ahead_s": AHEAD_S, "measures": measures, "flights": moved, "left_out": names(&answer.left_out),
            "unseen": names(&answer.unseen),
        })
    }
}

/// A question with its answer, or with none yet.
fn head(question: &Question, answer: Value) -> Value {
    json!({
        "person": question.person, "callsign": question.callsign, "change": question.words,
        "at_s": question.moment.now_s(), "answer": answer,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::control::clearance::Board;
    use models::control::layout::Layout;
    use models::control::parameters::Parameters;
    use models::control::safety_net::SafetyNet;
    use models::traffic::ahead::Known;
    use std::path::Path;
    use std::time::Duration;

    #[test]
    fn questions_are_answered_beside_the_run_and_what_cannot_be_asked_is_told_at_once() {
        let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
        let text = format!(
            "[run]\ntitle = \"t\"\nseed = 3\nduration_s = 2400\n[airport]\nlayout = \"{airports}/XSYN.apt.dat\"\n\
             [[traffic]]\nkind = \"generated\"\narrivals_per_h = 10\ndepartures_per_h = 10\n"
        );
        let scene = scenarios::load_text(Path::new("look.toml"), &text).expect("a scene");
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let (network, flights) = (&behaving.network, &behaving.flights);
        let layout = Layout::of(&scene.airport.layout).with_network(network);
        let net = SafetyNet::new(layout, Parameters::default());
        let board = Board::default();
        let known = Known { board: &board, surveillance: net.surveillance(), layout: net.layout() };
        let picture =
            Picture { known, network, flights, waiting: &[], frame: (2000, scene.run.frame.s()) };
        let mut look = LookAhead::new(Arc::clone(network), Arc::clone(flights), 3, true);
        let departs = |f: &&Flight| f.direction == Direction::Departure;
        let callsign = flights.iter().find(departs).expect("a departure").callsign.clone();
        let mut ask = |callsign: &str, change: &str| look.ask("anna", (callsign, change), &picture);
        for (who, change, why) in [
            ("NOBODY", "HOLD 60", "there is no flight \"NOBODY\""),
            (&callsign, "HOLD", "give seconds"),
            (&callsign, "HOLD -3", "0 to 900 s"),
            (&callsign, "HOLD nan", "0 to 900 s"),
            (&callsign, "STAND moon", "there is no stand \"moon\""),
            (&callsign, "RUNWAY 99", "there is no runway \"99\""),
            (&callsign, "FLY 1", "there is no change \"FLY\""),
            (&callsign, "", "there is no change"),
        ] {
            let text = ask(who, change).expect_err(change);
            assert!(text.contains(why), "{text}");
        }
        assert!(ask(&callsign, "HOLD 300").is_ok() && ask(&callsign, "HOLD 0").is_ok());
        let wait = |look: &mut LookAhead| {
            for _ in 0..6000 {
                if look.told().iter().all(|t| !t["answer"].is_null()) {
                    return;
                }
                std::thread::sleep(Duration::from_millis(10));
            }
            panic!("no answer: {:?}", look.told());
        };
        wait(&mut look);
        let told = look.told();
        assert_eq!(told.len(), 2, "{told:?}");
        let of = |change: &str| told.iter().find(|t| t["change"] == change).expect("answered");
        let held = of("HOLD 300");
        assert_eq!(held["answer"]["flights"][0]["callsign"], callsign.as_str(), "{held}");
        assert_eq!(held["answer"]["measures"].as_array().map(Vec::len), Some(MEASURES.len()));
        assert_eq!(of("HOLD 0")["answer"]["flights"].as_array().map(Vec::len), Some(0));
        // However fast they come, they are taken; only their number in a minute of the run counts.
        let left = A_MINUTE - 2;
        for n in 0..left {
            assert!(look.ask("anna", (&callsign, &format!("HOLD {n}")), &picture).is_ok());
        }
        let text = look.ask("anna", (&callsign, "HOLD 7"), &picture).expect_err("too many");
        assert!(text.contains("a minute"), "{text}");
        let later = Picture { frame: (2000 + 61 * 20, 0.05), ..picture };
        assert!(look.ask("anna", (&callsign, "HOLD 7"), &later).is_ok());
        wait(&mut look);
        let told = look.told();
        assert_eq!(told.len(), SHOWN);
        assert!(told.iter().any(|t| t["change"] == "HOLD 7" && t["answer"]["flights"].is_array()));
    }
}
