// Common parts of the forces: people as rows of numbers, parameters of the model, and vectorised functions.
//
// Exponential and arc tangent are made of additions and multiplications. Calls of the C library would keep loops
// scalar, and its last digits differ between machines. Polynomials are written in pairs of terms, which the processor
// computes at the same time.
#pragma once

#include <array>
#include <vector>

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

}  // namespace vbbench::social_force
