// Alerts, strips, dial and panes: what they make of what is said.
import assert from "node:assert/strict";
import { test } from "node:test";
import { alertWords, runwayOf, stagesOf, subjectOf } from "../web/alerts.js";
import { errorOf, front, pick } from "../web/dial.js";
import { foreignAt, paintForeign } from "../web/foreign.js";
import { sensorScan } from "../web/panes.js";
import { paintPosition, runwayState } from "../web/position.js";
import { Ground } from "../web/situation.js";
import { targetFacts } from "../web/lists.js";
import { labelLines } from "../web/traffic.js";
import { baysOf, clearanceFacts, stripsOf, targetText, waitText, withTargets } from "../web/strips.js";

const track = (number, callsign, x = 0, y = 0, more = {}) => ({ id: `t${number}`, number, callsign, x, y, vx: 0, vy: 0, altitudeM: null, type: "aircraft", movement: "arrival", ...more });
const scanOf = (...tracks) => ({ tracks, truth: [], plots: [] });
const alert = (stage, ...subjects) => ({ id: 1, kind: "RMCA_ARR", stage, subjects, place_m: [0, 0] });
const AIRPORT = { runways: [{ designators: ["09", "27"], ends: [[0, 0], [3000, 0]], width_m: 45 }], stands: [{ name: "A1", position_m: [500, 400] }] };

test("an alert finds its targets by call sign, else by track number, and never by a call sign that is only assumed", () => {
  const scan = scanOf(track(4, "SWR1"), track(7, ""), track(12, "BAW2", 0, 0, { assumed: true }));
  assert.equal(subjectOf(scan, "SWR1").id, "t4");
  assert.equal(subjectOf(scan, "7").id, "t7");
  assert.equal(subjectOf(scan, "4"), null, "who has a name is called by it");
  assert.equal(subjectOf(scan, "strip"), null);
  assert.equal(subjectOf(null, "7"), null);
  const stages = stagesOf(scan, [alert("alarm", "SWR1", "7"), alert("information", "SWR1"), alert("information", "nobody")]);
  assert.deepEqual([...stages], [["t4", "alarm"], ["t7", "alarm"]], "the graver counts, in any order");
});

test("every kind of alert has words", () => {
  for (const kind of ["RMCA_ARR", "RMCA_ROLL", "RMCA_OPP", "RMCA_CROSS", "RWY_CLOSED", "NOCLR_RWY", "NOCLR_TOF", "NOCLR_LND", "NOCLR_PUSH", "NOCLR_TAXI", "STOPBAR", "ROUTE_DEV", "NOMOV", "HIGH_SPEED", "AREA", "WRTY", "STOCC"]) {
    assert.notEqual(alertWords(kind), kind);
  }
  assert.equal(alertWords("CATC_CRO_TOF"), "clearances exclude each other: crossing, take-off");
  assert.equal(alertWords("NEW_KIND"), "NEW_KIND");
});

test("an alert about a runway names it: where it is, where its subjects are, or whose strip it lies in", () => {
  const ground = new Ground(AIRPORT), beside = { ...alert("alarm", "CAR1", "SWR1"), kind: "RMCA_ROLL", place_m: [600, -40] };
  const roll = scanOf(track(1, "CAR1", 600, -40), track(2, "SWR1", 2500, 3));
  assert.deepEqual(runwayOf(beside, roll, ground)?.names, ["09", "27"], "one of them is on it");
  assert.deepEqual(runwayOf(beside, scanOf(), ground)?.names, ["09", "27"], "its place is in the strip");
  assert.equal(runwayOf({ ...beside, place_m: [600, -140] }, scanOf(), ground), null);
  assert.equal(runwayOf({ ...beside, place_m: [600, -140] }, scanOf(track(2, "SWR1", 2500, 3, { altitudeM: 90 })), ground), null, "who flies over is not on it");
  assert.equal(runwayOf({ ...beside, kind: "HIGH_SPEED", place_m: [600, 0] }, roll, ground), null, "a taxiway's matter");
  const state = (a) => runwayState(AIRPORT.runways[0], { traffic: null, scan: roll, ground, alerts: a });
  assert.equal(state([beside]), "alert");
  assert.equal(state([{ ...beside, stage: "information" }]), "occupied");
  assert.equal(state([{ ...beside, kind: "ROUTE_DEV" }]), "occupied");
});

const flight = (callsign, movement, due, more = {}) => ({ callsign, movement, type_designator: "A320", wake: "M", runway: "09", stand: "A_1", eta_ctd_ns: due * 1e9, ...more });

