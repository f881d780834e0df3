//! Federates on other hosts, started by agents there; here on loopback: who may ask an agent, what one command starts and ends, and what
//! becomes of an agent's processes.

use crate::common;

use crate::common::{
    Background, Folder, Ports, SOON, finish, free_port, run, seeds, stderr, summary, wait_for,
};
use federates::runtime::bus::ask;
use federates::runtime::certs::Certs;
use federates::runtime::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use serde_json::Value;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

/// An agent on a port of its own, and its endpoint.
fn agent(certs: Option<&Path>) -> (Background, String) {
    let port = free_port();
    let endpoint = format!("{}/127.0.0.1:{port}", if certs.is_some() { "tls" } else { "tcp" });
    let mut command = seeds();
    command.args(["agent", "--listen", &endpoint]);
    if let Some(folder) = certs {
        command.arg("--certs").arg(folder);
    }
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let agent = Background(command.spawn().expect("it starts"));
    let listens = || std::net::TcpStream::connect(("127.0.0.1", port)).ok();
    assert!(wait_for(SOON, listens).is_some(), "it listens");
    (agent, endpoint)
}

/// The command lines of the processes that `parent` has started, and whether they wait to be reaped.
fn children(parent: &Background) -> Vec<(i32, String, bool)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").expect("/proc").flatten() {
        let Ok(pid) = entry.file_name().to_string_lossy().parse::<i32>() else { continue };
        let stat = std::fs::read_to_string(entry.path().join("stat")).unwrap_or_default();
        let Some((_, fields)) = stat.rsplit_once(") ") else { continue };
        let fields: Vec<&str> = fields.split_whitespace().collect();
        if fields.get(1).and_then(|ppid| ppid.parse().ok()) == Some(parent.0.id()) {
            let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
            let line = String::from_utf8_lossy(&line).replace('\0', " ");
            found.push((pid, line, fields[0] == "Z"));
        }
    }
    found
}

/// Whether `parent` runs just these federates.
fn runs(parent: &Background, names: &[&str]) -> bool {
    let children = children(parent);
    let is_there = |name: &&str| {
        children.iter().any(|(_, line, dead)| !dead && line.contains(&format!(" {name} --")))
    };
    children.len() == names.len() && names.iter().all(is_there)
}

fn become_true(what: &str, mut is: impl FnMut() -> bool) {
    assert!(wait_for(SOON, || is().then_some(())).is_some(), "{what}");
}

fn certificates(folder: &Folder) -> std::path::PathBuf {
    let certs = folder.0.join("certs");
    let mut make = seeds();
    make.arg("certs").arg(&certs).stdout(Stdio::null()).stderr(Stdio::null());
    assert!(make.status().expect("it runs").success());
    certs
}

/// Two agents with certificates and a scene that names them: the run is that of one host; the agents outlive it, and the next run as well,
/// which is interrupted; nothing of either is left behind.
#[test]
fn one_command_starts_and_ends_federates_on_two_other_hosts() {
    let folder = Folder::new("agents");
    let certs = certificates(&folder);
    let ((first, b), (second, c)) = (agent(Some(&certs)), agent(Some(&certs)));
    let scene = folder.file("hosts.toml");
    let airport = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports/LZIB.apt.dat");
    let text = format!(
        "[run]\ntitle = \"hosts\"\nseed = 5\nduration_s = 60\n[airport]\nlayout = \"{airport}\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 20\ndepartures_per_h = 40\n"
    );
    std::fs::write(&scene, &text).expect("a scene");
    let alone = finish(run(&Ports::new(), &[&scene, "--in-process", "--fast"]));
    let agents = format!(
        "[network]\nagents = {{ smdfm = \"{b}\", external-world = \"{b}\", traffic-generator = \"{c}\" }}\n"
    );
    std::fs::write(&scene, text + &agents).expect("a scene");
    let ports = Ports::new();
    let with_certs = |arguments: &[&str]| {
        let mut command = seeds();
        command.args(["run", &scene, "--no-viewer", "--no-visitors", "--dis", &ports.dis]);
        command.args(["--sync-listen", &ports.sync.replace("tcp/", "tls/")]);
        command.arg("--certs").arg(&certs).args(arguments);
        command
    };
    let output = finish(with_certs(&["--fast"]));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(summary(&output)["digest"], summary(&alone)["digest"], "{}", stderr(&output));
    assert_eq!(summary(&output)["faults"], Value::Array(Vec::new()));
    become_true("all are ended and reaped", || runs(&first, &[]) && runs(&second, &[]));

    let mut command = with_certs(&["--rate", "1", "--wait"]);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let going = Background(command.spawn().expect("it starts"));
    become_true("the first has two", || runs(&first, &["smdfm", "external-world"]));
    become_true("the second has one", || runs(&second, &["traffic-generator"]));
    let launcher = common::processes(&ports.sync.replace("tcp/", "tls/"));
    assert!(launcher.len() >= 5, "launcher, station and three: {launcher:?}");
    going.interrupt();
    become_true("all are ended and reaped", || runs(&first, &[]) && runs(&second, &[]));
    become_true("nobody is left behind", || {
        common::processes(&ports.sync.replace("tcp/", "tls/")).is_empty()
    });
    assert_eq!(first.interrupt(), Some(0), "an agent ends when it is told to");
    assert_eq!(second.interrupt(), Some(0));
}

