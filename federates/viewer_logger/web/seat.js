// A person at controllers' seats: what the run says of them, and what can be said to whom. The state is pure; the panel is in
// `panels/seats.js`, what is typed in `meant.js` and `command.js`.

import { nameAs, person } from "./local.js";

/** Kinds of clearances that people can say in a run. */
export const KINDS_SAID = ["PSH", "TAX", "CRO", "LUP", "TOF", "LND", "HLD", "GOA"];
const HERE_MS = 5000, MOST_NAME = 32;

/** Who gives a clearance to a flight that wants something: the seat of its list, else ground or the only tower. */
export function seatFor(state, word, callsign) {
  const asks = state.seats.find((s) => [...s.wants, ...(s.could ?? [])].some((w) => w.callsign === callsign));
  if (word === "PSH") return "apron";
  if (word === "TAX" || word === "HLD") return "ground";
  return asks?.name.startsWith("tower") ? asks.name : state.seats.find((s) => s.name.startsWith("tower"))?.name ?? "ground";
}

/** What can be said to a flight now: [{ seat, clearance, asked }], what it asks for first. */
export function possible(state, callsign) {
  if (!state || !callsign || state.pending.some((p) => p.callsign === callsign)) return [];
  const wants = state.seats.flatMap((s) => s.wants.filter((w) => w.callsign === callsign).map((w) => ({ seat: s.name, clearance: w.clearance, asked: true })));
  const add = (clearance) => ({ seat: seatFor(state, clearance, callsign), clearance, asked: false });
  if (wants.some((w) => w.clearance === "LND")) wants.push(add("GOA"));
  if (state.held.includes(callsign)) wants.push(add("TAX"));
  else if (!wants.some((w) => ["PSH", "LND", "TOF"].includes(w.clearance))) wants.push(add("HLD"));
  return wants;
}

/** The flight of a typed name: all of it, its end where that is one flight's, "." for the selected. */
function flightOf(name, callsigns, selected) {
  if (name === "." && !selected) return { error: "no flight is selected" };
  const found = name === "." ? [selected] : callsigns.filter((c) => c.toUpperCase() === name);
  const ends = found.length ? found : callsigns.filter((c) => c.toUpperCase().endsWith(name));
  if (!ends.length) return { error: `no flight is called ${name}` };
  if (ends.length > 1) return { error: `${name} may be ${ends.slice(0, 4).join(", ")}` };
  return { callsign: ends[0] };
}

const CHANGES = ["HOLD", "STAND", "RUNWAY"];

/** A typed question: "SWR1A HOLD 120", "1A STAND A12", "RUNWAY 28" (the selected) → { callsign, change } or { error }. */
export function question(line, callsigns, selected) {
  const words = line.trim().split(/\s+/).filter(Boolean);
  const upper = words.map((w) => w.toUpperCase());
  if (CHANGES.includes(upper[0])) upper.unshift(".") && words.unshift(".");
  const [name, kind] = upper, value = words.slice(2).join(" ");
  if (!name) return { error: "type a call sign and what is done otherwise, like SWR1A HOLD 120" };
  const { callsign, error } = flightOf(name, callsigns, selected);
  if (error) return { error };
  if (!CHANGES.includes(kind)) return { error: `${name}: what is done otherwise? HOLD and seconds, STAND and its name, RUNWAY and its end` };
  if (!value) return { error: `${kind}: ${kind === "HOLD" ? "how many seconds?" : "which one?"}` };
  return { callsign, change: `${kind} ${value}` };
}

const KINDS = { request: "asks", clearance: "clears", readback: "reads back", correction: "corrects" };

/** What is said on the radio, in words. */
export const saysOf = (m) => `${KINDS[m.kind] ?? m.kind} ${m.clearance}`;

/** The last six messages to and from a flight, the newest first. */
export function radioOf(seats, callsign) {
  const own = (seats?.radio ?? []).filter((m) => m.from === callsign || m.to === callsign);
  return own.slice(-6).reverse().map((m) => ({ ...m, says: saysOf(m) }));
}

/** The seats of the run and this person at them. */
export class Seats {
  state = null;
  answer = null;

  /** `link` carries what is done; `changed()` is called when something else is to be shown. */
  constructor(link, changed) {
    Object.assign(this, { link, changed });
    nameAs(person());
    this.person = person();
    setInterval(() => {
      for (const seat of this.own()) this.link.send({ type: "seat", id: 0, seat, person: this.person, action: "here" });
    }, HERE_MS);
  }

  take(state) {
    this.state = state;
    const mine = state?.answers.filter((a) => a.number && a.person === this.person).at(-1);
    if (mine && mine.number !== this.answer?.number) this.answer = mine;
    this.changed();
  }

  /** Names of the seats that this person has. */
  own() {
    return (this.state?.seats ?? []).filter((s) => s.by === this.person).map((s) => s.name);
  }

  rename(name) {
    const sound = name.replace(/[^A-Za-z0-9._@ -]/g, "").trim().slice(0, MOST_NAME);
    if (!sound || this.own().length) return;
    this.person = sound;
    nameAs(sound);
    this.link.send({ type: "person", person: sound });
  }

  /** What this person can say to a flight now. */
  mine(callsign) {
    const own = this.own();
    return possible(this.state, callsign).filter((p) => own.includes(p.seat));
  }

  async act(seat, action, more = {}) {
    const { accepted, text } = await this.link.command({ type: "seat", seat, person: this.person, action, ...more });
    if (!accepted) this.say(false, text);
    return accepted;
  }

  clear(seat, callsign, clearance) {
    return this.act(seat, "say", { callsign, clearance });
  }

  /** Asks what would be if; "SWR1A HOLD 120", or without a call sign for the selected flight. */
  whatIf(text, callsigns, selected) {
    const asked = question(text, callsigns, selected);
    if (asked.error) {
      this.say(false, asked.error);
      return Promise.resolve(false);
    }
    return this.act(this.own()[0], "what-if", { callsign: asked.callsign, clearance: asked.change });
  }

  say(accepted, text) {
    this.answer = { accepted, text, number: this.answer?.number };
    this.changed();
  }
}
