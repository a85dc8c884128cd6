// The ego-motion factor: by which of a few modes the camera moves, and how.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "../constants.hpp"
#include "elementary.hpp"
#include "walk.hpp"

namespace vbbench {

/// Motion modes. A vehicle drives straight on or in curves; a head follows its bearer's path with a lag, loosely, or
/// wanders.
enum Mode { kStand, kDrive, kCurve, kFollow, kLoose, kWander, kModes };

using Modes = std::array<double, kModes>;

/// What carries the camera, where it is given.
enum Carrier { kUnknownCarrier, kPerson, kVehicle, kRobot };

constexpr int kSpan = kReach + 1;         ///< poses of one step's residuals, the newest last
constexpr int kSpanUnknowns = 3 * kSpan;  ///< x, y, yaw of each
using PoseDual = Dual<kSpanUnknowns>;

/// The camera's motion into a frame (m, m, rad), in the axes of the mean of the two yaws.
template <class T>
struct Step {
  T forward, left, turn;
};

template <class T>
Step<T> step_between(const std::array<T, 3>& before, const std::array<T, 3>& now) {
  using elementary::cos;
  using elementary::sin;
  const T turn = wrap(now[2] - before[2]), heading = before[2] + 0.5 * turn;
  const T x = now[0] - before[0], y = now[1] - before[1], c = cos(heading), s = sin(heading);
  return {c * x + s * y, c * y - s * x, turn};
}

/// The motion modes of a step at frames of dt seconds.
struct EgoMotion {
  double dt = 0.4;
  Walk walk;
  /// Factors of the scales by which the camera's motion changes: forward, or anywhere of a pedestrian, left, turn;
  /// learned.
  std::array<double, 3> roughness{1.0, 1.0, 1.0};
  double spread = 1.0;             ///< factor of a pedestrian's innovations on those of `walk`; learned from the crowd
  std::array<double, 3> change{};  ///< m, m, rad: scales by which a vehicle's step changes
  double curve = 0.0;              ///< rad: the same of its turn in curves
  std::array<double, 2> slip{};    ///< m and rad in a frame: sideways motion and turn of a vehicle that drives straight
  std::array<double, 2> stand{};
  std::array<double, 2> lag{};   ///< how far a head follows within a frame, 0 to 1
  std::array<double, 3> head{};  ///< rad, Cauchy scales of a head that lags, is loose, wanders
  VelocityPrior pace;            ///< of a pedestrian
  double nu = 4.0, first = 1.6, slow = 0.12;
  double duration = 1.0;  ///< weight in one frame of a density that holds for seconds
  bool on_foot = false;   ///< whether a person carries the camera
  Modes start{};          ///< prior of the modes
  std::array<Modes, kModes> transition{};

  static EgoMotion of(const Constants& c, double dt, Carrier carrier) {
    EgoMotion e;
    e.dt = dt;
    e.walk = Walk::of(c, dt);
    for (int i = 0; i < 3; ++i) e.change[i] = c.drive[i] * dt * std::sqrt(dt);
    e.curve = c.curve * dt * std::sqrt(dt);
    e.slip = {c.slip[0] * dt, c.slip[1] * dt};
    e.stand = {std::min(c.stand[0], 0.5 * e.slip[0]), std::min(c.stand[1], 0.5 * e.slip[1])};
    for (int i = 0; i < 2; ++i) e.lag[i] = 1.0 - elementary::exp(-dt / c.head_lag[i]);
    e.head = {c.head_scale[0] * dt / 0.4, c.head_scale[1], c.head_scale[2] * dt / 0.4};
    e.nu = c.drive_nu;
    e.pace = VelocityPrior::of(c);
    e.first = c.drive_speed * dt;
    e.slow = 0.3 * dt;
    e.duration = dt / 0.4;
    const bool person = carrier == kUnknownCarrier || carrier == kPerson;
    const bool vehicle = carrier != kPerson;
    e.on_foot = !vehicle;
    e.start = {0.02, vehicle ? 0.19 : 0.04, 0.01, 0.0, 0.0, 0.0};  // a person's camera may be held still, or pushed
    if (person) e.start[kFollow] = 0.25, e.start[kLoose] = 0.4, e.start[kWander] = 0.28;
    double sum = 0.0;
    for (double p : e.start) sum += p;
    for (double& p : e.start) p /= sum;
    const double leave = 1.0 - elementary::exp(-dt / c.stay), rare = 1e-3 * leave;
    for (int from = 0; from < kModes; ++from) {
      for (int to = 0; to < kModes; ++to) {
        // each carrier stands at times, and vehicles turn
        const bool alike = from == kStand || to == kStand || (vehicular(from) && vehicular(to));
        e.transition[from][to] = from == to ? 1.0 : (alike ? leave : rare) * e.start[to];
      }
      double total = 0.0;
      for (double p : e.transition[from]) total += p;
      for (double& p : e.transition[from]) p /= total;
    }
    return e;
  }

