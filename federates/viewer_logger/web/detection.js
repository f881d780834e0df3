// Where the radars see: a picture of the server under the map. Violet: missed more often, or of errors (1σ) ten metres and more; grey:
// nothing is displayed.

export class Detection {
  /**
   * `sensor`: a radar's number, or null for all together; `changed()`: another picture is there; `of`: "pd" or "sigma"; `run()`: the
   * name of the run that is looked at.
   */
  constructor(sensor, changed, of = "pd", run = () => "") {
    Object.assign(this, { sensor, changed, of, run, key: null, picture: null, shown: 0 });
  }

  /** Draws the picture of the weather since `fromS`; asks for it where it is not there. */
  paint(g, cam, fromS) {
    const run = this.run(), key = `${fromS} ${run}`;
    if (key !== this.key) {
      if (run !== this.ofRun) this.picture = null;
      Object.assign(this, { key, ofRun: run });
      this.#ask(fromS);
    }
    if (!this.picture) return;
    const { image, west, north, step } = this.picture;
    const [ox, oy] = cam.toScreen(west, north), [ax, ay] = cam.toScreen(west + image.width * step, north), [bx, by] = cam.toScreen(west, north - image.height * step);
    g.save();
    g.imageSmoothingEnabled = false;
    g.transform((ax - ox) / image.width, (ay - oy) / image.width, (bx - ox) / image.height, (by - oy) / image.height, ox, oy);
    g.drawImage(image, 0, 0);
    g.restore();
  }

  async #ask(fromS) {
    const token = sessionStorage.getItem("token"), key = this.key;
    const query = new URLSearchParams({ t: String(fromS), of: this.of });
    if (this.ofRun) query.set("run", this.ofRun);
    if (this.sensor !== null) query.set("sensor", String(this.sensor));
    try {
      const answer = await fetch(`/detection?${query}`, token ? { headers: { Authorization: `Bearer ${token}` } } : {});
      if (!answer.ok) throw new Error((await answer.text()).trim());
      const [west, north, step] = answer.headers.get("x-place").split(" ").map(Number);
      const image = await createImageBitmap(await answer.blob());
      // Meanwhile the weather may be another one.
      if (key === this.key) this.picture = { image, west, north, step };
    } catch (error) {
      if (key === this.key) Object.assign(this, { picture: null, why: error.message });
    }
    this.shown += 1;
    this.changed();
  }
}
