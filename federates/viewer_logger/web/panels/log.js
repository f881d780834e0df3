// Log: what operators did.

import { element, elapsed } from "../text.js";

function showOperations(list, operations) {
  if (!operations.length) {
    list.replaceChildren(element("li", "No operator action yet.", { class: "empty" }));
    return;
  }
  list.replaceChildren(...[...operations].reverse().map((o) => element("li", [
    element("time", elapsed(o.time_ns / 1e9)), element("b", o.command), element("span", o.source, { class: "source" }),
    element("span", o.text, { "data-mark": o.ok ? "" : "warn" }),
  ])));
}

export default {
  key: "log",
  title: "Log",
  make(section, { state }) {
    const list = element("ol", [], { id: "operations" });
    section.append(list);
    return { show: () => showOperations(list, state.operations), needs: ["operations"] };
  },
};
