#include "common/step_fault.h"

#include <utility>

namespace palpate {

std::string FaultWords(std::uint32_t faults) {
  static constexpr std::pair<std::uint32_t, const char*> kWords[] = {
      {kFaultBadPose, "bad pose"},      {kFaultTargetFar, "target far"},
      {kFaultRowsFull, "rows full"},    {kFaultJammed, "jammed"},
      {kFaultUnsolved, "unsolved"},     {kFaultPoseRejected, "pose rejected"},
      {kFaultNotStarted, "not started"}};
  std::string words;
  const auto add = [&words](const std::string& word) {
    if (!words.empty()) words += ", ";
    words += word;
  };
  for (const auto& [bit, word] : kWords) {
    if (faults & bit) add(word);
    faults &= ~bit;
  }
  if (faults != 0) add("unknown");
  return words.empty() ? "none" : words;
}

}  // namespace palpate
