//! What the integration tests share: starting the launcher on ports of its own, reading its summary.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part of this")]

use serde_json::Value;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A folder of this test's own, removed at the end.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("seeds-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    pub fn file(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A port for whoever listens later.
pub fn free_port() -> u16 {
    datalink::free_port().expect("a free port")
}

/// Addresses that no other run on this host uses.
pub struct Ports {
    /// Synchronisation plane.
    pub sync: String,
    /// Data plane: broadcast that cannot leave the host.
    pub dis: String,
    /// Port of the data plane.
    pub dis_port: u16,
    /// Page.
    pub page: String,
}

impl Ports {
    pub fn new() -> Self {
        let dis_port = free_port();
        Self {
            sync: format!("tcp/127.0.0.1:{}", free_port()),
            dis: format!("127.255.255.255:{dis_port}"),
            dis_port,
            page: format!("127.0.0.1:{}", free_port()),
        }
    }
}

pub fn seeds() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seeds"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null());
    command
}

/// `seeds run` on ports of its own; "zurich" where the arguments do not begin with a scene.
pub fn run(ports: &Ports, arguments: &[&str]) -> Command {
    let mut command = seeds();
    command.arg("run");
    if arguments.first().is_none_or(|first| first.starts_with('-')) {
        command.arg("zurich");
    }
    command.args(arguments);
    command.args(["--sync-listen", &ports.sync, "--dis", &ports.dis, "--page", &ports.page]);
    command
}

/// Runs to the end; a run that takes longer than two minutes is killed.
pub fn finish(mut command: Command) -> Output {
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let pid = child.id();
    let (done, wait) = std::sync::mpsc::channel::<()>();
    let guard = std::thread::spawn(move || {
        if wait.recv_timeout(Duration::from_secs(120)).is_err() {
            let _ = Command::new("kill").args(["-9", &pid.to_string()]).status();
        }
    });
    let output = child.wait_with_output().expect("it ends");
    let _ = done.send(());
    let _ = guard.join();
    output
}

/// The last line on standard output as JSON.
pub fn summary(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().last().unwrap_or_else(|| {
        panic!("no line on stdout; stderr: {}", String::from_utf8_lossy(&output.stderr))
    });
    serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// How long a test waits for what comes at once where nothing else runs.
pub const SOON: Duration = Duration::from_secs(90);

/// A run in the background that ends with the test.
pub struct Background(pub Child);

impl Background {
    pub fn start(mut command: Command) -> Self {
        Self(command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("it starts"))
    }

    /// Ctrl-C, and the exit code.
    pub fn interrupt(mut self) -> Option<i32> {
        let _ = Command::new("kill").args(["-INT", &self.0.id().to_string()]).status();
        let code = wait_for(SOON, || self.0.try_wait().ok().flatten());
        code.and_then(|status| status.code())
    }

    pub fn wait(&mut self, within: Duration) -> Option<i32> {
        wait_for(within, || self.0.try_wait().ok().flatten()).and_then(|status| status.code())
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        let _ = Command::new("kill").args(["-TERM", &self.0.id().to_string()]).status();
        let ended = wait_for(Duration::from_secs(5), || self.0.try_wait().ok().flatten());
        if ended.is_none() {
            let _ = self.0.kill();
        }
        let _ = self.0.wait();
    }
}

/// Asks until there is an answer or time is up.
pub fn wait_for<T>(within: Duration, mut ask: impl FnMut() -> Option<T>) -> Option<T> {
    #[expect(clippy::disallowed_methods, reason = "a bound for waiting on other processes")]
    let until = Instant::now() + within;
    loop {
        if let Some(answer) = ask() {
            return Some(answer);
        }
        #[expect(clippy::disallowed_methods, reason = "a bound for waiting on other processes")]
        let now = Instant::now();
        if now >= until {
            return None;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn asked(ports: &Ports, arguments: &[&str]) -> Output {
    let mut command = seeds();
    command.arg("admin-station").args(arguments).args(["--at", &ports.sync]);
    finish(command)
}

/// A command to a run from a second terminal: success and its words. Where it found no connection within its three seconds, on
/// a busy machine, it was not given: it is given again.
pub fn operate(ports: &Ports, arguments: &[&str]) -> (bool, String) {
    let answered = wait_for(SOON, || {
        let output = asked(ports, arguments);
        let words = format!("{}{}", String::from_utf8_lossy(&output.stdout), stderr(&output));
        let given = !words.contains("nobody answers there");
        given.then(|| (output.status.success(), words.trim().to_owned()))
    });
    answered.unwrap_or_else(|| (false, "nobody answers there".to_owned()))
}

/// The run's statistics, once they can be had.
pub fn status(ports: &Ports) -> Option<Value> {
    let output = asked(ports, &["status", "--json"]);
    let text = String::from_utf8_lossy(&output.stdout);
    output.status.success().then(|| serde_json::from_str(&text).expect("JSON"))
}

/// A federate that a test starts by hand has the patience of one of a launcher: the station may be slow to start.
pub fn patient(command: &mut Command) -> &mut Command {
    command.env("SEEDS_LAUNCHED", std::process::id().to_string())
}

/// Processes whose command line holds `text`.
pub fn processes(text: &str) -> Vec<i32> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").expect("/proc").flatten() {
        let Ok(pid) = entry.file_name().to_string_lossy().parse::<i32>() else { continue };
        let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
        if String::from_utf8_lossy(&line).replace('\0', " ").contains(text) {
            found.push(pid);
        }
    }
    found
}

/// Names of the threads of a process.
pub fn threads(pid: u32) -> Vec<String> {
    let tasks = std::fs::read_dir(format!("/proc/{pid}/task")).expect("it lives").flatten();
    let name = |task: std::fs::DirEntry| std::fs::read_to_string(task.path().join("comm"));
    tasks.filter_map(|task| Some(name(task).ok()?.trim().to_owned())).collect()
}

pub fn kill(signal: &str, pid: i32) {
    let _ = Command::new("kill").args([&format!("-{signal}"), &pid.to_string()]).status();
}
