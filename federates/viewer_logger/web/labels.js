// Places labels beside their targets: none over another, none on a runway while there is room, no crossing leaders, each
// near where it was in the picture before. No DOM here; once a scan, never while the map moves.
//
// Targets are served by importance. A candidate is a direction on a ring around the symbol. It is refused where the box
// leaves its bounds, touches another label or covers a runway (a summed-area table says so in four look-ups), or where
// its leader crosses another's leader or label. Without a place the label falls to the next lower level; then neighbours
// may change places; then it is left out, unless it must show: for those the runway becomes a cost, and for those that always must, leaders, too.

const RINGS = [[13, 8], [30, 16], [56, 16], [90, 16], [135, 16]];
const OFFSETS = RINGS.flatMap(([radius, directions]) => Array.from({ length: directions }, (_, k) => {
  const angle = ((k + 0.5) / directions) * 2 * Math.PI, dx = Math.cos(angle), dy = Math.sin(angle);
  return { dx: dx * radius, dy: dy * radius, ux: dx, uy: dy, radius, bias: bias(dx, dy, radius) };
}));
/** Turns and lengthenings by which a label that cannot stay slides on, nearest first. */
const SLIDES = [[0.15, 0], [0, 6], [0.3, 0], [0.15, 6], [0, 12], [0.3, 12], [0.45, 0], [0, 20], [0.3, 20]]
  .flatMap(([turn, longer]) => (turn ? [[turn, longer], [-turn, longer]] : [[0, longer]]));
/** The same in pixels, across and along the leader, nearest first: where a label goes that may go `ASIDE` and no farther; from another size its corner is farther off. */
const asides = (farthest) => {
  const steps = [0, 6, 12, 18, 24, 30, 36].flatMap((s) => (s ? [-s, s] : [0]));
  return steps.flatMap((across) => steps.map((along) => [across, along])).filter((at) => Math.hypot(...at) < farthest).sort((a, b) => Math.hypot(...a) - Math.hypot(...b));
};
const ASIDES = asides(19), RESIZED = asides(40);
function bias(ux, uy, radius) {
  return (radius - 13) / 4 + (ux < 0 ? 1.5 : 0) + (uy > 0 ? 1 : 0);
}

/** How far a label goes aside from one scan to the next without anybody minding, pixels; one in so many looks for a better place. */
const ASIDE = 19, LOOK_AROUND = 100, SAY_MORE = 10;
const GAP = 2, STAY = 12, AWAY = 0.3, FARTHEST = 60, FOREIGN = 14, OWN = 40, SWAPS = 60, PUSHES = 300, CROWD = 200;
const ON_RUNWAY = 20, A_CELL = 6, CROSSING = 15;
/** Shorter leaders are not drawn, so nobody sees them cross. */
export const SHORT_LEADER = 14;
/** Pixels of a cell of the static field. */
export const CELL = 8;

/** How much of a box is on what labels keep away from: runways, designators, what lies over the map. */
export class Field {
  constructor(x0, y0, width, height) {
    this.x0 = x0;
    this.y0 = y0;
    this.w = Math.max(1, Math.ceil(width / CELL));
    this.h = Math.max(1, Math.ceil(height / CELL));
    this.cells = new Uint8Array(this.w * this.h);
    this.sums = null;
  }

  /** Marks the cells that a convex polygon covers or touches. */
  polygon(points) {
    const ring = points.map(([x, y]) => [(x - this.x0) / CELL, (y - this.y0) / CELL]);
    const ys = ring.map((p) => p[1]);
    const first = Math.max(0, Math.floor(Math.min(...ys))), last = Math.min(this.h - 1, Math.floor(Math.max(...ys)));
    for (let row = first; row <= last; row++) {
      let low = Infinity, high = -Infinity;
      for (let i = 0; i < ring.length; i++) {
        const [ax, ay] = ring[i], [bx, by] = ring[(i + 1) % ring.length];
        // The part of the edge within the row: a convex polygon covers what lies between the outermost of these.
        const t0 = ay === by ? 0 : clamp((row - ay) / (by - ay), 0, 1), t1 = ay === by ? 1 : clamp((row + 1 - ay) / (by - ay), 0, 1);
        if (Math.max(ay, by) < row || Math.min(ay, by) > row + 1) continue;
        low = Math.min(low, ax + t0 * (bx - ax), ax + t1 * (bx - ax));
        high = Math.max(high, ax + t0 * (bx - ax), ax + t1 * (bx - ax));
      }
      if (high < low) continue;
      this.cells.fill(1, row * this.w + clamp(Math.floor(low), 0, this.w), row * this.w + clamp(Math.floor(high) + 1, 0, this.w));
    }
    this.sums = null;
  }

