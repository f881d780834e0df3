// Where an effect of a radar's plan is on: rings and sectors round the radar, on the map and in the dial beside the list of effects. The
// server plans the scan (federates/viewer_logger/rings.rs). What is decided here without DOM: cells, their outlines, words and sums.

const TAU = 2 * Math.PI, AGAIN_MS = 1000;

/** Letter, word and meaning of each state, the least first: what is on lies over what is not. */
export const STATES = [
  { letter: "n", word: "not called for", means: "nothing there calls for it" },
  { letter: "s", word: "skipped", means: "left out: the tolerance allows what that changes" },
  { letter: "r", word: "reduced", means: "a cheaper form" },
  { letter: "e", word: "exact", means: "as exact as can be, or a table that equals that" },
];
const RANK = new Map(STATES.map((state, rank) => [state.letter, rank]));

/** Cells of one effect, in the order of drawing; null where the radar has no such effect. */
export function cellsOf(told, effect) {
  const at = told.effects.indexOf(effect);
  if (at < 0) return null;
  const cells = told.cells.map((cell) => ({
    near: cell.ring_m[0], far: cell.ring_m[1], low: cell.band_m[0], high: cell.band_m[1], sector: cell.sector, kind: cell.class, targets: cell.targets,
    state: told.whole[effect] ?? cell.states[at],
  }));
  return cells.sort((a, b) => RANK.get(a.state) - RANK.get(b.state) || a.near - b.near || a.sector - b.sector);
}

/** Bearings between which a sector lies, rad clockwise from north. */
export function bearings(sector, sectors) {
  return [(sector / sectors) * TAU, ((sector + 1) / sectors) * TAU];
}

/** Outline of a part of a ring round a site, m east and north: the far arc clockwise, then the near one back; a ring from the site itself ends there. */
export function wedge([x, y], near, far, sector, sectors, steps = 8) {
  const [from, to] = bearings(sector, sectors), out = [];
  const at = (r, k) => {
    const bearing = from + ((to - from) * k) / steps;
    return [x + r * Math.sin(bearing), y + r * Math.cos(bearing)];
  };
  for (let k = 0; k <= steps; k++) out.push(at(far, k));
  if (near > 0) for (let k = steps; k >= 0; k--) out.push(at(near, k));
  else out.push([x, y]);
  return out;
}

/** Edges of the rings up to what is displayed, m: 100 m times powers of the root of two. */
export function ringEdges(toM) {
  const out = [];
  for (let k = 0; 100 * 2 ** (k / 2) < toM; k++) out.push(100 * 2 ** (k / 2));
  return [...out, toM];
}

/** Radius in a dial of this radius for a distance: the rings of the lattice are equally wide, the first is the foot of the radar. */
export function dialRadius(metres, toM, radius) {
  const ring = (m) => 1 + Math.max(0, 2 * Math.log2(m / 100));
  return metres < 100 ? (radius * (metres / 100)) / ring(toM) : Math.min(radius, (radius * ring(metres)) / ring(toM));
}

/** Cells and targets in each state, those that are there, what is on first. */
export function sums(cells) {
  const of = (letter) => cells.filter((c) => c.state === letter);
  const count = (list) => list.reduce((sum, c) => sum + c.targets, 0);
  return [...STATES].reverse().map((state) => ({ ...state, cells: of(state.letter).length, targets: count(of(state.letter)) })).filter((s) => s.cells);
}

/** One sentence of where an effect is on. */
export function sentence(effect, cells) {
  if (!cells) return `${effect}: the radar's plan has no such effect.`;
  if (!cells.length) return `${effect}: no target is displayed.`;
  const some = (n, what) => `${n} ${what}${n === 1 ? "" : "s"}`;
  return `${effect} \u2013 ${sums(cells).map((s) => `${s.word}: ${some(s.targets, "target")} in ${some(s.cells, "cell")}`).join("; ")}.`;
}

/** Bearings of a cell as people read them: "22.5–45°". */
export function sectorText(sector, sectors) {
  const degrees = (k) => String(Number(((k * 360) / sectors).toFixed(1)));
  return `${degrees(sector)}\u2013${degrees(sector + 1)}\u00b0`;
}

