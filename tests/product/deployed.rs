//! Compose file and chart: every command line in them is one that the executables take, names and ports agree between their files,
//! and pods that are evicted, one after the other, come back by the same command line to the same run.

#[path = "deployed/chart.rs"]
mod chart;

use crate::common;

use crate::common::{Background, Folder, Ports, SOON, finish, summary, wait_for};
use chart::{Chart, parsed};
use serde_json::Value;
use serde_yaml::Value as Yaml;
use std::collections::BTreeSet;
use std::io::{BufRead as _, Write as _};
use std::process::{Command, Stdio};
use std::time::Duration;

const STATEFUL: [&str; 7] = [
    "admin-station",
    "control",
    "external-world",
    "router",
    "smdfm",
    "traffic-generator",
    "viewer-logger",
];

/// Whether `seeds` takes this command line: with `--help` at its end it is read up to there, and nothing is started.
fn is_taken(line: &[String]) -> Result<(), String> {
    let mut command = common::seeds();
    command.args(line.iter().skip_while(|word| *word == "seeds")).arg("--help");
    let output = finish(command);
    if output.status.success() { Ok(()) } else { Err(common::stderr(&output)) }
}

/// A command line with what Kubernetes puts in the place of variables.
fn with_addresses(line: Vec<String>, address: &str, index: usize) -> Vec<String> {
    let word = |word: String| {
        let mut word = word.replace("$(POD_INDEX)", &index.to_string());
        for variable in ["$(POD_IP)", "$(SMDFM_SERVICE_HOST)", "$(VIEWER_LOGGER_SERVICE_HOST)"] {
            word = word.replace(variable, address);
        }
        word
    };
    line.into_iter().map(word).collect()
}

/// The value of `--exercise` in a command line.
fn exercise_of(line: &[String]) -> Option<String> {
    let text = line.join(" ").replace('=', " ");
    let mut words = text.split(' ').skip_while(|word| *word != "--exercise");
    words.nth(1).map(str::to_owned)
}

fn words(list: &Yaml) -> Vec<String> {
    let text = |word: &Yaml| word.as_str().unwrap_or_else(|| panic!("{word:?}")).to_owned();
    list.as_sequence().into_iter().flatten().map(text).collect()
}

#[test]
fn the_compose_file_says_what_the_executables_take() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docker-compose.yml");
    let text = std::fs::read_to_string(path).expect("the file");
    let of_ours = text.replace("${SEEDS_SCENE:-zurich}", "/scenes/own.toml");
    let of_ours = of_ours.replace("${SEEDS_EXERCISE:-1}", "9");
    let mut file = parsed(&of_ours).remove(0);
    file.apply_merge().expect("merged");
    let services = file["services"].as_mapping().expect("services");
    assert_eq!(services.len(), 6);
    assert_eq!(words(&services["control"]["profiles"]), ["control"]);
    let mut addresses = BTreeSet::new();
    for (name, service) in services {
        let name = name.as_str().expect("a name");
        let mut line = words(&service["entrypoint"]);
        line.extend(words(&service["command"]));
        assert_eq!(line[0], name);
        is_taken(&line).unwrap_or_else(|e| panic!("{name}: {line:?}: {e}"));
        let own = service["networks"]["federation"]["ipv4_address"].as_str().expect("an address");
        assert!(addresses.insert(own.to_owned()), "{name}: {own} twice");
        let interface = line.iter().skip_while(|word| *word != "--interface").nth(1);
        assert_eq!(interface.map(String::as_str), Some(own), "{name}");
        assert_eq!(service["restart"], "unless-stopped", "{name}");
        assert!(line.contains(&"/scenes/own.toml".to_owned()), "{name}");
        assert!(words(&service["volumes"]).iter().any(|v| v.ends_with(":/scenes:ro")), "{name}");
        assert_eq!(exercise_of(&line).as_deref(), Some("9"), "{name}");
        let test = words(&service["healthcheck"]["test"]);
        let asks = test.join(" ").contains("admin-station status");
        assert!(!asks || test.join(" ").contains("--exercise 9"), "{name}: {test:?}");
        assert!(service["healthcheck"]["interval"].is_string() && test.len() >= 2, "{name}");
        match name {
            "admin-station" => is_taken(&test[1..]).unwrap_or_else(|e| panic!("{test:?}: {e}")),
            "viewer-logger" => assert!(test[3].contains("/8600")),
            _ => {
                assert_eq!(service["environment"]["FEDERATE"], name);
                let asked: Vec<String> = test[1]
                    .split('|')
                    .next()
                    .map_or(vec![], |line| line.split_whitespace().map(str::to_owned).collect());
                is_taken(&asked).unwrap_or_else(|e| panic!("{asked:?}: {e}"));
            }
        }
    }
    // Everybody sends to the receivers, which listen where they are sent to.
    for receiver in ["smdfm", "viewer-logger"] {
        let own = &services[receiver]["networks"]["federation"]["ipv4_address"];
        let place = format!("{}:3000", own.as_str().expect("an address"));
        for sender in ["traffic-generator", "external-world", "admin-station", receiver] {
            let line = words(&services[sender]["command"]);
            assert!(line.iter().any(|word| word.contains(&place)), "{sender} to {receiver}");
        }
    }
    assert!(words(&services["viewer-logger"]["volumes"]).contains(&"runs:/seeds/runs".to_owned()));
    assert!(file["volumes"]["runs"].is_null() && !file["volumes"].is_null(), "it is declared");
    let docker = concat!(env!("CARGO_MANIFEST_DIR"), "/Dockerfile");
    let docker = std::fs::read_to_string(docker).expect("the file");
    assert!(docker.contains("-o 65534 -g 65534 /seeds/runs") && docker.contains("USER 65534"));
    for (name, _) in services {
        assert!(docker.contains(&format!(" {}", name.as_str().expect("a name"))), "{name:?}");
    }
}