  box({ x, y, w, h }) {
    this.polygon([[x, y], [x + w, y], [x + w, y + h], [x, y + h]]);
  }

  /** Number of marked cells under a box. */
  under({ x, y, w, h }) {
    this.sums ??= this.#summed();
    const W = this.w + 1;
    const x0 = clamp(Math.floor((x - this.x0) / CELL), 0, this.w), x1 = clamp(Math.ceil((x + w - this.x0) / CELL), 0, this.w);
    const y0 = clamp(Math.floor((y - this.y0) / CELL), 0, this.h), y1 = clamp(Math.ceil((y + h - this.y0) / CELL), 0, this.h);
    return this.sums[y1 * W + x1] - this.sums[y0 * W + x1] - this.sums[y1 * W + x0] + this.sums[y0 * W + x0];
  }

  #summed() {
    const W = this.w + 1, sums = new Int32Array(W * (this.h + 1));
    for (let y = 0; y < this.h; y++) {
      let row = 0;
      for (let x = 0; x < this.w; x++) {
        row += this.cells[y * this.w + x];
        sums[(y + 1) * W + x + 1] = sums[y * W + x + 1] + row;
      }
    }
    return sums;
  }
}

/**
 * items: { id, x, y, importance, must, always, level, sizes: { 1: {w, h}, 2: …, 3: … }, reach } in pixels, `reach` the radius of the
 * own symbol, `dragged` {dx, dy} where a person put it.
 * options: { view, room: boxes {x, y, w, h} (targets in `view` keep their labels inside it, others inside `room`), field: a
 * Field or null, covers: boxes that lie over the map, under which nothing is read, before: Map id → {dx, dy, level} of the scan before, turn: number of the scan, marks: [{x, y, r, weight}] that labels avoid }
 * Returns Map id → { x, y, w, h, level, ax, ay, dx, dy, runway }: the box, the level, where the leader ends, the offset to hand in as
 * `before`, and the cells of runway under it.
 */
export function place(items, options) {
  return whole(placing(items, options));
}

/** What work in steps returns, done at once. */
export function whole(work) {
  for (;;) {
    const { done, value } = work.next();
    if (done) return value;
  }
}

/** The same in steps of a few labels each. */
export function* placing(items, options) {
  const crowd = items.length > CROWD; // sees at once that all cannot say all, and costs one frame only
  const first = yield* tryAll(crowd ? items.map(shorter) : items, options, crowd ? SWAPS / 6 : SWAPS);
  if (crowd) return first;
  // Where many find no room, all but the important ones say less, and more are shown.
  if (items.length - first.size <= 0.05 * items.length) return first;
  const second = yield* tryAll(items.map(shorter), options, SWAPS);
  return second.size > first.size ? second : first;
}

const shorter = (item) => (item.must || item.level === 1 ? item : { ...item, level: 1 });

