// One set of hulls beside the others: its part of the stage, its slider, figures and curve.

import { BufferGeometry, Color, FrontSide, Group, LineSegments, Mesh, Ray, Scene, ShaderMaterial, Vector3 } from "three";
import { rest } from "./ball";
import { Curve } from "./curve";
import { alive, colourNumbers, HullSet, Page, State, uncoveredAfter } from "./data";
import { element, number, percent, words } from "./dom";
import { material, repurpose, shared } from "./shaders";
import * as shapes from "./shapes";

/** Which surfaces are drawn, and how: the same for all panels. */
export interface Look {
  mesh: boolean;
  hulls: boolean;
  wires: boolean;
  errors: boolean;
  openings: boolean;
  filled: boolean;
  up: "y" | "z";
}

/** Of hulls over the mesh: both are seen. */
const OVER_MESH = 0.62;

/** Of what a probe does not reach: the gaps below are seen. */
const FILLED = 0.55;

/** What a simplified mesh has. */
const FIGURES_OF_SIMPLIFIED = [
  ["error", "distance, at most", "The larger of the next two, in diagonals of the mesh"],
  ["protrusion", "after from before", "How far any point of the mesh after simplification is from the one before"],
  ["uncovered", "before from after", "How far any point of the mesh before simplification is from the one after"],
  ["vertices", "vertices after", "Of the mesh after simplification"],
];

const linear = (rgb: readonly number[]): number[] =>
  new Color().setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255, "srgb").toArray();

export class Panel {
  readonly viewport = element("div", "viewport");
  readonly scene = new Scene();
  /** Hulls that are left out of those that there are: each is a join. */
  joins = 0;
  picked: number | null = null;
  private areCreasesLeftOut = false;
  /** Whether the slider or the look has changed since the mesh was coloured. */
  private isMeshStale = true;
  private root = new Group();
  private hulls: number[] = [];
  private readonly colours: number[][];
  private readonly ways: number[][];
  private readonly edges: shapes.EdgeTable;
  private readonly curve: Curve;
  private readonly slider = element("input", "hulls-slider");
  private readonly count = element("output", "count");
  private readonly figures = new Map<string, HTMLElement>();
  private readonly pick = element("p", "pick");
  private readonly faces = new Mesh(new BufferGeometry(), material("FACES", 1));
  private readonly depth = new Mesh(new BufferGeometry(), material("FACES", 1));
  private readonly lines = new LineSegments(new BufferGeometry(), material("CREASES", 1));
  private readonly meshFaces: Mesh<BufferGeometry, ShaderMaterial>;
  private readonly meshCreases = new LineSegments(new BufferGeometry(), material("CREASES", 1));
  private readonly meshWires = new LineSegments(new BufferGeometry(), material("CREASES", 1));
  private readonly filled = new Mesh(new BufferGeometry(), material("FACES", 1));
  private readonly ball = new Mesh(new BufferGeometry(), material("FACES", 1));
  /** What still has to be made before each of them is drawn: most are never seen. */
  private readonly stale = new Map<Mesh | LineSegments, () => BufferGeometry>();

