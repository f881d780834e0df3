//! What people drive, between the member `visitors`, the traffic generators and whoever replays a run: which seats there are, and what
//! is done at them in which frame.
//!
//! An input is in the frame end of `visitors` at its own frame, and moves its vehicle [`delay_frames`] later, so that no generator
//! waits for `visitors`.

use crate::runtime::messages::{Frame, SeatAction, SeatInput};
use models::traffic::core::{Core, Notice, Order, Wish};
use scenarios::Scene;
use scenarios::driven::{Wheel, at_seat, seat_of, seat_of_flight};

/// From an input to what it does, s of simulated time (`docs/traffic.md`, "By hand").
const DELAY_S: f64 = 0.2;

/// The same in frames, one at least.
#[must_use]
pub fn delay_frames(scene: &Scene) -> Frame {
    delay_in(scene.run.frame.s())
}

/// The same in frames of a length, s.
#[must_use]
pub fn delay_in(frame_s: f64) -> Frame {
    (DELAY_S / frame_s).round().max(1.0) as Frame
}

/// Whether people can drive anything of a scene.
#[must_use]
pub fn any(scene: &Scene) -> bool {
    scene.traffic.behaving.as_ref().is_some_and(|b| b.by_hand || !b.driven.is_empty())
}

/// Whether the traffic of a scene acts upon what the member `visitors` lets in.
#[must_use]
pub fn hears(scene: &Scene) -> bool {
    any(scene) || scene.traffic.behaving.as_ref().is_some_and(|b| !b.places.is_empty())
}

/// Names of the seats from which people drive what is there to be driven.
#[must_use]
pub fn seats(scene: &Scene) -> Vec<String> {
    scene.traffic.behaving.iter().flat_map(|b| b.driven.iter().map(seat_of)).collect()
}

/// Names of the seats from which people take flights that taxi.
#[must_use]
pub fn flight_seats(scene: &Scene) -> Vec<String> {
    let behaving = scene.traffic.behaving.iter().filter(|b| b.by_hand);
    behaving.flat_map(|b| b.flights.iter().map(|f| seat_of_flight(&f.callsign))).collect()
}

/// What is driven from a seat.
#[must_use]
pub fn wheel_of(scene: &Scene, seat: &str) -> Option<Wheel> {
    scene.traffic.behaving.as_ref().and_then(|b| at_seat(b, seat))
}

/// What an input of frame `said` is to the core; `None` where it is none of a driver.
#[must_use]
pub fn notice(scene: &Scene, core: &Core, said: Frame, input: &SeatInput) -> Option<Notice> {
    let flight = match wheel_of(scene, &input.order.seat)? {
        Wheel::Driven(mover) => core.first_driven() + mover,
        Wheel::Flight(flight) => flight,
    };
    let order = match input.order.action {
        SeatAction::Take => Order::Take,
        SeatAction::Leave => Order::Leave,
        SeatAction::Drive { throttle, brake, steer } => {
            Order::Drive(Wish { throttle, brake, steer })
        }
        SeatAction::Here
        | SeatAction::Decide { .. }
        | SeatAction::WhatIf { .. }
        | SeatAction::Give { .. }
        | SeatAction::Release { .. }
        | SeatAction::Say { .. } => return None,
    };
    Some(Notice {
        effect_frame: (said + delay_frames(scene)) as i64,
        source: input.order.seat.clone(),
        sequence: input.number,
        flight,
        order,
    })
}
