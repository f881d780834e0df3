// Filter: the run's own, and the dial over all the others.

import { Dial } from "../dial.js";
import { duration, facts } from "../lists.js";
import { element, fixed } from "../text.js";
import { TolerancePart } from "../tolerance.js";

/** The error of the run's own filter, and its time. */
function showRun(box, { measures, tookUs }) {
  const read = (name) => measures?.find(([n]) => n === name)?.[1];
  const list = element("dl", [], { class: "facts" });
  facts(list, [["Error of the tracks", `${fixed(read("rmse_m"), 2)} m`], ["of the plots", `${fixed(read("raw_rmse_m"), 2)} m`], ["Scan took", duration(tookUs)]]);
  box.replaceChildren(element("h3", "The run"), list);
}

export default {
  key: "filter",
  title: "Filter",
  make(section, { state, map, link }) {
    const box = element("div", [], { id: "filter" }), dialBox = element("div", [], { id: "dial-box" }), effectsBox = element("div", [], { id: "tolerance-box" });
    section.append(box, dialBox, effectsBox);
    const send = (message) => link.send(message), ghosts = { rungs: [], tolerances: [] };
    // One ghost at a time: who is chosen last.
    const dial = new Dial(dialBox, { send, chosen: () => tolerance.release() });
    const tolerance = new TolerancePart(effectsBox, { send, chosen: () => dial.release() });
    const ghost = (of, places) => {
      ghosts[of] = places ?? [];
      map.ghost = [...ghosts.rungs, ...ghosts.tolerances];
      map.need("traffic");
    };
    return {
      show() {
        showRun(box, { measures: state.timeline?.measures, tookUs: state.timeline?.took_us });
        dial.draw();
        tolerance.draw();
      },
      needs: ["rungs", "tolerances"],
      take: {
        rungs(message) {
          state.rungs = message;
          dial.show(message);
          ghost("rungs", message.ghost);
        },
        tolerances(message) {
          state.tolerances = message;
          tolerance.show(message);
          ghost("tolerances", message.ghosts_m);
        },
      },
    };
  },
};
