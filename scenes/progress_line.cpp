#include "scenes/progress_line.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace palpate {
namespace {

constexpr double kSilent_s = 2.0;
constexpr double kLeastDone = 0.02;
constexpr double kLogEvery_s = 5.0;

/// Formats a duration, more coarsely the longer it is, because it is an estimate.
std::string About(double seconds) {
  const auto rounded = [&](double step) {
    return step * std::max(1.0, std::round(seconds / step));
  };
  if (seconds < 10.0) return fmt::format("{:.0f} s", rounded(1.0));
  if (seconds < 57.5) return fmt::format("{:.0f} s", rounded(5.0));
  if (seconds < 3570.0) return fmt::format("{:.0f} min", rounded(60.0) / 60.0);
  return fmt::format("{:.1f} h", rounded(360.0) / 3600.0);
}

}  // namespace

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string ProgressText::operator()(std::string_view stage, double fraction) {
  const double now = clock_();
  if (fraction < fraction_) began_ = now;
  fraction_ = fraction;
  std::string text = fmt::format("{:3.0f} %  {}", std::floor(100.0 * fraction), stage);
  const double taken = now - began_;
  if (taken < kSilent_s || fraction < kLeastDone) return text;
  const double left = taken * (1.0 - fraction) / fraction;
  if (left >= 1.0) text += ", about " + About(left) + " left";
  return text;
}

void ProgressLine::operator()(std::string_view stage, double fraction) {
  const std::string text = text_(stage, fraction);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (!terminal && stage == stage_) return;
  stage_ = stage;
  std::fprintf(stderr, terminal ? "\r\033[K%s" : "%s\n", text.c_str());
  shown_ = terminal;
}

void ProgressLine::Clear() {
  if (shown_) std::fputs("\r\033[K", stderr);
  shown_ = false;
}

void ProgressLog::operator()(std::string_view stage, double fraction) {
  const double now = clock_();
  if (fraction < fraction_) reported_ = now;
  fraction_ = fraction;
  const std::string text = text_(stage, fraction);
  if (now - reported_ < kLogEvery_s) return;
  reported_ = now;
  tell_(text);
}

}  // namespace palpate
