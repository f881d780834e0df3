// Draws the airport: pavement, buildings, runways, names, stands, sensors. Everything by the camera, so that any rotation works.

import { runwayRing } from "./situation.js";

function path(g, cam, points, close = false) {
  points.forEach(([x, y], i) => {
    const [px, py] = cam.toScreen(x, y);
    if (i) g.lineTo(px, py);
    else g.moveTo(px, py);
  });
  if (close) g.closePath();
}

/** `box` is what is seen, in pixels of the camera. */
export function paintAirport(g, { airport, cam, c, layers, box }) {
  const { scale } = cam;
  g.fillStyle = c.ground;
  g.fillRect(box.x, box.y, box.w, box.h);
  if (!airport) return;
  g.lineJoin = g.lineCap = "round";
  // Ground network first as broad bands, so that taxiways without mapped pavement have a surface.
  g.strokeStyle = c.pavement;
  g.lineWidth = Math.max(1.5, 23 * scale);
  g.beginPath();
  for (const way of airport.taxiways) path(g, cam, way.points_m);
  g.stroke();
  areas(g, cam, airport.pavements, c.pavement);
  if (layers.buildings !== false) areas(g, cam, [...(airport.buildings ?? []), ...(airport.blocks ?? []).map((b) => ({ rings: [b.ring] }))], c["pavement-edge"]);
  for (const runway of airport.runways) paintRunway(g, cam, c, runway);
  g.strokeStyle = c.taxi;
  g.lineWidth = Math.max(0.7, Math.min(1.6, scale * 2));
  g.beginPath();
  for (const way of airport.taxiways) path(g, cam, way.points_m);
  g.stroke();
  paintHolds(g, cam, c, airport.holds ?? []);
  const seen = { airport, cam, c, box };
  if (layers.stands) paintStands(g, seen);
  if (layers.taxiways) paintNames(g, seen);
  paintSites(g, seen, layers);
}

/** Holding positions: a line across the taxiway, of category II/III with bars across it where there is room for them. */
function paintHolds(g, cam, c, holds) {
  g.strokeStyle = c["runway-mark"];
  g.lineWidth = Math.min(2.5, Math.max(1, 0.9 * cam.scale));
  g.beginPath();
  for (const { ends_m: [a, b], cat3 } of holds) {
    path(g, cam, [a, b]);
    if (!cat3 || cam.scale < 0.5) continue;
    const [p, q] = [cam.toScreen(...a), cam.toScreen(...b)], length = Math.hypot(q[0] - p[0], q[1] - p[1]) || 1;
    const [ux, uy] = [(q[0] - p[0]) / length, (q[1] - p[1]) / length];
    for (const at of [0.2, 0.5, 0.8].map((k) => [p[0] + k * (q[0] - p[0]), p[1] + k * (q[1] - p[1])])) {
      g.moveTo(at[0] - 3 * uy, at[1] + 3 * ux);
      g.lineTo(at[0] + 3 * uy, at[1] - 3 * ux);
    }
  }
  g.stroke();
}

function areas(g, cam, list, colour) {
  g.fillStyle = colour;
  for (const area of list) {
    g.beginPath();
    for (const ring of area.rings) path(g, cam, ring, true);
    g.fill("evenodd");
  }
}

function paintRunway(g, cam, c, runway) {
  const [a, b] = runway.ends, dx = b[0] - a[0], dy = b[1] - a[1], length = Math.hypot(dx, dy) || 1, { scale } = cam;
  const ux = dx / length, uy = dy / length;
  g.fillStyle = c.runway;
  g.strokeStyle = c["runway-mark"];
  g.lineWidth = 1;
  g.beginPath();
  path(g, cam, runwayRing(runway, 0), true);
  g.fill();
  g.stroke();
  g.setLineDash([30 * scale, 20 * scale]);
  g.lineWidth = Math.max(0.8, 0.9 * scale);
  g.beginPath();
  path(g, cam, [[a[0] + ux * 80, a[1] + uy * 80], [b[0] - ux * 80, b[1] - uy * 80]]);
  g.stroke();
  g.setLineDash([]);
  g.font = `700 ${Math.max(11, Math.min(26, 24 * scale + 8))}px B612, sans-serif`;
  g.fillStyle = c["runway-mark"];
  g.textAlign = "center";
  g.textBaseline = "middle";
  designators(cam, runway).forEach(([px, py], i) => g.fillText(runway.designators[i], px, py));
}

/** Where the designators of both ends are written, in pixels. */
export function designators(cam, { ends: [a, b], width_m: width }) {
  const dx = b[0] - a[0], dy = b[1] - a[1], length = Math.hypot(dx, dy) || 1;
  const gap = (14 / cam.scale + width / 2) / length;
  return [cam.toScreen(a[0] - dx * gap, a[1] - dy * gap), cam.toScreen(b[0] + dx * gap, b[1] + dy * gap)];
}

