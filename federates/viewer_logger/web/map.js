// The map: airport, weather, plots, truth, tracks and labels on one canvas, in local metres, north up.

import { place } from "./labels.js";
import { kinds, setKinds } from "./frame.js";

const MIN_SCALE = 0.02, MAX_SCALE = 40; // pixels a metre
const VECTOR_S = 15; // speed vectors end where the target will be then
const KNOT = 1.943844;

export const LAYERS = [
  ["tracks", "Tracks"], ["truth", "Truth"], ["errors", "Errors"], ["labels", "Labels"], ["history", "History"],
  ["vectors", "Vectors"], ["ellipses", "Ellipses"], ["weather", "Weather"], ["taxiways", "Taxi names"],
  ["stands", "Stands"], ["coverage", "Coverage"],
];

export class MapView {
  constructor(canvas, changed) {
    this.canvas = canvas;
    this.changed = changed;
    this.g = canvas.getContext("2d", { alpha: false });
    this.fixed = document.createElement("canvas"); // the airport as last drawn
    this.view = { cx: 0, cy: 0, scale: 0.2 };
    this.touched = false; // whether the user chose the view
    this.layers = Object.fromEntries(LAYERS.map(([key]) => [key, true]));
    this.layers.coverage = false;
    this.sensorsOff = new Set();
    this.airport = null;
    this.scan = null;
    this.weather = null;
    this.selected = null;
    this.follow = false;
    this.labels = new Map();
    this.before = new Map();
    this.#listen();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.colours();
    this.resize();
  }

  // ---- state ----

  setAirport(airport) {
    this.airport = airport;
    setKinds(airport.kinds ?? []);
    this.colours();
    this.bounds = boundsOf(airport);
    if (!this.touched) this.fit();
    this.stale = true;
    this.dirty();
  }

  setScan(scan) {
    this.scan = scan;
    if (this.follow) this.#centreOnSelected();
    this.dirty();
  }

  /** Colours out of the style sheet, after a change of day and night. */
  colours() {
    const style = getComputedStyle(document.documentElement);
    this.c = new Proxy({}, { get: (_, name) => style.getPropertyValue(`--${name}`).trim() });
    const names = ["ground", "pavement", "pavement-edge", "runway", "runway-mark", "taxi", "taxi-name", "stand", "text", "dim",
      "arrival", "departure", "vehicle", "unknown", "truth", "error", "rain", "coverage", "halo", "select", "label-back",
      ...kinds.map((k) => `plot-${k.word}`), "plot-other"];
    this.c = Object.fromEntries(names.map((n) => [n, style.getPropertyValue(`--${n}`).trim()]));
    this.stale = true;
    this.dirty();
  }

