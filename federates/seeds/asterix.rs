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
    if let Command::Cut { from, to: Some(to), .. } = &args.command
        && from > to
    {
        return fail(BAD_INPUT, "--from is after --to: nothing lies between them");
    }
    let pieces = match read(&input.file, input.port) {
        Ok(pieces) => pieces,
        Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
    };
    let done = match &args.command {
        Command::Stat { json, .. } => stat(&pieces, *json).then_some(true).with_context(|| {
            format!("{}: no record was found: this is not ASTERIX", input.file.display())
        }),
        Command::Dump { .. } => Ok(dump(&pieces)),
        Command::Check { json, .. } => Ok(check(&pieces, *json)),
        Command::Cut { out, from, to, category, .. } => {
            cut(&pieces, *from, *to, category).and_then(|cut| write(&cut, out)).map(|()| true)
        }
        Command::Convert { out, .. } => write(&pieces.pieces, out).map(|()| true),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(FAILED),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

#[derive(Default)]
struct Count {
    records: u64,
    items: BTreeMap<&'static str, u64>,
}

/// Whether there was anything: a sound record, or whole blocks of categories that are not known here and nothing else.
fn stat(pieces: &Pieces, as_json: bool) -> bool {
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
    let whole = damaged == 0 && pieces.problems.is_empty();
    let something = records > 0 || (whole && !unknown.is_empty());
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
        return something;
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
    something
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

fn cut(
    pieces: &Pieces,
    from_s: f64,
    to_s: Option<f64>,
    categories: &[u8],
) -> anyhow::Result<Vec<Piece>> {
    let mut times = asterix::time::Unwrap::default();
    let mut first = None;
    let mut last_s = 0.0;
    let mut kept = Vec::new();
    for piece in &pieces.pieces {
        // Without any time it stands where its neighbour does.
        if let Some(s) = seconds(piece) {
            let s = if piece.dated { s } else { times.seconds(s) };
            last_s = s - *first.get_or_insert(s);
        }
        if last_s < from_s || to_s.is_some_and(|to| last_s > to) {
            continue;
        }
        let mut own = piece.clone();
        if !categories.is_empty() {
            let blocks = sound(&piece.octets).filter_map(Result::ok);
            let wanted = blocks.filter(|b| categories.contains(&b.number));
            own.octets = wanted.flat_map(|b| b.octets().iter().copied()).collect();
        }
        if !own.octets.is_empty() {
            kept.push(own);
        }
    }
    if kept.is_empty() {
        bail!("nothing of the recording is within the cut");
    }
    Ok(kept)
}

/// Writes datagrams in the form that a name says.
fn write(pieces: &[Piece], path: &Path) -> anyhow::Result<()> {
    let name = path.display().to_string();
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let mut times = asterix::time::Unwrap::default();
    let mut last_ns = 0;
    let mut stamped = pieces.iter().map(|piece| {
        if let Some(s) = seconds(piece) {
            let undated = || (times.seconds(s) * 1e9) as i64;
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
