"use strict";
// Decodes and tone-maps HDR frames; the format is described in src/page/picture.h.

const STOP = 256;           // units per stop
const FLOOR = 1 / 512;      // log2( light + FLOOR ) is stored
const HALF_TABLE = 16384;   // levels go from -HALF_TABLE to HALF_TABLE - 1

// Offset from the base in units, for each byte of the detail layer.
const s_stepsOfByte = new Int16Array(256);
for (let i = 0; i < 256; ++i) {
  const steps = Math.abs(i - 128);
  s_stepsOfByte[i] = Math.sign(i - 128) * Math.round(STOP * (Math.exp(steps / 32) - 1) / 2);
}

function bytesOf(id) {
  const text = document.getElementById(id).textContent;
  if (Uint8Array.fromBase64)
    return Uint8Array.fromBase64(text);
  const binary = atob(text), bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i)
    bytes[i] = binary.charCodeAt(i);
  return bytes;
}

async function fetchBytes(path) {
  const reply = await fetch(path);
  if (!reply.ok)
    throw new Error(`${path}: ${reply.status}`);
  return new Uint8Array(await reply.arrayBuffer());
}

// Parses the frame of a block, or of a path on the server of a live page: { cell, columns, rows, base, bitmap }. The browser decodes the
// bitmap asynchronously.
async function decodeFrame(id) {
  const bytes = id.startsWith("/") ? await fetchBytes(id) : bytesOf(id);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const cell = view.getUint16(0, true), columns = view.getUint16(2, true), rows = view.getUint16(4, true);
  const base = new Int16Array(3 * columns * rows);
  for (let i = 0; i < base.length; ++i)
    base[i] = view.getInt16(6 + 2 * i, true);
  const jpeg = new Blob([bytes.subarray(6 + 2 * base.length)], { type: "image/jpeg" });
  const bitmap = await createImageBitmap(jpeg, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  return { cell, columns, rows, base, bitmap };
}

function encodeSrgb(light) {
  if (!(light > 0))
    return 0;
  return light >= 1 ? 255 : Math.round(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * Math.pow(light, 1 / 2.4) - 0.055));
}

// The view that the frames are meant for, as rf_fill_view_cube (src/cli/view/view.h) has it: CUBE in each direction.
const CUBE = 33, CUBE_FROM = -9, CUBE_STOPS = 15;

// What is displayed of a colour at three places in the cube, 0 to CUBE - 1, by interpolation within a tetrahedron: along the axes in the
// order of the places within a cell.
function lookUp(cube, r, g, b, out) {
  const i = Math.min(r | 0, CUBE - 2), j = Math.min(g | 0, CUBE - 2), k = Math.min(b | 0, CUBE - 2);
  const x = r - i, y = g - j, z = b - k, first = 3 * (i + CUBE * (j + CUBE * k)), last = first + 3 * (1 + CUBE + CUBE * CUBE);
  const most = Math.max(x, y, z), least = Math.min(x, y, z), middle = x + y + z - most - least;
  const stepX = 3, stepY = 3 * CUBE, stepZ = 3 * CUBE * CUBE;
  const second = first + (most === x ? stepX : most === y ? stepY : stepZ), third = last - (least === z ? stepZ : least === y ? stepY : stepX);
  for (let c = 0; c < 3; ++c)
    out[c] = cube[first + c] * (1 - most) + cube[second + c] * (most - middle) + cube[third + c] * (middle - least) + cube[last + c] * least + 0.5;
}

// Shows scene light at an exposure in stops: by a view's cube, or without one (null) by a table of the sRGB curve.
class Tone {
  constructor(exposure, cube) {
    this.table = cube ? null : makeToneTable(exposure);
    if (this.table)
      return;
    this.cube = cube;
    this.bytes = new Uint8ClampedArray(4);
    this.place = new Float32Array(2 * HALF_TABLE);
    const gain = Math.pow(2, exposure);
    for (let i = 0; i < 2 * HALF_TABLE; ++i) {
      const level = Math.log2(Math.max(gain * s_lightOfLevel[i], 0) + FLOOR);
      this.place[i] = Math.min(Math.max((level - CUBE_FROM) / CUBE_STOPS, 0), 1) * (CUBE - 1);
    }
  }

