// Sensors: their plots in the scan shown, and the measures of the run.

import { duration, facts } from "../lists.js";
import { element, fixed, NONE } from "../text.js";

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
  ["settled_rmse_m", ["Error, settled tracks", "Error as published, without the first three reports of a track on a target, and the last"]],
  ["settled_nees", ["Claims of settled tracks", "Squared error over the covariance claimed, mean: 2 is honest, more is too sure of itself"]],
  ["gross_plots", ["Gross plots", "Plots too far from their target to count in the errors"]],
  ["far_reports", ["Far reports", "Published tracks too far from their target to count in the errors"]],
  ["outsiders_now", ["Outsiders now", "Entities of other simulators that the sensors see"]],
]);

/** Words for a measure, and a hint. */
function measureName(name) {
  const known = MEASURES.get(name);
  if (known) return known;
  const [what, ...rest] = name.split("_");
  const sensor = rest.join(" ").toUpperCase();
  if (what === "pd") return [`Detected by ${sensor}`, "Looks at a target that gave a plot, of all looks"];
  if (what === "plots") return [sensor === "OTHER" ? "Plots but of radar and GPS" : `Plots of ${sensor}`, ""];
  return [name.replaceAll("_", " "), ""];
}

/** Plots of each sensor in the scan shown, and the measures of the run. */
function showSensors(box, { scan, sensors, measures, tookUs }) {
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

function measure(name, value) {
  if (!Number.isFinite(value)) return NONE;
  if (name.startsWith("pd")) return `${fixed(100 * value, 1)} %`;
  if (name.endsWith("_m")) return `${fixed(value, 2)} m`;
  return Number.isInteger(value) ? String(value) : fixed(value, 3);
}

export default {
  key: "sensors",
  title: "Sensors",
  make(section, { state }) {
    const box = element("div", [], { id: "sensors" });
    section.append(box);
    const show = () => showSensors(box, {
      scan: state.scan, sensors: state.airport?.sensors ?? [], measures: state.timeline?.measures, tookUs: state.timeline?.took_us,
    });
    return { show, needs: ["scan"] };
  },
};
