//! `seeds sim`: a scene's federation in one thread under drawn faults, over a simulated clock, bus and ether.
//!
//! The oracle is the run of the same scene and seed that nothing happens to: members die and are started
//! again, stand still and are cut off, messages and PDUs are lost; in the end every digest must be the same.

use super::trial::Trial;
use crate::runtime::cli::{self, BAD_INPUT, COMPLETE, FAILED, fail, load_scene, out};
use crate::runtime::messages::Command;
use crate::runtime::simulation::{Fault, MS, What};
use clap::Args;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Run a scene's federation under drawn faults in simulated time, and compare every digest
#[derive(Args, Clone, Debug)]
pub struct SimArgs {
    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(value_name = "SCENE", default_value = "zurich")]
    scene: String,

    /// Seeds of the faults, first to last
    #[arg(long, value_name = "A..B", default_value = "1..20", value_parser = seeds_of)]
    seeds: (u64, u64),

    /// Simulated duration of each run, s
    #[arg(long, value_name = "S", default_value_t = 20.0, value_parser = cli::seconds)]
    duration: f64,

    /// Faults of this file (JSON, as a failing seed prints them) instead of drawn ones
    #[arg(long, value_name = "FILE")]
    faults: Option<PathBuf>,

    /// A table of what each kind of fault costs, instead of drawn ones
    #[arg(long)]
    table: bool,

    /// With a car of an outsider, which nobody can make again
    #[arg(long)]
    visitors: bool,

    /// SMDFMs that share the sensors, 1 to 3
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=3))]
    smdfms: u32,

    /// Only the rows of the table whose names hold this
    #[arg(long, value_name = "WORD", requires = "table")]
    only: Option<String>,
}

fn seeds_of(text: &str) -> Result<(u64, u64), String> {
    let parts = text.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match parts {
        Some((a, b)) if a <= b => Ok((a, b)),
        _ => Err(format!("'{text}' is not a range of seeds like 1..100")),
    }
}

/// What a thousand drawn seeds have to reach, each row at least [`HITS`] times; where there is a standby the rows of one come less often.
const ROWS: [&str; 27] = [
    "seal",
    "cut",
    "view that waits",
    "admit",
    "outcast",
    "frozen by a fault",
    "frozen by command",
    "return that makes the run again",
    "taken over",
    "station made again",
    "messages lost in a burst",
    "aimed at seal",
    "aimed at sealed",
    "aimed at cut",
    "aimed at held",
    "aimed at view",
    "aimed at admit",
    "aimed at finish",
    "aimed at results",
    "aimed at candidacy",
    "aimed at a new leader",
    "journal not writable",
    "another build was refused",
    "another scene was refused",
    "another run was refused",
    "forged messages",
    "rate by command",
];

/// How often at least, of a thousand seeds.
const HITS: u64 = 20;

/// The rows that so many seeds did not reach often enough.
fn missed(seen: &BTreeMap<&'static str, u64>, seeds: u64) -> Vec<String> {
    let least = (HITS * seeds).div_ceil(1_000);
    let count = |row: &str| seen.get(row).copied().unwrap_or(0);
    let missed = ROWS.iter().filter(|row| count(row) < least);
    missed.map(|row| format!("{row}: {} of {least}", count(row))).collect()
}

