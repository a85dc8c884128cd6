// The linear system of one step: every person is eliminated exactly, which leaves camera and calibration.
#pragma once

#include <algorithm>
#include <vector>

#include "factors/person.hpp"

namespace vbbench {

/// Columns of the reduced system: globals that are free, then the free frames in order.
struct Layout {
  std::array<int, kGlobals> global{};  ///< −1: fixed
  int globals = 0, held = 0, frames = 0, unknowns = kFrame;

  int size() const { return globals + (frames - held) * unknowns; }
  int camera(int index) const {  ///< of frame component `index`; −1 where it is held or fixed
    const int frame = index / kFrame, component = index % kFrame;
    if (frame < held || component >= unknowns) return -1;
    return globals + (frame - held) * unknowns + component;
  }
  int of(const Variable& v) const {
    if (v.kind == Variable::kShared) return global[v.index];
    if (v.kind == Variable::kCamera) return camera(v.index);
    return -1;
  }
};

/// H and −gradient of the reduced system.
struct Reduced {
  Matrix hessian;  ///< lower half
  std::vector<double> vector;

  void reset(int size) {
    hessian.reset(size, size);
    vector.assign(size, 0.0);
  }
  void add(const Row& row, const Layout& layout) {
    int columns[24];
    double by[24];
    int count = 0;
    for (int k = 0; k < row.count; ++k) {
      const int column = layout.of(row.variables[k]);
      if (column >= 0) {
        columns[count] = column;
        by[count++] = row.by[k];
      }
    }
    for (int a = 0; a < count; ++a) {
      vector[columns[a]] -= row.w * row.e * by[a];
      for (int b = 0; b < count; ++b)
        if (columns[b] <= columns[a]) hessian[columns[a]][columns[b]] += row.w * by[a] * by[b];
    }
  }
};

/// The local system of one person: A x = b + B c, of which L Lᵀ = A and X = L⁻¹ [b | B] remain after elimination.
class Elimination {
 public:
  int local = 0;  ///< 2 · nodes + 2

  void reset(const Person& person, const Layout& layout, double damping) {
    local = 2 * person.frames() + 2;
    layout_ = &layout;
    columns_ = 1 + layout.size();
    damping_ = damping;
    factor_.reset(local, local);
    right_.reset(local, columns_);
    first_.assign(local, local);
    low_.assign(local, columns_);
    high_.assign(local, 1 + layout.globals);
  }

  int index_of(const Variable& v) const {
    if (v.kind == Variable::kPath) return v.index;
    if (v.kind == Variable::kHeight) return local - 2;
    if (v.kind == Variable::kOwn) return local - 1;
    return -1;
  }

  void add(const Row& row, Reduced& reduced) {
    int inner[24], outer[24], inners = 0, outers = 0;
    double by_inner[24], by_outer[24];
    for (int k = 0; k < row.count; ++k) {
      const int i = index_of(row.variables[k]);
      if (i >= 0) {
        inner[inners] = i;
        by_inner[inners++] = row.by[k];
        continue;
      }
      const int column = layout_->of(row.variables[k]);
      if (column >= 0) {
        outer[outers] = column;
        by_outer[outers++] = row.by[k];
      }
    }
    for (int a = 0; a < inners; ++a) {
      const int i = inner[a];
      const double weighted = row.w * by_inner[a];
      double* line = factor_[i];
      for (int b = 0; b < inners; ++b) {
        if (inner[b] > i) continue;
        line[inner[b]] += weighted * by_inner[b];
        first_[i] = std::min(first_[i], inner[b]);
      }
      double* right = right_[i];
      right[0] -= weighted * row.e;
      for (int b = 0; b < outers; ++b) add_right(i, right, 1 + outer[b], weighted * by_outer[b]);
    }
    for (int a = 0; a < outers; ++a) {
      const double weighted = row.w * by_outer[a];
      reduced.vector[outer[a]] -= weighted * row.e;
      double* line = reduced.hessian[outer[a]];
      for (int b = 0; b < outers; ++b)
        if (outer[b] <= outer[a]) line[outer[b]] += weighted * by_outer[b];
    }
  }

