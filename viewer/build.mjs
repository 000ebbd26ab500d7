// Bundles the viewer into one HTML file: `node build.mjs` writes it, `--check` compares it with what
// the repository has.

import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const TEMPLATE = here("../crates/cli/src/viewer/template.html");

async function bundle(entry) {
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
    logLevel: "warning",
  });
  return outputFiles[0].text.trim();
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

const style = await bundle("src/style.css");
// Shaders keep the line breaks that the preprocessor needs; others are no use.
const script = (await bundle("src/main.ts")).replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
// Nothing is loaded, and no script runs but this one, whatever the data holds.
const policy = [
  "default-src 'none'",
  `script-src ${hash(script)}`,
  `style-src ${hash(style)}`,
  "base-uri 'none'",
  "form-action 'none'",
].join("; ");
const page = readFileSync(here("src/page.html"), "utf8")
  .replace("<!--policy-->", () => policy)
  .replace("<!--style-->", () => style)
  .replace("<!--script-->", () => script);

if (process.argv.includes("--check")) {
  if (readFileSync(TEMPLATE, "utf8") !== page) {
    console.error("template.html is not what viewer/ builds: run `npm run build` there");
    process.exit(1);
  }
  console.log("template.html is what viewer/ builds");
} else {
  writeFileSync(TEMPLATE, page);
  console.log(`template.html: ${page.length} characters`);
}
