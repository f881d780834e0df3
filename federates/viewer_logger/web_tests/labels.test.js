// Laws of the placing of labels, on crowds that are drawn from a counter.
import assert from "node:assert/strict";
import { test } from "node:test";
import { crosses, cuts, Field, overlap, place, SHORT_LEADER, thin } from "../web/labels.js";

/** Numbers from 0 to 1, the same every time. */
function draws(seed) {
  let s = seed >>> 0;
  return () => {
    s = (Math.imul(s ^ (s >>> 15), 0x2c1b3c6d) + 0x9e3779b9) >>> 0;
    return ((s ^ (s >>> 13)) >>> 0) / 2 ** 32;
  };
}
const VIEW = { x: 0, y: 0, w: 1600, h: 1000 };
const RUNWAY = [[100, 700], [1500, 300], [1500, 330], [100, 730]];

function crowd(n, seed, must = () => false) {
  const draw = draws(seed);
  return Array.from({ length: n }, (_, i) => ({
    id: `t${i}`, x: draw() * 1600, y: draw() * 1000, importance: Math.floor(draw() * 5), must: must(i), level: 1 + Math.floor(draw() * 3), reach: 6,
    sizes: { 1: { w: 60, h: 19 }, 2: { w: 84, h: 32 }, 3: { w: 96, h: 45 } },
  }));
}

function field() {
  const f = new Field(0, 0, VIEW.w, VIEW.h);
  f.polygon(RUNWAY);
  return f;
}

/** Whether a box touches the runway, by its corners and edges. */
function onRunway(box) {
  const corners = [[box.x, box.y], [box.x + box.w, box.y], [box.x, box.y + box.h], [box.x + box.w, box.y + box.h]];
  const side = (p, q, [x, y]) => (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
  const inside = corners.some((c) => RUNWAY.every((p, i) => side(p, RUNWAY[(i + 1) % 4], c) >= 0) || RUNWAY.every((p, i) => side(p, RUNWAY[(i + 1) % 4], c) <= 0));
  return inside || RUNWAY.some((p, i) => cuts(...p, ...RUNWAY[(i + 1) % 4], box));
}

for (const [n, seed] of [[30, 1], [100, 2], [300, 3], [1000, 4]]) {
  test(`${n} labels: none over another, none on a runway, at most two crossing leaders in a hundred`, () => {
    const placed = [...place(crowd(n, seed), { view: VIEW, field: field() }).values()];
    let crossings = 0;
    assert.ok(placed.length >= { 30: 27, 100: 90, 300: 230, 1000: 400 }[n], `${placed.length} shown`);
    for (const [i, a] of placed.entries()) {
      assert.ok(a.x >= 0 && a.y >= 0 && a.x + a.w <= VIEW.w && a.y + a.h <= VIEW.h);
      assert.ok(!onRunway(a), `${a.id} on the runway`);
      for (const b of placed.slice(i + 1)) {
        assert.ok(!overlap(a, b), `${a.id} over ${b.id}`);
        const long = (p) => Math.hypot(p.ax - p.item.x, p.ay - p.item.y) >= SHORT_LEADER;
        const line = (p) => [p.item.x, p.item.y, p.ax, p.ay], through = (p, q) => long(p) && cuts(...line(p), q);
        if ((long(a) && long(b) && crosses(...line(a), ...line(b))) || through(a, b) || through(b, a)) crossings++;
      }
    }
    assert.ok(crossings <= 0.02 * placed.length, `${crossings} leaders cross`);
  });
}

test("labels stay where they were while nothing changes, and mostly while targets move a little", () => {
  const items = crowd(150, 7), first = place(items, { view: VIEW, field: field() });
  const before = new Map([...first].map(([id, p]) => [id, { dx: p.dx, dy: p.dy }]));
  const again = place(items, { view: VIEW, field: field(), before });
  let moved = 0;
  for (const [id, p] of again) if (first.has(id) && Math.hypot(p.dx - first.get(id).dx, p.dy - first.get(id).dy) > 20) moved++;
  assert.ok(moved <= 0.02 * again.size, `${moved} of ${again.size} moved`);
});

test("what must show is shown where the runway fills the view", () => {
  const f = new Field(0, 0, VIEW.w, VIEW.h);
  f.box(VIEW);
  const items = crowd(20, 9, (i) => i < 5), placed = place(items, { view: VIEW, field: f });
  assert.deepEqual([...placed.keys()].sort(), ["t0", "t1", "t2", "t3", "t4"]);
  assert.ok([...placed.values()].every((p) => p.runway > 0));
});

test("a dragged label keeps its offset, whoever else wants to be there", () => {
  const items = crowd(200, 11);
  items[3].dragged = { dx: 40, dy: -25 };
  items[3].x = 800;
  items[3].y = 500;
  const p = place(items, { view: VIEW }).get("t3");
  assert.deepEqual([p.dx, p.dy, p.level], [40, -25, items[3].level]);
});

test("a field counts cells as they are, and a polygon marks all that it touches", () => {
  const f = new Field(-16, -16, 64, 64);
  f.box({ x: 1, y: 1, w: 2, h: 2 });
  assert.equal(f.under({ x: 0, y: 0, w: 8, h: 8 }), 1);
  assert.equal(f.under({ x: 9, y: 9, w: 8, h: 8 }), 0);
  assert.equal(f.under({ x: -1000, y: -1000, w: 5000, h: 5000 }), 1);
  f.polygon([[-16, -16], [47, 47], [47, 47.1], [-16, -15.9]]);
  for (let d = -15; d < 47; d += 5) assert.ok(f.under({ x: d, y: d, w: 1, h: 1 }) > 0, `${d}`);
});

test("a crowd on one point is bounded and counted", () => {
  const items = crowd(200, 13).map((item) => ({ ...item, x: 800, y: 500 }));
  const placed = place(items, { view: VIEW });
  assert.ok(placed.size > 5 && placed.size < 120, `${placed.size}`);
});

test("where labels would cover too much, the least important shrink first and standing ones go", () => {
  const items = crowd(100, 15).map((item, i) => ({ ...item, importance: i, level: 3, standing: i < 30, must: i === 0 }));
  thin(items, 500_000);
  assert.equal(items[0].level, 3, "must show");
  assert.equal(items[1].level, 1);
  assert.equal(items.at(-1).level, 3, "the most important kept theirs");
  thin(items, 100_000);
  assert.equal(items[1].level, 0);
  assert.equal(items[40].level, 1, "a moving one stays");
});
