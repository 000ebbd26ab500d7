// Pages made by the program, opened from disk.

import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import type { Page } from "@playwright/test";

const root = fileURLToPath(new URL("../../", import.meta.url));

/** The program; CI names the one that it has built. */
const program = process.env.HULLWRIGHT ?? join(root, "target/debug/hullwright");

export const folder = mkdtempSync(join(tmpdir(), "hullwright-view-"));

/** Pictures to be looked at. */
export const shots = fileURLToPath(new URL("../shots/", import.meta.url));
mkdirSync(shots, { recursive: true });

export const asset = (name: string) => join(root, "assets", name);

export const mesh = (name: string) => fileURLToPath(new URL(name, import.meta.url));

/** Writes a page about a mesh, and returns its address. */
export function view(mesh: string, name: string, ...options: string[]): string {
  const page = join(folder, name);
  execFileSync(program, ["view", mesh, "-o", page, ...options], { stdio: "pipe" });
  writeFileSync(page, withTemplate(readFileSync(page, "utf8")));
  return pathToFileURL(page).href;
}

/** The page's data in the template as it is now: the program may have been built with the one before. */
function withTemplate(page: string): string {
  const template = readFileSync(join(root, "crates/cli/src/viewer/template.html"), "utf8");
  const begin = page.indexOf('<script type="application/json" id="data">');
  const end = page.indexOf("</script>", page.indexOf('id="geometry">')) + "</script>".length;
  return template.replace("<!--data-->", () => page.slice(begin, end));
}

export interface Watched {
  errors: string[];
  requests: string[];
}

/** Opens a page; what goes wrong and what is asked for is kept. */
export async function open(page: Page, address: string): Promise<Watched> {
  const watched: Watched = { errors: [], requests: [] };
  page.on("pageerror", (error) => watched.errors.push(String(error)));
  page.on("console", (message) => {
    // Of software rendering the browser itself complains.
    const isOwn = /GPU stall|Automatic fallback to software/.test(message.text());
    if (["error", "warning"].includes(message.type()) && !isOwn) watched.errors.push(message.text());
  });
  page.on("request", (request) => {
    if (request.url() !== address) watched.requests.push(request.url());
  });
  await page.goto(address);
  await page.waitForSelector("html[data-ready]");
  await settled(page);
  return watched;
}

/** Waits until everything that changed is drawn. */
export async function settled(page: Page) {
  await page.evaluate(
    () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))),
  );
}

/** The canvas as a string, and the share of it that is drawn on. */
export async function picture(page: Page): Promise<{ text: string; filled: number }> {
  await settled(page);
  return page.evaluate(() => {
    const canvas = document.querySelector("canvas")!;
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [160, 100];
    const context = copy.getContext("2d")!;
    context.drawImage(canvas, 0, 0, 160, 100);
    const pixels = context.getImageData(0, 0, 160, 100).data;
    let filled = 0;
    for (let i = 3; i < pixels.length; i += 4) filled += pixels[i] > 0 ? 1 : 0;
    return { text: pixels.join(","), filled: filled / 16_000 };
  });
}
