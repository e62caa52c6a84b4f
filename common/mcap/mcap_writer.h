#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/mcap/mcap_format.h"

struct ZSTD_CCtx_s;

namespace palpate::mcap {

/// Writes one MCAP file: chunked, compressed, indexed.  What has been flushed is whole in the file
/// whatever becomes of this process: each chunk goes out with one write(), and a write that fails
/// is taken back.  What has been synchronised outlives the machine, too.  Thread contract: one
/// thread.
class Writer {
 public:
  /// @param library  who writes, for the header.
  /// Throws Error where the file cannot be made, or is there already: with `overwrite` it is
  /// replaced, and who reads the old one keeps it.  A file that could not be begun is not left.
  Writer(const std::string& file, const std::string& library, bool overwrite = false);
  /// Closes, if Close was not called; what fails then is lost silently.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Throws Error where the file has kMostSchemas.
  std::uint16_t AddSchema(const std::string& name, const std::string& encoding,
                          const std::string& data);
  /// Throws Error where the file has kMostChannels.
  std::uint16_t AddChannel(std::uint16_t schema, const std::string& topic,
                           const std::string& message_encoding, const StringMap& metadata = {});
  /// Puts a message into the open chunk.  Times in ns since 1970.
  void Write(std::uint16_t channel, std::uint32_t sequence, std::int64_t log_time_ns,
             std::int64_t publish_time_ns, std::span<const std::uint8_t> data);
  /// Bytes of the open chunk, uncompressed.
  std::size_t pending() const { return chunk_.size(); }
  /// Closes the open chunk and writes it.  Throws Error (file, the system's reason) where that
  /// fails, or bad_alloc; the file is then as it was before, and the chunk is dropped.
  void Flush();
  /// Waits until the disk has what was flushed.  Throws Error where it does not take it.
  void Synchronise();
  /// Flushes, and writes a metadata record.
  void WriteMetadata(const Metadata& metadata);
  /// Flushes, writes summary and footer, and synchronises; nothing more once that is done.  Throws
  /// Error as Flush does: the file then ends without them, which readers in order do not mind.
  void Close();

  const std::string& file() const { return file_; }
  /// Bytes in the file.
  std::uint64_t size() const { return size_; }
  std::uint64_t messages() const { return messages_; }
  std::size_t channels() const { return channels_.size(); }

 private:
  struct ChunkPlace {
    std::uint64_t start_ns, end_ns, offset, length, index_length, compressed, uncompressed;
    std::map<std::uint16_t, std::uint64_t> index_offset;
  };
  struct IndexEntry {
    std::uint64_t time_ns, offset;
  };

  void WritePending();
  void Put(std::span<const std::uint8_t> bytes);
  void BuildSummary(std::vector<std::uint8_t>& out) const;

  std::string file_;
  int fd_ = -1;
  ZSTD_CCtx_s* zstd_;
  std::uint64_t size_ = 0;
  std::uint32_t crc_ = 0;  // of all bytes in the file
  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::size_t schemas_written_ = 0, channels_written_ = 0;
  std::vector<std::uint8_t> chunk_, out_;
  std::uint64_t chunk_start_ns_ = 0, chunk_end_ns_ = 0;
  std::map<std::uint16_t, std::vector<IndexEntry>> index_;
  // Of what is in the file.
  std::vector<ChunkPlace> chunks_;
  std::vector<std::pair<std::string, std::pair<std::uint64_t, std::uint64_t>>> metadata_;
  std::map<std::uint16_t, std::uint64_t> channel_messages_;
  std::uint64_t messages_ = 0, start_ns_ = 0, end_ns_ = 0;
};

}  // namespace palpate::mcap
