//! The report of a run: HTML, CSV and JSON made from its database.

use anyhow::Context;
use rusqlite::{Connection, OpenFlags, types::ValueRef};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::Path;

/// Rows of a query as JSON objects.
fn rows(database: &Connection, query: &str) -> anyhow::Result<Vec<Map<String, Value>>> {
    let mut statement = database.prepare(query)?;
    let names: Vec<String> = statement.column_names().map(str::to_owned).collect();
    let mut found = statement.query([])?;
    let mut all = Vec::new();
    while let Some(row) = found.next()? {
        let mut object = Map::new();
        for (i, name) in names.iter().enumerate() {
            let value = match row.get_ref(i)? {
                ValueRef::Null | ValueRef::Blob(_) => Value::Null,
                ValueRef::Integer(n) => json!(n),
                ValueRef::Real(x) => json!(x),
                ValueRef::Text(text) => json!(String::from_utf8_lossy(text)),
            };
            object.insert(name.clone(), value);
        }
        all.push(object);
    }
    Ok(all)
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Number(n) => {
            n.as_f64().filter(|_| !n.is_i64()).map_or_else(|| n.to_string(), |x| format!("{x:.3}"))
        }
        other => other.to_string(),
    }
}

fn csv(rows: &[Map<String, Value>]) -> String {
    let Some(first) = rows.first() else { return String::new() };
    let quoted = |text: &str| {
        if text.contains([',', '"', '\n']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let mut out = first.keys().map(|k| quoted(k)).collect::<Vec<_>>().join(",") + "\n";
    for row in rows {
        let line: Vec<_> = row
            .values()
            .map(|v| match v {
                Value::Number(n) => n.to_string(),
                other => quoted(&cell(other)),
            })
            .collect();
        out += &(line.join(",") + "\n");
    }
    out
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn table(title: &str, rows: &[Map<String, Value>]) -> String {
    let mut out = format!("<h2>{}</h2>", escaped(title));
    let Some(first) = rows.first() else { return out + "<p>none</p>" };
    out += "<table><thead><tr>";
    for key in first.keys() {
        let _ = write!(out, "<th>{}</th>", escaped(key));
    }
    out += "</tr></thead><tbody>";
    for row in rows.iter().take(500) {
        out += "<tr>";
        for value in row.values() {
            let _ = write!(out, "<td>{}</td>", escaped(&cell(value)));
        }
        out += "</tr>";
    }
    out + "</tbody></table>"
}

/// Every table and view of the database as CSV and JSON, the small ones on one page.
///
/// # Errors
/// If the database cannot be read or a file not written.
pub fn write(folder: &Path, database: &Path) -> anyhow::Result<()> {
    let doing = || format!("writing the report into {}", folder.display());
    std::fs::create_dir_all(folder).with_context(doing)?;
    let connection = Connection::open_with_flags(database, OpenFlags::SQLITE_OPEN_READ_ONLY)
        .with_context(|| format!("reading {}", database.display()))?;
    let names = rows(
        &connection,
        "SELECT name, type FROM sqlite_master WHERE type IN ('table', 'view') AND name NOT LIKE 'sqlite_%' ORDER BY type DESC, name",
    )?;
    let mut page = String::new();
    let mut everything = Map::new();
    for entry in names {
        let name = cell(&entry["name"]);
        let found = rows(&connection, &format!("SELECT * FROM \"{}\"", name.replace('"', "")))?;
        std::fs::write(folder.join(format!("{name}.csv")), csv(&found)).with_context(doing)?;
        if found.len() <= 500 {
            page += &table(&name, &found);
            everything.insert(name, json!(found));
        } else {
            let _ = write!(
                page,
                "<h2>{}</h2><p>{} rows: see <a href=\"{name}.csv\">{name}.csv</a></p>",
                escaped(&name),
                found.len()
            );
        }
    }
    let html = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>SEEDS run</title><style>{STYLE}</style><h1>SEEDS run</h1>{page}</html>"
    );
    std::fs::write(folder.join("report.html"), html).with_context(doing)?;
    let text = serde_json::to_string_pretty(&everything)?;
    std::fs::write(folder.join("report.json"), text).with_context(doing)
}

const STYLE: &str = "body{font:14px system-ui,sans-serif;margin:2rem;max-width:1200px;color:#1b2430}\
h1,h2{font-weight:600}table{border-collapse:collapse;font-size:12px;margin:.5rem 0 1.5rem;display:block;overflow:auto}\
th,td{padding:3px 8px;border-bottom:1px solid #d5dbe3;text-align:right;white-space:nowrap}\
th{background:#eef2f6;position:sticky;top:0}td:first-child,th:first-child{text-align:left}";
