//! The safety net on tracks at three runways, and at six: half taxi, the others stand, one in a hundred is on final, two are in strips.
//! Goal: 50 µs a scan of 1 000 tracks and three runways.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use models::control::clearance::{Board, Clearance, ClearanceKind};
use models::control::layout::{Layout, RunwayAxis, StopBar};
use models::control::parameters::Parameters;
use models::control::safety_net::{SafetyNet, Scan};
use models::control::situation::{Target, TargetClass};
use models::frames::{Point2, Vector2};
use models::plot::Callsign;
use models::time::SimTime;

#[path = "common/cpu_time.rs"]
mod cpu_time;

use cpu_time::CpuTime;

/// What is watched, and how.
#[derive(Clone, Copy)]
struct Case {
    tracks: u16,
    runways: usize,
    parameters: Parameters,
    /// Every so-many-th track has no name (0: none),
    nameless: u16,
    /// has had no plot for five seconds.
    coasting: u16,
    bars: bool,
    /// Flights have stands.
    stands: bool,
}

fn layout(runways: usize) -> Layout {
    let axis = |a: [f64; 2], b: [f64; 2], names: [&str; 2]| {
        let ends = [Point2::new(a[0], a[1]), Point2::new(b[0], b[1])];
        RunwayAxis::new(names.map(String::from), ends, 45.0, 90.0)
    };
    let all = [
        axis([0.0, 0.0], [3000.0, 0.0], ["09R", "27L"]),
        axis([0.0, 1800.0], [3500.0, 1800.0], ["09L", "27R"]),
        axis([2500.0, -800.0], [3900.0, 2300.0], ["02", "20"]),
        axis([-400.0, -1500.0], [3000.0, -1700.0], ["10R", "28L"]),
        axis([0.0, 3900.0], [3800.0, 3900.0], ["10L", "28R"]),
        axis([-900.0, 3500.0], [-1100.0, 100.0], ["18", "36"]),
    ];
    Layout::new(all.into_iter().take(runways).flatten().collect())
}

/// What a track is: of a hundred one is on final, two are in strips, 52 taxi. Of more than a thousand, as every thousand.
fn part(case: &Case, n: u16) -> (u16, f64) {
    (n * (1000 / case.tracks).max(1) % 1000, f64::from(n / 1000))
}

fn target(case: &Case, n: u16, second: u32) -> Target {
    let (part, block) = part(case, n);
    let (t, i) = (f64::from(second), f64::from(part));
    let (position, velocity) = match part {
        // On final, 15 s apart beyond the alerts.
        0..10 => ((-2500.0 - 1100.0 * (i + 10.0 * block) + 70.0 * (t % 30.0), 2.0), (70.0, 0.0)),
        // Lined up or crossing, cleared.
        10..30 => ((60.0 + 140.0 * (i - 10.0) + 45.0 * block, 1800.0), (0.0, 0.0)),
        30..550 => {
            let along = (i * 37.0 + 10.0 * t) % 3000.0;
            ((along, way_m(part, block)), (10.0, 0.0))
        }
        _ => (
            (f64::from(part % 70) * 45.0, 500.0 + 60.0 * f64::from(part % 9) + 19.0 * block),
            (0.05, -0.02),
        ),
    };
    let every = |nth: u16| nth > 0 && n.is_multiple_of(nth);
    Target {
        number: n,
        callsign: (!every(case.nameless)).then(|| Callsign::new(&format!("X{n}"))),
        class: if n % 10 == 9 { TargetClass::Vehicle } else { TargetClass::Aircraft },
        arriving: n.is_multiple_of(2),
        length_m: 38.0,
        position_m: Point2::new(position.0, position.1),
        velocity_mps: Vector2::new(velocity.0, velocity.1),
        altitude_m: None,
        last_plot: SimTime::from_s(if every(case.coasting) { t - 5.0 } else { t }),
        first: false,
    }
}

