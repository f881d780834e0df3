// Runs one after the other, and beside each other.
import assert from "node:assert/strict";
import { test } from "node:test";
import { AlertPanel } from "../web/alerts.js";
import { forgetSaid, otherFirst, selectAgain } from "../web/runs.js";

/** As much of a document as a list needs. */
function withPage(work) {
  const kept = { document: globalThis.document, setInterval: globalThis.setInterval };
  const node = () => ({ dataset: {}, textContent: "", append() {}, replaceChildren() {}, addEventListener() {}, setAttribute() {}, querySelector: () => null });
  globalThis.document = { createElement: node, activeElement: null };
  globalThis.setInterval = () => 0;
  try {
    work(node());
  } finally {
    Object.assign(globalThis, kept);
  }
}

test("an alarm of another run is announced, with its own runway, though its number was there before", () => withPage((box) => {
  const runways = { SWR1: "16/34", KLM2: "14/32" };
  const panel = new AlertPanel(box, { time: String, runway: (alert) => runways[alert.subjects[0]], pick() {}, acknowledge() {} });
  const alarm = (who) => ({ open: [{ id: 1, kind: "RMCA_ARR", stage: "alarm", subjects: [who], since_s: 1, end_s: null, place_m: [0, 0], acknowledged: null }], ended: [] });
  panel.show(alarm("SWR1"));
  assert.match(panel.aloud.textContent, /16\/34.*SWR1/);
  panel.aloud.textContent = "";
  panel.show(alarm("SWR1"));
  assert.equal(panel.aloud.textContent, "", "once");
  const said = [], map = { setSaid: (now) => said.push(now), setForeign: (tracks) => said.push(tracks) }, state = { traffic: {} };
  forgetSaid({ state, map, alerts: panel });
  assert.deepEqual([state, panel.open], [{ traffic: null }, []]);
  assert.deepEqual(said, [{ alerts: [], traffic: null, lights: null }, []]);
  panel.show(alarm("KLM2"));
  assert.match(panel.aloud.textContent, /14\/32.*KLM2/);
}));

test("it is another run where the first of those shown is, not where one is laid beside it", () => {
  assert.deepEqual([otherFirst([], ["a"]), otherFirst(["a"], ["a", "b"]), otherFirst(["a", "b"], ["b"]), otherFirst(["a"], ["a"])], [false, false, true, false]);
});

test("what was selected is let go and looked for by its name in another run", () => {
  const page = (selected, callsign) => {
    const state = { selected, callsign, wish: {} }, asked = [];
    selectAgain({ state, select: (id) => asked.push(id) });
    return [asked, state.wish];
  };
  assert.deepEqual(page("t4", "SWR1"), [[null], { sel: "SWR1" }]);
  assert.deepEqual(page("t4", null), [[null], {}], "without a name it is nobody there");
  assert.deepEqual(page(null, null), [[null], {}]);
});
