import {say} from "../messages/say";
import type {ReplayAnswer, ReplayState} from "../protocol/messages";

export type WishName = "play" | "pause" | "seek" | "rate" | "add_bookmark" | "drop_bookmark";

/// A viewer's request to a replay (client/viewer/page_messages.h).
export interface Wish {
  readonly wish: WishName;
  readonly value?: number;
  readonly text?: string;
}

/// Interval of seek requests while a bar is dragged [s].
const kSeekEveryS = 0.2;
/// An answer can be missed if another viewer's follows at once; after this time it counts
/// as given [s].
const kPatienceS = 2;
const kHeardMost = 16;

/// Each lane has at most one request in flight.
type LaneName = "motion" | "seek" | "rate" | "add_bookmark" | "drop_bookmark";
interface Lane {
  readonly waiting: Wish[];
  asked: {tag: number; request: string; wish: Wish} | undefined;
  sentS: number;
}

const laneOf = (wish: Wish): LaneName =>
  wish.wish === "play" || wish.wish === "pause" ? "motion" : wish.wish;
/// Each bookmark request counts; of the others only the last.
const everyOneCounts = (name: LaneName): boolean => name.endsWith("bookmark");

/// Sends requests to a replay so that none is lost: the transport keeps only the newest of a kind.
/// So a request waits for the answer to the former; while a bar is dragged, which makes one per
/// pixel, for a fifth of a second.  The last one is always sent.
export class Wishes {
  private readonly lanes = new Map<LaneName, Lane>();
  private readonly heard: {request: string; refusal: string}[] = [];
  private nextTag = 1;

  /// @param publish  returns false if the gateway takes no message now
  constructor(
    private readonly publish: (message: object) => boolean,
    private readonly refused: (wish: Wish, reason: string) => void,
  ) {}

  ask(replay: string, wish: Wish, nowS: number): void {
    const lane = this.lane(laneOf(wish));
    if (!everyOneCounts(laneOf(wish))) lane.waiting.length = 0;
    lane.waiting.push(wish);
    this.flush(replay, nowS);
  }

  /// Takes the gateway's answer: the number that the replay's answer will have, or a refusal.
  answered({tag, request, refusal}: ReplayAnswer): void {
    for (const lane of this.lanes.values()) {
      const asked = lane.asked;
      if (asked?.tag !== tag) continue;
      asked.request = request;
      const told = this.heard.find((known) => known.request === request);
      if (refusal !== "") this.end(lane, refusal);
      else if (told) this.end(lane, told.refusal);
    }
  }

  /// Takes the replay's state, which may answer the last request.
  told({request, refusal}: ReplayState): void {
    if (request === this.heard.at(-1)?.request) return;
    this.heard.push({request, refusal});
    if (this.heard.length > kHeardMost) this.heard.shift();
    for (const lane of this.lanes.values()) {
      if (lane.asked?.request === request) this.end(lane, refusal);
    }
  }

  /// Sends the requests that may be sent by now.
  flush(replay: string, nowS: number): void {
    for (const [name, lane] of this.lanes) {
      if (lane.asked && nowS - lane.sentS >= kPatienceS) lane.asked = undefined;
      const goesOn = name === "seek" ? nowS - lane.sentS >= kSeekEveryS : !lane.asked;
      const wish = goesOn ? lane.waiting.shift() : undefined;
      if (!wish) continue;
      const tag = this.nextTag++;
      lane.asked = {tag, request: "", wish};
      lane.sentS = nowS;
      if (!this.publish({replay, tag, ...wish})) this.end(lane, say("replay.link_lost"));
    }
  }

  /// The position last requested and not reached yet: the page shows it as if it were.
  get soughtS(): number | undefined {
    return this.latest("seek")?.value;
  }
  get rate(): number | undefined {
    return this.latest("rate")?.value;
  }
  get playing(): boolean | undefined {
    const wish = this.latest("motion")?.wish;
    return wish && wish === "play";
  }

  /// Another replay, or none.
  clear(): void {
    this.lanes.clear();
    this.heard.length = 0;
  }

  private latest(name: LaneName): Wish | undefined {
    const lane = this.lanes.get(name);
    return lane?.waiting.at(-1) ?? lane?.asked?.wish;
  }

  private end(lane: Lane, refusal: string): void {
    const wish = lane.asked?.wish;
    lane.asked = undefined;
    if (wish && refusal !== "") this.refused(wish, refusal);
  }

  private lane(name: LaneName): Lane {
    let lane = this.lanes.get(name);
    if (!lane) this.lanes.set(name, (lane = {waiting: [], asked: undefined, sentS: -Infinity}));
    return lane;
  }
}
