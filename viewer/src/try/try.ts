// The page on which anyone tries the method: a mesh from a file or a bundled one, decomposed in a worker with every change
// of a setting, while the hulls before stay. What is drawn is the view of `hullwright view`.

import { meshArrays, namedFiles, parameterText } from "../../../crates/web/npm/src/arguments";
import { inflate } from "../../../crates/web/npm/src/inflate";
import type { Mass, Parameters, ReadMesh } from "../../../crates/web/npm/src/types";
import { find } from "../controls";
import { Page, pageOf, text } from "../data";
import { element, words } from "../dom";
import { shared } from "../shaders";
import { View } from "../view";
import { Desk } from "./jobs";
import { openPhysics } from "./physics";

/** Settings of the sliders, in percent of the diagonal. */
const BOUNDS = [0.2, 0.3, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 7, 10];
const DEFAULT_BOUND = BOUNDS.indexOf(2);
const PROBES = [0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 15];

/** A slider that moves decomposes once, when it has rested so long, in milliseconds. */
const REST = 200;

/** The first model that is shown. */
const FIRST = "mug";

const input = (id: string) => find<HTMLInputElement>(id);
const chosen = (id: string) => find<HTMLSelectElement>(id).value;

class Superseded extends Error {}

interface Subject {
  title: string;
  mesh: ReadMesh;
}

/** The worker that keeps what is shown, and the one that makes what will be. */
let kept: Desk | undefined;
let working: Desk | undefined;
let subject: Subject | undefined;
let shown: { page: Page; mass: Mass; settings: Parameters } | undefined;
let view: View | undefined;

function settings(): Parameters {
  const probe = PROBES[Number(input("probe").value)];
  return {
    maxError: `${BOUNDS[Number(input("bound").value)]}%`,
    probeRadius: probe ? `${probe}%` : "none",
    maxHulls: input("max-hulls").value ? Number(input("max-hulls").value) : "none",
    maxVertices: input("max-vertices").value ? Number(input("max-vertices").value) : "none",
    openings: chosen("openings-rule") as Parameters["openings"],
    preset: chosen("preset") as Parameters["preset"],
  };
}

/** The tag of the plugin for Bevy with these settings. */
export function tag({ maxError, probeRadius, maxHulls, maxVertices, openings, preset }: Parameters, diagonal: number): string {
  const share = (length: string) => Number((parseFloat(length) / 100).toPrecision(12));
  const word = (name: string) => name[0].toUpperCase() + name.slice(1);
  const calls = [];
  if (maxError && maxError !== "2%") calls.push(`.with_max_error(${share(maxError)})`);
  if (preset && preset !== "balanced") calls.push(`.with_preset(DecompositionPreset::${word(preset)})`);
  if (typeof maxHulls === "number") calls.push(`.with_max_hulls(${maxHulls})`);
  if (maxVertices === "none") calls.push(".with_max_vertices(None)");
  else if (maxVertices !== 64) calls.push(`.with_max_vertices(${maxVertices})`);
  if (openings && openings !== "auto") calls.push(`.with_openings(DecompositionOpenings::${word(openings)})`);
  // In metres of the world: those of the mesh, if its entity has no scale. A whole number is no `f32` in Rust.
  const radius = String(Number((share(probeRadius ?? "none") * diagonal).toPrecision(3)));
  if (probeRadius !== "none") calls.push(`.with_probe_radius(${/[.e]/.test(radius) ? radius : `${radius}.0`})`);
  return ["ConvexDecomposition::default()", ...calls].join("");
}

/** The call of the package with these settings. */
export function call(parameters: Parameters): string {
  const defaults: Record<string, unknown> = { maxError: "2%", preset: "balanced", maxHulls: "none", maxVertices: 64, probeRadius: "none", openings: "auto" };
  const given = Object.entries(parameters).filter(([name, value]) => value !== undefined && value !== defaults[name]);
  const options = given.map(([name, value]) => `${name}: ${JSON.stringify(value)}`).join(", ");
  return options ? `await decompose(mesh, { ${options} })` : "await decompose(mesh)";
}

function say(text: string) {
  find("status").textContent = text;
}

function fail(error: unknown) {
  const message = find("failure");
  message.hidden = error === undefined;
  message.textContent = error instanceof Error ? error.message : String(error ?? "");
}

/** Shows that there is work, or that there is none. */
function busy(isBusy: boolean) {
  find("progress").hidden = find("cancel").hidden = !isBusy;
  input("progress").value = "0";
  document.documentElement.dataset.busy = String(isBusy);
  for (const id of ["drop", "save-hulls", "save-glb", "copy-tag", "copy-js"]) find<HTMLButtonElement>(id).disabled = !shown;
}

/** Begins anew: what runs is ended, and what falls is of the mesh before. */
function begin(): Desk {
  working?.end(new Superseded());
  find<HTMLDialogElement>("physics").close();
  fail(undefined);
  busy(true);
  return (working = new Desk());
}

/** Runs work of a fresh worker, which is kept where the work is its last. */
async function run(work: (desk: Desk) => Promise<void>) {
  const desk = begin();
  try {
    await work(desk);
  } catch (error) {
    desk.end(error);
    if (error instanceof Superseded) return;
    fail(error);
    say(shown ? "What is shown is the decomposition before." : "");
  }
  if (working === desk) working = undefined;
  if (!working) busy(false);
}

