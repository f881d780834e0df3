// The switches over the map: layers, the plots of each sensor, panes.

import { LAYERS } from "./map.js";
import { element } from "./text.js";
import { plotMark } from "./traffic.js";

const byId = (id) => document.getElementById(id);
/** Panes that are no sensor's: name in the address, title. */
const MORE_PANES = [["tracks", "Tracks alone"], ["eye:tower", "Eye"], ["curve", "Error curve"], ["strips", "Strips"], ["dial", "All filters"]];

/** `page` has state, map, panes, changed() and say({accepted, text}). */
export function switches({ state, map, panes, changed: addressChanged, say: showAnswer }) {
  function makeLayers() {
    const list = byId("layer-list");
    LAYERS.forEach(([key, title], i) => {
      const box = element("input", [], { type: "checkbox", id: `layer-${key}` });
      box.checked = map.layers[key];
      box.addEventListener("change", () => setLayer(key, box.checked));
      const hint = i < 9 ? `${title} (${i + 1})` : title;
      list.append(element("label", [box, title], { for: box.id, title: hint }));
    });
    list.append(element("div", [], { id: "sensor-layers" }), ...MORE_PANES.map(([pane, title]) => element("div", [element("span", title), paneButton(pane, title)], { class: "sensor" })));
    const narrow = matchMedia("(max-width: 900px)");
    const fold = () => (byId("layers").open = !narrow.matches);
    narrow.addEventListener("change", fold);
    fold();
  }

  function setLayer(key, on) {
    map.layers[key] = on;
    byId(`layer-${key}`).checked = on;
    if (key === "video") panes.videoChanged();
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
      const name = sensor.name || `${sensor.kind} ${id}`;
      box.append(element("div", [element("label", [input, mark, name], { for: input.id, title: `Plots of ${name} (${sensor.kind})` }), paneButton(`sensor:${id}`, name)], { class: "sensor" }));
    }
  }

  /** A button that opens and closes a pane. */
  function paneButton(pane, name) {
    const button = element("button", "\u25a3", { type: "button", "data-pane-of": pane, "aria-pressed": String(panes.has(pane)), title: `A pane of its own: ${name}`, "aria-label": `Pane ${name}` });
    button.addEventListener("click", () => {
      if (!panes.toggle(pane)) showAnswer({ accepted: false, text: "three panes at most: close one" });
    });
    return button;
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

  return { makeLayers, setLayer, makeSensorLayers, drawMark };
}
