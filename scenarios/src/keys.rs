//! The tables of a scene as data: every key with its kind, unit, limits, default and a line of text.
//!
//! The reader refuses keys that are not here; reference ([`reference`](crate::reference)), schema and the law that every
//! limit is the reader's own are made of these tables. Keys of sensors stand with the sensors ([`models::sensors::KINDS`]).

use models::environment::surface::MATERIALS;
use models::filter::Rung;
use models::keys::{Holds, Key, PLACE};
use models::sensors::KINDS;
use models::traffic::core::FailureKind;

/// Most vehicles of one type in a demand.
pub(crate) const MOST_VEHICLES: i64 = 200;

/// A table of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Table {
    /// Its name.
    pub word: &'static str,
    /// Whether there may be several (`[[word]]`).
    pub many: bool,
    /// Whether it has to be there.
    pub needed: bool,
    /// What it says.
    pub doc: &'static str,
    /// Its keys.
    pub keys: &'static [Key],
}

const fn one(word: &'static str, keys: &'static [Key], doc: &'static str) -> Table {
    Table { word, many: false, needed: false, doc, keys }
}

const fn many(word: &'static str, keys: &'static [Key], doc: &'static str) -> Table {
    Table { word, many: true, needed: false, doc, keys }
}

/// All tables, in the order in which a scene is written.
pub const TABLES: &[Table] = &[
    Table { needed: true, ..one("run", RUN, "When, how long, and in which steps") },
    Table { needed: true, ..one("airport", AIRPORT, "Where: runways, taxiways, stands") },
    many("traffic", TRAFFIC, "Who moves: one mover each, a schedule, or rates of flights"),
    one("weather", WEATHER, "What the weather is from when on; clear and dry without it"),
    many("building", BUILDING, "What shadows and mirrors targets"),
    many(
        "board",
        BOARD,
        "Square plates that are turned to the eye, by which the light of its view is measured; sensors do not see them",
    ),
    many("sensor", SENSOR, "Who looks on; the keys of `overrides` are listed by kind below"),
    one("tracking", TRACKING, "How plots become tracks; without a key the profile's value holds"),
    one(
        "accuracy",
        ACCURACY,
        "What may be lost against everything simulated exactly, on the same draws",
    ),
    one("network", NETWORK, "Where PDUs and grants go; the command line goes before it"),
    one("external", EXTERNAL, "What a gateway sends and hears; each flag goes before its key"),
    one("control", CONTROL, "Who clears the flights that react to each other"),
    many("failure", FAILURE, "What goes wrong with flights of a schedule, or with who clears them"),
    many("shape", SHAPE, "Echo of a size of target, in place of one of the same name that ships"),
];

/// Keys at the root of a scene, which are not tables.
pub const ROOT: &[Key] =
    &[Key::new("shapes", Holds::File, "A file of [[shape]] that go before those that ship")];

/// The words of a table's keys.
#[must_use]
pub fn words(keys: &'static [Key]) -> Vec<&'static str> {
    keys.iter().map(|key| key.word).collect()
}

/// The words of some keys beside those of a place.
#[must_use]
pub fn place_words() -> Vec<&'static str> {
    words(PLACE)
}

pub(crate) const RUN: &[Key] = &[
    Key::text("title", "One line for people").needed(),
    Key::whole("seed", 0, i64::MAX, "Seed of every draw").or("1"),
    Key::new(
        "start",
        Holds::Time,
        "Start, like 2019-11-24T09:00:00Z; a schedule that says it itself goes without",
    )
    .needed(),
    Key::number("duration_s", "s", 1.0, 86_400.0, "Length of the run").needed(),
    Key::whole("exercise", 0, 255, "Exercise identifier of DIS").or("1"),
    Key::whole("site", 1, 65_534, "Site number of DIS; visitors use others").or("1"),
    Key::whole(
        "targets_max",
        1,
        1_000_000,
        "Targets at a time: the scene's own, and visitors in what these leave",
    )
    .or("the scene's own and 4096 visitors"),
    Key::number("frame_s", "s", 0.001, 1.0, "Length of a frame").or("0.05"),
    Key::number("scan_s", "s", 0.01, 60.0, "Length of a scan: a whole number of frames").or("1"),
    Key::new(
        "dead_reckoning",
        Holds::Table(DEAD_RECKONING),
        "How states are extrapolated between PDUs",
    ),
    Key::new("heartbeat", Holds::Table(HEARTBEAT), "Longest time between two PDUs of a mover"),
];

