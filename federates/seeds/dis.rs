//! `seeds dis`: what is in a file of DIS datagrams, what is wrong with it, and parts of it.

use crate::runtime::cli::{BAD_INPUT, fail};
use anyhow::Context;
use capture::tools::check::check;
use capture::tools::diff::diff;
use capture::tools::dump::{Item, dump};
use capture::tools::edit::{Change, EntityPattern, Selection, edit};
use capture::tools::lint::{Limits, Rule, lint};
use capture::tools::stat::stat;
use capture::tools::{json, pdu_type};
use capture::{Problem, Rewrite, When};
use clap::{Args, Subcommand};
use pdu::enumerations::PduType;
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Look into captures of DIS, and cut and merge them
///
/// Files: pcap, pcapng (Ethernet with VLAN, Linux cooked, raw IP, loopback; IPv4 with fragments, IPv6)
/// and bare PDUs (.raw, .bin, .dis).
#[derive(Args, Clone, Debug)]
pub struct DisArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    /// What is in a file: types, versions, exercises, senders, entities, rates
    Stat {
        #[command(flatten)]
        input: Input,
    },
    /// Every PDU, one a line
    Dump {
        #[command(flatten)]
        input: Input,
        #[command(flatten)]
        selection: SelectionArgs,
        /// Every field on a line of its own
        #[arg(long, conflicts_with = "json")]
        fields: bool,
    },
    /// What hurts in practice: bad enumerations, NaN, positions inside the earth, silent or doubled entities …
    Lint {
        #[command(flatten)]
        input: Input,
        /// Silence of an entity that is too long
        #[arg(long, value_name = "S", default_value_t = 12.0, value_parser = positive)]
        silence: f64,
        /// Only these rules, with commas between [default: all]
        #[arg(long, value_name = "RULE", value_delimiter = ',', value_parser = rule)]
        only: Vec<Rule>,
        /// End with 1 if anything was found
        #[arg(long)]
        strict: bool,
    },
    /// Decode and encode every PDU: is it sound, does it come back octet by octet?
    Check {
        #[command(flatten)]
        input: Input,
        /// End with 1 if any PDU is damaged
        #[arg(long)]
        strict: bool,
    },
    /// What one file has and another has not; ends with 1 if they differ
    Diff {
        /// First file
        first: PathBuf,
        /// Second file
        second: PathBuf,
        /// Time stamps of PDUs do not count
        #[arg(long)]
        ignore_times: bool,
        #[command(flatten)]
        output: Output,
    },
    /// A part of a file, by time, entity, type, exercise; with other identifiers and addresses if wanted
    Cut {
        /// Input
        input: PathBuf,
        /// Output: pcapng, or bare PDUs if it ends in .raw, .bin or .dis
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        #[command(flatten)]
        edit: EditArgs,
    },
    /// Several files in one, in the order of time
    Merge {
        /// Output: pcapng, or bare PDUs if it ends in .raw, .bin or .dis
        output: PathBuf,
        /// Inputs
        #[arg(required = true)]
        inputs: Vec<PathBuf>,
        #[command(flatten)]
        edit: EditArgs,
    },
}

/// A file to be read
#[derive(Args, Clone, Debug)]
struct Input {
    /// Capture file
    file: PathBuf,
    #[command(flatten)]
    output: Output,
}

/// How results are written
#[derive(Args, Clone, Debug)]
struct Output {
    /// One JSON object a line, for programs
    #[arg(long)]
    json: bool,
    /// UDP ports that carry DIS, with commas between [default: 3000 and all to which sound DIS headers go]
    #[arg(long, value_name = "PORT", value_delimiter = ',')]
    port: Vec<u16>,
}

/// Which PDUs are wanted
#[derive(Args, Clone, Debug, Default)]
pub struct SelectionArgs {
    /// From this time on: seconds from the start, or UTC (2026-11-20T23:30:00Z) [default: the start]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    from: Option<When>,
    /// Up to and with this time: seconds from the start, or UTC [default: the end]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    to: Option<When>,
    /// Exercises, with commas between [default: all]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    exercise: Vec<u8>,
    /// PDU types by number or name, with commas between [default: all]
    #[arg(long = "type", value_name = "TYPE", value_delimiter = ',', value_parser = pdu_type)]
    types: Vec<PduType>,
    /// PDUs that name one of these entities, with commas between; * is any number [default: all]
    #[arg(long, value_name = "SITE:APPLICATION:ENTITY", value_delimiter = ',')]
    entity: Vec<EntityPattern>,
}

impl SelectionArgs {
    /// What is wrong with its times, where nothing can lie between them.
    fn backwards(&self) -> Option<String> {
        let after = match (self.from?, self.to?) {
            (When::FromStart(from), When::FromStart(to)) => from > to,
            (When::At(from), When::At(to)) => from > to,
            _ => false, // told by the recording
        };
        after.then(|| "--from is after --to: nothing lies between them".to_owned())
    }

