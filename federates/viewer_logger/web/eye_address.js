// What the address of the eye asks for: from where one looks, and which run at which time. No DOM here.

import { otherFirst } from "./runs.js";

const EYES = ["tower", "pilot", "driver", "free"];

/** From where one looks and out of what, as the address has it (`pilot:SWR1`); null for what is none. */
export function eyeOf(text) {
  try {
    const [eye, of] = decodeURIComponent(text ?? "").split(/:(.*)/s);
    return EYES.includes(eye) ? [eye, of || null] : null;
  } catch {
    return null; // %zz, or cut off
  }
}

/** Out of what one looks: who was named stays, there or not; else the first that is there. */
export function outOf(of, there, named) {
  return (named && of) || there.includes(of) || !there.length ? of : there[0];
}

/** Why the picture is not that of now, in words; empty where it is. */
export function troubleOf({ link, refused, unreadable }) {
  if (link === "lost" || link === "silent") return "no word from the viewer: the picture stands";
  if (refused) return refused;
  return unreadable ? "what comes cannot be read: this page is of another version, load it again" : "";
}

/** Run and time that are asked of the server: again where it is another connection, run or address. */
export class Asks {
  #opened = null;
  #shown = [];
  #line = null;

  /** `send(message)`: whether it was sent. */
  constructor(send) {
    this.send = send;
    this.wish = {};
  }

  /** { t, run } of the address. */
  want(wish) {
    this.wish = wish;
    this.#ask();
  }

  /** A connection is there: whoever is at its other end knows nothing of what was asked before. */
  hello() {
    this.#opened = null;
    this.#ask();
  }

  /** What was asked for last is not there: the same address asks anew. */
  refused() {
    this.#opened = null;
  }

  /** These runs are shown: the time line of another first one is still to come. */
  runs(shown) {
    if (otherFirst(this.#shown, shown)) this.#line = null;
    this.#shown = shown;
  }

  timeline(line) {
    const first = !this.#line;
    this.#line = line;
    if (first) this.#ask();
  }

  #ask() {
    const { t, run } = this.wish, line = this.#line, name = run?.join();
    if (run && this.#opened !== name && this.send({ type: "open", runs: run })) this.#opened = name;
    if (!line || t === undefined) return;
    const share = line.last_s > line.first_s ? (Math.min(line.last_s, Math.max(line.first_s, t)) - line.first_s) / (line.last_s - line.first_s) : 0;
    this.send({ type: "show", scan: t === "live" ? null : Math.floor(line.first + share * (line.last - line.first) + 1e-6) });
  }
}
