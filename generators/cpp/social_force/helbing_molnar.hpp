// Repulsion of Helbing & Molnár, Phys. Rev. E 51 (1995) 4282: elliptical potentials about people, round ones at walls.
//
// With r from j to i, s = speed of j times Δt and e the direction in which j wants to walk (eqs. 3 and 4 there):
//
//     V(b) = V0 exp(−b/σ),    2b = √((|r| + |r − s e|)² − s²),    f = −∇_r V
//
// f counts c times if −f lies outside the field of view of i: e_i·(−f) < |f| cos φ (eqs. 6 and 7).
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "basics.hpp"
#include "clones.hpp"

namespace vbbench::social_force {

constexpr double kForceError = 1e-8;  ///< m/s² that a person may miss because pairs too far apart are skipped
/// b in m is at least this; on the line that the other is about to walk the gradient has no direction.
constexpr double kSoftest = 1e-6;

/// Replaces the places x, y (m) of i as seen from j by −∇V (m/s²), given the strides s e of j (m).
VBBENCH_WIDE inline void helbing_molnar_pairs(int filled, double strength, double fall_off, double* __restrict x,
                                              double* __restrict y, const double* __restrict sx,
                                              const double* __restrict sy) {
  for (int n = 0; n < filled; ++n) {
    double near = std::sqrt(x[n] * x[n] + y[n] * y[n]);
    const double qx = x[n] - sx[n], qy = y[n] - sy[n];
    double far = std::sqrt(qx * qx + qy * qy);
    const double both = near + far, squared = both * both - (sx[n] * sx[n] + sy[n] * sy[n]);
    double b = 0.5 * std::sqrt(squared > 0.0 ? squared : 0.0);
    b = b > kSoftest ? b : kSoftest;
    near = near > kTiny ? near : kTiny;
    far = far > kTiny ? far : kTiny;
    const double slope = 0.25 * strength / fall_off * exp_negative(b * (-1.0 / fall_off)) * both / (b * near * far);
    x[n] = slope * (x[n] * far + qx * near);
    y[n] = slope * (y[n] * far + qy * near);
  }
}

/// Computes the gathered pairs and hands i the force, less of it where i does not see j.
inline void push(int filled, const People& people, const Settings& s, Pairs& pairs, Forces& forces) {
  double *const x = pairs.rows[0].data(), *const y = pairs.rows[1].data();
  helbing_molnar_pairs(filled, s.factor, s.fall_off, x, y, pairs.rows[2].data(), pairs.rows[3].data());
  for (int n = 0; n < filled; ++n) {
    const int i = pairs.of[n];
    const double fx = x[n], fy = y[n], facing = -(people.ahead_x[i] * fx + people.ahead_y[i] * fy);
    const double weight = facing >= std::sqrt(fx * fx + fy * fy) * s.view_cosine ? 1.0 : s.unseen_weight;
    forces.x[i] += weight * fx;
    forces.y[i] += weight * fy;
  }
}

/// Adds the force (m/s²) of everybody on i, for i = first, first + stride, …
inline void add_helbing_molnar(const People& people, int first, int stride, const Settings& s, Pairs& pairs,
                               Forces& forces) {
  const int count = people.count;
  std::vector<double> stride_x(count), stride_y(count);  // s e: what each person walks towards the current goal
  for (int k = 0; k < count; ++k) {
    const double length = std::sqrt(people.vx[k] * people.vx[k] + people.vy[k] * people.vy[k]) * s.stride_time;
    stride_x[k] = people.ahead_x[k] * length;
    stride_y[k] = people.ahead_y[k] * length;
  }
  // b² ≥ r·(r − s e); the gradient of b is at most (b + s)/b long, which the margin of 20 stands for.
  const double depth = std::log(std::max(20.0 * s.factor / s.fall_off * count / kForceError, 1.0));
  const double bound = (depth * s.fall_off) * (depth * s.fall_off);
  auto& [dx, dy, sx, sy] = pairs.rows;
  int filled = 0;
  for (int i = first; i < count; i += stride) {
    if (filled + count > pairs.room()) {
      push(filled, people, s, pairs, forces);
      filled = 0;
    }
    for (int j = 0; j < count; ++j) {  // those near enough to matter stay
      const double x = people.x[i] - people.x[j], y = people.y[i] - people.y[j];
      dx[filled] = x;
      dy[filled] = y;
      sx[filled] = stride_x[j];
      sy[filled] = stride_y[j];
      pairs.of[filled] = i;
      const bool near = x * (x - stride_x[j]) + y * (y - stride_y[j]) <= bound;
      filled += near & (j != i);
    }
  }
  push(filled, people, s, pairs, forces);
}

}  // namespace vbbench::social_force
