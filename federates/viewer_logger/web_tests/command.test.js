// What a typed line means in a run, against what the flights are planned to do; completion and the lines of before.
import assert from "node:assert/strict";
import { test } from "node:test";
import { completed, Past } from "../web/command.js";
import { alongOf, completions, conflictOf, contextOf, crossedBy, meant } from "../web/meant.js";

// An east-west runway 10/28 along y = 0; taxiway A along y = 200 and B across the runway at x = 500.
const airport = {
  runways: [{ designators: ["10", "28"], ends: [[0, 0], [2000, 0]], width_m: 45 }, { designators: ["16", "34"], ends: [[3000, 1000], [3000, -1000]], width_m: 45 }],
  taxiways: [{ name: "A", points_m: [[0, 200], [1000, 200]] }, { name: "A", points_m: [[1000, 200], [2000, 200]] }, { name: "B", points_m: [[500, 200], [500, 90]] }, { name: "C", points_m: [[0, 400], [2000, 400]] }],
  stands: [{ name: "A 14", position_m: [1500, 300] }, { name: "S9", position_m: [900, -300] }],
};
const flights = [
  { callsign: "SWR137H", movement: "departure", runway: "28", stand: "A 14" }, { callsign: "SWR37H", movement: "arrival", runway: "28", stand: "S9" },
  { callsign: "EDW229", movement: "arrival", runway: "10", stand: "S9" }, { callsign: "FOLLOW1", movement: "vehicle", runway: "", stand: "" },
];
const traffic = {
  movers: [
    { callsign: "SWR137H", stand: "A_14", runway: "28", authority_m: [[1500, 200], [1200, 200]], planned_m: [[1200, 200], [500, 200], [500, 90]], cleared: [] },
    { callsign: "SWR37H", stand: "A_14", runway: "28", authority_m: [], planned_m: [[500, 100], [500, -200], [900, -200]], cleared: [{ kind: "LND", runway: "28" }] },
  ],
};
const context = contextOf({ airport, flights, traffic, selected: "EDW229" });
const orders = (line) => meant(line, context).orders?.map((o) => `${o.callsign} ${o.clearance}`) ?? meant(line, context);

test("a line gives the clearances that a click gives, with or without what the plan says anyway", () => {
  for (const line of ["swr137h t", "137h tax A B hold 28", "137H T hold", " 137H  t  A hold 28"]) assert.deepEqual(orders(line), ["SWR137H TAX"], line);
  assert.deepEqual(orders("137H t; tof"), ["SWR137H TAX", "SWR137H TOF"]);
  assert.deepEqual(orders(". lnd"), ["EDW229 LND"]);
  assert.deepEqual(orders("swr37h x 10"), ["SWR37H CRO"], "either end names the runway that is crossed");
  assert.deepEqual(orders("swr37h t stand A_14"), ["SWR37H TAX"], "the stand that control gave, not that of the flight list");
  assert.equal(meant("137H t; tof", context).line, "137H t hold 28; tof 28");
  assert.equal(meant("swr37h x", context).line, "swr37h x 10");
  assert.equal(meant("137H t a hold 28", context).orders[0].words, "SWR137H: taxi A hold short of 28");
});

test("what the flight is not planned to do is refused in words, at its column", () => {
  const refused = (line) => {
    const { error, column, text } = meant(line, context);
    assert.ok(text?.length > 8, line);
    return [error, column];
  };
  for (const [line, error, column] of [
    ["137H t C hold 28", "other_way", 7], ["137H t A hold 10", "other_runway", 14], ["137H t stand S9", "other_limit", 13], ["137H tof 10", "other_runway", 9],
    ["137H x 28", "other_runway", 7], ["swr37h x 34", "other_runway", 9], ["swr37h t stand S9", "other_limit", 15], ["swr37h t hold 28", "other_limit", 14], ["137H cto", "not_said_here", 5], ["137H p left", "not_said_here", 7],
    ["137H t A hold 28 follow 229", "not_said_here", 27], ["137H tof 28; lup 10", "other_runway", 17],
  ]) assert.deepEqual(refused(line), [error, column], line);
  // Errors of the grammar keep their column in the line as it was typed, whatever was completed before.
  assert.deepEqual(refused("137H t; walk"), ["unknown_kind", 8]);
  assert.deepEqual(refused("follow1 t"), ["missing_limit", 9], "a vehicle without a plan has to be told how far");
  assert.deepEqual(refused("37H t"), ["ambiguous_callsign", 0]);
});

test("ways are known by the taxiways they lie on and the runways they come over", () => {
  assert.deepEqual(alongOf([[1500, 203], [500, 203], [500, 90]], airport.taxiways), ["A", "B"]);
  assert.deepEqual(alongOf([[1500, 215], [500, 215]], airport.taxiways), []);
  assert.deepEqual(crossedBy([[500, 100], [500, -100], [4000, -100]], airport.runways), [["10", "28"], ["16", "34"]]);
  assert.deepEqual(crossedBy([[500, 100], [500, 30]], airport.runways), []);
});

test("a clearance that excludes a standing one is asked back, unless who enters is behind who rolls", () => {
  const of = (line, places) => conflictOf(meant(line, context).messages[0], { airport, traffic, places });
  assert.equal(of("137H tof"), "SWR37H is cleared LND 28");
  assert.equal(of("137H u", new Map([["SWR137H", [1900, 60]], ["SWR37H", [2600, 0]]])), "SWR37H is cleared LND 28", "28 lands westward: it has not come by");
  assert.equal(of("137H u", new Map([["SWR137H", [1900, 60]], ["SWR37H", [900, 0]]])), "");
  assert.equal(of("137H t"), "");
  assert.equal(of("swr37h lnd"), "", "its own");
});

test("Tab offers what may stand there, and nothing else", () => {
  assert.deepEqual(completions("SWR", context), ["SWR137H", "SWR37H"]);
  assert.deepEqual(completions("229", context), ["EDW229"]);
  assert.deepEqual(completions("137H t A ho", context), ["HOLD"]);
  assert.deepEqual(completions("137H t A hold ", context), ["10", "28", "16", "34"]);
  assert.deepEqual(completions("follow1 T", context), ["TAX"], "no TOF for a vehicle");
  assert.deepEqual(completed("edw", context), { line: "EDW229 ", more: [] });
  assert.deepEqual(completed("137H t stand a", context), { line: "137H t stand A_14 ", more: [] });
  assert.equal(completed("swr", context).line, "SWR");
  assert.equal(completed("zz", context), null);
});

test("lines of before come again, and what was being typed after them", () => {
  const past = new Past(["a", 7, "b"]);
  assert.deepEqual([past.step(-1, "draft"), past.step(-1, "b"), past.step(-1, "a"), past.step(1, "a"), past.step(1, "b"), past.step(1, "draft")], ["b", "a", "a", "b", "draft", "draft"]);
  past.add("a");
  assert.deepEqual(past.lines, ["b", "a"], "once");
  for (let i = 0; i < 99; i++) past.add(`line ${i}`);
  assert.equal(past.lines.length, 50);
});
