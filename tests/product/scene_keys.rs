//! No key of a scene is nominal: each one, given another value in a scene that calls for it, changes what is said of it.
//!
//! Said by a run's last line, by the plan of its effects, or by its log.
//! `scene_keys.toml` holds the scenes and what some keys need beyond them; all others are tried with values from their limits.

use crate::common::{Background, Folder, Ports, SOON, finish, run, seeds, stderr};
use models::keys::{Holds, Key, PLACE};
use models::sensors::KINDS;
use scenarios::keys::{ROOT, TABLES};
use socket2::{Domain, Protocol, Socket, Type};
use std::collections::BTreeMap;
use std::io::Read;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use toml::{Table, Value};

const CASES: &str = include_str!("scene_keys/cases.toml");

/// A key with its path from the root of a scene ("tracking.q"), of a sensor by its kind ("sensor.gps.level").
struct Asked {
    name: String,
    key: Key,
}

fn below(prefix: &str, keys: &[Key], all: &mut Vec<Asked>) {
    for key in keys {
        let name = format!("{prefix}.{}", key.word);
        match key.holds {
            Holds::Table(inner) | Holds::Tables(inner) | Holds::Places(inner)
                if !inner.is_empty() =>
            {
                below(&name, inner, all);
            }
            // Places are the same everywhere: asked once.
            Holds::Place => below(&name, PLACE, all),
            Holds::Open => {}
            _ => all.push(Asked { name, key: *key }),
        }
    }
}

fn every_key() -> Vec<Asked> {
    let mut all = Vec::new();
    all.extend(ROOT.iter().map(|key| Asked { name: key.word.to_owned(), key: *key }));
    for table in TABLES {
        below(table.word, table.keys, &mut all);
    }
    for declared in KINDS {
        let keys: Vec<Key> = declared.kind.keys.iter().flat_map(|group| group.to_vec()).collect();
        below(&format!("sensor.{}", declared.kind.word), &keys, &mut all);
    }
    all
}

/// What `scene_keys.toml` says of a key, or of all below a word.
#[derive(Default)]
struct Called {
    /// The scene that it is tried in.
    scene: Table,
    /// The values that it is tried with; none: from its limits. An empty text takes the key out.
    values: Vec<Option<Value>>,
    /// What is said where one of these is refused: that is all that the key does.
    refused: Option<String>,
    /// A test that tries it where no single run can.
    tested: Option<String>,
}

/// `above` put over `scene`: tables are merged, an empty text takes a key out, everything else is replaced.
fn put_over(scene: &mut Table, above: Table) {
    for (word, value) in above {
        match (scene.get_mut(&word), value) {
            (Some(Value::Table(below)), Value::Table(value)) => put_over(below, value),
            (_, Value::String(text)) if text.is_empty() => {
                scene.remove(&word);
            }
            (_, value) => {
                scene.insert(word, value);
            }
        }
    }
}

pub(crate) fn shipped(name: &str) -> Table {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenarios/{name}.toml"));
    std::fs::read_to_string(file).expect("a shipped scene").parse().expect("TOML")
}

fn called(cases: &Table, name: &str) -> Called {
    let list = |word: &str| cases[word].as_array().into_iter().flatten();
    let text =
        |row: &Value, word: &str| row.get(word).map(|v| v.as_str().expect("a text").to_owned());
    let covers = |row: &&Value| {
        let of = row["of"].as_array().into_iter().flatten();
        of.filter_map(Value::as_str).any(|w| name == w || name.starts_with(&format!("{w}.")))
    };
    // The last one goes before: it is the nearer.
    let scene = list("scene").rfind(covers);
    let scene = scene.unwrap_or_else(|| panic!("{name}: no [[scene]] is for it"));
    let mut out =
        Called { scene: shipped(&text(scene, "from").expect("from")), ..Called::default() };
    let put = |scene: &mut Table, row: &Value| {
        let above = text(row, "with").unwrap_or_default();
        put_over(scene, above.parse().unwrap_or_else(|e| panic!("{name}: {e}")));
    };
    put(&mut out.scene, scene);
    if let Some(row) = list("key").find(|row| row["key"].as_str() == Some(name)) {
        put(&mut out.scene, row);
        (out.tested, out.refused) = (text(row, "tested"), text(row, "refused"));
        out.values = row.get("values").and_then(Value::as_array).map_or(vec![], |values| {
            let value = |v: &Value| match v.as_str() {
                Some("") => None,
                _ => Some(v.clone()),
            };
            values.iter().map(value).collect()
        });
    }
    out
}

