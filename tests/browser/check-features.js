// What check-page.js looks for on a page besides playing: AOVs, wipe, zoom, probe, names for
// screen readers, and a phone.
"use strict";

const settle = page => page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));
const read_data = page => page.evaluate(() => JSON.parse(document.getElementById("data").textContent));

async function shown_frame(page, number) {
  await page.waitForFunction(number => document.querySelector("#panels canvas").dataset.frame === String(number), number, { timeout: 20000 });
}

async function check_aovs(page, check, look) {
  const data = await read_data(page), names = [...new Set(data.sequences.flatMap(sequence => sequence.layers.map(layer => layer.name)))];
  if (names.length === 0)
    return;
  const before = await look(page), hashes = new Set([before.hash]);
  for (const name of names) {
    await page.locator("#view").selectOption(name);
    await page.waitForFunction(() => window.reframePlayer.shown >= 0);
    const picture = await look(page);
    hashes.add(picture.hash);
    const is_light = ["light", "deviation"].includes(data.sequences.flatMap(sequence => sequence.layers).find(layer => layer.name === name).look);
    check(picture.frame !== "" && await page.locator("#exposure").isDisabled() === !is_light, `${name} is shown, ${is_light ? "with" : "without"} exposure`);
  }
  check(hashes.size === names.length + 1, "each AOV is a picture of its own");
  await page.locator("#view").selectOption("picture");
  await page.waitForFunction(() => window.reframePlayer.shown >= 0);
  check((await look(page)).hash === before.hash, "and the picture comes back");
}

// Light groups: their sum looks like the picture, and a slider changes it as the group's own picture is.
async function check_mix(page, check, look) {
  const data = await read_data(page), layer = data.sequences[0].layers.find(layer => layer.group);
  if (!data.sequences[0].mixes) {
    check(await page.locator("#view option[value=mix]").count() === 0 && await page.locator("#mix").isHidden(), "without light groups there is no mix");
    return;
  }
  const show = async name => {
    await page.locator("#view").selectOption(name);
    await page.waitForFunction(() => window.reframePlayer.shown >= 0);
    return look(page);
  };
  const slide = (group, factor) => page.locator("#mix-groups label", { hasText: group.slice(6) }).locator("input").evaluate((slider, factor) => {
    slider.value = factor;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  }, factor);
  const groups = data.sequences[0].layers.filter(layer => layer.group).map(layer => layer.name), picture = await show("picture"), alone = await show(layer.name), mix = await show("mix");
  check(Math.abs(mix.mean - picture.mean) < 1 && Math.abs(alone.mean - picture.mean) > 3, `the mix looks like the picture: ${mix.mean.toFixed(1)}, ${picture.mean.toFixed(1)}, one group ${alone.mean.toFixed(1)}`);
  for (const group of groups.filter(group => group !== layer.name))
    await slide(group, 0);
  const dimmed = await look(page), command = await page.locator("#mix-command").innerText();
  check(Math.abs(dimmed.mean - alone.mean) < 1 && command.includes("--mix ") && command.includes(`${groups.find(group => group !== layer.name).slice(6)}=0`), `without the others it is the group's picture: ${dimmed.mean.toFixed(1)}, ${command}`);
  await page.locator("#mix-reset").click();
  check((await look(page)).hash === mix.hash && await page.locator("#mix-command").innerText() === "", "and comes back");
  await show("picture");
  check(await page.locator("#mix").isHidden(), "the sliders belong to the mix");
}

// The sequence whose stage is at a place of the panels.
const sequence_at = (page, share) => page.evaluate(share => {
  const box = document.getElementById("panels").getBoundingClientRect(), stage = document.querySelector("figure:not([hidden]) .stage").getBoundingClientRect();
  const found = document.elementsFromPoint(box.left + share * box.width, stage.top + 20).map(element => element.closest(".stage")).find(Boolean);
  return found ? Number(found.querySelector("canvas").dataset.sequence) : null;
}, share);

async function check_wipe(page, check) {
  const data = await read_data(page), divider = page.locator("#divider");
  if (data.sequences.length < 2) {
    check(await page.locator("#layout").isHidden(), "one sequence has nothing to wipe");
    return;
  }
  await page.evaluate(() => scrollTo(0, 0));
  await page.locator("#layout").selectOption("wipe");
  await settle(page);
  check(await sequence_at(page, 0.3) === 0 && await sequence_at(page, 0.7) === 1, "the wipe shows A on the left and B on the right");
  await divider.focus();
  for (let i = 0; i < 30; ++i)
    await divider.press("ArrowRight");
  check(await divider.inputValue() === "80" && await sequence_at(page, 0.7) === 0, "arrow keys move its divider");
  const box = await page.locator("#panels").boundingBox();
  await page.mouse.move(box.x + 22 + 0.8 * (box.width - 44), box.y + 30);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.2 * box.width, box.y + 30, { steps: 4 });
  await page.mouse.up();
  check(Math.abs(Number(await divider.inputValue()) - 20) <= 2 && await sequence_at(page, 0.3) === 1, "and so does the pointer");
  await page.locator("#wipe-a").selectOption("1");
  await page.locator("#wipe-b").selectOption("0");
  check(await sequence_at(page, 0.1) === 1 && await sequence_at(page, 0.7) === 0, "A and B can be chosen");
  await page.locator("#wipe-a").selectOption("0");
  await page.locator("#wipe-b").selectOption("1");
  await page.locator("body").press("w");
  check(await page.locator("#layout").inputValue() === "side" && await divider.isHidden(), "w puts them side by side again");
}

