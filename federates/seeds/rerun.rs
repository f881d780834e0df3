//! An SMDFM on a recording, as its scene says or with something changed on the way, into a log.

use super::replay::Recorded;
use crate::admin_station::summary::RunDigests;
use crate::exchange::flights::flight_notice;
use crate::runtime::codec::decode;
use crate::runtime::conductor::ClosedRun;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::messages::{FinalReport, Frame, Notice, RunConfig, ScanReport};
use crate::smdfm::Smdfm;
use crate::smdfm::change::{Amend, Anew};
use crate::viewer_logger::frame::Noted;
use crate::viewer_logger::log::Log;
use crate::viewer_logger::noted::Notes;
use crate::viewer_logger::picture::AirportMap;
use scenarios::Scene;
use std::sync::Arc;

/// What changes from a frame on.
pub(super) struct Stage {
    /// Last frame before it, a whole scan.
    pub(super) at: Frame,
    /// From when on its tracker runs along; none where the tracker stays.
    pub(super) warm_from: Option<Frame>,
    /// The scene from then on, with all changes before.
    pub(super) after: Arc<Scene>,
    pub(super) anew: Anew,
    pub(super) amend: Amend,
}

/// A recorded run that is made again.
pub(super) struct Rerun<'a> {
    pub(super) recorded: &'a Recorded,
    pub(super) scene: &'a Arc<Scene>,
    pub(super) exercise: u8,
    pub(super) seed: u64,
    /// Last frame.
    pub(super) last: Frame,
}

impl Rerun<'_> {
    /// Writes every scan, with the stages in their order; `noted` has what was noted of the tracks of a scan in the run that was recorded, where
    /// that still holds; `progress` is told each frame done and the last one.
    ///
    /// # Errors
    /// If a sensor cannot be made, the log refuses, or `progress` wants no more.
    pub(super) fn write_log(
        &self,
        stages: &[Stage],
        log: &mut Log,
        noted: impl Fn(u64) -> Option<Noted>,
        mut progress: impl FnMut(Frame, Frame) -> anyhow::Result<()>,
    ) -> anyhow::Result<RunDigests> {
        let &Self { recorded, scene, exercise, seed, last } = self;
        let mut smdfm = Smdfm::new(Arc::clone(scene), exercise).explaining(true);
        let period = smdfm.period();
        let config =
            RunConfig { run: 1, seed, generators: 1, last_frame: last, ..RunConfig::default() };
        smdfm.configure(&config, &mut FrameOut::default()).map_err(anyhow::Error::msg)?;
        let flights = scene.flight_list.entries.iter().map(flight_notice).collect();
        let mut notices = vec![(0, Notice::Flights(flights))];
        let mut notes = Notes::of(&AirportMap::of(scene));
        for scan in 1..=last / period {
            let frame = scan * period;
            for stage in stages {
                if stage.warm_from.is_some_and(|from| frame == from + period) {
                    smdfm.warm_up(&stage.after);
                }
                if frame == stage.at + period {
                    smdfm
                        .change(&stage.after, &stage.anew, stage.amend.clone())
                        .map_err(anyhow::Error::msg)?;
                }
            }
            let inputs = FrameInputs {
                notices: std::mem::take(&mut notices),
                pdus: recorded.pdus(frame - period + u64::from(scan > 1)..=frame),
                ..FrameInputs::default()
            };
            let mut made = FrameOut::default();
            smdfm.step(frame, &inputs, &mut made);
            for publication in &made.publish {
                if publication.key == "tracks/1/scan" {
                    let report: ScanReport = decode(&publication.body)?;
                    let derived = notes.scan(&report);
                    log.scan_noted(&report, &noted(report.scan).unwrap_or(derived))?;
                }
            }
            progress(frame, last)?;
        }
        let mut report = FinalReport { run: 1, name: "smdfm".into(), ..FinalReport::default() };
        smdfm.finish(&mut report);
        let reports = recorded.producers(last).into_iter().chain([report]).collect();
        Ok(RunDigests::of(&ClosedRun {
            run: 1,
            seed,
            frame: last,
            reports,
            ..ClosedRun::default()
        }))
    }
}
