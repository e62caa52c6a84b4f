import {parseIDL} from "@foxglove/omgidl-parser";
import {MessageReader} from "@foxglove/omgidl-serialization";

import type {Channel as ServerChannel} from "@foxglove/ws-protocol";

export type Channel = Pick<ServerChannel, "id" | "topic" | "encoding" | "schemaName" | "schema">;

export type Decode = (payload: Uint8Array) => unknown;

const kText = new TextDecoder();

/// Returns a JSON object; undefined if the text is none.
export function parseObject(source: string): Readonly<Record<string, unknown>> | undefined {
  try {
    const value: unknown = JSON.parse(source);
    const isObject = typeof value === "object" && value !== null && !Array.isArray(value);
    return isObject ? (value as Readonly<Record<string, unknown>>) : undefined;
  } catch {
    return undefined;
  }
}

/// Makes a reader for a channel's messages from the schema that it advertises, so that fields added
/// by a newer server do no harm.  Returns undefined if the page cannot read the encoding.
export function makeDecoder(channel: Channel): Decode | undefined {
  if (channel.encoding === "json") return (payload) => parseObject(kText.decode(payload));
  if (channel.encoding !== "cdr") return undefined;
  const reader = new MessageReader<unknown>(channel.schemaName, parseIDL(channel.schema));
  return (payload) => reader.readMessage(payload);
}
