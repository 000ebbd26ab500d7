// Pictures of pages to be looked at: `npm run look -- FOLDER PAGE…` writes each page in light, in dark, with errors as
// colours, and as a telephone shows it. It fails if a page reports an error or asks for anything.

import { mkdirSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "@playwright/test";
import { launchOptions } from "./chromium.mjs";

const [folder, ...pages] = process.argv.slice(2);
if (!pages.length) {
  console.error("npm run look -- FOLDER PAGE…");
  process.exit(2);
}
mkdirSync(folder, { recursive: true });

const desk = { viewport: { width: 1280, height: 800 } };
const phone = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true };
const looks = [
  { name: "light", options: { ...desk, colorScheme: "light" }, keys: [] },
  { name: "dark", options: { ...desk, colorScheme: "dark" }, keys: ["e"] },
  { name: "errors", options: { ...desk, colorScheme: "light" }, keys: ["c", "m"] },
  { name: "phone", options: { ...phone, colorScheme: "light" }, keys: [] },
];

const browser = await chromium.launch(launchOptions);
let faults = 0;
for (const path of pages) {
  const address = pathToFileURL(resolve(path)).href;
  for (const { name, options, keys } of looks) {
    const context = await browser.newContext({ ...options, reducedMotion: "reduce" });
    const page = await context.newPage();
    const fault = (what) => {
      faults++;
      console.error(`${path}: ${what}`);
    };
    page.on("pageerror", (error) => fault(error));
    page.on("request", (request) => request.url() !== address && fault(`asks for ${request.url()}`));
    await page.goto(address);
    await page.waitForSelector("html[data-ready]");
    for (const key of keys) await page.keyboard.press(key);
    await page.waitForTimeout(500);
    await page.screenshot({ path: join(folder, `${basename(path, ".html")}-${name}.png`) });
    await context.close();
  }
}
await browser.close();
process.exit(faults ? 1 : 0);
