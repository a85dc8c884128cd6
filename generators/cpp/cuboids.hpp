// Boxes around projected cuboids, by a pinhole or an upright cylinder.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "elementary.hpp"

namespace vbbench::cuboids {

/// A camera whose axes are right, down and forward; its intrinsics in px.
struct Projection {
  double fx, fy, cx, cy;  ///< of a cylinder fx is px per rad, cx the column straight ahead
  bool cylinder;
  double behind;  ///< a corner less than so many m in front of a pinhole has no place in its picture
};

/// N cuboids in the world, and the camera's axes and origin in each of T frames: p in the camera is turn · p + shift.
struct Scene {
  std::int64_t count;
  const std::int64_t* frame;                  ///< [N]
  const double *centres, *rotations, *sizes;  ///< [N, 3] m, [N, 3, 3] and [N, 3] m
  const double *turns, *shifts;               ///< [T, 3, 3] and [T, 3] m
};

struct Box {
  double left, top, right, bottom;
};

/// The box around the corners centre ± a₀ ± a₁ ± a₂; columns of a cylinder are counted from that of the centre on.
inline Box around(const double* centre, const double (&axes)[3][3], const Projection& camera) {
  constexpr double far = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
  Box box{far, far, -far, -far};
  for (int corner = 0; corner < 8; ++corner) {
    double p[3];
    for (int i = 0; i < 3; ++i)
      p[i] = centre[i] + (corner & 1 ? axes[i][0] : -axes[i][0]) + (corner & 2 ? axes[i][1] : -axes[i][1]) +
             (corner & 4 ? axes[i][2] : -axes[i][2]);
    if (!camera.cylinder && !(p[2] >= camera.behind)) return {none, none, none, none};
    const double reach = camera.cylinder ? std::sqrt(p[0] * p[0] + p[2] * p[2]) : p[2];
    const double across =
        camera.cylinder ? elementary::atan2(p[0] * centre[2] - p[2] * centre[0], p[0] * centre[0] + p[2] * centre[2])
                        : p[0] / reach;
    const double u = camera.fx * across, v = camera.cy + camera.fy * p[1] / reach;
    box = {std::min(box.left, u), std::min(box.top, v), std::max(box.right, u), std::max(box.bottom, v)};
  }
  const double middle = camera.cx + (camera.cylinder ? camera.fx * elementary::atan2(centre[0], centre[2]) : 0.0);
  return {box.left + middle, box.top, box.right + middle, box.bottom};
}

/// Boxes [N] of cuboids, NaN where a corner is behind a pinhole.
inline void project(const Scene& scene, const Projection& camera, Box* boxes) {
  for (std::int64_t n = 0; n < scene.count; ++n) {
    const double* turn = scene.turns + 9 * scene.frame[n];
    const double* shift = scene.shifts + 3 * scene.frame[n];
    const double *world = scene.centres + 3 * n, *rotation = scene.rotations + 9 * n, *size = scene.sizes + 3 * n;
    double centre[3], axes[3][3];
    for (int i = 0; i < 3; ++i) {
      const double* row = turn + 3 * i;
      centre[i] = row[0] * world[0] + row[1] * world[1] + row[2] * world[2] + shift[i];
      for (int j = 0; j < 3; ++j)
        axes[i][j] = 0.5 * size[j] * (row[0] * rotation[j] + row[1] * rotation[3 + j] + row[2] * rotation[6 + j]);
    }
    boxes[n] = around(centre, axes, camera);
  }
}

}  // namespace vbbench::cuboids
