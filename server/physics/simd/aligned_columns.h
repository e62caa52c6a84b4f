#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace palpate {

/// Columns of doubles for the kernels, initially zero.  Each column begins at a cache line.  The
/// distance between columns is a cache line more than a power of two would be, so that they do not
/// share a cache set.
class AlignedColumns {
 public:
  /// @param rows  of each column; rounded up to a multiple of 16.  Set-up.
  AlignedColumns(std::size_t columns, std::size_t rows)
      : stride_(((rows + 15) & ~std::size_t{15}) + 8),
        storage_(new (kCacheLine) double[columns * stride_]()) {}
  double* operator[](std::size_t column) const { return storage_.get() + column * stride_; }

 private:
  static constexpr std::align_val_t kCacheLine{64};
  struct Delete {
    void operator()(double* p) const { ::operator delete[](p, kCacheLine); }
  };
  std::size_t stride_;
  std::unique_ptr<double[], Delete> storage_;
};

}  // namespace palpate
