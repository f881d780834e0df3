//! What the browser may ask for: the files of `web/`, inside the executable.
//!
//! For work on the page itself the variable `SEEDS_WEB` may name a folder: files are then read from there at each
//! request, so that a change needs a reload only.

use std::borrow::Cow;
use std::path::{Component, Path};

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const DATA: &str = "application/json";
const FONT: &str = "font/woff2";
const PICTURE: &str = "image/svg+xml";

macro_rules! files {
    ($($path:literal $kind:expr;)*) => { &[$(($path, $kind, include_bytes!(concat!("web/", $path)))),*] };
}

/// Path, type and octets of everything the browser may ask for.
const FILES: &[(&str, &str, &[u8])] = files! {
    "index.html" HTML;
    "style.css" STYLE;
    "main.js" SCRIPT;
    "link.js" SCRIPT;
    "local.js" SCRIPT;
    "frame.js" SCRIPT;
    "hook.js" SCRIPT;
    "keys.js" SCRIPT;
    "state.js" SCRIPT;
    "switches.js" SCRIPT;
    "takeaway.js" SCRIPT;
    "address.js" SCRIPT;
    "alerts.js" SCRIPT;
    "position.js" SCRIPT;
    "strips.js" SCRIPT;
    "camera.js" SCRIPT;
    "closeup.js" SCRIPT;
    "export.js" SCRIPT;
    "eye.js" SCRIPT;
    "eye_gl.js" SCRIPT;
    "eye_light.js" SCRIPT;
    "eye_scene.js" SCRIPT;
    "eye_see.js" SCRIPT;
    "paint.js" SCRIPT;
    "situation.js" SCRIPT;
    "time.js" SCRIPT;
    "tools.js" SCRIPT;
    "traffic.js" SCRIPT;
    "eye.html" HTML;
    "eye.css" STYLE;
    "line.js" SCRIPT;
    "labels.js" SCRIPT;
    "map.js" SCRIPT;
    "panels.js" SCRIPT;
    "curve.js" SCRIPT;
    "dial.js" SCRIPT;
    "panes.js" SCRIPT;
    "text.js" SCRIPT;
    "icon.svg" PICTURE;
    "vendor/uPlot.iife.min.js" SCRIPT;
    "vendor/uPlot.min.css" STYLE;
    "vendor/b612-latin-400-normal.woff2" FONT;
    "vendor/b612-latin-700-normal.woff2" FONT;
    "vendor/b612-mono-latin-400-normal.woff2" FONT;
    "vendor/b612-mono-latin-700-normal.woff2" FONT;
};

/// Type and octets of the file at a path of the address.
#[must_use]
pub fn find(path: &str) -> Option<(&'static str, Cow<'static, [u8]>)> {
    let name = match path.strip_prefix('/')? {
        "" => "index.html",
        "eye" => "eye.html",
        name => name,
    };
    if let Some(folder) = std::env::var_os("SEEDS_WEB") {
        return in_folder(Path::new(&folder), name);
    }
    FILES.iter().find(|f| f.0 == name).map(|f| (f.1, Cow::Borrowed(f.2)))
}

fn in_folder(folder: &Path, name: &str) -> Option<(&'static str, Cow<'static, [u8]>)> {
    let plain = Path::new(name).components().all(|c| matches!(c, Component::Normal(_)));
    let octets = std::fs::read(folder.join(name)).ok().filter(|_| plain)?;
    let kind = match Path::new(name).extension()?.to_str()? {
        "html" => HTML,
        "js" => SCRIPT,
        "css" => STYLE,
        "json" => DATA,
        "woff2" => FONT,
        "svg" => PICTURE,
        _ => return None,
    };
    Some((kind, Cow::Owned(octets)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_script_of_the_folder_is_inside_the_executable() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("federates/viewer_logger/web");
        let mut count = 0;
        for entry in std::fs::read_dir(&folder).expect("the folder").flatten() {
            let name = entry.file_name().into_string().expect("a name");
            if entry.path().is_file() {
                assert!(
                    FILES.iter().any(|f| f.0 == name),
                    "{name} is not in the list of assets.rs"
                );
                count += 1;
            }
        }
        assert!(count >= 10);
    }

    #[test]
    fn a_path_out_of_the_folder_finds_nothing() {
        for path in ["/../mod.rs", "//etc/passwd", "/vendor/../../mod.rs", "", "/nothing.js"] {
            assert!(find(path).is_none(), "{path}");
            let web = Path::new(env!("CARGO_MANIFEST_DIR")).join("federates/viewer_logger/web");
            let name = path.strip_prefix('/').unwrap_or("..");
            assert!(in_folder(&web, name).is_none(), "{path}");
        }
        assert_eq!(find("/").map(|f| f.0), Some(HTML));
    }
}
