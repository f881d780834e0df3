//! Scenes of many movers side by side, made of what ships.

use models::draw::{DrawKey, Purpose, uniform};
use models::frames::Point2;
use scenarios::{ScenarioError, Scene};

/// Zurich with thirty-five movers under its radar alone: thirteen recorded movements (the six that ship, seven of them again
/// at other times under other names), eleven parked aircraft that no list knows, eleven vehicles on routes between the
/// stands, unlisted too. Nothing was tuned on it.
///
/// # Errors
/// What the scene reader says.
pub fn thirty_five(seed: u64) -> Result<Scene, ScenarioError> {
    scenarios::load_text(&scenarios::locate("zurich"), &thirty_five_text(seed, &Draw::default()))
}

/// The same with another draw: each recorded movement up to 8 s earlier or later (more, and some drive through each other), parked
/// aircraft of drawn types and vehicles of drawn kinds. Nothing was tuned on it.
///
/// # Errors
/// What the scene reader says.
pub fn thirty_five_drawn(seed: u64) -> Result<Scene, ScenarioError> {
    let mut rng = DrawKey { run_seed: seed, sensor: 0, entity: 35, scan: 0 }.rng(Purpose::Study);
    let mut draw = |n: usize| ((uniform(&mut rng) * n as f64) as usize).min(n - 1);
    let by = std::array::from_fn(|_| draw(17) as f64 - 8.0);
    // The first two stands are large ones.
    let parked = std::array::from_fn(|n| {
        if n < 2 { ["A320", "A333", "B738", "E190"][draw(4)] } else { ["C172", "C550"][draw(2)] }
    });
    let vehicles = std::array::from_fn(|_| ["FOLLOWME", "FUEL", "BUS", "FIRE", "TUG"][draw(5)]);
    let drawn = Draw { by, parked: Some(parked), vehicles: Some(vehicles) };
    scenarios::load_text(&scenarios::locate("zurich"), &thirty_five_text(seed, &drawn))
}

