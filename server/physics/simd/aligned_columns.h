#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace palpate {

/// Columns of doubles for the kernels: each begins at a cache line, and they lie a cache line apart
/// from a power of two, or all would share a cache set.  Zero at first.
class AlignedColumns {
 public:
  /// @param rows  of each column, to the next multiple of 16.  Set-up.
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
