// Driving by hand: what keys and gamepad ask for, when it is said, and where a mover is between two messages. No DOM but the gamepads.

import { person } from "./local.js";

/** What each key does: keys of the event, word of the wish, line of the help. */
export const KEYS = [
  [["w", "ArrowUp"], "forward", "W  \u2191", "throttle"],
  [["s", "ArrowDown"], "back", "S  \u2193", "brake, half; standing: backwards (vehicles)"],
  [["a", "ArrowLeft"], "left", "A  \u2190", "wheels to the left"],
  [["d", "ArrowRight"], "right", "D  \u2192", "wheels to the right"],
  [[" "], "brake", "Space", "all of the brake, harder while it is held"],
  [["Shift"], "fine", "Shift", "a third of throttle and wheels"],
];
export const PAD = [["left stick", "wheels"], ["right trigger", "throttle"], ["left trigger", "brake"], ["B, held", "backwards"]];
const FINE = 0.33, DEAD = 0.08, EVERY_MS = 100, AGAIN_MS = 250, MOST_AHEAD_S = 1;

/** The wish of held keys: throttle −1 to 1, brake 0 to 1, steer −1 to 1. */
export function wishOf(held, speed, parked) {
  const share = held.has("fine") ? FINE : 1;
  const wish = { throttle: 0, brake: parked ? 1 : 0, steer: 0 };
  if (held.has("left") !== held.has("right")) wish.steer = held.has("left") ? -share : share;
  if (held.has("brake")) wish.brake = 1;
  else if (held.has("forward")) wish.throttle = share;
  else if (held.has("back") && speed > 0.2) wish.brake = 0.5;
  else if (held.has("back")) wish.throttle = -share;
  if (parked) wish.throttle = 0;
  return wish;
}

/** The wish of a gamepad, or null while nobody touches it. */
export function wishOfPad(pad) {
  if (!pad?.connected) return null;
  const dead = (x) => (Math.abs(x) < DEAD ? 0 : (x - Math.sign(x) * DEAD) / (1 - DEAD)), pressed = (i) => pad.buttons[i]?.value ?? 0;
  const steer = dead(pad.axes[0] ?? 0), throttle = dead(pressed(7)), brake = dead(pressed(6));
  return steer || throttle || brake ? { throttle: pressed(1) > 0.5 ? -throttle : throttle, brake, steer } : null;
}

/** A mover some seconds on, with the wheels and the acceleration that it has: the equations of the core. */
export function reckoned(mover, seconds) {
  const t = Math.max(0, Math.min(MOST_AHEAD_S, seconds)), v = mover.speed_mps, a = mover.acceleration_mps2;
  const stops = v !== 0 && a !== 0 && Math.sign(a) !== Math.sign(v) && Math.abs(v) < Math.abs(a) * t;
  const moved = v === 0 && !a ? 0 : stops ? (v * v) / (2 * Math.abs(a)) * Math.sign(v) : v * t + 0.5 * a * t * t;
  const steer = mover.steer_rad, turn = (moved * Math.sin(steer)) / mover.wheelbase_m, ahead = 0.4 * mover.length_m;
  const to = mover.heading_rad + turn, along = mover.heading_rad + turn / 2 + steer, unit = (h) => [Math.sin(h), Math.cos(h)];
  const at = [0, 1].map((i) => mover.at_m[i] + unit(mover.heading_rad)[i] * ahead + unit(along)[i] * moved - unit(to)[i] * ahead);
  return { ...mover, at_m: at, heading_rad: to, speed_mps: stops ? 0 : v + a * t };
}

/** Which movers people drive, which of them this person has, and what is said for it. */
export class Wheel {
  state = null;
  mine = null;
  held = new Set();
  parked = false;
  #said = "";
  #saidAt = 0;
  #heardAt = 0;
  #had = false;
  flights = [];

