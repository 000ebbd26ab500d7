// The page to try the method, as `npm run try` builds it, opened from disk. With HULLWRIGHT_MESHES=FOLDER it is fed foreign
// files too.

import { existsSync, readdirSync, readFileSync, statSync } from "node:fs";
import { fileURLToPath, pathToFileURL } from "node:url";
import { basename, join } from "node:path";
import { expect, test, type Page } from "@playwright/test";
import { asset, shots } from "./page";

const FILE = fileURLToPath(new URL("../dist/try.html", import.meta.url));

/** The hulls of the first model, the mug, under the default settings, as the library's own tests have them. */
const MUG_HULLS = 22;

const failures: string[] = [];

/** Opens the page, and waits for its first model. */
async function start(page: Page) {
  failures.length = 0;
  page.on("pageerror", (error) => failures.push(String(error)));
  page.on("console", (message) => message.type() === "error" && failures.push(message.text()));
  page.on("request", (request) => /^https?:/.test(request.url()) && failures.push(`loads ${request.url()}`));
  await page.goto(pathToFileURL(FILE).href);
  await shown(page, 1);
}

test.afterEach(() => expect(failures).toEqual([]));

/** Waits until so many decompositions were shown. */
const shown = (page: Page, count: number) => expect(page.locator("html")).toHaveAttribute("data-shown", String(count), { timeout: 90_000 });

const hulls = async (page: Page) => parseInt((await page.locator(".count").first().textContent()) ?? "");

test("the file has at most 4 MB, and loads nothing", async ({ page }) => {
  expect(statSync(FILE).size).toBeLessThanOrEqual(4_000_000);
  await start(page);
  await expect(page.locator("#title")).toHaveText("mug");
  expect(await hulls(page)).toBe(MUG_HULLS);
  await page.screenshot({ path: join(shots, "try-light.png") });
});

test("settings decompose anew while the old hulls stay, and the newest wins", async ({ page }) => {
  await start(page);
  await page.locator("#preset").selectOption("fine");
  // The old hulls can be looked at meanwhile.
  await expect(page.locator("html")).toHaveAttribute("data-busy", "true");
  expect(await hulls(page)).toBe(MUG_HULLS);
  await page.locator("#preset").selectOption("fast");
  await page.locator("#bound").fill("9");
  await page.locator("#max-hulls").fill("6");
  await page.locator("#openings-rule").selectOption("keep");
  await shown(page, 2);
  expect(await hulls(page)).toBe(6);
  await expect(page.locator("#about")).toContainText("bound 5 %");
  await expect(page.locator("#remarks")).toContainText("limit on hulls");
  await page.locator("#max-hulls").fill("");
  await page.locator("#probe").fill("10");
  await shown(page, 3);
  const filled = await hulls(page);
  await page.locator("#probe").fill("0");
  await shown(page, 4);
  expect(filled).toBeLessThan(await hulls(page));
});

test("a setting that can't be is refused in words, and the next one works", async ({ page }) => {
  await start(page);
  await page.locator("#max-vertices").fill("3");
  await expect(page.locator("#failure")).toContainText("at least 8");
  expect(await hulls(page)).toBe(MUG_HULLS);
  await page.locator("#max-vertices").fill("16");
  await shown(page, 2);
  await expect(page.locator("#failure")).toBeHidden();
});

test("a decomposition is cancelled, and what was shown stays", async ({ page }) => {
  await start(page);
  await page.locator("#model").selectOption("dog");
  await page.locator("#cancel").click();
  await expect(page.locator("html")).toHaveAttribute("data-busy", "false");
  await expect(page.locator("#title")).toHaveText("mug");
  await page.locator("#model").selectOption("chair");
  await shown(page, 2);
  await expect(page.locator("#title")).toHaveText("chair");
});

test("the slider joins hulls, and files and tag are of what is shown", async ({ page }) => {
  await start(page);
  await page.locator("#bound").fill("7");
  await shown(page, 2);
  await page.locator(".hulls-slider").fill("5");
  expect(await hulls(page)).toBe(5);
  const saved = async (id: string) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator(id).click()]);
    return [download.suggestedFilename(), readFileSync(await download.path())] as const;
  };
  const [name, file] = await saved("#save-hulls");
  expect(name).toBe("mug.hulls");
  expect(file.subarray(1, 6).toString()).toBe("HULLS");
  const [glbName, glb] = await saved("#save-glb");
  expect(glbName).toBe("mug-hulls.glb");
  const json = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)).toString());
  expect(json.meshes).toHaveLength(5);
  await page.locator("#copy-tag").click();
  await expect(page.locator("#status")).toHaveText("copied: ConvexDecomposition::default().with_max_error(0.03).with_max_hulls(5)");
  await page.locator("#copy-js").click();
  await expect(page.locator("#status")).toHaveText('copied: await decompose(mesh, { maxError: "3%", maxHulls: 5 })');
});

