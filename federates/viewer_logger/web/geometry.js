// What decides how well a sensor that is no radar sees, in its pane: the sky and its dilution, stations and theirs, messages and their
// age, loops. The figures are the models' own (`GET /geometry`); here they are fetched once for as long as they hold, and drawn.

import { STILL_MPS } from "./situation.js";
import { fixed } from "./text.js";

/** How long a sky holds, s of simulated time; what stands in the ground does not change. */
const SKY_S = 10;
const STALE_S = 2, MOST_NAMES = 6;
/** Steps of the map of dilution: up to which value, how opaque. */
const STEPS = [[1, 0.05], [1.5, 0.12], [2, 0.2], [4, 0.32], [Infinity, 0.45]];

/** Where a satellite stands in a sky plot of a radius, north up: zenith in the middle, horizon at the rim. */
export function skyPlace({ azimuth_deg: azimuth, elevation_deg: elevation }, radius) {
  const a = (azimuth * Math.PI) / 180, r = (radius * (90 - Math.max(0, elevation))) / 90;
  return [r * Math.sin(a), -r * Math.cos(a)];
}

/** The geometry in words, for the head of the pane. */
export function geometryText(told, ages = []) {
  if (!told) return "";
  if (told.kind === "gps") {
    const age = Number.isFinite(told.correction_age_s) ? `correction ${fixed(told.correction_age_s, 1)} s old` : "";
    if (told.statistical) return ["by statistics: no sky is simulated", age].filter(Boolean).join(", ");
    const used = told.satellites.filter((s) => s.used).length, dop = told.dop;
    return [`${used} satellites`, dop ? `HDOP ${fixed(dop.horizontal, 2)}, VDOP ${fixed(dop.vertical, 2)}, PDOP ${fixed(dop.position, 2)}` : "no fix", age].filter(Boolean).join(", ");
  }
  if (told.kind === "mlat") {
    const heard = told.target ? `, selected: heard by ${told.target.heard_by.length}, HDOP ${told.target.dilution === null ? "\u2013" : fixed(told.target.dilution, 2)}` : "";
    return `${told.stations.length} stations${heard}`;
  }
  if (told.kind === "adsb") {
    const silent = ages.filter((a) => a.ageS === null), old = ages.filter((a) => a.late);
    const names = silent.slice(0, MOST_NAMES).map((a) => a.name).join(" ");
    return [`NACp ${told.nacp} (${told.radius_95_m} m, 95 %)`, old.length ? `${old.length} late` : "", silent.length ? `silent: ${names}${silent.length > MOST_NAMES ? ` and ${silent.length - MOST_NAMES} more` : ""}` : ""].filter(Boolean).join(", ");
  }
  return told.kind === "loop" ? `${told.loops_m.length} loop${told.loops_m.length > 1 ? "s" : ""}` : "";
}

/**
 * Of each entity how old its last message is, s; null: none was heard since the pane is open. `last`: by entity, when. Late: two
 * messages are missing, of those that it sends as it moves or stands.
 */
export function agesOf(scan, last, { moving_s: moving = 0, parked_s: parked = 0 } = {}) {
  return scan.truth.map((t) => {
    const ageS = last.has(t.id) ? scan.timeS - last.get(t.id) : null, every = Math.hypot(t.vx || 0, t.vy || 0) < STILL_MPS ? parked : moving;
    return { name: t.callsign || t.id, x: t.x, y: t.y, ageS, late: ageS !== null && ageS > Math.max(STALE_S, 2 * every) };
  });
}

/** Beyond loopback for whoever shows the token of its tab. */
function withToken(url) {
  const token = sessionStorage.getItem("token");
  return fetch(url, token ? { headers: { Authorization: `Bearer ${token}` } } : {});
}

export class Geometry {
  run = "";
  told = null;
  target = null;
  why = "";
  /** When each entity was heard last, s. */
  last = new Map();
  #asked = null;
  #askedTarget = null;

  /** `changed()` when something came. */
  constructor(sensor, changed, fetched = withToken) {
    Object.assign(this, { sensor, changed, fetched });
  }

  /** What the scan shown needs, of a run; `selected`: a target whose stations are asked for. */
  async take(scan, selected, run = "") {
    if (run !== this.run) {
      Object.assign(this, { run, told: null, target: null });
      this.#asked = this.#askedTarget = null;
      this.last.clear();
    }
    const of = run && `&run=${encodeURIComponent(run)}`, put = (told) => run === this.run && told();
    if (this.lastScanS === undefined || scan.timeS < this.lastScanS || scan.timeS > this.lastScanS + 5) this.last.clear();
    this.lastScanS = scan.timeS;
    for (const p of scan.plots) if (p.sensor === this.sensor && p.truthIndex >= 0) this.last.set(scan.truth[p.truthIndex]?.id, scan.timeS - (p.ageS || 0));
    const epoch = Math.max(0, Math.floor(scan.timeS / SKY_S) * SKY_S), key = this.told && this.told.kind !== "gps" ? "stands" : epoch;
    if (key !== "stands" && key !== this.#asked) {
      this.#asked = key;
      await this.#get(`/geometry?sensor=${this.sensor}&t=${epoch}${of}`, (told) => put(() => (this.told = told)));
    }
    if (this.told?.kind !== "mlat" || run !== this.run) return;
    const place = selected ? [selected.x, selected.y].map((v) => Math.round(v / 10) * 10) : null, asked = place?.join() ?? null;
    if (asked === this.#askedTarget) return;
    this.#askedTarget = asked;
    if (place) await this.#get(`/geometry?sensor=${this.sensor}&x=${place[0]}&y=${place[1]}${of}`, (told) => put(() => (this.target = asked === this.#askedTarget ? told.target : this.target)));
    else this.target = null;
  }

  async #get(url, put) {
    try {
      const answer = await this.fetched(url);
      if (answer.ok) put(await answer.json());
      else this.why = (await answer.text()).trim();
    } catch {
      this.why = "no connection";
    }
    this.changed();
  }

