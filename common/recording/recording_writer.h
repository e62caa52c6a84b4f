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
  std::string file;  ///< FILE.mcap; when split, FILE_000.mcap, FILE_001.mcap, ... ...
  /// Size at which a split ends, without what it repeats; 0: never.
  std::uint64_t split_bytes = 0;
  double split_s = 0.0;  ///< 0: never
  bool bundles = true;   ///< false: only the names and hashes of scenes are kept
  /// Replaces a recording of that name; never a split, or a file that is no recording.
  bool overwrite = false;
  mcap::StringMap about{};  ///< further metadata of the recording
};

/// Writes samples as a recording: MCAP, one channel per topic, with counts that prove that it is
/// complete or tell what is missing.  Each split can be read alone: it repeats the latest state of
/// every session, the scenes, and what has been removed from them.
/// Thread contract: one thread.
class RecordingWriter {
 public:
  /// A chunk is closed at the latest when it has this size [bytes].
  static constexpr std::size_t kChunk = 1 << 20;

  /// Throws Error if the file cannot be made, or if a file exists that a split would need; with
  /// `overwrite`, if the file of that name is no recording.
  explicit RecordingWriter(RecordingOptions options);

  /// Adds a sample.  Throws Error if a write fails; what was written before is intact.
  void Add(const std::string& topic, RecordedType type, std::int64_t log_time_ns,
           std::span<const std::uint8_t> cdr);
  /// Sets how many of the topic's samples arrived but were dropped for lack of room.
  void SetDropped(const std::string& topic, RecordedType type, std::uint64_t dropped);
  /// Writes pending samples: a killed recorder then loses only later ones, a host that crashes
  /// moments later those for which the disk had no time.
  void Flush() {
    file_->Flush();
    file_->Synchronise();
  }
  /// Writes the counts and the file's index.
  /// @param reason  why the recording ends, in words.
  void Close(const std::string& reason);

  std::uint64_t messages() const { return messages_; }
  std::uint64_t bytes() const { return closed_bytes_ + (finished_ ? 0 : file_->size()); }
  /// Samples missing according to their sequence numbers, over all topics.
  std::uint64_t missing() const { return missing_; }
  /// Names of the files so far.
  const std::vector<std::string>& files() const { return files_; }

 private:
  struct Topic {
    explicit Topic(RecordedType what) : type(what) {}
    RecordedType type;
    std::optional<std::uint16_t> channel;  ///< none: not yet in this file
    std::uint64_t messages = 0;
    std::uint64_t dropped = 0;
    std::uint64_t no_channel = 0;  ///< samples left out, because the file had all the channels that
                                   ///< MCAP allows
    SequenceCount sequence;
  };
  /// A sample that every split repeats.
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
  /// Returns the sample's own sequence number, or a count; keeps what splits repeat.
  std::uint64_t Look(const std::string& name, Topic& topic, std::span<const std::uint8_t> cdr);
  void KeepScene(const std::string& name, std::span<const std::uint8_t> cdr);

  RecordingOptions options_;
  std::unique_ptr<mcap::Writer> file_;
  bool finished_ = false;             // file_ has its counts, and the next split does not exist yet
  std::uint64_t repeated_bytes_ = 0;  // part of file_ that repeats earlier splits
  std::vector<std::string> files_;
  std::int64_t file_began_ns_ = 0;
  std::uint64_t messages_ = 0, missing_ = 0, closed_bytes_ = 0;
  std::uint64_t changes_run_ = 0;  // the server run of the kept scene changes
  bool told_of_no_channel_ = false;
  std::array<std::uint16_t, kRecordedTypes> schema_{};  ///< id in this file; 0: not yet
  std::map<std::string, Topic> topics_;
  std::map<std::string, mcap::StringMap> scenes_;
  std::map<std::string, Kept> kept_, kept_changes_;  // keyed by what a newer one replaces
};

}  // namespace palpate