  static constexpr int kNoChange = -1;

  /// Adds the `share` of a mode to the squares of the changes of the camera's motion, in units of their scales without
  /// `roughness`, and to how many of them boxes decide.
  void add_changes(int mode, const std::array<std::array<double, 3>, kSpan>& poses, int known,
                   const std::array<double, 3>& information, double share, std::array<double, 3>& squares,
                   std::array<double, 3>& count) const {
    if (mode == kStand || known < 3) return;
    const std::array<double, 3> s = scales(mode, known);
    residuals(mode, poses, known, [&](const double& r, double weight, double, int axis) {
      if (axis == kNoChange) return;
      const double decided = s[axis] * s[axis] * information[axis];
      squares[axis] += share * weight * r * r * roughness[axis] * roughness[axis];
      count[axis] += share * decided / (1.0 + decided);
    });
  }

  /// Probabilities of the modes a step later.
  Modes after(const Modes& now) const {
    Modes next{};
    for (int from = 0; from < kModes; ++from)
      for (int to = 0; to < kModes; ++to) next[to] += now[from] * transition[from][to];
    return next;
  }

  static bool vehicular(int mode) { return mode == kDrive || mode == kCurve; }
  static bool pedestrian(int mode) { return mode >= kFollow; }

  /// Residuals of the step into the last of `poses`, of which the last `known` ≥ 2 exist, under one mode:
  /// `add`(residual, weight, cost, axis along which the motion changes).
  template <class T, class Add>
  void residuals(int mode, const std::array<std::array<T, 3>, kSpan>& poses, int known, Add&& add) const {
    const auto& now = poses[kSpan - 1];
    const auto& before = poses[kSpan - 2];
    const Step<T> step = step_between(before, now);
    const auto gaussian = [&](const T& r, double sigma) {
      const double v = value_of(r);
      add(r, 1.0 / (sigma * sigma), 0.5 * v * v / (sigma * sigma), kNoChange);
    };
    const auto cauchy = [&](const T& r, double scale, double share, int axis) {
      const double gamma = roughness[axis] * scale, v = value_of(r), square = v * v / (gamma * gamma);
      add(r, 2.0 * share / (gamma * gamma * (1.0 + square)), share * elementary::log1p(square), axis);
    };
    if (mode == kStand) {
      gaussian(step.forward, stand[0]);
      gaussian(step.left, stand[0]);
      gaussian(step.turn, stand[1]);
      return;
    }
    if (vehicular(mode)) {
      if (known > 2) {
        const Step<T> last = step_between(poses[kSpan - 3], before);
        const T off[3] = {step.forward - last.forward, step.left - last.left, step.turn - last.turn};
        const std::array<double, 3> scale = scales(mode, known);
        for (int i = 0; i < 3; ++i) {
          const double scaled = value_of(off[i]) / scale[i];
          const Robust robust = student(scaled * scaled, nu, 1.0);
          add(off[i], robust.weight / (scale[i] * scale[i]), robust.cost, i);
        }
      } else {
        gaussian(step.forward, first);
      }
      cauchy(step.left, slip[0], 1.0, 1);
      if (mode == kDrive) cauchy(step.turn, slip[1], duration, 2);
      if (!on_foot) return;
    }
    // A person stands or walks, and hardly runs.
    const double speed = elementary::hypot(value_of(step.forward), value_of(step.left)) / dt;
    if (speed > pace.running) {
      using std::sqrt;
      const T x = now[0] - before[0], y = now[1] - before[1];
      const T faster = sqrt(x * x + y * y) - T(pace.running * dt);
      const double v = value_of(faster), sigma = pace.running_std * dt;
      add(faster, duration / (sigma * sigma), 0.5 * duration * v * v / (sigma * sigma), kNoChange);
    }
    if (pace.weight > 0.0) {
      using std::sqrt;
      const T x = T(1.0 / dt) * (now[0] - before[0]), y = T(1.0 / dt) * (now[1] - before[1]);
      const T pacing = sqrt(x * x + y * y + T(1e-8));
      const Pace usual = pace.at(value_of(pacing), 0.0, dt);
      add(pacing - T(pace.walking), usual.walk, -pace.weight * dt * elementary::log(usual.density), kNoChange);
      add(x, usual.stand, 0.0, kNoChange);
      add(y, usual.stand, 0.0, kNoChange);
    }
    if (vehicular(mode)) return;
    // A pedestrian walks as others do, and looks along the path or anywhere.
    if (known > 2) {
      std::array<double, kReach + 1> c;
      const double scale = roughness[0] * spread * walk.coefficients(known - 1, c);
      T ex(0.0), ey(0.0);
      for (int j = 0; j <= std::min(known - 1, kReach); ++j) {
        ex = ex + c[j] * poses[kSpan - 1 - j][0];
        ey = ey + c[j] * poses[kSpan - 1 - j][1];
      }
      const double square = (value_of(ex) * value_of(ex) + value_of(ey) * value_of(ey)) / (scale * scale);
      const Robust robust = student(square, walk.nu, 2.0);
      add(ex, robust.weight / (scale * scale), robust.cost, 0);
      add(ey, robust.weight / (scale * scale), 0.0, 0);
    } else {
      gaussian(step.forward, first);
      gaussian(step.left, first);
    }
    const double gamma = head[mode - kFollow];
    if (mode == kWander) {
      cauchy(step.turn, gamma, 1.0, 2);
    } else {
      using elementary::atan2;
      using elementary::cos;
      using elementary::sin;
      using std::sqrt;
      const T x = now[0] - before[0], y = now[1] - before[1], ca = cos(before[2]), sa = sin(before[2]);
      const T ahead = ca * x + sa * y, left = ca * y - sa * x, square = x * x + y * y;
      const double s4 = slow * slow * slow * slow;
      const T gain = lag[mode - kFollow] * (square * square) / (square * square + s4);
      const T turned = atan2(gain * left, (1.0 - gain) * sqrt(square + slow * slow) + gain * ahead);
      cauchy(wrap(wrap(now[2] - before[2]) - turned), gamma, 1.0, 2);
    }
  }

