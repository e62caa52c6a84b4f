// Reads a recording with the readers of others, in the file's order and by its index, decodes each
// message by its own schema, encodes it again, and prints what was found as JSON:
//   node read_back.mjs FOLDER_WITH_NODE_MODULES FILE
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { readFileSync } from "node:fs";
import { open } from "node:fs/promises";

const require = createRequire(resolve(process.argv[2]) + "/");
const { McapStreamReader, McapIndexedReader } = require("@mcap/core");
const { parseIDL } = require("@foxglove/omgidl-parser");
const { MessageReader, MessageWriter } = require("@foxglove/omgidl-serialization");
const fzstd = require("fzstd");

const decompressHandlers = { zstd: (data, size) => fzstd.decompress(data, new Uint8Array(Number(size))) };
const file = process.argv[3];

// Every number and text of a message in the order of its fields; a sequence of bytes as its sum.
function flatten(value, out = []) {
  if (typeof value === "bigint") out.push(value.toString());
  else if (value instanceof Uint8Array) out.push(value.length, value.reduce((sum, byte) => sum + byte, 0));
  else if (Array.isArray(value) || ArrayBuffer.isView(value)) for (const item of value) flatten(item, out);
  else if (value !== null && typeof value === "object") for (const item of Object.values(value)) flatten(item, out);
  else out.push(value);
  return out;
}

const schemas = new Map();
const channels = new Map();
const result = { topics: {}, messages: [], metadata: [], reencoded: 0, different: 0, indexed: 0, index_same: 0 };

function typesOf(channel) {
  const schema = schemas.get(channel.schemaId);
  if (!schema.types) {
    const definitions = parseIDL(new TextDecoder().decode(schema.data));
    // Their writer takes a matrix for its first row; such types are only read.
    const matrix = definitions.find((type) => type.name === schema.name).definitions.some((field) => field.arrayLengths?.length > 1);
    schema.types = {
      reader: new MessageReader(schema.name, definitions),
      writer: matrix ? undefined : new MessageWriter(schema.name, definitions),
    };
  }
  return { name: schema.name, encoding: schema.encoding, ...schema.types };
}

function take(record) {
  if (record.type === "Schema") schemas.set(record.id, record);
  if (record.type === "Channel") channels.set(record.id, record);
  if (record.type === "Metadata") result.metadata.push({ name: record.name, ...Object.fromEntries(record.metadata) });
  if (record.type !== "Message") return;
  const channel = channels.get(record.channelId);
  const types = typesOf(channel);
  const message = types.reader.readMessage(record.data);
  if (types.writer) {
    const again = Buffer.from(types.writer.writeMessage(message));
    // DDS fills the last word, and says in the header's last byte by how much.
    const fill = record.data[3] & 3;
    const payload = Buffer.from(record.data.subarray(4, record.data.length - fill));
    result.reencoded++;
    if (Buffer.compare(again.subarray(4), payload) !== 0) result.different++;
  }
  const topic = (result.topics[channel.topic] ??= {
    type: types.name, schema: types.encoding, encoding: channel.messageEncoding, messages: 0,
  });
  topic.messages++;
  result.messages.push({
    topic: channel.topic, sequence: record.sequence, log_time: record.logTime.toString(), values: flatten(message),
  });
}

const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
stream.append(readFileSync(file));
for (let record; (record = stream.nextRecord()); ) take(record);
result.done = stream.done();

const handle = await open(file);
try {
  const readable = {
    size: async () => BigInt((await handle.stat()).size),
    read: async (offset, length) => {
      const buffer = new Uint8Array(Number(length));
      await handle.read(buffer, 0, buffer.length, Number(offset));
      return buffer;
    },
  };
  const indexed = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  result.statistics = {
    messages: Number(indexed.statistics.messageCount),
    channels: indexed.statistics.channelCount,
    chunks: indexed.statistics.chunkCount,
    metadata: indexed.statistics.metadataCount,
  };
  const times = result.messages.map((message) => BigInt(message.log_time)).sort((a, b) => (a < b ? -1 : a > b));
  for await (const message of indexed.readMessages({ validateCrcs: true })) {
    if (message.logTime === times[result.indexed]) result.index_same++;
    result.indexed++;
  }
  result.indexed_metadata = 0;
  for await (const metadata of indexed.readMetadata()) result.indexed_metadata += metadata.name !== "";
} catch (error) {
  result.index_error = String(error.message ?? error);
} finally {
  await handle.close();
}
process.stdout.write(JSON.stringify(result) + "\n");