pub(crate) const DEAD_RECKONING: &[Key] = &[
    Key::word(
        "algorithm",
        || vec!["fpw", "rpw", "rvw", "fvw"],
        "Model of DIS: fixed or rotating, by velocity or with acceleration",
    )
    .or("rvw"),
    Key::number(
        "position_m",
        "m",
        0.001,
        1000.0,
        "Distance between truth and extrapolation that calls for a PDU",
    )
    .or("1"),
    Key::number("orientation_deg", "deg", 0.01, 180.0, "Angle between them that does").or("3"),
];

pub(crate) const HEARTBEAT: &[Key] = &[
    Key::number("moving_s", "s", 0.1, 60.0, "Of a mover under way").or("5"),
    Key::number("parked_s", "s", 0.1, 600.0, "Of one that stands").or("60"),
];

pub(crate) const AIRPORT: &[Key] = &[
    Key::text("icao", "Location indicator, which has to be that of the file"),
    Key::new(
        "layout",
        Holds::File,
        "Layout: apt.dat, ground network (.xml), nodes.csv, or OpenStreetMap (.json, .geojson)",
    )
    .needed(),
    Key::new("ground_network", Holds::File, "A network that replaces the layout's own"),
    Key::new("overlay", Holds::File, "What the files lack or say wrongly: keys below, *Overlay*"),
    Key::new("reference", Holds::Table(REFERENCE), "Reference point").or("that of the layout"),
    Key::number("radius_m", "m", 500.0, 50_000.0, "Farthest place of a sensor").or("10000"),
    Key::new("tower", Holds::Table(TOWER), "Where a controller looks out")
        .or("the viewpoint of the layout, else 5 m above the highest building"),
    Key::number(
        "taxiway_width_m",
        "m",
        5.0,
        100.0,
        "Width of taxiways of which the layout says none",
    )
    .or("23"),
    Key::flag(
        "mend_crossings",
        "Whether taxiways that cross without a node are joined there; else one is taken for a bridge",
    )
    .or("false"),
];

pub(crate) const TOWER: &[Key] = &[
    Key::new("place", Holds::Place, "Where it stands").needed(),
    Key::number("cab_height_m", "m", 1.0, 300.0, "Height of the eye in its cab above that place")
        .needed(),
];

/// Tables of an overlay of an airport (`[airport] overlay`): a file of its own.
pub const OVERLAY: &[Table] = &[
    many(
        "hold",
        OVERLAY_HOLD,
        "A runway holding position: a node, or a place on a taxiway (as *Places*)",
    ),
    many("edge", OVERLAY_EDGE, "An edge that the file lacks"),
    many("taxiway", OVERLAY_TAXIWAY, "Width, code letter and direction of a taxiway or an edge"),
    many("stand", OVERLAY_STAND, "What a stand is for"),
    many("closed", OVERLAY_CLOSED, "What nobody uses: one of these keys"),
    many(
        "area",
        OVERLAY_AREA,
        "Ground that is protected for a time: who is in it is told of, nobody goes round it",
    ),
    one("runways", OVERLAY_RUNWAYS, "Runway ends in use where a demand names none"),
];

const CODE: fn() -> Vec<&'static str> = || vec!["A", "B", "C", "D", "E", "F"];

const OVERLAY_HOLD: &[Key] = &[
    Key::text(
        "node",
        "Node by name, or by `#` and its number; or a place within 30 m of a taxiway",
    ),
    Key::flag("off", "Nobody holds there, whatever the file says").or("false"),
];

const OVERLAY_EDGE: &[Key] = &[
    Key::new("between", Holds::Texts, "Its two nodes").needed(),
    Key::text("name", "Name of the taxiway"),
    Key::flag("one_way", "Driven from the first to the second only").or("false"),
    Key::word("code", CODE, "Largest code letter"),
    Key::number("width_m", "m", 5.0, 100.0, "Width").or("23"),
];

const OVERLAY_TAXIWAY: &[Key] = &[
    Key::text("name", "All edges of this name"),
    Key::new("edge", Holds::Texts, "Or the edge between these two nodes"),
    Key::word("code", CODE, "Largest code letter"),
    Key::number("width_m", "m", 5.0, 100.0, "Width"),
    Key::flag("one_way", "With `edge`: from the first node to the second only; false: both ways"),
];

const OVERLAY_STAND: &[Key] = &[
    Key::text("name", "Its name").needed(),
    Key::word("code", CODE, "Largest code letter"),
    Key::text("kind", "As in layout files: `gate`, `cargo`, `ga`, `tie_down`, …"),
    Key::number("heading_deg", "deg", 0.0, 360.0, "Heading of a parked aircraft"),
];

