//! Candidate sites for one radar, compared by what its maps say of the movement area.

use crate::picture::Pavement;
use crate::siting::{Grid, Map, NO_DATA, Subject, nearest, radar_maps, weight};
use crate::siting_candidates::Candidate;
use models::environment::Weather;
use models::frames::Point2;
use models::sensors::asde::picture::Ground as _;
use scenarios::{Scene, SensorScene};
use serde_json::{Value, json};
use std::cmp::Ordering;
use std::fmt::Write as _;

/// Two-way loss by buildings from which a place is in shadow, dB.
const SHADOW_DB: f32 = 1.0;
/// Sigma up to which a place counts as covered, m.
const COVERED_SIGMA_M: f32 = 3.5;

/// By what candidates are ranked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Objective {
    /// Share of the movement area with Pd at or above the bound.
    Pd,
    /// The same, weighted (runways 4, taxiways 2, else 1), with sigma of 3.5 m or less besides.
    Covered,
    /// Worst Pd.
    WorstPd,
    /// Mean sigma.
    Sigma,
    /// Share in shadow.
    Shadow,
    /// Mean of the expected ghosts.
    Ghosts,
}

impl Objective {
    /// All, with their words.
    pub const WORDS: [(&str, Self); 6] = [
        ("pd", Self::Pd),
        ("covered", Self::Covered),
        ("worst-pd", Self::WorstPd),
        ("sigma", Self::Sigma),
        ("shadow", Self::Shadow),
        ("ghosts", Self::Ghosts),
    ];

    /// The one of a word.
    #[must_use]
    pub fn named(word: &str) -> Option<Self> {
        Self::WORDS.iter().find(|w| w.0 == word).map(|w| w.1)
    }

    /// Its value: less is better.
    fn cost(self, of: &Figures) -> f64 {
        match self {
            Self::Pd => -of.share,
            Self::Covered => -of.covered,
            Self::WorstPd => -of.worst_pd,
            Self::Sigma => of.sigma_m,
            Self::Shadow => of.shadow_share,
            Self::Ghosts => of.ghosts,
        }
    }
}

/// What the maps of a site say of the movement area. Places that the radar does not display have Pd 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Share with Pd at or above the bound.
    pub share: f64,
    /// Weighted share with Pd at or above the bound and sigma of 3.5 m or less.
    pub covered: f64,
    /// Least Pd.
    pub worst_pd: f64,
    /// Where that is, m east and north.
    pub worst_m: Point2<f64>,
    /// Mean sigma where there is one, m; infinite if nowhere.
    pub sigma_m: f64,
    /// Share with a two-way loss by buildings above 1 dB.
    pub shadow_share: f64,
    /// Mean of the expected ghosts per scan of a target.
    pub ghosts: f64,
}

/// How good a site is.
#[derive(Clone, Debug, PartialEq)]
pub struct Rating {
    /// The site.
    pub candidate: Candidate,
    /// Each figure in the weather that is worst for it.
    pub worst: Figures,
    /// What is nearest to the place of the worst Pd, and the weather there.
    pub worst_at: (String, String),
    /// Every weather.
    pub by_weather: Vec<(String, Figures)>,
}

/// The cells that count, with their weights.
#[derive(Clone, Debug)]
pub struct Area {
    /// The grid with the movement area alone: runways, taxiways, aprons, stands.
    pub grid: Grid,
    cells: Vec<(usize, f64)>,
}

impl Area {
    /// The movement area of a scene on a grid.
    ///
    /// # Errors
    /// If no cell's middle is paved.
    pub fn of(scene: &Scene, grid: &Grid) -> Result<Self, String> {
        let reach = |i: usize| grid.place(i).coords.abs().max() + 2.0 * grid.step_m;
        let reach_m = reach(0).max(reach(grid.area.len().saturating_sub(1)));
        let pavement = Pavement::of(&scene.airport.layout, reach_m);
        let mut grid = grid.clone();
        for i in 0..grid.area.len() {
            grid.area[i] = grid.area[i] && pavement.factor(grid.place(i)) == 1.0;
        }
        let paved = (0..grid.area.len()).filter(|i| grid.area[*i]);
        let cells: Vec<_> = paved.map(|i| (i, weight(scene, grid.place(i)))).collect();
        if cells.is_empty() {
            return Err("no cell lies on pavement: a smaller --step is needed".into());
        }
        Ok(Self { grid, cells })
    }

