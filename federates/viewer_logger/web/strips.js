// Strips by bay: what each flight does, what it is cleared for, and why it waits. The bays are pure functions; the panel is at the end.

import { element, elapsed } from "./text.js";

/** Bays in their order: key, title, movements. */
export const BAYS = [
  ["pending", "Pending", "departure"], ["push", "Push and start", "departure"], ["taxi", "Taxi out", "departure"], ["hold", "Holding", "departure"],
  ["runway", "Runway", ""], ["final", "Final", "arrival"], ["taxi-in", "Taxi in", "arrival"], ["stand", "On stand", "arrival"], ["expected", "Expected", "arrival"], ["vehicle", "Vehicles", "vehicle"],
];

/** Bay of a flight by what the simulated traffic says of it. */
const BY_PHASE = {
  departure: { parked: "pending", docked: "pending", pushing: "push", starting: "push", taxiing: "taxi", "lined up": "runway", rolling: "runway" },
  arrival: { final: "final", "going around": "final", landing: "runway", taxiing: "taxi-in", docked: "stand", parked: "stand" },
};
/** The same by map and speed of its track. */
const BY_STATE = {
  departure: { parked: "pending", holding: "hold", taxiing: "taxi", runway: "runway", airborne: null },
  arrival: { airborne: "final", runway: "runway", taxiing: "taxi-in", holding: "taxi-in", parked: "stand" },
};
const LATE_S = 60, GONE_S = 600;

/**
 * One strip a flight: { callsign, type, movement, stand, runway, bay, state, derived, cleared: [text], waits, wants, timeS, lateS, trackId }.
 * `traffic` is what behaving traffic says (or null), `ground` tells a track's state by map and speed.
 */
export function stripsOf({ flights, scan, traffic, ground, timeS }) {
  const movers = new Map((traffic?.movers ?? []).map((m) => [m.callsign, m]));
  const tracks = new Map((scan?.tracks ?? []).filter((t) => t.callsign && !t.assumed).map((t) => [t.callsign, t]));
  const strips = [];
  for (const flight of flights) {
    const mover = movers.get(flight.callsign), track = tracks.get(flight.callsign);
    const state = mover ? mover.phase : track && ground ? ground.stateOf(track) : null;
    const bay = bayOf(flight, mover, state, timeS);
    if (!bay) continue;
    const due = flight.movement === "vehicle" ? NaN : flight.eta_ctd_ns / 1e9, waits = mover?.waits ?? null;
    const late = flight.movement === "departure" && bay !== "runway" ? timeS - due : NaN;
    strips.push({
      callsign: flight.callsign, type: flight.wake ? `${flight.type_designator}/${flight.wake}` : flight.type_designator, movement: flight.movement,
      stand: (mover?.stand || flight.stand).replaceAll("_", " "), runway: mover?.runway || flight.runway, bay, state: state ?? "not seen", derived: !mover,
      cleared: (mover?.cleared ?? []).map((c) => (c.runway ? `${c.kind} ${c.runway}` : c.kind)), waits, wants: mover?.wants ?? null,
      timeS: due, lateS: late > LATE_S ? late : null, trackId: track?.id ?? null, targets: mover?.targets ?? null,
    });
  }
  return strips;
}

function bayOf(flight, mover, state, timeS) {
  if (flight.movement === "vehicle") return "vehicle";
  const due = flight.eta_ctd_ns / 1e9;
  if (mover) {
    if (mover.phase === "taxiing" && flight.movement === "departure" && mover.waits) return "hold";
    return BY_PHASE[flight.movement]?.[mover.phase] ?? "runway";
  }
  if (state) return BY_STATE[flight.movement]?.[state] === undefined ? "runway" : BY_STATE[flight.movement][state];
  if (!(timeS < due + GONE_S)) return null;
  if (flight.movement === "arrival") return timeS < due ? "expected" : null;
  return timeS < due ? "pending" : null;
}

/** Strips of each bay that has any, the earliest first. */
export function baysOf(strips) {
  return BAYS.map(([key, title]) => [key, title, strips.filter((s) => s.bay === key).sort((a, b) => (a.timeS || 0) - (b.timeS || 0) || (a.callsign < b.callsign ? -1 : 1))])
    .filter(([, , list]) => list.length);
}

