// One canvas for all panels, one camera for all: what is turned in one is turned in each.

import { PerspectiveCamera, Ray, Raycaster, Vector2, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Look, Panel } from "./panel";
import { shared } from "./shaders";

/** The angle from one side of the bounding sphere to the other, and where the viewer stands, in degrees:
 * as in the program's own pictures. */
const FIELD_OF_VIEW = 24;
const AZIMUTH = 35;
const ELEVATION = 22;

/** Half the diagonal, which is 1, with a little room: no point comes nearer to the camera. */
const RADIUS = 0.53;

/** The share of a panel that the mesh fills, however it is turned about the vertical. */
const FILLED = 0.86;

/** Turns that are tried for that, and points at most. */
const TURNS = 12;
const POINTS = 3000;

/** A pointer that moves less than this between down and up, in pixels, picks. */
const CLICK = 4;

/** After some frames that take longer than this, in milliseconds, 30 a second, all that moves is drawn without
 * lines and with fewer pixels. After a rest of so long all is drawn. */
const SLOW = 34;
const SLOW_FRAMES = 2;
const REST = 150;

/** The share of pixels along each side that is drawn then: a processor draws a quarter of them three times as fast. */
const COARSE = 0.5;

/** Without a graphics card, smooth edges double the time of a frame: pages of so many triangles do without. */
const MANY_TRIANGLES = 10_000;

/** The buffer is kept for who saves the picture. */
const ATTRIBUTES = { alpha: true, depth: true, stencil: false, preserveDrawingBuffer: true };

/** Whether the processor draws. */
function isSoftware(gl: WebGL2RenderingContext): boolean {
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  const renderer = names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
  return /swiftshader|llvmpipe|software/i.test(renderer);
}

/** Opens a canvas to draw on, with smooth edges where they are cheap. Whether they are, its context says, and it can't be
 * asked for another one: that takes another canvas. */
function openCanvas(canvas: HTMLCanvasElement, triangles: number) {
  const isLarge = triangles >= MANY_TRIANGLES;
  const context = canvas.getContext("webgl2", { ...ATTRIBUTES, antialias: !isLarge });
  if (!context) throw new Error("This browser can't draw in 3D: it has no WebGL 2, or it is switched off.");
  const isHeavy = isLarge && isSoftware(context);
  if (!isLarge || isHeavy) return { canvas, context, isHeavy };
  context.getExtension("WEBGL_lose_context")?.loseContext();
  const other = canvas.cloneNode() as HTMLCanvasElement;
  canvas.replaceWith(other);
  const smooth = other.getContext("webgl2", { ...ATTRIBUTES, antialias: true });
  return { canvas: other, context: smooth ?? undefined, isHeavy };
}

