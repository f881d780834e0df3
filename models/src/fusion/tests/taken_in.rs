//! What the tracker takes in: plots in their order, cut into looks, and numbers of sensors within their limits.

use super::hard_cases::plot;
use super::*;
use config::SensorModel;

fn sensor(id: u16, interval_s: f64) -> SensorModel {
    SensorModel { interval_s, ..SensorModel::default_of(SensorId(id), SensorKind::Asde) }
}

/// Sensor by sensor in the order of time and sequence, each of a sensor's intervals since the last scan by itself; what is late,
/// not yet, unsound or said twice is left out, and told.
#[test]
fn what_comes_in_is_cut_into_looks() {
    let intervals_s = [0.13, 0.5, 1.0, 4.0];
    for round in 0..30 {
        let mut config = TrackingConfig::paper();
        config.sensors = (1..).zip(intervals_s).map(|(id, s)| sensor(id, s)).collect();
        config.sensors[1].extra_sigma_m = 1.5;
        config.sensors[2].latency_s = 0.2;
        let (last_s, now_s) = (10.0, 10.0 + [0.3, 1.0, 2.7, 3.0][round % 4]);
        let mut tracker = Tracker::new(config);
        let key = DrawKey { run_seed: 8, sensor: 1, entity: round as u64, scan: 0 };
        let mut rng = key.rng(Purpose::Study);
        let draw = |rng: &mut rand::rngs::ChaCha8Rng, from: f64, to: f64| {
            from + (to - from) * uniform(rng)
        };
        // Said in the scan before: late ones of these are not taken again.
        let old: Vec<Plot> =
            (0..20).map(|n| plot(9.0 + 0.05 * f64::from(n), n, 1e5, 50.0 * f64::from(n))).collect();
        tracker.scan(SimTime::from_s(last_s), &old, &FlightList::default());
        let mut plots: Vec<Plot> = old[..5].to_vec();
        for n in 0..(20 + 10 * round as u32) {
            let mut made =
                plot(draw(&mut rng, 7.5, now_s + 0.2), 100 + n % 7, 300.0 * f64::from(n), 0.0);
            made.sensor = SensorId(1 + (uniform(&mut rng) * 4.0) as u16);
            // Some at the same instant, some on borders of intervals.
            if n % 5 == 0 {
                made.time = SimTime::from_s((made.time.s() * 2.0).round() / 2.0);
                made.sequence = 1000 + n;
            }
            match n % 11 {
                3 => made.position_m.x = f64::NAN,
                4 => plots.push(made),
                _ => (),
            }
            plots.push(made);
        }
        let now = SimTime::from_s(now_s);
        let oldest = SimTime(now.0 - 5_000_000_000);
        let start = SimTime::from_s(last_s);
        let mut wanted: Vec<(Plot, usize)> = Vec::new();
        let mut told = vec![None; plots.len()];
        for (index, p) in plots.iter().enumerate() {
            told[index] = match () {
                () if p.position_m.x.is_nan() || p.time > now => Some(Outcome::Unsound),
                () if p.time < oldest => Some(Outcome::TooLate),
                () => None,
            };
            if told[index].is_none() {
                wanted.push((*p, index));
            }
        }
        let name = |p: &Plot| (p.sensor, p.time, p.sequence);
        wanted.sort_by_key(|(p, index)| (name(p), *index));
        let mut kept: Vec<(Plot, usize)> = Vec::new();
        for (p, index) in wanted {
            let again = kept.iter().any(|(k, _)| name(k) == name(&p));
            if again || old.iter().any(|o| name(o) == name(&p)) {
                told[index] = Some(Outcome::Duplicate);
            } else {
                kept.push((p, index));
            }
        }
        let before = *tracker.statistics();
        tracker.begin(now);
        let mut work = std::mem::take(&mut tracker.work);
        tracker.take_in(now, &plots, &mut work);
        for (index, told) in told.iter().enumerate() {
            let found = &tracker.outcomes()[index];
            let same = match told {
                Some(told) => std::mem::discriminant(told) == std::mem::discriminant(found),
                None => matches!(found, Outcome::Unused),
            };
            assert!(same, "{round}: {found:?} of {:?}", plots[index]);
        }
        let count =
            |of: fn(&Outcome) -> bool| tracker.outcomes().iter().filter(|o| of(o)).count() as u64;
        let after = tracker.statistics();
        assert_eq!(after.plots - before.plots, plots.len() as u64);
        assert_eq!(after.unsound - before.unsound, count(|o| matches!(o, Outcome::Unsound)));
        assert_eq!(after.too_late - before.too_late, count(|o| matches!(o, Outcome::TooLate)));
        assert_eq!(
            after.duplicates - before.duplicates,
            count(|o| matches!(o, Outcome::Duplicate))
        );
        let found: Vec<usize> = work.candidates.iter().map(|c| c.index).collect();
        assert_eq!(found, kept.iter().map(|k| k.1).collect::<Vec<_>>(), "{round}");
        // Looks: one sensor, one interval, counted from the nanosecond after the last scan.
        let look = |p: &Plot| {
            let interval_s = intervals_s[usize::from(p.sensor.0) - 1].max((now_s - last_s) / 64.0);
            let since = p.time.0 - start.0 - 1;
            (p.sensor, since.div_euclid(SimTime::from_s(interval_s).0))
        };
        let mut seen = vec![false; kept.len()];
        let mut last = (SimTime(i64::MIN), SensorId(0));
        for batch in &work.batches {
            let here = &kept[batch.from..batch.to];
            assert!(here.iter().all(|(p, _)| look(p) == look(&here[0].0)), "{round}: {batch:?}");
            for (at, slot) in (0..).zip(&mut seen) {
                let inside = (batch.from..batch.to).contains(&at);
                let mine = look(&kept[at].0) == look(&here[0].0);
                assert_eq!(inside, mine, "{round}: {batch:?} {at}");
                *slot |= inside;
            }
            let first = &work.candidates[batch.from].plot;
            let order = (first.time, first.sensor);
            assert!(order >= last, "{round}: {order:?} after {last:?}");
            last = order;
        }
        assert!(seen.iter().all(|s| *s));
        for (candidate, (said, _)) in work.candidates.iter().zip(&kept) {
            let (more_m2, late_s) = match said.sensor.0 {
                2 => (2.25, 0.0),
                3 => (0.0, 0.2),
                _ => (0.0, 0.0),
            };
            let own = SensorModel::default_of(said.sensor, said.kind).extra_sigma_m;
            let more_m2 = if said.sensor.0 == 2 { more_m2 } else { own * own };
            assert!((candidate.plot.along_m2 - said.along_m2 - more_m2).abs() < 1e-9);
            assert!((candidate.plot.across_m2 - said.across_m2 - more_m2).abs() < 1e-9);
            assert_eq!(candidate.plot.time.0, said.time.0 - SimTime::from_s(late_s).0);
        }
    }
}

