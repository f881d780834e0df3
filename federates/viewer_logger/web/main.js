// Wires the page together: messages of the server in, map, lists and controls out.

import { Address } from "./address.js";
import { closeUp } from "./closeup.js";
import { Curve } from "./curve.js";
import { csv, curveRows, json, picture, save, shownRows, targetRows } from "./export.js";
import { backgroundOf, extinction, rvr, sunElevation } from "./eye_light.js";
import { decode } from "./frame.js";
import { Link } from "./link.js";
import { LAYERS, MapView } from "./map.js";
import { nextEvent, TimeLine, typedTime } from "./time.js";
import { found, latLon, Tools, tutorial } from "./tools.js";
import { plotMark } from "./traffic.js";
import {
  facts, flightColumns, showEffects, showFederates, showOperations, showRungs, showSensors, Table, targetFacts, TRACK_COLUMNS,
} from "./panels.js";
import { element, elapsed, fixed, place, utc, visibility, wind } from "./text.js";

const byId = (id) => document.getElementById(id);

const state = {
  run: null, airport: null, notices: [], runState: null, timeline: null, weather: null, flights: [], federates: [], operations: [],
  plan: [], scan: null, live: true, selected: null, link: "connecting", notice: null, playing: false, answer: null,
  runs: [], shownRuns: [], loop: null, wish: {}, tab: "tracks",
};

// ---- parts ----

const map = new MapView(byId("map"), () => {
  showFollow();
  addressChanged();
});
map.tools = new Tools(map);
map.onPick = (id, at) => {
  if (!map.tools.click(id, at)) select(id);
  else addressChanged();
};
map.onDragged = (dragged) => keepLocal(`labels ${state.run?.scene}`, [...dragged].slice(-200));
map.onPointer = (p) => {
  byId("pointer").textContent = p ? `${place(...p)}\n${latLon(...p, state.airport?.reference_deg ?? [0, 0]).map((v) => v.toFixed(6)).join(" ")}` : "";
};

const curve = new Curve(byId("curve"), (scan) => showScan(scan));

const line = new TimeLine(byId("strip"), byId("scrub"), byId("event-kinds"));

const tracks = new Table(byId("tracks"), TRACK_COLUMNS, { id: (t) => t.id, onSelect: (id) => select(id), sortBy: "callsign" });
const flights = new Table(byId("flights"), flightColumns(() => state.run?.start_utc_ns), {
  id: (f) => f.callsign, sortBy: "time",
  onSelect: (callsign) => {
    const target = targets().find((t) => t.callsign === callsign);
    if (target) select(target.id);
    flights.select(callsign);
  },
});

/** The address follows the view, once both are there. */
let started = false;
function addressChanged(push = false) {
  if (started) address.changed(push);
}

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
  if (state.wish.run) hello.unshift({ type: "open", runs: state.wish.run });
  return hello;
});

// ---- messages ----

