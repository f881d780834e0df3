// Wires the page together: messages of the server in, map, lists and controls out.

import { Curve } from "./curve.js";
import { decode } from "./frame.js";
import { Link } from "./link.js";
import { closeUp, LAYERS, MapView, plotMark } from "./map.js";
import {
  facts, flightColumns, showEffects, showFederates, showOperations, showRungs, showSensors, Table, targetFacts, TRACK_COLUMNS,
} from "./panels.js";
import { element, elapsed, fixed, place, utc, visibility, wind } from "./text.js";

const byId = (id) => document.getElementById(id);

const state = {
  run: null, airport: null, notices: [], runState: null, timeline: null, weather: null, flights: [], federates: [], operations: [],
  plan: [], scan: null, live: true, selected: null, link: "connecting", notice: null, playing: false, answer: null,
};

// ---- parts ----

const map = new MapView(byId("map"), () => showFollow());
map.onPick = (id) => select(id);
map.onPointer = (p) => {
  byId("pointer").textContent = p ? place(...p) : "";
};

const curve = new Curve(byId("curve"), (scan) => showScan(scan));

const tracks = new Table(byId("tracks"), TRACK_COLUMNS, { id: (t) => t.id, onSelect: (id) => select(id), sortBy: "callsign" });
const flights = new Table(byId("flights"), flightColumns(() => state.run?.start_utc_ns), {
  id: (f) => f.callsign, sortBy: "time",
  onSelect: (callsign) => {
    const target = targets().find((t) => t.callsign === callsign);
    if (target) select(target.id);
    flights.select(callsign);
  },
});

const link = new Link({
  text: onText,
  scan: onScan,
  state: (word) => {
    state.link = word;
    if (word === "open") state.lostAt = null;
    else state.lostAt ??= new Date();
    showLink();
  },
}, () => {
  const hello = [{ type: "show", scan: state.live ? null : state.scan?.scan ?? null }];
  if (selectedNumber() !== null) hello.push({ type: "select", track: selectedNumber() });
  return hello;
});

// ---- messages ----

function onText(message) {
  switch (message.type) {
    case "scene":
      state.run = message.run;
      state.airport = message.map;
      map.setAirport(message.map);
      byId("title").textContent = message.run.title || message.run.scene;
      document.title = `${message.run.title || message.run.scene} \u2013 SEEDS`;
      makeSensorLayers();
      showFlights();
      break;
    case "timeline":
      state.timeline = message;
      showTimeline();
      break;
    case "state":
      state.runState = message.state;
      showState();
      break;
    case "weather":
      state.notices = message.notices;
      showWeather();
      break;
    case "flights":
      state.flights = message.entries;
      showFlights();
      break;
    case "federates":
      state.federates = message.federates;
      showPanel("federates");
      break;
    case "operations":
      state.operations = message.operations;
      showPanel("log");
      break;
    case "plan":
      state.plan = message.rows;
      showPanel("effects");
      break;
    case "rungs":
      state.rungs = message;
      byId("compare").setAttribute("aria-pressed", String(message.comparing));
      byId("compare").textContent = message.comparing ? "Stop comparing" : "Compare with a cheaper and a more exact filter";
      showPanel("filter");
      break;
    case "effects":
      if (message.track !== selectedNumber()) break;
      state.effects = message;
      showPanel("effects");
      break;
    case "curve":
      if (message.track === selectedNumber()) curve.add(message);
      break;
    case "new_run":
      setLive(true);
      select(null);
      map.before = new Map();
      break;
    case "refused":
      showAnswer({ accepted: false, text: message.text });
      break;
    default: // reply is handled by the link; alive says no more than that; later versions may send others
  }
}

function onScan(buffer) {
  try {
    state.scan = decode(buffer);
    state.notice = null;
  } catch (error) {
    state.notice = `A picture could not be read: ${error.message}.`;
    showLink();
    return;
  }
  if (!state.live && state.playing && state.scan.newest) setLive(true);
  map.setScan(state.scan);
  if (state.selected && !map.find(state.selected)) keepSelection();
  tracks.show(targets());
  showClock();
  showTarget();
  showPanel("sensors");
  showTimeline();
  makeSensorLayers();
}

/** Tracks and the entities that no track follows: what the table lists. */
function targets() {
  if (!state.scan) return [];
  return [...state.scan.tracks, ...state.scan.truth.filter((t) => t.track === null)];
}

