import {FoxgloveClient, type IWebSocket} from "@foxglove/ws-protocol";

import {type Channel, type Decode, makeDecoder} from "./decoder";

export type LinkState = "connecting" | "open" | "lost";

export interface ConnectionEvents {
  link(state: LinkState): void;
  message(topic: string, value: unknown, stampS: number): void;
  status(level: number, message: string): void;
  /// Whether the gateway takes messages of this page, and the role that it gives it.
  mayPublish(may: boolean, role: string): void;
  /// The topics that it offers this page.
  offers(topics: ReadonlySet<string>): void;
}

const kSubprotocols = [FoxgloveClient.SUPPORTED_SUBPROTOCOL, "foxglove.sdk.v1"];
const kFirstRetryMs = 250;
const kLastRetryMs = 2000;
/// Time limit for opening, before another attempt.
const kOpenWithinMs = 3000;

/// Delay of the n-th attempt after a loss, from 0.
const retryMs = (attempt: number): number => Math.min(kLastRetryMs, kFirstRetryMs * 2 ** attempt);

/// A WebSocket to the gateway that reconnects by itself.  It subscribes to the wanted topics
/// whenever the gateway advertises them.
export class Connection {
  private socket: WebSocket | undefined;
  private client: FoxgloveClient | undefined; // of the present socket, like the following fields
  private canPublish = false;
  private readonly subscriptions = new Map<number, {channel: Channel; decode: Decode}>();
  private readonly published = new Map<string, number>(); // channel ids by topic
  private attempt = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly wants: (topic: string) => boolean,
    private readonly events: ConnectionEvents,
    private readonly openSocket: (protocols: string[]) => WebSocket,
  ) {}

  open(): void {
    this.events.link("connecting");
    const socket = this.openSocket(kSubprotocols);
    const client = new FoxgloveClient({ws: socket as IWebSocket});
    this.socket = socket;
    this.client = client;
    this.canPublish = false;
    this.subscriptions.clear();
    this.published.clear();
    this.wait(() => socket.close(), kOpenWithinMs);
    client.on("open", () => {
      this.attempt = 0;
      clearTimeout(this.timer);
      this.events.link("open");
    });
    client.on("close", () => {
      this.lose();
      this.wait(() => this.open(), retryMs(this.attempt));
      this.attempt += 1;
    });
    client.on("serverInfo", ({capabilities, metadata}) => {
      this.canPublish = capabilities.includes("clientPublish");
      this.events.mayPublish(this.canPublish, metadata?.role ?? "");
    });
    client.on("status", ({level, message}) => this.events.status(level, message));
    client.on("advertise", (channels) => {
      for (const channel of channels) this.subscribe(client, channel);
      this.events.offers(new Set(channels.map(({topic}) => topic)));
    });
    client.on("message", ({subscriptionId, timestamp, data}) =>
      this.receive(subscriptionId, Number(timestamp) * 1e-9, data),
    );
  }

  /// Drops a socket that only looks open, and reconnects at once.
  restart(): void {
    this.lose();
    this.open();
  }

  /// Sends on a JSON channel of this client; returns false if the gateway takes no messages now.
  publish(topic: string, value: object): boolean {
    const {client} = this;
    if (!client || this.socket?.readyState !== 1 || !this.canPublish) return false;
    let channel = this.published.get(topic);
    if (channel === undefined) {
      channel = client.advertise({topic, encoding: "json", schemaName: ""});
      this.published.set(topic, channel);
    }
    client.sendMessage(channel, new TextEncoder().encode(JSON.stringify(value)));
    return true;
  }

  /// Ignores the socket from now on.
  private lose(): void {
    const {socket} = this;
    this.socket = this.client = undefined;
    clearTimeout(this.timer);
    if (socket) socket.onopen = socket.onclose = socket.onmessage = null;
    socket?.close();
    this.events.link("lost");
  }

  private subscribe(client: FoxgloveClient, channel: Channel): void {
    const isHad = [...this.subscriptions.values()].some((one) => one.channel.id === channel.id);
    if (isHad || !this.wants(channel.topic)) return;
    try {
      const decode = makeDecoder(channel);
      if (decode) this.subscriptions.set(client.subscribe(channel.id), {channel, decode});
    } catch (error) {
      this.events.status(2, `${channel.topic}: its schema could not be read (${String(error)})`);
    }
  }

  private receive(subscription: number, stampS: number, data: ArrayBufferView): void {
    const {channel, decode} = this.subscriptions.get(subscription) ?? {};
    if (!channel || !decode) return;
    let value: unknown;
    try {
      value = decode(new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
    } catch (error) {
      const said = `${channel.topic}: a message could not be read (${String(error)})`;
      this.events.status(2, said);
      return;
    }
    this.events.message(channel.topic, value, stampS);
  }

  private wait(callback: () => void, milliseconds: number): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(callback, milliseconds);
  }
}
