//! Plots of a sensor between the SMDFM that has it and the one that fuses: as notices, to the bit.

use super::report::plan_line;
use crate::runtime::messages::{CausedPlot, PlotsNotice};
use models::frames::Vector2;
use models::plot::{Callsign, Identity, Plot, Polar, SensorId, SensorKind};
use models::sensors::{Cause, Contribution, PlotSink, Sensor};
use models::time::SimTime;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

/// Plots of one notice: with what some thirty effects did to each, half of a report.
const CHUNK: usize = 64;

/// What a sensor saw in a scan; `plan` where its plan is another one. Nothing where there is nothing to say.
pub fn notices(
    sensor: SensorId,
    sink: &PlotSink,
    mut plan: Option<Vec<[String; 5]>>,
) -> impl Iterator<Item = PlotsNotice> {
    let mut looks = sink.looks;
    let plots: Vec<CausedPlot> =
        sink.plots.iter().zip(&sink.causes).map(|(plot, cause)| told(plot, cause)).collect();
    let says = looks > 0 || plan.is_some();
    let mut chunks: Vec<Vec<CausedPlot>> = plots.chunks(CHUNK).map(<[_]>::to_vec).collect();
    if chunks.is_empty() && says {
        chunks.push(Vec::new());
    }
    chunks.into_iter().map(move |plots| PlotsNotice {
        sensor: sensor.0,
        looks: std::mem::take(&mut looks),
        plan: plan.take(),
        plots,
    })
}

fn told(plot: &Plot, cause: &Cause) -> CausedPlot {
    let (callsign, address) = match plot.identity {
        Some(Identity::Callsign(callsign)) => (Some(callsign.as_str().to_owned()), None),
        Some(Identity::Address(address)) => (None, Some(address)),
        None => (None, None),
    };
    let effect = |c: &Contribution| (c.effect.to_owned(), c.value, c.unit.to_owned());
    CausedPlot {
        time_ns: plot.time.0,
        sequence: plot.sequence,
        position_m: plot.position_m,
        axis: plot.axis.into(),
        variances_m2: [plot.along_m2, plot.across_m2],
        altitude_m: plot.altitude_m,
        polar: plot.polar.map(|p| [p.range_m, p.azimuth_rad, p.sigma_range_m, p.sigma_azimuth_rad]),
        extent_m2: plot.polar.and_then(|p| p.extent_m2),
        callsign,
        address,
        scnr_db: plot.scnr_db,
        key: cause.key,
        truth_m: cause.truth_m,
        effects: cause.effects.iter().map(effect).collect(),
    }
}

/// Names and units of effects that are known at most: a build has some dozens.
const WORDS: usize = 512;

/// The same name for as long as the process lives: each is kept once.
fn word(text: &str) -> &'static str {
    static WORDS_KEPT: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut kept = WORDS_KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(word) = kept.get(text) {
        return word;
    }
    if kept.len() >= WORDS {
        return "another effect";
    }
    let word: &'static str = Box::leak(text.into());
    kept.insert(word);
    word
}

fn heard(sensor: SensorId, kind: SensorKind, told: CausedPlot) -> (Plot, Cause) {
    let callsign = told.callsign.map(|text| Identity::Callsign(Callsign::new(&text)));
    let polar = told.polar.map(|[range_m, azimuth_rad, sigma_range_m, sigma_azimuth_rad]| Polar {
        range_m,
        azimuth_rad,
        sigma_range_m,
        sigma_azimuth_rad,
        extent_m2: told.extent_m2,
    });
    let effect = |(effect, value, unit): (String, f64, String)| Contribution {
        effect: word(&effect),
        value,
        unit: word(&unit),
    };
    let plot = Plot {
        sensor,
        kind,
        time: SimTime(told.time_ns),
        sequence: told.sequence,
        position_m: told.position_m,
        axis: Vector2::from(told.axis),
        along_m2: told.variances_m2[0],
        across_m2: told.variances_m2[1],
        altitude_m: told.altitude_m,
        polar,
        identity: callsign.or(told.address.map(Identity::Address)),
        scnr_db: told.scnr_db,
    };
    let cause = Cause {
        key: told.key,
        truth_m: told.truth_m,
        effects: told.effects.into_iter().map(effect).collect(),
    };
    (plot, cause)
}

/// What other SMDFMs told of their sensors and no scan has had.
#[derive(Clone, Debug, Default)]
pub struct Remote {
    seen: BTreeMap<SensorId, (u64, Vec<CausedPlot>)>,
    plans: BTreeMap<SensorId, Vec<[String; 5]>>,
}

