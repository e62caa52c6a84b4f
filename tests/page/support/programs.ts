import {type ChildProcess, spawn} from "node:child_process";
import {join} from "node:path";

const kBin = process.env.PALPATE_BIN_DIR ?? join(process.cwd(), "../../build/release/bin");

/// What still runs when this process ends before its time, as at Ctrl-C.
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

  /// The first match in what it says; throws with all that it said where there is none in time.
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
