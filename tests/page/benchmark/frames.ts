// What pictures cost on a machine without a graphics card: the page in Chromium, which draws by
// software, at the real programs.  tests/benchmarks/page runs it, and says how.
import {readdirSync, readFileSync, writeFileSync} from "node:fs";
import {cpus, loadavg} from "node:os";
import {join} from "node:path";
import {parseArgs} from "node:util";

import type {BrowserContextOptions, Page} from "playwright-core";

import type {Probe} from "@page/parts/probe";

import {launch, probe, until} from "../support/browser";
import {type Program, startGateway, startHand, startServer} from "../support/programs";

const kScreens: Readonly<Record<string, BrowserContextOptions>> = {
  "laptop, 1400 × 900": {viewport: {width: 1400, height: 900}},
  "phone, 360 × 800 at 3": {
    viewport: {width: 360, height: 800},
    deviceScaleFactor: 3,
    isMobile: true,
    hasTouch: true,
  },
};
const kTicksMs = 10; // of /proc/PID/stat

const kDefaults = {
  scene: "oral-cavity",
  seconds: "5",
  repeats: "3",
  report: "", // file; empty: none
  qualities: "chosen,full,good,fair,low",
  shots: "", // folder of screenshots; empty: none
  build: "", // what is measured, in words
  command: "",
};
type Options = typeof kDefaults;

interface Row {
  screen: string;
  quality: string; // chosen: by the page
  moves: "the tool" | "the eye";
  perSecond: number[]; // pictures, of each repeat
  cpuMs: number[]; // of Chromium's processes, a picture
  drawn: string; // the quality that was in use at the end
  canvas: string;
  triangles: number; // a picture
  calls: number;
}

function optionsFrom(args: string[]): Options {
  const texts = Object.keys(kDefaults).map((name) => [name, {type: "string"}] as const);
  return {...kDefaults, ...parseArgs({args, options: Object.fromEntries(texts)}).values};
}

const sleep = (seconds: number): Promise<void> =>
  new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

/// Processor time of all processes of Chromium that this one has begun [ms].
function chromiumMs(): number {
  const parents = new Map<number, number>();
  const ticks = new Map<number, number>();
  for (const name of readdirSync("/proc").filter((entry) => /^\d+$/.test(entry))) {
    let stat = "";
    try {
      stat = readFileSync(join("/proc", name, "stat"), "utf8");
    } catch {
      continue; // it has ended meanwhile
    }
    const command = stat.slice(stat.indexOf("(") + 1, stat.lastIndexOf(")"));
    const [, parent, ...rest] = stat.slice(stat.lastIndexOf(")") + 2).split(" ");
    parents.set(Number(name), Number(parent));
    if (/chrom/.test(command)) ticks.set(Number(name), Number(rest[9]) + Number(rest[10]));
  }
  const isOurs = (pid: number | undefined): boolean =>
    pid !== undefined && (pid === process.pid || isOurs(parents.get(pid)));
  let sum = 0;
  for (const [pid, own] of ticks) sum += isOurs(pid) ? own : 0;
  return kTicksMs * sum;
}

/// Drags the picture to and fro about the first sight, as long as wanted.
/// @return what the page knows in the midst of it
async function turn(page: Page, seconds: number, shot = ""): Promise<Probe> {
  await page.locator("#reset").click();
  const box = (await page.locator("#view").boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + 0.4 * box.height];
  const end = performance.now() + 1000 * seconds;
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 0; performance.now() < end; i++) {
    await page.mouse.move(x + 0.1 * box.width * Math.sin(0.06 * i), y);
    await sleep(0.012);
  }
  const last = await probe(page);
  if (shot !== "") await page.screenshot({path: shot});
  await page.mouse.up();
  return last;
}

/// Lets the tool move.
async function watch(page: Page, seconds: number): Promise<Probe> {
  await sleep(seconds);
  return probe(page);
}

interface Run {
  perSecond: number;
  cpuMs: number;
  probe: Probe; // while it moves
}

async function measure(page: Page, moves: Row["moves"], seconds: number): Promise<Run> {
  const pictures = (): Promise<[number, number]> =>
    page.evaluate(() => [window.palpate.probe.pictures, performance.now()]);
  const [before, fromMs] = await pictures();
  const cpuBefore = chromiumMs();
  const moved = await (moves === "the tool" ? watch(page, seconds) : turn(page, seconds));
  const cpu = chromiumMs() - cpuBefore;
  const [after, toMs] = await pictures();
  const count = Math.max(1, after - before);
  return {perSecond: (1000 * count) / (toMs - fromMs), cpuMs: cpu / count, probe: moved};
}

