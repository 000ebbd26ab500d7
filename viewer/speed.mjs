// What a frame of a page costs while it turns: `npm run speed -- PAGE…`. Beside it stands a page with an empty canvas of
// the same size that is cleared in each frame: what that one costs, the browser takes. All are tried in turns, since
// other programs slow them down too.

import { basename, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "@playwright/test";
import { launchOptions } from "./chromium.mjs";

const paths = process.argv.slice(2);
if (paths.length === 0) {
  console.error("npm run speed -- PAGE…");
  process.exit(2);
}

const ROUNDS = 4;
/** In milliseconds: before the measurement, and of it. */
const WARM_UP = 1000;
const TIME = 3000;
const viewport = { width: 1280, height: 800 };

/** Ways of Chromium to draw without a graphics card. */
const ways = {
  "WebGL and composition by SwiftShader": launchOptions.args,
  "WebGL by SwiftShader, composition without": ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"],
};

const empty = `<style>body{margin:0}canvas{width:100vw;height:100vh}</style><canvas width=1280 height=800></canvas><script>
  const attributes = { antialias: false, preserveDrawingBuffer: true };
  const gl = document.querySelector("canvas").getContext("webgl2", attributes);
  let frame = 0;
  window.clear = () => {
    gl.clearColor((frame++ % 2) / 9, 0.5, 0.5, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
  };
</script>`;

/** Turns for some time. Intervals between frames, and time in the page's own drawing, in milliseconds. */
async function turning(milliseconds) {
  const own = [];
  const intervals = [];
  const { stage } = window.hullwright ?? {};
  const render = stage?.render;
  if (stage) {
    stage.render = () => {
      const begin = performance.now();
      render.call(stage);
      own.push(performance.now() - begin);
    };
  }
  const end = performance.now() + milliseconds;
  let last = await new Promise(requestAnimationFrame);
  while (last < end) {
    if (stage) stage.turn(0.02, 0);
    else window.clear();
    const now = await new Promise(requestAnimationFrame);
    intervals.push(now - last);
    last = now;
  }
  if (stage) stage.render = render;
  return { own, intervals, calls: stage?.calls, triangles: stage?.drawnTriangles, width: stage?.canvas.width };
}

const quantile = (numbers, share) => [...numbers].sort((a, b) => a - b)[Math.floor(share * (numbers.length - 1))];
const column = (number) => (number ?? 0).toFixed(1).padStart(9);

/** Processor time of Chromium's processes so far, in milliseconds. */
async function processorTime(system) {
  const { processInfo } = await system.send("SystemInfo.getProcessInfo");
  return new Map(processInfo.map(({ id, type, cpuTime }) => [id, { type, time: 1000 * cpuTime }]));
}

const spent = (before, after, type) =>
  [...after]
    .filter(([, process]) => process.type === type)
    .reduce((sum, [id, { time }]) => sum + time - (before.get(id)?.time ?? 0), 0);

async function once(browser, system, path) {
  const page = await browser.newPage({ viewport });
  if (path) {
    await page.goto(pathToFileURL(resolve(path)).href);
    await page.waitForSelector("html[data-ready]");
  } else {
    await page.setContent(empty);
  }
  await page.evaluate(turning, WARM_UP);
  const before = await processorTime(system);
  const found = await page.evaluate(turning, TIME);
  const after = await processorTime(system);
  await page.close();
  const per = (type) => spent(before, after, type) / found.intervals.length;
  return { ...found, page: per("renderer"), drawing: per("GPU") };
}

for (const [name, args] of Object.entries(ways)) {
  const browser = await chromium.launch({ ...launchOptions, args });
  const system = await browser.newBrowserCDPSession();
  const pages = ["", ...paths].map((path) => ({ path, rounds: [] }));
  for (let round = 0; round < ROUNDS; round++) {
    for (const { path, rounds } of pages) rounds.push(await once(browser, system, path));
  }
  await browser.close();
  console.log(`${name}, in milliseconds per frame:`);
  console.log("   median  90 percent      own  page process  drawing process");
  for (const { path, rounds } of pages) {
    const intervals = rounds.flatMap((round) => round.intervals);
    const middle = (of) => quantile(rounds.map(of), 0.5);
    const { calls, triangles, width } = rounds[0];
    console.log(
      [quantile(intervals, 0.5), quantile(intervals, 0.9), quantile(rounds.flatMap(({ own }) => own), 0.5)]
        .concat(middle((round) => round.page), middle((round) => round.drawing))
        .map(column)
        .join("  "),
      path ? ` ${basename(path)}: ${calls} calls, ${triangles} triangles, ${width} pixels wide` : "  an empty page",
    );
  }
}
