// Forces of walls, which are line segments.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "basics.hpp"
#include "clones.hpp"

namespace vbbench::social_force {

constexpr double kSamplesPerMetre = 10.0;

struct Wall {
  double x0, y0, x1, y1;
};

using Vector = std::array<double, 2>;

/// Replaces places (m) of points of a wall by their forces (m/s²), without branches.
VBBENCH_WIDE inline void wall_pushes(int filled, double radius, double fall_off, double reach, double* __restrict dx,
                                     double* __restrict dy) {
  for (int n = 0; n < filled; ++n) {
    const double distance = std::sqrt(dx[n] * dx[n] + dy[n] * dy[n]), gap = distance - radius;
    double decay = exp_negative(-std::abs(gap) / fall_off);
    decay = gap >= 0.0 ? decay : 1.0 / decay;
    double push = decay / (distance > kTiny ? distance : kTiny);
    push = gap < reach ? push : 0.0;
    dx[n] *= push;
    dy[n] *= push;
  }
}

/// The part of a segment, as fractions of it, within `reach` of x, y as seen from its start; (1, −1) if none.
inline Vector within_reach(double x, double y, double ax, double ay, double length, double reach) {
  if (length == 0.0) return {0.0, 1.0};
  const double along = (x * ax + y * ay) / length, across = (x * ay - y * ax) / length;
  const double squared = reach * reach - across * across;
  if (squared < 0.0) return {1.0, -1.0};
  const double half = std::sqrt(squared), first = (along - half) / length, last = (along + half) / length;
  if (first <= 1.0 && last >= 0.0) return {std::max(first, 0.0), std::min(last, 1.0)};
  return {1.0, -1.0};
}

/// Force (m/s²) on a person at x, y (m) of one wall as pysocialforce has it.
///
/// int(10 · length) points evenly spread from end to end repel with exp(−(d − body radius)/fall-off) each. Walls too
/// short for two points have two, at their ends.
inline Vector sampled_wall(double x, double y, const Wall& wall, const Settings& s) {
  constexpr int kAtOnce = 256;
  const double ax = wall.x1 - wall.x0, ay = wall.y1 - wall.y0, length = std::sqrt(ax * ax + ay * ay);
  const std::int64_t count = std::max<std::int64_t>(static_cast<std::int64_t>(length * kSamplesPerMetre), 2);
  const double step = 1.0 / static_cast<double>(count - 1);
  const double from_x = x - wall.x0, from_y = y - wall.y0, step_x = ax * step, step_y = ay * step;
  const auto [first, last] = within_reach(from_x, from_y, ax, ay, length, s.wall_reach + s.body_radius);
  const std::int64_t start = std::max<std::int64_t>(static_cast<std::int64_t>(first / step) - 1, 0);
  const std::int64_t end = std::min(static_cast<std::int64_t>(last / step) + 2, count);
  std::array<double, kAtOnce> dx, dy;
  double fx = 0.0, fy = 0.0;
  for (std::int64_t k = start; k < end; k += kAtOnce) {
    const int filled = static_cast<int>(std::min<std::int64_t>(end - k, kAtOnce));
    for (int n = 0; n < filled; ++n) {
      dx[n] = from_x - static_cast<double>(k + n) * step_x;
      dy[n] = from_y - static_cast<double>(k + n) * step_y;
    }
    wall_pushes(filled, s.body_radius, s.wall_fall_off, s.wall_reach, dx.data(), dy.data());
    for (int n = 0; n < filled; ++n) {
      fx += dx[n];
      fy += dy[n];
    }
  }
  return {s.wall_factor * fx, s.wall_factor * fy};
}

}  // namespace vbbench::social_force
