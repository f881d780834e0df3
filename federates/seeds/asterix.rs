//! `seeds asterix`: what is in a recording of ASTERIX, what is wrong with it, parts of it, other forms of it.

use crate::exchange::asterix_file::{Piece, Pieces, read, sound};
use crate::gateway::foreign::{of_day_s, source};
use crate::runtime::cli::out;
use crate::runtime::cli::{BAD_INPUT, FAILED, fail, save};
use anyhow::{Context, bail};
use asterix::files::{FileWriter, Form};
use asterix::{json as record_json, presence};
use capture::Recorder;
use clap::{Args, Subcommand};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Look into recordings of ASTERIX, cut and convert them
///
/// Files: pcap, pcapng, bare blocks (.ast), IOSS final (.ff), RFF (.rff); which one it is is told by its octets.
#[derive(Args, Clone, Debug)]
pub struct AsterixToolArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    /// Records by sender and category, and their items
    Stat {
        #[command(flatten)]
        input: Input,
        /// One JSON object
        #[arg(long)]
        json: bool,
    },
    /// Every record as a JSON object, one a line
    Dump {
        #[command(flatten)]
        input: Input,
        /// JSON, as without this flag
        #[arg(long)]
        json: bool,
    },
    /// Damage with offset and item, and every rule of presence that is broken; exit code 1 if there is any
    Check {
        #[command(flatten)]
        input: Input,
        /// JSON objects, one a line
        #[arg(long)]
        json: bool,
    },
    /// A part of a recording, in the form that the name of OUT says
    Cut {
        #[command(flatten)]
        input: Input,
        /// File to write: .pcapng, .ast, .ff or .rff
        #[arg(value_name = "OUT")]
        out: PathBuf,
        /// From so many seconds after the first datagram on
        #[arg(long, value_name = "S", default_value_t = 0.0)]
        from: f64,
        /// Up to so many seconds after the first datagram [default: the end]
        #[arg(long, value_name = "S")]
        to: Option<f64>,
        /// Only blocks of these categories, with commas between [default: all]
        #[arg(long, value_name = "N", value_delimiter = ',')]
        category: Vec<u8>,
    },
    /// The same datagrams in another form, which the name of OUT says
    Convert {
        #[command(flatten)]
        input: Input,
        /// File to write: .pcapng, .ast, .ff or .rff
        #[arg(value_name = "OUT")]
        out: PathBuf,
    },
}

#[derive(Args, Clone, Debug)]
struct Input {
    /// Recording
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Only datagrams to this UDP port [default: all that begin with a known category]
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
}

