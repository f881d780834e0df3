//! The A-SMGCS functions of an airport: system tracks and clearances in, control alerts out, once a scan.
//!
//! It sees tracks only: those that the SMDFM tells in its frame ends, with the clearances that the generators tell in
//! theirs. It takes no PDU in, so a run gives the same alerts in every layout.

mod advice_words;
pub mod command;
mod look_ahead;
mod people;
mod seats;
mod standing;

use crate::exchange::control_records::{Light, Lights, Teller};
use crate::exchange::driven;
use crate::exchange::flights::flight_list;
use crate::exchange::repeated::Repeated;
use crate::exchange::seats::{seat_facts, seat_values};
use crate::exchange::weather_notice::day_of;
use crate::federation::{closes_loop, is_front_end, loop_frames, on_tracks};
use crate::runtime::bus::Class;
use crate::runtime::codec::encode;
use crate::runtime::digest::Digest;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut, Publication};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{
    AlertMessage, ClearanceNotice, FederateStatus, FinalReport, Frame, HANDOVER_SEAT, Kind, Notice,
    RunConfig, SeatMessage, TrackNotice,
};
use models::control::alert::{Alert, Change};
use models::control::clearance::{Board, Clearance, ClearanceKind};
use models::control::layout::{Area, Layout, RunwayAxis, StopBar};
use models::control::lights::{self, Failed, FailedBars};
use models::control::parameters::Parameters;
use models::control::safety_net::{SafetyNet, Scan};
use models::control::situation::{Target, TargetClass};
use models::control::widths::{runway_is_narrow, way_is_narrow};
use models::flight_list::{FlightList, MovementKind};
use models::frames::{Point2, Vector2};
use models::plot::Callsign;
use models::time::SimTime;
use models::traffic::network::{Network, code_of_span};
use scenarios::Scene;
use seats::Seats;
use serde_json::json;
use standing::Standing;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The federate's logic.
pub struct Control {
    scene: Arc<Scene>,
    time: FrameTime,
    run: u32,
    net: SafetyNet,
    board: Board,
    bars: Vec<StopBar>,
    /// Bars that fail in this run, which their monitors tell.
    failed_bars: Vec<FailedBars>,
    tracks: Vec<TrackNotice>,
    areas: Vec<Area>,
    /// Of the weather that was told last, m.
    visibility_m: f64,
    flights: FlightList,
    digest: Digest,
    raised: BTreeMap<String, u64>,
    /// All lights of the runways as they were told last, and when those who hear DIS were, s.
    lights_told: Option<(Vec<Light>, f64)>,
    teller: Teller,
    /// Controllers' seats, where they clear.
    seats: Option<Seats>,
    alerts: Repeated<AlertMessage>,
    standing: Standing,
    seat_events: Repeated<SeatMessage>,
}

fn net_of(scene: &Scene) -> SafetyNet {
    let mut layout = Layout::of(&scene.airport.layout);
    layout = match &scene.traffic.behaving {
        Some(behaving) => layout.with_network(&behaving.network),
        None => layout.with_network(&Network::of(&scene.airport.layout)),
    };
    let control = &scene.control;
    let parameters = Parameters {
        confirm_scans: control.confirm_scans,
        strip_margin_m: control.strip_margin_m,
        bar_margin_m: control.bar_margin_m,
        ..Parameters::on_tracks()
    };
    SafetyNet::new(layout, parameters)
}

impl Control {
    /// The control of a scene's airport.
    #[must_use]
    pub fn new(scene: Arc<Scene>, exercise: u8) -> Self {
        let net = net_of(&scene);
        Self {
            time: FrameTime::of(&scene.run),
            run: 0,
            bars: net.layout().bars.clone(),
            failed_bars: Vec::new(),
            board: Board::default(),
            tracks: Vec::new(),
            areas: net.layout().areas.clone(),
            visibility_m: f64::INFINITY,
            flights: FlightList::default(),
            digest: Digest::default(),
            raised: BTreeMap::new(),
            lights_told: None,
            teller: Teller { exercise, site: scene.run.site },
            seats: None,
            alerts: Repeated::default(),
            standing: Standing::default(),
            seat_events: Repeated::default(),
            net,
            scene,
        }
    }

