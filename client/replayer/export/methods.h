#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/recording/file_summary.h"

namespace palpate {

/// The maker that an export's methods.json names.
inline constexpr const char* kExportMaker = "palpate-replay export";

/// Collects, sample by sample, what the methods section of a paper needs to say about a recording:
/// versions, scenes, machine, transport, rates, losses, springs, and the limiter's actions.
/// Thread contract: one thread.
class Methods {
 public:
  struct Session {
    std::string station, scene, tool, device;
    std::uint64_t run = 0;
    double stiffness_N_per_m = 0.0, torsional_stiffness_Nm_per_rad = 0.0;
    bool forces = false;  ///< forces have begun
    // Of the session's limiter: wrenches wanted and applied, and in how many calls each
    // stage acted.
    double wanted_force_N = 0.0, wanted_torque_Nm = 0.0;
    double applied_force_N = 0.0, applied_torque_Nm = 0.0;
    std::map<std::string, std::uint64_t> limiter_calls;
    std::uint64_t limiter_periods = 0;
    std::string folder;  ///< of its tables; empty: it has none
  };

  /// @param sample  the next sample of the recording, in its order.
  void Add(const RecordedSample& sample);
  /// Adds what the recorder reports of itself.  Call it after the last sample.
  void Finish(const RecordingReader& reader) { all_.Finish(reader); }

  /// Returns the session of a station's run; adds a new one if no sample has mentioned it.
  Session& SessionOf(const std::string& station, std::uint64_t run);
  void CountLeftOut() { ++left_out_; }

  /// @param recording  names of its files.
  /// @param files      files written, relative to the folder.
  std::string ToJson(const std::vector<std::string>& recording,
                     const std::vector<std::string>& files) const;
  std::string ToMarkdown(const std::vector<std::string>& recording) const;

 private:
  FileSummary all_;
  std::vector<Session> sessions_;
  std::map<std::pair<std::string, std::uint64_t>, std::size_t> places_;  // by station and run
  std::uint64_t left_out_ = 0;
};

}  // namespace palpate
