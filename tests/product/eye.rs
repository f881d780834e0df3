//! The light of the eye's view, measured in its picture against contrasts that physics gives.
//!
//! Plates of known luminance stand before the horizon at seven distances; their contrast to the sky beside them is
//! read from the picture. Four wrong renderers are made of the right one and must fail.

use crate::page::browser::Browser;
use federates::runtime::messages::{ScanReport, WeatherNotice};
use federates::viewer_logger::Viewer;
use federates::viewer_logger::picture::{AirportMap, BoardPlate, RunInfo};
use federates::viewer_logger::server::{Page, serve};
use serde_json::{Value, json};
use std::path::Path;

fn data(name: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/views").join(name);
    std::fs::read_to_string(file).expect("reference data")
}

/// The plates of the reference file.
fn boards() -> Vec<BoardPlate> {
    let number = |line: &str, key: &str| -> f64 {
        let after = line.split_once(&format!("{key} = ")).expect(key).1;
        let end = after.find([',', ' ', '}']).unwrap_or(after.len());
        after[..end].trim().parse().expect("a number")
    };
    data("boards.toml")
        .split("[[board]]")
        .skip(1)
        .map(|text| {
            let line = |key: &str| text.lines().find(|l| l.starts_with(key)).expect("a key");
            let place = line("place");
            BoardPlate {
                name: line("name").split('"').nth(1).expect("a name").to_owned(),
                centre_m: [
                    number(place, "x_m"),
                    number(place, "y_m"),
                    number(line("centre_height_m"), "centre_height_m"),
                ],
                size_m: number(line("size_m"), "size_m"),
                luminance_ratio: number(line("luminance_ratio"), "luminance_ratio"),
            }
        })
        .collect()
}

fn weather(visibility_m: f64, rain_mm_per_h: f64) -> WeatherNotice {
    WeatherNotice {
        from_ns: 0,
        rain_mm_per_h,
        visibility_m,
        temperature_k: 288.15,
        pressure_hpa: 1013.25,
        vapour_g_per_m3: 7.5,
        wind_mps: [0.0, 0.0],
        film_mm: 0.0,
        cells: Vec::new(),
    }
}

/// Contrast of every plate in the picture as it stands, by name.
const MEASURE: &str = "(() => { \
  const eye = document.getElementById('eye'), c = new OffscreenCanvas(eye.width, eye.height), g = c.getContext('2d', { willReadFrequently: true }); \
  g.drawImage(eye, 0, 0); \
  const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); \
  const mean = (x0, y0, x1, y1) => { x0 = Math.ceil(x0); y0 = Math.ceil(y0); const w = Math.floor(x1) - x0, h = Math.floor(y1) - y0; \
    const d = g.getImageData(x0, y0, w, h).data; let s = 0; for (let k = 1; k < d.length; k += 4) s += d[k]; return linear(s / (w * h) / 255); }; \
  const beside = Math.tan(1.5 * Math.PI / 180) / Math.tan(15 * Math.PI / 180) * 360; \
  return Object.fromEntries(__eye.marks.map(({ name, px, py, half_px }) => { const h = half_px - 4, s = half_px / 2; \
    const o = mean(px - h, py - h, px + h, py + h), b = (mean(px - beside - s, py - s, px - beside + s, py + s) + mean(px + beside - s, py - s, px + beside + s, py + s)) / 2; \
    return [name, (o - b) / b]; })); })()";

/// Cases beyond the tolerance and the worst relative error of one weather.
fn judge(browser: &mut Browser, cases: &[&Value]) -> (usize, f64) {
    let measured = browser.eval(MEASURE);
    let (mut beyond, mut worst) = (0, 0.0_f64);
    for case in cases {
        let expected = case["contrast"].as_f64().expect("a contrast");
        let name = format!(
            "d{}r{}",
            case["distance_m"],
            case["ratio"].as_f64().map(|r| format!("{r}")).expect("a ratio")
        );
        let found = measured[&name].as_f64().unwrap_or_else(|| panic!("{name}: {measured}"));
        let error = (found - expected).abs();
        if expected.abs() >= 0.05 {
            worst = worst.max(error / expected.abs());
            beyond += usize::from(error > 0.05 * expected.abs());
        } else {
            beyond += usize::from(error > 0.003);
        }
    }
    (beyond, worst)
}

