// Ego-motion: the observer's pose as the exact minimiser of its energy, and people's positions once it is known.
//
// People are expected at p_k with variance σ_k² and measured at z_k in the camera's frame with covariance N_k. The
// energy of a pose (c, R) and the people's positions x_k,
//
//     Σ_k ‖x_k − p_k‖²/σ_k² + (z_k − Rᵀ(x_k − c))ᵀ N_k⁻¹ (z_k − Rᵀ(x_k − c)),
//
// is least over the x_k, that is with the people's own places (their depths among them) eliminated, at
//
//     E(c, R) = Σ_k r_kᵀ W_k r_k,   r_k = z_k + Rᵀ(c − p_k),   W_k = (σ_k² I + N_k)⁻¹,
//
// because a sum of two independent normal errors has the sum of their covariances and σ_k² I does not turn with R. This
// is E_c of arXiv 2111.05060, section IV-B, for normal factors. The observer is one more person with z = 0 and N = 0.
//
// With m = (cos yaw, sin yaw), q = −Rᵀ(c − o) and d_k = p_k − o about any origin o, r_k = z_k − q − D_k m is linear in
// q and m; eliminating q leaves mᵀAm − 2gᵀm on the unit circle, a trigonometric polynomial of degree two, whose global
// minimum one scan and Newton's method find. With every W_k a multiple of I, A is one too, and yaw = atan2(g_2, g_1) is
// the weighted rigid (Procrustes) fit. The people are summed over once.
//
// With the origin o at any other place c, q = 0 and E(c, R) = mᵀAm − 2gᵀm + const.: minimised over yaw, this is the
// energy of the observer at c. E is a sum of squared, normalised errors, so −ln p = E/2.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "elementary.hpp"

namespace vbbench::cascade {

constexpr double kVague = 1e-6;  ///< 1/m² and 1/rad²: holds the pose in directions that people do not determine
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;

using Pose = std::array<double, 3>;  ///< x, y in m, yaw in rad

/// The terms of a frame's energy, see `factors.py`: arrays [K, 2], [K, 3], [K, 2], [K] and the observer's pose.
struct Factors {
  int people;
  const double *relative, *covariance, *expected, *std;
  Pose walk;
  double walk_std;

  /// Whether a person is seen and expected.
  bool usable(int k) const { return !std::isnan(std[k]) && !std::isnan(relative[2 * k]); }
};

/// A symmetric matrix [[a, b], [b, c]].
struct Symmetric {
  double a, b, c;

  Symmetric inverse() const {
    const double determinant = a * c - b * b;
    return {c / determinant, -b / determinant, a / determinant};
  }
};

struct Vector {
  double x, y;
};

inline double square(double x) { return x * x; }

/// The angle in rad wrapped to [−π, π), as by `vbbench.geometry.wrap_angle`.
inline double wrapped(double angle) {
  double turned = std::fmod(angle + kPi, 2.0 * kPi);
  if (turned < 0.0) turned += 2.0 * kPi;
  return turned - kPi;
}

/// (σ_k² I + N_k)⁻¹ of a person expected with this variance.
inline Symmetric information(const double* covariance, double variance) {
  return Symmetric{covariance[0] + variance, covariance[1], covariance[2] + variance}.inverse();
}

/// mᵀAm − 2gᵀm, m = (cos, sin) of an angle.
struct Polynomial {
  Symmetric a;
  Vector g;

