// Error of the selected target over time, with uPlot.

import { kinds as known } from "./frame.js";
import { fixed } from "./text.js";

export class Curve {
  /** `onTime(scan)` is called when a point of the curve is clicked. */
  constructor(box, onTime) {
    this.box = box;
    this.onTime = onTime;
    this.points = [];
    this.track = null;
    this.shownS = null;
    new ResizeObserver(() => this.#size()).observe(box);
  }

  clear() {
    this.points = [];
    this.track = null;
    this.#draw();
  }

  /** Takes a curve message of the server. */
  add({ track, reset, points }) {
    if (reset || track !== this.track) this.points = [];
    this.track = track;
    this.points.push(...points);
    this.#draw();
  }

  /** Shows what another one has, in the colours of the page. */
  show({ points, track, shownS }, colours) {
    if (colours !== this.colouring) {
      this.colouring = colours;
      this.plot?.destroy();
      this.plot = null;
      this.drawn = -1;
    }
    if (track !== this.track || points.length !== this.drawn) {
      Object.assign(this, { points, track, drawn: points.length });
      this.#draw();
    }
    if (shownS !== this.shownS) this.mark(shownS);
  }

  /** Marks the time that the map shows. */
  mark(seconds) {
    this.shownS = seconds;
    this.plot?.redraw(false, false);
  }

  /** Builds it again with the colours of the style sheet. */
  colours() {
    this.plot?.destroy();
    this.plot = null;
    this.#draw();
  }

  #draw() {
    if (typeof uPlot === "undefined") return;
    const kinds = known.map((k) => k.word).filter((kind) => this.points.some((p) => kind in p.plots_m));
    const column = (read) => this.points.map((p) => {
      const value = read(p);
      return Number.isFinite(value) ? value : null;
    });
    // The line of the track is drawn last, over the dots.
    const data = [column((p) => p.time_s), ...kinds.map((k) => column((p) => p.plots_m[k])), column((p) => p.claimed_m), column((p) => p.error_m)];
    const key = kinds.join();
    if (this.plot && this.key === key) {
      this.plot.setData(data);
      return;
    }
    this.plot?.destroy();
    this.key = key;
    this.plot = new uPlot(this.#options(kinds), data, this.box);
    this.#size(); // the legend is there now, in as many lines as it takes
  }

  #options(kinds) {
    const style = getComputedStyle(document.documentElement);
    const c = (name) => style.getPropertyValue(`--${name}`).trim();
    // Without a pointer on the curve the legend gives the newest figures.
    const value = (u, v, series, index) => {
      const shown = index === null || index === undefined ? u.data[series].findLast((x) => x !== null) : v;
      return shown === null || shown === undefined ? "\u2013" : fixed(shown, 2);
    };
    const axis = { stroke: c("dim"), grid: { stroke: c("line"), width: 1 }, ticks: { stroke: c("line"), width: 1, size: 4 }, font: "10px B612, sans-serif" };
    const clock = (s) => `${Math.floor(s / 60)}:${String(Math.floor(s % 60)).padStart(2, "0")}`;
    return {
      ...this.#measure(),
      padding: [8, 16, 0, 0],
      cursor: { y: false, points: { size: 5 } },
      legend: { live: true },
      scales: { x: { time: false }, y: { range: (_, low, high) => [0, Math.max(1, (high ?? 1) * 1.1)] } },
      axes: [
        { ...axis, size: 24, values: (_, ticks) => ticks.map(clock) },
        { ...axis, size: 34, values: (_, ticks) => ticks.map((t) => `${Number(t.toPrecision(6))}`) },
      ],
      series: [
        { label: "time", value: (_, v) => (v === null || v === undefined ? "" : clock(v)) },
        ...kinds.map((kind) => ({
          label: `${kind} plots`, stroke: c(`plot-${kind}`), paths: () => null, value,
          points: { show: true, size: 3, fill: c(`plot-${kind}`), width: 0 },
        })),
        { label: "claimed \u03c3", stroke: c("text"), width: 1, dash: [4, 4], value, points: { show: false } },
        { label: "track", stroke: c("error"), width: 1.6, value, points: { show: false } },
      ],
      hooks: {
        drawClear: [(u) => this.#drawMark(u, c("select"))],
        ready: [(u) => u.over.addEventListener("click", () => {
          const point = this.points[u.cursor.idx ?? -1];
          if (point) this.onTime(point.scan);
        })],
      },
    };
  }

  #drawMark(u, colour) {
    if (!Number.isFinite(this.shownS) || !this.points.length) return;
    const x = Math.round(u.valToPos(this.shownS, "x", true));
    if (!(x >= u.bbox.left && x <= u.bbox.left + u.bbox.width)) return;
    u.ctx.save();
    u.ctx.strokeStyle = colour;
    u.ctx.lineWidth = 1;
    u.ctx.beginPath();
    u.ctx.moveTo(x + 0.5, u.bbox.top);
    u.ctx.lineTo(x + 0.5, u.bbox.top + u.bbox.height);
    u.ctx.stroke();
    u.ctx.restore();
  }

  #measure(legend = 20) {
    return { width: Math.max(120, this.box.clientWidth), height: Math.max(90, this.box.clientHeight - legend - 4) };
  }

  #size() {
    const { plot } = this;
    plot?.setSize(this.#measure());
    // Once it is as wide as that, the legend takes the lines that it takes.
    if (plot) requestAnimationFrame(() => plot === this.plot && plot.setSize(this.#measure(plot.root.querySelector(".u-legend")?.offsetHeight)));
  }
}
