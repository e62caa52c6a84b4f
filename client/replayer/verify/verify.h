#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/wire.h"
#include "common/program/stop_signal.h"
#include "scenes/grid/cut_field.h"
#include "scenes/scene.h"
#include "server/physics/haptic_model.h"

namespace palpate {

struct VerifyOptions {
  std::string scene;       ///< for recordings without scenes: name or file; empty: as recorded
  std::string models_dir;  ///< as LoadOptions
  /// Whose solids the result is to keep, station and run: a class's together do not fit into
  /// memory.
  std::optional<std::pair<std::string, std::uint64_t>> whose = std::nullopt;
  bool keep_left = false;  ///< Verification::left is wanted
  /// Nothing later counts: from the recording's first sample [s].
  double until_s = std::numeric_limits<double>::infinity();
  const StopSignal* stop = nullptr;  ///< looked at now and then; then throws Error
};

/// The solids of a recorded scene, as burs left them.
struct SolidsCut {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const SceneObjects> objects;  ///< the solids that the fields are of
  std::vector<CutField> before;                 ///< as objects->solids(): as a session found them
  std::vector<CutField> after;                  ///< as it left them
};

/// A field of a wrench that is not what the physics gives now.
struct WrenchDifference {
  std::uint64_t pose_sequence = 0;
  double time_s = 0.0;             ///< since the recording's first sample
  std::string field;               ///< "force_N[1]"
  std::string recorded, computed;  ///< both as number and as bits
};

/// What became of one station's session.
struct SessionVerdict {
  std::string station, scene, tool;
  std::string scene_hash{};  ///< of the recorded one; empty: unknown
  std::uint64_t run = 0;
  std::uint64_t poses = 0;      ///< in the recording
  std::uint64_t recorded = 0;   ///< wrenches in the recording
  std::uint64_t broken = 0;     ///< of these: bytes that are no wrench
  std::uint64_t cut_off = 0;    ///< not of these: the last ones, whose poses were cut off
  std::uint64_t verified = 0;   ///< computed again, the same bits
  std::uint64_t different = 0;  ///< computed again, other bits
  std::optional<WrenchDifference> first;
  std::string ends;                ///< why no more could be computed; empty: all were
  std::optional<SolidsCut> cut{};  ///< of whose it was asked for
  double recorded_s = 0.0, computed_s = 0.0;
  bool good() const { return recorded > 0 && verified == recorded; }
};

struct Verification {
  std::vector<SessionVerdict> sessions;
  std::vector<std::string> problems;  ///< of the files
  bool damaged = false;               ///< they have changed since they were written
  /// What is left at the end of each scene of each server's run; `before` is as it was at first.
  std::vector<SolidsCut> left{};
  /// Every wrench of every session was computed again and is the same, and there is at least one.
  /// A recording that was cut off can be good as far as it goes.
  bool good() const;
};

/// Gives the recorded poses to the server's own servo loop, and compares its wrenches with the
/// recorded ones, bit for bit; all but step_time_s, which a clock gave.  Throws Error where a file
/// or a scene cannot be had.
Verification Verify(const std::vector<std::string>& files, const VerifyOptions& options);

/// The first field in which the two differ, step_time_s left out; none where they are equal.
std::optional<WrenchDifference> Difference(const wire::Wrench& recorded,
                                           const wire::Wrench& computed);

std::string ToText(const Verification& verification);
/// @param file  "-" is stdout.  Throws Error.
void WriteJson(const Verification& verification, const std::string& file);

}  // namespace palpate