const OVERLAY_CLOSED: &[Key] = &[
    Key::text("taxiway", "All edges of this name"),
    Key::new("edge", Holds::Texts, "The edge between these two nodes"),
    Key::text("stand", "A stand"),
    Key::new(
        "area",
        Holds::Places(&[]),
        "Corners in order, 3 at least: every edge and stand in it",
    ),
    Key::text(
        "runway",
        "A runway, by one of its ends: landings and rolls on it are told of; no drawn flight uses it where it is closed to the end",
    ),
    Key::number("from_s", "s", 0.0, 1e6, "With `runway`: closed from then on").or("0"),
    Key::number("until_s", "s", 0.0, 1e6, "And until then").or("the end"),
];

const OVERLAY_AREA: &[Key] = &[
    Key::word("kind", || vec!["closed", "ils", "restricted"], "Why it is protected").needed(),
    Key::new("corners", Holds::Places(&[]), "Corners in order, 3 at least").needed(),
    Key::number("from_s", "s", 0.0, 1e6, "Protected from then on").or("0"),
    Key::number("until_s", "s", 0.0, 1e6, "And until then").or("the end"),
];

const OVERLAY_RUNWAYS: &[Key] = &[
    Key::new("arrival", Holds::Texts, "Ends for landings"),
    Key::new("departure", Holds::Texts, "Ends for take-offs"),
];

/// The words of a table of an overlay; those of a place too where it may stand for a node.
pub(crate) fn overlay_words(word: &str) -> Vec<&'static str> {
    let table = OVERLAY.iter().find(|t| t.word == word);
    let mut all = table.map_or(Vec::new(), |t| words(t.keys));
    if word == "hold" {
        all.extend(place_words());
    }
    all
}

pub(crate) const REFERENCE: &[Key] = &[
    Key::number("lat_deg", "deg", -90.0, 90.0, "Latitude").needed(),
    Key::number("lon_deg", "deg", -180.0, 180.0, "Longitude").needed(),
    Key::number("height_m", "m", -500.0, 9000.0, "Height above the ellipsoid").needed(),
];

pub(crate) const TRAFFIC: &[Key] = &[
    Key::word(
        "kind",
        || vec!["parked", "recorded", "route", "driven", "schedule", "generated", "handover"],
        "What moves it",
    )
    .needed(),
    Key::text(
        "callsign",
        "Of a mover: call sign or name, 1 to 11 upper-case letters, digits or signs; unique",
    ),
    Key::text(
        "type",
        "Of a mover: type designator of types.csv; handover: the largest that may be given, if larger than all flights",
    ),
    Key::whole("count", 1, 500, "handover: how many aircraft other programs may give in a run")
        .or("20"),
    Key::whole("address", 1, 0xff_fffe, "Of a mover: its 24-bit address; unique"),
    Key::new(
        "flight",
        Holds::Table(FLIGHT),
        "Of a mover: its line of the flight list; without it nobody expects it",
    ),
    Key::text(
        "stand",
        "parked: name of the stand; driven: where it stands until a person takes it, a stand or a node",
    ),
    Key::new("file", Holds::File, "recorded: movement (CSV); schedule: flights (CSV)"),
    Key::number(
        "start_s",
        "s",
        -86_400.0,
        86_400.0,
        "recorded: time of the first record that is used; route: when it sets off, not before 0",
    ),
    Key::number(
        "cut_from_s",
        "s",
        0.0,
        86_400.0,
        "recorded: time in the file before which nothing is used",
    )
    .or("0"),
    Key::number(
        "cut_to_s",
        "s",
        0.0,
        f64::INFINITY,
        "recorded: time in the file after which nothing is used",
    )
    .or("the end"),
    Key::new(
        "via",
        Holds::Texts,
        "route: stands, nodes, taxiways, runways and `hold RUNWAY` in order, two at least; it begins and ends at a place",
    ),
    Key::new("halts", Holds::Tables(HALT), "route: where it stands for a while"),
    Key {
        unit: "flights/h",
        ..Key::new(
            "arrivals_per_h",
            Holds::NumberOrNumbers { least: 0.0, most: 2000.0 },
            "generated: arrivals; of a list each for an hour of the run, the last one from then on",
        )
        .or("0")
    },
    Key {
        unit: "flights/h",
        ..Key::new(
            "departures_per_h",
            Holds::NumberOrNumbers { least: 0.0, most: 2000.0 },
            "generated: departures, likewise",
        )
        .or("0")
    },
    Key::new("mix", Holds::Shares, "generated: weight of each type")
        .or("A320 5, B738 4, E190 2, A333 1"),
    Key::word(
        "profile",
        || vec!["poisson", "even", "banks"],
        "generated: drawn times, equal gaps, or drawn times with all arrivals in the first and all departures in the last third of each hour",
    )
    .or("poisson"),
    Key::number(
        "turnaround_min",
        "min",
        10.0,
        1440.0,
        "generated: mean time from landing to off-block of an aircraft that leaves again; drawn with a quarter of it, at least 0.7 of it",
    )
    .or("48, from code D on 95"),
    Key::new(
        "vehicles",
        Holds::Counts { most: MOST_VEHICLES },
        "generated: how many of each type of vehicle drive from stand to stand where no flight is expected",
    ),
    Key::whole("seed", 0, i64::MAX, "generated: seed of the flights").or("that of the run"),
    Key::new("arrival_runways", Holds::Texts, "generated: runways for landings")
        .or("by network and wind"),
    Key::new("departure_runways", Holds::Texts, "generated: runways for take-offs")
        .or("by network and wind"),
];

