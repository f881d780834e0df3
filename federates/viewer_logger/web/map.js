// The map on its canvas: two bitmaps larger than the view, airport and traffic, that panning only shifts. They are drawn
// again for a new scan, when a movement of the map ends, or when their margin is used up; labels are placed once a scan.
// Work is done in steps, some milliseconds in each animation frame: place, draw the traffic, draw the airport. What is being
// drawn becomes seen when it is whole.

import { Bitmap, MARGIN } from "./bitmap.js";
import { Camera } from "./camera.js";
import { paintHeat, paintHollow } from "./compare.js";
import { kinds, setKinds } from "./frame.js";
import { placing, thin } from "./labels.js";
import { paintAirport, paintScale } from "./paint.js";
import { stagesOf } from "./alerts.js";
import { Detection } from "./detection.js";
import { paintForeign } from "./foreign.js";
import { paintGhost } from "./dial.js";
import { listen } from "./pointer.js";
import { paintAlerts, paintPosition } from "./position.js";
import { Ground, pointsOf } from "./situation.js";
import { colourOf, paintingLabels, paintingTraffic, paintSelected, sound, targetsOf } from "./traffic.js";
import { nameOf, Wishes } from "./wishes.js";

const SETTLE_MS = 120, ZOOM_MS = 80;
/** Work of a frame, ms: what a step takes beyond it and the picture come on top. */
const WORK_MS = 8;
/** Putting two bitmaps together takes a graphics card less, ms. */
const SLOW_MS = 12;

export const LAYERS = [
  ["tracks", "Tracks"], ["truth", "Truth"], ["errors", "Errors"], ["labels", "Labels"], ["history", "History"],
  ["vectors", "Vectors"], ["ellipses", "Ellipses"], ["weather", "Weather"], ["taxiways", "Taxi names"],
  ["stands", "Stands"], ["coverage", "Coverage"], ["detection", "Detection"], ["plots", "Plots"], ["buildings", "Buildings"], ["one second ago", "A scan ago"], ["alerts", "Alerts, bars"], ["routes", "Ways"], ["video", "Radar video"], ["foreign", "Others' tracks"],
];
const OFF = new Set(["coverage", "detection", "one second ago", "video"]);

