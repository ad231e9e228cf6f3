// Panels of the sequences, and charts over their frames.

function showFailure(error) {
  const line = document.getElementById("failure");
  line.textContent = `Something went wrong on this page: ${error && error.message || error}`;
  line.hidden = false;
  console.error(error);
}

const colorOf = index => `var(--series-${index % 6})`;

// What a view shows of a frame of a sequence: { ids, width, height, layer, groups }, or null. The mix has a block for each light group.
function sourceOf(sequence, data, view, i) {
  if (sequence.blocks[i] === null)
    return null;
  if (isPictureView(view))
    return { ids: [sequence.blocks[i]], width: sequence.width, height: sequence.height };
  const mixes = view === "mix" && sequence.mixes, shown = sequence.layers.filter(layer => mixes ? layer.group : layer.name === view);
  if (shown.length === 0 || !sequence.has_layers[i])
    return null;
  const ids = shown.map(layer => `l${sequence.index}-${sequence.layers.indexOf(layer)}-${data.frames[i]}`), { width, height } = shown[0];
  return mixes ? { ids, width, height, layer: { name: "mix", look: "light" }, groups: shown.map(layer => layer.name) } : { ids: ids.slice(0, 1), width, height, layer: shown[0] };
}

function makePanel(sequence, index, data) {
  const canvas = make("canvas", {}), missing = make("p", { hidden: true }), cross = make("span", { className: "cross", hidden: true });
  const name = make("strong", { textContent: sequence.name, title: sequence.path }), words = make("span", {}), bad = make("span", { className: "bad" });
  const caption = make("figcaption", {}, name, words, bad);
  caption.style.setProperty("--mark", colorOf(index));
  const stage = make("div", { className: "stage", tabIndex: 0 }, canvas, cross, missing);
  stage.style.aspectRatio = `${sequence.file_width} / ${sequence.file_height}`;
  stage.setAttribute("role", "group");
  stage.setAttribute("aria-label", `Picture of ${sequence.name}: arrow keys move the probe, plus and minus zoom`);
  const figure = make("figure", {}, stage, caption);
  document.getElementById("panels").append(figure);
  canvas.dataset.sequence = index;
  const onFrame = (i, shown, view) => {
    missing.hidden = shown;
    missing.textContent = sequence.blocks[i] === null ? `Frame ${data.frames[i]} is missing` : `Frame ${data.frames[i]} has no ${view}`;
    canvas.dataset.frame = shown ? data.frames[i] : "";
    const parts = [], source = shown ? sourceOf(sequence, data, view, i) : null;
    if (sequence.relmse[i] !== null)
      parts.push(`relMSE ${sequence.at_least[i] ? "\u2265 " : ""}${formatNumber(sequence.relmse[i])} (${formatNumber(Number((100 * Math.sqrt(sequence.relmse[i] / 3)).toPrecision(2)))} % noise)`);
    if (sequence.phi[i] !== null)
      parts.push(`\u03c6 ${formatNumber(sequence.phi[i])}`);
    if (source && source.layer)
      parts.push(legendOfLayer(source.layer));
    words.textContent = parts.join("   ");
    bad.textContent = sequence.bad[i] > 0 ? `${sequence.bad[i]} pixels are NaN or infinite` : "";
  };
  return { figure, stage, canvas, cross, sequence, painter: new Painter(canvas, sequence.width, sequence.height), source: (view, i) => sourceOf(sequence, data, view, i), isReference: sequence.reference, onFrame };
}

// Adds a chart of the values under `key` of all sequences over the frames, if there are any.
function addFrameChart(data, key, title, note, seek) {
  const series = [];
  data.sequences.forEach((sequence, index) => {
    if (sequence[key].some(value => value !== null))
      series.push({ name: sequence.name, color: colorOf(index), points: sequence[key].map((value, i) => [data.frames[i], value]) });
  });
  if (series.length === 0)
    return [];
  return [new Chart(document.getElementById("charts"), { title, note, series, xLabel: "frame", seek, id: `chart-${key}`, explains: key in s_explanations ? key : null })];
}

function addCostChart(cost) {
  const names = [...new Set(cost.rows.map(row => row.reuse))];
  const series = names.map((name, index) => ({
    name, color: colorOf(index),
    points: cost.rows.filter(row => row.reuse === name && row.seconds > 0 && row.relmse > 0).map(row => [row.seconds, row.relmse]).sort((a, b) => a[0] - b[0]),
  })).filter(one => one.points.length > 0);
  if (series.length === 0)
    return;
  new Chart(document.getElementById("charts"), { title: `Cost: ${cost.name}`, note: cost.note, series, xLabel: "seconds per frame", xLog: true, yLog: true, dots: true, id: "chart-cost", explains: "relmse" });
}
