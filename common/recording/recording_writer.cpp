#include "common/recording/recording_writer.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "common/dds/cdr.h"
#include "common/dds/cdr_reader.h"
#include "common/error.h"
#include "common/recording/split_name.h"
#include "common/revision.h"
#include "common/text/hex16.h"

namespace palpate {

RecordingWriter::RecordingWriter(RecordingOptions options) : options_(std::move(options)) {
  if (splits()) {
    // Splits of any number are refused: a reader of all of them would mix two recordings.
    if (const std::vector<NamedSplit> former = FindSplits(options_.file); !former.empty()) {
      throw Error(former.front().file + ": exists already, and a split file of " + options_.file +
                  " may need this name; give another name, or move such files away");
    }
  } else if (options_.overwrite) {
    CheckMayReplace(options_.file);
  }
  Open();
}

void RecordingWriter::Open() {
  const std::string file = splits() ? SplitName(options_.file, files_.size()) : options_.file;
  file_ = std::make_unique<mcap::Writer>(file, "palpate " PALPATE_VERSION,
                                         options_.overwrite && !splits());
  files_.push_back(file);
  finished_ = false;
  repeated_bytes_ = 0;
  schema_ = {};
  for (auto& [name, topic] : topics_) topic.channel.reset();
  mcap::StringMap about = options_.about;
  about["build"] = PALPATE_VERSION;
  about["physics"] = kPhysicsRevision;
  about["scenes"] = kScenesRevision;
  about["split"] = std::to_string(files_.size() - 1);
  file_->WriteMetadata({kRecordingRecord, about});
  for (const auto& [name, scene] : scenes_) file_->WriteMetadata({"palpate.scene", scene});
}

void RecordingWriter::Finish(const std::string& reason) {
  std::uint64_t dropped = 0;
  for (const auto& [name, topic] : topics_) {
    dropped += topic.dropped;
    mcap::StringMap figures{{"topic", name},
                            {"type", SchemaName(topic.type)},
                            {"messages", std::to_string(topic.messages)},
                            {"dropped", std::to_string(topic.dropped)},
                            {"no_channel", std::to_string(topic.no_channel)}};
    if (topic.messages > 0) {
      figures["first"] = std::to_string(topic.sequence.first());
      figures["last"] = std::to_string(topic.sequence.last());
      figures["holes"] = std::to_string(topic.sequence.holes());
      figures["missing"] = std::to_string(topic.sequence.missing());
    }
    file_->WriteMetadata({"palpate.topic", figures});
  }
  // These counts cover all splits so far.
  file_->WriteMetadata({"palpate.end",
                        {{"reason", reason},
                         {"messages", std::to_string(messages_)},
                         {"dropped", std::to_string(dropped)},
                         {"missing", std::to_string(missing_)}}});
  file_->Close();
  closed_bytes_ += file_->size();
  finished_ = true;
}

void RecordingWriter::Close(const std::string& reason) {
  if (!finished_) Finish(reason);
}

void RecordingWriter::SetDropped(const std::string& topic, RecordedType type,
                                 std::uint64_t dropped) {
  // Also lists a topic whose samples were all dropped.
  topics_.try_emplace(topic, Topic{type}).first->second.dropped = dropped;
}

void RecordingWriter::SplitIfDue(std::int64_t log_time_ns) {
  if (file_began_ns_ == 0) file_began_ns_ = log_time_ns;
  const double age_s = 1e-9 * static_cast<double>(log_time_ns - file_began_ns_);
  const bool due =
      (options_.split_bytes > 0 && file_->size() - repeated_bytes_ >= options_.split_bytes) ||
      (options_.split_s > 0.0 && age_s >= options_.split_s);
  if (!due || files_.size() == kMostSplits) return;
  Finish("continues in the next split file");
  file_began_ns_ = log_time_ns;
  Open();
  for (const auto* all : {&kept_, &kept_changes_}) {
    for (const auto& [key, kept] : *all) {
      Topic& topic = topics_.at(kept.topic);
      Put(kept.topic, topic, log_time_ns, topic.messages, kept.cdr);
    }
  }
  file_->Flush();
  repeated_bytes_ = file_->size();
}

void RecordingWriter::Add(const std::string& name, RecordedType type, std::int64_t log_time_ns,
                          std::span<const std::uint8_t> cdr) {
  SplitIfDue(log_time_ns);
  Topic& topic = topics_.try_emplace(name, Topic{type}).first->second;
  const std::uint64_t sequence = Look(name, topic, cdr);
  missing_ -= topic.sequence.missing();
  topic.sequence.Add(sequence);
  missing_ += topic.sequence.missing();
  ++topic.messages;
  ++messages_;
  if (type == RecordedType::kSceneBundle && !options_.bundles) return;
  Put(name, topic, log_time_ns, sequence, cdr);
}

void RecordingWriter::Put(const std::string& name, Topic& topic, std::int64_t log_time_ns,
                          std::uint64_t sequence, std::span<const std::uint8_t> cdr) {
  if (!topic.channel && file_->channels() == mcap::kMostChannels) {
    ++topic.no_channel;
    if (std::exchange(told_of_no_channel_, true)) return;
    spdlog::warn(
        "{}: an MCAP file has at most {} topics; further topics are not recorded, and the "
        "recording says so",
        files_.back(), mcap::kMostChannels);
    return;
  }
  if (!topic.channel) {
    std::uint16_t& schema = schema_[static_cast<std::size_t>(topic.type)];
    if (schema == 0) {
      schema = file_->AddSchema(SchemaName(topic.type), "omgidl", SchemaText(topic.type));
    }
    topic.channel = file_->AddChannel(schema, name, "cdr");
  }
  file_->Write(*topic.channel, static_cast<std::uint32_t>(sequence), log_time_ns, log_time_ns, cdr);
  if (file_->pending() >= kChunk) file_->Flush();
}

std::uint64_t RecordingWriter::Look(const std::string& name, Topic& topic,
                                    std::span<const std::uint8_t> cdr) {
  const std::uint64_t count = topic.messages + 1;
  const auto keep = [&](std::map<std::string, Kept>& kept, const std::string& key) {
    kept[name + key] = {name, {cdr.begin(), cdr.end()}};
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
      if (dds::FromCdr(cdr, state)) keep(kept_, std::string("/") + state.station);
      return count;
    }
    case RecordedType::kSolidBlock: {
      dds::Owned<wire::SolidBlock> owned;
      const wire::SolidBlock& block = owned.value;
      if (!dds::FromCdr(cdr, owned.value)) return count;
      // Changes are kept for the present scene only: with another server run, the scene is
      // whole again.
      if (std::exchange(changes_run_, block.server_run) != block.server_run) kept_changes_.clear();
      keep(kept_changes_, std::string("/") + block.scene + "/" +
                              std::to_string(block.object_index) + "/" +
                              std::to_string(block.block));
      return count;
    }
    case RecordedType::kSceneWhole: {
      wire::SceneWhole whole{};
      if (dds::FromCdr(cdr, whole)) keep(kept_, std::string("/") + whole.scene);
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
                          {"hash", Hex16(bundle.hash)},
                          {"bytes", std::to_string(bundle.bundle._length)}};
    if (options_.bundles) {
      kept_[name + "/" + bundle.scene] = {name, {cdr.begin(), cdr.end()}};
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
