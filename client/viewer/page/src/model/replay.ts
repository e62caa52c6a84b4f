import {say} from "../messages/say";
import type {ReplayContents, ReplayMark, ReplayState} from "../protocol/messages";

/// Replayers speak five times a second: one that is silent for this long has stopped [s].
export const kReplaySilentS = 3;
/// Of the recording's time, back, and on beyond what went by: what is more was a leap [s].
const kLeapBackS = 0.1;
const kLeapS = 0.5;
/// From a mark that has only just passed, the way back leads to the one before it [s].
const kJustPassedS = 0.8;
/// A mark at which the replay stands is not the next one [s].
export const kHereS = 0.05;

/// none: what the page sees is live.
export type ReplayPhase = "none" | "playing" | "paused" | "silent" | "ended";

/// What is known of the replay that this page sees.  Times of the recording are seconds from its
/// beginning; `nowS` and `stampS` are this page's clock and the replayer's.
export class Replay {
  private readonly known = new Map<string, ReplayContents>(); // by replay
  state: ReplayState | undefined; // the last that was heard
  private stampS = 0;
  private heardS = -Infinity;

  get contents(): ReplayContents | undefined {
    return this.state && this.known.get(this.state.replay);
  }
  /// The recording's name, for those who read it.
  get name(): string {
    return this.contents?.recording ?? say("replay.a_recording");
  }
  get lengthS(): number {
    return Math.max(this.contents?.lengthS ?? 0, this.state?.atS ?? 0);
  }

  /// @param sinceS  silence before this moment is none of the replay's: the link was not open, or
  ///                this page could not run
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

  /// True where the recording's time has leapt: what was before does not lead here.
  receiveState(state: ReplayState, stampS: number, nowS: number): boolean {
    const isOther = state.replay !== this.state?.replay;
    const phase = this.phase(nowS);
    // Of two at once the first is shown until it is over.
    if (isOther && (phase === "playing" || phase === "paused")) return false;
    const beyondS = state.atS - this.timeOf(stampS);
    const backS = (this.state?.atS ?? 0) - state.atS;
    const leapS = kLeapS * Math.max(1, state.rate);
    this.state = state;
    this.stampS = stampS;
    this.heardS = nowS;
    return isOther || backS > kLeapBackS || beyondS > leapS;
  }

  /// The recording's time of what the replayer sent at a moment of its clock.
  timeOf(stampS: number): number {
    const {state} = this;
    if (!state) return 0;
    return state.atS + (state.playing ? state.rate * (stampS - this.stampS) : 0);
  }

  /// Where the replay is now.  Between two states it goes on, and in a silence it stops.
  atS(nowS: number): number {
    const {state} = this;
    if (!state) return 0;
    const goneS = state.playing ? Math.min(nowS - this.heardS, 1) : 0;
    return Math.min(state.atS + state.rate * goneS, this.lengthS);
  }

  /// Who may steer is who the gateway takes messages from, where the replay is not locked.
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
