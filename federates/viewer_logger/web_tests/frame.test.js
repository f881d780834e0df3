// What stands in a track of a scan, octet by octet as federates/viewer_logger/frame.rs lays it out.
import assert from "node:assert/strict";
import { test } from "node:test";
import { decode, setWords } from "../web/frame.js";
import { found } from "../web/tools.js";

/** A scan of one track. */
function scan(fill) {
  const view = new DataView(new ArrayBuffer(40 + 152));
  "SEED".split("").forEach((c, at) => view.setUint8(at, c.charCodeAt(0)));
  view.setUint8(4, 3);
  view.setUint32(24, 1, true);
  view.setUint8(40 + 126, 255);
  view.setUint8(40 + 127, 255);
  fill(view, 40);
  return decode(view.buffer);
}

test("what a track does, its alert, its emitter and its clearance are read by the server's words, octet by octet", () => {
  setWords({ types: [], statuses: [], movements: [], doing: ["", "parked", "pushing"], cleared: ["PSH", "TAX"] });
  const [none] = scan(() => {}).tracks;
  assert.deepEqual([none.doing, none.derived, none.alertStage, none.emitter, none.cleared], ["", false, 0, 0, ""]);
  const read = (octets) => {
    const [t] = scan((view, at) => octets.forEach(([to, value]) => view.setUint8(at + to, value))).tracks;
    return [t.doing, t.derived, t.alertStage, t.emitter, t.cleared];
  };
  assert.deepEqual(read([[120, 2], [121, 1], [122, 5], [124, 1]]), ["pushing", false, 1, 5, "PSH"]);
  assert.deepEqual(read([[120, 1], [121, 2], [122, 21], [124, 2], [125, 8]]), ["parked", true, 2, 21, "TAX"]);
  assert.deepEqual(read([[120, 77], [124, 77]]), ["", false, 0, 0, ""], "numbers of a later version");
  setWords({ types: [], statuses: [], movements: [] });
  assert.equal(read([[120, 2], [124, 1]]).join(), ",false,0,0,", "a server of before says no words");
});

test("address, existence and what could not be told apart are read where they are said, and unknown where not", () => {
  const [none] = scan(() => {}).tracks;
  assert.deepEqual([none.address, none.existenceP, none.labelP, none.unresolved, none.assumed], ["", null, null, false, false]);
  const told = scan((view, at) => {
    view.setUint32(at + 112, 0x0b1234, true);
    view.setUint8(at + 125, 2);
    view.setUint8(at + 127, 127);
  }), [track] = told.tracks;
  assert.deepEqual([track.address, track.existenceP, track.unresolved, track.assumed], ["0b1234", 0.5, true, false]);
  assert.equal(found("0B12", told, null, { tracks: true, truth: false }).length, 1, "a target is found by its address");
});
