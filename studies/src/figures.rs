//! The paper's Figs. 3 to 5: signal to clutter and noise ratio against range, drawn and checked.
//!
//! The original curves are not available; what the text says of them is tested as statements.

use crate::plot::{Chart, Line};
use crate::{Ladder, Options, Outcome, Progress, Row};
use models::draw::{DrawKey, Purpose, uniform};
use models::environment::Weather;
use models::environment::surface::Material;
use models::frames::Point2;
use models::sensors::asde::AsdeParameters;
use models::sensors::radar::detection::{albersheim_db, to_db};
use models::sensors::radar::equation::{BudgetLevels, Echo, Reflection};
use scenarios::ScenarioError;
use scenarios::sensors::asde::shipped;

/// Height of the scatterer in the figures, m.
const HEIGHT_M: f64 = 1.5;

/// One statement of the text with what was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// What the text says.
    pub says: &'static str,
    /// Whether it holds.
    pub holds: bool,
    /// The numbers.
    pub found: String,
}

/// The figures and the statements about them.
#[derive(Clone, Debug)]
pub struct Figures {
    /// Figs. 3, 4 and 5.
    pub charts: Vec<Chart>,
    /// The statements.
    pub statements: Vec<Statement>,
}

impl Figures {
    /// One self-contained page.
    #[must_use]
    pub fn html(&self) -> String {
        let mut body = String::from("<h1>Signal to clutter and noise ratio against range</h1>\n");
        for chart in &self.charts {
            body.push_str(&chart.svg());
        }
        body.push_str("<h2>Statements</h2>\n<ol>\n");
        for s in &self.statements {
            let mark = if s.holds { "holds" } else { "does not hold" };
            body.push_str(&format!("<li><b>{mark}</b>: {} <i>({})</i></li>\n", s.says, s.found));
        }
        body.push_str("</ol>\n");
        crate::plot::page("Figures 3 to 5", &body)
    }

    /// One row per statement: error 0 where it holds.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        let row = |s: &Statement| Row {
            group: "figures".into(),
            scene: s.says.into(),
            rung: s.found.clone(),
            failed: if s.holds { Vec::new() } else { vec![s.found.clone()] },
            ..Row::default()
        };
        self.statements.iter().map(row).collect()
    }
}

/// One radar in one weather over one surface.
#[derive(Clone, Debug)]
struct Setting {
    parameters: AsdeParameters,
    weather: Weather,
    reflection: Reflection,
    rcs_m2: f64,
}

impl Setting {
    /// Ratio in dB at each ground range.
    fn curve(&self, ranges: &[f64]) -> Vec<f64> {
        let radar = self.parameters.radar();
        let air = radar.air(&self.weather);
        let levels = BudgetLevels { reflection: self.reflection, ..BudgetLevels::MIDDLE };
        let at = |&ground_m: &f64| {
            let echo =
                Echo { ground_m, height_m: HEIGHT_M, extent_m: HEIGHT_M, rcs_m2: self.rcs_m2 };
            let to = Point2::new(0.0, ground_m);
            to_db(radar.budget(&air, &levels, &echo, Point2::origin(), to).scnr())
        };
        ranges.iter().map(at).collect()
    }
}

fn weather(rain_mm_per_h: f64, visibility_m: f64) -> Weather {
    Weather { rain_mm_per_h, visibility_m, ..Weather::default() }
}

/// The group `figures`: the charts, and one row per statement.
pub(crate) fn study(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let (rows, pictures) = match run(options.seed) {
        Ok(figures) => (figures.rows(), figures.charts.iter().map(Chart::svg).collect()),
        Err(error) => {
            let failed = vec![error.to_string()];
            (vec![Row { group: "figures".into(), failed, ..Row::default() }], Vec::new())
        }
    };
    progress(Progress { group: "figures", what: "Figs. 3 to 5".into(), done: 1, total: 1 });
    let ladder = Ladder {
        group: "figures".into(),
        title: "Figures 3 to 5 of the paper".into(),
        about: "Single-pulse signal to clutter and noise ratio against range, at the parameters that the \
                paper gives, and what its text says of the figures, tested: a row without a failure holds."
            .into(),
        ..Ladder::default()
    };
    Outcome { ladder, rows, pictures, ..Outcome::default() }
}

