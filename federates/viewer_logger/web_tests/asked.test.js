// What is asked of the server for a run names the run that is looked at.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Detection } from "../web/detection.js";
import { Geometry } from "../web/geometry.js";
import { Rings } from "../web/rings.js";
import { Video } from "../web/video.js";

const soon = () => new Promise((done) => setImmediate(done));

/** A page whose server keeps what it is asked for, and answers all of it alike. */
async function asked(work, answer) {
  const names = ["fetch", "sessionStorage", "document", "matchMedia", "createImageBitmap"], kept = names.map((name) => globalThis[name]), urls = [];
  Object.assign(globalThis, {
    fetch: async (url) => urls.push(url) && { ok: true, ...answer }, sessionStorage: { getItem: () => null }, document: { createElement: () => ({}) }, matchMedia: () => ({ matches: true }), createImageBitmap: async (blob) => blob,
  });
  try {
    await work(urls);
  } finally {
    names.forEach((name, i) => (globalThis[name] = kept[i]));
  }
}

/** The smallest turn, of scan 5. */
function turn() {
  const view = new DataView(new ArrayBuffer(64 + 32));
  [..."VIDE"].forEach((c, i) => view.setUint8(i, c.charCodeAt(0)));
  view.setUint8(4, 1);
  view.setBigUint64(8, 5n, true);
  view.setUint16(24, 2, true);
  view.setUint16(26, 32, true);
  return view.buffer;
}

const runOf = (url) => new URL(url, "http://here").searchParams.get("run");

test("where the radars see is asked for of the run looked at, and again where that is another one", () => asked(async (urls) => {
  let run = "a b&c";
  const detection = new Detection(1, () => {}, "pd", () => run), g = { save() {}, restore() {}, transform() {}, drawImage: () => (g.drawn = true) }, cam = { toScreen: (x, y) => [x, y] };
  const paint = async () => {
    g.drawn = false;
    detection.paint(g, cam, 3);
    await soon();
    return g.drawn;
  };
  await paint();
  assert.equal(await paint(), true, "its picture");
  run = "other";
  assert.equal(await paint(), false, "that of another run is not shown meanwhile");
  assert.deepEqual(urls.map(runOf), ["a b&c", "other"]);
}, { headers: { get: () => "0 0 10" }, blob: async () => ({ width: 2, height: 2 }) }));

test("rings, turns and geometry are asked for of the run looked at, also where sensor and scan are the same", () => asked(async (urls) => {
  const rings = new Rings(() => {}), video = new Video(1, () => {}, () => {});
  const geometry = new Geometry(1, () => {}, async (url) => urls.push(url) && { ok: true, json: async () => ({ kind: "gps" }) }), scan = { timeS: 3, plots: [], truth: [] };
  for (const run of ["a", "a", "b&c", ""]) {
    rings.want({ sensor: 1, effect: "fog" }, 5, run);
    await soon();
    video.want(5, { sweeping: false, wallS: 1, run });
    await soon();
    await geometry.take(scan, null, run);
  }
  video.close();
  clearTimeout(rings.later);
  const of = (path) => urls.filter((url) => url.startsWith(path)).map(runOf);
  for (const path of ["/geometry", "/rings", "/video"]) assert.deepEqual(of(path), ["a", "b&c", null], path);
}, { json: async () => ({ sensor: 1, scan: 5, effects: ["fog"], whole: {}, cells: [] }), arrayBuffer: async () => turn() }));