  // Of levels to RGBA pixels.
  paint(levels, pixels) {
    const { table, cube, place, bytes } = this, count = levels.length / 3;
    for (let i = 0, from = 0; table && i < count; ++i, from += 3)
      pixels[i] = 0xff000000 | table[levels[from + 2] + HALF_TABLE] << 16 | table[levels[from + 1] + HALF_TABLE] << 8 | table[levels[from] + HALF_TABLE];
    for (let i = 0, from = 0; !table && i < count; ++i, from += 3) {
      lookUp(cube, place[levels[from] + HALF_TABLE], place[levels[from + 1] + HALF_TABLE], place[levels[from + 2] + HALF_TABLE], bytes);
      pixels[i] = 0xff000000 | bytes[2] << 16 | bytes[1] << 8 | bytes[0];
    }
  }
}

// The display byte for each level, at an exposure in stops.
function makeToneTable(exposure) {
  const table = new Uint8Array(2 * HALF_TABLE), gain = Math.pow(2, exposure);
  const low = -10 * STOP, high = 17 * STOP;
  for (let level = low; level < high; ++level)
    table[level + HALF_TABLE] = encodeSrgb(gain * (Math.pow(2, level / STOP) - FLOOR));
  table.fill(table[high - 1 + HALF_TABLE], high + HALF_TABLE);
  return table;
}

// The linear light of each level.
const s_lightOfLevel = new Float32Array(2 * HALF_TABLE);
for (let level = -HALF_TABLE; level < HALF_TABLE; ++level)
  s_lightOfLevel[level + HALF_TABLE] = Math.pow(2, Math.min(level / STOP, 17)) - FLOOR;

// The two cells whose centres enclose a pixel, and the share of the second, of 2 * cell.
function cellsAt(pixel, cell, count) {
  const place = 2 * pixel + 1 - cell, at = Math.floor(place / (2 * cell));
  return [Math.max(at, 0), Math.min(at + 1, count - 1), place - at * 2 * cell];
}

// Draws frames on a canvas.
class Painter {
  constructor(canvas) {
    this.context = canvas.getContext("2d", { alpha: false });
    this.scratch = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  }

  // Passes may be smaller than pictures.
  resize(width, height) {
    if (this.width === width && this.height === height)
      return;
    for (const context of [this.context, this.scratch])
      Object.assign(context.canvas, { width, height });
    this.width = width;
    this.height = height;
    this.levels = new Int16Array(3 * width * height);
    this.image = this.context.createImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
  }

  // Converts a decoded frame to levels, ready for tone mapping: the base, interpolated between the centres of cells, and the detail.
  take({ bitmap, cell, columns, rows, base }) {
    this.resize(bitmap.width, bitmap.height);
    const { width, height, levels } = this, span = 2 * cell, shift = 2 * Math.log2(span), half = 1 << (shift - 1);
    this.scratch.drawImage(bitmap, 0, 0);
    const detail = this.scratch.getImageData(0, 0, width, height).data, row = new Int32Array(3 * columns);
    for (let y = 0, to = 0, from = 0; y < height; ++y) {
      const [above, below, down] = cellsAt(y, cell, rows), upper = 3 * columns * above, lower = 3 * columns * below;
      for (let i = 0; i < row.length; ++i)
        row[i] = base[upper + i] * (span - down) + base[lower + i] * down;
      for (let x = 0; x < width;) {
        const [left, right, share] = cellsAt(x, cell, columns);
        for (let at = share; at < span && x < width; at += 2, ++x, ++from)
          for (let c = 0; c < 3; ++c, ++to, ++from)
            levels[to] = (row[3 * left + c] * (span - at) + row[3 * right + c] * at + half >> shift) + s_stepsOfByte[detail[from]];
      }
    }
  }

  // Keeps several decoded frames, of light groups, for mix().
  takeParts(frames) {
    this.parts = frames.map(frame => {
      this.take(frame);
      return this.levels.slice();
    });
  }

  // The sum of the parts with these factors.
  mix(factors) {
    const { levels, parts } = this;
    for (let i = 0; i < levels.length; ++i) {
      let light = 0;
      for (let k = 0; k < parts.length; ++k)
        light += factors[k] * s_lightOfLevel[parts[k][i] + HALF_TABLE];
      levels[i] = Math.round(STOP * Math.log2(Math.max(light, 0) + FLOOR));
    }
  }

  paint(tone) {
    tone.paint(this.levels, this.pixels);
    this.context.putImageData(this.image, 0, 0);
  }

  // The light of a pixel, as close as the encoding has it.
  lightAt(x, y) {
    const from = 3 * (y * this.width + x);
    return [0, 1, 2].map(c => s_lightOfLevel[this.levels[from + c] + HALF_TABLE]);
  }
}
