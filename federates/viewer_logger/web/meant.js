// What a typed line means in this run: clearances in words, each held against what the flight is planned to do. No DOM here.
//
// People clear kinds of clearances; ways, stands and runways are those of the plan (docs/control.md, "Take a seat"). A line may name
// them: what agrees is sent, what is missing is completed from the plan, and what disagrees is refused with its reason and its column.

import { CLEARANCES, LINE_ERRORS, MEANS, parseLine } from "./line.js";
import { KINDS_SAID } from "./seat.js";

const MOST_CLAUSES = 8, BESIDE_M = 8, SAMPLE_M = 10;
const KEYWORDS = ["LEFT", "RIGHT", "STRAIGHT", "TO", "HOLD", "STAND", "FOLLOW", "GIVEWAY", "AT", "BEHIND", "UNTIL"];
const same = (a, b) => a.replaceAll("_", " ").toUpperCase() === b.replaceAll("_", " ").toUpperCase();

/** A name as a word of the line: no blanks in it. */
export const wordOf = (name) => name.replaceAll(" ", "_");

/** What the line may name at this airport and in this run: names of the map, call signs, who is a vehicle. */
export function contextOf({ airport, flights, traffic, selected }) {
  const list = (names) => [...new Set(names.filter(Boolean).map(wordOf))];
  return {
    callsigns: [...new Set([...flights.map((f) => f.callsign), ...(traffic?.movers ?? []).map((m) => m.callsign)])],
    vehicles: flights.filter((f) => f.movement === "vehicle").map((f) => f.callsign), selected,
    runways: list((airport?.runways ?? []).flatMap((r) => r.designators)), taxiways: list((airport?.taxiways ?? []).map((t) => t.name)),
    stands: list((airport?.stands ?? []).map((s) => s.name)), places: list((airport?.stands ?? []).map((s) => s.name)),
    plan: (callsign) => planOf(callsign, { airport, flights, traffic }),
  };
}

/** What a flight is planned to do, or null: { movement, runway, stand, along: names of taxiways ahead, crosses: pairs of designators ahead }. */
export function planOf(callsign, { airport, flights, traffic }) {
  const flight = flights.find((f) => f.callsign === callsign), mover = traffic?.movers.find((m) => m.callsign === callsign);
  if (!flight && !mover) return null;
  const way = mover ? [...mover.authority_m, ...mover.planned_m] : [];
  return {
    movement: flight?.movement ?? "", runway: mover?.runway || flight?.runway || "", stand: mover?.stand || flight?.stand || "",
    along: mover ? alongOf(way, airport?.taxiways ?? []) : null, crosses: mover ? crossedBy(way, airport?.runways ?? []) : null,
  };
}

/** Names of the taxiways of which a piece lies on a way. */
export function alongOf(way, taxiways) {
  const near = ([x, y]) => way.some(([ax, ay], i) => {
    if (!i) return false;
    const [bx, by] = way[i - 1], dx = bx - ax, dy = by - ay, t = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
    return Math.hypot(x - ax - t * dx, y - ay - t * dy) <= BESIDE_M;
  });
  const on = ({ points_m: points }) => points.some((b, i) => i && near([(points[i - 1][0] + b[0]) / 2, (points[i - 1][1] + b[1]) / 2]));
  return [...new Set(taxiways.filter((t) => t.name && on(t)).map((t) => wordOf(t.name)))];
}

/** Runways that a way comes over, in its order: their designators. */
export function crossedBy(way, runways) {
  const found = [];
  const take = ([x, y]) => {
    for (const r of runways) {
      const [a, b] = r.ends, length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1, ux = (b[0] - a[0]) / length, uy = (b[1] - a[1]) / length;
      const along = (x - a[0]) * ux + (y - a[1]) * uy, beside = Math.abs((x - a[0]) * uy - (y - a[1]) * ux);
      if (along >= 0 && along <= length && beside <= r.width_m / 2 && !found.includes(r.designators)) found.push(r.designators);
    }
  };
  way.forEach((p, i) => {
    const q = way[Math.max(0, i - 1)], steps = Math.max(1, Math.ceil(Math.hypot(p[0] - q[0], p[1] - q[1]) / SAMPLE_M));
    for (let s = 1; s <= steps; s++) take([q[0] + ((p[0] - q[0]) * s) / steps, q[1] + ((p[1] - q[1]) * s) / steps]);
  });
  return found;
}

