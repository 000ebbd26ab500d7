// The hulls in Rapier's own wasm build: they fall on a floor, and balls are thrown at them.

import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, GridHelper, Group, Mesh, MeshStandardMaterial,
  PerspectiveCamera, PlaneGeometry, Raycaster, Scene, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
import { toRapier } from "../../../crates/web/npm/src/rapier";
import type { Hull, Mass } from "../../../crates/web/npm/src/types";
import { inflate } from "../../../crates/web/npm/src/inflate";
import { find } from "../controls";
import { text } from "../data";
import { words } from "../dom";

export interface Body {
  hulls: Hull[];
  mass: Mass;
  diagonal: number;
  isZUp: boolean;
  colours: [number, number, number][];
}

/** The diagonal in Rapier's world, in metres: contacts of small hulls are wrong. */
const SIZE = 4;
const BALL = 0.22;
const SPEED = 14;
const MOST_BALLS = 40;
const STEP = 1 / 60;

/** Where the camera looks, and how far it is; radians for each pixel that is dragged, and for each arrow key. */
const MIDDLE = new Vector3(0, 0.8, 0);
const DISTANCE = 10.4;
const TURN = 0.006;
const KEY_TURN = 0.12;
/** What moves by less is a click. */
const DRAG = 5;
/** How much the shadow of the sun reaches around the middle. */
const SHADOW = 9;

/** Around, and up. */
const KEYS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

let rapier: Promise<any> | undefined;

/** Rapier's script has its module from here. */
async function loadRapier() {
  const [script, module] = await Promise.all(["rapier", "rapier-module"].map((id) => inflate(text(id), "gzip")));
  Object.assign(globalThis, { rapierModule: module });
  const url = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  const RAPIER = await import(/* @vite-ignore */ url);
  await RAPIER.init();
  return RAPIER;
}

export async function openPhysics(body: Body) {
  const dialog = find<HTMLDialogElement>("physics");
  dialog.showModal();
  find("physics-text").textContent = "loading Rapier…";
  const RAPIER = await (rapier ??= loadRapier());
  if (!dialog.open) return;
  const world = new Drop(RAPIER, body);
  dialog.addEventListener("close", () => world.end(), { once: true });
}

class Drop {
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(40, 1, 0.1, 100);
  private readonly renderer: WebGLRenderer;
  private readonly canvas = find<HTMLCanvasElement>("physics-canvas");
  private readonly world: any;
  private readonly moved: { body: any; object: Group | Mesh }[] = [];
  private readonly thing: any;
  private readonly balls: { body: any; object: Mesh }[] = [];
  private readonly ballShape = new SphereGeometry(BALL, 24, 16);
  private readonly listening = new AbortController();
  private around = 0.6;
  private up = 0.36;
  private frame = 0;
  private time = 0;
  private last = performance.now();