/// A federate that is killed on another host is started again there, by the policy; the digest is the undisturbed run's. Then the agent itself is
/// killed: what it had started ends with it, and the run misses it.
#[test]
fn a_federate_killed_on_another_host_is_started_again_there_and_ends_with_its_agent() {
    let (there, endpoint) = agent(None);
    let ports = Ports::new();
    let undisturbed = finish(run(&Ports::new(), &["--in-process", "--fast", "--duration", "200"]));
    let smdfm = format!("smdfm={endpoint}");
    let arguments = ["--rate", "4", "--duration", "200", "--no-viewer", "--no-visitors"];
    let mut command = run(&ports, &arguments);
    command.args(["--agents", &smdfm, "--on-loss", "takeover", "--stall-ms", "10000"]);
    let mut going = Background::start(command);
    let alive = |least: u64| {
        let status = common::status(&ports)?;
        let running = status["state"]["phase"] == "RUNNING";
        let members = status["state"]["members"].as_array()?;
        let smdfm = members.iter().find(|m| m["name"] == "smdfm" && m["alive"] == true)?;
        let (pid, frame) = (smdfm["pid"].as_i64()? as i32, smdfm["frame"].as_u64()?);
        (running && frame > least).then_some((pid, frame))
    };
    let (pid, frame) = wait_for(SOON, || alive(20)).expect("it runs");
    assert!(children(&there).iter().any(|(child, ..)| *child == pid), "on the other host");
    common::kill("KILL", pid);
    let (again, _) = wait_for(SOON, || alive(frame + 60).filter(|(new, _)| *new != pid))
        .unwrap_or_else(|| panic!("{:?}", common::status(&ports)));
    assert!(children(&there).iter().any(|(child, ..)| *child == again), "there again");
    assert!(runs(&there, &["smdfm"]), "the killed one is reaped: {:?}", children(&there));
    assert!(common::operate(&ports, &["rate", "fast"]).0);
    let stdout = going.0.stdout.take().expect("piped");
    assert_eq!(going.wait(SOON), Some(0), "made good: no failure");
    let text = std::io::read_to_string(stdout).expect("its words");
    let line = text.lines().find(|l| l.starts_with('{')).expect("a summary");
    let found: Value = serde_json::from_str(line).expect("JSON");
    assert_eq!(found["digest"], summary(&undisturbed)["digest"], "{line}");

    let mut command = run(&ports, &["--rate", "4", "--no-viewer", "--no-visitors"]);
    command.args(["--agents", &smdfm, "--return-ms", "none"]);
    let going = Background::start(command);
    let (pid, _) = wait_for(SOON, || alive(20)).expect("the same agent, the next run");
    common::kill("KILL", there.0.id() as i32);
    become_true("it ends with its agent", || !Path::new(&format!("/proc/{pid}")).exists());
    become_true("the run misses it", || {
        common::status(&ports).is_some_and(|status| status["state"]["phase"] == "FROZEN")
    });
    going.interrupt();
}

/// Only the station's certificate is answered; who stands on the same list as another, or on none, is not. What is not to be started is refused
/// with words, an agent that is not there is named, and one beyond this host needs certificates.
#[test]
fn an_agent_obeys_nobody_but_the_station() {
    let folder = Folder::new("agents-refuse");
    let certs = certificates(&folder);
    let (there, endpoint) = agent(Some(&certs));
    let answered = |name: &str| {
        let bus = ZenohBus::open(&ZenohConfig {
            part: Part::Peer,
            listen: Vec::new(),
            connect: vec![endpoint.clone()],
            exercise: 0,
            connect_timeout: Duration::from_secs(5),
            certs: Some(Certs::of(&certs, name).expect("there")),
        })
        .expect("a connection");
        let tries = if name == "admin-station" { 20 } else { 2 };
        let within = Duration::from_millis(500);
        (0..tries).any(|_| ask(&bus, "agent/do", vec![0], within).expect("a bus").is_some())
    };
    assert!(answered("admin-station"), "octets that are no question get an answer, too");
    for name in ["operator", "viewer-logger", "smdfm", "traffic-generator", "agent"] {
        assert!(!answered(name), "{name}");
    }
    assert!(runs(&there, &[]));

    let others = Folder::new("agents-others");
    let strangers = certificates(&others);
    let ports = Ports::new();
    let sync = ports.sync.replace("tcp/", "tls/");
    let refused = |certs: Option<&Path>, more: &[&str]| {
        let mut command = seeds();
        command.args(["run", "zurich", "--no-viewer", "--dis", &ports.dis]).args(more);
        if let Some(certs) = certs {
            command.arg("--certs").arg(certs).args(["--sync-listen", &sync]);
        } else {
            command.args(["--sync-listen", &ports.sync]);
        }
        let output = finish(command);
        (output.status.code(), stderr(&output))
    };
    let (code, words) = refused(Some(&strangers), &["--agents", &endpoint]);
    assert_eq!(code, Some(1), "{words}");
    assert!(
        words.contains("no agent answers at") && words.contains("seeds certs check"),
        "{words}"
    );
    let (code, words) = refused(None, &["--agents", "smdfm=tcp/127.0.0.1:9"]);
    assert_eq!(code, Some(1), "{words}");
    assert!(words.contains("seeds agent --listen tcp/127.0.0.1:9"), "{words}");
    let (code, words) = refused(None, &["--agents", "smdfm=tls/10.0.0.2:7450"]);
    assert!(code == Some(2) && words.contains("needs certificates"), "{code:?}: {words}");
    assert!(runs(&there, &[]), "nothing was started");

    let mut open = seeds();
    open.args(["agent", "--listen", "tcp/0.0.0.0:0"]);
    let output = finish(open);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("needs --certs DIR"), "{}", stderr(&output));
}
