// The pixel probe: scene values of all shown sequences at the place that is pointed at.

function lightOfHalf(half) {
  const sign = half & 0x8000 ? -1 : 1, exponent = half >> 10 & 31, mantissa = half & 1023;
  if (exponent === 31)
    return mantissa ? NaN : sign * Infinity;
  return sign * (exponent === 0 ? mantissa * 2 ** -24 : (1024 + mantissa) * 2 ** (exponent - 25));
}

// The bytes of a block, or null. The last block of each kind and sequence is kept.
const s_blocks = {};
function viewOf(id) {
  const kind = id.slice(0, id.indexOf("-"));
  if (!s_blocks[kind] || s_blocks[kind].id !== id) {
    const bytes = document.getElementById(id) ? bytesOf(id) : null;
    s_blocks[kind] = { id, view: bytes && new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength) };
  }
  return s_blocks[kind].view;
}

// Scene values at a pixel of a frame's file, or null; the format is described in src/page/page.h.
function sceneValues(sequence, number, x, y) {
  const view = viewOf(`v${sequence.index}-${number}`), factor = sequence.value_factor;
  if (view === null)
    return null;
  const from = 6 + 6 * (Math.floor(y / factor) * view.getUint16(2, true) + Math.floor(x / factor));
  return [0, 2, 4].map(c => lightOfHalf(view.getUint16(from + c, true)));
}

// What covers most of a pixel of a Cryptomatte's picture, "" for nothing, or null where that is not known; the format is described in
// src/cli/report/report_frames.h.
function nameAt({ ids: [id], layer }, x, y) {
  const view = layer.look === "mattes" ? viewOf(id.replace("l", "n")) : null;
  for (let i = 0, left = y * layer.width + x; view && i < view.byteLength; i += 4) {
    left -= view.getUint16(i + 2, true);
    if (left < 0)
      return ["", ...layer.names][view.getUint16(i, true)];
  }
  return null;
}

// What the light of a pass's picture stands for, nearly. `of` what black and white do, in words. As src/page/picture.c draws them.
const s_looks = {
  light: { values: (layer, light) => light, of: layer => layer.name.includes("albedo") ? "reflectance" : "light" },
  deviation: { values: (layer, light) => light.map(value => value * value), of: () => "shown as standard deviation" },
  normal: { values: (layer, light, level) => level.map(value => 2 * value - 1), of: () => "X red, Y green, Z blue; 0 is grey" },
  depth: {
    values: ({ low, high }, light, [level]) => [level < 0.08 ? Infinity : low * (high / low) ** Math.min(Math.max(1 - (level - 0.1) / 0.9, 0), 1)],
    of: ({ low, high }) => `white ${formatNumber(low)} m, dark ${formatNumber(high)} m, by the logarithm; black: nothing`,
  },
  motion: {
    values: ({ high }, light, level) => level.slice(0, 2).map(value => 2 * high * (value - 0.5)),
    of: ({ high }) => `to the frame before: red right, green up, up to ${formatNumber(high)} pixels; grey: none`,
  },
  share: { values: ({ high }, light, level) => [level[0] * high], of: ({ high }) => `white is ${formatNumber(high)}` },
  signed: { values: ({ high }, light, level) => level.map(value => 2 * high * (value - 0.5)), of: ({ high }) => `0 is grey, white ${formatNumber(high)}` },
  index: { values: () => [], of: () => "a colour for each number; black: nothing" },
  mattes: { values: () => [], of: () => "a colour for each name; black: nothing" },
};

class Probe {
  constructor(box, data, player, stage) {
    Object.assign(this, { box, data, player, stage, place: null, pinned: false });
    this.where = make("p", {});
    this.note = make("p", {});
    this.rows = data.sequences.map((sequence, index) => make("div", {}, markedName(sequence, index), make("b", {}), make("span", {})));
    box.append(this.where, ...this.rows, this.note);
    this.show();
  }

  // A place by shares of the picture's width and height. A click pins it, and another one lets it go.
  point(u, v, how) {
    const inside = how !== "leave" && u >= 0 && u < 1 && v >= 0 && v < 1;
    if (this.pinned && (how === "hover" || !inside))
      return;
    this.pinned = inside && (how === "keys" || how === "pin" && !this.pinned);
    this.place = inside ? [u, v] : null;
    this.box.setAttribute("aria-live", how === "keys" ? "polite" : "off");
    this.show();
  }

  clear() {
    this.pinned = false;
    this.point(0, 0, "leave");
  }

  // By the arrow keys: pixels of the first sequence.
  step(dx, dy) {
    const { file_width, file_height } = this.data.sequences[0], [u, v] = this.place || [0.5, 0.5];
    const move = (share, by, size) => (Math.min(Math.max(Math.floor(share * size) + by, 0), size - 1) + 0.5) / size;
    this.point(move(u, dx, file_width), move(v, dy, file_height), "keys");
  }

  show() {
    const { place } = this, [{ file_width, file_height }] = this.data.sequences, shown = this.stage.shownPanels();
    this.stage.mark(place);
    this.where.textContent = place === null ? "Point at a pixel, or tap it, for its scene values"
      : `Pixel ${Math.floor(place[0] * file_width)}, ${Math.floor(place[1] * file_height)}${this.pinned ? " \u00b7 pinned" : ""}`;
    this.rows.forEach((row, i) => {
      row.hidden = place === null || !shown.includes(i);
      if (!row.hidden)
        this.fill(row, this.player.panels[i], this.player.sources && this.player.sources[i]);
    });
    const factor = Math.max(...shown.map(i => this.data.sequences[i].value_factor));
    this.note.textContent = place === null ? ""
      : factor === 0 ? "Values are read back from the picture: report --values puts those of the file in."
        : factor === 1 ? "Values of the file, in half precision."
          : `Values of the file, the mean of ${factor}x${factor} pixels; \u2248 is read back from the picture. report --values gives more.`;
  }

  fill(row, { sequence, painter }, source) {
    const { view, shown } = this.player, at = (share, size) => Math.min(Math.floor(share * size), size - 1), [u, v] = this.place;
    const [, exact, near] = row.children, column = at(u, painter.width), line = at(v, painter.height);
    const values = source ? sceneValues(sequence, this.data.frames[shown], at(u, sequence.file_width), at(v, sequence.file_height)) : null;
    exact.textContent = values ? values.map(formatValue).join("  ") : "";
    near.textContent = "";
    if (!source || (!source.layer && values && sequence.value_factor === 1))
      return;
    const layer = source.layer || { look: "light", name: "" }, name = nameAt({ ...source, layer }, column, line);
    const light = painter.lightAt(column, line), level = light.map(value => encodeSrgb(value) / 255);
    const list = s_looks[layer.look].values(layer, light, level).map(value => formatNumber(value)).join("  ");
    near.textContent = `${source.layer ? view : ""}${name !== null ? `: ${name || "nothing"}` : ` \u2248 ${list}`}`;
  }
}