// ---- selection ----

function selectedNumber() {
  return state.selected?.startsWith("t") ? Number(state.selected.slice(1)) : null;
}

function select(id) {
  if (id === state.selected) return;
  state.selected = id;
  state.callsign = map.find(id)?.callsign ?? null;
  map.selected = id;
  if (id === null) map.follow = false;
  curve.clear();
  state.effects = null;
  showPanel("effects");
  link.send({ type: "select", track: selectedNumber() });
  tracks.select(id);
  if (state.callsign) flights.select(state.callsign);
  if (map.follow) map.setFollow(true);
  showFollow();
  showTarget();
  map.dirty();
}

/** The target selected is not in this picture: look for it under another number, else keep waiting for it. */
function keepSelection() {
  const again = state.callsign && targets().find((t) => t.callsign === state.callsign);
  if (again) select(again.id);
}

function selectNext(step) {
  const order = tracks.order();
  if (!order.length) return;
  const at = order.indexOf(state.selected);
  select(order[(at < 0 ? (step > 0 ? 0 : order.length - 1) : at + step + order.length) % order.length]);
}

// ---- time ----

function showScan(scan) {
  const { first, last } = state.timeline ?? {};
  if (first === undefined) return;
  const wanted = Math.min(last, Math.max(first, Math.round(scan)));
  state.live = false;
  link.send({ type: "show", scan: wanted });
  showTimeline(wanted);
}

function setLive(live) {
  state.live = live;
  setPlaying(false);
  if (live) link.send({ type: "show", scan: null });
  showTimeline();
}

let playTimer = 0;
function setPlaying(on) {
  state.playing = on;
  clearInterval(playTimer);
  if (on) {
    if (state.live) showScan(state.timeline?.first ?? 0);
    const rate = state.runState?.rate ?? 1;
    const every = Math.max(60, (1000 * (state.run?.scan_s || 1)) / Math.min(10, Math.max(0.2, rate || 1)));
    playTimer = setInterval(() => {
      if (!state.scan || state.scan.newest) setLive(true);
      else showScan(state.scan.scan + 1);
    }, every);
  }
  byId("timeline").querySelector("[data-time=play]").setAttribute("aria-pressed", String(on));
}

function showTimeline(wanted) {
  const line = state.timeline, scrub = byId("scrub");
  if (line) {
    scrub.min = line.first;
    scrub.max = line.last;
    scrub.value = wanted ?? (state.live ? line.last : state.scan?.scan ?? line.last);
    scrub.setAttribute("aria-valuetext", elapsed(state.scan?.timeS));
  }
  byId("timeline").querySelector("[data-time=live]").setAttribute("aria-pressed", String(state.live));
  document.body.classList.toggle("past", !state.live);
  const past = byId("past");
  past.hidden = state.live;
  if (!state.live && state.scan) {
    const behind = (line?.last_s ?? state.scan.timeS) - state.scan.timeS;
    past.textContent = `PAST  ${elapsed(state.scan.timeS)}  (${elapsed(behind).slice(3)} before now)`;
  }
  showClock();
  showWeather();
}

// ---- what the parts show ----

function showClock() {
  const seconds = state.live ? state.runState ? frameTime() ?? state.scan?.timeS : state.scan?.timeS : state.scan?.timeS;
  byId("utc").textContent = Number.isFinite(seconds) && state.run ? utc(state.run.start_utc_ns, seconds) : "--:--:--";
  byId("elapsed").textContent = elapsed(seconds);
  curve.mark(state.live ? null : state.scan?.timeS);
}

function frameTime() {
  const { frame, step_ns: step } = state.runState ?? {};
  return Number.isFinite(frame * step) ? (frame * step) / 1e9 : null;
}

