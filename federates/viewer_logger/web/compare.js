// A second run beside the first on the same clock: hollow with lines between the same entities, or their difference as a heat map.
// Side by side it has a pane of its own (`panes.js`).

import { sound } from "./traffic.js";
import { element, fixed } from "./text.js";

export const COMPARED = ["side", "ghost", "difference"];
const CELL_M = 25, MOST_CELLS = 20_000, FULL_M = 15, MOST_ROWS = 8, FEW = 30;

/** What a track follows, or what it is called where nobody may know. */
const keyOf = (t) => t.truth?.id ?? (t.callsign && !t.assumed ? t.callsign : null);

/** Tracks of both that follow the same entity (its DIS identifier): [{ name, own, other, apart }], the farthest apart first. */
export function pairsOf(scan, other) {
  if (!scan || !other) return [];
  const theirs = new Map(other.tracks.filter(sound).map((t) => [keyOf(t), t]));
  const pairs = [];
  for (const own of scan.tracks.filter(sound)) {
    const key = keyOf(own), found = key === null ? undefined : theirs.get(key);
    if (found) pairs.push({ name: own.callsign || `#${own.number}`, own, other: found, apart: Math.hypot(own.x - found.x, own.y - found.y) });
  }
  return pairs.sort((a, b) => b.apart - a.apart);
}

/** The largest difference seen in each cell of 25 m, and the pairs of every moment, since both runs are compared. */
export class Differences {
  cells = new Map();
  sum = 0;
  count = 0;
  #seen = new Set();
  #first = null;

  /** Takes the pairs of a time, each time once. */
  take(timeS, pairs) {
    if (this.#seen.has(timeS)) return;
    this.#seen.add(timeS);
    for (const { own, apart } of pairs) {
      this.sum += apart;
      this.count++;
      if (apart > 0 && (this.#first === null || timeS < this.#first)) this.#first = timeS;
      const key = `${Math.floor(own.x / CELL_M)},${Math.floor(own.y / CELL_M)}`;
      if (this.cells.has(key) || this.cells.size < MOST_CELLS) this.cells.set(key, Math.max(this.cells.get(key) ?? 0, apart));
    }
  }

  /** The difference of all moments seen, in words. */
  get text() {
    if (this.count < FEW) return `too few to say (${this.count} pairs seen)`;
    if (this.#first === null) return `no difference in ${this.count} pairs seen`;
    return `${fixed(this.sum / this.count, 2)} m apart on average of ${this.count} pairs seen, first at ${fixed(this.#first, 0)} s`;
  }
}

/** Which comparison is on, what it has seen, and its table. */
export class Compared {
  mode = null;
  seen = new Differences();

  /** `box` takes choice and table; `page` has map, names() of the runs shown, changed(). */
  constructor(box, page) {
    this.page = page;
    this.choice = element("select", [["", "in grey"], ["side", "side by side"], ["ghost", "hollow, with lines"], ["difference", "their difference"]].map(([value, text]) => element("option", text, { value })), { id: "compare-runs" });
    this.choice.addEventListener("change", () => this.set(this.choice.value || null));
    this.table = element("table", [element("caption", ""), element("tbody", [])], { class: "compared" });
    this.line = element("p", [element("label", "The other run ", { for: "compare-runs" }), this.choice], { class: "pair" });
    box.append(this.line, this.table);
    this.show();
  }

  set(mode) {
    this.mode = COMPARED.includes(mode) ? mode : null;
    this.choice.value = this.mode ?? "";
    this.seen = new Differences();
    this.page.changed();
    this.page.map.need("traffic");
    this.scan();
  }

  /** Of other runs than before nothing is known. */
  forget() {
    this.seen = new Differences();
    this.show();
  }

  /** The other run's scan has come, which is sent after the first one's of the same moment. */
  scan() {
    const { map } = this.page, other = map.others.get(1);
    if (this.mode === "difference" && map.scan && other) this.seen.take(map.scan.timeS, pairsOf(map.scan, other));
    if (this.mode) map.need("traffic");
    this.show();
  }

  show() {
    const { map } = this.page, several = this.page.names().length > 1, shows = several && this.mode === "difference";
    this.line.hidden = !several;
    this.table.hidden = !shows;
    if (!shows) return;
    const row = (cells) => element("tr", cells.map((c, i) => element(i ? "td" : "th", c, i ? { class: "number" } : { scope: "row" })));
    const text = `${this.page.names()[0]} and ${this.page.names()[1]}: ${this.seen.text}. Farthest apart now:`;
    if (this.table.caption.textContent !== text) this.table.caption.textContent = text;
    this.table.tBodies[0].replaceChildren(...pairsOf(map.scan, map.others.get(1)).slice(0, MOST_ROWS).map((p) => row([p.name, `${fixed(p.apart, 2)} m`])));
  }
}

/** Over the airport, under the targets: the cells by how far apart the runs were there. */
export function paintHeat(g, { cam, c, compared }) {
  if (compared?.mode !== "difference") return;
  const half = CELL_M / 2, style = g.fillStyle;
  g.fillStyle = c.error;
  for (const [key, apart] of compared.seen.cells) {
    if (!(apart > 0)) continue;
    const [i, j] = key.split(",").map(Number), middle = [i * CELL_M + half, j * CELL_M + half];
    const corners = [[-half, -half], [half, -half], [half, half], [-half, half]].map(([dx, dy]) => cam.toScreen(middle[0] + dx, middle[1] + dy));
    g.globalAlpha = 0.08 + 0.6 * Math.min(1, apart / FULL_M);
    g.beginPath();
    corners.forEach((p, k) => (k ? g.lineTo(...p) : g.moveTo(...p)));
    g.fill();
  }
  g.globalAlpha = 1;
  g.fillStyle = style;
}

/** The tracks of the others hollow, each with a line to the same entity of the first run. */
export function paintHollow(g, { cam, c, scan, others }) {
  g.strokeStyle = c.select;
  g.lineWidth = 1.3;
  g.beginPath();
  for (const other of others.values()) {
    for (const t of other.tracks.filter(sound)) {
      const [x, y] = cam.toScreen(t.x, t.y);
      g.moveTo(x + 6, y);
      g.arc(x, y, 6, 0, 7);
    }
    for (const { own, other: theirs } of pairsOf(scan, other)) {
      g.moveTo(...cam.toScreen(own.x, own.y));
      g.lineTo(...cam.toScreen(theirs.x, theirs.y));
    }
  }
  g.stroke();
}
