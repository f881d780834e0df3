// The time line: heat of errors, events, ticks, loop and thumb on a canvas behind the slider that people and screen readers move.

import { element, elapsed, fixed } from "./text.js";

const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200];
const INSET = 8; // half the slider's thumb
/** Error of surface movement surveillance that is required, m. */
const REQUIRED_M = 7.5;
/** Mark of each kind of event, its place in the row and its name. */
export const EVENT_KINDS = [
  ["alert", "\u25bc", "alerts"], ["operator", "\u25c6", "operator"], ["weather", "\u25cf", "weather"], ["lost", "\u2715", "tracks lost"],
  ["swap", "\u21c4", "swaps"], ["clearance", "\u25b2", "clearances"], ["fork", "\u2442", "forks"], ["fault", "!", "faults"],
];
const MARKS = new Map(EVENT_KINDS.map(([kind, mark]) => [kind, mark]));

/** Seconds between the labels of a line of so many pixels: none nearer than `apart`. */
export function tickStep(fromS, toS, width, apart = 70) {
  return STEPS_S.find((s) => (s / Math.max(1e-9, toS - fromS)) * width >= apart) ?? STEPS_S.at(-1);
}

/** Seconds of a time as typed: `215`, `3:35`, `1:02:03`, or UTC `09:03:35Z` of a run that began at `startS` of its day; null for no time. */
export function typedTime(text, startS = 0) {
  const word = text.trim().toUpperCase(), utc = word.endsWith("Z"), parts = word.replace(/Z$/, "").split(":");
  if (parts.length > 3 || !parts.every((p, i) => /^\d+(\.\d+)?$/.test(p) && (i === parts.length - 1 || /^\d+$/.test(p)))) return null;
  if (parts.slice(1).some((p) => Number(p) >= 60)) return null;
  const seconds = parts.reduce((sum, p) => sum * 60 + Number(p), 0);
  if (!utc) return seconds;
  if (parts.length !== 3 || seconds >= 86_400) return null;
  return (((seconds - startS) % 86_400) + 86_400) % 86_400;
}

/** The next event of the kinds wanted after (or before) a time, or null. */
export function nextEvent(events, timeS, step, wanted) {
  const list = events.filter((e) => wanted.has(e.kind)).map((e) => e.time_ns / 1e9);
  const found = step > 0 ? list.filter((t) => t > timeS + 1e-6) : list.filter((t) => t < timeS - 1e-6);
  return found.length ? (step > 0 ? Math.min(...found) : Math.max(...found)) : null;
}

/** How much of an error the strip shows, 0 to 1: half of it at the requirement; null where there is none. */
export function heat(metres, requiredM = REQUIRED_M) {
  return Number.isFinite(metres ?? NaN) ? Math.min(1, Math.max(0, metres) / (2 * requiredM)) : null;
}

/** A colour between two (#rrggbb), by a part of the way. */
export function between(low, high, part) {
  const read = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16)), [a, b] = [read(low), read(high)];
  return `#${a.map((v, i) => Math.round(v + (b[i] - v) * part).toString(16).padStart(2, "0")).join("")}`;
}

export class TimeLine {
  constructor(canvas, slider, filter) {
    Object.assign(this, { canvas, slider, firstS: 0, lastS: 1, timeS: null, strip: null, events: [], more: 0, loop: null, notices: [], judged: true });
    this.wanted = new Set(EVENT_KINDS.map(([kind]) => kind));
    new ResizeObserver(() => this.draw()).observe(canvas.parentElement);
    slider.addEventListener("pointermove", (event) => (slider.title = this.textAt(this.timeAt(event.offsetX))));
    filter?.append(...EVENT_KINDS.map(([kind, mark, title]) => {
      const box = element("input", [], { type: "checkbox", id: `event-${kind}` });
      box.checked = true;
      box.addEventListener("change", () => {
        if (box.checked) this.wanted.add(kind);
        else this.wanted.delete(kind);
        this.draw();
      });
      return element("label", [box, `${mark} ${title}`], { for: box.id });
    }));
  }

  get width() {
    return Math.max(1, this.canvas.clientWidth);
  }

  x(timeS) {
    return INSET + ((timeS - this.firstS) / Math.max(1e-9, this.lastS - this.firstS)) * (this.width - 2 * INSET);
  }

  timeAt(x) {
    return this.firstS + ((x - INSET) / Math.max(1, this.width - 2 * INSET)) * (this.lastS - this.firstS);
  }

  show(changes) {
    Object.assign(this, changes);
    this.draw();
  }

  /** What is to be said of a moment. */
  textAt(timeS) {
    const near = 4 * ((this.lastS - this.firstS) / this.width);
    const told = this.events.filter((e) => this.#shown(e) && Math.abs(e.time_ns / 1e9 - timeS) <= near).slice(0, 6).map((e) => `${MARKS.get(e.kind) ?? ""} ${e.text}`);
    const { strip } = this, at = strip ? Math.floor(((timeS - strip.from_s) / (strip.to_s - strip.from_s)) * strip.worst_m.length) : -1;
    const worst = this.judged ? strip?.worst_m[at] : undefined;
    return [elapsed(Math.max(0, timeS)), Number.isFinite(worst) ? `worst error ${fixed(worst, 1)} m` : "", ...told, this.more ? `${this.more} events of this run are not marked: alerts, faults, operators and the newest are` : ""].filter(Boolean).join("\n");
  }

  /** Who judges a run sees which labels were swapped; who works in it does not. */
  #shown(event) {
    return this.wanted.has(event.kind) && (this.judged || event.kind !== "swap");
  }

