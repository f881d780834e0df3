// Tools on the map: range and bearing lines that stick to targets, a search, latitude and longitude. The figures are pure functions.

import { element } from "./text.js";
import { targetsOf } from "./traffic.js";

const NM = 1852, MOST_LINES = 8, KNOT = 1.943844;

/** Metres, nautical miles and true bearing from a to b; between moving ones when and how near they come to each other. */
export function rangeAndBearing(a, b) {
  const dx = b.x - a.x, dy = b.y - a.y, metres = Math.hypot(dx, dy), bearing = ((Math.atan2(dx, dy) * 180) / Math.PI + 360) % 360;
  const vx = (b.vx || 0) - (a.vx || 0), vy = (b.vy || 0) - (a.vy || 0), v2 = vx * vx + vy * vy;
  const time = v2 > 0.25 ? -(dx * vx + dy * vy) / v2 : null, ahead = time !== null && time > 0;
  return { metres, bearing, cpaS: ahead ? time : null, cpaM: ahead ? Math.hypot(dx + vx * time, dy + vy * time) : null };
}

export function rangeText({ metres, bearing, cpaS, cpaM }) {
  const far = metres >= NM ? `${(metres / NM).toFixed(2)} NM` : `${metres.toFixed(0)} m`;
  return `${far}  ${String(Math.round(bearing) % 360).padStart(3, "0")}\u00b0${cpaS === null ? "" : `  nearest ${cpaM.toFixed(0)} m in ${cpaS.toFixed(0)} s`}`;
}

/** Latitude and longitude, degrees, of a point of the local plane: WGS 84 radii of curvature at the reference point. */
export function latLon(x, y, [lat0, lon0]) {
  const a = 6_378_137, e2 = 0.00669437999014, s = Math.sin((lat0 * Math.PI) / 180), w = Math.sqrt(1 - e2 * s * s);
  const north = (a * (1 - e2)) / (w * w * w), east = (a / w) * Math.cos((lat0 * Math.PI) / 180);
  return [lat0 + (y / north) * (180 / Math.PI), lon0 + (x / east) * (180 / Math.PI)];
}

/** Targets, stands and taxiways that a text is in: call sign, type, number, address, name. */
export function found(text, scan, airport, layers) {
  const word = text.trim().toUpperCase();
  if (!word) return [];
  const has = (...names) => names.some((n) => n && String(n).toUpperCase().includes(word));
  const targets = targetsOf(scan, layers).filter((t) => has(t.callsign, t.designator, `#${t.number}`, t.address, t.runwayStand, t.status)).map((t) => ({ id: t.id, x: t.x, y: t.y, name: t.callsign || t.id }));
  const exact = (n) => n.toUpperCase().replaceAll("_", " ") === word.replaceAll("_", " ");
  const stands = (airport?.stands ?? []).filter((s) => s.name && exact(s.name)).map((s) => ({ id: null, x: s.position_m[0], y: s.position_m[1], name: s.name }));
  const ways = (airport?.taxiways ?? []).filter((w) => w.name && exact(w.name)).slice(0, 1).map((w) => ({ id: null, x: w.points_m[0][0], y: w.points_m[0][1], name: w.name }));
  return [...targets, ...stands, ...ways].slice(0, 200);
}

export class Tools {
  constructor(map) {
    this.map = map;
    this.lines = [];
    this.from = null;
    this.hits = [];
    this.measuring = false;
  }

  /** A click while measuring: the first end, then the second. Ends are targets by name, or places. */
  click(id, [x, y]) {
    if (!this.measuring) return false;
    const target = this.map.find(id), end = target ? { name: target.callsign || `#${target.number}` } : { x, y };
    if (this.from) {
      this.lines = [...this.lines, [this.from, end]].slice(-MOST_LINES);
      this.from = null;
      this.measuring = false;
    } else this.from = end;
    this.map.dirty();
    return true;
  }

  clear() {
    this.lines = [];
    this.from = null;
    this.measuring = false;
    this.hits = [];
    this.map.dirty();
  }

  /** Where an end is now; null while its target is not in the picture. */
  at(end) {
    if (end.name === undefined) return end;
    const { scan } = this.map;
    return [...(scan?.tracks ?? []), ...(scan?.truth ?? [])].find((t) => t.callsign === end.name || `#${t.number}` === end.name) ?? null;
  }

