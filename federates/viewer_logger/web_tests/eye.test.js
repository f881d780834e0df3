// Light, sight and frustum of the eye against the reference cases.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Asks, eyeOf, outOf, troubleOf } from "../web/eye_address.js";
import { backgroundOf, contrastTo, extinction, extinctionTo, illuminance, lampRange, rainAt, rvr, sightM, sunElevation, threshold, through } from "../web/eye_light.js";
import { lit, worn } from "../web/eye_lamps.js";
import { aboard, hidden, matrix, outlook, project, seen } from "../web/eye_see.js";

import { Ground } from "../web/situation.js";

const cases = JSON.parse(readFileSync(new URL("../../../tests/data/views/contrast.json", import.meta.url)));
const near = (a, b, relative, absolute = 0) => assert.ok(Math.abs(a - b) <= relative * Math.abs(b) + absolute, `${a}, not ${b}`);

test("contrast to the horizon", () => {
  for (const c of cases.horizon) near(through(c.ratio, extinction(c.visibility_m, c.rain_mm_per_h), c.distance_m) - 1, c.contrast, 1e-3, 2e-7);
});

test("contrast to the ground", () => {
  for (const c of cases.ground) near(contrastTo(c.object, c.background, extinction(c.visibility_m), c.distance_m), c.contrast, 1e-3, 2e-6);
});

test("lamps: threshold, range, illuminance at that range", () => {
  for (const c of cases.lights) {
    const beta = extinction(c.visibility_m, c.rain_mm_per_h);
    if (c.illuminance_lx !== undefined) {
      near(illuminance(c.intensity_cd, beta, c.distance_m), c.illuminance_lx, 1e-3);
      continue;
    }
    near(threshold(c.background_cd_m2), c.threshold_lx, 1e-4);
    near(lampRange(c.intensity_cd, beta, threshold(c.background_cd_m2)), c.range_m, 1e-3);
  }
});

test("who is seen", () => {
  for (const c of cases.frustum) {
    const targets = c.targets.map((t) => ({ id: t.id, at: [t.x_m, t.y_m, t.z_m] }));
    const eye = { eye: c.eye_m, look: c.look_deg, fov: c.vertical_fov_deg, aspect: c.aspect[0] / c.aspect[1], sight: sightM(extinction(c.visibility_m)) };
    assert.deepEqual(seen(eye, targets).sort(), [...c.seen].sort());
  }
});

test("the matrix draws a point where the projection says it is", () => {
  const eye = [100, -50, 30], look = [33, -7], m = matrix(eye, look, 40, 1.6);
  for (const p of [[300, 200, 0], [120, 400, 80], [900, 900, 3]]) {
    const clip = [0, 1, 2, 3].map((r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]), q = project(p, eye, look, 40, 1.6);
    near(clip[0] / clip[3], q.x, 1e-4, 1e-5);
    near(clip[1] / clip[3], q.y, 1e-4, 1e-5);
  }
});

test("a building hides what is behind and below it only", () => {
  const block = { ring: [[-10, 50], [10, 50], [10, 60], [-10, 60]], height_m: 20 };
  assert.ok(hidden([0, 0, 2], [0, 100, 2], block));
  assert.ok(!hidden([0, 0, 50], [0, 100, 30], block), "over it");
  assert.ok(hidden([0, 0, 50], [0, 100, 2], block) === (50 - 48 * 0.6 < 20), "down behind it");
  assert.ok(!hidden([0, 0, 2], [40, 100, 2], block), "beside it");
  assert.ok(!hidden([0, 0, 2], [0, 40, 2], block), "before it");
});

test("no figure is lost in wild weather", () => {
  for (const v of [null, Infinity, NaN, 0, 10, 1e9]) for (const r of [0, 200, 1000, -1]) assert.ok(extinction(v, r) >= 0 && Number.isFinite(extinction(v, r)));
  assert.equal(illuminance(100, 0, 0.1), illuminance(100, 0, 5));
  assert.equal(rvr(extinction(null), 10_000), 2000);
  assert.equal(rvr(extinction(100), 10_000) % 25, 0);
  assert.equal(sightM(0), Infinity);
  assert.equal(rainAt({ rain_mm_per_h: 2, cells: [[0, 0, 100, 30]] }, 50, 0), 30);
  const shower = { visibility_m: 5000, rain_mm_per_h: 2, cells: [[0, 0, 100, 30]] };
  assert.equal(extinctionTo(shower, [-400, 0, 40], [420, 10, 2]), extinction(5000, 30), "it falls halfway");
  assert.equal(extinctionTo(shower, [0, 0, 40], [420, 10, 2]), extinction(5000, 2), "it falls on the eye alone");
  assert.ok(backgroundOf(-30) === 1 && backgroundOf(60) === 10_000 && backgroundOf(0) > 100);
});

