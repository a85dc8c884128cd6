// An extended Kalman filter of planar pose and velocities from wheels and gyro.
//
// The state is the pose (x, y, yaw) since frame 0, the motion (forward, left, turn) since the frame before, the speeds
// (v, ω), the gyro's bias b, and the wheels' slip, as shares s of the speed and k of the turning rate:
//
//     x' = x + v Δt cos(yaw + ωΔt/2),  y' = y + v Δt sin(yaw + ωΔt/2),  yaw' = yaw + ωΔt   (the motion likewise)
//     v, ω, b: random walks;   s, k: stationary Ornstein–Uhlenbeck processes of the correlation time τ
//     wheels: (1 + s) v and (1 + k) ω;   gyro: ω + b
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "elementary.hpp"

namespace vbbench::odometry {

constexpr int kSize = 11;
/// Indices in the state: x, y, yaw; forward, left, turn; v, ω, b, s, k.
constexpr int kMoved = 3, kV = 6, kW = 7, kBias = 8, kSlip = 9, kTurnSlip = 10;

/// Kinds of readings; a frame is a time at which pose and motion are reported.
enum Kind : std::int64_t { kSpeedReading, kTurnReading, kGyroReading, kFrame };

/// Standard deviations of the filter's model, for a robot with differential drive.
struct Noise {
  std::array<double, 3> readings{0.02, 0.03, 0.01};    ///< of speed, turn and gyro, in m/s, rad/s, rad/s
  double acceleration = 0.4, turn_acceleration = 1.0;  ///< random walks of v and ω, in m/s and rad/s after a second
  double sideways = 0.01;                              ///< lateral drift in m per metre of driving
  double bias = 0.02, bias_drift = 2e-4;               ///< of the gyro at first and after a second, in rad/s
  std::array<double, 2> slips{0.018, 0.1};             ///< shares of speed and turning rate
  double slip_seconds = 10.0, freedom = 4.0;           ///< τ, and ν of the Student-t error of a reading
};

using State = std::array<double, kSize>;
using Matrix = std::array<std::array<double, kSize>, kSize>;

class Filter {
 public:
  Filter() {
    spread_[kV][kV] = spread_[kW][kW] = 1.0;  // up to 1 m/s and 1 rad/s or so
    spread_[kBias][kBias] = noise_.bias * noise_.bias;
    spread_[kSlip][kSlip] = noise_.slips[0] * noise_.slips[0];
    spread_[kTurnSlip][kTurnSlip] = noise_.slips[1] * noise_.slips[1];
  }

  /// Moves the state `dt` seconds on; its covariance becomes F P Fᵀ + Q.
  void predict(double dt) {
    Matrix change{}, turned{};
    for (int a = 0; a < kSize; ++a) change[a][a] = 1.0;
    const double v = state_[kV], w = state_[kW], stays = elementary::exp(-dt / noise_.slip_seconds);
    for (int first = 0; first < kV; first += kMoved) {
      const double yaw = state_[first + 2] + 0.5 * w * dt, ahead = dt * elementary::cos(yaw),
                   aside = dt * elementary::sin(yaw);
      state_[first] += v * ahead;
      state_[first + 1] += v * aside;
      state_[first + 2] += w * dt;
      change[first][first + 2] = -v * aside;
      change[first + 1][first + 2] = v * ahead;
      change[first][kV] = ahead;
      change[first + 1][kV] = aside;
      change[first][kW] = -0.5 * v * dt * aside;
      change[first + 1][kW] = 0.5 * v * dt * ahead;
      change[first + 2][kW] = dt;
    }
    for (int slip = kSlip; slip < kSize; ++slip) {
      state_[slip] *= stays;
      change[slip][slip] = stays;
    }
    for (int a = 0; a < kSize; ++a)
      for (int b = 0; b < kSize; ++b) turned[a][b] = change[b][a];
    spread_ = product(product(change, spread_), turned);
    add_noise(dt, stays);
  }

