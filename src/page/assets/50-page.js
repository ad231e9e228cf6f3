// Builds the page from its data.

function showState(player, data, charts, sheet) {
  const number = data.frames[player.index];
  element("scrubber").value = player.index;
  element("scrubber").setAttribute("aria-valuetext", `frame ${number}`);
  element("frame-number").textContent = `${number} of ${data.frames[data.frames.length - 1]}`;
  element("exposure").value = player.exposure;
  element("exposure-value").textContent = `${player.exposure > 0 ? "+" : ""}${player.exposure.toFixed(1)} stops`;
  element("exposure").setAttribute("aria-valuetext", element("exposure-value").textContent);
  element("exposure").disabled = element("curve").disabled = player.isData();
  element("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
  element("play-icon").setAttribute("d", player.playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
  for (const chart of charts)
    chart.mark(number);
  if (sheet) {
    sheet.markCurrent();
    sheet.repaint();
  }
}

function addCharts(data, seek) {
  const charts = [...addFrameChart(data, "relmse", "Error: relMSE", data.notes.relmse, seek), ...addFrameChart(data, "phi", "Flicker: \u03c6", data.notes.phi, seek),
    ...addFrameChart(data, "f1", "Flicker: F1", data.notes.f1, seek), ...addFrameChart(data, "seconds", "Seconds", data.notes.seconds, seek)];
  if (data.sequences.some(sequence => new Set(sequence.samples.filter(value => value !== null)).size > 1))
    charts.push(...addFrameChart(data, "samples", "Samples", data.notes.samples, seek));
  data.cost.forEach(addCostChart);
  return charts;
}

function start() {
  const data = JSON.parse(element("data").textContent);
  element("title").textContent = data.title;
  element("subtitle").textContent = data.subtitle;
  const count = data.sequences.length;
  element("panels").style.setProperty("--columns", count <= 3 ? count : Math.ceil(Math.sqrt(count)));
  const panels = data.sequences.map((sequence, index) => makePanel(sequence, index, data)), charts = [];
  let sheet = null, probe = null, showMix = () => {};
  const player = new Player(panels, data.frames.length, data.fps, () => {
    showState(player, data, charts, sheet);
    showMix();
    if (probe)
      probe.show();
  });
  player.exposure = data.exposure;
  if (data.view) {
    player.cube = bytesOf("view-cube");
    player.curve = "view";
    element("curve").prepend(new Option(data.view, "view", true, true));
  }
  const stage = new Stage(element("panels"), panels, (panel, u, v, how) => probe.point(u, v, how));
  connectZoom(stage);
  probe = new Probe(element("probe"), data, player, stage);
  stage.setLayout("side");
  const seek = number => player.seek(data.frames.indexOf(number)).catch(showFailure);
  showVerdict(data, seek);
  showWarnings(data);
  charts.push(...addCharts(data, seek));
  addFacts(data);
  showMix = connectControls(player, data);
  connectKeys(player, stage, probe, connectLayout(stage, data, () => probe.show()), data);
  player.seek(0).then(() => {
    sheet = new ContactSheet(data, player);
    document.documentElement.dataset.ready = "yes";
  }).catch(showFailure);
  Object.assign(window, { reframePlayer: player, reframeStage: stage, reframeProbe: probe }); // for debugging and tests
}

try {
  start();
} catch (error) {
  showFailure(error);
}