  /// Scales (forward, left, turn) in m, m and rad of a step under a mode, after `known` poses.
  std::array<double, 3> scales(int mode, int known) const {
    if (mode == kStand) return {stand[0], stand[0], stand[1]};
    const std::array<double, 3>& r = roughness;
    if (vehicular(mode))
      return {known > 2 ? r[0] * change[0] : first, r[1] * change[1], r[2] * (mode == kCurve ? curve : change[2])};
    std::array<double, kReach + 1> c;
    const double walked = known > 2 ? r[0] * spread * walk.coefficients(known - 1, c) : first;
    return {walked, walked, r[2] * head[mode - kFollow]};
  }

  /// −ln of the evidence of the step under every mode, by Laplace's approximation: residuals of scale s add ½ ln(1 + s²
  /// d) for each direction, d [3] being the `information` of the boxes. Where nobody is seen, d is 0 and no mode gains.
  Modes costs(const std::array<std::array<double, 3>, kSpan>& poses, int known,
              const std::array<double, 3>& information) const {
    Modes out{};
    for (int mode = 0; mode < kModes; ++mode) {
      double sum = 0.0;
      residuals(mode, poses, known, [&](const double&, double, double cost, int) { sum += cost; });
      const std::array<double, 3> s = scales(mode, known);
      for (int a = 0; a < 3; ++a) sum += 0.5 * elementary::log1p(s[a] * s[a] * information[a]);
      out[mode] = sum;
    }
    return out;
  }
};

/// Probability that a vehicle carries the camera and moves.
inline double driving(const Modes& modes) { return modes[kDrive] + modes[kCurve]; }

/// Weighs probabilities of the modes by what a step costs under each. Returns −ln of the evidence.
inline double weigh(Modes& modes, const Modes& costs) {
  double least = 1e300, sum = 0.0;
  for (int m = 0; m < kModes; ++m)
    if (modes[m] > 0.0) least = std::min(least, costs[m]);
  for (int m = 0; m < kModes; ++m) sum += modes[m] *= elementary::exp(least - costs[m]);
  for (double& p : modes) p /= sum;
  return least - elementary::log(sum);
}

/// Probabilities of the modes in every frame, from what each step costs under every mode: forward and backward as in a
/// hidden Markov model. `prior` is that of the first step. Returns −ln of the evidence.
inline double mode_posteriors(const EgoMotion& motion, const std::vector<Modes>& costs, const Modes& prior,
                              std::vector<Modes>& posterior) {
  const int n = static_cast<int>(costs.size());
  posterior.assign(n, prior);
  if (n == 0) return 0.0;
  std::vector<Modes> forward(n);
  double evidence = 0.0;
  for (int t = 0; t < n; ++t) {
    forward[t] = t > 0 ? motion.after(forward[t - 1]) : prior;
    evidence += weigh(forward[t], costs[t]);
  }
  Modes after;
  after.fill(1.0);
  for (int t = n - 1; t >= 0; --t) {
    double sum = 0.0;
    for (int m = 0; m < kModes; ++m) sum += posterior[t][m] = forward[t][m] * after[m];
    for (double& p : posterior[t]) p /= sum;
    if (t == 0) break;
    double least = 1e300;
    for (int m = 0; m < kModes; ++m) least = std::min(least, costs[t][m]);
    Modes next;
    next.fill(0.0);
    double top = 0.0;
    for (int from = 0; from < kModes; ++from) {
      for (int to = 0; to < kModes; ++to)
        next[from] += motion.transition[from][to] * elementary::exp(least - costs[t][to]) * after[to];
      top = std::max(top, next[from]);
    }
    for (int m = 0; m < kModes; ++m) after[m] = next[m] / top;
  }
  return evidence;
}

}  // namespace vbbench
