// The hulls in Rapier's own wasm build: they fall on a floor, and balls are thrown at them.

import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, Group, Mesh, MeshStandardMaterial, PerspectiveCamera,
  PlaneGeometry, Raycaster, Scene, SphereGeometry, Vector2, Vector3, WebGLRenderer,
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
    this.camera.position.set(5.5, 4.5, 8);
    this.camera.lookAt(0, 0.8, 0);
    const sun = new DirectionalLight(0xffffff, 2.4);
    sun.position.set(4, 8, 3);
    this.scene.add(sun, new AmbientLight(0xffffff, 1.1));
    const floor = new Mesh(new PlaneGeometry(60, 60), new MeshStandardMaterial({ color: style.getPropertyValue("--line").trim() }));
    floor.rotation.x = -Math.PI / 2;
    this.scene.add(floor);

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
      group.add(new Mesh(geometry, new MeshStandardMaterial({ color, flatShading: true, roughness: 0.7 })));
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

  private listen() {
    const { signal } = this.listening;
    this.canvas.addEventListener("pointerdown", ({ offsetX, offsetY }) =>
      this.throwAt((2 * offsetX) / this.canvas.clientWidth - 1, 1 - (2 * offsetY) / this.canvas.clientHeight), { signal });
    find("again").addEventListener("click", () => this.again(), { signal });
    find("throw").addEventListener("click", () => this.atBody(), { signal });
    find("leave").addEventListener("click", () => find<HTMLDialogElement>("physics").close(), { signal });
    find("physics").addEventListener("keydown", (event) => {
      if (event.target instanceof HTMLButtonElement && event.key === " ") return;
      if (event.key === " ") this.atBody();
      else if (event.key.toLowerCase() === "a") this.again();
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
