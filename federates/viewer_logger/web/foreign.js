// Tracks of somebody else's tracker, as they came last: an open diamond (coasting: broken), a line to where it will be in five seconds, and who
// says it: call sign, else its number, with its source.

/** A report further from the scan that is shown is of another time, s. */
const NEAR_S = 5;
const HALF = 6;
const AHEAD_S = 5;

/** Those of about the time of the scan. */
export function foreignAt(foreign, scan) {
  return scan ? foreign.filter((t) => Math.abs(t.time_s - scan.timeS) <= NEAR_S) : [];
}

/** `see` has cam, c, scan, layers and foreign. */
export function paintForeign(g, { cam, c, scan, layers, foreign }) {
  if (!layers.foreign) return;
  g.strokeStyle = c["plot-other"];
  g.fillStyle = c["plot-other"];
  g.lineWidth = 1.5;
  for (const t of foreignAt(foreign, scan)) {
    const [x, y] = cam.toScreen(t.x_m, t.y_m);
    g.setLineDash(t.coasting ? [2, 2] : []);
    g.beginPath();
    g.moveTo(x, y - HALF);
    g.lineTo(x + HALF, y);
    g.lineTo(x, y + HALF);
    g.lineTo(x - HALF, y);
    g.lineTo(x, y - HALF);
    if (t.vx_ms !== undefined) {
      g.moveTo(x, y);
      g.lineTo(...cam.toScreen(t.x_m + AHEAD_S * t.vx_ms, t.y_m + AHEAD_S * t.vy_ms));
    }
    g.stroke();
    if (layers.labels) g.fillText(`${t.callsign || t.track} ${t.source}`, x + HALF + 3, y + HALF + 8);
  }
  g.setLineDash([]);
}