/// Keys of one mover.
pub const MOVER: &[&str] = &[
    "kind",
    "callsign",
    "type",
    "address",
    "flight",
    "stand",
    "file",
    "start_s",
    "cut_from_s",
    "cut_to_s",
    "via",
    "halts",
];
/// Keys of what a person drives.
pub const DRIVEN: &[&str] = &["kind", "callsign", "type", "address", "flight", "stand"];
/// Keys of places for those who are given by other programs.
pub const HANDOVER: &[&str] = &["kind", "count", "type"];
/// Keys of a schedule.
pub const SCHEDULE: &[&str] = &["kind", "file"];
/// Keys of generated traffic.
pub const GENERATED: &[&str] = &[
    "kind",
    "arrivals_per_h",
    "departures_per_h",
    "mix",
    "profile",
    "turnaround_min",
    "vehicles",
    "seed",
    "arrival_runways",
    "departure_runways",
];

pub(crate) const FLIGHT: &[Key] = &[
    Key::word("movement", || vec!["arrival", "departure", "vehicle"], "What it does").needed(),
    Key::text("runway", "Its runway"),
    Key::text("stand", "Its stand"),
    Key::number(
        "eta_ctd_s",
        "s",
        -86_400.0,
        86_400.0,
        "Estimated landing or take-off, from the start of the run",
    )
    .or("0"),
    Key::number("off_block_s", "s", -86_400.0, 86_400.0, "Off-block time"),
    Key::new("routing", Holds::Texts, "Taxiways that it is expected on"),
];

pub(crate) const HALT: &[Key] = &[
    Key::text("at", "One of the names in `via`").needed(),
    Key::number("duration_s", "s", 0.0, 86_400.0, "How long").needed(),
];

pub(crate) const WEATHER: &[Key] = &[Key::new(
    "timeline",
    Holds::Tables(NOTICE),
    "Notices in the order of time; what one does not say stays as it was",
)];

pub(crate) const NOTICE: &[Key] = &[
    Key::number("at_s", "s", 0.0, 86_400.0, "From when on").needed(),
    Key::number("rain_mm_per_h", "mm/h", 0.0, 1000.0, "Rain everywhere").or("0"),
    Key::number("visibility_m", "m", 10.0, f64::INFINITY, "Meteorological visibility").or("clear"),
    Key::number("temperature_c", "°C", -60.0, 60.0, "Temperature").or("15"),
    Key::number(
        "pressure_hpa",
        "hPa",
        500.0,
        1100.0,
        "Pressure at the field (not reduced to sea level); an elevation changes nothing by itself",
    )
    .or("1013.25"),
    Key::number("vapour_g_per_m3", "g/m³", 0.0, 60.0, "Water vapour").or("7.5"),
    Key::number("wind_mps", "m/s", 0.0, 80.0, "Speed of the wind; goes with `wind_from_deg`")
        .or("0"),
    Key::number("wind_from_deg", "deg", 0.0, 360.0, "Where it comes from"),
    Key::number("film_mm", "mm", 0.0, 20.0, "Water on the surfaces").or("0"),
    Key::new("cells", Holds::Tables(CELL), "Rain cells, at most 100, which the wind carries"),
];

