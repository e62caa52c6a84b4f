import type {ToolState} from "../protocol/messages";
import {mixPose, mixVec3} from "../base/pose";

/// Delay of the picture behind the newest frame, in frame intervals: with it there is nearly always
/// a frame on either side to interpolate between.
const kDelayIntervals = 1.5;
/// Interval at 30 Hz, the gateway's default, and the least delay's: faster frames do not arrive
/// more evenly [s].
const kUsualIntervalS = 1 / 30;
/// Older frames are dropped [s].
const kKeepS = 1;
/// After a gap this long a tool jumps: a slow glide would show a motion that never happened [s].
const kGapS = 0.5;

/// A frame later than this, or late for longer than this, shows that the clocks have diverged, not
/// that this page was busy [s].
const kPartedS = 10;
const kLateForS = 3;

/// Maps a sender's clock to this page's, using the frame that arrived fastest; forgets slowly, to
/// follow a drifting clock.  Frames that waited while the page was busy keep their true intervals.
export class StreamClock {
  private offset: number | undefined;
  private lastArrivalS = 0;
  private lateSinceS: number | undefined;

  /// Returns the estimated local time at which a frame stamped `stampS` and received at
  /// `arrivalS` was sent.
  toLocal(stampS: number, arrivalS: number): number {
    const offset = arrivalS - stampS;
    const late = offset - (this.offset ?? offset);
    const elapsed = Math.max(0, arrivalS - this.lastArrivalS);
    this.lastArrivalS = arrivalS;
    if (late < kGapS) {
      this.lateSinceS = undefined;
      this.offset = Math.min(offset, (this.offset ?? offset) + 0.01 * elapsed);
    } else {
      this.lateSinceS ??= arrivalS;
      if (late > kPartedS || arrivalS - this.lateSinceS > kLateForS) this.offset = offset;
    }
    return stampS + this.offset!;
  }
}

/// The frames of one station, and its interpolated state at any moment between
/// them.  Never extrapolates.
export class PoseTrack {
  private readonly frames: {timeS: number; state: ToolState}[] = [];
  private intervalS = kUsualIntervalS;

  clear(): void {
    this.frames.length = 0;
  }

  push(timeS: number, state: ToolState): void {
    const last = this.frames.at(-1);
    if (last && timeS <= last.timeS) {
      // Out of order, or the same moment: the newer sample wins, and time never goes back.
      if (state.poseSequence < last.state.poseSequence && timeS > last.timeS - kGapS) return;
      this.frames.length = 0;
    } else if (last && timeS - last.timeS < kGapS) {
      this.intervalS += 0.1 * (timeS - last.timeS - this.intervalS);
    }
    this.frames.push({timeS, state});
    while (this.frames[1] && this.frames[1].timeS < timeS - kKeepS) this.frames.shift();
  }

  get latest(): ToolState | undefined {
    return this.frames.at(-1)?.state;
  }
  /// Delay of the picture behind the newest frame [s].
  get delayS(): number {
    return kDelayIntervals * Math.max(kUsualIntervalS, this.intervalS);
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
    if (b.timeS - a.timeS > kGapS) return a.state;
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
    moved: b.moved.map((pose, i) => mixPose(a.moved[i] ?? pose, pose, t)),
  };
}

/// Smaller changes are invisible [m, N, N m, and quaternion components].
const kVisible = 1e-7;

/// All values of a state that a picture shows.
function numbersOf(state: ToolState): number[] {
  const {haptic, graphic, forceN, torqueNm, points, buttons} = state;
  const contacts = points.flatMap((point) => [point.positionM, point.forceN]);
  const poses = [haptic, graphic, ...state.moved].flatMap(({p, q}) => [p, q]);
  return [...poses, forceN, torqueNm, ...contacts, buttons].flat();
}

/// Returns whether both states give the same picture.
export function looksTheSame(a: ToolState | undefined, b: ToolState | undefined): boolean {
  if (a === b) return true;
  if (a?.tool !== b?.tool || !a || !b) return false;
  const [x, y] = [numbersOf(a), numbersOf(b)];
  return x.length === y.length && x.every((value, i) => Math.abs(value - y[i]!) < kVisible);
}
