//! `[control]` and `[[failure]]`: who controls on what, and what goes wrong. What a scene of traffic that behaves is
//! watched by where it names no sensors.

use crate::airport::AirportScene;
use crate::document::{Section, one_of, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use models::airport::Airport;
use models::sensors::mlat::MAX_STATIONS;
use models::traffic::core::{Failure, FailureKind, Flight, Policy};
use std::path::Path;

/// What the functions of control read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sees {
    /// There is no control: everything is cleared as the plan says.
    #[default]
    Nothing,
    /// Exact truth: controllers know of the traffic what its core knows.
    Truth,
    /// System tracks: there is a federate `control`.
    Tracks,
}

/// Categories of wake that aircraft are separated by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Separation {
    /// Of ICAO.
    #[default]
    Icao,
    /// RECAT-EU.
    RecatEu,
}

/// Whose a controller's seat is, until somebody takes or leaves it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HumanSeats {
    /// Push-backs are a person's.
    pub apron: bool,
    /// Taxiing is a person's.
    pub ground: bool,
    /// All towers are persons'.
    pub tower: bool,
    /// The model takes an empty one after a while.
    pub fallback: bool,
}

impl HumanSeats {
    /// Whether any seat is a person's.
    #[must_use]
    pub fn any(self) -> bool {
        self.apron || self.ground || self.tower
    }
}

/// `[control]` of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlScene {
    /// What control reads.
    pub sees: Sees,
    /// Models of controllers clear, not the plan.
    pub controllers: bool,
    /// Which piece may be taken.
    pub policy: Policy,
    /// Stop bars are in use.
    pub stop_bars: bool,
    /// Lamps of the taxiways show each flight its way.
    pub greens: bool,
    /// Departures leave their stands by the best sequence of take-offs within so many places; `None`: first come.
    pub shift: Option<usize>,
    /// Categories of wake that aircraft are separated by.
    pub wake: Separation,
    /// Seats that are persons'.
    pub seats: HumanSeats,
    /// Controllers are advised.
    pub advice: bool,
    /// People may take flights that taxi.
    pub by_hand: bool,
    /// Scans in a row before an alert is raised.
    pub confirm_scans: u32,
    /// Off the hold distance, m.
    pub strip_margin_m: f64,
    /// The nose counts as over a bar so far behind it, m.
    pub bar_margin_m: f64,
    /// Errors of pilots, in multiples of what is assumed; 0: none.
    pub errors: f64,
}

/// Reads `[control]`.
pub(crate) fn read(root: &Section) -> Result<ControlScene, ScenarioError> {
    let section =
        root.section("control", &words(keys::CONTROL))?.unwrap_or_else(|| root.empty("control"));
    let sees = [("none", Sees::Nothing), ("truth", Sees::Truth), ("tracks", Sees::Tracks)];
    let policies =
        [("planned", Policy::Planned), ("ordered", Policy::Ordered), ("free", Policy::Free)];
    let sees = section.choice("sees", &sees)?.unwrap_or_default();
    let who = section.choice("controllers", &[("plan", false), ("model", true)])?;
    let controllers = who.unwrap_or(sees == Sees::Truth);
    let fits = match sees {
        Sees::Nothing => !controllers,
        Sees::Truth => controllers,
        Sees::Tracks => true,
    };
    if !fits {
        let found = if controllers { "model" } else { "plan" };
        let allowed = match sees {
            Sees::Truth => "\"model\": with sees = \"truth\" controllers clear",
            _ => "\"plan\": controllers need something to see, sees = \"truth\" or \"tracks\"",
        };
        let problem = Problem::NotAllowed { found: found.into(), allowed: allowed.into() };
        return Err(section.refuse("controllers", problem));
    }
    let advice = section.flag("advice")?.unwrap_or(false);
    if advice && !controllers {
        let problem = Problem::NotAllowed {
            found: "true".into(),
            allowed: "false where the plan clears: advice is for controllers, sees = \"truth\" or controllers = \"model\""
                .into(),
        };
        return Err(section.refuse("advice", problem));
    }
    let seats = human_seats(&section, controllers)?;
    let cps = section.choice("sequence", &[("first", false), ("cps", true)])?.unwrap_or(false);
    let shift = section.integer("shift", 0, 4)?.unwrap_or(2) as usize;
    let wakes = [("icao", Separation::Icao), ("recat-eu", Separation::RecatEu)];
    Ok(ControlScene {
        sees,
        greens: section.flag("greens")?.unwrap_or(false),
        shift: cps.then_some(shift),
        wake: section.choice("wake", &wakes)?.unwrap_or_default(),
        seats,
        advice,
        by_hand: section.flag("by_hand")?.unwrap_or(false),
        controllers,
        policy: section.choice("policy", &policies)?.unwrap_or_default(),
        stop_bars: section.flag("stop_bars")?.unwrap_or(false),
        confirm_scans: section.integer("confirm_scans", 1, 10)?.unwrap_or(1) as u32,
        strip_margin_m: section.number_or("strip_margin_m", 7.5, within(0.0, 50.0, "m"))?,
        errors: section.number_or("errors", 0.0, within(0.0, 1e5, ""))?,
        bar_margin_m: section.number_or("bar_margin_m", 0.0, within(0.0, 20.0, "m"))?,
    })
}

