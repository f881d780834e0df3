//! What is left to be said of each confirmed track; ended ones leave.

use super::labels;
use crate::flight_list::FlightList;
use crate::fusion::state::Tracker;
use crate::fusion::track_file::Stage;
use crate::time::SimTime;
use crate::track::{SystemTrack, TrackStatus};

impl Tracker {
    /// What is left to be said of each confirmed track, by number; ended tracks leave.
    pub(in crate::fusion) fn publish(
        &mut self,
        t_out: SimTime,
        flights: &FlightList,
        seen: &[u32],
        out: &mut [SystemTrack],
    ) {
        for (&index, shown) in seen.iter().zip(&mut *out) {
            let track = &mut self.tracks[index as usize];
            if track.name_refused >= NAME_DOUBTED {
                // What calls itself so is seen elsewhere.
                (shown.reported, shown.address) = (None, None);
                shown.label_p = Some(1.0 - labels::NAMED);
            } else {
                let own = track.callsign.is_some() || track.address.is_some();
                if !own && !track.updated && track.history & UNSEEN == 0 {
                    // Whoever it was has not been seen for some looks: nobody is called so for certain.
                    shown.assumed = track.entry.or(track.assumed);
                    shown.label_p = track.label_p.map(|p| p.min(labels::UNSEEN_P));
                } else {
                    (shown.track_type, shown.label) = labels::label(track.entry, flights);
                    (shown.assumed, shown.label_p) = (track.assumed, track.label_p);
                }
            }
            shown.status = match track.stage {
                Stage::Ended => TrackStatus::Last,
                _ if !track.updated && track.history & 1 == 0 => TrackStatus::Coasting,
                _ => TrackStatus::Confirmed,
            };
            (track.heading_rad, track.published) = (shown.heading_rad, true);
        }
        if !out.is_sorted_by_key(|track| track.number) {
            out.sort_by_cached_key(|track| track.number);
        }
        let mut ended = false;
        for track in &mut self.tracks {
            (track.updated, track.manoeuvre) = (false, false);
            (track.came_late, track.came_in_time) = (false, false);
            ended |= track.stage == Stage::Ended;
        }
        if !ended {
            return;
        }
        let (numbers, ring, labels) = (&mut self.numbers, &mut self.ring, &mut self.labels);
        let config = &self.config;
        self.tracks.retain_mut(|track| {
            if track.stage != Stage::Ended {
                return true;
            }
            if let Some(number) = track.number {
                numbers.give_back(number, t_out);
            }
            if let Some(entry) = track.entry {
                labels.rest(entry, t_out);
                if let Some(line) = flights.by_callsign(entry).filter(|_| track.evidence.is_event())
                {
                    labels.remember(&labels::likelihoods(track, line, flights, config, t_out));
                }
            }
            track.way.leave(ring);
            false
        });
    }
}

/// Expected updates in a row without a plot after which a label by evidence is only assumed: the target may have gone.
const UNSEEN: u32 = 0b111;

/// Refused plots in a row with a track's name after which the name is withheld.
const NAME_DOUBTED: u32 = 5;
