#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace palpate {

/// Seconds of a clock that never goes back; where it begins does not matter.
using SecondsClock = std::function<double()>;
double SteadySeconds();

/// Long work as a line for people: " 43 %  part: touching balls, about 12 s left".
/// How long it will take is what the past says: the time so far, times what is left over what is
/// done.  Nothing is said of it in the first two seconds, which are over soon or tell too little,
/// nor before a fiftieth is done, nor of less than a second.
class ProgressText {
 public:
  explicit ProgressText(SecondsClock clock = SteadySeconds) : clock_(std::move(clock)) {}
  /// A fraction that is less than the one before begins other work.
  std::string operator()(std::string_view stage, double fraction);

 private:
  SecondsClock clock_;
  double began_ = 0.0;
  double fraction_ = 2.0;  ///< of the last call; before the first more than any
};

/// The same on one line of standard error: rewritten on a terminal, one line a stage elsewhere.
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

/// The same for a log: told once the work has taken five seconds, and every five from then on.
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
  double told_ = 0.0;
  double fraction_ = 2.0;
};

}  // namespace palpate
