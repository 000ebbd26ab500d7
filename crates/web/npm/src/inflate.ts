// What is compressed within a script or a page.

/** Decodes base64, and decompresses what it holds. */
export async function inflate(base64: string, format: CompressionFormat): Promise<ArrayBuffer> {
  const letters = atob(base64);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  // Not the stream of a `Blob`, which jsdom's lacks.
  const { body } = new Response(bytes);
  return new Response(body!.pipeThrough(new DecompressionStream(format))).arrayBuffer();
}
