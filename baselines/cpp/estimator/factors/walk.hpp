// The walk factor: how people's paths go on.
#pragma once

#include <array>
#include <cmath>

#include "../constants.hpp"

namespace vbbench {

constexpr int kReach = 4;  ///< frames before a frame that its innovation spans

/// Innovations of second differences, e_t = a_t − b₁ a_{t−1} − b₂ a_{t−2}, at frames of dt seconds.
///
/// The velocity is a random walk of the power density q plus an Ornstein–Uhlenbeck process of the deviation s and the
/// time τ. Its second differences have the autocovariance γ; b and σ are those of the Yule–Walker equations.
struct Walk {
  double dt = 0.4, sigma = 0.08, nu = 5.0, people = 12.0;
  std::array<double, 2> b{};
  std::array<double, 3> begin{};  ///< σ of the first and second second difference, and the coefficient between them

  static Walk of(const Constants& c, double dt) {
    const auto gait = [&](int k) {  // autocovariance of displacements
      const double t = c.gait_time, decay = std::exp(-dt / t), power = c.gait_speed * c.gait_speed * t * t;
      if (k == 0) return 2.0 * power * (dt / t - 1.0 + decay);
      return power * std::pow(decay, k - 1) * (1.0 - decay) * (1.0 - decay);
    };
    std::array<double, 3> g{};
    for (int k = 0; k < 3; ++k) g[k] = 2.0 * gait(k) - gait(k == 0 ? 1 : k - 1) - gait(k + 1);
    const double cube = c.acceleration * dt * dt * dt;
    g[0] += 2.0 / 3.0 * cube;
    g[1] += 1.0 / 6.0 * cube;
    Walk w;
    w.dt = dt;
    w.nu = c.walk_nu;
    w.people = c.walk_people;
    const double r1 = g[1] / g[0], r2 = g[2] / g[0], rest = 1.0 - r1 * r1;
    w.b = {r1 * (1.0 - r2) / rest, (r2 - r1 * r1) / rest};
    w.sigma = std::sqrt(g[0] * (1.0 - w.b[0] * r1 - w.b[1] * r2));
    w.begin = {std::sqrt(g[0]), std::sqrt(g[0] * rest), r1};
    return w;
  }

  /// Coefficients of the positions at t, t − 1, … in the innovation that a path with `past` frames before t allows
  /// (0 for the first frame of a path), and its scale beside σ_k/σ. No innovation for past < 2.
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

constexpr double kStroll = 1.3, kStrollStd = 0.35;    ///< m/s: how fast people walk
constexpr double kRestScale = 0.06, kResting = 0.25;  ///< m/s and the share of those who stand
constexpr double kFastWalk = 2.0, kRunning = 0.5;     ///< m/s: speed up to which people walk, and σ beyond it

/// Weights and density of a speed under the prior of pedestrians, who walk or stand: e = speed − kStroll with the
/// weight `walking`, and each component of the velocity with the weight `resting`, as expectation maximisation has
/// them. Who stands hardly moves, so this is a Cauchy law, which ends where nobody runs.
struct Pace {
  double walking, resting, density;
};
inline Pace pace_of(double speed, double weight) {
  const double walking = (1.0 - kResting) / kStrollStd * std::exp(-0.5 * std::pow((speed - kStroll) / kStrollStd, 2));
  const double scaled = 1.0 + speed * speed / (kRestScale * kRestScale);
  const double faster = std::max(0.0, speed - kFastWalk) / kRunning;
  const double resting =
      kResting / kRestScale * std::exp(-0.5 * faster * faster) / (scaled * std::sqrt(scaled)) + 1e-300;
  const double share = walking / (walking + resting), rest = 1.0 - share;
  const double running = faster > 0.0 ? faster / kRunning / (speed - kStroll) : 0.0;
  return {weight * (share / (kStrollStd * kStrollStd) + rest * running),
          weight * rest * 3.0 / scaled / (kRestScale * kRestScale), walking + resting};
}

}  // namespace vbbench
