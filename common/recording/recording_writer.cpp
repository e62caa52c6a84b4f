#include "common/recording/recording_writer.h"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "common/dds/cdr.h"
#include "common/dds/cdr_reader.h"
#include "common/error.h"

namespace palpate {
namespace {

std::string Hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, value);
  return text;
}

std::string SplitName(const std::string& file, std::size_t number) {
  std::filesystem::path path(file);
  char digits[24];
  std::snprintf(digits, sizeof digits, "_%03zu", number);
  path.replace_filename(path.stem().string() + digits + path.extension().string());
  return path.string();
}

/// The splits of a former recording of that name.  Whatever their number: a reader that takes all
/// of them would mix two recordings.
std::vector<std::filesystem::path> FormerSplits(const std::string& file) {
  const std::filesystem::path path(file);
  const std::string begin = path.stem().string() + "_", end = path.extension().string();
  const auto is_split = [&](const std::string& name) {
    if (name.size() < begin.size() + 3 + end.size() || !name.starts_with(begin) ||
        !name.ends_with(end)) {
      return false;
    }
    const auto first = name.begin() + static_cast<std::ptrdiff_t>(begin.size());
    const auto last = name.end() - static_cast<std::ptrdiff_t>(end.size());
    return std::all_of(first, last, [](char c) { return c >= '0' && c <= '9'; });
  };
  std::vector<std::filesystem::path> found;
  std::error_code none;  // where it cannot be listed, the writer says why
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    if (is_split(entry.path().filename().string())) found.push_back(entry.path());
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace

RecordingWriter::RecordingWriter(RecordingOptions options) : options_(std::move(options)) {
  if (options_.split_bytes > 0 || options_.split_s > 0.0) {
    const auto former = FormerSplits(options_.file);
    if (!former.empty() && !options_.overwrite) {
      throw Error(former.front().string() + ": is there already, and a split of " + options_.file +
                  " may want that name; give another name, or --overwrite");
    }
    for (const auto& split : former) std::filesystem::remove(split);
  }
  Open();
}

void RecordingWriter::Open() {
  const bool splits = options_.split_bytes > 0 || options_.split_s > 0.0;
  const std::string file = splits ? SplitName(options_.file, files_.size()) : options_.file;
  file_ = std::make_unique<mcap::Writer>(file, "palpate " PALPATE_VERSION, options_.overwrite);
  files_.push_back(file);
  finished_ = false;
  repeated_bytes_ = 0;
  schema_ = {};
  for (auto& [name, topic] : topics_) topic.channel = 0;
  mcap::StringMap about = options_.about;
  about["build"] = PALPATE_VERSION;
  about["split"] = std::to_string(files_.size() - 1);
  file_->WriteMetadata({"palpate.recording", about});
  for (const auto& [name, scene] : scenes_) file_->WriteMetadata({"palpate.scene", scene});
}

void RecordingWriter::Finish(const std::string& reason) {
  std::uint64_t dropped = 0;
  for (const auto& [name, topic] : topics_) {
    dropped += topic.dropped;
    mcap::StringMap figures{{"topic", name},
                            {"type", SchemaName(topic.type)},
                            {"messages", std::to_string(topic.messages)},
                            {"dropped", std::to_string(topic.dropped)}};
    if (topic.messages > 0) {
      figures["first"] = std::to_string(topic.sequence.first());
      figures["last"] = std::to_string(topic.sequence.last());
      figures["holes"] = std::to_string(topic.sequence.holes());
      figures["missing"] = std::to_string(topic.sequence.missing());
    }
    file_->WriteMetadata({"palpate.topic", figures});
  }
  // Of all splits so far.
  file_->WriteMetadata({"palpate.end",
                        {{"reason", reason},
                         {"messages", std::to_string(messages_)},
                         {"dropped", std::to_string(dropped)},
                         {"missing", std::to_string(missing())}}});
  file_->Close();
  closed_bytes_ += file_->size();
  finished_ = true;
}

void RecordingWriter::Close(const std::string& reason) {
  if (!finished_) Finish(reason);
}

std::uint64_t RecordingWriter::missing() const {
  std::uint64_t sum = 0;
  for (const auto& [name, topic] : topics_) sum += topic.sequence.missing();
  return sum;
}

void RecordingWriter::SetDropped(const std::string& topic, RecordedType type,
                                 std::uint64_t dropped) {
  // A topic all of whose samples were dropped is known by that alone.
  topics_.try_emplace(topic, Topic{type}).first->second.dropped = dropped;
}

void RecordingWriter::SplitIfDue(std::int64_t log_time_ns) {
  if (file_began_ns_ == 0) file_began_ns_ = log_time_ns;
  const double age_s = 1e-9 * static_cast<double>(log_time_ns - file_began_ns_);
  const bool due =
      (options_.split_bytes > 0 && file_->size() - repeated_bytes_ >= options_.split_bytes) ||
      (options_.split_s > 0.0 && age_s >= options_.split_s);
  if (!due) return;
  Finish("goes on in the next split");
  file_began_ns_ = log_time_ns;
  Open();
  for (const auto& [key, kept] : kept_) {
    Topic& topic = topics_.at(kept.topic);
    Put(kept.topic, topic, log_time_ns, topic.messages, kept.cdr);
  }
  file_->Flush();
  repeated_bytes_ = file_->size();
}

void RecordingWriter::Add(const std::string& name, RecordedType type, std::int64_t log_time_ns,
                          std::span<const std::uint8_t> cdr) {
  SplitIfDue(log_time_ns);
  Topic& topic = topics_.try_emplace(name, Topic{type}).first->second;
  const std::uint64_t sequence = Look(name, topic, cdr);
  topic.sequence.Add(sequence);
  ++topic.messages;
  ++messages_;
  if (type == RecordedType::kSceneBundle && !options_.bundles) return;
  Put(name, topic, log_time_ns, sequence, cdr);
}

void RecordingWriter::Put(const std::string& name, Topic& topic, std::int64_t log_time_ns,
                          std::uint64_t sequence, std::span<const std::uint8_t> cdr) {
  if (topic.channel == 0) {
    std::uint16_t& schema = schema_[static_cast<std::size_t>(topic.type)];
    if (schema == 0) {
      schema = file_->AddSchema(SchemaName(topic.type), "omgidl", SchemaText(topic.type));
    }
    topic.channel = file_->AddChannel(schema, name, "cdr");
  }
  file_->Write(topic.channel, static_cast<std::uint32_t>(sequence), log_time_ns, log_time_ns, cdr);
  if (file_->pending() >= kChunk) file_->Flush();
}

std::uint64_t RecordingWriter::Look(const std::string& name, Topic& topic,
                                    std::span<const std::uint8_t> cdr) {
  const std::uint64_t count = topic.messages + 1;
  const auto keep = [&](const std::string& key, std::uint64_t server_run) {
    kept_[name + key] = {name, topic.type, server_run, {cdr.begin(), cdr.end()}};
  };
  switch (topic.type) {
    case RecordedType::kHapticPose: {
      wire::HapticPose pose;
      return dds::FromCdr(cdr, pose) ? pose.pose_sequence : count;
    }
    case RecordedType::kWrench: {
      wire::Wrench wrench;
      return dds::FromCdr(cdr, wrench) ? wrench.answer : count;
    }
    case RecordedType::kSessionState: {
      wire::SessionState state{};
      if (dds::FromCdr(cdr, state)) keep(std::string("/") + state.station, state.server_run);
      return count;
    }
    case RecordedType::kSceneChange: {
      wire::SceneChange change{};
      if (!dds::FromCdr(cdr, change)) return count;
      // Of the scene as it stands now: another run of the server finds it whole again.
      std::erase_if(kept_, [&](const auto& entry) {
        return entry.second.type == topic.type && entry.second.server_run != change.server_run;
      });
      char number[24];
      std::snprintf(number, sizeof number, "/%016" PRIx64, std::uint64_t{change.change});
      keep(std::string("/") + change.scene + number, change.server_run);
      return count;
    }
    case RecordedType::kSceneWhole: {
      wire::SceneWhole whole{};
      if (dds::FromCdr(cdr, whole)) keep(std::string("/") + whole.scene, whole.server_run);
      return count;
    }
    case RecordedType::kSceneBundle:
      KeepScene(name, cdr);
      return count;
    default:
      return count;
  }
}

void RecordingWriter::KeepScene(const std::string& name, std::span<const std::uint8_t> cdr) {
  wire::SceneBundle bundle{};
  if (dds::FromCdr(cdr, bundle)) {
    mcap::StringMap scene{{"scene", bundle.scene},
                          {"hash", Hex(bundle.hash)},
                          {"bytes", std::to_string(bundle.bundle._length)}};
    if (options_.bundles) {
      kept_[name + "/" + bundle.scene] = {
          name, RecordedType::kSceneBundle, bundle.server_run, {cdr.begin(), cdr.end()}};
    }
    mcap::StringMap& known = scenes_[bundle.scene];
    if (known != scene) {
      known = scene;
      file_->WriteMetadata({"palpate.scene", scene});
    }
  }
  dds::FreeContents(bundle);
}

}  // namespace palpate
