import {
  type ReplayState,
  type SceneGoal,
  type SceneWhole,
  type SessionState,
  type SolidBlock,
  toLoopStatistics,
  toMovedState,
  toReplayContents,
  toReplayState,
  toSceneGoal,
  toSceneWhole,
  toSessionState,
  toSolidBlock,
  toStationStatistics,
  type ToolState,
  toToolState,
} from "../protocol/messages";
import type {Pose} from "../base/pose";
import type {Compiling, Health} from "../protocol/health";
import {Remains} from "./remains";
import {Replay} from "./replay";
import {Station} from "./station";

/// No server is known yet.
const kNoRun = "0";

type Receiver = (value: unknown, stampS: number, nowS: number) => void;

/// What has changed, so that only that is redrawn.
export type Change = "tool" | "scenes" | "remains" | "whole" | "goal" | "replay" | "serverRun";

/// Everything that the gateway has reported.  Knows neither socket nor screen.
export class World {
  readonly stations = new Map<string, Station>();
  scenes: ReadonlySet<string> = new Set(); // names of the gateway's scenes
  lastStateS = -Infinity;
  serverLives = true; // according to the gateway
  compiling: Compiling | undefined; // by a server that does not serve yet
  readonly replay = new Replay();
  private readonly remains = new Map<string, Remains>(); // by scene
  private readonly moved = new Map<string, readonly Pose[]>(); // by scene
  /// By scene: the teacher's goal, and the last message about restoring it.
  readonly goals = new Map<string, SceneGoal>();
  readonly wholes = new Map<string, SceneWhole>();
  private nowS = -Infinity; // when a message last arrived
  private serverRun = "";
  private readonly formerRuns = new Set<string>();
  private damaged = false; // a block was damaged

  constructor(private readonly changed: (change: Change, scene: string) => void) {}

  /// What to do with a topic's messages.
  private readonly receivers: Readonly<Record<string, Receiver>> = {
    tool_state: (value, stampS, nowS) =>
      this.receiveToolState(this.withMoved(toToolState(value)), stampS, nowS),
    moved_state: (value) => {
      const {scene, moved} = toMovedState(value);
      this.moved.set(scene, moved);
    },
    loop_statistics: (value) => {
      const statistics = toLoopStatistics(value);
      this.station(statistics.station).statistics = statistics;
    },
    station_statistics: (value, _, nowS) => {
      const statistics = toStationStatistics(value);
      this.station(statistics.station).pushDevice(statistics, nowS);
    },
    replay_contents: (value) => {
      this.replay.receiveContents(toReplayContents(value));
      this.changed("replay", "");
    },
    replay_state: (value, stampS, nowS) => this.receiveReplay(toReplayState(value), stampS, nowS),
    session_state: (value) => this.receiveSession(toSessionState(value)),
    goal: (value) => {
      const goal = toSceneGoal(value);
      this.goals.set(goal.scene, goal);
      this.changed("goal", goal.scene);
    },
    solid_block: (value) => {
      const block = toSolidBlock(value);
      if (!this.isOfServer(block.serverRun)) return;
      if (!this.remainsOf(block.scene).cut(block)) this.sayDamaged(block);
      this.changed("remains", block.scene);
    },
    scene_whole: (value) => {
      const whole = toSceneWhole(value);
      if (!this.isOfServer(whole.serverRun)) return;
      this.remainsOf(whole.scene).undo(whole.lastChange);
      this.wholes.set(whole.scene, whole);
      this.changed("whole", whole.scene);
    },
  };

  wants(topic: string): boolean {
    return topic in this.receivers;
  }
  receive(topic: string, value: unknown, stampS: number, nowS: number): void {
    this.nowS = nowS;
    this.receivers[topic]?.(value, stampS, nowS);
  }

  /// Takes the gateway's report: its scenes, and the server that they belong to.
  receiveHealth(health: Health, nowS = this.nowS): void {
    const {scenes} = health;
    this.nowS = nowS;
    this.serverLives = health.server_lives;
    this.compiling = health.compiling ?? undefined;
    if (!this.isOfServer(health.server_run)) return;
    const same =
      scenes.length === this.scenes.size && scenes.every((name) => this.scenes.has(name));
    if (same) return;
    this.scenes = new Set(scenes);
    this.changed("scenes", "");
  }

