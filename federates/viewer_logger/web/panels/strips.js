// Strips by bay, of the time shown.

import { element } from "../text.js";

export default {
  key: "strips",
  title: "Strips",
  make(section, page) {
    const box = element("div", [], { id: "strips", class: "strips" });
    section.append(box);
    page.stripBoxes.push(box);
    return { show: page.showStrips };
  },
};