  resize() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    this.width = Math.max(1, Math.round(box.width));
    this.height = Math.max(1, Math.round(box.height));
    for (const c of [this.canvas, this.fixed]) {
      c.width = Math.round(this.width * ratio);
      c.height = Math.round(this.height * ratio);
    }
    this.canvas.style.width = `${this.width}px`;
    this.canvas.style.height = `${this.height}px`;
    this.ratio = ratio;
    if (!this.touched && this.airport) this.fit();
    this.stale = true;
    this.dirty();
  }

  // ---- view ----

  toScreen(x, y) {
    const { cx, cy, scale } = this.view;
    return [this.width / 2 + (x - cx) * scale, this.height / 2 - (y - cy) * scale];
  }

  toMetres(px, py) {
    const { cx, cy, scale } = this.view;
    return [cx + (px - this.width / 2) / scale, cy - (py - this.height / 2) / scale];
  }

  look(view) {
    const next = { ...this.view, ...view };
    if (![next.cx, next.cy, next.scale].every(Number.isFinite)) return;
    next.scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, next.scale));
    this.view = next;
    this.stale = true;
    this.dirty();
  }

  fit() {
    if (this.bounds) this.#show(this.bounds, 44);
  }

  fitTargets() {
    this.follow = false;
    const points = [...(this.scan?.tracks ?? []), ...(this.scan?.truth ?? [])].filter(sound);
    if (!points.length) return;
    this.touched = true;
    const xs = points.map((p) => p.x), ys = points.map((p) => p.y);
    this.#show([Math.min(...xs) - 80, Math.min(...ys) - 80, Math.max(...xs) + 80, Math.max(...ys) + 80], 80);
    this.changed();
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    this.touched = true;
    const [x, y] = this.toMetres(px, py);
    const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, this.view.scale * factor));
    this.look({ scale, cx: x - (px - this.width / 2) / scale, cy: y + (py - this.height / 2) / scale });
    if (this.follow) this.#centreOnSelected();
  }

  pan(dx, dy) {
    this.touched = true;
    this.follow = false;
    this.look({ cx: this.view.cx - dx / this.view.scale, cy: this.view.cy + dy / this.view.scale });
    this.changed();
  }

  setFollow(on) {
    this.follow = on && this.selected !== null;
    if (this.follow) {
      this.touched = true;
      if (this.view.scale < 0.6) this.look({ scale: 1.2 });
      this.#centreOnSelected();
    }
    this.changed();
  }

  #show([x0, y0, x1, y1], margin) {
    const scale = Math.min((this.width - 2 * margin) / Math.max(1, x1 - x0), (this.height - 2 * margin) / Math.max(1, y1 - y0));
    this.look({ cx: (x0 + x1) / 2, cy: (y0 + y1) / 2, scale: Math.max(scale, MIN_SCALE) });
  }

  #centreOnSelected() {
    const target = this.find(this.selected);
    if (target && sound(target)) this.look({ cx: target.x, cy: target.y });
  }

  find(id) {
    if (id === null || !this.scan) return null;
    return this.scan.tracks.find((t) => t.id === id) ?? this.scan.truth.find((t) => t.id === id) ?? null;
  }

  // ---- what is under the pointer ----

  #listen() {
    const canvas = this.canvas, pointers = new Map();
    let moved = 0, pinch = 0;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, at(event));
      moved = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const here = at(event);
      this.onPointer?.(this.toMetres(...here));
      const last = pointers.get(event.pointerId);
      if (!last) {
        canvas.style.cursor = this.pick(...here) ? "pointer" : "grab";
        return;
      }
      pointers.set(event.pointerId, here);
      if (pointers.size === 2) {
        const [a, b] = [...pointers.values()];
        const apart = Math.hypot(a[0] - b[0], a[1] - b[1]);
        if (pinch) this.zoom(apart / pinch, (a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
        pinch = apart;
        moved = 99;
        return;
      }
      const dx = here[0] - last[0], dy = here[1] - last[1];
      moved += Math.hypot(dx, dy);
      if (moved > 4) {
        canvas.style.cursor = "grabbing";
        this.pan(dx, dy);
      }
    });
    const up = (event) => {
      pinch = 0;
      if (pointers.delete(event.pointerId) && event.type === "pointerup" && moved <= 4) {
        this.onPick?.(this.pick(...at(event))?.id ?? null);
      }
      canvas.style.cursor = "grab";
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("pointerleave", () => this.onPointer?.(null));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...at(event));
    }, { passive: false });
    canvas.addEventListener("dblclick", (event) => this.zoom(2, ...at(event)));
  }

  /** The target whose symbol or label is at this pixel. */
  pick(px, py) {
    let best = null, nearest = 16;
    for (const target of this.#targets()) {
      const [x, y] = this.toScreen(target.x, target.y);
      const d = Math.hypot(x - px, y - py);
      if (d < nearest) [best, nearest] = [target, d];
    }
    if (best) return best;
    for (const [id, box] of this.labels) {
      if (px >= box.x && px <= box.x + box.w && py >= box.y && py <= box.y + box.h) return this.find(id);
    }
    return null;
  }

  /** Tracks, and entities that no track follows, with a place on the map. */
  #targets() {
    if (!this.scan) return [];
    const tracks = this.layers.tracks ? this.scan.tracks.filter(sound) : [];
    const alone = this.layers.truth ? this.scan.truth.filter((t) => sound(t) && (t.track === null || !this.layers.tracks)) : [];
    return [...tracks, ...alone];
  }

  // ---- drawing ----

  dirty() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  draw() {
    const { g, ratio } = this;
    if (this.stale) {
      this.#drawAirport();
      this.stale = false;
    }
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.drawImage(this.fixed, 0, 0);
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (this.layers.weather) this.#drawWeather(g);
    if (this.scan) {
      if (this.layers.history) this.#drawTrails(g);
      this.#drawPlots(g);
      if (this.layers.ellipses && this.layers.tracks) for (const t of this.scan.tracks.filter(sound)) this.#ellipse(g, t, this.colourOf(t));
      if (this.layers.truth) this.#drawTruth(g);
      if (this.layers.errors) this.#drawErrors(g);
      if (this.layers.vectors) this.#drawVectors(g);
      if (this.layers.tracks) for (const t of this.scan.tracks.filter(sound)) this.#symbol(g, t);
      this.#select(g);
      this.labels = this.layers.labels ? this.#drawLabels(g) : new Map();
    }
    this.#drawScale(g);
    this.drawn = (this.drawn ?? 0) + 1;
  }

  #path(g, points, close = false) {
    points.forEach(([x, y], i) => {
      const [px, py] = this.toScreen(x, y);
      if (i) g.lineTo(px, py);
      else g.moveTo(px, py);
    });
    if (close) g.closePath();
  }

  #drawAirport() {
    const g = this.fixed.getContext("2d", { alpha: false }), { c, ratio, airport } = this, { scale } = this.view;
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.fillStyle = c.ground;
    g.fillRect(0, 0, this.width, this.height);
    if (!airport) return;
    g.lineJoin = g.lineCap = "round";
    // Ground network first as broad bands, so that taxiways without mapped pavement have a surface.
    g.strokeStyle = c.pavement;
    g.lineWidth = Math.max(1.5, 23 * scale);
    g.beginPath();
    for (const way of airport.taxiways) this.#path(g, way.points_m);
    g.stroke();
    g.fillStyle = c.pavement;
    for (const area of airport.pavements) {
      g.beginPath();
      for (const ring of area.rings) this.#path(g, ring, true);
      g.fill("evenodd");
    }
    g.fillStyle = c["pavement-edge"];
    for (const area of airport.buildings ?? []) {
      g.beginPath();
      for (const ring of area.rings) this.#path(g, ring, true);
      g.fill("evenodd");
    }
    for (const runway of airport.runways) this.#runway(g, runway);
    g.strokeStyle = c.taxi;
    g.lineWidth = Math.max(0.7, Math.min(1.6, scale * 2));
    g.beginPath();
    for (const way of airport.taxiways) this.#path(g, way.points_m);
    g.stroke();
    if (this.layers.stands) this.#stands(g);
    this.#names(g);
    this.#sites(g);
  }

  #runway(g, runway) {
    const { c } = this, { scale } = this.view;
    const [a, b] = runway.ends, dx = b[0] - a[0], dy = b[1] - a[1], length = Math.hypot(dx, dy) || 1;
    const ux = dx / length, uy = dy / length, half = runway.width_m / 2;
    const corner = (end, along, side) => [end[0] + ux * along - uy * half * side, end[1] + uy * along + ux * half * side];
    g.fillStyle = c.runway;
    g.strokeStyle = c["runway-mark"];
    g.lineWidth = 1;
    g.beginPath();
    this.#path(g, [corner(a, 0, 1), corner(b, 0, 1), corner(b, 0, -1), corner(a, 0, -1)], true);
    g.fill();
    g.stroke();
    g.setLineDash([30 * scale, 20 * scale]);
    g.lineWidth = Math.max(0.8, 0.9 * scale);
    g.beginPath();
    this.#path(g, [[a[0] + ux * 80, a[1] + uy * 80], [b[0] - ux * 80, b[1] - uy * 80]]);
    g.stroke();
    g.setLineDash([]);
    g.font = `700 ${Math.max(11, Math.min(26, 24 * scale + 8))}px B612, sans-serif`;
    g.fillStyle = c["runway-mark"];
    g.textAlign = "center";
    g.textBaseline = "middle";
    this.#designators(runway).forEach(([px, py], i) => g.fillText(runway.designators[i], px, py));
  }

  /** Where the designators of both ends are written, in pixels. */
  #designators({ ends: [a, b], width_m: width }) {
    const dx = b[0] - a[0], dy = b[1] - a[1], length = Math.hypot(dx, dy) || 1;
    const gap = (14 / this.view.scale + width / 2) / length;
    return [this.toScreen(a[0] - dx * gap, a[1] - dy * gap), this.toScreen(b[0] + dx * gap, b[1] + dy * gap)];
  }

  #stands(g) {
    const { c } = this, { scale } = this.view;
    const r = Math.max(1.2, Math.min(4, 4 * scale));
    g.fillStyle = c.stand;
    for (const stand of this.airport.stands) {
      const [x, y] = this.toScreen(...stand.position_m);
      g.beginPath();
      g.arc(x, y, r, 0, 7);
      g.fill();
    }
    if (scale < 0.55) return;
    g.font = "10px B612, sans-serif";
    g.textAlign = "left";
    g.textBaseline = "middle";
    const taken = [];
    for (const stand of this.airport.stands) {
      const [x, y] = this.toScreen(...stand.position_m);
      this.#freeText(g, taken, stand.name.replaceAll("_", " "), x + r + 3, y);
    }
  }

  /** Names of taxiways once a screenful each, where they do not cover one another. */
  #names(g) {
    if (!this.layers.taxiways || this.view.scale < 0.1) return;
    g.font = "700 10px B612, sans-serif";
    g.fillStyle = this.c["taxi-name"];
    g.textAlign = "center";
    g.textBaseline = "middle";
    const taken = [], last = new Map();
    const ways = this.airport.taxiways.filter((w) => w.name && w.points_m.length > 1 && w.name.length <= 3);
    const middle = (w) => [(w.points_m[0][0] + w.points_m.at(-1)[0]) / 2, (w.points_m[0][1] + w.points_m.at(-1)[1]) / 2];
    const long = (w) => Math.hypot(w.points_m[0][0] - w.points_m.at(-1)[0], w.points_m[0][1] - w.points_m.at(-1)[1]);
    for (const way of ways.sort((p, q) => long(q) - long(p))) {
      const [x, y] = this.toScreen(...middle(way));
      const near = (last.get(way.name) ?? []).some(([a, b]) => Math.hypot(a - x, b - y) < 260);
      if (near || !this.#freeText(g, taken, way.name, x, y, true)) continue;
      last.set(way.name, [...(last.get(way.name) ?? []), [x, y]]);
    }
  }

  #freeText(g, taken, text, x, y, centred = false) {
    const w = g.measureText(text).width + 4;
    const box = { x: centred ? x - w / 2 : x, y: y - 7, w, h: 14 };
    if (taken.some((t) => t.x < box.x + box.w && box.x < t.x + t.w && t.y < box.y + box.h && box.y < t.y + t.h)) return false;
    if (box.x > this.width || box.y > this.height || box.x + w < 0 || box.y < -14) return false;
    taken.push(box);
    if (centred) {
      g.save();
      g.fillStyle = this.c.pavement;
      g.fillRect(box.x, box.y + 1, box.w, 12);
      g.restore();
    }
    g.fillText(text, x, y);
    return true;
  }

  #sites(g) {
    const { c } = this;
    for (const s of this.airport.sensors ?? []) {
      if (!s.position_m) continue;
      const [x, y] = this.toScreen(...s.position_m);
      if (this.layers.coverage && s.range_m) {
        g.strokeStyle = c.coverage;
        g.lineWidth = 1;
        g.setLineDash([4, 5]);
        g.beginPath();
        g.arc(x, y, s.range_m * this.view.scale, 0, 7);
        g.stroke();
        g.setLineDash([]);
      }
      g.strokeStyle = g.fillStyle = c.dim;
      g.lineWidth = 1.2;
      g.beginPath();
      g.moveTo(x, y - 6);
      g.lineTo(x + 5, y + 4);
      g.lineTo(x - 5, y + 4);
      g.closePath();
      g.stroke();
      g.font = "10px B612, sans-serif";
      g.textAlign = "center";
      g.textBaseline = "top";
      g.fillText(s.name || s.kind, x, y + 7);
    }
  }

  #drawWeather(g) {
    for (const [east, north, radius, rate] of this.weather?.cells ?? []) {
      const [x, y] = this.toScreen(east, north);
      const r = radius * this.view.scale;
      if (![x, y, r].every(Number.isFinite) || r <= 0) continue;
      g.save();
      g.globalAlpha = Math.min(0.26, 0.06 + rate / 400);
      g.fillStyle = this.c.rain;
      g.beginPath();
      g.arc(x, y, r, 0, 7);
      g.fill();
      g.globalAlpha = 0.8;
      g.strokeStyle = this.c.rain;
      g.setLineDash([2, 4]);
      g.stroke();
      g.font = "10px B612, sans-serif";
      g.textAlign = "center";
      g.fillText(`${rate.toFixed(0)} mm/h`, x, y - r + 14);
      g.restore();
    }
  }

  #drawTrails(g) {
    for (const track of this.scan.tracks) {
      const points = this.scan.trails.get(track.number) ?? [];
      g.fillStyle = this.colourOf(track);
      points.forEach(([x, y], i) => {
        if (!Number.isFinite(x + y)) return;
        const [px, py] = this.toScreen(x, y);
        g.globalAlpha = 0.65 * (1 - i / (points.length + 4));
        g.fillRect(px - 1, py - 1, 2, 2);
      });
    }
    g.globalAlpha = 1;
  }

  #drawPlots(g) {
    for (const plot of this.scan.plots) {
      if (this.sensorsOff.has(plot.sensor) || !sound(plot)) continue;
      const [x, y] = this.toScreen(plot.x, plot.y);
      g.strokeStyle = this.c[`plot-${plot.kind}`] ?? this.c["plot-other"];
      g.lineWidth = 1.2;
      g.beginPath();
      plotMark(g, plot.kind, x, y, 3.5);
      g.stroke();
    }
  }

  #drawTruth(g) {
    for (const truth of this.scan.truth) {
      if (!sound(truth)) continue;
      const [x, y] = this.toScreen(truth.x, truth.y);
      g.strokeStyle = this.c.truth;
      g.lineWidth = 1.2;
      g.setLineDash(truth.ours ? [] : [3, 2]);
      outline(g, truth, x, y, this.view.scale);
      g.stroke();
      g.setLineDash([]);
    }
  }

  #drawErrors(g) {
    g.strokeStyle = this.c.error;
    g.lineWidth = 1.6;
    g.beginPath();
    for (const track of this.scan.tracks) {
      if (!track.truth || !sound(track) || !sound(track.truth)) continue;
      const [x, y] = this.toScreen(track.x, track.y), [tx, ty] = this.toScreen(track.truth.x, track.truth.y);
      g.moveTo(x, y);
      g.lineTo(tx, ty);
    }
    g.stroke();
  }

  #drawVectors(g) {
    g.lineWidth = 1.2;
    for (const t of this.#targets()) {
      if (!(Math.hypot(t.vx, t.vy) > 0.5)) continue;
      const [x, y] = this.toScreen(t.x, t.y), [ex, ey] = this.toScreen(t.x + t.vx * VECTOR_S, t.y + t.vy * VECTOR_S);
      g.strokeStyle = this.colourOf(t);
      g.beginPath();
      g.moveTo(x, y);
      g.lineTo(ex, ey);
      g.stroke();
    }
  }

  #ellipse(g, track, colour) {
    const e = ellipseOf(track.cov);
    if (!e) return;
    const [x, y] = this.toScreen(track.x, track.y), { scale } = this.view;
    const a = e.a * scale, b = e.b * scale;
    if (a < 4 || a > 4000) return;
    g.strokeStyle = colour;
    g.globalAlpha = 0.55;
    g.lineWidth = 1;
    g.beginPath();
    g.ellipse(x, y, a, Math.max(b, 0.5), -e.angle, 0, 7);
    g.stroke();
    g.globalAlpha = 1;
  }

  #symbol(g, track) {
    const [x, y] = this.toScreen(track.x, track.y);
    const colour = this.colourOf(track);
    g.lineWidth = 1.4;
    g.strokeStyle = g.fillStyle = colour;
    trackMark(g, track, x, y, 5);
    if (track.status === "coasting" || track.status === "tentative") g.stroke();
    else {
      g.globalAlpha = 0.95;
      g.fill();
      g.globalAlpha = 1;
      g.strokeStyle = this.c.ground;
      g.lineWidth = 1;
      g.stroke();
    }
    if (track.manoeuvre) {
      g.strokeStyle = colour;
      g.beginPath();
      g.arc(x, y, 8, -0.9, 0.9);
      g.stroke();
    }
  }

  #select(g) {
    const target = this.find(this.selected);
    if (!target || !sound(target)) return;
    const [x, y] = this.toScreen(target.x, target.y);
    g.strokeStyle = this.c.select;
    g.lineWidth = 1.6;
    const r = 12, k = 5;
    g.beginPath();
    for (const [sx, sy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
      g.moveTo(x + sx * r, y + sy * (r - k));
      g.lineTo(x + sx * r, y + sy * r);
      g.lineTo(x + sx * (r - k), y + sy * r);
    }
    g.stroke();
  }

  #drawLabels(g) {
    const bold = "700 12px B612, sans-serif", plain = "11px B612, sans-serif";
    const width = (font, text) => {
      g.font = font;
      return g.measureText(text).width;
    };
    const items = [], obstacles = [];
    for (const runway of this.airport?.runways ?? []) for (const [x, y] of this.#designators(runway)) obstacles.push({ x, y, r: 11, weight: 9 });
    const inView = (x, y) => x > -10 && y > -10 && x < this.width + 10 && y < this.height + 10;
    for (const target of this.#targets()) {
      const [x, y] = this.toScreen(target.x, target.y);
      if (!inView(x, y)) continue;
      const lines = labelLines(target);
      const full = Math.max(width(bold, lines[0]), ...lines.slice(1).map((l) => width(plain, l)));
      const sizes = [{ w: Math.ceil(full) + 10, h: 4 + 15 + 13 * (lines.length - 1) }];
      if (lines.length > 1) sizes.push({ w: Math.ceil(width(bold, lines[0])) + 10, h: 19 });
      const chosen = target.id === this.selected;
      const speed = Math.hypot(target.vx, target.vy) || 0;
      items.push({ id: target.id, x, y, sizes, lines, target, priority: (chosen ? 1000 : 0) + (target.number !== undefined ? 100 : 0) + Math.min(speed, 90) });
      const size = Math.max(target.truth?.lengthM ?? target.lengthM ?? 0, target.truth?.spanM ?? target.spanM ?? 0);
      const reach = Math.max(8, Math.min(90, 0.55 * size * this.view.scale));
      items.at(-1).reach = reach;
      obstacles.push({ id: target.id, own: true, x, y, r: reach });
      // The way ahead stays free, too.
      if (this.layers.vectors && speed > 0.5) {
        for (const s of [0.33, 0.66, 1]) {
          const [ex, ey] = this.toScreen(target.x + target.vx * VECTOR_S * s, target.y + target.vy * VECTOR_S * s);
          obstacles.push({ x: ex, y: ey, r: 3, weight: 6 });
        }
      }
    }
    const placed = place(items, { width: this.width, height: this.height, obstacles, before: this.before, blocked: this.#overlays() });
    this.before = new Map([...placed].map(([id, p]) => [id, { dx: p.dx, dy: p.dy }]));
    g.textAlign = "left";
    g.textBaseline = "alphabetic";
    for (const item of items) {
      const box = placed.get(item.id);
      if (box) this.#label(g, item, box, bold, plain);
    }
    return placed;
  }

  /** Boxes of what lies over the map: labels keep out of them. */
  #overlays() {
    const map = this.canvas.getBoundingClientRect();
    const boxes = [...this.canvas.parentElement.querySelectorAll("#layers, #zoom, #past")].map((e) => e.getBoundingClientRect());
    return boxes.filter((b) => b.width).map((b) => ({ x: b.x - map.x, y: b.y - map.y, w: b.width, h: b.height }));
  }

  #label(g, { x, y, lines, target, id }, box, bold, plain) {
    const colour = this.colourOf(target), chosen = id === this.selected;
    const length = Math.hypot(box.ax - x, box.ay - y);
    if (length > 9) {
      g.strokeStyle = colour;
      g.globalAlpha = 0.6;
      g.lineWidth = 1;
      g.beginPath();
      g.moveTo(x + ((box.ax - x) / length) * 8, y + ((box.ay - y) / length) * 8);
      g.lineTo(box.ax, box.ay);
      g.stroke();
      g.globalAlpha = 1;
    }
    g.fillStyle = this.c["label-back"];
    g.fillRect(box.x, box.y, box.w, box.h);
    if (chosen) {
      g.strokeStyle = this.c.select;
      g.lineWidth = 1;
      g.strokeRect(box.x + 0.5, box.y + 0.5, box.w - 1, box.h - 1);
    }
    g.fillStyle = colour;
    g.font = bold;
    g.fillText(lines[0], box.x + 5, box.y + 14);
    if (box.form > 0) return;
    g.font = plain;
    g.fillStyle = this.c.text;
    lines.slice(1).forEach((line, i) => g.fillText(line, box.x + 5, box.y + 27 + 13 * i));
  }

  #drawScale(g) {
    const { c } = this;
    const goal = 110 / this.view.scale;
    const power = 10 ** Math.floor(Math.log10(goal));
    const metres = [5, 2, 1].map((k) => k * power).find((m) => m <= goal) ?? power;
    const w = metres * this.view.scale, x = this.width - w - 16, y = this.height - 14;
    g.strokeStyle = g.fillStyle = c.dim;
    g.lineWidth = 1.2;
    g.beginPath();
    g.moveTo(x, y - 5);
    g.lineTo(x, y);
    g.lineTo(x + w, y);
    g.lineTo(x + w, y - 5);
    g.stroke();
    g.font = "10px B612, sans-serif";
    g.textAlign = "center";
    g.textBaseline = "alphabetic";
    g.fillText(metres >= 1000 ? `${metres / 1000} km` : `${metres} m`, x + w / 2, y - 5);
    const nx = this.width - 24, ny = this.height - 58;
    g.beginPath();
    g.moveTo(nx, ny - 14);
    g.lineTo(nx + 5, ny + 2);
    g.lineTo(nx, ny - 2);
    g.lineTo(nx - 5, ny + 2);
    g.closePath();
    g.fill();
    g.fillText("N", nx, ny + 14);
  }

  colourOf(target) {
    if (target.number === undefined) return this.c.truth;
    const { c } = this;
    return { arrival: c.arrival, departure: c.departure, vehicle: c.vehicle }[target.movement]
      ?? (target.type === "vehicle" ? c.vehicle : c.unknown);
  }
}

