// Builds the page from its data: panels, controls, charts, tables.

const element = id => document.getElementById(id);
const colorOf = index => `var(--series-${index % 6})`;

const mark = color => {
  const dot = make("i", { className: "mark" });
  dot.style.background = color;
  return dot;
};
const markedName = (sequence, index) => make("strong", { className: "named", title: sequence.path }, mark(colorOf(index)), sequence.name);

function showFailure(error) {
  element("failure").textContent = `Something went wrong on this page: ${error && error.message || error}`;
  element("failure").hidden = false;
  console.error(error);
}

// What a view shows of a frame of a sequence: { ids, layer, groups }, or null. The mix has a block for each light group.
function sourceOf(sequence, data, view, i) {
  const { blocks, layers, index } = sequence, mixes = view === "mix" && sequence.mixes;
  if (blocks[i] === null)
    return null;
  if (view === "picture")
    return { ids: [blocks[i]] };
  const shown = layers.filter(layer => mixes ? layer.group : layer.name === view);
  if (shown.length === 0 || !sequence.has_layers[i])
    return null;
  const ids = shown.map(layer => `l${index}-${layers.indexOf(layer)}-${data.frames[i]}`);
  return mixes ? { ids, layer: { name: "mix", look: "light" }, groups: shown.map(layer => layer.name) } : { ids: ids.slice(0, 1), layer: shown[0] };
}

function makePanel(sequence, index, data) {
  const canvas = make("canvas", {}), cross = make("span", { className: "cross", hidden: true }), missing = make("p", { hidden: true });
  const content = make("div", { className: "content" }, canvas, cross), stage = make("div", { className: "stage", tabIndex: 0 }, content, missing);
  stage.setAttribute("role", "group");
  stage.setAttribute("aria-label", `Picture of ${sequence.name}: arrow keys move the probe, plus and minus zoom`);
  const words = make("span", {}), bad = make("span", { className: "bad" });
  const figure = make("figure", {}, stage, make("figcaption", {}, markedName(sequence, index), words, bad));
  figure.style.setProperty("--aspect", sequence.file_width / sequence.file_height);
  element("panels").append(figure);
  canvas.dataset.sequence = sequence.index = index;
  const onFrame = (i, source) => {
    const relmse = sequence.relmse[i], said = [];
    missing.hidden = source !== null;
    missing.textContent = `Frame ${data.frames[i]} ${sequence.blocks[i] === null ? "is missing" : "lacks this"}`;
    canvas.dataset.frame = source ? data.frames[i] : "";
    if (relmse !== null)
      said.push(`relMSE ${sequence.at_least[i] ? "\u2265 " : ""}${formatNumber(relmse)} (${formatNumber(100 * Math.sqrt(relmse / 3), 2)} % noise)`);
    if (sequence.phi[i] !== null)
      said.push(`\u03c6 ${formatNumber(sequence.phi[i])}`);
    if (source && source.layer)
      said.push(s_looks[source.layer.look].of(source.layer));
    words.textContent = said.join("   ");
    bad.textContent = sequence.bad[i] > 0 ? `${sequence.bad[i]} pixels are NaN or infinite` : "";
  };
  const source = (view, i) => sourceOf(sequence, data, view, i);
  return { figure, stage, content, cross, sequence, painter: new Painter(canvas), source, onFrame };
}

// Curves of what any sequence has.
function addCharts(data, seek) {
  const titles = { relmse: "Error: relMSE", phi: "Flicker: \u03c6", f1: "Flicker: relative F1", seconds: "Seconds", samples: "Samples" };
  return Object.entries(titles).flatMap(([key, title]) => {
    const all = data.sequences.map((sequence, index) => ({ name: sequence.name, color: colorOf(index), values: sequence[key] }));
    const series = all.filter(one => one.values.some(value => value !== null));
    return series.length === 0 ? [] : [new Chart(element("charts"), { id: `chart-${key}`, title, series, frames: data.frames, seek })];
  });
}

