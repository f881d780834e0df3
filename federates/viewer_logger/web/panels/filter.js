// Filter: the run's own, and the dial over all the others.

import { Dial } from "../dial.js";
import { duration, facts } from "../lists.js";
import { element, fixed, NONE } from "../text.js";
import { TolerancePart } from "../tolerance.js";

/** The error of the run's own filter, and its time. */
function showRun(box, { measures, tookUs, over }) {
  const read = (name) => measures?.find(([n]) => n === name)?.[1], metres = (name) => (Number.isFinite(read(name)) ? `${fixed(read(name), 2)} m` : NONE);
  const list = element("dl", [], { class: "facts" });
  facts(list, [["Error of the tracks", metres("rmse_m")], ["of the plots", metres("raw_rmse_m")], ["Scan took", duration(tookUs)]]);
  const parts = [element("h3", "The run"), list];
  if (over) parts.push(element("p", "Of this finished run all filters and tolerances are compared on its own plots and truth, over the two minutes before the time shown. What if (beside the time line) makes another run from there on, with any of them.", { class: "where" }));
  box.replaceChildren(...parts);
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
        const over = state.timeline?.live === false;
        showRun(box, { measures: state.timeline?.measures, tookUs: state.timeline?.took_us, over });
        dial.draw();
        tolerance.draw();
      },
      needs: ["rungs", "tolerances", "timeline"],
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