    /// Cells of it.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.cells.len()
    }

    /// What the maps of one weather say.
    fn figures(&self, maps: &[Map], bound: f64) -> Figures {
        let values = |layer: &str| maps.iter().find(|m| m.layer == layer).map(|m| &*m.values);
        let [pd, sigma, shadow, ghosts] = ["pd", "sigma", "shadow", "ghosts"].map(values);
        let at = |map: Option<&[f32]>, i: usize| map.map(|m| m[i]).filter(|v| *v != NO_DATA);
        let (mut good, mut dark, mut weights, mut covered) = (0.0, 0.0, 0.0, 0.0);
        let (mut worst, mut sigmas, mut ghost_sum) = ((f64::INFINITY, 0), (0.0, 0.0), 0.0);
        for &(i, weight) in &self.cells {
            // Maps hold single precision; so does the bound that they are held against.
            let here = at(pd, i).unwrap_or(0.0);
            let enough = here >= bound as f32;
            let s = at(sigma, i);
            good += f64::from(u8::from(enough));
            weights += weight;
            if enough && s.is_some_and(|s| s <= COVERED_SIGMA_M) {
                covered += weight;
            }
            if f64::from(here) < worst.0 {
                worst = (f64::from(here), i);
            }
            if let Some(s) = s {
                sigmas = (sigmas.0 + f64::from(s), sigmas.1 + 1.0);
            }
            dark += f64::from(u8::from(at(shadow, i).is_some_and(|db| db > SHADOW_DB)));
            ghost_sum += f64::from(at(ghosts, i).unwrap_or(0.0));
        }
        let n = self.cells.len() as f64;
        Figures {
            share: good / n,
            covered: covered / weights,
            worst_pd: worst.0,
            worst_m: self.grid.place(worst.1),
            sigma_m: if sigmas.1 > 0.0 { sigmas.0 / sigmas.1 } else { f64::INFINITY },
            shadow_share: dark / n,
            ghosts: ghost_sum / n,
        }
    }
}

/// The sensor at another site.
#[must_use]
pub fn placed(sensor: &SensorScene, candidate: &Candidate) -> SensorScene {
    let mut moved = sensor.clone();
    if candidate.present {
        return moved;
    }
    moved.site_m = Some(candidate.site_m);
    if let Some(radar) = moved.asde.as_mut() {
        radar.parameters.antenna_height_m = candidate.site_m.z;
    }
    moved
}

/// One candidate: the radar there, in every weather. `bound` is the Pd that a place needs.
///
/// # Errors
/// As [`radar_maps`], or without any weather.
pub fn rate(
    scene: &Scene,
    sensor: &SensorScene,
    candidate: &Candidate,
    weathers: &[(String, Weather)],
    area: &Area,
    subject: &Subject,
    bound: f64,
) -> Result<Rating, String> {
    let moved = placed(sensor, candidate);
    let mut by_weather = Vec::new();
    for (word, weather) in weathers {
        let maps = radar_maps(scene, &moved, (word, weather), &area.grid, subject)?;
        by_weather.push((word.clone(), area.figures(&maps, bound)));
    }
    let (worst, weather) = worst_of(&by_weather).ok_or("no weather")?;
    let worst_at = (nearest(scene, worst.worst_m), weather);
    Ok(Rating { candidate: candidate.clone(), worst, worst_at, by_weather })
}

/// Each figure in the weather that is worst for it, and the weather of the worst Pd.
fn worst_of(by_weather: &[(String, Figures)]) -> Option<(Figures, String)> {
    let (mut weather, mut worst) = by_weather.first().cloned()?;
    for (word, here) in &by_weather[1..] {
        if here.worst_pd < worst.worst_pd {
            (worst.worst_pd, worst.worst_m) = (here.worst_pd, here.worst_m);
            weather.clone_from(word);
        }
        worst.share = worst.share.min(here.share);
        worst.covered = worst.covered.min(here.covered);
        worst.sigma_m = worst.sigma_m.max(here.sigma_m);
        worst.shadow_share = worst.shadow_share.max(here.shadow_share);
        worst.ghosts = worst.ghosts.max(here.ghosts);
    }
    Some((worst, weather))
}

/// Best first: by the first objective, among equals by the next, at last by name.
pub fn rank(ratings: &mut [Rating], by: &[Objective]) {
    ratings.sort_by(|a, b| {
        let differs = |o: &Objective| match o.cost(&a.worst).total_cmp(&o.cost(&b.worst)) {
            Ordering::Equal => None,
            order => Some(order),
        };
        let order = by.iter().find_map(differs).unwrap_or(Ordering::Equal);
        order.then_with(|| a.candidate.name.cmp(&b.candidate.name))
    });
}

