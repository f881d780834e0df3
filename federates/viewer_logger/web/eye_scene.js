// The geometry of the eye's view: plain arrays of vertices out of the airport's map and the targets' dimensions. No DOM here.
// A vertex is nine figures: position (m, x east, y north, z up), normal, colour (share of light given back; normal 0: own luminance).

import { designatorLines } from "./eye_ground.js";
import { runwayRing } from "./situation.js";

export const GRASS = [0.11, 0.16, 0.07], PAVEMENT = [0.2, 0.2, 0.2], RUNWAY = [0.13, 0.13, 0.14], PAINT = [0.75, 0.75, 0.73], YELLOW = [0.7, 0.55, 0.08];
const UP = [0, 0, 1];

export class Mesh {
  constructor() {
    this.data = [];
  }

  get triangles() {
    return this.data.length / 27;
  }

  vertex(p, n, c) {
    this.data.push(p[0], p[1], p[2], n[0], n[1], n[2], c[0], c[1], c[2]);
  }

  /** A triangle with the normal of its winding, or the one given. */
  triangle(a, b, c, colour, normal) {
    const n = normal ?? unit(cross(minus(b, a), minus(c, a)));
    for (const p of [a, b, c]) this.vertex(p, n, colour);
  }

  quad(a, b, c, d, colour, normal) {
    this.triangle(a, b, c, colour, normal);
    this.triangle(a, c, d, colour, normal);
  }

