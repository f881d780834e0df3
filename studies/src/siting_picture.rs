//! A map of a site as a picture: colours by value, sites, footprints, a scale and a colour bar with its ends.

use crate::picture::Pavement;
use crate::siting::{Grid, Map, NO_DATA};
use crate::siting_rating::Rating;
use models::frames::{Point2, Vector2};
use models::sensors::asde::picture::Ground as _;
use models::sensors::radar::shadow::Building;
use scenarios::Scene;

/// Colours from low to high: dark blue, green, yellow.
const COLOURS: [[f32; 3]; 5] = [
    [68.0, 1.0, 84.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [253.0, 231.0, 37.0],
];
/// Rows of the bar below the map, pixels.
const BAR: usize = 34;
/// Least width of a picture, pixels.
const LEAST_WIDTH: usize = 420;

/// Glyphs of 3 × 5 points, rows from the top, bits from the left.
const GLYPHS: [(char, [u8; 5]); 42] = [
    ('0', [7, 5, 5, 5, 7]),
    ('1', [2, 6, 2, 2, 7]),
    ('2', [7, 1, 7, 4, 7]),
    ('3', [7, 1, 3, 1, 7]),
    ('4', [5, 5, 7, 1, 1]),
    ('5', [7, 4, 7, 1, 7]),
    ('6', [7, 4, 7, 5, 7]),
    ('7', [7, 1, 2, 2, 2]),
    ('8', [7, 5, 7, 5, 7]),
    ('9', [7, 5, 7, 1, 7]),
    ('.', [0, 0, 0, 0, 2]),
    ('-', [0, 0, 7, 0, 0]),
    ('_', [0, 0, 0, 0, 7]),
    ('/', [1, 1, 2, 4, 4]),
    (':', [0, 2, 0, 2, 0]),
    (',', [0, 0, 0, 2, 4]),
    ('A', [2, 5, 7, 5, 5]),
    ('B', [6, 5, 6, 5, 6]),
    ('C', [3, 4, 4, 4, 3]),
    ('D', [6, 5, 5, 5, 6]),
    ('E', [7, 4, 6, 4, 7]),
    ('F', [7, 4, 6, 4, 4]),
    ('G', [3, 4, 5, 5, 3]),
    ('H', [5, 5, 7, 5, 5]),
    ('I', [7, 2, 2, 2, 7]),
    ('J', [1, 1, 1, 5, 2]),
    ('K', [5, 5, 6, 5, 5]),
    ('L', [4, 4, 4, 4, 7]),
    ('M', [5, 7, 7, 5, 5]),
    ('N', [6, 5, 5, 5, 5]),
    ('O', [2, 5, 5, 5, 2]),
    ('P', [6, 5, 6, 4, 4]),
    ('Q', [2, 5, 5, 6, 3]),
    ('R', [6, 5, 6, 5, 5]),
    ('S', [3, 4, 2, 1, 6]),
    ('T', [7, 2, 2, 2, 2]),
    ('U', [5, 5, 5, 5, 7]),
    ('V', [5, 5, 5, 5, 2]),
    ('W', [5, 5, 7, 7, 5]),
    ('X', [5, 5, 2, 5, 5]),
    ('Y', [5, 5, 2, 2, 2]),
    ('Z', [7, 1, 2, 4, 7]),
];

struct Canvas {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Canvas {
    fn set(&mut self, x: i64, y: i64, colour: [u8; 3]) {
        if x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height {
            let at = 3 * (y as usize * self.width + x as usize);
            self.rgb[at..at + 3].copy_from_slice(&colour);
        }
    }

    fn text(&mut self, x: i64, y: i64, text: &str) -> i64 {
        let mut x = x;
        for c in text.to_uppercase().chars() {
            if let Some((_, rows)) = GLYPHS.iter().find(|g| g.0 == c) {
                for (row, bits) in (0i64..).zip(rows) {
                    for column in (0..3i64).filter(|k| bits >> (2 - k) & 1 == 1) {
                        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                            self.set(x + 2 * column + dx, y + 2 * row + dy, [0; 3]);
                        }
                    }
                }
            }
            x += 8;
        }
        x
    }

    fn line(&mut self, a: (f64, f64), b: (f64, f64), colour: [u8; 3]) {
        let steps = (b.0 - a.0).abs().max((b.1 - a.1).abs()).ceil().clamp(1.0, 1e5) as u32;
        for i in 0..=steps {
            let share = f64::from(i) / f64::from(steps);
            let at = (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1));
            self.set(at.0.round() as i64, at.1.round() as i64, colour);
        }
    }
}

fn colour(share: f32) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f32;
    let low = (at as usize).min(COLOURS.len() - 2);
    let part = at - low as f32;
    [0, 1, 2].map(|i| (COLOURS[low][i] + part * (COLOURS[low + 1][i] - COLOURS[low][i])) as u8)
}

/// The ends of the colours: the whole range of probabilities, else all but the farthest hundredths.
fn range(map: &Map) -> (f32, f32) {
    if matches!(map.layer, "pd" | "pd_any") {
        return (0.0, 1.0);
    }
    let mut values: Vec<f32> = map.known().collect();
    if values.is_empty() {
        return (0.0, 1.0);
    }
    values.sort_by(f32::total_cmp);
    let at = |share: f32| values[((values.len() - 1) as f32 * share) as usize];
    let (low, high) = (at(0.01), at(0.99));
    if high > low { (low, high) } else { (low, low + 1.0) }
}