/// The ranked table for people.
#[must_use]
pub fn text(ratings: &[Rating], bound: f64) -> String {
    let wide = ratings.iter().map(|r| r.candidate.name.chars().count()).max().unwrap_or(0).max(4);
    let mut text = format!(
        "rank  {:<wide$}  {:>8} {:>8} {:>6}  {:>8} {:>7} {:>8} {:>7} {:>7} {:>7}  worst Pd at\n",
        "name",
        "east_m",
        "north_m",
        "height",
        format!("Pd>={bound}"),
        "covered",
        "worst Pd",
        "sigma_m",
        "shadow",
        "ghosts",
    );
    for (rank, r) in (1..).zip(ratings) {
        let (at, f) = (r.candidate.site_m, &r.worst);
        let _ = writeln!(
            text,
            "{rank:>4}  {:<wide$}  {:>8.0} {:>8.0} {:>6.1}  {:>8.4} {:>7.4} {:>8.4} {:>7.2} {:>7.4} {:>7.4}  {} ({})",
            r.candidate.name,
            at.x,
            at.y,
            at.z,
            f.share,
            f.covered,
            f.worst_pd,
            f.sigma_m,
            f.shadow_share,
            f.ghosts,
            r.worst_at.0,
            r.worst_at.1
        );
    }
    if ratings.iter().all(|r| r.worst.covered == 0.0) && ratings.iter().any(|r| r.worst.share > 0.0)
    {
        let _ = writeln!(
            text,
            "covered is 0 everywhere: no place with that Pd has a sigma of {COVERED_SIGMA_M} m or less for this class; rank by pd and sigma"
        );
    }
    text
}

/// The ranked table as CSV.
#[must_use]
pub fn csv(ratings: &[Rating]) -> String {
    let mut text = String::from(
        "rank,name,present,east_m,north_m,height_m,share_pd,covered,worst_pd,worst_near,worst_east_m,\
         worst_north_m,worst_weather,sigma_m,shadow_share,ghosts\n",
    );
    let quoted = |word: &str| format!("\"{}\"", word.replace('"', "\"\""));
    for (rank, r) in (1..).zip(ratings) {
        let (at, f) = (r.candidate.site_m, &r.worst);
        let sigma = if f.sigma_m.is_finite() { f.sigma_m.to_string() } else { String::new() };
        let _ = writeln!(
            text,
            "{rank},{},{},{},{},{},{},{},{},{},{},{},{},{sigma},{},{}",
            quoted(&r.candidate.name),
            r.candidate.present,
            at.x,
            at.y,
            at.z,
            f.share,
            f.covered,
            f.worst_pd,
            quoted(&r.worst_at.0),
            f.worst_m.x,
            f.worst_m.y,
            quoted(&r.worst_at.1),
            f.shadow_share,
            f.ghosts
        );
    }
    text
}

