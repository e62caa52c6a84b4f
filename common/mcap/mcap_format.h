#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace palpate::mcap {

// MCAP, the container format of recordings, after its specification 0 (mcap.dev/spec).  Debian has
// no library for it.  The following parts of the format are used: schemas, channels, chunks of
// messages compressed with zstd, message and chunk indexes, metadata, statistics, summary offsets.

inline constexpr char kMagic[] = "\x89MCAP0\r\n";
inline constexpr std::size_t kMagicSize = 8;
/// Opcode and length before each record's content.
inline constexpr std::size_t kRecordHead = 9;

/// Ids are 16 bits wide, and those of schemas are not 0.
inline constexpr std::size_t kMostSchemas = 65'535;
inline constexpr std::size_t kMostChannels = 65'535;

/// Size limit of names and of metadata [bytes]: we write no longer ones, and they would fill
/// terminals and pages.
inline constexpr std::size_t kMostText = 4096;

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

using StringMap = std::map<std::string, std::string>;

struct Schema {
  std::uint16_t id = 0;  ///< from 1
  std::string name;
  std::string encoding;
  std::string data;
  friend bool operator==(const Schema&, const Schema&) = default;
};

struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;
  std::string topic;
  std::string message_encoding;
  StringMap metadata;
  friend bool operator==(const Channel&, const Channel&) = default;
};

struct Metadata {
  std::string name;
  StringMap values;
};

}  // namespace palpate::mcap
