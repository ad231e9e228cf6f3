// Line charts, as SVG.

function makeSvg(name, attributes, parent) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes)
    element.setAttribute(key, attributes[key]);
  if (parent)
    parent.append(element);
  return element;
}

function make(name, attributes, ...children) {
  const element = document.createElement(name);
  Object.assign(element, attributes);
  element.append(...children);
  return element;
}

function formatNumber(value) {
  if (value === null || value === undefined || !Number.isFinite(value))
    return "\u2013";
  const size = Math.abs(value);
  if (size === 0)
    return "0";
  if (size >= 1e6 || size < 1e-4)
    return value.toExponential(1).replace("e+", "e");
  return String(Number(value.toPrecision(3)));
}

// An axis: { at( value ): 0 to 1, ticks }
function makeScale(low, high, wantsLog) {
  if (!(high > low)) {
    const pad = Math.abs(low) > 0 ? 0.5 * Math.abs(low) : 1;
    low -= pad;
    high += pad;
    wantsLog = wantsLog && low > 0;
  }
  if (wantsLog && low > 0) {
    const a = Math.log10(low) - 0.05 * Math.log10(high / low) - 0.02, b = Math.log10(high) + 0.05 * Math.log10(high / low) + 0.02;
    const steps = b - a < 0.7 ? [1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9] : b - a < 1.6 ? [1, 2, 5] : b - a < 3 ? [1, 3] : [1], ticks = [];
    for (let decade = Math.floor(a); decade <= b; ++decade)
      for (const step of steps) {
        const value = step * 10 ** decade;
        if (Math.log10(value) >= a && Math.log10(value) <= b)
          ticks.push(value);
      }
    return { at: value => (Math.log10(value) - a) / (b - a), ticks };
  }
  const pad = 0.06 * (high - low);
  const a = low >= 0 && low < 0.5 * high ? 0 : low - pad, b = high + pad;
  const rough = (b - a) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map(factor => factor * power).find(size => size >= rough);
  const ticks = [];
  for (let i = Math.ceil(a / step); i * step <= b; ++i)
    ticks.push(i * step);
  return { at: value => (value - a) / (b - a), ticks };
}

function rangeOf(values) {
  const finite = values.filter(value => value !== null && Number.isFinite(value));
  return finite.length > 0 ? [Math.min(...finite), Math.max(...finite)] : null;
}

const CHART_HEIGHT = 210, MARGIN = { left: 58, right: 14, top: 8, bottom: 32 };

class Chart {
  // series: { name, color, points: [[ x, y ], ...] }; y null is a gap. `seek( x )` is called on clicks and drags.
  constructor(parent, { title, note, series, xLabel, xLog, yLog, dots, seek, id, explains }) {
    Object.assign(this, { series, xLabel, xLog, yLog, dots, seek });
    this.svg = makeSvg("svg", { role: "img", "aria-label": title });
    this.legend = make("div", { className: "legend" });
    const explanation = explains ? makeExplanation(explains) : null;
    this.element = make("div", { className: seek ? "chart seeks" : "chart", id },
      make("div", { className: "chart-title" }, make("h2", { textContent: title }), ...(explanation ? [explanation.button] : [])),
      ...(explanation ? [explanation.words] : []), make("p", { textContent: note || "" }), this.legend, this.svg);
    parent.append(this.element);
    this.readouts = series.map(one => {
      const readout = make("b", {}), mark = make("i", {});
      mark.style.background = one.color;
      this.legend.append(make("span", {}, mark, one.name, readout));
      return readout;
    });
    if (seek)
      this.listen();
    new ResizeObserver(() => this.draw()).observe(this.svg);
  }

  listen() {
    const go = event => {
      const box = this.svg.getBoundingClientRect();
      const share = (event.clientX - box.left - MARGIN.left) / (box.width - MARGIN.left - MARGIN.right);
      let best = null;
      for (const x of this.xs)
        if (best === null || Math.abs(this.x.at(x) - share) < Math.abs(this.x.at(best) - share))
          best = x;
      this.seek(best);
    };
    this.svg.addEventListener("pointerdown", event => {
      this.svg.setPointerCapture(event.pointerId);
      go(event);
    });
    this.svg.addEventListener("pointermove", event => {
      if (event.buttons & 1)
        go(event);
    });
  }

