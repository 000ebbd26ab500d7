// A Bevy game in Chromium with 300 baked props, 50 that are decomposed and 8 pieces of ground that are simplified: in workers,
// in slices, with files for workers that are missing, of another build, faulty or never loaded, with a cache, also one that is
// too small or fails; and the same game with boxes instead. Prints the gaps between its frames. Fails unless each prop gets its
// hulls and the ground its few triangles, from workers where these can work, hulls from the cache at a second visit, and on any
// error in the page. `npm run game -- ROUNDS`, of which 5 are the default. Needs the package built: `npm run build`.

import { mkdirSync, rmSync, writeFileSync } from "node:fs";
import { buildProgram, copyWorker, countAnswers, folderOf, run } from "./program.mjs";
import { launch, openPage, serve } from "./tests/browser.mjs";

const GAME = folderOf("game");
const BAKED = 300;
const DECOMPOSED = 50;
const GROUNDS = 8;
/** Of the ground as it is drawn. */
const GROUND_TRIANGLES = 160_000;
/** As in the game, which may keep a sixteenth more. */
const SMALL_CACHE = 64 << 10;
/** Gaps scatter with what else the machine does: all modes take turns. */
const ROUNDS = Number(process.argv[2] ?? 5);
const MODES = {
  "no decomposition": { mode: "boxes", folder: "hullwright" },
  "in workers": { mode: "worker", folder: "hullwright" },
  "in slices": { mode: "slices", folder: "hullwright" },
  "in workers, those unfinished once 300 are baked despawned": { mode: "worker", folder: "hullwright", replaced: true },
  // The page is loaded anew between its two plays. In the second the browser hashes nothing: its hashes were the plugin's own.
  "in workers, kept in IndexedDB": { mode: "cached", folder: "hullwright", once: true },
  "in workers, some kept in IndexedDB": { mode: "cached-some", folder: "hullwright", once: true },
  "in workers, IndexedDB full": { mode: "cached", folder: "hullwright", once: true, indexedDb: "full" },
  "in workers, IndexedDB denied": { mode: "cached", folder: "hullwright", isBroken: true, indexedDb: "denied" },
  "in workers, IndexedDB silent": { mode: "cached", folder: "hullwright", isBroken: true, indexedDb: "silent" },
};
/** Folders whose files do not do. How long the work takes then is not of interest: one game is played. */
const WITHOUT = {
  nowhere: "no file",
  "no-script": "no script",
  "other-build": "a module without functions",
  faulty: "a script that fails after some answers",
  stalled: "files that never come",
};
for (const [folder, what] of Object.entries(WITHOUT)) MODES[`in workers, ${what}`] = { mode: "worker", folder, isBroken: true };

function build() {
  buildProgram(GAME, "hullwright_web_game", "--package", "hullwright_web_game", "--lib");
  for (const folder of ["hullwright", "no-script", "other-build", "faulty"]) copyWorker(`${GAME}/${folder}`);
  rmSync(`${GAME}/no-script/worker-core.js`);
  writeFileSync(`${GAME}/other-build/hullwright-core.wasm`, Uint8Array.of(0, 0x61, 0x73, 0x6d, 1, 0, 0, 0));
  writeFileSync(`${GAME}/faulty/worker-core.js`, FAULTY);
  mkdirSync(`${GAME}/assets`);
  run("cargo", "run", "--quiet", "--release", "--package", "hullwright_web_game", "--bin", "props", "--", "assets", `${GAME}/assets/props.hullscene`);
}

/** Each worker fails at its third request. */
const FAULTY = `importScripts("/hullwright/worker-core.js");
const answer = onmessage;
let requests = 0;
onmessage = (event) => {
  if (++requests === 3) throw new Error("on purpose");
  answer(event);
};`;

/** Counts what the browser hashes. Runs in the page. */
function countDigests() {
  const { digest } = SubtleCrypto.prototype;
  window.digests = 0;
  SubtleCrypto.prototype.digest = function (...args) {
    window.digests++;
    return digest.apply(this, args);
  };
}

/** The bytes in the cache. Runs in the page. */
async function bytesKept() {
  const ended = (request) => new Promise((resolve, reject) => Object.assign(request, { onsuccess: () => resolve(request.result), onerror: reject }));
  const database = await ended(indexedDB.open("hullwright", 1));
  const all = await ended(database.transaction("uses").objectStore("uses").getAll());
  return all.reduce((sum, [, bytes]) => sum + bytes, 0);
}

/** Runs in the page. */
function breakIndexedDb(how) {
  if (how === "full") {
    const { put } = IDBObjectStore.prototype;
    IDBObjectStore.prototype.put = function (...args) {
      const request = put.apply(this, args);
      queueMicrotask(() => {
        try {
          this.transaction.abort();
        } catch {
          // It has been.
        }
      });
      return request;
    };
    return;
  }
  const get = () => {
    if (how === "denied") throw new DOMException("on purpose", "SecurityError");
    return { open: () => ({}) };
  };
  Object.defineProperty(window, "indexedDB", { get });
}

