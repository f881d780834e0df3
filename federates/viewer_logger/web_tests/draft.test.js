// The author's draft: steps back, places clicked, what is under the pointer.
import assert from "node:assert/strict";
import { test } from "node:test";
import { choose, draftOf, MOST_UNDO, nearestOf } from "../web/draft.js";

test("every step can be taken back, fifty at most, and the same text is no step", () => {
  let draft = draftOf("0").to("1").to("1").to("2");
  assert.deepEqual([draft.text, draft.past], ["2", ["0", "1"]]);
  draft = draft.back();
  assert.equal(draft.to("3").back().text, "1");
  assert.equal(draft.back().back().text, "0", "before the first there is nothing");
  for (let n = 0; n < 2 * MOST_UNDO; n++) draft = draft.to(`x${n}`);
  assert.equal(draft.past.length, MOST_UNDO);
});

test("a second click on the last place takes it back, a place may come again later", () => {
  assert.deepEqual(["A", "B", "B", "C", "A"].reduce(choose, []), ["A", "C", "A"]);
});

test("what is nearest to the pointer is meant, and nothing far away", () => {
  const at = (p) => p;
  assert.deepEqual(nearestOf([[0, 0], [10, 0], [11, 0]], [9, 0], at, 14), [10, 0]);
  assert.equal(nearestOf([[100, 0]], [0, 0], at, 14), null);
  assert.equal(nearestOf([[NaN, 0]], [0, 0], at, 14), null);
});
