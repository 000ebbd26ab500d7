// The page's buttons and keys, and what they do to all panels.

import { Page } from "./data";
import { element } from "./dom";
import { Look, Panel } from "./panel";
import { shared } from "./shaders";
import { Stage } from "./stage";

/** How far hulls move apart at most, in their distances from the middle. */
const MOST_APART = 1.5;

/** How far by key, and how long that takes in milliseconds. */
const APART = 0.6;
const APART_TIME = 420;

/** What an arrow key turns, in radians, and what plus and minus zoom. */
const TURN = Math.PI / 24;
const ZOOM = 1.12;

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
  ["F", "what the probe does not reach"],
  ["E", "move hulls apart"],
  ["Z", "which axis is up"],
  ["R", "look from the start"],
  ["Space", "keep turning"],
  ["T", "light, dark"],
  ["S", "save a picture"],
  ["?", "this list"],
];

/** Of these a simplified mesh has none, or others. */
const KEYS_OF_HULLS = ["click", "N P", "Esc", "[ ]", "{ }", "M", "H", "C", "O", "F", "E"];
const KEYS_OF_SIMPLIFIED: [string, string][] = [
  ["B", "before, after"],
  ["M", "before"],
  ["H", "after"],
  ["C", "distances as colours"],
];

/** What is on or off. */
const SWITCHES = ["mesh", "hulls", "wires", "errors", "openings", "filled"] as const;
type Switch = (typeof SWITCHES)[number];

export const find = <E extends HTMLElement>(id: string) => document.getElementById(id) as E;

/** Takes the colours of the drawing from those of the page. */
export function paint() {
  const style = getComputedStyle(document.documentElement);
  shared.paper.value.set(style.getPropertyValue("--paper").trim());
  shared.wires.value = isDark() ? 0 : 0.3;
  shared.ink.value.set(style.getPropertyValue("--ink-line").trim());
}

function isDark(): boolean {
  return getComputedStyle(document.documentElement).getPropertyValue("--is-dark").trim() === "1";
}

function fillKeys(keys: [string, string][]) {
  for (const [key, what] of keys) find("keys").append(element("dt", "", key), element("dd", "", what));
}

export class Controls {
  /** The panel that keys go to: the one whose slider was touched last. */
  private current = 0;
  private readonly apart = find<HTMLInputElement>("apart");
  private readonly help = find<HTMLDialogElement>("help-list");
  private readonly keys: Record<string, () => void>;

