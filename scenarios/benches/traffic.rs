//! What traffic that behaves costs on one core, planning included: a step with ten, a hundred and a thousand movers, a flight
//! from its begin to its end, and what if. Goals: 30 µs for ten, 0.5 ms for a thousand, 3 ms of planning a mover, 1 s to look ahead.
//!
//! A thousand movers are those that are there at a time, many of them on stands; the networks for many are several airports that ship
//! beside each other, with taxiways between them over which they go to stands of each other.

use criterion::{Criterion, criterion_group, criterion_main};
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::time::SimTime;
use models::traffic::ahead::{Airport, Change, Known, perceive};
use models::traffic::core::Seen;
use models::traffic::exact::Watch;
use scenarios::Scene;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

#[path = "../../models/benches/common/cpu_time.rs"]
mod cpu_time;
#[path = "common/linked.rs"]
mod linked;

use cpu_time::CpuTime;
use criterion::measurement::Measurement as _;
use linked::{core, moving, there, when_there};

const SIX: [&str; 6] = ["EHAM", "EGCC", "LSZH", "LIMC", "LZIB", "XSYN"];

/// Frames over which steps are measured: two minutes.
const FRAMES: i64 = 2400;

/// A step, over the two minutes from when so many are there.
fn steps(c: &mut Criterion<CpuTime>, name: &str, scene: &Result<Scene, String>, count: usize) {
    let found = scene.as_ref().ok().and_then(|scene| when_there(scene, 1, count));
    let Some((begin, first)) = found else { return };
    let (there, moving) = (there(&begin), moving(&begin));
    c.bench_function(&format!("step/{name}, {there} movers, {moving} under way"), |b| {
        b.iter_custom(|steps| {
            let (mut core, mut frame, mut spent) = (begin.clone(), first, Duration::ZERO);
            let mut left = steps as i64;
            while left > 0 {
                if frame == first + FRAMES {
                    (core, frame) = (begin.clone(), first);
                }
                let to = first + FRAMES.min(frame - first + left);
                let before = CpuTime.start();
                (frame..to).for_each(|frame| core.step(frame));
                spent += CpuTime.end(before);
                (left, frame) = (left - (to - frame), to);
            }
            spent
        });
    });
}

/// A flight of an hour, planned and driven.
fn flights(c: &mut Criterion<CpuTime>, name: &str, scene: &Result<Scene, String>) {
    let Some((scene, begin)) = scene.as_ref().ok().and_then(|s| Some((s, core(s, 1)?))) else {
        return;
    };
    c.bench_function(
        &format!("flight, planned and driven/{name}, {} in an hour", begin.flights().len()),
        |b| {
            b.iter_custom(|times| {
                let mut spent = Duration::ZERO;
                for _ in 0..times {
                    let mut core = begin.clone();
                    let before = CpuTime.start();
                    (1..=scene.run.frames() as i64).for_each(|frame| core.step(frame));
                    spent += CpuTime.end(before);
                }
                spent / begin.flights().len().max(1) as u32
            });
        },
    );
}

/// What if somebody is held for two minutes: from what a safety net on truth knows at 40 min, quarter of an hour ahead, twice.
fn what_if(c: &mut Criterion<CpuTime>, name: &str, scene: &Result<Scene, String>) {
    let found =
        scene.as_ref().ok().and_then(|s| Some((s, s.traffic.behaving.as_ref()?, core(s, 1)?)));
    let Some((scene, behaving, mut core)) = found else { return };
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), false);
    let frame_s = scene.run.frame.s();
    let frames = (2400.0 / frame_s) as i64;
    for frame in 1..=frames {
        core.step(frame);
        if frame % 20 == 0 {
            watch.scan(&core, SimTime(frame * scene.run.frame.0));
        }
    }
    let (network, flights) = (Arc::clone(&behaving.network), Arc::new(core.flights().to_vec()));
    let (surveillance, layout) = (watch.net().surveillance(), watch.net().layout());
    let known = Known { board: watch.board(), surveillance, layout };
    let moment = perceive(known, &network, &flights, (frames, frame_s), 99);
    let airport = Airport::new(network, flights);
    let hold = |flight: usize| Change::Hold { flight: flight as u32, for_s: 120.0 };
    let mut changes = (0..moment.seen.len()).map(hold);
    let can = |c: &Change| moment.can(&airport.network, &airport.flights, *c).is_ok();
    let Some(change) = changes.find(can) else { return };
    let moves = |s: &&Seen| !matches!(s, Seen::Planned | Seen::Gone | Seen::OnStand(_));
    let moving = moment.seen.iter().filter(moves).count();
    c.bench_function(&format!("what if, 15 min ahead/{name}, {moving} moving"), |b| {
        b.iter(|| moment.what_if(&airport, change));
    });
}

fn bench(c: &mut Criterion<CpuTime>) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for name in SIX {
        let scene = linked::one(name, 15.0);
        steps(c, name, &scene, 10);
        flights(c, name, &scene);
        what_if(c, name, &scene);
    }
    what_if(c, "EHAM, 60 an hour each way", &linked::one("EHAM", 60.0));
    let six = linked::together(folder, &SIX, 100.0);
    steps(c, "six airports linked", &six, 100);
    flights(c, "six airports linked", &six);
    let (names, per_h) = linked::LARGE;
    steps(c, "46 airports beside each other", &linked::beside(folder, &names, per_h, 1), 1000);
}

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(CpuTime).sample_size(10).warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_secs(2));
    targets = bench
}
criterion_main!(benches);
