#include "common/mcap/mcap_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include "common/error.h"
#include "common/text/quoted.h"

namespace palpate::mcap {
namespace {

/// Size limit of a chunk.  Ours are far smaller; a file that claims more is broken or malicious.
constexpr std::uint64_t kMaxChunk = std::uint64_t{1} << 30;
constexpr std::size_t kMaxProblems = 20;
constexpr std::uint64_t kLatest_ns = std::numeric_limits<std::int64_t>::max() / 2;

/// Reads the fields of a record.  Once one does not fit, or is too long a text, ok() is false and
/// all further fields are empty.
class Fields {
 public:
  explicit Fields(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

  template <class Integer>
  Integer Take() {
    Integer value = 0;
    const auto bytes = TakeBytes(sizeof value);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      value = static_cast<Integer>(value | static_cast<Integer>(Integer{bytes[i]} << 8 * i));
    }
    return value;
  }
  std::span<const std::uint8_t> TakeBytes(std::uint64_t size) {
    if (size > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const auto taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  std::string TakeString(std::size_t most = kMostText) {
    const auto size = Take<std::uint32_t>();
    if (size > most) too_long_ = true;
    const auto bytes = TakeBytes(too_long_ ? std::numeric_limits<std::uint64_t>::max() : size);
    return {bytes.begin(), bytes.end()};
  }
  std::int64_t TakeTime_ns() {
    return static_cast<std::int64_t>(std::min(Take<std::uint64_t>(), kLatest_ns));
  }
  StringMap TakeMap() {
    Fields entries(TakeBytes(Take<std::uint32_t>()));
    StringMap map;
    while (entries.ok_ && !entries.rest_.empty()) {
      std::string key = entries.TakeString();
      map[std::move(key)] = entries.TakeString();
    }
    ok_ = ok_ && entries.ok_;
    too_long_ = too_long_ || entries.too_long_;
    return map;
  }
  std::span<const std::uint8_t> rest() const { return rest_; }
  bool ok() const { return ok_; }
  /// Returns what is wrong with the record if ok() is false.
  std::string Problem() const {
    return too_long_ ? "has a name of more than " + std::to_string(kMostText) + " bytes: left out"
                     : "is too short for its fields: left out";
  }

 private:
  std::span<const std::uint8_t> rest_;
  bool ok_ = true, too_long_ = false;
};

std::uint32_t Crc(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

std::string At(std::size_t offset) {
  return " at byte " + std::to_string(offset);
}

}  // namespace

MappedFile::MappedFile(const std::string& file) {
  const int fd =
      open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // open would wait for a pipe's writer
  struct stat status {};
  if (fd < 0 || fstat(fd, &status) != 0) {
    const std::string why = std::strerror(errno);
    if (fd >= 0) close(fd);
    throw Error(file + ": " + why + "; give the path of a recording");
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (S_ISREG(status.st_mode) && size > 0) {
    void* const memory = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (memory != MAP_FAILED) bytes_ = {static_cast<const std::uint8_t*>(memory), size};
  }
  close(fd);
  if (!S_ISREG(status.st_mode) || (size > 0 && bytes_.empty())) {
    throw Error(file + ": cannot be read as a file; give the path of a recording");
  }
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) munmap(const_cast<std::uint8_t*>(bytes_.data()), bytes_.size());
}

Reader::Reader(std::span<const std::uint8_t> bytes, std::string source)
    : bytes_(bytes), source_(std::move(source)) {
  if (bytes.size() < kMagicSize || std::memcmp(bytes.data(), kMagic, kMagicSize) != 0) {
    throw Error(source_ + ": is not an MCAP file; give a recording of palpate-record");
  }
  at_ = kMagicSize;
}

bool Reader::TakeRecord(std::span<const std::uint8_t> bytes, std::size_t& at, Record& record) {
  Fields fields(bytes.subspan(at));
  record.opcode = fields.Take<std::uint8_t>();
  record.content = fields.TakeBytes(fields.Take<std::uint64_t>());
  if (!fields.ok()) return false;
  at += kRecordHead + record.content.size();
  return true;
}

void Reader::End() {
  ended_ = true;
  // Frees the memory: a reader of many splits keeps a Reader for each.
  std::vector<std::uint8_t>().swap(chunk_);
  if (std::exchange(read_once_, true)) return;
  for (const auto& [channel, messages] : undeclared_) {
    Damaged(source_ + ": " + std::to_string(messages) + " messages of channel " +
            std::to_string(channel) + ", which is nowhere declared: left out");
  }
}

void Reader::Stop(const std::string& problem) {
  End();
  AddProblem(problem);
}

void Reader::Damaged(const std::string& problem) {
  damaged_ = true;
  if (problems_.size() < kMaxProblems) AddProblem(problem);
}

void Reader::AddProblem(const std::string& problem) {
  if (std::ranges::find(problems_, problem) == problems_.end()) problems_.push_back(problem);
}

/// Takes a declaration.  A file may repeat one, but not give its id a second meaning: messages
/// would be returned under another's name.
template <class Declared>
void Reader::Declare(std::map<std::uint16_t, Declared>& all, Declared declared, const char* what,
                     std::string Declared::*name) {
  const std::uint16_t id = declared.id;
  const auto [known, is_new] = all.try_emplace(id, declared);
  if (is_new || known->second == declared) return;
  damaged_ = true;
  Stop(source_ + ": " + what + " " + std::to_string(id) + " is declared twice, as " +
       Quoted(known->second.*name) + " and as " + Quoted(declared.*name) +
       ": nothing from there on is read" + At(offset_));
}

bool Reader::TakeBasic(const Record& record, Message& message) {
  Fields fields(record.content);
  if (record.opcode == kSchema) {
    Schema schema;
    schema.id = fields.Take<std::uint16_t>();
    schema.name = fields.TakeString();
    schema.encoding = fields.TakeString();
    schema.data = fields.TakeString(record.content.size());
    if (fields.ok()) Declare(schemas_, std::move(schema), "schema", &Schema::name);
  } else if (record.opcode == kChannel) {
    Channel channel;
    channel.id = fields.Take<std::uint16_t>();
    channel.schema_id = fields.Take<std::uint16_t>();
    channel.topic = fields.TakeString();
    channel.message_encoding = fields.TakeString();
    channel.metadata = fields.TakeMap();
    if (fields.ok()) Declare(channels_, std::move(channel), "channel", &Channel::topic);
  } else if (record.opcode == kMessage) {
    const auto id = fields.Take<std::uint16_t>();
    const auto channel = channels_.find(id);
    message.sequence = fields.Take<std::uint32_t>();
    message.log_time_ns = fields.TakeTime_ns();
    message.publish_time_ns = fields.TakeTime_ns();
    message.data = fields.rest();
    if (fields.ok() && channel != channels_.end()) {
      message.channel = &channel->second;
      return true;
    }
    if (fields.ok()) ++undeclared_[id];
  }
  if (!fields.ok()) Damaged(source_ + ": a record before" + At(at_) + ' ' + fields.Problem());
  return false;
}

void Reader::OpenChunk(std::span<const std::uint8_t> content, std::size_t offset) {
  first_chunk_ = std::min(first_chunk_, offset);
  Fields fields(content);
  fields.TakeBytes(16);  // times of its first and last message; not needed
  const auto size = fields.Take<std::uint64_t>();
  const auto crc = fields.Take<std::uint32_t>();
  const std::string compression = fields.TakeString();
  const auto records = fields.TakeBytes(fields.Take<std::uint64_t>());

  std::string problem;
  bool changed = true;  // false: intact, but of an unsupported kind
  if (!fields.ok() || size > kMaxChunk) {
    problem = "says impossible sizes";
  } else if (compression.empty()) {
    chunk_.assign(records.begin(), records.end());
  } else if (compression != "zstd") {
    problem = "is compressed by " + Quoted(compression) + ", which this version does not read";
    changed = false;
  } else if (ZSTD_getFrameContentSize(records.data(), records.size()) != size) {
    problem = "contradicts itself about its size";
  } else {
    chunk_.resize(size);
    const std::size_t n =
        ZSTD_decompress(chunk_.data(), chunk_.size(), records.data(), records.size());
    if (ZSTD_isError(n)) problem = std::string("does not decompress: ") + ZSTD_getErrorName(n);
  }
  if (problem.empty() && crc != 0 && crc != Crc(chunk_)) {
    problem = "has other bytes than were written (its checksum differs)";
  }
  chunk_at_ = 0;
  chunk_offset_ = offset;
  if (problem.empty()) return;
  chunk_.clear();
  const bool damaged = damaged_ || changed;
  Damaged(source_ + ": the chunk" + At(offset) + " " + problem + ": left out");
  damaged_ = damaged;
}

void Reader::GoTo(std::size_t offset) {
  at_ = offset;
  chunk_.clear();
  chunk_at_ = 0;
  ended_ = false;
}

void Reader::Grow(std::span<const std::uint8_t> bytes) {
  bytes_ = bytes;
  if (complete_ || damaged_) return;
  problems_.clear();
  read_once_ = false;
  GoTo(offset_);
}

bool Reader::Next(Message& message) {
  Record record{};
  while (!ended_) {
    if (chunk_at_ < chunk_.size()) {
      if (!TakeRecord(chunk_, chunk_at_, record)) {
        chunk_.clear();
        Damaged(source_ + ": the chunk" + At(chunk_offset_) +
                " ends within a record: its rest is left out");
      } else if (TakeBasic(record, message)) {
        return true;
      }
      continue;
    }
    const std::size_t offset = offset_ = at_;
    if (at_ == bytes_.size()) {
      Stop(source_ + ": has no end: its recorder was cut off" + At(offset));
    } else if (!TakeRecord(bytes_, at_, record)) {
      Stop(source_ + ": is cut off within a record" + At(offset));
    } else if (record.opcode == kChunk) {
      OpenChunk(record.content, offset);
    } else if (record.opcode == kMetadata) {
      Fields fields(record.content);
      Metadata metadata;
      metadata.name = fields.TakeString();
      metadata.values = fields.TakeMap();
      if (!fields.ok()) {
        Damaged(source_ + ": a record" + At(offset) + ' ' + fields.Problem());
      } else if (offset >= seen_) {
        metadata_.push_back(std::move(metadata));
      }
      seen_ = std::max(seen_, at_);
    } else if (record.opcode == kDataEnd) {
      const auto crc = Fields(record.content).Take<std::uint32_t>();
      bool changed = crc != 0 && crc != Crc(bytes_.first(offset));
      // The summary repeats earlier records; check only that it is complete and unaltered.
      const auto index = bytes_.subspan(at_);
      complete_ = index.size() >= kMagicSize + sizeof crc &&
                  std::memcmp(&index[index.size() - kMagicSize], kMagic, kMagicSize) == 0;
      if (complete_) {
        const auto covered = index.first(index.size() - kMagicSize - sizeof crc);
        const auto index_crc = Fields(index.subspan(covered.size())).Take<std::uint32_t>();
        changed = changed || (index_crc != 0 && index_crc != Crc(covered));
      }
      if (changed) Damaged(source_ + ": some of its bytes have changed since it was written");
      if (complete_) {
        End();
      } else {
        Stop(source_ + ": is cut off within its index; all its data are there");
      }
    } else if (record.opcode == 0 || record.opcode == kFooter ||
               (record.opcode == kMessage && offset > first_chunk_)) {
      // A writer of chunks writes no messages outside of them.
      damaged_ = true;
      Stop(source_ + ": has a record that cannot be there" + At(offset));
    } else if (TakeBasic(record, message)) {
      return true;
    }
  }
  return false;
}

}  // namespace palpate::mcap
