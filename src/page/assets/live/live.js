// The page of a render that goes on: asks for its state once a second, shows the frame in work, and plays those that are finished.
const element = id => document.getElementById(id);
const POLL = 1000;     // milliseconds between two questions
const MOST_KEPT = 100; // finished frames that are fetched while they can be had

const live = { status: null, ended: false, following: true, shown: "", version: 0 };
window.reframeLive = live; // for tests

const finished = () => live.status ? live.status.finished : [];
const ignore = () => {}; // what cannot be had now may be there the next time

// The chosen pass of a finished frame, or the frame. The one in work has no passes yet: the last that is finished.
function sourceOf(view, i) {
  const pass = panel.sequence.layers.findIndex(layer => layer.name === view), frames = finished();
  const number = frames[live.following ? frames.length - 1 : i];
  if (live.following && pass < 0)
    return live.status && live.status.version > 0 ? { ids: [`/preview#${live.status.version}`], name: "work" } : null;
  return number === undefined ? null : { ids: [`/frame/${number}${pass < 0 ? "" : `/${pass}`}`], name: live.following ? "pass" : "frame" };
}

function onFrame(i, source) {
  if (!source)
    return;
  live.version = source.name === "work" ? Number(source.ids[0].split("#")[1]) : live.version;
  live.shown = `${source.name} ${source.ids[0]}`;
  element("picture").hidden = false;
  element("waiting").hidden = true;
}

const panel = { painter: new Painter(element("picture")), sequence: { layers: [] }, source: sourceOf, onFrame };
const player = new Player([panel], 1, 24, 0, showControls);

function duration(seconds) {
  const whole = Math.ceil(seconds), two = n => String(n).padStart(2, "0");
  return whole < 3600 ? `${Math.floor(whole / 60)}:${two(whole % 60)}` : `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

function showProgress() {
  const s = live.status;
  if (live.ended) {
    const done = s && s.finished.length === s.frames;
    element("progress-text").textContent = done ? `All ${s.frames} frames are finished.`
      : `The render has ended${s ? `: ${s.finished.length} of ${s.frames} frames were finished when this page last heard of it` : ""}.`;
    return;
  }
  const left = s.left === null ? "" : `, ${duration(s.left)} left`;
  const work = s.version > 0 ? `; frame ${s.frame} in work, ${s.spp} samples per pixel so far` : "";
  element("progress-text").textContent = `${Math.floor(100 * s.share)} %: ${s.finished.length} of ${s.frames} frames finished, ${duration(s.seconds)} spent${left}${work}`;
  element("progress").value = s.share;
  element("subtitle").textContent = `${s.scene} \u2192 ${s.output}`;
  document.title = `${Math.floor(100 * s.share)} % ${s.scene}`;
}

function showControls() {
  const frames = finished(), slider = element("scrubber");
  slider.max = Math.max(frames.length - 1, 0);
  slider.disabled = element("play").disabled = frames.length === 0;
  slider.value = live.following ? slider.max : player.index;
  element("frame-number").textContent = live.following || frames.length === 0 ? "" : `frame ${frames[player.index]}`;
  element("follow").setAttribute("aria-pressed", String(live.following));
  element("exposure").disabled = player.isData();
  element("exposure-value").textContent = player.exposure.toFixed(1);
  element("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
  element("play-icon").setAttribute("d", player.playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
}

// Shows a frame from the moment on at which it is decoded; -1: the one in work.
function seek(index) {
  live.following = index < 0;
  player.playing = false;
  return player.seek(Math.max(index, 0)).catch(ignore);
}

function play() {
  if (live.following && finished().length > 0)
    seek(0);
  player.toggle().catch(ignore);
}

function take(status) {
  const select = element("pass");
  live.status = status;
  live.ended = false;
  player.count = Math.max(status.finished.length, 1);
  player.fps = status.fps;
  panel.sequence.layers = status.passes.map(({ name, light }) => ({ name, look: light ? "light" : "depth" }));
  for (const { name } of status.passes.slice(select.options.length - 1))
    select.append(new Option(name));
  select.parentElement.hidden = status.passes.length === 0;
}

async function ask() {
  try {
    take(await (await fetch("/status")).json());
    showControls();
    if (live.following && (live.status.version > live.version || player.view !== "picture"))
      await player.seek(0).catch(ignore);
    for (const number of finished().slice(-MOST_KEPT))
      await player.load(`/frame/${number}`).catch(ignore);
  } catch (error) {
    live.ended = true;
  }
  showProgress();
  setTimeout(ask, POLL);
}

const on = (id, name, act) => element(id).addEventListener(name, event => act(event.target.value));
on("play", "click", play);
on("follow", "click", () => seek(-1));
on("scrubber", "input", value => seek(Number(value)));
on("exposure", "input", value => player.setExposure(Number(value)));
on("pass", "change", value => player.setView(value).catch(ignore));
document.addEventListener("keydown", event => {
  if (event.target.matches("input, select, button") && event.key === " ")
    return;
  if (event.key === " ") {
    event.preventDefault();
    play();
  } else if (event.key === "End")
    seek(-1);
});
ask();
