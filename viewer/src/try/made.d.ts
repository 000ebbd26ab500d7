// What the build puts in.

declare module "#worker" {
  /** The worker's code. */
  const text: string;
  export default text;
}