/// Each number of a sensor is taken up to its limits; beyond, it is refused by its name, and the default stands in its place.
#[test]
fn numbers_of_a_sensor_are_taken_within_their_limits() {
    type Slot = fn(&mut SensorModel) -> &mut f64;
    let all: [(&str, f64, f64, Slot); 8] = [
        ("interval_s", 1e-3, 1e6, |m| &mut m.interval_s),
        ("detection", 0.0, 1.0, |m| &mut m.detection),
        ("false_density_m2", 0.0, 1e3, |m| &mut m.false_density_m2),
        ("extra_sigma_m", 0.0, 1e4, |m| &mut m.extra_sigma_m),
        ("slow_share", 0.0, 1.0, |m| &mut m.slow_share),
        ("slow_tau_s", 1e-6, 1e9, |m| &mut m.slow_tau_s),
        ("latency_s", 0.0, 60.0, |m| &mut m.latency_s),
        ("late_sigma_s", 0.0, 60.0, |m| &mut m.late_sigma_s),
    ];
    for (name, low, high, slot) in all {
        let cases = [low, high, low - 1e-7, high * 1.001, f64::NAN, f64::NEG_INFINITY];
        for (value, taken) in cases.into_iter().zip([true, true, false, false, false, false]) {
            let mut model = sensor(7, 1.0);
            *slot(&mut model) = value;
            let said =
                TrackingConfig { sensors: vec![sensor(3, 1.0), model], ..TrackingConfig::paper() }
                    .check();
            let named = said.map_err(|e| (e.name, e.low, e.high));
            let wanted = if taken { Ok(()) } else { Err((format!("sensor 7: {name}"), low, high)) };
            assert_eq!(named, wanted, "{name} = {value}");
            let mut spare = SensorModel::default_of(SensorId(7), SensorKind::Asde);
            let wanted = if taken { value } else { *slot(&mut spare) };
            assert_eq!(*slot(&mut model.sound()), wanted, "{name} = {value}");
        }
    }
}
