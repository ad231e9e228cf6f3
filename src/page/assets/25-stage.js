// Zoom and place of the pictures, which all panels share, and the wipe between two of them. A stage scrolls its picture.

const MOST_ZOOM = 64;

class Stage {
  // `panels`: { figure, stage, content, cross, sequence }; onPoint( u, v, how ) gets shares of the picture's width and height, how is
  // "hover", "pin" or "leave"; onZoom() follows each change.
  constructor(box, panels, onPoint, onZoom) {
    Object.assign(this, { box, panels, onPoint, onZoom, zoom: 1, layout: "side", pair: [0, 1], leader: panels[0] });
    panels.forEach(panel => this.listen(panel));
    new ResizeObserver(() => this.zoomTo(this.zoom)).observe(box);
  }

  shownPanels() {
    return this.layout === "wipe" ? this.pair : this.panels.map((panel, i) => i);
  }

  // Pixels of the display for one of the file.
  scale() {
    const { content, sequence } = this.panels[this.shownPanels()[0]];
    return content.clientWidth / sequence.file_width * devicePixelRatio;
  }

  // The zoom that shows one pixel of the file on one of the display.
  pixelZoom() {
    return this.zoom / this.scale();
  }

  // Zooms about a place of the screen, which stays where it is; not below what fits, unless pixels are smaller.
  zoomTo(zoom, panel = this.panels[this.shownPanels()[0]], event = null) {
    const { stage, content } = this.leader = panel;
    const before = content.getBoundingClientRect(), box = stage.getBoundingClientRect();
    const x = event ? event.clientX : box.left + box.width / 2, y = event ? event.clientY : box.top + box.height / 2;
    const u = (x - before.left) / before.width, v = (y - before.top) / before.height;
    this.zoom = Math.min(Math.max(zoom, Math.min(1, this.pixelZoom())), MOST_ZOOM);
    this.box.style.setProperty("--zoom", this.zoom);
    this.box.classList.toggle("pixels", this.scale() >= 2);
    const after = content.getBoundingClientRect();
    stage.scrollBy(after.left + u * after.width - x, after.top + v * after.height - y);
    this.onZoom();
  }

  placeOf({ content }, event) {
    const box = content.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  listen(panel) {
    const { stage, content } = panel;
    let moved = 0;
    stage.addEventListener("pointerdown", () => {
      this.leader = panel;
      moved = 0;
    });
    stage.addEventListener("pointermove", event => {
      if (event.buttons === 0 || event.pointerType === "touch") {
        this.onPoint(...this.placeOf(panel, event), "hover");
        return;
      }
      moved += Math.abs(event.movementX) + Math.abs(event.movementY);
      stage.scrollBy(-event.movementX, -event.movementY);
    });
    stage.addEventListener("click", event => moved < 5 && this.onPoint(...this.placeOf(panel, event), "pin"));
    stage.addEventListener("pointerleave", () => this.onPoint(0, 0, "leave"));
    stage.addEventListener("mousedown", event => event.preventDefault()); // keeps the focus, and with it the arrow keys, where they were
    stage.addEventListener("dblclick", event => this.zoomTo(this.zoom > 1 ? 1 : Math.max(this.pixelZoom(), 2), panel, event));
    stage.addEventListener("wheel", event => {
      if (!event.ctrlKey && !event.metaKey)
        return;
      event.preventDefault();
      this.zoomTo(this.zoom * 2 ** (-event.deltaY / 120), panel, event);
    }, { passive: false });
    stage.addEventListener("scroll", () => {
      if (this.leader !== panel) // else the panels would answer each other
        return;
      const x = stage.scrollLeft / content.clientWidth, y = stage.scrollTop / content.clientHeight;
      for (const other of this.panels.filter(other => other !== panel))
        other.stage.scrollTo(x * other.content.clientWidth, y * other.content.clientHeight);
    });
  }

  // The cross at the probed pixel; null: none.
  mark(place) {
    for (const { cross, sequence: { file_width, file_height } } of this.panels) {
      const middle = (share, size) => `${100 * (Math.floor(share * size) + 0.5) / size}%`, [u, v] = place || [0, 0];
      cross.hidden = place === null;
      Object.assign(cross.style, { left: middle(u, file_width), top: middle(v, file_height), width: `${100 / file_width}%` });
    }
  }

  // "side": all panels side by side; "wipe": two over each other, with a divider.
  setLayout(layout, pair = this.pair) {
    Object.assign(this, { layout, pair });
    const wipes = layout === "wipe";
    this.box.classList.toggle("wipe", wipes);
    this.panels.forEach(({ figure }, i) => {
      figure.hidden = wipes && !pair.includes(i);
      figure.classList.toggle("over", wipes && pair[1] === i && pair[0] !== i);
    });
    this.zoomTo(this.zoom);
  }
}