/** Draws one target large: truth to scale, track, ellipse, plots and the error between them. */
export function closeUp(canvas, map, target) {
  const box = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
  const w = Math.round(box.width), h = Math.round(box.height);
  if (!w || !h) return;
  if (canvas.width !== Math.round(w * ratio)) canvas.width = Math.round(w * ratio);
  if (canvas.height !== Math.round(h * ratio)) canvas.height = Math.round(h * ratio);
  const g = canvas.getContext("2d"), { c } = map;
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.fillStyle = c.ground;
  g.fillRect(0, 0, w, h);
  if (!target || !sound(target)) return;
  const truth = target.number === undefined ? target : target.truth;
  const plots = map.scan.plots.filter((p) => sound(p) && (target.number !== undefined ? p.track === target.number : false));
  const reach = Math.max(truth?.lengthM || 0, truth?.spanM || 0, 12) * 0.62;
  const far = [truth, ...plots].filter((p) => p && sound(p)).map((p) => Math.hypot(p.x - target.x, p.y - target.y));
  const scale = (Math.min(w, h) / 2 - 8) / Math.max(reach, ...far.filter((d) => d < 400));
  const at = (p) => [w / 2 + (p.x - target.x) * scale, h / 2 - (p.y - target.y) * scale];
  if (truth && sound(truth)) {
    const [x, y] = at(truth);
    g.strokeStyle = c.truth;
    g.lineWidth = 1.4;
    outline(g, truth, x, y, scale);
    g.stroke();
    g.beginPath();
    g.moveTo(x - 4, y);
    g.lineTo(x + 4, y);
    g.moveTo(x, y - 4);
    g.lineTo(x, y + 4);
    g.stroke();
  }
  for (const plot of plots) {
    g.strokeStyle = c[`plot-${plot.kind}`] ?? c["plot-other"];
    g.lineWidth = 1.4;
    g.beginPath();
    plotMark(g, plot.kind, ...at(plot), 5);
    g.stroke();
  }
  if (target.number !== undefined) {
    const colour = map.colourOf(target), e = ellipseOf(target.cov);
    if (e && e.a * scale < 2000) {
      g.strokeStyle = colour;
      g.setLineDash([3, 3]);
      g.lineWidth = 1;
      g.beginPath();
      g.ellipse(w / 2, h / 2, e.a * scale, e.b * scale, -e.angle, 0, 7);
      g.stroke();
      g.setLineDash([]);
    }
    if (truth && sound(truth)) {
      g.strokeStyle = c.error;
      g.lineWidth = 2;
      g.beginPath();
      g.moveTo(w / 2, h / 2);
      g.lineTo(...at(truth));
      g.stroke();
    }
    g.fillStyle = colour;
    g.beginPath();
    g.arc(w / 2, h / 2, 3.5, 0, 7);
    g.fill();
  }
  const metres = [100, 50, 20, 10, 5, 2, 1].find((m) => m * scale < w * 0.4) ?? 1;
  g.strokeStyle = g.fillStyle = c.dim;
  g.lineWidth = 1;
  g.beginPath();
  g.moveTo(8, h - 8);
  g.lineTo(8 + metres * scale, h - 8);
  g.stroke();
  g.font = "10px B612, sans-serif";
  g.textAlign = "left";
  g.fillText(`${metres} m`, 8, h - 12);
}

