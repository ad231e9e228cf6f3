// The picture and its error are painted from the same blocks.
const isPictureView = view => view === "picture" || view === "error";

// Player state, shared by all panels: frame, playback, exposure.

const AHEAD = 10;                  // frames decoded ahead, if they are small enough
const CACHE_BYTES = 600 * 2 ** 20; // of decoded frames

class Player {
  // `panels`: { painter, sequence, source( view, index ), onFrame( index, shown ) }, where the source is { id, width, height }
  // of what is shown of a frame, or null; `onChange( player )` is called after each change of frame or setting.
  constructor(panels, count, fps, onChange) {
    this.panels = panels;
    this.count = count;
    this.fps = fps;
    this.onChange = onChange;
    this.index = 0;
    this.wanted = 0;
    this.shown = -1;
    this.playing = false;
    this.startTime = null; // time of startIndex during playback; null: set at the next tick
    this.startIndex = 0;
    this.exposure = 0;
    this.curve = "srgb";
    this.view = "picture";
    this.ahead = Math.min(Math.max(Math.floor(CACHE_BYTES / 2 / this.bytesOfFrame()), 2), AHEAD);
    this.cache = new FrameCache(Math.max(CACHE_BYTES, 5 * this.bytesOfFrame()));
    this.tick = this.tick.bind(this);
  }

  bytesOfFrame() {
    return this.panels.reduce((sum, panel) => sum + 4 * panel.painter.width * panel.painter.height, 0);
  }

  ids(index) {
    return this.panels.map(panel => panel.source(this.view, index)).filter(source => source !== null).map(source => source.id);
  }

  isReady(index) {
    return this.ids(index).every(id => this.cache.has(id));
  }

  // Shows a frame once it is decoded, unless another one was requested meanwhile.
  async seek(index) {
    this.wanted = Math.min(Math.max(index, 0), this.count - 1);
    const wanted = this.wanted;
    if (!this.isReady(wanted))
      await Promise.all(this.ids(wanted).map(id => this.cache.load(id)));
    if (this.wanted === wanted && this.shown !== wanted) {
      this.show(wanted);
      this.restart();
    }
    this.prefetch(wanted);
  }

  show(index) {
    for (const panel of this.panels) {
      const source = panel.source(this.view, index), frame = source !== null ? this.cache.get(source.id) : undefined;
      if (frame) {
        panel.painter.resize(source.width, source.height);
        panel.painter.take(frame);
      }
      panel.onFrame(index, frame !== undefined, this.view);
    }
    this.index = this.wanted = this.shown = index;
    this.paint();
    this.onChange(this);
  }

  // Whether the view is of an AOV that is no light: neither exposure nor curve changes it.
  isData() {
    const layer = this.panels.flatMap(panel => panel.sequence.layers).find(layer => layer.name === this.view);
    return layer !== undefined && layer.look !== "light" && layer.look !== "deviation";
  }

  paint() {
    const data = this.isData(), reference = this.reference();
    const table = makeToneTable(data ? 0 : this.exposure, data ? "srgb" : this.curve);
    if (this.shown < 0)
      return;
    for (const panel of this.panels) {
      if (panel.source(this.view, this.shown) === null)
        continue;
      if (this.view === "error" && this.canShowError(panel) && reference.source(this.view, this.shown) !== null)
        panel.painter.paintError(reference.painter, this.exposure);
      else
        panel.painter.paint(table);
    }
  }

  // What the error is of: the reference, else the last sequence, if there are several.
  reference() {
    return this.panels.find(panel => panel.isReference) || (this.panels.length > 1 ? this.panels[this.panels.length - 1] : undefined);
  }

  canShowError(panel) {
    const reference = this.reference();
    return reference !== undefined && reference !== panel && reference.painter.width === panel.painter.width && reference.painter.height === panel.painter.height;
  }

  setView(name) {
    const samePictures = isPictureView(this.view) && isPictureView(name);
    this.view = name;
    if (samePictures) {
      this.paint();
      this.onChange(this);
      return;
    }
    this.shown = -1;
    this.seek(this.index).catch(showFailure);
  }

  prefetch(index) {
    for (let i = 1; i <= Math.min(this.ahead, this.count - 1); ++i) {
      for (const id of this.ids((index + i) % this.count))
        this.cache.load(id).catch(() => {}); // reported when the frame is shown
    }
  }

  setExposure(stops) {
    this.exposure = Math.min(Math.max(Math.round(10 * stops) / 10, -8), 8);
    this.paint();
    this.onChange(this);
  }

  setCurve(name) {
    this.curve = name;
    this.paint();
    this.onChange(this);
  }

  setFps(fps) {
    if (fps > 0 && fps <= 240)
      this.fps = fps;
    this.restart();
    this.onChange(this);
  }

  toggle() {
    this.playing = !this.playing && this.count > 1;
    this.restart();
    this.onChange(this);
    if (this.playing)
      requestAnimationFrame(this.tick);
  }

  restart() {
    this.startTime = null;
    this.startIndex = this.index;
  }

  // Drops late frames, but waits for a frame that is not decoded yet.
  tick(now) {
    if (!this.playing)
      return;
    if (this.startTime === null)
      this.startTime = now;
    const due = (this.startIndex + Math.floor((now - this.startTime) * this.fps / 1000)) % this.count;
    const seeks = this.wanted !== this.shown;
    if (!seeks && due !== this.shown) {
      if (!this.isReady(due)) {
        this.waitFor(due);
        return;
      }
      this.show(due);
      this.prefetch(due);
    }
    requestAnimationFrame(this.tick);
  }

  waitFor(index) {
    Promise.all(this.ids(index).map(id => this.cache.load(id))).then(() => {
      if (!this.playing)
        return;
      this.show(index);
      this.prefetch(index);
      this.restart();
      requestAnimationFrame(this.tick);
    }).catch(showFailure);
  }
}
