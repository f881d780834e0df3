// The line for clearances of a controller's position: a text typed, to messages or to one error with its column.
//
//   line = callsign clause { ";" clause }    callsign = full | unique ending of two characters or more | "." (the one selected)
//
// No DOM here; `control` checks the same once more.

/** Word of each kind of clearance, its letter, whether vehicles can be told it, and what it says. */
export const CLEARANCES = [
  ["PSH", "P", false, "push and start"], ["TAX", "T", true, "taxi"], ["HLD", "H", true, "hold position"], ["CRO", "X", true, "cross"],
  ["LUP", "U", false, "line up"], ["TOF", null, false, "take off"], ["CTO", null, false, "cancel the take-off"], ["LND", "L", false, "land"],
  ["GOA", null, false, "go around"], ["BTR", "B", false, "backtrack"], ["ENT", "E", true, "enter"], ["SPD", "S", true, "keep a speed"],
  ["REV", null, true, "revoke"],
];

/** What each kind says, by its word. */
export const MEANS = new Map(CLEARANCES.map(([kind, , , words]) => [kind, words]));

/** What each error says to a person. */
export const LINE_ERRORS = {
  unknown_callsign: "no such call sign", ambiguous_callsign: "more than one call sign ends so", nothing_selected: "no target is selected",
  unknown_kind: "no such clearance", unknown_runway: "no such runway", unknown_place: "no such taxiway or place", unknown_stand: "no such stand",
  missing_runway: "a runway is missing", missing_limit: "the limit is missing: hold RUNWAY, stand STAND or to PLACE", missing_word: "a word is missing",
  bad_time: "a time is HHMM", bad_speed: "a speed is 1 to 250 kt", extra_word: "one word too many", not_for_vehicle: "not for a vehicle", empty: "nothing is said",
};

class LineError extends Error {
  constructor(code, column) {
    super(LINE_ERRORS[code]);
    this.code = code;
    this.column = column;
  }
}

/** { messages } of a line, or { error, column } with columns from 0. */
export function parseLine(line, context) {
  try {
    return { messages: messagesOf(line, context) };
  } catch (error) {
    if (!(error instanceof LineError)) throw error;
    return { error: error.code, column: error.column };
  }
}

function messagesOf(line, context) {
  const clauses = clausesOf(line);
  const first = clauses[0];
  if (!first.words.length) throw new LineError("empty", clauses.length > 1 ? first.end : 0);
  const to = callsign(first.words[0], context);
  first.words.shift();
  return clauses.map((clause) => {
    if (!clause.words.length) throw new LineError("empty", clause.end);
    return clauseOf(new Words(clause, context), to, context);
  });
}

/** The line cut at its semicolons: words with their columns, and where each clause ends. */
function clausesOf(line) {
  const clauses = [];
  let from = 0;
  for (const part of line.split(";")) {
    const words = [...part.matchAll(/\S+/g)].map((m) => ({ text: m[0], upper: m[0].toUpperCase(), column: from + m.index }));
    const last = words.at(-1);
    clauses.push({ words, end: last ? last.column + last.text.length : from + part.length });
    from += part.length + 1;
  }
  return clauses;
}

function callsign(word, { callsigns = [], selected = null }) {
  if (word.text === ".") {
    if (!selected) throw new LineError("nothing_selected", word.column);
    return selected;
  }
  const full = callsigns.find((c) => c.toUpperCase() === word.upper);
  if (full) return full;
  const ending = word.text.length >= 2 ? callsigns.filter((c) => c.toUpperCase().endsWith(word.upper)) : [];
  if (ending.length !== 1) throw new LineError(ending.length ? "ambiguous_callsign" : "unknown_callsign", word.column);
  return ending[0];
}

/** The words of a clause, taken one by one. */
class Words {
  constructor({ words, end }, context) {
    this.words = [...words];
    this.end = end;
    this.context = context;
  }

  next(missing) {
    const word = this.words.shift();
    if (!word && missing) throw new LineError(missing, this.end);
    return word;
  }

