// Scene values of frames, for the probe; the format is described in src/page/page.h.

function lightOfHalf(half) {
  const sign = half & 0x8000 ? -1 : 1, exponent = half >> 10 & 31, mantissa = half & 1023;
  if (exponent === 31)
    return mantissa ? NaN : sign * Infinity;
  return sign * (exponent === 0 ? mantissa * 2 ** -24 : (1024 + mantissa) * 2 ** (exponent - 25));
}

class SceneValues {
  constructor(data) {
    this.data = data;
    this.blocks = new Map(); // by id; the few that were used last
  }

  // The block with the finest values of a frame, or null.
  idOf(sequence, number) {
    const fine = sequence.fine_frame === number && sequence.fine_factor > 0;
    return fine ? `w${sequence.index}-${number}` : sequence.value_factor > 0 ? `v${sequence.index}-${number}` : null;
  }

  block(id) {
    if (!this.blocks.has(id)) {
      const bytes = bytesOf(id), view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
      this.blocks.set(id, { view, factor: view.getUint16(0, true), columns: view.getUint16(2, true) });
      if (this.blocks.size > 12)
        this.blocks.delete(this.blocks.keys().next().value);
    }
    return this.blocks.get(id);
  }

  // { factor, light: [r, g, b] } at a pixel of the frame's file, or null.
  at(sequence, index, x, y) {
    const id = sequence.blocks[index] !== null ? this.idOf(sequence, this.data.frames[index]) : null;
    if (id === null)
      return null;
    const { view, factor, columns } = this.block(id);
    const from = 6 + 6 * (Math.floor(y / factor) * columns + Math.floor(x / factor));
    return { factor, light: [0, 2, 4].map(c => lightOfHalf(view.getUint16(from + c, true))) };
  }
}

// Names of a Cryptomatte, for the probe; the format is described in src/cli/report/report_frames.h.
class MatteNames {
  constructor() {
    this.last = { id: null, names: null };
  }

  // What covers most of a pixel of the picture of a pass: its name, "" for nothing, or null where that is not known.
  at({ ids: [id], layer }, x, y) {
    const block = id.replace("l", "n");
    if (layer.look !== "mattes" || !document.getElementById(block))
      return null;
    if (this.last.id !== block) {
      const bytes = bytesOf(block), view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), names = new Uint16Array(layer.width * layer.height);
      for (let i = 0, to = 0; i < bytes.length; to += view.getUint16(i + 2, true), i += 4)
        names.fill(view.getUint16(i, true), to, to + view.getUint16(i + 2, true));
      this.last = { id: block, names };
    }
    const name = this.last.names[y * layer.width + x];
    return name > 0 ? layer.names[name - 1] : "";
  }
}

// What the levels of an AOV's picture stand for, nearly: [label, values].
function valuesOfLayer(layer, light) {
  const level = light.map(value => encodeSrgb(value) / 255);
  switch (layer.look) {
    case "light": return light;
    case "deviation": return light.map(value => value * value);
    case "normal": return level.map(value => 2 * value - 1);
    case "depth": return level[0] < 0.08 ? [Infinity] : [layer.low * (layer.high / layer.low) ** Math.min(Math.max(1 - (level[0] - 0.1) / 0.9, 0), 1)];
    case "signed": return level.map(value => 2 * layer.high * (value - 0.5));
    case "index": case "mattes": return [];
    case "motion": return [2 * layer.high * (level[0] - 0.5), 2 * layer.high * (level[1] - 0.5)];
    default: return [level[0] * layer.high];
  }
}

// What black and white of an AOV's picture stand for.
function legendOfLayer(layer) {
  switch (layer.look) {
    case "normal": return "X red, Y green, Z blue; 0 is grey";
    case "depth": return `white ${formatNumber(layer.low)} m, dark ${formatNumber(layer.high)} m, by the logarithm; black: nothing`;
    case "motion": return `to the frame before: red right, green up, up to ${formatNumber(layer.high)} pixels; grey: none`;
    case "deviation": return "shown as standard deviation, in scene values";
    case "signed": return `0 is grey, white ${formatNumber(layer.high)}`;
    case "index": case "mattes": return "a colour for each name or number; black: nothing";
    case "share": return `white is ${formatNumber(layer.high)}`;
    default: return layer.name.includes("albedo") ? "reflectance" : "light";
  }
}
