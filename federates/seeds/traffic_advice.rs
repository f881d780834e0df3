//! `seeds traffic advice SCENE…`: what advice is worth to controllers, over many seeds.

use crate::runtime::cli::{self, BAD_INPUT, fail, out};
use clap::{Args, ValueEnum};
use models::control::advice::Habits;
use std::process::ExitCode;
use studies::advice::{Benefit, fly};

/// What advice is worth to controllers: scenes flown with and without it, the same seeds each, with intervals
#[derive(Args, Clone, Debug)]
pub struct AdviceArgs {
    /// Scenes with traffic that behaves
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<String>,

    /// How many seeds, from 1 on; generated traffic is another for each
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,

    /// Probability with which the models accept an advice
    #[arg(long, value_name = "P", default_value_t = 0.8)]
    accepts: f64,

    /// Form of the table
    #[arg(long, value_enum, default_value_t = Form::Text)]
    form: Form,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Form {
    Text,
    Json,
    Csv,
}

/// Flies and tells.
#[must_use]
pub fn run(args: &AdviceArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    if !(0.0..=1.0).contains(&args.accepts) {
        return fail(BAD_INPUT, "--accepts: a probability, 0 to 1");
    }
    if args.form == Form::Csv {
        out!("{}", Benefit::CSV_HEADS.trim_end());
    }
    for scene in &args.scenes {
        let benefit = match of(scene, args) {
            Ok(benefit) => benefit,
            Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
        };
        match args.form {
            Form::Text => out!("{}", benefit.to_text()),
            Form::Json => out!("{}", benefit.to_json()),
            Form::Csv => out!("{}", benefit.to_csv().trim_end()),
        }
    }
    ExitCode::SUCCESS
}

fn of(name: &str, args: &AdviceArgs) -> anyhow::Result<Benefit> {
    let path = scenarios::locate(name);
    let text = scenarios::text_of(&path)?;
    let mut benefit = Benefit { scene: name.to_owned(), pairs: Vec::new() };
    for seed in 1..=args.seeds {
        let text = scenarios::vary::with_key(&text, "run.seed", &seed.to_string())
            .map_err(anyhow::Error::msg)?;
        let scene = scenarios::load_text(&path, &text)?;
        let habits = Habits { accepts: args.accepts, ..Habits::default() };
        let fly = |habits| fly(&scene, seed, habits).map_err(anyhow::Error::msg);
        benefit.pairs.push((seed, fly(None)?, fly(Some(habits))?));
        show(&format!("\r{name}: seed {seed} of {} ", args.seeds));
    }
    show("\n");
    Ok(benefit)
}

#[expect(clippy::print_stderr, reason = "progress for a person at a terminal")]
fn show(text: &str) {
    if std::io::IsTerminal::is_terminal(&std::io::stderr()) {
        eprint!("{text}");
    }
}