/// Computes the figures and tests the statements; `seed` moves the parameters of the last one.
///
/// # Errors
/// If a parameter set that ships is missing.
pub fn run(seed: u64) -> Result<Figures, ScenarioError> {
    let (ku, x) = (shipped("ku_asde3")?, shipped("x_paper")?);
    let ranges: Vec<f64> = (0..=80).map(|i| 1500.0 + 50.0 * f64::from(i)).collect();
    let grass = |p: &AsdeParameters| AsdeParameters {
        surface: Material::named("medium_dry_ground").unwrap_or(p.surface),
        roughness_m: 0.05,
        ..p.clone()
    };
    let setting = |p: &AsdeParameters, weather: Weather, reflection, rcs_m2| Setting {
        parameters: p.clone(),
        weather,
        reflection,
        rcs_m2,
    };
    let (none, mean) = (Reflection::None, Reflection::Incoherent);
    let storm = weather(16.0, f64::INFINITY);
    let bad = weather(10.0, 100.0);
    let clear = Weather::default();
    let fig3 = [
        setting(&ku, storm.clone(), none, 1.6),
        setting(&grass(&ku), storm.clone(), mean, 1.6),
        setting(&ku, storm, mean, 1.6),
    ]
    .map(|s| s.curve(&ranges));
    let fig4 = [
        setting(&ku, bad.clone(), none, 1.6),
        setting(&ku, clear.clone(), none, 1.6),
        setting(&x, bad.clone(), none, 1.6),
        setting(&x, clear, none, 1.6),
    ]
    .map(|s| s.curve(&ranges));
    let fig5 = [setting(&ku, bad.clone(), none, 3.0), setting(&x, bad.clone(), none, 3.0)]
        .map(|s| s.curve(&ranges));
    let required = |p: &AsdeParameters| albersheim_db(p.pd, p.pfa, p.pulses()).unwrap_or(f64::NAN);
    let (ku_db, x_db) = (required(&ku), required(&x));
    let charts = vec![
        chart(
            "Fig. 3: 16 GHz, 16 mm/h, 1.6 m²",
            &ranges,
            &[
                ("no surface reflection", &fig3[0]),
                ("grass, 5 cm rms, incoherent", &fig3[1]),
                ("asphalt, 3 mm rms, incoherent", &fig3[2]),
            ],
            &[("required, 16 GHz", ku_db)],
        ),
        chart(
            "Fig. 4: visibility 100 m, 10 mm/h, 1.6 m²",
            &ranges,
            &[
                ("16 GHz, bad weather", &fig4[0]),
                ("16 GHz, clear", &fig4[1]),
                ("9 GHz, bad weather", &fig4[2]),
                ("9 GHz, clear", &fig4[3]),
            ],
            &[("required, 16 GHz", ku_db), ("required, 9 GHz", x_db)],
        ),
        chart(
            "Fig. 5: visibility 100 m, 10 mm/h, 3 m²",
            &ranges,
            &[("16 GHz", &fig5[0]), ("9 GHz", &fig5[1])],
            &[("required, 16 GHz", ku_db), ("required, 9 GHz", x_db)],
        ),
    ];
    let statements = vec![
        reflection_spans_five_db(&ranges, &fig3),
        ku_above_x(&fig4, &fig5, ku_db, x_db),
        weather_costs_x_more(&ranges, &fig4),
        ratio_of_cross_sections(&fig4, &fig5),
        moved_parameters(seed, &ku, &x, &bad),
    ];
    Ok(Figures { charts, statements })
}

