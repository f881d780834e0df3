// What people drive: take a vehicle, drive it by keyboard or gamepad, see its speed and what is wrong, give it up.

import { radioOf } from "../seat.js";
import { clearanceFacts } from "../strips.js";
import { element, elapsed } from "../text.js";
import { KEYS, PAD, paintDriven, speedOf, warningsOf, Wheel } from "../wheel.js";

const rows = (list) => list.map(([key, does]) => element("tr", [element("th", key, { scope: "row" }), element("td", does)]));

export default {
  key: "drive",
  title: "Drive",
  make(section, page) {
    const { state, map } = page;
    let refused = "", text = "", heardText = "", follow = true;
    const wheel = new Wheel(page.link, {
      changed: () => show(),
      rate: () => (state.live && state.runState?.phase === "RUNNING" ? state.runState.achieved_rate || 0 : 0),
      refused: (why) => (refused = why),
    });
    const none = element("p", "Nothing can be driven in this run: the scene needs a [[traffic]] of kind \"driven\" beside traffic that behaves, or [control] by_hand = true.", { class: "empty" });
    const list = element("ul", [], { class: "seat-list" }), answer = element("p", "", { role: "status", class: "seat-answer", "data-mark": "warn" });
    const speed = element("b", ""), wheels = element("span", ""), says = element("p", "", { role: "status", class: "seat-answer", "data-mark": "warn" });
    const wheelBox = element("div", [element("p", [speed, " ", wheels]), says], { id: "wheel", class: "wheel", role: "group", tabindex: "0", "aria-label": "Wheel: keys drive while this has the focus" });
    const following = element("input", [], { type: "checkbox", id: "drive-follow" });
    following.checked = follow;
    following.addEventListener("change", () => (follow = following.checked));
    const view = element("a", "View from its seat", { target: "_blank", rel: "noopener", href: "eye" });
    const told = element("dl", [], { class: "told" }), radio = element("ol", [], { class: "radio", "aria-label": "Radio" });
    const heard = element("div", [element("h3", "Cleared, and on the radio"), told, radio], { hidden: "" });
    const at = element("div", [
      wheelBox, element("p", [element("label", [following, " map follows it"], { for: "drive-follow" }), " ", view], { class: "pair" }), heard,
      element("h3", "Keys, while the box above has the focus (Esc leaves it)"),
      element("table", rows([...KEYS.map(([, , key, does]) => [key, does]), ["P", "parking brake"]]), { class: "keys" }),
      element("h3", "Gamepad"), element("table", rows(PAD), { class: "keys" }),
    ]);
    section.append(element("div", [none, list, answer, at], { id: "drive", class: "seats" }));

    const row = (m) => {
      const mine = m.seat === wheel.mine;
      const act = element("button", mine ? "Give up" : "Take", { type: "button", "data-seat": m.seat, "aria-label": `${mine ? "Give up" : "Take"} ${m.seat}` });
      act.disabled = m.taken && !mine;
      act.addEventListener("click", async () => {
        refused = "";
        await (mine ? wheel.leave() : wheel.sit(m.seat));
        if (wheel.mine) wheelBox.focus();
      });
      return element("li", [act, element("b", m.callsign), element("span", mine ? "you" : m.taken ? "a person" : m.flight ? "itself, taxies" : "nobody")], { "data-mine": String(mine) });
    };

    function show() {
      const own = wheel.own(), told = wheel.state?.movers ?? [];
      const free = wheel.flights.filter((seat) => !told.some((m) => m.seat === seat)).map((seat) => ({ seat, callsign: seat.replace("pilot ", ""), taken: false, flight: true }));
      const movers = [...told, ...free];
      state.driven = movers.length ? { mine: wheel.mine, movers: wheel.movers(), flights: wheel.flights } : null;
      map.driven = movers.length ? { paint: (g) => paintDriven(g, map, wheel) } : null;
      if (section.hidden) return;
      const made = JSON.stringify([movers.map((m) => [m.seat, m.taken]), wheel.mine]);
      none.hidden = movers.length > 0;
      if (made !== text) {
        text = made;
        const focus = document.activeElement?.dataset?.seat;
        list.replaceChildren(...movers.map(row));
        if (focus) list.querySelector(`[data-seat="${CSS.escape(focus)}"]`)?.focus();
      }
      if (answer.textContent !== refused) answer.textContent = refused;
      at.hidden = !own;
      if (!own) return;
      view.href = `eye#eye=${own.aircraft ? "pilot" : "driver"}:${encodeURIComponent(own.callsign)}`;
      speed.textContent = speedOf(own);
      hear(own);
      const degrees = Math.round((own.steer_rad * 180) / Math.PI);
      wheels.textContent = degrees ? `wheels ${Math.abs(degrees)}\u00b0 ${degrees < 0 ? "left" : "right"}` : "wheels straight";
      const words = [...warningsOf(own, wheel.parked), state.live ? "" : "the page shows the past: End goes to now"].filter(Boolean).join("; ");
      if (says.textContent !== words) says.textContent = words;
    }

    /** What the pilot of a flight is cleared for, what it waits for, and what is said to it and by it. */
    function hear(own) {
      const facts = clearanceFacts(own, state.traffic).filter(([name]) => ["Cleared", "Why", "May drive"].includes(name));
      const said = radioOf(page.seats?.state, own.callsign);
      heard.hidden = !facts.length && !said.length;
      const made = JSON.stringify([facts, said]);
      if (made === heardText) return;
      heardText = made;
      told.replaceChildren(...facts.flatMap(([name, value, mark]) => [element("dt", name), element("dd", value, { "data-mark": mark ?? "" })]));
      radio.replaceChildren(...said.map((m) => element("li", [element("time", elapsed(m.time_s)), element("b", m.from), element("span", m.says), element("span", m.to)])));
    }

    /** While somebody drives, the map is drawn as often as it can be; it follows one's own mover. */
    function frame() {
      const own = wheel.own();
      if (own && state.live) {
        if (follow) {
          map.touched = true;
          map.look({ cx: own.at_m[0], cy: own.at_m[1], scale: Math.max(map.view.scale, 1.5) });
          // It never comes to rest: at another scale it is drawn again while it moves.
          if (map.ground.cam?.scale !== map.cam.scale && !map.busy) map.need("ground", "place");
        }
        show();
      }
      if (wheel.state?.movers.some((m) => m.speed_mps || m.seat === wheel.mine)) map.dirty();
      requestAnimationFrame(frame);
    }
    requestAnimationFrame(frame);

    wheelBox.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || event.key === "Tab") return;
      if (event.key === "Escape") wheelBox.blur();
      else if (!wheel.key(event.key, true)) return;
      event.preventDefault();
      event.stopPropagation();
    });
    wheelBox.addEventListener("keyup", (event) => {
      if (wheel.key(event.key, false)) event.stopPropagation();
    });
    wheelBox.addEventListener("blur", () => wheel.held.clear());

    return { show, take: { driven: (message) => wheel.take(message.state), new_run: () => wheel.take(null) } };
  },
};
