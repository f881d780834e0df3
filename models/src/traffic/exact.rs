//! The safety net on exact truth: the reference that tracks are scored against.
//!
//! Exact positions of a core's movers in the form of tracks, its clearances on a board, once a scan.

use super::core::{Core, Direction};
use super::network::code_of_span;
use crate::control::alert::{Alert, Change};
use crate::control::clearance::{Board, Clearance, ClearanceKind};
use crate::control::layout::{Area, Layout, StopBar};
use crate::control::lights::{self, Failed};
use crate::control::parameters::Parameters;
use crate::control::safety_net::{SafetyNet, Scan};
use crate::control::situation::{Target, TargetClass};
use crate::control::widths::{runway_is_narrow, way_is_narrow};
use crate::frames::{Point2, Vector2};
use crate::plot::Callsign;
use crate::time::SimTime;
use crate::truth::TruthState;
use std::collections::BTreeMap;

/// Tracks that a safety net watches at a time.
const MOST_TARGETS: usize = 4096;

/// A safety net that watches a core.
#[derive(Clone, Debug)]
pub struct Watch {
    net: SafetyNet,
    board: Board,
    numbers: Numbers,
    /// Clearances taken so far, and those of them that still stand.
    taken: usize,
    open: Vec<usize>,
    bars: Vec<StopBar>,
    areas: Vec<Area>,
    /// Visibility from a time on, m, in the order of time; before the first it is clear.
    visibility_m: Vec<(SimTime, f64)>,
}

impl Watch {
    /// A watch over an airport; `with_bars`: its stop bars are in use.
    #[must_use]
    pub fn new(layout: Layout, parameters: Parameters, with_bars: bool) -> Self {
        let bars = if with_bars { layout.bars.clone() } else { Vec::new() };
        let areas = layout.areas.clone();
        let net = SafetyNet::new(layout, parameters);
        let (board, numbers) = (Board::default(), Numbers::default());
        let (open, visibility_m) = (Vec::new(), Vec::new());
        Self { net, board, numbers, taken: 0, open, bars, areas, visibility_m }
    }

    /// The same in a weather: visibility from a time on, m, in the order of time.
    #[must_use]
    pub fn in_visibility(self, visibility_m: Vec<(SimTime, f64)>) -> Self {
        Self { visibility_m, ..self }
    }

    /// The net.
    #[must_use]
    pub fn net(&self) -> &SafetyNet {
        &self.net
    }

    /// The clearances, as of the last scan.
    #[must_use]
    pub fn board(&self) -> &Board {
        &self.board
    }

    /// Judges the core as it stands at `now`, on its exact truth.
    pub fn scan(&mut self, core: &Core, now: SimTime) -> &[(Change, Alert)] {
        let targets = self.numbers.targets(core, now);
        self.scan_targets(core, now, &targets)
    }

    /// Judges tracks of a core's movers, sorted by number, with the core's clearances.
    pub fn scan_targets(
        &mut self,
        core: &Core,
        now: SimTime,
        targets: &[Target],
    ) -> &[(Change, Alert)] {
        for (index, c) in core.clearances().iter().enumerate().skip(self.taken) {
            self.open.push(index);
            let Some(kind) = ClearanceKind::of(c.kind) else { continue };
            let callsign = Callsign::new(&core.flights()[c.flight].callsign);
            self.board.give(Clearance {
                callsign,
                kind,
                runway: self.net.layout().runway(&c.runway),
                place_m: c.place_m,
                from: SimTime::from_s(c.from_s),
                until: None,
            });
            if let Some(strip) = self.board.strip(callsign) {
                let way = core.cleared_way_m(c.flight);
                if kind == ClearanceKind::Taxi && strip.way_m.len() != way.len() {
                    strip.way_m = way.to_vec();
                }
                if matches!(kind, ClearanceKind::Taxi | ClearanceKind::Land) {
                    let way = if kind == ClearanceKind::Taxi { way } else { &[] };
                    let (network, flight) = (core.network(), &core.flights()[c.flight]);
                    let code = code_of_span(flight.size.span_m);
                    let name = &network.runways[flight.runway.0].names[flight.runway.1];
                    let axis = self.net.layout().runway(name).map(|r| r.0);
                    let axis = axis.and_then(|r| self.net.layout().runways.get(r));
                    strip.too_small = axis.is_some_and(|axis| runway_is_narrow(axis, code))
                        || way_is_narrow(network, code, way);
                }
            }
        }
        self.taken = core.clearances().len();
        self.board.advance(now);
        let board = &mut self.board;
        self.open.retain(|index| {
            let c = &core.clearances()[*index];
            let (Some(until_s), Some(kind)) = (c.until_s, ClearanceKind::of(c.kind)) else {
                return true;
            };
            let runway = self.net.layout().runway(&c.runway).map(|r| r.0);
            let callsign = Callsign::new(&core.flights()[c.flight].callsign);
            board.end(callsign, kind, runway, SimTime::from_s(until_s));
            false
        });
        self.board.advance(now);
        for (number, flight) in core.flights().iter().enumerate() {
            let callsign = Callsign::new(&flight.callsign);
            // Who was never there needs no strip.
            if self.board.find(callsign).is_none() && core.state(number).is_none() {
                continue;
            }
            let at_m = core.stand_m(core.stand(number));
            if let Some(strip) = self.board.strip(callsign) {
                strip.stand_m = Some(at_m);
            }
        }
        let failed: Vec<Failed> = core
            .failed_bars()
            .filter_map(|bars| Failed::of(self.net.layout(), &bars.runway, bars.lit))
            .collect();
        lights::switch(
            &mut self.bars,
            &failed,
            now,
            self.net.layout(),
            &self.board,
            self.net.surveillance(),
        );
        let at = self.visibility_m.partition_point(|(from, _)| *from <= now);
        let visibility_m = at.checked_sub(1).map_or(f64::INFINITY, |at| self.visibility_m[at].1);
        let low_visibility = self.net.parameters().is_low(visibility_m);
        self.net.scan(&Scan {
            now,
            targets,
            board: &self.board,
            bars: &self.bars,
            areas: &self.areas,
            low_visibility,
        })
    }
}

