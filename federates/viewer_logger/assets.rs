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

/// Path and octets of everything the browser may ask for: all files of the folder, listed by the build.
const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/web_files.rs"));

/// Type and octets of the file at a path of the address.
#[must_use]
pub fn find(path: &str) -> Option<(&'static str, Cow<'static, [u8]>)> {
    let name = match path.strip_prefix('/')? {
        "" => "index.html",
        "eye" => "eye.html",
        "author" => "author.html",
        name => name,
    };
    if let Some(folder) = std::env::var_os("SEEDS_WEB") {
        return in_folder(Path::new(&folder), name);
    }
    let (_, octets) = FILES.iter().find(|file| file.0 == name)?;
    Some((kind(name)?, Cow::Borrowed(*octets)))
}

/// Type of a file by its ending; `None` where nobody may have it.
fn kind(name: &str) -> Option<&'static str> {
    Some(match Path::new(name).extension()?.to_str()? {
        "html" => HTML,
        "js" => SCRIPT,
        "css" => STYLE,
        "json" => DATA,
        "woff2" => FONT,
        "svg" => PICTURE,
        _ => return None,
    })
}

fn in_folder(folder: &Path, name: &str) -> Option<(&'static str, Cow<'static, [u8]>)> {
    let plain = Path::new(name).components().all(|c| matches!(c, Component::Normal(_)));
    let octets = std::fs::read(folder.join(name)).ok().filter(|_| plain)?;
    Some((kind(name)?, Cow::Owned(octets)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_page_imports_is_inside_the_executable() {
        let mut imports = 0;
        for (name, octets) in FILES.iter().filter(|file| file.0.ends_with(".js")) {
            let text = String::from_utf8_lossy(octets);
            let folder = Path::new(name).parent().unwrap_or(Path::new(""));
            for from in text.split("from \"").skip(1).filter_map(|rest| rest.split('"').next()) {
                let path = if let Some(up) = from.strip_prefix("../") {
                    up.to_owned()
                } else {
                    folder.join(from.trim_start_matches("./")).to_string_lossy().into_owned()
                };
                let found = find(&format!("/{path}"));
                assert_eq!(found.map(|f| f.0), Some(SCRIPT), "{name} imports {from}");
                imports += 1;
            }
        }
        assert!(imports > 50, "{imports}");
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
