// The page in a real browser: Debian's Chromium, with software rendering.

import { defineConfig } from "@playwright/test";

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
    launchOptions: {
      executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
      args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
    },
  },
});
