//! Tracks of others: what a record of category 010, 011, 020, 021 or 062 says of a track.

use asterix::table::Item;
use asterix::{Record, Value, View, cat010, cat011, cat020, cat021, cat062};

/// Nautical mile, m.
const NM_M: f64 = 1852.0;

/// One report of a track.
#[derive(Clone, Debug, PartialEq)]
pub struct ForeignTrack {
    /// System area code and identification code of who sent it.
    pub source: (u8, u8),
    /// Category of the record.
    pub category: u8,
    /// Track number.
    pub number: u32,
    /// Time of day, s.
    pub of_day_s: f64,
    /// Where it is.
    pub place: ForeignPlace,
    /// East and north, m/s, where it is said.
    pub velocity_mps: Option<[f64; 2]>,
    /// Call sign; empty for none.
    pub label: String,
    /// Not confirmed.
    pub tentative: bool,
    /// Without a recent plot.
    pub coasting: bool,
    /// Last message of the track.
    pub last: bool,
}

/// How a position was said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ForeignPlace {
    /// Latitude and longitude, degrees.
    Degrees([f64; 2]),
    /// East and north of the sender's reference point, m.
    Local([f64; 2]),
    /// Slant range, m, and azimuth from north, degrees, as the sensor of this number sees it from its site.
    Polar([f64; 2]),
}

/// Who sent a record.
#[must_use]
pub fn source(record: &Record<'_>) -> Option<(u8, u8)> {
    record.source()
}

/// The first time of day in a record, s.
#[must_use]
pub fn of_day_s(record: &Record<'_>) -> Option<f64> {
    let values = record.items().flat_map(|view| view.values());
    let mut times = values.filter(|(field, _)| field.kind == asterix::table::Kind::TimeOfDay);
    times.next()?.1.number()
}

/// Where a category keeps what a track is made of.
struct Rows {
    number: &'static Item,
    times: &'static [&'static Item],
    degrees: &'static [&'static Item],
    local: Option<&'static Item>,
    polar: Option<&'static Item>,
    velocity: Option<&'static Item>,
    /// The same by speed, NM/s, and angle.
    polar_velocity: Option<&'static Item>,
    status: Option<&'static Item>,
    last: &'static str,
}

static ROWS: &[(u8, Rows)] = &[
    (
        10,
        Rows {
            number: &cat010::I161,
            times: &[&cat010::I140],
            degrees: &[&cat010::I041],
            local: Some(&cat010::I042),
            polar: Some(&cat010::I040),
            velocity: Some(&cat010::I202),
            polar_velocity: Some(&cat010::I200),
            status: Some(&cat010::I170),
            last: "TRE",
        },
    ),
    (
        11,
        Rows {
            number: &cat011::I161,
            times: &[&cat011::I140],
            degrees: &[&cat011::I041],
            local: Some(&cat011::I042),
            polar: None,
            velocity: Some(&cat011::I202),
            polar_velocity: None,
            status: Some(&cat011::I170),
            last: "TSE",
        },
    ),
    (
        20,
        Rows {
            number: &cat020::I161,
            times: &[&cat020::I140],
            degrees: &[&cat020::I041],
            local: Some(&cat020::I042),
            polar: None,
            velocity: Some(&cat020::I202),
            polar_velocity: None,
            status: Some(&cat020::I170),
            last: "TRE",
        },
    ),
    (
        21,
        Rows {
            number: &cat021::I161,
            times: &[&cat021::I071, &cat021::I073, &cat021::I077],
            degrees: &[&cat021::I131, &cat021::I130],
            local: None,
            polar: None,
            velocity: None,
            polar_velocity: None,
            status: None,
            last: "",
        },
    ),
    (
        62,
        Rows {
            number: &cat062::I040,
            times: &[&cat062::I070],
            degrees: &[&cat062::I105],
            local: Some(&cat062::I100),
            polar: None,
            velocity: Some(&cat062::I185),
            polar_velocity: None,
            status: Some(&cat062::I080),
            last: "TSE",
        },
    ),
];

/// The report of a track that a record makes; `None` where it is not one (a plot, a status) or lacks
/// number, time or position.
#[must_use]
pub fn track(record: &Record<'_>) -> Option<ForeignTrack> {
    let category = record.category.number;
    let rows = ROWS.iter().find(|(number, _)| *number == category).map(|(_, rows)| rows)?;
    let degrees = rows.degrees.iter().find_map(|item| record.numbers(item));
    let local = || record.numbers(rows.local?).map(ForeignPlace::Local);
    let polar = || record.numbers(rows.polar?).map(ForeignPlace::Polar);
    let status = rows.status.and_then(|item| record.get(item));
    let set = |name: &str| {
        let value = status.and_then(|view| view.value(name));
        value.is_some_and(|v| v != Value::Integer(0))
    };
    Some(ForeignTrack {
        source: source(record)?,
        category,
        number: record.number(rows.number)? as u32,
        of_day_s: rows.times.iter().find_map(|item| record.number(item))?,
        place: match degrees {
            Some(place) => ForeignPlace::Degrees(place),
            None => local().or_else(polar)?,
        },
        velocity_mps: match rows.velocity {
            Some(item) => record.numbers(item).or_else(|| {
                let [nm_per_s, degrees] = record.numbers(rows.polar_velocity?)?;
                Some(east_north(nm_per_s * NM_M, degrees))
            }),
            None => ground_vector(record),
        },
        label: label(record),
        tentative: set("CNF"),
        coasting: set("CST"),
        last: set(rows.last),
    })
}

