// Draws what moves: rain, trails, plots, truth, errors, vectors, ellipses, tracks, labels. One path a colour.

import { kinds } from "./frame.js";
import { paintWeather } from "./paint.js";
import { SHORT_LEADER, whole } from "./labels.js";
import { STILL_MPS } from "./situation.js";

const KNOT = 1.943844, FOOT = 3.28084, AIRBORNE_M = 15;
export const BOLD = "700 12px B612, sans-serif", PLAIN = "11px B612, sans-serif";

/** What a scan holds that has a place on the map. */
export function targetsOf(scan, layers) {
  if (!scan) return [];
  const tracks = layers.tracks ? scan.tracks.filter(sound) : [];
  const alone = layers.truth ? scan.truth.filter((t) => sound(t) && (t.track === null || !layers.tracks)) : [];
  return [...tracks, ...alone];
}

export function sound(p) {
  return Number.isFinite(p.x) && Number.isFinite(p.y) && Math.abs(p.x) < 1e6 && Math.abs(p.y) < 1e6;
}

export function colourOf(c, target) {
  if (target.number === undefined) return c.truth;
  return { arrival: c.arrival, departure: c.departure, vehicle: c.vehicle }[target.movement] ?? (target.type === "vehicle" ? c.vehicle : c.unknown);
}

/** Runway and stand of a label, with the stand that control gave instead of the planned one. */
export function placeOf(runwayStand, given) {
  const at = runwayStand.lastIndexOf("/");
  return given && at >= 0 ? `${runwayStand.slice(0, at + 1)}${given}` : runwayStand;
}

/** The lines of a label, up to level 3; `given`: the stand that the flight has now, where traffic says it. */
export function labelLines(target, given = "") {
  const name = cut(target.callsign || (target.number === undefined ? "no name" : `#${target.number}`)) + (target.assumed ? "?" : "");
  const mps = Math.hypot(target.vx, target.vy), speed = mps < STILL_MPS ? 0 : Math.round(mps * KNOT);
  const kind = target.wake ? `${target.designator}/${target.wake}` : target.designator;
  const height = target.altitudeM > AIRBORNE_M ? `${Math.round((target.altitudeM * FOOT) / 10) * 10} ft` : "";
  const second = [kind, Number.isFinite(speed) ? `${speed} kt` : "", height].filter(Boolean).join("  ");
  if (target.number === undefined) return [name, `${second}  no track`];
  return [name, second, cut(placeOf(target.runwayStand, given).replaceAll("_", " "))].filter(Boolean);
}

const cut = (text) => ([...text].length > 24 ? `${[...text].slice(0, 23).join("")}\u2026` : text);

/** Everything of the scan but the labels; `see` has scan, cam, c, layers, weather, sensorsOff, vectorS, dots. */
export function paintTraffic(g, see) {
  whole(paintingTraffic(g, see));
}

/** Targets that are drawn without a pause. */
const A_STEP = 100;

/** The same in steps. */
export function* paintingTraffic(g, see) {
  const { scan, cam, c, layers } = see;
  if (layers.weather) paintWeather(g, see);
  if (!scan) return;
  const tracks = layers.tracks ? scan.tracks.filter(sound) : [];
  yield;
  if (layers.history) yield* trails(g, see);
  if (layers.plots !== false) plots(g, see);
  yield;
  if (layers.ellipses) {
    for (const [i, t] of tracks.entries()) {
      ellipse(g, cam, t, colourOf(c, t));
      if (i % A_STEP === A_STEP - 1) yield;
    }
  }
  for (const part of layers.truth ? parts(scan.truth) : []) {
    truths(g, { ...see, scan: { truth: part } });
    yield;
  }
  if (layers.errors) errors(g, see);
  if (layers["one second ago"]) lags(g, see, tracks);
  yield;
  if (layers.vectors) vectors(g, see, targetsOf(scan, layers));
  yield;
  symbols(g, see, tracks);
  yield;
}

function parts(list) {
  return Array.from({ length: Math.ceil(list.length / A_STEP) }, (_, i) => list.slice(i * A_STEP, (i + 1) * A_STEP));
}

function* trails(g, { scan, cam, c, dots }) {
  const parts = new Map(); // by colour: by age: pixels
  for (const track of scan.tracks) {
    const points = scan.trails.get(track.number) ?? [], colour = colourOf(c, track), n = Math.min(points.length, dots);
    let ages = parts.get(colour);
    if (!ages) parts.set(colour, (ages = [[], [], [], [], [], []]));
    for (let i = 0; i < n; i++) {
      const [x, y] = points[i];
      if (!Number.isFinite(x + y)) continue;
      const [px, py] = cam.toScreen(x, y);
      ages[Math.min(5, Math.floor((6 * i) / (n + 1)))].push(px - 1, py - 1);
    }
  }
  for (const [colour, ages] of parts) {
    g.fillStyle = colour;
    for (const [age, pixels] of ages.entries()) {
      g.globalAlpha = 0.6 - 0.09 * age;
      for (let i = 0; i < pixels.length; i += 2) g.fillRect(pixels[i], pixels[i + 1], 2, 2);
      yield;
    }
  }
  g.globalAlpha = 1;
}

