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

const offsets = (placed) => new Map([...placed].map(([id, { dx, dy, level }]) => [id, { dx, dy, level }]));
/** How many labels stand elsewhere beside their targets than in the scan before, of how many that were in both. */
function elsewhere(before, now) {
  const both = [...now].filter(([id]) => before.has(id));
  const far = both.filter(([id, p]) => Math.hypot(p.x - p.item.x - before.get(id).x + before.get(id).item.x, p.y - p.item.y - before.get(id).y + before.get(id).item.y) > 20);
  return [far.length, both.length];
}

test("labels stay where they were while nothing changes", () => {
  const items = crowd(150, 7), first = place(items, { view: VIEW, field: field() });
  const again = place(items, { view: VIEW, field: field(), before: offsets(first), turn: 1 });
  const [moved, of] = elsewhere(first, again);
  assert.ok(moved <= 0.02 * of, `${moved} of ${of} moved`);
});

for (const [n, seed, share] of [[30, 21, 0.02], [100, 22, 0.02], [250, 25, 0.02]]) {
  test(`${n} labels, two thirds of them under way, stay beside their targets for two minutes, and as many show as if each scan were the first`, () => {
    const draw = draws(seed), way = Array.from({ length: n }, (_, i) => (i % 3 ? [draw() * 8 - 4, draw() * 8 - 4] : [0, 0]));
    let items = crowd(n, seed, (i) => i % 25 === 0), before = new Map(), last = null, moved = 0, of = 0, shown = 0, fresh = 0, level = 0, wished = 0;
    for (let turn = 0; turn < 120; turn++) {
      const placed = place(items, { view: VIEW, field: field(), before, turn }), list = [...placed.values()];
      for (const [i, a] of list.entries()) for (const b of list.slice(i + 1)) assert.ok(!overlap(a, b), `${a.id} over ${b.id}`);
      assert.ok(list.every((p) => p.item.must || !onRunway(p)));
      if (last) [moved, of] = elsewhere(last, placed).map((k, i) => k + [moved, of][i]);
      if (turn % 20 === 19) {
        shown += placed.size;
        fresh += place(items, { view: VIEW, field: field() }).size;
      }
      for (const p of list) [level, wished] = [level + p.level, wished + p.item.level];
      [last, before] = [placed, offsets(placed)];
      items = items.map((item, i) => ({ ...item, x: (item.x + way[i][0] + 1600) % 1600, y: (item.y + way[i][1] + 1000) % 1000 }));
    }
    assert.ok(moved <= share * of, `${moved} of ${of} moved`);
    assert.ok(shown >= 0.95 * fresh, `${shown} of ${fresh} shown`);
    assert.ok(level >= 0.75 * wished, `${level} lines of ${wished} wished for`);
  });
}

test("where many find no room those who have a place keep it, and keep off their own symbols", () => {
  const draw = draws(31), way = Array.from({ length: 260 }, () => [draw() * 4 - 2, draw() * 4 - 2]);
  let items = crowd(260, 31).map((i) => ({ ...i, x: 500 + i.x / 3, y: 300 + i.y / 3 })), before = new Map(), last = null, moved = 0, of = 0, left = 0, gone = 0, own = 0;
  for (let turn = 0; turn < 40; turn++) {
    const placed = place(items, { view: VIEW, before, turn });
    if (last) [moved, of] = elsewhere(last, placed).map((k, i) => k + [moved, of][i]);
    left += items.length - placed.size;
    gone += last ? [...last.keys()].filter((id) => !placed.has(id)).length : 0;
    own += [...placed.values()].filter((p) => Math.hypot(p.ax - p.item.x, p.ay - p.item.y) <= 6).length;
    [last, before] = [placed, offsets(placed)];
    items = items.map((item, i) => ({ ...item, x: item.x + way[i][0], y: item.y + way[i][1] }));
  }
  assert.ok(left > 40 * 50, `${left} left out`);
  assert.ok(moved <= 0.02 * of, `${moved} of ${of} moved`);
  assert.ok(gone <= 0.04 * of, `${gone} of ${of} gone`);
  assert.ok(own <= 0.005 * of, `${own} of ${of} on their own symbols`);
});

