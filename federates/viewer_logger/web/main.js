// Wires the page together: messages of the server in, map, lists and controls out.

import { Address } from "./address.js";
import { AlertPanel, alertWords, runwayOf, subjectOf } from "./alerts.js";
import { CommandLine } from "./command.js";
import { Compared } from "./compare.js";
import { closeUp, watch } from "./closeup.js";
import { Curve } from "./curve.js";
import { decode, setWords } from "./frame.js";
import { head } from "./head.js";
import { hiddenLabels } from "./hidden.js";
import { expose } from "./hook.js";
import { Insets } from "./insets.js";
import { keyboard } from "./keys.js";
import { Link } from "./link.js";
import { keepLocal, readLocal } from "./local.js";
import { Panes } from "./panes.js";
import { forgetSaid, otherFirst, runList, selectAgain } from "./runs.js";
import { MapView } from "./map.js";
import { clearanceFacts, StripPanel, stripsOf, withTargets } from "./strips.js";
import { sidePanes } from "./sidepanes.js";
import { playback } from "./playback.js";
import { TimeLine } from "./time.js";
import { found, latLon, Tools, tutorial } from "./tools.js";
import { switches } from "./switches.js";
import { takeaway } from "./takeaway.js";
import { facts, targetFacts } from "./lists.js";
import { panels } from "./panels.js";
import { entityName, viewOf } from "./view.js";
import { WhatIf } from "./whatif.js";
import { place, utc } from "./text.js";

const byId = (id) => document.getElementById(id);
const FRAME_MS = 17;
/** Frames that a list waits for the map, at most: it may always be busy where scans come fast. */
const MOST_WAITED = 40;

const state = {
  run: null, airport: null, notices: [], runState: null, timeline: null, weather: null, flights: [], federates: [], operations: [],
  scan: null, live: true, asked: null, selected: null, link: "connecting", notice: null, playing: false, answer: null,
  runs: [], shownRuns: [], loop: null, wish: {}, effect: null, tab: "tracks", traffic: null, strips: [],
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

hiddenLabels(byId("labels-hidden"), map, (id) => select(id));

const curve = new Curve(byId("curve"), (scan) => showScan(scan));

const line = new TimeLine(byId("strip"), byId("scrub"), byId("event-kinds"));

const alerts = new AlertPanel(byId("alerts"), {
  time: (s) => utc(state.run?.start_utc_ns, s),
  runway: (alert) => runwayOf(alert, state.scan, map.situation)?.names.join("/") ?? "",
  pick: showAlert,
  acknowledge: (id) => link.send({ type: "ack", id }),
});
const onPick = (strip) => {
  if (strip.trackId) select(strip.trackId);
  else lists.selected(null, strip.callsign);
  lists.flight(strip.callsign);
};
const panes = new Panes(byId("panes"), map, { onPick: (id) => select(id), onChange: () => panesChanged(), runName: (place) => state.shownRuns[place] ?? "" });
const compared = new Compared(byId("run-beside"), {
  map, names: () => state.shownRuns, changed: () => {
    panes.setRuns(compared.mode === "side" ? state.shownRuns.slice(1).map((_, i) => i + 1) : []);
    addressChanged(true);
  },
});
map.compared = compared;
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
  const hello = [{ type: "show", scan: state.live ? null : state.asked ?? state.scan?.scan ?? null }];
  if (selectedNumber() !== null) hello.push({ type: "select", track: selectedNumber() });
  if (state.wish.run) hello.unshift({ type: "open", runs: state.wish.run });
  return hello;
});

const { showScan, came, showTime, setLive, setPlaying, showTimeline, finished, askStrip, forgetStrip, toEvent, setLoop, askTime, goTo, grantTime, times } = playback({
  state, map, link, line, changed: () => addressChanged(), say: (answer) => showAnswer(answer),
  shown: () => {
    showClock();
    showWeather();
  },
});
const { showClock, showState, showLink, showWeather } = head({ state, map, curve, finished });

const { showRuns, openRuns } = runList({ state, link, forgetStrip, changed: () => addressChanged(true) });
panes.makers = sidePanes({
  state, curve, onTime: (scan) => showScan(scan), send: (message) => link.send(message), close: (name) => panes.toggle(name),
  addStrips(box) {
    const panel = stripPanel(box);
    strips.push(panel);
    setTimeout(showStrips, 0);
    return panel;
  },
  dropStrips: (panel) => strips.splice(strips.indexOf(panel), 1),
});
const whatIf = new WhatIf(byId("what-if"), { state, link, open: openRuns, say: (answer) => showAnswer(answer) });

const stripBoxes = [byId("bays-list")];
const page = { state, map, link, operate, select, selectedNumber, targets, stripBoxes, showStrips, viewChanged: () => addressChanged(true), showTab: (key) => lists.showTab(key) };
const lists = panels(byId("tabs"), page, (key) => {
  state.tab = key;
  addressChanged();
});
const sayLine = new CommandLine({ form: byId("say"), input: byId("clearance-line"), says: byId("said"), next: byId("next") }, {
  state, map, seats: () => page.seats, finished, focusMap: () => byId("map").focus(),
});
const stripPanel = (box) => new StripPanel(box, { onPick, onAct: (callsign, act) => page.seats.clear(act.seat, callsign, act.clearance), time: (s) => utc(state.run?.start_utc_ns, s) });
const strips = stripBoxes.map(stripPanel);

