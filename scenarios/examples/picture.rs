//! Prints what the import of each recorded movement of a scene did, the extremes of its truth, and
//! draws tracks and layout: `cargo run -p scenarios --example picture -- scenarios/zurich.toml out.svg`
#![allow(clippy::print_stdout, reason = "a command-line example")]

use models::frames::{Point2, Vector2};
use models::time::SimTime;
use std::fmt::Write;
use std::path::PathBuf;

/// The records of a file named after a call sign, if there is one beside the scene.
fn recordings(
    scene_file: &std::path::Path,
    callsign: &str,
    scene: &scenarios::Scene,
) -> Option<Vec<models::truth::recorded::Record>> {
    let file = scene_file.parent()?.join(format!("movements/{callsign}.csv"));
    let movement = scenarios::movements::read(&file, &scene.airport, 0.0, f64::INFINITY).ok()?;
    Some(movement.records)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scene_file = args.next().map_or_else(|| scenarios::locate("zurich"), PathBuf::from);
    let out = args.next().unwrap_or_else(|| "tracks.svg".into());
    let scene = scenarios::load(&scene_file)?;
    let airport = &scene.airport.layout;
    let mut svg = String::new();
    let ring = |points: &[Point2<f64>]| -> String {
        points.iter().map(|p| format!("{:.1},{:.1} ", p.x, -p.y)).collect()
    };
    for outline in &airport.pavement {
        writeln!(svg, "<polygon points='{}' fill='#ddd'/>", ring(outline))?;
    }
    for runway in &airport.runways {
        writeln!(
            svg,
            "<polyline points='{}' stroke='#aaa' stroke-width='{}' fill='none'/>",
            ring(&runway.ends_m),
            runway.width_m
        )?;
        writeln!(
            svg,
            "<polyline points='{}' stroke='#fff' stroke-width='1' fill='none'/>",
            ring(&runway.ends_m)
        )?;
    }
    for edge in &airport.edges {
        let ends = [airport.nodes[edge.from].position_m, airport.nodes[edge.to].position_m];
        writeln!(
            svg,
            "<polyline points='{}' stroke='#8a8' stroke-width='2' fill='none'/>",
            ring(&ends)
        )?;
    }
    let colours = ["#c00", "#06c", "#080", "#a0a", "#e80", "#088", "#555", "#960"];
    for (index, entity) in scene.traffic.entities.iter().enumerate() {
        if let Some(records) = recordings(&scene_file, &entity.callsign.to_string(), &scene) {
            for record in records {
                if let Some(p) = record.position_m {
                    writeln!(svg, "<circle cx='{:.1}' cy='{:.1}' r='2' fill='#000'/>", p.x, -p.y)?;
                }
            }
        }
        println!("{} ({})", entity.callsign, entity.class.designator);
        if let Some(report) = &entity.report {
            println!("{report}");
        }
        let Some(trajectory) = &entity.trajectory else { continue };
        let (start, end) = (trajectory.start(), trajectory.end());
        let mut points = Vec::new();
        let mut worst = (0.0, 0.0, 0.0, 0.0);
        let (mut fastest, mut acc, mut dec, mut lateral, mut turn, mut highest) =
            (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
        let mut time = start;
        while time <= end {
            if let Some(state) = trajectory.at(time) {
                let v = state.velocity_mps.xy();
                let nose = Vector2::new(libm::sin(state.heading_rad), libm::cos(state.heading_rad));
                let along = state.acceleration_ms2.xy().dot(&nose) * v.dot(&nose).signum();
                fastest = fastest.max(v.norm());
                acc = acc.max(along);
                dec = dec.min(along);
                lateral = lateral.max(
                    (state.acceleration_ms2.xy() - nose * state.acceleration_ms2.xy().dot(&nose))
                        .norm(),
                );
                if state.angular_rate_rads.z.abs() > turn {
                    turn = state.angular_rate_rads.z.abs();
                    worst = (time.s(), state.position_m.x, state.position_m.y, v.norm());
                }
                highest = highest.max(state.position_m.z);
                points.push(state.position_m.xy());
            }
            time = SimTime(time.0 + 50_000_000);
        }
        println!(
            "         from {:.1} s to {:.1} s; fastest {fastest:.1} m/s, acceleration {dec:.2} to {acc:.2}, lateral {lateral:.2} m/s2, turn {:.1} deg/s at {worst:.1?}, highest {highest:.0} m",
            start.s(),
            end.s(),
            turn.to_degrees()
        );
        writeln!(
            svg,
            "<polyline points='{}' stroke='{}' stroke-width='3' fill='none'/>",
            ring(&points),
            colours[index % colours.len()]
        )?;
    }
    let view = std::env::var("VIEW").unwrap_or_else(|_| "-2600 -3400 5400 5200".into());
    std::fs::write(
        &out,
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' viewBox='{view}' width='1600' height='1540'><rect x='-20000' y='-20000' width='40000' height='40000' fill='#eee'/>{svg}</svg>"
        ),
    )?;
    Ok(())
}
