// Compares removed volumes with those of an independent library: Manifold's hulls, intersected with the
// solid's mesh (manifold-3d, build/sweep), from the output of palpate-bench cut --sweep.
//   node sweep_test.mjs [FILE.json]...    prints both volumes of each file; without files: a test
import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import {existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {fileURLToPath, pathToFileURL} from "node:url";
import {describe, it} from "node:test";

const folder = process.env.PALPATE_SWEEP_MODULES ?? "build/sweep/node_modules";
const module = join(folder, "manifold-3d", "manifold.js");
const kSides = 36;
const kMillimetre = 1e3; // Manifold's precision suits numbers about 1

/// The bur's profile as a polygon in (rho, z), with arcs of `rounding` about the curve's points.
function outlineOf({curve_m, rounding_m}) {
  const outline = [];
  const normal = (i) => {
    if (i < 0) return -0.5 * Math.PI;
    if (i + 1 >= curve_m.length) return 0.5 * Math.PI;
    const [[a, b], [c, d]] = [curve_m[i], curve_m[i + 1]];
    return Math.atan2(a - c, d - b);
  };
  curve_m.forEach(([rho, z], i) => {
    const from = normal(i - 1);
    const to = normal(i);
    const steps =
      rounding_m > 0 ? Math.max(1, Math.ceil((to - from) / ((2 * Math.PI) / kSides))) : 0;
    const turn = steps ? (to - from) / steps : 0;
    // Of the arc's area: chords lie half inside and half outside it.
    const radius = turn > 0 ? rounding_m * Math.sqrt(turn / Math.sin(turn)) : rounding_m;
    for (let s = 0; s <= steps; ++s) {
      const angle = from + turn * s;
      outline.push([Math.max(0, rho + radius * Math.cos(angle)), z + radius * Math.sin(angle)]);
    }
  });
  return outline.map(([rho, z]) => [kMillimetre * rho, kMillimetre * z]);
}

/// Volume [mm^3] of the solid of revolution of a convex outline about z, by cones.
function turnedVolume(outline) {
  let sum = 0;
  for (let i = 0; i + 1 < outline.length; ++i) {
    const [[a, b], [c, d]] = [outline[i], outline[i + 1]];
    sum += (Math.PI / 3) * (d - b) * (a * a + a * c + c * c);
  }
  return Math.abs(sum);
}

/// Volume that a bur's path removes from the solids [mm^3], by Manifold.
async function volumeOf(report) {
  const {default: Module} = await import(pathToFileURL(module));
  const wasm = await Module();
  wasm.setup();
  const {Manifold, Mesh} = wasm;
  const outline = outlineOf(report.bur);
  const inscribed = Manifold.revolve([outline], kSides);
  const wider = Math.sqrt(turnedVolume(outline) / inscribed.volume());
  const bur = inscribed.scale([wider, wider, 1]);
  let volume = 0;
  for (const {vertices_m, triangles, way} of report.solids) {
    const solid = new Manifold(
      new Mesh({
        numProp: 3,
        vertProperties: Float32Array.from(vertices_m.flat(), (x) => kMillimetre * x),
        triVerts: Uint32Array.from(triangles.flat()),
      }),
    );
    const pieces = way.map(([x, y, z, w, i, j, k, ...step]) => {
      // Columns of the rotation, then the position.
      const at = (p) => [
        ...[1 - 2 * (j * j + k * k), 2 * (i * j + w * k), 2 * (i * k - w * j), 0],
        ...[2 * (i * j - w * k), 1 - 2 * (i * i + k * k), 2 * (j * k + w * i), 0],
        ...[2 * (i * k + w * j), 2 * (j * k - w * i), 1 - 2 * (i * i + j * j), 0],
        ...p.map((c) => kMillimetre * c),
        1,
      ];
      return Manifold.hull([
        bur.transform(at([x, y, z])),
        bur.transform(at([x + step[0], y + step[1], z + step[2]])),
      ]);
    });
    volume += solid.intersect(Manifold.union(pieces)).volume();
  }
  return volume;
}

async function errorOf(file) {
  const report = JSON.parse(readFileSync(file, "utf8"));
  const volume = await volumeOf(report);
  const error = (1e9 * report.cut_m3) / volume - 1;
  console.log(
    `${report.scene}: ${(1e9 * report.cut_m3).toFixed(4)} mm3 removed, ${volume.toFixed(4)} mm3 by Manifold: ` +
      `${error < 0 ? "" : "+"}${(100 * error).toFixed(2)} %`,
  );
  return error;
}

const files = process.argv.slice(2);
if (!existsSync(module)) {
  console.log("SKIPPED: no manifold-3d in " + folder + "; deploy/setup --for tests fetches it");
} else if (files.length > 0) {
  for (const file of files) await errorOf(file);
} else {
  // Down into a block and on in a spiral, turning about the block's long axis.
  const poses = Array.from({length: 900}, (_, i) => {
    const turn = 0.006 * Math.max(0, i - 350);
    const [x, z] = [0.0004 * turn * Math.cos(turn), 0.0004 * turn * Math.sin(turn)];
    const tilt = 0.1 * turn;
    return [
      x,
      0.0031 - 4e-6 * Math.min(i, 350),
      z,
      Math.cos(tilt / 2),
      Math.sin(tilt / 2),
      0,
      0,
    ].join();
  }).join("\n");
  describe("RemovedVolume", () => {
    for (const scene of ["layers", "tapered-groove"]) {
      it(`is Manifold's within 0.5 %: ${scene}`, async () => {
        const out = mkdtempSync(join(tmpdir(), "sweep-"));
        try {
          const [path, file] = [join(out, "poses.csv"), join(out, "sweep.json")];
          writeFileSync(path, poses + "\n");
          const {status, stderr} = spawnSync(
            process.env.PALPATE_BENCH,
            ["cut", "--repeats", "1", "--poses", path, "--sweep", file, "--scene"].concat(
              fileURLToPath(new URL(`../scenes/${scene}.json`, import.meta.url)),
            ),
            {encoding: "utf8"},
          );
          assert.equal(status, 0, stderr);
          assert.ok(Math.abs(await errorOf(file)) < 0.005);
        } finally {
          rmSync(out, {recursive: true});
        }
      });
    }
  });
}
