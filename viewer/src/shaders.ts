// How surfaces and lines look: the soft light of the program's own pictures, and errors as colours.

import { Color, DoubleSide, ShaderMaterial, Vector3 } from "three";

/** What all materials of all panels share; changing a value changes them all. */
export const shared = {
  /** How far hulls are moved apart. */
  explosion: { value: 0 },
  /** The bound, in diagonals. */
  bound: { value: 0.02 },
  /** What lies behind everything. */
  paper: { value: new Color() },
  /** How much darker wires are than their hull: on light paper light colours would be lost. */
  wires: { value: 0 },
  /** What lines are drawn with. */
  ink: { value: new Color() },
};

/** From no error over the bound, in the middle, to four times the bound: apart for colour-blind eyes. */
export const RAMP = ["#3f6fb5", "#93bddb", "#fbe7a2", "#f08a4f", "#a3082b"];

/** Errors beyond this many times the bound have the last colour. */
export const RAMP_END = 4;

const linear = (hex: string) => {
  const { r, g, b } = new Color(hex);
  return `vec3(${[r, g, b].map((x) => x.toFixed(5)).join(", ")})`;
};

/** Where light comes from, as the camera sees it. */
const LIGHT = new Vector3(-0.5, 0.85, 0.65).normalize().toArray();

const VERTEX = /* glsl */ `
  uniform float explosion;
  uniform float most;
  attribute vec3 away;
  attribute vec3 tint;
  attribute float hull;
  attribute float share;
  varying vec3 vTint;
  varying vec3 vSeen;
  varying float vHull;
  varying float vError;
  void main() {
    vec4 seen = modelViewMatrix * vec4(position + explosion * away, 1.0);
    vTint = tint;
    vSeen = seen.xyz;
    vHull = hull;
    vError = most * share * share;
    gl_Position = projectionMatrix * seen;
    // Hulls that share a face do not flicker: one of them is before the other.
    gl_Position.z += 2e-6 * mod(hull, 29.0) * gl_Position.w;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform float bound;
  uniform float opacity;
  uniform float picked;
  uniform float wires;
  uniform vec3 paper;
  uniform vec3 ink;
  varying vec3 vTint;
  varying vec3 vSeen;
  varying float vHull;
  varying float vError;

  vec3 ramp(float x) {
    vec3 a = ${linear(RAMP[0])}, b = ${linear(RAMP[1])}, c = ${linear(RAMP[2])};
    vec3 d = ${linear(RAMP[3])}, e = ${linear(RAMP[4])};
    if (x < 1.0) return mix(a, b, x);
    if (x < 2.0) return mix(b, c, x - 1.0);
    if (x < 3.0) return mix(c, d, x - 2.0);
    return mix(d, e, min(x - 3.0, 1.0));
  }

  // From linear light to sRGB, within a third of a 255th where it is not all but black. A processor takes roots, but no powers, in one instruction.
  vec3 encoded(vec3 light) {
    vec3 second = sqrt(light), fourth = sqrt(second), eighth = sqrt(fourth);
    return 0.662002687 * second + 0.684122060 * fourth - 0.323583601 * eighth - 0.0225411470 * light;
  }

  void main() {
    vec3 colour = vTint;
    #if defined(WIRES)
      colour = mix(colour, ink, wires);
    #elif defined(CREASES)
      #ifdef ERRORS
        colour = mix(colour, ink, 0.9);
      #else
        colour = mix(colour, ink, 0.72);
      #endif
    #else
      vec3 normal = normalize(cross(dFdx(vSeen), dFdy(vSeen)));
      float wrapped = 0.5 + 0.5 * dot(normal, vec3(${LIGHT.map((x) => x.toFixed(5)).join(", ")}));
      float light = 0.42 + 0.78 * wrapped * wrapped;
      #ifdef ERRORS
        float times = vError / bound;
        colour = ramp(times < 1.0 ? 2.0 * times : 2.0 + log2(times));
        // Less shade: the colour is a number.
        light = mix(0.92, light, 0.45);
      #endif
      colour *= light;
    #endif
    if (picked > -0.5 && abs(picked - vHull) > 0.5) colour = mix(colour, paper, 0.78);
    gl_FragColor = vec4(encoded(colour), opacity);
  }
`;

/** What a material draws. A program of its own for each: a processor works through branches that are not taken, too. */
export type Purpose = "FACES" | "CREASES" | "WIRES";

/** A material for surfaces or lines. `most` is the greatest error, `picked` the hull that stands out. */
export function material(purpose: Purpose, most: number): ShaderMaterial {
  return new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: DoubleSide,
    defines: { [purpose]: "" },
    uniforms: {
      ...shared,
      most: { value: most },
      opacity: { value: 1 },
      picked: { value: -1 },
    },
  });
}

/** Says what a material draws from now on. */
export function repurpose(material: ShaderMaterial, purpose: Purpose, errors: boolean) {
  const defines: Record<string, string> = errors ? { [purpose]: "", ERRORS: "" } : { [purpose]: "" };
  const names = Object.keys(material.defines);
  if (names.length === Object.keys(defines).length && names.every((name) => name in defines)) return;
  material.defines = defines;
  material.needsUpdate = true;
}
