// Times as typed, ticks, events and exports.
import assert from "node:assert/strict";
import { test } from "node:test";
import { csv, json } from "../web/export.js";
import { between, heat, nextEvent, TimeLine, tickStep, typedTime } from "../web/time.js";
import { Camera } from "../web/camera.js";
import { Ground } from "../web/situation.js";

test("a time is typed in seconds, minutes or UTC", () => {
  for (const [text, s] of [["215", 215], ["3:35", 215], ["1:02:03", 3723], [" 2.5 ", 2.5], ["09:03:35Z", 215], ["08:59:59z", 86399], ["x", null], ["", null], ["1:60", null], ["1:2:3:4", null], ["-5", null], ["25:00:00Z", null], ["3:35Z", null]]) {
    assert.equal(typedTime(text, 9 * 3600), s, text);
  }
});

test("labels of the time line stand apart", () => {
  for (const [span, width] of [[10, 800], [600, 800], [7200, 300], [86_400, 1500], [1, 200]]) {
    const step = tickStep(0, span, width);
    assert.ok((step / span) * width >= 70 || step === 7200, `${span} s on ${width}`);
  }
});

test("the next event of the kinds wanted", () => {
  const events = [1, 5, 9].map((s, i) => ({ time_ns: s * 1e9, kind: ["lost", "weather", "lost"][i] }));
  assert.equal(nextEvent(events, 1, 1, new Set(["lost"])), 9);
  assert.equal(nextEvent(events, 9, -1, new Set(["lost", "weather"])), 5);
  assert.equal(nextEvent(events, 9, 1, new Set(["lost"])), null);
});

test("an error fills the strip to the half where it is as large as is required, and no error is none", () => {
  assert.deepEqual([null, undefined, NaN, 0, 7.5, 15, 100].map((m) => heat(m)), [null, null, null, 0, 0.5, 1, 1]);
  assert.deepEqual([0, 0.5, 1].map((part) => between("#000080", "#ff0001", part)), ["#000080", "#800041", "#ff0001"]);
});

test("a table as CSV is read back as it was, and no cell is a formula", () => {
  assert.equal(csv(["a", "b"], [[1.5, 'x"y,z'], [null, "=1+1"], [NaN, "-5"]]), 'a,b\r\n1.5,"x""y,z"\r\n,\'=1+1\r\n,\'-5\r\n');
  assert.deepEqual(JSON.parse(json(["a"], [[1], [null]])), [{ a: 1 }, { a: null }]);
});

test("a camera turns and comes back, and zooms about a pixel", () => {
  const cam = new Camera(800, 600);
  cam.look({ cx: 120, cy: -40, scale: 0.7, rot: 350 });
  const [x, y] = cam.toMetres(123, 456), [px, py] = cam.toScreen(x, y);
  assert.ok(Math.hypot(px - 123, py - 456) < 1e-9);
  cam.look(cam.zoomed(3, 123, 456));
  assert.ok(Math.hypot(...cam.toMetres(123, 456).map((v, i) => v - [x, y][i])) < 1e-9);
  cam.look({ rot: 90 });
  const east = cam.toScreen(cam.cx + 100, cam.cy);
  assert.ok(east[1] < 300 && Math.abs(east[0] - 400) < 1e-9, "east is up");
  assert.equal(cam.look({ cx: NaN }), false);
});

test("what a target does, by map and speed", () => {
  const ground = new Ground({ runways: [{ designators: ["09", "27"], ends: [[0, 0], [2000, 0]], width_m: 45 }], stands: [{ position_m: [500, 300] }] });
  const at = (x, y, v, more) => ground.stateOf({ x, y, vx: v, vy: 0, altitudeM: 0, type: "aircraft", ...more });
  assert.equal(at(1000, 10, 60), "runway");
  assert.equal(at(1000, 10, 60, { altitudeM: 50 }), "airborne");
  assert.equal(at(510, 310, 0), "parked");
  assert.equal(at(900, 310, 0), "holding");
  assert.equal(at(900, 310, 8), "taxiing");
  assert.equal(at(1000, 10, 8, { type: "vehicle" }), "vehicle on a runway");
  assert.equal(at(1000, 40, 8, { type: "vehicle" }), "vehicle");
});

test("the line says how many events it does not mark", () => {
  globalThis.ResizeObserver = class {
    observe() {}
  };
  class Undrawn extends TimeLine {
    draw() {}
  }
  const line = new Undrawn({ clientWidth: 400 }, { addEventListener() {} });
  delete globalThis.ResizeObserver;
  line.show({ firstS: 0, lastS: 100, events: [{ kind: "lost", time_ns: 5e9, text: "lost SWR1" }], more: 0 });
  assert.equal(line.textAt(5), "T+ 00:05\n\u2715 lost SWR1");
  line.show({ more: 502 });
  assert.match(line.textAt(5), /lost SWR1\n502 events of this run are not marked/);
});
