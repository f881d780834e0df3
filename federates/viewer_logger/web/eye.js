// The page of the eye: takes scans, weather and airport from the viewer, and shows what is seen from a place.

import { Asks, eyeOf, outOf, troubleOf } from "./eye_address.js";
import { decode, setWords } from "./frame.js";
import { aboard, axes, hidden, matrix, outlook, project, reckoned, seen } from "./eye_see.js";
import { backgroundOf, extinction, extinctionTo, illuminance, rainAt, sightM, sunElevation, threshold } from "./eye_light.js";
import { worn } from "./eye_lamps.js";
import { faces, fixed, slopes, switched } from "./eye_ground.js";
import { aircraft, board, flats, Mesh, solids, vehicle } from "./eye_scene.js";
import { Renderer } from "./eye_gl.js";
import { Link } from "./link.js";
import { MapView } from "./map.js";
import { Ground } from "./situation.js";
import { readState } from "./state.js";
import { element, utc } from "./text.js";
import { Wheel, wordsOf } from "./wheel.js";

const byId = (id) => document.getElementById(id);
const AHEAD_S = 2, JUMP_S = 5, CLEAR_FOV = 40, NEAR_FOV = 7;
const canvas = byId("eye");
const state = { run: null, airport: null, notices: [], scan: null, arrived: 0, rate: 0, eye: "tower", of: null, at: null, look: [0, 0], fov: CLEAR_FOV, frames: 0, dragging: false };
let gl = null, map = null;
const made = { shapes: new Map() };

// ---- the address: eye, at, look, fov beside the keys of the page ----

function readAddress() {
  const { state: view, kept } = readState(location.hash), own = Object.fromEntries(kept.map((part) => part.split(/=(.*)/s).slice(0, 2)));
  const numbers = (text, n) => {
    const list = (text ?? "").split(",").map(Number);
    return list.length === n && list.every(Number.isFinite) ? list : null;
  };
  state.at = numbers(own.at, 3) ?? (own.eye ? null : state.at);
  state.look = numbers(own.look, 2) ?? state.look;
  if (own.look) state.looked = state.turned = true;
  const [fov] = numbers(own.fov, 1) ?? [];
  if (fov >= 1 && fov <= 120) state.fov = fov;
  const eye = eyeOf(own.eye);
  if (eye) [state.eye, state.of, state.named] = [...eye, Boolean(eye[1])];
  if (state.at) state.eye = "free";
  state.notShown = ""; // of the address of before; this one may be refused in turn
  asks.want({ t: view.t, run: view.run });
}

let writing = 0;
function writeAddress() {
  clearTimeout(writing);
  writing = setTimeout(() => {
    const parts = [`eye=${state.eye}${state.of ? `:${encodeURIComponent(state.of)}` : ""}`];
    const { run, t } = asks.wish;
    if (run) parts.push(`run=${run.join()}`);
    if (t !== undefined) parts.push(`t=${t}`);
    if (state.at) parts.push(`at=${state.at.map((v) => v.toFixed(1))}`);
    parts.push(`look=${state.look.map((v) => v.toFixed(2))}`, `fov=${state.fov.toFixed(1)}`);
    history.replaceState(null, "", `#${parts.join("&")}`);
  }, 300);
}

// ---- messages ----

const link = new Link({
  text(message) {
    if (message.type === "scene") {
      setWords(message.words);
      state.run = message.run;
      state.airport = message.map;
      state.notShown = "";
      state.looked = Boolean(state.turned); // another run: other traffic
      build();
      map?.setAirport(message.map);
      state.lights = null;
    } else if (message.type === "lights") state.lights = message.state;
    else if (message.type === "weather") state.notices = message.notices;
    else if (message.type === "driven") wheel.take(message.state);
    else if (message.type === "state") state.rate = message.state.phase === "RUNNING" ? message.state.achieved_rate || message.state.rate || 0 : 0;
    else if (message.type === "runs") asks.runs(message.shown);
    else if (message.type === "refused") {
      state.notShown = message.text;
      asks.refused();
    }
    else if (message.type === "timeline") asks.timeline(message);
    draw();
  },
  scan(buffer) {
    try {
      const scan = decode(buffer);
      if (scan.run) return;
      if (!state.turned && !scan.newest && Math.abs(scan.timeS - (state.scan?.timeS ?? 0)) > JUMP_S) state.looked = false;
      state.scan = scan;
      state.arrived = performance.now();
      map?.setScan(scan);
      offer();
      if (!state.looked && state.airport) lookOut();
      draw();
      state.unreadable = false;
    } catch {
      state.unreadable = true; // of another version
      draw();
    }
  },
  state(word) {
    state.link = word;
    draw();
  },
}, () => {
  asks.hello();
  return [];
});
const asks = new Asks((message) => link.send(message));