/// The scenes that keys are tried in, by the first key that each is for, but for those that need a recording or take long.
pub(crate) fn scenes() -> Vec<(String, Table)> {
    let cases: Table = CASES.parse().expect("TOML");
    let rows = cases["scene"].as_array().expect("scenes");
    let first = |row: &Value| row["of"][0].as_str().expect("a key").to_owned();
    let rest = ["sensor.file", "tracking.scan_budget_ms"];
    let names = rows.iter().map(first).filter(|name| !rest.contains(&name.as_str()));
    names.map(|name| (name.clone(), called(&cases, &name).scene)).collect()
}

/// A scene in a file of its own, with what else it needs.
pub(crate) fn written(folder: &Folder, number: usize, scene: &Table) -> String {
    Said { folder, number }.written(scene)
}

/// Other values of a key, by its limits, near ones first.
fn values(key: &Key, now: Option<&Value>) -> Vec<Option<Value>> {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|v| v as f64));
    let now_is = now.and_then(number).or_else(|| key.default.parse().ok());
    let near = |least: f64, most: f64| {
        let mut all = Vec::new();
        if let Some(v) = now_is {
            all.extend([v * 1.7, v * 0.6, v * 3.0, v + 1.0, v - 1.0]);
        }
        if most.is_finite() {
            if least > 0.0 {
                all.push((least * most).sqrt());
            }
            all.extend([least + 0.3 * (most - least), least + 0.01 * (most - least), least, most]);
        } else {
            all.extend([least, 2.0 * least + 3.0, least + 100.0]);
        }
        all.retain(|v| (least..=most).contains(v));
        all
    };
    match key.holds {
        Holds::Number { least, most } => {
            near(least, most).into_iter().map(|v| Some(Value::Float(v))).collect()
        }
        Holds::Whole { least, most } => near(least as f64, most as f64)
            .into_iter()
            .map(|v| Some(Value::Integer((v as i64).clamp(least, most))))
            .collect(),
        Holds::Flag => [true, false].map(|v| Some(Value::Boolean(v))).to_vec(),
        Holds::Word(words) => {
            let word = |w: &&str| Some(Value::String((*w).to_owned()));
            words().iter().map(word).filter(|w| w.as_ref() != now).collect()
        }
        _ => Vec::new(),
    }
}

/// Where a key stands in a scene: of a list of tables in the last one.
fn put(table: &mut Table, path: &[&str], value: Option<Value>) {
    let (last, above) = path.split_last().expect("a path");
    let mut table = table;
    for word in above {
        let inner = table.entry(*word).or_insert_with(|| Value::Table(Table::new()));
        table = match inner {
            Value::Array(list) => list.last_mut().and_then(Value::as_table_mut).expect("a table"),
            inner => inner.as_table_mut().expect("a table"),
        };
    }
    match value {
        Some(value) => table.insert((*last).to_owned(), value),
        None => table.remove(*last),
    };
}

fn held<'a>(table: &'a Table, path: &[&str]) -> Option<&'a Value> {
    let (first, rest) = path.split_first()?;
    let value = table.get(*first)?;
    match (rest, value) {
        ([], _) => Some(value),
        (_, Value::Table(inner)) => held(inner, rest),
        (_, Value::Array(list)) => held(list.last()?.as_table()?, rest),
        _ => None,
    }
}

/// Files of a scene that lies elsewhere, by whole paths.
fn with_whole_paths(table: &mut Table) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    for (word, value) in table.iter_mut() {
        match value {
            Value::String(text)
                if ["layout", "ground_network", "file"].contains(&word.as_str())
                    && folder.join(&*text).exists() =>
            {
                *text = folder.join(&*text).display().to_string();
            }
            Value::Table(inner) => with_whole_paths(inner),
            Value::Array(list) => {
                list.iter_mut().filter_map(Value::as_table_mut).for_each(with_whole_paths);
            }
            _ => {}
        }
    }
}

/// One of a queue of cars.
fn car(number: i64) -> Value {
    let way = ["Terminal_A_Gate_48", "D_57", "Terminal_A_Gate_48"];
    let mut car = Table::new();
    car.insert("kind".to_owned(), "route".into());
    car.insert("callsign".to_owned(), format!("CAR{number}").into());
    car.insert("type".to_owned(), "FOLLOWME".into());
    car.insert("via".to_owned(), way.map(Value::from).to_vec().into());
    car.insert("start_s".to_owned(), (1 + number % 40).into());
    car.into()
}

/// A scene in a folder of its own, and what is said of it.
struct Said<'a> {
    folder: &'a Folder,
    number: usize,
}

