//! What a record of category 010, 020, 021, 048 or 062 says of a plot.

use asterix::table::Item;
use asterix::{Record, Text, View, cat010, cat020, cat021, cat048, cat062};
use models::plot::{Callsign, Identity};

/// One foot, m; one nautical mile, m.
const FOOT_M: f64 = 0.3048;
const NM_M: f64 = 1852.0;
/// A hundred feet, m.
const LEVEL_M: f64 = 100.0 * FOOT_M;

/// One report, as it was said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Time of day of the measurement, ns (a step is 1/128 s).
    pub of_day_ns: i64,
    /// Where.
    pub place: Place,
    /// Range, m, and azimuth from north, rad, as measured from the site.
    pub polar: Option<[f64; 2]>,
    /// Variance east, covariance, variance north, m², where they are said.
    pub cov_m2: Option<[f64; 3]>,
    /// Height, m, where it is said.
    pub height: Option<Height>,
    /// Signal to clutter and noise, dB, where it is said.
    pub scnr_db: Option<f64>,
    /// Who, where it is said.
    pub identity: Option<Identity>,
}

/// How a position was said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Latitude and longitude, degrees.
    Degrees([f64; 2]),
    /// East and north of the reference point, m.
    Local([f64; 2]),
    /// East and north of the site, m.
    FromSite([f64; 2]),
    /// By range and azimuth alone.
    Polar,
}

/// How a height was said, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Height {
    /// Above the reference plane.
    Local(f64),
    /// Above the ellipsoid or the sea (the scene has one height for both).
    Sea(f64),
    /// Flight level: good enough to correct a slant range.
    Pressure(f64),
}

