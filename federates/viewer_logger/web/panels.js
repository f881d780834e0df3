// The lists beside the map: targets, flights, federates, sensors, operator actions.

import { bytes, element, elapsed, fixed, NONE, place, utc } from "./text.js";

const KNOT = 1.943844;

/** A table that sorts by the head clicked, keeps its rows and shows which one is selected. */
/** Rows of a table, at most. */
const MOST_ROWS = 200;

export class Table {
  /** columns: { key, title, hint, read(item) → value to sort by, show(item) → text, number } */
  constructor(table, columns, { id, onSelect, sortBy }) {
    this.columns = columns;
    this.id = id;
    this.onSelect = onSelect;
    this.sort = { key: sortBy, down: false };
    this.items = [];
    this.selected = null;
    this.body = table.tBodies[0];
    this.rows = new Map();
    const head = element("tr", columns.map((column) => {
      const button = element("button", column.title, { type: "button", title: column.hint ?? column.title });
      button.addEventListener("click", () => this.#sortBy(column.key));
      return element("th", button, { scope: "col", class: column.number ? "number" : null, "data-key": column.key });
    }));
    this.head = head;
    table.tHead.append(head);
    this.#markSort();
  }

  #sortBy(key) {
    this.sort = { key, down: this.sort.key === key ? !this.sort.down : false };
    this.#markSort();
    this.show(this.items);
  }

  #markSort() {
    for (const cell of this.head.cells) {
      cell.setAttribute("aria-sort", cell.dataset.key !== this.sort.key ? "none" : this.sort.down ? "descending" : "ascending");
    }
  }

  select(id) {
    this.selected = id;
    for (const [key, row] of this.rows) row.setAttribute("aria-selected", String(key === id));
    this.rows.get(id)?.scrollIntoView({ block: "nearest" });
  }

  /** Ids in the order shown. */
  order() {
    return [...this.body.rows].map((row) => row.dataset.id);
  }

  show(items) {
    this.items = items;
    const column = this.columns.find((c) => c.key === this.sort.key);
    const sorted = [...items].sort((a, b) => compare(column.read(a), column.read(b)) * (this.sort.down ? -1 : 1) || compare(this.id(a), this.id(b)));
    const seen = new Set();
    // What nobody scrolls to costs nothing: the selected row is always there.
    const chosen = sorted.findIndex((item) => this.id(item) === this.selected);
    if (chosen >= MOST_ROWS) sorted.splice(MOST_ROWS - 1, 0, ...sorted.splice(chosen, 1));
    const more = sorted.length - MOST_ROWS;
    sorted.length = Math.min(sorted.length, MOST_ROWS);
    this.body.parentElement.dataset.more = more > 0 ? `${more} more: search or sort to see them` : "";
    sorted.forEach((item, i) => {
      const id = this.id(item);
      seen.add(id);
      const row = this.rows.get(id) ?? this.#row(id);
      this.columns.forEach((c, k) => {
        const text = (c.show ?? c.read)(item) ?? NONE;
        if (row.cells[k].textContent !== text) row.cells[k].textContent = text;
        const mark = c.mark?.(item) ?? "";
        if (row.cells[k].dataset.mark !== mark) row.cells[k].dataset.mark = mark;
      });
      if (this.body.rows[i] !== row) this.body.insertBefore(row, this.body.rows[i] ?? null);
    });
    for (const [id, row] of this.rows) {
      if (seen.has(id)) continue;
      row.remove();
      this.rows.delete(id);
    }
  }

  #row(id) {
    const row = element("tr", this.columns.map((c) => element("td", "", { class: c.number ? "number" : null })),
      { "data-id": id, "aria-selected": String(id === this.selected) });
    if (this.onSelect) {
      row.tabIndex = 0;
      row.addEventListener("click", () => this.onSelect(id));
      row.addEventListener("keydown", (event) => {
        if (event.key === "Enter") this.onSelect(id);
      });
    }
    this.rows.set(id, row);
    return row;
  }
}

/** Made once: a comparison that makes its own costs fifty times as much. */
const WORDS = new Intl.Collator("en", { numeric: true });

function compare(a, b) {
  const empty = (v) => v === null || v === undefined || v === "" || Number.isNaN(v);
  if (empty(a) || empty(b)) return Number(empty(a)) - Number(empty(b));
  return typeof a === "number" && typeof b === "number" ? a - b : WORDS.compare(String(a), String(b));
}

