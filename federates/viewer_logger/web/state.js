// The view as text: what stands after the # of the address, both ways. No DOM here.
//
// `key=value` joined by `&`, percent-encoded UTF-8. A bad value is refused alone, unknown keys are kept and written last,
// of a key given twice the first counts. Keys are written in the order of KEYS.

/** Letter in the address and name of every layer that can be switched. */
export const LAYER_LETTERS = new Map([
  ["k", "tracks"], ["t", "truth"], ["e", "errors"], ["l", "labels"], ["h", "history"], ["v", "vectors"], ["c", "ellipses"],
  ["w", "weather"], ["x", "taxiways"], ["s", "stands"], ["o", "coverage"], ["p", "plots"], ["r", "video"], ["b", "buildings"],
  ["a", "alerts"], ["u", "routes"], ["d", "detection"], ["g", "one second ago"], ["f", "foreign"],
]);
const LETTER_OF = new Map([...LAYER_LETTERS].map(([letter, name]) => [name, letter]));

const LONGEST = 64, MOST_RUNS = 8, MOST_PANES = 4, MOST_PAIRS = 8, MOST_UNKNOWN = 16;
const NUMBER = /^-?\d{1,7}(\.\d{1,6})?$/;
const PANE = /^(map|tracks|curve|strips|dial|sensor:\d{1,5}|eye:(tower|(pilot|driver)(:[^:]{1,64})?))$/u;

/** A kind of value: `read` gives undefined for a bad one, `write` the text again. */
const number = (low = -Infinity, high = Infinity) => ({
  read: (text) => (NUMBER.test(text) && Number(text) >= low && Number(text) <= high ? Number(text) + 0 : undefined),
  write: decimal,
});
const oneOf = (...words) => ({ read: (text) => (words.includes(text) ? text : undefined), write: (word) => word });
const flag = { read: (text) => ({ 0: false, 1: true })[text], write: (on) => (on ? "1" : "0") };
const text = { read: (value) => (printable(value) ? value : undefined), write: encode };
const list = (item, least, most, join = ",") => ({
  read(value) {
    const items = value.split(join).map(item.read);
    return items.length >= least && items.length <= most && !items.includes(undefined) ? items : undefined;
  },
  write: (items) => items.map(item.write).join(join),
});
/** Something of a sensor: its number, `~`, and what. */
const ofSensor = {
  read(value) {
    const parts = list(text, 2, 2, "~").read(value);
    return parts && /^\d{1,5}$/.test(parts[0]) ? parts : undefined;
  },
  write: list(text, 2, 2, "~").write,
};
const angle = {
  read: (value) => (NUMBER.test(value) ? turn(Number(value)) : undefined),
  write: (degrees) => decimal(turn(degrees)),
};
const time = {
  read: (value) => (value === "live" ? value : number(0).read(value)),
  write: (value) => (value === "live" ? value : decimal(value)),
};
const loop = {
  read(value) {
    const ends = list(number(0), 2, 2).read(value);
    return ends && ends[0] <= ends[1] ? ends : undefined;
  },
  write: list(number(), 2, 2).write,
};
const layers = {
  read(value) {
    const letters = [...value];
    const known = letters.every((l) => LAYER_LETTERS.has(l)) && new Set(letters).size === letters.length;
    return known ? letters.map((l) => LAYER_LETTERS.get(l)).sort() : undefined;
  },
  write: (names) => names.map((name) => LETTER_OF.get(name) ?? "").sort().join(""),
};
const inset = {
  read(value) {
    const parts = list(number(), 3, 4).read(value);
    if (!parts || parts[2] < 0.02 || parts[2] > 40) return undefined;
    return parts.length === 4 ? [...parts.slice(0, 3), turn(parts[3])] : parts;
  },
  write: list(number(), 3, 4).write,
};
const detail = {
  read: (value) => (value === "auto" ? value : /^[123]$/.test(value) ? Number(value) : undefined),
  write: String,
};
const pane = { read: (value) => (PANE.test(value) ? value : undefined), write: encode };

/** Every key that is known, in the order of writing. */
export const KEYS = new Map(Object.entries({
  run: list(text, 1, MOST_RUNS), t: time, ab: loop, x: number(), y: number(), z: number(0.02, 40), rot: angle,
  fit: oneOf("airport", "targets"), lay: layers, sel: text, follow: flag, play: flag, skin: oneOf("research", "controller"),
  pane: list(pane, 1, MOST_PANES), tab: text, col: oneOf("night", "day"), in1: inset, in2: inset,
  rb: list(list(text, 2, 2, "~"), 1, MOST_PAIRS), find: text, lod: detail, vec: number(0, 60), hist: number(0, 30),
  cmp: oneOf("side", "ghost", "difference"), eff: ofSensor,
}));

/** Reads what follows the #. Returns { state, refused: keys, kept: raw texts of unknown keys }. */
export function readState(fragment) {
  const state = {}, refused = [], kept = [];
  const raw = fragment.replace(/^#/, "");
  for (const part of raw === "" ? [] : raw.split("&")) {
    const at = part.indexOf("="), key = at < 0 ? part : part.slice(0, at);
    const kind = KEYS.get(key);
    if (!kind) {
      if (part !== "" && part.length <= LONGEST && kept.length < MOST_UNKNOWN) kept.push(part);
      continue;
    }
    const value = Object.hasOwn(state, key) || at < 0 ? undefined : decoded(part.slice(at + 1));
    const read = value === undefined ? undefined : kind.read(value);
    if (read === undefined) refused.push(key);
    else state[key] = read;
  }
  return { state, refused, kept };
}

/** The canonical text of a state, with its #. */
export function writeState(state, kept = []) {
  const parts = [];
  for (const [key, kind] of KEYS) {
    if (state[key] !== undefined && state[key] !== null) parts.push(`${key}=${kind.write(state[key])}`);
  }
  return `#${[...parts, ...kept].join("&")}`;
}

/** A number as the address writes it: at most six decimals, no exponent. */
export function decimal(value) {
  const shown = value.toFixed(6).replace(/\.?0+$/, "");
  return shown === "-0" ? "0" : shown;
}

function turn(degrees) {
  return (((degrees % 360) + 360) % 360) + 0;
}

function decoded(value) {
  try {
    return decodeURIComponent(value);
  } catch {
    return undefined; // %zz
  }
}

function printable(value) {
  return value !== "" && [...value].length <= LONGEST && !/\p{C}/u.test(value);
}

/** Percent-encoding that leaves alone what an address bar shows well and no reader of a fragment mistakes. */
function encode(value) {
  return encodeURIComponent(value).replace(/%(23|2C|2F|3A|3B|3F|40|24)/g, (hex) => decodeURIComponent(hex));
}
