/// Chooses the best of several qualities that a machine draws fast enough: steps down if pictures
/// take too long, and up if there is time to spare.  Knows the pictures' durations, but no clock.

/// The aim is thirty pictures a second; a 60 Hz screen shows them every 33.3 ms or slightly later.
const kSlowMs = 36;
/// Approximate cost of a rung relative to the one below it.
const kRungCost = 1.5;
/// Fast enough for the rung above to reach thirty a second.
const kFastMs = 33.4 / kRungCost;
/// Judged by the median over this time, and over a least number of pictures: a single one may be
/// late because the machine did something else.
const kJudgedMs = 500;
const kJudged = 5;
/// The first pictures of a rung create its buffers and shaders.
const kSettling = 2;
/// A rung must be easy for this long before the next one is tried; the time doubles each time that
/// a try is soon taken back.
const kPatienceMs = 3000;
const kLongestPatienceMs = 60_000;
const kSoonMs = 5000;
/// A longer time means that the page was hidden.
const kLongestMs = 1000;

export class Ladder {
  rung: number; // the present one
  private took_: number[] = [];
  private settling = kSettling;
  private easyMs = 0;
  private patienceMs = kPatienceMs;
  private sinceClimbMs = Infinity;

  /// @param rungs  number of qualities; 0 is the best.   @param start  where to begin
  constructor(
    private readonly rungs: number,
    private readonly start = 0,
  ) {
    this.rung = start;
  }

  /// Something else is drawn from now on, at an unknown cost.
  restart(): void {
    this.patienceMs = kPatienceMs;
    this.sinceClimbMs = Infinity;
    this.moveTo(this.start);
  }

  /// @return whether the rung has changed
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
    // If it is much too slow, skip rungs.
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
