// The social force model: repulsion between people and of walls, and a crowd step by step.
//
// Exponential and arc tangent are made of additions and multiplications. Calls of the C library would keep loops
// scalar, and its last digits differ between machines. Polynomials are written in pairs of terms, which the processor
// computes at the same time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "clones.hpp"

namespace vbbench::social_force {

constexpr int kPairs = 1024;          ///< pairs computed at a time: few enough for the processor's first cache
constexpr double kTiny = 1e-60;       ///< stands in for a length of 0 m that divides; its cube is still a number
constexpr double kUnderflow = -32.0;  ///< exponents below it are raised to it: exp(−32) is 1e−14

/// The numbers of a model; lengths in m, times in s.
struct Settings {
  double relaxation_time, top_speed, arrival_radius, stop_radius;
  double factor, velocity_weight, reach, side_sharpness, brake_sharpness;
  double wall_factor, wall_fall_off, wall_reach, body_radius;
};

/// K people: place (m), velocity (m/s), unit vector to the current goal, and distance (m) from it.
struct People {
  static constexpr int kRows = 7;
  double *x, *y, *vx, *vy, *ahead_x, *ahead_y, *distance;
  int count;

  /// On rows [7, K].
  People(double* rows, int people)
      : x(rows),
        y(rows + people),
        vx(rows + 2 * people),
        vy(rows + 3 * people),
        ahead_x(rows + 4 * people),
        ahead_y(rows + 5 * people),
        distance(rows + 6 * people),
        count(people) {}
};

/// Forces in m/s² on K people.
struct Forces {
  std::vector<double> x, y;
  explicit Forces(int people) : x(people), y(people) {}
};

/// Pairs that are gathered before they are computed in one loop: four numbers and the two indices of each.
struct Pairs {
  std::array<std::vector<double>, 4> rows;
  std::vector<int> of;
  explicit Pairs(int people) : of(people > kPairs ? people : kPairs) {
    for (auto& row : rows) row.resize(of.size());
  }
  int room() const { return static_cast<int>(of.size()); }
};

/// exp(x) of x ≤ 0 to within 5e−13: Taylor's series of exp(x/256), squared eight times.
inline double exp_negative(double x) {
  const double y = (x > kUnderflow ? x : kUnderflow) * (1.0 / 256.0), z = y * y;
  double e = (1.0 + y) + z * ((0.5 + y * (1.0 / 6.0)) + z * (1.0 / 24.0 + y * (1.0 / 120.0)));
  for (int n = 0; n < 8; ++n) e *= e;
  return e;
}

/// atan(r) of 0 ≤ r ≤ 1 to within 6e−12: atan(r)/r interpolated in r² at Chebyshev's points, degree 12.
inline double atan_unit(double r) {
  const double u = r * r, v = u * u, w = v * v;
  const double low = (0.999999999988737 - u * 0.33333332951665584) + v * (0.19999978337002625 - u * 0.1428522562534094);
  const double mid =
      (0.11105306907877154 - u * 0.09049180114773321) + v * (0.07495266091119122 - u * 0.06022205218890623);
  const double top =
      (0.043646729133535726 - u * 0.02600614172204219) + v * (0.011427729645781124 - u * 0.003195461834616629);
  return r * ((low + w * mid) + w * w * (top + w * 0.00041923393867625194));
}

// Repulsion of Moussaïd et al., Proc. R. Soc. B 276 (2009) 2755, eqs. 4 to 6, in the signs of pysocialforce.
//
// Of two people i and j, with e the unit vector from j to i, d their distance and
//
//     D = λ (v_j − v_i) + e,    t = D/|D|,    θ the angle from e to t in (−π, π],    B = γ |D|,
//
// i feels A (exp(−d/B − (n'Bθ)²) t − sign(θ) exp(−d/B − (nBθ)²) t⊥), t⊥ being t turned left. Exchanging i and j turns D
// round and leaves θ as it is: j feels the opposite, and each pair is computed once.

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

// Walls, which are line segments.

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

// The crowd: goals, forces, and the semi-implicit integration v += F·Δt, x += v·Δt.

constexpr double kBrakeRadius = 0.2;  ///< m from the goal at which a person brakes, as in pysocialforce
/// From so many people on, forces are summed in blocks of people, and the blocks in order: this fixes their last bits.
constexpr int kLarge = 256, kBlocks = 16;

/// A crowd of K people, and the parameters of its simulation.
struct Crowd {
  int people = 0;
  std::int64_t goals_each = 0;     ///< G
  const double* states = nullptr;  ///< [4, K] x, y, vx, vy in m and m/s
  const double* speeds = nullptr;  ///< [K] desired, in m/s
  const double* goals = nullptr;   ///< [K, G, 2] in m
  std::span<const Wall> walls;
  Settings settings;
  double dt = 0.0;  ///< seconds per frame
  int substeps = 1;
};

/// Adds repulsion and walls for the people first, first + stride, … in m/s².
inline void add_row_forces(const People& people, int first, int stride, std::span<const Wall> walls, const Settings& s,
                           Pairs& pairs, Forces& forces) {
  add_moussaid(people, first, stride, s, pairs, forces);
  for (int k = first; k < people.count; k += stride) {
    for (const Wall& wall : walls) {
      const auto [fx, fy] = sampled_wall(people.x[k], people.y[k], wall, s);
      forces.x[k] += fx;
      forces.y[k] += fy;
    }
  }
}

/// The state of a crowd during its simulation.
class Walk {
 public:
  explicit Walk(const Crowd& crowd)
      : crowd_(crowd),
        rows_(People::kRows * crowd.people),
        people_(rows_.data(), crowd.people),
        current_(crowd.people) {
    std::copy_n(crowd.states, 4 * crowd.people, rows_.data());
  }