impl Said<'_> {
    fn file(&self, what: &str) -> String {
        self.folder.file(&format!("{}{what}", self.number))
    }

    fn written(&self, scene: &Table) -> String {
        let mut scene = scene.clone();
        if let Some(Value::Integer(cars)) = scene.remove("cars") {
            scene.insert("traffic".to_owned(), (0..cars).map(car).collect::<Vec<_>>().into());
        }
        if let Some(Value::Table(files)) = scene.remove("files") {
            for (name, text) in files {
                std::fs::write(self.folder.file(&name), text.as_str().expect("text"))
                    .expect("written");
            }
        }
        with_whole_paths(&mut scene);
        let path = self.file(".toml");
        std::fs::write(&path, scene.to_string()).expect("written");
        path
    }

    /// The last line of the run, without what a clock says.
    fn by_the_run(&self, scene: &str) -> Result<String, String> {
        let ports = Ports::new();
        let output = finish(run(&ports, &[scene, "--fast", "--no-viewer", "--in-process"]));
        if output.status.code() != Some(0) {
            return Err(stderr(&output));
        }
        let mut summary = crate::common::summary(&output);
        let object = summary.as_object_mut().expect("an object");
        for clock in ["wall_s", "rate", "scene"] {
            object.remove(clock);
        }
        Ok(summary.to_string())
    }

    fn by_the_plan(scene: &str) -> String {
        let mut command = seeds();
        command.args(["plan", scene, "--json", "--all"]);
        String::from_utf8_lossy(&finish(piped(command)).stdout).into_owned()
    }

    /// Every row of the log but what a clock says and what holds the scene's text.
    fn by_the_log(&self, scene: &str) -> Result<String, String> {
        let ports = Ports::new();
        let recording = self.file("/run.pcapng");
        let output = finish(run(&ports, &[scene, "--fast", "--no-viewer", "--record", &recording]));
        if output.status.code() != Some(0) {
            return Err(stderr(&output));
        }
        let log = rusqlite::Connection::open(self.file("/run.sqlite")).expect("a log");
        let mut tables =
            log.prepare("SELECT name FROM sqlite_master WHERE type = 'table'").expect("tables");
        let names: Vec<String> =
            tables.query_map([], |row| row.get(0)).expect("names").flatten().collect();
        let mut out = Vec::new();
        for name in names {
            if ["federates", "files", "scans", "states", "statistics"].contains(&name.as_str()) {
                continue;
            }
            let mut query = log.prepare(&format!("SELECT * FROM {name}")).expect("a table");
            let columns = query.column_count();
            let row = |row: &rusqlite::Row<'_>| -> rusqlite::Result<String> {
                (0..columns).map(|c| Ok(shown(row.get_ref(c)?))).collect()
            };
            let rows = query.query_map([], row).expect("rows").flatten();
            let of_this_run = |row: &String| OF_THIS_RUN.iter().any(|w| row.starts_with(w));
            out.extend(
                rows.filter(|row| name != "run" || !of_this_run(row))
                    .map(|row| format!("{name} {row}")),
            );
        }
        let _ = std::fs::remove_dir_all(self.file(""));
        out.sort_unstable();
        Ok(out.join("\n"))
    }
}

/// Rows of the table `run` that two runs of one scene have differently, or that hash its text.
const OF_THIS_RUN: [&str; 5] =
    ["command_line ", "datagrams_recorded ", "scene ", "scene_digest ", "scene_file "];

fn shown(value: rusqlite::types::ValueRef<'_>) -> String {
    match value {
        rusqlite::types::ValueRef::Text(text) => format!("{} ", String::from_utf8_lossy(text)),
        value => format!("{value:?} "),
    }
}

fn piped(mut command: std::process::Command) -> std::process::Command {
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    command
}

/// What is said of a scene that several keys are tried in, made once.
#[derive(Clone)]
struct Base {
    run: Result<String, String>,
    plan: String,
}

type Bases = Mutex<BTreeMap<String, Base>>;

fn base(bases: &Bases, said: &Said<'_>, scene: &Table) -> Base {
    let text = scene.to_string();
    if let Some(base) = bases.lock().expect("no other panics").get(&text) {
        return base.clone();
    }
    let written = said.written(scene);
    let base = Base { run: said.by_the_run(&written), plan: Said::by_the_plan(&written) };
    bases.lock().expect("no other panics").insert(text, base.clone());
    base
}

