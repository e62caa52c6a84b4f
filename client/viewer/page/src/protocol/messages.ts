import type {Pose, Quat, Vec3} from "../model/pose";

/// What travels, as the page uses it: idl/teaching.idl, idl/session.idl and idl/replay.idl.  A field that the
/// sender does not have is zero or empty: an older server is no obstacle.

export interface ContactPoint {
  readonly positionM: Vec3; // in W
  readonly forceN: Vec3; // of the object on the tool, in W
}

export interface ToolState {
  readonly station: string;
  readonly scene: string;
  readonly tool: string;
  readonly poseSequence: number;
  readonly haptic: Pose; // X_WH
  readonly graphic: Pose; // X_WG
  readonly forceN: Vec3;
  readonly torqueNm: Vec3;
  readonly stepUs: number;
  readonly contacts: number;
  readonly points: readonly ContactPoint[];
}

export interface LoopStatistics {
  readonly station: string;
  readonly scene: string;
  readonly steps: number;
  readonly rateHz: number;
  readonly stepUs: {
    readonly p50: number;
    readonly p99: number;
    readonly p999: number;
    readonly max: number;
  };
  readonly late: number;
  readonly lost: number;
  readonly rejected: number;
  readonly faultedSteps: number;
  readonly faults: number;
}

/// What a station's program says of its arm: the last second's, in calls of its wrench limiter where
/// a stage is named (devices/wrench_limiter.h).
export interface StationStatistics {
  readonly station: string;
  readonly device: string;
  readonly ticks: number;
  readonly replies: number;
  readonly late: number;
  readonly lost: number;
  readonly silenceS: number; // the longest
  readonly limiter: Readonly<Record<LimiterStage, number>>;
  readonly wantedForceN: number; // the most
  readonly appliedForceN: number;
  readonly energyJ: number; // since the start, as the next
  readonly energyLeastJ: number;
  readonly warmth: number;
  readonly deviceStatus: number;
}
export const kLimiterStages = [
  "nonfinite",
  "clamped",
  "slewed",
  "braked",
  "warm",
  "faded",
  "disabled",
] as const;
export type LimiterStage = (typeof kLimiterStages)[number];

const kPhases = ["waiting", "acquiring", "active", "refused", "ended", "held"] as const;
export type SessionPhase = (typeof kPhases)[number];

export interface SessionState {
  readonly station: string;
  readonly serverRun: string;
  readonly phase: SessionPhase;
  readonly muted: boolean; // its forces are held at zero
  readonly scene: string;
  readonly tool: string;
  readonly reason: string;
  readonly startDepthM: number;
}

export interface SceneChange {
  readonly scene: string;
  readonly change: number;
  readonly serverRun: string;
  readonly objectIndex: number;
  readonly leaf: number;
  readonly triangles: readonly number[];
}

/// A worn scene has been made whole, or why it has not.
export interface SceneWhole {
  readonly scene: string;
  readonly serverRun: string;
  readonly lastChange: number; // changes up to this one are undone
  readonly request: string;
  readonly by: string;
  readonly refusal: string;
}

/// What a teacher has set for a scene, for everybody who looks at it.
export interface SceneGoal {
  readonly scene: string;
  readonly text: string;
  readonly limitN: number; // 0: none
}

/// What became of the page's own wish to take a tool.
export interface MouseState {
  readonly station: string;
  readonly phase: SessionPhase | "";
  readonly reason: string;
}

export const kMarkKinds = ["bookmark", "session", "contact", "fault", "whole"] as const;
export type MarkKind = (typeof kMarkKinds)[number];

