// The hooks for tests and tools have the names that are specified.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { besideOf, expose, labelSaid } from "../web/hook.js";
import { Field, place } from "../web/labels.js";

test("a label says its box, its leader where one is drawn, and whether it lies on a runway", () => {
  const field = new Field(0, 0, 800, 600);
  field.polygon([[0, 280], [800, 280], [800, 320], [0, 320]]);
  const sizes = { 1: { w: 60, h: 19 }, 2: { w: 84, h: 32 }, 3: { w: 96, h: 45 } };
  const item = (id, x, y, more) => ({ id, x, y, importance: 1, level: 1, reach: 6, sizes, ...more });
  const items = [item("away", 400, 100), item("far", 400, 500, { dragged: { dx: 90, dy: 40 } }), item("there", 200, 300, { dragged: { dx: 0, dy: 8 } })];
  const placed = place(items, { view: { x: 0, y: 0, w: 800, h: 600 }, field });
  const said = Object.fromEntries([...placed].map(([id, p]) => [id, labelSaid([id, { ...p, sx: p.item.x, sy: p.item.y }])]));
  assert.deepEqual(Object.keys(said.away), ["id", "level", "box", "leader", "on_runway"]);
  assert.deepEqual([said.away.leader, said.away.on_runway], [null, false], "beside its symbol");
  assert.deepEqual([said.far.leader[0], said.far.on_runway], [[400, 500], false]);
  const [x, y] = said.far.leader[1], { box } = said.far;
  assert.ok(x >= box.x && x <= box.x + box.w && y >= box.y && y <= box.y + box.h, "ends at its box");
  assert.ok(said.there.on_runway && said.there.box.w === 60);
});

test("the hooks have all getters that are specified, and nothing can be set", () => {
  globalThis.window = {};
  const part = { placed: new Map(), labels: new Map(), others: new Map(), longestMs: 12.5, view: {}, layers: {}, sensorsOff: [] };
  expose({ state: {}, map: part, line: {}, curve: {}, alerts: { open: [] }, panes: { names: ["map"], list: [] }, insets: { list: [] }, address: { text: () => "t=5" }, whatIf: {} });
  const hook = globalThis.window.__viewer;
  assert.deepEqual([hook.labels, hook.state, hook.longest_task_ms, hook.panes, hook.alerts], [[], "t=5", 12.5, ["map"], []]);
  for (const name of ["labels", "view", "state", "longest_task_ms", "panes", "alerts", "strips"]) assert.ok(name in hook, name);
  assert.throws(() => { "use strict"; hook.state = "t=6"; }, TypeError);
  delete globalThis.window;
  const eye = readFileSync(new URL("../web/eye.js", import.meta.url), "utf8").split('"__eye"')[1];
  for (const name of ["pose", "fov", "beta", "visibility_m", "visible", "marks", "lamps", "age_s", "triangles", "calls", "frames"]) assert.match(eye, new RegExp(`\\b${name}: \\(\\) =>`));
});

test("a track has what it does, its alert and its clearance, though no scan says them", () => {
  const situation = { stateOf: (t) => (t.x > 0 ? "taxiing" : "parked") }, alerted = new Map([["t2", "information"], ["t3", "alarm"]]);
  const traffic = { movers: [{ callsign: "SWR1", phase: "lined up", cleared: [{ kind: "LUP" }, { kind: "TOF" }] }] }, of = (t) => besideOf(t, { situation, alerted, traffic });
  assert.deepEqual(of({ id: "t2", callsign: "SWR1", x: 5 }), { state: "lined up", alert: 1, clearance: "TOF" });
  assert.deepEqual(of({ id: "t3", callsign: "SWR1", assumed: true, x: 5 }), { state: "taxiing", alert: 2, clearance: "" }, "a name in doubt is nobody's");
  assert.deepEqual(of({ id: "t5", callsign: "X", x: -1, doing: "holding", alertStage: 2, cleared: "TAX" }), { state: "holding", alert: 0, clearance: "TAX" }, "as its scan has it; alerts as they are said");
  assert.equal(besideOf({ id: "t5", alertStage: 2 }, {}).alert, 2, "of a run whose alerts are not said");
  assert.deepEqual(of({ id: "t4", callsign: "", x: -1 }), { state: "parked", alert: 0, clearance: "" });
});
