#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/dds/wire.h"

namespace palpate {

/// What recordings hold: the types of common/dds/wire.h.
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
};
inline constexpr int kRecordedTypes = 15;

/// "palpate::HapticPose"
const char* SchemaName(RecordedType type);
/// The type's schema: IDL that stands alone (the file of idl/ that declares it).
const std::string& SchemaText(RecordedType type);
std::optional<RecordedType> TypeOfSchema(const std::string& schema_name);

template <class T>
constexpr RecordedType kTypeOf = RecordedType::kHapticPose;
template <>
inline constexpr RecordedType kTypeOf<wire::Wrench> = RecordedType::kWrench;
template <>
inline constexpr RecordedType kTypeOf<wire::SessionRequest> = RecordedType::kSessionRequest;
template <>
inline constexpr RecordedType kTypeOf<wire::SessionState> = RecordedType::kSessionState;
template <>
inline constexpr RecordedType kTypeOf<wire::LoopWhole> = RecordedType::kLoopWhole;
template <>
inline constexpr RecordedType kTypeOf<wire::ToolState> = RecordedType::kToolState;
template <>
inline constexpr RecordedType kTypeOf<wire::LoopStatistics> = RecordedType::kLoopStatistics;
template <>
inline constexpr RecordedType kTypeOf<wire::SceneBundle> = RecordedType::kSceneBundle;
template <>
inline constexpr RecordedType kTypeOf<wire::GuideTarget> = RecordedType::kGuideTarget;
template <>
inline constexpr RecordedType kTypeOf<wire::StationStatistics> = RecordedType::kStationStatistics;
template <>
inline constexpr RecordedType kTypeOf<wire::SceneOffer> = RecordedType::kSceneOffer;
template <>
inline constexpr RecordedType kTypeOf<wire::WholeRequest> = RecordedType::kWholeRequest;
template <>
inline constexpr RecordedType kTypeOf<wire::SceneWhole> = RecordedType::kSceneWhole;
template <>
inline constexpr RecordedType kTypeOf<wire::SolidBlock> = RecordedType::kSolidBlock;
template <>
inline constexpr RecordedType kTypeOf<wire::CutLog> = RecordedType::kCutLog;

/// Counts what a topic's samples number themselves by, so that each hole is known.
class SequenceCount {
 public:
  /// Numbers that lie further apart are not of one count: a loop of 4 kHz takes three days to them.
  static constexpr std::uint64_t kMostHole = std::uint64_t{1} << 30;

  void Add(std::uint64_t sequence);
  std::uint64_t first() const { return first_; }
  std::uint64_t last() const { return last_; }
  std::uint64_t holes() const { return holes_; }
  std::uint64_t missing() const { return missing_; }
  /// Samples whose number the count does not lead to; they are passed over.
  std::uint64_t astray() const { return astray_; }

 private:
  bool any_ = false;
  std::uint64_t first_ = 0, last_ = 0, holes_ = 0, missing_ = 0, astray_ = 0;
};

}  // namespace palpate