// ---- at the wheel of what one looks out of, where people may drive it ----

const wheel = new Wheel(link, {
  changed: () => draw(),
  rate: () => (state.scan?.newest ? state.rate : 0),
  refused: (why) => (state.refused = why),
});

/** What people drive, by call sign, as it is now; nothing in the past. */
function drivenNow() {
  return new Map(state.scan?.newest ? wheel.movers().map((m) => [m.callsign, m]) : []);
}

/** Truth of a target, brought to now where somebody drives it. */
function asDriven(t, driven) {
  const m = driven.get(t.callsign);
  return m ? { truth: { ...t, x: m.at_m[0], y: m.at_m[1], vx: 0, vy: 0, ax: 0, ay: 0, heading: m.heading_rad }, now: true } : { truth: t, now: false };
}

async function drive() {
  const mover = drivenNow().get(state.of);
  state.refused = "";
  if (wheel.mine) await wheel.leave();
  else if (mover) await wheel.sit(mover.seat);
  else if (wheel.flights.includes(`pilot ${state.of}`)) await wheel.sit(`pilot ${state.of}`);
  draw();
}

function showWheel() {
  const aboardOne = state.eye === "pilot" || state.eye === "driver", mover = aboardOne ? drivenNow().get(state.of) : null, button = byId("drive");
  button.hidden = !mover && !(aboardOne && wheel.flights.includes(`pilot ${state.of}`));
  button.setAttribute("aria-pressed", String(Boolean(mover && wheel.mine === mover.seat)));
  button.disabled = Boolean(mover?.taken && wheel.mine !== mover.seat);
  const words = state.refused || (mover && wheel.mine === mover.seat ? wordsOf(mover, wheel.parked) : "");
  if (byId("wheel-says").textContent !== words) byId("wheel-says").textContent = words;
}

/** Who can be looked out of. */
function offer() {
  const wanted = state.eye === "driver" ? (t) => !t.aircraft : (t) => t.aircraft, list = state.eye === "pilot" || state.eye === "driver" ? state.scan.truth.filter(wanted).map((t) => t.callsign) : [];
  const box = byId("of");
  if ([...box.options].map((o) => o.value).join() !== list.join()) box.replaceChildren(...list.map((name) => element("option", name, { value: name })));
  state.of = outOf(state.of, list, state.named);
  state.absent = (state.eye === "pilot" || state.eye === "driver") && Boolean(state.of) && !list.includes(state.of);
  box.value = state.of ?? "";
  box.hidden = byId("of-label").hidden = !list.length;
}

// ---- what is where ----

/** Seconds since the scan shown, that truth is carried on by; nothing in the past. */
function age() {
  if (!state.scan?.newest || !state.rate) return 0;
  return Math.min(AHEAD_S, ((performance.now() - state.arrived) / 1000) * state.rate);
}

const towerEye = () => state.airport?.cab?.at_m ?? [0, 0, 45];

/** From the tower one looks where the most is going on; from a seat, ahead. */
function lookOut() {
  state.looked = true;
  if (state.eye !== "tower") return;
  const eye = towerEye(), width = (2 * Math.atan(Math.tan((state.fov * Math.PI) / 360) * aspect()) * 180) / Math.PI, targets = targetsAt(0).map((t) => t.ground);
  state.look = [outlook(eye, targets.length ? targets : (state.airport?.runways ?? []).flatMap((r) => r.ends), width), -3];
}

function pose() {
  const dt = age();
  if ((state.eye === "pilot" || state.eye === "driver") && state.scan) {
    const own = state.scan.truth.find((t) => t.callsign === state.of);
    if (own) {
      const { truth, now } = asDriven(own, drivenNow());
      const { eye, look } = aboard(truth, now ? 0 : dt, state.eye);
      return { eye, look: [look[0] + state.look[0], state.look[1]], own: own.id };
    }
  }
  return { eye: state.eye === "free" && state.at ? state.at : towerEye(), look: state.look, own: null };
}

function weather() {
  const now = (state.scan?.timeS ?? 0) * 1e9;
  return state.notices.findLast((n) => n.from_ns <= now) ?? null;
}

const aspect = () => canvas.width / Math.max(1, canvas.height);

