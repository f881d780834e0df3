//! `[airport]`: layout files, reference point, frame.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use geodesy::{Geodetic, LocalFrame};
use models::airport::Airport;
use models::frames::{Point2, Point3};
use std::path::{Path, PathBuf};

mod apt_dat;
mod findings;
mod groundnet;
mod network_csv;
mod osm;
mod overlay;

pub(crate) use findings::NO_NETWORK;

/// The airport of a scene with its place on the earth.
#[derive(Clone, Debug, PartialEq)]
pub struct AirportScene {
    /// Runways, ground network, stands, pavement in local metres.
    pub layout: Airport,
    /// Origin of the local frame: aerodrome reference point at field elevation.
    pub reference: Geodetic,
    /// The local frame: metres east, north, up at the reference point.
    pub frame: LocalFrame,
    /// Distance from the reference point up to which things belong to the airport, m.
    pub radius_m: f64,
    /// Eye of a tower controller where the scene says it (`[airport] tower`), m.
    pub cab_m: Option<Point3<f64>>,
    /// What was found and mended in the layout files.
    pub report: LayoutReport,
}

/// What the reading of layout files found, for people: one line each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayoutReport {
    /// Lines of text: what was read, mended, left out and assumed.
    pub lines: Vec<String>,
    /// What [`check`] found in the layout as a whole.
    pub findings: Vec<String>,
}

/// Reads `[airport]` and the files that it names. The second value lists those files.
pub(crate) fn read(root: &Section) -> Result<(AirportScene, Vec<PathBuf>), ScenarioError> {
    let section = root
        .section("airport", &words(keys::AIRPORT))?
        .ok_or_else(|| root.missing("airport", "a table [airport]".into()))?;
    let layout_file = section
        .file_path("layout")?
        .ok_or_else(|| section.missing("layout", "the name of an apt.dat file".into()))?;
    let network_file = section.file_path("ground_network")?;
    let overlay_file = section.file_path("overlay")?;
    let width_m = section.number_or("taxiway_width_m", ASSUMED_WIDTH_M, within(5.0, 100.0, "m"))?;
    let raw = Layout::read(&layout_file)?;
    if let Some(icao) = section.text("icao")?
        && !raw.icao().is_empty()
        && icao != raw.icao()
    {
        let problem =
            Problem::NotAllowed { found: icao.into(), allowed: format!("\"{}\"", raw.icao()) };
        return Err(section.refuse("icao", problem));
    }
    let reference = match section.section("reference", &words(keys::REFERENCE))? {
        None => raw.reference(),
        Some(point) => Geodetic::from_degrees(
            point.need_number("lat_deg", LATITUDE)?,
            point.need_number("lon_deg", LONGITUDE)?,
            point.need_number("height_m", within(-500.0, 9000.0, "m"))?,
        ),
    };
    let frame = LocalFrame::at(reference);
    let mut report = LayoutReport::default();
    let mut files = raw.files(&layout_file);
    let mut layout = Airport::default();
    raw.into_airport(&frame, width_m, &mut layout, &mut report);
    if let Some(file) = &network_file {
        let network = Layout::read(file)?;
        files.extend(network.files(file));
        network.into_airport(&frame, width_m, &mut layout, &mut report);
    }
    layout.details.mend_crossings = section.flag("mend_crossings")?.unwrap_or(false);
    let radius_m = section.number_or("radius_m", 10_000.0, within(500.0, 50_000.0, "m"))?;
    let mut airport = AirportScene { layout, reference, frame, radius_m, cab_m: None, report };
    if let Some(file) = overlay_file {
        overlay::apply(&mut airport, &file)?;
        files.push(file);
    }
    if let Some(tower) = section.section("tower", &words(keys::TOWER))? {
        let height_m = tower.need_number("cab_height_m", within(1.0, 300.0, "m"))?;
        airport.cab_m = Some(airport.place_above(&tower, height_m)?);
    }
    Ok((airport, files))
}

/// A layout file of any known kind, told by its name.
#[derive(Debug)]
enum Layout {
    AptDat(Box<apt_dat::AptDat>),
    GroundNet(groundnet::GroundNet),
    Tables(network_csv::Tables),
    Osm(osm::Osm),
}