    fn take_in(&mut self, inputs: &FrameInputs) {
        for (effect, notice) in &inputs.notices {
            match notice {
                Notice::Flights(flights) => {
                    self.flights = flight_list(flights, self.scene.flight_list.runways.clone());
                    for entry in &self.flights.entries {
                        if let Some(strip) = self.board.strip(entry.callsign) {
                            strip.stand_m = entry.stand_m;
                        }
                    }
                }
                Notice::Tracks(tracks) => self.tracks.clone_from(tracks),
                Notice::Clearances(clearances) => clearances.iter().for_each(|c| self.clear(c)),
                Notice::Stands(stands) => {
                    for told in stands {
                        if let Some(strip) = self.board.strip(Callsign::new(&told.callsign)) {
                            strip.stand_m = Some(told.stand_m);
                        }
                    }
                }
                Notice::Weather(weather) => {
                    self.visibility_m = weather.visibility_m;
                    if let Some(seats) = &mut self.seats {
                        seats.weather(day_of(weather));
                    }
                }
                Notice::Wants { share, wants } => {
                    if let Some(seats) = &mut self.seats {
                        seats.take(*share, wants);
                    }
                }
                // Whoever drives himself is nobody's controller.
                Notice::Seat(input)
                    if driven::wheel_of(&self.scene, &input.order.seat).is_none()
                        && input.order.seat != HANDOVER_SEAT =>
                {
                    if let Some(seats) = &mut self.seats {
                        seats.input(*effect, input);
                    }
                }
                Notice::Outsider { .. }
                | Notice::MoreFlights(_)
                | Notice::Plots(_)
                | Notice::Given(_)
                | Notice::Seat(_) => {}
            }
        }
    }

    fn clear(&mut self, c: &ClearanceNotice) {
        let kind = c.kind;
        let callsign = Callsign::new(&c.callsign);
        let runway = self.net.layout().runway(&c.runway);
        if let Some(until_ns) = c.until_ns {
            self.board.end(callsign, kind, runway.map(|r| r.0), SimTime(until_ns));
            return;
        }
        self.board.give(Clearance {
            callsign,
            kind,
            runway,
            place_m: c.place_m,
            from: SimTime(c.from_ns),
            until: None,
        });
        let lands = kind == ClearanceKind::Land;
        if c.way_m.is_empty() && !lands {
            return;
        }
        let too_small = self.is_too_small(callsign, runway.filter(|_| lands), &c.way_m);
        if let Some(strip) = self.board.strip(callsign) {
            if !lands {
                strip.way_m.clone_from(&c.way_m);
            }
            strip.too_small = too_small;
        }
    }

    /// Whether its way, or its runway (`None`: that of the list), is too narrow for a flight of the list.
    fn is_too_small(
        &self,
        callsign: Callsign,
        runway: Option<(usize, Option<usize>)>,
        way_m: &[Point2<f64>],
    ) -> bool {
        let Some(entry) = self.flights.entries.iter().find(|e| e.callsign == callsign) else {
            return false;
        };
        let Some(row) = self.scene.traffic.types.get(&entry.type_designator) else { return false };
        let code = code_of_span(row.class.span_m);
        let layout = self.net.layout();
        let axis = runway.or_else(|| layout.runway(&entry.runway));
        let axis = axis.and_then(|r| layout.runways.get(r.0));
        let behaving = self.scene.traffic.behaving.as_ref();
        axis.is_some_and(|axis| runway_is_narrow(axis, code))
            || behaving.is_some_and(|b| way_is_narrow(&b.network, code, way_m))
    }

    fn target(&self, t: &TrackNotice) -> Target {
        let callsign = (!t.callsign.is_empty()).then(|| Callsign::new(&t.callsign));
        // A name that the target reports itself counts where the flight list knows it.
        let entry = callsign.and_then(|c| self.flights.entries.iter().find(|e| e.callsign == c));
        let named = entry.map_or("", |e| e.type_designator.as_str());
        let designator = if t.type_designator.is_empty() { named } else { &t.type_designator };
        let size = self.scene.traffic.types.get(designator);
        let movement = t.movement.or(entry.map(|e| e.movement));
        let class = match movement {
            Some(MovementKind::Arrival | MovementKind::Departure) => TargetClass::Aircraft,
            Some(MovementKind::Vehicle) => TargetClass::Vehicle,
            None => TargetClass::Unknown,
        };
        Target {
            number: t.number,
            callsign,
            class,
            arriving: movement == Some(MovementKind::Arrival),
            length_m: size.map_or(0.0, |row| row.class.length_m),
            position_m: t.position_m,
            velocity_mps: Vector2::new(t.velocity_mps[0], t.velocity_mps[1]),
            altitude_m: t.altitude_m,
            last_plot: SimTime(t.last_plot_ns),
            first: t.first,
        }
    }
}

/// Half the length of a stop bar as it is drawn, m (assumed: 23 m of taxiway).
const HALF_BAR_M: f64 = 11.5;
/// Entry lights are so far behind their bar, towards the runway, m, and take-off hold lights so far along the runway (assumed).
const ENTRY_BEHIND_M: f64 = 8.0;
const HOLD_ALONG_M: f64 = 115.0;
/// Lights are told to those who hear DIS at least so often, s.
const LIGHTS_EVERY_S: f64 = 30.0;

