"""What `run` and `draw` share: mutants behind a switch, sources that are put back, tests that are stopped at the first failure."""
import contextlib, os, re, resource, signal, subprocess, sys, threading

# Goes to the end of the crate's root while mutants are in. With SEEDS_MUTANTS_REACHED the numbers that were asked for go to that file.
SWITCH = """
/// Which mutant is on.
pub mod mutant {
    use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

    /// Whether it is this one.
    pub fn on(number: usize) -> bool {
        static ON: std::sync::OnceLock<usize> = std::sync::OnceLock::new();
        static REACHED: std::sync::OnceLock<Option<String>> = std::sync::OnceLock::new();
        static ASKED: [AtomicBool; COUNT] = [const { AtomicBool::new(false) }; COUNT];
        if let Some(file) = REACHED.get_or_init(|| std::env::var("SEEDS_MUTANTS_REACHED").ok())
            && !ASKED[number].load(Relaxed)
            && !ASKED[number].swap(true, Relaxed)
        {
            use std::io::Write;
            let file = std::fs::OpenOptions::new().create(true).append(true).open(file);
            file.and_then(|mut f| f.write_all(format!("{number}\\n").as_bytes())).expect("written");
        }
        *ON.get_or_init(|| std::env::var("SEEDS_MUTANT").ok().and_then(|n| n.parse().ok()).unwrap_or(0)) == number
    }
}
"""

# What `noticed` says of tests that a limit stopped.
ENDLESS = "that it does not end in time"

# The random tests draw the same cases for every mutant, and none is made smaller.
ENVIRONMENT = dict(
    os.environ,
    PROPTEST_RNG_SEED=os.environ.get("PROPTEST_RNG_SEED", "1999"),
    RUST_BACKTRACE="0",
    PROPTEST_MAX_SHRINK_ITERS="0",
    PROPTEST_DISABLE_FAILURE_PERSISTENCE="1",
    INSTA_UPDATE="no",
)


def switch(count):
    """The text of the switch for mutants 1 to `count`."""
    return SWITCH.replace("COUNT", str(count + 1))


@contextlib.contextmanager
def put_in(before, after):
    """The texts of `after` in the files while the body runs; those of `before` when it ends, however it ends."""
    def leave(number, _frame):
        sys.exit(128 + number)
    handlers = {s: signal.signal(s, leave) for s in (signal.SIGTERM, signal.SIGHUP)}
    try:
        for file, text in after.items():
            file.write_text(text)
        yield
    finally:
        for file, text in before.items():
            if file.read_text() != text:
                file.write_text(text)
        for number, handler in handlers.items():
            signal.signal(number, handler)


def noticed(command, environment, within_s, cwd, processor_s=None, bytes_at_most=None):
    """The first test that fails; empty if all hold."""
    def limits():
        if processor_s:
            resource.setrlimit(resource.RLIMIT_CPU, (processor_s, processor_s))
        if bytes_at_most:
            resource.setrlimit(resource.RLIMIT_AS, (bytes_at_most, bytes_at_most))
    tests = subprocess.Popen(command, cwd=cwd, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, preexec_fn=limits)
    late = threading.Timer(within_s, tests.kill)
    late.start()
    try:
        for line in tests.stdout:
            failed = re.match(r"test (\S+)(?: - should panic)? \.\.\. FAILED", line)
            if failed:
                tests.kill()
                return failed[1]
        code = tests.wait()
    finally:
        late.cancel()
        tests.kill()
        tests.wait()
    if code in (-signal.SIGKILL, -signal.SIGXCPU):
        return ENDLESS
    return "" if code == 0 else "its abort"
