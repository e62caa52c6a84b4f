import {say} from "../messages/say";
import type {LinkState} from "../protocol/connection";
import type {Compiling} from "../protocol/health";
import {sayReason} from "./reasons";
import type {ReplayPhase} from "./replay";
import {percent} from "./words";

/// What the banner reports about the path from the server to this page.
export interface LinkReport {
  readonly tone: "none" | "info" | "alarm";
  readonly text: string;
}

export interface LinkFacts {
  readonly link: LinkState;
  readonly wasOpen: boolean; // at any earlier time
  readonly nowS: number;
  readonly openedS: number; // when the link was last opened
  readonly lastStateS: number; // when the last ToolState arrived; -Infinity: never
  readonly sessions: number; // sessions that have a tool
  readonly scenes: number; // number of known scenes
  /// Why a gateway that answers does not accept the link, if so.
  readonly refusal: "none" | "full" | "this page" | "token";
  readonly serverLives: boolean; // the server that the gateway heard last
  readonly compiling: Compiling | undefined; // by a server that does not serve yet
  readonly mayTake: boolean; // a tool, with the mouse
  readonly takes: boolean; // this page requests or holds a tool
  readonly draws: boolean; // the browser has WebGL
  readonly replay: ReplayPhase;
  readonly recording: string; // name of a replay's recording
  readonly replaySilenceS: number;
  readonly busyS: number; // when this page last resumed after a stall; -Infinity: never
}

/// Tool states arrive 30 times a second; a gap this long counts as silence [s].
export const kSilenceS = 1.5;

/// A timer later than this shows that the page was stalled by its browser's drawing [s].
const kBusyS = 0.5;

/// Detects stalls of the page with a timer that should fire regularly.
export class Pulse {
  private lastS = Number.NaN;
  /// When the last stall ended; -Infinity: never.
  busyS = -Infinity;

  /// @param visible  browsers slow down the timers of hidden pages.
  beat(nowS: number, visible: boolean): void {
    if (visible && nowS - this.lastS > kBusyS) this.busyS = nowS;
    this.lastS = visible ? nowS : Number.NaN;
  }
}

const info = (text: string): LinkReport => ({tone: "info", text});
const alarm = (text: string): LinkReport => ({tone: "alarm", text});

export function linkReport(facts: LinkFacts): LinkReport {
  if (facts.link !== "open") return closedReport(facts);
  const {recording} = facts;
  if (facts.replay === "ended") return info(say("link.replay_ended", {recording}));
  if (facts.replay === "silent") {
    const seconds = Math.floor(facts.replaySilenceS);
    return alarm(say("link.replay_silent", {recording, seconds}));
  }
  if (facts.compiling && (facts.scenes === 0 || !facts.serverLives)) {
    const {scene, stage, done} = facts.compiling;
    const share = percent(Math.floor(100 * done) / 100);
    return info(say("link.compiles", {scene, share, stage: sayReason(stage)}));
  }
  if (facts.replay === "none" && facts.scenes > 0 && !facts.serverLives) {
    return alarm(say("link.no_server"));
  }
  const since = Math.max(facts.lastStateS, facts.openedS);
  // A replay may be paused, or at moments in which nothing moved.
  const quiet = facts.replay === "none" && facts.nowS - since >= kSilenceS;
  // Messages wait during a stall: only after it is known who was silent.
  const busy = facts.nowS - facts.busyS < kSilenceS;
  if (quiet && busy) {
    return info(say("link.slow"));
  }
  if (quiet && facts.sessions > 0) {
    return alarm(say("link.no_data", {seconds: Math.floor(facts.nowS - since)}));
  }
  if (!facts.draws) return info(say("link.no_picture"));
  if (!quiet || facts.takes) return {tone: "none", text: ""};
  if (facts.scenes === 0) {
    return info(say("link.no_scene"));
  }
  return info(say(facts.mayTake ? "link.idle_may_take" : "link.idle"));
}

function closedReport({link, refusal, wasOpen}: LinkFacts): LinkReport {
  switch (refusal) {
    case "full":
      return alarm(say("link.full"));
    case "token":
      return alarm(say("link.token"));
    case "this page":
      return alarm(say("link.this_page"));
    case "none":
      if (wasOpen) return alarm(say("link.lost"));
      return link === "lost" ? alarm(say("link.no_answer")) : info(say("link.connecting"));
  }
}
