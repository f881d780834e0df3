// The list of runs: which ones are shown on one clock.

import { element } from "./text.js";

const byId = (id) => document.getElementById(id);

/** Whether the first of the runs shown, which tells the time, is another one than before. */
export const otherFirst = (before, shown) => before.length > 0 && before[0] !== shown[0];

/** What was said of the run shown is of that run alone: another one, or one that begins again, says it anew. */
export function forgetSaid({ state, map, alerts }) {
  state.traffic = null;
  alerts.forget();
  map.setSaid({ alerts: [], traffic: null, lights: null });
  map.setForeign([]);
}

/** What was selected is looked for by its name in another run: the number of its track is that of somebody else there. */
export function selectAgain({ state, select }) {
  const name = state.selected && state.callsign;
  select(null);
  if (name) state.wish.sel = name;
}

/** `page` has state, link, forgetStrip() and changed(). */
export function runList({ state, link, forgetStrip, changed }) {
  function showRuns() {
    const box = byId("runs"), several = state.runs.length > 1;
    box.hidden = !several && state.runs.every((r) => r.live);
    const choice = (run, i) => {
      const input = element("input", [], { type: "checkbox", id: `run-${i}` });
      input.checked = state.shownRuns.includes(run.id);
      input.addEventListener("change", () => {
        const shown = state.runs.map((r) => r.id).filter((id) => (id === run.id ? input.checked : state.shownRuns.includes(id)));
        if (shown.length) openRuns(shown);
        else input.checked = true;
      });
      const words = [run.id, element("small", `${run.title || run.scene}, seed ${run.seed}${run.fork ? `, fork of ${run.fork}` : ""}`)];
      return element("label", [input, ...words], { for: input.id });
    };
    byId("run-list").replaceChildren(...state.runs.map(choice));
    byId("run-names").textContent = state.shownRuns.join(" + ");
  }

  function openRuns(ids) {
    state.wish.run = ids;
    forgetStrip();
    link.send({ type: "open", runs: ids });
    changed();
  }

  return { showRuns, openRuns };
}
