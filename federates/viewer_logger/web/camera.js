// From metres east and north to pixels and back: centre, pixels a metre, and the bearing that points up. No DOM here.

export const MIN_SCALE = 0.02, MAX_SCALE = 40;

export class Camera {
  constructor(width = 1, height = 1) {
    Object.assign(this, { width, height, cx: 0, cy: 0, scale: 0.2, rot: 0, cos: 1, sin: 0 });
  }

  /** Takes over what is given and finite; says whether anything changed. */
  look({ cx = this.cx, cy = this.cy, scale = this.scale, rot = this.rot }) {
    if (![cx, cy, scale, rot].every(Number.isFinite)) return false;
    const next = { cx, cy, scale: Math.min(MAX_SCALE, Math.max(MIN_SCALE, scale)), rot: ((rot % 360) + 360) % 360 };
    const same = Object.entries(next).every(([k, v]) => this[k] === v);
    Object.assign(this, next);
    this.cos = Math.cos((this.rot * Math.PI) / 180);
    this.sin = Math.sin((this.rot * Math.PI) / 180);
    return !same;
  }

  toScreen(x, y) {
    const dx = (x - this.cx) * this.scale, dy = (y - this.cy) * this.scale;
    return [this.width / 2 + dx * this.cos - dy * this.sin, this.height / 2 - dx * this.sin - dy * this.cos];
  }

  toMetres(px, py) {
    const u = (px - this.width / 2) / this.scale, v = (this.height / 2 - py) / this.scale;
    return [this.cx + u * this.cos + v * this.sin, this.cy - u * this.sin + v * this.cos];
  }

  /** The view that zooms by a factor about a pixel. */
  zoomed(factor, px, py) {
    const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, this.scale * factor)), [x, y] = this.toMetres(px, py);
    const k = this.scale / scale;
    return { scale, cx: x + (this.cx - x) * k, cy: y + (this.cy - y) * k };
  }

  /** The view moved by so many pixels. */
  panned(dx, dy) {
    const [cx, cy] = this.toMetres(this.width / 2 - dx, this.height / 2 - dy);
    return { cx, cy };
  }

  /** The view that shows points whole, with a margin in pixels. */
  fitting(points, margin) {
    if (!points.length) return {};
    const along = points.map(([x, y]) => [x * this.cos - y * this.sin, x * this.sin + y * this.cos]);
    const [us, vs] = [0, 1].map((i) => along.map((p) => p[i]));
    const [u0, u1, v0, v1] = [least(us), -least(us.map((u) => -u)), least(vs), -least(vs.map((v) => -v))];
    const scale = Math.min((this.width - 2 * margin) / Math.max(1, u1 - u0), (this.height - 2 * margin) / Math.max(1, v1 - v0));
    const u = (u0 + u1) / 2, v = (v0 + v1) / 2;
    return { cx: u * this.cos + v * this.sin, cy: -u * this.sin + v * this.cos, scale: Math.max(scale, MIN_SCALE) };
  }

  /** Whether it shows the same picture. */
  same(other) {
    return ["cx", "cy", "scale", "rot", "width", "height"].every((k) => this[k] === other[k]);
  }

  copy() {
    return Object.assign(new Camera(), this);
  }
}

const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