/** Why one waits, in words. */
export function waitText({ waits, wants }) {
  if (wants) return `waits for clearance ${wants}`;
  if (!waits) return "";
  const whom = waits.for ? `waits for ${waits.for}` : "waits for its turn";
  const planned = Number.isFinite(waits.planned_s) ? (waits.planned_s >= 0 ? `, planned in ${waits.planned_s} s` : `, ${-waits.planned_s} s late`) : "";
  return `${whom}${waits.at ? ` at ${waits.at}` : ""}, since ${elapsed(waits.since_s)}${planned}`;
}

/** Target times of a departure: key, short name, what it is. */
export const TARGETS = [
  ["tobt_s", "TOBT", "Target off-block time"], ["tsat_s", "TSAT", "Target start-up approval time"], ["ttot_s", "TTOT", "Target take-off time"],
  ["ctot_s", "CTOT", "Calculated take-off time: its slot"],
];

/** The traffic with the target times of its movers: under controllers those are said with their positions, else with the traffic itself. */
export function withTargets(traffic, positions) {
  if (!traffic || !positions?.targets?.length) return traffic;
  const said = new Map(positions.targets.map(({ callsign, ...times }) => [callsign, times]));
  const known = (times) => Object.fromEntries(Object.entries(times ?? {}).filter(([, s]) => Number.isFinite(s)));
  return { ...traffic, movers: traffic.movers.map((m) => (said.has(m.callsign) ? { ...m, targets: { ...said.get(m.callsign), ...known(m.targets) } } : m)) };
}

/** Target times in words; `time` makes a text of seconds. */
export function targetText(targets, time) {
  return TARGETS.filter(([key]) => Number.isFinite(targets?.[key])).map(([key, name]) => `${name} ${time(targets[key])}`).join(", ");
}

/** Facts of a target that only its strip and the simulated traffic know; `time` makes a text of seconds. */
export function clearanceFacts(target, traffic, time) {
  const mover = target?.callsign ? traffic?.movers.find((m) => m.callsign === target.callsign) : null;
  if (!mover) {
    // What its scan has: of runs without traffic that behaves, and of a run beside.
    const by = target?.derived ? ["", "By map and speed"] : [];
    return target?.doing ? [["Doing", target.doing, ...by], ...(target.cleared ? [["Cleared", target.cleared]] : [])] : [];
  }
  const runway = traffic.runways.find((r) => r.name.split("/").includes(mover.runway));
  const cleared = mover.cleared?.map((c) => (c.runway ? `${c.kind} ${c.runway}` : c.kind)).join(", ");
  const length = (line) => line.slice(1).reduce((sum, p, i) => sum + Math.hypot(p[0] - line[i][0], p[1] - line[i][1]), 0);
  const rows = [["Doing", `${mover.phase}, stand ${mover.stand.replaceAll("_", " ")}, runway ${mover.runway}`], ["Cleared", cleared || "nothing", cleared ? "" : "missing"]];
  if (mover.authority_m.length) rows.push(["May drive", `${length(mover.authority_m).toFixed(0)} m of ${(length(mover.authority_m) + length(mover.planned_m)).toFixed(0)} m`, "", "Its authority, of the whole planned way; drawn on the map"]);
  if (mover.held.length) rows.push(["Holds", `${mover.held.length} piece${mover.held.length > 1 ? "s" : ""} of the network`]);
  const why = waitText({ waits: mover.waits, wants: mover.wants });
  if (why) rows.push(["Why", why, "warn"]);
  for (const [key, name, what] of TARGETS) if (Number.isFinite(mover.targets?.[key])) rows.push([name, time(mover.targets[key]), "", what]);
  if (runway) rows.push([`Runway ${runway.name}`, `${runway.owner ? `in use by ${runway.owner}` : "free"}, ${runway.queue} waiting`]);
  return rows;
}

export class StripPanel {
  #text = "";
  #rows = new Map();
  #bays = new Map();

