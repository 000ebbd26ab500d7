// What the build puts in.

declare module "#wasm" {
  /** Base64 of the gzipped module. */
  const text: string;
  export default text;
}

declare module "#worker" {
  /** The worker's code. */
  const text: string;
  export default text;
}
