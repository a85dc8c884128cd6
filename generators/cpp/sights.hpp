// Directions to feet and heads from a carried camera: tilted, at its own height, over uneven ground.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "elementary.hpp"

namespace vbbench::field {

constexpr double kFarthestEdge = 0.5;  ///< no body's near edge is nearer than this share of the way to its middle

/// Uneven ground: its height z(x, y) = Σ aᵢ sin(kᵢ·(x, y) + φᵢ).
struct Ground {
  std::int64_t waves;
  const double *amplitudes, *phases;  ///< [N] in m and rad
  const double* vectors;              ///< [N, 2] kᵢ in rad/m

  double at(const double* place) const {
    double height = 0.0;
    for (std::int64_t i = 0; i < waves; ++i)
      height += amplitudes[i] * elementary::sin(vectors[2 * i] * place[0] + vectors[2 * i + 1] * place[1] + phases[i]);
    return height;
  }
};

/// Poses and tilts of a camera in T frames, and K people.
struct Carriage {
  std::int64_t frames, people;
  const double* relative;   ///< [T, K, 2] (right, forward) of the camera, in m
  const double* positions;  ///< [T, K, 2] in m
  const double* poses;      ///< [T, 3] (x, y, yaw) of the camera
  const double* heights;    ///< [K] in m
  const double* mounts;     ///< [T] height in m over the ground below
  const double* tilt;       ///< [4, T] cosine and sine of pitch and of roll
  Ground ground;
  double near_edge;  ///< m
};

/// Directions [N, 2, 3] (right, down, forward) to feet and heads of the people `there` [N], counted through [T, K].
inline void sights(const Carriage& c, std::int64_t count, const std::int64_t* there, double* directions) {
  std::int64_t last = -1;
  double level = 0.0;
  for (std::int64_t n = 0; n < count; ++n) {
    const std::int64_t t = there[n] / c.people, k = there[n] % c.people;
    if (t != last) {
      last = t;
      level = c.mounts[t] + c.ground.at(c.poses + 3 * t);
    }
    double down = level - c.ground.at(c.positions + 2 * there[n]);
    const double right = c.relative[2 * there[n]], forward = c.relative[2 * there[n] + 1];
    const double share = std::max(1.0 - c.near_edge / elementary::hypot(right, forward), kFarthestEdge);
    const double cp = c.tilt[t], sp = c.tilt[c.frames + t];
    const double cr = c.tilt[2 * c.frames + t], sr = c.tilt[3 * c.frames + t];
    for (int end = 0; end < 2; ++end, directions += 3, down -= c.heights[k]) {
      const double across = cp * down + sp * share * forward;
      directions[0] = cr * share * right + sr * across;
      directions[1] = cr * across - sr * share * right;
      directions[2] = cp * share * forward - sp * down;
    }
  }
}

}  // namespace vbbench::field