  constructor(
    private readonly page: Page,
    private readonly set: HullSet,
    private readonly look: Look,
    private readonly changed: () => void,
    host: HTMLElement,
  ) {
    const { colours, clay, cap } = page.document;
    const palette = colours.map(linear);
    this.colours = colourNumbers(set).map((colour) => palette[colour % palette.length]);
    this.ways = shapes.ways(set);
    this.edges = new shapes.EdgeTable(set);
    this.curve = new Curve(set.entry.states, page.document.bound, (state) => this.join(state));

    const [earth, red] = [linear(clay), linear(cap)];
    this.meshFaces = new Mesh(new BufferGeometry(), material("FACES", set.entry.uncovered.most));
    this.stale.set(this.meshFaces, () => shapes.meshFaces(page, earth, red));
    this.stale.set(this.meshCreases, () => shapes.meshLines(page, false, earth));
    this.stale.set(this.meshWires, () => shapes.meshLines(page, true, earth));
    this.stale.set(this.filled, () => shapes.filledFaces(page, linear(page.document.filled?.colour ?? clay)));
    this.stale.set(this.ball, () => shapes.ball(linear(page.document.filled?.ball ?? clay)));
    this.ball.visible = false;
    Object.assign(this.filled.material, { transparent: true, depthWrite: false });
    this.filled.material.uniforms.opacity.value = FILLED;
    this.faces.material.uniforms.most.value = set.entry.protrusion_most;
    // Hulls hide each other, but not the mesh: their depth is drawn first, without a colour.
    this.depth.material.colorWrite = false;
    for (const [order, object] of [
      this.meshFaces, this.meshCreases, this.meshWires, this.depth, this.faces, this.lines, this.ball, this.filled,
    ].entries()) {
      object.renderOrder = order;
      object.frustumCulled = false;
      this.root.add(object);
    }
    // Hulls are closed and face outward: half of their triangles need no drawing.
    if (!this.isSimplified) this.faces.material.side = this.depth.material.side = FrontSide;
    for (const { material } of [this.meshFaces, this.depth, this.faces]) {
      material.polygonOffset = true;
      material.polygonOffsetFactor = material.polygonOffsetUnits = 1;
    }
    // Where both are at the same place, the hull is seen.
    this.meshFaces.material.polygonOffsetFactor = this.meshFaces.material.polygonOffsetUnits = 3;
    this.scene.add(this.root);
    host.append(this.build());
    this.update();
  }

  /** Removes it from the page, and frees what it drew with. */
  dispose() {
    this.viewport.parentElement?.remove();
    this.root.traverse((object) => {
      if (!(object instanceof Mesh || object instanceof LineSegments)) return;
      object.geometry.dispose();
      object.material.dispose();
    });
  }

  /** Whether a surface that stands for the mesh is shown, not hulls. */
  private get isSimplified(): boolean {
    return this.page.document.is_simplified;
  }

  /** What is shown now. */
  get state(): State {
    return this.set.entry.states[this.joins];
  }

  /** Triangles of the hulls that are shown. */
  get triangles(): number {
    return this.hulls.reduce((sum, hull) => sum + this.set.entry.hulls[hull].triangles, 0);
  }

  /** Shows the state after so many joins, or the nearest there is. */
  join(joins: number) {
    const most = this.set.entry.states.length - 1;
    this.joins = Math.max(0, Math.min(most, joins));
    this.select(null);
    this.update();
  }

  private build(): HTMLElement {
    const { entry } = this.set;
    const [fewest, most] = [entry.states.at(-1)!.hulls, entry.states[0].hulls];
    Object.assign(this.slider, { type: "range", min: fewest, max: most, step: 1 });
    this.slider.setAttribute("aria-label", `Number of hulls, ${entry.name}`);
    this.slider.addEventListener("input", () => this.join(most - Number(this.slider.value)));
    const sliderRow = element("div", "slider-row", this.slider, this.count);
    this.slider.hidden = entry.states.length < 2;

    const title = element("div", "panel-title", element("h2", "", entry.name));
    const facts = entry.facts.map(([name, value]) => `${name} ${value}`).join(" · ");
    title.append(element("span", "facts", facts));
    const list = element("dl", "figures");
    const at = entry.is_verified ? "at most" : "sampled";
    for (const [key, label, explanation] of this.isSimplified ? FIGURES_OF_SIMPLIFIED : [
      ["error", `error, ${at}`, "The larger of protrusion and uncovered distance, in diagonals of the mesh"],
      ["protrusion", "protrusion", "How far a hull is outside of the solid"],
      ["uncovered", "uncovered", "How far the mesh is outside of every hull"],
      ["iou", "volume IoU", "Volume of the intersection over that of the union"],
      ["vertices", "vertices", "Of all hulls"],
    ]) {
      const value = element("dd");
      this.figures.set(key, value);
      const row = element("div", `figure ${key}`, element("dt", "", label), value);
      row.title = explanation;
      list.append(row);
    }
    const card = element("div", "card", title, sliderRow, element("div", "numbers", list));
    card.classList.toggle("plain", entry.states.length < 2);
    if (entry.states.length > 1) card.append(this.curve.element);
    this.pick.hidden = true;
    return element("section", "panel", this.viewport, this.pick, card);
  }

  /** Leaves out the lines of faces while a slow machine moves. */
  set isHurried(isHurried: boolean) {
    this.areCreasesLeftOut = isHurried;
    this.showLines();
  }

