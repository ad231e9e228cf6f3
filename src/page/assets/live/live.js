// The page of a render that goes on: asks for its state once a second, shows the frame in work, and plays those that are finished.
const element = id => document.getElementById(id);
const POLL = 1000;       // milliseconds between two questions
const MOST_KEPT = 200;   // decoded frames

const live = {
  status: null, ended: false, following: true, index: 0, playing: false,
  shown: "", version: 0, work: null, frames: new Map(), painter: null, drawn: null, pass: -1, // of the frames, the picture
};
window.reframeLive = live; // for tests

async function fetchPicture(path) {
  const reply = await fetch(path);
  if (!reply.ok)
    throw new Error(`${path}: ${reply.status}`);
  return decodePicture(new Uint8Array(await reply.arrayBuffer()));
}

// A finished frame, or the chosen pass of it, fetched once.
function finishedFrame(number) {
  const path = live.pass < 0 ? `/frame/${number}` : `/frame/${number}/${live.pass}`;
  if (!live.frames.has(path)) {
    live.frames.set(path, fetchPicture(path).catch(() => {
      live.frames.delete(path);
      return null;
    }));
    if (live.frames.size > MOST_KEPT)
      live.frames.delete(live.frames.keys().next().value);
  }
  return live.frames.get(path);
}

// Passes that are no light are shown as they are.
function paint() {
  const data = live.pass >= 0 && !live.status.passes[live.pass].light;
  element("exposure").disabled = element("curve").disabled = data;
  if (live.painter)
    live.painter.paint(data ? new Tone(0, "srgb", null) : new Tone(Number(element("exposure").value), element("curve").value, null));
}

// The passes that the finished frames have.
function showPasses() {
  const { passes } = live.status, select = element("pass");
  for (const [i, { name }] of passes.entries()) {
    if (select.options.length <= i + 1)
      select.append(new Option(name, i));
  }
  select.parentElement.hidden = passes.length === 0;
}

function draw(picture, name) {
  const { width, height } = picture.bitmap;
  if (live.painter)
    live.painter.resize(width, height);
  else
    live.painter = new Painter(element("picture"), width, height);
  live.painter.take(picture);
  live.shown = name;
  element("picture").hidden = false;
  element("waiting").hidden = true;
  paint();
}

const finished = () => live.status ? live.status.finished : [];

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
  const frames = finished(), last = frames.length - 1, slider = element("scrubber");
  slider.max = Math.max(last, 0);
  slider.disabled = element("play").disabled = last < 0;
  live.index = Math.min(live.index, Math.max(last, 0));
  slider.value = live.following ? slider.max : live.index;
  element("follow").setAttribute("aria-pressed", String(live.following));
  element("play").setAttribute("aria-label", live.playing ? "Pause" : "Play");
  element("play-icon").setAttribute("d", live.playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
  element("frame-number").textContent = live.following ? "" : `frame ${frames[live.index]}`;
}

// The frame in work, or where all are finished the last of them.
async function showWork() {
  const s = live.status;
  if (s.version > live.version) {
    try {
      live.work = await fetchPicture("/preview");
      live.version = s.version;
    } catch (error) { return; } // the next time
  }
  if (live.following && live.pass >= 0)
    await showLast();
  else if (live.following && live.work)
    draw(live.work, `work ${live.version}`);
}

// The frame in work has no passes yet: the last that is finished.
async function showLast() {
  const number = finished()[finished().length - 1], pass = live.pass, picture = number === undefined ? null : await finishedFrame(number);
  if (picture && live.following && live.pass === pass)
    draw(picture, `pass ${number}`);
}

async function showFrame() {
  const number = finished()[live.index];
  const picture = number === undefined ? null : await finishedFrame(number);
  if (picture && !live.following && finished()[live.index] === number)
    draw(picture, `frame ${number}`);
  showControls();
}

function follow(following) {
  live.following = following;
  live.playing = live.playing && !following;
  showControls();
  if (following && live.pass >= 0)
    showLast();
  else if (following && live.work)
    draw(live.work, `work ${live.version}`);
}

function seek(index) {
  live.index = index;
  follow(false);
  return showFrame();
}

async function play() {
  if (finished().length === 0)
    return;
  live.playing = !live.playing;
  let next = performance.now();
  while (live.playing) {
    await seek((live.following ? 0 : live.index + 1) % finished().length);
    next = Math.max(next + 1000 / live.status.fps, performance.now());
    await new Promise(done => setTimeout(done, next - performance.now()));
  }
  showControls();
}

async function ask() {
  try {
    const reply = await fetch("/status");
    live.status = await reply.json();
    live.ended = false;
    showProgress();
    showControls();
    showPasses();
    if (live.following)
      await showWork();
    for (const number of finished().slice(-MOST_KEPT / 2)) // while they can be had
      await finishedFrame(number);
  } catch (error) {
    live.ended = true;
    showProgress();
  }
  setTimeout(ask, POLL);
}

element("play").addEventListener("click", play);
element("follow").addEventListener("click", () => follow(true));
element("scrubber").addEventListener("input", event => { live.playing = false; seek(Number(event.target.value)); });
element("exposure").addEventListener("input", event => {
  element("exposure-value").textContent = Number(event.target.value).toFixed(1);
  paint();
});
element("curve").addEventListener("change", paint);
element("pass").addEventListener("change", event => {
  live.pass = Number(event.target.value);
  if (live.following)
    follow(true);
  else
    showFrame();
});
document.addEventListener("keydown", event => {
  if (event.target.matches("input, select, button") && event.key === " ")
    return;
  if (event.key === " ") {
    event.preventDefault();
    play();
  } else if (event.key === "End")
    follow(true);
});
ask();