impl Layout {
    fn read(path: &Path) -> Result<Self, ScenarioError> {
        let is_xml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("xml"));
        if is_xml {
            groundnet::read(path).map(Self::GroundNet)
        } else if network_csv::is_nodes_table(path) {
            network_csv::read(path).map(Self::Tables)
        } else if osm::is_osm(path) {
            osm::read(path).map(Self::Osm)
        } else {
            apt_dat::read(path).map(|raw| Self::AptDat(Box::new(raw)))
        }
    }

    /// The location indicator that it states, if it does.
    fn icao(&self) -> &str {
        if let Self::AptDat(raw) = self { &raw.icao } else { "" }
    }

    fn reference(&self) -> Geodetic {
        match self {
            Self::AptDat(raw) => raw.reference(),
            Self::GroundNet(raw) => raw.reference(),
            Self::Tables(raw) => raw.reference(),
            Self::Osm(raw) => raw.reference(),
        }
    }

    /// The file and those that belong to it.
    fn files(&self, path: &Path) -> Vec<PathBuf> {
        let mut files = vec![path.to_path_buf()];
        if let Self::Tables(raw) = self {
            files.push(raw.edges_file().to_path_buf());
        }
        files
    }

    /// Puts what it has into `airport`; a network replaces the one that is there.
    fn into_airport(
        self,
        frame: &LocalFrame,
        width_m: f64,
        airport: &mut Airport,
        report: &mut LayoutReport,
    ) {
        match self {
            Self::AptDat(raw) => *airport = raw.into_airport(frame, width_m, report),
            Self::GroundNet(raw) => raw.into_airport(frame, width_m, airport, report),
            Self::Tables(raw) => raw.into_airport(frame, width_m, airport, report),
            Self::Osm(raw) => raw.into_airport(frame, width_m, airport, report),
        }
    }
}

/// Reads one layout file (apt.dat; `.xml`: ground network; `nodes.csv` with its `edges.csv`; `.json` or
/// `.geojson`: OpenStreetMap) and says what is in it; coordinates count from the middle of its runways, or
/// of its network.
///
/// # Errors
/// If the file cannot be read or is damaged; the error names the line.
pub fn check(path: &Path) -> Result<(Airport, LayoutReport), ScenarioError> {
    check_files(&[path.to_path_buf()], None)
}

/// [`check`] for a layout and the files that complete it (a network; `.toml`: an overlay), around `reference` if given.
///
/// # Errors
/// As [`check`].
pub fn check_files(
    paths: &[PathBuf],
    reference: Option<Geodetic>,
) -> Result<(Airport, LayoutReport), ScenarioError> {
    let (mut report, mut layout) = (LayoutReport::default(), Airport::default());
    let mut frame = reference.map(LocalFrame::at);
    let is_overlay = |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let (overlays, layouts): (Vec<&PathBuf>, Vec<&PathBuf>) =
        paths.iter().partition(|p| is_overlay(p));
    if let (Some(overlay), true) = (overlays.first(), layouts.is_empty()) {
        let reason = "an overlay changes a layout: name that one first".into();
        return Err(ScenarioError::new(overlay, 0, "layout", Problem::Unreadable { reason }));
    }
    for path in layouts {
        let raw = Layout::read(path)?;
        let frame = frame.get_or_insert_with(|| LocalFrame::at(raw.reference()));
        raw.into_airport(frame, ASSUMED_WIDTH_M, &mut layout, &mut report);
    }
    if !layout.edges.is_empty() {
        let width = format!("width of every taxiway: {ASSUMED_WIDTH_M} m (assumed)");
        report.lines.push(width);
    }
    if let Some(frame) = frame.filter(|_| !overlays.is_empty()) {
        let reference = frame.origin_geodetic();
        let mut airport =
            AirportScene { layout, reference, frame, radius_m: 50_000.0, cab_m: None, report };
        overlays.into_iter().try_for_each(|file| overlay::apply(&mut airport, file))?;
        (layout, report) = (airport.layout, airport.report);
    }
    report.findings = findings::of(&layout);
    Ok((layout, report))
}

/// The files that a name means: a file that is there; else one that comes with SEEDS, by its own name
/// (`airports/LSZH.apt.dat`) or by the airport's (`LSZH`: its layout, and the ground network beside it).
#[must_use]
pub fn files_meant(name: &Path) -> Vec<PathBuf> {
    let shipped =
        |name: &str| Some(crate::files::shipped(name)).filter(|path| crate::files::is_file(path));
    let text = name.to_str().filter(|_| !crate::files::is_file(name));
    let Some(text) = text else { return vec![name.to_path_buf()] };
    let by_airport = crate::files::layout_of(text).map(|layout| {
        let network = layout.replace(".apt.dat", ".groundnet.xml");
        let network = Some(network).filter(|n| *n != layout);
        shipped(&layout).into_iter().chain(network.and_then(|n| shipped(&n))).collect()
    });
    let found = by_airport.or_else(|| shipped(text).map(|path| vec![path]));
    found.unwrap_or_else(|| vec![name.to_path_buf()])
}

/// Width of taxiways where the scene does not say it, m: that of code letter D and E.
const ASSUMED_WIDTH_M: f64 = 23.0;

impl AirportScene {
    /// East and north of a place at field elevation, m.
    #[must_use]
    pub fn local_m(&self, lat_deg: f64, lon_deg: f64) -> Point2<f64> {
        local_m(&self.frame, lat_deg, lon_deg)
    }

