#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/recording/recording_reader.h"

namespace palpate {

/// Summary of a recording, from its samples and its recorder's metadata.
struct FileSummary {
  struct Topic {
    std::string type;
    std::uint64_t messages = 0, bytes = 0, dropped = 0, broken = 0;
    /// Between its first and last sample; 0 if there is no rate, for example if all samples came at
    /// once as history.
    double rate_hz = 0.0;
    std::int64_t first_ns = 0, last_ns = 0;
    SequenceCount sequence;
    /// Returns how many answers of the server's loop preceded the first in the recording: a loop
    /// counts from 1.
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
    /// Number in the recording; 0: the session had ended before, but the server still published
    /// its state.
    std::uint64_t poses = 0;
  };

  std::vector<std::string> files;
  std::uint64_t bytes = 0;
  double duration_s = 0.0;
  std::int64_t first_ns = 0;
  mcap::StringMap about;  ///< the recording's description of itself
  std::string build, end_reason;
  std::string physics;    ///< revision of the recorder's build (revision.h); older ones said none
  bool complete = false;  ///< the recording has its end
  bool damaged = false;   ///< bytes were altered after recording
  std::vector<std::string> problems;
  std::map<std::string, Topic> topics;
  std::map<std::string, Scene> scenes;
  std::vector<Session> sessions;
  std::uint64_t messages = 0, missing = 0, dropped = 0;
  std::uint64_t no_channel = 0;  ///< left out, because the file had as many topics as MCAP allows
  std::uint64_t broken = 0;      ///< samples whose bytes do not fit their type
  std::uint64_t astray = 0;      ///< samples whose number does not continue their topic's count
  std::uint64_t unknown = 0;     ///< samples of types unknown to this version

  /// Returns the recording's state in a word: "whole" if it contains everything that arrived while
  /// it was recorded, and nothing else; otherwise the first of "damaged", "cut off" or "incomplete"
  /// that applies.
  const char* verdict() const;
  bool whole() const;
  /// Returns true if the file is as its recorder wrote it, even if the recorder missed samples.
  bool intact() const { return complete && !damaged; }

  /// Adds a sample, in the recording's order.
  void Add(const RecordedSample& sample);
  /// Call it after the last sample: adds the recorder's metadata, and what follows from
  /// all samples.
  void Finish(const RecordingReader& reader);

 private:
  bool Look(const RecordedSample& sample, std::uint64_t& sequence);

  std::map<std::pair<std::string, std::uint64_t>, std::size_t> places_;  // by station and run
  std::map<std::string, std::uint64_t> first_forces_;  // first pose with forces, by wrench topic
  std::int64_t last_ns_ = 0;
};

/// Summarises a recording's files.  Throws Error if one cannot be read.
FileSummary Summarise(const std::vector<std::string>& files);

}  // namespace palpate
