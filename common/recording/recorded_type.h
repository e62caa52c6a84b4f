#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>

#include "common/dds/wire.h"

namespace palpate {

/// The types of samples in recordings; each is a type of common/dds/wire.h.
enum class RecordedType {
  kHapticPose,
  kWrench,
  kSessionRequest,
  kSessionState,
  kLoopWhole,
  kToolState,
  kLoopStatistics,
  kSceneBundle,
  kGuideTarget,
  kStationStatistics,
  kSceneOffer,
  kWholeRequest,
  kSceneWhole,
  kSolidBlock,
  kCutLog,
  kMovedState,
};
/// Their wire types, in the same order.
using RecordedWires =
    std::tuple<wire::HapticPose, wire::Wrench, wire::SessionRequest, wire::SessionState,
               wire::LoopWhole, wire::ToolState, wire::LoopStatistics, wire::SceneBundle,
               wire::GuideTarget, wire::StationStatistics, wire::SceneOffer, wire::WholeRequest,
               wire::SceneWhole, wire::SolidBlock, wire::CutLog, wire::MovedState>;
inline constexpr int kRecordedTypes = std::tuple_size_v<RecordedWires>;

/// @tparam T  a type of RecordedWires.
template <class T>
inline constexpr RecordedType kTypeOf = []<class... Each>(const std::tuple<Each...>*) {
  const bool is[] = {std::is_same_v<T, Each>...};
  return static_cast<RecordedType>(std::ranges::find(is, true) - is);
}(static_cast<const RecordedWires*>(nullptr));

/// "palpate::HapticPose"
const char* SchemaName(RecordedType type);
/// Returns the type's schema: self-contained IDL (the file of idl/ that declares it).
const std::string& SchemaText(RecordedType type);
std::optional<RecordedType> TypeOfSchema(const std::string& schema_name);

/// Tracks the sequence numbers of a topic's samples, to find gaps.
class SequenceCount {
 public:
  /// The largest gap within one count; a loop of 4 kHz takes three days for it.
  static constexpr std::uint64_t kMostHole = std::uint64_t{1} << 30;

  void Add(std::uint64_t sequence);
  std::uint64_t first() const { return first_; }
  std::uint64_t last() const { return last_; }
  std::uint64_t holes() const { return holes_; }
  std::uint64_t missing() const { return missing_; }
  /// Samples whose number does not continue the count; they are ignored.
  std::uint64_t astray() const { return astray_; }

 private:
  bool any_ = false;
  std::uint64_t first_ = 0, last_ = 0, holes_ = 0, missing_ = 0, astray_ = 0;
};

}  // namespace palpate
