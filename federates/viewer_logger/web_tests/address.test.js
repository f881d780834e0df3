// The address of the page: what it wrote once, and what comes again.
import assert from "node:assert/strict";
import { test } from "node:test";

test("an address that the page wrote is obeyed when it comes again", async () => {
  const heard = {};
  globalThis.window = { addEventListener: (name, f) => (heard[name] = f) };
  globalThis.location = { hash: "" };
  globalThis.history = { pushState: (a, b, text) => (location.hash = text), replaceState: (a, b, text) => (location.hash = text) };
  const { Address } = await import("../web/address.js");
  const applied = [];
  const page = { map: { view: {}, layers: {}, lod: "auto", vectorS: 15, dots: 30, need() {}, look() {} }, state: () => ({ t: 5 }), say() {}, colours() {}, layer() {}, skin() {}, apply: (state) => applied.push(state.t) };
  const address = new Address(page);
  address.changed(true);
  const written = location.hash;
  assert.match(written, /t=5/);
  for (const hash of ["#t=9", written]) {
    location.hash = hash;
    heard.hashchange();
  }
  assert.deepEqual(applied, [9, 5]);
  for (const name of ["window", "location", "history"]) delete globalThis[name];
});
