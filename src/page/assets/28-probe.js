// The pixel probe: scene values of all shown sequences at the place that is pointed at.

function formatValue(value) {
  if (Number.isNaN(value))
    return "NaN";
  if (!Number.isFinite(value))
    return value > 0 ? "infinite" : "-infinite";
  const size = Math.abs(value);
  if (size >= 65504)
    return value > 0 ? "65504 or more" : "-65504 or less";
  return size !== 0 && (size >= 1e5 || size < 1e-3) ? value.toExponential(2).replace("e+", "e") : String(Number(value.toPrecision(4)));
}

class Probe {
  constructor(box, data, player, stage) {
    Object.assign(this, { box, data, player, stage, place: null, pinned: false, values: new SceneValues(data), names: new MatteNames() });
    this.where = make("p", { className: "where" });
    this.rows = data.sequences.map((sequence, index) => this.makeRow(sequence, index));
    this.note = make("p", { className: "note" });
    box.append(this.where, make("div", { className: "values" }, ...this.rows.map(row => row.element)), this.note);
    this.show();
  }

  makeRow(sequence, index) {
    const parts = { swatch: make("i", {}), light: make("b", {}), near: make("span", {}) };
    const name = make("span", { className: "name", textContent: sequence.name });
    name.style.setProperty("--mark", colorOf(index));
    return { ...parts, element: make("div", {}, name, parts.swatch, parts.light, parts.near) };
  }

  // A place by shares of the picture's width and height.
  point(u, v, how) {
    if (how === "leave" || !(u >= 0 && u < 1 && v >= 0 && v < 1)) {
      if (!this.pinned)
        this.clear();
      return;
    }
    if (how === "hover" && this.pinned)
      return;
    const again = how === "pin" && this.pinned && this.isSame(u, v);
    this.pinned = how !== "hover" && !again;
    this.box.setAttribute("aria-live", how === "keys" ? "polite" : "off");
    this.place = [u, v];
    this.show();
  }

  isSame(u, v) {
    const { file_width, file_height } = this.data.sequences[0];
    return Math.abs(u - this.place[0]) * file_width < 2 && Math.abs(v - this.place[1]) * file_height < 2;
  }

  clear() {
    this.place = null;
    this.pinned = false;
    this.show();
  }

  // By the arrow keys: pixels of the first sequence.
  step(dx, dy) {
    const { file_width, file_height } = this.data.sequences[0], [u, v] = this.place || [0.5, 0.5];
    const move = (share, by, size) => (Math.min(Math.max(Math.floor(share * size) + by, 0), size - 1) + 0.5) / size;
    this.point(move(u, this.place ? dx : 0, file_width), move(v, this.place ? dy : 0, file_height), "keys");
  }

  show() {
    this.box.classList.toggle("empty", this.place === null);
    this.stage.mark(...(this.place || [null, null]));
    if (this.place === null) {
      this.where.textContent = "Point at a pixel, or tap it, for its scene values";
      this.note.textContent = "";
      this.rows.forEach(row => row.element.hidden = true);
      return;
    }
    const { file_width, file_height } = this.data.sequences[0];
    this.where.textContent = `Pixel ${Math.floor(this.place[0] * file_width)}, ${Math.floor(this.place[1] * file_height)}${this.pinned ? " \u00b7 pinned" : ""}`;
    const shown = this.stage.shownPanels(), factors = new Set();
    this.rows.forEach((row, i) => {
      row.element.hidden = !shown.includes(i);
      if (!row.element.hidden)
        this.fill(row, this.player.panels[i], factors);
    });
    const coarse = [...factors].filter(factor => factor > 1);
    this.note.textContent = factors.size === 0 ? "Scene values are not in this page: report --values puts them in."
      : coarse.length > 0 ? `Linear values of the file, the mean of ${coarse.map(factor => `${factor}x${factor}`).join(" or ")} pixels; \u2248 is this pixel, nearly, from the picture. Frame ${this.data.sequences[0].fine_frame || "\u2013"} has finer ones, report --values more.`
        : "Linear values of the file, in half precision.";
  }

  fill(row, panel, factors) {
    const { sequence, painter } = panel, index = this.player.shown, view = this.player.view;
    const x = Math.floor(this.place[0] * sequence.file_width), y = Math.floor(this.place[1] * sequence.file_height);
    const probed = index >= 0 ? this.values.at(sequence, index, x, y) : null;
    const source = index >= 0 ? panel.source(view, index) : null, near = [];
    if (probed)
      factors.add(probed.factor);
    if (source) {
      const column = Math.min(Math.floor(this.place[0] * painter.width), painter.width - 1), row = Math.min(Math.floor(this.place[1] * painter.height), painter.height - 1);
      const light = painter.lightAt(column, row), name = isPictureView(view) ? null : this.names.at(source, column, row);
      if (name !== null)
        near.push(name !== "" ? `${view}: ${name}` : `${view}: nothing`);
      else if (!isPictureView(view))
        near.push(`${view} \u2248 ${valuesOfLayer(source.layer, light).map(value => Number.isFinite(value) ? formatNumber(value) : "nothing").join("  ")}`);
      else if (!probed || probed.factor > 1)
        near.push(`\u2248 ${light.map(formatNumber).join("  ")}`);
    }
    row.light.textContent = probed ? probed.light.map(formatValue).join("  ") : "";
    row.light.title = probed ? "red, green, blue" : "";
    row.near.textContent = near.join("   ");
    row.element.dataset.factor = probed ? probed.factor : "";
    const bytes = probed ? showLight(probed.light.map(value => 2 ** this.player.exposure * value), this.player.curve, this.player.cube) : [0, 0, 0];
    row.swatch.style.background = `rgb(${bytes.join(" ")})`;
  }
}
