#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace palpate {

/// Counts durations [ns] in buckets that widen with the value: exact below 64 ns, within 1/32 (3 %)
/// above, up to 2^40 ns (18 minutes); the maximum is kept exactly.  Fixed size (9.5 kB), plain
/// data, passed to other threads by copy.  One thread at a time.
/// Real-time: no allocation, lock, log or clock.
class Histogram {
 public:
  void Add(std::int64_t nanoseconds) noexcept {
    const std::uint64_t value = nanoseconds < 0 ? 0 : static_cast<std::uint64_t>(nanoseconds);
    ++bucket_[Index(value)];
    ++count_;
    if (value > max_) max_ = value;
  }

  /// Adds all values of another histogram.
  void Add(const Histogram& other) noexcept {
    for (std::size_t i = 0; i < kBuckets; ++i) bucket_[i] += other.bucket_[i];
    count_ += other.count_;
    if (other.max_ > max_) max_ = other.max_;
  }

  void Clear() noexcept { *this = Histogram(); }
  std::uint64_t count() const noexcept { return count_; }
  std::uint64_t max() const noexcept { return max_; }

  /// Returns the value [ns] that the fraction q of all values does not exceed (nearest rank),
  /// rounded up to its bucket's end; 0 if nothing was counted.
  std::uint64_t Quantile(double q) const noexcept {
    std::uint64_t rank = static_cast<std::uint64_t>(q * static_cast<double>(count_));
    if (static_cast<double>(rank) < q * static_cast<double>(count_)) ++rank;
    if (rank == 0) rank = 1;
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += bucket_[i];
      if (seen >= rank) return i + 1 < kBuckets && LastValue(i) < max_ ? LastValue(i) : max_;
    }
    return max_;
  }

 private:
  static constexpr int kSubBits = 5;   // 32 buckets per power of two
  static constexpr int kMaxBits = 40;  // larger values share the last bucket
  static constexpr std::size_t kLinear = std::size_t{2} << kSubBits;
  static constexpr std::size_t kBuckets =
      kLinear + (static_cast<std::size_t>(kMaxBits - kSubBits - 1) << kSubBits);

  static std::size_t Index(std::uint64_t value) noexcept {
    if (value < kLinear) return value;
    const int bits = std::bit_width(value);
    if (bits > kMaxBits) return kBuckets - 1;
    const int shift = bits - 1 - kSubBits;
    return (static_cast<std::size_t>(shift) << kSubBits) + (value >> shift);
  }
  static std::uint64_t LastValue(std::size_t index) noexcept {
    if (index < kLinear) return index;
    const std::size_t shift = (index >> kSubBits) - 1;
    const std::uint64_t mantissa = index - (shift << kSubBits);
    return ((mantissa + 1) << shift) - 1;
  }

  std::array<std::uint64_t, kBuckets> bucket_{};
  std::uint64_t count_ = 0;
  std::uint64_t max_ = 0;
};

}  // namespace palpate