  box([x0, y0, z0], [x1, y1, z1], colour) {
    const p = (x, y, z) => [x ? x1 : x0, y ? y1 : y0, z ? z1 : z0];
    for (const [corners, normal] of [[[[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], [0, 0, 1]], [[[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]], [0, -1, 0]],
      [[[1, 1, 0], [0, 1, 0], [0, 1, 1], [1, 1, 1]], [0, 1, 0]], [[[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]], [1, 0, 0]], [[[0, 1, 0], [0, 0, 0], [0, 0, 1], [0, 1, 1]], [-1, 0, 0]]]) {
      this.quad(...corners.map((c) => p(...c)), colour, normal);
    }
  }

  array() {
    return new Float32Array(this.data);
  }
}

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
function unit(v) {
  const l = Math.hypot(...v) || 1;
  return v.map((x) => x / l);
}

/** Triangles of a simple polygon, as indices: ears cut off one by one. */
export function ears(ring) {
  const area = ring.reduce((s, [x, y], i) => s + x * ring[(i + 1) % ring.length][1] - ring[(i + 1) % ring.length][0] * y, 0);
  const left = ring.map((_, i) => i), out = [], side = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  if (area < 0) left.reverse();
  let tries = 0;
  for (let i = 0; left.length > 3 && tries < 2 * left.length; ) {
    const n = left.length, [a, b, c] = [left[(i + n - 1) % n], left[i % n], left[(i + 1) % n]].map((k) => ring[k]);
    // A ring that touches itself has points on the sides of its ears: where nothing else is left, only points inside are in the way.
    const convex = side(a, b, c) > 0, strict = tries >= n;
    const ear = convex && !left.some((k) => {
      const p = ring[k];
      return p !== a && p !== b && p !== c && [side(a, b, p), side(b, c, p), side(c, a, p)].every((s) => (strict ? s > 0 : s >= 0));
    });
    if (ear || side(a, b, c) === 0) {
      if (ear) out.push(left[(i + n - 1) % n], left[i % n], left[(i + 1) % n]);
      left.splice(i % n, 1);
      i = i % n ? (i % n) - 1 : 0;
      tries = 0;
    } else {
      i = (i + 1) % n;
      tries++;
    }
  }
  if (left.length === 3) out.push(...left);
  return out;
}

/** All that lies flat at height 0, in painter's order. */
export function flats(airport) {
  const mesh = new Mesh(), at = ([x, y]) => [x, y, 0], far = 60_000;
  mesh.quad([-far, -far, 0], [far, -far, 0], [far, far, 0], [-far, far, 0], GRASS, UP);
  const area = (ring, colour) => {
    const index = ears(ring);
    for (let i = 0; i < index.length; i += 3) mesh.triangle(at(ring[index[i]]), at(ring[index[i + 1]]), at(ring[index[i + 2]]), colour, UP);
  };
  const band = (a, b, width, colour) => {
    const l = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (l > 0) area(runwayRing({ ends: [a, b], width_m: width }, 0), colour);
  };
  for (const way of airport.taxiways) for (let i = 1; i < way.points_m.length; i++) band(way.points_m[i - 1], way.points_m[i], 23, PAVEMENT);
  for (const { rings } of airport.pavements) area(rings[0], PAVEMENT);
  for (const way of airport.taxiways) for (let i = 1; i < way.points_m.length; i++) band(way.points_m[i - 1], way.points_m[i], 0.5, YELLOW);
  for (const runway of airport.runways) marked(mesh, area, band, runway);
  for (const { ends_m: [a, b] } of airport.holds ?? []) band(a, b, 1, YELLOW);
  return mesh;
}

/** A runway with its paint: sides, centre line, threshold bars, designators, aiming points. */
function marked(mesh, area, band, runway) {
  area(runwayRing(runway, 0), RUNWAY);
  const [a, b] = runway.ends, l = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1, u = [(b[0] - a[0]) / l, (b[1] - a[1]) / l], w = runway.width_m;
  const p = (along, across) => [a[0] + u[0] * along + u[1] * across, a[1] + u[1] * along - u[0] * across];
  for (const side of [-1, 1]) band(p(0, side * (w / 2 - 1)), p(l, side * (w / 2 - 1)), 0.9, PAINT);
  for (let s = 60; s + 30 < l - 60; s += 50) band(p(s, 0), p(s + 30, 0), 0.9, PAINT);
  for (const end of [0, 1]) {
    const from = (s) => (end ? l - s : s), bars = Math.max(2, Math.floor(w / 7.5));
    for (let k = 0; k < bars; k++) for (const side of [-1, 1]) band(p(from(6), side * (1.8 + 3.6 * k)), p(from(36), side * (1.8 + 3.6 * k)), 1.8, PAINT);
    if (l > 1500) for (const side of [-1, 1]) band(p(from(300), side * 11), p(from(345), side * 11), 6, PAINT);
  }
  if (w >= 18) for (const [from, to] of designatorLines(runway)) band(from, to, 0.9, PAINT);
}

/** What stands: buildings as blocks with flat roofs. Those without a height are 10 m. */
export function solids(airport) {
  const mesh = new Mesh(), wall = [0.42, 0.42, 0.44], roof = [0.3, 0.3, 0.31];
  const known = (airport.blocks ?? []).map((b) => [b.ring, b.height_m]);
  for (const [ring, height] of [...known, ...(known.length ? [] : (airport.buildings ?? []).map((b) => [b.rings[0], 10]))]) {
    const index = ears(ring), top = (k) => [...ring[k], height];
    for (let i = 0; i < index.length; i += 3) mesh.triangle(top(index[i]), top(index[i + 1]), top(index[i + 2]), roof, UP);
    const turned = ring.reduce((s, [x, y], i) => s + x * ring[(i + 1) % ring.length][1] - ring[(i + 1) % ring.length][0] * y, 0) < 0 ? [...ring].reverse() : ring;
    turned.forEach((p, i) => {
      const q = turned[(i + 1) % turned.length];
      mesh.quad([...p, 0], [...q, 0], [...q, height], [...p, height], wall);
    });
  }
  return mesh;
}

/** An aircraft of a length and span: x across, y ahead, z up, middle at the origin, wheels on z = 0. */
export function aircraft(length, span) {
  const mesh = new Mesh(), white = [0.78, 0.78, 0.8], grey = [0.5, 0.52, 0.55], dark = [0.03, 0.04, 0.05], tail = [0.55, 0.1, 0.1];
  const r = Math.min(6.2, Math.max(1.1, 0.104 * length)) / 2, axis = r + Math.min(2.2, 0.045 * length), round = 12;
  const stations = [[0.5, 0.05, -0.35], [0.485, 0.45, -0.2], [0.45, 0.8, -0.06], [0.4, 1, 0], [-0.2, 1, 0], [-0.38, 0.62, 0.25], [-0.5, 0.12, 0.55]];
  const ring = stations.map(([y, k, lift]) => Array.from({ length: round }, (_, i) => {
    const t = (i / round) * 2 * Math.PI;
    return [Math.sin(t) * r * k, y * length, axis + lift * r + Math.cos(t) * r * k];
  }));
  for (let s = 1; s < ring.length; s++) {
    for (let i = 0; i < round; i++) {
      const j = (i + 1) % round, windscreen = s === 2 && (i < 2 || i >= round - 2);
      mesh.quad(ring[s - 1][i], ring[s - 1][j], ring[s][j], ring[s][i], windscreen ? dark : white);
    }
  }
  const both = (draw) => [-1, 1].forEach(draw);
  const plate = (a, b, c, d, colour) => {
    mesh.quad(a, b, c, d, colour, UP);
  };
  both((s) => plate([s * r * 0.7, 0.14 * length, axis - 0.5 * r], [s * r * 0.7, -0.06 * length, axis - 0.5 * r], [(s * span) / 2, -0.17 * length, axis + 0.06 * span], [(s * span) / 2, -0.1 * length, axis + 0.06 * span], grey));
  both((s) => plate([0, -0.38 * length, axis + 0.5 * r], [0, -0.48 * length, axis + 0.5 * r], [s * 0.19 * span, -0.5 * length, axis + 0.6 * r], [s * 0.19 * span, -0.45 * length, axis + 0.6 * r], grey));
  const fin = [[0, -0.33 * length, axis + 0.8 * r], [0, -0.47 * length, axis + 0.6 * r], [0, -0.51 * length, axis + r + 0.17 * length], [0, -0.44 * length, axis + r + 0.17 * length]];
  mesh.quad(...fin, tail, [1, 0, 0]);
  both((s) => mesh.box([s * 0.17 * span - 0.55 * r, -0.02 * length, axis - 1.1 * r], [s * 0.17 * span + 0.55 * r, 0.1 * length, axis - 0.25 * r], grey));
  both((s) => mesh.box([s * 0.9 * r - 0.4, -0.05 * length, 0], [s * 0.9 * r + 0.4, -0.02 * length, axis - 0.6 * r], dark));
  mesh.box([-0.3, 0.38 * length, 0], [0.3, 0.4 * length, axis - 0.8 * r], dark);
  return mesh;
}

/** A vehicle as boxes, with a beacon; fire engines red, follow-me cars yellow. */
export function vehicle(length, width, name) {
  const mesh = new Mesh(), colour = /fire/i.test(name) ? [0.5, 0.04, 0.03] : /follow/i.test(name) ? [0.75, 0.6, 0.05] : [0.6, 0.6, 0.6];
  const l = Math.max(3, length), w = Math.max(1.6, width || 0.4 * l), h = l > 6 ? 2.8 : 1.5;
  mesh.box([-w / 2, -l / 2, 0.35], [w / 2, l / 2, h * 0.55], colour);
  mesh.box([-w / 2 + 0.1, -l * 0.35, h * 0.55], [w / 2 - 0.1, l * (l > 6 ? 0.45 : 0.2), h], l > 6 ? colour : [0.06, 0.07, 0.08]);
  for (const s of [-1, 1]) for (const y of [-0.32, 0.32]) mesh.box([(s * w) / 2 - 0.15, y * l - 0.35, 0], [(s * w) / 2 + 0.15, y * l + 0.35, 0.7], [0.03, 0.03, 0.03]);
  mesh.box([-0.2, -0.2, h], [0.2, 0.2, h + 0.2], [0.9, 0.5, 0.02]);
  return mesh;
}

/** A board as two triangles turned to an eye, with its own luminance. */
export function board(mesh, { centre_m: c, size_m: size, luminance_ratio: ratio }, eye) {
  const to = unit(minus(c, eye)), right = unit(cross(to, UP)), up = cross(right, to), h = size / 2;
  const p = (x, y) => [0, 1, 2].map((i) => c[i] + right[i] * x * h + up[i] * y * h);
  mesh.quad(p(-1, -1), p(1, -1), p(1, 1), p(-1, 1), [ratio, ratio, ratio], [0, 0, 0]);
}