export const speedKt = (t) => Math.hypot(t.vx, t.vy) * KNOT;
export const headingDeg = (t) => (((t.heading * 180) / Math.PI) % 360 + 360) % 360;

export const TRACK_COLUMNS = [
  { key: "callsign", title: "Call sign", read: (t) => t.callsign || `#${t.number}`, mark: (t) => (t.number === undefined ? "truth" : t.movement || t.type) },
  { key: "number", title: "Trk", hint: "Track number", read: (t) => t.number ?? null, show: (t) => (t.number === undefined ? NONE : String(t.number)), number: true },
  { key: "type", title: "Type", read: (t) => t.designator, show: (t) => (t.wake ? `${t.designator}/${t.wake}` : t.designator || NONE) },
  { key: "speed", title: "kt", hint: "Ground speed, knots", read: speedKt, show: (t) => fixed(speedKt(t), 0), number: true },
  { key: "heading", title: "Hdg", hint: "Course over ground, degrees", read: headingDeg, show: (t) => (Number.isFinite(t.heading) ? String(Math.round(headingDeg(t)) % 360).padStart(3, "0") : NONE), number: true },
  { key: "error", title: "Err m", hint: "Distance from truth, metres", read: (t) => t.errorM ?? null, show: (t) => (t.errorM === undefined || t.errorM === null ? NONE : fixed(t.errorM, 1)), number: true },
  { key: "status", title: "State", read: (t) => t.status ?? "no track", mark: (t) => t.status ?? "missing" },
];

export function flightColumns(startNs) {
  const at = (s) => (Number.isFinite(s) ? utc(startNs(), s).slice(0, 5) : NONE);
  return [
    { key: "callsign", title: "Call sign", read: (f) => f.callsign, mark: (f) => f.movement },
    { key: "type", title: "Type", read: (f) => f.type_designator, show: (f) => (f.wake ? `${f.type_designator}/${f.wake}` : f.type_designator) },
    { key: "movement", title: "Mov", hint: "Arrival, departure, vehicle", read: (f) => f.movement, show: (f) => ({ arrival: "ARR", departure: "DEP", vehicle: "VEH" })[f.movement] ?? f.movement },
    { key: "runway", title: "Rwy", read: (f) => f.runway, show: (f) => f.runway || NONE },
    { key: "stand", title: "Stand", read: (f) => f.stand, show: (f) => f.stand.replaceAll("_", " ") || NONE },
    { key: "time", title: "Time", hint: "Estimated arrival or calculated departure, UTC", read: (f) => f.eta_ctd_ns, show: (f) => (f.movement === "vehicle" ? NONE : at(f.eta_ctd_ns / 1e9)), number: true },
    { key: "routing", title: "Routing", read: (f) => (f.routing ?? []).join(" "), show: (f) => (f.routing ?? []).join(" ") || NONE },
  ];
}

/** Facts as a list of pairs; keeps the elements between calls so that nothing flickers. */
export function facts(list, pairs) {
  while (list.children.length > pairs.length * 2) list.lastChild.remove();
  while (list.children.length < pairs.length * 2) list.append(element("dt", ""), element("dd", ""));
  pairs.forEach(([name, value, mark, hint], i) => {
    const [dt, dd] = [list.children[2 * i], list.children[2 * i + 1]];
    if (dt.textContent !== name) dt.textContent = name;
    if (dd.textContent !== value) dd.textContent = value;
    dd.dataset.mark = mark ?? "";
    dt.title = hint ?? "";
  });
}

export function targetFacts(t) {
  if (!t) return [];
  const rows = [];
  if (t.number !== undefined) {
    rows.push(["Track", `${t.number} ${t.status}`], ["Type", [t.designator, t.wake].filter(Boolean).join("/") || (t.callsign ? NONE : "not identified yet")]);
    rows.push(["Movement", [t.movement, t.runwayStand.replaceAll("_", " ")].filter(Boolean).join(" ") || NONE]);
  } else rows.push(["Track", "none", "missing"], ["Type", t.designator || NONE]);
  rows.push(["Speed", `${fixed(speedKt(t), 0)} kt`], ["Course", Number.isFinite(t.heading) ? `${fixed(headingDeg(t), 0)}\u00b0` : NONE]);
  rows.push(["Position", place(t.x, t.y), "", "From the airport's reference point"]);
  if (t.number !== undefined) {
    rows.push(["Error", t.errorM === null ? "no truth" : `${fixed(t.errorM, 2)} m`, t.errorM === null ? "missing" : "error", "Distance of the track from truth"]);
    const sigma = Math.sqrt(t.cov[0] + t.cov[2]);
    rows.push(["Claimed \u03c3", Number.isFinite(sigma) ? `${fixed(sigma, 2)} m` : NONE, "", "The error that the track itself expects: its standard deviation"]);
  }
  return rows;
}

