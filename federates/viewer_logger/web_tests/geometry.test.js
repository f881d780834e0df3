// Sensors that are no radar, in their panes.
import assert from "node:assert/strict";
import { test } from "node:test";
import { agesOf, Geometry, geometryText, skyPlace } from "../web/geometry.js";

const near = (a, b) => assert.ok(a.every((v, i) => Math.abs(v - b[i]) < 1e-9), `${a} is not ${b}`);

test("a sky plot has the zenith in its middle, north up, east to the right, the horizon at its rim", () => {
  near(skyPlace({ azimuth_deg: 123, elevation_deg: 90 }, 60), [0, 0]);
  near(skyPlace({ azimuth_deg: 0, elevation_deg: 0 }, 60), [0, -60]);
  near(skyPlace({ azimuth_deg: 90, elevation_deg: 45 }, 60), [30, 0]);
});

test("the head says satellites and dilution, stations that hear, who is silent", () => {
  const sky = { kind: "gps", statistical: false, satellites: [{ used: true }, { used: true }, { used: false }], dop: { horizontal: 1.234, vertical: 2, position: 2.35 } };
  assert.equal(geometryText(sky), "2 satellites, HDOP 1.23, VDOP 2.00, PDOP 2.35");
  assert.equal(geometryText({ ...sky, dop: null, correction_age_s: 1.25 }), "2 satellites, no fix, correction 1.3 s old");
  assert.match(geometryText({ kind: "gps", statistical: true }), /no sky/);
  assert.equal(geometryText({ kind: "mlat", stations: [1, 2, 3, 4], target: { heard_by: [0, 2, 3], dilution: 1.5 } }), "4 stations, selected: heard by 3, HDOP 1.50");
  const ages = [{ name: "A", ageS: 0.5, late: false }, { name: "B", ageS: 9, late: true }, { name: "C", ageS: null, late: false }];
  assert.equal(geometryText({ kind: "adsb", nacp: 9, radius_95_m: 30 }, ages), "NACp 9 (30 m, 95 %), 1 late, silent: C");
  assert.equal(geometryText(null), "");
});

test("the age of a message counts from when it was sent, and a jump in time forgets", async () => {
  const asked = [], geometry = new Geometry(4, () => {}, async (url) => {
    asked.push(url);
    return { ok: true, json: async () => ({ kind: "adsb", nacp: 10, radius_95_m: 10 }) };
  });
  const scan = (timeS, plots) => ({ timeS, truth: [{ id: "e1", callsign: "A", x: 0, y: 0 }, { id: "e2", callsign: "B", x: 9, y: 9 }], plots });
  await geometry.take(scan(12, [{ sensor: 4, truthIndex: 0, ageS: 0.25 }, { sensor: 5, truthIndex: 1, ageS: 0 }]), null);
  const ages = (s) => agesOf(scan(s, []), geometry.last).map((a) => a.ageS);
  assert.deepEqual(ages(15), [3.25, null], "another sensor's plot is none of its own");
  const late = (vx, told) => agesOf({ timeS: 15, truth: [{ id: "e1", callsign: "A", x: 0, y: 0, vx, vy: 0 }], plots: [] }, geometry.last, told)[0].late;
  assert.deepEqual([late(9, { moving_s: 0.5, parked_s: 5 }), late(0, { moving_s: 0.5, parked_s: 5 }), late(0, { moving_s: 0.5, parked_s: 1 })], [true, false, true], "who stands says so every five seconds");
  await geometry.take(scan(13, []), null);
  assert.deepEqual(ages(15), [3.25, null]);
  await geometry.take(scan(600, []), null);
  assert.deepEqual(ages(600), [null, null]);
  assert.deepEqual(asked, ["/geometry?sensor=4&t=10"], "what stands is asked for once");
});

test("a sky is asked for again every ten seconds, stations of a selected target as it moves", async () => {
  const asked = [], told = { gps: { kind: "gps", statistical: false, satellites: [], outages_s: [], until_s: 60 }, mlat: { kind: "mlat", stations: [], target: { heard_by: [], dilution: null } } };
  const of = (kind) => new Geometry(1, () => {}, async (url) => {
    asked.push(url);
    return { ok: true, json: async () => told[kind] };
  });
  const scan = (timeS) => ({ timeS, truth: [], plots: [] }), sky = of("gps");
  for (const s of [1, 5, 9.9, 10, 19, 31]) await sky.take(scan(s), null);
  assert.deepEqual(asked.splice(0), ["/geometry?sensor=1&t=0", "/geometry?sensor=1&t=10", "/geometry?sensor=1&t=30"]);
  const mlat = of("mlat");
  for (const [s, x] of [[1, null], [2, 100], [3, 103], [4, 120], [5, null]]) await mlat.take(scan(s), x === null ? null : { x, y: 0 });
  assert.deepEqual(asked, ["/geometry?sensor=1&t=0", "/geometry?sensor=1&x=100&y=0", "/geometry?sensor=1&x=120&y=0"]);
  assert.equal(mlat.target, null);
});
