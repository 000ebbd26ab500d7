// What a page of 500 hulls takes: calls and triangles are counted. Times are printed: they depend on the machine.

import { expect, test, type Page } from "@playwright/test";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { asset, folder, open, shots, view } from "./page";

/** 500 balls on a lattice, each of which is a hull. */
function balls(): string {
  const [rings, around] = [5, 6];
  let text = "";
  let first = 1;
  for (let ball = 0; ball < 500; ball++) {
    const centre = [3 * (ball % 10), 3 * (Math.floor(ball / 10) % 10), 3 * Math.floor(ball / 100)];
    const point = (polar: number, angle: number) => {
      const way = [Math.sin(polar) * Math.cos(angle), Math.cos(polar), Math.sin(polar) * Math.sin(angle)];
      text += `v ${way.map((x, axis) => (x + centre[axis]).toFixed(4)).join(" ")}\n`;
    };
    point(0, 0);
    for (let i = 1; i < rings; i++) {
      for (let j = 0; j < around; j++) point((Math.PI * i) / rings, (2 * Math.PI * j) / around);
    }
    point(Math.PI, 0);
    const at = (i: number, j: number) => first + 1 + (i - 1) * around + (j % around);
    const last = first + 1 + (rings - 1) * around;
    for (let j = 0; j < around; j++) {
      text += `f ${first} ${at(1, j + 1)} ${at(1, j)}\n`;
      for (let i = 1; i < rings - 1; i++) {
        text += `f ${at(i, j)} ${at(i, j + 1)} ${at(i + 1, j + 1)} ${at(i + 1, j)}\n`;
      }
      text += `f ${last} ${at(rings - 1, j)} ${at(rings - 1, j + 1)}\n`;
    }
    first = last + 1;
  }
  return text;
}

test("while frames are slow a quarter of the pixels is drawn, and all of them at rest", async ({ page }) => {
  await open(page, view(asset("mug.glb"), "slow.html"));
  const width = () => page.locator("canvas").evaluate((canvas: HTMLCanvasElement) => canvas.width);
  const all = await width();
  // Each frame takes the browser's thread for longer than a thirtieth of a second.
  const turned = await page.evaluate(async () => {
    const { stage } = (window as any).hullwright;
    for (let frame = 0; frame < 12; frame++) {
      await new Promise(requestAnimationFrame);
      stage.turn(0.05, 0);
      const end = performance.now() + 50;
      while (performance.now() < end);
    }
    return stage.canvas.width;
  });
  expect(turned).toBe(Math.floor(all / 2));
  await expect.poll(width).toBe(all);
});

/** Waits until nothing moves and all is drawn. */
async function rested(page: Page) {
  const frames = () => page.evaluate(() => (window as any).hullwright.stage.frames);
  let before = -1;
  await expect
    .poll(async () => {
      const last = before;
      before = await frames();
      return before === last;
    }, { intervals: [400] })
    .toBe(true);
}

test("nothing is drawn while nothing moves, and nothing is made that was never seen", async ({ page }) => {
  await open(page, view(asset("mug.glb"), "rest.html"));
  await rested(page);
  const found = await page.evaluate(async () => {
    const { stage, panels } = (window as any).hullwright;
    const before = stage.frames;
    for (let frame = 0; frame < 30; frame++) await new Promise(requestAnimationFrame);
    const idle = stage.frames - before;
    const isMade = () => panels[0].meshFaces.geometry.hasAttribute("position");
    const early = isMade();
    document.getElementById("mesh")!.click();
    stage.render();
    return { idle, early, late: isMade() };
  });
  expect(found).toEqual({ idle: 0, early: false, late: true });
});

test("a page of 500 hulls turns, and takes one call to draw them and one for their edges", async ({ page }) => {
  test.setTimeout(600_000);
  const mesh = join(folder, "balls.obj");
  writeFileSync(mesh, balls());
  const begin = Date.now();
  const address = view(mesh, "balls.html", "--max-error", "0.5%", "--no-merge");
  console.log(`written in ${((Date.now() - begin) / 1000).toFixed(1)} s`);
  const watched = await open(page, address);
  expect(watched).toEqual({ errors: [], requests: [] });
  await rested(page);
  const found = await page.evaluate(async () => {
    const { stage, panels } = (window as any).hullwright;
    const drawing = () => {
      stage.render();
      return [stage.calls, stage.drawnTriangles];
    };
    const atRest = drawing();
    const gl = stage.canvas.getContext("webgl2");
    const pixel = new Uint8Array(4);
    // Drawing is over when a pixel can be read.
    const drawn = (act: () => void) => {
      const start = performance.now();
      act();
      stage.render();
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      return performance.now() - start;
    };
    const median = (times: number[]) => times.sort((a, b) => a - b)[times.length >> 1];
    const all = (count: number, act: (step: number) => void) =>
      median(Array.from({ length: count }, (_, step) => drawn(() => act(step))));
    const hulls = panels[0].state.hulls;
    // As while it moves on a slow machine.
    panels[0].isHurried = true;
    const moving = drawing();
    const turning = all(60, () => stage.turn(0.05, 0));
    const anew = all(20, () => panels[0].update());
    return { hulls, atRest, moving, turning, anew };
  });
  expect(found.hulls).toBe(500);
  const triangles = 500 * 2 * 4 * 6;
  expect(found.atRest).toEqual([2, triangles]);
  expect(found.moving).toEqual([1, triangles]);
  console.log(
    `${found.hulls} hulls: a frame takes ${found.turning.toFixed(1)} ms, one with all hulls anew, as by the slider, ${found.anew.toFixed(1)} ms`,
  );
  await page.screenshot({ path: `${shots}balls.png` });
});