fn chart(
    title: &str,
    ranges: &[f64],
    curves: &[(&str, &Vec<f64>)],
    levels: &[(&str, f64)],
) -> Chart {
    let mut lines: Vec<Line> = curves
        .iter()
        .map(|(name, values)| Line {
            name: (*name).to_owned(),
            points: ranges.iter().zip(values.iter()).map(|(&r, &v)| (r, v)).collect(),
            dashed: false,
        })
        .collect();
    let ends = [ranges[0], ranges[ranges.len() - 1]];
    for (name, level) in levels {
        let points = ends.iter().map(|&r| (r, *level)).collect();
        lines.push(Line { name: format!("{name}: {level:.2} dB"), points, dashed: true });
    }
    let (x, y) = ("ground range, m", "signal to clutter and noise, dB");
    Chart { title: title.into(), x_name: x.into(), y_name: y.into(), lines }
}

fn reflection_spans_five_db(ranges: &[f64], fig3: &[Vec<f64>; 3]) -> Statement {
    let near = ranges.iter().take_while(|&&r| r <= 2600.0).count();
    let most = |curve: &Vec<f64>| {
        let pairs = curve.iter().zip(&fig3[0]).take(near);
        pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
    };
    let (grass, asphalt) = (most(&fig3[1]), most(&fig3[2]));
    Statement {
        says: "Fig. 3: from 1500 to 2600 m the surface reflection (grass) changes less than 5 dB",
        holds: grass < 5.0,
        found: format!("grass {grass:.2} dB, asphalt {asphalt:.2} dB"),
    }
}

fn ku_above_x(fig4: &[Vec<f64>; 4], fig5: &[Vec<f64>; 2], ku_db: f64, x_db: f64) -> Statement {
    let least = |a: &Vec<f64>, b: &Vec<f64>| {
        a.iter().zip(b).fold(f64::INFINITY, |m: f64, (a, b)| m.min(a - b))
    };
    let least = least(&fig4[0], &fig4[2]).min(least(&fig5[0], &fig5[1]));
    Statement {
        says: "Figs. 4 and 5: 16 GHz is above 9 GHz at every range, its required ratio too",
        holds: least > 0.0 && ku_db > x_db,
        found: format!("at least {least:.2} dB apart; required {ku_db:.2} and {x_db:.2} dB"),
    }
}

fn weather_costs_x_more(ranges: &[f64], fig4: &[Vec<f64>; 4]) -> Statement {
    let near = ranges.iter().take_while(|&&r| r <= 3500.0).count();
    let mean = |bad: &Vec<f64>, clear: &Vec<f64>| {
        clear.iter().zip(bad).take(near).map(|(c, b)| c - b).sum::<f64>() / near as f64
    };
    let (ku, x) = (mean(&fig4[0], &fig4[1]), mean(&fig4[2], &fig4[3]));
    Statement {
        says: "Fig. 4: weather costs 9 GHz with its wide beam more than 16 GHz, 1500 to 3500 m",
        holds: x > ku,
        found: format!("9 GHz {x:.1} dB, 16 GHz {ku:.1} dB on average"),
    }
}

fn ratio_of_cross_sections(fig4: &[Vec<f64>; 4], fig5: &[Vec<f64>; 2]) -> Statement {
    let expected = 10.0 * libm::log10(3.0 / 1.6);
    let most = [(0, 0), (2, 1)].into_iter().fold(0.0, |m: f64, (a, b)| {
        let pairs = fig4[a].iter().zip(&fig5[b]);
        pairs.fold(m, |m, (a, b)| m.max((b - a - expected).abs()))
    });
    Statement {
        says: "Figs. 4 to 5: 3 m² instead of 1.6 m² is 2.73 dB everywhere",
        holds: most < 1e-9,
        found: format!("within {most:.1e} dB"),
    }
}