// A table for each group of facts, a column for each sequence.
function addFacts({ sequences }) {
  const groups = {};
  element("facts").style.columnWidth = `${210 + 110 * sequences.length}px`;
  for (const [index, { facts }] of sequences.entries())
    for (const [group, label, value] of facts)
      ((groups[group] ||= {})[label] ||= sequences.map(() => ""))[index] = value;
  for (const [group, rows] of Object.entries(groups)) {
    const table = make("table", {});
    if (sequences.length > 1)
      table.append(make("tr", {}, make("td", {}), ...sequences.map((sequence, i) => make("th", { scope: "col" }, markedName(sequence, i)))));
    for (const [label, values] of Object.entries(rows))
      table.append(make("tr", {}, make("th", { scope: "row", textContent: label }), ...values.map(value => make("td", { textContent: value }))));
    element("facts").append(make("div", { className: "card" }, make("h2", { textContent: group }), table));
  }
}

// Sliders of the light groups that any sequence can mix, and what gives the same as a file. Returns what shows their state.
function fillMix(player, data) {
  const groups = data.sequences.filter(sequence => sequence.mixes).flatMap(sequence => sequence.layers.filter(layer => layer.group));
  const names = [...new Set(groups.map(layer => layer.name))];
  const sliders = names.map(name => {
    const slider = make("input", { type: "range", min: 0, max: 4, step: 0.05 }), value = make("output", {});
    slider.addEventListener("input", () => player.setFactor(name, Number(slider.value)));
    element("mix-groups").append(make("label", {}, name.replace(/^light_/, ""), " ", slider, " ", value));
    return { name, slider, value };
  });
  element("mix-reset").addEventListener("click", () => names.forEach(name => player.setFactor(name, 1)));
  return () => {
    element("mix").hidden = player.view !== "mix";
    for (const { name, slider, value } of sliders) {
      slider.value = player.factorOf(name);
      value.textContent = player.factorOf(name).toFixed(2);
    }
    const mix = names.filter(name => player.factorOf(name) !== 1).map(name => `${name.replace(/^light_/, "")}=${Number(player.factorOf(name).toFixed(2))}`).join(",");
    const quoted = /^[\w=,.-]*$/.test(mix) ? mix : `'${mix.replaceAll("'", "'\\''")}'`; // for a shell
    element("mix-command").textContent = mix !== "" ? `reframe png --mix ${quoted}` : "";
  };
}

// Views: the picture, the mix, and the passes that any sequence has.
function fillViews({ sequences }) {
  const add = (value, text) => element("view").append(new Option(text, value));
  add("picture", "Image");
  if (sequences.some(sequence => sequence.mixes))
    add("mix", "Light groups, mixed");
  for (const name of new Set(sequences.flatMap(sequence => sequence.layers.map(layer => layer.name))))
    add(name, name.startsWith("light_") ? `Light: ${name.slice(6)}` : name[0].toUpperCase() + name.slice(1));
  element("view").parentElement.hidden = element("view").options.length < 2;
}

function connectControls(player, stage, data) {
  const on = (id, name, act) => element(id).addEventListener(name, event => act(event.target.value));
  element("scrubber").max = data.frames.length - 1;
  element("scrubber").disabled = element("play").disabled = data.frames.length < 2;
  element("fps").value = Number(data.fps.toPrecision(6));
  on("scrubber", "input", value => player.seek(Number(value)).catch(showFailure));
  on("play", "click", () => player.toggle().catch(showFailure));
  on("exposure", "input", value => player.setExposure(Number(value)));
  on("exposure-reset", "click", () => player.setExposure(0));
  on("view", "change", value => player.setView(value).catch(showFailure));
  on("fps", "change", value => player.fps = value > 0 && value <= 240 ? Number(value) : player.fps);
  on("zoom-in", "click", () => stage.zoomTo(stage.zoom * 1.5));
  on("zoom-out", "click", () => stage.zoomTo(stage.zoom / 1.5));
  on("zoom-fit", "click", () => stage.zoomTo(1));
  on("zoom-pixels", "click", () => stage.zoomTo(stage.pixelZoom()));
  on("divider", "input", value => element("panels").style.setProperty("--split", value / 100));
}

// Returns what changes between side by side and the wipe.
function connectLayout(stage, { sequences }, onChange) {
  const [a, b] = ["wipe-a", "wipe-b"].map(element), layout = element("layout");
  layout.parentElement.hidden = sequences.length < 2;
  sequences.forEach((sequence, index) => [a, b].forEach(select => select.append(new Option(sequence.name, index))));
  b.value = Math.min(1, sequences.length - 1);
  const apply = () => {
    a.parentElement.hidden = b.parentElement.hidden = element("divider").hidden = layout.value !== "wipe";
    stage.setLayout(layout.value, [Number(a.value), Number(b.value)]);
    onChange();
  };
  [layout, a, b].forEach(control => control.addEventListener("change", apply));
  return () => {
    if (sequences.length > 1)
      layout.value = layout.value === "wipe" ? "side" : "wipe";
    apply();
  };
}

