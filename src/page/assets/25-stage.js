// Zoom and position, shared by all panels, and the wipe between two of them.

const MOST_ZOOM = 64;

class Stage {
  // `panels`: { figure, stage, canvas, sequence }; onPoint( panel, x, y, how ) gets pixels of the file, how is "hover", "pin" or "leave".
  constructor(box, panels, onPoint) {
    Object.assign(this, { box, panels, onPoint, zoom: 1, x: 0.5, y: 0.5, layout: "side", pair: [0, Math.min(1, panels.length - 1)], split: 0.5 });
    this.pointers = new Map();
    this.divider = make("div", { id: "divider", tabIndex: 0, hidden: true });
    for (const [name, value] of Object.entries({ role: "slider", "aria-label": "Wipe between A and B", "aria-valuemin": 0, "aria-valuemax": 100, "aria-orientation": "horizontal" }))
      this.divider.setAttribute(name, value);
    box.append(this.divider);
    this.listenToDivider();
    for (const panel of panels)
      this.listen(panel);
    new ResizeObserver(() => this.place()).observe(box);
  }

  // CSS pixels of a pixel of the file, without zoom.
  fitOf(panel) {
    return Math.min(panel.stage.clientWidth / panel.sequence.file_width, panel.stage.clientHeight / panel.sequence.file_height);
  }

  place() {
    for (const panel of this.panels) {
      const { stage, canvas, sequence } = panel, scale = this.fitOf(panel) * this.zoom;
      const width = sequence.file_width * scale, height = sequence.file_height * scale;
      const put = (room, size, at) => size <= room ? (room - size) / 2 : Math.min(Math.max(room / 2 - at * size, room - size), 0);
      panel.left = put(stage.clientWidth, width, this.x);
      panel.top = put(stage.clientHeight, height, this.y);
      panel.scale = scale;
      Object.assign(canvas.style, { width: `${width}px`, height: `${height}px`, transform: `translate(${panel.left}px, ${panel.top}px)` });
      canvas.classList.toggle("pixels", scale * devicePixelRatio >= 2);
      stage.classList.toggle("zoomed", this.zoom > 1);
      this.placeMark(panel);
    }
    this.divider.style.height = `${this.panels[this.pair[0]].stage.clientHeight}px`;
    if (this.onPlace)
      this.onPlace(this);
  }

  // The cross at the probed pixel.
  mark(u, v) {
    this.marked = u === null ? null : [u, v];
    this.panels.forEach(panel => this.placeMark(panel));
  }

  placeMark(panel) {
    const { cross, sequence } = panel;
    cross.hidden = !this.marked;
    if (!this.marked)
      return;
    const size = Math.max(panel.scale, 7), x = Math.floor(this.marked[0] * sequence.file_width) + 0.5, y = Math.floor(this.marked[1] * sequence.file_height) + 0.5;
    Object.assign(cross.style, { width: `${size}px`, height: `${size}px`, transform: `translate(${panel.left + x * panel.scale - size / 2}px, ${panel.top + y * panel.scale - size / 2}px)` });
  }

  // Relative place in the picture, of a pointer.
  placeOf(panel, event) {
    const box = panel.stage.getBoundingClientRect();
    return [(event.clientX - box.left - panel.left) / (panel.scale * panel.sequence.file_width), (event.clientY - box.top - panel.top) / (panel.scale * panel.sequence.file_height)];
  }

  // The zoom that shows one pixel of the file on one of the display.
  pixelZoom() {
    return 1 / (this.fitOf(this.panels[this.shownPanels()[0]]) * devicePixelRatio);
  }

  // Zooms about a relative place, which stays where it is; not below what fits, unless pixels are smaller.
  zoomTo(zoom, u = this.x, v = this.y) {
    const next = Math.min(Math.max(zoom, Math.min(1, this.pixelZoom())), MOST_ZOOM), share = this.zoom / next;
    this.x = u + (this.x - u) * share;
    this.y = v + (this.y - v) * share;
    this.zoom = next;
    this.keepInside();
  }

  keepInside() {
    const half = 0.5 / Math.max(this.zoom, 1);
    this.x = Math.min(Math.max(this.x, half), 1 - half);
    this.y = Math.min(Math.max(this.y, half), 1 - half);
    this.place();
  }

