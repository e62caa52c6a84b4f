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
  std::string scene = {};       ///< for recordings without scenes: name or file; empty: as recorded
  std::string models_dir = {};  ///< as in LoadOptions
  /// Station and run of the session whose solids the result keeps: those of a whole class do not
  /// fit into memory.
  std::optional<std::pair<std::string, std::uint64_t>> whose = std::nullopt;
  bool keep_left = false;  ///< fill Verification::left
  /// Ignores all later samples; time from the recording's first sample [s].
  double until_s = std::numeric_limits<double>::infinity();
  const StopSignal* stop = nullptr;  ///< checked now and then; a signal makes it throw Error
};

/// The solids of a recorded scene, before and after a session's cuts.
struct SolidsCut {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const SceneObjects> objects;  ///< the fields' solids
  std::vector<CutField> before;                 ///< as objects->solids: at the session's beginning
  std::vector<CutField> after;                  ///< at the session's end
};

/// A field of a recorded wrench that differs from the recomputed one.
struct WrenchDifference {
  std::uint64_t pose_sequence = 0;
  double time_s = 0.0;             ///< since the recording's first sample
  std::string field;               ///< "force_N[1]"
  std::string recorded, computed;  ///< each as number and as bits
};

/// The result of verifying one session.
struct SessionVerdict {
  std::string station, scene, tool;
  std::string scene_hash{};  ///< of the recorded one; empty: unknown
  std::uint64_t run = 0;
  std::uint64_t poses = 0;     ///< in the recording
  std::uint64_t recorded = 0;  ///< wrenches in the recording
  std::uint64_t broken = 0;    ///< of these, not valid wrench samples
  /// Not of these: the last ones, whose poses are missing because the recording ended first.
  std::uint64_t cut_off = 0;
  std::uint64_t verified = 0;   ///< recomputed to the same bits
  std::uint64_t different = 0;  ///< recomputed to other bits
  std::optional<WrenchDifference> first;
  std::string ends;                ///< why no more could be recomputed; empty: all were
  std::optional<SolidsCut> cut{};  ///< if asked for by `whose`
  double recorded_s = 0.0, computed_s = 0.0;
  bool good() const { return recorded > 0 && verified == recorded; }
};

/// That somebody made a scene whole, set its bookmark or went back to it while a session ran there.
struct Restoration {
  std::string by;
  wire::WholeWish wish{};
  double time_s = 0.0;  ///< since the recording's first sample
};

struct Verification {
  std::vector<SessionVerdict> sessions;
  std::vector<std::string> problems;  ///< of the files
  bool damaged = false;               ///< they have changed since they were written
  std::string physics{};  ///< revision of the build that recorded (revision.h); empty: not told
  std::vector<Restoration> restorations{};
  /// The solids at the end of each scene of each server's run; `before` is their initial state.
  std::vector<SolidsCut> left{};
  /// True if every wrench of every session was recomputed to the same bits, and there is at least
  /// one.  A recording that was cut off can be good as far as it goes.
  bool good() const;
  /// Returns whether any wrench was recomputed to other bits.
  bool differs() const;
};

/// Returns ", recorded by physics A; this is B ...: how to get A", if these are not the same
/// build's, and else that they are.
/// @param kind  "physics" or "scenes".   @param recorded  empty: not told.   @param own  this
/// build's.
std::string WhichBuild(std::string_view kind, const std::string& recorded, const std::string& own);

/// Feeds the recorded poses to the server's own servo loop and compares its wrenches with the
/// recorded ones, bit for bit, except step_time_s, which a clock gave.  Throws Error if a file or a
/// scene is missing.
Verification Verify(const std::vector<std::string>& files, const VerifyOptions& options);

/// Returns the first field in which the two differ, ignoring step_time_s; none if they are equal.
std::optional<WrenchDifference> Difference(const wire::Wrench& recorded,
                                           const wire::Wrench& computed);

std::string ToText(const Verification& verification);
/// @param file  "-" is stdout.  Throws Error.
void WriteJson(const Verification& verification, const std::string& file);

}  // namespace palpate
