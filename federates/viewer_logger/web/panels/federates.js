// Federates: one card each.

import { duration, facts } from "../lists.js";
import { bytes, element, fixed, NONE } from "../text.js";

/** What gives the place of a member to the process of another one; nothing where it cannot be given, or to nobody. */
function mover(m, members, give) {
  const others = m?.movable ? members.filter((o) => o.movable && (o.host !== m.host || o.pid !== m.pid)) : [];
  if (!others.length) return [];
  const choice = element("select", [
    element("option", "Move to the process of \u2026", { value: "" }),
    ...others.map((o) => element("option", o.name, { value: o.name })),
  ], { class: "mover", "aria-label": `Give the place of ${m.name} to another process` });
  choice.addEventListener("change", () => choice.value && give(m.name, choice.value));
  return [choice];
}

/** One card a federate. */
function showFederates(box, federates, members, over, give) {
  // A list that is open, or has the keyboard, is left as it is.
  if (box.contains(document.activeElement) && document.activeElement.matches("select")) return;
  const names = [...new Set([...members.map((m) => m.name), ...federates.map((f) => f.name)])].sort();
  if (!names.length) {
    box.replaceChildren(element("p", over ? "What the federates reported was shown while the run went on; its log keeps it in the table federates." : "No federate has reported yet.", { class: "empty" }));
    return;
  }
  box.replaceChildren(...names.map((name) => {
    const f = federates.find((x) => x.name === name) ?? {}, m = members.find((x) => x.name === name);
    const alive = m ? m.alive : true;
    const dropped = (f.dropped ?? []).reduce((sum, d) => sum + d[1], 0);
    const list = element("dl", [], { class: "facts" });
    facts(list, [
      ["Frame", String(f.frame ?? m?.frame ?? NONE)],
      ["PDUs in", f.in_per_s === null || f.in_per_s === undefined ? String(f.pdus_in ?? NONE) : `${fixed(f.in_per_s, 0)} /s`],
      ["PDUs out", f.out_per_s === null || f.out_per_s === undefined ? String(f.pdus_out ?? NONE) : `${fixed(f.out_per_s, 0)} /s`],
      ["Lost", String(f.lost ?? NONE), f.lost > 0 ? "warn" : ""],
      ["Repaired", String(f.repaired ?? NONE)],
      ["Refused", f.dropped ? String(dropped) : NONE, dropped ? "warn" : ""],
      ["Step", duration(f.exec_us), "", "Computing one frame, mean"], ["Longest", duration(f.exec_max_us), "", "The longest frame so far"],
      ["Latency", duration(m?.latency_us), "", "From the conductor's order for a frame to this federate's answer"],
      ["CPU", Number.isFinite(f.cpu_pct) ? `${fixed(f.cpu_pct, 0)} %` : NONE],
      ["Memory", bytes(f.rss_bytes)],
    ]);
    const where = [(f.host || m?.host) && `host ${f.host || m?.host}`, (f.pid || m?.pid) && `process ${f.pid || m?.pid}`].filter(Boolean).join(", ");
    const reasons = (f.dropped ?? []).map(([why, n]) => `${n} \u00d7 ${why}`).join("; ");
    return element("article", [
      element("h3", [element("i", "", { class: "dot", "data-mark": alive ? "good" : "bad" }), name,
        element("small", alive ? (m && !m.essential ? "spectator" : "") : "not heard")]),
      element("p", [where, reasons && ` \u2013 refused: ${reasons}`].filter(Boolean), { class: "where" }),
      list,
      ...mover(m, members, give),
    ], { class: "card", "data-name": name });
  }));
}

export default {
  key: "federates",
  title: "Federates",
  make(section, { state, operate }) {
    const box = element("div", [], { id: "federates" });
    section.append(box);
    const give = (name, to) => {
      document.activeElement?.blur();
      operate({ command: "move", name, to });
    };
    const show = () => showFederates(box, state.federates, state.runState?.members ?? [], state.timeline?.live === false, give);
    return { show, needs: ["federates", "state"] };
  },
};
