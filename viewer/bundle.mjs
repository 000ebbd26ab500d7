// What the builds of the viewer's two pages share.

import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

export const here = (path) => fileURLToPath(new URL(path, import.meta.url));

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

/** One file of an entry and all that it imports. */
export async function bundle(entry, plugins = []) {
  const { outputFiles } = await build({
    entryPoints: [here(entry)],
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    target: "es2022",
    charset: "utf8",
    // Licences stay in the file.
    legalComments: "inline",
    plugins,
    logLevel: "warning",
  });
  return outputFiles[0].text.trim();
}

/** `page.html` with style and script, and a policy: nothing is loaded, and no script runs but this one, whatever the data
 * holds, and those that `scripts` allows. */
export function fill({ style, script, scripts = "", policies = [] }) {
  const harmless = script.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
  const policy = [
    "default-src 'none'",
    `script-src ${hash(harmless)}${scripts}`,
    ...policies,
    `style-src ${hash(style)}`,
    "base-uri 'none'",
    "form-action 'none'",
  ].join("; ");
  return readFileSync(here("src/page.html"), "utf8")
    .replace("<!--policy-->", () => policy)
    .replace("<!--style-->", () => style)
    .replace("<!--script-->", () => harmless);
}
