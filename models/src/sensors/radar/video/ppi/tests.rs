use super::*;

/// Few cells, all of them unlike, and none where the pulse is still on its way.
fn radar() -> CellRadar {
    CellRadar {
        cell_m: 7.0,
        range_min_m: 40.0,
        cells: 50,
        beams: 22,
        width_rad: 0.1,
        pulses: 4,
        pfa: 1e-6,
        threshold: 20.0,
        recovered: 1.0,
    }
}

fn ppi() -> Ppi {
    Ppi {
        size: 240,
        rim_m: 360.0,
        ring_m: 120.0,
        antenna_m: 35.0,
        stc: 0.7,
        black_db: -3.0,
        white_db: 24.0,
    }
}

fn video(radar: &CellRadar, power: impl Fn(usize, usize) -> f64) -> Video {
    let (beams, cells) = (radar.beams, radar.cells);
    let all = (0..beams * cells).map(|i| power(i / cells, i % cells) as f32).collect();
    Video { beams, cells, power: all, blobs: Vec::new() }
}

/// Pixels that rings, ticks and figures may touch: those of a picture whose echoes say nothing.
fn drawn_over(ppi: &Ppi) -> Vec<bool> {
    let radar = radar();
    let dark = ppi.draw(&radar, &video(&radar, |_, _| 0.0)).rgb;
    let plain = [5, 10, 13];
    dark.chunks(3).map(|p| p != [0; 3] && p != plain).collect()
}

/// Each pixel against the cells themselves: bearing in degrees and slant range of its four points, the median of a range sorted out.
#[test]
fn a_pixel_shows_the_mean_of_the_cells_under_it() {
    let (radar, ppi) = (radar(), ppi());
    let power = |beam: usize, cell: usize| {
        let spread = (beam * 37 + cell * 61) % 97;
        libm::pow(10.0, spread as f64 / 35.0) * 2000.0 / (40.0 + cell as f64 * 9.0)
    };
    let video = video(&radar, power);
    let picture = ppi.draw(&radar, &video);
    assert_eq!((picture.size, picture.rgb.len()), (240, 3 * 240 * 240));
    let after_control = |beam: usize, cell: usize| {
        let mut all: Vec<f64> = (0..22).map(|b| f64::from(power(b, cell) as f32)).collect();
        all.sort_by(f64::total_cmp);
        f64::from(power(beam, cell) as f32) / libm::pow(all[11].max(1.0), 0.7)
    };
    let over = drawn_over(&ppi);
    let (mut compared, mut outside) = (0, 0);
    for (at, pixel) in picture.rgb.chunks(3).enumerate() {
        if over[at] {
            continue;
        }
        let (column, row) = ((at % 240) as f64, (at / 240) as f64);
        let mut powers = Vec::new();
        for (right, down) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let (east_m, north_m) = ((column + right - 120.0) * 3.0, (120.0 - row - down) * 3.0);
            if libm::hypot(east_m, north_m) > 360.0 {
                continue;
            }
            let range_m = libm::hypot(libm::hypot(east_m, north_m), 35.0);
            let bearing_deg = (libm::atan2(east_m, north_m).to_degrees() + 360.0) % 360.0;
            let (cell, beam) = ((range_m - 40.0) / 7.0, (bearing_deg * 22.0 / 360.0) as usize);
            let there = (0.0..50.0).contains(&cell);
            powers.push(if there { after_control(beam, cell as usize) } else { 0.0 });
        }
        let mean = powers.iter().sum::<f64>() / powers.len().max(1) as f64;
        let share = ((10.0 * libm::log10(mean.max(1e-6)) + 3.0) / 27.0).clamp(0.0, 1.0);
        let wanted = [
            0.02 + 0.95 * libm::pow(share, 3.0),
            0.04 + 0.93 * libm::pow(share, 0.8),
            0.05 + 0.1 * share + 0.5 * libm::pow(share, 4.0),
        ];
        for (found, wanted) in pixel.iter().zip(wanted) {
            let wanted = if powers.is_empty() { 0.0 } else { wanted * 255.0 };
            assert!((f64::from(*found) - wanted).abs() <= 0.51, "{column} {row}: {found} {wanted}");
        }
        compared += 1;
        outside += i32::from(powers.is_empty());
    }
    assert!(compared > 50_000 && outside > 8_000, "{compared} {outside}");
}

#[test]
fn colours_go_from_black_over_green_to_pale_and_never_back() {
    let ppi = ppi();
    let at = |db: f64| ppi.colour(libm::pow(10.0, db / 10.0));
    assert_eq!(at(-80.0), [0.02, 0.04, 0.05]);
    assert_eq!(ppi.colour(0.0), at(-3.1));
    for (found, wanted) in at(24.0).into_iter().zip([0.97, 0.97, 0.65]) {
        assert!((found - wanted).abs() < 1e-9, "{found}");
    }
    assert_eq!(at(60.0), at(24.1));
    for step in 0..54 {
        let db = -3.0 + 0.5 * f64::from(step);
        let (dark, bright) = (at(db), at(db + 0.5));
        assert!((0..3).all(|part| dark[part] < bright[part]), "{db}");
        assert!(bright[1] > bright[0] - 1e-9 && bright[1] > bright[2], "{db}");
    }
}