function plots(g, { scan, cam, c, sensorsOff }) {
  const by = Map.groupBy(scan.plots.filter((p) => !sensorsOff.has(p.sensor) && sound(p)), (p) => p.kind);
  g.lineWidth = 1.2;
  for (const [kind, list] of by) {
    g.strokeStyle = c[`plot-${kind}`] ?? c["plot-other"];
    g.beginPath();
    for (const plot of list) plotMark(g, kind, ...cam.toScreen(plot.x, plot.y), 3.5);
    g.stroke();
  }
}

function truths(g, { scan, cam, c }) {
  g.strokeStyle = c.truth;
  g.lineWidth = 1.2;
  for (const ours of [true, false]) {
    g.setLineDash(ours ? [] : [3, 2]);
    g.beginPath();
    for (const truth of scan.truth) if (truth.ours === ours && sound(truth)) outline(g, truth, ...cam.toScreen(truth.x, truth.y), cam.scale, cam.rot);
    g.stroke();
  }
  g.setLineDash([]);
}

function errors(g, { scan, cam, c }) {
  g.strokeStyle = c.error;
  g.lineWidth = 1.6;
  g.beginPath();
  for (const track of scan.tracks) {
    if (!track.truth || !sound(track) || !sound(track.truth)) continue;
    g.moveTo(...cam.toScreen(track.x, track.y));
    g.lineTo(...cam.toScreen(track.truth.x, track.truth.y));
  }
  g.stroke();
}

/** Where each track was a scan ago as it is known now: a small cross. */
function lags(g, { cam, c }, tracks) {
  g.strokeStyle = c.dim;
  g.lineWidth = 1.2;
  g.beginPath();
  for (const { lag } of tracks) {
    if (!lag) continue;
    const [x, y] = cam.toScreen(lag.x, lag.y);
    g.moveTo(x - 3, y);
    g.lineTo(x + 3, y);
    g.moveTo(x, y - 3);
    g.lineTo(x, y + 3);
  }
  g.stroke();
}

function vectors(g, { cam, c, vectorS }, targets) {
  g.lineWidth = 1.2;
  for (const [colour, list] of Map.groupBy(targets, (t) => colourOf(c, t))) {
    g.strokeStyle = colour;
    g.beginPath();
    for (const t of list) {
      if (!(Math.hypot(t.vx, t.vy) >= STILL_MPS)) continue;
      g.moveTo(...cam.toScreen(t.x, t.y));
      g.lineTo(...cam.toScreen(t.x + t.vx * vectorS, t.y + t.vy * vectorS));
    }
    g.stroke();
  }
}

function ellipse(g, cam, track, colour) {
  const e = ellipseOf(track.cov);
  if (!e) return;
  const a = e.a * cam.scale, b = e.b * cam.scale;
  if (a < 4 || a > 4000) return;
  g.strokeStyle = colour;
  g.globalAlpha = 0.55;
  g.lineWidth = 1;
  g.beginPath();
  g.ellipse(...cam.toScreen(track.x, track.y), a, Math.max(b, 0.5), -e.angle - (cam.rot * Math.PI) / 180, 0, 7);
  g.stroke();
  g.globalAlpha = 1;
}

function symbols(g, { cam, c }, tracks) {
  for (const [colour, list] of Map.groupBy(tracks, (t) => colourOf(c, t))) {
    const hollow = (t) => t.status === "coasting" || t.status === "tentative" || ((!t.callsign || t.assumed) && t.type !== "none");
    for (const open of [false, true]) {
      const some = list.filter((t) => hollow(t) === open);
      if (!some.length) continue;
      g.beginPath();
      for (const t of some) trackMark(g, t, ...cam.toScreen(t.x, t.y), 5);
      g.strokeStyle = open ? colour : c.ground;
      g.fillStyle = colour;
      g.lineWidth = open ? 1.6 : 1;
      if (!open) g.fill();
      g.stroke();
    }
    g.strokeStyle = colour;
    g.lineWidth = 1;
    g.beginPath();
    for (const t of list) {
      if (!t.manoeuvre) continue;
      const [x, y] = cam.toScreen(t.x, t.y);
      g.moveTo(x + 8 * Math.cos(0.9), y - 8 * Math.sin(0.9));
      g.arc(x, y, 8, -0.9, 0.9);
    }
    g.stroke();
  }
}

