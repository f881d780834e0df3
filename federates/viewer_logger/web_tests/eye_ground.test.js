// Lamps and paint of the ground: which side they shine to, what is switched, what a slope shows, which way signs are read.
import assert from "node:assert/strict";
import { test } from "node:test";
import { designatorLines, faces, fixed, slopes, switched } from "../web/eye_ground.js";
import { flats } from "../web/eye_scene.js";

/** A runway in any direction: its first end at a place, so long, so many degrees from north. */
const runway = (deg, designators = ["09", "27"], length = 2000, [x, y] = [300, -500]) => {
  const b = (deg * Math.PI) / 180;
  return { designators, width_m: 45, ends: [[x, y], [x + length * Math.sin(b), y + length * Math.cos(b)]] };
};
/** Where one is so far before an end, to its right, above: as who comes to land there. */
const before = ({ ends: [a, b] }, end, far, right = 0, up = 50) => {
  const [from, to] = end ? [b, a] : [a, b], l = Math.hypot(to[0] - from[0], to[1] - from[1]), u = [(to[0] - from[0]) / l, (to[1] - from[1]) / l];
  return [from[0] - u[0] * far + u[1] * right, from[1] - u[1] * far - u[0] * right, up];
};
const airport = (r, more = {}) => ({ runways: [r], taxiways: [], pavements: [], ...more });

test("who lands sees green thresholds and red ends, whichever end it is", () => {
  for (const deg of [0, 37, 160, 285]) {
    const r = runway(deg), all = fixed(airport(r), false);
    for (const end of [0, 1]) {
      const eye = before(r, end, 800), seen = all.filter((l) => faces(l, eye)).map((l) => l.id), names = r.designators;
      assert.ok(seen.some((id) => id.startsWith(`${names[end]} threshold`)), `${deg}: own threshold`);
      assert.ok(!seen.some((id) => id.startsWith(`${names[end]} end`)), `${deg}: no red at the near end`);
      assert.ok(seen.some((id) => id.startsWith(`${names[1 - end]} end`)), `${deg}: red at the far end`);
      assert.ok(!seen.some((id) => id.startsWith(`${names[1 - end]} threshold`)), `${deg}: not the other's green`);
    }
    assert.ok(all.filter((l) => / edge | centre /.test(l.id)).every((l) => faces(l, before(r, 0, 800)) && faces(l, before(r, 1, 800))));
    assert.ok(all.filter((l) => / threshold /.test(l.id)).every((l) => l.colour[1] > l.colour[0]) && all.filter((l) => / end /.test(l.id)).every((l) => l.colour[0] > l.colour[1]));
  }
});

test("a slope is two white and two red on three degrees, more white above it, dark behind", () => {
  for (const deg of [0, 123, 301]) {
    const r = runway(deg);
    for (const end of [0, 1]) {
      const whites = (degrees, far = 3000) => {
        // From the lamps, which are 300 m beyond the threshold.
        const eye = before(r, end, far, -40, 1 + Math.tan((degrees * Math.PI) / 180) * (far + 300));
        const own = slopes(airport(r), eye, false).filter((l) => l.id.startsWith(r.designators[end]));
        assert.equal(own.length, 4);
        assert.ok(own.every((l) => faces(l, eye)));
        return own.map((l) => (l.colour[2] > 0.5 ? "W" : "R")).join("");
      };
      assert.deepEqual([2.2, 2.7, 3, 3.3, 3.8].map((d) => whites(d)), ["RRRR", "RRRW", "RRWW", "RWWW", "WWWW"], `${deg}, end ${end}`);
      const behind = before(r, end, -1500);
      assert.ok(slopes(airport(r), behind, false).filter((l) => l.id.startsWith(r.designators[end])).every((l) => !faces(l, behind)));
    }
  }
  assert.deepEqual(slopes(airport(runway(0, ["09", "27"], 800)), [0, 0, 10], false), [], "a short field has none");
});

test("slopes stand left of the runway as who lands has it", () => {
  const r = runway(0, ["36", "18"], 2000, [0, 0]);
  const of = (name) => slopes(airport(r), [0, 0, 10], false).filter((l) => l.id.startsWith(name)).map((l) => l.at);
  assert.ok(of("36").every(([x, y]) => x < -22.5 && y === 300) && of("18").every(([x, y]) => x > 22.5 && y === 1700));
});

test("bars that are lit are red across their taxiway, dark ones are not there", () => {
  const lights = { bars: [{ id: 7, lit: true, ends_m: [[0, 0], [20, 0]] }, { id: 8, lit: false, ends_m: [[0, 9], [20, 9]] }], entries: [{ lit: true, ends_m: [[0, 30], [0, 36]] }], holds: [{ lit: false, ends_m: [[0, 50], [9, 50]] }] };
  const out = switched(lights, false);
  assert.deepEqual(out.filter((l) => l.id.startsWith("bar 7")).map((l) => l.at.slice(0, 2)).filter((_, i, all) => i === 0 || i === all.length - 1), [[0, 0], [20, 0]]);
  assert.ok(!out.some((l) => l.id.startsWith("bar 8")));
  assert.equal(out.filter((l) => l.id.startsWith("status")).length, 3);
  assert.ok(out.every((l) => l.colour[0] === 1 && l.colour[1] < 0.3));
  assert.deepEqual([switched(null, true), switched({}, true)], [[], []]);
});

test("designators are read by who lands, the letter nearer to the threshold", () => {
  const r = runway(90, ["09L", "27R"], 2500, [0, 0]), lines = designatorLines(r), near = lines.filter(([[x]]) => x < 1250), far = lines.filter(([[x]]) => x > 1250);
  // 0, 9 and L: six, six and three bars; 2, 7 and R: five, three and six.
  assert.deepEqual([near.length, far.length], [15, 14]);
  const xs = near.flat().map(([x]) => Math.round(x * 1e6) / 1e6);
  assert.ok(Math.min(...xs) === 42 && Math.max(...xs) === 66, `${Math.min(...xs)} ${Math.max(...xs)}`);
  // Of the L (nearest) the upright is left of who lands: north of the middle line on an eastbound runway.
  const letter = near.filter((l) => l.every(([x]) => x < 51.1)), upright = letter.filter(([[, y0], [, y1]]) => Math.abs(y0 - y1) < 1e-6);
  assert.ok(upright.length === 2 && upright.every(([[, y]]) => y > 0), JSON.stringify(letter));
  // Who lands on 27R has the 2 (five bars) left of the 7 (three): south and north of the line.
  const number = far.filter((l) => l.every(([x]) => x < 2500 - 51.1)), side = (sign) => number.filter((l) => l.every(([, y]) => sign * y > 0)).length;
  assert.deepEqual([side(-1), side(1)], [5, 3]);
  assert.deepEqual(designatorLines(runway(0, ["", ""])), []);
});

test("hold lines are painted", () => {
  const bare = flats(airport(runway(0))).array().length, held = flats(airport(runway(0), { holds: [{ ends_m: [[0, 0], [20, 0]] }] })).array().length;
  assert.ok(held > bare);
});