function* tryAll(items, { view, room = view, field = null, covers = [], before = new Map(), marks = [], turn = 0 }, swaps) {
  const context = { view, room, field, covers, before, turn, placed: new Map(), crossings: 0, boxes: new Grid(), leaders: new Grid(), symbols: new Grid(), swaps, pushes: PUSHES, moves: movesOf(before.size, turn), spacious: items.filter((i) => !before.has(i.id)).length <= 0.02 * items.length };
  for (const item of items) {
    const r = item.reach ?? 6;
    context.symbols.add({ id: item.id, x: item.x, y: item.y, r, weight: FOREIGN }, item.x - r, item.y - r, item.x + r, item.y + r);
  }
  for (const m of marks) context.symbols.add(m, m.x - m.r, m.y - m.r, m.x + m.r, m.y + m.r);
  const order = [...items].sort((a, b) => Number(Boolean(b.dragged)) - Number(Boolean(a.dragged)) || b.importance - a.importance || (a.id < b.id ? -1 : 1));
  // Who must show chooses first, and takes what there is. Who has a place keeps it; who cannot, moves aside or says less, alone or with one neighbour;
  // only then do others look for theirs.
  const out = [];
  for (const [group, rules] of [[order.filter((i) => i.must || i.dragged), [ANY_GROUND, ANY_WAY]], [order.filter((i) => !i.must && !i.dragged), []]]) {
    let left = group;
    for (const tries of [stays, slides, pushes, settle, makeRoom, ...rules.map((r) => (item, c) => (item.always || r !== ANY_WAY) && (slides(item, c, r) || settle(item, c, r)))]) {
      const still = [];
      for (const item of left) {
        if (!tries(item, context)) still.push(item);
        yield;
      }
      left = still;
    }
    out.push(...left);
  }
  // Two leaders in a hundred labels may cross: first of those that must show.
  let allowed = Math.floor(context.placed.size / 50) - context.crossings;
  for (const item of out) {
    if (allowed <= 0) break;
    const rules = item.must ? MUST_CROSS : ONE_CROSSING, one = { ...item, level: 1 };
    if (!slides(one, context, rules) && !settle(one, context, rules)) continue;
    allowed -= context.placed.get(item.id).crossings;
    yield;
  }
  return context.placed;
}

/** Labels that may change places for somebody else in this scan: one in two hundred, over the scans; all of them where nobody has a place yet. */
function movesOf(known, turn) {
  return known ? Math.floor((turn + 1) * known * 0.005) - Math.floor(turn * known * 0.005) : Infinity;
}

/** Whether a label looks in this scan for something better than the place that it has. */
function looksAround(id, turn, often = LOOK_AROUND) {
  let hash = turn;
  for (let i = 0; i < id.length; i++) hash = (Math.imul(hash, 31) + id.charCodeAt(i)) >>> 0;
  return (Math.imul(hash ^ (hash >>> 15), 0x2c1b3c6d) >>> 16) % often === 0;
}

/** The same where most have a place: in a crowd every place is soon another's. */
const looks = (item, context) => context.spacious && looksAround(item.id, context.turn);

/** The level at which a label goes on: what must be read says all of it. */
const goesOn = (item, last) => (item.must ? item.level : Math.min(item.level, last.level ?? item.level));

/** At the very place beside its target, saying as much as before; from time to time as much as is wished, if that is hardly another place. */
function stays(item, context) {
  const last = item.dragged ? null : context.before.get(item.id);
  if (!last || looks(item, context)) return false;
  const same = goesOn(item, last);
  if (same < item.level && context.spacious && looksAround(item.id, context.turn, SAY_MORE)) {
    for (let level = item.level; level > same; level--) {
      const more = beside(item, level, last, context);
      if (more && more.cost < STAY) return keep(finish(more, item, level), context);
    }
  }
  if (same !== (last.level ?? same)) return false; // another size has another corner
  const found = candidate(item, item.sizes[same], last.dx, last.dy, context, STRICT);
  return Boolean(found) && found.cost < STAY && keep(finish(found, item, same), context);
}

/** A little aside, or saying less. In a crowd over anybody's symbol rather than not at all: who comes later would do so, too. */
function slides(item, context, rules = STRICT) {
  const last = item.dragged ? null : context.before.get(item.id);
  if (!last || looks(item, context)) return false;
  for (let level = goesOn(item, last); level >= 1; level--) {
    const found = beside(item, level, last, context, rules);
    if (found && !found.own && (found.cost < OWN || !context.spacious || rules !== STRICT)) return keep(finish(found, item, level), context);
  }
  return false;
}

/** A little aside, where one who is in the way goes a little aside as well. */
function pushes(item, context) {
  const last = item.dragged ? null : context.before.get(item.id);
  if (!last || looks(item, context)) return false;
  const size = item.sizes[goesOn(item, last)], [x, y] = corner(item, size, last), around = new Set();
  const x0 = Math.min(item.x, x - ASIDE), y0 = Math.min(item.y, y - ASIDE), x1 = Math.max(item.x, x + size.w + ASIDE), y1 = Math.max(item.y, y + size.h + ASIDE);
  for (const grid of [context.boxes, context.leaders]) grid.each(x0, y0, x1, y1, (p) => context.before.has(p.id) && !p.item.dragged && around.add(p));
  for (const neighbour of around) {
    if (context.pushes-- <= 0) return false;
    drop(neighbour, context);
    if (slides(item, context)) {
      if (slides(neighbour.item, context)) return true;
      drop(context.placed.get(item.id), context);
    }
    keep(neighbour, context);
  }
  return false;
}

