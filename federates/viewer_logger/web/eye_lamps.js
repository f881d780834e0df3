// Lamps that movers wear, by what they do: where on the body, how bright towards an eye, and whether a flash is lit. Pure functions.
// Intensities: navigation and anti-collision lights as 14 CFR 25.1391 and 25.1401 ask at least (effective ones, so that Allard's law holds for
// flashes, too); a vehicle's beacon as ICAO Annex 14, 6.2.2, type C; landing, taxi and head lights as their makers say, roughly.

const RED = [1, 0.15, 0.1], GREEN = [0.2, 1, 0.5], WHITE = [1, 1, 1], WARM = [1, 0.95, 0.85], AMBER = [1, 0.65, 0.1];
/** Seconds of a period, and the parts of it in which a flash is lit. */
const STEADY = null, BEACON = [1, [0, 0.2]], STROBE = [1, [0, 0.08], [0.2, 0.28]], TURNING = [0.8, [0, 0.25]];
/** Faster on a runway is a take-off or a landing; slower than this stands; m/s. */
const ROLLING_MPS = 15, STILL_MPS = 0.5;

/** Towards which bearings off the nose, degrees to the right, a lamp shines: all of its light between the two. Both sides are seen from ahead. */
const sector = (from, to) => (off) => (((off - from) % 360) + 360) % 360 <= to - from ? 1 : 0;
/** A headlight: half of its light `half` degrees off its axis, and a thousandth to where else it is ahead. */
const beam = (half) => (off) => (Math.abs(off) < 90 ? Math.max(2 ** -((off / half) ** 2), 0.001) : 0);
const AROUND = () => 1;

/** The lamps on an aircraft by what it does: { name, at (m: right, ahead, up), cd, colour, towards(degrees), flash }. */
function ofAircraft({ lengthM, spanM }, doing, speed) {
  const l = lengthM || 30, tip = (spanM || 28) / 2 + 0.3, r = Math.min(6.2, Math.max(1.1, 0.104 * l)) / 2, axis = r + Math.min(2.2, 0.045 * l), wing = axis + 0.06 * (spanM || 28) + 0.2;
  if (doing === "parked") return [];
  const lamps = [
    { name: "navigation left", at: [-tip, -0.12 * l, wing], cd: 40, colour: RED, towards: sector(-110, 10), flash: STEADY },
    { name: "navigation right", at: [tip, -0.12 * l, wing], cd: 40, colour: GREEN, towards: sector(-10, 110), flash: STEADY },
    { name: "navigation tail", at: [0, -l / 2 - 0.3, axis], cd: 20, colour: WHITE, towards: sector(110, 250), flash: STEADY },
    { name: "beacon top", at: [0, 0, axis + r + 0.4], cd: 400, colour: RED, towards: AROUND, flash: BEACON },
    { name: "beacon belly", at: [0, 0.02 * l, Math.max(0.4, axis - r - 0.2)], cd: 400, colour: RED, towards: AROUND, flash: BEACON },
  ];
  if (doing === "runway" || doing === "airborne") for (const side of [-1, 1]) lamps.push({ name: `strobe ${side < 0 ? "left" : "right"}`, at: [side * tip, -0.13 * l, wing], cd: 400, colour: WHITE, towards: AROUND, flash: STROBE });
  if (doing === "airborne" || (doing === "runway" && speed > ROLLING_MPS)) for (const side of [-1, 1]) lamps.push({ name: `landing ${side < 0 ? "left" : "right"}`, at: [side * 1.1 * r, 0.16 * l, axis], cd: 200_000, colour: WARM, towards: beam(7), flash: STEADY });
  else if (speed > STILL_MPS) lamps.push({ name: "taxi", at: [0, 0.42 * l, 1.2], cd: 40_000, colour: WARM, towards: beam(15), flash: STEADY });
  return lamps;
}

/** The same on a vehicle, which is as high as it is drawn. */
function ofVehicle({ lengthM, spanM }, doing, speed) {
  const l = Math.max(3, lengthM || 5), w = Math.max(1.6, spanM || 0.4 * l), h = l > 6 ? 2.8 : 1.5;
  if (doing === "parked") return [];
  const lamps = [{ name: "beacon", at: [0, 0, h + 0.35], cd: 200, colour: AMBER, towards: AROUND, flash: TURNING }];
  if (speed > STILL_MPS) for (const side of [-1, 1]) lamps.push({ name: `head ${side < 0 ? "left" : "right"}`, at: [side * (w / 2 - 0.3), l / 2 + 0.1, 0.7], cd: 10_000, colour: WARM, towards: beam(12), flash: STEADY });
  return lamps;
}

/** What a mover does, as far as its lamps go: who stands on a stand has switched them off. */
export function doing(ground, truth) {
  const state = ground.stateOf(truth), still = !(Math.hypot(truth.vx, truth.vy) >= STILL_MPS);
  return truth.aircraft || !still || !ground.atStand(truth.x, truth.y) ? state : "parked";
}

/** Whether a flash is lit at a time of the run; where time stands still, it always is: no lamp is missed in a picture. */
export function lit(flash, timeS, callsign, running) {
  if (!flash || !running) return true;
  let hash = 0;
  for (let i = 0; i < callsign.length; i++) hash = (Math.imul(hash, 31) + callsign.charCodeAt(i)) >>> 0;
  const [period, ...spans] = flash, at = (((timeS + (hash % 97) / 97) % period) + period) % period;
  return spans.some(([from, to]) => at >= from && at < to);
}

/** The lamps of a mover as an eye has them now: { id, at (m: east, north, up), cd (towards the eye), colour }. */
export function worn(ground, truth, place, eye, timeS, running) {
  const heading = Number.isFinite(truth.heading) ? truth.heading : 0, s = Math.sin(heading), c = Math.cos(heading), name = truth.callsign || truth.id;
  const ahead = (truth.vx || 0) * s + (truth.vy || 0) * c, does = doing(ground, truth), of = truth.aircraft ? ofAircraft : ofVehicle;
  // Who is pushed back has its nose dark.
  return of(truth, does, ahead).filter((lamp) => lit(lamp.flash, timeS, name, running)).map((lamp) => {
    const [right, along, up] = lamp.at, at = [place[0] + along * s + right * c, place[1] + along * c - right * s, Math.max(0, place[2]) + up];
    const off = ((((Math.atan2(eye[0] - at[0], eye[1] - at[1]) - heading) * 180) / Math.PI + 540) % 360) - 180;
    return { id: `${name} ${lamp.name}`, at, cd: lamp.cd * lamp.towards(off), colour: lamp.colour };
  }).filter((lamp) => lamp.cd > 0);
}
