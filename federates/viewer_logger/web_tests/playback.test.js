// Stepping and playing a run that has lost scans.
import assert from "node:assert/strict";
import { test } from "node:test";
import { playback } from "../web/playback.js";

/** A page on a run of these scans that was finished: what it asks for is answered by the newest that is not later. */
function pageOn(scans) {
  const node = { setAttribute() {}, querySelector: () => node, classList: { toggle() {} }, textContent: "" };
  globalThis.document = { getElementById: () => node, body: node };
  const state = { timeline: { first: scans[0], last: scans.at(-1), first_s: scans[0], last_s: scans.at(-1), live: false }, live: true, scan: null, run: { scan_s: 1 }, loop: null }, said = [];
  const asked = [];
  const link = { send: (message) => asked.push(message.scan) > 0 };
  const times = playback({ state, map: {}, link, line: { show() {}, textAt: () => "" }, changed() {}, shown() {}, say: ({ text }) => said.push(text) });
  const answer = () => {
    const wanted = asked.pop() ?? scans.at(-1), scan = scans.findLast((n) => n <= wanted) ?? scans[0];
    state.scan = { scan, timeS: scan, newest: scan === scans.at(-1) };
    times.came();
    return scan;
  };
  return { state, times, answer, asked, said };
}

test("scans that were lost are stepped over, forth and back, and it is said that they are not there", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { times, answer, said } = pageOn([1, 2, 3, 7, 8]);
  answer();
  times.showScan(2);
  assert.equal(answer(), 2);
  const forth = Array.from({ length: 5 }, () => {
    times.times.forth();
    const scan = answer();
    t.mock.timers.tick(400);
    return scan;
  });
  assert.deepEqual(forth, [3, 3, 3, 3, 7]);
  assert.deepEqual(said, [4, 5, 6].map((n) => `there is no scan ${n}: this is scan 3`));
  times.times.back();
  answer();
  times.times.back();
  assert.equal(answer(), 2, "from the one that is shown");
});

test("a run is played over what was lost to its end, and waits for what it asked for", (t) => {
  t.mock.timers.enable({ apis: ["setInterval"] });
  const { state, times, answer, asked } = pageOn([1, 2, 3, 7, 8]);
  answer();
  times.showScan(2);
  answer();
  times.setPlaying(true);
  t.mock.timers.tick(5000);
  assert.equal(asked.length, 1, "no answer yet");
  const shown = [];
  for (let k = 0; k < 20 && state.playing; k++) {
    if (asked.length) shown.push(answer());
    t.mock.timers.tick(1000);
  }
  assert.deepEqual([shown, state.playing], [[3, 3, 3, 3, 7, 8], false]);
});

test("while one drags over scans that are there nothing is said of the answers on their way", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { state, times, said } = pageOn([1, 2, 3, 4, 5, 6, 7]);
  const comes = (scan) => {
    state.scan = { scan, timeS: scan, newest: false };
    times.came();
    t.mock.timers.tick(100);
  };
  comes(1);
  [4, 5, 6].forEach((scan) => times.showScan(scan));
  [4, 5, 6].forEach(comes);
  t.mock.timers.tick(1000);
  assert.deepEqual(said, []);
});
