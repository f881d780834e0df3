//! Aircraft that other programs hand over, between whoever lets the asks in (the member `visitors`), the traffic generators and whoever
//! replays a run: what is asked in words, whether it may be, and what it is to the core.
//!
//! An ask stands in the frame end of `visitors` as what is done at the seat [`SEAT`], and takes effect [`driven::delay_frames`] later. So
//! it is logged and said again with `--inputs` as all other inputs are. Places and speeds are whole millimetres, times whole nanoseconds:
//! what is written down and read back is the same bits.

use super::driven;
use crate::runtime::messages::{Frame, HANDOVER_SEAT, SeatAction, SeatInput, SeatOrder};
use geodesy::{Enu, Geodetic, LocalFrame};
use models::frames::Vector3;
use models::traffic::core::{Ask, Given};
use scenarios::schedule::Behaving;
use scenarios::types::TypeTable;
use scenarios::{Entity, Scene};
use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::str::FromStr;
use std::sync::Arc;

/// Name of the seat at which aircraft are handed over.
pub const SEAT: &str = HANDOVER_SEAT;

/// Longest call sign: that of a transponder.
const CALLSIGN: usize = 8;
/// Farther than this from the airport nobody is given, m; faster, m/s.
const FARTHEST_M: f64 = 100_000.0;
const FASTEST_MPS: f64 = 1000.0;
/// Oldest state that is let in, ns.
const OLDEST_NS: i64 = 2_000_000_000;

/// How many aircraft may be given in a run of a scene.
#[must_use]
pub fn places(scene: &Scene) -> usize {
    scene.traffic.behaving.as_ref().map_or(0, |b| b.places.len())
}

/// Whether this entity of the scene is a place for one who is given.
#[must_use]
pub fn is_place(scene: &Scene, entity: usize) -> bool {
    scene.traffic.behaving.as_ref().is_some_and(|b| {
        let first = b.first_entity + b.flights.len() + b.vehicles.len();
        (first..first + b.places.len()).contains(&entity)
    })
}

/// When a state is, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// So long before it was said.
    Age(i64),
    /// UTC of the host where it was let in.
    Utc(i64),
    /// Time of the run.
    Run(i64),
}

/// The state of an aircraft as its giver has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Words {
    /// Type designator.
    pub designator: String,
    /// 24-bit address.
    pub address: Option<u32>,
    /// Name of a runway end.
    pub runway: Option<String>,
    /// Name of a stand, blanks as `_`.
    pub stand: Option<String>,
    /// Middle of it, east, north and up in the airport frame, mm.
    pub at_mm: [i64; 3],
    /// The same of its velocity, mm/s.
    pub velocity_mmps: [i64; 3],
    /// When.
    pub when: When,
}

impl Words {
    /// Of a geodetic state: degrees, height above the ellipsoid, m; velocity east, north and up where it is, m/s. `None`: not an
    /// airport's.
    #[must_use]
    pub fn placed(
        frame: &LocalFrame,
        place: Geodetic,
        velocity_mps: [f64; 3],
    ) -> Option<([i64; 3], [i64; 3])> {
        let ecef = place.to_ecef();
        let Enu { east_m, north_m, up_m } = frame.to_enu(ecef);
        let there = LocalFrame::at_ecef(ecef);
        let velocity = frame.vector_to_enu(there.vector_to_ecef(velocity_mps));
        let milli = |x: f64, most: f64| (x.abs() <= most).then_some((1e3 * x).round() as i64);
        let all = |v: [f64; 3], most: f64| {
            Some([milli(v[0], most)?, milli(v[1], most)?, milli(v[2], most)?])
        };
        Some((all([east_m, north_m, up_m], FARTHEST_M)?, all(velocity, FASTEST_MPS)?))
    }
}

impl Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |t: &Option<String>| t.clone().unwrap_or_else(|| "-".to_owned());
        let address = self.address.map_or_else(|| "-".to_owned(), |a| format!("{a:06x}"));
        write!(f, "{} {address} {} {}", self.designator, text(&self.runway), text(&self.stand))?;
        self.at_mm.iter().chain(&self.velocity_mmps).try_for_each(|x| write!(f, " {x}"))?;
        match self.when {
            When::Age(ns) => write!(f, " age {ns}"),
            When::Utc(ns) => write!(f, " utc {ns}"),
            When::Run(ns) => write!(f, " run {ns}"),
        }
    }
}

