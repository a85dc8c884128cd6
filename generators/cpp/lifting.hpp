// Lifting heads to the ground: the smoother of tracks, and the normal equations of log walking speeds.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "elementary.hpp"

namespace vbbench::lifting {

constexpr double kFirstSpeedStd = 5.0;  ///< m/s, prior of a velocity

/// The Kalman filter and the smoother of Rauch, Tung and Striebel of one coordinate, driven by white acceleration.
class Smoother {
 public:
  /// `q`: density of acceleration in m²/s³; `dt`: seconds per frame.
  Smoother(double q, double dt) : q_(q), dt_(dt) {}

  /// A track of measured places and their noise variances, NaN = none; the first and the last are known.
  void smooth(std::int64_t count, const double* known, const double* noise, double* result) {
    filter(count, known, noise);
    double x = states_[count - 1].x, v = states_[count - 1].v;
    result[count - 1] = x;
    for (std::int64_t t = count - 2; t >= 0; --t) {
      const auto [m, w, pp, pv, vv] = states_[t];
      const double app = pp + dt_ * (2.0 * pv + dt_ * vv) + q_ * (dt_ * (dt_ * dt_)) / 3.0;
      const double apv = pv + dt_ * vv + q_ * (dt_ * dt_) / 2.0, avv = vv + q_ * dt_;
      const double determinant = app * avv - apv * apv, dx = x - (m + dt_ * w), dv = v - w;
      const double a = (avv * dx - apv * dv) / determinant, b = (app * dv - apv * dx) / determinant;
      x = m + (pp + dt_ * pv) * a + pv * b;
      v = w + (pv + dt_ * vv) * a + vv * b;
      result[t] = x;
    }
  }

 private:
  struct State {
    double x, v, pp, pv, vv;  ///< place, velocity and their covariances
  };

  void filter(std::int64_t count, const double* known, const double* noise) {
    states_.resize(static_cast<std::size_t>(count));
    State s{known[0], 0.0, noise[0], 0.0, kFirstSpeedStd * kFirstSpeedStd};
    for (std::int64_t t = 0; t < count; ++t) {
      if (t > 0) {
        s.x += dt_ * s.v;
        s.pp += dt_ * (2.0 * s.pv + dt_ * s.vv) + q_ * (dt_ * (dt_ * dt_)) / 3.0;
        s.pv += dt_ * s.vv + q_ * (dt_ * dt_) / 2.0;
        s.vv += q_ * dt_;
        if (!std::isnan(known[t])) {
          const double total = s.pp + noise[t], surprise = known[t] - s.x;
          s.x += s.pp / total * surprise;
          s.v += s.pv / total * surprise;
          s.vv -= s.pv * s.pv / total;
          s.pv *= noise[t] / total;
          s.pp *= noise[t] / total;
        }
      }
      states_[t] = s;
    }
  }

  double q_, dt_;
  std::vector<State> states_;
};

constexpr int kHarmonics = 6;
constexpr int kTerms = 2 * kHarmonics + 1;

/// Normal equations of the harmonics of log speeds; deviations of people are integrated out.
struct Normal {
  std::array<double, kTerms * kTerms> matrix{};
  std::array<double, kTerms> right{};
  double square = 0.0, log_determinant = 0.0;  ///< weighted sum of squares
};

/// Of segments in the order of their people: log speed, direction φ in rad, weight; `between`: variance of paces.
inline Normal whiten(std::int64_t count, const double* value, const double* phi, const double* weight,
                     const std::int64_t* person, double between) {
  Normal normal;
  std::array<double, kTerms> row{}, total{};
  double mass = 0.0, sums = 0.0;
  for (std::int64_t s = 0; s < count; ++s) {
    const double w = weight[s], cos1 = elementary::cos(phi[s]), sin1 = elementary::sin(phi[s]);
    double cos = 1.0, sin = 0.0;
    row[0] = 1.0;
    for (int n = 0; n < kHarmonics; ++n) {
      const double turned = cos * cos1 - sin * sin1;
      sin = sin * cos1 + cos * sin1;
      cos = turned;
      row[2 * n + 1] = cos;
      row[2 * n + 2] = sin;
    }
    for (int i = 0; i < kTerms; ++i) {
      normal.right[i] += w * row[i] * value[s];
      total[i] += w * row[i];
      for (int j = 0; j <= i; ++j) normal.matrix[kTerms * i + j] += w * row[i] * row[j];
    }
    normal.square += w * (value[s] * value[s]);
    normal.log_determinant -= elementary::log(w);
    mass += w;
    sums += w * value[s];
    if (s + 1 < count && person[s + 1] == person[s]) continue;
    const double shared = between / (1.0 + between * mass);
    for (int i = 0; i < kTerms; ++i) {
      normal.right[i] -= shared * total[i] * sums;
      for (int j = 0; j <= i; ++j) normal.matrix[kTerms * i + j] -= shared * total[i] * total[j];
    }
    normal.square -= shared * (sums * sums);
    normal.log_determinant += elementary::log(1.0 + between * mass);
    total.fill(0.0);
    mass = sums = 0.0;
  }
  for (int i = 0; i < kTerms; ++i)
    for (int j = 0; j < i; ++j) normal.matrix[kTerms * j + i] = normal.matrix[kTerms * i + j];
  return normal;
}

}  // namespace vbbench::lifting
