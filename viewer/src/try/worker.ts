// The page's worker: reads a mesh, decomposes it, and keeps the result, of which it hands out any state.

import { buffersIn, calls, parse, separate, start, using, withMesh } from "../../../crates/web/npm/src/calls";
import type { MeshArrays } from "../../../crates/web/npm/src/arguments";
import { plain } from "../../../crates/web/npm/src/error";
import * as glue from "#glue";
import type { Requests } from "./jobs";

let shown: glue.Shown | undefined;

const result = (): glue.Shown => {
  if (!shown) throw new Error("there is nothing decomposed yet");
  return shown;
};

const answers: Requests = {
  read: (files) => calls().readMesh(files),
  show(mesh: MeshArrays, title, parameters, compares) {
    const onProgress = (stage: string, fraction: number) => self.postMessage({ progress: { stage, fraction } });
    shown = withMesh(mesh, (mesh) => new glue.Shown(mesh, title, parameters, compares, onProgress));
    const { document, geometry, remarks, mass } = shown;
    return { document, geometry, remarks, mass: parse(mass) };
  },
  hulls: (most) => using(result().hulls(most), separate),
  file: (name, most) => result().file(name, most),
  glb: (most) => result().glb(most),
};

self.onmessage = ({ data: { module, call, args } }) => {
  try {
    if (module) start(module);
    const value = (answers[call as keyof Requests] as (...args: unknown[]) => unknown)(...args);
    self.postMessage({ value }, { transfer: buffersIn(value) });
  } catch (error) {
    self.postMessage({ error: plain(error) });
  }
};