/** The cheapest candidate whose corner is within `ASIDE` of where it was. */
function beside(item, level, last, context, rules = STRICT) {
  const size = item.sizes[level], was = item.sizes[last.level ?? level], [x0, y0] = corner(item, was, last), radius = Math.hypot(last.dx, last.dy), angle = Math.atan2(last.dy, last.dx);
  let best = null;
  const half = Math.abs(Math.cos(angle)) * size.w / 2 + Math.abs(Math.sin(angle)) * size.h / 2;
  for (const [across, along] of was === size ? ASIDES : RESIZED) {
    const r = radius + along, turned = angle + across / (radius + half), dx = Math.cos(turned) * r, dy = Math.sin(turned) * r, [x, y] = corner(item, size, { dx, dy }), far = Math.hypot(x - x0, y - y0);
    if (far > ASIDE) continue;
    const found = candidate(item, size, dx, dy, context, rules);
    if (!found) continue;
    found.cost += AWAY * far;
    if (!best || found.cost < best.cost) best = found;
  }
  return best;
}

/** What is refused: a runway under the label, a leader that crosses. What is not, costs. */
const STRICT = { runway: false, leaders: 0 }, ANY_GROUND = { runway: true, leaders: 0 }, ANY_WAY = { runway: true, leaders: 9 }, ONE_CROSSING = { runway: false, leaders: 1 }, MUST_CROSS = { runway: true, leaders: 1 };

function settle(item, context, rules = STRICT) {
  for (let level = rules === STRICT ? item.level : 1; level >= 1; level--) {
    const best = cheapest(item, level, context, rules);
    if (best) {
      keep(best, context);
      return true;
    }
  }
  return false;
}

function keep(p, context) {
  const { placed, boxes, leaders } = context;
  context.crossings += p.crossings;
  placed.set(p.id, p);
  boxes.add(p, p.x, p.y, p.x + p.w, p.y + p.h);
  if (p.long) leaders.add(p, Math.min(p.item.x, p.ax), Math.min(p.item.y, p.ay), Math.max(p.item.x, p.ax), Math.max(p.item.y, p.ay));
  return true;
}

function drop(p, context) {
  const { placed, boxes, leaders } = context;
  context.crossings -= p.crossings;
  placed.delete(p.id);
  boxes.remove(p, p.x, p.y, p.x + p.w, p.y + p.h);
  if (p.long) leaders.remove(p, Math.min(p.item.x, p.ax), Math.min(p.item.y, p.ay), Math.max(p.item.x, p.ax), Math.max(p.item.y, p.ay));
}

/** Lets a label without a place have that of a less important neighbour, if both find one then, or the neighbour matters less. */
function makeRoom(item, context) {
  const around = [];
  context.boxes.each(item.x - 110, item.y - 60, item.x + 110, item.y + 60, (p) => {
    if (!p.item.dragged && !around.includes(p)) around.push(p);
  });
  for (const neighbour of around) {
    if (context.swaps-- <= 0 || (context.moves < 1 && !item.must)) return false;
    drop(neighbour, context);
    const placed = settle(item, context);
    if (placed && settle(neighbour.item, context)) {
      context.moves--;
      return true;
    }
    if (placed) drop(context.placed.get(item.id), context);
    keep(neighbour, context);
  }
  return false;
}

