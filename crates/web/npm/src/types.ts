// What goes in and what comes out.

/** A fraction of the bounding box's diagonal (`"2%"`), or a length in the mesh's units (`"0.02m"`). */
export type Length = `${number}%` | `${number}m` | (string & {});

/** Arrays in memory of their own. From TypeScript 5.7 on they say so, as `Blob` wants it, before they can't. */
export type Bytes = ReturnType<Uint8ArrayConstructor["of"]>;
export type Uint32s = ReturnType<Uint32ArrayConstructor["of"]>;
export type Float32s = ReturnType<Float32ArrayConstructor["of"]>;
export type Float64s = ReturnType<Float64ArrayConstructor["of"]>;

/** A mesh: three numbers a vertex, three indices a triangle. It is copied and stays yours. */
export interface Mesh {
  positions: Float32Array | Float64Array | ArrayLike<number>;
  /** Left out, every three vertices are a triangle. */
  indices?: Uint32Array | Uint16Array | ArrayLike<number> | undefined;
  /** A byte a triangle, 1 where both its sides are drawn. With it openings are judged better. */
  doubleSided?: Uint8Array | undefined;
}

/** The library's parameters, in its names. What is left out has its default. */
export interface Parameters {
  /** The bound on protrusion and uncovered distance. Default `"2%"`. */
  maxError?: Length | undefined;
  /** How long the search takes. Default `"balanced"`. */
  preset?: "fast" | "balanced" | "fine" | undefined;
  /** The largest number of hulls. Default `"none"`. Where the bound needs more, the error exceeds it. */
  maxHulls?: number | "none" | undefined;
  /** The largest number of vertices of a hull, at least 8. Default 64. */
  maxVertices?: number | "none" | undefined;
  /** Half the thickness of the thinnest thing that moves: hulls may fill what it can't enter. Default `"none"`. */
  probeRadius?: Length | "none" | undefined;
  /** Points of closed rooms that stay open; only with `probeRadius`. */
  probeFrom?: readonly (readonly [number, number, number])[] | undefined;
  /** Whether cavities that nothing can enter stay empty. Default false. */
  keepCavities?: boolean | undefined;
  /** What becomes of the sides that a modeller leaves out. Default `"auto"`. */
  openings?: "auto" | "keep" | "close" | undefined;
  /** Default `"y"`. */
  upAxis?: "y" | "z" | undefined;
}

/** How far the work has come: a stage's name, and the fraction of the whole, which never falls. */
export interface Progress {
  stage: string;
  fraction: number;
}

export interface Options extends Parameters {
  /** Called in the caller's thread while the worker works. */
  onProgress?: ((progress: Progress) => void) | undefined;
}

/** For functions that run in a worker of this package. */
export interface Cancellable {
  /** Ends the work at once; the promise is rejected with the signal's reason. */
  signal?: AbortSignal | undefined;
}

/** A convex hull as engines take it: in single precision convex as it stands, wound outward. */
export interface Hull {
  /** Three numbers a point, in the mesh's units. */
  points: Float32s;
  /** Three a triangle. */
  indices: Uint32s;
  /** No point of the hull is farther than this outside the solid, in the mesh's units; NaN where it was not verified. */
  protrusion: number;
}

export interface StageTime {
  stage: string;
  seconds: number;
}

/** Lengths are in the mesh's units. */
export interface Report {
  /** The requested bound. */
  bound: number;
  /** No hull is farther than this outside the solid. At most `bound`, unless `remarks` says why not. */
  protrusionMax: number;
  /** No point of the mesh is farther than this outside every hull. */
  uncoveredMax: number;
  /** As many hulls would keep the bound without the limit on vertices, at most. */
  hullsWithoutVertexLimit: number;
  patches: number;
  polygons: number;
  probe: { radius: number; cell: number; unreachableVolume: number } | null;
  algorithmVersion: number;
  sourceVertices: number;
  sourceTriangles: number;
  /** After repair, with caps of openings. */
  triangles: number;
  /** Of the mesh's bounding box. */
  diagonal: number;
  components: number;
  closedComponents: number;
  nestedComponents: number;
  deadlineReached: boolean;
  repairs: Record<string, number>;
  openings: { edges: number; area: number; centre: [number, number, number]; outcome: string }[];
  times: StageTime[];
  /** What was repaired and closed, and why the bound is exceeded if it is, in words; mostly empty. */
  remarks: string[];
}

