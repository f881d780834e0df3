// Colours of the style sheet: red and amber are for alarms.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { between } from "../web/time.js";

const css = readFileSync(new URL("../web/style.css", import.meta.url), "utf8");
const themes = [":root {", ':root[data-colours="day"] {'].map((head) => {
  const body = css.slice(css.indexOf(head)).split("}")[0];
  return Object.fromEntries([...body.matchAll(/--([a-z-]+): (#[0-9a-f]{6})\b/g)].map(([, name, colour]) => [name, colour]));
});

/** CIE L*a*b* of an sRGB colour (D65): lightness, chroma, hue in degrees. */
function lch(hex) {
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  const f = (t) => (t > 216 / 24389 ? Math.cbrt(t) : (24389 / 27 * t + 16) / 116);
  const [x, y, z] = [(0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505, 0.2126 * r + 0.7152 * g + 0.0722 * b, (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089].map(f);
  const [a, c] = [500 * (x - y), 200 * (y - z)];
  return { lightness: 116 * y - 16, chroma: Math.hypot(a, c), hue: ((Math.atan2(c, a) * 180) / Math.PI + 360) % 360 };
}
const apart = (a, b) => Math.abs(((a - b + 540) % 360) - 180);

// A lit stop bar is red as it is outside; an arrival is amber on every position, its shape is no frame.
const AS_IN_THE_WORLD = new Set(["bar", "arrival"]);
const DRAWN = ["ground", "pavement", "pavement-edge", "runway", "runway-mark", "taxi", "taxi-name", "stand", "departure", "vehicle", "unknown", "truth", "error", "rain", "coverage", "select", "video", "bar", "arrival", "plan-exact", "plan-reduced", "plan-skipped", "plan-not-called-for"];

for (const [i, name] of ["night", "day"].entries()) {
  test(`by ${name} nothing on the map but alarms is red or amber`, () => {
    const colours = themes[i], alarms = ["alarm", "information"].map((n) => lch(colours[n]));
    for (const drawn of DRAWN) {
      assert.ok(colours[drawn], drawn);
      const { chroma, hue } = lch(colours[drawn]);
      if (AS_IN_THE_WORLD.has(drawn)) continue;
      assert.ok(chroma < 40 || alarms.every((a) => apart(a.hue, hue) >= 25), `${drawn} ${colours[drawn]}: hue ${hue.toFixed(0)}, chroma ${chroma.toFixed(0)}`);
    }
  });
}

/** A colour as somebody sees it who has no long-wave (0), no middle-wave (1) cones: Viénot, Brettel and Mollon 1999, in linear light. */
function without(cone, hex) {
  const line = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4), back = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
  const [r, g, b] = [1, 3, 5].map((i) => line(parseInt(hex.slice(i, i + 2), 16) / 255));
  const [k, l] = [[0.1124, 0.8876], [0.2928, 0.7072]][cone], yellow = k * r + l * g, blue = cone ? b - 0.0223 * r + 0.0223 * g : b + 0.004 * r - 0.004 * g;
  return `#${[yellow, yellow, blue].map((v) => Math.round(255 * back(Math.min(1, Math.max(0, v)))).toString(16).padStart(2, "0")).join("")}`;
}

for (const [i, name] of ["night", "day"].entries()) {
  test(`by ${name} the heat of errors grows evenly for every eye, stands out where it matters, and is no alarm's colour`, () => {
    const colours = themes[i], steps = Array.from({ length: 11 }, (_, k) => between(colours["heat-low"], colours["heat-high"], k / 10)), alarms = ["alarm", "information"].map((n) => lch(colours[n]));
    for (const seen of [(c) => c, (c) => without(0, c), (c) => without(1, c)]) {
      const l = steps.map((c) => lch(seen(c)).lightness), way = Math.sign(l[10] - l[0]);
      assert.ok(Math.abs(l[10] - l[0]) >= 25, `lightness ${l[0].toFixed(0)} to ${l[10].toFixed(0)}`);
      for (let k = 1; k < l.length; k++) assert.ok(way * (l[k] - l[k - 1]) >= 1, `step ${k}: ${l.map((v) => v.toFixed(0)).join(" ")}`);
    }
    for (const step of steps) {
      const { chroma, hue } = lch(step);
      assert.ok(chroma < 40 || alarms.every((a) => apart(a.hue, hue) >= 25), `${step}: hue ${hue.toFixed(0)}, chroma ${chroma.toFixed(0)}`);
    }
    const y = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)).reduce((sum, v, at) => sum + v * [0.2126, 0.7152, 0.0722][at], 0);
    const ratio = (a, b) => (Math.max(y(a), y(b)) + 0.05) / (Math.min(y(a), y(b)) + 0.05);
    assert.ok(ratio(steps[10], colours.line) >= 3, `${ratio(steps[10], colours.line).toFixed(1)} to the strip`);
  });
}
