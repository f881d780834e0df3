// The page of a scene's author: routes by click, sensors by drag, the text beside them; the server checks every step and saves.

import { choose, draftOf, nearestOf } from "./draft.js";
import { readLocal, keepLocal } from "./local.js";
import { MapView } from "./map.js";
import { element, place } from "./text.js";

const byId = (id) => document.getElementById(id);
const NEAR_PX = 14;
const state = { file: "", draft: draftOf(""), onDisk: "", places: [], ways: [], sensors: [], via: [], try: [], names: false, drag: null, said: null, busy: false };

const map = new MapView(byId("map"), () => {});
map.layers.detection = true;
map.layers.tracks = map.layers.labels = false;
map.tools = { paint };

// ---- the server ----

async function ask(act) {
  const token = sessionStorage.getItem("token"), headers = token ? { Authorization: `Bearer ${token}` } : {};
  const answer = await fetch(act ? "/author/act" : "/author/scene", act ? { method: "POST", headers, body: JSON.stringify(act) } : { headers });
  if (!answer.ok) throw new Error((await answer.text()).trim());
  return answer.json();
}

/** One question after the other: an answer to an old draft must not come after a new one's. */
let last = Promise.resolve();
function act(wanted, done) {
  last = last.then(async () => {
    state.busy = true;
    try {
      done(await ask(wanted && { text: state.draft.text, ...wanted }));
    } catch (error) {
      say({ error: error.message });
    }
    state.busy = false;
    draw();
  });
  return last;
}

/** Takes what the server made of a draft; an error leaves the draft as it was. */
function take(answer, { draft = true } = {}) {
  if (!answer.error && draft) {
    state.draft = state.draft.to(answer.text);
    byId("text").value = answer.text;
  }
  if (!answer.error) {
    const moved = JSON.stringify(state.sensors) !== JSON.stringify(answer.sensors);
    Object.assign(state, { sensors: answer.sensors, ways: answer.ways });
    map.airport = { ...map.airport, sensors: answer.sensors };
    if (moved) seeAgain();
    map.need("ground");
  }
  say(answer);
}

/** What the sensors see from where they are now. */
function seeAgain() {
  map.detection.key = null;
  map.need("ground");
}

function load() {
  return act(null, (answer) => {
    if (answer.error) return say(answer);
    state.file = answer.file;
    state.onDisk = answer.text;
    state.draft = draftOf(answer.text);
    state.places = answer.places;
    map.setAirport(answer.map);
    take(answer);
    byId("title").textContent = answer.file;
    document.title = `${answer.file} \u2013 SEEDS author`;
    byId("place-names").replaceChildren(...state.places.map((p) => element("option", p.kind, { value: p.name })));
    byId("kinds").replaceChildren(...answer.types.map((name) => element("option", [], { value: name })));
  });
}

// ---- the route ----

function pickPlace(name) {
  state.via = choose(state.via, name);
  byId("via").replaceChildren(...state.via.map((n) => element("li", `${n} (${state.places.find((p) => p.name === n)?.kind ?? "?"})`)));
  preview();
}

/** The way as it would be, without taking it into the draft. */
function preview() {
  state.try = [];
  if (state.via.length < 2) return draw();
  const asked = state.via;
  act({ route: routeOf(asked) }, (answer) => {
    if (asked !== state.via) return;
    state.tried = !answer.error;
    if (answer.error) return say(answer);
    const known = new Set(state.ways.map((w) => w.callsign));
    state.try = answer.ways.filter((w) => !known.has(w.callsign));
    say({ ...answer, text: undefined });
  });
}

function routeOf(via) {
  return { via, callsign: byId("callsign").value.trim().toUpperCase(), designator: byId("kind").value.trim().toUpperCase(), start_s: Number(byId("start").value) || 0 };
}

function clearRoute() {
  Object.assign(state, { via: [], try: [] });
  byId("via").replaceChildren();
  draw();
}

// ---- what is shown ----

function say(answer) {
  state.said = answer;
  const found = byId("found"), warnings = answer.warnings ?? [];
  found.textContent = answer.error ?? (warnings.length ? `${warnings.length} warnings` : answer.saved ? "Saved; no errors, no warnings." : "No errors, no warnings.");
  found.dataset.mark = answer.error ? "bad" : warnings.length ? "" : "good";
  byId("warnings").replaceChildren(...warnings.map((w) => element("li", [w.line ? `line ${w.line}: ` : "", w.number ? `${w.number} ` : "", w.text].join(""))));
  draw();
}