  constructor(
    private page: Page,
    private readonly panels: Panel[],
    private readonly stage: Stage,
    private readonly look: Look,
    private readonly isCalm: boolean,
  ) {
    this.keys = this.keyTable();
    for (const id of SWITCHES) find(id).addEventListener("click", () => this.toggle(id));
    find("up").addEventListener("click", () => this.turnUp());
    find("theme").addEventListener("click", () => this.theme());
    find("home").addEventListener("click", () => stage.home());
    this.apart.max = String(MOST_APART);
    this.apart.addEventListener("input", () => this.explode(Number(this.apart.value)));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.repaint());
    document.addEventListener("keydown", (event) => this.press(event));
    this.listKeys();
    this.replace(page);
  }

  /** The panels show another page. */
  replace(page: Page) {
    this.page = page;
    this.current = 0;
    this.panels.forEach((panel, index) => {
      panel.viewport.parentElement?.addEventListener("focusin", () => (this.current = index));
    });
    find("openings").hidden = !this.hasOpenings;
    find("filled").hidden = page.filled === null;
    if (page.document.is_simplified) this.rename();
    this.update();
  }

  /** Words for a mesh before and after simplification. */
  private rename() {
    for (const [id, word, title] of [
      ["mesh", "Before", "Before (M)"],
      ["hulls", "After", "After (H)"],
    ]) {
      find(id).textContent = word;
      find(id).title = title;
    }
    find("errors").title = "Distances as colours (C)";
    find("legend").querySelector("p")!.textContent = "How far each of the two surfaces is from the other";
    this.stage.canvas.ariaLabel = "The mesh before or after simplification; drag to turn, press ? for keys";
    this.apart.parentElement!.hidden = true;
    find("keys").replaceChildren();
    fillKeys([...KEYS_OF_SIMPLIFIED, ...KEYS.filter(([key]) => !KEYS_OF_HULLS.includes(key))]);
  }

  /** Shows what the look says, on the buttons too. */
  private update() {
    const { look } = this;
    for (const id of SWITCHES) find(id).setAttribute("aria-pressed", String(look[id]));
    find("up").setAttribute("aria-pressed", String(look.up === "z"));
    find("legend").hidden = !look.errors;
    this.panels.forEach((panel) => panel.update());
  }

  private get isSimplified(): boolean {
    return this.page.document.is_simplified;
  }

  private get hasOpenings(): boolean {
    return this.page.document.mesh.caps > 0 && !this.isSimplified;
  }

  private toggle(what: Switch) {
    const { look } = this;
    look[what] = !look[what];
    // Before or after: the surfaces lie in each other.
    if (this.isSimplified && what === "mesh") look.hulls = !(look.mesh = true);
    if (this.isSimplified && what === "hulls") look.mesh = !(look.hulls = true);
    // Something is always to be seen.
    if (what === "mesh" && !look.mesh && !look.hulls) look.hulls = true;
    if (what === "hulls" && !look.hulls) look.mesh = true;
    if (what === "openings" && look.openings) look.mesh = true;
    // Hulls lie over what is filled, and would hide it.
    if (what === "filled" && look.filled) Object.assign(look, { mesh: true, hulls: false });
    this.update();
  }

  private turnUp() {
    this.look.up = this.look.up === "y" ? "z" : "y";
    this.update();
  }

  private explode(value: number) {
    shared.explosion.value = value;
    this.apart.value = String(value);
    this.stage.draw();
  }

  /** Moves there, or is there at once where motion is not wanted. */
  private explodeTo(value: number) {
    const from = shared.explosion.value;
    if (this.isCalm) return this.explode(value);
    const begin = performance.now();
    const step = (now: number) => {
      const share = Math.min(1, Math.max(0, (now - begin) / APART_TIME));
      this.explode(from + (value - from) * (1 - (1 - share) ** 3));
      if (share < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  private repaint() {
    paint();
    this.stage.draw();
  }

  private theme() {
    document.documentElement.dataset.theme = isDark() ? "light" : "dark";
    this.repaint();
  }

  private save() {
    const link = element("a");
    link.href = this.stage.canvas.toDataURL("image/png");
    link.download = `${this.page.document.title.replace(/[^\w.-]+/g, "_")}.png`;
    link.click();
  }

  private listKeys() {
    const { help } = this;
    fillKeys(KEYS);
    find("help").addEventListener("click", () => this.showHelp());
    find("close").addEventListener("click", () => help.close());
    help.addEventListener("click", (event) => {
      if (event.target === help) help.close();
    });
  }

  private showHelp() {
    if (this.help.open) this.help.close();
    else this.help.showModal();
  }

  private keyTable(): Record<string, () => void> {
    const { stage, panels } = this;
    const panel = () => panels[this.current];
    return {
      b: () => this.isSimplified && this.toggle(this.look.mesh ? "hulls" : "mesh"),
      m: () => this.toggle("mesh"),
      h: () => this.toggle("hulls"),
      w: () => this.toggle("wires"),
      c: () => this.toggle("errors"),
      o: () => this.hasOpenings && this.toggle("openings"),
      f: () => this.page.filled && this.toggle("filled"),
      e: () => this.isSimplified || this.explodeTo(shared.explosion.value > 0 ? 0 : APART),
      z: () => this.turnUp(),
      r: () => stage.home(),
      t: () => this.theme(),
      s: () => this.save(),
      n: () => panel().step(1),
      p: () => panel().step(-1),
      "[": () => panel().join(panel().joins + 1),
      "]": () => panel().join(panel().joins - 1),
      "{": () => panel().join(Infinity),
      "}": () => panel().join(0),
      "+": () => stage.zoom(ZOOM),
      "=": () => stage.zoom(ZOOM),
      "-": () => stage.zoom(1 / ZOOM),
      "?": () => this.showHelp(),
      " ": () => (stage.controls.autoRotate = !stage.controls.autoRotate),
      escape: () => panels.forEach((panel) => panel.select(null)),
      arrowleft: () => stage.turn(-TURN, 0),
      arrowright: () => stage.turn(TURN, 0),
      arrowup: () => stage.turn(0, TURN),
      arrowdown: () => stage.turn(0, -TURN),
    };
  }

  private press(event: KeyboardEvent) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.toLowerCase();
    const on = event.target as HTMLElement;
    // Sliders and buttons keep their own keys.
    if (on.tagName === "INPUT" && key.startsWith("arrow")) return;
    if (["BUTTON", "SUMMARY", "LABEL"].includes(on.tagName) && key === " ") return;
    if (on.matches("select, input[type=number], input[type=checkbox]")) return;
    if (document.querySelector("dialog[open]") && !this.help.open) return;
    if (this.help.open && key !== "?") return;
    const act = this.keys[key];
    if (!act) return;
    event.preventDefault();
    act();
  }
}
