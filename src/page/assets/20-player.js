// The frame, view, exposure and playback that all panels share.

const AHEAD = 10;                  // frames decoded ahead, if they are small enough
const CACHE_BYTES = 600 * 2 ** 20; // of decoded frames

class Player {
  // `panels`: { painter, sequence, source( view, index ), onFrame( index, source ) }; the source of a frame is null or
  // { ids, layer, groups } of what is shown. `onChange()` follows each change of frame or setting.
  constructor(panels, count, fps, exposure, onChange) {
    Object.assign(this, { panels, count, fps, exposure, onChange, index: 0, shown: -1, turn: 0, playing: false });
    this.cube = null; // of the view that is shown; null: the sRGB curve
    this.view = "picture";
    this.factors = {}; // of light groups, by name; 1 where there is none
    this.cache = new Map(); // of promised frames by id, the one that was used last behind the others
    this.room = Infinity; // in frames
  }

  load(id) {
    const frame = this.cache.get(id) || decodeFrame(id);
    this.cache.delete(id);
    this.cache.set(id, frame);
    frame.catch(() => this.cache.delete(id));
    return frame;
  }

  // Releases what was used longest ago, but for the frames that `needed` are.
  trim(needed) {
    for (const [id, frame] of this.cache) {
      if (this.cache.size <= Math.max(this.room, needed))
        return;
      this.cache.delete(id);
      frame.then(({ bitmap }) => bitmap.close()).catch(() => {});
    }
  }

  // Shows a frame once it is decoded, unless another one was requested meanwhile.
  async seek(index) {
    const turn = ++this.turn;
    this.index = Math.min(Math.max(index, 0), this.count - 1);
    const sources = this.panels.map(panel => panel.source(this.view, this.index));
    const decoded = await Promise.all(sources.map(source => source && Promise.all(source.ids.map(id => this.load(id)))));
    if (turn !== this.turn)
      return;
    this.panels.forEach(({ painter, onFrame }, i) => {
      const source = sources[i];
      for (const { bitmap } of decoded[i] || [])
        this.room = Math.min(this.room, CACHE_BYTES / (4 * bitmap.width * bitmap.height));
      if (source && source.groups)
        painter.takeParts(decoded[i]);
      else if (source)
        painter.take(decoded[i][0]);
      onFrame(this.index, source);
    });
    this.sources = sources;
    this.shown = this.index;
    this.paint();
    this.prefetch();
  }

  prefetch() {
    const idsOf = i => this.panels.map(panel => panel.source(this.view, i % this.count)).flatMap(source => source ? source.ids : []);
    const now = idsOf(this.index).length, ahead = Math.min(AHEAD, this.count - 1, this.room / 2 / Math.max(now, 1));
    this.trim((ahead + 2) * now);
    for (let i = 1; i <= ahead; ++i)
      idsOf(this.index + i).forEach(id => this.load(id).catch(() => {})); // reported when the frame is shown
  }

  // Whether the view is of a pass that is no light: neither exposure nor curve changes it.
  isData() {
    const layer = this.panels.flatMap(panel => panel.sequence.layers).find(({ name }) => name === this.view);
    return layer !== undefined && layer.look !== "light" && layer.look !== "deviation";
  }

  paint() {
    const tone = this.isData() ? new Tone(0, null) : new Tone(this.exposure, this.cube);
    this.panels.forEach((panel, i) => {
      const source = this.sources && this.sources[i];
      if (!source)
        return;
      if (source.groups)
        panel.painter.mix(source.groups.map(name => this.factorOf(name)));
      panel.painter.paint(tone);
    });
    this.onChange();
  }

  setView(name) {
    this.view = name;
    this.shown = -1;
    this.sources = null;
    return this.seek(this.index);
  }

  setExposure(stops) {
    this.exposure = Math.min(Math.max(Math.round(10 * stops) / 10, -8), 8);
    this.paint();
  }

  setCube(cube) {
    this.cube = cube;
    this.paint();
  }

  factorOf(group) {
    return group in this.factors ? this.factors[group] : 1;
  }

  setFactor(group, factor) {
    this.factors[group] = factor;
    this.paint();
  }

  // Plays or pauses. Frames that come too late are left out.
  async toggle() {
    const playing = this.playing = !this.playing && this.count > 1 ? {} : false;
    this.onChange();
    for (let next = performance.now(); playing && this.playing === playing;) {
      const late = Math.floor(Math.max(0, performance.now() - next) * this.fps / 1000);
      await this.seek((this.index + 1 + late) % this.count);
      next += 1000 * (1 + late) / this.fps;
      await new Promise(done => setTimeout(done, next - performance.now()));
    }
  }
}
