// What if, from here: the run shown again from the time shown on with something changed, beside its parent. What the dialog asks
// for is a pure function; the server makes the fork.

import { element, elapsed } from "./text.js";

/** Key and value of every change that the fields name: { filter, off, rain, visibility, seed, key, value }, texts, empty where nothing is asked. */
export function changesOf({ filter, off, rain, visibility, seed, key, value }) {
  const changes = [];
  if (filter) changes.push(["tracking.filter", filter]);
  if (off) changes.push([`sensor[${off}].enabled`, "false"]);
  if (rain) changes.push(["weather.rain_factor", rain]);
  if (visibility) changes.push(["weather.visibility_m", visibility]);
  if (seed) changes.push(["run.sensor_seed", seed]);
  if (key && value) changes.push([key, value]);
  return changes;
}

export class WhatIf {
  #id = 0;
  #run = null;

  /** `page` has state, link, open(ids), say({accepted, text}). */
  constructor(button, page) {
    this.page = page;
    this.fields = {};
    const field = (name, title, input) => {
      this.fields[name] = input;
      input.id = `what-if-${name}`;
      return element("p", [element("label", title, { for: input.id }), input]);
    };
    const text = (attributes) => element("input", [], { autocomplete: "off", maxlength: "60", ...attributes });
    this.head = element("h2", "What if", { id: "what-if-title" });
    const form = element("form", [
      this.head,
      field("filter", "Another filter", element("select", [])),
      field("off", "Without this sensor", element("select", [])),
      field("rain", "Rain, times", text({ inputmode: "decimal", placeholder: "as it was; 2: doubled" })),
      field("visibility", "Visibility, m", text({ inputmode: "decimal", placeholder: "as it was" })),
      field("seed", "Seed of the sensors", text({ inputmode: "numeric", placeholder: "as it was" })),
      field("key", "Another key", text({ placeholder: "tracking.gate, sensor[NAME].range_max_m" })),
      field("value", "and its value", text({})),
      element("div", [element("button", "Cancel", { type: "button" }), element("button", "Make it", { type: "submit" })], { class: "buttons" }),
    ], { method: "dialog" });
    this.dialog = element("dialog", [form], { id: "what-if-dialog", "aria-labelledby": "what-if-title" });
    form.querySelector("button[type=button]").addEventListener("click", () => this.dialog.close());
    form.addEventListener("submit", () => this.#ask());
    document.body.append(this.dialog);
    this.told = element("span", "", { role: "status" });
    this.stop = element("button", "Cancel the fork", { type: "button", hidden: "" });
    this.stop.addEventListener("click", () => page.link.send({ type: "cancel" }));
    this.line = element("div", [this.told, this.stop], { id: "what-if-told", hidden: "" });
    document.getElementById("views").append(this.line);
    button.addEventListener("click", () => this.show());
  }

  show() {
    const { state } = this.page, choice = (select, none, names) => select.replaceChildren(element("option", none, { value: "" }), ...names.map((name) => element("option", name, { value: name })));
    this.head.textContent = `What if, from ${elapsed(state.scan?.timeS ?? 0)} on`;
    choice(this.fields.filter, "as it was", state.filters ?? []);
    choice(this.fields.off, "all of them", (state.airport?.sensors ?? []).map((s) => s.name).filter(Boolean));
    for (const name of ["rain", "visibility", "seed", "key", "value"]) this.fields[name].value = "";
    this.dialog.showModal();
  }

  #ask() {
    const { state, link, say } = this.page, wished = Object.fromEntries(Object.entries(this.fields).map(([name, input]) => [name, input.value.trim()]));
    const changes = changesOf(wished), run = state.shownRuns[0];
    if (!changes.length) return say({ accepted: false, text: "nothing was changed: the fork would be the run itself" });
    this.#id = Math.floor(Math.random() * 2 ** 31);
    this.#run = run;
    if (!link.send({ type: "fork", id: this.#id, run, at_s: state.scan?.timeS ?? 0, changes })) say({ accepted: false, text: "no connection: ask again" });
  }

  /** What became of a fork; only who asked for it sees it opened. */
  take({ id, state, text, run }) {
    if (id !== this.#id) return;
    this.state = { state, text, run };
    this.line.hidden = false;
    this.line.dataset.state = state;
    this.stop.hidden = state !== "running";
    this.told.textContent = `Fork: ${text}${state === "running" ? " \u2026" : ""}`;
    if (state === "done") this.page.open([this.#run, run]);
    if (state !== "running") this.#run = null;
  }
}