function connectKeys(player, stage, probe, toggleWipe) {
  const seek = index => player.seek(index).catch(showFailure), zoom = factor => stage.zoomTo(stage.zoom * factor);
  const keys = {
    " ": () => player.toggle().catch(showFailure),
    ArrowLeft: () => seek(player.index - 1), ArrowRight: () => seek(player.index + 1), Home: () => seek(0), End: () => seek(player.count - 1),
    ArrowUp: () => player.setExposure(player.exposure + 0.5), ArrowDown: () => player.setExposure(player.exposure - 0.5), 0: () => player.setExposure(0),
    "+": () => zoom(1.5), "=": () => zoom(1.5), "-": () => zoom(1 / 1.5),
    w: toggleWipe,
    Escape: () => probe.clear(),
  };
  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  addEventListener("keydown", event => {
    const on = selector => event.target.matches && event.target.matches(selector), step = on(".stage") && steps[event.key];
    const takes = on("select, input[type=number]") || (event.key === " " ? on("button") : /^(Arrow|Home|End)/.test(event.key) && on("input")); // the key itself
    if (takes || event.ctrlKey || event.altKey || event.metaKey || (!step && !keys[event.key]))
      return;
    event.preventDefault();
    if (step)
      probe.step(...step.map(pixels => event.shiftKey ? 10 * pixels : pixels));
    else
      keys[event.key]();
  });
}

function showState(player, data, charts) {
  const number = data.frames[player.index], stops = `${player.exposure > 0 ? "+" : ""}${player.exposure.toFixed(1)} stops`;
  element("scrubber").value = player.index;
  element("scrubber").setAttribute("aria-valuetext", `frame ${number}`);
  element("frame-number").textContent = `${number} of ${data.frames[data.frames.length - 1]}`;
  element("exposure").value = player.exposure;
  element("exposure-value").textContent = stops;
  element("exposure").disabled = element("curve").disabled = player.isData();
  element("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
  element("play-icon").setAttribute("d", player.playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
  charts.forEach(chart => chart.mark(player.index));
}

function start() {
  const data = JSON.parse(element("data").textContent), count = data.sequences.length, shows = [];
  element("title").textContent = data.title;
  element("subtitle").textContent = data.subtitle;
  element("panels").style.setProperty("--columns", count <= 3 ? count : Math.ceil(Math.sqrt(count)));
  element("panels").style.setProperty("--aspect", data.sequences[0].file_width / data.sequences[0].file_height);
  const panels = data.sequences.map((sequence, index) => makePanel(sequence, index, data));
  const player = new Player(panels, data.frames.length, data.fps, data.exposure, () => shows.forEach(show => show()));
  if (data.view) {
    const cube = player.cube = bytesOf("view-cube"), curve = element("curve");
    curve.prepend(new Option(data.view, "view", true, true));
    curve.parentElement.hidden = false;
    curve.addEventListener("change", () => player.setCube(curve.value === "view" ? cube : null));
  }
  const stage = new Stage(element("panels"), panels, (u, v, how) => probe.point(u, v, how), () => {
    element("zoom-value").textContent = `${Math.round(100 * stage.scale())} %`;
    element("zoom-fit").disabled = stage.zoom === 1;
  });
  const probe = new Probe(element("probe"), data, player, stage);
  const charts = addCharts(data, index => player.seek(index).catch(showFailure));
  addFacts(data);
  fillViews(data);
  connectControls(player, stage, data);
  connectKeys(player, stage, probe, connectLayout(stage, data, () => probe.show()));
  shows.push(() => showState(player, data, charts), fillMix(player, data), () => probe.show());
  player.seek(0).then(() => document.documentElement.dataset.ready = "yes").catch(showFailure);
  Object.assign(window, { reframePlayer: player, reframeStage: stage, reframeProbe: probe }); // for debugging and tests
}

try {
  start();
} catch (error) {
  showFailure(error);
}
