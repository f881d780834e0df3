// Controllers' seats: take one, clear who waits by click or by key, see what is read back and said on the frequencies.

import { MEANS } from "../line.js";
import { saysOf, Seats } from "../seat.js";
import { element, elapsed } from "../text.js";

export default {
  key: "seats",
  title: "Seats",
  make(section, page) {
    const { state } = page;
    const seats = new Seats(page.link, () => {
      show();
      page.showStrips();
    });
    page.seats = seats;
    let selected = null, text = "";
    const name = element("input", [], { id: "person", maxlength: "32", autocomplete: "off", spellcheck: "false" });
    name.value = seats.person;
    name.addEventListener("change", () => {
      seats.rename(name.value);
      name.value = seats.person;
    });
    const list = element("ul", [], { class: "seat-list" }), answer = element("p", "", { role: "status", class: "seat-answer" });
    const question = element("input", [], { id: "what-if-line", maxlength: "48", autocomplete: "off", spellcheck: "false", placeholder: "SWR1A HOLD 120" });
    const ask = element("form", [element("label", "What if", { for: "what-if-line" }), question, element("button", "Look ahead", { type: "submit" })], { class: "pair" });
    ask.title = "HOLD and seconds, STAND and its name, or RUNWAY and its end; without a call sign for the selected flight. Flown 15 minutes ahead from what is seen; nothing is done.";
    ask.addEventListener("submit", async (event) => {
      event.preventDefault();
      if (await seats.whatIf(question.value, state.flights.map((f) => f.callsign), selected)) question.value = "";
    });
    const ahead = element("div", [], { class: "what-if" });
    const advised = element("div", []), waits = element("div", []), chosen = element("div", []), radio = element("ol", [], { class: "radio", "aria-label": "Frequencies" });
    const none = element("p", "In this run nobody can sit down: the scene needs traffic that behaves and [control] sees = \"truth\", or sees = \"tracks\" with controllers = \"model\".", { class: "empty" });
    const body = element("div", [
      element("p", [element("label", "You are ", { for: "person" }), name], { class: "pair" }), list, answer, chosen, advised, waits, ask, ahead, element("h3", "Radio"), radio,
    ]);
    const box = element("div", [none, body], { id: "seats", class: "seats" });
    section.append(box);
    body.hidden = true;

    const button = (key, callsign, p) => {
      const words = [key ? element("kbd", key) : null, element("span", `${callsign} `, { class: "hidden" }), `${p.clearance} `, element("small", MEANS.get(p.clearance) ?? "")];
      const made = element("button", words, { type: "button", "data-clear": `${callsign} ${p.clearance}` });
      made.addEventListener("click", () => seats.clear(p.seat, callsign, p.clearance));
      return made;
    };
    const seatRow = (seat) => {
      const mine = seat.by === seats.person, act = element("button", mine ? "Give up" : "Take", { type: "button", "data-seat": seat.name, "aria-label": `${mine ? "Give up" : "Take"} ${seat.name}` });
      act.disabled = Boolean(seat.by) && !mine;
      act.addEventListener("click", () => seats.act(seat.name, mine ? "leave" : "take"));
      return element("li", [act, element("b", seat.name), element("span", mine ? "you" : seat.by ?? "model"), element("span", seat.wants.length ? `${seat.wants.length} waiting` : "")], { "data-mine": String(mine) });
    };

    // What the planner advises: whoever has the seat decides, else the model there has.
    const advice = (a, mine) => {
      const decide = (action, words) => {
        const made = element("button", words, { type: "button", "data-clear": `${a.subjects} ${action}`, "aria-label": `${words}: ${a.text}` });
        made.disabled = a.decision === (action === "accept" ? "accepted" : "refused");
        made.addEventListener("click", () => seats.act(a.seat, action, { callsign: a.subjects.split(" ")[0], clearance: a.kind }));
        return made;
      };
      const look = () => {
        const made = element("button", "What if", { type: "button", "data-clear": `${a.subjects} what-if`, "aria-label": `What if ${a.subjects.split(" ")[0]} ${a.what_if}` });
        made.addEventListener("click", () => seats.act(seats.own()[0], "what-if", { callsign: a.subjects.split(" ")[0], clearance: a.what_if }));
        return made;
      };
      const stands = element("span", a.decision === "open" ? "open" : `${a.decision} by ${a.by_person ? "a person" : "the model"}`);
      const says = element("p", [`${a.seat}: ${a.text}. `, element("small", `Otherwise it ${a.otherwise}.`)]);
      return element("li", [says, element("p", [...(mine ? [decide("accept", "Accept"), decide("refuse", "Refuse")] : []), ...(seats.own().length && a.what_if ? [look()] : []), stands], { class: "pair" })]);
    };

    // What was asked and what came of it: measures without and with, and whose end moves.
    const foreseen = (q) => {
      const title = element("h4", `${q.callsign} ${q.change}, at ${elapsed(q.at_s)}`), a = q.answer;
      if (!a) return [title, element("p", "is worked out …")];
      if (a.refused) return [title, element("p", a.refused, { "data-mark": "warn" })];
      const row = (cells) => element("tr", cells.map((c, i) => element(i ? "td" : "th", c, i ? {} : { scope: "row" })));
      const number = (x, unit) => `${x}${unit ? ` ${unit}` : ""}`;
      const clock = (s) => (s == null ? `not within ${a.ahead_s / 60} min` : elapsed(s));
      const head = (cells) => element("tr", cells.map((c) => element("th", c, { scope: "col" })));
      const changed = a.measures.filter((m) => m.without !== m.with);
      const table = (rows) => element("table", [element("thead", [head(["", "as it is", "if"])]), element("tbody", rows)]);
      const rows = [...changed.map((m) => row([m.words, number(m.without, m.unit), number(m.with, m.unit)])), ...a.flights.map((f) => row([`${f.callsign} ${f.end}`, clock(f.without_s), clock(f.with_s)]))];
      const missing = [...a.unseen.map((c) => `${c} is not seen`), ...a.left_out.map((c) => `${c} fits into no plan`)];
      return [title, rows.length ? table(rows) : element("p", "Nothing changes within the time looked ahead."), missing.length ? element("p", `Without: ${missing.join(", ")}.`) : null];
    };

    /** Made again where something changed, with the focus where it was. */
    function show() {
      const now = seats.state, at = state.scan?.timeS ?? now?.time_s, next = now?.radio.filter((m) => m.time_s > at).length;
      const made = JSON.stringify([now && { ...now, time_s: 0 }, next, seats.person, seats.answer, selected]);
      if (made === text) return;
      text = made;
      none.hidden = Boolean(now);
      body.hidden = !now;
      if (!now) return;
      const focus = document.activeElement?.dataset ?? {}, own = seats.own();
      name.disabled = own.length > 0;
      list.replaceChildren(...now.seats.map(seatRow));
      answer.textContent = seats.answer?.text ?? "";
      answer.dataset.mark = seats.answer && !seats.answer.accepted ? "warn" : "";
      const options = seats.mine(selected);
      chosen.replaceChildren(...(selected && own.length ? [element("h3", `Selected: ${selected}`), element("p", options.length ? options.map((p) => button("", selected, p)) : "nothing can be said to it now", { class: "pair" })] : []));
      const asked = now.seats.filter((s) => own.includes(s.name)).flatMap((s) => s.wants.map((w) => ({ ...w, seat: s.name })));
      asked.sort((a, b) => a.since_s - b.since_s);
      const rows = asked.map((w, i) => {
        const told = now.pending.find((p) => p.callsign === w.callsign);
        const act = told ? element("span", `${told.clearance} said; reads back, begins about ${elapsed(told.until_s)}`, { class: "told" }) : button(i < 9 ? String(i + 1) : "", w.callsign, w);
        return element("li", [element("b", w.callsign), element("span", `since ${elapsed(w.since_s)}`), act]);
      });
      waits.replaceChildren(...(own.length ? [element("h3", `Waiting for you (${asked.length})`), rows.length ? element("ul", rows, { class: "waiting" }) : element("p", "Nobody waits.", { class: "empty" })] : []));
      const told = now.advice ?? [];
      advised.replaceChildren(...(told.length ? [element("h3", `Advice (${told.length})`), element("ul", told.map((a) => advice(a, own.includes(a.seat))), { class: "advice" })] : []));
      ask.hidden = own.length === 0;
      ahead.replaceChildren(...(now.what_if ?? []).filter((q) => q.person === seats.person).reverse().flatMap(foreseen).filter(Boolean));
      radio.replaceChildren(...[...now.radio].reverse().slice(0, 16).map((m) => element("li", [
        element("time", elapsed(m.time_s)), element("b", m.from), element("span", saysOf(m)), element("span", m.time_s > at ? `${m.to} (to come)` : m.to),
      ], { "data-next": m.time_s > at ? "" : null })));
      const again = focus.clear ? `[data-clear="${CSS.escape(focus.clear)}"]` : focus.seat ? `[data-seat="${CSS.escape(focus.seat)}"]` : null;
      // A strip of the list beside keeps its own focus.
      if (again && !box.contains(document.activeElement) && document.activeElement === document.body) (box.querySelector(again) ?? box.querySelector("button"))?.focus();
    }

    // Digits give what the first nine wait for, while the panel has the keyboard.
    section.addEventListener("keydown", (event) => {
      if (event.target.matches("input")) {
        event.stopPropagation();
        return;
      }
      if (event.ctrlKey || event.altKey || event.metaKey || !/^[1-9]$/.test(event.key)) return;
      const act = [...waits.querySelectorAll("button")].find((b) => b.querySelector("kbd")?.textContent === event.key);
      event.preventDefault();
      event.stopPropagation();
      act?.click();
    });

    return {
      show,
      scan: () => !section.hidden && show(),
      take: { seats: (message) => seats.take(message.state), new_run: () => seats.take(null) },
      selected(_, callsign) {
        selected = callsign;
        show();
      },
    };
  },
};
