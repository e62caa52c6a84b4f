import {
  kStillBur,
  type LoopStatistics,
  type SessionState,
  type StationStatistics,
  type ToolState,
} from "../protocol/messages";
import {History} from "./history";
import {norm} from "../base/pose";
import {PoseTrack, StreamClock} from "./pose_track";
import {handPastM, holdsTool} from "./words";

/// Length of the plots [s].
export const kHistoryS = 12;
/// A station silent for this long does not move its tool [s].
const kAliveS = 1.5;

/// Stations report on their arms once a second.
const kDeviceAliveS = 3;

/// The columns of a station's history after the time.
export const kFigures = ["force", "torque", "past", "step"] as const;

/// What is known of a station: where its tool is, its figures and its session.
export class Station {
  readonly track = new PoseTrack();
  readonly history = new History(kFigures.length, kHistoryS);
  statistics: LoopStatistics | undefined;
  private device: StationStatistics | undefined;
  private deviceS = -Infinity;
  session: SessionState | undefined;
  private run: string | undefined; // of its last session
  private isNew = false; // nothing of that run has come yet
  lastArrivalS = -Infinity;
  private heldS = -Infinity;
  frames = 0;
  private readonly clock = new StreamClock();

  constructor(readonly id: string) {}

  begin(session: SessionState): void {
    if (this.run !== undefined && this.run !== session.run) this.isNew = true;
    this.run = session.run;
    this.session = session;
  }
  /// The newest state of its present run, which begins anew wherever the former one left its tool.
  get own(): ToolState | undefined {
    return this.isNew ? undefined : this.track.latest;
  }

  /// @param recordedS  recorded time, if this is a replay
  push(state: ToolState, stampS: number, nowS: number, recordedS?: number): void {
    const timeS = this.clock.toLocal(stampS, nowS);
    const before = this.track.latest;
    if (before && (before.scene !== state.scene || before.tool !== state.tool)) {
      // Another tool's path leads nowhere here, and its forces are no part of these.
      this.track.clear();
      this.history.clear();
    }
    this.track.push(timeS, state);
    this.isNew = false;
    this.lastArrivalS = nowS;
    this.frames += 1;
    this.keep(state, recordedS ?? timeS);
  }

  /// A paused replay moves no tool, yet its tool does not count as left alone, unless nobody held
  /// it at that moment.
  hold(nowS: number): void {
    if (this.isMoving(nowS) && this.holdsTool) this.heldS = nowS;
  }

  /// Clears the plots, which continue at a recorded time if there is one.
  /// @param sinceS  data sent after this moment already belongs there
  restartHistory(recordedS: number | undefined, sinceS: number): void {
    this.history.clear();
    const latest = this.track.latest;
    if (recordedS === undefined || !latest || this.lastArrivalS < sinceS) return;
    this.keep(latest, recordedS);
  }

  private keep(state: ToolState, timeS: number): void {
    this.history.push(
      timeS,
      norm(state.forceN),
      1000 * norm(state.torqueNm),
      1000 * handPastM(state),
      state.stepUs,
    );
  }

  pushDevice(statistics: StationStatistics, nowS: number): void {
    this.device = statistics;
    this.deviceS = nowS;
  }
  /// Returns the last report on the station's arm; undefined if neither tool states nor reports
  /// arrive any more.
  deviceNow(nowS: number): StationStatistics | undefined {
    return this.isMoving(nowS) || nowS - this.deviceS < kDeviceAliveS ? this.device : undefined;
  }

  isMoving(nowS: number): boolean {
    return nowS - Math.max(this.lastArrivalS, this.heldS) < kAliveS;
  }
  /// Returns the state for the picture: a little in the past, between two frames.  A tool that
  /// nothing moves any more stays where it was, without forces.
  shown(nowS: number): ToolState | undefined {
    const state = this.track.at(nowS - this.track.delayS);
    return state && !this.isMoving(nowS) ? atRest(state) : state;
  }
  /// Returns whether there are frames that the picture has not reached.
  isCatchingUp(nowS: number): boolean {
    return this.track.latestTimeS > nowS - this.track.delayS;
  }
  get scene(): string {
    return this.track.latest?.scene ?? this.session?.scene ?? this.statistics?.scene ?? "";
  }
  /// It has a session that has neither ended nor been refused.
  get isHere(): boolean {
    return this.session !== undefined && !["ended", "refused"].includes(this.session.phase);
  }
  get holdsTool(): boolean {
    return this.session !== undefined && holdsTool(this.session);
  }
}

const atRest = (state: ToolState): ToolState => ({
  ...state,
  haptic: state.graphic,
  forceN: [0, 0, 0],
  torqueNm: [0, 0, 0],
  contacts: 0,
  points: [],
  buttons: kStillBur,
});
