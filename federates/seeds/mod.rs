//! `seeds`: starts federations, and carries every federate and tool as a subcommand.

pub mod accuracy;
pub mod airport;
pub mod asterix;
pub mod asterix_file;
pub mod certs;
pub mod dis;
pub mod export;
mod fault_table;
pub mod federate_commands;
pub mod fit;
pub mod fork;
pub mod gateway;
pub mod in_process;
pub mod launch;
pub mod link_args;
pub mod open;
pub mod plan;
mod plan_report;
pub mod player;
pub mod record;
pub mod replay;
pub mod report;
pub mod run;
pub mod scene;
pub mod score;
pub mod score_asterix;
pub mod sim;
pub mod site;
pub mod sweep;
pub mod verify;
pub mod viewer_process;

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
    Run(Box<run::RunArgs>),
    Open(open::OpenArgs),
    Fork(fork::ForkArgs),
    Replay(Box<replay::ReplayArgs>),
    Plan(plan::PlanArgs),
    Site(Box<site::SiteArgs>),
    Accuracy(accuracy::AccuracyArgs),
    Fit(fit::FitArgs),
    Score(score::ScoreArgs),
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
    TrafficGenerator(federate_commands::TrafficArgs),
    ExternalWorld(federate_commands::WorldArgs),
    Smdfm(federate_commands::SmdfmArgs),
    Control(federate_commands::ControlArgs),
    Visitors(federate_commands::VisitorsArgs),
    Gateway(Box<gateway::GatewayArgs>),
    ViewerLogger(federate_commands::ViewerArgs),
    AdminStation(federate_commands::AdminArgs),
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
        Some(Command::Replay(args)) => replay::run(*args),
        Some(Command::Plan(args)) => plan::run(&args),
        Some(Command::Site(args)) => site::run(&args),
        Some(Command::Record(args)) => finished(record::run(args)),
        Some(Command::Dis(args)) => finished(dis::run(args)),
        Some(Command::Certs(args)) => certs::run(&args),
        Some(Command::Asterix(args)) => asterix::run(&args),
        Some(Command::Gateway(args)) => gateway::run(&args),
        Some(Command::Airport(args)) => airport::run(&args),
        Some(Command::Scene(args)) => scene::run(&args),
        Some(Command::Traffic(args)) => airport::traffic(&args),
        Some(Command::Accuracy(args)) => accuracy::run(&args),
        Some(Command::Fit(args)) => fit::run(&args),
        Some(Command::Score(args)) => score::run(&args),
        Some(Command::Export(args)) => export::run(&args),
        Some(Command::Sweep(args)) => sweep::run(&args),
        Some(Command::Sim(args)) => sim::run(&args),
        Some(Command::Verify(args)) => verify::run(&args),
        Some(Command::TrafficGenerator(args)) => federate_commands::traffic_generator(&args),
        Some(Command::ExternalWorld(args)) => federate_commands::external_world(&args),
        Some(Command::Smdfm(args)) => federate_commands::smdfm(&args),
        Some(Command::Control(args)) => federate_commands::control(&args),
        Some(Command::Visitors(args)) => federate_commands::visitors(&args),
        Some(Command::ViewerLogger(args)) => federate_commands::viewer_logger(&args),
        Some(Command::AdminStation(args)) => federate_commands::admin_station(&args),
        Some(Command::Completions { shell }) => {
            let mut command = Seeds::command();
            clap_complete::generate(shell, &mut command, "seeds", &mut std::io::stdout());
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

fn default_run() -> run::RunArgs {
    #[derive(Parser)]
    struct Defaults {
        #[command(flatten)]
        run: run::RunArgs,
    }
    Defaults::parse_from(["seeds"]).run
}
