//! Checks of the radar vectors, and of those tracking vectors that are about waves.

use crate::{CaseResult, Check, Judge};
use models::environment::fog::{self, FogLaw};
use models::environment::mie::MieRain;
use models::environment::rain::{self, RainLaw};
use models::environment::surface::{Complex, Fresnel, Material, Roughness, modulus};
use models::environment::{Weather, gas, wavelength_m};
use models::frames::Point2;
use models::sensors::asde::{AsdeParameters, DetectionRule, Energy};
use models::sensors::measurement::{angle_sigma, delay_sigma_s, energy_ratio, range_sigma_m};
use models::sensors::radar::antenna::Pattern;
use models::sensors::radar::detection::{
    Detector, Swerling, albersheim_db, from_db, marcum_q, shnidman_db, to_db,
};
use models::sensors::radar::effects::value::OwnKeys;
use models::sensors::radar::equation::{BudgetLevels, Echo, Polarisation, Reflection};
use models::sensors::radar::extended::centroid_of;
use models::sensors::radar::geometry::{RoundEarth, TwoPaths};
use models::sensors::radar::propagation;
use models::sensors::radar::shadow::{knife_edge_db, knife_edge_exact_db};
use models::sensors::radar::shape::Echo as ExtendedEcho;
use serde_json::Value;
use std::f64::consts::{LN_10, TAU};

/// The check for a file's stem.
#[must_use]
pub fn check_for(stem: &str) -> Option<Check> {
    Some(match stem {
        "rain_attenuation" => |d| each(d, rain_attenuation),
        "fog_attenuation" => |d| each(d, fog_attenuation),
        "gas_attenuation" => |d| each(d, gas_attenuation),
        "geometry_flat" => |d| each(d, geometry_flat),
        "geometry_spherical" => |d| each(d, geometry_spherical),
        "reflection" => |d| each(d, reflection),
        "reflection_film" => |d| each(d, reflection_film),
        "propagation_factor" => |d| each(d, propagation_factor),
        "antenna" => |d| each(d, antenna),
        "rain_beam_integral" => |d| each(d, rain_beam_integral),
        "rain_reflectivity" => |d| each(d, rain_reflectivity),
        "mie_rain" => |d| each(d, mie_rain),
        "detection_threshold" => |d| each(d, detection_threshold),
        "detection_pd" => |d| each(d, detection_pd),
        "required_snr" => |d| each(d, required_snr),
        "marcum_q" => |d| each(d, marcum),
        "measurement_errors" => |d| each(d, measurement_errors),
        "knife_edge" => |d| each(d, knife_edge),
        "extended_centroid" => |d| each(d, extended_centroid),
        "scenes" => |d| each(d, scene),
        "detection" => |d| each(d, single_pulse),
        "multipath" => |d| each(d, multipath),
        "fresnel" => |d| each(d, fresnel),
        "rain" => |d| each(d, rain_path),
        _ => return None,
    })
}

/// One case with what it needs of its file.
struct Case<'a> {
    input: &'a Value,
    expected: &'a Value,
    document: &'a Value,
    case: &'a Value,
}

