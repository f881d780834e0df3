// The flight data list.

import { Table } from "../lists.js";
import { element, NONE, utc } from "../text.js";

function columns(startNs) {
  const at = (s) => (Number.isFinite(s) ? utc(startNs(), s).slice(0, 5) : NONE);
  return [
    { key: "callsign", title: "Call sign", read: (f) => f.callsign, mark: (f) => f.movement },
    { key: "type", title: "Type", read: (f) => f.type_designator, show: (f) => (f.wake ? `${f.type_designator}/${f.wake}` : f.type_designator) },
    { key: "movement", title: "Mov", hint: "Arrival, departure, vehicle", read: (f) => f.movement, show: (f) => ({ arrival: "ARR", departure: "DEP", vehicle: "VEH" })[f.movement] ?? f.movement },
    { key: "runway", title: "Rwy", read: (f) => f.runway, show: (f) => f.runway || NONE },
    { key: "stand", title: "Stand", read: (f) => f.stand, show: (f) => f.stand.replaceAll("_", " ") || NONE },
    { key: "time", title: "Time", hint: "Estimated arrival or calculated departure, UTC", read: (f) => f.eta_ctd_ns, show: (f) => (f.movement === "vehicle" ? NONE : at(f.eta_ctd_ns / 1e9)), number: true },
    { key: "routing", title: "Routing", read: (f) => (f.routing ?? []).join(" "), show: (f) => (f.routing ?? []).join(" ") || NONE },
  ];
}

export default {
  key: "flights",
  title: "Flights",
  make(section, page) {
    const table = element("table", [element("caption", "Flight data list", { class: "hidden" }), element("thead"), element("tbody")], { id: "flights" });
    section.append(table);
    const pick = (callsign) => {
      const target = page.targets().find((t) => t.callsign === callsign);
      if (target) page.select(target.id);
      list.select(callsign);
    };
    const list = new Table(table, columns(() => page.state.run?.start_utc_ns), { id: (f) => f.callsign, sortBy: "time", onSelect: pick });
    const show = () => list.show(page.state.flights);
    return {
      take: { scene: show, flights: show },
      selected: (_, callsign) => callsign && list.select(callsign),
    };
  },
};
