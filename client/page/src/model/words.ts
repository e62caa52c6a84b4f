import {nameOf} from "./names";
import {sayReason} from "./reasons";
import {hasText, type Key, locale, say, sayList, sayNumber} from "../messages/say";
import {
  kLimiterStages,
  type LimiterStage,
  type LoopStatistics,
  type ReplayGap,
  type ReplayMark,
  type SessionState,
  type StationStatistics,
  type ToolState,
} from "../protocol/messages";
import type {SceneModel} from "./bundle";
import {norm, subtract} from "../base/pose";

/// The page's sentences, worded for readers who do not know the program.

/// Returns how far the hand is beyond the surface that stops the tool [m].
export const handPastM = (state: ToolState): number =>
  norm(subtract(state.graphic.p, state.haptic.p));

/// At most three significant digits.
export function figure(value: number, digits = 2): string {
  const magnitude = Math.abs(value);
  if (!Number.isFinite(value)) return "–";
  if (magnitude >= 100) return sayNumber(value, 0);
  return sayNumber(value, magnitude >= 10 ? Math.min(1, digits) : digits);
}

/// Formats a share as a percentage.
export const percent = (share: number): string =>
  say("unit.percent", {value: sayNumber(100 * share, 0)});

/// Formats a recorded time as players do: 1:05, 1:02:03.
export function clock(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds + 1e-6));
  const two = (value: number): string => String(value).padStart(2, "0");
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  const rest = two(whole % 60);
  return hours > 0 ? `${hours}:${two(minutes)}:${rest}` : `${minutes}:${rest}`;
}

/// The same for a screen reader.
export function spokenTime(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds + 1e-6));
  const minutes = Math.floor(whole / 60);
  const rest = say("replay.seconds", {count: whole % 60});
  if (minutes === 0) return rest;
  return say("list.sentences", {first: say("replay.minutes", {count: minutes}), second: rest});
}

/// Shortens a text to at most this many bytes, between characters.
export const fitBytes = (text: string, most: number): string =>
  text.slice(0, new TextEncoder().encodeInto(text, new Uint8Array(most)).read);

/// Names a tissue or another part of a scene.
export function partWords(name: string): string {
  const key = `tissue.${name}`;
  return hasText(key) ? say(key) : name.replace(/[-_]/g, " ");
}

/// Names what pushes the tool.
export function touchedWords(names: readonly string[]): string {
  if (names.length === 0) return say("touched.nothing");
  const [first, second] = names.map(partWords);
  if (second === undefined) return first!;
  return names.length === 2
    ? say("touched.two", {first: first!, second})
    : say("touched.more", {first: first!, count: names.length - 1});
}

/// Describes the state in one sentence, for a screen reader.
/// @param probingM  depth of a probe's tip below the gum's margin; undefined: it is no probe
export function statusSentence(state: ToolState | undefined, probingM?: number): string {
  if (!state) return say("sentence.none");
  if (state.contacts === 0) return say("sentence.free");
  const force = figure(norm(state.forceN), 1);
  const past = figure(1000 * handPastM(state), 1);
  if (probingM === undefined) return say("sentence.contact", {force, past});
  return say("sentence.probing", {force, past, depth: figure(1000 * probingM, 1)});
}

/// The faults of common/step_fault.h, with their meaning for the user.
const kFaults: readonly (readonly [number, Key])[] = [
  [1 << 0, "fault.no_pose"],
  [1 << 1, "fault.quick"],
  [1 << 2, "fault.many"],
  [1 << 3, "fault.jammed"],
  [1 << 4, "fault.unsolved"],
  [1 << 5, "fault.effect"],
  [1 << 6, "fault.friction"],
  [1 << 9, "fault.leap"],
  [1 << 10, "fault.inside"],
];

export function faultWords(faults: number): string[] {
  return kFaults.filter(([bit]) => (faults & bit) !== 0).map(([, key]) => say(key));
}

export interface Line {
  readonly label: string;
  readonly value: string;
  readonly remark: string;
  readonly tone: "good" | "plain" | "bad";
}

/// @param isBad  else it is good, or "plain": neither
const line = (
  key: Key,
  value: string,
  remark: string,
  isBad: boolean | "plain" = "plain",
): Line => ({
  label: say(key),
  value,
  remark,
  tone: isBad === "plain" ? isBad : isBad ? "bad" : "good",
});