test("the sun is where it is", () => {
  near(sunElevation(Date.UTC(2026, 5, 21, 11, 26), 47.46, 8.55), 65.98, 0, 1);
  near(sunElevation(Date.UTC(2026, 11, 21, 11, 24), 47.46, 8.55), 19.1, 0, 1);
  assert.ok(sunElevation(Date.UTC(2026, 11, 21, 23), 47.46, 8.55) < -50);
});

test("a pilot sits behind the nose and looks ahead", () => {
  const { eye, look } = aboard({ x: 0, y: 0, vx: 0, vy: 10, altitudeM: 0, heading: 0, lengthM: 37.6, designator: "A320" }, 1, "pilot");
  assert.deepEqual(look, [0, 0]);
  near(eye[1], 10 + 18.8 - 2, 1e-9);
  assert.equal(eye[2], 4.8);
});

test("the tower looks where the most of the traffic is", () => {
  const around = (bearing, far) => [Math.sin((bearing * Math.PI) / 180) * far, Math.cos((bearing * Math.PI) / 180) * far, 0], width = 66;
  near(outlook([0, 0, 30], [around(30, 800), around(50, 900), around(180, 700)], width), 40, 1e-9);
  near(outlook([0, 0, 30], [around(200, 800)], width), 200, 1e-9);
  near(outlook([0, 0, 30], [around(90, 400), around(270, 9000)], width), 90, 1e-9);
  assert.equal(outlook([0, 0, 30], [], width), 0);
  assert.equal(outlook([0, 0, 30], [[NaN, 0, 0]], width), 0);
  for (let turn = 0; turn < 360; turn += 7) near((outlook([5, 5, 30], [-20, 0, 25].map((d) => around(turn + d, 1000)).map(([x, y]) => [x + 5, y + 5, 0]), width) - turn - 2.5 + 540) % 360, 180, 0, 1e-6);
});

// Lamps of movers: a stand at (0, 0), a runway along the north, nose to the north.
const field = new Ground({ runways: [{ designators: ["36", "18"], ends: [[500, -1000], [500, 1000]], width_m: 45 }], stands: [{ name: "1", position_m: [0, 0] }] });
const plane = (more) => ({ id: "e1", callsign: "SWR1", aircraft: true, x: 200, y: 0, vx: 0, vy: 0, altitudeM: 0, heading: 0, lengthM: 37.6, spanM: 34.1, ...more });
const names = (truth, eye = [truth.x, truth.y + 300, 2]) => worn(field, truth, [truth.x, truth.y, truth.altitudeM], eye, 0, false).map((l) => l.id.replace("SWR1 ", "")).sort();

test("an aircraft wears the lamps of what it does", () => {
  assert.deepEqual(names(plane({ x: 0 })), [], "on its stand");
  const holding = ["beacon belly", "beacon top", "navigation left", "navigation right"];
  assert.deepEqual(names(plane()), holding, "seen from straight ahead");
  assert.deepEqual(names(plane({ vy: 8 })), [...holding, "taxi"]);
  assert.deepEqual(names(plane({ vy: -1.5 })), holding, "pushed back");
  assert.deepEqual(names(plane({ x: 500 })), [...holding, "strobe left", "strobe right"], "lined up");
  const all = ["beacon belly", "beacon top", "landing left", "landing right", "navigation left", "navigation right", "strobe left", "strobe right"];
  assert.deepEqual(names(plane({ x: 500, vy: 60 })), all, "rolling");
  assert.deepEqual(names(plane({ x: 500, y: -3000, vy: 70, altitudeM: 150 })), all, "on final");
});

test("a vehicle has its beacon on but on a stand, and its headlights while it drives", () => {
  const car = (more) => plane({ aircraft: false, lengthM: 5, spanM: 2, ...more });
  assert.deepEqual([names(car({ x: 0 })), names(car()), names(car({ vy: 10 }))], [[], ["beacon"], ["beacon", "head left", "head right"]]);
});

test("red is left, green is right, white behind, and a landing light dazzles only ahead", () => {
  const of = (eye, truth = plane({ x: 500, vy: 60 })) => Object.fromEntries(worn(field, truth, [truth.x, truth.y, 0], [500 + eye[0], eye[1], 2], 0, false).map((l) => [l.id.replace("SWR1 ", ""), l]));
  const left = of([-400, 50]), right = of([400, 50]), behind = of([0, -400]), ahead = of([0, 800]);
  assert.ok(left["navigation left"] && !left["navigation right"] && !left["navigation tail"]);
  assert.ok(right["navigation right"] && !right["navigation left"] && !right["navigation tail"]);
  assert.ok(behind["navigation tail"] && !behind["navigation left"] && !behind["landing left"]);
  assert.ok(ahead["landing left"].cd > 150_000 && left["landing left"].cd <= 200, `${ahead["landing left"].cd} ${left["landing left"].cd}`);
  // They turn with the body, and stand at its ends.
  const east = worn(field, plane({ heading: Math.PI / 2 }), [200, 0, 0], [600, 0, 2], 0, false).find((l) => l.id.endsWith("navigation left"));
  assert.ok(east.at[1] > 17 && Math.abs(east.at[0] - 200) < 6, `${east.at}`);
  assert.deepEqual([left["navigation left"].colour[0], right["navigation right"].colour[1]], [1, 1]);
});

