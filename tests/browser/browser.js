// Finds the browser, and the npm package that drives it.
"use strict";
const fs = require("fs"), path = require("path");

function load_playwright() {
  for (const folder of [process.env.REFRAME_NODE_MODULES, __dirname].filter(Boolean)) {
    try {
      return require(require.resolve("playwright-core", { paths: [folder, path.dirname(folder)] }));
    } catch (error) { /* the next one */ }
  }
  return null;
}

function find_chromium() {
  const names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
  const places = (process.env.PATH || "").split(":").flatMap(folder => names.map(name => path.join(folder, name)));
  return [process.env.REFRAME_CHROMIUM, ...places].filter(Boolean).find(place => fs.existsSync(place));
}

module.exports = { load_playwright, find_chromium };