async function decompose(desk: Desk, { title, mesh }: Subject) {
  say(`${title}: ${words(mesh.indices.length / 3, "triangle")}…`);
  const start = performance.now();
  const onProgress = ({ stage, fraction }: { stage: string; fraction: number }) => {
    input("progress").value = String(fraction);
    say(fraction < 1 ? `${title}: ${stage}` : `${title}: errors`);
  };
  const wanted = settings();
  const made = await desk.call("show", [meshArrays(mesh), title, parameterText(wanted), input("compare").checked], onProgress);
  kept?.end(new Superseded());
  kept = desk;
  const page = pageOf(made.document, made.geometry.buffer as ArrayBuffer);
  shown = { page, mass: made.mass, settings: wanted };
  subject = { title, mesh };
  if (view) view.replace(page);
  else {
    view = new View(page);
    Object.assign(window, { hullwright: { ...view, shared, tag } });
  }
  find("remarks").textContent = made.remarks;
  const seconds = ((performance.now() - start) / 1000).toFixed(2);
  say(`${words(page.sets[0].entry.leaves, "hull")}; ${seconds} s with measuring and drawing`);
  document.documentElement.dataset.ready = "true";
  document.documentElement.dataset.shown = String(Number(document.documentElement.dataset.shown ?? 0) + 1);
}

/** Reads files, and decomposes the mesh in them. */
function open(title: string, read: () => Promise<Record<string, Uint8Array>>) {
  return run(async (desk) => {
    say(`reading ${title}`);
    const mesh = await desk.call("read", [namedFiles(await read())]);
    await decompose(desk, { title, mesh });
  });
}

/** Decomposes what is shown with the settings of now. */
function again() {
  const now = subject;
  if (now) void run((desk) => decompose(desk, now));
}

async function openFiles(files: File[]) {
  if (files.length === 0) return;
  const main = files.find(({ name }) => /\.(glb|gltf|obj|off|ply|stl)$/i.test(name)) ?? files[0];
  find<HTMLSelectElement>("model").value = "";
  await open(main.name, async () => {
    const entries = files.map(async (file) => [file.name, new Uint8Array(await file.arrayBuffer())] as const);
    return Object.fromEntries(await Promise.all(entries));
  });
}

function save(name: string, bytes: Uint8Array) {
  const link = element("a");
  link.href = URL.createObjectURL(new Blob([bytes as BlobPart]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

const stem = (title: string) => title.replace(/\.[^.]*$/, "").replace(/[^\w.-]+/g, "_") || "mesh";

/** How many hulls the slider shows. */
const count = () => view?.panels[0]?.state.hulls ?? 1;

/** What makes what is shown: with fewer hulls than there are by a limit, whatever the form says by now. */
function shownSettings({ page, settings }: { page: Page; settings: Parameters }): Parameters {
  return count() < page.sets[0].entry.leaves ? { ...settings, maxHulls: count() } : settings;
}

function connect() {
  const models = JSON.parse(text("models")) as Record<string, string>;
  const select = find<HTMLSelectElement>("model");
  select.append(new Option("a bundled model", ""), ...Object.keys(models).map((name) => new Option(name, name)));
  const openModel = (name: string) =>
    open(name, async () => ({ [`${name}.glb`]: new Uint8Array(await inflate(models[name], "gzip")) }));
  select.addEventListener("change", () => select.value && void openModel(select.value));
  input("files").addEventListener("change", () => {
    void openFiles([...(input("files").files ?? [])]);
    // The same file again is a change, too.
    input("files").value = "";
  });

  input("bound").max = String(BOUNDS.length - 1);
  input("bound").value = String(DEFAULT_BOUND);
  input("probe").max = String(PROBES.length - 1);
  input("probe").value = "0";
  const label = () => {
    find("bound-text").textContent = `${BOUNDS[Number(input("bound").value)]} %`;
    const probe = PROBES[Number(input("probe").value)];
    find("probe-text").textContent = probe ? `radius ${probe} %` : "none";
  };
  label();
  let timer = 0;
  for (const id of ["bound", "probe", "max-hulls", "max-vertices", "openings-rule", "preset", "compare"]) {
    find(id).addEventListener("input", () => {
      label();
      clearTimeout(timer);
      timer = window.setTimeout(again, REST);
    });
  }
  if (matchMedia("(max-width: 720px)").matches) find<HTMLDetailsElement>("settings").open = false;

  find("cancel").addEventListener("click", () => {
    working?.end(new Superseded());
    working = undefined;
    busy(false);
    say("cancelled");
  });
  const title = () => stem(subject?.title ?? "mesh");
  const act = (id: string, work: () => Promise<unknown>) => find(id).addEventListener("click", () => void work().catch(fail));
  act("save-hulls", async () => kept && save(`${title()}.hulls`, await kept.call("file", [title(), count()])));
  act("save-glb", async () => kept && save(`${title()}-hulls.glb`, await kept.call("glb", [count()])));
  const copy = async (code: string) => {
    await navigator.clipboard.writeText(code).catch(() => copyByHand(code));
    say(`copied: ${code}`);
  };
  act("copy-tag", async () => shown && copy(tag(shownSettings(shown), shown.page.document.diagonal)));
  act("copy-js", async () => shown && copy(call(shownSettings(shown))));
  act("drop", async () => {
    if (!kept || !shown) return;
    const { mass, page: { document: { diagonal, colours } } } = shown;
    const hulls = await kept.call("hulls", [count()]);
    await openPhysics({ hulls, mass, diagonal, isZUp: view?.look.up === "z", colours });
  });

  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("over");
  });
  addEventListener("dragleave", () => document.body.classList.remove("over"));
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("over");
    void openFiles([...(event.dataTransfer?.files ?? [])]);
  });
  select.value = FIRST;
  void openModel(FIRST);
}

/** Where the browser has no clipboard for pages from disk. */
function copyByHand(text: string) {
  const area = element("textarea");
  area.value = text;
  document.body.append(area);
  area.select();
  document.execCommand("copy");
  area.remove();
}

connect();
