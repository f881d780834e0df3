// Effects: what each did to the plots of the target selected, and what the scene calls for.

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

/** What every simulated effect did to the plots of the selected target in the scan shown, and what the scene calls for. */
function showEffects(box, { of, message, sensors, plan }) {
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

export default {
  key: "effects",
  title: "Effects",
  make(section, { state, selectedNumber }) {
    const box = element("div", [], { id: "effects" });
    section.append(box);
    let told = null, plan = [];
    const show = () => {
      const of = state.selected && (state.callsign || state.selected.replace(/^t/, "Track "));
      showEffects(box, { of, message: told, sensors: state.airport?.sensors ?? [], plan });
    };
    return {
      show,
      needs: ["plan", "effects"],
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
