// A bitmap larger than the view: moving the map shifts it until its margin is used up.

/** Pixels of the bitmap beyond the view, on each side. */
export const MARGIN = 160;

/** A bitmap and the camera that it was drawn with. */
export class Bitmap {
  constructor(alpha = true) {
    this.canvas = document.createElement("canvas");
    this.g = this.canvas.getContext("2d", { alpha });
    this.cam = null;
  }

  begin(cam, ratio) {
    const w = Math.round((cam.width + 2 * MARGIN) * ratio), h = Math.round((cam.height + 2 * MARGIN) * ratio);
    if (this.canvas.width !== w || this.canvas.height !== h) Object.assign(this.canvas, { width: w, height: h });
    else {
      this.g.setTransform(1, 0, 0, 1, 0, 0);
      this.g.clearRect(0, 0, w, h);
    }
    this.g.setTransform(ratio, 0, 0, ratio, MARGIN * ratio, MARGIN * ratio);
    this.cam = cam.copy();
    return this.g;
  }

  /** Has what was drawn so far made pixels now: a browser puts it off, and would do all of it in the frame that shows it. */
  settle() {
    this.g.getImageData(0, 0, 1, 1);
  }

  /** Where its middle is now, in pixels from the middle of the view. */
  offset(cam) {
    const [x, y] = cam.toScreen(this.cam.cx, this.cam.cy);
    return [x - cam.width / 2, y - cam.height / 2];
  }

  onto(g, cam, ratio) {
    if (!this.cam) return;
    const [dx, dy] = this.offset(cam), k = cam.scale / this.cam.scale, turn = ((this.cam.rot - cam.rot) * Math.PI) / 180;
    if (k === 1 && turn === 0) {
      // Whole pixels: nothing is resampled.
      g.setTransform(1, 0, 0, 1, 0, 0);
      g.drawImage(this.canvas, Math.round((dx - MARGIN) * ratio), Math.round((dy - MARGIN) * ratio));
      return;
    }
    g.setTransform(ratio, 0, 0, ratio, (cam.width / 2 + dx) * ratio, (cam.height / 2 + dy) * ratio);
    g.rotate(turn);
    g.scale(k, k);
    const w = this.cam.width + 2 * MARGIN, h = this.cam.height + 2 * MARGIN;
    g.drawImage(this.canvas, -w / 2, -h / 2, w, h);
  }

  /** Whether it still covers the view. */
  covers(cam) {
    if (!this.cam || this.cam.width !== cam.width || this.cam.height !== cam.height) return false;
    const [dx, dy] = this.offset(cam), k = cam.scale / this.cam.scale;
    return k >= 1 && this.cam.rot === cam.rot ? Math.abs(dx) <= MARGIN * k + ((k - 1) * cam.width) / 2 && Math.abs(dy) <= MARGIN * k + ((k - 1) * cam.height) / 2 : false;
  }
}
