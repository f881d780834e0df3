//! Sensor kinds as messages, the log and the page write them.

use models::plot::SensorKind;

/// Word of a sensor kind, as scenes and messages write it.
#[must_use]
pub fn kind_word(kind: SensorKind) -> &'static str {
    match kind {
        SensorKind::Asde => "asde",
        SensorKind::Gps => "gps",
        SensorKind::Dgps => "dgps",
        SensorKind::Adsb => "adsb",
        SensorKind::Mlat => "mlat",
        SensorKind::Loop => "loop",
        SensorKind::Dynamic => "dynamic",
    }
}

/// The sensor kind of a word; none for words of later versions.
#[must_use]
pub fn kind_of(word: &str) -> Option<SensorKind> {
    use SensorKind::{Adsb, Asde, Dgps, Dynamic, Gps, Loop, Mlat};
    [Asde, Gps, Dgps, Adsb, Mlat, Loop, Dynamic].into_iter().find(|kind| kind_word(*kind) == word)
}
