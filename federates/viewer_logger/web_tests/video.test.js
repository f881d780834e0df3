// Turns of a radar: read as they were written, and every pixel shows the cell that it lies in.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Camera } from "../web/camera.js";
import { glowing, opacities, pixelTable, readTurn, SECTORS } from "../web/video.js";

const RANGES = 101, BEAMS = 360, FIRST = 100, STEP = 10;

/** A turn whose cells say where they are. */
function written(level) {
  const across = Math.ceil(RANGES / 2), buffer = new ArrayBuffer(64 + BEAMS * across), view = new DataView(buffer), octets = new Uint8Array(buffer);
  octets.set([..."VIDE"].map((c) => c.charCodeAt(0)).concat(1, 0));
  view.setUint16(6, 7, true);
  view.setBigUint64(8, 12n, true);
  view.setBigInt64(16, 3_500_000_000n, true);
  view.setUint16(24, RANGES, true);
  view.setUint16(26, BEAMS, true);
  [FIRST, STEP, -1.5, 3, 50, -20, 40, 1].forEach((v, i) => view.setFloat32(28 + 4 * i, v, true));
  for (let b = 0; b < BEAMS; b++) for (let r = 0; r < RANGES; r++) octets[64 + b * across + (r >> 1)] |= level(b, r) << (4 * (r & 1));
  return buffer;
}

test("a turn is read as it was written, and what is none is refused", () => {
  const level = (b, r) => (b * 7 + r * 3) % 16, buffer = written(level), turn = readTurn(buffer);
  assert.deepEqual([turn.sensor, turn.scan, turn.timeS, turn.ranges, turn.beams, ...turn.siteM, turn.antennaM], [7, 12, 3.5, RANGES, BEAMS, 50, -20, 40]);
  for (const [b, r] of [[0, 0], [0, 100], [359, 99], [17, 42]]) assert.equal(turn.levels[b * RANGES + r], level(b, r), `${b}, ${r}`);
  assert.throws(() => readTurn(buffer.slice(0, 900)), /cut short/);
  assert.throws(() => readTurn(new ArrayBuffer(10)), /not a turn/);
  const later = buffer.slice(0);
  new DataView(later).setUint8(4, 9);
  assert.throws(() => readTurn(later), /version 9.*reload/);
});

test("every pixel shows the cell that it lies in, whatever the place, zoom and rotation", () => {
  const turn = readTurn(written(() => 1));
  for (const view of [{ cx: 0, cy: 0, scale: 0.1, rot: 0 }, { cx: 400, cy: -300, scale: 0.7, rot: 137 }]) {
    const cam = new Camera(230, 170);
    cam.look(view);
    const { cells, pixels, from } = pixelTable(cam, turn);
    let seen = 0;
    for (let py = 3; py < cam.height; py += 13) {
      for (let px = 1; px < cam.width; px += 11) {
        const [x, y] = cam.toMetres(px + 0.5, py + 0.5), dx = x - 50, dy = y + 20, slant = Math.hypot(dx, dy, 40);
        const range = Math.floor((slant - FIRST) / STEP), azimuth = ((Math.atan2(dx, dy) * 180) / Math.PI + 360) % 360;
        const near = (v) => Math.abs(v - Math.round(v)) < 1e-6;
        if (near((slant - FIRST) / STEP) || near(azimuth)) continue;
        const want = range < 0 || range >= RANGES ? -1 : Math.floor(azimuth) * RANGES + range;
        assert.equal(cells[py * cam.width + px], want);
        seen += want >= 0;
      }
    }
    assert.ok(seen > 20, `${seen} pixels`);
    // The sectors hold all pixels that show something, once each, in the order of the sweep.
    assert.equal(from[SECTORS], pixels.length);
    assert.equal(new Set(pixels).size, cells.filter((c) => c >= 0).length);
    for (let s = 0; s < SECTORS; s++) {
      for (let k = from[s]; k < from[s + 1]; k++) assert.equal(Math.floor((Math.floor(cells[pixels[k]] / RANGES) / BEAMS) * SECTORS), s);
    }
  }
});

test("a threshold hides what is below, and what was painted fades by half each half time", () => {
  const shades = opacities({ floorDb: -1.5, stepDb: 3 }, 6, 24);
  assert.deepEqual([shades[0], shades[2], shades[15]], [0, 0, 255]);
  assert.ok(shades[3] > 0 && shades.every((v, i) => i === 0 || v >= shades[i - 1]));
  assert.deepEqual([glowing(10, 0, 0.5), glowing(2, 160, 0.5), glowing(0, 160, 0)], [160, 80, 0]);
});