  /// A new link: the state of all sessions is sent again by the present server.
  startLink(): void {
    this.formerRuns.clear();
    this.forgetSessions();
  }

  /// Returns what has been cut of a scene.
  remainsOf(scene: string): Remains {
    let remains = this.remains.get(scene);
    if (!remains) this.remains.set(scene, (remains = new Remains()));
    return remains;
  }

  /// Returns the stations worth looking at, those with a tool first.
  listed(nowS: number): Station[] {
    const listed = [...this.stations.values()].filter(
      (station) => station.holdsTool || station.isMoving(nowS) || station.session !== undefined,
    );
    const rank = (station: Station): number =>
      station.holdsTool || station.isMoving(nowS) ? 0 : 1;
    return listed.sort((a, b) => rank(a) - rank(b) || a.id.localeCompare(b.id));
  }

  holderOf(scene: string, tool: string): Station | undefined {
    return [...this.stations.values()].find(
      ({holdsTool, session}) => holdsTool && session?.scene === scene && session.tool === tool,
    );
  }

  /// Returns the station that moved a tool last.
  lastMoverOf(scene: string, tool: string): Station | undefined {
    let mover: Station | undefined;
    for (const station of this.stations.values()) {
      const state = station.track.latest;
      if (state?.scene !== scene || state.tool !== tool) continue;
      if (!mover || station.lastArrivalS > mover.lastArrivalS) mover = station;
    }
    return mover;
  }

  /// Once only: more may follow at any rate.
  private sayDamaged({scene, objectIndex, block}: SolidBlock): void {
    if (this.damaged) return;
    this.damaged = true;
    const where = `block ${block} of object ${objectIndex} of the scene ${scene}`;
    console.warn(`The surface of ${where} is damaged and not shown, nor are others that are.`);
  }

  /// What moves is told just before the tool.
  private withMoved(state: ToolState): ToolState {
    const moved = this.moved.get(state.scene);
    return moved ? {...state, moved} : state;
  }

  private receiveToolState(state: ToolState, stampS: number, nowS: number): void {
    const recordedS = this.replay.state && this.replay.timeOf(stampS);
    this.station(state.station).push(state, stampS, nowS, recordedS);
    this.lastStateS = nowS;
    this.changed("tool", state.scene);
  }

  private receiveReplay(state: ReplayState, stampS: number, nowS: number): void {
    const formerS = nowS - this.replay.silenceS(nowS);
    const leapt = this.replay.receiveState(state, stampS, nowS);
    for (const station of this.stations.values()) {
      if (!state.playing) station.hold(nowS);
      if (leapt) station.restartHistory(state.atS, formerS);
    }
    this.changed("replay", "");
  }

  /// Another sender has appeared after a replay ended: what is shown from now on is not the replay.
  private forgetReplay(): void {
    const phase = this.replay.phase(this.nowS);
    if (phase !== "ended" && phase !== "silent") return;
    this.replay.forget();
    for (const station of this.stations.values()) station.restartHistory(undefined, this.nowS);
    this.changed("replay", "");
  }

  private receiveSession(session: SessionState): void {
    if (!this.isOfServer(session.serverRun)) return;
    this.station(session.station).begin(session);
  }

  /// Returns false for a message of a former server.  The first message of a new one clears the
  /// state of its predecessor: sessions, cuts, and scenes if they differ.
  private isOfServer(run: string): boolean {
    if (run === this.serverRun || run === kNoRun) return true;
    if (this.formerRuns.has(run)) return false;
    const former = this.serverRun;
    this.serverRun = run;
    if (former === "") return true;
    this.formerRuns.add(former);
    this.forgetReplay();
    this.wholes.clear();
    this.forgetSessions();
    for (const [scene, remains] of this.remains) {
      remains.clear();
      this.changed("remains", scene);
    }
    this.changed("serverRun", "");
    return true;
  }

  private forgetSessions(): void {
    for (const station of this.stations.values()) station.session = undefined;
  }

  private station(id: string): Station {
    let station = this.stations.get(id);
    if (!station) this.stations.set(id, (station = new Station(id)));
    return station;
  }
}
