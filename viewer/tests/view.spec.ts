// Promises of the page, each tried in a browser.

import { expect, test, type Page } from "@playwright/test";
import { copyFileSync, statSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { asset, folder, mesh, open, picture, settled, shots, view, type Watched } from "./page";

let mug: string;
let compared: string;

test.beforeAll(() => {
  mug = view(asset("mug.glb"), "mug.html");
  compared = view(asset("table.glb"), "table.html", "--compare", "surface");
});

async function opened(page: Page, address: string): Promise<Watched> {
  const watched = await open(page, address);
  expect(watched).toEqual({ errors: [], requests: [] });
  return watched;
}

/** Does something, and expects another picture. */
async function changes(page: Page, act: () => Promise<unknown>) {
  const before = await picture(page);
  await act();
  const after = await picture(page);
  expect(after.text).not.toBe(before.text);
  expect(after.filled).toBeGreaterThan(0.02);
}

const count = (page: Page, panel = 0) => page.locator(".count").nth(panel).innerText();

test("a page opens from disk without errors and without any request", async ({ page }) => {
  const watched = await opened(page, mug);
  expect((await picture(page)).filled).toBeGreaterThan(0.05);
  await page.screenshot({ path: `${shots}mug.png` });
  await page.waitForTimeout(500);
  expect(watched).toEqual({ errors: [], requests: [] });
  expect(statSync(fileURLToPath(mug)).size).toBeLessThan(2 * 2 ** 20);
});

test("the slider goes through all numbers of hulls, with figures and picture", async ({ page }) => {
  await opened(page, mug);
  const slider = page.locator(".hulls-slider");
  const most = Number(await slider.getAttribute("max"));
  expect(await count(page)).toBe(`${most} hulls`);
  const error = page.locator(".error dd");
  let last = 0;
  for (const hulls of [most, 10, 5, 2, 1]) {
    await slider.fill(String(hulls));
    expect(await count(page)).toBe(hulls === 1 ? "1 hull" : `${hulls} hulls`);
    const now = parseFloat((await error.innerText()).replace("≤", ""));
    expect(now).toBeGreaterThanOrEqual(last);
    last = now;
    const shown = await page.evaluate(() => (window as any).hullwright.panels[0].hulls.length);
    expect(shown).toBe(hulls);
  }
  await changes(page, () => slider.fill(String(most)));
  await slider.fill("4");
  await page.screenshot({ path: `${shots}mug-4.png` });
  const marker = page.locator(".marker");
  const before = await marker.getAttribute("cx");
  await page.locator(".curve svg[role=img]").click({ position: { x: 250, y: 40 } });
  expect(await marker.getAttribute("cx")).not.toBe(before);
  expect(await count(page)).not.toBe("4 hulls");
});

for (const [button, key] of [
  ["mesh", "m"],
  ["wires", "w"],
  ["errors", "c"],
  ["up", "z"],
] as const) {
  test(`${button} changes the picture, by button and by key`, async ({ page }) => {
    await opened(page, mug);
    const pressed = () => page.locator(`#${button}`).getAttribute("aria-pressed");
    expect(await pressed()).toBe("false");
    await changes(page, () => page.locator(`#${button}`).click());
    expect(await pressed()).toBe("true");
    await page.screenshot({ path: `${shots}mug-${button}.png` });
    await changes(page, () => page.keyboard.press(key));
    expect(await pressed()).toBe("false");
  });
}

test("hulls alone, both, mesh alone: something is always to be seen", async ({ page }) => {
  await opened(page, mug);
  await changes(page, () => page.keyboard.press("h"));
  expect(await page.locator("#mesh").getAttribute("aria-pressed")).toBe("true");
  await page.screenshot({ path: `${shots}mug-mesh-alone.png` });
  await changes(page, () => page.keyboard.press("m"));
  expect(await page.locator("#hulls").getAttribute("aria-pressed")).toBe("true");
});

test("hulls move apart, by slider and by key", async ({ page }) => {
  await page.emulateMedia({ reducedMotion: "reduce" });
  await opened(page, mug);
  await changes(page, () => page.locator("#apart").fill("1"));
  await changes(page, () => page.keyboard.press("e"));
  expect(await page.locator("#apart").inputValue()).toBe("0");
  await changes(page, () => page.keyboard.press("e"));
  await page.screenshot({ path: `${shots}mug-apart.png` });
});

test("with motion hulls get apart over several frames, without it in one", async ({ page }) => {
  await opened(page, mug);
  const frames = async () => {
    const before = await page.evaluate(() => (window as any).hullwright.stage.frames);
    await page.keyboard.press("e");
    await page.waitForTimeout(900);
    return (await page.evaluate(() => (window as any).hullwright.stage.frames)) - before;
  };
  expect(await frames()).toBeGreaterThan(3);
  await page.emulateMedia({ reducedMotion: "reduce" });
  await page.reload();
  await page.waitForSelector("html[data-ready]");
  await settled(page);
  expect(await frames()).toBeLessThanOrEqual(2);
});

test("dragging and arrows turn, wheel and keys zoom, R looks from the start", async ({ page }) => {
  await page.emulateMedia({ reducedMotion: "reduce" });
  await opened(page, mug);
  const start = await picture(page);
  await changes(page, async () => {
    await page.mouse.move(600, 300);
    await page.mouse.down();
    await page.mouse.move(700, 340, { steps: 4 });
    await page.mouse.up();
  });
  await changes(page, () => page.keyboard.press("ArrowLeft"));
  await changes(page, () => page.keyboard.press("+"));
  await changes(page, () => page.mouse.wheel(0, 300));
  await page.keyboard.press("r");
  expect((await picture(page)).text).toBe(start.text);
});

test("a hull is picked by click and by key, and says what it is", async ({ page }) => {
  await opened(page, mug);
  const pick = page.locator(".pick");
  await expect(pick).toBeHidden();
  const box = (await page.locator(".viewport").boundingBox())!;
  await changes(page, () => page.mouse.click(box.x + box.width / 2, box.y + box.height * 0.62));
  await expect(pick).toContainText(/Hull \d+.*vertices.*volume.*protrusion/s);
  await page.screenshot({ path: `${shots}mug-picked.png` });
  const first = await pick.innerText();
  await page.keyboard.press("n");
  expect(await pick.innerText()).not.toBe(first);
  await page.keyboard.press("Escape");
  await expect(pick).toBeHidden();
});

test("light and dark follow the system, and T", async ({ page }) => {
  await page.emulateMedia({ colorScheme: "dark" });
  await opened(page, mug);
  const paper = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await paper();
  await page.screenshot({ path: `${shots}mug-dark.png` });
  await page.keyboard.press("t");
  const light = await paper();
  expect(light).not.toBe(dark);
  await page.keyboard.press("t");
  expect(await paper()).toBe(dark);
  await page.emulateMedia({ colorScheme: "light" });
  await page.reload();
  expect(await paper()).toBe(light);
});

test("? lists the keys, and each of them is taken", async ({ page }) => {
  const watched = await opened(page, mug);
  await page.keyboard.press("?");
  await expect(page.locator("#help-list")).toBeVisible();
  await page.screenshot({ path: `${shots}mug-keys.png` });
  expect(await page.locator("#keys dt").count()).toBeGreaterThan(15);
  await page.keyboard.press("?");
  await expect(page.locator("#help-list")).toBeHidden();
  for (const key of ["[", "]", "{", "}", "n", "p", "o", "s", " ", " ", "ArrowUp"]) await page.keyboard.press(key);
  await page.keyboard.press("{");
  expect(await count(page)).toBe("1 hull");
  expect(watched.errors).toEqual([]);
});

test("closed openings are tinted where there are any", async ({ page }) => {
  await opened(page, mug);
  await expect(page.locator("#openings")).toBeHidden();
  const open = view(mesh("open.obj"), "open.html");
  await opened(page, open);
  await page.keyboard.press("h");
  await page.keyboard.press("ArrowDown");
  for (let i = 0; i < 8; i++) await page.keyboard.press("ArrowDown");
  await changes(page, () => page.locator("#openings").click());
  await changes(page, () => page.locator("#openings").click());
  await page.screenshot({ path: `${shots}open.png` });
});

test("what a probe does not reach is drawn over the mesh, by button and by key, and only with a probe", async ({ page }) => {
  await opened(page, mug);
  await expect(page.locator("#filled")).toBeHidden();
  await page.keyboard.press("f");
  expect(await page.locator("#filled").getAttribute("aria-pressed")).toBe("false");
  await opened(page, view(asset("gear.glb"), "gear.html", "--probe-radius", "6%"));
  const shown = () => page.locator("#filled").getAttribute("aria-pressed");
  await changes(page, () => page.locator("#filled").click());
  expect(await shown()).toBe("true");
  expect(await page.locator("#mesh").getAttribute("aria-pressed")).toBe("true");
  const middle = await page.locator(".viewport").evaluate((viewport) => {
    const { left, top, width, height } = viewport.getBoundingClientRect();
    return { x: left + width / 2, y: top + height / 2 };
  });
  // A ball comes as far as the mesh lets it, and is gone where it would pass.
  const bare = await picture(page);
  await changes(page, () => page.mouse.move(middle.x, middle.y));
  await page.screenshot({ path: `${shots}gear-filled.png` });
  await changes(page, () => page.mouse.move(middle.x + 30, middle.y));
  await page.mouse.move(middle.x, 2);
  expect((await picture(page)).text).toBe(bare.text);
  await changes(page, () => page.keyboard.press("f"));
  expect(await shown()).toBe("false");
});

test("two methods stand side by side, seen by one camera, each with its slider", async ({ page }) => {
  await opened(page, compared);
  await expect(page.locator(".panel")).toHaveCount(2);
  await page.screenshot({ path: `${shots}table-compared.png` });
  const halves = () =>
    page.evaluate(async () => {
      await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
      const canvas = document.querySelector("canvas")!;
      const half = (left: number) => {
        const copy = document.createElement("canvas");
        [copy.width, copy.height] = [80, 60];
        const context = copy.getContext("2d")!;
        context.drawImage(canvas, left, 0, canvas.width / 2, canvas.height, 0, 0, 80, 60);
        return context.getImageData(0, 0, 80, 60).data.join(",");
      };
      return [half(0), half(canvas.width / 2)];
    });
  const before = await halves();
  await page.keyboard.press("ArrowRight");
  const turned = await halves();
  expect(turned[0]).not.toBe(before[0]);
  expect(turned[1]).not.toBe(before[1]);
  const left = await count(page, 0);
  await page.locator(".hulls-slider").nth(1).fill("1");
  expect(await count(page, 0)).toBe(left);
  expect(await count(page, 1)).toBe("1 hull");
  const moved = await halves();
  expect(moved[0]).toBe(turned[0]);
  expect(moved[1]).not.toBe(turned[1]);
});

test("a simplified mesh is switched between before and after, with its triangles and distances", async ({ page }) => {
  const watched = await opened(page, view(asset("props.glb"), "simplified.html", "--simplified", "--max-error", "1%"));
  const pressed = (id: string) => page.locator(`#${id}`).getAttribute("aria-pressed");
  const triangles = async () => Number((await count(page)).replace(/[^0-9]/g, ""));
  expect([await pressed("mesh"), await pressed("hulls"), await pressed("wires")]).toEqual(["false", "true", "true"]);
  const after = await triangles();
  await page.screenshot({ path: `${shots}simplified-after.png` });
  await changes(page, () => page.locator("#mesh").click());
  expect(await triangles()).toBeGreaterThan(after);
  expect([await pressed("mesh"), await pressed("hulls")]).toEqual(["true", "false"]);
  await page.screenshot({ path: `${shots}simplified-before.png` });
  await changes(page, () => page.keyboard.press("b"));
  expect(await triangles()).toBe(after);
  await changes(page, () => page.keyboard.press("c"));
  await expect(page.locator("#legend")).toBeVisible();
  await page.screenshot({ path: `${shots}simplified-distances.png` });
  await changes(page, () => page.keyboard.press("w"));
  for (const figure of [".error", ".protrusion", ".uncovered"]) {
    expect(await page.locator(`${figure} dd`).innerText()).toMatch(/^≤ .* %$/);
  }
  // What only hulls have does nothing here, and is not listed.
  const shown = await picture(page);
  for (const key of ["n", "e", "o", "f", "]"]) await page.keyboard.press(key);
  expect((await picture(page)).text).toBe(shown.text);
  await expect(page.locator(".pick")).toBeHidden();
  await expect(page.locator("#apart")).toBeHidden();
  await page.keyboard.press("?");
  await expect(page.locator("#keys")).toContainText("before, after");
  await expect(page.locator("#keys")).not.toContainText("hull");
  expect(watched.errors).toEqual([]);
});

test("on a telephone everything fits its width", async ({ browser }) => {
  const context = await browser.newContext({
    viewport: { width: 390, height: 844 },
    deviceScaleFactor: 2,
    hasTouch: true,
    isMobile: true,
  });
  const page = await context.newPage();
  for (const [address, name] of [
    [mug, "mug"],
    [compared, "table"],
  ]) {
    await opened(page, address);
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    expect(width).toBeLessThanOrEqual(390);
    expect((await picture(page)).filled).toBeGreaterThan(0.03);
    for (const card of await page.locator(".card").all()) {
      const box = (await card.boundingBox())!;
      expect(box.y + box.height).toBeLessThanOrEqual(844);
    }
    await page.screenshot({ path: `${shots}phone-${name}.png` });
  }
  await context.close();
});

test("without WebGL the page says what is missing", async ({ page }) => {
  await page.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
  await page.goto(mug);
  await expect(page.locator("#message")).toHaveText(/can't draw in 3D.*WebGL 2/);
});

test("no name of a file, an object, a material or a tool becomes markup or script", async ({ page }) => {
  const named = join(folder, "<img src=x onerror='window.injected=true'>.obj");
  copyFileSync(mesh("hostile.obj"), named);
  const hostile = view(named, "hostile.html", "--hulls", named);
  let asked = false;
  page.on("dialog", (dialog) => {
    asked = true;
    void dialog.dismiss();
  });
  await opened(page, hostile);
  await page.keyboard.press("n");
  await expect(page.locator(".pick").first()).toContainText("<script>");
  expect(await page.locator("img, iframe, script:not([id]):not([type])").count()).toBe(1);
  expect(asked).toBe(false);
  expect(await page.evaluate(() => (window as any).injected)).toBeUndefined();
});

test("a script that gets into the page all the same does not run", async ({ page }) => {
  await open(page, mug);
  await page.evaluate(() => {
    const script = document.createElement("script");
    script.textContent = "window.injected = true";
    document.body.append(script);
  });
  expect(await page.evaluate(() => (window as any).injected)).toBeUndefined();
});
