// One target large, beside its figures.

import { ellipseOf, outline, plotMark, sound } from "./traffic.js";

const sizes = new WeakMap();

/** Measures the canvas whenever its size changes, and never in a drawing: that would lay out the whole page. */
export function watch(canvas, changed) {
  new ResizeObserver(([entry]) => {
    const { inlineSize: w, blockSize: h } = entry.borderBoxSize[0];
    sizes.set(canvas, [w, h]);
    changed();
  }).observe(canvas);
}

/** Draws one target large: truth to scale, track, ellipse, plots and the error between them. */
export function closeUp(canvas, map, target) {
  const [w, h] = (sizes.get(canvas) ?? [0, 0]).map(Math.round), ratio = window.devicePixelRatio || 1;
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
    g.beginPath();
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