const kRateHz = 1000;
/// The share of late or missing poses beyond which a load is too much, as in palpate-load.
const kMostAmiss = 0.01;

/// Describes the loop's last second, as lines of a table.
export function statisticsLines(statistics: LoopStatistics): Line[] {
  const {rateHz, steps, late, lost, rejected} = statistics;
  const {p50, p99, p999} = statistics.stepUs;
  const onTime = Math.abs(rateHz - kRateHz) < kMostAmiss * kRateHz;
  const time = (us: number): string =>
    us >= 1000 ? `${figure(us / 1000, 1)} ms` : `${figure(us, 1)} µs`;
  const rate = say("loop.rate_is", {rate: sayNumber(rateHz, 0)});
  const faults = faultWords(statistics.faults);
  const noFault = faults.length === 0;
  // Unused poses had no step.
  const faulted = say(noFault ? "loop.faults_none" : "loop.steps", {
    count: statistics.faultedSteps,
  });
  const poses = (count: number): string => say("loop.poses", {count});
  const lateTone = late > kMostAmiss * steps || (late > 0 ? "plain" : false);
  const slowest = p999 >= 1000;
  return [
    line("loop.rate", rate, say(onTime ? "loop.rate_good" : "loop.rate_bad"), !onTime),
    line("loop.usual", time(p50), say("loop.usual_is")),
    line("loop.slow", time(p99), say("loop.slow_is")),
    line(
      "loop.slower",
      time(p999),
      say(slowest ? "loop.slower_bad" : "loop.slower_is"),
      slowest || "plain",
    ),
    line("loop.late", poses(late), say(late > 0 ? "loop.late_some" : "loop.late_none"), lateTone),
    line("loop.lost", poses(lost), say(lost > 0 ? "loop.lost_some" : "loop.lost_none"), lost > 0),
    ...(rejected > 0
      ? [line("loop.refused", poses(rejected), say("loop.refused_some"), true)]
      : []),
    line("loop.faults", faulted, sayList("list.clauses", faults), noFault ? false : "plain"),
  ];
}

/// Bits of DeviceStatus (devices/device.h).
const kDeviceCalibrating = 1 << 1;
const kDeviceFault = 1 << 2;
const kDeviceForcesIgnored = 1 << 3;

/// Rounding error of summed energies [J].
const kRoundingJ = 1e-6;

function deviceLine({device, deviceStatus}: StationStatistics): Line {
  if (deviceStatus & kDeviceFault) return line("arm.device", say("arm.fault"), device, true);
  if (deviceStatus & kDeviceCalibrating) return line("arm.device", say("arm.calibrates"), device);
  if (deviceStatus & kDeviceForcesIgnored) return line("arm.device", say("arm.ignored"), device);
  return line("arm.device", say("arm.in_order"), device, false);
}

function limiterLine({limiter, ticks}: StationStatistics): Line {
  const share = (stage: LimiterStage): string => {
    const share = limiter[stage] / Math.max(ticks, limiter[stage]);
    return share < 0.01 ? say("arm.less_than_one") : percent(share);
  };
  const acting = kLimiterStages.filter((stage) => limiter[stage] > 0);
  if (acting.length === 0)
    return line("arm.held_back", say("arm.nothing"), say("arm.all_arrives"), false);
  // The stage that acts most of the time comes first.
  acting.sort((a, b) => limiter[b] - limiter[a]);
  const most = acting[0]!;
  // What each stage withholds from the hand, and why.
  const all = acting.map((stage) => {
    const words = say(`arm.${stage}`);
    return stage === most ? words : say("arm.stage_share", {stage: words, share: share(stage)});
  });
  const stages = sayList("list.clauses", all);
  const isBad = limiter.nonfinite > 0 || most === "faded";
  return line("arm.held_back", share(most), say("arm.of_the_time", {stages}), isBad || "plain");
}

function silenceLine({silenceS, replies, late, lost, limiter}: StationStatistics): Line {
  const milliseconds = 1000 * silenceS;
  const value = milliseconds >= 1000 ? `${figure(silenceS, 1)} s` : `${figure(milliseconds, 1)} ms`;
  if (replies === 0) return line("arm.silence", value, say("arm.silence_bad"), true);
  const longest = sayList("list.clauses", [
    say("arm.silence_is"),
    late > 0 ? say("arm.late", {count: late}) : "",
    lost > 0 ? say("arm.lost", {count: lost}) : "",
  ]);
  return line("arm.silence", value, longest, limiter.faded > 0 || "plain");
}

