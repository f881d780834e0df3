// Windows in the map: another piece of the airport with a zoom and a rotation of its own, its targets and their call signs.

import { Camera } from "./camera.js";
import { place } from "./labels.js";
import { paintAirport } from "./paint.js";
import { paintAlerts, paintPosition } from "./position.js";
import { BOLD, colourOf, labelLines, paintLabels, paintSelected, paintTraffic, sound } from "./traffic.js";
import { element } from "./text.js";

export const MOST_INSETS = 2;
const TARGETS = { tracks: true, history: false, vectors: true, ellipses: false, plots: false, truth: false, errors: false, weather: false, alerts: true, routes: true };

/** View of a new window: what lies in the middle of the map, this much larger. */
const CLOSER = 4;

/** A view as the address has it, [x, y, z] or with a rotation, and back. */
export function viewOf([cx, cy, scale, rot = 0]) {
  return { cx, cy, scale, rot };
}
export function writtenView({ cx, cy, scale, rot }) {
  const round = (value, digits) => Number(value.toFixed(digits)), view = [round(cx, 1), round(cy, 1), round(scale, 4)];
  return rot ? [...view, round(rot, 2)] : view;
}

class Inset {
  constructor(number, view, insets) {
    Object.assign(this, { number, insets, cam: new Camera(), before: new Map() });
    this.cam.look(view);
    this.canvas = element("canvas", [], { role: "img", tabindex: "0", "aria-label": `Window ${number} of the map: targets with call signs; arrows move it, plus and minus zoom, Delete closes` });
    const close = element("button", "\u00d7", { type: "button", title: "Close this window", "aria-label": `Close window ${number}` });
    close.addEventListener("click", () => insets.close(this));
    this.head = element("header", [element("span", `Window ${number}`), close]);
    this.box = element("section", [this.head, this.canvas], { class: "inset", "data-inset": String(number), "aria-label": `Window ${number} of the map` });
    this.#listen();
    new ResizeObserver(() => this.draw()).observe(this.box);
  }

  look(view) {
    if (!this.cam.look(view)) return;
    this.draw();
    this.insets.changed();
  }

