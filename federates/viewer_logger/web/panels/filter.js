// Filter: the run's own, and the dial over all the others.

import { Dial } from "../dial.js";
import { duration, facts } from "../lists.js";
import { element, fixed } from "../text.js";

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
    const box = element("div", [], { id: "filter" }), dialBox = element("div", [], { id: "dial-box" });
    section.append(box, dialBox);
    const dial = new Dial(dialBox, { send: (message) => link.send(message) });
    return {
      show() {
        showRun(box, { measures: state.timeline?.measures, tookUs: state.timeline?.took_us });
        dial.draw();
      },
      needs: ["rungs"],
      take: {
        rungs(message) {
          state.rungs = message;
          dial.show(message);
          map.ghost = message.ghost ?? null;
          map.need("traffic");
        },
      },
    };
  },
};
