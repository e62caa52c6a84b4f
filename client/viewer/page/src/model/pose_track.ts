import type {ToolState} from "../protocol/messages";
import {mixPose, mixVec3, samePose} from "./pose";

/// How far behind the newest frame the picture is [s]: one and a half frames of 30 Hz, so that there
/// is nearly always a frame on either side to interpolate between.
export const kDelayS = 0.05;
/// Frames that are older than this are forgotten [s].
const kKeepS = 1;
/// After a gap of this length a tool jumps: a slow glide would show a motion that never was [s].
const kGapS = 0.5;

/// Maps a sender's clock to ours by the frame that came fastest; forgets slowly, so that a clock
/// that drifts or is set is followed.
export class StreamClock {
  private offset: number | undefined;
  private lastArrivalS = 0;

  /// Our time at which a frame stamped `stampS` and received at `arrivalS` is taken to have been sent.
  toLocal(stampS: number, arrivalS: number): number {
    const offset = arrivalS - stampS;
    const elapsed = Math.max(0, arrivalS - this.lastArrivalS);
    this.lastArrivalS = arrivalS;
    if (this.offset === undefined || Math.abs(offset - this.offset) > kGapS) {
      this.offset = offset;
    } else {
      this.offset = Math.min(offset, this.offset + 0.01 * elapsed);
    }
    return stampS + this.offset;
  }
}

/// The frames of one station, and its state at any moment between them.  Never extrapolates.
export class PoseTrack {
  private readonly frames: {timeS: number; state: ToolState}[] = [];

  push(timeS: number, state: ToolState): void {
    const last = this.frames.at(-1);
    if (last && timeS <= last.timeS) {
      // Out of order or the same moment: the newer sample wins, time does not go back.
      if (state.poseSequence < last.state.poseSequence && timeS > last.timeS - kGapS) return;
      this.frames.length = 0;
    }
    this.frames.push({timeS, state});
    while (this.frames[1] && this.frames[1].timeS < timeS - kKeepS) this.frames.shift();
  }

  get latest(): ToolState | undefined {
    return this.frames.at(-1)?.state;
  }
  get latestTimeS(): number {
    return this.frames.at(-1)?.timeS ?? -Infinity;
  }

  at(timeS: number): ToolState | undefined {
    let after = this.frames.length - 1;
    if (after < 0) return undefined;
    while (after > 0 && this.frames[after - 1]!.timeS >= timeS) after -= 1;
    const b = this.frames[after]!;
    const a = this.frames[after - 1];
    if (!a || timeS >= b.timeS) return b.state;
    if (b.timeS - a.timeS > kGapS || a.state.tool !== b.state.tool) return a.state;
    return between(a.state, b.state, (timeS - a.timeS) / (b.timeS - a.timeS));
  }
}

function between(a: ToolState, b: ToolState, t: number): ToolState {
  if (t <= 0) return a;
  return {
    ...(t < 0.5 ? a : b),
    haptic: mixPose(a.haptic, b.haptic, t),
    graphic: mixPose(a.graphic, b.graphic, t),
    forceN: mixVec3(a.forceN, b.forceN, t),
    torqueNm: mixVec3(a.torqueNm, b.torqueNm, t),
  };
}

/// True where a picture of both would be the same.
export function looksTheSame(a: ToolState | undefined, b: ToolState | undefined): boolean {
  if (a === b) return true;
  if (!a || !b) return false;
  return (
    a.tool === b.tool &&
    samePose(a.haptic, b.haptic) &&
    samePose(a.graphic, b.graphic) &&
    a.forceN.every((value, i) => value === b.forceN[i]) &&
    a.torqueNm.every((value, i) => value === b.torqueNm[i]) &&
    a.points === b.points
  );
}
