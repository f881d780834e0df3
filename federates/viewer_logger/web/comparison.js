// Several choices side by side, beside a run that goes on or on a finished one: a switch, one slider over them, budgets that
// choose, a ghost on the map, a table and a picture of error over cost. What is compared says the rest.

import { scatter } from "./scatter.js";
import { element } from "./text.js";

/** Fewer plots say nothing. */
export const FEW = 30;

/** How far a finished run has been gone through. */
export function wayOf(done, leftS) {
  const left = Number.isFinite(leftS) && leftS >= 2 ? `, ${leftS < 90 ? `${Math.round(leftS)} s` : `${Math.round(leftS / 60)} min`} left` : "";
  return `The two minutes before the time shown are gone through: ${Math.round(100 * done)} %${left}.`;
}

/**
 * What a subclass says: `words` (ids and texts of the parts), and of what was told `rows()`, `key(row)` (that the ghost is named by),
 * `own(row)` (the run's), `name(row)`, `cost(row)`, `error(row)`, `ask(on, ghost)` (the message), `within(budget)` (the row it
 * chooses), `asked(budget)`, `found(row)`, `choice(row)`, `columns()`, `cells(row)`, `foot()`, and, where there is more to say, `about(row)`.
 */
export class Comparison {
  /** `send(message)`; `chosen()` when a ghost is asked for. */
  constructor(box, { send, chosen }, words) {
    Object.assign(this, { send, chosen, words, told: null, ghost: null });
    this.on = element("button", words.start, { type: "button", id: words.button, "aria-pressed": "false" });
    this.on.addEventListener("click", () => this.#ask(!this.told?.comparing, this.ghost));
    this.slider = element("input", [], { type: "range", id: words.slider, min: 0, max: 0, step: 1, value: 0 });
    this.slider.addEventListener("input", () => this.#chose(Number(this.slider.value)));
    this.choiceText = element("p", "", { class: "choice", role: "status" });
    this.progress = element("progress", [], { max: 1, value: 0, "aria-label": words.start });
    this.more = element("p", "", { class: "where" });
    this.said = element("p", "", { class: "where", role: "status" });
    this.table = element("div", []);
    this.plot = element("canvas", [], { role: "img", "aria-label": words.picture, id: words.plot });
    const budgets = words.budgets.map(([id, label, key]) => this.#budget(id, label, key));
    this.live = element("div", [
      element("label", words.label, { for: words.slider }), this.slider, this.progress, this.choiceText, this.about ? this.more : [],
      element("div", budgets, { class: "budgets" }), this.said, this.plot, this.table,
    ], { class: "dial" });
    box.append(this.on, this.live);
    this.live.hidden = true;
    new ResizeObserver(() => this.#scatter()).observe(this.plot);
  }

  #budget(id, label, key) {
    const input = element("input", [], { type: "number", id, min: 0, step: "any", size: 6 });
    input.addEventListener("change", () => {
      const value = Number(input.value);
      if (input.value !== "" && value > 0) this.#within({ [key]: value });
    });
    return element("label", [label, input], { for: id });
  }

  #ask(on, ghost) {
    this.ghost = ghost;
    this.send(this.ask(on, ghost));
  }

  #chose(at) {
    const row = this.rows()[at];
    if (row) this.#ask(true, this.own(row) ? null : this.key(row));
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
    const row = this.within(budget), asked = this.asked(budget);
    this.said.textContent = row ? `For ${asked}: ${this.found(row)}.` : `No ${this.words.one} keeps ${asked} here.`;
    if (row) {
      this.slider.value = this.rows().indexOf(row);
      this.#chose(this.rows().indexOf(row));
    }
  }

  show(told) {
    this.told = told;
    this.draw();
  }

  rows() {
    return this.told?.rows ?? [];
  }

  /** The ghost, or the run's own while there is none. */
  #shown(row) {
    return this.ghost === null ? this.own(row) : this.key(row) === this.ghost;
  }

  draw() {
    const on = this.told?.comparing ?? false, rows = this.rows();
    this.on.setAttribute("aria-pressed", String(on));
    this.on.textContent = on ? this.words.stop : this.words.start;
    this.live.hidden = !on;
    if (!on) return;
    const done = this.told.done ?? 1, working = done < 1;
    this.progress.hidden = !working;
    this.progress.value = done;
    this.slider.disabled = this.plot.hidden = this.table.hidden = !rows.length;
    this.slider.max = Math.max(0, rows.length - 1);
    const ghost = rows.findIndex((r) => this.key(r) === this.ghost), at = ghost >= 0 ? ghost : rows.findIndex((r) => this.own(r)), row = rows[at];
    if (document.activeElement !== this.slider) this.slider.value = Math.max(0, at);
    this.slider.setAttribute("aria-valuetext", row ? this.name(row) : "");
    this.choiceText.textContent = row ? this.choice(row) : this.told.why_not || (working ? wayOf(done, this.told.left_s) : "The first scan is awaited.");
    this.more.textContent = (row && this.about?.(row)) || "";
    const number = (i) => ({ class: i ? "number" : null });
    const head = this.columns().map((t, i) => element("th", t, { ...number(i), scope: "col" }));
    const body = rows.map((r) => element("tr", this.cells(r).map((c, i) => element("td", c, number(i))), { "aria-selected": String(this.#shown(r)) }));
    this.table.replaceChildren(element("table", [element("thead", element("tr", head)), element("tbody", body)], { id: this.words.table }),
      element("p", rows.length ? this.foot() : "", { class: "where" }));
    this.#scatter();
  }

  #scatter() {
    scatter(this.plot, this.rows().map((r) => ({ name: this.name(r), cost: this.cost(r), error: this.error(r), own: this.own(r), ghost: this.key(r) === this.ghost })), this.words.unit);
  }
}