impl Case<'_> {
    fn number(&self, key: &str) -> Option<f64> {
        self.input.get(key)?.as_f64()
    }

    /// A number where `null` stands for none.
    fn optional(&self, key: &str) -> Option<Option<f64>> {
        let value = self.input.get(key)?;
        if value.is_null() { Some(None) } else { value.as_f64().map(Some) }
    }

    fn text(&self, key: &str) -> Option<&str> {
        self.input.get(key)?.as_str()
    }

    fn pulses(&self, key: &str) -> Option<u32> {
        let n = self.input.get(key)?.as_u64()?;
        (1..=100_000).contains(&n).then_some(n as u32)
    }

    fn tolerance(&self, quantity: &str, expected: f64) -> f64 {
        let table = &self.document["tolerance"];
        let entry = table.get(quantity).or_else(|| table.get("*"));
        let part = |name| entry.and_then(|e| e.get(name)).and_then(Value::as_f64).unwrap_or(0.0);
        f64::max(part("abs"), part("rel") * expected.abs())
    }

    /// Compares one quantity, if the case expects it.
    fn compare(&self, judge: &mut Judge, quantity: &str, found: f64) {
        let Some(expected) = self.expected.get(quantity) else { return };
        match expected.as_f64() {
            Some(expected) => {
                judge.number(quantity, found, expected, self.tolerance(quantity, expected));
            }
            // `null` stands for the logarithm of zero.
            None if expected.is_null() => judge.holds(quantity, found == f64::NEG_INFINITY),
            None => judge.holds(quantity, false),
        }
    }

    /// Compares a complex number `{re, im}` by its modulus of difference.
    fn complex(&self, judge: &mut Judge, quantity: &str, re: f64, im: f64) {
        let Some(expected) = self.expected.get(quantity) else { return };
        let part = |name| expected.get(name).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let (e_re, e_im) = (part("re"), part("im"));
        let size = modulus(Complex::new(e_re, e_im));
        let error = modulus(Complex::new(re - e_re, im - e_im));
        judge.number(quantity, error, 0.0, self.tolerance(quantity, size));
    }

    /// The tolerance of a tracking case, relative.
    fn relative(&self, judge: &mut Judge, quantity: &str, found: f64) {
        let tol = self.case.get("tol").and_then(Value::as_f64).unwrap_or(f64::NAN);
        let Some(expected) = self.expected.get(quantity) else { return };
        let expected = expected.as_f64().unwrap_or(f64::NAN);
        judge.number(quantity, found, expected, tol * expected.abs());
    }
}

