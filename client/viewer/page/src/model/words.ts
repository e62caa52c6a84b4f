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
import {norm, subtract} from "./pose";

/// What the page says, in words that need no knowledge of the program.

/// How far the hand is past the surface that stops the tool [m].
export const handPastM = (state: ToolState): number =>
  norm(subtract(state.graphic.p, state.haptic.p));

/// Three figures at most, as a person would say them.
export function figure(value: number, digits = 2): string {
  const magnitude = Math.abs(value);
  if (!Number.isFinite(value)) return "–";
  if (magnitude >= 100) return value.toFixed(0);
  if (magnitude >= 10) return value.toFixed(Math.min(1, digits));
  return value.toFixed(digits);
}

/// A time of a recording, as players show it: 1:05, 1:02:03.
export function clock(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds + 1e-6));
  const two = (value: number): string => String(value).padStart(2, "0");
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  const rest = two(whole % 60);
  return hours > 0 ? `${hours}:${two(minutes)}:${rest}` : `${minutes}:${rest}`;
}

/// The same for those who hear it.
export function spokenTime(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds + 1e-6));
  const minutes = Math.floor(whole / 60);
  const rest = plural(whole % 60, "second");
  return minutes > 0 ? `${plural(minutes, "minute")} ${rest}` : rest;
}

/// A text that has so many bytes at most, cut between letters.
export function fitBytes(text: string, most: number): string {
  const encoder = new TextEncoder();
  let fit = "";
  let bytes = 0;
  for (const letter of text) {
    bytes += encoder.encode(letter).length;
    if (bytes > most) return fit;
    fit += letter;
  }
  return text;
}

const plural = (count: number, one: string, many = `${one}s`): string =>
  `${count.toLocaleString("en")} ${count === 1 ? one : many}`;

/// What pushes the tool; a tooth by its number and not as one of twenty-eight.
export function touchedWords(names: readonly string[]): string {
  if (names.length === 0) return "nothing";
  const [first, second] = names.map((name) => name.replace(/[-_]/g, " "));
  if (second === undefined) return first!;
  return names.length === 2 ? `${first}, ${second}` : `${first} and ${names.length - 1} more`;
}

/// One sentence for those who do not see the picture.
/// @param probingM  how deep a probe's tip is below the gum's margin; undefined: it is no probe
export function statusSentence(state: ToolState | undefined, probingM?: number): string {
  if (!state) return "No tool is moving.";
  if (state.contacts === 0) return "The tool is free.";
  const force = norm(state.forceN);
  const past = `hand ${figure(1000 * handPastM(state), 1)} millimetres past the surface`;
  const probing =
    probingM === undefined
      ? ""
      : `, tip ${figure(1000 * probingM, 1)} millimetres below the margin`;
  return `Contact, ${figure(force, 1)} newtons, ${past}${probing}.`;
}

/// common/step_fault.h, with what it means to who holds the tool.
const kFaults: readonly (readonly [number, string])[] = [
  [1 << 0, "the device sent a pose that is no pose, and the force faded"],
  [1 << 1, "the hand was quicker than the tool, which followed"],
  [1 << 2, "more contacts at once than are computed; the tightest were kept"],
  [1 << 3, "the tool was jammed between surfaces"],
  [1 << 4, "a contact problem was not solved; the tool stood still"],
  [1 << 5, "an added force of the scene failed, and is off from then on"],
  [1 << 9, "a pose was further from the last than a hand comes, and the force faded"],
  [1 << 10, "no force yet: the tool has just come, or is inside an object"],
];

export function faultWords(faults: number): string[] {
  return kFaults.filter(([bit]) => (faults & bit) !== 0).map(([, words]) => words);
}

export interface Line {
  readonly label: string;
  readonly value: string;
  readonly remark: string;
  readonly tone: "good" | "plain" | "bad";
}

const line = (
  label: string,
  value: string,
  remark: string,
  tone: Line["tone"] = "plain",
): Line => ({label, value, remark, tone});

const kRateHz = 1000;
/// Of the poses that may be late or missing before a load no longer holds, as palpate-load has it.
const kMostAmiss = 0.01;

