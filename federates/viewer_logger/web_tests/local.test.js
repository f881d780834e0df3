// Who sits at a browser: one name at a seat, at the wheel and on the wire, also where nothing may be kept.
import test from "node:test";
import assert from "node:assert/strict";
import { nameAs, person } from "../web/local.js";

test("a browser that keeps nothing has one name of its own, until it takes another", async () => {
  const own = person();
  assert.match(own, /^page-[0-9a-f]{4}$/);
  assert.equal(person(), own);
  // Another browser has another one.
  const others = new Set();
  for (let n = 0; n < 8; n++) others.add((await import(`../web/local.js?other=${n}`)).person());
  assert.ok(others.size > 1);
  nameAs("anna");
  assert.equal(person(), "anna");
});

test("where names are kept the one from last time is taken", async () => {
  const kept = new Map([["person", JSON.stringify("ben")]]);
  globalThis.localStorage = { getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => kept.set(key, value) };
  const local = await import("../web/local.js?kept");
  assert.equal(local.person(), "ben");
  local.nameAs("eva");
  assert.equal(kept.get("person"), JSON.stringify("eva"));
  delete globalThis.localStorage;
});