  private showLines() {
    this.lines.visible = this.look.hulls && (this.look.wires || !this.areCreasesLeftOut);
  }

  /** Draws what the state and the look say. */
  update() {
    const { set, look } = this;
    const { entry } = set;
    this.hulls = alive(set, this.joins);
    const hulls = this.hulls.map((number) => ({
      number,
      colour: this.colours[number],
      way: this.ways[number],
    }));
    const both = look.mesh && look.hulls;
    const { errors, wires } = look;
    // Of a simplified mesh faces hide what lies behind them.
    const bare = wires && !this.isSimplified;
    this.stale.set(this.faces, () => (errors ? shapes.hullErrors(set, hulls) : shapes.hullFaces(set, hulls)));
    this.stale.set(this.lines, () => shapes.hullLines(set, hulls, this.edges, wires));
    this.faces.visible = look.hulls && !bare;
    this.depth.visible = this.faces.visible && both;
    this.showLines();
    this.faces.material.transparent = both;
    this.faces.material.depthWrite = !both;
    this.faces.material.uniforms.opacity.value = both ? OVER_MESH : 1;
    repurpose(this.lines.material, bare ? "WIRES" : "CREASES", errors);
    for (const { material } of [this.faces, this.meshFaces]) repurpose(material, "FACES", errors);
    for (const { material } of [this.meshCreases, this.meshWires]) repurpose(material, "CREASES", errors);

    this.meshFaces.visible = look.mesh && (look.hulls || !bare);
    this.meshCreases.visible = look.mesh && !look.hulls && !wires;
    this.meshWires.visible = look.mesh && !look.hulls && wires;
    this.filled.visible = look.filled && this.page.filled !== null;
    this.ball.visible &&= this.filled.visible;
    this.isMeshStale = true;
    this.root.rotation.x = look.up === "z" ? -Math.PI / 2 : 0;
    this.write(entry);
    this.changed();
  }

  /** Makes what is visible and not made yet. */
  prepare() {
    for (const [object, make] of this.stale) {
      if (!object.visible) continue;
      this.stale.delete(object);
      object.geometry.dispose();
      object.geometry = make();
      if (object === this.faces) this.depth.geometry = object.geometry;
    }
    if (!this.isMeshStale || !this.meshFaces.visible) return;
    this.isMeshStale = false;
    const share = this.meshFaces.geometry.getAttribute("share");
    share.array.set(uncoveredAfter(this.set, this.joins));
    share.needsUpdate = true;
    this.tintCaps();
  }

  private tintCaps() {
    const { document, mesh } = this.page;
    if (document.mesh.caps === 0) return;
    const tint = this.meshFaces.geometry.getAttribute("tint");
    const colour = linear(this.look.openings ? document.cap : document.clay);
    const first = mesh.divisions.length - document.mesh.caps;
    let sample = 0;
    mesh.divisions.forEach((parts, triangle) => {
      const end = sample + ((parts + 1) * (parts + 2)) / 2;
      for (; sample < end; sample++) if (triangle >= first) tint.setXYZ(sample, colour[0], colour[1], colour[2]);
    });
    tint.needsUpdate = true;
  }

  private write(entry: HullSet["entry"]) {
    const { state } = this;
    this.slider.value = String(state.hulls);
    const { source_triangles } = this.page.document.mesh;
    const triangles = this.look.mesh ? source_triangles : entry.hulls[0]?.triangles;
    this.count.textContent = this.isSimplified ? words(triangles, "triangle") : words(state.hulls, "hull");
    const sign = entry.is_verified ? "≤ " : "";
    const over = state.error > this.page.document.bound * (1 + 1e-9);
    this.figure("error", sign + percent(state.error), over);
    this.figure("protrusion", sign + percent(state.protrusion));
    this.figure("uncovered", sign + percent(state.uncovered));
    if (!this.isSimplified) this.figure("iou", state.iou === null ? "–" : percent(state.iou));
    this.figure("vertices", state.vertices.toLocaleString("en"));
    this.curve.mark(this.joins);
  }

  private figure(key: string, text: string, over = false) {
    const value = this.figures.get(key)!;
    value.textContent = text;
    value.classList.toggle("over", over);
  }

