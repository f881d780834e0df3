// Reads the binary form of a scan; federates/viewer_logger/frame.rs writes it and says how it is laid out.

const VERSION = 3;
const HEADER = 40, TRACK = 152, TRUTH = 80, PLOT = 56;

/** Words of a track in the order of their numbers; the server says them. */
let words = { types: [], statuses: [], movements: [], doing: [], cleared: [] };

/** Takes the server's words. */
export function setWords(told) {
  words = { doing: [], cleared: [], ...told };
}

/** Kinds of sensors in the order of the numbers in plots: word, title, colours, symbol; the server says them. */
export const kinds = [];
const colours = typeof CSSStyleSheet === "undefined" ? { replaceSync() {} } : new CSSStyleSheet(); // none where laws are tested
if (typeof document !== "undefined") document.adoptedStyleSheets = [...document.adoptedStyleSheets, colours];

/** Takes the server's kinds; their colours become --plot-WORD of the style sheet. */
export function setKinds(list) {
  kinds.splice(0, kinds.length, ...list.filter((k) => /^[a-z_]+$/.test(k.word) && k.colours.every((c) => /^#[0-9a-f]{6}$/.test(c))));
  const rule = (side) => kinds.map((k) => `--plot-${k.word}: ${k.colours[side]};`).join(" ");
  colours.replaceSync(`:root { ${rule(0)} } :root[data-colours="day"] { ${rule(1)} }`);
}

const decoder = new TextDecoder("utf-8");

/** The scan in `buffer`; throws an Error with a reason if it is none. */
export function decode(buffer) {
  const view = new DataView(buffer);
  if (view.byteLength < HEADER || decoder.decode(new Uint8Array(buffer, 0, 4)) !== "SEED") {
    throw new Error("a message that is not a valid scan");
  }
  if (view.getUint8(4) !== VERSION) {
    throw new Error(`scans of version ${view.getUint8(4)}, this page reads ${VERSION}: reload it`);
  }
  const count = [24, 28, 32, 36].map((at) => view.getUint32(at, true));
  const size = HEADER + count[0] * TRACK + count[1] * TRUTH + count[2] * PLOT;
  if (view.byteLength < size + count[3] * 4) throw new Error("a scan cut short");
  let at = HEADER;
  const records = (n, width, read) => Array.from({ length: n }, () => (at += width, read(view, at - width)));
  const scan = {
    newest: (view.getUint8(5) & 1) === 1,
    run: view.getUint16(6, true),
    scan: Number(view.getBigUint64(8, true)),
    timeS: Number(view.getBigInt64(16, true)) / 1e9,
    tracks: records(count[0], TRACK, readTrack),
    truth: records(count[1], TRUTH, readTruth),
    plots: records(count[2], PLOT, readPlot),
    trails: new Map(),
  };
  for (let i = 0; i < count[3]; i++) {
    const number = view.getUint16(at, true), points = view.getUint16(at + 2, true);
    if (view.byteLength < at + 4 + points * 8) throw new Error("a scan cut short");
    scan.trails.set(number, Array.from({ length: points },
      (_, k) => [view.getFloat32(at + 4 + k * 8, true), view.getFloat32(at + 8 + k * 8, true)]));
    at += 4 + points * 8;
  }
  for (const track of scan.tracks) track.truth = scan.truth[track.truthIndex] ?? null;
  return scan;
}

function readTrack(view, at) {
  const f32 = (offset) => view.getFloat32(at + offset, true);
  const flags = view.getUint16(at + 4, true);
  const wake = view.getUint8(at + 7);
  return {
    id: `t${view.getUint16(at, true)}`,
    number: view.getUint16(at, true),
    type: words.types[view.getUint8(at + 2)] ?? "none",
    status: words.statuses[view.getUint8(at + 3)] ?? "unknown",
    first: (flags & 1) !== 0,
    manoeuvre: (flags & 2) !== 0,
    movement: words.movements[view.getUint8(at + 6) - 1] ?? "",
    wake: wake ? String.fromCharCode(wake) : "",
    truthIndex: view.getInt32(at + 8, true),
    callsign: text(view, at + 12, 12),
    designator: text(view, at + 24, 8),
    runwayStand: text(view, at + 32, 24),
    x: view.getFloat64(at + 56, true),
    y: view.getFloat64(at + 64, true),
    vx: f32(72), vy: f32(76),
    cov: [f32(80), f32(84), f32(88)],
    errorM: known(f32(92)),
    heading: f32(100),
    altitudeM: known(f32(104)),
    address: view.getUint32(at + 112, true) ? view.getUint32(at + 112, true).toString(16).padStart(6, "0") : "",
    plotAgeS: known(f32(116)),
    doing: words.doing[view.getUint8(at + 120)] ?? "",
    derived: (view.getUint8(at + 125) & 8) !== 0,
    alertStage: view.getUint8(at + 121),
    emitter: view.getUint8(at + 122),
    cleared: words.cleared[view.getUint8(at + 124) - 1] ?? "",
    sensors: kinds.map((k) => k.word).filter((_, bit) => view.getUint8(at + 123) & (1 << bit)),
    assumed: (view.getUint8(at + 125) & 1) !== 0,
    unresolved: (view.getUint8(at + 125) & 2) !== 0,
    labelP: share(view.getUint8(at + 126)),
    existenceP: share(view.getUint8(at + 127)),
    lag: known(f32(128)) === null ? null : { x: f32(128), y: f32(132), cov: [f32(136), f32(140), f32(144)], coasted: (view.getUint8(at + 125) & 4) !== 0 },
  };
}

function readTruth(view, at) {
  const f32 = (offset) => view.getFloat32(at + offset, true);
  const flags = view.getUint32(at + 28, true);
  const number = view.getInt32(at + 72, true);
  return {
    id: `e${view.getBigUint64(at, true)}`,
    callsign: text(view, at + 8, 12),
    designator: text(view, at + 20, 8),
    aircraft: (flags & 1) !== 0,
    ours: (flags & 2) !== 0,
    x: view.getFloat64(at + 32, true),
    y: view.getFloat64(at + 40, true),
    vx: f32(48), vy: f32(52),
    heading: f32(56),
    lengthM: f32(60), spanM: f32(64),
    altitudeM: known(f32(68)),
    track: number < 0 ? null : number,
  };
}

function readPlot(view, at) {
  const f32 = (offset) => view.getFloat32(at + offset, true);
  const track = view.getInt32(at + 48, true);
  return {
    sensor: view.getUint16(at, true),
    kind: kinds[view.getUint8(at + 2)]?.word ?? "other",
    truthIndex: view.getInt32(at + 4, true),
    x: view.getFloat64(at + 8, true),
    y: view.getFloat64(at + 16, true),
    cov: [f32(24), f32(28), f32(32)],
    scnrDb: known(f32(36)),
    ageS: f32(40),
    errorM: known(f32(44)),
    track: track < 0 ? null : track,
  };
}

const known = (value) => (Number.isFinite(value) ? value : null);
/** A probability in an octet; null where nobody says it. */
const share = (octet) => (octet === 255 ? null : octet / 254);

function text(view, at, width) {
  const octets = new Uint8Array(view.buffer, view.byteOffset + at, width);
  const end = octets.indexOf(0);
  return decoder.decode(end < 0 ? octets : octets.subarray(0, end));
}
