#include "scenes/tree/leaf_count.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/elementary.h"
#include "scenes/mesh/figure.h"

namespace palpate {
namespace {

constexpr int kHalvings = 3;  // of the last doubling: 2^(1/8), a tenth

/// Returns the geometric mean of two counts, because errors fall by powers of the count.
std::size_t Between(std::size_t low, std::size_t high) {
  return static_cast<std::size_t>(std::lround(std::sqrt(double(low) * double(high))));
}

/// The share of the work that is done, in leaves: a count costs about in proportion to it.
class Work {
 public:
  Work(double tolerance, std::size_t most) : tolerance_(tolerance), most_(double(most)) {}

  void Tried(std::size_t count, double error) {
    // Two counts tell the power by which errors fall; before that assume a half.
    if (before_count_ > 0.0 && error > 0.0 && before_ > error) {
      power_ = std::clamp(Log(before_ / error) / Log(double(count) / before_count_), 0.3, 2.0);
    }
    before_count_ = double(count);
    before_ = error;
    done_ += double(count);
  }
  /// Returns the shares done before and after `count` is tried, while counts are doubled.
  std::pair<double, double> Doubling(std::size_t count) {
    double last = double(count);
    if (before_count_ > 0.0) {
      last = before_count_ * Pow(std::max(1.0, before_ / tolerance_), 1.0 / power_);
    }
    last = std::clamp(last, double(count), most_);
    return Share(double(count), 2.0 * last - 2.0 * double(count) + kHalvings * 0.75 * last);
  }
  /// Returns the same for the bisection, of which `left` counts remain, this one included.
  std::pair<double, double> Halving(std::size_t count, int left) {
    return Share(double(count), (left - 1) * double(count));
  }

 private:
  /// @param then  an estimate of the work after `now`.  It may grow, but the share
  ///              shown never falls.
  std::pair<double, double> Share(double now, double then) {
    const double all = done_ + now + std::max(then, 0.0);
    const double from = std::max(shown_, done_ / all);
    shown_ = std::max(from, (done_ + now) / all);
    return {from, shown_};
  }

  double tolerance_, most_;
  double done_ = 0.0, shown_ = 0.0;
  double before_count_ = 0.0, before_ = 0.0;
  double power_ = 1.0;
};

std::string WithCommas(std::size_t number) {
  std::string text = std::to_string(number);
  for (int at = static_cast<int>(text.size()) - 3; at > 0; at -= 3) text.insert(at, ",");
  return text;
}

}  // namespace

LeafCount ChooseLeafCount(double tolerance, std::size_t most,
                          const std::function<double(std::size_t count)>& error_of,
                          const LeafCountProgress& progress) {
  Work work(tolerance, most);
  LeafCount chosen;
  const auto enough = [&](std::size_t count, const std::pair<double, double>& share) {
    if (progress) progress(count, share.first, share.second);
    const double error = error_of(count);
    ++chosen.tried;
    work.Tried(count, error);
    if (error <= tolerance || count == most) {
      chosen.count = count;
      chosen.error = error;
      chosen.reached = error <= tolerance;
    }
    return error <= tolerance;
  };
  std::size_t low = 0;
  std::size_t high = std::min(kFewestByTolerance, most);
  while (!enough(high, work.Doubling(high))) {
    if (high == most) return chosen;
    low = high;
    high = std::min(2 * high, most);
  }
  for (int left = kHalvings; low > 0 && left > 0; --left) {
    const std::size_t middle = Between(low, high);
    if (middle <= low || middle >= high) break;
    (enough(middle, work.Halving(middle, left)) ? high : low) = middle;
  }
  return chosen;
}

std::string ToText(const LeafTolerance& tolerance) {
  return std::to_string(static_cast<int>(tolerance.of)) + " " + Figure(tolerance.most, 17) + " " +
         std::to_string(tolerance.most_leaves);
}

std::string ToText(const LeafCount& chosen, const LeafTolerance& tolerance, double bound) {
  const auto figure = [&](double value) {
    return tolerance.of == LeafTolerance::Of::kHeight
               ? Figure(1e6 * value, 3) + " um"
               : Figure(180.0 / M_PI * value, 3) + " degrees";
  };
  return WithCommas(chosen.count) + " leaves for " + figure(bound) + ": " + figure(chosen.error) +
         (tolerance.of == LeafTolerance::Of::kHeight ? " off at 95 of 100 places ("
                                                     : " off on average (") +
         std::to_string(chosen.tried) + " counts tried)";
}

}  // namespace palpate