  /** `onPick(strip)`; `onAct(callsign, act)` where a strip has an act: what a person at its seat may say; `time(seconds)` → text. */
  constructor(box, { onPick, onAct, time }) {
    Object.assign(this, { box, onPick, onAct, time });
    box.addEventListener("keydown", (event) => this.#move(event));
  }

  show(strips, traffic, selected) {
    const bays = baysOf(strips), runways = traffic?.runways ?? [], text = JSON.stringify([bays, runways, selected]);
    if (text === this.#text) return;
    this.#text = text;
    const focus = document.activeElement?.closest?.("[data-strip]")?.dataset.strip, here = focus !== undefined && this.box.contains(document.activeElement);
    const parts = runways.map((r) => element("p", [element("b", r.name), ` ${r.owner ? `in use by ${r.owner}` : "free"}, ${r.queue} waiting`], { class: "runway", "data-busy": String(Boolean(r.owner)) }));
    // Bays and strips are kept: only what says something else is made again, only what stands elsewhere is moved.
    const kept = new Map();
    for (const [key, title, list] of bays) parts.push(this.#bay(key, `${title} (${list.length})`, list.map((s) => this.#strip(s, selected, kept))));
    this.#rows = kept;
    if (!bays.length) parts.push(element("p", "No flight of the list is under way.", { class: "empty" }));
    else if (strips.every((s) => s.derived)) parts.push(element("p", "States by map and speed of the tracks: these movements follow no clearances.", { class: "where" }));
    arrange(this.box, parts);
    if (here && document.activeElement?.dataset?.strip !== focus) this.box.querySelector(`[data-strip="${CSS.escape(focus)}"]`)?.focus();
  }

  #bay(key, title, rows) {
    let bay = this.#bays.get(key);
    if (!bay) {
      bay = { head: element("h3", ""), list: element("ul", []) };
      bay.section = element("section", [bay.head, bay.list], { "data-bay": key });
      this.#bays.set(key, bay);
    }
    if (bay.head.textContent !== title) bay.head.textContent = title;
    arrange(bay.list, rows);
    return bay.section;
  }

  #strip(s, selected, kept) {
    const text = JSON.stringify(s), old = this.#rows.get(s.callsign), pressed = String(s.callsign === selected);
    if (old?.text === text) {
      kept.set(s.callsign, old);
      if (old.button.getAttribute("aria-pressed") !== pressed) old.button.setAttribute("aria-pressed", pressed);
      return old.row;
    }
    const times = Number.isFinite(s.timeS) ? this.time(s.timeS).slice(0, 5) : "";
    const button = element("button", [
      element("b", s.callsign), element("span", s.type), element("span", s.stand), element("span", s.runway), element("span", times),
      element("small", [s.state, s.cleared.length ? ` \u00b7 ${s.cleared.join(", ")}` : "", waitText(s) ? ` \u00b7 ${waitText(s)}` : "", s.targets ? ` \u00b7 ${targetText(s.targets, (t) => this.time(t).slice(0, 5))}` : ""].join("")),
      s.lateS ? element("em", `\u2212${Math.round(s.lateS / 60)} min`, { title: "Late against its calculated time" }) : null,
    ], { type: "button", class: "strip", "data-strip": s.callsign, "data-movement": s.movement, "aria-pressed": pressed });
    button.addEventListener("click", () => this.onPick(s));
    const act = s.act && element("button", s.act.clearance, { type: "button", class: "next", "aria-label": `${s.callsign}: clear ${s.act.clearance}` });
    act?.addEventListener("click", () => this.onAct(s.callsign, s.act));
    const row = element("li", [button, act], { class: act ? "with-act" : null });
    kept.set(s.callsign, { row, button, text });
    return row;
  }

  /** Arrows go from strip to strip. */
  #move(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key], all = [...this.box.querySelectorAll(".strip")], at = all.indexOf(event.target);
    if (!step || at < 0) return;
    all[Math.min(all.length - 1, Math.max(0, at + step))].focus();
    event.preventDefault();
    event.stopPropagation();
  }
}

/** Makes these the children of a box, in this order; those that are there already stay where they can. */
function arrange(box, parts) {
  const wanted = new Set(parts);
  for (const child of [...box.children]) if (!wanted.has(child)) child.remove();
  parts.forEach((part, i) => {
    if (box.children[i] !== part) box.insertBefore(part, box.children[i] ?? null);
  });
}