/** { line: completed, messages, orders: [{ callsign, clearance, words }] } or { error, column, text } with the column in the line as typed. */
export function meant(line, context) {
  const added = [];
  let text = line, parsed = parseLine(text, context);
  for (let i = 0; i < MOST_CLAUSES && parsed.error; i++) {
    const more = missing(text, parsed, context);
    if (!more) break;
    const completed = parseLine(text.slice(0, parsed.column) + more + text.slice(parsed.column), context);
    if (completed.error === parsed.error && completed.column === parsed.column + more.length) break;
    text = text.slice(0, parsed.column) + more + text.slice(parsed.column);
    added.push([parsed.column, more.length]);
    parsed = completed;
  }
  const typedAt = (column) => added.reduceRight((at, [from, length]) => (at > from ? Math.max(from, at - length) : at), column);
  if (parsed.error) return { error: parsed.error, column: typedAt(parsed.column), text: `${LINE_ERRORS[parsed.error]}` };
  const clauses = clausesOf(text);
  for (const [i, message] of parsed.messages.entries()) {
    const wrong = disagrees(message, context.plan?.(message.to) ?? null);
    if (wrong) return { error: wrong.error, column: typedAt(columnOf(clauses[i], wrong.word)), text: wrong.text };
  }
  return { line: text, messages: parsed.messages, orders: parsed.messages.map((m) => ({ callsign: m.to, clearance: m.kind, words: wordsOf(m) })) };
}

/** For whom a line is, as far as it is typed; null for nobody yet. */
export function whom(line, context) {
  return parseLine(`${line.trim().split(/[\s;]/)[0]} HLD`, context).messages?.[0].to ?? null;
}

/** The clauses of a line: where each begins, and its text. */
function clausesOf(line) {
  let from = 0;
  return line.split(";").map((text) => {
    const clause = { from, text };
    from += text.length + 1;
    return clause;
  });
}

function columnOf({ from, text }, word) {
  const at = [...text.matchAll(/\S+/g)].find((m) => word && same(m[0], word));
  return from + (at ? at.index : text.trimEnd().length);
}

/** What is added at the end of a clause that lacks its limit or runway: the plan's, or nothing. */
function missing(line, { error, column }, context) {
  if (!["missing_limit", "missing_runway"].includes(error)) return "";
  const clauses = clausesOf(line), at = clauses.findIndex(({ from, text }) => from + text.trimEnd().length === column);
  if (at < 0) return "";
  const words = clauses[at].text.trim().split(/\s+/), to = whom(line, context), plan = to ? context.plan?.(to) : null;
  if (!plan) return "";
  const kind = CLEARANCES.find(([word, letter]) => [word, letter].includes(words[at ? 0 : 1].toUpperCase()))?.[0];
  if (error === "missing_limit") {
    if (plan.movement === "departure" && plan.runway) return ` hold ${plan.runway}`;
    return plan.movement === "arrival" && plan.stand ? ` stand ${wordOf(plan.stand)}` : "";
  }
  const runway = kind === "CRO" ? plan.crosses?.[0]?.[0] : plan.runway;
  return runway ? ` ${runway}` : "";
}

