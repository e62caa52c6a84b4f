#pragma once

#include <string>
#include <vector>

#include "tests/faults/lab.h"

namespace palpate::faults {

using Findings = std::vector<Finding>;

// What several faults look at.

void Wait(double seconds);
Finding Lives(const std::string& who, test::Program& program);
Finding LoopRuns(Lab& lab);
Finding Resumes(Lab& lab);
/// What happened to others is nothing to the loop.
/// @param said_before  what the station had said until then.
Finding Undisturbed(Lab& lab, const std::string& said_before);
Finding Says(const std::string& must, test::Program& program, const std::string& text);
Finding EndsInOrder(const std::string& who, test::Program& program);
/// Waits up to 10 s for the gateway to tell of the lab's scene.
Finding Shows(const std::string& must, Lab& lab);

}  // namespace palpate::faults
