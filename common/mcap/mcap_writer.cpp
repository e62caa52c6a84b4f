#include "common/mcap/mcap_writer.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include "common/error.h"
#include "common/text/quoted.h"

namespace palpate::mcap {
namespace {

/// Compression level, of zstd's 22: it takes less than a hundredth of a core at 1 kHz, and higher
/// levels gain little on numbers.
constexpr int kLevel = 3;

using Bytes = std::vector<std::uint8_t>;

template <class Integer>
void PutInteger(Bytes& out, Integer value) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    out.push_back(static_cast<std::uint8_t>(value >> 8 * i));
  }
}
void PutBytes(Bytes& out, const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  out.insert(out.end(), bytes, bytes + size);
}
void PutString(Bytes& out, const std::string& text) {
  PutInteger(out, static_cast<std::uint32_t>(text.size()));
  PutBytes(out, text.data(), text.size());
}
/// Writes a map.  Its values come from outside (names of files and scenes, reasons): readers expect
/// UTF-8, and ours a limited length.
void PutMap(Bytes& out, const StringMap& map) {
  Bytes content;
  for (const auto& [key, value] : map) {
    PutString(content, key);
    PutString(content, std::string(BeginningOf(Printable(value), kMostText)));
  }
  PutInteger(out, static_cast<std::uint32_t>(content.size()));
  PutBytes(out, content.data(), content.size());
}

/// A record being written; the destructor sets its length.
class Record {
 public:
  Record(Bytes& out, Opcode opcode) : out_(out) {
    out.push_back(opcode);
    PutInteger(out, std::uint64_t{0});
    begin_ = out.size();
  }
  ~Record() {
    const std::uint64_t length = out_.size() - begin_;
    for (std::size_t i = 0; i < 8; ++i) {
      out_[begin_ - 8 + i] = static_cast<std::uint8_t>(length >> 8 * i);
    }
  }
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

 private:
  Bytes& out_;
  std::size_t begin_;
};

void PutSchema(Bytes& out, const Schema& schema) {
  const Record record(out, kSchema);
  PutInteger(out, schema.id);
  PutString(out, schema.name);
  PutString(out, schema.encoding);
  PutString(out, schema.data);
}

void PutChannel(Bytes& out, const Channel& channel) {
  const Record record(out, kChannel);
  PutInteger(out, channel.id);
  PutInteger(out, channel.schema_id);
  PutString(out, channel.topic);
  PutString(out, channel.message_encoding);
  PutMap(out, channel.metadata);
}

std::uint32_t Crc(std::uint32_t crc, std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(crc32_z(crc, bytes.data(), bytes.size()));
}

}  // namespace

Writer::Writer(const std::string& file, const std::string& library, bool overwrite)
    : file_(file), zstd_(ZSTD_createCCtx()) {
  ZSTD_CCtx_setParameter(zstd_, ZSTD_c_compressionLevel, kLevel);
  // A regular file is replaced, not emptied: another program may have it mapped.
  struct stat former {};
  const bool regular = stat(file.c_str(), &former) != 0 || S_ISREG(former.st_mode);
  if (overwrite && regular) unlink(file.c_str());
  const bool must_be_new = regular || !overwrite;
  fd_ = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (must_be_new ? O_EXCL : 0), 0644);
  try {
    if (fd_ < 0) {
      throw Error(file + ": " +
                  (errno == EEXIST
                       ? "exists already; give another name, or --overwrite"
                       : std::string(std::strerror(errno)) + "; give a folder that is writable"));
    }
    // Tells others that this file still grows; a device may refuse it.
    [[maybe_unused]] const int locked = flock(fd_, LOCK_EX | LOCK_NB);
    PutBytes(out_, kMagic, kMagicSize);
    {
      const Record record(out_, kHeader);
      PutString(out_, "");
      PutString(out_, library);
    }
    Put(out_);
  } catch (...) {
    if (fd_ >= 0) {
      close(fd_);
      if (must_be_new) unlink(file.c_str());
    }
    ZSTD_freeCCtx(zstd_);
    throw;
  }
}

Writer::~Writer() {
  try {
    Close();
  } catch (...) {
    // Call Close() to learn of errors.
  }
  ZSTD_freeCCtx(zstd_);
}

void Writer::Put(std::span<const std::uint8_t> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = write(fd_, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const std::string why = n < 0 ? std::strerror(errno) : "nothing was written";
      // Half a record would end the file for every reader.  The size of a device cannot be set.
      struct stat status {};
      if (fstat(fd_, &status) == 0 && S_ISREG(status.st_mode)) {
        if (ftruncate(fd_, static_cast<off_t>(size_)) == 0) lseek(fd_, 0, SEEK_END);
      }
      throw Error(file_ + ": " + why + "; free some space, or record to another place");
    }
    done += static_cast<std::size_t>(n);
  }
  size_ += bytes.size();
  crc_ = Crc(crc_, bytes);
}