export interface ReplayMark {
  readonly atS: number; // from the recording's beginning, as all that follow
  readonly number: number; // of a bookmark
  readonly kind: MarkKind;
  readonly text: string;
}
export interface ReplayGap {
  readonly fromS: number;
  readonly toS: number;
  readonly station: string;
  readonly reason: string;
}
/// What is played.
export interface ReplayContents {
  readonly replay: string;
  readonly recording: string;
  readonly begunS: number; // wall clock, since 1970
  readonly lengthS: number;
  readonly locked: boolean;
  readonly marks: readonly ReplayMark[]; // by time
  readonly gaps: readonly ReplayGap[];
}
export interface ReplayState {
  readonly replay: string;
  readonly atS: number;
  readonly rate: number;
  readonly sought: number; // of the way to where it was sent
  readonly playing: boolean;
  readonly ended: boolean;
  readonly request: string; // that it answered last
  readonly refusal: string;
}
/// The gateway's word on a wish of this page.
export interface ReplayAnswer {
  readonly tag: number;
  readonly request: string;
  readonly refusal: string;
}

/// A decoded message, field by field.
class Fields {
  private readonly fields: Readonly<Record<string, unknown>>;

  constructor(value: unknown) {
    this.fields = typeof value === "object" && value !== null ? {...value} : {};
  }
  number(name: string): number {
    const value = this.fields[name];
    return typeof value === "number" || typeof value === "bigint" ? Number(value) : 0;
  }
  flag(name: string): boolean {
    return this.fields[name] === true;
  }
  text(name: string): string {
    const value = this.fields[name];
    return typeof value === "string" ? value : "";
  }
  /// 64 bits that are a name and not a quantity.
  id(name: string): string {
    const value = this.fields[name];
    return typeof value === "bigint" || typeof value === "number" ? value.toString(16) : "0";
  }
  numbers(name: string): readonly number[] {
    const value = this.fields[name];
    if (value instanceof Float64Array || value instanceof Uint32Array) return Array.from(value);
    return Array.isArray(value) ? value.map(Number) : [];
  }
  vec3(name: string): Vec3 {
    const [x = 0, y = 0, z = 0] = this.numbers(name);
    return [x, y, z];
  }
  quat(name: string): Quat {
    const [w = 1, x = 0, y = 0, z = 0] = this.numbers(name);
    return [w, x, y, z];
  }
  items(name: string): readonly Fields[] {
    const value = this.fields[name];
    return Array.isArray(value) ? value.map((item) => new Fields(item)) : [];
  }
}

export function toToolState(value: unknown): ToolState {
  const fields = new Fields(value);
  const points = fields.items("point").slice(0, fields.number("points"));
  return {
    station: fields.text("station"),
    scene: fields.text("scene"),
    tool: fields.text("tool"),
    poseSequence: fields.number("pose_sequence"),
    haptic: {p: fields.vec3("haptic_position_m"), q: fields.quat("haptic_orientation_wxyz")},
    graphic: {p: fields.vec3("graphic_position_m"), q: fields.quat("graphic_orientation_wxyz")},
    forceN: fields.vec3("force_N"),
    torqueNm: fields.vec3("torque_Nm"),
    stepUs: fields.number("step_us"),
    contacts: fields.number("contacts"),
    points: points.map((point) => ({
      positionM: point.vec3("position_m"),
      forceN: point.vec3("force_N"),
    })),
  };
}

export function toLoopStatistics(value: unknown): LoopStatistics {
  const fields = new Fields(value);
  return {
    station: fields.text("station"),
    scene: fields.text("scene"),
    steps: fields.number("steps"),
    rateHz: fields.number("rate_hz"),
    stepUs: {
      p50: fields.number("step_us_p50"),
      p99: fields.number("step_us_p99"),
      p999: fields.number("step_us_p999"),
      max: fields.number("step_us_max"),
    },
    late: fields.number("late"),
    lost: fields.number("lost"),
    rejected:
      fields.number("rejected_nonfinite") +
      fields.number("rejected_sequence") +
      fields.number("rejected_speed"),
    faultedSteps: fields.number("faulted_steps"),
    faults: fields.number("faults"),
  };
}