/** What a message says that this run would not do: { error, word, text }, or null. */
function disagrees({ to, kind, body }, plan) {
  const no = (error, word, text) => ({ error, word, text });
  if (!KINDS_SAID.includes(kind)) return no("not_said_here", kind, `nobody in this run is told ${kind} (${MEANS.get(kind)})`);
  const { direction, until, place, behind, follow, give_way: giveWay } = body, more = direction ?? until ?? place ?? behind ?? follow ?? giveWay;
  if (more) return no("not_said_here", more, `${to} does so as it is planned: leave out what ${more} says`);
  if (!plan) return null;
  const runway = body.runway ?? body.limit?.hold;
  if (kind === "CRO") {
    const ways = plan.crosses?.map((r) => r.join("/")) ?? [];
    if (plan.crosses && !plan.crosses.flat().includes(runway)) return no("other_runway", runway, ways.length ? `${to} crosses ${ways.join(", ")} on its way, not ${runway}` : `${to} crosses no runway on its way`);
    return null;
  }
  if (runway && plan.runway && !same(runway, plan.runway)) return no("other_runway", runway, `${to} is planned on ${plan.runway}: ask "What if" with RUNWAY ${runway}`);
  if (kind !== "TAX") return null;
  const strange = (body.via ?? []).find((name) => plan.along && !plan.along.some((a) => same(a, name)));
  if (strange) return no("other_way", strange, `the way of ${to} does not go along ${strange}${plan.along.length ? `: ${plan.along.slice(0, 8).join(" ")}` : ""}`);
  const { stand } = body.limit, end = stand ?? body.limit.place;
  if (end && !(plan.movement === "arrival" && same(end, plan.stand))) {
    return no("other_limit", end, plan.movement === "arrival" ? `${to} is planned to stand ${plan.stand}: ask "What if" with STAND ${end}` : `${to} taxies to its holding position: hold ${plan.runway}`);
  }
  if (body.limit.hold && plan.movement === "arrival") return no("other_limit", body.limit.hold, `${to} taxies to its stand: stand ${wordOf(plan.stand)}`);
  return null;
}

/** A message in words. */
export function wordsOf({ to, kind, body }) {
  const limit = body.limit && (body.limit.hold ? `hold short of ${body.limit.hold}` : `to ${body.limit.stand ?? body.limit.place}`);
  return [`${to}:`, MEANS.get(kind), body.runway ?? "", (body.via ?? []).join(" "), limit ?? ""].filter(Boolean).join(" ");
}

const FLIES = ["TOF", "LND"], ENTERS = ["LUP", "CRO"];

/** Why a clearance is asked back before it is said: it excludes one that stands on the same runway. "" where none does. */
export function conflictOf({ to, kind, body }, { airport, traffic, places = new Map() }) {
  const shape = (airport?.runways ?? []).find((r) => r.designators.includes(body.runway));
  if (!shape || ![...FLIES, ...ENTERS].includes(kind)) return "";
  for (const mover of traffic?.movers ?? []) {
    for (const c of mover.callsign === to ? [] : mover.cleared ?? []) {
      if (!shape.designators.includes(c.runway)) continue;
      const flies = FLIES.includes(kind), other = FLIES.includes(c.kind), both = flies && other;
      const ahead = flies && ENTERS.includes(c.kind) ? isAhead(shape, body.runway, places.get(to), places.get(mover.callsign))
        : ENTERS.includes(kind) && other ? isAhead(shape, c.runway, places.get(mover.callsign), places.get(to)) : false;
      if (both || ahead) return `${mover.callsign} is cleared ${c.kind} ${c.runway}`;
    }
  }
  return "";
}

/** Whether who enters is ahead of who rolls or lands; taken for so where nobody can tell. */
function isAhead({ ends, designators }, runway, flier, enters) {
  if (!flier || !enters) return true;
  const [a, b] = designators.indexOf(runway) === 0 ? ends : [ends[1], ends[0]], ux = b[0] - a[0], uy = b[1] - a[1];
  return (enters[0] - flier[0]) * ux + (enters[1] - flier[1]) * uy > 0;
}

/** Words that may stand where the line ends: those with which the line has no error there. At most 40. */
export function completions(line, context) {
  const at = line.search(/\S*$/), begun = line.slice(at).toUpperCase(), before = line.slice(0, at);
  const first = !before.trim();
  const pool = first ? context.callsigns : [...CLEARANCES.map(([kind]) => kind), ...KEYWORDS, ...context.runways, ...context.taxiways, ...context.stands, ...context.places, ...context.callsigns];
  const fits = (word) => {
    if (!word.toUpperCase().startsWith(begun) && !(first && begun.length >= 2 && word.toUpperCase().endsWith(begun))) return false;
    const { error, column } = parseLine(before + word, context);
    return first || !error || column !== at;
  };
  return [...new Set(pool.filter(fits))].slice(0, 40);
}
