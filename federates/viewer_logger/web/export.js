// What can be taken away: the picture of the map, tables and curves as CSV or JSON. Pure but for `save`.

/** Rows of a table as CSV: numbers with a point, texts quoted where they must be, nothing that a spreadsheet takes for a formula. */
export function csv(names, rows) {
  const cell = (value) => {
    if (value === null || value === undefined || Number.isNaN(value)) return "";
    if (typeof value === "number" || typeof value === "boolean") return String(value);
    const text = /^[=+\-@\t\r]/.test(value) ? `'${value}` : String(value);
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return `${[names, ...rows].map((row) => row.map(cell).join(",")).join("\r\n")}\r\n`;
}

/** Rows as JSON objects. */
export function json(names, rows) {
  return `${JSON.stringify(rows.map((row) => Object.fromEntries(names.map((n, i) => [n, row[i] ?? null]))), null, 1)}\n`;
}

/** Targets of a scan: what the table shows, in SI units. */
export function targetRows(scan) {
  const names = ["time_s", "track", "callsign", "type", "status", "x_m", "y_m", "vx_mps", "vy_mps", "altitude_m", "error_m"];
  const list = scan ? [...scan.tracks, ...scan.truth.filter((t) => t.track === null)] : [];
  return [names, list.map((t) => [scan.timeS, t.number ?? null, t.callsign, t.designator, t.status ?? "no track", t.x, t.y, t.vx, t.vy, t.altitudeM, t.errorM ?? null])];
}

/** An error curve: one row a scan, one column a kind of plot. */
export function curveRows(points) {
  const kinds = [...new Set(points.flatMap((p) => Object.keys(p.plots_m)))].sort();
  return [["scan", "time_s", "error_m", "claimed_m", ...kinds.map((k) => `plots_${k}_m`)],
    points.map((p) => [p.scan, p.time_s, p.error_m, p.claimed_m, ...kinds.map((k) => p.plots_m[k] ?? null)])];
}

/** The rows of an HTML table as they are shown. */
export function shownRows(table) {
  const names = [...table.querySelectorAll("thead th")].map((th) => th.textContent.trim());
  return [names, [...table.querySelectorAll("tbody tr")].map((tr) => [...tr.cells].map((td) => td.textContent.trim()))];
}

/** The picture of the map with a line below that says what it is. */
export function picture(canvas, title, scale = 1) {
  const out = document.createElement("canvas"), ratio = window.devicePixelRatio || 1, line = 26 * scale * ratio;
  out.width = canvas.width * scale;
  out.height = canvas.height * scale + line;
  const g = out.getContext("2d"), style = getComputedStyle(document.documentElement);
  g.fillStyle = style.getPropertyValue("--panel");
  g.fillRect(0, 0, out.width, out.height);
  g.drawImage(canvas, 0, 0, canvas.width * scale, canvas.height * scale);
  g.fillStyle = style.getPropertyValue("--text");
  g.font = `${12 * scale * ratio}px B612, sans-serif`;
  g.textBaseline = "middle";
  g.fillText(title, 10 * scale * ratio, out.height - line / 2);
  return new Promise((done) => out.toBlob(done, "image/png"));
}

export function save(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
