// Effects: what each did to the plots of the target selected, what the scene calls for, and where in a radar's rings and sectors it is on.

import { dial, patch, Rings, sectorText, sentence, STATES, sums } from "../rings.js";
import { element, elapsed, fixed, NONE } from "../text.js";

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

/** What every simulated effect did to the plots of the selected target in the scan shown. */
function cards({ of, message, sensors }) {
  const say = (text) => element("p", text, { class: "empty" });
  if (!of) return [say("Select a target to see what each simulated effect did to its plots.")];
  if (!message?.plots.length) return [say(`${of} has no plot in this scan, or the SMDFM runs without --explain.`)];
  const units = "dB: change of the echo or of what disturbs it; m: shift of the plot. SCNR: echo above clutter and noise.";
  return [...message.plots.map((plot) => effectCard(plot, sensors)), element("p", units, { class: "where" })];
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

/** Which effects the scene calls for, a table for each sensor: the simulated ones first. Those of a radar can be chosen. */
function planTables(plan, sensors, chosen) {
  if (!plan.length) return [];
  const parts = [element("h3", "Effects that the scene calls for")];
  for (const id of new Set(plan.map((row) => row[0]))) {
    const rows = plan.filter((row) => row[0] === id).map((row) => row.slice(1)), sensor = sensors.find((s) => String(s.id) === id);
    rows.sort((a, b) => Number(a[3] === "skipped") - Number(b[3] === "skipped"));
    const name = (effect) => {
      if (sensor?.kind !== "asde") return effect;
      const on = chosen?.sensor === Number(id) && chosen.effect === effect;
      return element("button", effect, { type: "button", class: "where-on", "data-sensor": id, "data-effect": effect, "aria-pressed": String(on), title: "Where it is on: rings and sectors, on the map too" });
    };
    parts.push(element("table", [
      element("caption", sensor?.name || `sensor ${id}`),
      element("thead", element("tr", ["Effect", "Called for by", "At most", "Simulated"].map((t) => element("th", t)))),
      element("tbody", rows.map((row) => element("tr", row.map((t, i) => element("td", i ? t : name(t))), { "data-mark": row[3] === "skipped" ? "skipped" : "" }))),
    ], { class: "plan" }));
  }
  parts.push(element("p", "At most: what leaving the effect out could change. Simulated: the level chosen, and its time for one target. An effect of a radar, pressed, shows where it is on.", { class: "where" }));
  return parts;
}

/** Where the effect chosen is on: dial, legend, and the same as a table. */
function whereOn(rings, sensors) {
  const { chosen, told, cells, why } = rings;
  if (!chosen) return [];
  const of = sensors.find((s) => s.id === chosen.sensor)?.name || `sensor ${chosen.sensor}`;
  const head = element("h3", ["Where it is on", element("button", "Close", { type: "button", "data-effect": "", "data-sensor": "" })]);
  if (!told) return [head, element("p", why ? `${of}, ${chosen.effect}: ${why}.` : `${of}, ${chosen.effect}: being planned \u2026`, { class: "empty" })];
  const words = `${of}, ${sentence(chosen.effect, cells)}`;
  if (!cells) return [head, element("p", words, { class: "empty" })];
  const legend = [...STATES].reverse().map((s) => element("li", [patch(s.letter), element("b", s.word), ` \u2013 ${s.means}`]));
  const metres = (from, to) => `${from.toFixed(0)}\u2013${to.toFixed(0)}`;
  const row = (c) => [STATES.find((s) => s.letter === c.state).word, metres(c.near, c.far), sectorText(c.sector, told.sectors), c.low > 0 ? metres(c.low, c.high) : "ground", c.kind, String(c.targets)];
  const table = element("table", [
    element("thead", element("tr", ["State", "Ring, m", "Sector", "Height, m", "Class", "Targets"].map((t) => element("th", t)))),
    element("tbody", [...cells].reverse().map((c) => element("tr", row(c).map((t) => element("td", t))))),
  ], { class: "told" });
  return [
    head, element("p", words, { class: "where", id: "rings-words", "data-cells": String(cells.length), "data-on": String(sums(cells).filter((s) => s.letter !== "n").length) }),
    dial(told, cells, words), element("ul", legend, { class: "legend" }),
    ...(cells.length ? [element("details", [element("summary", "Cells as a table"), table])] : []),
  ];
}

/** A change with its sign; a factor or a count without. */
function signed(value, unit) {
  if (!Number.isFinite(value)) return NONE;
  const text = fixed(value, Math.abs(value) < 10 ? 2 : 1);
  if (Number(text) === 0) return "0.00";
  return value > 0 && (unit === "dB" || unit === "m") ? `+${text}` : text;
}

export default {
  key: "effects",
  title: "Effects",
  make(section, { state, map, selectedNumber, viewChanged }) {
    const box = element("div", [], { id: "effects" }), parts = ["told", "rings", "plans"].map((key) => element("div", [], { "data-part": key }));
    box.append(...parts);
    section.append(box);
    let told = null, plan = [], shown = "", opened = false;
    const [cardBox, ringBox, planBox] = parts, sensors = () => state.airport?.sensors ?? [];
    const rings = map.rings = new Rings(() => {
      map.need("ground");
      showRings();
    });
    /** Content anew; what had the focus has it again. */
    const fill = (part, content) => {
      const held = part.contains(document.activeElement) ? document.activeElement.dataset : null;
      part.replaceChildren(...content);
      if (held?.effect !== undefined) part.querySelector(`button[data-sensor="${held.sensor}"][data-effect="${CSS.escape(held.effect)}"]`)?.focus();
    };
    const showRings = () => {
      fill(ringBox, whereOn(rings, sensors()));
      const details = ringBox.querySelector("details");
      if (!details) return;
      details.open = opened;
      details.addEventListener("toggle", () => (opened = details.open));
    };
    const ask = () => rings.want(map.skin === "controller" || map.blind ? null : state.effect ?? null, state.scan?.scan, map.run);
    const show = () => {
      const of = state.selected && (state.callsign || state.selected.replace(/^t/, "Track "));
      fill(cardBox, cards({ of, message: told, sensors: sensors() }));
      ask();
      const now = JSON.stringify([plan, state.effect, sensors().map((s) => [s.id, s.name])]);
      if (now === shown) return;
      shown = now;
      fill(planBox, planTables(plan, sensors(), state.effect));
    };
    box.addEventListener("click", (event) => {
      const { sensor, effect } = event.target.closest?.("button[data-effect]")?.dataset ?? {};
      if (effect === undefined) return;
      const same = state.effect?.effect === effect && state.effect.sensor === Number(sensor), before = state.effect;
      state.effect = effect && !same ? { sensor: Number(sensor), effect } : null;
      show();
      if (!effect) planBox.querySelector(`button[data-effect="${CSS.escape(before?.effect ?? "")}"]`)?.focus();
      viewChanged();
    });
    return {
      show,
      needs: ["plan", "effects"],
      scan: ask,
      take: {
        plan: (message) => (plan = message.rows),
        effects: (message) => {
          if (message.track === selectedNumber()) told = message;
        },
      },
      selected: () => (told = null),
    };
  },
};
