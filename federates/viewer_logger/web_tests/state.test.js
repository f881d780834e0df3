// The view in the address, against the reference cases.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { readState, writeState, LAYER_LETTERS } from "../web/state.js";

const { cases } = JSON.parse(readFileSync(new URL("../../../tests/data/views/fragments.json", import.meta.url)));

for (const c of cases) {
  test(`the address ${c.fragment || "(empty)"}`, () => {
    const { state, refused, kept } = readState(c.fragment);
    assert.deepEqual(state, c.state);
    assert.deepEqual(refused, c.refused);
    assert.deepEqual(kept, c.kept);
    assert.equal(writeState(state, kept), c.canonical);
  });
}

test("what is written is read again as it was, and written again the same", () => {
  const all = {
    run: ["a", "b c"], t: 3.25, ab: [0, 7], x: -1e-6, y: 9999999, z: 40, rot: 359.5, fit: "airport", lay: [...LAYER_LETTERS.values()].sort(),
    sel: "e1.2.3", follow: true, play: false, skin: "research", pane: ["map", "eye:driver:CAR 1"], tab: "log", col: "night", in1: [0, 0, 1],
    in2: [1, 2, 3, 4], rb: [["#1", "x_y"]], find: "é & = % +", lod: 2, vec: 0, hist: 30, cmp: "side", eff: ["1", "rain clutter"],
  };
  const written = writeState(all);
  assert.deepEqual(readState(written), { state: all, refused: [], kept: [] });
  assert.equal(writeState(readState(written).state), written);
});

test("hostile values are refused alone", () => {
  for (const [part, key] of [["sel=%00", "sel"], [`sel=${"a".repeat(65)}`, "sel"], ["find=%E2%80%AE", "find"], ["x=1e3", "x"], ["x=12345678", "x"],
    ["z=0.01", "z"], ["rot=north", "rot"], ["in1=0,0,99", "in1"], ["pane=map,map,map,map,map", "pane"], ["run=", "run"], ["ab=1", "ab"], ["t", "t"], ["eff=fog", "eff"], ["eff=x~fog", "eff"], ["eff=1~a~b", "eff"]]) {
    assert.deepEqual(readState(`#${part}&col=day`), { state: { col: "day" }, refused: [key], kept: [] }, part);
  }
  assert.deepEqual(readState("#__proto__=1&constructor=2"), { state: {}, refused: [], kept: ["__proto__=1", "constructor=2"] });
});
