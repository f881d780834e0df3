//! Writes the picture of one turn of a scene's radar: `video SCENE.toml SECONDS FILE.png [RIM_M]`.

#![allow(clippy::print_stderr, reason = "a command-line example")]

use models::time::SimTime;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.as_slice() {
        [scene, at, file, rim @ ..] if rim.len() <= 1 => {
            match write(scene, at, file, rim.first()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => {
                    eprintln!("{error}");
                    ExitCode::FAILURE
                }
            }
        }
        _ => {
            eprintln!("video SCENE.toml SECONDS FILE.png [RIM_M]");
            ExitCode::from(2)
        }
    }
}

fn write(scene: &str, at: &str, file: &str, rim_m: Option<&String>) -> Result<(), String> {
    let number = |text: &str| text.parse::<f64>().map_err(|e| format!("{text}: {e}"));
    let scene = scenarios::load(Path::new(scene)).map_err(|e| e.to_string())?;
    let rim_m = rim_m.map(|text| number(text)).transpose()?;
    let octets = studies::picture::video_png(&scene, SimTime::from_s(number(at)?), 1200, rim_m)?;
    std::fs::write(file, octets).map_err(|e| format!("{file}: {e}"))
}
