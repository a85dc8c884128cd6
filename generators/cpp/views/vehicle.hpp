// Visibility of people along a vehicle's paths.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "elementary.hpp"

namespace vbbench::views {

/// Limits of view and collision of a vehicle, and the people.
struct Limits {
  double left, right;         ///< azimuths in rad of the view's borders
  double horizon, clearance;  ///< farthest distance in m of a person in view, and nearest of one who is passed
};

struct People {
  std::int64_t frames, count;
  const double* places;  ///< [T, K, 2] in m, NaN = absent
  const bool* crowd;     ///< [T, K] people to be seen
};

/// Visibility along each of the paths [P, T, 3].
///
/// `runs` [P, 2] are the longest run of frames first ≤ t < last in which enough people are in view and nobody is in the
/// way, the first of several; `nearest` [P, T] is the distance in m of the nearest in view, or the horizon's.
inline void look_round(const People& people, std::int64_t ways, const double* poses, std::int64_t wanted,
                       const Limits& limits, std::int64_t* runs, double* nearest) {
  const auto [left, right, horizon, clearance] = limits;
  const bool all_around = right - left >= 2.0 * std::numbers::pi;
  const bool narrow = std::max(-left, right) < 0.5 * std::numbers::pi;
  const double reach = std::max(horizon, clearance), beyond = reach * reach;
  for (std::int64_t p = 0; p < ways; ++p, runs += 2) {
    runs[0] = runs[1] = 0;
    std::int64_t begun = 0;
    for (std::int64_t t = 0; t < people.frames; ++t, poses += 3, ++nearest) {
      const double sin = elementary::sin(poses[2]), cos = elementary::cos(poses[2]);
      std::int64_t seen = 0;
      bool clear = true;
      *nearest = horizon;
      for (std::int64_t n = t * people.count; n < (t + 1) * people.count; ++n) {
        const double east = people.places[2 * n] - poses[0], north = people.places[2 * n + 1] - poses[1];
        const double squared = east * east + north * north;
        if (!(squared < beyond)) continue;
        const double away = std::sqrt(squared);
        clear = clear && away >= clearance;
        if (!people.crowd[n] || !(away < horizon)) continue;
        const double aside = sin * east - cos * north, ahead = cos * east + sin * north;
        if (narrow && ahead <= 0.0) continue;
        const double azimuth = all_around ? 0.0 : elementary::atan2(aside, ahead);
        if (all_around || (left < azimuth && azimuth < right)) {
          ++seen;
          *nearest = std::min(*nearest, away);
        }
      }
      if (!clear || seen < wanted) {
        begun = t + 1;
      } else if (t + 1 - begun > runs[1] - runs[0]) {
        runs[0] = begun;
        runs[1] = t + 1;
      }
    }
  }
}

}  // namespace vbbench::views
