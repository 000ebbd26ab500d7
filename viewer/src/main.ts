// The page: its controls, and what they do to all panels.

import { readPage } from "./data";
import { element, number, percent, words } from "./dom";
import { Look, Panel } from "./panel";
import { RAMP, RAMP_END, shared } from "./shaders";
import { Stage } from "./stage";

/** How far hulls move apart at most, in their distances from the middle. */
const MOST_APART = 1.5;

/** How far by key, and how long that takes in milliseconds. */
const APART = 0.6;
const APART_TIME = 420;

/** What an arrow key turns, in radians, and what plus and minus zoom. */
const TURN = Math.PI / 24;
const ZOOM = 1.12;

const find = <E extends HTMLElement>(id: string) => document.getElementById(id) as E;

const KEYS: [string, string][] = [
  ["drag", "turn"],
  ["right drag, two fingers", "move"],
  ["wheel, pinch, + −", "zoom"],
  ["← → ↑ ↓", "turn"],
  ["click", "pick a hull"],
  ["N P", "next, previous hull"],
  ["Esc", "pick none"],
  ["[ ]", "fewer, more hulls"],
  ["{ }", "one hull, all hulls"],
  ["M", "mesh"],
  ["H", "hulls"],
  ["W", "wireframe"],
  ["C", "colours: hulls, errors"],
  ["O", "tint closed openings"],
  ["E", "move hulls apart"],
  ["Z", "which axis is up"],
  ["R", "look from the start"],
  ["Space", "keep turning"],
  ["T", "light, dark"],
  ["S", "save a picture"],
  ["?", "this list"],
];

