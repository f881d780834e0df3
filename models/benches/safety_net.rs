//! The safety net on 1 000 tracks and three runways: half taxi, the others stand, ten are on final, twenty in strips.
//! Goal: 50 µs a scan.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use models::control::clearance::{Board, Clearance, ClearanceKind};
use models::control::layout::{Layout, RunwayAxis, StopBar};
use models::control::parameters::Parameters;
use models::control::safety_net::{SafetyNet, Scan};
use models::control::situation::{Target, TargetClass};
use models::frames::Vector2;
use models::plot::Callsign;
use models::time::SimTime;

#[path = "common/cpu_time.rs"]
mod cpu_time;

use cpu_time::CpuTime;

fn layout() -> Layout {
    let axis = |a: [f64; 2], b: [f64; 2], names: [&str; 2]| {
        let ends = [Vector2::new(a[0], a[1]), Vector2::new(b[0], b[1])];
        RunwayAxis::new(names.map(String::from), ends, 45.0, 90.0)
    };
    let runways = [
        axis([0.0, 0.0], [3000.0, 0.0], ["09R", "27L"]),
        axis([0.0, 1800.0], [3500.0, 1800.0], ["09L", "27R"]),
        axis([2500.0, -800.0], [3900.0, 2300.0], ["02", "20"]),
    ];
    Layout::new(runways.into_iter().flatten().collect())
}

fn target(n: u16, second: u32) -> Target {
    let (t, i) = (f64::from(second), f64::from(n));
    let (position, velocity) = match n {
        // On final, 15 s apart beyond the alerts.
        0..10 => ((-2500.0 - 1100.0 * i + 70.0 * (t % 30.0), 2.0), (70.0, 0.0)),
        // Lined up or crossing, cleared.
        10..30 => ((60.0 + 140.0 * (i - 10.0), 1800.0), (0.0, 0.0)),
        30..550 => {
            let along = (i * 37.0 + 10.0 * t) % 3000.0;
            ((along, 200.0 + 30.0 * f64::from(n % 40)), (10.0, 0.0))
        }
        _ => ((f64::from(n % 70) * 45.0, 500.0 + 60.0 * f64::from(n % 9)), (0.05, -0.02)),
    };
    Target {
        number: n,
        callsign: Some(Callsign::new(&format!("X{n}"))),
        class: if n % 10 == 9 { TargetClass::Vehicle } else { TargetClass::Aircraft },
        arriving: n.is_multiple_of(2),
        length_m: 38.0,
        position_m: Vector2::new(position.0, position.1),
        velocity_mps: Vector2::new(velocity.0, velocity.1),
        altitude_m: None,
        last_plot: SimTime::from_s(t),
        first: false,
    }
}

/// Every `nameless`-th track without a name (0: none).
fn bench_with(
    c: &mut Criterion<CpuTime>,
    name: &str,
    parameters: Parameters,
    nameless: u16,
    with_bars: bool,
) {
    let mut net = SafetyNet::new(layout(), parameters);
    let mut board = Board::default();
    for n in 0..1000 {
        let (kind, runway) = match n {
            0..10 => (ClearanceKind::Land, Some((0, Some(0)))),
            10..30 => (ClearanceKind::Cross, Some((1, None))),
            30..550 => (ClearanceKind::Taxi, None),
            _ => (ClearanceKind::Push, None),
        };
        let callsign = Callsign::new(&format!("X{n}"));
        let from = SimTime::ZERO;
        board.give(Clearance { callsign, kind, runway, place_m: None, from, until: None });
        if let Some(strip) = board.strip(callsign).filter(|_| (30..550).contains(&n)) {
            let y = 200.0 + 30.0 * f64::from(n % 40);
            strip.way_m = (0..100).map(|k| Vector2::new(30.0 * f64::from(k), y)).collect();
        }
    }
    let one = |n: u16, s: u32| {
        let named = nameless == 0 || !n.is_multiple_of(nameless);
        let target = target(n, s);
        Target { callsign: target.callsign.filter(|_| named), ..target }
    };
    // A lit bar every 100 m on both sides of each runway.
    let bar = |n: u32| StopBar {
        runway: n as usize % 3,
        place_m: 100.0 * f64::from(n / 6),
        across_m: Some(if n.is_multiple_of(2) { 90.0 } else { -90.0 }),
        entry_m: 100.0 * f64::from(n / 6),
        lit: true,
    };
    let bars: Vec<StopBar> = (0..if with_bars { 180 } else { 0 }).map(bar).collect();
    let second = std::cell::Cell::new(0);
    c.bench_function(name, |b| {
        let tracks = || {
            second.set(second.get() + 1);
            (0..1000).map(|n| one(n, second.get())).collect::<Vec<Target>>()
        };
        let judge = |targets: Vec<Target>| {
            let now = SimTime::from_s(f64::from(second.get()));
            board.advance(now);
            let (targets, board) = (&targets[..], &board);
            let scan = Scan { now, targets, board, bars: &bars, areas: &[], low_visibility: false };
            let raised = net.scan(&scan).len();
            // Tracks that coast are left out: these are of now.
            assert_eq!(net.surveillance().situations().len(), 1000, "every track is looked at");
            raised
        };
        b.iter_batched(tracks, judge, BatchSize::PerIteration);
    });
}

fn bench(c: &mut Criterion<CpuTime>) {
    bench_with(c, "alerts of 1000 tracks, 3 runways", Parameters::default(), 0, false);
    bench_with(c, "the same as tracks", Parameters::on_tracks(), 0, false);
    bench_with(c, "the same, every second without a name", Parameters::on_tracks(), 2, false);
    bench_with(c, "the same as tracks, 180 lit bars", Parameters::on_tracks(), 0, true);
}

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = bench
}
criterion_main!(benches);
