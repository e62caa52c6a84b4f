import {parseIDL} from "@foxglove/omgidl-parser";
import {MessageReader} from "@foxglove/omgidl-serialization";

import type {Channel as ServerChannel} from "@foxglove/ws-protocol";

export type Channel = Pick<ServerChannel, "id" | "topic" | "encoding" | "schemaName" | "schema">;

export type Decode = (payload: Uint8Array) => unknown;

const kText = new TextDecoder();

/// Makes a reader for a channel's messages from the schema that it advertises, so that fields added
/// by a newer server do no harm.  Returns undefined if the page cannot read the encoding.
export function makeDecoder(channel: Channel): Decode | undefined {
  if (channel.encoding === "json") return (payload) => JSON.parse(kText.decode(payload)) as unknown;
  if (channel.encoding !== "cdr") return undefined;
  const reader = new MessageReader<unknown>(channel.schemaName, parseIDL(channel.schema));
  return (payload) => reader.readMessage(payload);
}
