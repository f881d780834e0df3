// Control alerts: their words, the panel with acknowledgement and sound, and who on the map they are about.

import { element } from "./text.js";

const ACTIONS = { BTR: "backtrack", CRO: "crossing", ENT: "entry", GOA: "go-around", HLD: "hold", LND: "landing", LUP: "line-up", PSH: "push-back", REV: "revocation", SPD: "speed", TAX: "taxi", TOF: "take-off" };

/** Words of every kind but the clearances that exclude each other. */
const WORDS = new Map([
  ["RMCA_ARR", "runway not free for an arrival"], ["RMCA_ROLL", "runway not free ahead of a roll"], ["RMCA_OPP", "traffic against each other on a runway"],
  ["RMCA_CROSS", "traffic that meets where runways cross"], ["RWY_CLOSED", "closed runway"], ["NOCLR_RWY", "on a runway without clearance"],
  ["NOCLR_TOF", "take-off without clearance"], ["NOCLR_LND", "landing without clearance"], ["NOCLR_PUSH", "push-back without clearance"],
  ["NOCLR_TAXI", "taxiing without clearance"], ["STOPBAR", "lit stop bar crossed"], ["ROUTE_DEV", "off the cleared way"], ["NOMOV", "cleared and does not move"],
  ["HIGH_SPEED", "too fast"], ["AREA", "in a protected area"], ["WRTY", "way or runway too small for the type"], ["STOCC", "stand of an arrival occupied"],
]);

/** What an alert of this kind says. */
export function alertWords(kind) {
  const pair = /^CATC_([A-Z]{3})_([A-Z]{3})$/.exec(kind);
  if (pair) return `clearances exclude each other: ${ACTIONS[pair[1]] ?? pair[1]}, ${ACTIONS[pair[2]] ?? pair[2]}`;
  return WORDS.get(kind) ?? kind;
}

/** The target that an alert calls so: by its call sign, else by the number of its track. */
export function subjectOf(scan, name) {
  return scan?.tracks.find((t) => t.callsign === name && !t.assumed) ?? scan?.tracks.find((t) => !t.callsign && String(t.number) === name)
    ?? scan?.tracks.find((t) => t.callsign === name) ?? null;
}

/** Kinds that are about a runway. */
const RUNWAY = /^(RMCA|RWY|NOCLR_(RWY|TOF|LND)|CATC)/;

/** The runway that an alert is about, as `ground` has it: where it is, where its subjects are, or whose strip its place lies in; null for none. */
export function runwayOf(alert, scan, ground) {
  if (!ground || !RUNWAY.test(alert.kind)) return null;
  const on = alert.subjects.map((name) => subjectOf(scan, name)).filter((t) => t && !(t.altitudeM > 15));
  for (const [x, y] of [alert.place_m, ...on.map((t) => [t.x, t.y])]) {
    const runway = ground.runwayAt(x, y);
    if (runway) return runway;
  }
  return ground.runwayAt(...alert.place_m, STRIP_M);
}

/** Half the width of a strip beyond the runway's edge, m. */
const STRIP_M = 75;

/** Stage by target: the graver counts. */
export function stagesOf(scan, open) {
  const stages = new Map();
  for (const alert of open) {
    for (const name of alert.subjects) {
      const id = subjectOf(scan, name)?.id;
      if (id !== undefined && stages.get(id) !== "alarm") stages.set(id, alert.stage);
    }
  }
  return stages;
}

const MOST_SHOWN = 40, REPEAT_MS = 3000;

export class AlertPanel {
  #known = new Set();
  #text = "";
  #runways = new Map();
  #sounded = 0;

