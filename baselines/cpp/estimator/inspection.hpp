// The linear system of a window as dense matrices, for tests: elimination must give the same solution.
#pragma once

#include <vector>

#include "window.hpp"

namespace vbbench {

/// Columns of the dense system, in the order of `Window::each_number`: the frames; of each person the path and
/// log height; the globals.
class DenseColumns {
 public:
  explicit DenseColumns(const Window& window) : size_(kFrame * static_cast<int>(window.frames.size())) {
    for (const Person& person : window.people) {
      begin_.push_back(size_);
      size_ += 2 * person.frames() + 1;
    }
    size_ += kGlobals;
  }

  int size() const { return size_; }
  int global(int index) const { return size_ - kGlobals + index; }
  int camera(int index) const { return index; }

  int of(const Window& window, int person, const Variable& v) const {
    if (v.kind == Variable::kPath) return begin_[person] + v.index;
    if (v.kind == Variable::kHeight) return begin_[person] + 2 * window.people[person].frames();
    return v.kind == Variable::kShared ? global(v.index) : camera(v.index);
  }

  /// 1 for columns that the window solves for, else 0.
  std::vector<double> free(const Window& window) const {
    std::vector<double> mask(size_, 1.0);
    for (int g = 0; g < kGlobals; ++g) mask[global(g)] = window.calibration.free[g];
    for (int t = 0; t < static_cast<int>(window.frames.size()); ++t)
      for (int c = 0; c < kFrame; ++c)
        mask[camera(kFrame * t + c)] = t >= window.held && (c < kPose || window.calibration.sway_std[0] > 0.0);
    return mask;
  }

 private:
  std::vector<int> begin_;
  int size_;
};

/// The quadratic cost without elimination: ½ Σ w e² of the rows plus ½ xᵀ Λ x + gᵀ x of the Gaussian priors.
struct DenseSystem {
  int size = 0;
  std::vector<double> residuals, weights, jacobian;  ///< [R], [R], [R][N]
  std::vector<double> information, gradient;         ///< [N][N], [N]
  std::vector<double> free;                          ///< [N]
};

inline DenseSystem dense_system(const Window& window, const Model& model) {
  const DenseColumns columns(window);
  DenseSystem out;
  const int n = out.size = columns.size();
  out.information.assign(static_cast<std::size_t>(n) * n, 0.0);
  out.gradient.assign(n, 0.0);
  out.free = columns.free(window);
  const auto add = [&](double e, double w) {
    out.residuals.push_back(e);
    out.weights.push_back(w);
    out.jacobian.resize(out.jacobian.size() + n, 0.0);
    return out.jacobian.size() - n;
  };
  const int people = static_cast<int>(window.people.size());
  for (int p = 0; p < people; ++p) {
    const Person& person = window.people[p];
    const auto add_row = [&](const Row& row) {
      const std::size_t begin = add(row.e, row.w);
      row.each(person.first,
               [&](const Variable& v, double by) { out.jacobian[begin + columns.of(window, p, v)] += by; });
    };
    person_rows(person, window.frames, window.calibration, model.people, RowVisitor(add_row));
    height_row(person, model.people, add_row);
    if (!person.prior.any) continue;
    double off[kPrior];
    int at[kPrior];
    Elimination::prior_offsets(person, window.calibration, off);
    for (int a = 0; a < kPrior; ++a) {
      const Variable v = prior_variable(a);
      const bool absent = v.kind == Variable::kPath && v.index >= 2 * person.frames();
      at[a] = absent ? -1 : columns.of(window, p, v);
    }
    for (int a = 0; a < kPrior; ++a) {
      if (at[a] < 0) continue;
      out.gradient[at[a]] -= person.prior.vector[a];
      for (int b = 0; b < kPrior; ++b) {
        out.gradient[at[a]] += person.prior.information[a][b] * off[b];
        if (at[b] >= 0) out.information[static_cast<std::size_t>(at[a]) * n + at[b]] += person.prior.information[a][b];
      }
    }
  }
  camera_rows(window.frames, window.calibration, model.motion, window.posterior, model.sway_memory, window.held,
              [&](const CameraRow& row) {
                const std::size_t begin = add(row.e, row.w);
                for (int k = 0; k < row.count; ++k)
                  out.jacobian[begin + columns.of(window, -1, row.variables[k])] += row.by[k];
              });
  const Calibration& calibration = window.calibration;
  for (int a = 0; a < kGlobals; ++a) {
    out.gradient[columns.global(a)] -= calibration.vector[a];
    for (int b = 0; b < kGlobals; ++b) {
      if (!calibration.free[a] || !calibration.free[b]) continue;
      const double information = calibration.information[a][b];
      out.gradient[columns.global(a)] += information * (calibration.at[b] - calibration.about[b]);
      out.information[static_cast<std::size_t>(columns.global(a)) * n + columns.global(b)] += information;
    }
  }
  return out;
}

/// The cost of the window after a step [N].
inline double cost_after(Window window, const Model& model, const double* step) {
  window.each_number([&](double& value) { value += *step++; });
  return window.cost(model);
}

/// The undamped step that elimination takes from the present state; empty if the system is not positive definite.
inline std::vector<double> eliminated_step(Window window, const Model& model) {
  window.cost(model);  // posteriors of the modes at the present state
  std::vector<double> step;
  window.each_number([&](double& value) { step.push_back(-value); });
  if (!window.take_step(model, 0.0)) return {};
  std::size_t i = 0;
  window.each_number([&](double& value) { step[i++] += value; });
  return step;
}

}  // namespace vbbench