function showState() {
  const s = state.runState, pill = byId("phase");
  pill.textContent = s.phase;
  pill.dataset.phase = s.phase;
  const asked = s.rate === null ? "fast" : `${s.rate}\u00d7`;
  const achieved = `${fixed(s.achieved_rate, s.achieved_rate < 10 ? 1 : 0)}\u00d7`;
  byId("rate").textContent = s.phase !== "RUNNING" ? asked : s.rate === null ? `fast: ${achieved}` : `${achieved} of ${asked}`;
  const can = {
    start: ["CONFIGURED", "FROZEN"], freeze: ["RUNNING"], step: ["CONFIGURED", "FROZEN"],
    stop: ["CONFIGURED", "RUNNING", "FROZEN"], restart: ["FROZEN", "STOPPED"],
  };
  for (const button of byId("controls").querySelectorAll("button")) {
    // A button that will be refused is dimmed, not dead: the reason why not is an answer, too.
    button.classList.toggle("unlikely", !can[button.dataset.command]?.includes(s.phase));
  }
  byId("controls").querySelector("[data-command=start]").textContent = s.phase === "FROZEN" ? "Resume" : "Start";
  const choice = s.rate === null ? "fast" : String(s.rate);
  const select = byId("rate-ask");
  if (document.activeElement !== select) {
    if (![...select.options].some((o) => o.value === choice)) select.append(element("option", choice, { value: choice }));
    select.value = choice;
  }
  showClock();
  showLink();
  showPanel("federates");
}

function showLink() {
  const pill = byId("link"), alert = byId("alert");
  const words = { open: "live", connecting: "connecting", silent: "silent", lost: "disconnected" };
  pill.textContent = state.link === "open" && !state.live ? "connected" : words[state.link];
  pill.dataset.link = state.link;
  document.body.classList.toggle("stale", state.link === "lost" || state.link === "silent");
  const at = state.lostAt?.toTimeString().slice(0, 8) ?? "";
  const reasons = state.runState?.reasons ?? [];
  let text = "", level = "bad";
  if (state.link === "lost") {
    text = state.scan ? `Connection to the viewer lost at ${at}. The picture is of ${elapsed(state.scan.timeS)} and is not renewed. Trying again \u2026`
      : "No connection to the viewer. Trying again \u2026";
  } else if (state.link === "silent") text = `Nothing heard from the viewer since ${at}; the picture may be old.`;
  else if (state.notice) text = state.notice;
  else if (reasons.length) [text, level] = [`${state.runState.phase}: ${reasons.join("; ")}`, "warn"];
  else if (lateScans()) [text, level] = [`No tracks since ${elapsed(state.scan?.timeS ?? 0)}: the SMDFM is behind or its messages are lost.`, "warn"];
  alert.hidden = !text;
  if (alert.textContent !== text) alert.textContent = text;
  alert.dataset.level = level;
}

/** Whether the run goes on while scans stay away. */
function lateScans() {
  const now = frameTime();
  if (state.runState?.phase !== "RUNNING" || now === null || !state.timeline) return false;
  const slack = Math.max(4 * (state.run?.scan_s || 1), 3 * (state.runState.achieved_rate || 1));
  return now - state.timeline.last_s > slack;
}

/** The weather at the time of the picture. */
function showWeather() {
  const now = state.live ? Infinity : (state.scan?.timeS ?? 0) * 1e9;
  const w = (state.notices ?? []).findLast((n) => n.from_ns <= now) ?? null;
  if (w === state.weather) return;
  state.weather = map.weather = w;
  map.dirty();
  if (!w) {
    byId("weather").replaceChildren();
    return;
  }
  const rain = w.rain_mm_per_h > 0 ? `rain ${fixed(w.rain_mm_per_h, w.rain_mm_per_h < 10 ? 1 : 0)} mm/h` : "dry";
  const parts = [
    [w.rain_mm_per_h > 0 || w.cells.length ? "wet" : "", w.cells.length ? `${rain}, ${w.cells.length} cell${w.cells.length > 1 ? "s" : ""}` : rain],
    ["", `vis ${visibility(w.visibility_m)}`], ["", wind(w.wind_mps)], ["", `${fixed(w.temperature_k - 273.15, 0)} \u00b0C`],
    ...(w.film_mm > 0 ? [["", `film ${fixed(w.film_mm, 1)} mm`]] : []),
  ];
  byId("weather").replaceChildren(...parts.map(([mark, text]) => element("span", text, { "data-mark": mark })));
  byId("weather").title = `Since ${elapsed(w.from_ns / 1e9)}; ${fixed(w.pressure_hpa, 0)} hPa, vapour ${fixed(w.vapour_g_per_m3, 1)} g/m\u00b3`;
}

function showFlights() {
  flights.show(state.flights);
}

