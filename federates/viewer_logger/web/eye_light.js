// Light through air: what the eye sees of an object, of a lamp, and how far. Pure functions; luminances in units of the horizon's.

/** Extinction, 1/m, of a visibility (meteorological optical range, m; null or infinite: clear) and rain (mm/h). */
export function extinction(visibilityM, rain = 0) {
  const fog = Number.isFinite(visibilityM) && visibilityM !== null ? 2.9957 / Math.max(1, visibilityM) : 0;
  return fog + 0.248e-3 * Math.max(0, rain) ** 0.67;
}

/** Luminance of an object of luminance L0 before a horizon of 1, at a distance from the eye (Koschmieder). */
export function through(l0, beta, distanceM) {
  const t = Math.exp(-beta * distanceM);
  return l0 * t + 1 - t;
}

/** Contrast to another object at the same distance, `background` its luminance without air (Duntley). */
export function contrastTo(object, background, beta, distanceM) {
  return (object / background - 1) / (1 + (1 / background) * (Math.exp(beta * distanceM) - 1));
}

/** Threshold of illuminance at the eye, lx, before a background of so many cd/m². */
export function threshold(backgroundCdM2) {
  const lg = Math.log10(backgroundCdM2);
  return 10 ** (-6.66 + 0.57 * lg + 0.05 * lg * lg);
}

/** Illuminance of a lamp at the eye, lx (Allard); nearer than 5 m counts as 5. */
export function illuminance(intensityCd, beta, distanceM) {
  const d = Math.max(5, distanceM);
  return (intensityCd * Math.exp(-beta * d)) / (d * d);
}

/** How far a lamp is seen, m: where its illuminance falls to the threshold. */
export function lampRange(intensityCd, beta, thresholdLx) {
  let low = 0, high = 1;
  const above = (d) => (intensityCd * Math.exp(-beta * d)) / (d * d) >= thresholdLx;
  while (above(high) && high < 1e7) high *= 2;
  for (let i = 0; i < 80; i++) {
    const middle = (low + high) / 2;
    if (above(middle)) low = middle;
    else high = middle;
  }
  return low;
}

/** The 5 % range of contrast, m: beyond it nothing without a light of its own is seen. */
export function sightM(beta) {
  return beta > 0 ? Math.log(20) / beta : Infinity;
}

/** Runway visual range as it is reported: the larger of the lamps' range and the 5 % range, in steps, from 50 to 2 000 m. */
export function rvr(beta, backgroundCdM2, lampCd = 10_000) {
  const range = Math.max(lampRange(lampCd, beta, threshold(backgroundCdM2)), sightM(beta));
  if (range >= 2000) return 2000;
  const step = range < 400 ? 25 : range < 800 ? 50 : 100;
  return Math.max(50, Math.floor(range / step) * step);
}

/** Elevation of the sun, degrees, within a degree: UTC in ms since 1970, place in degrees. */
export function sunElevation(utcMs, latDeg, lonDeg) {
  const rad = Math.PI / 180, days = utcMs / 86_400_000 - 10_957.5; // since J2000.0
  const mean = (357.528 + 0.9856003 * days) * rad, longitude = (280.46 + 0.9856474 * days + 1.915 * Math.sin(mean) + 0.02 * Math.sin(2 * mean)) * rad;
  const tilt = 23.439 * rad, declination = Math.asin(Math.sin(tilt) * Math.sin(longitude));
  const ascension = Math.atan2(Math.cos(tilt) * Math.sin(longitude), Math.cos(longitude));
  const sidereal = (280.46062 + 360.98564737 * days + lonDeg) * rad, hour = sidereal - ascension;
  return Math.asin(Math.sin(latDeg * rad) * Math.sin(declination) + Math.cos(latDeg * rad) * Math.cos(declination) * Math.cos(hour)) / rad;
}

/** Background luminance, cd/m², by the sun: day, dull, dusk, night. */
export function backgroundOf(elevationDeg) {
  const table = [[-12, 0], [-6, 0.5], [-3, 1.5], [0, 2.5], [5, 3.3], [15, 4]]; // lg cd/m²
  if (!(elevationDeg > -12)) return 1;
  const at = table.findIndex(([e]) => e >= elevationDeg);
  if (at < 0) return 10_000;
  const [[e0, l0], [e1, l1]] = [table[at - 1] ?? table[0], table[at]];
  return 10 ** (e1 === e0 ? l0 : l0 + ((elevationDeg - e0) / (e1 - e0)) * (l1 - l0));
}

/** Extinction, 1/m, on the line from an eye to a place, [east, north, …] m: in the rain that falls halfway. */
export function extinctionTo(weather, eye, to) {
  return extinction(weather?.visibility_m, rainAt(weather, 0.5 * (eye[0] + to[0]), 0.5 * (eye[1] + to[1])));
}

/** Rain, mm/h, at a place: the heaviest cell there, else what falls everywhere. */
export function rainAt(weather, x, y) {
  const cells = (weather?.cells ?? []).filter(([cx, cy, r]) => Math.hypot(x - cx, y - cy) <= r).map((c) => c[3]);
  return Math.max(weather?.rain_mm_per_h ?? 0, ...cells);
}
