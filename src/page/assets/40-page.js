// Builds the page from its data: panels, controls, charts and tables.

function showFailure(error) {
  const line = document.getElementById("failure");
  line.textContent = `Something went wrong on this page: ${error && error.message || error}`;
  line.hidden = false;
  console.error(error);
}

const colorOf = index => `var(--series-${index % 6})`;

function makePanel(sequence, index, data) {
  const canvas = make("canvas", {}), missing = make("p", { hidden: true });
  const name = make("strong", { textContent: sequence.name, title: sequence.path }), words = make("span", {}), bad = make("span", { className: "bad" });
  const caption = make("figcaption", {}, name, words, bad);
  caption.style.setProperty("--mark", colorOf(index));
  const figure = make("figure", {}, make("div", { className: "stage" }, canvas, missing), caption);
  document.getElementById("panels").append(figure);
  canvas.dataset.sequence = index;
  const onFrame = (i, shown) => {
    missing.hidden = shown;
    missing.textContent = `Frame ${data.frames[i]} is missing`;
    canvas.dataset.frame = shown ? data.frames[i] : "";
    const parts = [];
    if (sequence.relmse[i] !== null)
      parts.push(`relMSE ${formatNumber(sequence.relmse[i])}`);
    if (sequence.phi[i] !== null)
      parts.push(`\u03c6 ${formatNumber(sequence.phi[i])}`);
    words.textContent = parts.join("   ");
    bad.textContent = sequence.bad[i] > 0 ? `${sequence.bad[i]} pixels are NaN or infinite` : "";
  };
  return { painter: new Painter(canvas, sequence.width, sequence.height), blocks: sequence.blocks, isReference: sequence.reference, onFrame };
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
  return [new Chart(document.getElementById("charts"), { title, note, series, xLabel: "frame", seek, id: `chart-${key}` })];
}

function addCostChart(cost) {
  const names = [...new Set(cost.rows.map(row => row.reuse))];
  const series = names.map((name, index) => ({
    name, color: colorOf(index),
    points: cost.rows.filter(row => row.reuse === name && row.seconds > 0 && row.relmse > 0).map(row => [row.seconds, row.relmse]).sort((a, b) => a[0] - b[0]),
  })).filter(one => one.points.length > 0);
  if (series.length === 0)
    return;
  new Chart(document.getElementById("charts"), { title: `Cost: ${cost.name}`, note: cost.note, series, xLabel: "seconds per frame", xLog: true, yLog: true, dots: true, id: "chart-cost" });
}

function addFacts(data) {
  const box = document.getElementById("facts"), groups = new Map();
  box.style.setProperty("--fact-width", `${240 + 110 * data.sequences.length}px`);
  data.sequences.forEach((sequence, index) => {
    for (const [group, label, value] of sequence.facts) {
      if (!groups.has(group))
        groups.set(group, new Map());
      if (!groups.get(group).has(label))
        groups.get(group).set(label, data.sequences.map(() => ""));
      groups.get(group).get(label)[index] = value;
    }
  });
  for (const [group, rows] of groups) {
    const table = make("table", {});
    if (data.sequences.length > 1)
      table.append(make("thead", {}, make("tr", {}, make("th", {}), ...data.sequences.map(sequence => make("th", { textContent: sequence.name })))));
    for (const [label, values] of rows)
      table.append(make("tr", {}, make("th", { scope: "row", textContent: label }), ...values.map(value => make("td", { textContent: value }))));
    box.append(make("div", { className: "card" }, make("h2", { textContent: group }), table));
  }
}

function connectControls(player, data) {
  const get = id => document.getElementById(id);
  get("scrubber").max = data.frames.length - 1;
  get("scrubber").disabled = get("play").disabled = data.frames.length < 2;
  get("fps").value = Number(data.fps.toPrecision(6));
  const seek = index => player.seek(index).catch(showFailure);
  get("scrubber").addEventListener("input", event => seek(Number(event.target.value)));
  get("play").addEventListener("click", () => player.toggle());
  get("exposure").addEventListener("input", event => player.setExposure(Number(event.target.value)));
  get("exposure-reset").addEventListener("click", () => player.setExposure(0));
  get("curve").addEventListener("change", event => player.setCurve(event.target.value));
  get("view").addEventListener("change", event => player.setView(event.target.value));
  get("view").parentElement.hidden = !player.panels.some(panel => player.canShowError(panel));
  get("fps").addEventListener("change", event => player.setFps(Number(event.target.value)));
  get("size").addEventListener("change", event => get("viewer").classList.toggle("full", event.target.value === "full"));
  const keys = {
    " ": () => player.toggle(),
    ArrowLeft: () => seek(player.wanted - 1), ArrowRight: () => seek(player.wanted + 1),
    Home: () => seek(0), End: () => seek(data.frames.length - 1),
    ArrowUp: () => player.setExposure(player.exposure + 0.5), ArrowDown: () => player.setExposure(player.exposure - 0.5),
    0: () => player.setExposure(0),
  };
  addEventListener("keydown", event => {
    const on = selector => event.target.matches && event.target.matches(selector);
    const typing = on("select, input[type=number]") || (event.key === " " && on("button")); // a focused button handles the space key itself
    const action = keys[event.key];
    if (!action || typing || event.ctrlKey || event.altKey || event.metaKey)
      return;
    event.preventDefault();
    action();
  });
}

function showState(player, data, charts) {
  const get = id => document.getElementById(id), number = data.frames[player.index];
  get("scrubber").value = player.index;
  get("frame-number").textContent = `${number} of ${data.frames[data.frames.length - 1]}`;
  get("exposure").value = player.exposure;
  get("exposure-value").textContent = `${player.exposure > 0 ? "+" : ""}${player.exposure.toFixed(1)} stops`;
  get("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
  get("play-icon").setAttribute("d", player.playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
  for (const chart of charts)
    chart.mark(number);
}

function start() {
  const data = JSON.parse(document.getElementById("data").textContent);
  document.getElementById("title").textContent = data.title;
  document.getElementById("subtitle").textContent = data.subtitle;
  const count = data.sequences.length;
  document.getElementById("panels").style.setProperty("--columns", count <= 3 ? count : Math.ceil(Math.sqrt(count)));
  const panels = data.sequences.map((sequence, index) => makePanel(sequence, index, data)), charts = [];
  const player = new Player(panels, data.frames.length, data.fps, () => showState(player, data, charts));
  player.exposure = data.exposure;
  const seek = number => player.seek(data.frames.indexOf(number)).catch(showFailure);
  charts.push(...addFrameChart(data, "relmse", "Error: relMSE", data.notes.relmse, seek), ...addFrameChart(data, "phi", "Flicker: \u03c6", data.notes.phi, seek),
    ...addFrameChart(data, "f1", "Flicker: F1", data.notes.f1, seek), ...addFrameChart(data, "seconds", "Seconds", data.notes.seconds, seek));
  if (data.sequences.some(sequence => new Set(sequence.samples.filter(value => value !== null)).size > 1))
    charts.push(...addFrameChart(data, "samples", "Samples", data.notes.samples, seek));
  data.cost.forEach(addCostChart);
  addFacts(data);
  connectControls(player, data);
  player.seek(0).then(() => document.documentElement.dataset.ready = "yes").catch(showFailure);
  window.reframePlayer = player; // for debugging and tests
}

try {
  start();
} catch (error) {
  showFailure(error);
}
