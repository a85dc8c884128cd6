// The walk and pace factors: the process model of people's paths, and the prior of their speed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "../constants.hpp"
#include "elementary.hpp"

namespace vbbench {

constexpr int kReach = 4;  ///< number of earlier frames on which an innovation depends

/// Innovations of second differences, e_t = a_t − b₁ a_{t−1} − b₂ a_{t−2}, at frames of dt seconds.
///
/// The velocity is a random walk of the power density q plus an Ornstein–Uhlenbeck process of the deviation s and the
/// time τ. Its second differences have the autocovariance γ; b and σ are those of the Yule–Walker equations.
struct Walk {
  double dt = 0.4, sigma = 0.08, nu = 5.0;
  std::array<double, 2> b{};
  std::array<double, 3> begin{};  ///< σ of the first and second second difference, and the coefficient between them

  static Walk of(const Constants& c, double dt) {
    const auto gait = [&](int k) {  // autocovariance of displacements
      const double t = c.gait_time, decay = elementary::exp(-dt / t), power = c.gait_speed * c.gait_speed * t * t;
      if (k == 0) return 2.0 * power * (dt / t - 1.0 + decay);
      return power * elementary::exp((1 - k) * dt / t) * (1.0 - decay) * (1.0 - decay);
    };
    std::array<double, 3> g{};
    for (int k = 0; k < 3; ++k) g[k] = 2.0 * gait(k) - gait(k == 0 ? 1 : k - 1) - gait(k + 1);
    const double cube = c.acceleration * dt * dt * dt;
    g[0] += 2.0 / 3.0 * cube;
    g[1] += 1.0 / 6.0 * cube;
    Walk w;
    w.dt = dt;
    w.nu = c.walk_nu;
    const double r1 = g[1] / g[0], r2 = g[2] / g[0], rest = 1.0 - r1 * r1;
    w.b = {r1 * (1.0 - r2) / rest, (r2 - r1 * r1) / rest};
    w.sigma = std::sqrt(g[0] * (1.0 - w.b[0] * r1 - w.b[1] * r2));
    w.begin = {std::sqrt(g[0]), std::sqrt(g[0] * rest), r1};
    return w;
  }

  /// Writes the coefficients `c` of the positions at t, t − 1, … in the innovation of a path that has `past` ≥ 2
  /// earlier frames, and returns its scale in m.
  double coefficients(int past, std::array<double, kReach + 1>& c) const {
    c = {1.0, -2.0, 1.0, 0.0, 0.0};
    double b1 = b[0], b2 = b[1], scale = sigma;
    if (past == 2) {
      b1 = b2 = 0.0;
      scale = begin[0];
    } else if (past == 3) {
      b1 = begin[2];
      b2 = 0.0;
      scale = begin[1];
    }
    if (past > 2) {
      c[1] -= b1;
      c[2] += 2.0 * b1;
      c[3] -= b1;
    }
    if (past > 3) {
      c[2] -= b2;
      c[3] += 2.0 * b2;
      c[4] -= b2;
    }
    return scale;
  }
};

/// The prior's density at a velocity, and the weights (s²/m²) of a step of expectation maximisation: `walk` weighs the
/// residual speed − `walking`, `across` the component across the axis, and `stand` each component of the velocity.
struct Pace {
  double walk, across, stand, density;
};

/// The prior of a pedestrian's velocity: a Gaussian of the speed of those who walk and a Cauchy law for those who
/// stand, both without mass where nobody runs. Of those who walk a share has directions about an axis, the same both
/// ways, and all others any direction.
struct VelocityPrior {
  static constexpr double kFirst = 1.0;          ///< s, for as long as this the first speed of a path counts
  double weight = 0.0;                           ///< 1/s, weight of the log density in a second
  double walking = 0.0, walking_std = 0.0;       ///< m/s
  double standing = 0.0, standing_weight = 0.0;  ///< m/s, and the weight of those who stand
  double running = 0.0, running_std = 0.0;       ///< m/s
  double aligned = 0.0, axis_std = 0.0;          ///< share of those about the axis, and rad
  std::array<double, 2> normal{};                ///< of the axis
  double axis_information = 0.0;                 ///< 1/rad², of all steps about it

  static VelocityPrior of(const Constants& c) {
    return {c.pace, c.walking, c.walking_std, c.standing, c.standing_weight, c.running, c.running_std, 0.0, c.axis_std};
  }

  /// The prior at a `speed` and its component `across` the axis in m/s, weighted for a step of dt seconds.
  Pace at(double speed, double across, double dt) const {
    const double off = (speed - walking) / walking_std, across_std = axis_std * walking;
    double about = 0.0;  // density of directions about the axis, in those of a uniform law
    if (aligned > 0.0) {
      const double turned = across / across_std;
      about = aligned * std::sqrt(0.5 * kPi) / axis_std * elementary::exp(-0.5 * turned * turned);
    }
    const double directed = 1.0 - aligned + about;
    const double walk = (1.0 - standing_weight) / walking_std * elementary::exp(-0.5 * off * off) * directed;
    const double scaled = 1.0 + speed * speed / (standing * standing);
    const double faster = std::max(0.0, speed - running) / running_std;
    const double stand = standing_weight / standing * (faster > 0.0 ? elementary::exp(-0.5 * faster * faster) : 1.0) /
                             (scaled * std::sqrt(scaled)) +
                         1e-300;
    const double share = walk / (walk + stand), rest = 1.0 - share;
    const double beyond = faster > 0.0 ? faster / running_std / (speed - walking) : 0.0;
    const double counts = weight * dt;
    return {counts * (share / (walking_std * walking_std) + rest * beyond),
            counts * share * about / directed / (across_std * across_std),
            counts * rest * 3.0 / scaled / (standing * standing), walk + stand};
  }
};

}  // namespace vbbench
