// Small dense linear algebra in double precision; sums run in a fixed order.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "clones.hpp"

namespace vbbench {

/// A row-major matrix whose memory is reused by `reset`.
class Matrix {
 public:
  Matrix() = default;
  Matrix(int rows, int cols) { reset(rows, cols); }

  void reset(int rows, int cols) {
    rows_ = rows;
    cols_ = cols;
    data_.assign(static_cast<std::size_t>(rows) * cols, 0.0);
  }

  int rows() const { return rows_; }
  int cols() const { return cols_; }
  double* operator[](int row) { return data_.data() + static_cast<std::size_t>(row) * cols_; }
  const double* operator[](int row) const { return data_.data() + static_cast<std::size_t>(row) * cols_; }

 private:
  int rows_ = 0, cols_ = 0;
  std::vector<double> data_;
};

constexpr int kLane = 4;  ///< columns of a vectorised block; widths of matrices are multiples of it

inline int padded(int columns) { return (columns + kLane - 1) / kLane * kLane; }

/// target −= Σ by[k] · rows[k], one k after another, in `lanes` · kLane columns.
template <int N>
void subtract_rows(double* __restrict target, const double* const* rows, const double* by, int lanes) {
  const double* r[N];
  double b[N];
  for (int k = 0; k < N; ++k) {
    r[k] = rows[k];
    b[k] = by[k];
  }
  const int columns = lanes * kLane;
  for (int c = 0; c < columns; ++c) {
    double sum = target[c];
    for (int k = 0; k < N; ++k) sum -= b[k] * r[k][c];
    target[c] = sum;
  }
}

/// The same for up to eight rows, in the columns from `begin` to `end`, widened to lanes.
inline void subtract_rows(double* target, const double* const* rows, const double* by, int count, int begin, int end) {
  const int first = begin / kLane * kLane, lanes = (end - first + kLane - 1) / kLane;
  if (lanes <= 0) return;
  const double* from[8];
  for (int k = 0; k < count; ++k) from[k] = rows[k] + first;
  target += first;
  if (count == 8) return subtract_rows<8>(target, from, by, lanes);
  int k = 0;
  if (count - k >= 4) {
    subtract_rows<4>(target, from, by, lanes);
    k += 4;
  }
  if (count - k >= 2) {
    subtract_rows<2>(target, from + k, by + k, lanes);
    k += 2;
  }
  if (count > k) subtract_rows<1>(target, from + k, by + k, lanes);
}

/// The upper Cholesky factor U, Uᵀ U = A, of the symmetric matrix whose upper half stands in `a` [n][stride], in place;
/// the stride is a multiple of kLane, and what stands below the diagonal is lost. False if it is not positive definite.
VBBENCH_WIDE_WHOLE inline bool cholesky(double* a, int n, int stride) {
  constexpr int kBlock = 8;
  for (int i = 0; i < n; ++i) {
    double* row = a + static_cast<std::ptrdiff_t>(i) * stride;
    for (int begin = 0; begin < i; begin += kBlock) {
      const int count = std::min(kBlock, i - begin);
      const double* rows[kBlock];
      double by[kBlock];
      for (int k = 0; k < count; ++k) {
        rows[k] = a + static_cast<std::ptrdiff_t>(begin + k) * stride;
        by[k] = rows[k][i];
      }
      subtract_rows(row, rows, by, count, i, n);
    }
    if (!(row[i] > 0.0)) return false;
    const double scale = 1.0 / std::sqrt(row[i]);
    for (int c = i; c < n; ++c) row[c] *= scale;
  }
  return true;
}

/// Solves Uᵀ Y = B in place for all columns of B [n][count]; `count` is a multiple of kLane.
VBBENCH_WIDE_WHOLE inline void solve_lower(const double* u, int n, int stride, double* b, int count) {
  constexpr int kBlock = 8;
  for (int i = 0; i < n; ++i) {
    double* row = b + static_cast<std::ptrdiff_t>(i) * count;
    for (int begin = 0; begin < i; begin += kBlock) {
      const int block = std::min(kBlock, i - begin);
      const double* rows[kBlock];
      double by[kBlock];
      for (int k = 0; k < block; ++k) {
        rows[k] = b + static_cast<std::ptrdiff_t>(begin + k) * count;
        by[k] = u[static_cast<std::ptrdiff_t>(begin + k) * stride + i];
      }
      subtract_rows(row, rows, by, block, 0, count);
    }
    const double scale = 1.0 / u[static_cast<std::ptrdiff_t>(i) * stride + i];
    for (int c = 0; c < count; ++c) row[c] *= scale;
  }
}

/// Solves Uᵀ U x = b in place.
inline void solve_both(const double* u, int n, int stride, double* x) {
  for (int i = 0; i < n; ++i) {
    const double* row = u + static_cast<std::ptrdiff_t>(i) * stride;
    const double value = x[i] /= row[i];
    for (int c = i + 1; c < n; ++c) x[c] -= value * row[c];
  }
  for (int i = n - 1; i >= 0; --i) {
    const double* row = u + static_cast<std::ptrdiff_t>(i) * stride;
    double sum = x[i];
    for (int c = i + 1; c < n; ++c) sum -= row[c] * x[c];
    x[i] = sum / row[i];
  }
}

}  // namespace vbbench
