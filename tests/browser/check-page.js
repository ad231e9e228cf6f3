// node check-page.js PAGE.html [--pictures FOLDER] [--seconds S] [--mean M] [--probe X,Y:R,G,B]
//                    [--mattes NAME@X,Y;...] [--coarse] [--quick]
// Opens a page of `reframe report` in headless Chromium, from its file, and uses it
// as a person would. --seconds: it loads faster; --mean: of the bytes of the first
// picture; --probe: scene values at a pixel of the first
// sequence; --mattes: names there by CryptoObject; --coarse: the page has means of pixels;
// --quick: exposure and playing only; --pictures: leaves screenshots. Needs the npm package
// playwright-core (where REFRAME_NODE_MODULES says) and Chromium (REFRAME_CHROMIUM, else
// found). One line for each check; exit status 1 where one failed, 77 where there is no browser.
"use strict";
const fs = require("fs"), path = require("path"), { pathToFileURL } = require("url");

const features = require("./check-features.js");
const { load_playwright, find_chromium } = require("./browser.js");

const page_file = process.argv[2];
const option = name => process.argv.includes(name) ? process.argv[process.argv.indexOf(name) + 1] : null;
const pictures = option("--pictures"), most_seconds = Number(option("--seconds") || 0), mean = option("--mean"), quick = process.argv.includes("--quick");

let failures = 0;
function check(holds, words) {
  console.log(`${holds ? "ok" : "FAILED"}: ${words}`);
  failures += holds ? 0 : 1;
}

// Mean and a hash of what a panel shows.
const look = (page, index = 0) => page.evaluate(index => {
  const canvas = document.querySelectorAll("#panels canvas")[index], { width, height } = canvas;
  const copy = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const data = copy.getImageData(0, 0, width, height).data;
  let sum = 0, hash = 17;
  for (let i = 0; i < data.length; i += 4) {
    sum += data[i] + data[i + 1] + data[i + 2];
    hash = (Math.imul(hash, 31) + data[i] + 256 * data[i + 1] + 65536 * data[i + 2]) | 0;
  }
  return { mean: sum / (0.75 * data.length), hash, frame: canvas.dataset.frame, width, height };
}, index);

const state = page => page.evaluate(() => {
  const { index, playing, exposure, count } = window.reframePlayer;
  return { index, playing, exposure, count };
});

async function shown(page, index) {
  await page.waitForFunction(index => window.reframePlayer.shown === index, index, { timeout: 20000 });
}

async function check_exposure(page) {
  await page.locator("#exposure-reset").click();
  const before = await look(page);
  await page.locator("#exposure").evaluate(slider => {
    slider.value = 2;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  });
  const after = await look(page);
  check(after.mean > before.mean + 5 && after.hash !== before.hash, `the exposure slider changes the picture: ${before.mean.toFixed(1)} to ${after.mean.toFixed(1)}`);
  await page.locator("#exposure-reset").click();
  const again = await look(page);
  check(again.hash === before.hash, "exposure 0 gives back what was there");
  await page.keyboard.press("ArrowDown");
  check((await state(page)).exposure === -0.5 && (await look(page)).mean < before.mean, "arrow down darkens");
  await page.keyboard.press("0");
  if (await page.locator("#curve").isVisible()) {
    await page.locator("#curve").selectOption("srgb");
    check((await look(page)).hash !== before.hash, "the view is another picture than the sRGB curve");
    await page.locator("#curve").selectOption("view");
  }
  check((await look(page)).hash === before.hash, "exposure and view go there and back");
}

async function check_seeking(page, count) {
  const first = await look(page);
  await page.locator("#scrubber").evaluate((slider, value) => {
    slider.value = value;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  }, count - 1);
  await shown(page, count - 1);
  const last = await look(page);
  check(last.hash !== first.hash && last.frame !== first.frame, "the scrubber shows another frame");
  await page.locator("body").press("Home");
  await shown(page, 0);
  check((await look(page)).hash === first.hash, "the first frame is what it was");
  await page.locator("body").press("ArrowRight");
  await shown(page, 1);
  check((await state(page)).index === 1, "arrow right steps");
  for (const chart of await page.locator(".chart svg").all()) {
    await chart.scrollIntoViewIfNeeded();
    const box = await chart.boundingBox(), name = await chart.getAttribute("aria-label");
    await page.mouse.click(box.x + box.width - 16, box.y + 60);
    await page.waitForTimeout(50);
    await page.waitForFunction(() => window.reframePlayer.shown === window.reframePlayer.index);
    const right = (await state(page)).index;
    await page.mouse.click(box.x + 60, box.y + 60);
    await page.waitForTimeout(50);
    await page.waitForFunction(() => window.reframePlayer.shown === window.reframePlayer.index);
    const left = (await state(page)).index;
    check(right === count - 1 && left <= 1, `the curve "${name}" seeks: ${right}, then ${left}`);
    const cursor = await chart.locator(".cursor").boundingBox();
    check(cursor.x < box.x + 0.5 * box.width, `its line follows`);
  }
}