/// Tilt, gain, power, height and ground moved at random: how often the second and third statement hold.
fn moved_parameters(
    seed: u64,
    ku: &AsdeParameters,
    x: &AsdeParameters,
    bad: &Weather,
) -> Statement {
    let ranges: Vec<f64> = (0..=16).map(|i| 1500.0 + 250.0 * f64::from(i)).collect();
    let draws = 200;
    let (mut above, mut above_far, mut costlier) = (0, 0, 0);
    for n in 0..draws {
        let key = DrawKey { run_seed: seed, sensor: 0, entity: n, scan: 0 };
        let rng = &mut key.rng(Purpose::Study);
        let mut between = |low: f64, high: f64| low + (high - low) * uniform(rng);
        let height = between(40.0, 80.0);
        let ground = between(-36.0, -26.0);
        let mut moved = |p: &AsdeParameters| AsdeParameters {
            tilt_deg: p.tilt_deg * between(0.7, 1.3),
            gain_dbi: p.gain_dbi + between(-2.0, 2.0),
            peak_power_w: p.peak_power_w * libm::pow(10.0, between(-0.3, 0.3)),
            antenna_height_m: height,
            ground_gamma_db: ground,
            ..p.clone()
        };
        let (ku, x) = (moved(ku), moved(x));
        let curve = |p: &AsdeParameters, weather: &Weather| {
            let (weather, reflection) = (weather.clone(), Reflection::None);
            Setting { parameters: p.clone(), weather, reflection, rcs_m2: 1.6 }.curve(&ranges)
        };
        let (a, b) = (curve(&ku, bad), curve(&x, bad));
        let over = |from: usize| a.iter().zip(&b).skip(from).all(|(a, b)| a > b);
        above += u64::from(over(0));
        above_far += u64::from(over(2));
        let clear = Weather::default();
        let near = 9;
        let cost = |bad: &[f64], clear: &[f64]| -> f64 {
            clear.iter().zip(bad).take(near).map(|(c, b)| c - b).sum()
        };
        costlier += u64::from(cost(&b, &curve(&x, &clear)) > cost(&a, &curve(&ku, &clear)));
    }
    let share = |n: u64| 100.0 * n as f64 / draws as f64;
    Statement {
        says: "With tilt, gain, power, height and ground moved at random they hold mostly",
        holds: share(above) > 75.0 && share(above_far) > 90.0 && share(costlier) > 80.0,
        found: format!(
            "16 GHz above in {:.0} % ({:.0} % beyond 2 km), weather costlier at 9 GHz in {:.0} %",
            share(above),
            share(above_far),
            share(costlier)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curves_go_through_the_reference_points() {
        let figures = run(1).expect("sets ship");
        // dB at 1500, 2600 and 5500 m.
        let expected: [&[[f64; 3]]; 3] = [
            &[[19.96, 23.75, 9.41], [22.11, 28.51, 16.36], [26.33, 30.74, 17.01]],
            &[
                [23.08, 26.19, 13.65],
                [30.66, 30.29, 21.00],
                [19.02, 14.53, 6.12],
                [28.27, 23.07, 10.92],
            ],
            &[[25.81, 28.92, 16.38], [21.75, 17.26, 8.85]],
        ];
        for (chart, curves) in figures.charts.iter().zip(expected) {
            for (line, points) in chart.lines.iter().zip(curves) {
                for (range, value) in [1500.0, 2600.0, 5500.0].into_iter().zip(points) {
                    let found = line.points.iter().find(|p| p.0 == range).expect("a point").1;
                    assert!(
                        (found - value).abs() < 0.006,
                        "{} {}: {found} {value}",
                        chart.title,
                        line.name
                    );
                }
            }
        }
    }

    #[test]
    fn every_statement_holds() {
        let figures = run(1).expect("sets ship");
        assert_eq!(figures.statements.len(), 5);
        for statement in &figures.statements {
            println!("{}: {}", statement.says, statement.found);
            assert!(statement.holds, "{statement:?}");
        }
        let html = figures.html();
        assert_eq!(html.matches("<svg").count(), 3);
        assert!(!html.contains("NaN") && !html.contains("http"));
    }
}
