// What the dialog asks for, as `seeds fork --set` takes it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { changesOf } from "../web/whatif.js";

test("only what was filled in is changed", () => {
  const none = { filter: "", off: "", rain: "", visibility: "", seed: "", key: "", value: "" };
  assert.deepEqual(changesOf(none), []);
  assert.deepEqual(changesOf({ ...none, filter: "imm3", off: "ASDE tower", rain: "2" }), [["tracking.filter", "imm3"], ["sensor[ASDE tower].enabled", "false"], ["weather.rain_factor", "2"]]);
  assert.deepEqual(changesOf({ ...none, visibility: "400", seed: "9", key: "tracking.gate", value: "12" }), [["weather.visibility_m", "400"], ["run.sensor_seed", "9"], ["tracking.gate", "12"]]);
  assert.deepEqual(changesOf({ ...none, key: "tracking.gate" }), [], "a key without a value is none");
});