/// The loop's last second as lines of a table.
export function statisticsLines(statistics: LoopStatistics): Line[] {
  const {rateHz, steps, late, lost, rejected} = statistics;
  const {p50, p99, p999} = statistics.stepUs;
  const onTime = Math.abs(rateHz - kRateHz) < kMostAmiss * kRateHz;
  const time = (us: number): string =>
    us >= 1000 ? `${figure(us / 1000, 1)} ms` : `${figure(us, 1)} µs`;
  const rate = `${rateHz.toFixed(0)} / s`;
  const faults = faultWords(statistics.faults);
  // Of poses that were not used there is no step.
  const faulted = faults.length === 0 ? "none" : plural(statistics.faultedSteps, "step");
  return [
    onTime
      ? line("Rate", rate, "as it should be", "good")
      : line("Rate", rate, "should be a thousand", "bad"),
    line("Usual step", time(p50), "half are quicker"),
    line("Slow step", time(p99), "1 in 100 takes longer"),
    p999 < 1000
      ? line("Slower yet", time(p999), "1 in 1000 takes longer")
      : line("Slower yet", time(p999), "more than the millisecond that there is", "bad"),
    late === 0
      ? line("Late", plural(late, "pose"), "all came in time", "good")
      : line(
          "Late",
          plural(late, "pose"),
          "came too late",
          late > kMostAmiss * steps ? "bad" : "plain",
        ),
    lost === 0
      ? line("Lost", plural(lost, "pose"), "none on the way", "good")
      : line("Lost", plural(lost, "pose"), "never arrived", "bad"),
    ...(rejected > 0 ? [line("Refused", plural(rejected, "pose"), "not usable", "bad")] : []),
    line("Faults", faulted, faults.join("; "), faults.length === 0 ? "good" : "plain"),
  ];
}

/// Bits of DeviceStatus (devices/device.h).
const kDeviceCalibrating = 1 << 1;
const kDeviceFault = 1 << 2;
const kDeviceForcesIgnored = 1 << 3;

/// What each stage of the limiter keeps from the hand, and why.
const kStageWords: Readonly<Record<LimiterStage, string>> = {
  nonfinite: "what is no number",
  clamped: "what is more than the arm may give",
  slewed: "leaps of the force",
  braked: "energy that delay would add",
  warm: "peaks, while the motors are warm",
  faded: "force, while replies are late or missing",
  disabled: "force, until it is enabled at the station",
};
/// Of sums of energy [J].
const kRoundingJ = 1e-6;

function deviceLine({device, deviceStatus}: StationStatistics): Line {
  if (deviceStatus & kDeviceFault) return line("Device", "fault: no force", device, "bad");
  if (deviceStatus & kDeviceCalibrating) return line("Device", "calibrates", device);
  if (deviceStatus & kDeviceForcesIgnored) return line("Device", "renders no force", device);
  return line("Device", "in order", device, "good");
}

function limiterLine({limiter, ticks}: StationStatistics): Line {
  const share = (stage: LimiterStage): string => {
    const percent = (100 * limiter[stage]) / Math.max(ticks, limiter[stage]);
    return percent < 1 ? "< 1 %" : `${percent.toFixed(0)} %`;
  };
  const acting = kLimiterStages.filter((stage) => limiter[stage] > 0);
  if (acting.length === 0) return line("Held back", "nothing", "all force arrives", "good");
  // The one that acts most of the time first.
  acting.sort((a, b) => limiter[b] - limiter[a]);
  const most = acting[0]!;
  const all = acting.map(
    (stage) => kStageWords[stage] + (stage === most ? "" : ` (${share(stage)})`),
  );
  const isBad = limiter.nonfinite > 0 || most === "faded";
  return line("Held back", share(most), `of the time: ${all.join("; ")}`, isBad ? "bad" : "plain");
}

function silenceLine({silenceS, replies, late, lost, limiter}: StationStatistics): Line {
  const milliseconds = 1000 * silenceS;
  const value = milliseconds >= 1000 ? `${figure(silenceS, 1)} s` : `${figure(milliseconds, 1)} ms`;
  if (replies === 0) {
    return line("Silence", value, "no answer from the server: no force", "bad");
  }
  const missed = [
    late > 0 ? `${plural(late, "reply", "replies")} late` : "",
    lost > 0 ? `${lost.toLocaleString("en")} lost` : "",
  ].filter((words) => words !== "");
  const longest = ["the longest without a reply", ...missed].join("; ");
  return line("Silence", value, longest, limiter.faded > 0 ? "bad" : "plain");
}

