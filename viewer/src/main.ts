// The page: reads its data, says what it is about, and sets up panels, stage and controls.

import { Controls, find, paint } from "./controls";
import { Page, readPage } from "./data";
import { number, percent, words } from "./dom";
import { Look, Panel } from "./panel";
import { RAMP, RAMP_END, shared } from "./shaders";
import { Stage } from "./stage";

async function start() {
  const page = await readPage();
  const isCalm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const { up, bound } = page.document;
  introduce(page);
  legend(bound);
  const look: Look = { mesh: false, hulls: true, wires: false, errors: false, openings: true, up };
  let stage: Stage | undefined;
  const draw = () => stage?.draw();
  const host = find("panels");
  host.classList.toggle("many", page.sets.length > 1);
  shared.bound.value = bound;
  paint();
  const panels = page.sets.map((set) => new Panel(page, set, look, draw, host));
  const triangles = panels.reduce((sum, panel) => sum + panel.triangles, 0);
  const canvas = find<HTMLCanvasElement>("canvas");
  stage = new Stage(canvas, panels, page.mesh.positions, triangles, look, isCalm);
  new Controls(page, panels, stage, look, isCalm);
  // For tests and for who embeds the page.
  Object.assign(window, { hullwright: { panels, stage, look, shared } });
  document.documentElement.dataset.ready = "true";
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

start().catch((error: unknown) => {
  const message = find("message");
  message.textContent = error instanceof Error ? error.message : String(error);
  message.hidden = false;
});