impl Control {
    /// Tells pages and those who hear DIS the lights of the runways, whenever one changed: JSON, each with its runway, its ends in m east
    /// and north, whether it is lit, and whether it fails.
    fn tell_lights(&mut self, frame: Frame, failed: &[Failed], out: &mut FrameOut) {
        if self.bars.is_empty() {
            return;
        }
        let now = self.time.time(frame);
        let layout = self.net.layout();
        let of = lights::runway_lights(layout, &self.board, self.net.surveillance());
        let fails = |bar: &StopBar| failed.iter().any(|f| f.runway == bar.runway);
        let light = |lit: bool, failed: bool| Light { lit, failed };
        let mut all: Vec<Light> = self.bars.iter().map(|bar| light(bar.lit, fails(bar))).collect();
        all.extend(of.entries.iter().map(|lit| light(*lit, false)));
        all.extend(of.holds.iter().flatten().map(|lit| light(*lit, false)));
        let (known, told_s) = self.lights_told.take().unwrap_or_default();
        let changed = known != all;
        let due = changed || now.s() >= told_s + LIGHTS_EVERY_S;
        self.lights_told = Some((all, if due { now.s() } else { told_s }));
        let Some((all, _)) = &self.lights_told else { return };
        if due {
            let numbered: Vec<(u16, Light)> = (0..).zip(all.iter().copied()).collect();
            let at = self.time.stamp(frame);
            out.aside.extend(self.teller.lights(Lights::Runways, at, &numbered));
        }
        if !changed {
            return;
        }
        let round = |x: f64| (10.0 * x).round() / 10.0;
        // A line of so many metres across or along an axis, with its middle there.
        let line = |middle: Point2<f64>, along: Vector2<f64>| {
            [-HALF_BAR_M, HALF_BAR_M].map(|m| middle + along * m).map(|p| [round(p.x), round(p.y)])
        };
        let at_bar = |bar: &StopBar, nearer_m: f64| {
            let axis = layout.runways.get(bar.runway)?;
            let across_m = bar.across_m.unwrap_or(axis.hold_m);
            let across_m = across_m - nearer_m.copysign(across_m);
            let right = Vector2::new(axis.along.y, -axis.along.x);
            let middle = axis.origin_m + axis.along * bar.place_m + right * across_m;
            Some((axis.names.join("/"), line(middle, axis.along)))
        };
        let bar = |bar: &StopBar| {
            let (runway, ends_m) = at_bar(bar, 0.0)?;
            Some(json!({"runway": runway, "ends_m": ends_m, "lit": bar.lit, "failed": fails(bar)}))
        };
        let entry = |(bar, lit): (&StopBar, &bool)| {
            let (runway, ends_m) = at_bar(bar, ENTRY_BEHIND_M)?;
            Some(json!({"runway": runway, "ends_m": ends_m, "lit": lit}))
        };
        let hold = |(axis, lit): (&RunwayAxis, &[bool; 2])| {
            let right = Vector2::new(axis.along.y, -axis.along.x);
            let of = |end: usize| {
                let from_m = HOLD_ALONG_M.min(0.5 * axis.length_m);
                let place_m = if end == 0 { from_m } else { axis.length_m - from_m };
                let ends_m = line(axis.origin_m + axis.along * place_m, right);
                json!({"runway": axis.names[end], "ends_m": ends_m, "lit": lit[end]})
            };
            [of(0), of(1)]
        };
        let bars: Vec<_> = self.bars.iter().filter_map(bar).collect();
        let entries: Vec<_> = self.bars.iter().zip(&of.entries).filter_map(entry).collect();
        let holds: Vec<_> = layout.runways.iter().zip(&of.holds).flat_map(hold).collect();
        let body = json!({"time_s": now.s(), "bars": bars, "entries": entries, "holds": holds});
        out.publish.push(Publication {
            key: "control/1/lights".into(),
            class: Class::Lossy,
            body: body.to_string().into_bytes(),
            retained: Some("control/1/lights/last".into()),
        });
    }
}

fn message(run: u32, now: SimTime, change: Change, alert: &Alert) -> AlertMessage {
    let place = alert.condition.place_m;
    AlertMessage {
        run,
        time_ns: now.0,
        change,
        id: alert.id,
        kind: alert.condition.kind,
        stage: alert.condition.stage,
        subjects: alert.subjects(),
        since_ns: alert.since.0,
        asterix: alert.condition.asterix(),
        place_m: Point2::new(place.x, place.y),
        number: 0,
    }
}

impl Federate for Control {
    fn kind(&self) -> Kind {
        Kind::Control
    }

    fn period(&self) -> Frame {
        u64::from(self.scene.run.frames_per_scan)
    }

    fn consumes(&self) -> bool {
        true
    }

    fn ahead_of(&self, producer: &str) -> Option<Frame> {
        // Tracks, not the plots that they are made of.
        (!is_front_end(producer)).then_some(0)
    }