/// Describes how the arm's force was limited in the last second, as lines of a table.
export function deviceLines(device: StationStatistics): Line[] {
  const lines = [deviceLine(device)];
  if (!(device.deviceStatus & kDeviceForcesIgnored)) {
    const {appliedForceN, wantedForceN, warmth, limiter, energyLeastJ, energyJ} = device;
    const active = energyLeastJ < -kRoundingJ;
    const whole = appliedForceN > 0.99 * wantedForceN;
    const strongest = whole
      ? say("arm.as_computed")
      : say("arm.of_computed", {force: `${figure(wantedForceN)} N`});
    const energy = `${figure(1000 * (active ? -energyLeastJ : energyJ), 1)} mJ`;
    lines.push(
      limiterLine(device),
      line("arm.strongest", `${figure(appliedForceN)} N`, strongest),
      line("arm.motors", percent(warmth), say("arm.motors_are"), limiter.warm > 0 || "plain"),
      line(
        "arm.energy",
        energy,
        say(active ? "arm.energy_bad" : "arm.energy_is"),
        active || "plain",
      ),
    );
  }
  lines.push(silenceLine(device));
  return lines;
}

/// Names a mark of a replay, with the replayer's text if it has one.
export function markWords(mark: ReplayMark): string {
  const own = mark.kind === "bookmark" ? mark.text : sayReason(mark.text);
  return own || say(`mark.${mark.kind}`);
}

export function gapWords({station: id, reason}: ReplayGap): string {
  const station = nameOf(id);
  return reason === ""
    ? say("replay.gap", {station})
    : say("replay.gap_because", {station, reason: sayReason(reason)});
}

/// Formats a wall-clock time in seconds since 1970, in the reader's time zone.
export const whenWords = (timeS: number): string =>
  new Date(1000 * timeS).toLocaleString(locale(), {dateStyle: "medium", timeStyle: "short"});

/// Says when a recording was made; empty if that is unknown.
export const recordedWhen = (begunS: number): string =>
  begunS > 0 ? say("replay.recorded", {when: whenWords(begunS)}) : "";

export function sessionWords(session: SessionState): string {
  const {scene, reason} = session;
  const tool =
    session.tool === "" ? say("session.a_tool") : say("session.the_tool", {tool: session.tool});
  const key = `session.${kSessionWords[session.phase]}` as const;
  const depth = figure(1000 * session.startDepthM, 1);
  return say(key, {tool, scene, reason: sayReason(reason), depth});
}
const kSessionWords = {
  ...({active: "drives", refused: "refused", acquiring: "acquiring"} as const),
  ...({waiting: "waits", ended: "left", held: "held"} as const),
} as const;

/// Says what a user who feels or sees a session's forces must know; empty: nothing.
/// @param own  it is this page's session
export function stationNote(session: SessionState | undefined, own: boolean): string {
  if (!session) return "";
  const station = nameOf(session.station);
  if (session.phase === "held") return own ? say("note.you_wait") : say("note.it_waits", {station});
  if (!holdsTool(session)) return "";
  if (session.muted) return own ? say("note.you_muted") : say("note.it_muted", {station});
  if (session.phase === "acquiring")
    return say("note.inside", {depth: figure(1000 * session.startDepthM, 1)});
  return "";
}

/// The same for the teacher who decides about it.
export function consoleWords(session: SessionState): string {
  const what = sessionWords(session);
  return session.muted ? say("session.without_forces", {what}) : what;
}

/// Returns whether a session has its tool.
export const holdsTool = (session: SessionState): boolean =>
  session.phase === "waiting" || session.phase === "acquiring" || session.phase === "active";

/// Describes the picture for a screen reader.
export function pictureWords(model: SceneModel): string {
  const tools = sayList(
    "list.separator",
    model.tools.map(({name}) => name),
  );
  const {length: count} = model.objects;
  const objects = count === 1 ? model.objects[0]!.name : say("stage.objects", {count});
  return say("stage.picture_of", {scene: model.name, tools, objects});
}