function paintStands(g, seen) {
  const { airport, cam, c, box } = seen, r = Math.max(1.2, Math.min(4, 4 * cam.scale));
  g.fillStyle = c.stand;
  g.beginPath();
  for (const stand of airport.stands) {
    const [x, y] = cam.toScreen(...stand.position_m);
    g.moveTo(x + r, y);
    g.arc(x, y, r, 0, 7);
  }
  g.fill();
  if (cam.scale < 0.55) return;
  g.font = "10px B612, sans-serif";
  g.textAlign = "left";
  g.textBaseline = "middle";
  const taken = [];
  for (const stand of airport.stands) {
    const [x, y] = cam.toScreen(...stand.position_m);
    freeText(g, c, box, taken, stand.name.replaceAll("_", " "), x + r + 3, y);
  }
}

/** Names of taxiways once a screenful each, where they do not cover one another. */
function paintNames(g, { airport, cam, c, box }) {
  if (cam.scale < 0.1) return;
  g.font = "700 10px B612, sans-serif";
  g.fillStyle = c["taxi-name"];
  g.textAlign = "center";
  g.textBaseline = "middle";
  const taken = [], last = new Map();
  const ways = airport.taxiways.filter((w) => w.name && w.points_m.length > 1 && w.name.length <= 3);
  const middle = (w) => [(w.points_m[0][0] + w.points_m.at(-1)[0]) / 2, (w.points_m[0][1] + w.points_m.at(-1)[1]) / 2];
  const long = (w) => Math.hypot(w.points_m[0][0] - w.points_m.at(-1)[0], w.points_m[0][1] - w.points_m.at(-1)[1]);
  for (const way of ways.sort((p, q) => long(q) - long(p))) {
    const [x, y] = cam.toScreen(...middle(way));
    const near = (last.get(way.name) ?? []).some(([a, b]) => Math.hypot(a - x, b - y) < 260);
    if (near || !freeText(g, c, box, taken, way.name, x, y, true)) continue;
    last.set(way.name, [...(last.get(way.name) ?? []), [x, y]]);
  }
}

function freeText(g, c, seen, taken, text, x, y, centred = false) {
  if (x > seen.x + seen.w || y > seen.y + seen.h || x < seen.x - 60 || y < seen.y - 14) return false;
  const w = g.measureText(text).width + 4;
  const box = { x: centred ? x - w / 2 : x, y: y - 7, w, h: 14 };
  if (taken.some((t) => t.x < box.x + box.w && box.x < t.x + t.w && t.y < box.y + box.h && box.y < t.y + t.h)) return false;
  taken.push(box);
  if (centred) {
    g.save();
    g.fillStyle = c.pavement;
    g.fillRect(box.x, box.y + 1, box.w, 12);
    g.restore();
  }
  g.fillText(text, x, y);
  return true;
}

function paintSites(g, { airport, cam, c }, layers) {
  for (const s of airport.sensors ?? []) {
    if (!s.position_m) continue;
    const [x, y] = cam.toScreen(...s.position_m);
    if (layers.coverage && s.range_m) {
      g.strokeStyle = c.coverage;
      g.lineWidth = 1;
      g.setLineDash([4, 5]);
      g.beginPath();
      g.arc(x, y, s.range_m * cam.scale, 0, 7);
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

export function paintWeather(g, { weather, cam, c }) {
  for (const [east, north, radius, rate] of weather?.cells ?? []) {
    const [x, y] = cam.toScreen(east, north), r = radius * cam.scale;
    if (![x, y, r].every(Number.isFinite) || r <= 0) continue;
    g.save();
    g.globalAlpha = Math.min(0.26, 0.06 + rate / 400);
    g.fillStyle = c.rain;
    g.beginPath();
    g.arc(x, y, r, 0, 7);
    g.fill();
    g.globalAlpha = 0.8;
    g.strokeStyle = c.rain;
    g.setLineDash([2, 4]);
    g.stroke();
    g.font = "10px B612, sans-serif";
    g.textAlign = "center";
    g.fillText(`${rate.toFixed(0)} mm/h`, x, y - r + 14);
    g.restore();
  }
}

/** Scale bar and north arrow in the lower right corner. */
/** What the scale says and where its line lies. */
function scaleOf(cam) {
  const power = 10 ** Math.floor(Math.log10(110 / cam.scale));
  const metres = [5, 2, 1].map((k) => k * power).find((m) => m <= 110 / cam.scale) ?? power;
  const w = metres * cam.scale;
  return { metres, w, x: cam.width - w - 16, y: cam.height - 14 };
}

/** Boxes of the scale and of the arrow to the north: no label stands there. */
export function scaleBoxes(cam) {
  const { w, x, y } = scaleOf(cam);
  return [{ x: x - 2, y: y - 16, w: w + 4, h: 18 }, { x: cam.width - 42, y: cam.height - 92, w: 36, h: 52 }];
}

export function paintScale(g, cam, c) {
  const { metres, w, x, y } = scaleOf(cam);
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
  g.save();
  g.translate(cam.width - 24, cam.height - 56);
  g.rotate((-cam.rot * Math.PI) / 180);
  g.beginPath();
  g.moveTo(0, -16);
  g.lineTo(5, 0);
  g.lineTo(0, -4);
  g.lineTo(-5, 0);
  g.closePath();
  g.fill();
  g.fillText("N", 0, 12);
  g.restore();
}
