//! One turn of a scene's radar at the video level, as an operator's picture.

use crate::zurich::Traffic;
use models::airport::{Airport, distance_to_segment_m};
use models::environment::Weather;
use models::frames::{Point2, Vector2};
use models::sensors::ScanInterval;
use models::sensors::asde::Asde;
use models::sensors::asde::picture::{Ground, VideoScene};
use models::sensors::radar::levels::RadarLevels;
use models::sensors::radar::video::ppi::{Picture, Ppi};
use models::sensors::radar::video::{CellRadar, MOST_CELLS};
use models::time::SimTime;
use scenarios::Scene;
use std::sync::Arc;

/// By how much grass returns more than pavement, for which a radar's γ stands: −32 dB of asphalt
/// against −20 dB of mown grass are usual.
const GRASS_FACTOR: f64 = 15.8;

/// Side of the squares in which pavement is kept, m.
const SQUARE_M: f64 = 4.0;

/// Where an airport is paved, in squares.
#[derive(Clone, Debug)]
pub struct Pavement {
    reach_m: f64,
    side: usize,
    paved: Vec<bool>,
}

impl Pavement {
    /// The pavement within `reach_m` of the reference point: runways, taxiways, aprons, stands.
    #[must_use]
    pub fn of(airport: &Airport, reach_m: f64) -> Self {
        let side = (2.0 * reach_m / SQUARE_M).ceil() as usize;
        let mut map = Self { reach_m, side, paved: vec![false; side * side] };
        for runway in &airport.runways {
            map.strip(runway.ends_m[0], runway.ends_m[1], 0.5 * runway.width_m);
        }
        for edge in &airport.edges {
            let ends = [edge.from, edge.to].map(|i| airport.nodes[i].position_m);
            map.strip(ends[0], ends[1], 0.5 * edge.width_m);
        }
        for stand in &airport.stands {
            map.strip(stand.position_m, stand.position_m, 30.0);
        }
        for polygon in &airport.pavement {
            let corners = || polygon.iter();
            let all = |m: f64| Point2::new(m, m);
            let low = corners().fold(all(f64::INFINITY), |m, p| m.inf(p));
            let high = corners().fold(all(f64::NEG_INFINITY), |m, p| m.sup(p));
            map.mark(low, high, |place| inside(polygon, place));
        }
        map
    }

    fn strip(&mut self, a: Point2<f64>, b: Point2<f64>, half_m: f64) {
        let margin = Vector2::repeat(half_m);
        let near = |place| distance_to_segment_m(place, a, b) <= half_m;
        self.mark(a.inf(&b) - margin, a.sup(&b) + margin, near);
    }

    fn mark(&mut self, low: Point2<f64>, high: Point2<f64>, paved: impl Fn(Point2<f64>) -> bool) {
        let step = |m: f64| ((m + self.reach_m) / SQUARE_M).floor().max(0.0) as usize;
        let last = |m: f64| step(m).min(self.side.saturating_sub(1));
        let (columns, rows) = ((step(low.x), last(high.x)), (step(low.y), last(high.y)));
        for row in rows.0..=rows.1 {
            for column in columns.0..=columns.1 {
                let middle = |i: usize| (i as f64 + 0.5) * SQUARE_M - self.reach_m;
                if paved(Point2::new(middle(column), middle(row))) {
                    self.paved[row * self.side + column] = true;
                }
            }
        }
    }
}

impl Ground for Pavement {
    fn factor(&self, place_m: Point2<f64>) -> f64 {
        let step = |m: f64| (m + self.reach_m) / SQUARE_M;
        let (column, row) = (step(place_m.x), step(place_m.y));
        let within = |i: f64| i >= 0.0 && i < self.side as f64;
        if !within(column) || !within(row) {
            return GRASS_FACTOR;
        }
        if self.paved[row as usize * self.side + column as usize] { 1.0 } else { GRASS_FACTOR }
    }
}

fn inside(polygon: &[Point2<f64>], p: Point2<f64>) -> bool {
    let last = polygon.last().into_iter().chain(polygon);
    let crossings = last.zip(polygon).filter(|(a, b)| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossings.count() % 2 == 1
}

/// The picture that the first radar of a scene shows of the turn after `at`, as a PNG of `size` pixels
/// across: noise, rain with its cells, ground with its runways, walls, shadows, targets.
///
/// `rim_m` is the ground distance at the rim; `None` for the radar's display range. The scene has to be
/// loaded with its movements.
///
/// # Errors
/// One sentence: no radar in the scene, a time outside it, a size outside 64 to 8192 pixels.
pub fn video_png(
    scene: &Scene,
    at: SimTime,
    size: usize,
    rim_m: Option<f64>,
) -> Result<Vec<u8>, String> {
    if !(64..=8192).contains(&size) {
        return Err(format!("a picture of {size} pixels: 64 to 8192 are possible"));
    }
    if at < SimTime::ZERO || at > scene.run.duration {
        return Err(format!(
            "time {} s: the scene lasts from 0 to {} s",
            at.s(),
            scene.run.duration.s()
        ));
    }
    let found = scene.sensors.iter().find_map(|s| Some((s, s.asde.as_ref()?)));
    let (sensor, scene_radar) = found.ok_or("the scene has no radar")?;
    let parameters = scene_radar.parameters.clone();
    let cells = CellRadar::of(&parameters).turn_cells();
    if cells > MOST_CELLS {
        return Err(format!("{cells} cells a turn: at most {MOST_CELLS} are possible"));
    }
    let site_m = sensor.site_m.map_or_else(Point2::origin, |s| s.xy());
    let mut radar = Asde::new(sensor.id, site_m, parameters.clone())
        .map_err(|e| e.to_string())?
        .among(Arc::from(scene.buildings.clone()))
        .at_levels(RadarLevels::EXACT);
    let notice = scene.weather.iter().rev().find(|n| n.time <= at);
    let weather = notice.map_or_else(Weather::default, |n| n.weather.after(at.since_s(n.time)));
    let turn_s = 1.0 / parameters.turns_per_s();
    let interval = ScanInterval {
        run_seed: scene.run.seed,
        scan: (at.s() / turn_s) as u64 + 1,
        from: at,
        to: at.plus_s(turn_s),
    };
    let reach_m = parameters.range_max_m + site_m.coords.norm();
    let ground = Pavement::of(&scene.airport.layout, reach_m.min(12_000.0));
    let truth = Traffic(scene);
    let video = radar.video(&interval, &truth, &weather, &ground, &VideoScene::PICTURE);
    let rim_m = rim_m.unwrap_or(parameters.range_max_m).clamp(100.0, parameters.range_max_m);
    let ppi = Ppi {
        size,
        rim_m,
        ring_m: if rim_m > 2500.0 { 1000.0 } else { 500.0 },
        antenna_m: parameters.antenna_height_m,
        stc: 0.7,
        black_db: -3.0,
        white_db: 24.0,
    };
    png_of(&ppi.draw(&CellRadar::of(&parameters), &video))
}

/// A picture as a PNG file's octets.
///
/// # Errors
/// What the encoder says.
pub fn png_of(picture: &Picture) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let side = u32::try_from(picture.size).map_err(|e| e.to_string())?;
    let mut encoder = png::Encoder::new(&mut out, side, side);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(&picture.rgb).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(out)
}