/** What the air and the sun do now, seen from a place. */
function light(eye) {
  const w = weather(), beta = extinction(w?.visibility_m, rainAt(w, eye[0], eye[1]));
  const start = Number(BigInt(state.run?.start_utc_ns ?? "0") / 1000000n), [lat, lon] = state.airport?.reference_deg ?? [0, 0];
  const sun = sunElevation(start + (state.scan?.timeS ?? 0) * 1000, lat, lon), background = backgroundOf(sun), night = background < 30;
  const fog = sightM(beta) < 5000, direct = night ? 0 : fog ? 0 : 0.55 * Math.min(1, Math.max(0, sun) / 15);
  const s = (Math.max(3, sun) * Math.PI) / 180;
  return {
    beta, betaTo: (to) => extinctionTo(w, eye, to), fog: extinction(w?.visibility_m), rain: w?.rain_mm_per_h ?? 0, cells: w?.cells ?? [], visibility: w?.visibility_m ?? null, background, night, exposure: night ? 0.05 : 0.62, horizon: [1, 1, 1], zenith: fog ? [1, 1, 1] : [0.38, 0.55, 0.95],
    sun: [0.6 * Math.cos(s), -0.8 * Math.cos(s), Math.sin(s)], sunLight: direct, skyLight: night ? 0.35 : 0.85, wet: (w?.film_mm ?? 0) > 0.1 ? 1 : 0, threshold: threshold(background),
  };
}

function targetsAt(dt) {
  const driven = drivenNow();
  return (state.scan?.truth ?? []).filter((t) => Number.isFinite(t.x + t.y)).map((t0) => {
    const { truth: t, now } = asDriven(t0, driven), at = reckoned(t, now ? 0 : dt), height = t.aircraft ? Math.min(20, 0.3 * (t.lengthM || 10)) : 2;
    return { id: t.callsign || t.id, key: t.id, truth: t, ground: at, at: [at[0], at[1], Math.max(0, at[2]) + height / 2] };
  });
}

function visible() {
  const { eye, look, own } = pose(), l = light(eye);
  return seen({ eye, look, fov: state.fov, aspect: aspect(), sight: (to) => sightM(l.betaTo(to)) }, targetsAt(age()).filter((t) => t.key !== own), state.airport?.blocks ?? []);
}

// ---- pictures ----

function build() {
  if (!state.airport) return;
  made.ground = new Ground(state.airport);
  if (!gl) return;
  for (const name of ["flats", "solids", "lamps"]) gl.free(made[name]);
  made.flats = gl.upload(flats(state.airport).array());
  made.solids = gl.upload(solids(state.airport).array());
  made.lampsOf = null;
}

function lampsFor(night) {
  if (made.lampsOf === night) return;
  made.lampsOf = night;
  gl.free(made.lamps);
  made.lampList = fixed(state.airport, night);
  made.lamps = gl.upload(lampVertices(made.lampList), LAMP_SIZES);
}

/** Lamps that change with the time or the eye: stop bars and runway status lights, approach slopes, those of movers. */
function changing({ eye, own }, dt) {
  const { night } = light(eye);
  return state.airport ? [...switched(state.lights, night), ...slopes(state.airport, eye, night), ...wornLamps({ eye, own }, dt)] : [];
}

/** Lamps of all movers as they are seen from `eye` now, but those of whom one looks out of. */
function wornLamps({ eye, own }, dt) {
  if (!made.ground) return [];
  const timeS = (state.scan?.timeS ?? 0) + dt;
  return targetsAt(dt).filter((m) => m.key !== own).flatMap(({ truth, ground: place }) => worn(made.ground, truth, place, eye, timeS, state.rate > 0 && state.scan.newest));
}

/** Numbers of a lamp: place, colour and candela, side to which it shines (0: around). */
const LAMP_SIZES = [3, 4, 2];
const lampVertices = (list) => new Float32Array(list.flatMap((l) => [...l.at, ...l.colour, l.cd, ...(l.aim ?? [0, 0])]));

function shapeOf(t) {
  const key = `${t.aircraft} ${t.lengthM} ${t.spanM} ${t.aircraft ? "" : t.designator}`;
  if (!made.shapes.has(key)) made.shapes.set(key, gl.upload((t.aircraft ? aircraft(t.lengthM || 30, t.spanM || 28) : vehicle(t.lengthM || 5, t.spanM, t.designator)).array()));
  return made.shapes.get(key);
}

let asked = false;
function draw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    paint();
    if ((age() > 0 && age() < AHEAD_S) || wheel.mine) draw(); // truth is carried on: the picture moves
  });
}

