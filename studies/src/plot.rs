//! Line charts as SVG and pages that need nothing else.

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
    /// Drawn dashed (levels, thresholds).
    pub dashed: bool,
}

/// A chart with linear axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Title above it.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub x_name: String,
    /// Name and unit of the vertical axis.
    pub y_name: String,
    /// Its curves.
    pub lines: Vec<Line>,
}

const WIDTH: f64 = 760.0;
/// Width of a letter of 12 px sans-serif, generously.
const LETTER: f64 = 7.5;
const HEIGHT: f64 = 420.0;
/// Height of a line of the legend.
const LEGEND_STEP: f64 = 18.0;
const LEFT: f64 = 60.0;
const TOP: f64 = 36.0;
const PLOT_WIDTH: f64 = 660.0;
const PLOT_HEIGHT: f64 = 330.0;
const COLOURS: [&str; 8] =
    ["#0b62a4", "#c23b22", "#2e7d32", "#8e24aa", "#ef6c00", "#00838f", "#5d4037", "#455a64"];

impl Chart {
    /// The chart as one `<svg>` element. Points that are no numbers are left out.
    #[must_use]
    pub fn svg(&self) -> String {
        let sound = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let all = || self.lines.iter().flat_map(|l| l.points.iter()).filter(sound);
        let span = |f: fn(&(f64, f64)) -> f64| {
            let low = all().map(f).fold(f64::INFINITY, f64::min);
            let high = all().map(f).fold(f64::NEG_INFINITY, f64::max);
            if low < high { (low, high) } else { (low.min(0.0), low.max(0.0) + 1.0) }
        };
        let (x_ticks, y_ticks) = (ticks(span(|p| p.0)), ticks(span(|p| p.1)));
        let (x0, x1) = (x_ticks[0], x_ticks[x_ticks.len() - 1]);
        let (y0, y1) = (y_ticks[0], y_ticks[y_ticks.len() - 1]);
        let px = |x: f64| LEFT + (x - x0) / (x1 - x0) * PLOT_WIDTH;
        let py = |y: f64| TOP + PLOT_HEIGHT - (y - y0) / (y1 - y0) * PLOT_HEIGHT;
        // The legend stands below the plot, a line for each curve, as wide as the longest name.
        let longest = self.lines.iter().map(|l| l.name.chars().count()).max().unwrap_or(0);
        let width = (LEFT + 46.0 + LETTER * longest as f64).max(WIDTH);
        let height = HEIGHT + LEGEND_STEP * self.lines.len() as f64;
        let mut out = format!(
            "<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\">\n\
             <title>{t}</title>\n<text x=\"{LEFT}\" y=\"20\" font-weight=\"bold\">{t}</text>\n",
            t = escape(&self.title)
        );
        for &x in &x_ticks {
            let p = px(x);
            let (bottom, below) = (TOP + PLOT_HEIGHT, TOP + PLOT_HEIGHT + 16.0);
            out.push_str(&format!(
                "<path d=\"M{p:.1} {TOP}V{bottom}\" class=\"grid\"/>\
                 <text x=\"{p:.1}\" y=\"{below}\" text-anchor=\"middle\">{x}</text>\n"
            ));
        }
        for &y in &y_ticks {
            let p = py(y);
            let (right, label) = (LEFT + PLOT_WIDTH, LEFT - 6.0);
            out.push_str(&format!(
                "<path d=\"M{LEFT} {p:.1}H{right}\" class=\"grid\"/>\
                 <text x=\"{label}\" y=\"{:.1}\" text-anchor=\"end\">{y}</text>\n",
                p + 4.0
            ));
        }
        for (i, line) in self.lines.iter().enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            let dash = if line.dashed { " stroke-dasharray=\"6 4\"" } else { "" };
            let points: Vec<String> = line
                .points
                .iter()
                .filter(sound)
                .map(|p| format!("{:.1},{:.1}", px(p.0), py(p.1)))
                .collect();
            let (x, y) = (LEFT, HEIGHT + LEGEND_STEP * i as f64);
            out.push_str(&format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>\n\
                 <path d=\"M{x} {y}h22\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>\
                 <text x=\"{}\" y=\"{}\">{}</text>\n",
                points.join(" "),
                x + 28.0,
                y + 4.0,
                escape(&line.name)
            ));
        }
        let (middle, bottom) = (LEFT + 0.5 * PLOT_WIDTH, HEIGHT - 14.0);
        out.push_str(&format!(
            "<text x=\"{middle}\" y=\"{bottom}\" text-anchor=\"middle\">{}</text>\n\
             <text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n</svg>\n",
            escape(&self.x_name),
            TOP + 0.5 * PLOT_HEIGHT,
            escape(&self.y_name)
        ));
        out
    }
}

