// A demo of `crates/demos` in Chromium, drawn by WebGL2 without a graphics card: a worker decomposes its models, they fall,
// and when all lie still a picture is written. Prints what the program says. Fails without an answer of a worker, if
// nothing is to be seen, and on any warning or error. `npm run window -- DEMO PICTURE`, of which `minimal` and
// `build/window/minimal.png` are the defaults. Needs the package built: `npm run build`.

import { cpSync, writeFileSync } from "node:fs";
import { chromium } from "playwright-core";
import { launchOptions } from "../../../viewer/chromium.mjs";
import { ROOT, buildProgram, copyWorker, countAnswers, folderOf } from "./program.mjs";
import { openPage, serve } from "./tests/browser.mjs";

const FOLDER = folderOf("window");
const [demo = "minimal", picture = `${FOLDER}/${demo}.png`] = process.argv.slice(2);
/** Milliseconds until the picture: without a graphics card it is some minutes. */
const MOST = 900_000;

buildProgram(FOLDER, demo, "--package", "hullwright_demos", "--bin", demo);
copyWorker(`${FOLDER}/hullwright`);
cpSync(`${ROOT}/assets`, `${FOLDER}/assets`, { recursive: true });
const start = `import start from "./${demo}.js"; start({ module_or_path: "./${demo}_bg.wasm" });`;
writeFileSync(`${FOLDER}/index.html`, `<!doctype html><title>${demo}</title><body style="margin: 0"><script type="module">${start}</script>`);

const server = await serve(FOLDER);
const browser = await chromium.launch(launchOptions);
try {
  const page = await openPage(browser, server.address);
  page.on("pageerror", () => (process.exitCode = 1));
  page.on("console", (message) => {
    const text = message.text();
    if (process.env.ALL) console.log(message.type(), text);
  });
  await page.addInitScript(countAnswers);
  const download = page.waitForEvent("download", { timeout: MOST });
  await page.goto(`${server.address}/index.html?--screenshot&${demo}.png`);
  await (await download).saveAs(picture);
  const answers = await page.evaluate(() => window.answers);
  console.log(`${picture}: ${answers} answers of workers`);
  if (answers === 0) process.exitCode = 1;
} finally {
  await browser.close();
  server.close();
}