  double at(double cos, double sin) const {
    return a.a * cos * cos + 2.0 * a.b * cos * sin + a.c * sin * sin - 2.0 * (g.x * cos + g.y * sin);
  }
  double operator()(double angle) const { return at(elementary::cos(angle), elementary::sin(angle)); }
};

/// Newton's method downhill from `angle`, in moves of at most `reach` rad.
inline double descend_circle(const Polynomial& energy, double angle, double reach) {
  const auto& [a, g] = energy;
  for (int round = 0; round < 50; ++round) {
    const double cos = elementary::cos(angle), sin = elementary::sin(angle);
    const double cos2 = cos * cos - sin * sin, sin2 = 2.0 * sin * cos, spread = a.c - a.a;
    const double slope = spread * sin2 + 2.0 * a.b * cos2 + 2.0 * (g.x * sin - g.y * cos);
    const double curvature = 2.0 * spread * cos2 - 4.0 * a.b * sin2 + 2.0 * (g.x * cos + g.y * sin);
    double move = -slope / std::max({std::abs(curvature), std::abs(slope) / reach, 1e-300});
    if (std::abs(move) > 1e-7) {
      const double here = energy.at(cos, sin);
      while (std::abs(move) > 1e-7 && energy(angle + move) > here) move *= 0.5;
    }
    angle += move;
    if (std::abs(move) < 1e-13) break;
  }
  return angle;
}

/// The angle in [−π, π) at which the polynomial is least over the whole circle.
///
/// Newton's method starts from every local minimum of a scan, whose steps may be too wide to rank them. A polynomial of
/// degree two has at most two minima on the circle.
inline double least_angle(const Polynomial& energy) {
  constexpr int kScan = 32;
  constexpr double kStep = 2.0 * kPi / kScan;
  static const auto directions = [] {
    std::array<Vector, kScan> found;
    for (int i = 0; i < kScan; ++i) found[i] = {elementary::cos(i * kStep), elementary::sin(i * kStep)};
    return found;
  }();
  std::array<double, kScan> values;
  for (int i = 0; i < kScan; ++i) values[i] = energy.at(directions[i].x, directions[i].y);
  double best = 0.0, least = kInfinity;
  for (int i = 0; i < kScan; ++i) {
    if (!(values[i] <= values[(i + kScan - 1) % kScan] && values[i] <= values[(i + 1) % kScan])) continue;
    const double angle = descend_circle(energy, i * kStep, kStep), value = energy(angle);
    if (value < least) best = angle, least = value;
  }
  return wrapped(best);
}

/// Σ W, Σ W z, Σ W D by columns, Σ Dᵀ W D and Σ Dᵀ W z about an origin.
struct Sums {
  Symmetric s;
  Vector wz, wd_cos, wd_sin;
  Polynomial circle;
};

/// The first sum begins with `prior` information on the place, the last with `start`.
inline Sums sums_about(const Factors& factors, double x, double y, double prior, Vector start) {
  Sums t{{prior, 0.0, prior}, {0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, {{0.0, 0.0, 0.0}, start}};
  for (int k = 0; k < factors.people; ++k) {
    if (!factors.usable(k)) continue;
    const double *z = factors.relative + 2 * k, *p = factors.expected + 2 * k;
    const auto [rr, rf, ff] = information(factors.covariance + 3 * k, square(factors.std[k]));
    const double dx = p[0] - x, dy = p[1] - y;
    const double zr = rr * z[0] + rf * z[1], zf = rf * z[0] + ff * z[1];
    // D = [[−dy, dx], [dx, dy]], W D = [[rc, rs], [fc, fs]]
    const double rc = rf * dx - rr * dy, rs = rr * dx + rf * dy, fc = ff * dx - rf * dy, fs = rf * dx + ff * dy;
    t.s = {t.s.a + rr, t.s.b + rf, t.s.c + ff};
    t.wz = {t.wz.x + zr, t.wz.y + zf};
    t.wd_cos = {t.wd_cos.x + rc, t.wd_cos.y + fc};
    t.wd_sin = {t.wd_sin.x + rs, t.wd_sin.y + fs};
    auto& [a, g] = t.circle;
    a = {a.a + dx * fc - dy * rc, a.b + dx * fs - dy * rs, a.c + dx * rs + dy * fs};
    g = {g.x + dx * zf - dy * zr, g.y + dx * zr + dy * zf};
  }
  return t;
}

/// Information in 1/m² of the observer's motion prior on the place, at least `kVague`.
inline double walk_information(const Factors& factors) { return std::max(1.0 / square(factors.walk_std), kVague); }

/// The pose of least energy; `facing` in 1/rad² is the information on the predicted yaw, as 2(1 − cos d) for d².
inline Pose fit_pose(const Factors& factors, double facing) {
  const Pose& walk = factors.walk;
  const Sums t = sums_about(factors, walk[0], walk[1], walk_information(factors), {0.0, 0.0});
  const auto [rr, rf, ff] = t.s.inverse();
  const auto [rc, fc] = t.wd_cos;
  const auto [rs, fs] = t.wd_sin;
  const auto& [a, g] = t.circle;
  // A less (Σ W D)ᵀ S⁻¹ (Σ W D), g less (Σ W D)ᵀ S⁻¹ (Σ W z)
  const double c_r = rc * rr + fc * rf, c_f = rc * rf + fc * ff;
  const double s_r = rs * rr + fs * rf, s_f = rs * rf + fs * ff;
  const Polynomial energy{{a.a - c_r * rc - c_f * fc, a.b - c_r * rs - c_f * fs, a.c - s_r * rs - s_f * fs},
                          {g.x - (c_r * t.wz.x + c_f * t.wz.y) + facing * elementary::cos(walk[2]),
                           g.y - (s_r * t.wz.x + s_f * t.wz.y) + facing * elementary::sin(walk[2])}};
  const double yaw = least_angle(energy), sin = elementary::sin(yaw), cos = elementary::cos(yaw);
  const double off_r = t.wz.x - (rc * cos + rs * sin), off_f = t.wz.y - (fc * cos + fs * sin);
  const double q_r = rr * off_r + rf * off_f, q_f = rf * off_r + ff * off_f;
  return {walk[0] - sin * q_r - cos * q_f, walk[1] + cos * q_r - sin * q_f, yaw};
}

/// Positions [K, 2] in m of least energy given the pose, the same as a Kalman update; NaN = not observed.
///
///     Rᵀ(x_k − c) = e_k + σ_k² (σ_k² I + N_k)⁻¹ (z_k − e_k),   e_k = Rᵀ(p_k − c).
///
/// With N_k → 0 a person stands on its ray where its height says; without expectation the measurement is all there is.
inline void localise(const Pose& pose, const Factors& factors, double* positions) {
  const double sin = elementary::sin(pose[2]), cos = elementary::cos(pose[2]);
  for (int k = 0; k < factors.people; ++k) {
    double right = factors.relative[2 * k], forward = factors.relative[2 * k + 1];
    if (!std::isnan(factors.std[k])) {
      const double dx = factors.expected[2 * k] - pose[0], dy = factors.expected[2 * k + 1] - pose[1];
      const double e_r = dx * sin - dy * cos, e_f = dx * cos + dy * sin, v = square(factors.std[k]);
      const auto [rr, rf, ff] = information(factors.covariance + 3 * k, v);
      const double d_r = right - e_r, d_f = forward - e_f;
      right = e_r + v * (rr * d_r + rf * d_f);
      forward = e_f + v * (rf * d_r + ff * d_f);
    }
    positions[2 * k] = pose[0] + right * sin + forward * cos;
    positions[2 * k + 1] = pose[1] - right * cos + forward * sin;
  }
}

}  // namespace vbbench::cascade
