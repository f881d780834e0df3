//! A recorder that is killed at any moment leaves a file with all that it had flushed.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use capture::{Problem, Reader, Recorder};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// Names the file to the process that is going to be killed.
const FILE: &str = "CAPTURE_TEST_KILLED_FILE";

/// Not a test by itself: what the process does that is killed. Without the variable it does nothing.
#[test]
fn records_until_it_is_killed() {
    let Ok(file) = std::env::var(FILE) else { return };
    let mut recorder = Recorder::create(file).unwrap();
    let here = "10.0.0.7:4001".parse().unwrap();
    let mut out = std::io::stdout();
    for batch in 0..200_000u32 {
        for i in 0..40 {
            let number = batch * 40 + i;
            let mut payload = vec![0x5a; 144 + (number % 900) as usize];
            payload[..4].copy_from_slice(&number.to_be_bytes());
            recorder.record(i64::from(number), here, here, &payload).unwrap();
        }
        recorder.flush().unwrap();
        writeln!(out, "flushed {}", (batch + 1) * 40).unwrap();
    }
}

/// Kills a recorder after about `wanted` datagrams; gives how many it said were flushed.
fn record_and_kill(file: &Path, wanted: u32) -> u32 {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "records_until_it_is_killed", "--nocapture"])
        .env(FILE, file)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut flushed = 0;
    for line in BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok) {
        let told = line.split("flushed ").nth(1).and_then(|n| n.parse().ok());
        flushed = told.unwrap_or(flushed);
        if flushed >= wanted {
            break;
        }
    }
    // SIGKILL: nothing of the process runs any more.
    child.kill().unwrap();
    child.wait().unwrap();
    flushed
}

#[test]
fn a_killed_recorder_loses_at_most_the_last_block_and_the_file_says_so() {
    let file = std::env::temp_dir().join(format!("capture-killed-{}.pcapng", std::process::id()));
    for wanted in [1, 500, 3_000, 10_000] {
        let flushed = record_and_kill(&file, wanted);
        assert!(flushed >= wanted, "the recorder ended by itself");
        let (mut count, mut remarks) = (0, Vec::new());
        for item in Reader::open(&file).unwrap() {
            match item {
                Ok(datagram) => {
                    let number = u32::from_be_bytes(datagram.payload[..4].try_into().unwrap());
                    assert_eq!(number, count, "in order, none missing");
                    assert_eq!(datagram.payload.len(), 144 + (number % 900) as usize);
                    count += 1;
                }
                Err(problem) => remarks.push(problem),
            }
        }
        assert!(count >= flushed, "{count} in the file, {flushed} flushed");
        assert!(
            matches!(remarks[..], [Problem::NotClosed { .. } | Problem::Cut { .. }]),
            "{remarks:?}"
        );
    }
    let _ = std::fs::remove_file(&file);
}
