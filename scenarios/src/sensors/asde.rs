//! `kind = "asde"`: a named parameter set, single parameters that differ, and the place of the antenna.
//!
//! A set is a file `parameter-sets/NAME.toml` beside the scene, or one that ships. Limits stand with
//! the model; what it refuses is reported with the line that said it.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::{Scene, SensorScene};
use models::effects::Tolerance;
use models::environment::fog::FogLaw;
use models::environment::surface::{MATERIALS, Material};
use models::frames::{Point2, Point3};
use models::sensors::asde::{ALL_KEYS, Asde, AsdeParameters, DetectionRule, Energy, GLINT_SIGMA_M};
use models::sensors::config::ConfigError;
use models::sensors::radar::detection::Swerling;
use models::sensors::radar::effects::VALUE_KEYS;
use models::sensors::radar::effects::value::OwnKeys;
use models::sensors::radar::equation::Polarisation;
use models::sensors::radar::levels::Processing;
use std::path::{Path, PathBuf};

/// A surface movement radar of a scene, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct AsdeScene {
    /// Its parameters, with the antenna height of the site.
    pub parameters: AsdeParameters,
    /// How its echoes become plots: `processing = "plot"`, `"cells"` or `"video"`; `None` for
    /// `"auto"`, where the effect plan chooses.
    pub processing: Option<Processing>,
    /// What is usable but reaches beyond its source, one line each.
    pub warnings: Vec<String>,
}

impl AsdeScene {
    /// The radar at its place among the scene's buildings, planned for the scene's accuracy.
    ///
    /// # Errors
    /// A parameter outside its limits; a scene that was read has none.
    pub fn radar(&self, scene: &Scene, sensor: &SensorScene) -> Result<Asde, ConfigError> {
        self.radar_for(scene, sensor, scene.tolerance())
    }

    /// The same, planned for another tolerance.
    ///
    /// # Errors
    /// As [`Self::radar`].
    pub fn radar_for(
        &self,
        scene: &Scene,
        sensor: &SensorScene,
        tolerance: Tolerance,
    ) -> Result<Asde, ConfigError> {
        let site_m = sensor.site_m.map_or_else(Point2::origin, |site| site.xy());
        let made = Asde::new(sensor.id, site_m, self.parameters.clone())?
            .among(scene.buildings.clone().into())
            .tolerating(tolerance);
        Ok(match self.processing {
            Some(processing) => made.processing(processing),
            None => made,
        })
    }
}

/// A parameter set that ships, by name.
///
/// # Errors
/// If there is none of that name.
pub fn shipped(name: &str) -> Result<AsdeParameters, ScenarioError> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let section = Section::parse(&here, &format!("parameters = \"{name}\""))?;
    let (scene, _) = read(&section, &section.empty("overrides"), Point3::origin())?;
    Ok(scene.parameters)
}

const PROCESSING: [(&str, Option<Processing>); 4] = [
    ("auto", None),
    ("plot", Some(Processing::Plot)),
    ("cells", Some(Processing::Cells)),
    ("video", Some(Processing::Video)),
];

/// Reads the parameters of one radar. `name` is the set's, from the key `parameters` of `section`.
/// The second value is the set's file.
pub(super) fn read(
    section: &Section,
    overrides: &Section,
    site_m: Point3<f64>,
) -> Result<(AsdeScene, PathBuf), ScenarioError> {
    let name = section.need_text("parameters", "the name of a parameter set, like \"ku_asde3\"")?;
    let file = locate(section, name)?;
    let text = crate::files::read_text(&file, crate::LARGEST_DATA).map_err(|error| {
        let problem = Problem::File { path: file.clone(), reason: error.to_string() };
        section.refuse("parameters", problem)
    })?;
    let set = Section::parse(&file, &text)?;
    let allowed: Vec<&str> = ALL_KEYS.iter().copied().flatten().map(|key| key.word).collect();
    set.only(&allowed)?;
    overrides.only(&allowed)?;
    let processing = section.choice("processing", &PROCESSING)?.flatten();
    let layers = Layers { set: &set, overrides };
    let mut parameters = layers.parameters()?;
    // A site with a height says where the antenna is; one without leaves it to the set.
    let has_height = section.any_section("site")?.is_some_and(|site| site.has("height_m"));
    let from_site = has_height && !overrides.has("antenna_height_m");
    if from_site {
        parameters.antenna_height_m = site_m.z;
    }
    match parameters.validate() {
        Ok(warnings) => {
            let warnings = warnings
                .into_iter()
                .map(|w| {
                    let place = layers.of(w.key);
                    let line = place.line_of(w.key);
                    format!("{}:{line}: {}: {}", place.file().display(), path(place), w.text)
                })
                .collect();
            Ok((AsdeScene { parameters, processing, warnings }, file))
        }
        Err(error) => Err(layers.refuse(section, from_site, error)),
    }
}

fn path(section: &Section) -> &str {
    if section.path().is_empty() { "parameter set" } else { section.path() }
}

/// The file of a parameter set: beside the scene, beside the executable, or inside it.
fn locate(section: &Section, name: &str) -> Result<PathBuf, ScenarioError> {
    let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    let folders: Vec<PathBuf> = crate::data_folders(section.file())
        .into_iter()
        .map(|folder| folder.join("parameter-sets"))
        .collect();
    let file = format!("{name}.toml");
    let found =
        folders.iter().map(|folder| folder.join(&file)).find(|path| crate::files::is_file(path));
    if let (true, Some(path)) = (plain, found) {
        return Ok(path);
    }
    let mut names: Vec<String> =
        folders.iter().flat_map(|folder| crate::files::toml_names(folder)).collect();
    names.sort();
    names.dedup();
    let allowed: Vec<_> = names.iter().map(|n| format!("\"{n}\"")).collect();
    let problem = Problem::NotAllowed { found: name.into(), allowed: allowed.join(", ") };
    Err(section.refuse("parameters", problem))
}

