// The picture and its error are painted from the same blocks.
const isPictureView = view => view === "picture" || view === "error";

// Player state, shared by all panels: frame, playback, exposure.

const AHEAD = 10;                  // frames decoded ahead, if they are small enough
const CACHE_BYTES = 600 * 2 ** 20; // of decoded frames

class Player {
  // `panels`: { painter, sequence, source( view, index ), onFrame( index, shown ) }, where the source is { ids, width, height }
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
    this.cube = null; // of the view, if the frames name one
    this.view = "picture";
    this.factors = {}; // of light groups, by name; 1 where there is none
    this.ahead = Math.min(Math.max(Math.floor(CACHE_BYTES / 2 / this.bytesOfFrame()), 2), AHEAD);
    this.cache = new FrameCache(Math.max(CACHE_BYTES, 5 * this.bytesOfFrame()));
    this.tick = this.tick.bind(this);
  }

  bytesOfFrame() {
    return this.panels.reduce((sum, panel) => sum + 4 * panel.painter.width * panel.painter.height, 0);
  }

  ids(index) {
    return this.panels.map(panel => panel.source(this.view, index)).filter(source => source !== null).flatMap(source => source.ids);
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
      const source = panel.source(this.view, index), frames = source !== null ? source.ids.map(id => this.cache.get(id)) : [];
      const has = frames.length > 0 && frames.every(frame => frame !== undefined);
      if (has) {
        panel.painter.resize(source.width, source.height);
        if (source.groups)
          panel.painter.takeParts(frames);
        else
          panel.painter.take(frames[0]);
      }
      panel.onFrame(index, has, this.view);
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

  makeTone() {
    return new Tone(this.exposure, this.curve, this.cube);
  }

  paint() {
    const data = this.isData(), reference = this.reference();
    const tone = data ? new Tone(0, "srgb", null) : this.makeTone();
    if (this.shown < 0)
      return;
    for (const panel of this.panels) {
      const source = panel.source(this.view, this.shown);
      if (source === null)
        continue;
      if (source.groups && panel.painter.parts)
        panel.painter.mix(source.groups.map(name => this.factorOf(name)));
      if (this.view === "error" && this.canShowError(panel) && reference.source(this.view, this.shown) !== null)
        panel.painter.paintError(reference.painter, this.exposure);
      else
        panel.painter.paint(tone);
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

  factorOf(group) {
    return group in this.factors ? this.factors[group] : 1;
  }

  setFactor(group, factor) {
    this.factors[group] = factor;
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