/** Side of a tile of the patterns on the map, pixels: lines for what is reduced, dots for what is skipped. */
const TILE = 8;

/** The picture on the map. */
export class Rings {
  /** `changed()`: something else is to be drawn. */
  constructor(changed) {
    Object.assign(this, { changed, chosen: null, run: "", told: null, why: "", asking: false, wanted: null, askedAt: 0, patterns: new Map() });
  }

  /** An effect of a sensor: { sensor, effect }, or null for none; of the scan shown of a run. */
  want(chosen, scan, run = "") {
    const other = chosen?.sensor !== this.chosen?.sensor || run !== this.run;
    this.run = run;
    const again = other || chosen?.effect !== this.chosen?.effect;
    this.chosen = chosen;
    if (other) this.told = null;
    this.wanted = chosen && Number.isFinite(scan) ? scan : null;
    if (again) this.changed();
    this.#ask();
  }

  get cells() {
    return this.told && this.chosen ? cellsOf(this.told, this.chosen.effect) : null;
  }

  async #ask() {
    const { chosen, wanted, run } = this;
    if (this.asking || !chosen || wanted === null || (this.told?.scan === wanted && this.told.sensor === chosen.sensor)) return;
    // Live scans may come faster than anybody reads.
    const rest = this.askedAt + AGAIN_MS - performance.now();
    clearTimeout(this.later);
    if (rest > 0 && this.told) {
      this.later = setTimeout(() => this.#ask(), rest);
      return;
    }
    const token = sessionStorage.getItem("token"), before = this.#key();
    this.asking = true;
    this.askedAt = performance.now();
    try {
      const answer = await fetch(`/rings?${new URLSearchParams({ sensor: chosen.sensor, scan: wanted, ...(run && { run }) })}`, token ? { headers: { Authorization: `Bearer ${token}` } } : {});
      if (!answer.ok) throw new Error((await answer.text()).trim());
      const told = await answer.json();
      if (this.chosen?.sensor === told.sensor && this.run === run) Object.assign(this, { told, why: "" });
    } catch (error) {
      Object.assign(this, { told: null, why: error.message });
    }
    this.asking = false;
    if (this.#key() !== before) this.changed();
    if (this.run !== run || (!this.why && this.wanted !== wanted)) this.#ask();
  }

  #key() {
    return JSON.stringify([this.chosen, this.why, this.cells]);
  }

  /** Draws cells, rings and sectors; `c` has the colours. */
  paint(g, cam, c) {
    const { told, cells } = this;
    if (!told || !cells) return;
    const [sx, sy] = cam.toScreen(...told.site_m);
    g.save();
    g.strokeStyle = c.dim;
    g.lineWidth = 1;
    g.globalAlpha = 0.3;
    g.beginPath();
    for (const edge of ringEdges(told.to_m)) {
      g.moveTo(sx + edge * cam.scale, sy);
      g.arc(sx, sy, edge * cam.scale, 0, TAU);
    }
    for (let k = 0; k < told.sectors; k++) {
      const [bearing] = bearings(k, told.sectors), end = (r) => [told.site_m[0] + r * Math.sin(bearing), told.site_m[1] + r * Math.cos(bearing)];
      g.moveTo(...cam.toScreen(...end(100)));
      g.lineTo(...cam.toScreen(...end(told.to_m)));
    }
    g.stroke();
    for (const cell of cells) this.#cell(g, cam, c, cell);
    g.restore();
  }