// ---- messages ----

function onText(message) {
  switch (message.type) {
    case "scene":
      setWords(message.words);
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
      if (otherFirst(state.shownRuns, message.shown)) {
        Object.assign(state, { operations: [], asked: null });
        forgetSaid({ state, map, alerts });
        selectAgain({ state, select });
      }
      state.shownRuns = message.shown;
      map.run = message.shown[0] ?? "";
      map.others.clear();
      compared.forget();
      if (compared.mode) compared.page.changed();
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
      line.show({ events: message.events, more: message.more });
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
    case "sees":
      showSees(message.seats);
      break;
    case "lights":
      map.setSaid({ lights: message.state });
      break;
    case "foreign":
      map.setForeign(message.tracks);
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
      map.forgetLabels();
      forgetSaid({ state, map, alerts });
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
      compared.scan();
      return;
    }
    state.scan = scan;
    state.notice = null;
    came();
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
  return [...state.scan.tracks, ...(map.skin === "controller" ? [] : state.scan.truth.filter((t) => t.track === null))];
}

// ---- selection ----

function selectedNumber() {
  return state.selected?.startsWith("t") ? Number(state.selected.slice(1)) : null;
}

function select(id) {
  if (id === state.selected) return;
  delete state.wish.sel;
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


// ---- what the parts show ----

/** Strips of the time shown, where they are seen. */
function showStrips() {
  sayLine.show();
  if (!state.scan || (!lists.isShown("strips") && map.skin !== "controller" && !panes.has("strips"))) return;
  const { flights: list, scan } = state, traffic = withTargets(state.traffic, page.seats.state);
  state.strips = stripsOf({ flights: list, scan, traffic, ground: map.situation, timeS: scan.timeS });
  for (const strip of state.strips) strip.act = page.seats.mine(strip.callsign).find((p) => p.asked) ?? null;
  for (const panel of strips) panel.show(state.strips, traffic, state.callsign);
}

/** From which seats this page sees; the server sends it nothing else. */
function showSees(seats) {
  const aboard = (seat) => /^(driver|pilot) /.test(seat), box = byId("sees");
  box.hidden = !seats.length;
  map.blind = seats.length > 0;
  box.textContent = `${seats.join(", ")}: ${seats.every(aboard) ? "only who is in sight" : "as sensors have it, without the truth"}`;
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
    : state.selected ? `${state.callsign || state.selected.replace(/^t/, "Track ")} \u2013 not in this picture`
      : state.wish.sel ? `${state.wish.sel} \u2013 not in this picture` : "No target selected";
  byId("target-name").textContent = name;
  byId("target").dataset.empty = String(!state.selected);
  byId("target-name").dataset.mark = target?.movement ?? "";
  facts(byId("target-facts"), [...targetFacts(target, map.skin === "controller", map.stands.get(target?.callsign)), ...clearanceFacts(target, withTargets(state.traffic, page.seats?.state), (s) => utc(state.run?.start_utc_ns, s))]);
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
  await operate(message);
}

/** Asks the run for what an operator wants, and shows the answer. */
async function operate(message) {
  byId("answer").textContent = `${message.command} \u2026`;
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

// ---- several runs, links, exports ----

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

function grantSelection() {
  const { sel, follow } = state.wish;
  if (sel === undefined) return;
  const found = targets().find((t) => t.callsign === sel || `#${t.number}` === sel || entityName(t) === sel);
  if (!found) {
    if (!state.selected) showTarget();
    return;
  }
  delete state.wish.sel;
  select(found.id);
  if (follow) map.setFollow(true);
}

const address = new Address({
  map,
  say: (text) => showAnswer({ accepted: false, text }),
  colours: (colours) => setColours(colours),
  layer: (key, on) => setLayer(key, on),
  skin: (skin) => setSkin(skin),
  ...viewOf({ state, map, panes, insets, lists, compared, search, openRuns, grantTime, grantSelection }),
});

/** Tabs that hold a run against the truth. */
const JUDGED = ["effects", "filter", "sensors"];

/** Research shows truth and errors; a controller's position shows what a controller has. */
function setSkin(skin) {
  map.skin = skin;
  document.documentElement.dataset.skin = skin;
  byId("skin").setAttribute("aria-pressed", String(skin === "controller"));
  for (const key of ["truth", "errors", "ellipses", "plots"]) setLayer(key, skin === "research");
  map.vectorS = skin === "controller" ? 30 : 15;
  line.show({ judged: skin !== "controller" });
  if (skin === "controller" && JUDGED.includes(state.tab)) lists.showTab("strips");
  lists.scan();
  showTarget();
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