  /** Says what a hull is, and makes it stand out. */
  select(hull: number | null) {
    this.picked = hull;
    for (const { material } of [this.faces, this.lines]) material.uniforms.picked.value = hull ?? -1;
    this.pick.hidden = hull === null;
    if (hull !== null) this.pick.replaceChildren(...this.describe(hull));
    this.changed();
  }

  private describe(hull: number): HTMLElement[] {
    const { entry } = this.set;
    const { names } = this.page.document;
    const of = entry.hulls[hull];
    const swatch = element("i", "swatch");
    swatch.style.background = new Color().fromArray(this.colours[hull]).getStyle();
    const title = hull < entry.leaves ? `Hull ${hull + 1}` : `Joint hull of ${this.leavesOf(hull)}`;
    const total = this.hulls.reduce((sum, index) => sum + entry.hulls[index].volume, 0);
    const rows = [
      ["vertices", `${of.vertices}`],
      ["volume", `${number(of.volume)} (${percent(of.volume / total)} of all)`],
      ["protrusion", (of.is_verified ? "≤ " : "sampled ") + percent(of.protrusion)],
    ];
    if (of.objects.length > 0 && names.length > 0) {
      const most = 3;
      const some = of.objects.slice(0, most).map((object) => names[object] || "unnamed");
      if (of.objects.length > most) some.push(`${of.objects.length - most} more`);
      rows.push(["part of", some.join(", ")]);
    }
    const list = element("span", "pick-rows");
    for (const [name, value] of rows) {
      list.append(element("span", "pick-name", name), element("span", "pick-value", value));
    }
    return [element("strong", "", swatch, title), list];
  }

  private leavesOf(hull: number): number {
    const { leaves, joins } = this.set.entry;
    if (hull < leaves) return 1;
    const [a, b] = joins[hull - leaves];
    return this.leavesOf(a) + this.leavesOf(b);
  }

  /** Selects the hull after or before the one that is selected. */
  step(by: number) {
    if (this.isSimplified) return;
    const now = this.picked === null ? (by > 0 ? -1 : 0) : this.hulls.indexOf(this.picked);
    const count = this.hulls.length;
    this.select(this.hulls[(now + by + count) % count]);
  }

  /** Moves a ball of the probe's radius along a ray to where the mesh stops it, while what is filled is shown. */
  roll(ray: Ray | null) {
    const { filled } = this.page.document;
    const wasVisible = this.ball.visible;
    const at = ray && filled && this.filled.visible ? rest(this.own(ray), filled.radius, this.page.mesh) : null;
    this.ball.visible = at !== null;
    if (at && filled) {
      this.ball.position.copy(at);
      this.ball.scale.setScalar(filled.radius);
    }
    if (at || wasVisible) this.changed();
  }

  /** A ray as the mesh sees it, whichever axis is up. */
  private own(ray: Ray): Ray {
    this.root.updateMatrixWorld();
    return ray.clone().applyMatrix4(this.root.matrixWorld.clone().invert());
  }

  /** The hull that a ray hits first, if hulls are shown. */
  hit(ray: Ray): number | null {
    if (!this.look.hulls || this.isSimplified) return null;
    const own = this.own(ray);
    const { positions, triangles } = this.set.surface;
    const corners = [new Vector3(), new Vector3(), new Vector3()];
    const [at, shift, moved] = [new Vector3(), new Vector3(), new Ray()];
    let [nearest, found]: [number, number | null] = [Infinity, null];
    for (const hull of this.hulls) {
      const { vertex, triangle } = this.set.places[hull];
      shift.fromArray(this.ways[hull]).multiplyScalar(shared.explosion.value);
      moved.copy(own);
      moved.origin.sub(shift);
      const end = triangle + this.set.entry.hulls[hull].triangles;
      for (let t = triangle; t < end; t++) {
        corners.forEach((corner, k) => corner.fromArray(positions, 3 * (vertex + triangles[3 * t + k])));
        if (!moved.intersectTriangle(corners[0], corners[1], corners[2], false, at)) continue;
        const distance = at.distanceToSquared(moved.origin);
        if (distance < nearest) [nearest, found] = [distance, hull];
      }
    }
    return found;
  }
}