  /** `page` has pick(alert), acknowledge(id), time(seconds) → text, runway(alert) → its name or "". */
  constructor(box, page) {
    Object.assign(this, { box, page, open: [], ended: [] });
    this.count = element("h2", "Alerts");
    this.sound = element("button", "Sound off", { type: "button", "aria-pressed": "false", title: "Two tones; an alarm repeats until it is acknowledged" });
    this.sound.addEventListener("click", () => this.setSound(!this.audio));
    this.list = element("ol", []);
    const log = element("div", [this.list], { role: "log", "aria-label": "Alerts that stand" });
    this.past = element("ol", []);
    this.more = element("details", [element("summary", "Ended"), this.past]);
    this.aloud = element("p", "", { class: "hidden", role: "alert" });
    box.append(element("header", [this.count, this.sound]), log, this.more, this.aloud);
    setInterval(() => this.#repeat(), 500);
  }

  show({ open, ended }) {
    Object.assign(this, { open, ended });
    const fresh = open.filter((a) => !a.acknowledged && !this.#known.has(`${a.id}${a.stage}`));
    for (const alert of open) this.#known.add(`${alert.id}${alert.stage}`);
    if (this.#known.size > 5000) this.#known.clear();
    if (this.#runways.size > 5000) this.#runways.clear();
    this.draw();
    const alarm = fresh.find((a) => a.stage === "alarm");
    if (alarm) this.aloud.textContent = `Alarm: ${this.#words(alarm)}, ${alarm.subjects.join(" and ")}`;
    if (fresh.length) this.#tone(Boolean(alarm));
  }

  /** Another run: its alerts are numbered from 1 again, and none of them was seen before. */
  forget() {
    this.#known.clear();
    this.#runways.clear();
    this.#text = "";
    this.show({ open: [], ended: [] });
  }

  draw() {
    const { open, ended } = this, text = JSON.stringify([open, ended]);
    if (text === this.#text) return;
    this.#text = text;
    this.box.hidden = !open.length && !ended.length;
    const alarms = open.filter((a) => a.stage === "alarm").length;
    this.count.textContent = `Alerts (${open.length}${alarms ? `, ${alarms} alarm${alarms > 1 ? "s" : ""}` : ""})`;
    const focus = document.activeElement?.closest?.("[data-alert]")?.dataset.alert, acked = document.activeElement?.classList.contains("ack");
    this.list.replaceChildren(...open.slice(0, MOST_SHOWN).map((a) => this.#row(a)));
    if (open.length > MOST_SHOWN) this.list.append(element("li", `${open.length - MOST_SHOWN} more`, { class: "empty" }));
    this.past.replaceChildren(...ended.map((a) => this.#row(a)));
    this.more.hidden = !ended.length;
    if (focus) this.box.querySelector(`[data-alert="${CSS.escape(focus)}"] ${acked ? ".ack" : "button"}`)?.focus();
  }

  /** Words with the runway, as it was known when the alert was first seen. */
  #words(alert) {
    if (!this.#runways.get(alert.id)) this.#runways.set(alert.id, this.page.runway(alert));
    const runway = this.#runways.get(alert.id);
    return `${runway ? `${runway}: ` : ""}${alertWords(alert.kind)}`;
  }

  #row(alert) {
    const { page } = this, alarm = alert.stage === "alarm", over = alert.end_s !== null;
    const until = over ? `\u2013${page.time(alert.end_s)}` : "";
    const show = element("button", [
      element("b", `${alarm ? "\u25a0" : "\u25c7"} ${alert.stage}`), ` ${page.time(alert.since_s)}${until} `, element("span", alert.subjects.join(" / "), { class: "who" }),
      element("small", `${this.#words(alert)} (${alert.kind})`),
    ], { type: "button", title: "Show on the map" });
    show.addEventListener("click", () => page.pick(alert));
    const parts = [show];
    if (alert.acknowledged) parts.push(element("small", `seen by ${alert.acknowledged}`, { class: "seen" }));
    else if (!over) {
      const ack = element("button", "Seen", { type: "button", class: "ack", title: "Acknowledge (K: the first)", "aria-label": `Seen: ${alert.kind} ${alert.subjects.join(" ")}` });
      ack.addEventListener("click", () => page.acknowledge(alert.id));
      parts.push(ack);
    }
    return element("li", parts, { "data-alert": alert.id, "data-stage": alert.stage, "data-seen": String(Boolean(alert.acknowledged) || over) });
  }

  /** The first that nobody has seen. */
  first() {
    return this.open.find((a) => !a.acknowledged) ?? null;
  }

  setSound(on) {
    if (on && !this.audio) this.audio = new AudioContext();
    if (!on) {
      this.audio?.close();
      this.audio = null;
    }
    this.sound.setAttribute("aria-pressed", String(on));
    this.sound.textContent = on ? "Sound on" : "Sound off";
    if (on) this.#tone(false);
  }

  #repeat() {
    const standing = this.open.some((a) => a.stage === "alarm" && !a.acknowledged);
    if (standing && performance.now() - this.#sounded > REPEAT_MS) this.#tone(true);
  }

  /** Two generated tones: falling for an alarm, one soft one for information. */
  #tone(alarm) {
    this.#sounded = performance.now();
    if (!this.audio) return;
    const { audio } = this;
    (alarm ? [880, 660] : [520]).forEach((hertz, i) => {
      const tone = audio.createOscillator(), gain = audio.createGain(), from = audio.currentTime + i * 0.18;
      tone.frequency.value = hertz;
      gain.gain.setValueAtTime(alarm ? 0.2 : 0.1, from);
      gain.gain.exponentialRampToValueAtTime(0.001, from + 0.17);
      tone.connect(gain).connect(audio.destination);
      tone.start(from);
      tone.stop(from + 0.18);
    });
  }
}