test("flashes are short, each in its own time, and all lit where time stands still", () => {
  const share = (flash) => Array.from({ length: 1000 }, (_, k) => lit(flash, k / 100, "SWR1", true)).filter(Boolean).length / 1000;
  near(share([1, [0, 0.2]]), 0.2, 0, 0.02);
  near(share([1, [0, 0.08], [0.2, 0.28]]), 0.16, 0, 0.02);
  assert.equal(share(null), 1);
  assert.ok(lit([1, [0, 0.2]], 0.5, "x", false));
  const times = (name) => Array.from({ length: 100 }, (_, k) => lit([1, [0, 0.2]], k / 100, name, true)).join();
  assert.notEqual(times("SWR1"), times("SWR2"));
});

test("an address that is cut or no address leaves the eye where it is", () => {
  for (const text of ["pilot:SWR%2", "%zz", undefined, "", "nobody:SWR1"]) assert.equal(eyeOf(text), null, String(text));
  assert.deepEqual(eyeOf("pilot:SWR%201"), ["pilot", "SWR 1"]);
  assert.deepEqual([eyeOf("tower"), eyeOf("driver:a:b")], [["tower", null], ["driver", "a:b"]]);
});

test("after each connection the eye asks for its run and its time again, by the time line of that run", () => {
  let open = false;
  const sent = [], asks = new Asks((message) => open && sent.push(message) > 0), told = () => sent.splice(0).map((m) => (m.type === "open" ? m.runs.join() : m.scan));
  asks.want({ t: 12, run: ["b", "a"] });
  assert.deepEqual(told(), [], "there is no connection");
  open = true;
  const connected = () => {
    asks.hello();
    // What the server had sent before it read the first word.
    asks.runs(["a"]);
    asks.timeline({ first: 1, last: 5, first_s: 1, last_s: 5 });
    asks.runs(["b", "a"]);
    asks.timeline({ first: 1, last: 41, first_s: 0, last_s: 20 });
    asks.timeline({ first: 1, last: 43, first_s: 0, last_s: 21 });
    return told();
  };
  assert.deepEqual(connected(), ["b,a", 5, 25]);
  assert.deepEqual(connected(), ["b,a", 25, 5, 25]);
  asks.want({ t: "live", run: ["b", "a"] });
  assert.deepEqual(told(), [null], "the runs are open");
  asks.want({ run: ["c"] });
  assert.deepEqual(told(), ["c"]);
  // It is not there, and neither is what was asked for before any more: the same words ask again.
  asks.refused();
  asks.want({ run: ["c"] });
  assert.deepEqual(told(), ["c"]);
});

test("who was named is not exchanged for somebody else", () => {
  assert.equal(outOf("SWR9", ["SWR1", "SWR2"], true), "SWR9", "gone, and nobody in its place");
  assert.equal(outOf("SWR2", ["SWR1", "SWR2"], true), "SWR2");
  assert.equal(outOf(null, ["SWR1", "SWR2"], false), "SWR1");
  assert.equal(outOf("SWR9", ["SWR1"], false), "SWR1");
  assert.equal(outOf(null, [], false), null);
});

test("a picture that is not of now says why", () => {
  assert.equal(troubleOf({ link: "open" }), "");
  assert.equal(troubleOf({ link: "connecting" }), "");
  for (const link of ["lost", "silent"]) assert.match(troubleOf({ link, refused: "no such run" }), /stands/);
  assert.equal(troubleOf({ link: "open", refused: "no such run" }), "no such run");
  assert.match(troubleOf({ link: "open", unreadable: true }), /another version/);
});

test("how far one sees may depend on where one looks", () => {
  const eye = { eye: [0, 0, 10], look: [0, 0], fov: 60, aspect: 1.6 };
  const targets = [{ id: "LEFT", at: [-200, 900, 10] }, { id: "RIGHT", at: [200, 900, 10] }];
  assert.deepEqual(seen({ ...eye, sight: (at) => (at[0] < 0 ? 500 : 5000) }, targets), ["RIGHT"]);
  assert.deepEqual(seen({ ...eye, sight: 5000 }, targets), ["LEFT", "RIGHT"]);
});
