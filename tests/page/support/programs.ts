import {type ChildProcess, spawn} from "node:child_process";
import {join} from "node:path";
import {fileURLToPath} from "node:url";

import {ownDomain} from "./domain";

export const kBin = process.env.PALPATE_BIN_DIR ?? join(process.cwd(), "../../build/release/bin");

/// Programs to be stopped if this process ends early, as with Ctrl-C.
const kRunning = new Set<ChildProcess>();
process.once("exit", () => {
  for (const child of kRunning) child.kill();
});

/// One of Palpate's programs, as a test runs it.
export class Program {
  output = "";
  private readonly child: ChildProcess;
  private ended = false;

  constructor(
    private readonly name: string,
    args: readonly string[],
  ) {
    this.child = spawn(join(kBin, name), args, {stdio: ["ignore", "pipe", "pipe"]});
    const keep = (text: Buffer): void => void (this.output += text.toString());
    this.child.stdout!.on("data", keep);
    this.child.stderr!.on("data", keep);
    this.child.on("error", (error) => (this.output += String(error)));
    kRunning.add(this.child);
    this.child.on("close", () => {
      this.ended = true;
      kRunning.delete(this.child);
    });
  }

  /// Waits for output that matches, and returns the match; throws with all output if none does in time.
  async says(regex: RegExp, withinMs = 60_000): Promise<RegExpMatchArray> {
    const end = Date.now() + withinMs;
    for (;;) {
      const match = regex.exec(this.output);
      if (match) return match;
      if (this.ended || Date.now() > end) {
        throw new Error(`${this.name} did not say ${String(regex)}:\n${this.output}`);
      }
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  }

  async stop(signal: NodeJS.Signals = "SIGTERM"): Promise<void> {
    if (this.ended) return;
    const gone = new Promise((resolve) => this.child.once("close", resolve));
    this.child.kill(signal);
    const insist = setTimeout(() => this.child.kill("SIGKILL"), 10_000);
    await gone;
    clearTimeout(insist);
  }
}

const kPage = fileURLToPath(new URL("../../../build/page", import.meta.url));
export const kDomain = ["--domain", await ownDomain()];
export const kCommon = ["--transport", "udp", ...kDomain];

/// Starts a server, and waits until it is ready.   @param scenes  their names, or files
export async function startServer(...scenes: string[]): Promise<Program> {
  const server = new Program("palpate-server", [
    ...["--scene", ...scenes, "--realtime", "off"],
    ...kCommon,
  ]);
  await server.says(/^ready/m, 300_000);
  return server;
}

/// Starts a gateway with the page, and waits until it is ready.
export async function startGateway(...more: string[]): Promise<{gateway: Program; url: string}> {
  const gateway = new Program("palpate-viewer", [
    "--http",
    "0",
    "--page",
    kPage,
    ...more,
    ...kCommon,
  ]);
  const [url] = await gateway.says(/http:\/\/127\.0\.0\.1:\d+\//);
  return {gateway, url};
}

/// Starts a station that repeats its motion until it is stopped.
export const startHand = (device: string, scene: string): Program =>
  new Program("palpate-station", [
    ...["--device", device, "--scene", scene, "--id", "hand", "--loop"],
    ...["--no-table", "--realtime", "off"],
    ...kCommon,
  ]);
