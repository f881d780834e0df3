//! Rain cells from the scene's timeline to the scans, over several heartbeats.

use super::intake::Intake;
use crate::external_world::ExternalWorld;
use crate::runtime::codec::decode;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::messages::{Frame, RunConfig, WeatherNotice};
use models::environment::Weather;
use models::time::SimTime;
use std::path::Path;
use std::sync::Arc;

fn load() -> Arc<scenarios::Scene> {
    let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let text = format!(
        "[run]\ntitle = \"w\"\nseed = 7\nduration_s = 120\n[airport]\nlayout = \"{airports}/LZIB.apt.dat\"\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 1\ndepartures_per_h = 1\n[weather]\ntimeline = [\n\
         {{ at_s = 0, wind_mps = 20.3, wind_from_deg = 261, cells = [{{ east_m = -180, north_m = 1084, radius_m = 600, rain_mm_per_h = 100 }}] }},\n\
         {{ at_s = 70.02, visibility_m = 9000 }}]"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("weather.toml");
    Arc::new(scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn cells_go_with_the_wind_whichever_heartbeats_a_fusion_heard() {
    let scene = load();
    let last = scene.run.frames();
    let time = |frame: Frame| SimTime(scene.run.frame.0 * frame as i64);
    let mut world = ExternalWorld::new(Arc::clone(&scene), 1);
    let config = RunConfig { run: 1, seed: 7, last_frame: last, ..RunConfig::default() };
    // Who hears all, nothing but the changes, and who joins late.
    let mut hears: Vec<Intake> = (0..3).map(|_| Intake::of(&scene, 1)).collect();
    let (mut told, mut notices) = (Vec::new(), Vec::<WeatherNotice>::new());
    for frame in 0..=last {
        let mut out = FrameOut::default();
        match frame {
            0 => world.configure(&config, &mut out).expect("configured"),
            _ => world.step(frame, &FrameInputs::default(), &mut out),
        }
        let own = out.publish.iter().filter(|p| p.key == "obs/weather");
        notices.extend(own.map(|p| decode::<WeatherNotice>(&p.body).expect("a notice")));
        let change = scene
            .weather
            .iter()
            .any(|n| n.time <= time(frame) && frame > 0 && n.time > time(frame - 1));
        told.extend(out.pdus.iter().map(|_| frame));
        for (who, intake) in hears.iter_mut().enumerate() {
            let heard = [true, change || frame == 0, frame >= 500][who];
            let pdus = out.pdus.iter().filter(|_| heard).map(|o| (frame, o.clone())).collect();
            intake.take_in(&FrameInputs { pdus, ..FrameInputs::default() }, frame);
        }
        if !frame.is_multiple_of(20) {
            continue;
        }
        let notice = scene.weather.iter().rev().find(|n| n.time <= time(frame)).expect("one");
        let wanted = notice.weather.after(time(frame).since_s(notice.time));
        let found: Vec<Weather> = hears.iter_mut().map(|i| i.weather_at(frame)).collect();
        assert_eq!(found[0], wanted, "at {} s", time(frame).s());
        assert_eq!(found[1], wanted, "at {} s, changes alone", time(frame).s());
        // From the second heartbeat on.
        assert_eq!(found[2], if frame < 600 { Weather::default() } else { wanted.clone() });
        // Spectators are told the same.
        let notice = notices.last().expect("one");
        let since_s = (time(frame).0 - notice.from_ns) as f64 * 1e-9;
        let (there, own) = (&notice.cells[0], &wanted.cells[0]);
        let east_m = there[0] + notice.wind_mps[0] * since_s;
        assert!((east_m - own.centre_m.x).abs() < 1e-6, "{east_m} at {} s", time(frame).s());
    }
    assert!(told.len() >= 5, "changes and heartbeats: {told:?}");
}

/// What is repeated has the octets of the first time where nothing moves: digests of scenes without cells are as they were.
#[test]
fn a_weather_without_cells_has_the_same_octets_at_any_age() {
    use crate::exchange::weather_pdu::encode;
    let told = |weather: &Weather, since_s: f64| format!("{:?}", encode(weather, since_s, 1, 4));
    let mut weather = Weather { rain_mm_per_h: 3.0, ..Weather::default() };
    assert_eq!(told(&weather, 0.0), told(&weather, 30.0));
    weather.cells = load().weather[0].weather.cells.clone();
    assert_ne!(told(&weather, 0.0), told(&weather, 30.0));
}
