// What keys and gamepads ask for, and where a driven mover is between two messages.

import assert from "node:assert/strict";
import { test } from "node:test";
import { reckoned, wishOf, wishOfPad } from "../web/wheel.js";

const car = { at_m: [0, 100], heading_rad: Math.PI / 2, speed_mps: 5, acceleration_mps2: -1, steer_rad: 0.2, length_m: 4.6, wheelbase_m: 2.7 };

test("a mover is reckoned on by the equations of the core: one step of half a second is ten of a twentieth, within centimetres", () => {
  const far = reckoned(car, 0.5);
  let near = car;
  for (let k = 0; k < 10; k++) near = reckoned(near, 0.05);
  assert.ok(Math.hypot(far.at_m[0] - near.at_m[0], far.at_m[1] - near.at_m[1]) < 0.03, `${far.at_m} ${near.at_m}`);
  assert.ok(Math.abs(far.heading_rad - near.heading_rad) < 1e-9);
  // 2.375 m of way, sin(0.2)/2.7 of turn a metre: to the right, so ahead to the east and a little south.
  assert.ok(Math.abs(far.heading_rad - Math.PI / 2 - (2.375 * Math.sin(0.2)) / 2.7) < 1e-9);
  assert.ok(far.at_m[0] > 2 && far.at_m[1] < 99.95, `${far.at_m}`);
});

test("who brakes stands in the end, forwards and backwards, and is not reckoned farther than a second", () => {
  for (const sign of [1, -1]) {
    const stopped = reckoned({ ...car, speed_mps: sign * 0.5, acceleration_mps2: -sign }, 1);
    assert.equal(stopped.speed_mps, 0);
    assert.ok(Math.abs(Math.hypot(stopped.at_m[0], stopped.at_m[1] - 100) - 0.125) < 0.01);
  }
  const rolling = { ...car, acceleration_mps2: 0 };
  assert.deepEqual(reckoned(rolling, 60), reckoned(rolling, 1));
  assert.deepEqual(reckoned({ ...car, speed_mps: 0, acceleration_mps2: 0 }, 1).at_m.map((x) => Math.round(1e9 * x) / 1e9), [0, 100]);
});

test("keys ask for what they say, and the brake goes before the throttle", () => {
  const wish = (keys, speed = 0, parked = false) => Object.values(wishOf(new Set(keys), speed, parked));
  assert.deepEqual(wish([]), [0, 0, 0]);
  assert.deepEqual(wish(["forward", "left"]), [1, 0, -1]);
  assert.deepEqual(wish(["forward", "brake"]), [0, 1, 0]);
  assert.deepEqual(wish(["left", "right", "forward", "fine"]), [0.33, 0, 0]);
  assert.deepEqual(wish(["back"], 3), [0, 0.5, 0]);
  assert.deepEqual(wish(["back"], 0), [-1, 0, 0]);
  assert.deepEqual(wish(["forward"], 0, true), [0, 1, 0]);
});

test("a gamepad at rest says nothing; its triggers and its stick do, beyond the dead part", () => {
  const pad = (steer, throttle, brake, b = 0) => ({ connected: true, axes: [steer, 0], buttons: [0, b, 0, 0, 0, 0, brake, throttle].map((value) => ({ value })) });
  assert.equal(wishOfPad(null), null);
  assert.equal(wishOfPad(pad(0.05, 0.02, 0)), null);
  assert.deepEqual(wishOfPad(pad(0, 1, 0)), { throttle: 1, brake: 0, steer: 0 });
  assert.deepEqual(wishOfPad(pad(-1, 1, 0, 1)), { throttle: -1, brake: 0, steer: -1 });
  assert.ok(Math.abs(wishOfPad(pad(0.54, 0, 0)).steer - 0.5) < 1e-9);
});
