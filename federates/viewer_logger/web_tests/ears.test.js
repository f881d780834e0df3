// Areas of the eye cut into triangles.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ears } from "../web/eye_scene.js";

const twice = (p) => p.reduce((s, [x, y], i) => s + x * p[(i + 1) % p.length][1] - p[(i + 1) % p.length][0] * y, 0);

/** Area of the triangles of a ring by its own area. */
function covered(ring) {
  const t = ears(ring);
  let sum = 0;
  for (let i = 0; i < t.length; i += 3) sum += Math.abs(twice(t.slice(i, i + 3).map((k) => ring[k])));
  return sum / Math.abs(twice(ring));
}

test("triangles cover a ring, also one that touches itself", () => {
  const rings = {
    square: [[0, 0], [10, 0], [10, 10], [0, 10]],
    bent: [[0, 0], [10, 0], [10, 10], [5, 10], [5, 5], [0, 5]],
    // Two squares that meet in a point, passed twice.
    pinched: [[0, 0], [4, 0], [4, 4], [8, 4], [8, 8], [4, 8], [4, 4], [0, 4]],
    // A hole joined to the outline by a slit that is passed there and back.
    slit: [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0], [3, 3], [3, 6], [6, 6], [6, 3], [3, 3]],
    // A corner that touches the middle of a side.
    touching: [[0, 0], [10, 0], [10, 10], [6, 10], [5, 0], [4, 10], [0, 10]],
  };
  for (const [name, ring] of Object.entries(rings)) {
    for (let turn = 0; turn < ring.length; turn++) {
      for (const way of [1, -1]) {
        const turned = [...ring.slice(turn), ...ring.slice(0, turn)];
        if (way < 0) turned.reverse();
        assert.ok(Math.abs(covered(turned) - 1) < 1e-9, `${name} from ${turn}, ${way}: ${covered(turned)}`);
      }
    }
  }
});
