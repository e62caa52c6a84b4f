#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/mcap/mcap_format.h"

namespace palpate::mcap {

struct Message {
  const Channel* channel = nullptr;
  std::uint32_t sequence = 0;
  // Times are between 1970 and 2116, so that the sum of two cannot overflow, whatever a
  // file contains.
  std::int64_t log_time_ns = 0;
  std::int64_t publish_time_ns = 0;
  std::span<const std::uint8_t> data;  ///< valid until the next call
};

/// A memory-mapped file.
class MappedFile {
 public:
  /// Throws Error (file, the system's reason).
  explicit MappedFile(const std::string& file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// Reads an MCAP file in order, from first byte to last, and trusts nothing in it: from a file that
/// was cut off or altered it gives the part that is intact, and the reason why it stops there.
class Reader {
 public:
  /// @param bytes   the file's bytes; must outlive the reader.
  /// @param source  names it in messages.
  /// Throws Error if the file does not begin with MCAP's magic bytes.
  Reader(std::span<const std::uint8_t> bytes, std::string source);

  /// Reads the next message, in file order; false at the end, or if it cannot go on.
  bool Next(Message& message);

  /// Returns the offset of the last message's chunk, or of the message itself if it is in none.
  std::size_t offset() const { return offset_; }
  /// Continues from an offset that offset() has returned, or from kMagicSize, the beginning.
  /// Problems and metadata that are read a second time are not reported again.
  void GoTo(std::size_t offset);
  /// Continues with a file that has grown, after Next has returned false because it had no end.
  void Grow(std::span<const std::uint8_t> bytes);

  /// Valid after Next has returned false: true if the file has its end (a footer).
  bool complete() const { return complete_; }
  /// Returns true if bytes were altered, as opposed to cut off.
  bool damaged() const { return damaged_; }
  /// Returns what is wrong with the file, a sentence each; empty if it is intact.
  const std::vector<std::string>& problems() const { return problems_; }
  /// Metadata, schemas and channels read so far.
  const std::vector<Metadata>& metadata() const { return metadata_; }
  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }

 private:
  struct Record {
    std::uint8_t opcode;
    std::span<const std::uint8_t> content;
  };
  /// Reads the record at `at` and advances; false if no whole record is left.
  static bool TakeRecord(std::span<const std::uint8_t> bytes, std::size_t& at, Record& record);
  /// Takes a Schema, Channel or Message record; true for a message that can be returned.
  bool TakeBasic(const Record& record, Message& message);
  template <class Declared>
  void Declare(std::map<std::uint16_t, Declared>& all, Declared declared, const char* what,
               std::string Declared::*name);
  void OpenChunk(std::span<const std::uint8_t> content, std::size_t offset);
  void End();
  void Stop(const std::string& problem);
  void Damaged(const std::string& problem);
  void AddProblem(const std::string& problem);

  std::span<const std::uint8_t> bytes_;
  std::string source_;
  std::size_t at_ = 0, offset_ = 0;
  std::vector<std::uint8_t> chunk_;
  std::size_t chunk_at_ = 0, chunk_offset_ = 0;
  std::size_t first_chunk_ = std::numeric_limits<std::size_t>::max();  // offset of the first chunk
  std::size_t seen_ = 0;  // metadata before this offset have been reported
  bool ended_ = false, read_once_ = false, complete_ = false, damaged_ = false;
  std::vector<std::string> problems_;
  std::vector<Metadata> metadata_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::map<std::uint16_t, std::uint64_t> undeclared_;  // number of messages, by channel
};

}  // namespace palpate::mcap
