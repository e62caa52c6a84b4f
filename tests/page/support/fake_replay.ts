import {type FakeGateway, pressed, sessionState} from "./fake_gateway";
import {replayStateSent} from "./replay_state";

export interface Mark {
  at_s: number;
  number: number;
  kind: string;
  text: string;
}

const kStepMs = 33;
const kStateEverySteps = 6;

/// A replayer behind a gateway, as pages see it: it plays, follows requests and keeps bookmarks.  At
/// a time of t seconds, its tool presses on the box with t newtons.
export class FakeReplay {
  readonly wishes: Record<string, unknown>[] = [];
  readonly state = replayStateSent(0, {replay: "fedcba9876543210"});
  readonly contents = {
    replay: this.state.replay,
    recording: "lesson-3.mcap",
    begun_s: Date.UTC(2026, 2, 12, 13, 3) / 1000,
    length_s: 60,
    locked: false,
    marks: [] as Mark[],
    gaps: [] as {from_s: number; to_s: number; station: string; reason: string}[],
  };
  refusal = ""; // of the next wishes
  private timer: NodeJS.Timeout | undefined;
  private steps = 0;
  private steppedNs = process.hrtime.bigint();
  private requests = 0;

  constructor(private readonly gateway: FakeGateway) {
    gateway.onPublish = (message) => this.wished(message);
  }

  start(): void {
    this.gateway.retained.length = 0;
    const session = sessionState("hand", "active", "test-box", "ball");
    this.gateway.retain("/palpate/session_state", session);
    this.tellContents();
    this.timer = setInterval(() => this.step(), kStepMs);
  }
  /// Stops without a message.
  die(): void {
    clearInterval(this.timer);
    this.gateway.retained.length = 0;
  }
  end(): void {
    this.die();
    Object.assign(this.state, {playing: false, ended: true});
    this.tellState();
  }
  tellContents(): void {
    this.gateway.retained.splice(1);
    this.gateway.retain("/palpate/replay_contents", this.contents);
  }

  private step(): void {
    const {state, contents} = this;
    const elapsedS = Number(process.hrtime.bigint() - this.steppedNs) * 1e-9;
    this.steppedNs = process.hrtime.bigint();
    if (this.steps++ % kStateEverySteps === 0) this.tellState();
    if (!state.playing) return;
    state.at_s = Math.min(contents.length_s, state.at_s + state.rate * elapsedS);
    if (!contents.gaps.some((gap) => gap.from_s <= state.at_s && state.at_s < gap.to_s))
      this.tellTool();
  }

  private tellState(): void {
    this.gateway.send("/palpate/replay_state", this.state);
  }

  private tellTool(): void {
    const newtons = this.state.at_s;
    const state = pressed("hand", Math.round(1000 * newtons), newtons);
    this.gateway.send("/palpate/tool_state", state);
  }

  private wished(message: Record<string, unknown>): void {
    this.wishes.push(message);
    const request = (0xf000_0000_0000_0000n + BigInt(++this.requests)).toString(16);
    this.gateway.send("/palpate/replay_answer", {tag: message.tag, request, refusal: ""});
    const {state, contents} = this;
    state.request = request;
    state.refusal = this.refusal;
    if (this.refusal === "") this.follow(message);
    // Like a replayer: first the tool there, then the position.
    if (message.wish === "seek") this.tellTool();
    this.tellState();
    if (/bookmark/.test(String(message.wish))) {
      contents.marks.sort((a, b) => a.at_s - b.at_s);
      this.tellContents();
    }
  }

  private follow({wish, value, text}: Record<string, unknown>): void {
    const {state, contents} = this;
    const number = Number(value);
    if (wish === "play" || wish === "pause") state.playing = wish === "play";
    if (wish === "seek") state.at_s = number;
    if (wish === "rate") state.rate = number;
    if (wish === "add_bookmark") {
      const next = 1 + Math.max(0, ...contents.marks.map((mark) => mark.number));
      contents.marks.push({at_s: number, number: next, kind: "bookmark", text: String(text)});
    }
    if (wish === "drop_bookmark")
      contents.marks = contents.marks.filter((mark) => mark.number !== number);
  }
}