function draw() {
  const changed = state.draft.text !== state.onDisk;
  byId("state").textContent = state.busy ? "checking" : changed ? "not saved" : "as on disk";
  byId("undo").disabled = !state.draft.past.length;
  byId("save").disabled = !changed || Boolean(state.said?.error);
  byId("route-add").disabled = state.via.length < 2 || Boolean(state.said?.error);
  byId("route-clear").disabled = !state.via.length;
  byId("after").textContent = changed ? "" : `seeds run ${state.file}`;
  const box = byId("sensors");
  if (!box.contains(document.activeElement)) box.replaceChildren(...state.sensors.map(sensorRow));
  map.dirty();
}

function sensorRow(sensor, i) {
  const [x, y] = sensor.position_m ?? [];
  const input = (axis, value) => {
    const id = `sensor-${i}-${axis}`, field = element("input", [], { id, type: "number", step: "any", value: value.toFixed(1) });
    field.addEventListener("change", () => {
      const at = ["east", "north"].map((a) => Number(byId(`sensor-${i}-${a}`).value));
      field.blur();
      if (at.every(Number.isFinite)) moveSensor(sensor.name, at);
    });
    return [element("label", `${axis}, m`, { for: id }), field];
  };
  return element("li", [element("strong", `${sensor.name} (${sensor.kind})`), ...(sensor.position_m ? [...input("east", x), ...input("north", y)] : ["on board or around the airport"])]);
}

function moveSensor(name, at) {
  return act({ sensor: [name, at] }, (answer) => take(answer));
}

const LOOK = { stand: "stand", hold: "bar", runway: "runway-mark", node: "taxi-name" };
function paint(g, { cam, c }) {
  const line = (points) => points.forEach(([x, y], i) => (i ? g.lineTo(...cam.toScreen(x, y)) : g.moveTo(...cam.toScreen(x, y))));
  for (const [ways, colour, width] of [[state.ways, c.dim, 2], [state.try, c.departure, 3]]) {
    g.strokeStyle = colour;
    g.lineWidth = width;
    g.beginPath();
    for (const way of ways) line(way.points_m);
    g.stroke();
  }
  g.font = "10px B612, sans-serif";
  g.textAlign = "left";
  for (const p of state.places) {
    const [x, y] = cam.toScreen(...p.at_m), r = p.kind === "node" ? 2 : 3.5;
    if (x < -20 || y < -20 || x > cam.width + 20 || y > cam.height + 20) continue;
    g.fillStyle = c[LOOK[p.kind]];
    if (p.kind === "hold") g.fillRect(x - r, y - r, 2 * r, 2 * r);
    else {
      g.beginPath();
      g.arc(x, y, r, 0, 7);
      g.fill();
    }
    if (state.names && cam.scale > 0.3) g.fillText(p.name, x + 6, y + 3);
  }
  g.strokeStyle = c.select;
  g.fillStyle = c.select;
  g.lineWidth = 2;
  state.via.forEach((name, i) => {
    const p = state.places.find((q) => q.name === name);
    if (!p) return;
    const [x, y] = cam.toScreen(...p.at_m);
    g.beginPath();
    g.arc(x, y, 8, 0, 7);
    g.stroke();
    g.fillText(`${i + 1}`, x + 10, y - 6);
  });
  for (const s of state.sensors) {
    if (!s.position_m) continue;
    const [x, y] = cam.toScreen(...(state.drag?.name === s.name ? state.drag.at : s.position_m));
    g.beginPath();
    g.arc(x, y, 11, 0, 7);
    g.stroke();
    if (state.drag?.name === s.name) g.fillText(s.name, x + 14, y + 4); // else its own name stands below it
  }
}

// ---- hands ----

