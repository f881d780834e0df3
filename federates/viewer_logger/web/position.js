// What a controller's position adds to the map: stop bars, runways by their state, the way of who is selected, alerts round their targets.

import { runwayOf, subjectOf } from "./alerts.js";
import { runwayRing } from "./situation.js";

/** State of a runway: "free", "reserved" (somebody has it), "occupied" (somebody is on it), "alert". */
export function runwayState(runway, { traffic, scan, ground, alerts }) {
  const names = runway.designators, said = traffic?.runways.find((r) => r.name.split("/").some((n) => names.includes(n)));
  const there = (t) => ground?.runwayAt(t.x, t.y)?.names === names && !(t.altitudeM > 15);
  const inside = (alerts ?? []).some((a) => a.stage === "alarm" && (runwayOf(a, scan, ground) ?? ground?.runwayAt(...a.place_m))?.names === names);
  if (inside) return "alert";
  if ((scan?.tracks ?? []).some(there)) return "occupied";
  return said?.owner ? "reserved" : "free";
}

function line(g, cam, points) {
  points.forEach(([x, y], i) => (i ? g.lineTo(...cam.toScreen(x, y)) : g.moveTo(...cam.toScreen(x, y))));
}

/** What lies under the targets. `see` has airport, cam, c, layers, traffic, lights, situation, scan, alerts, selected. */
export function paintPosition(g, see) {
  const { airport, cam, c, layers } = see;
  if (layers.alerts) {
    for (const runway of airport?.runways ?? []) {
      const state = runwayState(runway, { traffic: see.said.traffic, scan: see.scan, ground: see.situation, alerts: see.alerts });
      if (state === "free") continue;
      g.strokeStyle = { reserved: c.departure, occupied: c.select, alert: c.alarm }[state];
      g.lineWidth = state === "reserved" ? 1.5 : 2.5;
      g.beginPath();
      line(g, cam, [...runwayRing(runway, 4), runwayRing(runway, 4)[0]]);
      g.stroke();
    }
    bars(g, see);
    runwayLights(g, see);
    greens(g, see);
  }
  if (layers.routes) routes(g, see);
}

/** Stop bars: lit ones solid, others dotted; one that fails is crossed, whether it stays lit or dark. */
function bars(g, { said, cam, c }) {
  const all = (said.lights?.bars ?? []).map((bar) => ({ ...bar, ends: bar.ends_m.map(([x, y]) => cam.toScreen(x, y)) }));
  for (const lit of [false, true]) {
    g.strokeStyle = lit ? c.bar : c.dim;
    g.lineWidth = lit ? Math.max(2, Math.min(4, 2.5 * cam.scale + 1)) : 1;
    g.setLineDash(lit ? [] : [2, 2]);
    g.beginPath();
    for (const { ends: [a, b] } of all.filter((bar) => bar.lit === lit)) {
      g.moveTo(...a);
      g.lineTo(...b);
    }
    g.stroke();
  }
  g.setLineDash([]);
  g.strokeStyle = c.select;
  g.lineWidth = 1.5;
  g.beginPath();
  for (const { ends: [a, b] } of all.filter((bar) => bar.failed)) {
    const [x, y] = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
    for (const side of [-1, 1]) {
      g.moveTo(x - CROSS_PX, y - side * CROSS_PX);
      g.lineTo(x + CROSS_PX, y + side * CROSS_PX);
    }
  }
  g.stroke();
}

/** Entry lights and take-off hold lights that are lit: red and dotted. */
function runwayLights(g, { said, cam, c }) {
  g.strokeStyle = c.bar;
  g.lineWidth = 2;
  g.setLineDash([2, 3]);
  g.beginPath();
  for (const { ends_m: ends } of [...(said.lights?.entries ?? []), ...(said.lights?.holds ?? [])].filter((light) => light.lit)) line(g, cam, ends);
  g.stroke();
  g.setLineDash([]);
}

/** Lamps of the taxiways that lead flights, and the lit bar where each is led to. */
function greens(g, { said, cam, c }) {
  const led = said.traffic?.greens ?? [];
  g.strokeStyle = c.vehicle;
  g.lineWidth = 2;
  g.setLineDash([3, 4]);
  g.beginPath();
  for (const { lines_m: lines } of led) lines.forEach((ends) => line(g, cam, ends));
  g.stroke();
  g.setLineDash([]);
  g.strokeStyle = c.bar;
  g.beginPath();
  for (const { bar_m: bar } of led) line(g, cam, bar);
  g.stroke();
}

/** Half the cross over a bar that fails, pixels. */
const CROSS_PX = 5;

/** Where the selected one, or the one for whom a clearance is typed, may drive, and where it is to go after that. */
function routes(g, { said, cam, c, scan, selected, previewed }) {
  const target = [...(scan?.tracks ?? []), ...(scan?.truth ?? [])].find((t) => t.id === selected), callsign = previewed ?? target?.callsign;
  const mover = callsign ? said.traffic?.movers.find((m) => m.callsign === callsign) : null;
  if (!mover) return;
  g.lineWidth = 3;
  g.strokeStyle = c.vehicle;
  g.beginPath();
  line(g, cam, mover.authority_m);
  g.stroke();
  g.lineWidth = 1.5;
  g.setLineDash([6, 5]);
  g.strokeStyle = c.select;
  g.beginPath();
  line(g, cam, mover.planned_m);
  g.stroke();
  g.setLineDash([]);
}

/** Over the targets: a frame round each subject, a line between two. Alarms solid, information broken. */
export function paintAlerts(g, { cam, c, scan, alerts, layers }, labels) {
  if (!layers.alerts) return;
  for (const alert of [...alerts].reverse()) {
    const alarm = alert.stage === "alarm", targets = alert.subjects.map((name) => subjectOf(scan, name)).filter(Boolean);
    g.strokeStyle = alarm ? c.alarm : c.information;
    g.lineWidth = alarm ? 2.5 : 1.5;
    g.setLineDash(alarm ? [] : [4, 3]);
    g.beginPath();
    for (const t of targets) {
      const [x, y] = cam.toScreen(t.x, t.y), box = labels?.get(t.id);
      g.rect(x - 11, y - 11, 22, 22);
      if (box) g.rect(box.x - 1.5, box.y - 1.5, box.w + 3, box.h + 3);
    }
    if (targets.length === 2) line(g, cam, targets.map((t) => [t.x, t.y]));
    if (!targets.length) {
      const [x, y] = cam.toScreen(...alert.place_m);
      g.rect(x - 11, y - 11, 22, 22);
    }
    g.stroke();
  }
  g.setLineDash([]);
}
