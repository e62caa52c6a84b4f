/// A press shorter than this is a tap [ms].
const kTapMs = 250;

/// The pedal of a bur, which turns while it is held down; a tap lets it turn until the next.
export class Pedal {
  turns = false;
  private downMs: number | undefined;
  private turnedBefore = false;

  constructor(private readonly changed: () => void) {}

  down(nowMs: number): void {
    if (this.downMs !== undefined) return; // a key that repeats
    this.downMs = nowMs;
    this.turnedBefore = this.turns;
    this.set(true);
  }

  up(nowMs: number): void {
    if (this.downMs === undefined) return;
    const isTap = nowMs - this.downMs < kTapMs;
    this.downMs = undefined;
    this.set(isTap && !this.turnedBefore);
  }

  off(): void {
    this.downMs = undefined;
    this.set(false);
  }

  private set(turns: boolean): void {
    if (this.turns === turns) return;
    this.turns = turns;
    this.changed();
  }
}