/** 95 % ellipse of a covariance [ee, en, nn]: half axes in metres, angle of the larger from east. */
export function ellipseOf([ee, en, nn]) {
  if (![ee, en, nn].every(Number.isFinite)) return null;
  const mean = (ee + nn) / 2, gap = Math.hypot((ee - nn) / 2, en);
  const k = 2.4477; // root of the 95 % quantile of chi squared with two degrees of freedom
  return { a: k * Math.sqrt(Math.max(0, mean + gap)), b: k * Math.sqrt(Math.max(0, mean - gap)), angle: Math.atan2(2 * en, ee - nn) / 2 };
}

export function labelLines(target) {
  const name = target.callsign || (target.number === undefined ? "no name" : `#${target.number}`);
  const speed = Math.round(Math.hypot(target.vx, target.vy) * KNOT);
  const kind = target.wake ? `${target.designator}/${target.wake}` : target.designator;
  const second = [kind, Number.isFinite(speed) ? `${speed} kt` : ""].filter(Boolean).join("  ");
  if (target.number === undefined) return [name, `${second}  no track`];
  return [name, second, target.runwayStand.replaceAll("_", " ")].filter(Boolean);
}

function sound(p) {
  return Number.isFinite(p.x) && Number.isFinite(p.y);
}

/** Aircraft or vehicle to scale, at least a few pixels large. */
function outline(g, truth, x, y, scale) {
  const length = Math.max((truth.lengthM || 10) * scale, 9), span = Math.max((truth.spanM || 5) * scale, truth.aircraft ? 8 : 5);
  g.beginPath();
  const heading = Number.isFinite(truth.heading) ? truth.heading : 0;
  const [sin, cos] = [Math.sin(heading), Math.cos(heading)];
  const shape = truth.aircraft ? AIRCRAFT : VEHICLE;
  shape.forEach(([across, along], i) => {
    const a = across * span, l = along * length;
    const px = x + l * sin + a * cos, py = y - l * cos + a * sin;
    if (i) g.lineTo(px, py);
    else g.moveTo(px, py);
  });
  g.closePath();
}

