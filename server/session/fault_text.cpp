#include "server/session/fault_text.h"

#include <utility>

#include "server/physics/haptic_step.h"

namespace palpate {

std::string FaultText(std::uint32_t faults) {
  static constexpr std::pair<StepFault, const char*> kNames[] = {
      {kFaultBadPose, "bad-pose"},           {kFaultTargetFar, "target-far"},
      {kFaultRowsFull, "rows-full"},         {kFaultJammed, "jammed"},
      {kFaultUnsolved, "unsolved"},          {kFaultPoseStale, "pose-stale"},
      {kFaultPoseRejected, "pose-rejected"}, {kFaultNotStarted, "not-started"},
  };
  std::string text;
  for (const auto& [bit, name] : kNames) {
    if ((faults & bit) == 0) continue;
    if (!text.empty()) text += ' ';
    text += name;
  }
  return text.empty() ? "-" : text;
}

}  // namespace palpate