  peek() {
    return this.words[0]?.upper;
  }

  /** Takes a keyword if it is the next word. */
  keyword(...allowed) {
    if (!allowed.includes(this.peek())) return null;
    return this.words.shift().upper.toLowerCase();
  }

  #named(word, names, error) {
    const found = names?.find((name) => name.toUpperCase() === word.upper);
    if (found === undefined) throw new LineError(error, word.column);
    return found;
  }

  runway() {
    return this.#named(this.next("missing_runway"), this.context.runways, "unknown_runway");
  }

  stand() {
    return this.#named(this.next("missing_word"), this.context.stands, "unknown_stand");
  }

  place() {
    const { taxiways = [], places = [] } = this.context;
    return this.#named(this.next("missing_word"), [...taxiways, ...places], "unknown_place");
  }

  callsign() {
    return callsign(this.next("missing_word"), this.context);
  }

  done() {
    if (this.words.length) throw new LineError("extra_word", this.words[0].column);
  }
}

function kindOf(word) {
  return CLEARANCES.find(([kind, letter]) => kind === word.upper || letter === word.upper);
}

function clauseOf(words, to, { vehicles = [] }) {
  const word = words.next("empty"), known = kindOf(word);
  if (!known) throw new LineError("unknown_kind", word.column);
  const [kind, , forVehicles] = known;
  if (!forVehicles && vehicles.includes(to)) throw new LineError("not_for_vehicle", word.column);
  const body = BODIES[kind](words);
  words.done();
  return { to, kind, body };
}

const runwayOnly = (words) => ({ runway: words.runway() });
const optional = (words, keyword, name, read) => (words.keyword(keyword) ? { [name]: read() } : {});

const BODIES = {
  PSH(words) {
    const direction = words.keyword("LEFT", "RIGHT", "STRAIGHT");
    return { ...(direction ? { direction } : {}), ...optional(words, "TO", "until", () => words.place()) };
  },
  TAX(words) {
    const via = [];
    while (words.words.length && !["HOLD", "STAND", "TO", "FOLLOW", "GIVEWAY"].includes(words.peek())) via.push(words.place());
    const limit = words.keyword("HOLD", "STAND", "TO");
    if (!limit) throw new LineError("missing_limit", words.end);
    const body = { via, limit: { hold: () => ({ hold: words.runway() }), stand: () => ({ stand: words.stand() }), to: () => ({ place: words.place() }) }[limit]() };
    const other = words.keyword("FOLLOW", "GIVEWAY");
    if (other) body[other === "follow" ? "follow" : "give_way"] = words.callsign();
    return body;
  },
  HLD: () => ({}),
  CRO: (words) => ({ ...runwayOnly(words), ...optional(words, "AT", "place", () => words.place()) }),
  LUP: (words) => ({
    ...runwayOnly(words), ...optional(words, "AT", "place", () => words.place()), ...optional(words, "BEHIND", "behind", () => words.callsign()),
  }),
  TOF: runwayOnly,
  CTO: () => ({}),
  LND: runwayOnly,
  GOA: () => ({}),
  BTR: (words) => ({ ...runwayOnly(words), ...optional(words, "TO", "until", () => words.place()) }),
  ENT: (words) => ({ ...runwayOnly(words), ...optional(words, "UNTIL", "until_utc", () => clock(words.next("missing_word"))) }),
  SPD(words) {
    const word = words.next("missing_word");
    if (!/^\d{1,3}$/.test(word.text) || Number(word.text) < 1 || Number(word.text) > 250) throw new LineError("bad_speed", word.column);
    return { speed_kt: Number(word.text) };
  },
  REV(words) {
    const word = words.next("missing_word"), known = kindOf(word);
    if (!known) throw new LineError("unknown_kind", word.column);
    return { revokes: known[0] };
  },
};

function clock(word) {
  const m = /^([01]\d|2[0-3])([0-5]\d)$/.exec(word.text);
  if (!m) throw new LineError("bad_time", word.column);
  return `${m[1]}:${m[2]}`;
}
