// Light, sight and frustum of the eye against the reference cases.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { backgroundOf, contrastTo, extinction, illuminance, lampRange, rainAt, rvr, sightM, sunElevation, threshold, through } from "../web/eye_light.js";
import { aboard, hidden, matrix, outlook, project, seen } from "../web/eye_see.js";

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
