// The one hook for tests and tools: getters only, values are frozen copies.

const copy = (value) => Object.freeze(JSON.parse(JSON.stringify(value ?? null)));

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