pub(crate) const CELL: &[Key] = &[
    Key::number("east_m", "m", -1e5, 1e5, "Middle, east of the reference point").needed(),
    Key::number("north_m", "m", -1e5, 1e5, "Middle, north of it").needed(),
    Key::number("radius_m", "m", 1.0, 1e5, "Radius").needed(),
    Key::number(
        "rain_mm_per_h",
        "mm/h",
        0.0,
        1000.0,
        "Rain inside; the heavier of this and the one around counts",
    )
    .needed(),
];

pub(crate) const BUILDING: &[Key] = &[
    Key::text("name", "A name for people").needed(),
    Key::new("footprint", Holds::Places(&[]), "Corners in order, 3 to 200").needed(),
    Key::number("height_m", "m", 1.0, 500.0, "Height of its roof").needed(),
    Key::word("facade", || MATERIALS.iter().map(|m| m.name).collect(), "What its walls are of")
        .or("concrete"),
];

pub(crate) const BOARD: &[Key] = &[
    Key::text("name", "A name for people").needed(),
    Key::new("place", Holds::Place, "Where it stands").needed(),
    Key::number("centre_height_m", "m", 0.0, 5000.0, "Height of its centre above that place")
        .needed(),
    Key::number("size_m", "m", 0.01, 1000.0, "Its side").needed(),
    Key::number("luminance_ratio", "", 0.0, 100.0, "Its luminance, of that of the horizon")
        .needed(),
];

pub(crate) const SENSOR: &[Key] = &[
    Key::word(
        "kind",
        || KINDS.iter().map(|d| d.kind.word).chain(["offline", "asterix"]).collect(),
        "The kind of sensor",
    )
    .needed(),
    Key::text("name", "A name for people, unique").needed(),
    Key::new("site", Holds::Place, "Where it stands; needed of radars and loops"),
    Key::text(
        "parameters",
        "Name of a parameter set; of a radar a file `parameter-sets/NAME.toml`",
    ),
    Key::new("overrides", Holds::Open, "Single parameters that differ from the set"),
    Key::new("equipped", Holds::ShareOrNames, "Which targets carry it: a share, or call signs")
        .or("all"),
    Key::word(
        "processing",
        || vec!["auto", "plot", "cells", "video"],
        "asde: how echoes become plots",
    )
    .or("auto"),
    Key::new("figures", Holds::File, "offline: figures that `seeds fit` wrote"),
    Key::text(
        "of",
        "offline: which sensor of that file; asterix: the kind of sensor that it is (asde)",
    ),
    Key::text("listen", "asterix: own address, multicast group or broadcast address with the port"),
    Key::text("interface", "asterix: address of the interface of a multicast group"),
    Key::new("from", Holds::Texts, "asterix: only these senders' addresses"),
    Key::new(
        "file",
        Holds::File,
        "asterix: a recording in place of the network, part of the scene",
    ),
    Key::whole("sac", 0, 255, "asterix: system area code of its reports").or("any"),
    Key::whole("sic", 0, 255, "asterix: system identification code of its reports").or("any"),
    Key::new(
        "categories",
        Holds::Numbers { least: 0.0, most: 255.0 },
        "asterix: categories taken, of 10, 20, 21, 48, 62",
    )
    .or("all of them"),
    Key::number(
        "sigma_m",
        "m",
        0.01,
        1000.0,
        "asterix: standard deviation of a position whose report says none",
    )
    .or("5"),
    Key::number("interval_s", "s", 0.05, 60.0, "asterix: time between two reports of a target")
        .or("a scan"),
    Key::word(
        "clock",
        || vec!["utc", "first"],
        "asterix: its times are the scene's, or count from its first plot",
    )
    .or("utc"),
];

