//! `[network]`, keys `stall_ms`, `step_ms`, `on_loss` and `return_ms`: what becomes of a run that loses a federate.
//!
//! ```toml
//! [network]
//! stall_ms = 2000                      # for all, or by federate:
//! on_loss = { all = "takeover", smdfm = "abort", visitors = "degrade" }
//! return_ms = 10000                    # or "none"
//! ```

use crate::document::Section;
use crate::error::{Problem, ScenarioError};
use std::collections::BTreeMap;
use std::fmt::{Display, Formatter};

/// What becomes of a run that an essential federate is lost of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnLoss {
    /// Time stands until the federate is back; nothing is left out.
    #[default]
    Freeze,
    /// The run goes on without it, and says since when.
    Degrade,
    /// Another process takes its place, and the run goes on with nothing left out.
    TakeOver,
    /// The run is closed at the frame where it stands.
    Abort,
}

/// The words for [`OnLoss`].
const ON_LOSS: [(&str, OnLoss); 4] = [
    ("freeze", OnLoss::Freeze),
    ("degrade", OnLoss::Degrade),
    ("takeover", OnLoss::TakeOver),
    ("abort", OnLoss::Abort),
];

impl Display for OnLoss {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let word = ON_LOSS.iter().find(|(_, policy)| policy == self).map_or("", |(word, _)| word);
        f.pad(word)
    }
}

/// How long a run waits for a lost federate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReturnWithin {
    /// So long, ms of wall time; then the run is closed.
    Ms(u64),
    /// As long as it takes.
    NoEnd,
}

impl Display for ReturnWithin {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Ms(ms) => write!(f, "{ms}"),
            Self::NoEnd => f.pad("none"),
        }
    }
}

/// A value for all federates, and others for some by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ByMember<T> {
    /// For all that are not named.
    pub all: Option<T>,
    /// By name ("traffic-generator-2") or by kind ("traffic-generator").
    pub named: BTreeMap<String, T>,
}

impl<T> Default for ByMember<T> {
    fn default() -> Self {
        Self { all: None, named: BTreeMap::new() }
    }
}

impl<T: Clone> ByMember<T> {
    /// The value of the federate called `name`: its own, that of its kind, or that of all.
    #[must_use]
    pub fn of(&self, name: &str) -> Option<T> {
        self.by_name(name).or_else(|| self.all.clone())
    }

    /// The same where only what names the federate or its kind counts.
    #[must_use]
    pub fn by_name(&self, name: &str) -> Option<T> {
        let number = |c: char| c.is_ascii_digit() || c == '-';
        let own = self.named.get(name).or_else(|| self.named.get(name.trim_end_matches(number)));
        own.cloned()
    }

    /// Whether there is any value.
    #[must_use]
    pub fn is_given(&self) -> bool {
        self.all.is_some() || !self.named.is_empty()
    }
}

impl<T: Display> Display for ByMember<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let all = self.all.iter().map(ToString::to_string);
        let named = self.named.iter().map(|(name, value)| format!("{name}={value}"));
        f.write_str(&all.chain(named).collect::<Vec<_>>().join(","))
    }
}

/// Federates of a run, as keys and flags name them.
const KINDS: [&str; 5] = ["traffic-generator", "external-world", "smdfm", "control", "visitors"];

/// Bounds of the clocks, ms.
const STALL_MS: [i64; 2] = [300, 3_600_000];
const STEP_MS: [i64; 2] = [100, 86_400_000];
const RETURN_MS: [i64; 2] = [0, 86_400_000];

/// What becomes of a run that loses a federate; what is not said is as the conductor has it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// A federate of which nothing is heard for so long is given up, ms of wall time.
    pub stall_ms: ByMember<u64>,
    /// A federate that is heard of but does not go on for so long is given up, ms of wall time.
    pub step_ms: ByMember<u64>,
    /// What becomes of the run then.
    pub on_loss: ByMember<OnLoss>,
    /// How long the run waits for it.
    pub return_ms: Option<ReturnWithin>,
}

impl Losses {
    /// These, and what they do not say as `scene` has it.
    #[must_use]
    pub fn over(&self, scene: &Self) -> Self {
        fn first<T: Clone>(a: &ByMember<T>, b: &ByMember<T>) -> ByMember<T> {
            if a.is_given() { a.clone() } else { b.clone() }
        }
        Self {
            stall_ms: first(&self.stall_ms, &scene.stall_ms),
            step_ms: first(&self.step_ms, &scene.step_ms),
            on_loss: first(&self.on_loss, &scene.on_loss),
            return_ms: self.return_ms.or(scene.return_ms),
        }
    }
}