/// Why a key seems to do nothing; nothing where it does.
fn nominal(
    asked: &Asked,
    cases: &Table,
    folder: &Folder,
    bases: &Bases,
    number: usize,
) -> Option<String> {
    let name = &asked.name;
    let called = called(cases, name);
    if let Some(test) = &called.tested {
        return (!stands_in_the_sources(test)).then(|| format!("{name}: there is no test {test}"));
    }
    let mut path: Vec<&str> = name.split('.').collect();
    if path[0] == "sensor" && KINDS.iter().any(|d| d.kind.word == path[1]) {
        path[1] = "overrides";
    }
    let said = Said { folder, number };
    let Base { run, plan } = base(bases, &said, &called.scene);
    let before = match run {
        Ok(before) => before,
        Err(error) => return Some(format!("{name}: the scene itself is refused: {error}")),
    };
    let explicit = !called.values.is_empty();
    let tried =
        if explicit { called.values } else { values(&asked.key, held(&called.scene, &path)) };
    let (mut refused, mut log) = (Vec::new(), None);
    for value in &tried {
        let mut scene = called.scene.clone();
        put(&mut scene, &path, value.clone());
        let written = said.written(&scene);
        match said.by_the_run(&written) {
            Ok(after) if after != before => return None,
            Ok(_) => {}
            Err(error) if called.refused.as_ref().is_some_and(|said| error.contains(said)) => {
                return None;
            }
            Err(error) => {
                refused.push(error);
                continue;
            }
        }
        if Said::by_the_plan(&written) != plan {
            return None;
        }
        let after = said.by_the_log(&written);
        let log = log.get_or_insert_with(|| said.by_the_log(&said.written(&called.scene)));
        if after != *log {
            return None;
        }
    }
    let refused = refused.first().map_or(String::new(), |e| format!("; refused: {}", e.trim()));
    Some(format!("{name}: {} values, all the same{refused}", tried.len()))
}

fn stands_in_the_sources(test: &str) -> bool {
    fn holds(folder: &Path, text: &str) -> bool {
        std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| {
            let path = entry.path();
            if path.is_dir() {
                return holds(&path, text);
            }
            path.extension().is_some_and(|e| e == "rs")
                && std::fs::read_to_string(&path).is_ok_and(|source| source.contains(text))
        })
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    ["tests", "federates", "scenarios", "models/src"]
        .iter()
        .any(|folder| holds(&root.join(folder), &format!("fn {test}()")))
}

#[test]
fn every_key_of_a_scene_changes_what_is_said() {
    let cases: Table = CASES.parse().expect("TOML");
    let all = every_key();
    // One by name while a case is written: SEEDS_KEY=tracking.q.
    let only = std::env::var("SEEDS_KEY").ok();
    let chosen = |name: &str| only.as_ref().is_none_or(|only| name.starts_with(only.as_str()));
    let listed = cases["key"].as_array().expect("cases");
    for row in listed {
        let name = row["key"].as_str().expect("a name");
        assert!(all.iter().any(|a| a.name == name), "cases.toml: {name} is not a key");
    }
    let (folder, bases) = (Folder::new("scene-keys"), Bases::default());
    if all.iter().any(|a| a.name.starts_with("sensor.") && chosen(&a.name)) {
        for (file, seed) in [("theirs.ast", "1"), ("others.ast", "2")] {
            let what = ["--fast", "--duration", "30", "--seed", seed, "--no-viewer"];
            let mut recorded = run(&Ports::new(), &what);
            recorded.args(["--asterix-record", &folder.file(file)]);
            assert_eq!(finish(recorded).status.code(), Some(0), "{file}");
        }
    }
    // Every third one here, which one by its name; all of them (six minutes of two cores) by SEEDS_KEY= (CONTRIBUTING).
    let sampled = |name: &str| only.is_some() || name.bytes().map(u32::from).sum::<u32>() % 3 == 0;
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(2, usize::from) {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(asked) = all.get(number) else { break };
                    if !chosen(&asked.name) || !sampled(&asked.name) {
                        continue;
                    }
                    if let Some(why) = nominal(asked, &cases, &folder, &bases, number) {
                        found.lock().expect("no other panics").push(why);
                    }
                }
            });
        }
    });
    assert!(all.len() > 330, "{} keys", all.len());
    let found = found.into_inner().expect("no other panics");
    assert!(found.is_empty(), "{} keys do nothing:\n{}", found.len(), found.join("\n"));
}