function onText(message) {
  switch (message.type) {
    case "scene":
      state.run = message.run;
      state.airport = message.map;
      map.dragged = new Map(readLocal(`labels ${message.run.scene}`) ?? []);
      map.setAirport(message.map);
      byId("title").textContent = message.run.title || message.run.scene;
      document.title = `${message.run.title || message.run.scene} \u2013 SEEDS`;
      makeSensorLayers();
      showFlights();
      break;
    case "timeline":
      state.timeline = message;
      grantTime();
      showTimeline();
      askStrip();
      break;
    case "runs":
      state.runs = message.runs;
      state.shownRuns = message.shown;
      map.others.clear();
      showRuns();
      break;
    case "no_picture":
      map.setOther(message.run, null);
      showAnswer({ accepted: false, text: `${message.id}: ${message.text}` });
      break;
    case "strip":
      line.show({ strip: message });
      break;
    case "events":
      line.show({ events: message.events });
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
    const scan = decode(buffer);
    if (scan.run) {
      map.setOther(scan.run, scan);
      return;
    }
    state.scan = scan;
    state.notice = null;
  } catch (error) {
    state.notice = `A picture could not be read: ${error.message}.`;
    showLink();
    return;
  }
  if (!state.live && state.playing && state.scan.newest) setLive(true);
  map.setScan(state.scan);
  grantSelection();
  if (state.selected && !map.find(state.selected)) keepSelection();
  showTimeline();
  // The lists wait until the map is drawn: nobody's frame is held up by a table.
  clearTimeout(onScan.later);
  onScan.later = setTimeout(() => {
    tracks.show(targets());
    showTarget();
    setTimeout(() => {
      showPanel("sensors");
      makeSensorLayers();
    }, 0);
  }, 0);
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
  map.need("place");
  addressChanged(true);
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

/** A time in seconds instead of a scan; beyond the ends of what there is, the nearest end, and said. */
function showTime(seconds) {
  const { first, last, first_s: from, last_s: to } = state.timeline ?? {};
  if (first === undefined) return;
  if (seconds < from - 0.5 || seconds > to + 0.5) showAnswer({ accepted: false, text: `${elapsed(seconds)} is outside ${elapsed(from)} to ${elapsed(to)}` });
  showScan(to > from ? Math.floor(first + ((Math.min(to, Math.max(from, seconds)) - from) / (to - from)) * (last - first) + 1e-6) : first);
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
      const { loop, scan } = state;
      if (loop && scan && (scan.timeS >= loop[1] || scan.timeS < loop[0])) showTime(loop[0]);
      else if (!scan || scan.newest) finished() ? setPlaying(false) : setLive(true);
      else showScan(scan.scan + 1);
    }, every);
  }
  byId("timeline").querySelector("[data-time=play]").setAttribute("aria-pressed", String(on));
}

function showTimeline(wanted) {
  map.live = state.live && !finished();
  const strip = line;
  showTimes(state.timeline, byId("scrub"), strip, wanted);
}

function showTimes(line, scrub, strip, wanted) {
  if (line) {
    scrub.min = line.first;
    scrub.max = line.last;
    scrub.value = wanted ?? (state.live ? line.last : state.scan?.scan ?? line.last);
    const shown = wanted ?? (state.live ? line.last : state.scan?.scan ?? line.last);
    const timeS = line.last > line.first ? line.first_s + ((shown - line.first) / (line.last - line.first)) * (line.last_s - line.first_s) : line.first_s;
    strip.show({ firstS: line.first_s, lastS: line.last_s, timeS, loop: state.loop, notices: state.notices ?? [] });
    scrub.setAttribute("aria-valuetext", strip.textAt(state.scan?.timeS ?? timeS).replaceAll("\n", ", "));
  }
  addressChanged();
  byId("timeline").querySelector("[data-time=live]").setAttribute("aria-pressed", String(state.live));
  byId("timeline").querySelector("[data-time=live]").textContent = finished() ? "End" : "Live";
  document.body.classList.toggle("past", !state.live && !finished());
  document.body.classList.toggle("finished", finished());
  const past = byId("past");
  past.hidden = state.live || finished();
  if (!past.hidden && state.scan) {
    const behind = (line?.last_s ?? state.scan.timeS) - state.scan.timeS;
    past.textContent = `PAST  ${elapsed(state.scan.timeS)}  (${elapsed(behind).slice(3)} before now)`;
  }
  showClock();
  showWeather();
}

// ---- what the parts show ----

function showClock() {
  const seconds = state.live && !finished() ? state.runState ? frameTime() ?? state.scan?.timeS : state.scan?.timeS : state.scan?.timeS;
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
  pill.textContent = state.link === "open" && (!state.live || finished()) ? "connected" : words[state.link];
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
  map.need("traffic");
  if (!w) {
    byId("weather").replaceChildren();
    return;
  }
  const rain = w.rain_mm_per_h > 0 ? `rain ${fixed(w.rain_mm_per_h, w.rain_mm_per_h < 10 ? 1 : 0)} mm/h` : "dry";
  const parts = [
    [w.rain_mm_per_h > 0 || w.cells.length ? "wet" : "", w.cells.length ? `${rain}, ${w.cells.length} cell${w.cells.length > 1 ? "s" : ""}` : rain],
    ["", `vis ${visibility(w.visibility_m)}`], ["", wind(w.wind_mps)], ["", `${fixed(w.temperature_k - 273.15, 0)} \u00b0C`],
    ["", `QNH ${fixed(w.pressure_hpa, 0)}`],
    ...(runwayRange(w) < 2000 ? [["", `RVR ${runwayRange(w)} m`]] : []),
    ...(w.film_mm > 0 ? [["", `film ${fixed(w.film_mm, 1)} mm`]] : []),
  ];
  byId("weather").replaceChildren(...parts.map(([mark, text]) => element("span", text, { "data-mark": mark })));
  byId("weather").title = `Since ${elapsed(w.from_ns / 1e9)}; ${fixed(w.pressure_hpa, 0)} hPa, vapour ${fixed(w.vapour_g_per_m3, 1)} g/m\u00b3`;
}