std::uint16_t Writer::AddSchema(const std::string& name, const std::string& encoding,
                                const std::string& data) {
  if (schemas_.size() == kMostSchemas)
    throw Error(file_ + ": has all the schemas that MCAP allows");
  const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
  schemas_.push_back({id, name, encoding, data});
  return id;
}

std::uint16_t Writer::AddChannel(std::uint16_t schema, const std::string& topic,
                                 const std::string& message_encoding, const StringMap& metadata) {
  if (channels_.size() == kMostChannels) {
    throw Error(file_ + ": has all the channels that MCAP allows");
  }
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  channels_.push_back({id, schema, topic, message_encoding, metadata});
  return id;
}

void Writer::Write(std::uint16_t channel, std::uint32_t sequence, std::int64_t log_time_ns,
                   std::int64_t publish_time_ns, std::span<const std::uint8_t> data) {
  const auto time_ns = static_cast<std::uint64_t>(log_time_ns);
  if (chunk_.empty()) chunk_start_ns_ = chunk_end_ns_ = time_ns;
  chunk_start_ns_ = std::min(chunk_start_ns_, time_ns);
  chunk_end_ns_ = std::max(chunk_end_ns_, time_ns);
  index_[channel].push_back({time_ns, chunk_.size()});
  const Record record(chunk_, kMessage);
  PutInteger(chunk_, channel);
  PutInteger(chunk_, sequence);
  PutInteger(chunk_, time_ns);
  PutInteger(chunk_, static_cast<std::uint64_t>(publish_time_ns));
  PutBytes(chunk_, data.data(), data.size());
}

void Writer::Flush() {
  try {
    WritePending();
  } catch (...) {
    // Frees memory, which may be what was lacking.
    index_.clear();
    Bytes().swap(chunk_);
    Bytes().swap(out_);
    throw;
  }
}

void Writer::WritePending() {
  out_.clear();
  // Written outside of the chunk, so that a reader that skips the chunk still finds them.
  for (std::size_t i = schemas_written_; i < schemas_.size(); ++i) PutSchema(out_, schemas_[i]);
  for (std::size_t i = channels_written_; i < channels_.size(); ++i) PutChannel(out_, channels_[i]);
  if (chunk_.empty()) {
    if (out_.empty()) return;
    Put(out_);
    schemas_written_ = schemas_.size();
    channels_written_ = channels_.size();
    return;
  }

  ChunkPlace place{.start_ns = chunk_start_ns_,
                   .end_ns = chunk_end_ns_,
                   .offset = size_ + out_.size(),
                   .length = 0,
                   .index_length = 0,
                   .compressed = 0,
                   .uncompressed = chunk_.size(),
                   .index_offset = {}};
  {
    const Record record(out_, kChunk);
    PutInteger(out_, chunk_start_ns_);
    PutInteger(out_, chunk_end_ns_);
    PutInteger(out_, static_cast<std::uint64_t>(chunk_.size()));
    PutInteger(out_, Crc(0, chunk_));
    PutString(out_, "zstd");
    const std::size_t at = out_.size();
    out_.resize(at + 8 + ZSTD_compressBound(chunk_.size()));
    place.compressed = ZSTD_compress2(zstd_, out_.data() + at + 8, out_.size() - at - 8,
                                      chunk_.data(), chunk_.size());
    if (ZSTD_isError(place.compressed)) {
      throw Error(file_ + ": zstd: " + ZSTD_getErrorName(place.compressed));
    }
    out_.resize(at + 8 + place.compressed);
    for (std::size_t i = 0; i < 8; ++i) {
      out_[at + i] = static_cast<std::uint8_t>(place.compressed >> 8 * i);
    }
  }
  const std::uint64_t end = size_ + out_.size();
  place.length = end - place.offset;
  for (const auto& [channel, entries] : index_) {
    place.index_offset[channel] = size_ + out_.size();
    const Record record(out_, kMessageIndex);
    PutInteger(out_, channel);
    PutInteger(out_, static_cast<std::uint32_t>(16 * entries.size()));
    for (const IndexEntry& entry : entries) {
      PutInteger(out_, entry.time_ns);
      PutInteger(out_, entry.offset);
    }
  }
  place.index_length = size_ + out_.size() - end;

  const auto index = std::exchange(index_, {});
  chunk_.clear();
  Put(out_);
  schemas_written_ = schemas_.size();
  channels_written_ = channels_.size();
  for (const auto& [channel, entries] : index) {
    channel_messages_[channel] += entries.size();
    messages_ += entries.size();
  }
  start_ns_ = chunks_.empty() ? place.start_ns : std::min(start_ns_, place.start_ns);
  end_ns_ = std::max(end_ns_, place.end_ns);
  chunks_.push_back(std::move(place));
}

void Writer::Synchronise() {
  constexpr std::chrono::seconds kNow{0};
  if (synchronising_.valid()) {
    if (synchronising_.wait_for(kNow) == std::future_status::timeout) return;
    synchronising_.get();
  }
  // Where no thread can be made, the next call waits.
  synchronising_ = std::async([this] { PutOnDisk(); });
}