/// Runs the tool.
#[must_use]
pub fn run(args: &AsterixToolArgs) -> ExitCode {
    let input = match &args.command {
        Command::Stat { input, .. }
        | Command::Dump { input, .. }
        | Command::Check { input, .. }
        | Command::Cut { input, .. }
        | Command::Convert { input, .. } => input,
    };
    if let Command::Cut { from, to, .. } = &args.command {
        if !from.is_finite() || to.is_some_and(|to| !to.is_finite()) {
            return fail(BAD_INPUT, "--from and --to are finite numbers of seconds");
        }
        if to.is_some_and(|to| *from > to) {
            return fail(BAD_INPUT, "--from is after --to: nothing lies between them");
        }
    }
    let pieces = match read(&input.file, input.port) {
        Ok(pieces) => pieces,
        Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
    };
    let name = input.file.display();
    let nothing = || format!("{name}: no record was found: this is not ASTERIX");
    let found = |whole: bool| holds_something(&pieces).then_some(whole).with_context(nothing);
    // What is left out of a copy is said beside it, and the copy is there all the same.
    let copied = |lost: Vec<String>| {
        let problems: Vec<&String> = pieces.problems.iter().chain(&lost).collect();
        problems.iter().for_each(|problem| left_out(&input.file, problem));
        problems.is_empty()
    };
    let done = match &args.command {
        Command::Stat { json, .. } => {
            stat(&pieces, *json);
            found(true)
        }
        Command::Dump { .. } => found(dump(&pieces)),
        Command::Check { json, .. } => found(check(&pieces, *json)),
        Command::Cut { out, from, to, category, .. } => found(true)
            .and_then(|_| cut(&pieces, *from, *to, category))
            .and_then(|(cut, lost)| write(&cut, out).map(|()| copied(lost))),
        Command::Convert { out, .. } => {
            found(true).and_then(|_| write(&pieces.pieces, out)).map(|()| copied(Vec::new()))
        }
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(FAILED),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

#[expect(clippy::print_stderr, reason = "a word to the person at the terminal")]
fn left_out(file: &Path, problem: &str) {
    eprintln!("{}: left out: {problem}", file.display());
}

#[derive(Default)]
struct Count {
    records: u64,
    items: BTreeMap<&'static str, u64>,
}

/// Whether there is anything: a sound record, or whole blocks of categories that are not known here and nothing else.
fn holds_something(pieces: &Pieces) -> bool {
    let (mut unknown, mut damaged) = (false, !pieces.problems.is_empty());
    for block in pieces.pieces.iter().flat_map(|piece| sound(&piece.octets)) {
        match block {
            Ok(block) if block.records().flatten().next().is_some() => return true,
            Ok(block) => unknown |= block.category.is_none(),
            Err(_) => damaged = true,
        }
    }
    unknown && !damaged
}

fn stat(pieces: &Pieces, as_json: bool) {
    let mut counts: BTreeMap<(u8, u8, u8), Count> = BTreeMap::new();
    let (mut unknown, mut damaged, mut octets) = (BTreeMap::<u8, u64>::new(), 0u64, 0usize);
    for piece in &pieces.pieces {
        octets += piece.octets.len();
        for block in sound(&piece.octets) {
            let Ok(block) = block else {
                damaged += 1;
                continue;
            };
            if block.category.is_none() {
                *unknown.entry(block.number).or_default() += 1;
            }
            for record in block.records().flatten() {
                let (sac, sic) = source(&record).unwrap_or((0, 0));
                let count = counts.entry((sac, sic, block.number)).or_default();
                count.records += 1;
                for view in record.items() {
                    *count.items.entry(view.item.id).or_default() += 1;
                }
            }
        }
    }
    let records: u64 = counts.values().map(|c| c.records).sum();
    if as_json {
        let rows: Vec<Value> = counts
            .iter()
            .map(|((sac, sic, category), c)| {
                json!({"sac": sac, "sic": sic, "category": category, "records": c.records, "items": c.items})
            })
            .collect();
        let unknown: BTreeMap<String, u64> =
            unknown.iter().map(|(number, n)| (number.to_string(), *n)).collect();
        let line = json!({
            "form": pieces.form, "datagrams": pieces.pieces.len(), "octets": octets, "records": records,
            "damaged": damaged, "problems": pieces.problems, "other_datagrams": pieces.others,
            "unknown_categories": unknown, "sources": rows,
        });
        out!("{line}");
        return;
    }
    out!(
        "{}: {} datagrams, {octets} octets, {records} records, {damaged} damaged, {} not ASTERIX",
        pieces.form,
        pieces.pieces.len(),
        pieces.others
    );
    for ((sac, sic, category), count) in &counts {
        out!("{sac}/{sic} category {category:03}: {} records", count.records);
        let items: Vec<String> = count.items.iter().map(|(id, n)| format!("{id} {n}")).collect();
        out!("    {}", items.join(", "));
    }
    for (number, n) in &unknown {
        out!("category {number:03}: {n} blocks, not known here");
    }
    for problem in &pieces.problems {
        out!("{problem}");
    }
}

/// Whether nothing was damaged.
fn dump(pieces: &Pieces) -> bool {
    let mut whole = pieces.problems.is_empty();
    for piece in &pieces.pieces {
        for block in sound(&piece.octets) {
            let block = match block {
                Ok(block) => block,
                Err(e) => {
                    whole = false;
                    let at = piece.offset + e.offset as u64;
                    out!(
                        "{}",
                        json!({"time_ns": piece.time_ns, "octet": at, "error": e.to_string()})
                    );
                    continue;
                }
            };
            if block.category.is_none() {
                out!(
                    "{}",
                    json!({"time_ns": piece.time_ns, "category": block.number, "record": null})
                );
            }
            for record in block.records().flatten() {
                let line = json!({
                    "time_ns": piece.time_ns, "octet": piece.offset + record.offset as u64,
                    "category": block.number, "record": record_json::record(&record),
                });
                out!("{line}");
            }
        }
    }
    for problem in &pieces.problems {
        out!("{}", json!({"error": problem}));
    }
    whole
}

/// Whether nothing was found.
fn check(pieces: &Pieces, as_json: bool) -> bool {
    let mut found = 0u64;
    let mut say = |octet: Option<u64>, what: &str| {
        found += 1;
        match (as_json, octet) {
            (true, octet) => out!("{}", json!({"octet": octet, "finding": what})),
            (false, Some(octet)) => out!("octet {octet}: {what}"),
            (false, None) => out!("{what}"),
        }
    };
    let mut records = 0u64;
    for piece in &pieces.pieces {
        for block in sound(&piece.octets) {
            match block {
                Ok(block) => {
                    for record in block.records().flatten() {
                        records += 1;
                        let at = piece.offset + record.offset as u64;
                        for breach in presence::breaches(&record) {
                            say(Some(at), &breach.to_string());
                        }
                        if of_day_s(&record).is_some_and(|s| s >= asterix::DAY_S) {
                            say(Some(at), "the time of day is not below 86400 s");
                        }
                    }
                }
                Err(e) => {
                    let text = e.to_string();
                    // The error's own octet counts within its datagram.
                    let what = text.split_once(": ").map_or(text.as_str(), |(_, what)| what);
                    say(Some(piece.offset + e.offset as u64), what);
                }
            }
        }
    }
    for problem in &pieces.problems {
        say(None, problem);
    }
    if as_json {
        out!("{}", json!({"records": records, "findings": found}));
    } else {
        out!("{records} records, {found} findings");
    }
    found == 0
}

/// When a datagram came, s of any clock: as recorded, else by the first time of day in it.
fn seconds(piece: &Piece) -> Option<f64> {
    let recorded = piece.time_ns.map(|ns| ns as f64 / 1e9);
    recorded.or_else(|| {
        let blocks = sound(&piece.octets).filter_map(Result::ok);
        blocks.flat_map(|b| b.records().flatten()).find_map(|r| of_day_s(&r))
    })
}

/// When datagrams came, s of a clock that goes on over midnight.
#[derive(Default)]
struct Times {
    of_day: asterix::time::Unwrap,
    /// Seconds of the days that the form's own times lack.
    added_s: f64,
    latest_s: Option<f64>,
}

impl Times {
    /// Of the next datagram; none where neither its form nor its records have a time.
    ///
    /// IOSS final has times with a day, which stands over midnight in some recordings and not in others: a jump back of more than half
    /// a day is a day that is missing, a jump forward a silence, however long.
    fn seconds(&mut self, piece: &Piece) -> Option<f64> {
        let s = seconds(piece)?;
        if piece.dated {
            return Some(s);
        }
        if piece.time_ns.is_none() {
            return Some(self.of_day.seconds(s));
        }
        let latest_s = self.latest_s.unwrap_or(s);
        if s + self.added_s < latest_s - asterix::DAY_S / 2.0 {
            self.added_s += asterix::DAY_S;
        }
        let s = s + self.added_s;
        self.latest_s = Some(latest_s.max(s));
        Some(s)
    }
}

/// What lies in the cut, and what of it is damaged and left out where blocks are chosen.
fn cut(
    pieces: &Pieces,
    from_s: f64,
    to_s: Option<f64>,
    categories: &[u8],
) -> anyhow::Result<(Vec<Piece>, Vec<String>)> {
    let mut lost = Vec::new();
    let mut times = Times::default();
    let mut first = None;
    let mut last_s = 0.0;
    let mut kept = Vec::new();
    for piece in &pieces.pieces {
        // Without any time it stands where its neighbour does.
        if let Some(s) = times.seconds(piece) {
            last_s = s - *first.get_or_insert(s);
        }
        if last_s < from_s || to_s.is_some_and(|to| last_s > to) {
            continue;
        }
        let mut own = piece.clone();
        if !categories.is_empty() {
            own.octets.clear();
            for block in sound(&piece.octets) {
                match block {
                    Ok(block) if categories.contains(&block.number) => {
                        own.octets.extend_from_slice(block.octets());
                    }
                    Ok(_) => {}
                    Err(e) => lost.push(format!("octet {}: {e}", piece.offset + e.offset as u64)),
                }
            }
        }
        if !own.octets.is_empty() {
            kept.push(own);
        }
    }
    if kept.is_empty() {
        bail!("nothing of the recording is within the cut");
    }
    Ok((kept, lost))
}

/// Writes datagrams in the form that a name says.
fn write(pieces: &[Piece], path: &Path) -> anyhow::Result<()> {
    let name = path.display().to_string();
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let mut times = Times::default();
    let mut last_ns = 0;
    let mut stamped = pieces.iter().map(|piece| {
        if let Some(s) = times.seconds(piece) {
            let undated = || (s * 1e9) as i64;
            last_ns = piece.time_ns.filter(|_| piece.dated).unwrap_or_else(undated);
        }
        (last_ns, piece)
    });
    if ending.eq_ignore_ascii_case("pcapng") {
        let mut recorder = Recorder::create(path).with_context(|| format!("writing {name}"))?;
        let from = SocketAddr::from(([127, 0, 0, 1], 8600));
        stamped.try_for_each(|(ns, piece)| recorder.record(ns, from, from, &piece.octets))?;
        return Ok(recorder.close(0)?);
    }
    let Some(form) = Form::of_name(&name) else {
        bail!("{name}: which form? Name it .pcapng, .ast (bare blocks), .ff (IOSS final) or .rff");
    };
    let mut file = FileWriter::new(form);
    stamped.try_for_each(|(ns, piece)| file.add(ns, &piece.octets))?;
    save(path, file.finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use asterix::{Packer, cat010};

    /// A folder of its own with recordings: whole, damaged in the middle, and none of ASTERIX.
    struct Recordings(PathBuf);

    impl Recordings {
        fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("seeds-{name}-{}", std::process::id()));
            std::fs::create_dir_all(&folder).expect("a folder");
            let made = Self(folder);
            let blocks: Vec<Vec<u8>> = (0..12).map(|n| plots(f64::from(n))).collect();
            made.write("whole.ast", &blocks.concat());
            let mut damaged = blocks.clone();
            // A length that no block has.
            damaged[4][1..3].copy_from_slice(&[0, 1]);
            made.write("damaged.ast", &damaged.concat());
            made.write("text.ast", b"hello, this is a text and no recording of anything\n");
            made.capture("whole.pcapng", &blocks);
            damaged[4][3] = 0;
            made.capture("damaged.pcapng", &[damaged[..6].concat(), damaged[6..].concat()]);
            // Two PDUs of DIS: version 7, and what begins as none of ours.
            made.capture("dis.pcapng", &[vec![7; 144], vec![7; 144]]);
            made
        }

        fn file(&self, name: &str) -> PathBuf {
            self.0.join(name)
        }

        fn write(&self, name: &str, octets: &[u8]) {
            std::fs::write(self.file(name), octets).expect("written");
        }

        fn capture(&self, name: &str, datagrams: &[Vec<u8>]) {
            let mut recorder = Recorder::create(self.file(name)).expect("created");
            let from = SocketAddr::from(([127, 0, 0, 1], 8600));
            for (octets, n) in datagrams.iter().zip(0..) {
                recorder.record(n * 1_000_000_000, from, from, octets).expect("recorded");
            }
            recorder.close(0).expect("closed");
        }

        fn input(&self, name: &str) -> Input {
            Input { file: self.file(name), port: None }
        }

        fn done(&self, command: Command) -> ExitCode {
            run(&AsterixToolArgs { command })
        }

        fn cut(&self, name: &str, from: f64, to: Option<f64>, category: &[u8]) -> ExitCode {
            let (input, out) = (self.input(name), self.file("out.ff"));
            self.done(Command::Cut { input, out, from, to, category: category.to_vec() })
        }

        /// Exit codes of stat, dump, check, cut and convert.
        fn all(&self, name: &str) -> [ExitCode; 5] {
            let out = self.file("out.ff");
            [
                self.done(Command::Stat { input: self.input(name), json: false }),
                self.done(Command::Dump { input: self.input(name), json: false }),
                self.done(Command::Check { input: self.input(name), json: true }),
                self.cut(name, 0.0, None, &[10]),
                self.done(Command::Convert { input: self.input(name), out }),
            ]
        }
    }

    impl Drop for Recordings {
        fn drop(&mut self) {
            std::fs::remove_dir_all(&self.0).ok();
        }
    }

    /// A block of ten plots at a second of the day.
    fn plots(at_s: f64) -> Vec<u8> {
        let mut packer = Packer::new(1400);
        for n in 0..10 {
            let record = packer.record(&cat010::CATEGORY, |items| {
                items.put(&cat010::I010, &[0, 1])?;
                items.put(&cat010::I000, &[1])?;
                items.put(&cat010::I020, &[3, 0, 0, 1, 0])?;
                items.put(&cat010::I140, &[at_s])?;
                items.put(&cat010::I042, &[f64::from(n), 20.0])
            });
            record.expect("fits");
        }
        packer.take().concat()
    }

    #[test]
    fn no_verb_passes_over_damage_or_takes_a_stranger_for_asterix() {
        let recordings = Recordings::new("verbs");
        let [good, failed] = [ExitCode::SUCCESS, ExitCode::from(FAILED)];
        for whole in ["whole.ast", "whole.pcapng"] {
            assert_eq!(recordings.all(whole), [good; 5], "{whole}");
        }
        for damaged in ["damaged.ast", "damaged.pcapng"] {
            let [stat, rest @ ..] = recordings.all(damaged);
            assert_eq!(stat, good, "{damaged}: it counts the damage");
            // A conversion of datagrams as they are loses nothing of them.
            let kept = damaged.ends_with("pcapng");
            let expected = [failed, failed, failed, if kept { good } else { failed }];
            assert_eq!(rest, expected, "{damaged}");
        }
        recordings.write("out.ff", b"what was there");
        for stranger in ["text.ast", "dis.pcapng"] {
            assert_eq!(recordings.all(stranger), [failed; 5], "{stranger}");
        }
        let kept = std::fs::read(recordings.file("out.ff")).expect("there");
        assert_eq!(kept, b"what was there", "nothing is written over for nothing");
    }

    /// IOSS final with its own days and times, converted and cut: over midnight in a recording whose day octet stands, and over a silence
    /// of more than half a day in one whose does not, no time goes back.
    #[test]
    fn times_of_ioss_go_on_over_midnight_and_over_silence() {
        const DAY_S: f64 = 86_400.0;
        let recordings = Recordings::new("ioss");
        let hour = 3600.0;
        // Seconds of each frame with its day, as they are in the file, and when that is.
        let silent = [hour, 14.0 * hour, DAY_S + 10.0];
        let midnight = [DAY_S - 2.0, DAY_S - 1.0, 0.5, 14.0 * hour, 23.0 * hour, hour];
        let in_truth = midnight.map(|s| if s < DAY_S - 2.0 { s + DAY_S } else { s });
        let in_truth = [&in_truth[..5], &[hour + 2.0 * DAY_S]].concat();
        for (own, expected) in [(&silent[..], &silent[..]), (&midnight[..], &in_truth[..])] {
            let mut file = FileWriter::new(Form::Final);
            for own_s in own {
                file.add((own_s * 1e9) as i64, &plots(own_s % DAY_S)).expect("fits");
            }
            recordings.write("own.ff", &file.finish());
            let out = recordings.file("out.pcapng");
            let input = recordings.input("own.ff");
            assert_eq!(recordings.done(Command::Convert { input, out }), ExitCode::SUCCESS);
            let copy = read(&recordings.file("out.pcapng"), None).expect("written");
            let seconds = |piece: &Piece| piece.time_ns.expect("a time") as f64 * 1e-9;
            let said: Vec<f64> = copy.pieces.iter().map(seconds).collect();
            for (said, wanted) in said.iter().zip(expected) {
                assert!((said - wanted).abs() < 0.011, "{own:?}: {said}, {wanted}");
            }
            // A cut from between any two on has those behind it.
            for (at, pair) in expected.windows(2).enumerate() {
                let from = (pair[0] + pair[1]) / 2.0 - expected[0];
                assert_eq!(recordings.cut("own.ff", from, None, &[]), ExitCode::SUCCESS);
                let kept = read(&recordings.file("out.ff"), None).expect("written").pieces.len();
                assert_eq!(kept, own.len() - at - 1, "from {from} s on of {own:?}");
            }
        }
    }

    #[test]
    fn a_cut_lies_between_two_times() {
        let recordings = Recordings::new("times");
        for (from, to) in [(f64::NAN, None), (0.0, Some(f64::NAN)), (f64::NEG_INFINITY, Some(1.0))]
        {
            let refused = recordings.cut("whole.ast", from, to, &[]);
            assert_eq!(refused, ExitCode::from(BAD_INPUT), "{from} to {to:?}");
        }
        assert_eq!(recordings.cut("whole.ast", 2.0, Some(5.0), &[]), ExitCode::SUCCESS);
        let kept = read(&recordings.file("out.ff"), None).expect("written");
        let records = |piece: &Piece| {
            let blocks = sound(&piece.octets).filter_map(Result::ok);
            blocks.flat_map(|b| b.records()).count()
        };
        assert_eq!(kept.pieces.iter().map(records).sum::<usize>(), 40, "four blocks of ten");
    }
}
