#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace palpate::doctor {

enum class Status {
  kOk,
  kWarning,  ///< holds 1 kHz, less well than it could, or not for everybody
  kFault,    ///< does not hold 1 kHz, or does not work at all
};

/// What one check has to say.
struct Finding {
  std::string check{};  ///< its name, as a script looks for it: "idle states"; Examine gives it
  Status status = Status::kOk;
  std::string found{};
  std::string remedy{};  ///< what to do, with the command or file; empty where it is ok
};

inline Finding Ok(std::string found) {
  return {.found = std::move(found)};
}
inline Finding Warning(std::string found, std::string remedy) {
  return {.status = Status::kWarning, .found = std::move(found), .remedy = std::move(remedy)};
}
inline Finding Fault(std::string found, std::string remedy) {
  return {.status = Status::kFault, .found = std::move(found), .remedy = std::move(remedy)};
}

/// How a kernel gets an option, in a remedy's words.
inline std::string GrubLine(const std::string& option) {
  return "add " + option + " to GRUB_CMDLINE_LINUX in /etc/default/grub, run sudo update-grub";
}

/// The worst status of all.
inline Status Worst(const std::vector<Finding>& findings) {
  Status worst = Status::kOk;
  for (const Finding& finding : findings) worst = std::max(worst, finding.status);
  return worst;
}

}  // namespace palpate::doctor