type Body = fn(&Case<'_>, &mut Judge) -> Option<()>;

/// Runs `body` over all cases; a case whose input is missing or malformed is refused, and so is one
/// that expects nothing.
fn each(document: &Value, body: Body) -> Vec<CaseResult> {
    let cases = document["cases"].as_array().map_or(&[][..], Vec::as_slice);
    let run = |(index, case): (usize, &Value)| {
        let mut judge = Judge::default();
        let view = Case { input: &case["input"], expected: &case["expected"], document, case };
        let expects = view.expected.as_object().is_some_and(|e| !e.is_empty());
        if !expects || body(&view, &mut judge).is_none() {
            judge.holds("input or expected values", false);
        }
        let name = case.get("name").and_then(Value::as_str);
        judge.case(name.map_or_else(|| format!("case {index}"), str::to_owned))
    };
    cases.iter().enumerate().map(run).collect()
}

fn rain_attenuation(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (el, tau) = (c.number("el")?.to_radians(), c.number("tau")?.to_radians());
    let law = RainLaw::new(c.number("f")?, el, tau);
    c.compare(judge, "k", law.k);
    c.compare(judge, "alpha", law.alpha);
    c.compare(judge, "gamma", law.specific_db_per_km(c.number("rain")?));
    Some(())
}

fn fog_attenuation(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (f, t, v) = (c.number("f")?, c.number("T")?, c.number("V")?);
    let water = fog::water_permittivity(f, t);
    c.compare(judge, "eps_re", water.re);
    c.compare(judge, "eps_im", water.im);
    c.compare(judge, "Kl", fog::coefficient(f, t));
    c.compare(judge, "lwc_A", FogLaw::TwoPoint.liquid_water(v));
    c.compare(judge, "lwc_B", FogLaw::Eldridge.liquid_water(v));
    c.compare(judge, "gamma", fog::specific_db_per_km(f, t, v, FogLaw::TwoPoint));
    Some(())
}

fn gas_attenuation(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (oxygen, water) =
        gas::specific_db_per_km(c.number("f")?, c.number("p")?, c.number("rho")?, c.number("T")?);
    c.compare(judge, "gamma_o", oxygen);
    c.compare(judge, "gamma_w", water);
    Some(())
}

fn geometry_flat(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let p = TwoPaths::flat(c.number("d")?, c.number("ha")?, c.number("ht")?);
    c.compare(judge, "R", p.direct_m);
    c.compare(judge, "Rr", p.reflected_m);
    c.compare(judge, "delta", p.difference_m);
    c.compare(judge, "psi", p.grazing_rad);
    c.compare(judge, "eps_d", p.depression_rad);
    c.compare(judge, "d1", p.reflection_point_m);
    Some(())
}

fn geometry_spherical(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let p = RoundEarth::new(c.number("d")?, c.number("ha")?, c.number("ht")?);
    c.compare(judge, "d1", p.reflection_point_m);
    c.compare(judge, "h1", p.antenna_m);
    c.compare(judge, "h2", p.target_m);
    c.compare(judge, "delta", p.difference_m);
    c.compare(judge, "psi", p.grazing_rad);
    c.compare(judge, "div", p.divergence);
    Some(())
}

fn reflection(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (f, psi) = (c.number("f")?, c.number("psi")?.to_radians());
    let permittivity = Material::named(c.text("material")?)?.permittivity(f);
    let fresnel = Fresnel::half_space(permittivity, psi);
    c.complex(judge, "eps", permittivity.re, permittivity.im);
    fresnel_parts(c, judge, &fresnel);
    let (sigma, lambda) = (c.number("sigma_h")?, wavelength_m(f));
    c.compare(judge, "ament", Roughness::Ament.factor(sigma, lambda, psi));
    c.compare(judge, "mbv", Roughness::MillerBrownVegh.factor(sigma, lambda, psi));
    Some(())
}

fn fresnel_parts(c: &Case<'_>, judge: &mut Judge, fresnel: &Fresnel) {
    for (quantity, value) in [
        ("GH", fresnel.horizontal),
        ("GV", fresnel.vertical),
        ("co", fresnel.circular_same()),
        ("cross", fresnel.circular_opposite()),
    ] {
        c.complex(judge, quantity, value.re, value.im);
    }
}

fn reflection_film(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (f, psi) = (c.number("f")?, c.number("psi")?.to_radians());
    let base = Material::named(c.text("base")?)?.permittivity(f);
    let water = fog::water_permittivity(f, c.number("T")?);
    let fresnel = Fresnel::film(water, base, c.number("t")?, wavelength_m(f), psi);
    fresnel_parts(c, judge, &fresnel);
    Some(())
}

fn propagation_factor(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (q, phi, spread) = (c.number("q")?, c.number("phi")?, c.number("dphi")?);
    c.compare(judge, "incoherent", propagation::incoherent(q));
    c.compare(judge, "coherent", propagation::coherent(q, phi));
    c.compare(judge, "extended", propagation::extended(q, phi, spread));
    Some(())
}

fn pattern(c: &Case<'_>) -> Option<Pattern> {
    Some(Pattern {
        azimuth_rad: 0.01,
        elevation_rad: c.number("theta_el")?.to_radians(),
        axis_rad: c.number("eps0")?.to_radians(),
        skirt_end_rad: c.optional("eps_max")?.map(f64::to_radians),
        floor: c.number("floor_db").map_or(0.0, from_db),
    })
}

fn antenna(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    c.compare(judge, "g", pattern(c)?.elevation(c.number("eps")?.to_radians()));
    Some(())
}

fn rain_beam_integral(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (range, antenna, top) = (c.number("R")?, c.number("ha")?, c.number("h_rain")?);
    c.compare(judge, "J", pattern(c)?.rain_integral(range, antenna, top));
    Some(())
}

fn rain_reflectivity(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let rain = c.number("rain")?;
    c.compare(judge, "eta", rain::reflectivity(c.number("f")?, rain));
    c.compare(judge, "icr_drop", rain::drop_rejection_db(rain));
    let fraction = rain::circular_fraction(c.number("axial_ratio")?, rain);
    c.compare(judge, "rejected_fraction", fraction);
    Some(())
}

fn mie_rain(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let mie = MieRain::new(c.number("f")?, c.number("rain")?);
    c.compare(judge, "eta", mie.reflectivity);
    c.compare(judge, "ext", mie.db_per_km);
    c.compare(judge, "icr_spheroid_db", mie.drop_rejection_db);
    Some(())
}

/// The detector of a case, if its parameters make sense.
fn detector(n: u32, pfa: f64) -> Option<Detector> {
    (pfa > 0.0 && pfa < 1.0).then(|| Detector::new(n, pfa))
}

fn detection_threshold(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    c.compare(judge, "T", detector(c.pulses("n")?, c.number("pfa")?)?.threshold);
    Some(())
}

fn detection_pd(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let detector = detector(c.pulses("n")?, c.number("pfa")?)?;
    let snr = from_db(c.number("snr_db")?);
    let case = Swerling::case(c.input.get("swerling")?.as_u64()?)?;
    c.compare(judge, "pd", detector.probability(snr, case));
    c.compare(judge, "sankaran", detector.sankaran(snr));
    c.compare(judge, "albersheim", detector.albersheim(snr));
    c.compare(judge, "north", detector.north(snr));
    Some(())
}

fn required_snr(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (n, pfa, pd) = (c.pulses("n")?, c.number("pfa")?, c.number("pd")?);
    let case = Swerling::case(c.input.get("swerling")?.as_u64()?)?;
    let exact = detector(n, pfa)?.required_snr(pd, case);
    c.compare(judge, "exact_db", to_db(exact));
    let albersheim = albersheim_db(pd, pfa, f64::from(n)).unwrap_or(f64::NAN);
    c.compare(judge, "albersheim_db", albersheim);
    c.compare(judge, "shnidman_db", shnidman_db(pd, pfa, n, case));
    Some(())
}

fn marcum(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (a, b) = (c.number("a")?, c.number("b")?);
    if !(0.0..=1e4).contains(&a) || !(0.0..=1e4).contains(&b) {
        return None;
    }
    let found = marcum_q(c.pulses("N")?, a, b);
    c.compare(judge, "Q", found.q);
    c.compare(judge, "P", found.p);
    c.compare(judge, "ln_Q", found.ln_q);
    c.compare(judge, "ln_P", found.ln_p);
    Some(())
}

fn measurement_errors(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let (tau, band) = (c.number("tau")?, c.number("B")?);
    let energy = energy_ratio(from_db(c.number("snr_db")?), band, tau);
    c.compare(judge, "en0_db", to_db(energy));
    c.compare(judge, "delta_T", delay_sigma_s(tau, band, energy));
    c.compare(judge, "sigma_R", range_sigma_m(tau, band, energy));
    c.compare(judge, "sigma_theta", angle_sigma(c.number("theta_B")?, energy));
    Some(())
}

fn knife_edge(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let v = c.number("v")?;
    c.compare(judge, "exact_db", knife_edge_exact_db(v));
    c.compare(judge, "approx_db", knife_edge_db(v));
    Some(())
}

fn extended_centroid(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let mut echoes = Vec::new();
    for scatterer in c.input.get("scatterers")?.as_array()? {
        let part = |name| scatterer.get(name).and_then(Value::as_f64);
        echoes.push(ExtendedEcho { along_m: part("x")?, across_m: part("y")?, rcs_m2: part("w")? });
    }
    let centroid = centroid_of(&echoes)?;
    c.compare(judge, "mean_x", centroid.bias_along_m);
    c.compare(judge, "mean_y", centroid.bias_across_m);
    c.compare(judge, "sigma_x", centroid.glint_along_m);
    c.compare(judge, "sigma_y", centroid.glint_across_m);
    c.compare(judge, "total", centroid.rcs_m2);
    Some(())
}

/// A parameter set of `parameter_sets.json` and a case of `scenes.json` as the product's parameters.
fn scene_parameters(set: &Value, c: &Case<'_>) -> Option<AsdeParameters> {
    let number = |key: &str| set.get(key).and_then(Value::as_f64);
    Some(AsdeParameters {
        carrier_ghz: number("f_ghz")?,
        peak_power_w: number("P_t_W")?,
        pulse_s: number("tau_s")?,
        bandwidth_hz: number("B_Hz")?,
        noise_figure_db: number("NF_dB")?,
        system_loss_db: number("L_sys_dB")?,
        azimuth_beamwidth_deg: number("theta_az_deg")?,
        elevation_beamwidth_deg: number("theta_el_deg")?,
        tilt_deg: number("eps0_deg")?,
        csc2_limit_deg: number("eps_max_deg"),
        gain_dbi: number("G_dBi")?,
        antenna_height_m: number("h_a_m")?,
        prf_hz: number("prf_hz")?,
        rotation_rpm: number("rpm")?,
        start_azimuth_deg: 0.0,
        polarisation: match c.text("pol")? {
            "CP" => Polarisation::Circular,
            "H" => Polarisation::Horizontal,
            "V" => Polarisation::Vertical,
            _ => return None,
        },
        axial_ratio_db: number("axial_ratio_db")?,
        circular_target_loss_db: c.number("L_cp_db")?,
        sidelobe_floor_db: number("sidelobe_floor_db")?,
        recovery_s: 100e-9,
        range_min_m: 100.0,
        range_max_m: 5500.0,
        pfa: 1e-6,
        pd: 0.9,
        detection: DetectionRule::Bernoulli,
        swerling: Swerling::Steady,
        energy: Energy::SinglePulse,
        range_step_m: 0.0,
        azimuth_step_deg: 0.0,
        assumed_height_m: 0.0,
        frequency_agile: true,
        rain_spread_mps: 1.5,
        glint_sigma_m: 0.0,
        reflection_coupling: 0.0,
        ground_gamma_db: c.number("gamma_db")?,
        surface: Material::named(c.text("surface")?)?,
        roughness_m: c.number("sigma_h")?,
        rain_top_m: c.number("h_rain")?,
        fog_law: FogLaw::TwoPoint,
        own: OwnKeys::new(),
    })
}

fn scene(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let set = c.document.get("parameter_sets")?.get(c.text("set")?)?;
    let parameters = scene_parameters(set, c)?;
    parameters.validate().ok()?;
    let radar = parameters.radar();
    let weather = Weather {
        rain_mm_per_h: c.number("rain")?,
        visibility_m: c.optional("V")?.unwrap_or(f64::INFINITY),
        temperature_k: c.number("T")?,
        vapour_g_per_m3: c.number("rho")?,
        ..Weather::default()
    };
    let reflection = match c.text("multipath")? {
        "none" => Reflection::None,
        "incoherent" => Reflection::Incoherent,
        "coherent" => Reflection::Coherent,
        _ => return None,
    };
    let levels = BudgetLevels { reflection, ..BudgetLevels::MIDDLE };
    let ground_m = c.number("d")?;
    let echo =
        Echo { ground_m, height_m: c.number("ht")?, extent_m: 0.0, rcs_m2: c.number("rcs")? };
    let target_m = Point2::new(0.0, ground_m);
    let (air, site_m) = (radar.air(&weather), Point2::origin());
    let budget = radar.budget(&air, &levels, &echo, site_m, target_m);
    for (quantity, found) in [
        ("R", budget.range_m),
        ("gamma_total", budget.db_per_km),
        ("F4", budget.propagation),
        ("S", budget.signal_w),
        ("N", budget.noise_w),
        ("sigma_rain", budget.rain_m2),
        ("sigma_ground", budget.ground_m2),
        ("Cr", budget.rain_w),
        ("Cg", budget.ground_w),
        ("snr_db", to_db(budget.snr())),
        ("scnr_db", to_db(budget.scnr())),
    ] {
        c.compare(judge, quantity, found);
    }
    Some(())
}

fn single_pulse(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let detector = detector(1, c.number("pfa")?)?;
    let snr = from_db(c.number("snr_db")?);
    c.relative(judge, "pd_sw0", detector.probability(snr, Swerling::Steady));
    c.relative(judge, "pd_sw1", detector.probability(snr, Swerling::One));
    c.relative(judge, "pd_sw3", detector.probability(snr, Swerling::Three));
    c.relative(judge, "miss_sw1", detector.miss(snr, Swerling::One));
    if let Some(expected) = c.expected.get("log10_miss_sw0") {
        let expected = expected.as_f64()?;
        let found = detector.ln_miss(snr, Swerling::Steady) / LN_10;
        // 1e-9 of the logarithm, as the file states.
        judge.number("log10_miss_sw0", found, expected, 1e-9 * expected.abs());
    }
    Some(())
}

fn multipath(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let lambda = wavelength_m(c.number("freq_hz")? / 1e9);
    let paths = TwoPaths::flat(
        c.number("ground_range_m")?,
        c.number("h_radar_m")?,
        c.number("h_target_m")?,
    );
    let phase = propagation::path_phase_rad(paths.difference_m, lambda);
    c.relative(judge, "path_difference_m", paths.difference_m);
    if let Some(expected) = c.expected.get("phase_rad") {
        // The product keeps the phase within one turn.
        let expected = expected.as_f64()?;
        let turns = ((expected - phase) / TAU).round();
        c.relative(judge, "phase_rad", phase + turns * TAU);
    }
    c.relative(judge, "F2_one_way", propagation::one_way_real(c.number("rho")?, phase));
    Some(())
}

fn fresnel(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let permittivity = Complex::new(c.number("eps_re")?, c.number("eps_im")?);
    let found = Fresnel::half_space(permittivity, c.number("grazing_rad")?);
    let tol = c.case.get("tol").and_then(Value::as_f64)?;
    for (quantity, value) in [
        ("rho_v", found.vertical),
        ("rho_h", found.horizontal),
        ("one_plus_rho_v", found.one_plus_vertical),
        ("one_plus_rho_h", found.one_plus_horizontal),
    ] {
        let expected = c.expected.get(quantity)?.as_array()?;
        let (re, im) = (expected.first()?.as_f64()?, expected.get(1)?.as_f64()?);
        let error = modulus(value - Complex::new(re, im));
        judge.number(quantity, error, 0.0, tol * modulus(Complex::new(re, im)));
    }
    Some(())
}

fn rain_path(c: &Case<'_>, judge: &mut Judge) -> Option<()> {
    let law = RainLaw { k: c.number("k")?, alpha: c.number("alpha")? };
    let loss = law.two_way_db(c.number("rain_mm_h")?, c.number("path_km")?);
    let out_db = c.number("snr_db")? - loss;
    c.relative(judge, "two_way_db", loss);
    c.relative(judge, "snr_out_db", out_db);
    c.relative(judge, "ln_snr_out", models::sensors::radar::detection::ln_ratio(out_db));
    Some(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    /// Files of this module with the cases that the repository's copies have.
    const FILES: [(&str, usize); 24] = [
        ("radar/antenna", 22),
        ("radar/detection_pd", 105),
        ("radar/detection_threshold", 15),
        ("radar/extended_centroid", 3),
        ("radar/fog_attenuation", 36),
        ("radar/gas_attenuation", 15),
        ("radar/geometry_flat", 9),
        ("radar/geometry_spherical", 5),
        ("radar/knife_edge", 8),
        ("radar/marcum_q", 11),
        ("radar/measurement_errors", 8),
        ("radar/mie_rain", 8),
        ("radar/propagation_factor", 80),
        ("radar/rain_attenuation", 120),
        ("radar/rain_beam_integral", 12),
        ("radar/rain_reflectivity", 20),
        ("radar/reflection", 126),
        ("radar/reflection_film", 24),
        ("radar/required_snr", 45),
        ("radar/scenes", 180),
        ("tracking/detection", 9),
        ("tracking/multipath", 7),
        ("tracking/fresnel", 6),
        ("tracking/rain", 4),
    ];

    #[test]
    fn every_radar_vector_passes() {
        crate::assert_all_pass(&FILES);
    }

    #[test]
    fn damaged_vectors_are_refused_and_do_not_panic() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/vectors");
        for (file, _) in FILES {
            let stem = file.rsplit('/').next().expect(file);
            let check = super::check_for(stem).expect(file);
            let text = std::fs::read_to_string(root.join(format!("{file}.json"))).expect(file);
            let mut document: serde_json::Value = serde_json::from_str(&text).expect(file);
            document["cases"][0]["input"] = serde_json::json!({});
            document["cases"][1]["expected"] = serde_json::json!({});
            let results = check(&document);
            assert!(results[0].worst.is_infinite() && results[1].worst.is_infinite(), "{file}");
        }
    }
}