/// `VALUE`, `NAME=VALUE` or both, with commas between, as flags take them.
pub(crate) fn by_member<T>(
    text: &str,
    value: impl Fn(&str) -> Result<T, String>,
) -> Result<ByMember<T>, String> {
    let mut read = ByMember::default();
    for part in text.split(',') {
        match part.split_once('=') {
            None if read.all.is_none() => read.all = Some(value(part)?),
            None => return Err(format!("'{text}' has two values for all")),
            Some((name, of)) => {
                let number = |c: char| c.is_ascii_digit() || c == '-';
                if !KINDS.contains(&name.trim_end_matches(number)) {
                    let known = KINDS.join(", ");
                    return Err(format!("'{name}' is not a federate of a run: {known}"));
                }
                read.named.insert(name.to_owned(), value(of)?);
            }
        }
    }
    Ok(read)
}

fn milliseconds(text: &str, [low, high]: [i64; 2]) -> Result<u64, String> {
    match text.parse::<i64>() {
        Ok(ms) if (low..=high).contains(&ms) => Ok(ms as u64),
        _ => Err(format!("'{text}' is not a whole number of milliseconds from {low} to {high}")),
    }
}

/// The value of a flag for `stall_ms`: `2000`, `smdfm=5000` or `2000,smdfm=5000`.
///
/// # Errors
/// What is wrong with it.
pub fn stall_flag(text: &str) -> Result<ByMember<u64>, String> {
    by_member(text, |ms| milliseconds(ms, STALL_MS))
}

/// The value of a flag for `step_ms`, as [`stall_flag`].
///
/// # Errors
/// What is wrong with it.
pub fn step_flag(text: &str) -> Result<ByMember<u64>, String> {
    by_member(text, |ms| milliseconds(ms, STEP_MS))
}

/// The value of a flag for `on_loss`: `takeover`, `smdfm=abort` or `takeover,smdfm=abort`.
///
/// # Errors
/// What is wrong with it.
pub fn on_loss_flag(text: &str) -> Result<ByMember<OnLoss>, String> {
    let read = by_member(text, |word| {
        let known = ON_LOSS.iter().find(|(known, _)| *known == word).map(|(_, policy)| *policy);
        known.ok_or_else(|| {
            let words: Vec<_> = ON_LOSS.iter().map(|(word, _)| *word).collect();
            format!("'{word}' is not one of {}", words.join(", "))
        })
    })?;
    if read.by_name("visitors") == Some(OnLoss::TakeOver) {
        return Err(format!("visitors cannot be taken over: {LET_IN}"));
    }
    Ok(read)
}

/// Why nobody takes the place of `visitors`.
const LET_IN: &str = "what outsiders sent cannot be made again; degrade, freeze or abort";

/// The value of a flag for `return_ms`: a number, or `none`.
///
/// # Errors
/// What is wrong with it.
pub fn return_flag(text: &str) -> Result<ReturnWithin, String> {
    match text {
        "none" => Ok(ReturnWithin::NoEnd),
        ms => milliseconds(ms, RETURN_MS)
            .map(ReturnWithin::Ms)
            .map_err(|e| format!("{e}, nor \"none\"")),
    }
}

/// Reads them from `[network]`.
pub(crate) fn read(network: &Section) -> Result<Losses, ScenarioError> {
    let ms = |section: &Section, key: &str, [low, high]: [i64; 2]| {
        Ok(section.integer(key, low, high)?.map(|ms| ms as u64))
    };
    let return_ms = match network.text("return_ms") {
        Ok(Some("none")) => Some(ReturnWithin::NoEnd),
        Ok(Some(other)) => {
            let (found, allowed) = (other.to_owned(), "a number of milliseconds, \"none\"".into());
            return Err(network.refuse("return_ms", Problem::NotAllowed { found, allowed }));
        }
        _ => ms(network, "return_ms", RETURN_MS)?.map(ReturnWithin::Ms),
    };
    let on_loss = members(network, "on_loss", |s, key| s.choice(key, &ON_LOSS))?;
    if on_loss.by_name("visitors") == Some(OnLoss::TakeOver) {
        let (found, allowed) = ("visitors = \"takeover\"".into(), LET_IN.into());
        return Err(network.refuse("on_loss", Problem::NotAllowed { found, allowed }));
    }
    Ok(Losses {
        stall_ms: members(network, "stall_ms", |s, key| ms(s, key, STALL_MS))?,
        step_ms: members(network, "step_ms", |s, key| ms(s, key, STEP_MS))?,
        on_loss,
        return_ms,
    })
}