impl FromStr for Words {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "give: a state is TYPE ADDRESS|- RUNWAY|- STAND|- EAST NORTH UP (mm) VE VN VU (mm/s) run|age NANOSECONDS".to_owned()
        };
        let words: Vec<&str> = text.split_whitespace().collect();
        let [designator, address, runway, stand, numbers @ .., word, ns] = words.as_slice() else {
            return Err(wrong());
        };
        let numbers: Vec<i64> =
            numbers.iter().map(|n| n.parse()).collect::<Result<_, _>>().map_err(|_| wrong())?;
        let &[e, n, u, ve, vn, vu] = numbers.as_slice() else { return Err(wrong()) };
        let far = |x: &i64| x.unsigned_abs() > (1e3 * FARTHEST_M) as u64;
        let fast = |x: &i64| x.unsigned_abs() > (1e3 * FASTEST_MPS) as u64;
        if [e, n, u].iter().any(far) || [ve, vn, vu].iter().any(fast) {
            return Err("give: farther than 100 km from the airport, or above 1000 m/s".into());
        }
        let ns: i64 = ns.parse().map_err(|_| wrong())?;
        let said = |t: &str| (t != "-").then(|| t.chars().take(32).collect::<String>());
        let address = said(address).map(|a| u32::from_str_radix(&a, 16)).transpose();
        Ok(Self {
            designator: designator.chars().take(8).collect(),
            address: address.map_err(|_| wrong())?,
            runway: said(runway),
            stand: said(stand),
            at_mm: [e, n, u],
            velocity_mmps: [ve, vn, vu],
            when: match *word {
                "age" => When::Age(ns),
                "utc" => When::Utc(ns),
                "run" => When::Run(ns),
                _ => return Err(wrong()),
            },
        })
    }
}

/// What a scene lets be handed over, as the door has it.
#[derive(Debug)]
pub struct Rules {
    behaving: Arc<Behaving>,
    types: TypeTable,
    addresses: BTreeMap<u32, String>,
}

impl Rules {
    /// Of a scene; `None` where nobody can be handed over.
    #[must_use]
    pub fn of(scene: &Scene) -> Option<Self> {
        let behaving = scene.traffic.behaving.clone().filter(|b| !b.places.is_empty())?;
        let named = |e: &Entity| Some((e.address?, e.callsign.to_string()));
        let addresses = scene.traffic.entities.iter().filter_map(named).collect();
        Some(Self { behaving, types: scene.traffic.types.clone(), addresses })
    }

    /// Whether something may be asked; where it is a state, with the time at which it was.
    ///
    /// # Errors
    /// Why not, in a sentence.
    pub fn check(&self, action: &SeatAction, utc_ns: i64) -> Result<SeatAction, String> {
        let named = |callsign: &str| match callsign.len() {
            1..=CALLSIGN
                if callsign.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit()) =>
            {
                Ok(())
            }
            _ => Err(format!("callsign: 1 to {CALLSIGN} upper-case letters and digits")),
        };
        match action {
            SeatAction::Release { callsign } => named(callsign).map(|()| action.clone()),
            SeatAction::Give { callsign, state } => {
                named(callsign)?;
                let mut words: Words = state.parse()?;
                self.given(callsign, &words)?;
                if let When::Age(age_ns) = words.when {
                    if !(-OLDEST_NS..=OLDEST_NS).contains(&age_ns) {
                        return Err("a state may be two seconds old at most".into());
                    }
                    words.when = When::Utc(utc_ns - age_ns);
                }
                Ok(SeatAction::Give { callsign: callsign.clone(), state: words.to_string() })
            }
            _ => Err(format!("at {SEAT} aircraft are handed over: give or release")),
        }
    }

    /// Whether something may be asked as it was in an earlier run: the time of a state is that of the run.
    ///
    /// # Errors
    /// Why not, in a sentence.
    pub fn check_said(&self, action: &SeatAction) -> Result<(), String> {
        if let SeatAction::Give { state, .. } = self.check(action, 0)?
            && !matches!(state.parse::<Words>()?.when, When::Run(_))
        {
            return Err("give: of a state that was, the time is `run NANOSECONDS`".into());
        }
        Ok(())
    }

    fn given(&self, callsign: &str, words: &Words) -> Result<Given, String> {
        let short = |t: &str| t.chars().take(12).collect::<String>();
        let flight = scenarios::handover::flight(
            &self.types,
            self.behaving.wake,
            &words.designator,
            callsign,
        )
        .ok_or_else(|| {
            format!("type {:?} is not an aircraft of types.csv", short(&words.designator))
        })?;
        if let Some(address) = words.address {
            if !(1..=0xff_fffe).contains(&address) {
                return Err("address: six hexadecimal digits, not all 0 or f".into());
            }
            if let Some(other) = self.addresses.get(&address).filter(|o| *o != callsign) {
                return Err(format!("address {address:06x} is that of {other}"));
            }
        }
        let network = &self.behaving.network;
        let runway = words.runway.as_deref().map(|name| {
            scenarios::handover::runway(network, name)
                .ok_or_else(|| format!("there is no runway {:?} here", short(name)))
        });
        let stand = words.stand.as_deref().map(|name| {
            scenarios::handover::stand(network, name)
                .ok_or_else(|| format!("there is no stand {:?} here", short(name)))
        });
        let metres = |v: [i64; 3]| Vector3::new(v[0] as f64, v[1] as f64, v[2] as f64) * 1e-3;
        let (When::Age(ns) | When::Utc(ns) | When::Run(ns)) = words.when;
        Ok(Given {
            flight,
            address: words.address,
            designator: words.designator.clone(),
            runway: runway.transpose()?,
            stand: stand.transpose()?,
            at_m: metres(words.at_mm).into(),
            velocity_mps: metres(words.velocity_mmps),
            time_s: ns as f64 * 1e-9,
        })
    }
}

