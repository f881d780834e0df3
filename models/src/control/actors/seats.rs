//! Which seats an airport has: one for the apron, one for the ground, a tower for each group of runways that cross.

use super::message::Seat;
use crate::traffic::network::Network;
use std::collections::BTreeSet;

/// Of each runway, those that share a node with it, itself among them.
#[must_use]
pub(crate) fn crossings(net: &Network) -> Vec<Vec<usize>> {
    let count = net.runways.len();
    let shared = |a: usize, b: usize| {
        let spine = |r: usize| net.runways[r].spine.iter().map(|(_, n)| *n);
        a == b || spine(a).any(|n| spine(b).any(|m| m == n))
    };
    (0..count).map(|a| (0..count).filter(|b| shared(a, *b)).collect()).collect()
}

/// Group of a runway: the first of those that cross it.
pub(crate) fn group_of(crossing: &[Vec<usize>], runway: usize) -> u8 {
    crossing[runway].first().copied().unwrap_or(runway).min(255) as u8
}

/// Group of the runway that has an end of this name; 0 where none has.
#[must_use]
pub fn group_named(net: &Network, name: &str) -> u8 {
    let named = |r: &crate::traffic::network::NetRunway| r.names.iter().any(|n| n == name);
    net.runways.iter().position(named).map_or(0, |r| group_of(&crossings(net), r))
}

/// The seats of an airport's controllers.
#[must_use]
pub fn seats(net: &Network) -> Vec<Seat> {
    let crossing = crossings(net);
    let towers: BTreeSet<u8> = (0..crossing.len()).map(|r| group_of(&crossing, r)).collect();
    [Seat::Apron, Seat::Ground].into_iter().chain(towers.into_iter().map(Seat::Tower)).collect()
}