function showTarget() {
  const target = map.find(state.selected);
  const name = target ? target.callsign || (target.number === undefined ? "no name" : `Track ${target.number}`)
    : state.selected ? `${state.callsign || state.selected.replace(/^t/, "Track ")} \u2013 not in this picture` : "No target selected";
  byId("target-name").textContent = name;
  byId("target").dataset.empty = String(!state.selected);
  byId("target-name").dataset.mark = target?.movement ?? "";
  facts(byId("target-facts"), targetFacts(target));
  closeUp(byId("close-up"), map, target);
}

function showPanel(name) {
  if (byId(`panel-${name}`).hidden) return;
  if (name === "effects") {
    showEffects(byId("effects"), { of: state.selected && (state.callsign || state.selected.replace(/^t/, "Track ")), message: state.effects, sensors: state.airport?.sensors ?? [], plan: state.plan });
  }
  if (name === "filter") {
    showRungs(byId("filter"), { rungs: state.rungs, measures: state.timeline?.measures, tookUs: state.timeline?.took_us });
  }
  if (name === "federates") showFederates(byId("federates"), state.federates, state.runState?.members ?? []);
  if (name === "sensors") {
    showSensors(byId("sensors"), {
      scan: state.scan, sensors: state.airport?.sensors ?? [], measures: state.timeline?.measures, tookUs: state.timeline?.took_us,
    });
  }
  if (name === "log") showOperations(byId("operations"), state.operations);
}

function showFollow() {
  byId("zoom").querySelector("[data-view=follow]").setAttribute("aria-pressed", String(map.follow));
}

let answerTimer = 0;
function showAnswer({ accepted, text }) {
  state.answer = { accepted, text };
  const box = byId("answer");
  box.textContent = text;
  box.dataset.mark = accepted ? "good" : "bad";
  clearTimeout(answerTimer);
  answerTimer = setTimeout(() => (box.textContent = ""), 12000);
}

// ---- layers, tabs, controls ----

function makeLayers() {
  const list = byId("layer-list");
  LAYERS.forEach(([key, title], i) => {
    const box = element("input", [], { type: "checkbox", id: `layer-${key}` });
    box.checked = map.layers[key];
    box.addEventListener("change", () => setLayer(key, box.checked));
    const hint = i < 9 ? `${title} (${i + 1})` : title;
    list.append(element("label", [box, title], { for: box.id, title: hint }));
  });
  list.append(element("div", [], { id: "sensor-layers" }));
  const narrow = matchMedia("(max-width: 900px)");
  const fold = () => (byId("layers").open = !narrow.matches);
  narrow.addEventListener("change", fold);
  fold();
  byId("layers").addEventListener("toggle", () => map.dirty());
}

function setLayer(key, on) {
  map.layers[key] = on;
  byId(`layer-${key}`).checked = on;
  map.stale = true;
  map.dirty();
}

/** One switch for the plots of each sensor, as sensors become known. */
function makeSensorLayers() {
  const box = byId("sensor-layers");
  const known = new Map((state.airport?.sensors ?? []).map((s) => [s.id, s]));
  for (const plot of state.scan?.plots ?? []) if (!known.has(plot.sensor)) known.set(plot.sensor, { id: plot.sensor, kind: plot.kind });
  for (const [id, sensor] of [...known].sort((a, b) => a[0] - b[0])) {
    if (byId(`sensor-${id}`)) continue;
    const input = element("input", [], { type: "checkbox", id: `sensor-${id}` });
    input.checked = !map.sensorsOff.has(id);
    input.addEventListener("change", () => {
      if (input.checked) map.sensorsOff.delete(id);
      else map.sensorsOff.add(id);
      map.dirty();
    });
    const mark = element("canvas", [], { class: "mark", width: 24, height: 24, "data-kind": sensor.kind });
    drawMark(mark);
    box.append(element("label", [input, mark, sensor.name || `${sensor.kind} ${id}`], { for: input.id, title: `Plots of ${sensor.name || "sensor"} (${sensor.kind})` }));
  }
}

function drawMark(canvas) {
  const g = canvas.getContext("2d");
  g.setTransform(1, 0, 0, 1, 0, 0);
  g.clearRect(0, 0, 24, 24);
  g.strokeStyle = map.c[`plot-${canvas.dataset.kind}`] ?? map.c["plot-other"];
  g.lineWidth = 2.4;
  g.beginPath();
  plotMark(g, canvas.dataset.kind, 12, 12, 7);
  g.stroke();
}

