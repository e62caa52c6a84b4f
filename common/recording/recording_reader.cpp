#include "common/recording/recording_reader.h"

#include <algorithm>

#include "common/text/number_of.h"

namespace palpate {
namespace {

/// Upper limit of the bytes that fields added since a recording can take; surplus bytes
/// are ignored.
constexpr std::size_t kMostAdded = 256;

/// No recorder reaches this count, and the sum over 65,535 topics does not overflow.
constexpr std::uint64_t kMostCount = std::uint64_t{1} << 47;

}  // namespace

std::optional<std::uint64_t> CountIn(const mcap::StringMap& metadata, const std::string& key) {
  const auto found = metadata.find(key);
  if (found == metadata.end()) return 0;
  const auto count = NumberOf<std::uint64_t>(found->second);
  return count < kMostCount ? count : std::nullopt;
}

RecordingReader::RecordingReader(const std::vector<std::string>& files) : names_(files) {
  for (const std::string& file : files) {
    files_.push_back(std::make_unique<mcap::MappedFile>(file));
    mcap::Reader(files_.back()->bytes(), file);  // throws if it is no MCAP file
  }
}

void RecordingReader::Restart() {
  readers_.clear();
  begun_ = 0;
  complete_ = true;
  unknown_ = 0;
}

void RecordingReader::GoTo(const Place& place) {
  begun_ = place.file + 1;
  readers_[place.file]->GoTo(place.offset);
}

void RecordingReader::Grow() {
  auto grown = std::make_unique<mcap::MappedFile>(names_.back());
  complete_ = true;
  readers_.back()->Grow(grown->bytes());
  files_.back() = std::move(grown);
}

bool RecordingReader::Next(RecordedSample& sample) {
  mcap::Message message;
  for (;;) {
    if (begun_ == 0 || !readers_[begun_ - 1]->Next(message)) {
      if (begun_ > 0) complete_ = complete_ && readers_[begun_ - 1]->complete();
      if (begun_ == files_.size()) return false;
      if (begun_ < readers_.size()) {
        readers_[begun_]->GoTo(mcap::kMagicSize);
      } else {
        readers_.push_back(std::make_unique<mcap::Reader>(files_[begun_]->bytes(), names_[begun_]));
      }
      ++begun_;
      continue;
    }
    const auto& schemas = readers_[begun_ - 1]->schemas();
    const auto schema = schemas.find(message.channel->schema_id);
    const auto type = schema == schemas.end() ? std::nullopt : TypeOfSchema(schema->second.name);
    if (!type || message.channel->message_encoding != "cdr") {
      ++unknown_;
      continue;
    }
    sample = {*type, &message.channel->topic, message.log_time_ns, message.data};
    const bool of_loop = *type == RecordedType::kHapticPose || *type == RecordedType::kWrench;
    if (!of_loop && schema->second.data != SchemaText(*type)) {
      older_.assign(message.data.begin(), message.data.end());
      older_.resize(older_.size() + kMostAdded);
      sample.cdr = older_;
    }
    return true;
  }
}

bool RecordingReader::damaged() const {
  return std::ranges::any_of(readers_, [](const auto& reader) { return reader->damaged(); });
}

std::vector<std::string> RecordingReader::problems() const {
  std::vector<std::string> all;
  for (const auto& reader : readers_) {
    all.insert(all.end(), reader->problems().begin(), reader->problems().end());
  }
  return all;
}

std::vector<mcap::Metadata> RecordingReader::metadata() const {
  std::vector<mcap::Metadata> all;
  for (const auto& reader : readers_) {
    all.insert(all.end(), reader->metadata().begin(), reader->metadata().end());
  }
  return all;
}

std::uint64_t RecordingReader::bytes() const {
  std::uint64_t sum = 0;
  for (const auto& file : files_) sum += file->bytes().size();
  return sum;
}

}  // namespace palpate
