import type {LinkState} from "../protocol/connection";

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
}

/// Tool states come 30 times a second: silence of this length is one [s].
export const kSilenceS = 1.5;

export function linkReport(facts: LinkFacts): LinkReport {
  if (facts.link !== "open") {
    if (facts.wasOpen) {
      return {tone: "alarm", text: "The link to the gateway is lost. Trying again…"};
    }
    return facts.link === "lost"
      ? {tone: "alarm", text: "The gateway does not answer. Trying again…"}
      : {tone: "info", text: "Connecting…"};
  }
  const since = Math.max(facts.lastStateS, facts.openedS);
  if (facts.nowS - since < kSilenceS) return {tone: "none", text: ""};
  if (facts.sessions > 0) {
    return {
      tone: "alarm",
      text:
        `No data for ${Math.floor(facts.nowS - since)} s: the gateway is there, ` +
        "the server or its station is silent.",
    };
  }
  return facts.scenes === 0
    ? {tone: "info", text: "The gateway is there, but no server has told it of a scene yet."}
    : {tone: "info", text: "No station is moving. Start one, or take the tool with the mouse."};
}
