//! The scans of the run, kept in the form that the page reads, for scrubbing back and for error curves.

use super::frame::{self, Noted, Trail};
use super::source::{self, CurvePoint, Event, EventFinder, ScanSums, Source};
use crate::runtime::messages::ScanReport;
use models::time::SimTime;
use serde_json::json;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// One scan as kept.
#[derive(Debug)]
struct Kept {
    scan: u64,
    time: SimTime,
    octets: Arc<[u8]>,
    tracks: Vec<KeptTrack>,
    plot_errors: Vec<(u64, &'static str, f32)>, // entity, kind of sensor, error in m
    explained: Vec<Explained>,
}

/// What every simulated effect did to a plot.
#[derive(Debug)]
struct Explained {
    track: Option<u16>,
    entity: Option<u64>,
    text: Box<str>, // JSON
}

#[derive(Debug)]
struct KeptTrack {
    number: u16,
    entity: Option<u64>,
    position_m: [f32; 2],
    error_m: Option<f32>,
    claimed_m: f32,
}

/// Scans in ascending order, the oldest dropped when the memory limit is reached.
#[derive(Debug)]
pub struct History {
    kept: VecDeque<Kept>,
    octets: usize,
    limit_octets: usize,
    dropped: u64,
    sums: Vec<ScanSums>,
    events: Vec<Event>,
    finder: EventFinder,
}

/// Dots of history drawn behind a track.
pub const TRAIL: usize = 30;
/// Events kept, at most.
const MOST_EVENTS: usize = 20_000;

impl History {
    /// An empty history that keeps at most about `limit_octets`.
    #[must_use]
    pub fn new(limit_octets: usize) -> Self {
        Self {
            kept: VecDeque::new(),
            octets: 0,
            limit_octets,
            dropped: 0,
            sums: Vec::new(),
            events: Vec::new(),
            finder: EventFinder::default(),
        }
    }

    /// Appends a scan and says whether it began the history anew, because it does not follow in time.
    pub fn push(&mut self, scan: &ScanReport) -> bool {
        self.push_noted(scan, &Noted::new())
    }

    /// The same with what is noted of its tracks.
    pub fn push_noted(&mut self, scan: &ScanReport, noted: &Noted) -> bool {
        let time = SimTime(scan.time_ns);
        let anew = self.kept.back().is_some_and(|last| scan.scan <= last.scan || time <= last.time);
        if anew {
            self.clear();
        }
        let key_of: BTreeMap<&str, u64> =
            scan.truth.iter().map(|t| (t.callsign.as_str(), frame::entity_key(t.id))).collect();
        let paired = frame::pairs(scan);
        let tracks = scan.tracks.iter().map(|t| {
            let truth = paired.get(&t.number);
            KeptTrack {
                number: t.number,
                entity: truth.map(|pair| frame::entity_key(scan.truth[pair.0].id)),
                position_m: t.position_m.map(|x| x as f32).into(),
                error_m: truth.map(|pair| pair.1 as f32),
                claimed_m: (t.cov_m2[0] + t.cov_m2[2]).sqrt() as f32,
            }
        });
        let plot_errors = scan.plots.iter().filter_map(|p| {
            let entity = key_of.get(p.cause.as_str())?;
            Some((*entity, p.kind.word, frame::plot_error_m(p)? as f32))
        });
        let explained = scan.plots.iter().filter(|p| !p.effects.is_empty()).map(|p| {
            let plot = json!({
                "sensor": p.sensor, "kind": p.kind.word, "time_s": SimTime(p.time_ns).s(),
                "scnr_db": p.scnr_db, "error_m": frame::plot_error_m(p), "track": p.track,
                "effects": p.effects,
            });
            let entity = key_of.get(p.cause.as_str()).copied();
            Explained { track: p.track, entity, text: plot.to_string().into() }
        });
        let kept = Kept {
            scan: scan.scan,
            time,
            octets: frame::encode_noted(scan, noted).into(),
            tracks: tracks.collect(),
            plot_errors: plot_errors.collect(),
            explained: explained.collect(),
        };
        self.sums.push(ScanSums::of(scan));
        for event in self.finder.scan(scan) {
            self.note(event);
        }
        self.octets += kept.cost();
        self.kept.push_back(kept);
        while self.octets > self.limit_octets && self.kept.len() > 1 {
            self.octets -= self.kept.pop_front().map_or(0, |old| old.cost());
            self.dropped += 1;
        }
        anew
    }

