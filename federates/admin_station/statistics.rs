//! What the station knows of the federation's measures: told to whoever asks, and shown by `status`, page and screen.

use crate::runtime::messages::{FederateStatus, RunState};
use serde::Serialize;
use std::collections::BTreeMap;

/// Statistics of the whole federation, as `seeds admin-station status` and the page show them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Statistics {
    /// How the run stands.
    pub state: RunState,
    /// Application measures of the last scan: plots, tracks, Pd, errors.
    pub measures: BTreeMap<String, f64>,
    /// Measures of traffic that behaves, from truth, by name and unit, as they stood within the last ten scans; absent where none does.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub traffic: BTreeMap<String, f64>,
    /// System statistics of each federate.
    pub federates: BTreeMap<String, FederateStatus>,
    /// How far the clock of each other host is ahead of the station's, s.
    pub clocks: BTreeMap<String, f64>,
}

impl Statistics {
    /// Takes what a federate says of itself. Anybody on the bus may say a name: only those that have joined are kept.
    pub(super) fn hear(&mut self, status: FederateStatus) {
        if self.state.members.iter().any(|m| m.name == status.name) {
            let before = self.federates.get(&status.name).map_or(&[][..], |s| &s.alarms);
            for alarm in status.alarms.iter().filter(|a| !before.contains(a)) {
                // A federate of this host has said it to the same terminal.
                if status.host != crate::runtime::process::host_name() {
                    tracing::warn!("{} on {} {alarm}", status.name, status.host);
                }
            }
            self.federates.insert(status.name.clone(), status);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::MemberState;

    #[test]
    fn two_hundred_thousand_names_that_never_joined_are_not_kept() {
        let member = MemberState { name: "smdfm".to_owned(), ..MemberState::default() };
        let state = RunState { members: vec![member], ..RunState::default() };
        let mut statistics = Statistics { state, ..Statistics::default() };
        for n in 0..200_000 {
            let name = format!("forged-{n}");
            statistics.hear(FederateStatus { name, ..FederateStatus::default() });
        }
        statistics.hear(FederateStatus { name: "smdfm".to_owned(), ..FederateStatus::default() });
        assert_eq!(statistics.federates.keys().collect::<Vec<_>>(), ["smdfm"]);
    }
}
