// Controls and keys.

const element = id => document.getElementById(id);

// Sliders of the light groups that any sequence can mix, and what gives the same as a file.
function fillMix(player, data) {
  const names = [...new Set(data.sequences.filter(sequence => sequence.mixes).flatMap(sequence => sequence.layers.filter(layer => layer.group).map(layer => layer.name)))];
  const sliders = names.map(name => {
    const slider = make("input", { type: "range", min: 0, max: 4, step: 0.05, value: 1 }), value = make("output", {}), label = make("label", {}, name.replace(/^light_/, ""), " ", slider, " ", value);
    slider.addEventListener("input", () => player.setFactor(name, Number(slider.value)));
    element("mix-groups").append(label);
    return { name, slider, value };
  });
  element("mix-reset").addEventListener("click", () => names.forEach(name => player.setFactor(name, 1)));
  return () => {
    element("mix").hidden = player.view !== "mix";
    for (const { name, slider, value } of sliders) {
      slider.value = player.factorOf(name);
      value.textContent = player.factorOf(name).toFixed(2);
    }
    const changed = names.filter(name => player.factorOf(name) !== 1).map(name => `${name.replace(/^light_/, "")}=${Number(player.factorOf(name).toFixed(2))}`);
    const mix = changed.join(","), quoted = /^[\w=,.-]*$/.test(mix) ? mix : `'${mix.replaceAll("'", "'\\''")}'`; // for a shell
    element("mix-command").textContent = mix !== "" ? `reframe png --mix ${quoted}` : "";
  };
}

// Views: the picture, its error where there is a reference, and the passes that any sequence has.
function fillViews(player, data) {
  const names = [...new Set(data.sequences.flatMap(sequence => sequence.layers.map(layer => layer.name)))];
  const add = (value, text) => element("view").append(make("option", { value, textContent: text }));
  add("picture", "Image");
  if (player.panels.some(panel => player.canShowError(panel)))
    add("error", player.reference().isReference ? "Error" : `Difference to ${player.reference().sequence.name}`);
  if (data.sequences.some(sequence => sequence.mixes))
    add("mix", "Light groups, mixed");
  for (const name of names)
    add(name, name.startsWith("light_") ? `Light: ${name.slice(6)}` : name[0].toUpperCase() + name.slice(1));
  element("view").parentElement.hidden = element("view").options.length < 2;
  element("view").addEventListener("change", event => player.setView(event.target.value));
}

function connectLayout(stage, data, onChange) {
  const selects = ["wipe-a", "wipe-b"].map(element);
  data.sequences.forEach((sequence, index) => selects.forEach(select => select.append(make("option", { value: index, textContent: sequence.name }))));
  selects[0].value = 0;
  selects[1].value = Math.min(1, data.sequences.length - 1);
  element("layout").parentElement.hidden = data.sequences.length < 2;
  const apply = () => {
    const wipes = element("layout").value === "wipe";
    selects.forEach(select => select.parentElement.hidden = !wipes);
    stage.setLayout(element("layout").value, selects.map(select => Number(select.value)));
    onChange();
  };
  for (const control of [element("layout"), ...selects])
    control.addEventListener("change", apply);
  return () => {
    if (data.sequences.length < 2)
      return;
    element("layout").value = stage.layout === "wipe" ? "side" : "wipe";
    apply();
  };
}

function connectZoom(stage) {
  element("zoom-in").addEventListener("click", () => stage.zoomTo(stage.zoom * 1.5));
  element("zoom-out").addEventListener("click", () => stage.zoomTo(stage.zoom / 1.5));
  element("zoom-fit").addEventListener("click", () => stage.zoomTo(1));
  element("zoom-pixels").addEventListener("click", () => stage.zoomTo(stage.pixelZoom()));
  stage.onPlace = () => {
    const panel = stage.panels[stage.shownPanels()[0]];
    element("zoom-value").textContent = `${Math.round(100 * panel.scale * devicePixelRatio)} %`;
    element("zoom-out").disabled = stage.zoom <= Math.min(1, stage.pixelZoom());
    element("zoom-fit").disabled = stage.zoom === 1;
  };
}

function connectControls(player, data) {
  element("scrubber").max = data.frames.length - 1;
  element("scrubber").disabled = element("play").disabled = data.frames.length < 2;
  element("fps").value = Number(data.fps.toPrecision(6));
  element("scrubber").addEventListener("input", event => player.seek(Number(event.target.value)).catch(showFailure));
  element("play").addEventListener("click", () => player.toggle());
  element("exposure").addEventListener("input", event => player.setExposure(Number(event.target.value)));
  element("exposure-reset").addEventListener("click", () => player.setExposure(0));
  element("curve").addEventListener("change", event => player.setCurve(event.target.value));
  element("fps").addEventListener("change", event => player.setFps(Number(event.target.value)));
  fillViews(player, data);
  return fillMix(player, data);
}

function connectKeys(player, stage, probe, toggleWipe, data) {
  const seek = index => player.seek(index).catch(showFailure);
  const keys = {
    " ": () => player.toggle(),
    ArrowLeft: () => seek(player.wanted - 1), ArrowRight: () => seek(player.wanted + 1),
    Home: () => seek(0), End: () => seek(data.frames.length - 1),
    ArrowUp: () => player.setExposure(player.exposure + 0.5), ArrowDown: () => player.setExposure(player.exposure - 0.5),
    0: () => player.setExposure(0),
    "+": () => stage.zoomTo(stage.zoom * 1.5), "=": () => stage.zoomTo(stage.zoom * 1.5), "-": () => stage.zoomTo(stage.zoom / 1.5),
    w: toggleWipe,
    Escape: () => probe.clear(),
  };
  const probing = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  addEventListener("keydown", event => {
    const on = selector => event.target.matches && event.target.matches(selector);
    const typing = on("select, input[type=number]") || (event.key === " " && on("button, summary")); // a focused button handles the space key itself
    if (typing || event.ctrlKey || event.altKey || event.metaKey)
      return;
    const step = on(".stage") && probing[event.key];
    if (!step && !keys[event.key])
      return;
    event.preventDefault();
    if (step)
      probe.step(...step.map(pixels => event.shiftKey ? 10 * pixels : pixels));
    else
      keys[event.key]();
  });
}
