// The camera of the eye and what it sees by identifier. Pure functions; x east, y north, z up, metres.

const rad = (degrees) => (degrees * Math.PI) / 180;

/** Directions of a look (bearing and elevation, degrees): ahead, right, up. */
export function axes([bearing, elevation]) {
  const [sb, cb, se, ce] = [Math.sin(rad(bearing)), Math.cos(rad(bearing)), Math.sin(rad(elevation)), Math.cos(rad(elevation))];
  return { ahead: [sb * ce, cb * ce, se], right: [cb, -sb, 0], up: [-sb * se, -cb * se, ce] };
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** A point in the camera: across and up in half widths and half heights of the picture (−1 to 1 inside), ahead in metres. */
export function project(point, eye, look, fovDeg, aspect) {
  const to = [point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]], { ahead, right, up } = axes(look);
  const z = dot(to, ahead), t = Math.tan(rad(fovDeg) / 2);
  return { x: dot(to, right) / (z * t * aspect), y: dot(to, up) / (z * t), ahead: z, distance: Math.hypot(...to) };
}

/** Whether a building stands between two points: somewhere over its footprint the line is below its top. */
export function hidden(from, to, { ring, height_m: height }) {
  const dx = to[0] - from[0], dy = to[1] - from[1], dz = to[2] - from[2], cuts = [];
  for (let i = 0; i < ring.length; i++) {
    const [ax, ay] = ring[i], [bx, by] = ring[(i + 1) % ring.length], ex = bx - ax, ey = by - ay, den = dx * ey - dy * ex;
    if (Math.abs(den) < 1e-12) continue;
    const t = ((ax - from[0]) * ey - (ay - from[1]) * ex) / den, s = ((ax - from[0]) * dy - (ay - from[1]) * dx) / den;
    if (t > 0 && t < 1 && s >= 0 && s <= 1) cuts.push(t);
  }
  if (!cuts.length) return false;
  return Math.min(...[Math.min(...cuts), Math.max(...cuts)].map((t) => from[2] + t * dz)) < height;
}

/** Identifiers of the targets whose middle is in the picture, nearer than the range of sight, and not behind a building. */
export function seen({ eye, look, fov, aspect, sight }, targets, blocks = []) {
  return targets.filter((t) => {
    const p = project(t.at, eye, look, fov, aspect);
    return p.ahead > 0 && Math.abs(p.x) <= 1 && Math.abs(p.y) <= 1 && p.distance < (typeof sight === "function" ? sight(t.at) : sight) && !blocks.some((b) => hidden(eye, t.at, b));
  }).map((t) => t.id);
}

/** The matrix of projection times view, columns first, as WebGL takes it; x east, y north, z up in. */
export function matrix(eye, look, fovDeg, aspect, near = 0.5, far = 40_000) {
  const { ahead, right, up } = axes(look), t = 1 / Math.tan(rad(fovDeg) / 2);
  const rows = [
    [...right.map((v) => (v * t) / aspect), (-dot(right, eye) * t) / aspect],
    [...up.map((v) => v * t), -dot(up, eye) * t],
    [...ahead.map((v) => (v * (far + near)) / (far - near)), (-dot(ahead, eye) * (far + near) - 2 * far * near) / (far - near)],
    [...ahead, -dot(ahead, eye)],
  ];
  return new Float32Array([0, 1, 2, 3].flatMap((c) => rows.map((r) => r[c])));
}

/** Where a truth stands `dt` seconds after its scan. */
export function reckoned(truth, dt) {
  return [truth.x + (truth.vx || 0) * dt, truth.y + (truth.vy || 0) * dt, truth.altitudeM ?? 0];
}

/** Height of the eye and its distance behind the nose, m, by type. */
const COCKPITS = { A320: [4.8, 2], A319: [4.8, 2], A321: [4.8, 2], B738: [4.6, 2.2], B77W: [5.9, 2.3], A388: [7.2, 2.4], E190: [4.2, 1.8], AT75: [3, 1.6], C172: [1.6, 2.3] };

/** Eye and look of somebody aboard. */
export function aboard(truth, dt, role) {
  const [x, y, z] = reckoned(truth, dt), length = truth.lengthM || 10, heading = Number.isFinite(truth.heading) ? truth.heading : 0;
  const guess = [Math.min(7, Math.max(1.5, 0.13 * length)), 0.06 * length];
  const [height, behind] = role === "driver" ? [length > 6 ? 2.8 : 1.6, 0.4 * length] : COCKPITS[truth.designator] ?? guess;
  const ahead = length / 2 - behind;
  return { eye: [x + Math.sin(heading) * ahead, y + Math.cos(heading) * ahead, Math.max(0, z) + height], look: [(heading * 180) / Math.PI, 0] };
}

/** The bearing, degrees, in which a picture `width` degrees wide holds the most of some places as seen from `eye`; nearer ones count more. */
export function outlook(eye, places, width) {
  const all = places.map(([x, y]) => ({ bearing: (Math.atan2(x - eye[0], y - eye[1]) * 180) / Math.PI, weight: 1 / (1 + Math.hypot(x - eye[0], y - eye[1]) / 1000) })).filter((p) => Number.isFinite(p.bearing));
  const apart = (a, b) => ((a - b + 540) % 360) - 180;
  let best = 0, most = -1;
  for (const { bearing: from } of all) {
    // The picture begins a little left of somebody, and has its middle where those within lie.
    const within = all.filter((p) => apart(p.bearing, from) >= 0 && apart(p.bearing, from) <= 0.9 * width), weight = within.reduce((s, p) => s + p.weight, 0);
    if (weight <= most) continue;
    most = weight;
    best = from + Math.max(...within.map((p) => apart(p.bearing, from))) / 2;
  }
  return ((best % 360) + 360) % 360;
}
