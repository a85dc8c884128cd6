// The terms of a frame's energy: where people are measured by their boxes, and where people and observer are expected.
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

/// The terms of a frame's energy, see `vbbench_baselines.cascade.Factors`: arrays [K, 2], [K, 3], [K, 2], [K] and the
/// observer's pose.
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

// Measurements of boxes: places of people of known or uncertain height, and heights of people at known places.

/// Boxes as rays, see `vbbench_baselines.common.bearings.Sightings`: [K, 2], [K, 2] and [K].
struct Sightings {
  const double *rays, *sideways, *stretch;
};

/// Means [K, 2] in m and covariances [K, 3] in m² of places, by heights and their variances [K].
inline void measure(const Sightings& sightings, const double* heights, const double* variances, int people,
                    double* relative, double* covariance) {
  for (int k = 0; k < people; ++k) {
    const double height = heights[k], across = square(height);
    const double along = variances[k] + square(height * sightings.stretch[k]);
    const double r = sightings.rays[2 * k], f = sightings.rays[2 * k + 1];
    const double dr = sightings.sideways[2 * k], df = sightings.sideways[2 * k + 1];
    relative[2 * k] = height * r;
    relative[2 * k + 1] = height * f;
    covariance[3 * k] = along * r * r + across * dr * dr;
    covariance[3 * k + 1] = along * r * f + across * dr * df;
    covariance[3 * k + 2] = along * f * f + across * df * df;
  }
}

/// Normal posteriors of heights [K], sharpened by people whose places [K, 2] are known to within `spread` [K].
struct Heights {
  double *mean, *variance;

  /// `pose_std` in m is the error of distances from the pose; the mean is kept within the limits.
  void learn(const Pose& pose, const double* positions, const double* spread, const Sightings& sightings, int people,
             double pose_std, double lowest, double highest) const {
    constexpr double kFloor = 1e-5;  // m, least standard deviation of one frame: exact data must not divide by zero
    const double sin = elementary::sin(pose[2]), cos = elementary::cos(pose[2]);
    for (int k = 0; k < people; ++k) {
      const double stretch = sightings.stretch[k];
      if (std::isnan(spread[k] + stretch)) continue;
      const double *ray = sightings.rays + 2 * k, *sideways = sightings.sideways + 2 * k;
      const double dx = positions[2 * k] - pose[0], dy = positions[2 * k + 1] - pose[1];
      const double right = dx * sin - dy * cos, forward = dx * cos + dy * sin;
      const double squared = square(ray[0]) + square(ray[1]);
      const double height = (right * ray[0] + forward * ray[1]) / squared;
      const double slip = (ray[0] * sideways[0] + ray[1] * sideways[1]) / squared;
      const double noise = square(height) * (square(stretch) + square(slip)) +
                           (square(pose_std) + square(spread[k])) / squared + square(kFloor);
      const double gain = variance[k] / (variance[k] + noise);
      mean[k] = std::min(std::max(mean[k] + gain * (height - mean[k]), lowest), highest);
      variance[k] *= 1.0 - gain;
    }
  }
};

// Predictions of people and observer at constant velocity, and the social force that aligns them.

constexpr double kAnchorStd = 1e-3;  ///< m, of a position given at t itself

/// Standard deviations in m of walks, see `vbbench_baselines.common.motion.Spreads`.
struct Spreads {
  double motion, stay, estimate, reach;

  /// Standard deviation about 2x' − x'', by whether the two past places were given or are estimates.
  double total(bool before_given, bool last_given) const {
    const double estimates = (last_given ? 0.0 : 4.0) + (before_given ? 0.0 : 1.0);
    return std::sqrt(square(motion) + estimates * square(estimate));
  }
};

/// Expected places [K, 2] and their standard deviations [K], by positions [3, K, 2] and whether they were given [3, K].
inline void continue_people(const double* positions, const bool* given, int people, const Spreads& spreads, double kept,
                            double* expected, double* std) {
  for (int k = 0; k < people; ++k) {
    const double *before = positions + 2 * k, *last = before + 2 * people, *now = last + 2 * people;
    double x = NAN, y = NAN, deviation = NAN;
    if (!std::isnan(now[0])) {
      x = now[0], y = now[1], deviation = kAnchorStd;
    } else if (std::isnan(last[0])) {
      if (!std::isnan(before[0])) x = before[0], y = before[1], deviation = 2.0 * spreads.stay;
    } else if (std::isnan(before[0]) || elementary::hypot(last[0] - before[0], last[1] - before[1]) > spreads.reach) {
      x = last[0], y = last[1], deviation = spreads.stay;
    } else {
      x = (1.0 + kept) * last[0] - kept * before[0];
      y = (1.0 + kept) * last[1] - kept * before[1];
      deviation = spreads.total(given[k], given[people + k]);
    }
    expected[2 * k] = x, expected[2 * k + 1] = y, std[k] = deviation;
  }
}

/// The observer's expected pose by poses [3, 3], its yaw held; no known pose at all: the world's origin.
inline Pose continue_observer(const double* poses, double kept) {
  Pose pose;
  for (int i = 0; i < 3; ++i) {
    const double before = poses[i], last = poses[3 + i];
    pose[i] = last;
    if (std::isnan(last))
      pose[i] = std::isnan(before) ? 0.0 : before;
    else if (i < 2 && !std::isnan(before))
      pose[i] += kept * (last - before);
  }
  return pose;
}

/// Changes of velocity [K, 2] = rate·(w_k − v_k), w_k the mean velocity of everyone within `radius`, k included.
///
/// People of unknown velocity (NaN) do not count and do not change; above a rate of 1 the mean would be overshot.
inline void adapt_velocities(const double* positions, const double* velocities, int people, double radius, double rate,
                             double* change) {
  const double share = std::min(rate, 1.0);
  for (int k = 0; k < people; ++k) {
    change[2 * k] = change[2 * k + 1] = 0.0;
    if (std::isnan(velocities[2 * k])) continue;
    double total_x = 0.0, total_y = 0.0, count = 0.0;
    for (int i = 0; i < people; ++i) {
      const double dx = positions[2 * i] - positions[2 * k];
      if (!(std::abs(dx) < radius)) continue;  // avoids most square roots in a large crowd
      const bool near = elementary::hypot(dx, positions[2 * i + 1] - positions[2 * k + 1]) < radius;
      if (!near || std::isnan(velocities[2 * i])) continue;
      total_x += velocities[2 * i], total_y += velocities[2 * i + 1], count += 1.0;
    }
    change[2 * k] = share * (total_x / count - velocities[2 * k]);
    change[2 * k + 1] = share * (total_y / count - velocities[2 * k + 1]);
  }
}

}  // namespace vbbench::cascade
