// A Bevy game in Chromium with 300 baked props and 50 that are decomposed, in workers, in slices, and with the files for
// workers missing; and the same game with boxes instead. Prints the gaps between its frames, and fails unless each prop
// gets its hulls. `npm run game -- ROUNDS`, of which 5 are the default. Needs the package built: `npm run build`.

import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, rmSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { launch, openPage, serve } from "./tests/browser.mjs";

const ROOT = fileURLToPath(new URL("../../..", import.meta.url));
const GAME = fileURLToPath(new URL("build/game", import.meta.url));
const BAKED = 300;
const DECOMPOSED = 50;
/** Gaps scatter with what else the machine does: all modes take turns. */
const ROUNDS = Number(process.argv[2] ?? 5);
const MODES = {
  "no decomposition": { mode: "boxes", folder: "hullwright" },
  "in workers": { mode: "worker", folder: "hullwright" },
  "in slices": { mode: "slices", folder: "hullwright" },
  "in workers, without their files": { mode: "worker", folder: "nowhere" },
  "in workers, those unfinished in frame 60 despawned": { mode: "worker", folder: "hullwright", replaced: 60 },
};

const run = (program, ...args) => execFileSync(program, args, { cwd: ROOT, stdio: ["ignore", "pipe", "inherit"], maxBuffer: 1 << 26 }).toString();

function build() {
  const flags = ["--ignore-rust-version", "--package", "hullwright_web_game"];
  const made = run("crates/web/toolchain", "build", "--quiet", "--lib", "--profile", "web-game", ...flags, "--message-format", "json-render-diagnostics");
  const files = made.split("\n").filter((line) => line.startsWith("{")).flatMap((line) => JSON.parse(line).filenames ?? []);
  run("cargo", "run", "--quiet", "--package", "hullwright_bindgen", "--", files.findLast((file) => file.endsWith("hullwright_web_game.wasm")), GAME);
  for (const folder of ["hullwright", "assets"]) mkdirSync(`${GAME}/${folder}`);
  for (const file of ["worker-core.js", "hullwright-core.wasm"]) copyFileSync(fileURLToPath(new URL(`dist/${file}`, import.meta.url)), `${GAME}/hullwright/${file}`);
  run("cargo", "run", "--quiet", "--release", "--package", "hullwright_web_game", "--bin", "props", "--", "assets", `${GAME}/assets/props.hullscene`);
}

/** Plays until all have their hulls. Runs in the page. */
async function play({ mode, folder, replaced }) {
  const PAUSE = 4;
  const glue = await import("/hullwright_web_game.js");
  window.ready ??= glue.default({ module_or_path: "/hullwright_web_game_bg.wasm" });
  await window.ready;
  const game = new glue.Game(mode, folder);
  const gaps = [];
  let counters;
  let plugin = 0;
  const begin = performance.now();
  let bakedAfter = 0;
  for (let last = begin; ; ) {
    if (gaps.length === replaced) game.replace_unfinished();
    game.update();
    counters = JSON.parse(game.counters());
    if (!bakedAfter && counters.baked === 300) bakedAfter = gaps.length + 1;
    const isOver = mode === "boxes" ? performance.now() > begin + 5000 : counters.left === 0;
    if (isOver) break;
    await new Promise((resolve) => setTimeout(resolve, PAUSE));
    const now = performance.now();
    gaps.push(now - last);
    plugin = Math.max(plugin, counters.plugin);
    last = now;
  }
  game.free();
  return { gaps, plugin, counters, bakedAfter, seconds: (performance.now() - begin) / 1000 };
}

rmSync(GAME, { recursive: true, force: true });
mkdirSync(GAME, { recursive: true });
build();
const server = await serve(GAME);
const browser = await launch();
const empty = () => Object.fromEntries(Object.keys(MODES).map((name) => [name, []]));
const [cold, found] = [empty(), empty()];
try {
  for (let round = 0; round < ROUNDS; round++) {
    for (const [name, mode] of Object.entries(MODES)) {
      const page = await openPage(browser, server.address);
      // A browser compiles functions when they are first called. That is the same for any game, and is seen apart.
      const first = await page.evaluate(play, mode);
      cold[name].push(Math.max(...first.gaps));
      found[name].push(await page.evaluate(play, mode));
      await page.close();
    }
  }
} finally {
  await browser.close();
  server.close();
}
const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];
const listed = (values, digits = 1) => `${median(values).toFixed(digits)} (${values.map((value) => value.toFixed(digits)).join(", ")})`;
console.log("Medians of rounds, and each. Times in milliseconds.");
console.log("mode | seconds until all are ready | frames until 300 are baked | median gap | longest gap | longest gap at first | most of the plugin in a frame");
for (const [name, rounds] of Object.entries(found)) {
  const row = [
    listed(rounds.map(({ seconds }) => seconds)),
    listed(rounds.map(({ bakedAfter }) => bakedAfter), 0),
    listed(rounds.map(({ gaps }) => median(gaps))),
    listed(rounds.map(({ gaps }) => Math.max(...gaps))),
    listed(cold[name]),
    listed(rounds.map(({ plugin }) => plugin)),
  ];
  console.log([name, ...row].join(" | "));
  const { mode, replaced } = MODES[name];
  const [baked, decomposed] = mode === "boxes" ? [0, 0] : [BAKED, DECOMPOSED];
  for (const { counters } of rounds) {
    // Of those that are replaced some are done before, and the new one after them.
    const isDone = replaced ? counters.decomposed > 1 && counters.decomposed < DECOMPOSED : counters.decomposed === decomposed;
    if (counters.baked !== baked || !isDone || counters.failed !== 0) {
      console.error(name, counters);
      process.exitCode = 1;
    }
  }
}