function paint() {
  const ratio = window.devicePixelRatio || 1, w = Math.max(1, Math.round(canvas.clientWidth * ratio)), h = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
  const { eye, look, own } = pose(), l = light(eye), dt = age();
  byId("who").textContent = { tower: ["tower", state.airport?.cab?.by].filter(Boolean).join(", "), free: "free" }[state.eye] ?? `${state.eye} ${state.of ?? ""}${state.absent ? " is not there at this time; this is the tower" : ""}`;
  byId("utc").textContent = `${utc(state.run?.start_utc_ns, (state.scan?.timeS ?? 0) + dt)} UTC`;
  byId("air").textContent = Number.isFinite(l.visibility) && l.visibility !== null ? `visibility ${Math.round(l.visibility)} m` : "clear";
  const trouble = troubleOf({ link: state.link, refused: state.notShown, unreadable: state.unreadable });
  if (byId("trouble").textContent !== trouble) byId("trouble").textContent = trouble;
  canvas.classList.toggle("stale", Boolean(trouble));
  showWheel();
  byId("age").textContent = dt > 0 ? `reckoned ${dt.toFixed(1)} s` : "";
  if (map) map.unseen = new Set(visible());
  map?.dirty();
  if (!gl || !state.airport || !made.flats) return;
  lampsFor(l.night);
  const boards = new Mesh();
  for (const plate of state.airport.boards ?? []) board(boards, plate, eye);
  gl.free(made.boards);
  made.boards = boards.data.length ? gl.upload(boards.array()) : null;
  gl.free(made.worn);
  made.worn = gl.upload(lampVertices(changing({ eye, own }, dt)), LAMP_SIZES);
  const t = Math.tan((state.fov * Math.PI) / 360), { ahead, right, up } = axes(look);
  const view = { matrix: matrix(eye, look, state.fov, aspect()), eye, ahead, right: right.map((v) => v * t * aspect()), up: up.map((v) => v * t) };
  const models = targetsAt(dt).filter((m) => m.key !== own).map(({ truth, ground }) => ({
    shape: shapeOf(truth), place: [ground[0], ground[1], Math.max(0, ground[2]), Number.isFinite(truth.heading) ? truth.heading : 0],
  }));
  gl.draw(l, view, { ...made, models });
  state.frames++;
  const names = visible();
  const words = names.length ? `seen: ${names.join(", ")}` : "nobody is seen";
  if (byId("seen").textContent !== words) byId("seen").textContent = words; // a reader says each writing
}

// ---- controls ----

function choose(eye) {
  if (eye !== state.eye) state.named = false;
  state.eye = eye;
  state.turned = false;
  state.at = null;
  state.look = [0, 0];
  lookOut();
  if (state.scan) offer();
  writeAddress();
  draw();
}

function turn(dx, dy) {
  const [bearing, elevation] = state.look;
  state.turned = true;
  state.look = [(((bearing + dx) % 360) + 360) % 360, Math.min(89, Math.max(-89, elevation + dy))];
  writeAddress();
  draw();
}

function move(ahead, side) {
  const { eye, look } = pose(), b = (look[0] * Math.PI) / 180, far = Math.max(2, eye[2] * 0.2);
  state.eye = "free";
  state.turned = true;
  state.at = [eye[0] + far * (Math.sin(b) * ahead + Math.cos(b) * side), eye[1] + far * (Math.cos(b) * ahead - Math.sin(b) * side), eye[2]];
  state.look = look;
  writeAddress();
  draw();
}

function binoculars() {
  state.fov = state.fov > NEAR_FOV + 1 ? NEAR_FOV : CLEAR_FOV;
  byId("binoculars").setAttribute("aria-pressed", String(state.fov === NEAR_FOV));
  writeAddress();
  draw();
}

/** The same moment beside it as the radar has it; rings mark whom only one of the two sees. */
function split() {
  const box = byId("map-box");
  box.hidden = !box.hidden;
  byId("split").setAttribute("aria-pressed", String(!box.hidden));
  if (!box.hidden && !map) {
    map = new MapView(byId("map"), () => {});
    for (const key of ["truth", "errors", "ellipses"]) map.layers[key] = false;
    map.tools = { paint: ring };
    if (state.airport) map.setAirport(state.airport);
    if (state.scan) map.setScan(state.scan);
  }
  setTimeout(draw, 50);
}

function ring(g, view) {
  g.strokeStyle = view.c.select;
  g.lineWidth = 1.5;
  for (const track of view.scan?.tracks ?? []) {
    if (!track.truth || view.unseen?.has(track.truth.callsign || track.truth.id)) continue;
    g.beginPath();
    g.arc(...view.toScreen(track.x, track.y), 13, 0, 7);
    g.stroke();
  }
}