/// What becomes of the force at the arm, in the last second, as lines of a table.
export function deviceLines(device: StationStatistics): Line[] {
  const lines = [deviceLine(device)];
  if (!(device.deviceStatus & kDeviceForcesIgnored)) {
    const {appliedForceN, wantedForceN, warmth, limiter, energyLeastJ, energyJ} = device;
    const active = energyLeastJ < -kRoundingJ;
    const whole = appliedForceN > 0.99 * wantedForceN;
    const strongest = whole
      ? "as it was computed"
      : `of ${figure(wantedForceN)} N that were computed`;
    const kWarm = "warm; from 100 % on, only the force that they stand for ever";
    const energy = `${figure(1000 * (active ? -energyLeastJ : energyJ), 1)} mJ`;
    lines.push(
      limiterLine(device),
      line("Strongest", `${figure(appliedForceN)} N`, strongest),
      line("Motors", `${(100 * warmth).toFixed(0)} %`, kWarm, limiter.warm > 0 ? "bad" : "plain"),
      active
        ? line("Energy", energy, "that the arm gave and the hand had not put in", "bad")
        : line("Energy", energy, "put in by the hand and not given back"),
    );
  }
  lines.push(silenceLine(device));
  return lines;
}

/// What a mark of a replay is, in the replayer's words where it has some.
export function markWords(mark: ReplayMark): string {
  return mark.text || (mark.kind === "whole" ? "made whole" : mark.kind);
}

export function gapWords({station, reason}: ReplayGap): string {
  return `nothing of ${station}${reason === "" ? "" : `: ${reason}`}`;
}

/// When something was recorded, in the reader's own time; empty where that is not known.
export function recordedWhen(begunS: number): string {
  if (begunS <= 0) return "";
  const when = new Date(1000 * begunS);
  return `recorded ${when.toLocaleString("en-GB", {dateStyle: "medium", timeStyle: "short"})}`;
}

export function sessionWords(session: SessionState): string {
  const tool = session.tool === "" ? "a tool" : `the ${session.tool}`;
  switch (session.phase) {
    case "active":
      return `drives ${tool} of ${session.scene}`;
    case "refused":
      return `was refused ${tool} of ${session.scene}: ${session.reason}`;
    case "acquiring":
      return (
        `starts with ${tool} of ${session.scene} ${figure(1000 * session.startDepthM, 1)} mm ` +
        "inside an object: no force until it is out"
      );
    case "waiting":
      return `waits for its first sample (${tool} of ${session.scene})`;
    case "ended":
      return `has left (${tool} of ${session.scene})`;
    case "held":
      return `waits to be admitted (${tool} of ${session.scene})`;
  }
}

/// What of a session whoever feels, or sees, its forces has to know; empty: nothing.
/// @param own  it is this page's
export function stationNote(session: SessionState | undefined, own: boolean): string {
  if (!session) return "";
  const who = own ? "You are" : `${session.station} is`;
  const hand = own ? "your hand" : "that hand";
  if (session.phase === "held")
    return `${who} waiting for a teacher to admit ${own ? "you" : "it"}.`;
  if (!holdsTool(session)) return "";
  if (session.muted) return `${who} muted by a teacher: no force reaches ${hand}.`;
  if (session.phase === "acquiring") {
    return `The tool starts ${figure(1000 * session.startDepthM, 1)} mm inside an object: no force until it is out.`;
  }
  return "";
}

/// The same for who decides about it.
export function consoleWords(session: SessionState): string {
  return sessionWords(session) + (session.muted ? ", without forces" : "");
}

/// True for a session that has its tool.
export const holdsTool = (session: SessionState): boolean =>
  session.phase === "waiting" || session.phase === "acquiring" || session.phase === "active";

/// What the picture shows, for those who do not see it.
export function pictureWords(model: SceneModel): string {
  const tools = model.tools.map(({name}) => name).join(", ");
  const [first] = model.objects;
  const objects = model.objects.length === 1 ? first!.name : `${model.objects.length} objects`;
  return `${model.name} in three dimensions: ${tools} touching ${objects}`;
}