/// Runs the seeds; ends with 1 at the first that does not come to the same result.
#[must_use]
pub fn run(args: &SimArgs) -> ExitCode {
    let scene = match load_scene(&args.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    let given = match &args.faults {
        None => None,
        Some(file) => match read_faults(file) {
            Ok(faults) => Some(faults),
            Err(e) => return fail(BAD_INPUT, format!("{}: {e}", file.display())),
        },
    };
    let trial =
        Trial::new(scene, args.duration).with_visitors(args.visitors).with_smdfms(args.smdfms);
    let whole = match trial.undisturbed() {
        Ok(whole) => whole,
        Err(why) => return fail(FAILED, why),
    };
    if args.table {
        return match super::fault_table::print(&trial, &whole, args.only.as_deref()) {
            Ok(()) => ExitCode::from(COMPLETE),
            Err(why) => fail(BAD_INPUT, why),
        };
    }
    let mut seen = BTreeMap::new();
    for seed in args.seeds.0..=args.seeds.1 {
        let faults = given.clone().unwrap_or_else(|| trial.draw(seed));
        let Err(why) = trial.holds(seed, &faults, &whole, &mut seen) else { continue };
        let least = shrink(&faults, |fewer| {
            is_mended(fewer) && trial.holds(seed, fewer, &whole, &mut BTreeMap::new()).is_err()
        });
        let text = serde_json::to_string(&least).unwrap_or_default();
        out!("{text}");
        return fail(
            FAILED,
            format!(
                "seed {seed}: {why}; again with: seeds sim {} --duration {}{}{} --seeds {seed}..{seed} --faults FILE (the line on standard output)",
                args.scene,
                args.duration,
                if args.visitors { " --visitors" } else { "" },
                if args.smdfms > 1 { format!(" --smdfms {}", args.smdfms) } else { String::new() }
            ),
        );
    }
    for (what, count) in &seen {
        out!("{count:>9} {what}");
    }
    let seeds = args.seeds.1 - args.seeds.0 + 1;
    let missed = missed(&seen, seeds);
    if given.is_none() && seeds >= 1_000 && !missed.is_empty() {
        return fail(FAILED, format!("hardly reached: {}", missed.join(", ")));
    }
    ExitCode::from(COMPLETE)
}

fn read_faults(file: &std::path::Path) -> anyhow::Result<Vec<Fault>> {
    Ok(serde_json::from_str(&std::fs::read_to_string(file)?)?)
}

/// Whether everybody who dies is started again, and the last word of an operator is to go on.
fn is_mended(faults: &[Fault]) -> bool {
    let again = |fault: &Fault| {
        let starts = |f: &&Fault| f.who == fault.who && f.what == What::Start;
        let dies = match &fault.what {
            What::Aimed(_, _, what) => matches!(**what, What::Kill | What::Vanish),
            what => matches!(what, What::Kill | What::Vanish | What::Another),
        };
        !dies || faults.iter().filter(starts).any(|f| f.at_ns > fault.at_ns)
    };
    let orders = faults.iter().filter(|f| matches!(f.what, What::Command(_)));
    let last = orders.max_by_key(|f| f.at_ns);
    faults.iter().all(again) && last.is_none_or(|f| f.what == What::Command(Command::Start))
}

/// The fewest of `faults` that `fails` is still true of: halves, then single ones are left out.
fn shrink(faults: &[Fault], fails: impl Fn(&[Fault]) -> bool) -> Vec<Fault> {
    let mut least = faults.to_vec();
    let mut size = least.len();
    while size > 0 {
        let mut at = 0;
        while at < least.len() {
            let mut fewer = least.clone();
            fewer.drain(at..(at + size).min(least.len()));
            if fails(&fewer) {
                least = fewer;
            } else {
                at += size;
            }
        }
        size /= 2;
    }
    for at in 0..least.len() {
        // As early, and as short, as it may be.
        for unit_ms in [1_000, 100, 10] {
            let mut earlier = least.clone();
            earlier[at].at_ns = earlier[at].at_ns / (unit_ms * MS) * (unit_ms * MS);
            if earlier != least && fails(&earlier) {
                least = earlier;
                break;
            }
        }
        while let Some(what) = shorter(&least[at].what) {
            let mut less = least.clone();
            less[at].what = what;
            if !fails(&less) {
                break;
            }
            least = less;
        }
    }
    least
}

/// The same for half the time, if that is 10 ms at least.
fn shorter(what: &What) -> Option<What> {
    let half = |ns: &u64| Some(*ns / 2 / MS * MS).filter(|ns| *ns >= 10 * MS);
    Some(match what {
        What::Pause(ns) => What::Pause(half(ns)?),
        What::Cut(ns) => What::Cut(half(ns)?),
        What::Deaf(ns) => What::Deaf(half(ns)?),
        What::Mute(ns) => What::Mute(half(ns)?),
        What::Slow(ns) => What::Slow(half(ns)?),
        What::Part(with, ns) => What::Part(with.clone(), half(ns)?),
        What::Burst(to, ns) => What::Burst(to.clone(), half(ns)?),
        What::Intruder(ns) => What::Intruder(half(ns)?),
        What::Aimed(event, late, what) => What::Aimed(*event, *late, Box::new(shorter(what)?)),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::super::trial::{Digests, More, has_standby, more, taking_over};
    use super::*;
    use crate::federation::is_front_end;
    use crate::runtime::simulation::Event;
    use scenarios::losses::{ByMember, Losses};

    /// Every one of some seeds holds on the shipped scene; how often which row was reached.
    fn all_hold(seeds: impl IntoIterator<Item = u64>) -> BTreeMap<&'static str, u64> {
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let trial = Trial::new(Arc::new(scene), 20.0);
        let whole = trial.undisturbed().expect("it ends");
        let mut seen = BTreeMap::new();
        for seed in seeds {
            let faults = trial.draw(seed);
            if let Err(why) = trial.holds(seed, &faults, &whole, &mut seen) {
                panic!("seed {seed}: {why} under {faults:?}");
            }
        }
        seen
    }

    /// Forty seeds of the shipped scene's first seconds; a thousand and more by the command.
    #[test]
    fn whatever_befalls_a_federation_its_digests_are_those_of_the_undisturbed_run() {
        let seen = all_hold(1..=40);
        for what in ["seal", "cut", "view that waits", "admit", "outcast", "frozen by a fault"] {
            assert!(seen.get(what).is_some_and(|n| *n >= 5), "{what} was hardly reached: {seen:?}");
        }
        assert_eq!(seen.get("the same run twice"), Some(&4), "{seen:?}");
    }

    /// Faults aimed at what the protocol does, bursts, a disk that is full, strangers and forged words, an operator who hurries: the digests are
    /// the same, and each row is hit. How often in a thousand seeds: `seeds sim --seeds 1..1000` says and checks.
    #[test]
    fn whatever_is_aimed_at_the_protocol_the_digests_are_the_same() {
        let seen = all_hold((1_001..=1_100).filter(|seed| more(*seed) != More::Nothing));
        let seldom = |row: &&&str| seen.get(**row).is_none_or(|n| *n < 2);
        let rows = ROWS[10..].iter().chain(&["begun again by command"]);
        let missed: Vec<_> = rows.filter(seldom).collect();
        assert!(missed.is_empty(), "{missed:?} of {seen:?}");
    }

    /// The station is lost where it has a standby, or the two lose each other: every digest is that of the undisturbed run, nobody says two
    /// things, no epoch has two leaders, and each row of the table of faults that speaks of a standby is reached.
    #[test]
    fn with_a_standby_whatever_befalls_the_station_the_digests_are_the_same() {
        let seen = all_hold((1..=175).filter(|seed| has_standby(*seed)));
        for row in [
            "standby is in",
            "standby leads: station lost",
            "standby leads: station and a member lost",
            "standby leads: station stands still",
            "standby leads: station cut off",
            "station stands down",
            "station goes on without its standby",
            "both stand without a majority",
            "station made again",
        ] {
            assert!(seen.get(row).is_some_and(|n| *n >= 1), "{row} was not reached: {seen:?}");
        }
    }

    /// Seeds that failed once: number, and the fewest faults that did it.
    #[test]
    fn what_failed_once_holds() {
        let fault = |at_ms: u64, who: &str, what: What| Fault {
            at_ns: at_ms * MS,
            who: who.to_owned(),
            what,
        };
        let (smdfm, second) = ("smdfm", "traffic-generator-2");
        let cases = [
            (
                639,
                vec![
                    fault(7174, "external-world", What::Mute(442 * MS)),
                    fault(8150, smdfm, What::Kill),
                    fault(8184, second, What::Pause(4136 * MS)),
                    fault(12004, smdfm, What::Start),
                ],
            ),
            (175, vec![fault(322, smdfm, What::Vanish), fault(3_000, smdfm, What::Start)]),
        ];
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let trial = Trial::new(Arc::new(scene), 20.0);
        let whole = trial.undisturbed().expect("it ends");
        for (seed, faults) in cases {
            let seen = &mut BTreeMap::new();
            let policies = [Losses::default(), taking_over()];
            for losses in policies {
                let held = trial.holds_with(seed, &faults, &whole, seen, &losses);
                held.unwrap_or_else(|why| panic!("seed {seed}, {losses:?}: {why}"));
            }
        }
    }

    /// An answer to the standby came twice before its next question: what it held was no journal any more, it began anew, and with two of four
    /// members gone nobody could say that the station goes on without it: time stood for good (seed 3061).
    #[test]
    fn an_answer_to_the_standby_that_comes_twice_changes_nothing() {
        let fault = |at_ns: u64, who: &str, what: What| Fault { at_ns, who: who.to_owned(), what };
        let [first, second] = ["traffic-generator-1", "traffic-generator-2"];
        let aimed = What::Aimed(Event::Seal, 4_949_292, Box::new(What::Kill));
        let faults = [
            fault(240 * MS, "standby", What::Start),
            fault(6_790 * MS, "standby", What::Pause(24 * MS)),
            fault(4_200 * MS, first, What::Kill),
            fault(10_000 * MS, first, What::Start),
            fault(0, second, aimed),
            fault(25_000 * MS, second, What::Start),
        ];
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let trial = Trial::new(Arc::new(scene), 20.0);
        let whole = trial.undisturbed().expect("it ends");
        let seen = &mut BTreeMap::new();
        trial.holds(3_061, &faults, &whole, seen).unwrap_or_else(|why| panic!("{why}"));
        assert_eq!(seen.get("standby is in"), Some(&1), "{seen:?}");
    }

    /// One is killed, another one `gap_ms` later; each is started again after `again_ms`.
    fn pair(at_ms: u64, one: &str, gap_ms: u64, two: &str, again_ms: u64) -> Vec<Fault> {
        let fault =
            |at_ms: u64, who: &str, what| Fault { at_ns: at_ms * MS, who: who.to_owned(), what };
        let mut faults =
            vec![fault(at_ms, one, What::Kill), fault(at_ms + again_ms, one, What::Start)];
        if one != two {
            faults.push(fault(at_ms + gap_ms, two, What::Kill));
            faults.push(fault(at_ms + gap_ms + again_ms, two, What::Start));
        }
        faults
    }

    /// Each of some cases leaves the digests as they are, by turns with places taken over and without, and somebody returns in it.
    fn hold_by_turns(trial: &Trial, cases: &[Vec<Fault>], whole: &Digests) {
        for (n, faults) in cases.iter().enumerate() {
            let losses = if n % 2 == 0 { taking_over() } else { Losses::default() };
            let mut seen = BTreeMap::new();
            let held = trial.holds_with(3 + n as u64, faults, whole, &mut seen, &losses);
            held.unwrap_or_else(|why| panic!("{faults:?}, {losses:?}: {why}"));
            let back = seen.contains_key("return that makes the run again");
            assert!(back, "{faults:?}, {losses:?}: {seen:?}");
        }
    }

    /// The digests of SMDFMs that share the sensors are those of one, whoever of them is lost, alone, with another one or with
    /// whom it hears or tells; at the shipped scene, and in a loop on tracks with an outsider.
    #[test]
    fn several_smdfms_make_the_run_of_one_whatever_befalls_them() {
        let without_front_ends = |whole: &Digests| -> Digests {
            whole.iter().filter(|(of, ..)| !is_front_end(of)).cloned().collect()
        };
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let zurich = |smdfms| Trial::new(Arc::new(scene.clone()), 20.0).with_smdfms(smdfms);
        let tracks = "sees = \"tracks\"\ncontrollers = \"model\"";
        let alone = [zurich(1), loop_of(tracks)].map(|t| t.undisturbed().expect("it ends"));
        for smdfms in [2, 3] {
            let (trial, mut seen) = (zurich(smdfms), BTreeMap::new());
            let whole = trial.undisturbed().expect("it ends");
            assert_eq!(without_front_ends(&whole), alone[0], "{smdfms} SMDFMs");
            for seed in 1..=12 {
                let faults = trial.draw(seed);
                let held = trial.holds(seed, &faults, &whole, &mut seen);
                held.unwrap_or_else(|why| panic!("{smdfms}, seed {seed}: {why} under {faults:?}"));
            }
        }
        let trial = loop_of(tracks).with_smdfms(2);
        let whole = trial.undisturbed().expect("it ends");
        assert_eq!(without_front_ends(&whole), alone[1]);
        let (first, second, control) = ("smdfm", "smdfm-2", "control");
        let cases = [
            pair(41_300, second, 0, second, 700),
            pair(41_300, second, 20, first, 700),
            pair(41_300, first, 300, second, 900),
            pair(30_010, second, 450, control, 900),
            pair(44_020, "traffic-generator-2", 30, second, 900),
        ];
        hold_by_turns(&trial, &cases, &whole);
        // One that hangs is told from those that wait for it.
        let hangs =
            [Fault { at_ns: 20_000 * MS, who: second.to_owned(), what: What::Slow(20_000 * MS) }];
        let step_ms = ByMember { all: Some(3_000), ..ByMember::default() };
        let (losses, seen) = (Losses { step_ms, ..Losses::default() }, &mut BTreeMap::new());
        let held = trial.holds_with(3, &hangs, &whole, seen, &losses);
        held.unwrap_or_else(|why| panic!("{hangs:?}: {why}"));
        assert_eq!(seen.get("seal"), Some(&1), "{seen:?}");
    }

    /// Controllers clear at an airport that nothing was tuned on, and a car of somebody else drives there.
    fn loop_of(control: &str) -> Trial {
        let airport = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports/LZIB.apt.dat");
        let text = format!(
            "[run]\ntitle = \"loop\"\nseed = 11\nduration_s = 100\n[airport]\nlayout = \"{airport}\"\n[[traffic]]\nkind = \"generated\"\n\
             arrivals_per_h = 20\ndepartures_per_h = 30\n[control]\n{control}\n"
        );
        let scene =
            scenarios::load_text(std::path::Path::new("loop.toml"), &text).expect("a scene");
        Trial::new(Arc::new(scene), 100.0).with_visitors(true)
    }

    #[test]
    fn who_is_killed_in_the_loop_with_an_outsider_there_makes_the_same_run() {
        let (smdfm, control, second) = ("smdfm", "control", "traffic-generator-2");
        let on_tracks = [
            pair(41_300, smdfm, 0, smdfm, 700),
            pair(41_300, control, 0, control, 700),
            pair(41_300, second, 0, second, 700),
            pair(30_010, smdfm, 450, control, 900),
            pair(44_020, second, 30, smdfm, 900),
        ];
        let on_truth =
            [pair(41_300, control, 0, control, 700), pair(30_010, second, 450, control, 900)];
        let tracks = "sees = \"tracks\"\ncontrollers = \"model\"";
        for (sees, cases) in [(tracks, &on_tracks[..]), ("sees = \"truth\"", &on_truth)] {
            let trial = loop_of(sees);
            let whole = trial.undisturbed().expect("it ends");
            hold_by_turns(&trial, cases, &whole);
            // It is the loop that is tested: something was cleared in it.
            let cleared = |(of, what, _): &(String, String, u64)| of == control && what != "pdus";
            assert!(whole.iter().any(cleared), "{sees}: {whole:?}");
        }
    }

    #[test]
    fn what_is_shrunk_still_fails_and_has_nothing_that_could_go() {
        let fault = |at_ns| Fault { at_ns, who: "smdfm".into(), what: What::Kill };
        let faults: Vec<Fault> = (1..=9).map(fault).collect();
        let fails = |f: &[Fault]| [3, 7].iter().all(|at| f.iter().any(|f| f.at_ns == *at));
        assert_eq!(shrink(&faults, fails), [fault(3), fault(7)]);
    }

    /// A time is rounded and a duration halved as long as that still fails; of one that is aimed, the duration of what it does.
    #[test]
    fn what_is_shrunk_is_as_early_and_as_short_as_still_fails() {
        let fault = |at_ms: u64, what| Fault { at_ns: at_ms * MS, who: "smdfm".into(), what };
        let aimed = |ns| What::Aimed(Event::Cut, 7, Box::new(What::Pause(ns)));
        let faults = [fault(7_654, What::Cut(6_000 * MS)), fault(2_222, aimed(900 * MS))];
        let fails = |faults: &[Fault]| {
            let cut = faults.iter().any(|f| {
                f.at_ns >= 7_300 * MS && matches!(f.what, What::Cut(ns) if ns >= 1_000 * MS)
            });
            let pauses = |f: &Fault| matches!(&f.what, What::Aimed(_, 7, what) if matches!(**what, What::Pause(ns) if ns > 200 * MS));
            cut && faults.iter().any(pauses)
        };
        let least = [fault(7_600, What::Cut(1_500 * MS)), fault(2_000, aimed(225 * MS))];
        assert_eq!(shrink(&faults, fails), least);
    }
}