async function check_playing(page, count) {
  await page.locator("body").press("Home");
  await shown(page, 0);
  await page.evaluate(() => {
    window.seen = new Set();
    window.changes = 0;
    let last = -1;
    const onChange = window.reframePlayer.onChange;
    window.reframePlayer.onChange = () => {
      const player = window.reframePlayer;
      window.seen.add(player.index);
      window.changes += player.index !== last ? 1 : 0;
      last = player.index;
      onChange();
    };
  });
  await page.locator("#play").click();
  check((await state(page)).playing, "the button plays");
  const wanted = Math.min(5, count);
  await page.waitForFunction(wanted => window.seen.size >= wanted, wanted, { timeout: 30000 });
  const start = Date.now(), before = await page.evaluate(() => window.changes);
  await page.waitForTimeout(2000);
  const seconds = (Date.now() - start) / 1000, after = await page.evaluate(() => window.changes);
  console.log(`   plays ${((after - before) / seconds).toFixed(1)} frames a second`);
  await page.locator("body").press(" ");
  check(!(await state(page)).playing, "space pauses");
  const still = await look(page);
  await page.waitForTimeout(300);
  check((await look(page)).hash === still.hash, "and it stands");
}

async function run(browser) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 1000 } });
  const page = await context.newPage();
  const said = [], asked = [];
  page.on("console", message => ["error", "warning"].includes(message.type()) && said.push(message.text()));
  page.on("pageerror", error => said.push(String(error)));
  page.on("request", request => asked.push(request.url()));
  const start = Date.now();
  await page.goto(pathToFileURL(path.resolve(page_file)).href);
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes", null, { timeout: 60000 });
  const seconds = (Date.now() - start) / 1000, bytes = fs.statSync(page_file).size;
  const { count } = await state(page), first = await look(page);
  console.log(`   ${count} frames of ${first.width}x${first.height}, ${(bytes / 1e6).toFixed(1)} MB, first frame after ${seconds.toFixed(2)} s`);
  if (most_seconds > 0)
    check(seconds < most_seconds, `it loads in less than ${most_seconds} s`);
  check(first.mean > 0 && first.frame !== "", "a frame is shown");
  if (mean)
    check(Math.abs(first.mean - Number(mean)) < 1.5, `it has the brightness that it should: ${first.mean.toFixed(1)}`);
  if (pictures)
    await page.screenshot({ path: path.join(pictures, "page.png"), fullPage: true });
  await features.check_names(page, check);
  await check_exposure(page);
  if (!quick) {
    await features.check_aovs(page, check, look);
    await features.check_mix(page, check, look);
    await features.check_zoom(page, check);
    await features.check_probe(page, check, option("--probe"), process.argv.includes("--coarse"));
    await features.check_mattes(page, check, option("--mattes"));
    await features.check_wipe(page, check);
    await features.check_schemes(page, check);
  }
  if (count > 1) {
    await check_seeking(page, count);
    await check_playing(page, count);
  }
  if (pictures) {
    await page.emulateMedia({ colorScheme: "dark" });
    await page.setViewportSize({ width: 1280, height: 720 });
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ path: path.join(pictures, "page-dark.png") });
  }
  if (!quick)
    await features.check_phone(browser, pathToFileURL(path.resolve(page_file)).href, check, pictures ? path.join(pictures, "page-phone.png") : null);
  check(await page.locator("#failure").isHidden(), "the page tells of no failure");
  check(said.length === 0, `nothing is said in the console${said.length > 0 ? ": " + said.join(" | ").slice(0, 500) : ""}`);
  const others = asked.filter(url => !/^(file|blob|data):/.test(url));
  check(others.length === 0 && asked.filter(url => url.startsWith("file:")).length === 1, `nothing else is loaded ${others.join(" ")}`);
}

async function main() {
  const playwright = load_playwright(), chromium = find_chromium();
  if (!playwright || !chromium) {
    console.log(`skipped: there is no ${!chromium ? "Chromium" : "playwright-core"}: scripts/install-packages --browser gets it`);
    process.exit(77);
  }
  const browser = await playwright.chromium.launch({ executablePath: chromium, args: ["--no-sandbox"] });
  try {
    await run(browser);
  } finally {
    await browser.close();
  }
  process.exit(failures > 0 ? 1 : 0);
}

main().catch(error => {
  console.log(`FAILED: ${error}`);
  process.exit(1);
});