#[test]
fn contrasts_in_the_picture_are_those_of_physics_and_wrong_renderers_are_found() {
    let reference: Value = serde_json::from_str(&data("contrast.json")).expect("JSON");
    let all = reference["horizon"].as_array().expect("cases");
    let mut weathers: Vec<(f64, f64)> = Vec::new();
    for case in all {
        let of = |name: &str| case[name].as_f64().expect("a figure");
        let weather = (of("visibility_m"), of("rain_mm_per_h"));
        if !weathers.contains(&weather) {
            weathers.push(weather);
        }
    }
    assert_eq!((all.len(), weathers.len()), (231, 11), "a cut file tests nothing");
    let page = Page::new(Viewer::new(1 << 20));
    let map = AirportMap { boards: boards(), ..AirportMap::default() };
    // Noon of a summer's day at the equator.
    let info = RunInfo { start_utc_ns: 1_750_507_200_000_000_000, ..RunInfo::default() };
    page.update(|viewer| {
        viewer.on_scene(&info, &map);
        viewer.on_weather(&weather(400.0, 0.0));
        viewer.on_scan(&ScanReport {
            run: 1,
            scan: 1,
            time_ns: 1_000_000_000,
            ..ScanReport::default()
        });
    });
    let here = "127.0.0.1:0".parse().expect("an address");
    let server =
        serve(here, page.clone(), Box::new(|_, _| (false, String::new()))).expect("served");
    let url = format!("http://{}/eye#eye=free&at=0,0,50&look=0,0&fov=30", server.address());
    let Some(mut browser) = Browser::open(&url, [1280, 720]) else {
        skipped();
        return;
    };
    browser.until("window.__eye && __eye.frames > 1 && __eye.marks.length === 21");
    let show = |browser: &mut Browser, (visibility_m, rain): (f64, f64)| -> Vec<&Value> {
        let frames = browser.eval("__eye.frames");
        page.update(|viewer| viewer.on_weather(&weather(visibility_m, rain)));
        browser.until(&format!("__eye.visibility_m === {visibility_m} && __eye.frames > {frames}"));
        browser.eval("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))");
        let of = |c: &&Value| {
            c["visibility_m"] == json!(visibility_m as i64)
                && c["rain_mm_per_h"] == json!(rain as i64)
        };
        all.iter().filter(of).collect()
    };
    let (mut seen, mut worst) = (0, 0.0_f64);
    for weather in &weathers {
        let cases = show(&mut browser, *weather);
        let (beyond, of_these) = judge(&mut browser, &cases);
        assert_eq!(beyond, 0, "visibility {} m, rain {} mm/h", weather.0, weather.1);
        seen += cases.len();
        worst = worst.max(of_these);
    }
    assert_eq!(seen, 231);
    assert!(worst < 0.01, "worst {worst}");
    for (name, from, to) in [
        ("depth for distance", "distance(at, uEye)", "(1.0 / gl_FragCoord.w)"),
        (
            "squared",
            "exp(-extinctionTo(at) * distance(at, uEye))",
            "exp(-pow(extinctionTo(at) * distance(at, uEye), 2.0))",
        ),
        (
            "3.912 over V",
            "exp(-extinctionTo(at) * distance(at, uEye))",
            "exp(-1.3059 * extinctionTo(at) * distance(at, uEye))",
        ),
        ("no dither", "n / 255.0", "0.0"),
    ] {
        // The same page with one line of its shader changed: the context is lost and comes back.
        browser.eval(&format!(
            "(async () => {{ const gl = document.getElementById('eye').getContext('webgl2'), of = WebGL2RenderingContext.prototype; \
             of.original ??= of.shaderSource; of.shaderSource = function (s, text) {{ return of.original.call(this, s, text.replaceAll({}, {})); }}; \
             const lose = gl.getExtension('WEBGL_lose_context'); lose.loseContext(); await new Promise((r) => setTimeout(r, 100)); lose.restoreContext(); \
             await new Promise((r) => setTimeout(r, 100)); }})()",
            json!(from), json!(to)
        ));
        let beyond: usize = [(400.0, 0.0), (1000.0, 0.0), (2000.0, 0.0), (150.0, 0.0)]
            .into_iter()
            .map(|weather| {
                let cases = show(&mut browser, weather);
                judge(&mut browser, &cases).0
            })
            .sum();
        assert!(beyond > 0, "{name} is not found");
    }
    server.stop();
}

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn skipped() {
    eprintln!("skipped: chromium is not installed (./test installs it)");
}