pub(crate) const TRACKING: &[Key] = &[
    Key::word(
        "profile",
        || vec!["paper", "accurate", "bulk"],
        "The named choice that everything not said follows",
    )
    .or("paper"),
    Key::word(
        "filter",
        || Rung::ALL.iter().map(|(_, name)| *name).collect(),
        "Rung of the filter ladder",
    ),
    Key::number("q", "m²/s⁵", 1e-9, 1e6, "Spectral density of the jerk"),
    Key::word("association", || vec!["nearest", "global", "joint"], "How plots find their tracks"),
    Key::whole(
        "joint_limit",
        2,
        10_000_000,
        "joint: hypotheses of a cluster beyond which a cheaper form is taken",
    )
    .or("100000"),
    Key::word(
        "life",
        || vec!["m_of_n", "existence"],
        "What confirms and ends tracks: counted hits and times, or the probability of a target",
    ),
    Key::number(
        "gate_probability",
        "",
        0.5,
        1.0 - 1e-12,
        "Share of right plots that the gate lets pass",
    ),
    Key::number(
        "identified_gate_probability",
        "",
        0.5,
        1.0 - 1e-12,
        "The same where an identity says whose it is",
    ),
    Key::flag("kinematic_gate", "Whether what no mover can do is refused"),
    Key::flag("restart", "Whether a track begins again where plots go on beside it"),
    Key::whole("confirm_hits", 1, 32, "Plots that confirm a track, at most `confirm_of`"),
    Key::whole("confirm_of", 1, 32, "Of so many that were due"),
    Key::whole("identified_hits", 1, 32, "The same of a track with an identity"),
    Key::whole("identified_of", 1, 32, "Of so many that were due"),
    Key::number(
        "constant_velocity_after_s",
        "s",
        0.0,
        60.0,
        "Without plots for so long, a track coasts straight on",
    ),
    Key::number("coast_q", "m²/s³", 0.0, 1e3, "Spectral density of the acceleration meanwhile"),
    Key::number(
        "delete_moving_s",
        "s",
        0.5,
        600.0,
        "Without plots for so long, a moving track ends",
    ),
    Key::number(
        "delete_standing_s",
        "s",
        0.5,
        3600.0,
        "Without plots for so long, a standing one does",
    ),
    Key::number("delete_radius_m", "m", 1.0, 10_000.0, "Uncertainty at which a track ends that lacks two looks, where it has doubled since its last plot"),
    Key::whole("track_numbers", 1, 65_536, "How many numbers there are; more than 28 672 are as many"),
    Key::number(
        "number_rest_s",
        "s",
        0.0,
        3600.0,
        "How long a number rests before it is used again",
    ),
    Key::number("late_s", "s", 0.0, 60.0, "How late a plot may be and still be taken in its order"),
    Key::flag("consider_slow_errors", "Whether slow errors of sensors are respected"),
    Key::flag("register_sites", "Whether constant errors of radar sites are estimated"),
    Key::flag(
        "register_map",
        "With `register_sites`: from what taxis on the airport's lanes too, where these were surveyed to half a metre",
    )
    .or("false"),
    Key::flag("register_echo", "Whether the near side of echoes is taken off"),
    Key::flag("amplitude", "Whether the strength of an echo says whether it has a target")
        .or("false"),
    Key::number(
        "duplicate_radius_m",
        "m",
        0.0,
        100.0,
        "Two tracks so near that move alike are one",
    ),
    Key::flag("second_ago", "Whether tracks are published as they were a scan ago too"),
    Key::number(
        "scan_budget_ms",
        "ms",
        1.0,
        1e6,
        "What a scan may cost, by a table of evaluations",
    ),
    Key::number(
        "stand_radius_m",
        "m",
        1.0,
        500.0,
        "How near its stand a target is taken for the flight there",
    ),
    Key::number("list_sigma_s", "s", 1.0, 86_400.0, "How exact the times of the flight list are"),
];

pub(crate) const ACCURACY: &[Key] = &[
    Key::number("position_m", "m", 0.0, 1000.0, "Rms distance of plots that both runs have")
        .or("0.1"),
    Key::number(
        "tail",
        "",
        0.0,
        1.0,
        "Share of these that may be farther apart than five times that",
    )
    .or("0.001"),
    Key::number("detection", "", 0.0, 1.0, "Share of scans in which only one run has the plot")
        .or("0.01"),
    Key::number(
        "false_plots",
        "",
        0.0,
        1e6,
        "Expected false plots of one run only, a scan and radar",
    )
    .or("0.01"),
    Key::number(
        "track_m",
        "m",
        0.0,
        1000.0,
        "Rms shift of the published position of a steady filter",
    ),
    Key::number(
        "time_budget_us",
        "µs",
        1.0,
        1e9,
        "Time of a scan and radar by the table of costs; the other keys are then the unit of a factor",
    ),
];

/// A key of `[accuracy]` that was one, refused with what takes its place.
pub(crate) const ACCURACY_BEFORE: &str = "sum_db";