/** Mass properties of the mesh for a density of 1. */
export interface Mass {
  volume: number;
  centre: [number, number, number];
  /** About the centre, along the mesh's axes. */
  inertia: [[number, number, number], [number, number, number], [number, number, number]];
  principalMoments: [number, number, number];
  /** The rotation to the principal axes: a quaternion, x, y, z, w. */
  principalRotation: [number, number, number, number];
  /** What it was computed from. */
  source: "Mesh" | "MeshUnion" | "HullUnion" | "ConvexHull" | (string & {});
}

export interface Decomposition {
  hulls: Hull[];
  report: Report;
  mass: Mass;
  /** A `.hulls` file: hulls in double precision with their errors and mass, as the command and `HullsFile` in Rust read it. */
  hullsFile: Bytes;
}

/** How a surface is simplified. What is left out has its default. */
export interface SimplifyParameters {
  /** The largest distance between the two surfaces, from either to the other. Default `"0.5%"`. */
  maxError?: Length | undefined;
  /** Whether triangles that nothing can touch stay. Default false. */
  keepHidden?: boolean | undefined;
}

export interface SimplifyOptions extends SimplifyParameters {
  /** Called in the caller's thread while the worker works. */
  onProgress?: ((progress: Progress) => void) | undefined;
}

/** Lengths are in the mesh's units. */
export interface SimplifyReport {
  /** The bound. Both distances are at most this. */
  bound: number;
  /** No point of the result is farther than this from the mesh. */
  fromSource: number;
  /** No point of the mesh is farther than this from the result. */
  toSource: number;
  sourceTriangles: number;
  sourceVertices: number;
  triangles: number;
  vertices: number;
  hiddenTriangles: number;
  repairs: Record<string, number>;
  algorithmVersion: number;
}

/** A surface with few triangles, for a collider of what never moves. */
export interface SimplifiedSurface {
  /** Three numbers a vertex. Each vertex has the place of one of the mesh. */
  positions: Float64s;
  indices: Uint32s;
  /** For each triangle one of the mesh: the nearest to its centre. A material survives so. */
  sources: Uint32s;
  /** The triangles of the mesh that nothing can touch, and that are left out. */
  hidden: Uint32s;
  report: SimplifyReport;
}

/** Distances of sampled points, as fractions of the diagonal. */
export interface Distances {
  mean: number;
  p99: number;
  max: number;
}

/** How well hulls stand for a mesh. Lengths are fractions of `diagonal`. */
export interface Measurement {
  hulls: number;
  unusableHulls: number;
  vertices: number;
  nonConvexHulls: number;
  worstConcavity: number;
  openHulls: number;
  nonPositiveVolumes: number;
  protrusion: Distances;
  uncovered: Distances;
  hausdorff: number;
  uncoveredVolume: number | null;
  iou: number | null;
  overlap: number | null;
  openEdges: number;
  diagonal: number;
}

/** Hulls of a decomposition, of a `.hulls` file, or the points of hulls of any tool. */
export type Hulls =
  | Pick<Decomposition, "hullsFile">
  | Uint8Array
  | readonly { points: Float32Array | Float64Array | ArrayLike<number> }[];

/** Errors of a state, in the mesh's units. */
export interface CurvePoint {
  hulls: number;
  error: number;
  protrusionMax: number;
  uncoveredMax: number;
}

/** Hulls and all that they are joined to, from all of them down to one. */
export interface MergeTree {
  /** One for each state: as many hulls as there are, one fewer, … one. */
  curve: CurvePoint[];
  /** The hulls that were given, then the joint ones in the order of the joins. */
  hulls: Hull[];
  /** For each join the two of `hulls` that give way to the next joint one. */
  joined: [number, number][];
}

/** A file's bytes, or its text. */
export type FileContent = Uint8Array | ArrayBuffer | string;

/** A file, or several files by their paths, for a glTF that names others. */
export type MeshFiles = FileContent | Record<string, FileContent>;

export type MeshFormat = "obj" | "off" | "ply" | "stl" | "gltf" | "glb";

/** What a file holds, in its own units. */
export interface ReadMesh {
  positions: Float64s;
  indices: Uint32s;
  /** Empty where the file says nothing of sides. */
  doubleSided: Bytes;
  /** The named parts, in triangles. */
  objects: { name: string; start: number; count: number }[];
}
