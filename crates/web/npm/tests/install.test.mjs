// The package as users get it: its tarball, installed into fresh projects of Vite, Parcel, vitest, TypeScript and Node.
// Takes them from npm's registry, whichever that is.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { launch, openPage, PACKAGE, serve } from "./browser.mjs";
import { root } from "./common.mjs";

const folder = mkdtempSync(join(tmpdir(), "hullwright-"));
after(() => rmSync(folder, { recursive: true, force: true }));
const run = (program, args, cwd = folder) => execFileSync(program, args, { cwd, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });

const [{ filename, files }] = JSON.parse(run("npm", ["pack", "--json", "--pack-destination", folder], PACKAGE));
const { devDependencies } = JSON.parse(readFileSync(`${PACKAGE}/package.json`, "utf8"));

/** Chosen here: they are no dependencies of the package, and take long to install. */
const VITE = "8.3.8";
const VITEST = { vitest: "4.1.12", jsdom: "27.4.0" };
const PARCEL = "2.16.4";
/** The oldest, and the first whose arrays say which memory they have; the newest is a dependency. */
const TYPESCRIPT = ["5.0.4", "5.7.3"];

function project(name, dependencies, sources) {
  const place = join(folder, name);
  mkdirSync(place);
  const own = { hullwright: `file:../${filename}`, ...dependencies };
  writeFileSync(join(place, "package.json"), JSON.stringify({ name, private: true, type: "module", dependencies: own }));
  for (const [file, text] of Object.entries(sources)) writeFileSync(join(place, file), text);
  run("npm", ["install", "--no-audit", "--no-fund", "--loglevel=error"], place);
  return place;
}