void Writer::PutOnDisk() const {
  // Pipes and devices have nothing to synchronise.
  if (fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS) {
    throw Error(file_ + ": " + std::strerror(errno) + "; record to another place");
  }
}

void Writer::WriteMetadata(const Metadata& metadata) {
  Flush();
  out_.clear();
  {
    const Record record(out_, kMetadata);
    PutString(out_, metadata.name);
    PutMap(out_, metadata.values);
  }
  const std::uint64_t offset = size_;
  Put(out_);
  metadata_.push_back({metadata.name, {offset, out_.size()}});
}

void Writer::PutStatistics(Bytes& out) const {
  const Record record(out, kStatistics);
  PutInteger(out, messages_);
  PutInteger(out, static_cast<std::uint16_t>(schemas_written_));
  PutInteger(out, static_cast<std::uint32_t>(channels_written_));
  PutInteger(out, std::uint32_t{0});
  PutInteger(out, static_cast<std::uint32_t>(metadata_.size()));
  PutInteger(out, static_cast<std::uint32_t>(chunks_.size()));
  PutInteger(out, start_ns_);
  PutInteger(out, end_ns_);
  PutInteger(out, static_cast<std::uint32_t>(10 * channel_messages_.size()));
  for (const auto& [channel, count] : channel_messages_) {
    PutInteger(out, channel);
    PutInteger(out, count);
  }
}

void Writer::PutChunkIndex(Bytes& out, const ChunkPlace& chunk) {
  const Record record(out, kChunkIndex);
  PutInteger(out, chunk.start_ns);
  PutInteger(out, chunk.end_ns);
  PutInteger(out, chunk.offset);
  PutInteger(out, chunk.length);
  PutInteger(out, static_cast<std::uint32_t>(10 * chunk.index_offset.size()));
  for (const auto& [channel, offset] : chunk.index_offset) {
    PutInteger(out, channel);
    PutInteger(out, offset);
  }
  PutInteger(out, chunk.index_length);
  PutString(out, "zstd");
  PutInteger(out, chunk.compressed);
  PutInteger(out, chunk.uncompressed);
}

void Writer::BuildSummary(Bytes& out) const {
  {
    const Record record(out, kDataEnd);
    PutInteger(out, crc_);
  }
  const std::size_t summary = out.size();
  std::vector<std::pair<Opcode, std::pair<std::size_t, std::size_t>>> groups;
  const auto group = [&](Opcode opcode, const auto& put) {
    const std::size_t begin = out.size();
    put();
    if (out.size() > begin) groups.push_back({opcode, {begin, out.size() - begin}});
  };
  group(kSchema, [&] {
    for (std::size_t i = 0; i < schemas_written_; ++i) PutSchema(out, schemas_[i]);
  });
  group(kChannel, [&] {
    for (std::size_t i = 0; i < channels_written_; ++i) PutChannel(out, channels_[i]);
  });
  group(kStatistics, [&] { PutStatistics(out); });
  group(kChunkIndex, [&] {
    for (const ChunkPlace& chunk : chunks_) PutChunkIndex(out, chunk);
  });
  group(kMetadataIndex, [&] {
    for (const auto& [name, place] : metadata_) {
      const Record record(out, kMetadataIndex);
      PutInteger(out, place.first);
      PutInteger(out, place.second);
      PutString(out, name);
    }
  });
  const std::size_t offsets = out.size();
  for (const auto& [opcode, place] : groups) {
    const Record record(out, kSummaryOffset);
    out.push_back(opcode);
    PutInteger(out, static_cast<std::uint64_t>(size_ + place.first));
    PutInteger(out, static_cast<std::uint64_t>(place.second));
  }
  {
    const Record record(out, kFooter);
    PutInteger(out, static_cast<std::uint64_t>(size_ + summary));
    PutInteger(out, static_cast<std::uint64_t>(size_ + offsets));
    // The checksum covers all up to here, including this record's head, whose length is set at
    // its end.
    Bytes covered(out.begin() + static_cast<std::ptrdiff_t>(summary), out.end());
    covered[covered.size() - 24] = 20;
    PutInteger(out, Crc(0, covered));
  }
  PutBytes(out, kMagic, kMagicSize);
}

void Writer::Close() {
  if (fd_ < 0) return;
  const auto end = [this] { return close(std::exchange(fd_, -1)) == 0; };
  try {
    Flush();
    out_.clear();
    BuildSummary(out_);
    Put(out_);
    if (synchronising_.valid()) synchronising_.get();
    PutOnDisk();
  } catch (...) {
    if (synchronising_.valid()) synchronising_.wait();
    end();
    throw;
  }
  // Some file systems report write errors only on close.
  if (!end()) throw Error(file_ + ": " + std::strerror(errno) + "; record to another place");
}

}  // namespace palpate::mcap
