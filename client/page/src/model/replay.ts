import {say} from "../messages/say";
import type {ReplayContents, ReplayMark, ReplayState} from "../protocol/messages";

/// Replayers send their state five times a second: one silent for this long has stopped [s].
export const kReplaySilentS = 3;
/// A change of recorded time beyond this, backwards or ahead of the elapsed time, is a jump [s].
const kLeapBackS = 0.1;
const kLeapS = 0.5;
/// If a mark has only just passed, "back" goes to the one before it [s].
const kJustPassedS = 0.8;
/// "next" skips a mark at which the replay stands [s].
export const kHereS = 0.05;

/// none: the page shows live data.
export type ReplayPhase = "none" | "playing" | "paused" | "silent" | "ended";

/// The state of the replay that this page shows.  Times of the recording are in seconds from its
/// beginning; `nowS` is this page's clock, `stampS` the replayer's.
export class Replay {
  private readonly known = new Map<string, ReplayContents>(); // by replay number
  state: ReplayState | undefined; // the last one received
  private stampS = 0;
  private heardS = -Infinity;

  get contents(): ReplayContents | undefined {
    return this.state && this.known.get(this.state.replay);
  }
  /// The recording's name, for display.
  get name(): string {
    return this.contents?.recording ?? say("replay.a_recording");
  }
  get lengthS(): number {
    return Math.max(this.contents?.lengthS ?? 0, this.state?.atS ?? 0);
  }

  /// @param sinceS  silence before this moment does not count: the link was closed, or this page
  /// could not run
  phase(nowS: number, sinceS = -Infinity): ReplayPhase {
    if (!this.state) return "none";
    if (this.state.ended) return "ended";
    if (this.silenceS(nowS, sinceS) > kReplaySilentS) return "silent";
    return this.state.playing ? "playing" : "paused";
  }
  silenceS(nowS: number, sinceS = -Infinity): number {
    return nowS - Math.max(this.heardS, sinceS);
  }

  receiveContents(contents: ReplayContents): void {
    this.known.set(contents.replay, contents);
  }

  /// Returns whether the recording's time has jumped, so that earlier data is not
  /// continuous with it.
  receiveState(state: ReplayState, stampS: number, nowS: number): boolean {
    const isOther = state.replay !== this.state?.replay;
    const phase = this.phase(nowS);
    // Of two replays at once, the first is shown until it ends.
    if (isOther && (phase === "playing" || phase === "paused")) return false;
    const beyondS = state.atS - this.timeOf(stampS);
    const backS = (this.state?.atS ?? 0) - state.atS;
    const leapS = kLeapS * Math.max(1, state.rate);
    this.state = state;
    this.stampS = stampS;
    this.heardS = nowS;
    return isOther || backS > kLeapBackS || beyondS > leapS;
  }

  /// Returns the recorded time of data sent at a time of the replayer's clock.
  timeOf(stampS: number): number {
    const {state} = this;
    if (!state) return 0;
    return state.atS + (state.playing ? state.rate * (stampS - this.stampS) : 0);
  }

  /// Returns the replay's position: it advances between two states and stops when the
  /// replayer is silent.
  atS(nowS: number): number {
    const {state} = this;
    if (!state) return 0;
    const goneS = state.playing ? Math.min(nowS - this.heardS, 1) : 0;
    return Math.min(state.atS + state.rate * goneS, this.lengthS);
  }

  /// Whether it can be steered: anybody may from whom the gateway takes messages, unless
  /// it is locked.
  isSteered(nowS: number): boolean {
    const phase = this.phase(nowS);
    return (phase === "playing" || phase === "paused") && this.contents?.locked === false;
  }

  forget(): void {
    this.state = undefined;
    this.heardS = -Infinity;
  }
}

export function markBefore(
  marks: readonly ReplayMark[],
  atS: number,
  rate: number,
): ReplayMark | undefined {
  const passedS = Math.max(kHereS, kJustPassedS * rate);
  return marks.filter((mark) => mark.atS < atS - passedS).at(-1);
}

export function markAfter(marks: readonly ReplayMark[], atS: number): ReplayMark | undefined {
  return marks.find((mark) => mark.atS > atS + kHereS);
}