/** Labels where they were placed; their items have lines and target. */
export function paintLabels(g, see, placed) {
  whole(paintingLabels(g, see, placed));
}

/** The same in steps. */
export function* paintingLabels(g, { c, selected }, placed) {
  g.textAlign = "left";
  g.textBaseline = "alphabetic";
  g.lineWidth = 1;
  const all = [...placed.values()];
  for (const [colour, list] of Map.groupBy(all, (p) => colourOf(c, p.item.target))) {
    g.strokeStyle = colour;
    g.globalAlpha = 0.6;
    g.beginPath();
    for (const { item, ax, ay } of list) {
      const length = Math.hypot(ax - item.x, ay - item.y);
      if (length < SHORT_LEADER) continue;
      g.moveTo(item.x + ((ax - item.x) / length) * 8, item.y + ((ay - item.y) / length) * 8);
      g.lineTo(ax, ay);
    }
    g.stroke();
    g.globalAlpha = 1;
    g.fillStyle = c["label-back"];
    for (const p of list) g.fillRect(p.x, p.y, p.w, p.h);
    g.fillStyle = colour;
    g.font = BOLD;
    for (const p of list) g.fillText(p.item.lines[0], p.x + 5, p.y + 14);
    yield;
  }
  g.fillStyle = c.text;
  g.font = PLAIN;
  for (const p of all) for (let i = 1; i < p.level && i < p.item.lines.length; i++) g.fillText(p.item.lines[i], p.x + 5, p.y + 14 + 13 * i);
  yield;
  const chosen = placed.get(selected);
  if (chosen) {
    g.strokeStyle = c.select;
    g.strokeRect(chosen.x + 0.5, chosen.y + 0.5, chosen.w - 1, chosen.h - 1);
  }
  g.strokeStyle = c.dim;
  g.setLineDash([3, 2]);
  for (const p of all) if (p.item.target.status === "coasting") g.strokeRect(p.x + 0.5, p.y + 0.5, p.w - 1, p.h - 1);
  g.setLineDash([]);
}

/** Corners round the selected target. */
export function paintSelected(g, cam, c, target) {
  if (!target || !sound(target)) return;
  const [x, y] = cam.toScreen(target.x, target.y), r = 12, k = 5;
  g.strokeStyle = c.select;
  g.lineWidth = 1.6;
  g.beginPath();
  for (const [sx, sy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
    g.moveTo(x + sx * r, y + sy * (r - k));
    g.lineTo(x + sx * r, y + sy * r);
    g.lineTo(x + sx * (r - k), y + sy * r);
  }
  g.stroke();
}

/** 95 % ellipse of a covariance [ee, en, nn]: half axes in metres, angle of the larger from east. */
export function ellipseOf([ee, en, nn]) {
  if (![ee, en, nn].every(Number.isFinite)) return null;
  const mean = (ee + nn) / 2, gap = Math.hypot((ee - nn) / 2, en);
  const k = 2.4477; // root of the 95 % quantile of chi squared with two degrees of freedom
  return { a: k * Math.sqrt(Math.max(0, mean + gap)), b: k * Math.sqrt(Math.max(0, mean - gap)), angle: Math.atan2(2 * en, ee - nn) / 2 };
}

/** Adds an aircraft or vehicle to the path, to scale, at least a few pixels large. */
export function outline(g, truth, x, y, scale, rot = 0) {
  const length = Math.max((truth.lengthM || 10) * scale, 9), span = Math.max((truth.spanM || 5) * scale, truth.aircraft ? 8 : 5);
  const heading = (Number.isFinite(truth.heading) ? truth.heading : 0) - (rot * Math.PI) / 180;
  const [sin, cos] = [Math.sin(heading), Math.cos(heading)];
  (truth.aircraft ? AIRCRAFT : VEHICLE).forEach(([across, along], i) => {
    const a = across * span, l = along * length, px = x + l * sin + a * cos, py = y - l * cos + a * sin;
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

/** Disc for an aircraft, square for a vehicle, diamond where nothing is known. */
function trackMark(g, track, x, y, r) {
  if (track.type === "vehicle") g.rect(x - r + 1, y - r + 1, 2 * r - 2, 2 * r - 2);
  else if (track.type === "aircraft") {
    g.moveTo(x + r, y);
    g.arc(x, y, r, 0, 7);
  } else {
    g.moveTo(x, y - r - 1);
    g.lineTo(x + r + 1, y);
    g.lineTo(x, y + r + 1);
    g.lineTo(x - r - 1, y);
    g.closePath();
  }
}
