// Wires the page together: messages of the server in, map, lists and controls out.

import { Address } from "./address.js";
import { AlertPanel, alertWords, subjectOf } from "./alerts.js";
import { closeUp, watch } from "./closeup.js";
import { Curve } from "./curve.js";
import { backgroundOf, extinction, rvr, sunElevation } from "./eye_light.js";
import { decode } from "./frame.js";
import { expose } from "./hook.js";
import { Insets } from "./insets.js";
import { keyboard } from "./keys.js";
import { Link } from "./link.js";
import { keepLocal, readLocal } from "./local.js";
import { Panes } from "./panes.js";
import { MapView } from "./map.js";
import { clearanceFacts, StripPanel, stripsOf } from "./strips.js";
import { nextEvent, TimeLine, typedTime } from "./time.js";
import { found, latLon, Tools, tutorial } from "./tools.js";
import { switches } from "./switches.js";
import { takeaway } from "./takeaway.js";
import { facts, targetFacts } from "./lists.js";
import { panels } from "./panels.js";
import { WhatIf } from "./whatif.js";
import { element, elapsed, fixed, place, utc, visibility, wind } from "./text.js";

const byId = (id) => document.getElementById(id);
const FRAME_MS = 17;
/** Frames that a list waits for the map, at most: it may always be busy where scans come fast. */
const MOST_WAITED = 40;