    /// Adds something that happened; of too much the oldest goes.
    pub fn note(&mut self, event: Event) {
        let at = self.events.partition_point(|e| e.time_ns <= event.time_ns);
        self.events.insert(at, event);
        if self.events.len() > MOST_EVENTS {
            self.events.remove(0);
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.kept.clear();
        self.sums.clear();
        self.events.clear();
        self.finder = EventFinder::default();
        self.octets = 0;
        self.dropped = 0;
    }

    fn index_at(&self, scan: u64) -> Option<usize> {
        if self.kept.is_empty() {
            return None;
        }
        Some(self.kept.partition_point(|k| k.scan <= scan).saturating_sub(1))
    }

    fn trails(&self, index: usize) -> Vec<Trail> {
        let mut trails: BTreeMap<u16, Vec<[f32; 2]>> =
            self.kept[index].tracks.iter().map(|t| (t.number, Vec::new())).collect();
        for kept in self.kept.range(index.saturating_sub(TRAIL)..index).rev() {
            for track in &kept.tracks {
                if let Some(points) = trails.get_mut(&track.number) {
                    points.push(track.position_m);
                }
            }
        }
        trails.into_iter().collect()
    }
}

impl Source for History {
    fn range(&self) -> Option<(u64, u64)> {
        Some((self.kept.front()?.scan, self.kept.back()?.scan))
    }

    fn times(&self) -> Option<(SimTime, SimTime)> {
        Some((self.kept.front()?.time, self.kept.back()?.time))
    }

    fn dropped(&self) -> u64 {
        self.dropped
    }

    fn nearest(&self, scan: u64) -> Option<u64> {
        Some(self.kept.get(self.index_at(scan)?)?.scan)
    }

    fn message(&self, scan: u64) -> Option<Vec<u8>> {
        let index = self.index_at(scan)?;
        let kept = &self.kept[index];
        Some(frame::with_trails(&kept.octets, index + 1 == self.kept.len(), &self.trails(index)))
    }

    fn curve(&self, number: u16, from: u64, upto: u64) -> Vec<CurvePoint> {
        let Some(end) = self.index_at(upto) else { return Vec::new() };
        let of = |kept: &Kept| kept.tracks.iter().position(|t| t.number == number);
        let entity = self
            .kept
            .range(..=end)
            .rev()
            .find_map(|kept| of(kept).and_then(|i| kept.tracks[i].entity));
        let points = self.kept.range(..=end).filter(|kept| kept.scan >= from).filter_map(|kept| {
            let track = &kept.tracks[of(kept)?];
            if entity.is_some() && track.entity.is_some() && track.entity != entity {
                return None;
            }
            let mut plots_m: BTreeMap<String, f32> = BTreeMap::new();
            for (_, kind, error_m) in kept.plot_errors.iter().filter(|p| Some(p.0) == entity) {
                let largest = plots_m.entry((*kind).to_owned()).or_insert(*error_m);
                *largest = largest.max(*error_m);
            }
            Some(CurvePoint {
                scan: kept.scan,
                time_s: kept.time.s(),
                error_m: track.error_m,
                claimed_m: track.claimed_m,
                plots_m,
            })
        });
        points.collect()
    }

    fn effects(&self, number: u16, scan: u64) -> Vec<String> {
        let Some(kept) = self.index_at(scan).map(|i| &self.kept[i]) else { return Vec::new() };
        let entity = kept.tracks.iter().find(|t| t.number == number).and_then(|t| t.entity);
        let of_it =
            |e: &&Explained| e.track == Some(number) || (entity.is_some() && e.entity == entity);
        kept.explained.iter().filter(of_it).map(|e| e.text.to_string()).collect()
    }

    fn at(&self, time: SimTime) -> Option<u64> {
        let kept = self.kept.front()?.time;
        source::at(&self.sums, time).filter(|_| time >= kept)
    }

    fn time_of(&self, scan: u64) -> Option<SimTime> {
        let kept = self.kept.get(self.index_at(scan)?)?;
        (kept.scan == scan).then_some(kept.time)
    }

    fn sums(&self) -> &[ScanSums] {
        &self.sums
    }

    fn events(&self) -> &[Event] {
        &self.events
    }
}

impl Kept {
    fn cost(&self) -> usize {
        size_of::<Self>()
            + self.octets.len()
            + self.tracks.len() * size_of::<KeptTrack>()
            + self.plot_errors.len() * size_of::<(u64, &'static str, f32)>()
            + self.explained.iter().map(|e| size_of::<Explained>() + e.text.len()).sum::<usize>()
    }
}