/** Plays until all have their hulls, or two minutes. Runs in the page. */
async function play({ mode, folder, replaced, isUnhashed }) {
  if (isUnhashed) Object.defineProperty(Crypto.prototype, "subtle", { get: () => undefined });
  const [PAUSE, MOST] = [4, 120_000];
  const glue = await import("/hullwright_web_game.js");
  window.ready ??= glue.default({ module_or_path: "/hullwright_web_game_bg.wasm" });
  await window.ready;
  const game = new glue.Game(mode, folder);
  Object.assign(window, { answers: 0, surfaces: 0 });
  const gaps = [];
  let counters;
  let plugin = 0;
  const begin = performance.now();
  let bakedAfter = 0;
  for (let last = begin; ; ) {
    if (replaced && bakedAfter && bakedAfter === gaps.length) game.replace_unfinished();
    game.update();
    counters = JSON.parse(game.counters());
    if (!bakedAfter && counters.baked === 300) bakedAfter = gaps.length + 1;
    const isOver = mode === "boxes" ? performance.now() > begin + 5000 : counters.left === 0;
    if (isOver || performance.now() > begin + MOST) break;
    await new Promise((resolve) => setTimeout(resolve, PAUSE));
    const now = performance.now();
    gaps.push(now - last);
    plugin = Math.max(plugin, counters.plugin);
    last = now;
  }
  game.free();
  return { gaps, plugin, counters: { ...counters, answers: window.answers, surfaces: window.surfaces, digests: window.digests }, bakedAfter, seconds: (performance.now() - begin) / 1000 };
}

build();
const server = await serve(GAME);
const browser = await launch();

/** Plays twice on a page, since a browser compiles functions when they are first called: that is the same for any game, and
 * is seen apart. */
async function playTwice(name, mode) {
  const page = await openPage(browser, server.address);
  page.on("pageerror", () => (process.exitCode = 1));
  let started = 0;
  page.on("worker", () => started++);
  // A page with routes has no cache, and each of its requests takes longer.
  if (mode.folder === "stalled") await page.route("**/stalled/*", () => undefined);
  await page.addInitScript(countAnswers);
  await page.addInitScript(countDigests);
  if (mode.indexedDb) await page.addInitScript(breakIndexedDb, mode.indexedDb);
  await page.reload();
  const plays = [await page.evaluate(play, mode)];
  if (!mode.isBroken) {
    if (isCached(mode)) await page.reload();
    plays.push(await page.evaluate(play, { ...mode, isUnhashed: isCached(mode) }));
  }
  const kept = isCached(mode) && !mode.indexedDb ? await page.evaluate(bytesKept) : 0;
  await page.close();
  if (mode.mode === "cached-some" && (kept === 0 || kept > 1.1 * SMALL_CACHE)) {
    console.error(name, `${kept} bytes are kept`);
    process.exitCode = 1;
  }
  for (const [number, { counters }] of plays.entries()) {
    if (isRight(mode, counters, started, number) && isGroundRight(mode, counters)) continue;
    console.error(name, counters, `workers: ${started}`);
    process.exitCode = 1;
  }
  return plays;
}

/** The ground has the same few triangles in all modes, from workers where these can work. */
let groundTriangles;
function isGroundRight({ mode, folder }, { simplified, triangles, surfaces }) {
  if (mode === "boxes") return simplified + triangles === 0;
  groundTriangles ??= triangles;
  if (simplified !== GROUNDS || triangles !== groundTriangles || triangles > GROUND_TRIANGLES / 4) return false;
  if (mode === "slices") return surfaces === 0;
  if (folder === "hullwright") return surfaces === GROUNDS;
  return folder === "faulty" ? surfaces < GROUNDS : surfaces === 0;
}

const isCached = ({ mode }) => mode.startsWith("cached");

function isRight({ mode, folder, replaced, indexedDb }, { baked, decomposed, cached, left, failed, answers, digests }, started, number) {
  if (left + failed > 0) return false;
  const isSecondVisit = isCached({ mode }) && number === 1;
  // The boxes have no meshes, and at a second visit the browser does not hash.
  const isHashed = mode !== "boxes" && !isSecondVisit;
  if (digests > 0 !== isHashed) return false;
  if (isSecondVisit && !indexedDb) {
    if (baked !== BAKED || cached + decomposed !== DECOMPOSED || answers !== decomposed) return false;
    // What is needed next may have gone for what was made last.
    return mode === "cached" ? decomposed === 0 : decomposed > 0;
  }
  if (cached > 0) return false;
  if (mode === "boxes") return baked + decomposed + started === 0;
  // Of those that are replaced some may be done before, and the new one comes after them.
  const isDone = replaced ? decomposed > 0 && decomposed < DECOMPOSED : decomposed === DECOMPOSED;
  if (baked !== BAKED || !isDone) return false;
  if (mode === "slices") return started === 0;
  if (folder === "hullwright") return started > 0 && answers >= decomposed;
  // Each worker answers two of three requests, and another one goes on.
  return folder === "faulty" ? answers > decomposed / 2 && answers < decomposed : answers === 0;
}

const found = Object.fromEntries(Object.keys(MODES).map((name) => [name, []]));
try {
  for (let round = 0; round < ROUNDS; round++) {
    for (const [name, mode] of Object.entries(MODES)) {
      if (round === 0 || !(mode.once || mode.isBroken)) found[name].push(await playTwice(name, mode));
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
  const inPlay = (play, value) => rounds.map((plays) => value(plays[play] ?? plays[0]));
  const longest = ({ gaps }) => Math.max(...gaps);
  const row = [
    listed(inPlay(1, ({ seconds }) => seconds)),
    listed(inPlay(1, ({ bakedAfter }) => bakedAfter), 0),
    listed(inPlay(1, ({ gaps }) => median(gaps))),
    listed(inPlay(1, longest)),
    listed(inPlay(0, longest)),
    listed(inPlay(1, ({ plugin }) => plugin)),
  ];
  console.log([name, ...row].join(" | "));
}
