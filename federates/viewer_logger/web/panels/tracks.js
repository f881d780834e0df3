// Targets: every track, and every target that no track follows.

import { headingDeg, speedKt, Table } from "../lists.js";
import { element, fixed, NONE } from "../text.js";

const COLUMNS = [
  { key: "callsign", title: "Call sign", read: (t) => t.callsign || `#${t.number}`, mark: (t) => (t.number === undefined ? "truth" : t.movement || t.type) },
  { key: "number", title: "Trk", hint: "Track number", read: (t) => t.number ?? null, show: (t) => (t.number === undefined ? NONE : String(t.number)), number: true },
  { key: "type", title: "Type", read: (t) => t.designator, show: (t) => (t.wake ? `${t.designator}/${t.wake}` : t.designator || NONE) },
  { key: "speed", title: "kt", hint: "Ground speed, knots", read: speedKt, show: (t) => fixed(speedKt(t), 0), number: true },
  { key: "heading", title: "Hdg", hint: "Course over ground, degrees", read: headingDeg, show: (t) => (Number.isFinite(t.heading) ? String(Math.round(headingDeg(t)) % 360).padStart(3, "0") : NONE), number: true },
  { key: "error", title: "Err m", hint: "Distance from truth, metres", read: (t) => t.errorM ?? null, show: (t) => (t.errorM === undefined || t.errorM === null ? NONE : fixed(t.errorM, 1)), number: true },
  { key: "status", title: "State", read: (t) => t.status ?? "no track", mark: (t) => t.status ?? "missing" },
];

export default {
  key: "tracks",
  title: "Targets",
  make(section, page) {
    const table = element("table", [element("caption", "Targets: tracks and truth without a track", { class: "hidden" }), element("thead"), element("tbody")], { id: "tracks" });
    section.append(table);
    const list = new Table(table, COLUMNS, { id: (t) => t.id, onSelect: page.select, sortBy: "callsign" });
    return {
      scan: () => list.show(page.targets()),
      selected: (id) => list.select(id),
      /** Ids in the order shown. */
      order: () => list.order(),
    };
  },
};