    fn reads_pdus(&self) -> bool {
        false
    }

    fn in_loop(&self) -> bool {
        closes_loop(&self.scene)
    }

    fn configure(&mut self, config: &RunConfig, _out: &mut FrameOut) -> Result<(), String> {
        let scene = Arc::clone(&self.scene);
        *self = Self::new(scene, self.teller.exercise);
        self.run = config.run;
        let behaving = self.scene.traffic.behaving.as_ref();
        self.failed_bars = behaving.map_or_else(Vec::new, |b| b.failed_bars(config.seed));
        self.seats = behaving.filter(|_| closes_loop(&self.scene)).map(|behaving| {
            let run = &self.scene.run;
            let times = (run.frame.s(), run.start_utc_ns);
            let airport = (Arc::clone(&behaving.network), Arc::clone(&behaving.flights));
            let (ahead, on_tracks) = (loop_frames(&self.scene), on_tracks(&self.scene));
            let seats = Seats::new(airport, config.seed, times, ahead, on_tracks)
                .with(&self.scene.control.seats, behaving.departure_manager());
            match self.scene.control.advice {
                true => seats.with_advice(config.seed, behaving.departing()),
                false => seats,
            }
        });
        Ok(())
    }

    fn step(&mut self, frame: Frame, inputs: &FrameInputs, out: &mut FrameOut) {
        self.take_in(inputs);
        let now = self.time.time(frame);
        self.board.advance(now);
        let mut targets: Vec<Target> = self.tracks.iter().map(|t| self.target(t)).collect();
        targets.sort_by_key(|t| t.number);
        let layout = self.net.layout();
        let failed: Vec<Failed> = self
            .failed_bars
            .iter()
            .filter(|bars| bars.at(now.s()))
            .filter_map(|bars| Failed::of(layout, &bars.runway, bars.lit))
            .collect();
        match self.scene.control.stop_bars && on_tracks(&self.scene) {
            true => {
                let seen = self.net.surveillance();
                lights::switch(&mut self.bars, &failed, now, layout, &self.board, seen);
            }
            false => self.bars.clear(),
        }
        let scan = Scan {
            now,
            targets: &targets,
            board: &self.board,
            bars: &self.bars,
            areas: &self.areas,
            low_visibility: self.net.parameters().is_low(self.visibility_m),
        };
        // Recorded movements follow no clearances, so that nobody is without one.
        let cleared = self.scene.traffic.behaving.is_some();
        let changes = self.net.scan(&scan);
        let meant = |c: &&(Change, Alert)| cleared || !c.1.condition.kind.is_about_clearances();
        let told: Vec<AlertMessage> = changes
            .iter()
            .filter(meant)
            .map(|(change, alert)| message(self.run, now, *change, alert))
            .collect();
        for m in &told {
            if m.change == Change::Raised {
                *self.raised.entry(m.kind.word()).or_default() += 1;
            }
        }
        self.tell_lights(frame, &failed, out);
        let at = self.time.stamp(frame);
        out.aside.extend(told.iter().map(|m| self.teller.alert(at, m, &self.scene)));
        if !told.is_empty() {
            self.digest.add(frame, &encode(&told));
        }
        for message in told {
            let message = AlertMessage { number: self.alerts.next(), ..message };
            self.standing.take(&message);
            self.alerts.tell(message);
        }
        let message = |key: &str, body: Vec<u8>| Publication {
            key: key.into(),
            class: Class::Lossy,
            body,
            retained: None,
        };
        if let Some(told) = self.standing.told(self.alerts.scan()) {
            let told = message("control/1/alerts", encode(&told));
            out.publish
                .push(Publication { retained: Some("control/1/alerts/last".into()), ..told });
        }
        if let Some(seats) = &mut self.seats {
            let events = seats.scan(frame, now, &self.net, &self.board, out);
            if !events.is_empty() {
                self.digest.add(frame, &encode(&events));
            }
            for event in events {
                let number = self.seat_events.next();
                self.seat_events.tell(SeatMessage { run: self.run, number, event });
            }
            let told = self.seat_events.scan();
            out.publish.extend(told.map(|m| message("control/1/seats", encode(&m))));
        }
    }

    fn state(&self) -> u64 {
        self.digest.0
    }

    fn status(&self, status: &mut FederateStatus) {
        status.facts.extend(self.seats.iter().flat_map(|seats| seat_facts(seats.actors())));
    }

    fn finish(&mut self, report: &mut FinalReport) {
        report.values.extend(self.seats.iter().flat_map(|seats| seat_values(seats.actors())));
        report.digests.push(("alerts".into(), self.digest.0));
        for (kind, count) in &self.raised {
            report.values.push((format!("alerts {kind}"), *count as f64));
        }
    }
}
