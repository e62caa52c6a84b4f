#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/recording/recording_reader.h"

namespace palpate {

/// What is in a recording, from its samples, and what its recorder said of it.
struct FileSummary {
  struct Topic {
    std::string type;
    std::uint64_t messages = 0, bytes = 0, dropped = 0, broken = 0;
    /// Between its first and last; 0 where there is none, as where what was said before came at
    /// once.
    double rate_hz = 0.0;
    std::int64_t first_ns = 0, last_ns = 0;
    SequenceCount sequence;
    /// Answers of the server's loop before the first that is here: a loop counts from 1.
    std::uint64_t before() const;
  };
  struct Scene {
    std::string hash;
    bool bundle = false;  ///< the scene itself is in the recording
  };
  struct Session {
    std::string station, scene, tool;
    std::uint64_t run = 0;
    std::uint64_t start_sequence = 0;  ///< 0: forces never began
    /// In the recording; 0: the server still told of the session, which had ended before.
    std::uint64_t poses = 0;
  };

  std::vector<std::string> files;
  std::uint64_t bytes = 0;
  double duration_s = 0.0;
  std::int64_t first_ns = 0;
  mcap::StringMap about;  ///< what the recording says of itself
  std::string build, end_reason;
  bool complete = false;  ///< has its end
  bool damaged = false;   ///< holds what no recorder wrote there
  std::vector<std::string> problems;
  std::map<std::string, Topic> topics;
  std::map<std::string, Scene> scenes;
  std::vector<Session> sessions;
  std::uint64_t messages = 0, missing = 0, dropped = 0;
  std::uint64_t no_channel = 0;  ///< left out: the file had as many topics as MCAP allows
  std::uint64_t broken = 0;      ///< not of their type
  std::uint64_t astray = 0;      ///< with numbers that their topics' counts do not lead to
  std::uint64_t unknown = 0;     ///< of types that this version does not know

  /// How it is, in a word: "whole", where all that came while it was recorded is in it and nothing
  /// else; "damaged", "cut off" or "incomplete", the first of these that is true.
  const char* verdict() const;
  bool whole() const;
  /// As its recorder wrote it, whatever that had not.
  bool intact() const { return complete && !damaged; }

  /// A sample, in the recording's order.
  void Add(const RecordedSample& sample);
  /// Once there is none any more: what its recorder said of it, and what follows from all.
  void Finish(const RecordingReader& reader);

 private:
  bool Look(const RecordedSample& sample, std::uint64_t& sequence);

  std::map<std::pair<std::string, std::uint64_t>, std::size_t> places_;  // by station and run
  std::int64_t last_ns_ = 0;
};

/// Throws Error where a file cannot be read.
FileSummary Summarise(const std::vector<std::string>& files);

}  // namespace palpate
