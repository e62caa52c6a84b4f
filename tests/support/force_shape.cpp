#include "tests/support/force_shape.h"

#include <algorithm>
#include <optional>

#include "tests/support/jump_cause.h"

namespace palpate::test {
namespace {

class Trace {
 public:
  Trace(std::span<const Vec3> force, std::span<const double> by_hand)
      : force_(force), by_hand_(by_hand) {}
  std::size_t size() const { return force_.size(); }
  double At(std::size_t i) const { return force_[i].norm(); }
  double Change(std::size_t from, std::size_t to) const {
    return (force_[to] - force_[from]).norm();
  }
  double ByHand(std::size_t from, std::size_t to) const {
    double most = 0.0;
    for (std::size_t i = from + 1; i <= to && !by_hand_.empty(); ++i) most += by_hand_[i];
    return most;
  }

 private:
  std::span<const Vec3> force_;
  std::span<const double> by_hand_;
};

/// Returns the notch that begins at one step and is first below half at another.
std::optional<ForceNotch> NotchOf(const Trace& trace, std::size_t begin, std::size_t fallen) {
  const double before = trace.At(begin);
  const auto low = [&](std::size_t i) { return trace.At(i) < kFallen * before; };
  if (!(before > kJump) || !low(fallen)) return {};
  for (std::size_t i = begin + 1; i < fallen; ++i) {
    if (low(i)) return {};
  }
  if (before - trace.At(fallen) <= trace.ByHand(begin, fallen)) return {};
  ForceNotch notch{.begin = begin, .before = before, .least = trace.At(fallen)};
  std::size_t last_low = fallen;
  const std::size_t end = std::min(trace.size(), fallen + kNotchSteps + 1);
  for (std::size_t i = fallen + 1; i < end; ++i) {
    if (trace.At(i) > kBack * before) {
      if (trace.At(i) - trace.At(last_low) <= trace.ByHand(last_low, i)) return {};
      notch.end = i;
      notch.after = trace.At(i);
      return notch;
    }
    if (low(i)) last_low = i;
    notch.least = std::min(notch.least, trace.At(i));
  }
  return {};
}

/// Returns a notch whose force is first below half at a given step.  It begins at the last step
/// that qualifies, or earlier if the force jumped down to it, but excludes a gradual release.
std::optional<ForceNotch> NotchAt(const Trace& trace, std::size_t earliest, std::size_t fallen) {
  const std::size_t first = std::max(earliest, fallen - std::min(fallen, kNotchSteps));
  std::optional<ForceNotch> found;
  for (std::size_t begin = fallen; begin-- > first;) {
    const double fall = trace.At(begin) - trace.At(begin + 1);
    if (found && fall <= std::max(kJump, trace.ByHand(begin, begin + 1))) break;
    const std::optional<ForceNotch> notch = NotchOf(trace, begin, fallen);
    if (found && !notch) break;
    found = notch;
  }
  return found;
}

/// The outcome of a change; unknown for one just before the end.
struct Fate {
  bool stays = false;
  std::optional<std::size_t> undone{};
};
Fate FateOf(const Trace& trace, const std::vector<bool>& in_notch, std::size_t step) {
  const double change = trace.Change(step - 1, step);
  std::size_t looked = 0;
  for (std::size_t i = step + 1; i < trace.size() && looked < kNotchSteps; ++i) {
    if (in_notch[i]) continue;
    if (trace.Change(step - 1, i) < (1.0 - kBack) * change) return {.stays = false, .undone = i};
    ++looked;
  }
  return {.stays = looked == kNotchSteps};
}

template <typename T, typename Measure>
T Greatest(std::span<const T> all, Measure measure) {
  const auto at = std::max_element(all.begin(), all.end(),
                                   [&](const T& a, const T& b) { return measure(a) < measure(b); });
  return at == all.end() ? T{} : *at;
}

}  // namespace

ForceShape JudgeForce(std::span<const Vec3> force, std::span<const double> by_hand) {
  const Trace trace(force, by_hand);
  ForceShape shape;
  std::vector<bool> in_notch(trace.size(), false);
  std::size_t earliest = 0;
  for (std::size_t i = 1; i < trace.size(); ++i) {
    const std::optional<ForceNotch> notch = NotchAt(trace, earliest, i);
    if (!notch) continue;
    shape.notches.push_back(*notch);
    // Includes the whole return, beyond 60 % too.
    std::size_t k = notch->begin + 1;
    const auto returns = [&] {
      return trace.At(k - 1) < notch->before && trace.At(k) > trace.At(k - 1);
    };
    for (; k < trace.size() && (k <= notch->end || returns()); ++k) in_notch[k] = true;
    earliest = i = notch->end;
  }
  std::size_t judged_from = 1;
  for (std::size_t i = 1; i < trace.size(); ++i) {
    const double change = trace.Change(i - 1, i);
    if (change > shape.largest_jump.size) shape.largest_jump = {i, change};
    if (i < judged_from || in_notch[i] || !(change > kJump) || change <= trace.ByHand(i - 1, i)) {
      continue;
    }
    const Fate fate = FateOf(trace, in_notch, i);
    if (fate.stays) shape.ledges.push_back({i, change});
    if (!fate.undone) continue;
    shape.passing.push_back({i, change});
    judged_from = *fate.undone + 1;
  }
  return shape;
}

ForceNotch Deepest(std::span<const ForceNotch> notches) {
  return Greatest(notches, [](const ForceNotch& n) { return n.depth(); });
}
ForceNotch Longest(std::span<const ForceNotch> notches) {
  return Greatest(notches, [](const ForceNotch& n) { return n.end - n.begin; });
}
ForceChange Largest(std::span<const ForceChange> changes) {
  return Greatest(changes, [](const ForceChange& c) { return c.size; });
}

}  // namespace palpate::test