  #cell(g, cam, c, cell) {
    const colour = c[`plan-${STATES[RANK.get(cell.state)].word.replaceAll(" ", "-")}`];
    g.beginPath();
    wedge(this.told.site_m, cell.near, cell.far, cell.sector, this.told.sectors).forEach(([x, y], i) => g[i ? "lineTo" : "moveTo"](...cam.toScreen(x, y)));
    g.closePath();
    if (cell.state === "e") {
      g.globalAlpha = 0.3;
      g.fillStyle = colour;
      g.fill();
    } else if (cell.state !== "n") {
      g.globalAlpha = 0.75;
      g.fillStyle = this.#pattern(g, cell.state, colour);
      g.fill();
    }
    g.globalAlpha = 0.95;
    g.strokeStyle = colour;
    g.lineWidth = cell.state === "e" ? 2 : 1.2;
    g.setLineDash(cell.state === "n" ? [3, 4] : []);
    g.stroke();
    g.setLineDash([]);
  }

  #pattern(g, state, colour) {
    const key = state + colour;
    if (!this.patterns.has(key)) {
      const tile = document.createElement("canvas");
      tile.width = tile.height = TILE;
      const t = tile.getContext("2d");
      t.strokeStyle = t.fillStyle = colour;
      t.lineWidth = 1.4;
      t.beginPath();
      if (state === "r") {
        for (const k of [-TILE, 0, TILE]) {
          t.moveTo(k, TILE);
          t.lineTo(k + TILE, 0);
        }
        t.stroke();
      } else {
        t.arc(TILE / 2, TILE / 2, 1.1, 0, TAU);
        t.fill();
      }
      this.patterns.set(key, g.createPattern(tile, "repeat"));
    }
    return this.patterns.get(key);
  }
}

const SVG = "http://www.w3.org/2000/svg";

function shape(tag, attributes, parts = []) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...parts);
  return made;
}

/** The pattern of a state, for `fill`. */
function tileOf(letter) {
  const mark = letter === "r" ? shape("path", { d: "M-2 8L8 -2M0 10L10 0M-2 2L2 -2", class: "lines" }) : shape("circle", { cx: 3, cy: 3, r: 1, class: "dots" });
  return shape("pattern", { id: `plan-${letter}`, width: letter === "r" ? 6 : 5, height: letter === "r" ? 6 : 5, patternUnits: "userSpaceOnUse" }, [mark]);
}

/** What a shape of a state wears: its pattern is in the dial; full ones take their colour from the style sheet. */
const worn = (letter) => ({ "data-state": letter, fill: letter === "r" || letter === "s" ? `url(#plan-${letter})` : "none" });

/** A patch of a state for the legend. */
export function patch(letter) {
  return shape("svg", { class: "patch", width: 26, height: 14, "aria-hidden": "true" }, [shape("rect", { x: 1, y: 1, width: 24, height: 12, ...worn(letter) })]);
}

/** The dial: north up, rings equally wide, filled where the effect is on. */
export function dial(told, cells, words) {
  const size = 220, middle = size / 2, radius = 100;
  const at = (r, bearing) => `${(middle + r * Math.sin(bearing)).toFixed(2)} ${(middle - r * Math.cos(bearing)).toFixed(2)}`;
  const line = [...ringEdges(told.to_m).map((m) => dialRadius(m, told.to_m, radius))];
  const parts = [shape("defs", {}, ["r", "s"].map(tileOf))];
  for (const r of line) parts.push(shape("circle", { cx: middle, cy: middle, r: r.toFixed(2), class: "edge" }));
  for (let k = 0; k < told.sectors; k++) {
    const [bearing] = bearings(k, told.sectors);
    parts.push(shape("path", { d: `M${at(line[0], bearing)}L${at(radius, bearing)}`, class: "edge" }));
  }
  for (const cell of cells) {
    const [from, to] = bearings(cell.sector, told.sectors), [near, far] = [cell.near, cell.far].map((m) => dialRadius(m, told.to_m, radius));
    const back = near > 0 ? `L${at(near, to)}A${near.toFixed(2)} ${near.toFixed(2)} 0 0 0 ${at(near, from)}Z` : `L${at(0, 0)}Z`;
    parts.push(shape("path", { d: `M${at(far, from)}A${far.toFixed(2)} ${far.toFixed(2)} 0 0 1 ${at(far, to)}${back}`, ...worn(cell.state) }));
  }
  const north = shape("text", { x: middle, y: 8, "text-anchor": "middle" }, ["N"]);
  return shape("svg", { class: "rings", viewBox: `0 0 ${size} ${size}`, role: "img", "aria-label": words }, [...parts, north]);
}
