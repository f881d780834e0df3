// Places labels beside their targets: none over another, none over a symbol where that can be helped, each
// near where it was in the picture before.
//
// Every label has candidate places: 16 directions on rings around its target. A place costs for what it covers
// (other labels: forbidden; symbols, leaders crossing), for its distance, for leaving the view and for moving
// away from its last place. Labels are placed in order of importance, then each in turn may move to a better place
// until nothing changes; a label that finds no free place is tried in its short form, then left out.

const DIRECTIONS = 16;
const RINGS = [14, 30, 52, 82, 120];
const GAP = 3;
const ROUNDS = 3;
const CROWD = 120, SWAPS = 60;

/**
 * items: { id, x, y, priority, sizes: [{w, h}, …] } in pixels; sizes from full to short form.
 * options: { width, height, obstacles: [{x, y, r}], before: Map id → {dx, dy},
 * blocked: [{x, y, w, h}] }; an item's `reach` is the radius of its own symbol
 * Returns Map id → { x, y, w, h, form, ax, ay, dx, dy }: the box, the form chosen, where the leader ends, and the
 * offset to hand in again as `before`. Labels without a place are not in it.
 */
export function place(items, { width, height, obstacles = [], before = new Map(), blocked = [] }) {
  const order = [...items].sort((a, b) => b.priority - a.priority || (a.id < b.id ? -1 : 1));
  const placed = new Map();
  const grid = new Grid();
  const dots = new Grid();
  for (const o of obstacles) dots.add(o, { x: o.x - o.r, y: o.y - o.r, w: 2 * o.r, h: 2 * o.r });
  const context = { width, height, dots, before, grid, blocked };
  for (const item of order) settle(item, placed, context);
  // Work is bounded, so that a crowd costs no more than a flicker; what is left over is done in the next picture.
  context.swaps = SWAPS;
  const rounds = items.length > CROWD ? 0 : ROUNDS;
  for (const item of rounds ? [] : order) makeRoom(item, placed, context);
  for (let round = 0; round < rounds; round++) {
    let moved = false;
    for (const item of order) {
      const now = placed.get(item.id);
      if (now && (now.cost < CHEAP || stays(now, before))) continue;
      if (now) grid.remove(now);
      placed.delete(item.id);
      settle(item, placed, context);
      const next = placed.get(item.id);
      moved ||= next?.x !== now?.x || next?.y !== now?.y;
    }
    for (const item of order) moved ||= makeRoom(item, placed, context);
    if (!moved) break;
  }
  return placed;
}

const CHEAP = 12;
const STAY = 14;
const BAD = 14, SHORT = 20, MISSING = 200; // costs that call for a neighbour to make room

/** Lets a badly placed label take the place of a neighbour, if the two are better off together. */
function makeRoom(item, placed, context) {
  const now = placed.get(item.id);
  const cost = (p) => (p ? p.cost + p.form * SHORT : MISSING);
  if (cost(now) < BAD || (now && stays(now, context.before))) return false;
  const around = { x: item.x - 110, y: item.y - 70, w: 220, h: 140 };
  const neighbours = [];
  context.grid.some(around, 0, (n) => void neighbours.push(n));
  for (const neighbour of neighbours) {
    if (context.swaps <= 0) return false;
    if (neighbour.item === item || neighbour.item.priority >= item.priority + 900) continue;
    context.swaps--;
    const other = neighbour.item, sum = cost(now) + cost(neighbour);
    const remove = (p) => {
      if (!p) return;
      context.grid.remove(p);
      placed.delete(p.item.id);
    };
    remove(placed.get(item.id));
    remove(neighbour);
    settle(item, placed, context);
    settle(other, placed, context);
    if (cost(placed.get(item.id)) + cost(placed.get(other.id)) < sum - 2) return true;
    remove(placed.get(item.id));
    remove(placed.get(other.id));
    for (const p of [now, neighbour]) {
      if (!p) continue;
      placed.set(p.item.id, p);
      context.grid.add(p, p);
    }
  }
  return false;
}

/** Whether a label is in its old place and not much worse off there. */
function stays(now, before) {
  const last = before.get(now.item.id);
  return last !== undefined && last.dx === now.dx && last.dy === now.dy && now.form === 0 && now.cost < 3 * BAD;
}

function settle(item, placed, context) {
  for (let form = 0; form < item.sizes.length; form++) {
    const best = cheapest(item, form, context);
    if (best) {
      placed.set(item.id, best);
      context.grid.add(best, best);
      return;
    }
  }
}

function cheapest(item, form, context) {
  const last = context.before.get(item.id);
  const size = item.sizes[form];
  let best = null;
  const consider = (dx, dy, bias) => {
    const box = boxAt(item, size, dx, dy);
    const cost = costOf(item, box, dx, dy, last, context) + bias;
    if (cost < (best?.cost ?? Infinity)) best = { ...box, form, dx, dy, cost, item };
  };
  if (last) consider(last.dx, last.dy, -STAY); // staying is worth some disorder
  const own = Math.max(0, (item.reach ?? 8) - 8);
  for (const [ring, beyond] of RINGS.entries()) {
    const radius = beyond + own;
    if (best && best.cost < ring * 4) break; // farther out cannot be cheaper
    for (let k = 0; k < DIRECTIONS; k++) {
      const angle = ((k + 0.5) / DIRECTIONS) * 2 * Math.PI;
      consider(Math.cos(angle) * radius, Math.sin(angle) * radius, ring * 4);
    }
  }
  return best;
}

