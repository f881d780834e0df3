//! Scene files: text to checked values, with file, line and key in every error.
//!
//! One TOML file says everything of a run; the data that it names (airport, movements, types) stand
//! beside it. [`load`] reads and checks all of it. Each section of the file has its module:
//! [`run`], [`airport`], [`traffic`], [`weather`], [`sensors`], [`tracking`], [`network`]; they read
//! through [`document::Section`], so adding a key is one line and its errors come by themselves.

mod advice;
pub mod airport;
pub mod board;
pub mod building;
pub mod change;
pub mod control;
pub mod document;
pub mod driven;
pub mod edit;
pub mod entity;
pub mod error;
pub mod external;
pub mod files;
pub mod footprints;
mod hash;
pub mod hours;
pub mod keys;
pub mod losses;
pub mod movements;
pub mod network;
mod places;
pub mod reference;
pub mod run;
pub mod schedule;
pub mod sensors;
pub mod shapes;
pub mod template;
pub mod tracking;
pub mod traffic;
pub mod types;
pub mod vary;
pub mod via;
pub mod warnings;
pub mod weather;

pub use airport::AirportScene;
pub use entity::Entity;
pub use error::{Problem, ScenarioError};
pub use external::External;
pub use network::Network;
pub use run::Run;
pub use schedule::handover;
pub use sensors::{AsdeScene, ForeignScene, ForeignSource, SensorScene};
pub use tracking::{Accuracy, Tracking};
pub use traffic::Traffic;
pub use weather::WeatherNotice;

use models::flight_list::FlightList;
use models::sensors::radar::shadow::Building;
use std::path::{Component, Path, PathBuf};

/// Everything of a run, as plain checked values.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name: the file's name without its ending.
    pub name: String,
    /// The scene file.
    pub path: PathBuf,
    /// 64-bit hash of the scene's values and its data files (not of `[network]` and `[external]`, nor of layout and
    /// comments): federates with another one play another scene.
    pub hash: u64,
    /// `[run]`.
    pub run: Run,
    /// `[airport]`.
    pub airport: AirportScene,
    /// `[[traffic]]`.
    pub traffic: Traffic,
    /// What the operator knows of the traffic.
    pub flight_list: FlightList,
    /// `[weather]`, sorted by time; the first notice is at time 0.
    pub weather: Vec<WeatherNotice>,
    /// `[[building]]`: what shadows and mirrors targets.
    pub buildings: Vec<Building>,
    /// `[[board]]`: plates in the eye's view.
    pub boards: Vec<board::Board>,
    /// `[[sensor]]`, in the order of the file.
    pub sensors: Vec<SensorScene>,
    /// `[tracking]`.
    pub tracking: Tracking,
    /// `[accuracy]`.
    pub accuracy: Accuracy,
    /// `[control]`.
    pub control: control::ControlScene,
    /// `[network]`: defaults for what the command line may say.
    pub network: Network,
    /// `[external]`: the same for what a gateway does.
    pub external: External,
    /// What is read and kept, but says less than its author may think: a line each, with file and line.
    pub warnings: Vec<String>,
    /// The data files that it names.
    pub files: Vec<PathBuf>,
}

impl Scene {
    /// Visibility of the weather from a time on, m, in the order of time.
    #[must_use]
    pub fn visibility_m(&self) -> Vec<(models::time::SimTime, f64)> {
        self.weather.iter().map(|notice| (notice.time, notice.weather.visibility_m)).collect()
    }

    /// What the scene tolerates against everything simulated exactly.
    #[must_use]
    pub fn tolerance(&self) -> models::effects::Tolerance {
        self.accuracy.tolerance(self.tracking.config.filter.q)
    }

    /// The scene's text and every data file that it names, each by its path from the scene's folder: what is needed to
    /// read it again where it is gone.
    ///
    /// # Errors
    /// If one cannot be read any more.
    pub fn sources(&self) -> std::io::Result<Vec<(String, Vec<u8>)>> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        // Below an empty folder (a scene where one stands) there is every path.
        let below = |path: &Path| path.components().all(|c| matches!(c, Component::Normal(_)));
        let name = |path: &Path| {
            let short = path.strip_prefix(files::SHIPPED).or_else(|_| path.strip_prefix(folder));
            let short = short.ok().filter(|short| below(short));
            let short = short.unwrap_or(Path::new(path.file_name().unwrap_or_default()));
            short.to_string_lossy().into_owned()
        };
        let mut all: Vec<&PathBuf> = std::iter::once(&self.path).chain(&self.files).collect();
        all.dedup();
        let read = |path: &&PathBuf| Ok((name(path), files::read(path, LARGEST_DATA)?));
        all.iter().map(read).collect()
    }

    /// What the tracker is told: `[tracking]` with the scene's sensors and types.
    #[must_use]
    pub fn tracking_config(&self) -> models::fusion::TrackingConfig {
        let airport = &self.airport.layout;
        tracking::complete(&self.tracking, &self.sensors, &self.traffic.types, airport)
    }
}