export function toStationStatistics(value: unknown): StationStatistics {
  const fields = new Fields(value);
  const stages = kLimiterStages.map((stage) => [stage, fields.number(stage)]);
  return {
    station: fields.text("station"),
    device: fields.text("device"),
    ticks: fields.number("ticks"),
    replies: fields.number("replies"),
    late: fields.number("late"),
    lost: fields.number("lost"),
    silenceS: fields.number("silence_s_max"),
    limiter: Object.fromEntries(stages) as Record<LimiterStage, number>,
    wantedForceN: fields.number("wanted_force_N_max"),
    appliedForceN: fields.number("applied_force_N_max"),
    energyJ: fields.number("energy_J"),
    energyLeastJ: fields.number("energy_J_min"),
    warmth: fields.number("warmth"),
    deviceStatus: fields.number("device_status"),
  };
}

export function toSessionState(value: unknown): SessionState {
  const fields = new Fields(value);
  return {
    station: fields.text("station"),
    serverRun: fields.id("server_run"),
    phase: kPhases[fields.number("phase")] ?? "ended",
    muted: fields.flag("muted"),
    scene: fields.text("scene"),
    tool: fields.text("tool"),
    reason: fields.text("reason"),
    startDepthM: fields.number("start_depth_m"),
  };
}

export function toSceneChange(value: unknown): SceneChange {
  const fields = new Fields(value);
  return {
    scene: fields.text("scene"),
    change: fields.number("change"),
    serverRun: fields.id("server_run"),
    objectIndex: fields.number("object_index"),
    leaf: fields.number("leaf"),
    triangles: fields.numbers("triangle").slice(0, fields.number("triangles")),
  };
}

export function toSceneWhole(value: unknown): SceneWhole {
  const fields = new Fields(value);
  return {
    scene: fields.text("scene"),
    serverRun: fields.id("server_run"),
    lastChange: fields.number("last_change"),
    request: fields.id("request"),
    by: fields.text("by"),
    refusal: fields.text("refusal"),
  };
}

export function toSceneGoal(value: unknown): SceneGoal {
  const fields = new Fields(value);
  return {
    scene: fields.text("scene"),
    text: fields.text("text"),
    limitN: fields.number("limit_N"),
  };
}

export function toMouseState(value: unknown): MouseState {
  const fields = new Fields(value);
  const phase = fields
    .text("phase")
    .toLowerCase()
    .replace(/^session_/, "");
  return {
    station: fields.text("station"),
    phase: kPhases.find((known) => known === phase) ?? "",
    reason: fields.text("reason"),
  };
}

export function toReplayContents(value: unknown): ReplayContents {
  const fields = new Fields(value);
  return {
    replay: fields.text("replay"),
    recording: fields.text("recording"),
    begunS: fields.number("begun_s"),
    lengthS: fields.number("length_s"),
    locked: fields.flag("locked"),
    marks: fields.items("marks").map((mark) => ({
      atS: mark.number("at_s"),
      number: mark.number("number"),
      kind: kMarkKinds.find((known) => known === mark.text("kind")) ?? "session",
      text: mark.text("text"),
    })),
    gaps: fields.items("gaps").map((gap) => ({
      fromS: gap.number("from_s"),
      toS: gap.number("to_s"),
      station: gap.text("station"),
      reason: gap.text("reason"),
    })),
  };
}

export function toReplayState(value: unknown): ReplayState {
  const fields = new Fields(value);
  return {
    replay: fields.text("replay"),
    atS: fields.number("at_s"),
    rate: fields.number("rate"),
    sought: fields.number("sought"),
    playing: fields.flag("playing"),
    ended: fields.flag("ended"),
    request: fields.text("request"),
    refusal: fields.text("refusal"),
  };
}

export function toReplayAnswer(value: unknown): ReplayAnswer {
  const fields = new Fields(value);
  return {
    tag: fields.number("tag"),
    request: fields.text("request"),
    refusal: fields.text("refusal"),
  };
}
