// How the cascade's energies rise away from their minimum: −ln p of the observer's pose, and people's beliefs.
//
// The first energy (`reweighting.hpp`) at a pose (c, R), each person minimised out, is
//
//     E_c(c, R) = ρ(m_0) + Σ_k min over x of ρ(‖x − p_k‖/σ_k) + ½‖z_k − Rᵀ(x − c)‖²_{N_k⁻¹}.
//
// Since ρ(m) = √(m² + ε²) is the least over v > 0 of ½(m²/v + v + ε²/v), a person's place can be eliminated as under
// squared norms, with σ_k² v for σ_k². Along the principal axes of N_k, in the camera's frame, with
// r_k = z_k + Rᵀ(c − p_k), what remains is one convex function of one number,
//
//     g(v) = ½ [ r_1²/(σ²v + n_1) + r_2²/(σ²v + n_2) + v + ε²/v ],
//
// whose derivative is concave: Newton's method from the left of its zero never steps over it. With N_k = 0 it is ρ.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "ego_motion.hpp"
#include "elementary.hpp"
#include "message_passing.hpp"

namespace vbbench::cascade {

/// A person's terms along the principal axes of N: the first axis is (along, across) as (right, forward), n_1 ≥ n_2.
struct Principal {
  double p_x, p_y, variance, z_1, z_2, along, across, n_1, n_2;

  Principal(const double* relative, const double* covariance, const double* expected, double std)
      : p_x(expected[0]), p_y(expected[1]), variance(square(std)) {
    const double rr = covariance[0], rf = covariance[1], ff = covariance[2];
    const double angle = 0.5 * elementary::atan2(2.0 * rf, rr - ff);
    along = elementary::cos(angle), across = elementary::sin(angle);
    const double middle = 0.5 * (rr + ff), half = elementary::hypot(0.5 * (rr - ff), rf);
    z_1 = along * relative[0] + across * relative[1];
    z_2 = along * relative[1] - across * relative[0];
    n_1 = middle + half, n_2 = std::max(middle - half, 0.0);
  }

  /// The least g(v) of squared distances along the axes.
  double least(double s_1, double s_2, double softness) const {
    constexpr double kFine = 1e-4;  // Newton's relative step to stop at; the energy's own error is its square
    const double squared = square(softness);
    if (n_1 <= 1e-9 * variance) return std::sqrt((s_1 + s_2) / variance + squared);
    double v = std::max(softness, std::sqrt((s_1 + s_2) / variance) - n_1 / variance);
    for (int round = 0; round < 50; ++round) {
      const double t_1 = 1.0 / (variance * v + n_1), t_2 = 1.0 / (variance * v + n_2), bend = squared / (v * v);
      const double pull_1 = s_1 * variance * t_1 * t_1, pull_2 = s_2 * variance * t_2 * t_2;
      const double slope = 1.0 - bend - pull_1 - pull_2;
      const double step = -slope / (2.0 * (bend / v + variance * (pull_1 * t_1 + pull_2 * t_2)));
      v += step;
      if (std::abs(step) <= kFine * v) break;
    }
    return 0.5 * (s_1 / (variance * v + n_1) + s_2 / (variance * v + n_2) + v + squared / v);
  }
};

/// −ln p [N] of the observer's poses [N, 3], up to a constant, people's places minimised out.
inline void pose_energies(const double* poses, int count, const Factors& factors, double softness, double facing,
                          double* energies) {
  std::vector<Principal> people;
  for (int k = 0; k < factors.people; ++k)
    if (factors.usable(k))
      people.emplace_back(factors.relative + 2 * k, factors.covariance + 3 * k, factors.expected + 2 * k,
                          factors.std[k]);
  const Pose& walk = factors.walk;
  for (int n = 0; n < count; ++n) {
    const double x = poses[3 * n], y = poses[3 * n + 1], yaw = poses[3 * n + 2];
    const double sin = elementary::sin(yaw), cos = elementary::cos(yaw),
                 off = square(x - walk[0]) + square(y - walk[1]);
    double total = facing * (1.0 - elementary::cos(yaw - walk[2]));
    total += std::isinf(factors.walk_std) ? 0.5 * kVague * off
                                          : std::sqrt(off / square(factors.walk_std) + square(softness));
    for (const Principal& p : people) {
      const double dx = p.p_x - x, dy = p.p_y - y;
      const double right = dx * sin - dy * cos, forward = dx * cos + dy * sin;
      const double r_1 = p.z_1 - (p.along * right + p.across * forward);
      const double r_2 = p.z_2 - (p.along * forward - p.across * right);
      total += p.least(r_1 * r_1, r_2 * r_2, softness);
    }
    energies[n] = total;
  }
}

/// Probability [K, S] of each person's samples by the messages: exp(−belief), of sum 1.
///
/// Beliefs are min-marginals: a sample has the probability of the best joint choice that contains it.
inline std::vector<double> ray_beliefs(const Choices& choices, const Passing& how) {
  int rounds = 0;
  std::vector<double> beliefs = pass_beliefs(choices, how, rounds);
  for (int k = 0; k < choices.nodes; ++k) {
    double* row = beliefs.data() + static_cast<std::size_t>(k) * choices.samples;
    const double least = *std::min_element(row, row + choices.samples);
    double total = 0.0;
    for (int s = 0; s < choices.samples; ++s) total += row[s] = elementary::exp(least - row[s]);
    for (int s = 0; s < choices.samples; ++s) row[s] /= total;
  }
  return beliefs;
}

}  // namespace vbbench::cascade
