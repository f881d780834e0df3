// Colours of the style sheet: red and amber are for alarms.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

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
const DRAWN = ["ground", "pavement", "pavement-edge", "runway", "runway-mark", "taxi", "taxi-name", "stand", "departure", "vehicle", "unknown", "truth", "error", "rain", "coverage", "select", "video", "bar", "arrival"];

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