// Where the pictures are in their stages, and how wide.
const places = page => page.evaluate(() => window.reframeStage.panels.map(({ stage, content }) => {
  const [outer, inner] = [stage, content].map(box => box.getBoundingClientRect());
  return { scale: inner.width, height: inner.height, left: inner.left - outer.left, top: inner.top - outer.top };
}));

async function check_zoom(page, check) {
  await page.evaluate(() => scrollTo(0, 0));
  const [before] = await places(page), stage = await page.locator(".stage").first().boundingBox();
  await page.locator("#zoom-in").click();
  await page.locator("#zoom-in").click();
  await settle(page);
  const zoomed = await places(page);
  check(Math.abs(zoomed[0].scale / before.scale - 2.25) < 0.01 && zoomed.every(place => Math.abs(place.scale - zoomed[0].scale) < 0.05 * zoomed[0].scale), "the button zooms all panels alike");
  await page.mouse.move(stage.x + 60, stage.y + 60);
  await page.mouse.down();
  await page.mouse.move(stage.x + 100, stage.y + 80, { steps: 3 });
  await page.mouse.up();
  await settle(page);
  const moved = await places(page);
  const [across, down] = [40 / moved[0].scale, 20 / moved[0].height]; // shares of the picture
  check(moved.every((place, i) => Math.abs((place.left - zoomed[i].left) / place.scale - across) < 0.002 && Math.abs((place.top - zoomed[i].top) / place.height - down) < 0.002), "dragging moves the pictures alike");
  const at = place => [(60 - place.left) / place.scale, (60 - place.top) / place.scale];
  await page.mouse.move(stage.x + 60, stage.y + 60);
  await page.keyboard.down("Control");
  await page.mouse.wheel(0, -120);
  await page.keyboard.up("Control");
  await settle(page);
  const [wheeled] = await places(page);
  check(wheeled.scale > 1.5 * moved[0].scale && at(wheeled).every((share, i) => Math.abs(share - at(moved[0])[i]) < 0.01), "Ctrl and the wheel zoom about the pointer");
  await page.locator("#zoom-pixels").click();
  check(await page.locator("#zoom-value").textContent() === "100 %", "1:1 shows a pixel as one");
  await page.locator("body").press("+");
  await page.locator("#zoom-fit").click();
  check(Math.abs((await places(page))[0].scale - before.scale) < 0.01, "and Fit fits it again");
}

// wanted: "x,y:r,g,b" of the first sequence's file.
async function check_probe(page, check, wanted, is_coarse) {
  const box = page.locator("#probe"), row = box.locator("div").first();
  const where = () => box.locator("p").first().textContent();
  const [x, y] = wanted ? wanted.split(":")[0].split(",").map(Number) : [3, 2];
  const point = await page.evaluate(([x, y]) => {
    const { content, sequence } = window.reframeStage.panels[0], rect = content.getBoundingClientRect();
    return [rect.left + (x + 0.5) / sequence.file_width * rect.width, rect.top + (y + 0.5) / sequence.file_height * rect.height];
  }, [x, y]);
  await page.mouse.move(...point);
  check((await where()).startsWith(`Pixel ${x}, ${y}`), `pointing probes a pixel: ${await where()}`);
  const told = (await row.locator("b").textContent()).split(/\s+/).map(Number);
  if (wanted) {
    const values = wanted.split(":")[1].split(",").map(Number);
    check(values.every((value, c) => Math.abs(told[c] - value) <= 0.001 * Math.abs(value)), `in scene values: ${told.join(" ")}`);
  }
  check(((await box.locator("p").last().textContent()).includes("the mean of")) === is_coarse, `and says ${is_coarse ? "that they are means" : "nothing of means"}`);
  await page.mouse.click(...point);
  await page.mouse.move(point[0] + 40, point[1]);
  check((await where()).includes(`Pixel ${x}, ${y} `) && (await where()).includes("pinned") && await page.locator(".cross").first().isVisible(), "a click pins it");
  await page.locator("body").press("ArrowUp");
  check((await row.locator("b").textContent()).split(/\s+/).map(Number).every((value, c) => value === told[c]), "exposure does not change the values");
  await page.locator("#exposure-reset").click();
  await page.locator(".stage").first().focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowDown");
  check((await where()).startsWith(`Pixel ${x + 1}, ${y + 1}`) && await box.getAttribute("aria-live") === "polite", "arrow keys on the picture move it, and it is read out");
  await page.keyboard.press("Escape");
  check((await where()).startsWith("Point at") && await page.locator(".cross").first().isHidden(), "Escape lets it go");
  await page.mouse.move(2, 2);
}