/// One value for all, or a table by federate with `all` among its keys.
pub(crate) fn members<T>(
    network: &Section,
    key: &str,
    read: impl Fn(&Section, &str) -> Result<Option<T>, ScenarioError>,
) -> Result<ByMember<T>, ScenarioError> {
    let Ok(Some(table)) = network.any_section(key) else {
        return Ok(ByMember { all: read(network, key)?, named: BTreeMap::new() });
    };
    table.only(&[&["all"], &KINDS[..]].concat())?;
    let mut by_member = ByMember { all: read(&table, "all")?, named: BTreeMap::new() };
    for kind in KINDS {
        if let Some(value) = read(&table, kind)? {
            by_member.named.insert(kind.to_owned(), value);
        }
    }
    Ok(by_member)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn losses(text: &str) -> Result<Losses, String> {
        let root = Section::parse(Path::new("x.toml"), text).expect("TOML");
        let network = root.any_section("network").expect("a table").expect("there");
        read(&network).map_err(|e| e.to_string())
    }

    #[test]
    fn a_key_holds_for_all_or_by_federate() {
        let read = losses(
            "[network]\nstall_ms = 900\non_loss = { all = \"takeover\", smdfm = \"abort\" }\nreturn_ms = \"none\"",
        );
        let read = read.expect("sound");
        assert_eq!(read.stall_ms.of("smdfm"), Some(900));
        assert_eq!(read.on_loss.of("traffic-generator-2"), Some(OnLoss::TakeOver));
        assert_eq!(read.on_loss.of("smdfm"), Some(OnLoss::Abort));
        assert_eq!((read.on_loss.by_name("visitors"), read.step_ms.of("smdfm")), (None, None));
        assert_eq!(read.return_ms, Some(ReturnWithin::NoEnd));
    }

    #[test]
    fn what_is_not_a_value_is_refused_with_its_line() {
        for (line, words) in [
            ("stall_ms = 10", "x.toml:2: network.stall_ms: found 10"),
            (
                "on_loss = \"panic\"",
                "found \"panic\", allowed is \"freeze\", \"degrade\", \"takeover\", \"abort\"",
            ),
            ("on_loss = { smdf = \"abort\" }", "did you mean `smdfm`"),
            ("return_ms = \"never\"", "\"none\""),
            ("on_loss = { visitors = \"takeover\" }", "cannot be made again"),
            ("step_ms = { smdfm = 1.5 }", "network.step_ms.smdfm"),
        ] {
            let refused = losses(&format!("[network]\n{line}")).expect_err(line);
            assert!(refused.contains(words), "{line}: {refused}");
        }
    }

    #[test]
    fn a_flag_says_the_same_as_the_key_and_goes_before_it() {
        let flag = on_loss_flag("takeover,traffic-generator-2=degrade").expect("sound");
        assert_eq!(flag.of("traffic-generator-2"), Some(OnLoss::Degrade));
        assert_eq!(flag.of("traffic-generator-1"), Some(OnLoss::TakeOver));
        assert_eq!(on_loss_flag(&flag.to_string()), Ok(flag.clone()));
        let scene =
            Losses { stall_ms: stall_flag("smdfm=700").expect("sound"), ..Losses::default() };
        let line = Losses { on_loss: flag.clone(), ..Losses::default() };
        let both = line.over(&scene);
        assert_eq!((both.stall_ms.of("smdfm"), both.stall_ms.of("control")), (Some(700), None));
        assert_eq!(both.on_loss, flag);
        for wrong in ["", "10", "2000,3000", "smdf=2000", "2000;3000"] {
            assert!(stall_flag(wrong).is_err(), "{wrong}");
        }
        assert_eq!(return_flag("0"), Ok(ReturnWithin::Ms(0)));
        assert!(return_flag("never").is_err_and(|e| e.contains("none")));
    }
}
