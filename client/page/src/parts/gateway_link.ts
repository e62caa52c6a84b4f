import {type LinkFacts, type LinkReport, linkReport, Pulse} from "../model/link_report";
import type {World} from "../model/world";
import {Connection, type LinkState} from "../protocol/connection";
import {fetchHealth} from "../protocol/health";
import {AccessToken} from "../protocol/token";
import {element, setText} from "../ui/elements";
import {nowS} from "./now";

const kAll = "/palpate/"; // topics

/// Interval of health requests, which also detect a link that only looks open.
const kAskHealthMs = 4000;
const kAnswerWithinMs = 3000;
const kError = 2; // level of a status
/// A link without messages is closed after this many unanswered health requests.
const kMostSilences = 2;

export interface LinkEvents {
  link(state: LinkState): void;
  wants(topic: string): boolean;
  message(topic: string, value: unknown, stampS: number): void;
  rights(): void; // they may have changed
  refused(reason: string): void; // something that this page asked for
}

/// This page's own state, as far as the banner depends on it.
type OwnFacts = Pick<LinkFacts, "mayTake" | "takes" | "draws" | "replay">;

/// The link to the gateway: whether it is open, why it does not open, and this page's rights; also
/// the banner above the picture, about the path from the server to this page.
export class GatewayLink {
  state: LinkState = "connecting";
  opened = 0; // number of times
  openedS = -Infinity;
  readonly pulse = new Pulse();
  readonly token = new AccessToken();
  /// This page's rights: to take a tool, until the gateway denies it; to steer a replay; to decide
  /// about stations; to decide about people of a course; to do its exercises.
  may = {publish: false, take: true, steer: false, operate: false, teach: false, try: false};
  private losses = 0; // since the link was last open: its loss and failed attempts
  private lostS = -Infinity; // time of the first of them
  private gateway = {saidS: -Infinity, full: false, wantsToken: false, silences: 0};
  private readonly connection: Connection;
  private readonly banner = element("banner", HTMLParagraphElement);

  constructor(
    private readonly world: World,
    private readonly events: LinkEvents,
  ) {
    const url = new URL(".", location.href);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    this.connection = new Connection(
      (topic) => topic.startsWith(kAll) && events.wants(topic.slice(kAll.length)),
      {
        link: (state) => this.changed(state),
        message: (topic, value, stampS) => events.message(topic.slice(kAll.length), value, stampS),
        status: (level, message) => {
          if (level > 0) console.warn(`gateway: ${message}`);
          if (level === kError) events.refused(message);
        },
        mayPublish: (publish, role) => {
          this.may = {...this.may, publish, operate: publish && role === "operate"};
        },
        offers: (topics) => {
          const offered = (topic: string): boolean => this.may.publish && topics.has(kAll + topic);
          const [take, steer] = [offered("mouse_state"), offered("replay_answer")];
          this.may = {
            ...this.may,
            take,
            steer,
            teach: this.may.operate && offered("class_answer"),
            try: offered("exercises"),
          };
          events.rights();
        },
      },
      (protocols) => new WebSocket(url.href, this.token.protocols(protocols)),
    );
    // A link with another token, opened in this tab, changes only the address and loads nothing.
    addEventListener("hashchange", () => {
      if (!this.token.takeFromAddress()) return;
      this.connection.restart();
      void this.askHealth();
    });
  }

  start(): void {
    this.connection.open();
    // In parallel with the socket's handshake, so that the first picture need not wait for it.
    void this.askHealth();
    window.setInterval(() => void this.watchGateway(), kAskHealthMs);
  }

  publish(topic: string, message: object): boolean {
    return this.connection.publish(kAll + topic, message);
  }

  /// Since when this page receives messages: the link is open, and the page runs.
  get heardSinceS(): number {
    return Math.max(this.openedS, this.pulse.busyS);
  }

  /// Why the link does not open, if the gateway can be reached.
  private get refusal(): LinkFacts["refusal"] {
    if (this.gateway.wantsToken) return "token";
    if (this.losses < 2 || this.gateway.saidS < this.lostS) return "none";
    return this.gateway.full ? "full" : "this page";
  }

  show(own: OwnFacts): LinkReport {
    const {world, banner} = this;
    const now = nowS();
    const report = linkReport({
      ...own,
      link: this.state,
      wasOpen: this.opened > 0,
      nowS: now,
      openedS: this.openedS,
      lastStateS: world.lastStateS,
      sessions: [...world.stations.values()].filter(({holdsTool}) => holdsTool).length,
      scenes: world.scenes.size,
      refusal: this.refusal,
      serverLives: world.serverLives,
      compiling: world.compiling,
      recording: world.replay.name,
      replaySilenceS: world.replay.silenceS(now, this.heardSinceS),
      busyS: this.pulse.busyS,
    });
    banner.hidden = report.tone === "none";
    banner.classList.toggle("alarm", report.tone === "alarm");
    setText(banner, report.text);
    return report;
  }

  async askHealth(): Promise<void> {
    const health = await fetchHealth(kAnswerWithinMs, this.token.headers);
    if (!health) {
      this.gateway.silences += 1;
      return;
    }
    const wantsToken = health === "token";
    const full = !wantsToken && health.viewers >= health.max_viewers;
    this.gateway = {saidS: nowS(), full, wantsToken, silences: 0};
    if (!wantsToken) this.world.receiveHealth(health, nowS());
  }

  private changed(state: LinkState): void {
    this.state = state;
    if (state === "open") {
      this.opened += 1;
      this.losses = 0;
      this.openedS = nowS();
      this.world.startLink();
      void this.askHealth();
    } else if (state === "lost" && (this.losses += 1) === 1) {
      this.lostS = nowS();
    }
    this.events.link(state);
  }

  /// A socket can look open long after its peer has become unreachable: if no message arrives and
  /// the gateway does not answer either, the link is opened again.
  private async watchGateway(): Promise<void> {
    const askedS = nowS();
    await this.askHealth();
    const isSilent = this.world.lastStateS < askedS && this.openedS < askedS;
    if (this.state !== "open" || !isSilent || this.gateway.silences < kMostSilences) return;
    this.gateway.silences = 0;
    this.connection.restart();
  }
}