async function start() {
  const page = await readPage();
  const doc = page.document;
  const isCalm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  document.title = `${doc.title} – Hullwright`;
  find("title").textContent = doc.title;
  find("about").textContent = [
    words(doc.mesh.source_triangles, "triangle"),
    `diagonal ${number(doc.diagonal)}`,
    `bound ${percent(doc.bound)}`,
    ...openings(doc.openings),
  ].join(" · ");
  find("program").textContent = doc.program;

  const look: Look = {
    mesh: false,
    hulls: true,
    wires: false,
    errors: false,
    openings: true,
    up: doc.up,
  };
  let stage: Stage | undefined;
  const draw = () => stage?.draw();
  const host = find("panels");
  host.classList.toggle("many", page.sets.length > 1);
  shared.bound.value = doc.bound;
  const panels = page.sets.map((set) => new Panel(page, set, look, draw, host));
  paint();
  const triangles = panels.reduce((sum, panel) => sum + panel.triangles, 0);
  const canvas = find<HTMLCanvasElement>("canvas");
  stage = new Stage(canvas, panels, page.mesh.positions, triangles, look, isCalm);
  const active = stage;

  /** The panel that keys go to: the one whose slider was touched last. */
  let current = 0;
  panels.forEach((_, index) => {
    host.children[index].addEventListener("focusin", () => (current = index));
  });

  function update() {
    for (const [id, isOn] of [
      ["mesh", look.mesh],
      ["hulls", look.hulls],
      ["wires", look.wires],
      ["errors", look.errors],
      ["openings", look.openings],
      ["up", look.up === "z"],
    ] as const) {
      find(id).setAttribute("aria-pressed", String(isOn));
    }
    shared.errors.value = look.errors ? 1 : 0;
    find("legend").hidden = !look.errors;
    panels.forEach((panel) => panel.update());
  }

  function toggle(what: "mesh" | "hulls" | "wires" | "errors" | "openings") {
    look[what] = !look[what];
    // Something is always to be seen.
    if (what === "mesh" && !look.mesh && !look.hulls) look.hulls = true;
    if (what === "hulls" && !look.hulls) look.mesh = true;
    if (what === "openings" && look.openings) look.mesh = true;
    update();
  }

  const apart = find<HTMLInputElement>("apart");
  function explode(value: number) {
    shared.explosion.value = value;
    apart.value = String(value);
    draw();
  }
  apart.max = String(MOST_APART);
  apart.addEventListener("input", () => explode(Number(apart.value)));

  /** Moves there, or is there at once where motion is not wanted. */
  function explodeTo(value: number) {
    const from = shared.explosion.value;
    if (isCalm) return explode(value);
    const begin = performance.now();
    const step = (now: number) => {
      const share = Math.min(1, Math.max(0, (now - begin) / APART_TIME));
      explode(from + (value - from) * (1 - (1 - share) ** 3));
      if (share < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  function paint() {
    const style = getComputedStyle(document.documentElement);
    shared.paper.value.set(style.getPropertyValue("--paper").trim());
    shared.wires.value = style.getPropertyValue("--is-dark").trim() === "1" ? 0 : 0.3;
    shared.ink.value.set(style.getPropertyValue("--ink-line").trim());
    draw();
  }

  function theme() {
    const root = document.documentElement;
    const isDark = getComputedStyle(root).getPropertyValue("--is-dark").trim() === "1";
    root.dataset.theme = isDark ? "light" : "dark";
    paint();
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);

  function up() {
    look.up = look.up === "y" ? "z" : "y";
    update();
  }

  function save() {
    const link = element("a");
    link.href = find<HTMLCanvasElement>("canvas").toDataURL("image/png");
    link.download = `${doc.title.replace(/[^\w.-]+/g, "_")}.png`;
    link.click();
  }

  const help = find<HTMLDialogElement>("help-list");
  const list = find("keys");
  for (const [key, what] of KEYS) list.append(element("dt", "", key), element("dd", "", what));
  const showHelp = () => (help.open ? help.close() : help.showModal());
  find("close").addEventListener("click", () => help.close());
  help.addEventListener("click", (event) => {
    if (event.target === help) help.close();
  });

  for (const id of ["mesh", "hulls", "wires", "errors", "openings"] as const) {
    find(id).addEventListener("click", () => toggle(id));
  }
  find("openings").hidden = doc.mesh.caps === 0;
  find("up").addEventListener("click", up);
  find("theme").addEventListener("click", theme);
  find("home").addEventListener("click", () => active.home());
  find("help").addEventListener("click", showHelp);
  legend(doc.bound);

  const keys: Record<string, () => void> = {
    m: () => toggle("mesh"),
    h: () => toggle("hulls"),
    w: () => toggle("wires"),
    c: () => toggle("errors"),
    o: () => doc.mesh.caps > 0 && toggle("openings"),
    e: () => explodeTo(shared.explosion.value > 0 ? 0 : APART),
    z: up,
    r: () => active.home(),
    t: theme,
    s: save,
    n: () => panels[current].step(1),
    p: () => panels[current].step(-1),
    "[": () => panels[current].join(panels[current].joins + 1),
    "]": () => panels[current].join(panels[current].joins - 1),
    "{": () => panels[current].join(Infinity),
    "}": () => panels[current].join(0),
    "+": () => active.zoom(ZOOM),
    "=": () => active.zoom(ZOOM),
    "-": () => active.zoom(1 / ZOOM),
    "?": showHelp,
    " ": () => (active.controls.autoRotate = !active.controls.autoRotate),
    escape: () => panels.forEach((panel) => panel.select(null)),
    arrowleft: () => active.turn(-TURN, 0),
    arrowright: () => active.turn(TURN, 0),
    arrowup: () => active.turn(0, TURN),
    arrowdown: () => active.turn(0, -TURN),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.toLowerCase();
    const on = event.target as HTMLElement;
    // Sliders and buttons keep their own keys.
    if (on.tagName === "INPUT" && key.startsWith("arrow")) return;
    if (on.tagName === "BUTTON" && key === " ") return;
    if (help.open && key !== "?") return;
    const act = keys[key];
    if (!act) return;
    event.preventDefault();
    act();
  });

  update();
  // For tests and for who embeds the page.
  Object.assign(window, { hullwright: { panels, stage, look, shared } });
  document.documentElement.dataset.ready = "true";
}

/** What became of the mesh's openings, in words. */
function openings(all: { outcome: string }[]): string[] {
  if (all.length === 0) return [];
  const closed = all.filter(({ outcome }) => outcome.startsWith("closed")).length;
  const parts = [];
  if (closed > 0) parts.push(`${words(closed, "opening")} closed`);
  if (closed < all.length) parts.push(`${words(all.length - closed, "opening")} left`);
  return parts;
}

function legend(bound: number) {
  const labels = find("legend-labels").children;
  labels[0].textContent = "0";
  labels[1].textContent = `bound ${percent(bound)}`;
  labels[2].textContent = `≥ ${percent(RAMP_END * bound)}`;
  find("ramp").style.background = `linear-gradient(to right, ${RAMP.join(", ")})`;
}

start().catch((error: unknown) => {
  const message = find("message");
  message.textContent = error instanceof Error ? error.message : String(error);
  message.hidden = false;
});