const state = {
  run: null, airport: null, notices: [], runState: null, timeline: null, weather: null, flights: [], federates: [], operations: [],
  scan: null, live: true, selected: null, link: "connecting", notice: null, playing: false, answer: null,
  runs: [], shownRuns: [], loop: null, wish: {}, tab: "tracks", traffic: null, strips: [],
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

const alerts = new AlertPanel(byId("alerts"), {
  time: (s) => utc(state.run?.start_utc_ns, s),
  pick: showAlert,
  acknowledge: (id) => link.send({ type: "ack", id }),
});
const onPick = (strip) => {
  if (strip.trackId) select(strip.trackId);
  else lists.selected(null, strip.callsign);
  lists.flight(strip.callsign);
};
const panes = new Panes(byId("panes"), map, { onPick: (id) => select(id), onChange: () => panesChanged() });
const insets = new Insets(byId("map-box"), map, { onPick: (id) => select(id), onChange: () => addressChanged() });
map.onDrawn = () => {
  panes.draw();
  insets.draw();
};
panes.wallS = () => (state.run?.scan_s || 1) / (state.runState?.achieved_rate || 1);
function panesChanged() {
  for (const button of document.querySelectorAll("[data-pane-of]")) button.setAttribute("aria-pressed", String(panes.has(button.dataset.paneOf)));
  addressChanged(true);
}

/** The address follows the view, once both are there. */
let started = false;
function addressChanged(push = false) {
  if (started) address.changed(push);
}

const { makeLayers, setLayer, makeSensorLayers, drawMark } = switches({ state, map, panes, changed: () => addressChanged(), say: (answer) => showAnswer(answer) });
const { EXPORTS, bookmark } = takeaway({ state, map, curve, address: () => address, say: (answer) => showAnswer(answer) });

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

const whatIf = new WhatIf(byId("what-if"), { state, link, open: openRuns, say: (answer) => showAnswer(answer) });

const stripBoxes = [byId("bays-list")];
const page = { state, map, link, select, selectedNumber, targets, stripBoxes, showStrips, showTab: (key) => lists.showTab(key) };
const lists = panels(byId("tabs"), page, (key) => {
  state.tab = key;
  addressChanged();
});
const strips = stripBoxes.map((box) => new StripPanel(box, { onPick, onAct: (callsign, act) => page.seats.clear(act.seat, callsign, act.clearance), time: (s) => utc(state.run?.start_utc_ns, s) }));

// ---- messages ----

function onText(message) {
  switch (message.type) {
    case "scene":
      state.run = message.run;
      state.airport = message.map;
      state.filters = message.filters;
      map.dragged = new Map(readLocal(`labels ${message.run.scene}`) ?? []);
      map.setAirport(message.map);
      byId("title").textContent = message.run.title || message.run.scene;
      document.title = `${message.run.title || message.run.scene} \u2013 SEEDS`;
      makeSensorLayers();
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
    case "fork":
      whatIf.take(message);
      break;
    case "events":
      line.show({ events: message.events });
      break;
    case "alerts":
      alerts.show(message);
      map.setSaid({ alerts: message.open });
      break;
    case "traffic":
      state.traffic = message.state;
      map.setSaid({ traffic: message.state });
      showStrips();
      showTarget();
      break;
    case "lights":
      map.setSaid({ lights: message.state });
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
      break;
    case "federates":
      state.federates = message.federates;
      break;
    case "operations":
      state.operations = message.operations;
      break;
    case "curve":
      if (message.track === selectedNumber()) curve.add(message);
      break;
    case "new_run":
      setLive(true);
      select(null);
      map.before = new Map();
      state.traffic = null;
      alerts.show({ open: [], ended: [] });
      map.setSaid({ alerts: [], traffic: null, lights: null });
      break;
    case "refused":
      showAnswer({ accepted: false, text: message.text });
      break;
    default: // the panels' own; reply is handled by the link; alive says no more than that; later versions may send others
  }
  lists.came(message.type, message);
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
  panes.scan(state.scan);
  grantSelection();
  if (state.selected && !map.find(state.selected)) keepSelection();
  showTimeline();
  clearTimeout(later);
  state.listing = true;
  later = setTimeout(() => inTurn([() => {
    lists.scan();
    showTarget();
  }, showStrips, () => {
    lists.came("scan");
    makeSensorLayers();
  }]), 0);
}

let later = 0;
/** The lists wait until the map is drawn, and for one another: no frame holds more than one of them. */
function inTurn(steps, waited = 0) {
  const due = !map.busy || document.hidden || waited > MOST_WAITED;
  if (due) steps.shift()();
  state.listing = steps.length > 0;
  if (state.listing) later = setTimeout(() => inTurn(steps, due ? 0 : waited + 1), FRAME_MS);
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
  link.send({ type: "select", track: selectedNumber() });
  lists.selected(id, state.callsign);
  showStrips();
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
  const order = lists.order();
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
  map.need(map.layers.detection ? "ground" : "traffic", "traffic");
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

/** Strips of the time shown, where they are seen. */
function showStrips() {
  if (!state.scan || (!lists.isShown("strips") && map.skin !== "controller")) return;
  const { flights: list, scan, traffic } = state;
  state.strips = stripsOf({ flights: list, scan, traffic, ground: map.situation, timeS: scan.timeS });
  for (const strip of state.strips) strip.act = page.seats.mine(strip.callsign).find((p) => p.asked) ?? null;
  for (const panel of strips) panel.show(state.strips, traffic, state.callsign);
}

/** An alert on the map: its place in the middle, its first subject selected. */
function showAlert(alert) {
  const target = alert.subjects.map((name) => subjectOf(state.scan, name)).find(Boolean), [x, y] = target ? [target.x, target.y] : alert.place_m;
  map.touched = true;
  map.look({ cx: x, cy: y, scale: Math.max(map.view.scale, 0.5) });
  if (target) select(target.id);
  else showAnswer({ accepted: true, text: `${alertWords(alert.kind)}: ${alert.subjects.join(", ")} (no track now)` });
}

function showTarget() {
  const target = map.find(state.selected);
  const name = target ? target.callsign || (target.number === undefined ? "no name" : `Track ${target.number}`)
    : state.selected ? `${state.callsign || state.selected.replace(/^t/, "Track ")} \u2013 not in this picture` : "No target selected";
  byId("target-name").textContent = name;
  byId("target").dataset.empty = String(!state.selected);
  byId("target-name").dataset.mark = target?.movement ?? "";
  facts(byId("target-facts"), [...targetFacts(target), ...clearanceFacts(target, state.traffic)]);
  closeUp(byId("close-up"), map, target);
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

// ---- controls ----

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

const views = {
  in: () => map.zoom(1.5), out: () => map.zoom(1 / 1.5),
  fit: () => {
    map.touched = false;
    map.follow = false;
    map.fit();
    showFollow();
  },
  targets: () => map.fitTargets(),
  inset: () => insets.open() || showAnswer({ accepted: false, text: "two windows at most: close one" }),
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
    if (wanted.pane) panes.set(wanted.pane);
    insets.set([wanted.in1, wanted.in2]);
    if (wanted.find) setTimeout(() => search(wanted.find), 500);
    if (wanted.tab) lists.showTab(wanted.tab);
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
    Object.assign(shown, insets.state);
    if (panes.list.length) shown.pane = ["map", ...panes.names];
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
  showStrips();
  map.need("place");
  addressChanged();
}

// ---- start ----

makeLayers();
lists.showTab("tracks");
keyboard({
  state, map, link, alerts, views, times, insets, finished, setPlaying, toggleRun, command, showTime, showScan, toEvent, setLoop, askTime,
  showTimeline, selectNext, select, addressChanged, setColours, setLayer, bookmark,
});
for (const button of byId("zoom").querySelectorAll("button")) button.addEventListener("click", views[button.dataset.view]);
for (const button of byId("timeline").querySelectorAll("button[data-time]")) {
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
watch(byId("close-up"), showTarget);
setInterval(showLink, 1000);
setColours(readLocal("colours") === "day" ? "day" : "night");
started = true;
address.read();
Promise.all(["700 12px B612", "11px B612", "11px 'B612 Mono'"].map((f) => document.fonts.load(f))).then(() => {
  map.wishes.forget();
  map.need("ground", "place");
});

expose({ state, map, line, curve, alerts, panes, insets, address, whatIf });
