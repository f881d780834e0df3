//! The scene of a finished run, out of its log.

use super::archive::Archive;
use super::log::Log;
use crate::exchange::flights::flight_list;
use anyhow::{Context as _, ensure};
use models::flight_list::FlightList;
use scenarios::Scene;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Puts the scene into the log; a log without it shows everything, but cannot be forked where the scene is gone.
pub fn keep(log: &mut Log, scene: &Scene) {
    let kept = scene.sources().map_err(|e| e.to_string()).and_then(|sources| {
        let text = scene.path.file_name().map(|n| n.to_string_lossy().into_owned());
        log.fact("scene_file", &text.unwrap_or_default()).map_err(|e| e.to_string())?;
        let mut write = |(name, octets): &(String, Vec<u8>)| log.file(name, octets);
        sources.iter().try_for_each(&mut write).map_err(|e| e.to_string())
    });
    if let Err(reason) = kept {
        tracing::warn!("the scene is not in the log: {reason}");
    }
}

/// The scene of a run, without its truth, out of its log.
///
/// # Errors
/// The log does not hold it (it is of an earlier version), or it cannot be read.
pub fn load(archive: &Archive) -> anyhow::Result<Scene> {
    changed(archive, &[])
}

/// The same with the filter that a fork ended with, where the run is one.
///
/// # Errors
/// As [`load`] and [`changes`].
pub fn load_as_tracked(archive: &Archive) -> anyhow::Result<Scene> {
    let tracking = |c: &(String, String)| c.0.starts_with("tracking.");
    changed(archive, &changes(archive)?.into_iter().filter(tracking).collect::<Vec<_>>())
}

/// The same with all values of the scene that a fork changed, as it ended, where the run is one.
///
/// # Errors
/// As [`load`] and [`changes`].
pub fn load_as_changed(archive: &Archive) -> anyhow::Result<Scene> {
    let of_scene = changes(archive)?.into_iter().filter(|c| is_of_scene(&c.0));
    changed(archive, &of_scene.collect::<Vec<_>>())
}

/// Whether what a fork changes is a value of the scene: neither the weather as a whole, nor a seed, nor a sensor that is off.
#[must_use]
pub fn is_of_scene(key: &str) -> bool {
    !AMENDED.contains(&key) && !is_switch(key)
}

/// `sensor[NAME].enabled`.
#[must_use]
pub fn is_switch(key: &str) -> bool {
    key.starts_with("sensor[") && key.ends_with("].enabled")
}

/// Keys that are not values of the scene.
const AMENDED: [&str; 3] = ["weather.rain_factor", "weather.visibility_m", "run.sensor_seed"];

/// Keys and values that a fork changed in its parent's scene; none of a run that is no fork.
///
/// # Errors
/// The fork does not say so (it is of an earlier version).
pub fn changes(archive: &Archive) -> anyhow::Result<Vec<(String, String)>> {
    if archive.fact("fork").is_none_or(|parent| parent.is_empty()) {
        return Ok(Vec::new());
    }
    let kept = archive.fact(CHANGES).with_context(|| {
        let file = archive.path().display();
        format!("{file}: this fork is of an earlier version and does not say what it changed: fork its parent again")
    })?;
    Ok(serde_json::from_str(&kept)?)
}

fn changed(archive: &Archive, changes: &[(String, String)]) -> anyhow::Result<Scene> {
    let folder = empty_folder()?;
    let read = write(archive, &folder)
        .and_then(|(text, path)| Ok(scenarios::change::load_changed(&path, &text, changes)?));
    let _ = std::fs::remove_dir_all(&folder);
    read
}

/// The flight list of the scene, which knows where stands are; that of the log where the scene has none.
///
/// # Errors
/// If the database refuses.
pub fn flights(archive: &Archive, scene: &Scene) -> anyhow::Result<FlightList> {
    if !scene.flight_list.entries.is_empty() {
        return Ok(scene.flight_list.clone());
    }
    let logged = archive.flights().context("the flight list of the log")?;
    Ok(flight_list(&logged, scene.flight_list.runways.clone()))
}

/// Fact of a fork's log: what it changed, as JSON pairs of key and value.
pub const CHANGES: &str = "changes_json";

/// An empty folder of this process's own.
fn empty_folder() -> std::io::Result<PathBuf> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("seeds-scene-{}-{number}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// Puts the scene of a run and its files, as the log has them, into `scene/` of a folder: the text, and where it lies.
///
/// # Errors
/// The log does not hold them, or they cannot be written.
pub fn write(archive: &Archive, folder: &Path) -> anyhow::Result<(String, PathBuf)> {
    let files = archive.files().context("reading the scene out of the log")?;
    let scene = archive.fact("scene_file").unwrap_or_default();
    ensure!(
        !scene.is_empty() && files.iter().any(|f| f.0 == scene),
        "{}: the log does not hold the scene of the run (it is of an earlier version)",
        archive.path().display()
    );
    let inside = folder.join("scene");
    for (name, octets) in &files {
        let plain = Path::new(name).components().all(|c| matches!(c, Component::Normal(_)));
        ensure!(plain, "{name}: not a name of a file in the scene's folder");
        let file = inside.join(name);
        if let Some(of) = file.parent() {
            std::fs::create_dir_all(of).with_context(|| format!("making {}", of.display()))?;
        }
        std::fs::write(&file, octets).with_context(|| format!("writing {}", file.display()))?;
    }
    let path = inside.join(&scene);
    let text = std::fs::read_to_string(&path)?;
    Ok((text, path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::log::tests::Folder;
    use crate::viewer_logger::picture::{AirportMap, RunInfo};

    #[test]
    fn what_is_shown_of_a_fork_is_of_its_own_scene() {
        let folder = Folder::new();
        let parent = scenarios::load_without_truth(&scenarios::locate("asmgcs")).expect("a scene");
        let of = |name: &str, fork: Option<&str>, changes: &[(&str, &str)]| {
            let file = folder.0.join(name);
            let info = RunInfo { fork: fork.map(str::to_owned), ..RunInfo::default() };
            let mut log = Log::create(&file, &info, &AirportMap::default()).expect("a log");
            keep(&mut log, &parent);
            log.fact(CHANGES, &serde_json::json!(changes).to_string()).expect("written");
            log.close().expect("closed");
            load_as_changed(&Archive::open(&file).expect("opened")).expect("read").hash
        };
        let own = of("own.sqlite", None, &[("tracking.filter", "abg")]);
        assert_eq!(own, parent.hash, "a run that is no fork");
        let radar = &parent.sensors.iter().find(|s| s.asde.is_some()).expect("a radar").name;
        let off = format!("sensor[{radar}].enabled");
        let beside = [("weather.rain_factor", "2"), ("run.sensor_seed", "3"), (&off, "false")];
        assert_eq!(of("beside.sqlite", Some("a"), &beside), parent.hash);
        let all = [beside[0], ("tracking.filter", "abg")];
        let changed = of("changed.sqlite", Some("a"), &all);
        assert_ne!(changed, parent.hash);
        assert_eq!(changed, of("alone.sqlite", Some("a"), &all[1..]));
    }
}
