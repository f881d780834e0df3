// The rotating video of a radar in its pane: a turn of cells from the server (federates/viewer_logger/video.rs writes it), put
// on the pane's pixels sector by sector. What is decided here without DOM: reading a turn, which pixel shows which cell.

const MAGIC = "VIDE", VERSION = 1, HEADER = 64, TAU = 2 * Math.PI;
/** Parts of a turn that are shown one after the other. */
export const SECTORS = 32;
const REST_MS = 150, AGAIN_MS = 900;

/** A turn out of its octets; throws an Error with a reason if they are none. */
export function readTurn(buffer) {
  const view = new DataView(buffer);
  if (view.byteLength < HEADER || String.fromCharCode(...new Uint8Array(buffer, 0, 4)) !== MAGIC) throw new Error("not a turn of a radar");
  if (view.getUint8(4) !== VERSION) throw new Error(`turns of version ${view.getUint8(4)}, this page reads ${VERSION}: reload it`);
  const ranges = view.getUint16(24, true), beams = view.getUint16(26, true), across = Math.ceil(ranges / 2);
  if (!ranges || !beams || view.byteLength < HEADER + beams * across) throw new Error("a turn cut short");
  const [firstM, stepM, floorDb, stepDb, east, north, antennaM, turnS] = Array.from({ length: 8 }, (_, i) => view.getFloat32(28 + 4 * i, true));
  const octets = new Uint8Array(buffer, HEADER, beams * across), levels = new Uint8Array(beams * ranges);
  for (let beam = 0; beam < beams; beam++) {
    for (let cell = 0; cell < ranges; cell++) levels[beam * ranges + cell] = (octets[beam * across + (cell >> 1)] >> (4 * (cell & 1))) & 15;
  }
  return { sensor: view.getUint16(6, true), scan: Number(view.getBigUint64(8, true)), timeS: Number(view.getBigInt64(16, true)) / 1e9, ranges, beams, firstM, stepM, floorDb, stepDb, siteM: [east, north], antennaM, turnS, levels };
}

/** Which cell every pixel of a camera shows (-1: none), and its pixels in the order of sectors: `from[s]` to `from[s + 1]` of `pixels`. */
export function pixelTable(cam, turn) {
  const { width, height, scale, cos, sin } = cam, { ranges, beams, firstM, stepM, antennaM } = turn;
  const cells = new Int32Array(width * height).fill(-1), counts = new Uint32Array(SECTORS + 1), sectors = new Uint8Array(width * height);
  const [x0, y0] = cam.toMetres(0.5, 0.5), dx = cos / scale, dy = -sin / scale, [dxr, dyr] = [-sin / scale, -cos / scale];
  for (let row = 0, i = 0; row < height; row++) {
    let x = x0 + row * dxr - turn.siteM[0], y = y0 + row * dyr - turn.siteM[1];
    for (let column = 0; column < width; column++, i++, x += dx, y += dy) {
      const cell = Math.floor((Math.sqrt(x * x + y * y + antennaM * antennaM) - firstM) / stepM);
      if (cell < 0 || cell >= ranges) continue;
      let azimuth = Math.atan2(x, y);
      if (azimuth < 0) azimuth += TAU;
      const beam = Math.min(beams - 1, Math.floor((azimuth / TAU) * beams)), sector = Math.floor((beam / beams) * SECTORS);
      cells[i] = beam * ranges + cell;
      sectors[i] = sector;
      counts[sector + 1]++;
    }
  }
  for (let s = 0; s < SECTORS; s++) counts[s + 1] += counts[s];
  const next = counts.slice(), pixels = new Uint32Array(counts[SECTORS]);
  for (let i = 0; i < cells.length; i++) if (cells[i] >= 0) pixels[next[sectors[i]]++] = i;
  return { cells, pixels, from: counts };
}

/** Opacity of each of the 16 levels: none up to `thresholdDb`, all from `spanDb` above it. */
export function opacities({ floorDb, stepDb }, thresholdDb, spanDb) {
  return Uint8Array.from({ length: 16 }, (_, level) => {
    const over = (floorDb + stepDb * level - thresholdDb) / spanDb;
    return level === 0 ? 0 : Math.round(255 * Math.min(1, Math.max(0, over)));
  });
}

/** What glows in a cell: what was just painted, or what is left of before after `turns` turns at this half time. */
export function glowing(level, before, left) {
  return Math.max(level * 16, before * left);
}

export class Video {
  /** `changed()`: something else is to be drawn; `say(text)`: what is shown, or why nothing. */
  constructor(sensor, changed, say) {
    Object.assign(this, { sensor, changed, say, run: "", turn: null, glow: null, table: null, image: null, wanted: null, asking: false, sweep: SECTORS, thresholdDb: 6, spanDb: 24, afterglowS: 1, why: "" });
    this.canvas = document.createElement("canvas");
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
  }

  /** The scan to show, of a run; `sweeping` where time goes on, `wallS` the wall seconds of a scan. */
  want(scan, { sweeping, wallS, run = "" }) {
    if (run !== this.run) this.turn = null;
    Object.assign(this, { wanted: scan, run, sweeping: sweeping && !this.still.matches, wallS });
    this.#ask();
  }

  close() {
    this.wanted = null;
    clearTimeout(this.later);
    clearTimeout(this.sweeper);
    clearTimeout(this.resting);
  }