/// What of the thirty-five is drawn: by how much later movements come, s; types of parked aircraft and of vehicles.
#[derive(Default)]
struct Draw {
    by: [f64; 13],
    parked: Option<[&'static str; 11]>,
    vehicles: Option<[&'static str; 11]>,
}

fn thirty_five_text(seed: u64, drawn: &Draw) -> String {
    let by = &drawn.by;
    let mut text = format!(
        "[run]\ntitle = \"Zurich, thirty-five movers\"\nseed = {seed}\nstart = 2019-11-24T09:00:00Z\nduration_s = 600\n\
         exercise = 1\nsite = 417\nframe_s = 0.05\nscan_s = 1.0\n\
         [airport]\nicao = \"LSZH\"\nlayout = \"airports/LSZH.apt.dat\"\nground_network = \"airports/LSZH.groundnet.xml\"\n\
         radius_m = 6000\ntaxiway_width_m = 23\n\
         [[sensor]]\nkind = \"asde\"\nname = \"ASDE tower\"\nparameters = \"ku_asde3\"\n\
         site = {{ lat_deg = 47.453819, lon_deg = 8.556911, height_m = 60 }}\n"
    );
    // Name, type, file, start, cut, flight.
    let arrival = |runway: &str, stand: &str, eta: f64| {
        format!(
            "movement = \"arrival\", runway = \"{runway}\", stand = \"{stand}\", eta_ctd_s = {eta}"
        )
    };
    let departure = |runway: &str, stand: &str, ctd: f64, off: f64| {
        format!(
            "movement = \"departure\", runway = \"{runway}\", stand = \"{stand}\", eta_ctd_s = {ctd}, off_block_s = {off}"
        )
    };
    let recorded: [(&str, &str, &str, f64, &str, String); 13] = [
        ("EDW229", "A320", "EDW229", 10.0 + by[0], "", arrival("28", "D_16", 21.0 + by[0])),
        ("EDW231", "A320", "EDW229", 200.0 + by[1], "", arrival("28", "D_16", 211.0 + by[1])),
        ("EDW233", "A320", "EDW229", 380.0 + by[2], "", arrival("28", "D_57", 391.0 + by[2])),
        (
            "CAI3208",
            "B738",
            "CAI3208",
            30.0 + by[3],
            "cut_to_s = 640\n",
            arrival("14", "Gate_B_38", 45.0 + by[3]),
        ),
        (
            "CAI3210",
            "B738",
            "CAI3208",
            300.0 + by[4],
            "cut_to_s = 640\n",
            arrival("14", "Gate_B_38", 315.0 + by[4]),
        ),
        (
            "SWR137H",
            "A320",
            "SWR137H",
            by[5],
            "cut_from_s = 270\ncut_to_s = 480\n",
            departure("28", "I_98", 180.0 + by[5], -420.0 + by[5]),
        ),
        (
            "SWR139",
            "A320",
            "SWR137H",
            250.0 + by[6],
            "cut_from_s = 270\ncut_to_s = 480\n",
            departure("28", "I_98", 430.0 + by[6], -170.0 + by[6]),
        ),
        (
            "ENT57BW",
            "B738",
            "ENT57BW",
            by[7],
            "cut_from_s = 430\n",
            departure("28", "Heliport_West_15", 424.0 + by[7], -340.0 + by[7]),
        ),
        (
            "ENT59",
            "B738",
            "ENT57BW",
            150.0 + by[8],
            "cut_from_s = 430\n",
            departure("28", "Heliport_West_15", 574.0 + by[8], -190.0 + by[8]),
        ),
        (
            "ACA879",
            "B788",
            "ACA879",
            100.0 + by[9],
            "cut_from_s = 120\ncut_to_s = 520\n",
            departure("16", "E_19", 485.0 + by[9], -20.0 + by[9]),
        ),
        (
            "ACA881",
            "B788",
            "ACA879",
            -60.0 + by[10],
            "cut_from_s = 120\ncut_to_s = 520\n",
            departure("16", "E_19", 325.0 + by[10], -180.0 + by[10]),
        ),
        (
            "AEE5ZH",
            "A320",
            "AEE5ZH",
            by[11],
            "cut_from_s = 115\n",
            departure("28", "Terminal_A_Gate_48", 578.0 + by[11], 11.0 + by[11]),
        ),
        (
            "AEE7",
            "A320",
            "AEE5ZH",
            -190.0 + by[12],
            "cut_from_s = 115\n",
            departure("28", "Terminal_A_Gate_48", 388.0 + by[12], -179.0 + by[12]),
        ),
    ];
    for (name, kind, file, start, cut, flight) in recorded {
        text += &format!(
            "[[traffic]]\nkind = \"recorded\"\ncallsign = \"{name}\"\ntype = \"{kind}\"\nfile = \"movements/{file}.csv\"\n\
             start_s = {start}\n{cut}flight = {{ {flight} }}\n"
        );
    }
    let parked = [
        ("E_67", "A320"),
        ("Dock_Midfield_Gate_E56", "A333"),
        ("GAC_S1_C", "C550"),
        ("GAC_S1_D", "C172"),
        ("GAC_S1_F", "C550"),
        ("GAC_S3_F", "C172"),
        ("GAC_S3_H", "C172"),
        ("GAC_S4_D", "C550"),
        ("Heliport_West_12", "C172"),
        ("Heliport_West_8", "C172"),
        ("Heliport_West_6", "C172"),
    ];
    for (n, (stand, kind)) in parked.iter().enumerate() {
        let kind = drawn.parked.map_or(*kind, |own| own[n]);
        text += &format!(
            "[[traffic]]\nkind = \"parked\"\ncallsign = \"PARK{n}\"\ntype = \"{kind}\"\nstand = \"{stand}\"\n"
        );
    }
    // Each begins where no other one does, and ends where one has left.
    let routed: [(&str, [&str; 2], f64); 11] = [
        ("FOLLOWME", ["Terminal_A_Gate_48", "D_57"], 90.0),
        ("FUEL", ["D_57", "E_19"], 60.0),
        ("FUEL", ["E_19", "D_16"], 50.0),
        ("BUS", ["D_16", "Gate_B_38"], 40.0),
        ("FUEL", ["Gate_B_38", "I_98"], 30.0),
        ("FIRE", ["I_98", "GAC_S1_A"], 20.0),
        ("TUG", ["GAC_S1_A", "GAC_S1_E"], 100.0),
        ("FUEL", ["GAC_S1_E", "Terminal_A_Gate_48"], 150.0),
        ("FOLLOWME", ["Heliport_West_15", "Heliport_West_1"], 200.0),
        ("BUS", ["Heliport_West_14", "Heliport_West_15"], 260.0),
        ("FOLLOWME", ["Heliport_West_3", "E_19"], 300.0),
    ];
    for (n, (kind, [from, to], start)) in routed.iter().enumerate() {
        let kind = drawn.vehicles.map_or(*kind, |own| own[n]);
        text += &format!(
            "[[traffic]]\nkind = \"route\"\ncallsign = \"TRUCK{n}\"\ntype = \"{kind}\"\nvia = [\"{from}\", \"{to}\"]\n\
             start_s = {start}\n"
        );
    }
    text
}

/// Parked aircraft and driven vehicles in one scene.
const MOST_OF_EACH: usize = 11;

/// A shipped scene of flights that behave (`eham`, `xsyn`) with eleven parked aircraft in groups of neighbouring stands, and
/// eleven vehicles that drive between the free stands among them; and how many seconds of it. Nothing was tuned on them.
///
/// # Errors
/// What the scene reader says.
pub fn among_parked(airport: &str, seed: u64) -> Result<(Scene, f64), ScenarioError> {
    let path = scenarios::locate(airport);
    let base = scenarios::load(&path)?;
    let text = scenarios::files::read_text(&path, 1 << 20).unwrap_or_default();
    let radar_m =
        base.sensors.first().and_then(|s| s.site_m).map_or_else(Point2::origin, |s| s.xy());
    let stands = &base.airport.layout.stands;
    // A stand that the list gives to a flight has room for no other aircraft.
    let listed = |stand: Point2<f64>| {
        let mut own = base.flight_list.entries.iter().filter_map(|e| e.stand_m);
        own.any(|s| (s - stand).norm() < 30.0)
    };
    let near: Vec<usize> = (0..stands.len())
        .filter(|&s| (stands[s].position_m - radar_m).norm() < 2_500.0)
        .filter(|&s| !listed(stands[s].position_m))
        .collect();
    let mut rng = DrawKey { run_seed: seed, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
    let mut draw = |n: usize| ((uniform(&mut rng) * n as f64) as usize).min(n - 1);
    let mut chosen: Vec<usize> = Vec::new();
    let groups = if near.is_empty() { 0 } else { 4 };
    for _ in 0..groups {
        let middle_m = stands[near[draw(near.len())]].position_m;
        let mut group = near.clone();
        group.sort_by(|a, b| {
            let off = |s: &usize| (stands[*s].position_m - middle_m).norm();
            off(a).total_cmp(&off(b)).then(a.cmp(b))
        });
        chosen.extend(group.into_iter().take(6));
    }
    chosen.sort_unstable();
    chosen.dedup();
    let mut whole = text.replacen("duration_s = 3600", "duration_s = 1500", 1);
    let types = ["A333", "A320", "C550", "C172", "B788", "A320"];
    let (mut taken, mut free) = (0, Vec::new());
    for (n, &stand) in chosen.iter().enumerate() {
        if n % 2 == 0 && taken < MOST_OF_EACH {
            whole += &format!(
                "[[traffic]]\nkind = \"parked\"\ncallsign = \"PARK{n}\"\ntype = \"{}\"\nstand = {:?}\n",
                types[draw(types.len())],
                stands[stand].name
            );
            taken += 1;
        } else {
            free.push(stand);
        }
    }
    let types = ["FOLLOWME", "FUEL", "BUS", "FIRE", "TUG"];
    for n in 0..MOST_OF_EACH.min(free.len() / 2) {
        let mut next = || free.swap_remove(draw(free.len()));
        let (from, to) = (next(), next());
        let way = format!(
            "[[traffic]]\nkind = \"route\"\ncallsign = \"TRUCK{n}\"\ntype = \"{}\"\nvia = [{:?}, {:?}]\nstart_s = {}\n",
            types[draw(types.len())],
            stands[from].name,
            stands[to].name,
            20 + draw(400)
        );
        // Some stands are on no road.
        if scenarios::load_text(&path, &format!("{text}{way}")).is_ok() {
            whole += &way;
        }
    }
    Ok((scenarios::load_text(&path, &whole)?, 1_200.0))
}
