// Figures and times as people read them.

export const NONE = "\u2013";

export function fixed(value, digits = 1) {
  return Number.isFinite(value) ? value.toFixed(digits) : NONE;
}

/** Seconds since the start as T+ mm:ss or T+ h:mm:ss. */
export function elapsed(seconds) {
  if (!Number.isFinite(seconds)) return "T+ --:--";
  const sign = seconds < 0 ? "\u2212" : "+";
  const s = Math.floor(Math.abs(seconds) + 1e-6);
  const two = (n) => String(n).padStart(2, "0");
  const hours = Math.floor(s / 3600);
  const rest = `${two(Math.floor(s / 60) % 60)}:${two(s % 60)}`;
  return `T${sign} ${hours ? `${hours}:` : ""}${rest}`;
}

/** UTC of `seconds` after `startNs` (decimal text), as hh:mm:ss. */
export function utc(startNs, seconds) {
  const ms = Number(BigInt(startNs || "0") / 1000000n) + seconds * 1000;
  const date = new Date(ms);
  return Number.isNaN(date.getTime()) ? "--:--:--" : date.toISOString().slice(11, 19);
}

export function bytes(n) {
  if (!Number.isFinite(n)) return NONE;
  return n < 1e6 ? `${(n / 1e3).toFixed(0)} kB` : `${(n / 1e6).toFixed(0)} MB`;
}

/** A point of the map, metres from the airport's reference point. */
export function place(east, north) {
  const metres = (value, to, from) => `${fixed(Math.abs(value), 0)} m ${value < 0 ? from : to}`;
  return Number.isFinite(east + north) ? `${metres(east, "E", "W")}  ${metres(north, "N", "S")}` : NONE;
}

export function visibility(m) {
  if (!Number.isFinite(m) || m === null || m >= 10000) return "clear";
  return m >= 5000 ? `${(m / 1000).toFixed(0)} km` : `${m.toFixed(0)} m`;
}

/** Where the wind comes from and how fast, from the vector it blows to. */
export function wind([east, north]) {
  const speed = Math.hypot(east, north);
  if (!(speed >= 0.25)) return "calm";
  const from = ((Math.atan2(-east, -north) * 180) / Math.PI + 360) % 360;
  return `${String(Math.round(from / 10) * 10 || 360).padStart(3, "0")}\u00b0 ${(speed * 1.943844).toFixed(0)} kt`;
}

/** An element with text; text is never read as markup. */
export function element(tag, content, attributes = {}) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined) made.setAttribute(name, value);
  }
  for (const part of Array.isArray(content) ? content : [content]) {
    if (part !== undefined && part !== null) made.append(part);
  }
  return made;
}