const TABS = [["tracks", "Targets"], ["effects", "Effects"], ["filter", "Filter"], ["flights", "Flights"], ["federates", "Federates"], ["sensors", "Sensors"], ["log", "Log"]];

function makeTabs() {
  for (const [key, title] of TABS) {
    const tab = element("button", title, { type: "button", role: "tab", id: `tab-${key}`, "aria-controls": `panel-${key}`, "data-tab": key });
    tab.addEventListener("click", () => showTab(key));
    byId("tabs").append(tab);
  }
  showTab("tracks");
  byId("compare").addEventListener("click", () => link.send({ type: "compare", on: !state.rungs?.comparing }));
}

function showTab(key) {
  for (const [other] of TABS) {
    byId(`panel-${other}`).hidden = other !== key;
    byId(`tab-${other}`).setAttribute("aria-selected", String(other === key));
  }
  showPanel(key);
}

async function command(word, shift = false) {
  const message = { command: word };
  if (word === "step") {
    const { frame = 0, step_ns: step = 50_000_000 } = state.runState ?? {};
    const scan = Math.max(1, Math.round(((state.run?.scan_s || 1) * 1e9) / step));
    message.frames = shift ? 1 : scan - (frame % scan);
  }
  if (word === "rate") {
    const choice = byId("rate-ask").value;
    if (choice === "fast") message.command = "fast";
    else message.rate = Number(choice);
  }
  byId("answer").textContent = `${word} \u2026`;
  byId("answer").dataset.mark = "";
  showAnswer(await link.command(message));
}

function toggleRun() {
  command(state.runState?.phase === "RUNNING" ? "freeze" : "start");
}

function setColours(colours) {
  document.documentElement.dataset.colours = colours;
  byId("colours").textContent = colours === "night" ? "Day" : "Night";
  map.colours();
  curve.colours();
  for (const mark of document.querySelectorAll("canvas.mark")) drawMark(mark);
  showTarget();
  try {
    localStorage.setItem("colours", colours);
  } catch { /* private window: not kept */ }
}

const views = {
  in: () => map.zoom(1.5), out: () => map.zoom(1 / 1.5),
  fit: () => {
    map.touched = false;
    map.follow = false;
    map.fit();
    showFollow();
  },
  targets: () => map.fitTargets(),
  follow: () => map.setFollow(!map.follow),
};
const times = {
  back: () => showScan((state.scan?.scan ?? 1) - 1), forth: () => showScan((state.scan?.scan ?? 0) + 1),
  play: () => setPlaying(!state.playing), live: () => setLive(true),
};

// ---- keyboard ----

const KEYS = [
  ["Space", "freeze or resume", [" "], toggleRun],
  [".", "execute one scan (Shift: one frame)", [".", ":"], (e) => command("step", e.shiftKey)],
  ["[  ]", "one scan back, forward", ["["], times.back], ["", "", ["]"], times.forth],
  ["P", "play from the scan shown", ["p"], times.play], ["L", "back to the newest scan", ["l"], times.live],
  ["J  K", "next, previous target", ["j"], () => selectNext(1)], ["", "", ["k"], () => selectNext(-1)],
  ["Esc", "select nothing", ["Escape"], () => select(null)],
  ["C", "follow the selected target", ["c"], views.follow],
  ["arrows", "move the map", ["ArrowLeft"], () => map.pan(60, 0)], ["", "", ["ArrowRight"], () => map.pan(-60, 0)],
  ["", "", ["ArrowUp"], () => map.pan(0, 60)], ["", "", ["ArrowDown"], () => map.pan(0, -60)],
  ["+  \u2212", "zoom", ["+", "="], views.in], ["", "", ["-"], views.out],
  ["F", "fit the airport", ["f"], views.fit], ["T", "fit the targets", ["t"], views.targets],
  ["1 \u2013 9", "layers on or off, in their order", [], null],
  ["N", "day or night colours", ["n"], () => setColours(document.documentElement.dataset.colours === "night" ? "day" : "night")],
  ["?", "this help", ["?"], () => byId("help").showModal()],
];

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || byId("help").open) return;
  const field = event.target.closest?.("input, select, button, tr[tabindex]");
  if (field && (event.target.matches("input[type=range], select") || [" ", "Enter"].includes(event.key))) return;
  const layer = LAYERS[Number(event.key) - 1];
  if (/^[1-9]$/.test(event.key) && layer) setLayer(layer[0], !map.layers[layer[0]]);
  else {
    const key = KEYS.find((k) => k[2].includes(event.key) || k[2].includes(event.key.toLowerCase()));
    if (!key) return;
    key[3](event);
  }
  event.preventDefault();
});

