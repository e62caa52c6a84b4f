import type {Pose, Quat, Vec3} from "../base/pose";

/// The messages of idl/teaching.idl, idl/session.idl, idl/solid.idl and idl/replay.idl, as the page
/// uses them.  A field that the sender lacks is zero or empty, so older servers work.

type Fields = Readonly<Record<string, unknown>>;
type Read<T> = (fields: Fields) => T;

const number =
  (name: string): Read<number> =>
  ({[name]: value}) =>
    typeof value === "number" || typeof value === "bigint" ? Number(value) : 0;
const flag =
  (name: string): Read<boolean> =>
  ({[name]: value}) =>
    value === true;
const text =
  (name: string): Read<string> =>
  ({[name]: value}) =>
    typeof value === "string" ? value : "";
/// A 64-bit identifier.
const id =
  (name: string): Read<string> =>
  ({[name]: value}) =>
    typeof value === "bigint" || typeof value === "number" ? value.toString(16) : "0";
const kArrays = [Float32Array, Float64Array, Uint32Array];
const numbers =
  (name: string): Read<readonly number[]> =>
  ({[name]: value}) => {
    if (kArrays.some((type) => value instanceof type)) return Array.from(value as Float64Array);
    return Array.isArray(value) ? value.map(Number) : [];
  };
const vec3 =
  (name: string): Read<Vec3> =>
  (fields) => {
    const [x = 0, y = 0, z = 0] = numbers(name)(fields);
    return [x, y, z];
  };
const poseAt =
  (prefix: string): Read<Pose> =>
  (fields) => {
    const [w = 1, x = 0, y = 0, z = 0] = numbers(`${prefix}orientation_wxyz`)(fields);
    const q: Quat = [w, x, y, z];
    return {p: vec3(`${prefix}position_m`)(fields), q};
  };
const pose = (of: string): Read<Pose> => poseAt(`${of}_`);
const list =
  <T>(name: string, toItem: (value: unknown) => T): Read<readonly T[]> =>
  ({[name]: value}) =>
    Array.isArray(value) ? value.map(toItem) : [];

type Message<R> = {readonly [Name in keyof R]: R[Name] extends Read<infer T> ? T : never};

/// Reads a decoded message field by field, whatever its type.
const message =
  <R extends Readonly<Record<string, Read<unknown>>>>(readers: R) =>
  (value: unknown): Message<R> => {
    const fields = typeof value === "object" && value !== null ? (value as Fields) : {};
    const read = Object.entries(readers).map(([name, reader]) => [name, reader(fields)]);
    return Object.fromEntries(read) as Message<R>;
  };

const toContactPoint = message({
  positionM: vec3("position_m"), // in W
  forceN: vec3("force_N"), // force of the object on the tool, in W
});
export type ContactPoint = ReturnType<typeof toContactPoint>;

const kNowhere: readonly Pose[] = [];

export const toToolState = message({
  station: text("station"),
  scene: text("scene"),
  tool: text("tool"),
  poseSequence: number("pose_sequence"),
  haptic: pose("haptic"), // X_WH
  graphic: pose("graphic"), // X_WG
  forceN: vec3("force_N"),
  torqueNm: vec3("torque_Nm"),
  stepUs: number("step_us"),
  contacts: number("contacts"),
  buttons: number("buttons"),
  points: (fields): readonly ContactPoint[] =>
    list("point", toContactPoint)(fields).slice(0, number("points")(fields)),
  /// Of the scene's groups that move, from MovedState: relative to where their objects are placed.
  moved: () => kNowhere,
});
export type ToolState = ReturnType<typeof toToolState>;
/// Bit of its buttons while which a bur stands still.
export const kStillBur = 2;
export const burTurns = ({buttons}: ToolState): boolean => (buttons & kStillBur) === 0;

const toBodyPose = message({pose: poseAt("")});
export const toMovedState = message({
  scene: text("scene"),
  moved: list("moved", (value) => toBodyPose(value).pose),
});

export const toLoopStatistics = message({
  station: text("station"),
  scene: text("scene"),
  steps: number("steps"),
  rateHz: number("rate_hz"),
  stepUs: message({
    p50: number("step_us_p50"),
    p99: number("step_us_p99"),
    p999: number("step_us_p999"),
    max: number("step_us_max"),
  }),
  late: number("late"),
  lost: number("lost"),
  rejected: (fields) =>
    number("rejected_nonfinite")(fields) +
    number("rejected_sequence")(fields) +
    number("rejected_speed")(fields),
  faultedSteps: number("faulted_steps"),
  faults: number("faults"),
});
export type LoopStatistics = ReturnType<typeof toLoopStatistics>;

const kLimiter = {
  nonfinite: number("nonfinite"),
  clamped: number("clamped"),
  slewed: number("slewed"),
  braked: number("braked"),
  warm: number("warm"),
  faded: number("faded"),
  disabled: number("disabled"),
};
export type LimiterStage = keyof typeof kLimiter;
export const kLimiterStages = Object.keys(kLimiter) as readonly LimiterStage[];