/// Every ring is closed, stands where its distance says and is labelled with it; ticks stand every ten degrees; nothing else is drawn.
#[test]
fn rings_stand_at_their_distances_and_are_labelled() {
    for (size, rim_m, ring_m) in [(240, 360.0, 120.0), (400, 2500.0, 500.0), (300, 9000.0, 1750.0)]
    {
        let ppi = Ppi { size, rim_m, ring_m, ..ppi() };
        let lit = drawn_over(&ppi);
        let (middle, pixel_m) = (size as f64 / 2.0, 2.0 * rim_m / size as f64);
        let is_lit = |x: f64, y: f64| lit[y as usize * size + x as usize];
        // At the rim itself one pixel inwards.
        let radius = |ring: usize| (ring as f64 * ring_m / pixel_m).min(middle - 1.0);
        let rings = 1..=(rim_m / ring_m) as usize;
        let mut explained: Vec<bool> = (0..size * size)
            .map(|at| {
                let (x, y) = ((at % size) as f64 + 0.5 - middle, (at / size) as f64 + 0.5 - middle);
                rings.clone().any(|ring| (libm::hypot(x, y) - radius(ring)).abs() <= 0.7072)
            })
            .collect();
        for ring in rings {
            for step in 0..3600 {
                let (sin, cos) = libm::sincos(f64::from(step).to_radians() / 10.0);
                let (x, y) = (middle + radius(ring) * sin, middle - radius(ring) * cos);
                let around = [-1.0, 0.0, 1.0].map(|i| [-1.0, 0.0, 1.0].map(|j| (x + i, y + j)));
                let near = around.concat();
                let inside = near.iter().filter(|(x, y)| x.max(*y) < size as f64);
                assert!(inside.into_iter().any(|(x, y)| is_lit(*x, *y)), "{size}: {ring} {step}");
            }
            let (left, top) = (middle + 6.0, (middle - radius(ring) + 4.0).floor());
            let wanted = format!("{:.0}", ring as f64 * ring_m);
            let mut said = String::new();
            for place in 0..wanted.len() {
                let rows = [0, 1, 2, 3, 4].map(|row| {
                    (0..3).fold(0, |bits, column| {
                        let x = left + 8.0 * place as f64 + 2.0 * f64::from(column);
                        let y = top + 2.0 * f64::from(row);
                        let four = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
                        let on = four.iter().all(|(i, j)| is_lit(x + i, y + j));
                        for (i, j) in four.iter().filter(|_| on) {
                            explained[(y + j) as usize * size + (x + i) as usize] = true;
                        }
                        2 * bits + u8::from(on)
                    })
                });
                let digit = DIGITS.iter().position(|d| *d == rows);
                said.push(digit.map_or('?', |d| char::from(b'0' + d as u8)));
            }
            assert_eq!(said, wanted, "{size}");
        }
        for ten in 0..36u32 {
            let (sin, cos) = libm::sincos(f64::from(10 * ten).to_radians());
            let long = if ten % 9 == 0 { 24 } else { 10 };
            for i in 1..=long {
                let inwards = middle - f64::from(i);
                let (x, y) = (middle + inwards * sin, middle - inwards * cos);
                // On the border between two pixels rounding decides.
                let pixels = [(-1e-6, -1e-6), (-1e-6, 1e-6), (1e-6, -1e-6), (1e-6, 1e-6)];
                let any = pixels.iter().any(|(i, j)| is_lit(x + i, y + j));
                assert!(any, "{size}: tick {ten}, {i} from the rim");
                for (i, j) in pixels {
                    explained[(y + j) as usize * size + (x + i) as usize] = true;
                }
            }
        }
        let stray = (0..size * size).find(|&at| lit[at] && !explained[at]);
        assert_eq!(stray, None, "{size}: drawn for nothing");
    }
}

/// Lines are put over the picture by a share, towards one colour, and make nothing darker.
#[test]
fn lines_let_the_picture_through() {
    let (radar, ppi) = (radar(), ppi());
    let all = |db: f64| {
        let of = |_: usize, _: usize| libm::pow(10.0, db / 10.0);
        Ppi { stc: 0.0, ..ppi }.draw(&radar, &video(&radar, of)).rgb
    };
    let (dark, bright) = (all(-30.0), all(40.0));
    let at = |(x, y): (usize, usize)| 3 * (y * 240 + x);
    // A tick, and a ring, both to the north.
    for (pixel, share) in [((120, 11), 0.9), ((120, 80), 0.45)] {
        for (part, (line, under)) in [(0.25, 5.0), (0.45, 10.0), (0.6, 13.0)].iter().enumerate() {
            let found = f64::from(dark[at(pixel) + part]);
            let least = under + (line * 255.0 - under) * share;
            let most = if share > 0.5 { least } else { line * 255.0 };
            assert!(found >= least - 1.0 && found <= most, "{pixel:?} {part}: {found} {least}");
        }
    }
    assert!(bright.iter().zip(&dark).all(|(b, d)| b >= d), "darker under a line");
    assert_eq!(bright[at((120, 80))..][..3], [247, 247, 166]);
}
