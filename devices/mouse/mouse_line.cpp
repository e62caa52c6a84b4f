#include "devices/mouse/mouse_line.h"

#include <array>
#include <charconv>
#include <cmath>

namespace palpate {
namespace {

constexpr double kFarthest_m = 10.0;
constexpr std::string_view kSpace = " \t\r";

std::string_view TakeWord(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(kSpace), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(kSpace));
  rest.remove_prefix(word.size());
  return word;
}

}  // namespace

std::optional<MouseLine> ParseMouseLine(std::string_view line, std::string& complaint) {
  const auto refuse = [&](const char* why) {
    complaint = why;
    return std::nullopt;
  };
  std::array<double, 7> number{};
  std::string_view rest = line;
  for (std::size_t i = 0; i < number.size(); ++i) {
    const std::string_view word = TakeWord(rest);
    if (i == 0 && word == "release" && TakeWord(rest).empty()) return MouseLine{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number[i]);
    if (word.empty() || error != std::errc{} || end != word.data() + word.size()) {
      return refuse("give 'x y z qw qx qy qz', seven numbers, or 'release'");
    }
  }
  if (!TakeWord(rest).empty()) return refuse("more than seven numbers");
  Pose X;
  X.p = Vec3(number[0], number[1], number[2]);
  X.q = Quat(number[3], number[4], number[5], number[6]);
  // maxCoeff may pass over a NaN; comparisons with one are false.
  if (!X.p.allFinite() || X.p.cwiseAbs().maxCoeff() > kFarthest_m) {
    return refuse("a position beyond 10 m");
  }
  const double norm = X.q.norm();
  if (!(norm >= 1e-3 && norm <= 1e3)) return refuse("a quaternion that is no rotation");
  X.q.coeffs() /= norm;
  return MouseLine{X};
}

}  // namespace palpate