/// Reads `seats` and `fallback`: there are seats only where models of controllers clear.
fn human_seats(control: &Section, controllers: bool) -> Result<HumanSeats, ScenarioError> {
    let mut seats = HumanSeats {
        fallback: control.flag("fallback")?.unwrap_or(false),
        ..HumanSeats::default()
    };
    let Some(section) = control.section("seats", &words(keys::SEATS))? else { return Ok(seats) };
    for (key, human) in
        [("apron", &mut seats.apron), ("ground", &mut seats.ground), ("tower", &mut seats.tower)]
    {
        *human = section.choice(key, &[("model", false), ("human", true)])?.unwrap_or(false);
        if *human && !controllers {
            let problem = Problem::NotAllowed {
                found: "human".into(),
                allowed: "\"model\" where the plan clears: people sit where sees = \"truth\" or controllers = \"model\"".into(),
            };
            return Err(section.refuse(key, problem));
        }
    }
    Ok(seats)
}

/// Clearances that a controller may give against another.
const CLEARANCES: [(&str, &str); 5] =
    [("CRO", "CRO"), ("ENT", "ENT"), ("LUP", "LUP"), ("TOF", "TOF"), ("LND", "LND")];

/// How long a failure stays where the scene does not say, s (assumed).
fn usual_stay_s(kind: FailureKind) -> f64 {
    match kind {
        FailureKind::StopBar => 1800.0,
        FailureKind::Transponder => 600.0,
        _ => 60.0,
    }
}

/// Reads `[[failure]]`.
pub(crate) fn read_failures(
    root: &Section,
    flights: &[Flight],
    stop_bars: bool,
) -> Result<Vec<Failure>, ScenarioError> {
    let mut failures: Vec<Failure> = Vec::new();
    for section in root.sections("failure", &words(keys::FAILURE))? {
        let kind = section.choice("kind", &FailureKind::WORDS)?;
        let kind = kind
            .ok_or_else(|| section.missing("kind", "what goes wrong, like \"pass_hold\"".into()))?;
        if kind == FailureKind::StopBar && !stop_bars {
            let problem = Problem::NotAllowed {
                found: kind.word().into(),
                allowed: "stop bars in use: [control] stop_bars = true".into(),
            };
            return Err(section.refuse("kind", problem));
        }
        let callsign =
            section.need_text("callsign", "the call sign of a flight of the schedule")?;
        let Some(flight) = flights.iter().position(|f| f.callsign == callsign) else {
            let known: Vec<&str> = flights.iter().map(|f| f.callsign.as_str()).collect();
            let allowed = one_of(callsign, &known);
            return Err(
                section.refuse("callsign", Problem::NotAllowed { found: callsign.into(), allowed })
            );
        };
        let seconds = |key, default| section.number_or(key, default, within(0.0, 86_400.0, "s"));
        let number = failures.iter().filter(|f| f.kind == FailureKind::VehicleOnRunway).count() + 1;
        failures.push(Failure {
            id: section
                .text("id")?
                .map_or_else(|| format!("{}-{}", kind.word(), failures.len() + 1), str::to_owned),
            kind,
            flight,
            at_s: seconds("at_s", 0.0)?,
            stay_s: seconds("stay_s", usual_stay_s(kind))?,
            lead_s: seconds("lead_s", 45.0)?,
            clearance: section.choice("clearance", &CLEARANCES)?.unwrap_or("CRO"),
            lamps_lit: section.choice("lamps", &[("dark", false), ("lit", true)])?.unwrap_or(false),
            vehicle: format!("CAR{number}"),
        });
    }
    Ok(failures)
}

