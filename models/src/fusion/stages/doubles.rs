//! Tracks that follow another part of a target that already has a track.
//!
//! Two tracks near each other that move alike are one target with two echoes, or two targets. What tells them apart is how
//! they began and how they are seen. A second echo has been beside the first from its first report on
//! ([`Companion`]); what was somewhere else before is a target of its own. And a look of one sensor that brings both of them a
//! plot each speaks for two, one that brings a single plot for both for one: ln of the ratio of both is added up look by look
//! ([`Twin`]), from a prior of one in fifty; the younger ends at nineteen in twenty. On a body whose size is known (its type,
//! or the cells it lights) two echoes are what is to be expected, and every look speaks for one target.
//!
//! Source: sequential test of two hypotheses (Wald, "Sequential tests of statistical hypotheses", 1945); the chances are
//! assumed.

use crate::frames::{Point2, Vector2};
use crate::fusion::config::TrackingConfig;
use crate::fusion::size;
use crate::fusion::state::{Statistics, Work};
use crate::fusion::track_file::{Companion, Stage, Track, Twin};
use crate::time::SimTime;
use crate::track::SystemTrack;

/// Tracks beside one that are looked at.
const NEIGHBOURS: usize = 64;

/// ln of the odds of one target, for a track that was there from its first report on: one in fifty.
const BORN_BESIDE: f64 = -3.9;
/// The same for one that was somewhere else before; no other evidence takes it lower.
const CAME_FROM_ELSEWHERE: f64 = -12.0;
/// ln of the odds at which the younger ends: nineteen in twenty.
const ONE_TARGET: f64 = 2.94;
/// Both had a plot of their own: a body of unknown size splits in half of the looks, two targets are both seen in nine of ten.
const SEEN_APART: f64 = -0.6;
/// One plot for both, or for one of them: half of the looks at one target, one in ten at two.
const SEEN_AS_ONE: f64 = 1.6;
/// A look at two echoes on a body that is known to hold both: three in a row end the younger.
const ON_KNOWN_BODY: f64 = (ONE_TARGET - BORN_BESIDE) / 3.0 + 1e-9;

/// Nobody farther off than this when a track begins can be the same target, m.
const COMPANION_M: f64 = 100.0;
/// Two plots of one body may be so much farther apart than the body is long, m.
const PLOTS_M: f64 = 5.0;

