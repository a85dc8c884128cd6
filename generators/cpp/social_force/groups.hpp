// Forces within groups, as pysocialforce has them (coherence and gaze in its "alternative" form).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "basics.hpp"
#include "elementary.hpp"

namespace vbbench::social_force {

/// Force on i towards the centre x, y, which rises smoothly beyond the distance `radius`.
inline void cohere(const People& people, std::int64_t i, double x, double y, double radius, double factor,
                   Forces& forces) {
  const double dx = x - people.x[i], dy = y - people.y[i];
  const double distance = std::sqrt(dx * dx + dy * dy);
  const double pull = factor * 0.5 * (elementary::tanh(distance - radius) + 1.0);
  forces.x[i] += pull * dx;
  forces.y[i] += pull * dy;
}

/// Force on i towards the goal, by how far the others' centre lies ahead relative to the goal's distance.
///
/// x, y are sums over the group. The goal counts as 0.5 m away where it is nearer.
inline void gaze(const People& people, std::int64_t i, double x, double y, double size, double factor, Forces& forces) {
  const double dx = (x - people.x[i]) / (size - 1.0) - people.x[i];
  const double dy = (y - people.y[i]) / (size - 1.0) - people.y[i];
  const double distance = std::max(people.distance[i], 0.5);
  const double push = factor * (dx * people.ahead_x[i] + dy * people.ahead_y[i]) / distance;
  forces.x[i] += push * people.ahead_x[i];
  forces.y[i] += push * people.ahead_y[i];
}

/// Adds the forces (m/s²) within a group, whose people are `members`.
inline void add_group_forces(const People& people, std::span<const std::int64_t> members, const Settings& s,
                             Forces& forces) {
  const double size = static_cast<double>(members.size());
  if (members.size() < 2) return;
  double x = 0.0, y = 0.0;
  for (const std::int64_t i : members) {
    x += people.x[i];
    y += people.y[i];
  }
  for (const std::int64_t i : members) {
    cohere(people, i, x / size, y / size, (size - 1.0) / 2.0, s.cohesion, forces);
    gaze(people, i, x, y, size, s.gaze, forces);
    for (const std::int64_t j : members) {  // repulsion proportional to the distance
      const double dx = people.x[i] - people.x[j], dy = people.y[i] - people.y[j];
      if (std::sqrt(dx * dx + dy * dy) > s.personal_space) continue;
      forces.x[i] += s.separation * dx;
      forces.y[i] += s.separation * dy;
    }
  }
}

}  // namespace vbbench::social_force
