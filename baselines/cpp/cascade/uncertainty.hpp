// Covariances of pose and positions: the inverse Gauss–Newton Hessian.
//
// With r_k = z_k + Rᵀ(c − p_k) as in `ego_motion.hpp` and J_k = ∂r_k/∂(c, yaw), the pose has the covariance
//
//     Σ = (I/σ_0² + Σ_k J_kᵀ W_k J_k)⁻¹,   W_k = (σ_k² I + N_k)⁻¹ (I/σ_0² on the place only),
//
// where under a reweighted norm the σ² are divided by the weights. A person's position inherits the pose's error as far
// as it rests on the measurement: dx_k = R B_k Rᵀ (I, ∂x_k/∂yaw) dpose with B_k = σ_k² W_k, on top of
// P_k = σ_k² W_k N_k.
#pragma once

#include <cmath>

#include "ego_motion.hpp"
#include "elementary.hpp"

namespace vbbench::cascade {

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

}  // namespace vbbench::cascade
