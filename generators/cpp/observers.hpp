// How vehicles and robots move among people, and how heads turn.
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

struct Drive {
  double top_speed, acceleration;  ///< m/s and m/s²
  double turn_rate, turn_time;     ///< rad/s, and s within which it turns to the goal's direction
  double lead;                     ///< s by which goals are ahead
  double step;                     ///< s
};

/// An angle in rad brought to [−π, π).
inline double wrapped(double angle) {
  const double turn = 2.0 * std::numbers::pi, rest = std::fmod(angle + std::numbers::pi, turn);
  return (rest < 0.0 ? rest + turn : rest) - std::numbers::pi;
}

/// Place x, y in m, yaw in rad, speed and turning rate at each of the steps, into way [N, 5], towards goals [N, 2].
inline void steer(std::int64_t steps, const double* goals, const double* start, const Drive& d, double* way) {
  double x = start[0], y = start[1], speed = 0.0;
  double yaw = steps > 0 ? elementary::atan2(goals[1] - y, goals[0] - x) : 0.0;
  for (std::int64_t n = 0; n < steps; ++n, goals += 2, way += 5) {
    const double dx = goals[0] - x, dy = goals[1] - y, aside = wrapped(elementary::atan2(dy, dx) - yaw);
    const double reach = elementary::hypot(dx, dy);
    const double wanted = std::min(reach / d.lead, d.top_speed) * std::max(elementary::cos(aside), 0.0);
    speed += std::min(std::max(wanted - speed, -d.acceleration * d.step), d.acceleration * d.step);
    const double near = std::min(reach / (0.2 * d.lead), 1.0);  // a goal at its feet lies in no direction
    const double turn = near * std::min(std::max(aside / d.turn_time, -d.turn_rate), d.turn_rate);
    way[0] = x;
    way[1] = y;
    way[2] = yaw;
    way[3] = speed;
    way[4] = turn;
    const double middle = yaw + 0.5 * turn * d.step;
    x += speed * elementary::cos(middle) * d.step;
    y += speed * elementary::sin(middle) * d.step;
    yaw += turn * d.step;
  }
}

/// Yaws [n] that follow a course [n] by at most so many rad a step.
inline void turn_towards(std::int64_t count, const double* course, double most, double* yaws) {
  if (count > 0) yaws[0] = course[0];
  for (std::int64_t t = 1; t < count; ++t) {
    const double off = course[t] - yaws[t - 1], wanted = elementary::atan2(elementary::sin(off), elementary::cos(off));
    yaws[t] = yaws[t - 1] + std::min(std::max(wanted, -most), most);
  }
}

}  // namespace vbbench::views
