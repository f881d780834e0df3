// The panels beside the map: a file each in `panels/`, and a line each here, in the order of their tabs.
//
// A panel's file exports { key, title, make(section, page) }. `make` fills its section once and gives what the page calls, each
// of them where it is there: `show()` when the panel is looked at and something it needs has come, `needs` the kinds of messages after
// which to show ("scan" is the picture of a scan), `take` a function for each kind of message, `scan()` after every picture,
// looked at or not, `selected(id, callsign)`. `page` has state, map, link, operate(command), select(id), selectedNumber(), targets().

import { element } from "./text.js";

const FILES = [
  "tracks",
  "strips",
  "seats",
  "drive",
  "effects",
  "filter",
  "flights",
  "federates",
  "sensors",
  "log",
];

const PANELS = (await Promise.all(FILES.map((file) => import(`./panels/${file}.js`)))).map((module) => module.default);

/** The panels on the page: tabs into `tabs`, sections behind it. `onTab(key)` is told which one is looked at. */
export function panels(tabs, page, onTab) {
  const sections = new Map(), made = new Map();
  let looked = null;
  for (const { key, title, make } of PANELS) {
    const tab = element("button", title, { type: "button", role: "tab", id: `tab-${key}`, "aria-controls": `panel-${key}`, "data-tab": key });
    tab.addEventListener("click", () => {
      showTab(key);
      // On a phone the panel lies under what sticks to the foot: it comes up below the tabs.
      if (matchMedia("(max-width: 900px)").matches) tabs.scrollIntoView({ block: "start" });
    });
    tab.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key], list = [...tabs.children].filter((t) => t.offsetParent);
      if (!step || event.ctrlKey || event.altKey) return;
      list[(list.indexOf(tab) + step + list.length) % list.length].focus();
      event.preventDefault();
      event.stopPropagation();
    });
    tabs.append(tab);
    const section = element("section", [], { class: "panel", id: `panel-${key}`, role: "tabpanel", "aria-labelledby": `tab-${key}`, tabindex: "0" });
    section.hidden = true;
    tabs.parentElement.append(section);
    sections.set(key, section);
    made.set(key, make(section, page));
  }

  function showTab(key) {
    if (!made.has(key)) return;
    looked = key;
    for (const [other, section] of sections) {
      section.hidden = other !== key;
      document.getElementById(`tab-${other}`).setAttribute("aria-selected", String(other === key));
    }
    onTab(key);
    made.get(key).show?.();
  }

  return {
    showTab,
    /** Whether a panel is looked at. */
    isShown: (key) => looked === key,
    /** Something of this kind has come: who needs it and is looked at shows it. */
    came(kind, message) {
      for (const [key, panel] of made) {
        if (message) panel.take?.[kind]?.(message);
        if (key === looked && panel.needs?.includes(kind)) panel.show();
      }
    },
    scan: () => made.forEach((panel) => panel.scan?.()),
    selected(id, callsign) {
      made.forEach((panel) => panel.selected?.(id, callsign));
      made.get(looked)?.show?.();
    },
    /** The row of a flight in the flight data list. */
    flight: (callsign) => made.get("flights").selected(null, callsign),
    /** Targets in the order of their list. */
    order: () => made.get("tracks").order(),
  };
}