// A Cryptomatte: its names at pixels of the files, such as "left@10,20;right@80,20".
async function check_mattes(page, check, wanted) {
  if (!wanted)
    return;
  await page.evaluate(() => scrollTo(0, 0));
  await page.locator("#view").selectOption("CryptoObject");
  await page.waitForFunction(() => window.reframePlayer.shown >= 0);
  for (const [name, place] of wanted.split(";").map(part => part.split("@"))) {
    await page.evaluate(([x, y]) => window.reframeProbe.point((x + 0.5) / window.reframeProbe.data.sequences[0].file_width, (y + 0.5) / window.reframeProbe.data.sequences[0].file_height, "hover"), place.split(",").map(Number));
    const told = await page.locator("#probe div").first().locator("span").textContent();
    check(told === `CryptoObject: ${name}`, `the probe names what covers ${place}: ${told}`);
  }
  await page.evaluate(() => window.reframeProbe.clear());
  await page.locator("#view").selectOption("picture");
  await page.waitForFunction(() => window.reframePlayer.shown >= 0);
}

// Everything that takes the focus has a name; ids are unique; what refers to an id finds it; text stands out from its ground.
async function check_names(page, check) {
  const found = await page.evaluate(() => {
    const name = element => element.getAttribute("aria-label") || (element.labels && [...element.labels].map(label => label.textContent.trim()).join("")) || element.textContent.trim() || element.getAttribute("aria-labelledby");
    const ids = [...document.querySelectorAll("[id]")].map(element => element.id);
    const refers = [...document.querySelectorAll("[aria-controls], [aria-labelledby]")].flatMap(element => [element.getAttribute("aria-controls"), element.getAttribute("aria-labelledby")]).filter(Boolean);
    return {
      nameless: [...document.querySelectorAll("button, select, input, [tabindex='0'], svg[role=img]")].filter(element => !name(element)).map(element => element.outerHTML.slice(0, 80)),
      twice: ids.filter((id, i) => ids.indexOf(id) !== i), lost: refers.filter(id => !document.getElementById(id)),
    };
  });
  check(found.nameless.length + found.twice.length + found.lost.length === 0, `everything has a name ${JSON.stringify(found)}`);
}

const contrast = page => page.evaluate(() => {
  const light = text => {
    const [r, g, b] = text.match(/[\d.]+/g).map(value => (value / 255 <= 0.04045 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const probe = document.createElement("span"), of = name => {
    probe.style.color = `var(${name})`;
    return light(getComputedStyle(probe).color);
  };
  document.body.append(probe);
  const ratios = ["--text", "--dim", "--accent", "--alert"].map(name => {
    const [a, b] = [of(name), of("--card")].sort((x, y) => y - x);
    return (a + 0.05) / (b + 0.05);
  });
  const ground = of("--ground");
  probe.remove();
  return { ground, least: Math.min(...ratios) };
});

async function check_schemes(page, check) {
  await page.emulateMedia({ colorScheme: "light" });
  const light = await contrast(page);
  await page.emulateMedia({ colorScheme: "dark" });
  const dark = await contrast(page);
  await page.emulateMedia({ colorScheme: null });
  check(light.ground > 0.8 && dark.ground < 0.05 && Math.min(light.least, dark.least) >= 4.5, `light and dark, with contrast ${light.least.toFixed(1)} and ${dark.least.toFixed(1)}`);
}

// 360 pixels wide, by touch.
async function check_phone(browser, url, check, picture) {
  const context = await browser.newContext({ viewport: { width: 360, height: 740 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true });
  const page = await context.newPage(), said = [];
  page.on("console", message => ["error", "warning"].includes(message.type()) && said.push(message.text()));
  page.on("pageerror", error => said.push(String(error)));
  await page.goto(url);
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes", null, { timeout: 60000 });
  const width = () => page.evaluate(() => Math.max(document.documentElement.scrollWidth, document.body.scrollWidth, innerWidth));
  const wide = () => page.evaluate(() => [...document.querySelectorAll("main *")].filter(element => element.getBoundingClientRect().right > 361 && !element.closest(".stage, svg")).map(element => element.outerHTML.slice(0, 60)));
  check(await width() === 360 && (await wide()).length === 0, `on a phone nothing is wider than the screen ${(await wide()).slice(0, 3).join(" ")}`);
  const stage = page.locator(".stage").first();
  await stage.scrollIntoViewIfNeeded();
  await stage.tap({ position: { x: 40, y: 30 } });
  check((await page.locator("#probe p").first().textContent()).includes("pinned"), "a tap probes");
  if (await page.locator("#layout").isVisible())
    await page.locator("#layout").selectOption("wipe");
  check(await width() === 360 && (await wide()).length === 0, "nor with a wipe");
  if (picture)
    await page.screenshot({ path: picture, fullPage: true });
  check(said.length === 0, `and nothing is said there ${said.join(" | ").slice(0, 300)}`);
  await context.close();
}

module.exports = { check_aovs, check_mix, check_wipe, check_zoom, check_probe, check_mattes, check_names, check_schemes, check_phone };