test("a flight is in the bay of what it does: by its clearances where there are any, else by map and speed", () => {
  const traffic = { movers: [
    { callsign: "D1", phase: "taxiing", stand: "A_1", runway: "09", cleared: [{ kind: "TAX", runway: "" }], waits: { for: "D2", at: "A (1-2)", since_s: 90, planned_s: -12 }, authority_m: [], planned_m: [], held: [] },
    { callsign: "D2", phase: "lined up", stand: "A_1", runway: "09", cleared: [{ kind: "LUP", runway: "09" }], authority_m: [], planned_m: [], held: [1] },
    { callsign: "A1", phase: "landing", stand: "A_1", runway: "09", cleared: [], authority_m: [], planned_m: [], held: [] },
  ], runways: [{ name: "09/27", owner: "A1", queue: 1 }] };
  const scan = scanOf(track(1, "A2", 500, 400), track(2, "A3", 1500, 0), track(3, "A4", 900, 300, { vx: 9 }), track(4, "A5", -5000, 0, { altitudeM: 300 }), track(5, "D3", 500, 400, { movement: "departure" }));
  const flights = [flight("D1", "departure", 60), flight("D2", "departure", 300), flight("A1", "arrival", 90), ...["A2", "A3", "A4", "A5"].map((c) => flight(c, "arrival", 10)),
    flight("D3", "departure", 500), flight("A9", "arrival", 500), flight("A8", "arrival", 20), flight("D9", "departure", 20), flight("CAR", "vehicle", 0)];
  const strips = stripsOf({ flights, scan, traffic, ground: new Ground(AIRPORT), timeS: 200 });
  assert.deepEqual(Object.fromEntries(strips.map((s) => [s.callsign, s.bay])), {
    D1: "hold", D2: "runway", A1: "runway", A2: "stand", A3: "runway", A4: "taxi-in", A5: "final", D3: "pending", A9: "expected", CAR: "vehicle",
  });
  const d1 = strips[0];
  assert.deepEqual([d1.cleared, d1.lateS, d1.derived, strips[3].derived], [["TAX"], 140, false, true]);
  assert.equal(waitText(d1), "waits for D2 at A (1-2), since T+ 01:30, 12 s late");
  assert.equal(waitText({ wants: "CRO" }), "waits for clearance CRO");
  assert.deepEqual(baysOf(strips).map(([key, , list]) => [key, list.length]), [["pending", 1], ["hold", 1], ["runway", 3], ["final", 1], ["taxi-in", 1], ["stand", 1], ["expected", 1], ["vehicle", 1]]);
  const facts = new Map(clearanceFacts({ callsign: "D1" }, traffic).map(([name, value]) => [name, value]));
  assert.equal(facts.get("Why"), waitText(d1));
  assert.equal(facts.get("Runway 09/27"), "in use by A1, 1 waiting");
  assert.deepEqual(clearanceFacts({ callsign: "X" }, traffic), []);
  assert.deepEqual(clearanceFacts(null, null), []);
});

test("a runway is free, reserved, occupied, or in alert, the gravest first", () => {
  const [runway] = AIRPORT.runways, ground = new Ground(AIRPORT), state = (more) => runwayState(runway, { ground, scan: scanOf(), traffic: null, alerts: [], ...more });
  const owned = { runways: [{ name: "09/27", owner: "A1", queue: 0 }], movers: [] }, there = scanOf(track(1, "A1", 1500, 3));
  assert.equal(state({}), "free");
  assert.equal(state({ traffic: owned }), "reserved");
  assert.equal(state({ traffic: owned, scan: there }), "occupied");
  assert.equal(state({ scan: scanOf(track(1, "A1", 1500, 3, { altitudeM: 200 })) }), "free", "flies over it");
  assert.equal(state({ scan: there, alerts: [{ ...alert("alarm"), place_m: [100, 5] }] }), "alert");
  assert.equal(state({ alerts: [{ ...alert("information"), place_m: [100, 5] }] }), "free");
});

test("a budget picks the most exact within it, a target the cheapest, and nothing where nothing does", () => {
  const row = (rung, error, us) => ({ rung, rmse_m: error, rmse_60s_m: null, us_per_track: us });
  const rows = [row("abg", 5, 1), row("ca3", 4, 2), row("imm3", 4.5, 4), row("mh9", 3, 9), row("new", null, null)];
  assert.equal(pick(rows, { us: 5 }).rung, "ca3");
  assert.equal(pick(rows, { us: 0.5 }), null);
  assert.equal(pick(rows, { m: 4.5 }).rung, "ca3");
  assert.equal(pick(rows, { m: 1 }), null);
  assert.deepEqual(front(rows).map((r) => r.rung), ["abg", "ca3", "mh9"]);
  assert.equal(errorOf({ rmse_m: 2, rmse_60s_m: 1 }), 1, "the last minute counts");
});