impl Remote {
    /// Takes in what one of them saw.
    pub fn take(&mut self, told: &PlotsNotice) {
        let sensor = SensorId(told.sensor);
        if let Some(plan) = &told.plan {
            self.plans.insert(sensor, plan.clone());
        }
        let (looks, plots) = self.seen.entry(sensor).or_default();
        *looks += told.looks;
        plots.extend_from_slice(&told.plots);
    }

    /// Adds what this sensor saw.
    pub fn scan(&mut self, sensor: SensorId, kind: SensorKind, sink: &mut PlotSink) {
        let Some((looks, plots)) = self.seen.remove(&sensor) else { return };
        sink.looks += looks;
        for told in plots {
            let (plot, cause) = heard(sensor, kind, told);
            sink.plots.push(plot);
            sink.causes.push(cause);
        }
    }

    /// The lines of the plan of a sensor, here or elsewhere.
    #[must_use]
    pub fn plan_of(&self, sensor: &dyn Sensor) -> Vec<[String; 5]> {
        let elsewhere = self.plans.get(&sensor.id()).cloned();
        elsewhere.unwrap_or_else(|| sensor.plan().iter().map(plan_line).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::frames::Point2;
    use proptest::prelude::*;

    fn bits(plot: &Plot) -> String {
        let f = |v: f64| format!("{:016x}", v.to_bits());
        let numbers = [plot.position_m.x, plot.position_m.y, plot.axis.x, plot.axis.y];
        let polar = plot.polar.map(|p| {
            let four = [p.range_m, p.azimuth_rad, p.sigma_range_m, p.sigma_azimuth_rad].map(f);
            (four, p.extent_m2.map(|e| e.map(f)))
        });
        format!(
            "{:?} {:?} {:?} {} {:?} {} {} {:?} {polar:?} {:?} {:?}",
            plot.sensor,
            plot.kind.word,
            plot.time,
            plot.sequence,
            numbers.map(f),
            f(plot.along_m2),
            f(plot.across_m2),
            plot.altitude_m.map(f),
            plot.identity,
            plot.scnr_db.map(f),
        )
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![any::<f64>(), Just(f64::NAN), Just(f64::INFINITY), Just(-0.0)]
    }

    proptest! {
        /// Every bit of a plot and of its cause passes, its order too, in however many notices.
        #[test]
        fn plots_arrive_as_they_were(
            numbers in proptest::array::uniform9(number()),
            some in proptest::array::uniform6(any::<bool>()),
            count in 0usize..700,
            looks in 0u64..5,
        ) {
            let identity = match (some[0], some[1]) {
                (true, _) => Some(Identity::Callsign(Callsign::new("DLH4AB"))),
                (_, true) => Some(Identity::Address(0xA1_B2_C3)),
                _ => None,
            };
            let polar = Polar {
                range_m: numbers[0],
                azimuth_rad: numbers[1],
                sigma_range_m: numbers[2],
                sigma_azimuth_rad: numbers[3],
                extent_m2: some[2].then_some([numbers[4], numbers[5], numbers[6]]),
            };
            let plot = Plot {
                sensor: SensorId(3),
                kind: SensorKind::Asde,
                time: SimTime(-7),
                sequence: 0,
                position_m: Point2::new(numbers[7], numbers[8]),
                axis: Vector2::new(numbers[2], numbers[1]),
                along_m2: numbers[3],
                across_m2: numbers[4],
                altitude_m: some[3].then_some(numbers[5]),
                polar: some[4].then_some(polar),
                identity,
                scnr_db: some[5].then_some(numbers[6]),
            };
            let cause = Cause {
                key: some[0].then_some(u64::MAX - 1),
                truth_m: some[1].then(|| Point2::new(1.5, numbers[0])),
                effects: vec![Contribution { effect: "rain", value: 2.5, unit: "dB" }],
            };
            let mut sink = PlotSink { looks, ..PlotSink::default() };
            for sequence in 0..count {
                sink.plots.push(Plot { sequence: sequence as u32, ..plot });
                sink.causes.push(cause.clone());
            }
            let mut remote = Remote::default();
            for told in notices(SensorId(3), &sink, None) {
                assert!(told.plots.len() <= CHUNK);
                remote.take(&told);
            }
            let mut got = PlotSink::default();
            remote.scan(SensorId(4), SensorKind::Asde, &mut got);
            prop_assert!(got.plots.is_empty(), "those of another sensor");
            remote.scan(SensorId(3), SensorKind::Asde, &mut got);
            prop_assert_eq!(got.looks, looks);
            let all = |sink: &PlotSink| sink.plots.iter().map(bits).collect::<Vec<_>>();
            prop_assert_eq!(all(&got), all(&sink));
            prop_assert_eq!(format!("{:?}", got.causes), format!("{:?}", sink.causes));
            remote.scan(SensorId(3), SensorKind::Asde, &mut got);
            prop_assert_eq!(got.plots.len(), count, "twice");
        }
    }
}