  constructor(
    private readonly RAPIER: any,
    private readonly body: Body,
  ) {
    const fresh = this.canvas.cloneNode() as HTMLCanvasElement;
    this.canvas.replaceWith(fresh);
    this.canvas = fresh;
    this.renderer = new WebGLRenderer({ canvas: fresh, antialias: true });
    const style = getComputedStyle(document.documentElement);
    this.scene.background = new Color(style.getPropertyValue("--paper").trim());
    this.turn(0, 0);
    this.renderer.shadowMap.enabled = true;
    const sun = new DirectionalLight(0xffffff, 2.4);
    sun.position.set(4, 8, 3);
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    sun.shadow.normalBias = 0.03;
    Object.assign(sun.shadow.camera, { left: -SHADOW, right: SHADOW, top: SHADOW, bottom: -SHADOW, far: 40 });
    this.scene.add(sun, new AmbientLight(0xffffff, 1.1));
    const floor = new Mesh(new PlaneGeometry(60, 60), new MeshStandardMaterial({ color: style.getPropertyValue("--line").trim() }));
    floor.rotation.x = -Math.PI / 2;
    floor.receiveShadow = true;
    const lines = style.getPropertyValue("--quiet").trim();
    const grid = new GridHelper(60, 60, lines, lines);
    grid.position.y = 0.002;
    Object.assign(grid.material, { transparent: true, opacity: 0.25 });
    this.scene.add(floor, grid);

    this.world = new RAPIER.World({ x: 0, y: -9.81, z: 0 });
    this.world.createCollider(RAPIER.ColliderDesc.cuboid(30, 1, 30).setTranslation(0, -1, 0).setFriction(0.8));
    this.thing = this.world.createRigidBody(RAPIER.RigidBodyDesc.dynamic());
    const scale = SIZE / body.diagonal;
    for (const collider of toRapier<any>(RAPIER, body, { scale, density: 200 })) this.world.createCollider(collider, this.thing);
    this.moved.push({ body: this.thing, object: this.draw(scale) });
    this.again();
    this.listen();
    const frame = (now: number) => {
      this.frame = requestAnimationFrame(frame);
      this.advance(now);
    };
    this.frame = requestAnimationFrame(frame);
    this.canvas.focus();
  }