/// Round numbers that cover an interval: steps of 1, 2 or 5 times a power of ten.
fn ticks((low, high): (f64, f64)) -> Vec<f64> {
    let raw = (high - low) / 6.0;
    let power = libm::pow(10.0, libm::floor(libm::log10(raw)));
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().find(|s| s * power >= raw).unwrap_or(10.0) * power;
    let (first, last) = ((low / step).floor() as i64, (high / step).ceil() as i64);
    // Rounded, so that labels do not show the binary of a decimal step.
    (first..=last).map(|i| ((i as f64 * step) * 1e9).round() / 1e9).collect()
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A page with its own style and nothing to load.
#[must_use]
pub fn page(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{}</title>\n<style>\n\
         body {{ font: 14px/1.4 sans-serif; margin: 2em; max-width: 70em }}\n\
         svg {{ font: 12px sans-serif; display: block; margin: 1em 0 }}\n\
         .grid {{ stroke: #ddd; fill: none }}\n\
         table {{ border-collapse: collapse }} td, th {{ border: 1px solid #ccc; padding: .2em .6em }}\n\
         td.n {{ text-align: right }}\n</style></head><body>\n{body}</body></html>\n",
        escape(title)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_cover() {
        assert_eq!(ticks((1500.0, 5500.0)), [1000.0, 2000.0, 3000.0, 4000.0, 5000.0, 6000.0]);
        let t = ticks((0.03, 0.11));
        assert!(t[0] <= 0.03 && t[t.len() - 1] >= 0.11 && t.len() < 10, "{t:?}");
    }

    #[test]
    fn every_name_of_the_legend_is_inside_the_picture() {
        let line = |name: &str| Line { name: name.into(), points: vec![(0.0, 1.0)], dashed: false };
        let long = "a name that is as long as a sentence about what was simulated and what was left out, \
                    and a little longer than that";
        let (title, x_name, y_name) = ("t".into(), "x".into(), "y".into());
        let lines = (0..12).map(|_| line(long)).collect();
        let svg = Chart { title, x_name, y_name, lines }.svg();
        let of = |text: &str, key: &str| -> f64 {
            let from = text.find(&format!(" {key}=\"")).expect(key) + key.len() + 3;
            let rest = &text[from..];
            rest[..rest.find('"').expect("a quote")].parse().expect("a number")
        };
        let (width, height) = (of(&svg, "width"), of(&svg, "height"));
        for entry in svg.split("<text").filter(|t| t.contains(long)) {
            assert!(of(entry, "x") + LETTER * long.len() as f64 <= width, "{entry}");
            assert!(of(entry, "y") < height && of(entry, "y") > HEIGHT - 20.0, "{entry}");
        }
    }

    #[test]
    fn a_chart_of_nothing_or_one_point_is_still_a_chart() {
        for points in [vec![], vec![(1.0, 2.0)], vec![(f64::NAN, 1.0)]] {
            let line = Line { name: "a<b".into(), points, dashed: true };
            let chart = Chart {
                title: "t".into(),
                x_name: "x".into(),
                y_name: "y".into(),
                lines: vec![line],
            };
            let svg = chart.svg();
            assert!(svg.starts_with("<svg") && svg.contains("a&lt;b"), "{svg}");
        }
    }
}