    fn selection(&self) -> Selection {
        Selection {
            from: self.from,
            to: self.to,
            exercises: self.exercise.clone(),
            types: self.types.clone(),
            entities: self.entity.clone(),
        }
    }
}

/// Other identifiers in PDUs
#[derive(Args, Clone, Debug, Default)]
pub struct RewriteArgs {
    /// Exercise of every PDU [default: as it is]
    #[arg(long, value_name = "N")]
    set_exercise: Option<u8>,
    /// Sites: NEW for all, or OLD=NEW, with commas between [default: as they are]
    #[arg(long, value_name = "[OLD=]NEW", value_delimiter = ',', value_parser = renumber)]
    set_site: Vec<(Option<u16>, u16)>,
    /// Applications: NEW for all, or OLD=NEW, with commas between [default: as they are]
    #[arg(long, value_name = "[OLD=]NEW", value_delimiter = ',', value_parser = renumber)]
    set_application: Vec<(Option<u16>, u16)>,
}

impl RewriteArgs {
    /// As the library takes it.
    #[must_use]
    pub fn rewrite(&self) -> Rewrite {
        Rewrite {
            exercise: self.set_exercise,
            site: self.set_site.clone(),
            application: self.set_application.clone(),
        }
    }
}

/// What is wanted, and what is changed on the way
#[derive(Args, Clone, Debug)]
struct EditArgs {
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    rewrite: RewriteArgs,
    /// Sender of every datagram [default: as it is]
    #[arg(long, value_name = "ADDR:PORT")]
    set_from: Option<SocketAddr>,
    /// Receiver of every datagram [default: as it is]
    #[arg(long, value_name = "ADDR:PORT")]
    set_to: Option<SocketAddr>,
    #[command(flatten)]
    output: Output,
}

/// Runs one of the tools. Results go to stdout, remarks to stderr. The file being damaged gives exit
/// code 3.
///
/// # Errors
/// If a file cannot be read or written.
pub fn run(args: DisArgs) -> anyhow::Result<ExitCode> {
    let mut out = BufWriter::new(io::stdout().lock());
    let code = dispatch(args.command, &mut out);
    match code.and_then(|code| out.flush().map(|()| code).context("writing to stdout")) {
        // Whoever reads has seen enough (`| head`).
        Err(e) if is_broken_pipe(&e) => Ok(ExitCode::SUCCESS),
        other => other,
    }
}

