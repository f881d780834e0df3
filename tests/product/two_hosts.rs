//! Two hosts: traffic generator and external world on one, the rest on the other, joined by a bridge
//! of network namespaces that the test makes itself. Needs root; skipped with a word otherwise.

use crate::common;

use crate::common::{finish, summary};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

struct Hosts {
    names: [String; 2],
    tag: u32,
    bridge: String,
}

fn ip(arguments: &[&str]) -> bool {
    Command::new("ip")
        .args(arguments)
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

impl Hosts {
    /// A third namespace holds the bridge, so nothing of the real host is touched.
    fn new() -> Option<Self> {
        // The tests of this file run side by side.
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let tag = std::process::id() % 10_000 * 10 + NEXT.fetch_add(1, Ordering::Relaxed);
        let bridge = format!("sb{tag}");
        let names = [format!("sa{tag}"), format!("sc{tag}")];
        let made = ip(&["netns", "add", &bridge])
            && ip(&["-n", &bridge, "link", "add", "br0", "type", "bridge"])
            && ip(&["-n", &bridge, "link", "set", "br0", "up"]);
        let hosts = Self { names, tag, bridge };
        if !made {
            return None;
        }
        for (i, name) in hosts.names.iter().enumerate() {
            let (inner, outer) = (format!("v{i}{tag}"), format!("w{i}{tag}"));
            let address = format!("10.83.0.{}/24", i + 1);
            let ok = ip(&["netns", "add", name])
                && ip(&[
                    "link",
                    "add",
                    &inner,
                    "netns",
                    name,
                    "type",
                    "veth",
                    "peer",
                    "name",
                    &outer,
                    "netns",
                    &hosts.bridge,
                ])
                && ip(&["-n", &hosts.bridge, "link", "set", &outer, "master", "br0"])
                && ip(&["-n", &hosts.bridge, "link", "set", &outer, "up"])
                && ip(&["-n", name, "addr", "add", &address, "brd", "+", "dev", &inner])
                && ip(&["-n", name, "link", "set", &inner, "up"])
                && ip(&["-n", name, "link", "set", "lo", "up"]);
            if !ok {
                return None;
            }
        }
        Some(hosts)
    }

    /// The longest datagram that the interface of a host takes, with its head.
    fn mtu(&self, host: usize, octets: u32) -> bool {
        let interface = format!("v{host}{}", self.tag);
        ip(&["-n", &self.names[host], "link", "set", &interface, "mtu", &octets.to_string()])
    }

    fn on(&self, host: usize, arguments: &[&str]) -> Command {
        let mut command = Command::new("ip");
        command
            .args(["netns", "exec", &self.names[host], env!("CARGO_BIN_EXE_seeds")])
            .args(arguments)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .stdin(Stdio::null());
        command
    }
}

impl Drop for Hosts {
    fn drop(&mut self) {
        for name in self.names.iter().chain([&self.bridge]) {
            ip(&["netns", "del", name]);
        }
    }
}

#[test]
fn two_hosts_give_the_digest_of_one() {
    let Some(hosts) = Hosts::new() else {
        eprintln!("skipped: network namespaces cannot be made here (needs root and iproute2)");
        return;
    };
    let alone =
        finish(common::run(&common::Ports::new(), &["--fast", "--duration", "30", "--no-viewer"]));
    let reference = summary(&alone)["digest"].clone();

    for dis in
        ["10.83.0.255:3000", "239.83.0.1:3000", "10.83.0.1:3000,10.83.0.2:3000,10.83.0.2:3001"]
    {
        let network = |host: usize| {
            let interface = ["10.83.0.1", "10.83.0.2"][host];
            ["--dis", dis, "--interface", interface].map(str::to_owned)
        };
        let start = |host: usize, arguments: &[&str]| {
            let mut command = hosts.on(host, arguments);
            common::patient(&mut command).args(network(host));
            command.stdout(Stdio::null()).stderr(Stdio::null());
            common::Background(command.spawn().expect("it starts"))
        };
        let at = "tcp/10.83.0.2:7447";
        let mut admin = hosts.on(
            1,
            &[
                "admin-station",
                "--open",
                "--sync-listen",
                at,
                "--fast",
                "--duration",
                "30",
                "--batch",
            ],
        );
        admin.args(network(1));
        let admin = std::thread::spawn(move || finish(admin));
        let _smdfm = start(1, &["smdfm", "--open", "--sync-connect", at]);
        let _traffic = start(0, &["traffic-generator", "--open", "--sync-connect", at]);
        let _world = start(0, &["external-world", "--open", "--sync-connect", at]);
        let output = admin.join().expect("the administration station ends");
        assert_eq!(output.status.code(), Some(0), "{dis}: {}", common::stderr(&output));
        assert_eq!(summary(&output)["digest"], reference, "{dis}");
    }
}

/// An SMDFM that listens in another group hears no truth: the run is exact by repair, and both hosts are told.
#[test]
fn an_smdfm_in_the_wrong_group_is_told_of_and_the_run_is_exact() {
    let Some(hosts) = Hosts::new() else {
        eprintln!("skipped: network namespaces cannot be made here (needs root and iproute2)");
        return;
    };
    let alone =
        finish(common::run(&common::Ports::new(), &["--fast", "--duration", "60", "--no-viewer"]));
    let at = "tcp/10.83.0.2:7447";
    let start = |host: usize, group: &str, arguments: &[&str]| {
        let mut command = hosts.on(host, arguments);
        let interface = ["10.83.0.1", "10.83.0.2"][host];
        common::patient(&mut command).args(["--dis", group, "--interface", interface]);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        common::Background(command.spawn().expect("it starts"))
    };
    let (right, wrong) = ("239.83.0.1:3000", "239.83.0.2:3000");
    let mut admin = hosts.on(
        1,
        &[
            "admin-station",
            "--open",
            "--sync-listen",
            at,
            "--rate",
            "8",
            "--duration",
            "60",
            "--batch",
            // A busy host is none of this test's subjects, and ends a batch.
            "--stall-ms",
            "20000",
        ],
    );
    admin.args(["--dis", right, "--interface", "10.83.0.2"]);
    let admin = std::thread::spawn(move || finish(admin));
    let mut smdfm = start(0, wrong, &["smdfm", "--open", "--sync-connect", at]);
    let _traffic = start(1, right, &["traffic-generator", "--open", "--sync-connect", at]);
    let _world = start(1, right, &["external-world", "--open", "--sync-connect", at]);
    let output = admin.join().expect("the administration station ends");
    assert_eq!(output.status.code(), Some(0), "{}", common::stderr(&output));
    assert_eq!(summary(&output)["digest"], summary(&alone)["digest"], "exact by repair");
    smdfm.wait(common::SOON);
    let mut said = String::new();
    use std::io::Read;
    smdfm.0.stderr.take().expect("piped").read_to_string(&mut said).expect("text");
    for producer in ["traffic-generator", "external-world"] {
        let words = format!("smdfm hears none of {producer}'s PDUs on {wrong} via 10.83.0.1");
        assert!(said.contains(&words), "{said}");
    }
    assert!(said.contains("wrong group, interface or firewall"), "{said}");
}

/// One host takes datagrams up to 1280 octets, the other sends some of 1400: nobody refuses them, they are just not there. It is said at the start,
/// with what to do, by the consumer and by the administration station on the other host; the same hosts with one MTU say nothing.
#[test]
fn a_smaller_mtu_on_one_host_is_told_and_the_run_is_exact() {
    let alone =
        finish(common::run(&common::Ports::new(), &["--fast", "--duration", "30", "--no-viewer"]));
    for mtu in [1280, 1500] {
        let Some(hosts) = Hosts::new() else {
            eprintln!("skipped: network namespaces cannot be made here (needs root and iproute2)");
            return;
        };
        assert!(hosts.mtu(0, mtu), "an interface");
        let (at, group) = ("tcp/10.83.0.2:7447", "239.83.0.1:3000");
        let start = |host: usize, arguments: &[&str]| {
            let mut command = hosts.on(host, arguments);
            let interface = ["10.83.0.1", "10.83.0.2"][host];
            common::patient(&mut command).args(["--dis", group, "--interface", interface]);
            command.args(["--open", "--sync-connect", at]);
            command.stdout(Stdio::null()).stderr(Stdio::piped());
            common::Background(command.spawn().expect("it starts"))
        };
        let mut admin = hosts.on(1, &["admin-station", "--open", "--sync-listen", at]);
        admin.args(["--rate", "8", "--duration", "30", "--batch", "--stall-ms", "20000"]);
        admin.args(["--dis", group, "--interface", "10.83.0.2"]);
        let admin = std::thread::spawn(move || finish(admin));
        let mut smdfm = start(0, &["smdfm"]);
        let _traffic = start(1, &["traffic-generator"]);
        let _world = start(1, &["external-world"]);
        let output = admin.join().expect("the administration station ends");
        assert_eq!(output.status.code(), Some(0), "{}", common::stderr(&output));
        assert_eq!(summary(&output)["digest"], summary(&alone)["digest"]);
        smdfm.wait(common::SOON);
        let mut said = String::new();
        use std::io::Read;
        smdfm.0.stderr.take().expect("piped").read_to_string(&mut said).expect("text");
        for producer in ["traffic-generator", "external-world"] {
            let words = format!("smdfm hears short PDUs of {producer} on {group} via 10.83.0.1");
            assert_eq!(said.contains(&words), mtu == 1280, "{mtu}: {said}");
        }
        assert_eq!(said.contains("ip link set dev INTERFACE mtu 1500"), mtu == 1280, "{said}");
        assert!(!said.contains("hears none of"), "{said}");
    }
}

/// Two hosts that cannot reach each other, and a third that both reach: all speak through the router there, with certificates and without, and a
/// command from a third terminal as well. The run is that of one host, and all processes end.
#[test]
fn hosts_that_cannot_reach_each_other_meet_at_a_router() {
    let Some(hosts) = Hosts::new() else {
        eprintln!("skipped: network namespaces cannot be made here (needs root and iproute2)");
        return;
    };
    let folder = common::Folder::new("router");
    let alone =
        finish(common::run(&common::Ports::new(), &["--fast", "--duration", "30", "--no-viewer"]));
    let between = &hosts.bridge;
    assert!(ip(&["-n", between, "addr", "add", "10.83.0.9/24", "dev", "br0"]), "an address");
    for (host, other) in [(0, "10.83.0.2/32"), (1, "10.83.0.1/32")] {
        assert!(ip(&["-n", &hosts.names[host], "route", "add", "unreachable", other]), "{other}");
    }
    let certs = folder.0.join("certs");
    let certs = certs.to_str().expect("a name");
    let mut make = common::seeds();
    make.args(["certs", certs, "--host", "10.83.0.9"]);
    assert_eq!(finish(make).status.code(), Some(0));
    for (transport, protection) in [("tcp", &["--open"][..]), ("tls", &["--certs", certs])] {
        let at = format!("{transport}/10.83.0.9:7447");
        let spawn = |mut command: Command| {
            command.stdout(Stdio::null()).stderr(Stdio::null());
            common::Background(command.spawn().expect("it starts"))
        };
        let on = |namespace: &str, arguments: &[&str]| {
            let mut command = Command::new("ip");
            command.args(["netns", "exec", namespace, env!("CARGO_BIN_EXE_seeds")]);
            command.args(arguments).args(protection);
            command.current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null());
            command
        };
        let router = spawn(on(between, &["router", "--listen", &at]));
        let federate = |host: usize, arguments: &[&str]| {
            let mut command = on(&hosts.names[host], arguments);
            let interface = ["10.83.0.1", "10.83.0.2"][host];
            command.args(["--sync-router", &at, "--dis", "10.83.0.255:3000"]);
            common::patient(&mut command).args(["--interface", interface]);
            command
        };
        let admin = federate(
            1,
            &["admin-station", "--rate", "4", "--duration", "30", "--batch", "--stall-ms", "20000"],
        );
        let admin = std::thread::spawn(move || finish(admin));
        let mut members = ["smdfm", "traffic-generator", "external-world"]
            .map(|name| (name, spawn(federate(usize::from(name == "smdfm"), &[name]))));
        let mut ask = hosts.on(0, &["admin-station", "status", "--json", "--at", &at]);
        if transport == "tls" {
            ask.args(protection);
        }
        let status = common::wait_for(common::SOON, || {
            let output = ask.output().expect("it runs");
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            (output.status.success() && text.contains("RUNNING")).then_some(text)
        });
        assert!(status.is_some(), "{transport}: a command through the router is answered");
        // The engine reads and writes a TLS connection without a lock: on one thread nothing can meet there.
        for pid in [&router.0, &members[0].1.0].map(std::process::Child::id) {
            let threads = common::threads(pid);
            let engine = |name: &&String| ["rx-", "tx-"].iter().any(|n| name.starts_with(n));
            assert_eq!(threads.iter().any(|n| engine(&n)), transport == "tcp", "{threads:?}");
            assert!(
                threads.iter().any(|name| name.starts_with("app-")) || transport == "tcp",
                "{threads:?}"
            );
        }
        let output = admin.join().expect("the administration station ends");
        assert_eq!(output.status.code(), Some(0), "{}", common::stderr(&output));
        assert_eq!(summary(&output)["digest"], summary(&alone)["digest"], "{transport}");
        for (name, member) in &mut members {
            assert_eq!(member.wait(common::SOON), Some(0), "{transport}: {name} ends");
        }
        assert_eq!(router.interrupt(), Some(0), "{transport}: the router ends when it is told to");
    }
}