#[test]
fn the_chart_says_what_the_executables_take_and_its_files_agree() {
    let all = Chart::read().rendered("exercise: 9");
    let of = |kind: &str, name: &str| {
        let found = all.iter().find(|o| o["kind"] == kind && o["metadata"]["name"] == name);
        found.unwrap_or_else(|| panic!("{kind} {name}"))
    };
    let mut names: Vec<&str> = all
        .iter()
        .filter(|object| object["kind"] == "StatefulSet")
        .filter_map(|object| object["metadata"]["name"].as_str())
        .collect();
    names.sort_unstable();
    assert_eq!(names, STATEFUL);
    let secrets = secrets_made();
    for name in STATEFUL {
        let set = &of("StatefulSet", name)["spec"];
        let pod = &set["template"]["spec"];
        let labels = &set["template"]["metadata"]["labels"];
        assert_eq!(set["selector"]["matchLabels"]["app.kubernetes.io/name"], name);
        assert_eq!(labels["app.kubernetes.io/name"], name);
        assert_eq!(labels["app.kubernetes.io/part-of"], "seeds");
        of("Service", set["serviceName"].as_str().expect("a name"));
        assert!(pod["terminationGracePeriodSeconds"].is_u64(), "{name}");
        assert_eq!(pod["securityContext"]["runAsNonRoot"], true, "{name}");
        let container = &pod["containers"][0];
        assert_eq!(container["securityContext"]["readOnlyRootFilesystem"], true, "{name}");
        let line = with_addresses(chart::line(container), "10.0.0.1", 1);
        is_taken(&line).unwrap_or_else(|e| panic!("{name}: {line:?}: {e}"));
        assert_eq!(exercise_of(&line).as_deref(), Some("9"), "{name}");
        for probe in ["readinessProbe", "livenessProbe"] {
            let (command, port) =
                (&container[probe]["exec"]["command"], &container[probe]["tcpSocket"]["port"]);
            if command.is_sequence() {
                let command = words(command);
                assert_eq!(exercise_of(&command).as_deref(), Some("9"), "{name}");
                is_taken(&command).unwrap_or_else(|e| panic!("{name}: {command:?}: {e}"));
            } else if let Some(port) = port.as_u64() {
                assert!(
                    line.iter().any(|word| word.ends_with(&format!(":{port}"))),
                    "{name} {port}"
                );
            }
        }
        // What a command line reads is mounted, and every volume that is mounted is there.
        let mounts = container["volumeMounts"].as_sequence().expect("mounts");
        let at = |place: &str| mounts.iter().any(|mount| mount["mountPath"] == place);
        assert!(at("/certs") && at("/scene") && at("/tmp"), "{name}: {mounts:?}");
        let volumes = pod["volumes"].as_sequence().expect("volumes").iter();
        let mut volumes: BTreeSet<&str> = volumes.filter_map(|v| v["name"].as_str()).collect();
        if set["volumeClaimTemplates"].is_sequence() {
            volumes.insert(
                set["volumeClaimTemplates"][0]["metadata"]["name"].as_str().expect("a name"),
            );
        }
        for mount in mounts {
            let volume = mount["name"].as_str().expect("a name");
            assert!(volumes.contains(volume), "{name}: {volume}");
        }
        let secret = &pod["volumes"][0]["secret"]["secretName"];
        assert!(
            secrets.contains(secret.as_str().expect("a name")),
            "{name}: {secret:?}: {secrets:?}"
        );
    }
    of("ConfigMap", "scene");
    assert!(
        of("ConfigMap", "scene")["data"]["scene.toml"]
            .as_str()
            .is_some_and(|s| s.contains("[airport]"))
    );
    // Variables are those that Kubernetes makes of the Services, and what the pod is told of itself; ports are those of the Services.
    for name in STATEFUL {
        let set = of("StatefulSet", name);
        for word in chart::line(&set["spec"]["template"]["spec"]["containers"][0]) {
            for part in word.split("$(").skip(1) {
                let (variable, rest) = part.split_once(')').expect("closed");
                let Some(service) = variable.strip_suffix("_SERVICE_HOST") else {
                    assert!(["POD_IP", "POD_INDEX"].contains(&variable), "{name}: {variable}");
                    continue;
                };
                let service = of("Service", &service.to_lowercase().replace('_', "-"));
                let port = service["spec"]["ports"][0]["port"].as_u64().expect("a port");
                let of_word = rest.trim_start_matches(':').split(',').next();
                assert_eq!(of_word, Some(&port.to_string()[..]), "{name}: {word}");
                assert_eq!(service["spec"]["ports"][0]["protocol"], "UDP", "{name}: {word}");
            }
            if let Some(router) = word.strip_prefix("--sync-router=tls/router:") {
                let service = of("Service", "router");
                assert_eq!(
                    service["spec"]["ports"][0]["port"].as_u64().map(|p| p.to_string()).as_deref(),
                    Some(router)
                );
            }
        }
    }
    for service in all.iter().filter(|o| o["kind"] == "Service") {
        let selected = service["spec"]["selector"]["app.kubernetes.io/name"].as_str();
        assert!(selected.is_none_or(|name| STATEFUL.contains(&name)), "{service:?}");
    }
    let values = std::fs::read_to_string(Chart::folder().join("Chart.yaml")).expect("a file");
    assert!(
        values.contains(&format!("version: {}\n", env!("CARGO_PKG_VERSION"))),
        "the package's version"
    );
}

