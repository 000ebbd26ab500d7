// The page in a real browser.

import { defineConfig } from "@playwright/test";
import { launchOptions } from "./chromium.mjs";

export default defineConfig({
  testDir: "tests",
  // Software rendering takes all processors.
  workers: 1,
  timeout: 120_000,
  reporter: "list",
  outputDir: "shots/failures",
  use: {
    browserName: "chromium",
    viewport: { width: 1280, height: 800 },
    launchOptions,
  },
});
