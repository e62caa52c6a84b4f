import type {LinkState} from "../protocol/connection";
import type {Compiling} from "../protocol/scene_fetch";
import type {ReplayPhase} from "./replay";

/// What the banner says of the way from the server to this page.
export interface LinkReport {
  readonly tone: "none" | "info" | "alarm";
  readonly text: string;
}

export interface LinkFacts {
  readonly link: LinkState;
  readonly wasOpen: boolean; // at any time before
  readonly nowS: number;
  readonly openedS: number; // when the link was last opened
  readonly lastStateS: number; // when the last ToolState came; -Infinity: never
  readonly sessions: number; // that have a tool
  readonly scenes: number; // that are known
  /// Why a gateway that answers lets no link come about, where that is so.
  readonly refusal: "none" | "full" | "this page" | "token";
  readonly serverLives: boolean; // the one that the gateway last heard
  readonly compiling: Compiling | undefined; // by a server that serves nothing yet
  readonly mayTake: boolean; // a tool, with the mouse
  readonly takes: boolean; // this page asks for a tool, or has one
  readonly draws: boolean; // the browser has WebGL
  readonly replay: ReplayPhase;
  readonly recording: string; // its name, of a replay
  readonly replaySilenceS: number;
  readonly busyS: number; // when this page last could not run for a while; -Infinity: never
}

/// Tool states come 30 times a second: silence of this length is one [s].
export const kSilenceS = 1.5;

/// A page whose timer is later than this could not run: its browser was drawing [s].
const kBusyS = 0.5;

/// Tells when a page could not run for a while, from a timer that should go regularly.
export class Pulse {
  private lastS = Number.NaN;
  /// When it last could not; -Infinity: never.
  busyS = -Infinity;

  /// @param visible  browsers slow down the timers of pages that nobody sees.
  beat(nowS: number, visible: boolean): void {
    if (visible && nowS - this.lastS > kBusyS) this.busyS = nowS;
    this.lastS = visible ? nowS : Number.NaN;
  }
}

const info = (text: string): LinkReport => ({tone: "info", text});
const alarm = (text: string): LinkReport => ({tone: "alarm", text});

export function linkReport(facts: LinkFacts): LinkReport {
  if (facts.link !== "open") return closedReport(facts);
  if (facts.replay === "ended") {
    return info(`The replay of ${facts.recording} has ended. What you see is the last of it.`);
  }
  if (facts.replay === "silent") {
    return alarm(
      `The replay of ${facts.recording} has not been heard of for ` +
        `${Math.floor(facts.replaySilenceS)} s: its program has stopped, or cannot be reached. ` +
        "What you see is the last of it.",
    );
  }
  if (facts.compiling && (facts.scenes === 0 || !facts.serverLives)) {
    const {scene, stage, done} = facts.compiling;
    return info(
      `The server compiles ${scene} for the first time: ${Math.floor(100 * done)} %, ${stage}. ` +
        "It shows as soon as it is done.",
    );
  }
  if (facts.replay === "none" && facts.scenes > 0 && !facts.serverLives) {
    return alarm("No server is there: the last one has gone. What you see is the last of it.");
  }
  const since = Math.max(facts.lastStateS, facts.openedS);
  // A replay may stand still, and hold moments at which nothing moved.
  const quiet = facts.replay === "none" && facts.nowS - since >= kSilenceS;
  // What came meanwhile waits until the page runs again: only then is it known who was silent.
  const busy = facts.nowS - facts.busyS < kSilenceS;
  if (quiet && busy) {
    return info(
      "This browser draws slowly, and is behind: a smaller window helps, or a browser with " +
        "hardware acceleration.",
    );
  }
  if (quiet && facts.sessions > 0) {
    return alarm(
      `No data for ${Math.floor(facts.nowS - since)} s: the gateway is there, ` +
        "the server or its station is silent.",
    );
  }
  if (!facts.draws) return info("No picture: this browser has no WebGL. The figures are live.");
  if (!quiet || facts.takes) return {tone: "none", text: ""};
  if (facts.scenes === 0) {
    return info("The gateway is there and waits: no server has told it of a scene yet.");
  }
  const how = facts.mayTake ? "Start one, or take the tool with the mouse." : "Start one.";
  return info(`No station is moving. ${how}`);
}

function closedReport({link, refusal, wasOpen}: LinkFacts): LinkReport {
  switch (refusal) {
    case "full":
      return alarm("The gateway has as many viewers as it takes. Trying again…");
    case "token":
      return alarm(
        "The gateway lets in who has a token: open this page by the link that you were given, " +
          "which ends in #token=…",
      );
    case "this page":
      return alarm(
        "The gateway is there and does not let this page attach: does it know the page's " +
          "address (--allow-origin)? Trying again…",
      );
    case "none":
      if (wasOpen) return alarm("The link to the gateway is lost. Trying again…");
      return link === "lost"
        ? alarm("The gateway does not answer. Trying again…")
        : info("Connecting…");
  }
}