/** Runway visual range, m: of the edge lights and of contrast, by the light of the hour, as it would be reported. */
function runwayRange(w) {
  const { run, airport, scan } = state, [lat, lon] = airport?.reference_deg ?? [0, 0];
  const utcMs = Number(BigInt(run?.start_utc_ns || "0") / 1_000_000n) + (scan?.timeS ?? 0) * 1000;
  return rvr(extinction(w.visibility_m, w.rain_mm_per_h), backgroundOf(sunElevation(utcMs, lat, lon)));
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
}

function setLayer(key, on) {
  map.layers[key] = on;
  byId(`layer-${key}`).checked = on;
  map.need("ground", "place");
  addressChanged();
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
      map.need("traffic");
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
  if (!TABS.some(([known]) => known === key)) return;
  state.tab = key;
  addressChanged();
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
  line.draw();
  for (const mark of document.querySelectorAll("canvas.mark")) drawMark(mark);
  showTarget();
  keepLocal("colours", colours);
  addressChanged();
}

/** Kept in this browser, where it may. */
function keepLocal(key, value) {
  try {
    localStorage.setItem(key, JSON.stringify(value));
  } catch { /* private window: not kept */ }
}

function readLocal(key) {
  try {
    return JSON.parse(localStorage.getItem(key));
  } catch {
    return null;
  }
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

/** Whether the run shown no longer goes on: nothing can be commanded, and its end is not "now". */
function finished() {
  return state.timeline?.live === false;
}

/** The time line's columns and events: once for what is finished, every two seconds for what grows. */
let stripAsked = -Infinity;
function askStrip(force = false) {
  const { first_s: from, last_s: to } = state.timeline ?? {}, now = performance.now();
  if (from === undefined || (!force && now - stripAsked < 2000)) return;
  if (link.send({ type: "strip", from_s: from, to_s: Math.max(to, from + 1), columns: Math.max(1, Math.min(2000, line.width - 16, state.timeline.last - state.timeline.first + 1)) })) stripAsked = now;
}

function toEvent(step) {
  const t = nextEvent(line.events, state.scan?.timeS ?? 0, step, line.wanted);
  if (t === null) showAnswer({ accepted: false, text: step > 0 ? "no later event of these kinds" : "no earlier event of these kinds" });
  else showTime(t);
}

/** Start or end of the loop at the time shown; the two change places where they must. */
function setLoop(end) {
  const now = state.scan?.timeS ?? 0, loop = state.loop ?? [now, now];
  loop[end] = now;
  state.loop = loop.sort((a, b) => a - b);
  showTimeline();
}

function askTime() {
  byId("go").showModal();
  byId("go-time").select();
}

function goTo(text) {
  const of = utc(state.run?.start_utc_ns, 0).split(":").map(Number), startS = of[0] * 3600 + of[1] * 60 + of[2];
  const seconds = typedTime(text, startS);
  if (seconds === null) showAnswer({ accepted: false, text: `"${text.slice(0, 20)}" is not a time: 215, 3:35 or 09:03:35Z` });
  else {
    setPlaying(false);
    showTime(seconds);
  }
}

// ---- several runs, links, exports ----

function showRuns() {
  const box = byId("runs"), several = state.runs.length > 1;
  box.hidden = !several && state.runs.every((r) => r.live);
  const choice = (run, i) => {
    const input = element("input", [], { type: "checkbox", id: `run-${i}` });
    input.checked = state.shownRuns.includes(run.id);
    input.addEventListener("change", () => {
      const shown = state.runs.map((r) => r.id).filter((id) => (id === run.id ? input.checked : state.shownRuns.includes(id)));
      if (shown.length) openRuns(shown);
      else input.checked = true;
    });
    const words = [run.id, element("small", `${run.title || run.scene}, seed ${run.seed}${run.fork ? `, fork of ${run.fork}` : ""}`)];
    return element("label", [input, ...words], { for: input.id });
  };
  byId("run-list").replaceChildren(...state.runs.map(choice));
  byId("run-names").textContent = state.shownRuns.join(" + ");
}

function openRuns(ids) {
  state.wish.run = ids;
  stripAsked = -Infinity;
  link.send({ type: "open", runs: ids });
  addressChanged(true);
}

function copyLink() {
  const link = `${location.origin}${location.pathname}${address.text()}`;
  navigator.clipboard?.writeText(link).then(() => showAnswer({ accepted: true, text: "link copied" }), () => showAnswer({ accepted: false, text: link }));
}

/** Rings what is found; one alone is shown in the middle, and selected. */
function search(text) {
  const hits = found(text, state.scan, state.airport, map.layers);
  map.tools.hits = hits;
  state.find = text.trim() && hits.length ? text.trim() : null;
  if (hits.length === 1) {
    map.touched = true;
    map.look({ cx: hits[0].x, cy: hits[0].y });
    if (hits[0].id) select(hits[0].id);
  }
  showAnswer({ accepted: hits.length > 0, text: hits.length ? `${hits.length} found: ${hits.slice(0, 6).map((h) => h.name).join(", ")}` : `nothing is called "${text.slice(0, 20)}"` });
  map.dirty();
  addressChanged();
}

const nameOfRun = () => `${state.shownRuns[0] ?? "run"} ${elapsed(state.scan?.timeS).slice(3).replaceAll(":", "-")}`;
const EXPORTS = {
  link: copyLink,
  png: async () => save(`${nameOfRun()}.png`, await picture(map.canvas, `${byId("title").textContent}   ${byId("utc").textContent}Z   ${elapsed(state.scan?.timeS)}   tracks: filled, truth: outline, error: red line`)),
  png2: async () => save(`${nameOfRun()}@2.png`, await picture(map.canvas, `${byId("title").textContent}   ${byId("utc").textContent}Z`, 2)),
  targets: () => save(`${nameOfRun()} targets.csv`, csv(...targetRows(state.scan)), "text/csv"),
  targetsJson: () => save(`${nameOfRun()} targets.json`, json(...targetRows(state.scan)), "application/json"),
  curve: () => save(`${nameOfRun()} curve.csv`, csv(...curveRows(curve.points)), "text/csv"),
  curveJson: () => save(`${nameOfRun()} curve.json`, json(...curveRows(curve.points)), "application/json"),
  table: () => {
    const table = byId(`panel-${state.tab}`).querySelector("table");
    if (table) save(`${nameOfRun()} ${state.tab}.csv`, csv(...shownRows(table)), "text/csv");
    else showAnswer({ accepted: false, text: "this list has no table" });
  },
};

/** Ctrl+1 … 9 goes to a bookmark of this scene, with Shift it is set. */
function bookmark(number, store) {
  const key = `bookmarks ${state.run?.scene}`, all = readLocal(key) ?? {};
  if (store) {
    all[number] = address.text();
    keepLocal(key, all);
    showAnswer({ accepted: true, text: `bookmark ${number} set` });
  } else if (all[number]) location.hash = all[number];
  else showAnswer({ accepted: false, text: `bookmark ${number} is not set (Ctrl+Shift+${number} sets it)` });
}

/** A time out of the address is shown as soon as there is one. */
function grantTime() {
  const { wish } = state;
  if (wish.t === undefined || !state.timeline) return;
  if (wish.t === "live") setLive(true);
  else showTime(wish.t);
  if (wish.play) setPlaying(true);
  delete wish.t;
}

function grantSelection() {
  const { sel, follow } = state.wish;
  if (sel === undefined) return;
  const found = targets().find((t) => t.callsign === sel || `#${t.number}` === sel || entityName(t) === sel);
  if (!found) return;
  delete state.wish.sel;
  select(found.id);
  if (follow) map.setFollow(true);
}

/** `e1.2.3` of an entity: its DIS identifier. */
function entityName(t) {
  if (t.number !== undefined || !t.id.startsWith("e")) return null;
  const key = BigInt(t.id.slice(1));
  return `e${key >> 32n}.${(key >> 16n) & 0xffffn}.${key & 0xffffn}`;
}

const address = new Address({
  map,
  say: (text) => showAnswer({ accepted: false, text }),
  colours: (colours) => setColours(colours),
  layer: (key, on) => setLayer(key, on),
  skin: (skin) => setSkin(skin),
  apply(wanted) {
    for (const key of ["t", "sel", "follow", "play", "run"]) if (wanted[key] !== undefined) state.wish[key] = wanted[key];
    if (wanted.ab) state.loop = wanted.ab;
    if (wanted.rb) map.tools.setPairs(wanted.rb);
    if (wanted.find) setTimeout(() => search(wanted.find), 500);
    if (wanted.tab) showTab(wanted.tab);
    if (wanted.run && state.runs.length) openRuns(wanted.run);
    if (wanted.fit === "targets") setTimeout(() => map.fitTargets(), 600);
    grantTime();
    grantSelection();
  },
  state() {
    const shown = {}, target = map.find(state.selected);
    if (state.shownRuns.length > 1 || (state.runs.length > 1 && state.shownRuns[0] !== state.runs[0]?.id)) shown.run = state.shownRuns;
    if (!state.live && state.scan) shown.t = Number(state.scan.timeS.toFixed(3));
    if (map.tools.lines.length) shown.rb = map.tools.pairs();
    if (state.find) shown.find = state.find;
    if (state.loop) shown.ab = state.loop.map((s) => Number(s.toFixed(3)));
    if (target) shown.sel = target.callsign || (target.number !== undefined ? `#${target.number}` : entityName(target));
    if (state.playing) shown.play = true;
    if (state.tab !== "tracks") shown.tab = state.tab;
    if (map.skin === "controller") shown.skin = "controller";
    if (document.documentElement.dataset.colours === "day") shown.col = "day";
    return shown;
  },
});

/** Research shows truth and errors; a controller's position shows what a controller has. */
function setSkin(skin) {
  map.skin = skin;
  document.documentElement.dataset.skin = skin;
  byId("skin").setAttribute("aria-pressed", String(skin === "controller"));
  for (const key of ["truth", "errors", "ellipses", "plots"]) setLayer(key, skin === "research");
  map.vectorS = skin === "controller" ? 30 : 15;
  map.need("place");
  addressChanged();
}

// ---- keyboard ----

const KEYS = [
  ["Space", "freeze or resume; play or pause a finished run", [" "], () => (finished() ? setPlaying(!state.playing) : toggleRun())],
  ["X", "execute one scan (Shift: one frame)", ["x"], (e) => command("step", e.shiftKey)],
  [",  .", "one scan back, forward (Shift: a minute)", [",", "<", ";"], (e) => (e.shiftKey ? showTime((state.scan?.timeS ?? 0) - 60) : times.back())],
  ["", "", [".", ">", ":"], (e) => (e.shiftKey ? showTime((state.scan?.timeS ?? 0) + 60) : times.forth())],
  ["[  ]", "previous, next event", ["["], () => toEvent(-1)], ["", "", ["]"], () => toEvent(1)],
  ["Home End", "to the start, to the newest scan", ["Home"], () => showScan(state.timeline?.first ?? 0)], ["", "", ["End"], times.live],
  ["J", "go to a time", ["j"], askTime], ["A  B", "start and end of a loop", ["a"], () => setLoop(0)], ["", "", ["b"], () => setLoop(1)],
  ["O", "no loop", ["o"], () => {
    state.loop = null;
    showTimeline();
  }],
  ["P", "play from the scan shown", ["p"], times.play], ["L", "back to the newest scan", ["l"], times.live],
  ["D  U", "next, previous target", ["d"], () => selectNext(1)], ["", "", ["u"], () => selectNext(-1)],
  ["Esc", "select nothing", ["Escape"], () => {
    select(null);
    if (map.tools.measuring || map.tools.hits.length) map.tools.clear();
    byId("pointer").dataset.say = "";
  }],
  ["M", "range and bearing between two clicks (Shift: none)", ["m"], (e) => {
    if (e.shiftKey) map.tools.clear();
    else map.tools.measuring = true;
    addressChanged();
  }],
  ["/", "search: call sign, type, number, stand, taxiway", ["/"], () => {
    byId("find").showModal();
    byId("find-text").select();
  }],
  ["C", "follow the selected target", ["c"], views.follow],
  ["arrows", "move the map", ["ArrowLeft"], () => map.pan(60, 0)], ["", "", ["ArrowRight"], () => map.pan(-60, 0)],
  ["", "", ["ArrowUp"], () => map.pan(0, 60)], ["", "", ["ArrowDown"], () => map.pan(0, -60)],
  ["+  \u2212", "zoom", ["+", "="], views.in], ["", "", ["-"], views.out],
  ["F", "fit the airport", ["f"], views.fit], ["T", "fit the targets", ["t"], views.targets],
  ["1 \u2013 9", "layers on or off, in their order", [], null],
  ["R", "hold and turn the wheel: rotate the map (Shift: runway up)", ["r"], (e) => (e.shiftKey ? map.runwayUp() : (map.turning = true))],
  ["0", "north up", ["0"], () => map.northUp()],
  ["Ctrl 1 \u2013 9", "bookmark of this scene (with Shift: set it)", [], null],
  ["N", "day or night colours", ["n"], () => setColours(document.documentElement.dataset.colours === "night" ? "day" : "night")],
  ["?", "this help", ["?"], () => byId("help").showModal()],
];

document.addEventListener("keyup", (event) => {
  if (event.key.toLowerCase() === "r") map.turning = false;
});

document.addEventListener("keydown", (event) => {
  const digit = /^Digit([1-9])$/.exec(event.code);
  if (event.ctrlKey && !event.altKey && digit) {
    bookmark(digit[1], event.shiftKey);
    event.preventDefault();
    return;
  }
  if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector("dialog[open]")) return;
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
byId("find-form").addEventListener("submit", () => search(byId("find-text").value));
byId("tutorial").addEventListener("click", () => {
  byId("help").close();
  tutorial(() => keepLocal("tutorial", "seen"));
});
byId("go-form").addEventListener("submit", () => goTo(byId("go-time").value));
byId("skin").addEventListener("click", () => setSkin(map.skin === "controller" ? "research" : "controller"));
byId("export").addEventListener("change", (event) => {
  EXPORTS[event.target.value]?.();
  event.target.value = "";
});
byId("scrub").addEventListener("input", (event) => {
  setPlaying(false);
  showScan(Number(event.target.value));
});
byId("colours").addEventListener("click", () => setColours(document.documentElement.dataset.colours === "night" ? "day" : "night"));
byId("help-button").addEventListener("click", () => byId("help").showModal());
new ResizeObserver(() => showTarget()).observe(byId("close-up"));
setInterval(showLink, 1000);
setColours(readLocal("colours") === "day" ? "day" : "night");
started = true;
address.read();
Promise.all(["700 12px B612", "11px B612", "11px 'B612 Mono'"].map((f) => document.fonts.load(f))).then(() => {
  map.widths.clear();
  map.need("ground", "place");
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
  labels: () => copy([...map.labels].map(([id, { x, y, w, h, level, ax, ay, runway, sx, sy }]) => ({ id, x, y, w, h, level, ax, ay, sx, sy, runway }))),
  labelsHidden: () => map.hidden.length,
  state: () => address.text(),
  longestTaskMs: () => map.longestMs,
  runs: () => copy(state.runs),
  shownRuns: () => copy(state.shownRuns),
  others: () => copy([...map.others].map(([run, scan]) => ({ run, timeS: scan.timeS, tracks: scan.tracks.length }))),
  strip: () => copy(line.strip),
  events: () => copy(line.events),
  busy: () => map.todo.size > 0,
  selected: () => state.selected,
  layers: () => copy({ ...map.layers, sensorsOff: [...map.sensorsOff] }),
  view: () => copy({ cx: map.view.cx, cy: map.view.cy, scale: map.view.scale, rot: map.view.rot, width: map.width, height: map.height, follow: map.follow }),
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
