import {say} from "../messages/say";
import type {LinkState} from "../protocol/connection";
import type {Compiling} from "../protocol/scene_fetch";
import type {ReplayPhase} from "./replay";
import {percent} from "./words";

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
  const {recording} = facts;
  if (facts.replay === "ended") return info(say("link.replay_ended", {recording}));
  if (facts.replay === "silent") {
    const seconds = Math.floor(facts.replaySilenceS);
    return alarm(say("link.replay_silent", {recording, seconds}));
  }
  if (facts.compiling && (facts.scenes === 0 || !facts.serverLives)) {
    const {scene, stage, done} = facts.compiling;
    const share = percent(Math.floor(100 * done) / 100);
    return info(say("link.compiles", {scene, share, stage}));
  }
  if (facts.replay === "none" && facts.scenes > 0 && !facts.serverLives) {
    return alarm(say("link.no_server"));
  }
  const since = Math.max(facts.lastStateS, facts.openedS);
  // A replay may stand still, and hold moments at which nothing moved.
  const quiet = facts.replay === "none" && facts.nowS - since >= kSilenceS;
  // What came meanwhile waits until the page runs again: only then is it known who was silent.
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
