// Panes beside the map, on its clock and with its view: what one sensor sees, or the tracks alone.

import { Detection } from "./detection.js";
import { Geometry } from "./geometry.js";
import { paintAirport, paintScale, paintWeather } from "./paint.js";
import { paintSelected, paintTraffic, plotMark, sound } from "./traffic.js";
import { element, fixed } from "./text.js";
import { Video } from "./video.js";

const TURNS = 6; // scans whose plots are still to be seen, fainter each
export const MOST_PANES = 3;

/** What a sensor gave in a scan: its plots, those that nothing caused, and the entities within its reach that it did not report. */
export function sensorScan(scan, sensor, site) {
  const plots = scan.plots.filter((p) => p.sensor === sensor && sound(p)), seen = new Set(plots.map((p) => p.truthIndex).filter((i) => i >= 0));
  const reach = site?.position_m && site.range_m ? (t) => Math.hypot(t.x - site.position_m[0], t.y - site.position_m[1]) <= site.range_m : () => true;
  const missed = scan.truth.filter((t, i) => sound(t) && !seen.has(i) && reach(t)), errors = plots.map((p) => p.errorM).filter((e) => e !== null);
  const rms = errors.length ? Math.sqrt(errors.reduce((s, e) => s + e * e, 0) / errors.length) : NaN;
  return { plots, ghosts: plots.filter((p) => p.truthIndex < 0), missed, rms };
}

class Pane {
  constructor(name, panes) {
    Object.assign(this, { name, panes, past: [] });
    this.canvas = element("canvas", [], { role: "img", tabindex: "0", "aria-label": this.title });
    this.head = element("h2", this.title);
    this.told = element("span", "");
    const close = element("button", "\u00d7", { type: "button", title: "Close this pane", "aria-label": `Close the pane ${this.title}` });
    this.closer = close;
    close.addEventListener("click", () => panes.toggle(name));
    this.of = "pd";
    this.errors = element("button", "1\u03c3", { type: "button", "aria-pressed": "false", title: "Under the plots: how far off a plot would be (1\u03c3, violet from 10 m on), not how surely there is one" });
    this.errors.addEventListener("click", () => {
      this.of = this.of === "pd" ? "sigma" : "pd";
      this.errors.setAttribute("aria-pressed", String(this.of === "sigma"));
      Object.assign(this, { detection: null, key: "" });
      this.draw();
    });
    this.knobs = element("div", [], { class: "knobs", hidden: "" });
    this.box = element("section", [element("header", [this.head, this.told, this.knobs, close]), this.canvas], { class: "pane", "data-pane": name });
    this.canvas.addEventListener("click", (event) => panes.pick(this, event));
    new ResizeObserver(() => this.draw()).observe(this.box);
  }

  get sensor() {
    return this.name.startsWith("sensor:") ? Number(this.name.slice(7)) : null;
  }

  get site() {
    return this.panes.map.airport?.sensors?.find((s) => s.id === this.sensor) ?? null;
  }

  /** Place of another run among those shown, of which this is the picture; null for the run looked at. */
  get run() {
    return this.name.startsWith("run:") ? Number(this.name.slice(4)) : null;
  }

  get title() {
    if (this.run !== null) return this.panes.runName(this.run);
    return this.sensor === null ? "Tracks" : this.site?.name || `Sensor ${this.sensor}`;
  }

  close() {
    this.video?.close();
  }

  /** The radar's video, where it is asked for; what is asked of the server follows the scan shown. */
  askVideo() {
    const { map } = this.panes, on = map.layers.video && this.site?.kind === "asde";
    this.knobs.hidden = !on;
    if (!on) {
      this.video?.close();
      this.video = null;
      this.videoSays = "";
      return;
    }
    if (!this.video) {
      this.video = new Video(this.sensor, () => this.draw(), (text) => (this.videoSays = text));
      const knob = (name, title, key, max, step) => {
        const input = element("input", [], { type: "range", min: "0", max: String(max), step: String(step), value: String(this.video[key]), "aria-label": `${title}, ${this.title}` });
        input.addEventListener("input", () => {
          this.video[key] = Number(input.value);
          this.draw();
        });
        return element("label", [name, input], { title });
      };
      this.knobs.replaceChildren(knob("dB", "Threshold of the video over noise, dB", "thresholdDb", 30, 1), knob("s", "Half time of the afterglow, s", "afterglowS", 5, 0.5));
    }
    if (map.scan) this.video.want(map.scan.scan, { sweeping: map.live, wallS: this.panes.wallS?.() ?? 1, run: map.run });
  }

  /** The map's camera, for as large a piece of the airport as fits. */
  camera() {
    const { map } = this.panes, cam = map.cam.copy(), w = this.canvas.clientWidth || 1, h = this.canvas.clientHeight || 1;
    const scale = cam.scale * Math.min(w / cam.width, h / cam.height);
    Object.assign(cam, { width: w, height: h });
    cam.look({ scale });
    return cam;
  }

