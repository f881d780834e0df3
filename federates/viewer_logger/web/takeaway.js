// What is taken away from the page: links, bookmarks, pictures, tables.

import { csv, curveRows, json, picture, save, shownRows, targetRows } from "./export.js";
import { keepLocal, readLocal } from "./local.js";
import { elapsed } from "./text.js";

/** `page` has state, map, curve, address() and say({accepted, text}). Gives what the menu calls, and the bookmarks. */
export function takeaway({ state, map, curve, address, say: showAnswer }) {
  const byId = (id) => document.getElementById(id);
  function copyLink() {
    // Who follows the link finds the labels of this moment alone, not where they came from: the same is shown here from now on.
    if (!state.live) map.placeAfresh();
    const link = `${location.origin}${location.pathname}${address().text()}`;
    navigator.clipboard?.writeText(link).then(() => showAnswer({ accepted: true, text: "link copied" }), () => showAnswer({ accepted: false, text: link }));
  }

  const nameOfRun = () => `${state.shownRuns[0] ?? "run"} ${elapsed(state.scan?.timeS).slice(3).replaceAll(":", "-")}`;
  const EXPORTS = {
    link: copyLink,
    png: async () => save(`${nameOfRun()}.png`, await picture(map.canvas, `${byId("title").textContent}   ${byId("utc").textContent}Z   ${elapsed(state.scan?.timeS)}   tracks: filled, truth: outline, error: magenta line`)),
    png2: async () => save(`${nameOfRun()}@2.png`, await picture(map.canvas, `${byId("title").textContent}   ${byId("utc").textContent}Z`, 2)),
    targets: () => save(`${nameOfRun()} targets.csv`, csv(...targetRows(state.scan)), "text/csv"),
    targetsJson: () => save(`${nameOfRun()} targets.json`, json(...targetRows(state.scan)), "application/json"),
    curve: () => save(`${nameOfRun()} curve.csv`, csv(...curveRows(curve.points)), "text/csv"),
    curveJson: () => save(`${nameOfRun()} curve.json`, json(...curveRows(curve.points)), "application/json"),
    table: () => {
      const table = byId(`panel-${state.tab}`).querySelector("table");
      if (table) save(`${nameOfRun()} ${state.tab}.csv`, csv(...shownRows(table)), "text/csv");
      else showAnswer({ accepted: false, text: "this list has no table" });
    },
  };

  /** Ctrl+1 … 9 goes to a bookmark of this scene, with Shift it is set. */
  function bookmark(number, store) {
    const key = `bookmarks ${state.run?.scene}`, all = readLocal(key) ?? {};
    if (store) {
      all[number] = address().text();
      keepLocal(key, all);
      showAnswer({ accepted: true, text: `bookmark ${number} set` });
    } else if (all[number]) location.hash = all[number];
    else showAnswer({ accepted: false, text: `bookmark ${number} is not set (Ctrl+Shift+${number} sets it)` });
  }

  return { EXPORTS, bookmark };
}