// Half outlines mirrored: across in spans, along in lengths, nose first.
const HALF = [[0, 0.5], [0.05, 0.42], [0.055, 0.14], [0.5, -0.1], [0.5, -0.17], [0.055, -0.06], [0.045, -0.36], [0.19, -0.45], [0.19, -0.5], [0, -0.46]];
const AIRCRAFT = [...HALF, ...HALF.slice(1, -1).reverse().map(([x, y]) => [-x, y])];
const VEHICLE = [[-0.5, -0.5], [-0.5, 0.3], [0, 0.5], [0.5, 0.3], [0.5, -0.5]];

/** Marks by kind of sensor, so that colour is not the only difference. */
export function plotMark(g, word, x, y, r) {
  const lines = kinds.find((kind) => kind.word === word)?.symbol ?? [[[0, -1], [1, 1], [-1, 1], [0, -1]]];
  for (const line of lines) {
    line.forEach(([right, down], i) => (i ? g.lineTo(x + right * r, y + down * r) : g.moveTo(x + right * r, y + down * r)));
  }
}

function trackMark(g, track, x, y, r) {
  g.beginPath();
  if (track.type === "vehicle") g.rect(x - r + 1, y - r + 1, 2 * r - 2, 2 * r - 2);
  else if (track.type === "aircraft") g.arc(x, y, r, 0, 7);
  else {
    g.moveTo(x, y - r - 1);
    g.lineTo(x + r + 1, y);
    g.lineTo(x, y + r + 1);
    g.lineTo(x - r - 1, y);
    g.closePath();
  }
}

function boundsOf(airport) {
  const points = [
    ...airport.runways.flatMap((r) => r.ends), ...airport.taxiways.flatMap((t) => t.points_m),
    ...airport.stands.map((s) => s.position_m), ...airport.pavements.flatMap((p) => p.rings.flat()),
  ].filter(([x, y]) => Number.isFinite(x + y));
  if (!points.length) return [-1000, -1000, 1000, 1000];
  return points.reduce(([a, b, c, d], [x, y]) => [Math.min(a, x), Math.min(b, y), Math.max(c, x), Math.max(d, y)],
    [Infinity, Infinity, -Infinity, -Infinity]);
}