/// The names of the Secrets that `deploy/secrets` makes of the certificates of two generators; every file that it names is there.
fn secrets_made() -> BTreeSet<String> {
    let folder = Folder::new("deployed-secrets");
    let certs = folder.file("certs");
    let mut command = common::seeds();
    command.args(["certs", &certs, "--host", "router", "--generators", "2"]);
    assert!(finish(command).status.success());
    let kubectl = folder.file("kubectl");
    std::fs::write(&kubectl, "#!/bin/sh\necho \"$@\"\n").expect("written");
    let mut command = Command::new("sh");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/deploy/secrets");
    command.args([
        "-c",
        &format!(
            "chmod +x {kubectl}; PATH={}:$PATH exec sh {script} {certs} --namespace air",
            folder.0.display()
        ),
    ]);
    let output = finish(command);
    assert!(output.status.success(), "{}", common::stderr(&output));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut names = BTreeSet::new();
    for line in said.lines() {
        let rest = line.strip_prefix("create secret generic ").unwrap_or_else(|| panic!("{line}"));
        names.extend(rest.split(' ').next().map(str::to_owned));
        for file in rest.split("--from-file=").skip(1).filter_map(|f| f.split(' ').next()) {
            assert!(std::path::Path::new(file).is_file(), "{file}");
        }
        assert!(line.ends_with("--namespace air"), "{line}");
    }
    assert!(said.contains("traffic-generator-2.key") && said.contains("operator.key"), "{said}");
    names
}

