// What the labels of the map wish for: their lines and sizes, how much they matter, and where they must not be.

import { Field } from "./labels.js";
import { designators, scaleBoxes } from "./paint.js";
import { importanceOf, LEVELS, runwayRing } from "./situation.js";
import { BOLD, labelLines, PLAIN } from "./traffic.js";

/** The name under which a label that was dragged is known again. */
export const nameOf = (target) => target.callsign || target.id;

export class Wishes {
  /** Widths of texts by font, measured once. */
  #widths = new Map();
  #field = null;
  #fieldKey = "";

  /** The fonts are others now. */
  forget() {
    this.#widths.clear();
  }

  /** What `place` of labels.js wants to know of a target at a pixel of the map. */
  item(map, target, x, y) {
    const state = map.situation.stateOf(target), chosen = target.id === map.selected, alert = map.alerted.has(target.id);
    const must = chosen || alert || state === "runway" || state === "vehicle on a runway" || state === "airborne";
    const lines = labelLines(target, map.stands.get(target.callsign)), sizes = {};
    let w = this.#width(map.g, BOLD, lines[0]);
    for (let level = 1; level <= 3; level++) {
      if (level > 1 && lines[level - 1]) w = Math.max(w, this.#width(map.g, PLAIN, lines[level - 1]));
      sizes[level] = { w: Math.ceil(w) + 10, h: 19 + 13 * (Math.min(level, lines.length) - 1) };
    }
    const rule = map.lod !== "auto" ? map.lod : map.skin === "controller" ? LEVELS[state] ?? 2 : 3;
    const level = Math.min(chosen || alert ? 3 : rule, lines.length);
    const size = Math.max(target.truth?.lengthM ?? target.lengthM ?? 0, target.truth?.spanM ?? target.spanM ?? 0);
    const reach = map.layers.truth ? Math.max(6, Math.min(60, 0.5 * size * map.cam.scale)) : 6;
    return {
      id: target.id, target, x, y, lines, sizes, level, must, always: chosen || alert, state, reach, standing: state === "parked" || state === "holding",
      importance: importanceOf(target, state, { selected: chosen, alert }), dragged: map.dragged.get(nameOf(target)),
    };
  }

  #width(g, font, text) {
    const key = font + text;
    let w = this.#widths.get(key);
    if (w === undefined) {
      g.font = font;
      w = g.measureText(text).width;
      if (this.#widths.size > 20_000) this.#widths.clear();
      this.#widths.set(key, w);
    }
    return w;
  }

  /** What lies over the map: nothing is read below it. */
  covers({ overlays }, cam) {
    return [...overlays, ...scaleBoxes(cam)];
  }

  /** Where labels must not be: runways with 10 m around, their designators, what lies over the map. */
  field({ airport, overlays }, cam, room) {
    const key = [cam.cx, cam.cy, cam.scale, cam.rot, cam.width, cam.height, airport?.icao, JSON.stringify(overlays)].join();
    if (this.#fieldKey === key) return this.#field;
    const field = new Field(room.x, room.y, room.w, room.h);
    for (const runway of airport?.runways ?? []) {
      field.polygon(runwayRing(runway, 10).map(([x, y]) => cam.toScreen(x, y)));
      for (const [x, y] of designators(cam, runway)) field.box({ x: x - 11, y: y - 9, w: 22, h: 18 });
    }
    for (const box of this.covers({ overlays }, cam)) field.box(box);
    this.#fieldKey = key;
    this.#field = field;
    return field;
  }
}
