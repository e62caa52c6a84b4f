#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/mcap/mcap_writer.h"
#include "common/recording/recorded_type.h"

namespace palpate {

struct RecordingOptions {
  std::string file;  ///< FILE.mcap; with a split FILE_000.mcap, FILE_001.mcap, ...
  /// Of what a split does not repeat; 0: never.
  std::uint64_t split_bytes = 0;
  double split_s = 0.0;  ///< 0: never
  bool bundles = true;   ///< false: of scenes, only their names and hashes are kept
  /// A recording of that name goes; a split, and what is no recording, never does.
  bool overwrite = false;
  mcap::StringMap about{};  ///< what else the recording is to say of itself
};

/// Writes samples as a recording: MCAP, one channel for each topic, with figures that prove that it
/// is complete or say what is lacking.  Each split can be read alone: it repeats the latest state
/// of every session, the scenes, and what has been scraped off them. Thread contract: one thread.
class RecordingWriter {
 public:
  /// A chunk is closed at the latest when it holds this much.
  static constexpr std::size_t kChunk = 1 << 20;

  /// Throws Error where the file cannot be made, or one that a split may want is there already;
  /// with `overwrite`, where what has the name is no recording.
  explicit RecordingWriter(RecordingOptions options);

  /// Throws Error where a write fails; what was written before is whole.
  void Add(const std::string& topic, RecordedType type, std::int64_t log_time_ns,
           std::span<const std::uint8_t> cdr);
  /// Samples of the topic that came, and that there was no room for.
  void SetDropped(const std::string& topic, RecordedType type, std::uint64_t dropped);
  /// Writes what is pending, to the disk: no more than what came since then can be lost.
  void Flush() {
    file_->Flush();
    file_->Synchronise();
  }
  /// Writes the figures and the file's index.
  /// @param reason  why it ends, in words.
  void Close(const std::string& reason);

  std::uint64_t messages() const { return messages_; }
  std::uint64_t bytes() const { return closed_bytes_ + (finished_ ? 0 : file_->size()); }
  /// Missing by their numbers, all topics together.
  std::uint64_t missing() const { return missing_; }
  /// Names of the files so far.
  const std::vector<std::string>& files() const { return files_; }

 private:
  struct Topic {
    explicit Topic(RecordedType what) : type(what) {}
    RecordedType type;
    std::optional<std::uint16_t> channel;  ///< nothing: not yet in this file
    std::uint64_t messages = 0;
    std::uint64_t dropped = 0;
    std::uint64_t no_channel = 0;  ///< came when the file had all the channels that MCAP allows
    SequenceCount sequence;
  };
  /// What every split repeats.
  struct Kept {
    std::string topic;
    std::vector<std::uint8_t> cdr;
  };

  bool splits() const { return options_.split_bytes > 0 || options_.split_s > 0.0; }
  void Open();
  void Finish(const std::string& reason);
  void SplitIfDue(std::int64_t log_time_ns);
  void Put(const std::string& name, Topic& topic, std::int64_t log_time_ns, std::uint64_t sequence,
           std::span<const std::uint8_t> cdr);
  /// The number that the sample gives itself, or a count; keeps what splits repeat.
  std::uint64_t Look(const std::string& name, Topic& topic, std::span<const std::uint8_t> cdr);
  void KeepScene(const std::string& name, std::span<const std::uint8_t> cdr);

  RecordingOptions options_;
  std::unique_ptr<mcap::Writer> file_;
  bool finished_ = false;             // file_ has its figures, and the next split is not there yet
  std::uint64_t repeated_bytes_ = 0;  // of file_: what it repeats of the splits before
  std::vector<std::string> files_;
  std::int64_t file_began_ns_ = 0;
  std::uint64_t messages_ = 0, missing_ = 0, closed_bytes_ = 0;
  std::uint64_t changes_run_ = 0;  // the run of the server that the kept SceneChanges are of
  bool told_of_no_channel_ = false;
  std::array<std::uint16_t, kRecordedTypes> schema_{};  ///< in this file; 0: not yet
  std::map<std::string, Topic> topics_;
  std::map<std::string, mcap::StringMap> scenes_;
  std::map<std::string, Kept> kept_, kept_changes_;  // by what they replace
};

}  // namespace palpate