/// The plot that a record reports; `None` for messages that are no reports of targets.
///
/// # Errors
/// What it lacks, or why it is no measurement.
pub fn reading(record: &Record<'_>) -> Result<Option<Reading>, &'static str> {
    let first = |items: &[&'static Item]| items.iter().find_map(|item| record.number(item));
    let two = |item| record.numbers::<2>(item);
    let (time, place, polar, height) = match record.category.number {
        10 => {
            if record.number(&cat010::I000) != Some(1.0) {
                return Ok(None);
            }
            let polar = two(&cat010::I040).map(|[rho_m, deg]| [rho_m, deg.to_radians()]);
            let place = two(&cat010::I041).map(Place::Degrees);
            let place = place.or_else(|| two(&cat010::I042).map(Place::Local));
            let height = first(&[&cat010::I091]).map(|feet| Height::Local(feet * FOOT_M));
            (first(&[&cat010::I140]), place, polar, height)
        }
        20 => {
            let place = two(&cat020::I041).map(Place::Degrees);
            let place = place.or_else(|| two(&cat020::I042).map(Place::Local));
            let geometric = first(&[&cat020::I105]).map(|feet| Height::Sea(feet * FOOT_M));
            let local = || first(&[&cat020::I110]).map(|feet| Height::Local(feet * FOOT_M));
            (first(&[&cat020::I140]), place, None, geometric.or_else(local))
        }
        21 => {
            let place = two(&cat021::I131).or_else(|| two(&cat021::I130)).map(Place::Degrees);
            let height = first(&[&cat021::I140]).map(|feet| Height::Sea(feet * FOOT_M));
            let times: [&'static Item; 3] = [&cat021::I071, &cat021::I073, &cat021::I077];
            (first(&times), place, None, height)
        }
        48 => {
            let polar = two(&cat048::I040).map(|[rho, deg]| [rho * NM_M, deg.to_radians()]);
            let place = two(&cat048::I042).map(|place| Place::FromSite(place.map(|nm| nm * NM_M)));
            let measured = first(&[&cat048::I110]).map(|feet| Height::Sea(feet * FOOT_M));
            let level = || {
                let [invalid, _, level] = record.numbers::<3>(&cat048::I090)?;
                (invalid == 0.0).then_some(Height::Pressure(level * LEVEL_M))
            };
            // What was measured comes before what was calculated of it.
            let place = if polar.is_some() { None } else { place };
            (first(&[&cat048::I140]), place, polar, measured.or_else(level))
        }
        62 => {
            let place = two(&cat062::I105).map(Place::Degrees);
            let place = place.or_else(|| two(&cat062::I100).map(Place::Local));
            let height = first(&[&cat062::I130]).map(|feet| Height::Sea(feet * FOOT_M));
            (first(&[&cat062::I070]), place, None, height)
        }
        _ => return Ok(None),
    };
    let place = match (place, polar) {
        (Some(place), _) => place,
        (None, Some(_)) => Place::Polar,
        (None, None) => return Err("a plot without a position"),
    };
    if let Some(reason) = unmeasured(record) {
        return Err(reason);
    }
    Ok(Some(Reading {
        of_day_ns: (time.ok_or("a plot without a time")? * 1e9).round() as i64,
        place,
        polar,
        cov_m2: covariance(record),
        height,
        scnr_db: record.number(&cat010::I131).map(|twice| twice / 2.0),
        identity: identity(record),
    }))
}

/// Why a report of a target measured nothing: what was extrapolated, the farewell of a track (where it was last, or would be by now),
/// targets of tests and monitors in the field. Simulated ones are targets.
fn unmeasured(record: &Record<'_>) -> Option<&'static str> {
    let get = |item: &'static Item| record.get(item);
    let (descriptor, status, last) = match record.category.number {
        10 => (get(&cat010::I020), get(&cat010::I170), "TRE"),
        20 => (get(&cat020::I020), get(&cat020::I170), "TRE"),
        21 => (get(&cat021::I040), None, ""),
        48 => (get(&cat048::I020), None, ""),
        62 => {
            let measured = get(&cat062::I340).and_then(|view| view.sub(&cat062::I340_TYP));
            (measured, get(&cat062::I080), "TSE")
        }
        _ => return None,
    };
    let code = |view: Option<View<'_>>, name: &str| view?.value(name)?.number();
    let set = |view, name: &str| code(view, name).is_some_and(|number| number != 0.0);
    let undetected = record.category.number == 48 && code(descriptor, "TYP") == Some(0.0);
    [
        (set(status, "CST"), "an extrapolated position"),
        (set(status, last), "the last report of a track"),
        (set(descriptor, "TST"), "a test target"),
        (set(descriptor, "RAB"), "a field monitor"),
        (undetected, "a report without a detection"),
    ]
    .into_iter()
    .find_map(|(is, reason)| is.then_some(reason))
}

fn covariance(record: &Record<'_>) -> Option<[f64; 3]> {
    let sub = |item: &'static Item, sub: &'static Item| record.get(item)?.sub(sub);
    match record.category.number {
        10 => {
            let [east_m, north_m, en_m2] = record.numbers(&cat010::I500)?;
            Some([east_m * east_m, en_m2, north_m * north_m])
        }
        20 => {
            let said = sub(&cat020::I500, &cat020::I500_SDP)?;
            let mut numbers = said.data().filter_map(|datum| datum.number());
            let (east_m, north_m) = (numbers.next()?, numbers.next()?);
            let correlation = numbers.next()?.clamp(-1.0, 1.0);
            Some([east_m * east_m, correlation * east_m * north_m, north_m * north_m])
        }
        21 => {
            let category = record.get(&cat021::I090)?.value("NACP")?.number()?;
            // 95 % radius of the navigation accuracy category (DO-260B); of two normal axes it is 2.45 deviations. Category 0 is not
            // known: as of a record that states none.
            let radius_m = match category as u8 {
                11 => 3.0,
                10 => 10.0,
                9 => 30.0,
                8 => 92.6,
                7 => 185.2,
                6 => 555.6,
                5 => 926.0,
                4 => 1852.0,
                3 => 3704.0,
                2 => 7408.0,
                1 => 18_520.0,
                _ => return None,
            };
            let sigma_m: f64 = radius_m / 2.447_746_830_680_816;
            Some([sigma_m * sigma_m, 0.0, sigma_m * sigma_m])
        }
        62 => {
            let said = sub(&cat062::I500, &cat062::I500_APC)?;
            let mut numbers = said.data().filter_map(|datum| datum.number());
            let (east_m, north_m) = (numbers.next()?, numbers.next()?);
            let root = sub(&cat062::I500, &cat062::I500_COV)
                .and_then(|view| view.data().next()?.number())
                .unwrap_or(0.0);
            Some([east_m * east_m, root * root.abs(), north_m * north_m])
        }
        _ => None,
    }
}

fn identity(record: &Record<'_>) -> Option<Identity> {
    let said = |text: Text| Some(text.trimmed().to_owned()).filter(|name| !name.is_empty());
    let text = |item: &'static Item| said(record.get(item)?.text()?);
    let inner = |item: &'static Item, sub: &'static Item| record.get(item)?.sub(sub);
    let inner_text = |item, sub| said(inner(item, sub)?.text()?);
    let code = |item: &'static Item| record.number(item);
    let inner_code = |item, sub| inner(item, sub)?.data().next()?.number();
    let (name, address) = match record.category.number {
        10 => (text(&cat010::I245), code(&cat010::I220)),
        20 => (text(&cat020::I245), code(&cat020::I220)),
        21 => (text(&cat021::I170), code(&cat021::I080)),
        48 => (text(&cat048::I240), code(&cat048::I220)),
        62 => {
            let name = inner_text(&cat062::I390, &cat062::I390_CS);
            let name = name.or_else(|| inner_text(&cat062::I380, &cat062::I380_ID));
            (name, inner_code(&cat062::I380, &cat062::I380_ADR))
        }
        _ => (None, None),
    };
    let name = name.map(|name| Callsign::new(&name)).filter(|name| !name.as_str().is_empty());
    let address = || address.map(|code| code as u32).filter(|code| *code != 0);
    name.map(Identity::Callsign).or_else(|| address().map(Identity::Address))
}
