// What a target is doing, by map and speed: what decides how much its label says. No DOM here.

/** Levels of detail by state, for a controller's position. */
export const LEVELS = { parked: 0, standing: 1, holding: 2, taxiing: 2, runway: 3, airborne: 2, vehicle: 1, "vehicle on a runway": 2 };
/** Below it a target stands, m/s. */
export const STILL_MPS = 0.5;
const STAND_M = 45, AIRBORNE_M = 15, CELL_M = 100;

/** Runways as polygons and stands by place, made once an airport. */
export class Ground {
  constructor(airport) {
    this.runways = (airport?.runways ?? []).map((r) => ({ names: r.designators, ring: runwayRing(r, 0), runway: r }));
    this.stands = new Map();
    for (const { position_m: [x, y] } of airport?.stands ?? []) {
      const key = `${Math.floor(x / CELL_M)},${Math.floor(y / CELL_M)}`;
      this.stands.set(key, [...(this.stands.get(key) ?? []), [x, y]]);
    }
  }

  /** The runway that a point is on, or so many metres beside, or null. */
  runwayAt(x, y, beside = 0) {
    return this.runways.find(({ ring, runway }) => inside(beside ? runwayRing(runway, beside) : ring, x, y)) ?? null;
  }

  atStand(x, y) {
    const i = Math.floor(x / CELL_M), j = Math.floor(y / CELL_M);
    for (let a = i - 1; a <= i + 1; a++) {
      for (let b = j - 1; b <= j + 1; b++) {
        if ((this.stands.get(`${a},${b}`) ?? []).some(([sx, sy]) => Math.hypot(sx - x, sy - y) <= STAND_M)) return true;
      }
    }
    return false;
  }

  stateOf(target) {
    const speed = Math.hypot(target.vx, target.vy) || 0, still = speed < STILL_MPS;
    const vehicle = target.type === "vehicle" || target.movement === "vehicle" || target.aircraft === false;
    if (target.altitudeM > AIRBORNE_M) return "airborne";
    const runway = this.runwayAt(target.x, target.y);
    if (vehicle) return runway ? "vehicle on a runway" : "vehicle";
    if (runway) return "runway";
    if (!still) return "taxiing";
    return this.atStand(target.x, target.y) ? "parked" : "holding";
  }
}

/** A runway's outline, `more` metres larger on every side. */
export function runwayRing({ ends: [a, b], width_m: width }, more) {
  const dx = b[0] - a[0], dy = b[1] - a[1], length = Math.hypot(dx, dy) || 1;
  const ux = dx / length, uy = dy / length, half = width / 2 + more;
  const corner = (end, along, side) => [end[0] + ux * along - uy * half * side, end[1] + uy * along + ux * half * side];
  return [corner(a, -more, 1), corner(b, more, 1), corner(b, more, -1), corner(a, -more, -1)];
}

function inside(ring, x, y) {
  let sign = 0;
  for (let i = 0; i < ring.length; i++) {
    const [ax, ay] = ring[i], [bx, by] = ring[(i + 1) % ring.length], side = Math.sign((bx - ax) * (y - ay) - (by - ay) * (x - ax));
    if (side && sign && side !== sign) return false;
    sign ||= side;
  }
  return sign !== 0;
}

/** How important a target's label is: alert > selected > runway > final > moving > standing > parked. */
export function importanceOf(target, state, { selected = false, alert = false } = {}) {
  if (alert) return 1000;
  if (selected) return 900;
  const speed = Math.min(90, Math.hypot(target.vx, target.vy) || 0) / 100;
  const rank = { runway: 700, "vehicle on a runway": 700, airborne: 600, taxiing: 400, holding: 300, vehicle: speed > 0.005 ? 350 : 150, parked: 100 };
  return (rank[state] ?? 200) + speed + (target.number === undefined ? -50 : 0);
}

/** Points that are seen when the whole airport is. */
export function pointsOf(airport) {
  const points = [
    ...airport.runways.flatMap((r) => r.ends), ...airport.taxiways.flatMap((t) => t.points_m),
    ...airport.stands.map((s) => s.position_m), ...airport.pavements.flatMap((p) => p.rings.flat()),
  ].filter(([x, y]) => Number.isFinite(x + y));
  return points.length ? points : [[-1000, -1000], [1000, 1000]];
}