/// Names of the tables and keys of a scene's root.
fn sections() -> Vec<&'static str> {
    let tables = keys::TABLES.iter().map(|table| table.word);
    tables.chain(keys::ROOT.iter().map(|key| key.word)).collect()
}

/// Reads a scene and every file that it names.
///
/// # Errors
/// The first fault found, as one line: `file:line: key: what was found, what is allowed`.
pub fn load(path: &Path) -> Result<Scene, ScenarioError> {
    read(path, &text_of(path)?, TruthOf::All)
}

/// [`load`] without making movements: [`Entity::trajectory`] and [`Entity::report`] stay empty, all
/// else is the same, the hash included. For everybody who does not play the truth; a recording that
/// no truth can be made of is found by [`load`] only.
///
/// # Errors
/// As [`load`].
pub fn load_without_truth(path: &Path) -> Result<Scene, ScenarioError> {
    read(path, &text_of(path)?, TruthOf::Nobody)
}

/// [`load`] with the movements of share `share` (from 1) of `of` only, as [`in_share`] deals them out.
///
/// # Errors
/// As [`load`], faults of other shares' movements excepted.
pub fn load_share(path: &Path, share: u32, of: u32) -> Result<Scene, ScenarioError> {
    read(path, &text_of(path)?, TruthOf::Share(share, of))
}

/// Whether the mover that stands at `index` of the scene belongs to share `share` (from 1) of `of`.
#[must_use]
pub fn in_share(index: usize, share: u32, of: u32) -> bool {
    index as u32 % of == share - 1
}

/// Whose movements are made when a scene is read.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TruthOf {
    All,
    Nobody,
    Share(u32, u32),
}

impl TruthOf {
    /// Whether the mover at `index` is among them.
    fn has(self, index: usize) -> bool {
        match self {
            Self::All => true,
            Self::Nobody => false,
            Self::Share(share, of) => in_share(index, share, of),
        }
    }
}

/// [`load`] for the text of a scene that would stand at `path`; files count from its folder.
///
/// # Errors
/// As [`load`].
pub fn load_text(path: &Path, text: &str) -> Result<Scene, ScenarioError> {
    read(path, text, TruthOf::All)
}

/// Octets of the largest file that a scene names: a world of airports is larger, one airport is not.
pub(crate) const LARGEST_DATA: u64 = 64 << 20;

/// Octets of the largest scene: ten thousand movers with everything that they can have.
const LARGEST_SCENE: u64 = 16 << 20;

/// The text of a scene file.
///
/// # Errors
/// One sentence if it is not there (and how to have one), too long, or not UTF-8.
pub fn text_of(path: &Path) -> Result<String, ScenarioError> {
    let refuse = |line, reason: String| {
        let problem = Problem::Unreadable { reason };
        ScenarioError::new(path, line, "scene", problem)
    };
    let octets = files::read(path, LARGEST_SCENE).map_err(|error| {
        let no_path = path.components().count() == 1 && path.extension().is_none();
        let unknown = error.kind() == std::io::ErrorKind::NotFound && no_path;
        let known = if unknown { shipped_scenes() } else { String::new() };
        let missing = error.kind() == std::io::ErrorKind::NotFound;
        refuse(
            0,
            match (known.is_empty(), missing) {
                (false, _) => format!("{error}; scenes that come with SEEDS: {known}"),
                (true, true) => format!("{error}; {HOW_TO_HAVE_ONE}"),
                (true, false) => error.to_string(),
            },
        )
    })?;
    String::from_utf8(octets).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..at].iter().filter(|o| **o == b'\n').count();
        refuse(line, "not UTF-8 text".to_owned())
    })
}

/// What helps where a scene file is not there.
const HOW_TO_HAVE_ONE: &str =
    "`seeds scene new AIRPORT -o FILE` writes one that runs, and `seeds run asmgcs` needs no file";

/// Names of the scenes where [`locate`] looks.
fn shipped_scenes() -> String {
    let folders = data_folders(Path::new("scenarios/scene"));
    let mut names: Vec<String> = folders.iter().flat_map(|f| files::toml_names(f)).collect();
    names.retain(|name| format!("{name}.toml") != shapes::FILE);
    names.sort();
    names.dedup();
    names.join(", ")
}