  private draw(scale: number): Group {
    const group = new Group();
    this.body.hulls.forEach(({ points, indices }, hull) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(points.map((x) => x * scale), 3));
      geometry.setIndex(new BufferAttribute(indices, 1));
      const [r, g, b] = this.body.colours[hull % this.body.colours.length];
      const color = new Color().setRGB(r / 255, g / 255, b / 255, "srgb");
      const mesh = new Mesh(geometry, new MeshStandardMaterial({ color, flatShading: true, roughness: 0.7 }));
      mesh.castShadow = mesh.receiveShadow = true;
      group.add(mesh);
    });
    this.scene.add(group);
    return group;
  }

  /** Lifts the body, and takes the balls away. */
  private again() {
    for (const { body, object } of this.balls.splice(0)) {
      this.world.removeRigidBody(body);
      this.scene.remove(object);
    }
    this.moved.length = 1;
    const upright = this.body.isZUp ? -Math.PI / 2 : 0;
    // Tilted, so that it tumbles.
    const [s, c] = [Math.sin((upright + 0.5) / 2), Math.cos((upright + 0.5) / 2)];
    this.thing.setRotation({ x: s, y: 0, z: 0, w: c }, true);
    const centre = this.thing.worldCom();
    const at = this.thing.translation();
    this.thing.setTranslation({ x: at.x - centre.x, y: at.y - centre.y + SIZE, z: at.z - centre.z }, true);
    this.thing.setLinvel({ x: 0, y: 0, z: 0 }, true);
    this.thing.setAngvel({ x: 0, y: 0.8, z: 0 }, true);
  }

  private throwAt(x: number, y: number) {
    const { RAPIER } = this;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2(x, y), this.camera);
    const { origin, direction } = caster.ray;
    const from = origin.clone().addScaledVector(direction, 2);
    const body = this.world.createRigidBody(
      RAPIER.RigidBodyDesc.dynamic().setTranslation(from.x, from.y, from.z).setLinvel(...direction.multiplyScalar(SPEED).toArray()).setCcdEnabled(true),
    );
    this.world.createCollider(RAPIER.ColliderDesc.ball(BALL).setDensity(800).setRestitution(0.4), body);
    const object = new Mesh(this.ballShape, new MeshStandardMaterial({ color: 0xf2a33a, roughness: 0.5 }));
    object.castShadow = true;
    this.scene.add(object);
    const ball = { body, object };
    this.balls.push(ball);
    this.moved.push(ball);
    if (this.balls.length <= MOST_BALLS) return;
    const oldest = this.balls.shift()!;
    this.moved.splice(this.moved.indexOf(oldest), 1);
    this.world.removeRigidBody(oldest.body);
    this.scene.remove(oldest.object);
  }

  private atBody() {
    const { x, y, z } = this.thing.worldCom();
    const place = new Vector3(x, y, z).project(this.camera);
    this.throwAt(place.x, place.y);
  }

  /** Turns the view around the middle, in radians. */
  private turn(around: number, up: number) {
    this.around += around;
    this.up = Math.min(1.4, Math.max(0.06, this.up + up));
    const flat = DISTANCE * Math.cos(this.up);
    const from = new Vector3(flat * Math.sin(this.around), DISTANCE * Math.sin(this.up), flat * Math.cos(this.around));
    this.camera.position.copy(from.add(MIDDLE));
    this.camera.lookAt(MIDDLE);
  }

  private listen() {
    const { signal } = this.listening;
    const { canvas } = this;
    let dragged: { x: number; y: number; far: number } | undefined;
    canvas.addEventListener("pointerdown", ({ offsetX: x, offsetY: y, pointerId }) => {
      canvas.setPointerCapture(pointerId);
      dragged = { x, y, far: 0 };
    }, { signal });
    canvas.addEventListener("pointermove", ({ offsetX: x, offsetY: y }) => {
      if (!dragged) return;
      const [dx, dy] = [x - dragged.x, y - dragged.y];
      dragged = { x, y, far: dragged.far + Math.hypot(dx, dy) };
      if (dragged.far > DRAG) this.turn(-TURN * dx, TURN * dy);
    }, { signal });
    canvas.addEventListener("pointerup", ({ offsetX: x, offsetY: y }) => {
      if (dragged && dragged.far <= DRAG) this.throwAt((2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight);
      dragged = undefined;
    }, { signal });
    find("again").addEventListener("click", () => this.again(), { signal });
    find("throw").addEventListener("click", () => this.atBody(), { signal });
    find("leave").addEventListener("click", () => find<HTMLDialogElement>("physics").close(), { signal });
    find("physics").addEventListener("keydown", (event) => {
      if (event.target instanceof HTMLButtonElement && event.key === " ") return;
      if (event.key === " ") this.atBody();
      else if (event.key.toLowerCase() === "a") this.again();
      else if (event.key in KEYS) this.turn(KEYS[event.key][0] * KEY_TURN, KEYS[event.key][1] * KEY_TURN);
      else return;
      event.preventDefault();
    }, { signal });
  }

  private advance(now: number) {
    // Slow machines see slow motion, not jumps.
    this.time = Math.min(this.time + (now - this.last) / 1000, 3 * STEP);
    this.last = now;
    let took = 0;
    for (; this.time >= STEP; this.time -= STEP) {
      const start = performance.now();
      this.world.step();
      took = performance.now() - start;
    }
    for (const { body, object } of this.moved) {
      const [at, turn] = [body.translation(), body.rotation()];
      object.position.set(at.x, at.y, at.z);
      object.quaternion.set(turn.x, turn.y, turn.z, turn.w);
    }
    const { clientWidth, clientHeight } = this.canvas;
    this.camera.aspect = clientWidth / Math.max(1, clientHeight);
    this.camera.updateProjectionMatrix();
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.renderer.render(this.scene, this.camera);
    if (took > 0) {
      const balls = this.balls.length > 0 ? `, ${words(this.balls.length, "ball")}` : "";
      find("physics-text").textContent = `one body of ${words(this.body.hulls.length, "hull")}${balls}, a step takes ${took.toFixed(1)} ms`;
    }
    Object.assign(find("physics").dataset, { height: this.thing.worldCom().y.toFixed(3), balls: String(this.balls.length) });
  }

  end() {
    cancelAnimationFrame(this.frame);
    this.listening.abort();
    this.scene.traverse((object) => {
      if (!(object instanceof Mesh)) return;
      object.geometry.dispose();
      (object.material as MeshStandardMaterial).dispose();
    });
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.world.free();
  }
}
