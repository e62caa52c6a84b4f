import type {LoopStatistics, SessionState, ToolState} from "../protocol/messages";
import {norm, subtract} from "./pose";

/// What the page says, in words that need no knowledge of the program.

/// Depth of the hand past the surface [m].
export const depthM = (state: ToolState): number => norm(subtract(state.graphic.p, state.haptic.p));

/// Three figures at most, as a person would say them.
export function figure(value: number, digits = 2): string {
  const magnitude = Math.abs(value);
  if (!Number.isFinite(value)) return "–";
  if (magnitude >= 100) return value.toFixed(0);
  if (magnitude >= 10) return value.toFixed(Math.min(1, digits));
  return value.toFixed(digits);
}

const plural = (count: number, one: string, many = `${one}s`): string =>
  `${count.toLocaleString("en")} ${count === 1 ? one : many}`;

/// One sentence for those who do not see the picture.
export function statusSentence(state: ToolState | undefined): string {
  if (!state) return "No tool is moving.";
  if (state.contacts === 0) return "The tool is free.";
  const force = norm(state.forceN);
  const depth = 1000 * depthM(state);
  const pressed = `hand ${figure(depth, 1)} millimetres past the surface`;
  return `Contact, ${figure(force, 1)} newtons, ${pressed}.`;
}

/// common/step_fault.h, with what it means to who holds the tool.
const kFaults: readonly (readonly [number, string])[] = [
  [1 << 0, "the device sent a pose that is no pose"],
  [1 << 1, "the hand was quicker than the tool, which followed"],
  [1 << 2, "more contacts at once than are computed; the tightest were kept"],
  [1 << 3, "the tool was jammed between surfaces"],
  [1 << 4, "a contact problem was not solved; the tool stood still"],
  [1 << 8, "no fresh pose came, and the force faded"],
  [1 << 9, "a pose came out of turn, or faster than a hand"],
  [1 << 10, "the tool has not started: it is inside an object"],
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

const kRateHz = 1000;

/// The loop's last second as lines of a table.
export function statisticsLines(statistics: LoopStatistics): Line[] {
  const {p50, p99, p999} = statistics.stepUs;
  const onTime = Math.abs(statistics.rateHz - kRateHz) < 0.05 * kRateHz;
  const time = (us: number): string =>
    us >= 1000 ? `${figure(us / 1000, 1)} ms` : `${figure(us, 1)} µs`;
  const faults = faultWords(statistics.faults);
  const lines: Line[] = [
    {
      label: "Rate",
      value: `${statistics.rateHz.toFixed(0)} / s`,
      remark: onTime ? "as it should be" : "should be a thousand",
      tone: onTime ? "good" : "bad",
    },
    {label: "Usual step", value: time(p50), remark: "half are quicker", tone: "plain"},
    {label: "Slow step", value: time(p99), remark: "1 in 100 takes longer", tone: "plain"},
    {
      label: "Slower yet",
      value: time(p999),
      remark: p999 < 1000 ? "1 in 1000 takes longer" : "more than the millisecond that there is",
      tone: p999 < 1000 ? "plain" : "bad",
    },
    {
      label: "Late",
      value: plural(statistics.late, "pose"),
      remark: statistics.late === 0 ? "all came in time" : "came too late",
      tone:
        statistics.late === 0
          ? "good"
          : statistics.late > 0.01 * statistics.steps
            ? "bad"
            : "plain",
    },
    {
      label: "Lost",
      value: plural(statistics.lost, "pose"),
      remark: statistics.lost === 0 ? "none on the way" : "never arrived",
      tone: statistics.lost === 0 ? "good" : "bad",
    },
  ];
  if (statistics.rejected > 0) {
    lines.push({
      label: "Refused",
      value: plural(statistics.rejected, "pose"),
      remark: "not usable",
      tone: "bad",
    });
  }
  lines.push({
    label: "Faults",
    value: statistics.faultedSteps === 0 ? "none" : plural(statistics.faultedSteps, "step"),
    remark: faults.join("; "),
    tone: statistics.faultedSteps === 0 ? "good" : "plain",
  });
  return lines;
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
  }
}

/// True for a session that has its tool.
export const holdsTool = (session: SessionState): boolean =>
  session.phase === "waiting" || session.phase === "acquiring" || session.phase === "active";