export class MapView {
  constructor(canvas, changed) {
    this.canvas = canvas;
    this.changed = changed;
    this.g = canvas.getContext("2d", { alpha: false });
    this.cam = new Camera();
    this.ground = new Bitmap();
    this.traffic = new Bitmap();
    this.next = new Bitmap(); // the traffic that is being drawn
    this.job = null;
    this.wishes = new Wishes();
    this.whole = new Bitmap(false);
    this.touched = false; // whether the user chose the view
    this.layers = Object.fromEntries(LAYERS.map(([key]) => [key, !OFF.has(key)]));
    Object.assign(this, { sensorsOff: new Set(), airport: null, scan: null, weather: null, selected: null, follow: false, lod: "auto", skin: "research", vectorS: 15, dots: 30, others: new Map() });
    Object.assign(this, { ghost: null, foreign: [], alerts: [], said: { traffic: null, lights: null }, stands: new Map() }); // what is said beside the scans
    Object.assign(this, { placed: new Map(), before: new Map(), dragged: new Map(), hidden: [], todo: new Set(), longestMs: 0, drawn: 0, overlays: [] });
    this.run = ""; // name of the run that is looked at
    this.detection = new Detection(null, () => this.need("ground"), "pd", () => this.run);
    listen(this);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    // What lies over the map is measured when it changes, never in a drawing.
    const over = new ResizeObserver(() => this.#measureOverlays());
    for (const e of canvas.parentElement.querySelectorAll("#layers, #zoom, #past, #labels-hidden")) over.observe(e);
    this.colours();
    this.resize();
  }

  // ---- state ----

  get view() {
    return this.cam;
  }

  setAirport(airport) {
    this.airport = airport;
    setKinds(airport.kinds ?? []);
    this.colours();
    this.situation = new Ground(airport);
    this.bounds = pointsOf(airport);
    if (!this.touched) this.fit();
    this.need("ground", "place");
  }

  setScan(scan) {
    this.scan = scan;
    if (this.follow) this.#centreOnSelected();
    this.need("place");
  }

  /** Another run: its targets are others, whatever they are called. */
  forgetLabels() {
    Object.assign(this, { placed: new Map(), before: new Map(), placedScan: null });
  }

  /** Labels as whoever comes by a link finds them: from nothing. */
  placeAfresh() {
    Object.assign(this, { before: new Map(), placedScan: this.scan?.scan ?? null });
    this.need("place");
  }

  /** Alerts that stand, and what traffic and stop bars say. */
  setSaid({ alerts = this.alerts, traffic = this.said.traffic, lights = this.said.lights }) {
    const again = JSON.stringify(alerts.map((a) => [a.id, a.stage, a.subjects])) !== JSON.stringify(this.alerts.map((a) => [a.id, a.stage, a.subjects]));
    Object.assign(this, { alerts, said: { traffic, lights }, stands: new Map((traffic?.movers ?? []).map((m) => [m.callsign, m.stand])) });
    this.need(again ? "place" : "traffic");
  }

  /** Tracks of somebody else's tracker, as they came last. */
  setForeign(tracks) {
    this.foreign = tracks;
    this.need("traffic");
  }

  /** The scan of another run on the same clock, or null where it has none. */
  setOther(run, scan) {
    if (scan) this.others.set(run, scan);
    else this.others.delete(run);
    this.need("traffic");
  }

  /** Colours out of the style sheet, after a change of day and night. */
  colours() {
    const style = getComputedStyle(document.documentElement);
    const names = ["ground", "pavement", "pavement-edge", "runway", "runway-mark", "taxi", "taxi-name", "stand", "text", "dim",
      "arrival", "departure", "vehicle", "unknown", "truth", "error", "rain", "coverage", "halo", "select", "label-back", "alarm", "information", "bar", "video", "plan-exact", "plan-reduced", "plan-skipped", "plan-not-called-for",
      ...kinds.map((k) => `plot-${k.word}`), "plot-other"];
    this.c = Object.fromEntries(names.map((n) => [n, style.getPropertyValue(`--${n}`).trim()]));
    this.need("ground", "traffic");
  }

  resize() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    this.ratio = window.devicePixelRatio || 1;
    this.cam.width = Math.max(1, Math.round(box.width));
    this.cam.height = Math.max(1, Math.round(box.height));
    this.canvas.width = Math.round(this.cam.width * this.ratio);
    this.canvas.height = Math.round(this.cam.height * this.ratio);
    this.canvas.style.width = `${this.cam.width}px`;
    this.canvas.style.height = `${this.cam.height}px`;
    if (!this.touched && this.airport) this.fit();
    this.#measureOverlays();
    this.need("ground", "place");
  }

  get width() {
    return this.cam.width;
  }

  get height() {
    return this.cam.height;
  }

  // ---- view ----

  toScreen(x, y) {
    return this.cam.toScreen(x, y);
  }

  toMetres(px, py) {
    return this.cam.toMetres(px, py);
  }

  look(view) {
    if (!this.cam.look(view)) return;
    this.#moved();
  }

  fit() {
    if (this.bounds?.length) this.look(this.cam.fitting(this.bounds, 44));
  }

  fitTargets() {
    this.follow = false;
    const points = [...(this.scan?.tracks ?? []), ...(this.scan?.truth ?? [])].filter(sound);
    if (!points.length) return;
    this.touched = true;
    this.look(this.cam.fitting(points.flatMap((p) => [[p.x - 80, p.y - 80], [p.x + 80, p.y + 80]]), 80));
    this.changed();
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    this.touched = true;
    this.look(this.cam.zoomed(factor, px, py));
    if (this.follow) this.#centreOnSelected();
    this.changed();
  }

  pan(dx, dy) {
    this.touched = true;
    this.follow = false;
    this.look(this.cam.panned(dx, dy));
    this.changed();
  }

  rotate(degrees) {
    this.touched = true;
    this.look({ rot: this.cam.rot + degrees });
    this.changed();
  }

