// What is typed at a seat.
import assert from "node:assert/strict";
import { test } from "node:test";
import { question, radioOf } from "../web/seat.js";

const CALLSIGNS = ["SWR1A", "DLH1A", "KLM22"];

test("what is done otherwise is typed the same way, with the case of names kept", () => {
  assert.deepEqual(question("22 hold 120", CALLSIGNS, null), { callsign: "KLM22", change: "HOLD 120" });
  assert.deepEqual(question("SWR1A stand Ramp 12b", CALLSIGNS, null), { callsign: "SWR1A", change: "STAND Ramp 12b" });
  assert.deepEqual(question("runway 28", CALLSIGNS, "DLH1A"), { callsign: "DLH1A", change: "RUNWAY 28" });
  for (const [line, word] of [["", "type a call sign"], ["HOLD 60", "selected"], ["22", "what is done"], ["22 FLY 3", "what is done"], ["22 HOLD", "how many seconds"], ["22 STAND ", "which one"], ["1A HOLD 9", "may be"]]) {
    assert.ok(question(line, CALLSIGNS, null).error.includes(word), line);
  }
});

test("who drives a flight hears what is said to it and by it, and nothing else", () => {
  const said = (from, to, kind, clearance, time_s) => ({ from, to, kind, clearance, time_s });
  const radio = [said("KLM22", "ground", "request", "TAX", 1), said("ground", "DLH1A", "clearance", "TAX", 2), said("ground", "KLM22", "clearance", "TAX", 3), said("KLM22", "ground", "readback", "HLD", 4), said("ground", "KLM22", "correction", "TAX", 5)];
  assert.deepEqual(radioOf({ radio }, "KLM22").map((m) => m.says), ["corrects TAX", "reads back HLD", "clears TAX", "asks TAX"]);
  assert.equal(radioOf({ radio: Array(20).fill(radio[0]) }, "KLM22").length, 6);
  assert.deepEqual([radioOf(null, "KLM22"), radioOf({ radio }, "")], [[], []]);
});
