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
/** Milliseconds until the picture, which takes two minutes without a graphics card. */
const MOST = 900_000;
/** A line of the program's log: level, file and text, with colours. */
const LINE = /^%c([A-Z]+)%c (\S*)%c(.*?) color: /s;

buildProgram(FOLDER, demo, "--package", "hullwright_demos", "--bin", demo);
copyWorker(`${FOLDER}/hullwright`);
cpSync(`${ROOT}/assets`, `${FOLDER}/assets`, { recursive: true });
const start = `import start from "./${demo}.js"; start({ module_or_path: "./${demo}_bg.wasm" });`;
writeFileSync(`${FOLDER}/index.html`, `<!doctype html><title>${demo}</title><body style="margin: 0"><script type="module">${start}</script>`);

/** Prints what the program says, and fails as soon as something is wrong. Bevy warns of all that WebGL2 lacks: files that are
 * not of this repository have absolute paths. */
function listen(page, fail) {
  page.on("pageerror", fail);
  page.on("console", (message) => {
    const [, level, file, text] = LINE.exec(message.text()) ?? [];
    if (!level || (file.startsWith("/") && level !== "ERROR")) return;
    console.log(text.trim());
    if (level === "WARN" || level === "ERROR") fail(new Error("see above"));
  });
}

const server = await serve(FOLDER);
const browser = await chromium.launch(launchOptions);
try {
  const page = await openPage(browser, server.address);
  await page.addInitScript(countAnswers);
  const failed = new Promise((_, fail) => listen(page, fail));
  const written = page.waitForEvent("download", { timeout: MOST });
  await page.goto(`${server.address}/index.html?--screenshot&${demo}.png`);
  const download = await Promise.race([written, failed]);
  await download.saveAs(picture);
  const answers = await page.evaluate(() => window.answers);
  console.log(`${picture}, answers of workers: ${answers}`);
  if (answers === 0) throw new Error("no worker has answered");
} finally {
  await browser.close();
  server.close();
}
