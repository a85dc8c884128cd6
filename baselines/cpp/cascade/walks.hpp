// Predictions of people and observer at constant velocity, and the social force that aligns them.
#pragma once

#include <algorithm>
#include <cmath>

#include "ego_motion.hpp"
#include "elementary.hpp"

namespace vbbench::cascade {

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