/// Where a taxiway to the east is, m north.
fn way_m(part: u16, block: f64) -> f64 {
    200.0 + 30.0 * f64::from(part % 40) + 7.0 * block
}

fn board(case: &Case) -> Board {
    let mut board = Board::default();
    for n in 0..case.tracks {
        let (part, block) = part(case, n);
        let (kind, runway) = match part {
            0..10 => (ClearanceKind::Land, Some((0, Some(0)))),
            10..30 => (ClearanceKind::Cross, Some((1, None))),
            30..550 => (ClearanceKind::Taxi, None),
            _ => (ClearanceKind::Push, None),
        };
        let callsign = Callsign::new(&format!("X{n}"));
        let from = SimTime::ZERO;
        board.give(Clearance { callsign, kind, runway, place_m: None, from, until: None });
        let Some(strip) = board.strip(callsign) else { continue };
        if (30..550).contains(&part) {
            let y = way_m(part, block);
            strip.way_m = (0..100).map(|k| Point2::new(30.0 * f64::from(k), y)).collect();
        }
        // Every stand has one who wants it, and who stands there another one.
        strip.stand_m =
            case.stands.then(|| Point2::new(f64::from(part % 70) * 45.0, 1100.0 + 19.0 * block));
    }
    board
}

fn bench_with(c: &mut Criterion<CpuTime>, name: &str, case: Case) {
    let mut net = SafetyNet::new(layout(case.runways), case.parameters);
    let mut board = board(&case);
    // A lit bar every 100 m on both sides of each runway.
    let bar = |n: usize| StopBar {
        runway: n % case.runways,
        place_m: 100.0 * (n / (2 * case.runways)) as f64,
        across_m: Some(if n.is_multiple_of(2) { 90.0 } else { -90.0 }),
        entry_m: 100.0 * (n / (2 * case.runways)) as f64,
        lit: true,
    };
    let bars: Vec<StopBar> = (0..if case.bars { 60 * case.runways } else { 0 }).map(bar).collect();
    let second = std::cell::Cell::new(0);
    c.bench_function(name, |b| {
        let tracks = || {
            second.set(second.get() + 1);
            (0..case.tracks).map(|n| target(&case, n, second.get())).collect::<Vec<Target>>()
        };
        let judge = |targets: Vec<Target>| {
            let now = SimTime::from_s(f64::from(second.get()));
            board.advance(now);
            let (targets, board) = (&targets[..], &board);
            let scan = Scan { now, targets, board, bars: &bars, areas: &[], low_visibility: false };
            let raised = net.scan(&scan).len();
            // Tracks that coast for longer are left out.
            let seen = net.surveillance().situations().len();
            assert_eq!(seen, usize::from(case.tracks), "every track is looked at");
            raised
        };
        b.iter_batched(tracks, judge, BatchSize::PerIteration);
    });
}

fn bench(c: &mut Criterion<CpuTime>) {
    let exact = Case {
        tracks: 1000,
        runways: 3,
        parameters: Parameters::default(),
        nameless: 0,
        coasting: 0,
        bars: false,
        stands: false,
    };
    let tracked = Case { parameters: Parameters::on_tracks(), ..exact };
    for runways in [3, 6] {
        for tracks in [100, 1000, 3000] {
            let mut one = |what: &str, case: Case| {
                let case = Case { tracks, runways, ..case };
                bench_with(c, &format!("{tracks} tracks, {runways} runways: {what}"), case);
            };
            one("exact", exact);
            one("as tracks", tracked);
            one("as tracks, every second coasts", Case { coasting: 2, ..tracked });
            one("as tracks, every second without a name", Case { nameless: 2, ..tracked });
            one("as tracks, a lit bar every 100 m", Case { bars: true, ..tracked });
            one("as tracks, with stands", Case { stands: true, ..tracked });
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = bench
}
criterion_main!(benches);
