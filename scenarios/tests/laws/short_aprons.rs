//! Small fields: aprons without room for a pushback. Light aircraft stand there with their nose to the lane and leave by themselves.

use models::frames::{Azimuth, wrap_pi};
use models::traffic::core::{Core, Direction, Phase};
use scenarios::Scene;
use scenarios::hours::{Hour, hour};
use std::path::PathBuf;

/// A runway of 1 100 m from south to north, and from its middle a taxiway east that ends between its stands, so many metres long.
fn field(stub_m: f64, stands: usize, turned_deg: f64, seed: u64) -> Scene {
    let turn = turned_deg.to_radians();
    let place = |east_m: f64, north_m: f64| {
        let (sin, cos) = libm::sincos(turn);
        let (x, y) = (east_m * cos - north_m * sin, east_m * sin + north_m * cos);
        let lat = -38.0 + y / 110_990.0;
        let lon = -72.0 + x / (111_320.0 * libm::cos(38_f64.to_radians()));
        format!("{lat:.8} {lon:.8}")
    };
    let heading = |deg: f64| (deg - turned_deg).rem_euclid(360.0);
    let mut text = format!(
        "A\n1000 Version\n\n1 100 1 1 XDRW Drawn\n100 18.00 1 1 0.00 0 0 1 01 {} 0 0 2 0 0 0 19 {} 0 0 2 0 0 0\n",
        place(0.0, 0.0),
        place(0.0, 1100.0)
    );
    for n in 0..stands {
        let along_m = 550.0 + 30.0 * (n as f64 - 0.5 * (stands - 1) as f64);
        let at = place(stub_m + 18.0, along_m);
        text += &format!("1300 {at} {:.1} misc props Apron {}\n", heading(90.0), n + 1);
    }
    text += "1200\n";
    for (id, x, y) in [(1, 0.0, 0.0), (2, 0.0, 550.0), (3, 0.0, 1100.0), (4, stub_m, 550.0)] {
        text += &format!("1201 {} both {id} n{id}\n", place(x, y));
    }
    text += "1202 1 2 twoway runway 01/19\n1202 2 3 twoway runway 01/19\n1202 2 4 twoway taxiway_A A\n99\n";
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("apron-{stub_m}-{seed}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("X.apt.dat"), text).expect("a file");
    let scene = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"X.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 6\ndepartures_per_h = 6\n"
    );
    let scene = scenarios::load_text(&folder.join("scene.toml"), &scene);
    std::fs::remove_dir_all(&folder).expect("removed");
    scene.unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn light_aircraft_leave_an_apron_without_room_for_a_pushback() {
    for (stub_m, stands, turned_deg, seed) in
        [(62.0, 2, 0.0, 1), (70.0, 3, 35.0, 2), (85.0, 4, 110.0, 3), (75.0, 2, 200.0, 4)]
    {
        let name = format!("{stub_m} m, {stands} stands, {turned_deg} degrees");
        let scene = field(stub_m, stands, turned_deg, seed);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let flights = behaving.flights.clone();
        let network = behaving.network.clone();
        let (mut pushed, mut parked) = (0, 0);
        let mut out = 0;
        let step = &mut |core: &mut Core, frame: i64| {
            core.step(frame);
            for (f, flight) in flights.iter().enumerate() {
                let Some(state) = core.state(f) else { continue };
                let along = Azimuth::from_rad(state.heading_rad).unit();
                pushed += usize::from(state.velocity_mps.xy().dot(&along) < -0.05);
                if flight.direction == Direction::Departure && core.phase(f) == Phase::Parked {
                    parked += 1;
                    let stand = &network.stands[core.stand(f)];
                    let off_rad = wrap_pi(state.heading_rad - stand.heading_rad).abs();
                    out += usize::from(off_rad > 1.57);
                }
            }
        };
        let looks = Hour { seed, every: 1, drain_s: 2700.0, stopping: 0.0 };
        let held = hour(behaving, &scene.run, &scene.airport.layout, &looks, step).expect("truth");
        assert_eq!(held.broken(), Vec::<String>::new(), "{name}");
        assert!(
            held.core.all_served(),
            "{name}: {} of {}",
            held.core.measures_of_served(),
            flights.len()
        );
        let departures = flights.iter().filter(|f| f.direction == Direction::Departure).count();
        assert!(departures >= 2, "{name}: {departures} departures");
        assert_eq!(pushed, 0, "{name}: nobody goes backwards");
        assert!(parked > 0 && out == parked, "{name}: {out} of {parked} with the nose to the lane");
    }
}
