// Weighted least-squares fit of the observer's motion by Gauss–Newton steps; `pose_fit.py` and `heads.py` have the
// equations.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "elementary.hpp"
#include "layers.hpp"

namespace vbbench::former {

/// A point, velocity or direction on the ground: forward and left of the camera, a complex number.
struct Point {
  float x = 0.0f, y = 0.0f;
};
inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator*(Point a, Point b) { return {a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x}; }
inline Point operator*(Point a, float b) { return {a.x * b, a.y * b}; }
inline Point operator/(Point a, float b) { return {a.x / b, a.y / b}; }
inline Point conj(Point a) { return {a.x, -a.y}; }
inline Point direction(float angle) { return {elementary::cos(angle), elementary::sin(angle)}; }
inline float squared(Point a) { return a.x * a.x + a.y * a.y; }

/// How the observer moved since the last frame, in m and rad.
struct Motion {
  Point step;
  float turn = 0.0f;
};

/// The motion by odometry, with 1/variance of its three numbers; `sure` where it replaces the predicted motion.
struct Measured {
  Motion motion;
  std::array<float, 3> information{};
  float sure = 0.0f;
};

/// A person in the fit: predicted and measured place in m, and the ray towards it.
struct View {
  Point expected, seen, ray;
};

/// The observer's head: (1 − g) s, g/dt, and the probability that it follows the motion (`heads.py`).
struct Head {
  Point kept;
  float gain = 0.0f, share = 0.0f;
};

/// A person's weights along and across the ray in 1/m², and the offset in m.
struct PersonWeight {
  float along, across;
  Point offset;
};

struct Weighing {
  std::vector<PersonWeight> people;
  std::array<float, 3> inertia;
  Motion motion;
  bool heads = false;
  Head head;
};

namespace heads {

constexpr float kLag = 0.8f, kStanding = 0.3f, kFollowing = 0.005f, kLoose = 0.03f, kWandering = 0.4f,
                kMostOdds = 10.0f;
inline float gain(float dt) { return 1.0f - elementary::exp(dt * (-1.0f / kLag)); }
inline float facing(Point way) { return elementary::atan2(way.y, way.x + 1e-4f); }
inline float walks(Point way) {
  const float speed = square(squared(way));
  return speed / (speed + square(square(kStanding)));
}

inline Head before(Point smooth, float odds, float dt) {
  const float share = gain(dt), first_odds = elementary::log(1.0f / 3.0f);
  return {smooth * (1.0f - share), share / dt, sigmoid(odds + first_odds)};
}

/// The log odds after a frame that turned the head by `turn` rad/s.
inline float odds_after(float odds, Point smooth, float turn, float dt) {
  const float off = square(facing(smooth)), turned = square(turn * dt), wandering = kWandering * dt;
  const float others = kLoose / (square(kLoose) + off) + wandering / (square(wandering) + turned);
  const float evidence = elementary::log(2.0f * kFollowing / (square(kFollowing) + off) / others);
  return clip(odds + evidence * walks(smooth), -kMostOdds, kMostOdds);
}

}  // namespace heads

/// The upper half of JᵀwJ by rows, and Jᵀwe.
using Equations = std::array<float, 9>;

inline Equations head_equations(const Head& head, const Motion& motion) {
  const Point way = head.kept + motion.step * head.gain;
  const float off = motion.turn - heads::facing(way);
  const float weight = 2.0f * head.share * heads::walks(way) / (square(heads::kFollowing) + square(off));
  const float scale = head.gain / (squared(way) + 1e-4f);
  const float ahead = way.y * scale, left = -way.x * scale, wx = weight * ahead, wy = weight * left;
  return {wx * ahead, wx * left, wx, wy * left, wy, weight, wx * off, wy * off, weight * off};
}

/// λ and x⁰ combined with odometry.
inline void add_measured(std::array<float, 3>& inertia, Motion& motion, const Measured& measured) {
  if (measured.sure > 0.5f) {
    inertia = measured.information;
    motion = measured.motion;
    return;
  }
  const Point off = measured.motion.step - motion.step;
  const float turned = measured.motion.turn - motion.turn;
  std::array<float, 3> share{};
  for (int n = 0; n < 3; ++n) {
    inertia[n] += measured.information[n];
    share[n] = measured.information[n] / inertia[n];
  }
  motion.step = motion.step + Point{share[0] * off.x, share[1] * off.y};
  motion.turn += share[2] * turned;
}

/// A person's predicted place after the motion, and the residual along and across the ray, in m.
struct Seen {
  Point place, off;
};
inline Seen seen_after(const View& view, const Motion& motion, Point turned) {
  const Point place = (view.expected - motion.step) * turned;
  return {place, (view.seen - place) * conj(view.ray)};
}
inline Seen seen_after(const View& view, const Motion& motion) {
  return seen_after(view, motion, direction(-motion.turn));
}

/// The best motion with isotropic weights (Umeyama 1991, in the plane).
inline Motion align(const std::vector<View>& views, const Weighing& weighing) {
  const float own = weighing.inertia[0];
  const Motion& expected = weighing.motion;
  float total = 0.0f;
  Point middle, centre, turned;
  std::vector<float> weights;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const auto [along, across, offset] = weighing.people[k];
    weights.push_back(2.0f * along * across / (along + across + 1e-9f));
    total += weights[k];
    middle = middle + views[k].expected * weights[k];
    centre = centre + views[k].seen * weights[k];
  }
  total += own;
  middle = (middle + expected.step * own) / total;
  centre = centre / total;
  for (std::size_t k = 0; k < views.size(); ++k)
    turned = turned + (views[k].expected - middle) * weights[k] * conj(views[k].seen - centre);
  turned = turned - (expected.step - middle) * own * conj(centre);
  const Point way = turned * conj(direction(expected.turn)) + Point{weighing.inertia[2], 0.0f};
  const float turn = expected.turn + elementary::atan2(way.y, way.x);
  return {middle - centre * direction(turn), turn};
}