function cheapest(item, level, context, rules) {
  const size = item.sizes[level], last = item.dragged ?? context.before.get(item.id);
  const own = Math.max(0, (item.reach ?? 6) - 6);
  // Who looks for something better weighs what he has as if it were new.
  const looking = last && !item.dragged && looks(item, context);
  let best = null;
  if (last) {
    const stay = candidate(item, size, last.dx, last.dy, context, item.dragged ? ANY_WAY : rules);
    if (stay) {
      const r = Math.hypot(last.dx, last.dy) || 1;
      stay.cost += (looking ? bias(last.dx / r, last.dy / r, r - own) : 0) - STAY;
      if (stay.cost < 0 || item.dragged) return finish(stay, item, level);
      best = stay;
    }
    const radius = Math.hypot(last.dx, last.dy), angle = Math.atan2(last.dy, last.dx);
    for (const [turn, longer] of SLIDES) {
      const ux = Math.cos(angle + turn), uy = Math.sin(angle + turn), r = Math.min(radius + longer, own + 135);
      const found = candidate(item, size, ux * r, uy * r, context, rules);
      if (!found) continue;
      found.cost += bias(ux, uy, r - own) - STAY / 2 + AWAY * Math.hypot(ux * r - last.dx, uy * r - last.dy);
      if (!best || found.cost < best.cost) best = found;
    }
  }
  for (const offset of OFFSETS) {
    if (best && offset.bias - 2.5 >= best.cost) break; // farther out cannot be cheaper
    const dx = offset.dx + offset.ux * own, dy = offset.dy + offset.uy * own, found = candidate(item, size, dx, dy, context, rules);
    if (!found) continue;
    found.cost += offset.bias;
    if (last && !looking) found.cost += AWAY * Math.min(Math.hypot(dx - last.dx, dy - last.dy), FARTHEST); // who has to go, goes next door
    if (!best || found.cost < best.cost) best = found;
  }
  return best && finish(best, item, level);
}

function finish(p, item, level) {
  p.id = item.id;
  p.item = item;
  p.level = level;
  return p;
}

/** Upper left corner of the box whose nearest edge lies at (dx, dy) of the target. */
function corner(item, { w, h }, { dx, dy }) {
  const length = Math.hypot(dx, dy) || 1;
  return [Math.round(item.x + dx - w / 2 + (dx / length) * (w / 2)), Math.round(item.y + dy - h / 2 + (dy / length) * (h / 2))];
}

/** The box whose nearest edge lies at (dx, dy) of the target, with its cost; null where it is refused. */
function candidate(item, { w, h }, dx, dy, context, rules) {
  const [x, y] = corner(item, { w, h }, { dx, dy });
  const { view, room } = context;
  const bounds = item.x >= view.x && item.y >= view.y && item.x <= view.x + view.w && item.y <= view.y + view.h ? view : room;
  if (x < bounds.x + 2 || y < bounds.y + 2 || x + w > bounds.x + bounds.w - 2 || y + h > bounds.y + bounds.h - 2) return null;
  const box = { x, y, w, h, dx, dy, ax: clamp(item.x, x, x + w), ay: clamp(item.y, y, y + h), cost: 0, runway: 0, own: false };
  if (context.covers.some((o) => overlap(box, o))) return null;
  if (context.boxes.some(x - GAP, y - GAP, x + w + GAP, y + h + GAP, (o) => overlap(box, o, GAP))) return null;
  if (context.field) {
    box.runway = context.field.under(box);
    if (box.runway > 0.5) {
      if (!rules.runway) return null;
      box.cost += ON_RUNWAY + A_CELL * box.runway;
    }
  }
  // The leader against other leaders and labels, and the label against other leaders.
  box.long = Math.hypot(box.ax - item.x, box.ay - item.y) >= SHORT_LEADER;
  const x0 = Math.min(item.x, box.ax), y0 = Math.min(item.y, box.ay), x1 = Math.max(item.x, box.ax), y1 = Math.max(item.y, box.ay);
  const over = (o) => cuts(o.item.x, o.item.y, o.ax, o.ay, box);
  const leads = (o) => crosses(item.x, item.y, box.ax, box.ay, o.item.x, o.item.y, o.ax, o.ay), under = (o) => cuts(item.x, item.y, box.ax, box.ay, o);
  let crossings = 0;
  if (rules.leaders === 0) {
    if (context.leaders.some(x, y, x + w, y + h, over)) return null;
    if (box.long && (context.leaders.some(x0, y0, x1, y1, leads) || context.boxes.some(x0, y0, x1, y1, under))) return null;
  } else {
    // Who may cross is counted by whom it crosses.
    const crossed = new Set(), note = (test) => (o) => test(o) && crossed.add(o.id);
    context.leaders.each(x, y, x + w, y + h, note(over));
    if (box.long) {
      context.leaders.each(x0, y0, x1, y1, note(leads));
      context.boxes.each(x0, y0, x1, y1, note(under));
    }
    crossings = crossed.size;
  }
  if (crossings > rules.leaders) return null;
  box.crossings = crossings;
  box.cost += CROSSING * crossings;
  context.symbols.each(x, y, x + w, y + h, (s) => {
    if (Math.hypot(s.x - clamp(s.x, x, x + w), s.y - clamp(s.y, y, y + h)) >= s.r + 1) return;
    box.own ||= s.id === item.id;
    box.cost += s.id === item.id ? OWN : s.weight ?? FOREIGN;
  });
  return box;
}