  /** What decides how well a sensor that is no radar sees; asked for with the scans, drawn when it comes. */
  askGeometry(scan) {
    const kind = this.site?.kind;
    if (!kind || kind === "asde") return;
    this.geometry ??= new Geometry(this.sensor, () => this.draw());
    this.geometry.take(scan, this.panes.map.find(this.panes.map.selected), this.panes.map.run);
  }

  /** Keeps the scan's plots for the afterglow; a moment jumped to has none before it. */
  take(scan) {
    this.askGeometry(scan);
    if (this.past.at(-1)?.scan === scan.scan) return;
    if (this.past.at(-1)?.scan !== scan.scan - 1) this.past = [];
    this.past.push({ scan: scan.scan, plots: scan.plots.filter((p) => p.sensor === this.sensor && sound(p)) });
    this.past = this.past.slice(-TURNS);
  }

  draw() {
    const { map } = this.panes, { canvas } = this, ratio = window.devicePixelRatio || 1, cam = this.camera();
    const w = Math.round(cam.width * ratio), h = Math.round(cam.height * ratio);
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
    const g = canvas.getContext("2d"), c = map.c, scan = this.run === null ? map.scan : map.others.get(this.run) ?? null;
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.ground(g, cam, ratio);
    if (!scan) this.told.textContent = "no picture at this time";
    if (scan) {
      if (this.sensor === null) this.tracks(g, cam, scan);
      else this.seen(g, cam, scan);
      if (this.run === null) paintSelected(g, cam, c, map.find(map.selected));
    }
    paintScale(g, cam, c);
    if (this.site?.kind === "asde" && !this.errors.isConnected) this.closer.before(this.errors);
    if (this.head.textContent !== this.title) {
      this.head.textContent = this.title;
      this.closer.setAttribute("aria-label", `Close the pane ${this.title}`);
    }
  }

  /** The airport, drawn again only where the view or the colours changed. */
  ground(g, cam, ratio) {
    const { map } = this.panes, key = [cam.cx, cam.cy, cam.scale, cam.rot, cam.width, cam.height, ratio, map.c.ground, map.airport?.icao, map.run, map.weather?.from_ns, this.detection?.shown, Boolean(this.video)].join();
    if (key !== this.key) {
      this.key = key;
      this.under ??= document.createElement("canvas");
      Object.assign(this.under, { width: this.canvas.width, height: this.canvas.height });
      const u = this.under.getContext("2d");
      u.setTransform(ratio, 0, 0, ratio, 0, 0);
      // Under what a radar sees: how surely it would.
      if (this.site?.kind === "asde") this.detection ??= new Detection(this.sensor, () => this.panes.draw(), this.of, () => this.panes.map.run);
      paintAirport(u, { airport: map.airport, cam, c: map.c, layers: { buildings: true, coverage: this.sensor !== null }, box: { x: 0, y: 0, w: cam.width, h: cam.height } });
      if (!this.video) this.detection?.paint(u, cam, (map.weather?.from_ns ?? 0) / 1e9);
    }
    g.save();
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.drawImage(this.under, 0, 0);
    g.restore();
  }

  tracks(g, cam, scan) {
    const { map } = this.panes, layers = { tracks: true, history: true, vectors: true, ellipses: true, plots: false, truth: false, weather: false };
    paintTraffic(g, { ...map, scan, cam, c: map.c, layers, sensorsOff: map.sensorsOff });
    this.told.textContent = `${scan.tracks.length} tracks`;
  }

  seen(g, cam, scan) {
    const { map } = this.panes, { c } = map, { plots, ghosts, missed, rms } = sensorScan(scan, this.sensor, this.site), kind = this.site?.kind ?? plots[0]?.kind ?? "other";
    if (this.video) this.video.paint(g, cam, c.video, scan.timeS);
    else if (this.site?.position_m) this.shadows(g, cam);
    this.geometry?.paintUnder(g, cam, c);
    paintWeather(g, { weather: map.weather, cam, c });
    g.strokeStyle = c[`plot-${kind}`] ?? c["plot-other"];
    this.past.forEach((turn, i) => {
      g.globalAlpha = (i + 1) / this.past.length;
      g.lineWidth = i === this.past.length - 1 ? 1.8 : 1;
      g.beginPath();
      for (const p of turn.plots) plotMark(g, kind, ...cam.toScreen(p.x, p.y), i === this.past.length - 1 ? 4.5 : 2.5);
      g.stroke();
    });
    g.globalAlpha = 1;
    this.geometry?.paintOver(g, cam, c, scan, map.find(map.selected));
    if (map.skin === "controller" || map.blind) {
      this.told.textContent = this.said(`${plots.length} plots`);
      return;
    }
    // Nothing caused these: rings; these it should have reported: crosses.
    g.strokeStyle = c.error;
    g.lineWidth = 1.4;
    g.beginPath();
    for (const p of ghosts) {
      const [x, y] = cam.toScreen(p.x, p.y);
      g.moveTo(x + 8, y);
      g.arc(x, y, 8, 0, 7);
    }
    for (const t of missed) {
      const [x, y] = cam.toScreen(t.x, t.y);
      g.moveTo(x - 4, y - 4);
      g.lineTo(x + 4, y + 4);
      g.moveTo(x - 4, y + 4);
      g.lineTo(x + 4, y - 4);
    }
    g.stroke();
    this.told.textContent = this.said(`${plots.length} plots, ${ghosts.length} false, ${missed.length} not reported, error ${fixed(rms, 1)} m`);
  }

