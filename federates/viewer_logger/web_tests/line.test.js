// The line for clearances, against the reference cases.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { parseLine } from "../web/line.js";

const { context, cases } = JSON.parse(readFileSync(new URL("../../../tests/data/views/clearance-lines.json", import.meta.url)));

for (const c of cases) {
  test(`the line "${c.line}"`, () => {
    const { line, ...expected } = c;
    assert.deepEqual(parseLine(line, context), expected);
  });
}

test("errors at the places where something is missing or too much", () => {
  for (const [line, error, column] of [["879", "empty", 3], ["879 ent 28 until", "missing_word", 16], ["879 e 28 until 2460", "bad_time", 15], [". t A follow 37H", "missing_limit", 16],
    ["229 s", "missing_word", 5], ["229 s 0", "bad_speed", 6], ["229 t stand A15", "unknown_stand", 12], ["229 t hold", "missing_runway", 10], ["   ", "empty", 0], [";", "empty", 0]]) {
    assert.deepEqual(parseLine(line, context), { error, column }, line);
  }
  assert.deepEqual(parseLine(". h", { ...context, selected: null }), { error: "nothing_selected", column: 0 });
});
