// Error over cost: what no other choice beats, what a budget allows, and the picture of both.

import { fixed } from "./text.js";

const known = (rows, of) => rows.filter((r) => Number.isFinite(of.error(r)) && Number.isFinite(of.cost(r)));

/** The row of least error within a budget of `cost`, or the cheapest within `error`; null where none is. `of` reads both from a row. */
export function best(rows, of, { cost = null, error = null }) {
  const least = (list, key) => list.reduce((found, r) => (found === null || key(r) < key(found) ? r : found), null);
  if (cost !== null) return least(known(rows, of).filter((r) => of.cost(r) <= cost), of.error);
  if (error !== null) return least(known(rows, of).filter((r) => of.error(r) <= error), of.cost);
  return null;
}

/** Rows that no other row beats in both, by cost. */
export function front(rows, of) {
  const all = known(rows, of);
  return all.filter((r) => !all.some((o) => o !== r && of.cost(o) <= of.cost(r) && of.error(o) < of.error(r))).sort((a, b) => of.cost(a) - of.cost(b));
}

const OF = { cost: (p) => p.cost, error: (p) => p.error };

/** Cost across, error (m) up, both logarithmic; `points` have name, cost, error, own, ghost. The front is drawn. */
export function scatter(canvas, points, unit) {
  const rows = points.filter((p) => p.error > 0 && p.cost > 0), ratio = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
  if (!w || !h) return;
  Object.assign(canvas, { width: Math.round(w * ratio), height: Math.round(h * ratio) });
  const g = canvas.getContext("2d"), style = getComputedStyle(canvas), c = (n) => style.getPropertyValue(`--${n}`).trim();
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  if (rows.length < 2) return;
  const ends = (list) => [Math.min(...list) / 1.15, Math.max(...list) * 1.15], [x0, x1] = ends(rows.map(OF.cost)), [y0, y1] = ends(rows.map(OF.error));
  const X = (v) => 34 + (Math.log(v / x0) / Math.log(x1 / x0)) * (w - 84), Y = (v) => h - 18 - (Math.log(v / y0) / Math.log(y1 / y0)) * (h - 28);
  const short = (v) => fixed(v, v < 100 ? 2 : 0);
  g.font = "10px B612, sans-serif";
  g.fillStyle = g.strokeStyle = c("dim");
  g.beginPath();
  g.moveTo(34, 4);
  g.lineTo(34, h - 18);
  g.lineTo(w - 4, h - 18);
  g.stroke();
  g.fillText(`${fixed(y1 / 1.15, 1)} m`, 0, 12);
  g.fillText(`${fixed(y0 * 1.15, 1)} m`, 0, h - 20);
  g.fillText(`${short(x0 * 1.15)} ${unit}`, 34, h - 5);
  g.fillText(`${short(x1 / 1.15)} ${unit}`, w - 54, h - 5);
  g.strokeStyle = c("good");
  g.beginPath();
  front(rows, OF).forEach((r, i) => (i ? g.lineTo(X(r.cost), Y(r.error)) : g.moveTo(X(r.cost), Y(r.error))));
  g.stroke();
  // Names where they have room: the run's own and the ghost's first.
  const taken = [], first = [...rows].sort((a, b) => Number(Boolean(b.own)) - Number(Boolean(a.own)) || Number(Boolean(b.ghost)) - Number(Boolean(a.ghost)));
  for (const r of first) {
    g.beginPath();
    g.arc(X(r.cost), Y(r.error), r.own ? 4.5 : 3, 0, 7);
    g.fillStyle = r.own ? c("strong") : r.ghost ? c("departure") : c("dim");
    g.fill();
    const width = g.measureText(r.name).width, y = Y(r.error) + 3, right = X(r.cost) + 6, x = right + width > w ? X(r.cost) - 6 - width : right;
    if (taken.some((t) => x < t.x + t.width + 2 && t.x < x + width + 2 && Math.abs(t.y - y) < 10)) continue;
    taken.push({ x, y, width });
    g.fillText(r.name, x, y);
  }
}