/// A station's report on its arm over the last second; where a stage is named, in calls of its
/// wrench limiter (devices/wrench_limiter.h).
export const toStationStatistics = message({
  station: text("station"),
  device: text("device"),
  ticks: number("ticks"),
  replies: number("replies"),
  late: number("late"),
  lost: number("lost"),
  silenceS: number("silence_s_max"),
  limiter: message(kLimiter),
  wantedForceN: number("wanted_force_N_max"),
  appliedForceN: number("applied_force_N_max"),
  energyJ: number("energy_J"), // since the start, like the next one
  energyLeastJ: number("energy_J_min"),
  warmth: number("warmth"),
  deviceStatus: number("device_status"),
});
export type StationStatistics = ReturnType<typeof toStationStatistics>;

const kPhases = ["waiting", "acquiring", "active", "refused", "ended", "held"] as const;
export type SessionPhase = (typeof kPhases)[number];

export const toSessionState = message({
  station: text("station"),
  run: id("run"), // of the station's request
  serverRun: id("server_run"),
  phase: (fields): SessionPhase => kPhases[number("phase")(fields)] ?? "ended",
  muted: flag("muted"), // its forces are held at zero
  scene: text("scene"),
  tool: text("tool"),
  reason: text("reason"),
  startDepthM: number("start_depth_m"),
});
export type SessionState = ReturnType<typeof toSessionState>;

/// The remaining part of a block of an object's grid.
export const toSolidBlock = message({
  scene: text("scene"),
  objectIndex: number("object_index"),
  block: number("block"),
  change: number("change"),
  serverRun: id("server_run"),
  originM: vec3("origin_m"), // origin of the grid, in the object's frame
  spacingM: number("spacing_m"),
  blocks: vec3("blocks"),
  cut: flag("cut"),
  removedMm3: numbers("removed_mm3"), // of each material of the object
  surface: ({surface}): Uint8Array => (surface instanceof Uint8Array ? surface : new Uint8Array()),
});
export type SolidBlock = ReturnType<typeof toSolidBlock>;

/// In the order of their numbers in messages.
const kWholeWishes = ["whole", "bookmark", "back"] as const;
export type WholeWish = (typeof kWholeWishes)[number];

/// The answer to WholeWish: the scene was restored, or a bookmark set, or why not.
export const toSceneWhole = message({
  wish: (fields): WholeWish => kWholeWishes[number("wish")(fields)] ?? "whole",
  hasBookmark: flag("has_bookmark"),
  scene: text("scene"),
  serverRun: id("server_run"),
  lastChange: number("last_change"), // changes up to this one are undone
  by: text("by"),
  refusal: text("refusal"),
});
export type SceneWhole = ReturnType<typeof toSceneWhole>;

/// A teacher's goal for a scene, for all of its viewers.
export const toSceneGoal = message({
  scene: text("scene"),
  text: text("text"),
  limitN: number("limit_N"), // 0: none
});
export type SceneGoal = ReturnType<typeof toSceneGoal>;

/// The state of the page's own request for a tool.
export const toMouseState = message({
  station: text("station"),
  scene: text("scene"),
  tool: text("tool"),
  phase: (fields): SessionPhase | "" =>
    kPhases.find((known) => known === text("phase")(fields)) ?? "",
  reason: text("reason"),
});
export type MouseState = ReturnType<typeof toMouseState>;

export const kMarkKinds = ["bookmark", "session", "contact", "fault", "whole"] as const;
export type MarkKind = (typeof kMarkKinds)[number];

const toReplayMark = message({
  atS: number("at_s"), // from the recording's beginning, like all that follow
  number: number("number"), // of a bookmark
  kind: (fields): MarkKind =>
    kMarkKinds.find((known) => known === text("kind")(fields)) ?? "session",
  text: text("text"),
});
export type ReplayMark = ReturnType<typeof toReplayMark>;

const toReplayGap = message({
  fromS: number("from_s"),
  toS: number("to_s"),
  station: text("station"),
  reason: text("reason"),
});
export type ReplayGap = ReturnType<typeof toReplayGap>;

/// What is being played.
export const toReplayContents = message({
  replay: text("replay"),
  recording: text("recording"),
  begunS: number("begun_s"), // wall-clock time since 1970
  lengthS: number("length_s"),
  locked: flag("locked"),
  marks: list("marks", toReplayMark), // sorted by time
  gaps: list("gaps", toReplayGap),
});
export type ReplayContents = ReturnType<typeof toReplayContents>;

export const toReplayState = message({
  replay: text("replay"),
  atS: number("at_s"),
  rate: number("rate"),
  sought: number("sought"), // progress towards the requested position
  playing: flag("playing"),
  ended: flag("ended"),
  request: text("request"), // the last request answered
  refusal: text("refusal"),
});
export type ReplayState = ReturnType<typeof toReplayState>;

/// The gateway's answer to a request of this page.
export const toReplayAnswer = message({
  tag: number("tag"),
  request: text("request"),
  refusal: text("refusal"),
});
export type ReplayAnswer = ReturnType<typeof toReplayAnswer>;
