// Small dense linear algebra in double precision; sums run in a fixed order.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace vbbench {

/// A row-major matrix that keeps its memory when it is made again.
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

/// The lower Cholesky factor of the symmetric matrix whose lower half stands in the first n rows of `a`, in place.
/// `first[i]`, where given, is the first column of row i that is not zero (a skyline). False if it is not positive
/// definite.
inline bool cholesky(Matrix& a, int n, const std::vector<int>* first = nullptr) {
  for (int i = 0; i < n; ++i) {
    double* row = a[i];
    const int from = first ? (*first)[i] : 0;
    for (int j = from; j < i; ++j) {
      const double* other = a[j];
      double sum = row[j];
      const int start = first ? std::max(from, (*first)[j]) : 0;
      for (int k = start; k < j; ++k) sum -= row[k] * other[k];
      row[j] = sum / other[j];
    }
    double diagonal = row[i];
    for (int k = from; k < i; ++k) diagonal -= row[k] * row[k];
    if (!(diagonal > 0.0)) return false;
    row[i] = std::sqrt(diagonal);
  }
  return true;
}

/// Solve L x = b in place.
inline void solve_lower(const Matrix& l, int n, double* x, const std::vector<int>* first = nullptr) {
  for (int i = 0; i < n; ++i) {
    const double* row = l[i];
    double sum = x[i];
    for (int k = first ? (*first)[i] : 0; k < i; ++k) sum -= row[k] * x[k];
    x[i] = sum / row[i];
  }
}

/// Solve Lᵀ x = b in place.
inline void solve_upper(const Matrix& l, int n, double* x, const std::vector<int>* first = nullptr) {
  for (int i = n - 1; i >= 0; --i) {
    const double* row = l[i];
    x[i] /= row[i];
    for (int k = first ? (*first)[i] : 0; k < i; ++k) x[k] -= row[k] * x[i];
  }
}

}  // namespace vbbench
