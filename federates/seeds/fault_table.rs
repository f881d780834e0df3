//! `seeds sim --table`: what each kind of fault costs a run, as rows of a table for people.
//!
//! The scene's own federates run in simulated time, so every figure is the same whenever it is made again.

use super::trial::{Digests, Trial};
use crate::runtime::cli::out;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::messages::Command;
use crate::runtime::simulation::{Fault, MS, Network, STANDBY, What};
use scenarios::losses::{Losses, on_loss_flag};

/// A fault as the table has it.
struct Row {
    /// Its name on the command line.
    name: String,
    /// What happens, for people.
    what: String,
    /// `--on-loss` of the run.
    on_loss: &'static str,
    /// Messages of the synchronisation plane and PDUs that are lost, of a thousand.
    loss: [u64; 2],
    /// At which time, s; to whom; what.
    faults: Vec<(f64, &'static str, What)>,
}

const GENERATOR: &str = "traffic-generator-2";
const WORLD: &str = "external-world";
const SMDFM: &str = "smdfm";
const CONTROL: &str = "control";

/// How long a table's run may take, ns of simulated wall time.
const WITHIN_NS: u64 = 2_000_000 * MS;

/// How finely what is seen is timed.
const LOOK_NS: u64 = 10 * MS;

fn row(
    name: &str,
    what: &str,
    on_loss: &'static str,
    faults: Vec<(f64, &'static str, What)>,
) -> Row {
    Row { name: name.to_owned(), what: what.to_owned(), on_loss, loss: [0, 0], faults }
}

fn rows() -> Vec<Row> {
    let s = |seconds: f64| (seconds * 1e3) as u64 * MS;
    let order = |at, command| (at, "", What::Command(command));
    let goes = |name: &str, to: &str| Command::Move { name: name.into(), to: to.into() };
    let mut rows = vec![
        row("nothing", "nothing", "freeze", vec![]),
        Row {
            loss: [200, 300],
            ..row("loss", "20 % of messages and 30 % of PDUs are lost", "freeze", vec![])
        },
        row(
            "kill-generator",
            "a generator is killed, the process of another producer takes its place",
            "takeover",
            vec![(5.0, GENERATOR, What::Kill)],
        ),
        row(
            "kill-world",
            "the external world is killed, a generator's process takes its place",
            "takeover",
            vec![(5.0, WORLD, What::Kill)],
        ),
        row(
            "move-generator",
            "a generator's place goes to the external world's process by command",
            "takeover",
            vec![order(5.0, goes(GENERATOR, WORLD))],
        ),
        row(
            "move-kill",
            "the same, and the external world, to whom it goes, is killed after 0.2 s",
            "takeover",
            vec![order(5.0, goes(GENERATOR, WORLD)), (5.2, WORLD, What::Kill)],
        ),
        row(
            "kill-smdfm",
            "the SMDFM is killed, the launcher starts it again after 0.5 s",
            "takeover",
            vec![(5.0, SMDFM, What::Kill), (5.5, SMDFM, What::Start)],
        ),
        row(
            "kill-two-producers",
            "a generator and, 50 ms later, the external world are killed",
            "takeover",
            vec![(5.0, GENERATOR, What::Kill), (5.05, WORLD, What::Kill)],
        ),
        row(
            "kill-three",
            "a generator, the external world and the SMDFM are killed within 0.6 s",
            "takeover",
            vec![
                (5.0, GENERATOR, What::Kill),
                (5.3, WORLD, What::Kill),
                (5.6, SMDFM, What::Kill),
                (5.7, SMDFM, What::Start),
            ],
        ),
        row(
            "kill-station",
            "the administration station is killed, the launcher starts it again with its journal",
            "takeover",
            vec![(5.0, CONDUCTOR, What::Kill), (5.05, CONDUCTOR, What::Start)],
        ),
        row(
            "kill-station-smdfm",
            "the administration station and, 50 ms later, the SMDFM are killed, both are started again",
            "takeover",
            vec![
                (5.0, CONDUCTOR, What::Kill),
                (5.05, CONDUCTOR, What::Start),
                (5.05, SMDFM, What::Kill),
                (5.55, SMDFM, What::Start),
            ],
        ),
        row(
            "kill-generator-wait",
            "a generator is killed, somebody starts it again after 3 s",
            "freeze",
            vec![(5.0, GENERATOR, What::Kill), (8.0, GENERATOR, What::Start)],
        ),
        row(
            "kill-smdfm-wait",
            "the SMDFM is killed, somebody starts it again after 3 s",
            "freeze",
            vec![(5.0, SMDFM, What::Kill), (8.0, SMDFM, What::Start)],
        ),
        row(
            "kill-frozen",
            "the SMDFM is killed in a frozen run and started again",
            "freeze",
            vec![
                order(5.0, Command::Freeze),
                (6.0, SMDFM, What::Kill),
                (8.0, SMDFM, What::Start),
                order(10.0, Command::Start),
            ],
        ),
        row(
            "kill-joining",
            "the SMDFM is killed while it joins and started again",
            "freeze",
            vec![(0.002, SMDFM, What::Kill), (1.0, SMDFM, What::Start)],
        ),
        row(
            "vanish-smdfm",
            "the SMDFM's host is gone and nobody is told; another is started after 3 s",
            "freeze",
            vec![(5.0, SMDFM, What::Vanish), (8.0, SMDFM, What::Start)],
        ),
        row(
            "slow-smdfm",
            "a frame of the SMDFM takes 10 s",
            "freeze",
            vec![(5.0, SMDFM, What::Slow(s(10.0)))],
        ),
        row(
            "freeze",
            "frozen for 10 minutes, then started",
            "freeze",
            vec![order(5.0, Command::Freeze), order(605.0, Command::Start)],
        ),
        row(
            "degrade-generator",
            "a generator is killed, the run goes on without it",
            "degrade",
            vec![(5.0, GENERATOR, What::Kill)],
        ),
        row(
            "without-generator",
            "a generator is killed, after 3 s an operator says that the run goes on without it",
            "freeze",
            vec![
                (5.0, GENERATOR, What::Kill),
                order(8.0, Command::Without { name: GENERATOR.to_owned() }),
            ],
        ),
        row(
            "abort-generator",
            "a generator is killed, the run is closed",
            "abort",
            vec![(5.0, GENERATOR, What::Kill)],
        ),
    ];
    rows.extend(rows_of_stations());
    rows.extend(rows_of_control());
    for (name, who, called) in
        [("generator", GENERATOR, "a generator"), ("smdfm", SMDFM, "the SMDFM")]
    {
        for (seconds, word) in [(1.0, "1"), (5.0, "5"), (60.0, "60")] {
            rows.push(row(
                &format!("pause-{name}-{word}"),
                &format!("{called} stands still for {word} s"),
                "freeze",
                vec![(5.0, who, What::Pause(s(seconds)))],
            ));
            rows.push(row(
                &format!("cut-{name}-{word}"),
                &format!("the link of {called} is cut for {word} s"),
                "freeze",
                vec![(5.0, who, What::Cut(s(seconds)))],
            ));
        }
        let one_way = [
            ("deaf", "nothing reaches", What::Deaf(s(5.0))),
            ("mute", "nothing comes from", What::Mute(s(5.0))),
        ];
        for (word, text, what) in one_way {
            rows.push(row(
                &format!("{word}-{name}-5"),
                &format!("{text} {called} for 5 s"),
                "freeze",
                vec![(5.0, who, what)],
            ));
        }
    }
    rows
}

/// Faults of the administration station, alone and where it has a standby.
fn rows_of_stations() -> Vec<Row> {
    let five_s = 5_000 * MS;
    let with = |name: &str, what: &str, faults: Vec<(f64, &'static str, What)>| {
        let faults = [vec![(0.0, STANDBY, What::Start)], faults].concat();
        row(name, what, "freeze", faults)
    };
    let side = [WORLD, SMDFM].map(str::to_owned).to_vec();
    vec![
        row(
            "pause-station-5",
            "the administration station stands still for 5 s",
            "freeze",
            vec![(5.0, CONDUCTOR, What::Pause(five_s))],
        ),
        row(
            "cut-station-5",
            "the link of the administration station is cut for 5 s",
            "freeze",
            vec![(5.0, CONDUCTOR, What::Cut(five_s))],
        ),
        with(
            "standby-kill-station",
            "the administration station is killed, its standby leads on",
            vec![(6.0, CONDUCTOR, What::Kill)],
        ),
        with(
            "standby-vanish-station",
            "the station's host is gone and nobody is told, its standby leads on",
            vec![(6.0, CONDUCTOR, What::Vanish)],
        ),
        with(
            "standby-pause-station",
            "the station stands still for 5 s, its standby leads on",
            vec![(6.0, CONDUCTOR, What::Pause(five_s))],
        ),
        with(
            "standby-cut-station",
            "the link of the station is cut for 5 s, its standby leads on",
            vec![(6.0, CONDUCTOR, What::Cut(five_s))],
        ),
        with(
            "standby-kill-station-smdfm",
            "the station and, 50 ms later, the SMDFM are killed; the standby leads on, the SMDFM is started again after 0.5 s",
            vec![
                (6.0, CONDUCTOR, What::Kill),
                (6.05, SMDFM, What::Kill),
                (6.55, SMDFM, What::Start),
            ],
        ),
        with(
            "standby-kill-standby",
            "the standby is killed, the station goes on without it",
            vec![(6.0, STANDBY, What::Kill)],
        ),
        with(
            "standby-part",
            "the station and two of four members are apart from the standby and the others for 5 s: no majority, both stand",
            vec![(6.0, CONDUCTOR, What::Part(side, five_s))],
        ),
    ]
}

/// Faults of the functions on tracks, in a scene that has them.
fn rows_of_control() -> Vec<Row> {
    let again = |who, kill_s, start_s| [(kill_s, who, What::Kill), (start_s, who, What::Start)];
    vec![
        row(
            "kill-control",
            "control is killed, the launcher starts it again after 0.5 s",
            "takeover",
            again(CONTROL, 5.0, 5.5).to_vec(),
        ),
        row(
            "kill-smdfm-control",
            "the SMDFM and, 50 ms later, control are killed, both are started again after 0.5 s",
            "takeover",
            [again(SMDFM, 5.0, 5.5), again(CONTROL, 5.05, 5.55)].concat(),
        ),
        row(
            "kill-generator-control",
            "a generator and, 50 ms later, control are killed",
            "takeover",
            [vec![(5.0, GENERATOR, What::Kill)], again(CONTROL, 5.05, 5.55).to_vec()].concat(),
        ),
    ]
}

/// What was seen of a fault.
#[derive(Debug, PartialEq)]
struct Seen {
    /// From the fault to the first word about it, s.
    named_s: Option<f64>,
    /// The longest time without a new frame of the whole federation, s.
    stood_s: f64,
    /// Frames that are not in the result.
    lost: u64,
    /// Whether the digests are those of the undisturbed run.
    same: bool,
    /// Exit code.
    exit: u8,
}

fn see(trial: &Trial, row: &Row, whole: &Digests) -> Result<Seen, String> {
    let losses = Losses { on_loss: on_loss_flag(row.on_loss)?, ..Losses::default() };
    let [bus_loss, udp_loss] = row.loss;
    let network = Network { delay_ns: MS, bus_loss, udp_loss, twice: 0 };
    let mut simulation = trial.simulation(1, 1.0, false, network, &losses);
    let mut rest: Vec<Fault> = row
        .faults
        .iter()
        .map(|(at_s, who, what)| {
            let at_ns = (at_s * 1e3) as u64 * MS;
            Fault { at_ns, who: (*who).to_owned(), what: what.clone() }
        })
        .collect();
    let befalls = |f: &&Fault| f.what != What::Start;
    let first_ns = rest.iter().filter(befalls).map(|f| f.at_ns).min().unwrap_or(0);
    let (mut named_ns, mut stood_ns, mut frame, mut since) = (None, 0_u64, 0, None::<u64>);
    while simulation.closed.is_empty() && simulation.now < WITHIN_NS {
        let to = simulation.now + LOOK_NS;
        let due: Vec<Fault> = rest.extract_if(.., |f| f.at_ns <= to).collect();
        simulation.run_to_close(to, &due);
        let state = simulation.conductor().state();
        if named_ns.is_none() && !state.reasons.is_empty() {
            named_ns = Some(simulation.now - first_ns);
        }
        if state.frame != frame {
            if let Some(since) = since {
                stood_ns = (simulation.now - since).max(stood_ns);
            }
            (frame, since) = (state.frame, Some(simulation.now));
        }
    }
    let closed = simulation.closed.first().ok_or("the run does not end")?;
    let lost = simulation.conductor().state().last_frame - closed.frame;
    let degraded = closed.reasons.iter().find_map(|reason| {
        let since = reason.strip_prefix("degraded since frame ")?.split(':').next()?;
        since.parse::<u64>().ok()
    });
    Ok(Seen {
        named_s: named_ns.map(|ns| ns as f64 * 1e-9),
        stood_s: stood_ns as f64 * 1e-9,
        lost: degraded.map_or(lost, |since| closed.frame + 1 - since),
        same: simulation.digests(0) == *whole,
        exit: simulation.conductor().exit_code(),
    })
}

/// Prints the table, or the rows whose names hold `only`.
///
/// # Errors
/// If no row is called so, or a run does not end.
pub(super) fn print(trial: &Trial, whole: &Digests, only: Option<&str>) -> Result<(), String> {
    let names = trial.names();
    let known = |row: &Row| {
        row.faults
            .iter()
            .all(|(_, who, _)| ["", CONDUCTOR, STANDBY].contains(who) || names.contains(who))
    };
    let all: Vec<Row> = rows().into_iter().filter(known).collect();
    let named = |row: &Row| only.is_none_or(|word| row.name.contains(word));
    let (rows, others): (Vec<Row>, Vec<Row>) = all.into_iter().partition(named);
    if rows.is_empty() {
        let names: Vec<_> = others.into_iter().map(|row| row.name).collect();
        return Err(format!("no fault is called so; there are {}", names.join(", ")));
    }
    out!(
        "| fault | `--on-loss` | `seeds sim --table --only` | named after, s | stood, s | frames lost | digest | exit |"
    );
    out!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    for row in rows {
        let seen = see(trial, &row, whole).map_err(|why| format!("{}: {why}", row.name))?;
        let named = seen.named_s.map_or_else(|| "–".to_owned(), |s| format!("{s:.2}"));
        out!(
            "| {} | {} | `{}` | {named} | {:.2} | {} | {} | {} |",
            row.what,
            row.on_loss,
            row.name,
            seen.stood_s,
            seen.lost,
            if seen.same { "same" } else { "another" },
            seen.exit
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Every fault of the table costs time and no frame, but where the policy says that the run goes on without.
    #[test]
    fn no_fault_of_the_table_loses_a_frame_unless_it_was_told_to() {
        let scene = scenarios::load(&scenarios::locate("zurich")).expect("the shipped scene");
        let trial = Trial::new(Arc::new(scene), 12.0);
        let whole = trial.undisturbed().expect("it ends");
        for row in rows().into_iter().filter(|row| !row.faults.iter().any(|f| f.1 == CONTROL)) {
            let seen =
                see(&trial, &row, &whole).unwrap_or_else(|why| panic!("{}: {why}", row.name));
            let by_command = row.name.starts_with("without");
            let told = by_command || ["degrade", "abort"].contains(&row.on_loss);
            assert_eq!(seen.lost > 0, told, "{}: {seen:?}", row.name);
            assert_eq!(seen.same, !told, "{}: {seen:?}", row.name);
            assert_eq!(seen.exit, u8::from(row.on_loss == "abort"), "{}: {seen:?}", row.name);
            // Stood: what it takes to be sure (0.35 s a killed process, 2 s one of which nothing is heard), to agree and to make again.
            // A station that is started again is found by each federate within 4 s.
            let station = row.faults.iter().any(|f| f.1 == CONDUCTOR);
            let standby = row.faults.iter().any(|f| f.1 == STANDBY);
            if standby && !row.faults.iter().any(|f| matches!(f.2, What::Part(..))) {
                assert!(seen.stood_s < 3.0, "{}: {seen:?}", row.name);
            }
            if row.on_loss == "takeover" {
                let most_s = if station { 4.2 } else { 1.6 };
                assert!(seen.stood_s < most_s, "{}: {seen:?}", row.name);
            }
        }
    }
}