  text(scan) {
    if (!this.told) return this.why;
    return geometryText({ ...this.told, target: this.target }, this.told.kind === "adsb" ? agesOf(scan, this.last, this.told) : []);
  }

  /** Under the plots. */
  paintUnder(g, cam, c) {
    const map = this.told?.map;
    if (!map) return;
    const size = map.step_m * cam.scale;
    g.fillStyle = c.coverage;
    map.cells.forEach((value, i) => {
      const x = map.west_m + ((i % map.columns) + 0.5) * map.step_m, y = map.north_m - (Math.floor(i / map.columns) + 0.5) * map.step_m, [px, py] = cam.toScreen(x, y);
      if (px < -size || py < -size || px > cam.width + size || py > cam.height + size) return;
      g.globalAlpha = value === null ? 0.6 : STEPS.find(([to]) => value <= to)[1];
      g.fillRect(px - size / 2, py - size / 2, size + 0.5, size + 0.5);
    });
    g.globalAlpha = 1;
  }

  /** Over them: `scan`, the selected target, and the size of the pane. */
  paintOver(g, cam, c, scan, selected) {
    const { told } = this;
    if (!told) return;
    if (told.kind === "mlat") this.#stations(g, cam, c, selected);
    if (told.kind === "loop") this.#loops(g, cam, c, scan);
    if (told.kind === "adsb") this.#ages(g, cam, c, scan);
    if (told.kind === "gps") {
      if (told.reference_m) this.#mark(g, cam, c, told.reference_m);
      if (!told.statistical) this.#sky(g, cam, c, scan);
    }
  }

  #mark(g, cam, c, at) {
    const [x, y] = cam.toScreen(...at);
    g.fillStyle = c.text;
    g.beginPath();
    g.moveTo(x, y - 6);
    g.lineTo(x + 5, y + 4);
    g.lineTo(x - 5, y + 4);
    g.fill();
  }

  #stations(g, cam, c, selected) {
    const heard = new Set(selected ? this.target?.heard_by ?? [] : []);
    g.strokeStyle = c.select;
    g.lineWidth = 1.2;
    g.beginPath();
    for (const i of heard) {
      g.moveTo(...cam.toScreen(...this.told.stations[i].position_m));
      g.lineTo(...cam.toScreen(selected.x, selected.y));
    }
    g.stroke();
    for (const { position_m: at } of this.told.stations) this.#mark(g, cam, c, at);
  }

  /** A loop is full while somebody's passage was told in this scan. */
  #loops(g, cam, c, scan) {
    const passed = scan.plots.some((p) => p.sensor === this.sensor);
    g.strokeStyle = g.fillStyle = c.select;
    g.lineWidth = 2;
    for (const ring of this.told.loops_m) {
      g.beginPath();
      ring.forEach((p, i) => (i ? g.lineTo(...cam.toScreen(...p)) : g.moveTo(...cam.toScreen(...p))));
      g.closePath();
      if (passed) g.fill();
      g.stroke();
    }
  }

  #ages(g, cam, c, scan) {
    g.font = "11px B612, sans-serif";
    g.fillStyle = c.text;
    for (const { x, y, ageS, late } of agesOf(scan, this.last, this.told)) {
      if (ageS !== null && !late) continue;
      const [px, py] = cam.toScreen(x, y);
      if (Number.isFinite(px + py)) g.fillText(ageS === null ? "silent" : `${fixed(ageS, 0)} s`, px + 8, py - 6);
    }
  }

  /** The sky in the corner, and a bar over the run: when there is no fix. */
  #sky(g, cam, c, scan) {
    const radius = Math.max(36, Math.min(90, 0.22 * Math.min(cam.width, cam.height))), [x0, y0] = [cam.width - radius - 14, radius + 14];
    g.save();
    g.translate(x0, y0);
    g.fillStyle = c["label-back"];
    g.strokeStyle = c.dim;
    g.lineWidth = 1;
    g.beginPath();
    g.arc(0, 0, radius + 6, 0, 7);
    g.fill();
    for (const elevation of [0, 30, 60]) {
      g.beginPath();
      g.arc(0, 0, (radius * (90 - elevation)) / 90, 0, 7);
      g.stroke();
    }
    g.setLineDash([2, 3]);
    g.beginPath();
    g.arc(0, 0, (radius * (90 - this.told.mask_deg)) / 90, 0, 7);
    g.stroke();
    g.setLineDash([]);
    g.font = "10px B612, sans-serif";
    g.fillStyle = c.text;
    g.textAlign = "center";
    g.fillText("N", 0, -radius - 1);
    for (const satellite of this.told.satellites) {
      const [x, y] = skyPlace(satellite, radius);
      g.beginPath();
      g.arc(x, y, 4, 0, 7);
      g.fillStyle = g.strokeStyle = satellite.error_m ? c.error : c.text;
      if (satellite.used) g.fill();
      else g.stroke();
      g.fillText(satellite.name, x, y - 6);
    }
    g.textAlign = "start";
    g.restore();
    const { outages_s: outages, until_s: until } = this.told, at = (s) => (s / Math.max(1, until)) * cam.width;
    g.fillStyle = c.coverage;
    g.fillRect(0, cam.height - 4, cam.width, 4);
    g.fillStyle = c.error;
    for (const [from, to] of outages) g.fillRect(at(from), cam.height - 6, Math.max(2, at(to) - at(from)), 6);
    g.fillStyle = c.select;
    g.fillRect(at(scan.timeS) - 1, cam.height - 8, 2, 8);
  }
}