const KEYS = {
  ArrowLeft: () => turn(-state.fov / 12, 0), ArrowRight: () => turn(state.fov / 12, 0), ArrowUp: () => turn(0, state.fov / 12), ArrowDown: () => turn(0, -state.fov / 12),
  b: binoculars, 1: () => choose("tower"), 2: () => choose("pilot"), 3: () => choose("driver"), w: () => move(1, 0), s: () => move(-1, 0), a: () => move(0, -1), d: () => move(0, 1), m: split,
};
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("select")) return;
  // Who drives, drives with these keys; he looks around with the mouse.
  if (wheel.mine && event.key !== "Tab") {
    if (event.key === "Escape") drive();
    else if (!wheel.key(event.key, true) && !["b", "m"].includes(event.key.toLowerCase())) return;
    else if (["b", "m"].includes(event.key.toLowerCase())) KEYS[event.key.toLowerCase()]();
    event.preventDefault();
    return;
  }
  const act = KEYS[event.key] ?? KEYS[event.key.toLowerCase()];
  if (!act) return;
  act();
  event.preventDefault();
});
for (const button of document.querySelectorAll("[data-eye]")) button.addEventListener("click", () => choose(button.dataset.eye));
document.addEventListener("keyup", (event) => wheel.key(event.key, false));
window.addEventListener("blur", () => wheel.held.clear());
byId("drive").addEventListener("click", () => {
  drive();
  byId("drive").blur();
});
byId("binoculars").addEventListener("click", binoculars);
byId("split").addEventListener("click", split);
byId("of").addEventListener("change", (event) => {
  state.of = event.target.value;
  state.named = true;
  state.absent = false;
  writeAddress();
  draw();
});
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  state.dragging = true;
});
canvas.addEventListener("pointerup", () => (state.dragging = false));
canvas.addEventListener("pointermove", (event) => {
  const k = state.fov / Math.max(1, canvas.clientHeight);
  if (state.dragging) turn(-event.movementX * k, event.movementY * k);
});
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  state.fov = Math.min(90, Math.max(2, state.fov * Math.exp(event.deltaY * 0.001)));
  writeAddress();
  draw();
}, { passive: false });
canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
canvas.addEventListener("webglcontextrestored", () => start());
window.addEventListener("hashchange", () => {
  readAddress();
  if (state.scan) offer();
  draw();
});
new ResizeObserver(draw).observe(canvas);

function start() {
  try {
    gl = new Renderer(canvas);
    made.shapes.clear();
    for (const name of ["flats", "solids", "lamps", "worn", "boards"]) made[name] = null;
    build();
  } catch {
    gl = null;
    byId("eye-none").hidden = false;
    if (!map) split();
  }
}

readAddress();
start();
draw();

// ---- the hook for tests and tools: getters only ----

const copy = (value) => Object.freeze(JSON.parse(JSON.stringify(value ?? null)));
function marks() {
  const { eye, look } = pose();
  return (state.airport?.boards ?? []).map(({ name, centre_m: c, size_m: size }) => {
    const p = project(c, eye, look, state.fov, aspect()), t = Math.tan((state.fov * Math.PI) / 360);
    return { name, distance_m: p.distance, px: ((p.x + 1) / 2) * canvas.clientWidth, py: ((1 - p.y) / 2) * canvas.clientHeight, half_px: (size / 2 / (p.ahead * t)) * (canvas.clientHeight / 2) };
  });
}
function lampOf(id) {
  const { eye, own } = pose(), l = light(eye), lamp = [...(made.lampList ?? []), ...changing({ eye, own }, age())].find((x) => x.id === id);
  if (!lamp) return null;
  const E = illuminance(lamp.cd, l.betaTo(lamp.at), Math.hypot(...lamp.at.map((v, i) => v - eye[i])));
  return { E, E_T: l.threshold, seen: E >= l.threshold && faces(lamp, eye) && !(state.airport.blocks ?? []).some((b) => hidden(eye, lamp.at, b)) };
}
Object.defineProperty(window, "__eye", {
  value: Object.freeze(Object.defineProperties({}, Object.fromEntries(Object.entries({
    pose: () => copy(pose()), fov: () => state.fov, beta: () => light(pose().eye).beta, visibility_m: () => light(pose().eye).visibility, visible: () => copy(visible()), marks: () => copy(marks()),
    lamps: () => (id) => copy(lampOf(id)), lampIds: () => copy((made.lampList ?? []).map((l) => l.id)), worn: () => copy(wornLamps(pose(), age())), age_s: () => age(), triangles: () => gl?.triangles ?? 0, calls: () => gl?.calls ?? 0,
    frames: () => state.frames, scan: () => state.scan?.scan ?? null, timeS: () => state.scan?.timeS ?? null,
  }).map(([name, get]) => [name, { get, enumerable: true }])))),
});
