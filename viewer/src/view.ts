// What is drawn of a page: panels, stage and controls, and what the page is about in words. Another page may take its place.

import { Controls, find, paint } from "./controls";
import { Page } from "./data";
import { number, percent, words } from "./dom";
import { Look, Panel } from "./panel";
import { RAMP, RAMP_END, shared } from "./shaders";
import { Stage } from "./stage";

export class View {
  readonly look: Look;
  readonly panels: Panel[] = [];
  readonly stage: Stage;
  private readonly controls: Controls;

  constructor(page: Page) {
    const isCalm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const { is_simplified: wires, up } = page.document;
    this.look = { mesh: false, hulls: true, wires, errors: false, openings: true, filled: false, up };
    paint();
    this.fill(page);
    const triangles = this.panels.reduce((sum, panel) => sum + panel.triangles, 0);
    const canvas = find<HTMLCanvasElement>("canvas");
    this.stage = new Stage(canvas, this.panels, page.mesh.positions, triangles, this.look, isCalm);
    this.controls = new Controls(page, this.panels, this.stage, this.look, isCalm);
  }

  /** Shows another page with the same look, from where the camera is. */
  replace(page: Page) {
    for (const panel of this.panels.splice(0)) panel.dispose();
    this.fill(page);
    this.stage.replace(page.mesh.positions);
    this.controls.replace(page);
  }

  private fill(page: Page) {
    const { bound } = page.document;
    introduce(page);
    legend(bound);
    const host = find("panels");
    host.classList.toggle("many", page.sets.length > 1);
    shared.bound.value = bound;
    const draw = () => this.stage?.draw();
    this.panels.push(...page.sets.map((set) => new Panel(page, set, this.look, draw, host)));
  }
}

/** Says what the page is about. */
function introduce({ document: doc }: Page) {
  document.title = `${doc.title} – Hullwright`;
  find("title").textContent = doc.title;
  find("about").textContent = [
    words(doc.mesh.source_triangles, "triangle"),
    `diagonal ${number(doc.diagonal)}`,
    `bound ${percent(doc.bound)}`,
    ...openings(doc.openings),
  ].join(" · ");
  find("program").textContent = doc.program;
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
