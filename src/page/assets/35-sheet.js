// The contact sheet: all frames of a sequence as small pictures, decoded when they come into view.

const THUMB_WIDTH = 192;

// Levels of a decoded frame at a smaller size. The detail is averaged in stops, which is near enough for so small a picture.
function shrinkFrame(frame, width, height, context) {
  Object.assign(context.canvas, { width, height });
  context.drawImage(frame.bitmap, 0, 0, width, height);
  const detail = context.getImageData(0, 0, width, height).data, levels = new Int16Array(3 * width * height);
  const { cell, columns, rows, base } = frame;
  for (let y = 0, to = 0; y < height; ++y) {
    const down = Math.min(Math.max((y + 0.5) * frame.bitmap.height / height / cell - 0.5, 0), rows - 1), row = Math.floor(down);
    const upper = 3 * columns * row, lower = 3 * columns * Math.min(row + 1, rows - 1), v = down - row;
    for (let x = 0; x < width; ++x) {
      const across = Math.min(Math.max((x + 0.5) * frame.bitmap.width / width / cell - 0.5, 0), columns - 1), column = Math.floor(across);
      const left = 3 * column, right = 3 * Math.min(column + 1, columns - 1), u = across - column;
      for (let c = 0; c < 3; ++c, ++to) {
        const top = base[upper + left + c] * (1 - u) + base[upper + right + c] * u, bottom = base[lower + left + c] * (1 - u) + base[lower + right + c] * u;
        levels[to] = top * (1 - v) + bottom * v + s_stepsOfByte[detail[4 * (to - c) / 3 + c]];
      }
    }
  }
  return levels;
}

class ContactSheet {
  // `player` shows the frame that is chosen.
  constructor(data, player) {
    Object.assign(this, { data, player, sequence: 0, queue: [], busy: false });
    this.list = document.getElementById("sheet-frames");
    this.scratch = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
    this.observer = new IntersectionObserver(entries => {
      for (const entry of entries)
        if (entry.isIntersecting)
          this.want(entry.target);
    }, { rootMargin: "200px" });
    const select = document.getElementById("sheet-sequence");
    data.sequences.forEach((sequence, index) => select.append(make("option", { value: index, textContent: sequence.name })));
    select.parentElement.hidden = data.sequences.length < 2;
    select.addEventListener("change", () => this.build(Number(select.value)));
    document.getElementById("sheet").hidden = data.frames.length < 2;
    this.build(0);
  }

  build(index) {
    this.sequence = index;
    this.observer.disconnect();
    this.queue = [];
    const sequence = this.data.sequences[index], known = sequence.relmse.filter(value => value !== null), most = Math.max(...known, 0);
    this.cells = this.data.frames.map((number, i) => this.makeCell(sequence, number, i, most));
    this.list.replaceChildren(...this.cells.map(cell => make("li", {}, cell.button)));
    this.cells.forEach(cell => this.observer.observe(cell.button));
    this.markCurrent();
  }

  makeCell(sequence, number, i, most) {
    const width = Math.min(THUMB_WIDTH, sequence.width), height = Math.max(1, Math.round(width * sequence.height / sequence.width));
    const canvas = make("canvas", { width, height }), error = sequence.relmse[i];
    const isWorst = this.data.verdict.worst_frame === number && this.data.verdict.worst_sequence === this.sequence;
    const label = make("span", {}, String(number), ...(isWorst ? [make("em", { textContent: "worst" })] : []));
    const button = make("button", { type: "button", className: "thumb" }, canvas, label);
    const status = sequence.blocks[i] === null ? ", missing" : error !== null ? `, relMSE ${formatNumber(error)}` : "";
    button.setAttribute("aria-label", `Frame ${number}${status}${isWorst ? ", the worst" : ""}`);
    button.title = button.getAttribute("aria-label");
    if (error !== null && most > 0)
      label.style.setProperty("--error", `${100 * error / most}%`);
    button.classList.toggle("missing", sequence.blocks[i] === null);
    button.addEventListener("click", () => this.player.seek(i).catch(showFailure));
    return { button, canvas, id: sequence.blocks[i], levels: null };
  }

  want(button) {
    const cell = this.cells.find(candidate => candidate.button === button);
    if (cell && cell.id !== null && cell.levels === null && !this.queue.includes(cell))
      this.queue.push(cell);
    if (!this.busy)
      this.work().catch(showFailure);
  }

  // One at a time, so that the player comes first.
  async work() {
    this.busy = true;
    try {
      for (let cell = this.queue.shift(); cell; cell = this.queue.shift()) {
        const frame = await decodeFrame(cell.id);
        cell.levels = shrinkFrame(frame, cell.canvas.width, cell.canvas.height, this.scratch);
        frame.bitmap.close();
        this.paintCell(cell, this.player.makeTone());
      }
    } finally {
      this.busy = false;
    }
  }

  paintCell(cell, tone) {
    const context = cell.canvas.getContext("2d", { alpha: false }), image = context.createImageData(cell.canvas.width, cell.canvas.height);
    tone.paint(cell.levels, new Uint32Array(image.data.buffer));
    context.putImageData(image, 0, 0);
    cell.button.dataset.painted = "yes";
  }

  // After a change of exposure or curve.
  repaint() {
    const key = `${this.player.exposure} ${this.player.curve}`;
    if (key === this.painted)
      return;
    this.painted = key;
    const tone = this.player.makeTone();
    this.cells.filter(cell => cell.levels !== null).forEach(cell => this.paintCell(cell, tone));
  }

  markCurrent() {
    this.cells.forEach((cell, i) => {
      if (i === this.player.index)
        cell.button.setAttribute("aria-current", "true");
      else
        cell.button.removeAttribute("aria-current");
    });
  }
}
