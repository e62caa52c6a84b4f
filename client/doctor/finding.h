#pragma once

#include <string>
#include <vector>

namespace palpate::doctor {

enum class Status {
  kOk,
  kWarning,  ///< holds 1 kHz, less well than it could, or not for everybody
  kFault,    ///< does not hold 1 kHz, or does not work at all
};

/// "ok", "warning", "fault".
constexpr const char* ToString(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kWarning:
      return "warning";
    default:
      return "fault";
  }
}

/// What one check has to say.
struct Finding {
  std::string check{};  ///< its name, as a script looks for it: "idle states"
  Status status = Status::kOk;
  std::string found{};
  std::string remedy{};  ///< what to do, with the command or file; empty where it is ok
};

/// The worst status of all.
inline Status Worst(const std::vector<Finding>& findings) {
  Status worst = Status::kOk;
  for (const Finding& finding : findings) {
    if (finding.status > worst) worst = finding.status;
  }
  return worst;
}

}  // namespace palpate::doctor