  async #ask() {
    if (this.asking || this.wanted === null || this.turn?.scan === this.wanted) return;
    const token = sessionStorage.getItem("token"), scan = this.wanted, { run } = this;
    this.asking = true;
    let again = 0;
    try {
      const answer = await fetch(`/video?${new URLSearchParams({ sensor: this.sensor, scan, ...(run && { run }) })}`, token ? { headers: { Authorization: `Bearer ${token}` } } : {});
      if (answer.status === 202) again = AGAIN_MS;
      else if (!answer.ok) throw new Error((await answer.text()).trim());
      else {
        const octets = await answer.arrayBuffer();
        if (run === this.run) this.#take(readTurn(octets));
      }
    } catch (error) {
      this.why = error.message;
      this.changed();
    }
    this.asking = false;
    clearTimeout(this.later);
    if (again || (this.wanted !== null && (this.wanted !== scan || this.run !== run))) this.later = setTimeout(() => this.#ask(), again || 50);
  }

  #take(turn) {
    const same = this.turn && this.turn.ranges === turn.ranges && this.turn.beams === turn.beams, follows = same && turn.scan > this.turn.scan && turn.timeS - this.turn.timeS < 10;
    if (!follows) this.glow = new Uint8Array(turn.levels.length);
    // What a turn leaves after the time since the one before.
    this.left = follows && this.afterglowS > 0 ? 0.5 ** ((turn.timeS - this.turn.timeS) / this.afterglowS) : 0;
    if (!same) this.table = null;
    this.turn = turn;
    this.why = "";
    clearTimeout(this.sweeper);
    this.sweep = 0;
    if (this.sweeping && follows) this.#turnOn();
    else {
      this.#light(0, SECTORS);
      this.sweep = SECTORS;
      this.#put(0, SECTORS);
    }
    this.changed();
  }

  /** The next sector, and so on until the turn is whole. */
  #turnOn() {
    this.#light(this.sweep, this.sweep + 1);
    this.#put(this.sweep, this.sweep + 1);
    this.sweep += 1;
    this.changed();
    if (this.sweep < SECTORS) this.sweeper = setTimeout(() => this.#turnOn(), Math.max(16, (900 * this.wallS) / SECTORS));
  }

  /** Cells of these sectors as they glow now. */
  #light(first, last) {
    const { ranges, beams, levels } = this.turn, beam = (s) => Math.ceil((s * beams) / SECTORS);
    for (let i = beam(first) * ranges; i < beam(last) * ranges; i++) this.glow[i] = glowing(levels[i], this.glow[i], this.left);
  }

  /** Pixels of these sectors. */
  #put(first, last) {
    const { table, image, shades } = this;
    if (!table || !image) return;
    const { cells, pixels, from } = table, { data } = image;
    for (let k = from[first]; k < from[last]; k++) data[4 * pixels[k] + 3] = shades[this.glow[cells[pixels[k]]] >> 4];
    this.stale = true;
  }

  /** A new table where the view, the colours or the threshold are others: at once the first time, later when the view rests. */
  #fit(cam, colour) {
    const at = [cam.cx, cam.cy, cam.scale, cam.rot, cam.width, cam.height].join(), look = [colour, this.thresholdDb, this.spanDb].join();
    if (this.at === at && this.look === look && this.table) return;
    const make = () => {
      Object.assign(this, { at, look, cam: cam.copy(), table: this.at === at && this.table ? this.table : pixelTable(cam, this.turn), image: new ImageData(cam.width, cam.height) });
      this.shades = opacities(this.turn, this.thresholdDb, this.spanDb);
      const [r, g, b] = /^#(..)(..)(..)/.exec(colour)?.slice(1).map((h) => parseInt(h, 16)) ?? [140, 220, 170];
      new Uint32Array(this.image.data.buffer).fill(r | (g << 8) | (b << 16)); // opacity is the highest octet
      Object.assign(this.canvas, { width: cam.width, height: cam.height });
      this.#put(0, SECTORS);
    };
    clearTimeout(this.resting);
    if (!this.table || this.at === at) make();
    else {
      this.resting = setTimeout(() => {
        make();
        this.changed();
      }, REST_MS);
    }
  }

  /** Draws it; `timeS` is that of the picture round it. */
  paint(g, cam, colour, timeS) {
    if (!this.turn) return this.say(this.why || "video: the first turn is being made");
    this.#fit(cam, colour);
    if (this.stale) {
      this.canvas.getContext("2d").putImageData(this.image, 0, 0);
      this.stale = false;
    }
    const own = this.cam, [x, y] = cam.toScreen(own.cx, own.cy), k = cam.scale / own.scale;
    g.save();
    g.translate(x, y);
    g.rotate(((own.rot - cam.rot) * Math.PI) / 180);
    g.scale(k, k);
    g.imageSmoothingEnabled = k !== 1;
    g.drawImage(this.canvas, -own.width / 2, -own.height / 2);
    g.restore();
    if (this.sweep < SECTORS) this.#line(g, cam, colour);
    const old = timeS - this.turn.timeS;
    this.say(this.why || (Math.abs(old) < 0.5 ? "" : `video of ${old.toFixed(0)} s ago`));
  }

  #line(g, cam, colour) {
    const azimuth = (this.sweep / SECTORS) * TAU, far = this.turn.firstM + this.turn.ranges * this.turn.stepM, [x, y] = this.turn.siteM;
    g.strokeStyle = colour;
    g.globalAlpha = 0.5;
    g.lineWidth = 1;
    g.beginPath();
    g.moveTo(...cam.toScreen(x, y));
    g.lineTo(...cam.toScreen(x + far * Math.sin(azimuth), y + far * Math.cos(azimuth)));
    g.stroke();
    g.globalAlpha = 1;
  }
}
