// Bundles the viewer into one HTML file: `node build.mjs` writes it, `--check` compares it with what
// the repository has.

import { readFileSync, writeFileSync } from "node:fs";
import { bundle, fill, here } from "./bundle.mjs";

const TEMPLATE = here("../crates/cli/src/viewer/template.html");

// Shaders keep the line breaks that the preprocessor needs; others are no use.
const page = fill({ style: await bundle("src/style.css"), script: await bundle("src/main.ts") });

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
