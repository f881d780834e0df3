use super::*;

/// A light aircraft that comes down near the threshold is below fifteen metres, and off the strip, before it: a take-off from a taxiway
/// was told of (Hoxton Park, twice an hour).
#[test]
fn a_light_aircraft_low_before_the_runway_takes_off_from_no_taxiway() {
    let told = |at: fn(f64) -> (f64, f64), (vx, vy): (f64, f64)| {
        let found = raised(Parameters::on_tracks(), 14, |s| {
            let light = target(6, "ABC1", at(f64::from(s)), (vx, vy), s);
            vec![Target { altitude_m: Some(9.0), length_m: 8.3, ..light }]
        });
        found.iter().filter(|r| r.1 == "HIGH_SPEED").count()
    };
    // To either end, as far beside the line as a roll may be.
    assert_eq!(told(|s| (0.0, -320.0 + 29.0 * s), (0.0, 29.0)), 0);
    assert_eq!(told(|s| (20.0, 3320.0 - 29.0 * s), (1.0, -29.0)), 0);
    // Farther out, beside it, across it or away from it nobody lands.
    assert_eq!(told(|s| (0.0, -900.0 + 29.0 * s), (0.0, 29.0)), 1, "far out");
    assert_eq!(told(|s| (90.0, -320.0 + 29.0 * s), (0.0, 29.0)), 1, "beside");
    assert_eq!(told(|s| (-200.0 + 29.0 * s, -200.0), (29.0, 0.0)), 1, "across");
    assert_eq!(told(|s| (0.0, -80.0 - 29.0 * s), (0.0, -29.0)), 1, "away");
}
