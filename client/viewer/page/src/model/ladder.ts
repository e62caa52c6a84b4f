/// Which of several qualities a machine draws fast enough: descends where pictures take too long, and
/// climbs where there is time to spare.  Knows how long pictures took, and no clock.

/// Thirty pictures a second are wanted; a screen of 60 Hz shows them at 33.3 ms sharp, or a little late.
const kSlowMs = 36;
/// What one rung costs more than the one below it, about.
const kRungCost = 1.5;
/// So fast that the rung above should hold thirty.
const kFastMs = 33.4 / kRungCost;
/// Judged by the median over so long, and so many pictures at the least: a single one may be late for
/// what the machine did besides.
const kJudgedMs = 500;
const kJudged = 5;
/// The first pictures of a rung make its buffers and shaders.
const kSettling = 2;
/// A rung must be easy for so long before the next one is tried; for twice as long each time that a try
/// had to be taken back soon.
const kPatienceMs = 3000;
const kLongestPatienceMs = 60_000;
const kSoonMs = 5000;
/// What takes longer is a page that was hidden, and no time that a machine had to spare.
const kLongestMs = 1000;

export class Ladder {
  rung: number; // it stands on
  private took_: number[] = [];
  private settling = kSettling;
  private easyMs = 0;
  private patienceMs = kPatienceMs;
  private sinceClimbMs = Infinity;

  /// @param rungs  from 0, the best, downwards.   @param start  where to begin
  constructor(
    private readonly rungs: number,
    private readonly start = 0,
  ) {
    this.rung = start;
  }

  /// Something else is drawn from now on: what its pictures cost is not known.
  restart(): void {
    this.patienceMs = kPatienceMs;
    this.sinceClimbMs = Infinity;
    this.moveTo(this.start);
  }

  /// @return whether the rung is another one now
  took(pictureMs: number): boolean {
    const ms = Math.min(kLongestMs, pictureMs);
    this.sinceClimbMs += ms;
    if (this.settling > 0) {
      this.settling -= 1;
      return false;
    }
    this.took_.push(ms);
    const spanMs = this.took_.reduce((sum, one) => sum + one, 0);
    if (this.took_.length < kJudged || spanMs < kJudgedMs) return false;
    const median = medianOf(this.took_);
    this.took_ = [];
    if (median > kSlowMs) return this.descend(median);
    this.easyMs = median < kFastMs ? this.easyMs + spanMs : 0;
    return this.easyMs >= this.patienceMs && this.climb();
  }

  private descend(medianMs: number): boolean {
    this.easyMs = 0;
    if (this.rung === this.rungs - 1) return false;
    if (this.sinceClimbMs < kSoonMs)
      this.patienceMs = Math.min(kLongestPatienceMs, 2 * this.patienceMs);
    this.sinceClimbMs = Infinity;
    // What is much too slow need not be tried rung by rung.
    const rungs = 1 + Math.floor(Math.log(medianMs / kSlowMs) / Math.log(kRungCost));
    return this.moveTo(Math.min(this.rungs - 1, this.rung + rungs));
  }

  private climb(): boolean {
    if (this.rung === 0) return false;
    this.sinceClimbMs = 0;
    return this.moveTo(this.rung - 1);
  }

  private moveTo(rung: number): boolean {
    const other = rung !== this.rung;
    this.rung = rung;
    this.took_ = [];
    this.settling = kSettling;
    this.easyMs = 0;
    return other;
  }
}

function medianOf(values: readonly number[]): number {
  return [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)]!;
}
