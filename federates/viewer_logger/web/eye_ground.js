// Lamps of the ground: runways, taxiways, approach slopes, stop bars and runway status lights. Pure functions; intensities as ICAO Annex 14 asks,
// roughly; at night a twentieth. A lamp with `aim` ([east, north], of length 1) shines to that side alone; a lamp without around.

const WHITE = [1, 0.95, 0.85], GREEN = [0.2, 1, 0.5], RED = [1, 0.15, 0.1], BLUE = [0.3, 0.5, 1];
/** A slope is seen white from above these elevations, degrees, red from below; the lamp next to the runway first. */
const PAPI_DEG = [3.5, 3 + 1 / 6, 3 - 1 / 6, 2.5];
/** Where the slope's lamps stand: beyond the threshold, and from the edge of the runway to the first and from lamp to lamp, m. */
const PAPI_M = [300, 15, 9];
/** From lamp to lamp of a bar across a taxiway, m. */
const BAR_M = 3;
const dimmed = (night) => (night ? 0.05 : 1);

/** Ends of a runway as who lands there has them: where, the direction of landing, and the place so far along and to the right. */
function endsOf({ designators, ends: [a, b], width_m: width }) {
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1, u = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
  return [[a, u], [b, [-u[0], -u[1]]]].map(([from, d], i) => ({
    name: designators[i], length, width, along: d,
    at: (far, right, up = 0.3) => [from[0] + d[0] * far + d[1] * right, from[1] + d[1] * far - d[0] * right, up],
  }));
}

/** Lamps that do not change: { id, at, cd, colour, aim }. */
export function fixed(airport, night) {
  const out = [], step = dimmed(night);
  for (const runway of airport.runways) {
    const [first, second] = endsOf(runway), { length, width, at } = first, name = runway.designators.join("/"), n = Math.max(1, Math.round(length / 60));
    for (let k = 0; k <= n; k++) for (const s of [-1, 1]) out.push({ id: `${name} edge ${k}${s < 0 ? "L" : "R"}`, at: at((k * length) / n, s * (width / 2 + 1.5)), cd: 10_000 * step, colour: WHITE });
    for (let s = 15; s < length; s += 30) out.push({ id: `${name} centre ${s}`, at: at(s, 0), cd: 5_000 * step, colour: WHITE });
    // Green to who comes to land, red to who runs towards the end.
    for (const end of [first, second]) {
      const out_ = end.along.map((v) => -v);
      for (let x = -width / 2; x <= width / 2; x += 3) {
        out.push({ id: `${end.name} threshold ${x.toFixed(0)}`, at: end.at(-2, x), cd: 5_000 * step, colour: GREEN, aim: out_ });
        out.push({ id: `${end.name} end ${x.toFixed(0)}`, at: end.at(-2, x), cd: 2_500 * step, colour: RED, aim: end.along });
      }
    }
  }
  for (const [k, way] of airport.taxiways.entries()) {
    const [a, b] = [way.points_m[0], way.points_m.at(-1)], l = Math.hypot(b[0] - a[0], b[1] - a[1]);
    for (let s = 15; s < l; s += 30) out.push({ id: `taxi ${way.name || k} ${s}`, at: [a[0] + ((b[0] - a[0]) * s) / l, a[1] + ((b[1] - a[1]) * s) / l, 0.1], cd: 200 * step, colour: night ? GREEN : BLUE });
  }
  return out;
}

/** Lamps across a line from place to place. */
function across(id, [a, b], cd, colour) {
  const n = Math.max(1, Math.round(Math.hypot(b[0] - a[0], b[1] - a[1]) / BAR_M));
  return Array.from({ length: n + 1 }, (_, k) => ({ id: `${id} ${k}`, at: [a[0] + ((b[0] - a[0]) * k) / n, a[1] + ((b[1] - a[1]) * k) / n, 0.1], cd, colour }));
}

/** Lamps as they are switched now: stop bars that are lit, entry and take-off hold lights that are lit. `lights` as the map has them. */
export function switched(lights, night) {
  const step = dimmed(night), bars = (lights?.bars ?? []).filter((bar) => bar.lit), status = [...(lights?.entries ?? []), ...(lights?.holds ?? [])].filter((l) => l.lit);
  return [...bars.flatMap((bar, i) => across(`bar ${bar.id ?? i}`, bar.ends_m, 1_000 * step, RED)), ...status.flatMap((l, i) => across(`status ${l.id ?? i}`, l.ends_m, 1_000 * step, RED))];
}

/** Approach slopes of runways of 1 200 m and more, left of the runway, as they show to an eye that is in front of them. */
export function slopes(airport, eye, night) {
  return airport.runways.flatMap(endsOf).filter((end) => end.length >= 1200).flatMap((end) => PAPI_DEG.map((deg, i) => {
    const at = end.at(PAPI_M[0], -(end.width / 2 + PAPI_M[1] + i * PAPI_M[2]), 1);
    const [dx, dy, dz] = at.map((v, k) => eye[k] - v), elevation = (Math.atan2(dz, Math.hypot(dx, dy)) * 180) / Math.PI;
    return { id: `${end.name} slope ${i + 1}`, at, cd: 15_000 * dimmed(night), colour: elevation > deg ? WHITE : RED, aim: end.along.map((v) => -v) };
  }));
}

/** Whether a lamp shines towards an eye. */
export const faces = ({ at, aim }, eye) => !aim || aim[0] * (eye[0] - at[0]) + aim[1] * (eye[1] - at[1]) > 0;

/** Bars of the digits and letters of a runway's designator: from and to in widths right and heights along, as who lands reads them. */
const SEGMENTS = { A: [0, 1, 1, 1], B: [1, 1, 1, 0.5], C: [1, 0.5, 1, 0], D: [0, 0, 1, 0], E: [0, 0.5, 0, 0], F: [0, 1, 0, 0.5], G: [0, 0.5, 1, 0.5], K: [0.4, 0.5, 1, 0] };
const SIGNS = { 0: "ABCDEF", 1: "BC", 2: "ABGED", 3: "ABGCD", 4: "FGBC", 5: "AFGCD", 6: "AFGECD", 7: "ABC", 8: "ABCDEFG", 9: "ABCDFG", L: "FED", C: "AFED", R: "EFABGK" };
/** A sign is so wide and high, its first row so far beyond the threshold, and the rows and signs so far apart, m. */
const SIGN_M = [3, 9], ROW_M = 42, APART_M = 3;

/** The designators painted on a runway as lines: [from, to], m; a letter stands nearer to the threshold than the number. */
export function designatorLines(runway) {
  return endsOf(runway).flatMap((end) => {
    const rows = [end.name.match(/[LCR]$/)?.[0] ?? "", end.name.match(/^\d{1,2}/)?.[0] ?? ""].filter(Boolean);
    return rows.flatMap((text, row) => [...text].flatMap((sign, k) => {
      const left = (k - (text.length - 1) / 2) * (SIGN_M[0] + APART_M) - SIGN_M[0] / 2, near = ROW_M + row * (SIGN_M[1] + 2 * APART_M);
      const at = (x, y) => end.at(near + y * SIGN_M[1], left + x * SIGN_M[0]).slice(0, 2);
      return [...(SIGNS[sign] ?? "")].map((s) => SEGMENTS[s]).map(([x0, y0, x1, y1]) => [at(x0, y0), at(x1, y1)]);
    }));
  });
}
