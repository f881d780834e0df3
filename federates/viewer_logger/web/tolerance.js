// The other half of the dial: tolerances of the effect plan side by side, on the same truth and draws; a slider, budgets, a ghost.

import { Comparison, FEW } from "./comparison.js";
import { best } from "./scatter.js";
import { elapsed, fixed } from "./text.js";

const OF = { cost: (r) => r.ns_per_target ?? NaN, error: (r) => r.rmse_60s_m ?? NaN };
const name = (row) => (row.tolerance_m === 0 ? "exact" : `${Number(row.tolerance_m.toPrecision(3))} m`);

/** What a tolerance leaves out against the row before it on the slider: "gases of ASDE". */
export function leftOut(row) {
  return row.skipped.map(([sensor, effect, bound]) => `${effect} of ${sensor} (${bound})`);
}

/** The row that a budget chooses: the one of least error within `ns` a target, or the cheapest that keeps within `m` of everything exact. */
export function within(rows, { ns = null, m = null }) {
  const sure = rows.filter((r) => r.plots >= FEW);
  if (ns !== null) return best(sure, OF, { cost: ns });
  return best(sure, { cost: OF.cost, error: (r) => r.apart_60s_m ?? NaN }, { error: m });
}

export class TolerancePart extends Comparison {
  constructor(box, page) {
    super(box, page, {
      start: "Compare tolerances", stop: "Stop comparing tolerances", button: "compare-tolerances", slider: "tolerance", plot: "tolerance-plot", table: "tolerances", one: "tolerance", unit: "ns",
      label: "Effects: all exact \u2026 many left out", picture: "Error over cost of every tolerance",
      budgets: [["tolerance-ns", "at most, ns a target", "ns"], ["tolerance-m", "off exact at most, m", "m"]],
    });
  }

  ask(on, ghost) {
    return { type: "tolerances", on, ghost_m: ghost };
  }

  key(row) {
    return row.tolerance_m;
  }

  own(row) {
    return row.run;
  }

  name(row) {
    return name(row);
  }

  cost(row) {
    return OF.cost(row);
  }

  error(row) {
    return OF.error(row);
  }

  within(budget) {
    return within(this.rows(), budget);
  }

  asked(budget) {
    return budget.ns ? `at most ${budget.ns} ns a target` : `at most ${budget.m} m off everything exact`;
  }

  found(row) {
    return `${name(row)}, ${fixed(row.rmse_60s_m, 2)} m at ${fixed(row.ns_per_target, 0)} ns a target`;
  }

  choice(row) {
    return `${name(row)}${row.run ? ": the run\u2019s own" : ": ghost on the map, hollow"}`;
  }

  about(row) {
    const out = leftOut(row);
    return out.length ? `Left out, with what it could change at most: ${out.join("; ")}.` : "Nothing is left out.";
  }

  columns() {
    return ["Tolerance", "now m", "60 s m", "off exact m", "alone", "ns a target", "\u00b5s a scan", "left out", "cheaper", "Tracks"];
  }

  cells(r) {
    const sure = (value, digits) => (r.plots < FEW ? "too few" : fixed(value, digits));
    return [r.run ? `${name(r)} (run)` : name(r), fixed(r.rmse_now_m, 2), sure(r.rmse_60s_m, 2), sure(r.apart_60s_m, 3),
      r.alone_60s === null ? "\u2013" : `${fixed(100 * r.alone_60s, 2)} %`, fixed(r.ns_per_target, 0), fixed(r.scan_us, 0), String(r.skipped.length), String(r.cheaper), String(r.tracks)];
  }

  foot() {
    const { since_s: since, taken } = this.told;
    const share = taken < 0.995 ? ` ${fixed(100 * taken, 0)} % of the scans are taken: all would need more than 40 % of a core.` : "";
    return `Since ${elapsed(since)}, each with sensors and a tracker of its own on the same truth and draws. Off exact: distance of plots that both have; alone: plots that only one has. Times are of the sensors.${share}`;
  }
}