test("when the crowd has gone the others say all again within a minute, and stand near again in time", () => {
  const many = crowd(120, 33).map((i) => ({ ...i, x: 700 + i.x / 10, y: 450 + i.y / 10, level: 3 })), few = many.slice(0, 8).map((i, k) => ({ ...i, x: 500 + 80 * k }));
  let before = new Map(), placed = null;
  for (let turn = 0; turn < 5; turn++) {
    placed = place(many, { view: VIEW, before, turn });
    before = offsets(placed);
  }
  const far = (p) => [...p.values()].reduce((sum, { dx, dy }) => sum + Math.hypot(dx, dy), 0) / p.size, level = (p) => [...p.values()].reduce((sum, q) => sum + q.level, 0);
  before = new Map(few.map((i, k) => [i.id, { dx: 60 + 8 * k, dy: -90, level: 1 }]));
  for (let turn = 5; turn < 65; turn++) {
    placed = place(few, { view: VIEW, before, turn });
    before = offsets(placed);
  }
  assert.ok(level(placed) >= 22, `${level(placed)} lines of 24`);
  for (let turn = 65; turn < 700; turn++) {
    placed = place(few, { view: VIEW, before, turn });
    before = offsets(placed);
  }
  const fresh = place(few, { view: VIEW });
  assert.ok(far(placed) <= far(fresh) + 15, `${far(placed)} px away, at first ${far(fresh)}`);
});

test("what must show is shown where the runway fills the view", () => {
  const f = new Field(0, 0, VIEW.w, VIEW.h);
  f.box(VIEW);
  const items = crowd(20, 9, (i) => i < 5), placed = place(items, { view: VIEW, field: f });
  assert.deepEqual([...placed.keys()].sort(), ["t0", "t1", "t2", "t3", "t4"]);
  assert.ok([...placed.values()].every((p) => p.runway > 0));
});

/** How many leaders cross another one or pass through a label. */
function crossing(placed) {
  const long = (p) => Math.hypot(p.ax - p.item.x, p.ay - p.item.y) >= SHORT_LEADER, line = (p) => [p.item.x, p.item.y, p.ax, p.ay], through = (p, q) => long(p) && cuts(...line(p), q);
  return placed.flatMap((a, i) => placed.slice(i + 1).map((b) => (long(a) && long(b) && crosses(...line(a), ...line(b))) || through(a, b) || through(b, a))).filter(Boolean).length;
}

test("where more must show than there is room for, two leaders in a hundred cross at most, scan by scan; who always must is shown", () => {
  const draw = draws(41), way = Array.from({ length: 160 }, () => [draw() * 3 - 1.5, draw() * 3 - 1.5]);
  let items = crowd(160, 41, () => true).map((i) => ({ ...i, x: 600 + i.x / 6, y: 450 + i.y / 8, level: 3 })), before = new Map();
  for (let turn = 0; turn < 12; turn++) {
    const placed = place(items, { view: VIEW, field: field(), before, turn }), list = [...placed.values()];
    assert.ok(list.length >= 20 && list.length < 160, `${list.length} shown`);
    assert.ok(crossing(list) <= 0.02 * list.length, `${crossing(list)} of ${list.length} cross`);
    before = offsets(placed);
    items = items.map((item, i) => ({ ...item, x: item.x + way[i][0], y: item.y + way[i][1] }));
  }
  const some = items.map((item, i) => ({ ...item, always: i % 16 === 0, importance: i % 16 ? 1 : 9 })), placed = place(some, { view: VIEW, field: field(), before, turn: 12 });
  assert.ok(some.every((i) => !i.always || placed.has(i.id)));
});

test("nothing is put under what lies over the map, not even what must show", () => {
  const f = new Field(0, 0, VIEW.w, VIEW.h), covers = [{ x: 300, y: 200, w: 900, h: 500 }];
  f.box(VIEW);
  const items = crowd(120, 9, () => true), placed = [...place(items, { view: VIEW, field: f, covers }).values()];
  assert.ok(placed.length > 40, `${placed.length} shown`);
  for (const p of placed) assert.ok(!overlap(p, covers[0]), `${p.id} is covered`);
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
