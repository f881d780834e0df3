// Figures of the tools on the map.
import assert from "node:assert/strict";
import { test } from "node:test";
import { found, latLon, rangeAndBearing, rangeText } from "../web/tools.js";

test("range, bearing and the nearest approach", () => {
  const r = rangeAndBearing({ x: 0, y: 0, vx: 0, vy: 0 }, { x: 0, y: 1000, vx: 10, vy: -10 });
  assert.deepEqual([r.metres, r.bearing, r.cpaS], [1000, 0, 50]);
  assert.ok(Math.abs(r.cpaM - Math.SQRT1_2 * 1000) < 1e-9);
  assert.equal(rangeText(r), "1000 m  000\u00b0  nearest 707 m in 50 s");
  assert.equal(rangeAndBearing({ x: 0, y: 0 }, { x: -100, y: 0 }).bearing, 270);
  assert.equal(rangeAndBearing({ x: 0, y: 0 }, { x: 10, y: 0, vx: 5, vy: 0 }).cpaS, null, "they part");
  assert.match(rangeText({ metres: 3704, bearing: 359.9, cpaS: null }), /^2\.00 NM {2}000/);
});

test("latitude and longitude of a place", () => {
  const [lat, lon] = latLon(0, 1852, [47.46, 8.55]);
  assert.ok(Math.abs(lat - 47.46 - 1 / 60) < 5e-5 && lon === 8.55);
  const [, east] = latLon(1000, 0, [60, 0]);
  assert.ok(Math.abs(east - 0.017922) < 2e-5, `${east}`);
});

test("a search finds targets by what they are called and are, and places by name", () => {
  const scan = { tracks: [{ id: "t4", number: 4, callsign: "SWR1", designator: "A320", runwayStand: "28/E_19", status: "confirmed", x: 1, y: 2 }], truth: [] };
  const airport = { stands: [{ name: "E_19", position_m: [5, 6] }], taxiways: [{ name: "E", points_m: [[7, 8]] }] }, layers = { tracks: true };
  assert.deepEqual(found("swr", scan, airport, layers).map((f) => f.id), ["t4"]);
  assert.deepEqual(found("a32", scan, airport, layers).map((f) => f.id), ["t4"]);
  assert.deepEqual(found("e 19", scan, airport, layers).map((f) => f.name), ["E_19"]);
  assert.deepEqual(found("e", scan, airport, layers).at(-1).name, "E");
  assert.deepEqual(found("  ", scan, airport, layers), []);
});