/// The movers of a core as tracks without error, in the order of their numbers: those of a scan alone (see [`Numbers`]).
#[must_use]
pub fn targets(core: &Core, now: SimTime) -> Vec<Target> {
    Numbers::default().targets(core, now)
}

/// Track numbers, 0 to 4095, of the movers of a core that are there: each keeps its own from scan to scan. A mover's index is its
/// number where that is one and free.
#[derive(Clone, Debug, Default)]
pub struct Numbers {
    of: BTreeMap<usize, u16>,
    /// Who had a number last.
    last: BTreeMap<u16, usize>,
}

impl Numbers {
    /// The movers of a core as tracks without error, in the order of their numbers; of more than there are numbers those with the least
    /// indices.
    pub fn targets(&mut self, core: &Core, now: SimTime) -> Vec<Target> {
        let flights = core.flights().len();
        let vehicles = (flights..).take_while(|n| core.vehicle_name(*n).is_some());
        let states = (0..flights).chain(vehicles).filter_map(|n| Some((n, core.state(n)?)));
        let there: BTreeMap<usize, TruthState> = states.collect();
        self.of.retain(|n, _| there.contains_key(n));
        let mut taken = [false; MOST_TARGETS];
        self.of.values().for_each(|number| taken[usize::from(*number)] = true);
        let (mut targets, mut spare) = (Vec::new(), MOST_TARGETS);
        for (n, state) in there {
            let own = self.of.get(&n).copied().or_else(|| {
                let free = match n < MOST_TARGETS && !taken[n] {
                    true => Some(n),
                    false => {
                        let free = taken[..spare].iter().rposition(|taken| !taken);
                        spare = free.unwrap_or(0);
                        free
                    }
                }?;
                taken[free] = true;
                Some(free as u16)
            });
            let Some(number) = own else { continue };
            self.of.insert(n, number);
            let before = self.last.insert(number, n);
            let flight = core.flights().get(n);
            let callsign = match flight {
                Some(flight) => &flight.callsign,
                None => core.vehicle_name(n).unwrap_or_default(),
            };
            let drives = flight.is_none_or(|f| f.direction == Direction::Vehicle);
            targets.push(Target {
                number,
                callsign: Some(Callsign::new(callsign)),
                class: if drives { TargetClass::Vehicle } else { TargetClass::Aircraft },
                arriving: flight.is_some_and(|f| f.direction == Direction::Arrival),
                length_m: flight.map_or(4.6, |f| f.size.length_m),
                position_m: Point2::new(state.position_m.x, state.position_m.y),
                velocity_mps: Vector2::new(state.velocity_mps.x, state.velocity_mps.y),
                altitude_m: Some(state.position_m.z),
                last_plot: now,
                // What is remembered of a number is of somebody else.
                first: before.is_some_and(|before| before != n),
            });
        }
        targets.sort_by_key(|target| target.number);
        targets
    }
}
