#pragma once

#include <cstdint>

namespace palpate {

/// A factor that falls from 1 to 0 (smoothstep) as replies stay away, or as they come from too far
/// in the past, and stays there until a fresh one comes; from then on it climbs back by a ramp.
/// Zero before the first reply.  So a producer that dies leaves no "last force".
class AgeStage {
 public:
  /// Silence, by the station's clock.  A reply or three that are lost are not felt; a dead server
  /// is, as a force that melts within 25 ms.
  static constexpr double kSilenceWhole_s = 0.004;
  static constexpr double kSilenceNone_s = 0.025;
  /// Age of the pose that was answered.  A far server's steady round trip is no fault; beyond this
  /// nothing stiff could be stable anyway.
  static constexpr double kAgeWhole_s = 0.060;
  static constexpr double kAgeNone_s = 0.100;
  static constexpr double kRampIn_s = 0.200;
  /// Steepest slope of the fade: the smoothstep x^2 (3 - 2x) has 1.5; and some for rounding.
  static constexpr double kFastest_1_s = (1.5 + 1e-9) / (kSilenceNone_s - kSilenceWhole_s);

  /// @param silence_s  since the newest usable reply arrived.  @param age_s  since the pose that it
  /// answers was sampled.  Negative, NaN or infinite: as good as none.
  /// While time passes as it should (dt_s is at least what silence_s grew by) the factor is the
  /// smoothstep itself, zero by kSilenceNone_s; where silence leaps it falls at kFastest_1_s, to
  /// zero within 14 ms.
  double Gain(double silence_s, double age_s, double dt_s) noexcept;

  /// Calls with less than the whole wrench.
  std::uint64_t count() const noexcept { return count_; }
  /// Times that it began to fade, after a fresh reply.
  std::uint64_t fades() const noexcept { return fades_; }
  bool fading() const noexcept { return armed_ && gain_ < 1.0; }

 private:
  bool armed_ = false;  // a fresh reply has come
  bool stale_ = true;   // the last call's was not fresh
  double gain_ = 0.0;
  std::uint64_t count_ = 0;
  std::uint64_t fades_ = 0;
};

}  // namespace palpate
