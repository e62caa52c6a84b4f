// Tests what capacity.md says about sizes that no machine here can hold.
import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import {readFileSync} from "node:fs";
import {describe, it} from "node:test";
import {fileURLToPath} from "node:url";

const script = fileURLToPath(new URL("capacity_model", import.meta.url));
const run = (...words) => spawnSync(script, words, {encoding: "utf8"});
/// The first number after a name at the beginning of a line.
const figure = (text, name) => Number(new RegExp(`^${name} +([\\d.]+)`, "m").exec(text)[1]);

describe("CapacityModel", () => {
  it("is what capacity.md publishes", () => {
    const report = readFileSync(new URL("results/capacity.md", import.meta.url), "utf8");
    assert.ok(report.includes(run("--published").stdout.trim()), "put in anew what capacity_model --published prints");
  });

  it("says rightly of the rows that it was not fitted to whether they hold", () => {
    const [, checked, right] = /Of (\d+) rows .* says of (\d+) rightly/.exec(run("--check").stdout);
    assert.ok(Number(checked) >= 10);
    assert.equal(right, checked);
  });

  it("needs twice as much for twice as many", () => {
    const one = run("--stations", "400", "--viewers", "4000").stdout;
    const two = run("--stations", "800", "--viewers", "8000").stdout;
    for (const name of ["servers", "gateways", "all gateways", "recordings"]) {
      assert.ok(Math.abs(figure(two, name) / figure(one, name) - 2) < 0.1, name);
    }
  });

  it("gives a gateway no more viewers than it has places for", () => {
    assert.equal(figure(run("--stations", "1", "--viewers", "3000").stdout, "gateways"), 10);
  });

  it("teaches, and refuses what makes no sense", () => {
    assert.match(run("--help").stdout, /^usage: /);
    for (const words of [["--per-server", "33"], ["--stations"], ["--viewers", "many"], ["--what"]]) {
      const {status, stderr} = run(...words);
      assert.equal(status, 2, words.join(" "));
      assert.match(stderr, /see --help/);
    }
  });
});