test("the tarball holds what its exports name, the licences and a description, and no source", () => {
  const paths = files.map(({ path }) => path);
  const { exports } = JSON.parse(readFileSync(`${PACKAGE}/package.json`, "utf8"));
  const named = Object.values(exports).flatMap((entry) => (typeof entry === "string" ? entry : Object.values(entry)));
  for (const path of [...named.map((path) => path.slice(2)), "README.md", "LICENSE-MIT", "LICENSE-APACHE"]) {
    assert.ok(paths.includes(path), `${path} is missing`);
  }
  assert.ok(!paths.some((path) => /^(src|tests|build)\//.test(path)), String(paths));
});

test("`main` and `package.json` are found by what knows no exports, and one function brings no module along", () => {
  const { main, types } = JSON.parse(readFileSync(`${PACKAGE}/package.json`, "utf8"));
  assert.deepEqual([main, types], ["./dist/index.js", "./dist/index.d.ts"]);
  const place = project("one", {}, {
    "main.mjs": `import { hullsAt } from "hullwright"; console.log(hullsAt);`,
    "name.mjs": `import { createRequire } from "node:module"; console.log(createRequire(import.meta.url)("hullwright/package.json").name);`,
  });
  assert.equal(run("node", ["name.mjs"], place).trim(), "hullwright");
  run(join(PACKAGE, "node_modules/.bin/esbuild"), ["main.mjs", "--bundle", "--format=esm", "--minify", "--outfile=out.js", "--log-level=error"], place);
  const { length } = readFileSync(join(place, "out.js"));
  assert.ok(length < 10_000, `${length} bytes`);
});

test("a program of Node decomposes, and ends by itself", () => {
  const place = project("node", {}, {
    "main.mjs": `
      import { readFile } from "node:fs/promises";
      import { decompose, readMesh } from "hullwright";
      const mesh = await readMesh(await readFile(process.argv[2]), "glb");
      const { hulls } = await decompose(mesh);
      console.log(hulls.length);`,
  });
  assert.ok(Number(run("node", ["main.mjs", root("assets/chair.glb")], place)) > 1);
});

test("a program of TypeScript is checked against the package's types, also without a bundler's rules", () => {
  const place = project("types", { typescript: devDependencies.typescript, "@types/three": devDependencies["@types/three"], three: devDependencies.three, "@dimforge/rapier3d-compat": devDependencies["@dimforge/rapier3d-compat"] }, {
    "main.ts": `
      import RAPIER from "@dimforge/rapier3d-compat";
      import { decompose, HullwrightError, type Decomposition } from "hullwright";
      import { toRapier } from "hullwright/rapier";
      import { toGeometries, fromGeometry } from "hullwright/three";
      import { createPool } from "hullwright/files";
      import { load } from "hullwright/direct";
      import { BoxGeometry } from "three";
      const maybe: AbortSignal | undefined = undefined;
      const result: Decomposition = await decompose(fromGeometry(new BoxGeometry()), { maxError: "2%", preset: "fast", signal: maybe });
      new Blob([result.hullsFile, result.hulls[0].points]);
      const all: RAPIER.ColliderDesc[] = toRapier(RAPIER, result);
      // @ts-expect-error: no such preset
      decompose({ positions: [] }, { preset: "best" }).catch((error: HullwrightError) => error.code);
      export { all, createPool, load, toGeometries };`,
    "tsconfig.json": JSON.stringify({ compilerOptions: { module: "nodenext", target: "es2022", strict: true, exactOptionalPropertyTypes: true, noEmit: true, skipLibCheck: false, types: [], lib: ["es2023", "dom"] } }),
  });
  // Other packages' own errors are theirs.
  let found = "";
  try {
    execFileSync("node", ["node_modules/typescript/bin/tsc"], { cwd: place, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
  } catch ({ stdout }) {
    found = stdout;
  }
  assert.deepEqual(found.split("\n").filter((line) => /^(main|node_modules\/hullwright)/.test(line)), []);
});

test("TypeScript from 5.0 on checks it with exact optional properties, and takes its bytes for a Blob", () => {
  const place = project("typescript", {}, {
    "main.ts": `
      import { close, decompose, prepare, type Decomposition } from "hullwright";
      const maybe: AbortSignal | undefined = undefined;
      const result: Decomposition = await decompose({ positions: [] }, { signal: maybe });
      new Blob([result.hullsFile, result.hulls[0].points]);
      await prepare();
      close();`,
    "tsconfig.json": JSON.stringify({ compilerOptions: { module: "nodenext", target: "es2022", strict: true, exactOptionalPropertyTypes: true, noEmit: true, types: [], lib: ["es2022", "dom"] } }),
  });
  for (const version of TYPESCRIPT) {
    run("npm", ["install", "--no-audit", "--no-fund", "--no-save", "--loglevel=error", `typescript@${version}`], place);
    assert.equal(run("npx", ["tsc"], place), "", version);
  }
});

test("a test of vitest under jsdom decomposes", () => {
  const place = project("jsdom", VITEST, {
    "a.test.js": `
      // @vitest-environment jsdom
      import { readFileSync } from "node:fs";
      import { expect, test } from "vitest";
      import { decompose, readMesh } from "hullwright";
      test("it decomposes", async () => {
        expect(typeof window).toBe("object");
        const mesh = await readMesh(readFileSync(${JSON.stringify(root("assets/chair.glb"))}), "glb");
        expect((await decompose(mesh)).hulls.length).toBeGreaterThan(1);
      });`,
  });
  assert.match(run("npx", ["vitest", "run", "--reporter=json"], place), /"numPassedTests":1,/);
});

test("a project of Parcel without settings builds, and decomposes in Chromium", async () => {
  const place = project("parcel", { parcel: PARCEL }, {
    "index.html": `<!doctype html><script type="module" src="./main.js"></script>`,
    "main.js": `
      import { decompose } from "hullwright";
      const mesh = { positions: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], indices: [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3] };
      decompose(mesh).then(({ hulls }) => { document.title = hulls.length + " hull"; }, (error) => { document.title = String(error); });`,
  });
  run("npx", ["parcel", "build", "index.html", "--no-cache", "--log-level=error"], place);
  const [server, browser] = [await serve(join(place, "dist")), await launch()];
  try {
    const page = await openPage(browser, `${server.address}/index.html`);
    await page.waitForFunction(() => document.title !== "", undefined, { timeout: 60_000 });
    assert.equal(await page.title(), "1 hull");
  } finally {
    await browser.close();
    server.close();
  }
});

test("a Vite project without settings builds, and decomposes in Chromium, served from a folder below the root", async () => {
  const place = project("vite", { vite: VITE, three: devDependencies.three }, {
    "index.html": `<!doctype html><script type="module" src="/main.js"></script>`,
    "main.js": `
      import { decompose } from "hullwright";
      import { fromGeometry, toGeometries } from "hullwright/three";
      import { TorusGeometry } from "three";
      const { hulls } = await decompose(fromGeometry(new TorusGeometry()));
      document.body.textContent = String(toGeometries(hulls).length);`,
  });
  const dist = join(folder, "served", "below");
  run("npx", ["vite", "build", "--base", "./", "--outDir", dist, "--emptyOutDir", "--logLevel", "error"], place);
  const [server, browser] = [await serve(join(folder, "served")), await launch()];
  try {
    const page = await openPage(browser, `${server.address}/below/`);
    await page.waitForFunction(() => Number(document.body.textContent) > 1, undefined, { timeout: 60_000 });
  } finally {
    await browser.close();
    server.close();
  }
});

test("Vite's development server, which bundles packages in another way, needs no settings either", async () => {
  const { createServer } = await import(join(folder, "vite/node_modules/vite/dist/node/index.js"));
  const server = await createServer({ root: join(folder, "vite"), logLevel: "error", server: { port: 0, host: "127.0.0.1" } });
  await server.listen();
  const browser = await launch();
  try {
    const page = await openPage(browser, server.resolvedUrls.local[0]);
    await page.waitForFunction(() => Number(document.body.textContent) > 1, undefined, { timeout: 120_000 });
  } finally {
    await browser.close();
    await server.close();
  }
});