/** Which labels are shown at which level where the wanted ones would cover too much: least important first to level 1, then standing ones go. */
export function thin(items, freePx2, dropStanding = true) {
  const area = (item) => (item.level ? item.sizes[item.level].w * item.sizes[item.level].h : 0);
  let covered = items.reduce((sum, item) => sum + area(item), 0);
  const limit = 0.3 * freePx2, byImportance = [...items].sort((a, b) => a.importance - b.importance);
  for (const item of byImportance) {
    if (covered <= limit) return;
    if (item.level > 1 && !item.must) {
      covered -= area(item);
      item.level = 1;
      covered += area(item);
    }
  }
  for (const item of dropStanding ? byImportance : []) {
    if (covered <= limit) return;
    if (item.standing && !item.must) {
      covered -= area(item);
      item.level = 0;
    }
  }
}

const clamp = (v, low, high) => (v < low ? low : v > high ? high : v);

export function overlap(a, b, gap = 0) {
  return a.x < b.x + b.w + gap && b.x < a.x + a.w + gap && a.y < b.y + b.h + gap && b.y < a.y + a.h + gap;
}

export function crosses(ax, ay, bx, by, cx, cy, dx, dy) {
  const side = (px, py, qx, qy, x, y) => (qx - px) * (y - py) - (qy - py) * (x - px);
  return side(ax, ay, bx, by, cx, cy) * side(ax, ay, bx, by, dx, dy) < 0 && side(cx, cy, dx, dy, ax, ay) * side(cx, cy, dx, dy, bx, by) < 0;
}

/** Whether a line passes through a box: cut off at its four sides (Liang and Barsky). */
export function cuts(ax, ay, bx, by, { x, y, w, h }) {
  let t0 = 0, t1 = 1;
  const dx = bx - ax, dy = by - ay;
  for (const [p, q] of [[-dx, ax - x], [dx, x + w - ax], [-dy, ay - y], [dy, y + h - ay]]) {
    if (p === 0) {
      if (q < 0) return false;
    } else if (p < 0) t0 = Math.max(t0, q / p);
    else t1 = Math.min(t1, q / p);
    if (t0 > t1) return false;
  }
  return true;
}

/** What lies where, in cells of 64 by 32 pixels. */
class Grid {
  #cells = new Map();

  #keys(x0, y0, x1, y1, use) {
    for (let j = Math.floor(y0 / 32); j <= Math.floor(y1 / 32); j++) {
      for (let i = Math.floor(x0 / 64); i <= Math.floor(x1 / 64); i++) if (use(i * 65536 + j)) return true;
    }
    return false;
  }

  add(thing, x0, y0, x1, y1) {
    this.#keys(x0, y0, x1, y1, (key) => {
      const cell = this.#cells.get(key);
      if (cell) cell.push(thing);
      else this.#cells.set(key, [thing]);
    });
  }

  remove(thing, x0, y0, x1, y1) {
    this.#keys(x0, y0, x1, y1, (key) => {
      const cell = this.#cells.get(key), at = cell?.indexOf(thing) ?? -1;
      if (at >= 0) cell.splice(at, 1);
    });
  }

  /** Things near a box until one answers true; one may come more than once. */
  some(x0, y0, x1, y1, test) {
    return this.#keys(x0, y0, x1, y1, (key) => {
      const cell = this.#cells.get(key);
      if (cell) for (let i = 0; i < cell.length; i++) if (test(cell[i])) return true;
      return false;
    });
  }

  /** Every thing near a box, once. */
  each(x0, y0, x1, y1, use) {
    const one = Math.floor(x0 / 64) === Math.floor(x1 / 64) && Math.floor(y0 / 32) === Math.floor(y1 / 32), seen = one ? null : new Set();
    this.#keys(x0, y0, x1, y1, (key) => {
      for (const thing of this.#cells.get(key) ?? []) {
        if (seen?.has(thing)) continue;
        seen?.add(thing);
        use(thing);
      }
      return false;
    });
  }
}