/// Ends tracks that follow another part of a target that already has a track.
pub(in crate::fusion) fn merge_duplicates(
    tracks: &mut [Track],
    shown: &[SystemTrack],
    scan: (Option<SimTime>, &TrackingConfig),
    work: &mut Work,
    statistics: &mut Statistics,
) {
    let Work { seen, positions, plots: grid, near, .. } = work;
    let (since, config) = scan;
    positions.clear();
    positions.extend(shown.iter().map(|s| s.position_m));
    let named = |track: &Track| track.callsign.is_some() || track.address.is_some();
    let mut reach = config.duplicate_radius_m;
    for track in seen.iter().map(|&s| &tracks[s as usize]) {
        if let Some((length, span)) = track.size_m.or_else(|| track.extent.size_m()) {
            reach = reach.max(libm::hypot(ALONG * length, ASIDE * span));
        }
        if named(track) {
            reach = reach.max(NAMESAKES_M);
        }
    }
    if !(reach > 0.0) {
        return;
    }
    grid.fill(positions, reach);
    for young in 0..seen.len() {
        accompany(young, tracks, shown, seen, positions, |low, high, visit| {
            grid.visit_near(low, high, NEIGHBOURS, near, visit);
        });
    }
    let around = Vector2::repeat(reach);
    for young in 0..seen.len() {
        let position = positions[young];
        // Mostly nobody else is there: it finds only itself.
        let mut there = 0;
        let (low, high) = (position - around, position + around);
        grid.visit_near(low, high, NEIGHBOURS, near, |old| {
            let offset = positions[old] - position;
            there += u32::from(offset.x.abs() <= reach) & u32::from(offset.y.abs() <= reach);
        });
        let candidate = &mut tracks[seen[young] as usize];
        if there <= 1 || candidate.unresolved {
            candidate.twin = None;
            continue;
        }
        let candidate = &tracks[seen[young] as usize];
        if candidate.stage != Stage::Confirmed {
            continue;
        }
        let nameless = candidate.entry.is_none() && !named(candidate);
        let velocity = shown[young].velocity_mps;
        let alike = 2.0 + 0.1 * velocity.norm();
        let mut twin: Option<(u64, usize)> = None;
        grid.visit_near(low, high, NEIGHBOURS, near, |old| {
            let offset = positions[old] - position;
            if old == young || offset.x.abs() > reach || offset.y.abs() > reach {
                return;
            }
            let other = &tracks[seen[old] as usize];
            // A track with a name of its own is a target of its own, unless that one was heard no more before the other began on it.
            let double = if has_another_name(candidate, other, shown[young].time) {
                (shown[old].velocity_mps - velocity).norm() < alike
                    && on_body(other, positions[old], position, config.duplicate_radius_m)
            } else if nameless {
                (other.serial < candidate.serial || other.entry.is_some())
                    && (shown[old].velocity_mps - velocity).norm() < alike
                    && on_body(other, positions[old], position, config.duplicate_radius_m)
            } else {
                other.serial < candidate.serial
                    && same_name(candidate, other)
                    && (positions[old] - position).norm() <= NAMESAKES_M
            };
            if other.stage == Stage::Confirmed && double {
                twin = Some(twin.map_or((other.serial, old), |s| s.min((other.serial, old))));
            }
        });
        let Some((serial, old)) = twin else {
            tracks[seen[young] as usize].twin = None;
            continue;
        };
        let other = &tracks[seen[old] as usize];
        let beside = !nameless || beside(candidate, other);
        let renamed = has_another_name(candidate, other, shown[young].time);
        let known =
            !(nameless || renamed) || other.size_m.or_else(|| other.extent.size_m()).is_some();
        let prior = if beside { BORN_BESIDE } else { CAME_FROM_ELSEWHERE };
        let before = candidate.twin.filter(|before| before.serial == serial);
        // A name is no second echo: who is seen apart from the one before is another one.
        let said =
            if beside && known && !renamed { ON_KNOWN_BODY } else { look(candidate, other, since) };
        let odds = (before.map_or(prior, |before| before.odds) + said).max(CAME_FROM_ELSEWHERE);
        tracks[seen[young] as usize].twin = Some(Twin { serial, odds });
        if odds < ONE_TARGET {
            continue;
        }
        statistics.merged += 1;
        if renamed
            && let Ok([mine, theirs]) =
                tracks.get_disjoint_mut([seen[young] as usize, seen[old] as usize])
        {
            // The elder goes on, by the name that is heard now.
            mine.take_name_of(theirs);
            mine.limits = config.limits_of(None);
            (mine.twin, theirs.stage) = (None, Stage::Ended);
        } else {
            tracks[seen[young] as usize].stage = Stage::Ended;
        }
    }
}

/// Who was near when a track began, and how far off that one has been since.
fn accompany(
    young: usize,
    tracks: &mut [Track],
    shown: &[SystemTrack],
    seen: &[u32],
    positions: &[Point2<f64>],
    visit_near: impl FnOnce(Point2<f64>, Point2<f64>, &mut dyn FnMut(usize)),
) {
    let position = positions[young];
    if shown[young].first {
        let around = Vector2::repeat(COMPANION_M);
        let mut nearest: Option<(f64, usize)> = None;
        visit_near(position - around, position + around, &mut |old| {
            let off = (positions[old] - position).norm();
            if old != young && off <= COMPANION_M && nearest.is_none_or(|n| (off, old) < n) {
                nearest = Some((off, old));
            }
        });
        tracks[seen[young] as usize].companion = nearest.map(|(off, old)| Companion {
            serial: tracks[seen[old] as usize].serial,
            farthest_m: off,
        });
        return;
    }
    let Some(companion) = tracks[seen[young] as usize].companion else { return };
    // Tracks lie in the order of their births.
    let place = seen.partition_point(|&s| tracks[s as usize].serial < companion.serial);
    let there = seen.get(place).filter(|&&s| tracks[s as usize].serial == companion.serial);
    tracks[seen[young] as usize].companion = there.map(|_| Companion {
        farthest_m: companion.farthest_m.max((positions[place] - position).norm()),
        ..companion
    });
}

