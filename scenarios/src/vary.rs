//! A scene with one value changed, for studies that vary a key.

/// The text of a scene with the value of `key` set: `tracking.profile`, `sensor.0.update_s`, `sensor.Radar North.rpm`.
///
/// Parts of a key are separated by dots; a list is entered by number from 0, or by the `name` or `kind` of its table. A key that is not
/// there is added, so that the scene's reader judges it. `value` is read as TOML, else taken as text.
///
/// # Errors
/// If the text is not TOML, or the key leads through something that is neither table nor list.
pub fn with_key(text: &str, key: &str, value: &str) -> Result<String, String> {
    let mut root: toml::Table =
        text.parse().map_err(|e: toml::de::Error| e.message().to_owned())?;
    let parts: Vec<&str> = key.split('.').collect();
    let Some((last, path)) = parts.split_last().filter(|(last, _)| !last.is_empty()) else {
        return Err(format!(
            "{key:?} is not a valid key; for example tracking.profile or sensor.0.site"
        ));
    };
    let written = match path.split_first() {
        None => {
            root.insert((*last).to_owned(), parsed(value));
            return toml::to_string(&root).map_err(|e| e.to_string());
        }
        Some((first, rest)) => {
            let start =
                root.entry((*first).to_owned()).or_insert_with(|| toml::Table::new().into());
            rest.iter().try_fold(start, |node, part| enter(node, part, key))
        }
    };
    match written? {
        toml::Value::Table(table) => drop(table.insert((*last).to_owned(), parsed(value))),
        toml::Value::Array(list) => {
            let count = list.len();
            let place = last.parse::<usize>().ok().and_then(|i| list.get_mut(i));
            *place.ok_or_else(|| {
                format!("{key}: {last:?} is not a number from 0 to below {count}")
            })? = parsed(value);
        }
        _ => return Err(format!("{key}: what stands before {last:?} is neither table nor list")),
    }
    toml::to_string(&root).map_err(|e| e.to_string())
}

fn enter<'a>(
    node: &'a mut toml::Value,
    part: &str,
    key: &str,
) -> Result<&'a mut toml::Value, String> {
    match node {
        toml::Value::Table(table) => {
            Ok(table.entry(part.to_owned()).or_insert_with(|| toml::Table::new().into()))
        }
        toml::Value::Array(list) => {
            let named = |v: &toml::Value| {
                ["name", "kind"]
                    .iter()
                    .any(|n| v.get(n).and_then(toml::Value::as_str) == Some(part))
            };
            let by_name = list.iter().position(named);
            let place = part.parse().ok().filter(|i| *i < list.len()).or(by_name);
            let names: Vec<&str> =
                list.iter().filter_map(|v| v.get("name").or(v.get("kind"))?.as_str()).collect();
            let there = names.join(", ");
            match place {
                Some(place) => Ok(&mut list[place]),
                None => {
                    Err(format!("{key}: no {part:?}; there are 0 to below {}: {there}", list.len()))
                }
            }
        }
        _ => Err(format!("{key}: what stands before {part:?} is neither table nor list")),
    }
}

fn parsed(value: &str) -> toml::Value {
    let whole: Result<toml::Table, _> = format!("x = {value}").parse();
    let alone = whole.ok().filter(|table| table.len() == 1).and_then(|mut table| table.remove("x"));
    alone.unwrap_or_else(|| value.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "[run]\nseed = 1\n[[sensor]]\nkind = \"asde\"\nrpm = 60\nsite = [1.0, 2.0]\n[[sensor]]\nkind = \"gps\"\n";

    fn value(key: &str, to: &str, pointer: &[&str]) -> String {
        let text = with_key(SCENE, key, to).expect(key);
        let table: toml::Value = toml::Value::Table(text.parse().expect("TOML"));
        let found = pointer.iter().fold(&table, |node, part| match part.parse::<usize>() {
            Ok(i) => &node[i],
            Err(_) => &node[*part],
        });
        found.to_string()
    }

    #[test]
    fn keys_are_found_by_name_and_number() {
        assert_eq!(value("run.seed", "7", &["run", "seed"]), "7");
        assert_eq!(value("sensor.0.rpm", "20.5", &["sensor", "0", "rpm"]), "20.5");
        assert_eq!(value("sensor.gps.sigma_m", "3", &["sensor", "1", "sigma_m"]), "3");
        assert_eq!(value("sensor.asde.site.1", "-4.0", &["sensor", "0", "site", "1"]), "-4.0");
        assert_eq!(value("tracking.profile", "accurate", &["tracking", "profile"]), "\"accurate\"");
        assert_eq!(value("run.title", "\"7\"", &["run", "title"]), "\"7\"");
        assert_eq!(value("run.title", "a\nb = 2", &["run", "title"]), "\"\"\"\na\nb = 2\"\"\"");
    }

    #[test]
    fn what_leads_nowhere_is_said() {
        for (key, words) in [
            ("sensor.2.rpm", "0 to below 2: asde, gps"),
            ("sensor.mlat.rpm", "no \"mlat\""),
            ("run.seed.x", "neither table nor list"),
            ("sensor.0.site.7", "below 2"),
            ("", "not a valid key"),
            ("run.", "not a valid key"),
        ] {
            let refused = with_key(SCENE, key, "1").expect_err(key);
            assert!(refused.contains(words), "{key}: {refused}");
        }
        assert!(with_key("= 3", "run.seed", "1").is_err());
    }
}
