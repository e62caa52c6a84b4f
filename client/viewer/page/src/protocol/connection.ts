import {type Decode, makeDecoder} from "./decoder";
import {type Channel, clientMessage, kSubprotocols, parseBinary, parseText} from "./foxglove";

export type LinkState = "connecting" | "open" | "lost";

export interface ConnectionEvents {
  link(state: LinkState): void;
  message(topic: string, value: unknown, stampS: number): void;
  status(level: number, message: string): void;
  /// The gateway takes messages of this page, or none; and the role that it gives it.
  mayPublish(may: boolean, role: string): void;
  /// The topics that it has for this page.
  offers(topics: ReadonlySet<string>): void;
}

const kFirstRetryMs = 250;
const kLastRetryMs = 2000;
/// A gateway that does not answer by then is tried anew.
const kOpenWithinMs = 3000;

/// The wait before the n-th try after a loss, from 0.
const retryMs = (attempt: number): number => Math.min(kLastRetryMs, kFirstRetryMs * 2 ** attempt);

/// A WebSocket to the gateway that comes back by itself.  Subscribes to the topics that it was
/// asked for as soon as, and each time that, the gateway advertises them.
export class Connection {
  private socket: WebSocket | undefined;
  private attempt = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private canPublish = false;
  private nextSubscription = 1;
  private readonly subscriptions = new Map<number, {channel: Channel; decode: Decode}>();
  private readonly published = new Map<string, number>(); // channel ids by topic, of this socket

  constructor(
    private readonly topics: ReadonlySet<string>,
    private readonly events: ConnectionEvents,
    private readonly openSocket: (protocols: string[]) => WebSocket,
  ) {}

  /// Gives up a socket that looks open and is not, and tries at once.
  restart(): void {
    const socket = this.socket;
    this.socket = undefined;
    socket?.close();
    this.events.link("lost");
    this.open();
  }

  /// Sends on a JSON channel of this client; false where the gateway takes no messages now.
  publish(topic: string, value: object): boolean {
    if (this.socket?.readyState !== 1 || !this.canPublish) return false;
    let channel = this.published.get(topic);
    if (channel === undefined) {
      channel = this.published.size + 1;
      this.published.set(topic, channel);
      this.sendText({
        op: "advertise",
        channels: [{id: channel, topic, encoding: "json", schemaName: "", schema: ""}],
      });
    }
    this.socket.send(clientMessage(channel, value));
    return true;
  }

  open(): void {
    this.events.link("connecting");
    const socket = this.openSocket(kSubprotocols);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.canPublish = false;
    this.subscriptions.clear();
    this.published.clear();
    this.wait(() => socket.close(), kOpenWithinMs);
    socket.onopen = () => {
      if (socket !== this.socket) return;
      this.attempt = 0;
      clearTimeout(this.timer);
      this.events.link("open");
    };
    socket.onclose = () => {
      if (socket === this.socket) this.lose();
    };
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (socket === this.socket) this.receive(event.data);
    };
  }

  private lose(): void {
    this.socket = undefined;
    this.events.link("lost");
    this.wait(() => this.open(), retryMs(this.attempt));
    this.attempt += 1;
  }

  private receive(data: unknown): void {
    if (typeof data === "string") {
      this.receiveText(data);
    } else if (data instanceof ArrayBuffer) {
      const message = parseBinary(data);
      const subscription = message && this.subscriptions.get(message.subscription);
      if (!message || !subscription) return;
      let value: unknown;
      try {
        value = subscription.decode(message.payload);
      } catch (error) {
        const topic = subscription.channel.topic;
        this.events.status(2, `${topic}: a message could not be read (${String(error)})`);
        return;
      }
      this.events.message(subscription.channel.topic, value, message.stampS);
    }
  }

  private receiveText(source: string): void {
    const message = parseText(source);
    switch (message.op) {
      case "serverInfo":
        this.canPublish = message.capabilities.includes("clientPublish");
        this.events.mayPublish(this.canPublish, message.role);
        break;
      case "status":
        this.events.status(message.level, message.message);
        break;
      case "advertise":
        this.subscribe(message.channels);
        this.events.offers(new Set(message.channels.map(({topic}) => topic)));
        break;
      case "unadvertise":
        for (const [id, {channel}] of this.subscriptions) {
          if (message.channelIds.includes(channel.id)) this.subscriptions.delete(id);
        }
        break;
      case "other":
        break;
    }
  }

  private subscribe(channels: readonly Channel[]): void {
    const wanted: {id: number; channelId: number}[] = [];
    const have = new Set([...this.subscriptions.values()].map(({channel}) => channel.id));
    for (const channel of channels) {
      if (!this.topics.has(channel.topic) || have.has(channel.id)) continue;
      let decode: Decode | undefined;
      try {
        decode = makeDecoder(channel);
      } catch (error) {
        this.events.status(2, `${channel.topic}: its schema could not be read (${String(error)})`);
      }
      if (!decode) continue;
      const id = this.nextSubscription++;
      this.subscriptions.set(id, {channel, decode});
      wanted.push({id, channelId: channel.id});
    }
    if (wanted.length > 0) this.sendText({op: "subscribe", subscriptions: wanted});
  }

  private sendText(message: object): void {
    this.socket?.send(JSON.stringify(message));
  }

  private wait(callback: () => void, milliseconds: number): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(callback, milliseconds);
  }
}
