// The head of the page: clock, state of the run, rate, connection, weather; and the sentence that says what is wrong.

import { backgroundOf, extinction, rvr, sunElevation } from "./eye_light.js";
import { element, elapsed, fixed, utc, visibility, wind } from "./text.js";

const byId = (id) => document.getElementById(id);

/** What shows the head of a page with this state, map and curve; `finished()`: whether the run no longer goes on. */
export function head({ state, map, curve, finished }) {
  function showClock() {
    const seconds = state.live && !finished() ? state.runState ? frameTime() ?? state.scan?.timeS : state.scan?.timeS : state.scan?.timeS;
    byId("utc").textContent = Number.isFinite(seconds) && state.run ? utc(state.run.start_utc_ns, seconds) : "--:--:--";
    byId("elapsed").textContent = elapsed(seconds);
    curve.mark(state.live ? null : state.scan?.timeS);
  }

  function frameTime() {
    const { frame, step_ns: step } = state.runState ?? {};
    return Number.isFinite(frame * step) ? (frame * step) / 1e9 : null;
  }

  function showState() {
    const s = state.runState, pill = byId("phase");
    pill.textContent = s.phase;
    pill.dataset.phase = s.phase;
    const asked = s.rate === null ? "fast" : `${s.rate}\u00d7`;
    const achieved = `${fixed(s.achieved_rate, s.achieved_rate < 10 ? 1 : 0)}\u00d7`;
    byId("rate").textContent = s.phase !== "RUNNING" ? asked : s.rate === null ? `fast: ${achieved}` : `${achieved} of ${asked}`;
    const can = {
      start: ["CONFIGURED", "FROZEN"], freeze: ["RUNNING"], step: ["CONFIGURED", "FROZEN"],
      stop: ["CONFIGURED", "RUNNING", "FROZEN"], restart: ["FROZEN", "STOPPED"],
    };
    for (const button of byId("controls").querySelectorAll("button")) {
      // A button that will be refused is dimmed, not dead: the reason why not is an answer, too.
      button.classList.toggle("unlikely", !can[button.dataset.command]?.includes(s.phase));
    }
    byId("controls").querySelector("[data-command=start]").textContent = s.phase === "FROZEN" ? "Resume" : "Start";
    const choice = s.rate === null ? "fast" : String(s.rate);
    const select = byId("rate-ask");
    if (document.activeElement !== select) {
      if (![...select.options].some((o) => o.value === choice)) select.append(element("option", choice, { value: choice }));
      select.value = choice;
    }
    showClock();
    showLink();
  }

  function showLink() {
    const pill = byId("link"), alert = byId("alert");
    const words = { open: "live", connecting: "connecting", silent: "silent", lost: "disconnected" };
    pill.textContent = state.link === "open" && (!state.live || finished()) ? "connected" : words[state.link];
    pill.dataset.link = state.link;
    document.body.classList.toggle("stale", state.link === "lost" || state.link === "silent");
    const at = state.lostAt?.toTimeString().slice(0, 8) ?? "";
    const reasons = state.runState?.reasons ?? [];
    let text = "", level = "bad";
    if (state.link === "lost") {
      text = state.scan ? `Connection to the viewer lost at ${at}. The picture is of ${elapsed(state.scan.timeS)} and is not renewed. Trying again \u2026`
        : "No connection to the viewer. Trying again \u2026";
    } else if (state.link === "silent") text = `Nothing heard from the viewer since ${at}; the picture may be old.`;
    else if (state.notice) text = state.notice;
    else if (reasons.length) [text, level] = [`${state.runState.phase}: ${reasons.join("; ")}`, "warn"];
    else if (lateScans()) [text, level] = [`No tracks since ${elapsed(state.scan?.timeS ?? 0)}: the SMDFM is behind or its messages are lost.`, "warn"];
    alert.hidden = !text;
    if (alert.textContent !== text) alert.textContent = text;
    alert.dataset.level = level;
  }

  /** Whether the run goes on while scans stay away. */
  function lateScans() {
    const now = frameTime();
    if (state.runState?.phase !== "RUNNING" || now === null || !state.timeline) return false;
    const slack = Math.max(4 * (state.run?.scan_s || 1), 3 * (state.runState.achieved_rate || 1));
    return now - state.timeline.last_s > slack;
  }

  /** The weather at the time of the picture. */
  function showWeather() {
    const now = state.live ? Infinity : (state.scan?.timeS ?? 0) * 1e9;
    const w = (state.notices ?? []).findLast((n) => n.from_ns <= now) ?? null;
    if (w === state.weather) return;
    state.weather = map.weather = w;
    map.need(map.layers.detection ? "ground" : "traffic", "traffic");
    if (!w) {
      byId("weather").replaceChildren();
      return;
    }
    const rain = w.rain_mm_per_h > 0 ? `rain ${fixed(w.rain_mm_per_h, w.rain_mm_per_h < 10 ? 1 : 0)} mm/h` : "dry";
    const parts = [
      [w.rain_mm_per_h > 0 || w.cells.length ? "wet" : "", w.cells.length ? `${rain}, ${w.cells.length} cell${w.cells.length > 1 ? "s" : ""}` : rain],
      ["", `vis ${visibility(w.visibility_m)}`], ["", wind(w.wind_mps)], ["", `${fixed(w.temperature_k - 273.15, 0)} \u00b0C`],
      ["", `QFE ${fixed(w.pressure_hpa, 0)}`],
      ...(runwayRange(w) < 2000 ? [["", `RVR ${runwayRange(w)} m`]] : []),
      ...(w.film_mm > 0 ? [["", `film ${fixed(w.film_mm, 1)} mm`]] : []),
    ];
    byId("weather").replaceChildren(...parts.map(([mark, text]) => element("span", text, { "data-mark": mark })));
    byId("weather").title = `Since ${elapsed(w.from_ns / 1e9)}; ${fixed(w.pressure_hpa, 0)} hPa, vapour ${fixed(w.vapour_g_per_m3, 1)} g/m\u00b3`;
  }

  /** Runway visual range, m: of the edge lights and of contrast, by the light of the hour, as it would be reported. */
  function runwayRange(w) {
    const { run, airport, scan } = state, [lat, lon] = airport?.reference_deg ?? [0, 0];
    const utcMs = Number(BigInt(run?.start_utc_ns || "0") / 1_000_000n) + (scan?.timeS ?? 0) * 1000;
    return rvr(extinction(w.visibility_m, w.rain_mm_per_h), backgroundOf(sunElevation(utcMs, lat, lon)));
  }

  return { showClock, showState, showLink, showWeather };
}
