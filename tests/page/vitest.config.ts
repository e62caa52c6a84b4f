import {fileURLToPath} from "node:url";

import {defineConfig} from "vitest/config";

const at = (path: string): string => fileURLToPath(new URL(path, import.meta.url));

export default defineConfig({
  cacheDir: at("../../build/page_modules/.vite"),
  resolve: {
    alias: {
      "@wire": at("../../build/page_modules/generated/scene_generated.ts"),
      "@page": at("../../client/page/src"),
    },
  },
  test: {
    include: ["**/*_test.ts"],
    fileParallelism: false,
    testTimeout: 300_000,
    hookTimeout: 300_000,
  },
});
