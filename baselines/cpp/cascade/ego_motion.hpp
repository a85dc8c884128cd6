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
#include <vector>

#include "elementary.hpp"
#include "factors.hpp"

namespace vbbench::cascade {

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

// Covariances of pose and positions: the inverse Gauss–Newton Hessian.
//
// With r_k = z_k + Rᵀ(c − p_k) as above and J_k = ∂r_k/∂(c, yaw), the pose has the covariance
//
//     Σ = (I/σ_0² + Σ_k J_kᵀ W_k J_k)⁻¹,   W_k = (σ_k² I + N_k)⁻¹ (I/σ_0² on the place only),
//
// where under a reweighted norm the σ² are divided by the weights. A person's position inherits the pose's error as far
// as it rests on the measurement: dx_k = R B_k Rᵀ (I, ∂x_k/∂yaw) dpose with B_k = σ_k² W_k, on top of
// P_k = σ_k² W_k N_k.

using Matrix3 = std::array<double, 9>;  ///< by rows

/// The inverse of a symmetric positive definite matrix, by LDLᵀ.
inline Matrix3 inverse(const Matrix3& m) {
  const double d0 = m[0], l10 = m[3] / d0, l20 = m[6] / d0;
  const double d1 = m[4] - l10 * m[3], l21 = (m[7] - l20 * m[3]) / d1;
  const double d2 = m[8] - l20 * m[6] - l21 * l21 * d1;
  const double i20 = l10 * l21 - l20;  // the lower corner of L⁻¹
  const double xt = i20 / d2, yt = -l21 / d2, tt = 1.0 / d2;
  const double yy = 1.0 / d1 - l21 * yt, xy = -l10 / d1 + i20 * yt, xx = 1.0 / d0 + l10 * l10 / d1 + i20 * xt;
  return {xx, xy, xt, xy, yy, yt, xt, yt, tt};
}

/// Gauss–Newton Hessian of ½ Σ rᵀWr by (x, y, yaw), without the observer's own terms.
inline Matrix3 hessian(const Pose& pose, const Factors& factors) {
  const double sin = elementary::sin(pose[2]), cos = elementary::cos(pose[2]);
  double xx = 0.0, xy = 0.0, yy = 0.0, xt = 0.0, yt = 0.0, tt = 0.0;
  for (int k = 0; k < factors.people; ++k) {
    if (!factors.usable(k)) continue;
    const auto [rr, rf, ff] = information(factors.covariance + 3 * k, square(factors.std[k]));
    const double x = factors.expected[2 * k] - pose[0], y = factors.expected[2 * k + 1] - pose[1];
    // The rows of J_k: (sin, −cos, −forward), (cos, sin, right) of where the person is expected.
    const double right = x * sin - y * cos, forward = x * cos + y * sin;
    const double first_r = rr * sin + rf * cos, first_f = rf * sin + ff * cos;
    const double second_r = rf * sin - rr * cos, second_f = ff * sin - rf * cos;
    xx += sin * first_r + cos * first_f;
    xy += sin * second_r + cos * second_f;
    yy += sin * second_f - cos * second_r;
    xt += right * first_f - forward * first_r;
    yt += right * second_f - forward * second_r;
    tt += forward * (rr * forward - rf * right) + right * (ff * right - rf * forward);
  }
  return {xx, xy, xt, xy, yy, yt, xt, yt, tt};
}

/// Covariance [3, 3] of the pose that `fit_pose` found with this information on the yaw.
inline Matrix3 pose_covariance(const Pose& pose, const Factors& factors, double facing) {
  const double prior = walk_information(factors);
  Matrix3 found = hessian(pose, factors);
  found[0] += prior;
  found[4] += prior;
  found[8] += facing;
  return inverse(found);
}

/// Covariances [K, 2, 2] of places in the world by `sigma` [3, 3] of the pose; NaN for people not observed.
inline void position_covariances(const Pose& pose, const double* sigma, const Factors& factors, double* spread) {
  const double sin = elementary::sin(pose[2]), cos = elementary::cos(pose[2]);
  const auto product = [sigma](double a, double b, double c, double d, double e, double f) {
    const double x = a * sigma[0] + b * sigma[3] + c * sigma[6];
    const double y = a * sigma[1] + b * sigma[4] + c * sigma[7];
    const double z = a * sigma[2] + b * sigma[5] + c * sigma[8];
    return x * d + y * e + z * f;
  };
  for (int k = 0; k < factors.people; ++k) {
    const double* noise = factors.covariance + 3 * k;
    const double n_rr = noise[0], n_rf = noise[1], n_ff = noise[2];
    Symmetric share{1.0, 0.0, 1.0};  // B: the measurement alone, where there is no prediction
    if (!std::isnan(factors.std[k])) {
      const double v = square(factors.std[k]);
      const Symmetric w = information(noise, v);
      share = {v * w.a, v * w.b, v * w.c};
    }
    const auto [rr, rf, ff] = share;
    const double right = factors.relative[2 * k], forward = factors.relative[2 * k + 1];
    // Rows of B·∂(Rᵀ(c + R z))/∂(c, yaw)
    const double a = rr * sin + rf * cos, b = rf * sin - rr * cos, c = rf * right - rr * forward;
    const double d = rf * sin + ff * cos, e = ff * sin - rf * cos, f = ff * right - rf * forward;
    const double p_rr = rr * n_rr + rf * n_rf + product(a, b, c, a, b, c);
    const double p_rf = rr * n_rf + rf * n_ff + product(a, b, c, d, e, f);
    const double p_ff = rf * n_rf + ff * n_ff + product(d, e, f, d, e, f);
    double* found = spread + 4 * k;
    found[0] = sin * sin * p_rr + 2.0 * sin * cos * p_rf + cos * cos * p_ff;
    found[1] = found[2] = sin * cos * (p_ff - p_rr) + (sin * sin - cos * cos) * p_rf;
    found[3] = cos * cos * p_rr - 2.0 * sin * cos * p_rf + sin * sin * p_ff;
  }
}

// How the energy rises away from its minimum: −ln p of the observer's pose. The energy E_c above,
// at a pose (c, R), each person minimised out, is
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

}  // namespace vbbench::cascade