pub(crate) const NETWORK: &[Key] = &[
    Key::new("dis", Holds::Texts, "Where PDUs are sent, ADDRESS:PORT").or("127.255.255.255:3000"),
    Key::text("interface", "Address of the interface that they leave by"),
    Key::whole("ttl", 0, 255, "Routers that they may pass").or("1"),
    Key::flag("bundle", "Whether several PDUs share a datagram").or("from 64 PDUs of a frame on"),
    Key::new(
        "dis_from",
        Holds::Texts,
        "Whose PDUs are taken beside this host's: addresses, or networks like 10.0.0.0/24",
    )
    .or("everybody's"),
    Key::new(
        "dis_sites",
        Holds::Numbers { least: 0.0, most: 65_535.0 },
        "DIS sites whose entities are taken beside the scene's own",
    )
    .or("all"),
    Key::new(
        "dis_managers",
        Holds::Texts,
        "Hosts whose simulation management is obeyed beside this one: addresses, or networks",
    )
    .or("none"),
    Key::new("sync_listen", Holds::Texts, "Endpoints of the synchronisation plane to listen at"),
    Key::new("sync_connect", Holds::Texts, "Endpoints of it to connect to"),
    Key::new(
        "stall_ms",
        Holds::ByName(&Holds::Whole { least: 300, most: 3_600_000 }),
        "Without a beat for so long, a federate is lost [ms]",
    ),
    Key::new(
        "step_ms",
        Holds::ByName(&Holds::Whole { least: 100, most: 86_400_000 }),
        "At one frame for so long, it is [ms]",
    ),
    Key::new(
        "on_loss",
        Holds::ByName(&Holds::Word(|| vec!["freeze", "degrade", "takeover", "abort"])),
        "What becomes of a run that loses a federate",
    )
    .or("freeze"),
    Key::new(
        "return_ms",
        Holds::WholeOr { least: 0, most: 86_400_000, word: "none" },
        "How long a run waits for it [ms]; none: as long as it takes",
    ),
    Key::new(
        "agents",
        Holds::ByName(&Holds::Text),
        "Endpoints of the `seeds agent` that starts a federate on its host; others run here",
    ),
];

pub(crate) const EXTERNAL: &[Key] = &[
    Key::new("asterix", Holds::Tables(ASTERIX_OUT), "Where ASTERIX goes"),
    Key::new("send", Holds::Texts, "What of it: sensors, tracks, status").or("all"),
    Key::new("categories", Holds::Numbers { least: 0.0, most: 255.0 }, "Only these categories")
        .or("4, 10, 11, 19, 20, 21, 62, 65, 247"),
    Key::whole("sac", 0, 255, "System area code of all that is sent").or("0"),
    Key::word(
        "time",
        || vec!["scene", "wall"],
        "Time of day: of the scene, or shifted to the host's",
    )
    .or("scene"),
    Key::new("asterix_in", Holds::Tables(ASTERIX_IN), "Where tracks of others are heard"),
    Key::new("adsb", Holds::Table(ADSB_FEED), "Squitters to whoever connects"),
    Key::text("http", "Where JSON and aircraft.json are served, ADDRESS:PORT"),
    Key::text("public", "Endpoint of clients (Zenoh)").or("tcp/127.0.0.1:7448"),
];

pub(crate) const ASTERIX_OUT: &[Key] = &[
    Key::text("to", "Host, multicast group or broadcast address, ADDRESS:PORT").needed(),
    Key::text("interface", "Address of the interface that it leaves by"),
    Key::whole("ttl", 0, 255, "Routers that it may pass").or("1"),
];

pub(crate) const ASTERIX_IN: &[Key] = &[
    Key::text("listen", "Own address, multicast group or broadcast address, ADDRESS:PORT").needed(),
    Key::text("interface", "Address of the interface of the group"),
    Key::new("from", Holds::Texts, "Only these senders").or("all"),
    Key::new("reference", Holds::Table(REFERENCE), "Point that positions in metres are about")
        .or("the aerodrome's"),
];

pub(crate) const ADSB_FEED: &[Key] = &[
    Key::text("beast", "Where Beast frames are served, ADDRESS:PORT"),
    Key::text("sbs", "Where SBS lines are served, ADDRESS:PORT"),
    Key::word("from", || vec!["truth", "reports"], "Whose positions they have").or("truth"),
];