    /// A point so many metres above the `place` of a table.
    pub(crate) fn place_above(
        &self,
        table: &Section,
        height_m: f64,
    ) -> Result<Point3<f64>, ScenarioError> {
        let place = table.any_section("place")?.ok_or_else(|| {
            let needed = "a place: { east_m = …, north_m = … } or { lat_deg = …, lon_deg = … }";
            table.missing("place", needed.into())
        })?;
        let at = self.site(&place)?;
        Ok(Point3::new(at.x, at.y, at.z + height_m))
    }

    /// A place from `lat_deg`/`lon_deg` or `east_m`/`north_m` (also `x_m`/`y_m`), with `height_m` over the reference
    /// plane; refused outside the airport.
    ///
    /// # Errors
    /// If neither or both forms are given, a value is out of range, or the place is outside.
    pub fn site(&self, section: &Section) -> Result<Point3<f64>, ScenarioError> {
        section.only(&keys::place_words())?;
        let height_m = section.number_or("height_m", 0.0, within(0.0, 500.0, "m"))?;
        let forms = [["lat_deg", "lon_deg"], ["x_m", "y_m"], ["east_m", "north_m"]];
        let said = |form: &&[&'static str; 2]| form.iter().find(|k| section.has(k)).copied();
        let mut found = forms.iter().filter(|form| said(form).is_some());
        let form = found.next().unwrap_or(&forms[2]);
        if let Some(key) = found.next().and_then(|other| said(&other)) {
            let problem = Problem::WrongKind {
                found: "two places".into(),
                needed: "either lat_deg and lon_deg or east_m and north_m".into(),
            };
            return Err(section.refuse(key, problem));
        }
        let east_north = if form[0] == "lat_deg" {
            let lat_deg = section.need_number("lat_deg", LATITUDE)?;
            let lon_deg = section.need_number("lon_deg", LONGITUDE)?;
            self.local_m(lat_deg, lon_deg)
        } else {
            let limits = within(-1e6, 1e6, "m");
            Point2::new(
                section.need_number(form[0], limits)?,
                section.need_number(form[1], limits)?,
            )
        };
        let distance_m = east_north.coords.norm();
        if distance_m > self.radius_m {
            let problem = Problem::OutsideAirport { distance_m, limit_m: self.radius_m };
            return Err(section.refuse(form[0], problem));
        }
        Ok(Point3::new(east_north.x, east_north.y, height_m))
    }
}

/// The middle of places, latitude and longitude in degrees, at a height, m: also where they lie on both sides of 180 degrees.
fn middle(places: impl Iterator<Item = (f64, f64)> + Clone, height_m: f64) -> Geodetic {
    let count = places.clone().count().max(1) as f64;
    let (least, most) = places
        .clone()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.1), b.max(p.1)));
    let beyond = |lon: f64| if most - least > 180.0 && lon < 0.0 { lon + 360.0 } else { lon };
    let lat_deg = places.clone().map(|p| p.0).sum::<f64>() / count;
    let lon_deg = places.map(|p| beyond(p.1)).sum::<f64>() / count;
    let lon_deg = if lon_deg > 180.0 { lon_deg - 360.0 } else { lon_deg };
    Geodetic::from_degrees(lat_deg, lon_deg, height_m)
}

/// East and north of a place at the height of the frame's origin, m.
fn local_m(frame: &LocalFrame, lat_deg: f64, lon_deg: f64) -> Point2<f64> {
    let height_m = frame.origin_geodetic().height_m;
    let place = Geodetic::from_degrees(lat_deg, lon_deg, height_m).to_ecef();
    let enu = frame.to_enu(place);
    Point2::new(enu.east_m, enu.north_m)
}

/// Reads a whole file as text. Names in old files are not always UTF-8: such letters are replaced.
fn text_of(path: &Path) -> Result<String, ScenarioError> {
    let refused =
        |reason: String| ScenarioError::new(path, 0, "file", Problem::Unreadable { reason });
    let octets =
        crate::files::read_table(path, crate::LARGEST_DATA).map_err(|error| {
            match error.kind() {
                std::io::ErrorKind::NotFound => refused(format!(
                    "{error}; airports that come with SEEDS: {}",
                    crate::files::airports().join(", ")
                )),
                std::io::ErrorKind::FileTooLarge => {
                    refused(format!("{error}; needed is one airport"))
                }
                _ => refused(error.to_string()),
            }
        })?;
    let text = String::from_utf8_lossy(&octets);
    Ok(text.into_owned())
}

const LATITUDE: crate::document::Limits = within(-90.0, 90.0, "deg");
const LONGITUDE: crate::document::Limits = within(-180.0, 180.0, "deg");