/// The ranked rows as JSON, every weather of each besides.
#[must_use]
pub fn json(ratings: &[Rating]) -> Value {
    let figures = |f: &Figures| {
        json!({
            "share_pd": f.share, "covered": f.covered, "worst_pd": f.worst_pd,
            "worst_m": [f.worst_m.x, f.worst_m.y],
            "sigma_m": Some(f.sigma_m).filter(|s| s.is_finite()),
            "shadow_share": f.shadow_share, "ghosts": f.ghosts,
        })
    };
    let row = |(rank, r): (usize, &Rating)| {
        let at = r.candidate.site_m;
        let every = r.by_weather.iter().map(|(word, f)| {
            let mut of = figures(f);
            of["weather"] = json!(word);
            of
        });
        json!({
            "rank": rank, "name": r.candidate.name, "present": r.candidate.present,
            "east_m": at.x, "north_m": at.y, "height_m": at.z,
            "worst": figures(&r.worst), "worst_near": r.worst_at.0, "worst_weather": r.worst_at.1,
            "weathers": every.collect::<Vec<_>>(),
        })
    };
    (1..).zip(ratings).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::frames::Point3;

    fn map(layer: &'static str, values: [f32; 4]) -> Map {
        let (sensor, weather) = ("r".to_owned(), "w".to_owned());
        let values = values.to_vec();
        Map { number: 1, sensor, weather, layer, unit: "", more_is_worse: false, values }
    }

    /// Three cells in a row count, of weights 4, 1, 1; the fourth does not.
    fn area() -> Area {
        let (first_m, area) = (Point2::origin(), vec![true, true, true, false]);
        let grid = Grid { first_m, step_m: 10.0, size: (4, 1), area };
        Area { grid, cells: vec![(0, 4.0), (1, 1.0), (2, 1.0)] }
    }

    fn figures(pd: [f32; 4], sigma: [f32; 4]) -> Figures {
        let shadow = map("shadow", [0.0, 1.0, 1.1, 50.0]);
        let ghosts = map("ghosts", [0.0, 0.3, NO_DATA, 9.0]);
        area().figures(&[map("pd", pd), map("sigma", sigma), shadow, ghosts], 0.9)
    }

    fn rating(name: &str, worst: Figures) -> Rating {
        let site_m = Point3::new(1.0, 2.0, 20.0);
        let candidate = Candidate { name: name.into(), site_m, present: false };
        let by_weather = vec![("dry".to_owned(), worst.clone())];
        Rating { candidate, worst, worst_at: ("stand A".into(), "dry".into()), by_weather }
    }

    #[test]
    fn figures_are_those_of_the_cells_that_count() {
        // The bound itself is enough; where nothing is displayed Pd is 0; the fourth cell is no matter.
        let f = figures([0.9, 0.95, NO_DATA, 0.0], [3.5, 4.5, NO_DATA, 100.0]);
        assert!((f.share - 2.0 / 3.0).abs() < 1e-12);
        assert!((f.covered - 4.0 / 6.0).abs() < 1e-12, "sigma of the second is too large");
        assert_eq!((f.worst_pd, f.worst_m), (0.0, Point2::new(20.0, 0.0)));
        assert!((f.sigma_m - 4.0).abs() < 1e-12, "where there is one");
        assert!((f.shadow_share - 1.0 / 3.0).abs() < 1e-12, "above 1 dB");
        assert!((f.ghosts - 0.1).abs() < 1e-6);
        assert!(figures([0.0; 4], [NO_DATA; 4]).sigma_m.is_infinite());
    }

    #[test]
    fn the_worst_weather_counts_for_each_figure_by_itself() {
        let dry = figures([0.99, 0.95, 0.5, 1.0], [3.0; 4]);
        let rain = figures([0.4, 0.95, 0.99, 1.0], [2.0; 4]);
        let (worst, weather) =
            worst_of(&[("dry".into(), dry), ("rain".into(), rain)]).expect("two");
        assert_eq!((&*weather, worst.worst_m), ("rain", Point2::origin()));
        assert!((worst.worst_pd - 0.4).abs() < 1e-6);
        assert!((worst.sigma_m - 3.0).abs() < 1e-12);
        assert!((worst.covered - 2.0 / 6.0).abs() < 1e-12);
        assert!(worst_of(&[]).is_none());
    }

    #[test]
    fn ranks_go_by_the_objectives_in_turn_then_by_name() {
        let all = figures([0.95; 4], [3.0; 4]);
        let finer = figures([0.92, 0.95, 0.95, 0.0], [2.0; 4]);
        let blind = figures([0.95, 0.95, 0.1, 0.0], [1.0; 4]);
        let mut rows = vec![
            rating("blind", blind),
            rating("finer", finer),
            rating("b", all.clone()),
            rating("a", all),
        ];
        let names = |rows: &[Rating]| -> Vec<String> {
            rows.iter().map(|r| r.candidate.name.clone()).collect()
        };
        rank(&mut rows, &[Objective::Pd, Objective::Sigma]);
        assert_eq!(names(&rows), ["finer", "a", "b", "blind"]);
        rank(&mut rows, &[Objective::WorstPd]);
        assert_eq!(names(&rows), ["a", "b", "finer", "blind"]);
        rank(&mut rows, &[Objective::Sigma]);
        assert_eq!(names(&rows), ["blind", "finer", "a", "b"]);
        let table = text(&rows, 0.9);
        assert_eq!(table.lines().count(), 5);
        assert!(table.lines().nth(1).is_some_and(|l| l.starts_with("   1  blind")), "{table}");
        // Where no place is fine enough the table says so.
        let coarse = [rating("coarse", figures([0.95; 4], [3.64; 4]))];
        assert!(text(&coarse, 0.9).contains("covered is 0 everywhere"));
        assert!(!table.contains("everywhere"));
        let columns = csv(&rows).lines().map(|l| l.split(',').count()).collect::<Vec<_>>();
        assert_eq!(columns, [16; 5]);
        assert_eq!(json(&rows)[0]["name"], "blind");
        assert_eq!(json(&rows)[0]["weathers"][0]["weather"], "dry");
        for (word, objective) in Objective::WORDS {
            assert_eq!(Objective::named(word), Some(objective));
        }
    }
}
