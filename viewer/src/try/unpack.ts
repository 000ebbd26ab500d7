// What is inlined as base64 of gzip in an element of the page.

export async function unpack(id: string): Promise<ArrayBuffer> {
  return inflate(document.getElementById(id)?.textContent ?? "");
}

export async function inflate(base64: string): Promise<ArrayBuffer> {
  const letters = atob(base64.trim());
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}
