import {mixPose, norm, type Pose, subtract, type Vec3} from "../base/pose";

/// Distances of the hand from the guide: up to the first the guide moves at the expert's pace, from
/// the second on it waits (client/replayer/guide).
const [kNearM, kFarM] = [0.005, 0.015];
const kLongestStepS = 0.1; // after the page was hidden, the guide does not catch up

/// The expert's motion: keys [t, x, y, z, qw, qx, qy, qz] in s and m, joined
/// by minimum-jerk motions.
export class Guide {
  private atS = 0;
  private lastS: number | undefined;

  constructor(private readonly keys: readonly (readonly number[])[]) {}

  get isOver(): boolean {
    return this.atS >= (this.keys.at(-1)?.[0] ?? 0);
  }

  /// Returns where the expert's tool is now; it slows down if the hand does not keep up.
  lead(nowS: number, hand: Vec3 | undefined): Pose {
    const aim = this.poseAt(this.atS);
    const behindM = hand ? norm(subtract(hand, aim.p)) : kFarM;
    const share = Math.min(1, Math.max(0, (kFarM - behindM) / (kFarM - kNearM)));
    this.atS += share * Math.min(kLongestStepS, nowS - (this.lastS ?? nowS));
    this.lastS = nowS;
    return this.poseAt(this.atS);
  }

  poseAt(t: number): Pose {
    const next = this.keys.findIndex((key) => key[0]! > t);
    const to = next < 0 ? this.keys.length - 1 : next;
    const [a, b] = [this.keys[Math.max(0, to - 1)]!, this.keys[to]!];
    const u = Math.min(1, Math.max(0, (t - a[0]!) / (b[0]! - a[0]! || 1)));
    return mixPose(toPose(a), toPose(b), u ** 3 * (10 + u * (6 * u - 15)));
  }
}

const toPose = (key: readonly number[]): Pose => ({
  p: [key[1]!, key[2]!, key[3]!],
  q: [key[4]!, key[5]!, key[6]!, key[7]!],
});