#[test]
fn what_goes_wrong_between_hosts_is_named_within_ten_seconds() {
    let Some(hosts) = Hosts::new() else {
        eprintln!("skipped: network namespaces cannot be made here (needs root and iproute2)");
        return;
    };
    for (arguments, words) in [
        (
            &[
                "smdfm",
                "--open",
                "--sync-connect",
                "tcp/10.83.0.77:7447",
                "--dis",
                "10.83.0.255:3000",
                "--interface",
                "10.83.0.1",
            ][..],
            "10.83.0.77",
        ),
        (
            &[
                "smdfm",
                "--open",
                "--sync-connect",
                "tcp/10.83.0.2:7447",
                "--dis",
                "10.83.0.255:3000",
                "--interface",
                "10.99.0.1",
            ],
            "10.99.0.1",
        ),
    ] {
        let mut command = hosts.on(0, arguments);
        let child =
            command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts");
        let mut background = common::Background(child);
        let code = background.wait(std::time::Duration::from_secs(15));
        assert_eq!(code, Some(1), "{arguments:?}");
        let mut text = String::new();
        use std::io::Read;
        background.0.stderr.take().expect("piped").read_to_string(&mut text).expect("text");
        assert!(text.contains(words), "{arguments:?}: {text}");
    }
}
