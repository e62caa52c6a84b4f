#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/program/stop_signal.h"

namespace palpate {

/// The function of foreign code, such as a user's driver, that this thread is in; null: none.
inline constinit thread_local const char* foreign_call = nullptr;

/// Says, as long as it lives, that this thread is in that function of foreign code.  Real-time.
class ForeignCall {
 public:
  /// @param name  lives as long as the process.
  explicit ForeignCall(const char* name) noexcept : before_(foreign_call) { foreign_call = name; }
  ~ForeignCall() { foreign_call = before_; }
  ForeignCall(const ForeignCall&) = delete;
  ForeignCall& operator=(const ForeignCall&) = delete;

 private:
  const char* before_;
};

/// What became of work in a process of its own.
struct ForkedEnd {
  std::vector<std::string> lines;  ///< lines that it had told by then
  bool finished = false;           ///< the work returned
  std::string how;  ///< if it did not: "palpate_device_read crashed (Segmentation fault)"
};

/// Does work in a copy of this process, since foreign code may crash, end the process, or not
/// return.  `work` gets a function that tells this process a line without a line break.  Not for a
/// process with a servo loop, which the copying would delay.  What the work has started ends with
/// it.
/// @param seconds  after which the copy is killed.
/// @param stopped  if it returns true, the copy is told to end, and killed if it does not.
/// Throws Error if there can be no further process.
ForkedEnd RunForked(
    const std::function<void(const std::function<void(const std::string&)>& tell)>& work,
    double seconds, const std::function<bool()>& stopped = StopWasSignalled);

}  // namespace palpate
