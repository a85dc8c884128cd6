// Pose and people together under unsquared norms, by iterative reweighting.
//
// The cascade's first energy with D_k = ‖F_k − ẍ_k‖ (arXiv 2111.05060, eq. 11) is, with m_k = ‖x_k − p_k‖/σ_k,
//
//     E_c = Σ_k ρ(m_k) + ½ (z_k − Rᵀ(x_k − c))ᵀ N_k⁻¹ (z_k − Rᵀ(x_k − c)),   ρ(m) = √(m² + ε²),
//
// the observer being one more walker with z = 0, N = 0. ρ is the norm, smooth below ε standard deviations: the gradient
// of a large deviation is bounded. Since ρ is concave in m²,
//
//     ρ(m) ≤ ½ w m² + constant,   w = 1/√(m_now² + ε²),   with equality at m_now,
//
// and the right-hand side is the weighted energy that `fit_pose` and `localise` minimise exactly, over all poses: each
// round lowers E_c, and the first is the global least-squares fit, wherever the observer was before. The box terms keep
// their own covariances: only the motion's variance σ_k² is divided by w. The gradient of E_c is that of the weighted
// energy at the same place.
#pragma once

#include <cmath>
#include <vector>

#include "ego_motion.hpp"
#include "elementary.hpp"

namespace vbbench::cascade {

/// How `minimise` and `descend` end: after some rounds, or when nothing moved by `tolerance` (m, rad) or more.
struct Stop {
  int rounds;
  double tolerance;
};

/// Weights w [K] of positions [K, 2] by their deviations from predictions; 1 without prediction.
inline void weigh(const double* positions, const Factors& factors, double softness, double* weights) {
  for (int k = 0; k < factors.people; ++k) {
    const double x = positions[2 * k] - factors.expected[2 * k];
    const double y = positions[2 * k + 1] - factors.expected[2 * k + 1];
    const double squared = (x * x + y * y) / square(factors.std[k]);
    weights[k] = std::isnan(squared) ? 1.0 : 1.0 / std::sqrt(squared + square(softness));
  }
}

/// Standard deviations [K] under weights.
inline void spread_by(const Factors& factors, const double* weights, double* spread) {
  for (int k = 0; k < factors.people; ++k) spread[k] = factors.std[k] / std::sqrt(weights[k]);
}

/// Whether a coordinate of a place [K, 2] changed by `distance` m or more; NaN counts as unchanged.
inline bool moved(const double* before, const double* after, int people, double distance) {
  for (int i = 0; i < 2 * people; ++i)
    if (std::abs(after[i] - before[i]) >= distance) return true;
  return false;
}

/// Where E_c is least: the pose, positions [K, 2] (NaN = not observed) and weights [K] of the people's terms.
struct Minimum {
  Pose pose;
  std::vector<double> positions, weights;
};

/// Minimises E_c over the people and the pose, unless that is known and not NaN.
inline Minimum minimise(const Factors& factors, const Pose& known, double softness, const Stop& stop, double facing) {
  const int people = factors.people;
  const bool free = std::isnan(known[2]);
  Minimum found{known, std::vector<double>(2 * people, kInfinity), std::vector<double>(people, 1.0)};
  std::vector<double> spread(factors.std, factors.std + people), last(2 * people);
  Factors weighted = factors;
  weighted.std = spread.data();
  double walk_weight = 1.0;
  for (int round = 0; round < stop.rounds; ++round) {
    const Pose before = found.pose;
    last.swap(found.positions);
    weighted.walk_std = factors.walk_std / std::sqrt(walk_weight);
    if (free) found.pose = fit_pose(weighted, facing);
    localise(found.pose, weighted, found.positions.data());
    bool held = true;
    for (int i = 0; i < 3; ++i) held = held && std::abs(found.pose[i] - before[i]) < stop.tolerance;
    if (held && !moved(last.data(), found.positions.data(), people, stop.tolerance)) break;
    weigh(found.positions.data(), factors, softness, found.weights.data());
    spread_by(factors, found.weights.data(), spread.data());
    if (free && !std::isinf(factors.walk_std)) {
      const Pose& walk = factors.walk;
      const double stray = elementary::hypot(found.pose[0] - walk[0], found.pose[1] - walk[1]) / factors.walk_std;
      walk_weight = 1.0 / std::sqrt(square(stray) + square(softness));
    }
  }
  return found;
}

}  // namespace vbbench::cascade
