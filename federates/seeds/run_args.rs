//! The command line of a whole federation on this host.

use crate::federation::{MOST_SMDFMS, RunOptions};
use crate::gateway::command::AsterixArgs;
use crate::runtime::cli::{self, CommonArgs, DEFAULT_PAGE, LogFormat, LossArgs, NetworkArgs};
use clap::Args;
use scenarios::Scene;
use scenarios::losses::ByMember;
use scenarios::network::agents_flag;
use std::net::SocketAddr;
use std::path::PathBuf;

/// The scene that a newcomer sees: everything that an A-SMGCS has, with one incursion.
pub const FIRST_SCENE: &str = "asmgcs";

/// Start all federates of a scene on this host
#[derive(Args, Clone, Debug)]
pub struct RunArgs {
    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(value_name = "SCENE", default_value = FIRST_SCENE)]
    pub scene: String,

    /// Simulated seconds per wall second, 0.001 to 1000
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = cli::rate, conflicts_with = "fast")]
    pub rate: f64,

    /// As fast as the slowest federate; ends with the run
    #[arg(long)]
    pub fast: bool,

    /// Simulated duration, s [default: the scene's]
    #[arg(long, value_name = "S", value_parser = cli::seconds)]
    pub duration: Option<f64>,

    /// Seed of all random draws but the flights of a generated demand, which the scene's seeds draw [default: the scene's]
    #[arg(long, value_name = "N", value_parser = cli::seed)]
    pub seed: Option<u64>,

    /// Address and port of the page; port 0: any free one
    #[arg(long, value_name = "ADDR:PORT", default_value = DEFAULT_PAGE, value_parser = cli::page)]
    pub page: SocketAddr,

    /// Without the page (and without the logger, unless --record or --report)
    #[arg(long)]
    pub no_viewer: bool,

    /// Record every datagram into this pcapng file, with the database (.sqlite) beside it
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,

    /// Write a report of the run (HTML, CSV, JSON) into this folder
    #[arg(long, value_name = "DIR", value_parser = cli::report_folder)]
    pub report: Option<PathBuf>,

    /// Keep what the station is told in FILE, which is removed when the run is over: where all processes are gone before that, and the host
    /// with them, `--continue FILE` goes on
    #[arg(long, value_name = "FILE", conflicts_with = "in_process")]
    pub journal: Option<PathBuf>,

    /// Go on with a run whose processes are all gone, from the journal that it kept (--journal FILE): everybody makes it again up to the last
    /// frame that all had ended. Scene, seed and flags are to be the same
    #[arg(long = "continue", value_name = "FILE", conflicts_with_all = ["journal", "in_process"])]
    pub continues: Option<PathBuf>,

    /// All federates in this process, over a bus in memory
    #[arg(long)]
    pub in_process: bool,

    /// Traffic generators that share the truth, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub generators: u32,

    /// SMDFMs that share the sensors, 1 to 8: the first fuses the plots of all
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SMDFMS)))]
    pub smdfms: u32,

    /// Do not start by itself: wait CONFIGURED for a start command
    #[arg(long)]
    pub wait: bool,

    /// Let outsiders' entities in also when as fast as possible; in real time they are, unless --no-visitors says otherwise
    #[arg(long, conflicts_with_all = ["no_visitors", "in_process"])]
    pub visitors: bool,

    /// Say again what people at controllers' seats said in another run: its database (.sqlite), or a line of JSON each
    #[arg(long, value_name = "FILE", conflicts_with = "no_visitors")]
    pub inputs: Option<PathBuf>,

    /// Nobody from outside is let in
    #[arg(long)]
    pub no_visitors: bool,

    /// DIS exercise identifier, 0 to 255 [default: the scene's]
    #[arg(long, value_name = "N")]
    pub exercise: Option<u8>,

    #[command(flatten)]
    pub(crate) asterix: AsterixArgs,

    #[command(flatten)]
    pub(crate) network: NetworkArgs,

    /// Endpoints of the agents (`seeds agent`) that start federates on other hosts, for all or by name as smdfm=tls/10.0.0.2:7450 [default: the scene's, else all run here]
    #[arg(long, value_name = "ENDPOINT", value_parser = agents_flag, conflicts_with = "in_process")]
    agents: Option<ByMember<String>>,

    #[command(flatten)]
    pub(crate) losses: LossArgs,

    /// Share of truth datagrams that the receivers drop on purpose, 0 to below 1
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = cli::share)]
    pub inject_loss: f64,

    /// Log lines on stderr: text for people, json for programs
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    pub log_format: LogFormat,
}

impl RunArgs {
    /// The options that the conductor needs.
    #[must_use]
    pub fn options(&self) -> RunOptions {
        RunOptions {
            seed: self.seed,
            duration_s: self.duration,
            rate: if self.fast { f64::INFINITY } else { self.rate },
            generators: self.generators,
            smdfms: self.smdfms,
            autostart: !self.wait,
            batch: self.fast || self.no_viewer || self.duration.is_some(),
            visitors: self.with_visitors(),
            losses: self.losses.losses(),
        }
    }

    pub(super) fn common(&self) -> CommonArgs {
        CommonArgs {
            scene: self.scene.clone(),
            exercise: self.exercise,
            network: self.network.clone(),
            inject_loss: self.inject_loss,
            log_format: self.log_format,
        }
    }

    /// Whether the member `visitors` takes part.
    #[must_use]
    pub fn with_visitors(&self) -> bool {
        let heard = !self.in_process && !self.no_visitors && (self.visitors || !self.fast);
        heard || self.inputs.is_some()
    }

    /// Who is started by an agent of another host.
    pub(super) fn agents(&self, scene: &Scene) -> ByMember<String> {
        self.agents.clone().unwrap_or_else(|| scene.network.agents.clone())
    }

    /// Where the administration station will listen. What a scene says of that holds where it names other hosts, too.
    pub(super) fn sync_endpoint(&self, scene: &Scene) -> String {
        let told = scene.network.sync_listen.first().filter(|_| self.agents(scene).is_given());
        let told = self.network.sync_listen.as_ref().or(told);
        told.cloned().unwrap_or_else(|| self.network.default_endpoint())
    }

    /// Checks what protects the synchronisation plane, before anything is started.
    pub(super) fn protection(&self) -> anyhow::Result<()> {
        if let Some(endpoint) = &self.network.sync_listen {
            self.network.check_listening(endpoint)?;
        }
        self.network.certs_of("admin-station").map(drop)
    }

    /// Whether a viewer-logger takes part.
    #[must_use]
    pub fn with_logger(&self) -> bool {
        !self.no_viewer || self.record.is_some() || self.report.is_some()
    }
}