/** One card a federate. */
export function showFederates(box, federates, members) {
  const names = [...new Set([...members.map((m) => m.name), ...federates.map((f) => f.name)])].sort();
  if (!names.length) {
    box.replaceChildren(element("p", "No federate has reported yet.", { class: "empty" }));
    return;
  }
  box.replaceChildren(...names.map((name) => {
    const f = federates.find((x) => x.name === name) ?? {}, m = members.find((x) => x.name === name);
    const alive = m ? m.alive : true;
    const dropped = (f.dropped ?? []).reduce((sum, d) => sum + d[1], 0);
    const list = element("dl", [], { class: "facts" });
    facts(list, [
      ["Frame", String(f.frame ?? m?.frame ?? NONE)],
      ["PDUs in", f.in_per_s === null || f.in_per_s === undefined ? String(f.pdus_in ?? NONE) : `${fixed(f.in_per_s, 0)} /s`],
      ["PDUs out", f.out_per_s === null || f.out_per_s === undefined ? String(f.pdus_out ?? NONE) : `${fixed(f.out_per_s, 0)} /s`],
      ["Lost", String(f.lost ?? NONE), f.lost > 0 ? "warn" : ""],
      ["Repaired", String(f.repaired ?? NONE)],
      ["Refused", f.dropped ? String(dropped) : NONE, dropped ? "warn" : ""],
      ["Step", duration(f.exec_us), "", "Computing one frame, mean"], ["Longest", duration(f.exec_max_us), "", "The longest frame so far"],
      ["Latency", duration(m?.latency_us), "", "From the conductor's order for a frame to this federate's answer"],
      ["CPU", Number.isFinite(f.cpu_pct) ? `${fixed(f.cpu_pct, 0)} %` : NONE],
      ["Memory", bytes(f.rss_bytes)],
    ]);
    const where = [(f.host || m?.host) && `host ${f.host || m?.host}`, (f.pid || m?.pid) && `process ${f.pid || m?.pid}`].filter(Boolean).join(", ");
    const reasons = (f.dropped ?? []).map(([why, n]) => `${n} \u00d7 ${why}`).join("; ");
    return element("article", [
      element("h3", [element("i", "", { class: "dot", "data-mark": alive ? "good" : "bad" }), name,
        element("small", alive ? (m && !m.essential ? "spectator" : "") : "not heard")]),
      element("p", [where, reasons && ` \u2013 refused: ${reasons}`].filter(Boolean), { class: "where" }),
      list,
    ], { class: "card", "data-name": name });
  }));
}

/** What the measures of a run are called for a reader: words, and what they mean where the words do not say it. */
const MEASURES = new Map([
  ["tracks_confirmed", ["Tracks so far", "Tracks that were confirmed since the run began"]],
  ["tracks_now", ["Tracks now", "Confirmed tracks in this scan"]],
  ["rmse_m", ["Error of the tracks", "Root mean square of the filtered positions against truth, moving targets that the radar sees"]],
  ["raw_rmse_m", ["Error of the plots", "Root mean square of the same targets' plots, before the filter"]],
  ["straight_rmse_m", ["Tracks, straight legs", "Error of the tracks where the target goes straight"]],
  ["straight_raw_rmse_m", ["Plots, straight legs", "Error of the plots where the target goes straight"]],
  ["published_rmse_m", ["Error as published", "Error of the tracks as they are published: predicted to the end of the scan"]],
  ["second_ago_rmse_m", ["Error one second ago", "Error of the same tracks one scan earlier, as the next scan's plots revise them"]],
  ["false_plots", ["False plots", "Plots that no target caused, since the run began"]],
  ["outsiders_now", ["Outsiders now", "Entities of other simulators that the sensors see"]],
]);