/** The box whose nearest edge point to the target lies at (dx, dy). */
function boxAt(item, { w, h }, dx, dy) {
  const length = Math.hypot(dx, dy) || 1;
  const ax = item.x + dx, ay = item.y + dy;
  const x = ax - w / 2 + (dx / length) * (w / 2);
  const y = ay - h / 2 + (dy / length) * (h / 2);
  return { x: Math.round(x), y: Math.round(y), w, h,
    ax: clamp(item.x, Math.round(x), Math.round(x) + w), ay: clamp(item.y, Math.round(y), Math.round(y) + h) };
}

function costOf(item, box, dx, dy, last, { grid, dots, width, height, blocked }) {
  if (box.x < 2 || box.y < 2 || box.x + box.w > width - 2 || box.y + box.h > height - 2) return Infinity;
  if (grid.some(box, GAP, (other) => overlap(box, other, GAP))) return Infinity;
  if (blocked.some((b) => overlap(box, b, GAP))) return Infinity;
  let cost = dx > 0 ? 0 : 1.5; // right of the target reads best
  if (dy > 0) cost += 1;
  dots.some(box, GAP, (dot) => {
    if (covers(box, dot)) cost += dot.own && dot.id === item.id ? 40 : dot.weight ?? 14;
  });
  const leader = { x1: item.x, y1: item.y, x2: box.ax, y2: box.ay };
  grid.some(spanOf(leader), 0, (other) => {
    if (cuts(leader, other)) cost += 25;
    else if (crosses(leader, { x1: other.item.x, y1: other.item.y, x2: other.ax, y2: other.ay })) cost += 15;
  });
  if (last) {
    const turn = Math.abs(Math.atan2(dy * last.dx - dx * last.dy, dx * last.dx + dy * last.dy));
    cost += turn * 5;
  }
  return cost;
}

const clamp = (v, low, high) => Math.max(low, Math.min(high, v));

export function overlap(a, b, gap = 0) {
  return a.x < b.x + b.w + gap && b.x < a.x + a.w + gap && a.y < b.y + b.h + gap && b.y < a.y + a.h + gap;
}

function covers(box, { x, y, r }) {
  return Math.hypot(x - clamp(x, box.x, box.x + box.w), y - clamp(y, box.y, box.y + box.h)) < r + 1;
}

function spanOf({ x1, y1, x2, y2 }) {
  return { x: Math.min(x1, x2), y: Math.min(y1, y2), w: Math.abs(x2 - x1), h: Math.abs(y2 - y1) };
}

function crosses(a, b) {
  const side = (l, x, y) => Math.sign((l.x2 - l.x1) * (y - l.y1) - (l.y2 - l.y1) * (x - l.x1));
  return side(a, b.x1, b.y1) * side(a, b.x2, b.y2) < 0 && side(b, a.x1, a.y1) * side(b, a.x2, a.y2) < 0;
}

/** Whether the line goes through the box. */
function cuts(line, box) {
  const { x, y, w, h } = box;
  return crosses(line, { x1: x, y1: y, x2: x + w, y2: y + h }) || crosses(line, { x1: x + w, y1: y, x2: x, y2: y + h });
}

/** Finds what lies near a box without looking at everything. */
class Grid {
  static CELL = 96;
  #cells = new Map();
  #look = 0;

  add(thing, box) {
    this.#cellsOf(box, 0, (key) => {
      const cell = this.#cells.get(key);
      if (cell) cell.push(thing);
      else this.#cells.set(key, [thing]);
    });
  }

  remove(thing) {
    this.#cellsOf(thing, 0, (key) => {
      const cell = this.#cells.get(key), at = cell ? cell.indexOf(thing) : -1;
      if (at >= 0) cell.splice(at, 1);
    });
  }

  /** Calls `visit` once for each thing near the box, until it returns true; says whether it did. */
  some(box, gap, visit) {
    const look = ++this.#look;
    return this.#cellsOf(box, gap, (key) => {
      for (const thing of this.#cells.get(key) ?? NOTHING) {
        if (thing.look === look) continue;
        thing.look = look;
        if (visit(thing)) return true;
      }
      return false;
    });
  }

  #cellsOf(box, gap, visit) {
    const c = Grid.CELL, last = Math.floor((box.x + box.w + gap) / c), low = Math.floor((box.y + box.h + gap) / c);
    for (let i = Math.floor((box.x - gap) / c); i <= last; i++) {
      for (let j = Math.floor((box.y - gap) / c); j <= low; j++) if (visit(i * 65536 + j)) return true;
    }
    return false;
  }
}

const NOTHING = [];