/// Σ over people of the equations.
inline Equations normal_equations(const std::vector<View>& views, const Weighing& weighing, const Motion& motion) {
  const Point turned = direction(-motion.turn);
  Equations sums{};
  for (std::size_t k = 0; k < views.size(); ++k) {
    const auto [wa, wc, offset] = weighing.people[k];
    const Seen seen = seen_after(views[k], motion, turned);
    const Point off = seen.off - offset, u = views[k].ray * conj(turned), swing = seen.place * conj(views[k].ray);
    const float along = -swing.y, across = swing.x;
    const float wax = wa * u.x, way = wa * u.y, wcx = wc * u.x, wcy = wc * u.y, wal = wa * along, wcr = wc * across;
    sums[0] += wax * u.x + wcy * u.y;
    sums[1] += wax * u.y - wcy * u.x;
    sums[2] += wax * along - wcy * across;
    sums[3] += way * u.y + wcx * u.x;
    sums[4] += way * along + wcx * across;
    sums[5] += wal * along + wcr * across;
    sums[6] += wax * off.x - wcy * off.y;
    sums[7] += way * off.x + wcx * off.y;
    sums[8] += wal * off.x + wcr * off.y;
  }
  return sums;
}

/// The solution of the equations, and the variances of its numbers.
inline Motion solved(const Equations& equations, std::array<float, 3>& variances) {
  const auto [a, b, c, d, e, f, gx, gy, gt] = equations;
  const float xx = d * f - e * e, xy = c * e - b * f, xt = b * e - c * d;
  const float yy = a * f - c * c, yt = b * c - a * e, tt = a * d - b * b;
  const float scale = 1.0f / (a * xx + b * xy + c * xt);
  variances = {xx * scale, yy * scale, tt * scale};
  return {{(xx * gx + xy * gy + xt * gt) * scale, (xy * gx + yy * gy + yt * gt) * scale},
          (xt * gx + yt * gy + tt * gt) * scale};
}

/// The motion after `times` Gauss–Newton steps, at least one, and the `variances` of its components, for which the
/// factor of the observer's head does not count.
inline Motion fit(const std::vector<View>& views, const Weighing& weighing, Motion motion, int times,
                  std::array<float, 3>& variances) {
  const auto& inertia = weighing.inertia;
  for (int step = 0; step < times; ++step) {
    Equations equations = normal_equations(views, weighing, motion);
    const Point drift = motion.step - weighing.motion.step;
    equations[0] += inertia[0];
    equations[3] += inertia[1];
    equations[5] += inertia[2];
    equations[6] += inertia[0] * drift.x;
    equations[7] += inertia[1] * drift.y;
    equations[8] += inertia[2] * (motion.turn - weighing.motion.turn);
    Motion back = solved(equations, variances);
    if (weighing.heads) {
      const Equations head = head_equations(weighing.head, motion);
      for (std::size_t n = 0; n < equations.size(); ++n) equations[n] += head[n];
      std::array<float, 3> of_heads{};
      back = solved(equations, of_heads);
    }
    motion = {motion.step - back.step, motion.turn - back.turn};
  }
  return motion;
}

}  // namespace vbbench::former