const canvas = byId("map"), box = byId("map-box");
const at = (event) => {
  const edge = canvas.getBoundingClientRect();
  return [event.clientX - edge.left, event.clientY - edge.top];
};
// A sensor under the pointer is dragged in place of the map.
box.addEventListener("pointerdown", (event) => {
  if (event.target !== canvas) return;
  const sensor = nearestOf(state.sensors.filter((s) => s.position_m), at(event), (s) => map.toScreen(...s.position_m), NEAR_PX);
  if (!sensor) return;
  event.stopPropagation();
  event.preventDefault();
  canvas.setPointerCapture(event.pointerId);
  state.drag = { name: sensor.name, at: sensor.position_m, moved: false };
}, true);
box.addEventListener("pointermove", (event) => {
  if (!state.drag) return;
  event.stopPropagation();
  state.drag = { ...state.drag, at: map.toMetres(...at(event)), moved: true };
  byId("pointer-at").textContent = place(...state.drag.at);
  map.dirty();
}, true);
box.addEventListener("pointerup", (event) => {
  const { drag } = state;
  if (!drag) return;
  event.stopPropagation();
  if (!drag.moved) state.drag = null;
  else moveSensor(drag.name, drag.at).then(() => {
    state.drag = null;
    draw();
  });
}, true);
map.onPick = (_, metres) => {
  const found = nearestOf(state.places, map.toScreen(...metres), (p) => map.toScreen(...p.at_m), NEAR_PX);
  if (found) pickPlace(found.name);
};
map.onPointer = (p) => {
  if (!state.drag) byId("pointer-at").textContent = p ? place(...p) : "";
};

byId("place-add").addEventListener("click", () => {
  const name = byId("place").value.trim();
  if (state.places.some((p) => p.name === name)) pickPlace(name);
  else say({ error: `there is no place "${name.slice(0, 40)}" on the network` });
  byId("place").value = "";
});
for (const id of ["callsign", "kind", "start"]) byId(id).addEventListener("change", preview);
byId("route-add").addEventListener("click", () => act({ route: routeOf(state.via) }, (answer) => {
  take(answer);
  if (!answer.error) {
    byId("callsign").value = "";
    clearRoute();
  }
}));
byId("route-clear").addEventListener("click", () => {
  clearRoute();
  act({}, take);
});
byId("text").addEventListener("change", () => {
  state.draft = state.draft.to(byId("text").value);
  act({}, (answer) => take(answer));
});
byId("undo").addEventListener("click", undo);
function undo() {
  state.draft = state.draft.back();
  byId("text").value = state.draft.text;
  act({}, (answer) => take(answer, { draft: false }));
}
document.addEventListener("keydown", (event) => {
  if (event.key === "z" && (event.ctrlKey || event.metaKey) && !/^(INPUT|TEXTAREA)$/.test(event.target.tagName) && state.draft.past.length) undo();
});
byId("reload").addEventListener("click", () => load());
byId("save").addEventListener("click", () => act({ save: true }, (answer) => {
  take(answer);
  if (answer.saved) state.onDisk = answer.text;
}));
for (const button of byId("zoom").querySelectorAll("button")) {
  button.addEventListener("click", () => ({
    in: () => map.zoom(1.5), out: () => map.zoom(1 / 1.5), fit: () => map.fit(),
    names: () => (state.names = !state.names),
    sees: () => {
      map.layers.detection = !map.layers.detection;
      map.need("ground");
    },
  })[button.dataset.view]());
  button.addEventListener("click", () => {
    if (button.dataset.view === "names") button.setAttribute("aria-pressed", String(state.names));
    if (button.dataset.view === "sees") button.setAttribute("aria-pressed", String(map.layers.detection));
    map.dirty();
  });
}
function setColours(colours) {
  document.documentElement.dataset.colours = colours;
  byId("colours").textContent = colours === "night" ? "Day" : "Night";
  map.colours();
  keepLocal("colours", colours);
}
byId("colours").addEventListener("click", () => setColours(document.documentElement.dataset.colours === "night" ? "day" : "night"));
addEventListener("beforeunload", (event) => {
  if (state.draft.text !== state.onDisk) event.preventDefault();
});

setColours(readLocal("colours") === "day" ? "day" : "night");
load();

Object.defineProperty(window, "__author", { value: Object.freeze({
  get state() {
    return structuredClone({ via: state.via, sensors: state.sensors, ways: state.ways.length, tried: state.try.length, said: state.said && { error: state.said.error, warnings: state.said.warnings, saved: state.said.saved }, busy: state.busy, changed: state.draft.text !== state.onDisk, text: state.draft.text, file: state.file, places: state.places, seen: map.detection.shown });
  },
  toScreen: (x, y) => map.toScreen(x, y),
}) });
