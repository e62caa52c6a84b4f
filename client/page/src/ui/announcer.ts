/// Announces changes to a screen reader: at most one sentence every few seconds, and none twice
/// in a row.
const kEveryMs = 4000;

export class Announcer {
  private spoken = "";
  private lastMs = -Infinity;

  constructor(private readonly say: (sentence: string) => void) {}

  offer(sentence: string, nowMs: number): void {
    if (sentence === this.spoken || nowMs - this.lastMs < kEveryMs) return;
    this.spoken = sentence;
    this.lastMs = nowMs;
    this.say(sentence);
  }
}
