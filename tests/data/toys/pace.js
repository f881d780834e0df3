// A toy panel: who moves fastest in the scan shown.

import { speedKt } from "../lists.js";
import { element, fixed } from "../text.js";

export default {
  key: "pace",
  title: "Pace",
  make(section, page) {
    const list = element("ol", [], { id: "pace" });
    section.append(list);
    const show = () => {
      const fastest = [...page.targets()].sort((a, b) => speedKt(b) - speedKt(a)).slice(0, 10);
      list.replaceChildren(...fastest.map((t) => element("li", `${t.callsign || t.id} ${fixed(speedKt(t), 0)} kt`)));
    };
    return { show, needs: ["scan"] };
  },
};
