#include "common/step_fault.h"

namespace palpate {
namespace {

struct Fault {
  std::uint32_t bit;
  const char* word;
  const char* meaning;
};
constexpr Fault kFaults[] = {
    {kFaultBadPose, "bad pose", "the device sent an invalid pose, and the force faded"},
    {kFaultTargetFar, "target far", "the hand moved faster than the tool, which follows"},
    {kFaultRowsFull, "rows full", "more contacts at once than are computed; the tool stays"},
    {kFaultJammed, "jammed", "the tool was wedged between surfaces"},
    {kFaultUnsolved, "unsolved", "a contact problem was not solved, and the tool did not move"},
    {kFaultEffect, "effect off", "a user-defined force failed and was turned off"},
    {kFaultFriction, "friction unsolved", "friction was not found, and the last one is felt"},
    {kFaultPoseRejected, "pose rejected", "the hand jumped farther than a hand can move"},
    {kFaultNotStarted, "not started",
     "no force yet: the tool was just placed, or is inside an object"}};

/// @param say  returns the text of a known fault.
template <class Say>
std::string Listed(std::uint32_t faults, Say say) {
  std::string words;
  const auto add = [&words](const std::string& word) {
    if (!words.empty()) words += ", ";
    words += word;
  };
  for (const Fault& fault : kFaults) {
    if (faults & fault.bit) add(say(fault));
    faults &= ~fault.bit;
  }
  if (faults != 0) add("unknown");
  return words.empty() ? "none" : words;
}

}  // namespace

std::string FaultWords(std::uint32_t faults) {
  return Listed(faults, [](const Fault& fault) { return std::string(fault.word); });
}

std::string FaultMeanings(std::uint32_t faults) {
  return Listed(faults, [](const Fault& fault) {
    return std::string(fault.word) + " (" + fault.meaning + ")";
  });
}

}  // namespace palpate
