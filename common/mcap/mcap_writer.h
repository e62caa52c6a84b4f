#pragma once

#include <cstdint>
#include <future>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/mcap/mcap_format.h"

struct ZSTD_CCtx_s;

namespace palpate::mcap {

/// Writes one MCAP file: chunked, compressed, indexed.  Flushed data are intact in the file
/// whatever happens to this process: each chunk is written by one write(), and a write that fails
/// is undone. Synchronised data also survive a crash of the machine.  While a file is written, it
/// is locked (flock), by which others tell that it still grows.
/// Thread contract: one thread.
class Writer {
 public:
  /// @param library  name of the writing program, for the header.
  /// Throws Error if the file cannot be made, or exists already.  With `overwrite` an existing file
  /// is replaced; a program that has the old one open can go on reading it.  If the start fails, no
  /// file is left behind.
  Writer(const std::string& file, const std::string& library, bool overwrite = false);
  /// Closes the file if Close was not called; errors are then ignored.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Adds a schema.  Throws Error if the file already has kMostSchemas.
  std::uint16_t AddSchema(const std::string& name, const std::string& encoding,
                          const std::string& data);
  /// Adds a channel.  Throws Error if the file already has kMostChannels.
  std::uint16_t AddChannel(std::uint16_t schema, const std::string& topic,
                           const std::string& message_encoding, const StringMap& metadata = {});
  /// Appends a message to the open chunk.  Times are in ns since 1970.
  void Write(std::uint16_t channel, std::uint32_t sequence, std::int64_t log_time_ns,
             std::int64_t publish_time_ns, std::span<const std::uint8_t> data);
  /// Uncompressed size of the open chunk [bytes].
  std::size_t pending() const { return chunk_.size(); }
  /// Closes the open chunk and writes it.  Throws Error (file, the system's reason) or bad_alloc if
  /// that fails; the file is then as before, and the chunk is lost.
  void Flush();
  /// Has the flushed data put on the disk, without waiting for it: a disk may take longer than a
  /// reader of the file should wait for what comes next.  Does nothing while the last call's data
  /// are on their way.  Throws Error if the disk failed at those.
  void Synchronise();
  /// Flushes, and writes a metadata record.
  void WriteMetadata(const Metadata& metadata);
  /// Flushes, writes summary and footer, and synchronises; does nothing if that is done already.
  /// Throws Error as Flush does: the file then ends without summary and footer, which a sequential
  /// reader does not need.
  void Close();

  const std::string& file() const { return file_; }
  /// Size of the file [bytes].
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

  /// Waits for the disk.
  void PutOnDisk() const;
  void WritePending();
  void Put(std::span<const std::uint8_t> bytes);
  void PutStatistics(std::vector<std::uint8_t>& out) const;
  static void PutChunkIndex(std::vector<std::uint8_t>& out, const ChunkPlace& chunk);
  void BuildSummary(std::vector<std::uint8_t>& out) const;

  std::string file_;
  int fd_ = -1;
  ZSTD_CCtx_s* zstd_;
  std::uint64_t size_ = 0;
  std::uint32_t crc_ = 0;  // over all bytes in the file
  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::size_t schemas_written_ = 0, channels_written_ = 0;
  std::vector<std::uint8_t> chunk_, out_;
  std::uint64_t chunk_start_ns_ = 0, chunk_end_ns_ = 0;
  std::map<std::uint16_t, std::vector<IndexEntry>> index_;
  // Describes what has been written to the file.
  std::vector<ChunkPlace> chunks_;
  std::vector<std::pair<std::string, std::pair<std::uint64_t, std::uint64_t>>> metadata_;
  std::map<std::uint16_t, std::uint64_t> channel_messages_;
  std::uint64_t messages_ = 0, start_ns_ = 0, end_ns_ = 0;
  std::future<void> synchronising_;
};

}  // namespace palpate::mcap
