// Tolerances beside the run: what a budget chooses, and what is never said of too few plots.
import assert from "node:assert/strict";
import { test } from "node:test";
import { best, front } from "../web/scatter.js";
import { leftOut, within } from "../web/tolerance.js";

const row = (tolerance_m, ns_per_target, rmse_60s_m, apart_60s_m, more = {}) => ({ tolerance_m, ns_per_target, rmse_60s_m, apart_60s_m, plots: 200, skipped: [], ...more });
const ROWS = [row(0, 2000, 1.2, 0), row(0.1, 500, 1.21, 0.06), row(0.5, 300, 1.3, 0.4), row(2, 310, 1.5, 1.1)];

test("a budget of time picks the least error, a bound on the distance the cheapest", () => {
  assert.equal(within(ROWS, { ns: 600 }).tolerance_m, 0.1);
  assert.equal(within(ROWS, { ns: 305 }).tolerance_m, 0.5);
  assert.equal(within(ROWS, { ns: 5000 }).tolerance_m, 0);
  assert.equal(within(ROWS, { m: 0.1 }).tolerance_m, 0.1);
  assert.equal(within(ROWS, { m: 9 }).tolerance_m, 0.5, "cheaper than the looser one");
  assert.equal(within(ROWS, { ns: 10 }), null);
});

test("too few plots choose nothing, and a row without figures is no choice", () => {
  assert.equal(within([row(0.1, 10, 0.1, 0.1, { plots: 29 })], { ns: 600 }), null);
  assert.equal(within([row(0.1, null, 1, 1), row(0.5, 5, null, null)], { ns: 600 }), null);
});

test("the front is what no other row beats in both", () => {
  const of = { cost: (r) => r.ns_per_target, error: (r) => r.rmse_60s_m };
  assert.deepEqual(front(ROWS, of).map((r) => r.tolerance_m), [0.5, 0.1, 0]);
  assert.equal(best([], of, { cost: 1 }), null);
  assert.equal(best(ROWS, of, {}), null);
});

test("what is left out is named with its sensor and what it could change", () => {
  assert.deepEqual(leftOut({ skipped: [["ASDE", "gases", "3.4e-2 dB"]] }), ["gases of ASDE (3.4e-2 dB)"]);
});