fn is_broken_pipe(e: &anyhow::Error) -> bool {
    e.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

/// Complete, but the file itself has damaged places.
const DATA_LOST: u8 = 3;
/// Findings of one rule about one entity that are shown to people; the others are counted.
const SHOWN: u32 = 3;

fn dispatch(command: Command, out: &mut impl Write) -> anyhow::Result<ExitCode> {
    let selection = match &command {
        Command::Dump { selection, .. } => Some(selection),
        Command::Cut { edit, .. } | Command::Merge { edit, .. } => Some(&edit.selection),
        _ => None,
    };
    if let Some(why) = selection.and_then(SelectionArgs::backwards) {
        return Ok(fail(BAD_INPUT, why));
    }
    match command {
        Command::Stat { input } => {
            let told = stat(&input.file, &input.output.port)?;
            if input.output.json {
                writeln!(out, "{}", told.json())?;
            } else {
                write!(out, "{told}")?;
            }
            Ok(lost_if(!told.problems.is_empty()))
        }
        Command::Dump { input, selection, fields } => dump_file(&input, &selection, fields, out),
        Command::Lint { input, silence, only, strict } => {
            lint_file(&input, silence, &only, strict, out)
        }
        Command::Check { input, strict } => {
            let mut failed = Ok(());
            let counts = check(&input.file, &input.output.port, |finding| {
                let line = if input.output.json { finding.json() } else { finding.to_string() };
                failed =
                    std::mem::replace(&mut failed, Ok(())).and_then(|()| writeln!(out, "{line}"));
            })?;
            failed?;
            if input.output.json {
                writeln!(out, "{}", counts.json())?;
            } else {
                write!(out, "{counts}")?;
            }
            let changed = counts.reencoded_identical < counts.pdus;
            if changed || strict && counts.damaged > 0 {
                return Ok(ExitCode::FAILURE);
            }
            Ok(lost_if(counts.problems > 0))
        }
        Command::Diff { first, second, ignore_times, output } => {
            let mut failed = Ok(());
            let counts = diff(&first, &second, &output.port, ignore_times, |difference| {
                let line = if output.json { difference.json() } else { difference.to_string() };
                failed =
                    std::mem::replace(&mut failed, Ok(())).and_then(|()| writeln!(out, "{line}"));
            })?;
            failed?;
            let line = if output.json { counts.json() } else { counts.to_string() };
            writeln!(out, "{line}")?;
            Ok(if counts.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
        }
        Command::Cut { input, output, edit } => edit_files(&[input], &output, &edit, out),
        Command::Merge { output, inputs, edit } => edit_files(&inputs, &output, &edit, out),
    }
}

fn lost_if(lost: bool) -> ExitCode {
    if lost { ExitCode::from(DATA_LOST) } else { ExitCode::SUCCESS }
}

fn dump_file(
    input: &Input,
    selection: &SelectionArgs,
    fields: bool,
    out: &mut impl Write,
) -> anyhow::Result<ExitCode> {
    let mut problems = false;
    dump(&input.file, &input.output.port, &selection.selection(), |item| -> anyhow::Result<()> {
        problems |= matches!(item, Item::File(_));
        let line = if input.output.json { item.json() } else { item.to_string() };
        writeln!(out, "{line}")?;
        if fields && let Some(all) = item.fields() {
            for (name, value) in all.lines() {
                writeln!(out, "    {name} = {value}")?;
            }
        }
        Ok(())
    })?;
    Ok(lost_if(problems))
}

fn lint_file(
    input: &Input,
    silence_s: f64,
    only: &[Rule],
    strict: bool,
    out: &mut impl Write,
) -> anyhow::Result<ExitCode> {
    let limits = Limits { silence_ns: (silence_s * 1e9) as i64, ..Limits::default() };
    let json_wanted = input.output.json;
    let mut failed = Ok(());
    let mut shown = BTreeMap::new();
    let counts = lint(&input.file, &input.output.port, limits, |finding| {
        if !only.is_empty() && !only.contains(&finding.rule) {
            return;
        }
        let times: &mut u32 = shown.entry((finding.rule, finding.entity)).or_default();
        *times += 1;
        if json_wanted || *times <= SHOWN {
            let line = if json_wanted { finding.json() } else { finding.to_string() };
            failed = std::mem::replace(&mut failed, Ok(())).and_then(|()| writeln!(out, "{line}"));
        }
    })?;
    failed?;
    let wanted = |rule: &Rule| only.is_empty() || only.contains(rule);
    let all: Vec<_> = Rule::ALL.into_iter().filter(wanted).collect();
    let count = |rule: &Rule| counts.get(rule).copied().unwrap_or(0);
    if json_wanted {
        let members = json::counts(all.iter().map(|rule| (rule.name(), count(rule))));
        writeln!(out, "{members}")?;
    } else {
        for rule in all.iter().filter(|rule| count(rule) > 0) {
            writeln!(out, "{:>10} {}", count(rule), rule.name())?;
        }
        if all.iter().all(|rule| count(rule) == 0) {
            writeln!(out, "nothing found")?;
        }
    }
    if strict && all.iter().any(|rule| count(rule) > 0) {
        return Ok(ExitCode::FAILURE);
    }
    Ok(lost_if(count(&Rule::File) > 0))
}

fn edit_files(
    inputs: &[PathBuf],
    output: &Path,
    args: &EditArgs,
    out: &mut impl Write,
) -> anyhow::Result<ExitCode> {
    let selection = args.selection.selection();
    let change = Change { rewrite: args.rewrite.rewrite(), from: args.set_from, to: args.set_to };
    let tell = |path: &Path, problem: &Problem| {
        let _ = writeln!(io::stderr(), "{}: {problem}", path.display());
    };
    let done = edit(inputs, output, &args.output.port, &selection, &change, tell)?;
    if args.output.json {
        let line = json::Object::default()
            .text("file", output.display())
            .raw("datagrams_read", done.read)
            .raw("datagrams_written", done.written)
            .raw("pdus", done.pdus)
            .raw("damaged_left_out", done.damaged_left_out)
            .raw("problems", done.problems)
            .end();
        writeln!(out, "{line}")?;
    } else {
        let (read, written, pdus) = (done.read, done.written, done.pdus);
        writeln!(out, "{}: {written} of {read} datagrams, {pdus} PDUs", output.display())?;
        if done.damaged_left_out > 0 {
            writeln!(out, "{} damaged PDUs left out", done.damaged_left_out)?;
        }
    }
    let bare = done.damaged_left_out > 0 && !args.selection.selection().looks_inside();
    Ok(lost_if(done.problems > 0 || bare))
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v < 1e9 => Ok(v),
        _ => Err("a number of seconds above 0 is needed".to_owned()),
    }
}

fn rule(text: &str) -> Result<Rule, String> {
    let found = Rule::ALL.into_iter().find(|rule| rule.name() == text);
    let names = || Rule::ALL.map(Rule::name).join(", ");
    found.ok_or_else(|| format!("no rule `{text}`; rules are {}", names()))
}

/// `NEW` or `OLD=NEW`.
fn renumber(text: &str) -> Result<(Option<u16>, u16), String> {
    let number = |t: &str| t.parse::<u16>().map_err(|e| format!("`{t}`: {e}"));
    match text.split_once('=') {
        Some((old, new)) => Ok((Some(number(old)?), number(new)?)),
        None => Ok((None, number(text)?)),
    }
}
