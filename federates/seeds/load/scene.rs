//! A scene of any number of movers: a square grid of taxiways, 60 m apart, with one mover a square.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Distance of the taxiways, m.
const STEP_M: f64 = 60.0;
/// A degree of latitude and of longitude at 45°, m. Source: WGS 84 series, exact to some metres in 10 km.
const DEGREE_M: [f64; 2] = [111_131.7, 78_846.8];
/// The middle of the grid.
const MIDDLE_DEG: [f64; 2] = [45.0, 10.0];
/// A follow-me car does at most so many squares' sides in a second.
const SIDES_PER_S: f64 = 0.2;

/// What of a scene moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moves {
    /// Everybody drives around its square.
    All,
    /// One in ten does, the others are parked aircraft.
    OneInTen,
}

impl Moves {
    /// In words.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::All => "all drive",
            Self::OneInTen => "one in ten drives",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::All => "drive",
            Self::OneInTen => "mixed",
        }
    }
}

/// Degrees of a place so many squares from the corner.
fn place(side: usize, east: f64, north: f64) -> [f64; 2] {
    let half = side as f64 / 2.0;
    let [lat, lon] = MIDDLE_DEG;
    [lat + (north - half) * STEP_M / DEGREE_M[0], lon + (east - half) * STEP_M / DEGREE_M[1]]
}

/// Layout (apt.dat) and scene (TOML) of `count` movers for `seconds`.
pub(super) fn texts(count: usize, moves: Moves, seconds: f64) -> (String, String) {
    let side = (count as f64).sqrt().ceil() as usize;
    let number = |i: usize, j: usize| i * (side + 1) + j;
    let [lat, lon] = MIDDLE_DEG;
    let [runway_lat, from_lon] = place(side, side as f64 / 2.0 - 25.0, side as f64 + 2.0);
    let to_lon = 2.0 * lon - from_lon;
    let mut layout = format!(
        "I\n1000 Version - a grid of taxiways, made by SEEDS\n\n1 330 1 0 XLOA Load\n\
         100 45.00 1 0 0.25 1 3 1 09 {runway_lat:.8} {from_lon:.8} 0 0 3 2 1 0 27 {runway_lat:.8} {to_lon:.8} 0 0 3 2 1 0\n\
         14 {lat:.8} {lon:.8} 60 0 Tower\n"
    );
    let mut scene = format!(
        "[run]\ntitle = \"{count} movers on a grid, {}\"\nseed = 1\nstart = 2026-01-01T06:00:00Z\nduration_s = {seconds}\n\
         dead_reckoning = {{ algorithm = \"rvw\", position_m = 0.1, orientation_deg = 0.5 }}\n\
         heartbeat = {{ moving_s = 5.0, parked_s = 60.0 }}\n\n\
         [airport]\nicao = \"XLOA\"\nlayout = \"{}\"\n\n\
         [[sensor]]\nkind = \"asde\"\nname = \"ASDE\"\nparameters = \"ku_asde3\"\n\
         site = {{ lat_deg = {lat:.8}, lon_deg = {lon:.8}, height_m = 60 }}\n",
        moves.word(),
        layout_name(count, moves),
    );
    let sides = (seconds * SIDES_PER_S).ceil() as usize + 2;
    let (mut nodes, mut edges) = (String::from("1200\n"), String::new());
    for (i, j) in (0..=side).flat_map(|i| (0..=side).map(move |j| (i, j))) {
        let [lat, lon] = place(side, i as f64, j as f64);
        let here = number(i, j);
        // Writing into a text cannot fail.
        let _ = writeln!(nodes, "1201 {lat:.8} {lon:.8} both {here} N{here}");
        if i < side {
            let _ = writeln!(edges, "1202 {here} {} twoway taxiway_C X{j}", number(i + 1, j));
        }
        if j < side {
            let _ = writeln!(edges, "1202 {here} {} twoway taxiway_C Y{i}", number(i, j + 1));
        }
    }
    for index in 0..count {
        let (i, j) = (index / side, index % side);
        if moves == Moves::All || index % 10 == 0 {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let via = (0..sides).map(|k| corners[k % 4]);
            let via: Vec<String> = via.map(|(i, j)| format!("\"#{}\"", number(i, j))).collect();
            let _ = writeln!(
                scene,
                "\n[[traffic]]\nkind = \"route\"\ncallsign = \"L{index:05}\"\ntype = \"FOLLOWME\"\nvia = [{}]\nstart_s = {}",
                via.join(", "),
                1 + index % 7,
            );
        } else {
            let [lat, lon] = place(side, i as f64 + 0.5, j as f64 + 0.5);
            let _ = writeln!(layout, "1300 {lat:.8} {lon:.8} 0.00 gate jets S{index}");
            let _ = writeln!(
                scene,
                "\n[[traffic]]\nkind = \"parked\"\ncallsign = \"L{index:05}\"\ntype = \"A320\"\nstand = \"S{index}\""
            );
        }
    }
    (layout + &nodes + &edges + "99\n", scene)
}

fn layout_name(count: usize, moves: Moves) -> String {
    format!("load-{}-{count}.apt.dat", moves.name())
}

/// Writes a scene into `folder`; its file.
pub(super) fn write(
    folder: &Path,
    count: usize,
    moves: Moves,
    seconds: f64,
) -> std::io::Result<PathBuf> {
    let (layout, scene) = texts(count, moves, seconds);
    let file = folder.join(format!("load-{}-{count}.toml", moves.name()));
    std::fs::write(folder.join(layout_name(count, moves)), layout)?;
    std::fs::write(&file, scene)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_of_a_hundred_is_read_and_as_many_move_as_are_said_to() {
        let folder = std::env::temp_dir().join(format!("seeds-load-scene-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        for (moves, moving) in [(Moves::All, 100), (Moves::OneInTen, 10)] {
            let file = write(&folder, 100, moves, 20.0).expect("it is written");
            let scene = scenarios::load(&file).expect("it is read");
            assert_eq!(scene.traffic.entities.len(), 100);
            let far = |e: &&scenarios::Entity| {
                let path = e.trajectory.as_ref().expect("a movement");
                let at = |t| path.at(models::time::SimTime::from_s(t)).expect("during the run");
                (at(19.0).position_m - at(0.0).position_m).norm() > 10.0
            };
            assert_eq!(scene.traffic.entities.iter().filter(far).count(), moving, "{moves:?}");
        }
        let _ = std::fs::remove_dir_all(&folder);
    }
}
