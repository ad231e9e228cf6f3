// node check-live.js URL [--pictures FOLDER]
// Opens the live page of a render that goes on (`reframe render --preview PORT`) in headless Chromium, and uses it as a person would:
// it follows the frame in work, shows a finished one, and changes the exposure. As check-page.js otherwise.
"use strict";
const { load_playwright, find_chromium } = require("./browser.js");

const url = process.argv[2];
const pictures = process.argv.includes("--pictures") ? process.argv[process.argv.indexOf("--pictures") + 1] : null;

let failures = 0;
function check(holds, words) {
  console.log(`${holds ? "ok" : "FAILED"}: ${words}`);
  failures += holds ? 0 : 1;
}

const mean = page => page.evaluate(() => {
  const canvas = document.getElementById("picture"), { width, height } = canvas;
  const copy = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const data = copy.getImageData(0, 0, width, height).data;
  let sum = 0;
  for (let i = 0; i < data.length; i += 4)
    sum += data[i] + data[i + 1] + data[i + 2];
  return sum / (0.75 * data.length);
});

async function use(page) {
  await page.goto(url);
  await page.waitForFunction(() => window.reframeLive.shown.startsWith("work"), null, { timeout: 60000 });
  const before = await mean(page), first = await page.evaluate(() => window.reframeLive.version);
  check(before > 1, `the frame in work is there, of mean ${before.toFixed(1)}`);
  check((await page.locator("#progress-text").textContent()).includes("in work"), "the progress names it");
  await page.waitForFunction(first => window.reframeLive.version > first, first, { timeout: 60000 });
  check(true, "it is refreshed");
  await page.locator("#exposure").evaluate(slider => {
    slider.value = 3;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  });
  const brighter = await mean(page);
  check(brighter > before + 5, `exposure brightens it: ${before.toFixed(1)} to ${brighter.toFixed(1)}`);
  await page.waitForFunction(() => window.reframeLive.status.finished.length > 0, null, { timeout: 60000 });
  if (pictures)
    await page.screenshot({ path: `${pictures}/live.png` });
  await page.locator("#pass").selectOption({ label: "depth" });
  await page.waitForFunction(() => window.reframeLive.shown.startsWith("pass"), null, { timeout: 60000 });
  check(await page.locator("#exposure").isDisabled() && Math.abs(await mean(page) - brighter) > 1, "the depth of a finished frame is shown, without exposure");
  await page.locator("#pass").selectOption({ label: "Image" });
  await page.waitForFunction(() => window.reframeLive.shown.startsWith("work"), null, { timeout: 60000 });
  await page.locator("#scrubber").evaluate(slider => {
    slider.value = 0;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await page.waitForFunction(() => window.reframeLive.shown.startsWith("frame"), null, { timeout: 60000 });
  check(true, "a finished frame is shown");
  await page.locator("#follow").click();
  await page.waitForFunction(() => window.reframeLive.shown.startsWith("work"), null, { timeout: 60000 });
  check(true, "and the frame in work again");
}

async function main() {
  const playwright = load_playwright(), executablePath = find_chromium();
  if (!playwright || !executablePath) {
    console.log("skipped: there is no playwright-core or no Chromium: scripts/install-packages --browser gets them");
    process.exit(77);
  }
  const browser = await playwright.chromium.launch({ executablePath, args: ["--no-sandbox"] });
  const page = await browser.newPage({ viewport: { width: 1100, height: 700 } });
  const said = [];
  page.on("console", message => said.push(message.text()));
  page.on("pageerror", error => said.push(error.message));
  await use(page);
  check(said.length === 0, `nothing on the console ${said.join("; ")}`);
  await browser.close();
  process.exit(failures > 0 ? 1 : 0);
}
main().catch(error => {
  console.log(`FAILED: ${error.message}`);
  process.exit(1);
});
