// The box factor: column, height and foot of a person's box.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "../constants.hpp"
#include "elementary.hpp"

namespace vbbench {

/// Constants of a recording that all frames share: angles in rad, lengths in m. Each has a column of the reduced
/// system.
enum Global { kPitch, kRoll, kMount, kOffset, kEdge, kOdometryScale, kOdometryTurn, kGlobals };

constexpr int kBoxGlobals = 5;  ///< a box depends on the first five `Global`s

/// Parts of a person that the border of the picture, or another person, hides.
enum Cut { kFeetCut = 1, kHeadCut = 2, kSideCut = 4 };

/// A box as a camera of the nominal calibration sees it.
struct Box {
  double azimuth = 0.0;   ///< rad, clockwise from forward
  double foot = 0.0;      ///< slope down to the feet, m per m
  double length = 0.0;    ///< slope from head to feet
  double pixels = 0.0;    ///< box height
  double width = 0.0;     ///< rad along the row of one box height
  int cut = 0;            ///< sum of `Cut`
  double expected = 0.0;  ///< length as the last solution expects it: the scale of the foot's error
  bool hidden = false;    ///< whether another person hides the feet
  double cos = 1.0, sin = 0.0, log_length = 0.0;  ///< cos and sin of the azimuth, ln of the length

  /// The box of a row of `Input::boxes`; `cut` is a sum of `Cut`.
  static Box of(const double* row, int cut) {
    Box box{row[0], row[1], row[2], row[3], row[4], cut, row[2]};
    box.cos = elementary::cos(box.azimuth);
    box.sin = elementary::sin(box.azimuth);
    box.log_length = elementary::log(box.length);
    return box;
  }
};

/// Errors of boxes in column, height and foot: σ in box heights with a correlation time in s, white σ in px, and the
/// degrees of freedom. While σ and time are uncertain, an innovation has `excess` times the variance that they give.
struct BoxNoise {
  std::array<double, 3> share, time;
  double pixel, nu;
  std::array<double, 3> excess{1.0, 1.0, 1.0};
};

/// Unknowns of one box, in the order of a `Cue`'s gradient.
enum BoxUnknown { kX, kY, kLogHeight, kPoseX, kPoseY, kYaw, kSwayPitch, kSwayRoll, kBoxUnknowns };

/// Residual q of one cue, in box heights, with its gradient and standard deviation.
struct Cue {
  double q = 0.0;
  std::array<double, kBoxUnknowns> by{};
  std::array<double, kBoxGlobals> by_global{};
  double std = 1.0, correlated = 0.0;  ///< correlated: share of the variance that is correlated in time
  bool used = false;
};

constexpr double kNearest = 0.2;        ///< m, no person is nearer than this
constexpr double kCutTolerance = 0.03;  ///< of the log height, by which a cut box may be too tall
constexpr double kShownStd = 0.4;       ///< σ of −ln of the visible share of a person who is cut
constexpr double kSideFactor = 4.0;     ///< by which a column is less certain where the side is cut

/// State that one box depends on, and the person's place relative to the camera.
struct BoxState {
  double log_height;
  const double *pose, *sway, *global;  ///< x, y, yaw; pitch, roll; `Global`
  double dx, dy, square, r;            ///< m; square: r² in m²
  double rho, by_rho, log_rho;         ///< r − δ in m, at least `kNearest`; its derivative by r; its logarithm

