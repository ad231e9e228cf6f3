// Line charts over the frames, as SVG, and what makes elements and numbers.

function make(name, attributes, ...children) {
  const element = document.createElement(name);
  Object.assign(element, attributes);
  element.append(...children);
  return element;
}

function makeSvg(name, attributes, parent) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes)
    element.setAttribute(key, attributes[key]);
  if (parent)
    parent.append(element);
  return element;
}

// To `digits`; what is no number is a dash.
function formatNumber(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value))
    return "\u2013";
  const size = Math.abs(value);
  return size !== 0 && (size >= 1e6 || size < 1e-4) ? value.toExponential(1).replace("e+", "e") : String(Number(value.toPrecision(digits)));
}

// Of a half float, which ends at 65504.
const formatValue = value => Number.isFinite(value) ? `${formatNumber(value, 4)}${Math.abs(value) >= 65504 ? " or beyond" : ""}` : String(value);

const WIDTH = 520, HEIGHT = 200, MARGIN = { left: 62, right: 12, top: 8, bottom: 24 };

// The smallest of the steps 1, 2, 2.5, 5 times a power of ten that is no less.
function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 2.5, 5, 10].map(factor => factor * power).find(step => step >= least * 0.999);
}

function multiples(step, low, high) {
  return Array.from({ length: Math.floor(high / step) - Math.ceil(low / step) + 1 }, (nothing, i) => (Math.ceil(low / step) + i) * step);
}

// An axis: { at( value ): 0 to 1, ticks }; of values that span much by the logarithm.
function makeScale(low, high) {
  const pad = high > low ? 0.06 * (high - low) : 0.5 * Math.abs(low) || 1;
  if (low > 0 && high > 8 * low) {
    const a = Math.log10(low) - 0.05, b = Math.log10(high) + 0.05, steps = b - a < 1.6 ? [1, 2, 5] : b - a < 3 ? [1, 3] : [1];
    const ticks = multiples(1, Math.floor(a), b).flatMap(decade => steps.map(step => step * 10 ** decade)).filter(tick => tick >= 10 ** a && tick <= 10 ** b);
    return { at: value => (Math.log10(value) - a) / (b - a), ticks };
  }
  const a = low >= 0 && low < 0.5 * high ? 0 : low - pad, b = high + pad;
  return { at: value => (value - a) / (b - a), ticks: multiples(roundStep((b - a) / 5), a, b) };
}

class Chart {
  // series: { name, color, values }, a value for each frame, null: a gap. `seek( index )` is called on clicks and drags.
  constructor(parent, { id, title, series, frames, seek }) {
    const known = series.flatMap(one => one.values).filter(value => value !== null), first = frames[0], last = frames[frames.length - 1];
    const y = makeScale(Math.min(...known), Math.max(...known));
    this.px = number => MARGIN.left + (last > first ? (number - first) / (last - first) : 0.5) * (WIDTH - MARGIN.left - MARGIN.right);
    this.py = value => HEIGHT - MARGIN.bottom - y.at(value) * (HEIGHT - MARGIN.top - MARGIN.bottom);
    Object.assign(this, { series, frames });
    this.svg = makeSvg("svg", { role: "img", "aria-label": title, viewBox: `0 0 ${WIDTH} ${HEIGHT}` });
    this.readouts = series.map(() => make("b", {}));
    const legend = make("div", { className: "legend" }, ...series.map((one, i) => make("span", {}, mark(one.color), one.name, " ", this.readouts[i])));
    parent.append(make("div", { className: "chart card", id }, make("h2", { textContent: title }), legend, this.svg));
    for (const tick of y.ticks) {
      makeSvg("line", { class: "grid", x1: MARGIN.left, x2: WIDTH - MARGIN.right, y1: this.py(tick), y2: this.py(tick) }, this.svg);
      this.write(formatNumber(tick), MARGIN.left - 7, this.py(tick) + 4, "end");
    }
    for (const tick of multiples(Math.max(1, roundStep((last - first) / 8 || 1)), first, last).filter(Number.isInteger))
      this.write(String(tick), this.px(tick), HEIGHT - MARGIN.bottom + 16, "middle");
    series.forEach(one => this.draw(one));
    this.cursor = makeSvg("line", { class: "cursor", y1: MARGIN.top, y2: HEIGHT - MARGIN.bottom }, this.svg);
    const go = event => {
      const box = this.svg.getBoundingClientRect(), x = (event.clientX - box.left) / box.width * WIDTH, off = i => Math.abs(this.px(frames[i]) - x);
      seek(frames.reduce((best, number, i) => off(i) < off(best) ? i : best, 0));
    };
    this.svg.addEventListener("pointerdown", go);
    this.svg.addEventListener("pointermove", event => event.buttons & 1 && go(event));
  }

  write(text, x, y, anchor) {
    makeSvg("text", { x, y, "text-anchor": anchor }, this.svg).textContent = text;
  }

  draw({ color, values }) {
    let path = "";
    values.forEach((value, i) => {
      if (value === null)
        return;
      path += `${i > 0 && values[i - 1] !== null ? "L" : "M"}${this.px(this.frames[i]).toFixed(1)} ${this.py(value).toFixed(1)}`;
      if (values.length < 60)
        makeSvg("circle", { cx: this.px(this.frames[i]), cy: this.py(value), r: 2.5, style: `fill:${color}` }, this.svg);
    });
    makeSvg("path", { class: "curve", d: path, style: `stroke:${color}` }, this.svg);
  }

  // Marks a frame, and tells its values.
  mark(index) {
    this.series.forEach((one, i) => this.readouts[i].textContent = formatNumber(one.values[index]));
    for (const end of ["x1", "x2"])
      this.cursor.setAttribute(end, this.px(this.frames[index]));
  }
}
