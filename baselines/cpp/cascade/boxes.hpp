// Measurements of boxes: places of people of known or uncertain height, and heights of people at known places.
#pragma once

#include <algorithm>
#include <cmath>

#include "ego_motion.hpp"
#include "elementary.hpp"

namespace vbbench::cascade {

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

}  // namespace vbbench::cascade