/// Whether one of two tracks has been on the body of the other (or nearer than two targets are told apart) ever since it
/// began.
fn beside(a: &Track, b: &Track) -> bool {
    let reach = |track: &Track| match track.size_m.or_else(|| track.extent.size_m()) {
        Some((length, span)) => libm::hypot(ALONG * length, ASIDE * span),
        None => 0.0,
    };
    let most = reach(a).max(reach(b)).max(UNKNOWN_M) + PLOTS_M;
    let kept = |track: &Track, of: &Track| {
        track.companion.is_some_and(|c| c.serial == of.serial && c.farthest_m <= most)
    };
    kept(a, b) || kept(b, a)
}

/// What the looks of this scan say: ln of the chance at one target over that at two.
fn look(candidate: &Track, other: &Track, since: Option<SimTime>) -> f64 {
    let new = |track: &Track| {
        let fresh = move |at: SimTime| since.is_none_or(|since| at > since);
        track.updated_by.iter().filter(move |by| fresh(by.time)).copied().collect::<Vec<_>>()
    };
    let (own, others) = (new(candidate), new(other));
    let apart = own.iter().any(|by| {
        let same = others.iter().find(|o| o.sensor == by.sensor);
        same.is_some_and(|o| (o.time, o.sequence) != (by.time, by.sequence))
    });
    match (own.is_empty() && others.is_empty(), apart) {
        (true, _) => 0.0,
        (_, true) => SEEN_APART,
        _ => SEEN_AS_ONE,
    }
}

/// Whether a target calls itself otherwise by now: `other` began on it with a name when the one of `track` was heard no more.
fn has_another_name(track: &Track, other: &Track, now: SimTime) -> bool {
    let named = |track: &Track| track.callsign.is_some() || track.address.is_some();
    let silent_s = SILENT * track.named_every_s;
    named(track)
        && named(other)
        && track.serial < other.serial
        && !same_name(track, other)
        && track.named_at < other.born
        && now.since_s(track.named_at) > silent_s
        && now.since_s(other.named_at) <= SILENT * other.named_every_s
        && beside(track, other)
}

/// A name that has not been heard for so many of its intervals is heard no more (assumed).
const SILENT: f64 = 10.0;

/// Two tracks of one name this near are one target, m.
const NAMESAKES_M: f64 = 60.0;

/// Whether both were called the same by their plots.
fn same_name(a: &Track, b: &Track) -> bool {
    (a.callsign.is_some() && a.callsign == b.callsign)
        || (a.address.is_some() && a.address == b.address)
}

/// The track follows some part of the target, so another part is almost a length away.
const ALONG: f64 = 0.9;
/// The same across, of the span.
const ASIDE: f64 = 0.6;

/// How far from the middle of a target of unknown type another echo of it may lie, m: what its echoes show of its size, and
/// the errors of two plots. Two small aircraft parked ten metres apart are two.
fn reach_of_body_m(track: &Track) -> f64 {
    match track.spread.variance_m2() {
        Some((seen_m2, triples)) if triples >= size::FEWEST_TRIPLES => {
            0.75 * size::diagonal_m(1.3 * seen_m2) + BESIDE_M
        }
        _ => f64::INFINITY,
    }
}

/// A body of unknown size is taken to be at least this long, m.
const UNKNOWN_M: f64 = 12.0;

/// Two plots of one point are no farther apart than this, m.
const BESIDE_M: f64 = 2.0;

/// Whether `point_m` lies on the body of `track` (its type known) or within `radius_m` of it.
pub(in crate::fusion) fn on_body(
    track: &Track,
    position_m: Point2<f64>,
    point_m: Point2<f64>,
    radius_m: f64,
) -> bool {
    let offset = point_m - position_m;
    let (length, span, beside) = match (track.size_m, track.extent.size_m()) {
        (Some((length, span)), _) => (length, span, 0.0),
        // As the cells show it, with the errors of two plots: a box where the course is known, else all round.
        (None, Some((length, width))) if track.course.is_some() => (length, width, BESIDE_M),
        (None, Some((length, _))) => return offset.norm() <= ALONG * length + BESIDE_M,
        (None, None) => return offset.norm() <= radius_m.min(reach_of_body_m(track)),
    };
    let (sin, cos) = libm::sincos(track.heading_rad);
    let along = offset.x * sin + offset.y * cos;
    let aside = offset.x * cos - offset.y * sin;
    along.abs() <= ALONG * length + beside && aside.abs() <= ASIDE * span + beside
}