export class Stage {
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.05, 20);
  readonly controls: OrbitControls;
  private readonly renderer: WebGLRenderer;
  private readonly points: number[][] = [];
  private zooms = new Map<string, number>();
  private isDirty = true;
  /** When the browser last asked for a frame, when one was last drawn, and how many were slow since the last rest. */
  private lastTick = 0;
  private lastFrame = 0;
  private slowFrames = 0;
  /** How many of these are borne. */
  private patience = SLOW_FRAMES;
  private wasDrawn = false;
  private isHurried = false;
  /** Frames that were drawn, and what the last one took in calls and triangles. */
  frames = 0;
  calls = 0;
  drawnTriangles = 0;

  readonly canvas: HTMLCanvasElement;

  constructor(
    place: HTMLCanvasElement,
    private readonly panels: Panel[],
    positions: Float32Array,
    triangles: number,
    private readonly look: Look,
    isCalm: boolean,
  ) {
    this.measure(positions);
    const { canvas, context, isHeavy } = openCanvas(place, triangles);
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, context });
    this.renderer.setScissorTest(true);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !isCalm;
    this.controls.addEventListener("change", () => this.draw());
    this.home();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.pickOnClick();
    // A ball does not follow a pointer that turns the mesh.
    canvas.addEventListener("pointermove", ({ clientX, clientY, buttons }) => {
      if (!this.look.filled) return;
      for (const panel of this.panels) panel.roll(buttons === 0 ? this.rayAt(panel, clientX, clientY) : null);
    });
    canvas.addEventListener("pointerleave", () => this.panels.forEach((panel) => panel.roll(null)));
    // The first picture is there sooner without lines.
    if (isHeavy) this.slowFrames = SLOW_FRAMES + 1;
    this.lastTick = this.lastFrame = performance.now();
    this.hurry();
    const frame = () => {
      requestAnimationFrame(frame);
      this.controls.update();
      this.hurry();
      if (this.isDirty) this.render();
    };
    requestAnimationFrame(frame);
  }

  /** The panels hold another mesh, of these positions. */
  replace(positions: Float32Array) {
    this.measure(positions);
    this.draw();
  }

  private measure(positions: Float32Array) {
    this.zooms.clear();
    this.points.length = 0;
    const step = 3 * Math.max(1, Math.ceil(positions.length / 3 / POINTS));
    for (let i = 0; i < positions.length; i += step) {
      this.points.push([positions[i], positions[i + 1], positions[i + 2]]);
    }
  }

  /** Draws with the next frame. */
  draw() {
    this.isDirty = true;
  }

  /** Decides between all that there is and speed: by how long frames take that follow each other. */
  private hurry() {
    const now = performance.now();
    // A frame that follows a drawn one comes as soon as the machine can.
    if (this.wasDrawn && now - this.lastTick > SLOW) this.slowFrames++;
    this.wasDrawn = this.isDirty;
    this.lastTick = now;
    if (this.isDirty) this.lastFrame = now;
    else if (now - this.lastFrame > REST) {
      // Where it was slow before, it is known sooner; what a key turns once stays sharp.
      if (this.isHurried) this.patience = 1;
      this.slowFrames = 0;
    }
    const isHurried = this.slowFrames > this.patience;
    if (isHurried === this.isHurried) return;
    this.isHurried = isHurried;
    for (const panel of this.panels) panel.isHurried = isHurried;
    this.resize();
  }

  /** Looks from three quarters above again. */
  home() {
    const [azimuth, elevation] = [AZIMUTH, ELEVATION].map((degrees) => (degrees * Math.PI) / 180);
    const away = RADIUS / Math.sin((FIELD_OF_VIEW * Math.PI) / 360);
    this.controls.target.set(0, 0, 0);
    this.camera.position
      .set(
        Math.sin(azimuth) * Math.cos(elevation),
        Math.sin(elevation),
        Math.cos(azimuth) * Math.cos(elevation),
      )
      .multiplyScalar(away);
    this.controls.update();
    this.draw();
  }

  /** Turns the camera about what it looks at, by angles in radians. */
  turn(azimuth: number, elevation: number) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const distance = offset.length();
    const up = Math.asin(offset.y / distance) + elevation;
    const around = Math.atan2(offset.x, offset.z) + azimuth;
    const limited = Math.max(-1.55, Math.min(1.55, up));
    offset.set(
      Math.sin(around) * Math.cos(limited),
      Math.sin(limited),
      Math.cos(around) * Math.cos(limited),
    );
    this.camera.position.copy(this.controls.target).addScaledVector(offset, distance);
    this.controls.update();
    this.draw();
  }

  /** Comes nearer by a factor. */
  zoom(factor: number) {
    const { position } = this.camera;
    position.sub(this.controls.target).divideScalar(factor).add(this.controls.target);
    this.controls.update();
    this.draw();
  }

  private resize() {
    const { clientWidth, clientHeight } = this.canvas;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2) * (this.isHurried ? COARSE : 1));
    this.renderer.setSize(clientWidth, clientHeight, false);
    // At once: a canvas that was resized is empty.
    this.render();
  }

  private render() {
    this.isDirty = false;
    this.frames++;
    const host = this.canvas.getBoundingClientRect();
    this.calls = this.drawnTriangles = 0;
    const { render } = this.renderer.info;
    for (const panel of this.panels) {
      const box = panel.viewport.getBoundingClientRect();
      if (box.width < 1 || box.height < 1) continue;
      panel.prepare();
      const [left, bottom] = [box.left - host.left, host.bottom - box.bottom];
      this.renderer.setViewport(left, bottom, box.width, box.height);
      this.renderer.setScissor(left, bottom, box.width, box.height);
      this.fit(box.width / box.height);
      this.renderer.render(panel.scene, this.camera);
      this.calls += render.calls;
      this.drawnTriangles += render.triangles;
    }
  }

  /** The mesh fills the panel, hulls that are moved apart too. */
  private fit(aspect: number) {
    this.camera.aspect = aspect;
    this.camera.zoom = this.zoomThatFits(aspect) / (1 + 0.8 * shared.explosion.value);
    this.camera.updateProjectionMatrix();
  }

  /** By the points as they are seen from the start, turned about the vertical. */
  private zoomThatFits(aspect: number): number {
    const key = `${aspect.toFixed(2)} ${this.look.up}`;
    const known = this.zooms.get(key);
    if (known !== undefined) return known;
    const [sine, cosine] = [Math.sin((ELEVATION * Math.PI) / 180), Math.cos((ELEVATION * Math.PI) / 180)];
    const tangent = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const away = RADIUS / Math.sin((FIELD_OF_VIEW * Math.PI) / 360);
    let most = 0.05;
    for (let turn = 0; turn < TURNS; turn++) {
      const [s, c] = [Math.sin((turn * 2 * Math.PI) / TURNS), Math.cos((turn * 2 * Math.PI) / TURNS)];
      for (const [x, first, second] of this.points) {
        const [y, z] = this.look.up === "z" ? [second, -first] : [first, second];
        const [right, front] = [x * c - z * s, x * s + z * c];
        const [up, depth] = [y * cosine - front * sine, away - y * sine - front * cosine];
        most = Math.max(most, Math.abs(up) / depth, Math.abs(right) / depth / aspect);
      }
    }
    const zoom = (FILLED * tangent) / most;
    this.zooms.set(key, zoom);
    return zoom;
  }

  private pickOnClick() {
    let start = { x: 0, y: 0 };
    this.canvas.addEventListener("pointerdown", (event) => (start = { x: event.clientX, y: event.clientY }));
    this.canvas.addEventListener("pointerup", (event) => {
      if (Math.hypot(event.clientX - start.x, event.clientY - start.y) > CLICK) return;
      this.pick(event.clientX, event.clientY);
    });
  }

  private pick(x: number, y: number) {
    for (const panel of this.panels) {
      const ray = this.rayAt(panel, x, y);
      if (!ray) continue;
      const hull = panel.hit(ray);
      panel.select(hull === panel.picked ? null : hull);
    }
  }

  /** From the camera through a place of the window; `null` outside the panel. */
  private rayAt(panel: Panel, x: number, y: number): Ray | null {
    const box = panel.viewport.getBoundingClientRect();
    const place = new Vector2((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height);
    if (Math.abs(place.x) > 1 || Math.abs(place.y) > 1) return null;
    this.fit(box.width / box.height);
    const caster = new Raycaster();
    caster.setFromCamera(place, this.camera);
    return caster.ray;
  }
}