  /// Adds the marginal prior of the person.
  void add_prior(const Person& person, const Calibration& calibration, Reduced& reduced) {
    const MarginalPrior& prior = person.prior;
    if (!prior.any) return;
    double off[kPrior], gradient[kPrior];
    int inner[kPrior], outer[kPrior];
    prior_offsets(person, calibration, off);
    for (int a = 0; a < kPrior; ++a) {
      gradient[a] = prior.vector[a];
      for (int b = 0; b < kPrior; ++b) gradient[a] -= prior.information[a][b] * off[b];
      inner[a] = outer[a] = -1;
      if (a < kPriorPlaces) {
        if (a < 2 * person.frames()) inner[a] = a;
      } else if (a < kPriorPlaces + 2) {
        inner[a] = local - 2 + a - kPriorPlaces;
      } else {
        outer[a] = layout_->global[a - kPriorPlaces - 2];
      }
    }
    for (int a = 0; a < kPrior; ++a) {
      if (inner[a] >= 0) {
        right_[inner[a]][0] += gradient[a];
        for (int b = 0; b < kPrior; ++b) {
          if (inner[b] >= 0 && inner[b] <= inner[a]) {
            factor_[inner[a]][inner[b]] += prior.information[a][b];
            first_[inner[a]] = std::min(first_[inner[a]], inner[b]);
          }
          if (outer[b] >= 0) right_[inner[a]][1 + outer[b]] += prior.information[a][b];
        }
      } else if (outer[a] >= 0) {
        reduced.vector[outer[a]] += gradient[a];
        for (int b = 0; b < kPrior; ++b)
          if (outer[b] >= 0 && outer[b] <= outer[a]) reduced.hessian[outer[a]][outer[b]] += prior.information[a][b];
      }
    }
  }

  static void prior_offsets(const Person& person, const Calibration& calibration, double* off) {
    for (int a = 0; a < kPrior; ++a) {
      double at = 0.0;
      if (a < kPriorPlaces) {
        at = a / 2 < person.frames() ? person.nodes[a / 2].at[a % 2] : person.prior.about[a];
      } else if (a == kPriorPlaces) {
        at = person.log_height;
      } else if (a == kPriorPlaces + 1) {
        at = person.own_edge;
      } else {
        at = calibration.at[a - kPriorPlaces - 2];
      }
      off[a] = at - person.prior.about[a];
    }
  }
  static double prior_cost(const Person& person, const Calibration& calibration) {
    if (!person.prior.any) return 0.0;
    double off[kPrior], sum = 0.0;
    prior_offsets(person, calibration, off);
    for (int a = 0; a < kPrior; ++a) {
      double row = 0.0;
      for (int b = 0; b < kPrior; ++b) row += person.prior.information[a][b] * off[b];
      sum += off[a] * (0.5 * row - person.prior.vector[a]);
    }
    return sum;
  }

  /// Factorises, and subtracts Xᵀ X from the reduced system. False if A is not positive definite.
  bool eliminate(Reduced& reduced) {
    for (int i = 0; i < local; ++i) factor_[i][i] += damping_ * factor_[i][i] + 1e-9;
    if (!cholesky(factor_, local, &first_)) return false;
    const int globals = 1 + layout_->globals;
    for (int i = 0; i < local; ++i) {
      double* row = right_[i];
      for (int k = first_[i]; k < i; ++k) {
        const double l = factor_[i][k];
        if (l == 0.0) continue;
        const double* other = right_[k];
        low_[i] = std::min(low_[i], low_[k]);
        high_[i] = std::max(high_[i], high_[k]);
        for (int c = 0; c < globals; ++c) row[c] -= l * other[c];
        for (int c = low_[k]; c < high_[k]; ++c) row[c] -= l * other[c];
      }
      const double scale = 1.0 / factor_[i][i];
      for (int c = 0; c < globals; ++c) row[c] *= scale;
      for (int c = low_[i]; c < high_[i]; ++c) row[c] *= scale;
    }
    subtract(reduced, globals);
    return true;
  }

  /// The step of the person's own variables, given that of the reduced ones.
  void back_substitute(const std::vector<double>& step, std::vector<double>& own) const {
    own.assign(local, 0.0);
    for (int i = 0; i < local; ++i) {
      const double* row = right_[i];
      double sum = row[0];
      for (int c = 0; c < layout_->globals; ++c) sum -= row[1 + c] * step[c];
      for (int c = low_[i]; c < high_[i]; ++c) sum -= row[c] * step[c - 1];
      own[i] = sum;
    }
    solve_upper(factor_, local, own.data(), &first_);
  }

  /// L⁻¹ g of a gradient g by the person's own variables, in place.
  void whiten(std::vector<double>& g) const { solve_lower(factor_, local, g.data(), &first_); }