  const People& people() const { return people_; }

  /// Assigns the next goal to people who have arrived, and computes direction and distance of goals.
  void aim() {
    for (int k = 0; k < people_.count; ++k) {
      const double* own = crowd_.goals + 2 * k * crowd_.goals_each;
      double dx, dy, distance;
      for (;; ++current_[k]) {
        dx = own[2 * current_[k]] - people_.x[k];
        dy = own[2 * current_[k] + 1] - people_.y[k];
        distance = std::sqrt(dx * dx + dy * dy);
        if (distance > crowd_.settings.arrival_radius || current_[k] == crowd_.goals_each - 1) break;
      }
      people_.distance[k] = distance;
      people_.ahead_x[k] = distance > 0.0 ? dx / distance : 0.0;
      people_.ahead_y[k] = distance > 0.0 ? dy / distance : 0.0;
    }
  }

  /// Takes a step, given the `forces` of all but the goals.
  void move(const Forces& forces) {
    const double step = crowd_.dt / crowd_.substeps;
    for (int k = 0; k < people_.count; ++k) step_of(k, forces.x[k], forces.y[k], step);
  }

  /// Writes everybody's place into the row [K, 2] of a frame.
  void record(double* places) const {
    for (int k = 0; k < people_.count; ++k) {
      places[2 * k] = people_.x[k];
      places[2 * k + 1] = people_.y[k];
    }
  }

 private:
  /// The desired force is (speed · e − v)/τ, −v/τ at the goal; the speed is capped; who has arrived stands still.
  void step_of(int k, double fx, double fy, double step) {
    const Settings& s = crowd_.settings;
    const double desired = crowd_.speeds[k], distance = people_.distance[k];
    const double wish = distance > kBrakeRadius ? desired : 0.0;
    const double ax = (wish * people_.ahead_x[k] - people_.vx[k]) / s.relaxation_time + fx;
    const double ay = (wish * people_.ahead_y[k] - people_.vy[k]) / s.relaxation_time + fy;
    const double vx = people_.vx[k] + step * ax, vy = people_.vy[k] + step * ay;
    const double speed = std::sqrt(vx * vx + vy * vy), top = desired * s.top_speed;
    double share = speed > 0.0 ? std::min(1.0, top / speed) : 0.0;
    share = distance < s.stop_radius ? 0.0 : share;
    people_.vx[k] = share * vx;
    people_.vy[k] = share * vy;
    people_.x[k] += people_.vx[k] * step;
    people_.y[k] += people_.vy[k] * step;
  }

  const Crowd& crowd_;
  std::vector<double> rows_;
  People people_;
  std::vector<std::int64_t> current_;
};

/// Simulates a crowd and fills `paths` [T, K, 2] in m.
inline void march(const Crowd& crowd, int frames, double* paths) {
  const int people = crowd.people, blocks = people < kLarge ? 1 : kBlocks;
  Walk walk(crowd);
  Pairs pairs(people);
  std::vector<Forces> forces(blocks, Forces(people));
  walk.record(paths);
  for (int n = 0; n < (frames - 1) * crowd.substeps; ++n) {
    walk.aim();
    for (int block = 0; block < blocks; ++block) {
      std::ranges::fill(forces[block].x, 0.0);
      std::ranges::fill(forces[block].y, 0.0);
      add_row_forces(walk.people(), block, blocks, crowd.walls, crowd.settings, pairs, forces[block]);
      for (int k = 0; block > 0 && k < people; ++k) {
        forces[0].x[k] += forces[block].x[k];
        forces[0].y[k] += forces[block].y[k];
      }
    }
    walk.move(forces[0]);
    if ((n + 1) % crowd.substeps == 0)
      walk.record(paths + static_cast<std::int64_t>((n + 1) / crowd.substeps) * people * 2);
  }
}

}  // namespace vbbench::social_force
