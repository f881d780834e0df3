//! The quickest way among reservations of points: time windows.
//!
//! Source: Gawrilow and others 2008, QPPTW; states are (zone, free window). Movers are
//! points here; the form for movers with a length, which the planned policy needs, does not exist yet.

use std::collections::BTreeSet;

/// Reservations of a zone: half-open intervals `[begin, end)`, sorted.
pub type Busy = Vec<(f64, f64)>;

/// Free windows `[begin, end)` between reservations that may overlap each other.
#[must_use]
pub fn free_windows(busy: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted = busy.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = Vec::with_capacity(sorted.len() + 1);
    let mut from = f64::NEG_INFINITY;
    for (begin, end) in sorted {
        if begin > from {
            free.push((from, begin));
        }
        from = from.max(end);
    }
    free.push((from, f64::INFINITY));
    free
}

/// Earliest entry into `to`, s, from `from` at time 0: a zone is used from entry to leaving, at least
/// `passage_s`, within one free window of it; the next one is entered at the moment of leaving. `None`
/// if there is no way before `horizon_s`.
#[must_use]
pub fn earliest_arrival_s(
    passage_s: &[f64],
    next: &[Vec<usize>],
    busy: &[Busy],
    from: usize,
    to: usize,
    horizon_s: f64,
) -> Option<f64> {
    let windows: Vec<Vec<(f64, f64)>> = busy.iter().map(|b| free_windows(b)).collect();
    // Of two entries into one window the earlier can do everything that the later one can.
    let mut entered: Vec<Vec<bool>> = windows.iter().map(|w| vec![false; w.len()]).collect();
    let mut open = BTreeSet::new();
    let first = windows.get(from)?.iter().position(|w| w.0 <= 0.0 && 0.0 < w.1)?;
    open.insert((0.0_f64.to_bits(), from, first));
    while let Some((bits, zone, window)) = open.pop_first() {
        let at = f64::from_bits(bits);
        if at > horizon_s {
            return None;
        }
        if std::mem::replace(&mut entered[zone][window], true) {
            continue;
        }
        let ready = at + passage_s[zone];
        let until = windows[zone][window].1;
        if zone == to && ready <= until {
            return Some(at);
        }
        for z in &next[zone] {
            for (index, (begin, end)) in windows[*z].iter().enumerate() {
                let entry = ready.max(*begin);
                if entry <= until && entry + passage_s[*z] <= *end && !entered[*z][index] {
                    open.insert((entry.to_bits(), *z, index));
                }
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_half_open() {
        let windows = free_windows(&[(5.0, 8.0), (0.0, 5.0), (7.0, 9.0)]);
        assert_eq!(windows, [(f64::NEG_INFINITY, 0.0), (9.0, f64::INFINITY)]);
        // Enters at the moment at which the other leaves.
        let busy = [vec![], vec![(0.0, 10.0)]];
        let found = earliest_arrival_s(&[1.0, 1.0], &[vec![1], vec![]], &busy, 0, 1, 600.0);
        assert_eq!(found, Some(10.0));
    }
}
