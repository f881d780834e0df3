// What lists and cards of the page share: a table that sorts, pairs of facts.

import { STILL_MPS } from "./situation.js";
import { element, fixed, NONE, place } from "./text.js";
import { placeOf } from "./traffic.js";

const KNOT = 1.943844;

/** Rows of a table, at most. */
const MOST_ROWS = 200;

/** A table that sorts by the head clicked, keeps its rows and shows which one is selected. */
export class Table {
  /** columns: { key, title, hint, read(item) → value to sort by, show(item) → text, number } */
  constructor(table, columns, { id, onSelect, sortBy }) {
    this.columns = columns;
    this.id = id;
    this.onSelect = onSelect;
    this.sort = { key: sortBy, down: false };
    this.items = [];
    this.selected = null;
    this.body = table.tBodies[0];
    this.rows = new Map();
    const head = element("tr", columns.map((column) => {
      const button = element("button", column.title, { type: "button", title: column.hint ?? column.title });
      button.addEventListener("click", () => this.#sortBy(column.key));
      return element("th", button, { scope: "col", class: column.number ? "number" : null, "data-key": column.key });
    }));
    this.head = head;
    table.tHead.append(head);
    this.#markSort();
  }

  #sortBy(key) {
    this.sort = { key, down: this.sort.key === key ? !this.sort.down : false };
    this.#markSort();
    this.show(this.items);
  }

  #markSort() {
    for (const cell of this.head.cells) {
      cell.setAttribute("aria-sort", cell.dataset.key !== this.sort.key ? "none" : this.sort.down ? "descending" : "ascending");
    }
  }

  select(id) {
    this.selected = id;
    for (const [key, row] of this.rows) row.setAttribute("aria-selected", String(key === id));
    this.rows.get(id)?.scrollIntoView({ block: "nearest" });
  }

  /** Ids in the order shown. */
  order() {
    return [...this.body.rows].map((row) => row.dataset.id);
  }

  show(items) {
    this.items = items;
    const column = this.columns.find((c) => c.key === this.sort.key);
    const sorted = [...items].sort((a, b) => compare(column.read(a), column.read(b)) * (this.sort.down ? -1 : 1) || compare(this.id(a), this.id(b)));
    const seen = new Set();
    // What nobody scrolls to costs nothing: the selected row is always there.
    const chosen = sorted.findIndex((item) => this.id(item) === this.selected);
    if (chosen >= MOST_ROWS) sorted.splice(MOST_ROWS - 1, 0, ...sorted.splice(chosen, 1));
    const more = sorted.length - MOST_ROWS;
    sorted.length = Math.min(sorted.length, MOST_ROWS);
    this.body.parentElement.dataset.more = more > 0 ? `${more} more: search or sort to see them` : "";
    sorted.forEach((item, i) => {
      const id = this.id(item);
      seen.add(id);
      const row = this.rows.get(id) ?? this.#row(id);
      this.columns.forEach((c, k) => {
        const text = (c.show ?? c.read)(item) ?? NONE;
        if (row.cells[k].textContent !== text) row.cells[k].textContent = text;
        const mark = c.mark?.(item) ?? "";
        if (row.cells[k].dataset.mark !== mark) row.cells[k].dataset.mark = mark;
      });
      if (this.body.rows[i] !== row) this.body.insertBefore(row, this.body.rows[i] ?? null);
    });
    for (const [id, row] of this.rows) {
      if (seen.has(id)) continue;
      row.remove();
      this.rows.delete(id);
    }
  }

  #row(id) {
    const row = element("tr", this.columns.map((c) => element("td", "", { class: c.number ? "number" : null })),
      { "data-id": id, "aria-selected": String(id === this.selected) });
    if (this.onSelect) {
      row.tabIndex = 0;
      row.addEventListener("click", () => this.onSelect(id));
      row.addEventListener("keydown", (event) => {
        if (event.key === "Enter") this.onSelect(id);
      });
    }
    this.rows.set(id, row);
    return row;
  }
}

/** Made once: a comparison that makes its own costs fifty times as much. */
const WORDS = new Intl.Collator("en", { numeric: true });

function compare(a, b) {
  const empty = (v) => v === null || v === undefined || v === "" || Number.isNaN(v);
  if (empty(a) || empty(b)) return Number(empty(a)) - Number(empty(b));
  return typeof a === "number" && typeof b === "number" ? a - b : WORDS.compare(String(a), String(b));
}

/** Knots; a target that hardly moves stands, as its label says. */
export function speedKt(t) {
  const mps = Math.hypot(t.vx, t.vy);
  return mps < STILL_MPS ? 0 : mps * KNOT;
}
export const headingDeg = (t) => (((t.heading * 180) / Math.PI) % 360 + 360) % 360;

/** Facts as a list of pairs; keeps the elements between calls so that nothing flickers. */
export function facts(list, pairs) {
  while (list.children.length > pairs.length * 2) list.lastChild.remove();
  while (list.children.length < pairs.length * 2) list.append(element("dt", ""), element("dd", ""));
  pairs.forEach(([name, value, mark, hint], i) => {
    const [dt, dd] = [list.children[2 * i], list.children[2 * i + 1]];
    if (dt.textContent !== name) dt.textContent = name;
    if (dd.textContent !== value) dd.textContent = value;
    dd.dataset.mark = mark ?? "";
    dt.title = hint ?? "";
  });
}

/** What is known of a target; `blind`: without what only truth can tell; `given`: the stand that it has now. */
export function targetFacts(t, blind = false, given = "") {
  if (!t) return [];
  const rows = [];
  if (t.number !== undefined) {
    rows.push(["Track", `${t.number} ${t.status}`], ["Type", [t.designator, t.wake].filter(Boolean).join("/") || (t.callsign ? NONE : "not identified yet")]);
    rows.push(["Movement", [t.movement, placeOf(t.runwayStand, given).replaceAll("_", " ")].filter(Boolean).join(" ") || NONE]);
  } else rows.push(["Track", "none", "missing"], ["Type", t.designator || NONE]);
  rows.push(["Speed", `${fixed(speedKt(t), 0)} kt`], ["Course", Number.isFinite(t.heading) ? `${fixed(headingDeg(t), 0)}\u00b0` : NONE]);
  rows.push(["Position", place(t.x, t.y), "", "From the airport's reference point"]);
  if (t.number !== undefined) {
    if (!blind) rows.push(["Error", t.errorM === null ? "no truth" : `${fixed(t.errorM, 2)} m`, t.errorM === null ? "missing" : "error", "Distance of the track from truth"]);
    const sigma = Math.sqrt(t.cov[0] + t.cov[2]);
    rows.push(["Claimed \u03c3", Number.isFinite(sigma) ? `${fixed(sigma, 2)} m` : NONE, "", "The error that the track itself expects: its standard deviation"]);
  }
  return rows;
}

/** A time in the unit that suits it; zero is not measured. */
export function duration(us) {
  if (!(us > 0)) return NONE;
  return us < 10 ? `${fixed(us, 0)} \u00b5s` : `${fixed(us / 1000, us < 10000 ? 2 : 0)} ms`;
}
