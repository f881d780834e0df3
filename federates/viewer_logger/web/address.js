// Keeps the address in step with the view: reads it at the start and when it changes, writes it at most four times a second.

import { LAYERS } from "./map.js";
import { LAYER_LETTERS, readState, writeState } from "./state.js";

const EVERY_MS = 250;
const STORED = new Set(LAYER_LETTERS.values());

/** A figure as the address holds it. */
const round = (value, digits) => Number(value.toFixed(digits));

export class Address {
  #timer = 0;

  /** `page` has map, time() → {t, ab, play}, tab(), runs(), selected(), apply(state) for all that is not the map's, and say(text). */
  constructor(page) {
    this.page = page;
    this.kept = [];
    this.defaults = defaultLayers();
    // What this page writes itself is no such event; an address it wrote once may come again.
    window.addEventListener("hashchange", () => this.read());
  }

  /** What the address says, applied; what it says wrongly, told. */
  read() {
    const { state, refused, kept } = readState(location.hash);
    this.kept = kept;
    if (refused.length) this.page.say(`The address says ${refused.map((k) => k.slice(0, 16)).join(", ")} in a way that this page does not understand; the rest was taken.`);
    this.apply(state);
  }

  apply(state) {
    const { map } = this.page;
    if (state.col) this.page.colours(state.col);
    if (state.lay) for (const [key] of LAYERS) if (STORED.has(key)) this.page.layer(key, state.lay.includes(key));
    if (state.lod) map.lod = state.lod;
    if (state.vec !== undefined) map.vectorS = state.vec;
    if (state.hist !== undefined) map.dots = state.hist;
    if (state.skin) this.page.skin(state.skin);
    const view = {};
    if (state.x !== undefined) view.cx = state.x;
    if (state.y !== undefined) view.cy = state.y;
    if (state.z !== undefined) view.scale = state.z;
    if (state.rot !== undefined) view.rot = state.rot;
    if (Object.keys(view).length) {
      if ("cx" in view || "cy" in view || "scale" in view) map.touched = true; // turned alone, the airport is still fitted
      map.look(view);
    }
    if (state.fit === "airport") map.fit();
    map.need("ground", "place");
    this.page.apply(state);
  }

  /** The view as the address has it, defaults left out. */
  state() {
    const { map } = this.page, state = { ...this.page.state() };
    if (map.touched) Object.assign(state, { x: round(map.view.cx, 1), y: round(map.view.cy, 1), z: round(Math.max(0.02, map.view.scale), 4) });
    if (map.view.rot) state.rot = round(map.view.rot, 2);
    const on = LAYERS.map(([key]) => key).filter((key) => STORED.has(key) && map.layers[key]).sort();
    if (on.join() !== this.defaults) state.lay = on;
    if (map.follow) state.follow = true;
    if (map.lod !== "auto") state.lod = map.lod;
    if (map.vectorS !== 15) state.vec = map.vectorS;
    if (map.dots !== 30) state.hist = map.dots;
    return state;
  }

  text() {
    return writeState(this.state(), this.kept);
  }

  /** The view changed: written soon; with `push` as a step that the browser's back button undoes. */
  changed(push = false) {
    if (push) return this.#write(true);
    // Written when the view comes to rest: an address that changes with every frame costs more than the frame.
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#write(false), EVERY_MS);
  }

  #write(push) {
    clearTimeout(this.#timer);
    this.#timer = 0;
    const text = this.text();
    if (text === location.hash || (text === "#" && !location.hash)) return;
    if (push) history.pushState(null, "", text);
    else history.replaceState(null, "", text);
  }
}

function defaultLayers() {
  return LAYERS.map(([key]) => key).filter((key) => STORED.has(key) && !["coverage", "detection", "one second ago", "video"].includes(key)).sort().join();
}
