// Repulsion of Moussaïd et al., Proc. R. Soc. B 276 (2009) 2755, eqs. 4 to 6, in the signs of pysocialforce.
//
// Of two people i and j, with e the unit vector from j to i, d their distance and
//
//     D = λ (v_j − v_i) + e,    t = D/|D|,    θ the angle from e to t in (−π, π],    B = γ |D|,
//
// i feels A (exp(−d/B − (n'Bθ)²) t − sign(θ) exp(−d/B − (nBθ)²) t⊥), t⊥ being t turned left. Exchanging i and j turns D
// round and leaves θ as it is: j feels the opposite, and each pair is computed once.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "basics.hpp"
#include "clones.hpp"

namespace vbbench::social_force {

/// Replaces the places x, y (m) of i as seen from j by the force (m/s²) on i, given velocities of j less i (m/s).
///
/// With r = (x, y), D is taken times d, which needs no division: d D = λ d u + r, and tan(θ/2) = |λ r × u| / (|d D| +
/// d + λ r·u). Coinciding people have no e and feel nothing. Of three short loops the processor overlaps more
/// iterations than of a long one.
VBBENCH_WIDE inline void moussaid_pairs(int filled, const Settings& s, double* __restrict x, double* __restrict y,
                                        const double* __restrict ux, const double* __restrict uy) {
  constexpr int kAtOnce = 128;
  alignas(64) double cross[kAtOnce], dot[kAtOnce], ratio[kAtOnce], depth[kAtOnce], spread[kAtOnce];
  const double factor = s.factor, weight = s.velocity_weight, reach = s.reach;
  const double side = s.side_sharpness * s.side_sharpness, brake = s.brake_sharpness * s.brake_sharpness;
  for (int done = 0; done < filled; done += kAtOnce, x += kAtOnce, y += kAtOnce, ux += kAtOnce, uy += kAtOnce) {
    const int count = filled - done < kAtOnce ? filled - done : kAtOnce;
    for (int n = 0; n < count; ++n) {
      double distance = std::sqrt(x[n] * x[n] + y[n] * y[n]);
      distance = distance > kTiny ? distance : kTiny;
      const double ix = weight * distance * ux[n] + x[n], iy = weight * distance * uy[n] + y[n];
      double length = std::sqrt(ix * ix + iy * iy);
      length = length > kTiny ? length : kTiny;
      cross[n] = weight * (x[n] * uy[n] - y[n] * ux[n]);
      dot[n] = distance + weight * (x[n] * ux[n] + y[n] * uy[n]);
      const double around = length + std::abs(dot[n]);
      // One division gives all three inverses: divisions are what takes the time here.
      const double inverse = 1.0 / (distance * length * around), unit = inverse * distance * around;
      ratio[n] = std::abs(cross[n]) * (inverse * distance * length);
      spread[n] = reach * length * (inverse * length * around);
      depth[n] = distance * distance * unit * (-1.0 / reach);
      x[n] = ix * unit;
      y[n] = iy * unit;
    }
    for (int n = 0; n < count; ++n) {
      const double angle = 2.0 * atan_unit(ratio[n]),
                   wide = spread[n] * (dot[n] >= 0.0 ? angle : std::numbers::pi - angle);
      spread[n] = wide * wide;
    }
    for (int n = 0; n < count; ++n) {
      const double ahead = factor * exp_negative(depth[n] - brake * spread[n]);
      double aside = factor * exp_negative(depth[n] - side * spread[n]);
      aside = cross[n] > 0.0 ? aside : -aside;
      aside = cross[n] != 0.0 ? aside : 0.0;
      const double tx = x[n], ty = y[n];
      x[n] = ahead * tx + aside * ty;
      y[n] = ahead * ty - aside * tx;
    }
  }
}

/// Sum in a fixed order: four interleaved sums, which the processor can add at the same time.
inline double interleaved_sum(const double* values, int count) {
  std::array<double, 4> sums{};
  const int whole = count / 4 * 4;
  for (int n = 0; n < whole; n += 4)
    for (int lane = 0; lane < 4; ++lane) sums[lane] += values[n + lane];
  for (int n = whole; n < count; ++n) sums[0] += values[n];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/// Adds the forces of a row of pairs to i = start, start + stride, … < end, and the opposite to all j > i.
VBBENCH_WIDE inline void hand_out_rows(int start, int end, int stride, const Pairs& pairs, Forces& forces) {
  const int count = static_cast<int>(forces.x.size());
  for (int axis = 0; axis < 2; ++axis) {
    double* const felt = axis == 0 ? forces.x.data() : forces.y.data();
    const double* row = pairs.rows[axis].data();
    for (int i = start; i < end; i += stride) {
      const int others = count - i - 1;
      double* const of_others = felt + i + 1;
      for (int n = 0; n < others; ++n) of_others[n] -= row[n];
      felt[i] += interleaved_sum(row, others);
      row += others;
    }
  }
}

/// values[j] less or from that of i, for all j > i.
VBBENCH_WIDE inline void differences(const double* __restrict values, int i, int count, bool less,
                                     double* __restrict row) {
  const double own = values[i];
  const double* const others = values + i + 1;
  if (less) {
    for (int n = 0; n < count - i - 1; ++n) row[n] = own - others[n];
  } else {
    for (int n = 0; n < count - i - 1; ++n) row[n] = others[n] - own;
  }
}

/// Writes places of i less j (m) and velocities of j less i (m/s), for all j > i, from `filled` on.
inline void gather_row(const People& people, int i, int filled, Pairs& pairs) {
  differences(people.x, i, people.count, true, pairs.rows[0].data() + filled);
  differences(people.y, i, people.count, true, pairs.rows[1].data() + filled);
  differences(people.vx, i, people.count, false, pairs.rows[2].data() + filled);
  differences(people.vy, i, people.count, false, pairs.rows[3].data() + filled);
}

/// Adds the forces (m/s²) between i and all j > i, for i = first, first + stride, …
///
/// Rows of pairs are gathered until there is no more room, computed in one loop, and handed out in the order of
/// gathering.
inline void add_moussaid(const People& people, int first, int stride, const Settings& s, Pairs& pairs, Forces& forces) {
  int start = first, filled = 0;
  const auto compute = [&](int end) {
    moussaid_pairs(filled, s, pairs.rows[0].data(), pairs.rows[1].data(), pairs.rows[2].data(), pairs.rows[3].data());
    hand_out_rows(start, end, stride, pairs, forces);
  };
  for (int i = first; i < people.count; i += stride) {
    if (filled + people.count - i - 1 > pairs.room()) {
      compute(i);
      start = i;
      filled = 0;
    }
    gather_row(people, i, filled, pairs);
    filled += people.count - i - 1;
  }
  compute(people.count);
}

}  // namespace vbbench::social_force
