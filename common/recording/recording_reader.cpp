#include "common/recording/recording_reader.h"

#include <algorithm>

namespace palpate {

RecordingReader::RecordingReader(const std::vector<std::string>& files) : names_(files) {
  for (const std::string& file : files) {
    files_.push_back(std::make_unique<mcap::MappedFile>(file));
    mcap::Reader(files_.back()->bytes(), file);  // is it one at all?
  }
}

void RecordingReader::Restart() {
  readers_.clear();
  complete_ = true;
  unknown_ = 0;
}

bool RecordingReader::Next(RecordedSample& sample) {
  mcap::Message message;
  for (;;) {
    if (readers_.empty() || !readers_.back()->Next(message)) {
      if (!readers_.empty()) complete_ = complete_ && readers_.back()->complete();
      const std::size_t next = readers_.size();
      if (next == files_.size()) return false;
      readers_.push_back(std::make_unique<mcap::Reader>(files_[next]->bytes(), names_[next]));
      continue;
    }
    const auto& schemas = readers_.back()->schemas();
    const auto schema = schemas.find(message.channel->schema_id);
    const auto type = schema == schemas.end() ? std::nullopt : TypeOfSchema(schema->second.name);
    if (!type || message.channel->message_encoding != "cdr") {
      ++unknown_;
      continue;
    }
    sample = {*type, &message.channel->topic, message.log_time_ns, message.data};
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
