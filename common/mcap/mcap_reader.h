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
  // No earlier than 1970 and no later than 2116, so that no sum of two overflows, whatever a file
  // says.
  std::int64_t log_time_ns = 0;
  std::int64_t publish_time_ns = 0;
  std::span<const std::uint8_t> data;  ///< until the next call
};

/// A file in memory, as the system pages it in.
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

/// Reads an MCAP file in order, from first byte to last, believing nothing: a file that was cut
/// off, or whose bytes have changed, gives what of it is whole, and the reason why not more.
class Reader {
 public:
  /// @param bytes   the file; must outlive the reader.
  /// @param source  names it in messages.
  /// Throws Error where it does not begin as an MCAP file does.
  Reader(std::span<const std::uint8_t> bytes, std::string source);

  /// The next message, in the file's order; false at the end, or where it cannot go on.
  bool Next(Message& message);

  /// Where the chunk of the last message begins (or that message, where it is in none).
  std::size_t offset() const { return offset_; }
  /// Goes on from an offset that it has given, or from kMagicSize, the beginning.  What is met
  /// again is not told again: neither problems nor metadata.
  void GoTo(std::size_t offset);
  /// The file has grown, after Next has returned false for it had no end: goes on from there.
  void Grow(std::span<const std::uint8_t> bytes);

  /// Once Next has returned false: true where the file has its end (a footer).
  bool complete() const { return complete_; }
  /// True where bytes have changed, as opposed to being cut off.
  bool damaged() const { return damaged_; }
  /// What is wrong with it, a sentence each; none where it is whole.
  const std::vector<std::string>& problems() const { return problems_; }
  /// Of what has been read so far.
  const std::vector<Metadata>& metadata() const { return metadata_; }
  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }

 private:
  struct Record {
    std::uint8_t opcode;
    std::span<const std::uint8_t> content;
  };
  /// The record at `at`, and moves on; false where none fits.
  static bool TakeRecord(std::span<const std::uint8_t> bytes, std::size_t& at, Record& record);
  /// Schema, Channel or Message; true for a message that can be given out.
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
  std::size_t first_chunk_ = std::numeric_limits<std::size_t>::max();  // its offset
  std::size_t seen_ = 0;  // metadata up to here have been told
  bool ended_ = false, read_once_ = false, complete_ = false, damaged_ = false;
  std::vector<std::string> problems_;
  std::vector<Metadata> metadata_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::map<std::uint16_t, std::uint64_t> undeclared_;  // messages, by channel
};

}  // namespace palpate::mcap
