import {join} from "node:path";
import {fileURLToPath} from "node:url";

import {defineConfig} from "vite";

const root = fileURLToPath(new URL("../..", import.meta.url));
export default defineConfig({
  base: "./",
  resolve: {
    alias: {
      "@wire": join(root, "build/page_modules/generated/scene_generated.ts"),
    },
  },
  build: {
    outDir: join(root, "build/page"),
    emptyOutDir: true,
    target: "es2022",
    sourcemap: false,
    chunkSizeWarningLimit: 1500,
    reportCompressedSize: false,
  },
});
