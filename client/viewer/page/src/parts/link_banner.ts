import {type LinkFacts, type LinkReport, linkReport} from "../model/link_report";
import type {World} from "../model/world";
import {element, setText} from "../ui/elements";
import type {GatewayLink} from "./gateway_link";
import {nowS} from "./now";

/// What this page does by itself, as far as the banner's words depend on it.
type OwnFacts = Pick<LinkFacts, "mayTake" | "takes" | "draws" | "replay">;

/// The banner above the picture, on the way from the server to this page.
export class LinkBanner {
  private readonly line = element("banner", HTMLParagraphElement);

  constructor(
    private readonly world: World,
    private readonly link: GatewayLink,
  ) {}

  show(own: OwnFacts): LinkReport {
    const {world, link} = this;
    const now = nowS();
    const report = linkReport({
      ...own,
      link: link.state,
      wasOpen: link.opened > 0,
      nowS: now,
      openedS: link.openedS,
      lastStateS: world.lastStateS,
      sessions: [...world.stations.values()].filter(({holdsTool}) => holdsTool).length,
      scenes: world.scenes.size,
      refusal: link.refusal,
      serverLives: world.serverLives,
      compiling: world.compiling,
      recording: world.replay.name,
      replaySilenceS: world.replay.silenceS(now, link.heardSinceS),
      busyS: link.pulse.busyS,
    });
    this.line.hidden = report.tone === "none";
    this.line.classList.toggle("alarm", report.tone === "alarm");
    setText(this.line, report.text);
    return report;
  }
}
