// The one hook for tests and tools: getters only, values are frozen copies.

import { stagesOf } from "./alerts.js";
import { SHORT_LEADER } from "./labels.js";

const copy = (value) => Object.freeze(JSON.parse(JSON.stringify(value ?? null)));

/** A label as tests read it: its box in pixels of the map, the leader from the symbol to the box (null: too short to be drawn), whether a runway lies under it. */
export function labelSaid([id, { x, y, w, h, level, ax, ay, runway, sx, sy }]) {
  const leader = Math.hypot(ax - sx, ay - sy) < SHORT_LEADER ? null : [[sx, sy], [ax, ay]];
  return { id, level, box: { x, y, w, h }, leader, on_runway: runway > 0 };
}

/** What a track does, the stage of its alert (0 to 2), the kind it was cleared for last: as said now, else as its scan has it. */
export function besideOf(track, { situation, alerted, traffic }) {
  const mover = track.callsign && !track.assumed ? traffic?.movers.find((m) => m.callsign === track.callsign) : null;
  return { state: mover?.phase ?? (track.doing || (situation?.stateOf(track) ?? "")), alert: alerted ? { information: 1, alarm: 2 }[alerted.get(track.id)] ?? 0 : track.alertStage ?? 0, clearance: mover?.cleared?.at(-1)?.kind ?? track.cleared ?? "" };
}

/** Puts `window.__viewer` there; `page` has the state and the parts. */
export function expose({ state, map, line, curve, alerts, panes, insets, address, whatIf }) {
  const drawn = (item) => {
    const [x, y] = map.toScreen(item.x, item.y);
    return { ...item, truth: undefined, screen: { x, y } };
  };
  const getters = {
    version: () => 1,
    connection: () => state.link,
    phase: () => state.runState?.phase ?? null,
    runState: () => copy(state.runState),
    scene: () => copy(state.run),
    scan: () => state.scan?.scan ?? null,
    timeS: () => state.scan?.timeS ?? null,
    live: () => state.live,
    timeline: () => copy(state.timeline),
    tracks: () => copy((state.scan?.tracks ?? []).map((t) => ({ ...drawn(t), ...besideOf(t, { situation: map.situation, alerted: stagesOf(state.scan, alerts.open), traffic: state.traffic }) }))),
    truth: () => copy((state.scan?.truth ?? []).map(drawn)),
    plots: () => copy((state.scan?.plots ?? []).map((p) => ({ ...drawn(p), shown: !map.sensorsOff.has(p.sensor) }))),
    labels: () => copy([...map.labels].map(labelSaid)),
    labelsHidden: () => map.hidden.length,
    state: () => address.text(),
    longest_task_ms: () => map.longestMs,
    runs: () => copy(state.runs),
    shownRuns: () => copy(state.shownRuns),
    compared: () => copy({ mode: map.compared?.mode, text: map.compared?.seen.text, cells: map.compared?.seen.cells.size }),
    others: () => copy([...map.others].map(([run, scan]) => ({ run, timeS: scan.timeS, tracks: scan.tracks.length }))),
    strip: () => copy(line.strip),
    events: () => copy(line.events),
    busy: () => map.busy || Boolean(state.listing),
    selected: () => state.selected,
    layers: () => copy({ ...map.layers, sensorsOff: [...map.sensorsOff] }),
    view: () => copy({ cx: map.view.cx, cy: map.view.cy, scale: map.view.scale, rot: map.view.rot, width: map.width, height: map.height, follow: map.follow }),
    colours: () => document.documentElement.dataset.colours,
    panes: () => copy(panes.names),
    fork: () => copy(whatIf.state),
    insets: () => copy(insets.list.map(({ number, cam, placed }) => ({ number, cx: cam.cx, cy: cam.cy, scale: cam.scale, rot: cam.rot, width: cam.width, height: cam.height, labels: [...(placed ?? [])].map(([id]) => id) }))),
    videos: () => copy(panes.list.filter((p) => p.video?.turn).map(({ sensor, video: { turn, sweep } }) => ({ sensor, scan: turn.scan, beams: turn.beams, ranges: turn.ranges, sweep }))),
    rungs: () => copy(state.rungs),
    curve: () => copy(curve.points),
    weather: () => copy(state.weather),
    detection: () => { const at = map.detection.picture; return at ? { width: at.image.width, height: at.image.height, west: at.west, north: at.north, step: at.step } : null; },
    flights: () => copy(state.flights),
    alerts: () => copy(alerts.open),
    strips: () => copy(state.strips),
    driven: () => copy(state.driven),
    said: () => copy({ traffic: state.traffic, lights: map.said.lights }),
    federates: () => copy(state.federates),
    operations: () => copy(state.operations),
    answer: () => copy(state.answer),
    frames: () => map.drawn ?? 0,
  };
  const hook = Object.defineProperties({}, Object.fromEntries(Object.entries(getters).map(([name, get]) => [name, { get, enumerable: true }])));
  Object.defineProperty(window, "__viewer", { value: Object.freeze(hook) });
}
