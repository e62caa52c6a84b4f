import {
  type LoopStatistics,
  type SessionState,
  toLoopStatistics,
  toSceneChange,
  toSessionState,
  type ToolState,
  toToolState,
} from "../protocol/messages";
import {History} from "./history";
import {norm} from "./pose";
import {kDelayS, PoseTrack, StreamClock} from "./pose_track";
import {Remains} from "./remains";
import {depthM, holdsTool} from "./words";

export const kTopics = {
  toolState: "/palpate/tool_state",
  loopStatistics: "/palpate/loop_statistics",
  sessionState: "/palpate/session_state",
  sceneChange: "/palpate/scene_change",
  mouse: "/palpate/mouse",
  mouseState: "/palpate/mouse_state",
} as const;

/// Seconds that the plots look back.
export const kHistoryS = 12;
/// A station that has been silent for this long does not move its tool [s].
const kAliveS = 1.5;

/// The figures that a station's history keeps, in this order.
export const kFigures = ["force", "torque", "depth", "step"] as const;

export class Station {
  readonly track = new PoseTrack();
  readonly history = new History(kFigures.length, kHistoryS);
  statistics: LoopStatistics | undefined;
  session: SessionState | undefined;
  lastArrivalS = -Infinity;
  frames = 0;
  private readonly clock = new StreamClock();

  constructor(readonly id: string) {}

  push(state: ToolState, stampS: number, nowS: number): void {
    const timeS = this.clock.toLocal(stampS, nowS);
    this.track.push(timeS, state);
    this.lastArrivalS = nowS;
    this.frames += 1;
    this.history.push(
      timeS,
      norm(state.forceN),
      1000 * norm(state.torqueNm),
      1000 * depthM(state),
      state.stepUs,
    );
  }

  isMoving(nowS: number): boolean {
    return nowS - this.lastArrivalS < kAliveS;
  }
  /// The picture's state now: a little in the past, between two frames.
  shown(nowS: number): ToolState | undefined {
    return this.track.at(nowS - kDelayS);
  }
  /// True while there are frames that the picture has not reached.
  isCatchingUp(nowS: number): boolean {
    return this.track.latestTimeS > nowS - kDelayS;
  }
  get scene(): string {
    return this.track.latest?.scene ?? this.session?.scene ?? this.statistics?.scene ?? "";
  }
  get holdsTool(): boolean {
    return this.session !== undefined && holdsTool(this.session);
  }
}

/// What changed, so that only that is drawn anew.
export type Change = "tool" | "sessions" | "statistics" | "scenes" | "remains" | "serverRun";

/// Everything that the gateway has told.  Knows no socket and no screen.
export class World {
  readonly stations = new Map<string, Station>();
  readonly scenes = new Map<string, Remains>(); // by name: what is left of each
  lastStateS = -Infinity;

  constructor(private readonly changed: (change: Change, scene: string) => void) {}

  receive(topic: string, value: unknown, stampS: number, nowS: number): void {
    switch (topic) {
      case kTopics.toolState:
        this.receiveToolState(toToolState(value), stampS, nowS);
        break;
      case kTopics.loopStatistics: {
        const statistics = toLoopStatistics(value);
        this.station(statistics.station).statistics = statistics;
        this.changed("statistics", statistics.scene);
        break;
      }
      case kTopics.sessionState:
        this.receiveSession(toSessionState(value));
        break;
      case kTopics.sceneChange: {
        const change = toSceneChange(value);
        this.addScene(change.scene);
        this.scenes.get(change.scene)?.apply(change);
        this.changed("remains", change.scene);
        break;
      }
    }
  }

  addScene(name: string): void {
    if (name === "" || this.scenes.has(name)) return;
    this.scenes.set(name, new Remains());
    this.changed("scenes", name);
  }

  /// A new link: who drives what is told again from the start, by whoever is there now.
  forgetSessions(): void {
    for (const station of this.stations.values()) station.session = undefined;
    this.changed("sessions", "");
  }

  /// The stations that are of use to look at, those with a tool first.
  listed(nowS: number): Station[] {
    const listed = [...this.stations.values()].filter(
      (station) => station.holdsTool || station.isMoving(nowS) || station.session !== undefined,
    );
    const rank = (station: Station): number =>
      station.holdsTool || station.isMoving(nowS) ? 0 : 1;
    return listed.sort((a, b) => rank(a) - rank(b) || a.id.localeCompare(b.id));
  }

  holderOf(scene: string, tool: string): Station | undefined {
    for (const station of this.stations.values()) {
      const session = station.session;
      if (station.holdsTool && session?.scene === scene && session.tool === tool) return station;
    }
    return undefined;
  }

  /// Who moved a tool last.
  lastMoverOf(scene: string, tool: string): Station | undefined {
    let mover: Station | undefined;
    for (const station of this.stations.values()) {
      const state = station.track.latest;
      if (state?.scene !== scene || state.tool !== tool) continue;
      if (!mover || station.lastArrivalS > mover.lastArrivalS) mover = station;
    }
    return mover;
  }

  private receiveToolState(state: ToolState, stampS: number, nowS: number): void {
    this.station(state.station).push(state, stampS, nowS);
    this.lastStateS = nowS;
    this.addScene(state.scene);
    this.changed("tool", state.scene);
  }

  private receiveSession(session: SessionState): void {
    this.station(session.station).session = session;
    if (session.phase !== "refused") {
      this.addScene(session.scene);
      const remains = this.scenes.get(session.scene);
      if (remains?.startRun(session.serverRun)) {
        this.changed("remains", session.scene);
        this.changed("serverRun", session.scene);
      }
    }
    this.changed("sessions", session.scene);
  }

  private station(id: string): Station {
    let station = this.stations.get(id);
    if (!station) this.stations.set(id, (station = new Station(id)));
    return station;
  }
}
