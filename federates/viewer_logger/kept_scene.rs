//! The scene of a finished run, out of its log.

use super::archive::Archive;
use anyhow::{Context as _, ensure};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// The scene of a run, without its truth, out of its log.
///
/// # Errors
/// The log does not hold it (it is of an earlier version), or it cannot be read.
pub fn load(archive: &Archive) -> anyhow::Result<scenarios::Scene> {
    let folder = empty_folder()?;
    let read =
        write(archive, &folder).and_then(|(_, path)| Ok(scenarios::load_without_truth(&path)?));
    let _ = std::fs::remove_dir_all(&folder);
    read
}

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
