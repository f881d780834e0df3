// The dial: every filter on the same plots, what it errs and what it costs; one slider over them, budgets that choose, a ghost on the map.

import { best, front as frontOf, scatter } from "./scatter.js";
import { element, elapsed, fixed } from "./text.js";

const COST = (row) => row.us_per_track;

/** The most exact row within `us` a track, or the cheapest within `m`; null where none is. */
export const pick = (rows, { us = null, m = null }) => best(rows, { cost: COST, error: errorOf }, { cost: us, error: m });

/** Error over the last minute where it is known, else since the comparison began. */
export const errorOf = (row) => row.rmse_60s_m ?? row.rmse_m ?? NaN;

/** Rows that no other row beats in both, by cost. */
export const front = (rows) => frontOf(rows, { cost: COST, error: errorOf });

const FEW = 30;

export class Dial {
  /** `send(message)`; `chosen()` when a ghost is asked for. */
  constructor(box, { send, chosen }) {
    Object.assign(this, { box, send, chosen, rungs: null, ghost: null });
    this.on = element("button", "Compare all filters", { type: "button", id: "compare", "aria-pressed": "false" });
    this.on.addEventListener("click", () => this.#ask(!this.rungs?.comparing, this.ghost));
    this.slider = element("input", [], { type: "range", id: "dial", min: 0, max: 0, step: 1, value: 0, list: "dial-ticks" });
    this.slider.addEventListener("input", () => this.#chose(Number(this.slider.value)));
    this.choice = element("p", "", { class: "choice", role: "status" });
    this.budget = this.#number("budget-us", "at most, \u00b5s a track", (v) => this.#within({ us: v }));
    this.target = this.#number("budget-m", "at most, m", (v) => this.#within({ m: v }));
    this.said = element("p", "", { class: "where", role: "status" });
    this.table = element("div", []);
    this.plot = element("canvas", [], { role: "img", "aria-label": "Error over cost of every filter", id: "dial-plot" });
    this.live = element("div", [
      element("label", "Filter, cheap to dear", { for: "dial" }), this.slider, this.choice,
      element("div", [this.budget, this.target], { class: "budgets" }), this.said, this.plot, this.table,
    ], { class: "dial" });
    box.append(this.on, this.live);
    this.live.hidden = true;
    new ResizeObserver(() => this.#scatter()).observe(this.plot);
  }

  #number(id, words, use) {
    const input = element("input", [], { type: "number", id, min: 0, step: "any", size: 6 });
    input.addEventListener("change", () => {
      const value = Number(input.value);
      if (input.value !== "" && value > 0) use(value);
    });
    return element("label", [words, input], { for: id });
  }

  #ask(on, ghost) {
    this.ghost = ghost;
    this.send({ type: "compare", on, ghost });
  }

  #chose(at) {
    const row = this.rungs?.rows[at];
    if (row) this.#ask(true, row.chosen ? null : row.rung);
    if (this.ghost !== null) this.chosen?.();
    this.draw();
  }

  /** No ghost any more. */
  release() {
    if (this.ghost === null) return;
    this.#ask(true, null);
    this.draw();
  }

  #within(budget) {
    const rows = this.rungs?.rows ?? [], row = pick(rows, budget);
    const asked = budget.us ? `at most ${budget.us} \u00b5s a track` : `at most ${budget.m} m`;
    this.said.textContent = row ? `For ${asked}: ${row.rung}, ${fixed(errorOf(row), 2)} m at ${fixed(row.us_per_track, 2)} \u00b5s a track.` : `No filter keeps ${asked} here.`;
    if (row) {
      this.slider.value = rows.indexOf(row);
      this.#chose(rows.indexOf(row));
    }
  }

  show(rungs) {
    this.rungs = rungs;
    this.draw();
  }

  draw() {
    const { rungs } = this, on = rungs?.comparing ?? false, rows = rungs?.rows ?? [];
    this.on.setAttribute("aria-pressed", String(on));
    this.on.textContent = on ? "Stop comparing" : "Compare all filters";
    this.live.hidden = !on;
    if (!on) return;
    this.slider.max = Math.max(0, rows.length - 1);
    const own = rows.findIndex((r) => r.chosen), at = rows.findIndex((r) => r.rung === this.ghost), row = rows[at >= 0 ? at : own];
    if (document.activeElement !== this.slider) this.slider.value = Math.max(0, at >= 0 ? at : own);
    this.slider.setAttribute("aria-valuetext", row ? row.rung : "");
    this.choice.textContent = !row ? "The first scan is awaited." : row.chosen ? `${row.rung}: the run's own filter` : `${row.rung}: ghost on the map, hollow, with a line to the run's own track`;
    this.#rows(rows);
    this.#scatter();
  }

  #rows(rows) {
    const few = (r, v) => (r.plots < FEW ? "too few" : fixed(v, 2));
    const cells = (r) => [[r.chosen ? `${r.rung} (run)` : r.rung, element("small", r.about ?? "")], fixed(r.rmse_now_m, 2), few(r, r.rmse_60s_m), few(r, r.rmse_m), fixed(1000 * r.us_per_track, 0), fixed(r.scan_us, 0), String(r.tracks)];
    const head = ["Filter", "now m", "60 s m", "all m", "ns a track", "\u00b5s a scan", "Tracks"].map((t, i) => element("th", t, { class: i ? "number" : null, scope: "col" }));
    const body = rows.map((r) => element("tr", cells(r).map((c, i) => element("td", c, { class: i ? "number" : null })), { "aria-selected": String(r.rung === this.ghost || (this.ghost === null && r.chosen)) }));
    const first = rows[0], raw = rows.find((r) => r.chosen)?.raw_rmse_60s_m;
    this.table.replaceChildren(element("table", [element("thead", element("tr", head)), element("tbody", body)], { id: "rungs" }),
      element("p", first ? `Since ${elapsed(first.since_s)}, on the same plots; all filters began then. Errors: root mean square just after each radar plot of a moving target; those plots themselves have ${fixed(raw, 2)} m. ${this.rungs.left_out ?? ""}` : "", { class: "where" }));
  }

  #scatter() {
    const points = (this.rungs?.rows ?? []).map((r) => ({ name: r.rung, cost: r.us_per_track, error: errorOf(r), own: r.chosen, ghost: r.rung === this.ghost }));
    scatter(this.plot, points, "\u00b5s");
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