  /** `link` carries what is done; `changed()` is called when something else is to be shown; `rate()`: simulated seconds a second. */
  constructor(link, { changed, rate, refused }) {
    Object.assign(this, { link, changed, rate, refused });
    setInterval(() => this.#tell(), EVERY_MS / 2);
  }

  get person() {
    return person();
  }

  take(state) {
    this.state = state;
    if (state?.flights || !state) this.flights = state?.flights ?? [];
    this.#heardAt = performance.now();
    const own = state?.movers.find((m) => m.seat === this.mine);
    this.#had ||= Boolean(own?.taken);
    // A flight goes on by itself at the end of its way, a run ends.
    if (this.mine && this.#had && !own) this.leave();
    this.changed();
  }

  /** The movers as they are now. */
  movers() {
    const age = ((performance.now() - this.#heardAt) / 1000) * this.rate();
    return (this.state?.movers ?? []).map((m) => (m.speed_mps || m.acceleration_mps2 ? reckoned(m, age) : m));
  }

  own() {
    return this.movers().find((m) => m.seat === this.mine) ?? null;
  }

  async sit(seat) {
    if (this.mine) await this.leave();
    const { accepted, text } = await this.#act(seat, "take");
    this.#had = false;
    if (accepted) Object.assign(this, { mine: seat, parked: false });
    else this.refused(text);
    this.changed();
  }

  async leave() {
    const seat = this.mine;
    this.mine = null;
    this.held.clear();
    if (seat) await this.#act(seat, "leave");
    this.changed();
  }

  /** A key goes down or up; whether it is one of the wheel's. */
  key(key, down) {
    const found = KEYS.find(([keys]) => keys.includes(key.length === 1 ? key.toLowerCase() : key));
    if (!found) {
      if (key.toLowerCase() !== "p") return false;
      if (down) this.parked = !this.parked;
      return true;
    }
    if (down) this.held.add(found[1]);
    else this.held.delete(found[1]);
    return true;
  }

  #act(seat, action, more = {}) {
    return this.link.command({ type: "seat", seat, person: this.person, action, ...more });
  }

  /** What is wished: at once where it changes, ten times a second at most, and again before it is too old. */
  #tell() {
    const mover = this.own();
    if (!mover) return;
    const pad = [...(navigator.getGamepads?.() ?? [])].map(wishOfPad).find(Boolean);
    const wish = pad ?? wishOf(this.held, mover.speed_mps, this.parked), now = performance.now();
    const text = [wish.throttle, wish.brake, wish.steer].map((x) => Math.round(1000 * x)).join(" ");
    if (now - this.#saidAt < (text === this.#said ? AGAIN_MS : EVERY_MS)) return;
    this.#said = text;
    this.#saidAt = now;
    const seat = this.mine;
    this.#act(seat, "drive", { clearance: text }).then(({ accepted, text: why }) => {
      if (accepted || this.mine !== seat) return;
      this.refused(why);
      if (/take it first|taken by/.test(why)) this.mine = null;
      this.changed();
    });
  }
}

/** Speed, wheels and what is wrong with a mover of one's own, in words. */
export function wordsOf(m, parked) {
  const degrees = Math.round((m.steer_rad * 180) / Math.PI), warns = warningsOf(m, parked);
  const wheels = degrees ? `wheels ${Math.abs(degrees)}\u00b0 ${degrees < 0 ? "left" : "right"}` : "wheels straight";
  return [`${speedOf(m)}`, wheels, ...warns].join("; ");
}

export function speedOf(m) {
  return `${Math.abs(m.speed_mps * 3.6).toFixed(0)} km/h${m.speed_mps < 0 ? " backwards" : ""}`;
}

export function warningsOf(m, parked) {
  return [
    m.off_pavement && "off the pavement: 11 km/h at most", m.contacts && `touched ${m.contacts} so far`, m.silent && "nothing is heard of you: it brakes", parked && "parking brake",
  ].filter(Boolean);
}

/** Draws what people drive as it is now, one's own with the way of the next three seconds. */
export function paintDriven(g, map, wheel) {
  for (const m of wheel.movers()) {
    const mine = m.seat === wheel.mine, colour = mine ? map.c.select : map.c.vehicle;
    const half = Math.max(0.5 * m.length_m, 6 / map.cam.scale), side = Math.max(0.5 * (m.aircraft ? 0.11 * m.length_m : m.width_m), 3 / map.cam.scale);
    const [sin, cos] = [Math.sin(m.heading_rad), Math.cos(m.heading_rad)];
    const at = (along, across) => map.toScreen(m.at_m[0] + sin * along + cos * across, m.at_m[1] + cos * along - sin * across);
    g.strokeStyle = g.fillStyle = colour;
    g.lineWidth = mine ? 2 : 1;
    g.setLineDash([]);
    g.beginPath();
    for (const [i, p] of [at(half, 0), at(0.4 * half, side), at(-half, side), at(-half, -side), at(0.4 * half, -side)].entries()) i ? g.lineTo(...p) : g.moveTo(...p);
    g.closePath();
    g.stroke();
    if (!mine) continue;
    if (Math.abs(m.speed_mps) > 0.1) {
      g.setLineDash([4, 4]);
      g.lineWidth = 1;
      g.beginPath();
      g.moveTo(...map.toScreen(...m.at_m));
      let on = { ...m, acceleration_mps2: 0 };
      for (let k = 0; k < 12; k++) {
        on = reckoned(on, 0.25);
        g.lineTo(...map.toScreen(...on.at_m));
      }
      g.stroke();
      g.setLineDash([]);
    }
    g.font = "700 12px B612, sans-serif";
    g.textAlign = "left";
    g.textBaseline = "middle";
    const [x, y] = map.toScreen(...m.at_m);
    g.fillText(speedOf(m), x + 14, y + 16); // its label has the name
  }
}