  BoxState(double x, double y, double height, const double* camera, const double* calibration)
      : log_height(height), pose(camera), sway(camera + 3), global(calibration) {
    dx = x - pose[0];
    dy = y - pose[1];
    square = std::max(dx * dx + dy * dy, 1e-6);
    r = std::sqrt(square);
    const double raw = r - global[kEdge];
    rho = std::max(raw, kNearest);
    by_rho = raw > kNearest ? 1.0 : 0.0;
    log_rho = elementary::log(rho);
  }
};

/// The cues of a box: bearing q_u = (a − a')/w, height q_l = ln λ + ln(r − δ) − η, and foot
/// q_b = (s − h/(r − δ))/λ − c q_l, where c decorrelates the pixel noise that height and foot share. a, s, λ, w:
/// azimuth, foot, length and width of the box; η: log height; h: mount height; δ: near edge.
inline std::array<Cue, 3> box_cues(const Box& box, const BoxState& at, const BoxNoise& noise) {
  std::array<Cue, 3> cues;
  const double dx = at.dx, dy = at.dy, square = at.square, r = at.r, rho = at.rho, by_rho = at.by_rho;
  const double pitch = at.global[kPitch] + at.sway[0], roll = at.global[kRoll] + at.sway[1];
  const double ca = box.cos, sa = box.sin;
  const double lift = -pitch * ca + roll * sa;  // of the ray, rad
  const double length_by = 2.0 * box.foot - box.length;
  const double middle = box.foot - 0.5 * box.length;

  const double per_pixel = noise.pixel / box.pixels, pixel_square = per_pixel * per_pixel;
  const double length_variance = noise.share[1] * noise.share[1] + 2.0 * pixel_square;
  const double coupling = pixel_square / length_variance;

  Cue& u = cues[0];
  const double seen = box.azimuth - middle * (pitch * sa + roll * ca) - at.global[kOffset];
  u.q = wrap(at.pose[2] - elementary::atan2(dy, dx) - seen) / box.width;
  const double by_x = -dy / square / box.width, by_y = dx / square / box.width;  // of the bearing, counter-clockwise
  u.by[kX] = -by_x;
  u.by[kY] = -by_y;
  u.by[kPoseX] = by_x;
  u.by[kPoseY] = by_y;
  u.by[kYaw] = 1.0 / box.width;
  u.by[kSwayPitch] = u.by_global[kPitch] = middle * sa / box.width;
  u.by[kSwayRoll] = u.by_global[kRoll] = middle * ca / box.width;
  u.by_global[kOffset] = 1.0 / box.width;
  const double side = (box.cut & kSideCut ? kSideFactor : 1.0) * noise.share[0];
  const double u_correlated = side * side, u_variance = u_correlated + pixel_square;
  u.std = std::sqrt(u_variance);
  u.correlated = u_correlated / u_variance;
  u.used = true;

  Cue& l = cues[1];
  l.q = box.log_length + lift * length_by + at.log_rho - at.log_height;
  const double rx = dx / r, ry = dy / r, by_r = by_rho / rho;
  l.by[kX] = by_r * rx;
  l.by[kY] = by_r * ry;
  l.by[kPoseX] = -by_r * rx;
  l.by[kPoseY] = -by_r * ry;
  l.by[kLogHeight] = -1.0;
  l.by_global[kEdge] = -by_r;
  l.by[kSwayPitch] = l.by_global[kPitch] = -ca * length_by;
  l.by[kSwayRoll] = l.by_global[kRoll] = sa * length_by;
  l.std = std::sqrt(length_variance);
  l.correlated = noise.share[1] * noise.share[1] / length_variance;
  l.used = true;

  // The foot, or the head where the feet are hidden: the end of the box that shows where it stands.
  Cue& b = cues[2];
  const bool feet = !(box.cut & kFeetCut || box.hidden), head = !(box.cut & kHeadCut);
  const double slope = feet ? box.foot : box.foot - box.length;
  const double height = feet ? 0.0 : elementary::exp(at.log_height), down = at.global[kMount] - height;
  const double scale = 1.0 / box.expected, by_distance = scale * down / (rho * rho) * by_rho;
  b.q = (slope + lift * (1.0 + slope * slope) - down / rho) * scale;
  b.by[kX] = by_distance * rx;
  b.by[kY] = by_distance * ry;
  b.by[kPoseX] = -by_distance * rx;
  b.by[kPoseY] = -by_distance * ry;
  b.by_global[kEdge] = -by_distance;
  b.by[kSwayPitch] = b.by_global[kPitch] = -ca * (1.0 + slope * slope) * scale;
  b.by[kSwayRoll] = b.by_global[kRoll] = sa * (1.0 + slope * slope) * scale;
  b.by_global[kMount] = -scale / rho;
  if (!feet) b.by[kLogHeight] = height / rho * scale;
  b.used = feet || head;
  double variance = noise.share[2] * noise.share[2] + pixel_square;
  if (feet && head) {
    for (int i = 0; i < kBoxUnknowns; ++i) b.by[i] -= coupling * l.by[i];
    for (int i = 0; i < kBoxGlobals; ++i) b.by_global[i] -= coupling * l.by_global[i];
    b.q -= coupling * l.q;
    variance -= coupling * pixel_square;
  } else {  // a cut box shows a share of its person, and no more than all
    l.std = l.q > 0.0 ? kCutTolerance : kShownStd;
    l.correlated = 0.0;
  }
  b.std = std::sqrt(variance);
  b.correlated = std::min(1.0, noise.share[2] * noise.share[2] / variance);
  return cues;
}

inline double square(double x) { return x * x; }

/// Cost and weight of a whitened residual under a Student-t law, of its `square` and number of `dimensions`.
struct Robust {
  double cost, weight;
};
inline Robust student(double square, double nu, double dimensions) {
  const double scaled = square / nu;
  return {0.5 * (nu + dimensions) * elementary::log1p(scaled), (nu + dimensions) / (nu * (1.0 + scaled))};
}

}  // namespace vbbench