/// A pod on this host: the chart's command line with this host's addresses, started again whenever it ends, as the kubelet does.
struct Pod {
    name: String,
    line: Vec<String>,
    /// Where its words go.
    words: String,
    process: Background,
}

impl Pod {
    fn start(name: &str, line: &[String], folder: &Folder) -> Self {
        let words = folder.file("words");
        let process = Self::process(name, line, &words);
        Self { name: name.to_owned(), line: line.to_vec(), words, process }
    }

    fn process(name: &str, line: &[String], words: &str) -> Background {
        let mut file =
            std::fs::OpenOptions::new().append(true).create(true).open(words).expect("a file");
        writeln!(file, "{name} starts").expect("written");
        let mut command = common::seeds();
        command.args(line.iter().skip_while(|word| *word == "seeds"));
        command.stdout(Stdio::piped()).stderr(file);
        Background(command.spawn().expect("it starts"))
    }

    fn keep(&mut self) {
        if self.process.0.try_wait().ok().flatten().is_some() {
            self.process = Self::process(&self.name, &self.line, &self.words);
        }
    }

    /// What the kubelet of a drained node does, and the replacement on another one.
    fn evict(&mut self) {
        let pid = self.process.0.id() as i32;
        common::kill("TERM", pid);
        std::thread::sleep(Duration::from_millis(300));
        common::kill("KILL", pid);
        let _ = self.process.0.wait();
        self.process = Self::process(&self.name, &self.line, &self.words);
    }
}

