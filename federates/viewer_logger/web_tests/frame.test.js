// What stands in a track of a scan, octet by octet as federates/viewer_logger/frame.rs lays it out.
import assert from "node:assert/strict";
import { test } from "node:test";
import { decode } from "../web/frame.js";
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