/// The set and what differs from it.
struct Layers<'a> {
    set: &'a Section,
    overrides: &'a Section,
}

impl Layers<'_> {
    fn of(&self, key: &str) -> &Section {
        if self.overrides.has(key) { self.overrides } else { self.set }
    }

    /// A number of any size: the model checks it.
    fn number(&self, key: &str) -> Result<f64, ScenarioError> {
        self.of(key).need_number(key, within(f64::NEG_INFINITY, f64::INFINITY, ""))
    }

    fn optional(&self, key: &str) -> Result<Option<f64>, ScenarioError> {
        self.of(key).number(key, within(f64::NEG_INFINITY, f64::INFINITY, ""))
    }

    fn choice<T: Clone>(&self, key: &str, allowed: &[(&str, T)]) -> Result<T, ScenarioError> {
        let words: Vec<_> = allowed.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        let needed = || format!("one of {}", words.join(", "));
        self.of(key).choice(key, allowed)?.ok_or_else(|| self.of(key).missing(key, needed()))
    }

    /// The model's refusal at the line that gave the value.
    fn refuse(&self, section: &Section, from_site: bool, error: ConfigError) -> ScenarioError {
        let key = error.key();
        if key == "antenna_height_m" && from_site {
            return section.refused_by_model("site", error);
        }
        // "carrier_ghz (for this surface)" and the like begin with the parameter's key.
        let plain = key.split(' ').next().unwrap_or(key);
        if ALL_KEYS.iter().copied().flatten().any(|key| key.word == plain) {
            self.of(plain).refused_by_model(plain, error)
        } else {
            section.refused_by_model("parameters", error)
        }
    }

    fn parameters(&self) -> Result<AsdeParameters, ScenarioError> {
        let pulse_s = self.number("pulse_s")?;
        let surfaces: Vec<(&str, &'static Material)> =
            MATERIALS.iter().map(|m| (m.name, m)).collect();
        let swerling = self.of("swerling").integer("swerling", 0, 4)?;
        let energy = match self.choice("energy", &[("single_pulse", false), ("dwell", true)])? {
            false => Energy::SinglePulse,
            true => Energy::Dwell { factor: self.optional("dwell_factor")?.unwrap_or(1.5) },
        };
        let mut own = OwnKeys::new();
        for key in VALUE_KEYS.iter().copied().flatten() {
            if let Some(value) = self.optional(key.word)? {
                own.insert(key.word, value);
            }
        }
        Ok(AsdeParameters {
            carrier_ghz: self.number("carrier_ghz")?,
            peak_power_w: self.number("peak_power_w")?,
            pulse_s,
            bandwidth_hz: self.optional("bandwidth_hz")?.unwrap_or(1.0 / pulse_s),
            noise_figure_db: self.number("noise_figure_db")?,
            system_loss_db: self.number("system_loss_db")?,
            azimuth_beamwidth_deg: self.number("azimuth_beamwidth_deg")?,
            elevation_beamwidth_deg: self.number("elevation_beamwidth_deg")?,
            tilt_deg: self.number("tilt_deg")?,
            csc2_limit_deg: self.optional("csc2_limit_deg")?,
            gain_dbi: self.number("gain_dbi")?,
            antenna_height_m: self.number("antenna_height_m")?,
            prf_hz: self.number("prf_hz")?,
            rotation_rpm: self.number("rotation_rpm")?,
            start_azimuth_deg: self.optional("start_azimuth_deg")?.unwrap_or(0.0),
            polarisation: self.choice(
                "polarisation",
                &[
                    ("circular", Polarisation::Circular),
                    ("horizontal", Polarisation::Horizontal),
                    ("vertical", Polarisation::Vertical),
                ],
            )?,
            axial_ratio_db: self.number("axial_ratio_db")?,
            circular_target_loss_db: self.number("circular_target_loss_db")?,
            sidelobe_floor_db: self.number("sidelobe_floor_db")?,
            recovery_s: self.number("recovery_s")?,
            range_min_m: self.number("range_min_m")?,
            range_max_m: self.number("range_max_m")?,
            pfa: self.number("pfa")?,
            pd: self.number("pd")?,
            detection: self.choice(
                "detection",
                &[("threshold", DetectionRule::Threshold), ("bernoulli", DetectionRule::Bernoulli)],
            )?,
            swerling: swerling
                .and_then(|case| Swerling::case(case.unsigned_abs()))
                .ok_or_else(|| self.of("swerling").missing("swerling", "a case 0 to 4".into()))?,
            energy,
            range_step_m: self.number("range_step_m")?,
            azimuth_step_deg: self.number("azimuth_step_deg")?,
            assumed_height_m: self.number("assumed_height_m")?,
            frequency_agile: self
                .of("frequency_agile")
                .flag("frequency_agile")?
                .ok_or_else(|| self.set.missing("frequency_agile", "true or false".into()))?,
            rain_spread_mps: self.number("rain_spread_mps")?,
            glint_sigma_m: self.optional("glint_sigma_m")?.unwrap_or(GLINT_SIGMA_M),
            reflection_coupling: self.number("reflection_coupling")?,
            ground_gamma_db: self.number("ground_gamma_db")?,
            surface: self.choice("surface", &surfaces)?,
            roughness_m: self.number("roughness_m")?,
            rain_top_m: self.number("rain_top_m")?,
            fog_law: self.choice(
                "fog_law",
                &[("two_point", FogLaw::TwoPoint), ("eldridge", FogLaw::Eldridge)],
            )?,
            own,
        })
    }
}