  pan(panel, dx, dy) {
    this.x -= dx / (panel.scale * panel.sequence.file_width);
    this.y -= dy / (panel.scale * panel.sequence.file_height);
    this.keepInside();
  }

  listen(panel) {
    const { stage } = panel;
    stage.addEventListener("pointerdown", event => this.press(panel, event));
    stage.addEventListener("pointermove", event => this.move(panel, event));
    for (const name of ["pointerup", "pointercancel"])
      stage.addEventListener(name, event => this.release(panel, event, name === "pointerup"));
    stage.addEventListener("pointerleave", () => this.onPoint(panel, 0, 0, "leave"));
    stage.addEventListener("mousedown", event => event.preventDefault()); // keeps the focus, and with it the arrow keys, where they were
    stage.addEventListener("dblclick", event => this.zoom > 1 ? this.zoomTo(1) : this.zoomTo(Math.max(this.pixelZoom(), 2), ...this.placeOf(panel, event)));
    stage.addEventListener("wheel", event => {
      if (!event.ctrlKey && !event.metaKey)
        return;
      event.preventDefault();
      this.zoomTo(this.zoom * 2 ** (-event.deltaY / 120), ...this.placeOf(panel, event));
    }, { passive: false });
  }

  press(panel, event) {
    panel.stage.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, moved: 0 });
  }

  move(panel, event) {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) {
      this.onPoint(panel, ...this.placeOf(panel, event), "hover");
      return;
    }
    const dx = event.clientX - pointer.x, dy = event.clientY - pointer.y;
    const others = [...this.pointers.entries()].filter(([id]) => id !== event.pointerId).map(entry => entry[1]);
    if (others.length > 0) { // pinch
      const before = Math.hypot(pointer.x - others[0].x, pointer.y - others[0].y), now = Math.hypot(event.clientX - others[0].x, event.clientY - others[0].y);
      if (before > 0)
        this.zoomTo(this.zoom * now / before, ...this.placeOf(panel, { clientX: others[0].x, clientY: others[0].y }));
      others[0].moved += 10;
    } else if (this.zoom > 1)
      this.pan(panel, dx, dy);
    Object.assign(pointer, { x: event.clientX, y: event.clientY, moved: pointer.moved + Math.abs(dx) + Math.abs(dy) });
  }

  // A press that did not move pins the probe.
  release(panel, event, isUp) {
    const pointer = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (isUp && pointer && pointer.moved < 5)
      this.onPoint(panel, ...this.placeOf(panel, event), "pin");
  }

  listenToDivider() {
    const { divider } = this;
    divider.addEventListener("pointerdown", event => divider.setPointerCapture(event.pointerId));
    divider.addEventListener("pointermove", event => {
      const box = this.box.getBoundingClientRect();
      if (divider.hasPointerCapture(event.pointerId))
        this.setSplit((event.clientX - box.left) / box.width);
    });
    divider.addEventListener("keydown", event => {
      const step = { ArrowLeft: -0.02, ArrowRight: 0.02, ArrowDown: -0.02, ArrowUp: 0.02, PageDown: -0.1, PageUp: 0.1, Home: -1, End: 1 }[event.key];
      if (step === undefined)
        return;
      event.preventDefault();
      event.stopPropagation();
      this.setSplit(this.split + step);
    });
  }

  setSplit(share) {
    this.split = Math.min(Math.max(share, 0), 1);
    this.box.style.setProperty("--split", `${100 * this.split}%`);
    this.divider.setAttribute("aria-valuenow", Math.round(100 * this.split));
  }

  shownPanels() {
    return this.layout === "wipe" ? this.pair : this.panels.map((panel, i) => i);
  }

  // "side": all panels side by side; "wipe": one over the other, with a divider.
  setLayout(layout, pair = this.pair) {
    this.layout = layout;
    this.pair = pair;
    const wipes = layout === "wipe";
    this.box.classList.toggle("wipe", wipes);
    this.divider.hidden = !wipes;
    this.panels.forEach((panel, i) => {
      panel.figure.hidden = wipes && !pair.includes(i);
      panel.figure.classList.toggle("over", wipes && pair[1] === i && pair[0] !== i);
    });
    this.setSplit(this.split);
    this.place();
  }
}
