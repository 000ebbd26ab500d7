// The page: reads its data, and shows it.

import { find } from "./controls";
import { readPage } from "./data";
import { shared } from "./shaders";
import { View } from "./view";

async function start() {
  const { panels, stage, look } = new View(await readPage());
  // For tests and for who embeds the page.
  Object.assign(window, { hullwright: { panels, stage, look, shared } });
  document.documentElement.dataset.ready = "true";
}

start().catch((error: unknown) => {
  const message = find("message");
  message.textContent = error instanceof Error ? error.message : String(error);
  message.hidden = false;
});
