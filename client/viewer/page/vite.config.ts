import {readdirSync, readFileSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {fileURLToPath} from "node:url";
import {gzipSync} from "node:zlib";

import {defineConfig, type Plugin} from "vite";

const root = fileURLToPath(new URL("../../..", import.meta.url));
const kCompressed = /\.(html|js|css|svg)$/;

/// Puts FILE.gz beside each file that compresses, so that the gateway need not compress.
function gzipBeside(): Plugin {
  let folder = "";
  return {
    name: "gzip-beside",
    configResolved: (config) => void (folder = config.build.outDir),
    closeBundle() {
      let total = 0;
      for (const name of readdirSync(folder, {recursive: true, encoding: "utf8"})) {
        if (!kCompressed.test(name)) continue;
        const file = join(folder, name);
        const packed = gzipSync(readFileSync(file), {level: 9});
        writeFileSync(`${file}.gz`, packed);
        total += packed.length;
      }
      console.log(`page: ${(total / 1000).toFixed(0)} kB compressed`);
    },
  };
}

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
  plugins: [gzipBeside()],
});
