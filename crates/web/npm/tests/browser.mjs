// Debian's Chromium, and a server of a folder for it.

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const PACKAGE = fileURLToPath(new URL("..", import.meta.url));

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };

/** Serves a folder without any header but the type, as the simplest host does. */
export async function serve(folder) {
  const server = createServer(async ({ url }, response) => {
    const path = normalize(decodeURIComponent(new URL(url, "http://host").pathname));
    try {
      if (path === "/") return response.setHeader("Content-Type", "text/html").end("<!doctype html><title>-</title>");
      const file = path.endsWith("/") ? `${path}index.html` : path;
      const bytes = await readFile(join(folder, file));
      response.setHeader("Content-Type", TYPES[extname(file)] ?? "application/octet-stream").end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { address: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

export const launch = () =>
  chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--disable-sync"] });

/** A page of the folder's server that fails the test on any error in it. */
export async function openPage(browser, address) {
  const page = await browser.newPage();
  page.on("pageerror", (error) => console.error("in the page:", error));
  await page.goto(address);
  return page;
}