  said(text) {
    const { scan } = this.panes.map;
    return [text, this.geometry?.text(scan), this.videoSays].filter(Boolean).join("; ");
  }

  /** What the buildings of the scene hide from the sensor: from each wall away from it. */
  shadows(g, cam) {
    const { airport, c } = this.panes.map, [sx, sy] = this.site.position_m, far = 20_000;
    g.fillStyle = c.ground;
    g.globalAlpha = 0.45;
    for (const { ring } of airport.blocks ?? []) {
      const angles = ring.map(([x, y]) => Math.atan2(y - sy, x - sx)), middle = Math.atan2(ring.reduce((s, p) => s + p[1] - sy, 0), ring.reduce((s, p) => s + p[0] - sx, 0));
      const turned = angles.map((a) => Math.atan2(Math.sin(a - middle), Math.cos(a - middle)));
      const [a, b] = [turned.indexOf(Math.min(...turned)), turned.indexOf(Math.max(...turned))].map((i) => ring[i]);
      const away = ([x, y]) => [sx + ((x - sx) / (Math.hypot(x - sx, y - sy) || 1)) * far, sy + ((y - sy) / (Math.hypot(x - sx, y - sy) || 1)) * far];
      g.beginPath();
      [a, away(a), away(b), b].forEach((p, i) => (i ? g.lineTo(...cam.toScreen(...p)) : g.moveTo(...cam.toScreen(...p))));
      g.fill();
    }
    g.globalAlpha = 1;
  }
}

export class Panes {
  /** `onPick(id)`, `onChange()`, `runName(place)`; `makers` of panes that show no sensor, by the kind before the colon. */
  constructor(box, map, { onPick, onChange, runName = String }) {
    Object.assign(this, { box, map, onPick, onChange, runName, list: [], makers: {} });
  }

  /** As the address has them: other runs stand there by `cmp`. */
  get names() {
    return this.list.map((p) => p.name).filter((name) => !name.startsWith("run:"));
  }

  has(name) {
    return this.list.some((p) => p.name === name);
  }

  toggle(name) {
    if (this.has(name)) {
      const gone = this.list.find((p) => p.name === name);
      gone.close();
      gone.box.remove();
    }
    else if (this.list.length >= MOST_PANES) return false;
    const before = this.list.filter((p) => p.name !== name);
    this.list = this.has(name) ? before : [...before, this.makers[name.split(":")[0]]?.(name) ?? new Pane(name, this)];
    this.box.replaceChildren(...this.list.map((p) => p.box));
    this.box.hidden = !this.list.length;
    if (this.map.scan) this.scan(this.map.scan);
    this.draw();
    this.onChange();
    return true;
  }

  /** As the address has them. */
  set(names) {
    for (const name of this.names) if (!names.includes(name)) this.toggle(name);
    for (const name of names) if (!this.has(name) && name !== "map") this.toggle(name);
  }

  /** Other runs side by side, or none of them. */
  setRuns(places) {
    const wanted = places.map((place) => `run:${place}`);
    for (const { name } of [...this.list]) if (name.startsWith("run:") && !wanted.includes(name)) this.toggle(name);
    for (const name of wanted) if (!this.has(name)) this.toggle(name);
  }

  scan(scan) {
    for (const pane of this.list) {
      pane.take(scan);
      pane.askVideo();
    }
  }

  /** The layer of the video was switched: with no radar's pane open, the first radar's is opened. */
  videoChanged() {
    const { map } = this, radars = (map.airport?.sensors ?? []).filter((s) => s.kind === "asde");
    if (map.layers.video && radars.length && !this.list.some((p) => p.site?.kind === "asde")) this.toggle(`sensor:${radars[0].id}`);
    for (const pane of this.list) pane.askVideo();
    this.draw();
  }

  draw() {
    for (const pane of this.list) pane.draw();
  }

  pick(pane, event) {
    const box = pane.canvas.getBoundingClientRect(), cam = pane.camera(), at = [event.clientX - box.left, event.clientY - box.top];
    const near = [...(this.map.scan?.tracks ?? []), ...(this.map.scan?.truth ?? []).filter((t) => t.track === null)].filter(sound)
      .map((t) => [Math.hypot(cam.toScreen(t.x, t.y)[0] - at[0], cam.toScreen(t.x, t.y)[1] - at[1]), t.id]).sort((a, b) => a[0] - b[0])[0];
    this.onPick(near && near[0] < 16 ? near[1] : null);
  }
}
