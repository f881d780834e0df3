//! The alerts of a scene on exact truth, its failures, and how many flights were served.
//! `cargo run --release -p scenarios --example alerts -- SCENE…`

use models::control::alert::Change;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::time::SimTime;
use models::traffic::exact::Watch;

#[expect(clippy::print_stdout, reason = "a tool for the terminal")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in std::env::args().skip(1) {
        let scene = scenarios::load(std::path::Path::new(&path))?;
        let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves in this scene")?;
        let mut core = behaving.core(&scene.run, scene.run.seed).ok_or("no truth")?;
        let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
        let mut watch = Watch::new(layout, Parameters::default(), scene.control.stop_bars);
        println!("== {path}");
        for frame in 1..=scene.run.frames() {
            core.step(frame as i64);
            if frame % u64::from(scene.run.frames_per_scan) == 0 {
                let now = SimTime(frame as i64 * scene.run.frame.0);
                for (change, alert) in watch.scan(&core, now) {
                    let (kind, stage) = (alert.condition.kind.word(), alert.condition.stage.word());
                    let word = match change {
                        Change::Raised => "raised",
                        Change::Changed => "changed",
                        Change::Ended => "ended",
                    };
                    println!("{:8.1} {word:8} {kind:14} {stage:12} {}", now.s(), alert.subjects());
                }
            }
        }
        for shown in core.shown() {
            println!("{:8.1} failure {} {}", shown.time_s, shown.kind.word(), shown.callsign);
        }
        for remark in core.remarks() {
            println!("{:8.1} {}", remark.time_s, remark.text);
        }
        println!("served {} of {}", core.measures_of_served(), core.flights().len());
    }
    Ok(())
}