  /// w gᵀ H⁻¹ g of a row with the gradient g by the person's own variables: how far the fit follows it; and
  /// w gᵀ H⁻¹ g' with the gradient g' by the path alone: by how much ½ ln det H falls with the log scale of the path.
  std::array<double, 2> leverage(const Row& row) {
    scratch_.assign(local, 0.0);
    path_.assign(local, 0.0);
    for (int k = 0; k < row.count; ++k) {
      const int i = index_of(row.variables[k]);
      if (i < 0) continue;
      scratch_[i] += row.by[k];
      if (row.variables[k].kind == Variable::kPath) path_[i] += row.by[k];
    }
    whiten(scratch_);
    whiten(path_);
    double all = 0.0, path = 0.0;
    for (int i = 0; i < local; ++i) {
      all += scratch_[i] * scratch_[i];
      path += scratch_[i] * path_[i];
    }
    return {row.w * all, row.w * path};
  }

  /// Covariance [2][2] of the place of the node, given the Cholesky factor of the reduced system.
  std::array<double, 3> place_covariance(int node, const Matrix& reduced_factor, int size) const {
    double own[2][2] = {}, through[2][2] = {};
    std::vector<double> unit(local), row(size);
    std::vector<std::vector<double>> rows;
    std::vector<std::vector<double>> units;
    for (int axis = 0; axis < 2; ++axis) {
      std::fill(unit.begin(), unit.end(), 0.0);
      unit[2 * node + axis] = 1.0;
      solve_lower(factor_, local, unit.data(), &first_);  // L⁻¹ e
      std::fill(row.begin(), row.end(), 0.0);
      for (int i = 2 * node; i < local; ++i) {
        const double u = unit[i];
        if (u == 0.0) continue;
        const double* right = right_[i];
        for (int c = 0; c < layout_->globals; ++c) row[c] += u * right[1 + c];
        for (int c = low_[i]; c < high_[i]; ++c) row[c - 1] += u * right[c];
      }
      solve_lower(reduced_factor, size, row.data());
      rows.push_back(row);
      units.push_back(unit);
    }
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b <= a; ++b) {
        for (int i = 0; i < local; ++i) own[a][b] += units[a][i] * units[b][i];
        for (int i = 0; i < size; ++i) through[a][b] += rows[a][i] * rows[b][i];
      }
    return {own[0][0] + through[0][0], own[1][0] + through[1][0], own[1][1] + through[1][1]};
  }

 private:
  void add_right(int i, double* right, int column, double value) {
    right[column] += value;
    if (column > layout_->globals) {
      low_[i] = std::min(low_[i], column);
      high_[i] = std::max(high_[i], column + 1);
    }
  }

  /// S −= Xᵀ X, four rows of X at a time.
  void subtract(Reduced& reduced, int globals) {
    for (int i = 0; i < local; i += 4) {
      const int rows = std::min(4, local - i);
      int low = columns_, high = globals;
      const double* x[4];
      static const std::vector<double> nothing(4096, 0.0);
      for (int r = 0; r < 4; ++r) {
        x[r] = r < rows ? right_[i + r] : nothing.data();
        if (r < rows) {
          low = std::min(low, low_[i + r]);
          high = std::max(high, high_[i + r]);
        }
      }
      const double *x0 = x[0], *x1 = x[1], *x2 = x[2], *x3 = x[3];
      const auto line = [&](int a) {
        const double a0 = x0[a], a1 = x1[a], a2 = x2[a], a3 = x3[a];
        reduced.vector[a - 1] -= a0 * x0[0] + a1 * x1[0] + a2 * x2[0] + a3 * x3[0];
        double* target = reduced.hessian[a - 1];
        for (int c = 1; c < std::min(globals, a + 1); ++c)
          target[c - 1] -= a0 * x0[c] + a1 * x1[c] + a2 * x2[c] + a3 * x3[c];
        for (int c = low; c <= a; ++c) target[c - 1] -= a0 * x0[c] + a1 * x1[c] + a2 * x2[c] + a3 * x3[c];
      };
      for (int a = 1; a < globals; ++a) {
        const double a0 = x0[a], a1 = x1[a], a2 = x2[a], a3 = x3[a];
        reduced.vector[a - 1] -= a0 * x0[0] + a1 * x1[0] + a2 * x2[0] + a3 * x3[0];
        double* target = reduced.hessian[a - 1];
        for (int c = 1; c <= a; ++c) target[c - 1] -= a0 * x0[c] + a1 * x1[c] + a2 * x2[c] + a3 * x3[c];
      }
      for (int a = low; a < high; ++a) line(a);
    }
  }

  const Layout* layout_ = nullptr;
  int columns_ = 0;
  double damping_ = 0.0;
  Matrix factor_, right_;
  std::vector<double> scratch_, path_;
  std::vector<int> first_, low_, high_;
};

}  // namespace vbbench
