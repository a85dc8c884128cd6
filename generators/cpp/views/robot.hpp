// A robot with differential drive that follows a person.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "elementary.hpp"

namespace vbbench::views {

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