fn read(path: &Path, text: &str, truth_of: TruthOf) -> Result<Scene, ScenarioError> {
    let root = document::Section::parse(path, text)?;
    root.only(&sections())?;
    let run = run::read(&root, schedule::start_utc_ns)?;
    let (airport, mut files) = airport::read(&root)?;
    let (weather, mut warnings) = weather::read(&root, &run)?;
    warnings.extend(weather::too_dense(&weather, airport.reference.height_m));
    let accuracy = tracking::read_accuracy(&root)?;
    let network = network::read(&root)?;
    let external = external::read(&root)?;
    let (shapes, shape_files, noticed) = shapes::read(&root)?;
    files.extend(shape_files);
    warnings.extend(noticed);
    let (traffic, flight_list, traffic_files) =
        traffic::read(&root, &run, (&airport, weather::days(&weather)), shapes, truth_of)?;
    files.extend(traffic_files);
    let buildings = building::read(&root, &airport)?;
    let boards = board::read(&root, &airport)?;
    let control = control::read(&root)?;
    // Traffic that behaves is watched also where the scene does not say by what.
    let lacks = traffic.behaving.is_some() && !(root.has("tracking") && root.has("sensor"));
    let standard = lacks.then(|| control::standard(path, &airport)).transpose()?;
    let of = |key: &str| standard.as_ref().filter(|_| !root.has(key)).unwrap_or(&root);
    let tracking = tracking::read(of("tracking"))?;
    let (sensors, sensor_files) =
        sensors::read(of("sensor"), &run, &airport, &traffic, &buildings)?;
    files.extend(sensor_files);
    let radars = sensors.iter().filter_map(|s| s.asde.as_ref());
    warnings.extend(radars.flat_map(|radar| radar.warnings.iter().cloned()));
    let left_out = traffic.behaving.iter().flat_map(|b| &b.left_out);
    warnings.extend(left_out.map(|line| format!("traffic: {line}")));
    let hash = scene_hash(&root, &files)?;
    let name = path.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let path = path.to_path_buf();
    Ok(Scene {
        name,
        path,
        hash,
        run,
        airport,
        traffic,
        flight_list,
        weather,
        buildings,
        boards,
        sensors,
        tracking,
        accuracy,
        control,
        network,
        external,
        warnings,
        files,
    })
}

/// The scene file for what a user typed: a path, or the bare name of a scene (`zurich`).
///
/// Looked for in this order: as a path; in `./scenarios`; beside the executable in `scenarios`; inside
/// the executable.
#[must_use]
pub fn locate(typed: &str) -> PathBuf {
    let as_path = PathBuf::from(typed);
    if as_path.exists() || as_path.components().count() > 1 || as_path.extension().is_some() {
        return as_path;
    }
    let file = format!("{typed}.toml");
    let beside_executable = std::env::current_exe()
        .ok()
        .and_then(|exe| exe.parent().map(|folder| folder.join("scenarios").join(&file)));
    let candidates =
        [Some(Path::new("scenarios").join(&file)), beside_executable, Some(files::shipped(&file))];
    candidates.into_iter().flatten().find(|p| files::is_file(p)).unwrap_or(as_path)
}

/// Where data are looked for that a scene names, in this order: beside the scene, beside the
/// executable, and inside it.
pub(crate) fn data_folders(scene: &Path) -> Vec<PathBuf> {
    let executable = std::env::current_exe().ok();
    let folders = [
        Some(scene.parent().unwrap_or(Path::new("")).to_path_buf()),
        executable.as_deref().and_then(Path::parent).map(|folder| folder.join("scenarios")),
        Some(PathBuf::from(files::SHIPPED)),
    ];
    folders.into_iter().flatten().collect()
}

/// A data file that a scene names: the first one there is in [`data_folders`]; one that was elsewhere and is gone may lie beside the
/// scene, where the log of a run puts it.
pub(crate) fn data_file(scene: &Path, name: &str) -> PathBuf {
    let named = Path::new(name);
    let elsewhere = !named.components().all(|c| matches!(c, Component::Normal(_)));
    let file = named.file_name().filter(|_| elsewhere);
    let beside = file.map(|file| scene.parent().unwrap_or(Path::new("")).join(file));
    let candidates = data_folders(scene).into_iter().map(|folder| folder.join(name));
    let mut candidates = candidates.chain(beside);
    candidates.find(|path| files::is_file(path)).unwrap_or(files::shipped(name))
}

/// Hash of the values of the scene (without `[network]` and `[external]`) and of its data files by name and content.
fn scene_hash(root: &document::Section, files: &[PathBuf]) -> Result<u64, ScenarioError> {
    let mut hash = hash::Fnv::default();
    for key in sections().iter().filter(|key| match **key {
        "network" | "external" => false,
        "control" | "failure" | "shape" | "shapes" => root.has(key),
        _ => true,
    }) {
        hash.tagged(10, key.as_bytes());
        root.feed_key(key, &mut hash);
    }
    let mut sorted: Vec<_> = files.iter().collect();
    sorted.sort_by_key(|p| p.file_name().map(ToOwned::to_owned));
    sorted.dedup();
    for file in sorted {
        let octets = files::read(file, LARGEST_DATA).map_err(|error| {
            let problem = Problem::File { path: file.clone(), reason: error.to_string() };
            ScenarioError::new(file, 1, "file", problem)
        })?;
        let name = file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        hash.tagged(11, name.as_bytes());
        hash.tagged(12, &octets);
    }
    Ok(hash.value())
}