  /** As the address has it. */
  pairs() {
    const text = (end) => end.name ?? `${end.x.toFixed(0)}_${end.y.toFixed(0)}`;
    return this.lines.map((line) => line.map(text));
  }

  setPairs(pairs) {
    const end = (text) => {
      const m = /^(-?\d+(?:\.\d+)?)_(-?\d+(?:\.\d+)?)$/.exec(text);
      return m ? { x: Number(m[1]), y: Number(m[2]) } : { name: text };
    };
    this.lines = pairs.map((pair) => pair.map(end)).slice(0, MOST_LINES);
    this.map.dirty();
  }

  paint(g, map) {
    g.strokeStyle = g.fillStyle = map.c.select;
    g.lineWidth = 1;
    g.font = "11px B612, sans-serif";
    g.textAlign = "center";
    g.textBaseline = "bottom";
    for (const line of this.lines) {
      const [a, b] = line.map((end) => this.at(end));
      if (!a || !b) continue;
      const [p, q] = [map.toScreen(a.x, a.y), map.toScreen(b.x, b.y)], text = rangeText(rangeAndBearing(a, b));
      g.setLineDash([5, 3]);
      g.beginPath();
      g.moveTo(...p);
      g.lineTo(...q);
      g.stroke();
      g.setLineDash([]);
      const x = (p[0] + q[0]) / 2, y = (p[1] + q[1]) / 2 - 4, w = g.measureText(text).width + 8;
      g.fillStyle = map.c.ground;
      g.fillRect(x - w / 2, y - 14, w, 15);
      g.fillStyle = map.c.select;
      g.fillText(text, x, y);
    }
    for (const hit of this.hits) {
      g.beginPath();
      g.arc(...map.toScreen(hit.x, hit.y), 14, 0, 7);
      g.stroke();
    }
  }
}

/** Ten steps through the page, each at what it speaks of. */
const STEPS = [
  ["#map", "The map", "Outlines are the truth, filled symbols the tracks that the system made of its sensors, magenta lines the errors between. Drag to move, wheel to zoom."],
  ["#tracks", "Targets", "Every track, and every target that no track follows. A click selects; D and U step through them."],
  ["#target", "One target", "Figures, a close-up and its error over the whole run; a click on the curve shows that moment."],
  ["#tab-effects", "Effects", "What every simulated effect did to the plots of the selected target: rain, ground, lobing, noise."],
  ["#tab-filter", "Filters", "The same plots through cheaper and more exact filters, while the run goes on."],
  ["#line", "Time", "A bar grows and turns from grey to magenta with the worst error of each moment; the notches are 7.5 m. Marks are events; [ and ] go from one to the next, J takes a time, A and B make a loop."],
  ["#layers", "Layers", "What is drawn; keys 1 to 9. Each sensor's plots have a switch of their own."],
  ["#skin", "A controller's view", "Leaves out what only a simulation knows. R and the wheel turn the map."],
  ["#export", "Take it away", "The whole view stands in the address: copy the link, save the picture or the tables."],
  ["#help-button", "Keys", "All keys are listed here. What if… makes a finished run again from the time shown, with something changed. What the tower sees: the address with /eye."],
];

/** Shows the steps; `done` is called at the end, or when it is skipped. */
export function tutorial(done) {
  const box = element("dialog", [], { class: "tutorial", "aria-live": "polite" });
  let step = 0;
  const mark = (on) => document.querySelector(STEPS[step][0])?.classList.toggle("pointed", on);
  const show = () => {
    const [, title, text] = STEPS[step], last = step === STEPS.length - 1;
    const next = element("button", last ? "Done" : "Next", { type: "button" }), skip = element("button", "Skip", { type: "button" });
    next.addEventListener("click", () => go(step + 1));
    skip.addEventListener("click", () => go(STEPS.length));
    box.replaceChildren(element("h2", `${step + 1}/${STEPS.length}  ${title}`), element("p", text), element("div", last ? [next] : [skip, next], { class: "buttons" }));
    mark(true);
    next.focus();
  };
  const go = (to) => {
    mark(false);
    step = to;
    if (step < STEPS.length) return show();
    box.remove();
    done();
  };
  box.addEventListener("keydown", (event) => event.key === "Escape" && go(STEPS.length));
  document.body.append(box);
  box.show();
  show();
}
