// What moment is shown, and how it goes on: live, looked back at, played, in a loop; the time line and what is typed of it.

import { nextEvent, typedTime } from "./time.js";
import { elapsed, utc } from "./text.js";

const byId = (id) => document.getElementById(id);
/** An answer that nothing follows for so long is the one to what was asked last. */
const SETTLED_MS = 300;

/** The moment of a page: `changed()` when the address follows, `shown()` when clock and weather do. */
export function playback({ state, map, link, line, changed, shown, say: showAnswer }) {
  let stripAsked = -Infinity, awaited = false, missing = 0;

  /** Whether the run shown no longer goes on: nothing can be commanded, and its end is not "now". */
  function finished() {
    return state.timeline?.live === false;
  }

  function showScan(scan) {
    const { first, last } = state.timeline ?? {};
    if (first === undefined) return;
    const wanted = Math.min(last, Math.max(first, Math.round(scan)));
    state.live = false;
    state.asked = wanted;
    clearTimeout(missing);
    awaited = true; // also without a connection: the next one begins with what was asked for
    link.send({ type: "show", scan: wanted });
    showTimeline(wanted);
  }

  /** A scan came. Where the one asked for was lost it is the one before, and that is said. */
  function came() {
    awaited = false;
    clearTimeout(missing);
    const { asked, live, scan } = state;
    if (live || !Number.isFinite(asked) || !scan || scan.scan === asked) return;
    // The answer to what was asked last may be on its way.
    missing = setTimeout(() => showAnswer({ accepted: false, text: `there is no scan ${asked}: this is scan ${scan.scan}` }), SETTLED_MS);
  }

  /** The next scan, or the one before: after the one asked for, so that those that were lost are passed. */
  function step(by) {
    const shown = state.scan?.scan ?? 0, asked = (!state.live && state.asked) || shown;
    showScan(by > 0 ? Math.max(asked, shown) + by : Math.min(asked, shown) + by);
  }

  /** A time in seconds instead of a scan; beyond the ends of what there is, the nearest end, and said. */
  function showTime(seconds) {
    const { first, last, first_s: from, last_s: to } = state.timeline ?? {};
    if (first === undefined) return;
    if (seconds < from - 0.5 || seconds > to + 0.5) showAnswer({ accepted: false, text: `${elapsed(seconds)} is outside ${elapsed(from)} to ${elapsed(to)}` });
    showScan(to > from ? Math.floor(first + ((Math.min(to, Math.max(from, seconds)) - from) / (to - from)) * (last - first) + 1e-6) : first);
  }

  function setLive(live) {
    state.live = live;
    state.asked = null;
    setPlaying(false);
    if (live) link.send({ type: "show", scan: null });
    showTimeline();
  }

  let playTimer = 0;
  function setPlaying(on) {
    state.playing = on;
    clearInterval(playTimer);
    if (on) {
      if (state.live) showScan(state.timeline?.first ?? 0);
      const rate = state.runState?.rate ?? 1;
      const every = Math.max(60, (1000 * (state.run?.scan_s || 1)) / Math.min(10, Math.max(0.2, rate || 1)));
      playTimer = setInterval(() => {
        const { loop, scan } = state;
        if (loop && scan && (scan.timeS >= loop[1] || scan.timeS < loop[0])) showTime(loop[0]);
        else if (!scan || scan.newest) finished() ? setPlaying(false) : setLive(true);
        else if (!awaited) step(1);
      }, every);
    }
    byId("timeline").querySelector("[data-time=play]").setAttribute("aria-pressed", String(on));
  }

  function showTimeline(wanted) {
    map.live = state.live && !finished();
    const strip = line;
    showTimes(state.timeline, byId("scrub"), strip, wanted);
  }

  function showTimes(line, scrub, strip, wanted) {
    if (line) {
      scrub.min = line.first;
      scrub.max = line.last;
      scrub.value = wanted ?? (state.live ? line.last : state.scan?.scan ?? line.last);
      const shown = wanted ?? (state.live ? line.last : state.scan?.scan ?? line.last);
      const timeS = line.last > line.first ? line.first_s + ((shown - line.first) / (line.last - line.first)) * (line.last_s - line.first_s) : line.first_s;
      strip.show({ firstS: line.first_s, lastS: line.last_s, timeS, loop: state.loop, notices: state.notices ?? [] });
      scrub.setAttribute("aria-valuetext", strip.textAt(state.scan?.timeS ?? timeS).replaceAll("\n", ", "));
    }
    changed();
    byId("timeline").querySelector("[data-time=live]").setAttribute("aria-pressed", String(state.live));
    byId("timeline").querySelector("[data-time=live]").textContent = finished() ? "End" : "Live";
    document.body.classList.toggle("past", !state.live && !finished());
    document.body.classList.toggle("finished", finished());
    const past = byId("past");
    past.hidden = state.live || finished();
    if (!past.hidden && state.scan) {
      const behind = (line?.last_s ?? state.scan.timeS) - state.scan.timeS;
      past.textContent = `PAST  ${elapsed(state.scan.timeS)}  (${elapsed(behind).slice(3)} before now)`;
    }
    shown();
  }

  /** The time line's columns and events: once for what is finished, every two seconds for what grows. */
  function askStrip(force = false) {
    const { first_s: from, last_s: to } = state.timeline ?? {}, now = performance.now();
    if (from === undefined || (!force && now - stripAsked < 2000)) return;
    if (link.send({ type: "strip", from_s: from, to_s: Math.max(to, from + 1), columns: Math.max(1, Math.min(2000, line.width - 16, state.timeline.last - state.timeline.first + 1)) })) stripAsked = now;
  }

  function toEvent(step) {
    const t = nextEvent(line.events, state.scan?.timeS ?? 0, step, line.wanted);
    if (t === null) showAnswer({ accepted: false, text: step > 0 ? "no later event of these kinds" : "no earlier event of these kinds" });
    else showTime(t);
  }

  /** Start or end of the loop at the time shown; the two change places where they must. */
  function setLoop(end) {
    const now = state.scan?.timeS ?? 0, loop = state.loop ?? [now, now];
    loop[end] = now;
    state.loop = loop.sort((a, b) => a - b);
    showTimeline();
  }

  function askTime() {
    byId("go").showModal();
    byId("go-time").select();
  }

  function goTo(text) {
    const of = utc(state.run?.start_utc_ns, 0).split(":").map(Number), startS = of[0] * 3600 + of[1] * 60 + of[2];
    const seconds = typedTime(text, startS);
    if (seconds === null) showAnswer({ accepted: false, text: `"${text.slice(0, 20)}" is not a time: 215, 3:35 or 09:03:35Z` });
    else {
      setPlaying(false);
      showTime(seconds);
    }
  }

  /** A time out of the address is shown as soon as there is one. */
  function grantTime() {
    const { wish } = state;
    if (wish.t === undefined || !state.timeline) return;
    if (wish.t === "live") setLive(true);
    else showTime(wish.t);
    if (wish.play) setPlaying(true);
    delete wish.t;
  }

  const times = {
    back: () => step(-1), forth: () => step(1),
    play: () => setPlaying(!state.playing), live: () => setLive(true),
  };

  /** The columns are asked for again: other runs are shown. */
  const forgetStrip = () => (stripAsked = -Infinity);
  return { showScan, came, showTime, setLive, setPlaying, showTimeline, finished, askStrip, forgetStrip, toEvent, setLoop, askTime, goTo, grantTime, times };
}