/// What the law above stands on: of one scene everything is said twice alike.
#[test]
fn of_one_scene_the_same_is_said_twice() {
    let cases: Table = CASES.parse().expect("TOML");
    let folder = Folder::new("scene-said");
    let scene = called(&cases, "control.sees").scene;
    let said = |number| {
        let said = Said { folder: &folder, number };
        let written = said.written(&scene);
        (said.by_the_run(&written), Said::by_the_plan(&written), said.by_the_log(&written))
    };
    let (run, plan, log) = said(1);
    assert!(run.is_ok() && plan.len() > 100, "{run:?}");
    assert!(log.as_ref().is_ok_and(|log| log.lines().count() > 1000), "{log:?}");
    let (again, plan_again, log_again) = said(2);
    assert_eq!((run, plan), (again, plan_again));
    let (log, log_again) = (log.expect("a log"), log_again.expect("a log"));
    let other = log.lines().zip(log_again.lines()).find(|(a, b)| a != b);
    assert!(log == log_again, "{other:?}");
}

/// A scene says where its planes are: federates that are given nothing but the scene find each other there, and PDUs leave as it says.
#[test]
fn a_scene_says_where_its_planes_are() {
    let folder = Folder::new("scene-planes");
    for bundle in [false, true] {
        let (ports, group) = (Ports::new(), Ipv4Addr::new(239, 19, 7, 3));
        let mut scene = shipped("zurich");
        let network = format!(
            "network = {{ dis = [\"{group}:{}\"], interface = \"127.0.0.1\", ttl = 3, bundle = {bundle}, sync_listen = [\"{}\"], sync_connect = [\"{}\"] }}",
            ports.dis_port, ports.sync, ports.sync
        );
        put_over(&mut scene, network.parse().expect("TOML"));
        let scene = Said { folder: &folder, number: usize::from(bundle) }.written(&scene);
        let heard = Heard::at(group, ports.dis_port);
        let part = |name: &str, more: &[&str]| {
            let mut command = seeds();
            crate::common::patient(&mut command).args([name, "--scene", &scene]).args(more);
            Background::start(command)
        };
        let mut station = part("admin-station", &["--fast", "--duration", "20", "--batch"]);
        let _members = ["traffic-generator", "external-world", "smdfm"].map(|name| part(name, &[]));
        assert_eq!(station.wait(SOON), Some(0), "they meet at {}", ports.sync);
        let (together, hops) = heard.end();
        assert!(together > 0, "PDUs at {group}:{}", ports.dis_port);
        assert_eq!(together > 1, bundle, "{together} PDUs in one datagram");
        assert!(hops.is_none_or(|hops| hops == 3), "{hops:?} routers");
    }
}

/// What arrives at a multicast group on loopback.
struct Heard {
    over: Arc<AtomicBool>,
    thread: std::thread::JoinHandle<(usize, Option<u8>)>,
}

impl Heard {
    fn at(group: Ipv4Addr, port: u16) -> Self {
        let socket = |kind| -> std::io::Result<Socket> {
            let socket = Socket::new(Domain::IPV4, kind, Some(Protocol::UDP))?;
            socket.set_reuse_address(true)?;
            socket.join_multicast_v4(&group, &Ipv4Addr::LOCALHOST)?;
            socket.set_read_timeout(Some(Duration::from_millis(50)))?;
            Ok(socket)
        };
        let plain = socket(Type::DGRAM).expect("a socket");
        plain.bind(&SocketAddrV4::new(group, port).into()).expect("the group's port");
        // Whole datagrams, with their header; where this is allowed.
        let raw = socket(Type::RAW).ok();
        let over = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&over);
        let thread = std::thread::spawn(move || {
            let (mut together, mut hops, mut octets) = (0, None, [0; 65_536]);
            while !end.load(Ordering::Relaxed) {
                if let Ok(length) = (&plain).read(&mut octets) {
                    together = together.max(pdus_in(&octets[..length]));
                }
                let Some(raw) = &raw else { continue };
                if let Ok(length) = (&mut &*raw).read(&mut octets) {
                    let header = usize::from(octets[0] & 15) * 4;
                    let to = octets[..length].get(header + 2..header + 4);
                    if to == Some(&port.to_be_bytes()) {
                        hops = Some(octets[8]);
                    }
                }
            }
            (together, hops)
        });
        Self { over, thread }
    }

    /// The most PDUs of one datagram, and how many routers the last one may pass.
    fn end(self) -> (usize, Option<u8>) {
        self.over.store(true, Ordering::Relaxed);
        self.thread.join().expect("it hears")
    }
}

/// By the lengths in their headers.
fn pdus_in(mut octets: &[u8]) -> usize {
    let mut count = 0;
    while let Some(&[high, low]) = octets.get(8..10) {
        let length = usize::from(u16::from_be_bytes([high, low])).max(12);
        octets = octets.get(length..).unwrap_or_default();
        count += 1;
    }
    count
}