/// The same with the time of its state in the run; `time_ns`: that of a UTC of the host.
#[must_use]
pub fn timed(action: SeatAction, time_ns: impl Fn(i64) -> i64) -> SeatAction {
    let SeatAction::Give { callsign, state } = action else { return action };
    let state = match state.parse::<Words>() {
        Ok(words @ Words { when: When::Utc(utc_ns), .. }) => {
            Words { when: When::Run(time_ns(utc_ns)), ..words }.to_string()
        }
        _ => state,
    };
    SeatAction::Give { callsign, state }
}

/// What an input is to the core; `None` where nothing is handed over by it.
#[must_use]
pub fn ask(scene: &Scene, order: &SeatOrder) -> Option<Ask> {
    if order.seat != SEAT {
        return None;
    }
    match &order.action {
        SeatAction::Release { callsign } => Some(Ask::Release(callsign.clone())),
        SeatAction::Give { callsign, state } => {
            let given = Rules::of(scene)?.given(callsign, &state.parse().ok()?).ok()?;
            Some(Ask::Give(Box::new(given)))
        }
        _ => None,
    }
}

/// Tells the core what was asked in frame `said`; whether there is anything to tell.
pub fn tell(
    scene: &Scene,
    core: &mut models::traffic::core::Core,
    said: Frame,
    input: &SeatInput,
) -> bool {
    let Some(ask) = ask(scene, &input.order) else { return false };
    core.ask((said + driven::delay_frames(scene)) as i64, SEAT, input.number, ask);
    true
}

/// The entity of one who was given, in its place.
#[must_use]
pub fn entity(scene: &Scene, place: &Entity, given: &Given) -> Entity {
    let class = scene.traffic.types.get(&given.designator).map(|row| row.class.clone());
    Entity {
        callsign: models::plot::Callsign::new(&given.flight.callsign),
        address: given.address,
        class: class.unwrap_or_else(|| place.class.clone()),
        trajectory: None,
        report: None,
        ..place.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// What is written down is read back, and nothing that anybody writes panics.
        #[test]
        fn a_state_in_words_comes_back(
            address in prop::option::of(1_u32..0xff_fffe),
            runway in prop::option::of("[0-3][0-9][LRC]"),
            stand in prop::option::of("[A-Z]_[0-9]{1,3}"),
            at_mm in prop::array::uniform3(-100_000_000_i64..=100_000_000),
            velocity_mmps in prop::array::uniform3(-1_000_000_i64..=1_000_000),
            ns: i64, kind in 0_u8..3, noise in ".{0,60}",
        ) {
            let when = [When::Age(ns), When::Utc(ns), When::Run(ns)][usize::from(kind)];
            let words = Words { designator: "A320".into(), address, runway, stand, at_mm, velocity_mmps, when };
            prop_assert_eq!(words.to_string().parse::<Words>(), Ok(words.clone()));
            let said = words.to_string();
            let cut = noise.len() % said.len();
            let _ = format!("{}{noise}", &said[..cut]).parse::<Words>();
            let action = SeatAction::Give { callsign: "A1".into(), state: noise };
            let _ = timed(action, |ns| ns);
        }
    }
}
