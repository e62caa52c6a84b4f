#pragma once

#include <cmath>
#include <utility>

namespace palpate {

/// The linear system H x = g of one step.  H starts as the identity; forces a (base + k b . x) are
/// added one by one.
template <int N>
class LinearSystem {
 public:
  explicit LinearSystem(const double (&g)[N]) {
    for (int r = 0; r < N; ++r) {
      g_[r] = g[r];
      for (int c = 0; c < N; ++c) H_[r][c] = r == c ? 1.0 : 0.0;
    }
  }
  void Add(const double (&a)[N], double base, double k, const double (&b)[N]) {
    for (int r = 0; r < N; ++r) {
      g_[r] -= base * a[r];
      const double part = k * a[r];
      for (int c = 0; c < N; ++c) H_[r][c] += part * b[c];
    }
  }
  /// Solves by elimination with row exchanges.
  void Solve(double (&x)[N]) {
    for (int k = 0; k < N; ++k) {
      int pivot = k;
      for (int i = k + 1; i < N; ++i) {
        if (std::fabs(H_[i][k]) > std::fabs(H_[pivot][k])) pivot = i;
      }
      if (pivot != k) {
        std::swap(H_[pivot], H_[k]);
        std::swap(g_[pivot], g_[k]);
      }
      const double inverse = 1.0 / H_[k][k];
      for (int i = k + 1; i < N; ++i) {
        const double part = H_[i][k] * inverse;
        for (int j = k + 1; j < N; ++j) H_[i][j] -= part * H_[k][j];
        g_[i] -= part * g_[k];
      }
    }
    for (int k = N - 1; k >= 0; --k) {
      double sum = g_[k];
      for (int j = k + 1; j < N; ++j) sum -= H_[k][j] * x[j];
      x[k] = sum / H_[k][k];
    }
  }

 private:
  double H_[N][N], g_[N];
};

}  // namespace palpate
