// The dial: every filter on the same plots, what it errs and what it costs; one slider over them, budgets that choose, a ghost on the map.

import { Comparison, FEW } from "./comparison.js";
import { best, front as frontOf } from "./scatter.js";
import { element, elapsed, fixed } from "./text.js";

const COST = (row) => row.us_per_track;

/** The most exact row within `us` a track, or the cheapest within `m`; null where none is. */
export const pick = (rows, { us = null, m = null }) => best(rows, { cost: COST, error: errorOf }, { cost: us, error: m });

/** Error over the last minute where it is known, else since the comparison began. */
export const errorOf = (row) => row.rmse_60s_m ?? row.rmse_m ?? NaN;

/** Rows that no other row beats in both, by cost. */
export const front = (rows) => frontOf(rows, { cost: COST, error: errorOf });

const few = (row, value) => (row.plots < FEW ? "too few" : fixed(value, 2));

export class Dial extends Comparison {
  constructor(box, page) {
    super(box, page, {
      start: "Compare all filters", stop: "Stop comparing", button: "compare", slider: "dial", plot: "dial-plot", table: "rungs", one: "filter", unit: "\u00b5s",
      label: "Filter, cheap to dear", picture: "Error over cost of every filter",
      budgets: [["budget-us", "at most, \u00b5s a track", "us"], ["budget-m", "at most, m", "m"]],
    });
  }

  ask(on, ghost) {
    return { type: "compare", on, ghost };
  }

  key(row) {
    return row.rung;
  }

  own(row) {
    return row.chosen;
  }

  name(row) {
    return row.rung;
  }

  cost(row) {
    return COST(row);
  }

  error(row) {
    return errorOf(row);
  }

  within(budget) {
    return pick(this.rows(), budget);
  }

  asked(budget) {
    return budget.us ? `at most ${budget.us} \u00b5s a track` : `at most ${budget.m} m`;
  }

  found(row) {
    return `${row.rung}, ${fixed(errorOf(row), 2)} m at ${fixed(row.us_per_track, 2)} \u00b5s a track`;
  }

  choice(row) {
    return row.chosen ? `${row.rung}: the run's own filter` : `${row.rung}: ghost on the map, hollow, with a line to the run's own track`;
  }

  columns() {
    return ["Filter", "now m", "60 s m", "all m", "ns a track", "\u00b5s a scan", "Tracks"];
  }

  cells(row) {
    const name = [row.chosen ? `${row.rung} (run)` : row.rung, element("small", row.about ?? "")];
    return [name, fixed(row.rmse_now_m, 2), few(row, row.rmse_60s_m), few(row, row.rmse_m), fixed(1000 * row.us_per_track, 0), fixed(row.scan_us, 0), String(row.tracks)];
  }

  foot() {
    const [first] = this.rows(), raw = this.rows().find((r) => r.chosen)?.raw_rmse_60s_m;
    return `Since ${elapsed(first.since_s)}, on the same plots; all filters began then. Errors: root mean square just after each radar plot of a moving target; those plots themselves have ${fixed(raw, 2)} m. ${this.told.left_out ?? ""}`;
  }
}

/** The ghost's tracks: hollow, each with a line to the run's own next to it. */
export function paintGhost(g, { cam, c, scan, ghost }) {
  if (!ghost?.length || !scan) return;
  g.strokeStyle = c.departure;
  g.lineWidth = 1.3;
  g.beginPath();
  for (const [x, y] of ghost) {
    const [px, py] = cam.toScreen(x, y);
    g.moveTo(px + 6, py);
    g.arc(px, py, 6, 0, 7);
    const own = scan.tracks.reduce((best, t) => (Math.hypot(t.x - x, t.y - y) < (best ? Math.hypot(best.x - x, best.y - y) : 60) ? t : best), null);
    if (own) {
      g.moveTo(px, py);
      g.lineTo(...cam.toScreen(own.x, own.y));
    }
  }
  g.stroke();
}
