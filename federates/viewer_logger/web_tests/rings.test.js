// Rings and sectors of a radar's plan: cells of an effect, where they lie, and what is said of them.
import assert from "node:assert/strict";
import { test } from "node:test";
import { bearings, cellsOf, dialRadius, ringEdges, sectorText, sentence, STATES, sums, wedge } from "../web/rings.js";

const SECTORS = 16;
const cell = (near, far, sector, states, targets = 1) => ({ ring_m: [near, far], band_m: [0, 0.5], sector, class: "A320", targets, states });
const TOLD = {
  sensor: 1, scan: 40, site_m: [100, -200], from_m: 60, to_m: 5000, sectors: SECTORS, effects: ["fog", "glint", "false alarms"], whole: { "false alarms": "e" },
  cells: [cell(800, 1131, 3, "esn", 2), cell(400, 565, 15, "nrn"), cell(0, 100, 7, "een")],
};

/** Where a place lies, by another way than the outlines are made: ground distance and bearing. */
const polar = ([x, y], [sx, sy]) => [Math.hypot(x - sx, y - sy), (Math.atan2(x - sx, y - sy) + 2 * Math.PI) % (2 * Math.PI)];
/** Whether a place is inside an outline (even and odd). */
function inside([x, y], ring) {
  let odd = false;
  for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
    const [[ax, ay], [bx, by]] = [ring[i], ring[j]];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) odd = !odd;
  }
  return odd;
}

test("a cell's outline holds the places of its ring and sector and no others", () => {
  let seed = 7;
  const random = () => ((seed = (seed * 48271) % 2147483647) / 2147483647);
  for (const site of [[0, 0], [1200, -3400]]) {
    for (const { ring_m: [near, far], sector } of [...TOLD.cells, cell(1600, 1902, 0, ""), cell(2263, 3200, 11, "")]) {
      const ring = wedge(site, near, far, sector, SECTORS, 64);
      for (let i = 0; i < 3000; i++) {
        const place = [site[0] + (random() - 0.5) * 2.4 * far, site[1] + (random() - 0.5) * 2.4 * far], [r, bearing] = polar(place, site);
        const edges = [near, far].some((m) => Math.abs(r - m) < 0.002 * far) || [0, 1].some((k) => Math.abs(Math.sin(bearing - ((sector + k) / SECTORS) * 2 * Math.PI)) < 1e-3);
        if (edges) continue;
        const wanted = r >= near && r < far && Math.floor((bearing / (2 * Math.PI)) * SECTORS) === sector;
        assert.equal(inside(place, ring), wanted, `${r.toFixed(0)} m, ${((bearing * 180) / Math.PI).toFixed(1)}\u00b0 of ${near} to ${far}, sector ${sector}`);
      }
    }
  }
});

test("sectors count clockwise from north, and their words say so", () => {
  assert.deepEqual(bearings(4, SECTORS), [Math.PI / 2, (5 * Math.PI) / 8]);
  const east = wedge([0, 0], 100, 200, 4, SECTORS)[0];
  assert.ok(Math.abs(east[0] - 200) < 1e-9 && Math.abs(east[1]) < 1e-9, "the fifth begins in the east");
  assert.equal(sectorText(0, SECTORS), "0\u201322.5\u00b0");
  assert.equal(sectorText(15, SECTORS), "337.5\u2013360\u00b0");
});

test("cells of an effect have its states, those that are on over those that are not", () => {
  const fog = cellsOf(TOLD, "fog"), glint = cellsOf(TOLD, "glint");
  assert.deepEqual(fog.map((c) => [c.state, c.near, c.sector]), [["n", 400, 15], ["e", 0, 7], ["e", 800, 3]]);
  assert.deepEqual(glint.map((c) => c.state), ["s", "r", "e"]);
  assert.deepEqual(cellsOf(TOLD, "false alarms").map((c) => c.state), ["e", "e", "e"], "of the whole radar");
  assert.equal(cellsOf(TOLD, "lobing"), null);
  assert.deepEqual(sums(glint).map((s) => [s.letter, s.cells, s.targets]), [["e", 1, 1], ["r", 1, 1], ["s", 1, 2]]);
  assert.equal(sentence("glint", glint), "glint \u2013 exact: 1 target in 1 cell; reduced: 1 target in 1 cell; skipped: 2 targets in 1 cell.");
  assert.equal(sentence("glint", []), "glint: no target is displayed.");
  assert.match(sentence("lobing", null), /no such effect/);
  assert.deepEqual(STATES.map((s) => s.letter).join(""), "nsre");
});

test("in the dial the rings of the lattice are equally wide and the display's rim is its rim", () => {
  const edges = ringEdges(5000);
  assert.deepEqual(edges.slice(0, 3).map((m) => Math.round(m)), [100, 141, 200]);
  assert.equal(edges.at(-1), 5000);
  const radii = edges.map((m) => dialRadius(m, 5000, 100));
  for (let i = 1; i < radii.length - 1; i++) assert.ok(Math.abs(radii[i] - radii[i - 1] - radii[0]) < 1e-9, `${i}: ${radii[i] - radii[i - 1]}`);
  assert.ok(Math.abs(radii.at(-1) - 100) < 1e-9);
  assert.equal(dialRadius(0, 5000, 100), 0);
  assert.ok(Math.abs(dialRadius(50, 5000, 100) - radii[0] / 2) < 1e-9);
  assert.equal(dialRadius(9000, 5000, 100), 100, "nothing is drawn beyond the rim");
});
