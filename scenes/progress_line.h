#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace palpate {

/// Returns the seconds of a clock that never goes back, counted from any moment.
using SecondsClock = std::function<double()>;
double SteadySeconds();

/// Formats the progress of long work for people: " 43 %  part: fitting balls, about 12 s left".
/// The time left is extrapolated from the time so far.  It is left out during the first two
/// seconds, before a fiftieth is done, and when it is less than a second.
class ProgressText {
 public:
  explicit ProgressText(SecondsClock clock = SteadySeconds) : clock_(std::move(clock)) {}
  /// A fraction smaller than the last one begins new work.
  std::string operator()(std::string_view stage, double fraction);

 private:
  SecondsClock clock_;
  double began_ = 0.0;
  double fraction_ = 2.0;  ///< of the last call; larger than any before the first
};

/// Shows it on standard error: one line that is rewritten on a terminal, one line
/// per stage elsewhere.
class ProgressLine {
 public:
  ~ProgressLine() { Clear(); }
  void operator()(std::string_view stage, double fraction);
  void Clear();

 private:
  ProgressText text_;
  std::string stage_;
  bool shown_ = false;
};

/// Writes it to a log: first after five seconds of work, and then every five seconds.
class ProgressLog {
 public:
  using Tell = std::function<void(const std::string&)>;
  explicit ProgressLog(Tell tell, SecondsClock clock = SteadySeconds)
      : tell_(std::move(tell)), clock_(clock), text_(std::move(clock)) {}
  void operator()(std::string_view stage, double fraction);

 private:
  Tell tell_;
  SecondsClock clock_;
  ProgressText text_;
  double reported_ = 0.0;
  double fraction_ = 2.0;
};

}  // namespace palpate
