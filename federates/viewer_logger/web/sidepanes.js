// Panes that show no sensor: the eye's view, the error curve, strips, the dial. Each has name, box, take(scan), draw() and close().

import { Curve } from "./curve.js";
import { errorOf } from "./dial.js";
import { scatter } from "./scatter.js";
import { element, fixed } from "./text.js";

class SidePane {
  constructor(name, title, close) {
    Object.assign(this, { name, title, told: element("span", "") });
    const closer = element("button", "\u00d7", { type: "button", title: "Close this pane", "aria-label": `Close the pane ${title}` });
    closer.addEventListener("click", () => close(name));
    this.body = element("div", [], { class: "side-body" });
    this.box = element("section", [element("header", [element("h2", title), this.told, closer]), this.body], { class: "pane", "data-pane": name });
  }

  take() {}
  draw() {}
  askVideo() {}
  close() {}
}

/** The view out of a window, in a frame of its own, on the clock of this page. */
class EyePane extends SidePane {
  constructor(name, page) {
    const [, eye, of] = /^eye:([a-z]+)(?::(.+))?$/u.exec(name);
    super(name, `Eye: ${eye}${of ? ` ${of}` : ""}`, page.close);
    Object.assign(this, { page, eye: `eye=${eye}${of ? `:${encodeURIComponent(of)}` : ""}` });
    this.frame = element("iframe", [], { title: this.title, src: `eye#${this.#address()}` });
    this.body.append(this.frame);
  }

  #address() {
    const { state } = this.page, run = state.shownRuns[0];
    return [this.eye, run && run !== state.runs[0]?.id ? `run=${encodeURIComponent(run)}` : "", `t=${state.live ? "live" : state.scan?.timeS ?? "live"}`].filter(Boolean).join("&");
  }

  /** Looked back at, the eye goes with the map; live both follow the run. */
  take() {
    const now = this.#address(), view = this.frame.contentWindow;
    if (now === this.asked || !view) return;
    this.asked = now;
    view.location.replace(`${view.location.pathname === "blank" ? "/eye" : view.location.href.split("#")[0]}#${now}`);
  }
}

/** The error curve of the selected target, as large as the pane. */
class CurvePane extends SidePane {
  constructor(name, page) {
    super(name, "Error of the selected target", page.close);
    Object.assign(this, { page, plot: element("div", [], { class: "curve-pane", role: "img", "aria-label": "Error of the selected target over time" }) });
    this.body.append(this.plot);
    this.curve = new Curve(this.plot, page.onTime);
  }

  take() {
    this.draw();
  }

  draw() {
    const { curve, state } = this.page;
    this.told.textContent = state.callsign ?? (curve.track === null ? "nothing is selected" : `track ${curve.track}`);
    this.curve.show(curve, document.documentElement.dataset.colours);
  }
}

class StripsPane extends SidePane {
  constructor(name, page) {
    super(name, "Strips", page.close);
    this.list = element("div", [], { class: "strips" });
    this.body.tabIndex = 0;
    this.body.append(this.list);
    this.panel = page.addStrips(this.list);
    Object.assign(this, { page });
  }

  close() {
    this.page.dropStrips(this.panel);
  }
}

/** Error over cost of all filters, and which one the run has. */
class DialPane extends SidePane {
  constructor(name, page) {
    super(name, "All filters: error over cost", page.close);
    this.canvas = element("canvas", [], { role: "img", "aria-label": "Error over cost of every filter; the tab Filter lists the same" });
    this.ask = element("button", "Compare all filters", { type: "button" });
    this.ask.addEventListener("click", () => page.send({ type: "compare", on: true, ghost: null }));
    this.body.append(this.ask, this.canvas);
    Object.assign(this, { page });
    new ResizeObserver(() => this.draw()).observe(this.body);
  }

  take() {
    this.draw();
  }

  draw() {
    const { rungs } = this.page.state, rows = rungs?.rows ?? [], own = rows.find((r) => r.chosen);
    this.ask.hidden = Boolean(rungs?.comparing);
    this.told.textContent = own ? `${own.rung}: ${fixed(errorOf(own), 2)} m at ${fixed(own.us_per_track, 2)} \u00b5s a track` : "";
    scatter(this.canvas, rows.map((r) => ({ name: r.rung, cost: r.us_per_track, error: errorOf(r), own: r.chosen, ghost: r.ghost ?? false })), "\u00b5s a track");
  }
}

/** A maker for each kind; `page` has state, curve, onTime(scan), addStrips(box), dropStrips(panel), send(message) and close(name). */
export const sidePanes = (page) => ({
  eye: (name) => new EyePane(name, page), curve: (name) => new CurvePane(name, page), strips: (name) => new StripsPane(name, page), dial: (name) => new DialPane(name, page),
});