  #listen() {
    const { canvas } = this;
    let last = null, moved = 0, carried = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      [last, moved] = [[event.clientX, event.clientY], 0];
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
      moved += Math.hypot(dx, dy);
      if (moved <= 4) return;
      last = [event.clientX, event.clientY];
      this.look(this.cam.panned(dx, dy));
    });
    canvas.addEventListener("pointerup", (event) => {
      if (last && moved <= 4) this.insets.onPick(this.#targetAt(event));
      last = null;
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = canvas.getBoundingClientRect(), step = event.deltaY * (event.deltaMode ? 33 : 1);
      if (this.insets.map.turning) this.look({ rot: this.cam.rot + step * 0.05 });
      else this.look(this.cam.zoomed(Math.exp(-step * 0.0015), event.clientX - box.left, event.clientY - box.top));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const move = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] }[event.key], zoom = { "+": 1.5, "=": 1.5, "-": 1 / 1.5 }[event.key];
      if (move) this.look(this.cam.panned(...move));
      else if (zoom) this.look(this.cam.zoomed(zoom, this.cam.width / 2, this.cam.height / 2));
      else if (event.key === "Delete") this.insets.close(this);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
    // The head carries the window over the map.
    this.head.addEventListener("pointerdown", (event) => {
      if (event.target.closest("button")) return;
      this.head.setPointerCapture(event.pointerId);
      carried = [event.clientX - this.box.offsetLeft, event.clientY - this.box.offsetTop];
    });
    this.head.addEventListener("pointermove", (event) => {
      if (!carried) return;
      const room = this.box.parentElement, within = (v, most) => `${Math.max(0, Math.min(most, v))}px`;
      Object.assign(this.box.style, { right: "auto", left: within(event.clientX - carried[0], room.clientWidth - this.box.offsetWidth), top: within(event.clientY - carried[1], room.clientHeight - this.box.offsetHeight) });
    });
    this.head.addEventListener("pointerup", () => {
      carried = null;
      this.insets.map.overlaysChanged();
    });
  }

  #targetAt(event) {
    const box = this.canvas.getBoundingClientRect(), at = [event.clientX - box.left, event.clientY - box.top];
    const far = (t) => Math.hypot(...this.cam.toScreen(t.x, t.y).map((v, i) => v - at[i]));
    const near = (this.insets.map.scan?.tracks ?? []).filter(sound).map((t) => [far(t), t.id]).sort((a, b) => a[0] - b[0])[0];
    return near && near[0] < 16 ? near[1] : null;
  }

  draw() {
    const { map } = this.insets, { canvas, cam } = this, ratio = window.devicePixelRatio || 1;
    Object.assign(cam, { width: Math.max(1, canvas.clientWidth), height: Math.max(1, canvas.clientHeight) });
    const w = Math.round(cam.width * ratio), h = Math.round(cam.height * ratio);
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
    const g = canvas.getContext("2d"), box = { x: 0, y: 0, w: cam.width, h: cam.height };
    this.#ground(w, h, ratio, box);
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.drawImage(this.under, 0, 0);
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (!map.scan) return;
    const see = { ...map, cam: cam.copy(), layers: { ...TARGETS, alerts: map.layers.alerts, routes: map.layers.routes } };
    paintPosition(g, see);
    paintTraffic(g, see);
    this.#label(g, see, box);
    paintAlerts(g, see, this.placed);
    paintSelected(g, cam, map.c, map.find(map.selected));
  }

  #ground(w, h, ratio, box) {
    const { map } = this.insets, { cam } = this, key = [cam.cx, cam.cy, cam.scale, cam.rot, w, h, map.c.ground, map.airport?.icao].join();
    if (key === this.key) return;
    this.key = key;
    this.under ??= document.createElement("canvas");
    Object.assign(this.under, { width: w, height: h });
    const u = this.under.getContext("2d");
    u.setTransform(ratio, 0, 0, ratio, 0, 0);
    paintAirport(u, { airport: map.airport, cam, c: map.c, layers: { buildings: true, taxiways: true }, box });
  }

  /** Call signs, by the same rules as on the map. */
  #label(g, see, view) {
    const { map } = this.insets, items = [];
    g.font = BOLD;
    for (const target of map.scan.tracks.filter(sound)) {
      const [x, y] = this.cam.toScreen(target.x, target.y);
      if (x < 0 || y < 0 || x > view.w || y > view.h) continue;
      const lines = labelLines(target).slice(0, 1);
      items.push({ id: target.id, target, x, y, lines, sizes: { 1: { w: Math.ceil(g.measureText(lines[0]).width) + 10, h: 19 } }, level: 1, reach: 6, importance: target.id === map.selected ? 900 : Math.hypot(target.vx, target.vy) || 0 });
    }
    this.placed = place(items, { view, before: this.before });
    this.before = new Map([...this.placed].map(([id, p]) => [id, { dx: p.dx, dy: p.dy }]));
    paintLabels(g, see, this.placed);
  }
}

export class Insets {
  /** `onPick(id)`; `onChange()`: the address is to follow. */
  constructor(box, map, { onPick, onChange }) {
    Object.assign(this, { box, map, onPick, changed: onChange, list: [] });
  }

  /** A window more, of the middle of the map or of a view; false where there are two. */
  open(view = { cx: this.map.cam.cx, cy: this.map.cam.cy, scale: this.map.cam.scale * CLOSER, rot: this.map.cam.rot }) {
    const number = [1, 2].find((n) => !this.list.some((inset) => inset.number === n));
    if (!number) return false;
    const inset = new Inset(number, view, this);
    this.list = [...this.list, inset].sort((a, b) => a.number - b.number);
    this.box.append(inset.box);
    inset.draw();
    this.map.overlaysChanged();
    this.changed();
    return true;
  }

  close(inset) {
    inset.box.remove();
    this.list = this.list.filter((other) => other !== inset);
    this.map.overlaysChanged();
    this.changed();
  }

  closeAll() {
    for (const inset of [...this.list]) this.close(inset);
  }

  /** As the address has them, by number; what it does not have is closed. */
  set(views) {
    for (const inset of [...this.list]) if (!views[inset.number - 1]) this.close(inset);
    views.forEach((view, i) => {
      if (!view) return;
      const there = this.list.find((inset) => inset.number === i + 1);
      if (there) there.look(viewOf(view));
      else this.open(viewOf(view));
    });
  }

  /** For the address: { in1, in2 }. */
  get state() {
    return Object.fromEntries(this.list.map((inset) => [`in${inset.number}`, writtenView(inset.cam)]));
  }

  draw() {
    for (const inset of this.list) inset.draw();
  }
}