/// Surface or airborne ground vector of category 021, m/s. Who stands needs no angle; one that is not valid is none.
fn ground_vector(record: &Record<'_>) -> Option<[f64; 2]> {
    const KNOT_MPS: f64 = NM_M / 3600.0;
    let surface = || {
        let field = record.get(&cat021::RE)?;
        let vector = field.sub(&cat021::RE_SGV)?;
        let number = |name| vector.value(name)?.number();
        let speed_kt = number("GSS")?;
        if number("STP")? != 0.0 || speed_kt == 0.0 {
            return Some([0.0, 0.0]);
        }
        Some([speed_kt * KNOT_MPS, number("HGT").filter(|_| number("HTS") != Some(0.0))?])
    };
    let airborne = || {
        let [_, nm_per_s, degrees] = record.numbers(&cat021::I160)?;
        Some([nm_per_s * NM_M, degrees])
    };
    let [speed_mps, degrees] = surface().or_else(airborne)?;
    Some(east_north(speed_mps, degrees))
}

/// Parts of a speed on an angle from north.
fn east_north(speed_mps: f64, degrees: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    [speed_mps * sin, speed_mps * cos]
}

fn label(record: &Record<'_>) -> String {
    let of = |item: &'static Item, sub: Option<&'static Item>| -> Option<String> {
        let view: View<'_> = record.get(item)?;
        let text = match sub {
            Some(sub) => view.sub(sub)?.text()?,
            None => view.text()?,
        };
        Some(text.trimmed().to_owned()).filter(|t| !t.is_empty())
    };
    let found = match record.category.number {
        10 => of(&cat010::I245, None),
        11 => of(&cat011::I390, Some(&cat011::I390_CSN)).or_else(|| of(&cat011::I245, None)),
        20 => of(&cat020::I245, None),
        21 => of(&cat021::I170, None),
        62 => of(&cat062::I390, Some(&cat062::I390_CS))
            .or_else(|| of(&cat062::I380, Some(&cat062::I380_ID))),
        _ => None,
    };
    found.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_track_of_each_category_is_read() {
        let read = |hex: &str| {
            let datagram = asterix::json::octets(hex).expect("digits");
            let block = asterix::blocks(&datagram).next().expect("a block").expect("sound");
            let record = block.records().next().expect("a record").expect("sound");
            track(&record)
        };
        let mlat = read("140037ffcd0c0008bf144650800081cac10018cff8fffe0b000708014102029c001bfffc3c65868005a071cb3d2040000a000d000001b1").expect("a track");
        assert_eq!((mlat.source, mlat.number, mlat.label.as_str()), ((0, 8), 321, "AZA1234"));
        assert_eq!(mlat.velocity_mps, Some([6.75, -1.0]));
        let adsb = read("150036eb193103c1410400030960001f3f480010df69ff030ade394b18053f482051f314123f48284d74b1cf7220030140050860f3c2").expect("a track");
        let [east, north] = adsb.velocity_mps.expect("a ground vector");
        // 15.125 kt on 272.8125°.
        assert!((east + 7.7717).abs() < 1e-3 && (north - 0.3818).abs() < 1e-3, "{east} {north}");
        assert_eq!(adsb.of_day_s, 32_400.0);
        let system = read("3e006bbfdfa3840014014651000081cac10018cff8fffe0b0007080021fff202ff029cc03c658605a071cb3d200141019101010110c120c8040210001e4fcc415a4131323334413332304d4c494d434548414d33355201100a0c1e4231322020204d514484000400050203").expect("a track");
        assert_eq!((system.category, system.label.as_str()), (62, "AZA1234"));
        assert!(!system.tentative && !system.coasting && !system.last);
        // A track of 010 with range and azimuth alone: SIC 9, 1000 m on 90°, number 5.
        let mut packer = asterix::Packer::new(1400);
        let written = packer.record(&cat010::CATEGORY, |items| {
            items.put(&cat010::I010, &[0, 9])?;
            items.put(&cat010::I000, &[1])?;
            items.put(&cat010::I140, &[32_400.0])?;
            items.put(&cat010::I040, &[1000.0, 90.0])?;
            items.put(&cat010::I161, &[5])
        });
        written.expect("it fits");
        let digits: Vec<String> =
            packer.take().concat().iter().map(|o| format!("{o:02x}")).collect();
        let polar = read(&digits.concat()).expect("a track");
        assert_eq!((polar.number, polar.place), (5, ForeignPlace::Polar([1000.0, 90.0])));
        assert_eq!(polar.velocity_mps, None);
        assert_eq!(
            read("0a001ff70109a0000701618046504005dc60000425fbdb4d41440a0cfffbb4"),
            None,
            "a plot"
        );
    }

    /// Reports of ADS-B say on the ground that they stand, a speed with an angle, or a speed whose angle is not valid.
    #[test]
    fn who_says_that_he_stands_has_a_velocity_of_zero() {
        let velocity = |surface: Option<&[f64]>, airborne: Option<[f64; 3]>| {
            let mut packer = asterix::Packer::new(1400);
            let written = packer.record(&cat021::CATEGORY, |items| {
                items.put(&cat021::I010, &[0, 9])?;
                items.put(&cat021::I040, &[0])?;
                items.put(&cat021::I161, &[5])?;
                items.put(&cat021::I071, &[32_400.0])?;
                items.put(&cat021::I131, &[47.4, 8.5])?;
                if let Some(airborne) = airborne {
                    items.put(&cat021::I160, &airborne)?;
                }
                match surface {
                    Some(surface) => {
                        items.compound(&cat021::RE, |sub| sub.put(&cat021::RE_SGV, surface))
                    }
                    None => Ok(()),
                }
            });
            written.expect("it fits");
            let octets = packer.take().concat();
            let block = asterix::blocks(&octets).next().expect("a block").expect("sound");
            track(&block.records().next().expect("a record").expect("sound"))
                .expect("a track")
                .velocity_mps
        };
        let near = |said: Option<[f64; 2]>, [east, north]: [f64; 2]| {
            said.is_some_and(|[e, n]| libm::hypot(e - east, n - north) < 0.1)
        };
        // STP, HTS, HTT, HRD, GSS, and HGT where it goes on.
        let stands: [&[f64]; 5] = [
            &[1.0, 0.0, 0.0, 0.0, 0.0],
            &[0.0, 0.0, 0.0, 0.0, 0.0],
            &[1.0, 0.0, 0.0, 0.0, 15.0],
            &[1.0, 1.0, 1.0, 0.0, 0.0, 90.0],
            &[0.0, 0.0, 1.0, 0.0, 0.0, 90.0],
        ];
        for surface in stands {
            assert_eq!(velocity(Some(surface), None), Some([0.0, 0.0]), "{surface:?}");
        }
        let mps = 15.0 * 1852.0 / 3600.0;
        assert!(near(velocity(Some(&[0.0, 1.0, 1.0, 0.0, 15.0, 270.0]), None), [-mps, 0.0]));
        for unknown in [&[0.0, 0.0, 0.0, 0.0, 15.0][..], &[0.0, 0.0, 1.0, 0.0, 15.0, 270.0]] {
            assert_eq!(velocity(Some(unknown), None), None, "where to is not known: {unknown:?}");
            let both = velocity(Some(unknown), Some([0.0, 0.01, 90.0]));
            assert!(near(both, [18.52, 0.0]), "{both:?}");
        }
        assert_eq!(velocity(None, None), None);
    }

    /// Radars of surface movement say a velocity by its parts, by speed and angle, or both ways.
    #[test]
    fn a_velocity_by_speed_and_angle_is_as_good_as_one_by_its_parts() {
        let velocity = |parts: Option<[f64; 2]>, polar: Option<[f64; 2]>| {
            let mut packer = asterix::Packer::new(1400);
            let written = packer.record(&cat010::CATEGORY, |items| {
                items.put(&cat010::I010, &[0, 9])?;
                items.put(&cat010::I000, &[1])?;
                items.put(&cat010::I140, &[32_400.0])?;
                items.put(&cat010::I042, &[10.0, 20.0])?;
                if let Some(polar) = polar {
                    items.put(&cat010::I200, &polar)?;
                }
                if let Some(parts) = parts {
                    items.put(&cat010::I202, &parts)?;
                }
                items.put(&cat010::I161, &[5])
            });
            written.expect("it fits");
            let octets = packer.take().concat();
            let block = asterix::blocks(&octets).next().expect("a block").expect("sound");
            track(&block.records().next().expect("a record").expect("sound"))?.velocity_mps
        };
        assert_eq!(
            (velocity(None, None), velocity(Some([3.0, -4.0]), None)),
            (None, Some([3.0, -4.0]))
        );
        for degrees in [0.0, 30.0, 143.0, 270.0_f64] {
            for speed_mps in [0.0, 7.5, 80.0] {
                let (sin, cos) = libm::sincos(degrees.to_radians());
                let [east, north] =
                    velocity(None, Some([speed_mps / 1852.0, degrees])).expect("a velocity");
                let off_mps = libm::hypot(east - speed_mps * sin, north - speed_mps * cos);
                // Half a step of the speed, 0.057 m/s, and of the angle.
                assert!(off_mps < 0.06 + 5e-5 * speed_mps, "{speed_mps} at {degrees}: {off_mps}");
            }
        }
        assert_eq!(velocity(Some([3.0, -4.0]), Some([0.1, 90.0])), Some([3.0, -4.0]));
    }
}
