// The line for clearances at the foot of a controller's position: typed, completed with Tab, shown on the map as it is typed, checked
// before it is sent, and remembered. What it means is said by `meant.js`.

import { completions, conflictOf, contextOf, meant, whom } from "./meant.js";
import { seatFor } from "./seat.js";
import { keepLocal, readLocal } from "./local.js";

const MOST_KEPT = 50;

/** Lines that were sent, the newest last, and a place among them: up and down as in a shell. */
export class Past {
  constructor(lines = []) {
    this.lines = lines.filter((l) => typeof l === "string").slice(-MOST_KEPT);
    this.at = this.lines.length;
    this.draft = "";
  }

  add(line) {
    this.lines = [...this.lines.filter((l) => l !== line), line].slice(-MOST_KEPT);
    this.at = this.lines.length;
    this.draft = "";
  }

  /** The line so many places on; what was being typed is kept below the newest. */
  step(by, typed) {
    if (this.at === this.lines.length) this.draft = typed;
    this.at = Math.min(this.lines.length, Math.max(0, this.at + by));
    return this.lines[this.at] ?? this.draft;
  }
}

/** What Tab makes of a line: { line, more: words that fit } with all that they have in common; null where nothing fits. */
export function completed(line, context) {
  const words = completions(line, context);
  if (!words.length) return null;
  const before = line.slice(0, line.search(/\S*$/)), begun = line.slice(before.length);
  if (words.length === 1) return { line: `${before}${words[0]} `, more: [] };
  const ahead = words.filter((w) => w.toUpperCase().startsWith(begun.toUpperCase()));
  let common = ahead[0] ?? begun;
  for (const word of ahead) while (!word.toUpperCase().startsWith(common.toUpperCase())) common = common.slice(0, -1);
  return { line: before + common, more: words };
}

export class CommandLine {
  #asked = "";

  /** `parts`: form, input, says, next; `page`: state, map, seats() (or null), finished(), focusMap(). */
  constructor(parts, page) {
    Object.assign(this, { ...parts, page, past: new Past(readLocal("lines") ?? []) });
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#send();
    });
    this.input.addEventListener("input", () => this.#changed());
    this.input.addEventListener("focus", () => this.#changed());
    this.input.addEventListener("blur", () => this.#preview(null));
    this.input.addEventListener("keydown", (event) => this.#key(event));
    document.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || this.form.hidden || event.defaultPrevented || document.querySelector("dialog[open]")) return;
      if (event.target.closest?.("input, select, button, a, summary, tr[tabindex], .wheel")) return;
      this.input.focus();
      event.preventDefault();
    });
  }

  get context() {
    const { state } = this.page;
    return contextOf({ airport: state.airport, flights: state.flights, traffic: state.traffic, selected: state.callsign ?? null });
  }

  /** Whether there is somebody to type: at a seat, or in a controller's skin; who waits longest for this person, and what is advised. */
  show() {
    const { map } = this.page, seats = this.page.seats(), own = seats?.own() ?? [];
    this.form.hidden = !own.length && (map.skin !== "controller" || this.page.finished());
    const waiting = (seats?.state?.seats ?? []).filter((s) => own.includes(s.name)).flatMap((s) => s.wants).sort((a, b) => a.since_s - b.since_s);
    const advised = (seats?.state?.advice ?? []).filter((a) => own.includes(a.seat)).length;
    const text = [advised ? `advice: ${advised}` : "", waiting.length ? `next: ${waiting[0].clearance} ${waiting[0].callsign}` : ""].filter(Boolean).join(" \u00b7 ");
    if (this.next.textContent !== text) this.next.textContent = text;
  }

  #key(event) {
    event.stopPropagation();
    const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (step && !event.ctrlKey && !event.altKey) {
      this.input.value = this.past.step(step, this.input.value);
      this.#changed();
      event.preventDefault();
    } else if (event.key === "Tab" && !event.shiftKey && this.input.value.trim()) {
      const to = completed(this.input.value, this.context);
      if (!to) return;
      event.preventDefault();
      this.input.value = to.line;
      this.#changed();
      if (to.more.length) this.#say(to.more.slice(0, 12).join("  ") + (to.more.length > 12 ? "  \u2026" : ""));
    } else if (event.key === "Escape") {
      this.input.value = "";
      this.#changed();
      this.page.focusMap();
      event.preventDefault();
    }
  }

  /** As typed: what it means, and the way of whom it is for. An error is told once the line is sent: it may not be whole yet. */
  #changed() {
    this.#asked = "";
    const line = this.input.value;
    if (!line.trim()) {
      this.#say("");
      this.#preview(null);
      return;
    }
    const means = meant(line, this.context);
    this.#say(means.error ? "" : means.orders.map((o) => o.words).join("; "));
    this.#preview(whom(line, this.context));
  }

  /** A text below the line; with a column its mark stands there. */
  #say(text, column = null, bad = column !== null) {
    this.says.textContent = column === null ? text : `${" ".repeat(column)}\u25b2 ${text}`;
    this.says.dataset.mark = bad ? "warn" : "";
  }

  #preview(callsign) {
    const { map } = this.page;
    if ((map.previewed ?? null) === callsign) return;
    map.previewed = callsign;
    map.need("traffic");
  }

  async #send() {
    const line = this.input.value, { state, map } = this.page, seats = this.page.seats();
    const means = meant(line, this.context);
    if (means.error) {
      this.#say(means.text, means.column);
      this.input.setSelectionRange(means.column, means.column);
      return;
    }
    if (!seats?.state || !seats.own().length) {
      this.#say("nobody hears it: take a seat first (tab Seats)", null, true);
      return;
    }
    const places = new Map([...(map.scan?.tracks ?? [])].filter((t) => t.callsign).map((t) => [t.callsign, [t.x, t.y]]));
    const against = means.messages.map((m) => conflictOf(m, { airport: state.airport, traffic: state.traffic, places })).find(Boolean);
    if (against && this.#asked !== line) {
      this.#asked = line;
      this.#say(`${against}: Enter again says it all the same`, null, true);
      return;
    }
    this.#asked = "";
    for (const order of means.orders) {
      if (!(await seats.clear(seatFor(seats.state, order.clearance, order.callsign), order.callsign, order.clearance))) {
        this.#say(seats.answer?.text ?? "refused", null, true);
        return;
      }
    }
    this.past.add(line.trim());
    keepLocal("lines", this.past.lines);
    this.input.value = "";
    this.#preview(null);
    this.#say(`said: ${means.orders.map((o) => o.words).join("; ")}`);
  }
}