test("a pane tells what its sensor reported, what nothing caused, and whom it left out within its reach", () => {
  const plot = (sensor, truthIndex, errorM) => ({ sensor, truthIndex, errorM, x: 0, y: 0 });
  const scan = { truth: [{ x: 10, y: 0 }, { x: 20, y: 0 }, { x: 9000, y: 0 }], plots: [plot(1, 0, 3), plot(1, 0, 4), plot(1, -1, null), plot(2, 1, 1)] };
  const seen = sensorScan(scan, 1, { position_m: [0, 0], range_m: 5000 });
  assert.deepEqual([seen.plots.length, seen.ghosts.length, seen.missed.map((t) => t.x)], [3, 1, [20]]);
  assert.equal(seen.rms, Math.sqrt(12.5));
  assert.deepEqual(sensorScan(scan, 2, null).missed.map((t) => t.x), [10, 9000], "without a range everybody is within reach");
});

test("a stop bar that fails is crossed, dark or lit, and one that works is not", () => {
  const bar = (x, lit, failed) => ({ runway: "09/27", ends_m: [[x, -10], [x, 10]], lit, failed });
  const drawn = (bars) => {
    const strokes = [];
    let path = [];
    const g = { setLineDash(d) { this.dash = d.length; }, beginPath: () => (path = []), moveTo: (...p) => path.push([p]), lineTo: (...p) => path.at(-1).push(p), stroke() { strokes.push({ colour: this.strokeStyle, dash: this.dash, path }); } };
    const cam = { scale: 1, toScreen: (x, y) => [x, -y] }, c = { bar: "red", dim: "grey", select: "white" };
    paintPosition(g, { airport: null, cam, c, layers: { alerts: true }, said: { traffic: null, lights: { bars } }, scan: null, alerts: [] });
    return strokes.filter((s) => s.path.length);
  };
  assert.deepEqual(drawn([bar(0, true, false), bar(50, false, false)]).map((s) => [s.colour, s.dash]), [["grey", 2], ["red", 0]]);
  for (const lit of [true, false]) {
    const strokes = drawn([bar(0, lit, true), bar(50, lit, false)]), cross = strokes.at(-1);
    assert.deepEqual([cross.colour, cross.dash, cross.path.length], ["white", 0, 2]);
    for (const [a, b] of cross.path) assert.deepEqual([(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], [0, 0], "over the middle of the one that fails");
    assert.equal(strokes[0].path.length, 2, "both bars are drawn as lit or dark as they are");
  }
  assert.deepEqual(drawn([]), []);
});

test("tracks of others are drawn where they are, broken where they coast, and not at another time", () => {
  const cam = { toScreen: (x, y) => [x, -y] }, c = { "plot-other": "grey" };
  const foreign = [
    { source: "77/9", track: 5, time_s: 100, x_m: 10, y_m: 20, vx_ms: 2, vy_ms: 0, callsign: "SWR1", coasting: false },
    { source: "77/9", track: 6, time_s: 98, x_m: 50, y_m: 0, callsign: "", coasting: true },
    { source: "77/9", track: 7, time_s: 90, x_m: 70, y_m: 0, callsign: "", coasting: false },
  ];
  const drawn = (layers, scan) => {
    const strokes = [], texts = [];
    let path = [];
    const g = { setLineDash(d) { this.dash = d.length; }, beginPath: () => (path = []), moveTo: (...p) => path.push([p]), lineTo: (...p) => path.at(-1).push(p), stroke() { strokes.push({ colour: this.strokeStyle, dash: this.dash, path }); }, fillText: (...t) => texts.push(t[0]) };
    paintForeign(g, { cam, c, scan, layers, foreign });
    return { strokes, texts };
  };
  const all = drawn({ foreign: true, labels: true }, { timeS: 101 });
  assert.deepEqual(all.strokes.map((s) => [s.colour, s.dash, s.path.length]), [["grey", 0, 2], ["grey", 2, 1]]);
  assert.deepEqual(all.strokes[0].path[1], [[10, -20], [20, -20]], "to where it is in five seconds");
  assert.deepEqual(all.texts, ["SWR1 77/9", "6 77/9"]);
  assert.deepEqual(drawn({ foreign: true, labels: false }, { timeS: 101 }).texts, []);
  assert.deepEqual(drawn({ foreign: false, labels: true }, { timeS: 101 }).strokes, []);
  assert.deepEqual(foreignAt(foreign, { timeS: 92 }).map((t) => t.track), [7]);
  assert.deepEqual(foreignAt(foreign, null), []);
});

test("labels and facts show the stand that control gave, not the planned one", () => {
  const track = { id: "t4", number: 4, callsign: "SWR1", designator: "A320", wake: "M", movement: "arrival", runwayStand: "28/E_19", status: "confirmed", vx: 5, vy: 0, x: 0, y: 0, cov: [1, 0, 1], errorM: 1 };
  const movement = (given) => targetFacts(track, true, given).find(([name]) => name === "Movement")[1];
  assert.deepEqual([labelLines(track)[2], labelLines(track, "B_12")[2], labelLines({ ...track, runwayStand: "" }, "B_12")[2]], ["28/E 19", "28/B 12", undefined]);
  assert.deepEqual([movement(""), movement("B_12")], ["arrival 28/E 19", "arrival 28/B 12"]);
});

test("target times of a departure are on its strip and among its facts, those that it has", () => {
  const mover = { callsign: "D1", phase: "parked", stand: "A_1", runway: "09", cleared: [], authority_m: [], planned_m: [], held: [], targets: { tobt_s: 60, tsat_s: 120, ttot_s: 660, ctot_s: null } };
  const traffic = { movers: [mover], runways: [] };
  const [strip] = stripsOf({ flights: [flight("D1", "departure", 900)], scan: scanOf(), traffic, ground: new Ground(AIRPORT), timeS: 30 });
  assert.equal(targetText(strip.targets, String), "TOBT 60, TSAT 120, TTOT 660");
  assert.equal(targetText(null, String), "");
  const facts = clearanceFacts({ callsign: "D1" }, traffic, String).map(([name, value]) => `${name} ${value}`);
  assert.deepEqual(facts.filter((f) => /T /.test(f)), ["TOBT 60", "TSAT 120", "TTOT 660"]);
});

test("under controllers the target times are those that are said with their positions", () => {
  const mover = (callsign, targets) => ({ callsign, phase: "parked", stand: "A_1", runway: "09", cleared: [], authority_m: [], planned_m: [], held: [], targets });
  const traffic = { movers: [mover("D1", { tobt_s: null, tsat_s: null, ttot_s: null, ctot_s: 900 }), mover("D2", null), mover("D3", null)], runways: [] };
  const positions = { seats: [], answers: [], targets: ["D1", "D2"].map((callsign) => ({ callsign, tobt_s: 60, tsat_s: 120, ttot_s: 660 })) };
  const facts = (state, callsign) => clearanceFacts({ callsign }, withTargets(traffic, state), String).filter(([, , , what]) => /[Tt]arget|slot/.test(what)).map(([name, value]) => `${name} ${value}`);
  assert.deepEqual(facts(positions, "D1"), ["TOBT 60", "TSAT 120", "TTOT 660", "CTOT 900"]);
  assert.deepEqual(facts(positions, "D2"), ["TOBT 60", "TSAT 120", "TTOT 660"]);
  assert.deepEqual([facts(positions, "D3"), facts(null, "D2")], [[], []]);
  assert.equal(withTargets(null, positions), null);
});

test("greens, entry lights and take-off hold lights are drawn where they are lit, bars at their ends", () => {
  const strokes = [];
  let path = [];
  const g = { setLineDash() {}, beginPath: () => { path = []; }, moveTo: (x, y) => path.push(["m", x, y]), lineTo: (x, y) => path.push(["l", x, y]), stroke() { strokes.push([this.strokeStyle, path]); } };
  const cam = { toScreen: (x, y) => [x, y], scale: 1 }, c = { vehicle: "green", bar: "red", dim: "dim", select: "select" };
  const light = (x, lit) => ({ runway: "09/27", ends_m: [[x, 0], [x, 9]], lit });
  const said = {
    lights: { bars: [], entries: [light(1, true), light(2, false)], holds: [light(3, true)] },
    traffic: { movers: [], runways: [], greens: [{ callsign: "D1", segments: [1, 2], lines_m: [[[10, 0], [70, 0]], [[70, 0], [130, 0]]], bar_m: [[130, -5], [130, 5]] }] },
  };
  paintPosition(g, { airport: null, cam, c, layers: { alerts: true }, said, situation: null, scan: scanOf(), alerts: [], selected: null });
  const drawn = (colour) => strokes.filter(([style]) => style === colour).flatMap(([, points]) => points.map(([, x, y]) => `${x},${y}`));
  assert.deepEqual(drawn("green"), ["10,0", "70,0", "70,0", "130,0"]);
  assert.deepEqual(drawn("red"), ["1,0", "1,9", "3,0", "3,9", "130,-5", "130,5"]);
  strokes.length = 0;
  paintPosition(g, { airport: null, cam, c, layers: { alerts: false }, said, situation: null, scan: scanOf(), alerts: [], selected: null });
  assert.equal(strokes.length, 0, "with the layer of alerts and bars");
});