function makeHelp() {
  byId("keys").append(...KEYS.filter((k) => k[0]).map((k) => element("tr", [element("th", k[0], { scope: "row" }), element("td", k[1])])));
  byId("symbols").append(...[
    "Filled circle: track of an aircraft; square: of a vehicle; diamond: not identified; hollow: coasting.",
    "Outline and small cross: truth, to scale once it is large enough; dashed: an outsider's entity.",
    "Small open marks: plots, one mark and colour a sensor as in the list of layers; a plot far from any target is a false one.",
    "Red line: error, from track to truth. Ellipse: where the track claims to be with 95 % probability.",
    "Line ahead: where the target will be in 15 s. Dots: where the track was.",
    "Amber arrival, blue departure, green vehicle, grey unknown.",
  ].map((text) => element("li", text)));
}

// ---- start ----

makeLayers();
makeTabs();
makeHelp();
for (const button of byId("zoom").querySelectorAll("button")) button.addEventListener("click", views[button.dataset.view]);
for (const button of byId("timeline").querySelectorAll("button")) {
  button.addEventListener("click", () => {
    if (button.dataset.time !== "play") setPlaying(false);
    times[button.dataset.time]();
  });
}
for (const button of byId("controls").querySelectorAll("button")) {
  button.addEventListener("click", (event) => command(button.dataset.command, event.shiftKey));
}
byId("rate-ask").addEventListener("change", () => command("rate"));
byId("scrub").addEventListener("input", (event) => {
  setPlaying(false);
  showScan(Number(event.target.value));
});
byId("colours").addEventListener("click", () => setColours(document.documentElement.dataset.colours === "night" ? "day" : "night"));
byId("help-button").addEventListener("click", () => byId("help").showModal());
new ResizeObserver(() => showTarget()).observe(byId("close-up"));
setInterval(showLink, 1000);
let colours = "night";
try {
  colours = localStorage.getItem("colours") === "day" ? "day" : "night";
} catch { /* private window */ }
setColours(colours);
document.fonts.ready.then(() => map.dirty());
Promise.all(["700 12px B612", "11px B612", "11px 'B612 Mono'"].map((f) => document.fonts.load(f))).then(() => {
  map.stale = true;
  map.dirty();
});

// ---- the one hook for tests and tools: getters only, values are copies ----

const copy = (value) => Object.freeze(JSON.parse(JSON.stringify(value ?? null)));
const drawn = (item) => {
  const [x, y] = map.toScreen(item.x, item.y);
  return { ...item, truth: undefined, screen: { x, y } };
};
const hook = Object.defineProperties({}, Object.fromEntries(Object.entries({
  version: () => 1,
  connection: () => state.link,
  phase: () => state.runState?.phase ?? null,
  runState: () => copy(state.runState),
  scene: () => copy(state.run),
  scan: () => state.scan?.scan ?? null,
  timeS: () => state.scan?.timeS ?? null,
  live: () => state.live,
  timeline: () => copy(state.timeline),
  tracks: () => copy((state.scan?.tracks ?? []).map(drawn)),
  truth: () => copy((state.scan?.truth ?? []).map(drawn)),
  plots: () => copy((state.scan?.plots ?? []).map((p) => ({ ...drawn(p), shown: !map.sensorsOff.has(p.sensor) }))),
  labels: () => copy([...map.labels].map(([id, { x, y, w, h, form, ax, ay }]) => ({ id, x, y, w, h, form, ax, ay }))),
  selected: () => state.selected,
  layers: () => copy({ ...map.layers, sensorsOff: [...map.sensorsOff] }),
  view: () => copy({ ...map.view, width: map.width, height: map.height, follow: map.follow }),
  colours: () => document.documentElement.dataset.colours,
  curve: () => copy(curve.points),
  weather: () => copy(state.weather),
  flights: () => copy(state.flights),
  federates: () => copy(state.federates),
  operations: () => copy(state.operations),
  answer: () => copy(state.answer),
  frames: () => map.drawn ?? 0,
}).map(([name, get]) => [name, { get, enumerable: true }])));
Object.defineProperty(window, "__viewer", { value: Object.freeze(hook) });