  px(value) { return MARGIN.left + this.x.at(value) * (this.width - MARGIN.left - MARGIN.right); }
  py(value) { return CHART_HEIGHT - MARGIN.bottom - this.y.at(value) * (CHART_HEIGHT - MARGIN.top - MARGIN.bottom); }

  draw() {
    const points = this.series.flatMap(one => one.points), xRange = rangeOf(points.map(point => point[0]));
    const yRange = rangeOf(points.map(point => point[1]));
    this.width = this.svg.clientWidth;
    if (this.width < 100 || !xRange || !yRange)
      return;
    this.xs = [...new Set(points.map(point => point[0]))].sort((a, b) => a - b);
    this.x = this.xLog ? makeScale(...xRange, true) : { at: value => xRange[1] > xRange[0] ? (value - xRange[0]) / (xRange[1] - xRange[0]) : 0.5, ticks: frameTicks(...xRange) };
    this.y = makeScale(...yRange, this.yLog === true || (this.yLog === undefined && yRange[0] > 0 && yRange[1] > 8 * yRange[0]));
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${CHART_HEIGHT}`);
    this.svg.replaceChildren();
    this.drawAxes();
    for (const one of this.series)
      this.drawSeries(one);
    this.cursor = this.seek ? makeSvg("line", { class: "cursor", y1: MARGIN.top, y2: CHART_HEIGHT - MARGIN.bottom }, this.svg) : null;
    if (this.cursor && this.current !== undefined)
      this.mark(this.current);
  }

  drawAxes() {
    const bottom = CHART_HEIGHT - MARGIN.bottom;
    for (const tick of this.y.ticks) {
      const y = this.py(tick);
      makeSvg("line", { class: "grid", x1: MARGIN.left, x2: this.width - MARGIN.right, y1: y, y2: y }, this.svg);
      makeSvg("text", { x: MARGIN.left - 7, y: y + 4, "text-anchor": "end" }, this.svg).textContent = formatNumber(tick);
    }
    for (const tick of this.x.ticks)
      makeSvg("text", { x: this.px(tick), y: bottom + 15, "text-anchor": "middle" }, this.svg).textContent = formatNumber(tick);
    makeSvg("text", { x: this.width - MARGIN.right, y: CHART_HEIGHT - 3, "text-anchor": "end" }, this.svg).textContent = this.xLabel;
  }

  drawSeries(one) {
    let path = "", open = false;
    for (const [x, y] of one.points) {
      const seen = y !== null && Number.isFinite(y);
      if (seen)
        path += `${open ? "L" : "M"}${this.px(x).toFixed(1)} ${this.py(y).toFixed(1)}`;
      open = seen;
      if (seen && (this.dots || one.points.length < 2))
        makeSvg("circle", { cx: this.px(x), cy: this.py(y), r: 3, style: `fill:${one.color}` }, this.svg);
    }
    makeSvg("path", { class: "curve", d: path, style: `stroke:${one.color}` }, this.svg);
  }

  // Marks the current frame.
  mark(x) {
    this.current = x;
    this.series.forEach((one, i) => {
      const point = one.points.find(candidate => candidate[0] === x);
      this.readouts[i].textContent = formatNumber(point ? point[1] : null);
    });
    if (!this.cursor)
      return;
    const at = Math.min(Math.max(this.px(x), MARGIN.left), this.width - MARGIN.right);
    this.cursor.setAttribute("x1", at);
    this.cursor.setAttribute("x2", at);
  }
}

function frameTicks(first, last) {
  const step = [1, 2, 5, 10, 20, 25, 50, 100, 200, 250, 500, 1000, 2000, 5000, 10000, 100000].find(size => (last - first) / size <= 9) || 1e6;
  const ticks = [];
  for (let i = Math.ceil(first / step); i * step <= last; ++i)
    ticks.push(i * step);
  return ticks;
}
