//! `seeds`: starts federations, and carries every federate and tool as a subcommand.

pub mod accuracy;
pub mod agent;
pub mod airport;
pub mod asterix;
pub mod author;
pub mod certs;
pub mod dis;
pub mod export;
mod fault_table;
pub mod fit;
pub mod fork;
mod guests;
pub mod in_process;
pub mod known;
pub mod launch;
pub mod link_args;
pub mod load;
pub mod open;
pub mod picture;
pub mod plan;
mod plan_report;
pub mod player;
pub mod record;
mod recorded;
pub mod reference;
pub mod replay;
pub mod report;
mod report_areas;
mod rerun;
pub mod router;
pub mod run;
pub mod run_args;
pub mod scene;
pub mod score;
pub mod score_alerts;
pub mod score_asterix;
mod score_source;
pub mod sim;
pub mod site;
pub mod sweep;
pub mod traffic_advice;
pub mod traffic_check;
pub mod traffic_import;
pub mod trial;
pub mod verify;

use crate::runtime::cli::{self, BAD_INPUT, EXIT_CODES, FAILED, fail};
use clap::{CommandFactory, Parser, Subcommand};
use std::process::ExitCode;

/// Distributed simulator of airport surface traffic and of the surveillance that watches it
#[derive(Parser, Debug)]
#[command(name = "seeds", version = crate::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Seeds {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand, Debug)]
enum Command {
    Run(Box<run_args::RunArgs>),
    Open(open::OpenArgs),
    Fork(fork::ForkArgs),
    Picture(picture::PictureArgs),
    Replay(Box<replay::ReplayArgs>),
    Plan(plan::PlanArgs),
    Site(Box<site::SiteArgs>),
    Accuracy(accuracy::AccuracyArgs),
    Fit(fit::FitArgs),
    Score(score::ScoreArgs),
    Reference(reference::ReferenceArgs),
    Export(export::ExportArgs),
    Sweep(sweep::SweepArgs),
    Sim(sim::SimArgs),
    Verify(verify::VerifyArgs),
    Record(record::RecordArgs),
    Certs(certs::CertsArgs),
    Dis(dis::DisArgs),
    Asterix(asterix::AsterixToolArgs),
    Airport(airport::AirportArgs),
    Scene(scene::SceneArgs),
    Traffic(airport::TrafficArgs),
    TrafficGenerator(crate::traffic_generator::command::TrafficArgs),
    ExternalWorld(crate::external_world::command::WorldArgs),
    Smdfm(crate::smdfm::command::SmdfmArgs),
    Control(crate::control::command::ControlArgs),
    Visitors(crate::visitors::command::VisitorsArgs),
    Gateway(Box<crate::gateway::command::GatewayArgs>),
    ViewerLogger(crate::viewer_logger::command::ViewerArgs),
    AdminStation(Box<crate::admin_station::command::AdminArgs>),
    Agent(agent::AgentArgs),
    Router(router::RouterArgs),
    /// Write the manual pages, one a command, into a folder
    Man {
        /// Folder
        #[arg(value_name = "DIR")]
        folder: std::path::PathBuf,
    },
    /// Print a completion script for a shell
    Completions {
        /// Shell
        shell: clap_complete::Shell,
    },
}

/// The whole command line of `seeds`; without a subcommand it runs the default scene.
#[must_use]
pub fn main() -> ExitCode {
    crate::runtime::process::end_with_launcher();
    let seeds = cli::parse::<Seeds>();
    cli::ended(match seeds.command {
        None => run::run(&default_run()),
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::Open(args)) => open::run(&args),
        Some(Command::Fork(args)) => fork::run(&args),
        Some(Command::Picture(args)) => picture::run(&args),
        Some(Command::Replay(args)) => replay::run(*args),
        Some(Command::Plan(args)) => plan::run(&args),
        Some(Command::Site(args)) => site::run(&args),
        Some(Command::Record(args)) => finished(record::run(args)),
        Some(Command::Dis(args)) => finished(dis::run(args)),
        Some(Command::Certs(args)) => certs::run(&args),
        Some(Command::Asterix(args)) => asterix::run(&args),
        Some(Command::Gateway(args)) => crate::gateway::command::run(&args),
        Some(Command::Airport(args)) => airport::run(&args),
        Some(Command::Scene(args)) => scene::run(&args),
        Some(Command::Traffic(args)) => airport::traffic(&args),
        Some(Command::Accuracy(args)) => accuracy::run(&args),
        Some(Command::Fit(args)) => fit::run(&args),
        Some(Command::Score(args)) => score::run(&args),
        Some(Command::Reference(args)) => reference::run(&args),
        Some(Command::Export(args)) => export::run(&args),
        Some(Command::Sweep(args)) => sweep::run(&args),
        Some(Command::Sim(args)) => sim::run(&args),
        Some(Command::Verify(args)) => verify::run(&args),
        Some(Command::TrafficGenerator(args)) => crate::traffic_generator::command::run(&args),
        Some(Command::ExternalWorld(args)) => crate::external_world::command::run(&args),
        Some(Command::Smdfm(args)) => crate::smdfm::command::run(&args),
        Some(Command::Control(args)) => crate::control::command::run(&args),
        Some(Command::Visitors(args)) => crate::visitors::command::run(&args),
        Some(Command::ViewerLogger(args)) => crate::viewer_logger::command::run(&args),
        Some(Command::Agent(args)) => agent::run(&args),
        Some(Command::Router(args)) => router::run(&args),
        Some(Command::AdminStation(args)) => crate::admin_station::command::run(&args),
        Some(Command::Man { folder }) => {
            let made = std::fs::create_dir_all(&folder)
                .and_then(|()| clap_mangen::generate_to(Seeds::command(), &folder));
            match made {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => fail(FAILED, format!("{}: {error}", folder.display())),
            }
        }
        Some(Command::Completions { shell }) => {
            let mut command = Seeds::command();
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut command, "seeds", &mut script);
            cli::print_line(String::from_utf8_lossy(&script).trim_end());
            ExitCode::SUCCESS
        }
    })
}

/// A tool's own exit code, or its error in one line.
fn finished(outcome: anyhow::Result<ExitCode>) -> ExitCode {
    outcome.unwrap_or_else(|e| {
        // A capture that is not there, or is none, is a wrong argument; `dis diff` says 1 for "they differ".
        let unreadable = e.chain().any(|cause| {
            cause.is::<capture::OpenError>()
                || matches!(cause.downcast_ref(), Some(capture::tools::edit::EditError::Open(_)))
        });
        fail(if unreadable { BAD_INPUT } else { FAILED }, format!("{e:#}"))
    })
}

fn default_run() -> run_args::RunArgs {
    #[derive(Parser)]
    struct Defaults {
        #[command(flatten)]
        run: run_args::RunArgs,
    }
    Defaults::parse_from(["seeds"]).run
}
