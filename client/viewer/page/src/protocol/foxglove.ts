/// The messages of the Foxglove WebSocket protocol that the page has a use for
/// (github.com/foxglove/ws-protocol, docs/spec.md).  No socket here: bytes in, values out.

export const kSubprotocols = ["foxglove.websocket.v1", "foxglove.sdk.v1"];

export interface Channel {
  readonly id: number;
  readonly topic: string;
  readonly encoding: string;
  readonly schemaName: string;
  readonly schema: string;
}

export type ServerMessage =
  | {readonly op: "serverInfo"; readonly capabilities: readonly string[]; readonly role: string}
  | {readonly op: "status"; readonly level: number; readonly message: string}
  | {readonly op: "advertise"; readonly channels: readonly Channel[]}
  | {readonly op: "unadvertise"; readonly channelIds: readonly number[]}
  | {readonly op: "other"};

type Json = Readonly<Record<string, unknown>>;

const isObject = (value: unknown): value is Json =>
  typeof value === "object" && value !== null && !Array.isArray(value);
const text = (value: unknown): string => (typeof value === "string" ? value : "");
const list = (value: unknown): readonly unknown[] => (Array.isArray(value) ? value : []);

/// A JSON object; undefined where it is none.
export function parseObject(source: string): Json | undefined {
  try {
    const value: unknown = JSON.parse(source);
    return isObject(value) ? value : undefined;
  } catch {
    return undefined;
  }
}

/// What the page does not know is `other`: a newer gateway may say more.
export function parseText(source: string): ServerMessage {
  const message = parseObject(source);
  switch (message?.op) {
    case "serverInfo":
      return {
        op: "serverInfo",
        capabilities: list(message.capabilities).map(text),
        role: isObject(message.metadata) ? text(message.metadata.role) : "",
      };
    case "status":
      return {
        op: "status",
        level: typeof message.level === "number" ? message.level : 0,
        message: text(message.message),
      };
    case "advertise":
      return {
        op: "advertise",
        channels: list(message.channels)
          .filter(isObject)
          .filter((channel) => typeof channel.id === "number")
          .map((channel) => ({
            id: Number(channel.id),
            topic: text(channel.topic),
            encoding: text(channel.encoding),
            schemaName: text(channel.schemaName),
            schema: text(channel.schema),
          })),
      };
    case "unadvertise":
      return {
        op: "unadvertise",
        channelIds: list(message.channelIds).filter((id) => typeof id === "number"),
      };
    default:
      return {op: "other"};
  }
}

export interface MessageData {
  readonly subscription: number;
  readonly stampS: number; // of the gateway's clock [s]
  readonly payload: Uint8Array;
}

const kMessageData = 1;
const kMessageHeader = 1 + 4 + 8;
const kClientMessageHeader = 1 + 4;

/// undefined for other binary messages and cut ones.
export function parseBinary(buffer: ArrayBuffer): MessageData | undefined {
  const view = new DataView(buffer);
  if (buffer.byteLength < kMessageHeader || view.getUint8(0) !== kMessageData) return undefined;
  return {
    subscription: view.getUint32(1, true),
    stampS: Number(view.getBigUint64(5, true)) * 1e-9,
    payload: new Uint8Array(buffer, kMessageHeader),
  };
}

/// A message of the client on a channel that it has advertised.
export function clientMessage(channel: number, value: object): Uint8Array<ArrayBuffer> {
  const payload = new TextEncoder().encode(JSON.stringify(value));
  const bytes = new Uint8Array(kClientMessageHeader + payload.length);
  bytes[0] = kMessageData;
  new DataView(bytes.buffer).setUint32(1, channel, true);
  bytes.set(payload, kClientMessageHeader);
  return bytes;
}
