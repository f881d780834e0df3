// Two runs on one clock: which tracks are of the same entity, and what is said of their difference.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Differences, paintHeat, paintHollow, pairsOf } from "../web/compare.js";

const track = (number, entity, x, y, more = {}) => ({ number, callsign: "", x, y, truth: entity === null ? null : { id: entity }, ...more });

test("tracks of both runs are paired by the entity that they follow, else by call sign, the farthest apart first", () => {
  const own = { tracks: [track(1, "e1", 0, 0, { callsign: "SWR1" }), track(2, "e2", 10, 0), track(3, null, 50, 50), track(4, null, 7, 0, { callsign: "DLH2" }), track(5, "e5", NaN, 0)] };
  const other = { tracks: [track(9, "e2", 10, 5), track(8, "e1", 0, 1, { callsign: "EDW9" }), track(7, null, 7, 3, { callsign: "DLH2" }), track(6, "e5", 0, 0)] };
  assert.deepEqual(pairsOf(own, other).map((p) => [p.name, p.other.number, p.apart]), [["#2", 9, 5], ["DLH2", 7, 3], ["SWR1", 8, 1]]);
  assert.deepEqual(pairsOf(null, other), []);
  const assumed = { tracks: [track(4, null, 7, 0, { callsign: "DLH2", assumed: true })] };
  assert.deepEqual(pairsOf(assumed, other), [], "a name that is in doubt pairs nothing");
});

test("no difference and too few are different words, and a time counts once", () => {
  const seen = new Differences(), pair = (apart) => ({ own: { x: 3, y: -3 }, apart });
  assert.match(seen.text, /too few/);
  for (let s = 0; s < 40; s++) seen.take(s, [pair(0)]);
  assert.equal(seen.text, "no difference in 40 pairs seen");
  for (let s = 40; s < 60; s++) seen.take(s, [pair(s === 41 ? 0 : 3)]);
  seen.take(59, [pair(100)]);
  assert.equal(seen.text, "0.95 m apart on average of 60 pairs seen, first at 40 s");
  assert.deepEqual([...seen.cells], [["0,-1", 3]], "the largest of its cell of 25 m");
});

test("the picture shows cells that differ and hollow tracks with lines, in their mode only", () => {
  const calls = [], g = new Proxy({}, { get: (_, name) => (...args) => calls.push([name, ...args]), set: () => true });
  const cam = { toScreen: (x, y) => [x, y] }, c = { error: "e", select: "s" }, compared = { mode: "difference", seen: new Differences() };
  compared.seen.take(1, [{ own: { x: 30, y: 30 }, apart: 4 }, { own: { x: 300, y: 30 }, apart: 0 }]);
  paintHeat(g, { cam, c, compared });
  assert.deepEqual(calls.filter(([name]) => ["moveTo", "lineTo"].includes(name)).map(([, ...p]) => p), [[25, 25], [50, 25], [50, 50], [25, 50]]);
  calls.length = 0;
  paintHeat(g, { cam, c, compared: { ...compared, mode: "ghost" } });
  assert.equal(calls.length, 0);
  paintHollow(g, { cam, c, scan: { tracks: [track(1, "e1", 0, 0)] }, others: new Map([[1, { tracks: [track(2, "e1", 5, 5), track(3, "e9", 8, 8)] }]]) });
  assert.deepEqual([calls.filter(([name]) => name === "arc").length, calls.filter(([name]) => name === "lineTo").length], [2, 1]);
});