  /** The runway nearest to the middle points up, whichever of its ends needs the smaller turn. */
  runwayUp() {
    const middle = ([a, b]) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
    const far = (r) => Math.hypot(middle(r.ends)[0] - this.cam.cx, middle(r.ends)[1] - this.cam.cy);
    const nearest = [...(this.airport?.runways ?? [])].sort((p, q) => far(p) - far(q))[0];
    if (!nearest) return;
    const [a, b] = nearest.ends, bearing = (Math.atan2(b[0] - a[0], b[1] - a[1]) * 180) / Math.PI;
    const turn = (to) => ((to - this.cam.rot + 540) % 360) - 180;
    const best = Math.abs(turn(bearing)) <= Math.abs(turn(bearing + 180)) ? bearing : bearing + 180;
    this.look({ rot: Math.abs(turn(best)) < 0.01 ? best + 180 : best });
    this.changed();
  }

  northUp() {
    this.look({ rot: 0 });
    this.changed();
  }

  setFollow(on) {
    this.follow = on && this.selected !== null;
    if (this.follow) {
      this.touched = true;
      if (this.cam.scale < 0.6) this.look({ scale: 1.2 });
      this.#centreOnSelected();
    }
    this.changed();
  }

  #centreOnSelected() {
    const target = this.find(this.selected);
    if (target && sound(target)) this.look({ cx: target.x, cy: target.y });
  }

  find(id) {
    if (id === null || !this.scan) return null;
    return this.scan.tracks.find((t) => t.id === id) ?? this.scan.truth.find((t) => t.id === id) ?? null;
  }

  /** The map moved: shift the bitmaps now, draw them again when it comes to rest. */
  #moved() {
    clearTimeout(this.settling);
    // While a finger or a button is down the map is not at rest, however slow the frames.
    if (!this.held) this.settling = setTimeout(() => this.rest(), SETTLE_MS);
    const now = performance.now(), shifted = this.placedFor?.scale === this.cam.scale && this.placedFor?.rot === this.cam.rot;
    if (!this.ground.covers(this.cam) && !(now - this.lastDrawn < ZOOM_MS)) this.need("ground", shifted ? "traffic" : "place");
    else this.dirty();
  }

  /** At rest the view is what the address can say of it, so that a link shows the very same picture. */
  rest() {
    const { cx, cy, scale, rot } = this.cam, to = (v, digits) => Number(v.toFixed(digits));
    if (this.touched) this.cam.look({ cx: to(cx, 1), cy: to(cy, 1), scale: to(scale, 4), rot: to(rot, 2) });
    this.need("ground", "place");
  }

  // ---- what is under the pointer ----

  /** A person moves a label: it keeps its offset from now on. */
  dragLabel(label, dx, dy) {
    const name = nameOf(label.item.target), old = this.dragged.get(name) ?? { dx: label.dx, dy: label.dy };
    this.dragged.set(name, { dx: old.dx + dx, dy: old.dy + dy });
    this.onDragged?.(this.dragged);
    this.need("place");
  }

  /** The label at a pixel. */
  labelAt(px, py) {
    const [dx, dy] = this.#labelShift();
    return [...this.placed.values()].find((p) => px - dx >= p.x && px - dx <= p.x + p.w && py - dy >= p.y && py - dy <= p.y + p.h) ?? null;
  }

  /** The target whose symbol or label is at this pixel. */
  pick(px, py) {
    let best = null, nearest = 16;
    for (const target of targetsOf(this.scan, this.layers)) {
      const [x, y] = this.toScreen(target.x, target.y), d = Math.hypot(x - px, y - py);
      if (d < nearest) [best, nearest] = [target, d];
    }
    if (best) return best;
    const label = this.labelAt(px, py);
    return label ? this.find(label.id) : null;
  }

  /** How far the map has moved since the labels were placed, pixels. */
  #labelShift(cam = this.cam) {
    if (!this.placedFor) return [0, 0];
    const [x, y] = cam.toScreen(this.placedFor.cx, this.placedFor.cy);
    return [x - cam.width / 2, y - cam.height / 2];
  }

  /** Labels as they are on the screen now. */
  get labels() {
    return this.#labelsOf(this.cam);
  }

  #labelsOf(cam) {
    const [dx, dy] = this.#labelShift(cam);
    return new Map([...this.placed].map(([id, p]) => [id, { ...p, x: p.x + dx, y: p.y + dy, ax: p.ax + dx, ay: p.ay + dy, sx: p.item.x + dx, sy: p.item.y + dy }]));
  }

  // ---- drawing ----

  /** Whether parts are still to be made. */
  get busy() {
    return this.todo.size > 0 || this.job !== null;
  }

  /** Has these parts made again: "ground", "traffic", "place" (and then the traffic). */
  need(...parts) {
    for (const part of parts) this.todo.add(part);
    this.dirty();
  }

  /** The whole picture again: something that decides what is drawn has changed. */
  dirty() {
    this.stale = true;
    this.#ask();
  }

  #ask() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      const began = performance.now();
      this.#step(began + WORK_MS);
      this.longestMs = Math.max(this.longestMs, performance.now() - began);
      if (this.busy) this.#ask();
    });
  }

  /** Some of the work, then the picture if it is another one. */
  #step(until) {
    this.job ??= this.#begin();
    while (this.job && performance.now() < until) {
      if (!this.job.next().done) continue;
      this.job = null;
      this.stale = true;
      break; // the next part has a frame of its own
    }
    if (this.stale) this.#show();
    this.stale = false;
  }

  /** What is to be done first. */
  #begin() {
    if (this.todo.delete("place")) {
      this.todo.delete("traffic");
      return this.#placingAndPainting(this.scan);
    }
    if (this.todo.delete("traffic")) return this.#painting(this.scan);
    if (this.todo.delete("ground")) return this.#groundwork();
    return null;
  }

  *#placingAndPainting(scan) {
    yield* this.#placing(scan);
    yield* this.#painting(scan);
  }

  *#painting(scan) {
    const see = { ...this.#see(), scan, cam: this.cam.copy() }, g = this.next.begin(see.cam, this.ratio), faint = see.c.coverage;
    paintHeat(g, see);
    if (!this.compared?.mode) for (const other of this.others.values()) yield* paintingTraffic(g, { ...see, scan: other, layers: BESIDE, c: { ...see.c, arrival: faint, departure: faint, vehicle: faint, unknown: faint } });
    else if (this.compared.mode !== "side") paintHollow(g, see);
    paintPosition(g, see);
    yield;
    for (const _ of paintingTraffic(g, see)) {
      this.#settle();
      yield;
    }
    const labelled = this.layers.labels && this.placedFor && this.placedFor.scale === see.cam.scale && this.placedFor.rot === see.cam.rot;
    if (labelled) {
      g.save();
      g.translate(...this.#labelShift(see.cam));
      for (const _ of paintingLabels(g, see, this.placed)) {
        this.#settle();
        yield;
      }
      g.restore();
    }
    paintForeign(g, see);
    paintGhost(g, see);
    paintAlerts(g, see, this.layers.labels ? this.#labelsOf(see.cam) : null);
    this.#settle();
    yield;
    [this.traffic, this.next] = [this.next, this.traffic];
    this.merged = false;
    this.lastDrawn = performance.now();
    if (!this.todo.size) this.#merge();
    yield;
    this.onDrawn?.();
  }

  *#groundwork() {
    this.merged = false;
    const g = this.ground.begin(this.cam, this.ratio);
    paintAirport(g, { ...this.#see(), box: this.#room() });
    if (this.layers.detection) this.detection.paint(g, this.cam, (this.weather?.from_ns ?? 0) / 1e9);
    this.rings?.paint(g, this.cam, this.c);
  }

  #see() {
    return { ...this, cam: this.cam };
  }

  #room() {
    return { x: -MARGIN, y: -MARGIN, w: this.width + 2 * MARGIN, h: this.height + 2 * MARGIN };
  }

  /** Where pixels are made by this thread, as they turn out to be, they are made bit by bit. */
  #settle() {
    if (this.settles) this.next.settle();
  }

  /** Where nothing but a shift is left to do, both are one opaque bitmap, made once. */
  #merge() {
    if (!this.ground.cam || !this.traffic.cam || !this.ground.cam.same(this.traffic.cam)) return false;
    if (this.merged) return true;
    const began = performance.now(), whole = this.whole.begin(this.ground.cam, this.ratio);
    whole.setTransform(1, 0, 0, 1, 0, 0);
    whole.drawImage(this.ground.canvas, 0, 0);
    whole.drawImage(this.traffic.canvas, 0, 0);
    this.merged = true;
    this.settles ||= performance.now() - began > SLOW_MS;
    return true;
  }

  #show() {
    const { g, ratio, cam } = this;
    if (!this.ground.covers(cam)) {
      g.setTransform(1, 0, 0, 1, 0, 0);
      g.fillStyle = this.c.ground;
      g.fillRect(0, 0, this.canvas.width, this.canvas.height);
    }
    if (this.#merge()) {
      this.whole.onto(g, cam, ratio);
    } else {
      this.ground.onto(g, cam, ratio);
      this.traffic.onto(g, cam, ratio);
    }
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    paintSelected(g, cam, this.c, this.find(this.selected));
    this.tools?.paint(g, this);
    this.driven?.paint(g);
    paintScale(g, cam, this.c);
    this.drawn++;
  }

  // ---- labels ----

  *#placing(scan) {
    const cam = this.cam.copy(), items = [];
    if (!this.layers.labels || !scan || !this.situation) {
      this.placedFor = cam;
      this.placed = new Map();
      this.hidden = [];
      this.onHidden?.();
      return;
    }
    const view = { x: 0, y: 0, w: cam.width, h: cam.height }, room = this.#room(), marks = [];
    this.alerted = stagesOf(scan, this.layers.alerts ? this.alerts : []);
    for (const target of targetsOf(scan, this.layers)) {
      const [x, y] = cam.toScreen(target.x, target.y);
      if (x < room.x || y < room.y || x > room.x + room.w || y > room.y + room.h) continue;
      items.push(this.wishes.item(this, target, x, y));
      yield;
      // The way ahead stays free, too.
      if (!this.layers.vectors || !(Math.hypot(target.vx, target.vy) > 0.5)) continue;
      for (const s of [0.5, 1]) {
        const [ex, ey] = cam.toScreen(target.x + target.vx * this.vectorS * s, target.y + target.vy * this.vectorS * s);
        marks.push({ x: ex, y: ey, r: 3, weight: 6 });
      }
    }
    const field = this.wishes.field(this, cam, room);
    const free = cam.width * cam.height - field.under(view) * 64;
    const wished = items.filter((i) => i.level > 0 && inBox(view, i)).map((i) => i.id);
    if (this.lod === "auto") thin(items.filter((i) => inBox(view, i)), Math.max(free, 1), this.skin === "controller");
    const wanted = items.filter((i) => i.level > 0);
    yield;
    // Labels stay where they were from one scan to the next, also where one scan is placed several times; a moment that was jumped to has
    // the same picture for everybody.
    if (scan.scan !== this.placedScan) this.before = this.live || scan.scan === this.placedScan + 1 ? offsetsOf(this.placed) : new Map();
    const placed = yield* placing(wanted, { view, room, field, covers: this.wishes.covers(this, cam), before: this.before, turn: scan.scan, marks });
    Object.assign(this, { placed, placedFor: cam, placedScan: scan.scan });
    this.hidden = wished.filter((id) => !placed.has(id));
    this.onHidden?.();
  }

  /** What lies over the map is elsewhere now. */
  overlaysChanged() {
    this.#measureOverlays();
  }

  #measureOverlays() {
    const map = this.canvas.parentElement.getBoundingClientRect();
    const boxes = [...this.canvas.parentElement.querySelectorAll("#layers, #zoom, #past, #labels-hidden, .inset")].map((e) => e.getBoundingClientRect());
    this.overlays = boxes.filter((b) => b.width).map((b) => ({ x: b.x - map.x, y: b.y - map.y, w: b.width, h: b.height }));
    this.need("place");
  }

  colourOf(target) {
    return colourOf(this.c, target);
  }
}

/** What is drawn of a run beside the first. */
const BESIDE = { tracks: true, truth: false, plots: false, weather: false };

function inBox(box, p) {
  return p.x >= box.x && p.y >= box.y && p.x <= box.x + box.w && p.y <= box.y + box.h;
}

/** Where labels stand, as the next scan wants to know it. */
function offsetsOf(placed) {
  return new Map([...placed].map(([id, { dx, dy, level }]) => [id, { dx, dy, level }]));
}