/** Words for a measure, and a hint. */
function measureName(name) {
  const known = MEASURES.get(name);
  if (known) return known;
  const [what, ...rest] = name.split("_");
  const sensor = rest.join(" ").toUpperCase();
  if (what === "pd") return [`Detected by ${sensor}`, "Looks at a target that gave a plot, of all looks"];
  if (what === "plots") return [sensor === "OTHER" ? "Plots of other kinds" : `Plots of ${sensor}`, ""];
  return [name.replaceAll("_", " "), ""];
}

/** Plots of each sensor in the scan shown, and the measures of the run. */
export function showSensors(box, { scan, sensors, measures, tookUs }) {
  const ids = [...new Set([...sensors.map((s) => s.id), ...(scan?.plots ?? []).map((p) => p.sensor)])].sort((a, b) => a - b);
  const row = (cells, tag = "td") => element("tr", cells.map((c, i) => element(tag, c, { class: i > 1 ? "number" : null })));
  const rows = ids.map((id) => {
    const plots = (scan?.plots ?? []).filter((p) => p.sensor === id), site = sensors.find((s) => s.id === id);
    const errors = plots.map((p) => p.errorM).filter((e) => e !== null);
    const rmse = errors.length ? Math.sqrt(errors.reduce((s, e) => s + e * e, 0) / errors.length) : NaN;
    const alarms = plots.filter((p) => p.truthIndex < 0).length;
    return row([site?.name || `sensor ${id}`, site?.kind ?? plots[0]?.kind ?? NONE, String(plots.length), String(alarms), fixed(rmse, 2)]);
  });
  const parts = [
    element("h3", "Plots of this scan"),
    element("table", [element("thead", row(["Sensor", "Kind", "Plots", "False", "Error m"], "th")), element("tbody", rows)]),
  ];
  if (measures?.length) {
    const list = element("dl", [], { class: "facts" });
    facts(list, [...measures.map(([n, v]) => [measureName(n)[0], measure(n, v), "", measureName(n)[1]]), ["Scan took", duration(tookUs)]]);
    parts.push(element("h3", "Measures of the run"), list);
  }
  box.replaceChildren(...parts);
}

/** What the effects are, for a reader who has not met them. */
const EFFECTS = new Map([
  ["rain attenuation", "rain on the way absorbs and scatters"], ["fog", "droplets on the way absorb"], ["gases", "oxygen and water vapour absorb"],
  ["rain clutter", "echo of the rain around the target"], ["ground clutter", "echo of the ground around the target"],
  ["surface reflection", "a second path by the surface"], ["lobing", "that path in phase or against it"],
  ["roughness", "a rough surface reflects less"], ["water film", "a wet surface reflects otherwise"],
  ["reflected polarisation", "reflection turns the polarisation"], ["earth curvature", "in the reflection at the surface"],
  ["detection probability", "whether an echo is seen at all"], ["target extent", "echo centre off the middle of the body"],
  ["glint", "the echo's centre wanders"], ["thermal range error", "noise of the receiver, along the beam"],
  ["thermal azimuth error", "noise of the receiver, across the beam"], ["quantisation", "steps of the extractor"],
  ["building shadow", "a building hides the target in part"], ["aircraft shadow", "an aircraft hides the target in part"],
  ["facade ghosts", "mirror image in a facade"], ["multipath", "signals by way of walls and ground"],
  ["geometry", "where the satellites stand"], ["correlated error", "satellites and air: changes slowly"], ["white error", "noise, new with every fix"],
  ["correction age", "the correction is already old"], ["correction distance", "it was made somewhere else"],
  ["latency", "the report is of an earlier moment"], ["position rounding", "digits of the report"],
]);

/** What every simulated effect did to the plots of the selected target in the scan shown, and what the scene calls for. */
export function showEffects(box, { of, message, sensors, plan }) {
  const say = (text) => element("p", text, { class: "empty" });
  const parts = [];
  if (!of) parts.push(say("Select a target to see what each simulated effect did to its plots."));
  else if (!message?.plots.length) parts.push(say(`${of} has no plot in this scan, or the SMDFM runs without --explain.`));
  else parts.push(...message.plots.map((plot) => effectCard(plot, sensors)));
  if (message?.plots.length) {
    parts.push(element("p", "dB: change of the echo or of what disturbs it; m: shift of the plot. SCNR: echo above clutter and noise.", { class: "where" }));
  }
  parts.push(...planTables(plan ?? [], sensors));
  box.replaceChildren(...parts);
}

