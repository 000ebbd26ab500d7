// Hulls against error, with a marker: the states that the slider goes through.

import { State } from "./data";
import { drawing, element, percent } from "./dom";

const WIDTH = 300;
const HEIGHT = 128;
const MARGIN = { left: 44, right: 12, top: 10, bottom: 30 };

export class Curve {
  readonly element = element("figure", "curve");
  private readonly svg: SVGElement;
  private readonly marker = drawing("circle", { r: 5, class: "marker" });
  private readonly drop = drawing("line", { class: "drop" });
  private readonly most: number;
  private readonly highest: number;

  constructor(
    private readonly states: State[],
    bound: number,
    choose: (state: number) => void,
  ) {
    this.most = Math.max(2, states[0]?.hulls ?? 2);
    this.highest = Math.max(...states.map((state) => state.error), bound) * 1.08;
    const svg = drawing("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
    svg.setAttribute("aria-label", "Hulls against error");
    this.svg = svg;
    this.axes(bound);
    const points = states.map((state) => `${this.x(state.hulls)},${this.y(state.error)}`);
    svg.append(drawing("polyline", { points: points.join(" "), class: "line" }));
    if (states.length <= 30) {
      for (const state of states) {
        svg.append(drawing("circle", { cx: this.x(state.hulls), cy: this.y(state.error), r: 2.4, class: "dot" }));
      }
    }
    // What moves is a layer of its own: the curve is not drawn anew for it.
    const over = drawing("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "over", "aria-hidden": "true" });
    over.append(this.drop, this.marker);
    this.element.append(svg, over);
    const follow = (event: PointerEvent) => choose(this.nearest(event));
    svg.addEventListener("pointerdown", (event) => {
      svg.setPointerCapture(event.pointerId);
      follow(event);
    });
    svg.addEventListener("pointermove", (event) => {
      if (event.buttons > 0) follow(event);
    });
  }

  /** Hulls, in logarithms: the few are told apart. */
  private x(hulls: number): number {
    const share = Math.log(hulls) / Math.log(this.most);
    return MARGIN.left + share * (WIDTH - MARGIN.left - MARGIN.right);
  }

  private y(error: number): number {
    return HEIGHT - MARGIN.bottom - (error / this.highest) * (HEIGHT - MARGIN.top - MARGIN.bottom);
  }

  private axes(bound: number) {
    const [left, right, bottom] = [MARGIN.left, WIDTH - MARGIN.right, HEIGHT - MARGIN.bottom];
    const line = (x1: number, y1: number, x2: number, y2: number, name: string) =>
      this.svg.append(drawing("line", { x1, y1, x2, y2, class: name }));
    const label = (x: number, y: number, text: string, anchor: string) => {
      const made = drawing("text", { x, y, "text-anchor": anchor });
      made.textContent = text;
      this.svg.append(made);
    };
    line(left, bottom, right, bottom, "axis");
    line(left, this.y(bound), right, this.y(bound), "bound");
    label(left - 5, this.y(bound) + 3.5, percent(bound), "end");
    const top = this.highest / 1.08;
    if (this.y(bound) - this.y(top) > 14) label(left - 5, this.y(top) + 3.5, percent(Number(top.toPrecision(2))), "end");
    if (bottom - this.y(bound) > 16) label(left - 5, bottom + 3.5, "0", "end");
    for (const hulls of ticks(this.most)) {
      line(this.x(hulls), bottom, this.x(hulls), bottom + 3, "axis");
      label(this.x(hulls), bottom + 13, String(hulls), "middle");
    }
    label((left + right) / 2, HEIGHT - 4, "hulls", "middle");
    const side = drawing("text", { x: 0, y: 0, "text-anchor": "middle" });
    side.setAttribute("transform", `translate(9 ${(MARGIN.top + bottom) / 2}) rotate(-90)`);
    side.textContent = "error";
    this.svg.append(side);
  }

  private nearest(event: PointerEvent): number {
    const box = this.svg.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * WIDTH;
    let best = 0;
    this.states.forEach((state, index) => {
      if (Math.abs(this.x(state.hulls) - x) < Math.abs(this.x(this.states[best].hulls) - x)) best = index;
    });
    return best;
  }

  mark(index: number) {
    const { hulls, error } = this.states[index];
    const [x, y] = [this.x(hulls), this.y(error)];
    this.marker.setAttribute("cx", String(x));
    this.marker.setAttribute("cy", String(y));
    const ends = { x1: x, x2: x, y1: y, y2: HEIGHT - MARGIN.bottom };
    for (const [name, value] of Object.entries(ends)) this.drop.setAttribute(name, String(value));
  }
}

/** 1, 2, 5, 10, … up to the most, which is always one of them. */
function ticks(most: number): number[] {
  const found = [];
  for (let power = 1; power <= most; power *= 10) {
    found.push(...[1, 2, 5].map((x) => x * power).filter((x) => x < most * 0.8));
  }
  return [...found, most];
}