/// The picture as a PNG file's octets.
///
/// # Errors
/// What the encoder says.
pub fn png(
    map: &Map,
    grid: &Grid,
    sites_m: &[Point2<f64>],
    buildings: &[Building],
) -> Result<Vec<u8>, String> {
    let (columns, rows) = grid.size;
    let (low, high) = range(map);
    let (width, height) = (columns.max(LEAST_WIDTH), rows + BAR);
    let mut canvas = Canvas { width, height, rgb: vec![255; 3 * width * height] };
    for (i, &value) in map.values.iter().enumerate() {
        let of = match () {
            () if value != NO_DATA => colour((value - low) / (high - low)),
            () if grid.area[i] => [120; 3],
            () => continue,
        };
        canvas.set((i % columns) as i64, (i / columns) as i64, of);
    }
    let pixel = |place: Point2<f64>| {
        let away = (place - grid.first_m) / grid.step_m;
        (away.x, -away.y)
    };
    for building in buildings {
        for (a, b) in building.walls() {
            canvas.line(pixel(a), pixel(b), [0; 3]);
        }
    }
    for site in sites_m {
        let (x, y) = pixel(*site);
        for k in -4..=4 {
            canvas.set(x as i64 + k, y as i64, [220, 0, 0]);
            canvas.set(x as i64, y as i64 + k, [220, 0, 0]);
        }
    }
    let top = (rows + 4) as i64;
    for x in 0..120i64 {
        for y in 0..8 {
            canvas.set(4 + x, top + y, colour(x as f32 / 119.0));
        }
    }
    let number = |v: f32| if v.abs() >= 100.0 { format!("{v:.0}") } else { format!("{v:.2}") };
    canvas.text(4, top + 14, &number(low));
    let end = number(high);
    canvas.text(124 - 8 * end.len() as i64, top + 14, &end);
    // A kilometre, or as much of it as there is room for.
    let scale_m = if grid.step_m * 150.0 >= 1000.0 { 1000.0 } else { 100.0 };
    let long = (scale_m / grid.step_m) as i64;
    for x in 0..=long.min(150) {
        for y in 0..2 {
            canvas.set(140 + x, top + 4 + y, [0; 3]);
        }
    }
    canvas.text(140, top + 14, &format!("{scale_m:.0} M"));
    let words = format!("{} {} {}", map.layer, map.unit, map.weather);
    canvas.text(300, top + 14, words.trim());
    encoded(&canvas)
}

/// Longer side of the picture of candidates, pixels.
const CANDIDATES_SIDE: f64 = 900.0;
/// Most names below it.
const MOST_NAMES: usize = 20;

/// The airport with ranked sites as a PNG file's octets: each with its rank, the present one in red, names and
/// shares below.
///
/// # Errors
/// What the encoder says.
pub fn candidates_png(scene: &Scene, grid: &Grid, ratings: &[Rating]) -> Result<Vec<u8>, String> {
    let ends = [grid.place(0), grid.place(grid.area.len().saturating_sub(1))];
    let places = || ends.into_iter().chain(ratings.iter().map(|r| r.candidate.site_m.xy()));
    let margin = Vector2::repeat(100.0);
    let low = places().fold(ends[0], |m, p| m.inf(&p)) - margin;
    let high = places().fold(ends[0], |m, p| m.sup(&p)) + margin;
    let size = high - low;
    let step_m = size.max() / CANDIDATES_SIDE;
    let [columns, rows] = [size.x, size.y].map(|side| ((side / step_m) as usize).max(1));
    let names = ratings.len().min(MOST_NAMES);
    let (width, height) = (columns.max(LEAST_WIDTH), rows + 14 * names + 8);
    let mut canvas = Canvas { width, height, rgb: vec![255; 3 * width * height] };
    let pavement =
        Pavement::of(&scene.airport.layout, low.coords.abs().sup(&high.coords.abs()).max() + 10.0);
    for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
        let place = Point2::new(low.x + x as f64 * step_m, high.y - y as f64 * step_m);
        if pavement.factor(place) == 1.0 {
            canvas.set(x as i64, y as i64, [190; 3]);
        }
    }
    let pixel = |place: Point2<f64>| ((place.x - low.x) / step_m, (high.y - place.y) / step_m);
    for (a, b) in scene.buildings.iter().flat_map(Building::walls) {
        canvas.line(pixel(a), pixel(b), [0; 3]);
    }
    // The best ones last: they stay legible where sites are close together.
    for (rank, r) in (1..).zip(ratings).collect::<Vec<(usize, _)>>().into_iter().rev() {
        let (x, y) = pixel(r.candidate.site_m.xy());
        let (x, y) = (x.round() as i64, y.round() as i64);
        let (best, present) = ([0, 140, 0], [220, 0, 0]);
        let of = match () {
            () if r.candidate.present => present,
            () if rank == 1 => best,
            () => [0, 60, 200],
        };
        for (dx, dy) in (-4..=4i64).flat_map(|dx| (-4..=4i64).map(move |dy| (dx, dy))) {
            if dx * dx + dy * dy <= 18 {
                canvas.set(x + dx, y + dy, of);
            }
        }
        canvas.text(x + 7, y - 5, &rank.to_string());
    }
    for (rank, r) in (1usize..).zip(ratings).take(names) {
        let line = format!("{rank} {} {:.3}", r.candidate.name, r.worst.share);
        canvas.text(4, (rows + 14 * (rank - 1) + 6) as i64, &line);
    }
    encoded(&canvas)
}

fn encoded(canvas: &Canvas) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let [w, h] = [canvas.width, canvas.height].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let mut encoder = png::Encoder::new(&mut out, w, h);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(&canvas.rgb).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(out)
}