#[test]
fn pods_that_are_evicted_one_after_the_other_return_to_the_same_run() {
    let folder = Folder::new("deployed-evicted");
    let certs = folder.file("certs");
    let mut command = common::seeds();
    command.args(["certs", &certs, "--host", "router", "--generators", "2"]);
    assert!(finish(command).status.success());
    let (ports, others) = (Ports::new(), [Ports::new(), Ports::new()]);
    let port = |text: &str| text.rsplit(':').next().unwrap_or_default().to_owned();
    let (sync, page) = (port(&ports.sync), port(&ports.page));
    // Three of UDP that nobody uses: the numbers of free TCP ports serve as well as any.
    let [station, smdfm] = others.each_ref().map(|p| port(&p.sync));
    let values = format!(
        "generators: 2\nrate: 4\nports:\n  sync: {sync}\n  station: {station}\n  smdfm: {smdfm}\n  viewer: {}\n  page: {page}\n",
        port(&others[0].page)
    );
    let chart = Chart::read();
    let all = chart.rendered(&values);
    let journal = folder.file("journal");
    std::fs::create_dir(&journal).expect("a volume");
    let scene = folder.file("scene.toml");
    let map = all.iter().find(|o| o["kind"] == "ConfigMap").expect("the scene");
    let text = map["data"]["scene.toml"].as_str().expect("text");
    std::fs::write(&scene, text.replace("duration_s = 600", "duration_s = 120")).expect("written");

    let undisturbed = {
        let mut command = common::seeds();
        command.args(["run", &scene, "--in-process", "--fast"]);
        summary(&finish(command))
    };
    let here = |line: Vec<String>, index: usize| -> Vec<String> {
        let word = |word: String| {
            word.replace("tls/router:", "tls/127.0.0.1:")
                .replace("0.0.0.0:", "127.0.0.1:")
                .replace("/certs", &certs)
                .replace("/scene/scene.toml", &scene)
                .replace("=/journal", &format!("={journal}"))
        };
        with_addresses(line, "127.0.0.1", index).into_iter().map(word).collect()
    };
    // Of the pods of a set, which begin with a number of its own, one.
    let line = |name: &str, pod: usize| {
        let set = all.iter().find(|o| o["kind"] == "StatefulSet" && o["metadata"]["name"] == name);
        let spec = &set.expect(name)["spec"];
        let index = spec["ordinals"]["start"].as_u64().unwrap_or(0) as usize + pod;
        here(chart::line(&spec["template"]["spec"]["containers"][0]), index)
    };
    let start = |name: &str, line: &[String]| Pod::start(name, line, &folder);
    let mut router = start("router", &line("router", 0));
    let mut station = start("admin-station", &line("admin-station", 0));
    let mut viewer = line("viewer-logger", 0);
    viewer.extend(["--record".to_owned(), folder.file("run.pcapng")]);
    let mut pods: Vec<Pod> = vec![
        start("traffic-generator-1", &line("traffic-generator", 0)),
        start("traffic-generator-2", &line("traffic-generator", 1)),
        start("external-world", &line("external-world", 0)),
        start("smdfm", &line("smdfm", 0)),
        start("viewer-logger", &viewer),
    ];
    let place =
        ["--at".to_owned(), format!("tls/127.0.0.1:{sync}"), "--certs".to_owned(), certs.clone()];
    let asked = |words: &[&str]| {
        let mut command = common::seeds();
        command.arg("admin-station").args(words).args(&place);
        finish(command)
    };
    let status = || -> Option<Value> {
        std::thread::sleep(Duration::from_millis(150));
        let output = asked(&["status", "--json"]);
        serde_json::from_slice(&output.stdout).ok()
    };
    // Process and frame of a member of a run that goes on.
    let runs = |name: &str| -> Option<(u64, u64)> {
        let state = status()?["state"].take();
        let member = state["members"].as_array()?.iter().find(|m| m["name"] == name)?;
        let on = state["phase"] == "RUNNING" && member["alive"] == true;
        on.then(|| Some((member["pid"].as_u64()?, member["frame"].as_u64()?)))?
    };
    let words = || std::fs::read_to_string(folder.file("words")).unwrap_or_default();
    for name in ["traffic-generator-2", "external-world", "smdfm"] {
        let before = wait_for(SOON, || {
            router.keep();
            pods.iter_mut().for_each(Pod::keep);
            runs(name).filter(|(_, frame)| *frame > 40)
        });
        let (pid, frame) = before.unwrap_or_else(|| panic!("{name}: {} {:?}", words(), status()));
        let pod = pods.iter_mut().find(|pod| pod.name == name).expect(name);
        pod.evict();
        let back = wait_for(SOON, || {
            router.keep();
            pod.keep();
            runs(name).filter(|(again, now)| *again != pid && *now > frame + 20)
        });
        assert!(back.is_some(), "{name}: {} {:?}", words(), status());
    }
    // The station: nobody else begins again.
    let (pid, frame) = wait_for(SOON, || runs("smdfm")).expect("it runs");
    station.evict();
    let back = wait_for(SOON, || {
        router.keep();
        station.keep();
        runs("smdfm").filter(|(_, now)| *now > frame + 40)
    });
    assert_eq!(back.map(|(again, _)| again), Some(pid), "{} {:?}", words(), status());
    let found = closed(&mut station.process, || asked(&["rate", "fast"]).status.success());
    same(&found, &undisturbed);
    let faults = found["faults"].as_array().expect("a list");
    let made_good = |fault: &Value| fault.as_str().is_some_and(|f| f.contains("back after"));
    assert!(faults.len() == 3 && faults.iter().all(made_good), "{faults:?}");
}

/// The summary of the run that this station closes, once it is let go.
fn closed(station: &mut Background, let_go: impl Fn() -> bool) -> Value {
    assert!(let_go());
    let stdout = std::io::BufReader::new(station.0.stdout.take().expect("piped"));
    let told = stdout.lines().map_while(Result::ok).find(|line| line.starts_with('{'));
    serde_json::from_str(&told.expect("a summary")).expect("JSON")
}

fn same(found: &Value, undisturbed: &Value) {
    for key in ["digest", "track_digest", "frames"] {
        assert!(!found[key].is_null() && found[key] == undisturbed[key], "{key}: {found}");
    }
}