async function measureScreen(
  page: Page,
  moves: Row["moves"],
  options: Options,
): Promise<Omit<Row, "screen" | "quality">> {
  const seconds = Number(options.seconds);
  // So that a page that chooses has chosen.
  await measure(page, moves, 2 * seconds);
  const runs: Run[] = [];
  for (let i = 0; i < Number(options.repeats); i++) runs.push(await measure(page, moves, seconds));
  const {quality, costs} = runs.at(-1)!.probe;
  const canvas = await page.evaluate(() => {
    const {width, height} = document.getElementById("view") as HTMLCanvasElement;
    return `${width} × ${height}`;
  });
  const both = moves === "the eye";
  return {
    moves,
    perSecond: runs.map((run) => run.perSecond),
    cpuMs: runs.map((run) => run.cpuMs),
    drawn: both ? quality.motion : quality.rest,
    canvas,
    triangles: costs.moving.triangles + (both ? costs.still.triangles : 0),
    calls: costs.moving.calls + (both ? costs.still.calls : 0),
  };
}

const best = (values: readonly number[]): number => Math.max(...values);
const middle = (values: readonly number[]): number =>
  [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)]!;

function tableOf(rows: readonly Row[]): string {
  const head = [
    "screen",
    "quality",
    "what moves",
    "pictures a second: best (middle)",
    "processor time a picture [ms]",
    "canvas",
    "triangles",
    "draw calls",
  ];
  const lines = rows.map((row) => [
    row.screen,
    row.quality === "chosen" ? `chosen: ${row.drawn}` : row.quality,
    row.moves,
    `${best(row.perSecond).toFixed(0)} (${middle(row.perSecond).toFixed(0)})`,
    Math.min(...row.cpuMs).toFixed(0),
    row.canvas,
    String(row.triangles),
    String(row.calls),
  ]);
  const align = ["---", "---", "---", "---:", "---:", "---", "---:", "---:"];
  return [head, align, ...lines].map((cells) => `| ${cells.join(" | ")} |`).join("\n");
}

function reportOf(rows: readonly Row[], options: Options, begun: string, load: string): string {
  const machine = [
    ["processor", `${cpus()[0]?.model.trim()}, no graphics card: Chromium draws by SwiftShader`],
    ["cores", `${cpus().length}, shared with server, gateway and station`],
    ["build", options.build],
    ["begun", begun],
    ["load averages before", load],
  ];
  const isBusy = Number(load.split(" ")[0]) > 0.25 * cpus().length;
  const notAtRest = `

**The machine was not at rest:** a load average of ${load.split(" ")[0]!} on ${cpus().length} cores before the first
measurement. Pictures a second are fewer than on a quiet machine, the middle ones most of all, and a picture's
processor time is longer, since caches are shared and plots, ten times a second, fall on fewer pictures.`;
  return `# The page's pictures

\`\`\`sh
${options.command}
\`\`\`

| | |
|---|---|
${machine.map((cells) => `| ${cells.join(" | ")} |`).join("\n")}${isBusy ? notAtRest : ""}

The page at the real server in \`${options.scene}\`, a simulated hand moving the tool, the teacher's view
with its plots, in headless Chromium. *The tool*: the eye stands still, and what stands still is copied
under each picture. *The eye*: the view is dragged to and fro meanwhile, so that all of it is drawn anew;
at full quality that is what every picture cost before what stands still was kept.
*Chosen* is what the page's own ladder came to; the others are fixed with \`?quality=\`. Pictures a second are
the best and the middle of ${options.repeats} runs of ${options.seconds} s: other processes take cores away, and
headless Chromium shows 60 a second at most. Processor time is that of all of Chromium's processes, the least of
the runs; the two cores share it.

${tableOf(rows)}
`;
}

async function main(): Promise<void> {
  const options = optionsFrom(process.argv.slice(2));
  const begun = new Date().toISOString().replace("T", " ").slice(0, 16) + " UTC";
  const load = loadavg()
    .map((value) => value.toFixed(2))
    .join(" ");
  const {scene} = options;
  const programs: Program[] = [];
  const browser = await launch(0, []);
  const rows: Row[] = [];
  try {
    const server = await startServer(scene);
    programs.push(server);
    const {gateway, url} = await startGateway();
    programs.push(gateway, startHand("simulated", scene));
    await server.says(/station hand: active/);
    for (const [screen, context] of Object.entries(kScreens)) {
      for (const quality of options.qualities.split(",")) {
        const page = await browser.newPage(context);
        await page.goto(`${url}?scene=${scene}&quality=${quality}`);
        await until(
          page,
          "a hand",
          ({stations, pictures}) => !!stations.hand && pictures > 5,
          60_000,
        );
        for (const moves of ["the tool", "the eye"] as const) {
          rows.push({screen, quality, ...(await measureScreen(page, moves, options))});
          console.log(JSON.stringify(rows.at(-1)));
          if (options.shots !== "") {
            const name = `${screen}-${quality}-${moves}`.replace(/\W+/g, "-");
            const file = join(options.shots, `${name}.png`);
            await (moves === "the tool" ? page.screenshot({path: file}) : turn(page, 1, file));
          }
        }
        await page.close();
      }
    }
  } finally {
    await browser.close();
    for (const program of programs.reverse()) await program.stop();
  }
  console.log(tableOf(rows));
  if (options.report !== "") writeFileSync(options.report, reportOf(rows, options, begun, load));
}

await main();