function effectCard(plot, sensors) {
  const site = sensors.find((s) => s.id === plot.sensor);
  const about = [elapsed(plot.time_s), Number.isFinite(plot.scnr_db) ? `SCNR ${fixed(plot.scnr_db, 1)} dB` : "",
    Number.isFinite(plot.error_m) ? `error ${fixed(plot.error_m, 2)} m` : "", plot.track === null ? "not used by a track" : ""];
  const row = ([name, value, unit]) => element("tr", [
    element("td", [name, element("small", EFFECTS.get(name) ?? "")]), element("td", signed(value, unit), { class: "number" }), element("td", unit),
  ]);
  const head = ["Effect", "Change", "Unit"].map((t, i) => element("th", t, { class: i === 1 ? "number" : null }));
  return element("article", [
    element("h3", [site?.name || `sensor ${plot.sensor}`, element("small", plot.kind)]),
    element("p", about.filter(Boolean).join(" \u2013 "), { class: "where" }),
    element("table", [element("thead", element("tr", head)), element("tbody", plot.effects.map(row))], { class: "told" }),
  ], { class: "card" });
}

/** Which effects the scene calls for, a table for each sensor: the simulated ones first. */
function planTables(plan, sensors) {
  if (!plan.length) return [];
  const parts = [element("h3", "Effects that the scene calls for")];
  for (const id of new Set(plan.map((row) => row[0]))) {
    const rows = plan.filter((row) => row[0] === id).map((row) => row.slice(1));
    rows.sort((a, b) => Number(a[3] === "skipped") - Number(b[3] === "skipped"));
    parts.push(element("table", [
      element("caption", sensors.find((s) => String(s.id) === id)?.name || `sensor ${id}`),
      element("thead", element("tr", ["Effect", "Called for by", "At most", "Simulated"].map((t) => element("th", t)))),
      element("tbody", rows.map((row) => element("tr", row.map((t) => element("td", t)), { "data-mark": row[3] === "skipped" ? "skipped" : "" }))),
    ], { class: "plan" }));
  }
  parts.push(element("p", "At most: what leaving the effect out could change. Simulated: the level chosen, and its time for one target.", { class: "where" }));
  return parts;
}

/** A change with its sign; a factor or a count without. */
function signed(value, unit) {
  if (!Number.isFinite(value)) return NONE;
  const text = fixed(value, Math.abs(value) < 10 ? 2 : 1);
  if (Number(text) === 0) return "0.00";
  return value > 0 && (unit === "dB" || unit === "m") ? `+${text}` : text;
}

/** The error of the run's own filter, and its time. */
export function showRun(box, { measures, tookUs }) {
  const read = (name) => measures?.find(([n]) => n === name)?.[1];
  const list = element("dl", [], { class: "facts" });
  facts(list, [["Error of the tracks", `${fixed(read("rmse_m"), 2)} m`], ["of the plots", `${fixed(read("raw_rmse_m"), 2)} m`], ["Scan took", duration(tookUs)]]);
  box.replaceChildren(element("h3", "The run"), list);
}

/** A time in the unit that suits it; zero is not measured. */
function duration(us) {
  if (!(us > 0)) return NONE;
  return us < 10 ? `${fixed(us, 0)} \u00b5s` : `${fixed(us / 1000, us < 10000 ? 2 : 0)} ms`;
}

function measure(name, value) {
  if (!Number.isFinite(value)) return NONE;
  if (name.startsWith("pd")) return `${fixed(100 * value, 1)} %`;
  if (name.endsWith("_m")) return `${fixed(value, 2)} m`;
  return Number.isInteger(value) ? String(value) : fixed(value, 3);
}

export function showOperations(list, operations) {
  if (!operations.length) {
    list.replaceChildren(element("li", "No operator action yet.", { class: "empty" }));
    return;
  }
  list.replaceChildren(...[...operations].reverse().map((o) => element("li", [
    element("time", elapsed(o.time_ns / 1e9)), element("b", o.command), element("span", o.source, { class: "source" }),
    element("span", o.text, { "data-mark": o.ok ? "" : "warn" }),
  ])));
}
