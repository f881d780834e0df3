//! The life of a run: one table; what is not in it is refused by name.

use serde::{Deserialize, Serialize};

/// Where the run stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Phase {
    /// Federates are joining.
    #[default]
    Init,
    /// Scene, seed and roster agreed; frame 0 not executed.
    Configured,
    /// Time is being granted.
    Running,
    /// Every federate has executed exactly the same frame and waits.
    Frozen,
    /// The run is closed.
    Stopped,
}

impl std::fmt::Display for Phase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Init => "INIT",
            Self::Configured => "CONFIGURED",
            Self::Running => "RUNNING",
            Self::Frozen => "FROZEN",
            Self::Stopped => "STOPPED",
        })
    }
}

/// What moves the run from phase to phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Transition {
    /// All expected federates have joined and are ready.
    Configure,
    /// Start, or resume after a freeze.
    Start,
    /// Stop granting time.
    Freeze,
    /// Close the run.
    Stop,
    /// Back to frame 0 of a new run of the same scene.
    Restart,
}

impl std::fmt::Display for Transition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Configure => "configure",
            Self::Start => "start",
            Self::Freeze => "freeze",
            Self::Stop => "stop",
            Self::Restart => "restart",
        })
    }
}

/// A transition that the present phase does not allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{transition}' is not possible while {phase}; possible now: {}", possible(*.phase))]
pub struct Refused {
    /// Where the run stands.
    pub phase: Phase,
    /// What was asked for.
    pub transition: Transition,
}

impl Phase {
    /// The phase after `transition`.
    ///
    /// # Errors
    /// [`Refused`] where the table has no entry.
    pub fn after(self, transition: Transition) -> Result<Self, Refused> {
        use {Phase as P, Transition as T};
        Ok(match (self, transition) {
            (P::Init, T::Configure) | (P::Configured | P::Frozen | P::Stopped, T::Restart) => {
                P::Configured
            }
            (P::Configured | P::Frozen, T::Start) => P::Running,
            (P::Running, T::Freeze) => P::Frozen,
            (P::Init | P::Configured | P::Running | P::Frozen, T::Stop) => P::Stopped,
            (phase, transition) => return Err(Refused { phase, transition }),
        })
    }
}

/// What an operator may ask in `phase`, in one list that every refusal gives.
#[must_use]
pub fn possible(phase: Phase) -> String {
    let transitions =
        [Transition::Start, Transition::Freeze, Transition::Stop, Transition::Restart];
    let mut names: Vec<_> =
        transitions.iter().filter(|&&t| phase.after(t).is_ok()).map(ToString::to_string).collect();
    if steps(phase) {
        names.insert(1, "step".to_owned());
    }
    names.push("rate".to_owned());
    names.join(", ")
}

/// Whether single frames may be executed in `phase`.
#[must_use]
pub fn steps(phase: Phase) -> bool {
    phase.after(Transition::Start).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Transition; 5] = [
        Transition::Configure,
        Transition::Start,
        Transition::Freeze,
        Transition::Stop,
        Transition::Restart,
    ];

    #[test]
    fn every_pair_is_decided_by_the_table() {
        let phases =
            [Phase::Init, Phase::Configured, Phase::Running, Phase::Frozen, Phase::Stopped];
        let mut table = String::new();
        for phase in phases {
            for transition in ALL {
                let after = phase.after(transition);
                table += &match after {
                    Ok(next) => format!("{phase} {transition} -> {next}\n"),
                    Err(refused) => format!("{phase} {transition}: {refused}\n"),
                };
            }
        }
        insta::assert_snapshot!(table);
    }
}