/// What watches an airport whose scene names no sensors (assumed): a radar on the tower, 60 m high, and
/// multilateration from eight stations around the ground network and one under each final; the profile `accurate`.
pub(crate) fn standard(path: &Path, airport: &AirportScene) -> Result<Section, ScenarioError> {
    let text = standard_sensors(&airport.layout, airport.radius_m);
    Section::parse(path, &format!("{text}[tracking]\nprofile = \"accurate\"\n"))
}

/// Least and greatest east and north of the ground network, m; of the runways where there is none.
#[must_use]
pub fn extent_m(layout: &Airport) -> [[f64; 2]; 2] {
    let ends = layout.runways.iter().flat_map(|r| r.ends_m);
    let mut places: Vec<_> = layout.nodes.iter().map(|node| node.position_m).collect();
    if places.is_empty() {
        places = ends.collect();
    }
    let of = |least: fn(f64, f64) -> f64| {
        let both = places.iter().map(|at| [at.x, at.y]);
        both.reduce(|a, b| [least(a[0], b[0]), least(a[1], b[1])]).unwrap_or_default()
    };
    [of(f64::min), of(f64::max)]
}

/// The `[[sensor]]` tables of a scene that names none: `ASDE tower` and `MLAT`. No station farther than `radius_m`.
#[must_use]
pub fn standard_sensors(layout: &Airport, radius_m: f64) -> String {
    let tower = layout.tower.map_or([0.0, 0.0], |(at, _)| [at.x, at.y]);
    radar_at("ASDE tower", tower, 60.0) + &multilateration("MLAT", layout, radius_m)
}

/// The `[[sensor]]` table of a radar like the standard one, mirrored about the middle of the ground network from where the first
/// radar is, on a mast of 40 m (assumed): what a second site would be.
#[must_use]
pub fn second_radar(name: &str, layout: &Airport, first_m: [f64; 2]) -> String {
    let [low, high] = extent_m(layout);
    radar_at(name, [0, 1].map(|axis| low[axis] + high[axis] - first_m[axis]), 40.0)
}

fn radar_at(name: &str, at_m: [f64; 2], height_m: f64) -> String {
    let [east, north] = at_m;
    format!(
        "[[sensor]]\nkind = \"asde\"\nname = \"{name}\"\nparameters = \"ku_asde3\"\n\
         site = {{ east_m = {east:.1}, north_m = {north:.1}, height_m = {height_m:.1} }}\n"
    )
}

/// From the threshold to the station under the final, m: 50 s of flight at 70 m/s, so that an arrival has a track when the
/// alerts that look 30 s ahead are due (assumed).
const UNDER_FINAL_M: f64 = 3500.0;

/// The `[[sensor]]` table of multilateration by eight stations around the ground network and one under the final to each end of a
/// runway (assumed). Under finals that reach beyond `radius_m` from the reference point there is none.
///
/// The ring alone sees arrivals late: outside it the dilution grows with the square of the distance.
#[must_use]
pub fn multilateration(name: &str, layout: &Airport, radius_m: f64) -> String {
    let [low, high] = extent_m(layout);
    let middle = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
    let mut places = vec![
        [low[0], low[1]],
        [middle[0], low[1]],
        [high[0], low[1]],
        [high[0], middle[1]],
        [high[0], high[1]],
        [middle[0], high[1]],
        [low[0], high[1]],
        [low[0], middle[1]],
    ];
    for runway in &layout.runways {
        let [one, other] = runway.thresholds_m;
        for (near, far) in [(one, other), (other, one)] {
            let at = near + UNDER_FINAL_M * (near - far).normalize();
            if at.coords.norm() < radius_m {
                places.push([at.x, at.y]);
            }
        }
    }
    places.truncate(MAX_STATIONS);
    let stations: Vec<String> = places
        .iter()
        .map(|[east, north]| format!("{{ east_m = {east:.1}, north_m = {north:.1} }}"))
        .collect();
    format!(
        "[[sensor]]\nkind = \"mlat\"\nname = \"{name}\"\noverrides = {{ stations = [{}] }}\n",
        stations.join(", ")
    )
}