  /// Updates the state with one reading; outliers have less weight.
  void update(Kind kind, double value) {
    const int rate = kind == kSpeedReading ? kV : kW;
    const int other = kind == kGyroReading ? kBias : kind == kSpeedReading ? kSlip : kTurnSlip;
    const double by_rate = kind == kGyroReading ? 1.0 : 1.0 + state_[other];
    const double by_other = kind == kGyroReading ? 1.0 : state_[rate];
    const double expected = kind == kGyroReading ? state_[kW] + state_[kBias] : by_rate * state_[rate];
    State gain;
    for (int a = 0; a < kSize; ++a) gain[a] = spread_[a][rate] * by_rate + spread_[a][other] * by_other;
    const double certain = gain[rate] * by_rate + gain[other] * by_other, off = value - expected;
    double variance = noise_.readings[kind] * noise_.readings[kind];
    variance *= std::max(1.0, (noise_.freedom + off * off / (certain + variance)) / (noise_.freedom + 1.0));
    for (int a = 0; a < kSize; ++a) {
      state_[a] += gain[a] / (certain + variance) * off;
      for (int b = 0; b < kSize; ++b) spread_[a][b] -= gain[a] * gain[b] / (certain + variance);
    }
  }

  /// Sets the pose (first = 0) or the motion (first = kMoved) to exactly 0.
  void begin_here(int first) {
    for (int a = first; a < first + kMoved; ++a) {
      state_[a] = 0.0;
      for (int b = 0; b < kSize; ++b) spread_[a][b] = spread_[b][a] = 0.0;
    }
  }

  /// Writes the pose or the motion [3] and its covariance [3, 3].
  void write(int first, double* mean, double* covariance) const {
    for (int a = 0; a < kMoved; ++a) {
      mean[a] = state_[first + a];
      for (int b = 0; b < kMoved; ++b) covariance[kMoved * a + b] = spread_[first + a][first + b];
    }
  }

 private:
  /// A matrix product with sums in one order on every machine.
  static Matrix product(const Matrix& first, const Matrix& second) {
    Matrix product{};
    for (int a = 0; a < kSize; ++a)
      for (int c = 0; c < kSize; ++c)
        for (int b = 0; b < kSize; ++b) product[a][b] += first[a][c] * second[c][b];
    return product;
  }

  /// Process noise Q: random walks of v, ω and b, the noise of the slips, and motion sideways, in pose and motion.
  void add_noise(double dt, double stays) {
    spread_[kV][kV] += noise_.acceleration * noise_.acceleration * dt;
    spread_[kW][kW] += noise_.turn_acceleration * noise_.turn_acceleration * dt;
    spread_[kBias][kBias] += noise_.bias_drift * noise_.bias_drift * dt;
    for (int slip = 0; slip < 2; ++slip)
      spread_[kSlip + slip][kSlip + slip] += noise_.slips[slip] * noise_.slips[slip] * (1.0 - stays * stays);
    State aside{};
    for (int first = 0; first < kV; first += kMoved) {
      aside[first] = elementary::sin(state_[first + 2]);
      aside[first + 1] = -elementary::cos(state_[first + 2]);
    }
    const double push = noise_.sideways * noise_.sideways * std::abs(state_[kV]) * dt;
    for (int a = 0; a < kSize; ++a)
      for (int b = 0; b < kSize; ++b) spread_[a][b] += push * aside[a] * aside[b];
  }

  const Noise noise_{};
  State state_{};
  Matrix spread_{};
};

/// Poses and motions of a robot at the readings that are frames.
struct Motion {
  double *poses, *covariances;  ///< [T, 3] and [T, 3, 3]
  double *motions, *spreads;    ///< the same since the frame before
};

/// Filters readings, ascending in time.
inline void filter(std::int64_t count, const double* times, const double* values, const std::int64_t* kinds,
                   const Motion& motion) {
  Filter filter;
  std::int64_t frame = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    if (i > 0 && times[i] > times[i - 1]) filter.predict(times[i] - times[i - 1]);
    if (kinds[i] != kFrame) {
      filter.update(static_cast<Kind>(kinds[i]), values[i]);
      continue;
    }
    if (frame == 0) filter.begin_here(0);
    filter.write(0, motion.poses + 3 * frame, motion.covariances + 9 * frame);
    filter.write(kMoved, motion.motions + 3 * frame, motion.spreads + 9 * frame);
    filter.begin_here(kMoved);
    ++frame;
  }
}

}  // namespace vbbench::odometry