test("a bundled model drops in Rapier, and balls hit it", async ({ page }) => {
  await start(page);
  await page.locator("#drop").click();
  const physics = page.locator("#physics");
  await expect.poll(async () => Number((await physics.getAttribute("data-height")) ?? NaN), { timeout: 60_000 }).toBeLessThan(2.2);
  await page.keyboard.press("Space");
  await page.locator("#physics-canvas").click();
  await expect(physics).toHaveAttribute("data-balls", "2");
  // What is dragged turns the view, and throws nothing.
  const { x, y, width, height: tall } = (await page.locator("#physics-canvas").boundingBox())!;
  await page.mouse.move(x + width / 2, y + tall / 2);
  await page.mouse.down();
  await page.mouse.move(x + width / 2 + 120, y + tall / 2 - 40, { steps: 5 });
  await page.mouse.up();
  await page.keyboard.press("ArrowLeft");
  await expect(physics).toHaveAttribute("data-balls", "2");
  await page.waitForTimeout(1000);
  const height = Number(await physics.getAttribute("data-height"));
  expect(height).toBeGreaterThan(0);
  await page.screenshot({ path: join(shots, "try-physics.png") });
  await page.keyboard.press("a");
  await expect(physics).toHaveAttribute("data-balls", "0");
  await page.keyboard.press("Escape");
  await expect(physics).toBeHidden();
  // Once more, with another mesh.
  await page.locator("#model").selectOption("bowl");
  await shown(page, 2);
  await page.locator("#drop").click();
  await expect(page.locator("#physics-text")).toContainText("one body of 25 hulls", { timeout: 30_000 });
  // What falls is not of a mesh that is opened now.
  await page.locator("#files").setInputFiles(asset("dog.glb"));
  await expect(physics).toBeHidden();
});

test("the paper's hulls stand beside, in the dark and by keys alone", async ({ page }) => {
  await page.emulateMedia({ colorScheme: "dark" });
  await start(page);
  await page.locator("#compare").focus();
  await page.keyboard.press("Space");
  await shown(page, 2);
  await expect(page.locator(".panel")).toHaveCount(2);
  await page.locator("#canvas").focus();
  await page.keyboard.press("c");
  await page.keyboard.press("e");
  await expect(page.locator("#legend")).toBeVisible();
  await page.waitForTimeout(800);
  await page.screenshot({ path: join(shots, "try-dark.png") });
});

test("at a telephone's width all is within reach", async ({ page }) => {
  await page.setViewportSize({ width: 390, height: 844 });
  await start(page);
  expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBe(390);
  expect((await page.locator(".viewport").boundingBox())!.height).toBeGreaterThan(180);
  await page.screenshot({ path: join(shots, "try-phone.png") });
  await page.locator("summary").click();
  await page.locator("#preset").selectOption("fast");
  await shown(page, 2);
  expect((await page.locator(".viewport").boundingBox())!.height).toBeGreaterThan(180);
  await page.screenshot({ path: join(shots, "try-phone-settings.png") });
});

/** As a user drops them. */
async function feed(page: Page, ...files: (string | { name: string; mimeType: string; buffer: Buffer })[]) {
  await page.locator("#files").setInputFiles(files as string[]);
}

const textFile = (name: string, text: string | Buffer) => ({ name, mimeType: "", buffer: Buffer.from(text) });

test("broken files are refused in words, and what was shown stays", async ({ page }) => {
  await start(page);
  const document = '{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"parts.bin"}]}';
  for (const [file, words] of [
    [textFile("cut.glb", readFileSync(asset("mug.glb")).subarray(0, 300)), /header announces/],
    [textFile("empty.off", ""), /off/i],
    [textFile("<b>.obj", "v 0 0 0\nf 1 2 3\n"), /vertex|vertices/],
    [textFile("notes.txt", "a note"), /one mesh file is expected/],
    [textFile("parts.gltf", document), /parts\.bin/],
    [textFile("flat.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n"), /no usable triangle/],
  ] as const) {
    await feed(page, file);
    await expect(page.locator("#failure")).toContainText(words);
    await expect(page.locator("html")).toHaveAttribute("data-busy", "false");
    await expect(page.locator("#title")).toHaveText("mug");
  }
  const buffer = Buffer.alloc(36);
  [0, 0, 0, 1, 0, 0, 0, 1, 0].forEach((x, i) => buffer.writeFloatLE(x, 4 * i));
  await feed(page, textFile("parts.gltf", document), textFile("parts.bin", buffer));
  await shown(page, 2);
  await expect(page.locator("#title")).toHaveText("parts.gltf");
});

/** Some of each format, of any folder. */
function foreign(folder: string): string[] {
  const found = readdirSync(folder, { recursive: true, encoding: "utf8" }).filter((path) => !/nasty/.test(path)).sort();
  const some = (suffix: RegExp, count: number) => {
    const of = found.filter((path) => suffix.test(path)).filter((path) => statSync(join(folder, path)).size < 1_000_000);
    return Array.from({ length: Math.min(count, of.length) }, (_, i) => of[Math.floor((i * of.length) / count)]);
  };
  return [...some(/\.glb$/i, 4), ...some(/\.obj$/i, 3), ...some(/\.off$/i, 2), ...some(/\.stl$/i, 2), ...some(/\.ply$/i, 1)].map((path) => join(folder, path));
}

const meshes = process.env.HULLWRIGHT_MESHES ?? "";

test("foreign files are decomposed", async ({ page }) => {
  test.skip(!existsSync(meshes), "HULLWRIGHT_MESHES names no folder");
  test.setTimeout(600_000);
  await start(page);
  const files = foreign(meshes);
  for (const [index, file] of files.entries()) {
    await feed(page, file);
    await shown(page, index + 2);
    await expect(page.locator("#title")).toHaveText(basename(file));
    console.log(`${basename(file)}: ${await page.locator("#status").textContent()}`);
    if (index % 4 === 0) await page.screenshot({ path: join(shots, `try-foreign-${index}.png`) });
  }
  expect(files.length).toBeGreaterThanOrEqual(1);
});