pub(crate) const CONTROL: &[Key] = &[
    Key::word("sees", || vec!["none", "truth", "tracks"], "What control reads").or("none"),
    Key::word("controllers", || vec!["plan", "model"], "Who clears, where control reads tracks")
        .or("plan; model where sees is truth"),
    Key::word("policy", || vec!["planned", "ordered", "free"], "How ways are cleared")
        .or("planned"),
    Key::number("errors", "", 0.0, 1e5, "Errors of pilots, in multiples of what is assumed")
        .or("0"),
    Key::flag("stop_bars", "Whether stop bars are in use").or("false"),
    Key::flag("advice", "Whether controllers at seats are advised, which models mostly follow")
        .or("false"),
    Key::flag("by_hand", "Whether people may take flights that taxi, and give them back")
        .or("false"),
    Key::flag("greens", "Whether lamps of the taxiways show each flight its way").or("false"),
    Key::word("sequence", || vec!["first", "cps"], "In which order departures leave their stands")
        .or("first"),
    Key::whole("shift", 0, 4, "With `sequence = \"cps\"`: places that one may be moved").or("2"),
    Key::word("wake", || vec!["icao", "recat-eu"], "Categories that aircraft are separated by")
        .or("icao"),
    Key::new("seats", Holds::Table(SEATS), "Whose the seats of controllers are").or("the models'"),
    Key::flag("fallback", "Whether the model takes a seat of a person that is empty for 30 s")
        .or("false"),
    Key::whole("confirm_scans", 1, 10, "Scans in a row before an alert is raised").or("1"),
    Key::number("strip_margin_m", "m", 0.0, 50.0, "Off the hold distance: 95 % error of tracks")
        .or("7.5"),
    Key::number("bar_margin_m", "m", 0.0, 20.0, "So far behind it the nose is over a bar").or("0"),
];

pub(crate) const SEATS: &[Key] = &[
    Key::word("apron", || vec!["model", "human"], "Push-backs").or("model"),
    Key::word("ground", || vec!["model", "human"], "Taxiing").or("model"),
    Key::word("tower", || vec!["model", "human"], "Runways: all towers").or("model"),
];

pub(crate) const FAILURE: &[Key] = &[
    Key::text("id", "Its name in the log"),
    Key::word("kind", || FailureKind::WORDS.map(|w| w.0).to_vec(), "What goes wrong").needed(),
    Key::text("callsign", "The flight of the schedule that does it").needed(),
    Key::number("at_s", "s", 0.0, 86_400.0, "Not before").or("0"),
    Key::number("stay_s", "s", 0.0, 86_400.0, "How long it stays")
        .or("60; stop bars 1800, transponders 600"),
    Key::number("lead_s", "s", 0.0, 86_400.0, "A vehicle is there so long before the arrival")
        .or("45"),
    Key::word(
        "clearance",
        || vec!["CRO", "ENT", "LUP", "TOF", "LND"],
        "What the controller clears another for",
    )
    .or("CRO"),
    Key::word("lamps", || vec!["dark", "lit"], "What failed stop bars are").or("dark"),
];

pub(crate) const SHAPE: &[Key] = &[
    Key::text("name", "Its name, as types.csv says it").needed(),
    Key::number("length_m", "m", 0.1, 200.0, "Length of the target that it is of").needed(),
    Key::number("span_m", "m", 0.1, 200.0, "Its span").needed(),
    Key::number("rcs_m2", "m²", 1e-3, 1e5, "Its median echo").needed(),
    Key::text("source", "Where the shape comes from").needed(),
    Key::number(
        "fuselage_radius",
        "",
        0.0,
        0.5,
        "With `flash`: radius of the fuselage, share of the length",
    ),
    Key::number(
        "behind_fuselage",
        "",
        0.0,
        1.0,
        "With `flash`: what a wing keeps behind the fuselage",
    ),
    Key::new("flash", Holds::Table(FLASH), "Echo of a fuselage seen from the side"),
    Key::new("limits_db", Holds::Table(LIMITS), "How far the echo may be off the median").needed(),
    Key::new(
        "scatterers",
        Holds::Rows,
        "Rows of x, y, share, or x, y, share, from_deg, half_width_deg",
    ),
];

pub(crate) const FLASH: &[Key] = &[
    Key::number("base", "", 0.0, 100.0, "Share of the echo away from the side").needed(),
    Key::number("peak", "", 0.0, 100.0, "Share of it at the side").needed(),
    Key::number("width_deg", "°", 0.5, 90.0, "Width of the flash").needed(),
    Key::new(
        "points",
        Holds::Numbers { least: -0.5, most: 0.5 },
        "Where along the fuselage it comes from, in lengths",
    ),
];

pub(crate) const LIMITS: &[Key] = &[
    Key::number("below", "dB", 0.0, 60.0, "Below it").needed(),
    Key::number("above", "dB", 0.0, 60.0, "Above it").needed(),
];