  draw() {
    const ratio = window.devicePixelRatio || 1, w = this.width, h = this.canvas.clientHeight || 56, g = this.canvas.getContext("2d");
    if (this.canvas.width !== Math.round(w * ratio) || this.canvas.height !== Math.round(h * ratio)) {
      Object.assign(this.canvas, { width: Math.round(w * ratio), height: Math.round(h * ratio) });
    }
    const style = getComputedStyle(this.canvas), c = (name) => style.getPropertyValue(`--${name}`).trim();
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, w, h);
    this.#weather(g, c, h);
    this.#heat(g, c);
    this.#ticks(g, c, h);
    this.#marks(g, c);
    if (this.loop) {
      const [a, b] = this.loop.map((t) => this.x(t));
      g.fillStyle = c("select");
      g.globalAlpha = 0.15;
      g.fillRect(a, 0, Math.max(1, b - a), h);
      g.globalAlpha = 1;
      g.fillRect(a - 1, 0, 2, h);
      g.fillRect(b - 1, 0, 2, h);
    }
    if (Number.isFinite(this.timeS)) {
      const x = this.x(this.timeS);
      g.fillStyle = c("strong");
      g.fillRect(x - 1, 0, 2, h);
      g.beginPath();
      g.moveTo(x - 5, h);
      g.lineTo(x + 5, h);
      g.lineTo(x, h - 7);
      g.fill();
    }
  }

  #weather(g, c, h) {
    const wet = this.notices.filter((n) => n.rain_mm_per_h > 0 || (n.visibility_m ?? Infinity) < 1500);
    g.fillStyle = c("rain");
    g.globalAlpha = 0.14;
    for (const notice of wet) {
      const next = this.notices.find((n) => n.from_ns > notice.from_ns);
      const from = this.x(Math.max(this.firstS, notice.from_ns / 1e9)), to = this.x(Math.min(this.lastS, next ? next.from_ns / 1e9 : this.lastS));
      if (to > from) g.fillRect(from, 0, to - from, h);
    }
    g.globalAlpha = 1;
  }

  #heat(g, c) {
    const { strip } = this;
    g.fillStyle = c("line");
    g.fillRect(INSET, 2, this.width - 2 * INSET, 8);
    if (!strip || !this.judged) return;
    const n = strip.worst_m.length, span = (strip.to_s - strip.from_s) / n;
    const low = c("heat-low"), high = c("heat-high");
    for (let i = 0; i < n; i++) {
      const x = this.x(strip.from_s + i * span), w = Math.max(1, this.x(strip.from_s + (i + 1) * span) - x + 0.5), part = heat(strip.worst_m[i]);
      // The more, the higher and the stronger the colour: neither says it alone.
      if (part !== null) {
        g.fillStyle = between(low, high, part);
        g.fillRect(x, 8 - 6 * part, w, 2 + 6 * part);
      }
      const bad = strip.untracked[i] + strip.false_tracks[i] + strip.wrong_labels[i];
      if (bad) {
        g.fillStyle = c("strong");
        g.globalAlpha = Math.min(1, 0.35 + 0.2 * bad);
        g.fillRect(x, 12, w, 3);
        g.globalAlpha = 1;
      }
    }
    // The requirement, as a notch at both ends.
    g.fillStyle = c("strong");
    for (const x of [0, this.width - INSET]) g.fillRect(x, 5, INSET - 1, 1);
  }

  #ticks(g, c, h) {
    const step = tickStep(this.firstS, this.lastS, this.width - 2 * INSET);
    g.font = "10px B612, sans-serif";
    g.textAlign = "center";
    g.textBaseline = "alphabetic";
    g.strokeStyle = c("dim");
    g.fillStyle = c("dim");
    g.lineWidth = 1;
    g.beginPath();
    for (let t = Math.ceil(this.firstS / step) * step; t <= this.lastS + 1e-9; t += step) {
      const x = Math.round(this.x(t)) + 0.5;
      g.moveTo(x, 34);
      g.lineTo(x, 39);
      g.fillText(elapsed(t).slice(3), Math.min(this.width - 16, Math.max(16, x)), h - 5);
    }
    g.stroke();
  }

  #marks(g, c) {
    g.font = "11px B612, sans-serif";
    g.textAlign = "center";
    g.textBaseline = "middle";
    const taken = new Set();
    for (const event of this.events) {
      if (!this.#shown(event)) continue;
      const x = this.x(event.time_ns / 1e9), slot = `${event.kind}${Math.round(x / 6)}`;
      if (taken.has(slot) || x < 0 || x > this.width) continue;
      taken.add(slot);
      g.fillStyle = event.kind !== "alert" ? c("text") : c(/^alarm/i.test(event.text ?? "") ? "alarm" : "information");
      g.fillText(MARKS.get(event.kind) ?? "\u00b7", x, 25);
    }
  }
}
