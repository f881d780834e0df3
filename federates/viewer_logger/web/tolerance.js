// The other half of the dial: tolerances of the effect plan side by side, on the same truth and draws; a slider, budgets, a ghost.

import { best, scatter } from "./scatter.js";
import { element, elapsed, fixed } from "./text.js";

/** Fewer plots say nothing. */
const FEW = 30;
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

export class TolerancePart {
  /** `send(message)`; `chosen()` when a ghost is asked for. */
  constructor(box, { send, chosen }) {
    Object.assign(this, { send, chosen, told: null, ghost: null });
    this.on = element("button", "Compare tolerances", { type: "button", id: "compare-tolerances", "aria-pressed": "false" });
    this.on.addEventListener("click", () => this.#ask(!this.told?.comparing, this.ghost));
    this.slider = element("input", [], { type: "range", id: "tolerance", min: 0, max: 0, step: 1, value: 0 });
    this.slider.addEventListener("input", () => this.#chose(Number(this.slider.value)));
    this.choice = element("p", "", { class: "choice", role: "status" });
    this.said = element("p", "", { class: "where", role: "status" });
    this.out = element("p", "", { class: "where" });
    this.table = element("div", []);
    this.plot = element("canvas", [], { role: "img", "aria-label": "Error over cost of every tolerance", id: "tolerance-plot", class: "scatter" });
    this.live = element("div", [
      element("label", "Effects: all exact \u2026 many left out", { for: "tolerance" }), this.slider, this.choice, this.out,
      element("div", [this.#number("tolerance-ns", "at most, ns a target", (v) => this.#within({ ns: v })), this.#number("tolerance-m", "off exact at most, m", (v) => this.#within({ m: v }))], { class: "budgets" }),
      this.said, this.plot, this.table,
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
    this.send({ type: "tolerances", on, ghost_m: ghost });
  }

  #chose(at) {
    const row = this.told?.rows[at];
    if (row) this.#ask(true, row.run ? null : row.tolerance_m);
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
    const rows = this.told?.rows ?? [], row = within(rows, budget);
    const asked = budget.ns ? `at most ${budget.ns} ns a target` : `at most ${budget.m} m off everything exact`;
    this.said.textContent = row ? `For ${asked}: ${name(row)}, ${fixed(row.rmse_60s_m, 2)} m at ${fixed(row.ns_per_target, 0)} ns a target.` : `No tolerance keeps ${asked} here.`;
    if (row) {
      this.slider.value = rows.indexOf(row);
      this.#chose(rows.indexOf(row));
    }
  }

  show(told) {
    this.told = told;
    this.draw();
  }

  draw() {
    const on = this.told?.comparing ?? false, rows = this.told?.rows ?? [];
    this.on.setAttribute("aria-pressed", String(on));
    this.on.textContent = on ? "Stop comparing tolerances" : "Compare tolerances";
    this.live.hidden = !on;
    if (!on) return;
    this.slider.max = Math.max(0, rows.length - 1);
    const own = rows.findIndex((r) => r.run), at = rows.findIndex((r) => r.tolerance_m === this.ghost), row = rows[at >= 0 ? at : own];
    if (document.activeElement !== this.slider) this.slider.value = Math.max(0, at >= 0 ? at : own);
    this.slider.setAttribute("aria-valuetext", row ? name(row) : "");
    const out = row ? leftOut(row) : [];
    this.out.textContent = out.length ? `Left out, with what it could change at most: ${out.join("; ")}.` : row ? "Nothing is left out." : "";
    this.choice.textContent = !row ? this.told.why_not || "The first scan is awaited." : `${name(row)}${row.run ? ": the run\u2019s own" : ": ghost on the map, hollow"}`;
    this.#rows(rows);
    this.#scatter();
  }

  #rows(rows) {
    const cells = (r) => [r.run ? `${name(r)} (run)` : name(r), fixed(r.rmse_now_m, 2), r.plots < FEW ? "too few" : fixed(r.rmse_60s_m, 2), r.plots < FEW ? "too few" : fixed(r.apart_60s_m, 3),
      r.alone_60s === null ? "\u2013" : `${fixed(100 * r.alone_60s, 2)} %`, fixed(r.ns_per_target, 0), fixed(r.scan_us, 0), String(r.skipped.length), String(r.cheaper), String(r.tracks)];
    const titles = ["Tolerance", "now m", "60 s m", "off exact m", "alone", "ns a target", "\u00b5s a scan", "left out", "cheaper", "Tracks"];
    const head = titles.map((t, i) => element("th", t, { class: i ? "number" : null, scope: "col" }));
    const body = rows.map((r) => element("tr", cells(r).map((c, i) => element("td", c, { class: i ? "number" : null })), { "aria-selected": String(r.tolerance_m === this.ghost || (this.ghost === null && r.run)) }));
    const { since_s: since, taken } = this.told;
    const share = taken < 0.995 ? ` ${fixed(100 * taken, 0)} % of the scans are taken: all would need more than 40 % of a core.` : "";
    this.table.replaceChildren(element("table", [element("thead", element("tr", head)), element("tbody", body)], { id: "tolerances" }),
      element("p", rows.length ? `Since ${elapsed(since)}, each with sensors and a tracker of its own on the same truth and draws. Off exact: distance of plots that both have; alone: plots that only one has. Times are of the sensors.${share}` : "", { class: "where" }));
  }

  #scatter() {
    scatter(this.plot, (this.told?.rows ?? []).map((r) => ({ name: name(r), cost: OF.cost(r), error: OF.error(r), own: r.run, ghost: r.tolerance_m === this.ghost })), "ns");
  }
}
